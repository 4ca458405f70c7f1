"""The drawing of a machine: bodies, joints, springs and loads with the symbols of the field, and its coordinates."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.system import System
from ...dynamics.kinematics import link_postures
from ...model.closure import Closure
from ...model.model import Link, Model
from ...motion.trajectory.trajectory import Trajectory
from ...symbolic.equations import Equations
from ...symbolic.printing.latex import latex_name
from ..paper import symbols
from ..paper.drawing import Drawing
from ..paper.palette import GREY, INK, legible
from ..paper.placing import Placer, inside
from ..paper.sheet import Arrow, Circle, Group, Line, Sheet, Style, arc
from ..paper.view import View, view_of
from .configuration import Configuration, configuration, equations_at
from .draw_coordinates import ground_axes, mark_coordinates, mark_dimensions
from .draw_forces import gravity, loads, springs
from .draw_ground import feet, gears, guides, rolling_planes, ropes, round_walls, surfaces
from .outlines import outlines, polygon
from .shapes import attachments, fill_of
from .solid_pieces import pieces_of

Array = NDArray[np.float64]

WIDE = 250.0
"""Length of the machine on paper [pt]."""

CROWD = 2
"""Joints at one point up to which each has its own label."""


def draw(
    system: System | Model | Equations,
    *,
    at: Any = None,
    trajectory: Trajectory | None = None,
    values: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    modes: Mapping[str, Any] | None = None,
    coordinates: bool = True,
    dimensions: bool = True,
    names: bool = True,
    axonometric: bool = False,
) -> Drawing:
    """Draw a machine: bodies, joints, springs, loads, coordinates, axes.

    Planar machines are drawn in their plane, others in an axonometric view.

    Parameters
    ----------
    system : System, Model or Equations
    at : mapping or number, optional
        Coordinates, ``{"theta": "30deg"}``, or the time of ``trajectory`` [s]. Coordinates that are not named get
        values at which nothing lies in one line.
    trajectory : Trajectory, optional
        A motion of the system.
    values : mapping, optional
        Of parameters, in place of their defaults.
    near : mapping, optional
        Of a machine with loops: coordinates near which it is closed.
    modes : mapping, optional
        Of contacts, ``{"floor": "stick"}``: those that are not open are drawn closed. Without modes, bodies stand on
        what they may touch.
    coordinates, dimensions, names : bool
        Whether the coordinates, the lengths, and the names of bodies and joints are written.
    axonometric : bool
        Draw a planar machine in space, too.

    Returns
    -------
    Drawing
        ``.svg``, ``.tikz``, ``.save("x.pdf")``; shows itself in notebooks.

    Raises
    ------
    ModelError
        Coordinates that the machine can not have.

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
    e = equations_at(system, None, None, modes)
    now = configuration(e.model, at, trajectory=trajectory, values=values, near=near)
    view = view_of(e.model, e, now.values, axonometric)
    maker = Machine(e, now, view)
    return Drawing(maker.sheet(coordinates, dimensions, names))


class Machine:
    """Draws one machine in one configuration.

    Attributes
    ----------
    e, now, view
        Equations, configuration, view.
    scale : float
        Points per unit of length.
    labels : list
        Labels that are placed when all lines are drawn: text, anchors, size, colour.
    arcs : list
        The points about which angles are drawn.
    """

    wide = WIDE

    def __init__(self, e: Equations, now: Configuration, view: View) -> None:
        self.e, self.now, self.view = e, now, view
        self.model = e.model
        self.pieces = pieces_of(now, view.planar)
        self.placer = Placer()
        self.root = Group()
        self.labels: list[tuple[str, list[tuple[Array, Array | None]], float, str]] = []
        self.arcs: list[Array] = []
        points = self.extent()
        seen = view(np.array(points))
        longest = float(np.ptp(seen, axis=0).max())
        self.scale = WIDE / longest if longest > 0 else 1.0
        self.down = np.array([0.0, -1.0])
        self.joints: dict[str, tuple[str, str, str, Array]] = self._joints()
        self.drawn = self._from_behind()

    def page(self, point: Any) -> Array:
        """A point in ground axes on paper."""
        return self.scale * self.view(point)

    def sheet(self, coordinates: bool, dimensions: bool, names: bool) -> Sheet:
        """Everything, from the back to the front."""
        rolling_planes(self)
        surfaces(self)
        ropes(self)
        guides(self)
        for name in self.drawn:
            self._body(name)
        gears(self)
        feet(self)
        self._joint_symbols()
        springs(self)
        loads(self)
        if coordinates:
            mark_coordinates(self)
        if dimensions and self.view.planar:
            mark_dimensions(self)
        ground_axes(self)
        gravity(self)
        if names:
            self._names()
        for tex, anchors, size, color in self.labels:
            self.root.add(self.placer.label(tex, anchors, size, legible(color)))
        title = f"{self.model.name}" + (f", t = {self.now.t:.4g} s" if self.now.moving else "")
        attributes = {
            "class": "freebody-drawing",
            "data-scale": f"{self.scale:.12g}",
            "data-view": " ".join(f"{x:.12g}" for x in self.view.matrix.ravel()),
        }
        return Sheet(self.root, title, attributes)

    # -- extent and order -----------------------------------------------------------------------------

    def extent(self) -> list[Array]:
        points = []
        for name in self.model.bodies:
            R, p = self.now.posture(name)
            points += [p + R @ q for q in attachments(self.model, self.now.state, name).values()]
            points.append(self.now.place(name, self.model.bodies[name].center))
            for piece in self.pieces[name]:
                points += [p + R @ q for q in piece.points()]
        for joint in self.model.joints.values():
            if joint.parent == "ground" and joint.type not in ("free", "planar"):
                points.append(self.now.place("ground", joint.at))
        return points + round_walls(self)

    def _from_behind(self) -> list[str]:
        """Bodies in the order in which they hide each other: in space by depth, at one depth small ones in front.

        In space a body without mass or extent, a link of a joint of several, is not drawn.
        """

        def order(name: str) -> tuple[float, float]:
            place = self.model.bodies[name]
            depth = 0.0 if self.view.planar else float(self.view.toward @ self.now.place(name, place.center))
            points = np.array([q for piece in self.pieces[name] for q in piece.points()])
            return round(depth * self.scale, 3), -float(np.ptp(points, axis=0).max())

        carriers = {
            name
            for name in self.model.bodies
            if not self.view.planar
            and all(piece.kind == "particle" and not piece.solid for piece in self.pieces[name])
        }
        return sorted((name for name in self.model.bodies if name not in carriers), key=order)

    def _joints(self) -> dict[str, tuple[str, str, str, Array]]:
        """Type, parent, child and place of every joint, those that close loops included."""
        found = {
            name: (one.type, one.parent, one.child, self.now.place(one.child, one.to))
            for name, one in self.model.joints.items()
            if one.type != "free"
        }
        for name, one in self.model.constraints.items():
            if isinstance(one, Closure):
                found[name] = (
                    one.type,
                    one.parent.name,
                    one.child.name,
                    self.now.place(one.child.name, one.to),
                )
        return found

    def _slides(self, body: str) -> bool:
        return any(kind == "slider" and child == body for kind, _, child, _ in self.joints.values())

    # -- parts ----------------------------------------------------------------------------------------

    def _body(self, name: str) -> None:
        R, p = self.now.posture(name)
        fill = self.fill(name)
        group = Group([], {"class": "body", "data-body": name}, name)
        order = sorted(
            self.pieces[name], key=lambda one: (one.hole, float(self.view.toward @ (p + R @ one.center)))
        )
        for piece in order:
            for item in outlines(piece, R, p, self.view, self.scale, fill, self._slides(name)):
                group.add(item)
                area = polygon(item)
                if area is not None:
                    self.placer.area(area, 1.0 if piece.kind in ("slender_bar", "rod") else 0.3)
                else:
                    self.placer.line(item.points)
        self.root.add(group)

    def fill(self, name: str) -> str:
        return fill_of(self.model, name)

    def add(self, items: list[Any], **attributes: str) -> None:
        """A symbol, with the attributes by which it is found."""
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

    def _joint_symbols(self) -> None:
        for name, (kind, parent, child, point) in self.joints.items():
            at = self.page(point)
            attributes = {"class_": f"joint {kind}", "data_joint": name}
            if kind == "planar":  # nothing holds the body in the plane
                continue
            if kind in ("slider", "cylindrical"):
                if parent != "ground" or kind == "cylindrical" or not self.view.planar:
                    self._rail(name, at)
                continue
            d = self.axis(name) if kind == "hinge" and not self.view.planar else None
            if d is not None:
                self.add(self._shaft(name, at, d), **attributes)
            elif "ground" in (parent, child):
                make = symbols.pin_on_ground if kind == "hinge" else symbols.ball_on_ground
                items = make(at, self._outward(child if parent == "ground" else parent, at))
                self.add(items + (symbols.pin(at) if kind == "hinge" else []), **attributes)
            elif kind == "weld":
                square = at + np.array([(-3, -3), (3, -3), (3, 3), (-3, 3)])
                self.add([Line(square, Style(INK, 1.0, (), INK), True)], **attributes)
            else:
                self.add(symbols.pin(at), **attributes)

    def _shaft(self, name: str, at: Array, d: Array) -> list[Any]:
        """A hinge in space: its axis, and where that is fixed the bearings in which a shaft turns."""
        _, parent, child, _ = self.joints[name]
        on_ground = "ground" in (parent, child)
        # a bearing stands outside of all that lies about the point
        about = [one for one in self.drawn if on_ground and self._holds(one, at)]
        ends = [
            at + side * (max(self.along(one, at, side * d) for one in (child, *about)) + 13.0) * d
            for side in (1.0, -1.0)
        ]
        items: list[Any] = [Line(np.array(ends), Style(INK, 0.9, (9.0, 2.0, 1.5, 2.0)))]
        for end, side in zip(ends, (1.0, -1.0), strict=True):
            items += symbols.bearing(end - 6.0 * side * d, d, self.down) if on_ground else []
        return [*items, *symbols.pin(at)]

    def along(self, body: str, at: Array, d: Array) -> float:
        """How far from a point the line in a direction leaves a body [pt]."""
        way = np.arange(0.0, 2 * WIDE, 1.0)
        inner = np.zeros(len(way), dtype=bool)
        for area in self.areas_of(body):
            for beside in (-2.0, 2.0):  # an axis may be an edge
                inner |= inside(area, at + way[:, None] * d + beside * np.array([-d[1], d[0]]))
        return float(way[inner].max()) if inner.any() else 0.0

    def _outward(self, body: str, at: Array) -> Array:
        """Down, or where the body hangs down from its joint, up: a bracket does not stand in its body."""
        center = self.page(self.now.place(body, self.model.bodies[body].center))
        way = center - at
        length = float(np.linalg.norm(way))
        down = self.down
        return -down if length > 3.0 and float(way @ down) > 0.2 * length else down

    def _rail(self, name: str, at: Array) -> None:
        """The line along which something slides on another body, or in space."""
        d = self.axis(name)
        if d is None:
            return
        line = np.array([at - 26.0 * d, at + 26.0 * d])
        self.add([Line(line, Style(INK, 0.8, (8.0, 2.0, 1.5, 2.0)))], class_="joint slider", data_joint=name)

    def axis(self, name: str, index: int = 0) -> Array | None:
        """Direction of one of a joint's axes on paper, the first if not said."""
        joint = self.model.joints.get(name)
        if joint is None:
            return None
        d = self.view(self.axis_in_space(self.model.links[joint.links[index]], joint.links[index]))
        length = float(np.linalg.norm(d))
        return d / length if length > 0.05 else None

    def axis_in_space(self, link: Link, number: int) -> Array:
        """The axis of a primitive motion, in ground axes."""
        R = np.array(link_postures(self.model, self.now.state)[number].rotation, dtype=float)
        return R @ np.array([float(self.now.state(x)) for x in link.axis])

    def reach(self, body: str, at: Array, d: Array) -> float:
        """How far a body reaches from a point in a direction [pt]."""
        return max((float(((area - at) @ d).max()) for area in self.areas_of(body)), default=0.0)

    # -- coordinates ----------------------------------------------------------------------------------

    def _holds(self, name: str, at: Array) -> bool:
        """Whether a point on paper lies in a body."""
        return any(inside(area, at[None]).any() for area in self.areas_of(name))

    def areas_of(self, name: str) -> list[Array]:
        R, p = self.now.posture(name)
        found = []
        for piece in self.pieces[name]:
            for item in outlines(piece, R, p, self.view, self.scale, "#ffffff", self._slides(name)):
                area = polygon(item)
                if area is not None:
                    found.append(area)
        return found

    # -- what stands around ---------------------------------------------------------------------------

    def _names(self) -> None:
        for name in self.model.bodies:
            if name in self.drawn:
                self.labels.append((name.replace("_", " "), [(self._seen(name), None)], 10.5, INK))
        points: list[tuple[Array, list[str]]] = []
        for name, (kind, _, _, point) in self.joints.items():
            if kind == "planar":
                continue
            at = self.page(point)
            here = next((names for q, names in points if float(np.linalg.norm(q - at)) < 1.0), None)
            if here is None:
                points.append((at, [name]))
            else:
                here.append(name)
        for at, names in points:
            shown = [latex_name(name) for name in names]
            if len(names) > CROWD:
                shown = [r",\,".join(shown)]
            self.labels += [(f"${tex}$", [(at, None)], 9.5, GREY) for tex in shown]

    def _seen(self, name: str) -> Array:
        """The centre of a body, or where others hide that the nearest place that is seen."""
        center = self.page(self.now.place(name, self.model.bodies[name].center))
        pieces = self.pieces[name]
        if all(piece.kind == "rod" for piece in pieces):
            R, p = self.now.posture(name)
            center = self.page(p + R @ pieces[0].center)
        above = self.drawn[self.drawn.index(name) + 1 :]
        if not any(self._holds(one, center) for one in above):
            return center
        over = [area for one in above for area in self.areas_of(one)]
        r = np.arange(0.0, WIDE, 6.0)[1:]
        turn = np.radians(np.arange(0.0, 360.0, 15.0))
        around = center + np.stack([np.outer(r, np.cos(turn)), np.outer(r, np.sin(turn))], axis=-1).reshape(
            -1, 2
        )
        own = np.any([inside(area, around) for area in self.areas_of(name)], axis=0)
        free = around[own & ~np.any([inside(area, around) for area in over], axis=0)]
        return free[0] if len(free) else center
