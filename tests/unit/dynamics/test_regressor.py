"""Forces are linear in the inertia of the bodies, on random machines: trees with every joint, couplings, drives."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state, inverse_dynamics
from freebody.dynamics.regressor import inertial_parameters, parameter_names, regressor
from freebody.testing import random_state
from unloaded_machines import coupled, unloaded

EXACT = 2**12 * np.finfo(float).eps  # of the sum of the terms; recursions over at most five bodies


def bare(model):
    """The model without armature and rotors, whose forces are no part of Y."""
    from dataclasses import replace

    links = tuple(replace(link, armature=(), rotor=(0, 0, 0)) for link in model.links)
    return replace(model, links=links)


@pytest.mark.parametrize("case", [*range(12), "coupled"])
def test_forces_are_the_regressor_times_the_parameters(case):
    model = bare(fb.assemble(coupled() if case == "coupled" else unloaded(case)))
    q, u = random_state(model, 7)
    udot = [float(x) for x in np.random.default_rng(3).normal(size=model.n_u)]
    state = float_state(model, q, u)
    Y, theta = (
        np.array(regressor(model, state, udot), float),
        np.array(inertial_parameters(model, state), float),
    )
    assert Y.shape == (model.n_u, len(parameter_names(model)))
    difference = Y @ theta - np.array(inverse_dynamics(model, state, udot), float)
    assert np.abs(difference).max() <= EXACT * (1 + (np.abs(Y) @ np.abs(theta)).max())
