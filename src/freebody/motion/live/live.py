"""A live motion in compiled code: close the loops, integrate, and compute the frames, in one call.

    p → c(p) → y(start) on the conditions → steps → frames → outputs

It is `step_control` with `dop853`, and `gauss_newton.close`, between what a caller writes and what it reads
(`memory.Live`); for a machine with contacts, the loop from event to event (`touching`). The same function is
compiled for WebAssembly and for this computer.
"""

from __future__ import annotations

from ...native.instructions import Compiled, Parts, address_of, greater
from ..cones.collision import collided
from ..cones.solution import find
from ..kernels.hoisted import Hoisted
from ..kernels.renewal import renew
from ..ode import dop853
from ..ode.layout import RUNNING
from ..phase import endings, phase_kernels, projection
from ..start.closing_record import MET
from ..start.gauss_newton import close
from .memory import OTHERS, Live
from .touching import run_from_event_to_event

part = Parts()
CLOSES, TOUCHES = True, False
"""Whether the machine has constraints, and contacts; without, the code that closes loops is not translated, and that
of contacts."""

piece, sample = (dop853.FUNCTIONS[name] for name in ("piece", "sample"))

FRAMES_OF_STEP = 4
"""Frames in a step. A vibration takes some ten steps: its chords miss it by a few thousandths of its amplitude."""
FEWEST = 200
"""Frames of a motion of few steps."""
TOO_MANY_STEPS = 7


@part
def first_fault(live: Live) -> int:
    """Return the first of the conditions on the parameters that does not hold, or -1."""
    live.conditions(live.start, live.initial, live.constants, live.positive)
    for i in range(live.n_positive):
        if not live.positive[i] > 0.0:
            return i
    return -1


@part
def close_loops(live: Live) -> int:
    """Move the start of the run onto the conditions; return MET, a failure of `gauss_newton.close`, or OTHERS."""
    y, closing, largest = live.run.initial, live.closing, 0.0
    size = closing.n_coordinates + closing.n_speeds
    for i in range(closing.n_coordinates):
        largest = greater(largest, abs(y[i]))
    for i in range(size):
        closing.state[i] = y[i]
    closing.t, closing.near = live.start, closing.dependent * (1.0 + largest)
    close(closing)
    live.worst = closing.worst
    if closing.status != MET:
        return closing.status
    for i in range(size):
        y[i] = closing.state[i]
    for i in range(closing.n_conditions):
        if closing.independent[i] != live.independent[i]:
            return OTHERS
    return MET


@part
def reset(live: Live) -> None:
    """Set the run to its start."""
    run = live.run
    run.t = run.start = live.start
    run.until = live.until
    run.h = run.old_error = 0.0
    run.accepted = run.rejected = run.evaluated = run.events = run.blame = run.after_rejection = 0
    run.taken = run.suspect = run.calm = run.stiffness = run.sampled = 0
    for i in range(run.n):
        run.relative[i] = run.absolute[i] = live.tolerances[i]
    run.room = live.room_of_steps if live.most_steps > live.room_of_steps else live.most_steps


@part
def scale_work(live: Live) -> None:
    """Multiply the tolerance of the work, and of the heat of friction, by the energy at the start."""
    run = live.run
    if live.energies is not None:
        live.energies(live.start, run.initial, live.constants, live.energy)
        energy = greater(abs(live.energy[0]), abs(live.energy[1]))
        for i in range(live.n_state, run.n):
            run.absolute[i] = run.relative[i] * (energy if energy > 0.0 else 1.0)


@part
def place_frames(live: Live) -> None:
    """Choose the times of the frames."""
    times, steps, last = live.run.times, live.steps, live.steps
    count = FEWEST + FRAMES_OF_STEP * steps
    if live.evenly != 0 or count > live.most_frames:
        count = live.most_frames
    if count > live.room_of_frames:
        count = live.room_of_frames
    if steps == 0:
        count = 1
    for k in range(count):
        part = k / (count - 1) if count > 1 else 0.0
        if live.evenly != 0:
            live.times[k] = times[0] + part * (times[last] - times[0])
        else:
            i = k * steps // (count - 1) if count > 1 else 0
            live.times[k] = times[i]
            if i < steps:
                live.times[k] += (part * steps - i) * (times[i + 1] - times[i])
    live.times[count - 1] = times[last]
    live.frames = count


@part
def show(live: Live) -> None:
    """Compute states and outputs of the frames."""
    live.run.sampled = 0
    sample(live.run, live.steps, live.dense, live.frames, live.times, live.states[0])
    for k in range(live.frames if live.n_outputs > 0 else 0):
        live.observation(live.times[k], live.states[k], live.constants, live.outputs[k])


@part
def simulate(live: Live) -> None:
    """Compute a motion from what the caller wrote."""
    run = live.run
    live.status, live.closed, live.worst, live.blame = RUNNING, MET, 0, 0
    live.steps = live.rejected = live.evaluated = live.frames = live.events = live.phases = 0
    live.reached = live.start
    hoisted = Hoisted(live.hoisted)
    for i in range(live.n_parameters):
        hoisted.parameters[i] = live.parameters[i]
    hoisted.programs, hoisted.prologues[0], hoisted.places[0] = 1, live.prologue, address_of(live.constants)
    renew(hoisted)
    live.fault = first_fault(live) if live.n_positive > 0 else -1
    if live.fault >= 0:
        return
    live.beginning(live.start, live.initial, live.constants, run.initial)
    for i in range(run.n):
        if live.given[i] != 0:
            run.initial[i] = live.initial[i]
    if CLOSES:
        if live.closing.n_conditions > 0:
            live.closed = close_loops(live)
        if live.closed != MET:
            return
    reset(live)
    scale_work(live)
    if live.answering is not None:
        live.answering(live.start, run.initial, live.constants, live.answers)
    if TOUCHES:
        live.status = run_from_event_to_event(live)
    else:
        run_at_once(live)


@part
def run_at_once(live: Live) -> None:
    """Run to the end, then compute the frames."""
    run = live.run
    status = piece(run)
    live.status = TOO_MANY_STEPS if status == RUNNING else status
    live.steps, live.rejected, live.evaluated = run.accepted, run.rejected, run.evaluated
    live.events, live.blame = run.events, run.blame
    live.reached = run.times[live.steps]
    place_frames(live)
    show(live)


def functions(closes: bool, touches: bool) -> dict[str, Compiled]:
    """Return the functions for machines with constraints, or without, and with contacts, or without."""
    return part.bound({**globals(), "CLOSES": closes, "TOUCHES": touches})


def called() -> dict[str, Compiled]:
    """Return the functions that the loop of a machine with contacts calls by their addresses."""
    kernels = ("looked", "rate", "rates", "acceleration", "force", "derived")
    return {
        "piece": piece, "find": find, "collided": collided,
        "projection": projection.projection, "watched": endings.watched,
        **{name: getattr(phase_kernels, name) for name in kernels},
    }  # fmt: skip


SIMULATE = functions(closes=True, touches=False)["simulate"]
SIMULATE_CONTACTS = functions(closes=True, touches=True)["simulate"]
