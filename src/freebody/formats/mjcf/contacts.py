"""Contacts of an MJCF file: geoms of bodies that move touch the planes of the world.

Two geoms may touch if the type of one is among the affinities of the other, or if a <pair> names them, and no <exclude>
names their bodies. The friction of two geoms is that of the one of higher priority, or else the greater one.

Source: MuJoCo's documentation, computation, collision detection; XML reference, body/geom, contact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ...errors import FormatError, nearest
from ..contacts import Solid, given_floor, touch
from ..xml_tree import Element, identifier
from .geoms import Geom


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
    if isinstance(reader.options.contacts, str) and planes:
        for plane in planes:
            _plane(reader, plane, moving, pairs, excluded)
    else:
        surface, friction = given_floor(reader, root.line, "since the file has no plane")
        for one in moving:
            if one.geom.touches:
                mu = _friction(reader, one) if friction is None else friction
                _touch(reader, one, surface, "floor", mu)
    reading.left_out("<worldbody>", root.line, "bodies touch planes and not each other")
    for one in still:
        if one.geom.kind != "plane" and one.geom.touches:
            reading.left_out(one.solid.what, one.element.line, "a solid of the world that nothing touches")


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
    solid = one.solid
    if solid.kind == "mesh":
        asset = reader.geoms.assets[one.element.get("mesh")]
        try:
            solid = replace(solid, vertices=reader.geoms.surface(asset)[0])
        except FormatError as error:
            reader.reading.left_out(solid.what, one.element.line, "it does not touch the floor", str(error))
            return
    touch(reader, solid, surface, floor, friction)


def _alike(one: Element, other: Element) -> bool:
    """Return True if the type of one geom is among the affinities of the other."""
    types, affinities = ([int(x.number(key, 1)) for x in (one, other)] for key in ("contype", "conaffinity"))
    return bool(types[0] & affinities[1] or types[1] & affinities[0])


def _friction(reader: Any, *ends: Any) -> float:
    """Return the coefficient of friction of a pair, or of the geoms that touch."""
    elements = [end.element if isinstance(end, Toucher) else end for end in ends]
    if elements[0].tag == "pair":
        elements = elements[:1]
    first = max(one.number("priority", 0) for one in elements)
    ruling = [one for one in elements if one.number("priority", 0) == first]
    size = max(int(one.number("condim", 3)) for one in ruling)
    if size > 3:
        reader.reading.left_out(
            f"<{elements[0].tag}>",
            elements[0].line,
            "no friction resists its turn and roll",
            f"condim {size}",
        )
    return 0.0 if size == 1 else max((one.several("friction") or (1.0,))[0] for one in ruling)
