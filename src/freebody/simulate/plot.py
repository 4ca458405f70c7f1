"""Quantities of a trajectory over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .trajectory import Trajectory, unit_of

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure


def plot(
    trajectory: Trajectory, names: Sequence[Any] | None = None, path: str | Path | None = None
) -> Figure:
    """See :meth:`Trajectory.plot`."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    model = trajectory.kernels.model
    if names is None:
        names = model.coordinate_names
    elif isinstance(names, str) or not isinstance(names, Sequence):
        names = [names]
    figure = Figure(figsize=(7, 1 + 1.5 * len(names)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(max(len(names), 1), 1, sharex=True, squeeze=False)[:, 0]
    for axis, name in zip(axes, names, strict=False):
        text = name if isinstance(name, str) else model.names.texts.get(name, str(name))
        unit = unit_of(trajectory, text) if text in trajectory.names else ""
        axis.plot(trajectory.t, trajectory[name])
        for event in trajectory.events:
            axis.axvline(event.time, color="0.6", linewidth=0.8, linestyle=":")
        axis.set_ylabel(f"{text} [{unit}]" if unit else text)
        axis.grid(alpha=0.3)
    axes[-1].set_xlabel("time [s]")
    if path is not None:
        figure.savefig(path, dpi=150)
    return figure
