"""Motion with contacts, from event to event.

    between events   the usual loop integrates the compiled equations of one set of modes (open, stick, slip)
    events           a gap closes, N falls to zero, |T| reaches μ_s N, the slip stops, a contact leaves its surface
    at an event      impulses if contacts approach (`impacts`), then modes from the contact problem of the
                     accelerations (`decision`)

All this is one compiled loop (`event_loop`), which returns to be asked again: with a longer log, for progress, and for
a blow.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import compress
from typing import Any

import numpy as np

from ...dynamics.bearing_loads import shared
from ...dynamics.state import float_state
from ...errors import SimulationError
from ..cones.contacts import AWAY, FORWARDS, PRESSED, Contacts
from ..ending import ENDS, End
from ..events import event_run
from ..events.code import code
from ..legs.blow import Blow, happening_of, hit_by, speeds_after
from ..ode.dense_output import Array, outputs_at
from ..phase.laws import CLOSED, OPEN
from ..phase.scene import KINDS
from ..phase.snapshot import Snapshot
from ..start.fitting import refuse_misfits
from ..start.loaded_joints import check_blows, jammed, struck_load
from ..start.overlap import refuse_overlap, sides_of
from ..trajectory.progress import Progress
from .state import ContactRun

FEW = 1 << 10
"""Steps and stages of events, over the number of rows of all contacts, before a thread is worth it."""


def check_apart(work: ContactRun, y: Array, seen: Snapshot) -> None:
    """Raise if bodies are inside each other in the initial state, or a round shape does not fit what it touches."""
    refuse_misfits(work.model, work.values)
    near = CLOSED * (1 + float(np.abs(y[: work.n]).max(initial=0)))
    rigid = (seen.reach >= 0) & (np.array(work.scene.compliant) == 0) & (np.array(work.scene.presser) < 0)
    gaps = zip(compress(work.names, rigid), seen.gap[rigid], strict=False)
    refuse_overlap(work.model.name, gaps, near, sides=sides_of(work.model.contacts))


def run(work: ContactRun, state: Array, begin: float, end: float, between: Progress) -> End:
    """Run from ``state`` (q, u) at ``begin`` to ``end``; ``work`` keeps the log. Return how the run ended."""
    it, memory = work.it, work.memory
    it.y[:], it.t = [*state, 0.0, 0.0], begin
    it.stage, it.stale, it.most_phases = event_run.ARRIVE, 1, event_run.PHASES
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
                few = few if long else min(2 * few, event_run.NO_PAUSE)
                it.budget = few  # a thread for the few stages after each answer would take longer than these
                if answer == event_run.PAUSE and long:
                    it.budget = event_run.NO_PAUSE
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
        return interrupted(work)


def interrupted(work: ContactRun) -> End:
    """End a run, with the steps of its present phase, at a pause."""
    code("break_off")(work.it, End.INTERRUPTED)
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
    search, count = work.memory.steps.search, work.memory.steps.events
    numbers = search.log_numbers[:count][search.log_times[:count] == it.t]
    numbers -= len(work.specs) + work.scene.laws
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
    y = np.array(it.y)
    state = float_state(
        model, y[: model.n_q].tolist(), y[model.n_q :][: model.n_u].tolist(), it.t, work.values
    )
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
    search, count = work.memory.steps.search, work.memory.steps.events
    for number, time in zip(search.log_numbers[:count], search.log_times[:count], strict=True):
        which = int(number) - work.asked
        if 0 <= which < len(work.called) and time == work.it.t and work.counts[which] > 0:
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
    before, energy = np.sign(watched(work, y)), work.energies(it.t, y).sum()
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
    after, ends = np.sign(watched(work, y)), False
    for k in np.flatnonzero(before * after < 0):
        spec, sign = work.specs[k], int(after[k])
        if spec.direction not in (0, sign):
            continue
        if k < work.asked:
            work.memory.fit_entry()
            code("log_crossing")(it, it.t, k, sign, y)
            ends |= spec.terminal
        elif work.counts[k - work.asked] > 0:
            work.counts[k - work.asked] -= 1
            struck(work, work.called[k - work.asked])
    if ends:
        code("break_off")(it, End.TERMINAL)
    return ends


def watched(work: ContactRun, y: Array) -> Array:
    """Return the functions of the user's events, and of those that call blows."""
    program, phase = work.memory.program, work.memory.phase
    outputs = outputs_at(program.address("watched"), program.outputs("watched"), work.it.t, y, phase)
    return outputs[: len(work.specs)]


# -- refusals --------------------------------------------------------------------------------------------


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
        shut = [(name, KINDS[mode]) for name, mode in zip(work.names, it.mode, strict=True) if mode != OPEN]
        states = ", ".join(f"{name}: {mode}" for name, mode in shut) or "all open"
        on = [k for k, c in enumerate(work.model.contacts) if c.stands and abs(it.gap[k]) < it.near]
        return SimulationError(
            f"Contacts of '{model}' change their modes again and again at t = {t:.9g} s ({states}), {it.phases} phases "
            f"so far. Impacts that end in a finite time only together (restitution of several contacts at once; a coin "
            f"that comes to lie flat on its two edges) do this: method='timestepping' with step= goes through them."
            f"{flat(work, on)}"
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
        rest = work.memory.problem.residual
        return SimulationError(
            f"{impact}No impulses were found that satisfy Coulomb friction at contacts {approach} (approach speed "
            f"along the normal), even without restitution: a law is still violated by {rest:.3g} of "
            f"the greatest speed. Less friction, or impacts='sequential', makes the problem easier."
        )
    if why == event_run.LOADED_IMPACT:
        return struck_load(
            work.model,
            f"{impact}Contacts {names} collide one after another.",
            "Take impacts='simultaneous', or give the joint torque= or force=.",
        )
    if why == event_run.JAMMED:
        return jammed(work.model, t)
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
    if why == event_run.NO_STATE:
        return SimulationError(
            f"The motion of '{model}' has no finite state at the event at t = {t:.9g} s, in a step from {start:.9g} s, "
            "as where slips lose their direction. Change the start a little, or take method='timestepping' with step=."
        )
    if why == event_run.NO_VALUE:
        what = "gap" if it.mode[it.blame] == OPEN else "friction or force"
        return SimulationError(
            f"The {what} of contact '{work.names[it.blame]}' of '{model}' has no value just after t = {t:.9g} s. A "
            "root or logarithm of a negative number, or 0/0, in its shape or its laws does this: write laws that have "
            "a value wherever it touches, give a line ends, between=, or stop before with a terminal event."
        )
    if why == event_run.PASSED_OVER:
        return SimulationError(
            f"Contact '{work.names[it.blame]}' of '{model}' closed between {start:.6g} and {t:.6g} s within one step "
            f"of {h:.3g} s, and was passed over: it is {-it.gap[it.blame]:.3g} m deep. Give a max_step shorter than "
            f"that contact lasts, or take method='timestepping' with step=.{flat(work, [it.blame])}"
        )
    if why == event_run.PARTED:
        return SimulationError(
            f"Contact '{work.names[it.blame]}' of '{model}' followed from the others at t = {it.held_from:.9g} s, as "
            f"at a dead centre, and no longer at {t:.9g} s, where its gap is {it.gap[it.blame]:.3g} m. No set of modes "
            "leads from there. Change the start a little, or take method='timestepping' with step=."
        )
    if why in (event_run.NO_MOTION, event_run.SEVERAL):
        return paradox(work, why)
    return open_shares(work, why)


def stalled(work: ContactRun) -> SimulationError:
    """Return the error for a run whose steps do not move on."""
    it = work.it
    closed = [k for k, mode in enumerate(it.mode) if mode != OPEN]
    names = ", ".join(f"'{work.names[k]}'" for k in closed) or "open"
    return SimulationError(
        f"The motion of '{work.model.name}' does not move on: {event_run.STALL} steps led from t = {it.crept_from:.9g} "
        f"to {it.t:.9g} s (contacts: {names}). Forces hold it between motions that lead back to the same state."
        f"{flat(work, closed)} method='timestepping' with step= goes through such states."
    )


def flat(work: ContactRun, contacts: Sequence[int]) -> str:
    """Return a sentence on disks in space among contacts: what touches in place of their edge when they lie flat."""
    for k in contacts:
        shapes = work.model.contacts[k].feature, work.model.contacts[k].surface
        if work.scene.tangents[k] == 2 and any(shape.bound == "edge" for shape in shapes):
            return (
                f" The edge of a disk, as of '{work.names[k]}', touches at its lowest point, which jumps where the "
                "disk lies flat: give it points along the edge, body.corners(...), which carry it like a face, or end "
                "the motion before, with a terminal event."
            )
    return ""


def open_shares(work: ContactRun, why: int) -> SimulationError:
    """Return the error for indeterminate forces that are refused."""
    it, model, t = work.it, work.model.name, work.it.t
    chosen = ", ".join(f"'{work.names[k]}'" for k in work.chosen())
    closed = ", ".join(f"'{work.names[k]}'" for k, mode in enumerate(it.mode) if mode != OPEN)
    cure = "take indeterminate='compliance', which decides for the limit of equal compliance at all contacts."
    if why == event_run.OPEN_IMPULSES:
        return SimulationError(
            f"Impact at t = {t:.9g} s of '{model}': the impulses of contacts {chosen} are statically indeterminate, "
            f"and each distribution moves the machine differently through its friction. Change the friction or the "
            f"shapes, or {cure}"
        )
    if why == event_run.OPEN_FORCES:
        return SimulationError(
            f"The normal forces of contacts {closed} of '{model}' at t = {t:.9g} s are statically indeterminate, and "
            f"each distribution moves the machine differently through its friction. Give them equal friction, or rest "
            f"the body on fewer contacts (three in space, two in a plane), or {cure}"
        )
    assert why == event_run.UNDECIDED
    return SimulationError(
        f"Contacts {closed} at t = {t:.9g} s are statically indeterminate: friction, shared in proportion to N, "
        f"has reached μ_s N, and the motion does not determine the shares beyond that. Rest the "
        f"body on fewer contacts, describe it in its plane of motion, or use method='timestepping'."
    )


def paradox(work: ContactRun, why: int) -> SimulationError:
    """Return the error for a state in which no motion, or several, satisfy the laws of rigid contact."""
    it, problem, seen, chosen = work.it, work.memory.problem, work.seen(), work.chosen()
    state = zip(
        (*work.model.coordinate_names, *work.model.speed_names), np.array(it.y).tolist(), strict=False
    )
    where = ", ".join(f"{name} = {x:.6g}" for name, x in state)
    criteria, alone = [], []
    undefined = [f"'{work.names[k]}'" for k in chosen if not np.isfinite(seen.friction[k])]
    if undefined:
        return SimulationError(
            f"The friction of {' and '.join(undefined)} of '{work.model.name}' has no finite value at t = {it.t:.9g} "
            f"s. Configuration: {where}. Write a law that has one wherever the contact is closed."
        )
    for i, k in enumerate(chosen):
        at, n = work.scene.first[k], work.scene.tangents[k]
        row = seen.between(range(at, at + 1 + n))[0]
        way = np.array(problem.way[2 * i : 2 * i + n])
        along = float(way @ row[1:]) if problem.slides[i] else float(np.linalg.norm(row[1:]))
        alone.append(row[0] - seen.friction[k] * along)
        criteria.append(f"{work.names[k]}: A_NN - mu d.A_NT = {alone[-1]:.6g} 1/kg")
    what = "no set of modes is consistent"
    if why == event_run.SEVERAL:
        tried, count = np.array(problem.tried), len(chosen)
        sets = (
            ", ".join(f"{work.names[k]}: {mode_tried(problem, i, modes[i])}" for i, k in enumerate(chosen))
            for modes in (tried[count : 2 * count], tried[:count])
        )
        what = f"different motions are consistent, {' or '.join(f'({one})' for one in sets)}"
    if min(alone) > 0:
        criteria.append("which are, but beside each other the contacts fail it: one presses another one away")
    return SimulationError(
        f"Contacts of '{work.model.name}' at t = {it.t:.9g} s: {what}. Rigid bodies with Coulomb friction do not "
        f"decide what happens there (Painlevé); the criterion is the normal acceleration per unit of normal force, "
        f"which must be positive: {', '.join(criteria)}. Configuration: {where}. Less friction, or another direction "
        f"of slip, has one motion.{flat(work, chosen)}"
    )


def mode_tried(problem: Contacts, i: int, mode: int) -> str:
    """Return the name of a mode of a combination."""
    if mode != PRESSED:
        return {AWAY: "open", FORWARDS: "slip+"}.get(mode, "slip-")
    rests = problem.slides[i] == 0 and problem.static[i] > 0 and problem.tangents[i] > 0
    return "stick" if rests else "slip"
