"""Bodies that turn by internal forces: reaction wheel, control moment gyroscope, yo-yo, cat, damper.

The formulas, for numbers or symbols, follow from the conservation of momentum.

Sources: Wie, *Space Vehicle Dynamics and Control*, 2nd ed., chapter 7; for the yo-yo, Eide and Vaughan, *Equations of
motion and design criteria for the despin of a vehicle by the radial release of weights and cables*, NASA TN D-1012
(1962).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .elementary import arccos, cos, sin, sqrt

PI = 3.141592653589793


class WheelTurn(NamedTuple):
    """Angle [rad], greatest rates of satellite and wheel [rad/s], work of the motor in the first half [J]."""

    angle: Any
    body_rate: Any
    wheel_rate: Any
    work: Any


def wheel_turn(I_B: Any, I_W: Any, T: Any, tau: Any, pi: Any = PI) -> WheelTurn:
    """Turn of a satellite from rest to rest by the torque T sin(2 π t / τ) of a wheel's motor.

        I_B θ' = (T τ / 2π) (1 - cos(2 π t / τ)),    θ(τ) = T τ² / (2 π I_B),    I_B θ' + I_W (θ' + φ') = 0

    Examples
    --------
    >>> round(wheel_turn(80.0, 0.05, 0.2, 60.0).angle, 6)
    1.432394
    """
    H = T * tau / pi
    return WheelTurn(H * tau / (2 * I_B), H / I_B, -H / I_B - H / I_W, H**2 / (2 * I_B) + H**2 / (2 * I_W))


class PlatformTurn(NamedTuple):
    """Initial acceleration [rad/s²]; rate [rad/s] and torque of the gimbal's motor [N m] at an angle of the gimbal."""

    start: Any
    rate: Any
    motor: Any


def platform_turn(I_P: Any, I_S: Any, I_T: Any, Omega: Any, nu: Any, delta: Any) -> PlatformTurn:
    """Turn of a free platform with a rotor whose axis is at the angle delta, with the rate nu, from the horizontal.

    The momentum about the vertical is zero::

        (I_P + I_T cos²δ + I_S sin²δ) θ' + I_S Ω sin δ = 0

    and the torque of the motor is the component of ω × H of the rotor about the gimbal's axis, where in axes of the
    gimbal ω = (ν, θ' sin δ, θ' cos δ), H = (I_T ν, I_S (Ω + θ' sin δ), I_T θ' cos δ).

    Parameters
    ----------
    I_P : platform about the vertical; I_S, I_T : rotor about and across its axis [kg m²]
    Omega, nu : speed of the rotor in the gimbal, rate of the gimbal [rad/s]
    delta : [rad]
    """
    s, c = sin(delta), cos(delta)
    rate = -I_S * Omega * s / (I_P + I_T * c**2 + I_S * s**2)
    motor = rate * s * I_T * rate * c - rate * c * I_S * (Omega + rate * s)
    return PlatformTurn(-I_S * Omega * nu / (I_P + I_T), rate, motor)


class Despin(NamedTuple):
    """Length of cord that stops the spin [m]; time [s], spin [rad/s] and tension of a cord [N] at a free length."""

    length: Any
    time: Any
    spin: Any
    tension: Any


def yo_yo(I: Any, R: Any, m: Any, omega: Any, length: Any) -> Despin:  # noqa: E741
    """Despin of a drum of radius R and moment of inertia I by two masses m on cords that unwind from it.

    ``omega`` is the spin ω_0 before. With C = 1 + I / (2 m R²) and the unwound angle φ, energy and momentum give::

        C (ω² - ω_0²) + φ² (ω + φ')² = 0,    C (ω - ω_0) + φ² (ω + φ') = 0

    so that φ' = ω_0 and ω = ω_0 (C - φ²) / (C + φ²); the tension follows from I ω' = -2 F R.

    Parameters
    ----------
    I, R, m, omega : [kg m²], [m], [kg], [rad/s]
    length : free length of cord R φ [m]
    """
    C, phi = 1 + I / (2 * m * R**2), length / R
    slowing = 4 * C * phi * omega**2 / (C + phi**2) ** 2
    return Despin(R * sqrt(C), phi / omega, omega * (C - phi**2) / (C + phi**2), I * slowing / (2 * R))


def cat_turn(J: Any, K: Any, alpha: Any, pi: Any = PI) -> Any:
    """Angle by which a bent cat turns when it rolls its two halves once about their spines [rad].

    Along the line that bisects the bend, the momentum of the turn 2 (J cos²α + K sin²α) ψ' and that of the rolls
    -2 J φ' cos α add up to zero; φ grows to 2 π.

    Parameters
    ----------
    J, K : moments of inertia of each half about its spine and across it, at the waist [kg m²]
    alpha : angle of each spine from that line [rad]

    References
    ----------
    Kane and Scher, *A dynamical explanation of the falling cat phenomenon*, Int. J. Solids Structures 5 (1969).
    """
    return 2 * pi * J * cos(alpha) / (J * cos(alpha) ** 2 + K * sin(alpha) ** 2)


def cat_bend(J: Any, K: Any) -> Any:
    """Bend alpha for which the cat of :func:`cat_turn` makes half a turn [rad].

    The root of (K - J) cos²α + 2 J cos α - K = 0 between 0 and 1: cos α = K / (J + sqrt(J² + K² - J K)).

    Examples
    --------
    >>> round(float(cat_turn(0.015, 0.05, cat_bend(0.015, 0.05))), 9)
    3.141592654
    """
    return arccos(K / (J + sqrt(J**2 + K**2 - J * K)))


def sink_rates(
    w: Any, ball: Any, I_1: float, I_2: float, I_3: float, I_D: float, c: float
) -> tuple[list[float], list[float]]:
    """Rates of the angular velocities of a body and of a ball in a viscous fluid inside it, in axes of the body.

        I ω' + ω × I ω = c (σ - ω),    I_D (σ' + ω × σ) = -c (σ - ω)

    Parameters
    ----------
    w, ball : angular velocities ω of the body and σ of the ball [rad/s]
    I_1, I_2, I_3, I_D : principal moments of the body, moment of the ball [kg m²]
    c : drag [N m s/rad]
    """
    moments = (I_1, I_2, I_3)
    body_rate, ball_rate = [], []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        drag = c * (ball[i] - w[i])
        body_rate.append((drag - (moments[k] - moments[j]) * w[j] * w[k]) / moments[i])
        ball_rate.append(-drag / I_D - (w[j] * ball[k] - w[k] * ball[j]))
    return body_rate, ball_rate
