"""What happened in a run, read from the log of the compiled loop: phases, impacts, changes of modes, their texts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...dynamics.conditions.unilateral import limits
from ..ending import ENDS, End
from ..events import event_run
from ..events.code import code
from ..events.limits import HELD, SLOW
from ..ode.dense_output import Array, Crossing, Path
from ..phase import laws
from ..phase.phase import KINDS, at_limit
from ..trajectory.event import Happening
from ..trajectory.phases import Phases, Segment
from .course import Change, Leap, Timeline, shown
from .impact import impact_of, passed
from .open_forces import LoggedSegment
from .state import ContactRun, Entry

WHY = {
    event_run.BLOW: "a blow",
    event_run.SWITCHED: "a load that switched",
    event_run.CHANGED: "a change of a signal or controller",
    event_run.OTHER_FEATURES: "other corners and edges of the patch",
    event_run.RESULTANT: "its points turned with the load",
    event_run.TIPS: "the load has reached the edge",
    event_run.GAP_CLOSED: "the gap closed",
    event_run.NORMAL_ZERO: "N reached 0",
    event_run.END_OF_SIDE: "the end of the side",
    event_run.ONTO_SIDE: "the foot came onto the side",
    event_run.SLIP_STOPPED: "the slip stopped",
    event_run.CONE_REACHED: "|T| reached {:.6g} {unit}",
    event_run.BOUNCES_BELOW: "bounces below what numbers resolve",
    event_run.BOUNCES_END: "end of the bounces, the limit of a geometric series",
}
"""Reasons why a mode began."""
UNWATCHED = f"open forces hold it at rest, asked every {1e3 * HELD:g} ms at most: a shorter slip is not seen"
"""What is left open about a rest whose limits of friction are not watched."""


LEAST = 12
"""Least number of marks of a phase."""


@dataclass
class History:
    """The history of a run.

    ``status``    how it ended
    """

    work: ContactRun
    status: End

    def __post_init__(self) -> None:
        it = self.work.it
        self.marks, self.numbers = np.array(it.marks[: it.marked]), np.array(it.numbers[: it.numbered])
        self.times, self.lengths = np.array(it.times[: it.logged]), np.array(it.lengths[: it.logged])
        self.states = np.array(it.states[: it.logged * it.n_y]).reshape(-1, it.n_y)
        places = np.empty(1 + it.marked // LEAST, dtype=np.int64)
        self.phases = places[: code("find_phases")(it, places)]
        self.told, self.turned = tuple(self.work.told), dict[Any, Array]()
        self.residual = float(it.worst)

    def __reduce__(self) -> Any:
        return Told, (self.happenings, self.timeline, self.indeterminate, self.residual)

    def entries(self, *kinds: int) -> Iterator[Entry]:
        """Yield the entries, of these kinds or of all, in their order."""
        at = 0
        while at < len(self.marks):
            kind, size = self.marks[at : at + 2].tolist()
            if not kinds or kind in kinds:
                yield self.entry(at)
            at += size

    def entry(self, at: int) -> Entry:
        """Return the entry at a place."""
        kind, size, first = self.marks[at : at + 3].tolist()
        last = self.marks[at + size + 2] if at + size < len(self.marks) else len(self.numbers)
        return Entry(kind, self.marks[at + 3 : at + size].tolist(), self.numbers[first:last])

    def modes(self, numbers: list[int], directions: Array) -> tuple[str, ...]:
        """Return the names of modes; ``directions`` has two numbers for each contact at its limit of friction."""
        result, at = [], 0
        for mode in numbers:
            result.append(at_limit(directions[at : at + 2].tolist()) if mode == laws.LIMIT else KINDS[mode])
            at += 2 * (mode == laws.LIMIT)
        return tuple(result)

    # -- the path ----------------------------------------------------------------------------------

    @cached_property
    def path(self) -> Phases:
        """The phases of the run."""
        return Phases(Logged(self), self.status)

    @cached_property
    def crossings(self) -> list[tuple[Crossing, ...]]:
        """The events of the user in every phase."""
        result, crossings = [], list[Crossing]()
        for kind, marks, numbers in (
            self.entries(event_run.CROSSING, event_run.PHASE) if self.work.asked else ()
        ):
            if kind == event_run.CROSSING:
                crossings.append(Crossing(float(numbers[0]), marks[0], marks[1], numbers[1:].copy()))
            else:
                result.append(tuple(crossings))
                crossings = []
        return result or [()] * len(self.phases)

    def segment(self, k: int) -> Segment:
        """Return a phase of the run."""
        _, marks, numbers = self.entry(self.phases[k])
        E, other = len(self.work.names), self.parameters_of(k, numbers)
        first, rows, status, rejected, evaluations, stiff, blame, kind, spare = marks[:9]
        modes = self.modes(marks[9 : 9 + E], numbers[1:])
        scene, work = self.work.scene, self.work
        parameters = work.parameters if other is None else other
        own = scene.candidates.own
        sides = tuple(map(float, marks[9 + 2 * E : 9 + 2 * E + scene.laws]))
        active = (*scene.kernels.active, *(own + i for i in marks[9 + 2 * E + scene.laws :]))
        phase = scene.holding(modes, active, sides)
        last, straight = first + rows, kind == event_run.STRAIGHT
        method = "radau" if kind == event_run.IMPLICIT else work.method
        path = object.__new__(Leap if straight else Path)
        path.__dict__.update(
            _recipe=(phase.rates, parameters), times=self.times[first:last],
            lengths=self.lengths[first : last - 1], states=self.states[first:last], crossings=self.crossings[k],
            status=ENDS[status], blame=blame, rejected=rejected, evaluations=evaluations,
            method="dop853" if straight else method,
            relative=None if straight else work.relative, absolute=None if straight else work.absolute, stiff=stiff,
            step=None,
        )  # fmt: skip
        shown_modes = marks[9 + E : 9 + 2 * E]
        dead = [mode >= event_run.DEAD for mode in shown_modes]
        names = tuple(
            contact.shown(KINDS[mode % event_run.DEAD])
            for contact, mode in zip(work.model.contacts, shown_modes, strict=True)
        )
        segment = object.__new__(LoggedSegment)
        segment.__dict__.update(
            path=path, kernels=phase, impulses=float(numbers[0]), modes=names, parameters=other, work=work,
            dead=dead if spare or any(dead) else None,
        )  # fmt: skip
        return segment

    def parameters_of(self, k: int, numbers: Array) -> Array | None:
        """Return the parameters of a phase with these real numbers, if they are not those of the whole run.

        The last of these are the angles of disks that lie flat. Phases of the same angles share the parameters.
        """
        it, given = self.work.it, self.work.parameters_of(k)
        parameters = self.work.parameters if given is None else given
        if it.rings == 0:
            return given
        angles, places = numbers[-2 * it.rings :], np.add.outer(it.ring_at, (0, 1)).ravel()
        if np.array_equal(parameters[places], angles):
            return given
        key = parameters.tobytes(), angles.tobytes()
        if key not in self.turned:
            self.turned[key] = parameters.copy()
            self.turned[key][places] = angles
        return self.turned[key]

    @cached_property
    def indeterminate(self) -> tuple[str, ...]:
        """Names of the contact forces that the motion does not determine at some time."""
        found: dict[str, None] = {}
        for segment in self.path.segments:
            found |= dict.fromkeys(self.work.scene.names[i] for i in np.flatnonzero(segment.loose))
        return tuple(found)

    # -- texts -------------------------------------------------------------------------------------

    @cached_property
    def happenings(self) -> tuple[Happening, ...]:
        """Blows, impacts and changes of mode, in their order."""
        happenings, notes, names = list[Happening](), iter(self._notes), self.work.model.state_names
        for entry in self.entries(event_run.TOLD, event_run.IMPACT, event_run.RESTING, event_run.NOTE):
            if entry.kind == event_run.TOLD:
                happenings.append(self.told[entry.marks[0]])
            elif entry.kind == event_run.IMPACT:
                happenings.append(self._impact(entry))
            elif entry.kind == event_run.RESTING:
                happenings.append(self._rest(entry))
            else:
                y = entry.numbers[1 : 1 + self.work.it.n_y]
                for was, (name, mode, t, _, why) in next(notes):
                    if was is not None:
                        text = f"contact {name}: {shown(was)} → {shown(mode)}, {why}"
                        happenings.append(Happening.between(names, t, name, (y, y), text))
        return tuple(happenings)

    @cached_property
    def timeline(self) -> Timeline:
        """Modes of every contact, with their times and the reasons why they began."""
        return Timeline(Change(*change) for changes in self._notes for _, change in changes)

    @cached_property
    def _notes(self) -> list[list[tuple[str | None, list[Any]]]]:
        """Changes of mode of every note: the mode before, and contact, mode, start, end, why."""
        current: dict[int, list[Any]] = {}
        notes = [self._note(entry, current) for entry in self.entries(event_run.NOTE)]
        for change in current.values():
            change[3] = float(self.path.end)
        return notes

    @property
    def may_warn(self) -> bool:
        """True if blows or impacts may exceed the limits of one-sided constraints."""
        return bool(self.told or limits(self.work.model))

    def _note(self, entry: Entry, current: dict[int, list[Any]]) -> list[tuple[str | None, list[Any]]]:
        """Return the changes of a note; ``current`` has the last one of every contact."""
        _, marks, numbers = entry
        work, E, n_y = self.work, len(self.work.names), self.work.it.n_y
        hit, compliance = marks[:2]
        t, changes = float(numbers[0]), []
        measures = numbers[1 + n_y + 2 * marks[2 : 2 + E].count(laws.LIMIT) :]
        for i in range(0, len(marks) - 2 - E, 4):
            k, before, after, code = marks[2 + E + i : 6 + E + i]
            held, was_held = after >= event_run.HELD_OPEN, before >= event_run.HELD_OPEN
            before, after = before - was_held * event_run.HELD_OPEN, after - held * event_run.HELD_OPEN
            if after == laws.OPEN and code == event_run.CONE_REACHED:  # |T| = μ N = 0
                code = event_run.NORMAL_ZERO
            name, unit, why = work.names[k], work.model.contacts[k].units["tangential"], ""
            across = work.model.contacts[k].friction_across is not None
            if code != event_run.NO_REASON:
                text = "T reached its ellipse" if across and code == event_run.CONE_REACHED else WHY[code]
                if work.model.contacts[k].presser:
                    text = text.replace("|T|", "|M|")
                if code == event_run.NORMAL_ZERO and work.model.contacts[k].adhesion != 0:
                    text = "N reached the adhesion"
                why = text.format(measures[i // 4], unit=unit)
            why = why or (
                "the start" if before < 0 else "an impact" if hit else "a change at another contact"
            )
            if was_held and before == after and code == event_run.NO_REASON and not hit:
                why = "its limits are watched again"
            if compliance and after != laws.OPEN:
                why += "; equal compliance shares the forces"
            if held:
                why += f"; {UNWATCHED}"
            if k in current:
                current[k][3] = t
            mode = work.model.contacts[k].shown(KINDS[after])
            # a step of the speeds may come before the first modes: it has led to them
            current[k] = [name, mode, t if before >= 0 else float(self.path.start), None, why]
            was = work.model.contacts[k].shown(KINDS[before]) if before >= 0 else None
            changes.append((was, current[k]))
        return changes

    def _rest(self, entry: Entry) -> Happening:
        _, marks, numbers = entry
        n_y, names = self.work.it.n_y, ", ".join(self.work.names[k] for k in marks[1:])
        states = numbers[1 : 1 + n_y], numbers[1 + n_y : 1 + 2 * n_y]
        text = f"{names}: slips slower than {SLOW:.0e} m/s end here together"
        if marks[0] == event_run.SERIES:
            text = f"{names}: the bounces end here, the limit of their geometric series"
        return Happening.between(self.work.model.state_names, float(numbers[0]), "rest", states, text)

    def _impact(self, entry: Entry) -> Happening:
        hit, parts = impact_of(self.work, entry), []
        for k, before, after in zip(hit.chosen, hit.speeds, hit.speeds_after, strict=True):
            if before < -hit.still:
                new = 0.0 if abs(after) <= hit.still else after
                unit = self.work.model.contacts[k].units["slip"]
                parts.append(f"{self.work.names[k]}: impact, normal speed {before:.6g} → {new:.6g} {unit}")
        if hit.part < 1:
            parts.append(
                f"restitution reduced to {hit.part:g} e: no impulses satisfy the law with e, or the energy would grow"
            )
        if hit.open:
            parts.append("indeterminate impulses of equal compliance")
        warnings = passed(self.work, hit)
        parts += [f"not possible: {one.what} ('{one.name}')" for one in warnings]
        names, states = self.work.model.state_names, (hit.before, hit.after)
        return Happening.between(names, hit.t, "impact", states, "; ".join(parts), warnings)


class Logged(Sequence[Segment]):
    """The phases of a run, each made from the log when it is first asked for."""

    def __init__(self, history: History) -> None:
        self.history, self._made = history, dict[int, Segment]()

    def __len__(self) -> int:
        return len(self.history.phases)

    @cached_property
    def heads(self) -> Any:
        """First row of the path, number of rows, status and rejected steps of every phase."""
        return self.history.marks[self.history.phases + np.arange(3, 7)[:, None]]

    def of_each(self, name: str) -> list[Any]:
        """Return what the path of every phase has by a name."""
        if name == "crossings":
            return self.history.crossings
        first, rows, _, rejected = self.heads
        found = {
            "start": self.history.times[first], "end": self.history.times[first + rows - 1], "steps": rows - 1,
            "rejected": rejected,
        }  # fmt: skip
        return found[name].tolist()

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return tuple(self[i] for i in range(*k.indices(len(self))))
        at = range(len(self))[k]
        if at not in self._made:
            self._made[at] = self.history.segment(at)
        return self._made[at]

    def __reduce__(self) -> Any:
        return tuple, (list(self),)


@dataclass(frozen=True)
class Told:
    """The history of a motion from a file, or of a copy."""

    happenings: tuple[Happening, ...]
    timeline: Timeline
    indeterminate: tuple[str, ...]
    residual: float

    may_warn = True
