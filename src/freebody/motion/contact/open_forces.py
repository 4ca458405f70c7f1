"""Phases of a log, and the contact forces that their motion does not determine: combinations without effect on it."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ..phase import laws
from ..phase.phase import KINDS, Phase, direction_of
from ..phase.scene import Snapshot
from ..trajectory.phases import Segment
from .state import ContactRun

NO_EFFECT = 1e-9
"""Motion by a force, relative to the greatest by another one, that is round-off."""


class LoggedSegment(Segment):
    """A phase of the log, whose indeterminate forces are found when they are first asked for.

    ``dead``    which contacts the others hold in place; None if all forces are determinate
    """

    work: ContactRun
    dead: list[bool] | None

    @cached_property
    def loose(self) -> Any:
        """True for each contact force that the motion does not determine."""
        work, path = self.work, self.path
        if self.dead is None:
            return np.zeros(work.scene.rows, dtype=bool)
        seen = work.look(path.start, path.states[0], self.values(work.parameters))
        return loose_forces(work, self.kernels, self.dead, seen)

    def __reduce__(self) -> Any:
        return Segment, (self.path, self.kernels, self.impulses, self.modes, self.loose, self.parameters)


def loose_forces(work: ContactRun, phase: Phase, dead: list[bool], seen: Snapshot) -> Any:
    """Return the mask of indeterminate contact forces: forces in combinations without effect on the motion.

    ``dead`` says which contacts the others hold in place: their forces have none.
    """
    rows: list[list[int]] = []
    columns, signs, normal = [], {"slip+": 1.0, "slip-": -1.0}, -1
    for k, mode in enumerate(phase.modes):
        if mode == KINDS[laws.OPEN] and not dead[k]:
            continue
        at, n = work.scene.first[k], work.scene.tangents[k]
        held = work.scene.held[k]
        if work.scene.presser[k] < 0:  # resistance to rolling and spinning follows its contact
            normal = -1 if held else len(rows)
        if not held:  # else the normal force is given
            rows.append([at])
            columns.append(seen.responses[at])
        if mode == KINDS[laws.STICK] or (dead[k] and n == 1):
            for i in range(at + 1, at + 1 + n):
                rows.append([i])
                columns.append(seen.responses[i])
        elif normal >= 0 and mode != KINDS[laws.OPEN] and n > 0 and not work.smooth(seen, k):
            v = np.array([signs[mode]] if mode in signs else direction_of(mode) or work.slip(seen, k))
            speed = float(np.linalg.norm(v))
            if speed > 0:
                rows[normal] = [*rows[normal], *range(at + 1, at + 1 + n)]
                columns[normal] = (
                    columns[normal] - seen.friction[k] * (v / speed) @ seen.responses[at + 1 : at + 1 + n]
                )
    mask = np.zeros(work.scene.rows, dtype=bool)
    if not rows:
        return mask
    F = np.array(columns)
    lengths = np.linalg.norm(F, axis=1, keepdims=True)
    F = np.where(lengths > NO_EFFECT * lengths.max(), F / np.where(lengths > 0, lengths, 1), 0.0)
    left, sizes, _ = np.linalg.svd(F)
    rank = int((sizes > NO_EFFECT * sizes.max(initial=0)).sum())
    for i, group in enumerate(rows):
        if np.abs(left[i, rank:]).max(initial=0) > 1e-7:
            mask[group] = True
    return mask
