"""One-sided constraints: what is said where a rope pushes, a wheel is pulled down, a groove left."""

import json
import math
import pickle
import re

import numpy as np
import pytest

import freebody as fb
from freebody.cli import main
from freebody.gallery import entries

G = 9.81


def stone(**kind):
    """A stone on a string of 1 m."""
    s = fb.System("stone on a string")
    m, L, g = s.parameters(m=1.0, L=1.0, g=G)
    s.gravity = (0, -g, 0)
    carrier, body = s.body("carrier", fb.particle(0)), s.body("stone", fb.particle(m))
    s.slider("across", s.ground, carrier, axis="x", coordinate="x")
    s.slider("up", carrier, body, axis="y", coordinate="y")
    s.rope([s.ground.origin, body.origin], L, name="string", **kind)
    return s


def disk(**kind):
    """A rolling disk on an incline of 30 degrees."""
    s = fb.System("disk")
    m, R, g, mu = s.parameters(m=2.0, R=0.3, g=G, mu=0.3)
    s.gravity = (g / 2, 0, -g * 3**0.5 / 2)
    body = s.body("disk", fb.disk(m, R))
    s.free("air", s.ground, body)
    s.rolling("floor", body, radius=R, axis="z", normal="z", **kind)
    return s


UPRIGHT = {"air": fb.Rotation.euler("XYZ", math.pi / 2, 0, 0)}
BOTTOM = {"x": 0, "y": -1}
# between 2 g L and 5 g L the string goes slack where v² = g L cos(angle): at the height (v₀² - 2 g L)/(3 g)
SQUARES = np.array([2.2, 3.0, 4.1, 4.9])
SLOW, FAST = 1.9, 5.1


@pytest.mark.parametrize("method", ["auto", "dop853", "dop54", "radau", "gauss"])
def test_string_goes_slack_where_it_must(method):
    s, bound = stone(), 1e-8 if method in ("radau", "dop54") else 1e-9
    for factor in (SLOW, *SQUARES, FAST):
        motion = fb.simulate(s, 1.5, initial={**BOTTOM, "x'": math.sqrt(factor * G)}, method=method)
        if factor in (SLOW, FAST):
            assert motion.warnings == () and motion.status == "finished" and motion.events == []
            continue
        (warning,) = motion.warnings
        first = motion.events[0]
        assert (first.name, first.time, first.direction) == ("string slack", warning.time, -1)
        assert first.state["y"] == pytest.approx((factor - 2) / 3, abs=bound)
        assert motion.status == "finished, not physical"
        assert len(warning.spans) == len(motion.events)
        # the tension at the highest point of the part is the least
        tension = motion.multipliers["string"]
        assert warning.value <= tension.min() + 1e-9
        assert warning.value == pytest.approx(tension.min(), abs=0.02)
        beyond = np.zeros(len(motion.t), dtype=bool)
        for begin, end in warning.spans:
            beyond |= (motion.t > begin) & (motion.t <= end)
        assert np.array_equal(tension < 0, beyond)


@pytest.mark.parametrize("method", ["auto", "dop853"])
def test_lane_is_told_as_the_run_alone(method):
    """Eight lanes wide and one by one."""
    s, speeds = stone(), np.sqrt(np.array([SLOW, *SQUARES, FAST, 2.5, 3.5, 4.5, 1.0]) * G)
    lanes = fb.simulate(s, 1.5, initial={**BOTTOM, "x'": speeds}, method=method)
    assert lanes.event.values.tolist() == ["string slack"]
    for k, speed in enumerate(speeds):
        alone = fb.simulate(s, 1.5, initial={**BOTTOM, "x'": speed}, method=method)
        assert lanes.status.values[k] == alone.status
        assert lanes.event_count.values[k, 0] == len(alone.events)
        assert lanes.blame.values[k] == ("string slack" if alone.warnings else "")
        if alone.warnings:
            assert lanes.event_time.values[k, 0] == pytest.approx(alone.warnings[0].time, abs=1e-12)


def test_start_beyond_the_limit():
    s, top = stone(), {"x": 0, "y": 1}
    slow, fast = 0.5 * math.sqrt(G), 1.1 * math.sqrt(G)
    motion = fb.simulate(s, 0.2, initial={**top, "x'": slow})
    assert motion.warnings[0].time == 0 and motion.events[0].time == 0
    assert motion.warnings[0].value == pytest.approx(slow**2 - G)
    assert fb.simulate(s, 0.2, initial={**top, "x'": fast}).warnings == ()
    for count in (2, 9):  # one after another, and eight at a time
        speeds = np.linspace(slow, fast, count)
        lanes = fb.simulate(s, 0.2, initial={**top, "x'": speeds}, near={"y": 1}, method="dop853")
        begun = speeds < math.sqrt(G)
        assert ((lanes.status.values == "finished, not physical") == begun).all()
        assert (lanes.event_time.values[begun] == 0).all() and np.isnan(lanes.event_time.values[~begun]).all()


def test_sweep_tells_whom_to_blame():
    data = fb.sweep(stone(), {"x'": np.sqrt(np.array([1.0, 3.0]) * G), "m": [1, 2]}, 1, initial=BOTTOM)
    assert data.status.values.tolist() == [["finished"] * 2, ["finished, not physical"] * 2]
    assert data.blame.values.tolist() == [[""] * 2, ["string slack"] * 2]


def test_other_events_stop_lanes_as_before():
    high = fb.event("y - 0.2", name="high", terminal=True, direction=1)
    speeds = np.sqrt(np.array([1.0, 2.2, 3.0, 5.2]) * G)
    lanes = fb.simulate(stone(), 1, initial={**BOTTOM, "x'": speeds}, events=[high])
    assert lanes.status.values.tolist() == [
        "finished", "finished, not physical", "terminal event", "terminal event",
    ]  # fmt: skip
    assert lanes.event.values.tolist() == ["high", "string slack"]


def test_slack_string_flies_on_a_parabola():
    speed = math.sqrt(3 * G)
    motion = fb.simulate(stone(taut=False), 1.3, initial={**BOTTOM, "x'": speed})
    assert [change.mode for change in motion.modes] == ["slip", "open", "slip"]
    slack, taut = motion.modes[1].start, motion.modes[1].end
    begin = motion.at(slack)
    assert begin["y"] == pytest.approx(1 / 3, abs=1e-9)
    t = np.linspace(0, taut - slack, 30)[:-1]
    flight = motion.at(slack + t)
    assert flight["x"] == pytest.approx(begin["x"] + begin["x'"] * t, abs=1e-9)
    assert flight["y"] == pytest.approx(begin["y"] + begin["y'"] * t - G / 2 * t**2, abs=1e-9)
    # where the parabola meets the circle again: the string's angle and speed give the time 4 sin(a) v/g, v² = g cos(a)
    cosine = 1 / 3
    expected = 4 * math.sqrt(1 - cosine**2) * math.sqrt(cosine / G)
    assert taut - slack == pytest.approx(expected, abs=1e-9)
    assert motion.warnings == () and motion.contacts["string"].normal.min() >= 0


@pytest.mark.parametrize("e", [0, 0.5, 1])
def test_string_is_pulled_taut_with_its_restitution(e):
    initial = {"x": 0.6, "y": 0, "x'": 2, "y'": 0.5}
    motion = fb.simulate(stone(taut=False, restitution=e), 0.5, initial=initial, values={"g": 0})
    hit = next(event for event in motion.events if "impact" in str(event))
    place = np.array([hit.state["x"], hit.state["y"]])
    before, after = (np.array([state["x'"], state["y'"]]) for state in (hit.state, hit.after))
    assert place @ place == pytest.approx(1)
    assert place @ after == pytest.approx(-e * (place @ before))
    across = np.array([-place[1], place[0]])
    assert across @ after == pytest.approx(across @ before)  # no impulse across the string


def test_lanes_of_slack_strings():
    speeds = np.sqrt(np.array([1.5, 3.0, 5.5]) * G)
    lanes = fb.simulate(
        stone(taut=False), 1, initial={**BOTTOM, "x'": speeds}, outputs=["string.mode", "min(string.gap)"]
    )
    slack = [(lanes["string.mode"].values[k] == "open").any() for k in range(3)]
    assert slack == [False, True, False] and (lanes["min(string.gap)"].values > -1e-9).all()


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-9, 1e-5])
def test_random_lanes_are_told_as_runs_alone(tolerance):
    """Disks that roll, spin and fall in any way: what eight lanes skip holds no zero."""
    rng, s, count = np.random.default_rng(3), disk(), 150
    s.gravity = (0, 0, -G)
    tilt, spin = rng.uniform(-1.2, 1.2, count) - math.pi / 2, rng.uniform(-15, 15, (count, 3))
    turned = np.array([[math.cos(a / 2), math.sin(a / 2), 0, 0] for a in tilt])
    start = {"air": turned, **{f"air_w{x}": spin[:, i] for i, x in enumerate("xyz")}}
    options = {"near": {"air_z": 0.3}, "tolerance": tolerance}
    for method in ("auto", "dop853"):
        lanes = fb.simulate(s, 1, initial=start, method=method, **options)
        assert 0 < (lanes.status.values == "finished").sum() < count
        for k in range(count):
            try:
                alone = fb.simulate(
                    s, 1, initial={n: x[k] for n, x in start.items()}, method=method, **options
                )
            except fb.FreebodyError as error:
                alone = error.trajectory
            assert lanes.event_count.values[k, 0] == len(alone.events)
            if alone.warnings:
                assert lanes.event_time.values[k, 0] == pytest.approx(alone.warnings[0].time, abs=1e-9)


def test_rod_may_push():
    motion = fb.simulate(stone(unilateral=False), 1, initial={**BOTTOM, "x'": math.sqrt(3 * G)})
    assert motion.multipliers["string"].min() < -4 and motion.warnings == ()
    assert motion.status == "finished" and motion.events == []


def test_machines_without_one_sided_parts_have_no_more_code():
    """The rod's lanes watch nothing, and a run of the rope compiles its limits only when it is asked."""
    s = stone()
    motion = fb.simulate(s, 1, initial={**BOTTOM, "x'": 5})
    assert "limits" not in motion.kernels.programs
    rod = fb.simulate(stone(unilateral=False), 1, initial={**BOTTOM, "x'": 5})
    assert np.array_equal(motion.path.states, rod.path.states)
    assert motion.warnings and "limits" in motion.kernels.programs
    lanes = fb.simulate(stone(unilateral=False), 1, initial={**BOTTOM, "x'": np.linspace(1, 6, 9)})
    assert "event" not in lanes.dims


def test_no_force_at_all_is_no_alarm():
    """Two bodies that fall side by side on a rope: its tension is round-off, of either sign."""
    s = fb.System("fall")
    s.gravity = (0, -G, 0)
    a, b = (s.body(name, fb.sphere(mass, 0.05)) for name, mass in (("a", 1), ("b", 2)))
    s.free("A", s.ground, a)
    s.free("B", s.ground, b)
    s.rope([a.origin, b.origin], 0.7, name="line")
    angles = np.linspace(0.1, 6, 9)
    starts = {"B_x": 0.7 * np.cos(angles), "B_y": 0.7 * np.sin(angles), "A_vx": 0.3, "B_vx": 0.3}
    lanes = fb.simulate(s, 1, initial=starts)
    assert (lanes.status.values == "finished").all() and np.isnan(lanes.event_time.values).all()
    one = fb.simulate(s, 1, initial={name: np.broadcast_to(x, 9)[4] for name, x in starts.items()})
    assert one.warnings == () and np.abs(one.multipliers["line"]).max() < 1e-12


def test_friction_that_rolling_needs():
    """tan(a)/3 on an incline: met exactly it is enough."""
    s, enough = disk(friction="mu"), math.tan(math.pi / 6) / 3
    near = {"air_z": 0.3}
    for mu in (enough * (1 + 1e-9), enough, enough * (1 - 1e-9)):
        assert fb.simulate(s, 0.5, initial=UPRIGHT, near=near, values={"mu": mu}).warnings == ()
    motion = fb.simulate(s, 0.5, initial=UPRIGHT, near=near, values={"mu": 0.9 * enough})
    (warning,) = motion.warnings
    assert (warning.event, warning.time) == ("floor slips", 0)
    assert warning.value == pytest.approx(-0.1 * enough * 2 * G * math.cos(math.pi / 6))
    lanes = fb.simulate(s, 0.5, initial=UPRIGHT, near=near, values={"mu": enough * np.array([0.9, 1.1] * 5)})
    assert lanes.blame.values.tolist() == ["floor slips", ""] * 5


def test_wheel_that_is_pulled_down():
    """An eccentric wheel leaps where m e w² > m g at its highest point."""
    s = fb.System("eccentric wheel")
    m, R, e, g = s.parameters(m=1.0, R=0.3, e=0.2, g=G)
    s.gravity = (0, -g, 0)
    wheel = s.body(
        "wheel", fb.MassProperties(m, center=(0, e, 0), inertia=((0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.02)))
    )
    s.planar("plane", s.ground, wheel, coordinate="x y turn")
    s.rolling("road", wheel, radius=R, axis="z")
    for rate in (3.0, 9.0):
        motion = fb.simulate(s, 1, initial={"turn'": -rate}, near={"y": 0.3})
        normal = motion.multipliers["road_y"]
        assert bool(motion.warnings) == (normal.min() < 0) == (rate == 9.0)
        for warning in motion.warnings:
            assert (warning.name, warning.event) == ("road", "road lifts off")
            assert warning.value == pytest.approx(normal.min(), abs=1e-3 * np.ptp(normal))


def test_bead_leaves_an_open_dome():
    s = fb.System("bead")
    s.gravity = (0, -G, 0)
    carrier, bead = s.body("carrier", fb.particle(0)), s.body("bead", fb.particle(1))
    s.slider("across", s.ground, carrier, axis="x", coordinate="x")
    s.slider("up", carrier, bead, axis="y", coordinate="y")
    s.constrain("y - sqrt(1 - x^2)", name="dome", unilateral=True)
    off = fb.event("x - 0.95", terminal=True)
    motion = fb.simulate(s, 2, initial={"x": 0, "y": 1, "x'": 0.5}, events=[off])
    assert motion.events[0].name == "dome leaves"
    assert motion.events[0].state["y"] == pytest.approx(2 / 3 + 0.25 / (3 * G), abs=1e-8)
    assert motion.status == "terminal event, not physical"
    assert "N at worst" not in str(motion.warnings[0])  # the unit of the force is that of the expression


def test_blow_that_pushes_a_rope():
    s = stone()
    body = s.bodies["stone"]
    hit = fb.impulse(s, at=body.origin, impulse=(0, 2, 0), initial=BOTTOM)
    assert hit.warnings[0].value == -2 and hit.warnings[0].unit == "N s"
    assert "not possible: the rope pushes ('string')" in hit.text()
    assert fb.impulse(s, at=body.origin, impulse=(0, -2, 0), initial=BOTTOM).warnings == ()
    blow = fb.blow(0.1, at=body.origin, impulse=(0, 2, 0))
    motion = fb.simulate(s, 0.3, initial=BOTTOM, impulses=[blow])
    assert motion.warnings[0].spans == ((0.1, 0.1),) and motion.status == "finished, not physical"
    lanes = fb.simulate(s, 0.3, initial={**BOTTOM, "x'": [0, 0.1]}, impulses=[blow])
    assert lanes.status.values.tolist() == ["finished, not physical"] * 2
    assert lanes.reason.values[0].startswith("string: the rope pushes, -2 N s at worst (t = 0.1 s)")


def test_impact_that_pushes_a_rope():
    """A stone that swings onto a floor: the rope would take the part of the impulse that is along it."""
    start = {"x": 0.9, "y": -math.sqrt(0.19)}
    s = stone()
    s.contact("floor", s.bodies["stone"].origin, s.ground.plane(at=(0, -0.5, 0)), restitution=1)
    motion = fb.simulate(s, 0.5, initial=start)
    hits = [event for event in motion.events if event.name == "impact"]
    (warning,) = motion.warnings
    assert warning.spans == tuple((hit.time, hit.time) for hit in hits) and len(hits) == 2
    assert motion.status == "finished, not physical" and "not possible: the rope pushes" in str(hits[0])
    # across the floor's normal only the rope acts: m Δx' = -Λ x/L
    change = hits[0].after["x'"] - hits[0].state["x'"]
    assert warning.value == pytest.approx(-change / hits[0].state["x"])
    free = stone(taut=False)
    free.contact("floor", free.bodies["stone"].origin, free.ground.plane(at=(0, -0.5, 0)), restitution=1)
    assert fb.simulate(free, 0.5, initial=start).warnings == ()


def test_what_else_a_run_may_be():
    """Backwards, with sensitivities, with signals and in time steps."""
    s, start = stone(), {**BOTTOM, "x'": math.sqrt(3 * G)}
    slack = fb.simulate(s, 1, initial=start).warnings[0].time
    back = fb.simulate(s, -1, initial=start)
    assert back.warnings[0].time == pytest.approx(-slack, abs=1e-9)
    assert [event.time for event in back.events] == sorted((e.time for e in back.events), reverse=True)
    derived = fb.simulate(s, 1, initial=start, sensitivities=["g"])
    assert derived.warnings[0].time == pytest.approx(slack, abs=1e-9)
    pushed = stone()
    pushed.force("wind", pushed.bodies["stone"].origin, (fb.signal([0, 0.2, 5], [0, 0, 0]), 0, 0))
    assert fb.simulate(pushed, 1, initial=start).warnings[0].time == pytest.approx(slack, abs=1e-9)
    lanes = fb.simulate(pushed, 1, initial={**start, "x'": [1, math.sqrt(3 * G)]})
    assert lanes.event_time.values[1, 0] == pytest.approx(slack, abs=1e-9)
    floor = stone()
    floor.contact("floor", floor.bodies["stone"].origin, floor.ground.plane(at=(0, -5, 0)))
    events = fb.simulate(floor, 1, initial=start)
    assert events.warnings[0].time == pytest.approx(slack, abs=1e-9)
    h = 1e-3
    steps = fb.simulate(floor, 1, initial=start, method="timestepping", step=h)
    assert steps.warnings[0].time == pytest.approx(slack, abs=2 * h) and "not physical" in steps.status


def test_warning_is_a_value():
    motion = fb.simulate(stone(), 1, initial={**BOTTOM, "x'": math.sqrt(3 * G)})
    (warning,) = motion.warnings
    assert isinstance(warning, fb.MotionWarning) and pickle.loads(pickle.dumps(warning)) == warning
    assert str(warning).startswith("string: the rope pushes, -") and "taut=False" in warning.cure
    assert pickle.loads(pickle.dumps(motion._passed)) == motion._passed
    assert "not physical from t = 0.482216 s on: the rope pushes ('string')" in repr(motion)
    assert motion.data.attrs["status"] == motion.status
    assert motion.data["event_name"].values.tolist() == ["string slack"]


def test_gallery_has_no_false_alarms():
    """Of the gallery's machines three have one-sided constraints, and keep to them."""
    for name in ("rolling-disk", "block-and-tackle", "whipple-bicycle"):
        motion = entries()[name].run({}, None, None).trajectory
        assert motion._limits and motion.warnings == ()


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ({"taut": False, "unilateral": False}, "a rod does not go slack"),
        ({"restitution": 0.5}, "Expected no restitution= for rope 'string', which stays taut, got 0.5"),
        ({"taut": 1}, "Expected True or False for taut= of rope 'string', got 1"),
        ({"unilateral": "no"}, "Expected True or False for unilateral= of rope 'string', got 'no'"),
    ],
)
def test_ropes_that_can_not_be(kind, message):
    with pytest.raises(fb.FreebodyError, match=message):
        stone(**kind)


def test_slack_ropes_that_can_not_be():
    s = stone()
    ends = [s.ground.origin, s.ground.point(1, 0, 0), s.bodies["stone"].origin]
    with pytest.raises(fb.FreebodyError, match="runs over 3 points, but a rope that goes slack .* joins two"):
        s.rope(ends, 2, name="long", taut=False)
    with pytest.raises(fb.FreebodyError, match="length of rope 'winch' depends on time"):
        s.rope(ends[1:], 2 - s.t, name="winch", taut=False)
    with pytest.raises(fb.FreebodyError, match="Expected a length greater than 0 m for rope 'none', got 0"):
        s.rope(ends[1:], 0, name="none", taut=False)
    with pytest.raises(
        fb.FreebodyError, match="The friction of rolling 'floor' is bounded by the force that presses"
    ):
        disk(friction=0.3, unilateral=False)


@pytest.mark.parametrize(
    "kind", [{}, {"unilateral": False}, {"taut": False}, {"taut": False, "restitution": 0.25}]
)
def test_files_keep_the_side(kind, tmp_path):
    s = stone(**kind)
    fb.write(s, tmp_path / "stone.toml")
    back = fb.read(tmp_path / "stone.toml")
    start = {**BOTTOM, "x'": math.sqrt(3 * G)}
    one, other = (fb.simulate(system, 0.8, initial=start) for system in (s, back))
    assert one.status == other.status and np.array_equal(one["y"], other["y"])


def test_files_keep_the_side_of_wheels_and_conditions(tmp_path):
    for name, s in (("held", disk(unilateral=False)), ("rough", disk(friction="mu"))):
        s.constrain("air_y", name="rail", unilateral=name == "held")
        fb.write(s, tmp_path / f"{name}.toml")
        back = fb.read(tmp_path / f"{name}.toml")
        for key in ("floor", "rail"):
            a, b = s.constraints[key], back.constraints[key]
            assert a.unilateral == b.unilateral and str(getattr(a, "friction", 0)) == str(
                getattr(b, "friction", 0)
            )


FILE = """
name = "stone on a string"
gravity = [0, -9.81, 0]
[bodies.stone]
solid = "sphere"
mass = 1
radius = 0.05
[joints.fly]
type = "planar"
parent = "ground"
child = "stone"
coordinate = ["x", "y", "turn"]
[constraints.string]
type = "rope"
points = ["ground", "stone"]
length = 1
[run]
until = 0.6
[initial]
x = 0
y = SIDE
"x'" = 5.5
[near]
y = SIDE
"""


def test_command_line_tells(tmp_path, capsys):
    low, high = tmp_path / "low.toml", tmp_path / "high.toml"
    low.write_text(FILE.replace("SIDE", "-1"))
    high.write_text(FILE.replace("SIDE", "1").replace("5.5", "1"))

    def said(*words):
        with pytest.raises(SystemExit) as ended:
            main([str(word) for word in words])
        assert ended.value.code == 0
        return capsys.readouterr().out

    told = said("run", low)
    assert (
        "Warnings:\n  string: the rope pushes, -" in told and "t = 0.481338 s: string: from here on" in told
    )
    data = json.loads(said("run", low, "--json"))
    assert data["status"] == "finished, not physical" and data["warnings"][0]["event"] == "string slack"
    assert "Warning: at rest there the rope pushes ('string', -9.81 N)" in said("check", high)
    assert "Warning" not in said("check", low)
    swept = said("sweep", low, "--vary", "x'=4,5.5", "--until", "0.6")
    assert re.search(r"finished, not physical +1 +1 \(x'_start = 5.5\) +string slack", swept)


def test_report_plot_and_drawing_tell(tmp_path):
    s = stone()
    motion = fb.simulate(s, 1, initial={**BOTTOM, "x'": math.sqrt(3 * G)})
    page = fb.report(s, motion, tmp_path / "page.html", equations=False).read_text()
    assert "<h2>Warnings</h2>" in page and "string: the rope pushes" in page
    assert "string slack" in [text.get_text() for text in motion.plot().get_legend().get_texts()]
    slack = fb.draw(stone(taut=False), at={"x": 0.3, "y": -0.6}).svg
    assert 'class="rope"' in slack


@pytest.mark.parametrize("method", ["radau", "dop853"])
def test_a_lane_that_collapses_beyond_a_limit_takes_no_other_along(method: str) -> None:
    """The rope's force passes zero in the last step, in which shorter steps of an implicit method need not converge."""
    entry = entries()["block-and-tackle"]
    masses = [1.0, 1.1, 1.2, 100.0]
    data = fb.simulate(
        entry.build(), 3.0, near=entry.near, values={"M": masses}, method=method, samples=3, threads=1
    )
    assert data.status.values[:3].tolist() == ["step collapsed"] * 3
    assert data.status.values[3].startswith("finished")
