"""The kernels that a method needs besides the rates, recorded from the same algorithms.

    radau        (∂f/∂y) v, the derivative of the rates along a direction, of (y, v)
    taylor       coefficients of the Taylor series of the motion through (t, y)
    structure    Hamilton's equations: q', P' of (q, P), P of (q, u), u of (q, P)

For a quaternion e, q' = B u is of degree 1 in e, and all other quantities are of degree 0. So H(s e, P/s) = H(e, P),
and e·P is conserved together with |e|².

Hamilton's equations follow from the Lagrangian: with u = M⁻¹ p fixed, and p = B(q)ᵀ P,

    P' = ∂/∂q (½ uᵀ M(q) u - V(q) - Pᵀ B(q) u)

since the differentiated expression is stationary in u. The mass matrix is differentiated only through its own trace.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ...dynamics import State, coordinate_rates, mass_matrix, potential_energy
from ...dynamics.linear import Factorization, scalar_product
from ...errors import ExpressionError, SimulationError
from ...model import Model
from ...native.records import padded
from ...program.kernels import compile_tape
from ...program.large.tree_loop import Directions, LoopedSet, is_large
from ...scalar.algebra import HALF, Scalar, divide
from ...scalar.derivative import forward, transposed
from ...scalar.trace import ADD, DIV, INPUT, MUL, NAMES, NEG, SUB, Tape, Traced
from .kernels import Kernels
from .program import Program


def tangent(kernels: Kernels) -> Program:
    """Return the program with the function ``tangent`` of (t, (y, v)): (∂f/∂y) v, by one sweep along the trace of the
    rates.
    """
    if "tangent" not in kernels.programs and is_large(kernels.model, "forward_dynamics_by_state"):
        along = Directions("rates", kernels.size)
        kernels.programs["tangent"] = Program(LoopedSet(kernels.model, directions=along))
    if "tangent" not in kernels.programs:
        tape, state, parameters = kernels.recorded()
        outputs, y = kernels.rates_of(state), [*state.q, *state.u]
        if kernels.works:
            y.append(tape.input("work done"))
        v = [tape.input(f"direction {i}") for i in range(len(y))]
        outputs_by_name = {"tangent": forward(tape, outputs, y, v)}
        kernels.programs["tangent"] = Program(
            compile_tape(tape, outputs_by_name, state.t, [*y, *v], parameters)
        )
    return kernels.programs["tangent"]


def series(kernels: Kernels) -> Program:
    """Return the program with the function ``series`` of (t, y): the coefficients of the motion
    (`program.series.jet`).
    """
    if "series" not in kernels.programs:
        tape, state, parameters = kernels.recorded()
        outputs, inputs = kernels.rates_of(state), [*state.q, *state.u]
        kernels.programs["series"] = series_of(kernels.model, tape, outputs, state.t, inputs, parameters)
    return kernels.programs["series"]


def series_of(
    model: Model,
    tape: Tape,
    rates: Sequence[Scalar],
    t: Scalar,
    y: Sequence[Scalar],
    parameters: Sequence[Scalar],
) -> Program:
    """Return the program with the function ``series`` of (t, y), from the recorded rates."""
    width = {"series": padded(len(rates))}
    try:
        return Program(compile_tape(tape, {"series": rates}, t, y, parameters, series=width))
    except ExpressionError as error:
        raise without_series(model, error) from None


def without_series(model: Model, error: ExpressionError) -> SimulationError:
    """Return the error for rates that bend or jump."""
    return SimulationError(
        f"Expected rates with a Taylor series for method=\"taylor\", but of '{model.name}' "
        f'{str(error).partition(" Known")[0]} Use method="dop853" or "gauss".'
    )


def hamilton(kernels: Kernels) -> Program:
    """Return the program with the functions ``hamilton`` (q', P') and ``speeds`` u of (t, (q, P)), and ``momenta`` P of
    (t, (q, u)).
    """
    if "hamilton" not in kernels.programs:
        model = kernels.model
        tape, traced, parameters = kernels.recorded()
        P = [tape.input(f"second half {i}") for i in range(model.n_q)]  # or u, at the same positions

        # H must not change with the length of a quaternion, or e·P would grow: divide each quaternion by its norm
        q = list(traced.q)
        norms: dict[int, Scalar] = {}
        for i in model.quaternions:
            norm = tape.sqrt(scalar_product(q[i : i + 4], q[i : i + 4]))
            q[i : i + 4] = [x / norm for x in q[i : i + 4]]
            norms.update(dict.fromkeys(range(i, i + 4), norm))

        def at(u: Sequence[Scalar]) -> State:
            return State(model, tape, traced.t, q, u, traced.values)

        def moved(u: Sequence[Scalar]) -> list[Scalar]:
            return [x * norms.get(i, 1) for i, x in enumerate(coordinate_rates(model, at(u)))]

        state = at(P[: model.n_u])
        M = mass_matrix(model, state)
        p = transposed(tape, moved(state.u), P, state.u)
        u = Factorization(M).solve(p)
        rates = moved(u)
        # differentiate at fixed u: u is an input of the Lagrangian, replaced by its value afterwards
        fixed_speeds = [tape.input(f"held {speed.name}") for speed in model.speeds]
        held_momenta = [scalar_product(row, fixed_speeds) for row in M]
        lagrangian = HALF * scalar_product(fixed_speeds, held_momenta) - potential_energy(model, state)
        gradient = transposed(tape, [lagrangian - scalar_product(P, moved(fixed_speeds))], [1], traced.q)
        gradient = replaced(tape, gradient, dict(zip(fixed_speeds, u, strict=True)))
        # the inverse is P = D B p, with D = 4 for a quaternion, whose B has columns of length ½
        weights = np.ones(model.n_q, dtype=int)
        for i in model.quaternions:
            weights[i : i + 4] = 4
        spread = moved([scalar_product(row, state.u) for row in M])
        momenta = [int(d) * x for d, x in zip(weights, spread, strict=True)]
        functions = {"hamilton": [*rates, *gradient], "speeds": u, "momenta": momenta}
        kernels.programs["hamilton"] = Program(
            compile_tape(tape, functions, state.t, [*traced.q, *P], parameters)
        )
    return kernels.programs["hamilton"]


def replaced(tape: Tape, outputs: Sequence[Scalar], values: Mapping[Traced, Scalar]) -> list[Scalar]:
    """Return the outputs with other scalars in place of inputs."""
    table: dict[int, Scalar] = {x.index: value for x, value in values.items()}
    for i in tape.used(outputs):
        code, a, b = tape.op[i], tape.a[i], tape.b[i]
        if i in table:
            continue
        if code <= INPUT:
            table[i] = tape.scalar(i)
        elif code in _ARITHMETIC:
            table[i] = _ARITHMETIC[code](table[a], table[b])
        elif code == NEG:
            table[i] = -table[a]
        else:
            table[i] = tape.apply(NAMES[code], *(table[x] for x in (a, b) if x >= 0))
    return [table[x.index] if type(x) is Traced else x for x in outputs]


_ARITHMETIC: dict[int, Callable[[Scalar, Scalar], Scalar]] = {
    ADD: operator.add,
    SUB: operator.sub,
    MUL: operator.mul,
    DIV: divide,
}
