"""Derivatives of motions with contacts: events of the user, ends, batches, fits, copies.

Closed forms are in tests/exact/test_contact_sensitivities.py, differences of random scenes in tests/laws.
"""

import pickle

import numpy as np
import pytest

import freebody as fb

G = 9.81


def ball():
    s = fb.System("ball")
    g, e, h = s.parameters(g=G, e=0.8, h=1.0)
    s.gravity = (0, -g, 0)
    body = s.body("ball", fb.particle(1))
    s.slider("rail", s.ground, body, axis="y", coordinate="y")
    s.contact("floor", body.origin, s.ground.plane(normal="y"), restitution=e)
    return s


HALF = fb.event("y - 1/2", name="half", direction=1)


def test_times_of_events_of_the_user_and_ends():
    """The ball rises through 1/2 at t with e v τ - g τ²/2 = 1/2, τ = t - √(2h/g)."""
    s, start = ball(), {"y": "h"}
    motion = fb.simulate(s, 0.9, initial=start, events=[HALF], sensitivities=["h", "e"], tolerance=1e-12)
    v, fall = np.sqrt(2 * G), np.sqrt(2 / G)
    since = (0.8 * v - np.sqrt(0.64 * v**2 - G)) / G
    rate = 0.8 * v - G * since
    expected = [fall / 2 - 0.8 * v / 2 * since / rate, -v * since / rate]
    assert motion.sensitivity.times("half")[0] == pytest.approx(expected, rel=1e-9)
    ends = fb.simulate(
        s,
        0.9,
        initial=start,
        events=[fb.event("y - 1/2", "half", 1, terminal=True)],
        sensitivities=["h", "e"],
    )
    assert ends.sensitivity["final(y)", "h"] == pytest.approx(0, abs=1e-8)
    later = fb.simulate(s, "h/2 + 2/5", initial=start, sensitivities=["h"], tolerance=1e-12)
    at_end, rate = later.sensitivity["y", "h"][-1], later["y'"][-1]
    assert later.sensitivity["final(y)", "h"] == pytest.approx(at_end + rate / 2, rel=1e-9)
    assert later.sensitivity["initial(y)", "h"] == 1
    assert later.sensitivity["energy", "h"][-1] == pytest.approx(0.64 * G, rel=1e-9)  # m = 1


def test_times_at_which_a_speed_jumps_are_those_of_the_contact():
    s, start = ball(), {"y": "h"}
    events = [fb.event("y'", "jump", 1), fb.event("1/2 - floor.gap", "half", 1)]
    motion = fb.simulate(s, 0.5, initial=start, events=events, sensitivities=["h"])
    assert motion.sensitivity.times("floor")[0] == pytest.approx(np.sqrt(2 / G) / 2, rel=1e-8)
    assert motion.sensitivity.times("half")[0] == pytest.approx(
        np.sqrt(1 / G), rel=1e-8
    )  # t² = 2 (h - 1/2)/g
    with pytest.raises(fb.errors.SimulationError, match="jumps over it"):
        motion.sensitivity.times("jump")


def test_batches_copies_and_fits():
    s, start = ball(), {"y": "h"}
    common = dict(initial=start, times=[0.3, 0.9], sensitivities=["h", "e"])
    data = fb.simulate(s, 1, values={"e": [0.5, 0.8]}, outputs=["y", "max(y)", "max(floor.gap)"], **common)
    alone = fb.simulate(s, 1, **common)
    assert np.array_equal(data["d(y)"][1], alone.sensitivity.of("y"))
    assert data["d(max(y))"].values == pytest.approx(np.array([[1, 0], [1, 0]]), abs=1e-12)
    reason = str(data["reason"].values[0])
    assert np.isnan(data["d(max(floor.gap))"]).all() and "got 'max(floor.gap)'" in reason
    copy = pickle.loads(pickle.dumps(alone))
    assert np.array_equal(copy.sensitivity["y", "e"], alone.sensitivity["y", "e"])
    told = fb.simulate(s, 2, initial=start, values={"e": 0.7}, times=np.linspace(0.1, 1.9, 40))
    fit = fb.fit(s, {"time": told.t, "y": told["y"]}, unknown={"e": 0.75, "h": 1.02}, initial=start)
    assert [fit.values[x] for x in ("e", "h")] == pytest.approx([0.7, 1.0], rel=1e-9)


def rolling():
    s = fb.System("ball")
    s.parameters(mu=0.3, d=0.01, e=0.5)
    s.gravity = (0, -G, 0)
    body = s.body("ball", fb.sphere(1, 0.1))
    s.planar("plane", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.sphere(0.1), s.ground.plane(), friction="mu", rolling="d", restitution="e")
    return s, {"y": 0.5, "x'": 6.0, "turn'": 3.0}, {"mu": 0.22, "d": 0.013, "e": 0.62}


def on_a_rough_pin():
    s = fb.System("bar")
    s.parameters(mu=0.5, k=500.0, c=8.0)
    s.gravity = (0, -G, 0)
    bar = s.body("bar", fb.slender_bar(2, 1, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, 0.5, 0), axis="z", coordinate="q")
    s.friction("dry", pin, coefficient="mu", radius=0.02)
    s.stop("wall", pin, high=0.2, stiffness="k", damping="c")
    return s, {"q": -1.0}, {"mu": 0.3, "k": 300.0, "c": 4.0}


@pytest.mark.parametrize("scene", [on_a_rough_pin, pytest.param(rolling, marks=pytest.mark.slow)])
def test_laws_from_data(scene):
    """Friction, restitution, resistance, stiffness and damping of a motion, from others."""
    s, start, told = scene()
    times = np.linspace(0, 1.5, 61)
    motion = fb.simulate(s, 1.5, initial=start, values=told, times=times, tolerance=1e-11)
    measured = {name: motion[name] for name in motion.names if not name.endswith("'")}
    sigma = dict.fromkeys(measured, 1e-3)
    near = {name: 0.95 * value for name, value in told.items()}
    fit = fb.fit(s, {"time": times, **measured}, near, initial=start, sigma=sigma, tolerance=1e-11)
    assert [fit.values[name] for name in told] == pytest.approx(list(told.values()), rel=1e-6)


def test_batches_of_machines_whose_loads_switch():
    """Switches are no events of the user; each lane has the derivatives of a run alone."""
    s, start, told = on_a_rough_pin()
    common = dict(initial=start, sensitivities=["mu", "k"], times=[0.3, 1.0])
    event = fb.event("q", direction=1)
    data = fb.simulate(s, 1, values={"mu": [0.2, 0.3]}, outputs=["q", "final(q)"], events=[event], **common)
    alone = fb.simulate(s, 1, values={"mu": 0.3}, events=[event], **common)
    assert np.array_equal(data["d(q)"][1], alone.sensitivity.of("q"))
    assert np.array_equal(data["d(event_time)"][1, 0], alone.sensitivity.times("q")[0])
    assert data["event_count"].shape == (2, 1)
    touched = alone.sensitivity.times("wall touches")
    assert touched.shape == (1, 2) and touched[0, 1] == pytest.approx(0, abs=1e-12)


def test_forces_and_gaps_are_differences():
    """A box that lands on two feet, slides and stops; of forces that the motion leaves open there is none."""
    s = fb.System("box")
    g = s.parameters(mu=0.3, F=4.0, a=0.05, g=9.81)[-1]
    s.gravity = (0, -g, 0)
    box = s.body("box", fb.box(2, (0.4, 0.2, 0.2)))
    s.planar("plane", s.ground, box, coordinate="x y phi")
    feet = box.corners((-0.2, -0.1, 0), (0.2, -0.1, 0))
    s.contact("feet", feet, s.ground.plane(), friction="mu", restitution=0.3)
    s.force("push", box.point(0, "a", 0), ("F*(1 + sin(6*t))", 0, 0), frame=s.ground)
    given = {"initial": {"x'": 1.0, "y": 0.2, "phi": 0.1}, "times": [0.05, 0.5, 1.1, 1.5], "tolerance": 1e-12}
    motion = fb.simulate(s, 1.6, sensitivities=["mu", "a"], **given)
    for name, value in (("mu", 0.3), ("a", 0.05)):
        h = 1e-6
        runs = [fb.simulate(s, 1.6, values={name: value + x}, **given) for x in (h, -h)]
        for what in ("feet_1.normal", "feet_1.slip", "feet_1.gap", "feet_2.approach", "feet_2.tangential"):
            expected = (runs[0][what] - runs[1][what]) / (2 * h)
            found = motion.sensitivity[what, name]
            assert (np.isnan(found) == np.isnan(motion[what])).all()
            seen = ~np.isnan(found)
            assert found[seen] == pytest.approx(expected[seen], rel=1e-4, abs=1e-5), (what, name)
    assert np.isnan(motion.sensitivity["feet_1.tangential", "mu"][2])  # both stick
