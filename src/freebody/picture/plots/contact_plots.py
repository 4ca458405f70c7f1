"""Plots of contacts over time: forces, gaps, and what friction has left. No curve runs through a jump."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError, nearest
from ...motion.start.initial import number
from ..machine.shapes import machine_size
from .plots import COLORS, PALE, _finish, _legend, _title, figure, pieces

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

ROUND_OFF = 1e-9
"""Gaps below this part of the size of the machine are drawn as none."""

LEAST = "least in norm"

MOST = 12
"""Contacts that one plot shows without being asked for by name."""


def friction_margin(trajectory: Trajectory, contacts: Any = None, ax: Axes | None = None) -> Axes:
    """What friction has left at each contact over time: μ_s N - |T| while it sticks, zero where it slips.

    Parameters
    ----------
    trajectory : Trajectory
        Of a machine with contacts.
    contacts : str or sequence of str, optional
        Names; all with friction if not given.
    ax : Axes, optional

    Returns
    -------
    Axes
        A curve [N] for each contact, with a gap where it is open; dotted where the motion does not determine the
        forces, which are then those least in norm.

    Raises
    ------
    SimulationError
        A machine without contacts, unknown names, contacts without friction.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("block")
    >>> s.gravity = (3, -9, 0)
    >>> block = s.body("block", fb.sphere(2, 0.1))
    >>> joint = s.planar("plane", s.ground, block, coordinate="x y phi")
    >>> floor = s.contact("floor", block.point(0, 0, 0), s.ground.plane(), friction=0.5)
    >>> ax = fb.plot.friction_margin(fb.simulate(s, 1.0))
    >>> [round(float(y), 9) for y in ax.lines[1].get_ydata()[:2]]
    [3.0, 3.0]
    """
    found = _contacts(trajectory)
    rough = {c.name for c in trajectory.kernels.model.contacts if not c.frictionless}
    names = _names(trajectory, contacts, [name for name in found if name in rough])
    for name in names:
        if name not in rough:
            raise SimulationError(f"Contact '{name}' has no friction, and so no margin of friction.")
    ax = figure(8, 4).subplots() if ax is None else ax
    ax.axhline(0.0, color=PALE, linewidth=1.2)
    for i, name in enumerate(names):
        # the law is exact where it slips, and what is left is round-off
        values = np.where(np.char.startswith(found[name].mode.astype(str), "slip"), 0.0, found[name].margin)
        shade = COLORS[i % len(COLORS)]
        _curve(ax, trajectory, values, shade, name, "-" if i < len(COLORS) else "--")
        open_to = _undetermined(found[name], values)
        if open_to.any():
            least = found[name].least
            mu = _static(trajectory, name)
            rest = np.where(open_to, mu * least[:, 0] - np.linalg.norm(least[:, 1:], axis=1), np.nan)
            _curve(ax, trajectory, rest, shade, f"{name} ({LEAST})", ":")
    _finish(ax, r"$\mu_s N - |T|$", {"N"})
    ax.set_xlim(trajectory.t[0], trajectory.t[-1])  # with the times at which all are open
    _legend(ax, ax.get_legend_handles_labels()[0])
    ax.set_xlabel("time [s]")
    _title(ax, "Friction margin")
    return ax


def contact_forces(trajectory: Trajectory, contacts: Any = None, ax: Axes | None = None) -> Axes:
    """Normal forces and friction of contacts on their features over time.

    Parameters
    ----------
    trajectory : Trajectory
    contacts : str or sequence of str, optional
        Names; all if not given.
    ax : Axes, optional

    Returns
    -------
    Axes
        N in full lines, T in broken ones. Of one contact in a planar machine the limits of friction, ±μ_s N, are
        dotted.

    Raises
    ------
    SimulationError
        A machine without contacts, an unknown name.
    """
    found = _contacts(trajectory)
    names = _names(trajectory, contacts, list(found))
    ax = figure(8, 4).subplots() if ax is None else ax
    color = iter(COLORS * (1 + 3 * len(names) // len(COLORS)))
    for one in trajectory.kernels.model.contacts:
        if one.name not in names:
            continue
        motion = found[one.name]
        _curve(ax, trajectory, motion.normal, next(color), one.normal_name)
        if one.frictionless:
            continue
        parts = motion.tangential.reshape(len(trajectory.t), -1)
        for k, tangent in enumerate(one.tangent_names):
            shade = next(color)
            _curve(ax, trajectory, parts[:, k], shade, tangent, "--")
            open_to = _undetermined(motion, parts[:, k])
            if open_to.any():
                rest = np.where(open_to, motion.least[:, 1 + k], np.nan)
                named = LEAST in ax.get_legend_handles_labels()[1]
                _curve(ax, trajectory, rest, shade, None if named else LEAST, ":")
        if one.tangents == 1 and len(names) == 1:
            limit = motion.margin + np.abs(parts[:, 0])
            for sign in (1, -1):
                label = r"$\pm\mu_s N$" if sign > 0 else None
                _curve(ax, trajectory, sign * limit, "0.55", label, ":")
    on = dict.fromkeys(c.feature.body.name for c in trajectory.kernels.model.contacts if c.name in names)
    _finish(ax, f"force on {', '.join(on)}", {"N"})
    ax.set_xlim(trajectory.t[0], trajectory.t[-1])
    _legend(ax, ax.get_legend_handles_labels()[0])
    ax.set_xlabel("time [s]")
    _title(ax, "Forces of contacts" if len(names) > 1 else f"Contact {names[0]}, on {', '.join(on)}")
    return ax


def contact_gaps(trajectory: Trajectory, contacts: Any = None, ax: Axes | None = None) -> Axes:
    """Distances of the bodies at their contacts over time.

    Parameters
    ----------
    trajectory : Trajectory
    contacts : str or sequence of str, optional
        Names; all if not given.
    ax : Axes, optional

    Returns
    -------
    Axes
    """
    found = _contacts(trajectory)
    names = _names(trajectory, contacts, list(found))
    ax = figure(8, 4).subplots() if ax is None else ax
    ax.axhline(0.0, color=PALE, linewidth=1.2)
    for i, name in enumerate(names):
        style = "-" if i < len(COLORS) else "--"
        _curve(ax, trajectory, found[name].gap, COLORS[i % len(COLORS)], name, style)
    reach = ROUND_OFF * machine_size(trajectory.kernels.model, trajectory.values)
    if all(float(np.abs(found[name].gap).max(initial=0.0)) < reach for name in names):
        ax.set_ylim(-reach, reach)
    _finish(ax, "gap", {"m"})
    _legend(ax, ax.get_legend_handles_labels()[0])
    ax.set_xlabel("time [s]")
    _title(ax, "Gaps of contacts")
    return ax


def _static(trajectory: Trajectory, name: str) -> float:
    model = trajectory.kernels.model
    one = next(c for c in model.contacts if c.name == name)
    return number(model, trajectory.values, one.static_friction, "a coefficient of friction")


def _undetermined(motion: Any, values: Array) -> Any:
    """Output times at which a contact is closed and the motion does not say how large a force is."""
    return np.isnan(values) & (motion.mode != "open")


def _curve(
    ax: Any, trajectory: Trajectory, values: Array, color: str, label: str | None, style: str = "-"
) -> None:
    """One quantity over time, in the pieces in which it does not jump."""
    t = trajectory.t
    for k, chosen in enumerate(pieces(trajectory)):
        name = label if k == 0 and label else "_nolegend_"
        ax.plot(t[chosen], values[chosen], color=color, linewidth=1.6, linestyle=style, label=name)


def _contacts(trajectory: Trajectory) -> Any:
    found = getattr(trajectory, "contacts", None)
    if not found:
        raise SimulationError(
            f"Expected the motion of a machine with contacts, but '{trajectory.name}' has none. Declare one by "
            "s.contact(name, feature, surface)."
        )
    return found


def _names(trajectory: Trajectory, given: Any, known: Sequence[str]) -> list[str]:
    if given is None:
        if len(known) > MOST:
            raise SimulationError(
                f"'{trajectory.name}' has {len(known)} contacts, too many for one plot: name those to show, such as "
                f"{known[0]!r}."
            )
        return list(known)
    names = [given] if isinstance(given, str) else list(given)
    every = [contact.name for contact in trajectory.kernels.model.contacts]
    for name in names:
        if name not in every:
            raise SimulationError(f"Unknown contact '{name}'; {nearest(str(name), every)}")
    return names
