"""The loop from event to event, in compiled code. It returns to Python for what it cannot decide, and goes on there.

arrive     impacts; bounces too low to follow end; gaps and speeds are corrected
decide     modes, from the contact problem of the accelerations
set up     equations of the modes; the first moment of a slip in space
follow     steps of the integrator up to the next event
halt       the last moment of a slip in space
"""

from __future__ import annotations

from ...native.instructions import compiled
from ..cones.contacts import Contacts
from ..ode.layout import RUNNING
from ..ode.run import Run
from . import event_run
from .event_run import EventRun
from .log import log_phase, log_state, room_for_event
from .moment import look
from .slips.slip_ends import resolve_slips
from .stages.event_stages import arrive, collision, correct, decision, setting
from .stages.phase_stages import follow, launch, stop_slips


@compiled
def go_on(it: EventRun, run: Run, contacts: Contacts) -> int:
    """Go on with the run; return how it ended (`End`), or why Python is asked."""
    code = RUNNING
    resolve_slips(it, run)
    while code == RUNNING:
        code = pass_stage(it, run, contacts)
    return code


@compiled
def pass_stage(it: EventRun, run: Run, contacts: Contacts) -> int:
    """Pass one stage; return RUNNING, how the run ended, or why Python is asked."""
    code = RUNNING
    if it.stage != event_run.FOLLOW:
        code = ready(it, contacts)
        if code != RUNNING:
            return code
    if it.stage == event_run.ARRIVE:
        code = arrive(it)
    elif it.stage == event_run.COLLIDE:
        code = collision(it, contacts)
    elif it.stage == event_run.CORRECT:
        correct(it, contacts)
    elif it.stage == event_run.DECIDE:
        code = decision(it, contacts)
    elif it.stage == event_run.SET_UP:
        code = setting(it, contacts)
    elif it.stage == event_run.LAUNCH:
        code = launch(it, run, contacts)
    elif it.stage == event_run.FOLLOW:
        code = follow(it, run, contacts)
    else:
        code = stop_slips(it, run, contacts)
    return code


@compiled
def ready(it: EventRun, contacts: Contacts) -> int:
    """Return RUNNING if there is room for a stage at an event, with the contacts looked at, or why Python is asked."""
    if it.budget <= 0 or it.stop != 0:
        return event_run.PAUSE
    it.budget -= 1
    if room_for_event(it) == 0:
        return event_run.LONGER
    if it.stale != 0:
        look(it)
        it.stale = 0
    if 2 * it.needed + 3 > contacts.most and contacts.most < it.rows:
        return event_run.GROW
    return RUNNING


@compiled
def break_off(it: EventRun, status: int) -> None:
    """Log the phase that is interrupted, or an empty one."""
    if it.stage != event_run.FOLLOW:
        it.first_row = it.logged
    log_state(it, it.t, it.y, 0.0)
    log_phase(it, status, 0, 0, 0, event_run.STEPS)
