"""What constraints refuse: every message says what was expected, what came, and the cure."""

from __future__ import annotations

import pytest

import freebody as fb
from freebody.errors import ExpressionError, ModelError, SimulationError


def plane():
    s = fb.System("plane")
    s.parameters(L=2.0)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.planar("p", s.ground, ball, coordinate="x y f")
    return s, ball


def geared():
    s = fb.System("geared")
    a, b = s.body("a", fb.disk(1, 1)), s.body("b", fb.disk(1, 1))
    first = s.hinge("first", s.ground, a, coordinate="p")
    second = s.hinge("second", s.ground, b, at=(2, 0, 0), coordinate="q")
    return s, first, second


def refused(call, message, error=ModelError):
    with pytest.raises(error) as caught:
        call()
    assert message in str(caught.value), str(caught.value)


# -- conditions -------------------------------------------------------------------------------------------------


def test_condition_with_speeds():
    s, _ = plane()
    refused(
        lambda: s.constrain("x' - y", name="rail"),
        "Constraint 'rail' depends on x'. Use s.constrain_speed for a condition on speeds.",
    )
    assert s.constraints == {}


def test_condition_without_coordinates():
    s, _ = plane()
    refused(
        lambda: s.constrain("L - t", name="rail"),
        "Constraint 'rail' contains no coordinate: 'L - t' does not restrict the motion.",
    )


def test_speed_condition_without_speeds():
    s, _ = plane()
    refused(
        lambda: s.constrain_speed("x - L", name="edge"),
        "Speed constraint 'edge' contains no speed: '-L + x'. Use s.constrain for a condition on coordinates.",
    )


@pytest.mark.parametrize("condition", ["x'^2 - 1", "x'*y'", "sin(x') + y'"])
def test_speed_condition_that_is_not_linear(condition):
    s, _ = plane()
    refused(
        lambda: s.constrain_speed(condition, name="edge"),
        "Speed constraint 'edge' must be linear in the speeds, but '",
    )


def test_speed_condition_names_the_speed_it_is_not_linear_in():
    s, _ = plane()
    refused(lambda: s.constrain_speed("x' + y'^3", name="edge"), "is not linear in y'.")


def test_unknown_name_in_a_condition():
    s, _ = plane()
    refused(
        lambda: s.constrain("z - L", name="rail"),
        "In constraint 'rail': Expected a known name, got 'z'",
        ExpressionError,
    )


def test_names_are_used_once():
    s, ball = plane()
    s.constrain("y", name="rail")
    refused(lambda: s.constrain("x", name="rail"), "There is already a constraint 'rail' in this system.")
    refused(lambda: s.constrain("x", name="p"), "There is already a joint 'p' in this system.")
    refused(lambda: s.weld("rail", s.ground, ball), "There is already a constraint 'rail' in this system.")
    refused(lambda: s.constrain("x", name="2b"), "'2b' cannot be the name of a constraint")


# -- gears ------------------------------------------------------------------------------------------------------


def test_gear_of_what_is_no_joint():
    s, first, _ = geared()
    refused(
        lambda: s.gear(first, "second", 2), "Expected two joints of this system for a gear, got 'second'."
    )
    other, foreign, _ = geared()
    refused(
        lambda: s.gear(first, foreign, 2), "Expected two joints of this system for a gear, got hinge 'first'"
    )
    assert other.constraints == {}


def test_gear_of_a_joint_with_several_displacements():
    s, first, _ = geared()
    free = s.ball("ball", s.ground, s.body("c", fb.sphere(1, 1)))
    refused(
        lambda: s.gear(first, free, 2),
        "A gear couples joints with one displacement, but 'ball' is a ball. Use s.constrain on its coordinates.",
    )


def test_gear_of_a_joint_that_closes_a_loop():
    s, first, _ = geared()
    closing = s.hinge("third", s.bodies["a"], s.bodies["b"])
    refused(
        lambda: s.gear(first, closing, 2),
        "A gear couples joints that have coordinates, but 'third' closes a loop. Declare it before the joint",
    )


def test_gear_of_a_joint_with_itself():
    s, first, _ = geared()
    refused(lambda: s.gear(first, first, 2), "A gear couples two joints, got 'first' twice.")


def test_ratio_that_moves():
    s, first, second = geared()
    refused(
        lambda: s.gear(first, second, "1 + p", name="cam"),
        "The ratio of gear 'cam' cannot depend on p. Write the condition out with s.constrain.",
    )
    assert s.constraints == {}


@pytest.mark.parametrize("ratio", [0, "0", "q - q", 0.0])
def test_a_gear_of_ratio_zero(ratio):
    s, first, second = geared()
    refused(
        lambda: s.gear(first, second, ratio, name="stop"),
        "The ratio of gear 'stop' is 0: 'first' would stand still and 'second' move freely. Give another ratio, "
        "or hold 'first' by s.constrain('p').",
    )
    assert s.constraints == {}


@pytest.mark.parametrize("angle", [0, -0.3, "pi/2", 20])
def test_a_pressure_angle_that_no_teeth_have(angle):
    s, first, second = geared()
    refused(
        lambda: s.gear(first, second, -2, name="mesh", pressure_angle=angle),
        "Expected the pressure angle of gear 'mesh' between 0 and pi/2 rad (90 degrees), got",
    )


def test_a_pressure_angle_that_is_no_constant_or_gets_such_a_value():
    s, first, second = geared()
    refused(
        lambda: s.gear(first, second, -2, name="mesh", pressure_angle="p"),
        "The pressure angle of gear 'mesh' cannot depend on p.",
    )
    alpha = s.parameters(alpha=0.3)
    s.gear(first, second, -2, name="mesh", pressure_angle=alpha)
    fb.simulate(s, 0.1, values={"alpha": "25 deg"})
    for value in ("100 deg", -0.1):
        refused(lambda value=value: fb.simulate(s, 0.1, values={"alpha": value}), "Expected ")


# -- ropes ------------------------------------------------------------------------------------------------------


def test_rope_with_one_point():
    s, ball = plane()
    refused(lambda: s.rope([ball.origin], 2), "Rope 'rope' needs at least two points, got 1.")


def test_rope_that_holds_nothing():
    s, _ = plane()
    refused(
        lambda: s.rope([s.ground.origin, s.ground.point(1, 0, 0)], 2, name="line"),
        "All points of rope 'line' are on the ground, so it holds nothing.",
    )


def test_rope_over_what_is_no_point():
    s, ball = plane()
    refused(
        lambda: s.rope([(0, 0, 0), ball.origin], 2),
        "Expected a point, such as bar.point(0, 1, 0), for rope 'rope'",
    )


def test_rope_of_a_length_that_follows_the_motion():
    s, ball = plane()
    refused(
        lambda: s.rope([s.ground.origin, ball.origin], "L - f", name="line"),
        "The length of rope 'line' cannot depend on f. Write the condition out with s.constrain.",
    )


# -- rolling ----------------------------------------------------------------------------------------------------


def test_the_ground_does_not_roll():
    s, _ = plane()
    refused(
        lambda: s.rolling("c", s.ground, radius=1),
        "The wheel of rolling 'c' is the ground. Name the body that rolls.",
    )


def test_the_plane_is_fixed():
    s, ball = plane()
    other = s.body("other", fb.sphere(1, 1))
    s.free("air", s.ground, other)
    refused(
        lambda: s.rolling("c", ball, radius=1, plane=other.origin),
        "The plane of rolling 'c' must be fixed in the ground, got a",
    )


@pytest.mark.parametrize("normal", ["q", "-q", "up", (0, 0, 1)])
def test_normal_of_the_plane(normal):
    s, ball = plane()
    refused(
        lambda: s.rolling("c", ball, radius=1, normal=normal),
        f"Expected 'x', 'y' or 'z', with or without a minus, for the normal of rolling 'c', got {normal!r}.",
    )


def test_radius_that_moves():
    s, ball = plane()
    refused(lambda: s.rolling("c", ball, radius="1 + t"), "The radius of rolling 'c' cannot depend on t.")


def test_axle_without_direction():
    s, ball = plane()
    refused(lambda: s.rolling("c", ball, radius=1, axis=(0, 0, 0)), "has length zero. Give a direction")
    assert s.constraints == {}


# -- joints that close loops ------------------------------------------------------------------------------------


def loop(kind, **given):
    s = fb.System("loop")
    a, b = s.body("a", fb.box(1, (1, 2, 3))), s.body("b", fb.box(1, (1, 2, 3)))
    s.free("fa", s.ground, a)
    s.free("fb", s.ground, b)
    getattr(s, kind)("third", a, b, **given)
    return s


def test_a_loop_joint_has_no_coordinate():
    refused(
        lambda: loop("hinge", coordinate="theta"),
        "Joint 'third' closes a loop, since 'b' is already held by an earlier joint: its displacement follows from the "
        "other coordinates. Leave out coordinate=, or declare this joint before the joint that is to close the loop.",
    )


def test_a_free_joint_closes_nothing():
    refused(
        lambda: loop("free"),
        "Free joint 'third' has no effect, since another joint already holds 'b'. Leave it out.",
    )


# -- closing ----------------------------------------------------------------------------------------------------


def four_bar(reach=2.0):
    s = fb.System("four-bar")
    crank, rod, rocker = (
        s.body(n, fb.slender_bar(1, L)) for n, L in (("crank", 1), ("rod", 2), ("rocker", 1.5))
    )
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), coordinate="a")
    s.hinge("B", crank, rod, at=(0.5, 0, 0), to=(-1, 0, 0), coordinate="b")
    s.hinge("D", s.ground, rocker, at=(reach, 0, 0), to=(-0.75, 0, 0), coordinate="d")
    s.hinge("C", rocker, rod, at=(0.75, 0, 0), to=(1, 0, 0))
    return s


def test_start_off_the_constraints():
    with pytest.raises(SimulationError) as caught:
        fb.simulate(four_bar(), 1, initial={"a": 0.3, "b": 0.4, "d": 0.9})
    message = str(caught.value)
    assert (
        "The initial state is off the constraints of 'four-bar'. The constraints cannot be met near the"
        in message
    )
    assert "'C_" in message and "is still missed by" in message
    assert (
        "leave some out and they are solved for (near= tells where to look), or pass project=True" in message
    )


def test_a_linkage_that_does_not_reach():
    with pytest.raises(SimulationError, match="after 50 steps 'C_x' is still missed by .*check the lengths"):
        fb.simulate(four_bar(9.0), 1)


def test_rope_between_points_in_one_place():
    s, ball = plane()
    s.rope([s.ground.origin, ball.origin], 2)
    with pytest.raises(
        SimulationError,
        match=r"'plane' \(rope\) has no direction at x = 0, y = 0, f = 0: two points of a rope",
    ):
        fb.simulate(s, 1)
    assert fb.simulate(s, 0.1, near={"y": -1})["y"][0] == pytest.approx(-2)


def test_wheel_that_lies_flat():
    s = fb.System("coin")
    coin = s.body("coin", fb.disk(1, 0.1))
    s.free("air", s.ground, coin)
    s.rolling("contact", coin, radius=0.1, axis="z", normal="z")
    with pytest.raises(SimulationError, match="has no direction at .*a wheel that lies flat"):
        fb.simulate(s, 1)


def test_speeds_that_contradict_the_constraints():
    with pytest.raises(SimulationError) as caught:
        fb.simulate(four_bar(), 1, initial={"a": 0.3, "a'": 1, "b'": 1, "d'": 1}, near={"b": 0.4, "d": 0.9})
    message = str(caught.value)
    assert "The initial speeds contradict the constraints of 'four-bar': the rate of 'C_" in message
    assert "not 0. Name fewer speeds, so that the others can follow, or pass project=True." in message


def test_start_in_a_singular_position():
    s = fb.System("parallelogram")
    s.gravity = (0, -9.81, 0)
    a, b, c = (s.body(n, fb.slender_bar(1, L)) for n, L in (("a", 1), ("b", 2), ("c", 1)))
    s.hinge("A", s.ground, a, to=(-0.5, 0, 0), coordinate="qa")
    s.hinge("B", a, b, at=(0.5, 0, 0), to=(-1, 0, 0), coordinate="qb")
    s.hinge("D", s.ground, c, at=(2, 0, 0), to=(-0.5, 0, 0), coordinate="qd")
    s.hinge("C", c, b, at=(0.5, 0, 0), to=(1, 0, 0))
    with pytest.raises(SimulationError) as caught:
        fb.simulate(s, 1)
    message = str(caught.value)
    assert (
        "The constraint 'C_x' of 'parallelogram' followed from the others at the start, but at t = "
        in message
    )
    assert "The start is a singular position, such as bars in line" in message
    assert message.endswith("Start beside it.")


def test_unknown_name_near():
    with pytest.raises(SimulationError, match="Unknown name 'bb' in near; did you mean 'b'"):
        fb.simulate(four_bar(), 1, near={"bb": 1})
    with pytest.raises(SimulationError, match="Expected near values by name"):
        fb.simulate(four_bar(), 1, near=[1])


# -- equations --------------------------------------------------------------------------------------------------


def test_too_few_or_many_independent_speeds():
    e = fb.equations(four_bar())
    message = "Expected 1 different independent speeds, since 2 constraints act on 3 speeds, got "
    for given in ([], ["a", "b"]):
        refused(lambda given=given: e.eliminated(given), message + f"{len(given)}.")


def test_the_same_speed_twice():
    s, _ = plane()
    s.constrain("y", name="floor")
    refused(lambda: fb.equations(s).eliminated(["x", "x"]), "Expected 2 different independent speeds")


def test_speeds_that_do_not_determine_the_others():
    s, _ = plane()
    s.constrain("y", name="floor")
    refused(
        lambda: fb.equations(s).eliminated(["x", "y"]),
        "The constraints do not determine f'. Choose other independent speeds.",
    )


def test_unknown_speed():
    refused(
        lambda: fb.equations(four_bar()).eliminated(["aa"]), "Unknown speed 'aa'; known names: a', b', d'."
    )


def test_indeterminate_near_unknown_coordinates():
    e = fb.equations(four_bar())
    refused(lambda: e.indeterminate({"aa": 1}), "Unknown coordinate 'aa' in near; did you mean 'a'")
    refused(
        lambda: e.indeterminate({"a": "b"}),
        "Expected a number or an expression of parameters for 'a' in near, got 'b'.",
    )
    refused(
        lambda: fb.equations(four_bar(9.0)).indeterminate(),
        "The constraints cannot be met near the coordinates given",
    )
