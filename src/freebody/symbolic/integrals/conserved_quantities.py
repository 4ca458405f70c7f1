"""Conserved quantities, each proven by a derivative that is canonically zero.

With the equations of motion written as E_j = 0, linear in u', the rate of a quantity I(q, u, t) along q' = N(q) u is

    dI/dt = Σ μ_j E_j + Σ ν_i ψ_i

identically in q, u and u' if and only if I is conserved; ψ_i = 0 are the constraints on speeds. The multipliers are
known in advance: u_j for the energy, the components of a rigid motion of the whole machine for a momentum, 1 for an
ignorable coordinate. So nothing is inverted: the two sides are subtracted as canonical polynomials, and a quantity is
listed only if the difference is identically zero.

Source: E. Noether (1918); chapter 6, eqs (6.36)-(6.38); Jacobi's integral after H. Goldstein et al., Classical
Mechanics, 3rd ed., §2.7.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ...errors import ModelError, nearest
from ...scalar.algebra import Expression, Scalar
from ...scalar.element import is_zero
from ...scalar.substitute import Substitution, arrays
from ..derivation.along_motion import numbers, random_numbers, rate_of, residuals_of
from ..derivation.derivation import Derivation
from ..printing.display import latex, text
from ..printing.show import aligned, latex_of, latex_words
from ..printing.typeset import Typeset
from .candidates import candidates


@dataclass(frozen=True)
class Proof(Typeset):
    """dI/dt = Σ μ_j E_j + Σ ν_i ψ_i, an identity of polynomials in q, u, u'.

    Attributes
    ----------
    multipliers : dict
        μ_j as SymPy expressions, by the name of the speed whose equation of motion E_j = 0 they multiply.
    constraints : dict
        ν_i by the name of the constraint on speeds, ψ_i = 0.
    statement : str
        The identity as text.
    name : str
        Name of the quantity.
    """

    multipliers: dict[str, Any]
    constraints: dict[str, Any]
    statement: str
    name: str = "I"

    def __str__(self) -> str:
        return self.statement

    def text(self) -> str:
        """The identity as plain text."""
        return self.statement

    def latex(self) -> str:
        """The identity as LaTeX; E is the left side minus the right side of an equation of motion."""
        parts = [_joined_latex(x, "E", name) for name, x in self.multipliers.items()]
        parts += [_joined_latex(x, r"\psi", name) for name, x in self.constraints.items()]
        left = rf"\frac{{d}}{{dt}}\,{latex_words(self.name)} = "
        return left + (" + ".join(parts) or "0")

    def __repr__(self) -> str:
        return self.statement


class Integral(Typeset):
    """A quantity that keeps its value along every motion.

    Attributes
    ----------
    name : str
    also : tuple of str
        Other names of the same quantity.
    canonical : Polynomial
    """

    def __init__(
        self, e: Derivation, name: str, canonical: Scalar, mu: Sequence[Scalar], nu: Sequence[Scalar]
    ) -> None:
        self._e = e
        self.name = name
        self.also: tuple[str, ...] = ()
        self.canonical = canonical
        self._mu = tuple(mu)
        self._nu = tuple(nu)

    @cached_property
    def expression(self) -> Any:
        """The quantity as a SymPy expression."""
        return self._e.displayed(self.canonical)

    @cached_property
    def proof(self) -> Proof:
        """Multipliers of the equations of motion whose sum is the rate of the quantity."""
        e = self._e
        mu = {name: e.displayed(x) for name, x in zip(e.model.speed_names, self._mu, strict=True) if x != 0}
        nu = {name: e.displayed(x) for name, x in zip(e.condition_names, self._nu, strict=True) if x != 0}
        named = [(x, f"(equation of {n})") for n, x in zip(e.model.speed_names, self._mu, strict=True)]
        named += [(x, f"(rate of {n})") for n, x in zip(e.condition_names, self._nu, strict=True)]
        parts = [_times(text(x, e.ring), factor) for x, factor in named if x != 0]
        statement = f"d({self.name})/dt = " + (" + ".join(parts).replace("+ -", "- ") or "0")
        return Proof(mu, nu, statement, self.name)

    def remainder(self) -> Scalar:
        """Form dI/dt - Σ μ_j E_j - Σ ν_i ψ_i anew: the canonical zero, int 0."""
        return remainder(self._e, self.canonical, self._mu, self._nu)

    def value(self, state: Mapping[Any, Expression] | None = None, **values: Expression) -> Any:
        """Return the value of the quantity at a state.

        Parameters
        ----------
        state : mapping, optional
            Coordinates, speeds, ``t`` and parameters by name or symbol; numbers, or arrays of one shape. By default,
            coordinates and speeds are zero, unit quaternions the identity, and parameters have their defaults.
        **values
            The same as keyword arguments, for names that are valid in Python.

        Raises
        ------
        ModelError
            An unknown name, or a parameter without a value.
        """
        atoms = numbers(self._e, {**(state or {}), **values})
        result = Substitution(self._e.ring, arrays, atoms)(self.canonical)
        return float(result) if getattr(result, "ndim", 0) == 0 else result

    def text(self) -> str:
        """``name: expression = const`` as plain text."""
        return f"{self.name}: {text(self.canonical, self._e.ring)} = const"

    def latex(self) -> str:
        """The expression as LaTeX, = const."""
        return latex(self.canonical, self._e.ring) + r" = \text{const}"

    def __repr__(self) -> str:
        return self.text()


class Integrals(Typeset, Sequence[Integral]):
    """The conserved quantities of a system, in a stable order, by index or name."""

    def __init__(self, integrals: Sequence[Integral]) -> None:
        self._integrals = tuple(integrals)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities."""
        return tuple(integral.name for integral in self._integrals)

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, str):
            return self._integrals[key]
        for integral in self._integrals:
            if key == integral.name or key in integral.also:
                return integral
        if not self._integrals:
            raise ModelError(f"No conserved quantity of this system is known, so there is no '{key}'.")
        raise ModelError(f"Unknown conserved quantity '{key}'; {nearest(key, self.names)}")

    def __iter__(self) -> Iterator[Integral]:
        return iter(self._integrals)

    def __len__(self) -> int:
        return len(self._integrals)

    def text(self) -> str:
        """The quantities as plain text, a line each."""
        return "\n".join(integral.text() for integral in self._integrals) or "No conserved quantities."

    def latex(self) -> str:
        """The quantities as a LaTeX ``aligned`` block."""
        if not self._integrals:
            return latex_words("No conserved quantities.")
        return aligned(
            rf"&{latex_words(integral.name + ':')}\quad {integral.latex()}" for integral in self._integrals
        )

    def __repr__(self) -> str:
        return self.text()


def integrals(e: Derivation) -> Integrals:
    """Find the conserved quantities of a system, and prove them.

    Candidates are the energy (Jacobi's integral if a motion is prescribed; constant forces count with their potential),
    the momenta of ignorable coordinates, linear momentum along the ground's axes, angular momentum about the ground's
    origin, about the points and axes of the joints on the ground and about the mass centre, and the components of
    angular momentum along the axes of bodies on ball and free joints. Linear combinations of earlier ones with constant
    coefficients are omitted.

    Returns
    -------
    Integrals

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1, L=1, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(m))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    >>> fb.equations(s).integrals
    energy: m*L^2*theta'^2/2 - m*L*g*cos(theta) = const
    >>> print(fb.equations(s).integrals["energy"].proof)
    d(energy)/dt = theta'*(equation of theta')
    """
    if "integrals" not in e.state.cache:
        e.state.cache["integrals"] = Integrals(_independent(e, _conserved(e)))
    return e.state.cache["integrals"]


def _conserved(e: Derivation) -> list[Integral]:
    """Return all candidates that are conserved; those with the same polynomial are one, with further names."""
    conserved: list[Integral] = []
    for name, canonical, mu in candidates(e):
        nu = _proven(e, canonical, mu)
        if nu is None:
            continue
        twin = next((x for x in conserved if x.canonical in (canonical, -canonical)), None)
        if twin is not None:
            twin.also = (*twin.also, name)
        else:
            conserved.append(Integral(e, name, canonical, mu, nu))
    return conserved


# -- proof ----------------------------------------------------------------------------------------


def remainder(e: Derivation, canonical: Scalar, mu: Sequence[Scalar], nu: Sequence[Scalar]) -> Scalar:
    """Return dI/dt - Σ μ_j E_j - Σ ν_i ψ_i."""
    total = rate_of(e, canonical)
    for factor, E in zip(mu, residuals_of(e), strict=True):
        if factor != 0:
            total = total - factor * E
    for factor, rate in zip(nu, e.conditions.rate, strict=True):
        if factor != 0:
            total = total - factor * rate
    return 0 if is_zero(total) else total


def _proven(e: Derivation, canonical: Scalar, mu: Sequence[Scalar]) -> tuple[Scalar, ...] | None:
    """Return the multipliers ν of the constraints that complete the proof; None if there is no proof."""
    none: tuple[Scalar, ...] = (0,) * len(e.condition_names)
    rest = remainder(e, canonical, mu, none)
    if rest == 0:
        return none
    if not e.condition_names:
        return None
    # λ enters as λ·(G μ); if G μ is a constraint's own ψ, as for the energy, this is zero along the motion
    nu = _by_constraint(e, mu)
    return nu if nu is not None and remainder(e, canonical, mu, nu) == 0 else None


def _by_constraint(e: Derivation, mu: Sequence[Scalar]) -> tuple[Scalar, ...] | None:
    """Multipliers ν_i = λ_i of the constraints with G_i μ = ψ_i, 0 for G_i μ = 0; None in other cases."""
    nu: list[Scalar] = []
    for row, rate, multiplier in zip(
        e.conditions.matrix, e.conditions.rate, e.canonical_multipliers, strict=True
    ):
        along: Scalar = 0
        for entry, factor in zip(row, mu, strict=True):
            along = along + entry * factor
        if is_zero(along):
            nu.append(0)
        elif is_zero(along - rate):
            nu.append(multiplier)
        else:
            return None
    return tuple(nu)


# -- independence ---------------------------------------------------------------------------------


def _independent(e: Derivation, integrals: Sequence[Integral]) -> list[Integral]:
    """Return the quantities that are not combinations of earlier ones with coefficients of parameters.

    This is decided by a numerical rank at random states with constant parameters. It selects what to print and is no
    proof.
    """
    import numpy as np

    if len(integrals) < 2:
        return list(integrals)
    count = 2 * len(integrals) + 4
    at = Substitution(e.ring, arrays, random_numbers(e, len(integrals), count))
    independent: list[Integral] = []
    basis: list[Any] = [np.ones(count) / np.sqrt(count)]  # a constant is no integral
    small = np.sqrt(np.finfo(float).eps)
    for integral in integrals:
        value = np.broadcast_to(np.asarray(at(integral.canonical), dtype=float), (count,))
        rest = value
        for _ in range(2):
            for b in basis:
                rest = rest - (b @ rest) * b
        if np.linalg.norm(rest) > small * np.linalg.norm(value) or not np.isfinite(value).all():
            independent.append(integral)
            if np.isfinite(value).all():
                basis.append(rest / np.linalg.norm(rest))
    return independent


def _times(a: str, b: str) -> str:
    if a in ("1", "-1"):
        return ("-" if a == "-1" else "") + b
    return f"({a})*{b}" if " " in a else f"{a}*{b}"


def _joined_latex(factor: Any, letter: str, name: str) -> str:
    base = rf"{letter}_{{{latex_words(name)}}}"
    if factor == 1:
        return base
    return rf"\left({latex_of(factor)}\right) {base}"
