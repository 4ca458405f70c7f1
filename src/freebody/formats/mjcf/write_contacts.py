"""Writer of contacts in MJCF: shapes of bodies and planes of the ground as geoms that only named pairs let touch.

A box has its eight corners, a mesh those of a convex hull.
"""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element, SubElement

from ...errors import ModelError
from ...scalar.algebra import Vector
from ...space.pose import Pose
from ...space.rotation import Rotation
from ..builder import normal, whole
from ..contacts import hull_of
from ..machine import Machine, text_of
from .placing import pose_attributes

UNSEEN = {"mass": "0", "contype": "0", "conaffinity": "0"}
"""Attributes of a geom that has no mass, and that touches what a pair names only."""
GROUP = {"group": "3"}
"""Group of geoms that touch, which viewers do not show at first."""
FIXED = "0.005 0.0001 0.0001"
"""Coefficients of friction of a pair besides those of slip; they need a condim above 3."""


class Contacts:
    """Says contacts in the sections of a file."""

    def __init__(self, machine: Machine, sections: dict[str, Element], elements: dict[str, Element]) -> None:
        self.machine, self.sections, self.elements = machine, sections, elements
        self.planes: dict[Any, str] = {}
        self.waiting: list[tuple[str, Any, str, float]] = []  # name, shape, plane, friction

    def add(self, pair: Any) -> None:
        """Take a contact of a shape and a plane of the ground."""
        m, title = self.machine, f"contact '{pair.name}'"
        shape, plane = pair.feature, pair.surface
        if shape.kind == "plane":
            shape, plane = plane, shape
        if plane.kind != "plane" or not plane.body.is_ground:
            m.refuse(
                title,
                "bodies of such a file touch planes of the ground; keep it in Python or in a .toml file",
            )
            return
        if pair.restitution != 0:
            m.refuse(title, "its restitution; contacts of the format do not rebound, leave out restitution=")
        if pair.normal_force is not None:
            m.refuse(title, "its normal force; contacts of the format have solref instead, leave out normal=")
        if pair.static_friction != pair.friction:
            m.refuse(title, "its static friction; leave out static_friction=")
        if pair.friction_across is not None:
            m.refuse(title, "its second coefficient of friction; give one, and leave out along=")
        if pair.adhesion != 0:
            m.refuse(title, "its adhesion; leave out adhesion=")
        for about in ("rolling", "spinning"):
            if getattr(pair, about) != 0:
                m.refuse(title, f"its resistance to {about}; leave out {about}=")
        at, up = m.vector(plane.at, title), m.vector(plane.normal, title)
        if (at, up) not in self.planes:
            name = f"plane{len(self.planes) + 1}"
            self.planes[at, up] = name
            pose = Pose(Rotation.trusted(normal(up)), at)
            SubElement(
                self.sections["worldbody"],
                "geom",
                {"name": name, "type": "plane", "size": "0 0 1", **pose_attributes(pose), **UNSEEN},
            )
        self.waiting.append(
            (pair.name, shape, self.planes[at, up], self.machine.number(pair.friction, title))
        )

    def finish(self) -> None:
        """Add the geoms and pairs."""
        for name, shape, plane, friction in self.waiting:
            geom = self._geom(name, shape)
            if geom is not None:
                self._pair(name, shape, geom, plane, friction)

    def _pair(self, name: str, shape: Any, geom: dict[str, str], plane: str, friction: float) -> None:
        SubElement(self.elements[shape.body.name], "geom", {"name": name, **geom, **UNSEEN, **GROUP})
        laws = (
            {"condim": "1"}
            if friction == 0
            else {"condim": "3", "friction": f"{text_of(friction, friction)} {FIXED}"}
        )
        SubElement(self.sections["contact"], "pair", {"geom1": name, "geom2": plane, **laws})

    def _geom(self, name: str, shape: Any) -> dict[str, str] | None:
        """Return the type, size and pose of a shape; None if it is refused."""
        m, title = self.machine, f"contact '{name}'"
        frame = m.place(shape.body, Pose())
        match shape.kind:
            case "sphere" if not shape.inside:
                at = frame.point(m.vector(shape.at, title))
                return {"type": "sphere", "size": text_of(m.number(shape.radius, title)), "pos": text_of(*at)}
            case "capsule":
                ends = [frame.point(m.vector(end, title)) for end in shape.corners]
                return {
                    "type": "capsule",
                    "size": text_of(m.number(shape.radius, title)),
                    "fromto": text_of(*ends[1], *ends[0]),
                }
            case "drum" if not shape.inside:
                turn = Rotation.trusted(normal(m.vector(shape.axis, title)))
                return {
                    "type": "cylinder",
                    "size": text_of(m.number(shape.radius, title), m.number(shape.length, title) / 2),
                    **pose_attributes(frame @ Pose(turn, m.vector(shape.at, title))),
                }
            case "ellipsoid":
                pose = frame @ Pose(position=m.vector(shape.at, title))
                return {
                    "type": "ellipsoid",
                    "size": text_of(*m.vector(shape.half_axes, title)),
                    **pose_attributes(pose),
                }
            case "corners":
                return self._corners(
                    name, [m.vector(point.components, title) for point in shape.points], frame
                )
            case "box" | "hull":
                return self._corners(name, [m.vector(corner, title) for corner in shape.corners], frame)
        m.refuse(
            title, f"a {shape.kind} of body '{shape.body.name}' is no shape of the format; use spheres, capsules, "
            "drums, ellipsoids, boxes or corners of a solid",
        )  # fmt: skip
        return None

    def _corners(self, name: str, points: list[Vector], frame: Pose) -> dict[str, str] | None:
        """Return a box along the axes of the body, or a mesh."""
        ranges = [sorted({point[i] for point in points}) for i in range(3)]
        if len(set(points)) == 8 and all(len(one) == 2 for one in ranges):
            middle: Any = tuple(whole((a + b) / 2) for a, b in ranges)
            return {
                "type": "box",
                "size": text_of(*((b - a) / 2 for a, b in ranges)),
                **pose_attributes(frame @ Pose(position=middle)),
            }
        try:
            if len(hull_of(points)) < len(set(points)):
                raise ModelError("corners within their convex hull never touch; leave them out")
        except ModelError as error:
            self.machine.refuse(
                f"contact '{name}'", f"{str(error).rstrip('.')}; give the corners of a solid, or spheres"
            )
            return None
        vertices = text_of(*(x for point in points for x in frame.point(point)))
        SubElement(self.sections["asset"], "mesh", name=name, vertex=vertices)
        return {"type": "mesh", "mesh": name}
