"""Few points of a window that show that it has no zeros."""

import numpy as np
import pytest

import freebody as fb
from freebody.motion.kernels.kernels import kernels_of
from freebody.motion.ode import window
from freebody.motion.ode.run import MARGIN
from freebody.motion.phase.scene import scene_of


@pytest.mark.parametrize("level", [0, 1])
def test_weights_are_exact_for_polynomials(level):
    parts, rng = window.FEWEST[level], np.random.default_rng(level)
    of_level = slice(5 * level, 5 * level + parts + 1)
    middle, close = (np.array(x[of_level]) for x in (window.IN_THE_MIDDLE, window.CLOSE_TO_THE_END))
    x = np.linspace(0, 1, parts + 1)
    p = np.polynomial.Polynomial(rng.normal(size=parts + 1))
    assert close @ p(x) == pytest.approx(p(MARGIN), rel=1e-13)
    q = np.polynomial.Polynomial(rng.normal(size=parts))  # through all ends but the middle one
    error = np.zeros(parts + 1)
    error[parts // 2] = 0.3
    assert abs(middle @ (q(x) + error)) == pytest.approx(0.3, rel=1e-13)


def test_dips_between_the_ends_of_few_parts_are_found():
    """(q - a)² - d² in one long step: a parabola is known at few points, and is below zero between two of them."""
    s = fb.System("slider")
    s.parameters(a=0.5, d=0.1)
    s.slider("guide", s.ground, s.body("block", fb.particle(1)), axis="x", coordinate="q")
    events = ["(q - a)^2 - d^2"]
    for depth in (0.02, 1e-3, 1e-6):
        for place in np.linspace(0.11, 0.89, 10):
            motion = fb.simulate(
                s,
                1,
                initial={"q": 0, "q'": 1},
                values={"a": place, "d": depth},
                events=events,
                method="dop853",
            )
            assert [e.time for e in motion.events] == pytest.approx([place - depth, place + depth], abs=1e-9)


def spinning_rod(load="0", surface=None):
    s = fb.System("rod")
    bar = s.body("bar", fb.slender_bar(2, 2, axis="y"))
    s.planar("rail", s.ground, bar, coordinate="x y theta")
    s.contact(
        "tip", bar.corners((0, -1, 0), (0, 1, 0)), surface(s) if surface else s.ground.plane(), friction=0
    )
    s.force("push", bar.origin, (load, 0, 0))
    return s


@pytest.mark.parametrize("depth", [1e-2, 1e-4, 1e-7])
def test_tips_that_dip_into_a_floor_between_the_ends_of_steps_are_found(depth):
    """A tip at height y - cos(ω t + φ), whose course the ends of steps show until it comes near."""
    s = spinning_rod()
    for phase in np.linspace(-3, -1, 9):
        motion = fb.simulate(s, 1, initial={"y": 1 - depth, "theta": phase, "theta'": 4})
        at = motion.events[0]
        assert at.time == pytest.approx((-np.arccos(1 - depth) - phase) / 4, abs=1e-8)


def test_ends_of_steps_show_only_what_follows_the_state():
    def smooth(system):
        kernels = kernels_of(system)
        return scene_of(kernels).candidates.pattern.smooth

    assert smooth(spinning_rod())
    assert not smooth(spinning_rod(load="sin(900*t)"))
    assert not smooth(spinning_rod(surface=lambda s: s.ground.heightline("0.1*exp(-1000*x^2)")))


def test_events_are_those_of_looks_between_the_ends():
    """A function of the user asks for looks between the ends of all steps."""
    s = fb.System("coin")
    s.gravity = (0, 0, -9.81)
    body = s.body("coin", fb.cylinder(0.005, 0.012, 0.002))
    s.free("f", s.ground, body)
    s.contact("edge", body.circle(0.012, axis="z"), s.ground.plane(normal="z"), friction=0.4, rolling=2e-4)
    start = {"f_z": 0.02, "f_wx": 3, "f_wy": 11, "f_wz": 20}
    runs = [fb.simulate(s, 0.2, initial=start, events=events) for events in ([], ["2 + f_x^2"])]
    segments = [[(x.modes, x.path.end) for x in run.path.segments] for run in runs]
    assert [x[0] for x in segments[0]] == [x[0] for x in segments[1]] and len(segments[0]) > 4
    assert [x[1] for x in segments[0]] == pytest.approx([x[1] for x in segments[1]], rel=1e-7)
