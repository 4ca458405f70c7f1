"""What a body looks like: kept beside its mass properties for drawing, used by no algorithm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from ..scalar.algebra import IDENTITY, ZERO, Matrix, Vector, add, apply, multiply


@dataclass(frozen=True)
class Shape:
    """A solid in body axes.

    Attributes
    ----------
    kind : str
        ``particle``, ``slender_bar``, ``disk``, ``ring``, ``cylinder``, ``tube``, ``cone``, ``box``,
        ``plate``, ``sphere``, ``spherical_shell``, ``ellipsoid``, ``torus``, ``revolved``, ``mesh``
        or ``compound``.
    dimensions : tuple of (name, value)
        [m]; ``mesh`` holds its arrays ``vertices`` and ``faces`` here, ``revolved`` its profile.
    axis : 3-tuple
        Symmetry axis (or normal) before ``axes`` turns it, not always of unit length.
    center : 3-tuple
        The shape's own origin (for all but ``revolved`` and ``mesh`` its mass centre), in body axes [m].
    axes : 3 x 3
        R_BS: components in the shape's axes to components in body axes.
    parts : tuple of Shape
        What a compound is made of, each placed in body axes.
    hole : bool
        Whether this part is taken away.
    color : str
        Of the whole body, "#rrggbb"; empty if it was not chosen.
    """

    kind: str
    dimensions: tuple[tuple[str, Any], ...] = ()
    axis: Vector = (0, 0, 1)
    center: Vector = ZERO
    axes: Matrix = IDENTITY
    parts: tuple[Shape, ...] = ()
    hole: bool = False
    color: str = ""

    def __repr__(self) -> str:
        sizes = ", ".join(f"{name} {x}" for name, x in self.dimensions if not hasattr(x, "__len__"))
        return f"a solid: {self.kind.replace('_', ' ')}{sizes and f' ({sizes})'}"

    def __getitem__(self, name: str) -> Any:
        """One dimension by its name."""
        return dict(self.dimensions)[name]

    def moved(self, p: Vector) -> Shape:
        """The shape displaced by ``p``."""
        return replace(self, center=add(self.center, p), parts=tuple(part.moved(p) for part in self.parts))

    def rotated(self, R: Matrix) -> Shape:
        """The shape turned about the body's origin."""
        return replace(
            self,
            center=apply(R, self.center),
            axes=multiply(R, self.axes),
            parts=tuple(part.rotated(R) for part in self.parts),
        )

    def mapped(self, put: Callable[[Any], Any]) -> Shape:
        """The shape with ``put`` applied to every entry."""
        axis: Any = tuple(map(put, self.axis))
        center: Any = tuple(map(put, self.center))
        axes: Any = tuple(tuple(map(put, row)) for row in self.axes)
        return replace(
            self,
            dimensions=tuple((name, put(value)) for name, value in self.dimensions),
            axis=axis,
            center=center,
            axes=axes,
            parts=tuple(part.mapped(put) for part in self.parts),
        )


def compound(first: Shape | None, second: Shape | None, hole: bool = False) -> Shape | None:
    """Two shapes of one body; a hole is the second one taken away."""
    if first is None or second is None:
        return second if first is None and not hole else first
    left = first.parts if first.kind == "compound" else (first,)
    # A hole in a hole is solid again.
    right = second.parts if second.kind == "compound" else (second,)
    return Shape("compound", parts=left + tuple(replace(part, hole=part.hole != hole) for part in right))
