"""Machines with two planar degrees of freedom: an airfoil section; folding links with a mass and two springs.

Source: chapter, Problems 6.14 and 6.16.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .elementary import cos, sin, sqrt


class Airfoil(NamedTuple):
    """Frequencies [rad/s] and amplitude ratios X / Θ [m/rad] of the two mode shapes, the slower first."""

    frequencies: tuple[Any, Any]
    ratios: tuple[Any, Any]


def airfoil(m: Any, I_E: Any, s: Any, k_x: Any, k_theta: Any) -> Airfoil:
    """Frequencies and mode shapes of a section whose mass centre is at the distance s from its elastic axis.

    The plunge x and the pitch θ are small::

        m x'' + m s θ'' + k_x x = 0,    m s x'' + I_E θ'' + k_θ θ = 0

    so that m (I_E - m s²) ω⁴ - (k_x I_E + k_θ m) ω² + k_x k_θ = 0 and, from the second equation,
    X / Θ = (k_θ / ω² - I_E) / (m s).

    Examples
    --------
    >>> [round(float(x), 9) for x in airfoil(10.0, 0.9, 0.1, 4000.0, 200.0).ratios]
    [0.1, -0.5]
    """
    lead, middle = m * (I_E - m * s**2), k_x * I_E + k_theta * m
    root = sqrt(middle**2 - 4 * lead * k_x * k_theta)
    squares = ((middle - root) / (2 * lead), (middle + root) / (2 * lead))
    # 1 / ω² = (middle ± root) / (2 k_x k_θ), the product of the roots being k_x k_θ / lead
    inverses = ((middle + root) / (2 * k_x * k_theta), (middle - root) / (2 * k_x * k_theta))
    slow, fast = ((k_theta * inverse - I_E) / (m * s) for inverse in inverses)
    return Airfoil((sqrt(squares[0]), sqrt(squares[1])), (slow, fast))


def airfoil_motion(
    m: float, I_E: float, s: float, k_x: float, k_theta: float, x: float, theta: float, t: Any
) -> tuple[Any, Any]:
    """Displacement and rotation at time t after a release from rest at ``x`` and ``theta``: the sum of both modes.

    x = Σ r_i a_i cos(ω_i t), θ = Σ a_i cos(ω_i t), where r_1 a_1 + r_2 a_2 and a_1 + a_2 are the initial values.
    """
    (w_1, w_2), (r_1, r_2) = airfoil(m, I_E, s, k_x, k_theta)
    a_1 = (x - r_2 * theta) / (r_1 - r_2)
    a_2 = theta - a_1
    first, second = a_1 * np.cos(w_1 * t), a_2 * np.cos(w_2 * t)
    return r_1 * first + r_2 * second, first + second


def folding_links(
    x: Any, theta: Any, theta_rate: Any, m: Any, L: Any, M: Any, k_1: Any, k_2: Any, g: Any
) -> tuple[Any, Any]:
    """Accelerations x'', theta'' of two links that fold below a line, with a mass and two springs.

    With T = (m L²)(4/3 - cos²θ) θ'² + M x'²/2 and V = -m g L sin θ + k_1 (2 L (1 - cos θ) - x)²/2 + k_2 x²/2::

        M x'' = k_1 (2 L (1 - cos θ) - x) - k_2 x
        2 m L² ((4/3 - cos²θ) θ'' + sin θ cos θ θ'²) = m g L cos θ - 2 L k_1 sin θ (2 L (1 - cos θ) - x)

    Each link has the moment m L²/12 about its centre; the centres are at (L/2, 3L/2) cos θ and -(L/2) sin θ.

    Parameters
    ----------
    x : displacement of the mass to the left [m]
    theta, theta_rate : angle of each link below the horizontal, and its rate [rad], [rad/s]
    m, L, M, k_1, k_2, g : [kg], [m], [kg], [N/m], [N/m], [m/s²]
    """
    s, c = sin(theta), cos(theta)
    stretch = 2 * L * (1 - c) - x
    turning = m * g * L * c - 2 * L * k_1 * s * stretch - 2 * m * L**2 * s * c * theta_rate**2
    # multiplied by 3 to avoid the fraction 4/3: exact for symbols too
    return (k_1 * stretch - k_2 * x) / M, 3 * turning / (2 * m * L**2 * (4 - 3 * c**2))


def folding_equilibrium(m: float, L: float, k_1: float, k_2: float, g: float) -> tuple[float, float]:
    """Equilibrium x, theta of the machine of :func:`folding_links`, with 0 <= theta < 90 degrees.

    With x = 2 L (1 - cos θ) k_1 / (k_1 + k_2) there remains 4 k L (1 - cos θ) tan θ = m g, 1/k = 1/k_1 + 1/k_2. The
    left side grows from 0 without bound, so there is exactly one root.
    """
    from scipy.optimize import brentq

    k = k_1 * k_2 / (k_1 + k_2)
    theta = brentq(
        lambda u: 4 * k * L * (1 - np.cos(u)) * np.sin(u) - m * g * np.cos(u), 0, np.pi / 2, xtol=1e-15
    )
    return 2 * L * (1 - np.cos(theta)) * k_1 / (k_1 + k_2), theta
