"""simulate: from a machine and a start to its motion.

    q' = q'(q, u),   u' = u'(t, q, u),   W' = P(t, q, u)

The rates are machine code made from the algorithms (`kernels`), the loop around them is compiled too (`dop853`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from numpy.typing import ArrayLike

from ..errors import SimulationError, arguments_named
from .kernels.kernels import kernels_of
from .single import single_motion
from .start.initial import asks_for_many


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
    options: dict[str, Any] = dict(
        initial=initial, near=near, project=project, values=values, tolerance=tolerance, events=events,
        impulses=impulses, impacts=impacts, indeterminate=indeterminate, method=method, step=step, times=times,
        samples=samples, start=start, max_step=max_step, max_steps=max_steps, progress=progress,
        sensitivities=sensitivities,
    )  # fmt: skip
    model = kernels_of(s).model
    if (
        outputs is not None
        or store is not None
        or executor is not None
        or asks_for_many(model, initial, values)
    ):
        from .batch.batch import simulate_batch

        return simulate_batch(
            s, until, outputs=outputs, store=store, threads=threads, executor=executor, **options
        )
    if threads is not None:
        raise SimulationError(
            f"Expected several motions for threads=, got one of '{model.name}', which is one thread's. Leave it out."
        )
    return single_motion(s, until, **options)
