"""Normal force, shear force and bending moment along a uniform slender bar that moves in a plane.

A cut at s leaves the part from the first end to s, with mass μ ds. Its balances give the force R and the moment M that
the rest of the bar exerts on it (Hibbeler, *Mechanics of Materials*, chapter 6, with the inertia forces added):

    R(s) = ∫ μ (a - g) dσ - Σ F_i,      M(s) = ∫ μ (r - r_s) x (a - g) dσ - Σ (r_i - r_s) x F_i - Σ M_i

with the forces F_i and couples M_i at points up to s. N = R·t is a tension, V = -R·n a shear for which dM/ds = V.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dynamics.kinematics import point_acceleration
from ...errors import SimulationError, nearest
from ..machine.configuration import configuration, equations_at
from ..machine.force_arrows import Marks
from ..machine.solid_pieces import pieces_of
from ..moving.keyframes import Named
from ..paper.view import view_of
from .plots import COLORS, INK, _title, figure

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

COUNT = 400
"""Cuts along the bar; more are made on both sides of each point at which a force acts."""


class SectionForces(NamedTuple):
    """Distances s of the cuts from the first end [m]; N [N], V [N], M [N m] there."""

    s: Array
    normal: Array
    shear: Array
    moment: Array


class _Place(NamedTuple):
    """A point at which a bar's force can be observed: its body and its components."""

    body: Named
    components: tuple[Any, ...]


def sections(trajectory: Trajectory, body: str, at: float | None = None) -> SectionForces:
    """Return the section forces of a bar at one time.

    Parameters
    ----------
    trajectory : Trajectory
    body : str
        A body made by :func:`freebody.slender_bar`.
    at : float, optional
        The time [s]; by default the start.

    Returns
    -------
    SectionForces

    Raises
    ------
    SimulationError
        If the body is no uniform bar, or the machine moves in space.

    Examples
    --------
    A bar that is released from the horizontal: the moment is largest at a third of its length, m g L/27.

    >>> import freebody as fb
    >>> s = fb.System("falling")
    >>> s.gravity = (0, -10, 0)
    >>> bar = s.body("bar", fb.slender_bar(2.7, 3))
    >>> pin = s.hinge("pin", s.ground, bar, to=(-1.5, 0, 0), coordinate="theta")
    >>> found = sections(fb.simulate(s, 0.1), "bar")
    >>> round(float(abs(found.moment).max()), 3), round(float(found.s[abs(found.moment).argmax()]), 1)
    (3.0, 1.0)
    """
    model = trajectory.kernels.model
    if body not in model.bodies:
        raise SimulationError(f"Unknown body '{body}'; {nearest(str(body), model.bodies)}")
    e = equations_at(model, trajectory, at)
    now = configuration(e.model, at, trajectory=trajectory)
    view = view_of(e.model, e, now.values)
    place = e.model.bodies[body]
    shape = place.shape
    if shape is None or shape.kind != "slender_bar" or shape.look or shape.parts:
        raise SimulationError(
            f"Expected a uniform bar, made by fb.slender_bar, for section forces, got '{body}'."
        )
    if not view.planar:
        raise SimulationError(
            f"Expected a planar machine for section forces, but '{trajectory.name}' moves in space."
        )
    piece = pieces_of(now, True)[body][0]
    R, p = now.posture(body)
    n = view.toward
    t = R @ piece.axis
    middle, length = p + R @ piece.center, float(piece["length"])
    first = middle - length / 2 * t
    density = float(now.state(place.mass)) / length
    gravity = np.zeros(3) if view.gravity is None else view.gravity
    udot = [now.lookup[speed.acceleration] for speed in e.model.speeds]

    def effective(local: Array) -> Array:
        point: Any = _Place(Named(body), tuple(local))
        return np.array([float(x) for x in point_acceleration(e.model, now.state, point, udot)]) - gravity

    # the acceleration is linear along the bar
    ends = [effective(piece.center + sign * length / 2 * piece.axis) for sign in (-1, 1)]
    slope = (ends[1] - ends[0]) / length
    marks = Marks(e, now, True)
    acting = []
    for action in e.free_body(body).actions:
        if action.kind != "weight":
            force, moment, where = (marks.vector(x) for x in (action.force, action.moment, action.at))
            acting.append((float((where - first) @ t), where, force, moment))
    cuts = [np.linspace(0.0, length, COUNT)]
    cuts += [np.clip([s - 1e-9 * length, s + 1e-9 * length], 0, length) for s, *_ in acting]
    s = np.unique(np.concatenate(cuts))
    # ∫ μ (e_0 + e' σ) dσ, and ∫ μ (σ - s) t x (e_0 + e' σ) dσ
    force = density * (np.outer(s, ends[0]) + np.outer(s**2 / 2, slope))
    moment = density * (
        np.outer(-(s**2) / 2, np.cross(t, ends[0])) + np.outer(-(s**3) / 6, np.cross(t, slope))
    )
    for place_s, where, F, M in acting:
        left = s >= min(max(place_s, 0.0), length)
        force[left] -= F
        arms = where - (first + s[left][:, None] * t)
        moment[left] -= np.cross(arms, F) + M
    return SectionForces(s, force @ t, -(force @ np.cross(n, t)), moment @ n)


def section_forces(
    trajectory: Trajectory, body: str, ax: Any = None, *, at: float | None = None, title: str | None = None
) -> Any:
    """Draw normal force, shear force and bending moment along a bar at one time: N, V, M diagrams.

    Tension is positive, and the shear is the slope of the moment. The moment is drawn on the side of the fibres that it
    stretches for a bar whose first end is on the left: downward if it is positive.

    Parameters
    ----------
    trajectory : Trajectory
    body : str
        A body made by :func:`freebody.slender_bar`.
    ax : sequence of three Axes, optional
    at : float, optional
        The time [s]; by default the start.
    title : str, optional

    Returns
    -------
    array of Axes

    Raises
    ------
    SimulationError
        If the body is no uniform bar, the machine moves in space, or there are not three axes.

    Examples
    --------
    >>> import freebody as fb
    >>> from freebody.gallery import entries
    >>> motion = fb.simulate(entries()["ex-6-2"].build(), 0.5)
    >>> normal, shear, moment = fb.plot.section_forces(motion, "bar", at=0.2)
    >>> moment.get_ylabel()
    'M [N m]'
    """
    found = sections(trajectory, body, at)
    panels = np.ravel(
        figure(7, 5.5).subplots(3, 1, sharex=True) if ax is None else np.asarray(ax, dtype=object)
    )
    if len(panels) != 3:
        raise SimulationError(f"Expected three axes for N, V and M, got {len(panels)}.")
    for k, (panel, values, label) in enumerate(
        zip(panels, found[1:], ("N [N]", "V [N]", "M [N m]"), strict=True)
    ):
        panel.fill_between(found.s, values, color=COLORS[k], alpha=0.2, linewidth=0)
        panel.plot(found.s, values, color=COLORS[k], linewidth=1.6)
        panel.axhline(0, color=INK, linewidth=0.9)
        k_most = int(np.argmax(np.abs(values)))
        if abs(values[k_most]) > 0:
            below = -12 if (values[k_most] > 0) == (k == 2) else 5
            last = found.s[k_most] > 0.85 * found.s[-1]
            panel.annotate(
                f"{values[k_most]:.4g}".replace("-", "−"), (found.s[k_most], values[k_most]),
                xytext=(-4 if last else 4, below), textcoords="offset points",
                ha="right" if last else "left", fontsize=9, color=INK,
            )  # fmt: skip
        panel.set_ylabel(label)
        panel.margins(y=0.25)
        panel.grid(alpha=0.3)
    panels[2].invert_yaxis()
    panels[2].set_xlabel("distance from the first end [m]")
    time = float(trajectory.t[0]) if at is None else at
    _title(panels[0], f"{body.replace('_', ' ')}, t = {time:.4g} s" if title is None else title)
    return panels
