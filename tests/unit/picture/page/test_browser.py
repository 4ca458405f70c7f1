"""The page in a browser: it runs under its own policy, asks for nothing, and does what its controls say."""

from __future__ import annotations

import io

import numpy as np
import pytest

import freebody as fb
from freebody.gallery import entries
from freebody.picture.page.browser import chromium
from freebody.picture.page.page import LIVE, script
from page_browser import PageBrowser

pytestmark = pytest.mark.skipif(chromium() is None, reason="no Chromium on this machine")

HOSTILE = "</script><script>window.stolen=1</script><img src=x onerror='window.stolen=2'>"


@pytest.fixture(scope="module")
def browser():
    with PageBrowser(1000, 800) as one:
        yield one


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    made = {}

    def page(name: str):
        if name not in made:
            outcome = entries()[name].run()
            made[name] = fb.report(
                outcome.system, outcome.trajectory, folder / f"{name}.html", answers=outcome.answers
            )
        return made[name]

    return page


def pixels(png: bytes) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)


def shown(browser: PageBrowser) -> np.ndarray:
    """The stage, once what was asked for is drawn."""
    browser.value("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(1))))")
    return pixels(browser.element(".stage"))


def part(picture: np.ndarray, red: tuple[int, int], green: tuple[int, int], blue: tuple[int, int]) -> int:
    """Number of pixels of a colour."""
    inside = [
        (low <= picture[..., k]) & (picture[..., k] <= high)
        for k, (low, high) in enumerate((red, green, blue))
    ]
    return int(np.sum(inside[0] & inside[1] & inside[2]))


def ink(picture: np.ndarray) -> float:
    return float(np.mean(np.any(picture < 235, axis=2)))


def black(picture: np.ndarray) -> int:
    return part(picture, (0, 45), (0, 45), (0, 45))


def blue(picture: np.ndarray) -> int:
    return part(picture, (0, 20), (40, 130), (100, 200))


NAMES = ("double-pendulum", "gyroscope", "four-bar", "rolling-disk")


@pytest.mark.parametrize("name", NAMES)
def test_the_page_runs_under_its_policy_and_asks_for_nothing(browser, pages, name):
    path = pages(name)
    browser.open(path)
    assert browser.errors == []
    assert browser.requests == [path.as_uri()]
    assert browser.value("freebody.state.drawn") > 0
    assert 0.005 < ink(shown(browser)) < 0.5


def test_a_request_is_refused(browser, pages):
    browser.open(pages("double-pendulum"))
    assert browser.value("fetch('https://example.org').then(() => 'sent', () => 'refused')") == "refused"
    inject = "const s = document.createElement('script'); s.textContent = 'window.ran = 1'; document.body.append(s);"
    assert browser.value(f"(() => {{ {inject} return window.ran === undefined; }})()")
    assert any("Content Security Policy" in error for error in browser.errors)


def test_a_hostile_name_does_not_run(browser, tmp_path):
    s = fb.System(HOSTILE)
    s.parameters(g=9.81)
    s.describe("g", unit=HOSTILE, about=HOSTILE)
    bar = s.body("bar", fb.slender_bar(1, 1))
    s.hinge("pin", s.ground, bar, to=("0.5", 0, 0), coordinate="theta")
    motion = fb.simulate(s, until=1, initial={"theta'": 1}, events=[fb.event("theta - 1/2", name=HOSTILE)])
    path = fb.report(
        s, motion, tmp_path / "x.html", title=HOSTILE, about=HOSTILE, answers={HOSTILE: (HOSTILE, HOSTILE)}
    )
    browser.open(path)
    assert browser.errors == [] and browser.requests == [path.as_uri()]
    assert browser.value("window.stolen === undefined && freebody.state.drawn > 0")
    assert browser.value("document.title") == HOSTILE
    assert browser.value("document.querySelector('h1').textContent") == HOSTILE


def test_play_and_pause(browser, pages):
    browser.open(pages("double-pendulum"))
    before = shown(browser)
    browser.value("document.querySelector('.play').click()")
    browser.wait("freebody.state.time > 0.2")
    browser.value("document.querySelector('.play').click()")
    time = browser.value("freebody.state.time")
    after = shown(browser)
    assert browser.value("freebody.state.time") == time and not browser.value("freebody.state.playing")
    assert np.mean(np.any(np.abs(after - before) > 30, axis=2)) > 0.002
    assert browser.value("document.querySelector('.clock').textContent") == f"{time:.2f} s"


def test_scrub_moves_the_machine_and_the_cursors(browser, pages):
    browser.open(pages("double-pendulum"))
    browser.value(
        "(s => { s.value = 0.25; s.dispatchEvent(new Event('input')); })(document.querySelector('.scrub'))"
    )
    assert browser.value("freebody.state.time") == pytest.approx(2.5)
    motion = entries()["double-pendulum"].run().trajectory
    text = browser.value("document.querySelector('.legend output').textContent")
    assert float(text.split()[0].replace("−", "-")) == pytest.approx(motion.at(2.5)["theta_1"], abs=0.01)
    # the pose that is drawn is that of the motion
    position = browser.value("freebody.motion.pose(0).slice(12, 15)")
    expected = motion.poses["link_1"].position[np.searchsorted(motion.t, 2.5)]
    assert position == pytest.approx(expected.tolist(), abs=0.01)
    cursors = browser.value(
        "[...document.querySelectorAll('.cursor')].map(c => Number(c.getAttribute('x1')))"
    )
    assert len(cursors) >= 2 and np.ptp(cursors) < 1e-9
    # a click in a plot moves the time
    box = browser.value(
        "(b => [b.x, b.y, b.width, b.height])(document.querySelector('.chart').getBoundingClientRect())"
    )
    browser.value("document.querySelector('.chart').scrollIntoView({block: 'center'})")
    box = browser.value(
        "(b => [b.x, b.y, b.width, b.height])(document.querySelector('.chart').getBoundingClientRect())"
    )
    browser.press(box[0] + 0.75 * box[2], box[1] + 0.5 * box[3])
    assert 7.5 < browser.value("freebody.state.time") < 9.5


def test_arrows_are_switched(browser, pages):
    browser.open(pages("double-pendulum"))
    assert browser.value("freebody.state.on.forces && freebody.state.on.reactions")  # four arrows are few
    browser.value("freebody.seek(1); freebody.show('forces', false); freebody.show('reactions', false)")
    plain = shown(browser)
    browser.value("document.querySelector('input[name=forces]').click()")
    forces = shown(browser)
    assert black(forces) > black(plain) + 200  # weights are black
    browser.value("document.querySelector('input[name=reactions]').click()")
    both = shown(browser)
    assert blue(both) > blue(forces) + 200  # reactions are blue
    for name in ("forces", "reactions"):
        browser.value(f"document.querySelector('input[name={name}]').click()")
    assert np.array_equal(shown(browser), plain)


def test_cones_and_frames_are_switched(browser, pages):
    browser.open(pages("gyroscope"))
    assert browser.value("freebody.motion.scene.cones.length") == 1
    plain = shown(browser)
    for name in ("cones", "frames"):
        browser.value(f"freebody.show('{name}', true)")
        changed = shown(browser)
        assert np.mean(np.any(np.abs(changed - plain) > 20, axis=2)) > 0.002
        plain = changed


def test_orbit_zoom_and_views(browser, pages):
    browser.open(pages("gyroscope"))
    start = browser.value("freebody.state")
    box = browser.value(
        "(b => [b.x + b.width / 2, b.y + b.height / 2])(document.querySelector('.view').getBoundingClientRect())"
    )
    browser.mouse("pressed", *box, button="left", buttons=1, clickCount=1)
    browser.mouse("moved", box[0] + 120, box[1] + 40, button="left", buttons=1)
    browser.mouse("released", box[0] + 120, box[1] + 40, button="left")
    turned = browser.value("freebody.state")
    assert np.linalg.norm(np.subtract(turned["toward"], start["toward"])) > 0.1
    assert np.linalg.norm(turned["toward"]) == pytest.approx(1)
    browser.mouse("wheel", *box, deltaX=0, deltaY=-300)
    browser.wait(f"freebody.state.distance < {0.9 * turned['distance']}")
    browser.value("freebody.look('z')")
    assert browser.value("freebody.state.toward") == [0, 0, 1]
    browser.value("freebody.look('fit')")
    assert browser.value("freebody.state.toward") == pytest.approx(start["toward"])
    assert browser.value("freebody.state.distance") == pytest.approx(start["distance"])


def test_the_eye_is_moved_by_keys(browser, pages):
    browser.open(pages("gyroscope"))
    start = browser.value("freebody.state")
    press = "document.querySelector('.view').dispatchEvent(new KeyboardEvent('keydown', {{key: '{}', shiftKey: {}}}))"
    browser.value(press.format("ArrowLeft", "true"))
    browser.value(press.format("+", "false"))
    turned = browser.value("freebody.state")
    assert np.linalg.norm(np.subtract(turned["toward"], start["toward"])) > 0.05
    assert turned["distance"] == pytest.approx(0.9 * start["distance"]) and turned["time"] == start["time"]
    browser.value(press.format("0", "false"))
    assert browser.value("freebody.state.toward") == pytest.approx(start["toward"])


def test_the_picture_without_webgl_is_the_same_picture(browser, pages):
    path = pages("double-pendulum")
    pictures = []
    for flat in (0, 1):
        browser.open(f"{path.as_uri()}#t=1.2&forces=1&flat={flat}")
        assert browser.value("freebody.state.kind") == ("canvas" if flat else "webgl")
        assert browser.errors == []
        pictures.append(np.any(shown(browser) < 200, axis=2))
    both, either = np.sum(pictures[0] & pictures[1]), np.sum(pictures[0] | pictures[1])
    assert both / either > 0.8


FLOOR = (238, 248), (240, 249), (242, 251)
SHADOW = (212, 218), (215, 221), (219, 225)


def test_the_stage_has_a_floor_and_shadows_where_there_is_a_vertical(browser, pages, tmp_path):
    browser.open(pages("gyroscope"))
    stage = shown(browser)
    assert part(stage, *FLOOR) > 0.1 * stage[..., 0].size and part(stage, *SHADOW) > 500
    s = fb.System("stone")
    s.free("flight", s.ground, s.body("stone", fb.box(6, (3, 2, 1))))
    motion = fb.simulate(s, until=1, initial={"flight_wx": 1, "flight_wy": 2})
    browser.open(fb.report(s, motion, tmp_path / "stone.html"))
    floating = shown(browser)
    assert part(floating, *FLOOR) < 0.01 * stage[..., 0].size
    assert browser.errors == []


def test_a_lost_graphics_context_is_restored(browser, pages):
    browser.open(f"{pages('double-pendulum').as_uri()}#t=1.2")
    before = shown(browser)
    browser.value(
        "window.lost = document.querySelector('.view').getContext('webgl').getExtension('WEBGL_lose_context');"
        "lost.loseContext()"
    )
    browser.value("new Promise(r => setTimeout(() => (lost.restoreContext(), setTimeout(r, 200)), 100))")
    assert browser.value("freebody.state.time") == pytest.approx(1.2)  # nothing is loaded again
    assert np.array_equal(shown(browser), before)
    browser.value("freebody.seek(2.5)")
    assert np.any(shown(browser) != before) and browser.errors == []


def test_a_page_is_printed_with_its_picture(browser, pages):
    browser.open(f"{pages('double-pendulum').as_uri()}#t=1.2")
    stage = shown(browser)
    browser.value("window.dispatchEvent(new Event('beforeprint'))")
    browser.value("document.querySelector('.printed').style.display = 'block'")
    assert np.mean(np.abs(shown(browser) - stage)) < 0.5
    browser.value("window.dispatchEvent(new Event('afterprint'))")
    assert browser.value("document.querySelector('.printed') === null")
    assert browser.pdf().startswith(b"%PDF-")


def test_curves_have_their_names_at_their_ends(browser, pages):
    browser.open(pages("double-pendulum"))
    ends = "[...p.querySelectorAll('.end')].map(e => e.getBoundingClientRect().y)"
    read = f"[...document.querySelectorAll('.plot')].map(p => {ends})"
    places = browser.value(read)
    assert len(places[0]) == 2
    assert all(b - a > 10 for ends in places for a, b in zip(sorted(ends), sorted(ends)[1:], strict=False))


def test_equations_are_copied_as_sympy(browser, pages):
    import sympy

    browser.open(pages("double-pendulum"))
    codes = browser.value("[...document.querySelectorAll('[data-sympy]')].map(e => e.dataset.sympy)")
    e = fb.equations(entries()["double-pendulum"].build())
    assert [str(x) for x in e.motion] == codes[-2:]
    assert all(isinstance(sympy.sympify(code, evaluate=False), sympy.Basic) for code in codes)
    buttons = "document.querySelector('[data-sympy]').querySelectorAll('button')"
    assert browser.value(f"[...{buttons}].map(b => b.textContent)") == ["LaTeX", "SymPy", "text"]
    stops = f"[...{buttons}].map(b => b.tabIndex)"
    assert browser.value(stops) == [0, -1, -1]  # one stop of the Tab key
    pressed = "new KeyboardEvent('keydown', { key: 'ArrowLeft', bubbles: true })"
    browser.value(f"{buttons}[0].focus(); {buttons}[0].dispatchEvent({pressed})")
    assert browser.value(f"document.activeElement === {buttons}[2]")
    assert browser.value(stops) == [-1, -1, 0]


def test_speed_and_end(browser, pages):
    browser.open(f"{pages('four-bar').as_uri()}#speed=10")
    browser.value("freebody.show('repeat', false); freebody.play()")
    browser.wait("!freebody.state.playing")
    assert browser.value("freebody.state.time") == browser.value("freebody.motion.last")


def test_a_film_is_written(tmp_path):
    from PIL import Image

    s = fb.System("pendulum")
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, 1, 0), coordinate="theta")
    made = fb.simulate(s, until=1, initial={"theta": 1}).animate()
    path = made.save(tmp_path / "x.gif", fps=4, width=320, height=240)
    with Image.open(path) as film:
        assert film.n_frames == 5 and film.size == (320, 240)
        frames = []
        for i in (0, 4):
            film.seek(i)
            frames.append(np.asarray(film.convert("RGB")).astype(int))
    assert np.mean(np.any(np.abs(frames[1] - frames[0]) > 60, axis=2)) > 0.005
    with pytest.raises(fb.errors.SimulationError, match="Expected a film of at most 2000 frames"):
        made.save(tmp_path / "y.gif", fps=1e4)


@pytest.fixture(scope="module")
def bouncing(tmp_path_factory):
    """A disk that falls on a floor, bounces, and rolls in the end."""
    from contact_machines import pulled_disk

    s = pulled_disk()
    motion = fb.simulate(s, 2.0, initial={"y": 0.3, "x'": 1.0})
    return fb.report(s, motion, tmp_path_factory.mktemp("contact") / "disk.html")


def test_the_time_bar_has_modes_and_events(browser, bouncing):
    browser.open(bouncing)
    bars = browser.value(
        "[...document.querySelectorAll('.timeline rect.mode')].map(r => [r.getAttribute('class'), "
        "r.getBoundingClientRect().x, r.getBoundingClientRect().right, r.textContent])"
    )
    assert [bar[0] for bar in bars] == ["mode open", "mode stick"]
    assert "the start" in bars[0][3] and bars[0][2] == pytest.approx(bars[1][1], abs=0.5)
    slider = browser.value("(r => [r.x, r.right])(document.querySelector('.scrub').getBoundingClientRect())")
    # the strip lies under the slider
    assert bars[0][1] == pytest.approx(slider[0], abs=12) and bars[1][2] == pytest.approx(slider[1], abs=12)
    share = bars[0][2] - bars[0][1]
    assert share / (bars[1][2] - bars[0][1]) == pytest.approx(0.7419 / 2, abs=0.01)
    marks = browser.value("document.querySelector('.timeline .mark').getAttribute('d')")
    assert marks.count("M") >= 10
    # the title of the marks is that of the event under the pointer
    at = browser.value("""(m => {
        const r = m.ownerSVGElement.getBoundingClientRect();
        const clientX = r.left + r.width * freebody.motion.scene.events[0][0] / 2;
        m.dispatchEvent(new PointerEvent('pointermove', { clientX }));
        return m.textContent;
    })(document.querySelector('.timeline .mark'))""")
    assert at.startswith("t = 0.24") and "impact" in at
    browser.press(bars[1][1] + 0.5 * (bars[1][2] - bars[1][1]), browser.value(
        "(r => r.y + r.height / 2)(document.querySelector('.timeline rect.stick').getBoundingClientRect())"
    ))  # fmt: skip
    assert browser.value("freebody.state.time") == pytest.approx((0.7419 + 2) / 2, abs=0.02)
    assert browser.errors == []


def test_contact_points_and_forces_are_switched(browser, bouncing):
    browser.open(f"{bouncing.as_uri()}#t=1.5&contacts=0&reactions=0")
    plain = shown(browser)
    browser.value("freebody.show('contacts', true)")
    points = shown(browser)
    assert np.any(plain != points)
    browser.value("freebody.show('reactions', true)")
    assert blue(shown(browser)) > blue(points)
    # in the air there is no force of the floor
    browser.value("freebody.seek(0.1)")
    flight = shown(browser)
    browser.value("freebody.show('reactions', false)")
    assert np.array_equal(flight, shown(browser))


def test_a_speed_jumps_in_the_page(browser, bouncing):
    browser.open(bouncing)
    fall = float(np.sqrt(2 * 0.3 / 9.81))
    read = 'freebody.motion.vector(freebody.motion.channels["state y\'"].values, 1)[0]'
    for t, expected in ((fall - 1e-4, -9.81 * fall), (fall + 1e-4, 0.5 * 9.81 * fall)):
        browser.value(f"freebody.seek({t})")
        assert browser.value(read) == pytest.approx(expected, rel=1e-2)
    # no line of a curve joins the two
    joined = browser.value(
        "[...document.querySelectorAll('.chart')].map(c => c.querySelectorAll('polyline').length)"
    )
    assert max(joined) > 10


def test_boxes_of_sliders_have_room_for_their_numbers(browser):
    code = next(line for line in script(LIVE).splitlines() if line.startswith("const short"))
    numbers = "[2e-4, -1.2345e-4, 1 / 3, 123456789, -2e-9, 0]"
    shown = browser.value(f"(() => {{ {code} return {numbers}.map(short).join(); }})()")
    assert shown == "0.0002,-1.2345e-4,0.33333,123460000,-2e-9,0"
