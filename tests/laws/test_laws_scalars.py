"""The same algorithms give the same numbers on floats, on exact polynomials and on recorded programs."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import (
    bias,
    coordinate_rates,
    float_state,
    forward_dynamics,
    inverse_dynamics,
    jacobian,
    kinetic_energy,
    mass_matrix,
    mechanical_power,
    momentum,
    polynomial_state,
    poses,
    potential_energy,
    reactions,
    traced_state,
)
from freebody.dynamics.kinematics import point_acceleration, point_velocity
from freebody.scalar.polynomial import Ring
from freebody.scalar.trace import Tape, Traced
from freebody.testing import JOINTS, polynomial_value, random_state, random_system, state_values

EXACT = 2**10 * np.finfo(float).eps
T = 0.3


def products(system, model, state, udot):
    """Everything that the dynamics computes, flat, but what divides by inertias."""
    body = list(system.bodies.values())[-1]
    point = body.point(1, -1, 2)
    result = [
        kinetic_energy(model, state),
        potential_energy(model, state),
        mechanical_power(model, state, udot),
    ]
    result += coordinate_rates(model, state)
    result += bias(model, state)
    result += inverse_dynamics(model, state, udot)
    result += [x for row in mass_matrix(model, state) for x in row]
    result += point_velocity(model, state, point)
    result += point_acceleration(model, state, point, udot)
    result += [x for row in jacobian(model, state, point) for x in row]
    for force, moment in reactions(model, state, udot).values():
        result += [*force, *moment]
    result += momentum(model, state).linear + momentum(model, state, (1, 2, 3)).angular
    for posture in poses(model, state).values():
        result += [*posture.position, *(x for row in posture.rotation for x in row)]
    return result


def floats_of(system, seed):
    model = fb.assemble(system)
    q, u = random_state(model, seed)
    udot = [float(x) for x in np.random.default_rng(seed).normal(size=model.n_u)]
    return model, q, u, udot


def close(a, b, tolerance):
    a, b = np.asarray(a, float), np.asarray(b, float)
    assert np.abs(a - b).max(initial=0) <= tolerance * max(1, np.abs(a).max(initial=0))


@pytest.mark.parametrize("seed", range(8))
def test_a_recorded_program_gives_the_numbers_of_floats(seed):
    system = random_system(seed, 5, driven=seed % 2 == 0, armature=seed % 3 == 1)
    model, q, u, udot = floats_of(system, seed)
    tape = Tape()
    traced = traced_state(model, tape)
    accelerations = [tape.input(f"{name}'") for name in model.speed_names]
    recorded = products(system, model, traced, accelerations)
    solved = forward_dynamics(model, traced)
    assert any(isinstance(x, Traced) for x in recorded)
    values = {
        "t": T,
        **dict(zip(model.coordinate_names, q, strict=True)),
        **dict(zip(model.speed_names, u, strict=True)),
    }
    values.update({f"{name}'": value for name, value in zip(model.speed_names, udot, strict=True)})
    state = float_state(model, q, u, T)
    close(tape.evaluate(recorded, values), products(system, model, state, udot), EXACT)
    M = np.array(mass_matrix(model, state), float)
    condition = np.linalg.cond(M) if len(M) else 1
    close(tape.evaluate(solved, values), forward_dynamics(model, state), EXACT * condition)


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=pytest.mark.slow) if kind == "gimbal" else kind for kind in JOINTS]
)
def test_exact_symbols_give_the_numbers_of_floats(kind):
    bodies = 1 if kind in ("free", "ball", "gimbal") else 2
    for seed in (1, 2):
        system = random_system(seed, bodies, [kind], small=True, driven=seed == 2)
        model, q, u, udot = floats_of(system, seed)
        ring = Ring()
        exact = polynomial_state(model, ring)
        accelerations = [ring.generator(s.acceleration, "acceleration") for s in model.speeds]
        values = state_values(model, q, u, T)
        values.update((s.acceleration, x) for s, x in zip(model.speeds, udot, strict=True))
        symbols = products(system, model, exact, accelerations)
        numbers = products(system, model, float_state(model, q, u, T), udot)
        # the terms of an expanded form are larger than their sum; the unit norm holds to round-off only
        close([polynomial_value(x, values, 60) for x in symbols], numbers, 2**6 * EXACT)
