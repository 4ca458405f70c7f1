"""Results of many motions: each number against what varies, each quantity over time as a band."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import SimulationError
from ...motion.ending import GOOD, End
from .plots import COLORS, INK, figure

MOST = 4
"""Most outputs, and most varied values, that a figure has room for."""
MARKS = 5000
"""Most lanes that are drawn, evenly spaced among all."""
_OTHERS = ("steps", "status", "blame", "reason", "end", "event_time", "event_last", "event_count", "modes")


def lanes(data: Any) -> Any:
    """Draw the results of a study.

    Parameters
    ----------
    data : xarray.Dataset
        What :meth:`freebody.Study.run` returns, or ``data`` of :func:`freebody.open_study`.

    Returns
    -------
    ndarray of matplotlib axes
        One row for each output: a number of the whole run against each value that varies; a quantity over time as its
        median and the bands that hold 50 % and 90 % of the lanes. Red marks at the lower edge are lanes that failed.
        At most 4 rows and columns, and 5000 lanes.

    Raises
    ------
    SimulationError
        If no lane has ended, or nothing is to be drawn.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("stone")
    >>> fall = s.slider("fall", s.ground, s.body("stone", fb.particle(1)), axis="y", coordinate="y")
    >>> s.gravity = (0, -9.81, 0)
    >>> study = fb.study(s, until=1, lanes=fb.grid({"y'": [0, 5, 10]}), outputs=["y", "max(y)"])
    >>> axes = fb.plot.lanes(study.run())
    >>> axes.shape, axes[1, 0].get_ylabel(), axes[1, 0].get_xlabel()
    ((2, 1), 'max(y) [m]', "y' at the start [m/s]")
    """
    count = data.sizes["lane"]
    chosen = np.unique(np.linspace(0, count - 1, min(count, MARKS)).astype(np.int64))
    codes = np.asarray(data["status"].values)[chosen]
    ended, good = codes != End.WAITING, np.isin(codes, GOOD)
    outputs = [
        name
        for name, x in data.data_vars.items()
        if name not in _OTHERS and x.dims in (("lane",), ("lane", "time")) and x.dtype.kind == "f"
    ]
    stored = data.attrs.get("coordinates", "").split()
    varied = [
        name
        for name, x in data.variables.items()
        if x.dims == ("lane",) and (name in data.coords or name in stored) and name != "lane"
    ]
    outputs = [name for name in outputs if name not in varied][:MOST]
    varied = varied[:MOST]
    if not outputs or not varied or not ended.any():
        raise SimulationError("Expected lanes that have ended, with outputs that are numbers, for a picture.")
    fig = figure(1 + 3.2 * len(varied), 0.4 + 2.4 * len(outputs))
    axes = fig.subplots(len(outputs), len(varied), squeeze=False)
    fig.suptitle(data.attrs.get("title", ""), fontsize="medium")
    for row, name in zip(axes, outputs, strict=True):
        values = data[name].isel(lane=chosen).values
        if data[name].dims == ("lane", "time"):
            _band(row, data["time"].values, values[good])
        else:
            for ax, along in zip(row, varied, strict=True):
                _cloud(ax, data[along].isel(lane=chosen).values, values, good, ended & ~good)
                ax.set_xlabel(_label(data[along], along))
        row[0].set_ylabel(_label(data[name], name))
    return axes


def _cloud(ax: Any, x: Any, y: Any, good: Any, bad: Any) -> None:
    """Draw a number of the lanes against a value of theirs, and marks for those that failed."""
    size = 12 if good.sum() < 500 else 2
    ax.scatter(x[good], y[good], s=size, color=COLORS[0], linewidths=0)
    if bad.any():
        ax.plot(
            x[bad],
            np.zeros(int(bad.sum())),
            "|",
            color=COLORS[1],
            transform=ax.get_xaxis_transform(),
            markersize=8,
        )


def _band(row: Any, time: Any, values: Any) -> None:
    """Draw a quantity over time in the first axes of a row; the others are left out."""
    for ax in row[1:]:
        ax.set_axis_off()
    if not len(values):
        return
    with np.errstate(invalid="ignore"):
        low, quarter, middle, most, high = np.nanquantile(values, [0.05, 0.25, 0.5, 0.75, 0.95], axis=0)
    row[0].fill_between(time, low, high, color=COLORS[0], alpha=0.15, linewidth=0, label="90 %")
    row[0].fill_between(time, quarter, most, color=COLORS[0], alpha=0.3, linewidth=0, label="50 %")
    row[0].plot(time, middle, color=COLORS[0], label="median")
    row[0].legend(fontsize="small", labelcolor=INK)
    row[0].set_xlabel("time [s]")


def _label(variable: Any, name: Any) -> str:
    """Return the label of an axis: the name with its unit."""
    text = f"{name.removesuffix('_start')} at the start" if str(name).endswith("_start") else str(name)
    unit = variable.attrs.get("units", "")
    return f"{text} [{unit}]" if unit and unit != "1" else text
