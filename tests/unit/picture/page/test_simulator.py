"""The live page: its drawing and answers follow the parameters; sliders move it in a browser without a server."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy
from click.testing import CliRunner

import freebody as fb
import page_data
from freebody.cli import command
from freebody.errors import SimulationError
from freebody.gallery import entries
from freebody.picture.page.animation import figure, frames_of, scene_of
from freebody.picture.page.browser import chromium
from freebody.picture.page.follow import Follow
from freebody.picture.page.packing import FINE
from freebody.picture.page.simulator import followed_answers, simulator
from live_machines import double_pendulum, four_bar, motion_of
from page_browser import PageBrowser

LIVE_PART, WHOLE = 60_000, 700_000
in_a_browser = pytest.mark.skipif(chromium() is None, reason="no Chromium on this machine")


def follow(motion: fb.Trajectory) -> tuple[Follow, dict, dict]:
    keys = frames_of(motion, 2e-3)
    scene = scene_of(motion, keys)
    return (
        Follow.of(motion, keys, scene),
        scene,
        {"keys": keys, "size": scene["size"], "up": np.array(scene["up"])},
    )


def at(tree: object, path: list) -> float:
    for key in path:
        tree = tree[key]  # type: ignore[index]
    return float(tree)  # type: ignore[arg-type]


# --- the drawing and the answers -------------------------------------------------------------------------------------


def test_the_drawing_follows_lengths():
    motion = motion_of("four-bar", until=0.5)
    found, scene, context = follow(motion)
    names = [parameter.name for parameter in motion.kernels.model.parameters]
    values = {**motion.values, "a": 1.3, "b": 2.2, "d": 3.7}
    other = figure(motion.kernels.model, values, **context)
    other["arrows"] = [arrow for arrow in other["arrows"] if arrow["channel"] in scene["channels"]]
    assert found.beyond == set() and len(found.numbers) > 10
    for path, value, slopes, tables in found.numbers:
        assert tables == []
        change = sum(slope * (values[names[k]] - motion.values[names[k]]) for k, slope in slopes)
        assert at(other, path) == pytest.approx(value + change, abs=1e-9), path


def test_what_is_not_linear_is_tabulated():
    """A bar whose point of suspension moves on a circle with the angle beta."""
    s = fb.System("mount")
    beta, L = s.parameters(beta=0.3, L=1.0)
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar(1, L, axis="x"))
    s.hinge("pin", s.ground, bar, at=("2*cos(beta)", "2*sin(beta)", 0), axis="z", coordinate="theta")
    motion = fb.simulate(s, 1, initial={"theta'": 1})
    found, _, context = follow(motion)
    assert found.beyond == set() and found.nodes == {0: [0.0, pytest.approx(0.6 / 16)]}
    for angle in (0.05, 0.41, 0.55):
        other = figure(motion.kernels.model, {"beta": angle, "L": 1.0}, **context)
        tabulated = [entry for entry in found.numbers if entry[3]]
        assert tabulated
        for path, value, _, [[k, row]] in tabulated:
            first, step = found.nodes[k]
            change = np.interp(angle, first + step * np.arange(17), row)
            assert at(other, path) == pytest.approx(value + change, abs=1e-3), path


def test_what_follows_in_another_way_has_no_slider():
    """The product of two lengths follows each of them, but not both: one has a slider."""
    s = fb.System("product")
    L, ratio = s.parameters(L=1.0, ratio=0.5)
    bar = s.body("bar", fb.slender_bar(1, L * ratio, axis="x"))
    s.hinge("pin", s.ground, bar, axis="z", coordinate="theta")
    assert follow(fb.simulate(s, 1, initial={"theta'": 1}))[0].beyond == {"ratio"}


def test_no_forces_hold_a_machine_whose_law_has_no_value_at_rest():
    car = entries()["turning-car"]
    s = car.build()
    motion = fb.simulate(s, 0.05, initial=dict(car.start))
    keys = frames_of(motion, 1e-2)
    assert simulator(s, motion, keys, scene_of(motion, keys), {})["holding"] == {}


def test_answers_that_are_formulas_of_parameters_follow():
    outcome = entries()["gyroscope"].run({})
    found = followed_answers(outcome.trajectory, outcome.answers)
    assert {"I_xi", "I_zeta", "psi'_fast", "Omega_min"} <= set(found)
    assert "psi(t_1)" not in found  # it comes from the motion
    a, b, m = (sympy.Symbol(name, real=True) for name in "abm")
    nested = replace(outcome.answers["I_xi"], value=4.8, formula=a**2 / m, where={"a": 2 * b, "b": m})
    (nested_found,) = followed_answers(outcome.trajectory, {"nested": nested}).values()
    assert str(nested_found) == "4*m"  # an abbreviation within another
    motion = motion_of("double pendulum", until=0.1)
    assert followed_answers(motion, {"period": (2.5, "s"), "law": "a < b"}) == {}


# --- the page ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pages(tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("live")
    result = {}
    for name in ("double pendulum", "four-bar"):
        motion = motion_of(name, until=2.0)
        s = {"double pendulum": double_pendulum, "four-bar": four_bar}[name]()
        result[name] = fb.report(s, motion, folder / f"{name}.html", live=True, equations=False)
    return result


def data_of(page: Path) -> dict:
    return page_data.scene_of(page.read_text("utf-8"))


def test_the_page_holds_the_machine_and_its_sliders(pages):
    text = pages["double pendulum"].read_text(encoding="utf-8")
    assert (
        "script-src &#x27;sha256-" in text
        and "&#x27;wasm-unsafe-eval&#x27;" in text
        and "connect-src" not in text
    )
    live = data_of(pages["double pendulum"])["live"]
    sliders = {x["name"]: x for x in live["sliders"]}
    assert list(sliders) == ["m", "L", "g", "theta_0", "q1", "q2", "q1'", "q2'"]
    assert sliders["q1"]["follows"] == ["theta_0"] and sliders["q2"]["follows"] == []
    assert 0 < sliders["L"]["low"] < 1 < sliders["L"]["high"]  # a length is positive
    # a closed machine has sliders for the initial values that were given: the others follow
    closed = [x["name"] for x in data_of(pages["four-bar"])["live"]["sliders"] if x["group"] == "initial"]
    assert closed == ["q1", "q1'"]


def test_sizes_of_the_gyroscope(tmp_path):
    for name, more in (("live", ["--live"]), ("plain", [])):
        done = CliRunner().invoke(
            command, ["report", "gyroscope", "-o", str(tmp_path / f"{name}.html"), *more]
        )
        assert done.exit_code == 0, done.output
    live, plain = ((tmp_path / f"{name}.html").stat().st_size for name in ("live", "plain"))
    assert live < WHOLE and live - plain < LIVE_PART


def test_a_motion_that_a_page_cannot_compute_is_refused_and_nothing_is_written(tmp_path):
    s = double_pendulum()
    s.force("gust", s.bodies["b"].origin, (fb.signal([0, 1], [0, 1], name="wind"), 0, 0))
    with pytest.raises(SimulationError, match="signals that switch"):
        fb.report(s, fb.simulate(s, 0.2), tmp_path / "page.html", live=True)
    assert list(tmp_path.iterdir()) == []


# --- in a browser ----------------------------------------------------------------------------------------------------


class Page(PageBrowser):
    """A live page with its sliders."""

    def begin(self, path: Path) -> None:
        self.open(path)
        self.address = path.resolve().as_uri()
        self.wait("document.querySelector('#sliders input')")

    @property
    def motions(self) -> int:
        return int(self.value("Number(document.documentElement.dataset.motions || 0)"))

    def set(self, name: str, value: float) -> None:
        before = self.motions
        self.value(
            f"(box => {{ box.value = {value!r}; box.dispatchEvent(new Event('change')); }})"
            f"([...document.querySelectorAll('#sliders input')].find(x => x.name === {name!r}).nextElementSibling)"
        )
        self.wait(f"Number(document.documentElement.dataset.motions) > {before}")

    @property
    def problem(self) -> str:
        return str(self.value("(p => p.hidden ? '' : p.textContent)(document.getElementById('problem'))"))

    def channel(self, key: str) -> tuple[np.ndarray, np.ndarray]:
        t, values = self.value(
            f"[freebody.motion.t, freebody.motion.channels[{key!r}].values].map(x => Array.from(x))"
        )
        return np.array(t), np.array(values).reshape(len(t), -1)

    def offline(self) -> None:
        assert self.errors == [] and self.requests == [self.address]


@pytest.fixture
def page() -> Iterator[Page]:
    with Page(1200, 900) as browser:
        yield browser


@in_a_browser
def test_sliders_give_the_motion_of_simulate(pages, page):
    """Frames are of the dense output at tolerance 1e-10, and 32-bit floats: within 1e-6."""
    page.begin(pages["double pendulum"])
    assert page.motions == 0  # the recorded motion is shown first
    page.value("freebody.seek(1); freebody.show('forces', true)")
    page.set("L", 1.7)
    page.set("theta_0", 0.4)
    assert page.value("freebody.state.time") == 1 and page.value("freebody.state.on.forces")
    assert page.value("document.querySelector('#sliders input[name=q1]').nextElementSibling.value") == "0.4"
    motion = motion_of("double pendulum", until=2.0, values={"L": 1.7, "theta_0": 0.4})
    t, q1 = page.channel("state q1")
    t = np.minimum(t, 2.0)
    states = motion.path.sample(t)
    assert t[0] == 0 and t[-1] == 2 and len(t) > 200
    assert np.abs(q1[:, 0] - states[:, 0]).max() < 1e-6
    _, residual = page.channel("energy residual")
    _, total = page.channel("energy total")
    assert np.abs(residual).max() < 1e-8 * np.abs(total).max()  # in double precision
    _, force = page.channel("reaction force upper 0")
    k = len(t) // 2
    expected = (
        fb.simulate(
            double_pendulum(),
            2.0,
            initial={"q1": 0.4, "q2": 0.5},
            values={"L": 1.7},
            times=[t[k]],
            tolerance=1e-10,
        )
        .reactions["upper"]
        .force[0]
    )
    assert np.abs(force[k] - expected).max() < 1e-4
    drawn = page.value("freebody.motion.scene.bodies[0].parts[0].profile[2][1]")
    assert drawn == pytest.approx(0.85)
    page.offline()


@in_a_browser
def test_contacts_follow(page, tmp_path):
    """A ball thrown along a floor: impacts, then slip, then rolling."""
    s = fb.System("ball")
    m, R, e, mu, g = s.parameters(m=1.0, R=0.1, e=0.5, mu=0.2, g=9.81)
    s.gravity = (0, -g, 0)
    ball = s.body("ball", fb.sphere(m, R))
    s.planar("plane", s.ground, ball, at=(0, R, 0), coordinate="x y phi")
    s.contact("floor", ball.circle(R), s.ground.plane(), friction=mu, restitution=e)
    start: dict[str, float] = {"y": 0.5, "x'": 3.0}
    motion = fb.simulate(s, 3, initial=start, tolerance=1e-10)
    page.begin(fb.report(s, motion, tmp_path / "ball.html", live=True, equations=False))
    page.set("mu", 0.1)
    assert page.problem == ""
    other = fb.simulate(s, 3, initial=start, values={"mu": 0.1}, tolerance=1e-10)
    spans = page.value("freebody.motion.scene.modes[0].spans.map(([mode, from, to]) => [mode, from, to])")
    expected = [[change.mode, change.start, change.end] for change in other.modes]
    assert [mode for mode, *_ in spans] == list(dict.fromkeys(mode for mode, *_ in expected))
    assert spans[-1][1] == pytest.approx(expected[-1][1], abs=1e-9) and spans[-1][2] == 3
    t, normal = page.channel("force N_floor")
    assert normal[-1, 0] == pytest.approx(9.81, abs=1e-5) and normal[0, 0] == 0
    _, arrow = page.channel("reaction force N_floor 0")
    assert arrow[-1] == pytest.approx([0, 9.81, 0], abs=1e-5)
    _, x = page.channel("state x")
    assert x[-1, 0] == pytest.approx(other["x"][-1], abs=1e-6)
    impacts = page.value("freebody.motion.scene.events.filter(([, text]) => text === 'floor: impact').length")
    breaks = page.value("freebody.motion.scene.breaks")
    assert impacts > 3 and all(t[k] == t[k - 1] for k in breaks)
    _, residual = page.channel("energy residual")
    assert np.abs(residual).max() < 1e-8
    page.set("y", -0.2)
    assert page.problem == (
        'The contact "floor" begins below its surface. The picture is that of the setting before.'
    )
    page.set("y", 0.3)
    assert page.problem == ""
    page.offline()


@pytest.mark.slow
@in_a_browser
def test_laws_that_switch_follow_and_stick(page, tmp_path):
    """x'' = -k sign(x) - c sign(x') swings; without k it sticks after v/c, which the page says."""
    s = fb.System("block")
    s.parameters(k=100.0, c=0.0)
    body = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, body, axis="x", coordinate="x")
    s.force("law", body, ("-k*sign(x) - c*sign(x')", 0, 0))
    motion = fb.simulate(s, 1, initial={"x": 1.0, "x'": 1.0})
    page.begin(fb.report(s, motion, tmp_path / "block.html", live=True, equations=False))
    page.set("k", 50)
    t, x = page.channel("state x")
    other = fb.simulate(
        s, 1, initial={"x": 1.0, "x'": 1.0}, values={"k": 50}, times=t.astype(float).clip(0, 1)
    )
    assert page.problem == "" and np.abs(x[:, 0] - other["x"]).max() < 1e-6
    page.set("k", 0)
    page.set("c", 2)
    assert page.problem.startswith(
        "x' reaches zero at t = 0.5 s, and the forces on either side of it lead back"
    )


@in_a_browser
def test_gaps_beyond_an_end_are_distances(page, tmp_path):
    """A ball runs along a capsule, past its axis, against its end: the gap is not that of the wall without ends."""
    s = fb.System("pill")
    s.parameters(v=1.0)
    ball = s.body("ball", fb.sphere(0.5, 0.1))
    s.slider("way", s.ground, ball, at=(0, 0.05, 0), axis="x", coordinate="x")
    s.contact("hit", ball.sphere(0.1), s.ground.capsule((-0.2, 0, 0), (0.2, 0, 0), 0.1), restitution=0.5)
    motion = fb.simulate(s, 0.3, initial={"x": 0.8, "x'": "-v"})
    page.begin(fb.report(s, motion, tmp_path / "pill.html", live=True, equations=False))
    for change in (None, 0.9):
        if change is not None:
            page.set("v", change)
        gap, x = (page.channel(name)[1][:, 0] for name in ("gap hit", "state x"))
        assert gap == pytest.approx(np.hypot(x - 0.2, 0.05) - 0.2, abs=1e-5)


@in_a_browser
def test_plots_and_events_follow(pages, page):
    page.begin(pages["double pendulum"])
    lines = "[...document.querySelectorAll('.chart .curve')].map(x => x.getAttribute('points')).join('|')"
    before, events = page.value(lines), page.value("freebody.motion.scene.events.length")
    page.set("until", 6.0)
    assert page.value(lines) != before and page.value("freebody.motion.last") == 6
    assert page.value("freebody.motion.scene.events.length") > events > 0
    page.value("document.getElementById('reset').click()")
    page.wait("freebody.motion.last === 2")
    page.offline()


@in_a_browser
def test_charts_out_of_sight_wait(pages, page):
    """They are drawn again when they come into sight, and before the page is printed."""
    page.ask("Emulation.setDeviceMetricsOverride", width=1200, height=300, deviceScaleFactor=1, mobile=False)
    page.begin(pages["double pendulum"])
    last = "[...document.querySelectorAll('.chart')].at(-1)"
    drawn = f"[...{last}.querySelectorAll('text')].some(t => t.textContent === '6')"
    page.value("new Promise(r => requestAnimationFrame(() => setTimeout(r, 50)))")
    page.set("until", 6.0)
    assert not page.value(drawn)
    page.value(f"{last}.scrollIntoView()")
    page.wait(drawn)
    page.value("scrollTo(0, 0)")
    page.value("new Promise(r => requestAnimationFrame(() => setTimeout(r, 50)))")
    page.set("until", 2.0)
    assert page.value(drawn)
    page.value("dispatchEvent(new Event('beforeprint'))")
    assert not page.value(drawn)


@in_a_browser
def test_numbers_are_written_with_powers_of_ten(page, tmp_path):
    s = fb.System("heavy pendulum")
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar(1e6, 2, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, 1, 0), coordinate="theta")
    motion = fb.simulate(s, until=2, initial={"theta": 1.0})
    given = {"E": (1.25e-7, "J"), "law": "sticks up to F - 1e-9: yes"}
    page.begin(fb.report(s, motion, tmp_path / "x.html", live=True, equations=False, answers=given))
    units = page.value("[...document.querySelectorAll('.chart text')].map(t => t.textContent)")
    assert "[10⁷ J]" in units and not any("e+" in text for text in units)
    text = page.value("document.querySelector('main').textContent")
    assert "1.25 × 10⁻⁷" in text and "F - 10⁻⁹: yes" in text and "tolerance 10⁻⁹" in text
    assert page.value("document.querySelectorAll('.legend output')[2].textContent").endswith(" × 10⁶ J")


@in_a_browser
def test_what_cannot_be_closed_is_said_and_the_page_recovers(pages, page):
    page.begin(pages["four-bar"])
    page.set("b", 0.5)
    page.set("c", 0.3)
    assert page.problem == (
        "This setting cannot be closed: the parts do not reach each other. The picture is that of the setting before."
    )
    page.set("b", 3.0)
    page.set("c", 2.0)
    assert page.problem == ""
    t, q2 = page.channel("state q2")
    motion = motion_of("four-bar", until=2.0)
    assert np.abs(q2[:, 0] - motion.path.sample(np.minimum(t, 2.0))[:, 1]).max() < 1e-6
    page.set("b", -1.0)
    assert page.problem == "Expected b > 0. The picture is that of the setting before."
    page.set("b", 3.0)
    page.set("until", 2000.0)
    assert page.problem.startswith("More than 20000 steps: the motion is shown until t = ")
    page.offline()


@in_a_browser
def test_no_number_breaks_the_page(pages, page):
    page.begin(pages["double pendulum"])
    for name, value in (
        ("g", 1e300), ("g", 9.81), ("L", 1e-300), ("L", 1.0), ("q1'", 1e200), ("q1'", 1e9), ("q1'", 0.0),
        ("until", 1e-9), ("until", 1e12), ("until", 2.0), ("m", 1e-320), ("m", 1.0), ("q1", 1e17), ("q1", 0.4),
    ):  # fmt: skip
        page.set(name, value)
        assert not re.search("NaN|undefined|null", page.problem), page.problem
    assert page.problem == ""
    before = page.motions
    page.value(
        "(box => { box.value = -3; box.dispatchEvent(new Event('change')); })"
        "(document.querySelector('#sliders input[name=until]').nextElementSibling)"
    )
    page.wait("freebody.motion.last === 2")
    assert page.motions == before  # a run has no negative length
    t, q1 = page.channel("state q1")
    motion = motion_of("double pendulum", until=2.0, initial={"q1": 0.4, "q2": 0.5})
    assert np.abs(q1[:, 0] - motion.path.sample(np.minimum(t, 2.0))[:, 0]).max() < 1e-6
    page.offline()


@in_a_browser
def test_keys_and_fingers_move_sliders(pages, page):
    page.begin(pages["double pendulum"])
    page.value("document.querySelector('#sliders input[name=g]').focus()")
    for kind in ("rawKeyDown", "keyUp"):
        page.ask(
            "Input.dispatchKeyEvent", type=kind, key="ArrowRight", code="ArrowRight", windowsVirtualKeyCode=39
        )
    page.wait("Number(document.documentElement.dataset.motions) >= 1")
    assert float(page.value("document.querySelector('#sliders input[name=g]').value")) > 9.81
    page.ask("Emulation.setTouchEmulationEnabled", enabled=True)
    x, y, width = page.value(
        "(b => [b.x, b.y + b.height / 2, b.width])"
        "(document.querySelector('#sliders input[name=L]').getBoundingClientRect())"
    )
    points = [{"x": x + part * width, "y": y} for part in (0.48, 0.6, 0.75)]
    page.ask("Input.dispatchTouchEvent", type="touchStart", touchPoints=points[:1])
    for point in points[1:]:
        page.ask("Input.dispatchTouchEvent", type="touchMove", touchPoints=[point])
    page.ask("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    page.wait("Number(document.querySelector('#sliders input[name=L]').value) > 1.2")
    page.wait("Number(document.documentElement.dataset.motions) >= 2")
    page.offline()


@in_a_browser
def test_without_a_graphics_card_the_stage_is_coarser_while_a_slider_moves(pages, page):
    page.begin(pages["double pendulum"])
    before, labels = page.value("[...document.querySelectorAll('canvas')].slice(0, 2).map(c => c.width)")
    view = "document.querySelector('canvas.view')"
    seen = "new MutationObserver(() => widths.push(VIEW.width)).observe(VIEW, { attributes: true })"
    page.value(f"window.widths = []; {seen.replace('VIEW', view)}")
    page.set("L", 1.3)
    page.wait(f"widths.length && widths[widths.length - 1] === {before}")  # sharp again at rest
    assert (before, page.value("widths[0]")) == (2 * labels, pytest.approx(labels / 2, abs=1))
    page.value("freebody.play()")
    page.wait(f"{view}.width === {labels}")
    page.value("freebody.pause()")
    assert page.value(f"{view}.width") == before
    assert page.value("document.querySelector('canvas.labels').width") == labels


@in_a_browser
def test_where_webassembly_is_not_allowed_the_recorded_motion_stays(pages, page, tmp_path):
    text = pages["double pendulum"].read_text(encoding="utf-8")
    file = tmp_path / "strict.html"
    file.write_text(text.replace(" &#x27;wasm-unsafe-eval&#x27;", ""), encoding="utf-8")
    page.open(file)
    page.wait("!document.getElementById('problem').hidden")
    assert page.problem == (
        "WebAssembly is not allowed here, so that this page has no sliders. It shows the recorded motion."
    )
    assert page.value("document.querySelectorAll('#sliders input').length") == 0
    page.value("freebody.seek(1.5)")
    assert page.value("freebody.state.time") == 1.5
    t, q1 = page.channel("state q1")
    recorded = np.abs(q1[:, 0] - motion_of("double pendulum", until=2.0).path.sample(t)[:, 0]).max()
    assert recorded < 2.0**-FINE * np.ptp(q1)
