"""Methods of Body that make the shapes by which bodies touch each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy

from ..errors import ExpressionError, ModelError, shown
from ..scalar.algebra import Expression, Scalar, Vector, add, apply, cross, dot, subtract
from ..scalar.expression import exact
from ..scalar.parser import parse
from .axes import UNIT, direction
from .constants import constant, default_value, is_number
from .contact_shapes import Ball, Circle, Corners, Cylinder, Ellipsoid, Heightline, Plane, Segment
from .description import names_of, positive_in, take_as_positive, varying, vector
from .frame import Frame, Point, place_in


def sphere(body: Frame, radius: Expression, *, at: Any = None, inside: bool = False) -> Ball:
    """Return a sphere fixed in the body, for contacts; ``inside=True`` for a bowl, whose body is around the sphere.

    Parameters
    ----------
    radius : expression of parameters [m]
    at : Point of the body or three components, optional
        Its centre; by default the body's origin.
    inside : bool
        True if other bodies touch it from within.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("ball in a bowl")
    >>> ball = s.body("ball", fb.sphere(1, 0.1))
    >>> air = s.free("air", s.ground, ball)
    >>> bowl = s.contact("bowl", ball.sphere(0.1), s.ground.sphere(1, at=(0, 1, 0), inside=True), friction=0.3)
    """
    what = f"the sphere of {body!r}"
    return Ball(body, place_in(body, at, what), _length(body, radius, what), _flag(inside, what))


def ellipsoid(body: Frame, half_axes: Any, *, at: Any = None) -> Ellipsoid:
    """Return an ellipsoid along the axes of the body, for contacts with planes: a wobblestone, an egg.

    Parameters
    ----------
    half_axes : three expressions of parameters [m]
        Along x, y and z.
    at : Point of the body or three components, optional
        Its centre; by default the body's origin.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("egg")
    >>> egg = s.body("egg", fb.sphere(0.06, 0.02))
    >>> air = s.free("air", s.ground, egg)
    >>> table = s.contact("table", egg.ellipsoid((0.02, 0.02, 0.03)), s.ground.plane(normal="z"), friction=0.3)
    """
    what = f"the ellipsoid of {body!r}"
    if isinstance(half_axes, str) or not isinstance(half_axes, Sequence) or len(half_axes) != 3:
        raise ModelError(f"Expected three half axes (a, b, c) for {what}, got {shown(half_axes)}.")
    a, b, c = (_length(body, axis, what) for axis in half_axes)
    return Ellipsoid(body, place_in(body, at, what), (a, b, c))


def circle(
    body: Frame, radius: Expression, *, at: Any = None, axis: Any = "z", inside: bool = False
) -> Circle:
    """Return a circle fixed in the body at right angles to ``axis``: a disk's edge.

    It touches a plane with its lowest point, tilted or not. Points and round shapes touch it like the wall of a
    cylinder along ``axis``, which in planar machines is the same.

    Parameters
    ----------
    radius : expression of parameters [m]
    at : Point of the body or three components, optional
        Its centre; by default the body's origin.
    axis : "x", "y", "z" or three components
    inside : bool
        True if other bodies touch it from within: a ring, a round hole.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("coin")
    >>> coin = s.body("coin", fb.disk(0.01, 0.012))
    >>> air = s.free("air", s.ground, coin)
    >>> table = s.contact("table", coin.circle(0.012), s.ground.plane(normal="z"), friction=0.2)
    """
    what = f"the circle of {body!r}"
    n = _unit(body, axis, f"the axis of {what}")
    return Circle(body, place_in(body, at, what), n, _length(body, radius, what), _flag(inside, what))


def cylinder(
    body: Frame, radius: Expression, *, at: Any = None, axis: Any = "z", inside: bool = False
) -> Cylinder:
    """Return the wall of an infinite circular cylinder fixed in the body.

    Parameters
    ----------
    radius : expression of parameters [m]
    at : Point of the body or three components, optional
        A point of its axis; by default the body's origin.
    axis : "x", "y", "z" or three components
    inside : bool
        True if other bodies touch it from within: a pipe.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("ball on a log")
    >>> ball = s.body("ball", fb.sphere(1, 0.1))
    >>> air = s.free("air", s.ground, ball)
    >>> log = s.contact("log", ball.sphere(0.1), s.ground.cylinder(0.5, axis="x"), friction=0.3)
    """
    what = f"the cylinder of {body!r}"
    n = _unit(body, axis, f"the axis of {what}")
    return Cylinder(body, place_in(body, at, what), n, _length(body, radius, what), _flag(inside, what))


def plane(body: Frame, *, at: Any = None, normal: Any = "y") -> Plane:
    """Return an infinite plane fixed in the body: a floor, a wall, a table.

    Parameters
    ----------
    at : Point of the body or three components, optional
        A point of the plane; by default the body's origin.
    normal : "y", "-x", … or three components
        Direction out of the body, to the side of the bodies that touch it.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("slope")
    >>> beta = s.parameters(beta="30deg")
    >>> s.ground.plane(normal=("sin(beta)", "cos(beta)", 0)).normal
    (sin(beta), cos(beta), 0)
    """
    what = f"the plane of {body!r}"
    n = _unit(body, normal, f"the normal of {what}")
    first, second = _across(n)
    return Plane(body, place_in(body, at, what), n, first, second)


def segment(body: Frame, start: Any, end: Any, *, normal: Any) -> Segment:
    """Return a straight side of the body from ``start`` to ``end``: the side of a bar, the top of a ledge.

    Parameters
    ----------
    start, end : Points of the body or three components each
    normal : "y", "-x", … or three components
        Direction out of the body, at right angles to the side.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("bar on a ledge")
    >>> bar = s.body("bar", fb.slender_bar(2, 1.2))
    >>> joint = s.planar("plane", s.ground, bar, coordinate="x y phi")
    >>> side = bar.segment((-0.6, 0, 0), (0.6, 0, 0), normal="-y")
    >>> ledge = s.contact("ledge", side, s.ground.point(0, 0, 0), friction=0.4)
    """
    what = f"the segment of {body!r}"
    a, b = place_in(body, start, what), place_in(body, end, what)
    n = _unit(body, normal, f"the normal of {what}")
    d = tuple(sympy.sympify(x) for x in subtract(b, a))
    if sympy.simplify(dot(d, n)) != 0:
        raise ModelError(
            f"The normal of {what} must be at right angles to the side from {_text(a)} to {_text(b)}, got "
            f"{shown(normal)}."
        )
    if all(x == 0 for x in d):
        raise ModelError(f"Start and end of {what} are the same point, {_text(a)}.")
    length = _root(body, sympy.Add(*(x**2 for x in d)))
    e = tuple(exact(x / length) for x in d)
    return Segment(body, a, b, e, n, exact(length))


def corners(body: Frame, *points: Any, size: Any = None, at: Any = None) -> Corners:
    """Return the corners of a convex body, each of which touches by itself.

    Without points and size they are the vertices of the body's mesh; vertices in one place count once.

    Parameters
    ----------
    *points : Points of the body, three components each, or one array of shape (n, 3)
    size : two or three expressions of parameters [m], in place of points
        Edges of a box along the body's axes: two give four corners in the plane of x and y, three give eight.
    at : Point of the body or three components, optional
        The middle of that box; by default the body's origin.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("rocking block")
    >>> block = s.body("block", fb.box(1, (0.2, 1, 0.2)))
    >>> block.corners(size=(0.2, 1)).points[:2]
    (point (-1/10, -1/2, 0) of block, point (1/10, -1/2, 0) of block)
    >>> faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    >>> stone = s.body("stone", fb.mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], faces, mass=6))
    >>> len(stone.corners().points)
    4
    """
    what = f"the corners of {body!r}"
    if size is not None and points:
        raise ModelError(f"Expected either points or size=(a, b) for {what}, got both.")
    if size is None and not points:
        points = _vertices(body, what)
    if size is not None:
        if isinstance(size, str) or not hasattr(size, "__len__") or len(size) not in (2, 3):
            raise ModelError(f"Expected two or three edges, size=(a, b, c), for {what}, got {shown(size)}.")
        edges = [sympy.sympify(_length(body, edge, what)) / 2 for edge in size]
        middle = place_in(body, at, what)
        # counter-clockwise from the lower left, the lower four (smaller z) first
        around = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        depths = (-1, 1) if len(edges) == 3 else (0,)
        edges = [*edges, 0][:3]
        vertices = [
            Point(body, _sum(middle, (i * edges[0], j * edges[1], k * edges[2])))
            for k in depths
            for i, j in around
        ]
        return Corners(body, tuple(vertices))
    if at is not None:
        raise ModelError(f"at= displaces a box given by size=, but {what} are given as points.")
    if len(points) == 1 and isinstance(points[0], Sequence | np.ndarray):
        rows = points[0].tolist() if hasattr(points[0], "tolist") else points[0]
        if hasattr(rows, "__len__") and len(rows) > 0 and hasattr(rows[0], "__len__"):
            points = tuple(rows)
    return Corners(body, tuple(Point(body, place_in(body, point, what)) for point in points))


def _vertices(body: Frame, what: str) -> tuple[Any, ...]:
    """Return the vertices of the mesh that a body is made of, in body axes."""
    shape = None if body.mass_properties is None else body.mass_properties.shape
    if shape is None or shape.kind != "mesh":
        raise ModelError(
            f"Expected points, or size=(a, b) of a box, for {what}, got none. A body made of a mesh has corners of its "
            f"own; this one is {'no mesh' if shape is None else f'a {shape.kind}'}."
        )
    return tuple(
        dict.fromkeys(add(shape.center, apply(shape.axes, tuple(v))) for v in shape["vertices"].tolist())
    )


def heightline(body: Frame, height: Expression, *, at: Any = None) -> Heightline:
    """Return a line y = f(x) in the axes of the body, which lies below it: a hill, a valley, a cam's face.

    Parameters
    ----------
    height : text or SymPy expression of ``x`` and parameters [m]
        Its first derivative must exist wherever it is touched.
    at : Point of the body or three components, optional
        The point x = 0, y = 0; by default the body's origin.

    Raises
    ------
    ModelError
        An expression that depends on coordinates, speeds or time, or not on ``x``.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("hill")
    >>> h, l = s.parameters(h=0.5, l=2.0)
    >>> s.ground.heightline("h*cos(pi*x/l)").slope
    -pi*h*sin(pi*x/l)/l
    """
    what = f"the heightline of {body!r}"
    names = names_of(body.system)
    x = sympy.Symbol("x", real=True)
    if isinstance(height, str):
        try:
            expression = parse(height, {**names.atoms, "x": x})
        except ExpressionError as error:
            raise ExpressionError(f"In {what}: {error}") from None
    else:
        if not isinstance(height, sympy.Expr) and not is_number(height):
            raise ExpressionError(
                f"In {what}: expected text or a SymPy expression of x, got {shown(height)}."
            )
        expression = sympy.sympify(height)
        free = {symbol: x for symbol in expression.free_symbols if symbol.name == "x"}
        expression = expression.xreplace(free)
        names.expression(expression.xreplace({x: sympy.Integer(1)}), what)
    moving = varying(body.system, expression)
    if moving:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} is fixed in its body and cannot depend on {', '.join(moving)}. Write it as "
            f"a function of x and parameters."
        )
    if not expression.has(x):
        raise ModelError(f"{what[0].upper()}{what[1:]} does not depend on x. A level line is body.plane().")
    return Heightline(body, place_in(body, at, what), x, exact(expression), exact(expression.diff(x)))


# --- helpers -----------------------------------------------------------------------------------


def _text(components: Vector) -> str:
    return f"({', '.join(map(str, components))})"


def _sum(a: Sequence[Any], b: Sequence[Any]) -> Vector:
    x, y, z = (exact(sympy.sympify(p) + q) for p, q in zip(a, b, strict=True))
    return (x, y, z)


def _unit(body: Frame, normal: Any, what: str) -> Vector:
    """Return the unit vector along a direction; (-sin b, cos b, 0) is taken as it is, without a square root."""
    if not isinstance(normal, str):
        components = vector(body.system, normal, what)
        square = sympy.Add(*(sympy.sympify(c) ** 2 for c in components))
        if square.free_symbols and sympy.simplify(square) == 1:
            direction(body.system, normal, what)  # checks the components
            return components
    return direction(body.system, normal, what)


def _root(body: Frame, square: Any) -> Any:
    """Return the square root, simplified by the dimensions known to be positive."""
    dummies = {s: sympy.Dummy(str(s), positive=True) for s in square.free_symbols & positive_in(body.system)}
    root = sympy.sqrt(sympy.factor(square.xreplace(dummies)))
    return root.xreplace({dummy: symbol for symbol, dummy in dummies.items()})


def _across(n: Vector) -> tuple[Vector, Vector]:
    """Return two unit vectors that complete a right-handed set with ``n``; coordinate axes if possible."""
    units = list(UNIT.values())
    for k in range(3):
        if n[k] in (1, -1):
            i, j = (k + 1) % 3, (k + 2) % 3
            return (units[i], units[j]) if n[k] == 1 else (units[j], units[i])
    level = [k for k in range(3) if n[k] == 0]
    if level:
        e = units[level[-1]]
    else:
        square = 1 - sympy.sympify(n[2]) ** 2
        e = tuple(sympy.sympify(c) / sympy.sqrt(square) for c in cross(n, UNIT["z"]))
    second = cross(n, e)
    x, y, z = (exact(c) for c in second)
    a, b, c = (exact(c) for c in e)
    return (a, b, c), (x, y, z)


def _length(body: Frame, size: Expression, what: str) -> Scalar:
    """Return a length greater than zero; a parameter as length becomes known to be positive."""
    expression = constant(body.system, size, f"the size of {what}")
    value = default_value(body.system, expression)
    if value is not None and value <= 0:
        raise ModelError(f"Expected a size of more than 0 for {what}, got {value:g}.")
    if isinstance(expression, sympy.Symbol):
        take_as_positive(body.system, expression)
    return expression


def _flag(value: Any, what: str) -> bool:
    if not isinstance(value, bool):
        raise ModelError(f"Expected inside=True or inside=False for {what}, got {shown(value)}.")
    return value
