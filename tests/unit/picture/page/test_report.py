"""The page: what it holds, that no script but its own can run, that its numbers are those of the motion."""

from __future__ import annotations

import html
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from click.testing import CliRunner

import freebody as fb
from freebody.gallery import entries
from freebody.motion.trajectory.quantities import quaternions
from freebody.picture.machine.shapes import hidden, holds, shapes
from freebody.picture.moving.keyframes import interpolated, keyframes
from freebody.picture.page.animation import animation
from freebody.picture.page.packing import FINE, packed
from freebody.picture.page.page import LIVE, SCRIPTS, VIEW, page, policy, script
from page_data import scene_of, unpacked

HOSTILE = '</script><script>alert(1)</script><img src=x onerror="alert(2)">'


@pytest.fixture(scope="module")
def pendulum() -> tuple[fb.System, fb.Trajectory]:
    s = fb.System("pendulum")
    m, L, g, k = s.parameters(m=2, L=1.5, g=9.81, k=3)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), coordinate="theta")
    s.spring("coil", pin, stiffness=k)
    s.force("push", bar.point(0, -L / 2, 0), (1, 0, 0))
    return s, fb.simulate(s, until=4, initial={"theta": 1}, events=[fb.event("theta'", name="turn")])


@pytest.fixture(scope="module")
def text(pendulum, tmp_path_factory) -> str:
    s, motion = pendulum
    path = tmp_path_factory.mktemp("report") / "pendulum.html"
    assert (
        fb.report(s, motion, path, title="A <pendulum>", answers={"period": (2.1, "s"), "law": "a < b"})
        == path
    )
    return path.read_text(encoding="utf-8")


class Elements(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def of(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.found if name == tag]


def floats(values: Any, *shape: int) -> np.ndarray:
    return np.asarray(values, dtype=np.float32).reshape(-1, *shape)


# --- the page ----------------------------------------------------------------------------------------------------


def test_the_page_has_every_section(text):
    assert "<h2>File</h2>" not in text
    assert text.index("<h2>Drawing</h2>") < text.index("<h2>Answers</h2>")  # which use its symbols
    for heading in (
        "Drawing",
        "Answers",
        "Plots",
        "Free-body diagrams",
        "Free-body equations",
        "Equations of motion",
        "Model",
    ):
        assert f"<h2>{heading}</h2>" in text
    elements = Elements(text)
    assert [x["id"] for x in elements.of("div") if "id" in x] == ["player"]
    assert text.count("data-tex=") >= 4  # one equation of motion, three of the free body
    assert elements.of("svg")
    charts = [int(x["data-chart"]) for x in elements.of("div") if "data-chart" in x]
    assert charts == list(range(len(scene_of(text)["charts"])))


def test_texts_are_escaped(text):
    assert "A &lt;pendulum&gt;" in text and "A <pendulum>" not in text
    assert "a &lt; b" in text


def test_the_page_points_to_nothing_outside(text):
    for tag, attributes in Elements(text).found:
        assert tag not in ("iframe", "object", "embed", "base", "form")
        for name in ("src", "href", "action", "xlink:href"):
            value = attributes.get(name) or ""
            assert not value or value.startswith(("data:", "#")), (tag, name, value)
    style = text[text.index("<style>") : text.index("</style>")]
    assert "url(" not in style and "@import" not in style


def test_the_policy_allows_the_one_script_and_no_request(text):
    (meta,) = [x for x in Elements(text).of("meta") if x.get("http-equiv") == "Content-Security-Policy"]
    code = text[text.rindex("<script>") + len("<script>") : text.rindex("</script>")]
    assert meta["content"] == policy(code)
    assert (
        "default-src 'none'" in policy(code) and "unsafe-inline" not in policy(code).partition("style-src")[0]
    )
    assert code == script()
    scripts = Elements(text).of("script")
    assert [x.get("type") for x in scripts] == ["application/octet-stream", None]


def test_hostile_names_stay_text():
    given = {"name": HOSTILE, "list": [HOSTILE, "\u2028", "&amp;"]}
    assert "<" not in packed(given) and ">" not in packed(given)
    assert unpacked(packed(given)) == given
    made = page(HOSTILE, {"title": HOSTILE}, "<p>body</p>")
    assert made.count("<script") == 2 and "<img" not in made


def test_a_hostile_model_file_makes_a_harmless_page(tmp_path):
    from freebody.cli import command

    model = tmp_path / "bad.toml"
    model.write_text(
        f"""
name = '''{HOSTILE}'''
gravity = [0, "-g", 0]
[parameters]
g = 9.81
[bodies.bar]
solid = "slender_bar"
mass = 1
length = 1
[joints.pin]
type = "hinge"
child = "bar"
to = ["0.5", 0, 0]
coordinate = "theta"
[describe.g]
unit = '''{HOSTILE}'''
about = '''{HOSTILE}'''
[run]
until = 0.5
"""
    )
    done = CliRunner().invoke(command, ["report", str(model), "-o", str(tmp_path / "bad.html")])
    assert done.exit_code == 0, done.output
    made = (tmp_path / "bad.html").read_text(encoding="utf-8")
    assert made.count("alert(1)") >= 4  # in the title and in the summary, as text
    assert made.count("<script") == 2 and "<img" not in made


def test_scripts_are_part_of_the_package():
    folder = Path(fb.__file__).parent / "picture" / "page"
    assert {path.name for path in folder.glob("*.js")} == {*SCRIPTS, *LIVE, *VIEW}
    for name in {*SCRIPTS, *LIVE, *VIEW}:  # each opens alike, so that joined they are one strict script
        assert (folder / name).read_text(encoding="utf-8").startswith('"use strict";\n// ')
    assert "http" not in script().replace("http://www.w3.org/2000/svg", "")


# --- the data ----------------------------------------------------------------------------------------------------


def test_keyframes_are_the_motion(pendulum, text):
    _, motion = pendulum
    scene = scene_of(text)
    t = floats(scene["t"]).astype(float)
    assert np.all(np.diff(t) > 0) and t[0] == 0 and t[-1] == 4
    values = floats(scene["channels"]["state theta"]["values"])
    step = 2.0**-FINE  # of what is kept of each value, relative to its range
    assert values == pytest.approx(motion.at(t)["theta"], abs=step * float(np.ptp(values)))
    q = floats(scene["bodies"][0]["quaternion"], 4)
    assert np.linalg.norm(q, axis=1) == pytest.approx(1, abs=2 * step)
    assert np.all(np.sum(q[1:] * q[:-1], axis=1) > 0)
    theta = motion.at(t)["theta"]
    assert np.abs(q[:, 3]) == pytest.approx(np.abs(np.sin(theta / 2)), abs=step)
    energies = [floats(scene["channels"][f"energy {name}"]["values"]) for name in ("kinetic", "potential")]
    error = step * float(sum(np.ptp(values) for values in energies))
    assert floats(scene["channels"]["energy total"]["values"]) == pytest.approx(sum(energies), abs=error)


def test_interpolation_keeps_its_tolerance(pendulum):
    """The page's own interpolation, between all keyframes, against the motion."""
    _, motion = pendulum
    for tolerance in (1e-2, 1e-3):
        keys = keyframes(motion, tolerance)
        t = np.linspace(0, 4, 1777)
        at = motion.at(t)
        theta = np.interp(t, keys.t, keys.states[:, 0])
        # checked in the middles of the intervals; elsewhere the error of a smooth motion is no greater
        assert np.max(np.abs(theta - at["theta"])) <= 1.5 * tolerance * np.max(np.abs(at["theta"]))
    assert len(keyframes(motion, 1e-4).t) > len(keyframes(motion, 1e-2).t)


@pytest.mark.parametrize("name", ["gyrocompass", "gyroscope"])
def test_the_turns_of_a_fast_rotor_are_counted(name):
    """Few moments are enough, at all times between them, however often the rotor turns from one to the next."""
    motion = entries()[name].run().trajectory
    keys = keyframes(motion)
    turned = np.trapezoid(np.linalg.norm(keys.spin, axis=2).max(axis=1), keys.t)
    assert len(keys.t) < 2 * turned
    t = np.setdiff1d(motion.t, keys.t)
    after = np.searchsorted(keys.t, t)
    before = after - 1
    lasting = keys.t[after] - keys.t[before]
    for i, body in enumerate(motion.kernels.model.bodies):
        turn = (keys.spin[before, i] + keys.spin[after, i]) / 2 * lasting[:, None]
        ends = keys.quaternion[before, i], keys.quaternion[after, i]
        q = interpolated(*ends, turn, ((t - keys.t[before]) / lasting)[:, None])
        true = quaternions(motion.poses[body].rotation[np.isin(motion.t, t)])
        away = np.minimum(np.linalg.norm(q - true, axis=1), np.linalg.norm(q + true, axis=1))
        assert 2 * away.max() < 1.5 * keys.tolerance


def test_a_motion_of_many_moments_is_drawn_coarser(monkeypatch, pendulum):
    _, motion = pendulum
    fine = keyframes(motion, 1e-4)
    monkeypatch.setattr("freebody.picture.moving.keyframes.MOST", len(fine.t) // 3)
    coarse = keyframes(motion, 1e-4)
    assert len(coarse.t) <= len(fine.t) // 3
    # doubled as often as it takes, and not once more
    doubled = np.log2(coarse.tolerance / fine.tolerance)
    assert fine.tolerance == 1e-4 and doubled == round(doubled) >= 1
    monkeypatch.undo()
    assert len(keyframes(motion, coarse.tolerance).t) == len(coarse.t)
    assert len(keyframes(motion, coarse.tolerance / 2).t) > len(fine.t) // 3


def test_arrows_are_loads_and_reactions(pendulum, text):
    _, motion = pendulum
    scene = scene_of(text)
    found = {(a["group"], a["kind"], a["label"]) for a in scene["arrows"]}
    assert found == {
        ("force", "force", "weight of bar"), ("force", "force", "push"), ("force", "moment", "coil"),
        ("reaction", "force", "pin"),
    }  # fmt: skip
    t = floats(scene["t"]).astype(float)
    value = {
        a["label"]: floats(scene["channels"][a["channel"]]["values"], 3)
        for a in scene["arrows"]
        if a["group"] == "force"
    }
    assert value["weight of bar"] == pytest.approx(np.tile([0, -2 * 9.81, 0], (len(t), 1)), rel=1e-6)
    assert value["push"] == pytest.approx(np.tile([1, 0, 0], (len(t), 1)))
    assert value["coil"][:, 2] == pytest.approx(-3 * motion.at(t)["theta"], abs=1e-4)
    reaction = next(a for a in scene["arrows"] if a["group"] == "reaction" and a["kind"] == "force")
    assert reaction["at"] == pytest.approx([0, 0.75, 0])
    # the joint's force at the output times, between the keyframes
    values = floats(scene["channels"][reaction["channel"]]["values"], 3)
    here = np.stack([np.interp(motion.t, t, values[:, k]) for k in range(3)], axis=1)
    force = np.asarray(motion.reactions["pin"].force)
    # the tolerance of the moments holds in the middle between two, where a line is farthest from a bend, half as much
    # again for what bends there; at the moments themselves it is the force
    assert (
        np.abs(here - force).max() < 1.5 * keyframes(motion).tolerance * np.linalg.norm(force, axis=1).max()
    )
    shared = np.isin(motion.t, t)
    assert shared.sum() >= 2 and here[shared] == pytest.approx(
        force[shared], abs=2.0**-FINE * float(np.ptp(force, axis=0).max())
    )


def test_round_off_is_no_arrow():
    """The guide of a cart whose load acts through the pin carries no moment; what is computed of it is round-off."""
    scene = animation(entries()["ex-6-5"].run().trajectory)
    kinds = {(a["name"], a["kind"]) for a in scene["arrows"] if a["group"] == "reaction"}
    assert kinds == {("guide", "force"), ("pin", "force")}
    assert not any("Moment" in chart["title"] for chart in scene["charts"])


def test_a_wheel_is_pushed_where_it_touches():
    outcome = entries()["rolling-disk"].run()
    scene = animation(outcome.trajectory)
    (arrow,) = [a for a in scene["arrows"] if a["name"] == "contact"]
    path = floats(arrow["path"], 3)
    assert path[:, 2] == pytest.approx(0, abs=1e-6)  # in the plane
    center = floats(scene["bodies"][0]["position"], 3)
    assert np.linalg.norm(path - center, axis=1) == pytest.approx(0.3, rel=1e-5)
    assert len(scene["ground"]["planes"]) == 1


def test_a_machine_that_travels_over_paper_passes_lines():
    """A car seen from above: without a plane, nothing would show that the picture follows it."""
    outcome = entries()["turning-car"].run()
    (plane,) = animation(outcome.trajectory)["ground"]["planes"]
    assert plane["normal"] == [0, 0, 1] and plane["at"][2] < 0
    standing = entries()["reaction-wheel"].run()
    assert animation(standing.trajectory)["ground"]["planes"] == []


def test_equations_and_matrices_among_answers_are_set():
    from freebody.picture.page.answers import answers_table
    from freebody.picture.page.symbols import Symbols

    answers = {"M": ((((1.5, 2), (3, 4))), "kg"), "lam": (0.5, "rad")}
    shown = answers_table(answers, Symbols())
    assert 'style="grid-template-columns: repeat(2, auto)"><span>1.5</span>' in shown
    assert "λ" in shown and "lam<" not in shown


SEEN = ["sec-6-10", "rattleback", "four-bar", "ex-6-4"]
"""Machines of the gallery that stand for all in the quick tests."""


@pytest.mark.parametrize(
    "name", [name if name in SEEN else pytest.param(name, marks=pytest.mark.slow) for name in entries()]
)
def test_every_gallery_machine_has_something_to_see(name):
    motion = entries()[name].run().trajectory
    scene = animation(motion)
    for body in scene["bodies"]:
        unseen = hidden(motion.kernels.model)
        assert bool(body["parts"]) != (body["name"] in unseen), body["name"]
        assert np.all(np.isfinite(floats(body["position"])))
    up, toward = np.array(scene["up"]), np.array(scene["toward"])
    assert np.linalg.norm(up) == pytest.approx(1) and np.linalg.norm(toward) == pytest.approx(1)
    assert abs(up @ toward) < 0.9
    kinds = {part["kind"] for body in scene["bodies"] for part in body["parts"]}
    assert kinds >= {"sec-6-10": {"lathe"}, "rattleback": {"ellipsoid"}}.get(name, set())


def test_every_solid_is_drawn():
    """Each by the surface that it has, placed where it is; exact numbers of a joint are numbers, too."""
    import sympy

    z = sympy.Symbol("z", real=True)
    vertices, faces = (
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)],
    )
    solids = {
        "cone": (fb.cone(1, 0.15, 0.4), "lathe"), "box": (fb.box(1, (0.3, 0.2, 0.1)), "box"),
        "plate": (fb.plate(1, (0.3, 0.2)), "box"), "ring": (fb.ring(1, 0.15), "lathe"),
        "torus": (fb.torus(1, 0.15, 0.04), "lathe"), "tube": (fb.tube(1, 0.08, 0.1, 0.3), "lathe"),
        "vase": (fb.revolve(0.1 + z**2, (-0.2, 0.2), z, mass=1), "lathe"), "ball": (fb.sphere(1, 0.1), "ellipsoid"),
        "egg": (fb.ellipsoid(1, (0.1, 0.2, 0.3)), "ellipsoid"), "disk": (fb.disk(1, 0.1), "lathe"),
        "bar": (fb.slender_bar(1, 0.4), "lathe"), "point": (fb.particle(1), "ellipsoid"),
        "rock": (fb.mesh(vertices, faces, mass=1), "mesh"), "shell": (fb.spherical_shell(1, 0.1), "ellipsoid"),
    }  # fmt: skip
    s = fb.System("shelf")
    for name, (solid, _) in solids.items():
        color = "#CC79A7" if name == "vase" else None
        s.slider(f"on_{name}", s.ground, s.body(name, solid, color=color))
    s.hinge("nail", s.ground, s.body("tag", fb.sphere(1, 0.1)), at=("1/3", 0, 2), to=(0, "1/3", 0))
    scene = animation(fb.simulate(s, until=0.1))
    by_name = {body["name"]: body for body in scene["bodies"]}
    for name, (_, kind) in solids.items():
        assert by_name[name]["parts"][0]["kind"] == kind, name
    assert by_name["vase"]["color"] == pytest.approx([0xCC / 255, 0x79 / 255, 0xA7 / 255])
    profile = np.array(by_name["vase"]["parts"][0]["profile"])
    assert profile[:, 0].max() == pytest.approx(0.14) and np.ptp(profile[:, 1]) == pytest.approx(0.4)
    assert by_name["egg"]["parts"][0]["radii"] == [0.1, 0.2, 0.3]
    assert len(floats(by_name["rock"]["parts"][0]["vertices"], 3)) == 4


def test_a_planar_machine_is_seen_at_right_angles(pendulum):
    _, motion = pendulum
    scene = animation(motion)
    assert scene["up"] == [0, 1, 0] and scene["toward"] == [0, 0, 1]


@pytest.mark.slow
def test_two_bodies_for_20_s_are_under_one_and_a_half_megabytes(tmp_path):
    from freebody.cli import command

    done = CliRunner().invoke(
        command, ["report", "double-pendulum", "--until", "20", "-o", str(tmp_path / "x.html")]
    )
    assert done.exit_code == 0, done.output
    assert (tmp_path / "x.html").stat().st_size < 1_500_000


# --- refusals, figures, notebook -----------------------------------------------------------------------------------


def test_a_parameter_that_is_drawn_with_another_value_is_said(pendulum, tmp_path):
    s, motion = pendulum

    def text(**options) -> str:
        return fb.report(s, motion, tmp_path / "report.html", equations=True, **options).read_text("utf-8")

    name, value = next((name, value) for name, value in motion.values.items() if value > 0)
    plain, other = text(drawn={"values": dict(motion.values)}), text(drawn={"values": {name: 1.25 * value}})
    assert "not to scale" not in plain
    named = text(names={"I_O": "m*L**2/3"})
    assert "I_{O}" in named and "I_{O}" not in plain
    assert re.search(rf"not to scale.*{1.25 * value:.6g} in place of {value:.6g}\.</p>", other)


def test_what_was_read_of_a_file_is_said(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(
        """<robot name="arm"><gazebo/><link name="w"/><link name="a"><inertial><mass value="1"/><origin xyz="1 0 0"/>
        <inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="continuous"><parent link="w"/>
        <child link="a"/></joint></robot>"""
    )
    s = fb.read(path)
    text = fb.report(s, fb.simulate(s, 0.1), tmp_path / "report.html").read_text("utf-8")
    assert "<h2>File</h2>\n<p>Read from arm.urdf: 1 joint, 2 links.</p>" in text
    assert all(f"<li>{html.escape(line)}</li>" in text for line in str(s.reading).splitlines()[1:])
    assert "&lt;gazebo&gt;" in text


def test_a_trajectory_of_another_system_is_refused(pendulum, tmp_path):
    _, motion = pendulum
    other = fb.System("other")
    with pytest.raises(fb.errors.ModelError, match="Expected a trajectory of 'other', got one of 'pendulum'"):
        fb.report(other, motion, tmp_path / "x.html")
    with pytest.raises(fb.errors.ModelError, match="Expected a System to report on, got 3"):
        fb.report(3, motion, tmp_path / "x.html")
    assert not list(tmp_path.iterdir())


def test_a_path_that_can_not_be_written_is_refused(pendulum, tmp_path):
    s, motion = pendulum
    with pytest.raises(fb.errors.FormatError, match="Expected an existing folder"):
        fb.report(s, motion, tmp_path / "nowhere" / "x.html")


def test_figures_are_embedded(pendulum, tmp_path):
    s, motion = pendulum
    path = fb.report(
        s, motion, tmp_path / "x.html", figures={"by <axes>": motion.plot(), "by bytes": b"\x89PNG"}
    )
    images = [x["src"] for x in Elements(path.read_text(encoding="utf-8")).of("img")]
    assert len(images) == 2 and all(x.startswith("data:image/png;base64,iVBOR") for x in images)
    with pytest.raises(fb.errors.SimulationError, match="Expected a figure as PNG bytes"):
        fb.report(s, motion, tmp_path / "y.html", figures={"no": 3})
    assert not (tmp_path / "y.html").exists()


def test_animate_shows_itself_and_writes_a_page(pendulum, tmp_path):
    _, motion = pendulum
    made = motion.animate(tmp_path / "x.html", forces=True)
    text = (tmp_path / "x.html").read_text(encoding="utf-8")
    assert scene_of(text)["shown"] == {"forces": True}
    assert repr(made) == "Animation of 'pendulum', 0 to 4 s"
    html = made._repr_html_()
    (frame,) = Elements(html).of("iframe")
    assert frame["sandbox"] == "allow-scripts" and frame["srcdoc"] == made.html
    assert motion._repr_html_().startswith("<iframe")


def test_animate_refuses_what_it_can_not_do(pendulum, tmp_path, monkeypatch):
    _, motion = pendulum
    with pytest.raises(
        fb.errors.SimulationError, match="Expected one of trails, frames, .* to show, got 'smoke'"
    ):
        motion.animate(smoke=True)
    with pytest.raises(fb.errors.SimulationError, match="ends in .html, .gif or .mp4, got 'x.avi'"):
        motion.animate(tmp_path / "x.avi")
    with pytest.raises(fb.errors.SimulationError, match="Expected a tolerance between 0 and 1"):
        motion.animate(tolerance=2).html  # noqa: B018
    monkeypatch.setenv("FREEBODY_BROWSER", "no-such-browser")
    with pytest.raises(fb.errors.FreebodyError, match="Writing .gif needs a Chromium or Chrome"):
        motion.animate(tmp_path / "x.gif")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(
        fb.errors.FreebodyError, match="and ffmpeg, which joins them; not found on this machine"
    ):
        motion.animate(tmp_path / "x.mp4")
    assert not list(tmp_path.iterdir())


def test_command_line(tmp_path):
    from freebody.cli import command

    path = tmp_path / "x.html"
    done = CliRunner().invoke(command, ["report", "hinged-bar", "--until", "1", "-o", str(path)])
    assert done.exit_code == 0, done.output
    assert done.output.startswith(f"wrote {path}, ")
    assert "<h2>Answers</h2>" in path.read_text(encoding="utf-8")
    done = CliRunner().invoke(command, ["report", "hinged-bar", "--until", "-1", "-o", str(path)])
    assert done.exit_code == 2 and "Expected a time greater than 0, got -1" in done.output


def test_answers_of_the_gallery_are_questions_numbers_and_formulas() -> None:
    from freebody.gallery import entries
    from freebody.gallery.tools.answer import Printed
    from freebody.picture.page.answers import answers_table
    from freebody.picture.page.symbols import Symbols

    answers = entries()["ex-6-2"].run({}).answers
    symbols = Symbols()
    shown = answers_table(answers, symbols)
    assert "Answer(" not in shown
    for key, answer in answers.items():
        assert f'<td>{symbols.name(key)}</td><td class="asked">{answer.question}</td>' in shown
    assert (
        shown.count('<div class="equation"')
        == sum(answer.formula is not None for answer in answers.values())
        > 0
    )
    assert '">−9.81</td><td class="unit">rad/s²</td>' in shown
    assert answers_table({}, symbols) == "" and ">where<" not in shown
    named = replace(
        answers["alpha"], where_printed={"I_0": Printed("m*L**2/9", r"\frac{1}{9} m L^{2}")}, where={"I_0": 0}
    )
    assert ">where<div" in answers_table({"alpha": named}, symbols)
    assert ">where<" not in answers_table({"alpha": named, "I_0": (0.1, "kg m²")}, symbols)  # it stands there
    hostile = answers_table({"<b>": ("<i>", "<u>")}, symbols)
    assert "&lt;b&gt;" in hostile and "<b>" not in hostile and "<i>" not in hostile


def solid_beside(kind: str, rng: np.random.Generator) -> fb.MassProperties:
    """A solid that lies anywhere, also with its own origin beside it."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    if kind == "mesh":
        return fb.mesh(corners + rng.integers(-3, 3, size=3) + 0.25, faces, mass=1)
    if kind == "revolved":
        z = sympy.Symbol("z")
        return fb.revolve(1 + z, (1, 2), z, density=1)
    made = {
        "cone": lambda: fb.cone(1, 0.2, 1), "disk": lambda: fb.disk(1, 0.3), "box": lambda: fb.box(1, (1, 2, 3)),
        "sphere": lambda: fb.sphere(1, 0.3), "particle": lambda: fb.particle(1),
        "tube": lambda: fb.tube(1, 0.1, 0.3, 1),
    }  # fmt: skip
    return made[kind]().moved(tuple(rng.integers(-1, 2, size=3).tolist()))


@pytest.mark.parametrize("kind", ["mesh", "revolved", "cone", "disk", "box", "sphere", "particle", "tube"])
def test_every_piece_is_drawn_with_numbers_wherever_the_joint_is(kind) -> None:
    """Joints in the body's origin, at the mass centre and elsewhere: rods lead from inside of a solid to the joint."""
    rng = np.random.default_rng(3)
    for at in ("origin", "centre", "elsewhere"):
        s = fb.System("machine")
        solid = solid_beside(kind, rng)
        body = s.body("body", solid)
        to = {
            "origin": (0, 0, 0),
            "centre": tuple(solid.center),
            "elsewhere": tuple(rng.normal(size=3).round(3) * 4),
        }
        s.ball("pin", s.ground, body, to=to[at])
        pieces = shapes(fb.assemble(s))["body"]
        drawn = next(piece for piece in pieces if piece.solid)
        point = np.array([float(x) for x in to[at]])
        assert any(np.linalg.norm(piece.points() - point, axis=1).min() < 0.5 for piece in pieces) or holds(
            drawn, point, 0.1
        )
        for piece in pieces:
            assert np.isfinite(piece.points()).all()
            assert np.isfinite(piece.axes).all()
            if piece.kind == "rod":
                assert piece["length"] > 0
                ends = [piece.center + side * piece["length"] / 2 * piece.axis for side in (-1, 1)]
                inside, outside = sorted(
                    ends, key=lambda end: float(np.linalg.norm(end - point)), reverse=True
                )
                np.testing.assert_allclose(outside, point, atol=1e-12)
                assert holds(drawn, inside, 1e-9)


def test_report_of_a_mesh_beside_its_origin(tmp_path) -> None:
    s = fb.System("block")
    s.gravity = (0, 0, -9.81)
    block = s.body("block", solid_beside("mesh", np.random.default_rng(1)))
    s.hinge("pin", s.ground, block, axis="x", coordinate="theta")
    motion = fb.simulate(s, 1, initial={"theta": 1})
    text = fb.report(s, motion, tmp_path / "block.html").read_text(encoding="utf-8")
    for body in scene_of(text)["bodies"]:
        assert np.isfinite(body["position"]).all() and np.isfinite(body["quaternion"]).all()
