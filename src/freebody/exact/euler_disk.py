"""Euler's disk: a thin disk that rolls on a plane and becomes flatter and faster.

e1 is horizontal in the plane of the disk, e2 points from the foot P up to the centre C, and e3 is the axle. The disk
makes the angle θ with the plane. With its rate ψ' about the vertical Z = sin θ e2 + cos θ e3 and its spin φ',

    ω = θ' e1 + ψ' sin θ e2 + (φ' + ψ' cos θ) e3,     v_C = R (ω1 e3 - ω3 e1)        (no slip)

and the balances of momentum and of angular momentum about C are written out below. Friction slows the foot on its way
around the rim: a horizontal couple with the power -c φ'² (viscous friction of the contour).

Source of the steady motion and of the energy argument: Moffatt, Nature 404 (2000) 833-834; derived here independently.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .elementary import cos, log, sin, sqrt


def euler_disk_turn(R: Any, theta: Any, g: Any = 9.81) -> Any:
    """Rate ψ' of the steady motion about a centre at rest [rad/s]: m R²/4 ψ'² sin θ cos θ = m g R cos θ for any mass.

    Examples
    --------
    >>> float(euler_disk_turn(1.0, 3.14159265358979 / 2, g=9.0))
    6.0
    """
    return 2 * sqrt(g / (R * sin(theta)))


def euler_disk_energy(m: Any, R: Any, theta: Any, g: Any = 9.81) -> Any:
    """Energy of the steady motion [J]: m g R sin θ + (m R²/4) (ψ' sin θ)²/2."""
    return 3 * m * g * R * sin(theta) / 2


def euler_disk_end(m: Any, R: Any, c: Any, theta: Any) -> Any:
    """Time in which friction dissipates the energy of the steady motion, from θ to 0 [s]; ψ' is then infinite.

    3/2 m g R cos θ θ' = -c (ψ' cos θ)²  =>  cos θ grows as exp(8 c t/(3 m R²)). The centre is assumed to stay at rest,
    which holds up to terms of order θ².

    Examples
    --------
    >>> from math import acos, exp
    >>> round(float(euler_disk_end(3.0, 2.0, 1.5, acos(exp(-1)))), 12)
    3.0
    """
    return -3 * m * R**2 / (8 * c) * log(cos(theta))


@dataclass(frozen=True)
class RollingDisk:
    """Accelerations θ'', ψ'', φ'' [rad/s²], normal force and friction [N]."""

    accelerations: tuple[Any, Any, Any]
    normal: Any
    friction: Any


def rolling_disk(m: Any, R: Any, c: Any, state: tuple[Any, Any, Any, Any], g: Any = 9.81) -> RollingDisk:
    """Accelerations and forces of the disk in the state (θ, θ', ψ', φ').

    With the angular velocity Ω of the axes e and the force F at P, whose moment about C is -R e2 × F:

        m (v' + Ω × v) = F - m g Z,     H' + Ω × H = -R e2 × F + K,     H = (I ω1, I ω2, 2 I ω3),   I = m R²/4
    """
    theta, w1, turn, spin = state
    s, k = sin(theta), cos(theta)
    w2, across = turn * s, turn * k
    w3 = spin + across
    moment = m * R**2 / 4
    K3 = -c * spin
    K2 = -K3 * k / s  # K is horizontal
    w1_rate = (moment * w2 * (across - 2 * w3) - m * R * (R * w2 * w3 + g * k)) / (moment + m * R**2)
    w2_rate = (2 * w1 * w3) - across * w1 + K2 / moment
    w3_rate = (m * R**2 * w1 * w2 + K3) / (2 * moment + m * R**2)
    F1 = m * R * (w1 * w2 - w3_rate)
    F2 = m * (g * s - R * (across * w3 + w1**2))
    F3 = m * (g * k + R * (w1_rate + w2 * w3))
    turn_rate = (w2_rate - turn * k * w1) / s
    spin_rate = w3_rate - turn_rate * k + turn * s * w1
    return RollingDisk((w1_rate, turn_rate, spin_rate), F2 * s + F3 * k, sqrt(F1**2 + (F2 * k - F3 * s) ** 2))
