"""A page of the works that are cited, made from ``references.bib``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from generated import plain, write

ACCENTS = {'"': "\u0308", "'": "\u0301", "`": "\u0300", "^": "\u0302", "~": "\u0303", "c": "\u0327"}
LETTERS = {"alpha": "α", "o": "ø", "O": "Ø", "ss": "ß", "aa": "å", "ae": "æ", "l": "ł"}


def setup(app: Any) -> dict[str, Any]:
    app.connect("builder-inited", write_page)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_page(app: Any) -> None:
    """Write ``docs/reference/bibliography.md``."""
    works = entries((Path(app.srcdir) / "references.bib").read_text(encoding="utf-8"))
    folder = Path(app.srcdir) / "reference"
    folder.mkdir(exist_ok=True)
    lines = [f"- **{plain(key)}** {plain(line(fields))}" for key, fields in sorted(works.items())]
    text = "# Bibliography\n\nWorks that the documentation and the docstrings cite, by the keys they use.\n\n"
    write(folder / "bibliography.md", text + "\n".join(lines) + "\n")


def entries(text: str) -> dict[str, dict[str, str]]:
    """Fields by key; a field stands on a line of its own.

    >>> entries("@book{A1999,\\n  author = {M{\\\\\\"u}ller, Ann},\\n  year = {1999},\\n}")
    {'A1999': {'author': 'Müller, Ann', 'year': '1999'}}
    """
    found = {}
    for key, body in re.findall(r"^@\w+\{([^,]+),\n(.*?)^\}", text, re.MULTILINE | re.DOTALL):
        pairs = re.findall(r"^\s*(\w+)\s*=\s*\{(.*)\},?$", body, re.MULTILINE)
        found[key] = {name: spoken(value) for name, value in pairs}
    return found


def spoken(value: str) -> str:
    """A value without the braces and commands of LaTeX."""
    import unicodedata

    value = re.sub(r"""\\(["'`^~]|c )\s*\{?\\?([A-Za-z])\}?""", lambda m: m[2] + ACCENTS[m[1].strip()], value)
    value = re.sub(r"\\([A-Za-z]+)\b ?\{?\}?", lambda m: LETTERS[m[1]], value)
    value = value.replace("{", "").replace("}", "").replace("$", "").replace("--", "–").replace("\\&", "&")
    return unicodedata.normalize("NFC", value)


def line(fields: dict[str, str]) -> str:
    """Authors, title, place, year."""
    people = (fields.get("author") or fields.get("editor", "")).replace(" and ", "; ")
    where = [fields.get(name, "") for name in ("journal", "booktitle", "series", "publisher", "school")]
    volume = " ".join(filter(None, [next(filter(None, where), ""), fields.get("volume", "")]))
    edition = f"edition {fields['edition']}" if "edition" in fields else ""
    parts = [fields["title"], edition, volume, fields.get("pages", ""), fields["year"]]
    return f"{people}: " + ", ".join(filter(None, parts)) + "."
