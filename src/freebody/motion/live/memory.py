"""Memory of a live motion: what a caller writes, the motion that it reads, and everything between.

Nothing in this file needs a compiler.
"""

from __future__ import annotations

from typing import Annotated

from ...native.records import Count, Kernel, Real, Record, Row, Rows, Whole, Wholes, record
from ..ode.run import Run
from ..start.closing_record import Closing

OTHERS = 5
"""A result of closing besides those of `closing_record`: other conditions are independent than at the export."""


DEEP, TOO_MANY_PHASES = 120, 121
"""Ends of a run besides those of `ending.End` and `events.event_run`: a contact is below its surface at the start; more
phases than there is room for."""


@record
class Touching(Record):
    """Memory of a motion with contacts, from event to event (`touching`).

    ``run``, ``problem``       memory of an `EventRun` and of its contact problem (`Contacts`)
    ``fresh``                  the first of these as it is before all runs; ``kept``: 1 if it is written
    ``phase``, ``looking``     memory of the present phase, and of the functions of all contacts (`PhaseData`)
    ``of_phase``, ``of_looking``    places in these of the constants of kernels
    ``observing``              kernel of what a caller wants to see, of the state in the present phase
    ``sides``                  of laws that switch, in the phase that is shown
    ``fades``                  power of two by which there are fewer frames than at first
    ``log_*`` and so on        rows of the run
    """

    run: Row
    problem: Row
    fresh: Annotated[Row, "n_fresh"]
    n_fresh: Count
    kept: Whole
    observing: Kernel
    fades: Whole
    phase: Row
    looking: Row
    of_phase: Annotated[Wholes, "n_of_phase"]
    n_of_phase: Count
    of_looking: Annotated[Wholes, "n_of_looking"]
    n_of_looking: Count
    ending: Annotated[Wholes, "n_endings"]
    place: Annotated[Wholes, "n_endings"]
    final: Annotated[Wholes, "n_final"]
    signs: Annotated[Wholes, "n_final"]
    ways: Annotated[Wholes, "n_final"]
    crossed_at: Annotated[Row, "n_final"]
    watch: Annotated[Row, "n_watched"]
    watch_later: Annotated[Row, "n_watched"]
    sides: Annotated[Row, "n_laws"]
    marks: Annotated[Wholes, "n_marks"]
    numbers: Annotated[Row, "n_numbers_logged"]
    times: Annotated[Row, "n_logged"]
    lengths: Annotated[Row, "n_logged"]
    states: Annotated[Row, "n_states_logged"]
    event_times: Annotated[Row, "n_found"]
    event_numbers: Annotated[Wholes, "n_found"]
    event_signs: Annotated[Wholes, "n_found"]
    event_states: Annotated[Rows, "n_found", "n"]


@record
class Live(Record):
    """A motion y' = f(t, y; p) from y(start) to ``until``.

    Written by the caller:

    ``parameters``    p, in the order of the machine
    ``given``, ``initial``    1 for each component of the state whose start the caller gives, and these values; all
                      others are those of the machine, which may be expressions of p
    ``start``, ``until``    times of the start and of the end [s]
    ``tolerances``    relative tolerance of each component of the state
    ``most_steps``, ``most_frames``    greatest numbers of steps and of frames, at most those that there is room for
    ``evenly``        1 for frames at equal distances of time, 0 for a fixed number of frames in each step
    ``dense``         1 for frames from the dense output, which is faster; 0 for frames as accurate as the steps

    Read by the caller:

    ``status``        how the run ended (`ending.End`), or RUNNING if there was none
    ``fault``         first of the conditions on p that does not hold, or -1
    ``closed``        result of closing (`closing_record`), or `OTHERS`
    ``worst``         condition with the greatest residual
    ``blame``         component, or event function, to blame for a run that failed
    ``reached``       time of the end of the run [s]
    ``steps``, ``rejected``, ``evaluated``    work of the run
    ``frames``, ``times``, ``states``, ``outputs``    number of frames; time, state and outputs of each
    ``events``, ``event_times``, ``event_numbers``, ``event_signs``, ``event_states``    events in order of time
    ``answers``       numbers that depend on p and on the start
    ``phases``, ``phase_times``, ``phase_frames``, ``modes``    of a machine with contacts: number of phases; of each,
                      its start, its first frame, and the modes of all contacts (`phase.laws`)

    The rest is the machine's: number of coordinates and speeds (``n_state``), kernels, and memory of
    `gauss_newton.close` and of the run. ``hoisted`` are the parameters that the run goes on with (`kernels.hoisted`).
    """

    start: Real
    until: Real
    most_steps: Whole
    most_frames: Whole
    evenly: Whole
    dense: Whole
    status: Whole
    fault: Whole
    closed: Whole
    worst: Whole
    blame: Whole
    reached: Real
    steps: Whole
    rejected: Whole
    evaluated: Whole
    frames: Whole
    events: Whole
    parameters: Annotated[Row, "n_parameters"]
    initial: Annotated[Row, "n"]
    given: Annotated[Wholes, "n"]
    tolerances: Annotated[Row, "n"]
    times: Annotated[Row, "room_of_frames"]
    states: Annotated[Rows, "room_of_frames", "n"]
    outputs: Annotated[Rows, "room_of_frames", "n_outputs"]
    answers: Annotated[Row, "n_answers"]
    phases: Whole
    phase_times: Annotated[Row, "room_of_phases"]
    phase_frames: Annotated[Wholes, "room_of_phases"]
    modes: Annotated[Wholes, "room_of_modes"]
    event_times: Annotated[Row, "room_of_events"]
    event_numbers: Annotated[Wholes, "room_of_events"]
    event_signs: Annotated[Wholes, "room_of_events"]
    event_states: Annotated[Rows, "room_of_events", "n"]
    prologue: Count
    hoisted: Row
    beginning: Kernel
    conditions: Kernel
    answering: Kernel
    observation: Kernel
    energies: Kernel
    constants: Annotated[Row, "n_constants"]
    positive: Annotated[Row, "n_positive"]
    energy: Annotated[Row, 2]
    n_positive: Count
    room_of_steps: Count
    room_of_frames: Count
    closing: Closing
    independent: Annotated[Wholes, "n_conditions"]
    quaternions: Annotated[Wholes, "n_quaternions"]
    step_times: Annotated[Row, "room_of_piece"]
    step_lengths: Annotated[Row, "rows_of_steps"]
    step_states: Annotated[Rows, "rows_of_steps", "n"]
    n_state: Count
    n_parameters: Count
    n_constants: Count
    n_events: Count
    n_outputs: Count
    room_of_phases: Count
    room_of_events: Count
    run: Run
    viewer: Run
    touching: Touching


READ = (
    "start", "until", "most_steps", "most_frames", "evenly", "dense", "status", "fault", "closed", "worst", "blame",
    "reached", "steps", "rejected", "evaluated", "frames", "events", "parameters", "initial", "given", "tolerances",
    "times", "states", "outputs", "answers", "event_times", "event_numbers", "event_signs", "event_states",
    "phases", "phase_times", "phase_frames", "modes",
)  # fmt: skip
"""Fields of `Live` that a caller writes or reads."""
