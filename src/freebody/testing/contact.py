"""The battery of a kind of contact."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..describe.contacts.gap import Gap
from ..describe.loads.action import PointForce
from ..errors import ModelError
from .comparison import machine_with, same, same_after_a_file
from .states import polynomial_value, random_state, state_values


def check_contact(kind: type[Gap], /, seed: int = 0, **data: Any) -> None:
    """Check a kind of contact on a machine of its own; fields without ``data`` get random values.

    At a zero gap the power of its normal force is the rate of the gap, and its tangents move along the surfaces; the
    forces on all bodies are in balance; floats and formulas agree; a kind with a name in files is the same when read
    again.

    Parameters
    ----------
    kind : subclass of Gap
    seed : int
        Seed of the random machine, state and data.
    **data : optional
        Values of fields, such as ``friction=0.3``.

    Raises
    ------
    AssertionError
        It says which law does not hold.

    Examples
    --------
    >>> from freebody.describe.contacts.stop import Stop
    >>> check_contact(Stop, low=0.5, high=None)
    """
    from ..dynamics.conditions.contact import contact_rows, touches, unit_forces
    from ..dynamics.kinematics import coordinate_rates, point_position, state_along
    from ..dynamics.state import float_state, polynomial_state
    from ..model.assemble import assemble
    from ..scalar.polynomial import Ring
    from ..scalar.series import derivative_at_start

    s = machine_with(kind, seed, data)
    model = assemble(s)
    q, u = random_state(model, seed)
    for _ in range(100):  # to a zero gap, by Newton's method in short steps
        state = float_state(model, q, u)
        gap = float(touches(model, state)[0].gap)
        moved = [
            touches(model, state_along(model, state, row, 0, 1))[0].gap for row in np.eye(len(u)).tolist()
        ]
        slope = np.array([float(derivative_at_start(x)) for x in moved])
        if not slope.any():
            break
        step = -gap / (slope @ slope) * slope
        step = (step / max(1.0, 4 * float(np.abs(step).max()))).tolist()
        change = coordinate_rates(model, float_state(model, q, step))
        q = [a + float(d) for a, d in zip(q, change, strict=True)]
    state = float_state(model, q, u)
    given = contact_rows(model, state)
    if abs(float(given.gap[0])) > 2**-32:
        raise ModelError(
            f"Expected a state with a zero gap of {kind.__name__}, found none near a gap of {float(given.gap[0]):.3g}. "
            f"Give other data: check_contact(kind, field=...)."
        )
    along = touches(model, state_along(model, state, state.u, 1, 1))
    gaps = [float(derivative_at_start(touch.gap)) for touch in along]
    rates = [float(x) for x in given.rate]
    first = np.cumsum([0, *(1 + contact.tangents for contact in model.contacts)])[:-1]
    same(
        kind,
        "the power of the normal force and the rate of the gap",
        [rates[k] for k in first],
        gaps,
        [1.0, *rates],
    )
    same(kind, "the rates and W u", rates, np.array(given.matrix, float) @ u, [1.0, *rates])
    for contact in model.contacts:
        for k, row in enumerate(unit_forces(model, state, contact)):
            pushes = [action for action in row if isinstance(action, PointForce)]
            places = [np.array(point_position(model, state, push.point), float) for push in pushes]
            forces = [np.array(push.force, float) for push in pushes]
            moments = [np.cross(p, f) for p, f in zip(places, forces, strict=True)]
            total = [x for sums in (forces, moments) for x in np.sum([np.zeros(3), *sums], axis=0).tolist()]
            same(kind, f"force {k} of contact '{contact.name}' and its opposite", total, [0.0] * 6, [1.0])
    values = state_values(model, q, u)
    symbols = contact_rows(model, polynomial_state(model, Ring()))
    same(
        kind,
        "rates as numbers and as formulas",
        rates,
        [polynomial_value(x, values) for x in symbols.rate],
        rates,
    )
    if kind.kind:
        same_after_a_file(
            kind, s, lambda again: [float(x) for x in contact_rows(again, float_state(again, q, u)).rate]
        )
