"""Where equations are linearised: values of coordinates and speeds, and where a steady motion takes them.

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
from ...scalar.algebra import Field, add, apply, cross, divide, dot, scale
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
"""What is wrong where no acceleration follows from the forces."""


@dataclass(frozen=True)
class OperatingPoint:
    """Values of q and u by index, as expressions or numbers, and the names of those that were given.

    ``rounded``  whether some are floats, which meet a condition but for their rounding
    """

    q: tuple[Any, ...]
    u: tuple[Any, ...]
    given: frozenset[str]
    rounded: bool = False


def operating_point(model: Model, about: Any) -> OperatingPoint:
    """``about`` read against a model's names; coordinates and speeds that are not named are zero.

    Raises
    ------
    ModelError
        An unknown name, a quaternion of the wrong size, a value that depends on the motion.
    """
    about = _of_steady_motion(model, {} if about is None else about)
    if not isinstance(about, Mapping):
        raise ModelError(
            "Expected `about` to be a mapping of coordinates and speeds to values, such as {'theta': 0}, a motion "
            f"of fb.steady_motions, a trajectory or a state of one, got {about!r}."
        )
    q: list[Any] = [*rest_coordinates(model)]
    u: list[Any] = [0] * model.n_u
    names = [*model.coordinate_names, *model.speed_names]
    turned = {
        link.joint: link.q + (3 if link.kind == "free" else 0)
        for link in model.links
        if link.kind in ("ball", "free")
    }
    given = set()
    for key, value in about.items():
        name = key if isinstance(key, str) else model.names.texts.get(key, str(key))
        if name in turned:
            four = value.as_quaternion() if hasattr(value, "as_quaternion") else value
            if isinstance(four, str) or not hasattr(four, "__len__") or len(four) != 4:
                raise ModelError(
                    f"Expected a quaternion (w, x, y, z) or a Rotation for joint '{name}' in `about`, got {value!r}."
                )
            for k, part in enumerate(four):
                q[turned[name] + k] = value_of_name(model, part, f"the quaternion of joint '{name}'")
        elif name not in names:
            raise ModelError(f"Unknown name '{name}' in `about`; {nearest(name, [*names, *turned])}")
        elif names.index(name) < model.n_q:
            q[names.index(name)] = value_of_name(model, value, f"the operating value of '{name}'")
        else:
            u[names.index(name) - model.n_q] = value_of_name(model, value, f"the operating value of '{name}'")
        given.add(name)
    rounded = any(isinstance(x, float | sympy.Float) for value in about.values() for x in np.ravel(value))
    return OperatingPoint(tuple(q), tuple(u), frozenset(given), rounded)


def _of_steady_motion(model: Model, about: Any) -> Any:
    """The values of a steady motion in numbers, or of one in closed form with symbols for what it leaves free.

    A coordinate ``theta`` that is free has the value ``theta_0``, a speed ``psi'`` the value ``psi_rate_0``; parameters
    of these names are taken for them.
    """
    if hasattr(about, "state") and isinstance(about.state, Mapping):
        return about.state
    if not (hasattr(about, "solution") and hasattr(about, "free")):
        return about
    known = {*model.coordinate_names, *model.speed_names}
    own = [name for name in (*about.solution, *about.free) if name not in known]
    if own:
        raise ModelError(
            f"This steady motion of '{model.name}' is given by the angles and rates of its ball and free joints "
            f"({', '.join(own)}), which are not among its coordinates. Linearise about one in numbers: "
            "about=fb.steady_motions(s, values={...}).states[0]."
        )
    symbols = {}
    for name in about.free:
        text = name.replace("'", "_rate") + "_0"
        known = model.names.kinds.get(text) == "parameter"
        symbols[model.names.atoms[name]] = model.names.atoms[text] if known else sympy.Symbol(text, real=True)
    order = sorted(symbols, key=lambda atom: not atom.is_Derivative)  # a speed holds its coordinate
    values = {model.names.texts[atom]: symbols[atom] for atom in order}
    for name, x in about.solution.items():
        for atom in order:
            x = sympy.sympify(x).xreplace({atom: symbols[atom]})
        values[name] = x
    return values


def value_of_name(model: Model, value: Any, what: str) -> Any:
    """A number or an expression that does not move; SymPy expressions may bring symbols of their own."""
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
            f"Expected a constant for {what}, got '{result}', which moves. Linearise about a motion in time by "
            "`about=` a trajectory."
        )
    if isinstance(result, sympy.Basic) and sympy.Symbol("s") in result.free_symbols:
        raise ModelError(
            f"The symbol s in {what}, '{result}', is that of the characteristic polynomial. Use another name, "
            "or a real "
            "symbol: sympy.Symbol('s', real=True)."
        )
    return result


def along(
    model: Model, field: Field, q: Sequence[Any], u: Sequence[Any], t: Any, values: Mapping[Any, Any]
) -> tuple[Any, ...]:
    """Coordinates after a time t of motion at the constant speeds u."""
    if all(map(_still, u)):
        return tuple(q)
    rates = coordinate_rates(model, State(model, field, 0, q, u, values))
    result = [a if _still(b) else a + b * t for a, b in zip(q, rates, strict=True)]
    for link in model.links:
        if link.kind not in ("ball", "free"):
            continue
        w = tuple(u[link.u : link.u + 3])
        start = link.q + (3 if link.kind == "free" else 0)
        if all(map(_still, w)):
            continue
        live = [x for x in w if not _still(x)]
        rate = live[0] if len(live) == 1 else field.sqrt(dot(w, w))
        half = divide(rate * t, 2)
        s, c = divide(field.sin(half), rate), field.cos(half)
        e0 = tuple(q[start : start + 4])
        result[start : start + 4] = quaternion_product(e0, (c, *scale(s, w)))
        if link.kind == "free":
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
    """Many states after times of motion at their constant speeds; those with the same speeds at zero go together."""
    patterns, which = np.unique(points.u != 0, axis=0, return_inverse=True)
    q = points.q.copy()
    for k, moving in enumerate(patterns):
        own = np.flatnonzero(which.reshape(-1) == k)
        part = points[own]
        values = {p.symbol: column(x) for p, x in zip(model.parameters, part.values.T, strict=True)}
        u = [column(x) if moves else 0 for x, moves in zip(part.u.T, moving, strict=True)]
        q[own] = np.array([*along(model, arrays, [*map(column, part.q.T)], u, column(t[own]), values)]).T
    return points.at(q=q, t=points.t + t)


def _still(x: Any) -> bool:
    return bool(np.all(x == 0))


def perturbed(
    model: Model,
    field: Field,
    q: Sequence[Any],
    u: Sequence[Any],
    t: Any,
    values: Mapping[Any, Any],
    inputs: Sequence[Any] = (),
) -> State:
    """The state with small deviations: of the tangent coordinates (variables 0 to n_u - 1), of the speeds (n_u on),
    and of parameters that are inputs (3 n_u on; those between are left to the accelerations)."""
    n = model.n_u
    dual = DualField(field)
    moved: list[dict[int, Any]] = [{} for _ in range(model.n_q)]
    places = {name: j for j, name in enumerate(model.speed_names)}
    for i, coordinate in enumerate(model.coordinates):
        if coordinate.kind == "scalar":
            moved[i][places[coordinate.name + "'"]] = 1
    for link in model.links:
        if link.kind not in ("ball", "free"):
            continue
        for j in range(link.u, link.u + (3 if link.kind == "ball" else 6)):
            unit = [1 if k == j else 0 for k in range(n)]
            for i, rate in enumerate(coordinate_rates(model, State(model, field, t, q, unit, values))):
                if model.coordinates[i].kind != "scalar" and not (type(rate) is int and rate == 0):
                    moved[i][j] = rate
    held = dict(values)
    for k, symbol in enumerate(inputs):
        held[symbol] = dual.dual(values[symbol], {3 * n + k: 1})
    return State(
        model,
        dual,
        t,
        [dual.dual(x, slopes) for x, slopes in zip(q, moved, strict=True)],
        [dual.dual(x, {n + j: 1}) for j, x in enumerate(u)],
        held,
    )


def tangent_drift(model: Model, u: Sequence[Any]) -> list[list[Any]]:
    """A in ξ' = δu + A ξ, where ξ are the deviations of the coordinates.

    Zero but for ball and free joints, whose deviations are small turns δθ (and displacements δs) in the child's axes:
    δθ' = δω - ω × δθ,   δs' = δv - ω × δs - v × δθ.
    """
    n = model.n_u
    A: list[list[Any]] = [[0] * n for _ in range(n)]

    def put(row: int, column: int, x: Sequence[Any]) -> None:
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
        if link.kind in ("ball", "free"):
            put(link.u, link.u, u[link.u : link.u + 3])
        if link.kind == "free":
            put(link.u + 3, link.u + 3, u[link.u : link.u + 3])
            put(link.u + 3, link.u, u[link.u + 3 : link.u + 6])
    return A


def tangent_names(model: Model) -> tuple[str, ...]:
    """Names of the deviations: of the coordinates themselves, and ``j_rx`` (turns), ``j_dx`` (displacements) of
    ball and free joints."""
    names = [name.removesuffix("'") for name in model.speed_names]
    for link in model.links:
        if link.kind in ("ball", "free"):
            for k, letter in enumerate("xyz"):
                names[link.u + k] = f"{link.joint}_r{letter}"
                if link.kind == "free":
                    names[link.u + 3 + k] = f"{link.joint}_d{letter}"
    return tuple(names)
