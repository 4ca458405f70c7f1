"""The pendulum of any amplitude.

    theta'' + rate² sin(theta) = 0,      rate² = m g d / I_O

d is the distance of the mass centre from the pivot, I_O the moment of inertia about it: a simple pendulum has
rate² = g / L, a uniform bar hung at its end rate² = 3 g / (2 L).

Sources: Landau and Lifshitz, *Mechanics*, 3rd ed., section 11, problem 1; *NIST Handbook of Mathematical
Functions*, section 22.19(i).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ModelError


def pendulum_period(amplitude: float, rate: float) -> float:
    """Exact period of an oscillation: T = 4 K(k²) / rate, k = sin(amplitude / 2).

    Parameters
    ----------
    amplitude : float
        Largest angle from the downward vertical, 0 to pi, pi excluded [rad].
    rate : float
        Circular frequency of the small oscillation [rad/s].

    Returns
    -------
    float
        Period [s]; 2 pi / rate at zero amplitude.

    Raises
    ------
    ModelError
        If the amplitude is outside [0, pi).

    Examples
    --------
    >>> round(pendulum_period(1.5707963267948966, 1.0), 10)
    7.4162987092
    """
    from scipy.special import ellipkm1

    if not 0 <= amplitude < np.pi:
        raise ModelError(f"Expected an amplitude from 0 to pi, pi excluded, got {amplitude:g} rad.")
    return 4 * float(ellipkm1(np.cos(amplitude / 2) ** 2)) / rate


def pendulum(amplitude: float, rate: float, t: Any) -> tuple[np.ndarray, np.ndarray]:
    """Angle and rate of a pendulum released from rest at ``amplitude``.

    With k = sin(amplitude / 2)::

        sin(theta / 2) = k cd(rate t | k²),    theta' = -2 k rate sqrt(1 - k²) sd(rate t | k²)

    Parameters
    ----------
    amplitude : float
        Angle of release from the downward vertical, -pi to pi, both excluded [rad].
    rate : float
        Circular frequency of the small oscillation [rad/s].
    t : float or array-like, shape (...)
        Time [s].

    Returns
    -------
    theta, theta_rate : ndarray, shape (...)
        [rad], [rad/s]

    Raises
    ------
    ModelError
        If the amplitude is outside (-pi, pi).
    """
    from scipy.special import ellipj

    if not abs(amplitude) < np.pi:
        raise ModelError(f"Expected an amplitude between -pi and pi, both excluded, got {amplitude:g} rad.")
    k = np.sin(amplitude / 2)
    sn, cn, dn, _ = ellipj(rate * np.asarray(t, dtype=float), k**2)
    theta = 2 * np.arcsin(np.clip(k * cn / dn, -1.0, 1.0))
    return theta, -2 * k * rate * np.cos(amplitude / 2) * sn / dn
