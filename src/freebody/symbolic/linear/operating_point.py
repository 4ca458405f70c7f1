"""The operating point: coordinates and speeds about which equations are linearised, and their steady motion.

q(t) = q0 + u0 t,        e(t) = e0 ∘ exp(ω t / 2),        p(t) = p0 + R0 ∫ exp([ω]× τ) dτ v
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...dynamics.kinematics import coordinate_rates
from ...dynamics.state import State, rest_coordinates
from ...errors import ModelError, nearest
from ...model.model import Model
from ...scalar.algebra import Expression, Field, Scalar, add, apply, cross, divide, dot, scale
from ...scalar.arrays import arrays, column
from ...scalar.dual import DualField
from ...scalar.expression import exact
from ...space.quaternion import matrix_from_quaternion, quaternion_product
from .recorded_functions import Points

SINGULAR = (
    "The mass matrix of '{}' is singular at the state given: its coordinates are singular there (as Euler angles of an "
    "upright axis are), or something without mass can move. Use other coordinates, such as another sequence of angles "
    "or a ball joint."
)
"""Message if the forces determine no acceleration."""


@dataclass(frozen=True)
class OperatingPoint:
    """Values of q and u by index, as expressions or numbers, and the names the user gave.

    ``rounded`` is true if some values are floats, which meet a condition only up to round-off.
    """

    q: tuple[Expression, ...]
    u: tuple[Expression, ...]
    names: frozenset[str]
    rounded: bool = False


def operating_point(model: Model, about: Any) -> OperatingPoint:
    """Return the operating point that ``about`` describes; coordinates and speeds not named are zero.

    Raises
    ------
    ModelError
        An unknown name, a quaternion of the wrong size, a value that depends on the motion.
    """
    about = _steady_motion_values(model, {} if about is None else about)
    if not isinstance(about, Mapping):
        raise ModelError(
            "Expected `about` to be a mapping of coordinates and speeds to values, such as {'theta': 0}, a motion "
            f"of fb.steady_motions, a trajectory or a state of one, got {about!r}."
        )
    q: list[Expression] = [*rest_coordinates(model)]
    u: list[Expression] = [0] * model.n_u
    names = model.state_names
    quaternions = {link.joint: link.quaternion for link in model.links if link.own}
    named = set()
    for key, value in about.items():
        name = key if isinstance(key, str) else model.names.texts.get(key, str(key))
        if name in quaternions:
            components = value.as_quaternion() if hasattr(value, "as_quaternion") else value
            if isinstance(components, str) or not hasattr(components, "__len__") or len(components) != 4:
                raise ModelError(
                    f"Expected a quaternion (w, x, y, z) or a Rotation for joint '{name}' in `about`, got {value!r}."
                )
            for k, part in enumerate(components):
                q[quaternions[name] + k] = value_of_name(model, part, f"the quaternion of joint '{name}'")
        elif name not in names:
            raise ModelError(f"Unknown name '{name}' in `about`; {nearest(name, [*names, *quaternions])}")
        elif names.index(name) < model.n_q:
            q[names.index(name)] = value_of_name(model, value, f"the operating value of '{name}'")
        else:
            u[names.index(name) - model.n_q] = value_of_name(model, value, f"the operating value of '{name}'")
        named.add(name)
    rounded = any(isinstance(x, float | sympy.Float) for value in about.values() for x in np.ravel(value))
    return OperatingPoint(tuple(q), tuple(u), frozenset(named), rounded)


def _steady_motion_values(model: Model, about: Any) -> Any:
    """Return the values of a steady motion, in numbers or in closed form; return anything else unchanged.

    A free coordinate ``theta`` gets the value ``theta_0`` and a free speed ``psi'`` the value ``psi_rate_0``: the
    parameters of these names if they exist, else new symbols.
    """
    if hasattr(about, "state") and isinstance(about.state, Mapping):
        return about.state
    if not (hasattr(about, "solution") and hasattr(about, "free")):
        return about
    known = {*model.state_names}
    foreign = [name for name in (*about.solution, *about.free) if name not in known]
    if foreign:
        raise ModelError(
            f"This steady motion of '{model.name}' is given by the angles and rates of its ball and free joints "
            f"({', '.join(foreign)}), which are not among its coordinates. Linearise about one in numbers: "
            "about=fb.steady_motions(s, values={...}).states[0]."
        )
    symbols = {}
    for name in about.free:
        text = name.replace("'", "_rate") + "_0"
        is_parameter = model.names.kinds.get(text) == "parameter"
        symbols[model.names.atoms[name]] = (
            model.names.atoms[text] if is_parameter else sympy.Symbol(text, real=True)
        )
    order = sorted(
        symbols, key=lambda atom: not atom.is_Derivative
    )  # an expression of a speed contains its coordinate
    values = {model.names.texts[atom]: symbols[atom] for atom in order}
    for name, x in about.solution.items():
        for atom in order:
            x = sympy.sympify(x).xreplace({atom: symbols[atom]})
        values[name] = x
    return values


def value_of_name(model: Model, value: Expression, what: str) -> Expression:
    """Return a constant: a number or an expression. SymPy expressions may contain new symbols."""
    if isinstance(value, str):
        result = model.names.expression(value, what)
    else:
        try:
            result = exact(value)
        except (sympy.SympifyError, TypeError, AttributeError, ValueError):
            raise ModelError(f"Expected a number or an expression for {what}, got {value!r}.") from None
    if isinstance(result, sympy.Basic) and (
        result.has(sympy.core.function.AppliedUndef) or sympy.Symbol("t") in result.free_symbols
    ):
        raise ModelError(
            f"Expected a constant for {what}, got '{result}', which moves. Linearise about a motion in time with "
            "about= a trajectory."
        )
    if isinstance(result, sympy.Basic) and sympy.Symbol("s") in result.free_symbols:
        raise ModelError(
            f"The symbol s in {what}, '{result}', is the variable of the characteristic polynomial. Use another name, "
            "or a real symbol: sympy.Symbol('s', real=True)."
        )
    return result


def along(
    model: Model,
    field: Field,
    q: Sequence[Scalar],
    u: Sequence[Scalar],
    t: Scalar,
    values: Mapping[Any, Scalar],
) -> tuple[Scalar, ...]:
    """Coordinates after motion at the constant speeds u for a time t.

    e(t) and p(t) of ball and free joints are given at the head of this file.
    """
    if all(map(_still, u)):
        return tuple(q)
    rates = coordinate_rates(model, State(model, field, 0, q, u, values))
    result = [a if _still(b) else a + b * t for a, b in zip(q, rates, strict=True)]
    for link in model.links:
        if not link.own:
            continue
        w = tuple(u[link.u : link.u + 3])
        start = link.quaternion
        if all(map(_still, w)):
            continue
        live = [x for x in w if not _still(x)]
        rate = live[0] if len(live) == 1 else field.sqrt(dot(w, w))
        half = divide(rate * t, 2)
        s, c = divide(field.sin(half), rate), field.cos(half)
        e0 = tuple(q[start : start + 4])
        result[start : start + 4] = quaternion_product(e0, (c, *scale(s, w)))
        if link.flies:
            v = tuple(u[link.u + 3 : link.u + 6])
            wv = cross(w, v)
            square = rate * rate
            turn = divide(1 - field.cos(rate * t), square)
            lag = divide(rate * t - field.sin(rate * t), square * rate)
            way = add(scale(t, v), add(scale(turn, wv), scale(lag, cross(w, wv))))
            p0 = tuple(q[link.q : link.q + 3])
            result[link.q : link.q + 3] = add(p0, apply(matrix_from_quaternion(e0), way))
    return tuple(result)


def moved(model: Model, points: Points, t: NDArray[np.float64]) -> Points:
    """Return many states after times ``t`` of motion at their constant speeds.

    States with the same speeds equal to zero are computed together.
    """
    patterns, which = np.unique(points.u != 0, axis=0, return_inverse=True)
    q = points.q.copy()
    for k, moving in enumerate(patterns):
        members = np.flatnonzero(which.reshape(-1) == k)
        part = points[members]
        values = {p.symbol: column(x) for p, x in zip(model.parameters, part.values.T, strict=True)}
        u = [column(x) if moves else 0 for x, moves in zip(part.u.T, moving, strict=True)]
        q[members] = np.array(
            [*along(model, arrays, [*map(column, part.q.T)], u, column(t[members]), values)]
        ).T
    return points.at(q=q, t=points.t + t)


def _still(x: Scalar) -> bool:
    return bool(np.all(x == 0))


def perturbed(
    model: Model,
    field: Field,
    q: Sequence[Scalar],
    u: Sequence[Scalar],
    t: Scalar,
    values: Mapping[Any, Scalar],
    inputs: Sequence[Any] = (),
) -> State:
    """Return the state with small deviations as dual numbers.

    Their variables are the tangent coordinates (0 to n_u - 1), the speeds (n_u to 2 n_u - 1), the accelerations (2 n_u
    to 3 n_u - 1, set elsewhere) and the parameters that are inputs (from 3 n_u).
    """
    n = model.n_u
    dual = DualField(field)
    rates_of: list[dict[int, Scalar]] = [{} for _ in range(model.n_q)]
    places = {name: j for j, name in enumerate(model.speed_names)}
    for i, coordinate in enumerate(model.coordinates):
        if coordinate.kind == "scalar":
            rates_of[i][places[coordinate.name + "'"]] = 1
    for link in model.links:
        if not link.own:
            continue
        for j in range(link.u, link.u + link.n_speeds):
            unit = [1 if k == j else 0 for k in range(n)]
            for i, rate in enumerate(coordinate_rates(model, State(model, field, t, q, unit, values))):
                if model.coordinates[i].kind != "scalar" and not (type(rate) is int and rate == 0):
                    rates_of[i][j] = rate
    parameters = dict(values)
    for k, symbol in enumerate(inputs):
        parameters[symbol] = dual.dual(values[symbol], {3 * n + k: 1})
    return State(
        model,
        dual,
        t,
        [dual.dual(x, slopes) for x, slopes in zip(q, rates_of, strict=True)],
        [dual.dual(x, {n + j: 1}) for j, x in enumerate(u)],
        parameters,
    )


def tangent_drift(model: Model, u: Sequence[Scalar]) -> list[list[Scalar]]:
    """Matrix A of ξ' = δu + A ξ, where ξ are the deviations of the coordinates.

    It is zero except for ball and free joints. Their deviations are small turns δθ (and displacements δs) in the
    child's axes: δθ' = δω - ω × δθ,   δs' = δv - ω × δs - v × δθ.
    """
    n = model.n_u
    A: list[list[Scalar]] = [[0] * n for _ in range(n)]

    def put(row: int, column: int, x: Sequence[Scalar]) -> None:
        for i, j, sign, k in (
            (0, 1, 1, 2),
            (0, 2, -1, 1),
            (1, 0, -1, 2),
            (1, 2, 1, 0),
            (2, 0, 1, 1),
            (2, 1, -1, 0),
        ):
            A[row + i][column + j] = sign * x[k]  # -[x]×

    for link in model.links:
        if link.own:
            put(link.u, link.u, u[link.u : link.u + 3])
        if link.flies:
            put(link.u + 3, link.u + 3, u[link.u : link.u + 3])
            put(link.u + 3, link.u, u[link.u + 3 : link.u + 6])
    return A


def tangent_names(model: Model) -> tuple[str, ...]:
    """Names of the deviations.

    A scalar coordinate keeps its name. Ball and free joints ``j`` have turns ``j_rx`` and displacements ``j_dx``.
    """
    names = [name.removesuffix("'") for name in model.speed_names]
    for link in model.links:
        if link.own:
            for k, letter in enumerate("xyz"):
                names[link.u + k] = f"{link.joint}_r{letter}"
                if link.flies:
                    names[link.u + 3 + k] = f"{link.joint}_d{letter}"
    return tuple(names)
