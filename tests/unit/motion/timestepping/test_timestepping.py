"""Time stepping: stacks at rest, the incline by a hair, cones in space, convergence of first order, refusals."""

import math
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError
from freebody.motion.timestepping import timestepping

G = 9.81


def stack(count):
    s = fb.System("stack")
    (g,) = (s.parameters(g=G),)
    s.gravity = (0, -g, 0)
    below = s.ground.plane(normal="y")
    for i in range(count):
        box = s.body(f"box{i}", fb.box(1, (1, 0.5, 1)))
        s.planar(f"rail{i}", s.ground, box, coordinate=f"x{i} y{i} turn{i}")
        s.contact(f"c{i}", box.corners((-0.5, -0.25, 0), (0.5, -0.25, 0)), below, friction=0.5)
        below = box.plane(at=(0, 0.25, 0), normal="y")
    return s


def block(angle, mu):
    s = fb.System("incline")
    (mu_,) = (s.parameters(mu=mu),)
    s.gravity = (G * math.sin(angle), -G * math.cos(angle), 0)
    body = s.body("block", fb.box(3, (1, 0.2, 1)))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("foot", body.corners(size=(1, 0.2)), s.ground.plane(normal="y"), friction=mu_)
    return s


def test_stack_of_ten_boxes_stays_for_a_hundred_seconds():
    start = {f"y{i}": 0.25 + 0.5 * i for i in range(10)}
    motion = fb.simulate(stack(10), 100, initial=start, method="timestepping", step=0.01)
    assert np.abs(motion.path.states - motion.path.states[0]).max() < 1e-9
    assert motion.depth < 1e-9
    assert motion.residual <= 1e-12
    # the lowest feet carry all
    lowest = motion.contacts["c0_1"].normal + motion.contacts["c0_2"].normal
    np.testing.assert_allclose(lowest, 10 * G, rtol=1e-9)


@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_block_sticks_or_slips_a_tenth_of_a_percent_beside_its_angle(mu):
    for part in (0.999, 1.001):
        angle = math.atan(mu) * part
        motion = fb.simulate(block(angle, mu), 10, initial={"y": 0.1}, method="timestepping", step=0.01)
        a = max(0.0, G * (math.sin(angle) - mu * math.cos(angle)))
        assert motion["x"][-1] == pytest.approx(50 * a, rel=1e-8, abs=1e-12)


def test_cone_in_space_is_a_disk_and_not_a_pyramid():
    # pulled just below and above mu N in many directions, a point on a plane holds or slips along the pull
    s = fb.System("puck")
    mu, fx, fy = s.parameters(mu=0.3, fx=0, fy=0)
    s.gravity = (0, 0, -G)
    a, b, c = (s.body(n, fb.particle(1)) for n in "abc")
    s.slider("x", s.ground, a, axis="x", coordinate="x")
    s.slider("y", a, b, axis="y", coordinate="y")
    s.slider("z", b, c, axis="z", coordinate="z")
    s.contact("floor", c.point(0, 0, 0), s.ground.plane(normal="z"), friction=mu)
    s.force("F", c.origin, (fx, fy, 0))
    for angle in np.linspace(0, 2 * np.pi, 7):
        for part in (1 - 1e-6, 1 + 1e-6):
            F = part * 0.3 * G
            values = {"fx": F * math.cos(angle), "fy": F * math.sin(angle)}
            motion = fb.simulate(s, 1, values=values, method="timestepping", step=0.02)
            speed = motion["x'"][-1] * math.cos(angle) * 3 + motion["y'"][-1] * math.sin(angle) * 2
            assert speed == pytest.approx(max(0.0, F - 0.3 * G), abs=1e-9)
            assert motion.residual <= 1e-12


def test_first_order_towards_the_exact_motion():
    s = fb.System("disk")
    R, m, g, mu = s.parameters(R=0.3, m=10, g=G, mu=0.2)
    s.gravity = (0, -g, 0)
    body = s.body("disk", fb.disk(m, R))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(R), s.ground.plane(normal="y"), friction=mu)
    start = {"y": 0.3, "x'": 3.0}
    exact = fb.simulate(s, 1, initial=start).at(1)
    errors = []
    for h in (1e-2, 1e-3):
        motion = fb.simulate(s, 1, initial=start, method="timestepping", step=h)
        errors.append(abs(motion.at(1)["x"] - exact["x"]))
        assert motion.at(1)["x'"] == pytest.approx(2, abs=5 * h)
        assert motion.energy.relative_residual < 5 * h
    assert errors[1] < 0.3 * errors[0] + 1e-12


def test_bounce_and_events_and_data():
    s = fb.System("ball")
    (e,) = (s.parameters(e=0.5),)
    s.gravity = (0, -G, 0)
    ball = s.body("ball", fb.disk(1, 0.1))
    s.planar("rail", s.ground, ball, coordinate="x y turn")
    s.contact("floor", ball.circle(0.1), s.ground.plane(normal="y"), friction=0, restitution=e)
    motion = fb.simulate(s, 2, initial={"y": 1.1}, method="timestepping", step=1e-3, events=["y - 0.6"])
    crossed, *bounces = motion.events  # rises to 0.35 only after
    assert (crossed.name, crossed.direction) == ("y - 0.6", -1)
    assert crossed.time == pytest.approx(math.sqrt(1 / G), abs=1e-3)
    assert str(bounces[0]) == "t = 0.452 s: contact floor: open → slip, the gap closed"
    # each flight is half as long as the last; one shorter than a step is none
    flights = [change.end - change.start for change in motion.modes.of("floor") if change.mode == "open"]
    assert len(flights) == len(bounces) // 2 + 1
    np.testing.assert_allclose(flights[1:5], math.sqrt(2 / G) * 0.5 ** np.arange(4), atol=2e-3)
    assert (
        motion.modes[-1].mode == "slip" and np.abs(motion.path.states[-1] - [0, 0.1, 0, 0, 0, 0]).max() < 1e-9
    )
    assert motion.depth < 1e-9
    assert motion.energy.impulses[-1] == pytest.approx(-G, rel=0.02)
    data = motion.data
    assert data.attrs["method"].startswith("Moreau-Jean")
    assert {"floor.gap", "floor.normal", "floor.mode"} <= set(data)


def test_closed_loops_stay_closed():
    s = fb.System("pendulum on a rod of given length, that hits the floor")
    s.gravity = (0, -G, 0)
    ball = s.body("ball", fb.disk(1, 0.1))
    s.planar("rail", s.ground, ball, coordinate="x y turn")
    s.constrain("x^2 + (y - 1)^2 - 1", name="rod")
    s.contact("floor", ball.circle(0.1), s.ground.plane(normal="y"), friction=0.3)
    motion = fb.simulate(
        s, 1, initial={"x": 1, "y": 1}, near={"x": 1, "y": 1}, method="timestepping", step=1e-3
    )
    assert np.abs(motion["x^2 + (y - 1)^2 - 1"]).max() < 1e-8
    assert motion.depth < 1e-9


def test_refusals():
    s = block(0.1, 0.5)
    for options, text in (
        ({}, "Expected the length of a step"),
        ({"step": 0}, "Expected a step greater than 0 s"),
    ):
        with pytest.raises(SimulationError, match=text):
            fb.simulate(s, 1, initial={"y": 0.1}, method="timestepping", **options)
    with pytest.raises(SimulationError, match=r"contacts 'foot_1' 0\.1 m deep, 'foot_2'"):
        fb.simulate(s, 1, method="timestepping", step=0.01)
    with pytest.raises(SimulationError, match="no way back"):
        fb.simulate(s, -1, initial={"y": 0.1}, method="timestepping", step=0.01)


def test_machines_without_contacts_move_by_the_midpoint_rule():
    """A contact that never closes changes nothing, and a body that flies keeps its energy and its momenta."""
    found = []
    for far in (False, True):
        s = fb.System("free")
        body = s.body("b", fb.box(1, (1, 2, 3)))
        s.free("f", s.ground, body)
        if far:
            s.contact("far", body.origin, s.ground.plane(at=(0, -50, 0)), friction=0.3)
        start = {"f_wx": 1, "f_wy": 0.1, "f_wz": 0.2, "f_vx": 1}
        motion = fb.simulate(s, 5, initial=start, method="timestepping", step=1e-2)
        found.append(motion.path.states)
        assert np.ptp(motion.energy.kinetic) < 1e-13 and np.ptp(motion["f_vx"]) > 0.01
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("damping", [0, 4])
def test_a_lone_soft_stop(damping):
    """Its switches are events; the motion comes to that by events as the steps become shorter."""
    s = fb.System("pendulum at a soft wall")
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar(1, 1, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, 0.5, 0), axis="z", coordinate="theta")
    s.stop("wall", pin, low=0, stiffness=500, damping=damping)
    exact = fb.simulate(s, 1.2, initial={"theta": 0.5})
    for step in (1e-3, 1e-4):
        motion = fb.simulate(s, 1.2, initial={"theta": 0.5}, method="timestepping", step=step)
        assert (
            [x.name for x in motion.events]
            == ["wall touches", "wall leaves"]
            == [x.name for x in exact.events]
        )
        assert max(abs(a.time - b.time) for a, b in zip(motion.events, exact.events, strict=True)) < step
        assert abs(motion["theta"][-1] - exact["theta"][-1]) < step
        assert motion.modes == [] and motion.contacts == {}
    batch = fb.simulate(
        s, 1, initial={"theta": [0.5, 0.6]}, outputs="theta", method="timestepping", step=1e-3
    )
    alone = fb.simulate(s, 1, initial={"theta": 0.6}, method="timestepping", step=1e-3)
    assert batch["theta"][1, -1] == alone["theta"][-1]


def test_a_terminal_event_stops_between_two_steps():
    s = fb.System("disk")
    R, m, g, mu = s.parameters(R=0.3, m=10, g=9.81, mu=0.2)
    s.gravity = (0, -g, 0)
    body = s.body("disk", fb.disk(m, R))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("floor", body.circle(R), s.ground.plane(normal="y"), friction=mu)
    events = [fb.event("x - 2.0005", terminal=True), fb.event("x - 1")]
    options = {"initial": {"y": 0.3, "x'": 3}, "events": events}
    motion = fb.simulate(s, 3, method="timestepping", step=1e-3, **options)
    assert motion.status == "terminal event"
    assert [event.name for event in motion.events] == ["x - 1", "floor", "x - 2.0005"]
    assert [change.mode for change in motion.modes] == ["slip+", "stick"]
    assert motion["x"][-1] == pytest.approx(2.0005, abs=1e-12)
    # of first order in the step
    assert motion.t[-1] == pytest.approx(fb.simulate(s, 3, **options).path.end, abs=1e-3)
    assert motion.contacts["floor"].normal[-1] == pytest.approx(98.1, rel=1e-9)
    assert abs(motion.energy.residual[-1]) < 1e-3 * 45


def resting():
    s = fb.System("block")
    s.gravity = (0, -G, 0)
    body = s.body("block", fb.box(2, (1, 0.2, 1)))
    s.planar("rail", s.ground, body, coordinate="x y turn")
    s.contact("foot", body.corners(size=(1, 0.2)), s.ground.plane(normal="y"), friction=0.3)
    return s, body


def test_a_blow_is_solved_together_with_the_contacts():
    s, body = resting()
    h = 0.01
    kick = fb.blow(0.105, at=body.point(0, -0.1, 0), impulse=(3, -2, 0), name="kick")
    motion = fb.simulate(s, 0.2, initial={"y": 0.1}, method="timestepping", step=h, impulses=kick)
    # in its step, friction is the limit of the floor's whole impulse: 2 v = 3 - 0.3 (2 + 2 g h)
    before, after = motion.at(0.1), motion.at(0.11)
    assert before["x'"] == pytest.approx(0, abs=1e-14)
    assert after["x'"] == pytest.approx((3 - 0.3 * (2 + 2 * G * h)) / 2, rel=1e-12)
    assert after["turn'"] == pytest.approx(0, abs=1e-12)
    assert "t = 0.1 s: kick: x' " in str(motion.events[0]) and " → 1.17057" in str(motion.events[0])
    assert motion.course.impulses.contacts[10].sum() == pytest.approx((2 + 2 * G * h) * (1 - 0.3), rel=1e-12)
    # the ledger has what the blow gave; friction takes it away at first order
    assert abs(motion.energy.residual[-1]) < 1e-12
    # the rail transmits nothing in its plane, struck or not
    assert np.abs(motion.reactions["rail"].force).max() < 1e-9


def test_a_blow_where_an_expression_passes_zero():
    s, body = resting()
    blow = fb.blow("x - 0.1", at=body, impulse=(-4, 0, 0), name="back", count=1)
    motion = fb.simulate(
        s, 1, initial={"y": 0.1, "x'": 1.5}, method="timestepping", step=1e-3, impulses=[blow], times=[0, 1]
    )
    (back,) = [event for event in motion.events if event.name == "back"]
    passed = (1.5 - math.sqrt(1.5**2 - 2 * 0.3 * G * 0.1)) / (0.3 * G)
    assert back.time == pytest.approx(passed, abs=1e-3)
    assert back.after["x'"] - back.state["x'"] == pytest.approx(-2, abs=0.3 * G * 1e-3 + 1e-9)
    assert back.state["x"] < 0.1
    assert abs(motion.energy.residual[-1]) < 1e-10


def test_reactions_are_means_over_a_step():
    # a pendulum of which the tip strikes a stop: the pin carries the impulse h R of the step
    s = fb.System("pendulum at a stop")
    s.gravity = (0, -G, 0)
    bar = s.body("bar", fb.slender_bar(2, 1.2, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, 0.6, 0), axis="z", coordinate="a")
    s.contact("stop", bar.point(0, -0.6, 0), s.ground.plane(at=(0, 0, 0), normal="x"), friction=0)
    h = 1e-3
    motion = fb.simulate(s, 0.5, initial={"a": 0.5}, method="timestepping", step=h)
    assert isinstance(motion.reactions["pin"].on, str)
    times = motion.path.times
    again = fb.simulate(s, 0.5, initial={"a": 0.5}, method="timestepping", step=h, times=times)
    k = int(np.argmax(again.contacts["stop"].normal))
    struck = fb.impulse(
        fb.equations(s, modes={}), at=bar.point(0, -0.6, 0), normal=(1, 0, 0), restitution=0, values={},
        initial={"a": 0.0, "a'": float(again["a'"][k - 1])},
    )  # fmt: skip
    exact = np.array([float(x) for x in struck.reactions["pin"].impulse])
    assert again.reactions["pin"].force[k] * h == pytest.approx(exact, abs=30 * h)
    # at rest, a gap of 1e-10 m is an angle that moves 1e-9 of the weight
    assert again.reactions["pin"].force[-1] == pytest.approx([0, 2 * G, 0], abs=1e-8)
    assert {"pin.force", "stop.normal"} <= set(again.data)


def slope(errors):
    return math.log(errors[0] / errors[-1]) / math.log(2) / (len(errors) - 1)


def test_of_first_order_in_a_smooth_phase_and_through_an_impact():
    s, _ = resting()
    smooth, struck = [], []
    exact = 1.5**2 / (2 * 0.3 * G)
    ball = fb.System("ball")
    ball.gravity = (0, -G, 0)
    b = ball.body("b", fb.particle(1))
    ball.slider("rail", ball.ground, b, axis="y", coordinate="y")
    ball.contact("floor", b.point(0, 0, 0), ball.ground.plane(normal="y"), friction=0, restitution=0.7)
    hit = math.sqrt(2 / G)
    for h in (8e-3, 4e-3, 2e-3, 1e-3, 5e-4):
        run = {"method": "timestepping", "step": h}
        # a block that slides until it rests
        smooth.append(abs(fb.simulate(s, 0.8, initial={"y": 0.1, "x'": 1.5}, **run).at(0.8)["x"] - exact))
        # a ball after its first bounce, over starts that place the impact anywhere in a step
        off = []
        for k in range(8):
            t = hit + 0.2 + k * h / 8
            after = 0.7 * G * hit * (t - hit) - G / 2 * (t - hit) ** 2
            off.append(abs(fb.simulate(ball, t, initial={"y": 1}, start=0, **run).path.states[-1, 0] - after))
        struck.append(max(off))
    assert smooth[-1] < 1e-5 and slope(smooth) > 0.9
    assert 0.7 < slope(struck) < 1.5


def test_a_point_leaves_the_end_of_a_side():
    s = fb.System("ledge")
    s.gravity = (0, -G, 0)
    carrier, ball = s.body("carrier", fb.particle(0.5)), s.body("ball", fb.particle(1))
    s.slider("across", s.ground, carrier, axis="x", coordinate="x")
    s.slider("up", carrier, ball, axis="y", coordinate="y")
    side = s.ground.segment((-1, 0, 0), (1, 0, 0), normal=(0, 1, 0))
    s.contact("side", ball.point(0, 0, 0), side, friction=0)
    motion = fb.simulate(s, 1, initial={"x": 0.5, "x'": 1}, method="timestepping", step=1e-3)
    assert [(change.mode, round(change.start, 9)) for change in motion.modes] == [("slip+", 0), ("open", 0.5)]
    assert motion.at(1)["y"] == pytest.approx(-G / 8, abs=1e-9)
    assert repr(motion).endswith("2 coordinates, 1 event, finished")


def test_ten_boxes_in_space_stay_on_their_forty_corners():
    s = fb.System("stack")
    s.gravity = (0, 0, -G)
    below, start = s.ground.plane(normal="z"), {}
    for i in range(10):
        box = s.body(f"b{i}", fb.box(1, (1, 1, 0.5)))
        s.free(f"f{i}", s.ground, box)
        corners = [(x, y, -0.25) for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
        s.contact(f"c{i}", box.corners(*corners), below, friction=0.5)
        below = box.plane(at=(0, 0, 0.25), normal="z")
        start[f"f{i}_z"] = 0.25 + 0.5 * i
    motion = fb.simulate(s, 100, initial=start, method="timestepping", step=0.01)
    assert np.abs(motion.path.states - motion.path.states[0]).max() < 1e-9
    assert motion.depth < 1e-9 and motion.residual <= 1e-12


def kanes_rod() -> tuple[fb.System, dict[str, float]]:
    s = fb.System("rod")
    s.gravity = (0, -9.81, 0)
    rod = s.body("rod", fb.slender_bar(1, 0.6, axis="x"))
    s.planar("rail", s.ground, rod, coordinate="x y turn")
    ends = rod.corners((-0.3, 0, 0), (0.3, 0, 0))
    s.contact("ends", ends, s.ground.plane(normal="y"), friction=1, restitution=1)
    return s, {"y": 0.3, "turn": 0.8, "x'": 0.2, "y'": -1.0}


def test_newtons_law_that_would_make_energy_has_less_restitution():
    """A rod of Kane: elastic and rough. Steps tend to the motion between events, and never gain by an impact."""
    s, start = kanes_rod()
    exact = fb.simulate(s, 0.1, initial=start)
    assert any("restitution reduced to" in str(event) for event in exact.events)
    errors = []
    for h in (1e-3, 1e-4):
        motion = fb.simulate(s, 0.1, initial=start, method="timestepping", step=h, samples=round(0.1 / h) + 1)
        assert np.diff(motion.energy.impulses).max() <= 1e-12 and motion.reduced == 1
        errors.append(np.abs(motion.states[-1] - exact.states[-1, :6]).max())
    assert errors[1] < 0.2 * errors[0]


def test_energy_that_one_body_would_gain_is_not_paid_by_another_that_loses_it():
    """A heavy lump that does not rebound falls in the step in which a rod of Kane hits the floor."""
    options: dict[str, Any] = {"method": "timestepping", "step": 1e-3, "samples": 101}
    s, start = kanes_rod()
    alone = fb.simulate(s, 0.1, initial=start, **options)
    hit = 0.0643  # within the step in which the rod does
    s, start = kanes_rod()
    lump = s.body("lump", fb.disk(100, 0.1))
    s.planar("air", s.ground, lump, coordinate="x2 y2 turn2")
    s.contact("fall", lump.point(0, 0, 0), s.ground.plane(normal="y"), friction=0)
    start |= {"x2": 5.0, "y2": 2.0 * hit + 9.81 * hit**2 / 2, "y2'": -2.0}
    both = fb.simulate(s, 0.1, initial=start, **options)
    assert both.reduced == alone.reduced == 1
    for name in ("x", "y", "turn"):
        assert np.abs(both[name] - alone[name]).max() < 1e-12


def test_the_length_of_pieces_changes_no_bit(monkeypatch):
    """Pieces of steps end by the clock; the time of a step is that of the grid, wherever its piece begins."""
    s = fb.System("shaken")
    s.gravity = (0, -9.81, 0)
    box = s.body("box", fb.box(1, (0.2, 0.1, 0.1)))
    s.planar("plane", s.ground, box, coordinate="x y turn")
    s.force("F", box.origin, ("8*sin(7*t)", 0, 0))
    s.contact("floor", box.corners((-0.1, -0.05, 0), (0.1, -0.05, 0)), s.ground.plane(), friction=0.4)
    ends = []
    for few in (16, 7, 1):
        monkeypatch.setattr(timestepping, "FEW", few)
        motion = fb.simulate(s, 0.5, initial={"y": 0.05}, method="timestepping", step=1e-3)
        ends.append(motion.path.states)
    assert (ends[0] == ends[1]).all()
    assert (ends[0] == ends[2]).all()
