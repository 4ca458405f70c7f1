"""The dictionary ``s.contacts`` of a system, which makes families of contacts when it is called."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields
from typing import Any

from ...errors import ModelError, arguments_named, shown
from ...scalar.algebra import Expression
from ..description import Description, changes_of, claim
from ..frame import Frame, own_body
from ..shapes.shape import ContactShape
from ..table import Table
from .anisotropy import is_pair
from .coefficients import bounce
from .family import ContactFamily
from .system_contacts import (
    SHAPES,
    bearable_pull,
    check_pair,
    compliant,
    coulomb,
    impact_law,
    resisting,
    shape_of,
)


@arguments_named
class ContactTable(Table):
    """The contacts of a system by name; a call adds a family of contacts."""

    named = "contacts"

    def __init__(self, system: Description) -> None:
        super().__init__(changes_of(system))
        self.system = system

    def __call__(
        self,
        name: str,
        shapes: Sequence[Any],
        *,
        against: Any = (),
        friction: Expression = 0,
        static_friction: Expression = None,
        restitution: Expression = 0,
        impact: str = "newton",
        normal: Expression = None,
        along: Any = None,
        adhesion: Expression = 0,
        rolling: Expression = 0,
        spinning: Expression = 0,
        apart: Sequence[tuple[Any, Any]] = (),
    ) -> ContactFamily:
        """Let each of these shapes touch each other one, by one law of contact.

        The pairs are those of :meth:`System.contact`, with the same laws. Left out are pairs of shapes of one body and
        pairs of two bodies that a joint joins directly; the ground does not count as a body here, so that a wheel on a
        slider may touch the floor. Pairs are found while the machine moves, at no cost for those that are apart: a
        thousand spheres are as easy to describe as two. Such a machine moves by ``method="timestepping"``, and
        by events if it is small.

        A member of the family has the name ``pile[b1,b2]``, with the names of the two bodies, and ``b1.3`` for the
        third place of a body that has several.

        Parameters
        ----------
        name : str
            The family is ``s.families[name]``.
        shapes : sequence of shapes of bodies
            Such as ``body.sphere(radius)``, ``body.corners(...)`` or ``s.ground.plane(...)``.
        against : shape or sequence of shapes, optional
            If given, the shapes touch these only, and not each other.
        friction, static_friction, restitution, impact, normal, adhesion, rolling, spinning : optional
            The laws of each pair, as for :meth:`System.contact`. Time steps know constant friction without another
            one at rest, and Newton's restitution. A normal force by the depth, adhesion and resistance are for pairs
            that touch at one point: not for solids with edges that touch each other.
        along : direction, optional
            Direction of the first of two coefficients of friction, in axes of the body of each shape of ``against``:
            these are the surfaces.
        apart : sequence of pairs of bodies, optional
            Bodies, or their names, that do not touch, such as parts of a robot whose solids overlap.

        Raises
        ------
        ModelError
            Two shapes without a law of contact, a shape given twice, shapes of one body only or of another system,
            coefficients out of range, pairs of bodies that are none.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("two balls on a floor")
        >>> balls = [s.body(f"b{i}", fb.sphere(1, 0.1)) for i in (1, 2)]
        >>> joints = [s.free(f"air{i}", s.ground, b) for i, b in enumerate(balls)]
        >>> shapes = [*(b.sphere(0.1) for b in balls), s.ground.plane(normal="z")]
        >>> s.contacts("pile", shapes, friction=0.5)
        family of contacts 'pile'
        """
        system, what = self.system, f"the family of contacts '{name}'"
        claim(system, name, "contact")
        own, others = _shapes(system, shapes, what), _shapes(system, against, f"'against' of {what}")
        _check_once((*own, *others), what)
        _check_pairs(own, others, what)
        if is_pair(friction) and not others:
            raise ModelError(
                f"Expected against= for {what}, whose friction has two coefficients: they are along a direction of a "
                "surface and across it, and among shapes that touch each other none is the surface. Name the "
                "surfaces by against=, or give one coefficient."
            )
        kinetic, across, static, direction = coulomb(system, friction, static_friction, along, others, what)
        e = bounce(system, restitution, what)
        law = None if normal is None else compliant(system, normal, (*own, *others), e, what)
        family = ContactFamily(
            name, own, others, kinetic, static, e, impact_law(impact, what),
            bearable_pull(system, adhesion, law, what), resisting(system, rolling, "rolling", what),
            resisting(system, spinning, "spinning", what), law, across, direction, _pairs(system, apart, what),
        )  # fmt: skip
        system.families[name] = family
        return family


def _shapes(system: Description, shapes: Any, what: str) -> tuple[ContactShape, ...]:
    if isinstance(shapes, Frame) or hasattr(shapes, "body"):
        shapes = (shapes,)
    if isinstance(shapes, str) or not isinstance(shapes, Iterable):
        raise ModelError(f"Expected a sequence of shapes for {what}, {SHAPES}, got {shown(shapes)}.")
    return tuple(shape_of(system, shape, what) for shape in shapes)


def _pairs(system: Description, apart: Any, what: str) -> tuple[tuple[Any, Any], ...]:
    """Return the pairs of bodies that do not touch."""
    pairs = []
    for pair in apart if isinstance(apart, Iterable) and not isinstance(apart, str) else (apart,):
        if isinstance(pair, str) or not isinstance(pair, Sequence) or len(pair) != 2:
            raise ModelError(
                f"Expected pairs of bodies for 'apart' of {what}, such as [('arm', 'hand')], got {shown(pair)}."
            )
        first, second = (own_body(system, one, f"'apart' of {what}") for one in pair)
        if first is second:
            raise ModelError(f"Expected two bodies in each pair of 'apart' of {what}, got {first!r} twice.")
        pairs.append((first, second))
    return tuple(pairs)


def _check_once(shapes: Sequence[Any], what: str) -> None:
    seen: set[Any] = set()
    for shape in shapes:
        key = (type(shape), *(getattr(shape, name) for name in (f.name for f in fields(shape))))
        if key in seen:
            raise ModelError(
                f"Expected every shape of {what} once, got two equal ones: {shape!r} at the same place. "
                "Leave one of them out."
            )
        seen.add(key)


def _check_pairs(own: Sequence[Any], others: Sequence[Any], what: str) -> None:
    """Refuse pairs without a law, and a family without a pair."""
    kinds: dict[Any, list[Any]] = {}
    for group, shapes in enumerate((own, others)):
        for shape in shapes:
            alike = getattr(shape, "radius", None) if shape.inside else None
            kinds.setdefault((group, shape.kind, shape.inside, alike), []).append(shape)
    keys, found = list(kinds), False
    for i, first in enumerate(keys):
        for second in keys[i:]:
            if others and first[0] == second[0]:
                continue
            pair = next(((a, b) for a in kinds[first] for b in kinds[second] if a.body is not b.body), None)
            if pair is None:
                continue
            found = True
            for shape in pair:
                if not shape.in_families:
                    raise ModelError(
                        f"A {shape.kind} cannot be one of {what}: its form is an expression of its own. Give it "
                        "contacts one by one, s.contact(name, feature, surface)."
                    )
            feature, surface = pair[::-1] if pair[0].inside else pair
            check_pair(feature, surface, what, CURE)
    if not found:
        raise ModelError(
            f"Expected shapes of two bodies or more for {what}, or of a body and the ground; none of these "
            f"{len(own) + len(others)} may touch another one."
        )


CURE = " Shapes that only touch some others: s.contacts(name, shapes, against=others)."
