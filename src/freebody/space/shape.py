"""Shape of a body, stored with its mass properties for drawings; no algorithm uses it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from ..scalar.algebra import IDENTITY, ZERO, Matrix, Vector, add, apply, multiply


class Surface:
    """The triangles of a mesh, found when they are first asked for: reading a robot does not wait for its pictures."""

    def __init__(self, find: Callable[[], tuple[Any, Any]]) -> None:
        self._find = find

    @cached_property
    def arrays(self) -> tuple[Any, Any]:
        """Vertices (n, 3) [m], and triangles (k, 3): numbers of vertices. Neither can be written to."""
        arrays = self._find()
        for array in arrays:
            array.setflags(write=False)
        return arrays

    @property
    def vertices(self) -> Any:
        """Points, shape (n, 3) [m]."""
        return self.arrays[0]

    @property
    def faces(self) -> Any:
        """Corners of triangles, counter-clockwise seen from outside, shape (k, 3)."""
        return self.arrays[1]

    def __reduce__(self) -> tuple[Any, ...]:
        return surface, self.arrays


def surface(vertices: Any, faces: Any) -> Surface:
    """Return a surface whose triangles are known."""
    made = Surface(lambda: (vertices, faces))
    made.arrays  # noqa: B018 - so that nobody writes to them
    return made


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
        [m]; ``mesh`` holds its ``surface`` (:class:`Surface`) here, ``revolved`` its profile.
    axis : 3-tuple
        Symmetry axis (or normal) in the shape's axes, not always of unit length.
    center : 3-tuple
        The shape's origin in body axes (for all but ``revolved`` and ``mesh`` its mass centre) [m].
    axes : 3 x 3
        R_BS: components in the shape's axes to components in body axes.
    parts : tuple of Shape
        Parts of a compound, each placed in body axes.
    hole : bool
        True if this part is cut out.
    look : bool
        True if the shape was chosen for drawing, and is not that of the mass.
    color : str
        Colour of the whole body, "#rrggbb"; empty if none was chosen.
    """

    kind: str
    dimensions: tuple[tuple[str, Any], ...] = ()
    axis: Vector = (0, 0, 1)
    center: Vector = ZERO
    axes: Matrix = IDENTITY
    parts: tuple[Shape, ...] = ()
    hole: bool = False
    look: bool = field(default=False, compare=False)
    color: str = ""

    def __repr__(self) -> str:
        sizes = ", ".join(f"{name} {x}" for name, x in self.dimensions if not hasattr(x, "__len__"))
        return f"a solid: {self.kind.replace('_', ' ')}{sizes and f' ({sizes})'}"

    def __getitem__(self, name: str) -> Any:
        """A dimension by its name."""
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
    """Two shapes as one; the second is cut out if it is a ``hole``."""
    if first is None or second is None:
        return second if first is None and not hole else first
    parts = first.parts if first.kind == "compound" else (first,)
    added = second.parts if second.kind == "compound" else (second,)
    # a hole in a hole is solid again
    return Shape("compound", parts=parts + tuple(replace(part, hole=part.hole != hole) for part in added))
