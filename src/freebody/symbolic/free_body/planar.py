"""Planar motion, recognised by canonical zeros.

A model is planar with the normal n, a ground axis, if for every body

    ω × n = 0,    v_C · n = 0    identically,

and if the equations across the plane, ΣF·n = 0 and ΣM_C × n = 0, are homogeneous in reactions out of the plane and
contain nothing else (no products of inertia, loads or weights across the plane). These reactions are then zero, and two
force equations and one moment equation remain.

Source: chapter 6, section 6.5.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy

from ...dynamics.kinematics import rotation, velocities
from ...dynamics.state import State
from ...errors import ModelError, TooManyTermsError
from ...model.model import Model
from ...scalar.algebra import IDENTITY, ZERO, Scalar, Vector, add, apply, apply_transpose, cross, dot, floats
from ..derivation.derivation import Derivation
from ..printing.display import equation_latex, equation_text, text
from ..printing.show import aligned, latex_words
from ..printing.systems import Row, collect, eliminate
from .action import TITLES, action_lines
from .balance import BodyBalance, body_balance
from .reaction import LETTERS, unknowns

_LEAST = math.sqrt(np.finfo(float).eps)
"""Part of the greatest velocity that is round-off: half of its digits."""


@dataclass(frozen=True)
class Plane:
    """The plane of a planar model.

    Attributes
    ----------
    normal : int
        Index of the ground axis at right angles to the plane.
    zero : tuple of str
        Reaction components out of the plane, all zero.
    loose : tuple of str
        Indeterminate ones of these components, in loops with redundant constraints out of the plane.
    """

    normal: int
    zero: tuple[str, ...]
    loose: tuple[str, ...]

    @property
    def letter(self) -> str:
        """Name of the normal axis: x, y or z."""
        return LETTERS[self.normal]


def plane_of(e: Derivation) -> Plane | str:
    """Return the plane of a model's motion, or the reason why there is none."""
    if "plane" not in e.state.cache:
        e.state.cache["plane"] = _find_plane(e)
    return e.state.cache["plane"]


def normal_of(e: Derivation) -> int | None:
    """Return the index of the ground axis at right angles to the plane of a model's motion; None without a plane.

    If the equations are too long to be formed, the recursive ones decide.
    """
    try:
        plane = plane_of(e)
    except TooManyTermsError:
        return e.recursive.normal
    return plane.normal if isinstance(plane, Plane) else None


def _find_plane(e: Derivation) -> Plane | str:
    # a motion in space is seen in numbers; only one in a plane needs the proof that polynomials are zero
    with suppress(ArithmeticError, ModelError):
        found = _normals(*_velocities(e.model, _somewhere(e.model)), _LEAST)
        if all(found.values()):
            return next(iter(found.values()))
    reason = ""
    for k, across in _normals(*_velocities(e.model, e.state)).items():
        plane: Plane | str = across or _plane_with_normal(e, k)
        if isinstance(plane, Plane):
            return plane
        reason = reason or plane
    return reason


def _somewhere(model: Model) -> State:
    """Return a random state of floats."""
    random = np.random.default_rng(0)
    q, u = random.uniform(-1, 1, model.n_q), random.uniform(-1, 1, model.n_u)
    for i in model.quaternions:
        q[i : i + 4] /= np.linalg.norm(q[i : i + 4])
    values = {p.symbol: 1 + random.random() for p in model.parameters}
    return State(model, floats, random.random(), q.tolist(), u.tolist(), values)


def _velocities(model: Model, state: State) -> tuple[list[tuple[str, Vector]], list[tuple[str, Vector]]]:
    """Return name and angular velocity of each body, and name and velocity of its mass centre, in ground axes."""
    angular_velocities, velocities_of_centres = [], []
    for name, place in model.bodies.items():
        w, v = velocities(model, state)[place.link]
        R = rotation(model, state, place.link)
        p = state.vector(tuple(a + b for a, b in zip(place.origin, place.center, strict=True)))
        angular_velocities.append((name, apply(R, w)))
        velocities_of_centres.append((name, apply(R, add(v, cross(w, p)))))
    return angular_velocities, velocities_of_centres


def _normals(
    angular_velocities: list[tuple[str, Vector]],
    velocities_of_centres: list[tuple[str, Vector]],
    least: float = 0,
) -> dict[int, str]:
    """Return the ground axes about which alone bodies turn, and why some are not at right angles to all motion.

    Numbers are zero if they are ``least`` of the greatest, or less.
    """

    def moving(velocities: list[tuple[str, Vector]], k: int) -> list[str]:
        bound = least and least * max(abs(x) for _, v in velocities for x in v)
        return [name for name, v in velocities if (abs(v[k]) > bound if least else v[k] != 0)]

    turning_about = {k: names for k in range(3) if (names := moving(angular_velocities, k))}
    axes = sorted(turning_about)
    if len(axes) > 1:
        first, second = (turning_about[k][0] for k in axes[:2])
        turning = f"'{first}' turns" if first == second else f"'{first}' and '{second}' turn"
        reason = f"{turning} about the ground axes {' and '.join(LETTERS[k] for k in axes[:2])}"
        return dict.fromkeys(axes, reason)
    result = {}
    for k in axes or (2, 1, 0):
        across = moving(velocities_of_centres, k)
        result[k] = f"'{across[0]}' moves along the ground axis {LETTERS[k]}" if across else ""
    return result


def _plane_with_normal(e: Derivation, k: int) -> Plane | str:
    """Return the plane with normal k if the equations across it contain only reactions out of it, else the reason."""
    n = IDENTITY[k]
    outside: dict[str, Any] = {}
    for joint in e.model.joints:
        for c in unknowns(e.model, e.state, joint):
            if _is_across(c.force, c.moment, n):
                outside[c.name] = c.symbol
    for name, symbol, pair in zip(e.condition_names, e.multipliers, e.constraint_wrenches, strict=True):
        if pair and all(_is_across(force, moment, n) for _, force, moment in pair):
            outside[name] = symbol
    places, mask = {}, 0
    for name, symbol in outside.items():
        (g,) = e.ring.used(e.ring.generator(symbol, "reaction"))
        places[g.index] = (name, 1)
        mask |= g.depends
    rows = []
    for body in e.model.bodies:
        free = body_balance(e, body)
        for i, (title, (left, right)) in enumerate(zip(TITLES, free.balances, strict=True)):
            within = (i != k) if i < 3 else (i - 3 == k)
            if within and not mask & (e.ring.depends(left) | e.ring.depends(right)):
                continue
            terms = collect(left - right, places, e.ring)
            if within and any(monomial for monomial in terms):
                return f"the {title} equation of '{body}' contains the reaction {next(m for m in terms if m)[0][0]}"
            if not within:
                if () in terms:
                    return f"the {title} equation of '{body}' contains more than reactions across the plane"
                rows.append(Row(title, terms))
    solved, _ = eliminate(rows, [list(outside)])
    loose = [name for name in outside if name not in solved or solved[name]]
    return Plane(k, tuple(outside), tuple(loose))


def _is_across(force: Vector, moment: Vector, n: Vector) -> bool:
    """True if a wrench is a force along the normal, or a moment at right angles to it."""
    if force != ZERO:
        return cross(force, n) == ZERO and dot(moment, n) == 0
    return dot(moment, n) == 0


def plane_in(body: BodyBalance) -> tuple[Plane, int] | str:
    """Return the plane and the index of its normal among the axes of a free body, or the reason why there is none."""
    plane = plane_of(body._e)
    if isinstance(plane, str):
        return plane
    n = apply_transpose(body._axes, IDENTITY[plane.normal])
    nonzero = [k for k in range(3) if n[k] != 0]
    if len(nonzero) != 1:
        return f"the axes of '{body.frame}' are not along the normal {plane.letter}"
    return plane, nonzero[0]


def planar_balances(body: BodyBalance) -> tuple[tuple[str, Scalar, Scalar], ...]:
    """(title, left, right) of two force equations and one moment equation, canonical.

    Raises
    ------
    ModelError
        The model is not planar, with the reason.
    """
    in_axes = plane_in(body)
    if isinstance(in_axes, str):
        raise ModelError(
            f"Free body '{body.body}' is not planar: {in_axes}. Its six equations are in .equations."
        )
    plane, k = in_axes
    zero = set()
    for name in plane.zero:
        (g,) = body._e.ring.used(body._e.ring.generator(sympy.Symbol(name, real=True), "reaction"))
        zero.add(g.index)
    result = []
    for i in (*(j for j in range(3) if j != k), k + 3):
        left, right = body.balances[i]
        result.append((TITLES[i], _without(body, left, zero), right))
    return tuple(result)


def _without(body: BodyBalance, x: Scalar, zero: set[int]) -> Scalar:
    """Return x without the reactions that are zero; about a point off the plane, x may contain them."""
    terms = collect(x, {index: (index, 1) for index in zero}, body._e.ring)
    return terms[()].whole() if () in terms else 0


def planar_equations(body: BodyBalance) -> tuple[Any, ...]:
    """Return two force equations and one moment equation; see :attr:`FreeBody.planar_equations`."""
    show = body._e.displayed
    return tuple(sympy.Eq(show(a), show(b), evaluate=False) for _, a, b in planar_balances(body))


def planar_text(body: BodyBalance) -> str:
    """The forces in the plane by name, the three equations, and the reactions that are zero, as plain text."""
    in_axes = plane_in(body)
    assert not isinstance(in_axes, str)
    plane, k = in_axes
    ring = body._e.ring
    within = [j for j in range(3) if j != k]
    letters = ", ".join(LETTERS[j] for j in within)
    lines = [
        *body._e.heading,
        f"Free body '{body.body}': planar, components along {letters} of {body.frame} axes, "
        f"moments about {body.about} along {LETTERS[k]}",
    ]

    def in_plane(force: Vector) -> str:
        components = body._in_axes(force)
        return f"({', '.join(text(components[j], ring) for j in within)})"

    shown = [a for a in body.actions if a.name not in plane.zero]
    lines += action_lines(shown, in_plane, lambda couple: text(body._in_axes(couple)[k], ring))
    for title, left, right in planar_balances(body):
        lines.append(f"  {title}:  {equation_text(left, right, ring)}")
    names = {a.name for a in body.actions}
    zero = [name for name in plane.zero if name in names]
    loose = [name for name in plane.loose if name in names]
    if zero:
        line = f"  out of the plane, zero:  {', '.join(zero)}"
        if loose:
            line += f" ({', '.join(loose)}: indeterminate, zero if the loops fit without force)"
        lines.append(line)
    return "\n".join([*lines, *body.remarks()])


def planar_latex(body: BodyBalance) -> str:
    """The three equations as a LaTeX ``aligned`` block."""
    ring = body._e.ring
    pairs = [*((a, b) for _, a, b in planar_balances(body)), *body.laws]
    rows = [equation_latex(a, b, ring).replace(" = ", " &= ", 1) for a, b in pairs]
    above = [f"&{latex_words(line)}" for line in body._e.heading]
    return aligned([*above, *rows])
