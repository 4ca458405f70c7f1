"""Steady turn of the single-track car with tyres of small slip, for numbers, arrays or SymPy expressions.

The lateral forces are C_F α_F and C_R α_R, with α_F = δ - (v + a r)/V and α_R = (b r - v)/V. With L = a + b,

    C_F α_F + C_R α_R = m V r,        a C_F α_F = b C_R α_R

    r = V δ/(L + η V²/g),        η/g = m (b C_R - a C_F)/(L C_F C_R),        v = (b - a m V²/(L C_R)) r

Source: Pacejka, Tyre and Vehicle Dynamics (2006), eqs (1.37) to (1.41).
"""

from __future__ import annotations

from typing import Any, NamedTuple


class SteadyTurn(NamedTuple):
    """Yaw rate r [rad/s], side speed v of the mass centre [m/s], and understeer η/g [rad s²/m]."""

    yaw_rate: Any
    side_speed: Any
    understeer: Any


def steady_turn(
    speed: Any, steer: Any, mass: Any, front: tuple[Any, Any], rear: tuple[Any, Any]
) -> SteadyTurn:
    """Turn at a speed V with a small steering angle δ of the front wheel.

    Parameters
    ----------
    front, rear : (distance from the mass centre [m], cornering stiffness of the axle [N/rad])

    Examples
    --------
    >>> neutral = steady_turn(20.0, 0.01, 1000.0, (1.0, 5e4), (1.0, 5e4))
    >>> neutral.yaw_rate, neutral.understeer  # V δ/L
    (0.1, 0.0)
    """
    (a, C_F), (b, C_R) = front, rear
    L = a + b
    understeer = mass * (b * C_R - a * C_F) / (L * C_F * C_R)
    yaw_rate = speed * steer / (L + understeer * speed**2)
    return SteadyTurn(yaw_rate, (b - a * mass * speed**2 / (L * C_R)) * yaw_rate, understeer)
