"""Algorithms that serve every scalar hold no float literals: 1/2 stays exact.

A float in one of them would turn exact polynomials into inexact ones, and a literal such as 0.5 in a
recorded program could not be told from a rounded result.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "freebody"
FOLDERS = ("dynamics", "model", "symbolic")
GENERIC = sorted(path for folder in FOLDERS for path in (SOURCE / folder).rglob("*.py"))
GENERIC += [SOURCE / "scalar" / "algebra.py", SOURCE / "scalar" / "expression.py"]


def float_literals(text: str) -> list[int]:
    """Lines with a float or complex literal; docstrings are text and do not count."""
    return [
        node.lineno
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Constant) and isinstance(node.value, float | complex)
    ]


@pytest.mark.parametrize("path", GENERIC, ids=lambda path: str(path.relative_to(SOURCE)))
def test_no_float_literal(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    found = float_literals(text)
    assert not found, f"float literals in {path.name}, lines {found}"


def test_the_scan_sees_floats() -> None:
    assert float_literals("x = 1\ny = 0.5 * x\n'0.5'") == [2]
    assert GENERIC
