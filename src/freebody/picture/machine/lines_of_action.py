"""Forces whose line of action keeps its place while the body turns: described by a force and a couple, drawn as one.

A force F at a point and a couple M on the same body are equivalent to the force alone on the line at the distance
d = M/F. If d depends on parameters only, that line is what the description means: the rope that pulls at a height h.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...describe.contact_shapes import kind_of
from ...describe.loads.load import Force, Torque
from ...symbolic.printing.display import latex
from ..paper.palette import GREY
from ..paper.sheet import Arrow, Line, Style
from .machine_drawing import MachineDrawing, fixed

Array = NDArray[np.float64]


def moved_forces(m: MachineDrawing) -> dict[str, tuple[str, int, Any]]:
    """Return, for each force that is drawn on another line, the couple, the axis and the distance along it [m]."""
    if not m.view.planar:
        return {}
    result: dict[str, tuple[str, int, Any]] = {}
    n = m.view.normal
    assert n is not None
    couples = {
        name: load
        for name, load in m.model.loads.items()
        if isinstance(load, Torque) and load.reaction_on is None and load.frame.is_ground
    }
    for name, load in m.model.loads.items():
        if not isinstance(load, Force) or not load.frame.is_ground:
            continue
        along = [k for k in range(3) if sympy.sympify(load.components[k]) != 0]
        partners = [key for key, couple in couples.items() if couple.body is load.point.body]
        if len(along) != 1 or along[0] == n or len(partners) != 1:
            continue
        k = along[0]
        # M = r x F about the normal: r along the other axis of the plane
        other = ({0, 1, 2} - {k, n}).pop()
        sign = int(sympy.LeviCivita(other, k, n))
        d = sympy.cancel(sign * sympy.sympify(couples[partners[0]].components[n]) / load.components[k])
        parameters = {p.symbol for p in m.model.parameters}
        if d != 0 and sympy.sympify(d).free_symbols <= parameters and not d.has(sympy.Function):
            result[name] = (partners[0], other, d)
    return result


def height_of_line(m: MachineDrawing, name: str, axis: int, distance: Any) -> tuple[Any, Array] | None:
    """Height of a line of action above the ground that the body rolls on, and the foot of the body, on paper.

    None if the body does not touch a plane of the ground across ``axis`` with a circle about the point of the force.
    """
    load: Any = m.model.loads[name]
    for contact in m.model.contacts:
        circle, plane = contact.feature, contact.surface
        if kind_of(circle) != "circle" or kind_of(plane) != "plane" or not plane.body.is_ground:
            continue
        normal = fixed(m, plane.normal)
        if (
            circle.body is load.point.body
            and tuple(circle.at) == tuple(load.point.components)
            and normal[axis] == 1
        ):
            center = m.now.point(load.point)
            return sympy.expand(distance + circle.radius), m.page(
                center - float(m.now.state(circle.radius)) * normal
            )
    return None


def mark_line(m: MachineDrawing, name: str, couple: str, axis: int, distance: Any) -> Array:
    """Draw the distance of a line of action from the ground, or from the point; return the point on the line."""
    load: Any = m.model.loads[name]
    at = m.now.point(load.point)
    start = m.page(at)
    end = m.page(at + float(m.now.state(distance)) * np.eye(3)[axis])
    foot = height_of_line(m, name, axis, distance)
    value, base = (distance, start) if foot is None else foot
    d = m.view.matrix[:, axis]
    across = np.array([d[1], -d[0]])
    reach = m.reach(load.point.body.name, start, across) + 26.0
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
