"""Names that a request to the equations may contain: those of the model, its accelerations and its reactions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from ...dynamics.conditions.constraints import rows
from ...errors import ExpressionError, ModelError, nearest
from ...scalar.algebra import Expression, Scalar
from ...scalar.expression import exact
from ...scalar.parser import parse
from ..derivation.derivation import Derivation
from ..free_body.gears import radial_symbols
from ..free_body.reaction import unknowns
from ..printing.display import latex


class Vocabulary:
    """Reader of a user's texts and SymPy expressions, which knows a model's names.

    Attributes
    ----------
    names, texts : dict
        Atom by name, and name by atom.
    accelerations, reactions : dict
        Their atoms by name; both are part of ``names``.
    owner : dict
        Joint or constraint of each reaction component.
    """

    def __init__(self, e: Derivation) -> None:
        self.ring = e.ring
        # forces that bound friction in a mode are parameters of the model in this mode alone
        self.names: dict[str, Any] = {p.name: p.symbol for p in e.model.parameters} | dict(
            e.model.names.atoms
        )
        self.accelerations = {speed.name + "'": speed.acceleration for speed in e.model.speeds}
        self.reactions: dict[str, Any] = {}
        self.owner: dict[str, str] = {}
        for joint in e.model.joints:
            for c in unknowns(e.model, e.state, joint):
                self.reactions[c.name] = c.symbol
                self.owner[c.name] = joint
        for row, symbol in zip(rows(e.model), e.multipliers, strict=True):
            self.reactions[row.name] = symbol
            self.owner[row.name] = row.owner
        for gear, symbol in radial_symbols(e).items():
            self.reactions[symbol.name] = symbol
            self.owner[symbol.name] = gear
        self.names |= self.accelerations
        self.names |= self.reactions
        self.texts = {atom: name for name, atom in self.names.items()}

    def extend(self, symbols: Mapping[str, Any]) -> None:
        """Add further symbols by name."""
        self.names |= symbols
        self.texts |= {atom: name for name, atom in symbols.items()}

    def expression(self, value: Expression, what: str) -> Any:
        """Return a number, text or SymPy expression as a SymPy expression of known atoms.

        Raises
        ------
        ModelError
            An unknown name, with the nearest known one.
        """
        try:
            result = parse(value, self.names) if isinstance(value, str) else sympy.sympify(exact(value))
        except (ExpressionError, sympy.SympifyError, TypeError, AttributeError) as error:
            raise ModelError(f"In {what}: {error}") from None
        if not isinstance(result, sympy.Expr):
            raise ModelError(f"In {what}: expected a number or an expression, got {value!r}.")
        return self._with_own_atoms(result, what)

    def _with_own_atoms(self, expression: Any, what: str) -> Any:
        """Return the expression with the model's atoms in place of symbols of the same name."""
        replaced = {}
        for atom in _atoms(expression):
            if atom in self.texts:
                continue
            name = _plain_name(atom)
            if name not in self.names:
                raise ModelError(f"In {what}: unknown name '{name}'; {nearest(name, sorted(self.names))}")
            replaced[atom] = self.names[name]
        return expression.xreplace(replaced) if replaced else expression

    def element(self, value: Expression, what: str) -> Scalar:
        """Return a number, text or SymPy expression as an element of the ring."""
        try:
            return self.ring.from_sympy(self.expression(value, what))
        except ExpressionError as error:
            raise ModelError(f"In {what}: {error}") from None

    def equation(self, value: Any, what: str) -> tuple[str, Scalar]:
        """Return (title, left - right) of a SymPy ``Eq``, a text with "=", a pair, or an expression to be zero."""
        if isinstance(value, sympy.Equality):
            sides: tuple[Any, Any] = (value.lhs, value.rhs)
        elif isinstance(value, str) and value.count("=") == 1:
            left, right = value.split("=")
            sides = (left.strip(), right.strip())
        elif isinstance(value, tuple) and len(value) == 2:
            sides = value
        elif isinstance(value, sympy.Expr) and not value.is_number:
            sides = (value, 0)
        else:
            raise ModelError(
                f"In {what}: expected an equation such as sympy.Eq(T, mu*N) or the text 'T = mu*N', got {value!r}."
            )
        left, right = (self.element(side, what) for side in sides)
        return f"{sides[0]} = {sides[1]}", left - right

    def name(self, expression: Any) -> str:
        """Return the text of an atom, or of an expression of atoms."""
        if expression in self.texts:
            return self.texts[expression]
        named = {atom: sympy.Symbol(self.texts.get(atom, str(atom))) for atom in _atoms(expression)}
        return str(expression.xreplace(named)).replace("**", "^")

    def latex(self, expression: Any) -> str:
        """Return the LaTeX of an expression, with its atoms printed as in the equations."""
        written = {}
        for atom in _atoms(expression):
            written[sympy.Symbol(self.texts.get(atom, str(atom)))] = latex(
                self.ring.generator(atom), self.ring
            )
        named = {atom: sympy.Symbol(self.texts.get(atom, str(atom))) for atom in _atoms(expression)}
        return sympy.latex(expression.xreplace(named), symbol_names=written)


def _atoms(expression: Any) -> set[Any]:
    """Symbols, functions of time and their derivatives, each as one atom."""
    if (
        expression.is_Symbol
        or expression.is_Derivative
        or isinstance(expression, sympy.core.function.AppliedUndef)
    ):
        return {expression}
    atoms: set[Any] = set()
    for argument in expression.args:
        atoms |= _atoms(argument)
    return atoms


def _plain_name(atom: Any) -> str:
    if atom.is_Derivative:
        return _plain_name(atom.expr) + "'" * sum(count for _, count in atom.variable_count)
    return str(atom.func) if atom.args else str(atom)
