"""Derivatives of a motion with contacts by its unknowns: variational equations in its phases, jumps at its events.

The motion is computed first, with all that decides it. The derivatives follow its phases: in each, the state at its
start and the s_j are integrated together (`phase_slopes.varied`) to its end, and at each event the s_j jump
(`saltation`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np

from ..events import event_run
from ..legs.switch_slopes import SwitchingLaws, check_others, refuse_jumps
from ..ode.dense_output import Array, Path, Rates, observe
from ..ode.integration import Integration
from ..phase.scene import LIMIT, Phase
from ..request import Problem
from ..trajectory.phases import Phases, Segment
from ..trajectory.progress import Progress
from .history import Entry, History
from .impact_slopes import Impact, after_impact, impact_slope
from .saltation import After, check_ties, event_slope, kept
from .slopes import Slopes, refused
from .variational_path import Switch, VariationalPath, pieces, straight_path, switches_of

ENDS_OF_SIDES = event_run.END_OF_SIDE, event_run.ONTO_SIDE
TRIGGERS = event_run.NORMAL_ZERO, event_run.SLIP_STOPPED, event_run.CONE_REACHED, *ENDS_OF_SIDES
"""Reasons of a mode that ends by a function of its own, beside the closing of a gap."""
ALIKE = 1e-6
"""Relative difference up to which times of events, and rates on both sides of one, are equal."""


class Happened(NamedTuple):
    """An event of a contact: its time, the contact, and the derivatives of the time."""

    time: float
    contact: str
    slopes: Array


@dataclass(frozen=True, eq=False)
class Followed:
    """The derivatives of a motion: its path with (q, u, work, heat, s_1, s_2, ...), and times of events of contacts."""

    slopes: Slopes
    path: Phases
    happened: tuple[Happened, ...]


class Moment(NamedTuple):
    """What the log has between two phases: entries, and the straight steps with the time that they take."""

    entries: list[Entry]
    straight: list[int]


def moments(history: History) -> tuple[list[int], list[Moment]]:
    """Return the numbers of the phases that are not straight steps, and the moments before each of them."""
    phases, result, number = [], [Moment([], [])], 0
    for entry in map(Entry._make, history.entries()):
        if entry.kind == event_run.PHASE:
            if entry.marks[7] == event_run.STRAIGHT:
                result[-1].straight.append(number)
            else:
                phases.append(number)
                result.append(Moment([], []))
            number += 1
        elif entry.kind != event_run.CROSSING:
            result[-1].entries.append(entry)
    return phases, result


def follow(
    slopes: Slopes, history: History, problem: Problem, first: Array, between: Progress,
    laws: SwitchingLaws | None = None,
) -> Followed:  # fmt: skip
    """Return the derivatives of a finished run, from those at its start, shape (unknowns, components of (q, u)).

    ``laws`` are those of loads that switch.

    Raises
    ------
    SimulationError
        A motion that has no derivatives.
    """
    return _Following(slopes, history, problem, between, laws).run(first)


class _Following:
    def __init__(
        self,
        slopes: Slopes,
        history: History,
        problem: Problem,
        between: Progress,
        laws: SwitchingLaws | None,
    ) -> None:
        self.laws = laws
        self.slopes, self.history, self.problem, self.between = slopes, history, problem, between
        self.scene, self.moved = slopes.scene, slopes.moved
        self.tolerance = float(problem.tolerances[: self.moved].max(initial=1e-12))
        self.alike = max(ALIKE, 1e3 * self.tolerance)
        self.happened: list[Happened] = []

    def run(self, first: Array) -> Followed:
        phases, before = moments(self.history)
        segments: list[Segment] = []
        last: Segment | None = None
        S, shifts = first, np.zeros(len(first))
        if self.laws is not None and phases:
            one = self.history.path.segments[phases[0]]
            t, y = one.path.start, one.path.states[0]
            check_others(self.laws, -1, t, y, first, self.slopes.velocity(one.kernels, t, y))
        for number, moment in zip(phases, before, strict=False):
            segment = self.history.path.segments[number]
            S, leaps = self.passed(last, moment, segment, S, shifts)
            segments += leaps
            switches = switches_of(self.slopes, self.laws, segment, self.problem.specs, self.tolerance)
            for piece in pieces(
                self.slopes, segment, S, self.way(segment), self.between, self.laws, switches
            ):
                segments.append(Segment(cast(Path, piece), segment.kernels))
                S, shifts = piece.last, piece.shifts
                self.refuse_jumps(piece, switches)
            last = segment
        # a last moment, with straight steps up to the end of the run
        rest = [self.history.path.segments[k] for k in before[len(phases)].straight]
        segments += [self.straight(one, S) for one in rest]
        return Followed(self.slopes, Phases(segments, self.history.status), tuple(self.happened))

    def refuse_jumps(self, piece: VariationalPath, switches: list[Switch]) -> None:
        """Refuse jumps of the rates that no switch of a load has told."""
        if self.laws is not None:
            n, states = self.moved, piece.states
            s = states[:, n + 2 :].reshape(len(states), -1, n)
            refuse_jumps(self.laws, piece.times, states, s, [(x.law, x.time) for x in switches])

    def way(self, segment: Segment) -> Callable[[Rates], Integration]:
        """Return how a phase is integrated with its derivatives: explicitly, by the method of the run."""
        k, method = len(self.slopes.unknowns), segment.path.method
        of_state = np.full(self.moved + 2, self.tolerance)
        of_state[: self.moved] = self.problem.tolerances[: self.moved]
        tolerances = np.concatenate([of_state, np.tile(of_state[: self.moved], k)])

        def made(rates: Rates) -> Integration:
            return Integration(
                rates, tolerances, method="dop853" if method == "radau" else method,
                max_step=self.problem.request.longest_step, max_steps=self.problem.most_steps,
            )  # fmt: skip

        return made

    def straight(self, segment: Segment, S: Array) -> Segment:
        """Return a straight step with constant derivatives."""
        return Segment(cast(Path, straight_path(self.slopes, segment, S)), segment.kernels)

    # -- an event ----------------------------------------------------------------------------------

    def passed(
        self, last: Segment | None, moment: Moment, segment: Segment, r: Array, shifts: Array
    ) -> tuple[Array, list[Segment]]:
        """Return the derivatives after a moment, and its straight steps; before it they are r - θ y'."""
        slopes, phase = self.slopes, segment.kernels
        t, y = segment.path.start, segment.path.states[0]
        straight = [self.history.path.segments[k] for k in moment.straight]
        self.check_modes(phase, moment, t)
        events, tau = self.times(last, moment, r, shifts, t)
        before = np.zeros(self.moved)
        if last is not None:
            before = slopes.velocity(last.kernels, last.path.end, last.path.states[-1])
        sigma = r + np.outer(tau - shifts, before)
        hits = [self.impact(entry) for entry in moment.entries if entry.kind == event_run.IMPACT]
        for hit in hits:
            sigma = after_impact(slopes, hit, sigma, tau)
        if straight:
            length = t - straight[0].path.start
            ways = [slopes.along(phase, t, y, *one) for one in zip(sigma, tau, slopes.seeds, strict=True)]
            sigma = sigma + length * np.array([way.rates for way in ways])
        sigma = self.bounces_taken(hits, y, phase, sigma, tau, straight)
        stopped = [
            k for k, why in events.items() if why == event_run.SLIP_STOPPED and self.scene.tangents[k] == 2
        ]
        sigma = kept(slopes, After(phase, t, y, stopped, self.alike), sigma, tau)
        if not straight:
            check_ties(slopes, phase, t, y, list(events))
        after = slopes.velocity(phase, t, y)
        jump = np.abs(after - before).max(initial=0.0)
        if (
            last is not None
            and not hits
            and not events
            and jump > ALIKE * (1 + np.abs(before).max(initial=0.0))
        ):
            raise refused(slopes, t, "the forces of contacts jump there")
        result = sigma - np.outer(tau, after)
        return result, [self.straight(one, result) for one in straight]

    def check_modes(self, phase: Phase, moment: Moment, t: float) -> None:
        """Raise for modes whose derivatives indeterminate forces decide."""
        slopes = self.slopes
        for k, mode in enumerate(phase.modes):
            if mode.startswith(LIMIT):
                what = f"contact '{slopes.model.contacts[k].name}' rests at its limit of friction, held by the others"
                raise refused(slopes, t, what)
        if len(moment.straight) > 2:
            raise refused(slopes, t, "slips of several contacts begin and end within a microsecond")

    def times(
        self, last: Segment | None, moment: Moment, r: Array, shifts: Array, t: float
    ) -> tuple[dict[int, int], Array]:
        """Return the contacts whose own events make a moment, with their reasons, and the derivatives of its time."""
        slopes, tau = self.slopes, np.zeros(len(r))
        events = self.events(last, moment, t)
        if last is None:
            self.check_start(list(events), r, t)
        found = [] if last is None else self.slopes_of_times(last, events, r, shifts)
        for other, k in zip(found[1:], list(events)[1:], strict=True):
            first = next(iter(events))
            off = np.abs(other - found[0]) > self.alike * (np.abs(other) + np.abs(found[0])) + self.tolerance
            if off.any():
                names = " and ".join(f"'{slopes.model.contacts[i].name}'" for i in (first, k))
                unknown = slopes.unknowns[int(np.argmax(off))].name
                what = (
                    f"events of contacts {names} come at the same time, but move apart if '{unknown}' changes"
                )
                raise refused(slopes, t, what)
        if found:
            tau = found[0]
        self.happened += [Happened(t, slopes.model.contacts[k].name, tau) for k in events]
        return events, tau

    def events(self, last: Segment | None, moment: Moment, t: float) -> dict[int, int]:
        """Return the contacts whose own events make a moment, with their reasons."""
        slopes, result = self.slopes, dict[int, int]()
        others: set[int] = set()
        was_open = [last is None or last.kernels.modes[k] == "open" for k in range(len(self.scene.first))]
        for entry in moment.entries:
            if entry.kind == event_run.IMPACT:
                at = 4 + 2 * (self.moved + 2)
                for k in entry.marks[2:]:
                    approaches, own = entry.numbers[at] < -entry.numbers[3], self.scene.presser[k] < 0
                    if not own:
                        pass  # it closes with its contact
                    elif was_open[k] and approaches:
                        result.setdefault(k, event_run.GAP_CLOSED)
                    elif was_open[k]:
                        others.add(k)
                    at += 3 + self.scene.tangents[k]
            elif entry.kind == event_run.NOTE:
                for k, before, _, why in _notes(entry, len(self.scene.first)):
                    if self.ends_itself(k, before, why, last, was_open[k]):
                        result.setdefault(k, why)
            elif entry.kind == event_run.RESTING and entry.marks[0] != event_run.SERIES:
                raise refused(slopes, t, "bounces or slips of several contacts end together there")
        for k in others - set(result):
            name = slopes.model.contacts[k].name
            raise refused(slopes, t, f"contact '{name}' touches, without approaching, as others collide")
        return result

    def ends_itself(self, k: int, before: int, why: int, last: Segment | None, was_open: bool) -> bool:
        """Return True if the mode of a contact ends by a function of its own."""
        if self.scene.presser[k] >= 0 and why in (
            event_run.GAP_CLOSED,
            event_run.NORMAL_ZERO,
            *ENDS_OF_SIDES,
        ):
            return False
        if why == event_run.GAP_CLOSED:
            return last is not None and was_open
        has_end = self.scene.candidates.pattern.contacts[k].reaches > 0
        return before >= 0 and why in TRIGGERS and (why not in ENDS_OF_SIDES or has_end)

    def slopes_of_times(self, last: Segment, events: dict[int, int], r: Array, shifts: Array) -> list[Array]:
        """Return the derivatives of the times of events."""
        slopes, phase, t, y = self.slopes, last.kernels, last.path.end, last.path.states[-1]
        if not events:
            return []
        onwards = slopes.along(phase, t, y, slopes.velocity(phase, t, y), 1.0)
        ways = [slopes.along(phase, t, y, *one) for one in zip(r, shifts, slopes.seeds, strict=True)]
        result = []
        for k, why in events.items():
            rate = event_slope(slopes, phase, t, y, k, why, onwards)
            if np.isnan(rate):
                name = slopes.model.contacts[k].name
                raise refused(
                    slopes, t, f"contacts without load share the force that ends the mode of '{name}'"
                )
            self.check_passing(last, k, why, rate)
            along = np.array([event_slope(slopes, phase, t, y, k, why, way) for way in ways])
            result.append(shifts - along / rate)
        return result

    def check_start(self, events: Sequence[int], S: Array, t: float) -> None:
        """Raise if contacts that collide at the start would not if an unknown changed."""
        y = self.history.states[0]
        for k in events:
            for s, dp, unknown in zip(S, self.slopes.seeds, self.slopes.unknowns, strict=True):
                gap = self.slopes.of_contact(k, t, y, s, 0.0, dp)[0]
                if abs(gap) > self.alike * np.abs(s).max(initial=0.0):
                    name = self.slopes.model.contacts[k].name
                    raise refused(
                        self.slopes,
                        t,
                        f"contact '{name}' begins closed, and would not if '{unknown.name}' changed",
                    )

    def check_passing(self, last: Segment, k: int, why: int, rate: float) -> None:
        """Raise if the function of an event only touches zero, as far as the errors of the run tell."""
        path, grazes = last.path, rate == 0
        if why == event_run.GAP_CLOSED:
            program = last.kernels.contact()
            constants = program.constants(self.slopes.parameters)
            gaps = observe(
                program.address("gap"), program.outputs("gap"), path.times, path.states, constants
            )[:, k]
            # an error δ of the gap changes its rate by g'' δ/g', and g'' is of the size of g/T²
            lasted = path.end - path.start
            grazes |= abs(rate) * lasted <= 1e2 * np.sqrt(self.tolerance) * np.abs(gaps).max()
        if grazes:
            name = self.slopes.model.contacts[k].name
            raise refused(
                self.slopes, path.end,
                f"contact '{name}' only touches there, with the rate {rate:.2g}: if an unknown changed, it might not",
            )  # fmt: skip

    def impact(self, entry: Entry) -> Impact:
        """Return an impact of the log."""
        slopes, n_y, numbers = self.slopes, self.moved + 2, entry.numbers
        t, part, _, still = numbers[:4].tolist()
        chosen, at, impulses = entry.marks[2:], 4 + 2 * n_y, np.zeros(self.scene.rows)
        if entry.marks[0]:
            raise refused(slopes, t, "the impulses of an impact are indeterminate, and decide the motion")
        for k in chosen:
            size, first = 1 + self.scene.tangents[k], self.scene.first[k]
            impulses[first : first + size] = numbers[at + 2 : at + 2 + size]
            at += 2 + size
        before, after = numbers[4 : 4 + n_y], numbers[4 + n_y : 4 + 2 * n_y]
        return Impact(t, before, after, chosen, impulses, part, still)

    def bounces_taken(
        self, hits: list[Impact], y: Array, phase: Any, sigma: Array, tau: Array, straight: list[Segment]
    ) -> Array:
        """Return derivatives after the rest of bounces is taken away from contacts that stay closed after an impact."""
        if not hits:
            return sigma
        hit, slopes, scene = hits[-1], self.slopes, self.scene
        restitution = hit.part * slopes.look(hit.t, hit.before).restitution
        still = slopes.look(hit.t, hit.after)
        taken = [
            k for k in hit.chosen
            if phase.modes[k] != "open" and restitution[k] > 0 and abs(still.rate[scene.first[k]]) > hit.still
        ]  # fmt: skip
        if not taken:
            return sigma
        closed = [k for k in hit.chosen if phase.modes[k] != "open" and k not in scene.loaded]
        if straight:
            raise refused(slopes, hit.t, "a series of bounces ends as a slip begins or ends")
        change = y.copy()
        change[: slopes.model.n_q] = hit.after[: slopes.model.n_q]
        impulses = self.impulses_between(hit, change, closed)
        rest = hit._replace(before=hit.after, after=change, impulses=impulses, chosen=closed, taken=True)
        return impact_slope(slopes, rest, sigma, tau)[0]

    def impulses_between(self, hit: Impact, after: Array, closed: Sequence[int]) -> Array:
        """Return the least impulses of the closed contacts that change the speeds after an impact to others."""
        slopes, scene = self.slopes, self.scene
        n_q = slopes.model.n_q
        seen = slopes.look(hit.t, hit.after)
        rows = [r for k in closed for r in range(scene.first[k], scene.first[k] + 1 + scene.tangents[k])]
        M, G = slopes.mass(hit.t, hit.after)
        change, pushed = M @ (after - hit.after)[n_q : self.moved], np.vstack([seen.matrix[rows], G])
        result = np.zeros(scene.rows)
        result[rows] = np.linalg.lstsq(pushed.T, change, rcond=1e-11)[0][: len(rows)]
        return result


def _notes(entry: Entry, contacts: int) -> list[list[int]]:
    """Return contact, mode before and after, and reason of each change of an entry."""
    marks = entry.marks[2 + contacts :]
    return [marks[i : i + 4] for i in range(0, len(marks), 4)]
