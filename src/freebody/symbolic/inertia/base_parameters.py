"""Base parameters: those combinations of the bodies' inertia on which the forces depend, τ = Y θ = Y_b β.

A column of the regressor that is a combination of columns before it, with coefficients that no motion changes, adds
its parameter to theirs:

    Y_j = Σ_k c_kj Y_k,        β_k = θ_k + Σ_j c_kj θ_j

Columns stand in the order of the bodies, so that the inertia of a body far out goes to the bodies that carry it.

Source: M. Gautier, W. Khalil, Direct calculation of minimum set of inertial parameters of serial robots (1990).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from ...describe.system import System
from ...dynamics.regressor import parameter_names
from ...errors import arguments_named
from ...model.assemble import assemble
from ...model.model import Model
from ...scalar.digits import significant
from ..derivation.canonical_model import CanonicalModel
from ..printing.latex import latex_name, latex_number
from ..printing.show import aligned, latex_of, text_of
from ..printing.typeset import Typeset
from .combinations import combinations_in_floats, combinations_with_symbols, rounded_joint

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, eq=False)
class BaseParameters(Typeset):
    """Base parameters β of a machine, made by :func:`freebody.base_parameters`.

    Attributes
    ----------
    names : tuple of str
        The parameter of a body with which each begins, such as ``"arm.Izz"``.
    combinations : dict of str to dict of str to expression
        For each, the inertial parameters that it is made of, and their coefficients.
    columns : tuple of int
        Their columns in the regressor: Y_b = Y[..., columns].
    without_influence : tuple of str
        Inertial parameters on which no force depends.
    rounded : str
        A joint whose axes are rounded numbers, so that the coefficients are numbers in double precision; else "".
    closed : tuple of str
        Constraints of the machine; its forces are those on independent speeds, and the coefficients are numbers.
    """

    names: tuple[str, ...]
    combinations: dict[str, dict[str, Any]]
    columns: tuple[int, ...]
    without_influence: tuple[str, ...]
    rounded: str
    model: Model
    closed: tuple[str, ...] = ()

    def matrix(self, values: Mapping[str, float] | None = None) -> Array:
        """Return K with β = K θ for values of the parameters, shape (n, 10 bodies)."""
        numbers = self.model.values(values)
        symbols = {p.symbol: numbers[p.name] for p in self.model.parameters}
        places = {name: j for j, name in enumerate(parameter_names(self.model))}
        K = np.zeros((len(self.names), len(places)))
        for row, combination in zip(K, self.combinations.values(), strict=True):
            for name, coefficient in combination.items():
                row[places[name]] = float(coefficient.subs(symbols))
        return K

    def text(self) -> str:
        """Return the combinations, one to a line."""
        width = max(map(len, self.names), default=0)
        lines = [f"{name:{width}}  =  {TEXT.sum(x)}" for name, x in self.combinations.items()]
        if self.without_influence:
            lines.append(f"without influence: {', '.join(self.without_influence)}")
        if self.rounded:
            lines.append(f"The coefficients are rounded, as the axes of joint '{self.rounded}' are.")
        if self.closed:
            lines.append(f"The coefficients are numbers, since {', '.join(self.closed)} couple the speeds.")
        return "\n".join(lines)

    def latex(self) -> str:
        """Return the combinations as LaTeX, aligned."""
        return aligned(
            rf"\beta_{{{k}}} &= {LATEX.sum(x)}" for k, x in enumerate(self.combinations.values(), start=1)
        )

    def __repr__(self) -> str:
        return self.text()


@dataclass(frozen=True)
class _Writing:
    """How numbers, expressions, sums in products, and names of inertial parameters are written."""

    number: Callable[[Any], str]
    expression: Callable[[Any], str]
    bracket: str
    times: str
    name: Callable[[str], str]

    def sum(self, combination: Mapping[str, Any]) -> str:
        """Return a combination; six digits of numbers that are not whole are shown."""
        text = ""
        for name, coefficient in combination.items():
            minus = coefficient.could_extract_minus_sign()
            size = -coefficient if minus else coefficient
            is_long = size.is_Float or size.is_Rational and size.q > 1
            shown = self.number(size) if is_long else self.expression(size)
            factor = self.bracket.format(shown) if size.is_Add else shown
            text += (" - " if minus else " + ") if text else "-" if minus else ""
            text += self.name(name) if shown == "1" else f"{factor}{self.times}{self.name(name)}"
        return text


def _symbol(name: str) -> str:
    """Return an inertial parameter as LaTeX: h_x of a body is its first moment."""
    body, _, part = name.rpartition(".")
    return latex_name("_".join(filter(None, (part[0], part[1:], body))))


TEXT = _Writing(significant, text_of, "({})", "*", str)
LATEX = _Writing(lambda x: latex_number(complex(x)), latex_of, r"\left({}\right)", " ", _symbol)


@arguments_named
def base_parameters(system: System | Model, values: Mapping[str, float] | None = None) -> BaseParameters:
    """Return the combinations of the bodies' inertia on which the forces of a machine depend.

    They are all that a measurement of forces can tell of the inertia: Y θ = Y_b β. Each body has ten inertial
    parameters about its origin, in its axes: mass m, first moment h = m c, moments of inertia I (the entries of the
    matrix). Names and columns are those of ``program.regressor``.

    The coefficients are exact and hold the machine's symbols. If axes are given as rounded numbers, which are no
    rotation exactly, the coefficients are numbers for the ``values`` of the parameters, and ``rounded`` names a joint.
    So they are for machines with constraints, whose forces are those on independent speeds, Nᵀ Y θ.

    Raises
    ------
    ModelError
        If a root of coordinates occurs in a place or a displacement, if a value is missing for rounded axes or a
        machine with constraints, or if no random configuration closes the loops.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("arm")
    >>> _ = s.parameters("g L")
    >>> s.gravity = (0, "-g", 0)
    >>> ball = fb.MassProperties(1, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    >>> upper, fore = s.body("upper", ball), s.body("fore", ball)
    >>> _ = s.hinge("shoulder", s.ground, upper, axis="z")
    >>> _ = s.hinge("elbow", upper, fore, at=("L", 0, 0), axis="z")
    >>> base = fb.base_parameters(s)
    >>> for line in base.text().splitlines()[:6]:
    ...     print(line)
    upper.hx   =  upper.hx + L*fore.m
    upper.hy   =  upper.hy
    upper.Izz  =  upper.Izz + L^2*fore.m
    fore.hx    =  fore.hx
    fore.hy    =  fore.hy
    fore.Izz   =  fore.Izz
    """
    model = system if isinstance(system, Model) else assemble(system)
    names, canonical = parameter_names(model), CanonicalModel(model)
    rounded, closed = rounded_joint(canonical), tuple(model.constraints)
    independent, others = (
        combinations_in_floats(model, values) if rounded or closed else combinations_with_symbols(canonical)
    )
    combinations: dict[str, dict[str, Any]] = {names[k]: {names[k]: sympy.Integer(1)} for k in independent}
    for j, combination in others.items():
        for k, coefficient in combination.items():
            combinations[names[k]][names[j]] = coefficient
    alone = tuple(names[j] for j, combination in others.items() if not combination)
    return BaseParameters(tuple(combinations), combinations, independent, alone, rounded, model, closed)
