"""A body that falls from rest through a fluid, for numbers, arrays or SymPy expressions.

    m v' = m g - k v²:    v = v_t tanh(g t/v_t),       y = (v_t²/g) ln cosh(g t/v_t),      v_t² = m g/k
    m v' = m g - c v:     v = v_t (1 - exp(-g t/v_t)), y = v_t t - (v_t/g) v,               v_t = m g/c

Source: Landau & Lifshitz, Fluid Mechanics, §20 (Stokes' formula); separation of variables for both.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .elementary import cosh, exp, log, tanh


class Fall(NamedTuple):
    """Speed [m/s] and distance [m] after the time t."""

    speed: Any
    distance: Any


def fall_with_drag(terminal: Any, g: Any, t: Any) -> Fall:
    """Fall from rest against quadratic drag, with the terminal speed √(m g/k).

    Examples
    --------
    >>> round(float(fall_with_drag(50.0, 9.81, 1e3).speed), 12)
    50.0
    """
    x = g * t / terminal
    return Fall(terminal * tanh(x), terminal**2 / g * log(cosh(x)))


def fall_in_syrup(terminal: Any, g: Any, t: Any) -> Fall:
    """Fall from rest against Stokes' linear drag, with the terminal speed m g/c.

    Examples
    --------
    >>> round(float(fall_in_syrup(2.0, 9.81, 1e3).speed), 12)
    2.0
    """
    v = terminal * (1 - exp(-g * t / terminal))
    return Fall(v, terminal * t - terminal / g * v)
