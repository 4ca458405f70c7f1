"""Rotors: whirl of a Jeffcott rotor, swing of a gyrocompass, a gyroscopic monorail car, for numbers or expressions.

Sources: Genta, *Dynamics of Rotating Systems*, section 2.4; Magnus, *Kreisel: Theorie und Anwendungen*, chapter 14.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .elementary import arctan2, cos, sin, sqrt


class Whirl(NamedTuple):
    """Radius of the whirl [m], its angle behind the mass centre [rad], torque on the shaft [N m]."""

    radius: Any
    lag: Any
    torque: Any


def jeffcott(m: Any, e: Any, k: Any, d: Any, omega: Any) -> Whirl:
    """Steady whirl of a disk on a flexible shaft that turns at omega; its mass centre is at e from the shaft.

    With z = x + i y, m z'' + d z' + k z = m e ω² exp(i ω t) has z = r exp(i (ω t - δ))::

        r = m e ω² / |k - m ω² + i d ω|,    δ = arg(k - m ω² + i d ω)

    and the damping dissipates the power d (r ω)², which the torque d ω r² supplies.

    Examples
    --------
    >>> round(float(jeffcott(5.0, 2e-4, 2e5, 60.0, 200.0).radius), 12)
    0.003333333333
    """
    stiff, loss = k - m * omega**2, d * omega
    square = stiff**2 + loss**2
    radius = m * e * omega**2 / sqrt(square)
    return Whirl(radius, arctan2(loss, stiff), d * omega * (m * e * omega**2) ** 2 / square)


def jeffcott_start(m: float, e: float, k: float, d: float, omega: float, t: Any) -> tuple[Any, Any]:
    """Deflection x, y of the rotor of :func:`jeffcott` at time t, from rest without deflection.

    It is the whirl and two decaying terms exp(s t), m s² + d s + k = 0, which cancel the whirl at t = 0.
    """
    Z = m * e * omega**2 / complex(k - m * omega**2, d * omega)
    s_1, s_2 = np.roots([m, d, k]).astype(complex)
    # Z + a + b = 0, i ω Z + s_1 a + s_2 b = 0
    a = Z * (s_2 - 1j * omega) / (s_1 - s_2)
    b = -Z - a
    z = Z * np.exp(1j * omega * np.asarray(t)) + a * np.exp(s_1 * t) + b * np.exp(s_2 * t)
    return z.real, z.imag


def gyrocompass(theta: Any, theta_rate: Any, *, M: Any, c: Any, H: Any, I_T: Any, horizontal: Any) -> Any:
    """Acceleration θ'' of a gyrocompass at the angle theta from north.

        M θ'' + c θ' + H w sin(θ) - I_T w² sin(θ) cos(θ) = 0

    w is the horizontal component of the angular velocity of the Earth, H the spin momentum, I_T the transverse moment
    of inertia of the rotor, M the moment of inertia of rotor and ring about the vertical.

    Returns
    -------
    theta'' [rad/s²]
    """
    pull = H * horizontal * sin(theta) - I_T * horizontal**2 * sin(theta) * cos(theta)
    return -(c * theta_rate + pull) / M


def monorail(
    y: Any, m_C: Any, h: Any, I_C: Any, m_R: Any, a: Any, I_S: Any, I_T: Any, h_G: Any, Omega: Any, g: Any
) -> tuple[Any, Any]:
    """Accelerations of a car on one rail and of its gimbal, from Lagrange's equations.

    With z = h_G + a cos θ and J(θ) = I_C + m_C h² + m_R z² + I_T cos²θ + I_S sin²θ::

        J φ'' + J' θ' φ' + I_S Ω cos(θ) θ' = g sin(φ) (m_C h + m_R z)
        (m_R a² + I_T) θ'' - J' φ'²/2 - I_S Ω cos(θ) φ' = m_R g a sin(θ) cos(φ)

    Parameters
    ----------
    y : roll of the car, pitch of the gimbal [rad] and their rates [rad/s]
    m_C, h, I_C : mass, height of the mass centre, moment of inertia of the car
    m_R, a, I_S, I_T : rotor: mass, height above the gimbal's axis, moments about and across its axis
    h_G, Omega, g : height of the gimbal's axis, speed of the rotor in the gimbal, gravity
    """
    phi, theta, roll, pitch = y
    s, c = sin(theta), cos(theta)
    z = h_G + a * c
    J = I_C + m_C * h**2 + m_R * z**2 + I_T * c**2 + I_S * s**2
    slope = -2 * m_R * z * a * s + 2 * (I_S - I_T) * s * c
    toppling = g * sin(phi) * (m_C * h + m_R * z)
    rolling = (toppling - slope * pitch * roll - I_S * Omega * c * pitch) / J
    gyro = slope * roll**2 / 2 + I_S * Omega * c * roll
    return rolling, (m_R * g * a * s * cos(phi) + gyro) / (m_R * a**2 + I_T)


def monorail_speed(m_C: Any, h: Any, I_C: Any, m_R: Any, a: Any, I_S: Any, I_T: Any, h_G: Any, g: Any) -> Any:
    """Smallest speed of the rotor that keeps the car of :func:`monorail` upright: I_S Ω >= sqrt(A k) + sqrt(B W).

    A φ'' + H θ' - W φ = 0 and B θ'' - H φ' - k θ = 0 give A B s⁴ + (H² - A k - B W) s² + W k = 0, whose roots s² are
    negative if H² - A k - B W >= 2 sqrt(A B W k).
    """
    A = I_C + m_C * h**2 + I_T + m_R * (h_G + a) ** 2
    B, k = I_T + m_R * a**2, m_R * g * a
    W = g * (m_C * h + m_R * (h_G + a))
    return sqrt(A * k + B * W + 2 * sqrt(A * B * W * k)) / I_S
