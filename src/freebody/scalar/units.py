"""Numbers with a unit by name: ``75 deg``, ``2 rev/s``, ``3 N m``, ``9.81 m/s^2``.

    quantity = number unit
    unit     = [ "1" ] [ "/" ] factor { [ "*" | "·" | "/" ] factor }      a "/" is of the factor behind it
    factor   = name [ "^" integer | "²" | "³" ]

The number is a product in the language of :mod:`freebody.scalar.parser`. A unit is its size in m, kg, s and rad and
the exponents of these; factors are those of the International System of Units, BIPM, The International System of
Units, 9th ed. 2019, tables 2, 4 and 8, exact.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import sympy

from ..errors import ExpressionError, nearest
from .parser import CONSTANTS, FUNCTIONS, parse


class Unit(NamedTuple):
    """Its size in m, kg, s and rad, and their exponents."""

    size: Any
    exponents: tuple[int, int, int, int]

    @property
    def kind(self) -> tuple[int, int, int, int]:
        """What has to agree: a torque per angle is a torque, but an angle is no pure number."""
        m, kg, s, rad = self.exponents
        return m, kg, s, max(rad, 0)


def _table() -> dict[str, Unit]:
    one, pi = sympy.Integer(1), sympy.pi
    length, mass, time, angle = (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)
    force, energy, power = (1, 1, -2, 0), (2, 1, -2, 0), (2, 1, -3, 0)
    named: dict[str, tuple[Any, tuple[int, int, int, int]]] = {
        "m": (one, length), "km": (one * 1000, length), "cm": (one / 100, length), "mm": (one / 1000, length),
        "kg": (one, mass), "g": (one / 1000, mass), "t": (one * 1000, mass),
        "s": (one, time), "ms": (one / 1000, time), "min": (one * 60, time), "h": (one * 3600, time),
        "day": (one * 86400, time),
        "N": (one, force), "kN": (one * 1000, force), "mN": (one / 1000, force),
        "J": (one, energy), "kJ": (one * 1000, energy), "W": (one, power), "kW": (one * 1000, power),
        "Hz": (one, (0, 0, -1, 0)), "rpm": (pi / 30, (0, 0, -1, 1)),
    }  # fmt: skip
    for size, *names in (
        (one, "rad", "radian", "radians"),
        (pi / 180, "deg", "degree", "degrees", "°"),
        (2 * pi, "rev", "revolution", "revolutions"),
    ):
        named |= {name: (size, angle) for name in names}
    return {name: Unit(*found) for name, found in named.items()}


UNITS = _table()

_POWER = r"(?:\^|\*\*)-?[0-9]{1,2}|[²³]"
_FACTOR = rf"(?:°|[^\W\d_]+?)(?:{_POWER})?(?![^\W_])"
_UNIT = rf"(?:1?\s*/\s*)?{_FACTOR}(?:\s*[*·/]?\s*{_FACTOR})*"
_QUANTITY = re.compile(rf"(?P<number>.*?(?:[0-9.)]|\bpi))\s*(?P<unit>{_UNIT})", re.DOTALL)
_PARTS = re.compile(rf"(?P<sign>[*·/]?)\s*(?P<name>°|[^\W\d_²³]+)(?P<power>{_POWER})?\s*")


def unit(text: str) -> Unit:
    """The unit that a text names.

    Raises
    ------
    ExpressionError
        A name that is no unit; all are listed.

    Examples
    --------
    >>> unit("kg m²/s")
    Unit(size=1, exponents=(2, 1, -1, 0))
    >>> unit("rpm").size, unit("1/day").size
    (pi/30, 1/86400)
    """
    size: Any = sympy.Integer(1)
    exponents = (0, 0, 0, 0)
    rest = text.strip().removeprefix("1").lstrip()
    at = 0
    while at < len(rest):
        part = _PARTS.match(rest, at)
        if part is None:
            raise ExpressionError(f"Expected a unit such as m/s^2 or N m, got '{text}'.")
        if part["name"] not in UNITS:
            raise ExpressionError(f"Unknown unit '{part['name']}' in '{text}'; {_known(part['name'])}")
        power = {"²": 2, "³": 3}.get(part["power"] or "") or int((part["power"] or "1").lstrip("^*"))
        power = -power if part["sign"] == "/" else power
        one = UNITS[part["name"]]
        size *= one.size**power
        exponents = tuple(a + power * b for a, b in zip(exponents, one.exponents, strict=True))  # type: ignore[assignment]
        at = part.end()
    return Unit(size, exponents)


def _known(name: str) -> str:
    if name in CONSTANTS:
        return f"write a product as 2*{name}."
    near = nearest(name, UNITS)
    listed = f"known units: {', '.join(UNITS)}."
    return f"{near} {listed[0].upper()}{listed[1:]}" if near.startswith("did") else listed


def quantity(text: str, wanted: str = "", what: str = "a value") -> Any:
    """The number that a text stands for, in a unit that is wanted.

    Parameters
    ----------
    text : str
        A number or an expression of numbers, with a unit behind it or without: without, it is in the unit wanted.
    wanted : str, optional
        Such as ``"rad/s"``; m, kg, s and rad if not given.
    what : str, optional
        What the number is of, for the messages.

    Returns
    -------
    SymPy number
        Exact.

    Raises
    ------
    ExpressionError
        No number, an unknown unit, a unit of another kind, a unit where the one wanted is no known one.

    Examples
    --------
    >>> quantity("75 degrees", "rad"), quantity("3 rpm", "rad/s"), quantity("25 cm", "m")
    (5*pi/12, pi/10, 1/4)
    >>> quantity("2 kg", "m", "parameter 'L'")
    Traceback (most recent call last):
    ...
    freebody.errors.ExpressionError: Expected parameter 'L' in m or a unit of its kind, got '2 kg'.
    """
    found = _QUANTITY.fullmatch(text.strip())
    if found and not re.search(r"[^eE*/^(]\s*[-+]", re.sub(r"\(.*\)", "0", found["number"])):
        given = unit(found["unit"])
        value = parse(found["number"], {})
        if not wanted:
            return value * given.size
        try:
            asked = unit(wanted)
        except ExpressionError:
            raise ExpressionError(
                f"Expected {what} as a plain number in {wanted}, a unit without a size here, got '{text}'."
            ) from None
        if asked.kind != given.kind:
            turns = " A frequency of turns is written in rev/s." if "Hz" in found["unit"] else ""
            raise ExpressionError(
                f"Expected {what} {_in(wanted)} or a unit of its kind, got '{text.strip()}'.{turns}"
            )
        return value * given.size / asked.size
    words = set(re.findall(r"\b[^\W\d]\w*", text)) - {*FUNCTIONS, *CONSTANTS, "deg", "rad"}
    if words:
        raise ExpressionError(
            f"Expected a number for {what}, such as 0.3, 2*pi or 75 deg, got '{text.strip()}'."
        )
    return parse(text, {})


def _in(wanted: str) -> str:
    return "as a pure number" if wanted == "1" else f"in {wanted}"
