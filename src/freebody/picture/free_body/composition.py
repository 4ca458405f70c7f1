"""Panels, captions and tables of a free-body diagram on its sheet."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ...symbolic.equations import Equations
from ...symbolic.free_body.gears import undetermined_by_couplings
from ...symbolic.printing.display import equation_latex
from ...symbolic.printing.latex import latex_number
from ..machine.configuration import Configuration
from ..machine.force_arrows import OMITTED, Mark
from ..machine.outlines import guide_of
from ..machine.shapes import Primitive, attachments, fill_of, machine_size
from ..machine.solid_pieces import pieces_of
from ..paper.labels import size_of
from ..paper.palette import GREY, INK, PAIRS
from ..paper.placing import Placer
from ..paper.sheet import Arrow, Box, Group, Label, Sheet, Style, box_of, moved, overlap
from ..paper.view import View
from .contact_states import contact_states
from .panel import LONGEST, SHORTEST, Panel

Array = NDArray[np.float64]

ROUND_OFF = 1e-10
"""Forces (couples) below this fraction of the greatest one are not drawn to scale: they are round-off."""

WIDE = 150.0
"""Length of the largest body on paper [pt]."""

CROWDED, CLOSE = 10, 15.0
"""More arrows than these on a body in space, at points less than this apart [pt]: it has a view and size of its own."""

LARGER = 4 / 3
"""Size of such a body, relative to the others."""

LINE = 64
"""Most characters in a line of text below a diagram."""


class Composition:
    """Puts the panels, captions and tables of a diagram on a sheet; ``marks`` holds the arrows of each body by name."""

    def __init__(
        self,
        e: Equations,
        now: Configuration,
        view: View,
        marks: dict[str, tuple[list[Mark], list[Mark]]],
        mode: str,
        angles: bool,
        dimensions: bool,
        kinetic: bool,
    ) -> None:
        self.e, self.now, self.view, self.marks, self.mode = e, now, view, marks, mode
        self.angles, self.dimensions, self.kinetic = angles, dimensions, kinetic
        self.pieces = pieces_of(now, view.planar)
        owners = dict.fromkeys(mark.owner for acting, _ in marks.values() for mark in acting if mark.owner)
        exploded = len(marks) > 1
        # in the diagram of one body, the colour shows the kind of a force
        self.colors = {owner: PAIRS[i % len(PAIRS)] for i, owner in enumerate(owners)} if exploded else {}
        self.greatest = {False: 0.0, True: 0.0}
        for acting, kinetic_marks in marks.values():
            for mark in (*acting, *kinetic_marks):
                self.greatest[mark.couple] = max(self.greatest[mark.couple], mark.value or 0.0)
        longest = self.greatest[False]
        self.unit = LONGEST / longest if mode == "scale" and longest > 0 else None
        self.size = WIDE

    def is_crowded(self, name: str) -> bool:
        """Return True for a body in space with many arrows at points that are close to each other on paper."""
        return not self.view.planar and len(self.marks[name][0]) > CROWDED and self.apart(name) < CLOSE

    def apart(self, name: str) -> float:
        """Return the least distance of two points at which arrows act on a body, on paper [pt]."""
        points = np.unique(np.round([mark.point for mark in self.marks[name][0]], 9), axis=0)
        page = self._scale([name]) * self.view(points)
        return min((float(np.linalg.norm(p - q)) for p, q in combinations(page, 2)), default=math.inf)

    # -- sheets -------------------------------------------------------------------------------------

    def single(self, name: str) -> Sheet:
        """Sheet with a body, and with its kinetic diagram beside it."""
        acting, kinetic = self.marks[name]
        if self.mode == "scale":
            acting, kinetic = self._without_zeros(acting), self._without_zeros(kinetic)
        scale = self._scale([name])
        left = self._panel(name, scale, acting, False)
        root = Group()
        _put(root, left, np.zeros(2))
        caption = "free-body diagram"
        self._axes(root, left)
        x0, y0, x1, y1 = box_of(root)
        low = y0 - 10.0
        root.add(_centered(caption, (box_of(left)[0] + box_of(left)[2]) / 2, low, 10.0, GREY))
        if self.kinetic:
            right = self._panel(name, scale, kinetic, True)
            if any(mark.law and mark.label[-2:-1] in "123" for mark in kinetic):
                self._body_axes(right, name)
            bx = box_of(right)
            shift = np.array([x1 + 52.0 - bx[0], 0.0])
            root.add(_centered("$=$", x1 + 26.0, _middle(self, name, scale), 20.0, INK))
            right = _put(root, right, shift)
            bx = box_of(right)
            if not kinetic and self.mode != "blank":
                words = "(no acceleration)" if self._has_inertia(name) else "(no mass)"
                root.add(_centered(words, (bx[0] + bx[2]) / 2, bx[1] - 6.0, 9.5, GREY))
            low = min(low, bx[1] - 10.0)
            root.add(_centered("kinetic diagram", (bx[0] + bx[2]) / 2, low, 10.0, GREY))
        self._below(root, [*acting, *kinetic])
        self._heading(root, name)
        return self._sheet(root, scale, f"Free-body diagram of {name} ({self.now.model.name})")

    def _has_inertia(self, name: str) -> bool:
        body = self.now.model.bodies[name]
        return body.mass != 0 or any(x != 0 for row in body.inertia for x in row)

    def _without_zeros(self, marks: Sequence[Mark]) -> list[Mark]:
        """The arrows whose values are more than round-off."""
        # couples are also compared with the forces at an arm of the size of the machine
        arm = self.greatest[False] * machine_size(self.now.model, self.now.values)
        least = {False: ROUND_OFF * self.greatest[False], True: ROUND_OFF * max(self.greatest[True], arm)}
        return [mark for mark in marks if mark.value is None or mark.value > least[mark.couple]]

    def exploded(self) -> Sheet:
        """Sheet with all bodies, pushed apart until nothing overlaps."""
        names = list(self.marks)
        scale = self._scale(names)
        panels = []
        for name in names:
            acting = self.marks[name][0]
            if self.mode == "scale":
                acting = self._without_zeros(acting)
            panels.append(self._panel(name, scale, acting, False))
            panels[-1].add(self._name_of(panels[-1], name))
        shifts = separation([box_of(panel) for panel in panels], 16.0)
        root = Group()
        for panel, shift in zip(panels, shifts, strict=True):
            _put(root, panel, shift)
        self._axes(root, root)
        marks = [mark for acting, _ in self.marks.values() for mark in acting]
        self._below(root, marks)
        self._heading(root, "all bodies")
        return self._sheet(root, scale, f"Free-body diagrams of {self.now.model.name}")

    def _sheet(self, root: Group, scale: float, title: str) -> Sheet:
        attributes = {
            "data-scale": f"{scale:.12g}",
            "data-view": " ".join(f"{x:.12g}" for x in self.view.matrix.ravel()),
            "data-toward": " ".join(f"{x:.12g}" for x in self.view.toward),
            "data-mode": self.mode,
            "class": "freebody-diagram",
        }
        if self.view.normal is not None:
            attributes["data-normal"] = "xyz"[self.view.normal]
        if self.now.moving:
            attributes["data-time"] = f"{self.now.t:.12g}"
        if self.unit is not None:
            attributes["data-unit"] = f"{self.unit:.12g}"
        return Sheet(root, title, attributes)

    # -- parts --------------------------------------------------------------------------------------

    def _scale(self, names: Sequence[str]) -> float:
        """Points per unit of length [pt/m], so that the largest body has its size on paper."""
        longest = 0.0
        for name in names:
            R, p = self.now.posture(name)
            points = [p + R @ q for q in attachments(self.now.model, self.now.state, name).values()]
            points.append(self.now.place(name, self.now.model.bodies[name].center))
            for piece in self.pieces[name]:
                if piece.kind != "particle":
                    points += [*(p + piece.points() @ R.T)]
            longest = max(longest, float(np.ptp(self.view(np.array(points)), axis=0).max()))
        return self.size / longest if longest > 0 else 1.0

    def _panel(self, name: str, scale: float, marks: Sequence[Mark], kinetic: bool) -> Group:
        panel = Panel(
            self.e, self.now, self.view, scale, name, self._back_to_front(name), fill_of(self.now.model, name),
            self.colors, self.unit, guide_of(self.now, self.view, name),
        )  # fmt: skip
        return panel.draw(
            marks,
            kinetic=kinetic,
            angles=self.angles and not kinetic,
            dimensions=self.dimensions and not kinetic,
            blank=self.mode == "blank",
        )

    def _back_to_front(self, name: str) -> list[Primitive]:
        """Pieces of a body from the back to the front, holes last."""
        R, p = self.now.posture(name)
        pieces = self.pieces[name]
        return sorted(
            pieces, key=lambda piece: (piece.hole, float(self.view.toward @ (p + R @ piece.center)))
        )

    def _axes(self, root: Group, beside: Group) -> None:
        """Add the directions of the ground axes, below to the left."""
        x0, y0, _, _ = box_of(beside)
        base = np.array([x0 + 4.0, y0 - 34.0])
        group = Group([], {"class": "axes"}, "ground axes")
        for letter, k in self.view.axes:
            d = 22.0 * self.view.matrix[:, k]
            group.add(Arrow(np.array([base, base + d]), Style(GREY, 0.9)))
            tex = f"${letter}$"
            w, h = size_of(tex, 10.0)
            d_unit = d / np.linalg.norm(d)
            at = base + d + d_unit * 6.0 - np.array([w / 2, h / 2])
            group.add(Label(tex, at, 10.0, GREY))
        # the axes stand below the bodies as a whole
        group = moved(group, np.array([0.0, min(0.0, y0 - 8.0 - box_of(group)[3])]))
        root.add(group)

    def _body_axes(self, root: Group, name: str) -> None:
        """Add the body axes 1, 2, 3, to which components with these numbers belong, above to the right."""
        R, _ = self.now.posture(name)
        _, _, x1, y1 = box_of(root)
        group = Group([], {"class": "body-axes"}, f"axes of {name}")
        placer = Placer()
        ends = []
        for k in range(3):
            d = 24.0 * (self.view.matrix @ R[:, k])
            length = float(np.linalg.norm(d))
            if length > 6.0:
                arrow = Arrow(np.array([np.zeros(2), d]), Style(GREY, 0.9))
                placer.arrow(arrow)
                group.add(arrow)
                ends.append((k, d, d / length))
        for k, d, unit in ends:
            group.add(placer.label(f"${k + 1}$", [(d, unit)], 10.0, GREY))
        bx = box_of(group)
        root.add(moved(group, np.array([x1 + 8.0 - bx[0], y1 - bx[3]])))

    def _heading(self, root: Group, title: str) -> None:
        x0, _, _, y1 = box_of(root)
        words = title.replace("_", " ")
        if self.now.moving:
            words += f",  t = {self.now.t:.4g} s"
        root.add(Label(words, np.array([x0, y1 + 10.0]), 12.0, INK))

    def _name_of(self, panel: Group, name: str) -> Label:
        x0, y0, x1, _ = box_of(panel)
        return _centered(name.replace("_", " "), (x0 + x1) / 2, y0 - 6.0, 10.0, GREY)

    def _below(self, root: Group, marks: Sequence[Mark]) -> None:
        """Add the laws of long labels and the states of contacts; to scale, also the table of values."""
        x0, y0, _, _ = box_of(root)
        top = y0 - 14.0
        for tex in self._lines(marks):
            _, h = size_of(tex, 10.0)
            root.add(Label(tex, np.array([x0, top - h]), 10.0, INK))
            top -= h + 6.0
        if self.mode == "scale":
            self._values(root, marks, x0, top - 4.0)

    def _lines(self, marks: Sequence[Mark]) -> list[str]:
        """Lines of text below a diagram."""
        lines: list[str] = []
        omitted: list[str] = []
        for mark in marks:
            if not mark.law:
                continue
            tex = f"${mark.law}$"
            if mark.law.endswith(OMITTED) or len(mark.law) > 420 or size_of(tex, 10.0)[0] > 520.0:
                omitted += [f"${mark.label}$"] if f"${mark.label}$" not in omitted else []
            elif tex not in lines:
                lines.append(tex)
        if omitted:
            lines.append(f"in the equations of the free body, too long for here: {', '.join(omitted)}")
        if self.mode != "blank":
            names = list(self.marks)
            states = contact_states(self.e, self.now, names)
            if states and self.e.chosen:
                states += textwrap.wrap(self.e.chosen.replace("_", " "), LINE)
            lines += states
            lines += self._of_teeth(names)
        where = dict.fromkeys(mark.where_tex for mark in marks if mark.where_tex)
        if where:
            lines.append(f"drawn for ${', '.join(where)}$")
        return lines

    def _values(self, root: Group, marks: Sequence[Mark], left: float, top: float) -> None:
        """Add the table of values."""
        rows = []
        for mark in marks:
            unit = r"\mathrm{N\,m}" if mark.couple else r"\mathrm{N}"
            label, value = mark.label, mark.value
            if label.startswith("-") and (mark.kind in ("reaction", "friction") or mark.law):
                label, value = label[1:], -(value or 0.0)
            tex = f"${label} = {'?' if value is None else latex_number(value, 4)}\\ {unit}$"
            if tex not in rows:
                rows.append(tex)
        columns = 1 if len(rows) < 4 else 2 if len(rows) < 9 else 3
        height = -(-len(rows) // columns)
        x = left
        for c in range(columns):
            column = rows[c * height : (c + 1) * height]
            for i, tex in enumerate(column):
                root.add(Label(tex, np.array([x, top - 17.0 * (i + 1)]), 10.0, INK))
            x += max((size_of(tex, 10.0)[0] for tex in column), default=0.0) + 26.0
        if any(
            m.value is not None and self.unit and not m.couple and self.unit * m.value < SHORTEST
            for m in marks
        ):
            words = "short arrows are drawn longer than to scale"
            root.add(Label(words, np.array([left, top - 17.0 * (height + 1)]), 9.0, GREY))

    def _of_teeth(self, names: Sequence[str]) -> list[str]:
        """Laws of the forces that press gear teeth apart, and notes on the reactions that gears leave indeterminate."""
        laws = dict.fromkeys(pair for name in names for pair in self.e.free_body(name).laws)
        lines = [f"${equation_latex(left, right, self.e.ring)}$" for left, right in laws]
        notes = dict.fromkeys(note for name in names for note in undetermined_by_couplings(self.e, body=name))
        for note in notes:
            lines += textwrap.wrap(note.replace("_", " "), LINE)
        return lines


def _put(root: Group, panel: Group, by: Array) -> Group:
    """Add a displaced copy of a panel to the sheet, with the displacement as an attribute; return it."""
    result = moved(panel, by)
    result.attributes["data-shift"] = f"{by[0]:.6f} {by[1]:.6f}"
    root.add(result)
    return result


def _middle(maker: Composition, name: str, scale: float) -> float:
    """Height of the mass centre of a body on paper [pt]."""
    center = maker.now.place(name, maker.now.model.bodies[name].center)
    return float(scale * maker.view(center)[1])


def _centered(tex: str, x: float, y: float, size: float, color: str) -> Label:
    """Return a label with its middle at (x, y)."""
    w, h = size_of(tex, size)
    return Label(tex, np.array([x - w / 2, y - h / 2]), size, color)


def separation(boxes: Sequence[Box], gap: float) -> list[Array]:
    """Displacements that separate overlapping boxes, each pair along its shorter overlap."""
    shifts = [np.zeros(2) for _ in boxes]

    def box(i: int) -> Box:
        x0, y0, x1, y1 = boxes[i]
        dx, dy = shifts[i]
        return (x0 + dx - gap / 2, y0 + dy - gap / 2, x1 + dx + gap / 2, y1 + dy + gap / 2)

    for _ in range(400):
        clear = True
        for i in range(len(boxes)):
            for j in range(i + 1, len(boxes)):
                a, b = box(i), box(j)
                if overlap(a, b) <= 1e-6:
                    continue
                clear = False
                w = min(a[2], b[2]) - max(a[0], b[0])
                h = min(a[3], b[3]) - max(a[1], b[1])
                k = 0 if w <= h else 1
                ahead = b[k] + b[k + 2] >= a[k] + a[k + 2]
                by = np.zeros(2)
                by[k] = (min(w, h) / 2 + 0.01) * (1.0 if ahead else -1.0)
                shifts[i] -= by
                shifts[j] += by
        if clear:
            break
    return shifts
