"""The protocol of a contact by its gap: what closes and opens, and the forces that then act.

    0 ≤ g ⊥ N ≥ 0,      |T| ≤ μ_s N in stick,      T = -μ_k N γ/|γ| in slip

g is a function of the state; N acts by the actions of `normal` per newton, T by those of `tangents`. The row of N is
the exact derivative of g, those of T follow from the power of their actions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeAlias, dataclass_transform

from ...errors import ModelError
from ...scalar.algebra import Expression, Scalar
from ..frame import Frame, Point
from ..loads.action import Action
from ..part import SORTS, Constant, Part, register
from .coefficients import at_rest, bounce, friction_law, static_law
from .system_contacts import impact_law

FrictionLaw: TypeAlias = Expression
"""A coefficient of friction, an expression that may depend on `slip` (`coefficients`)."""
GAPS: dict[str, type[Gap]] = {}
"""Kinds of contacts by their gaps that model files know, by name."""


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
@dataclass(frozen=True, repr=False)
class Gap(Part):
    """A kind of contact by its gap: subclass it, declare its data as fields, and say its gap and its direction.

    The fields of a subclass are those of :class:`freebody.Load`, and every contact has ``friction``,
    ``static_friction``, ``restitution`` and ``impact``, given by name (:meth:`System.contact` explains them).

    ``gap(at)`` returns the distance that cannot become negative [m] or [rad]; ``at`` is the machine at a state, as
    loads get it. ``normal(at)`` yields the actions of a normal force of 1 N: ``fb.PointForce`` on the one body and its
    opposite on the other, or ``fb.JointForce`` along a joint. Their power must be the rate of the gap
    (:func:`freebody.testing.check_contact` compares). ``tangents(at)`` returns, for friction, one sequence of such
    actions, or two at right angles, of a tangential force of 1 N each. ``at.spot(body, position)`` is a place on a body
    that may move over it, such as the point of contact.

    Examples
    --------
    >>> import freebody as fb
    >>> class Wall(fb.Gap):
    ...     point: fb.Point
    ...
    ...     def gap(self, at):
    ...         return at.position(self.point)[0]
    ...
    ...     def normal(self, at):
    ...         yield fb.PointForce(self.point, (1, 0, 0))
    >>> s = fb.System("ball and wall")
    >>> ball = s.body("ball", fb.particle(1))
    >>> guide = s.slider("guide", s.ground, ball, axis="x", coordinate="x")
    >>> s.add("wall", Wall(ball.origin, restitution=0.5))
    wall 'wall'
    >>> motion = fb.simulate(s, 2, initial={"x": 1, "x'": -1})
    >>> print(f"{motion['x'][-1]:.3f}")
    0.500
    """

    friction: FrictionLaw = field(default=0, kw_only=True)
    static_friction: FrictionLaw = field(default=None, kw_only=True)
    restitution: Constant = field(default=0, kw_only=True)
    impact: str = field(default="newton", kw_only=True)

    table: ClassVar[str] = "contacts"
    article: ClassVar[str] = "contact"
    base: ClassVar[str] = "fb.Gap"
    rules: ClassVar[str] = (
        "Gap, normal and tangents are formulas of what `at` gives, without if on a value; fb.Load lists what they may "
        "use."
    )
    held: ClassVar[bool] = False
    """True if a constant normal force of 1 holds it closed: friction up to the coefficients themselves."""
    loaded: ClassVar[bool] = False
    """True if the load of its joint is that normal force."""
    directions: ClassVar[int] = 1
    """Number of tangents, 1 or 2, if there is friction."""
    one_at_a_time: ClassVar[bool] = False
    """True if at most one of its ``elements`` can be closed."""

    def __init_subclass__(cls, *, kind: str = "") -> None:
        super().__init_subclass__()
        register(cls, kind, GAPS)

    def __repr__(self) -> str:
        return f"{self.noun} '{self.name}'" if self.noun else super().__repr__()

    def gap(self, at: Any) -> Scalar:
        """Return the gap at a state [m] or [rad]."""
        raise ModelError(
            f"{self.title}: its class {type(self).__name__} has no gap. Define gap(self, at), which returns the "
            f"distance that cannot become negative."
        )

    def normal(self, at: Any) -> Iterator[Action]:
        """Yield the actions of a normal force of 1 N."""
        raise ModelError(
            f"{self.title}: its class {type(self).__name__} has no normal. Define normal(self, at), which yields the "
            f"actions of a normal force of 1 N, such as fb.PointForce(self.point, direction)."
        )

    def tangents(self, at: Any) -> Sequence[Sequence[Action]]:
        """Return the actions of a tangential force of 1 N, for each of up to two directions."""
        return ()

    @property
    def elements(self) -> Sequence[tuple[str, Gap]]:
        """The gaps of the contact, each with the ending of its name."""
        return (("", self),)

    @property
    def bodies(self) -> tuple[Frame, Frame]:
        """The body on which the forces act, and the one on which their opposites act."""
        found = []
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            if isinstance(value, Point):
                found.append(value.body)
            elif isinstance(value, Frame):
                found.append(value)
        joint = getattr(self, "joint", None)
        if joint is not None:
            found[:0] = [joint.child, joint.parent]
        found = list(dict.fromkeys(found))
        if not found:
            raise ModelError(
                f"{self.heading} has no point, body or joint among its fields, so that it is between no bodies. Give "
                f"its class one, such as point: fb.Point."
            )
        return found[0], found[1] if len(found) > 1 else found[0].system.ground

    @property
    def limits(self) -> tuple[Any, Any]:
        """The coefficients of slip and of stick."""
        return self.friction, at_rest(self.friction) if self.static_friction is None else self.static_friction

    @property
    def turns(self) -> bool:
        """True if the gap, or what friction resists, is an angle: its forces are moments."""
        joint = getattr(self, "joint", None)
        return joint is not None and joint.primitives[getattr(self, "index", 0)].turns

    @property
    def parts(self) -> tuple[str, str]:
        """What touches what, in words."""
        joint = getattr(self, "joint", None)
        first, second = (body.name for body in self.bodies)
        what = self.noun or repr(self).partition(" '")[0]
        return (f"{what} of {joint.name}", "-") if joint is not None else (f"{what} of {first}", second)

    def check(self) -> None:
        """Refuse laws that no contact can have."""
        check_laws(self)


def check_laws(gap: Gap) -> None:
    """Refuse coefficients that are out of range."""
    system: Any = gap.bodies[0].system
    static_law(system, gap.static_friction, gap.friction, gap.title)
    bounce(system, gap.restitution, gap.title)
    impact_law(gap.impact, gap.title)


SORTS["FrictionLaw"] = lambda system, value, gap, name: friction_law(
    system, value, gap.title, name.replace("_", " ")
)
