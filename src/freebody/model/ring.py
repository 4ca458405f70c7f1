"""The edge of a disk that lies flat in a motion by events: the four points on which it stands turn with the load.

Their angle in the plane is that of the resultant of the contact forces, or of the point about which the disk begins to
tip. It is data that the motion writes (`motion.events.rings`), in two parameters of the model: its cosine and its sine.
A disk that spins leaves them where they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy

from ..describe.description import Parameter
from ..describe.shapes.circle import Footing
from ..scalar.algebra import add, scale
from .contact import Contact

POINTS = 4
"""Number of points of an edge."""


@dataclass(frozen=True)
class Ring:
    """An edge that may lie flat: its contact, the first one of its points, and the names of cosine and sine."""

    edge: int
    first: int
    names: tuple[str, str]


def edge_of(contacts: Sequence[Contact], point: Contact) -> int:
    """Return the contact of the edge of which a disk that lies flat stands on a point: a drum has two edges."""
    shape: Any = point.feature if point.feature.stands else point.surface
    return next(
        k for k, c in enumerate(contacts) if c.owner == point.owner and shape.edge in (c.feature, c.surface)
    )


def turning(contacts: Sequence[Contact]) -> tuple[list[Contact], list[Parameter], list[Ring]]:
    """Return the contacts with points of edges that turn, their parameters, and the edges."""
    result, parameters, rings = list(contacts), list[Parameter](), list[Ring]()
    points = [k for k, contact in enumerate(contacts) if contact.stands]
    for first in points[::POINTS]:
        edge = edge_of(contacts, contacts[first])
        names = f"{contacts[edge].name}_turn_cos", f"{contacts[edge].name}_turn_sin"
        cosine, sine = (sympy.Symbol(name, real=True) for name in names)
        parameters += [Parameter(names[0], cosine, 1), Parameter(names[1], sine, 0)]
        rings.append(Ring(edge, first, names))
        ways = (cosine, sine), (-sine, cosine), (-cosine, -sine), (sine, -cosine)
        for k, way in enumerate(ways, start=first):
            result[k] = _turned(contacts[k], way)
    return result, parameters, rings


def _turned(contact: Contact, way: tuple[Any, Any]) -> Contact:
    """Return the contact of a point with its direction along the axes of the plane."""
    point: Any = contact.feature
    plane: Any = contact.surface
    if plane.stands:
        point, plane = plane, point
    along = add(scale(way[0], plane.first), scale(way[1], plane.second))
    footing = Footing(point.edge.body, point.edge, plane, along)
    return replace(contact, surface=footing) if contact.surface.stands else replace(contact, feature=footing)
