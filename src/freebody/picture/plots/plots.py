"""Plots of a motion: quantities over time, reactions, the energy ledger, the phase plane.

Every function takes a trajectory and returns matplotlib axes; ``ax=`` draws into existing axes. Nothing is shown or
saved: use ``axes.figure.savefig(path)``. Figures are made without pyplot, so that no window opens and no figure stays
in memory.

This file is longer than others: these plots share the way they mark events and finish axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError, nearest
from .labels import SETTING, label, name_of, symbol, text_of, unit, with_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

COLORS = ("#1f5fa8", "#c8452d", "#3a8f5c", "#7b4ca0", "#b58a1b", "#3b8ea5")
INK, PALE = "0.25", "0.75"
MOST_MARKS = 80
"""Most events that a phase plane has room for."""

FEW = 12
"""Most events that are marked on the curves of a plot over time; more are ticks on the time axis."""

LINE, LONGEST, BESIDE = 1 / 13, 24, 1.07
"""Least distance of the right ends of curves, relative to the height of the panel, and greatest length of their names,
for names beside the curves in place of a legend; place of a second scale then."""

APART = 1 / 300
"""Least distance between two ticks, relative to the length of the motion."""


def figure(width: float, height: float) -> Any:
    """Return a new figure without a window; its size is in inches. Powers of ten at its axes are set: × 10⁵."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import ScalarFormatter

    def set_powers(changed: Figure) -> None:
        for ax in changed.axes:
            for formatter in (ax.xaxis.get_major_formatter(), ax.yaxis.get_major_formatter()):
                if isinstance(formatter, ScalarFormatter):
                    formatter.set_useMathText(True)

    result = Figure(figsize=(width, height), layout="constrained")
    result.add_axobserver(set_powers)
    FigureCanvasAgg(result)
    return result


def saved(draw: Callable[[], Any], dpi: int = 150) -> Callable[[Any], None]:
    """Return a function that writes the axes that ``draw`` returns to a path, as PNG."""

    def write(path: Any) -> None:
        axes = np.ravel(np.asarray(draw(), dtype=object))[0]
        axes.figure.savefig(path, dpi=dpi, format="png")

    return write


def color_map() -> Any:
    """Return a colour map without the brightest yellow, which cannot be seen on white."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    return ListedColormap(colormaps["plasma"](np.linspace(0, 0.88, 256)))


def history(
    trajectory: Trajectory,
    names: Any = None,
    ax: Any = None,
    *,
    title: str | None = None,
    events: bool = True,
) -> Any:
    """Quantities over time, with the events marked.

    Parameters
    ----------
    trajectory : Trajectory
    names : name, expression or sequence of them, optional
        As for ``trajectory[...]``; by default all coordinates. Quantities of one unit share a panel.
    ax : Axes, optional
        Axes for all quantities.
    title : str, optional
    events : bool
        Mark the events on the curves, unless there are too many.

    Returns
    -------
    Axes, or array of Axes if there are several panels
        An angle has a second scale on the right, in degrees.
    """
    listed = _listed(trajectory, names)
    groups: dict[str, list[Any]] = {}
    for name in listed:
        groups.setdefault(unit(trajectory, name) if ax is None else "", []).append(name)
    if ax is not None:
        panels = [ax]
    else:
        new = figure(8, 1.4 + 2.6 * len(groups))
        panels = list(new.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0])
    color = iter(COLORS * (1 + len(listed) // len(COLORS)))
    kinds = _event_kinds(trajectory) if events and len(trajectory.events) <= FEW else {}
    for panel, group in zip(panels, groups.values(), strict=True):
        handles = []
        for name in group:
            shade = next(color)
            handles.append(
                _curve(panel, trajectory, trajectory[name], shade, label(trajectory, name), name=name)
            )
            _mark(panel, trajectory, name, kinds, shade)
        units = {unit(trajectory, name) for name in group}
        _finish(panel, label(trajectory, group[0]) if len(group) == 1 else "", units)
        handles = _unnamed(panel, handles) if len(group) > 1 else []
        marks = _event_handles(kinds, trajectory) if kinds or not events else _ticks(panel, trajectory)
        _legend(panel, handles + (marks if panel is panels[0] else []))
    panels[-1].set_xlabel("time [s]")
    if title:
        _title(panels[0], title)
    return panels[0] if len(panels) == 1 else np.array(panels, dtype=object)


def pieces(trajectory: Trajectory, name: Any = None) -> list[Any]:
    """Numbers of the output times in pieces within which a quantity does not jump; a coordinate never jumps.

    Speeds jump at a blow or an impact; accelerations and forces also jump where a contact changes its mode.
    """
    path: Any = trajectory.path
    numbers = np.arange(len(trajectory.t))
    segments = getattr(path, "segments", None)
    if segments is None or name in trajectory.kernels.model.coordinate_names:
        return [numbers]
    places = path.places(trajectory.t)
    if name is not None and text_of(trajectory, name) in trajectory.names:
        # a speed: only the times at which it jumps
        k = trajectory.place(name)
        jumps = [
            i + 1
            for i, (a, b) in enumerate(zip(segments, segments[1:], strict=False))
            if abs(b.path.states[0][k] - a.path.states[-1][k])
            > 1e-9 * max(abs(float(a.path.states[-1][k])), abs(float(b.path.states[0][k])))
        ]
        places = np.searchsorted(jumps, places, side="right")
    cuts = np.flatnonzero(np.diff(places)) + 1
    return [piece for piece in np.split(numbers, cuts) if len(piece)]


def reaction(trajectory: Trajectory, joint: str, ax: Axes | None = None, *, axes: str = "xyz") -> Any:
    """Force of a joint on its child body over time, components in ground axes.

    Parameters
    ----------
    trajectory : Trajectory
    joint : str
    ax : Axes, optional
    axes : str
        Components to draw, such as "xy".

    Returns
    -------
    Axes
    """
    joint_reaction = trajectory.reactions[joint]
    ax = figure(8, 4).subplots() if ax is None else ax
    for axis, color in zip(axes, COLORS, strict=False):
        values = joint_reaction.force[:, "xyz".index(axis)]
        _curve(ax, trajectory, values, color, symbol(f"{joint}_{axis}"))
    on = joint_reaction.on
    _over_time(ax, f"force on {on}", {"N"}, f"Reaction of joint {joint}, on {on}", legend=len(axes) > 1)
    return ax


def energy_residual(trajectory: Trajectory, ax: Axes | None = None) -> Any:
    """Imbalance of the energy ledger over time, (T + V) - (T₀ + V₀) - W, relative to the greatest of T, V and W.

    Returns
    -------
    Axes
    """
    ledger = trajectory.energy
    scale = (
        max(float(np.max(np.abs(part))) for part in (ledger.kinetic, ledger.potential, ledger.work)) or 1.0
    )
    ax = figure(8, 3.6).subplots() if ax is None else ax
    ax.axhline(0, color=PALE, linewidth=1)
    ax.plot(trajectory.t, ledger.residual / scale, color=COLORS[0], linewidth=1.2)
    _finish(ax, "residual / greatest energy", set())
    ax.ticklabel_format(axis="y", style="sci", scilimits=(0, 0), useMathText=True)
    ax.set_xlabel("time [s]")
    ax.set_title("Energy ledger: what is left unbalanced", loc="left", fontsize=12, fontweight="bold", pad=24)
    return ax


def energy(trajectory: Trajectory, ax: Axes | None = None) -> Any:
    """Energy ledger over time: kinetic and potential energy, their sum, and the work done.

    Without loads that do work, the sum is constant; :func:`energy_residual` shows how exactly.

    Parameters
    ----------
    trajectory : Trajectory
    ax : Axes, optional

    Returns
    -------
    Axes
    """
    ledger = trajectory.energy
    curves = {"kinetic T": ledger.kinetic, "potential V": ledger.potential, "T + V": ledger.total}
    if trajectory.kernels.works or np.any(ledger.work):
        curves["work W"] = ledger.work
    if ledger.correction is not None and ledger.correction.any():
        curves["moved apart, part of W"] = ledger.correction
    ax = figure(8, 4).subplots() if ax is None else ax
    for (shown, values), color, dashes in zip(
        curves.items(), COLORS, ("-", "-", "--", ":", "-."), strict=False
    ):
        _curve(ax, trajectory, values, color, shown, dashes)
    _over_time(ax, "energy", {"J"}, "Energy ledger")
    return ax


def phase(
    trajectory: Trajectory,
    name: Any = None,
    against: Any = None,
    ax: Axes | None = None,
    *,
    title: str | None = None,
) -> Any:
    """Path of the motion in the phase plane: a quantity against another, by default against its rate.

    Parameters
    ----------
    trajectory : Trajectory
    name : name or expression, optional
        Horizontal; by default the first coordinate.
    against : name or expression, optional
        Vertical; by default the rate of ``name``.
    ax : Axes, optional
    title : str, optional

    Returns
    -------
    Axes
        The start is a circle, the end a dot; events are marked.

    Raises
    ------
    SimulationError
        If ``against`` is not given and the rate of ``name`` has no name, as for an expression.
    """
    quantity = _listed(trajectory, name)[0]
    text = text_of(trajectory, quantity)
    if against is None:
        against = f"{text}'"
        if against not in trajectory.names:
            raise SimulationError(
                f"Expected a coordinate whose rate is a speed of the machine, got '{text}'. Name the vertical "
                f"quantity, such as phase(trajectory, {text!r}, 't')."
            )
    x, y = trajectory[quantity], trajectory[against]
    ax = figure(5.6, 5).subplots() if ax is None else ax
    for piece in pieces(trajectory, against):
        ax.plot(x[piece], y[piece], color=COLORS[0], linewidth=1.4)
    for i, face in ((0, "white"), (-1, COLORS[0])):
        ax.plot(
            x[i], y[i], marker="o", markersize=6.5, markerfacecolor=face, markeredgecolor=COLORS[0], zorder=3
        )
    other = text_of(trajectory, against)
    kinds = _event_kinds(trajectory) if len(trajectory.events) <= MOST_MARKS else {}
    if text in trajectory.names and other in trajectory.names:
        for kind, marker in kinds.items():
            states = [event.state for event in trajectory.events if event.name == kind]
            ax.plot(
                [state[text] for state in states], [state[other] for state in states], linestyle="none", marker=marker,
                markersize=5, markerfacecolor="white", markeredgecolor=INK, zorder=3,
            )  # fmt: skip
        _legend(ax, _event_handles(kinds, trajectory))
    for name, set_label in ((text, ax.set_xlabel), (other, ax.set_ylabel)):
        set_label(with_unit(label(trajectory, name), unit(trajectory, name)), **SETTING)
    _grid(ax)
    _title(ax, title or f"Phase plane of {label(trajectory, text)}")
    return ax


# -- parts of the plots ---------------------------------------------------------------------------------------


def _curve(
    ax: Any,
    trajectory: Trajectory,
    values: Array,
    color: str,
    label: str | None,
    style: str = "-",
    name: Any = None,
) -> Any:
    """Draw a quantity over time, interrupted at its jumps; return its first line, which has the label."""
    lines = [
        ax.plot(
            trajectory.t[piece], values[piece], color=color, linewidth=1.6, linestyle=style,
            label=label if k == 0 and label else "_nolegend_",
        )[0]
        for k, piece in enumerate(pieces(trajectory, name))
    ]  # fmt: skip
    return lines[0]


def _over_time(ax: Any, label: str, units: set[str], title: str, *, legend: bool = True) -> None:
    """Finish a panel of quantities over time: labels, legend and title."""
    _finish(ax, label, units)
    _legend(ax, _unnamed(ax, ax.get_legend_handles_labels()[0]) if legend else [])
    ax.set_xlabel("time [s]")
    _title(ax, title)


def _listed(trajectory: Trajectory, names: Any) -> list[Any]:
    """Quantities as a list; all coordinates for None."""
    if names is None:
        return list(trajectory.kernels.model.coordinate_names)
    if isinstance(names, str) or not isinstance(names, Sequence):
        return [names]
    if not names:
        raise SimulationError(
            "Expected at least one name to plot, got none. Leave names out for all coordinates."
        )
    return list(names)


def _grid(ax: Any) -> None:
    """Draw a pale grid behind the curves."""
    ax.grid(color="0.9", linewidth=0.8)
    ax.set_axisbelow(True)


def _finish(ax: Any, shown: str, units: set[str]) -> None:
    """Label the vertical axis with its unit, if there is one, and a second scale in degrees for radians."""
    common = units.pop() if len(units) == 1 else ""
    ax.set_ylabel(with_unit(shown, common), **SETTING)
    _grid(ax)
    ax.margins(x=0)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    if common == "rad":
        degrees = ax.secondary_yaxis("right", functions=(np.rad2deg, np.deg2rad))
        degrees.set_ylabel("[deg]", fontsize=11)
        degrees.spines["right"].set_visible(False)


def _title(ax: Any, title: str) -> None:
    """Set the title, above the legend of the panel if it has one."""
    pad = 30 if ax.get_legend() else 10
    ax.set_title(title, loc="left", fontsize=12, fontweight="bold", pad=pad, math_fontfamily="stix")


def _unnamed(ax: Any, handles: list[Any]) -> list[Any]:
    """Write the names of curves at their right ends, if these are apart; return the handles that need a legend."""
    curves = [line for line in handles if len(line.get_xdata()) and line.get_linestyle() != "None"]
    low, high = ax.get_ylim()
    ends = [_end(ax, line) for line in curves]
    heights = sorted((end - low) / (high - low) for end in ends)
    names = [line.get_label() for line in curves]
    close = any(not b - a >= LINE for a, b in zip(heights, heights[1:], strict=False))
    if len(curves) < 2 or close or not np.isfinite(heights).all() or max(map(len, names)) > LONGEST:
        return handles
    for scale in ax.child_axes:  # degrees, to the right of the names
        scale.set_location(BESIDE)
    for line, name, end in zip(curves, names, ends, strict=True):
        ax.annotate(
            name, (1, end), (5, 0), xycoords=ax.get_yaxis_transform(), textcoords="offset points", va="center",
            color=line.get_color(), annotation_clip=False, **SETTING,
        )  # fmt: skip
    return [line for line in handles if line not in curves]


def _end(ax: Any, line: Any) -> float:
    """Value of a curve at the end of the time, where its last piece ends."""
    color, style = line.get_color(), line.get_linestyle()
    own = [
        x
        for x in ax.get_lines()
        if (x.get_color(), x.get_linestyle()) == (color, style) and len(x.get_xdata())
    ]
    return float(np.asarray(max(own, key=lambda x: x.get_xdata()[-1]).get_ydata())[-1])


def _legend(ax: Any, handles: list[Any]) -> None:
    """Add a legend in one row above the panel, where it covers no curve."""
    from matplotlib.font_manager import FontProperties

    if handles:
        ax.legend(
            handles=handles, loc="lower left", bbox_to_anchor=(0, 1), ncols=6, frameon=False, borderaxespad=0.2,
            borderpad=0.2, handletextpad=0.5, handlelength=1.4, columnspacing=1.6,
            prop=FontProperties(size=11, math_fontfamily="stix"),
        )  # fmt: skip


_MARKS = "ovsD^P"


def _event_kinds(trajectory: Trajectory) -> dict[str, str]:
    """Marker of the events of each name."""
    names = dict.fromkeys(event.name for event in trajectory.events)
    return {name: _MARKS[i % len(_MARKS)] for i, name in enumerate(names)}


def _mark(ax: Any, trajectory: Trajectory, name: Any, kinds: dict[str, str], color: str) -> None:
    """Draw a marker on the curve at each event."""
    text = text_of(trajectory, name)
    if text not in trajectory.names:
        return
    for kind, marker in kinds.items():
        events = [event for event in trajectory.events if event.name == kind]
        ax.plot(
            [event.time for event in events], [event.state[text] for event in events],
            linestyle="none", marker=marker, markersize=5, markerfacecolor="white",
            markeredgecolor=color, markeredgewidth=1.2, clip_on=False, zorder=3,
        )  # fmt: skip


def _ticks(ax: Any, trajectory: Trajectory) -> list[Any]:
    """Draw a tick on the time axis at each event, thinned; return the legend entry."""
    times = sorted(float(event.time) for event in trajectory.events)
    least = APART * abs(float(trajectory.t[-1] - trajectory.t[0]))
    kept: list[float] = []
    for time in times:
        if not kept or time - kept[-1] >= least:
            kept.append(time)
    if not kept:
        return []
    names = ", ".join(_event_label(trajectory, kind) for kind in _event_kinds(trajectory))
    return list(
        ax.plot(
            kept, [0.0] * len(kept), linestyle="none", marker=2, markersize=6, color=INK, clip_on=False,
            transform=ax.get_xaxis_transform(), label=names if len(names) <= 60 else "events", zorder=3,
        )
    )  # fmt: skip


def _event_handles(kinds: dict[str, str], trajectory: Trajectory) -> list[Any]:
    """Legend entries of the events."""
    from matplotlib.lines import Line2D

    style: dict[str, Any] = {
        "linestyle": "none",
        "markersize": 5,
        "markerfacecolor": "white",
        "markeredgecolor": INK,
    }
    return [
        Line2D([], [], marker=marker, label=_event_label(trajectory, kind), **style)
        for kind, marker in kinds.items()
    ]


def _event_label(trajectory: Trajectory, kind: str) -> str:
    """Name of an event, or of what changes at it."""
    contacts = {contact.name for contact in trajectory.kernels.model.contacts}
    return f"change at {kind}" if kind in contacts else name_of(kind)


def body_rotation(trajectory: Trajectory, body: str) -> Array:
    """R_NB of a body at the output times, shape (n, 3, 3)."""
    if body not in trajectory.poses:
        raise SimulationError(f"Unknown body '{body}'; {nearest(str(body), trajectory.poses)}")
    return trajectory.poses[body].rotation


def angular_velocity(trajectory: Trajectory, body: str) -> Array:
    """Angular velocity of a body in the ground at the output times, in ground axes, shape (n, 3) [rad/s]."""
    from ...dynamics.kinematics import angular_velocity as of_body
    from ...motion.kernels.program import at_states
    from ..moving.keyframes import Named

    if body not in trajectory.poses:
        raise SimulationError(f"Unknown body '{body}'; {nearest(str(body), trajectory.poses)}")
    kernels = trajectory.kernels
    program = kernels.program(
        ("spin", body), lambda state: {"spin": list(of_body(kernels.model, state, Named(body)))}
    )
    constants = program.constants(kernels.parameters(trajectory.numbers))
    return at_states(program, "spin", trajectory.t, trajectory.states, constants)
