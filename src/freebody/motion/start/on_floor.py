"""``fb.on_floor``: the start of a machine that stands on its floor.

A free joint, or slides in the ground, move what they carry without turning it. Along their displacements x the gaps
to a plane are linear: with the directions A of x and the unit vector e against gravity,

    x = x_0 + d Aᵀe,      g_i = g_i0 + d n_i·A Aᵀe,      d = max -g_i0 / (n_i·A Aᵀe)

So is the gap to a line of heights y = f(x) where e is along y.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ...describe.frame import Point
from ...describe.system import System
from ...dynamics.conditions.contact import touch
from ...dynamics.kinematics import place_of, point_position
from ...dynamics.state import float_state
from ...errors import ModelError, arguments_named
from ...model.assemble import assemble
from ...model.contact import Contact
from ...model.model import GROUND, Model
from ...scalar.algebra import IDENTITY, ZERO, Vector, dot, subtract
from .initial import named_state

LEAST = 1 / 10**9
"""Rate of a gap below which a body moves along the plane."""


@arguments_named
def on_floor(
    s: System | Model,
    *,
    initial: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
) -> dict[Any, Any]:
    """Return initial values with which the lowest place that may touch a floor touches it.

    Every part of the machine that a free joint or slides hold in the ground is moved against or along gravity, until
    its smallest gap to planes and lines of heights of the ground is zero. All other values stay as they are.

    Parameters
    ----------
    s : System or Model
        With contacts between bodies and planes or heightlines of the ground.
    initial : mapping, optional
        Initial values by name, as in :func:`freebody.simulate`.
    values : mapping, optional
        Values of parameters.

    Returns
    -------
    dict
        ``initial`` with other displacements.

    Raises
    ------
    ModelError
        A machine without gravity, without such contacts, or whose bodies cannot move along gravity.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("block on a floor")
    >>> s.gravity = (0, 0, -9.81)
    >>> block = s.body("block", fb.box(1, (0.2, 0.2, 0.6)))
    >>> air = s.free("air", s.ground, block)
    >>> floor = s.contact("floor", block.corners(size=(0.2, 0.2, 0.6)), s.ground.plane(normal="z"), friction=0.5)
    >>> fb.on_floor(s, initial={"air_x": 2})
    {'air_x': 2, 'air_z': 0.3}
    """
    model = s if isinstance(s, Model) else assemble(s)
    state, _ = named_state(model, model.values(values), initial or {})
    q = state[: model.n_q].tolist()
    up = _against_gravity(model, q, values)
    moved: dict[str, float] = {}
    for root, contacts in _on_floors(model, up).items():
        moved |= _raised(model, q, values, contacts, _slides(model, root), up)
    if not moved:
        raise ModelError(
            f"Expected a body of '{model.name}' that a free joint or slides let move along gravity, and that may touch "
            "a plane or a heightline of the ground, got none. A robot's file: fb.read(path, base='free', "
            "contacts='floor')."
        )
    names = model.names.texts
    rest = {key: x for key, x in (initial or {}).items() if names.get(key, key) not in moved}
    return {**rest, **moved}


def _against_gravity(model: Model, q: Sequence[float], values: Any) -> Vector:
    """Return the unit vector against gravity."""
    g = float_state(model, q, values=values).vector(model.gravity)
    length = math.hypot(*g)
    if length == 0:
        raise ModelError(f"Expected gravity in '{model.name}', which says where its floor is. Set s.gravity.")
    x, y, z = (-x / length for x in g)
    return x, y, z


def _on_floors(model: Model, up: Vector) -> dict[int, list[Contact]]:
    """Return the contacts with floors of the ground, by the link in the ground that carries the other body."""
    result: dict[int, list[Contact]] = {}
    for contact in model.contacts:
        ends = (contact.feature, contact.surface)
        still = [end for end in ends if end.body.is_ground]
        if contact.law is not None or len(still) != 1:
            continue
        if not (still[0].endless or (still[0].look == "profile" and up == IDENTITY[1])):
            continue
        link, _ = place_of(model, ends[1 if ends[0] is still[0] else 0].body)
        while model.links[link].parent != GROUND:
            link = model.links[link].parent
        result.setdefault(link, []).append(contact)
    return result


def _slides(model: Model, root: int) -> list[int]:
    """Return the coordinates that move the links of the joint that begins with a link in the ground."""
    joint = next(one for one in model.joints.values() if root in one.links)
    found = []
    for link in (model.links[k] for k in joint.links):
        if link.own and link.motion.slides:
            found += [i for i in range(link.q, link.quaternion) if model.coordinates[i].kind == "position"]
        elif link.slides_only:
            found += [model.places[model.speed_names[j][:-1]] for j, _ in link.partials]
    return found


def _raised(
    model: Model, q: Sequence[float], values: Any, contacts: Sequence[Contact], slides: list[int], up: Vector
) -> dict[str, float]:
    """Return the displacements, by name, with which the lowest of some contacts is closed; none if it cannot be."""
    feature = [not contact.feature.body.is_ground for contact in contacts]

    body = (contacts[0].feature if feature[0] else contacts[0].surface).body

    def place(places: Sequence[float]) -> Vector:
        return point_position(model, float_state(model, places, values=values), Point(body, ZERO))

    at = [touch(model, float_state(model, q, values=values), contact) for contact in contacts]
    A = [subtract(place([x + (k == i) for k, x in enumerate(q)]), place(q)) for i in slides]
    c = [dot(column, up) for column in A]
    way = [sum(x * column[k] for x, column in zip(c, A, strict=True)) for k in range(3)]
    rates = [dot(one.normal, way) * (1 if first else -1) for one, first in zip(at, feature, strict=True)]
    over = [all(x >= 0 for x in one.reach) for one in at]
    rises = [-one.gap / rate for one, rate, it in zip(at, rates, over, strict=True) if rate > LEAST and it]
    if not rises:
        return {}
    return {model.coordinate_names[i]: q[i] + max(rises) * x for i, x in zip(slides, c, strict=True) if x}
