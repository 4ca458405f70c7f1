"""Numbers with a unit by name."""

from __future__ import annotations

import re

import pytest
import sympy

import freebody as fb
from freebody.errors import ExpressionError, ModelError
from freebody.scalar.units import UNITS, quantity, unit

R = sympy.Rational


@pytest.mark.parametrize(
    ("text", "wanted", "expected"),
    [
        ("75deg", "rad", 5 * sympy.pi / 12), ("75 degrees", "rad", 5 * sympy.pi / 12),
        ("75°", "rad", 5 * sympy.pi / 12), ("-75 °", "rad", -5 * sympy.pi / 12),
        ("1.2 rad", "rad", R(6, 5)), ("0.5", "rad", R(1, 2)),
        ("3 rpm", "rad/s", sympy.pi / 10), ("2 rev/s", "rad/s", 4 * sympy.pi), ("2 rad/s", "rad/s", 2),
        ("2*pi rad", "rad", 2 * sympy.pi), ("pi/2 - 5deg", "rad", 17 * sympy.pi / 36), ("2*(3 - 1) cm", "m", R(1, 25)),
        ("-3e-2 kg m^2", "kg m²", R(-3, 100)), ("5 kg·m²", "kg m²", 5), ("9.81 m s^-2", "m/s²", R(981, 100)),
        ("10 N*m*s/rad", "N m s", 10), ("4 N m", "N m/rad", 4), ("20 km/h", "m/s", R(50, 9)), ("3 mm", "m", R(3, 1000)),
        ("7 g", "kg", R(7, 1000)), ("2 kN", "N", 2000), ("1 rev/day", "rev/day", 1), ("2/s", "1/s", 2),
        ("25 cm", "mm", 250), ("25 cm", "", R(1, 4)), ("30 deg", "", sympy.pi / 6),
    ],
)  # fmt: skip
def test_quantity(text: str, wanted: str, expected: object) -> None:
    assert sympy.simplify(quantity(text, wanted) - expected) == 0


@pytest.mark.parametrize(
    ("text", "wanted", "message"),
    [
        ("3 furlongs", "m", r"Unknown unit 'furlongs' in 'furlongs'; known units: m, km, .*revolutions\."),
        ("3 degs", "rad", "Unknown unit 'degs'.*did you mean 'deg'"),
        ("2pi", "rad", r"Unknown unit 'pi' in 'pi'; write a product as 2\*pi\."),
        ("2 kg", "m", "Expected parameter 'x' in m or a unit of its kind, got '2 kg'"),
        ("30deg", "m", "Expected parameter 'x' in m"), ("30deg", "1", "Expected parameter 'x' as a pure number"),
        ("3 Hz", "rad/s", "Expected parameter 'x' in rad/s .*got '3 Hz'. A frequency of turns is written in rev/s."),
        ("3 m", "slug", "Expected parameter 'x' as a plain number in slug, a unit without a size here, got '3 m'"),
        ("wide", "m", "Expected a number for parameter 'x', such as 0.3, .*got 'wide'"),
        ("5 m + 2 cm", "m", "Expected a number for parameter 'x'"), ("", "m", "got an empty text"),
    ],
)  # fmt: skip
def test_refused(text: str, wanted: str, message: str) -> None:
    with pytest.raises(ExpressionError, match=message):
        quantity(text, wanted, "parameter 'x'")


def test_a_text_that_is_no_unit() -> None:
    with pytest.raises(ExpressionError, match="Expected a unit such as m/s"):
        unit("m/s+")
    assert unit("1") == (1, (0, 0, 0, 0)) and unit("N m") == UNITS["J"]


def test_values_of_a_model() -> None:
    """Text is read in the unit that the system says of the parameter."""
    s = fb.System("bar")
    L, turn = s.parameters(L=2.0, turn=1.0)
    s.describe(L, unit="mm", about="length")
    s.body("bar", fb.slender_bar(1, L / 1000, axis="x"))
    s.hinge("pin", s.ground, "bar", axis="z", coordinate="theta")
    model = fb.assemble(s)
    assert model.values({L: "3 cm", "turn": "180 deg"}) == pytest.approx({"L": 30, "turn": sympy.pi.evalf()})
    with pytest.raises(
        (ModelError, ExpressionError), match="Expected parameter 'L' in mm or a unit of its kind"
    ):
        model.values({"L": "3 kg"})


def test_a_unit_of_another_kind_is_refused_where_the_use_tells_the_kind() -> None:
    """Nothing is described: a mass, a length and gravity are what they are used as; of c nothing is known."""
    s = fb.System("pendulum")
    m, L, d, g, c = s.parameters(m=1.0, L=2.0, d=0.1, g=9.81, c=0.2)
    s.gravity = (0, -g, 0)
    pin = s.hinge("pin", s.ground, s.body("bar", fb.slender_bar(m, 2 * L, axis="y")), to=(0, d / 2, 0))
    s.damper("c", pin, damping=c)
    model = fb.assemble(s)
    given = {"m": "500 g", "L": "25 cm", "d": "3 mm", "g": "9.81 m/s^2", "c": "1 N m s"}
    assert list(model.values(given).values()) == [0.5, 0.25, 0.003, 9.81, 1.0]
    for name, wrong, unit_ in (
        ("m", "1 m", "kg"),
        ("L", "1 kg", "m"),
        ("d", "1 s", "m"),
        ("g", "1 m", "m/s^2"),
    ):
        wanted = re.escape(f"Expected parameter '{name}' in {unit_} or a unit of its kind, got '{wrong}'.")
        with pytest.raises(ExpressionError, match=wanted):
            model.values({name: wrong})
        with pytest.raises(ExpressionError, match=wanted):
            fb.compile(s).forward_dynamics([0.1], [0.0], **{name: wrong})


TABLE = {  # size in m, kg, s, rad; exponents of these [BIPM, The International System of Units (2019), tables 2, 4, 8]
    "m": (1, "m"), "km": (1000, "m"), "cm": (0.01, "m"), "mm": (0.001, "m"),
    "kg": (1, "kg"), "g": (0.001, "kg"), "t": (1000, "kg"),
    "s": (1, "s"), "ms": (0.001, "s"), "min": (60, "s"), "h": (3600, "s"), "day": (86400, "s"),
    "N": (1, "kg m/s^2"), "kN": (1000, "kg m/s^2"), "mN": (0.001, "kg m/s^2"),
    "J": (1, "kg m^2/s^2"), "kJ": (1000, "kg m^2/s^2"), "W": (1, "kg m^2/s^3"), "kW": (1000, "kg m^2/s^3"),
    "Hz": (1, "1/s"), "rpm": (0.10471975511965977, "rad/s"),
    "rad": (1, "rad"), "radian": (1, "rad"), "radians": (1, "rad"),
    "deg": (0.017453292519943295, "rad"), "degree": (0.017453292519943295, "rad"),
    "degrees": (0.017453292519943295, "rad"), "°": (0.017453292519943295, "rad"),
    "rev": (6.283185307179586, "rad"), "revolution": (6.283185307179586, "rad"),
    "revolutions": (6.283185307179586, "rad"),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLE)
def test_every_unit_against_the_table(name: str) -> None:
    size, base = TABLE[name]
    assert float(quantity(f"3 {name}", base)) == pytest.approx(3 * size, rel=1e-15)
    assert UNITS[name].exponents == unit(base).exponents and unit(name) == UNITS[name]
    assert float(UNITS[name].size) == pytest.approx(size, rel=1e-15)


def test_the_table_names_every_unit() -> None:
    assert TABLE.keys() == UNITS.keys()
