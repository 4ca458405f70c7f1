"""A motor that starts an inertia through a gear, for numbers, arrays or SymPy expressions.

With the torque T_s - (T_s/ω_0) ω of a rotor J that turns n times as fast as the driven inertia I,

    (I + J n²) Ω' = n T_s (1 - n Ω/ω_0):    Ω = (ω_0/n) (1 - exp(-t/τ)),    τ = (I + J n²) ω_0/(n² T_s)
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .elementary import exp


class MotorStart(NamedTuple):
    """Rate [rad/s] and angle [rad] of the driven inertia at the time t, and the time constant τ [s]."""

    rate: Any
    angle: Any
    time: Any


def motor_start(
    stall_torque: Any, no_load_speed: Any, ratio: Any, rotor: Any, inertia: Any, t: Any
) -> MotorStart:
    """Start of a motor from rest.

    Examples
    --------
    >>> round(motor_start(0.5, 300.0, 50, 1e-4, 2.0, 0.0).time, 6)
    0.54
    """
    time = (inertia + rotor * ratio**2) * no_load_speed / (ratio**2 * stall_torque)
    last = no_load_speed / ratio
    rate = last * (1 - exp(-t / time))
    return MotorStart(rate, last * t - time * rate, time)
