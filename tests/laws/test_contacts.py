"""Laws of contacts: rates are derivatives of gaps, forces act through the same rows, bodies are in balance."""

import numpy as np
import pytest

import freebody as fb
from freebody.describe.loads.action import PointForce
from freebody.dynamics import float_state, mass_matrix, polynomial_state, poses, traced_state
from freebody.dynamics.conditions.constrained import independent_rows
from freebody.dynamics.conditions.constraints import residuals
from freebody.dynamics.conditions.contact import contact_layout, contact_rows, row_of, rows_of, touches
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.contact_motion import contact_forces, contact_problem, friction_power, in_modes
from freebody.dynamics.kinematics import (
    Spot,
    accelerations,
    coordinate_rates,
    point_acceleration,
    point_position,
    velocities,
)
from freebody.dynamics.motion import all_reactions, motion, total_power
from freebody.dynamics.state import State
from freebody.scalar.polynomial import Ring
from freebody.scalar.series import Series, SeriesField
from freebody.scalar.trace import Tape
from freebody.testing import polynomial_value, random_inertia, state_values

EPS = np.finfo(float).eps

# Every pair of shapes, on two bodies that move freely: (feature of a, surface of b).
SPATIAL = {
    "point on plane": lambda a, b: (a.point(0.1, 0.2, -0.3), b.plane(at=(0.1, 0, 0.2), normal=(1, 2, -2))),
    "sphere on plane": lambda a, b: (a.sphere(0.3, at=(0.1, 0, 0)), b.plane(normal="-z")),
    "disk's edge on plane": lambda a, b: (a.circle(0.4, at=(0, 0.1, 0), axis=(2, 1, 2)), b.plane(normal="y")),
    "point on sphere": lambda a, b: (a.point(0.1, 0.2, -0.3), b.sphere(0.7, at=(0.1, 0, 0.2))),
    "sphere on sphere": lambda a, b: (a.sphere(0.3), b.sphere(0.7, at=(0.1, 0, 0.2))),
    "sphere in bowl": lambda a, b: (a.sphere(0.3), b.sphere(7, at=(0.1, 0, 0.2), inside=True)),
    "point on cylinder": lambda a, b: (a.point(0.1, 0.2, -0.3), b.cylinder(0.7, axis=(1, 2, 2))),
    "sphere in pipe": lambda a, b: (a.sphere(0.2), b.cylinder(9, axis="x", inside=True)),
    "disk's wall on point": lambda a, b: (a.circle(0.2, at=(0, 0, 0.1)), b.point(0.1, 0, 0)),
    "disk's wall on sphere": lambda a, b: (a.cylinder(0.2, axis="y"), b.sphere(0.5, at=(0.1, 0, 0))),
    "side on point": lambda a, b: (a.segment((-1, 0.1, 0), (1, 0.1, 0), normal="y"), b.point(0.2, 0, 0)),
    "side on sphere": lambda a, b: (a.segment((-1, 0, 0), (1, 0, 0), normal="-z"), b.sphere(0.5)),
    "sphere on side": lambda a, b: (a.sphere(0.5), b.segment((-1, 0, 0), (1, 0, 0), normal="-z")),
    "plane on point": lambda a, b: (a.plane(normal="x"), b.point(0.3, 0.1, 0)),
}
PLANAR = {
    "circle on circle": lambda a, b: (a.circle(0.3), b.circle(0.4, at=(0.1, 0, 0))),
    "circle in circle": lambda a, b: (a.circle(0.3, at=(0, 0.1, 0)), b.circle(8, inside=True)),
    "cylinder on circle": lambda a, b: (a.cylinder(0.3, axis="-z"), b.circle(0.4)),
    "circle on side": lambda a, b: (a.circle(0.3), b.segment((0, -1, 0), (0, 1, 0), normal="x")),
    "side on circle": lambda a, b: (a.segment((0, -1, 0), (0, 1, 0), normal="x"), b.circle(0.3)),
    "circle on plane": lambda a, b: (a.circle(0.3), b.plane(normal=(3, 4, 0))),
    "point on circle": lambda a, b: (a.point(0.1, 0.2, 0), b.circle(0.3)),
}


def two_bodies(pair, planar=False, **laws):
    rng = np.random.default_rng(11)
    s = fb.System("two bodies")
    s.gravity = (0, -9.81, 0)
    bodies = [
        s.body(name, fb.MassProperties(1.5, rng.normal(size=3).tolist(), random_inertia(rng)))
        for name in "ab"
    ]
    for body in bodies:
        if planar:
            s.planar(f"j{body.name}", s.ground, body, coordinate=[f"{c}{body.name}" for c in "xyf"])
        else:
            s.free(f"j{body.name}", s.ground, body)
    s.contact("c", *pair(*bodies), **{"friction": 0.3, **laws})
    return fb.assemble(s)


def at_random(model, seed=3, spread=1):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=model.n_q) * spread
    for start in model.quaternions:
        q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
    return float_state(model, q.tolist(), rng.normal(size=model.n_u).tolist(), t=0.3)


def of_drives(state):
    """Rates of the contacts without speeds: the part of driven joints."""
    still = float_state(state.model, list(state.q), [0.0] * state.model.n_u, t=state.t)
    return np.array(contact_rows(state.model, still).rate, dtype=float)


def along(state, udot):
    """The state as a series of second order along the motion with constant u'."""
    model = state.model
    one, two = SeriesField(state.field, 1), SeriesField(state.field, 2)
    u = [one.series([a, b]) for a, b in zip(state.u, udot, strict=True)]
    first = coordinate_rates(model, state)
    q = [one.series([a, b]) for a, b in zip(state.q, first, strict=True)]
    moving = State(model, one, one.series([state.t, 1]), q, u, state.values)
    taylor = [
        two.series([a, b, r.c[1] / 2 if isinstance(r, Series) else 0])
        for a, b, r in zip(state.q, first, coordinate_rates(model, moving), strict=True)
    ]
    u = [two.series([a, b]) for a, b in zip(state.u, udot, strict=True)]
    return State(model, two, two.series([state.t, 1]), taylor, u, state.values)


@pytest.mark.parametrize("planar,name", [(False, n) for n in SPATIAL] + [(True, n) for n in PLANAR])
def test_rates_are_derivatives_of_the_gap(planar, name):
    model = two_bodies((PLANAR if planar else SPATIAL)[name], planar)
    contact = model.contacts[0]
    assert contact.tangents == (1 if planar else 2)
    state = at_random(model)
    udot = np.random.default_rng(5).normal(size=model.n_u)
    rows = contact_rows(model, state)
    W = np.array(rows.matrix, dtype=float)
    rate = W @ state.u + of_drives(state)
    assert rate == pytest.approx(rows.rate, rel=1e-13, abs=64 * EPS)
    moving = along(state, udot)
    gap = touches(model, moving)[0].gap
    second = W @ udot + np.array(rows.bias, dtype=float)
    assert gap.derivative(1) == pytest.approx(rate[0], rel=1e-11, abs=1e-13)
    assert gap.derivative(2) == pytest.approx(second[0], rel=1e-11, abs=1e-12)
    # the slip velocity along the motion
    for k, slip in enumerate(contact_rows(model, moving).rate[1:], start=1):
        assert slip.derivative(1) == pytest.approx(second[k], rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("planar,name", [(False, n) for n in SPATIAL] + [(True, n) for n in PLANAR])
def test_geometry_is_of_unit_vectors_and_nearest_points(planar, name):
    model = two_bodies((PLANAR if planar else SPATIAL)[name], planar)
    it = touches(model, at_random(model))[0]
    n, P, Q = (np.array(v, dtype=float) for v in (it.normal, it.on_feature, it.on_surface))
    assert pytest.approx(it.gap * n, abs=32 * EPS * (1 + abs(P).max())) == P - Q
    frame = np.array([*it.tangents, n], dtype=float)
    if planar:
        frame = np.vstack([frame, model.contacts[0].planar])
        # t = n × k: (t, n, k) is right-handed
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=16 * EPS)
    assert np.linalg.det(frame) == pytest.approx(1, abs=16 * EPS)


def test_feature_and_surface_may_trade_places():
    for name in ("sphere on plane", "point on sphere", "side on point"):
        pair = SPATIAL[name]
        one = two_bodies(pair)
        other = two_bodies(lambda a, b, pair=pair: tuple(reversed(pair(a, b))))
        a, b = (touches(m, at_random(m))[0] for m in (one, other))
        assert a.gap == pytest.approx(b.gap, rel=1e-14)
        assert np.array(a.normal, dtype=float) == pytest.approx(-np.array(b.normal, dtype=float))
        assert np.array(a.on_feature, dtype=float) == pytest.approx(np.array(b.on_surface, dtype=float))


def test_power_of_contact_forces_is_force_times_rate():
    model = two_bodies(SPATIAL["disk's edge on plane"])
    contact, *_ = model.contacts
    state = at_random(model)
    it = touches(model, state)[0]
    N, T1, T2 = 2.0, -0.7, 0.4
    force = sum(
        x * np.array(e, dtype=float) for x, e in zip((N, T1, T2), (it.normal, *it.tangents), strict=True)
    )
    pair = [
        PointForce(Spot(contact.feature.body, it.on_feature), tuple(force)),
        PointForce(Spot(contact.surface.body, it.on_surface), tuple(-force)),
    ]
    power = np.dot(row_of(model, state, pair, contact), state.u)
    assert power == pytest.approx(np.dot((N, T1, T2), contact_rows(model, state).rate[:3]), rel=1e-13)


def closed(model, modes, seed=3):
    """A model in modes at a state that satisfies them: coordinates by Newton steps, speeds by projection."""
    from freebody.dynamics.conditions.constrained import closed_coordinates, speed_correction

    held = in_modes(model, modes)
    start = at_random(held, seed)
    q = closed_coordinates(held, start.q, t=start.t)
    state = float_state(held, q, list(start.u), t=start.t)
    active = independent_rows(held, state)
    u = speed_correction(held, state, active)
    return held, float_state(held, q, list(u), t=start.t), active


@pytest.mark.parametrize(
    "name", ["sphere on plane", "disk's edge on plane", "point on sphere", "sphere in pipe", "side on sphere"]
)
@pytest.mark.parametrize("mode", ["stick", "slip"])
def test_motion_in_a_mode_satisfies_its_equations(name, mode):
    model = two_bodies(SPATIAL[name])
    held, state, active = closed(model, {"c": mode})
    assert np.abs(np.array(residuals(held, state), dtype=float)).max() < 1e-12
    moving = motion(held, state, active)
    # the first element; a side has its ends besides
    rows = rows_of(held, state, held.contacts[:1])
    W, b = np.array(rows.matrix, dtype=float), np.array(rows.bias, dtype=float)
    acceleration = W @ np.array(moving.udot, dtype=float) + b
    size = 1e-11 * (1 + np.abs(b).max())
    assert abs(acceleration[0]) < size
    forces = np.array(contact_forces(held, state, moving.multipliers)["c"], dtype=float)
    slip = np.array(rows.rate[1:], dtype=float)
    if mode == "stick":
        assert np.abs(acceleration[1:]).max() < size
        assert np.abs(slip).max() < 1e-13
    else:
        # T = -μ N γ/|γ|
        assert forces[1:] == pytest.approx(-0.3 * forces[0] * slip / np.linalg.norm(slip), rel=1e-12)
    power = float(friction_power(held, state, contact_forces(held, state, moving.multipliers)))
    assert power == pytest.approx(float(forces[1:] @ slip), abs=1e-14)
    assert float(total_power(held, state, moving)) == pytest.approx(power, rel=1e-12, abs=1e-13)
    # M u' = f + Wᵀ λ with the same forces
    problem = contact_problem(model, state)
    udot = np.array(problem.free) + np.array(problem.responses[:3]).T @ forces
    assert np.array(moving.udot, dtype=float) == pytest.approx(udot, rel=1e-9, abs=1e-10)
    A = np.array(problem.A, dtype=float)
    assert pytest.approx(A.T, rel=1e-10, abs=1e-12) == A
    assert (A[:, :3] @ forces + np.array(problem.c))[:3] == pytest.approx(acceleration, abs=1e3 * size)


@pytest.mark.parametrize("mode", ["stick", "slip"])
def test_every_body_is_in_balance_with_its_contact_forces(mode):
    """m a_C = m g + contact force, and Σ of both momenta changes by the weight alone."""
    model = two_bodies(SPATIAL["disk's edge on plane"])
    held, state, active = closed(model, {"c": mode})
    moving = motion(held, state, active)
    force = np.array(all_reactions(held, state, moving)["c"][0], dtype=float)
    contact = model.contacts[0]
    for body, sign in ((contact.feature.body, 1), (contact.surface.body, -1)):
        m = float(body.mass_properties.mass)
        a = np.array(point_acceleration(held, state, body.center, moving.udot), dtype=float)
        assert m * a == pytest.approx(sign * force + m * np.array([0, -9.81, 0]), rel=1e-9, abs=1e-10)


def test_drives_under_a_contact_enter_its_rates():
    """A ball on a table that is driven: slip is relative to the table, whose drive does the work."""
    s = fb.System("driven table")
    s.gravity = (0, -9.81, 0)
    table, ball = s.body("table", fb.box(1, (1, 1, 1))), s.body("ball", fb.sphere(1, 0.2))
    s.slider("shake", s.ground, table, axis="x", coordinate="sin(3*t)")
    s.free("air", s.ground, ball)
    s.contact("c", ball.sphere(0.2), table.plane(), friction=0.5)
    model = fb.assemble(s)
    state = at_random(model)
    rows = contact_rows(model, state)
    assert np.linalg.norm(of_drives(state)[1:]) == pytest.approx(3 * abs(np.cos(0.9)))
    moving = along(state, [0] * model.n_u)
    assert [x.derivative(1) for x in contact_rows(model, moving).rate[1:]] == pytest.approx(rows.bias[1:])
    held, state, active = closed(model, {"c": "stick"})
    there = motion(held, state, active)
    # the ball's centre moves with 2/7 of the table's acceleration while it rolls
    a = point_acceleration(held, state, model.contacts[0].feature.body.center, there.udot)
    assert float(a[0]) == pytest.approx(2 / 7 * -9 * np.sin(0.9), rel=1e-12)


def test_the_choice_of_frame_changes_nothing():
    """The same machine turned and moved as a whole: gap, forces and powers are the same."""
    rng = np.random.default_rng(8)
    turn = fb.Rotation.euler("XYZ", *rng.normal(size=3))
    shift = rng.normal(size=3)
    R = np.array(turn.matrix, dtype=float)
    found = []
    for moved in (False, True):
        s = fb.System("disk on plane")
        g, n, at = np.array([0, -9.81, 0]), np.array([0, 1, 0]), np.array([0.3, -0.2, 0.5])
        axes = {}
        if moved:
            g, n, at = R @ g, R @ n, R @ at + shift
            axes = {"at": tuple(shift), "parent_axes": turn}
        s.gravity = tuple(g)
        disk = s.body("disk", fb.disk(2, 0.3))
        s.free("air", s.ground, disk, **axes)
        s.contact("c", disk.circle(0.3), s.ground.plane(at=tuple(at), normal=tuple(n)), friction=0.3)
        model = fb.assemble(s)
        held, state, active = closed(model, {"c": "slip"})
        moving = motion(held, state, active)
        forces = np.array(contact_forces(held, state, moving.multipliers)["c"], dtype=float)
        gap = float(touches(model, at_random(model))[0].gap)
        found.append([gap, forces[0], np.linalg.norm(forces[1:]), float(total_power(held, state, moving))])
    assert found[0] == pytest.approx(found[1], rel=1e-9)


def test_order_of_declaration_changes_nothing():
    results = []
    for order in (1, -1):
        s = fb.System("two feet")
        s.gravity = (0, -9.81, 0)
        box = s.body("box", fb.box(3, (2, 1, 1)))
        s.planar("p", s.ground, box, coordinate="x y f")
        for name, x in [("left", -1), ("right", 1)][::order]:
            s.contact(name, box.point(x, -0.5, 0), s.ground.plane(), friction=0.2)
        model = fb.assemble(s)
        held, state, active = closed(model, {"left": "slip+", "right": "slip+"})
        moving = motion(held, state, active)
        forces = contact_forces(held, state, moving.multipliers)
        results.append([*forces["left"], *forces["right"], *moving.udot])
    assert results[0] == pytest.approx(results[1], rel=1e-12, abs=1e-13)


def test_sticking_of_a_round_feature_is_rolling():
    """A tilted disk that sticks to a plane moves as one that rolls on it by s.rolling, with the same force."""
    machines = []
    for rolls in (False, True):
        s = fb.System("disk")
        s.gravity = (0, -9.81, 0)
        disk = s.body("disk", fb.disk(2, 0.3))
        s.free("air", s.ground, disk)
        if rolls:
            s.rolling("c", disk, radius=0.3, axis="z")
        else:
            s.contact("c", disk.circle(0.3), s.ground.plane(), friction=1)
        machines.append(fb.assemble(s))
    held, state, active = closed(machines[0], {"c": "stick"})
    moving = motion(held, state, active)
    other = float_state(machines[1], list(state.q), list(state.u), t=state.t)
    assert linearized(machines[1], other).rate == pytest.approx([0, 0, 0], abs=1e-13)
    again = motion(machines[1], other, active)
    assert moving.udot == pytest.approx(again.udot, rel=1e-11, abs=1e-12)
    a, b = (
        all_reactions(m, x, y)["c"][0] for m, x, y in ((held, state, moving), (machines[1], other, again))
    )
    assert np.array(a, dtype=float) == pytest.approx(np.array(b, dtype=float), rel=1e-11)


def test_a_point_on_a_heightline():
    """On y = f(x) the normal is that of the curve, and ġ = g̈ = 0 along motions on it."""
    s = fb.System("hill")
    s.gravity = (0, -9.81, 0)
    bead = s.body("bead", fb.disk(2, 0.1))
    a, k = s.parameters(a=0.4, k=2)
    s.planar("p", s.ground, bead, coordinate="x y f")
    s.contact("hill", bead.point(0, 0, 0), s.ground.heightline("a*sin(k*x) + 0.1*x^3"), friction=0.3)
    model = fb.assemble(s)
    x, v = 0.7, 1.3
    f = 0.4 * np.sin(2 * x) + 0.1 * x**3
    slope, bend = 0.8 * np.cos(2 * x) + 0.3 * x**2, -1.6 * np.sin(2 * x) + 0.6 * x
    state = float_state(model, [x, f, 0.0], [v, slope * v, 0.4])
    rows = contact_rows(model, state)
    assert rows.gap[0] == pytest.approx(0, abs=EPS)
    root = np.sqrt(1 + slope**2)
    assert rows.rate == pytest.approx([0, v * root], abs=4 * EPS)
    # y'' = f' x'' + f'' x'²
    assert rows.bias[0] == pytest.approx(-bend * v**2 / root, rel=1e-13)
    held = in_modes(model, {"hill": "slip+"})
    state = float_state(held, [x, f, 0.0], [v, slope * v, 0.4])
    N = contact_forces(held, state, motion(held, state, (0,)).multipliers)["hill"][0]
    # along the normal: N - m g cos = m v²/ρ
    assert pytest.approx(2 * (9.81 / root + bend * v**2 / root), rel=1e-12) == N


def test_a_foot_beyond_the_end_of_a_side_is_told():
    s = fb.System("ledge")
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.planar("p", s.ground, ball, coordinate="x y f")
    s.contact("top", ball.origin, s.ground.segment((0, 0, 0), (2, 0, 0), normal="y"))
    model = fb.assemble(s)
    for x, inside in ((-0.5, False), (0.5, True), (2.5, False)):
        reach = touches(model, float_state(model, [x, 1.0, 0.0]))[0].reach
        assert reach == pytest.approx((x, 2 - x))
        assert all(r >= 0 for r in reach) == inside


@pytest.mark.parametrize("mode", ["stick", "slip+"])
def test_all_scalars_agree(mode):
    """Floats, recorded programs and polynomials give the same rows and the same motion."""
    model = two_bodies(PLANAR["circle on plane"], planar=True)
    held, state, active = closed(model, {"c": mode})
    moving = motion(held, state, active)
    tape = Tape()
    traced = traced_state(held, tape)
    inputs = {"t": state.t, **dict(zip(held.coordinate_names, state.q, strict=True))}
    inputs |= dict(zip(held.speed_names, state.u, strict=True))
    recorded = motion(held, traced, active)
    values = tape.evaluate([*recorded.udot, *recorded.multipliers], inputs)
    assert values == pytest.approx([*moving.udot, *moving.multipliers], rel=1e-12, abs=1e-13)
    ring = Ring(capacity=80)
    exact = polynomial_state(held, ring)
    rows, numbers = contact_rows(held, exact), contact_rows(held, state)
    at = state_values(held, state.q, state.u, state.t)
    for a, b in zip(rows.rate + rows.bias, numbers.rate + numbers.bias, strict=True):
        assert polynomial_value(a, at) == pytest.approx(b, rel=1e-11, abs=1e-12)


def test_a_machine_with_constraints_of_its_own():
    """A bar on two guides that leans against a wall: contact problem and motion in modes agree."""
    s = fb.System("ladder on a rail")
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar(2, 2, axis="x"))
    s.planar("p", s.ground, bar, coordinate="x y f")
    s.constrain("y - sin(f)", name="rail")
    s.contact("wall", bar.point(1, 0, 0), s.ground.plane(at=(1, 0, 0), normal="-x"), friction=0.3)
    model = fb.assemble(s)
    q = [1 - np.cos(0.7), np.sin(0.7), 0.7]
    own = float_state(model, q, [0.0, 0.0, 0.0])
    active = independent_rows(model, own)
    problem = contact_problem(model, own, active)
    held = in_modes(model, {"wall": "stick"})
    state = float_state(held, q, [0.0, 0.0, 0.0])
    kept = independent_rows(held, state)
    moving = motion(held, state, kept)
    forces = np.array(contact_forces(held, state, moving.multipliers)["wall"], dtype=float)
    udot = np.array(problem.free) + np.array(problem.responses).T @ forces
    assert udot == pytest.approx(np.array(moving.udot, dtype=float), rel=1e-10, abs=1e-11)


def test_names_and_layout():
    model = two_bodies(SPATIAL["sphere on plane"])
    assert [(row.name, row.kind, row.contact) for row in contact_layout(model.contacts)] == [
        ("N_c", "N", 0),
        ("T1_c", "T", 0),
        ("T2_c", "T", 0),
    ]
    assert poses(model, at_random(model)).keys() == {"a", "b"}
    assert np.linalg.eigvalsh(np.array(mass_matrix(model, at_random(model)), dtype=float)).min() > 0


@pytest.mark.parametrize("mode", ["stick", "slip"])
def test_joints_carry_what_contacts_put_on_the_machine(mode):
    """An arm of three links whose tip touches a wall: every link is in balance, forces and moments, joints included."""
    rng = np.random.default_rng(4)
    s = fb.System("arm at a wall")
    s.gravity = (0, 0, -9.81)
    parent, joints = s.ground, []
    for i, axis in enumerate("zyx"):
        body = s.body(
            f"link{i}", fb.MassProperties(1.0 + i, rng.normal(size=3).tolist(), random_inertia(rng))
        )
        make = s.ball if i == 1 else s.hinge
        options = {} if i == 1 else {"axis": axis, "coordinate": f"q{i}"}
        joints.append(make(f"j{i}", parent, body, at=(0.5, 0.1, 0), to=(-0.5, 0, 0.1), **options))
        parent = body
    s.contact(
        "wall",
        parent.sphere(0.2, at=(0.5, 0, 0)),
        s.ground.plane(at=(1.1, 0, 0), normal=(-3, 0, 4)),
        friction=0.4,
    )
    model = fb.assemble(s)
    held, state, active = closed(model, {"wall": mode}, seed=2)
    moving = motion(held, state, active)
    found = all_reactions(held, state, moving)
    contact = model.contacts[0]
    spot = np.array(touches(held, state)[0].on_feature, dtype=float)
    carried = [np.array(found[f"j{i}"], dtype=float) for i in range(3)]
    points = [np.array(point_position(held, state, j.child.point(*j.to)), dtype=float) for j in joints]
    for i in range(3):
        body = s.bodies[f"link{i}"]
        place = held.bodies[body.name]
        m, center = float(place.mass), np.array(point_position(held, state, body.center), dtype=float)
        a = np.array(point_acceleration(held, state, body.center, moving.udot), dtype=float)
        force, moment = carried[i].copy()
        moment += np.cross(points[i] - center, force)
        if i < 2:
            force -= carried[i + 1][0]
            moment -= carried[i + 1][1] + np.cross(points[i + 1] - center, carried[i + 1][0])
        if body is contact.feature.body:
            push = np.array(found["wall"][0], dtype=float)
            force += push
            moment += np.cross(spot - center, push)
        assert force + m * np.array([0, 0, -9.81]) == pytest.approx(m * a, rel=1e-9, abs=1e-9)
        R = np.array(poses(held, state)[body.name].rotation, dtype=float)
        inertia = np.array(place.inertia, dtype=float)
        w = np.array(velocities(held, state)[place.link][0], dtype=float)
        wdot = np.array(accelerations(held, state, moving.udot)[place.link][0], dtype=float)
        rate = R @ (inertia @ wdot + np.cross(w, inertia @ w))
        assert moment == pytest.approx(rate, rel=1e-9, abs=1e-9)
