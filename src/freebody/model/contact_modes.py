"""Contacts in given modes: closed ones are conditions of the machine, and forces that the state gives are loads.

rigid       N, and T in stick, are forces of conditions;  T = -μ N d in slip acts with N
adhesion    N is the force of a condition;  -μ A d in slip, of T = -μ (N + A) d, is a load
bearing     T = -μ P d in slip is a load, of the load P of a joint, which is a number that its reaction gives
rolling     M = -δ (N + A) d in slip is a load, as is that of spinning, of N + A of its contact as a number
compliant   N = N(d, d') is a load, as is T = -μ N d in slip; T in stick is the force of a condition
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy

from ..describe.contacts.coefficients import SLIP
from ..describe.description import Parameter
from ..describe.loads.action import Action, PointForce
from ..describe.loads.load import Load, Look
from ..errors import ModelError, nearest
from ..scalar.algebra import ZERO, Expression, Vector, add, divide, dot, negate, scale
from .contact import Contact, elliptic_friction
from .family import Family
from .model import Model


@dataclass(frozen=True)
class Touching:
    """A closed contact: a condition of the machine while it stays closed.

    ``direction`` is the direction of the slip velocity along the tangents. It is empty if the state gives the
    direction, and None if the contact does not slip.
    """

    contact: Contact
    direction: tuple[Expression, ...] | None

    @property
    def slips(self) -> bool:
        """True if the feature slips over the surface."""
        return self.direction is not None


class Pressing(Load):
    """The normal force of a compliant contact that is closed, a law of its depth: on the feature, and its opposite."""

    contact: Any

    noun = "normal force"
    look = Look("spring")

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the normal force on the feature, and its opposite on the surface."""
        it, _, N = at.pressed(self.contact)
        yield from at_the_touch(at, self.contact, it, scale(N, it.normal))


class Sliding(Load):
    """The friction of a slip under a normal force that the state gives, T = -μ N d: 1 in a joint, or a law of depth.

    The adhesion A of a rigid contact is such a force too: its friction is that of N, found with N, and -μ A d.
    ``direction`` is d along the tangents; without one it is that of the slip.
    """

    contact: Any
    direction: Any = ()

    noun = "friction"
    look = Look("damper")

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the friction."""
        contact = self.contact
        law = contact.law
        if law is not None:
            way, rows = tuple(map(at, self.direction)), law.tangents(at)
            if not way:
                way = _along(at, law.rates(at))[1]
            size = at.of(contact.friction, {SLIP: way[0] * law.slip(at) if contact.slows else 0})
            if contact.bounded:
                size = at(sympy.Symbol(contact.normal_name, real=True)) * size
            elif contact.presser:
                size = at.pressed(law.contact)[2] * size
            for d, row in zip(way, rows, strict=True):
                for action in row:
                    yield action.times(-d * size)
            return
        it, v, N = at.pressed(contact)
        slips = [dot(t, v) for t in it.tangents]
        if self.direction:
            way = tuple(map(at, self.direction))
            slip = sum((d * x for d, x in zip(way, slips, strict=True)), 0)
        else:
            slip, way = _along(at, slips)
        if contact.friction_across is None:
            mu = at.of(contact.friction, {SLIP: slip})
            shares = [mu * d for d in way]
        else:
            shares = elliptic_friction(way, tuple(map(at, contact.coefficients)), at.sqrt)
        total = ZERO
        for share, t in zip(shares, it.tangents, strict=True):
            total = add(total, scale(share, t))
        yield from at_the_touch(at, contact, it, scale(-N, total))


def _along(at: Any, slips: Sequence[Any]) -> tuple[Any, tuple[Any, ...]]:
    """Return the size of a slip and its direction, along tangents or axes."""
    slip = at.sqrt(sum((x * x for x in slips), 0))
    return slip, tuple(divide(x, slip) for x in slips)


def at_the_touch(at: Any, contact: Contact, touch: Any, force: Vector) -> Iterator[Action]:
    """Yield a force on the feature where two shapes touch, and its opposite on the surface."""
    yield PointForce(at.spot(contact.feature.body, touch.on_feature), force)
    yield PointForce(at.spot(contact.surface.body, touch.on_surface), negate(force))


MODES = ("open", "closed", "stick", "slip+", "slip-", "slip")


def in_modes(model: Model, modes: Any) -> Model:
    """Return the model whose contacts keep their modes: closed contacts are conditions, as its constraints are.

    Parameters
    ----------
    model : Model
    modes : mapping of str to mode
        Modes by name of a contact, or of one of its elements: "open", "stick" (round features then roll), "slip+"
        and "slip-" (by the sign of the slip velocity along the tangent), "slip" (in 3-D: along the slip velocity of
        the state), or ("slip", (d1, d2)) with a given direction of slip. Contacts without a mode are open.

    Raises
    ------
    ModelError
        If a contact or mode is unknown, if a mode has a sign in 3-D or none in the plane, if a contact without
        friction sticks, or if a joint is at both of its stops.
    """
    names = {c.name for c in model.contacts} | {c.owner for c in model.contacts}
    for name in modes:
        if name not in names:
            raise ModelError(
                f"Unknown contact '{name}' in modes; {nearest(str(name), sorted(names))}"
                if names
                else f"Unknown contact '{name}' in modes: {_none(model)} Declare one by s.contact."
            )
    closed: dict[str, Any] = {}
    given: dict[str, Load] = {}
    elements = {c.name for c in model.contacts}
    for contact in model.contacts:
        # a name that an element shares with its contact means the element only
        whole = "open" if contact.owner in elements else modes.get(contact.owner, "open")
        mode = modes.get(contact.name, whole)
        touching = _touching(model, contact, mode)
        if touching is None:
            continue
        if contact.compliant:
            given[contact.normal_name] = Pressing(contact, name=contact.normal_name)
        if touching.slips and not contact.frictionless and (contact.held or contact.adhesion != 0):
            name = contact.friction_name
            given[name] = Sliding(contact, touching.direction or (), name=name)
        if not contact.held or not touching.slips:
            closed[contact.name] = touching
    by_owner = {one.contact.owner: one.contact for one in closed.values()}
    for one in closed.values():
        first, last = one.contact, by_owner[one.contact.owner]
        if first is not last and first.law is not None and first.law.one_at_a_time:
            raise ModelError(
                f"'{first.name}' and '{last.name}' cannot be closed at once: they are the two ends of "
                f'{first.law.title}. Close one of them, modes={{"{first.name}": "closed"}}.'
            )
    return replace(
        model,
        constraints={**model.constraints, **closed},
        loads={**model.loads, **given},
        parameters=(*model.parameters, *pressures(model, given)),
    )


def _none(model: Model) -> str:
    """Return the sentence about a machine without contacts by `s.contact`."""
    if model.families:
        return f"{no_equations_of(model.families[0])}."
    return "this machine has no contacts."


def no_equations_of(family: Family) -> str:
    """Return the sentence about the contacts of a family, without its full stop."""
    return f"the contacts of the family '{family.name}' are those of a motion, and have no equations"


def pressures(model: Model, given: Mapping[str, Load]) -> list[Parameter]:
    """Return the forces that bound the friction of slips in joints, and what resists rolling and spinning: they are
    known with the reactions, as numbers.
    """
    known = {parameter.name for parameter in model.parameters}
    names = [x.contact.normal_name for x in given.values() if isinstance(x, Sliding) and x.contact.bounded]
    return [Parameter(name, sympy.Symbol(name, real=True), None) for name in names if name not in known]


def _touching(model: Model, contact: Contact, mode: Any) -> Touching | None:
    """The closed contact for a mode, None if it is open."""
    name = contact.name
    if mode == "open":
        return None
    if mode == "closed":
        if contact.tangents and not contact.frictionless:
            raise ModelError(
                f"Contact '{name}' has friction: expected the mode 'stick', or that of its slip, got 'closed'."
            )
        return Touching(contact, ())
    if mode == "stick":
        if contact.frictionless:
            raise ModelError(f"Contact '{name}' has no friction and cannot stick. Its mode is 'slip'.")
        return Touching(contact, None)
    if mode in ("slip+", "slip-"):
        if contact.tangents == 2:
            raise ModelError(
                f"Contact '{name}' can slip in two directions: expected 'slip', or ('slip', (d1, d2)), got '{mode}'."
            )
        return Touching(contact, (1,) if mode == "slip+" else (-1,))
    if mode == "slip":
        if contact.tangents == 1 and not contact.frictionless:
            raise ModelError(
                f"Contact '{name}' slips along one line: expected 'slip+' or 'slip-', by the sign of its slip "
                f"velocity, got 'slip'."
            )
        return Touching(contact, ())
    if isinstance(mode, tuple) and len(mode) == 2 and mode[0] == "slip" and hasattr(mode[1], "__len__"):
        if len(mode[1]) != contact.tangents:
            raise ModelError(
                f"Contact '{name}' has {contact.tangents} tangent directions, got {len(mode[1])} components of slip."
            )
        what = f"the direction of slip of contact '{name}'"
        return Touching(contact, tuple(model.names.expression(x, what) for x in mode[1]))
    raise ModelError(f"Unknown mode {mode!r} of contact '{name}'; expected one of {', '.join(MODES)}.")
