"""Messages about loads that follow a law: drag, motors, gravitation, bushings, cables, springs of any law."""

from __future__ import annotations

import re

import pytest

import freebody as fb
from freebody.formats.toml.read import case_from_text
from freebody.formats.toml.write import toml_text


def machine():
    s = fb.System("machine")
    s.parameters(k=1.0)
    one, two = s.body("one", fb.box(1, (1, 2, 3))), s.body("two", fb.particle(1))
    s.hinge("pin", s.ground, one, coordinate="q")
    s.free("air", s.ground, two)
    return s


REFUSALS = {
    "drag on the ground": (lambda s, one, two: s.drag("air", s.ground, linear=1), "Drag 'air' acts on the ground"),
    "drag of nothing": (lambda s, one, two: s.drag("Air", two), "Expected a coefficient of drag 'Air': quadratic= ("),
    "wind of two components": (lambda s, one, two: s.drag("air", two, linear=1, wind=(1, 2)), "three components"),
    "drag of an unknown": (lambda s, one, two: s.drag("air", two, linear="c"), "Expected a known name, got 'c'"),
    "no motor": (lambda s, one, two: s.motor("m", s.joints["pin"]), "Expected stall_torque= of motor 'm', with"),
    "two motors": (
        lambda s, one, two: s.motor("m", s.joints["pin"], stall_torque=1, electric=(1, 2, 3)),
        "electric=(V, k, R); got both",
    ),
    "electric": (
        lambda s, one, two: s.motor("m", s.joints["pin"], electric=3),
        "Expected electric=(voltage, constant, resistance) of motor 'm', got 3",
    ),
    "motor on a body": (lambda s, one, two: s.motor("m", one, stall_torque=1), "Expected a joint for motor 'm', got"),
    "motor on a free joint": (
        lambda s, one, two: s.motor("m", s.joints["air"], stall_torque=1),
        "Free 'air' has no single displacement for motor 'm' to act along",
    ),
    "motor with a ratio that changes": (
        lambda s, one, two: s.motor("m", s.joints["pin"], stall_torque=1, ratio="t"),
        "The ratio of motor 'm' must be constant, but it depends on t",
    ),
    "gravitation of the ground": (
        lambda s, one, two: s.gravitation("g", s.ground, two, parameter=1),
        "Gravitation 'g' acts on the ground",
    ),
    "gravitation of itself": (
        lambda s, one, two: s.gravitation("g", one, one.point(1, 0, 0), parameter=1),
        "Gravitation 'g' acts on a body toward a point of itself",
    ),
    "gradient on a particle": (
        lambda s, one, two: s.gravitation("g", two, parameter=1, extended=True),
        "'two' has no moment of inertia, so the gradient of the field does nothing to it. Leave out extended=True",
    ),
    "bushing in a body": (
        lambda s, one, two: s.bushing("b", one, one, stiffness=(1, 1, 1)),
        "Both ends of bushing 'b' are on 'one'",
    ),
    "bushing that changes": (
        lambda s, one, two: s.bushing("b", one, two, turning_stiffness=(1, "q", 1)),
        "The turning_stiffness of bushing 'b' must be constant, but it depends on q. Write the law as a load of",
    ),
    "cable in a body": (
        lambda s, one, two: s.cable("c", one, one, stiffness=1, length=1),
        "Both ends of cable 'c' are on 'one'",
    ),
    "spring without a law": (
        lambda s, one, two: s.spring("k1", s.joints["pin"]),
        "Expected either stiffness= or force= of spring 'k1', got neither",
    ),
    "spring of two laws": (
        lambda s, one, two: s.spring("k1", s.joints["pin"], stiffness=1, force="stretch"),
        "Expected either stiffness= or force= of spring 'k1', got both",
    ),
    "law of an unknown": (
        lambda s, one, two: s.spring("k1", s.joints["pin"], force="k*strech"),
        "In the law of spring 'k1': Expected a known name, got 'strech'; did you mean 'stretch'",
    ),
    "law of a foreign symbol": (
        lambda s, one, two: s.spring("k1", s.joints["pin"], force=__import__("sympy").Symbol("z")),
        "unknown symbol 'z'",
    ),
    "table of one": (
        lambda s, one, two: s.spring("k1", s.joints["pin"], force=[(0, 0)]),
        "Expected a table of 2 to 200 pairs (stretch, force) for spring 'k1'",
    ),
    "table of three": (
        lambda s, one, two: s.spring("k1", s.joints["pin"], force=[(0, 0, 1), (1, 2, 3)]),
        "Expected a table of 2 to 200 pairs (stretch, force) for spring 'k1'",
    ),
    "table that falls back": (
        lambda s, one, two: s.spring("k1", s.joints["pin"], force=[(0, 0), (1, 2), (0.5, 3)]),
        "Expected rising places in the table of spring 'k1', got 1 and then 0.5",
    ),
    "table of parameters": (
        lambda s, one, two: s.spring("k1", s.joints["pin"], force=[(0, 0), ("k", 2)]),
        "Expected numbers in the table of spring 'k1', got 'k', a parameter",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSALS)
def test_refusal(case):
    s = machine()
    make, message = REFUSALS[case]
    with pytest.raises(fb.FreebodyError, match=re.escape(message)):
        make(s, s.bodies["one"], s.bodies["two"])
    assert not s.loads


def test_a_law_and_a_name_of_the_system():
    s = machine()
    s.parameters(rate=1.0)
    with pytest.raises(fb.FreebodyError, match="this system has a parameter 'rate'. Give that another name"):
        s.spring("k1", s.joints["pin"], force="stretch*rate")


def test_files():
    s = machine()
    s.motor("m", s.joints["pin"], stall_torque=1, inertia=2)
    s.spring("k1", s.joints["pin"], force="k*stretch - rate^3", rest=0.5)
    s.spring("k2", s.ground.point(1, 0, 0), s.bodies["two"], force=[(0, 0), (0.5, 1), (2, 9)])
    text = toml_text(s)
    assert 'force = "k*stretch - rate**3"' in text and "force = [[0, 0], [0.5, 1], [2, 9]]" in text
    assert toml_text(case_from_text(text).system) == text
    with pytest.raises(fb.FreebodyError, match="loads.k2.*table of 2 to 200 pairs"):
        case_from_text(text.replace("[[0, 0], [0.5, 1], [2, 9]]", "[[0, 0]]"))
    with pytest.raises(fb.FreebodyError, match="loads.m.*Unknown key 'stall'"):
        case_from_text(text.replace("stall_torque = 1", "stall_torque = 1\nstall = 2"))
    with pytest.raises(fb.FreebodyError, match="loads.m.*'stall_torque', but it is missing"):
        case_from_text(text.replace("stall_torque = 1\n", ""))


@pytest.mark.parametrize("kind", ["cable", "gravitation"])
def test_a_law_without_a_value_at_a_state_is_named(kind):
    s = fb.System("two")
    a, b = (s.body(name, fb.sphere(1, 0.1)) for name in "ab")
    for name, body in (("x", a), ("z", b)):
        s.slider(f"rail_{name}", s.ground, body, axis="x", coordinate=name)
    if kind == "cable":
        s.cable("pull", a, b, stiffness=500, length=1)
    else:
        s.gravitation("pull", a, b, parameter=3)
    with pytest.raises(
        fb.errors.UndefinedError, match=f"{kind.title()} 'pull' has no value at this state: its law"
    ):
        fb.linearize(s)
    assert issubclass(fb.errors.UndefinedError, ZeroDivisionError)  # callers that try states pass it


def test_a_tyre_at_rest_in_a_formula_is_named():
    """Its slips divide by the speed, which is zero beside a formula of the steering angle."""
    s = fb.System("car")
    s.parameters(delta="1deg")
    car, front = s.body("car", fb.box(1000, (3, 1.5, 0.3))), s.body("front", fb.particle(0))
    s.planar("road", s.ground, car, coordinate="x y psi")
    s.hinge("steering", car, front, at=(1.2, 0, 0), axis="z", coordinate="delta")
    s.tyre("front_tyre", front, axis="y", lateral=12, load=5000, normal="z")
    with pytest.raises(
        fb.errors.UndefinedError,
        match="Tyre 'front_tyre' has no value at this state: .* speeds other than zero",
    ):
        fb.linearize(s)


def test_a_function_is_no_law_of_a_spring():
    s = machine()
    with pytest.raises(
        fb.errors.ModelError, match="Expected the law of spring 'hard' as an expression of stretch and"
    ):
        s.spring("hard", s.joints["pin"], force=lambda stretch: 20 * stretch)
