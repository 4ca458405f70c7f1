"""Drawings of machines: every body, joint, spring, load and coordinate has its symbol, and no label lies on another."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner

import freebody as fb
from drawn import as_drawn, groups, scale_of, texts, view_of
from freebody.cli import command
from freebody.dynamics.state import float_state
from freebody.errors import ModelError
from freebody.gallery import entries
from freebody.picture.machine.configuration import configuration
from freebody.picture.machine.draw import draw
from freebody.picture.machine.machine_drawing import WIDE
from freebody.picture.machine.outlines import hull
from freebody.picture.machine.shapes import attachments, colors, hidden, scenery_of, shapes
from freebody.picture.paper.labels import outline, size_of
from freebody.picture.paper.palette import pale
from freebody.picture.paper.placing import inside
from freebody.picture.paper.sheet import Label, Line, flat, overlap
from sampled import sampled

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module", params=sampled(entries(), 2, ("whipple-bicycle",)))
def drawn(request: pytest.FixtureRequest) -> tuple[Any, Any]:
    entry = entries()[request.param]
    e = fb.equations(entry.build())
    near = {key: x for key, x in entry.near.items() if key in e.model.coordinate_names}
    return e.model, draw(e, near=near)


def named(svg: str, attribute: str) -> set[str]:
    root = ElementTree.fromstring(svg)
    return {str(g.get(attribute)) for g in root.iter(f"{SVG}g") if g.get(attribute)}


def test_everything_of_the_model_is_drawn(drawn: Any) -> None:
    model, drawing = drawn
    bodies = named(drawing.svg, "data-body")
    assert not bodies & hidden(model)
    # a link of a joint of several: no mass, and all joints at one point
    for name in set(model.bodies) - bodies - hidden(model):
        held = np.array(list(attachments(model, float_state(model), name).values()))
        assert model.bodies[name].mass == 0 and not np.ptp(held, axis=0).any()
        assert "planar" not in {joint.type for joint in model.joints.values()}
    joints = {
        name
        for name, joint in model.joints.items()
        if joint.type not in ("free", "planar") and {joint.parent, joint.child} - hidden(model) - {"ground"}
    }
    assert named(drawing.svg, "data-joint") >= joints
    assert named(drawing.svg, "data-load") >= set(model.loads)
    ropes = {name for name, one in model.constraints.items() if type(one).__name__ in ("Rope", "Gear")}
    assert named(drawing.svg, "data-constraint") >= ropes


def test_no_label_lies_on_another_or_off_the_sheet(drawn: Any) -> None:
    _, drawing = drawn
    labels = [item for item in flat(drawing.sheet.root) if isinstance(item, Label)]
    x0, y0, x1, y1 = drawing.sheet.box
    for i, one in enumerate(labels):
        a = one.box
        assert x0 <= a[0] and y0 <= a[1] and a[2] <= x1 and a[3] <= y1
        for other in labels[i + 1 :]:
            assert overlap(a, other.box) == 0, (one.tex, other.tex)


def test_joints_at_one_point_share_a_label() -> None:
    """Three and more; two have their own. A joint with the name of its body has no second label."""
    svg = draw(entries()["control-moment-gyro"].build()).svg
    (tex,) = re.findall(r'data-tex="([^"]*pivot[^"]*)"', svg)
    assert tex.count(", ") == 1 and "axle" in tex and len(re.findall(r'data-tex="[^"]*gimbal', svg)) == 1
    assert 'data-tex="$\\mathrm{pin}$"' in draw(entries()["ex-6-5"].build()).svg


def test_a_name_of_several_words_is_written_in_words() -> None:
    svg = draw(entries()["slider-crank"].build()).svg
    assert 'data-tex="wrist pin"' in svg and 'data-tex="crank pin"' in svg
    assert r"$\mathrm{cord}_{1}$" in draw(entries()["yo-yo"].build()).svg  # a number is an index


def test_a_block_of_a_tackle_has_a_sheave_for_each_pair_of_strands() -> None:
    drawing = draw(entries()["block-and-tackle"].build(), near={"x": 3, "y": 1})
    (pulleys,) = groups(drawing, "pulleys")
    radii = sorted(
        round(item.radius, 3) for item in pulleys.items if hasattr(item, "radius") and item.radius > 2
    )
    # two blocks of two sheaves, for strands at 3.5 and 10.5 pt from the middle, and the pulley of the counterweight
    assert radii.count(10.5) == 2 and len(radii) >= 5


def test_the_axes_of_a_body_without_any_of_its_own_are_not_drawn() -> None:
    assert len(groups(draw(entries()["turntable"].build()), "body-axes")) == 0
    assert len(groups(draw(entries()["energy-sink"].build()), "body-axes")) == 1


def test_the_angle_of_a_rope_is_shown_by_what_slides_on_it() -> None:
    (angle,) = groups(draw(entries()["pumped-swing"].build()), "angle")
    assert angle.attributes["data-symbol"] == r"\theta"


def test_the_ellipsoid_that_lies_on_a_table_lies() -> None:
    """Bodies that stand on something are drawn upright, not a little turned."""
    drawing = draw(entries()["rattleback"].build())
    stone = next(g for g in drawing.sheet.root.items if g.attributes.get("data-body") == "stone")
    points = np.vstack([item.points for item in stone.items])
    wide, high = np.ptp(points, axis=0)
    assert wide > high


def test_a_drive_that_starts_from_rest_is_drawn_turned() -> None:
    """By 52 degrees or a little more: the time of the drawing is that at which it has turned so far."""
    s = fb.System("arm")
    arm = s.body("arm", fb.slender_bar(1, 1, axis="x"))
    s.hinge("pin", s.ground, arm, to=(-1 / 2, 0, 0), coordinate=s.t**2)
    drawing = draw(s)
    turned = configuration(fb.assemble(s)).t ** 2
    assert math.radians(52) < turned < 1.25**2 * math.radians(52)
    assert 'data-body="arm"' in drawing.svg


def test_a_round_wall_is_within_the_width() -> None:
    drawing = draw(entries()["prob-6-7"].build())
    x0, _, x1, _ = drawing.sheet.box
    assert x1 - x0 < 1.4 * WIDE


def test_coordinates_are_marked_by_their_symbols() -> None:
    svg = draw(entries()["ex-6-5"].build()).svg
    assert 'data-tex="$\\theta$"' in svg and 'data-tex="$x$"' in svg
    svg = draw(entries()["double-pendulum"].build()).svg
    assert r"\theta_{1}" in svg and r"$\theta_{2}$" in svg  # the absolute angle, not theta_2 - theta_1
    svg = draw(entries()["gyroscope"].build()).svg
    assert all(rf'data-tex="$\{angle}$"' in svg for angle in ("psi", "theta", "phi"))


def test_a_drawing_stands_where_it_was_asked_for() -> None:
    s = entries()["ex-6-2"].build()
    for angle in (20.0, 110.0, -35.0):
        drawing = draw(s, at={"theta": f"{angle}deg"})
        body = next(g for g in drawing.sheet.root.items if g.attributes.get("data-body") == "bar")
        points = body.items[0].points
        _, _, V = np.linalg.svd(points - points.mean(axis=0))
        assert abs(V[0] @ [math.cos(math.radians(angle)), math.sin(math.radians(angle))]) == pytest.approx(1)


def test_a_moment_of_a_motion() -> None:
    s = entries()["ex-6-2"].build()
    trajectory = fb.simulate(s, 0.5, initial={"theta": 0})
    by_time = draw(s, trajectory=trajectory, at=0.4)
    by_name = draw(s, at={"theta": trajectory.at(0.4)["theta"]})
    assert by_time.sheet.title == "hinged_bar, t = 0.4 s"
    shapes_of = [
        next(g for g in d.sheet.root.items if g.attributes.get("data-body") == "bar").items[0].points
        for d in (by_time, by_name)
    ]
    assert shapes_of[0] == pytest.approx(shapes_of[1])


def test_refusals() -> None:
    s = entries()["ex-6-2"].build()
    with pytest.raises(ModelError, match="A time needs trajectory="):
        draw(s, at=0.5)
    with pytest.raises(ModelError, match="has no body"):
        draw(fb.System("empty"))


@pytest.mark.parametrize(
    "solid",
    [
        fb.slender_bar(1, 2), fb.disk(1, 1), fb.ring(1, 1), fb.cylinder(1, 0.3, 2), fb.tube(1, 0.2, 0.4, 1),
        fb.cone(1, 0.5, 1), fb.box(1, (1, 2, 3)), fb.plate(1, (1, 2)), fb.sphere(1, 1), fb.spherical_shell(1, 1),
        fb.ellipsoid(1, (1, 2, 3)), fb.torus(1, 1, 0.2), fb.particle(1),
        fb.box(4, (1, 1, 1)) + fb.sphere(1, 0.5).moved((0, 0, 1)),
        fb.MassProperties(1, (0, 0, 0), ((1, 0, 0), (0, 2, 0), (0, 0, 2))),
    ],
    ids=lambda solid: solid.shape.kind if solid.shape else "numbers",
)  # fmt: skip
def test_every_solid_has_an_outline_about_its_centre(solid: fb.MassProperties) -> None:
    s = fb.System("one")
    body = s.body("body", solid)
    s.free("air", s.ground, body)
    e = fb.equations(s)
    assert shapes(e.model)["body"]
    drawing = draw(e)
    group = next(g for g in drawing.sheet.root.items if g.attributes.get("class") == "body")
    points = np.vstack(
        [
            item.points
            if hasattr(item, "points")
            else [item.center + [dx, dy] for dx in (-1, 1) for dy in (-1, 1)]
            for item in group.items
        ]
    )
    assert inside(hull(points), np.zeros((1, 2)) + 1e-3)[0]


def test_letters_are_measured_as_they_are_drawn() -> None:
    left, bottom, right, top = outline(r"$\frac{1}{2} m L \ddot{\theta}$").box
    assert size_of(r"$\frac{1}{2} m L \ddot{\theta}$", 10) == pytest.approx(
        (10 * (right - left), 10 * (top - bottom))
    )
    assert size_of("$m g$", 12)[0] > size_of("$m$", 12)[0]


def test_the_command_writes_the_file(tmp_path: Path) -> None:
    run = CliRunner()
    for arguments, start in (
        (["ex-6-5", "-o", str(tmp_path / "machine.svg")], "<svg"),
        (["ex-6-5", "--body", "bar", "--at", "theta=30deg", "-o", str(tmp_path / "bar.tex")], "% Free-body"),
        (
            ["ex-6-5", "--body", "all", "--mode", "blank", "--set", "a=1", "-o", str(tmp_path / "all.svg")],
            "<svg",
        ),
    ):
        result = run.invoke(command, ["draw", *arguments])
        assert result.exit_code == 0, result.output
        assert result.output == f"Wrote {arguments[-1]}\n"
        assert Path(arguments[-1]).read_text().startswith(start)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["ex-6-5", "--body", "baar"], "did you mean 'bar'"),
        (["ex-6-5", "-o", "x.jpg"], "expected a file name that ends in .svg, .pdf, .png, .tex"),
        (["ex-6-5", "--at", "1", "--at", "theta=1"], "expected one time, or coordinates by name, not both"),
        (["ex-6-5", "--at", "-1"], "expected a time of 0 s or later"),
        (
            ["ex-6-5", "--at", "1e9"],
            "a time within the run of ex-6-5, 0 to 10 s, got 1e+09 s; add --until 1e+09 for a longer run",
        ),
        (["ex-6-5", "--at", "2", "--until", "1"], "0 to 1 s, got 2 s; --until ends before it"),
        (["ex-6-5", "--at", "thet=1"], "did you mean 'theta'"),
        (["ex-6-5", "--mode", "blank"], "--mode is for free-body diagrams"),
    ],
)
def test_the_command_refuses(arguments: list[str], message: str, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(command, ["draw", *arguments])
    assert result.exit_code != 0
    assert message in result.output + str(result.exception)
    assert not list(tmp_path.iterdir())


def test_a_time_beyond_the_run_needs_its_length(tmp_path: Path) -> None:
    model, out = tmp_path / "body.toml", tmp_path / "body.svg"
    model.write_text(
        'name = "body"\n[bodies.body]\nsolid = "sphere"\nmass = 1\nradius = 1\n'
        '[joints.way]\ntype = "slider"\nchild = "body"\naxis = "x"\ncoordinate = "x"\n[initial]\n"x\'" = 1\n'
    )
    arguments = ["draw", str(model), "--at", "2", "-o", str(out)]
    refused = CliRunner().invoke(command, arguments)
    assert refused.exit_code == 2 and "has no length of its run; add --until 2" in refused.output
    assert CliRunner().invoke(command, [*arguments, "--until", "2"]).exit_code == 0 and out.exists()
    beyond = f"{entries()['ex-6-2'].until + 0.5:g}"
    longer = ["draw", "ex-6-2", "--at", beyond, "--until", beyond, "-o", str(out)]
    assert CliRunner().invoke(command, longer).exit_code == 0


def test_shape_and_colour_are_what_was_chosen() -> None:
    s = fb.System("cart")
    cart = s.body("cart", fb.particle(2), shape=fb.box(1, (0.4, 0.2, 0.2)), color="#0072B2")
    plain = s.body(
        "plain", fb.MassProperties(1, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1))), color="#D55E00"
    )
    s.slider("rail", s.ground, cart, coordinate="x")
    s.slider("other", s.ground, plain, coordinate="y")
    model = fb.assemble(s)
    (piece,) = shapes(model)["cart"]
    assert piece.kind == "box" and piece.dimensions == {"x": 0.4, "y": 0.2, "z": 0.2}
    assert cart.mass_properties is not None and cart.mass_properties.mass == 2
    assert colors(model) == {"cart": "#0072B2", "plain": "#D55E00"}
    assert [piece.kind for piece in shapes(model)["plain"]] == ["ellipsoid"]
    svg = draw(s).svg
    assert pale("#0072B2") in svg and pale("#D55E00") in svg


def test_no_shape_and_no_colour() -> None:
    s = fb.System("cart")
    with pytest.raises(ModelError, match="Expected a solid for shape= of body 'cart'"):
        s.body("cart", fb.particle(2), shape="box")
    with pytest.raises(ModelError, match="Expected a colour such as '#0072B2'"):
        s.body("cart", fb.particle(2), color="blue")
    assert not s.bodies


def test_the_page_on_drawings_does_what_it_says(tmp_path: Path, monkeypatch: Any) -> None:
    """Its code runs and writes the files, the two that it shows among them."""
    docs = Path(__file__).parents[4] / "docs"
    page = (docs / "drawings.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    scope: dict[str, Any] = {}
    for code in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(compile(code, "drawings.md", "exec"), scope)
    for name in re.findall(r'\.save\("(.*?)"\)', page):
        assert (tmp_path / name).stat().st_size > 1000
    for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page):
        shown, made = ((folder / name).read_text(encoding="utf-8") for folder in (docs, tmp_path))
        assert re.findall(r'data-tex="[^"]*"', shown) == re.findall(r'data-tex="[^"]*"', made)


def test_a_crowded_machine_in_space_has_few_labels() -> None:
    """Of more than five bodies in space: no lengths unless asked for; a joint and its coordinate have one label."""
    s = fb.System("arm")
    L = s.parameters(L=0.4)
    parent, at = s.ground, (0, 0, 0)
    for i in range(6):
        link = s.body(f"link{i}", fb.box(1, (0.1, 0.1, L)).moved((0, 0, L / 2)))
        s.hinge(f"turn{i}", parent, link, at=at, axis="xz"[i % 2], coordinate=f"turn{i}")
        parent, at = link, (0, 0, L)
    plain, with_lengths = fb.draw(s).svg, fb.draw(s, dimensions=True).svg
    assert 'class="dimension"' not in plain and 'class="dimension"' in with_lengths
    labels = [item.tex for item in flat(fb.draw(s).sheet.root) if isinstance(item, Label)]
    assert sorted(tex for tex in labels if "turn" in tex) == [rf"$\mathrm{{turn}}_{{{i}}}$" for i in range(6)]


def test_a_joint_by_functions_shows_its_curve():
    s = fb.System("cycloid")
    bead = s.body("bead", fb.particle(1))
    s.path_joint("wire", s.ground, bead, coordinate="p", position=("p + sin(p)", "1 - cos(p)", 0))
    svg = fb.draw(s, at={"p": 0.8}).svg
    curve = re.search(r'data-joint="wire".*?d="(M[^"]*)"', svg, re.DOTALL)
    points = np.array([float(x) for x in re.findall(r"-?[0-9.]+", curve[1])]).reshape(-1, 2)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert len(points) == 49 and steps == pytest.approx(3.0, rel=0.1)


def test_solids_of_contacts_are_drawn_where_nothing_else_shows_them():
    s = fb.System("solids")
    numbers = fb.MassProperties(1, (0, 0, 0), [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    bodies = {name: s.body(name, numbers) for name in ("box", "stone", "pill")}
    seen = s.body("seen", fb.box(1, (2, 1, 1)))
    for name, body in {**bodies, "seen": seen}.items():
        s.free(f"f_{name}", s.ground, body)
    shapes_of = [
        bodies["box"].box((0.4, 0.2, 0.1), at=(0.1, 0, 0)),
        bodies["stone"].hull((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
        bodies["pill"].capsule((0, 0, -1), (0, 0, 1), 0.5),
        seen.box((2, 1, 1)),
        s.ground.box((3, 3, 1), at=(0, 0, -0.5)),
    ]
    s.contacts("pile", shapes_of)
    model = fb.assemble(s)
    pieces = shapes(model)
    assert [piece.kind for piece in pieces["box"]] == ["box"] and pieces["box"][0]["x"] == 0.4
    np.testing.assert_allclose(pieces["box"][0].center, (0.1, 0, 0), atol=1e-15)
    assert [piece.kind for piece in pieces["stone"]] == ["mesh"] and len(pieces["stone"][0]["faces"]) == 4
    assert [piece.kind for piece in pieces["pill"]] == ["cylinder", "sphere", "sphere"]
    assert [piece.kind for piece in pieces["seen"]] == ["box"]  # the solid of its mass, once
    (table,) = scenery_of(model, float_state(model), 1.0)
    assert table.kind == "box" and table["z"] == 1
    assert 'class="scenery"' in fb.draw(s).svg


def test_a_block_lies_along_its_guide() -> None:
    """The rider of the swing: its edges are along the rope and across it."""
    drawing, now = draw(entries()["pumped-swing"].build(), at={"theta": "35deg"}), math.radians(35)
    (rider,) = (g for g in groups(drawing, "body") if g.attributes["data-body"] == "rider")
    edge = rider.items[0].points[1] - rider.items[0].points[0]
    assert math.remainder(math.atan2(edge[1], edge[0]) - now, math.pi / 2) == pytest.approx(0, abs=1e-9)


def test_a_guide_ends_at_its_origin_and_does_not_cross_a_rope() -> None:
    """The guide of the counterweight stands on its free side, below the pulley on the ceiling."""
    drawing = draw(entries()["block-and-tackle"].build(), near={"x": 3, "y": 1})
    (guide,) = (g for g in groups(drawing, "joint") if g.attributes["data-joint"] == "right")
    (rope,) = groups(drawing, "rope")
    edge, strands = guide.items[0].points, np.vstack([line.points for line in rope.items])
    assert edge[:, 0].min() > strands[:, 0].max() and edge[:, 1].max() <= strands[:, 1].max() + 1e-9


def test_an_angle_has_its_line_where_no_bar_shows_it() -> None:
    """From the corner of the ledge to the middle of the disk, but not along a pendulum."""
    for name, lines in (("prob-6-8", 2), ("prob-6-4", 1)):
        (angle,) = groups(draw(entries()[name].build(), at=dict(entries()[name].drawn) or None), "angle")
        assert sum(isinstance(item, Line) for item in angle.items) == lines


def test_what_is_too_small_is_drawn_enlarged() -> None:
    """The eccentricity of a rotor of 0.1 m is 0.2 mm."""
    _, drawing, _ = as_drawn("jeffcott-rotor")
    assert "$e$" in texts(drawing) and "$e$" not in texts(draw(entries()["jeffcott-rotor"].build()))


@pytest.mark.parametrize("first, second", [("sphere", "cylinder"), ("sphere", "sphere"), ("point", "sphere")])
@pytest.mark.parametrize("space", [False, True])
def test_concentric_shapes_are_drawn(first, second, space):
    """No point of them is the nearest one, so that nothing is drawn to touch; a motion refuses the overlap."""
    s = fb.System("concentric")
    one = s.body("one", fb.sphere(1, 0.1))
    if space:
        s.free("air", s.ground, one)
    else:
        s.planar("air", s.ground, one, coordinate="x y turn")
    feature = one.origin if first == "point" else getattr(one, first)(0.1)
    s.contact("c", feature, getattr(s.ground, second)(0.1), friction=0.3)
    assert "<svg" in str(fb.draw(s)) or fb.draw(s).svg
    with pytest.raises(fb.errors.SimulationError, match="contact 'c' 0.[12] m deep"):
        fb.simulate(s, 0.1)


def test_the_last_of_several_angles_about_a_point_lies_apart_on_its_axis() -> None:
    s = fb.System("top")
    rotor = s.body("rotor", fb.disk(1, 0.3, axis="z"))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -1), axis="ZXZ", coordinate="psi theta phi")
    at = {"psi": 0.5, "theta": 1.1, "phi": 0.8}
    drawing = fb.draw(s, at=at)
    axis = np.array([math.sin(1.1) * math.sin(0.5), -math.sin(1.1) * math.cos(0.5), math.cos(1.1)])
    center = scale_of(drawing) * view_of(drawing) @ axis
    psi, theta, phi = (group.items[0].points[0] for group in groups(drawing, "coordinate"))
    assert psi == pytest.approx([0, 0], abs=1e-9) and theta == pytest.approx([0, 0], abs=1e-9)
    part = float(phi @ center) / float(center @ center)
    assert 0.4 < part < 0.8 and phi == pytest.approx(part * center, abs=1e-9)


def test_a_line_leads_from_a_name_that_stands_apart() -> None:
    """The name of the gimbal is beside the car; names at their bodies and joints have no line."""
    _, drawing, _ = as_drawn("gyro-monorail")
    leaders = [group.items[0].points for group in groups(drawing, "leader")]
    (label,) = (item for item in flat(drawing.sheet.root) if isinstance(item, Label) and item.tex == "gimbal")
    starts = [
        p
        for p, _ in leaders
        if label.box[0] - 3 < p[0] < label.box[2] + 3 and label.box[1] - 3 < p[1] < label.box[3] + 3
    ]
    assert len(starts) == 1 and all(np.linalg.norm(q - p) > 5 for p, q in leaders)
    assert not groups(as_drawn("four-bar")[1], "leader")


def test_the_angle_of_a_body_about_its_mass_centre_is_that_of_its_axis() -> None:
    s = fb.System("wheel")
    s.hinge("axle", s.ground, s.body("wheel", fb.disk(1, 0.3)), axis="z", coordinate="phi")
    (angle,) = groups(fb.draw(s, at={"phi": 0.7}), "angle")
    line, reference = (item.points for item in angle.items if type(item) is Line)
    assert math.atan2(*(line[1] - line[0])[::-1]) == pytest.approx(0.7, abs=1e-12)
    assert math.atan2(*(reference[1] - reference[0])[::-1]) == pytest.approx(0.0, abs=1e-12)


def test_the_same_angle_about_the_same_point_is_drawn_once() -> None:
    """Both reels of the yo-yo turn by phi about the axis of the drum, which turns by theta."""
    names = [name.strip("$") for name in texts(as_drawn("yo-yo")[1])]
    assert names.count(r"\phi") == names.count(r"\theta") == 1, names
    assert names.count(r"R \phi") == 2  # lengths at two places


def test_a_tin_is_drawn_along_its_axis_and_across():
    """Two lines of its wall and two ends, or a circle."""
    for axis, count in (("x", 4), ("z", 1)):
        s = fb.System("tin")
        body = s.body("b", fb.box(1, (0.1, 0.1, 0.1)))
        s.planar("f", s.ground, body, coordinate="x y turn")
        s.contact("t", body.corners(size=(0.1, 0.1)), s.ground.drum(0.2, 0.6, axis=axis, inside=True))
        assert draw(s).svg.count('class="plane"') == count


@pytest.mark.parametrize("solid", ["hull", "drum"])
def test_feet_in_the_box_of_a_round_body_are_held_from_its_middle(solid):
    s = fb.System("ball with feet")
    s.gravity = (0, 0, -9.81)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, ball)
    shape = (
        ball.drum(0.1, 0.1)
        if solid == "drum"
        else ball.hull((0, 0, -0.1), (0.1, 0, 0.1), (-0.1, 0.1, 0.1), (-0.1, -0.1, 0.1))
    )
    s.contact("floor", shape, s.ground.plane(normal="z"))
    assert 'data-body="ball"' in fb.draw(s, at={"f_z": 0.2}).svg
