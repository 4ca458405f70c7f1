"""An impact of a run: what its log holds, and what the derivatives of its stages add."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...dynamics.composite import mass_matrix
from ...dynamics.conditions.contact import contact_rows
from ...dynamics.conditions.linearized import linearized
from ...dynamics.conditions.unilateral import MotionWarning, limits, passed_by_impulse
from ...dynamics.state import state_at
from ..ode.dense_output import Array
from .state import ContactRun, Entry


class Impact(NamedTuple):
    """An impact: states, contacts, impulses of all rows of their kernels, and the part of e that acts.

    ``still``       speed that counts as none;  ``speeds``, ``speeds_after``: normal speeds of the contacts
    ``open``        True if other distributions of the impulses would change the motion

    Of a stage, for its derivatives (`impact_slopes`):

    ``taken``       it takes the rest of a series of bounces away: v_N⁺ = 0 of all its contacts, with impulses that pull
    ``compressed``  it is the expansion of Poisson's law: impulses of the compression, and their derivatives
    ``origin``      its laws are those of another state, that before the compression, with its derivatives
    ``blown``       impulses of a blow at the bearings of joints, whose friction it is, and their derivatives
    """

    t: float
    before: Array
    after: Array
    chosen: Sequence[int]
    impulses: Array
    part: float
    still: float
    speeds: Sequence[float] = ()
    speeds_after: Sequence[float] = ()
    open: bool = False
    taken: bool = False
    compressed: Any = None
    origin: Any = None
    blown: Any = None


def impact_of(work: ContactRun, entry: Entry) -> Impact:
    """Return an impact of the log; ``impulses`` are those of all rows, in units of `candidates.stretches`."""
    n_y, scene, numbers, chosen = work.it.n_y, work.scene, entry.numbers, entry.marks[2:]
    t, part, _, still = numbers[:4].tolist()
    before, after = numbers[4 : 4 + n_y], numbers[4 + n_y : 4 + 2 * n_y]
    at, speeds, speeds_after, impulses = 4 + 2 * n_y, [], [], np.zeros(scene.rows)
    for k in chosen:
        size = 1 + scene.tangents[k]
        speeds.append(float(numbers[at]))
        speeds_after.append(float(numbers[at + 1]))
        impulses[scene.first[k] : scene.first[k] + size] = numbers[at + 2 : at + 2 + size]
        at += 2 + size
    is_open = bool(entry.marks[0])
    return Impact(t, before, after, chosen, impulses, part, still, speeds, speeds_after, is_open)


def passed(work: ContactRun, hit: Impact) -> tuple[MotionWarning, ...]:
    """Return warnings of one-sided constraints whose limits an impact exceeds.

    The impulses Λ of the constraints follow from Gᵀ Λ = M Δu - Wᵀ P.
    """
    if not limits(work.model):
        return ()
    mine, y, impulses = slice(work.n, work.n + work.n_u), hit.before, hit.impulses * work.ratios
    state = state_at(work.model, y, hit.t, work.values)
    M: Any = np.array(mass_matrix(work.model, state))
    W: Any = np.array(contact_rows(work.model, state).matrix)
    active, conditions = list(work.scene.kernels.active), linearized(work.model, state).matrix
    G = np.array([conditions[i] for i in active], dtype=float)
    multipliers = np.zeros(len(conditions))
    left = M @ (hit.after - y)[mine] - impulses @ W
    multipliers[active] = np.linalg.lstsq(G.T, left, rcond=None)[0]
    largest = max(np.abs(multipliers).max(), np.abs(impulses).max())
    return passed_by_impulse(
        work.model, multipliers.tolist(), lambda mu: float(state(mu)), float(largest), hit.t
    )
