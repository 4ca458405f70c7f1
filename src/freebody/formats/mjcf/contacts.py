"""Contacts of an MJCF file: geoms of bodies that move touch the planes of the world, and each other.

Two geoms may touch if the type of one is among the affinities of the other, or if a <pair> names them, and no <exclude>
names their bodies. The friction of two geoms is that of the one of higher priority, or else the greater one.

Source: MuJoCo's documentation, computation, collision detection; XML reference, body/geom, contact.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from ...errors import FormatError, nearest
from ..contacts import Solid, between_bodies, given_floor, gives_floor, touch, touch_each_other
from ..xml_tree import Element, identifier
from .geoms import Geom

SAYS = ("contype", "conaffinity", "priority", "condim", "friction")
"""Attributes of a geom that decide what it touches, and with what friction."""


@dataclass(frozen=True)
class Toucher:
    """A geom with the names of its own and of its body, and the body of the system that carries it."""

    name: str
    body: str
    geom: Geom
    solid: Solid

    @property
    def element(self) -> Element:
        """The element, with the attributes of its class."""
        return self.geom.element


def add_contacts(reader: Any) -> None:
    """Let the geoms touch the planes of the world, or report that nothing touches."""
    reading, root = reader.reading, reader.document.root
    geoms = _geoms(reader)
    moving = [one for one in geoms if one.solid.body is not reader.s.ground]
    pairs, excluded = _named(reader, {one.name: one for one in geoms})
    if not any(one.geom.touches for one in moving) and not pairs:
        return
    if reader.options.contacts is None:
        reading.left_out(
            "<worldbody>", root.line, "nothing touches: contacts='floor' lets geoms touch planes"
        )
        return
    for option in reader.document.settings("option"):
        for flag in option.all("flag"):
            if flag.attributes.get("contact") == "disable":
                reading.left_out("<flag>", flag.line, "nothing touches, since the file disables contacts")
                return
    still = [one for one in geoms if one.solid.body is reader.s.ground]
    planes = [one for one in still if one.geom.kind == "plane"]
    if planes and not gives_floor(reader.options.contacts):
        for plane in planes:
            _plane(reader, plane, moving, pairs, excluded)
    else:
        surface, friction = given_floor(reader, root.line, "since the file has no plane")
        for one in moving:
            if one.geom.touches:
                mu = _friction(reader, one) if friction is None else friction
                _touch(reader, one, surface, "floor", mu)
    if between_bodies(reader.options.contacts):
        _bodies(reader, [one for one in geoms if one.geom.kind != "plane"], pairs, excluded)
        return
    reading.left_out(
        "<worldbody>", root.line, "bodies touch planes and not each other, which contacts='all' reads"
    )
    for one in still:
        if one.geom.kind != "plane" and one.geom.touches:
            reading.left_out(one.solid.what, one.element.line, "a solid of the world that nothing touches")


def _bodies(
    reader: Any, geoms: list[Toucher], pairs: dict[frozenset[str], Element], excluded: set[frozenset[str]]
) -> None:
    """Let geoms touch each other: those of the same types, affinities and friction are a group."""
    named = {name for pair in pairs for name in pair}
    groups: dict[Any, list[Toucher]] = {}
    for one in geoms:
        if one.geom.touches or one.name in named:
            said = (one.element.attributes.get(key) for key in SAYS)
            groups.setdefault((one.name if one.name in named else "", *said), []).append(one)
    members = list(groups.values())

    def friction(i: int, j: int) -> float | None:
        a, b = members[i][0], members[j][0]
        pair = pairs.get(frozenset((a.name, b.name))) if i != j else None
        if pair is None and not _alike(a.element, b.element):
            return None
        return _friction(reader, *((pair,) if pair else (a, b)))

    solids = [[solid for one in group if (solid := _whole(reader, one))] for group in members]
    touch_each_other(reader, solids, friction, list(_apart(reader, pairs, excluded)))


def _apart(
    reader: Any, pairs: dict[frozenset[str], Element], excluded: set[frozenset[str]]
) -> Iterator[tuple[Any, Any]]:
    """Iterate over the pairs of bodies that the file excludes; report what bodies of fixed joints make of them."""
    carriers = [body for body, _ in reader.carriers.values()]
    for names in excluded:
        ends = [reader.carriers[name][0] for name in sorted(names)]
        if len(ends) < 2 or ends[0] is ends[1]:
            continue
        yield ends[0], ends[1]
        for name, body in zip(sorted(names), ends, strict=True):
            if carriers.count(body) > 1:
                reader.reading.changed(
                    f"body '{name}'", reader.bodies_of[name].element.line,
                    "<exclude> holds for all bodies that are one with it",
                )  # fmt: skip


def _geoms(reader: Any) -> list[Toucher]:
    """Return all geoms with their names, in the order of the file."""
    result = []
    for body in sorted(reader.bodies_of.values(), key=lambda one: one.number):
        carrier, pose = reader.carriers[body.name]
        for number, geom in enumerate(body.geoms, start=1):
            name = geom.element.attributes.get("name") or (
                body.name if len(body.geoms) == 1 else f"{body.name}_geom{number}"
            )
            what = f"<geom> '{name}'"
            solid = Solid(name, what, geom.element, carrier, pose @ geom.pose, geom.kind, geom.size)
            result.append(Toucher(name, body.name, geom, solid))
    return result


def _named(
    reader: Any, geoms: dict[str, Toucher]
) -> tuple[dict[frozenset[str], Element], set[frozenset[str]]]:
    """Return the pairs of geoms and the excluded pairs of bodies that the file names."""
    pairs, excluded = {}, set()
    for element in reader.document.sections("contact"):
        if element.tag not in ("pair", "exclude"):
            reader.reading.left_out(f"<{element.tag}>", element.line, "not a part of <contact>")
            continue
        kind = "geom" if element.tag == "pair" else "body"
        known: Any = geoms if kind == "geom" else reader.bodies_of
        ends = [element.get(f"{kind}{i}") for i in "12"]
        for name in ends:
            if name not in known:
                raise element.error(f"unknown {kind} '{name}' of <{element.tag}>; {nearest(name, known)}")
        if kind == "geom":
            pairs[frozenset(ends)] = reader.document.full(element)
        else:
            excluded.add(frozenset(ends))
    return pairs, excluded


def _plane(
    reader: Any,
    plane: Toucher,
    moving: list[Toucher],
    pairs: dict[frozenset[str], Element],
    excluded: set[frozenset[str]],
) -> None:
    """Let geoms touch a plane of the world."""
    pose = plane.solid.pose
    normal = tuple(row[2] for row in pose.rotation.matrix)
    surface = reader.s.ground.plane(at=pose.position, normal=normal)
    text = identifier(plane.name if "name" in plane.element.attributes else "floor", set())
    for one in moving:
        pair = pairs.get(frozenset((one.name, plane.name)))
        if pair is None and (
            frozenset((one.body, plane.body)) in excluded or not _alike(one.element, plane.element)
        ):
            continue
        _touch(reader, one, surface, text, _friction(reader, pair or one, plane))


def _touch(reader: Any, one: Toucher, surface: Any, floor: str, friction: float) -> None:
    """Let a geom touch a plane."""
    solid = _whole(reader, one)
    if solid is not None:
        touch(reader, solid, surface, floor, friction)


def _whole(reader: Any, one: Toucher) -> Solid | None:
    """Return the solid of a geom with the vertices of its mesh; None, and a report, if the mesh cannot be read."""
    if one.solid.kind != "mesh":
        return one.solid
    asset = reader.geoms.assets[one.element.get("mesh")]
    try:
        return replace(one.solid, vertices=reader.geoms.surface(asset)[0])
    except FormatError as error:
        reader.reading.left_out(one.solid.what, one.element.line, "it touches nothing", str(error))
        return None


def _alike(one: Element, other: Element) -> bool:
    """Return True if the type of one geom is among the affinities of the other."""
    types, affinities = ([x.whole(key, 1) for x in (one, other)] for key in ("contype", "conaffinity"))
    return bool(types[0] & affinities[1] or types[1] & affinities[0])


def _friction(reader: Any, *ends: Any) -> float:
    """Return the coefficient of friction of a pair, or of the geoms that touch."""
    elements = [end.element if isinstance(end, Toucher) else end for end in ends]
    if elements[0].tag == "pair":
        elements = elements[:1]
    first = max(one.number("priority", 0) for one in elements)
    ruling = [one for one in elements if one.number("priority", 0) == first]
    size = max(one.whole("condim", 3) for one in ruling)
    if size > 3:
        reader.reading.left_out(
            f"<{elements[0].tag}>",
            elements[0].line,
            "no friction resists its turn and roll",
            f"condim {size}",
        )
    for one in ruling:
        if min(one.several("friction"), default=0) < 0:
            raise one.error(
                f"expected a friction of <{one.tag}> that is not negative, got {one.get('friction')}"
            )
    return 0.0 if size == 1 else max((one.several("friction") or (1.0,))[0] for one in ruling)
