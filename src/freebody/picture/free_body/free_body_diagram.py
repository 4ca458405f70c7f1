"""Free-body diagrams, drawn from the symbols of the free-body equations.

Left the isolated body with everything that acts on it, right the same body with m a_C and dH_C/dt (I_C α in a plane):
the equations are what the two sides say. Every arrow bears its expression, its point and its direction as attributes,
so that a drawing can be read back and summed up.

The file is longer than others: the maker of a diagram keeps what all its parts have to avoid.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.body import Body
from ...describe.system import System
from ...dynamics.constraints import radial_names
from ...errors import ModelError, nearest
from ...model.model import Model
from ...motion.trajectory.trajectory import Trajectory
from ...symbolic.equations import Equations
from ...symbolic.free_body.gears import undetermined_by_gears
from ...symbolic.printing.display import equation_latex
from ...symbolic.printing.latex import latex_name
from ..machine.configuration import Configuration, configuration, equations_at, modes_drawn
from ..machine.force_arrows import Mark, Marks
from ..machine.shapes import Primitive, attachments, fill_of, machine_size
from ..machine.solid_pieces import pieces_of
from ..paper.drawing import Drawing
from ..paper.labels import size_of
from ..paper.palette import GREY, INK, PAIRS
from ..paper.placing import Placer
from ..paper.sheet import Arrow, Group, Label, Sheet, Style, box_of, moved, overlap
from ..paper.view import View, view_of
from .contact_states import contact_states
from .panel import LONGEST, Panel

Array = NDArray[np.float64]

MODES = ("symbolic", "scale", "blank")

ROUND_OFF = 1e-10
"""Forces (couples) below this part of the greatest one are zero to scale."""

WIDE = 150.0
"""Length of the largest body on paper [pt]."""

LINE = 64
"""Characters of a line of words below a diagram."""


def free_body_diagram(
    system: System | Model | Equations,
    body: str | Body = "all",
    *,
    at: Any = None,
    trajectory: Trajectory | None = None,
    mode: str | None = None,
    values: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    modes: Mapping[str, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    angles: bool = True,
    dimensions: bool = False,
    kinetic: bool | None = None,
) -> Drawing:
    """Draw the free-body diagram and the kinetic diagram of a body.

        Σ F = m a_C,        Σ M_C = dH_C/dt        (I_C α of a planar machine)

    Planar machines are drawn in their plane, which is found and not declared; others in an axonometric view.

    Parameters
    ----------
    system : System, Model or Equations
    body : str or Body
        Or "all": all bodies apart, with the two sides of each joint in one colour and opposite arrows.
    at : mapping or number, optional
        Coordinates at which the body is drawn, ``{"theta": "30deg"}``, or the time of ``trajectory`` [s]. Coordinates
        that are not named get values at which nothing lies in one line.
    trajectory : Trajectory, optional
        A motion of the system.
    mode : "symbolic", "scale" or "blank"
        Arrows of one length; arrows to scale with a table of values, at a time of a trajectory (the default where one
        is given); or outlines and points alone, for exercises.
    values : mapping, optional
        Of parameters, in place of their defaults.
    near : mapping, optional
        Of a machine with loops: coordinates near which it is closed.
    modes : mapping, optional
        Of contacts, as of :func:`freebody.equations`: ``{"floor": "stick"}``; of a motion, those of its moment. If
        not given, those in which the motion starts: from ``initial``; without it from coordinates of zero or, where
        nothing touches there or ``at`` is given, from rest as the machine is drawn.
    initial : mapping, optional
        The start of a motion with contacts, as of :func:`freebody.simulate`.
    angles, dimensions : bool
        Whether the angle of the body and the distances of its points are marked (planar machines).
    kinetic : bool, optional
        Whether the kinetic diagram stands beside; by default, but for "all".

    Returns
    -------
    Drawing
        ``.svg``, ``.tikz``, ``.save("x.pdf")``; shows itself in notebooks.

    Raises
    ------
    ModelError
        An unknown body or mode, coordinates that the machine can not have.

    Notes
    -----
    An arrow shows the sense in which its symbol is positive. To scale it shows the sense of the force, with a minus at
    a symbol whose value is negative. Source: chapter 6, eqs (6.1), (6.25); layout as is usual in Meriam & Kraige,
    Engineering Mechanics: Dynamics.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, L/2, 0), axis="z", coordinate="theta")
    >>> fb.free_body_diagram(s, "bar").svg.count('class="force"')
    5
    """
    chosen = ""
    if trajectory is None and modes is None and not isinstance(system, Equations):
        modes, chosen = modes_drawn(system, at, initial, values, near)
    elif initial is not None:
        raise ModelError(
            "Expected no initial= where modes=, a motion or equations say what contacts do. Leave it out."
        )
    e = equations_at(system, trajectory, at, modes)
    e.chosen = e.chosen or chosen
    model = e.model
    mode = _mode(mode, trajectory)
    name = body.name if isinstance(body, Body) else body
    if not isinstance(name, str) or (name != "all" and name not in model.bodies):
        raise ModelError(
            f"Expected a body of '{model.name}' (or 'all') for a free-body diagram, got {name!r}; "
            f"{nearest(str(name), [*model.bodies, 'all'])}"
        )
    now = configuration(model, at, trajectory=trajectory, values=values, near=near)
    if mode != "scale":
        now = replace(now, moving=False)  # a position like any other
    view = view_of(model, e, now.values)
    marks = Marks(e, now, view.planar)
    names = list(model.bodies) if name == "all" else [name]
    kinetic = name != "all" if kinetic is None else kinetic
    found = {one: _of_body(e, marks, one, kinetic, mode) for one in names}
    maker = _Maker(e, now, view, found, mode, angles, dimensions, kinetic)
    return Drawing(maker.exploded() if name == "all" else maker.single(name))


def _mode(mode: str | None, trajectory: Any) -> str:
    if mode is None:
        return "symbolic" if trajectory is None else "scale"
    if mode not in MODES:
        raise ModelError(f"Expected 'symbolic', 'scale' or 'blank' for mode, got {mode!r}.")
    if mode == "scale" and trajectory is None:
        raise ModelError(
            "Arrows to scale need values: pass trajectory= (of fb.simulate) and the time as at=. Without them "
            "mode='symbolic' draws all arrows of one length."
        )
    return mode


def _of_body(
    e: Equations, marks: Marks, name: str, kinetic: bool, mode: str
) -> tuple[list[Mark], list[Mark]]:
    if mode == "blank":
        return [], []
    free = e.free_body(name)
    return marks.of(free), marks.kinetic(free) if kinetic else []


class _Maker:
    """Puts panels, captions and tables on a sheet."""

    def __init__(
        self,
        e: Equations,
        now: Configuration,
        view: View,
        found: dict[str, tuple[list[Mark], list[Mark]]],
        mode: str,
        angles: bool,
        dimensions: bool,
        kinetic: bool,
    ) -> None:
        self.e, self.now, self.view, self.found, self.mode = e, now, view, found, mode
        self.angles, self.dimensions, self.kinetic = angles, dimensions, kinetic
        self.pieces = pieces_of(now, view.planar)
        owners = dict.fromkeys(mark.owner for acting, _ in found.values() for mark in acting if mark.owner)
        exploded = len(found) > 1
        # of a body alone, the colour says what kind of force it is
        self.colors = {owner: PAIRS[i % len(PAIRS)] for i, owner in enumerate(owners)} if exploded else {}
        self.greatest = {False: 0.0, True: 0.0}
        for acting, moving in found.values():
            for mark in (*acting, *moving):
                self.greatest[mark.couple] = max(self.greatest[mark.couple], mark.value or 0.0)
        longest = self.greatest[False]
        self.unit = LONGEST / longest if mode == "scale" and longest > 0 else None

    # -- sheets -------------------------------------------------------------------------------------

    def single(self, name: str) -> Sheet:
        """A body, and beside it its kinetic diagram."""
        acting, moving = self.found[name]
        if self.mode == "scale":
            acting, moving = self._felt(acting), self._felt(moving)
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
            right = self._panel(name, scale, moving, True)
            if any(mark.law and mark.label[-2:-1] in "123" for mark in moving):
                self._body_axes(right, name)
            bx = box_of(right)
            shift = np.array([x1 + 52.0 - bx[0], 0.0])
            root.add(_centered("$=$", x1 + 26.0, _middle(self, name, scale), 20.0, INK))
            right = _put(root, right, shift)
            bx = box_of(right)
            if not moving and self.mode != "blank":
                root.add(_centered("(no acceleration)", (bx[0] + bx[2]) / 2, bx[1] - 6.0, 9.5, GREY))
            low = min(low, bx[1] - 10.0)
            root.add(_centered("kinetic diagram", (bx[0] + bx[2]) / 2, low, 10.0, GREY))
        self._below(root, [*acting, *moving])
        self._heading(root, name)
        return self._sheet(root, scale, f"Free-body diagram of {name} ({self.now.model.name})")

    def _felt(self, marks: Sequence[Mark]) -> list[Mark]:
        """Without what is zero but for round-off, at this moment."""
        # a couple is measured by the forces too, at an arm of the machine's size
        arm = self.greatest[False] * machine_size(self.now.model, self.now.values)
        least = {False: ROUND_OFF * self.greatest[False], True: ROUND_OFF * max(self.greatest[True], arm)}
        return [mark for mark in marks if mark.value is None or mark.value > least[mark.couple]]

    def exploded(self) -> Sheet:
        """All bodies, pushed apart until nothing overlaps."""
        names = list(self.found)
        scale = self._scale(names)
        panels = []
        for name in names:
            acting = self.found[name][0]
            if self.mode == "scale":
                acting = self._felt(acting)
            panels.append(self._panel(name, scale, acting, False))
            panels[-1].add(self._name_of(panels[-1], name))
        shifts = _apart([box_of(panel) for panel in panels], 16.0)
        root = Group()
        for panel, shift in zip(panels, shifts, strict=True):
            _put(root, panel, shift)
        self._axes(root, root)
        marks = [mark for acting, _ in self.found.values() for mark in acting]
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
        """Points per unit of length, so that the largest body has its size on paper."""
        longest = 0.0
        for name in names:
            R, p = self.now.posture(name)
            points = [p + R @ q for q in attachments(self.now.model, self.now.state, name).values()]
            points.append(self.now.place(name, self.now.model.bodies[name].center))
            for piece in self.pieces[name]:
                if piece.kind != "particle":
                    points += [p + R @ q for q in piece.points()]
            seen = self.view(np.array(points))
            longest = max(longest, float(np.ptp(seen, axis=0).max()))
        return WIDE / longest if longest > 0 else 1.0

    def _panel(self, name: str, scale: float, marks: Sequence[Mark], kinetic: bool) -> Group:
        panel = Panel(
            self.e, self.now, self.view, scale, name, self._visible(name), fill_of(self.now.model, name),
            self.colors, self.unit, _slides(self.now.model, name),
        )  # fmt: skip
        return panel.draw(
            marks,
            kinetic=kinetic,
            angles=self.angles and not kinetic,
            dimensions=self.dimensions and not kinetic,
            blank=self.mode == "blank",
        )

    def _visible(self, name: str) -> Sequence[Primitive]:
        """The pieces from the back to the front."""
        R, p = self.now.posture(name)
        pieces = self.pieces[name]
        return sorted(pieces, key=lambda one: (one.hole, float(self.view.toward @ (p + R @ one.center))))

    def _axes(self, root: Group, beside: Group) -> None:
        """The directions of the ground's axes, below to the left."""
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
        # all of it below what it stands beside
        group = moved(group, np.array([0.0, min(0.0, y0 - 8.0 - box_of(group)[3])]))
        root.add(group)

    def _body_axes(self, root: Group, name: str) -> None:
        """The body's axes 1, 2, 3, to which components with these numbers belong, above to the right."""
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
        for k, d, way in ends:
            group.add(placer.label(f"${k + 1}$", [(d, way)], 10.0, GREY))
        bx = box_of(group)
        root.add(moved(group, np.array([x1 + 8.0 - bx[0], y1 - bx[3]])))

    def _heading(self, root: Group, what: str) -> None:
        x0, _, _, y1 = box_of(root)
        words = what.replace("_", " ")
        if self.now.moving:
            words += f",  t = {self.now.t:.4g} s"
        root.add(Label(words, np.array([x0, y1 + 10.0]), 12.0, INK))

    def _name_of(self, panel: Group, name: str) -> Label:
        x0, y0, x1, _ = box_of(panel)
        return _centered(name.replace("_", " "), (x0 + x1) / 2, y0 - 6.0, 10.0, GREY)

    def _below(self, root: Group, marks: Sequence[Mark]) -> None:
        """What long labels stand for, and of a moment the values."""
        x0, y0, x1, _ = box_of(root)
        lines: list[str] = []
        left: list[str] = []
        for mark in marks:
            if not mark.law:
                continue
            tex = f"${mark.law}$"
            if len(mark.law) > 420 or size_of(tex, 10.0)[0] > 520.0:
                left += [f"${mark.label}$"] if f"${mark.label}$" not in left else []
            elif tex not in lines:
                lines.append(tex)
        if left:
            lines.append(f"in the equations of the free body, too long for here: {', '.join(left)}")
        if self.mode != "blank":
            names = list(self.found) if len(self.found) > 1 else [next(iter(self.found))]
            states = contact_states(self.e, self.now, names)
            if states and self.e.chosen:
                states += textwrap.wrap(self.e.chosen.replace("_", " "), LINE)
            lines += states
            lines += self._of_teeth(names)
        where = dict.fromkeys(mark.where_tex for mark in marks if mark.where_tex)
        if where:
            lines.append(f"drawn for ${', '.join(where)}$")
        top = y0 - 14.0
        for tex in lines:
            _, h = size_of(tex, 10.0)
            root.add(Label(tex, np.array([x0, top - h]), 10.0, INK))
            top -= h + 6.0
        if self.mode != "scale":
            return
        rows = []
        for mark in marks:
            unit = r"\mathrm{N\,m}" if mark.couple else r"\mathrm{N}"
            label, value = mark.label, mark.value
            if label.startswith("-") and (mark.kind in ("reaction", "friction") or mark.law):
                label, value = label[1:], -(value or 0.0)
            tex = f"${label} = {_number(value)}\\ {unit}$"
            if tex not in rows:
                rows.append(tex)
        columns = 1 if len(rows) < 4 else 2 if len(rows) < 9 else 3
        deep = -(-len(rows) // columns)
        at = x0
        top -= 4.0
        for c in range(columns):
            part = rows[c * deep : (c + 1) * deep]
            for i, tex in enumerate(part):
                root.add(Label(tex, np.array([at, top - 17.0 * (i + 1)]), 10.0, INK))
            at += max((size_of(tex, 10.0)[0] for tex in part), default=0.0) + 26.0
        if any(
            m.value is not None and self.unit and not m.couple and self.unit * m.value < 11.0 for m in marks
        ):
            words = "short arrows are drawn longer than to scale"
            root.add(Label(words, np.array([x0, top - 17.0 * (deep + 1)]), 9.0, GREY))

    def _of_teeth(self, names: Sequence[str]) -> list[str]:
        """What presses teeth apart, and what gears leave open of the reactions, a line each."""
        laws = dict.fromkeys(pair for name in names for pair in self.e.free_body(name).laws)
        lines = [f"${equation_latex(left, right, self.e.ring)}$" for left, right in laws]
        notes = dict.fromkeys(note for name in names for note in undetermined_by_gears(self.e, body=name))
        for note in notes:
            words = note.replace("_", " ")
            for name in radial_names(self.e.model).values():
                words = words.replace(name.replace("_", " "), f"${latex_name(name)}$")
            lines += textwrap.wrap(words, LINE)
        return lines


def _put(root: Group, panel: Group, by: Array) -> Group:
    """A panel on the sheet; it remembers how far it was displaced."""
    result = moved(panel, by)
    result.attributes["data-shift"] = f"{by[0]:.6f} {by[1]:.6f}"
    root.add(result)
    return result


def _middle(maker: _Maker, name: str, scale: float) -> float:
    center = maker.now.place(name, maker.now.model.bodies[name].center)
    return float(scale * maker.view(center)[1])


def _centered(tex: str, x: float, y: float, size: float, color: str) -> Label:
    """A label about the height y of its middle (or under it, for captions)."""
    w, h = size_of(tex, size)
    return Label(tex, np.array([x - w / 2, y - h / 2]), size, color)


def _number(value: float | None) -> str:
    if value is None:
        return "?"
    text = f"{value:.4g}"
    if "e" in text:
        mantissa, exponent = text.split("e")
        return rf"{mantissa} \times 10^{{{int(exponent)}}}"
    return text


def _slides(model: Model, body: str) -> bool:
    return any(joint.child == body and joint.type == "slider" for joint in model.joints.values())


def _apart(boxes: Sequence[Any], gap: float) -> list[Array]:
    """Displacements by which boxes get clear of one another, along the shorter way out."""
    shifts = [np.zeros(2) for _ in boxes]

    def at(i: int) -> Any:
        x0, y0, x1, y1 = boxes[i]
        dx, dy = shifts[i]
        return (x0 + dx - gap / 2, y0 + dy - gap / 2, x1 + dx + gap / 2, y1 + dy + gap / 2)

    for _ in range(400):
        clear = True
        for i in range(len(boxes)):
            for j in range(i + 1, len(boxes)):
                a, b = at(i), at(j)
                if overlap(a, b) <= 1e-6:
                    continue
                clear = False
                w = min(a[2], b[2]) - max(a[0], b[0])
                h = min(a[3], b[3]) - max(a[1], b[1])
                k = 0 if w <= h else 1
                way = (b[k] + b[k + 2]) - (a[k] + a[k + 2])
                by = np.zeros(2)
                by[k] = (min(w, h) / 2 + 0.01) * (1.0 if way >= 0 else -1.0)
                shifts[i] -= by
                shifts[j] += by
        if clear:
            break
    return shifts
