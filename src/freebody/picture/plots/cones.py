"""Cones that the angular velocity of a body draws: the space cone, and the body cone, which rolls on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError
from .plots import COLORS, INK, angular_velocity, body_rotation
from .sphere import FRONT, INSIDE, TEXT, _axes, _frame, _heading

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]


def cones(
    trajectory: Trajectory,
    body: str,
    ax: Any = None,
    *,
    at: float | None = None,
    title: str | None = None,
    view: tuple[float, float] = (18.0, -58.0),
) -> Any:
    """Space cone and body cone of a body at one time; they touch along the angular velocity.

    The body cone rolls without slip on the space cone: any motion of a body about a point is such a rolling (Poinsot).
    Both are drawn with a slant height of 1.

    Parameters
    ----------
    trajectory : Trajectory
    body : str
    ax : Axes3D, optional
    at : float, optional
        Time at which the body cone is drawn [s], rounded to the nearest output time; by default the start.
    title : str, optional
    view : (elevation, azimuth)
        Direction of view [deg].

    Returns
    -------
    Axes3D

    Raises
    ------
    SimulationError
        If the body is unknown, or its angular velocity vanishes.
    """
    w = angular_velocity(trajectory, body)
    rotation = body_rotation(trajectory, body)
    speed = np.linalg.norm(w, axis=1)
    if not speed.min() > 1e-9 * speed.max():
        raise SimulationError(
            f"Expected a body that turns all the time, but the angular velocity of '{body}' is zero at "
            f"t = {trajectory.t[int(np.argmin(speed))]:g} s, where it has no direction."
        )
    space = w / speed[:, None]
    in_body = np.einsum("nji,nj->ni", rotation, space)
    start = trajectory.t[0] if at is None else at
    if not trajectory.t[0] <= start <= trajectory.t[-1]:
        raise SimulationError(
            f"Expected a time from {trajectory.t[0]:g} to {trajectory.t[-1]:g} s, got {start:g} s."
        )
    k = int(np.argmin(np.abs(trajectory.t - start)))
    ax = _axes(ax, view)
    _frame(ax)
    _cone(ax, space, COLORS[4])
    _cone(ax, in_body @ rotation[k].T, COLORS[0])
    ax.plot(*np.array([np.zeros(3), 1.12 * space[k]]).T, color=COLORS[1], linewidth=2.4, zorder=TEXT)
    ax.text(*(1.2 * space[k]), r"$\omega$", fontsize=14, color=COLORS[1], zorder=TEXT)
    from matplotlib.patches import Patch

    handles = [
        Patch(facecolor=COLORS[4], alpha=0.4, label="space cone"),
        Patch(facecolor=COLORS[0], alpha=0.4, label="body cone"),
    ]
    ax.figure.legend(handles=handles, loc="lower left", frameon=False, fontsize=10.5)
    _heading(
        ax, title or f"Cones of {body}", f"t = {trajectory.t[k]:.4g} s; they touch along the angular velocity"
    )
    return ax


def _cone(ax: Any, rim: Array, color: str) -> None:
    """Draw a cone from the origin to a curve of unit vectors, and the curve."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    # no more facets than a picture can show
    step = max(1, len(rim) // 720)
    few = np.concatenate([rim[:-1:step], rim[-1:]])
    facets = [np.array([np.zeros(3), a, b]) for a, b in zip(few, few[1:], strict=False)]
    ax.add_collection3d(
        Poly3DCollection(facets, facecolor=color, edgecolor="none", alpha=0.22, zorder=INSIDE)
    )
    ax.plot(*rim.T, color=color, linewidth=1.4, zorder=FRONT)
    ax.plot(*few[:1].T, marker="o", markersize=5, markerfacecolor="white", markeredgecolor=INK, zorder=TEXT)
