"""Impulses: jumps of the speeds at a blow without duration, and the impulsive reactions of the joints.

    M Δu = Jᵀ P + Gᵀ Λ,        G Δu = 0

and for each link, from the tips inward, the impulse that its joint transmits to it

    F_i = I_i ΔV_i - (blows on i) + Σ F_child.

Velocity terms, weights and the forces of springs and dampers are finite and have no impulse.

Source: chapter 6, eqs (6.3), (6.21), integrated over the duration; Featherstone (2008), §11.7.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..describe.constraints.constraint import Gear
from ..model.model import GROUND, Model
from ..scalar.algebra import (
    ZERO,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    cross,
    divide,
    dot,
    scale,
    subtract,
)
from ..space.spatial import (
    ZERO6,
    Spatial,
    force_to_parent,
    minus,
    momentum_of,
    motion_to_child,
    plus,
    power,
)
from .composite import mass_matrix
from .conditions.constraint_forces import separating_force, wrenches
from .conditions.constraints import rows
from .conditions.linearized import linearized
from .coordinates import forces_on_speeds
from .joints.freedom import transmissible
from .kinematics import link_postures, place_of, point_position, rotation
from .linear import Factorization, applied, combined, products
from .loads.added_mass import added_forces
from .loads.loading import Loading, act
from .state import State

Blow = tuple[Any, Vector, Vector]
"""(point, impulse, moment impulse) in ground axes; the point belongs to the struck body, else it is (body, point)."""


def blows_on(model: Model, state: State, blows: Sequence[Blow]) -> Loading:
    """Return the impulses sorted by the links that they act on."""
    result = Loading()
    for place, impulse, moment in blows:
        body, point = place if isinstance(place, tuple) else (place.body, place)
        link, _ = place_of(model, body)
        if link == GROUND:
            continue
        posture = link_postures(model, state)[link]
        arm = subtract(point_position(model, state, point), posture.position)
        n = apply_transpose(posture.rotation, add(moment, cross(arm, impulse)))
        result.wrenches[link] = plus(result.wrench(link), (n, apply_transpose(posture.rotation, impulse)))
    return result


def generalized_impulse(model: Model, state: State, blows: Loading) -> tuple[Scalar, ...]:
    """Return Jᵀ P, the impulses conjugate to the speeds [N s, N m s]. Length n_u."""
    F = _inward(model, state, [blows.wrench(i) for i in range(len(model.links))])
    tau = [power(state.subspace(i), F[i]) if link.one_dof else 0 for i, link in enumerate(model.links)]
    return tuple(forces_on_speeds(model, state, tau, F))


def speed_jumps(
    model: Model, state: State, impulses: Sequence[Scalar], active: Sequence[int] = ()
) -> tuple[tuple[Scalar, ...], tuple[Scalar, ...]]:
    """Return Δu and the impulses Λ of the constraints (zero for those that are not ``active``).

    Parameters
    ----------
    impulses : sequence, length n_u
        From :func:`generalized_impulse`.
    active : sequence of int
        Independent conditions of :func:`rows`; their rates do not change.
    """
    M = Factorization(mass_matrix(model, state))
    jump = list(M.solve(impulses))
    multipliers: list[Scalar] = [0] * len(linearized(model, state).matrix)
    if active:
        G = [linearized(model, state).matrix[i] for i in active]
        X = [M.solve(row) for row in G]
        lam = Factorization(products(G, X)).solve([-x for x in applied(G, jump)])
        jump = combined(jump, lam, X)
        for i, multiplier in zip(active, lam, strict=True):
            multipliers[i] = multiplier
    return tuple(jump), tuple(multipliers)


def with_constraints(
    model: Model, state: State, blows: Sequence[Blow], multipliers: Sequence[Scalar], factor: Scalar = 1
) -> list[Blow]:
    """Return the blows together with the impulses of loops, ropes, rolling contacts and teeth.

    ``factor`` multiplies the blows and multipliers; the impulse that presses teeth apart, at |Λ|, gets it too.
    """
    result = list(blows)
    for row, multiplier, acting in zip(rows(model), multipliers, wrenches(model, state), strict=True):
        if isinstance(multiplier, int) and multiplier == 0:
            continue
        result += [(place, scale(multiplier, f), scale(multiplier, n)) for place, f, n in acting]
        owner = model.constraints[row.owner]
        if isinstance(owner, Gear):
            pair, size = separating_force(model, state, owner)
            pressure = size * state.field.apply("abs", multiplier)
            if not (isinstance(factor, int) and factor == 1):
                pressure = divide(pressure * factor, state.field.apply("abs", factor))
            result += [(place, scale(pressure, f), n) for place, f, n in pair]
    return result


def impulsive_reactions(
    model: Model, state: State, jumps: Sequence[Spatial], blows: Loading
) -> dict[str, tuple[Vector, Vector]]:
    """Return (impulse, moment impulse) of every joint on its child, about its point, in ground axes [N s, N m s].

    Parameters
    ----------
    jumps : list of Spatial
        ΔV of the links, :func:`freebody.dynamics.kinematics.link_twists` of the jumps of the speeds.
    blows : Loading
        All impulses on bodies, including those of constraints.
    """
    added, needs = Loading(), []
    for name, action in added_forces(model, state, jumps):
        act(model, state, added, model.loads[name], [action])
    blows = blows.plus(added)
    for i in range(len(model.links)):
        needs.append(minus(momentum_of(state.inertia(i), jumps[i]), blows.wrench(i)))
    for i, link in enumerate(model.links):
        spin = state.spin(i)
        if spin is not None and link.parent != GROUND:
            needs[link.parent] = plus(
                needs[link.parent], (scale(_rate_jump(model, state, i, jumps), spin[0]), ZERO)
            )
    F = _inward(model, state, needs)
    result = {}
    for name, joint in model.joints.items():
        last = joint.links[-1]
        n, f = transmissible(model, state, joint, F[last])
        R = rotation(model, state, last)
        result[name] = (apply(R, f), apply(R, n))
    return result


def _rate_jump(model: Model, state: State, i: int, jumps: Sequence[Spatial]) -> Scalar:
    """Return Δy' of a link with one displacement, from the jumps of the link and of its parent."""
    R, p, _ = state.joint(i)
    S, parent = state.subspace(i), model.links[i].parent
    change = minus(jumps[i], ZERO6 if parent == GROUND else motion_to_child(R, p, jumps[parent]))
    turn = S[0] != ZERO
    return dot(S[0], change[0]) if turn else dot(S[1], change[1])


def _inward(model: Model, state: State, wrenches: Sequence[Spatial]) -> list[Spatial]:
    """Return each link's wrench together with those of all links outward of it."""
    F = list(wrenches)
    for i in range(len(model.links) - 1, -1, -1):
        parent = model.links[i].parent
        if parent != GROUND:
            R, p, _ = state.joint(i)
            F[parent] = plus(F[parent], force_to_parent(R, p, F[i]))
    return F


def state_after(model: Model, state: State, jump: Sequence[Scalar]) -> State:
    """Return the state just after: the same coordinates, u + Δu."""
    u = [a + b for a, b in zip(state.u, jump, strict=True)]
    return State(model, state.field, state.t, state.q, u, state.values)
