"""Simulation of constrained machines: they stay closed to round-off, keep their energy, and obey closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics.conditions.linearized import linearized
from freebody.dynamics.state import float_state
from freebody.errors import SimulationError

EPS = np.finfo(float).eps
TOLERANCE = 1e-10
# an answer after a run: some hundred steps, each right to TOLERANCE
MOTION = 1e-7


def missed(found):
    """Greatest residual and rate of all conditions, redundant ones too, over the output times."""
    model = found.kernels.model
    worst = 0.0
    for t, y in zip(found.t, found.states, strict=True):
        q, u = y[: model.n_q].tolist(), y[model.n_q : model.n_q + model.n_u].tolist()
        given = linearized(model, float_state(model, q, u, float(t), found.values))
        size = 1 + max(abs(x) for x in (*q, *u))
        # a residual of 0 is an int
        worst = max(worst, *(abs(float(x)) / size for x in (*given.residual, *given.rate)))
    return worst


def four_bar(lengths=(1, 2, 1.5, 2), gravity=9.81):
    a, b, c, d = lengths
    s = fb.System("four-bar")
    s.gravity = (0, -gravity, 0)
    crank, rod, rocker = (
        s.body(n, fb.slender_bar(x, x)) for n, x in (("crank", a), ("rod", b), ("rocker", c))
    )
    s.hinge("A", s.ground, crank, to=(-a / 2, 0, 0), coordinate="a")
    s.hinge("B", crank, rod, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), coordinate="b")
    s.hinge("D", s.ground, rocker, at=(d, 0, 0), to=(-c / 2, 0, 0), coordinate="d")
    s.hinge("C", rocker, rod, at=(c / 2, 0, 0), to=(b / 2, 0, 0))
    return s


@pytest.mark.parametrize("tolerance", [1e-3, 1e-7, 1e-12])
def test_four_bar_stays_closed_whatever_the_tolerance(tolerance):
    found = fb.simulate(four_bar(), 5, initial={"a": 0.3}, near={"b": 0.4, "d": 0.9}, tolerance=tolerance)
    assert missed(found) < 100 * EPS
    assert np.ptp(found["a"]) > 1
    assert found.energy.relative_residual < max(300 * tolerance, 1e-13)
    # also between the steps and at the events
    assert (
        missed(fb.simulate(four_bar(), 5, initial={"a": 0.3}, near={"b": 0.4, "d": 0.9}, samples=7))
        < 100 * EPS
    )


def test_four_bar_against_its_one_equation_of_motion():
    """Energy as a function of the crank's angle and rate: ½ J(a) a'² + V(a) is constant, with J by finite differences
    of the closed form of the linkage."""
    found = fb.simulate(four_bar(), 2, initial={"a": 0.3}, near={"b": 0.4, "d": 0.9}, tolerance=1e-12)

    def places(a):
        B = np.exp(1j * a)
        line = B - 2
        f = abs(line)
        C = 2 + 1.5 * np.exp(1j * (np.angle(line) - np.arccos((f**2 + 1.5**2 - 4) / (3 * f))))
        return B, C

    a, h = found["a"], 1e-5
    (B0, C0), (B, C), (B1, C1) = (places(a + k) for k in (-h, 0, h))
    vB, vC = (B1 - B0) / (2 * h), (C1 - C0) / (2 * h)
    inertia = (
        1 / 3 * abs(vB) ** 2
        + 2 / 3 * (abs(vB) ** 2 + (vB * vC.conj()).real + abs(vC) ** 2)
        + 0.5 * abs(vC) ** 2
    )
    potential = 9.81 * (B.imag / 2 + (B + C).imag + 1.5 * C.imag / 2)
    energy = inertia * found["a'"] ** 2 / 2 + potential
    assert energy == pytest.approx(energy[0], abs=1e-8 * 9.81 * 4)


def test_rope_pendulum_is_a_hinge_pendulum():
    g, L = 9.81, 1.3
    hinge = fb.System("hinge")
    hinge.gravity = (0, -g, 0)
    weight = hinge.body("bob", fb.particle(2))
    hinge.hinge("pin", hinge.ground, weight, to=(0, L, 0), coordinate="theta")
    start = math.radians(70)
    times = np.linspace(0, 6, 50)
    a = fb.simulate(hinge, 6, initial={"theta": start}, tolerance=1e-12, times=times)
    disk = fb.System("rope with a disk")
    disk.gravity = (0, -g, 0)
    ball = disk.body("ball", fb.sphere(2, 0.1))
    disk.planar("plane", disk.ground, ball, coordinate="x y turn")
    disk.rope([disk.ground.origin, ball.origin], L)
    b = fb.simulate(disk, 6, initial={"x": L * math.sin(start)}, near={"y": -L}, tolerance=1e-12, times=times)
    assert b["x"] == pytest.approx(L * np.sin(a["theta"]), abs=MOTION)
    assert b["y"] == pytest.approx(-L * np.cos(a["theta"]), abs=MOTION)
    assert np.hypot(b["x"], b["y"]) == pytest.approx(L, rel=4 * EPS)
    # tension = m g cos + m L theta'^2 = pull of the hinge
    assert b.multipliers["rope"] == pytest.approx(np.linalg.norm(a.reactions["pin"].force, axis=1), abs=1e-5)


def test_slider_crank_follows_the_closed_form():
    """A free crank: x = r cos a + sqrt(L² - r² sin² a) along the whole motion."""
    r, L = 0.4, 1.1
    s = fb.System("slider-crank")
    crank, rod, piston = (
        s.body("crank", fb.slender_bar(1, r)),
        s.body("rod", fb.slender_bar(2, L)),
        s.body("p", fb.particle(3)),
    )
    s.hinge("shaft", s.ground, crank, to=(-r / 2, 0, 0), coordinate="a")
    s.hinge("pin", crank, rod, at=(r / 2, 0, 0), to=(-L / 2, 0, 0), coordinate="b")
    s.slider("bore", s.ground, piston, coordinate="x")
    s.hinge("wrist", rod, piston, at=(L / 2, 0, 0))
    for side in (1, -1):  # the branch is that of near
        found = fb.simulate(
            s,
            3,
            initial={"a": 1.0, "a'": 5},
            near={"x": side * L, "b": -1.4 if side > 0 else 2.5},
            tolerance=1e-11,
        )
        a = found["a"]
        assert found["x"] == pytest.approx(
            r * np.cos(a) + side * np.sqrt(L**2 - r**2 * np.sin(a) ** 2), abs=1e-13
        )
        assert a[-1] > 2 * math.pi
        assert missed(found) < 100 * EPS
        # only the forces out of the plane are open; the side force of the bore is not
        assert "bore_z" in found.indeterminate and "bore_y" not in found.indeterminate


def test_disk_rolls_down_an_incline():
    """(6.54): a = 2/3 g sin, N = m g cos, T = m g sin / 3; the contact's moment about the centre is R T."""
    m, R, g, slope = 5.0, 0.25, 9.81, math.radians(25)
    s = fb.System("incline")
    s.gravity = (g * math.sin(slope), -g * math.cos(slope), 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, coordinate="x y turn")
    s.rolling("contact", disk, radius=R, axis="z")
    found = fb.simulate(s, 2, near={"y": R}, method="dop853")  # exact for a parabola
    assert found["x"] == pytest.approx(g * math.sin(slope) / 3 * found.t**2, rel=1e-12)
    assert found["turn"] == pytest.approx(-found["x"] / R, abs=1e-12)
    friction, normal = -m * g * math.sin(slope) / 3, m * g * math.cos(slope)
    contact = found.reactions["contact"]
    assert contact.force == pytest.approx(np.tile([friction, normal, 0], (len(found.t), 1)), abs=1e-11)
    assert contact.moment == pytest.approx(np.tile([0, 0, R * friction], (len(found.t), 1)), abs=1e-11)
    assert contact.on == "disk" and "centre of the wheel" in contact.about
    assert found.multipliers["contact_y"] == pytest.approx(normal)
    # the plane of the joint and the contact both keep the disk from sliding sideways
    assert "contact_z" in found.indeterminate and "contact_y" not in found.indeterminate
    assert found.energy.relative_residual < 1e-13


def free_wheel(body, radius, axis="z", gravity=(0, 0, -9.81)):
    s = fb.System("wheel")
    s.gravity = gravity
    wheel = s.body("wheel", body)
    s.free("air", s.ground, wheel)
    s.rolling("contact", wheel, radius=radius, axis=axis, normal="z")
    return s


@pytest.mark.parametrize(
    ("body", "k"), [(fb.disk(2, 0.3), 1 / 2), (fb.ring(2, 0.3), 1)], ids=["disk", "hoop"]
)
def test_steady_turn_of_a_thin_wheel(body, k):
    """Axial inertia k m R², transverse half of it:  Ω² R n c k/2 = (1 + k) R Ω ω_3 c + g n  gives the spin ω_3.

    n, c: sine and cosine of the axle's angle above the horizontal.
    """
    R, g, angle, turn = 0.3, 9.81, 0.35, 1.5
    n, c = math.sin(angle), math.cos(angle)
    w3 = (turn**2 * n * c * k / 2 - g * n / R) / ((1 + k) * turn * c)
    tilt = angle - math.pi / 2
    start = {
        "air": fb.Rotation.euler("XYZ", tilt, 0, 0), "air_wx": 0, "air_wy": turn * math.sin(tilt), "air_wz": w3,
    }  # fmt: skip
    found = fb.simulate(free_wheel(body, R), 5, initial=start, near={"air_z": R}, tolerance=1e-12)
    axle = found.poses["wheel"].rotation[:, :, 2]
    assert axle[:, 2] == pytest.approx(n, abs=1e-9)
    heading = np.unwrap(np.arctan2(axle[:, 1], axle[:, 0]))
    assert heading - heading[0] == pytest.approx(turn * found.t, abs=MOTION)
    assert found["air_z"] == pytest.approx(R * c, abs=1e-9)
    # centripetal force and weight
    force = found.reactions["contact"].force
    assert force[:, 2] == pytest.approx(2 * g, abs=1e-7)
    assert np.hypot(force[:, 0], force[:, 1]) == pytest.approx(2 * R * abs(w3) * turn, abs=1e-7)
    assert missed(found) < 100 * EPS


def test_sphere_on_a_plane_runs_straight_whatever_its_spin():
    """Rolling on a level plane: the centre moves uniformly, the contact carries the weight only."""
    s = free_wheel(fb.sphere(3, 0.2), 0.2, axis=None)
    found = fb.simulate(
        s, 3, initial={"air_wx": 2, "air_wy": -1, "air_wz": 5}, near={"air_z": 0.2}, tolerance=1e-12
    )
    # v = ω × R z
    assert found["air_x"] == pytest.approx(-0.2 * found.t, abs=1e-9)
    assert found["air_y"] == pytest.approx(-0.4 * found.t, abs=1e-9)
    assert found.reactions["contact"].force == pytest.approx(
        np.tile([0, 0, 3 * 9.81], (len(found.t), 1)), abs=1e-8
    )


def test_sphere_down_an_incline():
    """5/7 g sin for a full sphere, 3/5 g sin for a shell."""
    for body, share in ((fb.sphere(3, 0.2), 5 / 7), (fb.spherical_shell(3, 0.2), 3 / 5)):
        found = fb.simulate(free_wheel(body, 0.2, axis=None, gravity=(4, 0, -9)), 1, near={"air_z": 0.2})
        assert found["air_x"][-1] == pytest.approx(share * 4 / 2, rel=1e-9)
        assert found.reactions["contact"].force[-1, 0] == pytest.approx(-3 * 4 * (1 - share), rel=1e-9)


def test_two_gears_and_a_rack():
    s = fb.System("rack")
    pinion, rack = s.body("pinion", fb.disk(2, 0.1)), s.body("rack", fb.particle(3))
    turn = s.hinge("turn", s.ground, pinion, coordinate="f")
    slide = s.slider("slide", s.ground, rack, coordinate="x")
    s.gear(slide, turn, 0.1, name="teeth")
    s.torque("motor", turn, 1)
    found = fb.simulate(s, 1)
    acceleration = 1 / (2 * 0.01 / 2 + 3 * 0.01)
    assert found["f"][-1] == pytest.approx(acceleration / 2)
    assert found["x"] == pytest.approx(0.1 * found["f"], abs=1e-15)
    assert found.multipliers["teeth"] == pytest.approx(3 * 0.1 * acceleration)


def test_a_driven_shaft_feels_its_gear():
    """Its torque is that of its own inertia and of what the gear drives; the ledger closes."""
    s = fb.System("driven gear")
    a, b = s.body("a", fb.disk(1, 1)), s.body("b", fb.disk(4, 2))
    first = s.hinge("first", s.ground, a, coordinate=s.t**2)
    second = s.hinge("second", s.ground, b, at=(3, 0, 0), coordinate="q")
    s.gear(second, first, -0.5, name="mesh")
    found = fb.simulate(s, 2)
    # a: 2 rad/s² × 1/2;  b: -1 rad/s² × 8, felt with the ratio 1/2
    assert found.reactions["first"].moment[:, 2] == pytest.approx(1 + 8 * 0.5)
    assert found["q"][-1] == pytest.approx(-2)
    assert found.energy.work[-1] == pytest.approx(found.energy.kinetic[-1])
    assert found.energy.relative_residual < 1e-8


def test_a_driven_loop_keeps_the_ledger():
    s = fb.System("driven loop")
    s.gravity = (0, -9.81, 0)
    crank, rod, rocker = (
        s.body(n, fb.slender_bar(x, x)) for n, x in (("crank", 1), ("rod", 2), ("rocker", 1.5))
    )
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), coordinate=3 * s.t + 0.3)
    s.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-1, 0, 0), coordinate="b")
    s.hinge("D", s.ground, rocker, at=(2, 0, 0), to=(-0.75, 0, 0), coordinate="d")
    s.hinge("C", rocker, rod, at=(0.75, 0, 0), to=(1, 0, 0))
    found = fb.simulate(s, 2, near={"b": 0.4, "d": 0.9}, tolerance=TOLERANCE)
    assert np.ptp(found.energy.work) > 1
    assert found.energy.relative_residual < 1e-8
    assert missed(found) < 100 * EPS


def test_block_and_tackle():
    s = fb.System("tackle")
    s.gravity = (0, -9.81, 0)
    a, b = s.body("a", fb.sphere(3, 0.1)), s.body("b", fb.sphere(1, 0.1))
    s.slider("left", s.ground, a, axis="-y", coordinate="p")
    s.slider("right", s.ground, b, at=(1, 0, 0), axis="-y", coordinate="q")
    s.rope([s.ground.origin, a.origin, s.ground.origin, s.ground.point(1, 0, 0), b.origin], 6)
    found = fb.simulate(s, 1, initial={"p": 1}, near={"q": 1})
    assert found["q"][0] == pytest.approx(3)
    assert found["p"][-1] == pytest.approx(1 + 9.81 / 7 / 2)
    assert found.multipliers["rope"] == pytest.approx(9.81 * (1 + 2 / 7))


def test_a_rope_that_is_hauled_in_does_work():
    """A weight drawn up by a winch at constant speed: tension m g, work m g h."""
    s = fb.System("winch")
    s.gravity = (0, -9.81, 0)
    weight = s.body("weight", fb.particle(2))
    s.slider("rail", s.ground, weight, axis="-y", coordinate="depth")
    s.rope([s.ground.origin, weight.origin], 10 - s.t / 2)
    found = fb.simulate(s, 4, near={"depth": 9})
    assert found["depth"] == pytest.approx(10 - found.t / 2)
    assert found.multipliers["rope"] == pytest.approx(2 * 9.81)
    assert found.energy.work == pytest.approx(9.81 * found.t)
    assert found.energy.relative_residual < 1e-13


def test_a_condition_with_a_clock_does_work():
    """A bead on a rotating straight wire, r'' = w² r: r = r_0 cosh wt."""
    s = fb.System("wire")
    bead = s.body("bead", fb.sphere(2, 0.01))
    s.planar("plane", s.ground, bead, coordinate="x y turn")
    s.constrain("y*cos(3*t) = x*sin(3*t)", name="wire")
    found = fb.simulate(s, 1, initial={"x": 0.1}, tolerance=1e-12)
    r = 0.1 * np.cosh(3 * found.t)
    assert np.hypot(found["x"], found["y"]) == pytest.approx(r, rel=1e-8)
    # the wire pushes with the Coriolis force 2 m w r', which is λ times the unit normal
    assert abs(found.multipliers["wire"]) == pytest.approx(2 * 2 * 3 * 0.3 * np.sinh(3 * found.t), abs=1e-7)
    assert found.energy.work[-1] > 1
    assert found.energy.relative_residual < 1e-10


def test_knife_edge_sleigh():
    """Chaplygin's sleigh with its mass centre over the edge: it runs on a circle, speed and turn constant."""
    s = fb.System("sleigh")
    sleigh = s.body("sleigh", fb.disk(2, 0.5))
    s.planar("ice", s.ground, sleigh, coordinate="x y f")
    s.constrain_speed("x'*sin(f) - y'*cos(f)", name="edge")
    found = fb.simulate(s, 5, initial={"x'": 3, "f'": 2}, tolerance=1e-12)
    assert found["f"] == pytest.approx(2 * found.t, abs=1e-9)
    assert found["x"] == pytest.approx(1.5 * np.sin(2 * found.t), abs=1e-8)
    assert found["y"] == pytest.approx(1.5 * (1 - np.cos(2 * found.t)), abs=1e-8)
    assert abs(found.multipliers["edge"]) == pytest.approx(2 * 3 * 2, abs=1e-7)


def test_sleigh_on_a_slope_does_not_drift_downhill():
    """A skate on an incline turning at w: cycloids; its mean place does not go downhill.

    v' = g sin(wt) along the edge from rest: v = g/w (1 - cos wt); x along the slope downhill has v cos... bounded.
    """
    s = fb.System("skate")
    s.gravity = (0, 4, 0)
    skate = s.body("skate", fb.disk(2, 0.5))
    s.planar("ice", s.ground, skate, coordinate="x y f")
    s.constrain_speed("x'*sin(f) - y'*cos(f)", name="edge")
    w, g = 2.0, 4.0
    found = fb.simulate(s, 10, initial={"f'": w}, tolerance=1e-12)
    t = found.t
    # downhill is y: y' = v sin wt, v = g/w (1 - cos wt)
    y = g / w * ((1 - np.cos(w * t)) / w - (1 - np.cos(2 * w * t)) / (4 * w))
    x = g / w * (np.sin(w * t) / w - t / 2 - np.sin(2 * w * t) / (4 * w))
    assert found["y"] == pytest.approx(y, abs=1e-7)
    assert found["x"] == pytest.approx(x, abs=1e-7)


def bricard():
    """The symmetric loop of six hinges on the edges of a cube: seven conditions too many, and yet it moves."""
    s = fb.System("bricard")
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1), (0, 0, 1)], dtype=float)
    axes = ["y", "z", "x", "y", "z", "x"]
    parent = s.ground
    bodies = []
    for k in range(1, 6):
        body = s.body(f"b{k}", fb.particle(1) + fb.sphere(1, 0.2))
        # every body's axes are parallel to the ground's and its origin is its own corner
        step = (corners[k] - (corners[k - 1] if k > 1 else (0, 0, 0))).tolist()
        s.hinge(f"h{k}", parent, body, at=step, axis=axes[k], coordinate=f"q{k}")
        bodies.append(body)
        parent = body
    s.hinge("h0", parent, s.ground, at=(corners[0] - corners[5]).tolist(), axis=axes[0])
    return s


def test_a_loop_that_is_closed_too_often_moves():
    """Bricard's loop: six hinges on six edges of a cube, five conditions on five coordinates, one of them redundant."""
    s = bricard()
    model = fb.assemble(s)
    found = fb.simulate(model, 1, initial={"q1'": 1}, tolerance=TOLERANCE)
    active = found.kernels.active
    assert len(active) == 4 and model.n_u == 5
    assert found.kernels.dropped
    assert np.ptp(found["q1"]) > 0.5
    assert missed(found) < 1e-10  # the redundant condition too, which nothing holds but the others
    assert found.energy.relative_residual < 1e-8
    assert any(name.startswith("h0") for name in found.indeterminate)
    assert any(name.startswith("h3") for name in found.indeterminate)


def test_free_bodies_of_a_constrained_motion_balance():
    """Force and moment equations of every body, with the reactions of the run put in, leave nothing."""
    s = four_bar()
    found = fb.simulate(
        s, 1, initial={"a": 0.3, "a'": 1}, near={"b": 0.4, "d": 0.9}, tolerance=1e-12, times=[0.6]
    )
    e = fb.equations(s)
    now = {name: float(found[name][0]) for name in found.names}
    joints = found.reactions
    from freebody.dynamics.motion import motion

    state = float_state(found.kernels.model, found.states[0, :3].tolist(), found.states[0, 3:6].tolist(), 0.6)
    udot = [float(x) for x in motion(found.kernels.model, state, found.kernels.active).udot]
    put = {e.model.names.atoms[name]: value for name, value in now.items()}
    put |= {speed.acceleration: value for speed, value in zip(e.model.speeds, udot, strict=True)}
    values = {f"{j}_{c}": joints[j].force[0, k] for j in "ABCD" for k, c in enumerate("xyz")}
    values |= {f"{j}_M{c}": joints[j].moment[0, k] for j in "ABCD" for k, c in enumerate("xyz")}
    for body in ("crank", "rod", "rocker"):
        free = e.free_body(body)
        known = {symbol: values[symbol.name] for symbol in free.unknowns}
        for equation in free.equations:
            left, right = (float(side.xreplace(put | known)) for side in (equation.lhs, equation.rhs))
            assert left == pytest.approx(right, abs=1e-11)


def test_indeterminate_reactions_of_a_planar_loop():
    found = fb.simulate(four_bar(), 0.1, initial={"a": 0.3}, near={"b": 0.4, "d": 0.9})
    across = {f"{j}_{c}" for j in "ABCD" for c in ("z", "Mx", "My")}
    assert set(found.indeterminate) == across


def test_both_of_two_equal_ropes_are_indeterminate():
    s = fb.System("two ropes")
    s.gravity = (0, -9.81, 0)
    ball = s.body("ball", fb.sphere(2, 0.1))
    s.slider("rail", s.ground, ball, axis="y", coordinate="y")
    s.rope([s.ground.origin, ball.origin], 1, name="one")
    s.rope([s.ground.origin, ball.origin], 1, name="two")
    found = fb.simulate(s, 1, near={"y": -1})
    assert {"one", "two"} <= set(found.indeterminate)
    assert found.multipliers["one"] + found.multipliers["two"] == pytest.approx(2 * 9.81)


def test_nothing_is_indeterminate_in_a_determined_machine():
    s = free_wheel(fb.disk(2, 0.3), 0.3)
    found = fb.simulate(s, 0.1, initial={"air": (1, 1, 0, 0)}, near={"air_z": 0.3})
    assert found.indeterminate == ()


def test_what_is_named_is_held_and_the_rest_follows():
    s = four_bar()
    found = fb.simulate(s, 0.1, initial={"a": 0.3, "a'": 2}, near={"b": 0.4, "d": 0.9})
    assert (found["a"][0], found["a'"][0]) == (0.3, 2)
    elbow = fb.simulate(s, 0.1, initial={"a": 0.3}, near={"b": -2.0, "d": -0.9})
    assert elbow["d"][0] < 0 < found["d"][0]


def test_of_two_ball_joints_the_second_is_held():
    """Components of a quaternion belong to its own joint."""
    s = fb.System("two balls")
    a, b = s.body("a", fb.box(1, (1, 2, 3))), s.body("b", fb.box(1, (1, 2, 3)))
    s.ball("first", s.ground, a)
    s.ball("second", a, b, at=(1, 0, 0))
    given = fb.Rotation.euler("XYZ", 0.2, 0.1, 0)
    tip = np.array([1, 0, 0]) + np.array(given.matrix, dtype=float)[:, 2]
    # as far from the first ball, elsewhere
    place = np.array(fb.Rotation.euler("XYZ", 0.1, 0.2, 0.3).matrix, dtype=float) @ tip
    s.ball("third", s.ground, b, at=place.tolist(), to=(0, 0, 1))
    found = fb.simulate(s, 0.1, initial={"second": given})
    at = [found[f"second_e{k}"][0] for k in range(4)]
    assert at == pytest.approx(list(map(float, given.as_quaternion())), abs=1e-15)
    assert abs(found["first_e0"][0] - 1) > 1e-4
    assert missed(found) < 100 * EPS


def test_project_moves_what_is_named():
    s = four_bar()
    start = {"a": 0.3, "b": 0.4, "d": 0.9}
    with pytest.raises(SimulationError, match="initial state is off the constraints.*project=True"):
        fb.simulate(s, 1, initial=start)
    found = fb.simulate(s, 1, initial=start, project=True)
    assert missed(found) < 100 * EPS
    # each step of the projection is a shortest one, and together they are not much longer than the shortest way
    moved = lambda motion: np.linalg.norm([motion[k][0] - x for k, x in start.items()])  # noqa: E731
    near = {"b": found["b"][0], "d": found["d"][0]}
    shortest = min(
        moved(fb.simulate(s, 1e-3, initial={"a": a}, near=near)) for a in np.linspace(0.22, 0.3, 9)
    )
    assert shortest <= moved(found) < 1.1 * shortest


def test_project_takes_speeds_to_the_nearest_ones():
    """Nearest in the sense of the kinetic energy of the change: that is what a frictionless closing impact gives."""
    s = fb.System("rail")
    ball = s.body("ball", fb.sphere(2, 0.1))
    s.planar("plane", s.ground, ball, coordinate="x y f")
    s.constrain("y = x", name="rail")
    found = fb.simulate(s, 1, initial={"x'": 2, "y'": 0}, project=True)
    assert (found["x'"][0], found["y'"][0]) == pytest.approx((1, 1))


def test_a_machine_that_is_held_fast_does_not_move():
    s = fb.System("truss")
    s.gravity = (0, -9.81, 0)
    left, right = s.body("left", fb.slender_bar(1, 1)), s.body("right", fb.slender_bar(1, 1))
    s.hinge("A", s.ground, left, to=(-0.5, 0, 0), coordinate="a")
    s.hinge("B", s.ground, right, at=(1, 0, 0), to=(-0.5, 0, 0), coordinate="b")
    s.hinge("C", left, right, at=(0.5, 0, 0), to=(0.5, 0, 0))
    found = fb.simulate(s, 1, near={"a": 1, "b": 2})
    assert found["a"] == pytest.approx(math.pi / 3, abs=1e-14)
    # each support carries a bar
    assert found.reactions["A"].force[-1, 1] == pytest.approx(9.81)
    assert found.reactions["A"].force[-1, 0] == pytest.approx(9.81 / 2 / math.tan(math.pi / 3))


def test_events_of_a_constrained_motion_lie_on_the_constraints():
    found = fb.simulate(
        four_bar(), 3, initial={"a": 0.3}, near={"b": 0.4, "d": 0.9}, events=["a'", "d - 1"], tolerance=1e-9
    )
    assert len(found.events) >= 2
    for event in found.events:
        state = event.state
        gap = (
            np.exp(1j * state["a"])
            + 2 * np.exp(1j * (state["a"] + state["b"]))
            - 2
            - 1.5 * np.exp(1j * state["d"])
        )
        assert abs(gap) < 100 * EPS


def test_singular_starts_are_refused_not_followed():
    with pytest.raises(
        SimulationError, match="'C_x' of 'four-bar' followed from the others at the start, but at t = "
    ):
        fb.simulate(four_bar((1, 2, 1, 2)), 1)
    # a parallelogram beside its singular position is fine
    found = fb.simulate(four_bar((1, 2, 1, 2)), 0.2, initial={"a": 1}, near={"b": -1, "d": 1})
    assert found["a"] == pytest.approx(found["d"], abs=1e-12)


def test_the_same_run_from_a_model_twice():
    model = fb.assemble(four_bar())
    a, b = (fb.simulate(model, 1, initial={"a": 0.3}, near={"b": 0.4, "d": 0.9}) for _ in range(2))
    assert np.array_equal(a.states, b.states)


def test_loops_of_each_joint_stay_closed():
    for kind in ("hinge", "ball", "gimbal", "universal", "weld", "slider", "cylindrical", "planar"):
        s = fb.System(kind)
        s.gravity = (1, 2, 3)
        a, b = s.body("a", fb.box(1, (1, 2, 3))), s.body("b", fb.box(2, (3, 2, 3)))
        s.ball("fa", s.ground, a, to=(0.5, 0, 0))
        s.free("fb", s.ground, b)
        getattr(s, kind)("joint", a, b, at=(0, 0, 1), to=(0, 0.5, 1))
        found = fb.simulate(s, 1, initial={"fa_wx": 1, "fa_wy": 2}, tolerance=1e-9, samples=26)
        assert missed(found) < 1000 * EPS, kind
        assert found.energy.relative_residual < 1e-6, kind


def test_an_oblique_universal_joint_closes_with_the_angle_of_its_axes():
    """Axes that are not at right angles keep the angle that they have when the bodies are parallel."""
    s = fb.System("oblique")
    a, b = s.body("a", fb.box(1, (1, 2, 3))), s.body("b", fb.box(2, (3, 2, 3)))
    s.free("fa", s.ground, a)
    s.free("fb", s.ground, b)
    s.universal("cross", a, b, axis=("x", (1, 1, 0)))
    found = fb.simulate(s, 1, initial={"fa_wx": 1, "fb_wy": 2, "fb_wz": 1})
    Ra, Rb = (found.poses[name].rotation for name in "ab")
    angle = np.einsum("ni,nij,j->n", Ra[:, :, 0], Rb, np.array([1, 1, 0]) / math.sqrt(2))
    assert angle == pytest.approx(1 / math.sqrt(2), abs=1e-14)


def test_the_sign_of_a_loop_joint_s_axis_means_nothing():
    runs = []
    for axis in ("z", "-z"):
        s = fb.System("axis")
        s.gravity = (0, -9.81, 0)
        a, b = s.body("a", fb.slender_bar(1, 1)), s.body("b", fb.slender_bar(1, 2))
        s.hinge("A", s.ground, a, to=(-0.5, 0, 0), coordinate="a")
        s.planar("P", s.ground, b, coordinate="x y f")
        s.hinge("C", a, b, at=(0.5, 0, 0), to=(-1, 0, 0), axis=axis)
        runs.append(fb.simulate(s, 1, near={"x": 2}))
    assert np.array_equal(runs[0].states, runs[1].states)


def test_constraints_that_end_stop_the_run():
    """A counterweight that arrives at the beam: there the rope turns round."""
    s = fb.System("arrival")
    s.gravity = (0, -9.81, 0)
    a, b = s.body("a", fb.particle(3)), s.body("b", fb.particle(1))
    s.slider("left", s.ground, a, axis="-y", coordinate="p")
    s.slider("right", s.ground, b, at=(1, 0, 0), axis="-y", coordinate="q")
    s.rope([a.origin, s.ground.origin, s.ground.point(1, 0, 0), b.origin], 3)
    with pytest.raises(
        SimulationError, match="So do constraints that end.*points of a rope that meet"
    ) as caught:
        fb.simulate(s, 5, initial={"p": 1}, near={"q": 1})
    found = caught.value.trajectory
    # 1 m at g/2
    assert found.t[-1] == pytest.approx(2 / math.sqrt(9.81), rel=1e-6)
