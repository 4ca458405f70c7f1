"""Forces whose line of action keeps its place while the body turns: described by a force and a couple, drawn as one.

A force F at a point and a couple M on the same body are equivalent to the force alone on the line at the distance
d = M/F. If d depends on parameters only, that line is what the description means: the rope that pulls at a height h.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...describe.frame import Point
from ...describe.loads.action import Action, Couple, PointForce
from ...dynamics.loads.actions import actions, places
from ...dynamics.loads.added_mass import moving
from ...scalar.algebra import Vector
from ...symbolic.printing.display import latex
from ..paper.palette import GREY
from ..paper.sheet import Arrow, Line, Style
from .machine_drawing import MachineDrawing
from .shapes import numbers

Array = NDArray[np.float64]


def moved_forces(m: MachineDrawing) -> dict[str, tuple[str, int, Any]]:
    """Return, for each force that is drawn on another line, the couple, the axis and the distance along it [m]."""
    if not m.view.planar:
        return {}
    result: dict[str, tuple[str, int, Any]] = {}
    n = m.view.normal
    assert n is not None
    couples = {name: action for name in m.model.loads if (action := _single(m, name, Couple)) is not None}
    for name in m.model.loads:
        force = fixed_force(m, name)
        if force is None:
            continue
        along = [k for k in range(3) if force[k] != 0]
        body = point_of(m, name).body
        partners = [key for key, couple in couples.items() if couple.body is body]
        if len(along) != 1 or along[0] == n or len(partners) != 1:
            continue
        k = along[0]
        # M = r x F about the normal: r along the other axis of the plane
        other = ({0, 1, 2} - {k, n}).pop()
        sign = int(sympy.LeviCivita(other, k, n))
        moment = m.e.sympy(couples[partners[0]].moment[n])
        d = sympy.cancel(sign * moment / force[k])
        parameters = {p.symbol for p in m.model.parameters}
        if d != 0 and sympy.sympify(d).free_symbols <= parameters and not d.has(sympy.Function):
            result[name] = (partners[0], other, d)
    return result


def _single(m: MachineDrawing, name: str, sort: type[Action]) -> Any:
    """Return the action of a load that consists of one action of this sort, canonical; None of any other load."""
    kinds = [type(action) for action in places(m.model)[name]]
    return actions(m.model, moving(m.model, m.e.state, m.e.udot), name)[0] if kinds == [sort] else None


def fixed_force(m: MachineDrawing, name: str) -> Vector | None:
    """Return a force whose direction the description fixes, SymPy in ground axes; None for any other load.

    Its components may change with time, but depend on no coordinate.
    """
    action = _single(m, name, PointForce)
    if action is None:
        return None
    ring, kinds = m.e.ring, ("coordinate", "quaternion")
    moving = {g.atom for x in action.force for g in ring.of_mask(ring.depends(x)) if g.kind in kinds}
    return None if moving else tuple(map(m.e.sympy, action.force))


def point_of(m: MachineDrawing, name: str) -> Point:
    """Return the point at which a load of one force acts."""
    return next(action.point for action in places(m.model)[name] if isinstance(action, PointForce))


def height_of_line(m: MachineDrawing, name: str, axis: int, distance: Any) -> tuple[Any, Array] | None:
    """Height of a line of action above the ground that the body rolls on, and the foot of the body, on paper.

    None if the body does not touch a plane of the ground across ``axis`` with a circle about the point of the force.
    """
    point = point_of(m, name)
    for contact in m.model.contacts:
        circle, plane = contact.feature, contact.surface
        if circle.look != "disk" or plane.look != "plane" or not plane.body.is_ground:
            continue
        normal = numbers(m.now.state, plane.normal)
        if circle.body is point.body and tuple(circle.at) == tuple(point.components) and normal[axis] == 1:
            center = m.now.point(point)
            return sympy.expand(distance + circle.radius), m.page(
                center - float(m.now.state(circle.radius)) * normal
            )
    return None


def mark_line(m: MachineDrawing, name: str, couple: str, axis: int, distance: Any) -> Array:
    """Draw the distance of a line of action from the ground, or from the point; return the point on the line."""
    point = point_of(m, name)
    at = m.now.point(point)
    start = m.page(at)
    end = m.page(at + float(m.now.state(distance)) * np.eye(3)[axis])
    foot = height_of_line(m, name, axis, distance)
    value, base = (distance, start) if foot is None else foot
    d = m.view.matrix[:, axis]
    across = np.array([d[1], -d[0]])
    reach = m.reach(point.body.name, start, across) + 26.0
    line = np.array([base, end]) + reach * across
    tex = latex(m.e.state(value), m.e.ring)
    leads = [
        Line(np.array([p + 6 * across, q + 4 * across]), Style(GREY, 0.7))
        for p, q in zip((base, end), line, strict=True)
    ]
    m.add(
        [*leads, Arrow(line, Style(GREY, 0.8), "both")], class_="dimension", data_load=couple, data_symbol=tex
    )
    m.labels.append((f"${tex}$", [(line.mean(axis=0), across)], 10.5, GREY))
    return np.asarray(end)
