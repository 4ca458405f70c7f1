"""Linear equations of small motions about an equilibrium, a steady motion or a trajectory.

    M ξ'' + C ξ' + K ξ = B f        C = D + G (damping, gyroscopic),   K = S + N (stiffness, circulatory)

The equations of motion L(q, u, u', t, f) = M u' + h - Q are evaluated once on dual numbers (`scalar.dual`): M, C, K
and B are their exact derivatives, on polynomials for symbols, on floats or arrays for numbers. Nothing is
differentiated by differences, and the nonlinear equations are never written out.

Sources: chapter 6, eqs (6.107) to (6.114); Meirovitch, Methods of Analytical Dynamics (1970), chapter 8.

The file is longer than others: symbols, numbers and motions go through the same derivatives and the same checks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import sympy

from ..describe.system import System
from ..dynamics.articulated import forward_dynamics
from ..dynamics.newton_euler import inverse_dynamics
from ..dynamics.state import State
from ..errors import ModelError, arguments_named, nearest
from ..model.assemble import assemble
from ..model.model import Model
from ..model.values import check_assumptions
from ..scalar.algebra import Field, floats
from ..scalar.arrays import arrays, column
from ..scalar.dual import DualField, slope_of, value_of
from ..scalar.expression import evaluate
from ..scalar.polynomial import Ring
from ..scalar.zero import is_zero
from .display import text
from .linear_model import LinearModel
from .operating_point import (
    SINGULAR,
    along,
    operating_point,
    perturbed,
    tangent_drift,
    tangent_names,
    value_of_name,
)

TIMES = (0, 1, 2, 3)
"""Quarters of a turn at which a steady motion in numbers is looked at: it and its linear equations must not change."""
SMALL = 10**-9
"""A balance is off when it is missed by more than this part of its terms, of the size of one unit of motion."""


@arguments_named
def linearize(
    s: Any,
    about: Any = None,
    *,
    where: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
    inputs: Any = (),
    independent: Any = (),
) -> LinearModel:
    """Linear equations of the small motions of a machine about an equilibrium or a motion.

    M ξ'' + C ξ' + K ξ = B f, where ξ are the deviations of the coordinates. They bear the coordinates' names; of a
    ball joint ``j`` they are the small turns ``j_rx, j_ry, j_rz`` about the child's axes, q = q0 ∘ exp(ξ/2), and of a
    free joint the displacements ``j_dx, j_dy, j_dz`` along them besides.

    Parameters
    ----------
    s : System, Model or Equations
    about : mapping, Trajectory, state of one, or steady motion
        Values of coordinates and speeds by name or SymPy atom: numbers, text, or expressions of parameters and of new
        symbols. What is not named is zero. Speeds that are not zero make a steady motion: its coordinates move at
        these rates, and neither the balance nor the linear equations may change with time. A trajectory gives arrays
        over its output times, ``trajectory.at(t)`` the linear equations at that instant.
    where : mapping, optional
        Parameters in terms of others, such as the relation under which a steady motion exists.
    values : mapping, optional
        Numbers for parameters: the result is numeric, with default values for the others. ``{}`` takes all
        defaults. Without it the result is symbolic and exact.
    inputs : names or symbols
        Parameters (their deviations) and coordinates (a force along them) that drive the linear equations.
    independent : names of coordinates, optional
        Of a machine with constraints: those whose rates stand for the motion. If not given they are chosen by
        pivoting; in symbols, what ``about`` names is preferred, and what it does not name follows from the
        constraints where they hold it linearly.

    Returns
    -------
    LinearModel

    Raises
    ------
    ModelError
        A state that is not balanced (with what is left of each equation), a position or speeds that do not
        satisfy the constraints, a motion that is not steady, unknown names.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1, L=1, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(m))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    >>> linear = fb.linearize(s)
    >>> linear.M, linear.K
    (Matrix([[L**2*m]]), Matrix([[L*g*m]]))
    >>> fb.linearize(s, values={"L": 2}).natural_frequencies().round(6)
    array([2.214723])
    """
    model = getattr(s, "model", s)
    if isinstance(s, System):
        model = assemble(s)
    if not isinstance(model, Model):
        raise ModelError(f"Expected a System, a Model or its equations to linearise, got {s!r}.")
    named = _inputs(model, inputs)
    if _is_motion(about):
        return _about_trajectory(model, about, values, named, independent)
    if values is None:
        return _symbolic(model, about, where or {}, named, independent)
    return _numeric(model, about, where or {}, values, named, independent)


# -- symbols --------------------------------------------------------------------------------------


def _symbolic(
    model: Model, about: Any, where: Mapping[Any, Any], inputs: Sequence[str], independent: Any
) -> LinearModel:
    point = operating_point(model, about)
    ring = Ring(capacity=64 + len(model.parameters) + 2 * model.n_u)
    for expression in model.positive:
        ring.assume_positive(expression)
    given = _where(model, where)
    parameters = [p for p in model.parameters if p.name in inputs]
    for p in parameters:  # an input deviates from its default
        given.setdefault(p.symbol, value_of_name(model, p.default or 0, p.name))
    values: dict[Any, Any] = {p.symbol: ring.generator(p.symbol, "parameter") for p in model.parameters}
    values.update({symbol: ring.from_sympy(x) for symbol, x in given.items()})
    t = ring.generator(model.names.atoms["t"], "time")
    replaced = {symbol: sympy.sympify(x) for symbol, x in given.items()}

    def element(x: Any) -> Any:
        return ring.from_sympy(sympy.sympify(x).xreplace(replaced)) if isinstance(x, sympy.Basic) else x

    q0, u0 = [element(x) for x in point.q], [element(x) for x in point.u]
    if model.constraints:
        from .constrained_symbols import constrained_symbols

        return constrained_symbols(model, ring, point, q0, u0, t, values, inputs, _names(model, independent))
    q = along(model, ring, q0, u0, t, values)
    # an acceleration is never asked for: the deviations are about a motion without any
    terms = terms_at(model, ring, q, u0, (0,) * model.n_u, t, values, inputs)
    names = tangent_names(model)
    time = ring.generator(model.names.atoms["t"]).mask
    balanced(
        model, ring, terms["residual"], names, time, "without accelerations the equations of motion leave"
    )
    steady(model, ring, terms, names, time)
    terms = _in_rates(terms, tangent_drift(model, u0))
    return LinearModel(
        model,
        names,
        tuple(inputs),
        terms,
        ring=ring,
        point=_named_point(model, point.q, point.u),
    )


def _where(model: Model, where: Mapping[Any, Any]) -> dict[Any, Any]:
    symbols = {p.name: p.symbol for p in model.parameters}
    result = {}
    for key, value in where.items():
        name = key if isinstance(key, str) else model.names.texts.get(key, str(key))
        if name not in symbols:
            raise ModelError(f"Unknown parameter '{name}' in `where`; {nearest(name, symbols)}")
        result[symbols[name]] = value_of_name(model, value, f"the parameter '{name}'")
    return result


def balanced(
    model: Model, ring: Ring, residual: Sequence[Any], names: Sequence[str], moving: int, what: str
) -> None:
    """Refuse a residual, by coordinates, that is not zero; ``moving`` is the mask of what changes with time."""
    left = {name: r for name, r in zip(names, residual, strict=True) if not is_zero(r)}
    if not left:
        return
    shown = "; ".join(f"{name}: {text(r, ring)}" for name, r in left.items())
    changes = any(ring.depends(r) & moving for r in left.values())
    motion = "a steady motion" if changes else "an equilibrium or a steady motion"
    raise ModelError(
        f"The state given is not {motion} of '{model.name}': {what} {shown} in place of 0. Give a balanced state in "
        "`about` (fb.steady_motions finds them), a relation among parameters as where={parameter: expression} (or in "
        "`inputs` a load that is zero but for disturbances), or a trajectory."
    )


def steady(model: Model, ring: Ring, terms: Mapping[str, Any], names: Sequence[str], moving: int) -> None:
    """Refuse matrices that hold what changes with time."""
    for key in "MCKB":
        for name, row in zip(names, terms[key], strict=True):
            for x in row:
                if ring.depends(x) & moving:
                    raise ModelError(
                        f"The motion given is balanced, but the linear equations of '{model.name}' about it change "
                        f"with time: {key} has {text(x, ring)} in the row of '{name}'. Linearise about a trajectory "
                        "(about=fb.simulate(...)), or use coordinates in which the motion is steady."
                    )


# -- the derivatives, for any field ---------------------------------------------------------------


def terms_at(
    model: Model,
    field: Field,
    q: Sequence[Any],
    u: Sequence[Any],
    udot: Sequence[Any],
    t: Any,
    values: Mapping[Any, Any],
    inputs: Sequence[str],
) -> dict[str, Any]:
    """Residual, M, C, K and B of M u' + C δu + K ξ = B f at a state."""
    n = model.n_u
    symbols = {p.name: p.symbol for p in model.parameters}
    place = {name: 3 * n + k for k, name in enumerate(name for name in inputs if name in symbols)}
    state = perturbed(model, field, q, u, t, values, [symbols[name] for name in place])
    dual = DualField(field)
    accelerations = [dual.dual(x, {2 * n + j: 1}) for j, x in enumerate(udot)]
    left = inverse_dynamics(model, state, accelerations)
    blocks = {
        name: [[slope_of(x, start + j) for j in range(n)] for x in left]
        for name, start in (("K", 0), ("C", n), ("M", 2 * n))
    }
    names = tangent_names(model)
    B = [
        [-slope_of(x, place[name]) if name in place else int(names[i] == name) for name in inputs]
        for i, x in enumerate(left)
    ]
    return {"residual": [value_of(x) for x in left], **blocks, "B": B}


def _in_rates(
    terms: dict[str, Any], A: Sequence[Sequence[Any]], A_rate: Sequence[Sequence[Any]] | None = None
) -> dict[str, Any]:
    """From speeds to the rates of the deviations, δu = ξ' - A ξ: C - M A in place of C, K - C A - M A' in place of K.

    A changes along a motion whose speeds do.
    """
    if all(type(x) is int and x == 0 for row in A for x in row):
        return terms
    C, K = terms["C"], _minus(terms["K"], _product(terms["C"], A))
    return {
        **terms,
        "C": _minus(C, _product(terms["M"], A)),
        "K": K if A_rate is None else _minus(K, _product(terms["M"], A_rate)),
        "A": A,
    }


def _product(X: Sequence[Sequence[Any]], Y: Sequence[Sequence[Any]]) -> list[list[Any]]:
    return [[sum((x * y[j] for x, y in zip(row, Y, strict=True)), 0) for j in range(len(Y[0]))] for row in X]


def _minus(X: Sequence[Sequence[Any]], Y: Sequence[Sequence[Any]]) -> list[list[Any]]:
    return [[x - y for x, y in zip(a, b, strict=True)] for a, b in zip(X, Y, strict=True)]


# -- numbers --------------------------------------------------------------------------------------


def _numeric(
    model: Model,
    about: Any,
    where: Mapping[Any, Any],
    values: Mapping[Any, Any],
    inputs: Sequence[str],
    independent: Any,
) -> LinearModel:
    point = operating_point(model, about)
    numbers = _numbers(model, where, values)

    def number(x: Any) -> float:
        return float(_evaluated(model, x, numbers, "`about`"))

    q0, u0 = [number(x) for x in point.q], [number(x) for x in point.u]
    for i in model.quaternions:
        length = float(np.linalg.norm(q0[i : i + 4]))
        if not length > 0:
            raise ModelError(f"Expected a quaternion of length 1 in `about`, got {q0[i : i + 4]}.")
        q0[i : i + 4] = [x / length for x in q0[i : i + 4]]
    if model.constraints:
        from .linearize_constrained import constrained

        return constrained(model, q0, u0, point.given, numbers, inputs, _names(model, independent))
    fastest = max([abs(x) for x in u0], default=0)
    quarter = np.pi / (2 * fastest) if fastest > 0 else 1
    looked = []
    for k in TIMES:
        t = k * quarter
        q = along(model, floats, q0, u0, t, numbers)
        looked.append(
            _as_arrays(terms_at(model, floats, q, u0, (0,) * model.n_u, t, numbers, inputs), model, inputs)
        )
    scale = scale_of(looked[0], np.array(u0))
    names = tangent_names(model)
    off = (one for one in looked if not (np.abs(one["residual"]) <= SMALL * scale).all())
    residual = next(off, looked[0])["residual"]
    check_balance(model, residual, scale, names, "without accelerations the equations of motion leave")
    check_regular(model, looked[0]["M"])
    for one in looked[1:]:
        for key in "MCKB":
            check_same(model, looked[0][key], one[key], key)
    terms = {k: np.array(v, dtype=float) for k, v in _in_rates(looked[0], tangent_drift(model, u0)).items()}
    return LinearModel(
        model, names, tuple(inputs), terms, point=_named_point(model, q0, u0), values=_by_name(model, numbers)
    )


def check_balance(model: Model, residual: Any, scale: Any, names: Sequence[str], what: str) -> None:
    """Refuse a residual that is not round-off."""
    off = {
        name: float(r) for name, r, a in zip(names, residual, scale, strict=True) if not abs(r) <= SMALL * a
    }
    if off:
        shown = ", ".join(f"{name}: {r:.6g}" for name, r in off.items())
        raise ModelError(
            f"The state given is not an equilibrium or a steady motion of '{model.name}': {what} {shown} in place of "
            "0. Give a balanced state in `about` (fb.steady_motions finds them), or a trajectory."
        )


def check_regular(model: Model, M: Any) -> None:
    """Refuse a mass matrix that is singular, with each coordinate in a unit in which its own entry is 1."""
    own = np.sqrt(np.abs(np.diagonal(M)))
    if (own > 0).all() and np.linalg.cond(M / np.outer(own, own)) * 10 * len(M) * np.finfo(float).eps < 1:
        return
    raise ModelError(SINGULAR.format(model.name))


def check_same(model: Model, first: Any, later: Any, what: str) -> None:
    """Refuse matrices that change along a steady motion."""
    size = np.max(np.abs(first), initial=0)
    change = np.max(np.abs(later - first), initial=0)
    if not change <= 10**4 * SMALL * size:
        raise ModelError(
            f"The motion given is balanced, but the linear equations of '{model.name}' about it change with time: "
            f"entries of {what} up to {size:.6g} change by {change:.6g}. Linearise about a trajectory "
            "(about=fb.simulate(...)), or use coordinates in which the motion is steady."
        )


def scale_of(terms: Mapping[str, Any], u: Any) -> Any:
    """Size of the terms of each equation at unit deviations."""
    fast = np.max(np.abs(u), initial=0)
    M, C, K = (np.abs(terms[key]).sum(axis=1) for key in "MCK")
    return M * (1 + fast**2) + C * (1 + fast) + K


def _as_arrays(terms: Mapping[str, Any], model: Model, inputs: Sequence[str]) -> dict[str, Any]:
    shapes = {"B": (model.n_u, len(inputs)), "residual": (model.n_u,)}
    n = (model.n_u, model.n_u)
    return {k: np.array(v, dtype=float).reshape(shapes.get(k, n)) for k, v in terms.items()}


def _numbers(model: Model, where: Mapping[Any, Any], values: Mapping[Any, Any]) -> dict[Any, float]:
    replaced = _where(model, where)
    known = {p.symbol: p for p in model.parameters}
    missing = {p.name: 1 for p in model.parameters if p.symbol in replaced}
    plain = model.values({**missing, **values})
    numbers = {symbol: plain[p.name] for symbol, p in known.items()}
    for symbol, x in replaced.items():
        numbers[symbol] = float(_evaluated(model, x, numbers, "`where`"))
    check_assumptions(model, _by_name(model, numbers))
    return numbers


def _evaluated(model: Model, x: Any, numbers: Mapping[Any, float], what: str) -> Any:
    if isinstance(x, sympy.Basic):
        unknown = x.free_symbols - set(numbers)
        if unknown:
            raise ModelError(
                f"Expected numbers in {what}, but '{x}' holds {', '.join(sorted(map(str, unknown)))}, which "
                "has no value. Put a number, or leave out values= for a symbolic result."
            )
    return evaluate(x, numbers, floats)


def _by_name(model: Model, numbers: Mapping[Any, float]) -> dict[str, float]:
    return {p.name: numbers[p.symbol] for p in model.parameters}


# -- along a trajectory ---------------------------------------------------------------------------


def _is_motion(about: Any) -> bool:
    return hasattr(about, "t") and (hasattr(about, "states") or (hasattr(about, "q") and hasattr(about, "u")))


def _about_trajectory(
    model: Model, about: Any, values: Mapping[Any, Any] | None, inputs: Sequence[str], independent: Any
) -> LinearModel:
    trajectory = getattr(about, "_trajectory", about)
    if tuple(trajectory.names) != (*model.coordinate_names, *model.speed_names):
        raise ModelError(
            f"Expected a motion of '{model.name}' in `about`, got one of '{trajectory.name}' with the names "
            f"{', '.join(trajectory.names)}."
        )
    numbers = _numbers(model, {}, trajectory.values if values is None else {**trajectory.values, **values})
    times = np.asarray(about.t, dtype=float)
    states = about.states if hasattr(about, "states") else np.concatenate([about.q, about.u], axis=-1)
    shape = times.shape
    times, states = times.reshape(-1), np.asarray(states).reshape(times.size, -1)
    q = [column(states[:, i]) for i in range(model.n_q)]
    u = [column(states[:, model.n_q + j]) for j in range(model.n_u)]
    at = column(times)
    if model.constraints:
        from .linearize_constrained import constrained_along

        return constrained_along(
            model,
            [*map(np.asarray, q)],
            [*map(np.asarray, u)],
            times,
            shape,
            numbers,
            inputs,
            _names(model, independent),
        )
    udot = forward_dynamics(model, State(model, arrays, at, q, u, numbers))
    terms = terms_at(model, arrays, q, u, udot, at, numbers, inputs)
    terms = _in_rates(terms, tangent_drift(model, u), tangent_drift(model, udot))
    stacked = {}
    for key in ("M", "C", "K", "B", *(["A"] if "A" in terms else [])):
        rows = [[np.broadcast_to(np.asarray(x, dtype=float), times.shape) for x in row] for row in terms[key]]
        m = len(inputs) if key == "B" else model.n_u
        full = np.array(rows).reshape(model.n_u, m, times.size)
        stacked[key] = np.moveaxis(full, -1, 0).reshape(*shape, model.n_u, m)
    return LinearModel(
        model,
        tangent_names(model),
        tuple(inputs),
        stacked,
        point=_named_point(model, *([np.asarray(x).reshape(shape) for x in y] for y in (q, u))),
        values=_by_name(model, numbers),
        times=times.reshape(shape),
    )


# -- names ----------------------------------------------------------------------------------------


def _inputs(model: Model, inputs: Any) -> tuple[str, ...]:
    known = [p.name for p in model.parameters] + list(tangent_names(model))
    return _listed(model, inputs, known, "inputs")


def _names(model: Model, independent: Any) -> tuple[str, ...]:
    return _listed(model, independent, list(tangent_names(model)), "independent")


def _listed(model: Model, given: Any, known: Sequence[str], what: str) -> tuple[str, ...]:
    if isinstance(given, str):
        given = given.replace(",", " ").split()
    elif isinstance(given, sympy.Basic):
        given = [given]
    names = tuple(x if isinstance(x, str) else model.names.texts.get(x, str(x)) for x in given)
    for name in names:
        if name not in known:
            raise ModelError(f"Unknown name '{name}' in {what}; {nearest(name, known)}")
    if len(set(names)) != len(names):
        raise ModelError(f"Expected each name once in {what}, got {', '.join(names)}.")
    return names


def _named_point(model: Model, q: Sequence[Any], u: Sequence[Any]) -> dict[str, Any]:
    return {
        **dict(zip(model.coordinate_names, q, strict=True)),
        **dict(zip(model.speed_names, u, strict=True)),
    }
