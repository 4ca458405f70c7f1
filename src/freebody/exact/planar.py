"""Planar machines of the chapter, by Lagrange's equations and force balances written out by hand.

x to the right, y up; angles from the downward vertical, counter-clockwise positive; bars slender and uniform.

Sources: Examples 6.2 and 6.5 and Problem 6.15 of the chapter (with its figures as interpreted in the project's
specification); every formula below is derived here, not copied.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .elementary import sqrt


@dataclass(frozen=True)
class HingedBar:
    """Answers of Example 6.2.

    Attributes
    ----------
    alpha : float
        Angular acceleration just after release, clockwise [rad/s²].
    reaction_start : float
        Vertical reaction on the bar just after release, up [N].
    omega_vertical : float
        Angular velocity when the bar is first vertical, clockwise [rad/s].
    reaction_vertical : float
        Vertical reaction on the bar when it is vertical, up [N].
    energy_vertical : float
        Kinetic energy when the bar is vertical [J].
    """

    alpha: float
    reaction_start: float
    omega_vertical: float
    reaction_vertical: float
    energy_vertical: float


def hinged_bar(m: float, L: float, g: float = 9.81) -> HingedBar:
    """Motion and reaction of a uniform bar hinged at a third of its length, released from rest when horizontal.

    I_O = m L² / 12 + m (L / 6)² = m L² / 9, so alpha = (m g L / 6) / I_O = 3 g / (2 L), and the mass centre
    starts to fall with g / 4. From the energy, omega² = 3 g / L when the centre is L / 6 below the hinge.

    Parameters
    ----------
    m, L, g : float
        Mass [kg], length [m], gravity [m/s²].

    Returns
    -------
    HingedBar

    References
    ----------
    Chapter, Example 6.2.

    Examples
    --------
    >>> bar = hinged_bar(m=4.0, L=1.0, g=10.0)
    >>> bar.alpha, bar.reaction_start, bar.reaction_vertical
    (15.0, 30.0, 60.0)
    """
    return HingedBar(
        alpha=3 * g / (2 * L),
        reaction_start=3 * m * g / 4,
        omega_vertical=sqrt(3 * g / L),
        reaction_vertical=3 * m * g / 2,
        energy_vertical=m * g * L / 6,
    )


@dataclass(frozen=True)
class CartAndBar:
    """Accelerations and forces of Example 6.5.

    Attributes
    ----------
    x_acceleration, theta_acceleration : ndarray
        [m/s²], [rad/s²]
    hinge : ndarray, shape (..., 2)
        Force of the bar on the particle M, components x, y [N].
    ground : ndarray
        Force of the guide on M, positive up [N].
    energy : ndarray
        Kinetic plus potential energy of spring and weight, which is zero at x = 0 with the bar's centre at the
        height of the guide [J].
    """

    x_acceleration: Any
    theta_acceleration: Any
    hinge: Any
    ground: Any
    energy: Any


def cart_and_bar(
    x: Any,
    theta: Any,
    x_rate: Any,
    theta_rate: Any,
    *,
    M: float = 2.0,
    m: float = 1.0,
    a: float = 0.5,
    k: float = 50.0,
    F: float = 3.0,
    g: float = 9.81,
) -> CartAndBar:
    """Accelerations and forces of a guided particle on a spring with a hanging bar of length 2 a.

    A force F to the right acts at the lower end of the bar. The bar's centre is at (x + a sin(theta), -a cos(theta))
    and its central moment of inertia is m a² / 3::

        (M + m) x'' + m a (theta'' cos(theta) - theta'² sin(theta)) + k x = F
        m a x'' cos(theta) + (4/3) m a² theta'' + m g a sin(theta) = 2 a F cos(theta)

    The force of the bar on M follows from M x'' = -k x + X and from the bar's vertical balance; the guide
    carries the remaining weight.

    Parameters
    ----------
    x, theta, x_rate, theta_rate : float or array-like, shape (...)
        [m], [rad], [m/s], [rad/s]
    M, m, a, k, F, g : float
        [kg], [kg], [m], [N/m], [N], [m/s²]

    Returns
    -------
    CartAndBar

    References
    ----------
    Chapter, Example 6.5, eqs (a) to (f).
    """
    s, c = np.sin(theta), np.cos(theta)
    force = F - k * x + m * a * theta_rate**2 * s
    moment = 2 * F * c - m * g * s  # the second equation divided by a
    # Cramer on [[M + m, m c], [m c, 4 m / 3]] (x'', a theta'')
    determinant = (M + m) * 4 * m / 3 - (m * c) ** 2
    x_acc = (force * 4 * m / 3 - m * c * moment) / determinant
    theta_acc = ((M + m) * moment - m * c * force) / (determinant * a)
    rise = a * (theta_acc * s + theta_rate**2 * c)  # y'' of the bar's centre
    hinge = np.stack(np.broadcast_arrays(M * x_acc + k * x, -m * (g + rise)), axis=-1)
    ground = M * g + m * (g + rise)
    kinetic = (M + m) * x_rate**2 / 2 + m * a * x_rate * theta_rate * c + 2 * m * a**2 * theta_rate**2 / 3
    return CartAndBar(x_acc, theta_acc, hinge, ground, kinetic + k * x**2 / 2 - m * g * a * c)


@dataclass(frozen=True)
class DoublePendulum:
    """Accelerations and forces of two hanging bars.

    Attributes
    ----------
    accelerations : ndarray, shape (..., 2)
        theta_1'', theta_2'' [rad/s²].
    support : ndarray, shape (..., 2)
        Force of the support on link 1 at O, components x, y [N].
    joint : ndarray, shape (..., 2)
        Force of link 1 on link 2 at J, components x, y [N].
    energy : ndarray
        Kinetic plus potential energy, with heights measured from O [J].
    """

    accelerations: Any
    support: Any
    joint: Any
    energy: Any


def double_pendulum(
    theta1: Any,
    theta2: Any,
    theta1_rate: Any,
    theta2_rate: Any,
    *,
    m1: float = 2.0,
    m2: float = 1.0,
    L1: float = 0.8,
    L2: float = 0.6,
    g: float = 9.81,
) -> DoublePendulum:
    """Accelerations and forces of two uniform links in series, with absolute angles (Problem 6.15).

    With d = theta_1 - theta_2::

        (m_1/3 + m_2) L_1² theta_1'' + (m_2 L_1 L_2 / 2) (theta_2'' cos d + theta_2'² sin d)
            + (m_1/2 + m_2) g L_1 sin(theta_1) = 0
        (m_2/3) L_2² theta_2'' + (m_2 L_1 L_2 / 2) (theta_1'' cos d - theta_1'² sin d)
            + (m_2/2) g L_2 sin(theta_2) = 0

    The pin forces are F_J = m_2 (a_C2 - g) and F_O = m_1 (a_C1 - g) + F_J.

    Parameters
    ----------
    theta1, theta2, theta1_rate, theta2_rate : float or array-like, shape (...)
        [rad], [rad/s]
    m1, m2, L1, L2, g : float
        [kg], [kg], [m], [m], [m/s²]

    Returns
    -------
    DoublePendulum

    References
    ----------
    Chapter, Problem 6.15; Landau and Lifshitz, *Mechanics*, section 5, problem 1, for point masses.
    """
    s1, c1, s2, c2 = np.sin(theta1), np.cos(theta1), np.sin(theta2), np.cos(theta2)
    s, c = np.sin(np.subtract(theta1, theta2)), np.cos(np.subtract(theta1, theta2))
    A, B, D = (m1 / 3 + m2) * L1**2, m2 * L1 * L2 / 2, m2 * L2**2 / 3
    Q1 = -B * theta2_rate**2 * s - (m1 / 2 + m2) * g * L1 * s1
    Q2 = B * theta1_rate**2 * s - m2 * g * L2 * s2 / 2
    determinant = A * D - (B * c) ** 2
    acc1 = (D * Q1 - B * c * Q2) / determinant
    acc2 = (A * Q2 - B * c * Q1) / determinant
    # second derivatives of the vector from the upper pin of each link to its end
    end1 = np.stack([L1 * (acc1 * c1 - theta1_rate**2 * s1), L1 * (acc1 * s1 + theta1_rate**2 * c1)], axis=-1)
    end2 = np.stack([L2 * (acc2 * c2 - theta2_rate**2 * s2), L2 * (acc2 * s2 + theta2_rate**2 * c2)], axis=-1)
    up = np.array([0.0, g])
    joint = m2 * (end1 + end2 / 2 + up)
    support = m1 * (end1 / 2 + up) + joint
    energy = (
        A * theta1_rate**2 / 2
        + B * c * theta1_rate * theta2_rate
        + D * theta2_rate**2 / 2
        - (m1 / 2 + m2) * g * L1 * c1
        - m2 * g * L2 * c2 / 2
    )
    return DoublePendulum(np.stack([acc1, acc2], axis=-1), support, joint, energy)


def double_pendulum_frequencies(
    *, m1: float = 2.0, m2: float = 1.0, L1: float = 0.8, L2: float = 0.6, g: float = 9.81
) -> tuple[float, float]:
    """Circular frequencies of the small oscillations of :func:`double_pendulum`, the lower first [rad/s].

    Roots of (A D - B²) w⁴ - (A k_2 + D k_1) w² + k_1 k_2 = 0 with A = (m_1/3 + m_2) L_1²,
    B = m_2 L_1 L_2 / 2, D = m_2 L_2² / 3, k_1 = (m_1/2 + m_2) g L_1, k_2 = m_2 g L_2 / 2.
    """
    A, B, D = (m1 / 3 + m2) * L1**2, m2 * L1 * L2 / 2, m2 * L2**2 / 3
    k1, k2 = (m1 / 2 + m2) * g * L1, m2 * g * L2 / 2
    # discriminant (A k_2 + D k_1)² - 4 (A D - B²) k_1 k_2 as a sum of squares
    root = np.hypot(A * k2 - D * k1, 2 * B * np.sqrt(k1 * k2))
    high = (A * k2 + D * k1 + root) / (2 * (A * D - B**2))
    low = k1 * k2 / ((A * D - B**2) * high)
    return float(np.sqrt(low)), float(np.sqrt(high))
