"""What the pairs of families did in a motion in time steps, from the log of the loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError
from ...model import Model
from ...model.contact import friction_margin
from ...model.family import Family
from ...model.resistance import SPINNING
from ..contact.course import ContactMotion
from ..families.family_record import ENTRY, RESISTED
from ..families.memory import link_poses
from ..families.pair_quantities import pair_quantities
from ..ode.dense_output import Array
from ..start.initial import number
from ..trajectory.quantities import ByName
from .stepped_kernels import bodies_in_families

MODES = ("open", "stick", "slip", "slip+", "slip-")
"""Names of the contact modes, by the numbers that the loop gives them (`moreau.march`)."""


class PairLog(Sequence[Array]):
    """What the pairs of families do in every step: ``log[k]`` has the entries of step k (`family_record.ENTRY`).

    ``entries`` are those of all steps, and those of step k end before ``ends[k + 1]``.
    """

    def __init__(self, entries: Array, ends: NDArray[np.int64]) -> None:
        self.entries, self.ends = entries, ends

    @staticmethod
    def made(steps: int, width: int) -> PairLog:
        """Return a log with room for so many steps, with entries of a width."""
        return PairLog(np.empty((64, width)), np.zeros(steps + 1, dtype=np.int64))

    def append(self, step: int, entries: Array, ends: NDArray[np.int64]) -> None:
        """Write the entries of the steps from ``step`` on, which end before ``ends`` among ``entries``."""
        if not len(ends):
            return
        first, last = int(self.ends[step]), int(self.ends[step] + ends[-1])
        if last > len(self.entries):
            known, self.entries = self.entries[:first], np.empty((2 * last, entries.shape[1]))
            self.entries[:first] = known
        self.entries[first:last] = entries[: last - first]
        self.ends[step + 1 : step + 1 + len(ends)] = first + ends

    def between(self, first: int, last: int) -> PairLog:
        """Return the log of the steps from ``first`` to before ``last``."""
        ends = self.ends[first : last + 1]
        return PairLog(self.entries[ends[0] : ends[-1]], ends - ends[0])

    @property
    def steps(self) -> NDArray[np.int64]:
        """Step of each entry."""
        return np.repeat(np.arange(len(self)), np.diff(self.ends))

    def __len__(self) -> int:
        return len(self.ends) - 1

    def __getitem__(self, step: Any) -> Any:
        k = range(len(self))[step]
        return self.entries[self.ends[k] : self.ends[k + 1]]


def width_of(model: Model) -> int:
    """Return the length of the entries of the log of a machine."""
    return ENTRY + RESISTED * any(sum(family.rows[1:]) > 0 for family in model.families)


def pair_motion(course: Any, motion: Any, family: Family, name: str) -> ContactMotion:
    """Return gap, mean forces, slip and mode of two members of a family, or of what resists their rolling."""
    model, contact = course.kernels.model, cast(Any, family.element(name))
    first, second = family.ordered(*cast(Any, family.pair(contact.presser or name)))
    program, function = link_poses(course.kernels)
    poses = course.observed(motion, program, function, motion.t, motion.states)
    gap, approach, slip, turning = pair_quantities(
        course.kernels, course.values, family, (first, second), motion.t, poses
    )
    start, n = sum(len(f.members) for f in model.families[: model.families.index(family)]), contact.tangents
    log, columns, mode_at = course.impulses.pairs, [0, *range(1, 1 + n)], 3
    if contact.presser:
        spins = contact.law.about == SPINNING
        columns = [0, *range(ENTRY + 2 * spins, ENTRY + 2 * spins + n)]
        slip, mode_at = turning[:, 2:] if spins else turning, ENTRY + 6 + spins
    rows = np.zeros((len(log), 2 + n))
    own = (log.entries[:, 10] == start + first) & (log.entries[:, 11] == start + second)
    np.add.at(rows[:, :-1], log.steps[own], log.entries[own][:, columns])
    np.maximum.at(rows[:, -1], log.steps[own], log.entries[own, mode_at])
    forces, slip = course._mean(rows[:, :-1], motion.t), slip[:, :n]
    modes = np.append(rows[:, -1], 0).astype(np.int64)  # the last one is that of a motion without a step
    mode = np.array(MODES)[modes[course._step_of(motion.t)]]
    law = contact.name if contact.presser else family.name
    mu = course.static_friction(law, contact, motion.t, motion.states)
    pressing = cast(Any, family.element(contact.presser or name))
    pressure = forces[:, 0] + number(model, course.values, pressing.adhesion, "an adhesion")
    if contact.presser:
        pressure = forces[:, 0] = np.where(mode == "open", 0.0, pressure)
    across = 1.0
    if contact.friction_across is not None:
        across = number(model, course.values, contact.stretch, "a ratio of friction")
    margin = friction_margin(mu, pressure, forces[:, 1:].T, across, np.sqrt)
    return ContactMotion(
        gap, forces[:, 0], forces[:, 1] if n == 1 else forces[:, 1:], slip[:, 0] if n == 1 else slip,
        np.where(mode == "open", np.nan, margin), mode, forces, mu, margin,
        np.where(mode == "open", approach, 0.0),
    )  # fmt: skip


def wrenches(model: Model, pairs: PairLog, steps: Any) -> Array:
    """Return the impulses of families on each of `bodies_in_families`, and their moments about the origin."""
    bodies = {name: k for k, name in enumerate(bodies_in_families(model))}
    result = np.zeros((len(steps), 1 + len(bodies), 6))  # the last one is the ground's
    members = [member.shape.body.name for family in model.families for member in family.members]
    place = np.array([bodies.get(name, len(bodies)) for name in members], dtype=np.int64)
    for row, k in zip(result, steps, strict=True):
        if len(pairs.entries):
            log = pairs[k]
            for sign, member, point in ((1, 10, slice(7, 10)), (-1, 11, slice(12, 15))):
                moment = np.cross(log[:, point], log[:, 4:7])
                if log.shape[1] > ENTRY:
                    moment = moment + log[:, ENTRY + 3 : ENTRY + 6]
                wrench = np.hstack([log[:, 4:7], moment])
                np.add.at(row, place[log[:, member].astype(np.int64)], sign * wrench)
    return result[:, :-1].reshape(len(steps), -1)


class OfFamilies(ByName):
    """Contacts of a motion by name. Those of families are computed when they are asked for, and are not listed."""

    def __init__(
        self, items: Mapping[str, Any], motion_of: Callable[..., Any], families: Sequence[Family]
    ) -> None:
        super().__init__("contact", items)
        self.motion_of, self.families = motion_of, families

    def __missing__(self, name: Any) -> Any:
        for family in self.families:
            if isinstance(name, str) and family.element(name) is not None:
                self[name] = self.motion_of(family, name)
                return self[name]
            if isinstance(name, str) and name.startswith(family.name):
                a, *_, b = (member.label for member in family.members)
                raise SimulationError(
                    f"Unknown contact '{name}'. Expected two members of the family '{family.name}' that may touch, "
                    f"such as '{family.name}[{a},{b}]'."
                )
        return super().__missing__(name)
