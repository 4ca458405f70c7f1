"""A request to the equations: its unknowns, its values, and all equations as rows of polynomials in the unknowns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from ...errors import ExpressionError, ModelError, TooManyTermsError
from ...scalar.algebra import Expression, Scalar
from ...scalar.element import Polynomial
from ...scalar.ratio import Ratio
from ...scalar.substitute import Substitution
from ..derivation.derivation import Derivation
from ..printing.systems import Row, Terms, collect
from .vocabulary import Vocabulary


@dataclass(frozen=True)
class Unknown:
    """An unknown: its name, its SymPy expression, and the keys in the rows that represent it.

    The key is the name itself; a coordinate that occurs only in its sine and cosine has these as keys.
    """

    name: str
    expression: Any
    keys: tuple[str, ...]


class Request:
    """The rows and unknowns of one request.

    Attributes
    ----------
    unknowns : list of Unknown
    places : dict
        Generator of the ring -> (key, power of the generator that the key stands for).
    values : dict
        Values by atom, from ``where``.
    equations : list
        (title, x) of the equations x = 0.
    angles : list of Unknown
        Unknown coordinates that occur only in their sine and cosine.
    """

    def __init__(self, e: Derivation, vocabulary: Vocabulary | None = None) -> None:
        self.e = e
        self.ring = e.ring
        self.vocabulary = vocabulary or Vocabulary(e)
        self.unknowns: list[Unknown] = []
        self.places: dict[int, tuple[str, int]] = {}
        self.values: dict[Any, Scalar] = {}
        self.equations: list[tuple[str, Scalar]] = []
        self.angles: list[Unknown] = []

    # -- unknowns -----------------------------------------------------------------------------------

    def read_unknowns(self, unknowns: Any) -> None:
        """Read one unknown or a sequence of them: names, atoms, ``theta'^2``, ``cos(theta)``."""
        single = isinstance(unknowns, str | sympy.Basic) and not isinstance(unknowns, sympy.Tuple)
        if not single and not isinstance(unknowns, Iterable):
            raise ModelError(f"Expected the names of unknowns, such as 'pin_x', got {unknowns!r}.")
        for unknown in [unknowns] if single else list(unknowns):
            if isinstance(unknown, sympy.Symbol) and unknown.name not in self.vocabulary.names:
                self.vocabulary.extend({unknown.name: unknown})
            expression = self.vocabulary.expression(unknown, "the unknowns")
            self._add_unknown(self.vocabulary.name(expression), expression)
        if not self.unknowns:
            raise ModelError("Expected at least one unknown to solve for, such as 'pin_x'.")

    def _add_unknown(self, name: str, expression: Any) -> None:
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
            raise ModelError("The time cannot be an unknown: the equations hold at an instant.")
        if g.kind not in ("sin", "cos") and g.atom is None:
            raise ModelError(f"'{name}' cannot be an unknown; ask for a name that it contains.")
        self.places[g.index] = (name, int(power))
        self.unknowns.append(Unknown(name, expression, (name,)))
        if g.kind == "coordinate":
            for kind in ("sin", "cos"):
                self.ring.apply(kind, x)
        elif g.kind in ("sin", "cos"):
            self._add_partner(g)

    def _add_partner(self, g: Any) -> None:
        """Add the cosine of an unknown sine to the unknown generators, or the sine of an unknown cosine."""
        partner = self.ring.generators[g.partner] if g.partner >= 0 else None
        if partner is not None and partner.index not in self.places:
            name = self.vocabulary.name(self.ring.to_sympy(self.ring.variable(partner.index)))
            self.places[partner.index] = (name, 1)

    # -- values and equations -----------------------------------------------------------------------

    def read_where(self, where: Any) -> None:
        """Read values and equations: a mapping, an equation, a text, or a sequence of them."""
        if where is None:
            return
        if isinstance(where, Mapping):
            for key, value in where.items():
                self._add_value(key, value)
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
                for part in where:
                    self.read_where(part)
        else:
            raise ModelError(
                f"Expected values by name such as {{'pin_y': 0}}, or equations, for where, got {where!r}."
            )

    def _add_value(self, key: Any, value: Expression) -> None:
        """Add a value; if it defines no atom explicitly, add an equation."""
        left = self.vocabulary.expression(key, "where")
        right = self.vocabulary.element(value, "where")
        name = self.vocabulary.name(left)
        if name in self.value_names:
            raise ModelError(f"'{name}' is given twice in where. Leave one out.")
        right = self._substituted(right, self.values)
        g = self.ring.find(left)
        is_atom = left in self.vocabulary.texts
        index = -1 if g is None else g.index
        implicit = type(right) is Polynomial and left in right.atoms()
        if not is_atom or index in self.places or implicit:
            self.equations.append((f"{name} = {value}", self.ring.from_sympy(left) - right))
            return
        try:
            self.values = {k: self._substituted(v, {left: right}) for k, v in self.values.items()}
        except (ExpressionError, ZeroDivisionError) as error:
            raise ModelError(f"With {name} = {value}: {error}") from None
        self.values[left] = right

    def _substituted(self, x: Scalar, values: Mapping[Any, Scalar]) -> Scalar:
        return Substitution(self.ring, self.ring, values)(x) if values else x

    @property
    def value_names(self) -> set[str]:
        """Names that have a value."""
        return {self.vocabulary.texts[atom] for atom in self.values}

    # -- rows ---------------------------------------------------------------------------------------

    def add(self, title: str, x: Scalar) -> None:
        """Add the equation x = 0."""
        self.equations.append((title, x))

    def rows(self, hidden: Mapping[str, Any]) -> list[Row]:
        """Return all equations as polynomials in the unknowns.

        Parameters
        ----------
        hidden : mapping
            Name -> atom of further unknowns, which are to be eliminated.
        """
        places = dict(self.places)
        for name, symbol in hidden.items():
            g = self.ring.find(symbol)
            if g is not None:
                places.setdefault(g.index, (name, 1))
        values = Substitution(self.ring, self.ring, self.values)
        equations = []
        for title, x in self.equations:
            try:
                equations.append((title, values(x) if self.values else x))
            except (ExpressionError, ZeroDivisionError) as error:
                raise ModelError(f"With the values in where, '{title}' has no value: {error}") from None
        self._replace_angles(equations, places)
        rows = []
        for title, x in equations:
            rows.append(Row(title, self._collected(title, x, places)))
        rows += self._unit_circles(rows, places)
        return rows

    def _replace_angles(
        self, equations: Sequence[tuple[str, Scalar]], places: dict[int, tuple[str, int]]
    ) -> None:
        """Replace an unknown coordinate by its sine and cosine if it occurs in these only."""
        self.angles = []
        for i, unknown in enumerate(self.unknowns):
            g = self.ring.find(unknown.expression)
            if g is None or g.kind != "coordinate":
                continue
            plain = any(type(x) is Polynomial and g in self.ring.used(x) for _, x in equations)
            keys = []
            for other in list(self.ring.generators):
                of_angle = other.kind in ("sin", "cos") and other.depends >> g.index & 1
                inside = any(type(x) is Polynomial and other in self.ring.used(x) for _, x in equations)
                if not of_angle or not inside:
                    continue
                if plain or other.arguments != (self.ring.variable(g.index),):
                    raise ModelError(
                        f"'{unknown.name}' occurs inside and outside of sines, or in sines of several arguments: "
                        f"there is no closed form. Ask for something else, or give '{unknown.name}' a value."
                    )
                key = f"{other.kind}({unknown.name})"
                places[other.index] = (key, 1)
                keys.append(key)
            if keys:
                del places[g.index]
                self.unknowns[i] = Unknown(unknown.name, unknown.expression, tuple(sorted(keys)))
                self.angles.append(self.unknowns[i])

    def _collected(self, title: str, x: Scalar, places: Mapping[int, tuple[str, int]]) -> Terms:
        """Return an equation as a polynomial in the unknowns, or refuse it."""
        try:
            terms = collect(x, places, self.ring)
        except TooManyTermsError:
            raise
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
                            f"In '{title}' the unknown '{atom}' occurs inside {inside}: there is "
                            f"no closed form. Give '{atom}' a value, or ask for something else."
                        )
        return terms

    def _unit_circles(self, rows: Sequence[Row], places: Mapping[int, tuple[str, int]]) -> list[Row]:
        """Rows sin² + cos² = 1 for the unknown sines and cosines that both occur."""
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
