"""Laws of loads that switch (`kernels.switching`) in a run from event to event, in compiled code.

A switch ends a phase: forces jump, so that the modes of contacts are decided anew. Where contacts hold a body, an e is
zero but for round-off, and its law is at rest.
"""

from __future__ import annotations

from ...native.instructions import compiled, greater
from ..kernels.sided_run import SidedRun
from ..kernels.switching import OTHER_SIDES, is_quiet, judge, look_back, renew, see, settle, switch
from ..ode.layout import FINISHED, STUCK
from ..ode.run import Run
from ..phase.phase_record import PhaseData
from .event_run import SMALL, STEPS, EventRun
from .jumps import SAME
from .log import log_phase, log_state
from .moment import largest


@compiled
def take_sides(it: EventRun) -> None:
    """Let all that is computed follow the sides."""
    renew(SidedRun(it.sided))
    show_sides(it)
    it.stale = 1


@compiled
def show_sides(it: EventRun) -> None:
    """Write how far each law is from its switch into the functions that are watched."""
    s, phase = SidedRun(it.sided), PhaseData(it.phase)
    for k in range(it.laws):
        phase.sides[k], phase.bands[k], phase.idle[k] = s.sides[k], s.bands[k], s.idle[k]


@compiled
def see_laws(it: EventRun) -> None:
    """Evaluate all laws at the present moment, by the rates of the phase."""
    it.rates(it.t, it.y, it.phase, it.step)
    see(SidedRun(it.sided), it.t, it.y, it.step)


@compiled
def settle_sides(it: EventRun) -> None:
    """Give laws whose e has jumped over zero, as a speed does in an impact, their other side."""
    if it.laws > 0:
        it.rates(it.t, it.y, it.phase, it.step)
        if settle(SidedRun(it.sided), it.t, it.y, it.step, it.near) != 0:
            take_sides(it)
        show_sides(it)


@compiled
def judge_sides(it: EventRun) -> int:
    """Judge the sides by the rates of the phase (`switching.judge`)."""
    s = SidedRun(it.sided)
    see_laws(it)
    why = judge(s, it.near, SMALL * (1.0 + largest(it.step[it.n_q :], it.n)))
    if why == OTHER_SIDES:
        take_sides(it)
    show_sides(it)
    return why


@compiled
def switch_laws(it: EventRun, run: Run) -> int:
    """Let the laws switch whose events end the phase; return their number."""
    s, search, found = SidedRun(it.sided), run.search, 0
    steps, first = it.logged - it.first_row - 1, it.times[it.first_row]
    for e in range(run.events):
        k = search.log_numbers[e] - it.first_law
        if 0 <= k < it.laws:
            if found == 0:
                see_laws(it)
            change = abs(s.seen[3 * k + 1]) * (it.t - first)
            quiet = is_quiet(s, k, it.t, it.y, change) if steps <= 2 else 0
            look_back(s, k, it.t, quiet)
            switch(s, k)
            found += 1
    if found > 0:
        take_sides(it)
    return found


@compiled
def leave_idle(it: EventRun, run: Run) -> None:
    """Let the search for events leave laws that do not count."""
    for k in range(it.laws):
        run.search.unjudged[it.first_law + k] = SidedRun(it.sided).idle[k]


@compiled
def stick(it: EventRun) -> int:
    """End the run at the switch of a law that no side leads away, or where it is to end, if that is there."""
    code: int = STUCK
    if it.target - it.t <= SAME * greater(1.0, abs(it.t)):
        code, it.t = FINISHED, it.target
    it.first_row, it.blame = it.logged, SidedRun(it.sided).stuck
    log_state(it, it.t, it.y, 0.0)
    log_phase(it, code, 0, 0, 0, STEPS)
    return code
