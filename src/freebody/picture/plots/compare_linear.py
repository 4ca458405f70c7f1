"""Linear and nonlinear motion from the same initial values: the difference shows how far linear equations hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...motion.trajectory.trajectory import Trajectory
from ...scalar.algebra import floats
from ...studies.simulate import simulate
from ...symbolic.linear.checks import SMALL
from ...symbolic.linear.deviation import deviations, start_of
from ...symbolic.linear.linear_model import LinearModel
from ...symbolic.linear.linearize import linearize
from ...symbolic.linear.operating_point import along, tangent_names
from ...symbolic.printing.lines import Lines, Name
from .labels import SETTING, symbol
from .plots import COLORS, figure

Array = NDArray[np.float64]


def compare_linear(
    s: Any,
    about: Any = None,
    *,
    initial: Mapping[Any, Any],
    until: float,
    values: Mapping[Any, Any] | None = None,
    where: Mapping[Any, Any] | None = None,
    independent: Any = (),
    samples: int = 501,
    tolerance: float = 10**-10,
) -> Comparison:
    """Compare the linear and the nonlinear motion from the same initial values.

    Parameters
    ----------
    s : System or Model
    about : mapping or steady motion, optional
        The equilibrium or steady motion, as for :func:`freebody.linearize`.
    initial : mapping
        Initial deviations from it, by the names of coordinates and rates in the linear equations. With constraints,
        all other initial values follow from them.
    until : float
        Length of the motion [s].
    values, where : mapping, optional
        As for :func:`freebody.linearize`; by default parameters have their default values.
    independent : names of coordinates, optional
        As for :func:`freebody.linearize`.
    samples : int
        Number of evenly spaced times.
    tolerance : float
        Tolerance of the simulation.

    Returns
    -------
    Comparison
        For the coordinates of the linear equations. Turns and displacements of ball and free joints are measured
        from the steady motion, in the axes of its child.

    Raises
    ------
    ModelError
        As :func:`freebody.linearize`; or if the speeds of a ball or free joint change along the steady motion.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1.0, L=1.0, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(m))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    >>> fb.compare_linear(s, initial={"theta": 0.01}, until=2)
    Linear against nonlinear motion of 'pendulum', 0 to 2 s
    theta: largest deviation 0.01, largest difference 2.97e-07
    """
    linear = linearize(s, about, where=where, values=values or {}, independent=independent)
    model = linear.model
    _check_reference(linear)
    response: Any = linear.response(initial)
    t = np.linspace(0, until, samples)
    motion = response(t)
    first = response(0)
    deviation = [first[name] for name in (*linear.coordinates, *linear.carried)]
    q, u = start_of(linear, deviation, [first[name] for name in linear.rates])
    start = dict(zip(model.state_names, (*q, *u), strict=True))
    trajectory = simulate(model, until, initial=start, values=linear.values, times=t, tolerance=tolerance)
    q0 = [linear.point[name] for name in model.coordinate_names]
    u0 = [linear.point[name] for name in model.speed_names]
    steady = np.array([along(model, floats, q0, u0, float(x), {}) for x in t]).reshape(len(t), -1)
    coordinates = np.stack([trajectory[name] for name in model.coordinate_names], axis=-1)
    nonlinear = deviations(model, steady, coordinates)
    columns = tangent_names(model)
    names = (*linear.coordinates, *linear.carried)
    return Comparison(
        linear,
        trajectory,
        t,
        {name: motion[name] for name in names},
        {name: nonlinear[:, columns.index(name)] for name in names},
    )


def _check_reference(linear: LinearModel) -> None:
    """Raise if the speeds of a ball or free joint change along the steady motion: it then has no closed form."""
    model = linear.model
    udot = linear.canonical.get("udot")
    fast = max((abs(linear.point[name]) for name in model.speed_names), default=0)
    for link in model.links:
        if udot is None or not link.own:
            continue
        changing = np.abs(udot[link.u : link.u + link.n_speeds])
        if changing.max() > SMALL * (1 + fast**2):
            raise ModelError(
                f"The speeds of joint '{link.joint}' of '{model.name}' change along the motion to compare with. "
                "Use sliders and a gimbal instead, whose angles turn at constant rates."
            )


class Comparison(Lines):
    """Deviations from an equilibrium or a steady motion by the linear and the nonlinear equations.

    Attributes
    ----------
    linear : LinearModel
    trajectory : Trajectory
        The nonlinear motion.
    t : ndarray (n,)
        Times [s].
    linear_motion, nonlinear_motion : dict of ndarray (n,)
        Deviations by coordinate.
    difference : dict of ndarray (n,)
        Linear minus nonlinear.
    """

    def __init__(
        self,
        linear: LinearModel,
        trajectory: Trajectory,
        t: Array,
        linear_motion: dict[str, Array],
        nonlinear_motion: dict[str, Array],
    ) -> None:
        self.linear = linear
        self.trajectory = trajectory
        self.t = t
        self.linear_motion = linear_motion
        self.nonlinear_motion = nonlinear_motion
        self.difference = {name: linear_motion[name] - nonlinear_motion[name] for name in linear_motion}

    @property
    def worst(self) -> dict[str, float]:
        """Largest difference of each coordinate."""
        return {name: float(np.max(np.abs(x))) for name, x in self.difference.items()}

    def plot(self, path: Any = None) -> Any:
        """Plot the deviations of each coordinate by both equations, and their difference below.

        Parameters
        ----------
        path : path, optional
            Also write the picture to this file.

        Returns
        -------
        matplotlib Figure
        """
        names = list(self.difference)
        plot = figure(8, 0.8 + 2.6 * len(names))
        panels = plot.subplots(
            2 * len(names), 1, sharex=True, squeeze=False, height_ratios=[2, 1] * len(names)
        )[:, 0]
        for k, name in enumerate(names):
            both, below = panels[2 * k], panels[2 * k + 1]
            both.plot(self.t, self.nonlinear_motion[name], color=COLORS[0], linewidth=1.6, label="nonlinear")
            both.plot(
                self.t,
                self.linear_motion[name],
                color=COLORS[1],
                linewidth=1.2,
                linestyle="--",
                label="linear",
            )
            both.set_ylabel(f"deviation of {symbol(name)}", **SETTING)
            below.plot(self.t, self.difference[name], color=COLORS[3], linewidth=1.0)
            below.set_ylabel("difference")
            for panel in (both, below):
                panel.grid(True, alpha=0.3)
        panels[0].legend(loc="upper right", frameon=False)
        panels[0].set_title(f"Linear against nonlinear motion of '{self.linear.model.name}'")
        panels[-1].set_xlabel("time [s]")
        if path is not None:
            plot.savefig(path)
        return plot

    def _lines(self) -> list[list[Any]]:
        lines: list[list[Any]] = [
            [f"Linear against nonlinear motion of '{self.linear.model.name}', 0 to {self.t[-1]:g} s"]
        ]
        for name, worst in self.worst.items():
            size = float(np.max(np.abs(self.nonlinear_motion[name])))
            sizes = f": largest deviation {size:.3g}, largest difference {worst:.3g}"
            lines.append([Name(name), sizes])
        return lines

    def __repr__(self) -> str:
        return self.text()
