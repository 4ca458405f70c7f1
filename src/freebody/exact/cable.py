"""A jump on a cable that goes slack, for numbers, arrays or SymPy expressions.

A mass falls freely by h to the length of the cable, and swings about the sag m g/k until the cable is slack again:

    t₁ = √(2 h/g),    v = √(2 g h),    ω = √(k/m)
    taut for 2/ω (π/2 + atan(m g ω/(k v))),    longest by m g/k + √((m g/k)² + (v/ω)²)
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .elementary import arctan2, sqrt


class CableJump(NamedTuple):
    """Times at which the cable becomes taut, slack and taut again [s], and its greatest stretch [m]."""

    taut: Any
    slack: Any
    again: Any
    stretch: Any


def cable_jump(mass: Any, stiffness: Any, fall: Any, gravity: Any) -> CableJump:
    """Jump from rest, with a free fall of the height h to the length of the cable.

    Examples
    --------
    >>> jump = cable_jump(70.0, 100.0, 19.0, 9.81)
    >>> [round(float(x), 5) for x in (jump.taut, jump.slack, jump.stretch)]
    [1.96815, 5.26919, 24.41983]
    """
    first = sqrt(2 * fall / gravity)
    speed, rate, sag = gravity * first, sqrt(stiffness / mass), mass * gravity / stiffness
    taut = 2 * arctan2(speed, -sag * rate) / rate
    return CableJump(first, first + taut, 3 * first + taut, sag + sqrt(sag**2 + (speed / rate) ** 2))
