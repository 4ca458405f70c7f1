"""Bodies that fall in contact with corners, floors and cylinders, from energy and force balances by hand.

All bodies start from rest; bars are slender and uniform, disks uniform. Each function defines its angles.

Sources: Problems 6.7 to 6.11 of the chapter (with its figures as interpreted in the project's specification); every
formula below is derived here, not copied.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

from .elementary import arccos, arctan, cos, sin, sqrt, symbolic
from .swing import pendulum_period


@dataclass(frozen=True)
class BarInCylinder:
    """Answers of Problem 6.7.

    Rate [rad/s], angular acceleration [rad/s²], normal forces [N], frequency of small oscillation [rad/s].
    """

    rate: float
    alpha: float
    normal_A: float
    normal_B: float
    frequency: float


def bar_in_cylinder(m: float, R: float, theta_0: float, theta: float, g: float = 9.81) -> BarInCylinder:
    """Motion at θ, downwards, of a bar of length √2 R inside a smooth cylinder, released at θ_0.

    The angles are from the downward vertical.

    C is at R/√2 from the axis, I_O = m R² (1/6 + 1/2) = 2/3 m R², so θ'' = -(3/(2√2)) (g/R) sin θ and
    θ'² = (3/√2) (g/R) (cos θ - cos θ_0). The normal forces pass through the axis, at 45° to the line OC:

        (N_A + N_B)/√2 = m g cos θ + m R θ'²/√2,      (N_A - N_B)/√2 = m g sin θ + m R θ''/√2.

    Examples
    --------
    >>> abs(float(bar_in_cylinder(2, 1, 0.5, 0.5).rate))
    0.0
    """
    h = R / sqrt(2 * (R / R))  # exact where R is a symbol
    alpha = -m * g * h * sin(theta) / (2 * m * R**2 / 3)
    square = 2 * m * g * h * (cos(theta) - cos(theta_0)) / (2 * m * R**2 / 3)
    total = sqrt(2 * (R / R)) * (m * g * cos(theta) + m * h * square)
    difference = sqrt(2 * (R / R)) * (m * g * sin(theta) + m * h * alpha)
    return BarInCylinder(
        -sqrt(square),
        alpha,
        (total + difference) / 2,
        (total - difference) / 2,
        sqrt(3 * g / (2 * sqrt(2 * (R / R)) * R)),
    )


@dataclass(frozen=True)
class DiskOffLedge:
    """Answers of Problem 6.8.

    Angle from the vertical [rad], rate [rad/s], angular acceleration [rad/s²] and friction [N] when the disk leaves the
    corner; angular acceleration just after.
    """

    theta: float
    omega: float
    alpha: float
    friction: float
    alpha_after: float


def disk_off_ledge(m: float, R: float, g: float = 9.81) -> DiskOffLedge:
    """Motion of a disk that turns about the corner of a ledge from the top, without slip, until it leaves it.

    I_O = 3/2 m R²: θ'' = 2 g sin θ/(3 R), θ'² = 4 g (1 - cos θ)/(3 R);  N = m g cos θ - m R θ'² = 0 at cos θ =
    4/7, and T = m g sin θ - m R θ'' = m g sin θ/3. In flight no moment acts about the centre.

    Examples
    --------
    >>> round(float(cos(disk_off_ledge(1, 1).theta)) * 7, 12)
    4.0
    """
    root = sqrt(33 * (R / R))  # exact where R is a symbol; sin θ is a seventh of it
    alpha = 2 * g * root / (21 * R)
    return DiskOffLedge(arctan(root / 4), sqrt(4 * g / (7 * R)), alpha, m * g * root / 21, 0.0)


def disk_slips_on_ledge(mu: float) -> float:
    """Angle from the vertical at which the disk of `disk_off_ledge` begins to slip on its corner.

    T/N = sin θ/(7 cos θ - 4) = μ:  sin² = 1 - cos² gives  cos θ = (28 μ² + √(33 μ² + 1))/(49 μ² + 1).

    Examples
    --------
    >>> theta = disk_slips_on_ledge(0.5)
    >>> round(float(sin(theta) / (7 * cos(theta) - 4)), 12)
    0.5
    """
    c = (28 * mu**2 + sqrt(33 * mu**2 + 1)) / (49 * mu**2 + 1)
    return arctan(mu * (7 * c - 4) / c)


@dataclass(frozen=True)
class BarOnLedge:
    """Answers of Problem 6.9.

    Angle below the horizontal at which slip begins [rad], and rate [rad/s], normal force and friction [N] there.
    """

    theta: float
    omega: float
    normal: float
    friction: float


def bar_on_ledge(m: float, L: float, b: float, mu: float, g: float = 9.81) -> BarOnLedge:
    """Begin of slip of a bar that falls from the horizontal about the corner of a ledge.

    The corner is at the distance d = L/2 - b from the centre of the bar. With k² = L²/12 + d², θ'' = g d cos θ/k² and
    θ'² = 2 g d sin θ/k²:

        N = m g cos θ (1 - d²/k²),   T = m g sin θ (1 + 2 d²/k²),   T = μ N at tan θ = μ (L²/12)/(L²/12 + 3 d²).

    Examples
    --------
    >>> from math import tan
    >>> round(tan(float(bar_on_ledge(2, 1.2, 0.0, 0.4).theta)), 12)
    0.04
    """
    d = L / 2 - b
    k2 = L**2 / 12 + d**2
    theta = arctan(mu * (L**2 / 12) / (L**2 / 12 + 3 * d**2))
    return BarOnLedge(
        theta,
        sqrt(2 * g * d * sin(theta) / k2),
        m * g * cos(theta) * (1 - d**2 / k2),
        m * g * sin(theta) * (1 + 2 * d**2 / k2),
    )


@dataclass(frozen=True)
class DiskInCylinder:
    """Answers of Problem 6.10.

    Rate [rad/s] and angular acceleration [rad/s²] of the line of centres, normal force and magnitude of the friction
    [N], frequency of small oscillation [rad/s] and exact period [s].
    """

    rate: float
    alpha: float
    normal: float
    friction: float
    frequency: float
    period: float


def disk_in_cylinder(
    m: float, R: float, r: float, theta_0: float, theta: float, g: float = 9.81
) -> DiskInCylinder:
    """Motion at θ, downwards, of a disk that rolls inside a cylinder, released at θ_0.

    The angles of the line of centres are from the downward vertical.
    3/2 (R - r) θ'' = -g sin θ: a pendulum of length 3 (R - r)/2;  N = m g cos θ + m (R - r) θ'²,  |T| = m g |sin
    θ|/3.

    Examples
    --------
    >>> round(float(disk_in_cylinder(1, 3, 1, 0.5, 0.0, g=12.0).frequency), 12)
    2.0
    """
    d = R - r
    square = 4 * g * (cos(theta) - cos(theta_0)) / (3 * d)
    return DiskInCylinder(
        -sqrt(square),
        -2 * g * sin(theta) / (3 * d),
        m * g * cos(theta) + m * d * square,
        m * g * abs(sin(theta)) / 3,
        sqrt(2 * g / (3 * d)),
        nan if symbolic(theta_0) else pendulum_period(theta_0, sqrt(2 * g / (3 * d))),
    )


@dataclass(frozen=True)
class FallingBar:
    """Answers of Problem 6.11.

    Coefficient of friction, friction and normal force [N] and rate [rad/s] when the bar slips; the largest coefficient
    for which it slips in this direction, and the angle from the vertical then [rad].
    """

    mu: float
    friction: float
    normal: float
    omega: float
    mu_limit: float
    theta_limit: float


def falling_bar(m: float, L: float, angle: float, g: float = 9.81) -> FallingBar:
    """Begin of slip of a bar that falls from the vertical with its lower end on a rough floor.

    ``angle`` is the angle from the floor at which it slips. With θ from the vertical, θ'² = 3 g (1 - cos θ)/L:

        T = 3/4 m g sin θ (3 cos θ - 2),     N = 1/4 m g (1 - 3 cos θ)².

    T/N is largest, 15 √10/128, at cos θ = 9/11. For larger coefficients of friction the bar slips the other way, or
    does not slip before N = 0.

    Examples
    --------
    >>> from math import pi
    >>> round(float(falling_bar(2, 1.5, pi / 3).mu_limit) * 128 / 15, 12)
    3.162277660168
    """
    s, c = cos(angle), sin(angle)
    T = 3 * m * g * s * (3 * c - 2) / 4
    N = m * g * (1 - 3 * c) ** 2 / 4
    return FallingBar(
        T / N, T, N, sqrt(3 * g * (1 - c) / L), 15 * sqrt(10 * (L / L)) / 128, arccos(9 * (L / L) / 11)
    )
