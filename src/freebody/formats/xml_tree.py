"""XML read with limits: a file defines no entity, opens no other file, and is neither deep nor large."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from ..errors import FormatError

DEEPEST = 200
"""Greatest depth of nested elements."""
MOST = 500_000
"""Greatest number of elements and attributes of a file."""
GREATEST = 10**60
"""Greatest number of a file: its fifth power, as in the inertia of a solid of that size, is a number of floats."""

ROOTS = {
    "robot": "This is URDF: rename the file to end in .urdf",
    "mujoco": "This is MJCF: rename the file to end in .xml",
    "sdf": "This is SDF: convert it first, by sdformat's `gz sdf --print` and a converter such as sdformat_urdf",
    "mujocoinclude": "This is a part of an MJCF file: read the file that includes it",
}
"""Roots of files of robots, and what to do where another one is expected."""


def number(text: str) -> float:
    """Return the number that a text is; Python's underscores and digits of other scripts are none in these formats."""
    if "_" in text or not text.isascii():
        raise ValueError(text)
    return float(text)


@dataclass
class Element:
    """An element of a file, with the line that it begins on.

    >>> robot = tree('<robot name="arm"><link name="a"/></robot>', "arm.urdf")
    >>> robot.tag, robot.get("name"), [child.line for child in robot.all("link")]
    ('robot', 'arm', [1])
    """

    tag: str
    attributes: dict[str, str]
    line: int
    file: str
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def get(self, name: str, default: str | None = None) -> str:
        """Return an attribute; raise FormatError if it is missing and has no default."""
        value = self.attributes.get(name, default)
        if value is None:
            raise self.error(f"expected the attribute '{name}' of <{self.tag}>")
        return value

    def expect(self, tag: str, what: str) -> None:
        """Raise FormatError, with the cure, unless this is the root of a kind of file."""
        if self.tag != tag:
            cure = ROOTS.get(self.tag, "A model file of freebody ends in .toml")
            raise self.error(f"expected <{tag}> as the root of {what}, got <{self.tag}>. {cure}")

    def all(self, tag: str) -> Iterator[Element]:
        """Iterate over the children of a tag."""
        return (child for child in self.children if child.tag == tag)

    def first(self, tag: str) -> Element | None:
        """Return the first child of a tag, or None."""
        return next(self.all(tag), None)

    def numbers(self, name: str, count: int, default: tuple[float, ...] | None = None) -> tuple[float, ...]:
        """Return an attribute of ``count`` finite numbers, separated by spaces (or commas, which some tools write)."""
        if default is not None and name not in self.attributes:
            return default
        text = self.get(name)
        words = text.replace(",", " ").split()
        try:
            values = tuple(map(number, words))
        except ValueError:
            values = ()
        if len(values) != count or not all(map(math.isfinite, values)):
            what = "a number" if count == 1 else f"{count} numbers"
            raise self.error(f'expected {what} for {name}= of <{self.tag}>, got "{text[:60]}"')
        if any(abs(x) > GREATEST for x in values):
            raise self.error(
                f'expected numbers of at most 1e60 for {name}= of <{self.tag}>, got "{text[:60]}"'
            )
        return values

    def bound(self, name: str) -> float:
        """Return an attribute that is a limit: infinite from 1e60 on, as files write a limit that is none."""
        try:
            value = number(self.get(name))
        except ValueError:
            value = math.nan
        return self.number(name) if not abs(value) >= float(GREATEST) else math.copysign(math.inf, value)

    def number(self, name: str, default: float | None = None) -> float:
        """Return an attribute that is a number."""
        return self.numbers(name, 1, None if default is None else (default,))[0]

    def whole(self, name: str, default: int) -> int:
        """Return an attribute that is a whole number."""
        value = self.number(name, default)
        if value != int(value):
            raise self.error(f"expected a whole number for {name}= of <{self.tag}>, got {value:g}")
        return int(value)

    def positive(self, name: str, what: str = "") -> float:
        """Return an attribute that is a number and not negative, by default 0."""
        value = self.number(name, 0.0)
        if value < 0:
            raise self.error(
                f"expected {name}= of {what or f'<{self.tag}>'} that is not negative, got {value:g}"
            )
        return value

    def pair(self, name: str) -> tuple[float, float] | None:
        """Return an attribute that is two numbers, the smaller one first; without it, or for two zeros, None."""
        if name not in self.attributes:
            return None
        low, high = self.numbers(name, 2)
        if low > high:
            raise self.error(
                f"expected the smaller one first of {name}= of <{self.tag}>, got {low:g} {high:g}"
            )
        return (low, high) if low or high else None

    def several(self, name: str) -> tuple[float, ...]:
        """Return an attribute of any number of numbers; without it, none."""
        return self.numbers(name, len(self.attributes.get(name, "").replace(",", " ").split()), ())

    def choice(self, name: str, values: tuple[str, ...], default: str | None = None) -> str:
        """Return an attribute that is one of some words."""
        value = self.get(name, default)
        if value not in values:
            listed = ", ".join(f"'{one}'" for one in values)
            raise self.error(f"expected one of {listed} for {name}= of <{self.tag}>, got '{value[:60]}'")
        return value

    def error(self, message: str) -> FormatError:
        """Return the error of this element."""
        return FormatError(f"{self.file}, line {self.line}: {message.rstrip('.')}.")


def tree(text: str | bytes, file: str) -> Element:
    """Return the root of a file.

    Raises
    ------
    FormatError
        Text that is not XML, a document type or an entity, too deep or too large a tree; with the line.
    """
    parser = expat.ParserCreate()
    open_elements: list[Element] = []
    roots: list[Element] = []
    count = 0

    def refuse(message: str) -> FormatError:
        return FormatError(f"{file}, line {parser.CurrentLineNumber}: {message}.")

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1 + len(attributes)
        if len(open_elements) >= DEEPEST:
            raise refuse(f"expected elements nested at most {DEEPEST} deep, got more")
        if count > MOST:
            raise refuse(f"expected at most {MOST} elements and attributes, got more")
        element = Element(tag, attributes, parser.CurrentLineNumber, file)
        (open_elements[-1].children if open_elements else roots).append(element)
        open_elements.append(element)

    def end(tag: str) -> None:
        del tag
        open_elements.pop()

    def characters(text: str) -> None:
        if not text.isspace():
            open_elements[-1].text += text

    def document_type(*declaration: object) -> None:
        del declaration
        raise refuse("expected no document type: entities are not read. Delete the <!DOCTYPE ...>")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = characters
    parser.StartDoctypeDeclHandler = document_type
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        reason = expat.errors.messages[error.code]
        raise FormatError(
            f"{file}, line {error.lineno}: expected XML, got text with an error: {reason}."
        ) from None
    return roots[0]


def identifier(name: str, taken: set[str]) -> str:
    """Return a name of a system for a file's name, different from all ``taken``, to which it is added.

    >>> taken = {"t"}
    >>> [identifier(name, taken) for name in ("left-arm/1", "left_arm_1", "t", "7")]
    ['left_arm_1', 'left_arm_1_2', 't_2', '_7']
    """
    import keyword

    plain = re.sub(r"[^A-Za-z0-9_]", "_", name) or "_"
    if plain[0].isdigit():
        plain = "_" + plain
    if keyword.iskeyword(plain):
        plain += "_"
    result, number = plain, 2
    while result in taken:
        result, number = f"{plain}_{number}", number + 1
    taken.add(result)
    return result
