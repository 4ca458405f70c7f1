"""Coriolis matrix C and forces of gravity g: with the forces τ of all else,  M u' + C u + g = τ.

The motion V = J u of a link meets an inertia I that is constant in the axes of the link; its momentum is P = I V. There

    C = Σ Jᵀ (I J̇ + B),        B W = W ×* P

C u is the part of the bias that is quadratic in u. B is skew, since W'·(W ×* P) = -W·(W' ×* P), and so is
Ṁ - 2 C = Σ J̇ᵀ I J - Jᵀ I J̇ - 2 Jᵀ B J: at constant speeds, the power of C u is the change of the kinetic energy.
Rotors that a joint turns in its parent, with the spin s y', belong to the momentum of the parent.

Source: S. Echeandia, P. Wensing, Numerical methods to compute the Coriolis matrix and Christoffel symbols for
rigid-body systems (2021).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..model.model import GROUND, Model
from ..scalar.algebra import Scalar, add, apply_transpose, dot, scale
from ..scalar.series import derivative_at_start, value_at_start
from ..space.spatial import Spatial, force_cross, minus, momentum_of, plus, power
from .armature import rates, turned_slides
from .kinematics import link_postures, replaced, state_along, velocities
from .state import State


def coriolis_matrix(model: Model, state: State) -> tuple[tuple[Scalar, ...], ...]:
    """Return C(q, u) of a machine; what its drives move by themselves adds nothing to it.

    Ṁ - 2 C is not skew where the slides of a free joint have unequal armature: then the armature does work as it turns.
    """
    n, links = model.n_u, range(len(model.links))
    still = _motions(replaced(state, state.field, state.t, state.q, [0] * n))
    momenta = _momenta(state, *_less(_motions(state), still))
    along = state_along(model, state, state.u, 0, 1)
    still = _motions(replaced(along, along.field, along.t, along.q, [0] * n))
    columns = []
    for k in range(n):
        unit = [int(j == k) for j in range(n)]
        V, y = _less(_motions(replaced(along, along.field, along.t, along.q, unit)), still)
        own, own_rates = _each(y, value_at_start), _each(y, derivative_at_start)
        for i, link in enumerate(model.links):
            if link.armature and not link.one_dof:
                turned = turned_slides(state, i, own[i])
                own_rates[i] = tuple(a + b for a, b in zip(own_rates[i], turned, strict=True))
        columns.append((_each(V, value_at_start), own, _each(V, derivative_at_start), own_rates))
    rows: list[list[Scalar]] = [[0] * n for _ in range(n)]
    for k, (V, _, V_rate, y_rate) in enumerate(columns):
        forces = _momenta(state, V_rate, y_rate)
        forces = [plus(F, force_cross(W, P)) for F, W, P in zip(forces, V, momenta, strict=True)]
        along_own = [_along(state, i, V_rate, y_rate[i]) for i in links]
        for j, (W, y, _, _) in enumerate(columns):
            total: Scalar = 0
            for i in links:
                total = (
                    total
                    + power(W[i], forces[i])
                    + sum((a * b for a, b in zip(y[i], along_own[i], strict=True)), 0)
                )
            rows[j][k] = total
    return tuple(map(tuple, rows))


def gravity_forces(model: Model, state: State) -> tuple[Scalar, ...]:
    """Return g(q): minus the power of the weights per unit of each speed."""
    n = model.n_u
    pull = [apply_transpose(one.rotation, state.vector(model.gravity)) for one in link_postures(model, state)]
    still = _motions(replaced(state, state.field, state.t, state.q, [0] * n))
    result: list[Scalar] = []
    for k in range(n):
        unit = [int(j == k) for j in range(n)]
        V, _ = _less(_motions(replaced(state, state.field, state.t, state.q, unit)), still)
        linear = (momentum_of(state.inertia(i), V_i)[1] for i, V_i in enumerate(V))
        result.append(sum((-dot(g, p) for g, p in zip(pull, linear, strict=True)), 0))
    return tuple(result)


Motions = tuple[list[Spatial], list[tuple[Scalar, ...]]]
"""Motions of the links, in their axes, and the rates of those displacements that have armature."""


def _motions(state: State) -> Motions:
    """Return the motions of a machine."""
    model = state.model
    own = [tuple(rates(state, i)) if link.armature else () for i, link in enumerate(model.links)]
    return velocities(model, state), own


def _less(a: Motions, b: Motions) -> Motions:
    """Return the difference of two motions: what the speeds move, without the drives."""
    return (
        [minus(x, y) for x, y in zip(a[0], b[0], strict=True)],
        [tuple(x - y for x, y in zip(p, q, strict=True)) for p, q in zip(a[1], b[1], strict=True)],
    )


def _momenta(state: State, V: Sequence[Spatial], own: Sequence[tuple[Scalar, ...]]) -> list[Spatial]:
    """Return the momenta of the links, with those of the rotors that turn in them."""
    result = [momentum_of(state.inertia(i), V_i) for i, V_i in enumerate(V)]
    for i, link in enumerate(state.model.links):
        spin = state.spin(i)
        if spin is not None and link.parent != GROUND:
            angular, linear = result[link.parent]
            result[link.parent] = (add(angular, scale(own[i][0], spin[0])), linear)
    return result


def _along(state: State, i: int, V: Sequence[Spatial], own: tuple[Scalar, ...]) -> list[Scalar]:
    """Return the forces along a link's own displacements that change its armature's and rotors' momenta."""
    armature, spin, parent = state.armature(i), state.spin(i), state.model.links[i].parent
    forces = [a * y for a, y in zip(armature, own, strict=True)]
    if spin is not None and parent != GROUND:
        forces[0] = forces[0] + dot(spin[0], V[parent][0])
    return forces


def _each(nested: Any, function: Any) -> Any:
    """Return nested lists and tuples with a function applied to each scalar."""
    if isinstance(nested, list | tuple):
        return type(nested)(_each(x, function) for x in nested)
    return function(nested)
