"""Tables of a model file; every error names the file, the line and the key."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NoReturn

from ...describe.system import System
from ...errors import FormatError, FreebodyError, nearest
from ...scalar.algebra import Scalar, Vector
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
    """Return the kind of a TOML value in words."""
    return _KINDS.get(type(value), f"a {type(value).__name__}")


class Document:
    """The name of a file and the lines of its keys."""

    def __init__(self, name: str, lines: dict[Path, int]) -> None:
        self.name = name
        self.lines = lines

    def line(self, path: Path) -> int:
        """Return the line of a key, or of the nearest table above it that has one."""
        while path and path not in self.lines:
            path = path[:-1]
        return self.lines.get(path, 1)

    def fail(self, path: Path, message: str) -> NoReturn:
        """Raise FormatError with the file, the line and the key."""
        key = ".".join(part if part.isidentifier() else f'"{part}"' for part in path)
        raise FormatError(f"{self.name}, line {self.line(path)}, {key or 'the file'}: {message}") from None


class Table:
    """One table, whose keys are taken by name; :meth:`done` refuses the keys that were never taken."""

    def __init__(self, document: Document, path: Path, data: Any, system: System) -> None:
        self.document = document
        self.path = path
        self.system = system
        self.requested: dict[str, None] = {}
        if not isinstance(data, dict):
            self.fail(f"Expected a table, got {kind(data)}: {data!r}.")
        self.data: dict[str, Any] = data

    def fail(self, message: str, *keys: str) -> NoReturn:
        """Raise FormatError for this table or one of its keys."""
        self.document.fail((*self.path, *keys), message)

    def has(self, key: str) -> bool:
        """Return True if the table has the key, and count it as taken."""
        self.requested[key] = None
        return key in self.data

    def raw(self, key: str) -> Any:
        """Return the value of a required key."""
        if not self.has(key):
            self.fail(f"Expected the key '{key}', but it is missing.")
        return self.data[key]

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text; the key is required if there is no default."""
        if default is not None and not self.has(key):
            return default
        value = self.raw(key)
        if not isinstance(value, str):
            self.fail(f"Expected text in quotes, got {kind(value)}: {value!r}.", key)
        return value

    def whole(self, key: str, default: int) -> int:
        """Return a whole number."""
        value = self.raw(key) if self.has(key) else default
        if not isinstance(value, int) or isinstance(value, bool):
            self.fail(f"Expected a whole number, got {kind(value)}: {value!r}.", key)
        return value

    def flag(self, key: str) -> bool:
        """Return the truth value of a required key."""
        value = self.raw(key)
        if not isinstance(value, bool):
            self.fail(f"Expected true or false, got {value!r}.", key)
        return value

    def expression(self, key: str, default: Scalar = None) -> Scalar:
        """Return a number, or an expression of the system's names."""
        if default is not None and not self.has(key):
            return default
        return self.read(self.raw(key), key)

    def law(self, key: str) -> Any:
        """Return a number or a text that may have names of its own, as a law of friction has `slip`."""
        return self._plain(self.raw(key), key)

    def read(self, value: Any, key: str) -> Scalar:
        """Return a number or a text of the file as an expression of the system's names."""
        plain = self._plain(value, key)
        return self.guard(lambda: self.system.expression(plain, f"'{key}'"), key)

    def _plain(self, value: Any, key: str) -> Any:
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            self.fail(f"Expected a number or an expression in quotes, got {kind(value)}: {value!r}.", key)
        return value

    def vector(self, key: str, default: Any = None) -> Any:
        """Return three numbers or expressions."""
        if default is not None and not self.has(key):
            return default
        return self.three(self.raw(key), key)

    def three(self, value: Any, key: str) -> Vector:
        """Return the three components of a list."""
        if not isinstance(value, list) or len(value) != 3:
            got = f"{len(value)}: {value!r}" if isinstance(value, list) else f"{kind(value)}: {value!r}"
            self.fail(f"Expected three components [x, y, z], got {got}.", key)
        x, y, z = (self.read(component, key) for component in value)
        return (x, y, z)

    def matrix(self, key: str) -> Any:
        """Return a matrix, three rows of three."""
        value = self.raw(key)
        if not isinstance(value, list) or len(value) != 3:
            self.fail(f"Expected three rows [[...], [...], [...]], got {value!r}.", key)
        return tuple(self.three(row, key) for row in value)

    def texts(self, key: str) -> list[str]:
        """Return a list of texts; an empty one if the key is missing."""
        value = self.raw(key) if self.has(key) else []
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            self.fail(f"Expected a list of texts, got {value!r}.", key)
        return value

    def table(self, key: str) -> Table:
        """Return the table of a key; an empty one if the key is missing."""
        return Table(self.document, (*self.path, key), self.raw(key) if self.has(key) else {}, self.system)

    def tables(self, key: str) -> Iterator[tuple[str, Table]]:
        """Yield the named tables below a key, ``[bodies.NAME]``."""
        below = self.table(key)
        for name, data in below.data.items():
            yield name, Table(self.document, (*below.path, name), data, self.system)

    def each(self, key: str) -> list[Table]:
        """Return the tables of a list, ``key = [{...}, {...}]``."""
        value = self.raw(key)
        if not isinstance(value, list):
            self.fail(f"Expected a list of tables [{{...}}, {{...}}], got {kind(value)}: {value!r}.", key)
        return [Table(self.document, (*self.path, key), data, self.system) for data in value]

    def done(self) -> None:
        """Raise FormatError if there are keys that were never taken."""
        for key in self.data:
            if key not in self.requested:
                self.fail(f"Unknown key '{key}'; {nearest(key, self.requested)}", key)

    def guard(self, action: Any, *keys: str) -> Any:
        """Return the result of a call on the system; add the line and the key to its error."""
        try:
            return action()
        except FormatError:
            raise
        except FreebodyError as error:
            self.fail(str(error), *keys)
