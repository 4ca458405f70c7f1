"""The moment of a bushing at large angles, for numbers, arrays or SymPy expressions.

The angles (a, b, c) are those of a gimbal "XYZ". Its axes e_1 = x, e_2, e_3 are not at right angles. The moment M on
the second body has the power of the springs along each, M·e_i = -k_i times the angle:

    M_x = -k_1 a,    P = -k_2 b,    Q = (k_1 a sin b - k_3 c)/cos b
    M_y = P cos a - Q sin a,    M_z = P sin a + Q cos a
"""

from __future__ import annotations

from typing import Any

from .elementary import cos, sin


def bushing_moment(angles: Any, stiffness: Any) -> tuple[Any, Any, Any]:
    """Moment on the second body [N m], components along the axes of the first, for angles [rad] and N m/rad.

    Examples
    --------
    >>> [float(x) for x in bushing_moment((0.0, 0.5, 0.0), (1.0, 2.0, 3.0))]
    [-0.0, -1.0, 0.0]
    """
    (a, b, c), (k_1, k_2, k_3) = angles, stiffness
    P, Q = -k_2 * b, (k_1 * a * sin(b) - k_3 * c) / cos(b)
    return -k_1 * a, P * cos(a) - Q * sin(a), P * sin(a) + Q * cos(a)
