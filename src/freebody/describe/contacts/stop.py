"""The stops of a joint, or of an expression of coordinates: it stays between two values.

    low ≤ y ≤ high:      g = y - low,      g = high - y

N acts along the displacement y, and moves the joint away from the stop.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import sympy
from sympy.core.function import AppliedUndef

from ...errors import ModelError, shown
from ...scalar.algebra import Expression, Scalar
from ...scalar.expression import exact
from ..constants import default_value
from ..description import Description, coordinates_of, names_of
from ..frame import Frame
from ..joints.joint import Joint, turns_freely
from ..loads.action import Action, GeneralizedForce, JointForce
from ..loads.displacement import check_displacement
from ..loads.joint_stop import JointStop
from ..loads.load import Load
from ..part import Constant, add
from .gap import Gap
from .turn import TurnStop


class _Stops(Gap):
    """What stops of a displacement, between the fields ``low`` and ``high``, have in common."""

    noun = "stop"
    one_at_a_time = True

    @property
    def ends(self) -> tuple[Any, Any]:
        """The values at which it stops, None for no stop."""
        own: Any = self
        return own.low, own.high

    def check(self) -> None:
        """Refuse a stop at no end, and ends in the wrong order."""
        if self.ends == (None, None):
            raise ModelError(f"{self.heading} stops nothing. Give low= or high=, or both.")
        if None not in self.ends:
            system: Any = self.bodies[0].system
            low, high = (default_value(system, x) for x in self.ends)
            if low is not None and high is not None and not low < high:
                raise ModelError(
                    f"Expected low below high for {self.title}, got {low:g} and {high:g}. Exchange them; what cannot "
                    f"move at all is a constraint, s.constrain."
                )
        super().check()

    @property
    def elements(self) -> Sequence[tuple[str, Gap]]:
        """The stop at the low end, and that at the high one."""
        if None in self.ends:
            return (("", self),)
        own: Any = self
        return (("low", replace(own, high=None)), ("high", replace(own, low=None)))

    def gap(self, at: Any) -> Scalar:
        """Return the distance to the stop."""
        y, (low, high) = self.displacement(at), self.ends
        return at(high) - y if low is None else y - at(low)

    def displacement(self, at: Any) -> Scalar:
        """Return the displacement that the stops limit."""
        raise NotImplementedError


class Stop(_Stops, kind="stop"):
    """The stops of a displacement of a joint, at the values ``low`` and ``high`` if they are given."""

    joint: Joint
    low: Constant = None  # [m] or [rad]
    high: Constant = None
    index: int = 0

    words = {"index": "coordinate"}

    def check(self) -> None:
        """Refuse a joint without such a displacement, and stops in the wrong order."""
        check_displacement(self.joint, self.index, self.title)
        super().check()

    def displacement(self, at: Any) -> Scalar:
        """Return that of the joint."""
        return at.displacement(self.joint, self.index)

    def normal(self, at: Any) -> Iterator[Action]:
        """Yield the force along the joint."""
        yield JointForce(self.joint, -1 if self.low is None else 1, self.index)


class CoordinateStop(_Stops, kind="coordinate_stop"):
    """The stops of an expression of coordinates, at the values ``low`` and ``high`` if they are given."""

    expression: Expression
    low: Constant = None
    high: Constant = None
    body: Frame | None = None

    @property
    def turns(self) -> bool:
        """True if all its coordinates are angles."""
        moving = self.expression.atoms(AppliedUndef)
        joints: Any = self.bodies[0].system.joints.values()
        moved = [
            one for joint in joints for one in joint.primitives
            if isinstance(one.coordinate, sympy.Basic) and moving & one.coordinate.atoms(AppliedUndef)
        ]  # fmt: skip
        return bool(moved) and all(one.turns for one in moved)

    def displacement(self, at: Any) -> Scalar:
        """Return the expression."""
        return at(self.expression)

    def normal(self, at: Any) -> Iterator[Action]:
        """Yield the generalized forces ∂g/∂q."""
        for atom in sorted(self.expression.atoms(AppliedUndef), key=str):
            slope = at(exact(self.expression.diff(atom)))
            yield GeneralizedForce(atom, -slope if self.low is None else slope)


def stop(
    system: Description,
    name: str,
    on: Any,
    *,
    low: Expression = None,
    high: Expression = None,
    restitution: Expression = 0,
    coordinate: int = 0,
    stiffness: Expression = None,
    damping: Expression = 0,
) -> Gap | Load:
    """Let a joint stop at ``low`` and at ``high``: its displacement stays between them.

    A stop is a contact: rigid, with a force that only pushes away from it and Newton's restitution, or with a
    ``stiffness`` a one-sided spring, whose switches are located.

    Parameters
    ----------
    name : str
        The force on the stopped joint is ``N_name``; for stops at both ends ``N_name_low`` and ``N_name_high``.
    on : Joint, coordinate or expression of coordinates
        Such as a hinge, ``"theta"`` or ``q2 - q1``. On a ball or free joint the angle of the turn, about whatever axis,
        stops at ``high``, less than π.
    low, high : expressions of parameters [m] or [rad]
        One of them may be left out.
    restitution : expression of parameters, optional
        Between 0 and 1.
    coordinate : int, optional
        Which displacement, of a joint that has several.
    stiffness, damping : expressions of parameters, optional
        Of a compliant stop [N/m, N s/m] or [N m/rad, N m s/rad]: f = max(k d + c d', 0) at the depth d.

    Raises
    ------
    ModelError
        No end, ends in the wrong order, a joint without such a displacement, or restitution of a compliant stop.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum at a wall")
    >>> s.gravity = (0, -9.81, 0)
    >>> bar = s.body("bar", fb.slender_bar(1, 1, axis="y"))
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, 0.5, 0), axis="z", coordinate="theta")
    >>> s.stop("wall", pin, low=0, restitution=0.5)
    stop 'wall'
    >>> print(fb.simulate(s, 0.5, initial={"theta": 0.5}).events)
    t = 0.415978 s: wall: impact, normal speed -1.89809 → 0.949045 rad/s
    """
    title = f"stop '{name}'"
    compliant = stiffness is not None
    if not compliant and not (isinstance(damping, int) and damping == 0):
        raise ModelError(
            f"{title.capitalize()} has a damping but no stiffness. Give stiffness= too, or restitution= for a rigid "
            f"stop."
        )
    if compliant and not (isinstance(restitution, int) and restitution == 0):
        raise ModelError(
            f"{title.capitalize()} has a stiffness and a restitution. A compliant stop loses energy by damping=: "
            f"choose one of them."
        )
    if turns_freely(on, coordinate):
        if compliant or low is not None or high is None:
            what = "a stiffness" if compliant else "low=" if low is not None else "no end"
            raise ModelError(
                f"{title.capitalize()} has {what}, but {on.type} joint '{on.name}' has a turn, an angle from 0 to π "
                f"about any axis: give high= alone."
            )
        return add(system, name, TurnStop(on, high, restitution=restitution))
    if isinstance(on, Joint):
        if compliant:
            return add(system, name, JointStop(on, stiffness, low, high, damping, coordinate))
        return add(system, name, Stop(on, low, high, coordinate, restitution=restitution))
    expression = _of_coordinates(system, on, title)
    if compliant:
        raise ModelError(
            f"A compliant {title} is a load on a joint, got {shown(on)}. Name the joint, or write the law by "
            f"s.generalized_force."
        )
    return add(system, name, CoordinateStop(expression, low, high, system.ground, restitution=restitution))


def _of_coordinates(system: Description, on: Any, title: str) -> Any:
    """Return an expression of coordinates that a stop limits."""
    expression = system.expression(on, f"the displacement of {title}")
    names = names_of(system)
    known = set(coordinates_of(system))
    moving = names.depends(expression, "coordinate")
    bad = [*names.depends(expression, "speed", "time"), *(x for x in moving if x not in known)]
    if not moving or bad:
        raise ModelError(
            f"Expected a joint or an expression of coordinates for {title}, got {shown(on)}"
            + (f", which depends on {', '.join(bad)}." if bad else ".")
            + " The coordinates of ball and free joints have contacts instead, s.contact."
        )
    if isinstance(expression, sympy.Basic) and expression.has(sympy.sign, sympy.Abs, sympy.Max, sympy.Min):
        raise ModelError(
            f"Expected a displacement without a jump or a bend for {title}, got {shown(on)}: where it bends, the force "
            "of the stop has no direction. Limit each part by a stop of its own: abs(y) to h by low=-h, high=h of y, "
            "max(a, b) by a stop of a and one of b."
        )
    return expression
