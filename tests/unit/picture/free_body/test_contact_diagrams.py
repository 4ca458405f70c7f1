"""Free-body diagrams and drawings of machines with contacts: forces in the mode, at the point that touches."""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import sympy
from click.testing import CliRunner

import freebody as fb
from contact_machines import (
    DISK,
    ball_on_plane,
    block_on_incline,
    falling_rod,
    ladder,
    pulled_disk,
    seesaw,
    sliding_body,
)
from freebody.cli import command
from freebody.errors import ModelError, SimulationError, TooManyTermsError
from freebody.gallery import entries
from freebody.picture.free_body.free_body_diagram import free_body_diagram
from freebody.picture.machine.draw import draw
from freebody.picture.paper.sheet import Label, flat

SVG = "{http://www.w3.org/2000/svg}"


def arrows(svg: str) -> dict[str, ElementTree.Element]:
    root = ElementTree.fromstring(svg)
    (panel,) = [g for g in root.iter(f"{SVG}g") if g.get("class") == "free-body"]
    return {
        g.get("data-name", ""): g
        for g in panel.iter(f"{SVG}g")
        if g.get("class") in ("force", "couple") and g.get("data-name")
    }


def three(g: ElementTree.Element, key: str) -> np.ndarray:
    return np.array(g.get(key, "").split(), dtype=float)


def words(drawing: Any) -> str:
    return "\n".join(item.tex for item in flat(drawing.sheet.root) if isinstance(item, Label))


def color(g: ElementTree.Element) -> tuple[str | None, str | None]:
    shaft = next(p for p in g.iter(f"{SVG}path") if p.get("class") == "shaft")
    return shaft.get("stroke"), shaft.get("stroke-dasharray")


def test_forces_act_where_the_bodies_touch_and_friction_against_the_slip():
    for mode, sense in (("slip+", -1), ("slip-", 1)):
        found = arrows(free_body_diagram(pulled_disk(), "disk", modes={"floor": mode}).svg)
        N, T = found["N_floor"], found["T_floor"]
        assert three(N, "data-direction") == pytest.approx([0, 1, 0])
        assert three(T, "data-direction") == pytest.approx([sense, 0, 0])
        assert T.get("data-symbol") == "mu*N_floor"
        weight = next(g for g in found.values() if g.get("data-kind") == "weight")
        foot = three(weight, "data-point") - [0, 0.3, 0]
        for g in (N, T):
            assert three(g, "data-point") == pytest.approx(foot)


def test_friction_is_dashed_and_the_state_is_written():
    stick = free_body_diagram(pulled_disk(), "disk", modes={"floor": "stick"})
    found = arrows(stick.svg)
    assert found["T_floor"].get("data-kind") == "friction" and found["N_floor"].get("data-kind") == "reaction"
    assert color(found["T_floor"])[1] and not color(found["N_floor"])[1]
    assert r"contact floor: stick, $|T_{\mathrm{floor}}| \leq \mu N_{\mathrm{floor}}$" in words(stick)
    slip = free_body_diagram(pulled_disk(), "disk", modes={"floor": "slip+"})
    assert r"contact floor: slip, $|T_{\mathrm{floor}}| = \mu N_{\mathrm{floor}}$" in words(slip)
    opened = free_body_diagram(pulled_disk(), "disk", modes={"floor": "open"})
    assert "contact floor: open" in words(opened) and "N_floor" not in arrows(opened.svg)
    two = free_body_diagram(sliding_body(), "box", modes={"A": "slip+", "B": "slip+"})
    assert r"contacts A, B: slip, $|T| = \mu N$" in words(two)


def test_both_sides_of_a_contact_are_opposite_and_of_one_colour():
    drawing = free_body_diagram(seesaw(), modes={"feet": "slip-"})
    root = ElementTree.fromstring(drawing.svg)
    sides: dict[str, list[Any]] = {}
    for g in root.iter(f"{SVG}g"):
        if (g.get("data-name") or "")[:1] in "NT" and g.get("class") == "force":
            sides.setdefault(g.get("data-name", ""), []).append((three(g, "data-direction"), color(g)))
    assert set(sides) == {"N_feet_1", "T_feet_1", "N_feet_2", "T_feet_2"}
    for (d1, c1), (d2, c2) in sides.values():
        assert d1 == pytest.approx(-d2) and c1 == c2
    assert sides["N_feet_1"][0][1][0] == sides["T_feet_1"][0][1][0] != sides["N_feet_2"][0][1][0]


def test_to_scale_at_a_moment_in_the_mode_that_it_has():
    s = falling_rod()
    motion = fb.simulate(s, 0.9, initial={"x": -0.5 * math.sin(0.1), "y": 0.5 * math.cos(0.1), "phi": 0.1})
    slipping = next(change for change in motion.modes if change.mode.startswith("slip"))
    for t, state in ((0.3, "stick"), (slipping.start + 0.01, "slip")):
        drawing = free_body_diagram(s, "rod", trajectory=motion, at=t)
        assert f"contact O: {state}" in words(drawing)
        found = arrows(drawing.svg)
        at = fb.simulate(
            s, t, initial={"x": -0.5 * math.sin(0.1), "y": 0.5 * math.cos(0.1), "phi": 0.1}, times=[t]
        ).contacts["O"]
        N, T = (
            float(found[n].get("data-value", "nan")) * three(found[n], "data-direction")
            for n in ("N_O", "T_O")
        )
        # the two runs agree to their tolerance
        assert N[1] == pytest.approx(float(at.normal[0]), rel=1e-6)
        assert T[0] == pytest.approx(float(at.tangential[0]), rel=1e-6)
    sticking = words(free_body_diagram(s, "rod", trajectory=motion, at=0.3))
    assert r"\leq" in sticking and r"= \mu N_{O}$" in sticking


def test_forces_that_no_motion_determines_are_those_least_in_norm():
    s = sliding_body()
    motion = fb.simulate(s, 0.5, values={"F": 10.0})
    assert motion.indeterminate
    diagram = free_body_diagram(s, "box", trajectory=motion, at=0.2)
    assert "no motion determines the forces of A, B: least in norm" in words(diagram)
    found = arrows(diagram.svg)
    for name in ("A", "B"):
        least = float(motion.contacts[name].least[0, 1])
        drawn = float(found[f"T_{name}"].get("data-value", "nan")) * three(
            found[f"T_{name}"], "data-direction"
        )
        assert drawn[0] == pytest.approx(least, rel=1e-9) and least < 0
    total = sum(
        float(g.get("data-value", "nan")) * three(g, "data-direction")
        for g in found.values()
        if g.get("class") == "force"
    )
    assert total == pytest.approx(np.zeros(3), abs=1e-9 * 98.1)


def test_forces_across_a_direction_of_friction_that_no_motion_determines_hold_the_body():
    s = fb.System("block")
    s.gravity = (0, 1, -9.81)
    body = s.body("block", fb.particle(2))
    s.chain("move", s.ground, body, [fb.Slider(axis, axis) for axis in "xyz"])
    for name, x in (("left", -1), ("right", 1)):
        feet = body.point(x, 0, 0), s.ground.plane(normal="z")
        s.contact(name, *feet, friction=(0.2, 0.4), along="x")
    motion = fb.simulate(s, 0.5)
    found = arrows(free_body_diagram(s, "block", trajectory=motion, at=0.25).svg)
    for name in ("T2_left", "T2_right"):
        drawn = float(found[name].get("data-value", "nan")) * three(found[name], "data-direction")
        assert drawn == pytest.approx([0, -1, 0], abs=1e-9)


def test_in_space_friction_is_one_arrow_while_it_slips_and_two_while_it_sticks():
    stick = arrows(free_body_diagram(ball_on_plane(), "ball", modes={"floor": "stick"}).svg)
    assert {"N_floor", "T1_floor", "T2_floor"} <= set(stick)
    slip = arrows(free_body_diagram(ball_on_plane(), "ball", modes={"floor": ("slip", ("0.6", "0.8"))}).svg)
    assert three(slip["T_floor"], "data-direction")[2] == pytest.approx(0)
    assert slip["T_floor"].get("data-symbol") == "mu*N_floor"


@pytest.mark.parametrize(
    "make", [pulled_disk, ladder, falling_rod, block_on_incline, sliding_body, ball_on_plane]
)
def test_bodies_are_drawn_on_what_they_stand_on(make: Any):
    drawing = draw(make())
    root = ElementTree.fromstring(drawing.svg)
    touching = [g.get("data-contact") for g in root.iter(f"{SVG}g") if g.get("class") == "contact"]
    names = [contact.name for contact in fb.assemble(make()).contacts]
    assert touching == names
    assert sum(g.get("class") == "plane" for g in root.iter(f"{SVG}g")) == (2 if make is ladder else 1)


def test_coordinates_that_are_given_stay():
    # 0.1 m above the floor: nothing touches there
    svg = draw(pulled_disk(), at={"y": 0.1}).svg
    assert 'class="contact"' not in svg


REFUSED = {
    "unknown contact": ({"flor": "stick"}, "Unknown contact 'flor' in modes; did you mean 'floor'"),
    "unknown mode": ({"floor": "glue"}, "Unknown mode 'glue' of contact 'floor'"),
    "no mapping": ("stick", "Expected modes by contact"),
    "no sign": ({"floor": "slip"}, "expected 'slip+' or 'slip-'"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_modes_that_can_not_be_drawn(case: str):
    modes, message = REFUSED[case]
    with pytest.raises(ModelError) as found:
        free_body_diagram(pulled_disk(), "disk", modes=modes)  # type: ignore[arg-type]
    assert message in str(found.value)
    with pytest.raises(ModelError):
        draw(pulled_disk(), modes=modes)  # type: ignore[arg-type]


def test_a_motion_and_equations_have_modes_of_their_own():
    s = pulled_disk()
    motion = fb.simulate(s, 0.1)
    with pytest.raises(ModelError, match="no modes= with a motion"):
        free_body_diagram(s, "disk", trajectory=motion, at=0.05, modes={"floor": "stick"})
    with pytest.raises(ModelError, match="no modes= with the equations given"):
        free_body_diagram(fb.equations(s), "disk", modes={"floor": "stick"})
    with pytest.raises(SimulationError, match="within the run"):
        free_body_diagram(s, "disk", trajectory=motion, at=3.0)
    steps = fb.simulate(s, 0.1, method="timestepping", step=0.01)
    with pytest.raises(SimulationError, match="means over steps"):
        free_body_diagram(s, "disk", trajectory=steps, at=0.05)


def test_the_command_draws_contacts(tmp_path):
    model, out = tmp_path / "disk.toml", tmp_path / "disk.svg"
    model.write_text(DISK.replace("until = 0.2", "until = 1"))

    def run(*arguments: str) -> Any:
        return CliRunner().invoke(command, ["draw", str(model), *arguments, "-o", str(out)])

    found = run("--body", "disk", "--mode", "floor=slip+")
    assert found.exit_code == 0, found.output
    assert arrows(out.read_text())["T_floor"].get("data-symbol") == "mu*N_floor"
    assert run("--body", "disk").exit_code == 0 and "starts; modes=" in out.read_text()
    assert arrows(out.read_text()).keys() >= {"N_floor", "T_floor"}
    assert run("--body", "disk", "--at", "0.01").exit_code == 0
    assert "data-value" in out.read_text() and "T_floor" in arrows(out.read_text())
    for arguments, message in (
        (("--mode", "glue"), "expected symbolic, scale, blank, or a contact's mode"),
        (("--body", "disk", "--mode", "blank", "--mode", "scale"), "expected one mode of the arrows"),
        (("--body", "disk", "--at", "0.1", "--mode", "floor=stick"), "the motion gives the contact modes"),
    ):
        refused = run(*arguments)
        assert refused.exit_code == 2 and message in refused.output


def test_feet_are_joined_to_the_solid():
    from freebody.picture.machine.shapes import shapes

    s = fb.System("table")
    top = s.body("top", fb.box(1, (1, 0.1, 0.5)))
    s.planar("plane", s.ground, top, coordinate="x y phi")
    s.contact("feet", top.corners((-0.5, -0.4, 0), (0.5, -0.4, 0)), s.ground.plane())
    solid, *legs = shapes(fb.assemble(s))["top"]
    assert solid.kind == "box" and [leg.kind for leg in legs] == ["rod", "rod"]
    assert [leg.center.tolist() for leg in legs] == [pytest.approx([x, -0.225, 0]) for x in (-0.5, 0.5)]
    assert [leg["length"] for leg in legs] == pytest.approx([0.35, 0.35])


@pytest.mark.parametrize("beta", [0.3, 0.9])
def test_the_kinetic_diagram_lies_along_the_axes_of_the_joint(beta: float) -> None:
    """On a slope m a_C is along it, in one arrow where the body does not leave it; the vectors still add up."""
    system = entries()["ex-6-4"].build()
    e = fb.equations(system, modes={"slope": "stick"})
    svg = free_body_diagram(e, "disk", values={"beta": beta}).svg
    found = [
        g
        for g in ElementTree.fromstring(svg).iter(f"{SVG}g")
        if g.get("data-kind") == "kinetic" and g.get("class") == "force"
    ]
    directions = {g.get("data-name"): three(g, "data-direction") for g in found}
    assert directions["ma_Ct"] == pytest.approx([math.cos(beta), -math.sin(beta), 0])
    assert directions["ma_Cn"] == pytest.approx([math.sin(beta), math.cos(beta), 0])
    numbers = {**{p.name: p.default for p in e.model.parameters}, "beta": beta, "s_a": 3.0, "n_a": 2.0}
    names = {name: sympy.Symbol(name) for name in numbers}

    def vector(g: ElementTree.Element) -> np.ndarray:
        texts = g.get("data-vector", "").replace("''", "_a").split("; ")
        return np.array([float(sympy.sympify(x, locals=names).subs(numbers)) for x in texts])

    m = numbers["m"]
    expected = m * (3.0 * directions["ma_Ct"] + 2.0 * directions["ma_Cn"])
    assert sum(map(vector, found)) == pytest.approx(expected)


def test_diagrams_at_a_time_have_the_contacts_of_families_and_of_disks_that_lie():
    s = fb.System("ball on a coin")
    s.gravity = (0, 0, -10)
    ball, coin = s.body("ball", fb.sphere(1, 0.1)), s.body("coin", fb.disk(1, 0.1))
    s.free("air", s.ground, ball)
    s.free("lying", s.ground, coin)
    s.contacts("family", [ball.sphere(0.1), s.ground.plane(normal="z")], friction=0.5)
    s.contact("tail", coin.circle(0.1), s.ground.plane(normal="z"), friction=0.5)
    motion = fb.simulate(s, 0.1, initial={"air_z": 0.1, "air_x": 1})
    assert "10 N" in fb.free_body_diagram(s, "ball", trajectory=motion, at=0.05).svg
    assert fb.free_body_diagram(s, "coin", trajectory=motion, at=0.05).svg.count('class="force') >= 4


def test_diagrams_at_a_time_have_the_inputs_of_controllers_then():
    s = fb.System("cart")
    cart = s.body("cart", fb.particle(2))
    push = s.parameters(push=0.0)
    rail = s.slider("rail", s.ground, cart, axis="x", coordinate="x")
    s.force("motor", rail, push)
    s.controller(lambda t, x: 1 + (t > 0.45), 0.1, "push", name="law")
    motion = fb.simulate(s, 1)
    drawn = [fb.free_body_diagram(s, "cart", trajectory=motion, at=t).svg for t in (0.2, 0.8)]
    assert "= 1 N" in drawn[0] and "= 2 N" in drawn[1]


def boxes() -> fb.System:
    """Two boxes that touch each other and a floor as a family."""
    s = fb.System("stack")
    s.gravity = (0, 0, -9.81)
    bodies = [s.body(f"box{k}", fb.box(2, (0.3, 0.2, 0.1))) for k in range(2)]
    for k, body in enumerate(bodies):
        s.free(f"f{k}", s.ground, body)
    s.contacts(
        "stack", [*(body.box((0.3, 0.2, 0.1)) for body in bodies), s.ground.plane(normal="z")], friction=0.4
    )
    return s


PILE = {"f0_z": 0.05, "f1_z": 0.15, "f1_x": 0.05, "f1_vx": 0.3}


def test_a_patch_is_drawn_at_its_time_and_has_no_diagram():
    s = boxes()
    motion = fb.simulate(s, 0.02, initial=PILE)
    root = ElementTree.fromstring(draw(s, trajectory=motion, at=0.01).svg)
    touching = [g.get("data-contact") for g in root.iter(f"{SVG}g") if g.get("class") == "contact"]
    closed = [name for name, one in motion.contacts.items() if one.mode[-1] != "open" and name[-1] != "]"]
    assert sorted(touching) == sorted(closed) and len(closed) == 8
    with pytest.raises(TooManyTermsError) as caught:
        free_body_diagram(s, "box1", trajectory=motion, at=0.01)
    assert str(caught.value).endswith(
        "A diagram has no room for them. Take the forces as numbers, motion.contacts and motion.reactions of a motion, "
        "or see them on its bodies: fb.report(s, motion, 'page.html')."
    )


def test_what_a_family_has_no_equations_for_is_said():
    s = boxes()
    assert (
        fb.equations(s)
        .text()
        .startswith("Contacts of the family 'stack': left out, since only a motion has them\n")
    )
    motion = fb.simulate(s, 0.02, initial=PILE, method="timestepping", step=1e-3)
    refusals = {
        "Simulate with method='auto'.": lambda: free_body_diagram(s, "box1", trajectory=motion, at=0.01),
        "Give it and its time, trajectory=, at=.": lambda: free_body_diagram(s, "box1", initial=PILE),
        "the contacts of the family 'stack' are those of a motion, and have no equations. Leave it out.": lambda: (
            fb.equations(s, initial=PILE)
        ),
        "and have no equations. Declare one by s.contact.": lambda: fb.equations(
            s, modes={"stack[box0,box1]": "stick"}
        ),
        "Describe those that are closed by s.contact, or leave the family out.": lambda: fb.linearize(s),
    }
    for end, ask in refusals.items():
        with pytest.raises((ModelError, SimulationError)) as caught:
            ask()
        assert str(caught.value).endswith(end)
