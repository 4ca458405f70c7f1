"""Which speeds each constraint depends on, and directions that each tell many columns of its matrix G at once.

Along a direction u that is 1 for several speeds, the derivative of a condition that depends on one of these only is
its entry of G for that one. A row of loops takes as many directions as one loop has speeds, however long the row is.

Source: Griewank & Walther, Evaluating Derivatives (2008), chapter 8.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..describe.constraints.constraint import Gear, Rolling, Rope
from ..model.closure import Closure
from ..model.contact import Touching
from ..model.model import GROUND, Model
from .kinematics import place_of


def dependence(model: Model) -> dict[str, frozenset[int]]:
    """Speeds that the residuals of each constraint can depend on, by its name; none for contacts."""
    moving = [_moving(model, i) for i in range(len(model.links))]
    behind: list[frozenset[int]] = []
    for link, own in zip(model.links, moving, strict=True):
        behind.append(own if link.parent == GROUND else own | behind[link.parent])

    def of_bodies(bodies: Iterable[Any]) -> frozenset[int]:
        links = [place_of(model, body)[0] for body in bodies]
        return frozenset().union(*(behind[i] for i in links if i != GROUND))

    result: dict[str, frozenset[int]] = {}
    for name, one in model.constraints.items():
        if isinstance(one, Closure):
            links = loop_links(model, one)
            result[name] = frozenset().union(*(moving[i] for i in links))
        elif isinstance(one, Rope):
            result[name] = of_bodies(point.body for point in one.points)
        elif isinstance(one, Rolling):
            result[name] = of_bodies((one.center.body, one.plane.body))
        elif isinstance(one, Gear):
            result[name] = frozenset().union(
                *(moving[model.joints[joint.name].links[0]] for joint in (one.first, one.second))
            )
        elif isinstance(one, Touching):
            result[name] = frozenset()
        else:
            result[name] = _named(model, one.expression)
    return result


def loop_links(model: Model, closure: Closure) -> list[int]:
    """Links between the two bodies that a closure joins: those of either that do not carry the other too."""
    i, j = (place_of(model, body)[0] for body in (closure.parent, closure.child))
    result = []
    while i != j:  # parents stand before their children
        i, j = min(i, j), max(i, j)
        result.append(j)
        j = model.links[j].parent
    return result


def _moving(model: Model, i: int) -> frozenset[int]:
    """Speeds that move a link relative to its parent."""
    link = model.links[i]
    if link.u < 0:
        return frozenset(j for j, _ in link.partials)
    return frozenset(range(link.u, link.u + {"ball": 3, "free": 6}[link.kind]))


def _named(model: Model, expression: Any) -> frozenset[int]:
    """Speeds that stand in an expression, or whose coordinates do."""
    names = set(model.names.depends(expression, "coordinate", "speed"))
    result = {j for j, speed in enumerate(model.speeds) if {speed.name, speed.name.removesuffix("'")} & names}
    for i, link in enumerate(model.links):
        own = model.coordinate_names[link.q : link.q + {"ball": 4, "free": 7}.get(link.kind, 0)]
        if names.intersection(own):
            result |= _moving(model, i)
    return frozenset(result)


def directions(depends: Iterable[frozenset[int]]) -> list[frozenset[int]]:
    """Sets of speeds of which no constraint depends on two: each speed in the first set that has room for it."""
    sharing: dict[int, set[int]] = {}
    for speeds in depends:
        for j in speeds:
            sharing.setdefault(j, set()).update(speeds)
    result: list[set[int]] = []
    for j in sorted(sharing):
        for one in result:
            if one.isdisjoint(sharing[j]):
                one.add(j)
                break
        else:
            result.append({j})
    return [frozenset(one) for one in result]
