"""Derivatives of the initial state with respect to parameters and to named initial values: s_j = ∂y₀/∂p_j.

Named values change as prescribed. For a machine with constraints a search finds the others (`gauss_newton`), and its
result is differentiated. If the conditions leave coordinates undetermined, the result depends on the path of the
search, so its steps for the coordinates are differentiated one by one,

    δ = -A⁺ φ,    dδ = -A⁺ dφ - dA⁺ φ,
    dA⁺ = -A⁺ dA A⁺ + A⁺ A⁺ᵀ dAᵀ (1 - A A⁺) + (1 - A⁺ A) dAᵀ A⁺ᵀ A⁺.

The speeds satisfy ψ = G u + g = 0 with (u - u₀)ᵀ M (u - u₀) least, so that

    M (u - u₀) - Gᵀ λ = 0.

Source: G. H. Golub, V. Pereyra, The differentiation of pseudo-inverses and nonlinear least squares problems whose
variables separate, SIAM Journal on Numerical Analysis 10 (1973) 413-432 (the derivative of A⁺ at constant rank).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...dynamics import coordinate_rates, mass_matrix, traced_state
from ...dynamics.conditions.constrained import DEPENDENT, STEPS
from ...dynamics.conditions.linearized import linearized
from ...errors import SimulationError
from ...model import Model
from ...program.kernels import compile_tape
from ...scalar.algebra import Scalar
from ...scalar.derivative import forward
from ...scalar.trace import Tape
from ..kernels.kernels import Kernels
from ..kernels.program import Program, at_state
from .initial import named_state, quaternions_by_joint

Array = NDArray[np.float64]


def start_slopes(
    kernels: Kernels, unknowns: Sequence[Any], y: Array, values: Mapping[str, float], initial: Mapping[Any, Any],
    near: Mapping[Any, Any], t: float,
) -> Array:  # fmt: skip
    """Return the s_j at the start ``y`` = (q, u), shape (unknowns, size of the kernels' state).

    Raises
    ------
    SimulationError
        The constraints and the named values leave no freedom for the others to follow.
    """
    model = kernels.model
    guess_state, named = named_state(model, values, initial)
    slopes = _as_named(model, unknowns, guess_state, values, initial)
    if model.constraints:
        unknown_places = {unknown.place for unknown in unknowns if unknown.symbol is None}
        if unknown_places <= named:
            guess, guessed = named_state(model, values, near, "near")
            unnamed = sorted(guessed - named)
            guess_state[unnamed] = guess[unnamed]
            slopes[:, unnamed] = _as_named(model, unknowns, guess, values, near)[:, unnamed]
        else:  # differentiate with respect to values that the search found, as if they were named
            guess_state, slopes = y.copy(), _as_named(model, unknowns, y, values, {})
        search = _Search(kernels, unknowns, values, t)
        q = search.coordinates(guess_state, slopes, named | unknown_places)
        slopes = search.speeds(y, guess_state, q, slopes, named | unknown_places)
        search.check(y, slopes, initial)
    result = np.zeros((len(unknowns), kernels.size))
    result[:, : y.size] = slopes
    return result


def _as_named(
    model: Model, unknowns: Sequence[Any], start: Array, values: Mapping[str, float], named: Mapping[Any, Any]
) -> Array:
    """Return the s_j of the named values and of the unknowns, with all other values fixed at ``start``."""
    names = model.state_names
    result = np.zeros((len(unknowns), len(names)))
    quaternions = quaternions_by_joint(model)
    symbols = {p.symbol: values[p.name] for p in model.parameters}
    raw = start.copy()  # with quaternions before their normalisation
    for key, value in named.items():
        name = model.names.text_of(key)
        components = [(names.index(name), value)] if name in names else []
        if name in quaternions and not hasattr(value, "as_quaternion"):
            components = [(quaternions[name] + k, x) for k, x in enumerate(value)]
        for i, part in components:
            expression = model.names.expression(part, f"the initial value of '{name}'")
            if not isinstance(expression, sympy.Basic):
                raw[i] = float(expression)
                continue
            raw[i] = float(expression.subs(symbols))
            for j, unknown in enumerate(unknowns):
                if unknown.symbol is not None:
                    result[j, i] = float(expression.diff(unknown.symbol).subs(symbols))
    for j, unknown in enumerate(unknowns):
        if unknown.symbol is None:
            result[j, unknown.place] = 1.0
    for i in model.quaternions:
        result[:, i : i + 4] = _unit(raw[i : i + 4], result[:, i : i + 4])
    return result


def _unit(r: Array, dr: Array) -> Array:
    """Return the derivative de = (1 - e eᵀ) dr/|r| of e = r/|r|, by rows."""
    length = np.linalg.norm(r)
    e = r / length
    return (dr - np.outer(dr @ e, e)) / length


class _Search:
    """The search for the start of a machine with constraints, and its derivatives with respect to the unknowns."""

    def __init__(
        self, kernels: Kernels, unknowns: Sequence[Any], values: Mapping[str, float], t: float
    ) -> None:
        self.kernels, self.model, self.unknowns, self.t = kernels, kernels.model, unknowns, t
        self.parameters = kernels.parameters(values)
        self.program = self._program()
        self.constants = self.program.constants(self.parameters)
        self.of_places = [i for i, on_speeds in enumerate(kernels.on_speeds) if not on_speeds]

    def _program(self) -> Program:
        """Program of functions of (y, s_1, s_2, ..., u - u₀, λ), each followed by its derivatives along every s_j.

        The functions are ``conditions`` (φ or ψ, G), ``moved`` (q') and ``speeds`` (ψ, M (u - u₀) - Gᵀ λ); and, without
        derivatives, ``masses`` (G, M).
        """
        model, programs = self.model, self.kernels.programs
        key = ("slopes of the start", tuple(unknown.name for unknown in self.unknowns))
        if key not in programs:
            tape = Tape()
            state = traced_state(model, tape)
            y = [*state.q, *state.u]
            derivatives = [
                [tape.input(f"derivative {i} by {unknown.name}") for i in range(len(y))]
                for unknown in self.unknowns
            ]
            linear = linearized(model, state)
            w = [tape.input(f"{speed.name} less its guess") for speed in model.speeds]
            multipliers = [tape.input(f"multiplier {i}") for i in range(len(linear.rate))]
            parameters = [state.values[p.symbol] for p in model.parameters]
            M = mass_matrix(model, state)
            least = [
                sum((M[i][j] * w[j] for j in range(model.n_u)), 0)
                - sum((row[i] * x for row, x in zip(linear.matrix, multipliers, strict=True)), 0)
                for i in range(model.n_u)
            ]

            def along(outputs: list[Scalar]) -> list[Scalar]:
                result = list(outputs)
                for unknown, row in zip(self.unknowns, derivatives, strict=True):
                    moving = [] if unknown.symbol is None else [state.values[unknown.symbol]]
                    result += forward(tape, outputs, [*y, *moving], [*row, *[1 for _ in moving]])
                return result

            functions = {
                "conditions": along([*linear.residual, *(x for row in linear.matrix for x in row)]),
                "moved": along(list(coordinate_rates(model, state))),
                "speeds": along([*linear.rate, *least]),
                "masses": [*(x for row in linear.matrix for x in row), *(x for row in M for x in row)],
            }
            listed = [*y, *(x for row in derivatives for x in row), *w, *multipliers]
            programs[key] = Program(compile_tape(tape, functions, state.t, listed, parameters))
        return programs[key]

    def _at(self, function: str, y: Array, slopes: Array, *more: Array) -> tuple[Array, Array]:
        """Return a function of the program, and its derivatives by rows."""
        rest = np.zeros(self.model.n_u + len(self.kernels.on_speeds))
        state = np.concatenate([y, slopes.ravel(), *(more or (rest,))])
        outputs = at_state(self.program, function, self.t, state, self.constants)
        if function == "masses":
            return outputs, np.empty(0)
        values = outputs.reshape(1 + len(self.unknowns), -1)
        return values[0], values[1:]

    def coordinates(self, start: Array, slopes: Array, named: set[int]) -> Array:
        """Return ∂q/∂p at the end of the search, from the start ``start`` and its derivatives."""
        model = self.model
        n_q, n = model.n_q, model.n_u
        y, s = start.copy(), slopes.copy()
        fixed = {j for i in named if i < n_q for j in model.moved_by[i]}
        free = [j for j in range(n) if j not in fixed]
        m, k = len(self.kernels.on_speeds), len(self.unknowns)
        steps_met = 0
        for _ in range(STEPS):
            y[n_q:], s[:, n_q:] = 0.0, 0.0
            value, along = self._at("conditions", y, s)
            phi, dphi = value[self.of_places], along[:, self.of_places]
            A = value[m:].reshape(m, n)[self.of_places][:, free]
            dA = along[:, m:].reshape(k, m, n)[:, self.of_places][:, :, free]
            steps_met += np.abs(phi).max(initial=0.0) < DEPENDENT * (1 + np.abs(start[:n_q]).max(initial=0.0))
            P = np.linalg.pinv(A, rcond=DEPENDENT)
            step = -P @ phi
            transposed = dA.transpose(0, 2, 1)
            dP = (
                -P @ dA @ P
                + P @ P.T @ transposed @ (np.eye(len(phi)) - A @ P)
                + (np.eye(len(free)) - P @ A) @ transposed @ P.T @ P
            )
            dstep = -dphi @ P.T - dP @ phi
            if np.abs(step).max(initial=0.0) > 1:
                i = int(np.argmax(np.abs(step)))
                length = abs(step[i])
                dstep = dstep / length - np.outer(dstep[:, i] * np.sign(step[i]), step) / length**2
                step = step / length
            y[[n_q + j for j in free]] = step
            s[:, [n_q + j for j in free]] = dstep
            rates, drates = self._at("moved", y, s)
            y[:n_q] += rates
            s[:, :n_q] += drates
            for i in model.quaternions:
                s[:, i : i + 4] = _unit(y[i : i + 4], s[:, i : i + 4])
                y[i : i + 4] /= np.linalg.norm(y[i : i + 4])
            if steps_met > 2:
                break
        return s[:, :n_q]

    def speeds(self, y: Array, start: Array, q: Array, slopes: Array, named: set[int]) -> Array:
        """Return the s_j of all components, from those of the coordinates and of the speeds at the start of the
        search.
        """
        n_q, n, m = self.model.n_q, self.model.n_u, len(self.kernels.on_speeds)
        free = [j for j in range(n) if n_q + j not in named]
        moved = [n_q + j for j in free]
        numbers = self._at("masses", y, slopes)[0]
        G = numbers[: m * n].reshape(m, n)[:, free]
        M = numbers[m * n :].reshape(n, n)[np.ix_(free, free)]
        w = y[n_q:] - start[n_q:]
        multipliers = np.asarray(np.linalg.lstsq(G.T, M @ w[free], rcond=DEPENDENT)[0], dtype=np.float64)
        s = np.concatenate([q, slopes[:, n_q:]], axis=1)
        s[:, moved] = 0.0
        _, along = self._at("speeds", y, s, w, multipliers)
        A = np.block([[M, -G.T], [G, np.zeros((m, m))]])
        b = np.concatenate([slopes[:, moved] @ M - along[:, m:][:, free], -along[:, :m]], axis=1)
        s[:, moved] = np.linalg.lstsq(A, b.T, rcond=1e-11)[0][: len(free)].T
        return s

    def check(self, y: Array, slopes: Array, initial: Mapping[Any, Any]) -> None:
        """Check that the s_j satisfy the conditions on coordinates and on speeds."""
        m = len(self.kernels.on_speeds)
        of_places = self._at("conditions", y, slopes)[1][:, self.of_places]
        residuals = np.concatenate([of_places, self._at("speeds", y, slopes)[1][:, :m]], axis=1)
        for unknown, row, slope in zip(self.unknowns, residuals, slopes, strict=True):
            if not np.abs(row).max(initial=0.0) <= 1e-7 * (1 + np.abs(slope).max(initial=0.0)):
                raise SimulationError(
                    f"The start cannot follow a change of '{unknown.name}': the constraints of '{self.model.name}' "
                    f"hold what is named in initial ({', '.join(map(str, initial)) or 'nothing'}). Name less, so that "
                    "the rest can follow, or use near=."
                )
