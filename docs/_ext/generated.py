"""Pages that are made at build time: kept until the library or their maker changes, written only where they differ."""

from __future__ import annotations

import hashlib
from pathlib import Path

import freebody

PACKAGE = Path(freebody.__file__).parent


def fingerprint(*makers: str) -> str:
    """Of the library's text and of the files that make the pages."""
    found = hashlib.sha256()
    texts = (path for kind in ("py", "js", "css") for path in PACKAGE.rglob(f"*.{kind}"))
    for path in sorted([*texts, *map(Path, makers), Path(__file__)]):
        found.update(path.name.encode() + b"\0" + path.read_bytes())
    return found.hexdigest()


def up_to_date(folder: Path, stamp: str) -> bool:
    """Whether the folder was filled with this fingerprint."""
    kept = folder / ".made-of"
    return kept.exists() and kept.read_text() == stamp


def finish(folder: Path, stamp: str, made: set[Path]) -> None:
    """Remove what was not made this time, and remember of what the rest was made."""
    for path in folder.iterdir():
        if path not in made and path.is_file():
            path.unlink()
    (folder / ".made-of").write_text(stamp)


def write(path: Path, text: str) -> Path:
    """Write a page, unless it stands there already: an untouched page is not read again."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
    return path


def plain(text: str) -> str:
    """Words that Markdown takes as they are, with ``code`` kept.

    >>> print(plain("psi' = a*b*c, see ``fb.draw``"))
    psi' = a\\*b\\*c, see `fb.draw`
    """
    parts = text.split("``")
    for i in range(0, len(parts), 2):
        for sign in "\\*_`<>[]$|#":
            parts[i] = parts[i].replace(sign, "\\" + sign)
    return "`".join(parts)
