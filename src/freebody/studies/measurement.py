"""What a fit compares motions with: measured quantities, their standard deviations and bounds, checked.

Each measurement has times, and quantities by name, nan where they were not measured. Data that do not tell unknowns
apart are refused with the change of the unknowns that leaves the motion as it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SimulationError

if TYPE_CHECKING:
    from ..model.model import Model

Array = NDArray[np.float64]

INDISTINCT = 1e-8
"""Smallest singular value of the scaled Jacobian, relative to the greatest, below which data do not tell parameters
apart: relative changes of parameters then change the motion by no more than its integration error."""

ROUND_OFF = 1e-12
"""Fraction of the measurement below which a derivative is round-off: some thousand roundings."""


def weighted(measured: Any, weights: Any) -> Iterator[Array]:
    """Yield the measured values over their standard deviations."""
    for (_, columns), scales in zip(measured, weights, strict=True):
        for name, array in columns.items():
            finite = np.isfinite(array)
            yield array[finite] / scales[name][finite]


def name_of(model: Model, key: Any) -> str:
    """Return the name of a quantity as text."""
    return model.names.text_of(key)


def _columns(model: Model, run: Any) -> dict[str, Any]:
    """Return what was measured, by name, with the times as 'time'."""
    if hasattr(run, "data_vars"):
        columns = {str(k): np.asarray(v.values) for k, v in run.data_vars.items()}
        columns["time"] = np.asarray(run["time"].values)
    elif isinstance(run, Mapping):
        columns = {name_of(model, k): v for k, v in run.items()}
    elif hasattr(run, "columns"):  # a table of pandas, or a similar one
        columns = {name_of(model, k): run[k] for k in run.columns}
        index = getattr(run, "index", None)
        if getattr(index, "name", None) in ("time", "t"):
            columns.setdefault("time", np.asarray(index))
    else:
        raise SimulationError(
            f"Expected measured data by name, such as {{'time': t, 'theta': values}}, got {run!r}."
        )
    if "time" not in columns and "t" in columns:
        columns["time"] = columns.pop("t")
    if "time" not in columns:
        raise SimulationError(
            f"Expected 'time' among the measured data, got {', '.join(columns) or 'nothing'}. Name the array of times "
            "'time'."
        )
    return columns


def measured_by(model: Model, run: Any, begin: float) -> tuple[Array, dict[str, Array]]:
    """Return the measured times, and the measured quantities by name."""
    columns = _columns(model, run)
    arrays: dict[str, Array] = {}
    try:
        for name, x in columns.items():
            if np.iscomplexobj(x):
                raise SimulationError(
                    f"Expected real numbers for the measured '{name}', got complex numbers."
                )
            if np.asarray(x).dtype.kind in "mM":  # as numbers they would be nanoseconds
                raise SimulationError(
                    f"Expected numbers for the measured '{name}', got dates or durations. Compute seconds from the "
                    "start as (t - t[0]) / np.timedelta64(1, 's')."
                )
            arrays[name] = np.array(x.astype(float) if hasattr(x, "astype") else x, dtype=float)
    except (TypeError, ValueError):
        raise SimulationError(f"Expected arrays of numbers for the measured '{name}', got {x!r}.") from None
    times = arrays.pop("time")
    if times.ndim != 1 or not times.size:
        raise SimulationError(f"Expected times of shape (N,), got shape {times.shape}.")
    if not np.isfinite(times).all():
        k = int(np.flatnonzero(~np.isfinite(times))[0])
        raise SimulationError(f"Expected finite times, got {times[k]:g} for measurement {k}. Leave it out.")
    if times.min() < begin:
        raise SimulationError(
            f"Expected measurements after the start of the motion at {begin:g} s, got one at {times.min():g} s. "
            "start= is the time of the initial state."
        )
    for name, array in arrays.items():
        if array.shape != times.shape:
            raise SimulationError(
                f"Expected {times.size} measured values of '{name}', one for each time, got shape {array.shape}."
            )
        if np.isinf(array).any():
            raise SimulationError(
                f"Expected finite measured values of '{name}' (nan where there is none), got inf."
            )
    return times, arrays


def weights_of(sigma: Any, quantities: list[str], measured: Any) -> list[dict[str, Array]]:
    """Return standard deviations of all measured numbers by quantity, for each measurement; 1 if they are estimated."""
    if sigma is not None and not isinstance(sigma, Mapping):
        raise SimulationError(
            f"Expected standard deviations by quantity, such as sigma={{'{quantities[0]}': 0.01}}, got {sigma!r}."
        )
    deviations = dict(sigma or {})
    for name in deviations:
        if name not in quantities:
            raise SimulationError(
                f"Expected measured quantities in sigma, {', '.join(quantities)}; got '{name}'."
            )
    if deviations and len(deviations) < len(quantities):
        missing = [name for name in quantities if name not in deviations]
        raise SimulationError(
            f"Expected sigma of all measured quantities or of none; that of {', '.join(missing)} is missing."
        )
    if not deviations and len(quantities) > 1:
        raise SimulationError(
            f"Expected sigma= for several measured quantities ({', '.join(quantities)}): it weighs their errors "
            "against each other. Pass their standard deviations, such as sigma={'theta': 0.01}."
        )
    result = []
    for times, columns in measured:
        weights = {}
        for name in columns:
            try:
                array = np.asarray(deviations.get(name, 1.0), dtype=float)
            except (TypeError, ValueError):
                array = np.array(math.nan)
            if array.ndim and array.shape != times.shape or not (array > 0).all():
                raise SimulationError(
                    f"Expected a standard deviation greater than 0 for '{name}', one number or {times.size}, got "
                    f"{deviations[name]!r}."
                )
            weights[name] = np.broadcast_to(array, times.shape)
        result.append(weights)
    return result


def bounds_of(bounds: Any, names: list[str], first: Array) -> tuple[Array, Array]:
    """Return the least and greatest values of the unknowns."""
    low, high = np.full(len(names), -math.inf), np.full(len(names), math.inf)
    if bounds is not None and not isinstance(bounds, Mapping):
        raise SimulationError(f"Expected bounds by name, such as {{'{names[0]}': (0, 1)}}, got {bounds!r}.")
    for name, pair in (bounds or {}).items():
        if name not in names:
            raise SimulationError(f"Expected unknowns in bounds, {', '.join(names)}; got '{name}'.")
        i = names.index(name)
        try:
            low[i], high[i] = pair
        except (TypeError, ValueError):
            raise SimulationError(
                f"Expected (least, greatest) as bounds of '{name}', got {pair!r}."
            ) from None
        if not low[i] <= first[i] <= high[i]:
            raise SimulationError(
                f"Expected the first guess of '{name}' within its bounds, {low[i]:g} to {high[i]:g}, got {first[i]:g}."
            )
    return low, high


def check_rank(J: Array, p: Array, names: list[str], size: float, with_contacts: bool) -> None:
    """Raise if the data do not tell the unknowns apart; the message names the direction in which nothing changes.

    Columns are scaled by their parameters. A column that is negligible relative to the ``size`` of the measurement is
    round-off, even if all columns are.
    """
    scale = np.where(p != 0, np.abs(p), 1.0)
    scaled = J * scale
    lengths = np.linalg.norm(scaled, axis=0)
    largest = lengths.max(initial=0)
    idle = [
        name
        for name, x in zip(names, lengths, strict=True)
        if x <= max(INDISTINCT * largest, ROUND_OFF * size)
    ]
    if idle or largest == 0:
        listed = " and ".join(map(repr, idle or names))
        if with_contacts:
            at = ", ".join(f"{name} = {x:.6g}" for name, x in zip(names, p.tolist(), strict=True))
            raise SimulationError(
                f"The motion at {at} does not depend on {listed}, as it does not on friction where contacts stick or "
                "stay open. Begin elsewhere, or give starts=; leave out of unknown what no such motion depends on."
            )
        raise SimulationError(
            f"The measured motion does not depend on {listed}: it cannot be found "
            "from these data. Leave it out of unknown, or measure a quantity that depends on it."
        )
    _, singular, V = np.linalg.svd(scaled / lengths, full_matrices=False)
    if singular[-1] <= INDISTINCT * singular[0]:
        direction = V[-1] / lengths
        direction /= np.abs(direction).max()
        if direction[np.abs(direction).argmax()] < 0:
            direction = -direction
        changes = [
            f"{name} by {100 * x:+.3g} %" if q != 0 else f"{name} by {x:+.3g}"
            for name, x, q in zip(names, direction / 100, p, strict=True)
            if abs(x) > 1e-7
        ]
        raise SimulationError(
            f"The measured motion does not tell {', '.join(repr(m.split(' by ')[0]) for m in changes)} apart: changing "
            f"{', '.join(changes)} together does not change it. Give all but one of them in values=, or measure "
            "another quantity, such as a force, or a motion from other initial values."
        )
