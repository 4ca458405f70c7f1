"""The drawing of a machine in progress: its view and scale, and the items drawn so far."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...describe.joints.pair import Pair
from ...model.closure import Closure
from ...model.model import Link
from ...symbolic.equations import Equations
from ..paper.placing import Placer, inside
from ..paper.sheet import Arrow, Circle, Group, arc
from ..paper.view import View
from .configuration import Configuration
from .outlines import axis_in_space, axis_on_paper, guide_of, outlines, polygon
from .shapes import attachments, fill_of, hidden, numbers
from .solid_pieces import pieces_of
from .supports import idle_supports

Array = NDArray[np.float64]

WIDE = 250.0
"""Length of the machine on paper [pt]."""

MANY = 5
"""Most bodies of a machine in space between whose labels there is room for lengths."""

ROUND = ("disk", "wall", "ball")
"""Kinds of surfaces whose section with the plane of the machine is a circle."""


class PlacedJoint(NamedTuple):
    """A joint as it is drawn: name of its kind, what it leaves free, its bodies, and its point in ground axes."""

    type: str
    pair: Pair
    parent: str
    child: str
    point: Array


class MachineDrawing:
    """Drawing of one machine in one configuration, to which items are added.

    Attributes
    ----------
    e, now, view
        Equations, configuration, view.
    scale : float
        Points per unit of length [pt/m].
    labels : list
        Labels, placed after all lines are drawn: text, anchors, size, colour.
    idle : set
        Names of joints to the ground that transmit no force.
    named : dict
        Numbers of the labels that are names of bodies, and these bodies; of joints, and None.
    arcs : list
        Points about which angles are drawn, on paper.
    """

    wide = WIDE

    def __init__(self, e: Equations, now: Configuration, view: View) -> None:
        self.e, self.now, self.view = e, now, view
        self.model = e.model
        self.pieces = pieces_of(now, view.planar)
        self.placer = Placer()
        self._areas: dict[str, list[Array]] = {}
        self.root = Group()
        self.labels: list[tuple[str, list[tuple[Array, Array | None]], float, str]] = []
        self.named: dict[int, str | None] = {}
        self.arcs: list[Array] = []
        longest = float(np.ptp(view(self.extent), axis=0).max())
        self.scale = WIDE / longest if longest > 0 else 1.0
        self.down = np.array([0.0, -1.0])
        self.joints = self._joints()
        self.drawn = self._back_to_front()
        self.idle = idle_supports(now, view.planar)

    def page(self, point: Array) -> Array:
        """Map a point in ground axes to paper, or many (n, 3) [pt]."""
        return self.scale * self.view(point)

    @property
    def many(self) -> bool:
        """True for a machine in space that is too crowded for its lengths and for what acts along its joints."""
        return not self.view.planar and len(self.drawn) > MANY

    # -- extent and order -----------------------------------------------------------------------------

    @cached_property
    def extent(self) -> Array:
        """Points whose box contains the machine, in ground axes, shape (n, 3) [m]."""
        points: list[Array] = []
        unseen = hidden(self.model)
        for name in self.model.bodies:
            if name in unseen:
                continue
            R, p = self.now.posture(name)
            points += [p + R @ q for q in attachments(self.model, self.now.state, name).values()]
            points.append(self.now.place(name, self.model.bodies[name].center))
            for piece in self.pieces[name]:
                points += [*(p + piece.points() @ R.T)]
        for joint in self.model.joints.values():
            on_ground = joint.parent == "ground" and joint.child not in unseen
            if on_ground and joint.pair.holds:
                points.append(self.now.place("ground", joint.at))
        return np.array(points + round_walls(self))

    def _back_to_front(self) -> list[str]:
        """Names of the bodies in drawing order: in space the far ones first, at equal depth the large ones first.

        Hidden bodies are not drawn, nor in space a body without mass or extent between two motions of a joint.
        """

        def order(name: str) -> tuple[float, float]:
            place = self.model.bodies[name]
            depth = 0.0 if self.view.planar else float(self.view.toward @ self.now.place(name, place.center))
            points = np.concatenate([piece.points() for piece in self.pieces[name]])
            return round(depth * self.scale, 3), -float(np.ptp(points, axis=0).max())

        carriers = hidden(self.model) | {
            name
            for name in self.model.bodies
            if not self.view.planar
            and all(piece.kind == "particle" and not piece.solid for piece in self.pieces[name])
        }
        return sorted((name for name in self.model.bodies if name not in carriers), key=order)

    def _joints(self) -> dict[str, PlacedJoint]:
        """Every joint that transmits something, those that close loops included."""
        joints = {
            name: PlacedJoint(
                joint.type, joint.pair, joint.parent, joint.child, self.now.place(joint.child, joint.to)
            )
            for name, joint in self.model.joints.items()
            if not joint.pair.free
        }
        for name, closure in self.model.constraints.items():
            if isinstance(closure, Closure):
                parent, child = closure.parent.name, closure.child.name
                joints[name] = PlacedJoint(
                    closure.type, closure.pair, parent, child, self.now.place(child, closure.to)
                )
        return joints

    def axis(self, name: str, index: int = 0) -> Array | None:
        """Direction on paper of an axis of a joint; None if it points at the reader."""
        joint = self.model.joints.get(name)
        if joint is None:
            return None
        return axis_on_paper(self.now, self.view, joint.links[index])

    def axis_in_space(self, link: Link, number: int) -> Array:
        """Axis of a link, in ground axes; ``number`` is the number of the link."""
        return axis_in_space(self.now, number)

    def reach(self, body: str, at: Array, d: Array) -> float:
        """Distance by which a body reaches from a point in a direction [pt]."""
        return max((float(((area - at) @ d).max()) for area in self.areas_of(body)), default=0.0)

    def along(self, body: str, at: Array, d: Array) -> float:
        """Distance from a point at which the line in a direction leaves a body [pt]."""
        distance = np.arange(0.0, 2 * WIDE, 1.0)
        within = np.zeros(len(distance), dtype=bool)
        for area in self.areas_of(body):
            for beside in (-2.0, 2.0):  # the axis may be an edge of the body
                within |= inside(area, at + distance[:, None] * d + beside * np.array([-d[1], d[0]]))
        return float(distance[within].max()) if within.any() else 0.0

    def areas_of(self, name: str) -> list[Array]:
        """Polygons that a body covers on paper; they are computed once."""
        if name in self._areas:
            return self._areas[name]
        R, p = self.now.posture(name)
        areas = []
        for piece in self.pieces[name]:
            for item in outlines(
                piece, R, p, self.view, self.scale, "#ffffff", guide_of(self.now, self.view, name)
            ):
                area = polygon(item)
                if area is not None:
                    areas.append(area)
        self._areas[name] = areas
        return areas

    # -- items ----------------------------------------------------------------------------------------

    def fill(self, name: str) -> str:
        """Fill colour of a body."""
        return fill_of(self.model, name)

    def add(self, items: list[Any], **attributes: str) -> None:
        """Draw a symbol, as a group with attributes (``class_`` for ``class``, ``data_joint`` for ``data-joint``)."""
        named = {key.replace("_", "-").removesuffix("-"): value for key, value in attributes.items()}
        self.root.add(Group(items, named))
        for item in items:
            if isinstance(item, Circle):
                self.placer.line(arc(item.center, item.radius, 0.0, 2 * math.pi))
            elif isinstance(item, Arrow):
                self.placer.arrow(item)
            else:
                area = polygon(item)
                self.placer.line(item.points if area is None else np.vstack([area, area[:1]]))


def round_walls(m: MachineDrawing) -> list[Array]:
    """Four points of each round wall of the ground, in ground axes [m]."""
    return [
        numbers(m.now.state, shape.at) + sign * float(m.now.state(shape.radius)) * across
        for shape in m.model.touching
        if m.view.planar and shape.body.is_ground and shape.look in ROUND
        for across in m.view.matrix
        for sign in (-1.0, 1.0)
    ]
