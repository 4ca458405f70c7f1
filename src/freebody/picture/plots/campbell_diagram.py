"""Campbell's diagram: natural frequencies of a rotor over its speed, with sense of whirl and critical speeds.

The whirl of two displacements x = Re(X exp(iωt)), y = Re(Y exp(iωt)) across the shaft goes from x to y if
Im(X* Y) < 0: forward if the shaft turns so too (Genta, *Dynamics of Rotating Systems*, section 2.6).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError, nearest
from ...symbolic.linear.linear_model import LinearModel
from .labels import SETTING, symbol
from .linear_plots import _joined
from .plots import COLORS, INK, PALE, _grid, _title, figure

Array = NDArray[Any]

FLAT = 1e-6
"""Area of the path of a whirl, relative to a circle, below which it is a line without a sense."""

SENSES: dict[str, dict[str, Any]] = {
    "forward": {"color": COLORS[0], "linestyle": "-"},
    "backward": {"color": COLORS[1], "linestyle": (0, (5, 2))},
    "neither": {"color": INK, "linestyle": (0, (1, 2))},
}


def campbell(
    of: LinearModel | Callable[[float], LinearModel],
    speed: str,
    values: Sequence[float],
    ax: Any = None,
    *,
    whirl: tuple[str, str],
    orders: Sequence[float] = (1,),
    title: str | None = None,
) -> Any:
    """Draw the natural frequencies of a rotor over its speed.

    Forward whirl is drawn as lines, backward whirl dashed, motion along a line dotted. Where a frequency is a multiple
    of the speed in ``orders``, a dot marks the critical speed; unbalance excites the order 1.

    Parameters
    ----------
    of : LinearModel, or function of a number
        Linear equations with the speed as a symbol; or a function that returns linear equations in numbers.
    speed : str
        Name of the parameter that is the angular velocity of the shaft [rad/s].
    values : sequence of numbers
        Its values, ascending.
    ax : Axes, optional
    whirl : two coordinates
        Displacements, or angles, along two axes across the shaft; the shaft turns from the first to the second.
    orders : sequence of numbers
        Lines ω = n Ω to draw.
    title : str, optional

    Returns
    -------
    Axes

    Raises
    ------
    ModelError
        If the equations do not contain the speed or the coordinates, the number of oscillations changes, or there are
        fewer than two values.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("rotor")
    >>> I_t, I_p, k, Omega = s.parameters(I_t=2, I_p=1, k=200, Omega=5)
    >>> outer, inner = s.body("outer", fb.particle(0)), s.body("inner", fb.particle(0))
    >>> rotor = s.body("rotor", fb.MassProperties(1, (0, 0, 0), ((I_t, 0, 0), (0, I_t, 0), (0, 0, I_p))))
    >>> a = s.hinge("a", s.ground, outer, axis="x", coordinate="alpha")
    >>> b = s.hinge("b", outer, inner, axis="y", coordinate="beta")
    >>> shaft = s.hinge("shaft", inner, rotor, axis="z", coordinate=Omega*s.t)
    >>> springs = s.torsion_spring("k_a", a, stiffness=k), s.torsion_spring("k_b", b, stiffness=k)
    >>> linear = fb.linearize(s, about={"alpha": 0, "beta": 0})
    >>> axes = fb.plot.campbell(linear, "Omega", range(1, 25), whirl=("alpha", "beta"))
    >>> [label.split(":")[0] for label in axes.get_legend_handles_labels()[1]]
    ['forward whirl', 'backward whirl', '1 x speed', 'critical']
    """
    p = np.asarray(list(values), dtype=float)
    if p.ndim != 1 or len(p) < 2 or not np.all(np.diff(p) > 0):
        raise ModelError("Expected at least two values of the speed, ascending, for Campbell's diagram.")
    rows = [_oscillations(of, speed, float(x), whirl) for x in p]
    frequencies = _joined([row[0] for row in rows]).imag
    senses = _senses(rows, frequencies, p)
    ax = figure(7.5, 5).subplots() if ax is None else ax
    named: set[str] = set()
    for i in sorted(range(frequencies.shape[1]), key=lambda i: list(SENSES).index(senses[i])):
        sense = senses[i]
        label = f"{sense} whirl" if sense != "neither" else "along a line"
        ax.plot(p, frequencies[:, i], linewidth=1.8, label=None if label in named else label, **SENSES[sense])
        named.add(label)
    critical = []
    for order in orders:
        ax.plot(p, order * p, color=PALE, linewidth=1.2, label=f"{order:g} x speed", zorder=1)
        for i in range(frequencies.shape[1]):
            gap = frequencies[:, i] - order * np.abs(p)
            for k in np.flatnonzero(gap[:-1] * gap[1:] < 0).tolist():
                share = gap[k] / (gap[k] - gap[k + 1])
                at = float(p[k] + share * (p[k + 1] - p[k]))
                critical.append((at, order * abs(at)))
    met = ", ".join(f"{at:.4g}" for at, _ in sorted(critical))
    for number, (x, y) in enumerate(sorted(critical)):
        text = f"critical: {met} rad/s" if number == 0 else None
        ax.plot(x, y, "o", color=INK, markersize=5, label=text, zorder=4)
    ax.set_xlabel(f"{symbol(speed)} [rad/s]", **SETTING)
    ax.set_ylabel("natural frequency [rad/s]")
    ax.set_ylim(bottom=0, top=1.08 * float(frequencies.max()))
    ax.margins(x=0)
    _grid(ax)
    ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    _title(ax, title or "Campbell's diagram")
    return ax


def _oscillations(of: Any, speed: str, value: float, whirl: tuple[str, str]) -> tuple[Array, Array]:
    """Eigenvalues with Im s > 0 at a speed, and signed areas of their whirls: 1 for a circle from first to second."""
    if isinstance(of, LinearModel):
        names = {p.name for p in of.model.parameters}
        if not of.symbolic or speed not in names:
            raise ModelError(
                f"Expected linear equations with '{speed}' as a symbol, or a function of it, for Campbell's diagram; "
                f"{nearest(speed, names)}"
            )
        linear: Any = of.numeric({speed: value})
    else:
        linear = of(value)
    roots, areas = [], []
    for mode in linear.modes():
        if mode.kind != "oscillation" and complex(mode.eigenvalue).imag <= 0:
            continue
        missing = [name for name in whirl if name not in mode.shape]
        if missing:
            raise ModelError(
                f"Expected two coordinates of the linear equations for whirl=, got '{missing[0]}'; "
                f"{nearest(missing[0], mode.shape)}"
            )
        x, y = (complex(mode.shape[name]) for name in whirl)
        roots.append(complex(mode.eigenvalue))
        size = abs(x) ** 2 + abs(y) ** 2
        areas.append(-2 * (x.conjugate() * y).imag / size if size > 0 else 0.0)
    if not roots:
        raise ModelError(f"Expected oscillations for Campbell's diagram, got none at {speed} = {value:g}.")
    return np.array(roots), np.array(areas)


def _senses(rows: list[tuple[Array, Array]], frequencies: Array, speeds: Array) -> list[str]:
    """Sense of each joined branch: of the whirl in the middle of its values, relative to the turn of the shaft."""
    result = []
    for i in range(frequencies.shape[1]):
        total = 0.0
        for (roots, areas), frequency, speed in zip(rows, frequencies[:, i], speeds, strict=True):
            k = int(np.argmin(np.abs(roots.imag - frequency)))
            total += float(areas[k]) * float(np.sign(speed))
        mean = total / len(rows)
        result.append("neither" if abs(mean) < FLAT else "forward" if mean > 0 else "backward")
    return result
