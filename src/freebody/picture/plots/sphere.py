"""Paths on closed surfaces in 3-D: a body axis on the unit sphere, the angular velocity on the energy ellipsoid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError
from .plots import COLORS, INK, body_rotation, color_map, figure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

BACK = 0.22
"""Opacity of lines on the far side."""


def axis_path(
    trajectory: Trajectory,
    body: str,
    ax: Any = None,
    *,
    axis: str = "z",
    about: Any = (0, 0, 1),
    about_name: str = "the vertical Z",
    title: str | None = None,
    view: tuple[float, float] = (24.0, -58.0),
) -> Any:
    """Path of a body axis on the unit sphere, coloured by time and pale on the far side.

    The dashed circles mark the smallest and the largest angle between the axis and a fixed direction.

    Parameters
    ----------
    trajectory : Trajectory
    body : str
    ax : Axes3D, optional
    axis : 'x', 'y' or 'z'
        Body axis.
    about : three numbers
        The fixed direction, in ground axes, of any length.
    about_name : str
        Its name; the last word of the name is written in the picture.
    title : str, optional
    view : (elevation, azimuth)
        Direction of view [deg].

    Returns
    -------
    Axes3D

    Raises
    ------
    SimulationError
        If the body or axis is unknown.
    """
    if axis not in ("x", "y", "z"):
        raise SimulationError(f"Expected the body axis 'x', 'y' or 'z', got {axis!r}.")
    points = body_rotation(trajectory, body)[:, :, "xyz".index(axis)]
    n = np.asarray(about, dtype=float) / np.linalg.norm(about)
    ax = _axes(ax, view)
    _surface(ax, np.ones(3))
    _frame(ax)
    angles = np.arctan2(np.linalg.norm(np.cross(points, n), axis=1), points @ n)
    smallest, largest = float(angles.min()), float(angles.max())
    constant = largest - smallest < 1e-6
    for angle in (largest,) if constant else (smallest, largest):
        _circle(ax, n, angle)
    if n[2] < 1:
        _stick(ax, n, about_name.split()[-1])
    _line(ax, np.array([[0.0, 0.0, 0.0], points[-1]]), np.ones(3), inside=True, color=INK, linewidths=2.2)
    _colored(ax, trajectory.t, points, np.ones(3))
    crowded = min(np.linalg.norm(points[0] - other) for other in (points[-1], n, *np.eye(3))) < 0.35
    _tip(ax, points[0], "" if crowded else "start", hollow=True)
    _tip(ax, points[-1], f"{axis} axis of {body}", below=bool(points[-1] @ n > 0.9))
    low, high = f"{np.rad2deg(smallest):.4g}°", f"{np.rad2deg(largest):.4g}°"
    remark = (
        f"{high if constant else f'{low} to {high}'} from {about_name}{'; circle: start' if crowded else ''}"
    )
    _heading(ax, title or f"Path of the {axis} axis of {body}", remark)
    return ax


def polhode(
    trajectory: Trajectory,
    body: str | Sequence[str],
    moments: Any = None,
    ax: Any = None,
    *,
    title: str = "Polhode: path of the angular velocity in the body",
    view: tuple[float, float] = (20.0, 40.0),
) -> Any:
    """Polhode: path of the angular velocity of a torque-free body on its energy ellipsoid, 2 T = Σ I_i w_i².

    The thin lines are the paths of other motions of the same energy. The dark lines pass through the middle axis; they
    separate the paths around the axis of the largest moment from the paths around the axis of the smallest.

    Parameters
    ----------
    trajectory : Trajectory
    body : str, or three names of speeds
        The body; or the components of its angular velocity along the principal axes x, y, z.
    moments : three numbers
        Principal moments of inertia about the mass centre [kg m²]; only with names of speeds.
    ax : Axes3D, optional
    title : str, optional
    view : (elevation, azimuth)
        Direction of view [deg].

    Returns
    -------
    Axes3D
    """
    letters = "xyz"
    if isinstance(body, str):
        inertia, w = _principal(trajectory, body)
        letters = "123"
    else:
        inertia = np.asarray(moments, dtype=float)
        w = np.stack([trajectory[name] for name in body], axis=-1)
    twice_T = float(inertia @ w[0] ** 2)
    if twice_T == 0:
        raise SimulationError(
            f"Expected a body that turns at t = {float(trajectory.t[0]):g} s for its polhode, got one at rest, whose "
            "energy ellipsoid is a point. Start it with an angular velocity."
        )
    radii = np.sqrt(twice_T / inertia)
    ax = _axes(ax, view, size=0.88 * float(radii.max()), height=5.4)
    _surface(ax, radii)
    _family(ax, inertia, radii)
    for i, letter in enumerate(letters):
        end = np.zeros(3)
        end[i] = 1.25 * radii[i]
        start = np.zeros(3)
        start[i] = radii[i]
        order = INSIDE if end @ _toward(ax) < 0 else FRONT
        ax.plot(*np.array([start, end]).T, color=INK, linewidth=1.2, zorder=order)
        ax.text(*(1.08 * end), f"$\\omega_{letter}$", fontsize=13, color=INK, zorder=TEXT, **LABEL)
    _colored(ax, trajectory.t, w, radii)
    _tip(ax, w[0], "", hollow=True)
    _heading(
        ax, title, "circle: start; thin: other motions of this energy; dark: those through the middle axis"
    )
    return ax


def _principal(trajectory: Trajectory, body: str) -> tuple[Array, Array]:
    """Principal moments of a body about its mass centre, ascending, and its angular velocity along their axes."""
    from ...dynamics.state import float_state
    from .plots import angular_velocity

    w = angular_velocity(trajectory, body)
    model = trajectory.kernels.model
    state = float_state(model, values=trajectory.values)
    inertia = np.array([[float(x) for x in row] for row in state.matrix(model.bodies[body].inertia)])
    moments, axes = np.linalg.eigh((inertia + inertia.T) / 2)
    if not moments[0] > 0:
        raise SimulationError(
            f"Expected a body with three moments of inertia above zero, got {tuple(moments.tolist())} kg m² of "
            f"'{body}': its energy does not bound its angular velocity."
        )
    in_body = np.einsum("nji,nj->ni", trajectory.poses[body].rotation, w)
    return moments, in_body @ axes


# -- parts ----------------------------------------------------------------------------------------------------


# Drawing order; in matplotlib's order by depth, long lines cover short ones.
SURFACE, FAR, INSIDE, FRONT, PATH, TEXT = 0, 1, 2, 3, 4, 5

GROUND = "#eef3fa"
LABEL: dict[str, Any] = {
    "ha": "center",
    "va": "center",
    "bbox": {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.6},
}


def _axes(ax: Any, view: tuple[float, float], size: float = 1.0, height: float = 6.8) -> Any:
    """Return axes in a square 6.5 inches wide; a lower figure cuts off an empty part of it."""
    if ax is None:
        new = figure(7.6, height)
        new.set_layout_engine("none")
        bottom = 0.44 - 3.25 / height
        ax = new.add_axes((0.0, bottom, 6.5 / 7.6, 6.5 / height), projection="3d")
    ax.computed_zorder = False
    ax.view_init(*view)
    ax.set_proj_type("ortho")
    ax.set_box_aspect((1, 1, 1), zoom=1.55)
    for limits in (ax.set_xlim, ax.set_ylim, ax.set_zlim):
        limits(-1.15 * size, 1.15 * size)
    ax.set_axis_off()
    return ax


def _heading(ax: Any, title: str, remark: str) -> None:
    """Write a title and a remark at the top of the figure."""
    place = {"transform": ax.figure.transFigure, "va": "top"}
    inch = 1 / ax.figure.get_figheight()
    ax.text2D(0.03, 1 - 0.16 * inch, title, fontsize=13, fontweight="bold", **place)
    ax.text2D(0.03, 1 - 0.45 * inch, remark, fontsize=10.5, color=INK, **place)


def _toward(ax: Any) -> Array:
    """Unit vector from the picture to the eye."""
    elevation, azimuth = np.deg2rad([ax.elev, ax.azim])
    return np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )


def _facing(ax: Any, points: Array, radii: Array) -> NDArray[np.bool_]:
    """Truth value for each point of an ellipsoid: it lies on the near side; the normal is (x_i / radius_i²)."""
    return np.asarray((points / radii**2) @ _toward(ax) >= 0)


def _segments(points: Array) -> Array:
    """Start and end of each segment of a line, shape (n - 1, 2, 3)."""
    return np.stack([points[:-1], points[1:]], axis=1)


def _line(
    ax: Any, points: Array, radii: Array, inside: bool = False, alpha: float = 1.0, **style: Any
) -> None:
    """Draw a line on the surface, pale on the far side; a line ``inside`` has one opacity."""
    from matplotlib.colors import to_rgba
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    segments = _segments(points)
    near = _facing(ax, segments.mean(axis=1), radii)
    rgb = to_rgba(style.pop("color"))[:3]
    parts = [(~near, BACK * alpha, FAR), (near, alpha, FRONT)]
    if inside:
        parts = [(np.ones(len(segments), bool), alpha, INSIDE)]
    for chosen, opacity, order in parts:
        if chosen.any():
            ax.add_collection3d(
                Line3DCollection(segments[chosen], colors=[(*rgb, opacity)], zorder=order, **style)
            )


def _colored(ax: Any, t: Array, points: Array, radii: Array) -> None:
    """Draw a path coloured by time, pale on the far side, and a colour bar of the time."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    shades = color_map()
    norm = Normalize(float(t[0]), float(t[-1]))
    segments = _segments(points)
    near = _facing(ax, segments.mean(axis=1), radii)
    colors = shades(norm((t[:-1] + t[1:]) / 2))
    # on the far side, overlapping round ends would show as dots, because the line is transparent
    for side, opacity, order, caps in ((~near, 0.55, FAR, "butt"), (near, 1.0, PATH, "round")):
        if side.any():
            chosen = colors[side].copy()
            chosen[:, 3] = opacity
            ax.add_collection3d(
                Line3DCollection(segments[side], colors=chosen, linewidths=2.2, capstyle=caps, zorder=order)
            )
    box = ax.get_position()
    bar_axes = ax.figure.add_axes((box.x1 + 0.02, 0.2, 0.018, 0.5))
    ticks = _ticks(float(t[0]), float(t[-1]))
    bar = ax.figure.colorbar(ScalarMappable(norm, shades), cax=bar_axes, ticks=ticks)
    bar.set_label("time [s]", fontsize=11)
    bar.outline.set_visible(False)


def _ticks(first: float, last: float) -> Array:
    """Round numbers between two."""
    from matplotlib.ticker import MaxNLocator

    ticks = np.asarray(MaxNLocator(6).tick_values(first, last), dtype=float)
    return ticks[(ticks >= first - 1e-12) & (ticks <= last + 1e-12)]


def _surface(ax: Any, radii: Array) -> None:
    """Draw meridians and parallels every 30 degrees on a pale ellipsoid."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    around, up = np.linspace(0, 2 * np.pi, 145), np.linspace(0, np.pi, 73)
    style: dict[str, Any] = {"color": "0.55", "linewidths": 0.6, "alpha": 0.8}
    for angle in np.deg2rad(np.arange(0, 360, 30)):
        meridian = np.stack([np.sin(up) * np.cos(angle), np.sin(up) * np.sin(angle), np.cos(up)], axis=-1)
        _line(ax, radii * meridian, radii, **style)
    for angle in np.deg2rad(np.arange(30, 180, 30)):
        parallel = np.stack(
            [
                np.sin(angle) * np.cos(around),
                np.sin(angle) * np.sin(around),
                np.full_like(around, np.cos(angle)),
            ],
            axis=-1,
        )
        _line(ax, radii * parallel, radii, **style)
    # the outline: a point x = D s, |s| = 1, has the normal D⁻¹ s, so D⁻¹ s · toward = 0
    first, second = _across(_toward(ax) / radii)
    rim = radii * (np.cos(around)[:, None] * first + np.sin(around)[:, None] * second)
    ax.add_collection3d(
        Poly3DCollection([rim], facecolor=GROUND, edgecolor="0.45", linewidths=1.1, zorder=SURFACE)
    )


def _circle(ax: Any, n: Array, angle: float) -> None:
    """Draw the circle on the unit sphere at an angle from a unit vector."""
    first, second = _across(n)
    turn = np.linspace(0, 2 * np.pi, 181)[:, None]
    points = np.cos(angle) * n + np.sin(angle) * (np.cos(turn) * first + np.sin(turn) * second)
    near = _facing(ax, points, np.ones(3))
    for side, alpha, order in ((near, 0.9, FRONT), (~near, 0.35, FAR)):
        part = np.where(side[:, None], points, np.nan)
        ax.plot(*part.T, color=INK, linewidth=1.0, linestyle=(0, (4, 3)), alpha=alpha, zorder=order)


def _stick(ax: Any, n: Array, name: str) -> None:
    """Draw a direction: a line from the surface outward, with its name."""
    order = FRONT if n @ _toward(ax) > 0 else FAR
    ax.plot(*np.array([n, 1.3 * n]).T, color=COLORS[1], linewidth=2, zorder=order)
    ax.text(*(1.38 * n), name, fontsize=11, color=COLORS[1], zorder=TEXT, **LABEL)


def _across(n: Array) -> tuple[Array, Array]:
    """Two unit vectors perpendicular to a vector and to each other."""
    first = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    first /= np.linalg.norm(first)
    second = np.cross(n, first)
    return first, second / np.linalg.norm(second)


def _frame(ax: Any) -> None:
    """Draw the vertical through the centre, and the ends of the ground axes."""
    dashes = {"color": INK, "linewidth": 1.2, "linestyle": (0, (7, 2, 1, 2))}
    ax.plot([0, 0], [0, 0], [-1, 1], zorder=INSIDE, alpha=0.6, **dashes)
    ends = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
    for name, end in ends.items():
        tip = np.array(end)
        order, alpha = (FRONT, 1.0) if tip @ _toward(ax) > 0 else (FAR, 0.5)
        ax.plot(*np.array([tip, 1.1 * tip]).T, color=INK, linewidth=1.2, zorder=order, alpha=alpha)
        ax.text(*(1.17 * tip), name, fontsize=12, color=INK, ha="center", va="center", zorder=TEXT)


def _tip(ax: Any, point: Array, name: str, hollow: bool = False, below: bool = False) -> None:
    """Draw a dot with its name above or below it."""
    face = "white" if hollow else INK
    ax.plot(
        *point[:, None], marker="o", markersize=6.5, markerfacecolor=face, markeredgecolor=INK, zorder=TEXT
    )
    if not name:
        return
    up = np.array([0.0, 0.0, 0.1 * float(np.max(np.abs(ax.get_zlim())))])
    ax.text(*(point - up if below else point + up), name, fontsize=10.5, color=INK, zorder=TEXT, **LABEL)


def _family(ax: Any, inertia: Array, radii: Array) -> None:
    """Draw lines of equal H² = Σ I_i² w_i² on the ellipsoid; the line through the middle axis is dark."""
    import contourpy

    around, up = np.linspace(0, 2 * np.pi, 241), np.linspace(0, np.pi, 121)
    a, b = np.meshgrid(around, up)
    unit = np.stack([np.sin(b) * np.cos(a), np.sin(b) * np.sin(a), np.cos(b)], axis=-1)
    # on the ellipsoid, H² / 2T = Σ I_i s_i²
    find = contourpy.contour_generator(a, b, (unit**2) @ inertia)
    low, middle, high = np.sort(inertia)
    parts = np.array([0.15, 0.5, 0.85])
    for level in (*(low + (middle - low) * parts), middle, *(middle + (high - middle) * parts)):
        style: dict[str, Any] = {"linewidths": 0.9, "color": COLORS[0], "alpha": 0.55}
        if level == middle:
            style = {"linewidths": 1.4, "color": INK, "alpha": 0.9}
        for line in find.lines(level):
            a, b = np.asarray(line).T
            s = np.stack([np.sin(b) * np.cos(a), np.sin(b) * np.sin(a), np.cos(b)], axis=-1)
            _line(ax, radii * s, radii, **style)
