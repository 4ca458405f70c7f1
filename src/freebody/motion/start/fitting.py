"""Round shapes that fit into what they touch: a hollow is larger, and a line of heights touched at one place only.

A line y = f(x) has the curvature κ = f''/(1 + f'²)^(3/2). A circle of radius R touches it at one place if R κ < 1
everywhere, and the root that is this place is found if R κ changes by less than 1 - R κ over the distance 2⁻²⁰ R that
bisections leave (`Field.root`). Both are proven by bounds over ranges of x, which are halved where that is not enough.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, cast

import numpy as np

from ...describe.shapes.heightline import Heightline
from ...dynamics.state import State, float_state
from ...errors import SimulationError
from ...model.contact import Contact
from ...model.model import Model
from ...scalar.algebra import BISECTIONS
from ...scalar.expression import evaluate
from .intervals import Array, Interval, interval, intervals

FAR = 60
"""A line without ends is looked at up to 2**60 radii from its origin, where positions in doubles are coarse."""
HALVINGS, MOST = 60, 1 << 14
"""Most halvings of a range, and most ranges at once."""

CURE = (
    "Divide the line there, body.heightline(..., between=(start, end)), with a contact for each part; take a smaller "
    "circle; or give the line points or corners."
)


def refuse_misfits(model: Model, values: Mapping[str, float]) -> None:
    """Raise SimulationError if a round shape does not fit a hollow or its line of heights with these parameters."""
    state = None
    for name, inner, hollow in _hollows(model):
        state = state or float_state(model, values=values)
        r, R = float(state(inner.radius)), float(state(hollow.radius))
        if r >= R:
            raise SimulationError(
                f"The {inner.kind} of contact '{name}' has the radius {r:.6g} m and does not fit inside a "
                f"{hollow.kind} of radius {R:.6g} m. A shaft without play is a joint: s.revolute(...)."
            )
    for contact, shape, line in _pairs(model.contacts):
        state = state or float_state(model, values=values)
        _check(contact, shape, line, state)


def _hollows(model: Model) -> Iterable[tuple[str, Any, Any]]:
    """Yield contact, inner shape and hollow, once for each pair of radii; numbers were compared when declared."""
    seen = set()
    for contact in model.contacts:
        if contact.law is None and _is_around(contact.surface) and hasattr(contact.feature, "radius"):
            yield contact.name, contact.feature, contact.surface
    for family in model.families:
        for j, hollow in enumerate(family.members):
            if not _is_around(hollow.shape):
                continue
            for i, inner in enumerate(family.members):
                r = getattr(inner.shape, "radius", None)
                if r is not None and (r, hollow.shape) not in seen and family.meet(i, j):
                    seen.add((r, hollow.shape))
                    yield family.label(i, j), inner.shape, hollow.shape


def _is_around(shape: Any) -> bool:
    """Return True for a round hollow."""
    return shape.inside and hasattr(shape, "radius")


def _pairs(contacts: Iterable[Contact]) -> Iterable[tuple[Contact, Any, Heightline]]:
    for contact in contacts:
        for line, shape in ((contact.surface, contact.feature), (contact.feature, contact.surface)):
            if line.look == "profile" and hasattr(shape, "radius"):
                yield contact, shape, cast(Heightline, line)


def _check(contact: Contact, shape: Any, line: Heightline, state: State) -> None:
    """Raise SimulationError unless the ranges between the ends are proven, each as it is or in parts."""
    R = float(state(shape.radius))
    what = f"The {shape.kind} of contact '{contact.name}' has the radius {R:.6g} m"
    ends = _ends(contact, line, R, state)
    low, high = ends[:-1], ends[1:]
    with np.errstate(all="ignore"):
        for _ in range(HALVINGS):
            curvature, change = _bent(line, R, state, Interval(low, high))
            most = np.maximum(np.abs(change.low), np.abs(change.high))
            unproven = ~(R * most < (1 - curvature.high) * 2.0**BISECTIONS)
            if not unproven.any():
                return
            low, high = low[unproven], high[unproven]
            middle = (low + high) / 2
            x = middle[int(np.argmin(np.abs(middle)))]
            larger = middle[_at(line, R, state, middle) >= 1]
            if larger.size:
                x = larger[int(np.argmin(np.abs(larger)))]
                near = np.clip(x + R * np.linspace(-1, 1, 4001), ends[0], ends[-1])
                bends = _at(line, R, state, near)
                worst = int(np.argmax(bends))
                raise SimulationError(
                    f"{what} and does not fit into the heightline {line.height}, whose radius of curvature is "
                    f"{R / bends[worst]:.6g} m at x = {near[worst]:.6g} m: they would touch in two places. {CURE}"
                )
            if len(low) > MOST:
                break
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    raise SimulationError(
        f"{what}, and the heightline {line.height} may curve as much, or change its curvature at once, near "
        f"x = {x:.6g} m, so that they may touch in two places. {CURE}"
    )


def _ends(contact: Contact, line: Heightline, R: float, state: State) -> Array:
    """Return the ends of the first ranges."""
    if not line.between:
        ends = R * 2.0 ** np.arange(-4, FAR)
        return np.concatenate([-ends[::-1], [0.0], ends])
    start, end = (float(state(x)) for x in line.between)
    if start >= end:
        raise SimulationError(
            f"The heightline {line.height} of contact '{contact.name}' must start before it ends, got "
            f"between=({start:g}, {end:g})."
        )
    return np.linspace(start, end, 17)


def _bent(line: Heightline, R: float, state: State, x: Interval) -> tuple[Interval, Interval]:
    """Return the bounds of R κ and R dκ/dx."""
    names: dict[Any, Any] = {**state.values, line.variable: x}
    slope, bend, change = (
        evaluate(e, names, intervals, names) for e in (line.slope, line.bend, line.bend_rate)
    )
    square = 1 + slope * slope
    cube = square * intervals.apply("sqrt", square)
    return interval(R * bend / cube), interval(
        R * (change / cube - 3 * slope * bend * bend / (cube * square))
    )


def _at(line: Heightline, R: float, state: State, x: Array) -> Array:
    """Return R κ at some places, at least."""
    return np.asarray(_bent(line, R, state, Interval(x, x))[0].low + 0 * x)
