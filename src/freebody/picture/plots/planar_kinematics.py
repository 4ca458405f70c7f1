"""Instant centres, velocity and acceleration diagrams of a planar machine at one time, and paths of its points.

Two bodies that turn by ω relative to each other about the normal n have the same velocity at the point

    p + n x v / ω,     v: velocity of one body relative to the other at the point p

(Norton, *Design of Machinery*, chapter 6). A diagram draws the velocities of the points of the joints from one pole, so
that the line between the ends of two of them is the velocity of one point relative to the other.

This file is longer than others: these diagrams share the machine at one time, and the way in which it is drawn.
"""

from __future__ import annotations

from itertools import combinations, pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...describe.frame import Point
from ...dynamics.kinematics import angular_velocity, point_acceleration, point_velocity
from ...errors import SimulationError, nearest
from ...model.closure import Closure
from ..machine.configuration import Configuration, configuration, equations_at
from ..machine.outlines import outlines, polygon
from ..machine.shapes import hidden
from ..machine.solid_pieces import pieces_of
from ..moving.keyframes import Named
from ..paper.view import View, view_of
from .labels import HORIZONTAL, VERTICAL, free_side
from .plots import COLORS, INK, PALE, _title, figure

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

SLOW = 1e-9
"""Relative rate of turning, as a part of the largest of the machine, below which two bodies only translate."""


class InstantCentre(NamedTuple):
    """Point at which two bodies have the same velocity.

    ``point`` is in ground axes [m], or None if the bodies translate relative to each other; ``direction`` is then the
    unit vector across their relative velocity, in which the centre is infinitely far, or None if they are at rest
    relative to each other.
    """

    point: Array | None
    direction: Array | None


class _Moment(NamedTuple):
    """A planar machine at one time of a motion."""

    now: Configuration
    view: View
    udot: Array
    bodies: list[str]


def _moment(trajectory: Trajectory, at: float | None) -> _Moment:
    equations = equations_at(trajectory.kernels.model, trajectory, at)
    now = configuration(equations.model, at, trajectory=trajectory)
    view = view_of(equations.model, equations, now.values)
    if not view.planar:
        raise SimulationError(
            f"Expected a planar machine for a diagram of velocities, but '{trajectory.name}' moves in space."
        )
    unseen = hidden(equations.model)
    udot = np.array([now.lookup[speed.acceleration] for speed in equations.model.speeds])
    return _Moment(now, view, udot, [name for name in equations.model.bodies if name not in unseen])


def centres(trajectory: Trajectory, at: float | None = None) -> dict[tuple[str, str], InstantCentre]:
    """Return the instant centres of all pairs of bodies of a planar machine, the ground among them.

    Parameters
    ----------
    trajectory : Trajectory
    at : float, optional
        The time [s]; by default the start.

    Returns
    -------
    dict
        (name, name) -> :class:`InstantCentre`; the pairs with the ground come first.

    Raises
    ------
    SimulationError
        If the machine moves in space.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("rolling")
    >>> wheel = s.body("wheel", fb.disk(1, 2))
    >>> plane = s.planar("plane", s.ground, wheel, coordinate="x y phi")
    >>> motion = fb.simulate(s, 1, initial={"x'": 6, "phi'": -3})
    >>> centres(motion)[("ground", "wheel")].point.round(9).tolist()
    [0.0, -2.0, 0.0]
    """
    moment = _moment(trajectory, at)
    now, model = moment.now, moment.now.model
    n = moment.view.toward
    frames: dict[str, tuple[float, Array]] = {"ground": (0.0, np.zeros(3))}
    places = {"ground": np.zeros(3)}
    for name in moment.bodies:
        frames[name] = (
            float(n @ np.array([float(x) for x in angular_velocity(model, now.state, Named(name))])),
            np.array([float(x) for x in point_velocity(model, now.state, _point(name, (0, 0, 0)))]),
        )
        places[name] = now.posture(name)[1]
    fastest = max((abs(w) for w, _ in frames.values()), default=0.0)
    result = {}
    for first, second in combinations(frames, 2):
        w = frames[second][0] - frames[first][0]
        # relative velocity at the origin of the second
        carried = frames[first][1] + frames[first][0] * np.cross(n, places[second] - places[first])
        v = frames[second][1] - carried
        v = v - (v @ n) * n
        speed = float(np.linalg.norm(v))
        if abs(w) > SLOW * max(fastest, 1e-300):
            result[first, second] = InstantCentre(places[second] + np.cross(n, v) / w, None)
        else:
            result[first, second] = InstantCentre(None, np.cross(n, v) / speed if speed > 0 else None)
    return result


def instant_centres(
    trajectory: Trajectory, ax: Any = None, *, at: float | None = None, title: str | None = None
) -> Any:
    """Draw a planar machine at one time with its instant centres.

    A dot marks the centre of two bodies, with their numbers in the order of the legend (0 is the ground). By the
    theorem of Kennedy and Aronhold the centres of three bodies lie on one line: those with the ground are drawn.

    Parameters
    ----------
    trajectory : Trajectory
    ax : Axes, optional
    at : float, optional
        The time [s]; by default the start.
    title : str, optional

    Returns
    -------
    Axes

    Raises
    ------
    SimulationError
        If the machine moves in space.

    Examples
    --------
    >>> import freebody as fb
    >>> from freebody.gallery import entries
    >>> four_bar = entries()["four-bar"]
    >>> motion = fb.simulate(four_bar.build(), 1.0, near=four_bar.near)
    >>> axes = fb.plot.instant_centres(motion, at=0.3)
    >>> sorted(text.get_text() for text in axes.texts)[0]
    '$P_{01}$'
    """
    moment = _moment(trajectory, at)
    ax = figure(7, 5.5).subplots() if ax is None else ax
    drawn = _outlines(ax, moment)
    numbers = {name: k for k, name in enumerate(["ground", *moment.bodies])}
    found = {pair: centre for pair, centre in centres(trajectory, at).items() if centre.point is not None}
    at_point: list[tuple[Array, list[str]]] = []
    size = float(np.ptp(drawn, axis=0).max()) if len(drawn) else 1.0
    for (first, second), centre in found.items():
        p = moment.view(centre.point)
        text = rf"$P_{{{numbers[first]}{numbers[second]}}}$"
        same = next((texts for q, texts in at_point if float(np.linalg.norm(q - p)) < 1e-6 * size), None)
        if same is None:
            at_point.append((p, [text]))
        else:
            same.append(text)
    for first, second in combinations(moment.bodies, 2):
        trio = [found.get(pair) for pair in (("ground", first), ("ground", second), (first, second))]
        points = [moment.view(centre.point) for centre in trio if centre is not None]
        if len(points) == 3:
            ends = np.array(points)
            along = ends[:, 0] if np.ptp(ends[:, 0]) > np.ptp(ends[:, 1]) else ends[:, 1]
            ax.plot(*ends[np.argsort(along)].T, color=PALE, linewidth=0.9, linestyle=(0, (6, 3)), zorder=1)
    box = (drawn.min(axis=0), drawn.max(axis=0)) if len(drawn) else (np.zeros(2), np.ones(2))
    for p, texts in at_point:
        if bool((p < box[0] - 1.5 * size).any() or (p > box[1] + 1.5 * size).any()):
            # the machine stays legible: its place is written
            label = f"{', '.join(texts)} beyond, at ({p[0]:.3g}, {p[1]:.3g})"
            ax.plot([], [], "o", color=COLORS[1], markersize=5, label=label)
            continue
        box = (np.minimum(box[0], p), np.maximum(box[1], p))
        ax.plot(*p, "o", color=COLORS[1], markersize=5, zorder=4)
        for k, text in enumerate(texts):
            ax.annotate(
                text, p, xytext=(6, 6 + 13 * k), textcoords="offset points", color=COLORS[1], zorder=5
            )
    ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    _finished(ax, trajectory, at, title, "$x$ [m]", "$y$ [m]")
    room = 0.1 * float(np.ptp(np.array(box), axis=0).max())
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlim(box[0][0] - room, box[1][0] + room)
    ax.set_ylim(box[0][1] - room, box[1][1] + room)
    return ax


def velocity_diagram(
    trajectory: Trajectory, ax: Any = None, *, at: float | None = None, title: str | None = None
) -> Any:
    """Draw the velocities of the joints of a planar machine from one pole.

    Arrows from the pole o are velocities in the ground; a line between two ends, in the colour of a body that has both
    points, is the velocity of one point relative to the other: at right angles to the line between the points.

    Parameters
    ----------
    trajectory : Trajectory
    ax : Axes, optional
    at : float, optional
        The time [s]; by default the start.
    title : str, optional

    Returns
    -------
    Axes

    Raises
    ------
    SimulationError
        If the machine moves in space.

    Examples
    --------
    >>> import freebody as fb
    >>> from freebody.gallery import entries
    >>> four_bar = entries()["four-bar"]
    >>> motion = fb.simulate(four_bar.build(), 1.0, near=four_bar.near)
    >>> axes = fb.plot.velocity_diagram(motion, at=0.3)
    >>> axes.get_xlabel()
    '$v_x$ [m/s]'
    """
    return _diagram(trajectory, ax, at, title, "v", "m/s")


def acceleration_diagram(
    trajectory: Trajectory, ax: Any = None, *, at: float | None = None, title: str | None = None
) -> Any:
    """Draw the accelerations of the joints of a planar machine from one pole.

    As :func:`velocity_diagram`; a line between the ends of two points of a body is α x r - ω² r.

    Parameters
    ----------
    trajectory : Trajectory
    ax : Axes, optional
    at : float, optional
        The time [s]; by default the start.
    title : str, optional

    Returns
    -------
    Axes

    Raises
    ------
    SimulationError
        If the machine moves in space.

    Examples
    --------
    >>> import freebody as fb
    >>> from freebody.gallery import entries
    >>> four_bar = entries()["four-bar"]
    >>> motion = fb.simulate(four_bar.build(), 1.0, near=four_bar.near)
    >>> axes = fb.plot.acceleration_diagram(motion, at=0.3)
    >>> axes.get_ylabel()
    '$a_y$ [m/s²]'
    """
    return _diagram(trajectory, ax, at, title, "a", "m/s²")


def _point(body: str, components: Any) -> Any:
    """A point of a body by its name."""
    frame: Any = Named(body)
    return Point(frame, components)


def _points(moment: _Moment) -> dict[str, list[tuple[str, Point]]]:
    """Points of the joints on each body, by body: (name of the joint, point)."""
    model = moment.now.model
    result: dict[str, list[tuple[str, Point]]] = {name: [] for name in moment.bodies}

    def add(body: str, joint: str, components: Any) -> None:
        if body in result:
            result[body].append((joint, _point(body, components)))

    for name, joint in model.joints.items():
        if joint.pair.revolute or joint.pair.spherical or joint.pair.prismatic:
            add(joint.child, name, joint.to)
            if joint.pair.revolute:
                add(joint.parent, name, joint.at)
    for name, closure in model.constraints.items():
        if isinstance(closure, Closure) and closure.pair.revolute:
            add(closure.child.name, name, closure.to)
            add(closure.parent.name, name, closure.at)
    for name in moment.bodies:
        center = model.bodies[name].center
        place = moment.now.place(name, center)
        if not any(np.allclose(place, moment.now.point(p)) for _, p in result[name]):
            result[name].append((f"C {name}".replace("_", " "), _point(name, center)))
    return result


def _diagram(
    trajectory: Trajectory, ax: Any, at: float | None, title: str | None, letter: str, unit: str
) -> Any:
    moment = _moment(trajectory, at)
    model, state = moment.now.model, moment.now.state
    ax = figure(6.5, 6).subplots() if ax is None else ax

    def value(point: Point) -> Array:
        exact = (
            point_velocity(model, state, point)
            if letter == "v"
            else point_acceleration(model, state, point, moment.udot.tolist())
        )
        return moment.view(np.array([float(x) for x in exact]))

    ends: dict[str, Array] = {}
    lines: list[tuple[Array, Array]] = []
    for k, (body, points) in enumerate(_points(moment).items()):
        values = [(name, value(point)) for name, point in points]
        for name, v in values:
            ends.setdefault(name, v)
        if len(values) > 1:
            line = np.array([v for _, v in values])
            label = body.replace("_", " ")
            ax.plot(*line.T, "-", color=COLORS[k % len(COLORS)], linewidth=2.0, label=label, zorder=2)
            lines += list(pairwise(line))
    longest = max((float(np.linalg.norm(v)) for v in ends.values()), default=0.0)
    shown: list[tuple[Array, list[str]]] = [(np.zeros(2), ["o"])]
    for name, v in ends.items():
        same = next(
            (names for q, names in shown if np.linalg.norm(q - v) < 1e-6 * max(longest, 1e-300)), None
        )
        if same is None:
            shown.append((v, [name]))
            arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.1, "shrinkA": 0, "shrinkB": 0}
            ax.annotate("", xy=v, xytext=(0, 0), arrowprops=arrow, zorder=3)
        else:
            same.append(name)
    # points of the arrows and lines that are drawn, which texts should not cover
    way = np.linspace(0, 1, 25)[:, None]
    taken = [way * v for v in ends.values()] + [a + way * (b - a) for a, b in lines]
    for v, names in shown:
        ax.plot(*v, "o", color=INK, markersize=3.5, zorder=4)
        text = ", ".join(names)
        side = free_side(v, len(text), longest, taken)
        ax.annotate(
            text, v, xytext=5 * side, textcoords="offset points", ha=HORIZONTAL[side[0]], va=VERTICAL[side[1]],
            color=INK, fontsize=10,
        )  # fmt: skip
    if ax.get_legend_handles_labels()[0]:
        ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    letters = [name for name, _ in moment.view.axes]
    labels = [f"${letter}_{name}$ [{unit}]" for name in letters]
    _finished(ax, trajectory, at, title, *labels)
    return ax


def _outlines(ax: Any, moment: _Moment) -> Array:
    """Draw the bodies of a machine; return the points of their outlines [m]."""
    pieces = pieces_of(moment.now, True)
    everything: list[Array] = []
    raw: list[Array] = []
    for name in moment.bodies:
        R, p = moment.now.posture(name)
        raw += [q for piece in pieces[name] for q in moment.view(p + piece.points() @ R.T)]
    size = float(np.ptp(np.array(raw), axis=0).max()) if raw else 1.0
    scale = 250.0 / size if size > 0 else 1.0
    for k, name in enumerate(moment.bodies):
        R, p = moment.now.posture(name)
        for piece in pieces[name]:
            for item in outlines(piece, R, p, moment.view, scale, "#ffffff"):
                area = polygon(item)
                if area is not None:
                    everything.append(area / scale)
                    label = f"{k + 1}: {name}".replace("_", " ") if piece is pieces[name][0] else None
                    color = COLORS[k % len(COLORS)]
                    ax.fill(
                        *(area / scale).T, facecolor=color, alpha=0.22, edgecolor=color, label=label, zorder=2
                    )
    ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return np.vstack(everything) if everything else np.zeros((0, 2))


def _finished(ax: Any, trajectory: Trajectory, at: float | None, title: str | None, x: str, y: str) -> None:
    ax.set_aspect("equal", adjustable="datalim")
    ax.grid(alpha=0.3)
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.margins(0.12)
    time = float(trajectory.t[0]) if at is None else at
    _title(ax, f"{trajectory.name}, t = {time:.4g} s" if title is None else title)


def coupler_curves(
    trajectory: Trajectory, points: Any, ax: Any = None, *, at: float | None = None, title: str | None = None
) -> Any:
    """Draw the paths of points of a planar machine, and the machine at one time.

    Parameters
    ----------
    trajectory : Trajectory
    points : Point or sequence of points
        Such as ``coupler.point(a, b, 0)``: the coupler curve of a four-bar linkage.
    ax : Axes, optional
    at : float, optional
        Time at which the machine is drawn [s]; by default the start.
    title : str, optional

    Returns
    -------
    Axes

    Raises
    ------
    SimulationError
        If the machine moves in space, or something is not a point of it.

    Examples
    --------
    >>> import freebody as fb
    >>> from freebody.gallery import entries
    >>> four_bar = entries()["four-bar"]
    >>> s = four_bar.build()
    >>> motion = fb.simulate(s, 1.0, near=four_bar.near)
    >>> axes = fb.plot.coupler_curves(motion, s.bodies["coupler"].point(0.1, 0.2, 0))
    >>> len(axes.lines[0].get_xdata()) > 100
    True
    """
    moment = _moment(trajectory, at)
    ax = figure(7, 5.5).subplots() if ax is None else ax
    chosen = list(points) if isinstance(points, list | tuple) else [points]
    _outlines(ax, moment)
    for k, point in enumerate(chosen):
        name = getattr(getattr(point, "body", None), "name", None)
        if not isinstance(point, Point) or not isinstance(name, str) or name not in moment.now.model.bodies:
            raise SimulationError(
                f"Expected points of bodies of '{trajectory.name}', such as body.point(x, y, z), got {point!r}; "
                f"{nearest(str(name), moment.now.model.bodies)}"
            )
        pose = trajectory.poses[name]
        local = np.array([float(moment.now.state(x)) for x in point.components])
        path = moment.view(pose.position + pose.rotation @ local)
        color = COLORS[(k + 1) % len(COLORS)]
        ax.plot(*path.T, color=color, linewidth=1.6, zorder=3)
        ax.plot(*moment.view(moment.now.point(point)), "o", color=color, markersize=5, zorder=4)
    _finished(ax, trajectory, at, title, "$x$ [m]", "$y$ [m]")
    return ax
