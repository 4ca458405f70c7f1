"""Resistance of a contact to rolling and spinning: moments that the normal force bounds.

    rolling     |M_1, M_2| <= δ N, against the angular velocity along the tangents;    in a plane M <= δ N
    spinning    |M_n| <= δ_n N, against that along the normal

Each is an element of its own beside the contact, `floor_rolling` and `floor_spinning`: its mode is stick (no rolling)
or slip, its gap that of the contact, its normal force that of the contact.

Source: K. L. Johnson, Contact Mechanics (1985), section 9.3.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..describe.contacts.contact import ContactPair
from ..describe.contacts.gap import Gap
from ..describe.frame import Frame
from ..describe.loads.action import Action, Couple
from ..errors import ModelError
from .contact import Contact, Side, free_name

ROLLING, SPINNING = "rolling", "spinning"


class Resistance(Gap):
    """What resists the rolling, or the spinning, of a contact: couples along its tangents, or along its normal."""

    contact: Any
    about: str

    noun = "resistance"
    held = True

    @property
    def turns(self) -> bool:
        """True: it is a moment against an angular velocity."""
        return True

    @property
    def bodies(self) -> tuple[Frame, Frame]:
        """The bodies of the contact."""
        return self.contact.feature.body, self.contact.surface.body

    def gap(self, at: Any) -> Any:
        """Return the gap of the contact."""
        return at.pressed(self.contact)[0].gap

    def normal(self, at: Any) -> Iterator[Action]:
        """Yield nothing: the contact has the normal force."""
        yield from ()

    def tangents(self, at: Any) -> Sequence[Sequence[Action]]:
        """Return the couples of a moment of 1 N m about each axis."""
        first, second = self.bodies
        return [(Couple(first, e), Couple(second, -e)) for e in self._axes(at)]

    def rates(self, at: Any) -> Sequence[Any]:
        """Return the angular velocity of the feature over the surface about each axis."""
        first, second = self.bodies
        turn = at.angular_velocity(first) - at.angular_velocity(second)
        return [turn.dot(e) for e in self._axes(at)]

    def _axes(self, at: Any) -> Sequence[Any]:
        """Return the axes of the moments, in ground axes."""
        touch = at.pressed(self.contact)[0]
        tangents = touch.tangents if self.contact.planar is None else (self.contact.planar,)
        return [at.vector(e) for e in ((touch.normal,) if self.about == SPINNING else tangents)]


def with_resistances(contacts: Sequence[Contact], pairs: Mapping[str, Any]) -> tuple[Contact, ...]:
    """Return the elements of contacts, each followed by those that resist its rolling and spinning.

    Raises
    ------
    ModelError
        Spinning in a machine that moves in a plane.
    """
    taken, result = {*pairs, *(contact.name for contact in contacts)}, list[Contact]()
    for contact in contacts:
        pair = pairs[contact.owner]
        rolls = isinstance(pair, ContactPair) and not contact.stands
        result += [contact, *(resistances(contact, pair, taken) if rolls else ())]
    return tuple(result)


def pressers(contacts: Sequence[Contact]) -> list[int]:
    """Return for each element the place of that whose normal force bounds it; -1 for contacts themselves."""
    places = {contact.name: k for k, contact in enumerate(contacts)}
    return [places[contact.presser] if contact.presser else -1 for contact in contacts]


def resistances(contact: Contact, pair: Any, taken: set[str]) -> list[Contact]:
    """Return the elements that resist the rolling and spinning of an element, with the lengths of its pair or family.

    ``taken`` are names, to which theirs are added.
    """
    result = []
    for about, length in ((ROLLING, pair.rolling), (SPINNING, pair.spinning)):
        if length == 0:
            continue
        if about == SPINNING and contact.planar is not None:
            raise ModelError(
                f"{str(pair).capitalize()} resists spinning about its normal, but the machine moves in a plane and "
                f"does not spin so. Leave spinning= out."
            )
        letters = ("M",) if contact.planar is not None else ("M1", "M2") if about == ROLLING else ("M3",)
        own = free_name(f"{contact.name}_{about}", taken)
        law = Resistance(contact, about, friction=length, name=own)
        first, second = map(Side, law.bodies)
        result.append(
            Contact(
                own, contact.owner, first, second, length, length, 0, "newton", None, contact.upright,
                f"N_{own}", tuple(f"{letter}_{contact.name}" for letter in letters), law, presser=contact.name,
            )
        )  # fmt: skip
    return result
