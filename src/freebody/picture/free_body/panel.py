"""One isolated body on paper: its outline, its arrows and their labels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...symbolic.equations import Equations
from ...symbolic.printing.latex import latex_name
from ..machine.configuration import Configuration
from ..machine.force_arrows import Mark
from ..machine.measures import Measured, angle_of, dimensions_of
from ..machine.outlines import outlines, polygon
from ..machine.shapes import Primitive, attachments
from ..paper.palette import GREY, INK, KINDS, legible
from ..paper.placing import Placer, inside, meets, sampled
from ..paper.sheet import Arrow, Circle, Group, Label, Line, Style, arc
from ..paper.view import View

Array = NDArray[np.float64]

LENGTH, LONGEST, SHORTEST = 46.0, 50.0, 11.0
"""Lengths of an arrow in the symbolic mode, and of the longest and the shortest arrow to scale [pt]."""

LABEL = 11.0
"""Size of the labels of arrows [pt]."""

LONGER = (1.0, 1.55, 2.1, 2.65, 3.2)
"""Lengths that an arrow tries, relative to LENGTH, so that the heads of arrows on one line stay apart; not to scale."""

MANY, WIDER = 8, 0.07
"""Number of arrows at one point in space above which each further arrow lengthens all by this fraction, for labels."""

ALONG = 0.995
"""Cosine above which two arrows lie on one line."""

FAR = 15.0
"""Distance of a label from its arrow above which a line joins them [pt]."""


@dataclass
class Panel:
    """Draws one body.

    Parameters
    ----------
    e, now, view, scale
        The model, its configuration, the view and the points per unit of length.
    body : str
    pieces : sequence of Primitive
        Pieces of the body from the back to the front.
    fill : str
        Fill colour of the body.
    colors : dict
        Colours of the reactions, by joint.
    unit : float, optional
        Points per newton of an arrow to scale; None draws all arrows of one length.
    guide : array, optional
        Direction on paper of the guide on which the body slides: a particle is drawn as a block on it.
    placer : Placer
    taken : list
        Arrows that have their place: point, direction, length, and True if they point away from the body.
    ends : list
        Points of all arrows on paper.
    """

    e: Equations
    now: Configuration
    view: View
    scale: float
    body: str
    pieces: Sequence[Primitive]
    fill: str
    colors: dict[str, str]
    unit: float | None = None
    guide: Array | None = None
    placer: Placer = field(default_factory=Placer)
    taken: list[tuple[Array, Array, float, bool]] = field(default_factory=list)
    ends: list[Array] = field(default_factory=list)

    def page(self, point: Any) -> Array:
        """Map a point in ground axes to paper [pt]."""
        return self.scale * self.view(point)

    def draw(
        self,
        marks: Sequence[Mark],
        *,
        kinetic: bool = False,
        angles: bool = False,
        dimensions: bool = False,
        blank: bool = False,
    ) -> Group:
        """Return the body with its arrows and labels."""
        group = Group(
            [],
            {
                "class": "kinetic" if kinetic else "free-body",
                "data-body": self.body,
                "data-shift": "0 0",
            },
            f"{'kinetic' if kinetic else 'free-body'} diagram of {self.body}",
        )
        R, p = self.now.posture(self.body)
        solids = " ".join(dict.fromkeys(piece.kind for piece in self.pieces))
        outline = Group([], {"class": "outline", "data-solids": solids})
        for piece in self.pieces:
            for item in outlines(piece, R, p, self.view, self.scale, self.fill, self.guide):
                outline.add(item)
                area = polygon(item)
                if area is not None:
                    # an arrow may lie on a disk or a box, but it would hide a bar
                    bar = self.view.planar and piece.kind in ("slender_bar", "rod")
                    self.placer.area(area, 1.0 if bar else 0.2)
                else:
                    self.placer.line(item.points)
        group.add(outline)
        group.add(self._points())
        measures: list[Measured] = []
        if angles and self.view.planar:
            measures += self._add_measures(group, angle_of(self, self.body, pieces=self.pieces))
        self.ends = [self.page(mark.point) for mark in marks]
        placed = [] if blank else [(mark, *self._arrow(mark)) for mark in self._ordered(marks)]
        for mark, arrow, _ in placed:
            arrow.attributes |= self._attributes(mark)
            group.add(arrow)
        if dimensions and self.view.planar:
            measures += self._add_measures(group, dimensions_of(self, self.body, self.placer))
        for mark, arrow, anchors in placed:
            color = self._style(mark).stroke or INK
            label = self.placer.label(f"${mark.label}$", anchors, LABEL, legible(color))
            arrow.add(label, *self._leader(label, arrow, color))
        for _, tex, anchor in measures:
            group.add(self.placer.label(tex, [anchor], 10.0, GREY))
        for name, at in self._point_names(blank):
            group.add(self.placer.label(name, [(at, None)], 9.5, GREY))
        return group

    def _add_measures(self, group: Group, measures: list[Measured]) -> list[Measured]:
        for item, _, _ in measures:
            group.add(item)
            for part in item.items:
                self.placer.line(part.points)
        return measures

    def _leader(self, label: Label, arrow: Group, color: str) -> list[Any]:
        """Fine line from a label to a distant arrow: the shortest that crosses no other label, if there is any."""
        shafts = [item for item in arrow.items if isinstance(item, Arrow)]
        if not shafts:
            return []
        along = sampled(shafts[0].points, 2.0)
        x0, y0, x1, y1 = label.box
        nearest = np.column_stack([np.clip(along[:, 0], x0, x1), np.clip(along[:, 1], y0, y1)])
        gaps = np.linalg.norm(along - nearest, axis=1)
        if gaps.min() < FAR:
            return []
        others = [box for box in self.placer.boxes if box != label.box]
        for k in np.argsort(gaps, kind="stable"):
            d = (nearest[k] - along[k]) / gaps[k]
            line = np.array([along[k] + 2.0 * d, nearest[k] - 2.0 * d])
            if not any(meets(line, box) for box in others):
                self.placer.line(line)
                return [Line(line, Style(color, 0.5))]
        return []

    # -- points -------------------------------------------------------------------------------------

    def _points(self) -> Group:
        """The symbol of the mass centre, and small circles at the points that joints and loads act on."""
        group = Group([], {"class": "points"})
        center = self._center()
        for at in self._attachments():
            group.add(Circle(at, 2.4, Style(INK, 0.9, (), "#ffffff")))
        if not self._has_mass():
            return group
        # the symbol of a mass centre: a circle with two black quarters
        r = 3.4
        group.add(Circle(center, r, Style(INK, 0.8, (), "#ffffff")))
        for start in (0.0, math.pi):
            quarter = np.vstack([center, arc(center, r, start, start + math.pi / 2)])
            group.add(Line(quarter, Style(None, 0.0, (), INK), True))
        x, y = center
        self.placer.box((x - r, y - r, x + r, y + r))
        return group

    def _has_mass(self) -> bool:
        return self.now.model.bodies[self.body].mass != 0

    def _center(self) -> Array:
        return self.page(self.now.place(self.body, self.now.model.bodies[self.body].center))

    def _attachments(self) -> list[Array]:
        """Distinct points on paper that joints and loads act on, without the mass centre."""
        R, p = self.now.posture(self.body)
        points: list[Array] = [self._center()] if self._has_mass() else []
        first = len(points)
        for at in attachments(self.now.model, self.now.state, self.body).values():
            page = self.page(p + R @ at)
            if all(float(np.linalg.norm(page - q)) > 1.0 for q in points):
                points.append(page)
        return points[first:]

    def _point_names(self, blank: bool) -> list[tuple[str, Array]]:
        """Labels of points: C for the mass centre; the joints too, in a diagram without arrows."""
        result = []
        joints = {*self.now.model.joints, *self.now.model.constraints}
        # if a joint is called C, the mass centre has only its symbol
        if self._has_mass() and "C" not in joints and all(piece.kind != "particle" for piece in self.pieces):
            result.append(("$C$", self._center()))
        if blank:
            R, p = self.now.posture(self.body)
            for name, at in attachments(self.now.model, self.now.state, self.body).items():
                if name in joints:
                    result.append((f"${latex_name(name)}$", self.page(p + R @ at)))
        return result

    # -- arrows -------------------------------------------------------------------------------------

    def _ordered(self, marks: Sequence[Mark]) -> list[Mark]:
        """Marks in the order in which they get their places: weights first, reactions after loads, couples last."""
        order = {"weight": 0, "load": 1, "spring": 2, "damper": 2, "motor": 3}
        return sorted(marks, key=lambda mark: (mark.couple, order.get(mark.kind, 5)))

    def _style(self, mark: Mark) -> Style:
        color, width, dash = KINDS.get(mark.kind, KINDS["contact"])
        if mark.kind in ("reaction", "contact", "friction"):
            color = self.colors.get(mark.owner, color)
        return Style(color, width, dash)

    def _length(self, mark: Mark) -> float:
        if self.unit is None or mark.value is None or mark.couple:
            return LENGTH
        return max(SHORTEST, self.unit * mark.value)

    def _spread(self, at: Array) -> float:
        """Factor by which the arrows at a point are longer if there are many."""
        count = sum(float(np.linalg.norm(at - end)) < 1.0 for end in self.ends)
        return 1.0 + WIDER * max(0, count - MANY)

    def _arrow(self, mark: Mark) -> tuple[Group, list[tuple[Array, Array | None]]]:
        """Place the arrow of a mark; return its group and the anchors of its label."""
        if mark.couple and self.view.planar:
            return self._bent(mark)
        return self._straight(mark)

    def _straight(self, mark: Mark) -> tuple[Group, list[tuple[Array, Array | None]]]:
        at = self.page(mark.point)
        projected = self.view(mark.direction)
        share = float(np.linalg.norm(projected))
        style = self._style(mark)
        if mark.couple:
            style = Style(style.stroke, style.width, (7.0, 2.0))
        head = "open" if mark.kind == "kinetic" else "full"
        if mark.couple:
            head = "double"
        group = Group([], {}, self._title(mark))
        if share < 0.08:
            # toward the reader: a circle with a dot; away from the reader: a circle in a circle
            toward = float(np.dot(self.view.toward, mark.direction)) > 0
            group.add(Circle(at, 6.0, Style(style.stroke, 1.3, (), "#ffffff")))
            inner = 1.8 if toward else 5.0
            group.add(Circle(at, inner, Style(style.stroke, 1.0, (), style.stroke if toward else None)))
            self.placer.line(arc(at, 6.0, 0.0, 2 * math.pi))
            return group, [(at, None)]
        d = projected / share
        length = self._length(mark)
        if not self.view.planar:
            length *= max(0.55, share) * (1.0 if self.unit else self._spread(at))
        choices: list[tuple[float, int, Array, bool]] = []
        for step in range(1 if self.unit is not None and not mark.couple else len(LONGER)):
            for outward in (True, False):
                side = d if outward else -d
                cost = 0.3 * step + (0.0 if outward else 0.12)
                if mark.kind in ("weight", "kinetic") and not mark.couple and not outward:
                    cost += 4.0  # they start at the mass centre
                reach = length * LONGER[step]
                near = at + self._edge(at, side) * side
                points = np.array([near, near + reach * side])[:: 1 if outward else -1]
                cost += self.placer.crowding(points, at) + self._hidden(at, side, reach, outward)
                choices.append((cost, len(choices), points, outward))
        _, _, points, outward = min(choices, key=lambda choice: choice[:2])
        self.taken.append((at, d if outward else -d, float(np.linalg.norm(points[1] - points[0])), outward))
        arrow = Arrow(points, style, head)
        group.add(arrow)
        self.placer.arrow(arrow)
        far, near = (points[1], points[0]) if outward else (points[0], points[1])
        away = far - near
        away = away / np.linalg.norm(away)
        normal = np.array([-d[1], d[0]])
        middle = (points[0] + points[1]) / 2
        beyond = points[0] + (0.7 if outward else 0.3) * (points[1] - points[0])
        return group, [(far, away), (beyond, normal), (beyond, -normal), (middle, normal), (middle, -normal)]

    def _hidden(self, at: Array, d: Array, reach: float, outward: bool) -> float:
        """Cost of an arrow that lies on another arrow, on the same side of one point, because it may hide its head."""
        cost = 0.0
        for point, other, length, out in self.taken:
            if float(np.linalg.norm(point - at)) > 1.0 or float(d @ other) < ALONG:
                continue
            cost += 0.4 if outward and out and abs(reach - length) > 0.4 * LENGTH else 2.5
        return cost

    def _edge(self, at: Array, d: Array) -> float:
        """Distance from a particle to the edge of its circle, where its arrows begin; 0 for other bodies."""
        if not all(piece.kind == "particle" for piece in self.pieces):
            return 0.0
        along = at + np.arange(0.0, 40.0, 0.5)[:, None] * d
        within = np.zeros(len(along), dtype=bool)
        for area in self.placer.areas:
            within |= inside(area, along)
        return 0.0 if within.all() else 0.5 * float(np.argmin(within))

    def _bent(self, mark: Mark) -> tuple[Group, list[tuple[Array, Array | None]]]:
        """Place the arc of a couple about the normal of the plane; return its group and the anchors of its label."""
        at = self.page(mark.point)
        turn = 1.0 if self.view.turn(mark.direction) > 0 else -1.0
        style = self._style(mark)
        group = Group([], {}, self._title(mark))
        choices: list[tuple[float, int, Array]] = []
        small = 26.0 if all(piece.kind == "particle" for piece in self.pieces) else 19.0
        for rank, radius in enumerate((small, small + 6, small + 12, small + 19)):
            for k in range(12):
                start = math.radians(30 * k)
                points = arc(at, radius, start, start + turn * math.radians(200))
                cost = self.placer.crowding(points) + 0.22 * rank + 0.002 * k
                choices.append((cost, len(choices), points))
        points = min(choices, key=lambda choice: choice[:2])[2]
        arrow = Arrow(points, style, "open" if mark.kind == "kinetic" else "full")
        group.add(arrow)
        group.attributes["data-turn"] = f"{turn:g}"
        self.placer.arrow(arrow)
        anchors: list[tuple[Array, Array | None]] = []
        for share in (0.5, 0.75, 0.25, 1.0, 0.0):
            q = points[int(share * (len(points) - 1))]
            out = q - at
            anchors.append((q, out / np.linalg.norm(out)))
        return group, anchors

    # -- attributes by which an arrow is read back --------------------------------------------------

    def _title(self, mark: Mark) -> str:
        kind = "couple" if mark.couple else "force"
        by = f", {mark.by}" if mark.by else ""
        return f"{mark.name}: {kind} {mark.symbol}{by}"

    def _attributes(self, mark: Mark) -> dict[str, str]:
        result = {
            "class": "couple" if mark.couple else "force",
            "data-name": mark.name,
            "data-kind": mark.kind,
            "data-body": self.body,
            "data-symbol": mark.symbol,
            "data-direction": " ".join(f"{x:.12g}" for x in mark.direction),
            "data-point": " ".join(f"{x:.12g}" for x in mark.point),
        }
        if mark.exact:
            result["data-vector"] = "; ".join(mark.exact)
        if mark.at:
            result["data-at"] = "; ".join(mark.at)
        if mark.frame != "ground":
            result["data-frame"] = mark.frame
        if mark.owner:
            result["data-owner"] = mark.owner
        if mark.value is not None:
            result["data-value"] = f"{mark.value:.12g}"
            if self.unit is not None and not mark.couple and self.unit * mark.value < SHORTEST:
                result["data-enlarged"] = "true"
        if mark.law:
            result["data-law"] = mark.law
        if mark.where:
            result["data-where"] = mark.where
        return result
