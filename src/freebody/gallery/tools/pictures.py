"""Additional pictures for the gallery: lines in panels, and an axis seen from above."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import freebody as fb


def lines(t: Any, panels: Mapping[str, Mapping[str, Any]], title: str) -> Any:
    """Draw curves over time: a panel for each axis label, and in it a line for each name."""
    from ...picture.plots.plots import COLORS, figure

    axes = np.atleast_1d(figure(8, 2.4 + 1.6 * len(panels)).subplots(len(panels), 1, sharex=True))
    for ax, (label, curves) in zip(axes, panels.items(), strict=True):
        for (name, values), color in zip(curves.items(), COLORS, strict=False):
            ax.plot(t, values, color=color, linewidth=1.6, label=name)
        ax.set_ylabel(label)
        ax.grid(alpha=0.3)
        ax.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=len(curves), frameon=False)
    axes[0].set_title(title, loc="left", fontweight="bold")
    axes[-1].set_xlabel("time [s]")
    return axes


def moments(trajectory: fb.Trajectory, joint: str, title: str) -> Any:
    """Draw the moment of a joint on its child body over time, components in ground axes."""
    felt = trajectory.reactions[joint]
    curves = {f"{joint}_M{axis}": felt.moment[:, i] for i, axis in enumerate("xyz")}
    return lines(trajectory.t, {f"moment on {felt.on} [N m]": curves}, title)


def tip(trajectory: fb.Trajectory, body: str, title: str, about: Any = None) -> Any:
    """Draw the path of the tip of a body's z axis from above: components along X and Y; ``about`` marks a direction."""
    from ...picture.plots.plots import COLORS, figure

    axis = trajectory.poses[body].rotation[:, :, 2]
    ax = figure(8, 6.5).subplots()
    ax.plot(axis[:, 0], axis[:, 1], color=COLORS[0], linewidth=1.2)
    ax.plot(*axis[0, :2], "o", color=COLORS[1], label="start")
    if about is not None:
        name, vector = about
        unit = np.asarray(vector, dtype=float) / np.linalg.norm(vector)
        ax.plot(*unit[:2], "+", color="0.2", markersize=12, label=name)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("along X")
    ax.set_ylabel("along Y")
    ax.grid(alpha=0.3)
    ax.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
    ax.set_title(title, loc="left", fontweight="bold")
    return ax


def seen_in_body(
    trajectory: fb.Trajectory,
    body: str,
    vectors: Any,
    title: str,
    remark: str,
    view: tuple[float, float] = (22.0, 40.0),
) -> Any:
    """Draw the path of the direction of vectors (times, 3), given in ground axes, on the unit sphere of body axes."""
    from ...picture.plots import sphere

    own = np.einsum("nji,nj->ni", trajectory.poses[body].rotation, vectors)
    own /= np.linalg.norm(own, axis=1)[:, None]
    ax = sphere._axes(None, view)
    sphere._surface(ax, np.ones(3))
    for name, end in zip("xyz", np.eye(3), strict=True):
        ax.plot(*np.array([end, 1.1 * end]).T, color=sphere.INK, linewidth=1.2, zorder=sphere.FRONT)
        ax.text(
            *(1.17 * end), name, fontsize=12, color=sphere.INK, ha="center", va="center", zorder=sphere.TEXT
        )
    sphere._colored(ax, trajectory.t, own, np.ones(3))
    sphere._tip(ax, own[0], "", hollow=True)
    sphere._tip(ax, own[-1], "end")
    sphere._heading(ax, title, remark)
    return ax
