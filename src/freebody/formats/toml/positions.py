"""Line numbers of the keys of a TOML text, and limits of its nesting.

``tomllib`` gives values without line numbers. This scan knows only as much of the grammar as finding keys
requires: headers, keys, strings, comments and brackets. ``tomllib``, which reads the text afterwards, checks
that it is TOML; the limits are checked here, before recursive code reads the text.
"""

from __future__ import annotations

import re

from ...errors import FormatError

Path = tuple[str, ...]

MAX_DEPTH = 8  # of nested brackets, and of the names in one key

_SPACE = re.compile(r"[ \t]*")
_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_KEY_PART = re.compile(r"""[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*'""")
_STRING = re.compile(
    r'"""(?:[^\\]|\\.)*?"""|\'\'\'.*?\'\'\'|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'',
    re.DOTALL,
)
_PLAIN = re.compile(r"[^\[\]{}\"'#,\n]+")


def key_lines(text: str, name: str) -> dict[Path, int]:
    """Return the line of every key and table header.

    Parameters
    ----------
    text : str
    name : str
        Name of the file, for messages.

    Returns
    -------
    dict of tuple of str to int
        Path of the key from the root -> line, counted from 1. For an array of tables the last header counts.

    Raises
    ------
    FormatError
        Values or keys nested deeper than ``MAX_DEPTH``.

    Examples
    --------
    >>> key_lines("a = 1\\n[b.c]\\nd = [1,\\n  2]\\n", "example")
    {('a',): 1, ('b',): 2, ('b', 'c'): 2, ('b', 'c', 'd'): 3}
    """
    return _Scan(text, name).run()


class _Scan:
    """A position in the text that moves over keys and values."""

    def __init__(self, text: str, name: str) -> None:
        self.text = text
        self.name = name
        self.at = 0
        self.line = 1
        self.lines: dict[Path, int] = {}

    def run(self) -> dict[Path, int]:
        table: Path = ()
        while True:
            self.skip(_BLANK)
            if self.at >= len(self.text):
                return self.lines
            if self.text[self.at] == "[":
                while self.at < len(self.text) and self.text[self.at] == "[":
                    self.at += 1
                table = self.key(())
                for length in range(1, len(table)):  # [a.b] also makes a
                    self.lines.setdefault(table[:length], self.line)
                self.lines[table] = self.line
                self.to_line_end()
                continue
            path = self.key(table)
            if len(path) == len(table) or not self.equals():
                self.to_line_end()  # not TOML; tomllib refuses it
                continue
            self.lines.setdefault(path, self.line)
            self.value(path)

    def skip(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self.text, self.at)
        if match is None:
            return ""
        self.line += match.group().count("\n")
        self.at = match.end()
        return match.group()

    def key(self, above: Path) -> Path:
        """Read a dotted key at the current position."""
        parts = list(above)
        while True:
            self.skip(_SPACE)
            part = self.skip(_KEY_PART)
            if not part:
                return tuple(parts)
            parts.append(part[1:-1] if part[0] in "\"'" else part)
            if len(parts) > MAX_DEPTH:
                self.too_deep("names of a key")
            self.skip(_SPACE)
            if self.text[self.at : self.at + 1] != ".":
                return tuple(parts)
            self.at += 1

    def equals(self) -> bool:
        self.skip(_SPACE)
        if self.text[self.at : self.at + 1] != "=":
            return False
        self.at += 1
        return True

    def value(self, path: Path) -> None:
        """Step over a value; record the keys of inline tables on the way."""
        brackets: list[str] = []
        while self.at < len(self.text):
            if brackets and brackets[-1] == "{":
                self.skip(_SPACE)
                before = self.at
                inner = self.key(path)
                if len(inner) > len(path) and self.equals():
                    self.lines.setdefault(inner, self.line)
                elif self.at != before:
                    continue
            character = self.text[self.at : self.at + 1]
            if character in ("[", "{"):
                brackets.append(character)
                if len(brackets) > MAX_DEPTH:
                    self.too_deep("brackets")
                self.at += 1
            elif character in ("]", "}"):
                if brackets:
                    brackets.pop()
                self.at += 1
            elif character == "\n":
                if not brackets:
                    return
                self.at += 1
                self.line += 1
            elif character == "#":
                self.skip(re.compile(r"[^\n]*"))
            elif character and character in "\"'":
                if not self.skip(_STRING):
                    self.at += 1
            elif not self.skip(_PLAIN):
                self.at += 1

    def to_line_end(self) -> None:
        end = self.text.find("\n", self.at)
        self.at = len(self.text) if end < 0 else end

    def too_deep(self, what: str) -> None:
        raise FormatError(
            f"{self.name}, line {self.line}: expected at most {MAX_DEPTH} nested {what}, got more."
        )
