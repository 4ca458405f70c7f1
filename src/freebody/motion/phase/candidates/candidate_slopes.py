"""Derivatives of the kernels of a machine and of its contacts along a direction, whatever the modes.

    machine    of q', of h - Q of M u' + h - Q = 0, of M w at fixed w, and of γ and G of the machine's own conditions
    rates      of the rates of these conditions
    mass       M and G
    contact k  of each output of the contact's kernel (`candidates`), at the same place
    bearings   of the levers and forces of joints whose load bounds their friction, also along accelerations and forces

The direction is (s, τ, dp): changes of q and u, of time, and of parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

from ....dynamics import State, coordinate_rates
from ....dynamics.bearing_loads import LOADED
from ....dynamics.composite import mass_matrix
from ....dynamics.conditions.constraints import rows
from ....dynamics.conditions.linearized import linearized
from ....dynamics.contact_geometry import law_values, pressing
from ....dynamics.linear import applied
from ....dynamics.newton_euler import bias
from ....model.contact import Contact
from ....scalar.algebra import Scalar
from ....scalar.derivative import forward
from ....scalar.trace import Tape
from ...kernels.program import Program
from .candidates import Candidates


def along(
    state: State,
    outputs: Sequence[Scalar],
    symbols: Sequence[Any],
    given: Sequence[Scalar],
    others: Sequence[Scalar] = (),
) -> Any:
    """Return the derivatives of outputs along (s, τ, dp); dp are changes of the parameters ``symbols``.

    Changes of ``others``, further inputs, may follow.
    """
    wrt: list[Any] = [*state.q, *state.u, state.t, *(state.values[x] for x in symbols), *others]
    return forward(cast(Tape, state.field), outputs, wrt, given)


def normal_force_along(
    state: State, contact: Contact, symbols: Sequence[Any], given: Sequence[Scalar]
) -> Scalar:
    """Return Σ ∂N/∂x dx of a compliant normal force over the names of its law.

    As formulas the ∂N/∂x have values at depth 0, such as 3/2 k sqrt(d) of Hertz's law, where products of the
    derivatives of roots have none.
    """
    law, values = contact.normal_force, law_values(state.model, state, contact)
    names = sorted(law.free_symbols, key=str)
    parts = [state.with_values(law.diff(x), pressing(state, values)) for x in names]
    inner = [values[x] if x in values else state(x) for x in names]
    total: Scalar = 0
    for part, change in zip(parts, along(state, inner, symbols, given), strict=True):
        total = total + part * change
    return total


def bearing_slopes(candidates: Candidates, symbols: Sequence[Any]) -> Program:
    """Function ``bearings``: the outputs of `Candidates.bearings`, of each joint with their derivatives behind them.

    The inputs after the state are those of it, the direction, and their changes.
    """
    moved, count = candidates.model.n_q + candidates.model.n_u, candidates.inputs

    def functions(state: State, given: Sequence[Scalar]) -> Mapping[str, Sequence[Any]]:
        acting = given[:count]
        loads = candidates.bearings_of(state, acting)["bearings"]
        changes = along(state, loads, symbols, given[count:], acting)
        joints = range(0, len(loads), LOADED)
        return {"bearings": [x for i in joints for of in (loads, changes) for x in of[i : i + LOADED]]}

    key = ("slopes of bearings", tuple(map(str, symbols)))
    return candidates.kernels.program(key, functions, 2 * count + moved + 1 + len(symbols))


def candidate_slopes(candidates: Candidates, symbols: Sequence[Any]) -> Program:
    """Functions ``machine``, ``residuals``, ``rates``, ``mass``, ``contact 0``, ..., of the state and (w, s, τ, dp)."""
    model, active = candidates.model, candidates.kernels.active
    n, moved = model.n_u, model.n_q + model.n_u

    def functions(state: State, given: Sequence[Scalar]) -> Mapping[str, Sequence[Any]]:
        w, direction = given[:n], given[n:]
        M = mass_matrix(model, state)
        own = linearized(model, state)
        G = [x for i in active for x in own.matrix[i]]
        gamma, speeds = ([part[i] for i in active] for part in (own.bias, own.rate))
        kinds = rows(model)
        residuals = [0 if kinds[i].on_speeds else own.residual[i] for i in active]
        machine = [*coordinate_rates(model, state), *bias(model, state), *applied(M, w), *gamma, *G]
        of_contacts = {
            name: along(state, outputs, symbols, direction)
            for name, outputs in candidates.functions(state).items()
            if name.startswith("contact ")
        }
        for k in candidates.groups:
            contact, part = model.contacts[k], candidates.pattern.contacts[k]
            if contact.compliant:
                of_contacts[f"contact {k}"][part.laws + 4] = normal_force_along(
                    state, contact, symbols, direction
                )
        return {
            "machine": along(state, machine, symbols, direction),
            "residuals": along(state, residuals, symbols, direction),
            "rates": along(state, speeds, symbols, direction),
            "mass": [*(x for row in M for x in row), *G],
            **of_contacts,
        }

    key = ("slopes of candidates", tuple(map(str, symbols)))
    return candidates.kernels.program(key, functions, n + moved + 1 + len(symbols))
