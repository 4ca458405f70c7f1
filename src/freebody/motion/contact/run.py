"""Motion with contacts, from event to event.

    between events   the usual loop integrates the compiled equations of one set of modes (open, stick, slip)
    events           a gap closes, N falls to zero, |T| reaches μ_s N, the slip stops, a contact leaves its surface
    at an event      impulses if contacts approach (`impulses`), then modes from the contact problem of the
                     accelerations (`decision`)

All this is one compiled loop (`event_loop`), which returns to be asked again: with a longer log, for progress, for a
blow, and where a law holds with equality or several motions may be consistent, so that all sets of modes are compared
(`modes`).
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from time import perf_counter

import numpy as np

from ...errors import SimulationError
from ..ending import ENDS, End
from ..events import event_run
from ..events.code import code
from ..legs.blow import Blow, strike
from ..ode.dense_output import Array
from ..phase.places import CLOSED, OPEN
from ..phase.scene import KINDS, NUMBERS, Snapshot
from .history import History, impact_of
from .modes import modes_at
from .state import ContactRun

_DECIDING = Lock()
"""Held while modes are compared: the kernel of the derivatives is compiled at its first use."""
PIECE, FIRST = 0.05, 1 << 10
"""Seconds between two looks at the keyboard, and the number of steps up to the first."""
LOOKS = 32
"""Steps at which indeterminate forces are checked: the first ones of a phase, and as many spread along it."""


def check_apart(work: ContactRun, y: Array, seen: Snapshot) -> None:
    """Raise if bodies are inside each other in the initial state."""
    deepest = int(np.argmin(np.where(seen.reach >= 0, seen.gap, np.inf)))
    near = CLOSED * (1 + float(np.abs(y[: work.n]).max(initial=0)))
    if seen.gap[deepest] < -near and seen.reach[deepest] >= 0:
        raise SimulationError(
            f"The initial state of '{work.model.name}' has contact '{work.names[deepest]}' {-seen.gap[deepest]:.6g} m "
            f"deep. Begin with every gap at zero or above."
        )


def run(work: ContactRun, state: Array, begin: float, end: float, between: Callable[[float], None]) -> End:
    """Run from ``state`` (q, u) at ``begin`` to ``end``; ``work`` keeps the log. Return how the run ended."""
    it = work.it
    it.y[:], it.t = [*state, 0.0, 0.0], begin
    it.stage, it.stale, it.most_phases = event_run.ARRIVE, 1, event_run.PHASES
    check_apart(work, np.array(it.y), work.look(begin, np.array(it.y)))
    loop, steps, clock = code("go_on"), FIRST, perf_counter()
    it.budget = steps
    try:
        while True:
            it.target = work.blows[0][0] if work.blows else end
            answer = loop(it, work.steps, work.problem)
            while answer >= event_run.GROW:
                if answer == event_run.PAUSE:
                    pace = steps / max(perf_counter() - clock, 1e-6)
                    steps, clock = max(16, min(4 * steps, int(PIECE * pace))), perf_counter()
                    it.budget = steps
                    between(it.t)
                answer = answered(work, answer) or loop(it, work.steps, work.problem)
            if answer != End.FINISHED or not (work.blows and work.blows[0][0] <= it.t):
                return ENDS[answer]
            while work.blows and work.blows[0][0] <= it.t:
                struck(work, work.blows.pop(0)[1])
            it.reason[:], it.stage = event_run.BLOW, event_run.ARRIVE
    except KeyboardInterrupt:
        return interrupted(work)


def interrupted(work: ContactRun) -> End:
    """End a run, with the steps of its present phase, at a pause."""
    code("break_off")(work.it, End.INTERRUPTED)
    return End.INTERRUPTED


def answered(work: ContactRun, question: int) -> int:
    """Do what the loop asks for; return the end of the run, or 0 if the loop goes on."""
    it = work.it
    if question == event_run.GROW:
        work.make_room(4 * it.needed + 6)
    elif question == event_run.LONGER:
        work.longer_log()
    elif question == event_run.ASK_MODES:
        ask_modes(work)
    elif question == event_run.ASK_SIDES:
        leaving = work.begins_to_leave(np.array(it.free) + it.force @ np.array(it.X).reshape(it.rows, -1))
        it.left[leaving] = 1
        if leaving:  # from rest at the end of its side: from now on the corner touches
            it.stage, it.stale = event_run.DECIDE, 1
    elif question == event_run.STRUCK:
        blows(work)
    elif question == event_run.ASK_SHARES:
        check_shared(work)
        return int(it.then)
    elif question == event_run.ASK_IMPACT:
        check_impact(work)
    elif question != event_run.PAUSE:
        raise refusal(work, question)
    return 0


def ask_modes(work: ContactRun) -> None:
    """Write the modes that the comparison of all sets gives, and their forces."""
    it, chosen = work.it, work.chosen()
    with _DECIDING:
        modes, one = modes_at(work)
    it.mode[:] = [NUMBERS[mode] for mode in modes]
    it.way[:], it.force[:] = 0.0, 0.0
    if one is not None:
        at = 0
        for k, (_, d) in zip(chosen, one.modes, strict=True):
            if d is not None:
                it.way[k, : len(d)] = d
            size = 1 + work.scene.tangents[k]
            it.force[work.scene.first[k] :][:size] = one.forces[at : at + size]
            at += size
    it.stage = it.then


# -- blows -----------------------------------------------------------------------------------------------


def struck(work: ContactRun, blow: Blow) -> None:
    """Let a blow act. Approaching contacts then collide, as after any impact."""
    it = work.it
    after, gained, told = strike(work.kernels, work.values, it.t, np.array(it.y), blow)
    it.y[:] = after
    it.impulses += gained
    it.bounces, it.stale = 0, 1
    tell(work, told)


def tell(work: ContactRun, told: object) -> None:
    """Add a happening to the log."""
    it = work.it
    work.longer_log()
    work.told.append(told)
    it.marks[it.marked : it.marked + 4] = event_run.TOLD, 4, it.numbered, len(work.told) - 1
    it.marked += 4


def blows(work: ContactRun) -> None:
    """Let the blows act whose events end the phase."""
    search, count = work.steps.search, work.steps.events
    for number, time in zip(search.log_numbers[:count], search.log_times[:count], strict=True):
        which = int(number) - work.asked
        if 0 <= which < len(work.called) and time == work.it.t and work.counts[which] > 0:
            work.counts[which] -= 1
            struck(work, work.called[which])


# -- refusals --------------------------------------------------------------------------------------------


def check_impact(work: ContactRun) -> None:
    """Raise if other distributions of the impulses of the last impact would change the motion."""
    *_, last = (entry for entry in History(work, End.RUNNING).entries() if entry.kind == event_run.IMPACT)
    hit = impact_of(work, last.marks, last.numbers)
    if hit.open:
        names = ", ".join(f"'{work.names[k]}'" for k in hit.chosen)
        raise SimulationError(
            f"Impact at t = {hit.t:.9g} s of '{work.model.name}': the impulses of contacts {names} are statically "
            f"indeterminate, and each distribution moves the machine differently through its friction. Change the "
            f"friction or the shapes, or take indeterminate='compliance', which decides for the limit of equal "
            f"compliance at all contacts."
        )


def check_shared(work: ContactRun) -> None:
    """Raise if the friction of indeterminate forces would decide the motion of the last phase."""
    it = work.it
    modes = tuple(KINDS[mode] for mode in it.mode)
    first, last = it.first_row, it.logged - 1
    count = last - first + 1
    for i in np.unique([*range(min(count, LOOKS)), *np.linspace(0, count - 1, LOOKS).astype(int)]):
        t, y = float(it.times[first + i]), np.array(it.states[(first + i) * it.n_y :][: it.n_y])
        if work.decides(modes, t, y):
            names = ", ".join(f"'{work.names[k]}'" for k, mode in enumerate(it.mode) if mode != OPEN)
            raise SimulationError(
                f"The normal forces of contacts {names} at t = {t:.9g} s are statically indeterminate, and with "
                "different friction, or a turn as they slide, each distribution moves the machine differently. Give "
                "them equal friction, or fewer contacts, or take indeterminate='compliance'."
            )


def refusal(work: ContactRun, why: int) -> SimulationError:
    """Return the error for what cannot go on."""
    it, model, t = work.it, work.model.name, work.it.t
    chosen = work.chosen()
    names = ", ".join(f"'{work.names[k]}'" for k in chosen)
    units = [one.units["slip"] for one in work.model.contacts]
    speeds = [it.rate[work.scene.first[k]] for k in chosen]
    impact = f"Impact at t = {t:.9g} s of '{model}': "
    h = float(np.max(it.lengths[it.first_row : it.logged - 1], initial=0.0))
    start = float(it.times[it.first_row]) if it.logged else t
    if why == event_run.TOO_MANY:
        current = [KINDS[mode] for mode in it.mode]
        states = ", ".join(f"{a}: {b}" for a, b in zip(work.names, current, strict=True))
        return SimulationError(
            f"Contacts of '{model}' change their modes again and again at t = {t:.9g} s ({states}), {it.phases} phases "
            f"so far. Impacts that end in a finite time only together (restitution of several contacts at once; a coin "
            f"that comes to lie flat on its two edges) do this: method='timestepping' with step= goes through them."
        )
    if why == event_run.MIXED:
        return SimulationError(
            f"{impact}Contacts {names} collide at once, some by Newton's and some by Poisson's law. Give them the same "
            f"law: impact='newton' or 'poisson'."
        )
    if why == event_run.NO_IMPULSES:
        approach = ", ".join(
            f"'{work.names[k]}' ({v:.6g} {units[k]})" for k, v in zip(chosen, speeds, strict=True)
        )
        return SimulationError(
            f"{impact}No impulses were found that satisfy Coulomb friction at contacts {approach} (approach speed "
            f"along the normal), even without restitution: a law is still violated by {work.problem.residual:.3g} of "
            f"the greatest speed. Less friction, or impacts='sequential', makes the problem easier."
        )
    if why == event_run.SEQUENCE:
        fastest = float(np.min(it.x[np.cumsum([0, *(1 + work.scene.tangents[k] for k in chosen[:-1])])]))
        return SimulationError(
            f"{impact}The sequence of impacts at contacts {names} did not end after {event_run.PASSES} impacts: the "
            f"fastest contact still approaches at {-fastest:.3g} {units[chosen[0]]}. Use impacts='simultaneous'."
        )
    if why == event_run.TURNED:
        return SimulationError(
            f"Contact '{work.names[it.blame]}' of '{model}' changed its sense of slip between {start:.9g} and {t:.9g} "
            f"s within one step of {h:.3g} s, and was passed over. Give a max_step shorter than that, or take "
            f"method='timestepping' with step=."
        )
    if why == event_run.PASSED_OVER:
        return SimulationError(
            f"Contact '{work.names[it.blame]}' of '{model}' closed between {start:.6g} and {t:.6g} s within one step "
            f"of {h:.3g} s, and was passed over: it is {-it.gap[it.blame]:.3g} m deep. Give a max_step shorter than "
            f"that contact lasts, or take method='timestepping' with step=."
        )
    assert why == event_run.UNDECIDED
    closed = ", ".join(f"'{work.names[k]}'" for k in chosen if it.mode[k] != OPEN)
    return SimulationError(
        f"Contacts {closed} at t = {t:.9g} s are statically indeterminate: friction, shared in proportion to N, "
        f"has reached μ_s N, and the motion does not determine the shares beyond that. Rest the "
        f"body on fewer contacts, describe it in its plane of motion, or use method='timestepping'."
    )
