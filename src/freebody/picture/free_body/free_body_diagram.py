"""Free-body diagrams, drawn from the symbols of the free-body equations.

The left side shows the isolated body with everything that acts on it, the right side the same body with m a_C and
dH_C/dt (I_C α in a plane); the equations of motion say that both sides are equal. Every arrow has its expression, its
point and its direction as attributes, so that a drawing can be read back and summed up.

This file is longer than others because one class lays out the panels, captions and tables of a sheet.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...describe.body import Body
from ...describe.system import System
from ...errors import ModelError, TooManyTermsError, nearest
from ...model.model import Model
from ...motion.trajectory.trajectory import Trajectory
from ...symbolic.equations import Equations
from ..machine.configuration import configuration, equations_at, modes_drawn
from ..machine.force_arrows import Mark, Marks
from ..paper.drawing import Drawing
from ..paper.view import ASIDE, view_of
from .composition import LARGER, Composition

MODES = ("symbolic", "scale", "blank")


CURE = (
    "A diagram has no room for them. Take the forces as numbers, motion.contacts and motion.reactions of a motion, or "
    "see them on its bodies: fb.report(s, motion, 'page.html')."
)
"""Cure for expressions that are too long for a diagram."""


def free_body_diagram(
    system: System | Model | Equations,
    body: str | Body = "all",
    *,
    at: Any = None,
    trajectory: Trajectory | None = None,
    mode: str | None = None,
    values: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    modes: Mapping[str, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    angles: bool = True,
    dimensions: bool = False,
    kinetic: bool | None = None,
) -> Drawing:
    """Draw the free-body diagram and the kinetic diagram of a body.

        Σ F = m a_C,        Σ M_C = dH_C/dt        (I_C α of a planar machine)

    A planar machine is drawn in its plane, which need not be declared; any other in an axonometric view.

    Parameters
    ----------
    system : System, Model or Equations
    body : str or Body
        Or "all": all bodies side by side, with the opposite arrows of each joint in one colour.
    at : mapping or number, optional
        Coordinates at which the body is drawn, ``{"theta": "30deg"}``, or the time of ``trajectory`` [s]. Coordinates
        that you do not name get generic values, at which nothing is in line.
    trajectory : Trajectory, optional
        A motion of the system.
    mode : "symbolic", "scale" or "blank"
        Arrows of one length; arrows to scale with a table of values, at a time of a trajectory (the default with a
        trajectory); or outlines and points alone, for exercises.
    values : mapping, optional
        Values of parameters, in place of their defaults.
    near : mapping, optional
        For machines with loops: an approximate closed configuration.
    modes : mapping, optional
        Contact modes, as for :func:`freebody.equations`: ``{"floor": "stick"}``. By default the modes at the time of
        the trajectory; without a trajectory the modes in which the motion starts from ``initial``; without
        ``initial`` those at zero coordinates or, if nothing touches there or ``at`` is given, those in which the
        motion starts from rest as drawn.
    initial : mapping, optional
        Initial values of a motion with contacts, as for :func:`freebody.simulate`.
    angles, dimensions : bool
        Show the angle of the body and the distances of its points (planar machines).
    kinetic : bool, optional
        Show the kinetic diagram beside; by default True, but False for "all".

    Returns
    -------
    Drawing
        ``.svg``, ``.tikz``, ``.save("x.pdf")``; notebooks show it.

    Raises
    ------
    ModelError
        If a body or mode is unknown, or the machine cannot have these coordinates.

    Notes
    -----
    An arrow shows the sense in which its symbol is positive. An arrow to scale shows the sense of the force, with a
    minus sign at a symbol whose value is negative. Source: chapter 6, eqs (6.1), (6.25); layout as is usual in
    Meriam & Kraige, Engineering Mechanics: Dynamics.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, L/2, 0), axis="z", coordinate="theta")
    >>> fb.free_body_diagram(s, "bar").svg.count('class="force"')
    5
    """
    chosen = ""
    if trajectory is None and modes is None and not isinstance(system, Equations):
        modes, chosen = modes_drawn(system, at, initial, values, near)
    elif initial is not None:
        raise ModelError(
            "Expected no initial= with modes=, a motion or equations, which give the contact modes. Leave it out."
        )
    e = equations_at(system, trajectory, at, modes)
    e.chosen = e.chosen or chosen
    model = e.model
    mode = _mode(mode, trajectory)
    name = body.name if isinstance(body, Body) else body
    if not isinstance(name, str) or (name != "all" and name not in model.bodies):
        raise ModelError(
            f"Expected a body of '{model.name}' (or 'all') for a free-body diagram, got {name!r}; "
            f"{nearest(str(name), [*model.bodies, 'all'])}"
        )
    now = configuration(model, at, trajectory=trajectory, values=values, near=near)
    if mode != "scale":
        now = replace(now, moving=False)  # only the position of the trajectory is used
    view = view_of(model, e, now.values)
    marks = Marks(e, now, view.planar)
    names = list(model.bodies) if name == "all" else [name]
    kinetic = name != "all" if kinetic is None else kinetic
    marks_of = {body_name: _marks_of(e, marks, body_name, kinetic, mode) for body_name in names}
    maker = Composition(e, now, view, marks_of, mode, angles, dimensions, kinetic)
    if name != "all" and maker.is_crowded(name):
        aside = Composition(
            e, now, view_of(model, e, now.values, azimuth=ASIDE), marks_of, mode, angles, dimensions, kinetic
        )
        maker = max(maker, aside, key=lambda one: one.apart(name))
        maker.size *= LARGER
    return Drawing(maker.exploded() if name == "all" else maker.single(name))


def _mode(mode: str | None, trajectory: Trajectory | None) -> str:
    """The mode of a diagram; the default if None is given."""
    if mode is None:
        return "symbolic" if trajectory is None else "scale"
    if mode not in MODES:
        raise ModelError(f"Expected 'symbolic', 'scale' or 'blank' for mode, got {mode!r}.")
    if mode == "scale" and trajectory is None:
        raise ModelError(
            "Arrows to scale need values: pass trajectory= (of fb.simulate) and the time as at=. Without them "
            "mode='symbolic' draws all arrows of one length."
        )
    return mode


def _marks_of(
    e: Equations, marks: Marks, name: str, kinetic: bool, mode: str
) -> tuple[list[Mark], list[Mark]]:
    """Arrows of the free-body diagram and of the kinetic diagram of a body."""
    if mode == "blank":
        return [], []
    try:
        free = e.free_body(name)
        return marks.of(free), marks.kinetic(free) if kinetic else []
    except TooManyTermsError as error:
        raise TooManyTermsError(error.reason, CURE) from None
