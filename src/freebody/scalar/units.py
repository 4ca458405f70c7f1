"""Numbers with a unit by name: ``75 deg``, ``2 rev/s``, ``3 N m``, ``9.81 m/s^2``.

    quantity = number unit
    unit     = [ "1" ] [ "/" ] factor { [ "*" | "·" | "/" ] factor }      a "/" applies to the next factor only
    factor   = name [ "^" integer | "²" | "³" ]

The number is a product in the language of :mod:`freebody.scalar.parser`. A unit has a size in m, kg, s and rad and
the exponents of these. The factors are exact and from BIPM, The International System of Units, 9th ed. 2019, tables 2,
4 and 8.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import sympy

from ..errors import ExpressionError, nearest
from .parser import CONSTANTS, FUNCTIONS, parse


class Unit(NamedTuple):
    """Size of a unit in m, kg, s and rad, and their exponents."""

    size: Any
    exponents: tuple[int, int, int, int]

    @property
    def kind(self) -> tuple[int, int, int, int]:
        """Exponents that convertible units share: a torque per angle is a torque, but an angle is not a pure number."""
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
    return {name: Unit(*size_and_exponents) for name, size_and_exponents in named.items()}


UNITS = _table()

_POWER = r"(?:\^|\*\*)-?[0-9]{1,2}|[²³]"
_FACTOR = rf"(?:°|[^\W\d_]+?)(?:{_POWER})?(?![^\W_])"
_UNIT = rf"(?:1?\s*/\s*)?{_FACTOR}(?:\s*[*·/]?\s*{_FACTOR})*"
_QUANTITY = re.compile(rf"(?P<number>.*?(?:[0-9.)]|\bpi))\s*(?P<unit>{_UNIT})", re.DOTALL)
_PARTS = re.compile(rf"(?P<sign>[*·/]?)\s*(?P<name>°|[^\W\d_²³]+)(?P<power>{_POWER})?\s*")


def unit(text: str) -> Unit:
    """Return the unit that a text names.

    Raises
    ------
    ExpressionError
        For a name that is not a unit; the message lists all units.

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
        factor = UNITS[part["name"]]
        size *= factor.size**power
        exponents = tuple(a + power * b for a, b in zip(exponents, factor.exponents, strict=True))  # type: ignore[assignment]
        at = part.end()
    return Unit(size, exponents)


def _known(name: str) -> str:
    """End of the message about an unknown unit."""
    if name in CONSTANTS:
        return f"write a product as 2*{name}."
    near = nearest(name, UNITS)
    listed = f"known units: {', '.join(UNITS)}."
    return f"{near} {listed[0].upper()}{listed[1:]}" if near.startswith("did") else listed


def quantity(text: str, target: str = "", what: str = "a value") -> Any:
    """Return the number that a text stands for, converted to a unit.

    Parameters
    ----------
    text : str
        A number or an expression of numbers, followed by a unit or not; without a unit it is in ``target``.
    target : str, optional
        Unit of the result, such as ``"rad/s"``; by default in m, kg, s and rad.
    what : str, optional
        Name of the quantity, for the messages.

    Returns
    -------
    SymPy number
        Exact.

    Raises
    ------
    ExpressionError
        If there is no number, if the unit is unknown or of another kind, or if there is a unit but ``target`` is not
        a known unit.

    Examples
    --------
    >>> quantity("75 degrees", "rad"), quantity("3 rpm", "rad/s"), quantity("25 cm", "m")
    (5*pi/12, pi/10, 1/4)
    >>> quantity("2 kg", "m", "parameter 'L'")
    Traceback (most recent call last):
    ...
    freebody.errors.ExpressionError: Expected parameter 'L' in m or a unit of its kind, got '2 kg'.
    """
    match = _QUANTITY.fullmatch(text.strip())
    if match and not re.search(r"[^eE*/^(]\s*[-+]", re.sub(r"\(.*\)", "0", match["number"])):
        source = unit(match["unit"])
        value = parse(match["number"], {})
        if not target:
            return value * source.size
        try:
            target_unit = unit(target)
        except ExpressionError:
            raise ExpressionError(
                f"Expected {what} as a plain number in {target}, a unit without a size here, got '{text}'."
            ) from None
        if target_unit.kind != source.kind:
            turns = " A frequency of turns is written in rev/s." if "Hz" in match["unit"] else ""
            raise ExpressionError(
                f"Expected {what} {_in(target)} or a unit of its kind, got '{text.strip()}'.{turns}"
            )
        return value * source.size / target_unit.size
    words = set(re.findall(r"\b[^\W\d]\w*", text)) - {*FUNCTIONS, *CONSTANTS, "deg", "rad"}
    if words:
        raise ExpressionError(
            f"Expected a number for {what}, such as 0.3, 2*pi or 75 deg, got '{text.strip()}'."
        )
    return parse(text, {})


def _in(target: str) -> str:
    return "as a pure number" if target == "1" else f"in {target}"
