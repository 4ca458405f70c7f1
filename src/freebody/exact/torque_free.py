"""Bodies that turn about the mass centre without torque.

    H = I_1 w_1 e_1 + I_2 w_2 e_2 + I_3 w_3 e_3 = const.        I_1 w_1' = (I_2 - I_3) w_2 w_3, and cyclic

Sources: section 6.8 of the chapter, eqs (6.77) to (6.84); L. D. Landau, E. M. Lifshitz, *Mechanics*, 3rd ed.,
sections 33, 36 and 37; F. W. J. Olver et al., *NIST Handbook of Mathematical Functions*, chapter 22.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, overload

import numpy as np

from ..errors import ModelError
from .elliptic import matrix as rotation_matrix
from .elliptic import quaternion as quaternion_of
from .rigid_body import TorqueFreeMotion, solution


@dataclass(frozen=True)
class SymmetricMotion:
    """Motion of a torque-free symmetric body; body axes and inertial axes coincide at t = 0.

    Attributes
    ----------
    rate : float
        Rate Omega at which the angular velocity turns about axis 3 as seen from the body, positive from axis 1
        to axis 2 [rad/s].
    alpha, beta : float
        Angle between axis 3 and H, and between axis 3 and the angular velocity [rad].
    body_cone, space_cone : float
        Half angles of the cones that the angular velocity draws in the body (about axis 3) and in space
        (about H) [rad]; the body cone rolls on the space cone.
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


@overload
def torque_free(I: Any, w0: Any, t: None = None, *, attitude: Any = None) -> TorqueFreeMotion: ...  # noqa: E741
@overload
def torque_free(I: Any, w0: Any, t: Any, *, attitude: Any = None) -> np.ndarray: ...  # noqa: E741
def torque_free(I: Any, w0: Any, t: Any = None, *, attitude: Any = None) -> TorqueFreeMotion | np.ndarray:  # noqa: E741
    """Motion of any rigid body about its mass centre without torque, in closed form.

    Two equal moments give body and space cones. Three different moments give Jacobi's elliptic functions for the
    angular velocity and an elliptic integral of the third kind for the turn about H; on the separatrix the functions
    are hyperbolic. The equations are in :mod:`freebody.exact.rigid_body`.

    Parameters
    ----------
    I : array-like, shape (3,) or (3, 3)
        Principal moments of inertia about the mass centre, in any order, equal ones included; or the inertia
        matrix in body axes, which is diagonalized [kg m²].
    w0 : array-like, shape (3,)
        Angular velocity at t = 0, body axes (the principal axes if moments are given) [rad/s].
    t : float or array-like, shape (...), optional
        Times [s]: the result is then ``torque_free(I, w0).angular_velocity(t)``.
    attitude : array-like, shape (3, 3) or (4,), optional
        R_NB at t = 0, or its unit quaternion, scalar part first. Default: body axes and inertial axes
        coincide.

    Returns
    -------
    TorqueFreeMotion
        With ``angular_velocity(t)``, ``attitude(t)``, ``quaternion(t)``, ``polhode()``, ``herpolhode(t)``,
        ``cones``, ``period``...; if ``t`` is given, ndarray, shape (..., 3): the angular velocity in
        body axes [rad/s].

    Raises
    ------
    ModelError
        If a moment of inertia is not positive, the inertia matrix is not symmetric, the angular velocity does
        not have three finite components, or the attitude is not a rotation.

    Notes
    -----
    The data are treated as exact numbers, and the constants that determine the period are computed from them to 100
    digits. The motion is therefore accurate to about 1e-14 for the given doubles, however near to the separatrix, and
    the error does not grow with time. (The motion itself may depend strongly on the data: near the separatrix the
    period grows as log(1/(1 - k²)).) Principal moments of a full matrix that are equal within round-off are treated
    as equal.

    References
    ----------
    Landau and Lifshitz, *Mechanics*, 3rd ed., section 37; Whittaker, *Analytical Dynamics*, sections 69-71.

    Examples
    --------
    A body thrown to turn about its middle axis turns over again and again:

    >>> motion = torque_free((1.0, 2.0, 3.0), (0.0, 2.0, 1e-3))
    >>> motion
    <torque-free triaxial motion: I = (1, 2, 3) kg m², w0 = (0, 2, 0.001) rad/s, period 29.2297 s>
    >>> motion.angular_velocity([0.0, motion.period / 2]).round(6).tolist()
    [[0.0, 2.0, 0.001], [-0.0, -2.0, 0.001]]
    >>> motion.attitude(0.0).round(6).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]

    The cones of a coin that wobbles twice as fast as it turns:

    >>> cones = torque_free((1.0, 1.0, 2.0), (0.01, 0.0, 5.0)).cones
    >>> round(cones.rate, 3), round(cones.precession_rate, 3)
    (5.0, 10.0)
    """
    matrix = np.asarray(I, dtype=float)
    if matrix.shape == (3, 3):
        moments, axes = _principal(matrix)
    elif matrix.shape == (3,):
        moments, axes = matrix, np.eye(3)
    else:
        raise ModelError(
            f"Expected three principal moments of inertia or a 3 x 3 inertia matrix, got shape {matrix.shape}."
        )
    _check(moments)
    w = np.asarray(w0, dtype=float)
    if w.shape != (3,) or not np.isfinite(w).all():
        raise ModelError(
            f"Expected three finite components of the angular velocity w0 in body axes, got {w0!r}."
        )
    start = _unit_quaternion(attitude)
    along = axes.T @ w
    if not np.array_equal(axes, np.eye(3)):
        along[abs(along) <= 4 * np.finfo(float).eps * np.linalg.norm(w)] = 0.0  # round-off of the axes
    parts = solution(moments, along)
    motion = TorqueFreeMotion(
        kind=parts.kind,
        moments=moments,
        axes=axes,
        w0=w,
        energy=float(moments @ along**2) / 2,
        momentum=rotation_matrix(start) @ (axes @ (moments * along)),
        period=parts.period,
        precession_per_period=parts.precession_per_period,
        modulus2=parts.modulus2,
        complementary=parts.complementary,
        _solution=parts,
        _start=start,
    )
    return motion if t is None else motion.angular_velocity(t)


def _principal(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal moments and axes (columns, right-handed) of an inertia matrix; a diagonal one keeps its axes."""
    size = float(abs(inertia).max())
    if not np.isfinite(inertia).all() or abs(inertia - inertia.T).max() > 1e-12 * size:
        raise ModelError(
            "Expected a symmetric 3 x 3 inertia matrix of finite numbers, got one with a largest difference of "
            f"{abs(inertia - inertia.T).max():g} kg m² across its diagonal. Products of inertia come in equal pairs, "
            "-sum(m x y); use (I + I.T) / 2 if the difference is noise."
        )
    if np.array_equal(inertia, np.diag(np.diag(inertia))):
        return np.diag(inertia).copy(), np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    noise = 16 * np.finfo(float).eps * size
    if moments[2] - moments[0] <= noise:
        moments[:] = moments.mean()
    elif moments[1] - moments[0] <= noise:
        moments[:2] = moments[:2].mean()
    elif moments[2] - moments[1] <= noise:
        moments[1:] = moments[1:].mean()
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    return moments, axes


def _unit_quaternion(attitude: Any) -> np.ndarray:
    """The unit quaternion of an attitude given as a matrix or quaternion; the identity for None."""
    if attitude is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    R = np.asarray(attitude, dtype=float)
    if R.shape == (4,) and abs(np.linalg.norm(R) - 1) < 1e-9:
        return R / np.linalg.norm(R)
    if R.shape == (3, 3) and abs(R.T @ R - np.eye(3)).max() < 1e-9 and np.linalg.det(R) > 0:
        return quaternion_of(R)
    raise ModelError(
        "Expected the attitude at t = 0 as a rotation matrix R_NB, shape (3, 3), or a unit quaternion, shape "
        f"(4,), scalar part first; got {R.tolist()}. Normalize the quaternion; a matrix must have "
        "orthonormal columns and the determinant +1."
    )


def _check(moments: Any) -> None:
    if not all(moment > 0 for moment in moments):
        listed = ", ".join(f"{moment:g}" for moment in moments)
        raise ModelError(f"Expected three positive principal moments of inertia, got ({listed}) kg m².")


def _turn(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotation matrices about a fixed unit axis (Rodrigues): 1 + sin(angle) [a] + (1 - cos(angle)) [a]²."""
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    sine, versine = np.sin(angle)[..., None, None], 2 * np.sin(angle / 2)[..., None, None] ** 2
    return np.eye(3) + sine * cross + versine * (cross @ cross)
