"""The drawing of a machine: bodies, joints, springs and loads with the symbols of the field, and its coordinates."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..describe.constraint import Gear, Rolling, Rope
from ..describe.load import Damper, Force, JointDamper, JointForce, JointSpring, Spring, Torque
from ..describe.system import System
from ..dynamics.constraints import _arm
from ..dynamics.kinematics import link_postures
from ..equations.display import latex
from ..equations.equations import Equations, equations
from ..equations.latex import latex_name
from ..model.closure import Closure
from ..model.model import Link, Model
from ..simulate.trajectory import Trajectory
from . import symbols
from .configuration import Configuration, configuration
from .drawing import Drawing
from .marks import Marks
from .measures import angle_of, dimensions_of
from .outlines import outlines, polygon
from .palette import GREEN, GREY, INK, PALE, VERMILLION
from .placing import Placer
from .shapes import attachments, fill_of, shapes
from .sheet import Arrow, Circle, Group, Line, Sheet, Style, arc, box_of
from .view import View, view_of

Array = NDArray[np.float64]

WIDE = 250.0
"""Length of the machine on paper [pt]."""

FORCE = 42.0
"""Length of the arrow of a load [pt]."""


def draw(
    system: System | Model | Equations,
    *,
    at: Any = None,
    trajectory: Trajectory | None = None,
    values: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
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
    e = system if isinstance(system, Equations) else equations(system)
    now = configuration(e.model, at, trajectory=trajectory, values=values, near=near)
    view = view_of(e.model, e, now.values, axonometric)
    maker = _Machine(e, now, view)
    return Drawing(maker.sheet(coordinates, dimensions, names))


class _Machine:
    """Draws one machine in one configuration."""

    def __init__(self, e: Equations, now: Configuration, view: View) -> None:
        self.e, self.now, self.view = e, now, view
        self.model = e.model
        self.pieces = shapes(self.model, now.values)
        self.placer = Placer()
        self.root = Group()
        self.labels: list[tuple[str, list[tuple[Array, Array | None]], float, str]] = []
        points = self._extent()
        seen = view(np.array(points))
        longest = float(np.ptp(seen, axis=0).max())
        self.scale = WIDE / longest if longest > 0 else 1.0
        self.down = np.array([0.0, -1.0])
        self.joints: dict[str, tuple[str, str, str, Array]] = self._joints()

    def page(self, point: Any) -> Array:
        """A point in ground axes on paper."""
        return self.scale * self.view(point)

    def sheet(self, coordinates: bool, dimensions: bool, names: bool) -> Sheet:
        """Everything, from the back to the front."""
        self._planes()
        self._surfaces()
        self._ropes()
        self._guides()
        for name in self._from_behind():
            self._body(name)
        self._gears()
        self._joint_symbols()
        self._springs()
        self._loads()
        if coordinates:
            self._coordinates()
        if dimensions and self.view.planar:
            self._dimensions()
        self._axes()
        self._gravity()
        if names:
            self._names()
        for tex, anchors, size, color in self.labels:
            self.root.add(self.placer.label(tex, anchors, size, color))
        title = f"{self.model.name}" + (f", t = {self.now.t:.4g} s" if self.now.moving else "")
        attributes = {
            "class": "freebody-drawing",
            "data-scale": f"{self.scale:.12g}",
            "data-view": " ".join(f"{x:.12g}" for x in self.view.matrix.ravel()),
        }
        return Sheet(self.root, title, attributes)

    # -- extent and order -----------------------------------------------------------------------------

    def _extent(self) -> list[Array]:
        points = []
        for name in self.model.bodies:
            R, p = self.now.posture(name)
            points += [p + R @ q for q in attachments(self.model, self.now.state, name).values()]
            points.append(self.now.place(name, self.model.bodies[name].center))
            for piece in self.pieces[name]:
                points += [p + R @ q for q in piece.points()]
        for joint in self.model.joints.values():
            if joint.parent == "ground" and joint.type != "free":
                points.append(self.now.place("ground", joint.at))
        return points

    def _from_behind(self) -> list[str]:
        """Bodies in the order in which they hide each other: in space by depth, in a plane small ones in front."""

        def depth(name: str) -> float:
            place = self.model.bodies[name]
            return float(self.view.toward @ self.now.place(name, place.center))

        names = list(self.model.bodies)
        return names if self.view.planar else sorted(names, key=depth)

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
        fill = self._fill(name)
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
        self.root.add(group)

    def _fill(self, name: str) -> str:
        return fill_of(self.model, name)

    def _add(self, items: list[Any], **attributes: str) -> None:
        """A symbol, with the attributes by which it is found."""
        named = {key.replace("_", "-").removesuffix("-"): value for key, value in attributes.items()}
        self.root.add(Group(items, named))
        for item in items:
            if isinstance(item, Circle):
                self.placer.line(arc(item.center, item.radius, 0.0, 2 * math.pi))
            else:
                self.placer.line(item.points)

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
            if "ground" in (parent, child):
                make = symbols.pin_on_ground if kind == "hinge" else symbols.ball_on_ground
                items = make(at, self._outward(child if parent == "ground" else parent, at))
                self._add(items + (symbols.pin(at) if kind == "hinge" else []), **attributes)
            elif kind == "weld":
                square = at + np.array([(-3, -3), (3, -3), (3, 3), (-3, 3)])
                self._add([Line(square, Style(INK, 1.0, (), INK), True)], **attributes)
            else:
                self._add(symbols.pin(at), **attributes)

    def _outward(self, body: str, at: Array) -> Array:
        """Down, or where the body hangs down from its joint, up: a bracket does not stand in its body."""
        center = self.page(self.now.place(body, self.model.bodies[body].center))
        way = center - at
        length = float(np.linalg.norm(way))
        down = self.down
        return -down if length > 3.0 and float(way @ down) > 0.2 * length else down

    def _rail(self, name: str, at: Array) -> None:
        """The line along which something slides on another body, or in space."""
        d = self._axis(name)
        if d is None:
            return
        line = np.array([at - 26.0 * d, at + 26.0 * d])
        self._add([Line(line, Style(INK, 0.8, (8.0, 2.0, 1.5, 2.0)))], class_="joint slider", data_joint=name)

    def _axis(self, name: str) -> Array | None:
        """Direction of a joint's first axis on paper."""
        joint = self.model.joints.get(name)
        if joint is None:
            return None
        d = self.view(self._axis_in_space(self.model.links[joint.links[0]], joint.links[0]))
        length = float(np.linalg.norm(d))
        return d / length if length > 0.05 else None

    def _axis_in_space(self, link: Link, number: int) -> Array:
        """The axis of a primitive motion, in ground axes."""
        R = np.array(link_postures(self.model, self.now.state)[number].rotation, dtype=float)
        return R @ np.array([float(self.now.state(x)) for x in link.axis])

    def _guides(self) -> None:
        """Ground beside what slides on it, in a plane."""
        if not self.view.planar:
            return
        for name, (kind, parent, child, point) in self.joints.items():
            if kind != "slider" or parent != "ground":
                continue
            d = self._axis(name)
            if d is None:
                continue
            if d[0] < -0.01:
                d = -d
            at = self.page(point)
            base = (
                self.page(self.now.place("ground", self.model.joints[name].at))
                if name in self.model.joints
                else at
            )
            s = sorted((0.0, float((base - at) @ d)))
            gap = self._reach(child, at, np.array([d[1], -d[0]]))
            # not all the way to a far origin
            reach = (max(s[0] - 34.0, -110.0), min(s[1] + 34.0, 110.0))
            items = symbols.guide(at, d, reach, gap, 1.0)
            self._add(items, class_="joint slider", data_joint=name)

    def _reach(self, body: str, at: Array, d: Array) -> float:
        """How far a body reaches from a point in a direction [pt]."""
        return max((float(((area - at) @ d).max()) for area in self._areas_of(body)), default=0.0)

    def _planes(self) -> None:
        """The ground on which wheels roll."""
        wheels = [one for one in self.model.constraints.values() if isinstance(one, Rolling)]
        if not wheels:
            return
        feet = []
        for one in wheels:
            arm = np.array([float(x) for x in _arm(self.model, self.now.state, one)])
            feet.append(self.now.point(one.center) + arm)
        middle = np.mean(feet, axis=0)
        size = max(WIDE / self.scale * 0.42, float(np.ptp(np.array(feet), axis=0).max()) * 0.75)
        n = np.array([float(x) for x in wheels[0].normal[1]])
        first = np.array([float(x) for x in wheels[0].first[1]])
        second = np.array([float(x) for x in wheels[0].second[1]])
        if self.view.planar:
            normal_axis = np.eye(3)[self.view.normal or 0]
            along = first if abs(float(first @ normal_axis)) < 0.5 else second
            start, end = self.page(middle - size * along), self.page(middle + size * along)
            up = self.view(n)
            self._edge(start, end, up)
            return
        corners = [
            self.page(middle + size * (a * first + b * second * 0.7))
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        self._add([Line(np.array(corners), Style(GREY, 0.8, (), "#f4f4f4"), True)], class_="plane")
        for foot in feet:
            self._add([Circle(self.page(foot), 2.0, Style(INK, 0.8, (), INK))], class_="contact")

    def _surfaces(self) -> None:
        """What is fixed in the ground and may be touched: planes, sides, and round walls."""
        drawn: list[Any] = []
        for contact in getattr(self.model, "contacts", ()):
            for shape in (contact.feature, contact.surface):
                if not shape.body.is_ground or any(shape == other for other in drawn):
                    continue
                drawn.append(shape)
                kind = getattr(shape, "kind", "")
                if kind == "plane":
                    self._ground(self._fixed(shape.at), self._fixed(shape.normal))
                elif kind == "segment" and self.view.planar:
                    start, end = (self.page(self._fixed(point)) for point in (shape.start, shape.end))
                    self._edge(start, end, self.view(self._fixed(shape.normal)))
                elif kind in ("circle", "cylinder", "sphere") and self.view.planar:
                    self._wall_round(shape)

    def _fixed(self, components: Any) -> Array:
        """Three expressions of parameters, in numbers."""
        return np.array([float(self.now.state(x)) for x in components])

    def _edge(self, start: Array, end: Array, up: Array) -> None:
        """The edge of the ground, hatched on the side that ``up`` points away from."""
        way = end - start
        side = 1.0 if float(np.array([way[1], -way[0]]) @ up) < 0 else -1.0
        self._add(symbols.hatched(start, end, side), class_="plane")

    def _ground(self, point: Array, normal: Array) -> None:
        """A plane, under the whole machine."""
        seen = [self.page(p) for p in self._extent()]
        if self.view.planar:
            up = self.view(normal)
            along = np.array([-up[1], up[0]]) / np.linalg.norm(up)
            foot = self.page(point)
            reach = [float((q - foot) @ along) for q in seen]
            start, end = (foot + s * along for s in (min(reach) - 20.0, max(reach) + 20.0))
            self._edge(start, end, up)
            return
        middle = np.mean(np.array(self._extent()), axis=0)
        middle = middle - float((middle - point) @ normal) * normal
        first = np.eye(3)[int(np.argmin(np.abs(normal)))]
        first = first - float(first @ normal) * normal
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        size = 0.6 * WIDE / self.scale
        square = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        corners = np.array([self.page(middle + size * (a * first + b * second)) for a, b in square])
        self._add([Line(corners, Style(GREY, 0.8, (), "#f4f4f4"), True)], class_="plane")

    def _wall_round(self, shape: Any) -> None:
        """A round wall, hatched where the ground is."""
        center = self.page(self._fixed(shape.at))
        r = self.scale * float(self.now.state(shape.radius))
        items: list[Any] = [Line(arc(center, r, 0.0, 2 * math.pi), Style(INK, 1.3))]
        sign = 1.0 if shape.inside else -1.0
        for k in range(max(12, round(r * 2 * math.pi / 9.0))):
            t = 2 * math.pi * k / max(12, round(r * 2 * math.pi / 9.0))
            d = np.array([math.cos(t), math.sin(t)])
            foot = center + r * d
            items.append(
                Line(np.array([foot, foot + 5.0 * (sign * d + np.array([-d[1], d[0]]))]), symbols.FINE)
            )
        self._add(items, class_="plane")

    def _ropes(self) -> None:
        for name, one in self.model.constraints.items():
            if not isinstance(one, Rope):
                continue
            pages = [self.page(self.now.point(point)) for point in one.points]
            visits: dict[tuple[float, float], list[int]] = {}
            for k, q in enumerate(pages):
                visits.setdefault((round(float(q[0]), 3), round(float(q[1]), 3)), []).append(k)
            strands = max((len(v) for v in visits.values()), default=1)
            items: list[Any] = []
            total = len(pages) - 1
            for k, (a, b) in enumerate(zip(pages, pages[1:], strict=False)):
                # parts that run side by side are drawn side by side
                twins = [
                    j
                    for j, (c, d) in enumerate(zip(pages, pages[1:], strict=False))
                    if (np.allclose(a, c) and np.allclose(b, d)) or (np.allclose(a, d) and np.allclose(b, c))
                ]
                way = b - a if (b - a)[1] > 0 or ((b - a)[1] == 0 and (b - a)[0] > 0) else a - b
                length = float(np.linalg.norm(way))
                n = np.array([way[1], -way[0]]) / length if length > 0 else np.zeros(2)
                offset = 7.0 * (twins.index(k) - (len(twins) - 1) / 2)
                items.append(Line(np.array([a, b]) + offset * n, Style(GREEN, 1.3)))
            self._add(items, class_="rope", data_constraint=name)
            wheels: list[Any] = []
            for k, (point, q) in enumerate(zip(one.points, pages, strict=True)):
                if point.body.is_ground and 0 < k < total + 1:
                    wheels += symbols.pulley(q, 4.0 + 3.5 * (strands > 2))
            high = [q for point, q in zip(one.points, pages, strict=True) if point.body.is_ground]
            if high and self.view.planar:
                x0, x1 = min(q[0] for q in high) - 22.0, max(q[0] for q in high) + 22.0
                y = max(q[1] for q in high) + 12.0
                wheels += symbols.hatched(np.array([x0, y]), np.array([x1, y]), -1.0)
                wheels += [Line(np.array([q, (q[0], y)]), symbols.FINE) for q in high]
            self._add(wheels, class_="pulleys", data_constraint=name)
            middle = (pages[-1] + pages[-2]) / 2
            self.labels.append((f"${latex_name(name)}$", [(middle, np.array([1.0, 0.0]))], 10.0, GREEN))

    def _gears(self) -> None:
        """Teeth that mesh, on wheels that have a round solid."""
        for name, one in self.model.constraints.items():
            if not isinstance(one, Gear) or not self.view.planar:
                continue
            wheels = []
            for joint in (one.first, one.second):
                child = joint.child.name
                R, p = self.now.posture(child)
                wheels += [
                    (self.page(p + R @ piece.center), self.scale * piece["radius"], self._fill(child))
                    for piece in self.pieces[child]
                    if "radius" in piece.dimensions and piece.kind in ("disk", "cylinder", "ring")
                ][:1]
            if len(wheels) != 2:
                continue
            smallest = min(radius for _, radius, _ in wheels)
            pitch = 2 * math.pi * smallest / max(8, round(2 * math.pi * smallest / 12.0))
            for k, (center, radius, fill) in enumerate(wheels):
                way = wheels[1 - k][0] - center
                count = max(8, round(2 * math.pi * radius / pitch))
                phase = math.atan2(way[1], way[0]) + (math.pi / count if k else 0.0)
                items = symbols.teeth(center, radius, count, phase, fill)
                self._add(items, class_="gear", data_constraint=name)

    def _springs(self) -> None:
        for name, load in self.model.loads.items():
            if isinstance(load, Spring | Damper):
                a, b = self.page(self.now.point(load.start)), self.page(self.now.point(load.end))
                make = symbols.zigzag if isinstance(load, Spring) else symbols.dashpot
                self._add(make(a, b), class_=type(load).__name__.lower(), data_load=name)
                value = load.stiffness if isinstance(load, Spring) else load.damping
                self._spring_label(value, (a + b) / 2, b - a)
                for point, q in ((load.start, a), (load.end, b)):
                    if point.body.is_ground:
                        self._wall(q, b - a if point is load.start else a - b)
            elif isinstance(load, JointSpring | JointDamper):
                self._joint_spring(name, load)

    def _spring_label(self, value: Any, at: Array, along: Array) -> None:
        length = float(np.linalg.norm(along))
        side = np.array([-along[1], along[0]]) / length if length > 0 else np.array([0.0, 1.0])
        if side[1] < 0:
            side = -side
        tex = f"${latex(self.e.state(value), self.e.ring)}$"
        self.labels.append((tex, [(at + 6.0 * side, side), (at - 6.0 * side, -side)], 11.0, INK))

    def _joint_spring(self, name: str, load: JointSpring | JointDamper) -> None:
        joint = self.joints[load.joint.name]
        at = self.page(joint[3])
        value = load.stiffness if isinstance(load, JointSpring) else load.damping
        kind = "spring" if isinstance(load, JointSpring) else "damper"
        d = self._axis(load.joint.name)
        link = self.model.links[self.model.joints[load.joint.name].links[load.index]]
        if link.kind != "slider" or d is None:
            self._add(symbols.spiral(at), class_=kind, data_load=name)
            self._spring_label(value, at, np.array([20.0, 0.0]))
            return
        base = self.page(self.now.place(joint[1], self.model.joints[load.joint.name].at))
        beside = sum(
            isinstance(other, JointSpring | JointDamper) and other.joint is load.joint and key != name
            for key, other in list(self.model.loads.items())[: list(self.model.loads).index(name)]
        )
        normal = np.array([-d[1], d[0]])
        shift = (6.0 if beside == 0 else -6.0) * normal if self._beside(load) else np.zeros(2)
        half = self._reach(joint[2], at, -d)
        wall = base - 78.0 * d
        start, end = wall + shift, at - half * d + shift
        make = symbols.zigzag if isinstance(load, JointSpring) else symbols.dashpot
        self._add(make(start, end), class_=kind, data_load=name)
        if not beside:
            self._wall(wall, d)
        self._spring_label(value, (start + end) / 2, end - start)

    def _beside(self, load: JointSpring | JointDamper) -> bool:
        return (
            sum(
                isinstance(other, JointSpring | JointDamper) and other.joint is load.joint
                for other in self.model.loads.values()
            )
            > 1
        )

    def _wall(self, at: Array, toward: Array) -> None:
        """A piece of hatched wall, its free side toward a direction."""
        d = toward / np.linalg.norm(toward)
        across = np.array([-d[1], d[0]])
        self._add(symbols.hatched(at - 14.0 * across, at + 14.0 * across, -1.0), class_="wall")

    def _loads(self) -> None:
        """Applied forces and couples, by name."""
        marks = Marks(self.e, self.now, self.view.planar)
        style = Style(VERMILLION, 1.8)
        for name, load in self.model.loads.items():
            if not isinstance(load, Force | Torque | JointForce):
                continue
            bodies = [load.point.body.name] if isinstance(load, Force) else []
            if isinstance(load, Torque):
                bodies = [load.body.name]
            elif isinstance(load, JointForce):
                bodies = [self.model.joints[load.joint.name].child]
            for body in bodies:
                if body == "ground":
                    continue
                free = self.e.free_body(body)
                for action in free.actions:
                    if action.name != name:
                        continue
                    for vector, couple in ((action.force, False), (action.moment, True)):
                        if any(not (isinstance(x, int) and x == 0) for x in vector):
                            for mark in marks._resolved(name, "load", couple, vector, action.at, free):
                                self._load(mark, style)

    def _load(self, mark: Any, style: Style) -> None:
        at = self.page(mark.point)
        if mark.couple and self.view.planar:
            turn = 1.0 if self.view.turn(mark.direction) > 0 else -1.0
            choices = [
                arc(at, r, math.radians(a), math.radians(a) + turn * math.radians(200))
                for r in (20.0, 27.0, 34.0)
                for a in range(0, 360, 30)
            ]
        else:
            seen = self.view(mark.direction)
            d = seen / max(float(np.linalg.norm(seen)), 1e-9)
            choices = [np.array([at, at + FORCE * d]), np.array([at - FORCE * d, at])]
        costs = [self.placer.crowding(points, at) + 0.01 * k for k, points in enumerate(choices)]
        points = choices[int(np.argmin(costs))]
        arrow = Arrow(points, style, "double" if mark.couple and not self.view.planar else "full")
        self._add([arrow], class_="load", data_load=mark.name)
        far = points[-1] if float(np.linalg.norm(points[-1] - at)) > 6.0 else points[0]
        if mark.couple and self.view.planar:
            far = points[len(points) // 2]
        out = far - at
        out = out / max(float(np.linalg.norm(out)), 1e-9)
        self.labels.append((f"${mark.label}$", [(far, out)], 11.0, VERMILLION))

    # -- coordinates ----------------------------------------------------------------------------------

    def _coordinates(self) -> None:
        for name, joint in self.model.joints.items():
            for number in joint.links:
                link = self.model.links[number]
                if link.kind == "slider":
                    self._slide(name, number, link)
                elif link.kind == "hinge" and not self.view.planar:
                    self._turned(name, number, link)
            kinds = [self.model.links[i].kind for i in joint.links]
            if "ball" in kinds or "free" in kinds:
                self._own_axes(joint.child)
            if self.view.planar and "hinge" in kinds:
                found = [
                    angle_of(self.e, self.now, self.view, self.scale, joint.child, relative)
                    for relative in (False, True)
                ]
                # the absolute angle, where it is what the coordinate measures
                best = min((one for one in found if one), key=lambda one: len(one[0][1]), default=[])
                self._measured(best)

    def _measured(self, found: list[Any]) -> None:
        for group, tex, anchor in found:
            self.root.add(group)
            for item in group.items:
                self.placer.line(item.points)
            self.labels.append((tex, [anchor], 10.5, GREY))

    def _slide(self, name: str, number: int, link: Link) -> None:
        """A displacement: an arrow from the joint's point on the parent, beside the path."""
        shown = latex(self.e.state(link.displacement), self.e.ring)
        if not self.e.ring.atoms_of(self.e.ring.coerce(self.e.state(link.displacement))):
            return
        value = float(self.now.state(link.displacement))
        axis = self._axis_in_space(link, number)
        end = np.array(link_postures(self.model, self.now.state)[number].position, dtype=float)
        start, end = self.page(end - value * axis), self.page(end)
        way = end - start
        length = float(np.linalg.norm(way))
        if length < 8.0:
            return
        d = way / length
        side = np.array([-d[1], d[0]])
        choices = []
        for k, (sign, gap) in enumerate((s, g) for g in (24.0, 34.0, 46.0) for s in (1.0, -1.0)):
            line = np.array([start, end]) + sign * gap * side
            choices.append((self.placer.crowding(line) + 0.004 * gap + 0.001 * k, k, sign * gap * side))
        shift = min(choices, key=lambda one: one[:2])[2]
        out = shift / np.linalg.norm(shift)
        items = [
            Line(np.array([start + 3 * out, start + shift + 4 * out]), Style(GREY, 0.7)),
            Line(np.array([end + 13 * out, end + shift + 4 * out]), Style(GREY, 0.7)),
            Arrow(np.array([start, end]) + shift, Style(GREY, 0.9)),
        ]
        self._add(items, class_="coordinate", data_joint=name)
        self.labels.append((f"${shown}$", [((start + end) / 2 + shift, out)], 10.5, GREY))

    def _turned(self, name: str, number: int, link: Link) -> None:
        """An angle in space: an arc about its axis, from where a direction was before the turn."""
        value = float(self.now.state(link.displacement))
        exact = self.e.state(link.displacement)
        if not self.e.ring.atoms_of(self.e.ring.coerce(exact)):
            return
        posture = link_postures(self.model, self.now.state)[number]
        R = np.array(posture.rotation, dtype=float)
        n = self._axis_in_space(link, number)
        chain = self.model.joints[name].links
        place = chain.index(number)
        beside = [chain[place + 1]] if place + 1 < len(chain) else []
        beside += [chain[place - 1]] if place > 0 else []
        own = [np.array([float(self.now.state(x)) for x in self.model.links[i].axis]) for i in beside]
        own += [np.eye(3)[k] for k in range(3)]
        local = np.array([float(self.now.state(x)) for x in link.axis])
        r = R @ next(d for d in own if abs(float(d @ local)) < 1e-9)
        before = _about(n, -value) @ r
        point = self.joints[name][3]
        radius = (40.0 + 13.0 * place) / self.scale
        count = max(8, int(abs(math.degrees(value)) / 4))
        curve = np.array(
            [self.page(point + radius * (_about(n, a) @ before)) for a in np.linspace(0, value, count)]
        )
        at = self.page(point)
        fine = Style(GREY, 0.7, (4.0, 2.5))
        items: list[Any] = [
            Line(np.array([at, self.page(point + 1.35 * radius * before)]), fine),
            Line(np.array([at, self.page(point + 1.35 * radius * r)]), Style(GREY, 0.7)),
            Line(np.array([at, self.page(point + 1.5 * radius * n)]), Style(PALE, 0.9, (8.0, 2.0, 1.5, 2.0))),
        ]
        if float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum()) > 10.0:
            items.append(Arrow(curve, Style(GREY, 0.9)))
        self._add(items, class_="coordinate", data_joint=name)
        middle = curve[len(curve) // 2]
        out = middle - at
        out = out / max(float(np.linalg.norm(out)), 1e-9)
        self.labels.append((f"${latex(exact, self.e.ring)}$", [(middle, out)], 10.5, GREY))

    def _own_axes(self, body: str) -> None:
        """The axes of a body that turns freely, as 1, 2, 3."""
        R, p = self.now.posture(body)
        at = self.page(p)
        items = []
        for k in range(3):
            d = 34.0 * (self.view.matrix @ R[:, k])
            length = float(np.linalg.norm(d))
            if length > 6.0:
                items.append(Arrow(np.array([at, at + d]), Style(GREY, 1.0)))
                self.labels.append((f"${k + 1}$", [(at + d, d / length)], 10.0, GREY))
        self._add(items, class_="body-axes", data_body=body)

    def _dimensions(self) -> None:
        done: set[str] = set()
        for name in self.model.bodies:
            own = self.placer.about(self._areas_of(name))
            for group, tex, anchor in dimensions_of(
                self.e, self.now, self.view, self.scale, name, own, center=False
            ):
                if tex in done and len(self.model.bodies) > 3:
                    continue
                done.add(tex)
                self._measured([(group, tex, anchor)])

    def _areas_of(self, name: str) -> list[Array]:
        R, p = self.now.posture(name)
        found = []
        for piece in self.pieces[name]:
            for item in outlines(piece, R, p, self.view, self.scale, "#ffffff", self._slides(name)):
                area = polygon(item)
                if area is not None:
                    found.append(area)
        return found

    # -- what stands around ---------------------------------------------------------------------------

    def _axes(self) -> None:
        """The directions of the ground's axes, below to the left."""
        x0, y0, _, _ = box_of(self.root)
        clear = np.array([x0 + 14.0, y0 - 40.0])
        items = []
        for letter, k in self.view.axes:
            d = self.view.matrix[:, k]
            tip = clear + 26.0 * d
            items.append(Arrow(np.array([clear, tip]), Style(GREY, 0.9)))
            self.labels.append((f"${letter}$", [(tip, d / np.linalg.norm(d))], 10.0, GREY))
        self._add(items, class_="axes")

    def _gravity(self) -> None:
        g = self.view.gravity
        if g is None or not g.any():
            return
        d = self.view(g)
        length = float(np.linalg.norm(d))
        if length == 0:
            return
        x0, y0, x1, y1 = box_of(self.root)
        start = np.array([x1 + 16.0, y1 - 4.0])
        arrow = Arrow(np.array([start, start + 30.0 * d / length]), Style(INK, 1.2))
        self._add([arrow], class_="gravity")
        live = [c for c in self.model.gravity if not (isinstance(c, int) and c == 0)]
        tex = latex(self.e.state(live[0]), self.e.ring).removeprefix("-") if len(live) == 1 else r"\mathbf{g}"
        self.labels.append((f"${tex}$", [(start + 15.0 * d / length, np.array([1.0, 0.0]))], 11.0, INK))

    def _names(self) -> None:
        for name in self.model.bodies:
            center = self.page(self.now.place(name, self.model.bodies[name].center))
            pieces = self.pieces[name]
            if all(piece.kind == "rod" for piece in pieces):
                R, p = self.now.posture(name)
                center = self.page(p + R @ pieces[0].center)
            self.labels.append((name.replace("_", " "), [(center, None)], 10.5, INK))
        for name, (kind, _, _, point) in self.joints.items():
            if kind == "planar":
                continue
            self.labels.append((f"${latex_name(name)}$", [(self.page(point), None)], 9.5, GREY))


def _about(n: Array, angle: float) -> Array:
    """The rotation by an angle about a unit vector."""
    K = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    return np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * (K @ K)
