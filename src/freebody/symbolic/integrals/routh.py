"""Routh's reduction: elimination of ignorable coordinates by their constant momenta.

With the ignorable speeds w, the momenta p = A w + b and T = ½ wᵀ A w + wᵀ b + T_rest,

    w = A⁻¹ (p - b),        R = T_rest - ½ (p - b)ᵀ A⁻¹ (p - b) - V,        d/dt ∂R/∂q' - ∂R/∂q = Q

for the other coordinates. -R at rest, V + ½ (p - b)ᵀ A⁻¹ (p - b), is the amended potential.

Source: H. Goldstein et al., Classical Mechanics, 3rd ed., §8.3 (R with the sign of L).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy

from ...errors import ModelError
from ...scalar.algebra import HALF, Scalar, divide
from ...scalar.substitute import Substitution
from ..derivation.along_motion import momenta, rate_of, residuals_of
from ..derivation.derivation import Derivation
from ..derivation.determinant import determinant
from ..printing.display import Formulas
from ..printing.lines import EQUALS, Lines, Name
from .conserved_quantities import integrals


def routh(e: Derivation) -> Routh:
    """Eliminate all ignorable coordinates.

    Returns
    -------
    Routh

    Raises
    ------
    ModelError
        No coordinate is ignorable.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("spherical pendulum")
    >>> m, L, g = s.parameters(m=1, L=1, g=9.81)
    >>> s.gravity = (0, 0, -g)
    >>> bob = s.body("bob", fb.particle(m))
    >>> arm = s.universal("arm", s.ground, bob, to=(0, 0, L), axis=("z", "x"), coordinate="psi theta")
    >>> print(fb.equations(s).routh().text())
    R = m*L^2*theta'^2/2 + m*L*g*cos(theta) - p_psi^2/(2*m*L^2*sin(theta)^2)
    m*L^2*theta'' + m*L*g*sin(theta) - p_psi^2*cos(theta)/(m*L^2*sin(theta)^3) = 0
    psi' = p_psi/(m*L^2*sin(theta)^2)
    """
    return Routh(e, ignorable(e))


def ignorable(e: Derivation) -> tuple[int, ...]:
    """Indices of the speeds of ignorable coordinates, whose momenta are proven to be conserved."""
    result = []
    names = {name.removeprefix("momentum of ") for x in integrals(e) for name in (x.name, *x.also)}
    for j, name in enumerate(e.model.speed_names):
        if name.endswith("'") and name.removesuffix("'") in names:
            result.append(j)
    return tuple(result)


@dataclass(frozen=True)
class Recovery(Lines):
    """One ignorable coordinate: its momentum's symbol, its momentum by the speeds, its speed by the momenta."""

    coordinate: str
    symbol: Any
    momentum: Any
    speed: Any

    def _lines(self) -> list[list[Any]]:
        return [[self.symbol, EQUALS, self.momentum], [Name(f"{self.coordinate}'"), EQUALS, self.speed]]


class Routh(Formulas):
    """The reduced system. Made by ``fb.equations(s).routh()``.

    Attributes
    ----------
    coordinates : tuple of str
        The remaining coordinates.
    ignorable : tuple of str
        The eliminated coordinates.
    momenta : tuple of Symbol
        Constant momenta of the eliminated coordinates: ``p_psi``.
    """

    def __init__(self, e: Derivation, chosen: Sequence[int]) -> None:
        self._e = e
        if not chosen:
            raise ModelError(
                f"No coordinate of '{e.model.name}' is ignorable, so there is nothing to reduce: the momentum of each "
                f"coordinate changes. The conserved quantities are in fb.equations(...).integrals."
            )
        self._chosen = tuple(chosen)
        self._rest = tuple(j for j in range(e.model.n_u) if j not in chosen)
        names = e.model.speed_names
        self.ignorable = tuple(names[j].removesuffix("'") for j in chosen)
        self.coordinates = tuple(names[j].removesuffix("'") for j in self._rest)
        self.momenta = tuple(self._symbol(name) for name in self.ignorable)
        self.canonical_momenta = tuple(e.ring.generator(symbol, "parameter") for symbol in self.momenta)

    def _symbol(self, coordinate: str) -> Any:
        name = f"p_{coordinate}"
        while name in self._e.model.names.kinds:
            name += "_"
        return sympy.Symbol(name, real=True)

    @cached_property
    def block(self) -> tuple[tuple[Any, ...], ...]:
        """A, the ignorable block of the mass matrix, canonical."""
        M = self._e.canonical_mass_matrix
        return tuple(tuple(M[i][j] for j in self._chosen) for i in self._chosen)

    @cached_property
    def _momenta_at_rest(self) -> tuple[Scalar, ...]:
        """b: the momenta if the ignorable speeds are zero."""
        zero = {self._e.model.speeds[j].symbol: 0 for j in self._chosen}
        at = Substitution(self._e.ring, self._e.ring, zero)
        return tuple(at(momenta(self._e)[j]) for j in self._chosen)

    @cached_property
    def canonical_speeds(self) -> tuple[Any, ...]:
        """w = A⁻¹ (p - b), canonical, by determinants with one division each."""
        A, right = (
            self.block,
            [p - b for p, b in zip(self.canonical_momenta, self._momenta_at_rest, strict=True)],
        )
        det = determinant(A)
        result = []
        for k in range(len(A)):
            replaced = [[*row[:k], x, *row[k + 1 :]] for row, x in zip(A, right, strict=True)]
            result.append(divide(determinant(replaced), det))
        return tuple(result)

    @cached_property
    def canonical_routhian(self) -> Any:
        """R = T - V - Σ p w as a canonical polynomial in the remaining coordinates and speeds, and the momenta."""
        e = self._e
        at = Substitution(e.ring, e.ring, {e.model.speeds[j].symbol: 0 for j in self._chosen})
        T = at(e.energy.canonical_kinetic)
        for p, b, w in zip(self.canonical_momenta, self._momenta_at_rest, self.canonical_speeds, strict=True):
            T = T - HALF * (p - b) * w
        return T - e.energy.canonical_potential

    @cached_property
    def canonical_amended_potential(self) -> Any:
        """V + ½ (p - b)ᵀ A⁻¹ (p - b): minus the Routhian with the remaining coordinates at rest."""
        e = self._e
        rest = Substitution(e.ring, e.ring, {e.model.speeds[j].symbol: 0 for j in self._rest})
        return -rest(self.canonical_routhian)

    @cached_property
    def _recovered(self) -> Substitution:
        """Substitution of w and w' by the remaining coordinates; w' is the rate of w along the motion."""
        e = self._e
        values: dict[Any, Any] = {}
        for j, w in zip(self._chosen, self.canonical_speeds, strict=True):
            values[e.model.speeds[j].symbol] = w
        speeds = Substitution(e.ring, e.ring, values)
        for j, w in zip(self._chosen, self.canonical_speeds, strict=True):
            values[e.model.speeds[j].acceleration] = speeds(rate_of(e, w))
        return Substitution(e.ring, e.ring, values)

    @cached_property
    def canonical_equations(self) -> tuple[Any, ...]:
        """E_j of the remaining coordinates, with w and w' substituted; zero along every motion."""
        residuals = residuals_of(self._e)
        return tuple(self._recovered(residuals[j]) for j in self._rest)

    # -- SymPy at the edge ------------------------------------------------------------------------

    @cached_property
    def routhian(self) -> Any:
        """R as a SymPy expression."""
        return self._e.displayed(self.canonical_routhian)

    @cached_property
    def amended_potential(self) -> Any:
        """V + ½ (p - b)ᵀ A⁻¹ (p - b), with the remaining coordinates at rest, as a SymPy expression."""
        return self._e.displayed(self.canonical_amended_potential)

    @cached_property
    def equations(self) -> tuple[Any, ...]:
        """The reduced equations of motion as SymPy ``Eq``, one per remaining coordinate."""
        return tuple(sympy.Eq(self._e.displayed(x), 0, evaluate=False) for x in self.canonical_equations)

    @cached_property
    def recovery(self) -> dict[str, Recovery]:
        """For each ignorable coordinate: its momentum by the speeds, and its speed by the momenta."""
        e = self._e
        result = {}
        for k, j in enumerate(self._chosen):
            name = self.ignorable[k]
            result[name] = Recovery(
                name, self.momenta[k], e.displayed(momenta(e)[j]), e.displayed(self.canonical_speeds[k])
            )
        return result

    # -- display ----------------------------------------------------------------------------------

    def _lines(self, show: Any) -> list[str]:
        e = self._e
        letter = "Routhian" if "R" in e.model.names.kinds else "R"
        R = e.ring.generator(sympy.Symbol(letter, real=True), "parameter")
        lines = [show(R, self.canonical_routhian, e.ring)]
        lines += [show(x, 0, e.ring) for x in self.canonical_equations]
        for j, w in zip(self._chosen, self.canonical_speeds, strict=True):
            lines.append(show(e.state.u[j], w, e.ring))
        return lines

    def __repr__(self) -> str:
        return (
            f"Routh's reduction of '{self._e.model.name}', without {', '.join(self.ignorable)}\n{self.text()}"
        )
