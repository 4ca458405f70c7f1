"""Lines of hills and valleys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...errors import ExpressionError, ModelError, shown
from ...scalar.algebra import (
    IDENTITY,
    Expression,
    Scalar,
    Vector,
    add,
    apply,
    cross,
    divide,
    scale,
    subtract,
)
from ...scalar.expression import exact
from ...scalar.parser import parse
from ..constants import constant, default_value, is_number
from ..description import names_of, varying
from ..frame import Frame, place_in
from .point import Spot
from .segment import End
from .shape import ContactShape, Law, Nearest

LINE = sympy.Symbol("x", real=True)
"""Position along a line, a name of the body and not of the system."""


def on_line(at: Any, feature: Any, line: Any) -> Nearest:
    """Return the nearest points of a round shape of radius R and a line y = f(x), with the foot (p, f(p)):

        n = (-f', 1, 0)/w,   w = sqrt(1 + f'²)  at p,      p - R f'/w = x,      g = (y - f - R/w)/w

    for the centre C = (x, y, z): the shape, moved along y, would touch the line at p, and below a point p = x. The left
    side grows with p where the line curves less than the circle, R f''/w³ < 1. Near contact g is the distance to
    first order.
    """
    C, R = feature.middle(at), feature.size(at)
    O = at.place(line.body, line.at)  # noqa: E741
    x, y, z = at.within(line.body, subtract(C, O))

    def of(expression: Any, p: Any) -> Any:
        return at.of(expression, {line.variable: p})

    def excess(p: Any) -> Any:
        slope = of(line.slope, p)
        return p - divide(R * slope, at.field.sqrt(1 + slope * slope)) - x

    def rate(p: Any) -> Any:
        slope = of(line.slope, p)
        square = 1 + slope * slope
        return 1 - divide(R * of(line.bend, p), square * at.field.sqrt(square))

    low, high = map(at, line.between) if line.between else (x - R, x + R)
    reach = (-excess(low), excess(high)) if line.between else ()
    p = x
    if not isinstance(feature, Spot):
        p = at.field.root(excess, rate, (low, high), f"x_{at.name}", not line.between)
    f, slope = of(line.height, p), of(line.slope, p)
    root = at.field.sqrt(1 + slope * slope)
    n = at.outward(line.body, (divide(-slope, root), divide(1, root), 0))
    gap = divide(y - f - divide(R, root), root)
    return Nearest(subtract(C, scale(R, n)), add(O, at.outward(line.body, (p, f, z))), n, gap, reach)


class Heightline(ContactShape, kind="heightline"):
    """The line y = f(x) (in 3-D the surface over x and z) of a body that lies below it."""

    at: Vector
    variable: Any
    height: Scalar
    slope: Scalar
    bend: Scalar
    bend_rate: Scalar
    between: tuple[Scalar, ...] = ()

    door = True
    words = {"height": "text", "at": "vector", "between": "edges"}
    required = ("height",)
    look, in_families, extruded = "profile", False, True

    @property
    def kinks(self) -> bool:
        """True if its slope jumps."""
        derivatives = (sympy.sympify(e) for e in (self.slope, self.bend))
        return any(e.has(sympy.DiracDelta, sympy.Heaviside) for e in derivatives)

    @property
    def ended(self) -> bool:
        """True if the line has ends."""
        return bool(self.between)

    def ends(self, other: ContactShape) -> Sequence[ContactShape]:
        """Return the ends of the line for round shapes with a size."""
        if not other.round or not hasattr(other, "radius"):
            return ()
        heights = [sympy.sympify(self.height).subs(self.variable, x) for x in self.between]
        x, y, z = self.at
        return [
            End(self.body, (exact(x + a), exact(y + f), z))
            for a, f in zip(self.between, heights, strict=True)
        ]

    def lies_across(self, R: Any, k: Vector) -> bool:
        """Return True if its z is parallel to k."""
        return all(exact(x) == 0 for x in cross(apply(R, IDENTITY[2]), k))

    @classmethod
    def law_with(cls, feature: type[ContactShape]) -> Law | None:
        """Return the law of round shapes and points."""
        return on_line if feature.round else None

    @classmethod
    def made(cls, body: Any, **data: Any) -> ContactShape:
        """Return the line of a body from the data of a file."""
        return heightline(body, **data)


def heightline(
    body: Frame, height: Expression, *, at: Any = None, between: Sequence[Expression] = ()
) -> Heightline:
    """Return a line y = f(x) in the axes of the body, which lies below it: a hill, a valley, a cam's face.

    A round shape must curve more than the line does, everywhere: it then touches at one place, which is proven before
    a motion starts. In a dip where it touches in two places give it two lines, one for each flank.

    Parameters
    ----------
    height : text or SymPy expression of ``x`` and parameters [m]
        Its first derivative must exist wherever it is touched.
    at : Point of the body or three components, optional
        The point x = 0, y = 0; by default the body's origin.
    between : two expressions of parameters, optional
        The x of the ends of the line [m]; by default it has none. Round shapes roll over the ends.

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
    x = LINE
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
    f, slope, bend, bend_rate = (exact(expression.diff(x, k)) for k in range(4))
    place, ends = place_in(body, at, what), _ends(body, between, what)
    return Heightline(body, place, x, f, slope, bend, bend_rate, ends)


def _ends(body: Frame, between: Any, what: str) -> tuple[Scalar, ...]:
    """Return the x of two ends, or none."""
    if isinstance(between, str) or not isinstance(between, Sequence) or len(between) not in (0, 2):
        raise ModelError(f"Expected between=(start, end) for {what}, got {shown(between)}.")
    ends = tuple(constant(body.system, x, f"the ends of {what}") for x in between)
    values = [value for x in ends if (value := default_value(body.system, x)) is not None]
    if len(values) == 2 and values[0] >= values[1]:
        raise ModelError(
            f"Expected a start before the end of {what}, got between=({values[0]:g}, {values[1]:g})."
        )
    return ends
