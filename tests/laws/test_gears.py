"""Laws of teeth on random gears: one velocity at the pitch point, no power, and the balance of every body."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import freebody as fb
from freebody.describe.contacts.mesh import Mesh
from freebody.dynamics.conditions.constrained import closed_coordinates, independent_rows, speed_correction
from freebody.dynamics.conditions.constraint_forces import separating_force, wrenches
from freebody.dynamics.conditions.constraints import rows
from freebody.dynamics.kinematics import link_postures, place_of, poses, rotation, velocities
from freebody.dynamics.motion import all_reactions, motion
from freebody.dynamics.state import float_state
from freebody.space.quaternion import matrix_from_quaternion

EPS = np.finfo(float).eps
ANGLE = 0.4


def solid(rng):
    """An unsymmetrical body with its mass centre anywhere."""
    box = fb.box(rng.uniform(1, 3), tuple(rng.uniform(0.3, 0.9, 3)))
    return box.moved(tuple(rng.uniform(-0.2, 0.2, 3)))


def frame_on(s, rng, moving):
    """A body on the ground that carries the gears: as it moves, everything on it does."""
    if not moving:
        return s.ground
    frame = s.body("frame", solid(rng))
    s.gimbal("gimbal", s.ground, frame, at=(0.3, 0, 0.1), axis="ZXY", coordinate="a b c")
    return frame


def across(rng):
    """A random axis n and two unit vectors across it, of fractions: what is square is so exactly."""
    q = rng.permutation([1, 2, 2, 4]) * rng.choice([-1, 1], 4)  # of length 5
    R = matrix_from_quaternion([Fraction(int(x), 5) for x in q])
    return [np.array(row) for row in R]


def wheels(rng, ratio, moving, helix=0):
    s = fb.System("wheels")
    frame = frame_on(s, rng, moving)
    n, x, _ = across(rng)
    one, two = (s.body(name, solid(rng)) for name in ("one", "two"))
    first = s.hinge("first", frame, one, at=tuple(n / 5), axis=tuple(n), coordinate="p")
    second = s.hinge("second", frame, two, at=tuple(n / 5 + 7 * x / 10), axis=tuple(n), coordinate="q")
    s.gear(first, second, ratio, name="mesh", pressure_angle=ANGLE, helix_angle=helix)
    return s


def bevel(rng, ratio, height, helix):
    """Wheels whose axes meet at an angle with the cosine 3/5; the second has the height that their cones need."""
    s = fb.System("bevel")
    frame = frame_on(s, rng, True)
    n, x, _ = across(rng)
    m = 3 * n / 5 + 4 * x / 5
    c = Fraction(3, 5)
    other = height * (ratio * c - 1) / (ratio - c)
    apex = n / 7
    one, two = (s.body(name, solid(rng)) for name in ("one", "two"))
    first = s.hinge("first", frame, one, at=tuple(apex + height * n), axis=tuple(n), coordinate="p")
    second = s.hinge("second", frame, two, at=tuple(apex + other * m), axis=tuple(m), coordinate="q")
    s.gear(first, second, ratio, name="mesh", pressure_angle=ANGLE, helix_angle=helix)
    return s


def crossed(rng, ratio, helix, square):
    """Wheels on crossed axes, at right angles (a worm) or not."""
    s = fb.System("crossed")
    frame = frame_on(s, rng, True)
    n, x, y = across(rng)
    m = y if square else 3 * n / 5 + 4 * y / 5
    one, two = (s.body(name, solid(rng)) for name in ("one", "two"))
    first = s.hinge("first", frame, one, at=tuple(n / 5), axis=tuple(n), coordinate="p")
    second = s.hinge("second", frame, two, at=tuple(n / 5 + 7 * x / 10), axis=tuple(m), coordinate="q")
    s.gear(first, second, ratio, name="mesh", pressure_angle=ANGLE, helix_angle=helix)
    return s


def turned_joints(rng):
    """The first wheel carries the frame, which carries the second: a wheel that rolls around one that may stand."""
    s = fb.System("planet on an arm")
    n, x, _ = across(rng)
    sun, arm, planet = (s.body(name, solid(rng)) for name in ("sun", "arm", "planet"))
    s.ball("ball", s.ground, sun, coordinate="s")
    first = s.hinge("first", sun, arm, axis=tuple(n), coordinate="p")
    second = s.hinge("second", arm, planet, at=tuple(9 * x / 10), axis=tuple(-n), coordinate="q")
    s.gear(first, second, 0.4, name="mesh", pressure_angle=ANGLE)
    return s


def rack(rng, order, helix=0):
    s = fb.System("rack")
    frame = frame_on(s, rng, True)
    n, x, _ = across(rng)
    pinion, bar = s.body("pinion", solid(rng)), s.body("bar", solid(rng))
    turn = s.hinge("turn", frame, pinion, at=tuple(n / 10), axis=tuple(n), coordinate="p")
    slide = s.slider("slide", frame, bar, at=tuple(n / 10 + 3 * x / 10), axis=tuple(x), coordinate="q")
    pair = (turn, slide, -4) if order else (slide, turn, 0.3)
    s.gear(*pair, name="mesh", pressure_angle=ANGLE, helix_angle=helix)
    return s


def train(rng):
    """A sun, an idler and a ring on a moving arm."""
    s = wheels(rng, -0.5, True)
    frame, one, two = (s.bodies[name] for name in ("frame", "one", "two"))
    ring = s.body("ring", solid(rng))
    axis = s.joints["first"].axis
    third = s.hinge("third", frame, ring, at=s.joints["first"].at, axis=axis, coordinate="r")
    s.gear(s.joints["second"], third, 3, name="inner", pressure_angle=ANGLE)
    return s


MACHINES = {
    "outer": lambda rng: wheels(rng, -0.6, False),
    "outer, moving": lambda rng: wheels(rng, -1.7, True),
    "inner, large first": lambda rng: wheels(rng, 0.35, True),
    "inner, small first": lambda rng: wheels(rng, 2.5, True),
    "planet on an arm": turned_joints,
    "pinion and rack": lambda rng: rack(rng, True),
    "rack and pinion": lambda rng: rack(rng, False),
    "train": train,
    "helical, right-handed": lambda rng: wheels(rng, -1.5, True, 0.3),
    "helical, inner": lambda rng: wheels(rng, 0.4, True, -0.5),
    "bevel": lambda rng: bevel(rng, Fraction(-5, 3), Fraction(2, 5), 0),
    "bevel, spiral": lambda rng: bevel(rng, Fraction(-4, 3), Fraction(-1, 2), 0.6),
    "bevel, inner": lambda rng: bevel(rng, Fraction(4), Fraction(1, 2), 0.2),
    "bevel, ring first": lambda rng: bevel(rng, Fraction(1, 4), Fraction(1, 3), -0.2),
    "worm": lambda rng: crossed(rng, 20, 1.4, True),
    "wheel and worm": lambda rng: crossed(rng, -0.05, 0.1, True),
    "crossed helical": lambda rng: crossed(rng, -1.3, 0.5, False),
    "helical rack": lambda rng: rack(rng, True, 0.4),
    "helical pinion of a rack": lambda rng: rack(rng, False, -0.4),
}


@pytest.fixture(params=MACHINES)
def geared(request):
    rng = np.random.default_rng(len(request.param))
    s = MACHINES[request.param](rng)
    s.gravity = (1, -9.81, 2)
    s.torque("drive", [j for j in s.joints.values() if j.type == "hinge"][-1], 3)
    model = fb.assemble(s)
    assert all(isinstance(mesh, Mesh) for mesh in model.meshes.values())
    guess = rng.normal(size=model.n_q)
    for i in model.quaternions:
        guess[i : i + 4] /= np.linalg.norm(guess[i : i + 4])
    q = closed_coordinates(model, guess.tolist())
    active = independent_rows(model, float_state(model, q))
    u = speed_correction(model, float_state(model, q, rng.normal(size=model.n_u).tolist()), active)
    return s, model, float_state(model, q, u), active


def teeth(model, state, multipliers):
    """(body, point, force) of all teeth."""
    found = []
    for row, value, pair in zip(rows(model), multipliers, wrenches(model, state), strict=True):
        apart, size = separating_force(model, state, model.constraints[row.owner])
        for (spot, along, _), (_, away, _) in zip(pair, apart, strict=True):
            force = float(value) * np.array(along, float) + size * abs(value) * np.array(away, float)
            found.append((spot.body, np.array(spot.position, float), force))
    return found


def velocity(model, state, body, point):
    link, _ = place_of(model, body)
    if link < 0:
        return np.zeros(3)
    w, v = (np.array(x, float) for x in velocities(model, state)[link])
    posture = link_postures(model, state)[link]
    R, p = np.array(posture.rotation, float), np.array(posture.position, float)
    return R @ v + np.cross(R @ w, point - p)


def test_both_bodies_have_one_velocity_at_the_pitch_point_and_teeth_do_no_work(geared):
    """On crossed axes one velocity across the teeth: they slide along each other, in the direction that is said."""
    _, model, state, active = geared
    found = teeth(model, state, motion(model, state, active).multipliers)
    meshes = model.meshes.values()
    for mesh, (a, at, force), (b, same, opposite) in zip(meshes, found[::2], found[1::2], strict=True):
        assert (at == same).all() and (force == -opposite).all()
        slip = velocity(model, state, a, at) - velocity(model, state, b, at)
        size = 1 + sum(np.abs(x).max() for x in (at, velocity(model, state, a, at), state.u))
        if mesh.teeth is not None:
            R = np.array(rotation(model, state, place_of(model, mesh.carrier)[0]), float)
            along = R @ np.array([float(x) for x in mesh.teeth])
            along /= np.linalg.norm(along)
            assert np.linalg.norm(slip) > 0.01
            slip = slip - (slip @ along) * along
        assert np.abs(slip).max() < 64 * EPS * size
        assert abs(force @ slip) < 64 * EPS * size * np.abs(force).max()


H = 2e-3
STENCIL = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}
"""First derivative to the fourth order."""


def test_the_teeth_and_the_bearings_balance_every_body(geared):
    """F = m a_C and M_C = dH_C/dt, of poses along the motion by differences."""
    s, model, state, active = geared
    moving = motion(model, state, active)
    path = fb.simulate(s, 0.05, initial=dict(zip([*model.coordinate_names, *model.speed_names],
        [*state.q, *state.u], strict=True)), tolerance=1e-13, project=True)  # fmt: skip
    t = 0.025
    now = path.at(t)
    state = float_state(model, now.q.tolist(), now.u.tolist(), t)
    moving = motion(model, state, active)

    def pose(name, time):
        q = path.at(time).q.tolist()
        found = poses(model, float_state(model, q, t=time))[name]
        return np.array(found.rotation, float), np.array(found.position, float)

    def derivative(f, time):
        return sum(c * f(time + k * H) for k, c in STENCIL.items()) / H

    forces = {name: [] for name in (*model.bodies, "ground")}
    couples = {name: [] for name in forces}
    for body, at, force in teeth(model, state, moving.multipliers):
        forces[body.name].append((at, force))
    for name, (force, moment) in all_reactions(model, state, moving).items():
        joint = model.joints[name]
        at = np.array(link_postures(model, state)[joint.links[-1]].position, float)
        for body, sign in ((joint.child, 1), (joint.parent, -1)):
            forces[body].append((at, sign * np.array(force, float)))
            couples[body].append(sign * np.array(moment, float))
    drive = s.loads["drive"].joint
    last = model.joints[drive.name].links[-1]
    axis = np.array(link_postures(model, state)[last].rotation, float) @ np.array(
        [float(x) for x in model.links[last].axis]
    )
    couples[drive.child.name].append(3 * axis)
    couples[drive.parent.name].append(-3 * axis)
    g = np.array([1, -9.81, 2])
    for name, place in model.bodies.items():
        m, c = float(place.mass), np.array(place.center, float)
        J = np.array([[float(x) for x in row] for row in place.inertia])
        # the place of the centre is given in the link, the pose that of the body
        c = c - np.array(place.origin, float)

        def centre(time, name=name, c=c):
            R, p = pose(name, time)
            return p + R @ c

        def momentum(time, name=name, J=J):
            R, _ = pose(name, time)
            turn = derivative(lambda when: pose(name, when)[0], time) @ R.T
            w = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
            return R @ (J @ (R.T @ w))

        acceleration = derivative(lambda when, f=centre: derivative(f, when), t)
        total = m * g + sum((f for _, f in forces[name]), np.zeros(3))
        arms = sum((np.cross(at - centre(t), f) for at, f in forces[name]), np.zeros(3))
        moment = arms + sum(couples[name], np.zeros(3))
        size = m * 9.81 + sum(np.abs(f).max() for _, f in forces[name]) + abs(moment).max()
        # differences of the fourth order of motions at some 10 rad/s, H² of round-off
        assert np.abs(total - m * acceleration).max() < 1e-6 * size
        assert np.abs(moment - derivative(momentum, t)).max() < 1e-6 * size


def test_teeth_push_apart_whichever_flank_bears(geared):
    """Turned round, a load turns round the tangential force; the smaller wheel is pressed to its axis."""
    _, model, state, active = geared
    lam = [float(x) for x in motion(model, state, active).multipliers]
    there, back = teeth(model, state, lam), teeth(model, state, [-x for x in lam])
    for k, row in enumerate(rows(model)):
        gear = model.constraints[row.owner]
        arms = {}
        for joint, (_, at, force), (_, _, other) in zip(
            (gear.first, gear.second), there[2 * k : 2 * k + 2], back[2 * k : 2 * k + 2], strict=True
        ):
            apart, along = (force + other) / 2, (force - other) / 2
            size = np.linalg.norm(along)
            assert abs(apart @ along) < 64 * EPS * size**2
            assert np.linalg.norm(apart) == pytest.approx(math.tan(ANGLE) * size, rel=1e-12)
            if joint.type == "hinge":
                axis = np.array(
                    link_postures(model, state)[model.joints[joint.name].links[0]].position, float
                )
                arms[np.linalg.norm(axis - at)] = (axis - at) @ apart
        assert arms[min(arms)] > 0
