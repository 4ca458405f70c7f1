"""Linear equations of small motions about an equilibrium, a steady motion or a trajectory.

    M ξ'' + C ξ' + K ξ = B f        C = D + G (damping, gyroscopic),   K = S + N (stiffness, circulatory)

The equations of motion L(q, u, u', t, f) = M u' + h - Q are evaluated once on dual numbers (`scalar.dual`). M, C, K
and B are their exact derivatives: polynomials for symbols, floats or arrays for numbers. No finite differences are
used, and the nonlinear equations are never written out.

Sources: chapter 6, eqs (6.107) to (6.114); Meirovitch, Methods of Analytical Dynamics (1970), chapter 8.

The file is longer than others: symbols, numbers and trajectories share the same derivatives and the same checks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import sympy

from ...describe.system import System
from ...dynamics.articulated import forward_dynamics
from ...dynamics.newton_euler import inverse_dynamics
from ...dynamics.state import State
from ...errors import ModelError, arguments_named, nearest
from ...model.model import Model
from ...model.values import check_assumption
from ...scalar.algebra import Expression, Field, Scalar, floats
from ...scalar.arrays import arrays, column
from ...scalar.dual import DualField, slope_of, value_of
from ...scalar.expression import evaluate
from ...scalar.polynomial import Ring
from ..derivation.contact_modes import check_modes_are_chosen
from .checks import SMALL, Checks, balanced, scale_of, steady
from .constrained_symbols import constrained_symbols
from .linear_model import LinearModel
from .linearize_constrained import constrained, constrained_along
from .operating_point import (
    along,
    moved,
    operating_point,
    perturbed,
    tangent_drift,
    tangent_names,
    value_of_name,
)
from .recorded_functions import Points, Recorded, recorded

QUARTERS = (0, 1, 2, 3)
"""Quarter turns after which a steady motion in numbers is checked: its linear equations must not change."""


@arguments_named
def linearize(
    s: Any,
    about: Any = None,
    *,
    where: Mapping[Any, Expression] | None = None,
    values: Mapping[Any, Expression] | None = None,
    inputs: Any = (),
    independent: Any = (),
) -> LinearModel:
    """Linear equations of the small motions of a machine about an equilibrium or a motion.

    M ξ'' + C ξ' + K ξ = B f, where ξ are the deviations of the coordinates and have their names. A ball joint ``j``
    has the small turns ``j_rx, j_ry, j_rz`` about the child's axes, q = q0 ∘ exp(ξ/2); a free joint also has the
    displacements ``j_dx, j_dy, j_dz`` along them.

    Parameters
    ----------
    s : System, Model or Equations
    about : mapping, Trajectory, state of one, or steady motion
        Values of coordinates and speeds by name or SymPy atom: numbers, text, or expressions of parameters and of new
        symbols. Coordinates and speeds not named are zero. Nonzero speeds describe a steady motion: its coordinates
        move at these rates, and neither the balance nor the linear equations may change with time. A trajectory gives
        arrays over its output times, ``trajectory.at(t)`` the linear equations at that instant.
    where : mapping, optional
        Parameters as expressions of others, such as the relation under which a steady motion exists.
    values : mapping, optional
        Numbers for parameters; the others have their defaults, and the result is numeric. ``{}`` takes all
        defaults. Arrays that broadcast give the equations at all their values in one call: their axes come first in
        the matrices and in ``eigenvalues()``. Without ``values`` the result is symbolic and exact.
    inputs : names or symbols
        Parameters (their deviations) and coordinates (a force along them) that drive the linear equations.
    independent : names of coordinates, optional
        For a machine with constraints: the coordinates whose rates describe the motion. By default they are chosen
        by pivoting. In symbols, coordinates named in ``about`` are preferred; the others follow from the constraints
        if these are linear in them.

    Returns
    -------
    LinearModel

    Raises
    ------
    ModelError
        A state that is not balanced (with the residual of each equation), a position or speeds that do not
        satisfy the constraints, a motion that is not steady, unknown names; a system with contacts, whose equations in
        chosen modes are needed: ``fb.linearize(fb.equations(s, modes={"floor": "stick"}))``.

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
    >>> fb.linearize(s, values={"L": [1, 2, 4]}).eigenvalues().imag[:, 0].round(6)
    array([3.132092, 2.214723, 1.566046])
    """
    machine = s if isinstance(s, System) else getattr(s, "model", s)
    if not isinstance(machine, System | Model):
        raise ModelError(f"Expected a System, a Model or its equations to linearise, got {s!r}.")
    programs = recorded(machine)
    model = programs.model
    if machine is s:
        check_modes_are_chosen(model, "fb.linearize")
    named = _inputs(model, inputs)
    if _is_motion(about):
        return _about_trajectory(programs, about, values, named, independent)
    if values is None:
        return _symbolic(programs, about, where or {}, named, independent)
    return _numeric(programs, about, where or {}, values, named, independent)


# -- symbols --------------------------------------------------------------------------------------


def _symbolic(
    programs: Recorded, about: Any, where: Mapping[Any, Expression], inputs: Sequence[str], independent: Any
) -> LinearModel:
    model = programs.model
    point = operating_point(model, about)
    if point.rounded:
        point = replace(point, rounded=_is_balanced_in_numbers(programs, about, where, inputs, independent))
    ring = Ring(capacity=64 + len(model.parameters) + 2 * model.n_u)
    for expression in model.positive:
        ring.assume_positive(expression)
    relations = _where(model, where)
    parameters = [p for p in model.parameters if p.name in inputs]
    for p in parameters:  # an input deviates from its default
        relations.setdefault(p.symbol, value_of_name(model, p.default or 0, p.name))
    values: dict[Any, Scalar] = {p.symbol: ring.generator(p.symbol, "parameter") for p in model.parameters}
    values.update({symbol: ring.from_sympy(x) for symbol, x in relations.items()})
    t = ring.generator(model.names.atoms["t"], "time")
    substituted = {symbol: sympy.sympify(x) for symbol, x in relations.items()}

    def element(x: Expression) -> Scalar:
        return ring.from_sympy(sympy.sympify(x).xreplace(substituted)) if isinstance(x, sympy.Basic) else x

    q0, u0 = [element(x) for x in point.q], [element(x) for x in point.u]
    if model.constraints:
        start = State(model, ring, t, q0, u0, values)
        return constrained_symbols(point, start, inputs, _names(model, independent))
    q = along(model, ring, q0, u0, t, values)
    # the deviations are about a motion without accelerations, so that none need be solved for
    terms = terms_at(model, ring, q, u0, (0,) * model.n_u, t, values, inputs)
    names = tangent_names(model)
    time = ring.generator(model.names.atoms["t"]).mask
    if not point.rounded:
        what = "without accelerations the equations of motion leave"
        balanced(model, ring, terms["residual"], names, time, what)
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


def _is_balanced_in_numbers(
    programs: Recorded, about: Any, where: Mapping[Any, Expression], inputs: Sequence[str], independent: Any
) -> bool:
    """Return True if a state of floats is balanced up to round-off, at the default values."""
    try:
        _numeric(programs, about, where, {}, inputs, independent)
    except ModelError:
        return False
    return True


def _where(model: Model, where: Mapping[Any, Expression]) -> dict[Any, Expression]:
    symbols = {p.name: p.symbol for p in model.parameters}
    result = {}
    for key, value in where.items():
        name = key if isinstance(key, str) else model.names.texts.get(key, str(key))
        if name not in symbols:
            raise ModelError(f"Unknown parameter '{name}' in `where`; {nearest(name, symbols)}")
        result[symbols[name]] = value_of_name(model, value, f"the parameter '{name}'")
    return result


# -- the derivatives, for any field ---------------------------------------------------------------


def terms_at(
    model: Model,
    field: Field,
    q: Sequence[Scalar],
    u: Sequence[Scalar],
    udot: Sequence[Scalar],
    t: Scalar,
    values: Mapping[Any, Scalar],
    inputs: Sequence[str],
) -> dict[str, Any]:
    """Return the residual, M, C, K and B of M u' + C δu + K ξ = B f at a state."""
    n = model.n_u
    symbols = {p.name: p.symbol for p in model.parameters}
    place = {name: 3 * n + k for k, name in enumerate(name for name in inputs if name in symbols)}
    state = perturbed(model, field, q, u, t, values, [symbols[name] for name in place])
    dual = DualField(field)
    accelerations = [dual.dual(x, {2 * n + j: 1}) for j, x in enumerate(udot)]
    residual = inverse_dynamics(model, state, accelerations)
    blocks = {
        name: [[slope_of(x, start + j) for j in range(n)] for x in residual]
        for name, start in (("K", 0), ("C", n), ("M", 2 * n))
    }
    names = tangent_names(model)
    B = [
        [-slope_of(x, place[name]) if name in place else int(names[i] == name) for name in inputs]
        for i, x in enumerate(residual)
    ]
    return {"residual": [value_of(x) for x in residual], **blocks, "B": B}


def _in_rates(
    terms: dict[str, Any], A: Sequence[Sequence[Scalar]], A_rate: Sequence[Sequence[Scalar]] | None = None
) -> dict[str, Any]:
    """Replace speeds by rates of the deviations, δu = ξ' - A ξ: C becomes C - M A, and K becomes K - C A - M A'.

    A' is not zero along a motion whose speeds change.
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


def _product(X: Sequence[Sequence[Scalar]], Y: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
    return [[sum((x * y[j] for x, y in zip(row, Y, strict=True)), 0) for j in range(len(Y[0]))] for row in X]


def _minus(X: Sequence[Sequence[Scalar]], Y: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
    return [[x - y for x, y in zip(a, b, strict=True)] for a, b in zip(X, Y, strict=True)]


# -- numbers --------------------------------------------------------------------------------------


def _numeric(
    programs: Recorded,
    about: Any,
    where: Mapping[Any, Expression],
    values: Mapping[Any, Expression],
    inputs: Sequence[str],
    independent: Any,
) -> LinearModel:
    model = programs.model
    point = operating_point(model, about)
    shape, numbers = _numbers(model, where, values)
    size = int(np.prod(shape))

    def row(x: Expression) -> Any:
        return np.broadcast_to(np.asarray(_evaluated(model, x, numbers, "`about`"), dtype=float), (size,))

    q0, u0 = (np.array([row(x) for x in xs]).reshape(len(xs), size).T for xs in (point.q, point.u))
    parameters = (
        np.array([np.broadcast_to(x, (size,)) for x in numbers.values()]).reshape(len(numbers), size).T
    )
    checks = Checks(model, shape, numbers)
    for i in model.quaternions:
        length = np.linalg.norm(q0[:, i : i + 4], axis=1)
        if not (length > 0).all():
            which = int(np.argmin(length > 0))
            raise ModelError(
                f"Expected a quaternion of length 1 in `about`, got {q0[which, i : i + 4].tolist()}."
            )
        q0[:, i : i + 4] /= length[:, None]
    points = Points(np.zeros(size), q0, u0, parameters)
    if model.constraints:
        return constrained(programs, points, point.names, inputs, _names(model, independent), checks)
    fastest = np.abs(u0).max(axis=1, initial=0)
    quarter = np.pi / 2 / np.where(fastest > 0, fastest, np.pi / 2)

    def recorded_terms(state: State) -> dict[str, Any]:
        no_accelerations = (0,) * model.n_u
        own_values = {p.symbol: state.values[p.symbol] for p in model.parameters}
        terms = terms_at(model, state.field, state.q, state.u, no_accelerations, state.t, own_values, inputs)
        terms["B"] = np.array(terms["B"], dtype=object).reshape(model.n_u, len(inputs))
        return {**terms, "A": tangent_drift(model, state.u)}

    quarters = [
        programs(("terms", tuple(inputs)), recorded_terms, moved(model, points, k * quarter))
        for k in QUARTERS
    ]
    scale = scale_of(quarters[0], u0)
    names = tangent_names(model)
    off = (terms for terms in quarters if not (np.abs(terms["residual"]) <= SMALL * scale).all())
    residual = next(off, quarters[0])["residual"]
    checks.balance(residual, scale, names, "without accelerations the equations of motion leave")
    checks.regular(quarters[0]["M"])
    for terms in quarters[1:]:
        for key in "MCKB":
            checks.same(quarters[0][key], terms[key], key)
    M, C, A = (quarters[0][key] for key in "MCA")
    terms = {**quarters[0], "C": C - M @ A, "K": quarters[0]["K"] - C @ A}
    return LinearModel(
        model,
        names,
        tuple(inputs),
        {key: x.reshape(*shape, *x.shape[1:]) for key, x in terms.items()},
        point=checks.named(q0, u0),
        values=checks.values,
    )


def _numbers(
    model: Model, where: Mapping[Any, Expression], values: Mapping[Any, Expression]
) -> tuple[tuple[int, ...], dict[Any, Any]]:
    """Return the shape of the arrays in ``values``, and the parameters by symbol as numbers or flat arrays."""
    replaced = _where(model, where)
    parameters = {p.symbol: p for p in model.parameters}
    missing = {p.name: 1 for p in model.parameters if p.symbol in replaced}
    shape, many = _arrays(model, values)
    plain = model.values({**missing, **values, **{key: x.flat[0] for key, x in many.items()}})
    numbers: dict[Any, Any] = {symbol: plain[p.name] for symbol, p in parameters.items()}
    for key, x in many.items():
        name = key if isinstance(key, str) else model.parameter_names.get(key, key)
        numbers[next(p.symbol for p in model.parameters if p.name == name)] = column(x.reshape(-1))
    for symbol, x in replaced.items():
        numbers[symbol] = _evaluated(model, x, numbers, "`where`")
    by_name = {p.name: np.reshape(numbers[p.symbol], -1) for p in model.parameters}
    for expression in model.assumed:
        holds = np.reshape(_evaluated(model, expression, numbers, "assumptions"), -1) > 0
        k = int(np.argmin(holds))  # the first value that does not hold, if any
        check_assumption(model, expression, {name: float(x[k % len(x)]) for name, x in by_name.items()})
    return shape, numbers


def _arrays(model: Model, values: Mapping[Any, Expression]) -> tuple[tuple[int, ...], dict[Any, Any]]:
    """Return the values that are arrays or lists, broadcast to one shape."""
    if not isinstance(values, Mapping):
        return (), {}
    result = {}
    for key, value in values.items():
        if isinstance(value, str | sympy.Basic) or not hasattr(value, "__len__") and not np.ndim(value):
            continue
        try:
            listed = np.asarray(value)
        except ValueError:
            raise ModelError(f"Expected rows of one length for '{key}' in values=, got {value!r}.") from None
        if not listed.ndim:
            continue
        if not listed.size:
            raise ModelError(f"Expected at least one value of '{key}' in values=, got an empty array.")
        if (
            listed.dtype.kind not in "iuf" or not np.isfinite(listed).all()
        ):  # texts with units, or values to refuse
            name = key if isinstance(key, str) else model.parameter_names.get(key, key)
            each = [model.values({**_defaults(model), key: x})[name] for x in listed.reshape(-1).tolist()]
            listed = np.array(each).reshape(listed.shape)
        result[key] = listed.astype(float)
    try:
        full = np.broadcast_arrays(*result.values())
    except ValueError:
        shapes = ", ".join(f"{key}: {x.shape}" for key, x in result.items())
        raise ModelError(f"Expected arrays in values= that fit each other's shape, got {shapes}.") from None
    return (full[0].shape if full else ()), dict(zip(result, full, strict=True))


def _defaults(model: Model) -> dict[str, Any]:
    return {p.name: 1 for p in model.parameters if p.default is None}


def _evaluated(model: Model, x: Expression, numbers: Mapping[Any, float], what: str) -> Any:
    if isinstance(x, sympy.Basic):
        unknown = x.free_symbols - set(numbers)
        if unknown:
            raise ModelError(
                f"Expected numbers in {what}, but '{x}' holds {', '.join(sorted(map(str, unknown)))}, which "
                "has no value. Put a number, or leave out values= for a symbolic result."
            )
    return evaluate(x, numbers, arrays if any(np.ndim(value) for value in numbers.values()) else floats)


def _by_name(model: Model, numbers: Mapping[Any, float]) -> dict[str, float]:
    return {p.name: numbers[p.symbol] for p in model.parameters}


# -- along a trajectory ---------------------------------------------------------------------------


def _is_motion(about: Any) -> bool:
    return hasattr(about, "t") and (hasattr(about, "states") or (hasattr(about, "q") and hasattr(about, "u")))


def _about_trajectory(
    programs: Recorded,
    about: Any,
    values: Mapping[Any, Expression] | None,
    inputs: Sequence[str],
    independent: Any,
) -> LinearModel:
    model = programs.model
    trajectory = getattr(about, "_trajectory", about)
    if tuple(trajectory.names) != model.state_names:
        raise ModelError(
            f"Expected a motion of '{model.name}' in `about`, got one of '{trajectory.name}' with the names "
            f"{', '.join(trajectory.names)}."
        )
    lanes, numbers = _numbers(
        model, {}, trajectory.values if values is None else {**trajectory.values, **values}
    )
    if lanes:
        raise ModelError(
            f"Expected one value of each parameter along a trajectory of '{model.name}', got arrays of shape {lanes}."
        )
    times = np.asarray(about.t, dtype=float)
    states = about.states if hasattr(about, "states") else np.concatenate([about.q, about.u], axis=-1)
    shape = times.shape
    times, states = times.reshape(-1), np.asarray(states).reshape(times.size, -1)
    q = [column(states[:, i]) for i in range(model.n_q)]
    u = [column(states[:, model.n_q + j]) for j in range(model.n_u)]
    time = column(times)
    if model.constraints:
        size = times.size
        parameters = np.tile([numbers[p.symbol] for p in model.parameters], (size, 1)).reshape(size, -1)
        points = Points(
            times, states[:, : model.n_q], states[:, model.n_q : model.n_q + model.n_u], parameters
        )
        checks = Checks(model, shape, numbers)
        return constrained_along(programs, points, shape, numbers, inputs, _names(model, independent), checks)
    udot = forward_dynamics(model, State(model, arrays, time, q, u, numbers))
    terms = terms_at(model, arrays, q, u, udot, time, numbers, inputs)
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


def _listed(model: Model, names_given: Any, known: Sequence[str], what: str) -> tuple[str, ...]:
    if isinstance(names_given, str):
        names_given = names_given.replace(",", " ").split()
    elif isinstance(names_given, sympy.Basic):
        names_given = [names_given]
    names = tuple(x if isinstance(x, str) else model.names.texts.get(x, str(x)) for x in names_given)
    for name in names:
        if name not in known:
            raise ModelError(f"Unknown name '{name}' in {what}; {nearest(name, known)}")
    if len(set(names)) != len(names):
        raise ModelError(f"Expected each name once in {what}, got {', '.join(names)}.")
    return names


def _named_point(model: Model, q: Sequence[Scalar], u: Sequence[Scalar]) -> dict[str, Any]:
    return {
        **dict(zip(model.coordinate_names, q, strict=True)),
        **dict(zip(model.speed_names, u, strict=True)),
    }
