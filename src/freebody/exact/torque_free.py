"""Bodies that turn with no torque about the mass centre.

    H = I_1 w_1 e_1 + I_2 w_2 e_2 + I_3 w_3 e_3 = const.        I_1 w_1' = (I_2 - I_3) w_2 w_3, and cyclic

Sources: section 6.8 of the chapter, eqs (6.77) to (6.84); L. D. Landau, E. M. Lifshitz, *Mechanics*, 3rd ed.,
sections 33, 36 and 37; F. W. J. Olver et al., *NIST Handbook of Mathematical Functions*, chapter 22.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ellipj, ellipkinc

from ..errors import ModelError


@dataclass(frozen=True)
class SymmetricMotion:
    """Motion of a torque-free symmetric body; body axes and inertial axes coincide at t = 0.

    Attributes
    ----------
    rate : float
        Rate Omega at which the angular velocity turns about axis 3 as seen from the body, + from axis 1
        to axis 2 [rad/s].
    alpha, beta : float
        Angle between axis 3 and H, and between axis 3 and the angular velocity [rad].
    body_cone, space_cone : float
        Semi-angles of the cone the angular velocity draws in the body (about axis 3) and in space
        (about H) [rad]; the first rolls on the second.
    precession_rate : float
        Rate at which axis 3 turns about H [rad/s].
    momentum : ndarray, shape (3,)
        Angular momentum H in inertial axes [kg m²/s].
    omega : ndarray, shape (..., 3)
        Angular velocity, components in body axes [rad/s].
    attitude : ndarray, shape (..., 3, 3)
        R_NB: takes components in body axes to inertial axes; its third column is axis 3.
    """

    rate: float
    alpha: float
    beta: float
    body_cone: float
    space_cone: float
    precession_rate: float
    momentum: np.ndarray
    omega: np.ndarray
    attitude: np.ndarray


def torque_free_symmetric(I1: float, I3: float, w1: float, w3: float, t: Any = 0.0) -> SymmetricMotion:
    """Torque-free motion of a body with I_1 = I_2, from the angular velocity (w1, 0, w3) at t = 0.

    Omega = (I_3 - I_1) w_3 / I_1,   w = H / I_1 - Omega e_3,   R_NB = exp(H^ |H| t / I_1) exp(-e_3 Omega t):
    the body turns about the fixed H at |H| / I_1 and about its own axis at -Omega.

    Parameters
    ----------
    I1, I3 : float
        Moments of inertia about a transverse axis and about the symmetry axis 3 [kg m²].
    w1, w3 : float
        Components of the angular velocity at t = 0 along axes 1 and 3 [rad/s].
    t : float or array-like, shape (...)
        Time [s].

    Returns
    -------
    SymmetricMotion

    Raises
    ------
    ModelError
        If a moment of inertia is not positive.

    References
    ----------
    Section 6.8 of the chapter, eqs (6.79), (6.80), (6.83); Landau and Lifshitz, *Mechanics*, section 33.
    """
    _check((I1, I1, I3))
    t = np.asarray(t, dtype=float)
    rate = (I3 - I1) * w3 / I1
    momentum = np.array([I1 * w1, 0.0, I3 * w3])
    size = float(np.hypot(I1 * w1, I3 * w3))
    alpha = float(np.arctan2(I1 * abs(w1), I3 * w3))
    beta = float(np.arctan2(abs(w1), w3))
    zero = np.zeros_like(t)
    omega = np.stack([w1 * np.cos(rate * t), w1 * np.sin(rate * t), w3 + zero], axis=-1)
    direction = momentum / size if size else np.array([0.0, 0.0, 1.0])
    attitude = _turn(direction, size / I1 * t) @ _turn(np.array([0.0, 0.0, 1.0]), -rate * t)
    return SymmetricMotion(
        rate=rate,
        alpha=alpha,
        beta=beta,
        body_cone=min(beta, np.pi - beta),
        space_cone=abs(alpha - beta),
        precession_rate=size / I1,
        momentum=momentum,
        omega=omega,
        attitude=attitude,
    )


def torque_free(moments: Any, w0: Any, t: Any) -> np.ndarray:
    """Angular velocity of any torque-free rigid body, by Jacobi's elliptic functions.

    With axes 1, 2, 3 relabelled so that I_2 is the middle moment and H² lies between 2 T I_2 and 2 T I_3::

        w_1 = a cn(tau),  w_2 = b sn(tau),  w_3 = c dn(tau),  tau = p t + tau_0
        a² = A / (I_1 (I_3 - I_1)),  b² = A / (I_2 (I_3 - I_2)),  c² = B / (I_3 (I_3 - I_1)),
        A = 2 T I_3 - H²,  B = H² - 2 T I_1,  p² = (I_3 - I_2) B / (I_1 I_2 I_3),
        modulus k² = (I_2 - I_1) A / ((I_3 - I_2) B)

    Parameters
    ----------
    moments : array-like, shape (3,)
        Principal moments of inertia about the mass centre, in any order, equal ones included [kg m²].
    w0 : array-like, shape (3,)
        Angular velocity at t = 0, components along the principal axes [rad/s].
    t : float or array-like, shape (...)
        Time [s].

    Returns
    -------
    ndarray, shape (..., 3)
        Angular velocity, components along the principal axes of the body [rad/s].

    Raises
    ------
    ModelError
        If a moment of inertia is not positive.

    Notes
    -----
    Relative error about 1e-15 / (1 - k²): near the separatrix (rotation about the middle axis) the period
    itself depends on the initial state as log(1 - k²), and no formula in doubles does better.

    References
    ----------
    Landau and Lifshitz, *Mechanics*, section 37, eqs (37.8) to (37.10).
    """
    moments = np.asarray(moments, dtype=float)
    w0 = np.asarray(w0, dtype=float)
    _check(moments)
    t = np.asarray(t, dtype=float)
    order = np.argsort(moments, kind="stable")
    # H² - 2 T I_2 without cancellation of the large terms: the sign tells which extreme axis w circles
    low, mid, high = order
    circles_high = moments[high] * (moments[high] - moments[mid]) * w0[high] ** 2
    circles_low = moments[low] * (moments[mid] - moments[low]) * w0[low] ** 2
    one, two, three = (low, mid, high) if circles_high >= circles_low else (high, mid, low)
    (I1, I2, I3), (w1, w2, w3) = moments[[one, two, three]], w0[[one, two, three]]

    A = I1 * (I3 - I1) * w1**2 + I2 * (I3 - I2) * w2**2  # 2 T I_3 - H²
    B = I2 * (I2 - I1) * w2**2 + I3 * (I3 - I1) * w3**2  # H² - 2 T I_1
    omega = np.broadcast_to(w0, (*t.shape, 3)).copy()
    # rotation about a principal axis is steady, and so is any axis between two equal moments
    if np.count_nonzero(w0) < 2 or A == 0 or B == 0 or I3 == I2:
        return omega
    a = np.sqrt(A / (I1 * (I3 - I1)))
    b = np.sqrt(A / (I2 * (I3 - I2)))
    c = np.sqrt(B / (I3 * (I3 - I1)))
    p = np.sqrt((I3 - I2) * B / (I1 * I2 * I3))
    m = min(1.0, (I2 - I1) * A / ((I3 - I2) * B))
    # I_2 w_2' = e (I_3 - I_1) w_3 w_1, with e = +1 when (1, 2, 3) are in right-handed order
    handed = 1 if (one, two, three) in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) else -1
    side = 1.0 if w3 >= 0 else -1.0
    sign = handed * np.sign(I3 - I1) * side
    tau = p * t + ellipkinc(np.arctan2(sign * w2 / b, w1 / a), m)
    sn, cn, dn, _ = ellipj(tau, m)
    omega[..., one] = a * cn
    omega[..., two] = sign * b * sn
    omega[..., three] = side * c * dn
    return omega


def _check(moments: Any) -> None:
    if not all(moment > 0 for moment in moments):
        listed = ", ".join(f"{moment:g}" for moment in moments)
        raise ModelError(f"Expected three positive principal moments of inertia, got ({listed}) kg m².")


def _turn(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotation matrices about a fixed unit axis (Rodrigues): 1 + sin(angle) [a] + (1 - cos(angle)) [a]²."""
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    sine, versine = np.sin(angle)[..., None, None], 2 * np.sin(angle / 2)[..., None, None] ** 2
    return np.eye(3) + sine * cross + versine * (cross @ cross)
