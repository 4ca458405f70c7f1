"""Answers and checks: the questions about a system, the library's answers, and conditions that they must satisfy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import freebody as fb

from ...symbolic.printing.closed.answers import shown
from ...symbolic.printing.latex import Latex
from ...symbolic.printing.show import latex_of, text_of
from ...symbolic.printing.text import Text

Plots = dict[str, Callable[[Path], Any]]


@dataclass(frozen=True)
class Printed:
    """A formula as plain text and LaTeX."""

    text: str
    latex: str

    @classmethod
    def of(cls, formula: Any) -> Printed:
        """Return a SymPy expression as printed."""
        return cls(text_of(formula), latex_of(formula))

    @classmethod
    def closed(cls, x: Any, ring: Any) -> Printed:
        """Return an element of a ring in its closed form."""
        return cls(*(shown(kind, x, ring, closed=True) for kind in (Text, Latex)))

    @classmethod
    def line(cls, text: str) -> Printed:
        """Return a line of plain text that has no other print."""
        return cls(text, "")

    @classmethod
    def equation(cls, left: Any, right: Any, ring: Any) -> Printed:
        """Return an equation of two elements, each in its closed form."""
        a, b = cls.closed(left, ring), cls.closed(right, ring)
        return cls(f"{a.text} = {b.text}", f"{a.latex} = {b.latex}")


@dataclass(frozen=True)
class Answer:
    """The answer to one question.

    Attributes
    ----------
    question : str
        The question in words, with its sign convention if it needs one.
    value : float, tuple or str
        A number, several numbers, or words if the answer is not a number: an equation, "none: spin too small".
    unit : str
        Unit of the value; empty for words, "1" for a pure number.
    formula : SymPy expression, optional
        The closed form in the parameters (and in coordinates and speeds, if it holds at any state), derived from
        the model. The value is this formula evaluated at the values of the parameters.
    how : str
        The call of the library that gives the answer.
    where : mapping
        Abbreviations in the formula: name -> SymPy expression.
    printed, where_printed : Printed, mapping
        The formula and ``where`` as printed, if not in SymPy's order.
    """

    question: str
    value: Any
    unit: str
    formula: Any = None
    how: str = ""
    printed: Printed | None = None
    where: Mapping[str, Any] = field(default_factory=dict)
    where_printed: Mapping[str, Printed] = field(default_factory=dict)

    @property
    def meanings(self) -> dict[str, Printed]:
        """The abbreviations in the formula with their expressions, as printed."""
        return {name: self.where_printed.get(name) or Printed.of(x) for name, x in self.where.items()}

    @property
    def meaning(self) -> dict[str, str]:
        """The abbreviations in the formula with their expressions, as plain text."""
        return {name: x.text for name, x in self.meanings.items()}

    @property
    def text(self) -> str:
        """The formula as plain text; empty if there is none."""
        return self._printed.text

    @property
    def latex(self) -> str:
        """The formula as LaTeX; empty if there is none."""
        return self._printed.latex

    @property
    def _printed(self) -> Printed:
        if self.printed is not None:
            return self.printed
        return Printed("", "") if self.formula is None else Printed.of(self.formula)


Answers = dict[str, Answer]


@dataclass(frozen=True)
class Check:
    """A condition on the answers: a residual that must stay within a bound.

    Attributes
    ----------
    what : str
        What is compared with what, or a statement.
    residual, bound : float
    kind : str
        "agreement" of two values, "smallness" of a number, or "fact", a statement that is true or not.
    """

    what: str
    residual: float
    bound: float
    kind: str = "smallness"

    @property
    def holds(self) -> bool:
        """True if the residual is within the bound; False if it is not a number."""
        return bool(self.residual <= self.bound)

    @property
    def sentence(self) -> str:
        """The check as a sentence.

        >>> fact("sticks at F_max less 1e-9 of it", True).sentence
        'sticks at F_max less 1e-9 of it: yes'
        >>> same("N against the simulation", 1 + 2**-40, 1, 1e-9).sentence
        'N against the simulation: agrees to 9.1e-13 (1e-09 allowed)'
        """
        if self.kind == "fact":
            return f"{self.what}: {'yes' if self.holds else 'NO'}"
        if self.kind == "agreement":
            verb = "agrees to" if self.holds else "DIFFERS by"
            return f"{self.what}: {verb} {self.residual:.1e} ({self.bound:.0e} allowed)"
        return (
            f"{self.what}: {self.residual:.1e}, {'at most' if self.holds else 'MORE than'} {self.bound:.0e}"
        )


def same(what: str, a: Any, b: Any, bound: float) -> Check:
    """Return a check that two numbers or arrays agree: their difference relative to the larger of 1 and their size."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    size = max(1.0, float(np.max(np.abs(a))), float(np.max(np.abs(b))))
    return Check(what, float(np.max(np.abs(a - b))) / size, bound, "agreement")


def fact(what: str, holds: bool) -> Check:
    """Return a check that a statement is true."""
    return Check(what, 0.0 if holds else 1.0, 0.5, "fact")


@dataclass(frozen=True)
class Solved:
    """The result of `solve` of an entry.

    Attributes
    ----------
    trajectory : Trajectory
        The motion that is drawn and stored.
    answers : dict
        Short key -> :class:`Answer`, in the order of the questions.
    plots : dict
        File name -> function that draws it to a path.
    checks : tuple of Check
    equations : Equations, optional
        The equations to show if contacts make the mode an answer; by default the equations of the entry.
    """

    trajectory: fb.Trajectory
    answers: Answers
    plots: Plots
    checks: tuple[Check, ...] = ()
    equations: Any = None
