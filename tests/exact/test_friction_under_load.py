"""Friction of joints under their load: inclines, guides that jam, pins with a circle of friction."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import freebody as fb
from contact_machines import rough_pendulum
from freebody.exact import friction_circle, jamming_arm
from freebody.motion.moreau.stepping_record import JAMMED
from freebody.motion.timestepping.failure import failure

G = 9.81


def block(angle, mu, **laws):
    s = fb.System("block")
    s.gravity = (0, -G, 0)
    body = s.body("block", fb.particle(2))
    guide = s.slider("guide", s.ground, body, axis=(math.cos(angle), -math.sin(angle), 0), coordinate="x")
    s.friction("dry", guide, coefficient=mu, **laws)
    return s


@pytest.mark.parametrize("way", [{}, {"method": "timestepping", "step": 0.01}])
def test_a_block_on_an_incline_slides_with_g_sin_minus_mu_cos(way):
    motion = fb.simulate(block(0.3, 0.2), 1, **way)
    assert motion["x'"][-1] == pytest.approx(G * (math.sin(0.3) - 0.2 * math.cos(0.3)), rel=1e-12)
    assert motion.contacts["dry"].normal[-1] == pytest.approx(2 * G * math.cos(0.3), rel=1e-13)
    assert motion.contacts["dry"].mode[-1] == "slip+"


@pytest.mark.parametrize(("part", "mode"), [(1 - 1e-9, "stick"), (1 + 1e-9, "slip+")])
def test_it_sticks_up_to_the_angle_of_friction(part, mode):
    motion = fb.simulate(block(math.atan(0.4) * part, 0.4), 0.1)
    assert motion.contacts["dry"].mode[-1] == mode
    started = fb.simulate(block(math.atan(0.4) * part, 0.3, static=0.4), 0.1)
    assert started.contacts["dry"].mode[-1] == mode


@pytest.mark.parametrize(("part", "moves"), [(1 - 1e-9, True), (1 + 1e-9, False)])
def test_a_guide_that_is_pulled_too_far_from_its_axis_jams(part, moves):
    s = fb.System("guide")
    body = s.body("slide", fb.box(1, (0.1, 0.1, 0.1)))
    guide = s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("F", body.point(0, jamming_arm(0.25, 0.2) * part, 0), (10, 0, 0))
    s.friction("dry", guide, coefficient=0.25, length=0.2)
    assert (fb.simulate(s, 1).contacts["dry"].mode[-1] != "stick") == moves


@pytest.mark.parametrize(("part", "mode"), [(1 - 1e-9, "stick"), (1 + 1e-9, "slip-")])
def test_a_pendulum_rests_while_its_weight_passes_the_circle_of_friction(part, mode):
    offset = friction_circle(0.5, 0.2)
    assert offset == pytest.approx(0.2 * math.sin(math.atan(0.5)), rel=1e-15)
    theta = math.asin(offset / 0.5)
    motion = fb.simulate(rough_pendulum(0.5, 0.2), 0.2, initial={"theta": theta * part})
    assert motion.contacts["dry"].mode[-1] == mode


def falling(mu, r, until):
    """The angle of a bar that falls from 1.2 rad: J θ'' = -m g L/2 sin θ + T, T = r sin φ |F|, of which θ'' is in F."""
    m, L, share = 2.0, 1.0, friction_circle(mu, r)
    J = m * L * L / 3

    def rate(t, y):
        theta, w = y
        # F = m (r_C'' + g): with θ'' = a + b P of both sides, P² is a quadratic
        a, b = -m * G * L / 2 * math.sin(theta) / J, share / J
        along = np.array([math.cos(theta), math.sin(theta)]) * m * L / 2
        rest = m * (w * w * L / 2 * np.array([-math.sin(theta), math.cos(theta)]) + np.array([0, G]))
        A, B = rest + a * along, b * along
        P = (A @ B + math.sqrt((A @ B) ** 2 + (1 - B @ B) * (A @ A))) / (1 - B @ B)
        return [w, a + b * P]

    return solve_ivp(rate, (0, until), [1.2, 0], rtol=1e-11, atol=1e-13).y[0, -1]


def test_a_falling_pendulum_has_the_friction_that_its_own_reaction_bounds():
    expected = falling(0.5, 0.2, 0.6)
    motion = fb.simulate(rough_pendulum(0.5, 0.2), 0.6, initial={"theta": 1.2}, tolerance=1e-12)
    assert motion["theta"][-1] == pytest.approx(expected, abs=1e-10)
    force = np.linalg.norm(motion.reactions["pin"].force, axis=1)
    assert motion.contacts["dry"].normal == pytest.approx(0.2 * force, rel=1e-13)
    assert motion.contacts["dry"].tangential == pytest.approx(friction_circle(0.5, 0.2) * force, rel=1e-12)
    assert motion.energy.relative_residual < 1e-10
    off = [
        fb.simulate(rough_pendulum(0.5, 0.2), 0.6, initial={"theta": 1.2}, method="timestepping", step=h)[
            "theta"
        ][-1]
        - expected
        for h in (1e-2, 5e-3)
    ]
    assert abs(off[0]) < 1e-4 and off[0] / off[1] == pytest.approx(4, rel=0.01)


def test_two_places_of_a_bearing_bear_force_and_moment():
    """A disk beside the bearing of its shaft: F_a, F_b = F (1/2 ± e/length)."""
    s = fb.System("overhung")
    s.gravity = (0, -G, 0)
    disk = s.body("disk", fb.disk(3, 0.2, axis="z"))
    pin = s.hinge("pin", s.ground, disk, to=(0, 0, -0.3), axis="z", coordinate="turn")
    s.friction("dry", pin, coefficient=0.1, radius=0.01, length=0.2)
    motion = fb.simulate(s, 0.5, initial={"turn'": 50})
    load = 3 * G * (0.3 / 0.2 + 0.5) + 3 * G * (0.3 / 0.2 - 0.5)
    assert motion.contacts["dry"].normal[-1] == pytest.approx(0.01 * load, rel=1e-12)
    slowed = friction_circle(0.1, 0.01) * load / (3 * 0.2**2 / 2)
    assert motion["turn'"][-1] == pytest.approx(50 - 0.5 * slowed, rel=1e-10)


def test_a_joint_that_presses_itself_by_more_than_its_load_jams():
    """A body beside its guide slows down: N = max(w, 2 m a e/length), a = μ N/m, has no solution if 2 μ e > length."""

    def beside(e):
        s = fb.System("beside")
        body = s.body("slide", fb.box(1, (0.1, 0.1, 0.1)))
        guide = s.slider("guide", s.ground, body, to=(0, -e, 0), axis="x", coordinate="x")
        s.friction("dry", guide, coefficient=0.2, length=0.2)
        s.force("w", body.point(0, -e, 0), (0, -1, 0))
        return s

    assert fb.simulate(beside(0.49), 1, initial={"x'": 1})["x'"][-1] == pytest.approx(0.8, rel=1e-12)
    message = (
        "Joints of 'beside' jam at t = 0 s: the friction under their load presses them by more than it takes, so that "
        "no finite force is the friction 'dry' of joint 'guide' (Painlevé). Less friction, a smaller radius of a pin "
        "or a greater length of a guide has a motion."
    )
    with pytest.raises(fb.FreebodyError, match=re.escape(message)):
        fb.simulate(beside(0.51), 1, initial={"x'": 1})
    # an impulse stops it in a step, as any friction without bound does
    stepped = fb.simulate(beside(0.51), 0.1, initial={"x'": 1}, method="timestepping", step=0.01)
    assert stepped.at(0.01)["x'"] == pytest.approx(0, abs=1e-12)
    run, s = SimpleNamespace(failure=JAMMED), beside(0.51)
    assert "'beside' jam at t = 1 s" in failure(run, fb.assemble(s), {}, 1.0, np.zeros(2))


def door(d, law, halves=False, **joint):
    """A door on a rough pin, seen from above, and a ball that flies towards it at a distance d from the pin.

    The outer half of the door may be a body of its own, welded to the inner one in a loop of joints.
    """
    s = fb.System("door")
    if halves:
        inner, bar = (s.body(name, fb.slender_bar(1.5, 0.5, axis="y")) for name in ("inner", "door"))
        pin = s.hinge("pin", s.ground, inner, to=(0, -0.25, 0), axis="z", coordinate="turn")
        s.planar("board", s.ground, bar, coordinate="x_o y_o turn_o")
        s.weld("seam", inner, bar, at=(0, 0.25, 0), to=(0, -0.25, 0))
    else:
        bar = s.body("door", fb.slender_bar(3, 1, axis="y"))
        pin = s.hinge("pin", s.ground, bar, to=(0, -0.5, 0), axis="z", coordinate="turn")
    ball = s.body("ball", fb.sphere(0.5, 0.1))
    s.friction("dry", pin, coefficient=0.75, radius=0.1, **joint)
    s.slider("rail", s.ground, ball, at=(0, d, 0), axis="x", coordinate="x")
    s.contact("hit", ball.sphere(0.1), bar.plane(normal="-x"), restitution=0.5, impact=law)
    return s


@pytest.mark.parametrize("halves", [False, True])
@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("d", [0.9, 0.4])
def test_the_impulse_of_friction_of_a_door_that_is_hit(law, d, halves):
    """I ω = Λ d - ρ |F|,  F = m (L/2) ω - Λ,  ρ = r sin φ;   v⁺ - ω d = -e v₀,  m_b (v₀ - v⁺) = Λ.

    Beyond the centre of percussion F has the sense of the blow, else the other one.
    """
    s, m, L, m_b, v0, e = door(d, law, halves), 3, 1, 0.5, 2, 0.5
    motion = fb.simulate(s, 0.1, initial={"x": -0.1, "x'": v0})
    rho, sense = friction_circle(0.75, 0.1), 1 if d > 2 * L / 3 else -1
    ratio = (m * L**2 / 3 + rho * sense * m * L / 2) / (d + rho * sense)  # Λ/ω
    w = (1 + e) * v0 / (d + ratio / m_b)
    assert sense * (m * L / 2 * w - ratio * w) > 0
    hit = motion.events[0].after
    assert hit["turn'"] == pytest.approx(-w, rel=1e-12)
    assert hit["x'"] == pytest.approx(v0 - ratio * w / m_b, rel=1e-12)
    assert motion.energy.relative_residual < 1e-10 and np.diff(motion.energy.impulses).max() <= 1e-15


def test_a_hit_within_the_circle_of_friction_moves_nothing():
    """|Λ d| <= r sin φ |Λ|: the door stays, and the ball comes back with e of its speed."""
    motion = fb.simulate(door(0.05, "newton"), 0.2, initial={"x": -0.1, "x'": 2})
    assert friction_circle(0.75, 0.1) > 0.05
    assert np.abs(motion["turn"]).max() < 1e-15
    assert motion["x'"][-1] == pytest.approx(-1, rel=1e-12)
    with pytest.raises(fb.FreebodyError, match="collide one after another.*'simultaneous'"):
        fb.simulate(door(0.05, "newton"), 0.2, initial={"x": -0.1, "x'": 2}, impacts="sequential")


@pytest.mark.parametrize("halves", [False, True])
@pytest.mark.parametrize("d", [0.9, 0.4, 0.05])
def test_the_impulse_of_friction_in_a_blow(d, halves):
    """I ω = P d - ρ |F|,  F = m (L/2) ω - P; within the circle of friction the door stays."""
    s, m, L, P = door(1, "newton", halves), 3, 1, 2
    centre = 0.75 if halves else 0.5
    blow = fb.blow(0.1, at=s.bodies["door"].point(0, d - centre, 0), impulse=(P, 0, 0))
    motion = fb.simulate(s, 0.2, initial={"x": -5}, impulses=[blow])
    rho, sense = friction_circle(0.75, 0.1), 1 if d > 2 * L / 3 else -1
    w = P * max(d + rho * sense, 0) / (m * L**2 / 3 + rho * sense * m * L / 2)
    told = motion.events[0]
    assert told.after["turn'"] == pytest.approx(-w, rel=1e-12, abs=1e-15)
    assert halves or ("no speed changes" in str(told)) == (d < rho)
    assert np.abs(motion.energy.residual).max() < 1e-12
