"""How the start of a motion changes with parameters and with what is named of it: s_j = ∂y₀/∂p_j.

What is named moves as asked. Of a machine with constraints the rest is found by a search (`gauss_newton`), and what it
finds is differentiated, along its own steps for the coordinates, since where conditions leave some open these depend on
the way,

    δ = -A⁺ φ,    dδ = -A⁺ dφ - dA⁺ φ,
    dA⁺ = -A⁺ dA A⁺ + A⁺ A⁺ᵀ dAᵀ (1 - A A⁺) + (1 - A⁺ A) dAᵀ A⁺ᵀ A⁺,

and by what the speeds fulfil: ψ = G u + g = 0 with (u - u₀)ᵀ M (u - u₀) least,

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
from ...dynamics.constrained import DEPENDENT, STEPS
from ...dynamics.constraints import linearized
from ...errors import SimulationError
from ...model import Model
from ...program.kernels import compile_tape
from ...scalar.derivative import forward
from ...scalar.trace import Tape
from ..kernels.kernels import Kernels, Program
from ..ode.dense_output import observe
from .initial import named_state, quaternions_by_joint

Array = NDArray[np.float64]


def start_slopes(
    kernels: Kernels, unknowns: Sequence[Any], y: Array, values: Mapping[str, float], initial: Mapping[Any, Any],
    near: Mapping[Any, Any], t: float,
) -> Array:  # fmt: skip
    """The s_j at the start ``y`` = (q, u), shape (unknowns, size of the kernels' state).

    Raises
    ------
    SimulationError
        What is named holds the constraints so that the rest can not follow.
    """
    model = kernels.model
    begun, named = named_state(model, values, initial)
    slopes = _as_named(model, unknowns, begun, values, initial)
    if model.constraints:
        wanted = {one.place for one in unknowns if one.symbol is None}
        if wanted <= named:
            guess, guessed = named_state(model, values, near, "near")
            others = sorted(guessed - named)
            begun[others] = guess[others]
            slopes[:, others] = _as_named(model, unknowns, guess, values, near)[:, others]
        else:  # what is asked for as if it were named: from where it was found
            begun, slopes = y.copy(), _as_named(model, unknowns, y, values, {})
        search = _Search(kernels, unknowns, values, t)
        q = search.coordinates(begun, slopes, named | wanted)
        slopes = search.speeds(y, begun, q, slopes, named | wanted)
        search.check(y, slopes, initial)
    result = np.zeros((len(unknowns), kernels.size))
    result[:, : y.size] = slopes
    return result


def _as_named(
    model: Model, unknowns: Sequence[Any], begun: Array, values: Mapping[str, float], named: Mapping[Any, Any]
) -> Array:
    """The s_j of what is named and of the unknowns, where the rest stands still at ``begun``."""
    names = [*model.coordinate_names, *model.speed_names]
    result = np.zeros((len(unknowns), len(names)))
    turned = quaternions_by_joint(model)
    symbols = {p.symbol: values[p.name] for p in model.parameters}
    raw = begun.copy()  # quaternions as they were given, before they were made unit
    for key, value in named.items():
        name = model.names.text_of(key)
        parts = [(names.index(name), value)] if name in names else []
        if name in turned and not hasattr(value, "as_quaternion"):
            parts = [(turned[name] + k, x) for k, x in enumerate(value)]
        for i, part in parts:
            expression = model.names.expression(part, f"the initial value of '{name}'")
            if not isinstance(expression, sympy.Basic):
                raw[i] = float(expression)
                continue
            raw[i] = float(expression.subs(symbols))
            for j, one in enumerate(unknowns):
                if one.symbol is not None:
                    result[j, i] = float(expression.diff(one.symbol).subs(symbols))
    for j, one in enumerate(unknowns):
        if one.symbol is None:
            result[j, one.place] = 1.0
    for i in model.quaternions:
        result[:, i : i + 4] = _unit(raw[i : i + 4], result[:, i : i + 4])
    return result


def _unit(r: Array, dr: Array) -> Array:
    """e = r/|r|: de = (1 - e eᵀ) dr/|r|, by rows."""
    length = np.linalg.norm(r)
    e = r / length
    return (dr - np.outer(dr @ e, e)) / length


class _Search:
    """The search for a start of a machine with constraints, and its derivatives by the unknowns."""

    def __init__(
        self, kernels: Kernels, unknowns: Sequence[Any], values: Mapping[str, float], t: float
    ) -> None:
        self.kernels, self.model, self.unknowns, self.t = kernels, kernels.model, unknowns, t
        self.parameters = kernels.parameters(values)
        self.program = self._program()
        self.constants = self.program.constants(self.parameters)
        self.of_places = [i for i, on_speeds in enumerate(kernels.on_speeds) if not on_speeds]

    def _program(self) -> Program:
        """Functions of (y, s_1, s_2, ..., u - u₀, λ), each followed by its derivatives along every s_j: ``conditions``
        (φ or ψ, G), ``moved`` (q') and ``speeds`` (ψ, M (u - u₀) - Gᵀ λ)."""
        model, programs = self.model, self.kernels._programs
        key = ("slopes of the start", tuple(one.name for one in self.unknowns))
        if key not in programs:
            tape = Tape()
            state = traced_state(model, tape)
            y = [*state.q, *state.u]
            rows = [
                [tape.input(f"derivative {i} by {one.name}") for i in range(len(y))] for one in self.unknowns
            ]
            given = linearized(model, state)
            w = [tape.input(f"{speed.name} less its guess") for speed in model.speeds]
            multipliers = [tape.input(f"multiplier {i}") for i in range(len(given.rate))]
            parameters = [state.values[p.symbol] for p in model.parameters]
            M = mass_matrix(model, state)
            least = [
                sum((M[i][j] * w[j] for j in range(model.n_u)), 0)
                - sum((row[i] * x for row, x in zip(given.matrix, multipliers, strict=True)), 0)
                for i in range(model.n_u)
            ]

            def along(outputs: list[Any]) -> list[Any]:
                result = list(outputs)
                for one, row in zip(self.unknowns, rows, strict=True):
                    moving = [] if one.symbol is None else [state.values[one.symbol]]
                    result += forward(tape, outputs, [*y, *moving], [*row, *[1 for _ in moving]])
                return result

            functions = {
                "conditions": along([*given.residual, *(x for row in given.matrix for x in row)]),
                "moved": along(list(coordinate_rates(model, state))),
                "speeds": along([*given.rate, *least]),
            }
            listed = [*y, *(x for row in rows for x in row), *w, *multipliers]
            programs[key] = Program(compile_tape(tape, functions, state.t, listed, parameters))
        return programs[key]

    def _at(self, function: str, y: Array, slopes: Array, *more: Array) -> tuple[Array, Array]:
        """A function of the program, and its derivatives by rows."""
        rest = np.zeros(self.model.n_u + len(self.kernels.on_speeds))
        state = np.concatenate([y, slopes.ravel(), *(more or (rest,))])
        count = self.program.outputs(function)
        found = observe(
            self.program.address(function), count, np.array([self.t]), state[None], self.constants
        )
        both = found.reshape(1 + len(self.unknowns), -1)
        return both[0], both[1:]

    def coordinates(self, begun: Array, slopes: Array, named: set[int]) -> Array:
        """∂q/∂p where the search ends, from ``begun`` and its derivatives."""
        model = self.model
        n_q, n = model.n_q, model.n_u
        y, s = begun.copy(), slopes.copy()
        held = {j for i in named if i < n_q for j in model.moved_by[i]}
        free = [j for j in range(n) if j not in held]
        m, k = len(self.kernels.on_speeds), len(self.unknowns)
        met = 0
        for _ in range(STEPS):
            y[n_q:], s[:, n_q:] = 0.0, 0.0
            value, along = self._at("conditions", y, s)
            phi, dphi = value[self.of_places], along[:, self.of_places]
            A = value[m:].reshape(m, n)[self.of_places][:, free]
            dA = along[:, m:].reshape(k, m, n)[:, self.of_places][:, :, free]
            met += np.abs(phi).max(initial=0.0) < DEPENDENT * (1 + np.abs(begun[:n_q]).max(initial=0.0))
            P = np.linalg.pinv(A, rcond=DEPENDENT)
            step = -P @ phi
            turned = dA.transpose(0, 2, 1)
            dP = (
                -P @ dA @ P
                + P @ P.T @ turned @ (np.eye(len(phi)) - A @ P)
                + (np.eye(len(free)) - P @ A) @ turned @ P.T @ P
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
            if met > 2:
                break
        return s[:, :n_q]

    def speeds(self, y: Array, begun: Array, q: Array, slopes: Array, named: set[int]) -> Array:
        """The s_j of all, from those of the coordinates and of the speeds that the search began with."""
        n_q, n, m = self.model.n_q, self.model.n_u, len(self.kernels.on_speeds)
        free = [j for j in range(n) if n_q + j not in named]
        program = self.kernels.closing()
        constants = program.constants(self.parameters)
        found = observe(program.address("motion"), m + m * n + n * n, np.array([self.t]), y[None], constants)[
            0
        ]
        G, M = (
            found[m : m + m * n].reshape(m, n)[:, free],
            found[m + m * n :].reshape(n, n)[np.ix_(free, free)],
        )
        w = y[n_q:] - begun[n_q:]
        multipliers = np.linalg.lstsq(G.T, M @ w[free], rcond=DEPENDENT)[0]
        s = np.concatenate([q, slopes[:, n_q:]], axis=1)
        s[:, [n_q + j for j in free]] = 0.0
        _, along = self._at("speeds", y, s, w, multipliers)
        A = np.block([[M, -G.T], [G, np.zeros((m, m))]])
        b = np.concatenate(
            [slopes[:, [n_q + j for j in free]] @ M - along[:, m:][:, free], -along[:, :m]], axis=1
        )
        s[:, [n_q + j for j in free]] = np.linalg.lstsq(A, b.T, rcond=1e-11)[0][: len(free)].T
        return s

    def check(self, y: Array, slopes: Array, initial: Mapping[Any, Any]) -> None:
        """The s_j keep the conditions on coordinates and on speeds."""
        m = len(self.kernels.on_speeds)
        missed = np.concatenate(
            [
                self._at("conditions", y, slopes)[1][:, self.of_places],
                self._at("speeds", y, slopes)[1][:, :m],
            ],
            axis=1,
        )
        for one, row, slope in zip(self.unknowns, missed, slopes, strict=True):
            if not np.abs(row).max(initial=0.0) <= 1e-7 * (1 + np.abs(slope).max(initial=0.0)):
                raise SimulationError(
                    f"The start can not follow a change of '{one.name}': the constraints of '{self.model.name}' hold "
                    f"what is named in initial ({', '.join(map(str, initial)) or 'nothing'}). Name less, so that the "
                    "rest can follow, or use near=."
                )
