"""simulate: from a machine and its initial values to its motion, or to many motions.

    q' = q'(q, u),   u' = u'(t, q, u),   W' = P(t, q, u)

The rates are machine code made from the algorithms (`kernels`); the loop around them is compiled too (`ode`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from numpy.typing import ArrayLike

from ..errors import arguments_named
from ..motion.request import Request
from ..motion.route import route
from ..scalar.algebra import Expression


@arguments_named
def simulate(
    s: Any,
    until: Expression,
    *,
    initial: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    project: bool = False,
    values: Mapping[Any, Any] | None = None,
    tolerance: float | Mapping[Any, float] = 1e-9,
    events: Any = (),
    impulses: Any = (),
    impacts: str = "simultaneous",
    indeterminate: str = "compliance",
    method: str = "auto",
    step: float | None = None,
    times: ArrayLike | None = None,
    samples: int | None = None,
    start: Expression = 0,
    max_step: float | None = None,
    max_steps: int | None = None,
    progress: bool | Callable[[float], Any] | None = None,
    outputs: Any = None,
    store: Any = None,
    threads: int | None = None,
    executor: Any = None,
    sensitivities: Any = None,
) -> Any:
    """Return the motion of a machine from initial values, or many motions from arrays of initial values and parameters.

    Parameters
    ----------
    s : System or Model
    until : number, expression or text
        Time at which the run ends [s]. If it is earlier than ``start``, the run goes backwards.
    initial : mapping, optional
        Initial values, by name or SymPy atom: ``{"theta": "30deg", "theta'": 2}``. Each is a number, or an expression
        of parameters; coordinates and speeds not named are zero. The name of a ball or free joint stands for its
        quaternion (w, x, y, z), or a :class:`freebody.Rotation`.
    near : mapping, optional
        For machines with constraints: guesses of coordinates and speeds that are not named in ``initial`` and follow
        from the constraints.
    project : bool
        For machines with constraints: True to also move the values named in ``initial``, to the nearest state that
        satisfies the constraints.
    values : mapping, optional
        Values of parameters, by name or symbol, in place of their defaults.
    tolerance : float or mapping of name to float
        Bound ε of the error of one step: |error| <= ε (1 + |value|) for each coordinate and speed in its own
        unit, and ε (E + |work|) for the work, with E the energy at the start. The error at the end of a run is a
        multiple of it that depends on the motion. A mapping gives tolerances by name (1e-9 for the rest).
    events : list, optional
        :func:`freebody.event`, or bare expressions, located at their zero crossings. Each step is searched in windows
        short enough to show how the expression runs between its points; only a pulse shorter than an eighth of a
        step, from a value that is constant beside it, can be passed over: bound ``max_step`` for one.
    method : {"auto", "dop853", "dop54", "tsit5", "radau", "gauss", "taylor", "structure", "timestepping"}
        Integration method: explicit of order 8 or 5, implicit of order 5 for stiff machines, order 16 for tolerances
        down to round-off, Taylor series of order 16 for small smooth machines, symplectic with steps of one length.
        "auto" is "dop853"; for tolerances of 1e-7 and below (1e-6 in a batch) it is "taylor" if the machine is small,
        and below 1e-14 "gauss" otherwise; it changes to "radau" if the machine turns out to be stiff. "timestepping" is
        for many contacts: equal steps of Moreau and Jean, of first order. The page on integrators compares the methods.
    impulses : list, optional
        :func:`freebody.blow`: blows and impacts of no duration, at given times or where an expression passes through
        zero. They are events of the trajectory, and the energy ledger counts their work.
    impacts : {"simultaneous", "sequential"}
        How several contacts collide at once: all impulses together, or one contact after another, always the contact
        that approaches fastest.
    indeterminate : {"compliance", "refuse"}
        Treatment of contacts whose shares of the forces are indeterminate but affect the motion (four corners of a box
        that turns as it slides): the limit of equal compliance at all contacts, which the events and
        ``trajectory.indeterminate`` name, or a refusal.
    times : array, optional
        Output times, within the run; times after a terminal event are left out.
    samples : int, optional
        Number of output times at equal distances, both ends included (at least 401 if neither is given).
    start : number, expression or text
        Time of the initial state [s].
    max_step : float, optional
        Longest step [s]; needed for loads that act so briefly that a step could miss them.
    max_steps : int, optional
        Number of steps after which the run stops with an error; if not given, 10 million steps or 2 GiB of them. A run
        that needs more because of ``step``, ``max_step`` or the period of a controller is refused at once.
    step : float, optional
        Length of all steps [s], whatever their error: required by ``method="structure"`` and "timestepping", possible
        with all methods except "auto". In time steps it is the greatest one: samples of controllers and break points of
        signals end a step, and between two of them all steps are equal.
    progress : bool or function, optional
        True to show a progress bar once a second has passed; if not given, only on a terminal. A function is called
        several times a second with the part of the run that is done.
    outputs : name, expression, sequence or mapping of them, optional
        For a batch: quantities at the output times (all coordinates and speeds if not given), and single numbers for
        the whole run, "max(theta)", "min(...)", "range(...)", "initial(...)", "final(...)". For a joint "pin" is the
        magnitude of its reaction force, and "pin.force.y", "pin.moment.z" are components in ground axes. For a contact
        "floor.gap", ".approach", ".normal", ".tangential", ".slip", ".margin" and ".mode"; "modes" is the timeline of
        all modes (:func:`timeline`).
    store : path, optional
        For a batch: netCDF file to which results are written as they come. If it exists and holds the same runs, only
        missing runs are computed. Runs are the same if their content is: machine, controllers, values, options, ...
    threads : int, optional
        For a batch: number of threads that share the lanes; all processors if not given. Results do not depend on it.
    executor : concurrent.futures.Executor, optional
        For a batch: executor that runs blocks of lanes elsewhere, such as a ``ProcessPoolExecutor``. If a process dies,
        its lanes are "waiting", and ``reason`` says why.
    sensitivities : sequence of names, optional
        Parameters, and coordinates and speeds at the start, by which the motion is differentiated:
        ``trajectory.sensitivity["theta", "m"]``. Step-size control covers the derivatives. In a batch, "d(theta)" has
        those of the output "theta", over the dimension ``by``.

    Returns
    -------
    Trajectory
        ``interrupted`` is True if Ctrl-C stopped the run. ``warnings`` tells where the motion is not physical: a rope
        that pushes, a plane that pulls a rolling wheel.
    xarray.Dataset
        Result of a batch, which is run if ``values`` or ``initial`` contain arrays (entry k belongs to lane k), or if
        ``outputs``, ``store`` or ``executor`` is given: the outputs over ``lane`` and ``time`` (101 times if none are
        given), first and last times of events, and ``status`` of each lane. A lane that fails is no error: its values
        are nan from then on. For machines with contacts, blows or controllers ``reason`` says why it failed.

    Raises
    ------
    SimulationError
        Unknown names, an argument that does not apply to the run, or a motion that cannot be continued; then with the
        time, the coordinate and the last good state, and with the motion so far as ``error.trajectory``.

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
    request = Request.of(locals())
    return route(request)(request)
