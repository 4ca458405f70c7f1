"""Plots of contacts over time: forces, gaps and friction margins. No curve runs through a jump."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError, nearest
from ..machine.shapes import machine_size
from .plots import COLORS, PALE, _curve, _over_time, figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

ROUND_OFF = 1e-9
"""Gaps below this fraction of the size of the machine are drawn as zero."""

LEAST = "least in norm"
"""Label of forces that the motion does not determine."""

MOST = 12
"""Most contacts that a plot shows if none are named."""


def friction_margin(trajectory: Trajectory, contacts: Any = None, ax: Axes | None = None) -> Axes:
    """Friction margin of each contact over time: μ_s N - |T| while it sticks, zero while it slips.

    Parameters
    ----------
    trajectory : Trajectory
        Motion of a machine with contacts.
    contacts : str or sequence of str, optional
        Names; by default all contacts with friction.
    ax : Axes, optional

    Returns
    -------
    Axes
        A curve for each contact [N], interrupted while it is open; dotted where the motion does not determine the
        forces, which are then least in norm.

    Raises
    ------
    SimulationError
        If the machine has no contacts, a name is unknown, or a named contact has no friction.

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
    motions = _contacts(trajectory)
    rough = {c.name for c in trajectory.kernels.model.contacts if not c.frictionless}
    names = _names(trajectory, contacts, [name for name in _touching(trajectory, motions) if name in rough])
    for name in names:
        if name not in rough:
            raise SimulationError(f"Contact '{name}' has no friction, and so no friction margin.")
    ax = figure(8, 4).subplots() if ax is None else ax
    ax.axhline(0.0, color=PALE, linewidth=1.2)
    for i, name in enumerate(names):
        motion = motions[name]
        # the margin of a slipping contact is zero by the law of friction; computed, it would be round-off
        values = np.where(np.char.startswith(motion.mode.astype(str), "slip"), 0.0, motion.margin)
        shade = COLORS[i % len(COLORS)]
        _curve(ax, trajectory, values, shade, name, "-" if i < len(COLORS) else "--")
        undetermined = _undetermined(motion, values)
        if undetermined.any():
            margin = np.where(undetermined, motion.least_margin, np.nan)
            _curve(ax, trajectory, margin, shade, f"{name} ({LEAST})", ":")
    units = {c.name: c.units for c in trajectory.kernels.model.contacts}
    _over_time(ax, r"$\mu_s N - |T|$", {units[name]["margin"] for name in names}, "Friction margin")
    ax.set_xlim(trajectory.t[0], trajectory.t[-1])  # including the times at which all contacts are open
    return ax


def contact_forces(trajectory: Trajectory, contacts: Any = None, ax: Axes | None = None) -> Axes:
    """Normal forces and friction forces of contacts on their features over time.

    Parameters
    ----------
    trajectory : Trajectory
    contacts : str or sequence of str, optional
        Names; by default all contacts.
    ax : Axes, optional

    Returns
    -------
    Axes
        N as full lines, T as dashed lines. For a single contact of a planar machine, the limits of friction ±μ_s N
        are dotted.

    Raises
    ------
    SimulationError
        If the machine has no contacts, or a name is unknown.
    """
    motions = _contacts(trajectory)
    names = _names(trajectory, contacts, _touching(trajectory, motions))
    ax = figure(8, 4).subplots() if ax is None else ax
    color = iter(COLORS * (1 + 3 * len(names) // len(COLORS)))
    shown = [contact for contact in trajectory.kernels.model.contacts if contact.name in names]
    for contact in shown:
        motion = motions[contact.name]
        _curve(ax, trajectory, motion.normal, next(color), contact.normal_name)
        if contact.frictionless:
            continue
        components = motion.tangential.reshape(len(trajectory.t), -1)
        for k, tangent in enumerate(contact.tangent_names):
            shade = next(color)
            _curve(ax, trajectory, components[:, k], shade, tangent, "--")
            undetermined = _undetermined(motion, components[:, k])
            if undetermined.any():
                least = np.where(undetermined, motion.least[:, 1 + k], np.nan)
                in_legend = LEAST in ax.get_legend_handles_labels()[1]
                _curve(ax, trajectory, least, shade, None if in_legend else LEAST, ":")
        if contact.tangents == 1 and len(names) == 1:
            limit = motion.margin + np.abs(components[:, 0])
            for sign in (1, -1):
                label = r"$\pm\mu_s N$" if sign > 0 else None
                _curve(ax, trajectory, sign * limit, "0.55", label, ":")
    bodies = ", ".join(dict.fromkeys(contact.feature.body.name for contact in shown))
    title = "Forces of contacts" if len(names) > 1 else f"Contact {names[0]}, on {bodies}"
    units = {contact.units["normal"] for contact in shown}
    _over_time(ax, f"{'moment' if units == {'N m'} else 'force'} on {bodies}", units, title)
    ax.set_xlim(trajectory.t[0], trajectory.t[-1])
    return ax


def contact_gaps(trajectory: Trajectory, contacts: Any = None, ax: Axes | None = None) -> Axes:
    """Gaps of contacts over time.

    Parameters
    ----------
    trajectory : Trajectory
    contacts : str or sequence of str, optional
        Names; by default all contacts.
    ax : Axes, optional

    Returns
    -------
    Axes
    """
    motions = _contacts(trajectory)
    names = _names(trajectory, contacts, _touching(trajectory, motions))
    ax = figure(8, 4).subplots() if ax is None else ax
    ax.axhline(0.0, color=PALE, linewidth=1.2)
    for i, name in enumerate(names):
        style = "-" if i < len(COLORS) else "--"
        _curve(ax, trajectory, motions[name].gap, COLORS[i % len(COLORS)], name, style)
    reach = ROUND_OFF * machine_size(trajectory.kernels.model, trajectory.values)
    if all(float(np.abs(motions[name].gap).max(initial=0.0)) < reach for name in names):
        ax.set_ylim(-reach, reach)
    _over_time(ax, "gap", {"m"}, "Gaps of contacts")
    return ax


def _undetermined(motion: Any, values: Array) -> Any:
    """Truth value for each output time: a contact is closed, but the motion does not determine its force."""
    return np.isnan(values) & (motion.mode != "open")


def _touching(trajectory: Trajectory, motions: Any) -> list[str]:
    """Return the names of all contacts, without points on which a disk could stand that never lies flat."""
    rests = {contact.name for contact in trajectory.kernels.model.contacts if contact.stands}
    return [name for name, motion in motions.items() if name not in rests or (motion.mode != "open").any()]


def _contacts(trajectory: Trajectory) -> Any:
    """Motions of the contacts by name."""
    motions = getattr(trajectory, "contacts", None)
    if not motions:
        raise SimulationError(
            f"Expected the motion of a machine with contacts, but '{trajectory.name}' has none. Declare one by "
            "s.contact(name, feature, surface)."
        )
    return motions


def _names(trajectory: Trajectory, contacts: Any, default: Sequence[str]) -> list[str]:
    """Names of the contacts to plot."""
    if contacts is None:
        if len(default) > MOST:
            raise SimulationError(
                f"'{trajectory.name}' has {len(default)} contacts, too many for one plot: name the contacts to show, "
                f"such as {default[0]!r}."
            )
        return list(default)
    names = [contacts] if isinstance(contacts, str) else list(contacts)
    known = [contact.name for contact in trajectory.kernels.model.contacts]
    for name in names:
        if name not in known:
            raise SimulationError(f"Unknown contact '{name}'; {nearest(str(name), known)}")
    return names
