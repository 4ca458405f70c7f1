"""Gears: forces of teeth on wheels and bearings by hand, and what is said where a ratio leaves them open."""

from __future__ import annotations

import math

import pytest
import sympy
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command
from freebody.errors import ModelError

R1, R2, R3 = 0.1, 0.25, 0.2
ALGEBRA = 1e-13
ANGLE = math.pi / 9
F = 50.0  # tangential, of a torque of 5 N m on the first wheel
OUT = F * math.tan(ANGLE)


def pair(**options):
    """Two wheels, a torque on each, in balance."""
    s = fb.System("pair")
    one, two = s.body("one", fb.disk(1, R1)), s.body("two", fb.disk(2, R2))
    first = s.hinge("first", s.ground, one, coordinate="p")
    second = s.hinge("second", s.ground, two, at=(R1 + R2, 0, 0), coordinate="q")
    s.gear(first, second, -R2 / R1, name="mesh", **options)
    s.torque("drive", first, F * R1)
    s.torque("load", second, F * R2)
    return s


def start(s, **given):
    return fb.simulate(s, 0.1, samples=2, **given)


def force(motion, joint):
    return motion.reactions[joint].force[0]


def test_two_wheels_by_hand():
    """The driver pushes the driven wheel down, which pushes it up; both are pressed apart."""
    found = start(pair(pressure_angle="pi/9"))
    assert found["p'"][-1] == pytest.approx(0, abs=1e-9)
    assert force(found, "first") == pytest.approx([OUT, F, 0], rel=ALGEBRA)
    assert force(found, "second") == pytest.approx([-OUT, -F, 0], rel=ALGEBRA)
    assert found.indeterminate == ()


def test_an_idler_is_pressed_by_both_its_neighbours():
    """In line: twice the tangential force, and the radial ones cancel. The outer two turn alike."""
    s = pair(pressure_angle="pi/9")
    three = s.body("three", fb.disk(1, R3))
    third = s.hinge("third", s.ground, three, at=(R1 + 2 * R2 + R3, 0, 0), coordinate="r")
    s.gear(s.joints["second"], third, -R3 / R2, name="next", pressure_angle="pi/9")
    del s.loads["load"]
    s.torque("load", third, -F * R3)
    found = start(s)
    assert found["p'"][-1] == pytest.approx(0, abs=1e-9)
    assert force(found, "first") == pytest.approx([OUT, F, 0], rel=ALGEBRA)
    assert force(found, "second") == pytest.approx([0, -2 * F, 0], rel=ALGEBRA, abs=1e-12)
    assert force(found, "third") == pytest.approx([-OUT, F, 0], rel=ALGEBRA)


def planetary(rs, rp):
    """The ring is the ground, seen from the arm."""
    s = fb.System("planetary")
    arm, sun, planet = (
        s.body("arm", fb.disk(1, 0.1)),
        s.body("sun", fb.disk(1, rs)),
        s.body("planet", fb.disk(1, rp)),
    )
    turn = s.hinge("turn", s.ground, arm, coordinate="a")
    axle = s.hinge("axle", arm, sun, coordinate="p")
    pin = s.hinge("pin", arm, planet, at=(rs + rp, 0, 0), coordinate="q")
    s.gear(axle, pin, -rp / rs, name="inside", pressure_angle="pi/9")
    s.gear(turn, pin, -rp / (rs + 2 * rp), name="outside", pressure_angle="pi/9")
    return s


def test_a_planetary_gear_by_hand():
    """The pin carries twice the tangential force; sun and ring press the planet in and out alike."""
    rs, rp = 0.1, 0.04
    s = planetary(rs, rp)
    s.torque("drive", s.bodies["sun"], (0, 0, F * rs))
    s.torque("load", s.bodies["arm"], (0, 0, -2 * F * (rs + rp)))
    found = start(s)
    assert found["a'"][-1] == pytest.approx(0, abs=1e-9)
    assert force(found, "pin") == pytest.approx([0, -2 * F, 0], rel=ALGEBRA, abs=1e-12)
    # of one planet the sun's bearing feels the teeth, and the ring's the rest
    assert force(found, "axle") == pytest.approx([OUT, F, 0], rel=ALGEBRA)
    assert force(found, "turn") == pytest.approx([OUT, -F, 0], rel=ALGEBRA)
    # the ring stands: i = (1 + R/r)
    turned = fb.simulate(planetary(rs, rp), 1, initial={"a": 0, "a'": 1})
    assert turned["p'"][-1] + turned["a'"][-1] == pytest.approx(1 + (rs + 2 * rp) / rs, rel=1e-12)


def test_a_rack_by_hand():
    """Either way round: the rack is pressed from the pinion, the pinion's bearing holds both parts."""
    for order in (1, -1):
        s = fb.System("rack")
        bar, pinion = s.body("bar", fb.box(2, (1, 0.1, 0.1))), s.body("pinion", fb.disk(1, R1))
        slide = s.slider("slide", s.ground, bar, axis="x", coordinate="x")
        turn = s.hinge("turn", s.ground, pinion, at=(0, R1, 0), coordinate="p")
        joints, ratio = ((slide, turn), R1) if order > 0 else ((turn, slide), 1 / R1)
        s.gear(*joints, ratio, name="teeth", pressure_angle="pi/9")
        s.torque("drive", turn, F * R1)
        s.force("load", slide, -F)
        found = start(s)
        assert found["x'"][-1] == pytest.approx(0, abs=1e-9)
        assert force(found, "turn") == pytest.approx([F, -OUT, 0], rel=ALGEBRA)
        assert force(found, "slide") == pytest.approx([0, OUT, 0], rel=ALGEBRA)


def test_a_driven_shaft_and_a_weight_on_a_drum():
    """The teeth act on what a drive moves too: of a constant speed the weight alone."""
    s = fb.System("winch")
    one, two = s.body("one", fb.disk(1, R1)), s.body("two", fb.disk(2, R2))
    first = s.hinge("first", s.ground, one, coordinate=3 * s.t)
    second = s.hinge("second", s.ground, two, at=(0, R1 + R2, 0), coordinate="q")
    s.gear(second, first, -R1 / R2, name="mesh", pressure_angle="pi/9")
    s.torque("weight", second, F * R2)
    found = start(s)
    assert force(found, "first") == pytest.approx([-F, OUT, 0], rel=ALGEBRA)
    assert force(found, "second") == pytest.approx([F, -OUT, 0], rel=ALGEBRA)


def test_teeth_have_20_degrees_unless_another_angle_is_given():
    found = start(pair())
    assert force(found, "first") == pytest.approx([OUT, F, 0], rel=ALGEBRA)
    assert found.indeterminate == ()
    s = pair()
    assert "mesh_r = 10*abs(mesh)*tan(pi/9)" in fb.equations(s).free_body("one").text()
    with pytest.raises(ModelError, match="Expected an angle for the pressure angle of gear 'mesh', got None"):
        pair(pressure_angle=None)


def test_the_answer_to_a_question_has_the_radial_force():
    s = pair(pressure_angle="pi/9")
    e = fb.equations(s)
    tangent = e.solve("first_y")["first_y"]
    assert sympy.simplify(e.solve("first_x")["first_x"] - sympy.tan(sympy.pi / 9) * sympy.Abs(tangent)) == 0
    assert "mesh_r" in e.free_body("one").text().splitlines()[-1]
    with pytest.raises(ModelError, match="inside Abs\\(mesh\\)"):
        e.solve("p''", where={"first_x": 1})


def hinged(**options):
    return lambda s, body: s.hinge("other", s.ground, body, coordinate="q", **options)


def slid(**options):
    return lambda s, body: s.slider("other", s.ground, body, coordinate="q", **options)


PLANES = "the points of its joints are not in one plane across the ax"
BARE = {
    "the axes of its wheels cross at right angles, and the teeth have no helix_angle": (
        hinged(at=(1, 0, 0), axis="y"), -2
    ),
    "the points of its joints are not on the common perpendicular of its crossed axes": (
        hinged(at=(1, 1, 0), axis="y"), -2
    ),
    "its axes meet, but the points of its joints are not the centres of two pitch circles of this ratio that touch": (
        hinged(axis="y"), -2
    ),
    "its wheels have one axis": (hinged(), -2),
    f"{PLANES}es": (hinged(at=(1, 0, 1)), -2),
    "its wheels turn alike, and so have no pitch point": (hinged(at=(1, 0, 0)), 1),
    "'other' is a screw": (lambda s, body: s.screw("other", s.ground, body, pitch=0.1, coordinate="q"), 2),
    "its rack does not slide across the axis of its wheel": (slid(axis="z"), 2),
    f"{PLANES}is": (slid(at=(0, 0, 1), axis="x"), 2),
    "'first' and 'other' join no common body": (
        lambda s, body: s.hinge("other", s.bodies["third"], body, coordinate="q"), 2
    ),
}  # fmt: skip


@pytest.mark.parametrize("options", [{"at": (1, 0, 0.5)}, {"axis": "y"}])
def test_a_helix_angle_of_teeth_whose_place_is_not_known_is_refused(options):
    s = fb.System("helix")
    one, two = s.body("one", fb.disk(1, R1)), s.body("two", fb.disk(1, R1))
    first = s.hinge("first", s.ground, one, coordinate="p")
    second = s.hinge("second", s.ground, two, coordinate="q", **options)
    with pytest.raises(
        ModelError, match="Gear 'mesh' has a helix_angle, but where its teeth push is not known: "
    ):
        s.gear(first, second, -1, name="mesh", helix_angle=0.2)


def test_a_crown_wheel_has_no_hand():
    """i = n·m: the teeth of the first stand on a plane."""
    s = fb.System("crown")
    one, two = s.body("one", fb.disk(1, R1)), s.body("two", fb.disk(1, R1))
    first = s.hinge("first", s.ground, one, axis="x", coordinate="p")
    second = s.hinge("second", s.ground, two, at=(0.3, 0.4, 0), axis=(0.6, 0.8, 0), coordinate="q")
    assert s.gear(first, second, 0.6).mesh.apart is not None
    with pytest.raises(
        ModelError, match="a crown wheel, whose teeth have no hand; name the other joint first"
    ):
        s.gear(first, second, 0.6, name="spiral", helix_angle=0.2)


@pytest.mark.parametrize("why", BARE)
def test_a_ratio_alone_leaves_bearings_and_teeth_together(why):
    build, ratio = BARE[why]
    s = fb.System("ratio")
    one, third, two = (s.body(name, fb.disk(1, 1)) for name in ("one", "third", "two"))
    first = s.hinge("first", s.ground, one, coordinate="p")
    s.hinge("far", s.ground, third, coordinate="r")
    other = build(s, two)
    s.gear(first, other, ratio, name="mesh")
    e = fb.equations(s)
    assert e.model.meshes["mesh"] == why
    words = "how much of first the joint bears and how much the teeth of gear 'mesh', of which only the ratio is known"
    assert f"undetermined: {words}: {why}" in e.reactions["first"].text()
    assert why in e.free_body("one").text()
    assert {"first_x", "first_y", "first_z", "first_Mx", "first_My"} <= set(e.indeterminate())
    assert ("far_x" in e.indeterminate()) == (other.parent is third)
    assert "first_x" in start(s).indeterminate
    with pytest.raises(ModelError, match="only the ratio is known"):
        e.solve("first_x")
    assert "mesh" in e.solve("mesh")


def coupled(condition, **second):
    s = fb.System("coupled")
    one, two = s.body("one", fb.disk(1, R1)), s.body("two", fb.disk(1, R2))
    s.hinge("first", s.ground, one, coordinate="p")
    s.hinge("second", s.ground, two, at=(R1 + R2, 0, 0), coordinate="q")
    s.constrain(condition, name="chain")
    return s


def test_a_constraint_that_fixes_a_ratio_says_what_it_leaves_open():
    e = fb.equations(coupled("p = 2*q"))
    words = (
        "undetermined: how much of first the joint bears and how much the coupling by constraint 'chain', of which "
        "only the ratio is known: no point where it acts was described"
    )
    assert words in e.free_body("one").text()
    assert words in e.reactions["first"].text()
    assert words.replace("first", "second") in e.free_body("two").text()
    assert "no point where" in fb.free_body_diagram(coupled("p = 2*q"), "one").svg
    assert "first_x" in e.indeterminate()
    with pytest.raises(ModelError, match="The sum of both is in fb.equations"):
        e.solve("first_x")


@pytest.mark.parametrize("condition", ["p = 1/3", "sin(p) = q"])
def test_other_conditions_are_no_ratios(condition):
    """A lock acts in its own joint; a law that is not linear is a guide or a cam."""
    e = fb.equations(coupled(condition))
    assert "undetermined" not in e.free_body("one").text()


def test_sliders_share_no_pitch_point():
    s = fb.System("levers")
    one, two = s.body("one", fb.particle(1)), s.body("two", fb.particle(1))
    first = s.slider("first", s.ground, one, axis="x", coordinate="p")
    second = s.slider("second", s.ground, two, axis="y", coordinate="q")
    s.gear(first, second, 2)
    assert fb.assemble(s).meshes == {"gear_first_second": "'first' and 'second' are sliders"}


def test_an_impulse_passes_through_the_teeth():
    """Two equal wheels, a blow on the rim of one, along the centre line of neither."""
    s = fb.System("struck")
    one, two = s.body("one", fb.disk(1, R1)), s.body("two", fb.disk(1, R1))
    first = s.hinge("first", s.ground, one, coordinate="p")
    second = s.hinge("second", s.ground, two, at=(2 * R1, 0, 0), coordinate="q")
    s.gear(first, second, -1, name="mesh", pressure_angle="pi/9")
    for given in ({"values": {}}, {}):
        struck = fb.impulse(s, at=one.point(0, R1, 0), impulse=(1, 0, 0), **given)
        found = struck.reactions["second"].components
        # half of the moment impulse goes to the other wheel, r/2; exact ones are those of any place
        values = [
            float(sympy.sympify(found[f"second_{c}"]).subs(one.system.expression("p"), 0)) for c in "xy"
        ]
        assert values == pytest.approx([-math.tan(ANGLE) / 2, 1 / 2], rel=ALGEBRA)


def test_a_centre_of_percussion_of_what_is_not_linear_is_refused():
    with pytest.raises(ModelError, match="A centre of percussion is not offered with gear 'mesh'"):
        fb.centre_of_percussion(pair(), "first", along=(0, 1, 0))


def test_drawings_of_a_motion_hold_the_radial_force():
    s = pair(pressure_angle="pi/9")
    svg = fb.free_body_diagram(s, "one", trajectory=start(s), at=0).svg
    assert svg.count('class="force"') == 4


def test_the_command_says_what_a_ratio_leaves_open(tmp_path):
    def coaxial():
        s = fb.System("coaxial")
        one, two = s.body("one", fb.disk(1, R1)), s.body("two", fb.disk(2, R2))
        first = s.hinge("first", s.ground, one, coordinate="p")
        s.gear(first, s.hinge("second", s.ground, two, coordinate="q"), 2, name="mesh")
        return s

    for build, said in ((coaxial, True), (pair, False)):
        path = tmp_path / "pair.toml"
        fb.write(build(), path)
        found = CliRunner().invoke(command, ["run", str(path), "--until", "0.1"])
        assert found.exit_code == 0, found.output
        assert ("Statically indeterminate: first_x, first_y" in found.output) is said
