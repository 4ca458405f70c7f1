"""Forward dynamics by articulated bodies: accelerations at a cost linear in the number of bodies.

Inward:    U = I^A S,   D = Sᵀ U,   m = τ - Sᵀ p^A,
           I^a = I^A - U D⁻¹ Uᵀ,    p^a = p^A + I^a c + U D⁻¹ m        to the parent
Outward:   y'' = D⁻¹ (m - Uᵀ A'),   A = A' + S y''

A driven displacement has no D: its y'' is known and moves into c. Armature adds to D, and rotors in the parent to U.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §7.3.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import ModelError
from ..model.model import GROUND, Link, Model
from ..scalar.algebra import IDENTITY, ZERO, Matrix, Scalar, add, cross, divide, dot, negate, scale, subtract
from ..space.spatial import (
    ZERO6,
    Blocks,
    Spatial,
    blocks,
    blocks_less_outer,
    blocks_sum,
    blocks_times,
    blocks_to_parent,
    force_cross,
    force_to_parent,
    minus,
    momentum_of,
    motion_cross,
    motion_to_child,
    plus,
    power,
    times,
)
from .armature import turned_slides
from .composite import mass_matrix
from .coordinates import accelerations_of_coordinates, forces_on_displacements
from .kinematics import velocities
from .linear import Factorization, is_zero, solve_symmetric
from .loads.actions import accelerating
from .loads.loading import loading
from .newton_euler import bias
from .rotors import unturned
from .state import State

LinkTerms = tuple[Sequence[Spatial], list[Spatial], list[Scalar], Factorization]
"""Terms of a link: its own motions S, and U, m and D."""


def forward_dynamics(
    model: Model, state: State, forces: Sequence[Scalar] | None = None
) -> tuple[Scalar, ...]:
    """Return the accelerations u' under the model's loads and, if given, further generalized ``forces``.

    Returns
    -------
    tuple, length n_u
        u' [m/s², rad/s²].
    """
    if model.order is None or accelerating(model):
        return _by_mass_matrix(model, state, forces)
    loads = loading(model, state)
    extra = dict(loads.generalized)
    if forces is not None:
        for j, force in enumerate(forces):
            extra[j] = extra.get(j, 0) + force
    along = forces_on_displacements(model, state, extra)
    for i, force in loads.along.items():
        along[i] = along.get(i, 0) + force

    state = unturned(model, state, loads.wrenches)
    V = velocities(model, state)
    count = len(model.links)
    inertia = [blocks(state.inertia(i)) for i in range(count)]
    p = [minus(force_cross(V[i], momentum_of(state.inertia(i), V[i])), loads.wrench(i)) for i in range(count)]
    c = [motion_cross(V[i], state.joint(i)[2]) for i in range(count)]
    terms: list[Scalar] = [None] * count
    with_inertia: list[list[int]] = [[] for _ in range(count)]
    for i in range(count - 1, -1, -1):
        link = model.links[i]
        if link.driven:
            c[i] = plus(c[i], times(state.second_rate(link, None), state.subspace(i)))
        motion = free_motions(link, None if not link.one_dof or link.driven else state.subspace(i))
        tau: list[Scalar] = []
        if motion:
            tau = (
                [along.get(i, 0)] if link.one_dof else [extra.get(link.u + k, 0) for k in range(len(motion))]
            )
            U, m = pivot(motion, tau, inertia[i], p[i])
            D = [[power(S, W) for W in U] for S in motion]
            if link.armature:
                U, m = add_armature(state, i, c[i], U, m, D)
            with_inertia[i] = kept = _with_inertia(model, i, motion, D, tau, loads.wrench(i))
            motion, tau, U, m = ([x[k] for k in kept] for x in (motion, tau, U, m))
            if kept:
                terms[i] = (motion, U, m, Factorization([[D[j][k] for k in kept] for j in kept]))
        if link.parent == GROUND:
            continue
        p[i] = plus(p[i], _spin_moment(state, i, V[i]))
        I_a, p_a = apparent_inertia(inertia[i], p[i], c[i], tau, terms[i], alone=not link.armature)
        R, r, _ = state.joint(i)
        inertia[link.parent] = blocks_sum(inertia[link.parent], blocks_to_parent(R, r, I_a))
        p[link.parent] = plus(p[link.parent], force_to_parent(R, r, p_a))

    second, joint_rates = _outward(model, state, c, terms, with_inertia)
    return accelerations_of_coordinates(model, state, second, joint_rates)


def _outward(
    model: Model,
    state: State,
    c: Sequence[Spatial],
    terms: Sequence[LinkTerms | None],
    with_inertia: Sequence[Sequence[int]],
) -> tuple[dict[int, Scalar], dict[int, Scalar]]:
    """Return y'' of the 1-dof links and, by speed, u' of ball and free joints."""
    A: list[Spatial] = []
    second: dict[int, Scalar] = {}
    joint_rates: dict[int, Scalar] = {}
    ground = (ZERO, negate(state.vector(model.gravity)))
    for i, link in enumerate(model.links):
        R, r, _ = state.joint(i)
        a = plus(motion_to_child(R, r, ground if link.parent == GROUND else A[link.parent]), c[i])
        if link.one_dof:
            second |= {} if link.driven else {i: 0}
        elif link.u >= 0:
            joint_rates |= dict.fromkeys(range(link.u, link.u + link.n_speeds), 0)
        if (link_terms := terms[i]) is not None:
            rates, a = joint_acceleration(a, link_terms)
            for k, rate in zip(with_inertia[i], rates, strict=True):
                if link.one_dof:
                    second[i] = rate
                else:
                    joint_rates[link.u + k] = rate
        A.append(a)
    return second, joint_rates


def pivot(
    motion: Sequence[Spatial], tau: Sequence[Scalar], I_A: Blocks, p_A: Spatial
) -> tuple[list[Spatial], list[Scalar]]:
    """Return U = I^A S and m = τ - Sᵀ p^A of a link's own motions."""
    U = [blocks_times(I_A, S) for S in motion]
    return U, [t - power(S, p_A) for t, S in zip(tau, motion, strict=True)]


def add_armature(
    state: State, i: int, c: Spatial, U: Sequence[Spatial], m: Sequence[Scalar], D: list[list[Scalar]]
) -> tuple[list[Spatial], list[Scalar]]:
    """Return U and m with armature and rotors, of which the spin s couples y'' with the turning of the parent.

    D gets the armature on its diagonal:  (D + A) y'' = m + s·c - (U + s)·A',  where c is not of the parent.
    """
    for k, x in enumerate(state.armature(i)):
        D[k][k] = D[k][k] + x
    if not state.model.links[i].one_dof:
        armature, turned = state.armature(i), turned_slides(state, i)
        return list(U), [force - a * x for force, a, x in zip(m, armature, turned, strict=True)]
    spin = state.spin(i)
    if spin is None or state.model.links[i].parent == GROUND:
        return list(U), list(m)
    return [plus(U[0], (spin[1], ZERO))], [m[0] + dot(spin[1], c[0])]


def _spin_moment(state: State, i: int, V: Spatial) -> Spatial:
    """Return the moment of the rotors that link ``i`` turns on its parent, without the part with y'', in its axes."""
    link, spin = state.model.links[i], state.spin(i)
    if spin is None:
        return ZERO6
    turning = state.joint(i)[2][0]
    moment = cross(subtract(V[0], turning), scale(state.rate(link), spin[1]))
    if link.driven:
        moment = add(moment, scale(state.second_rate(link, None), spin[1]))
    return (moment, ZERO)


def apparent_inertia(
    I_A: Blocks,
    p_A: Spatial,
    c: Spatial,
    tau: Sequence[Scalar],
    terms: LinkTerms | None,
    *,
    alone: bool = True,
) -> tuple[Blocks, Spatial]:
    """Return I^a and p^a, the link as its parent feels it, in its own axes; ``terms`` None: it does not move in it.

    ``alone`` is true if forces along its motions meet the inertia of links alone; then I^a S = 0 and Sᵀ p^a = τ.
    """
    if terms is None:
        return I_A, plus(p_A, blocks_times(I_A, c))
    motion, U, m, D = terms
    I_a = I_A
    for W, x in zip(U, columns_solved(D, U), strict=True):
        I_a = blocks_less_outer(I_a, W, x)
    for S in motion if alone else ():
        I_a = _cleared(I_a, S)
    p_a = plus(p_A, blocks_times(I_a, c))
    for W, x in zip(U, D.solve(m), strict=True):
        p_a = plus(p_a, times(x, W))
    for S, force in zip(motion, tau, strict=True) if alone else ():
        p_a = _replaced(p_a, S, force)
    return I_a, p_a


def joint_acceleration(a: Spatial, terms: LinkTerms) -> tuple[list[Scalar], Spatial]:
    """Return y'' of a link's own motions and the link's acceleration, from A' = a."""
    motion, U, m, D = terms
    rates = D.solve([x - power(a, W) for x, W in zip(m, U, strict=True)])
    for S, rate in zip(motion, rates, strict=True):
        a = plus(a, times(rate, S))
    return rates, a


def _with_inertia(
    model: Model, i: int, motion: list[Spatial], D: list[list[Scalar]], tau: list[Scalar], wrench: Spatial
) -> list[int]:
    """Return the indices of a link's motions that meet inertia; ``tau`` and ``wrench`` are the loads along and on it.

    A motion that meets none, whatever the state, cannot be solved for. The turn of a particle in a joint that also
    displaces it has the equation 0 = 0 if no torque drives it: it keeps its rate.
    """
    result, link = [], model.links[i]
    for k, (S, force) in enumerate(zip(motion, tau, strict=True)):
        if not is_zero(D[k][k]):
            result.append(k)
        elif not (S[1] == ZERO and is_zero(force + power(S, wrench)) and _is_displaced_tip(model, i)):
            raise ModelError(
                f"Joint '{link.joint}' has a motion that meets no inertia, so the forces give no acceleration. Give "
                f"the bodies that it carries mass or moment of inertia (a particle has no moment of inertia), weld the "
                f"joint, or leave out the motion."
            )
    return result


def _is_displaced_tip(model: Model, i: int) -> bool:
    """Return True if a link carries no other and its joint displaces it as well."""
    links = model.joints[model.links[i].joint].links
    along = any((model.links[j].slides_only or model.links[j].flies) for j in links)
    return along and all(outer.parent != i for outer in model.links)


def free_motions(link: Link, subspace: Spatial | None) -> list[Spatial]:
    """Return the motions of a link that forces determine, in its axes; ``subspace`` belongs to a 1-dof joint."""
    if link.one_dof:
        return [] if subspace is None else [subspace]
    if link.u < 0:
        return []
    turns: list[Spatial] = [(IDENTITY[k], ZERO) for k in range(3)]
    return turns if link.pivots else turns + [(ZERO, IDENTITY[k]) for k in range(3)]


def _unit(S: Spatial) -> tuple[int, int] | None:
    """Return (0 angular or 1 linear, axis) of a motion along one coordinate axis, None for any other."""
    live = [
        (part, k)
        for part in (0, 1)
        for k in range(3)
        if not (isinstance(S[part][k], int) and S[part][k] == 0)
    ]
    part, k = live[0]
    return (part, k) if len(live) == 1 and isinstance(S[part][k], int) and S[part][k] == 1 else None


def _cleared(A: Blocks, S: Spatial) -> Blocks:
    """Return I^a with I^a S = 0 exactly: row and column of a joint's own motion along a coordinate axis vanish."""
    place = _unit(S)
    if place is None:
        return A
    part, k = place
    J, H, M = A
    if part == 0:
        return (_struck(J, k, k), _struck(H, k, None), M)
    return (J, _struck(H, None, k), _struck(M, k, k))


def _struck(A: Matrix, row: int | None, column: int | None) -> Matrix:
    """Return a matrix with one row and one column set to zero."""
    return tuple(  # type: ignore[return-value]
        tuple(0 if i == row or j == column else A[i][j] for j in range(3)) for i in range(3)
    )


def _replaced(p: Spatial, S: Spatial, force: Scalar) -> Spatial:
    """Return p^a with Sᵀ p^a = τ exactly, which gives its component along a coordinate axis."""
    place = _unit(S)
    if place is None:
        return p
    part, k = place
    new = tuple(force if i == k else p[part][i] for i in range(3))
    return (new, p[1]) if part == 0 else (p[0], new)


def columns_solved(D: Factorization, U: list[Spatial]) -> list[Spatial]:
    """Return the rows of D⁻¹ Uᵀ as spatial vectors."""
    if len(U) == 1:
        return [times(divide(1, D.D[0]), U[0])]
    flat = [(*n, *f) for n, f in U]
    columns = [D.solve([row[k] for row in flat]) for k in range(6)]
    return [
        ((columns[0][i], columns[1][i], columns[2][i]), (columns[3][i], columns[4][i], columns[5][i]))
        for i in range(len(U))
    ]


def _by_mass_matrix(model: Model, state: State, forces: Sequence[Scalar] | None) -> tuple[Scalar, ...]:
    """Solve M u' = Q - h by factorization, for displacements that share coordinates, and for added mass."""
    right = [-x for x in bias(model, state)]
    if forces is not None:
        right = [a + b for a, b in zip(right, forces, strict=True)]
    try:
        return tuple(solve_symmetric(mass_matrix(model, state), right))
    except ZeroDivisionError:
        shared = sorted(
            {model.speed_names[j] for link in model.links for j, _ in link.partials if len(link.partials) > 1}
        )
        raise ModelError(
            f"The mass matrix is singular in every configuration: {', '.join(shared)} do not move the masses "
            f"independently of each other. Leave out a coordinate, or let it move a body of its own."
        ) from None
