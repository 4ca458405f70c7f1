"""Families of contacts of a model: members, which are shapes that touch at one point, and the pairs that may touch.

Each corner and each end of a side is a member of its own. No list of pairs exists: whether two members may touch
follows from their kinds, bodies and groups (`Family.meet`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property
from itertools import compress

from ..describe.contacts.family import ContactFamily
from ..describe.shapes.shape import ContactShape, have_law
from ..describe.system import System
from ..errors import ModelError, nearest
from ..scalar.algebra import IDENTITY, Vector
from .contact import LETTERS, Contact, check_axes, frames_at_rest, moves_across, upright_of, within
from .model import Model
from .patched import Patched, contacts_of, corners_on, parts_of, places_of
from .resistance import ROLLING, SPINNING, resistances
from .ring import turning


@dataclass(frozen=True)
class Member:
    """One shape of a family that touches at one point.

    ``label`` is the body's name, followed by a number if the body has several members; ``group`` is 1 for the shapes
    that the others are ``against``.
    """

    label: str
    shape: ContactShape
    kind: str
    group: int


@dataclass(frozen=True)
class Family:
    """A family of contacts.

    Attributes
    ----------
    members : tuple of Member
    grouped : bool
        True if only members of different groups touch.
    joined : frozenset of two names each
        Pairs of bodies that do not touch: those joined directly, and those that the user holds apart.
    law : ContactFamily
        The family as described, with its laws.
    planar : unit vector or None
        Normal k of the plane of motion; the tangent is then n × k.
    upright : unit vector
        Ground axis against gravity.
    """

    name: str
    members: tuple[Member, ...]
    grouped: bool
    joined: frozenset[tuple[str, str]]
    law: ContactFamily
    planar: Vector | None
    upright: Vector

    def __repr__(self) -> str:
        return f"family of contacts '{self.name}'"

    @property
    def tangents(self) -> int:
        """Number of tangent directions: 1 in a planar machine, else 2."""
        return 2 if self.planar is None else 1

    def label(self, first: int, second: int) -> str:
        """Return the name of the contact of two members."""
        return f"{self.name}[{self.members[first].label},{self.members[second].label}]"

    def contact(self, first: int, second: int) -> Contact:
        """Return the contact of two members as one of its own."""
        a, b = self.members[first], self.members[second]
        name = self.label(first, second)
        tangents, law = LETTERS[self.tangents], self.law
        return Contact(
            name, self.name, a.shape, b.shape, law.friction, law.static_friction, law.restitution, law.impact,
            self.planar, self.upright, f"N_{name}", tuple(f"{letter}_{name}" for letter in tangents),
            normal_force=law.normal_force, friction_across=law.friction_across, along=law.along, adhesion=law.adhesion,
        )  # fmt: skip

    def resisting(self, contact: Contact) -> list[Contact]:
        """Return what resists the rolling and spinning of the contact of two members."""
        return [] if contact.stands else resistances(contact, self.law, set())

    @property
    def representatives(self) -> list[Contact]:
        """The contact of two members that may touch, with what resists its rolling and spinning: all have its laws."""
        for i in range(len(self.members)):
            for j in range(i + 1, len(self.members)):
                if self.meet(i, j):
                    one = self.contact(*self.ordered(i, j))
                    return [one, *self.resisting(one)]
        return []

    @property
    def rows(self) -> tuple[int, int, int]:
        """Numbers of tangents, of axes about which a resistance to rolling acts, and of those of one to spinning."""
        return self.tangents, self.tangents * int(self.law.rolling != 0), int(self.law.spinning != 0)

    def meet(self, first: int, second: int) -> bool:
        """Return whether two members may touch."""
        a, b = self.members[first], self.members[second]
        one, other = a.shape.body, b.shape.body
        if one is other or (self.grouped and a.group == b.group):
            return False
        return (one.name, other.name) not in self.joined and touch_each_other(a.shape, b.shape)

    def pair(self, name: str) -> tuple[int, int] | None:
        """Return the members whose contact has a name; None if there are none that may touch."""
        one, _, other = name.removeprefix(f"{self.name}[").removesuffix("]").partition(",")
        places = [self.places.get(label) for label in (one, other)]
        if None in places or not self.meet(places[0], places[1]):  # type: ignore[arg-type]
            return None
        return places[0], places[1]  # type: ignore[return-value]

    def element(self, name: str) -> Contact | None:
        """Return the contact of two members that has a name, or what resists its rolling or spinning."""
        for base in (name, *(name.removesuffix(f"_{about}") for about in (ROLLING, SPINNING))):
            pair = self.pair(base)
            if pair is not None:
                one = self.contact(*self.ordered(*pair))
                own = (one, *self.resisting(one))
                return next((x for x in own if x.name.endswith(name[len(base) :])), None)
        return None

    def ordered(self, first: int, second: int) -> tuple[int, int]:
        """Return two members as feature and surface: in their order, but a hollow is the surface."""
        first, second = min(first, second), max(first, second)
        swapped = turned(self.members[first].shape, self.members[second].shape)
        return (second, first) if swapped else (first, second)

    @cached_property
    def places(self) -> dict[str, int]:
        """Numbers of the members by their labels."""
        return {member.label: k for k, member in enumerate(self.members)}

    @cached_property
    def by_kind(self) -> dict[str, list[int]]:
        """Members of each kind."""
        result: dict[str, list[int]] = {}
        for i, member in enumerate(self.members):
            result.setdefault(member.kind, []).append(i)
        return result


def contact_named(model: Model, name: str) -> Contact | None:
    """Return the contact with a name, or that of two members of a family in either order; None if there is none."""
    for contact in model.contacts:
        if contact.name == name:
            return contact
    for family in (*model.families, *model.unrolled):
        found = family.element(name) if name.startswith(f"{family.name}[") else None
        if found is not None:
            return found
    return None


def meant_contact(model: Model, name: str) -> str:
    """Return the end of a message about the name of a contact that does not exist: what may be meant."""
    whole, _, inside = name.partition("[")
    names = [contact.name for contact in model.contacts]
    families = {family.name: family for family in (*model.families, *model.unrolled)}
    for near in get_close_matches(whole, families, n=1):
        family = families[near]
        labels = [
            (get_close_matches(x, family.places, n=1) or [""])[0] for x in inside.rstrip("]").split(",")
        ]
        likely = f"{near}[{','.join(labels)}]"
        if contact_named(model, likely) is not None:
            return f"did you mean '{likely}'?"
        if not names or inside:
            return (
                f"a contact of the family '{near}' has the names of two members that may touch, such as "
                f"'{family.label(0, len(family.members) - 1)}'."
            )
    return nearest(name, names) if names or families else f"'{model.name}' has no contacts."


def touch_each_other(first: ContactShape, second: ContactShape) -> bool:
    """Return whether there is a law of contact for two members: of their kinds, or in a patch."""
    return touch_in_patch(first, second) or have_law(first, second)


def touch_in_patch(first: ContactShape, second: ContactShape) -> bool:
    """Return whether two members touch in a patch: a solid with another one, a sphere, a point or a plane."""
    return any(
        a.patches and not (b.inside or b.enclosed) and (b.patches or b.endless or b.bound in ("spot", "ball"))
        for a, b in ((first, second), (second, first))
    )


def places_in_patch(first: ContactShape, second: ContactShape) -> bool:
    """Return whether two members touch in a patch whose points come and go, as those of corners on a plane do not."""
    if not touch_in_patch(first, second) or first.endless or second.endless:
        return False
    return not all(have_law(x, y) for x in first.parts(second) for y in second.parts(first))


def turned(first: ContactShape, second: ContactShape) -> bool:
    """Return whether the second of two members is the feature: a hollow, and the plane of a solid, is the surface."""
    return first.inside or (first.endless and second.patches)


def families(model: Model, system: System) -> tuple[Family, ...]:
    """Return the families of a model, in order of declaration.

    Raises
    ------
    ModelError
        If shapes touch at one point only while their axes are parallel, and the machine can turn these axes.
    """
    if not system.families:
        return ()
    flat = all((link.turns_only or link.slides_only or link.fixed) for link in model.links)
    frames = frames_at_rest(model.links) if flat else []
    planes = [k for k in (2, 1, 0) if flat and moves_across(model.links, frames, IDENTITY[k])]
    joined = frozenset(
        pair
        for joint in system.joints.values()
        if not (joint.parent.is_ground or joint.child.is_ground)
        for pair in ((joint.parent.name, joint.child.name), (joint.child.name, joint.parent.name))
    )
    result = []
    for family in system.families.values():
        members = tuple(_members(family))
        # the first one, with which the others are compared, is one that has a depth
        shapes = sorted((member.shape for member in members), key=lambda shape: shape.depth is None)
        in_plane = (all(within(model, frames, shapes[0], x, IDENTITY[k]) for x in shapes) for k in planes)
        k = next(compress(planes, in_plane), None)
        ends = [(a.name, b.name) for a, b in family.apart]
        apart = frozenset((*ends, *(pair[::-1] for pair in ends)))
        one = Family(
            family.name, members, bool(family.against), joined | apart, family,
            None if k is None else IDENTITY[k], upright_of(model.gravity),
        )  # fmt: skip
        _check_kinds(one, k)
        _check_laws(one)
        result.append(one)
    return tuple(result)


def _members(family: ContactFamily) -> Iterator[Member]:
    """Yield the members: the parts of the shapes that touch at one point, and that some other one may touch."""
    parts: list[tuple[str, ContactShape, int]] = []
    hollow = any(shape.inside for shape in (*family.shapes, *family.against))
    for group, shapes in enumerate((family.shapes, family.against)):
        for shape in shapes:
            own = [*shape.members, *(shape.enclosures if hollow else ())]
            parts += [(part.hollow if part.inside else part.kind, part, group) for part in own]
    kinds = {kind: part for kind, part, _ in parts}.values()
    parts = [it for it in parts if any(touch_each_other(it[1], other) for other in kinds)]
    count: dict[str, int] = {}
    for _, shape, _ in parts:
        count[shape.body.name] = count.get(shape.body.name, 0) + 1
    seen = dict.fromkeys(count, 0)
    for kind, shape, group in parts:
        body = shape.body.name
        seen[body] += 1
        yield Member(body if count[body] == 1 else f"{body}.{seen[body]}", shape, kind, group)


def _check_kinds(family: Family, k: int | None) -> None:
    """Refuse two cylinders, or a cylinder and a flat side, that do not touch in the plane of motion."""
    one_of = [members[0] for members in family.by_kind.values()]
    two_of = [members[-1] for members in family.by_kind.values()]
    for i in one_of:
        for j in two_of:
            if family.meet(i, j):
                check_axes(family.name, family.members[i].shape, family.members[j].shape, k)


def _check_laws(family: Family) -> None:
    """Refuse compliance, adhesion and resistance of solids that touch in patches, and spinning in a plane; two
    coefficients of friction in a plane, or over what is no surface.
    """
    law = family.law
    if law.along is not None and family.planar is not None:
        raise ModelError(
            f"The {law!r} has two coefficients of friction, but the machine moves in a plane, in which contacts slip "
            "along one line. Give the one coefficient of that line."
        )
    for a, b in ((a, b) for a in family.by_kind.values() for b in family.by_kind.values()):
        first, second = family.members[a[0]].shape, family.members[b[-1]].shape
        if not family.meet(a[0], b[-1]):
            continue
        surface = family.members[family.ordered(a[0], b[-1])[1]]
        if law.along is not None and surface.group == 0:
            raise ModelError(
                f"The {law!r} has two coefficients of friction along a direction of its surfaces, but the "
                f"{surface.shape.kind} of {surface.shape.body!r} is one, and none of against=. Exchange the shapes and "
                "those of against=."
            )
        if not places_in_patch(first, second):
            continue
        ball = any(shape.bound in ("spot", "ball") for shape in (first, second))
        words = {"normal": law.normal_force, "adhesion": law.adhesion}
        words |= {} if ball else {"rolling": law.rolling, "spinning": law.spinning}
        for name, given in words.items():
            if given is not None and given != 0:
                raise ModelError(
                    f"The {law!r} has {name}=, for shapes that touch at one point, but the {first.kind} of "
                    f"{first.body!r} and the {second.kind} of {second.body!r} touch in patches, whose points come and "
                    "go. Put them into a family of their own, without it."
                )
    family.representatives  # noqa: B018  refuses spinning in a plane


def contact_laws(model: Model) -> list[Contact]:
    """Return the contacts of a model, and those that have the laws of its families."""
    return [*model.contacts, *(contact for family in model.families for contact in family.representatives)]


def text_of_members(family: Family) -> str:
    """Return the members in words: how many of which kind, of how many bodies."""
    count = ", ".join(f"{len(members)} {kind}" for kind, members in family.by_kind.items())
    bodies = len({member.shape.body.name for member in family.members})
    return f"{count} of {bodies} bodies"


def unrolled(model: Model, most: int) -> Model | None:
    """Return the model for a motion by events; None if the pairs of its families are more than ``most``.

    These are contacts of their own, and the points on which disks stand that lie flat may turn.
    """
    contacts, turns, rings = turning(model.contacts)
    parameters, patches = [*model.parameters, *turns], list[Patched]()
    points = 0
    for f, family in enumerate(model.families):
        for i in range(len(family.members)):
            for j in range(i + 1, len(family.members)):
                if not family.meet(i, j):
                    continue
                first, second = family.ordered(i, j)
                whole = family.contact(first, second)
                a, b = whole.feature, whole.surface
                found = [whole]
                if places_in_patch(a, b):
                    kinds, at = places_of(a, b), len(contacts)
                    places = contacts_of(whole, kinds)
                    found = [contact for contact, _ in places]
                    parameters += [parameter for _, some in places for parameter in some]
                    names = tuple(tuple(parameter.name for parameter in some) for _, some in places)
                    each = 1 + len(family.resisting(found[0]))
                    own = tuple(range(at, at + each * len(found), each))
                    patches.append(Patched(model, f, first, second, whole, own, kinds, names))
                elif touch_in_patch(a, b):
                    found = corners_on(whole) if b.endless else parts_of(whole)
                for contact in found:
                    contacts += [contact, *family.resisting(contact)]
                points += len(found)
                if points > most:
                    return None
    return replace(
        model,
        contacts=tuple(contacts),
        families=(),
        unrolled=model.families,
        parameters=tuple(parameters),
        patches=tuple(patches),
        rings=tuple(rings),
    )
