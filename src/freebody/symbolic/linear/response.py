"""The motion of linear equations in closed form.

    X(s) = (M s² + C s + K)⁻¹ (M (s ξ_0 + ξ'_0) + C ξ_0 + B F(s))

A symbolic model is transformed back by partial fractions over the factors of the characteristic polynomial. In a
numeric model the inputs solve linear equations of their own; all equations together have a response that is a sum of
exponentials.

Source: chapter 6, eqs (6.115) to (6.120); Meirovitch (1970), §8.4.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from numpy.typing import ArrayLike, NDArray

from ...errors import ModelError, nearest
from ...scalar.algebra import Expression
from ..printing.closed.expressions import Closed
from ..printing.latex import latex_name
from ..printing.lines import Result
from ..printing.show import (
    aligned,
    latex_of,
    latex_words,
    text_of,
)
from .forcing import Term, terms_of
from .operating_point import value_of_name
from .partial_fractions import inverse_transform

T = sympy.Symbol("t")
WELL_CONDITIONED = 10**7
"""Largest condition number of the eigenvectors for an expansion in modes; beyond it, the matrix exponential is used."""
NOTHING = 10**-12
"""Size of terms of a response, and of rates [1/s], below which they are not shown."""


class ExactResponse(Result, Mapping[str, Any]):
    """Deviations as SymPy expressions of ``t``, by the name of a coordinate or of its rate."""

    def __init__(self, expressions: dict[str, Any], ring: Any) -> None:
        self._expressions = expressions
        self._ring = ring

    def __getitem__(self, name: str) -> Any:
        if name in self._expressions:
            return self._expressions[name]
        if isinstance(name, str) and name.removesuffix("'") in self._expressions:
            return self._expressions[name.removesuffix("'")].diff(T)
        raise ModelError(f"Unknown name '{name}' in a response; {nearest(str(name), self._expressions)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._expressions)

    def __len__(self) -> int:
        return len(self._expressions)

    def text(self) -> str:
        """A line for each coordinate."""
        return "\n".join(f"{name}(t) = {Closed(x, self._ring).text()}" for name, x in self.items())

    def latex(self) -> str:
        """A LaTeX ``aligned`` block."""
        rows = [f"{latex_name(n)}(t) &= {Closed(x, self._ring).latex()}" for n, x in self.items()]
        return aligned(rows)


class Response(Result):
    """Deviations of a numeric model as a function of time: ``response(t)["theta"]``.

    ``terms("theta")`` gives one as Σ c e^(s t), if the model has a mode for each root.
    """

    def __init__(self, names: tuple[str, ...], Z: NDArray[Any], start: NDArray[Any]) -> None:
        self.names = names
        self._Z = Z
        self._start = start
        roots, shapes = np.linalg.eig(Z)
        self._modal = bool(np.linalg.cond(shapes) < WELL_CONDITIONED)
        self._roots = roots
        if self._modal:
            self._parts = shapes * np.linalg.solve(shapes, start)

    def __call__(self, t: ArrayLike) -> dict[str, Any]:
        """Return deviations and rates by name, each of the shape of ``t``."""
        times = np.asarray(t, dtype=float)
        flat = times.reshape(-1)
        if self._modal:
            states = np.exp(np.multiply.outer(flat, self._roots)) @ self._parts.T
        else:
            from scipy.linalg import expm

            states = expm(np.multiply.outer(flat, self._Z)) @ self._start
        return {name: states[:, i].real.reshape(times.shape)[()] for i, name in enumerate(self.names)}

    def terms(self, name: str) -> list[tuple[complex, complex]]:
        """Return (c, s) of the terms of Σ c e^(s t), largest first.

        Raises
        ------
        ModelError
            An unknown name; a resonance or a rigid-body mode, whose terms contain powers of t.
        """
        if name not in self.names:
            raise ModelError(f"Unknown name '{name}' in a response; {nearest(str(name), self.names)}")
        if not self._modal:
            raise ModelError(
                "This response holds powers of t times exponentials (a rigid-body mode, or a resonance), so it "
                "has no terms "
                "c e^(s t). Call response(t), or take the response of a symbolic model."
            )
        pairs = list(zip(self._parts[self.names.index(name)].tolist(), self._roots.tolist(), strict=True))
        pairs = [(complex(c), complex(s)) for c, s in pairs]
        return sorted((p for p in pairs if p[0] != 0), key=lambda p: -abs(p[0]))

    @property
    def _written(self) -> dict[str, Any]:
        """The coordinates as sums of e^(a t) cos(b t) and e^(a t) sin(b t), rounded as they are shown."""
        result = {}
        for name in self.names if self._modal else ():
            if name.endswith("'"):
                continue
            total = sympy.S.Zero
            for c, s in self.terms(name):
                if s.imag < 0 or abs(c) < NOTHING:
                    continue
                a, b = (_shown(part * (2 if s.imag else 1)) for part in (c.real, c.imag))
                turn = _shown(s.imag) * T
                total += (a * sympy.cos(turn) - b * sympy.sin(turn)) * sympy.exp(_shown(s.real) * T)
            result[name] = total
        return result

    def text(self) -> str:
        """A line for each coordinate; only the names if terms contain powers of time."""
        return "\n".join(f"{name}(t) = {text_of(x)}" for name, x in self._written.items()) or repr(self)

    def latex(self) -> str:
        """The same as a LaTeX ``aligned`` block."""
        lines = [f"{latex_name(name)}(t) &= {latex_of(x)}" for name, x in self._written.items()]
        return aligned(lines or ["&" + latex_words(repr(self))])

    def __repr__(self) -> str:
        return f"Response of {', '.join(self.names)}: call it with times"


def _shown(x: float) -> Any:
    """Return a number rounded as it is shown."""
    rounded = float(f"{x:.6g}") if abs(x) > NOTHING else 0
    return sympy.Integer(int(rounded)) if rounded == int(rounded) else sympy.Float(str(rounded))


@dataclass(frozen=True)
class Start:
    """Initial deviations and rates, in the order of the coordinates."""

    positions: list[Expression]
    rates: list[Expression]


def response(
    linear: Any, initial: Mapping[Any, Expression], forcing: Mapping[Any, Expression]
) -> ExactResponse | Response:
    """Return the response of a linear model; see :meth:`LinearModel.response`."""
    start = _start(linear, initial)
    inputs: list[tuple[int, Term]] = []
    for key, value in forcing.items():
        name = key if isinstance(key, str) else linear.model.names.texts.get(key, str(key))
        if name not in linear.inputs:
            cure = "" if linear.inputs else " Name the inputs in fb.linearize(s, inputs=...)."
            raise ModelError(f"Unknown input '{name}' in forcing; {nearest(name, linear.inputs)}{cure}")
        expression = _expression(linear, value, f"the input '{name}'")
        inputs += [(linear.inputs.index(name), term) for term in terms_of(expression, name)]
    if linear.symbolic:
        return _exact(linear, start, inputs)
    return _modal(linear, start, inputs)


def _expression(linear: Any, value: Expression, what: str) -> Any:
    return sympy.sympify(linear.model.names.expression(value, what) if isinstance(value, str) else value)


def _start(linear: Any, initial: Mapping[Any, Expression]) -> Start:
    n, carried = len(linear.coordinates), len(linear.carried)
    positions: list[Expression] = [0] * (n + carried)
    rates: list[Expression] = [0] * n
    of_speed: dict[int, Any] = {}
    places = {name: i for i, name in enumerate((*linear.coordinates, *linear.carried))}
    speeds = {name: i for i, name in enumerate(linear.model.speed_names)} if not linear.carried else {}
    for key, value in initial.items():
        name = key if isinstance(key, str) else linear.model.names.texts.get(key, str(key))
        number = value_of_name(linear.model, value, f"the initial deviation of '{name}'")
        if name in places:
            positions[places[name]] = number
        elif name in linear.rates:
            rates[linear.rates.index(name)] = number
        elif name in speeds:
            of_speed[speeds[name]] = number
        else:
            known = [*places, *linear.rates, *speeds]
            raise ModelError(f"Unknown name '{name}' in initial; {nearest(name, known)}")
    A = linear.canonical.get("A")
    for j, number in of_speed.items():  # ξ' = δu + A ξ
        rates[j] = number
        if A is not None:
            drift = [linear.ring.to_sympy(x) if linear.symbolic else x for x in A[j]]
            rates[j] = number + sum(a * x for a, x in zip(drift, positions, strict=True))
    return Start(positions, rates)


# -- symbols --------------------------------------------------------------------------------------


def _exact(linear: Any, start: Start, inputs: list[tuple[int, Term]]) -> ExactResponse:
    character = linear.characteristic
    ring = character.ring
    n = len(linear.coordinates)
    M, C, B = (linear.canonical[key] for key in "MCB")
    s = ring.generator(sympy.Symbol("s"))
    x0 = [ring.from_sympy(sympy.sympify(x)) for x in start.positions]
    v0 = [ring.from_sympy(sympy.sympify(x)) for x in start.rates]
    sides: list[tuple[list[Any], Any]] = []
    free = [sum((M[i][j] * (s * x0[j] + v0[j]) + C[i][j] * x0[j] for j in range(n)), 0) for i in range(n)]
    free += [  # c' = E (ξ, c) + E_r ξ'
        c - sum((x * y for x, y in zip(E_rates, x0, strict=False)), 0)
        for c, E_rates in zip(x0[n:], linear.canonical.get("E_rates", ()), strict=True)
    ]
    if any(x != 0 for x in free):
        sides.append((free, None))
    for k, term in inputs:
        sides.append(([*(B[i][k] for i in range(n)), *(0 for _ in linear.carried)], term))
    result = {}
    for j, name in enumerate((*linear.coordinates, *linear.carried)):
        total: Any = sympy.Integer(0)
        for column, term in sides:
            rows = [
                [column[i] if c == j else x for c, x in enumerate(row)]
                for i, row in enumerate(character.matrix)
            ]
            total += inverse_transform(character, rows, term)
        result[name] = total
    return ExactResponse(result, character.ring)


# -- numbers --------------------------------------------------------------------------------------


def _modal(linear: Any, start: Start, inputs: list[tuple[int, Term]]) -> Response:
    A, B = linear.first_order
    size = len(A)
    chains = [(k, term, term.numbers()) for k, term in inputs]
    extra = sum(term.power + 1 for _, term, _ in chains)
    Z = np.zeros((size + extra, size + extra), dtype=complex if extra else float)
    Z[:size, :size] = A
    first = np.zeros(size + extra, dtype=Z.dtype)
    first[:size] = [_number(x) for x in (*start.positions, *start.rates)]
    place = size
    for k, term, (amplitude, exponent) in chains:
        # t^k e^(s t) / k! is the first of a chain of equations, each driven by the next
        links = range(place, place + term.power + 1)
        for i in links:
            Z[i, i] = exponent
            if i + 1 in links:
                Z[i, i + 1] = 1
        first[links[-1]] = 1
        Z[:size, place] = B[:, k] * amplitude * float(sympy.factorial(term.power))
        place += term.power + 1
    return Response(linear.states, Z, first)


def _number(x: Any) -> float:
    try:
        return float(x)
    except (TypeError, ValueError):
        raise ModelError(
            f"Expected a number for the response of a numeric model, got '{x}'. Leave out values= for a symbolic one."
        ) from None
