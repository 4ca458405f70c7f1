"""Bodies fixed to a shaft in two bearings that exert forces across the shaft and no moments.

X horizontal, Y up, Z along the shaft; the bearings A and B are at Z = L/2 and -L/2, theta is the angle of the
body's x axis from X. In the axes of the body, whose origin O is midway between the bearings, with omega =
theta' and alpha = theta'', H_O = (-I_xz omega, -I_yz omega, I_z omega), so that

    -(L/2) (A_y - B_y) = -I_xz alpha + I_yz omega²       A_x + B_x = -m e omega² + m g sin(theta)
     (L/2) (A_x - B_x) = -I_yz alpha - I_xz omega²       A_y + B_y =  m e alpha + m g cos(theta)

for a mass centre at the distance e from O along x. I_xz and I_yz are the integrals ∫xz dm and ∫yz dm.

All functions accept numbers or SymPy expressions. Sources: chapter, section 6.6 and Problems 6.12, 6.13, derived
here by hand.
"""

from __future__ import annotations

from typing import Any

from .elementary import cos, sin


def bearing_forces(
    m: Any, L: Any, g: Any, theta: Any, omega: Any, alpha: Any = 0, I_xz: Any = 0, I_yz: Any = 0, e: Any = 0
) -> tuple[Any, Any, Any, Any]:
    """Forces R_AX, R_AY, R_BX, R_BY of the bearings on the shaft, in ground axes [N].

    Parameters
    ----------
    m, L, g
        Mass [kg], distance between the bearings [m], gravity along -Y [m/s²].
    theta, omega, alpha
        Angle of the shaft [rad] and its rates [rad/s], [rad/s²].
    I_xz, I_yz
        Products of inertia about the midpoint, ∫xz dm and ∫yz dm, body axes [kg m²].
    e
        Distance of the mass centre from the midpoint along body x [m].

    Examples
    --------
    >>> [float(force) for force in bearing_forces(m=2, L=1, g=10, theta=0, omega=3, e=0.1)]
    [-0.9, 10.0, -0.9, 10.0]
    """
    sum_x, sum_y = m * g * sin(theta) - m * e * omega**2, m * g * cos(theta) + m * e * alpha
    difference_x = -2 / L * (I_yz * alpha + I_xz * omega**2)
    difference_y = 2 / L * (I_xz * alpha - I_yz * omega**2)
    forces = []
    for sign in (1, -1):
        x, y = (sum_x + sign * difference_x) / 2, (sum_y + sign * difference_y) / 2
        forces += [x * cos(theta) - y * sin(theta), x * sin(theta) + y * cos(theta)]
    a, b, c, d = forces
    return a, b, c, d


def tilted_product(I_axis: Any, I_across: Any, beta: Any) -> Any:
    """I_yz = ∫yz dm of a symmetric body whose axis is (0, sin(beta), cos(beta)): -(I_axis - I_across) sin cos."""
    return -(I_axis - I_across) * sin(beta) * cos(beta)


def tilted_axial(I_axis: Any, I_across: Any, beta: Any) -> Any:
    """Moment of inertia about z of the body of :func:`tilted_product`: I_axis cos² + I_across sin²."""
    return I_axis * cos(beta) ** 2 + I_across * sin(beta) ** 2


def dumbbell_product(m: Any, a: Any, beta: Any) -> Any:
    """I_yz of two particles m at ±a (0, sin(beta), cos(beta)): 2 m a² sin cos."""
    return 2 * m * a**2 * sin(beta) * cos(beta)
