"""Angles of slopes, guides and forces from the horizontal, in the drawing of a planar machine."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...dynamics.kinematics import rotation
from ...dynamics.state import State, rest_coordinates
from ...scalar.algebra import apply
from ...symbolic.printing.display import latex
from ..paper.palette import GREY
from ..paper.sheet import Arrow, Line, Style, arc
from .lines_of_action import fixed_force
from .machine_drawing import MachineDrawing
from .shapes import numbers

Array = NDArray[np.float64]

LEAST = math.radians(3)
"""Least angle that is marked."""

RADIUS = 46.0
"""Radius of the arc [pt]."""


def angle_with(x: Any, y: Any) -> Any:
    """Return the angle a with (x, y) = c (cos a, sin a), if it is a parameter or a number; None otherwise.

    Examples
    --------
    >>> F, beta = sympy.symbols("F beta")
    >>> angle_with(F*sympy.cos(beta), -F*sympy.sin(beta))
    -beta
    """
    x, y = sympy.sympify(x), sympy.sympify(y)
    for a in sorted(x.free_symbols & y.free_symbols, key=str):
        for sign in (1, -1):
            if sympy.expand(x * sympy.sin(a) - sign * y * sympy.cos(a)) == 0:
                return sign * a
    common = sympy.gcd(x, y)
    x, y = (x / common, y / common) if common != 0 else (x, y)
    return sympy.atan2(y, x) if not (x.free_symbols | y.free_symbols) else None


def mark_inclinations(m: MachineDrawing) -> None:
    """Draw the angles of the slopes, and of the forces with fixed directions."""
    across, up = (m.view.axes[0][1], m.view.axes[1][1])
    signs = [float(m.view.matrix[0, across]), float(m.view.matrix[1, up])]
    if signs != [1.0, 1.0]:
        return
    drawn: list[Any] = []
    for contact in m.model.contacts:
        for shape in (contact.feature, contact.surface):
            if shape.body.is_ground and shape.look == "plane" and shape not in drawn:
                drawn.append(shape)
                n = shape.normal
                _mark(m, _low_end(m, shape), (n[up], -n[across]) if n[up] != 0 else (n[across], 0))
    for name in m.drawn:
        _leaning(m, name, across, up)
    for name in m.model.loads:
        force = fixed_force(m, name)
        if force is not None:
            _mark(m, _tail(m, name), (force[across], force[up]))


def _leaning(m: MachineDrawing, name: str, across: int, up: int) -> None:
    """Draw the angle from the horizontal of a bar that leans at zero coordinates, if it is drawn there."""
    place = m.model.bodies[name]
    shape = place.shape
    if shape is None or shape.kind != "slender_bar" or shape.parts:
        return
    model, state = m.model, m.e.state
    zero = State(model, state.field, state.t, rest_coordinates(model), [0] * model.n_u, state.values)
    turned = apply(rotation(model, zero, place.link), apply(shape.axes, shape.axis))
    direction = [sympy.sympify(m.e.sympy(x)) for x in turned]
    along = numbers(m.now.state, direction)
    R, p = m.now.posture(name)
    piece = m.pieces[name][0]
    if abs(float(along @ (R @ piece.axis))) < 1 - 1e-9:
        return
    ends = [m.page(p + R @ (piece.center + s * piece["length"] / 2 * piece.axis)) for s in (1, -1)]
    _mark(m, min(ends, key=lambda q: float(q[1])), (direction[across], direction[up]))


def _low_end(m: MachineDrawing, shape: Any) -> Array | None:
    """The low end of a drawn slope, on paper."""
    n = m.view(numbers(m.now.state, shape.normal))
    d = np.array([n[1], -n[0]]) / np.linalg.norm(n)
    d = d if d[1] < 0 else -d
    foot = m.page(numbers(m.now.state, shape.at))
    reach = ((m.page(m.extent) - foot) @ d).max()
    return np.asarray(foot + (reach + 20.0) * d)


def _tail(m: MachineDrawing, name: str) -> Array | None:
    """The tail of the drawn arrow of a force, on paper."""
    for group in m.root.items:
        if getattr(group, "attributes", {}).get("data-load") == name:
            return np.asarray(group.items[0].points[0])
    return None


def _mark(m: MachineDrawing, at: Array | None, direction: tuple[Any, Any]) -> None:
    """Draw the arc of an angle from the horizontal, on the side of the line that lies beside ``at``."""
    x, y = direction
    if at is None or x == 0 or y == 0:
        return
    angle = angle_with(x, y)
    if angle is None:
        return
    value = math.atan2(float(m.now.state(y)), float(m.now.state(x)))
    # the acute angle, at the end of the line from which it rises
    along = np.array([math.cos(value), math.sin(value)])
    middle = m.page(m.extent).mean(axis=0)
    if float((middle - at) @ along) < 0:
        along = -along
    rise = math.atan2(along[1], along[0])
    level = 0.0 if along[0] > 0 else math.pi
    turn = math.remainder(rise - level, 2 * math.pi)
    if abs(turn) < LEAST:
        return
    free = angle.free_symbols
    tex = (
        latex(m.e.state(angle if free and turn * _value(m, angle) > 0 else -angle), m.e.ring) if free else ""
    )
    tex = tex.removeprefix("-") or rf"{abs(math.degrees(turn)):.4g}^\circ"
    swept = arc(at, RADIUS, level, level + turn)
    flat = np.array([at, at + (RADIUS + 12.0) * np.array([math.cos(level), 0.0])])
    items = [Line(flat, Style(GREY, 0.7, (4.0, 2.5))), Arrow(swept, Style(GREY, 0.8))]
    m.add(items, class_="inclination", data_symbol=tex)
    half = level + turn / 2
    out = np.array([math.cos(half), math.sin(half)])
    m.labels.append((f"${tex}$", [(at + RADIUS * out, out)], 10.5, GREY))


def _value(m: MachineDrawing, angle: Any) -> float:
    return float(m.now.state(angle))
