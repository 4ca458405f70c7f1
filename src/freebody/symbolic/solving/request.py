"""A question to the equations, read: its unknowns, its values, and all equations as rows of polynomials."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from ...errors import ExpressionError, ModelError
from ...scalar.element import Polynomial
from ...scalar.ratio import Ratio
from ...scalar.substitute import Substitution
from ..derivation.derivation import Derivation
from ..printing.systems import Row, collect
from .vocabulary import Vocabulary


@dataclass(frozen=True)
class Unknown:
    """An unknown: its name, its SymPy expression, and the keys of what stands for it in the rows."""

    name: str
    expression: Any
    keys: tuple[str, ...]


class Request:
    """The rows and unknowns of one question."""

    def __init__(self, e: Derivation, vocabulary: Vocabulary | None = None) -> None:
        self.e = e
        self.ring = e.ring
        self.vocabulary = vocabulary or Vocabulary(e)
        self.asked: list[Unknown] = []
        self.places: dict[int, tuple[str, int]] = {}
        """Generator of the ring -> (key, power that the key stands for)."""
        self.fixed: dict[Any, Any] = {}
        self.equations: list[tuple[str, Any]] = []
        self.angles: list[Unknown] = []

    # -- unknowns -----------------------------------------------------------------------------------

    def ask(self, unknowns: Any) -> None:
        """Read what is asked for: names, atoms, ``theta'^2``, ``cos(theta)``; one or a sequence."""
        one = isinstance(unknowns, str | sympy.Basic) and not isinstance(unknowns, sympy.Tuple)
        if not one and not isinstance(unknowns, Iterable):
            raise ModelError(f"Expected the names of unknowns, such as 'pin_x', got {unknowns!r}.")
        for given in [unknowns] if one else list(unknowns):
            if isinstance(given, sympy.Symbol) and given.name not in self.vocabulary.names:
                self.vocabulary.also({given.name: given})
            expression = self.vocabulary.expression(given, "the unknowns")
            self._ask(self.vocabulary.name(expression), expression)
        if not self.asked:
            raise ModelError("Expected at least one unknown to solve for, such as 'pin_x'.")

    def _ask(self, name: str, expression: Any) -> None:
        base, power = (expression.base, expression.exp) if expression.is_Pow else (expression, 1)
        x = self.ring.from_sympy(base)
        single = type(x) is Polynomial and len(x) == 1 and x.den == 1 and x.num.total_degree() == 1
        if not single or x.num.leading_coefficient() != 1 or not (power == int(power) > 0):
            raise ModelError(
                f"Expected a name, a square such as theta'^2, or a sine or cosine of a coordinate as an unknown, "
                f"got '{name}'."
            )
        (g,) = self.ring.used(x)
        if g.index in self.places:
            raise ModelError(f"'{name}' is asked for twice.")
        if g.kind == "time":
            raise ModelError("The time can not be an unknown: the equations hold at an instant.")
        if g.kind not in ("sin", "cos") and g.atom is None:
            raise ModelError(f"'{name}' can not be an unknown; ask for what stands in it.")
        self.places[g.index] = (name, int(power))
        self.asked.append(Unknown(name, expression, (name,)))
        if g.kind == "coordinate":
            for kind in ("sin", "cos"):
                self.ring.apply(kind, x)
        elif g.kind in ("sin", "cos"):
            self._partner(g)

    def _partner(self, g: Any) -> None:
        other = self.ring.generators[g.partner] if g.partner >= 0 else None
        if other is not None and other.index not in self.places:
            self.places[other.index] = (self._text_of(other), 1)

    def _text_of(self, g: Any) -> str:
        return self.vocabulary.name(self.ring.to_sympy(self.ring.variable(g.index)))

    # -- values and equations -----------------------------------------------------------------------

    def fix(self, where: Any) -> None:
        """Read values and equations: a mapping, an equation, a text, or a sequence of them."""
        if where is None:
            return
        if isinstance(where, Mapping):
            for key, value in where.items():
                self._fix(key, value)
        elif isinstance(where, str | sympy.Basic):
            self.equations.append(self.vocabulary.equation(where, "where"))
        elif isinstance(where, Iterable):
            pair = (
                isinstance(where, tuple)
                and len(where) == 2
                and not isinstance(where[0], Mapping | sympy.Equality)
            )
            if pair and not all(isinstance(x, str) and "=" in x for x in where):
                self.equations.append(self.vocabulary.equation(where, "where"))
            else:
                for one in where:
                    self.fix(one)
        else:
            raise ModelError(
                f"Expected values by name such as {{'pin_y': 0}}, or equations, for where, got {where!r}."
            )

    def _fix(self, key: Any, value: Any) -> None:
        left = self.vocabulary.expression(key, "where")
        right = self.vocabulary.element(value, "where")
        name = self.vocabulary.name(left)
        if name in self.fixed_names:
            raise ModelError(f"'{name}' is given twice in where. Leave one out.")
        right = self._valued(right, self.fixed)
        g = self.ring.find(left)
        known = left in self.vocabulary.texts
        index = -1 if g is None else g.index
        within = type(right) is Polynomial and left in right.atoms()
        if not known or index in self.places or within:
            self.equations.append((f"{name} = {value}", self.ring.from_sympy(left) - right))
            return
        try:
            self.fixed = {k: self._valued(v, {left: right}) for k, v in self.fixed.items()}
        except (ExpressionError, ZeroDivisionError) as error:
            raise ModelError(f"With {name} = {value}: {error}") from None
        self.fixed[left] = right

    def _valued(self, x: Any, values: Mapping[Any, Any]) -> Any:
        return Substitution(self.ring, self.ring, values)(x) if values else x

    @property
    def fixed_names(self) -> set[str]:
        """Names that have a value."""
        return {self.vocabulary.texts[atom] for atom in self.fixed}

    # -- rows ---------------------------------------------------------------------------------------

    def add(self, title: str, x: Any) -> None:
        """Add the equation x = 0."""
        self.equations.append((title, x))

    def rows(self, hidden: Mapping[str, Any]) -> list[Row]:
        """All equations as polynomials in the unknowns; ``hidden`` are names -> atoms to eliminate."""
        places = dict(self.places)
        for name, symbol in hidden.items():
            g = self.ring.find(symbol)
            if g is not None:
                places.setdefault(g.index, (name, 1))
        fixed = Substitution(self.ring, self.ring, self.fixed)
        valued = []
        for title, x in self.equations:
            try:
                valued.append((title, fixed(x) if self.fixed else x))
            except (ExpressionError, ZeroDivisionError) as error:
                raise ModelError(f"With the values in where, '{title}' has none: {error}") from None
        self._angles(valued, places)
        rows = []
        for title, x in valued:
            rows.append(Row(title, self._collected(title, x, places)))
        rows += self._circles(rows, places)
        return rows

    def _angles(self, valued: Sequence[tuple[str, Any]], places: dict[int, tuple[str, int]]) -> None:
        """A coordinate that only stands in its sine and cosine is found from these."""
        self.angles = []
        for i, unknown in enumerate(self.asked):
            g = self.ring.find(unknown.expression)
            if g is None or g.kind != "coordinate":
                continue
            plain = any(type(x) is Polynomial and g in self.ring.used(x) for _, x in valued)
            keys = []
            for other in list(self.ring.generators):
                turned = other.kind in ("sin", "cos") and other.depends >> g.index & 1
                inside = any(type(x) is Polynomial and other in self.ring.used(x) for _, x in valued)
                if not turned or not inside:
                    continue
                if plain or other.arguments != (self.ring.variable(g.index),):
                    raise ModelError(
                        f"'{unknown.name}' stands inside and outside of sines, or in sines of several arguments: "
                        f"there is no closed form. Ask for something else, or give '{unknown.name}' a value."
                    )
                key = f"{other.kind}({unknown.name})"
                places[other.index] = (key, 1)
                keys.append(key)
            if keys:
                del places[g.index]
                self.asked[i] = Unknown(unknown.name, unknown.expression, tuple(sorted(keys)))
                self.angles.append(self.asked[i])

    def _collected(self, title: str, x: Any, places: Mapping[int, tuple[str, int]]) -> Any:
        try:
            terms = collect(x, places, self.ring)
        except ValueError as error:
            g = self.ring.generators[error.args[0]]
            name = places[g.index][0]
            raise ModelError(
                f"'{title}' has other powers of {g.atom} than '{name}'. Ask for {g.atom} itself."
            ) from None
        mask = 0
        for index in places:
            mask |= self.ring.generators[index].depends
        for c in terms.values():
            for part in (c.num, c.den):
                for g in self.ring.used(part) if type(part) is Polynomial else ():
                    if g.depends & mask and g.index not in places:
                        atom = next(
                            places[i][0] for i in places if self.ring.generators[i].depends & g.depends
                        )
                        inside = self.ring.text(self.ring.variable(g.index))
                        raise ModelError(
                            f"In '{title}' the unknown '{atom}' stands inside {inside}: there is "
                            f"no closed form. Give '{atom}' a value, or ask for something else."
                        )
        return terms

    def _circles(self, rows: Sequence[Row], places: Mapping[int, tuple[str, int]]) -> list[Row]:
        """sin² + cos² = 1 where both occur."""
        present: set[str] = set()
        for row in rows:
            present |= row.unknowns
        result = []
        for index, (key, _) in places.items():
            g = self.ring.generators[index]
            if g.kind != "sin" or g.partner not in places:
                continue
            other = places[g.partner][0]
            if key in present and other in present:
                one = Ratio(self.ring, 1)
                result.append(Row("sin^2 + cos^2 = 1", {((key, 2),): one, ((other, 2),): one, (): -one}))
        return result
