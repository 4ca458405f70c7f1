"""Quantities of contacts in a phase as dual numbers: of what sensors give, and of what events watch.

In each mode they are what functions of the user take (`phase.endings.quantity`); the slopes of a dual number are its
derivatives along some ways.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ....scalar.algebra import floats
from ....scalar.dual import DualField, value_of
from ...kernels.contact_quantities import NAMES, Asked, OfContacts, asked_by
from ...legs.driven_slopes import dual_of, dual_state
from ...ode.dense_output import Array
from ...phase.phase import Phase
from ...trajectory.outputs import OfContact
from .slopes import ADHESION, Slopes, Touch, refused, title, turned_points, without_derivative

Way = tuple[Array, float, Array]
"""Changes of (q, u), of the time and of the symbols of `Slopes`."""


def quantities(
    of: Slopes, phase: Phase | None, asked: Asked, t: float, y: Array, ways: Sequence[Way]
) -> Mapping[Any, Any]:
    """Return quantities of contacts at a state of a phase, or before the first one, where all are open.

    Raises
    ------
    NoDerivativesError
        The margin of a contact that is about to bear friction; the force of a point that has turned with the load.
    """
    ahead = [] if phase is None else [of.along(phase, t, y, *way) for way in ways]
    names = [contact.name for contact in of.model.contacts]
    turned = (
        [k for points in turned_points(of.model, of.parameters) for k in points] if of.model.rings else []
    )

    def one(name: str, what: str, j: int) -> Any:
        k = names.index(name)
        contact, mode = of.model.contacts[k], "open" if phase is None else phase.modes[k]
        touches = [of.touch(x, k) for x in ahead] or [of.of_contact(k, t, y, *way) for way in ways]

        def dual(read: Callable[[Touch], Any]) -> Any:
            return dual_of(read(of.outputs(k, t, y)), [read(x) for x in touches])

        if what in ("gap", "approach"):
            if mode != "open" and not contact.compliant:
                return 0.0
            return dual(lambda x: x.gap) if what == "gap" else -dual(lambda x: x.rates[0])
        if what == "slip":
            return 0.0 if mode == "stick" else dual(lambda x: x.rates[1 + j])
        if phase is None or mode == "open":
            return 0.0
        if k in turned:
            what = "the points on which a disk lies have turned with the load, and with them the force of"
            raise refused(of, t, f"{what} {title(of, k)}")
        first, n, forces = of.scene.first[k], of.scene.tangents[k], of.forces(phase, t, y)
        N, *T = [dual_of(forces[r], [x.forces[r] for x in ahead]) for r in range(first, first + 1 + n)]
        if what != "margin":
            return N if what == "normal" else T[j]
        mu, static, load = (
            dual(lambda x: x.laws[0]),
            dual(lambda x: x.laws[1]),
            N + dual(lambda x: x.laws[ADHESION]),
        )
        if mode != "stick":
            return (static - mu) * load
        if any(value_of(x) != 0 for x in T):
            return static * load - DualField(floats).sqrt(sum(x * x for x in T))
        if any(x != 0 for x in T):
            raise refused(of, t, f"{title(of, k)} begins to bear friction, of which the margin has the size")
        return static * load

    return {terms: sum(one(*term) for term in terms) for terms in asked}


def check(of: Slopes, quantity: OfContact, t: float, y: Array) -> None:
    """Refuse an output of a contact that has no derivative.

    Raises
    ------
    NoDerivativesError
        One of forces with two coefficients, or beyond the end of a side.
    """
    k = [contact.name for contact in of.model.contacts].index(quantity.contact)
    two = of.model.contacts[k].friction_across is not None and quantity.what in (
        "tangential",
        "slip",
        "margin",
    )
    beyond = quantity.what in ("gap", "approach") and of.look(t, y).reach[k] < 0
    if quantity.what not in NAMES or two or beyond:
        raise without_derivative(f"{quantity.contact}.{quantity.what}")


def value_along(
    of: Slopes, phase: Phase, expression: OfContacts, t: float, y: Array, ways: Sequence[Way]
) -> Any:
    """Return an expression of quantities of contacts at a state of a phase."""
    s, tau, dp = (np.array(part) for part in zip(*ways, strict=True))
    moved = {symbol: dp[:, i] for i, symbol in enumerate(of.symbols)}
    values = [
        dual_of(value, moved.get(parameter.symbol, ()))
        for parameter, value in zip(of.model.parameters, of.parameters, strict=True)
    ]
    state = dual_state(
        of.model, dual_of(t, tau), [dual_of(x, way) for x, way in zip(y, s.T, strict=False)], values
    )
    return expression.value(state, quantities(of, phase, asked_by([expression]), t, y, ways))
