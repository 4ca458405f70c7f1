"""Sweeps: the motion at every combination of parameters and initial values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from ..errors import SimulationError, arguments_named
from ..motion.kernels.kernels import kernels_of
from .lanes.grid import grid_of
from .lanes.law import by_name, check_apart
from .simulate import simulate

if TYPE_CHECKING:
    import xarray


@arguments_named
def sweep(
    s: Any,
    vary: Mapping[Any, Any],
    until: Any,
    *,
    outputs: Any = None,
    initial: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
    executor: Any = None,
    store: Any = None,
    progress: bool | Callable[[float], Any] | None = None,
    **options: Any,
) -> xarray.Dataset:
    """Simulate a machine at every combination of parameters and initial values.

    Parameters
    ----------
    s : System or Model
    vary : mapping of name to array
        Values of parameters, and initial values of coordinates and speeds, each of shape (n_i,). The grid has
        n_1 × n_2 × ... runs.
    until : number, expression or text
        Time at which the runs end [s].
    outputs : name, expression, sequence or mapping of them, optional
        Quantities over time, "theta" or "L*sin(theta)", and single numbers of a whole run: "max(theta)", "min(theta)",
        "range(theta)", "initial(theta)", "final(theta)", located to the accuracy of the run. By default all
        coordinates and speeds.
    initial, values : mapping, optional
        Values that are the same in all runs; expressions of parameters follow the parameters that vary.
    executor : concurrent.futures.Executor, optional
        Runs blocks of the grid: processes, or a cluster (``dask.distributed.Client(...).get_executor()``). Without it
        the processors of this machine share the grid.
    store : path, optional
        netCDF file for the results, written as runs end. A stopped sweep continues from it.
    progress : bool or function, optional
        Show a progress bar; see :func:`freebody.simulate`.
    **options
        ``events``, ``times``, ``samples``, ``tolerance``, ``method``, ``threads``, ... of :func:`freebody.simulate`.

    Returns
    -------
    xarray.Dataset
        Dimensions by the names of ``vary`` (``theta_start`` for the initial value of ``theta``), then ``time`` and
        ``event``. ``status`` holds how each run ended; a run that fails raises no error.

    Raises
    ------
    SimulationError
        If a name is unknown, or an array has more than one axis; also as :func:`freebody.simulate`.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> L, g = s.parameters(L=1.0, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(1))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), axis="z", coordinate="theta")
    >>> data = fb.sweep(s, {"L": [1, 2, 4], "theta": [0.1, 1.0]}, until=5, outputs="max(theta')")
    >>> data["max(theta')"].round(4).values
    array([[0.3131, 3.0032],
           [0.2214, 2.1236],
           [0.1565, 1.5016]])
    """
    model = kernels_of(s).model
    if not isinstance(vary, Mapping) or not vary:
        raise SimulationError(f"Expected vary= by name, such as {{'m': [1, 2, 3]}}, got {vary!r}.")
    grid = grid_of(by_name(vary, {}, "fb.sweep"), "vary", "vary={}").resolved(model, "vary")
    check_apart(model, grid, values, initial, "vary")
    columns = grid.columns(0, grid.count)
    parameters = {name: x for name, x in columns.items() if name in model.defaults}
    starts = {name: x for name, x in columns.items() if name not in parameters}
    data = simulate(
        s, until, values={**(values or {}), **parameters}, initial={**(initial or {}), **starts}, outputs=outputs,
        store=store, progress=progress, executor=executor, **options,
    )  # fmt: skip
    return grid.shaped(data)
