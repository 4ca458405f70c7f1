"""Jumps of the speeds under impulses by exact elimination, Newton's restitution, and the centre of percussion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import sympy

from ...describe.frame import Point
from ...dynamics.composite import mass_matrix
from ...dynamics.conditions.linearized import linearized
from ...dynamics.impulse import (
    blows_on,
    generalized_impulse,
    impulsive_reactions,
    speed_jumps,
    with_constraints,
)
from ...dynamics.kinematics import carried, link_twists, point_velocity
from ...dynamics.state import State
from ...errors import ModelError
from ...model.model import Model
from ...scalar.algebra import ZERO, Scalar, Vector, divide, dot, scale
from ...scalar.element import Polynomial
from ...scalar.ratio import Ratio, cleared
from ..derivation.bodies import PointOf
from ..derivation.contact_modes import sticking_only
from ..equations import Equations
from ..free_body.gears import radial_symbols
from ..printing.systems import Row, Terms, eliminate
from ..solving.request import Request
from ..solving.solution import SolveResult
from ..solving.solve import solution_of
from ..solving.vocabulary import Vocabulary

Jumps = Callable[[Sequence[Scalar]], tuple[tuple[Scalar, ...], tuple[Scalar, ...]]]
"""Function from Jᵀ P to (Δu, Λ)."""


def exact_jumps(e: Equations, state: State) -> Jumps:
    """Return Δu and Λ by elimination on ratios of canonical polynomials; redundant conditions get no impulse.

        Δu = N w  with  G N = 0,      (Nᵀ M N) w = Nᵀ Jᵀ P,      Gᵀ Λ = M Δu - Jᵀ P

    N is formed first, without division. The expressions are far shorter than with the inverse of M.
    """
    model, ring = e.model, e.ring
    M = mass_matrix(model, state)
    sticking_only(linearized(model, state), "An impulse")
    G = linearized(model, state).matrix
    us = [f"u{j:04d}" for j in range(model.n_u)]
    ws = [f"w{i:04d}" for i in range(len(G))]
    dependent, _ = eliminate(
        [Row(name, _linear(ring, us, row)) for name, row in zip(ws, G, strict=True)], [us]
    )
    free = [k for k, key in enumerate(us) if key not in dependent]
    N = []
    for k in free:
        column = [Ratio(ring, 0)] * model.n_u
        column[k] = Ratio(ring, 1)
        for key, terms in dependent.items():
            column[us.index(key)] = terms.get(((us[k], 1),), Ratio(ring, 0)).tidy()
        N.append(cleared(ring, column))
    reduced = [
        [_sum(a[i] * M[i][j] * b[j] for i in range(len(M)) for j in range(len(M))) for b in N] for a in N
    ]
    keys = [us[k] for k in free]

    def jumps(f: Sequence[Scalar]) -> tuple[tuple[Scalar, ...], tuple[Scalar, ...]]:
        system = []
        for a, row, k in zip(N, reduced, free, strict=True):
            terms = _linear(ring, keys, row)
            right = _sum(x * y for x, y in zip(a, f, strict=True))
            if right != 0:
                terms[()] = -(right if type(right) is Ratio else Ratio(ring, right))
            system.append(Row(model.speed_names[k], terms))
        solved, remaining = eliminate(system, [keys])
        undetermined = [
            model.speed_names[k] for k in free if us[k] not in solved or _has_unknowns(solved[us[k]])
        ]
        if undetermined or remaining:
            raise ModelError(
                f"The impulse does not determine {', '.join(undetermined) or 'the speeds'}: no mass moves with them "
                f"alone. Give the bodies mass and moments of inertia."
            )
        w = [solved[key].get((), Ratio(ring, 0)) for key in keys]
        jump = [_sum(a[j] * x for a, x in zip(N, w, strict=True)) for j in range(model.n_u)]
        jump = [(x if type(x) is Ratio else Ratio(ring, x)).tidy() for x in jump]
        if not G:
            return tuple(jump), ()
        system = []
        for key in dependent:
            j = us.index(key)
            terms = _linear(ring, ws, [row[j] for row in G])
            right = _sum(x * y for x, y in zip(M[j], jump, strict=True)) - f[j]
            if right != 0:
                terms[()] = -(right if type(right) is Ratio else Ratio(ring, right))
            system.append(Row(key, terms))
        impulses, _ = eliminate(system, [ws])
        zero = Ratio(ring, 0)
        return tuple(jump), tuple(impulses[key].get((), zero) if key in impulses else 0 for key in ws)

    return jumps


def _linear(ring: Any, keys: Sequence[str], row: Sequence[Scalar]) -> Terms:
    """Terms of the linear form with these unknowns and coefficients."""
    return {((key, 1),): Ratio(ring, x) for key, x in zip(keys, row, strict=True) if x != 0}


def _sum(values: Iterable[Scalar]) -> Scalar:
    total: Scalar = 0
    for x in values:
        total = total + x
    return total


def _has_unknowns(terms: Terms) -> bool:
    return any(monomial for monomial in terms)


def float_jumps(model: Model, state: State, active: Sequence[int]) -> Jumps:
    """Return Δu and Λ in floats, with impulses of the active conditions only."""
    return lambda f: speed_jumps(model, state, f, active)


def restituted(
    model: Model, state: State, jumps: Jumps, point: Point, normal: Vector, restitution: Scalar, exact: bool
) -> Vector:
    """Return the impulse along the normal that changes n·v⁻ to -e n·v⁻ (Newton's restitution).

    With ``exact`` state and restitution are expressions, whose signs are not known.

    Raises
    ------
    ModelError
        A point that cannot move along the normal; with numbers, a point that does not approach, or e outside 0..1.
    """
    length = state.field.sqrt(dot(normal, normal))
    n = (divide(normal[0], length), divide(normal[1], length), divide(normal[2], length))
    jump, _ = jumps(generalized_impulse(model, state, blows_on(model, state, [(point, n, ZERO)])))
    gain = dot(n, carried(model, state, point, link_twists(model, state, jump)))
    speed = dot(n, point_velocity(model, state, point))
    if type(gain) is Ratio:
        gain = gain.tidy()
    if gain == 0 or (not exact and not gain > 0):
        raise ModelError(
            f"No impulse at {point} can change its velocity along the normal: the joints hold it there."
        )
    if not exact:
        if not 0 <= restitution <= 1:
            raise ModelError(f"Expected a coefficient of restitution from 0 to 1, got {restitution}.")
        if not speed < 0:
            raise ModelError(
                f"No impact: {point} moves along the normal at {float(speed):.6g} m/s, and only approaches the surface "
                f"at less than 0. The normal points from the surface to the body."
            )
    return scale(divide(-(1 + restitution) * speed, gain), n)


def percussion(
    e: Equations, joint: str, start: Sequence[Scalar], along: Sequence[Scalar], direction: Vector, body: Any
) -> SolveResult:
    """Distance h from the joint's point at which a blow along ``direction`` causes no impulse along it in the joint."""
    model, ring = e.model, e.ring
    for gear in radial_symbols(e):
        raise ModelError(
            f"A centre of percussion is not offered with gear '{gear}': the force that presses its teeth apart is not "
            f"linear in the blow. Ask fb.impulse for one blow."
        )
    vocabulary = Vocabulary(e)
    name = "h"
    while name in vocabulary.names:
        name += "_"
    symbol = sympy.Symbol(name, real=True)
    h = ring.generator(symbol, "parameter")
    state = e.state
    jumps = exact_jumps(e, state)
    total = []
    # the impulse is linear in h: blows at h = 0 and h = 1 determine it
    for k in range(2):
        place = tuple(a + k * b for a, b in zip(start, along, strict=True))
        f = blows_on(model, state, [(PointOf(body, place), direction, ZERO)])
        jump, multipliers = jumps(generalized_impulse(model, state, f))
        everything = with_constraints(model, state, [(PointOf(body, place), direction, ZERO)], multipliers)
        joint_impulses = impulsive_reactions(
            model, state, link_twists(model, state, jump), blows_on(model, state, everything)
        )
        value = dot(joint_impulses[joint][0], direction)
        total.append(value if type(value) is Ratio else Ratio(ring, value))
    request = Request(e, vocabulary)
    request.read_unknowns(symbol)
    x = (total[0] + (total[1] - total[0]) * h).num
    if symbol not in (ring.atoms_of(x) if type(x) is Polynomial else ()):
        raise ModelError(
            f"The impulse of joint '{joint}' does not depend on the position of the blow along {tuple(along)}. "
            f"Choose another direction, or another line."
        )
    request.add(f"impulse of '{joint}' along the blow", x)
    return solution_of(request)
