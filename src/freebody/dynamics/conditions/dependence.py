"""Speeds that each constraint depends on, and directions that each give many columns of its matrix G at once.

Along a direction u that is 1 for several speeds, the derivative of a condition that depends on only one of them is
its entry of G for that speed. A row of loops needs as many directions as one loop has speeds, however long it is.

Source: Griewank & Walther, Evaluating Derivatives (2008), chapter 8.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ...describe.constraints.constraint import Gear, Rolling, Rope
from ...model.closure import Closure
from ...model.contact_modes import Touching
from ...model.model import GROUND, Model
from ...scalar.algebra import Expression
from ..kinematics import place_of


def dependence(model: Model) -> dict[str, frozenset[int]]:
    """Return the speeds that the residuals of each constraint can depend on, by its name; none for contacts."""
    moving = [_moving(model, i) for i in range(len(model.links))]
    inward: list[frozenset[int]] = []  # speeds that move a link relative to the ground
    for link, speeds in zip(model.links, moving, strict=True):
        inward.append(speeds if link.parent == GROUND else speeds | inward[link.parent])

    def of_bodies(bodies: Iterable[Any]) -> frozenset[int]:
        links = [place_of(model, body)[0] for body in bodies]
        return frozenset().union(*(inward[i] for i in links if i != GROUND))

    result: dict[str, frozenset[int]] = {}
    for name, constraint in model.constraints.items():
        if isinstance(constraint, Closure):
            links = loop_links(model, constraint)
            result[name] = frozenset().union(*(moving[i] for i in links))
        elif isinstance(constraint, Rope):
            result[name] = of_bodies(point.body for point in constraint.points)
        elif isinstance(constraint, Rolling):
            result[name] = of_bodies((constraint.center.body, constraint.plane.body))
        elif isinstance(constraint, Gear):
            geared = (model.joints[joint.name].links[0] for joint in (constraint.first, constraint.second))
            result[name] = frozenset().union(*(moving[i] for i in geared))
        elif isinstance(constraint, Touching):
            result[name] = frozenset()
        else:
            result[name] = _named(model, constraint.expression)
    return result


def path_between(model: Model, i: int, j: int) -> tuple[list[int], int]:
    """Return the links on the way from one link to another, without the one that carries both, and that one."""
    result = []
    while i != j:  # parents come before their children
        i, j = min(i, j), max(i, j)
        result.append(j)
        j = model.links[j].parent
    return result, i


def loop_links(model: Model, closure: Closure) -> list[int]:
    """Return the links of a loop: those that carry one of the two bodies of the closure but not both."""
    return path_between(model, *(place_of(model, body)[0] for body in (closure.parent, closure.child)))[0]


def _moving(model: Model, i: int) -> frozenset[int]:
    """Return the speeds that move a link relative to its parent."""
    link = model.links[i]
    if link.u < 0:
        return frozenset(j for j, _ in link.partials)
    return frozenset(range(link.u, link.u + link.n_speeds))


def _named(model: Model, expression: Expression) -> frozenset[int]:
    """Return the speeds that occur in an expression, or whose coordinates do."""
    names = set(model.names.depends(expression, "coordinate", "speed"))
    result = {j for j, speed in enumerate(model.speeds) if {speed.name, speed.name.removesuffix("'")} & names}
    for i, link in enumerate(model.links):
        components = model.coordinate_names[link.q : link.q + link.n_coordinates]
        if names.intersection(components):
            result |= _moving(model, i)
    return frozenset(result)


def directions(depends: Iterable[frozenset[int]]) -> list[frozenset[int]]:
    """Return sets of speeds such that no constraint depends on two of a set; each speed joins the first free set."""
    sharing: dict[int, set[int]] = {}
    for speeds in depends:
        for j in speeds:
            sharing.setdefault(j, set()).update(speeds)
    result: list[set[int]] = []
    for j in sorted(sharing):
        for chosen in result:
            if chosen.isdisjoint(sharing[j]):
                chosen.add(j)
                break
        else:
            result.append({j})
    return [frozenset(chosen) for chosen in result]
