"""Kepler's orbit, and the libration of a satellite that its gravity gradient holds.

    r = a (1 - e cos E),    E - e sin E = √(μ/a³) t                        from the nearest point, E = 0

About a circular orbit of the rate Ω, the pitch θ of a body with the moments I_1 (along the path), I_2 (across the
plane), I_3 (along the vertical) obeys I_2 θ'' + 3 Ω² (I_1 - I_3) sin θ cos θ = 0, so that a dumbbell swings at √3 Ω.

Sources: Goldstein, *Classical Mechanics*, 2nd ed., §3-8; Hughes, *Spacecraft Attitude Dynamics*, §9.2.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import ModelError
from .elementary import sqrt


class Kepler(NamedTuple):
    """Position x (to the nearest point), y [m] and velocity [m/s] in the plane of the orbit."""

    x: Any
    y: Any
    vx: Any
    vy: Any


def kepler_orbit(mu: float, a: float, e: float, t: Any) -> Kepler:
    """Position and velocity on an ellipse of the half axis a and eccentricity e, at the time t after the nearest point.

    Kepler's equation is solved by Newton's method to the last bit.

    Examples
    --------
    >>> around = kepler_orbit(1.0, 1.0, 0.5, 2 * np.pi)
    >>> round(float(around.x), 12), round(abs(float(around.y)), 12)
    (0.5, 0.0)
    """
    if not 0 <= e < 1:
        raise ModelError(f"Expected an eccentricity from 0 to 1, 1 excluded, got {e:g}.")
    rate = np.sqrt(mu / a**3)
    mean = rate * np.asarray(t, float)
    E = mean + e * np.sin(mean)
    for _ in range(64):  # quadratic from a start within e of the root; e near 1 takes the most
        E = E - (E - e * np.sin(E) - mean) / (1 - e * np.cos(E))
    b = a * np.sqrt(1 - e * e)
    turning = rate / (1 - e * np.cos(E))
    return Kepler(a * (np.cos(E) - e), b * np.sin(E), -a * np.sin(E) * turning, b * np.cos(E) * turning)


def libration_frequency(orbit_rate: Any, along: Any, across: Any, vertical: Any) -> Any:
    """Frequency of the small libration of a satellite in the plane of its circular orbit [rad/s].

    Parameters
    ----------
    orbit_rate : number or expression
        Ω [rad/s].
    along, across, vertical
        Moments of inertia about the path, the normal of the plane and the vertical [kg m²].

    Examples
    --------
    >>> round(float(libration_frequency(1.0, 1.0, 1.0, 0.0)), 12)
    1.732050807569
    """
    return orbit_rate * sqrt(3 * (along - vertical) / across)
