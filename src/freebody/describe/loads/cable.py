"""A cable between two points at the distance d: it pulls when it is longer than its length d_0, and never pushes.

T = max(k (d - d_0) + c d', 0) where d > d_0,        V = ½ k max(d - d_0, 0)²

The times at which it becomes taut or slack are located.
"""

from __future__ import annotations

from typing import Any

from ...scalar.algebra import HALF, Expression, FieldVector, Scalar, divide
from ..description import Description
from ..part import Constant, add
from .load import Load, Look
from .straight import Straight


class Cable(Straight, kind="cable"):
    """An elastic cable between two points, which may be slack."""

    stiffness: Constant  # k [N/m]
    length: Constant  # d_0 [m]
    damping: Constant = 0  # c [N s/m], while it is taut

    units = {"stiffness": "N/m", "length": "m", "damping": "N s/m"}
    noun = "cable"
    look = Look("spring", "zigzag", "stiffness")
    switches = ("becomes taut", "becomes slack")

    @property
    def is_conservative(self) -> bool:
        """True if it has no damping."""
        return bool(self.damping == 0)

    def _density(self, at: Any, line: FieldVector, length: Scalar) -> Scalar:
        stretch = length - at(self.length)
        tension = at(self.stiffness) * stretch
        if self.damping != 0:
            tension = at.max(tension + at(self.damping) * self._rate(at, line, length), 0)
        return divide(at.where(stretch, tension, 0), length)

    def potential(self, at: Any) -> Scalar:
        """Return ½ k (d - d_0)² of a taut cable, 0 of a slack one [J]."""
        stretch = at.line(self.start, self.end).norm() - at(self.length)
        return HALF * at(self.stiffness) * at.where(stretch, stretch * stretch, 0)


def cable(
    system: Description,
    name: str,
    start: Any,
    to: Any,
    *,
    stiffness: Expression,
    length: Expression,
    damping: Expression = 0,
) -> Load:
    """Add an elastic cable between two points: it pulls when it is longer than ``length``, and never pushes.

    Parameters
    ----------
    name : str
    start, to : Point
    stiffness : expression [N/m]
    length : expression [m]
        Its length without tension. A rope that does not stretch is :meth:`rope`.
    damping : expression [N s/m]
        Of the taut cable.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("bungee")
    >>> m, g, k, L = s.parameters(m=70.0, g=9.81, k=100.0, L=20.0)
    >>> s.gravity = (0, -g, 0)
    >>> jumper = s.body("jumper", fb.particle(m))
    >>> fall = s.slider("fall", s.ground, jumper, axis="-y", coordinate="y")
    >>> rope = s.cable("rope", s.ground.origin, jumper.origin, stiffness=k, length=L)
    >>> print(fb.simulate(s, 3, initial={"y": 1.0}).events)
    t = 1.96815 s: rope becomes taut: rises through zero
    """
    return add(system, name, Cable(start, to, stiffness, length, damping))
