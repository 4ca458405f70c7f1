"""The glossary is generated from one table, names each thing once, and says where it is computed."""

from __future__ import annotations

import ast
import sys
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs" / "_ext"))

import glossary  # noqa: E402

TERMS = [term for terms in glossary.TERMS.values() for term in terms]


def test_the_page_is_up_to_date() -> None:
    """``python docs/_ext/glossary.py`` writes it."""
    assert (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8") == glossary.page()


def test_each_term_stands_once() -> None:
    assert [name for name, count in Counter(term.name for term in TERMS).items() if count > 1] == []


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.name)
def test_the_place_of_a_term_exists(term: glossary.Term) -> None:
    file, _, name = term.place.partition(":")
    defined = set()
    for node in ast.parse((ROOT / "src" / "freebody" / file).read_bytes()).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            defined.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            defined |= {target.id for target in targets if isinstance(target, ast.Name)}
    assert name in defined
    assert term.meaning and not term.meaning.endswith(".")
