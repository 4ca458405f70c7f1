"""Motion with contacts, from event to event.

    between events   the usual loop integrates the compiled equations of one set of modes (open, stick, slip)
    events           a gap closes, N falls to zero, |T| reaches μ_s N, the slip stops, a contact leaves its surface
    at an event      impulses if contacts approach (`impacts`), then modes from the contact problem of the
                     accelerations (`decision`)

All this is one compiled loop (`event_loop`), which returns to be asked again: with a longer log, for progress, and for
a blow.
"""

from __future__ import annotations

from itertools import compress
from typing import Any

import numpy as np

from ...dynamics.bearing_loads import shared
from ...dynamics.state import state_at
from ..ending import ENDS, End
from ..events import event_run, limits
from ..events.code import code
from ..legs.blow import Blow, happening_of, hit_by, speeds_after
from ..ode.dense_output import Array
from ..phase.laws import CLOSED
from ..phase.scene import Snapshot
from ..start.fitting import refuse_misfits
from ..start.loaded_joints import check_blows
from ..start.overlap import refuse_overlap, sides_of
from ..trajectory.progress import Progress
from .refusals import refusal, stalled
from .state import ContactRun

FEW = 1 << 10
"""Steps and stages of events, over the number of rows of all contacts, before a thread is worth it."""


def check_apart(work: ContactRun, y: Array, seen: Snapshot) -> None:
    """Raise if bodies are inside each other in the initial state, or a round shape does not fit what it touches."""
    refuse_misfits(work.model, work.values)
    near = CLOSED * (1 + float(np.abs(y[: work.n]).max(initial=0)))
    rigid = (seen.reach >= 0) & (np.array(work.scene.compliant) == 0) & (np.array(work.scene.presser) < 0)
    names = list(work.names)
    for pair in work.model.patches:
        for k in pair.places:
            names[k] = pair.whole.name
    gaps = zip(compress(names, rigid), seen.gap[rigid], strict=False)
    refuse_overlap(work.model.name, gaps, near, sides=sides_of(work.model.contacts))


def run(work: ContactRun, state: Array, begin: float, end: float, between: Progress) -> End:
    """Run from ``state`` (q, u) at ``begin`` to ``end``; ``work`` keeps the log. Return how the run ended."""
    it, memory = work.it, work.memory
    it.y[:], it.t = [*state, 0.0, 0.0], begin
    it.stage, it.stale, it.most_phases = event_run.ARRIVE, 1, limits.PHASES
    code("forget_signs")(it)
    choose_features(work)
    check_apart(work, np.array(it.y), work.look(begin, np.array(it.y)))
    loop, few = code("go_on"), max(FEW // (1 + it.rows), 4)
    between.halt.watch(it)
    try:
        while True:
            if changed(work):
                return ENDS[End.TERMINAL]
            it.target = min(work.next_stop(), end)
            it.budget = few
            answer = loop(it, memory.steps, memory.problem)
            while answer >= event_run.GROW:
                if answer == event_run.PAUSE or it.stop:
                    between(it.t)
                answered(work, answer)
                long = between.is_long
                few = few if long else min(2 * few, limits.NO_PAUSE)
                it.budget = few  # a thread for the few stages after each answer would take longer than these
                if answer == event_run.PAUSE and long:
                    it.budget = limits.NO_PAUSE
                    answer = between.result(lambda: it.t, loop, it, memory.steps, memory.problem)
                else:
                    answer = loop(it, memory.steps, memory.problem)
            if answer != End.FINISHED or (it.t >= end and not (work.blows and work.blows[0][0] <= it.t)):
                return ENDS[answer]
            while work.blows and work.blows[0][0] <= it.t:
                struck(work, work.blows.pop(0)[1])
                it.reason[:] = event_run.BLOW
            it.stage = event_run.ARRIVE
    except KeyboardInterrupt:
        code("break_off")(it, End.INTERRUPTED)  # with the steps of its present phase, at a pause
        return End.INTERRUPTED


def answered(work: ContactRun, question: int) -> None:
    """Do what the loop asks for."""
    it = work.it
    if question == event_run.GROW:
        work.memory.make_room(4 * it.needed + 6)
    elif question == event_run.LONGER:
        work.memory.longer_log()
    elif question == event_run.STRUCK:
        blows(work)
        choose_features(work)
    elif question == event_run.OTHER_PLACES:
        choose_features(work)
    elif question == event_run.STALLED:
        code("break_off")(it, End.BROKEN_OFF)
        raise stalled(work)
    elif question == event_run.OTHER_METHOD:
        work.memory.change_method()
    elif question != event_run.PAUSE:
        raise refusal(work, question)


def choose_features(work: ContactRun) -> None:
    """Give the places of patches the features that meet now."""
    it, patches = work.it, work.patches
    if patches is None:
        return
    numbers = ended_by(work) - (len(work.specs) + work.scene.laws)
    if 0 in numbers or 1 in numbers:
        reason = event_run.GAP_CLOSED if 0 in numbers else event_run.OTHER_FEATURES
        it.reason[np.array(it.reason) == event_run.BLOW] = reason
    if patches.changed(it.t, np.array(it.y)):
        log(work, event_run.OTHER_VALUES, len(work.changes))
        work.set_values(patches.values)
        it.stale = 1


# -- blows -----------------------------------------------------------------------------------------------


def struck(work: ContactRun, blow: Blow) -> None:
    """Let a blow act. Approaching contacts then collide, as after any impact."""
    it, kernels = work.it, work.kernels
    before = np.array(it.y)
    hit = hit_by(kernels, work.values, it.t, before, blow)
    it.y[:] = speeds_after(kernels, before, hit)
    it.impulses += float(hit.energy_change)
    if it.loads > 0:
        rub(work, blow, hit)
    it.bounces, it.stale = 0, 1
    log(work, event_run.TOLD, len(work.told))
    work.told.append(happening_of(kernels, it.t, blow.name, before, np.array(it.y), hit.warnings))
    work.struck.append(blow)


def rub(work: ContactRun, blow: Blow, hit: Any) -> None:
    """Let the friction of joints act in a blow, whose reactions press them."""
    it, model = work.it, work.model
    if blow.options["restitution"] is not None:
        check_blows(
            model, [blow], "the blow has a restitution of its own, of a surface that s.contact describes"
        )
    state = state_at(model, np.array(it.y), it.t, work.values)
    blown: list[Any] = []
    for law in (contact.law for contact in model.contacts if contact.loaded):
        reaction = hit.reactions[law.joint.name]
        blown += shared(model, state, law, reaction.impulse, reaction.moment)
    if work.memory.problem.most < it.rows:
        work.memory.make_room(it.rows)
    it.blown[:] = blown
    why = code("rub")(it, work.memory.problem)
    it.blown[:] = 0.0
    if why != 0:
        raise refusal(work, why)


def log(work: ContactRun, kind: int, number: int) -> None:
    """Add an entry to the log that is one number."""
    it = work.it
    work.memory.fit_entry()
    it.marks[it.marked : it.marked + 4] = kind, 4, it.numbered, number
    it.marked += 4


def blows(work: ContactRun) -> None:
    """Let the blows act whose events end the phase."""
    for which in (ended_by(work) - work.asked).tolist():
        if 0 <= which < len(work.called):
            called(work, which)


def ended_by(work: ContactRun) -> Any:
    """Return the numbers of the functions that are zero now, at the end of a phase."""
    search, count = work.memory.steps.search, work.memory.steps.events
    return search.log_numbers[:count][search.log_times[:count] == work.it.t]


def called(work: ContactRun, which: int) -> None:
    """Let a blow act that an event calls for, if it may once more."""
    if work.counts[which] > 0:
        work.counts[which] -= 1
        struck(work, work.called[which])


# -- signals and controllers -----------------------------------------------------------------------------


def changed(work: ContactRun) -> bool:
    """Change the values that signals and controllers give now; return True if an event of the user ends the run.

    A change of a potential is work. Events whose functions jump through zero happen.
    """
    it, drives = work.it, work.drives
    y = np.array(it.y)
    if drives is None or not drives.change(it.t, y):
        return False
    before, energy = np.sign(work.watch(y)), work.energies(it.t, y).sum()
    log(work, event_run.OTHER_VALUES, len(work.changes))
    work.changed_at[len(work.changes)] = it.t, y
    work.set_values(dict(drives.numbers))
    it.most_phases += 1
    it.stale = 1
    if it.phases == 0:
        return False
    it.reason[:] = event_run.CHANGED
    if drives.potential:
        it.impulses += work.energies(it.t, y).sum() - energy
    after, ends = np.sign(work.watch(y)), False
    for k in np.flatnonzero(before * after < 0):
        spec, sign = work.specs[k], int(after[k])
        if spec.direction not in (0, sign):
            continue
        if k < work.asked:
            work.memory.fit_entry()
            code("log_crossing")(it, it.t, k, sign, y)
            ends |= spec.terminal
        else:
            called(work, int(k) - work.asked)
    if ends:
        code("break_off")(it, End.TERMINAL)
    return ends
