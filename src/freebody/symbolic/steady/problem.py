"""Conditions of steady motion: the equations of motion at constant rates and constant coordinates.

A motion is steady if it runs along a symmetry of the machine: the speeds are u = Σ w_a ξ_a with constant rates w_a,
where ξ_a are constant directions in the coordinates along which no equation of motion changes:

    E_k(q, u = Σ w_a ξ_a, u' = 0) = 0,        φ_i(q) = 0.

Conditions on speeds are satisfied by dependent speeds, so that their forces drop out.

Source: J. E. Marsden, Lectures on Mechanics (1992), chapter 4; chapter 6, §6.9.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations
from typing import TYPE_CHECKING, Any

import sympy

from ...dynamics.conditions.constraints import rows
from ...dynamics.linear import scalar_product
from ...errors import ModelError
from ...scalar.algebra import Expression, Scalar, divide
from ...scalar.polynomial import Polynomial, Ring
from ...scalar.substitute import Substitution
from ..derivation.along_motion import residuals_of
from ..derivation.contact_modes import sticking_only
from ..derivation.determinant import determinant
from ..integrals.symmetry import solved
from .factors import cleared

if TYPE_CHECKING:
    from ..equations import Equations


class Problem:
    """The canonical conditions of the steady motions of a system.

    Attributes
    ----------
    residuals : tuple
        Equations of motion E_k = 0 of the independent speeds ``free``.
    families : list of dict
        Symmetries ξ: index of a speed -> coefficient; the first index names the rate.
    unknowns : tuple of atoms
        Multipliers, rates and coordinates, in the order in which they are solved for.
    exact : list
        What is zero on a steady motion, with denominators.
    conditions : tuple
        The numerators of ``exact``, polynomials, without trivial ones.
    """

    def __init__(self, e: Equations, terms: Mapping[Any, Expression] | None = None) -> None:
        self.e = e
        self.ring: Ring = e.ring
        model = e.model
        self.coordinates = [c.symbol for c in model.coordinates]
        names = [c.name for c in model.coordinates]
        self.coordinate_of = [names.index(s.name.removesuffix("'")) for s in model.speeds]
        self._eliminate()
        self._refuse_time()
        self.families = self._symmetries()
        self.pivots = tuple(next(iter(family)) for family in self.families)
        self.gauge = {self.coordinates[self.coordinate_of[j]] for j in self.pivots}
        self.rates = tuple(model.speeds[j].symbol for j in self.pivots)
        values: dict[Any, Scalar] = {speed.acceleration: 0 for speed in model.speeds}
        values.update({speed.symbol: 0 for speed in model.speeds})
        for family, rate in zip(self.families, self.rates, strict=True):
            w = self.ring.generator(rate)
            for j, factor in family.items():
                values[model.speeds[j].symbol] = values[model.speeds[j].symbol] + factor * w
        values.update(dict.fromkeys(self.gauge, 0))
        self.steady_values = values
        at = Substitution(self.ring, self.ring, values)
        used = frozenset().union(*(self.ring.atoms_of(x) for x in (*self.residuals, *self.closing)))
        # a coordinate with a dependent speed must be constant if an equation depends on it
        self.coupled = tuple(j for j in self.dependent if self.coordinates[self.coordinate_of[j]] in used)
        coupled_speeds = [self.dependent[j] for j in self.coupled]
        conditions = [at(E) for E in (*self.residuals, *self.closing, *coupled_speeds)]
        self.terms: dict[Any, Any] = {}  # new name's symbol -> its value in rates and coordinates
        self.replaced: dict[Any, Any] = {}  # rate -> its value with the new names
        for key, value in (terms or {}).items():
            self._introduce(key, value)
        again = Substitution(self.ring, self.ring, self.replaced)
        self.exact = [again(x) for x in conditions]
        self.conditions = tuple(x for x in (cleared(self.ring, c) for c in self.exact) if x != 0)
        self.unknowns = self._unknowns()

    # -- set-up -----------------------------------------------------------------------------------

    def _eliminate(self) -> None:
        """Form the residuals of the independent speeds, without the forces of conditions on speeds."""
        e = self.e
        sticking_only(e.conditions, "A search for steady motions")
        kinds = rows(e.model)
        on_coordinates = [i for i, kind in enumerate(kinds) if not kind.on_speeds]
        rolling = [i for i, kind in enumerate(kinds) if kind.on_speeds]
        self.closing = tuple(
            e.conditions.residual[i] for i in on_coordinates if e.conditions.residual[i] != 0
        )
        self.matrix = [
            e.conditions.matrix[i] for i in on_coordinates if any(x != 0 for x in e.conditions.matrix[i])
        ]
        self.multipliers = [
            e.multipliers[i] for i in on_coordinates if any(x != 0 for x in e.conditions.matrix[i])
        ]
        n = e.model.n_u
        self.dependent: dict[int, Scalar] = {}
        if not rolling:
            self.free = tuple(range(n))
            self.residuals = residuals_of(e)
            return
        no_force = Substitution(e.ring, e.ring, {e.multipliers[i]: 0 for i in rolling})
        E = [no_force(x) for x in residuals_of(e)]
        G = [e.conditions.matrix[i] for i in rolling]
        dependent = self._dependent_speeds(E, G)
        self.free = tuple(j for j in range(n) if j not in dependent)
        u, udot = e.state.u, e.udot

        def solve(values: Sequence[Scalar], right: Sequence[Scalar]) -> tuple[Any, ...]:
            balance = [
                ({j: x for j, x in enumerate(row) if x != 0}, r) for row, r in zip(G, right, strict=True)
            ]
            result = solved(n, balance, {k: values[k] for k in self.free})
            assert result is not None
            return result

        drift = [e.conditions.rate[i] - scalar_product(row, u) for i, row in zip(rolling, G, strict=True)]
        speeds = solve(u, [-x for x in drift])
        first = Substitution(e.ring, e.ring, {e.model.speeds[j].symbol: speeds[j] for j in dependent})
        accelerations = solve(udot, [-first(e.conditions.bias[i]) for i in rolling])
        values = {e.model.speeds[j].symbol: speeds[j] for j in dependent}
        values.update({e.model.speeds[j].acceleration: accelerations[j] for j in dependent})
        at = Substitution(e.ring, e.ring, values)
        put_in = [at(x) for x in E]
        self.dependent = {j: speeds[j] for j in dependent}
        result = []
        for k in self.free:
            total = put_in[k]
            for j in dependent:
                total = total + e.ring.derivative(speeds[j], e.model.speeds[k].symbol) * put_in[j]
            result.append(total)
        self.residuals = tuple(result)

    def _dependent_speeds(self, E: Sequence[Scalar], G: Sequence[Sequence[Scalar]]) -> tuple[int, ...]:
        """Choose speeds that the conditions determine, preferring coordinates on which no equation depends."""
        e = self.e
        used = frozenset().union(*(e.ring.atoms_of(x) for x in (*E, *(x for row in G for x in row))))
        order = sorted(range(e.model.n_u), key=lambda j: self.coordinates[self.coordinate_of[j]] in used)
        best: tuple[int, tuple[int, ...]] | None = None
        for candidate in combinations(order, len(G)):
            det = determinant([[row[j] for j in candidate] for row in G])
            size = len(det) if isinstance(det, Polynomial) else 0
            if det != 0 and (best is None or size < best[0]):
                best = (size, tuple(sorted(candidate)))
            if best is not None and best[0] == 0:  # the determinant is a number: no division
                break
        if best is not None:
            return best[1]
        raise ModelError(
            "The conditions on speeds depend on each other, so that they determine no speeds. Leave one out."
        )

    def _refuse_time(self) -> None:
        t = self.e.model.names.atoms["t"]
        for k, E in zip(self.free, self.residuals, strict=True):
            if t in self.ring.atoms_of(E):
                raise ModelError(
                    f"'{self.e.model.name}' has no steady motion: the equation of {self.e.model.speed_names[k]} "
                    f"depends on the time. Remove loads and drives that change with time, or turn with them."
                )

    def _symmetries(self) -> list[dict[int, Fraction]]:
        """Return the constant ξ with Σ ξ_j ∂E_k/∂q_j = 0 for all k, in echelon form."""
        e = self.e
        basis: dict[int, dict[int, Fraction]] = {}  # leading speed -> row of the derivatives' row space
        for E in (*self.residuals, *self.closing):
            table: dict[Any, dict[int, Fraction]] = {}
            for j in self.free:
                d = e.ring.derivative(E, self.coordinates[self.coordinate_of[j]])
                if type(d) is Polynomial:
                    for monomial, c in d.terms():
                        table.setdefault(monomial, {})[j] = Fraction(c, d.den)
                elif d != 0:
                    table.setdefault((), {})[j] = Fraction(d)
            for row in table.values():
                _insert(basis, row)
        result = []
        for j in self.free:
            if j in basis:
                continue
            family = {j: Fraction(1)}
            for lead, row in basis.items():
                if row.get(j):
                    family[lead] = -row[j]
            result.append(family)
        return result

    def _introduce(self, key: Any, value: Expression) -> None:
        """Introduce a new name for a combination of rates, in place of one of them."""
        names = self.e.model.names
        name = str(key)
        symbol = names.atoms.get(name, sympy.Symbol(name, real=True))
        x = self.e.state(names.expression(value, f"the term '{name}'"))
        x = Substitution(self.ring, self.ring, {**self.replaced})(x)
        for rate in reversed(self.rates):
            c = self.ring.derivative(x, rate)
            if rate in self.replaced or isinstance(c, Polynomial) or c == 0:
                continue
            others = x - c * self.ring.generator(rate)
            new = divide(self.ring.generator(symbol, "parameter") - others, c)
            step = Substitution(self.ring, self.ring, {rate: new})
            self.replaced = {old: step(y) for old, y in self.replaced.items()} | {rate: new}
            self.terms[symbol] = x
            return
        rates = ", ".join(self.name(rate) for rate in self.rates) or "none"
        raise ModelError(
            f"Expected the term '{name}' to hold a rate of this steady motion with a number in front, got '{value}'. "
            f"The rates are: {rates}."
        )

    def _unknowns(self) -> tuple[Any, ...]:
        used = frozenset().union(*(self.ring.atoms_of(x) for x in self.conditions), ())
        rates = [rate for rate in self.rates if rate not in self.replaced]
        q = [c for c in self.coordinates if c not in self.gauge]
        order = [*self.multipliers, *rates, *q, *self.terms]
        return tuple(atom for atom in order if atom in used)

    @property
    def named(self) -> tuple[Any, ...]:
        """The unknowns, and the rates and terms that do not occur in the conditions and may have any value."""
        more = [a for a in (*self.rates, *self.terms) if a not in self.replaced and a not in self.unknowns]
        return (*self.unknowns, *more)

    # -- numbers ----------------------------------------------------------------------------------

    short = True
    """True if a closed form is sought."""

    def defaults(self) -> dict[Any, Any]:
        """Return numbers for atoms of this problem that nothing determines."""
        return {}

    def completed(self, full: Mapping[Any, Any]) -> dict[Any, Any]:
        """Return numbers for coordinates that follow from others on a steady motion."""
        return {}

    def distinct(self, states: Sequence[Any], atoms: Mapping[Any, Any]) -> Sequence[Any]:
        """Return one of each set of states that symmetries map to each other."""
        return states

    # -- names ------------------------------------------------------------------------------------

    def name(self, atom: Any) -> str:
        """Return the name of an unknown."""
        return self.e.model.names.texts.get(atom, str(atom))

    def atom(self, name: Any, atoms: Sequence[Any]) -> Any:
        """Return the unknown with that name or symbol, or None."""
        return next((a for a in atoms if name == a or str(name) == self.name(a)), None)


def _insert(basis: dict[int, dict[int, Fraction]], row: dict[int, Fraction]) -> None:
    """Add a row to a reduced echelon basis; its last column leads, so that the first coordinates name the families."""
    row = dict(row)
    for lead, other_row in basis.items():
        c = row.get(lead)
        if c:
            row = _combined(row, other_row, -c)
    row = {j: c for j, c in row.items() if c}
    if not row:
        return
    lead = max(row)
    row = {j: c / row[lead] for j, c in row.items()}
    for other, other_row in list(basis.items()):
        if other_row.get(lead):
            basis[other] = _combined(other_row, row, -other_row[lead])
    basis[lead] = row


def _combined(a: dict[int, Fraction], b: dict[int, Fraction], c: Fraction) -> dict[int, Fraction]:
    result = dict(a)
    for j, x in b.items():
        result[j] = result.get(j, Fraction(0)) + c * x
    return {j: x for j, x in result.items() if x}
