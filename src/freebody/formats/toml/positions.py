"""Where the keys of a TOML text stand, and how deep its values are nested.

``tomllib`` gives values without places. This scan knows just as much of the grammar as finding keys
takes: headers, keys, strings, comments and brackets. Whether the text is TOML is left to ``tomllib``,
which reads it afterwards; the limits are checked here, before anything recursive sees the text.
"""

from __future__ import annotations

import re

from ...errors import FormatError

Path = tuple[str, ...]

MAX_DEPTH = 8  # of brackets in one another, and of names in one key

_SPACE = re.compile(r"[ \t]*")
_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_KEY_PART = re.compile(r"""[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*'""")
_STRING = re.compile(
    r'"""(?:[^\\]|\\.)*?"""|\'\'\'.*?\'\'\'|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'',
    re.DOTALL,
)
_PLAIN = re.compile(r"[^\[\]{}\"'#,\n]+")


def key_lines(text: str, name: str) -> dict[Path, int]:
    """The line of every key and table header.

    Parameters
    ----------
    text : str
    name : str
        Of the file, for messages.

    Returns
    -------
    dict of tuple of str to int
        Path of the key from the root -> line, counted from 1. Of an array of tables the last header counts.

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
                self.to_line_end()  # not TOML: tomllib says so
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
        """A dotted key, from the current place on."""
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
        """Step over a value; note the keys of inline tables on the way."""
        opened: list[str] = []
        while self.at < len(self.text):
            if opened and opened[-1] == "{":
                self.skip(_SPACE)
                before = self.at
                inner = self.key(path)
                if len(inner) > len(path) and self.equals():
                    self.lines.setdefault(inner, self.line)
                elif self.at != before:
                    continue
            character = self.text[self.at : self.at + 1]
            if character in ("[", "{"):
                opened.append(character)
                if len(opened) > MAX_DEPTH:
                    self.too_deep("brackets")
                self.at += 1
            elif character in ("]", "}"):
                if opened:
                    opened.pop()
                self.at += 1
            elif character == "\n":
                if not opened:
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
