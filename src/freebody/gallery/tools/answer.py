"""Answers and checks: what is asked of a system, what the library says, and what must hold of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import freebody as fb

from ...symbolic.printing.show import latex_of, text_of

Plots = dict[str, Callable[[Path], Any]]


@dataclass(frozen=True)
class Answer:
    """The answer to one question.

    Attributes
    ----------
    question : str
        What is asked, in words, with its sign convention where it has one.
    value : float, tuple or str
        A number, several of them, or words where the answer is none: an equation, "none: spin too small".
    unit : str
        Of the value; empty for words, "1" for a pure number.
    formula : SymPy expression, optional
        The closed form in the parameters (and in coordinates and speeds, where it holds at any state), derived from
        the model. The value is this formula at the values of the parameters.
    how : str
        Which call of the library gives it.
    where : mapping
        What stands in the formula for a longer expression: name -> SymPy expression.
    written, typeset, where_written : str, str, mapping
        Formula and ``where`` as they are printed, if not as SymPy orders them.
    """

    question: str
    value: Any
    unit: str
    formula: Any = None
    how: str = ""
    written: str = ""
    typeset: str = ""
    where: Mapping[str, Any] = field(default_factory=dict)
    where_written: Mapping[str, str] = field(default_factory=dict)

    @property
    def meaning(self) -> dict[str, str]:
        """What stands in the formula for a longer expression, as plain text."""
        return {name: self.where_written.get(name) or text_of(x) for name, x in self.where.items()}

    @property
    def text(self) -> str:
        """The formula as plain text; empty if there is none."""
        return self.written or ("" if self.formula is None else text_of(self.formula))

    @property
    def latex(self) -> str:
        """The formula as LaTeX; empty if there is none."""
        return self.typeset or ("" if self.formula is None else latex_of(self.formula))


Answers = dict[str, Answer]


@dataclass(frozen=True)
class Check:
    """Something that must hold of the answers: a residual that is to stay within a bound.

    Attributes
    ----------
    what : str
        What is compared with what.
    residual, bound : float
    """

    what: str
    residual: float
    bound: float

    @property
    def holds(self) -> bool:
        """Whether the residual is within the bound; not where it is not a number."""
        return bool(self.residual <= self.bound)


def same(what: str, a: Any, b: Any, bound: float) -> Check:
    """A check that two numbers (or arrays) agree: their difference, relative to the larger of 1 and their size."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    size = max(1.0, float(np.max(np.abs(a))), float(np.max(np.abs(b))))
    return Check(what, float(np.max(np.abs(a - b))) / size, bound)


@dataclass(frozen=True)
class Solved:
    """What `solve` of an entry gives.

    Attributes
    ----------
    trajectory : Trajectory
        The motion that is drawn and kept.
    answers : dict
        Short key -> :class:`Answer`, in the order in which they are asked.
    plots : dict
        File name -> function that draws it to a path.
    checks : tuple of Check
    equations : Equations, optional
        Those that are shown, where contacts make the mode an answer; else those of the entry.
    """

    trajectory: fb.Trajectory
    answers: Answers
    plots: Plots
    checks: tuple[Check, ...] = ()
    equations: Any = None
