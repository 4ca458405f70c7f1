"""Round shapes that fit their line of heights: they touch it at one place, whatever they do.

A line y = f(x) has the curvature κ = f''/(1 + f'²)^(3/2). A circle of radius R touches it at one place if R κ < 1
everywhere, and the root that is this place is found if R κ changes by less than 1 - R κ over the distance 2⁻²⁰ R that
bisections leave (`Field.root`). Both are proven by bounds over ranges of x, which are halved where that is not enough.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...describe.shapes.heightline import Heightline
from ...dynamics.state import State, float_state
from ...errors import SimulationError
from ...model.contact import Contact
from ...model.model import Model
from ...scalar.algebra import BISECTIONS
from ...scalar.expression import evaluate
from .intervals import Array, Interval, intervals

FAR = 60
"""A line without ends is looked at up to 2**60 radii from its origin, where positions in doubles are coarse."""
HALVINGS, MOST = 60, 1 << 14
"""Most halvings of a range, and most ranges at once."""

CURE = (
    "Divide the line there, body.heightline(..., between=(start, end)), with a contact for each part; take a smaller "
    "circle; or give the line points or corners."
)


def refuse_misfits(model: Model, values: Mapping[str, float]) -> None:
    """Raise SimulationError if a round shape does not fit its line of heights with these values of the parameters."""
    state = None
    for contact, shape, line in _pairs(model.contacts):
        state = state or float_state(model, values=values)
        _check(contact, shape, line, state)


def _pairs(contacts: Iterable[Contact]) -> Iterable[tuple[Contact, Any, Heightline]]:
    for contact in contacts:
        for line, shape in ((contact.surface, contact.feature), (contact.feature, contact.surface)):
            if isinstance(line, Heightline) and hasattr(shape, "radius"):
                yield contact, shape, line


def _check(contact: Contact, shape: Any, line: Heightline, state: State) -> None:
    R = float(state(shape.radius))

    def bent(x: Interval) -> tuple[Interval, Interval]:
        """Return the bounds of R κ and R dκ/dx."""
        names = {**state.values, line.variable: x}
        memo: dict[Any, Any] = dict(names)
        slope, bend, change = (
            evaluate(e, names, intervals, memo) for e in (line.slope, line.bend, line.bend_rate)
        )
        square = 1 + slope * slope
        cube = square * intervals.apply("sqrt", square)
        return R * bend / cube, R * (change / cube - 3 * slope * bend * bend / (cube * square))

    ends = R * 2.0 ** np.arange(-4, FAR)
    ends = np.concatenate([-ends[::-1], [0.0], ends])
    if line.between:
        ends = np.linspace(*(float(state(x)) for x in line.between), 17)
    low, high = ends[:-1], ends[1:]
    with np.errstate(all="ignore"):
        for _ in range(HALVINGS):
            curvature, change = bent(Interval(low, high))
            most = np.maximum(np.abs(change.low), np.abs(change.high))
            open_ = ~(R * most < (1 - curvature.high) * 2.0**BISECTIONS)
            if not open_.any():
                return
            low, high = low[open_], high[open_]
            middle = (low + high) / 2
            at, _ = bent(Interval(middle, middle))
            if (at.low >= 1).any():
                raise _too_large(
                    contact, shape, line, R, middle[at.low >= 1], lambda x: bent(Interval(x, x))[0].low
                )
            if len(low) > MOST:
                break
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    nearest = middle[int(np.argmin(np.abs(middle)))]
    raise SimulationError(
        f"The {shape.kind} of contact '{contact.name}' has the radius {R:.6g} m, and the heightline {line.height} may "
        f"curve as much, or change its curvature at once, near x = {nearest:.6g} m, so that they may touch in two "
        f"places. {CURE}"
    )


def _too_large(
    contact: Contact, shape: Any, line: Heightline, R: float, found: Array, bend: Any
) -> SimulationError:
    """Return the error for a line that curves more than the circle, with the place nearest to its origin."""
    x = found[int(np.argmin(np.abs(found)))]
    near = x + R * np.linspace(-1, 1, 4001)
    worst = near[int(np.nanargmax(bend(near)))]
    radius = R / float(np.max(bend(np.array([worst]))))
    return SimulationError(
        f"The {shape.kind} of contact '{contact.name}' has the radius {R:.6g} m and does not fit into the heightline "
        f"{line.height}, whose radius of curvature is {radius:.6g} m at x = {worst:.6g} m: they would touch in two "
        f"places. {CURE}"
    )
