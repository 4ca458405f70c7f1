"""Entries of kernels for Python: the bits of the general way, and its refusals."""

from __future__ import annotations

import gc
import inspect
import pickle
import sys
import weakref

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ModelError
from freebody.program import entry
from freebody.testing import random_system


@pytest.fixture(scope="module")
def program():
    """A program whose entries were made: the second plain call of a product makes one."""
    model = fb.assemble(random_system(5, bodies=3))
    program = fb.compile(model)
    q, u = np.array(model.rest[: model.n_q], dtype=float), np.arange(model.n_u) / 7
    for _ in range(2):
        program.inverse_dynamics(q, u, u)
        program.mass_matrix(q)
    names = {"inverse_dynamics", "mass_matrix"}
    assert names & set(vars(program)) == (names if entry.USABLE else set())
    return program, q, u


def test_same_bits_and_new_arrays(program):
    program, q, u = program
    tau, M = program.inverse_dynamics(q, u, u, 0.5), program.mass_matrix(q)
    assert np.array_equal(tau, program.inverse_dynamics([*q], [*u], [*u], 0.5))
    assert np.array_equal(M, program.mass_matrix([*q])) and M.shape == (u.size, u.size)
    assert tau.flags.owndata and tau.flags.writeable and program.mass_matrix(q) is not M


class Marked(np.ndarray):
    """Arrays of another class."""


def test_what_is_not_plain_goes_the_general_way(program):
    program, q, u = program
    tau = program.inverse_dynamics(q, u, u)
    for other in ([*u], u.view(Marked), np.repeat(u, 2)[::2], u.astype(">f8")):
        assert np.array_equal(program.inverse_dynamics(q, other, u), tau)
    assert np.array_equal(program.inverse_dynamics(q, u, u, 0), tau)
    assert np.array_equal(program.inverse_dynamics(q, u, udot=u), tau)
    rows = program.inverse_dynamics(np.array([q, q]), u, u)
    assert rows.shape == (2, u.size)
    with pytest.raises(ModelError, match=r"Expected u of shape \(\d+,\) or \(N, \d+\)"):
        program.inverse_dynamics(q, u[1:], u)
    with pytest.raises(TypeError, match="udot"):
        program.inverse_dynamics(q, u)
    with pytest.raises(ModelError, match="Expected real numbers for u"):
        program.inverse_dynamics(q, None, u)
    with pytest.raises(ModelError, match="Expected real numbers for q"):
        program.inverse_dynamics([10**400] * len(q), u, u)


@pytest.mark.skipif(not entry.USABLE, reason="no entries in this interpreter")
def test_references_are_counted_and_code_lives_as_long_as_its_entry(program):
    program, q, u = program
    call = fb.compile(program.model)
    for _ in range(2):
        expected = call.mass_matrix(q)
    made, alive = call.mass_matrix, weakref.ref(call)
    del call
    gc.collect()
    assert np.array_equal(made(q), expected)
    before = sys.getrefcount(q), sys.getrefcount(np.dtype(float))
    for _ in range(100):
        made(q)
    assert (sys.getrefcount(q), sys.getrefcount(np.dtype(float))) == before
    for _ in range(100):
        assert np.array_equal(made(q, 0), expected) and np.array_equal(made([*q], t=0.0), expected)
        with pytest.raises(TypeError):
            made()
    assert sys.getrefcount(q) == before[0]
    del made
    gc.collect()
    assert alive() is None


@pytest.mark.skipif(not entry.USABLE, reason="no entries in this interpreter")
def test_entries_look_and_travel_like_methods(program):
    program, q, u = program
    for _ in range(2):  # a batch may have been compiled in between
        program.inverse_dynamics(q, u, u)
    made = program.inverse_dynamics
    assert made.__name__ == "inverse_dynamics" and made.__doc__ == type(program).inverse_dynamics.__doc__
    assert str(inspect.signature(made)) == "(q, u, udot, t=0.0, *, actuators=None, values=None, **named)"
    other = pickle.loads(pickle.dumps(made))
    assert np.array_equal(other(q, u, u), made(q, u, u))


def test_none_where_there_is_nothing_to_enter(program, monkeypatch):
    program, q, _ = program
    kernel, c = program.kernel("mass_matrix"), program.constants("mass_matrix")
    method = program.mass_matrix
    assert entry.python_entry(method, kernel, c, [q.size], ()) is None  # a number is no array
    monkeypatch.setattr(entry, "LONGEST", 0)
    assert entry.python_entry(method, kernel, c, [q.size], (1,)) is None
