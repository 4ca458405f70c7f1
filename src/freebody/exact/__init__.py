"""Closed-form answers of the field, to check algorithms against. Nothing here imports an algorithm it checks.

torque-free bodies      :func:`torque_free_symmetric`, :func:`torque_free`
gyroscopes and tops     :func:`gyroscope_moments`, :func:`steady_precession`, :func:`least_spin`,
                        :func:`sleeping_spin`, :func:`top_from_rest`, :func:`precession_response`
planar machines         :func:`pendulum`, :func:`pendulum_period`, :func:`hinged_bar`, :func:`cart_and_bar`,
                        :func:`double_pendulum`, :func:`double_pendulum_frequencies`
"""

from __future__ import annotations

from .gyroscope import (
    PrecessionResponse,
    TopMotion,
    gyroscope_moments,
    least_spin,
    precession_response,
    sleeping_spin,
    steady_precession,
    top_from_rest,
)
from .planar import (
    CartAndBar,
    DoublePendulum,
    HingedBar,
    cart_and_bar,
    double_pendulum,
    double_pendulum_frequencies,
    hinged_bar,
)
from .swing import pendulum, pendulum_period
from .torque_free import SymmetricMotion, torque_free, torque_free_symmetric

__all__ = [
    "CartAndBar",
    "DoublePendulum",
    "HingedBar",
    "PrecessionResponse",
    "SymmetricMotion",
    "TopMotion",
    "cart_and_bar",
    "double_pendulum",
    "double_pendulum_frequencies",
    "gyroscope_moments",
    "hinged_bar",
    "least_spin",
    "pendulum",
    "pendulum_period",
    "precession_response",
    "sleeping_spin",
    "steady_precession",
    "top_from_rest",
    "torque_free",
    "torque_free_symmetric",
]
