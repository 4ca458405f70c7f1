"""Plots of linear and steady motions: mode shapes, root loci along a parameter, bifurcations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError, nearest
from ...symbolic.linear.linear_model import LinearModel
from ...symbolic.linear.modes import Mode, Modes
from ...symbolic.steady.continuation import Branch
from .labels import SETTING, symbol
from .plots import COLORS, INK, PALE, _grid, _title, color_map, figure

Array = NDArray[Any]

STABLE = ("stable", "asymptotically stable")
LINES: dict[str, dict[str, Any]] = {
    "stable": {"color": COLORS[0], "linestyle": "-", "linewidth": 2.0},
    "not stable": {"color": COLORS[1], "linestyle": (0, (4, 3)), "linewidth": 1.3},
}


def mode_shapes(of: LinearModel | Modes, ax: Any = None, *, title: str | None = None) -> Any:
    """Mode shapes: a panel for each mode, with a bar for each coordinate relative to the largest.

    With damping or gyroscopic terms, the components of a mode are out of phase: the outline shows their size, the bar
    the part in phase with the largest, and the phase angle is written beside it.

    Parameters
    ----------
    of : LinearModel or Modes
        Linear equations in numbers, or their modes.
    ax : Axes or sequence of Axes, optional
        Axes for each mode.
    title : str, optional

    Returns
    -------
    array of Axes

    Raises
    ------
    ModelError
        If there are not as many axes as modes, or the linear model has symbols.
    """
    if isinstance(of, LinearModel) and of.symbolic:
        raise ModelError(
            "Expected linear equations in numbers to plot their modes, got symbols. Use linear.numeric({...})."
        )
    modes = of.modes() if isinstance(of, LinearModel) else of
    names = list(modes[0].shape)
    if ax is None:
        panels = figure(7.5, 0.9 + 0.55 * len(modes) * max(2.0, 0.55 * len(names))).subplots(
            len(modes), 1, squeeze=False, sharex=True
        )[:, 0]
    else:
        panels = np.atleast_1d(np.asarray(ax, dtype=object))
    if len(panels) != len(modes):
        raise ModelError(f"Expected an axes for each of {len(modes)} modes, got {len(panels)}.")
    place = np.arange(len(names))[::-1]
    for k, (panel, mode) in enumerate(zip(panels, modes, strict=True)):
        shape = np.array([complex(mode.shape[name]) for name in names])
        color = COLORS[k % len(COLORS)]
        panel.barh(place, shape.real, height=0.55, color=color, alpha=0.85)
        for y, x in zip(place, shape, strict=True):
            if abs(x.imag) > 1e-6 * np.abs(shape).max():
                panel.barh(
                    y, np.copysign(abs(x), x.real), height=0.55, fill=False, edgecolor=color, linestyle="--"
                )
                gap, alignment = (4, "left") if x.real >= 0 else (-4, "right")
                panel.annotate(
                    f"{np.rad2deg(np.angle(x)):.0f}°", (np.copysign(abs(x), x.real), y), xytext=(gap, 0),
                    textcoords="offset points", va="center", ha=alignment, fontsize=9, color=INK,
                )  # fmt: skip
        panel.axvline(0, color=INK, linewidth=0.9)
        panel.set_yticks(place, [symbol(name) for name in names], **SETTING)
        panel.set_ylim(-0.6, len(names) - 0.4)
        panel.set_xlim(-1.25, 1.25)
        for side in ("top", "right"):
            panel.spines[side].set_visible(False)
        panel.set_title(f"{k + 1}: {_described(mode)}", loc="left", fontsize=10.5)
    panels[-1].set_xlabel("part of the largest component")
    if title:
        panels[0].figure.suptitle(title, fontsize=12, fontweight="bold", x=0.02, ha="left")
    return panels


def _described(mode: Mode) -> str:
    """Kind of a mode with its frequency and damping ratio, or its rate."""
    if mode.kind == "oscillation":
        damping = f", damping ratio {float(mode.damping_ratio):.3g}" if abs(mode.damping_ratio) > 1e-9 else ""
        return f"oscillation at {float(mode.frequency):.4g} rad/s{damping}"
    if mode.kind in ("decay", "growth"):
        return f"{mode.kind} at {complex(mode.eigenvalue).real:.4g} 1/s"
    return str(mode.kind)


def root_locus(
    of: LinearModel | Callable[[float], Any],
    parameter: str,
    values: Sequence[float],
    ax: Any = None,
    *,
    over: str = "plane",
    title: str | None = None,
) -> Any:
    """Eigenvalues of linear equations as a parameter changes.

    Parameters
    ----------
    of : LinearModel, or function of a number
        Linear equations with the parameter as a symbol, or in numbers at these values; or a function that returns
        linear equations in numbers, or eigenvalues, for a value of the parameter.
    parameter : str
        Name of the parameter.
    values : sequence of numbers
        Values of the parameter, ascending or descending.
    ax : Axes, optional
    over : "plane" or "parameter"
        Draw in the complex plane, coloured by the parameter; or real parts (lines) and imaginary parts (dashed) over
        the parameter.
    title : str, optional

    Returns
    -------
    Axes

    Raises
    ------
    ModelError
        If the equations do not contain the parameter, or there are fewer than two values.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("oscillator")
    >>> m, k, c = s.parameters(m=1, k=4, c=0.5)
    >>> guide = s.slider("guide", s.ground, s.body("block", fb.particle(m)), coordinate="x")
    >>> spring, damper = s.spring("k", guide, stiffness=k), s.damper("c", guide, damping=c)
    >>> fb.plot.root_locus(fb.linearize(s), "c", [0, 1, 2, 3, 4, 5]).get_xlabel()
    'Re s [1/s]'
    """
    if over not in ("plane", "parameter"):
        raise ModelError(f"Expected over='plane' or over='parameter', got {over!r}.")
    p = np.asarray(values, dtype=float)
    if p.ndim != 1 or len(p) < 2 or not np.all(np.isfinite(p)):
        raise ModelError("Expected at least two finite values of the parameter for a root locus.")
    if isinstance(of, LinearModel) and not of.symbolic and np.array_equal(of.values.get(parameter, ()), p):
        roots = _joined(of.eigenvalues())
    else:
        roots = _joined([_roots(of, parameter, float(x)) for x in p])
    if ax is None:
        ax = figure(6.4, 5.4).subplots() if over == "plane" else figure(8, 4.6).subplots()
    if over == "plane":
        _in_plane(ax, parameter, p, roots)
    else:
        for i in range(roots.shape[1]):
            color = COLORS[i % len(COLORS)]
            ax.plot(p, roots[:, i].real, color=color, linewidth=1.6)
            moving = np.where(np.abs(roots[:, i].imag) > 0, np.abs(roots[:, i].imag), np.nan)
            ax.plot(p, moving, color=color, linewidth=1.2, linestyle=(0, (5, 2)))
        ax.axhline(0, color=INK, linewidth=0.9)
        ax.set_xlabel(symbol(parameter), **SETTING)
        ax.set_ylabel("Re s (lines), |Im s| (dashed)  [1/s]")
        ax.margins(x=0)
    _grid(ax)
    _title(ax, title or f"Eigenvalues as {parameter} changes")
    return ax


def _roots(of: Any, parameter: str, value: float) -> Array:
    """Eigenvalues at one value of the parameter."""
    if isinstance(of, LinearModel):
        if not of.symbolic:
            raise ModelError(
                f"Expected linear equations with '{parameter}' as a symbol, got numbers. Linearize without values, or "
                f"at these values: fb.linearize(..., values={{'{parameter}': ...}}); or pass a function of "
                f"{parameter}."
            )
        names = [p.name for p in of.model.parameters]
        if parameter not in names and parameter not in {
            str(x) for m in (of.M, of.C, of.K) for x in m.free_symbols
        }:
            raise ModelError(
                f"Unknown parameter '{parameter}' of the linear equations; {nearest(parameter, names)}"
            )
        of = of.numeric({parameter: value})
    elif callable(of):
        of = of(value)
    else:
        raise ModelError(
            f"Expected linear equations or a function of '{parameter}' that returns them, got {of!r}."
        )
    eigenvalues = of.eigenvalues() if isinstance(of, LinearModel) else of
    return np.atleast_1d(np.asarray(eigenvalues, dtype=complex))


def _joined(rows: Sequence[Array]) -> Array:
    """Eigenvalues with a continuous root in each column: each row is ordered for the least total distance."""
    from scipy.optimize import linear_sum_assignment

    result = [np.asarray(rows[0])]
    for row in rows[1:]:
        if len(row) != len(result[-1]):
            raise ModelError("Expected as many eigenvalues at every value of the parameter.")
        last = result[-1]
        # extrapolate the last step
        ahead = 2 * last - result[-2] if len(result) > 1 else last
        cost = np.abs(ahead[:, None] - row[None, :]) + np.abs(last[:, None] - row[None, :])
        _, order = linear_sum_assignment(cost)
        result.append(row[order])
    return np.array(result)


def _in_plane(ax: Any, parameter: str, p: Array, roots: Array) -> None:
    """Draw roots in the complex plane, coloured by the parameter."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize

    shades = color_map()
    norm = Normalize(float(p.min()), float(p.max()))
    ax.axvline(0, color=INK, linewidth=0.9)
    ax.axhline(0, color=PALE, linewidth=0.9)
    for i in range(roots.shape[1]):
        points = np.column_stack([roots[:, i].real, roots[:, i].imag])
        lines = np.stack([points[:-1], points[1:]], axis=1)
        ax.add_collection(
            LineCollection(list(lines), colors=shades(norm((p[1:] + p[:-1]) / 2)), linewidths=1.8)
        )
    for k, marker in ((0, "x"), (-1, "o")):
        ax.plot(
            roots[k].real, roots[k].imag, linestyle="none", marker=marker, markersize=6, markerfacecolor="white",
            markeredgecolor=shades(norm(p[k])), label=f"{symbol(parameter)} = {p[k]:.4g}", zorder=3,
        )  # fmt: skip
    ax.margins(0.08)
    ax.autoscale_view()
    ax.legend(frameon=False, loc="best", fontsize=10)
    bar = ax.figure.colorbar(ScalarMappable(norm, shades), ax=ax)
    bar.set_label(parameter)
    bar.outline.set_visible(False)
    ax.set_xlabel("Re s [1/s]")
    ax.set_ylabel("Im s [rad/s]")


def bifurcation(
    branches: Branch | Sequence[Branch],
    unknown: str | None = None,
    ax: Any = None,
    *,
    title: str | None = None,
) -> Any:
    """Steady motions along a parameter: stable branches as lines, other branches dashed, folds and bifurcations marked.

    Parameters
    ----------
    branches : Branch or sequence of Branch
        From ``fb.steady_motions(s).continuation(parameter, span)``.
    unknown : str, optional
        Unknown on the vertical axis; by default the first.
    ax : Axes, optional
    title : str, optional

    Returns
    -------
    Axes

    Raises
    ------
    ModelError
        If there is no branch, or the name is unknown.
    """
    from matplotlib.lines import Line2D

    listed = [branches] if isinstance(branches, Branch) else list(branches)
    if not listed:
        raise ModelError("Expected at least one branch of steady motions to plot, got none.")
    names = list(listed[0].values)
    name = names[0] if unknown is None else unknown
    if name not in names:
        raise ModelError(f"Unknown unknown '{name}' of the steady motions; {nearest(str(name), names)}")
    ax = figure(7, 4.8).subplots() if ax is None else ax
    kinds: dict[str, Any] = {}
    for branch in listed:
        stable = np.array([verdict in STABLE for verdict in branch.stable])
        for kind, chosen in (("stable", stable), ("not stable", ~stable)):
            if not chosen.any():
                continue
            # a segment between two points has the stability of its first point
            points = chosen | np.concatenate([[False], chosen[:-1]])
            ax.plot(branch.parameters, np.where(points, branch.values[name], np.nan), **LINES[kind])
            kinds.setdefault(kind, Line2D([], [], label=kind, **LINES[kind]))
        for point in branch.special:
            marker = "s" if point.kind == "fold" else "o"
            style: dict[str, Any] = {
                "linestyle": "none", "marker": marker, "markersize": 6.5, "markerfacecolor": "white",
                "markeredgecolor": INK,
            }  # fmt: skip
            ax.plot(point.parameter, point.values[name], zorder=4, **style)
            kinds.setdefault(point.kind, Line2D([], [], label=point.kind, **style))
    ax.set_xlabel(symbol(listed[0].parameter), **SETTING)
    ax.set_ylabel(name)
    _grid(ax)
    ax.legend(handles=list(kinds.values()), frameon=False, fontsize=10)
    _title(ax, title or f"Steady motions: {name} over {listed[0].parameter}")
    return ax
