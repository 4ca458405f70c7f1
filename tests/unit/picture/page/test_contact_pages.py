"""Contacts in the animation, the report and the live page: forces, places, modes, jumps of speed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import freebody as fb
from contact_machines import ball_on_plane, falling_rod, ladder, pulled_disk, sliding_body
from freebody.errors import FreebodyError, SimulationError
from freebody.picture.moving.keyframes import keyframes
from freebody.picture.page import balances
from freebody.picture.page.animation import animation
from freebody.picture.page.live import Live
from freebody.picture.page.sliders import sliders

G = 9.81


def floats(values: Any, *shape: int) -> np.ndarray:
    return np.asarray(values, dtype=np.float32).reshape(-1, *shape)


@pytest.fixture(scope="module")
def bouncing() -> tuple[Any, Any]:
    s = pulled_disk()
    return s, fb.simulate(s, 2.0, initial={"y": 0.3, "x'": 1.0})


@pytest.fixture(scope="module")
def struck() -> tuple[Any, Any]:
    s = fb.System("pendulum")
    s.gravity = (0, -G, 0)
    bar = s.body("bar", fb.slender_bar(1, 1, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, 0.5, 0), axis="z", coordinate="theta")
    blow = fb.blow(0.7, at=bar.point(0, -0.5, 0), impulse=(0.5, 0, 0))
    return s, fb.simulate(s, 2.0, initial={"theta": 0.5}, impulses=[blow])


@pytest.fixture(scope="module")
def stack() -> tuple[Any, Any]:
    s = fb.System("stack")
    s.gravity = (0, -G, 0)
    below, start = s.ground.plane(), {}
    for i in range(1, 11):
        box = s.body(f"box{i}", fb.box(1, (0.4, 0.2, 0.3)))
        s.planar(f"j{i}", s.ground, box, coordinate=f"x{i} y{i} a{i}")
        s.contact(f"c{i}", box.corners((-0.2, -0.1, 0), (0.2, -0.1, 0)), below, friction=0.4)
        below = box.plane(at=(0, 0.1, 0), normal="y")
        start[f"y{i}"] = 0.2 * i - 0.1
    return s, fb.simulate(s, 0.5, initial=start, method="timestepping", step=2e-3)


# --- keyframes ---------------------------------------------------------------------------------------------------


def test_speeds_jump_between_two_keyframes_at_one_time(bouncing):
    _, motion = bouncing
    keys = keyframes(motion)
    fall = np.sqrt(2 * 0.3 / G)
    assert keys.breaks
    k = keys.breaks[0]
    assert keys.t[k - 1] == pytest.approx(fall, rel=1e-9) and keys.t[k] == pytest.approx(fall, rel=1e-9)
    y = motion.names.index("y'")
    before, after = keys.states[k - 1, y], keys.states[k, y]
    assert before == pytest.approx(-G * fall, rel=1e-7)
    assert after == pytest.approx(0.5 * G * fall, rel=1e-7)
    # nothing but positions goes on through it
    assert keys.position[k] == pytest.approx(keys.position[k - 1], abs=1e-9)


def test_every_phase_is_interpolated_as_accurately_as_any_motion(bouncing):
    _, motion = bouncing
    keys = keyframes(motion)
    inside = np.flatnonzero((np.diff(keys.part) == 0) & (np.diff(keys.t) > 1e-4))
    middle = (keys.t[inside] + keys.t[inside + 1]) / 2
    true = motion.at(middle)["y"]
    place = motion.names.index("y")
    straight = (keys.states[inside, place] + keys.states[inside + 1, place]) / 2
    assert np.abs(straight - true).max() <= keys.tolerance * np.abs(keys.states[:, place]).max()


def test_a_blow_makes_two_moments(struck):
    _, motion = struck
    keys = keyframes(motion)
    (k,) = keys.breaks
    assert keys.t[k] == keys.t[k - 1] == pytest.approx(0.7)
    u = motion.names.index("theta'")
    # a blow S at the end of a bar of length L on a hinge: Δω = 3 S cos θ / (m L)
    theta = keys.states[k, motion.names.index("theta")]
    assert keys.states[k, u] - keys.states[k - 1, u] == pytest.approx(3 * 0.5 * np.cos(theta), rel=1e-9)
    # the blow's work is in the ledger, so that nothing is left
    assert np.abs(keys.residual).max() < 1e-7 * np.abs(keys.energy["potential"]).max()


def test_ledger_of_impacts_and_friction(bouncing):
    _, motion = bouncing
    keys = keyframes(motion)
    scale = keys.energy["kinetic"].max()
    assert np.abs(keys.residual).max() < 1e-7 * scale
    assert keys.energy["work"][keys.breaks[0]] < keys.energy["work"][keys.breaks[0] - 1]  # lost in the impact


def test_forces_are_those_of_the_trajectory():
    s = falling_rod()
    start = {"x": -0.5 * np.sin(0.1), "y": 0.5 * np.cos(0.1), "phi": 0.1}
    motion = fb.simulate(s, 0.9, initial=start)
    keys = keyframes(motion)
    touched = keys.touched
    assert touched is not None
    inside = np.setdiff1d(np.arange(len(keys.t)), [k + d for k in keys.breaks for d in (-1, 0)])
    again = fb.simulate(s, 0.9, initial=start, times=keys.t[inside])
    found = again.contacts["O"]
    # two runs agree to their tolerance
    assert touched.forces[0][inside, 0] == pytest.approx(found.normal, rel=1e-5, abs=1e-5)
    assert touched.forces[0][inside, 1] == pytest.approx(found.tangential, rel=1e-5, abs=1e-5)
    N, T = touched.force(0, False), touched.force(0, True)
    assert N[:, 1] == pytest.approx(touched.forces[0][:, 0])
    assert np.abs(N[:, [0, 2]]).max() == np.abs(T[:, [1, 2]]).max() == 0
    foot = keys.position[:, 0] + 0.5 * np.column_stack(
        [np.sin(keys.states[:, 2]), -np.cos(keys.states[:, 2]), np.zeros(len(keys.t))]
    )
    assert touched.place[:, 0] == pytest.approx(foot, abs=1e-12)


# --- the page ----------------------------------------------------------------------------------------------------


def test_the_scene_has_contacts_modes_and_impacts(bouncing):
    _, motion = bouncing
    scene = animation(motion)
    names = {arrow["name"]: arrow for arrow in scene["arrows"]}
    assert {"N_floor", "T_floor"} <= set(names)
    assert names["N_floor"]["group"] == names["T_floor"]["group"] == "reaction"
    place = floats(names["N_floor"]["path"], 3)
    center = floats(scene["bodies"][0]["position"], 3)
    assert place - center == pytest.approx(np.tile([0, -0.3, 0], (len(place), 1)), abs=1e-6)
    (track,) = scene["modes"]
    assert track["contact"] == "floor" and [span[0] for span in track["spans"]] == ["open", "stick"]
    assert track["spans"][0][2] == track["spans"][1][1]
    texts = [text for _, text in scene["events"]]
    assert texts[0].startswith("floor: impact, normal speed")
    assert scene["breaks"] == keyframes(motion).breaks
    (touching,) = scene["touching"]
    closed = floats(touching["closed"])
    t = floats(scene["t"])
    rest = track["spans"][1][1]
    assert not closed[t < rest - 1e-6].any() and closed[t > rest + 1e-6].all()
    titles = [chart["title"] for chart in scene["charts"]]
    assert {"Contact floor: force on disk", "Friction margin: μN - |T|", "Gaps of contacts"} <= set(titles)
    assert len(scene["ground"]["planes"]) == 1
    assert len(animation(fb.simulate(ladder(), 0.1, initial={"y": 1.5}))["ground"]["planes"]) == 2


def test_a_ball_in_space(tmp_path):
    s = ball_on_plane()
    motion = fb.simulate(s, 0.6, initial={"flight_z": 0.3, "flight_vx": 5.0})
    scene = animation(motion)
    assert [arrow["name"] for arrow in scene["arrows"] if arrow["group"] == "reaction"] == [
        "N_floor",
        "T_floor",
    ]
    text = fb.report(s, motion, tmp_path / "ball.html").read_text(encoding="utf-8")
    assert "floor" in text


def test_the_report_shows_the_modes_that_lasted_longest(tmp_path, bouncing):
    s, motion = bouncing
    text = fb.report(s, motion, tmp_path / "disk.html").read_text(encoding="utf-8")
    assert text.count("<h2>Drawing</h2>") == 1
    assert "<h2>Free-body diagrams <small>(floor open; 0.7419 s of the motion)</small></h2>" in text
    assert "<h2>Equations of motion <small>(floor stick; 1.258 s of the motion)</small></h2>" in text
    assert text.count('data-name="N_floor"') == 1 and 'data-name="T_floor"' in text


def test_ten_stacked_boxes_have_a_page(tmp_path, stack):
    s, motion = stack
    page = fb.report(s, motion, tmp_path / "stack.html")
    assert page.stat().st_size < 1_000_000
    scene = animation(motion)
    assert len(scene["touching"]) == 20 and len(scene["bodies"]) == 10
    # at the floor the weight of all ten, shared by two corners
    keys = keyframes(motion)
    touched = keys.touched
    assert touched is not None
    lowest = sum(touched.forces[k][:, 0] for k, name in enumerate(touched.names) if name.startswith("c1_"))
    assert lowest[5:] == pytest.approx(10 * G, rel=1e-6)
    assert len(scene["modes"]) == 20
    assert all(span[0] == "stick" for track in scene["modes"] for span in track["spans"])
    # means over a step: every rail leaves its box to the contacts
    assert np.abs(motion.reactions["j1"].force).max() < 1e-6


def test_hostile_names_of_contacts_stay_text(tmp_path):
    hostile = "</script><script>alert(1)</script>"
    s = fb.System(hostile)
    s.gravity = (0, -G, 0)
    block = s.body("block", fb.sphere(1, 0.1))
    s.planar("plane", s.ground, block, coordinate="x y phi")
    with pytest.raises(FreebodyError):
        s.contact(hostile, block.point(0, 0, 0), s.ground.plane(), friction=0.1)
    s.contact("floor", block.point(0, 0, 0), s.ground.plane(), friction=0.1)
    text = fb.report(s, fb.simulate(s, 0.1), tmp_path / "x.html").read_text(encoding="utf-8")
    assert "<script>alert" not in text


def test_the_live_page_follows_contacts():
    from contact_machines import pulled_disk as machine
    from freebody.formats.case import Case

    s = machine()
    live = Live(Case(s, {"y": 0.2}, 1.0))
    first = live.machine()
    assert "(floor open; " in first["equations"] and "(floor stick; " in first["equations"]
    assert "On disk act its weight, " in first["equations"]
    again = live.motion({"mu": 0.01}, {"x'": 2.0}, 1.0)
    assert any(span[0] == "slip+" for span in again["scene"]["modes"][0]["spans"])
    with pytest.raises(SimulationError):
        live.motion({}, {"z": 1.0}, 1.0)


# --- plots -------------------------------------------------------------------------------------------------------


def test_angles_that_a_motion_writes_have_no_sliders():
    """The points on which a can stands turn with the load."""
    s = fb.System("can")
    s.gravity = (0, 0, -9.81)
    pull = s.parameters(F=1.0)
    can = s.body("can", fb.cylinder(1, 0.1, 0.3))
    s.free("f", s.ground, can)
    s.contact("table", can.circle(0.1, at=(0, 0, -0.15)), s.ground.plane(normal="z"), friction=0.8)
    s.force("push", can.point(0, 0, 0.1), (pull, 0, 0), frame=s.ground)
    motion = fb.simulate(s, 0.1, initial={"f_z": 0.15})
    found = sliders(s, motion.kernels.model, motion.values, {"f_z": 0.15}, {})
    assert [one["name"] for one in found if one["group"] == "values"] == ["F"]


def test_a_motion_of_a_can_is_drawn():
    """The motion's own model has the angles of the points on which it stands, which those of drawings do not have."""
    s = fb.System("can")
    s.gravity = (0, 0, -G)
    can = s.body("can", fb.cylinder(1, 0.1, 0.3))
    s.free("f", s.ground, can)
    s.contact("table", can.circle(0.1, at=(0, 0, -0.15)), s.ground.plane(normal="z"), friction=0.8)
    motion = fb.simulate(s, 0.1, initial={"f_z": 0.15})
    assert 'data-body="can"' in fb.draw(s, trajectory=motion, at=0.05).svg
    pair = fb.free_body_diagram(s, "can", trajectory=motion, at=0.05).svg
    assert pair == fb.free_body_diagram(motion.kernels.model, "can", trajectory=motion, at=0.05).svg


def test_modes_whose_equations_fill_pages_are_named_without_them(tmp_path, bouncing, monkeypatch):
    s, motion = bouncing
    lengths = [
        sum(
            len(x)
            for pair in fb.equations(s, modes={"floor": mode}).balances
            for x in pair
            if hasattr(x, "__len__")
        )
        for mode in ("open", "stick")
    ]
    monkeypatch.setattr(balances, "LONGEST", lengths[0])
    assert lengths[0] < lengths[1]
    text = fb.report(s, motion, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "<h2>Equations of motion <small>(floor open; " in text
    assert (
        "<h2>Equations <small>(floor stick; 1.258 s of the motion)</small></h2>\n<p>Free-body diagrams and"
        in text
    )


def test_no_curve_runs_through_a_jump(bouncing):
    _, motion = bouncing
    ax = motion.plot("y'")
    curves = [line for line in ax.lines if len(line.get_xdata()) > 1 and line.get_linestyle() == "-"]
    fall = np.sqrt(2 * 0.3 / G)
    for line in curves:
        x = np.asarray(line.get_xdata(), dtype=float)
        assert not (x[0] < fall - 1e-9 and x[-1] > fall + 1e-9)
    assert sum(len(line.get_xdata()) for line in ax.lines if line.get_linestyle() == "-") == len(motion.t)
    # a coordinate has no jump
    whole = [line for line in motion.plot("y").lines if line.get_linestyle() == "-"]
    assert len(whole) == 1 and len(whole[0].get_xdata()) == len(motion.t)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["impact, change at floor, rest"]


def test_friction_margin_is_the_rest_of_the_cone():
    s = falling_rod()
    motion = fb.simulate(s, 0.9, initial={"y": 0.5 * np.cos(0.1), "phi": 0.1})
    ax = fb.plot.friction_margin(motion)
    x, y = (
        np.concatenate([np.asarray(part, dtype=float) for part in parts])
        for parts in zip(*((line.get_xdata(), line.get_ydata()) for line in ax.lines[1:]), strict=True)
    )
    slip = next(change.start for change in motion.modes if change.mode.startswith("slip"))
    assert (y[x < slip - 1e-3] > 0).all() and (y[x > slip] == 0).all()
    assert ax.get_xlim() == pytest.approx((0, 0.9))
    N = motion.contacts["O"].normal
    assert y[0] == pytest.approx(0.3 * N[0] - abs(motion.contacts["O"].tangential[0]))


def test_forces_and_gaps(bouncing):
    _, motion = bouncing
    ax = fb.plot.contact_forces(motion, "floor")
    assert [text.get_text() for text in ax.texts][:2] == ["N_floor", "T_floor"]  # beside the curves
    known = [line for line in ax.lines if not np.isnan(line.get_ydata()).any()]
    assert max(float(np.max(line.get_ydata())) for line in known) == pytest.approx(10 * G)
    gaps = fb.plot.contact_gaps(motion, "floor")
    curves = [line for line in gaps.lines if line.get_label() != "_child0"]
    assert max(float(np.max(line.get_ydata())) for line in curves) == pytest.approx(0.3, rel=1e-3)
    quiet = fb.plot.contact_gaps(fb.simulate(sliding_body(), 0.1))
    assert max(map(abs, quiet.get_ylim())) < 1e-8


def test_plots_that_can_not_be_made(bouncing, struck, stack):
    _, motion = bouncing
    with pytest.raises(SimulationError, match="did you mean 'floor'"):
        fb.plot.friction_margin(motion, "flor")
    with pytest.raises(SimulationError, match="'pendulum' has none"):
        fb.plot.friction_margin(struck[1])
    with pytest.raises(SimulationError, match="too many for one plot"):
        fb.plot.contact_gaps(stack[1])
    s = fb.System("smooth")
    s.gravity = (0, -G, 0)
    block = s.body("block", fb.sphere(1, 0.1))
    s.planar("plane", s.ground, block, coordinate="x y phi")
    s.contact("floor", block.point(0, 0, 0), s.ground.plane())
    with pytest.raises(SimulationError, match="has no friction"):
        fb.plot.friction_margin(fb.simulate(s, 0.1), "floor")


def test_a_run_is_drawn_where_its_contacts_are_closed(bouncing):
    """In the middle of the longest time with a contact closed; nowhere for machines without contacts."""
    from freebody.picture.page.longest_phases import lasting_place

    _, motion = bouncing
    place = lasting_place(motion)
    assert list(place) == list(motion.kernels.model.coordinate_names)
    assert place["y"] == pytest.approx(float(motion.at(2.0)["y"]), abs=1e-9)  # it lies on the floor
    assert place["x"] > 0.1
    s = fb.System("free")
    s.slider("rail", s.ground, s.body("bead", fb.particle(1)), axis="x", coordinate="x")
    assert lasting_place(fb.simulate(s, 1, initial={"x'": 1})) == {}
