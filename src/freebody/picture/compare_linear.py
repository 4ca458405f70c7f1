"""Linear against nonlinear motion from the same start: how far the linear equations can be trusted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..equations.linear_model import LinearModel
from ..equations.linearize import linearize
from ..equations.operating_point import along
from ..errors import ModelError
from ..scalar.algebra import floats
from ..simulate.simulate import simulate
from ..simulate.trajectory import Trajectory
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
    samples: int = 501,
    tolerance: float = 10**-10,
) -> Comparison:
    """The linear and the nonlinear motion from one start, and their difference.

    Parameters
    ----------
    s : System or Model
        Without constraints, ball and free joints: its deviations are differences of coordinates.
    about : mapping or steady motion, optional
        The equilibrium or steady motion, as for :func:`freebody.linearize`.
    initial : mapping
        Initial deviations from it, of coordinates and speeds by name.
    until : float
        [s]
    values, where : mapping, optional
        As for :func:`freebody.linearize`; parameters not given have their default value.
    samples : int
        Number of times, at equal distances.
    tolerance : float
        Of the simulation.

    Returns
    -------
    Comparison

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
    linear = linearize(s, about, where=where, values=values or {})
    model = linear.model
    if model.constraints or model.quaternions:
        what = "constraints" if model.constraints else "ball or free joints"
        raise ModelError(
            f"'{model.name}' has {what}; compare_linear takes machines whose coordinates are independent angles and "
            "displacements. Compare fb.simulate with linearize(...).response(...) in the quantity of interest."
        )
    response: Any = linear.response(initial)
    t = np.linspace(0, until, samples)
    found = response(t)
    start = response(0)
    point = linear.point
    first = {name: point[name] + start[name] for name in (*linear.coordinates, *linear.rates)}
    trajectory = simulate(model, until, initial=first, values=linear.values, times=t, tolerance=tolerance)
    q0 = [point[name] for name in model.coordinate_names]
    u0 = [point[name] for name in model.speed_names]
    steady = np.array([along(model, floats, q0, u0, float(x), {}) for x in t]).reshape(len(t), -1)
    nonlinear, deviations = {}, {}
    for name in linear.coordinates:
        nonlinear[name] = trajectory[name] - steady[:, model.coordinate_names.index(name)]
        deviations[name] = found[name]
    return Comparison(linear, trajectory, t, deviations, nonlinear)


class Comparison:
    """Deviations from an equilibrium or a steady motion, by the linear and by the nonlinear equations.

    Attributes
    ----------
    linear : LinearModel
    trajectory : Trajectory
        The nonlinear motion.
    t : ndarray (n,)
    linear_motion, nonlinear_motion : dict of ndarray (n,)
        Deviations by coordinate.
    difference : dict of ndarray (n,)
        Linear less nonlinear.
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
        """Deviations of each coordinate by both equations, and their difference below.

        Parameters
        ----------
        path : path, optional
            Also write the picture to this file.

        Returns
        -------
        matplotlib Figure
        """
        names = list(self.difference)
        drawn = figure(8, 0.8 + 2.6 * len(names))
        panels = drawn.subplots(
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
            both.set_ylabel(f"deviation of {name}")
            below.plot(self.t, self.difference[name], color=COLORS[3], linewidth=1.0)
            below.set_ylabel("difference")
            for panel in (both, below):
                panel.grid(True, alpha=0.3)
        panels[0].legend(loc="upper right", frameon=False)
        panels[0].set_title(f"Linear against nonlinear motion of '{self.linear.model.name}'")
        panels[-1].set_xlabel("time [s]")
        if path is not None:
            drawn.savefig(path)
        return drawn

    def __repr__(self) -> str:
        lines = [f"Linear against nonlinear motion of '{self.linear.model.name}', 0 to {self.t[-1]:g} s"]
        for name, worst in self.worst.items():
            size = float(np.max(np.abs(self.nonlinear_motion[name])))
            lines.append(f"{name}: largest deviation {size:.3g}, largest difference {worst:.3g}")
        return "\n".join(lines)
