"""Free-body diagrams are read back from their SVG: what is drawn sums up to the equations of the free body."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import freebody as fb
from contact_machines import DRAWN
from freebody.dynamics.kinematics import rotation
from freebody.errors import FormatError, ModelError, SimulationError
from freebody.gallery import entries
from freebody.picture.free_body.free_body_diagram import free_body_diagram
from freebody.picture.paper.sheet import Label, flat, overlap
from freebody.scalar.algebra import ZERO, add, apply, cross, floats, subtract
from freebody.scalar.expression import evaluate
from freebody.symbolic.free_body.planar import plane_in
from freebody.symbolic.printing.display import latex
from freebody.symbolic.solving.vocabulary import Vocabulary
from sampled import sampled

SVG = "{http://www.w3.org/2000/svg}"
LONG = {
    "whipple-bicycle",
    "euler-disk",
    "yo-yo",
    "turntable",
    "falling-cat",
    "energy-sink",
    "control-moment-gyro",
    "gyrocompass",
    "flat-spin",
}

# coordinates of an SVG have three decimals, and the shortest arrow that is measured is 25 pt long
MEASURED = 2 * 0.0005 * math.sqrt(2) / 25

ROUND_OFF = 1e-10
"""Of numbers with twelve digits, after sums of some dozen terms."""


CONTACTS = {f"{make.__name__}-{i}": (make, modes) for i, (make, modes) in enumerate(DRAWN)}
"""Machines with contacts, in modes of these."""


def machine(name: str) -> tuple[Any, dict[str, Any]]:
    if name in CONTACTS:
        make, modes = CONTACTS[name]
        return fb.equations(make(), modes=modes), {}
    entry = entries()[name]
    e = fb.equations(entry.build())
    return e, {key: x for key, x in entry.near.items() if key in e.model.coordinate_names}


@pytest.fixture(scope="module", params=sampled([*entries(), *CONTACTS], 9, LONG))
def drawn(request: pytest.FixtureRequest) -> tuple[Any, dict[str, Any]]:
    """Equations, and a diagram of every body."""
    e, near = machine(request.param)
    return e, {body: free_body_diagram(e, body, near=near) for body in e.model.bodies}


def groups(svg: str, kind: str) -> Iterator[ElementTree.Element]:
    """The arrows of one side of a diagram."""
    root = ElementTree.fromstring(svg)
    (panel,) = [g for g in root.iter(f"{SVG}g") if g.get("class") == kind]
    yield from (g for g in panel.iter(f"{SVG}g") if g.get("class") in ("force", "couple"))


def components(words: Vocabulary, text: str) -> Any:
    """Three expressions separated by semicolons, canonical."""
    return tuple(
        words.element(one.strip(), "a drawing") if one.strip() != "0" else 0 for one in text.split(";")
    )


def vector(e: Any, words: Vocabulary, g: ElementTree.Element) -> Any:
    """The force or couple of an arrow in ground axes, canonical."""
    v = components(words, g.get("data-vector", ""))
    frame = g.get("data-frame")
    return v if frame is None else apply(rotation(e.model, e.state, e.model.bodies[frame].link), v)


def summed(e: Any, words: Vocabulary, svg: str, kind: str, about: Any) -> tuple[Any, Any]:
    """Σ F and Σ M about a point, of what the attributes of a drawing say."""
    force, moment = ZERO, ZERO
    for g in groups(svg, kind):
        v, at = vector(e, words, g), components(words, g.get("data-at", ""))
        if g.get("class") == "force":
            force = add(force, v)
            moment = add(moment, cross(subtract(at, about), v))
        else:
            moment = add(moment, v)
    return force, moment


def held(free: Any) -> tuple[range | list[int], range | list[int]]:
    """Components of forces and of moments that the diagram shows: of a planar machine those in the plane."""
    found = plane_in(free)
    if isinstance(found, str):
        return range(3), range(3)
    return [k for k in range(3) if k != found[1]], [found[1]]


def test_the_drawing_sums_up_to_the_equations(drawn: Any) -> None:
    """Exactly, for every position: Σ of the drawn vectors is the left side, of the kinetic diagram the right side."""
    e, diagrams = drawn
    words = Vocabulary(e)
    for body, diagram in diagrams.items():
        free = e.free_body(body)
        arrows = [g for kind in ("free-body", "kinetic") for g in groups(diagram.svg, kind)]
        if any(g.get("data-vector") is None or g.get("data-at") is None for g in arrows):
            assert e.model.name in (
                "whipple_bicycle",
                "falling_cat",
            )  # its contact points are long: only in numbers, below
            continue
        forces, moments = held(free)
        for kind, sides in (("free-body", 0), ("kinetic", 1)):
            force, moment = summed(e, words, diagram.svg, kind, free._centre)
            for k in forces:
                assert force[k] - free.balances[k][sides] == 0, (body, kind, k)
            for k in moments:
                assert moment[k] - free.balances[3 + k][sides] == 0, (body, kind, k)


def numbers(e: Any, svg: str, body: str) -> dict[Any, float]:
    """The drawn position, and any values of the unknowns."""
    from freebody.picture.machine.configuration import configuration

    entry = next((one for one in entries().values() if one.build().name == e.model.name), None)
    near = {key: x for key, x in entry.near.items() if key in e.model.coordinate_names} if entry else {}
    now = configuration(e.model, near=near)
    draw = random.Random(7)
    lookup = dict(now.lookup)
    words = Vocabulary(e)
    for atom in {*words.reactions.values(), *words.accelerations.values()}:
        lookup[atom] = draw.uniform(0.5, 2.0)
    for speed in e.model.speeds:
        lookup[speed.symbol] = draw.uniform(0.5, 2.0)
    return lookup


def test_the_arrows_on_paper_sum_up_to_the_equations(drawn: Any) -> None:
    """Read with ruler and protractor: places and directions from the paths, magnitudes from the symbols."""
    e, diagrams = drawn
    for body, diagram in diagrams.items():
        free = e.free_body(body)
        words, root = Vocabulary(e), ElementTree.fromstring(diagram.svg)
        lookup = numbers(e, diagram.svg, body)

        def value(x: Any, lookup: dict[Any, float] = lookup) -> float:
            return float(evaluate(e.sympy(x), lookup, floats))

        view = np.array(root.get("data-view", "").split(), dtype=float).reshape(2, 3)
        toward = np.array(root.get("data-toward", "").split(), dtype=float)
        scale = float(root.get("data-scale", "nan"))
        left, top = map(float, root.get("data-origin", "").split())
        middle = np.array([value(x) for x in free._centre])
        center = scale * view @ middle
        for kind, side in (("free-body", 0), ("kinetic", 1)):
            (panel,) = [g for g in root.iter(f"{SVG}g") if g.get("class") == kind]
            shift = np.array(panel.get("data-shift", "").split(), dtype=float)
            force, turn, size, arm = np.zeros(2), 0.0, 0.0, 1.0
            whole, largest = np.zeros(6), 1.0
            for g in groups(diagram.svg, kind):
                magnitude = value(words.element(g.get("data-symbol", ""), "a symbol"))
                direction = np.array(g.get("data-direction", "").split(), dtype=float)
                seen = view @ direction
                if g.get("data-vector") is not None:
                    exact = np.array([value(x) for x in vector(e, words, g)])
                    assert magnitude * direction == pytest.approx(
                        exact, abs=ROUND_OFF * max(1, abs(magnitude))
                    )
                at = np.array(g.get("data-point", "").split(), dtype=float)
                if g.get("class") == "force":
                    whole[:3] += magnitude * direction
                    whole[3:] += magnitude * np.cross(at - middle, direction)
                else:
                    whole[3:] += magnitude * direction
                largest = max(largest, abs(magnitude) * max(1.0, float(np.linalg.norm(at - middle))))
                shaft = next((p for p in g.iter(f"{SVG}path") if p.get("class") == "shaft"), None)
                if shaft is None:  # along the line of sight
                    continue
                start, end = (
                    np.array(shaft.get(key, "").split(), dtype=float) for key in ("data-start", "data-end")
                )
                if g.get("data-turn"):
                    turn += magnitude * float(g.get("data-turn", ""))
                    size = max(size, abs(magnitude))
                    continue
                start, end = (np.array([p[0] - left, top - p[1]]) - shift for p in (start, end))
                d = (end - start) / np.linalg.norm(end - start)
                assert d == pytest.approx(seen / np.linalg.norm(seen), abs=MEASURED)
                if g.get("class") == "force":
                    at = scale * view @ np.array(g.get("data-point", "").split(), dtype=float)
                    off = np.cross(np.append(at - start, 0), np.append(d, 0))[2]
                    assert abs(off) < MEASURED * 300, "the line of action leads through the point"
                    if root.get("data-normal"):
                        force += magnitude * d
                        lever = np.cross(np.append(start - center, 0), np.append(d, 0))[2] / scale
                        turn += magnitude * lever
                        arm = max(arm, abs(lever), 300 / scale)
                        size = max(size, abs(magnitude))
            forces, moments = held(free)
            for k in [*forces, *(3 + k for k in moments)]:
                assert whole[k] == pytest.approx(value(free.balances[k][side]), abs=10 * ROUND_OFF * largest)
            if root.get("data-normal"):
                expected = [value(free.balances[k][side]) for k in range(3)]
                k = "xyz".index(root.get("data-normal", ""))
                assert force == pytest.approx(view @ expected, abs=8 * size * MEASURED + 1e-12)
                moment = value(free.balances[3 + k][side]) * toward[k]
                assert turn == pytest.approx(moment, abs=8 * size * arm * MEASURED + 1e-12)


def test_labels_are_the_symbols_of_the_equations(drawn: Any) -> None:
    e, diagrams = drawn
    words = Vocabulary(e)
    for diagram in diagrams.values():
        for kind in ("free-body", "kinetic"):
            for g in groups(diagram.svg, kind):
                (label,) = [p for p in g.iter(f"{SVG}path") if p.get("class") == "label"]
                symbol = latex(words.element(g.get("data-symbol", ""), "a symbol"), e.ring)
                if g.get("data-law") is None:
                    assert label.get("data-tex") == f"${symbol}$"
                else:
                    name, _, expression = g.get("data-law", "").partition(" = ")
                    assert label.get("data-tex", "").strip("$").removeprefix("-") == name
                    assert expression == symbol


def test_labels_lie_on_no_other(drawn: Any) -> None:
    _, diagrams = drawn
    for body, diagram in diagrams.items():
        labels = [item for item in flat(diagram.sheet.root) if isinstance(item, Label)]
        x0, y0, x1, y1 = diagram.sheet.box
        for i, one in enumerate(labels):
            a = one.box
            assert x0 <= a[0] and y0 <= a[1] and a[2] <= x1 and a[3] <= y1
            for other in labels[i + 1 :]:
                assert overlap(a, other.box) == 0, (body, one.tex, other.tex)


@pytest.mark.parametrize("name", ["ex-6-5", "double-pendulum", "four-bar", "slider-crank", "two-gears"])
def test_both_sides_of_a_joint_are_opposite_and_of_one_colour(name: str) -> None:
    e, near = machine(name)
    diagram = free_body_diagram(e, near=near)
    labels = [item.box for item in flat(diagram.sheet.root) if isinstance(item, Label)]
    assert not any(overlap(a, b) for i, a in enumerate(labels) for b in labels[i + 1 :])
    root = ElementTree.fromstring(diagram.svg)
    sides: dict[str, list[tuple[Any, str]]] = {}
    for g in root.iter(f"{SVG}g"):
        if g.get("data-kind") == "reaction" and g.get("class") == "force":
            d = np.array(g.get("data-direction", "").split(), dtype=float)
            color = next(p.get("stroke", "") for p in g.iter(f"{SVG}path") if p.get("class") == "shaft")
            sides.setdefault(g.get("data-symbol", ""), []).append((d, color))
    pairs = [both for both in sides.values() if len(both) == 2]
    assert pairs
    for (d1, c1), (d2, c2) in pairs:
        assert d1 == pytest.approx(-d2)
        assert c1 == c2
    bodies = {g.get("data-body") for g in root.iter(f"{SVG}g") if g.get("class") == "free-body"}
    assert bodies == set(e.model.bodies)


@pytest.fixture(scope="module")
def moving() -> tuple[Any, Any]:
    entry = entries()["ex-6-5"]
    s = entry.build()
    return s, fb.simulate(s, 1.0, initial={"theta": "40deg", "x": 0.1})


def test_to_scale_lengths_and_values_are_those_of_the_motion(moving: Any) -> None:
    s, trajectory = moving
    svg = free_body_diagram(s, "bar", trajectory=trajectory, at=0.5).svg
    root = ElementTree.fromstring(svg)
    unit = float(root.get("data-unit", "nan"))
    total, mass_acceleration = np.zeros(3), np.zeros(3)
    at = fb.simulate(s, 0.5, initial={"theta": "40deg", "x": 0.1}, times=[0.5])
    for kind in ("free-body", "kinetic"):
        for g in groups(svg, kind):
            value = float(g.get("data-value", "nan"))
            assert value > 0
            d = np.array(g.get("data-direction", "").split(), dtype=float)
            if g.get("class") == "couple":
                continue
            if kind == "kinetic":
                mass_acceleration += value * d
            else:
                total += value * d
            shaft = next(p for p in g.iter(f"{SVG}path") if p.get("class") == "shaft")
            ends = [np.array(shaft.get(key, "").split(), dtype=float) for key in ("data-start", "data-end")]
            if g.get("data-enlarged") is None:
                assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(unit * value, abs=0.002)
    # round-off of solving for the accelerations, in parts of the weight
    assert total == pytest.approx(mass_acceleration, abs=1e-12 * 9.81 * 10)
    pin = {
        g.get("data-name"): float(g.get("data-value", "nan"))
        * np.array(g.get("data-direction", "").split(), float)
        for g in groups(svg, "free-body")
    }
    # the two runs agree to their tolerance
    assert (pin["pin_x"] + pin["pin_y"]) == pytest.approx(at.reactions["pin"].force[0], rel=1e-6, abs=1e-6)


def test_symbolic_arrows_show_the_positive_sense_at_any_moment(moving: Any) -> None:
    s, trajectory = moving
    at = trajectory.at(0.5)
    by_time = free_body_diagram(s, "bar", trajectory=trajectory, at=0.5, mode="symbolic").svg
    by_name = free_body_diagram(s, "bar", at={"theta": at["theta"], "x": at["x"]}).svg

    pairs = [
        [g for kind in ("free-body", "kinetic") for g in groups(svg, kind)] for svg in (by_time, by_name)
    ]
    for one, other in zip(*pairs, strict=True):
        assert one.get("data-symbol") == other.get("data-symbol")
        d, e = (np.array(g.get("data-direction", "").split(), dtype=float) for g in (one, other))
        assert d == pytest.approx(e)
    assert "-pin_x" not in by_time and "data-value" not in by_time


def test_the_scale_is_refused_without_a_motion(moving: Any) -> None:
    s, trajectory = moving
    with pytest.raises(ModelError, match="pass trajectory="):
        free_body_diagram(s, "bar", mode="scale")
    with pytest.raises(SimulationError, match="Expected the time of the trajectory to draw"):
        free_body_diagram(s, "bar", trajectory=trajectory, at={"theta": 1})
    with pytest.raises(SimulationError):
        free_body_diagram(s, "bar", trajectory=trajectory, at=7.0)
    other = entries()["ex-6-5"].build()
    with pytest.raises(ModelError, match="Expected a trajectory of the system"):
        free_body_diagram(other, "bar", trajectory=trajectory, at=0.5)


def test_a_blank_diagram_has_no_arrows_of_forces(moving: Any) -> None:
    s, _ = moving
    svg = free_body_diagram(s, "bar", mode="blank").svg
    assert 'class="force"' not in svg and 'class="couple"' not in svg
    assert svg.count('class="outline"') == 2
    assert r"\mathrm{pin}" in svg


def test_requests_that_can_not_be_met(moving: Any) -> None:
    s, _ = moving
    with pytest.raises(ModelError, match="did you mean 'bar'"):
        free_body_diagram(s, "baar")
    with pytest.raises(ModelError, match="Expected 'symbolic', 'scale' or 'blank'"):
        free_body_diagram(s, "bar", mode="full")
    with pytest.raises(ModelError, match="A time needs trajectory="):
        free_body_diagram(s, "bar", at=0.5)
    with pytest.raises(FormatError, match=r"ends in \.svg, \.pdf, \.png, \.tex"):
        free_body_diagram(s, "bar").save("bar.jpeg")
    four_bar = entries()["four-bar"].build()
    with pytest.raises(ModelError, match="cannot be drawn at these coordinates"):
        free_body_diagram(four_bar, "coupler", at={"beta": 3.0, "psi": 0.0, "t": 0})


def test_files_of_every_kind(moving: Any, tmp_path: Any) -> None:
    s, _ = moving
    diagram = free_body_diagram(s, "bar", dimensions=True)
    starts = {".svg": b"<svg", ".pdf": b"%PDF", ".png": b"\x89PNG", ".tex": b"% Free-body"}
    for ending, start in starts.items():
        path = tmp_path / f"bar{ending}"
        diagram.save(path)
        assert path.read_bytes().startswith(start)
    tex = (tmp_path / "bar.tex").read_text()
    for pair in ("scope", "tikzpicture", "document"):
        assert tex.count(rf"\begin{{{pair}}}") == tex.count(rf"\end{{{pair}}}") > 0
    assert tex.count("{") == tex.count("}") and tex.count("$") % 2 == 0
    assert r"$\mathrm{pin}_{x}$" in tex and "-{Stealth" in tex
    defined = {line.split("{")[1].split("}")[0] for line in tex.splitlines() if "definecolor" in line}
    used = {
        word.split("=")[1] for word in tex.replace("]", ",").split(",") if word.startswith(("draw=", "fill="))
    }
    assert {color for color in used if not color.startswith("{")} <= defined | {"white"}
    assert diagram._repr_svg_() == diagram.svg and diagram.svg in diagram._repr_html_()


def test_nothing_is_fetched_and_nothing_runs(moving: Any) -> None:
    s, _ = moving
    svg = free_body_diagram(s).svg
    for forbidden in ("<script", "href=", "url(", "<image", "@import", "<foreignObject", "onload", "<text"):
        assert forbidden not in svg


def test_the_same_model_gives_the_same_drawing() -> None:
    one, two = (free_body_diagram(entries()["ex-6-5"].build()).svg for _ in range(2))
    assert one == two


def test_an_inclined_force_is_one_arrow_with_its_value() -> None:
    s = fb.System("pulled block")
    m, P, beta = s.parameters(m=1.0, P=2.0, beta="30deg")
    block = s.body("block", fb.box(m, (2, 1, 1)))
    s.slider("floor", s.ground, block, axis="x", coordinate="x")
    s.force("P", block.point(1, 0, 0), ("P*cos(beta)", "P*sin(beta)", 0))
    (arrow,) = [
        g for g in groups(free_body_diagram(s, "block").svg, "free-body") if g.get("data-name") == "P"
    ]
    assert arrow.get("data-symbol") == "P"
    d = np.array(arrow.get("data-direction", "").split(), dtype=float)
    assert d == pytest.approx([math.cos(math.radians(30)), math.sin(math.radians(30)), 0])


def test_a_spring_between_points_pulls_along_its_line_with_its_law() -> None:
    s = fb.System("bob on a spring")
    m, k, L = s.parameters(m=1.0, k=20.0, L=0.3)
    bob = s.body("bob", fb.particle(m))
    s.planar("plane", s.ground, bob, coordinate="x y turn")
    s.spring("spring", s.ground.point(0, 1, 0), bob.origin, stiffness=k, rest=L)
    (arrow,) = [
        g
        for g in groups(free_body_diagram(s, "bob", at={"x": 0.4, "y": 0.2}).svg, "free-body")
        if g.get("data-name") == "spring"
    ]
    d = np.array(arrow.get("data-direction", "").split(), dtype=float)
    assert abs(d @ [0.4, -0.8, 0]) == pytest.approx(math.hypot(0.4, 0.8))
    assert "k" in arrow.get("data-symbol", "") and "L" in arrow.get("data-symbol", "")


def test_the_sign_of_a_length_is_read_off_the_configuration() -> None:
    """A spring along a line has the length |x|: its force is written for the side on which it is drawn."""
    s = fb.System("two carts")
    m, k, L = s.parameters(m=1.0, k=20.0, L=0.3)
    carts = [s.body(name, fb.particle(m)) for name in ("left", "right")]
    for cart, q in zip(carts, ("x", "y"), strict=True):
        s.slider(f"rail_{q}", s.ground, cart, axis="x", coordinate=q)
    s.spring("spring", *(cart.origin for cart in carts), stiffness=k, rest=L)
    for at, symbol in (({"x": 0, "y": 1}, "k*(y - x - L)"), ({"x": 1, "y": 0}, "k*(x - y - L)")):
        svg = free_body_diagram(s, at=at).svg
        root = ElementTree.fromstring(svg)
        arrows = [g for g in root.iter(f"{SVG}g") if g.get("data-name") == "spring"]
        assert len(arrows) == 2
        directions = [np.array(g.get("data-direction", "").split(), dtype=float) for g in arrows]
        assert directions[0] == pytest.approx(-directions[1])
        words = Vocabulary(fb.equations(s))
        for g in arrows:
            assert "abs" not in g.get("data-symbol", "") and g.get("data-where")
            expected, found = (words.element(x, "a test") for x in (symbol, g.get("data-symbol", "")))
            assert found in (expected, -expected)


def test_what_is_zero_has_no_arrow_and_what_has_no_mass_is_named() -> None:
    """The turboprop is level: m a_z and two rates of its angular momentum are 0; a wheel of the gallery has no mass."""
    entry = entries()["prob-6-19"]
    drawing = free_body_diagram(fb.equations(entry.build()), "airframe", near=entry.near)
    shown = {
        g.get("data-name"): g.get("data-symbol")
        for g in ElementTree.fromstring(drawing.svg).iter(f"{SVG}g")
        if g.get("data-kind") == "kinetic"
    }
    assert shown == {"ma_C1": "11*psi'^2/2", "ma_C2": "11*psi''/2", "dH_Cz": "10*psi''"}
    entry = entries()["turning-car"]
    e = fb.equations(entry.build())
    for body, words in (("front", ["(no mass)"]), ("car", [])):
        labels = [
            label.tex
            for label in flat(free_body_diagram(e, body, near=entry.near).sheet.root)
            if isinstance(label, Label)
        ]
        assert [tex for tex in labels if tex.startswith("(no ")] == words


def test_an_inertia_is_drawn_in_the_positive_sense() -> None:
    """The moment about the mass centre of the aerofoil is (I_E - m s²) θ'', counter-clockwise."""
    svg = free_body_diagram(fb.equations(entries()["prob-6-14"].build()), "section").svg
    (couple,) = (
        g
        for g in ElementTree.fromstring(svg).iter(f"{SVG}g")
        if g.get("data-kind") == "kinetic" and g.get("class") == "couple"
    )
    assert couple.get("data-symbol") == "(I_E - m*s^2)*theta''" and couple.get("data-turn") == "1"


def test_a_rope_over_a_block_pulls_with_all_its_parts() -> None:
    e, near = machine("block-and-tackle")
    (arrow,) = [
        g
        for g in groups(free_body_diagram(e, "weight", near=near).svg, "free-body")
        if g.get("data-name") == "rope"
    ]
    assert arrow.get("data-symbol") == "4*rope" and arrow.get("data-where") == "x > 0"
    assert np.array(arrow.get("data-direction", "").split(), dtype=float) == pytest.approx([0, 1, 0])


def test_a_crowded_body_in_space_is_seen_from_where_its_points_are_apart() -> None:
    """The shafts of the turboprop lie behind one another from before; few arrows keep the view of the machine."""
    e, entry = machine("prob-6-19")[0], entries()["prob-6-19"]
    crowded, other = (
        ElementTree.fromstring(free_body_diagram(e, name, **entry.drawing()).svg)
        for name in ("airframe", "propeller")
    )
    views = [np.array(root.get("data-view").split(), dtype=float).reshape(2, 3) for root in (crowded, other)]
    points = {tuple(map(float, x.get("data-point").split())) for x in crowded.iter() if x.get("data-point")}
    near = [
        min(np.linalg.norm(v @ (np.array(p) - q)) for p in points for q in points if p != q) for v in views
    ]
    assert near[0] > 1.2 * near[1]
