"""A robot as its file says it: links and joints, checked as a tree.

Source: the XML specification of URDF (ROS wiki, urdf/XML), and what its reference reader (urdfdom) accepts.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from ...errors import nearest
from ..meshes import Meshes
from ..reading import Reading
from ..xml_tree import Element
from .joint import Joint, joint
from .link import Link, link
from .words import LEFT_OUT, SEVERAL


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
