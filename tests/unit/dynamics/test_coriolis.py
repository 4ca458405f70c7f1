"""Coriolis matrix and forces of gravity on random machines: trees with every joint, armature, rotors, couplings."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import bias, coriolis_matrix, float_state, gravity_forces, mass_matrix
from freebody.dynamics.kinematics import state_along
from freebody.scalar.series import Series
from freebody.testing import random_state
from sampled import sampled
from unloaded_machines import coupled, unloaded

EPS = np.finfo(float).eps
EXACT = 2**12 * EPS  # of the largest term; recursions over at most five bodies, differentiated once


@pytest.fixture(params=[*range(12), "coupled"], name="case")
def case_(request):
    s = coupled() if request.param == "coupled" else unloaded(request.param)
    model = fb.assemble(s)
    q, u = random_state(model, np.random.default_rng(7))[:2]
    return s, model, q, u


def close(a, b, scale):
    assert np.abs(np.array(a, float) - np.array(b, float)).max() <= EXACT * scale


def test_coriolis_and_gravity_make_the_bias(case):
    _, model, q, u = case
    state = float_state(model, q, u)
    C, g = np.array(coriolis_matrix(model, state), float), np.array(gravity_forces(model, state), float)
    h = np.array(bias(model, state), float)
    close(C @ u + g, h, 1 + np.abs(C).max() * np.abs(u).max() * len(u) + np.abs(h).max())
    close(g, bias(model, float_state(model, q, np.zeros(model.n_u))), 1 + np.abs(g).max())


def test_the_rate_of_the_mass_matrix_less_twice_coriolis_is_skew(case):
    _, model, q, u = case
    if any(link.kind == "free" and len(set(link.armature[3:])) > 1 for link in model.links):
        pytest.skip("unequal armature of the slides of a free joint works as it turns")
    state = float_state(model, q, u)
    along = mass_matrix(model, state_along(model, state, state.u, 0, 1))
    rate = np.array(
        [[float(x.derivative(1)) if isinstance(x, Series) else 0.0 for x in row] for row in along]
    )
    C = np.array(coriolis_matrix(model, state), float)
    difference = rate - 2 * C
    close(difference, -difference.T, 1 + np.abs(C).max())


def test_it_is_linear_in_the_speeds(case):
    _, model, q, u = case
    one, three = (
        np.array(coriolis_matrix(model, float_state(model, q, [k * x for x in u])), float) for k in (1, 3)
    )
    close(three, 3 * one, 1 + np.abs(three).max())


@pytest.mark.parametrize("case", sampled([*range(12), "coupled"], 4), indirect=True)
def test_compiled(case):
    s, model, q, u = case
    program = fb.compile(s)
    state = float_state(model, q, u)
    C, g = np.array(coriolis_matrix(model, state), float), np.array(gravity_forces(model, state), float)
    close(program.coriolis_matrix(q, u), C, 1 + np.abs(C).max())
    close(program.gravity_forces(q), g, 1 + np.abs(g).max())


def test_two_links_as_in_the_books():
    """Siciliano et al., Robotics (2009), §7.3.2: C of two links has h = -m₂ a₁ l₂ sin θ₂ in three of its places."""
    s = fb.System("two links")
    a, l, m = 1.5, 0.4, 2.0  # noqa: E741
    first = s.body("first", fb.MassProperties(1, (0.5, 0, 0), np.diag([0.1, 0.1, 0.1])))
    second = s.body("second", fb.MassProperties(m, (l, 0, 0), np.diag([0.1, 0.1, 0.1])))
    s.hinge("one", s.ground, first, axis="z", coordinate="q1")
    s.hinge("two", first, second, at=(a, 0, 0), axis="z", coordinate="q2")
    h = -m * a * l * np.sin(0.7)
    expected = np.array([[h * 3.0, h * (2.0 + 3.0)], [-h * 2.0, 0]])
    found = fb.compile(s).coriolis_matrix([0.2, 0.7], [2.0, 3.0])
    assert np.abs(found - expected).max() < 1e-14
