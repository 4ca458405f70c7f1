"""Heavy symmetric top about a fixed point: the public functions; :mod:`freebody.exact.nutation` has the solution."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from ..errors import ModelError
from . import elliptic
from .nutation import Constants, Nutation, Sleeping


@dataclass(frozen=True, repr=False)
class TopPath:
    """Motion of a top; see :func:`freebody.exact.top`.

    Attributes
    ----------
    path : str
        ``"loop"`` (the precession reverses in every nutation), ``"cusp"`` (the precession stops at the upper
        limit), ``"wave"`` (the precession never stops), ``"steady"`` (theta constant), ``"sleeping"`` (always
        upright), ``"asymptotic"`` (approaches the upright for ever), ``"through the vertical"``,
        ``"plane swing"``, ``"plane rotation"`` (a pendulum that goes over the top).
    theta_min, theta_max : float
        Limits of theta [rad].
    period : float
        Time between two successive lowest points; ``inf`` for a sleeping or asymptotic top [s].
    psi_advance, phi_advance : float
        Increase of psi and phi in a period; ``nan`` if the period is infinite [rad].
    roots : tuple of float
        u_1 <= u_2 <= u_3, the roots of the cubic.
    modulus2, complementary : float
        k² and 1 - k².
    spin : float
        Omega [rad/s].
    """

    path: str
    theta_min: float
    theta_max: float
    period: float
    psi_advance: float
    phi_advance: float
    roots: tuple[float, float, float]
    modulus2: float
    complementary: float
    spin: float
    _motion: Any = field(compare=False)
    _psi0: float = field(compare=False)
    _phi0: float = field(compare=False)

    def __repr__(self) -> str:
        limits = f"{self.theta_min:g} to {self.theta_max:g} rad"
        return f"<top, {self.path}: theta from {limits}, period {self.period:g} s>"

    @property
    def precession_rate(self) -> float:
        """Mean rate of precession, psi_advance / period [rad/s]."""
        return self.psi_advance / self.period

    def theta(self, t: Any) -> np.ndarray:
        """Angle of the axis from the upward vertical at times ``t`` [rad].

        It is between 0 and pi. On a path exactly through the vertical (``"through the vertical"`` and the plane
        paths), however, theta continues smoothly below 0 or above pi, and psi does not jump.
        """
        return self._motion.theta(t)

    def theta_rate(self, t: Any) -> np.ndarray:
        """theta' at times ``t`` [rad/s]."""
        return self._motion.theta_rate(t)

    def psi(self, t: Any) -> np.ndarray:
        """Precession angle about the vertical at times ``t``, continuous [rad]."""
        return self._psi0 + self._motion.psi(t)

    def psi_rate(self, t: Any) -> np.ndarray:
        """psi' at times ``t`` [rad/s]."""
        return self._motion.rates(t)[0]

    def phi(self, t: Any) -> np.ndarray:
        """Spin angle relative to the line of nodes at times ``t``, continuous [rad]."""
        return self._phi0 + self._motion.phi(t)

    def phi_rate(self, t: Any) -> np.ndarray:
        """phi' = Omega - psi' cos(theta) at times ``t`` [rad/s]."""
        return self._motion.rates(t)[1]

    def quaternion(self, t: Any) -> np.ndarray:
        """Unit quaternion of :meth:`attitude`, scalar part first, shape (..., 4), continuous in t."""
        psi, phi = self._motion.halves(t)
        zero = np.zeros(np.shape(t))
        first = elliptic.turning(2, *psi, zero + self._psi0)
        last = elliptic.turning(2, *phi, zero + self._phi0)
        return elliptic.product(elliptic.product(first, elliptic.turning(0, self.theta(t))), last)

    def attitude(self, t: Any) -> np.ndarray:
        """R_NB = Rz(psi) Rx(theta) Rz(phi), z upward and along the axis, shape (..., 3, 3)."""
        return elliptic.matrix(self.quaternion(t))

    def axis(self, t: Any) -> np.ndarray:
        """Unit vector of the symmetry axis, inertial axes, z upward, shape (..., 3)."""
        theta, psi = self.theta(t), self.psi(t)
        sine = np.sin(theta)
        return np.stack([sine * np.sin(psi), -sine * np.cos(psi), np.cos(theta)], axis=-1)


def top(
    I_xi: float,
    I_zeta: float,
    mgL: float,
    theta0: float,
    spin: float,
    theta_rate0: float = 0.0,
    psi_rate0: float = 0.0,
    *,
    psi0: float = 0.0,
    phi0: float = 0.0,
) -> TopPath:
    """Motion of a heavy symmetric top about a fixed point, for any initial values, in closed form.

    The equations are in :mod:`freebody.exact.nutation`. Without spin the top is a spherical pendulum, and with
    psi' = 0 as well a plane pendulum.

    Parameters
    ----------
    I_xi, I_zeta : float
        Transverse and axial moment of inertia about the fixed point; I_zeta may be 0 (a thin rod) [kg m²].
    mgL : float
        Weight times distance of the mass centre from the fixed point, positive [N m].
    theta0 : float
        Angle of the axis from the upward vertical at t = 0, from 0 to pi [rad].
    spin : float
        Omega = phi' + psi' cos(theta): total angular velocity along the axis, constant [rad/s].
    theta_rate0, psi_rate0 : float
        theta' and psi' at t = 0; psi' has no meaning at theta0 = 0 and is not used there [rad/s].
    psi0, phi0 : float
        psi and phi at t = 0 [rad].

    Returns
    -------
    TopPath
        With ``theta(t)``, ``psi(t)``, ``phi(t)``, their rates, ``attitude(t)``, ``theta_min``, ``theta_max``,
        ``period``, ``path``...

    Raises
    ------
    ModelError
        If ``I_xi`` or ``mgL`` is not positive, ``I_zeta`` is negative, ``theta0`` is outside 0 to pi, or a
        number is not finite.

    Notes
    -----
    The data are treated as exact numbers, and the constants are computed from them to 100 digits. The motion is
    therefore accurate to about 1e-14 (times the total angle, for psi and phi) for the given doubles, near the
    sleeping top too. Doubles cannot represent the exact initial values of a motion that ends upright;
    :func:`asymptotic_top` gives this motion.

    References
    ----------
    Whittaker, *Analytical Dynamics*, sections 71 and 72; Goldstein et al., *Classical Mechanics*, section 5.7.

    Examples
    --------
    >>> motion = top(0.01308, 0.00216, 1.1772, theta0=1.0, spin=200.0)
    >>> motion
    <top, cusp: theta from 1 to 1.15715 rad, period 0.205636 s>
    >>> round(float(motion.theta(motion.period / 2)) - motion.theta_max, 12) + 0.0
    0.0
    >>> top(0.01308, 0.00216, 1.1772, theta0=1.0, spin=200.0, psi_rate0=-2.0).path
    'loop'
    """
    data = {
        "I_xi": I_xi, "I_zeta": I_zeta, "mgL": mgL, "theta0": theta0, "spin": spin,
        "theta_rate0": theta_rate0, "psi_rate0": psi_rate0,
    }  # fmt: skip
    _check(data)
    if float(theta0) == 0 and theta_rate0 == 0:
        a = I_zeta * spin / I_xi
        sleeping = Sleeping(a / 2, spin - a / 2)
        return TopPath(
            "sleeping",
            0.0,
            0.0,
            math.inf,
            math.nan,
            math.nan,
            *_sleeping_roots(I_xi, mgL, a),
            spin,
            sleeping,
            psi0,
            phi0,
        )
    constants = Constants.from_start(*(Fraction(float(value)) for value in data.values()))
    return _path(constants, spin, psi0, phi0)


def asymptotic_top(
    I_xi: float, I_zeta: float, mgL: float, spin: float, *, psi0: float = 0.0, phi0: float = 0.0
) -> TopPath:
    """Motion of a top that leaves the upright infinitely slowly and returns to it: the separatrix.

    alpha = beta, b = a: u_1 = a² / beta - 1, u_2 = u_3 = 1, u = u_1 + (1 - u_1) tanh²(tau). At t = 0 the axis is at its
    lowest point. Without spin the top is a plane pendulum that falls from the top and comes to rest there again.

    Parameters
    ----------
    I_xi, I_zeta, mgL, spin, psi0, phi0
        As in :func:`top`; ``|spin|`` below :func:`sleeping_spin`.

    Returns
    -------
    TopPath
        Its ``path`` is ``"asymptotic"``.

    Raises
    ------
    ModelError
        If the upright top is stable at this spin, or a number is impossible.

    References
    ----------
    Goldstein et al., *Classical Mechanics*, section 5.7; Whittaker, *Analytical Dynamics*, section 72.
    """
    _check({"I_xi": I_xi, "I_zeta": I_zeta, "mgL": mgL, "theta0": 1.0, "spin": spin})
    A, C, W, Omega = (Fraction(float(value)) for value in (I_xi, I_zeta, mgL, spin))
    a2, beta = (C * Omega / A) ** 2, 2 * W / A
    if a2 >= 2 * beta:
        least = 2 * math.sqrt(mgL * I_xi) / I_zeta
        raise ModelError(
            f"No motion leaves the upright position with a spin of {spin:g} rad/s: from {least:g} rad/s upwards "
            "the top sleeps. Spin slower, or ask top(..., theta0=0.0) for the sleeping top."
        )
    return _path(Constants.asymptotic(A, C, W, Omega), spin, psi0, phi0)


def _check(data: dict[str, float]) -> None:
    """Refuse data of a top that are impossible."""
    for name, value in data.items():
        if not math.isfinite(value):
            raise ModelError(f"Expected a finite number for {name}, got {value}.")
    if not data["I_xi"] > 0 or not data["I_zeta"] >= 0:
        raise ModelError(
            "Expected a positive transverse and an axial moment of inertia that is not negative, got "
            f"I_xi = {data['I_xi']:g}, I_zeta = {data['I_zeta']:g} kg m²."
        )
    if not data["mgL"] > 0:
        raise ModelError(
            f"Expected a positive moment mgL of the weight, got {data['mgL']:g} N m. Without weight the body is "
            "torque-free: exact.torque_free((I_xi, I_xi, I_zeta), w0). If the mass centre is "
            "on the other side of the fixed point, point the axis there: mgL positive, pi - theta0, and the "
            "opposite signs of theta_rate0 and spin."
        )
    if not 0 <= data["theta0"] <= math.pi:
        raise ModelError(
            f"Expected theta0, the angle from the upward vertical, between 0 and pi, got {data['theta0']:g} rad. "
            "If it is negative, change its sign and that of theta_rate0, and add pi to psi0 and to phi0; degrees "
            "need numpy.radians."
        )


def _sleeping_roots(I_xi: float, mgL: float, a: float) -> tuple[tuple[float, float, float], float, float]:
    third = a * a * I_xi / (2 * mgL) - 1
    low, middle, high = sorted((1.0, 1.0, third))
    return (low, middle, high), (middle - low) / (high - low or 1.0), (high - middle) / (high - low or 1.0)


def _path(constants: Constants, spin: float, psi0: float, phi0: float) -> TopPath:
    motion = Nutation(constants)
    u1, u2, u3 = (float(root) for root in constants.roots)
    return TopPath(
        path=motion.path,
        theta_min=motion.limits[0],
        theta_max=motion.limits[1],
        period=float(2 * motion.clock.exact_quarter),
        psi_advance=motion.advance(motion.psi_angle),
        phi_advance=motion.advance(motion.phi_angle),
        roots=(u1, u2, u3),
        modulus2=motion.functions.m,
        complementary=motion.functions.m1,
        spin=spin,
        _motion=motion,
        _psi0=psi0,
        _phi0=phi0,
    )
