"""Every work that a docstring or a page cites stands in docs/references.bib, with what finds it."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCES = [*sorted((ROOT / "src").rglob("*.py")), *sorted((ROOT / "docs").glob("*.md"))]
KEY = re.compile(r"\[([A-Z][A-Za-z]*[A-Za-z]) ?((?:1[89]|20)\d\d)\b")
WORKS = re.compile(r"Sources?: (.*?)(?:\n\s*\n|\"\"\"|\n#)", re.DOTALL)
YEAR = re.compile(r"\b(1[89]\d\d|20\d\d)\)")


def library() -> dict[str, dict[str, str]]:
    """Fields of each entry, by its key."""
    text = (ROOT / "docs" / "references.bib").read_text(encoding="utf-8")
    found: dict[str, dict[str, str]] = {}
    for kind, key, body in re.findall(r"@(\w+)\{(\w+),\n(.*?)\n\}", text, re.DOTALL):
        assert key not in found, key
        found[key] = {"kind": kind, **dict(re.findall(r"  (\w+) = \{(.*)\},", body))}
    assert len(found) == text.count("\n@")
    return found


def surnames(entry: dict[str, str]) -> list[str]:
    people = entry.get("author", entry.get("editor", ""))
    plain = people.replace("\\o", "o").replace("{", "").replace("}", "")
    return [person.split(",")[0] for person in plain.split(" and ") if person != "others"]


def test_entries_are_complete() -> None:
    for key, entry in library().items():
        assert surnames(entry) and entry["title"] and re.fullmatch(r"1[89]\d\d|20\d\d", entry["year"]), key
        assert key.endswith(entry["year"]), key
        if entry["kind"] == "article":
            assert entry["journal"], key


def test_keys_are_known() -> None:
    known = library()
    cited = {
        (key + year, path.name)
        for path in SOURCES
        for key, year in KEY.findall(path.read_text(encoding="utf-8"))
    }
    assert len(cited) >= 5
    for key, where in cited:
        assert key in known, f"{where} cites {key}"


def test_works_named_by_author_and_year_are_known() -> None:
    entries = library().values()
    checked = 0
    for path in SOURCES:
        for words in WORKS.findall(path.read_text(encoding="utf-8")):
            for year in YEAR.findall(words):
                of_year = [entry for entry in entries if entry["year"] == year]
                assert any(
                    name in words or entry["title"].split(":")[0] in words
                    for entry in of_year
                    for name in surnames(entry)
                ), f"{path.name}: no entry of {year} for: {' '.join(words.split())}"
                checked += 1
    assert checked >= 20


def test_every_entry_is_cited() -> None:
    """By its key, or by the surname of its first author, or by its title."""
    text = " ".join(" ".join(path.read_text(encoding="utf-8") for path in SOURCES).split())
    for key, entry in library().items():
        named = (
            key in text
            or surnames(entry)[0] in text
            or entry["title"].replace("{", "").replace("}", "") in text
        )
        assert named, f"nothing cites {key}"
