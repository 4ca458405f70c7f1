"""Motion with contacts: forces of closed contacts in given modes, and the problem that decides the modes.

While contacts keep their modes they are conditions of the machine (:func:`freebody.model.contact.in_modes`):

    M u' = f + Gᵀ λ + Σ W_Nᵀ N + W_Tᵀ T

    closed   n·(a_P - a_Q) = 0   for N;      stick   γ' = 0   for T;      slip   T = -μ N γ/|γ|.

To decide the modes, all forces of all contacts are left open. With the machine's own conditions kept,

    d(ġ, γ)/dt = A λ + c,     u' = free + Σ λ_i r_i,       A = W M⁻¹ Wᵀ

and impulses Λ change the same rates by A Λ.

Source: Glocker, Set-Valued Force Laws (2001), chapters 5 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..model.contact import Contact, Touching, in_modes
from ..model.model import Model
from .composite import mass_matrix
from .constraints import linearized, rows, slip_direction
from .contact import contact_rows, rows_of
from .linear import Factorization, applied, combined, products
from .newton_euler import bias
from .state import State

__all__ = [
    "ContactProblem",
    "contact_accelerations",
    "contact_forces",
    "contact_problem",
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
        Without contact forces [m/s²].
    free : tuple, length n_u
        Accelerations u' without contact forces.
    responses : tuple of tuples
        u' per unit of each contact force.
    """

    A: tuple[tuple[Any, ...], ...]
    c: tuple[Any, ...]
    free: tuple[Any, ...]
    responses: tuple[tuple[Any, ...], ...]


def contact_problem(model: Model, state: State, active: Sequence[int] = ()) -> ContactProblem:
    """What decides the modes: d(rate)/dt = A λ + c for all contacts of the machine.

    Parameters
    ----------
    active : sequence of int
        Independent conditions of the machine's own constraints
        (:func:`freebody.dynamics.constrained.independent_rows`).
    """
    M = Factorization(mass_matrix(model, state))
    contacts = contact_rows(model, state)
    keeping = _keeping(model, state, M, active)
    free = keeping(M.solve([-x for x in bias(model, state)]), True)
    responses = tuple(keeping(M.solve(row), False) for row in contacts.matrix)
    A = tuple(map(tuple, products(contacts.matrix, responses)))
    c = tuple(along + b for along, b in zip(applied(contacts.matrix, free), contacts.bias, strict=True))
    return ContactProblem(A, c, free, responses)


def contact_accelerations(
    model: Model, state: State, forces: Sequence[Any], active: Sequence[int] = ()
) -> tuple[Any, ...]:
    """A λ + c of given contact forces λ, as in :func:`contact_problem`, by one solution instead of one per contact.

    Parameters
    ----------
    forces : sequence
        In the order of ``contact_layout`` [N].
    """
    M = Factorization(mass_matrix(model, state))
    contacts = contact_rows(model, state)
    pushed = combined([-x for x in bias(model, state)], forces, contacts.matrix)
    udot = _keeping(model, state, M, active)(M.solve(pushed), True)
    return tuple(along + b for along, b in zip(applied(contacts.matrix, udot), contacts.bias, strict=True))


def _keeping(
    model: Model, state: State, M: Factorization, active: Sequence[int]
) -> Callable[[list[Any], bool], tuple[Any, ...]]:
    """A function that adds to accelerations, or to speeds per unit impulse, what the machine's own conditions do."""
    if not active:
        return lambda step, accelerations: tuple(step)
    held = linearized(model, state)
    G = [held.matrix[i] for i in active]
    X = [M.solve(row) for row in G]
    own = Factorization(products(G, X))

    def keeping(step: list[Any], accelerations: bool) -> tuple[Any, ...]:
        """The step with the constraint forces that make G u' = -γ, of speeds G u = 0."""
        gamma = [held.bias[i] if accelerations else 0 for i in active]
        lam = own.solve([-(g + along) for g, along in zip(gamma, applied(G, step), strict=True)])
        return tuple(combined(step, lam, X))

    return keeping


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    total: Any = 0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def contact_forces(model: Model, state: State, multipliers: Sequence[Any]) -> dict[str, tuple[Any, ...]]:
    """(N, T) or (N, T1, T2) of every contact of a machine in modes, on its feature; zeros where it is open [N]."""
    result: dict[str, tuple[Any, ...]] = {c.name: (0,) * (1 + c.tangents) for c in model.contacts}
    found: dict[str, list[Any]] = {}
    for row, value in zip(rows(model), multipliers, strict=True):
        if isinstance(model.constraints[row.owner], Touching):
            found.setdefault(row.owner, []).append(value)
    for name, values in found.items():
        touching = model.constraints[name]
        if touching.slips:
            (N,) = values
            mu = state(touching.contact.friction)
            values = [N, *(-(mu * N * d) for d in slip_direction(model, state, touching))]
        result[name] = tuple(values)
    return result


def friction_power(model: Model, state: State, forces: Mapping[str, Sequence[Any]]) -> Any:
    """Σ T·γ of all contacts, -μ N |γ| for each that slips [W].

    Parameters
    ----------
    forces : mapping
        As from :func:`contact_forces`.
    """
    total: Any = 0
    for contact in model.contacts:
        slip = rows_of(model, state, (contact,)).rate[1:]
        total = total + _dot(forces[contact.name][1:], slip)
    return total


def closed(model: Model) -> tuple[Contact, ...]:
    """The contacts of a machine in modes that are closed."""
    return tuple(c.contact for c in model.constraints.values() if isinstance(c, Touching))
