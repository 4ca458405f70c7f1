"""Derivatives of a motion with contacts by its unknowns: variational equations in its phases, jumps at its events.

The motion is computed first, with all that decides it. The derivatives follow its phases: in each, the state at its
start and the s_j are integrated together (`phase_slopes.varied`) to its end, and at each event the s_j jump
(`saltation`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import numpy as np

from ....errors import NoDerivativesError
from ...ending import End
from ...events import event_run
from ...kernels.contact_quantities import asked_by
from ...legs.blow import located
from ...legs.blow_slopes import Struck, event_along
from ...legs.driven_slopes import DifferentiatedDrives
from ...legs.sensitivity import slopes_of
from ...legs.switch_slopes import SwitchingLaws, check_others, refuse_jumps, switching_laws
from ...legs.variation import Unknown, Variation
from ...ode.dense_output import Array, Path, Rates
from ...ode.integration import Integration
from ...request import Problem
from ...trajectory.phases import Phases, Segment
from ...trajectory.progress import Progress
from ..history import History
from ..impact import Impact, impact_of
from ..state import Entry
from .impact_slopes import bounces_taken
from .impact_stages import after_blow_in_joints, after_impact, one_by_one
from .moments import Moment, moments, notes_of
from .quantities import quantities
from .saltation import After, check_modes, check_passing, check_ties, event_slope, kept
from .slopes import Slopes, refused, title, turned_points
from .variational_path import Switch, VariationalPath, pieces, straight_path, switches_of

ENDS_OF_SIDES = event_run.END_OF_SIDE, event_run.ONTO_SIDE
TRIGGERS = event_run.NORMAL_ZERO, event_run.SLIP_STOPPED, event_run.CONE_REACHED, *ENDS_OF_SIDES
"""Reasons of a mode that ends by a function of its own, beside the closing of a gap."""
OF_THE_PRESSER = event_run.GAP_CLOSED, event_run.NORMAL_ZERO, *ENDS_OF_SIDES
"""Reasons of what resists rolling or spinning that are those of its contact."""
ALIKE = 1e-6
"""Relative difference up to which times of events, and rates on both sides of one, are equal."""
NONE = 1e-9
"""Relative size of a function, or of its rate, that is none."""
OTHER_FEATURES = (
    "solids touch at other corners, edges or faces from there on, which changes their forces at a time that moves with "
    "the unknowns"
)
JUMPS = event_run.IMPACT, event_run.TOLD, event_run.OTHER_VALUES
"""Entries of the log after which rates may jump."""


class Happened(NamedTuple):
    """An event of a contact: its time, the contact, and the derivatives of the time."""

    time: float
    contact: str
    slopes: Array


@dataclass(frozen=True, eq=False)
class Followed:
    """The derivatives of a motion: its path with (q, u, work, heat, s_1, s_2, ...), and times of events of contacts.

    ``shifts``    start and end of each moment between two phases, and the derivatives of its time
    """

    slopes: Slopes
    path: Phases
    happened: tuple[Happened, ...]
    shifts: tuple[tuple[float, float, Array], ...]


def follow(slopes: Slopes, history: History, problem: Problem, first: Array, between: Progress) -> Followed:
    """Return the derivatives of a finished run, from those at its start, shape (unknowns, components of (q, u)).

    Raises
    ------
    SimulationError
        A motion that has no derivatives.
    """
    return _Following(slopes, history, problem, between).run(first)


class _Following:
    def __init__(self, slopes: Slopes, history: History, problem: Problem, between: Progress) -> None:
        self.slopes, self.history, self.problem, self.between = slopes, history, problem, between
        self.scene, self.moved, self.parameters = slopes.scene, slopes.moved, slopes.parameters
        self.tolerance = float(problem.tolerances[: self.moved].max(initial=1e-12))
        self.alike = max(ALIKE, 1e3 * self.tolerance)
        self.happened: list[Happened] = []
        self.shifts: list[tuple[float, float, Array]] = []
        symbols = [Unknown(str(symbol), symbol) for symbol in slopes.symbols]
        self.variation = Variation(slopes.kernels, symbols)
        self.drives = DifferentiatedDrives(problem, slopes.unknowns) if slopes.model.switched else None

    @property
    def laws(self) -> SwitchingLaws | None:
        """The laws of loads that switch, with the present values of the parameters."""
        laws, seeds = switching_laws(self.variation, self.slopes.parameters), self.slopes.seeds
        return laws if laws is None else replace(laws, seeds=seeds, unknowns=len(seeds))

    def run(self, first: Array) -> Followed:
        phases, before = moments(self.history)
        segments: list[Segment] = []
        last: Segment | None = None
        S, shifts = first, np.zeros(len(first))
        for number, moment in zip(phases, before, strict=False):
            segment = self.history.path.segments[number]
            S, leaps = self.passed(last, moment, segment, S, shifts)
            segments += leaps
            laws, t, y = self.laws, segment.path.start, segment.path.states[0]
            if laws is not None and last is None:
                check_others(laws, -1, t, y, S, self.slopes.velocity(segment.kernels, t, y))
            switches = switches_of(self.slopes, laws, segment, self.problem.specs, self.tolerance)
            for piece in pieces(self.slopes, segment, S, self.way(segment), self.between, laws, switches):
                segments.append(Segment(cast(Path, piece), segment.kernels))
                S, shifts = piece.last, piece.shifts
                self.refuse_jumps(laws, piece, switches)
            last = segment
        if self.drives is not None and self.history.status == End.FINISHED:
            self.check_end(self.drives.times_along(self.problem.end))
        # a last moment, with straight steps up to the end of the run
        rest = [self.history.path.segments[k] for k in before[len(phases)].straight]
        segments += [self.straight(one, S) for one in rest]
        return Followed(
            self.slopes, Phases(segments, self.history.status), tuple(self.happened), tuple(self.shifts)
        )

    def refuse_jumps(
        self, laws: SwitchingLaws | None, piece: VariationalPath, switches: list[Switch]
    ) -> None:
        """Refuse jumps of the rates that no switch of a load has told."""
        if laws is not None:
            n, states = self.moved, piece.states
            s = states[:, n + 2 :].reshape(len(states), -1, n)
            refuse_jumps(laws, piece.times, states, s, [(x.law, x.time) for x in switches])

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
        phase, t, y = segment.kernels, segment.path.start, segment.path.states[0]
        straight = [self.history.path.segments[k] for k in moment.straight]
        check_modes(self.slopes, phase, t, len(straight))
        events, tau = self.times(last, moment, r, shifts, t)
        before, drives = np.zeros(self.moved), self.drives is not None
        if last is not None:
            self.shifts.append((last.path.end, t, tau))
            before = self.slopes.velocity(last.kernels, last.path.end, last.path.states[-1])
        sigma, hits, jumps = r + np.outer(tau - shifts, before), list[Impact](), bool(events)
        for entry in moment.entries:
            if entry.kind == event_run.IMPACT:
                hits.append(self.impact(entry))
                sequential = self.problem.request.impacts == "sequential"
                for hit in one_by_one(self.slopes, hits[-1], sigma) if sequential else hits[-1:]:
                    sigma = after_impact(self.slopes, hit, sigma, tau)
            elif entry.kind == event_run.TOLD:
                sigma = after_blow_in_joints(self.slopes, self.struck(entry), sigma, tau)
                hits.clear()  # bounces before it have not ended
            elif entry.kind == event_run.OTHER_VALUES:
                self.slopes = self.changed(entry, last, sigma, tau)
            jumps |= entry.kind in JUMPS and (drives or entry.kind != event_run.OTHER_VALUES)
        self.turn(segment)
        slopes = self.slopes
        if straight:
            length = t - straight[0].path.start
            ways = [slopes.along(phase, t, y, *one) for one in zip(sigma, tau, slopes.seeds, strict=True)]
            sigma = sigma + length * np.array([way.rates for way in ways])
        if hits:
            sigma = bounces_taken(slopes, hits[-1], (y, phase, bool(straight)), sigma, tau)
        stopped = [
            k for k, why in events.items() if why == event_run.SLIP_STOPPED and self.scene.tangents[k] == 2
        ]
        features = not (drives or hits) and any(x.kind == event_run.OTHER_VALUES for x in moment.entries)
        try:
            sigma = kept(slopes, After(phase, t, y, stopped, self.alike), sigma, tau)
        except NoDerivativesError:
            if features:
                raise refused(slopes, t, OTHER_FEATURES) from None
            raise
        if not straight:
            check_ties(slopes, phase, t, y, list(events))
        after = slopes.velocity(phase, t, y)
        jump = np.abs(after - before).max(initial=0.0)
        if last is not None and not jumps and jump > ALIKE * (1 + np.abs(before).max(initial=0.0)):
            raise refused(slopes, t, OTHER_FEATURES if features else "the forces of contacts jump there")
        result = sigma - np.outer(tau, after)
        return result, [self.straight(one, result) for one in straight]

    def turn(self, segment: Segment) -> None:
        """Take the points on which disks that lie flat stand in a phase."""
        slopes, own = self.slopes, segment.parameters
        own = self.parameters if own is None else own
        if self.history.work.it.rings and not np.array_equal(own, slopes.parameters):
            self.slopes = Slopes(slopes.kernels, slopes.unknowns, own, slopes.seeds)

    def times(
        self, last: Segment | None, moment: Moment, r: Array, shifts: Array, t: float
    ) -> tuple[dict[int, int], Array]:
        """Return the contacts whose own events make a moment, with their reasons, and the derivatives of its time."""
        slopes, tau = self.slopes, np.zeros(len(r))
        events = self.events(last, moment, t)
        others = [*self.times_of_others(last, moment, r, shifts)]
        found = others
        if last is None:
            self.check_start(list(events), r, t)
        else:
            times = self.slopes_of_times(last, events, r, shifts, self.landing(moment, sigma=r, tau=tau))
            found = [*zip((title(slopes, k) for k in events), times, strict=True), *others]
        if found:
            tau = found[0][1]
        for name, other in found[1:]:
            self.check_together(t, (found[0][0], name), other - tau, np.abs(other) + np.abs(tau))
        if t >= self.problem.end:
            self.check_end(others)
        self.happened += [Happened(t, slopes.model.contacts[k].name, tau) for k in events]
        return events, tau

    def check_end(self, others: Iterable[tuple[str, Array]]) -> None:
        """Raise if a blow or a sample comes at the end of a run, and would come after it if an unknown changed."""
        slopes, p = self.slopes, self.problem
        end = np.array(slopes_of(slopes.model, slopes.unknowns, p.numbers, p.request.until))
        for name, tau in others:
            self.check_together(p.end, (name, "the end of the run"), tau - end, np.abs(tau) + np.abs(end))

    def check_together(self, t: float, names: tuple[str, str], apart: Array, size: Array) -> None:
        """Raise if two events would not come at the same time if an unknown changed."""
        off = np.abs(apart) > self.alike * size + self.tolerance
        if off.any():
            unknown = self.slopes.unknowns[int(np.argmax(off))].name
            what = f"{' and '.join(names)} come at the same time, but move apart if '{unknown}' changes"
            raise refused(self.slopes, t, what)

    def times_of_others(
        self, last: Segment | None, moment: Moment, r: Array, shifts: Array
    ) -> Iterator[tuple[str, Array]]:
        """Yield the blows, signals and controllers of a moment, with the derivatives of their times."""
        slopes = self.slopes
        for entry in moment.entries:
            if entry.kind == event_run.OTHER_VALUES and self.drives is not None:
                yield from self.drives.times_along(self.history.work.changed_at[entry.marks[0]][0])
            elif entry.kind == event_run.TOLD:
                hit = self.struck(entry)
                name = f"blow '{hit.blow.name}'"
                if not located(slopes.kernels, hit.blow):
                    values = self.values(slopes.parameters)
                    yield name, np.array(slopes_of(slopes.model, slopes.unknowns, values, hit.blow.when))
                elif last is not None:
                    y = last.path.states[-1]
                    f = slopes.velocity(last.kernels, hit.t, y)
                    value, rate, *ways = event_along(slopes, hit.blow, (hit.t, y, f), (r, shifts))
                    if abs(value) > NONE * (1 + np.abs(y).max(initial=0.0)):
                        continue  # it jumps over zero, at the time of another event
                    if abs(rate) <= NONE * (1 + np.abs(ways).max(initial=0.0)):
                        raise refused(slopes, hit.t, f"what calls for {name} only touches zero there")
                    yield name, shifts - np.array(ways) / rate

    def struck(self, entry: Entry) -> Struck:
        """Return a blow of the log."""
        told, model = self.history.told[entry.marks[0]], self.slopes.model
        names = model.state_names
        before, after = (np.array([of[x] for x in names]) for of in (told.state, told.after))
        return Struck(self.history.work.struck[entry.marks[0]], told.time, before, after)

    def values(self, parameters: Array) -> dict[str, float]:
        """Return values of the parameters by their names."""
        return dict(zip((p.name for p in self.slopes.model.parameters), parameters.tolist(), strict=True))

    def changed(self, entry: Entry, last: Segment | None, sigma: Array, tau: Array) -> Slopes:
        """Return the derivatives with the values that a signal, a controller or a patch of solids has set.

        Sensors read the contacts in the phase that has ended.
        """
        slopes, number = self.slopes, entry.marks[0]
        parameters = self.history.work.changes[number][1]
        if self.drives is None:  # the features of patches
            return Slopes(slopes.kernels, slopes.unknowns, parameters, slopes.seeds)
        t, y = self.history.work.changed_at[number]
        phase, ways = None if last is None else last.kernels, [*zip(sigma, tau, slopes.seeds, strict=True)]
        sensed = asked_by(self.drives.sensed)
        self.drives.touched = lambda: quantities(slopes, phase, sensed, t, y[: self.moved], ways)
        self.drives.follow(t, y[: self.moved], sigma, tau, self.values(parameters))
        return Slopes(slopes.kernels, slopes.unknowns, parameters, self.drives.along(slopes.symbols))

    def events(self, last: Segment | None, moment: Moment, t: float) -> dict[int, int]:
        """Return the contacts whose own events make a moment, with their reasons."""
        slopes, result = self.slopes, dict[int, int]()
        others: set[int] = set()
        was_open = [last is None or last.kernels.modes[k] == "open" for k in range(len(self.scene.first))]
        for entry in moment.entries:
            if entry.kind == event_run.IMPACT:
                hit = impact_of(self.history.work, entry)
                for k, speed in zip(hit.chosen, hit.speeds, strict=True):
                    if not was_open[k] or self.scene.presser[k] >= 0:
                        pass  # resistance closes with its contact
                    elif speed < -hit.still:
                        result.setdefault(k, event_run.GAP_CLOSED)
                    else:
                        others.add(k)
            elif entry.kind == event_run.NOTE:
                for k, before, _, why in notes_of(entry, len(self.scene.first)):
                    if self.ends_itself(k, before, why, last, was_open[k]):
                        result.setdefault(k, why)
            elif entry.kind == event_run.RESTING and entry.marks[0] != event_run.SERIES:
                raise refused(slopes, t, "bounces or slips of several contacts end together there")
        for k in others - set(result):
            raise refused(slopes, t, f"{title(slopes, k)} touches, without approaching, as others collide")
        modes = () if last is None else last.kernels.modes
        for points in turned_points(slopes.model, slopes.parameters) if modes else ():
            closed = [k for k in points if modes[k] != "open"]
            lost = [k for k in closed if result.get(k) == event_run.NORMAL_ZERO]
            if len(lost) < len(closed):  # a disk that sticks on the others moves as before
                for k in lost:
                    del result[k]
        return result

    def ends_itself(self, k: int, before: int, why: int, last: Segment | None, was_open: bool) -> bool:
        """Return True if the mode of a contact ends by a function of its own."""
        if self.scene.presser[k] >= 0 and why in OF_THE_PRESSER:
            return False
        if why == event_run.GAP_CLOSED:
            return last is not None and was_open
        has_end = self.scene.candidates.pattern.contacts[k].reaches > 0
        return before >= 0 and why in TRIGGERS and (why not in ENDS_OF_SIDES or has_end)

    def landing(self, moment: Moment, sigma: Array, tau: Array) -> Slopes:
        """Return the derivatives with the features of patches that collide in a moment."""
        slopes = self.slopes
        for entry in moment.entries if self.drives is None else ():
            if entry.kind == event_run.IMPACT:
                break
            if entry.kind == event_run.OTHER_VALUES:
                slopes = self.changed(entry, None, sigma, tau)
        return slopes

    def slopes_of_times(
        self, last: Segment, events: dict[int, int], r: Array, shifts: Array, landing: Slopes
    ) -> list[Array]:
        """Return the derivatives of the times of events; those of gaps that close have the features of ``landing``."""
        phase, t, y, result = last.kernels, last.path.end, last.path.states[-1], []
        for k, why in events.items():
            slopes = landing if why == event_run.GAP_CLOSED else self.slopes
            onwards = slopes.along(phase, t, y, slopes.velocity(phase, t, y), 1.0)
            ways = [slopes.along(phase, t, y, *one) for one in zip(r, shifts, slopes.seeds, strict=True)]
            rate = event_slope(slopes, phase, t, y, k, why, onwards)
            if np.isnan(rate):
                name = slopes.model.contacts[k].name
                raise refused(
                    slopes, t, f"contacts without load share the force that ends the mode of '{name}'"
                )
            check_passing(slopes, last, k, why, rate, self.tolerance)
            along = np.array([event_slope(slopes, phase, t, y, k, why, way) for way in ways])
            result.append(shifts - along / rate)
        return result

    def check_start(self, events: Sequence[int], S: Array, t: float) -> None:
        """Raise if contacts that collide at the start would not if an unknown changed."""
        y = self.history.states[0]
        for k in events:
            for s, dp, unknown in zip(S, self.slopes.seeds, self.slopes.unknowns, strict=True):
                gap = self.slopes.of_contact(k, t, y, s, 0.0, dp).gap
                if abs(gap) > self.alike * np.abs(s).max(initial=0.0):
                    what = f"{title(self.slopes, k)} begins closed, and would not if '{unknown.name}' changed"
                    raise refused(self.slopes, t, what)

    def impact(self, entry: Entry) -> Impact:
        """Return an impact of the log."""
        hit = impact_of(self.history.work, entry)
        if hit.open:
            what = "the impulses of an impact are indeterminate, and decide the motion"
            raise refused(self.slopes, hit.t, what)
        return hit
