"""Errors for what a motion with contacts cannot go on from, in the user's names, with the cure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...errors import SimulationError
from ..cones.contacts import AWAY, FORWARDS, PRESSED, Contacts
from ..events import event_run, limits
from ..ode.dense_output import observe
from ..phase.laws import OPEN
from ..phase.phase import KINDS
from ..start.loaded_joints import jammed, struck_load
from .state import ContactRun

BEFORE = 0.9
"""Part of the last phase after which a force that grows without bound has grown by `limits.GROWN`."""


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
    if why == event_run.TOO_MANY and it.crowd <= limits.ENDLESS:
        return SimulationError(
            f"The motion of '{model}' has more than {it.most_phases} phases between events up to t = {t:.9g} s, as "
            "many as a run keeps. Go on from an earlier end, or take method='timestepping' with step=."
        )
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
            f"{impact}The sequence of impacts at contacts {names} did not end after {limits.PASSES} impacts: the "
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
        f"The motion of '{work.model.name}' does not move on: {limits.STALL} steps led from t = {it.crept_from:.9g} "
        f"to {it.t:.9g} s (contacts: {names}). Forces hold it between motions that lead back to the same state."
        f"{flat(work, closed)}{_explicit(work)} method='timestepping' with step= goes through such states."
    )


def _explicit(work: ContactRun) -> str:
    """Return the cure for steps that a method of order 5 has made short. "auto" is "dop853" or has changed to radau."""
    if work.method not in ("dop54", "tsit5"):
        return ""
    return (
        f" If its forces are stiff, as where a slip begins, method='auto' has implicit steps where '{work.method}' "
        "has short ones."
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


def dynamic_jam(work: ContactRun) -> str:
    """Return why a run ended if a normal force grew without bound at the end of its last phase, else "".

    There A_NN - μ d·A_NT, beside the other contacts and joints, falls to zero: N is inversely proportional to it
    (F. Génot, B. Brogliato, New results on Painlevé paradoxes, 1999).
    """
    it = work.it
    rigid = [
        work.scene.first[k] for k, c in enumerate(work.model.contacts) if not c.held and it.mode[k] != OPEN
    ]
    rows = slice(it.first_row, it.logged)
    times, states = (
        np.array(it.times[rows]),
        np.array(it.states[: it.logged * it.n_y]).reshape(-1, it.n_y)[rows],
    )
    forces = np.abs(observe(it.forces, it.rows, times, states, work.memory.phase)[:, rigid])
    before = times <= times[0] + BEFORE * (times[-1] - times[0])
    if not rigid or before.all():
        return ""
    early, late = np.nanmax(forces[before]), np.nanmax(forces, axis=0)
    most = int(np.argmax(late))
    if not late[most] > limits.GROWN * early > 0:
        return ""
    name = work.names[[k for k in range(it.contacts) if work.scene.first[k] == rigid[most]][0]]
    return (
        f"The motion of '{work.model.name}' leads into a jam at t = {it.t:.9g} s: the normal force of contact '{name}' "
        f"grew from {early:.3g} N to {late[most]:.3g} N in the last {times[-1] - times[before][-1]:.3g} s, and without "
        "bound. The friction that it brings presses the contact on by as much as N holds it off, so that rigid bodies "
        "have no motion beyond (Painlevé). Less friction, or another direction of slip, avoids it; "
        "method='timestepping' with step= passes it by an impulse. The motion up to there is error.trajectory."
    )


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
    state = zip(work.model.state_names, np.array(it.y).tolist(), strict=False)
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
