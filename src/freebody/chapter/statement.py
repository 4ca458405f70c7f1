"""A statement of the chapter, and the verdict on it: worked out each time it is asked for, never written down.

A statement holds the equations as they are printed, and a meaning: what the library gives for each name in them.
Every member of a print is judged against its first one. With the names put in,

    holds                       their difference is zero in canonical form
    holds if ...                it is zero once the condition is put in, and not before
    definition                  it is zero, and the print gives a name to what the library knows by itself
    approximation               it falls faster with a small quantity than the least term that is printed
    misprint                    none of these: the form that the library derives is shown
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
"""Of a relation; that of a statement is the first that one of its relations has."""


def is_zero(expression: Any) -> bool:
    """Whether an expression is zero in canonical form, roots and complex numbers included.

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
    """With what stands under a root factored, so that positive factors leave it."""
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
        The condition, the error measured, or which relations are misprinted.
    residual : tuple
        Of a relation: the components of left minus right.
    derived : tuple
        Of a relation: what the library gives, (print or expression, sign, expression); shown where it is a misprint.
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
        What of the library gives its names their meaning.
    prints : str or tuple of str
        Its equations as printed, in the letters of `notation`.
    work : function
        Gives the meaning of the names; or several, as where the print is for every body i.
    condition : tuple, optional
        Words, and a function that gives pairs to put in for the statement to hold.
    defines : bool
        Whether it gives a name to something.
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
        """The prints, one equation each."""
        return (self.prints,) if isinstance(self.prints, str) else self.prints

    @cached_property
    def relations(self) -> tuple[tuple[int, Relation], ...]:
        """Every relation with the place of its print."""
        return tuple((i, r) for i, row in enumerate(self.rows) for r in notation.read(row).relations)

    @cached_property
    def meanings(self) -> tuple[Meaning, ...]:
        """What the names mean, derived now."""
        work = self.work()
        return (work,) if isinstance(work, Meaning) else tuple(work)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """The verdict on every relation."""
        return tuple(self.judge(place, relation) for place, relation in self.relations)

    def judge(self, place: int, relation: Relation) -> Finding:
        """The verdict on a relation in the place of a print, by what the names mean here."""
        found = [self._judged(m, place, relation) for m in self.meanings]
        return min(found, key=lambda f: VERDICTS.index(f.verdict))

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
        # the chapter writes = for ≅ too, but not where it has both
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
        for verdict, detail, known in (("holds", "", ()), ("holds under a condition", words, pairs())):
            # a positive multiple of what is positive
            if sympy.factor(sympy.cancel(put(gap, known) / put(meaning.positive, known))).is_positive:
                return Finding(verdict, detail, (left - right,), derived)
        return Finding("misprint", "", (left - right,), derived)

    @cached_property
    def finding(self) -> Finding:
        """The verdict on the whole: the worst of its relations."""
        found = self.findings
        verdict = min((f.verdict for f in found), key=VERDICTS.index)
        if verdict == "misprint":
            detail = _count([i for i, f in enumerate(found) if f.verdict == verdict], len(found))
        else:
            detail = "; ".join(dict.fromkeys(f.detail for f in found if f.verdict == verdict))
        return Finding(verdict, detail)

    @property
    def verdict(self) -> str:
        """The verdict with its detail, in a line."""
        found = self.finding
        if not found.detail:
            return found.verdict
        joint = {"holds under a condition": "holds if ", "misprint": "misprint in "}
        return joint.get(found.verdict, f"{found.verdict}: ") + found.detail

    @property
    def right(self) -> list[tuple[Any, str, Any]]:
        """What the library derives in the place of what is misprinted."""
        return [f.derived for f in self.findings if f.verdict == "misprint" and f.derived is not None]

    def text(self) -> str:
        """The statement, its verdict and the derivation, as plain text."""
        rows = [f"({self.number})  {self.about}", "", "  as printed:", *(f"    {row}" for row in self.rows)]
        rows += ["", f"  by the library: {self.call}"]
        rows += [
            f"    {r}: {self._said(found)}"
            for (_, r), found in zip(self.relations, self.findings, strict=True)
        ]
        if self.right:
            rows += ["", "  right:", *(f"    {self._plain(form)}" for form in self.right)]
        rows += ["", f"  verdict: {self.verdict}"]
        return "\n".join(rows)

    def _said(self, found: Finding) -> str:
        if found.verdict == "misprint":
            return f"left minus right is {_written(found.residual, self.meanings[0].units)}"
        if found.verdict == "holds under a condition":
            return f"holds if {found.detail}"
        return found.detail.rpartition(": ")[2] or found.verdict

    def _plain(self, form: tuple[Any, str, Any]) -> str:
        units = self.meanings[0].units
        left, sign, right = form
        return f"{left if isinstance(left, Node) else _written(components(left), units)} {sign} " + _written(
            components(right), units
        )

    def latex(self) -> str:
        """Printed and derived forms as LaTeX, one under the other."""
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
        """The same as plain data, for JSON."""
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
                    "verdict": found.verdict,
                    "residual": _written(found.residual, units),
                    "derived": self._plain(found.derived)
                    if found.verdict == "misprint" and found.derived
                    else None,
                }
                for (_, relation), found in zip(self.relations, self.findings, strict=True)
            ],
        }


def _difference(
    meaning: Meaning, place: int, relation: Relation
) -> tuple[tuple[Any, ...], tuple[Any, str, Any] | None]:
    """Components of left minus right, and the right form: what the library gives for the left."""
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
    known = [put(x, meaning.along) for x in components(left)]
    derived = (relation.left, "=", sympy.Matrix(known) if len(known) == 3 else known[0])
    return tuple(put(put(x, meaning.along), meaning.steady) for x in components(gap)), derived


def _rates(meaning: Meaning, value: Any) -> tuple[Any, ...]:
    """The rate of what is to be constant; at a steady state its own rate too."""
    rate = lambda x: put(x.diff(meaning.time), meaning.along)  # noqa: E731
    first = [rate(x) for x in components(value)]
    both = [*first, *map(rate, first)] if meaning.steady else first
    return tuple(put(x, meaning.steady) for x in both)


def terms(expression: Any) -> dict[Any, Any]:
    """Monomials of the canonical form with their numbers."""
    ring = Ring()
    plain = ring.to_sympy(ring.from_sympy(sympy.sympify(expression)))
    return dict(sympy.expand(plain).as_coefficients_dict())


def _scale(printed: Any, derived: Any) -> Any:
    """The number between two balances, by the first monomial that they share."""
    mine, other = terms(printed), terms(derived)
    return next((mine[k] / other[k] for k in sorted(other, key=str) if mine.get(k)), sympy.Integer(1))


def _approximated(meaning: Meaning, small: Small, relation: Relation) -> str:
    """The order and size of the error; nothing where it is not smaller than every term that is printed."""
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
    """The terms of a side, brackets around all of it opened."""
    while node.kind == "group":
        node = node.parts[0]
    return node.parts if node.kind == "sum" else (node,)


def _count(wrong: Sequence[int], total: int) -> str:
    """
    >>> _count([2, 3], 4)
    'relations 3 and 4 of 4'
    """
    if total == 1:
        return ""
    numbers = " and ".join(str(i + 1) for i in wrong)
    return f"relation{'s' if len(wrong) > 1 else ''} {numbers} of {total}"


def _tidy(x: Any) -> Any:
    """The canonical form, or it factored: whichever is written shorter."""
    x = sympy.sympify(x)
    if is_zero(x):
        return sympy.Integer(0)
    if x.has(sympy.I):  # the ring is of real numbers
        return x
    ring = Ring()
    plain = ring.to_sympy(ring.from_sympy(x))
    return min((sympy.factor_terms(plain), sympy.factor(plain), x), key=lambda e: len(text_of(e)))


def _written(parts: Sequence[Any], units: Sequence[str]) -> str:
    """Components with their unit vectors; those that are zero are left out."""
    texts = [notation.greek(text_of(_tidy(x))) for x in parts]
    if len(texts) != 3:
        return ", ".join(texts)
    return " + ".join(f"({x}) {u}" for x, u in zip(texts, units, strict=True) if x != "0") or "0"
