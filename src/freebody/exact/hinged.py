"""Single bodies on a hinge: a struck bar, a door, a disk on a rod, for numbers, arrays or SymPy expressions.

The moment equation about the fixed hinge gives the motion. The force equation of the mass centre then gives the
reaction.
Source: chapter, Problems 6.4 to 6.6.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .elementary import cos, sin, sqrt


class StruckBar(NamedTuple):
    """Angular acceleration [rad/s²] and horizontal reaction R_x [N] of a bar that hangs from its upper end."""

    alpha: Any
    reaction: Any


def struck_bar(m: Any, L: Any, F: Any, h: Any) -> StruckBar:
    """Angular acceleration and horizontal reaction of a uniform hanging bar under a horizontal force F.

    The force acts at the distance h below the hinge::

        (m L²/3) α = F h,    F + R_x = m (L/2) α

    Examples
    --------
    >>> struck_bar(2.0, 1.2, 100.0, 0.2).reaction
    -75.0
    """
    alpha = 3 * F * h / (m * L**2)
    return StruckBar(alpha, 3 * F * h / (2 * L) - F)


def door_frequency(b: Any, alpha: Any, g: Any) -> Any:
    """Frequency of the small motion of a uniform door of width b on a hinge line inclined by alpha [rad/s].

    (m b²/3) θ'' + m g sin(α) (b/2) sin(θ) = 0: the component of gravity normal to the line swings the door.
    """
    return sqrt(3 * g * sin(alpha) / (2 * b))


class DiskPendulum(NamedTuple):
    """Rate, acceleration, reaction on the rod and small frequency of a disk on a massless rod.

    The components of the reaction are ``x``, ``y`` (horizontal and up), ``along`` (along the rod to the hinge) and
    ``across`` (towards larger angles).
    """

    rate: Any
    acceleration: Any
    x: Any
    y: Any
    along: Any
    across: Any
    frequency: Any


def disk_pendulum(m: Any, L: Any, R: Any, g: Any, release: Any, theta: Any) -> DiskPendulum:
    """Motion at the angle ``theta`` of a disk on a rod, released from rest at the angle ``release``.

    The disk of radius R is fixed at its centre to the rod of length L::

        I_O = m (L² + R²/2),    θ'² = 2 m g L (cos θ - cos θ_0) / I_O,    I_O θ'' = -m g L sin θ

    and, along and across the rod, R_n = m (L θ'² + g cos θ), R_t = m (L θ'' + g sin θ).

    Parameters
    ----------
    m, L, R, g : [kg], [m], [m], [m/s²]
    release, theta : [rad]
        From the downward vertical, counter-clockwise; the rod passes ``theta`` clockwise.
    """
    over_mass = L**2 + R**2 / 2
    square = 2 * g * L * (cos(theta) - cos(release)) / over_mass
    acceleration = -g * L * sin(theta) / over_mass
    along = m * (L * square + g * cos(theta))
    across = m * (L * acceleration + g * sin(theta))
    return DiskPendulum(
        -sqrt(square),
        acceleration,
        across * cos(theta) - along * sin(theta),
        across * sin(theta) + along * cos(theta),
        along,
        across,
        sqrt(g * L / over_mass),
    )
