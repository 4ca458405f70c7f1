"""What is round on a straight side with two ends: over the end, from the corner, back onto the side."""

import math

import numpy as np
import pytest

import freebody as fb

G, R = 9.81, 0.5


def ledge(swapped=False, force=0):
    """A disk on a side from (0, 0) to (1, 0)."""
    s = fb.System("ledge")
    g, mu, F = s.parameters(g=G, mu=0.8, F=force)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(1, R))
    s.planar("plane", s.ground, disk, coordinate="x y turn")
    if force:
        s.force("F", disk.origin, (F, 0, 0))
    pair = disk.circle(R), s.ground.segment((0, 0, 0), (1, 0, 0), normal="y")
    s.contact("c", *(reversed(pair) if swapped else pair), friction=mu)
    return s


def timeline(motion, contact):
    return [m.mode for m in motion.modes.of(contact)]


def touching_is_exact(motion):
    """Closed contacts have no gap; nothing enters the side or its corners."""
    for one in motion.contacts.values():
        assert np.abs(one.gap[one.mode != "open"]).max(initial=0) < 1e-14
    inside = (motion["x"] > 0) & (motion["x"] < 1)
    assert motion.contacts["c"].gap[inside].min(initial=0) > -1e-14
    assert motion.contacts["c_end"].gap.min() > -1e-14
    assert motion.contacts["c_start"].gap.min() > -1e-14


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("way", [1, -1])
def test_a_disk_rolls_over_the_end_of_a_side(swapped, way):
    # pivoting about the end with v at its top: (3/4) v² + g R (1 - cos θ) = (3/4) w² R²,
    # N = m (g cos θ - R w²), T = m g sin θ/3
    v, mu = 0.6, 0.8
    begin = 0.2 if way > 0 else 0.8
    first = {"x": begin, "y": R, "x'": way * v, "turn'": -way * v / R}
    motion = fb.simulate(ledge(swapped), 2, initial=first, tolerance=1e-12)
    side, corner = motion.modes.of("c"), motion.modes.of("c_end" if way > 0 else "c_start")
    assert [m.mode for m in side] == ["stick", "open"]
    assert side[1].start == pytest.approx(0.8 / v, abs=1e-12)
    assert side[1].why == corner[1].why == "the end of the side"
    assert [m.mode for m in corner][:3] == ["open", "stick", corner[2].mode]
    assert corner[1].start == side[1].start
    at = next(e for e in motion.events if "|T| reached" in str(e))
    theta = math.atan2(abs(at.state["x"] - (1 if way > 0 else 0)), at.state["y"])
    w2 = v * v / R**2 + 4 / 3 * G / R * (1 - math.cos(theta))
    assert G * math.sin(theta) / 3 == pytest.approx(mu * (G * math.cos(theta) - R * w2), abs=1e-9)
    assert motion.energy.relative_residual < 1e-10
    touching_is_exact(motion)


def test_a_disk_that_slips_without_friction_goes_over_the_end_and_leaves_where_its_weight_no_longer_holds_it():
    # a sliding mass: v² = v0² + 2 g R (1 - cos θ) and N = 0 where v² = g R cos θ
    v = 0.6
    motion = fb.simulate(
        ledge(), 2, initial={"x": 0.2, "y": R, "x'": v, "turn'": 3}, values={"mu": 0}, tolerance=1e-12
    )
    assert timeline(motion, "c") == ["slip", "open"]
    assert timeline(motion, "c_end") == ["open", "slip", "open"]
    away = motion.modes.of("c_end")[2]
    assert away.why == "N reached 0"
    state = motion.at(away.start)
    assert state["y"] / R == pytest.approx(2 / 3 + v * v / (3 * G * R), rel=1e-10)
    assert motion["turn'"] == pytest.approx(3)
    touching_is_exact(motion)


def test_a_fast_disk_flies_off_the_end():
    v = math.sqrt(G * R) * 1.01
    motion = fb.simulate(ledge(), 0.6, initial={"x": 0.5, "y": R, "x'": v, "turn'": -v / R})
    assert timeline(motion, "c_end") == ["open"]
    assert motion.modes.of("c")[1].start == pytest.approx(0.5 / v, abs=1e-12)
    t = 0.6 - 0.5 / v
    assert motion.at(0.6)["y"] == pytest.approx(R - G * t * t / 2, rel=1e-10)


def test_a_disk_thrown_back_from_the_corner_rolls_onto_the_side_and_over_its_other_end():
    theta, w = 0.2, 2.0
    first = {
        "x": 1 + R * math.sin(theta), "y": R * math.cos(theta),
        "x'": -w * R * math.cos(theta), "y'": w * R * math.sin(theta), "turn'": w,
    }  # fmt: skip
    motion = fb.simulate(ledge(), 2, initial=first, tolerance=1e-12)
    assert timeline(motion, "c_end") == ["stick", "open"]
    assert timeline(motion, "c") == ["open", "stick", "open"]
    assert motion.modes.of("c")[1].why == motion.modes.of("c_end")[1].why == "the foot came onto the side"
    assert timeline(motion, "c_start")[:2] == ["open", "stick"]
    # on the side it rolls with what the climb has left of its speed
    top = w * w - 4 / 3 * G / R * (1 - math.cos(theta))
    passed = motion.modes.of("c")[1:]
    assert 1 / (R * math.sqrt(top)) == pytest.approx(passed[1].start - passed[0].start, rel=1e-10)
    touching_is_exact(motion)


@pytest.mark.parametrize("force", [1, -1])
def test_a_disk_at_rest_on_the_very_end_goes_where_it_is_pushed(force):
    motion = fb.simulate(ledge(force=force), 0.7, initial={"x": 1, "y": R})
    assert timeline(motion, "c") == (["open"] if force > 0 else ["stick"])
    assert timeline(motion, "c_end")[0] == ("stick" if force > 0 else "open")
    assert timeline(fb.simulate(ledge(), 1, initial={"x": 1, "y": R}), "c") == ["stick"]
    assert motion.energy.relative_residual < 1e-9
    touching_is_exact(motion)


def test_a_plank_slides_over_a_corner_until_its_end():
    s = fb.System("plank")
    g, mu = s.parameters(g=G, mu=0.1)
    s.gravity = (0, -g, 0)
    plank = s.body("plank", fb.box(1, (2, 0.1, 0.2)))
    s.planar("plane", s.ground, plank, coordinate="x y turn")
    s.contact(
        "c", plank.segment((-1, -0.05, 0), (1, -0.05, 0), normal="-y"), s.ground.point(0, 0, 0), friction=mu
    )
    motion = fb.simulate(s, 1, initial={"x": 0.3, "y": 0.05, "x'": 5}, tolerance=1e-12)
    assert timeline(motion, "c") == ["slip+", "open"]
    change = motion.modes.of("c")[1]
    state = motion.at(change.start)
    # the foot is at the end of the plank: (0, 0) in its axes is (-1, -0.05)
    c, n = math.cos(state["turn"]), math.sin(state["turn"])
    place = np.array([[c, n], [-n, c]]) @ [-state["x"], -state["y"]]
    assert place == pytest.approx([-1, -0.05], abs=1e-12)
    after = motion.t > change.start
    assert motion["turn'"][after] == pytest.approx(motion["turn'"][-1], rel=1e-12)
    assert motion.energy.relative_residual < 1e-11


def test_a_plank_tips_over_a_roller():
    s = fb.System("plank")
    g, mu = s.parameters(g=G, mu=2)
    s.gravity = (0, -g, 0)
    plank = s.body("plank", fb.box(1, (2, 0.1, 0.2)))
    s.planar("plane", s.ground, plank, coordinate="x y turn")
    side = plank.segment((-1, -0.05, 0), (1, -0.05, 0), normal="-y")
    s.contact("c", side, s.ground.circle(0.2, at=(0, -0.2, 0)), friction=mu)
    motion = fb.simulate(s, 1, initial={"x": 0.9, "y": 0.05}, tolerance=1e-12)
    assert timeline(motion, "c") == ["stick", "slip+", "open"]
    assert timeline(motion, "c_start") == timeline(motion, "c_end") == ["open"]
    # rolling without slip by θ, the foot moves by R θ along the plank: its middle is at 0.9 - 0.2 θ from the foot
    stuck = motion.contacts["c"].mode == "stick"
    theta = -motion["turn"][stuck]
    u = 0.9 + 0.2 * motion["turn"][stuck]
    h = 0.05
    x = 0.2 * np.sin(theta) + u * np.cos(theta) + h * np.sin(theta)
    assert motion["x"][stuck] == pytest.approx(x, abs=1e-10)
    assert motion.energy.relative_residual < 1e-11


def test_a_ball_in_space_goes_over_the_end():
    s = fb.System("ball")
    g, mu = s.parameters(g=G, mu=0.3)
    s.gravity = (0, -g, 0)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, ball)
    s.contact("c", ball.sphere(0.1), s.ground.segment((0, 0, 0), (1, 0, 0), normal="y"), friction=mu)
    first = {"f_x": 0.5, "f_y": 0.1, "f_vx": 0.5, "f_wz": -5}
    motion = fb.simulate(s, 1.5, initial=first, tolerance=1e-12)
    assert timeline(motion, "c") == ["stick", "open"]
    assert motion.modes.of("c")[1].start == pytest.approx(1, abs=1e-12)
    assert timeline(motion, "c_end") == ["open", "stick", "slip", "open"]
    # (7/10) v² + g r (1 - cos θ) = (7/10) r² w² while it pivots; T = (2/7) m g sin θ
    at = next(e for e in motion.events if "|T| reached" in str(e))
    n = at.state["f_y"] / 0.1
    w2 = 0.5**2 / 0.01 + 10 / 7 * G / 0.1 * (1 - n)
    assert 2 / 7 * G * math.sqrt(1 - n * n) == pytest.approx(0.3 * (G * n - 0.1 * w2), abs=1e-9)
    assert np.abs(motion.contacts["c_end"].gap[motion.contacts["c_end"].mode != "open"]).max() < 1e-14
