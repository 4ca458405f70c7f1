"""Joints against hand kinematics, drives, shared coordinates, and motions known without equations."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import (
    coordinate_rates,
    float_state,
    forward_dynamics,
    inverse_dynamics,
    kinetic_energy,
    mass_matrix,
    mechanical_power,
    poses,
    potential_energy,
    reactions,
    rest_coordinates,
    traced_state,
)
from freebody.dynamics.kinematics import angular_velocity, point_acceleration, point_velocity
from freebody.dynamics.linear import solve_symmetric
from freebody.scalar.trace import Tape
from freebody.testing import random_rotation

EXACT = 2**8 * np.finfo(float).eps


def turn(axis, angle):
    """Rotation matrix about a unit vector, by Rodrigues' formula."""
    n = np.asarray(axis, float)
    K = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


X, Y, Z = np.eye(3)
OBLIQUE = np.array([2.0, -1.0, 2.0]) / 3


def by_hand(kind, q, u):
    """Pose of the child's joint axes in the parent's, and their motion: R, p, w, v in the parent's joint axes."""
    zero = np.zeros(3)
    if kind == "weld":
        return np.eye(3), zero, zero, zero
    if kind == "hinge":
        return turn(OBLIQUE, q[0]), zero, OBLIQUE * u[0], zero
    if kind == "slider":
        return np.eye(3), OBLIQUE * q[0], zero, OBLIQUE * u[0]
    if kind == "cylindrical":
        return turn(OBLIQUE, q[1]), OBLIQUE * q[0], OBLIQUE * u[1], OBLIQUE * u[0]
    if kind == "screw":
        return turn(OBLIQUE, q[0]), 0.3 * OBLIQUE * q[0], OBLIQUE * u[0], 0.3 * OBLIQUE * u[0]
    if kind == "universal":
        first = turn(X, q[0])
        return first @ turn(Y, q[1]), zero, X * u[0] + first @ Y * u[1], zero
    if kind == "gimbal":
        first = turn(Z, q[0])
        second = first @ turn(X, q[1])
        return second @ turn(Z, q[2]), zero, Z * u[0] + first @ X * u[1] + second @ Z * u[2], zero
    if kind == "planar":
        return turn(Z, q[2]), X * q[0] + Y * q[1], Z * u[2], X * u[0] + Y * u[1]
    if kind == "ball":
        R = matrix_of(q)
        return R, zero, R @ u, zero
    R = matrix_of(q[3:])
    return R, np.array(q[:3]), R @ u[:3], R @ u[3:]


def matrix_of(e):
    """Rotation matrix of a unit quaternion through its axis and angle."""
    angle = 2 * np.arccos(e[0])
    return turn(np.array(e[1:]) / np.sin(angle / 2), angle)


GIVEN = {
    "hinge": {"axis": (2, -1, 2)},
    "slider": {"axis": (2, -1, 2)},
    "cylindrical": {"axis": (2, -1, 2)},
    "screw": {"axis": (2, -1, 2), "pitch": 0.3},
    "universal": {"axis": ("x", "y")},
    "gimbal": {"axis": "ZXZ"},
}
KINDS = ["hinge", "slider", "cylindrical", "screw", "universal", "gimbal", "planar", "ball", "free", "weld"]


@pytest.mark.parametrize("turned", [False, True], ids=["plain", "turned"])
@pytest.mark.parametrize("kind", KINDS)
def test_pose_and_velocity_of_every_joint(kind, turned):
    """R_NB = A R Cᵀ and p_NB = at + A p - R_NB to, with the joint's axes A on the parent and C on the child."""
    rng = np.random.default_rng(KINDS.index(kind))
    at, to = rng.normal(size=3).round(2), rng.normal(size=3).round(2)
    A, C = (np.array(random_rotation(rng)) if turned else np.eye(3) for _ in range(2))
    s = fb.System(kind)
    block = s.body("block", fb.box(1, (1, 2, 3)))
    axes = {"parent_axes": A, "child_axes": C} if turned else {}
    getattr(s, kind)("j", s.ground, block, at=at, to=to, **axes, **GIVEN.get(kind, {}))
    model = fb.assemble(s)
    q = rng.normal(size=model.n_q)
    for i in model.quaternions:
        q[i : i + 4] /= np.linalg.norm(q[i : i + 4])
    u = rng.normal(size=model.n_u)
    state = float_state(model, q, u)
    R, p, w, v = by_hand(kind, q, u)
    posture = poses(model, state)["block"]
    R_NB = A @ R @ C.T
    assert np.allclose(np.array(posture.rotation, float), R_NB, rtol=0, atol=EXACT)
    assert np.allclose(np.array(posture.position, float), at + A @ p - R_NB @ to, rtol=0, atol=4 * EXACT)
    assert np.allclose(np.array(angular_velocity(model, state, block), float), A @ w, rtol=0, atol=4 * EXACT)
    velocity = A @ v - np.cross(A @ w, R_NB @ to)
    assert np.allclose(
        np.array(point_velocity(model, state, block.origin), float), velocity, rtol=0, atol=8 * EXACT
    )


def test_with_coordinates_zero_the_joint_axes_coincide():
    for kind in KINDS:
        s = fb.System(kind)
        block = s.body("block", fb.box(1, (1, 2, 3)))
        getattr(s, kind)("j", s.ground, block, at=(1, 2, 3), to=(3, 2, 1), **GIVEN.get(kind, {}))
        model = fb.assemble(s)
        posture = poses(model, float_state(model, rest_coordinates(model)))["block"]
        assert np.array_equal(np.array(posture.rotation, float), np.eye(3))
        assert tuple(map(float, posture.position)) == (-2, 0, 2)


@pytest.mark.parametrize(
    "sequence", [a + b + c for a in "XYZ" for b in "XYZ" for c in "XYZ" if a != b and b != c]
)
def test_gimbals_turn_as_the_euler_sequences_of_scipy(sequence):
    from scipy.spatial.transform import Rotation

    s = fb.System("gimbal")
    block = s.body("block", fb.box(1, (1, 2, 3)))
    s.gimbal("mount", s.ground, block, axis=sequence)
    model = fb.assemble(s)
    angles = [0.3, -0.8, 1.9]
    R = np.array(poses(model, float_state(model, angles))["block"].rotation, float)
    assert np.allclose(R, Rotation.from_euler(sequence, angles).as_matrix(), rtol=0, atol=EXACT)


# --- drives ---------------------------------------------------------------------------------------


def test_a_driven_crank_needs_the_torque_of_its_weight_and_inertia():
    """theta = a t² / 2: M = I a + m g (L/2) cos theta, and its power is M theta'."""
    s = fb.System("crank")
    a, m, L, g = s.parameters(a=1.5, m=2.0, L=0.8, g=9.81)
    s.gravity = (0, -g, 0)
    crank = s.body("crank", fb.slender_bar(m, L, axis="x"))
    s.hinge("shaft", s.ground, crank, to=(-L / 2, 0, 0), coordinate=a * s.t**2 / 2)
    model = fb.assemble(s)
    t = 0.7
    state = float_state(model, [], [], t)
    theta, rate = 1.5 * t**2 / 2, 1.5 * t
    force, moment = reactions(model, state, ())["shaft"]
    torque = 2.0 * 0.8**2 / 3 * 1.5 + 2.0 * 9.81 * 0.4 * np.cos(theta)
    assert moment == pytest.approx((0, 0, torque), rel=EXACT)
    centre = 0.4 * np.array(
        [-np.sin(theta) * 1.5 - np.cos(theta) * rate**2, np.cos(theta) * 1.5 - np.sin(theta) * rate**2]
    )
    assert force == pytest.approx((2 * centre[0], 2 * centre[1] + 2 * 9.81, 0), rel=EXACT)
    assert mechanical_power(model, state, ()) == pytest.approx(torque * rate, rel=EXACT)


def test_a_motor_on_a_driven_joint_relieves_the_drive():
    """The drive gives what the motor does not."""
    s = fb.System("crank")
    disk = s.body("disk", fb.disk(2, 1))
    shaft = s.hinge("shaft", s.ground, disk, coordinate=3 * s.t**2)
    s.torque("motor", shaft, 4)
    model = fb.assemble(s)
    _, moment = reactions(model, float_state(model, [], [], 1), ())["shaft"]
    assert moment == (0, 0, pytest.approx(6 - 4, rel=EXACT))


def test_a_body_on_a_driven_carriage_feels_its_acceleration():
    """A pendulum hangs still at tan theta = -a / g on a wagon of acceleration a."""
    s = fb.System("wagon")
    s.gravity = (0, -9.81, 0)
    wagon = s.body("wagon", fb.particle(5))
    bob = s.body("bob", fb.particle(1))
    s.slider("track", s.ground, wagon, coordinate=2 * s.t**2)
    s.hinge("pin", wagon, bob, to=(0, 0.5, 0), coordinate="theta")
    model = fb.assemble(s)
    theta = -np.arctan2(4, 9.81)
    (acceleration,) = forward_dynamics(model, float_state(model, [theta], [0], 3.0))
    assert abs(acceleration) <= 40 * EXACT
    force, _ = reactions(model, float_state(model, [theta], [0], 3.0), [0])["track"]
    assert force == pytest.approx((6 * 4, 6 * 9.81, 0), rel=EXACT)


# --- coordinates as expressions -------------------------------------------------------------------


def test_absolute_and_relative_angles_are_one_motion():
    def chain(absolute):
        s = fb.System("chain")
        s.gravity = (0, -9.81, 0)
        q = s.coordinates("a b c")
        parent = s.ground
        for i in range(3):
            bar = s.body(f"bar{i}", fb.slender_bar(1 + i, 2, axis="y"))
            coordinate = q[i] - q[i - 1] if absolute and i else q[i]
            s.hinge(f"pin{i}", parent, bar, at=(0, -1 if i else 0, 0), to=(0, 1, 0), coordinate=coordinate)
            parent = bar
        s.damper("c", s.joints["pin1"], damping=0.4)
        return fb.assemble(s)

    relative, absolute = chain(False), chain(True)
    q, u = np.array([0.3, -0.5, 1.1]), np.array([1.0, 2.0, -0.7])
    one, two = float_state(relative, q, u), float_state(absolute, q.cumsum(), u.cumsum())
    assert kinetic_energy(relative, one) == pytest.approx(kinetic_energy(absolute, two), rel=EXACT)
    assert potential_energy(relative, one) == pytest.approx(potential_energy(absolute, two), rel=EXACT)
    accelerations = np.cumsum(forward_dynamics(relative, one))
    assert forward_dynamics(absolute, two) == pytest.approx(accelerations, rel=4 * EXACT)


def test_two_hinges_that_share_a_coordinate_are_a_gear():
    """(I1 + n² I2) q'' = M: wheels of ratio n, driven at the first."""
    s = fb.System("gear")
    q = s.coordinates("q")
    I1, I2, n = 0.5 * 2 * 1**2, 0.5 * 3 * 0.5**2, 2
    first, second = s.body("first", fb.disk(2, 1)), s.body("second", fb.disk(3, 0.5))
    one = s.hinge("a", s.ground, first, coordinate=q)
    s.hinge("b", s.ground, second, at=(3, 0, 0), coordinate=n * q)
    s.torque("M", one, 7)
    model = fb.assemble(s)
    assert model.order is None
    state = float_state(model, [0.4], [2.0])
    assert mass_matrix(model, state) == ((pytest.approx(I1 + n**2 * I2, rel=EXACT),),)
    (acceleration,) = forward_dynamics(model, state)
    assert acceleration == pytest.approx(7 / (I1 + n**2 * I2), rel=EXACT)
    result = reactions(model, state, [acceleration])
    # the tooth's force: what the first wheel lacks, the second gets n times less of
    assert result["b"][1][2] == pytest.approx(I2 * n * acceleration, rel=EXACT)
    assert result["a"][1][2] == pytest.approx(I1 * acceleration - 7, rel=EXACT)
    assert result["a"][1][2] + n * result["b"][1][2] == pytest.approx(0, abs=7 * EXACT)
    (residual,) = inverse_dynamics(model, state, [acceleration])
    assert abs(residual) <= 7 * EXACT


def test_a_cam_whose_displacement_is_a_function():
    """x = L sin q: x'' = L cos q q'' - L sin q q'²; the force of a spring at x drives q."""
    s = fb.System("scotch yoke")
    q = s.coordinates("q")
    wheel, yoke = s.body("wheel", fb.disk(2, 1)), s.body("yoke", fb.particle(3))
    s.hinge("axle", s.ground, wheel, coordinate=q)
    rail = s.slider("rail", s.ground, yoke, coordinate="0.5*sin(q)")
    s.spring("k", rail, stiffness=40)
    model = fb.assemble(s)
    state = float_state(model, [0.6], [3.0])
    c, d = 0.5 * np.cos(0.6), 0.5 * np.sin(0.6)
    # by Lagrange with T = (1 + 3 c²) q'² / 2: M q'' + 3 c c_q q'² + 40 x x_q = 0
    M = 1 + 3 * c**2
    expected = (3 * c * d * 9 - 40 * d * c) / M
    assert forward_dynamics(model, state) == (pytest.approx(expected, rel=EXACT),)


# --- motions known without equations --------------------------------------------------------------


def test_a_free_sphere_falls_and_keeps_spinning():
    s = fb.System("throw")
    s.gravity = (1, 2, -9.81)
    ball = s.body("ball", fb.sphere(2, 0.3))
    s.free("air", s.ground, ball)
    model = fb.assemble(s)
    e = np.array([1, 2, -1, 3]) / np.sqrt(15)
    w, v = [3.0, -1.0, 2.0], [0.5, 1.0, -2.0]
    state = float_state(model, [1, 2, 3, *e], [*w, *v])
    udot = forward_dynamics(model, state)
    assert udot[:3] == pytest.approx((0, 0, 0), abs=20 * EXACT)
    assert point_acceleration(model, state, ball.origin, udot) == pytest.approx((1, 2, -9.81), rel=EXACT)
    rates = coordinate_rates(model, state)
    assert rates[:3] == pytest.approx(point_velocity(model, state, ball.origin), rel=EXACT)
    force, moment = reactions(model, state, udot)["air"]
    assert (*force, *moment) == (0,) * 6


def test_a_free_joint_may_hold_any_point_and_axes():
    """The same flight, described at another point of the body in turned axes."""
    rng = np.random.default_rng(3)
    A, C = random_rotation(rng), random_rotation(rng)
    s = fb.System("throw")
    s.gravity = (1, 2, -9.81)
    body = s.body("body", fb.box(2, (1, 2, 3)))
    s.free("air", s.ground, body, at=(1, 1, 1), to=(0.5, -0.2, 0.1), parent_axes=A, child_axes=C)
    model = fb.assemble(s)
    q = [1, 2, 3, *(np.array([1, 2, -1, 3]) / np.sqrt(15))]
    state = float_state(model, q, rng.normal(size=6))
    udot = forward_dynamics(model, state)
    assert point_acceleration(model, state, body.center, udot) == pytest.approx((1, 2, -9.81), rel=8 * EXACT)
    # p' is the velocity of the point, in the joint axes of the parent
    v = np.array(point_velocity(model, state, body.point(0.5, -0.2, 0.1)), float)
    assert coordinate_rates(model, state)[:3] == pytest.approx(tuple(np.array(A).T @ v), rel=8 * EXACT)


def test_a_ball_joint_is_a_gimbal_without_its_singularity():
    """Angular acceleration of the body in the ground, from both descriptions of one state."""
    inertia = ((2.0, 0.1, 0.2), (0.1, 3.0, -0.3), (0.2, -0.3, 4.0))
    models = {}
    for kind in ("gimbal", "ball"):
        s = fb.System(kind)
        s.gravity = (0, 0, -9.81)
        rotor = s.body("rotor", fb.MassProperties(2.0, (0.1, 0.2, 0.7), inertia))
        getattr(s, kind)("pivot", s.ground, rotor, **({"axis": "ZXZ"} if kind == "gimbal" else {}))
        models[kind] = (fb.assemble(s), rotor)
    angles, rates = [0.4, 0.9, -0.3], [1.0, -2.0, 3.0]
    gimbal, rotor = models["gimbal"]
    one = float_state(gimbal, angles, rates)
    R = fb.Rotation(poses(gimbal, one)["rotor"].rotation)
    w_N = np.array(angular_velocity(gimbal, one, rotor), float)
    ball, same = models["ball"]
    two = float_state(ball, R.as_quaternion(), np.array(R.matrix, float).T @ w_N)
    assert kinetic_energy(gimbal, one) == pytest.approx(kinetic_energy(ball, two), rel=8 * EXACT)
    accelerations = [
        point_acceleration(model, state, body.point(1, 2, 3), forward_dynamics(model, state))
        for model, state, body in ((gimbal, one, rotor), (ball, two, same))
    ]
    assert accelerations[0] == pytest.approx(accelerations[1], rel=64 * EXACT)


def test_springs_and_dampers_between_points():
    """Two masses on a line: tension k (d - rest) + c d'."""
    s = fb.System("line")
    a, b = s.body("a", fb.particle(2)), s.body("b", fb.particle(3))
    for name, body in (("x", a), ("y", b)):
        s.slider(name, s.ground, body, coordinate=name)
    s.spring("k", a.origin, b.origin, stiffness=5, rest=1)
    s.damper("c", a, b, damping=0.5)
    model = fb.assemble(s)
    state = float_state(model, [1.0, 4.0], [0.2, -0.6])
    tension = 5 * (3 - 1) + 0.5 * (-0.6 - 0.2)
    assert forward_dynamics(model, state) == pytest.approx((tension / 2, -tension / 3), rel=EXACT)
    assert potential_energy(model, state) == pytest.approx(5 * 2**2 / 2, rel=EXACT)
    assert mechanical_power(model, state, ()) == pytest.approx(-0.5 * 0.8**2, rel=EXACT)


def test_torques_act_on_a_body_and_against_another():
    s = fb.System("motor")
    one, two = s.body("one", fb.disk(2, 1)), s.body("two", fb.disk(4, 1))
    s.hinge("a", s.ground, one)
    s.hinge("b", s.ground, two)
    s.torque("T", one, (0, 0, 3), reaction_on=two)
    model = fb.assemble(s)
    state = float_state(model, [0, 0], [1.0, 2.0])
    assert forward_dynamics(model, state) == pytest.approx((3.0, -1.5), rel=EXACT)
    assert mechanical_power(model, state, ()) == pytest.approx(3 - 6, rel=EXACT)


def test_forces_in_the_axes_of_a_body_turn_with_it():
    s = fb.System("rocket")
    body = s.body("body", fb.box(2, (1, 1, 1)))
    s.planar("plane", s.ground, body, coordinate="x y theta")
    s.force("thrust", body.point(0, -0.5, 0), (0, 6, 0), frame=body)
    model = fb.assemble(s)
    x, y, theta = forward_dynamics(model, float_state(model, [0, 0, np.pi / 6], [0, 0, 0]))
    assert (x, y, theta) == pytest.approx((-3 * np.sin(np.pi / 6), 3 * np.cos(np.pi / 6), 0), abs=EXACT * 3)


# --- recorded programs ----------------------------------------------------------------------------


def test_a_recorded_pendulum_is_as_short_as_by_hand():
    """theta'' = -(3 g / 2 L) sin theta with theta from the hinge: constants fold, zeros and ones vanish."""
    s = fb.System("pendulum")
    s.gravity = (0, -10, 0)
    bar = s.body("bar", fb.slender_bar(3, 2, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, 1, 0), coordinate="theta")
    model, tape = fb.assemble(s), Tape()
    (udot,) = forward_dynamics(model, traced_state(model, tape))
    assert tape.evaluate([udot], {"theta": 0.5, "theta'": 9.0, "t": 0}) == [
        pytest.approx(-7.5 * np.sin(0.5), rel=EXACT)
    ]
    assert len(tape.used([udot])) <= 16


# --- linear equations -----------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 3, 6])
def test_symmetric_solution(n):
    from fractions import Fraction

    rng = np.random.default_rng(n)
    B = rng.integers(-3, 4, size=(n, n)) + 5 * np.eye(n, dtype=int)
    A = [[int(x) for x in row] for row in B @ B.T]
    b = [int(x) for x in rng.integers(-5, 6, size=n)]
    x = solve_symmetric(A, b)
    assert all(isinstance(value, int | Fraction) for value in x)
    assert [sum(p * y for p, y in zip(row, x, strict=True)) for row in A] == b
