"""Elements and attributes of links and joints in a URDF file.

Source: the XML specification of URDF (ROS wiki, urdf/XML), and what its reference reader (urdfdom) accepts.
"""

from __future__ import annotations

from ..reading import Reading
from ..xml_tree import Element

SEVERAL = ("floating", "planar", "spherical")
"""Types of joints with several coordinates."""
MOVING = ("revolute", "continuous", "prismatic", *SEVERAL)
"""Types of joints that move; the others are ``fixed``."""
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


def say_unknown(element: Element, what: str, reading: Reading) -> None:
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
