"""Conserved quantities, each proven by a derivative that is canonically zero.

With the equations of motion written as E_j = 0, linear in u', the rate of a quantity I(q, u, t) along q' = N(q) u is

    dI/dt = Σ μ_j E_j + Σ ν_i ψ_i

identically in q, u and u' exactly if I is conserved, where ψ_i = 0 are the constraints on speeds. The multipliers are
known in advance: u_j for the energy, the components of a rigid motion of the whole machine for a momentum, one for an
ignorable coordinate. So nothing is inverted: the two sides are subtracted as canonical polynomials, and what is not
identically zero is not claimed.

Source: E. Noether (1918); chapter 6, eqs (6.36)-(6.38); Jacobi's integral after H. Goldstein et al., Classical
Mechanics, 3rd ed., §2.7.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ...errors import ModelError, nearest
from ...scalar.element import is_zero
from ...scalar.substitute import Substitution, arrays
from ..free_body.along_motion import numbers, random_numbers, rate_of, residuals_of
from ..printing.display import latex, text
from ..printing.show import EQUALS, aligned, elements, inner, latex_of, latex_words, mathml_of, words
from .candidates import candidates

if TYPE_CHECKING:
    from ..equations import Equations


@dataclass(frozen=True)
class Proof:
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
        Of the quantity.
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
        """The identity as LaTeX, E being the left less the right side of an equation of motion."""
        parts = [_joined_latex(x, "E", name) for name, x in self.multipliers.items()]
        parts += [_joined_latex(x, r"\psi", name) for name, x in self.constraints.items()]
        left = rf"\frac{{d}}{{dt}}\,{latex_words(self.name)} = "
        return left + (" + ".join(parts) or "0")

    def mathml(self) -> str:
        """The identity as presentation MathML."""
        named = [(x, "E", name) for name, x in self.multipliers.items()]
        named += [(x, "ψ", name) for name, x in self.constraints.items()]
        parts = [
            f"<mrow><mo>(</mo>{mathml_of(x)}<mo>)</mo></mrow><msub><mi>{letter}</mi>{words(name)}</msub>"
            for x, letter, name in named
        ]
        left = f"<mfrac><mi>d</mi><mi>dt</mi></mfrac>{words(self.name)}{EQUALS}"
        return elements([left + ("<mo>+</mo>".join(parts) or "<mn>0</mn>")])

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        return self.statement


class Integral:
    """A quantity that keeps its value along every motion.

    Attributes
    ----------
    name : str
    also : tuple of str
        Other names of the same quantity.
    canonical : Polynomial
    """

    def __init__(
        self, equations: Equations, name: str, canonical: Any, mu: Sequence[Any], nu: Sequence[Any]
    ) -> None:
        self._e = equations
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
        """The multipliers of the equations of motion that make up its rate."""
        e = self._e
        mu = {name: e.displayed(x) for name, x in zip(e.model.speed_names, self._mu, strict=True) if x != 0}
        nu = {name: e.displayed(x) for name, x in zip(e.condition_names, self._nu, strict=True) if x != 0}
        named = [(x, f"(equation of {n})") for n, x in zip(e.model.speed_names, self._mu, strict=True)]
        named += [(x, f"(rate of {n})") for n, x in zip(e.condition_names, self._nu, strict=True)]
        parts = [_times(text(x, e.ring), what) for x, what in named if x != 0]
        statement = f"d({self.name})/dt = " + (" + ".join(parts).replace("+ -", "- ") or "0")
        return Proof(mu, nu, statement, self.name)

    def remainder(self) -> Any:
        """dI/dt - Σ μ_j E_j - Σ ν_i ψ_i formed anew: the canonical zero, int 0."""
        return remainder(self._e, self.canonical, self._mu, self._nu)

    def value(self, state: Mapping[Any, Any] | None = None, **values: Any) -> Any:
        """The number at a state.

        Parameters
        ----------
        state : mapping, optional
            Coordinates, speeds, ``t`` and parameters by name or symbol; numbers, or arrays of one shape. Coordinates
            and speeds that are not given are zero, unit quaternions the identity, parameters at their defaults.
        **values
            The same by name, for names that are Python's too.

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

    def mathml(self) -> str:
        """The expression as presentation MathML, = const."""
        return elements([self._formula()])

    def _formula(self) -> str:
        return inner(self.canonical, self._e.ring) + EQUALS + words("const")

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        return self.text()


class Integrals(Sequence[Integral]):
    """The conserved quantities of a system, in a stable order; also found by name."""

    def __init__(self, found: Sequence[Integral]) -> None:
        self._found = tuple(found)

    @property
    def names(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(one.name for one in self._found)

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, str):
            return self._found[key]
        for one in self._found:
            if key == one.name or key in one.also:
                return one
        if not self._found:
            raise ModelError(
                f"This system has no conserved quantity that is known here, so none named '{key}'."
            )
        raise ModelError(f"Unknown conserved quantity '{key}'; {nearest(key, self.names)}")

    def __iter__(self) -> Iterator[Integral]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    def text(self) -> str:
        """One line each."""
        return "\n".join(one.text() for one in self._found) or "No conserved quantities."

    def latex(self) -> str:
        """A LaTeX ``aligned`` block."""
        if not self._found:
            return latex_words("No conserved quantities.")
        return aligned(rf"&{latex_words(one.name + ':')}\quad {one.latex()}" for one in self._found)

    def mathml(self) -> str:
        """Presentation MathML, an element each."""
        if not self._found:
            return elements([words("No conserved quantities.")])
        return elements(words(one.name + ": ") + one._formula() for one in self._found)

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        return self.text()


def integrals(e: Equations) -> Integrals:
    """The conserved quantities of a system, proven.

    Looked for are the energy (Jacobi's integral where something is driven; constant forces count with their
    potential), the momenta of ignorable coordinates, linear momentum along the ground's axes, angular momentum
    about the ground's origin, about the points and axes of the joints on the ground and about the mass centre, and the
    components of angular momentum along the axes of bodies on ball and free joints. Those that are combinations of
    others with constant coefficients are left out.

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
    found: list[Integral] = []
    for name, canonical, mu in candidates(e):
        nu = _proven(e, canonical, mu)
        if nu is None:
            continue
        twin = next((one for one in found if one.canonical in (canonical, -canonical)), None)
        if twin is not None:
            twin.also = (*twin.also, name)
        else:
            found.append(Integral(e, name, canonical, mu, nu))
    return Integrals(_independent(e, found))


# -- proof ----------------------------------------------------------------------------------------


def remainder(e: Equations, canonical: Any, mu: Sequence[Any], nu: Sequence[Any]) -> Any:
    """dI/dt - Σ μ_j E_j - Σ ν_i ψ_i."""
    total = rate_of(e, canonical)
    for factor, E in zip(mu, residuals_of(e), strict=True):
        if factor != 0:
            total = total - factor * E
    for factor, rate in zip(nu, e.conditions.rate, strict=True):
        if factor != 0:
            total = total - factor * rate
    return 0 if is_zero(total) else total


def _proven(e: Equations, canonical: Any, mu: Sequence[Any]) -> tuple[Any, ...] | None:
    """Multipliers ν of the constraints that complete the proof; None if there is none."""
    none: tuple[Any, ...] = (0,) * len(e.condition_names)
    rest = remainder(e, canonical, mu, none)
    if rest == 0:
        return none
    if not e.condition_names:
        return None
    # λ enters as λ·(G μ): where G μ is a constraint's own ψ, as for the energy, it is zero along the motion
    nu = _by_constraint(e, mu)
    return nu if nu is not None and remainder(e, canonical, mu, nu) == 0 else None


def _by_constraint(e: Equations, mu: Sequence[Any]) -> tuple[Any, ...] | None:
    nu: list[Any] = []
    for row, rate, multiplier in zip(
        e.conditions.matrix, e.conditions.rate, e.canonical_multipliers, strict=True
    ):
        along: Any = 0
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


def _independent(e: Equations, found: Sequence[Integral]) -> list[Integral]:
    """Those that are not combinations of earlier ones with coefficients of parameters.

    Decided at random states with the parameters held: a rank of numbers, as a choice of what to print, not a proof.
    """
    import numpy as np

    if len(found) < 2:
        return list(found)
    count = 2 * len(found) + 4
    at = Substitution(e.ring, arrays, random_numbers(e, len(found), count))
    kept: list[Integral] = []
    basis: list[Any] = [np.ones(count) / np.sqrt(count)]  # a constant is no integral
    small = np.sqrt(np.finfo(float).eps)
    for one in found:
        value = np.broadcast_to(np.asarray(at(one.canonical), dtype=float), (count,))
        rest = value
        for _ in range(2):
            for b in basis:
                rest = rest - (b @ rest) * b
        if np.linalg.norm(rest) > small * np.linalg.norm(value) or not np.isfinite(value).all():
            kept.append(one)
            if np.isfinite(value).all():
                basis.append(rest / np.linalg.norm(rest))
    return kept


def _times(factor: str, what: str) -> str:
    if factor in ("1", "-1"):
        return ("-" if factor == "-1" else "") + what
    return f"({factor})*{what}" if " " in factor else f"{factor}*{what}"


def _joined_latex(factor: Any, letter: str, name: str) -> str:
    base = rf"{letter}_{{{latex_words(name)}}}"
    if factor == 1:
        return base
    return rf"\left({latex_of(factor)}\right) {base}"
