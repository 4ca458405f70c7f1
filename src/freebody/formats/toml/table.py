"""A table of a model file, whose every refusal names the file, the line and the key."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NoReturn

from ...describe.system import System
from ...errors import FormatError, FreebodyError, nearest
from .positions import Path

_KINDS = {
    dict: "a table",
    list: "a list",
    str: "text",
    bool: "true or false",
    int: "a number",
    float: "a number",
}


def kind(value: Any) -> str:
    """What a TOML value is, in words."""
    return _KINDS.get(type(value), f"a {type(value).__name__}")


class Document:
    """The name of a file and the lines of its keys."""

    def __init__(self, name: str, lines: dict[Path, int]) -> None:
        self.name = name
        self.lines = lines

    def line(self, path: Path) -> int:
        """The line of a key, or of the nearest table above it that has one."""
        while path and path not in self.lines:
            path = path[:-1]
        return self.lines.get(path, 1)

    def fail(self, path: Path, message: str) -> NoReturn:
        key = ".".join(part if part.isidentifier() else f'"{part}"' for part in path)
        raise FormatError(f"{self.name}, line {self.line(path)}, {key or 'the file'}: {message}") from None


class Table:
    """Takes the keys of one table; what is left when all known keys were asked for is refused."""

    def __init__(self, document: Document, path: Path, data: Any, system: System) -> None:
        self.document = document
        self.path = path
        self.system = system
        self.asked: dict[str, None] = {}
        if not isinstance(data, dict):
            self.fail(f"Expected a table, got {kind(data)}: {data!r}.")
        self.data: dict[str, Any] = data

    def fail(self, message: str, *keys: str) -> NoReturn:
        self.document.fail((*self.path, *keys), message)

    def has(self, key: str) -> bool:
        self.asked[key] = None
        return key in self.data

    def raw(self, key: str) -> Any:
        """The value of a required key."""
        if not self.has(key):
            self.fail(f"Expected the key '{key}', but it is missing.")
        return self.data[key]

    def text(self, key: str, default: str | None = None) -> str:
        if default is not None and not self.has(key):
            return default
        value = self.raw(key)
        if not isinstance(value, str):
            self.fail(f"Expected text in quotes, got {kind(value)}: {value!r}.", key)
        return value

    def whole(self, key: str, default: int) -> int:
        value = self.raw(key) if self.has(key) else default
        if not isinstance(value, int) or isinstance(value, bool):
            self.fail(f"Expected a whole number, got {kind(value)}: {value!r}.", key)
        return value

    def flag(self, key: str) -> bool:
        value = self.raw(key)
        if not isinstance(value, bool):
            self.fail(f"Expected true or false, got {value!r}.", key)
        return value

    def expression(self, key: str, default: Any = None) -> Any:
        """A number, or text read against the names of the system."""
        if default is not None and not self.has(key):
            return default
        return self.read(self.raw(key), key)

    def read(self, value: Any, key: str) -> Any:
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            self.fail(f"Expected a number or an expression in quotes, got {kind(value)}: {value!r}.", key)
        return self.guard(lambda: self.system.expression(value, f"'{key}'"), key)

    def vector(self, key: str, default: Any = None) -> Any:
        """Three numbers or expressions."""
        if default is not None and not self.has(key):
            return default
        return self.three(self.raw(key), key)

    def three(self, value: Any, key: str) -> Any:
        if not isinstance(value, list) or len(value) != 3:
            got = f"{len(value)}: {value!r}" if isinstance(value, list) else f"{kind(value)}: {value!r}"
            self.fail(f"Expected three components [x, y, z], got {got}.", key)
        return tuple(self.read(component, key) for component in value)

    def matrix(self, key: str) -> Any:
        """Three rows of three."""
        value = self.raw(key)
        if not isinstance(value, list) or len(value) != 3:
            self.fail(f"Expected three rows [[...], [...], [...]], got {value!r}.", key)
        return tuple(self.three(row, key) for row in value)

    def texts(self, key: str) -> list[str]:
        value = self.raw(key) if self.has(key) else []
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            self.fail(f"Expected a list of texts, got {value!r}.", key)
        return value

    def table(self, key: str) -> Table:
        """The table of a key; an empty one if the key is missing."""
        return Table(self.document, (*self.path, key), self.raw(key) if self.has(key) else {}, self.system)

    def tables(self, key: str) -> Iterator[tuple[str, Table]]:
        """The named tables below a key, ``[bodies.NAME]``."""
        below = self.table(key)
        for name, data in below.data.items():
            yield name, Table(self.document, (*below.path, name), data, self.system)

    def done(self) -> None:
        """Refuse the keys nobody asked for."""
        for key in self.data:
            if key not in self.asked:
                self.fail(f"Unknown key '{key}'; {nearest(key, self.asked)}", key)

    def guard(self, action: Any, *keys: str) -> Any:
        """The result of a call on the system; its refusal gets the line and the key."""
        try:
            return action()
        except FormatError:
            raise
        except FreebodyError as error:
            self.fail(str(error), *keys)
