"""The text of every refusal of kinds that users wrote: the kind's name, the line in the user's file, and the cure."""

# ruff: noqa: E501 (tables: one case, one line)

from __future__ import annotations

import random
import re
from itertools import count

import pytest
import sympy

import freebody as fb

HERE = r"\(.*test_own_kind_errors\.py, line \d+: "


def pendulum():
    s = fb.System("pendulum")
    s.gravity = (0, "-g", 0) if s.parameters(g=9.81) else None
    bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, 1, 0), axis="z", coordinate="theta")
    return s


OTHER = pendulum()
COUNT = count(1)
MEMORY: list[float] = []


class OfPoint(fb.Load):
    point: fb.Point


class Branching(OfPoint):
    def actions(self, at):
        if at.velocity(self.point).x > 0:
            yield fb.PointForce(self.point, (1, 0, 0))


class BranchingOnEquality(OfPoint):
    def actions(self, at):
        v = at.velocity(self.point)
        yield fb.PointForce(self.point, (0, 1, 0) if v.x == 0 else v)


class WrongShape(OfPoint):
    def actions(self, at):
        yield fb.PointForce(self.point, (1, 0, 0))
        yield fb.PointForce(self.point, (1, 2))


class OtherBody(OfPoint):
    def actions(self, at):
        yield fb.Couple(OTHER.bodies["bar"], (0, 0, 1))


class AskingAnotherBody(OfPoint):
    def actions(self, at):
        yield fb.PointForce(self.point, at.velocity(OTHER.bodies["bar"]))


class OtherJoint(OfPoint):
    def actions(self, at):
        yield fb.JointForce(OTHER.joints["pin"], 1)


class Nothing(OfPoint):
    def actions(self, at):
        return None


class Number(OfPoint):
    def actions(self, at):
        yield 3


class WrongGradient(OfPoint):
    def actions(self, at):
        yield fb.PointForce(self.point, (0, -3, 0))

    def potential(self, at):
        return -3 * at.position(self.point).y


class Random(OfPoint):
    def actions(self, at):
        yield fb.PointForce(self.point, (random.random(), 0, 0))


class Counting(OfPoint):
    def actions(self, at):
        yield fb.PointForce(self.point, (next(COUNT), 0, 0))


class Remembering(OfPoint):
    def actions(self, at):
        MEMORY.append(1)
        yield from (fb.PointForce(self.point, (1, 0, 0)) for _ in MEMORY)


class OfPythonsMath(OfPoint):
    def actions(self, at):
        import math

        yield fb.PointForce(self.point, (math.tanh(at.velocity(self.point).x), 0, 0))


class Dividing(OfPoint):
    def actions(self, at):
        yield fb.PointForce(self.point, (1 / len(MEMORY[:0]), 0, 0))


LOADS = {
    Branching: rf"Branching 'x': .*no branch on the value.*{HERE}if at.velocity.*without if on a value: at.where.*fb.Load lists",
    BranchingOnEquality: rf"Branching on equality 'x': recorded as a formula its value is \(0, 0, 0\), but asked with "
    rf"numbers it is \(0, 1, 0\) {HERE}def actions.*branches on a value.*no ==.*at.where",
    WrongShape: rf"Wrong shape 'x': in its action .*three components, got \(1, 2\).*{HERE}yield .*\(1, 2\)",
    OtherBody: rf"Other body 'x': body 'bar' belongs to another system than 'pendulum'. Take bodies and points from the "
    rf"data of the load. {HERE}yield fb.Couple",
    AskingAnotherBody: rf"Asking another body 'x': body 'bar' belongs to another system.*{HERE}yield fb.PointForce",
    OtherJoint: rf"Other joint 'x': hinge 'pin' .* is not a joint of 'pendulum'. Name a joint .*{HERE}yield fb.JointForce",
    Nothing: rf"Nothing 'x': expected actions, got None {HERE}def actions.*Yield what acts, such as fb.PointForce",
    Number: rf"Number 'x': expected fb.PointForce.* got 3. Yield what acts.*{HERE}yield 3",
    WrongGradient: rf"Wrong gradient 'x': the gradient of its potential is not its force {HERE}def potential.*power .* W, "
    r"and -dV/dt is .* W. Correct the sign or the factor",
    Random: rf"Random 'x': asked twice at one state, it answers two things {HERE}def actions.*not a function of the state."
    " Take what changes from `at`.*no random numbers",
    Counting: r"Counting 'x': asked twice at one state.*no memory of earlier calls",
    Remembering: r"Remembering 'x': asked twice at one state",
    Dividing: rf"Dividing 'x': division by zero {HERE}yield fb.PointForce.*fb.Load lists what they may use",
    OfPythonsMath: rf"Of pythons math 'x': .*{HERE}yield .*math.tanh.*fb.Load lists what they may use",
}  # fmt: skip


@pytest.mark.parametrize("product", [fb.equations, fb.compile, fb.draw], ids=lambda f: f.__name__)
@pytest.mark.parametrize("kind", LOADS, ids=lambda kind: kind.__name__)
def test_loads(kind, product):
    s = pendulum()
    s.add("x", kind(s.bodies["bar"].point(1, 0, 0)))
    with pytest.raises(fb.FreebodyError) as error:
        result = product(s)
        result.text() if product is fb.equations else None
        result.inverse_dynamics([0.1], [0.2], [0.3]) if product is fb.compile else None
    assert re.search(LOADS[kind], str(error.value), re.DOTALL), error.value


# --- joints ------------------------------------------------------------------------------------


class OfMath(fb.Joint):
    def pose(self, q):
        import math

        return (math.sin(q), 0, 0), []


class BranchingPose(fb.Joint):
    def pose(self, q):
        return ((q, 0, 0) if q > 0 else (-q, 0, 0)), []


class NoTurns(fb.Joint):
    def pose(self, q):
        return (q, q, 0)


class TwoComponents(fb.Joint):
    def pose(self, q):
        return (q, sympy.sin(q)), []


class Speeding(fb.Joint):
    def pose(self, q):
        return ("x'", 0, 0), []


class Still(fb.Joint):
    def pose(self, q):
        return (1, 2, 3), []


class Without(fb.Joint):
    pass


class NoMotion(fb.Joint):
    def motions(self):
        return None


class NotMotions(fb.Joint):
    def motions(self):
        yield "hinge"


class SameTwice(fb.Joint):
    def motions(self):
        yield fb.Slider("x")
        yield fb.Slider("x")


class Failing(fb.Joint):
    def motions(self):
        yield fb.Hinge("z", at=(0, self.length, 0))


class OneEnding(fb.Joint):
    endings = ("hip",)

    def motions(self):
        yield fb.Hinge("z")
        yield fb.Hinge("x")


class MovingAnchor(fb.Joint):
    def motions(self):
        yield fb.Hinge("z", at=("theta", 0, 0))


JOINTS = {
    OfMath: rf"Of math 'x': .*{HERE}return \(math.sin\(q\).*made of SymPy expressions",
    BranchingPose: rf"Branching pose 'x': .*{HERE}return .*if q > 0.*without if on them",
    NoTurns: r"Expected a position and turns from the pose of no turns 'x', such as \(x, y, 0\), \[\('z', angle\)\], got"
    rf".*{HERE}def pose",
    TwoComponents: r"Expected three components .*for the position of two components 'x', got 2.*Add the third component"
    rf".*{HERE}def pose",
    Speeding: rf"a displacement may depend on coordinates, parameters and time, not on x'.*{HERE}def pose",
    Still: rf"The pose of still 'x' does not depend on its coordinate 'x'.*{HERE}def pose",
    Without: r"Without 'x': its class Without has no motions. Define motions\(self\)",
    NoMotion: rf"Expected a list of motions for no motion 'x', such as .*, got None.*{HERE}def motions",
    NotMotions: rf"Expected fb.Hinge, fb.Slider, fb.Screw or fb.Ball in not motions 'x', got 'hinge'.*{HERE}def motions",
    SameTwice: rf"Motions 1 and 2 of same twice 'x' are the same slider.*Leave one out.*{HERE}def motions",
    Failing: rf"Failing 'x': .*has no attribute 'length' {HERE}yield fb.Hinge",
    OneEnding: rf"One ending 'x' has 2 motions without a coordinate.* OneEnding has 1 endings.*hip.*{HERE}def motions",
    MovingAnchor: rf"The anchor of moving anchor 'x' is fixed in the joint and cannot depend on theta.*{HERE}def motions",
}  # fmt: skip


@pytest.mark.parametrize("kind", JOINTS, ids=lambda kind: kind.__name__)
def test_joints(kind):
    s = pendulum()
    body = s.body("tip", fb.particle(1))
    with pytest.raises(fb.FreebodyError) as error:
        s.add("x", kind(s.bodies["bar"], body))
    assert re.search(JOINTS[kind], str(error.value), re.DOTALL), error.value
    # nothing stays behind: the same name serves the next attempt
    assert "x" not in s.joints
    s.hinge("x", s.bodies["bar"], body, coordinate="x")


def test_a_joint_to_a_body_of_another_system():
    class Pin(fb.Joint):
        def motions(self):
            yield fb.Hinge("z")

    s = pendulum()
    with pytest.raises(fb.FreebodyError, match="Pin 'x': body 'bar' belongs to the system of the same name"):
        s.add("x", Pin(s.ground, OTHER.bodies["bar"]))
    with pytest.raises(fb.FreebodyError, match="Expected a rotor for pin 'x'"):
        s.add("x", Pin(s.bodies["bar"], s.body("tip", fb.particle(1)), rotor=3))


# --- contacts ----------------------------------------------------------------------------------


class Wall(fb.Gap):
    point: fb.Point

    def gap(self, at):
        return at.position(self.point).x

    def normal(self, at):
        yield fb.PointForce(self.point, (1, 0, 0))


class BranchingGap(Wall):
    def gap(self, at):
        x = at.position(self.point).x
        return x if x > 0 else 2 * x


class RandomGap(Wall):
    def gap(self, at):
        return at.position(self.point).x + random.random()


class GapOfThree(Wall):
    def gap(self, at):
        return at.position(self.point)


class ShapelessNormal(Wall):
    def normal(self, at):
        yield fb.PointForce(self.point, 1)


class OtherNormal(Wall):
    def normal(self, at):
        yield fb.PointForce(OTHER.bodies["bar"].origin, (1, 0, 0))


class RandomNormal(Wall):
    def normal(self, at):
        yield fb.PointForce(self.point, (random.random(), 0, 0))


GAPS = {
    BranchingGap: rf"Branching gap 'x': .*{HERE}return x if x > 0.*Gap, normal and tangents are formulas",
    RandomGap: rf"Random gap 'x': asked twice at one state, it answers two things {HERE}def gap.*not a function",
    GapOfThree: rf"Gap of three 'x': expected a number, got .*{HERE}def gap",
    ShapelessNormal: rf"Shapeless normal 'x': in its action .*{HERE}yield",
    OtherNormal: rf"Other normal 'x': body 'bar' belongs to another system than 'pendulum'.*{HERE}yield",
    RandomNormal: rf"Random normal 'x': asked twice at one state.*{HERE}def normal",
}  # fmt: skip


@pytest.mark.parametrize("kind", GAPS, ids=lambda kind: kind.__name__)
def test_contacts(kind):
    s = pendulum()
    s.add("x", kind(s.bodies["bar"].point(1, 0, 0)))
    with pytest.raises(fb.FreebodyError) as error:
        fb.simulate(s, 0.1, initial={"theta": 0.1})
    assert re.search(GAPS[kind], str(error.value), re.DOTALL), error.value


# --- methods -----------------------------------------------------------------------------------

HEUN = {"order": 2, "stages": [[1]], "weights": [1 / 2, 1 / 2], "embedded": [1, 0]}
METHODS = {
    "the name": ({}, "two words", "Expected a name such as 'heun' for a method, got 'two words'"),
    "taken": ({}, "dop853", "There is already a method 'dop853'. Choose another name."),
    "rows": ({"stages": [[1, 2]]}, "m", r"Expected 1 number in row 1 of the stages of the method 'm', which is explicit"),
    "no rows": ({"stages": 3}, "m", "Expected rows of numbers for the stages of the method 'm', got 3"),
    "text": ({"weights": ["a", "b"]}, "m", "Expected numbers for the weights of the method 'm', got"),
    "infinite": ({"weights": [float("nan"), 1]}, "m", "Expected finite numbers for the weights of the method 'm'"),
    "weights": ({"weights": [1]}, "m", "Expected 2 weights, one for each of the 2 stages of the method 'm', got 1"),
    "embedded": ({"embedded": [1]}, "m", "Expected 2 or 3 embedded, one for each of the 2 stages of the method 'm', got 1"),
    "order": ({"order": 3}, "m", "Expected weights of order 3 for the method 'm', but they have order 2:.*pass order=2"),
    "no order": ({"order": "two"}, "m", "Expected an order from 1 to 8 for the method 'm', got 'two'"),
    "sum": ({"embedded": [1, 1]}, "m", "Expected embedded weights of the method 'm' that add up to 1, got 2"),
    "no error": ({"embedded": [1 / 2, 1 / 2]}, "m", "The embedded weights of the method 'm' are its weights"),
    "too many": (
        {"order": 1, "stages": [[0] * i for i in range(1, 12)], "weights": [1, *[0] * 11], "embedded": [0, 1, *[0] * 10]},
        "m", "Expected at most 11 stages for the method 'm', got 12",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", METHODS)
def test_methods(case):
    change, name, message = METHODS[case]
    with pytest.raises(fb.FreebodyError, match=message):
        fb.RungeKutta(name, **{**HEUN, **change})
    with pytest.raises(
        fb.FreebodyError, match="Unknown method 'm'.*Import the module that defines it as fb.RungeKutta"
    ):
        fb.simulate(pendulum(), 1, method="m")
