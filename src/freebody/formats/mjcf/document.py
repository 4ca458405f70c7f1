"""An MJCF file with the files that it includes, its settings and its default classes.

Source: MuJoCo's documentation, XML reference; the order of things is that of its reader.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from ...errors import FormatError, nearest
from ..meshes import Meshes
from ..reading import Reading
from ..xml_tree import DEEPEST, MOST, Element, tree

LARGEST = 40_000_000
"""Greatest size of an included file, in bytes."""


@dataclass(frozen=True)
class Compiler:
    """Settings of <compiler>, with the defaults of the format."""

    angle: str = "degree"
    eulerseq: str = "xyz"
    autolimits: bool = True
    inertiafromgeom: str = "auto"
    inertiagrouprange: tuple[float, ...] = (0, 5)
    boundmass: float = 0.0
    boundinertia: float = 0.0
    settotalmass: float = -1.0
    balanceinertia: bool = False
    strippath: bool = False
    meshdir: str = ""
    assetdir: str = ""
    coordinate: str = "local"

    def updated(self, element: Element) -> Compiler:
        """Return the settings with those of an element."""
        values: dict[str, Any] = {}
        for one in fields(self):
            if one.name not in element.attributes:
                continue
            default = one.default
            if isinstance(default, bool):
                values[one.name] = element.choice(one.name, ("false", "true")) == "true"
            elif isinstance(default, float):
                values[one.name] = element.number(one.name)
            elif isinstance(default, tuple):
                values[one.name] = element.numbers(one.name, 2)
            else:
                choices = CHOICES.get(one.name)
                values[one.name] = element.choice(one.name, choices) if choices else element.get(one.name)
        if "eulerseq" in values and (
            len(values["eulerseq"]) != 3 or not set(values["eulerseq"].lower()) <= set("xyz")
        ):
            raise element.error(
                f"expected three of x, y, z (or X, Y, Z) for eulerseq, got '{values['eulerseq']}'"
            )
        if values.get("coordinate") == "global":
            raise element.error(
                "expected local coordinates, got coordinate='global', which MuJoCo gave up in version 2.3. Load and "
                "save the file with version 2.2 first"
            )
        return replace(self, **values)


CHOICES = {
    "angle": ("radian", "degree"), "inertiafromgeom": ("false", "true", "auto"), "coordinate": ("local", "global"),
}  # fmt: skip
ACTUATORS = (
    "general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion",
)  # fmt: skip
ORIENTATIONS = ("quat", "axisangle", "euler", "xyaxes", "zaxis")
"""Attributes of which an element has one; its own replaces another one of its class."""
SAME_CLASS = {"freejoint": ""}
"""Tags whose defaults are those of another tag; nothing for those that have none."""


@dataclass
class Document:
    """The sections of a file, in its order."""

    root: Element
    meshes: Meshes
    compiler: Compiler = Compiler()
    classes: dict[str, dict[str, list[Element]]] = field(default_factory=dict)

    def sections(self, *tags: str) -> Iterator[Element]:
        """Iterate over the elements of all sections with one of these tags."""
        return (child for section in self.root.children if section.tag in tags for child in section.children)

    def settings(self, tag: str) -> Iterator[Element]:
        """Iterate over the sections of a tag themselves."""
        return self.root.all(tag)

    def full(self, element: Element, childclass: str = "main") -> Element:
        """Return an element with the attributes of its default class."""
        given = [one for one in self.given(element, childclass) if one is not element]
        if not given:
            return element
        attributes: dict[str, str] = {}
        for one in (*given, element):
            if any(name in one.attributes for name in ORIENTATIONS):
                for name in ORIENTATIONS:
                    attributes.pop(name, None)
            attributes.update(one.attributes)
        return replace(element, attributes=attributes)

    def given(self, element: Element, childclass: str = "main") -> list[Element]:
        """Return the elements that say an element's attributes, from the outermost default class to itself."""
        name = element.attributes.get("class", childclass)
        if name not in self.classes:
            if name == "main":
                return [element]
            raise element.error(f"unknown class '{name}' of <{element.tag}>; {nearest(name, self.classes)}")
        tag = "actuator" if element.tag in ACTUATORS else SAME_CLASS.get(element.tag, element.tag)
        return [*self.classes[name].get(tag, []), element]


def document(root: Element, file: Path, reading: Reading) -> Document:
    """Return a file with the files that it includes.

    Raises
    ------
    FormatError
        The message names the file and line, and says what was expected and what came.
    """
    root.expect("mujoco", "an MJCF file")
    meshes = Meshes(file, reading)
    result = Document(_Included(meshes, file).expanded(root, file.resolve().parent, 0), meshes)
    for one in result.settings("compiler"):
        result.compiler = result.compiler.updated(one)
    for one in result.settings("default"):
        _add_class(result, one, "main", {})
    folder = result.compiler.meshdir or result.compiler.assetdir
    meshes.subfolder = folder
    reading.counts.clear()
    return result


class _Included:
    """Replaces <include> by the content of its file."""

    def __init__(self, meshes: Meshes, file: Path) -> None:
        self.meshes, self.seen, self.count = meshes, {file.resolve()}, 0

    def expanded(self, element: Element, folder: Path, depth: int) -> Element:
        """Return the element with the content of the files that it includes."""
        self.count += 1
        if self.count > MOST:
            raise element.error(f"expected at most {MOST} elements with all included files, got more")
        if depth >= DEEPEST:
            raise element.error(f"expected elements nested at most {DEEPEST} deep, got more")
        children: list[Element] = []
        for child in element.children:
            if child.tag != "include":
                children.append(self.expanded(child, folder, depth + 1))
                continue
            path = self.file(child, folder)
            part = tree(path.read_bytes(), path.name)
            children += self.expanded(part, path.parent, depth + 1).children
        return replace(element, children=children)

    def file(self, include: Element, folder: Path) -> Path:
        """Return the file of an <include>: beside the file that names it, or beside the first one."""
        name = include.get("file")
        try:
            path = self.meshes.path(name, folder)
        except FormatError as error:
            raise include.error(f"cannot include '{name[:60]}': {str(error).rstrip('.')}") from None
        if path in self.seen:
            raise include.error(f"expected each file included once, got '{name}' again")
        if path.stat().st_size > LARGEST:
            raise include.error(f"expected at most {LARGEST} bytes in '{name}', got {path.stat().st_size}")
        self.seen.add(path)
        return path


def _add_class(result: Document, element: Element, name: str, above: dict[str, list[Element]]) -> None:
    """Add a default class and those in it, which begin with what it says."""
    own = result.classes.setdefault(name, {tag: list(elements) for tag, elements in above.items()})
    for child in element.children:
        if child.tag != "default":
            own.setdefault("actuator" if child.tag in ACTUATORS else child.tag, []).append(child)
    for child in element.all("default"):
        inner = child.attributes.get("class")
        if inner is None:
            raise child.error("expected the attribute 'class' of a <default> in another one")
        if inner in result.classes:
            raise child.error(f"expected each class once, got '{inner}' again")
        _add_class(result, child, inner, own)
