"""Elements and attributes of links and joints in a URDF file.

Source: the XML specification of URDF (ROS wiki, urdf/XML), and what its reference reader (urdfdom) accepts.
"""

from __future__ import annotations

from ..reading import Reading, listed, reasons
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
QUIET: dict[str, tuple[str, ...]] = {
    "link": ("type",), "visual": ("name",), "collision": ("name", "group", "verbose"),
    "joint": ("safety_controller", "calibration"),
}  # fmt: skip
"""Attributes and elements of these that say nothing of the motion. The others are read."""
LEFT_OUT = {
    "transmission": "transmissions say nothing of the motion but a reduction; give the inertia of a rotor yourself",
    "gazebo": "settings of another simulator",
    "sensor": "sensors",
    "ros2_control": "settings of a controller",
    "mujoco": "settings of another simulator",
    "loop_joint": "not a part of URDF: the loop is open; close it by a joint of s",
}
"""What is left out of a robot, and what that means."""


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


def table() -> str:
    """Return the table of what is read, as the page on robots shows it."""
    rows = [
        "| in | attributes read | elements read | says nothing of the motion | left out, and said |",
        "|---|---|---|---|---|",
        f"| `<robot>` | `name` | `link`, `joint`, `material` | | {reasons(LEFT_OUT)} |",
    ]
    for tag, (attributes, single, several) in WORDS.items():
        quiet = QUIET.get(tag, ())
        columns = [
            [word for word in words if word not in quiet] for words in (attributes, (*single, *several))
        ]
        rows.append(f"| `<{tag}>` | {listed(columns[0])} | {listed(columns[1])} | {listed(quiet)} | |")
    return "\n".join(rows)
