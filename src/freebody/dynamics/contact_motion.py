"""Motion with contacts: forces in given contact modes, and the problem that decides the modes.

While contacts keep their modes, they are conditions of the machine (:func:`freebody.model.contact_modes.in_modes`):

    M u' = f + Gᵀ λ + Σ W_Nᵀ N + W_Tᵀ T

    closed   n·(a_P - a_Q) = 0   for N;      stick   γ' = 0   for T;      slip   T = -μ N γ/|γ|.

To decide the modes, the forces of all contacts are unknowns. With the machine's own conditions enforced,

    d(ġ, γ)/dt = A λ + c,     u' = free + Σ λ_i r_i,       A = W M⁻¹ Wᵀ

and impulses Λ change the same rates by A Λ.

Source: Glocker, Set-Valued Force Laws (2001), chapters 5 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..model.contact import Contact
from ..model.contact_modes import Sliding, Touching, in_modes
from ..model.model import Model
from ..scalar.algebra import ZERO, Scalar, add, negate, scale
from .composite import mass_matrix
from .conditions.constrained import constrained_loading, with_wrenches
from .conditions.constraint_forces import friction_along_tangents
from .conditions.constraints import rows
from .conditions.contact import (
    contact_rows,
    given_normal_force,
    rows_of,
    touch,
    unit_forces,
)
from .conditions.linearized import linearized
from .kinematics import Spot
from .linear import Factorization, applied, combined, products, scalar_product
from .loads.actions import scaled
from .loads.loading import Loading, act
from .motion import Motion
from .newton_euler import bias
from .state import State

__all__ = [
    "ContactProblem",
    "contact_accelerations",
    "contact_forces",
    "contact_problem",
    "forced_motion",
    "friction_power",
    "in_modes",
]


@dataclass(frozen=True)
class ContactProblem:
    """Accelerations at all contacts as functions of the forces there, in the order of ``contact_layout``.

    Attributes
    ----------
    A : tuple of rows
        Symmetric; positive semidefinite [1/kg].
    c : tuple
        Accelerations at the contacts without contact forces [m/s²].
    free : tuple, length n_u
        Accelerations u' without contact forces.
    responses : tuple of tuples
        u' per unit of each contact force.
    """

    A: tuple[tuple[Scalar, ...], ...]
    c: tuple[Scalar, ...]
    free: tuple[Scalar, ...]
    responses: tuple[tuple[Scalar, ...], ...]


def contact_problem(model: Model, state: State, active: Sequence[int] = ()) -> ContactProblem:
    """Return the problem that decides the modes: d(rate)/dt = A λ + c for all contacts of the machine.

    Parameters
    ----------
    active : sequence of int
        Independent conditions of the machine's own constraints
        (:func:`freebody.dynamics.conditions.constrained.independent_rows`).
    """
    M = Factorization(mass_matrix(model, state))
    contacts = contact_rows(model, state)
    enforce = _enforcing(model, state, M, active)
    free = enforce(M.solve([-x for x in bias(model, state)]), True)
    responses = tuple(enforce(M.solve(row), False) for row in contacts.matrix)
    A = tuple(map(tuple, products(contacts.matrix, responses)))
    c = tuple(along + b for along, b in zip(applied(contacts.matrix, free), contacts.bias, strict=True))
    return ContactProblem(A, c, free, responses)


def contact_accelerations(
    model: Model, state: State, forces: Sequence[Scalar], active: Sequence[int] = ()
) -> tuple[Scalar, ...]:
    """Return A λ + c of :func:`contact_problem` for contact forces λ, by one solution instead of one per contact.

    Parameters
    ----------
    forces : sequence
        Contact forces in the order of ``contact_layout`` [N].
    """
    M = Factorization(mass_matrix(model, state))
    contacts = contact_rows(model, state)
    forced = combined([-x for x in bias(model, state)], forces, contacts.matrix)
    udot = _enforcing(model, state, M, active)(M.solve(forced), True)
    return tuple(along + b for along, b in zip(applied(contacts.matrix, udot), contacts.bias, strict=True))


def _enforcing(
    model: Model, state: State, M: Factorization, active: Sequence[int]
) -> Callable[[list[Scalar], bool], tuple[Any, ...]]:
    """Return a function that enforces the machine's own conditions on accelerations, or on speeds per unit impulse."""
    if not active:
        return lambda step, accelerations: tuple(step)
    conditions = linearized(model, state)
    G = [conditions.matrix[i] for i in active]
    X = [M.solve(row) for row in G]
    factors = Factorization(products(G, X))

    def enforce(step: list[Scalar], accelerations: bool) -> tuple[Scalar, ...]:
        """Return the step with the constraint forces that make G u' = -γ, or G u = 0 for speeds."""
        gamma = [conditions.bias[i] if accelerations else 0 for i in active]
        lam = factors.solve([-(g + along) for g, along in zip(gamma, applied(G, step), strict=True)])
        return tuple(combined(step, lam, X))

    return enforce


def contact_forces(
    model: Model, state: State, multipliers: Sequence[Scalar]
) -> dict[str, tuple[Scalar, ...]]:
    """Return (N, T) or (N, T1, T2) on the feature of every contact of a machine in modes; zeros if it is open [N]."""
    result: dict[str, tuple[Scalar, ...]] = {c.name: (0,) * (1 + c.tangents) for c in model.contacts}
    by_contact: dict[str, list[Scalar]] = {}
    for contact in model.contacts:
        if contact.held:
            result[contact.name] = _given_forces(model, state, contact)
    for row, value in zip(rows(model), multipliers, strict=True):
        if isinstance(model.constraints[row.owner], Touching):
            by_contact.setdefault(row.owner, []).append(value)
    for name, values in by_contact.items():
        touching = model.constraints[name]
        if touching.slips:
            (N,) = values
            pressure = N + state(touching.contact.adhesion)
            values = [N, *friction_along_tangents(model, state, touching, pressure)]
        result[name] = (result[name][0], *values) if touching.contact.held else tuple(values)
    return result


def _given_forces(model: Model, state: State, contact: Contact) -> tuple[Scalar, ...]:
    """Return N that the state gives, and T of a slip under it."""
    if contact.compliant and contact.normal_name not in model.loads:
        return (0,) * (1 + contact.tangents)
    N = given_normal_force(model, state, contact, touching=True)
    load = model.loads.get(contact.friction_name) if contact.tangents else None
    if not isinstance(load, Sliding):
        return (N, *(0,) * contact.tangents)
    touching = Touching(contact, load.direction)
    return (N, *friction_along_tangents(model, state, touching, N))


def friction_power(model: Model, state: State, forces: Mapping[str, Sequence[Scalar]]) -> Scalar:
    """Return Σ T·γ of all contacts, -μ N |γ| for each that slips [W].

    Parameters
    ----------
    forces : mapping
        From :func:`contact_forces`.
    """
    total: Scalar = 0
    for contact in model.contacts:
        slip = rows_of(model, state, (contact,)).rate[1:]
        total = total + scalar_product(forces[contact.name][1:], slip)
    return total


def forced_motion(
    model: Model,
    state: State,
    udot: Sequence[Any],
    forces: Sequence[Any],
    multipliers: Sequence[Any],
    blows: Any = (),
) -> Motion:
    """Return a motion with known accelerations, forces of all contacts and multipliers: loads, constraints, blows."""
    acting, laws = [*blows], Loading()
    at = 0
    for contact in model.contacts:
        if contact.law is not None:
            for row in unit_forces(model, state, contact):
                act(model, state, laws, contact.law, [scaled(action, forces[at]) for action in row])
                at += 1
            continue
        it = touch(model, state, contact)
        total: Any = ZERO
        for k, e in enumerate((it.normal, *it.tangents)):
            total = add(total, scale(forces[at + k], e))
        at += 1 + len(it.tangents)
        acting += [
            (Spot(contact.feature.body, it.on_feature), total, ZERO),
            (Spot(contact.surface.body, it.on_surface), negate(total), ZERO),
        ]
    loads = with_wrenches(model, state, constrained_loading(model, state, multipliers, udot), acting)
    return Motion(tuple(udot), tuple(multipliers), loads.plus(laws))
