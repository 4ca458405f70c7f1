"""What a method needs of a model besides its rates, recorded from the same algorithms.

    radau        (∂f/∂y) v, the derivative of the rates along a direction: of (y, v)
    structure    Hamilton's equations: q', P' of (q, P), P of (q, u), u of (q, P)

Hamilton's equations come from the Lagrangian: with u = M⁻¹ p fixed, and p = B(q)ᵀ P,

    P' = ∂/∂q (½ uᵀ M(q) u - V(q) - Pᵀ B(q) u)

since what is differentiated is stationary in u. No mass matrix is differentiated but through its own trace.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..compile.kernels import compile_tape
from ..dynamics import State, coordinate_rates, mass_matrix, potential_energy, traced_state
from ..dynamics.linear import Factorization
from ..dynamics.motion import motion, total_power
from ..scalar.algebra import HALF
from ..scalar.derivative import forward, transposed
from ..scalar.trace import Tape, Traced
from .kernels import Kernels, Program


def tangent(kernels: Kernels) -> Program:
    """Function ``tangent`` of (t, (y, v)): (∂f/∂y) v, one sweep along the trace of the rates."""
    if "tangent" not in kernels._programs:
        tape = Tape()
        model = kernels.model
        state = traced_state(model, tape)
        moving = motion(model, state, kernels.active)
        outputs = [*coordinate_rates(model, state), *moving.udot]
        y = [*state.q, *state.u]
        if kernels.works:
            outputs.append(total_power(model, state, moving))
            y.append(tape.input("work done"))
        v = [tape.input(f"direction {i}") for i in range(len(y))]
        parameters = [state.values[parameter.symbol] for parameter in model.parameters]
        given = {"tangent": forward(tape, outputs, y, v)}
        kernels._programs["tangent"] = Program(compile_tape(tape, given, state.t, [*y, *v], parameters))
    return kernels._programs["tangent"]


def hamilton(kernels: Kernels) -> Program:
    """Functions ``hamilton`` (q', P') and ``speeds`` u of (t, (q, P)), ``momenta`` P of (t, (q, u))."""
    if "hamilton" not in kernels._programs:
        model, tape = kernels.model, Tape()
        traced = traced_state(model, tape)
        P = [tape.input(f"second half {i}") for i in range(model.n_q)]  # u stands in the same places

        def at(u: Sequence[Any]) -> State:
            return State(model, tape, traced.t, traced.q, u, traced.values)

        given = at(P[: model.n_u])
        M = mass_matrix(model, given)
        p = transposed(tape, coordinate_rates(model, given), P, given.u)
        u = Factorization(M).solve(p)
        rates = coordinate_rates(model, at(u))
        # a function of q, P and u, in which u is held
        held = [x for x in u if type(x) is Traced]
        lagrangian = HALF * _dot(u, [_dot(row, u) for row in M]) - potential_energy(model, given)
        gradient = transposed(tape, [lagrangian - _dot(P, rates)], [1], [*given.q, *held])[: model.n_q]
        # back: P = D B p, where D is 4 for a quaternion, whose B has columns of length ½
        weights = np.ones(model.n_q, dtype=int)
        for i in model.quaternions:
            weights[i : i + 4] = 4
        spread = coordinate_rates(model, at([_dot(row, given.u) for row in M]))
        momenta = [int(d) * x for d, x in zip(weights, spread, strict=True)]
        functions = {"hamilton": [*rates, *gradient], "speeds": u, "momenta": momenta}
        parameters = [given.values[parameter.symbol] for parameter in model.parameters]
        kernels._programs["hamilton"] = Program(
            compile_tape(tape, functions, given.t, [*given.q, *P], parameters)
        )
    return kernels._programs["hamilton"]


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    total: Any = 0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total
