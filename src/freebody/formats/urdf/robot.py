"""A robot as its file says it: links and joints, checked one by one and as a tree.

Source: the XML specification of URDF (ROS wiki, urdf/XML), and what its reference reader (urdfdom) accepts.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any

import numpy as np

from ...errors import FormatError, nearest
from ...scalar.algebra import ZERO, Vector
from ...space.mass import MassProperties
from ...space.pose import Pose
from ...space.rotation import Rotation
from ...space.shape import Shape, compound
from ..builder import NOTHING_MASSIVE, placed, whole
from ..meshes import Meshes
from ..reading import Reading
from ..xml_tree import Element

DECIMALS = 10
"""Decimals with which a multiple of a right angle must be written to be taken as one."""
RIGHT = math.pi / 2
SEVERAL = ("floating", "planar", "spherical")
"""Types of joints with several coordinates."""
ENDS, DRIVE = ("lower", "upper"), ("effort", "velocity")
"""Attributes of <limit>."""
WORDS: dict[str, tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]] = {
    "link": (("name", "type"), ("inertial",), ("visual", "collision")),
    "inertial": ((), ("origin", "mass", "inertia"), ()),
    "origin": (("xyz", "rpy"), (), ()),
    "mass": (("value",), (), ()),
    "inertia": (("ixx", "ixy", "ixz", "iyy", "iyz", "izz", "iyx", "izx", "izy"), (), ()),
    "visual": (("name",), ("origin", "geometry", "material"), ()),
    "collision": (("name", "group"), ("origin", "geometry", "material"), ("verbose",)),
    "geometry": ((), ("box", "cylinder", "sphere", "capsule", "mesh"), ()),
    "joint": (
        ("name", "type"),
        ("origin", "parent", "child", "axis", "limit", "mimic", "dynamics", "joint_properties"),
        ("safety_controller", "calibration"),
    ),
    "axis": (("xyz",), (), ()),
    "parent": (("link",), (), ()),
    "child": (("link",), (), ()),
    "limit": (("lower", "upper", "effort", "velocity"), (), ()),
    "mimic": (("joint", "multiplier", "offset"), (), ()),
    "dynamics": (("damping", "friction", "spring_stiffness", "spring_reference"), (), ()),
}
"""Attributes of an element, elements in it of which there is one, and elements of which there may be several."""
MOVING = ("revolute", "continuous", "prismatic", *SEVERAL)
"""Types of joints that move; the others are ``fixed``."""


@dataclass(frozen=True)
class Link:
    """Mass properties in the link's axes, with the solids that are shown, and the colour of these."""

    name: str
    element: Element
    properties: MassProperties
    color: str = ""
    collisions: tuple[Element, ...] = ()


@dataclass(frozen=True)
class Joint:
    """A joint; ``mimic`` is (joint, multiplier, offset) of a joint that follows another."""

    name: str
    kind: str
    element: Element
    parent: str
    child: str
    pose: Pose
    axis: Vector = (1, 0, 0)
    damping: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    mimic: tuple[str, float, float] | None = None
    friction: float = 0.0
    limits: tuple[float, float] | None = None

    @property
    def what(self) -> str:
        """Kind and name, as the report writes them."""
        return f"joint '{self.name}'"


@dataclass
class Robot:
    """Links and joints by name, and the name of the link that no joint holds."""

    name: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    root: str
    below: dict[str, list[Joint]] = field(default_factory=dict)  # joints by parent


def robot(root: Element, reading: Reading, meshes: Meshes | None = None) -> Robot:
    """Return the robot of a file; ``reading`` notes what is changed or left out.

    Raises
    ------
    FormatError
        The message names the line, and says what was expected and what came.
    """
    root.expect("robot", "a URDF file")
    if _has_macros(root):
        raise root.error(
            "expected URDF, got xacro macros. Expand them first: `xacro IN.urdf.xacro > OUT.urdf` (ROS), or "
            "`xacrodoc IN -o OUT.urdf` (from PyPI)"
        )
    links: dict[str, Link] = {}
    joints: dict[str, Joint] = {}
    materials = {child.get("name", ""): child for child in root.all("material")}
    for child in root.children:
        if child.tag == "link":
            _once(child, links)
            links[child.get("name")] = link(child, materials, reading, meshes)
        elif child.tag == "joint":
            _once(child, joints)
            joints[child.get("name")] = joint(child, reading)
        elif child.tag != "material":
            reading.left_out(f"<{child.tag}>", child.line, LEFT_OUT.get(child.tag, "not a part of URDF"))
    reading.counts.update(link=len(links), joint=len(joints))
    if reading.right_angles:
        reading.changed(
            "<robot>", root.line, "multiples of π/2 that are rounded to their decimals are these multiples",
            f"{reading.right_angles} angles",
        )  # fmt: skip
    return _tree(root, links, joints, reading)


LEFT_OUT = {
    "transmission": "transmissions say nothing of the motion but a reduction; give the inertia of a rotor yourself",
    "gazebo": "settings of another simulator",
    "sensor": "sensors",
    "ros2_control": "settings of a controller",
    "mujoco": "settings of another simulator",
    "loop_joint": "not a part of URDF: the loop is open; close it by a joint of s",
}
"""What is left out of a robot, and what that means."""


def _has_macros(root: Element) -> bool:
    waiting = [root]
    while waiting:
        element = waiting.pop()
        if element.tag.startswith("xacro:") or any("${" in value for value in element.attributes.values()):
            return True
        waiting += element.children
    return False


def _once(element: Element, known: dict[str, Any]) -> None:
    name = element.get("name")
    if not name:
        raise element.error(f"expected a name of <{element.tag}>, got none")
    if name in known:
        before = known[name].element.line
        raise element.error(
            f"expected each {element.tag} once, got '{name}' again (the first is on line {before})"
        )


# -- links ----------------------------------------------------------------------------------------------


def link(element: Element, materials: dict[str, Element], reading: Reading, meshes: Meshes | None) -> Link:
    """Return a link."""
    name, what = element.get("name"), f"link '{element.get('name')}'"
    shown = [shape for part in element.all("visual") for shape in _solids(part, what, reading, meshes)]
    if not shown:
        shown = [shape for part in element.all("collision") for shape in _solids(part, what, reading, meshes)]
    collisions = tuple(element.all("collision"))
    colour = next((c for part in element.all("visual") if (c := _color(part, materials))), "")
    _say_unknown(element, what, reading)
    inertial = element.first("inertial")
    properties = NOTHING_MASSIVE if inertial is None else _massive(inertial, what, reading)
    return Link(name, element, replace(properties, shape=reduce(compound, shown, None)), colour, collisions)


def _say_unknown(element: Element, what: str, reading: Reading) -> None:
    """Report elements and attributes of a link or joint that are not read; refuse a second one where there is one."""
    waiting = [element]
    while waiting:
        one = waiting.pop(0)
        attributes, single, several = WORDS[one.tag]
        for name in one.attributes:
            if name not in attributes:
                reading.left_out(f"{what}, <{one.tag}>", one.line, f"{name}: not an attribute of URDF")
        seen: set[str] = set()
        for child in one.children:
            if child.tag in seen and child.tag in single:
                raise child.error(f"expected one <{child.tag}> in <{one.tag}> of {what}, got another")
            seen.add(child.tag)
            if child.tag in (*single, *several):
                waiting += [child] if child.tag in WORDS else []
            else:
                reading.left_out(
                    f"{what}, <{child.tag}>",
                    child.line,
                    "not a part of URDF that says something of the motion",
                )


def _massive(inertial: Element, what: str, reading: Reading) -> MassProperties:
    """Return the mass properties of a link, in its axes, whether a body can have them or not."""
    mass = inertial.first("mass")
    m = 0.0 if mass is None else mass.number("value")
    if m < 0:
        raise inertial.error(f"expected a mass of {what} that is not negative, got {m:g} kg")
    values = [0.0] * 6
    inertia = inertial.first("inertia")
    if inertia is not None:
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        turned = {"ixy": "iyx", "ixz": "izx", "iyz": "izy"}
        for i, name in enumerate(names):
            other = turned.get(name, name)
            values[i] = inertia.number(name if name in inertia.attributes else other, 0.0)
    if m == 0 and any(values):
        reading.changed(what, inertial.line, "an inertia without mass is kept as it is")
    xx, xy, xz, yy, yz, zz = values
    own = MassProperties.as_given(m, ZERO, ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)), possible=False)
    return placed(own, pose_of(inertial, reading))


def _solids(part: Element, what: str, reading: Reading, meshes: Meshes | None) -> list[Shape]:
    """Return the solid of a visual or collision element, in the link's axes."""
    geometry = part.first("geometry")
    if geometry is None or not geometry.children:
        return []
    solid = geometry.children[0]
    if solid.tag == "box":
        x, y, z = solid.numbers("size", 3)
        shape = Shape("box", (("x", x), ("y", y), ("z", z)))
    elif solid.tag == "cylinder":
        shape = Shape("cylinder", (("radius", solid.number("radius")), ("length", solid.number("length"))))
    elif solid.tag == "sphere":
        shape = Shape("sphere", (("radius", solid.number("radius")),))
    elif solid.tag == "mesh" and meshes is not None:
        name = solid.attributes.get("filename", "").rpartition("/")[2][:60]

        def unread(problem: str) -> None:
            rule = "a mesh that cannot be read is not drawn"
            reading.left_out(f"{what}, <{part.tag}>", solid.line, rule, f"{name}: {problem}")

        try:
            scale = np.array(solid.numbers("scale", 3, (1.0, 1.0, 1.0)))
            return [
                placed(
                    meshes.shape(solid.get("filename"), lambda points: points * scale, unread), pose_of(part)
                )
            ]
        except FormatError as error:
            unread(str(error))
            return []
    else:
        reading.left_out(f"{what}, <{part.tag}>", solid.line, f"a {solid.tag} is not drawn")
        return []
    if any(size <= 0 for _, size in shape.dimensions):
        reading.left_out(f"{what}, <{part.tag}>", solid.line, "a solid without size is not drawn")
        return []
    return [placed(shape, pose_of(part))]


def _color(part: Element, materials: dict[str, Element]) -> str:
    """Return the colour of a visual element as "#rrggbb", or nothing."""
    material = part.first("material")
    if material is not None and material.first("color") is None:
        material = materials.get(material.attributes.get("name", ""), material)
    color = None if material is None else material.first("color")
    if color is None:
        return ""
    r, g, b, _ = color.numbers("rgba", 4)
    return "#" + "".join(f"{round(255 * min(max(x, 0.0), 1.0)):02x}" for x in (r, g, b))


# -- joints ---------------------------------------------------------------------------------------------


def joint(element: Element, reading: Reading) -> Joint:
    """Return a joint."""
    name, kind = element.get("name"), element.get("type")
    what = f"joint '{name}'"
    if kind not in (*MOVING, "fixed"):
        raise element.error(f"expected a type of {what} among {', '.join((*MOVING, 'fixed'))}, got '{kind}'")
    ends = []
    for tag in ("parent", "child"):
        end = element.first(tag)
        if end is None:
            raise element.error(f"expected <{tag} link=...> in {what}")
        ends.append(end.get("link"))
    _say_unknown(element, what, reading)
    result = Joint(name, kind, element, ends[0], ends[1], pose_of(element, reading))
    if kind == "fixed":
        return result
    result = replace(result, axis=_axis(element, kind, what, reading), mimic=_mimic(element, what))
    result = replace(_with_forces(result, what, reading), limits=_limits(element, result, reading))
    for tag in ("safety_controller", "calibration"):
        one = element.first(tag)
        if one is not None:
            reading.left_out(what, one.line, f"<{tag}> is a setting of a controller")
    return result


def _limits(element: Element, joint: Joint, reading: Reading) -> tuple[float, float] | None:
    """Return the limits of a joint that has some; ``reading`` keeps them, and those of its drive."""
    limit = element.first("limit")
    if limit is None:
        return None
    ends = {key: limit.bound(key) for key in (*ENDS, *DRIVE) if key in limit.attributes}
    bounds = {key: end for key, end in ends.items() if math.isfinite(end)}
    if bounds:
        reading.limits[joint.name] = bounds
    drive = ", ".join(f"{key} {bounds[key]:g}" for key in DRIVE if key in bounds)
    if drive:
        reading.left_out(
            joint.what, limit.line, "nothing limits the drive: s.reading.limits has its limits", drive
        )
    if joint.kind not in ("revolute", "prismatic") or not any(key in bounds for key in ENDS):
        return None
    low, high = (
        sign * math.inf if key in ends and key not in bounds else ends.get(key, 0.0)
        for key, sign in zip(ENDS, (-1, 1), strict=True)
    )
    return (low, high)


def _axis(element: Element, kind: str, what: str, reading: Reading) -> Vector:
    """Return the axis of a joint."""
    axis = element.first("axis")
    if axis is None:
        if kind in ("revolute", "continuous", "prismatic", "planar"):
            reading.changed(what, element.line, "without <axis> it is (1, 0, 0), as the format has it")
        return (1, 0, 0)
    x, y, z = axis.numbers("xyz", 3)
    length = math.hypot(x, y, z)
    if length == 0:
        if kind in ("floating", "spherical"):
            return (1, 0, 0)
        raise axis.error(f"expected an axis of {what} that has a direction, got (0, 0, 0)")
    if length != 1:
        if abs(length - 1) > 1e-6:
            reading.changed(
                what, axis.line, "an axis of another length than 1 is a direction", f"{length:.6g}"
            )
        x, y, z = x / length, y / length, z / length
    return (whole(x), whole(y), whole(z))


def _mimic(element: Element, what: str) -> tuple[str, float, float] | None:
    mimic = element.first("mimic")
    if mimic is None:
        return None
    if element.get("type") in SEVERAL:
        raise mimic.error(f"expected <mimic> on a joint of one coordinate, got it on {what}")
    return (mimic.get("joint"), mimic.number("multiplier", 1.0), mimic.number("offset", 0.0))


def _with_forces(joint: Joint, what: str, reading: Reading) -> Joint:
    """Return the joint with its damper and spring."""
    dynamics = joint.element.first("dynamics") or joint.element.first("joint_properties")
    if dynamics is None:
        return joint
    values = {
        key: dynamics.number(key, 0.0)
        for key in ("damping", "friction", "spring_stiffness", "spring_reference")
    }
    for key in ("damping", "friction", "spring_stiffness"):
        if values[key] < 0:
            raise dynamics.error(f"expected a {key} of {what} that is not negative, got {values[key]:g}")
    if joint.kind in SEVERAL and (values["damping"] or values["spring_stiffness"] or values["friction"]):
        reading.left_out(
            what, dynamics.line, f"a {joint.kind} joint has no damping, no friction and no spring"
        )
        return joint
    return replace(
        joint,
        damping=values["damping"],
        stiffness=values["spring_stiffness"],
        rest=values["spring_reference"],
        friction=values["friction"],
    )


# -- poses ----------------------------------------------------------------------------------------------


def pose_of(element: Element, reading: Reading | None = None) -> Pose:
    """Return the pose of the element's <origin>; ``reading`` counts the angles that are taken as others."""
    origin = element.first("origin")
    if origin is None:
        return Pose()
    x, y, z = map(whole, origin.numbers("xyz", 3, (0.0, 0.0, 0.0)))
    words = origin.attributes.get("rpy", "0 0 0").replace(",", " ").split()
    angles = origin.numbers("rpy", 3, (0.0, 0.0, 0.0))
    turns = [_turn(word, angle) for word, angle in zip(words, angles, strict=True)]
    if reading is not None:
        reading.right_angles += sum(
            angle != 0 and exact for angle, (*_, exact) in zip(angles, turns, strict=True)
        )
    (cr, sr, _), (cp, sp, _), (cy, sy, _) = turns
    # R = Rz(yaw) Ry(pitch) Rx(roll)
    R = Rotation.trusted((
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    ))  # fmt: skip
    return Pose(R, (x, y, z))


def _turn(word: str, angle: float) -> tuple[Any, Any, bool]:
    """Return cosine and sine of an angle, and whether it is taken as a multiple of a right angle.

    It is if it is that multiple rounded to the decimals that are written, at least :data:`DECIMALS` of them.
    """
    decimals = re.fullmatch(r"[+-]?\d*\.(\d+)", word)
    count = round(angle / RIGHT)
    written = len(decimals[1]) if decimals else 0
    exact = angle == 0 or (written >= DECIMALS and abs(angle - count * RIGHT) <= 10.0**-written)
    if exact:
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[count % 4]
        return c, s, True
    return math.cos(angle), math.sin(angle), False


# -- the tree -------------------------------------------------------------------------------------------


def _tree(root: Element, links: dict[str, Link], joints: dict[str, Joint], reading: Reading) -> Robot:
    """Return the robot; raise FormatError unless its joints make a tree of all links."""
    if not links:
        raise root.error("expected at least one <link> in the robot, got none")
    held: dict[str, Joint] = {}
    below: dict[str, list[str]] = {name: [] for name in links}
    for one in joints.values():
        for end in (one.parent, one.child):
            if end not in links:
                raise one.element.error(f"unknown link '{end}' in joint '{one.name}'; {nearest(end, links)}")
        if one.child in held:
            raise one.element.error(
                f"link '{one.child}' is held by joint '{held[one.child].name}' and by '{one.name}'; URDF has no loops"
            )
        held[one.child] = one
        below[one.parent].append(one.name)
    roots = [name for name in links if name not in held]
    if len(roots) != 1:
        listed = ", ".join(f"'{name}'" for name in roots[:5]) + (", ..." if len(roots) > 5 else "")
        got = f"{len(roots)}: {listed}" if roots else "none, since the joints go round in a loop"
        raise root.error(f"expected one link that no joint holds, got {got}")
    for one in list(joints.values()):
        if one.mimic is not None and one.mimic[0] not in joints:
            reading.changed(
                f"joint '{one.name}'", one.element.line, "a joint that mimics an unknown joint moves by itself",
                f"'{one.mimic[0]}'; {nearest(one.mimic[0], joints)}",
            )  # fmt: skip
            joints[one.name] = replace(one, mimic=None)
    for one in joints.values():
        _check_mimic(one, joints)
    tree = {parent: [joints[name] for name in names] for parent, names in below.items()}
    return Robot(root.attributes.get("name", "robot"), links, joints, roots[0], tree)


def _check_mimic(joint: Joint, joints: dict[str, Joint]) -> None:
    """Raise FormatError if a joint follows itself, or a joint of several coordinates."""
    seen = [joint.name]
    while joint.mimic is not None:
        name = joint.mimic[0]
        if name in seen:
            raise joint.element.error(
                f"joint '{seen[0]}' mimics itself, by way of {', '.join(seen[1:]) or 'nothing'}"
            )
        seen.append(name)
        joint = joints[name]
        if joint.kind in SEVERAL:
            raise joint.element.error(
                f"expected a joint of one coordinate for '{seen[-2]}' to mimic, got '{name}'"
            )
