"""Identification: exact from exact data, honest errors from noise, refusals."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics.conditions.constrained import closed_coordinates
from freebody.errors import ModelError


def arm():
    s = fb.System("arm")
    s.parameters(L=0.4, c=0.2, m=1.5)
    s.gravity = (0, 0, -9.81)
    upper = s.body(
        "upper", fb.MassProperties(2, (0.1, 0.02, 0), ((0.1, 0, 0), (0, 0.2, 0.01), (0, 0.01, 0.15)))
    )
    fore = s.body("fore", fb.MassProperties("m", (0.2, 0, 0.03), ((0.05, 0, 0), (0, 0.06, 0), (0, 0, 0.07))))
    shoulder = s.hinge("shoulder", s.ground, upper, axis="y")
    s.hinge("elbow", upper, fore, axis="z", at=("L", 0, 0), rotor=fb.Rotor(1e-4, ratio=50))
    s.damper("friction", shoulder, damping="c")
    return s


def measured(s, count=200, noise=0.0):
    rng = np.random.default_rng(4)
    q, u, udot = rng.uniform(-2, 2, (3, count, 2))
    tau = fb.compile(s).inverse_dynamics(q, u, udot)
    return q, u, udot, tau + noise * rng.normal(size=tau.shape) * [1, 3]


def test_exact_data_give_the_parameters():
    s = arm()
    found = fb.identify(s, *measured(s), unknowns=["c"])
    theta = np.array([*fb.compile(s).inertial_parameters().values()])
    expected = [*found.base.matrix() @ theta, 0.2]
    assert [*found.values] == [*found.base.names, "c"]
    assert np.abs(np.array([*found.values.values()]) - expected).max() < 1e-13 * found.condition


def test_noise_gives_errors_that_hold():
    """χ² of the errors of n unknowns: mean n, variance 2 n."""
    s = arm()
    found = fb.identify(s, *measured(s, 2000, 0.1), unknowns=["c"])
    theta = np.array([*fb.compile(s).inertial_parameters().values()])
    gap = np.array([*found.values.values()]) - [*found.base.matrix() @ theta, 0.2]
    n = len(gap)
    assert gap @ np.linalg.solve(found.covariance, gap) < n + 5 * np.sqrt(2 * n)
    assert found.sigma == pytest.approx({"shoulder'": 0.1, "elbow'": 0.3}, rel=0.1)
    assert "±" in repr(found) and "condition" in repr(found)


def test_what_cannot_be_found_is_refused():
    s = arm()
    q, u, udot, tau = measured(s)
    with pytest.raises(ModelError, match=r"but in these states .*fore.* cannot be distinguished"):
        fb.identify(s, 0 * q, 0 * u, udot, tau)
    with pytest.raises(ModelError, match="Expected coefficients of loads as unknowns, got m"):
        fb.identify(s, q, u, udot, tau, unknowns=["m"])
    with pytest.raises(ModelError, match="Unknown parameter 'd'"):
        fb.identify(s, q, u, udot, tau, unknowns=["d"])
    with pytest.raises(ModelError, match=r"Expected forces of shape \(200, 2\), got \(200, 1\)"):
        fb.identify(s, q, u, udot, tau[:, :1])
    with pytest.raises(ModelError, match="Expected finite numbers in u, got nan in row 3"):
        fb.identify(s, q, np.where(np.arange(200)[:, None] == 3, np.nan, u), udot, tau)
    with pytest.raises(ModelError, match=r"Expected more than \d+ measured forces"):
        fb.identify(s, q[:2], u[:2], udot[:2], tau[:2])


def test_a_load_that_is_not_linear_in_its_coefficient_is_refused():
    s = arm()
    s.parameters(k=1.0)
    s.spring("odd", s.joints["elbow"], stiffness="k**2")
    with pytest.raises(ModelError, match=r"Expected forces that are linear in 'k'.*fb\.fit"):
        fb.identify(s, *measured(s), unknowns=["k"])


# -- feasible inertia ---------------------------------------------------------------------------------------


def pseudo_inertia(body):
    """∫ (r, 1) (r, 1)ᵀ dm about the mass centre."""
    inertia = np.array(body.inertia, float)
    P = np.zeros((4, 4))
    P[:3, :3], P[3, 3] = np.trace(inertia) / 2 * np.eye(3) - inertia, float(body.mass)
    return P


def true_base(s, found):
    return found.base.matrix() @ [*fb.compile(s).inertial_parameters().values()]


def other_masses(s):
    """The same machine, described by rough masses, as one knows them before it is measured."""
    rough = arm()
    for body in rough.bodies.values():
        object.__setattr__(body, "mass_properties", fb.sphere(1, 0.3))
    return rough


def test_feasible_inertia_from_exact_data_is_that_of_the_forces():
    s = arm()
    free, found = (
        fb.identify(other_masses(s), *measured(s), unknowns=["c"], feasible=x) for x in (False, True)
    )
    expected = [*true_base(s, found), 0.2]
    assert np.abs(np.array([*found.values.values()]) - expected).max() < 1e-12 * found.condition
    for body in found.bodies.values():
        assert np.linalg.eigvalsh(pseudo_inertia(body)).min() > 0
    # what the forces need are the bodies that are returned
    again = arm()
    for name, body in again.bodies.items():
        object.__setattr__(body, "mass_properties", found.bodies[name])
    q, u, udot, tau = measured(s)
    assert (
        np.abs(fb.compile(again).inverse_dynamics(q, u, udot) - tau).max()
        < 1e-12 * found.condition * np.abs(tau).max()
    )
    assert free.bodies == {}


def test_what_the_forces_leave_open_stays_as_described():
    """The divergence of the description from itself is 0: with its own forces it is the answer."""
    s = arm()
    found = fb.identify(s, *measured(s), feasible=True)
    for name, body in found.bodies.items():
        own = s.bodies[name].mass_properties.at({"m": 1.5})
        assert float(body.mass) == pytest.approx(float(own.mass), rel=1e-9)
        assert np.allclose(np.array(body.inertia, float), np.array(own.inertia, float), atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_noise_gives_masses_that_bodies_can_have(seed):
    s = arm()
    q, u, udot, tau = measured(s, 12)
    tau = tau + np.random.default_rng(seed).normal(scale=20, size=tau.shape)
    free, found = (fb.identify(s, q, u, udot, tau, feasible=x) for x in (False, True))
    assert min(free.values["upper.Iyy"], free.values["fore.Izz"]) < 0 or seed  # one of them is impossible
    for body in found.bodies.values():
        assert np.linalg.eigvalsh(pseudo_inertia(body)).min() > 0
    cost = [(x.residuals**2 / np.array([*free.sigma.values()]) ** 2).sum() for x in (free, found)]
    assert cost[1] > cost[0]


def test_a_point_mass_is_no_start_of_feasible_inertia():
    s = fb.System("pendulum")
    s.gravity = (0, -9.81, 0)
    s.hinge("pin", s.ground, s.body("bob", fb.particle(1)), to=(0, 1, 0))
    q, u, udot = np.random.default_rng(0).uniform(-2, 2, (3, 50, 1))
    tau = fb.compile(s).inverse_dynamics(q, u, udot)
    with pytest.raises(
        ModelError, match="Expected a mass and an inertia of body 'bob' that a body with extent"
    ):
        fb.identify(s, q, u, udot, tau, feasible=True)


# -- closed loops -------------------------------------------------------------------------------------------


def four_bar():
    s = fb.System("four-bar")
    s.gravity = (0, -9.81, 0)
    crank, coupler, rocker = (
        s.body(n, fb.MassProperties(m, (0.1, x, 0), ((m / 5, 0, 0), (0, m / 5, 0), (0, 0, m / 5))))
        for n, m, x in (("crank", 1, 0.0), ("coupler", 2, 0.1), ("rocker", 1.5, -0.05))
    )
    s.hinge("a", s.ground, crank, coordinate="a")
    s.hinge("b", crank, coupler, at=(0.5, 0, 0), coordinate="b")
    s.hinge("d", s.ground, rocker, at=(1.5, 0, 0), coordinate="d")
    s.parameters(c=0.3)
    s.damper("friction", s.joints["d"], damping="c")
    s.hinge("e", coupler, rocker, at=(1.6, 0, 0), to=(1, 0, 0))
    return s


def measured_loop(s, count=60):
    """States of the crank's motion, and the torque of its motor."""
    program = fb.compile(s, at=[0.3, 0.4, 1.5])
    rng = np.random.default_rng(0)
    rows = []
    for angle in np.linspace(0.3, 6, count):
        start = rows[-1][0].copy() if rows else np.array([0.3, 0.4, 1.5])
        start[0] = angle
        q = np.array(closed_coordinates(program.model, start.tolist(), fixed=[0]))
        G = program.conditions(q, np.zeros(3))[:, :3]
        N = np.linalg.svd(G)[2][-1]
        u = N * rng.uniform(-2, 2)
        udot = program.accelerations(q, u, {"a": rng.uniform(-3, 3)})
        tau = np.zeros(3)
        tau[0] = program.inverse_dynamics(q, u, udot, actuators=["a"])[0]
        rows.append((q, u, udot, tau))
    return [np.array(x) for x in zip(*rows, strict=True)]


def test_a_closed_loop_is_identified_by_the_forces_of_its_motor():
    s = four_bar()
    found = fb.identify(s, *measured_loop(s), unknowns=["c"])
    theta = np.array([*fb.compile(s).inertial_parameters().values()])
    expected = [*found.base.matrix() @ theta, 0.3]
    assert found.residuals.shape[1] == 1 and len(found.base.names) < len(fb.base_parameters(tree(s)).names)
    assert np.abs(np.array([*found.values.values()]) - expected).max() < 1e-11 * found.condition
    assert "couple the speeds" in found.base.text()
    feasible = fb.identify(s, *measured_loop(s), unknowns=["c"], feasible=True)
    assert np.abs(np.array([*feasible.values.values()]) - expected).max() < 1e-11 * found.condition


def tree(s):
    """The machine without its last joint."""
    again = four_bar()
    del again.joints["e"]
    return again


def test_a_singular_position_of_a_loop_is_refused():
    s = fb.System("parallelogram")
    bodies = [s.body(n, fb.sphere(1, 0.1)) for n in "xyz"]
    s.hinge("a", s.ground, bodies[0])
    s.hinge("b", bodies[0], bodies[1], at=(1, 0, 0))
    s.hinge("d", s.ground, bodies[2], at=(2, 0, 0))
    s.hinge("e", bodies[1], bodies[2], at=(2, 0, 0), to=(1, 0, 0))
    q = np.array(
        [[0.3, -0.3, 0.3], [0, 0, 0], *([0.3 + x, -0.3 - x, 0.3 + x] for x in np.linspace(0, 1, 30))]
    )
    u = np.full(q.shape, [1, -1, 1])
    with pytest.raises(
        ModelError, match=r"conditions e are as independent .* got a singular position in row 1\. Leave"
    ):
        fb.identify(s, q, u, 0 * u, 0 * u)
