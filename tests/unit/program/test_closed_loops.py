"""Inverse dynamics, prescribed motions and singular positions of closed loops."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state
from freebody.dynamics.conditions.constraints import residuals
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.kinematics import state_along
from freebody.errors import ModelError, SimulationError
from freebody.scalar.series import Series


def four_bar(lengths=(1.0, 3.0, 2.5), base=3.0, crank="a"):
    """A crank, a coupler and a rocker on a base; the loop closes at the joint C."""
    s = fb.System("four-bar")
    s.gravity = (0, -9.81, 0)
    bars = [
        s.body(name, fb.slender_bar(1 + i, L, axis="x"))
        for i, (name, L) in enumerate(zip(("crank", "coupler", "rocker"), lengths, strict=True))
    ]
    L1, L2, L3 = lengths
    s.hinge("A", s.ground, bars[0], to=(-L1 / 2, 0, 0), axis="z", coordinate=crank)
    s.hinge("B", bars[0], bars[1], at=(L1 / 2, 0, 0), to=(-L2 / 2, 0, 0), axis="z", coordinate="b")
    s.hinge("D", s.ground, bars[2], at=(base, 0, 0), to=(-L3 / 2, 0, 0), axis="z", coordinate="d")
    s.hinge("C", bars[1], bars[2], at=(L2 / 2, 0, 0), to=(L3 / 2, 0, 0), axis="z")
    return s


def closed(a, lengths=(1.0, 3.0, 2.5), base=3.0):
    """(a, b, d) of the open branch, by the law of cosines; b is relative to the crank."""
    L1, L2, L3 = lengths
    tip = L1 * np.array([math.cos(a), math.sin(a)])
    way = np.array([base, 0]) - tip
    r = np.hypot(*way)
    coupler = math.atan2(way[1], way[0]) + math.acos((L2**2 + r**2 - L3**2) / (2 * L2 * r))
    end = tip + L2 * np.array([math.cos(coupler), math.sin(coupler)]) - [base, 0]
    return [a, coupler - a, math.atan2(end[1], end[0])]


def moving(program, a, rate):
    """q and u that keep the loop closed at a crank angle and rate, rates from differences of the closed form."""
    h = 1e-6
    q = np.array(closed(a))
    u = (np.array(closed(a + h)) - closed(a - h)) / (2 * h) * rate
    G = program._run("conditions", {"q": q, "u": u}, 0.0, None, {})[list(program._active), :-1]
    A = np.vstack([G, [1, 0, 0]])
    return q, np.linalg.lstsq(A, [0, 0, rate], rcond=None)[0]


def test_inverse_dynamics_of_a_loop_is_the_power_balance():
    """With one actuator τ a' = d(T + V)/dt, the derivative taken along the motion by differences."""
    s = four_bar()
    program = fb.compile(s, at=closed(0.9))
    q, u = moving(program, 0.9, 2.0)
    udot = program.accelerations(q, u, {"a": 3.0})
    (tau,) = program.inverse_dynamics(q, u, udot, actuators="a")

    def energy(t):
        x, v = q + u * t + udot * t * t / 2, u + udot * t
        return program.kinetic_energy(x, v) + program.potential_energy(x)

    h = 1e-4
    slope = (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h)
    assert tau * u[0] == pytest.approx(slope, rel=1e-8)


def test_inverse_dynamics_undoes_forward_dynamics():
    """u' of given forces on the crank needs just these forces, and its rocker alone needs others."""
    s = four_bar()
    program = fb.compile(s, at=closed(0.9))
    q, u = moving(program, 0.9, 2.0)
    udot = program.forward_dynamics(q, u, forces=[5.0, 0.0, 0.0])
    assert program.inverse_dynamics(q, u, udot, actuators=["A"])[0] == pytest.approx(5.0, abs=1e-10)
    one = program.inverse_dynamics(q, u, udot, actuators="d")
    assert one[0] * u[2] == pytest.approx(5.0 * u[0], rel=1e-9)  # of equal power
    np.testing.assert_allclose(
        program.forward_dynamics(q, u, forces=[0, 0, one[0]]), udot, rtol=0, atol=1e-9 * np.abs(udot).max()
    )


def test_smallest_forces_of_several_actuators():
    """Of all that give the motion, the least sum of squares; "all" speeds, and two of them."""
    s = four_bar()
    program = fb.compile(s, at=closed(0.9))
    q, u = moving(program, 0.9, 2.0)
    udot = program.accelerations(q, u, {"a": 3.0})
    (alone,) = program.inverse_dynamics(q, u, udot, actuators="a")
    both = program.inverse_dynamics(q, u, udot, actuators="a d")
    rates = np.array([u[0], u[2]])
    np.testing.assert_allclose(both, alone * u[0] * rates / (rates @ rates), rtol=1e-9)
    every = program.inverse_dynamics(q, u, udot, actuators="all")
    np.testing.assert_allclose(every, alone * u[0] * u / (u @ u), rtol=1e-9)
    batch = program.inverse_dynamics(
        np.array([q, q]), np.array([u, u]), np.array([udot, udot]), actuators="a d"
    )
    np.testing.assert_allclose(batch, [both, both], rtol=1e-12)


def test_torque_of_a_prescribed_crank_is_that_of_inverse_dynamics():
    """A crank turned as 0.9 + 2 t: the reaction of its joint along the axis, and the work it does."""
    t = fb.System("x").t
    driven = four_bar(crank=0.9 + 2 * t)
    start = closed(0.9)
    motion = fb.simulate(
        driven, 2, near={"b": start[1], "d": start[2]}, times=[0.0, 0.7, 2.0], tolerance=1e-11
    )
    program = fb.compile(four_bar(), at=start)
    for i, moment in enumerate(motion.t):
        q, u = moving(program, 0.9 + 2 * moment, 2.0)
        np.testing.assert_allclose([motion["b"][i], motion["d"][i]], q[1:], atol=1e-9)
        udot = program.accelerations(q, u, {"a": 0.0})
        (tau,) = program.inverse_dynamics(q, u, udot, actuators="a")
        assert motion.reactions["A"].moment[i, 2] == pytest.approx(tau, rel=1e-7)
    assert np.max(np.abs(motion.energy.residual)) < 1e-8


def test_dead_point_of_a_slider_crank():
    """At the dead centre the slider cannot turn the crank; beside it, it can, with a ratio that falls to zero."""
    s = fb.System("slider-crank")
    crank = s.body("crank", fb.slender_bar(1, 1, axis="x"))
    rod = s.body("rod", fb.slender_bar(1, 3, axis="x"))
    piston = s.body("piston", fb.particle(1))
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), axis="z", coordinate="a")
    s.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-1.5, 0, 0), axis="z", coordinate="b")
    s.slider("rail", s.ground, piston, axis="x", coordinate="x")
    s.hinge("C", rod, piston, at=(1.5, 0, 0), axis="z")
    q = [0.4, -0.4 - math.asin(math.sin(0.4) / 3), math.cos(0.4) + math.sqrt(9 - math.sin(0.4) ** 2)]
    program = fb.compile(s, at=q)
    assert program.singularity(q).kind == "regular"
    assert program.singularity(q, actuators="x").kind == "regular"
    dead = [0.0, 0.0, 4.0]
    found = program.singularity(dead, actuators="x")
    assert found.kind == "lock-up" and found.speeds == ("a'", "b'")
    assert "lock-up: a', b' can move" in str(found)
    assert program.singularity(dead, actuators="a").kind == "regular"
    ratios = [
        program.singularity([e, -e - math.asin(math.sin(e) / 3), math.cos(e) + math.sqrt(9 - math.sin(e) ** 2)],
                            actuators="rail").ratio
        for e in (1e-2, 1e-3)
    ]  # fmt: skip
    assert ratios[0] / ratios[1] == pytest.approx(10, rel=0.01)
    with pytest.raises(ModelError, match="Actuators on x cannot hold 'slider-crank'.*locked up"):
        program.inverse_dynamics(dead, [0, 0, 0], [0, 0, 0], actuators="x")
    with pytest.raises(ModelError, match="leave 1 degree of freedom.*dead point"):
        program.accelerations(dead, [0, 0, 0], {"x": 0.0})


def test_branch_of_a_parallelogram():
    """Flat, a parallelogram can go on as such or crossed: one condition depends on the other there."""
    lengths, base = (1.0, 3.0, 1.0), 3.0
    s = four_bar(lengths, base)
    program = fb.compile(s, at=[1.0, -1.0, 1.0])
    assert program.singularity([1.0, -1.0, 1.0]).kind == "regular"
    flat = program.singularity([0.0, 0.0, 0.0])
    assert flat.kind == "branch" and flat.ratio < 1e-9
    assert set(flat.conditions) <= {"C_x", "C_y"} and flat.conditions
    assert "depend on each other here" in str(flat)
    with pytest.raises(ModelError, match="depend on each other in this position"):
        program.inverse_dynamics([0, 0, 0], [0, 0, 0], [0, 0, 0], actuators="a")


def test_a_crank_that_can_not_turn_on_is_named():
    """Links 2, 1.5, 1.5 on 3: the crank reaches the angle at which coupler and rocker come into line, and stops."""
    lengths, base = (2.0, 1.5, 1.5), 3.0
    limit = math.acos((2**2 + 3**2 - 3**2) / (2 * 2 * 3))
    t = fb.System("x").t
    driven = four_bar(lengths, base, crank=0.5 + t)
    start = closed(0.5, lengths, base)
    with pytest.raises(SimulationError, match="locks up.*C_") as caught:
        fb.simulate(driven, 2, near={"b": start[1], "d": start[2]})
    assert caught.value.trajectory.path.end == pytest.approx(limit - 0.5, abs=1e-3)


def test_refused():
    s = four_bar()
    program = fb.compile(s, at=closed(0.9))
    q, u = moving(program, 0.9, 2.0)
    with pytest.raises(ModelError, match="do not keep the constraints"):
        program.inverse_dynamics(q, u, [1.0, 0.0, 0.0], actuators="a")
    with pytest.raises(ModelError, match="Expected coordinates with an actuator, got 'e'"):
        program.inverse_dynamics(q, u, u, actuators="e")
    with pytest.raises(ModelError, match="named twice"):
        program.singularity(q, actuators="a A")
    with pytest.raises(ModelError, match="at least one coordinate"):
        program.singularity(q, actuators=[])
    with pytest.raises(ModelError, match="contradict the constraints"):
        program.accelerations(q, u, {"a": 0.0, "b": 5.0})
    with pytest.raises(ModelError, match="fb.compile\\(s, at="):
        fb.compile(s).inverse_dynamics(q, u, u, actuators="a")
    pair = fb.System("double pendulum")
    upper, lower = pair.body("upper", fb.particle(1)), pair.body("lower", fb.particle(1))
    pair.hinge("one", pair.ground, upper, to=(0, 1, 0), axis="z", coordinate="a")
    pair.hinge("two", upper, lower, to=(0, 1, 0), axis="z", coordinate="b")
    assert fb.compile(pair).accelerations([0, 0], [0, 0], {"a": 1.0, "b": 2.0}).tolist() == [1, 2]
    assert str(fb.compile(pair).singularity([0, 0])) == "regular: ratio of singular values 1"
    with pytest.raises(ModelError, match="got a batch"):
        fb.compile(pair).singularity([[0, 0]] * 3)
    batch = np.zeros((3, 2))
    assert fb.compile(pair).inverse_dynamics(batch, batch, batch, actuators="all").shape == (3, 2)
    with pytest.raises(ModelError, match="at least 2 actuators for the 2 degrees of freedom.*got 1: a"):
        fb.compile(pair).inverse_dynamics([0, 0], [0, 0], [0, 0], actuators="a")


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda p, q: p.accelerations(q, [0] * 3, [2.0]), "by name, such as {'crank': 2.0}, got [2.0]."),
        (
            lambda p, q: p.accelerations(q, [0] * 3, {"a": "fast"}),
            "numbers for the acceleration of 'a', got 'fast'.",
        ),
        (
            lambda p, q: p.accelerations(q, [0] * 3, {"a": math.nan}),
            "a finite number for the acceleration of 'a'",
        ),
        (lambda p, q: p.inverse_dynamics(q, [0] * 3, [0] * 3, actuators=3), "with an actuator, got '3'"),
        (
            lambda p, q: p.singularity([math.nan, 1, 1]),
            "in which the conditions of 'four-bar' have values, got",
        ),
    ],
)
def test_nonsense_is_refused(ask, message):
    q = closed(0.9)
    with pytest.raises(ModelError) as caught:
        ask(fb.compile(four_bar(), at=q), q)
    assert message in str(caught.value)


@pytest.mark.parametrize("closing", ["ball", "hinge", "universal", "weld", "gimbal"])
def test_rows_of_a_loop_are_derivatives_of_its_residuals(closing):
    """G and γ from the motion of the ends against truncated series of φ, at states where the loop is open too.

    The loop holds joints of every kind; one of its loops hangs from a link that moves.
    """
    s = fb.System("loop")
    rng = np.random.default_rng(3)
    bodies, parent = [s.ground], s.ground
    for i, kind in enumerate(("free", "hinge", "ball", "slider", "driven", "screw", "weld", "hinge")):
        body = s.body(f"b{i}", fb.box(1, (0.3, 0.5, 0.7)))
        place = {x: tuple(rng.uniform(-1, 1, 3).round(2).tolist()) for x in ("at", "to")}
        if kind == "driven":
            s.hinge(f"j{i}", parent, body, axis=(0.6, 0, 0.8), coordinate="sin(2*t)", **place)
        elif kind == "screw":
            s.screw(f"j{i}", parent, body, axis="y", pitch=0.2, **place)
        elif kind in ("hinge", "slider"):
            getattr(s, kind)(f"j{i}", parent, body, axis="zx"[i % 2], **place)
        else:
            getattr(s, kind)(f"j{i}", parent, body, **place)
        bodies.append(body)
        parent = body
    for name, (a, b) in {"far": (0, 8), "near": (2, 7)}.items():
        axis = {"axis": "z"} if closing == "hinge" else {}
        getattr(s, closing)(name, bodies[a], bodies[b], at=(0.2, 0.1, 0), to=(0, 0.3, 0.1), **axis)
    model = fb.assemble(s)
    for _ in range(3):
        q, u = rng.normal(size=model.n_q), rng.normal(size=model.n_u)
        for k in model.quaternions:
            q[k : k + 4] /= np.linalg.norm(q[k : k + 4])
        state = float_state(model, q, u, 0.3)
        along = residuals(model, state_along(model, state, state.u, 1, 2))
        expected = np.array([r.derivative(2) for r in along])
        found = np.array(linearized(model, state).bias)
        assert len(found) > 5
        bound = 1e-12 * (1 + np.abs(expected).max())
        assert np.abs(found - expected).max() < bound
        G = np.array(linearized(model, state).matrix, dtype=float)
        for j, unit in enumerate(np.eye(model.n_u)):
            along = residuals(model, state_along(model, state, unit.tolist(), 0, 1))
            column = [r.derivative(1) if isinstance(r, Series) else 0 for r in along]
            assert np.abs(G[:, j] - column).max() < bound
        rows, back = linearized(model, state).in_loop_axes(range(len(found)))
        assert len(back) == 2
        for places, R in back:
            assert np.abs(np.array(R) @ [rows[i][0] for i in places] - G[places]).max() < bound
            assert np.abs(np.array(R) @ [rows[i][1] for i in places] - found[places]).max() < bound
