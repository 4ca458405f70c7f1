"""Sweeps: the motion at every combination of parameters and initial values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import SimulationError, arguments_named, nearest
from ..motion.batch.start import numbers_in
from ..motion.kernels.kernels import kernels_of
from .batch import simulate_batch

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
    axes = _axes(model, vary)
    grid = np.meshgrid(*(array for _, _, array in axes), indexing="ij")
    shape = tuple(array.size for _, _, array in axes)
    lanes: tuple[dict[Any, Any], dict[Any, Any]] = (dict(values or {}), dict(initial or {}))
    for (name, kind, _), entries in zip(axes, grid, strict=True):
        for key in lanes[kind]:
            text = key if isinstance(key, str) else model.names.texts.get(key, str(key))
            if text == name:
                where = "values" if kind == 0 else "initial"
                raise SimulationError(f"'{name}' is in vary= and in {where}=. Leave one out.")
        lanes[kind][name] = entries.reshape(-1)
    data = simulate_batch(
        s, until, values=lanes[0], initial=lanes[1], outputs=outputs, store=store, progress=progress,
        executor=executor, **options,
    )  # fmt: skip
    return _shaped(data, axes, shape)


def _axes(model: Any, vary: Any) -> list[tuple[str, int, np.ndarray]]:
    """(name, 0 for a parameter or 1 for an initial value, numbers) of each axis of the grid."""
    if not isinstance(vary, Mapping) or not vary:
        raise SimulationError(f"Expected vary= by name, such as {{'m': [1, 2, 3]}}, got {vary!r}.")
    parameters = [parameter.name for parameter in model.parameters]
    starts = [*model.coordinate_names, *model.speed_names]
    texts = {**model.names.texts, **{p.symbol: p.name for p in model.parameters}}
    axes = []
    for key, numbers in vary.items():
        name = key if isinstance(key, str) else texts.get(key, str(key))
        if name not in parameters and name not in starts:
            raise SimulationError(f"Unknown name '{name}' in vary; {nearest(name, [*parameters, *starts])}")
        try:
            array = np.array(numbers_in(model, numbers, name, f"values of '{name}' in vary"), dtype=float)
        except (TypeError, ValueError):
            raise SimulationError(f"Expected numbers for '{name}' in vary, got {numbers!r}.") from None
        if array.ndim != 1 or not array.size:
            raise SimulationError(
                f"Expected a list of at least one number for '{name}' in vary, got {numbers!r}. Write "
                f"vary={{'{name}': [1, 2, 3]}}; a name with one value belongs in values= or initial=."
            )
        if not np.isfinite(array).all():
            raise SimulationError(f"Expected finite numbers for '{name}' in vary, got {numbers!r}.")
        if len(set(array.tolist())) < array.size:
            raise SimulationError(f"Expected different numbers for '{name}' in vary, got {numbers!r}.")
        axes.append((name, int(name not in parameters), array))
    if math.prod(array.size for *_, array in axes) > 1 << 40:
        raise SimulationError(
            "Expected fewer than 10^12 runs. Vary fewer parameters, or fewer values of each."
        )
    return axes


def _shaped(data: Any, axes: list[tuple[str, int, np.ndarray]], shape: tuple[int, ...]) -> Any:
    """Return the dataset with the axes of the grid in place of the lanes."""
    import xarray

    names = [name if kind == 0 else f"{name}_start" for name, kind, _ in axes]
    variables: dict[str, Any] = {}
    for name, variable in data.data_vars.items():
        dims = [d for d in variable.dims if d != "lane"]
        array = variable.transpose("lane", *dims).data
        variables[name] = (
            (*names, *dims), array.reshape(*shape, *array.shape[1:]), variable.attrs
        )  # fmt: skip
    coordinates: dict[str, Any] = {
        name: (name, array, data[name].attrs if name in data.coords else {})
        for name, (_, _, array) in zip(names, axes, strict=True)
    }
    for name in ("time", "event", "by"):
        if name in data.coords:
            coordinates[name] = data[name].variable
    result = xarray.Dataset(variables, coords=coordinates, attrs=data.attrs)
    result.set_close(data.close)
    return result
