"""A statement of the chapter and the verdict on it, which is computed on every request and never stored.

A statement contains the equations as printed and a meaning: the library's value for each name in them.
Every member of a print is compared with its first member. With the values of the names,

    holds                       their difference is zero in canonical form
    holds if ...                it is zero only under the condition
    definition                  it is zero, and the print gives a name to a quantity of the library
    approximation               it falls faster with a small quantity than the smallest printed term
    misprint                    none of these: the form derived by the library is shown
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy

from ..scalar.element import is_zero as is_zero_element
from ..scalar.ring import Ring
from ..symbolic.printing.show import latex_of, text_of
from . import notation
from .latex import latex
from .meaning import Meaning
from .notation import Node, Relation
from .small import Small, components, put
from .values import evaluate

VERDICTS = ("misprint", "holds under a condition", "approximation", "definition", "holds")
"""Verdicts on a relation; the verdict on a statement is the first in this order that a relation of it has."""


def is_zero(expression: Any) -> bool:
    """Return True if an expression is zero in canonical form, roots and complex numbers included.

    >>> x = sympy.Symbol("x")
    >>> is_zero(sympy.sin(2 * x) - 2 * sympy.sin(x) * sympy.cos(x))
    True
    """
    expression = sympy.sympify(expression)
    if expression.has(sympy.I):
        atoms = expression.atoms(sympy.Derivative, sympy.core.function.AppliedUndef) | expression.free_symbols
        real = expression.xreplace({x: sympy.Dummy(real=True) for x in atoms})
        return all(map(is_zero, sympy.expand(real, complex=True).as_real_imag()))
    return bool(is_zero_element(Ring().from_sympy(_factored_roots(expression))))


def _factored_roots(x: Any) -> Any:
    """Return an expression with the arguments of its roots factored, so that positive factors leave the root."""
    roots = {
        root: sympy.factor(sympy.together(root.base)) ** root.exp
        for root in x.atoms(sympy.Pow)
        if root.exp.is_Rational and not root.exp.is_Integer
    }
    return x.xreplace(roots)


@dataclass(frozen=True)
class Finding:
    """The verdict on one relation of a statement, or on all of them.

    Attributes
    ----------
    verdict : one of `VERDICTS`
    detail : str
        The condition, the measured error, or the misprinted relations.
    residual : tuple
        For a relation: the components of left minus right.
    derived : tuple
        For a relation: the library's form, (print or expression, sign, expression); shown for a misprint.
    """

    verdict: str
    detail: str = ""
    residual: tuple[Any, ...] = ()
    derived: tuple[Any, str, Any] | None = None


@dataclass(frozen=True)
class Statement:
    """An equation of the chapter.

    Attributes
    ----------
    number : str
        ``"6.27"``, or ``"ex-6-1 (d)"`` for the lettered equation of an example.
    about : str
        What it states, in words.
    call : str
        The calls of the library that give its names their meaning.
    prints : str or tuple of str
        Its equations as printed, in the letters of `notation`.
    work : function
        Returns the meaning of the names, or several meanings if the print holds for every body i.
    condition : tuple, optional
        Words, and a function that returns the substitutions under which the statement holds.
    defines : bool
        True if it gives a name to a quantity.
    """

    number: str
    about: str
    call: str
    prints: str | tuple[str, ...]
    work: Callable[[], Meaning | Sequence[Meaning]]
    condition: tuple[str, Callable[[], Sequence[tuple[Any, Any]]]] | None = None
    defines: bool = False

    @cached_property
    def rows(self) -> tuple[str, ...]:
        """Return the prints, one equation each."""
        return (self.prints,) if isinstance(self.prints, str) else self.prints

    @cached_property
    def relations(self) -> tuple[tuple[int, Relation], ...]:
        """Return every relation with the index of its print."""
        return tuple((i, r) for i, row in enumerate(self.rows) for r in notation.read(row).relations)

    @cached_property
    def meanings(self) -> tuple[Meaning, ...]:
        """Derive the meanings of the names."""
        work = self.work()
        return (work,) if isinstance(work, Meaning) else tuple(work)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """Return the verdict on every relation."""
        return tuple(self.judge(place, relation) for place, relation in self.relations)

    def judge(self, place: int, relation: Relation) -> Finding:
        """Return the verdict on a relation of the print at an index, with this statement's meanings."""
        findings = [self._judged(m, place, relation) for m in self.meanings]
        return min(findings, key=lambda f: VERDICTS.index(f.verdict))

    def _judged(self, meaning: Meaning, place: int, relation: Relation) -> Finding:
        if relation.sign in "<>":
            return self._inequality(meaning, relation)
        residual, derived = _difference(meaning, place, relation)
        if all(map(is_zero, residual)):
            return Finding("definition" if self.defines else "holds", "", residual, derived)
        if self.condition is not None:
            words, pairs = self.condition
            if all(is_zero(put(x, pairs())) for x in residual):
                return Finding("holds under a condition", words, residual, derived)
        # the chapter also writes = for ≅, but not in a print that has both
        rough = relation.sign == "≅" or "≅" not in self.rows[place]
        if meaning.small is not None and rough and relation.right.kind != "const":
            error = _approximated(meaning, meaning.small, relation)
            if error:
                return Finding("approximation", error, residual, derived)
        return Finding("misprint", "", residual, derived)

    def _inequality(self, meaning: Meaning, relation: Relation) -> Finding:
        left, right = (evaluate(x, meaning) for x in (relation.left, relation.right))
        gap = left - right if relation.sign == ">" else right - left
        derived = (meaning.positive, ">", sympy.Integer(0))
        words, pairs = self.condition or ("", tuple)
        for verdict, detail, substitutions in (
            ("holds", "", ()),
            ("holds under a condition", words, pairs()),
        ):
            # a positive multiple of a positive expression
            if sympy.factor(
                sympy.cancel(put(gap, substitutions) / put(meaning.positive, substitutions))
            ).is_positive:
                return Finding(verdict, detail, (left - right,), derived)
        return Finding("misprint", "", (left - right,), derived)

    @cached_property
    def finding(self) -> Finding:
        """Return the verdict on the whole statement: the worst of its relations."""
        findings = self.findings
        verdict = min((f.verdict for f in findings), key=VERDICTS.index)
        if verdict == "misprint":
            detail = _count([i for i, f in enumerate(findings) if f.verdict == verdict], len(findings))
        else:
            detail = "; ".join(dict.fromkeys(f.detail for f in findings if f.verdict == verdict))
        return Finding(verdict, detail)

    @property
    def verdict(self) -> str:
        """Return the verdict with its detail in one line."""
        finding = self.finding
        if not finding.detail:
            return finding.verdict
        joint = {"holds under a condition": "holds if ", "misprint": "misprint in "}
        return joint.get(finding.verdict, f"{finding.verdict}: ") + finding.detail

    @property
    def right(self) -> list[tuple[Any, str, Any]]:
        """Return the forms that the library derives in place of the misprinted ones."""
        return [f.derived for f in self.findings if f.verdict == "misprint" and f.derived is not None]

    def text(self) -> str:
        """Return the statement, its verdict and the derivation as plain text."""
        rows = [f"({self.number})  {self.about}", "", "  as printed:", *(f"    {row}" for row in self.rows)]
        rows += ["", f"  by the library: {self.call}"]
        rows += [
            f"    {r}: {self._outcome(finding)}"
            for (_, r), finding in zip(self.relations, self.findings, strict=True)
        ]
        if self.right:
            rows += ["", "  right:", *(f"    {self._plain(form)}" for form in self.right)]
        rows += ["", f"  verdict: {self.verdict}"]
        return "\n".join(rows)

    def _outcome(self, finding: Finding) -> str:
        if finding.verdict == "misprint":
            return f"left minus right is {_written(finding.residual, self.meanings[0].units)}"
        if finding.verdict == "holds under a condition":
            return f"holds if {finding.detail}"
        return finding.detail.rpartition(": ")[2] or finding.verdict

    def _plain(self, form: tuple[Any, str, Any]) -> str:
        units = self.meanings[0].units
        left, sign, right = form
        return f"{left if isinstance(left, Node) else _written(components(left), units)} {sign} " + _written(
            components(right), units
        )

    def latex(self) -> str:
        """Return printed and derived forms as LaTeX, one below the other."""
        names = self.meanings[0].names
        bold = frozenset(k for k, v in names.items() if isinstance(v, sympy.MatrixBase))
        write = lambda node: latex(node, bold)  # noqa: E731
        signs = {"≅": r"\approx"}
        rows = [
            rf"{write(r.left)} {signs.get(r.sign, r.sign)} {write(r.right)} && \text{{printed}}"
            for _, r in self.relations
        ]
        for left, sign, right in self.right:
            side = write(left) if isinstance(left, Node) else latex_of(_tidy(left))
            vector = [latex_of(_tidy(x)) for x in components(right)]
            value = (
                vector[0]
                if len(vector) == 1
                else r"\begin{bmatrix}" + r" \\ ".join(vector) + r"\end{bmatrix}"
            )
            rows.append(rf"{side} {sign} {value} && \text{{derived}}")
        return "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"

    def data(self) -> dict[str, Any]:
        """Return the statement and its verdict as plain data for JSON."""
        units = self.meanings[0].units
        return {
            "number": self.number,
            "about": self.about,
            "call": self.call,
            "verdict": self.finding.verdict,
            "detail": self.finding.detail,
            "printed": list(self.rows),
            "relations": [
                {
                    "relation": str(relation),
                    "verdict": finding.verdict,
                    "residual": _written(finding.residual, units),
                    "derived": self._plain(finding.derived)
                    if finding.verdict == "misprint" and finding.derived
                    else None,
                }
                for (_, relation), finding in zip(self.relations, self.findings, strict=True)
            ],
        }


def _difference(
    meaning: Meaning, place: int, relation: Relation
) -> tuple[tuple[Any, ...], tuple[Any, str, Any] | None]:
    """Return the components of left minus right, and the corrected form: the library's value of the left side."""
    left = evaluate(relation.left, meaning)
    if relation.right.kind == "const":
        rate = notation.Node("rate", None, (relation.left,))
        return _rates(meaning, left), (rate, "=", left.diff(meaning.time))
    right = evaluate(relation.right, meaning)
    if isinstance(left, sympy.MatrixBase) != isinstance(right, sympy.MatrixBase) and right != 0:
        raise TypeError("a vector equal to a number")
    if place in meaning.rows:
        row = meaning.rows[place]
        gap = sympy.sympify(row[0] - row[1])
        return (left - right - _scale(left - right, gap) * gap,), (row[0], "=", row[1])
    gap = left - right if right != 0 else left
    values = [put(x, meaning.along) for x in components(left)]
    derived = (relation.left, "=", sympy.Matrix(values) if len(values) == 3 else values[0])
    return tuple(put(put(x, meaning.along), meaning.steady) for x in components(gap)), derived


def _rates(meaning: Meaning, value: Any) -> tuple[Any, ...]:
    """Return the rate of an expression that must be constant; at a steady state also the rate of this rate."""
    rate = lambda x: put(x.diff(meaning.time), meaning.along)  # noqa: E731
    first = [rate(x) for x in components(value)]
    both = [*first, *map(rate, first)] if meaning.steady else first
    return tuple(put(x, meaning.steady) for x in both)


def terms(expression: Any) -> dict[Any, Any]:
    """Return the monomials of the canonical form with their coefficients."""
    ring = Ring()
    plain = ring.to_sympy(ring.from_sympy(sympy.sympify(expression)))
    return dict(sympy.expand(plain).as_coefficients_dict())


def _scale(printed: Any, derived: Any) -> Any:
    """Return the ratio of two balances, from the first monomial that they share."""
    mine, other = terms(printed), terms(derived)
    return next((mine[k] / other[k] for k in sorted(other, key=str) if mine.get(k)), sympy.Integer(1))


def _approximated(meaning: Meaning, small: Small, relation: Relation) -> str:
    """Return the order and size of the error, or "" if it is not smaller than every printed term."""
    left, right = (evaluate(x, meaning) for x in (relation.left, relation.right))
    error = left - right if right != 0 else left
    order = small.order(error)
    kept = [x for x in (evaluate(x, meaning) for x in summands(relation.right)) if any(components(x))]
    if not kept or order < max(map(small.order, kept)) + 1 / 4:
        return ""
    relative = small.number(error, small.size) / small.number(left, small.size)
    lead = small.order(left)
    return (
        f"{relation}: relative error of order {order - lead:.2g} in {small.symbol}, {float(relative):.1e} at "
        f"{small.symbol} = {float(sympy.N(small.size)):.3g}"
    )


def summands(node: Node) -> tuple[Node, ...]:
    """Return the terms of a side; brackets around the whole side are removed."""
    while node.kind == "group":
        node = node.parts[0]
    return node.parts if node.kind == "sum" else (node,)


def _count(wrong: Sequence[int], total: int) -> str:
    """Return the wrong relations in words.

    >>> _count([2, 3], 4)
    'relations 3 and 4 of 4'
    """
    if total == 1:
        return ""
    numbers = " and ".join(str(i + 1) for i in wrong)
    return f"relation{'s' if len(wrong) > 1 else ''} {numbers} of {total}"


def _tidy(x: Any) -> Any:
    """Return the canonical form or its factored form, whichever is shorter."""
    x = sympy.sympify(x)
    if is_zero(x):
        return sympy.Integer(0)
    if x.has(sympy.I):  # the canonical form's ring is over real numbers
        return x
    ring = Ring()
    plain = ring.to_sympy(ring.from_sympy(x))
    return min((sympy.factor_terms(plain), sympy.factor(plain), x), key=lambda e: len(text_of(e)))


def _written(parts: Sequence[Any], units: Sequence[str]) -> str:
    """Return the nonzero components with their unit vectors as text."""
    texts = [notation.greek(text_of(_tidy(x))) for x in parts]
    if len(texts) != 3:
        return ", ".join(texts)
    return " + ".join(f"({x}) {u}" for x, u in zip(texts, units, strict=True) if x != "0") or "0"
