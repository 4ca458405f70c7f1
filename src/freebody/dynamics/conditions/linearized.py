"""Derivatives of the conditions: G and g of the rate ψ = G u + g, and γ of its rate G u' + γ.

They are derivatives of the residuals along a motion, taken by truncated series, so that no condition needs derivatives
of its own. G and γ of joints that hold two points together, however, follow from the motion of the bodies, with fewer
operations (`loop_ends`).

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 8, with exact γ.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

from ...model.closure import Closure
from ...model.contact_modes import Touching
from ...model.model import Model
from ...scalar.algebra import (
    Scalar,
    apply,
)
from ...scalar.series import derivative_at_start, value_at_start
from ..kinematics import (
    replaced,
    rotation,
    state_along,
)
from ..linear import entries
from ..state import State
from .constraint_forces import friction_along_tangents
from .constraints import count_of_contact, count_of_pin, from_carrier, own_rows, residuals, rows
from .contact import ContactRows, rows_of
from .dependence import dependence, directions
from .loop_ends import carrier_of, last_link, loop_rows


class Linearized:
    """The conditions at a state: residual φ (or ψ), rate ψ, matrix G of the speeds and γ; one entry per row.

    Each is computed when it is first used: as a formula γ can be far longer than the rest.
    """

    def __init__(self, model: Model, state: State) -> None:
        self._model = model
        self._state = state
        self._kinds = rows(model)
        places = {row.owner: i for i, row in reversed([*enumerate(self._kinds)])}
        self.touching = [
            (places[name], c) for name, c in model.constraints.items() if isinstance(c, Touching)
        ]
        self._pins = [
            (places[name], c)
            for name, c in model.constraints.items()
            if isinstance(c, Closure) and c.in_ground
        ]

    def _in_ground(self, pin: Closure) -> tuple[list[list[Scalar]], list[Scalar]]:
        """Return G and γ of a pin, its force in ground axes."""
        G, bias = loop_rows(self._model, self._state, pin, carrier_of(self._model, pin))
        R = from_carrier(self._model, self._state, pin)
        # a zero times a float is not a plain zero
        columns = [apply(R, x) if entries(x) else x for x in zip(*G[:3], strict=True)]
        return [*map(list, zip(*columns, strict=True)), *G[3:]], [
            *apply(R, (bias[0], bias[1], bias[2])),
            *bias[3:],
        ]

    def in_loop_axes(
        self, active: Sequence[int]
    ) -> tuple[dict[int, tuple[Any, Any]], list[tuple[list[int], Any]]]:
        """Return G and γ of pins with the force in axes of the loop, in which more is constant, and the way back.

        Returns
        -------
        rows : dict
            Row -> (row of G, γ).
        back : list of (rows, matrix)
            The matrix times the multipliers gives the multipliers along ground axes.
        """
        result: dict[int, tuple[Any, Any]] = {}
        back = []
        for i, pin in self._pins:
            link = last_link(self._model, pin)
            R = rotation(self._model, self._state, link)
            used = [k for k in range(3) if i + k in active]
            # R must not mix used and unused rows: there are no unused ones, or the loop moves in a plane
            unused = [k for k in range(3) if k not in used]
            if used and all(entries((R[a][b], R[b][a])) == [] for a in used for b in unused):
                G, bias = loop_rows(self._model, self._state, pin, link)
                result |= {i + k: (G[k], bias[k]) for k in used}
                back.append(([i + k for k in used], [[R[a][b] for b in used] for a in used]))
        return result, back

    def _contact_rows(self, touching: Touching) -> ContactRows:
        return rows_of(self._model, self._state, (touching.contact,))

    def _with_contacts(self, result: list[Any], name: str) -> tuple[Any, ...]:
        """Return values of all rows, with those of closed contacts from their own rows."""
        for i, touching in self.touching:
            own = getattr(self._contact_rows(touching), name)
            result[i : i + count_of_contact(touching)] = own[own_rows(touching)]
        return tuple(result)

    @cached_property
    def residual(self) -> tuple[Scalar, ...]:
        """φ of conditions on coordinates, ψ of those on speeds."""
        return tuple(residuals(self._model, self._state))

    @cached_property
    def rate(self) -> tuple[Scalar, ...]:
        """ψ = G u + g."""
        along = _along_motion(self._model, self._state, self._state.u, 1, 1)
        pairs = zip(along, self._kinds, strict=True)
        result = [value_at_start(r) if kind.on_speeds else derivative_at_start(r, 1) for r, kind in pairs]
        return self._with_contacts(result, "rate")

    @cached_property
    def bias(self) -> tuple[Scalar, ...]:
        """γ, the part of ψ' that is free of accelerations."""
        along = _along_motion(self._model, self._state, self._state.u, 1, 2, pins=False)
        pairs = zip(along, self._kinds, strict=True)
        result = [derivative_at_start(r, 1 if kind.on_speeds else 2) for r, kind in pairs]
        for i, pin in self._pins:
            result[i : i + count_of_pin(pin)] = self._in_ground(pin)[1]
        return self._with_contacts(result, "bias")

    @cached_property
    def matrix(self) -> tuple[tuple[Scalar, ...], ...]:
        """G, a row per condition and a column per speed."""
        model, state, kinds = self._model, self._state, self._kinds
        depends = dependence(model)
        at_rest: list[Scalar] = []
        if any(kind.on_speeds for kind in kinds):
            zeros = [0] * model.n_u
            at_rest = residuals(model, replaced(state, state.field, state.t, state.q, zeros), contacts=False)
        columns: list[dict[int, Scalar]] = [{} for _ in kinds]
        for moving in directions(depends.values()):
            unit = [int(j in moving) for j in range(model.n_u)]
            for i, r in enumerate(_along_motion(model, state, unit, 0, 1, pins=False)):
                for j in moving & depends[kinds[i].owner]:
                    columns[i][j] = (
                        value_at_start(r) - at_rest[i] if kinds[i].on_speeds else derivative_at_start(r, 1)
                    )
        result = [tuple(row.get(j, 0) for j in range(model.n_u)) for row in columns]
        for i, pin in self._pins:
            result[i : i + count_of_pin(pin)] = map(tuple, self._in_ground(pin)[0])
        return self._with_contacts(result, "matrix")

    @cached_property
    def acting(self) -> tuple[tuple[Scalar, ...], ...]:
        """Generalized force per unit multiplier: the rows of G, and for contacts that slip W_N - μ Σ d W_T."""
        result = list(self.matrix)
        for i, touching in self.touching:
            if touching.slips and not touching.contact.frictionless:
                row = list(result[i])
                shares = friction_along_tangents(self._model, self._state, touching, 1)
                for share, tangent in zip(shares, self._contact_rows(touching).matrix[1:], strict=True):
                    row = [a + share * b for a, b in zip(row, tangent, strict=True)]
                result[i] = tuple(row)
        return tuple(result)

    @property
    def symmetric(self) -> bool:
        """True if all forces act along their own conditions, which sliding friction does not."""
        return not any(c.slips and not c.contact.frictionless for _, c in self.touching)


def linearized(model: Model, state: State) -> Linearized:
    """Return φ, ψ, G and γ of all conditions at a state."""
    if "constraints" not in state.cache:
        state.cache["constraints"] = Linearized(model, state)
    return state.cache["constraints"]


def _along_motion(
    model: Model, state: State, u: Sequence[Scalar], clock: int, order: int, pins: bool = True
) -> list[Scalar]:
    """Return the residuals as series along q' = N(q) u with u constant; ``clock`` is the rate of time."""
    return residuals(model, state_along(model, state, u, clock, order), contacts=False, pins=pins)
