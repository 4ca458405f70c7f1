"""simulate: from a machine and a start to its motion.

    q' = q'(q, u),   u' = u'(t, q, u),   W' = P(t, q, u)

The rates are machine code made from the algorithms (`kernels`), the loop around them is compiled too (`dop853`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SimulationError, arguments_named, nearest
from .kernels.kernels import Kernels, kernels_of
from .kernels.methods import Way, check_method, check_method_of_contacts
from .legs.blow import blows_of, struck_path, watching_blows, watching_specs
from .legs.driven import Drives, at_time, check_signals, driven_path, refuse_switched
from .legs.failure import failure
from .legs.independent_conditions import Holding, check_redundant
from .ode import dense_output as runs
from .ode.dense_output import Path, Rates
from .plain import PlainRun, plain_run, scaled
from .start.arguments import STORED, check_heeded, check_numbers, check_steps, is_number, most_steps
from .start.initial import asks_for_many, initial_state, number
from .start.loop_closure import closed_start
from .trajectory.event import expressions_of, specs_of, watching
from .trajectory.phases import PhasedTrajectory, Phases
from .trajectory.progress import Progress
from .trajectory.trajectory import Trajectory

FINEST = 1e-15
"""Smallest tolerance that can be asked for: below it, double precision has no digits."""
FINEST_OF_SERIES = 1e-16
"""Of "taylor", whose steps are not iterated."""


@arguments_named
def simulate(
    s: Any,
    until: Any,
    *,
    initial: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    project: bool = False,
    values: Mapping[Any, Any] | None = None,
    tolerance: float | Mapping[Any, float] = 1e-9,
    events: Any = (),
    impulses: Any = (),
    impacts: str = "simultaneous",
    indeterminate: str = "refuse",
    method: str = "auto",
    step: Any = None,
    times: ArrayLike | None = None,
    samples: int | None = None,
    start: Any = 0,
    max_step: float | None = None,
    max_steps: int | None = None,
    progress: bool | Callable[[float], Any] | None = None,
    outputs: Any = None,
    store: Any = None,
    threads: int | None = None,
    executor: Any = None,
    sensitivities: Any = None,
) -> Any:
    """The motion of a machine from an initial state, or many motions from arrays of initial states and parameters.

    Parameters
    ----------
    s : System or Model
    until : number, expression or text
        Time at which the run ends [s]; earlier than ``start`` it runs backwards.
    initial : mapping, optional
        Start, by name or SymPy atom: ``{"theta": "30deg", "theta'": 2}``. A number, or an expression of
        parameters. What is not named is zero. The name of a ball or free joint stands for its quaternion
        (w, x, y, z), or a :class:`freebody.Rotation`.
    near : mapping, optional
        Of a machine with constraints: coordinates and speeds to begin the search from, where those not named in
        ``initial`` follow from the constraints.
    project : bool
        Of a machine with constraints: whether what is named in ``initial`` may move too, to the nearest state
        that satisfies them.
    values : mapping, optional
        Values of parameters, by name or symbol, in place of their defaults.
    tolerance : float or mapping of name to float
        Bound ε of the error of one step: |error| <= ε (1 + |value|) for each coordinate and speed in its own
        unit, and ε (E + |work|), E the energy at the start, for the work. The error at the end of a run is a
        multiple of it that depends on the motion. By name where coordinates need different ones (1e-9 for the
        rest).
    events : list, optional
        :func:`freebody.event`, or bare expressions, that are located where they pass through zero.
    method : {"auto", "dop853", "dop54", "radau", "gauss", "taylor", "structure", "timestepping"}
        How steps are made: explicit of order 8 or 5, implicit of order 5 for stiff machines, order 16 for tolerances
        down to round-off, Taylor series of order 16 for small smooth machines, symplectic in steps of one length.
        "auto" is "dop853"; for tolerances of 1e-7 and below "taylor" where the machine is small, "gauss" below 1e-14
        where it is not; and "radau" where the machine turns out to be stiff. In a batch it takes "taylor" from 1e-6 on.
        "timestepping" is for many contacts: equal steps of Moreau and Jean, of first order. The page on integrators
        tells them apart.
    impulses : list, optional
        :func:`freebody.blow`, blows and impacts of no duration at given times or where an expression passes through
        zero. They are among the events of the trajectory, and their work is in the energy ledger.
    impacts : {"simultaneous", "sequential"}
        Of several contacts that collide at once: all impulses together, or one contact after another, always the
        one that approaches fastest.
    indeterminate : {"refuse", "least"}
        What becomes of contacts that slide where the motion depends on how they share forces that nothing determines
        (four corners of a box that turns as it slides): the run is refused, or their normal forces, and impulses,
        are taken least in norm.
    times : array, optional
        Output times, within the run; those after a terminal event are left out.
    samples : int, optional
        Number of output times at equal distances, both ends included (at least 401 if neither is given).
    start : number, expression or text
        Time of the initial state [s].
    max_step : float, optional
        Longest step [s]: for loads that act so briefly that a step could jump over them.
    max_steps : int, optional
        Stop with an error after so many steps; after 10 million if not given, or 2 GiB of them. What is known before
        to take more, by ``step``, ``max_step`` or the period of a controller, is refused.
    step : float, optional
        Length of all steps [s], whatever their error: asked for by ``method="structure"``, possible with all but
        "auto".
    progress : bool or function, optional
        Whether to show a progress bar once a second has passed (on a terminal, if not given). A function is
        called several times a second with the part of the run that is done.
    outputs : name, expression, sequence or mapping of them, optional
        Of a batch: quantities at the output times (all coordinates and speeds if not given), and single numbers of
        the whole run, "max(theta)", "min(...)", "range(...)", "initial(...)", "final(...)". Of a contact "floor.gap",
        ".normal", ".tangential", ".slip", ".margin" and ".mode"; "modes" is the timeline of all (:func:`timeline`).
    store : path, optional
        Of a batch: netCDF file that takes the results as they come. Where it exists and holds the same runs, those
        that are missing are run. Runs are the same if their content is: machine, controllers, values, options, ...
    threads : int, optional
        Of a batch: how many share the lanes; all processors if not given. Results do not depend on it.
    executor : concurrent.futures.Executor, optional
        Of a batch: runs blocks of lanes elsewhere, such as a ``ProcessPoolExecutor``. Motions with contacts, which
        threads do not speed up, go so as fast as there are processors. Where a process dies, its lanes are "waiting",
        and ``reason`` says why.
    sensitivities : sequence of names, optional
        Parameters, and coordinates and speeds at the start, by which the motion is differentiated:
        ``trajectory.sensitivity["theta", "m"]``. The control of the step covers the derivatives.

    Returns
    -------
    Trajectory
        Flagged ``interrupted`` when the keyboard (Ctrl-C) stopped it. ``warnings`` tells where it is not physical: a
        rope that pushes, a plane that pulls a rolling wheel.
    xarray.Dataset
        Of a batch, which arrays in ``values`` or ``initial`` (entry k is of lane k), ``outputs`` or ``store`` ask for:
        the outputs over ``lane`` and ``time`` (101 times if none are given), first and last times of events, and
        ``status`` of each lane. A lane that fails is no error: its values are nan from there on. Of machines with
        contacts, blows or controllers ``reason`` says why it failed.

    Raises
    ------
    SimulationError
        Unknown names, an argument that the run can not heed, or a motion that can not be continued: with the time, the
        coordinate and the last good state, and with the motion so far as ``error.trajectory``.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, L/2, 0), axis="z", coordinate="theta")
    >>> motion = fb.simulate(s, until=10, initial={"theta": "30deg"}, events=["theta'"])
    >>> motion
    Trajectory of 'pendulum': t = 0 to 10 s, 1 coordinate, 9 events, finished
    """
    kernels = kernels_of(s)
    asked = (
        until, tolerance, impulses, impacts, indeterminate, method, step, times, samples, start,
        max_step, max_steps, outputs, store, threads, executor, sensitivities,
        *(events if isinstance(events, (list, tuple)) else (events,)),
    )  # fmt: skip
    plain = plain_run(kernels, asked, values)
    if plain is not None:
        y = plain.start(initial, near, project)
        motion = None if y is None else plain.motion(y, progress)
        if motion is not None:
            return motion
        plain = None if y is None else plain
    machine, model = kernels, kernels.model
    if (
        outputs is not None
        or store is not None
        or executor is not None
        or asks_for_many(model, initial, values)
    ):
        from .batch.batch import simulate_batch

        return simulate_batch(
            s, until, initial=initial, near=near, project=project, values=values, tolerance=tolerance, events=events,
            impulses=impulses, impacts=impacts, indeterminate=indeterminate, method=method, step=step, times=times,
            samples=samples, start=start, max_step=max_step, max_steps=max_steps, progress=progress, outputs=outputs,
            store=store, threads=threads, executor=executor, sensitivities=sensitivities,
        )  # fmt: skip
    if threads is not None:
        raise SimulationError(
            f"Expected several motions for threads=, got one of '{model.name}', which is one thread's. Leave it out."
        )
    if model.contacts and method != "timestepping":
        check_method_of_contacts(method, step)
    check_method(method, step)
    check_numbers(samples, max_step, max_steps, 1 + model.n_q + model.n_u)
    check_heeded(
        model, method, near=near, project=project, tolerance=tolerance, max_step=max_step, max_steps=max_steps,
        impacts=impacts, indeterminate=indeterminate,
    )  # fmt: skip
    numbers: Mapping[str, float] = kernels.values(values)
    begin = number(model, numbers, start, "start")
    numbers = at_time(model, numbers, begin)
    kernels.check(numbers)
    end = number(model, numbers, until, "until")
    if times is not None and samples is not None:
        raise SimulationError("Expected times= or samples=, got both. Leave one out.")
    most = most_steps(max_steps, STORED + model.n_q + model.n_u)
    if method != "timestepping":
        check_steps(begin, end, step, max_step, most)
    wanted = _times(times, begin, end)
    specs = specs_of(events)
    expressions = expressions_of(model, specs)
    check_signals(model)
    if model.constraints:
        state, active = closed_start(
            kernels, numbers, {} if initial is None else initial, near or {}, begin, bool(project)
        )
        kernels = kernels.holding(active)
    else:
        state = initial_state(model, numbers, {} if initial is None else initial)
    tolerances = _tolerances(kernels, tolerance, method)

    if sensitivities is not None:
        from .legs.sensitivity import sensitive_motion

        refuse_switched(model, "sensitivities=")
        if tuple(impulses if isinstance(impulses, list | tuple) else [impulses]):
            raise SimulationError("Expected a motion without impulses= for sensitivities=. Leave one out.")
        with Progress(begin, end, progress) as between:
            sensitive = sensitive_motion(
                kernels, numbers, sensitivities, initial or {}, near or {}, state, begin, end, specs, expressions,
                tolerances, wanted, samples, method=method, step=step, max_step=max_step, max_steps=max_steps,
                project=project, between=between,
            )  # fmt: skip
        if sensitive.path.status in runs.FAILED:
            raise failure(sensitive, sensitive.path, kernels, end, specs)
        return sensitive
    if method == "timestepping":
        from .timestepping.timestepping import stepped_motion

        refuse_switched(model, 'method="timestepping"')
        with Progress(begin, end, progress) as between:
            return stepped_motion(
                kernels, numbers, state, begin, end, specs, expressions, tolerances, wanted, samples,
                step=step, max_steps=max_steps, impulses=impulses, between=between,
            )  # fmt: skip
    if model.contacts:
        from .contact.motion import touching_motion

        refuse_switched(model, "a machine with contacts")
        with Progress(begin, end, progress) as between:
            return touching_motion(
                kernels, numbers, state, begin, end, specs, expressions, tolerances, wanted, samples,
                order=impacts, indeterminate=indeterminate, method=method, max_step=max_step, max_steps=most,
                impulses=impulses, between=between,
            )  # fmt: skip
    parameters, rates = kernels.at(numbers)
    blows = blows_of(impulses)
    longest = math.inf if max_step is None else float(max_step)
    if plain is None and not (blows or model.switched or kernels.dropped):
        way = Way(
            kernels, parameters, method, rates, tolerances, step=step, max_step=longest, max_steps=most,
            watch=watching(kernels, parameters, specs, expressions),
        )  # fmt: skip
        plain = PlainRun(
            machine, asked, values, kernels, numbers, way, begin, end, specs, tolerances, wanted, samples
        )
        plain.keep()
        motion = plain.motion(state.tolist(), progress)
        if motion is not None:
            return motion
    absolute = tolerances
    if kernels.works:
        state = np.append(state, 0.0)
        absolute = scaled(kernels, tolerances, begin, state, rates, method)
    watch = watching_blows(kernels, parameters, specs, blows)
    with Progress(begin, end, progress) as between:
        finest = float(tolerances.min(initial=1.0)) if step is None else None
        left, holding = most, Holding(kernels, finest)

        def leg(
            p: Any, how: str, here: Rates, y: Any, t0: float, t1: float, work: float = 0.0, **more: Any
        ) -> Any:
            def part(
                held: Kernels, rates: Rates, y: Any, t0: float, t1: float, halt: Any, method: str = how,
                watched: bool = True,
            ) -> Path:  # fmt: skip
                nonlocal left
                # a step across a position in which conditions lose their hold is one
                upper, length = (longest, step) if method == how else (math.inf, abs(t1 - t0))
                asked = more if watched else {**more, "watch": None}
                one = Way(
                    held, p, method, rates, tolerances, step=length, max_step=upper, max_steps=left, **asked,
                )  # fmt: skip
                done = one.path(y, t0, t1, absolute, between, halt)
                left -= done.steps
                return done

            return holding.path(part, p, here, y, t0, t1, work)

        happenings: tuple[Any, ...] = ()
        path: Any
        drives = Drives(kernels, numbers, begin, end, most) if model.switched else None
        given = method

        def advance(y: Any, t0: float, t1: float, work: float = 0.0) -> Any:
            if drives is None:
                return leg(parameters, method, rates, y, t0, t1, work, watch=watch)

            def interval(p: Any, here: Rates, *span: Any, method: str | None = None, **more: Any) -> Any:
                return leg(p, method or given, here, *span, **more)

            every = watching_specs(kernels, specs, blows)
            return driven_path(drives, interval, rates, watch, every, y, t0, t1, work)

        if blows:
            path, happenings = struck_path(kernels, numbers, advance, state, begin, end, specs, blows)
        else:
            path = advance(state, begin, end)
    parts = (kernels, numbers, path, specs, tolerances, wanted, samples)
    if isinstance(path, Phases):
        happened = sorted((*happenings, *holding.told), key=lambda one: one.time)
        trajectory: Trajectory = PhasedTrajectory(*parts, happenings=happened)
    else:
        trajectory = Trajectory(*parts)
    if path.status in runs.FAILED:
        raise failure(trajectory, path, holding.now, end, watching_specs(kernels, specs, blows))
    if model.constraints:
        check_redundant(trajectory)
    return trajectory


def _times(times: ArrayLike | None, begin: float, end: float) -> Any:
    if times is None:
        return None
    try:
        wanted = np.atleast_1d(np.array(times, dtype=float))
    except (TypeError, ValueError):
        raise SimulationError(f"Expected a list of output times [s], got {times!r}.") from None
    first, last = min(begin, end), max(begin, end)
    if wanted.ndim != 1 or wanted.size == 0:
        raise SimulationError(f"Expected a list of output times, got an array of shape {np.shape(times)}.")
    outside = ~((wanted >= first) & (wanted <= last))
    if outside.any():
        raise SimulationError(
            f"Expected output times from {first:g} to {last:g} s, got {wanted[outside][0]:g}. "
            "Leave it out, or simulate further."
        )
    return wanted


def _tolerances(kernels: Kernels, tolerance: Any, method: str) -> Any:
    finest = FINEST_OF_SERIES if method == "taylor" else FINEST
    if isinstance(tolerance, float) or not isinstance(tolerance, Mapping):
        return _equal(_tolerance(tolerance, finest), kernels.size)
    names = kernels.names
    texts = kernels.model.names.texts
    by_name = {key if isinstance(key, str) else texts.get(key, str(key)): v for key, v in tolerance.items()}
    for name in by_name:
        if name not in names:
            raise SimulationError(f"Unknown name '{name}' in tolerance; {nearest(name, names)}")
    return np.array([_tolerance(by_name.get(name, 1e-9), finest) for name in names])


@lru_cache(maxsize=64)
def _equal(number: float, n: int) -> Any:
    """``n`` times the same number, for all who ask for them."""
    result = np.full(n, number)
    result.setflags(write=False)
    return result


def _tolerance(value: Any, finest: float) -> float:
    if isinstance(value, list | tuple) or isinstance(value, np.ndarray) and value.ndim:
        raise SimulationError(
            f"Expected one number for tolerance=, or numbers by name, such as {{'theta': 1e-9}}, got {value!r}."
        )
    if not is_number(value) or not finest <= value < 1:
        raise SimulationError(
            f"Expected a tolerance between {finest:g} and 1, got {value!r}. "
            "1e-9 suits most purposes; below 1e-14 rounding errors dominate."
        )
    return float(value)
