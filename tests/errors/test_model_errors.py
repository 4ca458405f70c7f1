"""The text of every refusal of a description, of its assembly and of its equations.

Each says what was expected, what came and the cure, in the user's own names: the words asserted are those.
"""

# ruff: noqa: E501 (tables: one case, one line)

from __future__ import annotations

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.describe.description import coordinates_of, names_of
from freebody.dynamics import float_state
from freebody.errors import ExpressionError, FreebodyError, ModelError, nearest


@pytest.fixture
def s():
    """A cart on rails and a bar, not yet joined; theta and q are coordinates of nothing yet."""
    system = fb.System("crane")
    system.parameters("mass", length=2.0, k=3.0)
    system.coordinates("theta q")
    system.body("cart", fb.particle(2))
    system.body("bar", fb.slender_bar(1, 2))
    return system


def hinge(s, name="pin", **given):
    return s.hinge(name, s.bodies["cart"], s.bodies["bar"], **given)


def rail(s, **given):
    return s.slider("rail", s.ground, s.bodies["cart"], **given)


def other(name="other crane"):
    """A body of another system."""
    system = fb.System(name)
    return system.body("bar", fb.slender_bar(1, 2))


def other_joint():
    bar = other()
    return bar.system.hinge("pin", bar.system.ground, bar)


REFUSALS = {
    # --- names ---
    "system without a name": (lambda s: fb.System(" "), "Expected a name (text) for the system, got ' '"),
    "system named by a number": (lambda s: fb.System(5), "Expected a name (text) for the system, got 5"),
    "body named by a number": (lambda s: s.body(5, fb.particle(1)), "name (text) for the body, got 5", "in quotes"),
    "body named with a blank": (
        lambda s: s.body("big bar", fb.particle(1)), "'big bar' cannot be the name of a body", "letters, digits"),
    "joint named by a keyword": (lambda s: hinge(s, "lambda"), "'lambda' cannot be the name of a joint", "Python's keywords"),
    "joint named with accents": (lambda s: hinge(s, "é"), "'é' cannot be the name of a joint"),
    "parameter with a dash": (lambda s: s.parameters("a-b"), "'a-b' cannot be the name of a parameter"),
    "parameter twice": (lambda s: s.parameters(k=1), "'k' is taken", "already a parameter", "Choose another name"),
    "parameter twice in one call": (lambda s: s.parameters("a a"), "'a' is taken"),
    "parameter named as a coordinate": (lambda s: s.parameters(theta=1), "'theta' is taken", "already a coordinate"),
    "parameter named t": (lambda s: s.parameters(t=1), "'t' is taken", "already a time"),
    "coordinate twice": (lambda s: s.coordinates("theta"), "'theta' is taken", "already a coordinate"),
    "body twice": (lambda s: s.body("bar", fb.particle(1)), "already a body 'bar'", "Choose another name"),
    "body named ground": (lambda s: s.body("ground", fb.particle(1)), "already a body 'ground'"),
    "joint twice": (lambda s: [hinge(s), hinge(s)], "already a joint 'pin'", "Choose another name"),
    "ball twice": (lambda s: [s.ball("b", s.ground, s.bodies["bar"]), s.ball("b", s.ground, s.bodies["cart"])],
                   "already a joint 'b'", "Choose another name"),
    "prefix twice": (
        lambda s: [s.ball("b", s.ground, s.bodies["bar"]), s.ball("c", s.ground, s.bodies["cart"], coordinate="b")],
        "'b_e0' is taken", "already a coordinate"),
    "load twice": (
        lambda s: [s.force("F", s.bodies["bar"], (1, 0, 0)), s.torque("F", s.bodies["bar"], (1, 0, 0))],
        "already a load 'F'"),
    "no parameter": (lambda s: s.parameters(), "Expected at least one parameter, such as parameters(m=1.0)"),
    "no coordinate": (lambda s: s.coordinates(""), "Expected at least one coordinate name"),
    # --- expressions ---
    "unknown name in text": (
        lambda s: hinge(s, coordinate="2*thetta"), "coordinate of joint 'pin'", "'thetta'", "did you mean 'theta'?"),
    "unknown symbol": (
        lambda s: s.force("F", s.bodies["bar"], (sympy.Symbol("lenght"), 0, 0)),
        "In force 'F'", "unknown symbol 'lenght'", "did you mean 'length'?"),
    "unknown function of time": (
        lambda s: s.force("F", s.bodies["bar"], (sympy.Function("thet")(s.t), 0, 0)),
        "unknown symbol 'thet'", "did you mean 'theta'?"),
    "unknown, nothing near": (
        lambda s: s.spring("s", rail(s), stiffness="zzz"), "'zzz'", "known names:", "theta"),
    "foreign symbol of the same name": (
        lambda s: s.spring("s", rail(s), stiffness=sympy.Symbol("k")),
        "stiffness of spring 's'", "'k' has the name of a parameter", "another SymPy object", "the text 'k'"),
    "foreign coordinate of the same name": (
        lambda s: hinge(s, coordinate=sympy.Symbol("theta", real=True)), "has the name of a coordinate"),
    "acceleration": (
        lambda s: s.force("F", s.bodies["bar"], (s.expression("q").diff(s.t, 2), 0, 0)),
        "the acceleration", "coordinates, speeds, time and parameters"),
    "complex number": (lambda s: s.force("F", s.bodies["bar"], (1j, 0, 0)), "expected a real expression"),
    "infinity of SymPy": (lambda s: s.force("F", s.bodies["bar"], (-sympy.oo, 0, 0)), "expected a real expression"),
    "infinity": (lambda s: s.force("F", s.bodies["bar"], (float("inf"), 0, 0)), "force 'F'", "finite number, got inf"),
    "not a number": (lambda s: s.force("F", s.bodies["bar"], (float("nan"), 0, 0)), "finite number, got nan"),
    "a condition": (lambda s: s.force("F", s.bodies["bar"], (s.t > 0, 0, 0)), "expected a real expression"),
    "a list": (lambda s: s.force("F", s.bodies["bar"], ([1], 0, 0)), "number, a SymPy expression or text, got [1]"),
    "true": (lambda s: s.force("F", s.bodies["bar"], (True, 0, 0)), "Expected a number or an expression, got True"),
    "text that is no expression": (lambda s: s.force("F", s.bodies["bar"], ("k*(1", 0, 0)), "In force 'F'", "k*(1"),
    "default that is no number": (
        lambda s: s.parameters(a="k/2"), "default value of parameter 'a' must be a number, got 'k/2'", "where they are used"),
    "default beyond floats": (lambda s: s.parameters(a=10**400), "finite number for the default of parameter 'a'"),
    "default that is nothing": (lambda s: s.parameters(a=None), "default of parameter 'a'", "got None"),
    # --- vectors and axes ---
    "two components": (
        lambda s: hinge(s, at=(1, 0)), "three components (x, y, z) for at= of hinge 'pin', got 2", "Add the third"),
    "four components": (lambda s: s.bodies["bar"].point(1, 2, 3, 4), "the point of body 'bar', got 4"),
    "no components": (lambda s: s.bodies["bar"].point(5), "three components (x, y, z) for the point of body 'bar', got 5"),
    "gravity as a number": (lambda s: setattr(s, "gravity", 9.81), "three components (x, y, z) for gravity, got 9.81"),
    "gravity as text": (lambda s: setattr(s, "gravity", "down"), "for gravity, got 'down'"),
    "gravity that varies": (
        lambda s: setattr(s, "gravity", (0, "-theta", 0)), "Gravity must be constant", "depends on theta", "as forces"),
    "axis by a wrong letter": (lambda s: hinge(s, axis="w"), "'x', 'y', 'z' or three components for the axis of hinge 'pin'"),
    "axis with two signs": (lambda s: hinge(s, axis="--z"), "got '--z'"),
    "axis of length zero": (
        lambda s: hinge(s, axis=(0, 0, 0)), "axis of hinge 'pin' has length zero", "Give a direction, such as (0, 0, 1)"),
    "axis of two components": (lambda s: rail(s, axis=(1, 0)), "for the axis of slider 'rail', got 2"),
    "axis that moves": (lambda s: hinge(s, axis=(1, "theta", 0)), "cannot depend on theta", "axis of hinge 'pin'"),
    "axes of a wrong shape": (
        lambda s: hinge(s, parent_axes=[1, 2, 3]), "Rotation or a 3 x 3 rotation matrix for parent_axes= of hinge 'pin'"),
    "axes as text": (lambda s: hinge(s, child_axes="ZXZ"), "3 x 3 rotation matrix for child_axes="),
    "axes not orthonormal": (
        lambda s: hinge(s, parent_axes=[[1, 0, 0], [0, 2, 0], [0, 0, 1]]), "orthonormal to 3 only", "determinant is 2"),
    "axes reflected": (
        lambda s: hinge(s, parent_axes=[[1, 0, 0], [0, 1, 0], [0, 0, -1]]), "its determinant is -1, not 1"),
    "axes of symbols not orthonormal": (
        lambda s: hinge(s, parent_axes=[["cos(k)", "sin(k)", 0], ["sin(k)", "cos(k)", 0], [0, 0, 1]]),
        "Expected a rotation matrix for parent_axes="),
    "axes that move": (
        lambda s: hinge(s, parent_axes=[["cos(theta)", "-sin(theta)", 0], ["sin(theta)", "cos(theta)", 0], [0, 0, 1]]),
        "fixed in the bodies cannot depend on theta", "a joint's coordinate"),
    # --- bodies and points ---
    "body without mass properties": (
        lambda s: s.body("block", 5), "Expected mass properties for body 'block'", "fb.sphere(m, R)", "got 5"),
    "body whose mass varies": (
        lambda s: s.body("tank", fb.particle(s.expression("theta"))), "'tank' is rigid", "depend on theta", "body of its own"),
    "body of unknown symbols": (
        lambda s: s.body("tank", fb.particle(sympy.Symbol("mas", real=True))),
        "mass properties of body 'tank'", "unknown symbol 'mas'", "did you mean 'mass'?"),
    "point that moves": (
        lambda s: s.bodies["bar"].point(0, "theta", 0), "fixed in it and cannot depend on theta", "a body of its own"),
    "point of a joint that moves": (
        lambda s: hinge(s, at=(0, "theta", 0)), "at= of hinge 'pin'", "fixed in body 'cart'", "cannot depend on theta"),
    "point of the other body": (
        lambda s: hinge(s, at=s.bodies["bar"].point(0, 1, 0)), "a point of body 'cart' for at= of hinge 'pin'", "of bar"),
    "body by an unknown name": (
        lambda s: s.hinge("pin", "ground", "barr"), "Unknown body 'barr' in hinge 'pin'", "did you mean 'bar'?"),
    "body that is none": (lambda s: s.hinge("pin", s.ground, 7), "Expected a body for hinge 'pin', got 7"),
    "force on no point": (
        lambda s: s.force("F", (0, 1, 0), (1, 0, 0)), "Expected a point, such as bar.point(0, 1, 0), for force 'F'"),
    # --- across systems ---
    "joint across systems": (
        lambda s: s.hinge("pin", s.bodies["cart"], other()),
        "Hinge 'pin'", "body 'bar' belongs to the system 'other crane'", "not to 'crane'", "bodies of one system"),
    "joint across systems of one name": (
        lambda s: s.hinge("pin", s.bodies["cart"], other(s.name)), "belongs to the system of the same name, 'crane'"),
    "name not first": (lambda s: s.hinge(s.ground, s.bodies["bar"], "pin"), "Expected a name (text) for the joint, got the ground. It comes first"),
    "joint to the ground of another system": (
        lambda s: s.hinge("pin", other().system.ground, s.bodies["cart"]), "'ground' belongs to the system 'other crane'"),
    "force on a body of another system": (
        lambda s: s.force("F", other().point(0, 0, 1), (1, 0, 0)), "Force 'F'", "belongs to the system 'other crane'"),
    "frame of another system": (
        lambda s: s.force("F", s.bodies["bar"], (1, 0, 0), frame=other()), "belongs to the system 'other crane'"),
    "spring on a joint of another system": (
        lambda s: s.spring("s", other_joint(), stiffness=1), "joint 'pin' belongs to another system than 'crane'", "Name a joint"),
    # --- joints ---
    "joint of a body to itself": (
        lambda s: s.hinge("pin", s.bodies["bar"], s.bodies["bar"]), "Hinge 'pin' joins body 'bar' to itself", "two different"),
    "coordinate in use": (
        lambda s: [rail(s, coordinate="theta"), hinge(s, coordinate="theta")],
        "'theta' is already the displacement of another joint", "joint 'pin'", "pass the expression"),
    "displacement with a speed": (
        lambda s: hinge(s, coordinate="theta + q'"), "coordinates, parameters and time, not on q'"),
    "displacement by a quaternion": (
        lambda s: [s.ball("b", s.ground, s.bodies["cart"]), hinge(s, coordinate="b_e1")],
        "b_e1 is a component of a ball or free joint", "Use a gimbal"),
    "two coordinates for a hinge": (lambda s: hinge(s, coordinate="a b"), "Expected 1 coordinate for joint 'pin', got 2: a, b"),
    "one coordinate for a planar joint": (
        lambda s: s.planar("p", s.ground, s.bodies["cart"], coordinate="x"), "Expected 3 coordinates for joint 'p', got 1: x"),
    "planar joint along an oblique axis": (
        lambda s: s.planar("p", s.ground, s.bodies["cart"], axis=(0, 1, 1)), "'x', 'y' or 'z' for the normal", "parent_axes"),
    "universal joint with one axis": (
        lambda s: s.universal("u", s.ground, s.bodies["cart"], axis="x"), "Expected two axes, such as ('x', 'y')", "'u'"),
    "universal joint with parallel axes": (
        lambda s: s.universal("u", s.ground, s.bodies["cart"], axis=("x", (-2, 0, 0))), "'u' are parallel", "make a hinge"),
    "gimbal in lower case": (
        lambda s: s.gimbal("g", s.ground, s.bodies["cart"], axis="xyz"),
        "lower case 'xyz' means space-fixed", "in capitals", "'ZYX' with the angles in reverse order"),
    "gimbal of two axes": (
        lambda s: s.gimbal("g", s.ground, s.bodies["cart"], axis="XY"), "sequence of three axes, such as 'ZXZ'", "got 'XY'"),
    "gimbal of equal neighbours": (
        lambda s: s.gimbal("g", s.ground, s.bodies["cart"], axis="XXZ"), "'XXZ' is not an Euler sequence", "neighbours different"),
    "screw with a pitch that varies": (
        lambda s: s.screw("w", s.ground, s.bodies["cart"], pitch="theta"), "pitch of screw 'w' must be constant", "theta"),
    "ball with an expression": (
        lambda s: s.ball("b", s.ground, s.bodies["cart"], coordinate=s.expression("theta")), "Expected a prefix (text)"),
    # --- loads ---
    "spring that varies": (
        lambda s: s.spring("s", rail(s), stiffness="k*theta"), "The stiffness of spring 's' must be constant",
        "depends on theta", "as a force or a generalized force"),
    "rest length that varies": (
        lambda s: s.spring("s", rail(s), stiffness=1, rest="t"), "The rest length of spring 's' must be constant", "depends on t"),
    "damper that varies": (
        lambda s: s.damper("d", rail(s), damping="theta'"), "The damping of damper 'd' must be constant", "depends on theta'"),
    "spring with one end": (
        lambda s: s.spring("s", s.bodies["bar"].point(0, 0, 0), stiffness=1), "two points for spring 's'", "(to=) is missing"),
    "spring on one body": (
        lambda s: s.spring("s", s.bodies["bar"].point(0, 0, 0), s.bodies["bar"].point(1, 0, 0), stiffness=1),
        "Both ends of spring 's' are on 'bar'", "Put one end on another body"),
    "spring on a ball joint": (
        lambda s: s.spring("s", s.ball("b", s.ground, s.bodies["bar"]), stiffness=1),
        "Ball 'b' has no single displacement for spring 's'", "between two points, or by a torque", "s.torsion_spring and s.damper", "s.bushing"),
    "damper on a weld": (
        lambda s: s.damper("d", s.weld("w", s.ground, s.bodies["bar"]), damping=1), "Weld 'w' has no single displacement"),
    "spring on a displacement that is not there": (
        lambda s: s.spring("s", rail(s), stiffness=1, coordinate=1), "Joint 'rail' has 1 displacements (0 to 0), got 1"),
    "torsion spring on a body": (
        lambda s: s.torsion_spring("s", s.bodies["bar"], stiffness=1), "Expected a joint with an angle for torsion spring 's'"),
    "torsion spring on a slider": (
        lambda s: s.torsion_spring("s", rail(s), stiffness=1), "slider 'rail' has no angle", "made by s.spring"),
    "torsion spring on the slide of a planar joint": (
        lambda s: s.torsion_spring("s", s.planar("p", s.ground, s.bodies["bar"]), stiffness=1, coordinate=0),
        "Displacement 0 of planar 'p' is not an angle", "angles: [2]"),
    "motor force along a hinge": (
        lambda s: s.force("F", hinge(s), 1), "Force 'F' acts along a slider, but 'pin' is a hinge", "s.generalized_force"),
    "motor force along a screw": (
        lambda s: s.force("F", s.screw("w", s.ground, s.bodies["bar"], pitch=1), 1), "acts along a slider, but 'w' is a screw"),
    "motor moment along a slider": (
        lambda s: s.torque("T", rail(s), 1), "Torque 'T' acts along a hinge or a screw, but 'rail' is a slider"),
    "motor of three components": (
        lambda s: s.torque("T", hinge(s), (0, 0, 1)), "Expected one expression for torque 'T' on joint 'pin', got (0, 0, 1)"),
    "force on the ground": (
        lambda s: s.force("F", s.ground.point(1, 0, 0), (1, 0, 0)), "Force 'F' acts on the ground, which nothing moves",
        "Name a point of a body"),
    "torque on the ground": (
        lambda s: s.torque("T", s.ground, (0, 0, 1)), "Torque 'T' acts on the ground, which nothing moves", "reaction_on"),
    "torque and its opposite on one body": (
        lambda s: s.torque("T", s.bodies["bar"], (0, 0, 1), reaction_on=s.bodies["bar"]),
        "Torque 'T' acts on 'bar' and so does its opposite"),
    "force of two components": (lambda s: s.force("F", s.bodies["bar"], (1, 2)), "for force 'F', got 2", "Add the third"),
    "generalized force on an unknown coordinate": (
        lambda s: s.generalized_force("thetta", 1), "Unknown coordinate 'thetta'", "did you mean 'theta'?"),
    "generalized force on a parameter": (
        lambda s: s.generalized_force(s.parameters(a=1), 1), "Expected a coordinate of this system, got 'a'", "ball and free"),
    "description of an expression": (
        lambda s: s.describe("2*k"), "Expected a parameter or a coordinate to describe, got '2*k'"),
    "assumption that cannot hold": (lambda s: s.assume("1 > 2"), "Expected a condition that can hold, got '1 > 2'."),
    "assumption that is no condition": (lambda s: s.assume("k"), "Expected a condition such as k > 0, got 'k'"),
    "assumption with equality": (
        lambda s: s.assume(s.expression("k") >= 0), "Expected a condition such as k > 0, got k >= 0"),
    "assumption on an unknown symbol": (
        lambda s: s.assume(sympy.Symbol("kk") > 0), "the condition kk > 0", "unknown symbol 'kk'", "did you mean 'k'?"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSALS)
def test_a_description_is_refused_in_the_users_words(s, case):
    action, *words = REFUSALS[case]
    with pytest.raises((ModelError, ExpressionError)) as caught:
        action(s)
    message = str(caught.value)
    for word in words:
        assert word in message
    assert isinstance(caught.value, FreebodyError)


@pytest.mark.parametrize("case", REFUSALS)
def test_a_refused_description_changes_nothing_but_what_was_made_before(s, case):
    """The last call leaves no body, joint, load or name behind."""
    action, *_ = REFUSALS[case]

    def content():
        return [
            list(table)
            for table in (
                s.bodies,
                s.joints,
                s.loads,
                coordinates_of(s),
                names_of(s).kinds,
                names_of(s).atoms,
            )
        ]

    with pytest.raises(FreebodyError):
        action(s)
    first = content()
    with pytest.raises(FreebodyError):
        action(s)
    # what comes before the refused call in an action (a rail, a pin) is made once; a second time it is refused
    assert content() == first


def test_what_is_refused_can_be_said_again_rightly(s):
    bar = s.bodies["bar"]
    with pytest.raises(ModelError):
        s.free("air", s.ground, bar, at=(1, 2))
    with pytest.raises(ModelError):
        s.hinge("pin", s.ground, 5, coordinate="alpha")
    with pytest.raises(ModelError):
        s.parameters("b k")
    s.free("air", s.ground, bar, at=(1, 2, 3))
    s.hinge("pin", s.ground, s.bodies["cart"], coordinate="alpha")
    s.parameters("b")
    assert list(coordinates_of(s)) == ["theta", "q", "alpha"]


# --- assemble -------------------------------------------------------------------------------------


def two_bars():
    s = fb.System("mechanism")
    return s, s.body("crank", fb.slender_bar(1, 2)), s.body("rod", fb.slender_bar(1, 2))


def refused(s, *words):
    with pytest.raises(ModelError) as caught:
        fb.assemble(s)
    for word in words:
        assert word in str(caught.value)


def test_assemble_of_something_else():
    refused("crane", "Expected a System, got 'crane'", "s = fb.System('name')")


def test_a_system_without_bodies():
    refused(fb.System("empty"), "System 'empty' has no body", "s.body('name'")


def test_a_body_that_hangs_on_nothing():
    s, crank, _ = two_bars()
    s.hinge("pin", s.ground, crank)
    refused(s, "Body 'rod' hangs on nothing", "child of no joint", "s.free('air', s.ground, rod)")


def test_a_body_that_is_only_a_parent():
    s, crank, rod = two_bars()
    s.hinge("pin", crank, rod)
    refused(s, "Body 'crank' hangs on nothing", "only the parent of joint 'pin'", "exchange parent and child")


def test_a_ring_of_bodies():
    s, crank, rod = two_bars()
    s.hinge("there", crank, rod)
    s.hinge("back", rod, crank)
    refused(
        s,
        "Bodies",
        "crank",
        "rod",
        "hang on each other and not on the ground",
        "Join one of them to the ground",
    )


def test_the_ground_as_a_child():
    s, crank, _ = two_bars()
    s.hinge("pin", crank, s.ground)
    refused(s, "'crank' hangs on nothing", "only the parent of joint 'pin'", "exchange parent and child")


def test_a_loop():
    s, crank, rod = two_bars()
    s.hinge("a", s.ground, crank)
    s.hinge("b", crank, rod)
    s.hinge("c", s.ground, rod, at=(3, 0, 0))
    assert list(fb.assemble(s).constraints) == ["c"]
    with pytest.raises(
        ModelError, match="Joint 'd' closes a loop, since 'rod' is already held.*Leave out coordinate="
    ):
        s.hinge("d", s.ground, rod, coordinate="extra")
    with pytest.raises(
        ModelError,
        match="Free joint 'd' has no effect, since another joint already holds 'rod'. Leave it out",
    ):
        s.free("d", s.ground, rod)
    s.screw("e", s.ground, rod, pitch=1)
    assert list(fb.assemble(s).constraints) == ["c", "e"]


def test_an_undetermined_coordinate():
    s, crank, rod = two_bars()
    s.coordinates("alpha")
    s.hinge("a", s.ground, crank)
    s.hinge("b", crank, rod)
    refused(
        s,
        "Coordinate 'alpha' is undetermined",
        "displacement of no joint",
        "Use it in a coordinate=, or do not declare it",
    )


def test_a_massless_moving_tip():
    s, crank, _ = two_bars()
    tip = s.body("tip", fb.MassProperties(0, (0, 0, 0), ((0, 0, 0),) * 3))
    s.hinge("a", s.ground, crank)
    s.weld("w", crank, s.bodies["rod"])
    s.hinge("b", crank, tip)
    refused(
        s,
        "Body 'tip' is a moving tip without mass",
        "joint 'b' would accelerate it",
        "Give it mass, weld it, leave it out, or let it follow bodies with mass",
    )


def test_a_massless_tip_that_does_not_move_or_is_driven_is_welcome():
    s, crank, rod = two_bars()
    s.hinge("a", s.ground, crank)
    s.weld("w", crank, rod)
    for name, coordinate in (("eye", None), ("pointer", 3 * s.t)):
        tip = s.body(name, fb.MassProperties(0, (0, 0, 0), ((0, 0, 0),) * 3))
        if coordinate is None:
            s.weld(name, rod, tip)
        else:
            s.hinge(name, rod, tip, coordinate=coordinate)
    assert fb.assemble(s).n_u == 1


# --- values and states ----------------------------------------------------------------------------


@pytest.fixture
def model(s):
    rail(s, coordinate="q")
    hinge(s, coordinate="theta")
    return fb.assemble(s)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"lenght": 1}, ["Unknown parameter 'lenght'", "did you mean 'length'?"]),
        ({}, ["No value for parameter mass", "s.parameters", "values={'mass': ...}"]),
        ({"mass": "k"}, ["Expected a number for parameter 'mass', such as", "got 'k'"]),
        ({"mass": 10**400}, ["Expected a finite number for the value of parameter 'mass'"]),
        ({"mass": float("nan")}, ["value of parameter 'mass'", "finite number, got nan"]),
        ({"mass": "2*massive"}, ["Expected a number for parameter 'mass'", "got '2*massive'"]),
    ],
)
def test_values_of_parameters(model, given, words):
    with pytest.raises((ModelError, ExpressionError)) as caught:
        model.values(given)
    for word in words:
        assert word in str(caught.value)


def test_values_are_given_by_name_or_symbol(model):
    length = model.names.atoms["length"]
    assert model.values({"mass": "3/2", length: 4}) == {"mass": 1.5, "length": 4.0, "k": 3.0}


def test_a_state_of_the_wrong_size(model):
    with pytest.raises(ModelError, match=r"Expected 2 coordinates .*'theta', 'q'.* got 1 and 0"):
        float_state(model, [1], [], values={"mass": 1})


# --- equations ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (lambda eq: eq.free_body("barr"), ["Unknown body 'barr'", "did you mean 'bar'?"]),
        (lambda eq: eq.free_body(5), ["Expected a body for a free body, got 5"]),
        (
            lambda eq: eq.free_body(other()),
            ["'bar'", "belongs to the system 'other crane'", "Name a body of 'crane'"],
        ),
        (lambda eq: eq.free_body("bar", frame="carts"), ["Unknown frame 'carts'", "did you mean 'cart'?"]),
        (
            lambda eq: eq.free_body("bar", frame=other()),
            ["given for a frame", "belongs to the system 'other crane'"],
        ),
        (lambda eq: eq.free_body("bar", frame=3), ["Expected a body for a frame, got 3"]),
        (
            lambda eq: eq.free_body("bar", about=(0, 1, 0)),
            ["Expected a point, such as bar.point(0, 1, 0)", "(0, 1, 0)"],
        ),
        (
            lambda eq: eq.free_body("bar", about=other().point(0, 0, 1)),
            ["belongs to the system 'other crane'"],
        ),
        (lambda eq: eq.reactions["pni"], ["Unknown joint 'pni'", "did you mean 'pin'?"]),
        (lambda eq: eq.momentum.angular("C"), ["Expected a point or three components", "got 'C'"]),
        (lambda eq: eq.momentum.angular((1, 2)), ["Expected a point or three components", "(1, 2)"]),
        (
            lambda eq: eq.momentum.angular(("lenght", 0, 0)),
            ["point of angular momentum", "did you mean 'length'?"],
        ),
        (lambda eq: eq.momentum.angular(other()), ["belongs to the system 'other crane'"]),
    ],
)
def test_equations_of_what_is_not_there(model, action, words):
    with pytest.raises((ModelError, ExpressionError)) as caught:
        action(fb.equations(model))
    for word in words:
        assert word in str(caught.value)


# --- the tail of a message ------------------------------------------------------------------------


def test_nearest_name():
    assert nearest("thetta", ["theta", "x"]) == "did you mean 'theta'?"
    assert nearest("zzz", ["b", "a"]) == "known names: a, b."
    assert nearest("zzz", []) == "no names are known yet."


def test_numbers_of_numpy_are_welcome(s):
    s.force("F", s.bodies["bar"], np.array([1.5, 0, np.float32(2)]))
    assert s.loads["F"].components == (sympy.Rational(3, 2), 0, 2)
