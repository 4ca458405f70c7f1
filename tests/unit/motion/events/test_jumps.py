"""Events of the user on contacts: gaps, forces, slips and margins, in phases and where they jump."""

import numpy as np
import pytest

import freebody as fb

G, R, MU = 9.81, 0.3, 0.2


def disk(restitution=0.0, static=None):
    s = fb.System("bowling")
    s.gravity = (0, -G, 0)
    body = s.body("disk", fb.disk(10, R))
    s.planar("plane", s.ground, body, coordinate="x y turn")
    more = {} if static is None else {"static_friction": static}
    s.contact(
        "floor", body.circle(R), s.ground.plane(normal="y"), friction=MU, restitution=restitution, **more
    )
    return s


def seen(motion, name):
    return [(e.time, e.direction) for e in motion.events if e.name == name]


def test_gap_force_slip_and_margin_of_a_disk_that_lands_and_rolls():
    """It lands at √(2 h/g), N jumps from 0 to m g, and it rolls at v/3 once μ g t = v/3."""
    watched = [
        "floor.gap - 0.05",
        "floor.gap",
        "N_floor - 50",
        "floor.approach",
        "floor.slip",
        "floor.margin - 1",
    ]
    motion = fb.simulate(
        disk(), 1, initial={"y": 0.4, "x'": 3}, events=[fb.event(one, name=one) for one in watched]
    )
    lands, slides = np.sqrt(0.2 / G), 3 / (3 * MU * G)
    times = [np.sqrt(0.1 / G), lands, lands, lands, slides, slides]
    for name, time, way in zip(watched, times, (-1, -1, 1, -1, -1, 1), strict=True):
        found = [one for one in seen(motion, name) if one[0] > 0]
        assert [w for _, w in found] == [way], name
        assert found[0][0] == pytest.approx(time, abs=1e-9), name


@pytest.mark.parametrize("text", ["floor.gap", "3*floor.gap", "y' - 1e-3"])
def test_what_reaches_zero_or_jumps_through_it_ends_a_run(text):
    """The speed jumps from below to above zero at the impact; the gap only touches zero there."""
    start = {"y": 0.4}
    motion = fb.simulate(disk(0.5), 2, initial=start, events=[fb.event(text, name="stop", terminal=True)])
    assert motion.status == "terminal event"
    assert float(motion.t[-1]) == pytest.approx(np.sqrt(0.2 / G), abs=1e-12)
    assert len(seen(motion, "stop")) == 1


def test_friction_and_margin_of_a_block_that_is_pulled_until_it_slips():
    """F = 10 t: T passes -3 N at 0.3 s, and the margin reaches zero at F = μ_s m g."""
    s = fb.System("pulled")
    s.gravity = (0, -G, 0)
    bar, block = s.body("bar", fb.particle(1)), s.body("block", fb.particle(1))
    s.slider("along", s.ground, bar, axis="x", coordinate="x")
    s.slider("up", bar, block, axis="y", coordinate="y")
    s.contact("foot", block.point(0, 0, 0), s.ground.plane(normal="y"), friction=0.4, static_friction=0.5)
    s.force("pull", block.point(0, 0, 0), ("10*t", 0, 0))
    events = [fb.event("foot.tangential + 3", name="T"), fb.event("foot.margin", name="limit")]
    motion = fb.simulate(s, 0.6, events=events)
    assert seen(motion, "T")[0] == (pytest.approx(0.3, abs=1e-9), -1)
    assert seen(motion, "limit")[0] == (pytest.approx(0.5 * G / 10, abs=1e-9), -1)


def test_pairs_of_a_family_in_either_order_and_forces_that_the_motion_leaves_open():
    s, start = fb.System("pile"), {}
    s.gravity = (0, 0, -G)
    ball, box = s.body("ball", fb.sphere(1, 0.05)), s.body("box", fb.box(2, (0.2, 0.2, 0.1)))
    s.free("a", s.ground, ball)
    s.free("b", s.ground, box)
    start = {"a_x": 1.0, "a_z": 0.06, "b_z": 0.051}
    corners = [(x, y, -0.05) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    s.contacts(
        "pile", [ball.sphere(0.05), box.corners(*corners)], against=s.ground.plane(normal="z"), friction=0.5
    )
    events = [
        fb.event("pile[ground,ball].gap - 0.005", name="near"),
        fb.event("pile[box.1,ground].normal - 1", name="open force"),
    ]
    motion = fb.simulate(s, 0.05, initial=start, events=events)
    assert seen(motion, "near") == [(pytest.approx(np.sqrt(0.01 / G), abs=1e-9), -1)]
    (force,) = (e for e in motion.events if e.name == "open force")
    assert force.time == pytest.approx(np.sqrt(0.002 / G), abs=1e-9)
    assert str(force).endswith("rises through zero; equal compliance shares the forces of these contacts")


def test_a_batch_has_the_events_of_single_runs():
    data = fb.simulate(
        disk(),
        1,
        initial={"y": 0.3, "x'": [3, 1.5]},
        events=[fb.event("floor.slip", name="rolls")],
        outputs=["x"],
    )
    np.testing.assert_allclose(data["event_time"][:, 0], np.array([3, 1.5]) / (3 * MU * G), atol=1e-9)
