"""Laws of motion on random machines, simulated.

Tolerances: a law that the exact motion obeys is broken by the errors of the steps, at most tolerance x (1 + size of
the state) each; the law multiplies them by its sensitivity. SLACK covers that sensitivity for the machines here.
"""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state
from freebody.dynamics.momentum import mass_centre, momentum
from freebody.space.mass import MassProperties
from freebody.testing import random_inertia, random_state, random_system

TOLERANCE = 1e-10
SLACK = 30


def start_of(s, seed):
    """A model and a random start by name."""
    model = fb.assemble(s)
    q, u = random_state(model, seed)
    names = [*model.coordinate_names, *model.speed_names]
    return model, dict(zip(names, [*q, *u], strict=True))


def floating_chain(seed, links=3):
    """A free body that carries others on hinges, ball joints and sliders, with springs and dampers between them."""
    rng = np.random.default_rng(seed)
    s = fb.System(f"floating {seed}")

    def body(name):
        center = tuple(float(x) for x in rng.normal(size=3) / 4)
        return s.body(name, MassProperties(float(rng.uniform(0.5, 2)), center, random_inertia(rng)))

    parent = body("b0")
    s.free("air", s.ground, parent)
    for i in range(1, links + 1):
        child = body(f"b{i}")
        at = tuple(float(x) for x in rng.normal(size=3) / 3)
        kind = ("hinge", "ball", "slider")[int(rng.integers(3))]
        given = {} if kind == "ball" else {"axis": "xyz"[int(rng.integers(3))]}
        joint = getattr(s, kind)(f"j{i}", parent, child, at=at, **given)
        if kind != "ball":
            s.spring(f"k{i}", joint, stiffness=3)
            s.damper(f"c{i}", joint, damping=0.2)
        parent = child
    return s


def momenta(motion, every):
    """p, H about the ground's origin, and the mass centre, at some of the output times."""
    model = motion.kernels.model
    result = []
    for k in range(0, len(motion), every):
        y = motion.states[k]
        state = float_state(
            model, y[: model.n_q], y[model.n_q : model.n_q + model.n_u], motion.t[k], motion.values
        )
        found = momentum(model, state)
        result.append([*found.linear, *found.angular, *mass_centre(model, state)[1]])
    return np.array(result)


@pytest.mark.parametrize("seed", range(6))
def test_energy_ledger_balances(seed):
    """T + V = T₀ + V₀ + W with springs, dampers, forces of time and, on some, a driven joint."""
    s = random_system(seed, bodies=3, driven=seed % 2 == 1)
    _, initial = start_of(s, seed)
    motion = fb.simulate(s, 2, initial=initial, tolerance=TOLERANCE)
    assert motion.kernels.works
    size = max(
        abs(motion.energy.kinetic).max(), abs(motion.energy.potential).max(), abs(motion.energy.work).max()
    )
    assert abs(motion.energy.work[-1]) > 1e-3 * size  # the loads do something
    assert abs(motion.energy.residual).max() < SLACK * TOLERANCE * motion.steps**0.5 * (1 + size)


@pytest.mark.parametrize("seed", range(4))
def test_energy_is_kept_without_loads(seed):
    s = random_system(seed, bodies=4, loads=False, armature=True)
    _, initial = start_of(s, seed)
    motion = fb.simulate(s, 3, initial=initial, tolerance=TOLERANCE)
    assert not motion.kernels.works
    assert motion.energy.relative_residual < SLACK * TOLERANCE * motion.steps**0.5


@pytest.mark.parametrize("seed", range(4))
def test_momenta_of_a_floating_machine_are_kept(seed):
    """p and H are constant, and the mass centre moves uniformly, though dampers take energy."""
    s = floating_chain(seed)
    _, initial = start_of(s, seed)
    motion = fb.simulate(s, 3, initial=initial, tolerance=TOLERANCE)
    found = momenta(motion, every=25)
    p, centre = found[:, :6], found[:, 6:]
    bound = SLACK * TOLERANCE * motion.steps**0.5 * (1 + abs(p).max())
    assert np.ptp(p, axis=0).max() < bound
    mass = sum(float(body.mass_properties.mass) for body in s.bodies.values())
    t = motion.t[::25]
    assert abs(centre - centre[0] - np.outer(t, p[0, :3] / mass)).max() < bound * (1 + t[-1])


@pytest.mark.parametrize("seed", range(3))
def test_conservative_motion_runs_backwards_to_its_start(seed):
    s = random_system(seed, bodies=3, loads=False)
    _, initial = start_of(s, seed)
    there = fb.simulate(s, 1.5, initial=initial, tolerance=1e-12)
    back = fb.simulate(s, 0, start=1.5, initial=dict(there.at(1.5)), tolerance=1e-12)
    first = np.array([initial[name] for name in there.names])
    last = np.array([back.at(0)[name] for name in back.names])
    assert abs(last - first).max() < 1e-9 * (1 + abs(there.states).max())


@pytest.mark.parametrize("seed", range(3))
def test_reaction_on_the_root_moves_the_mass_centre(seed):
    """Σ m g + reaction of the ground = dp/dt, by central differences of the momentum."""
    s = random_system(seed, bodies=3, loads=False, joints=("hinge", "universal", "gimbal"), branching=False)
    model, initial = start_of(s, seed)
    t, h = 0.7, 1e-3
    times = t + h * np.array([-2, -1, 0, 1, 2])
    motion = fb.simulate(s, 1, initial=initial, tolerance=1e-13, times=times)
    p = momenta(motion, every=1)[:, :3]
    rate = (p[0] - 8 * p[1] + 8 * p[3] - p[4]) / (12 * h)
    mass = sum(float(body.mass_properties.mass) for body in s.bodies.values())
    force = motion.reactions["j0"].force[2] + mass * np.array([float(g) for g in s.gravity])
    assert model.joints["j0"].parent == "ground"
    assert force == pytest.approx(rate, abs=1e-7 * (1 + abs(p).max()))


def test_steady_precession_of_a_gyroscope_keeps_its_angle():
    """(I_ζ Ω - (I_ξ - I_ζ) ψ' cos θ) ψ' = m g L for the slow rate: chapter 6, section 6.9."""
    m, R, L, g, spin, theta = 1.2, 0.06, 0.1, 9.81, 300.0, np.pi / 3
    axial, transverse = m * R**2 / 2, m * R**2 / 4 + m * L**2
    s = fb.System("gyroscope")
    s.gravity = (0, 0, -g)
    rotor = s.body("rotor", fb.disk(m, R, axis="z"))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis="ZXZ", coordinate=("psi", "theta", "phi"))
    # axial ω_ζ ψ' sin θ - transverse ψ'² sin θ cos θ = m g L sin θ
    slow = min(np.roots([transverse * np.cos(theta), -axial * spin, m * g * L]).real)
    initial = {"theta": theta, "psi'": slow, "phi'": spin - slow * np.cos(theta)}
    motion = fb.simulate(s, 10, initial=initial, tolerance=TOLERANCE)
    assert abs(motion["theta"] - theta).max() < 1e-9
    assert motion["psi'"] == pytest.approx(slow, rel=1e-7)
    assert motion.energy.relative_residual < 1e-9
    vertical = (transverse * np.sin(motion["theta"]) ** 2) * motion["psi'"] + axial * np.cos(
        motion["theta"]
    ) * (motion["phi'"] + motion["psi'"] * np.cos(motion["theta"]))
    assert vertical == pytest.approx(vertical[0], rel=1e-9)
