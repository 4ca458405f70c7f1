"""Uniform solids: mass properties from mass and dimensions.

The origin of each solid is its mass centre. The moments are from [MeriamKraige2012, table D/4] and
[CRC2012, section "Moment of inertia for various bodies"]; the tests derive each of them by integration.
Masses and dimensions are numbers or SymPy expressions, assumed positive. ``axis`` is ``"x"``, ``"y"``, ``"z"``
or three components.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import sympy

from ..errors import MassError, shown
from ..scalar.algebra import Expression, Scalar, dot
from .entries import direction, exact_number, negative, reciprocal, text, vector
from .mass import MassProperties
from .shape import Shape


def particle(m: Expression) -> MassProperties:
    """A point mass: no inertia about itself."""
    return _solid("particle", m, {}, (0, 0, 0))


def slender_bar(m: Expression, length: Expression, axis: Any = "x") -> MassProperties:
    """A thin straight bar along ``axis``: 0 about it, ``m l²/12`` across it.

    >>> slender_bar(12, 1, axis="y").moments
    (1, 0, 1)
    """
    m, l = _mass(m), _length(length, "length", "slender_bar")  # noqa: E741
    return _about_axis("slender_bar", m, {"length": l}, axis, along=0, across=m * l * l / _12)


def disk(m: Expression, radius: Expression, axis: Any = "z") -> MassProperties:
    """A thin disk normal to ``axis``: ``m r²/2`` about it, ``m r²/4`` across it."""
    m, r = _mass(m), _length(radius, "radius", "disk")
    return _about_axis("disk", m, {"radius": r}, axis, along=m * r * r / _2, across=m * r * r / _4)


def ring(m: Expression, radius: Expression, axis: Any = "z") -> MassProperties:
    """A thin ring (hoop) normal to ``axis``: ``m r²`` about it, ``m r²/2`` across it."""
    m, r = _mass(m), _length(radius, "radius", "ring")
    return _about_axis("ring", m, {"radius": r}, axis, along=m * r * r, across=m * r * r / _2)


def cylinder(m: Expression, radius: Expression, length: Expression, axis: Any = "z") -> MassProperties:
    """A solid circular cylinder: ``m r²/2`` about ``axis``, ``m (3 r² + l²)/12`` across it."""
    m, r, l = _mass(m), _length(radius, "radius", "cylinder"), _length(length, "length", "cylinder")  # noqa: E741
    across = m * (3 * r * r + l * l) / _12
    return _about_axis("cylinder", m, {"radius": r, "length": l}, axis, along=m * r * r / _2, across=across)


def tube(
    m: Expression, inner: Expression, outer: Expression, length: Expression, axis: Any = "z"
) -> MassProperties:
    """A hollow circular cylinder: ``m (a² + b²)/2`` about ``axis``, ``m (3 (a² + b²) + l²)/12`` across it.

    ``inner`` a and ``outer`` b are radii.
    """
    m, a, b = _mass(m), _length(inner, "inner radius", "tube"), _length(outer, "outer radius", "tube")
    l = _length(length, "length", "tube")  # noqa: E741
    gap = _not_above("inner radius", a, "outer radius", b, "tube")
    squares = a * a + b * b
    dimensions = {"inner": a, "outer": b, "length": l}
    along, across = m * squares / _2, m * (3 * squares + l * l) / _12
    return _about_axis("tube", m, dimensions, axis, along=along, across=across, positive=gap)


def cone(m: Expression, radius: Expression, height: Expression, axis: Any = "z") -> MassProperties:
    """A solid circular cone: ``3 m r²/10`` about ``axis``, ``3 m (4 r² + h²)/80`` across it.

    The axis points from the base to the apex. From the origin, which is the mass centre, the apex is at
    ``+3 h/4`` along the axis and the base at ``-h/4``.
    """
    m, r, h = _mass(m), _length(radius, "radius", "cone"), _length(height, "height", "cone")
    along, across = Fraction(3, 10) * m * r * r, Fraction(3, 80) * m * (4 * r * r + h * h)
    return _about_axis("cone", m, {"radius": r, "height": h}, axis, along=along, across=across)


def box(m: Expression, sizes: Sequence[Expression]) -> MassProperties:
    """A solid rectangular box with edges ``(l_x, l_y, l_z)``: ``m (l_y² + l_z²)/12`` about x, ...

    >>> box(12, (1, 2, 3)).moments
    (13, 10, 5)
    """
    m = _mass(m)
    x, y, z = _lengths(sizes, "box")
    moments = (m * (y * y + z * z) / _12, m * (x * x + z * z) / _12, m * (x * x + y * y) / _12)
    return _solid("box", m, {"x": x, "y": y, "z": z}, moments)


def plate(m: Expression, sizes: Sequence[Expression], normal: str = "z") -> MassProperties:
    """A thin rectangular plate with edges ``(a, b)``: ``m b²/12``, ``m a²/12``, ``m (a² + b²)/12``.

    The edges lie along x and y for the normal z, along y and z for x, along z and x for y.
    """
    m = _mass(m)
    if isinstance(sizes, str) or not hasattr(sizes, "__len__") or len(sizes) != 2:
        raise MassError(f"Expected the two edges (a, b) of a plate, got {shown(sizes)}.")
    if not isinstance(normal, str) or normal not in ("x", "y", "z"):
        raise MassError(
            f"Expected the normal of a plate as 'x', 'y' or 'z', got {shown(normal)}. Turn it with .rotated(R)."
        )
    a, b = (_length(size, f"edge {name}", "plate") for size, name in zip(sizes, "ab", strict=True))
    n = "xyz".index(normal)
    moments: list[Any] = [0, 0, 0]
    moments[(n + 1) % 3], moments[(n + 2) % 3] = m * b * b / _12, m * a * a / _12
    moments[n] = m * (a * a + b * b) / _12
    return _solid("plate", m, {"a": a, "b": b}, tuple(moments), axis=normal)


def sphere(m: Expression, radius: Expression) -> MassProperties:
    """A solid sphere: ``2 m r²/5``."""
    m, r = _mass(m), _length(radius, "radius", "sphere")
    moment = Fraction(2, 5) * m * r * r
    return _solid("sphere", m, {"radius": r}, (moment, moment, moment))


def spherical_shell(m: Expression, radius: Expression) -> MassProperties:
    """A thin spherical shell: ``2 m r²/3``."""
    m, r = _mass(m), _length(radius, "radius", "spherical_shell")
    moment = Fraction(2, 3) * m * r * r
    return _solid("spherical_shell", m, {"radius": r}, (moment, moment, moment))


def ellipsoid(m: Expression, semiaxes: Sequence[Expression]) -> MassProperties:
    """A solid ellipsoid with *semi*-axes ``(a, b, c)`` along x, y, z: ``m (b² + c²)/5`` about x, ..."""
    m = _mass(m)
    a, b, c = _lengths(semiaxes, "ellipsoid")
    moments = (m * (b * b + c * c) / _5, m * (a * a + c * c) / _5, m * (a * a + b * b) / _5)
    return _solid("ellipsoid", m, {"a": a, "b": b, "c": c}, moments)


def torus(m: Expression, major: Expression, minor: Expression, axis: Any = "z") -> MassProperties:
    """A solid torus: ``m (R² + 3 r²/4)`` about ``axis``, ``m (R²/2 + 5 r²/8)`` across it.

    ``major`` R is the radius of the circle through the centres of the round sections, ``minor`` r the radius of the
    sections.
    """
    m, R, r = _mass(m), _length(major, "major radius", "torus"), _length(minor, "minor radius", "torus")
    gap = _not_above("minor radius", r, "major radius", R, "torus")
    along, across = m * (R * R + Fraction(3, 4) * r * r), m * (R * R / _2 + Fraction(5, 8) * r * r)
    return _about_axis("torus", m, {"major": R, "minor": r}, axis, along=along, across=across, positive=gap)


# Division by a Fraction is exact for every entry; an int divided by an int would be a float.
_2, _4, _5, _12 = Fraction(2), Fraction(4), Fraction(5), Fraction(12)


def _about_axis(
    kind: str,
    m: Scalar,
    dimensions: dict[str, Scalar],
    axis: Any,
    *,
    along: Scalar,
    across: Scalar,
    positive: tuple[Any, ...] = (),
) -> MassProperties:
    """Mass properties of a solid of revolution: I = across (1 - n nᵀ) + along n nᵀ for an axis n of any length."""
    n = tuple(exact_number(c, "the axis") for c in direction(axis, f"the axis of the {kind}", MassError))
    square = dot(n, n)
    inverse = reciprocal(square)

    def entry(i: int, j: int) -> Any:
        share = n[i] * n[j] * inverse
        if i == j:
            return along if share == 1 else across if share == 0 else across + (along - across) * share
        return (along - across) * share if share != 0 else 0

    inertia: Any = tuple(tuple(entry(i, j) for j in range(3)) for i in range(3))
    shape = Shape(kind, tuple(dimensions.items()), n)
    return MassProperties(m, (0, 0, 0), inertia, shape, (m, *dimensions.values(), *positive))


def _solid(
    kind: str, m: Scalar, dimensions: dict[str, Scalar], moments: Sequence[Scalar], axis: str = "z"
) -> MassProperties:
    """Mass properties of a solid with principal moments about x, y, z."""
    m = _mass(m)
    a, b, c = moments
    shape = Shape(kind, tuple(dimensions.items()), direction(axis, "the axis"))
    inertia = ((a, 0, 0), (0, b, 0), (0, 0, c))
    return MassProperties(m, (0, 0, 0), inertia, shape, (m, *dimensions.values()))


def _mass(m: Expression) -> Scalar:
    return exact_number(m, "the mass")


def _length(value: Expression, what: str, kind: str) -> Scalar:
    entry = exact_number(value, f"the {what} of the {kind}")
    if isinstance(entry, sympy.Basic) and entry.has(sympy.I):
        raise MassError(f"Expected a {what} of the {kind} that is a real number, got {entry}.")
    if negative(entry):
        raise MassError(
            f"Expected a {what} of the {kind} that is not negative, got {text(entry)}. "
            "Lengths are magnitudes."
        )
    return entry


def _lengths(values: Sequence[Expression], kind: str) -> Any:
    if kind == "box":
        what, names = "the edges (l_x, l_y, l_z) of the box", ("edge x", "edge y", "edge z")
    else:
        what = "the semi-axes (a, b, c) of the ellipsoid"
        names = ("semi-axis a", "semi-axis b", "semi-axis c")
    lengths = vector(values, what, MassError)
    return tuple(_length(v, name, kind) for v, name in zip(lengths, names, strict=True))


def _not_above(small: str, a: Scalar, large: str, b: Scalar, kind: str) -> tuple[Scalar, ...]:
    """Return the difference b - a, which must not be negative."""
    gap = exact_number(sympy.expand(b - a))
    if negative(gap):
        raise MassError(
            f"Expected the {small} of the {kind} not to be larger than the {large}, "
            f"got {text(a)} > {text(b)}. Check the order of the two."
        )
    return (gap,)
