"""Drawing of a machine: bodies, joints, springs and loads in the standard symbols of mechanics, and coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.system import System
from ...model.model import Model
from ...motion.trajectory.trajectory import Trajectory
from ...symbolic.equations import Equations
from ...symbolic.printing.latex import latex_name
from ...symbolic.printing.names import GREEK
from ..paper import symbols
from ..paper.drawing import Drawing
from ..paper.palette import GREY, INK, legible
from ..paper.placing import inside, sampled
from ..paper.sheet import Group, Label, Line, Sheet, Style
from ..paper.view import view_of
from .configuration import configuration, equations_at, of_the_motion
from .draw_coordinates import ground_axes, mark_coordinates, mark_dimensions
from .draw_forces import gravity, impulses, loads, springs
from .draw_gears import gears, solids_with_teeth
from .draw_ground import belts, feet, guides, rolling_planes, ropes, scenery, surfaces
from .inclinations import mark_inclinations
from .machine_drawing import WIDE, MachineDrawing
from .outlines import guide_of, outlines, polygon

Array = NDArray[np.float64]

PATH, STEP, NEARBY, WIDEST = 24, 3.0, 1e-6, 0.1
"""Points of a path on each side of its joint, and their distance [pt]; changes of its coordinate: for a slope, most."""

CROWD = 2
"""Most joints at one point that have labels of their own."""

ROOM = 18.0
"""Distance of a name from bodies in front of its own, where there is room [pt]."""

LEADING, TOUCHING = 12.0, 3.5
"""Distance of a name from what it names beyond which a line leads there, and the gap at both ends of that line [pt]."""


def draw(
    system: System | Model | Equations,
    *,
    at: Any = None,
    trajectory: Trajectory | None = None,
    values: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    modes: Mapping[str, Any] | None = None,
    coordinates: bool = True,
    dimensions: bool | None = None,
    names: bool = True,
    axonometric: bool = False,
    impulses: Mapping[str, Any] | None = None,
) -> Drawing:
    """Draw a machine: bodies, joints, springs, loads, coordinates, axes.

    A planar machine is drawn in its plane, any other in an axonometric view.

    Parameters
    ----------
    system : System, Model or Equations
    at : mapping or number, optional
        Coordinates, ``{"theta": "30deg"}``, or the time of ``trajectory`` [s]. Coordinates that you do not name get
        generic values, at which nothing is in line; those of a robot that was read from a file have the file's pose.
    trajectory : Trajectory, optional
        A motion of the system.
    values : mapping, optional
        Values of parameters, in place of their defaults.
    near : mapping, optional
        For machines with loops: an approximate closed configuration.
    modes : mapping, optional
        Contact modes, ``{"floor": "stick"}``; contacts that are not open are drawn closed. Without modes, bodies stand
        on the surfaces that they may touch.
    coordinates, names : bool
        Show the coordinates, and the names of bodies and joints. A joint whose coordinate has its name has one label.
    dimensions : bool, optional
        Show the lengths; by default except for machines of more than five bodies in space, whose drawing has no room
        for them.
    axonometric : bool
        Draw a planar machine in the axonometric view, too.
    impulses : mapping, optional
        Blows to show, by name: (point of a body, three components in ground axes), as :func:`freebody.impulse` takes
        them.

    Returns
    -------
    Drawing
        ``.svg``, ``.tikz``, ``.save("x.pdf")``; notebooks show it.

    Raises
    ------
    ModelError
        If the machine cannot have these coordinates.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L = s.parameters(m=1.0, L=2.0)
    >>> bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, L/2, 0), axis="z", coordinate="theta")
    >>> fb.draw(s, at={"theta": "30deg"}).svg.count('data-joint="pin"')
    1
    """
    e = of_the_motion(system, trajectory, equations_at(system, None, None, modes))
    now = configuration(e.model, at, trajectory=trajectory, values=values, near=near)
    view = view_of(e.model, e, now.values, axonometric)
    maker = Machine(e, now, view)
    return Drawing(maker.sheet(coordinates, dimensions, names, impulses or {}))


def _joint_label(name: str) -> str:
    """A name of several words as words, any other as a symbol."""
    words = name.split("_")
    if len(words) > 1 and all(len(word) > 2 and word.isalpha() and word not in GREEK for word in words):
        return " ".join(words)
    return f"${latex_name(name)}$"


class Machine(MachineDrawing):
    """Draws one machine in one configuration."""

    def sheet(
        self, coordinates: bool, dimensions: bool | None, names: bool, blows: Mapping[str, Any]
    ) -> Sheet:
        """Return the sheet with everything, drawn from the back to the front."""
        scenery(self)
        rolling_planes(self)
        surfaces(self)
        ropes(self)
        belts(self)
        guides(self)
        for name in self.drawn:
            self._body(name)
        gears(self)
        feet(self)
        self._joint_symbols()
        springs(self)
        loads(self)
        impulses(self, blows)
        if coordinates:
            mark_coordinates(self)
        if not self.many if dimensions is None else dimensions:
            mark_dimensions(self)
            if self.view.planar:
                mark_inclinations(self)
        ground_axes(self)
        gravity(self)
        if names:
            self._names()
        for k, (tex, anchors, size, color) in enumerate(self.labels):
            label = self.placer.label(tex, anchors, size, legible(color))
            self.root.add(label)
            if k in self.named:
                self._lead(label, anchors[0][0], self.named[k])
        title = f"{self.model.name}" + (f", t = {self.now.t:.4g} s" if self.now.moving else "")
        attributes = {
            "class": "freebody-drawing",
            "data-scale": f"{self.scale:.12g}",
            "data-view": " ".join(f"{x:.12g}" for x in self.view.matrix.ravel()),
        }
        return Sheet(self.root, title, attributes)

    # -- parts ----------------------------------------------------------------------------------------

    def _body(self, name: str) -> None:
        R, p = self.now.posture(name)
        fill = self.fill(name)
        toothed = {id(solid) for solid in solids_with_teeth(self)}
        group = Group([], {"class": "body", "data-body": name}, name)
        order = sorted(
            self.pieces[name],
            key=lambda piece: (piece.hole, float(self.view.toward @ (p + R @ piece.center))),
        )
        for piece in order:
            for item in outlines(
                piece, R, p, self.view, self.scale, fill, guide_of(self.now, self.view, name)
            ):
                if id(piece) not in toothed:  # the outline of a gear is that of its teeth
                    group.add(item)
                area = polygon(item)
                if area is not None:
                    self.placer.area(area, 1.0 if piece.kind in ("slender_bar", "rod") else 0.3)
                else:
                    self.placer.line(item.points)
        self.root.add(group)

    def _joint_symbols(self) -> None:
        for name, (kind, pair, parent, child, point) in self.joints.items():
            at = self.page(point)
            attributes = {"class_": f"joint {kind}", "data_joint": name}
            if pair.planar and self._at_centre(name):
                self.add(symbols.mass_centre(at), class_="mass-centre", data_body=child)
            if not pair.holds or not self._shows(parent, child):  # no point of a drawn body is held
                continue
            if name in self.idle:
                self.add(symbols.mass_centre(at), **attributes)
                continue
            if pair.guided:
                if parent != "ground" or pair.turns or not self.view.planar:
                    self._rail(name, at)
                continue
            if pair.path:
                self.add([Line(line, Style(INK, 1.0)) for line in self._paths(name)], **attributes)
                continue
            d = self.axis(name) if pair.revolute and not self.view.planar else None
            if d is not None:
                self.add(self._shaft(name, at, d), **attributes)
            elif "ground" in (parent, child):
                make = symbols.pin_on_ground if pair.revolute else symbols.ball_on_ground
                items = make(at, self._outward(child if parent == "ground" else parent, at))
                self.add(items + (symbols.pin(at) if pair.revolute else []), **attributes)
            elif pair.rigid:
                square = at + np.array([(-3, -3), (3, -3), (3, 3), (-3, 3)])
                self.add([Line(square, Style(INK, 1.0, (), INK), True)], **attributes)
            else:
                self.add(symbols.pin(at), **attributes)

    def _at_centre(self, joint: str) -> bool:
        """True if the coordinates of a joint are those of the mass centre of its body."""
        place = self.model.joints[joint]
        center = self.model.bodies[place.child].center
        return (
            self.view.planar
            and place.child in self.drawn
            and all(
                float(self.now.state(a)) == float(self.now.state(b))
                for a, b in zip(place.to, center, strict=True)
            )
        )

    def _shows(self, *bodies: str) -> bool:
        """True if any of these bodies is drawn."""
        return any(body in self.drawn for body in bodies)

    def _shaft(self, name: str, at: Array, d: Array) -> list[Any]:
        """A hinge in space: its axis, and bearings if the axis is fixed in the ground."""
        _, _, parent, child, _ = self.joints[name]
        on_ground = "ground" in (parent, child)
        # a bearing stands outside all bodies that contain the point
        around = [body for body in self.drawn if on_ground and self._holds(body, at)]
        ends = [
            at + side * (max(self.along(body, at, side * d) for body in (child, *around)) + 13.0) * d
            for side in (1.0, -1.0)
        ]
        items: list[Any] = [Line(np.array(ends), Style(INK, 0.9, (9.0, 2.0, 1.5, 2.0)))]
        for end, side in zip(ends, (1.0, -1.0), strict=True):
            items += symbols.bearing(end - 6.0 * side * d, d, self.down) if on_ground else []
        return items if on_ground else [*items, *symbols.pin(at)]

    def _outward(self, body: str, at: Array) -> Array:
        """Direction of a bracket, outside its body: down, or up if the body hangs down from its joint."""
        center = self.page(self.now.place(body, self.model.bodies[body].center))
        arm = center - at
        length = float(np.linalg.norm(arm))
        down = self.down
        return -down if length > 3.0 and float(arm @ down) > 0.2 * length else down

    def _paths(self, name: str) -> list[Array]:
        """Curves on which the point of a joint by functions moves, on paper: one for each of its coordinates."""
        place = self.model.joints[name]
        speeds = {j for i in place.links for j, _ in self.model.links[i].partials}
        curves = []
        for i, moved_by in enumerate(self.model.moved_by):
            if not speeds.isdisjoint(moved_by):
                line = [self._along_path(place, i, 0.0)]
                for side in (-1, 1):
                    shift = 0.0
                    for _ in range(PATH):
                        last = line[0 if side < 0 else -1]
                        pace = (
                            float(np.linalg.norm(self._along_path(place, i, shift + side * NEARBY) - last))
                            / NEARBY
                        )
                        shift += side * min(WIDEST, STEP / pace if pace > 0 else WIDEST)
                        line.insert(0 if side < 0 else len(line), self._along_path(place, i, shift))
                curves.append(np.array(line))
        return curves

    def _along_path(self, place: Any, coordinate: int, shift: float) -> Array:
        """Point of a joint on its child, on paper, with one coordinate changed."""
        return self.page(self.now.moved({coordinate: shift}).place(place.child, place.to))

    def _rail(self, name: str, at: Array) -> None:
        """Draw the line along which a body slides on another body, or in space."""
        d = self.axis(name)
        if d is None:
            return
        line = np.array([at - 26.0 * d, at + 26.0 * d])
        self.add([Line(line, Style(INK, 0.8, (8.0, 2.0, 1.5, 2.0)))], class_="joint slider", data_joint=name)

    def _holds(self, name: str, at: Array) -> bool:
        """True if a point on paper lies in a body."""
        return any(inside(area, at[None]).any() for area in self.areas_of(name))

    # -- names ----------------------------------------------------------------------------------------

    def _names(self) -> None:
        for name in self.model.bodies:
            if name in self.drawn:
                self.named[len(self.labels)] = name
                self.labels.append((name.replace("_", " "), [(self._visible_point(name), None)], 10.5, INK))
        points: list[tuple[Array, list[str]]] = []
        shown = {tex for tex, *_ in self.labels}
        for name, (_, pair, parent, child, point) in self.joints.items():
            if not pair.holds or not self._shows(parent, child) or f"${latex_name(name)}$" in shown:
                continue
            at = self.page(point)
            together = next((names for q, names in points if float(np.linalg.norm(q - at)) < 1.0), None)
            if together is None:
                points.append((at, [name]))
            else:
                together.append(name)
        for at, names in points:
            labels = [_joint_label(name) for name in names if name not in self.drawn]
            if len(names) > CROWD:
                labels = [", ".join(labels)]
            if not any(self.joints[name].pair.guided for name in names):
                self.named |= dict.fromkeys(range(len(self.labels), len(self.labels) + len(labels)))
            self.labels += [(label, [(at, None)], 9.5, GREY) for label in labels]

    def _lead(self, label: Label, at: Array, body: str | None) -> None:
        """Draw a thin line from the name of a joint or body to it, if the name stands apart or beside another body."""
        low, high = np.array(label.box[:2]), np.array(label.box[2:])

        def apart(points: Array) -> float:
            beyond = np.maximum(np.maximum(low - points, points - high), 0.0)
            return float(np.linalg.norm(beyond, axis=1).min())

        start = np.clip(at, low, high)
        gap = apart(at[None])
        if body is not None:
            gaps = {name: self._apart(name, apart, (low + high) / 2) for name in self.drawn}
            if gaps[body] <= min(LEADING, *(gaps[name] for name in gaps if name != body), LEADING):
                return
        elif gap <= LEADING:
            return
        d = (at - start) / gap
        line = np.array([start + TOUCHING / 2 * d, at - (TOUCHING * d if body is None else 0)])
        self.add([Line(line, Style(GREY, 0.6))], class_="leader")

    def _apart(self, name: str, apart: Callable[[Array], float], middle: Array) -> float:
        """Distance of a label from a body on paper, 0 on the body."""
        areas = self.areas_of(name)
        if self._holds(name, middle):
            return 0.0
        return min((apart(sampled(np.vstack([area, area[:1]]), 2.0)) for area in areas), default=math.inf)

    def _visible_point(self, name: str) -> Array:
        """Mass centre of a body on paper; if other bodies hide it, the nearest visible point of the body."""
        center = self.page(self.now.place(name, self.model.bodies[name].center))
        pieces = self.pieces[name]
        if all(piece.kind == "rod" for piece in pieces):
            R, p = self.now.posture(name)
            center = self.page(p + R @ pieces[0].center)
        in_front = self.drawn[self.drawn.index(name) + 1 :]
        if not any(self._holds(body, center) for body in in_front):
            return center
        r = np.arange(0.0, WIDE, 6.0)[1:]
        turn = np.radians(np.arange(0.0, 360.0, 15.0))
        rays = np.stack([np.outer(r, np.cos(turn)), np.outer(r, np.sin(turn))], axis=-1)
        around = center + rays.reshape(-1, 2)
        covered = np.any([inside(area, around) for area in self.areas_of(name)], axis=0)
        hidden = np.any([inside(area, around) for body in in_front for area in self.areas_of(body)], axis=0)
        visible = around[covered & ~hidden]
        # the nearest that is as far from the bodies in front as a name is high: there, it is not read as theirs
        ring = ROOM * np.column_stack([np.cos(turn), np.sin(turn)])
        for at in visible:
            beside = at + ring
            if not np.any([inside(area, beside) for body in in_front for area in self.areas_of(body)]):
                return at
        return visible[0] if len(visible) else center
