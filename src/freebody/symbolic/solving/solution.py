"""Solution of a request to the equations: values by name, branches and conditions, with their text and LaTeX."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy

from ...errors import ModelError, nearest
from ...scalar.algebra import Scalar
from ...scalar.ratio import Ratio
from ..derivation.derivation import Derivation
from ..printing.display import equation_latex, equation_text
from ..printing.fractions import ratio_displayed, ratio_latex, ratio_text
from ..printing.typeset import Typeset
from .vocabulary import Vocabulary


@dataclass(frozen=True)
class Branch:
    """One solution: values by the unknown's name, and exact ratios of the unknowns in which the request is linear.

    A long solution also has ``lines``, each unknown by others, and ``names``, the named coefficients in these lines.
    """

    ratios: Mapping[str, Ratio]
    values: Mapping[str, Any]
    lines: Sequence[tuple[str, Ratio]] = ()
    names: Sequence[tuple[str, Ratio]] = ()

    @property
    def printed(self) -> list[tuple[str, Ratio | None]]:
        """Printed lines: (unknown, ratio), with None for an unknown without a ratio."""
        return [*self.lines] or [(name, self.ratios.get(name)) for name in self.values]


class SolveResult(Typeset, Mapping[str, Any]):
    """Solution of :meth:`Equations.solve`: SymPy expressions by the unknown's name (or SymPy atom).

    A long solution is printed in steps: see :attr:`steps`.

    Attributes
    ----------
    branches : tuple of dict
        Every solution; a request that is not linear may have more than one.
    conditions : tuple of Eq
        Conditions for the solution: the equations of motion that remain.
    """

    def __init__(
        self, e: Derivation, vocabulary: Vocabulary, solutions: Sequence[Branch], conditions: Sequence[Scalar]
    ) -> None:
        self._ring = e.ring
        self._vocabulary = vocabulary
        self._solutions = tuple(solutions)
        self._conditions = tuple(conditions)
        vocabulary.extend({name: sympy.Symbol(name, real=True) for s in solutions for name, _ in s.names})
        self.branches = tuple(dict(s.values) for s in solutions)
        self.conditions = tuple(sympy.Eq(e.displayed(c), 0, evaluate=False) for c in conditions)

    @property
    def ratios(self) -> Mapping[str, Ratio]:
        """Exact ratios of canonical polynomials by name, of a single linear solution."""
        self._single()
        return self._solutions[0].ratios

    @cached_property
    def steps(self) -> tuple[tuple[tuple[str, Any], ...], tuple[tuple[str, Any], ...]]:
        """(unknowns, coefficients) of a long solution as printed, pairs of a name and a SymPy expression.

        An unknown is expressed by unknowns above it and by coefficients k_1, k_2, …, these by coefficients above them.
        Both are empty if the solution is short.
        """
        self._single()
        lines, names = (
            tuple((name, ratio_displayed(r, self._ring)) for name, r in part)
            for part in (self._solutions[0].lines, self._solutions[0].names)
        )
        return lines, names

    def _single(self) -> None:
        if len(self.branches) != 1:
            raise ModelError(
                f"There are {len(self.branches)} solutions for {', '.join(self.branches[0])}. "
                f"Choose one: result.branches[0], ..., result.branches[{len(self.branches) - 1}]."
            )

    def __getitem__(self, key: Any) -> Any:
        self._single()
        values = self.branches[0]
        name = key if isinstance(key, str) else self._vocabulary.name(sympy.sympify(key))
        name = name.replace("**", "^")
        if name not in values:
            raise ModelError(f"'{name}' was not solved for; {nearest(name, list(values))}")
        return values[name]

    def __contains__(self, key: object) -> bool:
        return key in self.branches[0]

    def __iter__(self) -> Iterator[str]:
        return iter(self.branches[0])

    def __len__(self) -> int:
        return len(self.branches[0])

    def text(self) -> str:
        """The solution as plain text, a line for each unknown."""
        blocks = []
        for s in self._solutions:
            blocks.append("\n".join(f"{name} = {self._text(s, name, r)}" for name, r in s.printed))
        lines = ["\nor\n".join(blocks)]
        if names := [pair for s in self._solutions for pair in s.names]:
            lines.append("where")
            lines += [f"  {name} = {ratio_text(r, self._ring)}" for name, r in names]
        if self._conditions:
            lines.append("provided that")
            lines += [f"  {equation_text(c, 0, self._ring)}" for c in self._conditions]
        return "\n".join(lines)

    def _text(self, s: Branch, name: str, r: Ratio | None) -> str:
        if r is not None:
            return ratio_text(r, self._ring)
        return self._vocabulary.name(s.values[name])

    def latex(self) -> str:
        """The solution as a LaTeX ``aligned`` block."""
        lines = []
        for s in self._solutions:
            for name, r in (*s.printed, *s.names):
                right = self._vocabulary.latex(s.values[name]) if r is None else ratio_latex(r, self._ring)
                lines.append(f"{self._unknown_latex(name)} &= {right}")
        lines += [equation_latex(c, 0, self._ring).replace(" = ", " &= ", 1) for c in self._conditions]
        return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"

    def _unknown_latex(self, name: str) -> str:
        return self._vocabulary.latex(self._vocabulary.expression(name, "the unknown"))

    def __repr__(self) -> str:
        return self.text()
