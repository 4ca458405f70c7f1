"""Gyroscope and heavy symmetric top about a fixed point: steady precession, release from rest, small oscillation.

    I_xi theta'' + psi' sin(theta) (I_zeta Omega - I_xi psi' cos(theta)) = m g L sin(theta)
    I_xi psi' sin²(theta) + I_zeta Omega cos(theta) = const.,      phi' + psi' cos(theta) = Omega = const.

theta is the angle from the upward vertical to the symmetry axis, psi the precession about the vertical, Omega
the total angular velocity along the symmetry axis.

Sources: sections 6.9 and 6.10 of the chapter, eqs (6.95) to (6.117); Landau and Lifshitz, *Mechanics*,
3rd ed., section 35; H. Goldstein et al., *Classical Mechanics*, 3rd ed., section 5.7; *NIST Handbook of
Mathematical Functions*, sections 19.25 and 22.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ModelError
from .elementary import cos, sin, sqrt, symbolic


def gyroscope_moments(m: float, R: float, L: float) -> tuple[float, float]:
    """Moments of inertia of a thin disk on a massless shaft, about the pivot on the shaft.

    I_xi = m R² / 4 + m L²,  I_zeta = m R² / 2

    Parameters
    ----------
    m, R, L : float
        Mass [kg] and radius [m] of the disk, distance of its centre from the pivot [m].

    Returns
    -------
    I_xi, I_zeta : float
        Transverse and axial moment of inertia about the pivot [kg m²].
    """
    return m * R**2 / 4 + m * L**2, m * R**2 / 2


def least_spin(I_xi: Any, I_zeta: Any, mgL: Any, theta: Any) -> Any:
    """Smallest \\|Omega\\| for which a steady precession at ``theta`` exists (its two rates are then equal).

    Omega² >= 4 m g L I_xi cos(theta) / I_zeta²; below the horizontal (theta >= pi/2) any spin is enough.

    Parameters
    ----------
    I_xi, I_zeta : float
        Transverse and axial moment of inertia about the pivot [kg m²].
    mgL : float
        Weight times distance of the mass centre from the pivot [N m].
    theta : float
        Angle of the shaft from the upward vertical [rad].

    Returns
    -------
    float
        [rad/s]

    References
    ----------
    Chapter, eq. (6.100).
    """
    cosine = cos(theta)
    if not symbolic(cosine):
        cosine = max(0.0, float(cosine))
    return 2 * sqrt(mgL * I_xi * cosine) / I_zeta


def sleeping_spin(I_xi: Any, I_zeta: Any, mgL: Any) -> Any:
    """Smallest \\|Omega\\| at which the upright top is stable: 2 sqrt(m g L I_xi) / I_zeta [rad/s].

    References
    ----------
    Goldstein et al., *Classical Mechanics*, section 5.7, eq. (5.80); chapter, section 6.10 (sleeping top).
    """
    return least_spin(I_xi, I_zeta, mgL, 0)


def steady_precession(I_xi: Any, I_zeta: Any, mgL: Any, theta: Any, spin: Any) -> tuple[Any, Any]:
    """Fast and slow rate of steady precession, the roots of I_xi cos(theta) w² - I_zeta Omega w + m g L = 0.

    Parameters
    ----------
    I_xi, I_zeta, mgL, theta
        As in :func:`least_spin`.
    spin : float
        Omega, total angular velocity along the symmetry axis, not zero; a symbol is taken to be positive [rad/s].

    Returns
    -------
    fast, slow : float
        [rad/s]. The fast rate of a horizontal shaft is infinite.

    Raises
    ------
    ModelError
        If the spin is below :func:`least_spin`.

    References
    ----------
    Chapter, eqs (6.98) and (6.99).
    """
    if symbolic(I_xi, I_zeta, mgL, theta, spin):
        half = (I_zeta * spin + sqrt((I_zeta * spin) ** 2 - 4 * mgL * I_xi * cos(theta))) / 2
        return half / (I_xi * cos(theta)), mgL / half
    if spin == 0 or abs(spin) < least_spin(I_xi, I_zeta, mgL, theta):
        least = least_spin(I_xi, I_zeta, mgL, theta)
        raise ModelError(
            f"No steady precession at theta = {theta:g} rad with a spin of {spin:g} rad/s: the spin must be "
            f"at least {least:g} rad/s (and not zero). Spin faster, or lower the shaft."
        )
    cosine = float(np.cos(theta))
    # both terms have the same sign, so that the slow rate is accurate at high spin
    half = I_zeta * spin * (1 + np.sqrt(max(0.0, 1 - 4 * mgL * I_xi * cosine / (I_zeta * spin) ** 2))) / 2
    slow = mgL / half
    fast = half / (I_xi * cosine) if cosine else np.inf * np.sign(spin)
    return float(fast), float(slow)


@dataclass(frozen=True)
class TopMotion:
    """Nutation of a top released from rest.

    Attributes
    ----------
    theta_max : float
        Largest angle reached [rad].
    period : float
        Time between successive smallest (or largest) angles [s].
    theta, psi, phi : ndarray, shape (...)
        Euler angles ZXZ at the given times; psi = phi = 0 at t = 0 [rad].
    theta_rate, psi_rate, phi_rate : ndarray, shape (...)
        Their rates [rad/s].
    """

    theta_max: float
    period: float
    theta: np.ndarray
    psi: np.ndarray
    phi: np.ndarray
    theta_rate: np.ndarray
    psi_rate: np.ndarray
    phi_rate: np.ndarray


def top_from_rest(
    I_xi: float, I_zeta: float, mgL: float, theta0: float, spin: float, t: Any = 0.0
) -> TopMotion:
    """Motion of a top whose shaft is released from rest (theta' = psi' = 0) at ``theta0``.

    With u = cos(theta), a = I_zeta Omega / I_xi, b = 2 m g L / I_xi::

        u'² = b (u_0 - u) (u - u_1) (u_2 - u),    psi' = a (u_0 - u) / (1 - u²)
        u_1, u_2 = s -+ sqrt(s² - 2 s u_0 + 1),  s = a² / (2 b);    u = u_1 + (u_0 - u_1) cd²(tau | k²)
        tau = t sqrt(b (u_2 - u_1)) / 2,  k² = (u_0 - u_1) / (u_2 - u_1),  period = 4 K / sqrt(b (u_2 - u_1))

    psi and phi are elliptic integrals of the third kind, in Carlson's form.

    Parameters
    ----------
    I_xi, I_zeta, mgL
        As in :func:`least_spin`; mgL positive.
    theta0 : float
        Angle at which the shaft is released, between 0 and pi, both excluded [rad].
    spin : float
        Omega, total angular velocity along the symmetry axis [rad/s].
    t : float or array-like, shape (...)
        Time [s].

    Returns
    -------
    TopMotion

    Raises
    ------
    ModelError
        If ``theta0`` is not inside (0, pi) or ``mgL`` is not positive.

    Notes
    -----
    The error is about 1e-15 (1 + number of nutations). At zero spin the shaft passes through the downward vertical,
    where psi jumps by pi: theta stays in [0, pi] and psi is reported as 0.

    References
    ----------
    Landau and Lifshitz, *Mechanics*, section 35; *NIST Handbook*, eqs 19.25.14 and 22.13.1.
    """
    if not 0 < theta0 < np.pi:
        raise ModelError(f"Expected theta0 between 0 and pi (both are equilibria), got {theta0:g} rad.")
    if not mgL > 0:
        raise ModelError(f"Expected a positive moment mgL of the weight, got {mgL:g} N m.")
    from scipy.special import ellipj, ellipk

    t = np.asarray(t, dtype=float)
    u0 = float(np.cos(theta0))
    a, b = I_zeta * spin / I_xi, 2 * mgL / I_xi
    s = a**2 / (2 * b)
    # s² - 2 s u_0 + 1 = (s - u_0)² + sin²(theta_0): a sum of squares
    root = float(np.hypot(s - u0, np.sin(theta0)))
    u2 = s + root
    u1 = (2 * s * u0 - 1) / u2 if u2 else -1.0  # u_1 u_2 = 2 s u_0 - 1: no cancellation at high spin
    fall = (np.sin(theta0) ** 2) / (u2 - u0)  # u_0 - u_1, from b (u_0 - u_1)(u_2 - u_0) = b (1 - u_0²)
    m = fall / (fall + (u2 - u0))
    p = float(np.sqrt(b * (fall + u2 - u0))) / 2
    K = float(ellipk(m))

    tau = p * t + K  # sn(tau + K) = cd(tau)
    turns = np.round(tau / (2 * K))
    sn, cn, dn, amplitude = ellipj(tau - 2 * K * turns, m)
    drop = fall * cn**2  # u_0 - u
    u = u0 - drop
    # 1 - u² from its factors, kept positive against round-off
    sine = np.sqrt(np.maximum((1 - u) * (1 + u), 0.0))
    u_rate = 2 * p * fall * sn * cn * dn
    if spin == 0:
        psi = np.zeros_like(t)
        psi_rate = np.zeros_like(t)
        phi, phi_rate = np.zeros_like(t), np.zeros_like(t)
        theta_rate = -np.sign(u_rate) * np.sqrt(b * drop)
    else:
        theta_rate = -u_rate / sine
        psi_rate = a * drop / sine**2
        phi_rate = spin - psi_rate * u
        # J_1 = integral of dt / (1 - u), J_2 of dt / (1 + u), from the release
        J1 = _third_kind(fall / (1 - u1), m, turns, amplitude) / ((1 - u1) * p)
        J2 = _third_kind(-fall / (1 + u1), m, turns, amplitude) / ((1 + u1) * p)
        psi = a / 2 * ((1 + u0) * J2 - (1 - u0) * J1)
        phi = spin * t - a * (t - (1 - u0) / 2 * J1 - (1 + u0) / 2 * J2)
    return TopMotion(
        theta_max=float(np.arccos(max(-1.0, u1))),
        period=2 * K / p,
        theta=np.arctan2(sine, u),
        psi=psi,
        phi=phi,
        theta_rate=theta_rate,
        psi_rate=psi_rate,
        phi_rate=phi_rate,
    )


def _third_kind(n: float, m: float, turns: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
    """Integral of 1 / (1 - n sn²) from K to 2 K turns + F(amplitude)."""
    from scipy.special import elliprf, elliprj

    def incomplete(angle: Any) -> Any:  # NIST 19.25.14
        s, c = np.sin(angle), np.cos(angle)
        d = 1 - m * s**2
        return s * elliprf(c**2, d, 1.0) + n / 3 * s**3 * elliprj(c**2, d, 1.0, 1 - n * s**2)

    return (2 * turns - 1) * incomplete(np.pi / 2) + incomplete(amplitude)


@dataclass(frozen=True)
class PrecessionResponse:
    """Small oscillation about a steady precession.

    Attributes
    ----------
    frequency : float
        Circular frequency of the nutation [rad/s].
    theta, psi : ndarray, shape (...)
        Angles, psi = 0 at t = 0 [rad].
    """

    frequency: Any
    theta: Any
    psi: Any


def precession_response(
    I_xi: float,
    I_zeta: float,
    mgL: float,
    theta0: float,
    spin: float,
    w_xi: float = 0.0,
    w_eta: float = 0.0,
    t: Any = 0.0,
    fast: bool = False,
) -> PrecessionResponse:
    """Small oscillation about steady precession after a small change of the angular velocity.

    With the steady rate psi_0' and c = I_zeta Omega / I_xi - 2 psi_0' cos(theta_0)::

        theta_1'' + (psi_0' sin(theta_0))² theta_1 + c sin(theta_0) psi_1' = 0
        sin(theta_0) psi_1'' = c theta_1'
        frequency² = (psi_0' sin(theta_0))² + c²

    Parameters
    ----------
    I_xi, I_zeta, mgL, theta0, spin
        As in :func:`steady_precession`; ``theta0`` not 0 or pi.
    w_xi, w_eta : float
        Changes of the angular velocity at t = 0: theta'(0) = w_xi, psi'(0) = psi_0' + w_eta / sin(theta_0)
        [rad/s].
    t : float or array-like, shape (...)
        Time [s].
    fast : bool
        If true, about the fast precession instead of the slow.

    Returns
    -------
    PrecessionResponse
        Its error is of second order in ``w_xi`` and ``w_eta``.

    References
    ----------
    Chapter, eqs (6.112) to (6.117), derived here from (6.96).
    """
    t = np.asarray(t, dtype=float)
    steady = steady_precession(I_xi, I_zeta, mgL, theta0, spin)[0 if fast else 1]
    c = I_zeta * spin / I_xi - 2 * steady * float(np.cos(theta0))
    return small_oscillation(steady, c, theta0, w_xi, w_eta, t)


def small_oscillation(rate: Any, c: Any, theta0: Any, w_xi: Any, w_eta: Any, t: Any) -> PrecessionResponse:
    """Oscillation of :func:`precession_response` from the steady rate and its constant c, for numbers or symbols.

    In terms of the rate alone, c = m g L / (I_xi psi_0') - psi_0' cos(theta_0).
    """
    sine = sin(theta0)
    w = sqrt((rate * sine) ** 2 + c**2)
    center = -c * w_eta / w**2
    theta1 = w_xi / w * sin(w * t) + center * (1 - cos(w * t))
    integral = w_xi / w**2 * (1 - cos(w * t)) + center * (t - sin(w * t) / w)
    psi = rate * t + (w_eta * t + c * integral) / sine
    return PrecessionResponse(frequency=w, theta=theta0 + theta1, psi=psi)
