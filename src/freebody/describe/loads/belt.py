"""An elastic belt or chain around two pulleys, which pulls with the tensions of its two spans.

The pulleys, of radii r_1 and r_2, turn by y_1 and y_2 about parallel axes n, at the distance D along e in one body.
The spans leave them at the angle β, sin β = (r_1 ∓ r_2)/D, upper sign for an open belt and lower for a crossed one:

    x = r_1 y_1 ∓ r_2 y_2,        T_1 = T_0 + k x + c x',        T_2 = T_0 - k x - c x'

along cos β e ∓ sin β n × e. They pull the pulleys together, so that the bearings feel it, and turn them with
r_1 (T_2 - T_1) and ± r_2 (T_1 - T_2). A span does not push: where T_0 ± k x would be negative it is slack. The belt has
no mass, does not slip, and touches nothing else. V = (T_1² + T_2²)/(2 k), without the parts of c.

Source: Shigley & Mischke, Mechanical Engineering Design (1989), §17-1 and 17-2.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import (
    HALF,
    Expression,
    FieldVector,
    Scalar,
    Vector,
    apply,
    cross,
    divide,
    dot,
    scale,
    subtract,
)
from ...scalar.algebra import add as add_vectors
from ...scalar.expression import exact
from ..description import Description
from ..frame import Point
from ..joints.joint import Joint
from ..part import Constant, add
from .action import Action, Couple, PointForce
from .load import Load

RUNS = ("open", "crossed")
PIECES = 24
"""Straight pieces in which a belt is drawn around a pulley."""


class Belt(Load, kind="belt"):
    """A belt around the pulleys of two hinges."""

    first: Joint
    second: Joint
    first_radius: Constant  # r_1 [m]
    second_radius: Constant  # r_2 [m]
    stiffness: Constant  # k of each span [N/m]
    tension: Constant = 0  # T_0 of both spans with the coordinates zero [N]
    damping: Constant = 0  # c of each span [N s/m]
    run: str = "open"

    units = {
        "first_radius": "m", "second_radius": "m", "stiffness": "N/m", "tension": "N", "damping": "N s/m",
    }  # fmt: skip
    noun = "belt"
    switches = ("becomes taut", "becomes slack")

    def check(self) -> None:
        """Refuse what has no two spans in one plane."""
        if self.run not in RUNS:
            raise ModelError(f"Expected run='open' or run='crossed' of {self.title}, got {shown(self.run)}.")
        for joint in (self.first, self.second):
            pulley = joint.primitives[0]
            if (
                len(joint.primitives) != 1
                or not pulley.turns
                or pulley.slides
                or not pulley.displaces
                or joint.pair.path
            ):
                raise ModelError(
                    f"{self.heading} runs around pulleys on hinges, but '{joint.name}' is a {joint.type}. Put the "
                    f"pulley on a hinge."
                )
        if self.first is self.second or self.first.parent is not self.second.parent:
            raise ModelError(
                f"{self.heading} runs around two pulleys whose hinges stand in one body; '{self.first.name}' stands in "
                f"'{self.first.parent.name}' and '{self.second.name}' in '{self.second.parent.name}'. Join them so."
            )
        n, d = self._axis(self.first), self._distance
        if any(exact(x) != 0 for x in cross(n, self._axis(self.second))) or exact(dot(n, d)) != 0:
            raise ModelError(
                f"{self.heading} runs in one plane, so the axes of '{self.first.name}' and '{self.second.name}' must "
                f"be parallel, and their points in one plane across them. Move at= of one of them."
            )
        if sympy.sympify(self.stiffness).is_number and not sympy.sympify(self.stiffness) > 0:
            raise ModelError(
                f"Expected a stiffness greater than 0 N/m of {self.title}, got {shown(self.stiffness)}."
            )
        cosine = sympy.sympify(1 - self._sine**2)
        if cosine.is_number and not cosine > 0:
            raise ModelError(
                f"The pulleys of {self.title} overlap: the distance of their axes is "
                f"{sympy.sqrt(dot(d, d))}. Move them apart."
            )

    @property
    def is_conservative(self) -> bool:
        """True if it has no damping."""
        return bool(self.damping == 0)

    @staticmethod
    def _axis(joint: Joint) -> Vector:
        """Axis of a pulley, in the axes of the body that carries both."""
        return apply(joint.parent_axes, joint.primitives[0].axis)

    @property
    def _distance(self) -> Vector:
        """Vector from the axis of the first pulley to that of the second, in the carrier's axes."""
        return subtract(self.second.at, self.first.at)

    @property
    def _sense(self) -> int:
        """±1: the sense in which the second pulley's angle turns the belt, less the sense of a crossed belt."""
        alike = exact(dot(self._axis(self.first), self._axis(self.second)))
        return (1 if alike == 1 else -1) * (1 if self.run == "open" else -1)

    @property
    def _sine(self) -> Any:
        d = self._distance
        sign = 1 if self.run == "open" else -1
        radius, other = sympy.sympify(self.first_radius), sympy.sympify(self.second_radius)
        return (radius - sign * other) / sympy.sqrt(dot(d, d))

    def _spans(self, at: Any) -> list[FieldVector]:
        """Unit vectors along both spans, from the first pulley to the second, in ground axes."""
        d = self._distance
        e = scale(1 / sympy.sqrt(dot(d, d)), d)
        m = cross(self._axis(self.first), e)
        sine = self._sine
        cosine = sympy.sqrt(1 - sine**2)
        carrier = self.first.parent
        along, across = at.vector(scale(cosine, e), carrier), at.vector(scale(sine, m), carrier)
        return [along - across, along + across]

    @property
    def strand(self) -> tuple[Point, ...]:
        """The belt as a closed line: along one span, around the second pulley, back, and around the first.

        A span leaves the first pulley at the angle φ = π/2 - β from the line of centres; the belt holds the second one
        between the angles ±φ, or ±(π/2 + β) if it is crossed.
        """
        d, tilt = self._distance, sympy.asin(self._sine)
        e = scale(1 / sympy.sqrt(dot(d, d)), d)
        m = cross(self._axis(self.first), e)
        sense = 1 if self.run == "open" else -1
        first, second = sympy.pi / 2 - tilt, sympy.pi / 2 - sense * tilt
        steps = [sympy.Rational(k, PIECES) for k in range(PIECES + 1)]
        angles = [(self.second, self.second_radius, sense * second * (1 - 2 * x)) for x in steps]
        angles += [(self.first, self.first_radius, -first - 2 * (sympy.pi - first) * x) for x in steps]
        result = []
        for joint, radius, angle in (*angles, angles[0]):
            arm = add_vectors(scale(radius * sympy.cos(angle), e), scale(radius * sympy.sin(angle), m))
            result.append(Point(self.first.parent, add_vectors(joint.at, arm)))
        return tuple(result)

    def _elastic(self, at: Any) -> list[Scalar]:
        """Tensions without damping; negative where a span is slack."""
        x = at(self.first_radius) * at.displacement(self.first)
        x = at(self.stiffness) * (x - self._sense * at(self.second_radius) * at.displacement(self.second))
        return [at(self.tension) + x, at(self.tension) - x]

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the pull of both spans on the pulleys, at their axes, and the couples of the tensions."""
        tensions = elastic = self._elastic(at)
        if self.damping != 0:
            rate = at(self.first_radius) * at.rate(self.first)
            rate = at(self.damping) * (rate - self._sense * at(self.second_radius) * at.rate(self.second))
            tensions = [at.max(elastic[0] + rate, 0), at.max(elastic[1] - rate, 0)]
        one, two = (at.where(e, t, 0) for e, t in zip(elastic, tensions, strict=True))
        upper, lower = self._spans(at)
        pull = one * upper + two * lower
        n = at.vector(self._axis(self.first), self.first.parent)
        sense = 1 if self.run == "open" else -1
        yield PointForce(Point(self.first.child, self.first.to), pull)
        yield PointForce(Point(self.second.child, self.second.to), -pull)
        yield Couple(self.first.child, at(self.first_radius) * (two - one) * n)
        yield Couple(self.second.child, sense * at(self.second_radius) * (one - two) * n)

    def potential(self, at: Any) -> Scalar:
        """Return (T_1² + T_2²)/(2 k) of the taut spans [J]."""
        one, two = (at.where(e, e * e, 0) for e in self._elastic(at))
        return divide(HALF * (one + two), at(self.stiffness))


def belt(
    system: Description,
    name: str,
    first: tuple[Joint, Expression],
    second: tuple[Joint, Expression],
    *,
    stiffness: Expression = None,
    tension: Expression = 0,
    damping: Expression = 0,
    run: str = "open",
) -> Load:
    """Add an elastic belt, or a chain, around the pulleys of two hinges in one body.

    Its two spans have tensions of their own; the bearings of the pulleys feel both.

    Parameters
    ----------
    name : str
    first, second : (hinge, expression)
        The hinge of each pulley, and its radius [m].
    stiffness : expression
        k of each span [N/m]; E A/L of a belt of cross section A and span L. A rigid belt is refused: it has no tensions
        of its own, but a ratio, which is a condition such as ``s.constrain("r*p = R*q")``.
    tension : expression
        T_0, of both spans with the coordinates zero [N]; without it one span is slack whenever the other pulls.
    damping : expression
        Of each span [N s/m].
    run : "open" or "crossed"
        A crossed belt turns the pulleys against each other.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("belt")
    >>> r, R, k, T, M = s.parameters(r=0.1, R=0.3, k=2000.0, T=100.0, M=2.0)
    >>> small, large = s.body("small", fb.disk(1, r)), s.body("large", fb.disk(9, R))
    >>> one = s.hinge("one", s.ground, small, coordinate="p")
    >>> two = s.hinge("two", s.ground, large, at=(1, 0, 0), coordinate="q")
    >>> drive = s.belt("belt", (one, r), (two, R), stiffness=k, tension=T)
    >>> brake = s.torsion_spring("brake", two, stiffness=50)
    >>> still = fb.compile(s).forward_dynamics([0.3, 0.1], [0, 0])
    >>> still.round(9)  # the belt is where it was tightened: only the brake turns the large pulley
    array([  0.        , -12.34567901])
    """
    for pulley in (first, second):
        if not isinstance(pulley, list | tuple) or len(pulley) != 2:
            raise ModelError(f"Expected a pulley of belt '{name}' as (hinge, radius), got {shown(pulley)}.")
    (one, radius), (two, other) = first, second
    if stiffness is None or isinstance(stiffness, float | sympy.Basic) and abs(stiffness) == sympy.oo:
        raise ModelError(
            f"Expected the stiffness of each span of belt '{name}' [N/m], got {shown(stiffness)}. A belt without "
            f"stretch does not determine its two tensions, which the bearings feel. Give stiffness=, E A/L of a span. "
            f"Where the ratio alone matters, couple the coordinates of {shown(one)} and {shown(two)} by "
            f"s.constrain."
        )
    return add(system, name, Belt(one, two, radius, other, stiffness, tension, damping, run))
