"""A question about a machine and its answer, as text, LaTeX and plain data."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass
class Section:
    """One question and its answer as text, LaTeX and plain data.

    Attributes
    ----------
    title : str
    text : list of str
        Blocks of plain text.
    latex : list of str
        Displayed formulas.
    notes : list of str
        Sentences: answers that do not exist, and assumptions.
    data : dict or list
        The answer as data that JSON can hold.
    """

    title: str
    text: list[str] = field(default_factory=list)
    latex: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    data: Any = None


def plain_data(x: Any) -> Any:
    """A number, array or matrix as JSON can hold it: a complex number as [real, imaginary], infinity as None."""
    if hasattr(x, "tolist"):
        return plain_data(x.tolist())
    if isinstance(x, Sequence):
        return [plain_data(entry) for entry in x]
    if isinstance(x, complex):
        return [plain_data(x.real), plain_data(x.imag)]
    return float(x) if math.isfinite(x) else None


def plain_latex(text: str) -> str:
    """Return text with the special characters of LaTeX escaped.

    >>> plain_latex("momentum of theta_1: 50%")
    'momentum of theta\\\\_1: 50\\\\%'
    """
    special = {"\\": r"\textbackslash{}", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}"}
    return "".join(special.get(c, "\\" + c if c in "&%$#_{}" else c) for c in text)
