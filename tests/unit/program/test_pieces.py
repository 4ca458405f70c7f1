"""Functions that are cut into pieces."""

from __future__ import annotations

import numpy as np

from freebody.motion.ode.dense_output import observe
from freebody.program.kernels import compile_tape
from freebody.scalar.trace import Tape


def test_pieces_that_leave_nothing_to_each_other():
    """Thousands of gaps, each of its own two coordinates: no value crosses a cut."""
    tape, n = Tape(), 2000
    q = [tape.input(f"q{i}") for i in range(2 * n)]
    gaps = [(a - b) * (a - b) for a, b in zip(q[::2], q[1::2], strict=True)]
    compiled = compile_tape(tape, {"gap": gaps}, tape.input("t"), q, [])
    states = np.random.default_rng(0).normal(size=(3, 2 * n))
    got = observe(compiled["gap"].address, n, np.zeros(3), states, np.zeros(1))
    assert np.array_equal(got, (states[:, ::2] - states[:, 1::2]) ** 2)
