"""The contacts of two solids in a motion by events: a fixed number of places for the points of their patch.

A place is a corner of one solid on a face of the other, or an edge on an edge; where one is round, also a corner on an
edge or a corner, with a sphere as a corner. Which corner, face or edge it is stands in parameters of the place, so that
equations, events and reactions are those of any contact, and nothing is derived or compiled again when the patch has
other features.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import sympy

from ..describe.description import Parameter
from ..describe.shapes.feature import Corner, Edge, Face, Feature
from .contact import Contact, elements

KINDS = (
    (Corner, Face), (Face, Corner), (Edge, Edge), (Corner, Edge), (Edge, Corner), (Corner, Corner),
)  # fmt: skip
"""Kinds of places, the feature of the first body named first."""
CORNER_ON_FACE, FACE_ON_CORNER, EDGE_ON_EDGE, CORNER_ON_EDGE, EDGE_ON_CORNER, CORNER_ON_CORNER = range(6)
VECTORS = {"at": (0, 0, 0), "normal": (0, 0, 1), "along": (1, 0, 0)}
NUMBERS = {"used": 0, "side": 1}
"""Data of features, and their values while a place is not used."""


@dataclass(frozen=True)
class Patched:
    """Two members of a family that touch in a patch.

    ``of``, ``whole``                    the model with the family, and the contact of both as a whole
    ``family``, ``first``, ``second``    number of the family, and members
    ``places``, ``kinds``                contact among those of the model of each place, and its kind
    ``names``                            names of the parameters of each place
    """

    of: Any
    family: int
    first: int
    second: int
    whole: Contact
    places: tuple[int, ...]
    kinds: tuple[int, ...]
    names: tuple[tuple[str, ...], ...]


def places_of(a: Any, b: Any) -> tuple[int, ...]:
    """Return the kinds of the places of two members: what a face cut by a face, or two edges, may need.

    Round ones also touch with one edge, or two ends of parallel ones, and with corners.
    """
    faces = [getattr(shape, "faces", ()) for shape in (a, b)]
    most = [max(map(len, own), default=len(shape.corners)) for own, shape in zip(faces, (a, b), strict=True)]
    sides = [len(shape.corners) > 1 for shape in (a, b)]
    count = dict.fromkeys(range(len(KINDS)), 0)
    count[CORNER_ON_FACE], count[FACE_ON_CORNER] = most[0] * bool(faces[1]), most[1] * bool(faces[0])
    if all(faces):
        count[EDGE_ON_EDGE] = most[0] + most[1]
    elif all(sides):
        count[EDGE_ON_EDGE] = 2 if any(faces) else 1
    if radius_of(a) != 0 or radius_of(b) != 0:
        both = 2 if all(sides) else 1
        count[CORNER_ON_EDGE], count[EDGE_ON_CORNER] = both * sides[1], both * sides[0]
        count[CORNER_ON_CORNER] = 1
    return tuple(kind for kind, n in count.items() for _ in range(n))


def radius_of(shape: Any) -> Any:
    """Return the radius around the core of a solid, of a sphere or of a point."""
    return getattr(shape, "radius", 0)


def contacts_of(whole: Contact, kinds: tuple[int, ...]) -> list[tuple[Contact, list[Parameter]]]:
    """Return the contacts of the places of two solids, with their parameters."""
    result = []
    for i, kind in enumerate(kinds, start=1):
        name, parameters = f"{whole.name}_{i}", list[Parameter]()
        shapes = [
            _feature(which, shape, f"{name}_{side}", parameters)
            for which, shape, side in zip(KINDS[kind], (whole.feature, whole.surface), "AB", strict=True)
        ]
        result.append((_part(whole, i, *shapes), parameters))
    return result


def corners_on(whole: Contact) -> list[Contact]:
    """Return the contacts of a solid and a plane: one for each corner."""
    parts = whole.feature.parts(whole.surface)
    return [_part(whole, i, part, whole.surface) for i, part in enumerate(parts, start=1)]


def parts_of(whole: Contact) -> list[Contact]:
    """Return the contacts of two members of which one has ends: a capsule and a sphere or point."""
    side, *ends = elements(whole.feature, whole.surface)
    return [
        replace(whole, owner=whole.name, feature=side[1], surface=side[2]),
        *(_part(whole, ending, feature, surface) for ending, feature, surface in ends),
    ]


def _part(whole: Contact, i: int | str, feature: Any, surface: Any) -> Contact:
    """Return the contact of two parts of two members."""
    return replace(
        whole, name=f"{whole.name}_{i}", owner=whole.name, feature=feature, surface=surface,
        normal_name=f"{whole.normal_name}_{i}", tangent_names=tuple(f"{name}_{i}" for name in whole.tangent_names),
    )  # fmt: skip


def _feature(kind: type[Feature], shape: Any, name: str, parameters: list[Parameter]) -> Feature:
    """Return a feature of a shape whose data are parameters, which are appended to the list."""

    def parameter(label: str, default: float) -> Any:
        symbol = sympy.Symbol(f"{name}_{label}", real=True)
        parameters.append(Parameter(symbol.name, symbol, float(default)))
        return symbol

    data: dict[str, Any] = {"radius": radius_of(shape)}
    for field in fields(kind):
        if field.name in VECTORS:
            data[field.name] = tuple(
                parameter(f"{field.name}_{k}", x) for k, x in enumerate(VECTORS[field.name])
            )
        elif field.name in NUMBERS:
            data[field.name] = parameter(field.name, NUMBERS[field.name])
    return kind(shape.body, **data)
