"""SymPy expressions in the names of the model, words in formulas, and blocks of formulas in LaTeX.

Canonical polynomials are printed by `display`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import sympy

from .latex import latex_name
from .printer import name_of


def latex_words(text: str) -> str:
    r"""Return words in a formula as LaTeX.

    >>> print(latex_words("momentum of theta_1:"))
    \text{momentum of theta\_1:}
    """
    for c in "&%$#_{}":
        text = text.replace(c, "\\" + c)
    return rf"\text{{{text}}}"


def aligned(lines: Iterable[str]) -> str:
    """Return LaTeX formulas in an ``aligned`` block."""
    return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"


def split(name: str) -> tuple[str, int]:
    """Return a name without its primes, and their number: ``theta'`` is theta, differentiated once.

    >>> split("theta''")
    ('theta', 2)
    """
    base = name.rstrip("'")
    return base, len(name) - len(base)


def text_of(x: Any) -> str:
    """Return a SymPy expression as text, with primes for derivatives.

    >>> t = sympy.Symbol("t")
    >>> theta = sympy.Function("theta")(t)
    >>> text_of(theta.diff(t)**2*sympy.sin(theta))
    "theta'^2*sin(theta)"
    """
    named = {atom: sympy.Symbol(name + "'" * dots) for atom, (name, dots) in _names(x).items()}
    return str(sympy.sympify(x).xreplace(named)).replace("**", "^")


def latex_of(x: Any) -> str:
    r"""Return a SymPy expression as LaTeX, with dots for derivatives.

    >>> t = sympy.Symbol("t")
    >>> print(latex_of(sympy.Function("theta_1")(t).diff(t)**2/2))
    \frac{\dot{\theta}_{1}^{2}}{2}
    """
    names = _names(x)
    named = {atom: sympy.Symbol(name + "'" * dots) for atom, (name, dots) in names.items()}
    written = {named[atom]: latex_name(name, dots) for atom, (name, dots) in names.items()}
    return sympy.latex(sympy.sympify(x).xreplace(named), symbol_names=written)


def _names(x: Any) -> dict[Any, tuple[str, int]]:
    """Return name and number of primes of every symbol, function of time and derivative, sorted."""
    x = sympy.sympify(x)
    atoms: set[Any] = set()

    def visit(part: Any) -> None:
        if part.is_Symbol or part.is_Derivative or isinstance(part, sympy.core.function.AppliedUndef):
            atoms.add(part)
            return
        for argument in part if isinstance(part, sympy.MatrixBase) else part.args:
            visit(argument)

    visit(x)
    return {atom: name_of(atom) for atom in sorted(atoms, key=lambda a: name_of(a))}


def column_text(v: Any) -> str:
    """Return components as text: ``(0, m*g, 0)``."""
    return "(" + ", ".join(map(text_of, v)) + ")"


def column_latex(v: Any) -> str:
    """Return components as a LaTeX column."""
    return r"\begin{bmatrix}" + r" \\ ".join(map(latex_of, v)) + r"\end{bmatrix}"
