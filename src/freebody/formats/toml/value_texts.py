"""Texts of values, points and tables in TOML model files."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from ...describe.contacts.normal_law import OWN_NAMES
from ...describe.description import names_of
from ...describe.frame import Point
from ...describe.system import System
from ...scalar.algebra import ZERO, Scalar
from ..text import expression_text, toml_number

_BARE = re.compile(r"[A-Za-z0-9_-]+\Z")


class ValueTexts:
    """Texts of the values of a system."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.texts = names_of(system).texts

    def value(self, value: Scalar) -> str:
        """Return a scalar as TOML: a number if that is exact, text otherwise."""
        number = toml_number(value)
        return repr(number) if number is not None else quoted(expression_text(value, self.texts))

    def law(self, value: Scalar) -> str:
        """Return a law of a contact, which may depend on `slip`, or on `depth` and `rate`."""
        number = toml_number(value)
        texts = {**self.texts, **OWN_NAMES}
        return repr(number) if number is not None else quoted(expression_text(value, texts))

    def row(self, values: Iterable[Scalar]) -> str:
        """Return a list of scalars."""
        return f"[{', '.join(map(self.value, values))}]"

    def argument(self, value: Any) -> str:
        """Return an argument of a solid: a scalar, a list of scalars or the name of an axis."""
        if isinstance(value, tuple):
            return self.row(value)
        return quoted(value) if isinstance(value, str) else self.value(value)

    def matrix(self, rows: Iterable[Iterable[Scalar]]) -> str:
        """Return a list of rows."""
        return f"[{', '.join(map(self.row, rows))}]"

    def point(self, point: Point) -> str:
        """Return a point as an inline table, or the name of the body for its origin."""
        if point.components == ZERO:
            return quoted(point.body.name)
        return f"{{ body = {quoted(point.body.name)}, point = {self.row(point.components)} }}"


def quoted(text: str) -> str:
    """Return a TOML basic string; JSON's escapes are a subset of TOML's."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def key(name: str) -> str:
    """Return a TOML key, bare if possible."""
    return name if _BARE.match(name) else quoted(name)


def block(path: tuple[str, ...] | None, keys: Mapping[str, str]) -> str:
    """Return one table."""
    lines = [] if path is None else [f"[{'.'.join(map(key, path))}]"]
    return "\n".join([*lines, *(f"{key(name)} = {value}" for name, value in keys.items())]) + "\n"
