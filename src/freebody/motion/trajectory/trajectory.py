"""The motion of a machine, as users see it: its quantities by name, as a dataset, in a file, in pictures."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from ...errors import ExpressionError, SimulationError
from ...rooms_above import module_for
from ..ending import End
from .computed_motion import ComputedMotion
from .dataset import ENERGIES, dataset
from .extremes import extremes, values
from .outputs import OfContact, outputs_of, quantity_of, reduction
from .quantities import LEDGER

if TYPE_CHECKING:
    from pathlib import Path as FilePath

    import xarray

    from ...describe.system import System


class Trajectory(ComputedMotion):
    """The motion of a machine. Made by :func:`freebody.simulate`.

    ``trajectory["theta"]``, ``["theta'"]``, or any expression of the machine's names, gives an array over the output
    times ``t``. Energies, poses and reactions are computed on first use.

    Attributes
    ----------
    values : dict
        Values of all parameters.
    tolerances : ndarray
        Relative tolerance of each coordinate and speed.
    path : SampledPath
        The states, which can be sampled at any time: smooth, in phases or in steps.
    course : Course
        How the quantities follow from the path.
    initial, near : dict
        Initial values and guesses as they were given, by name: numbers, or expressions of the parameters. Empty for
        motions that contacts, blows, signals or controllers interrupt.
    """

    def __getitem__(self, name: Any) -> Any:
        """A coordinate, speed, acceleration, expression (SymPy or text) or reaction at the output times.

        ``["max(theta)"]``, and likewise min, initial, final and range, is one number for the whole run, as in a batch.
        ``["pin"]`` is the magnitude of the force of joint pin, ``["pin.force"]`` its components in ground axes, shape
        (n, 3), ``["pin.force.y"]`` one of them, and ``["pin.moment"]`` likewise. ``["N_floor"]`` is the normal force of
        contact floor, as ``["floor.normal"]`` is; its other quantities are gap, tangential, slip, margin and mode.
        """
        if not isinstance(name, str | sympy.Basic | int | float):
            raise SimulationError(f"Expected a coordinate, a speed or an expression of them, got {name!r}.")
        text = name if isinstance(name, str) else self.kernels.model.names.texts.get(name)
        if text in self.names:
            return self.states[:, self.names.index(text)]
        if isinstance(name, str) and name in ("t", "time"):
            return self.t
        if isinstance(name, str) and name in ENERGIES:
            return getattr(self.energy, LEDGER[name])
        if isinstance(name, str) and name.endswith("'") and name[:-1] in self.kernels.model.speed_names:
            return self._rates()[:, self.kernels.model.n_q + self.kernels.model.speed_names.index(name[:-1])]
        if isinstance(name, str) and (number := self._number(name)) is not None:
            return number
        if parts := quantity_of(self.kernels.model, name):
            first = next(iter(parts.values()))
            if isinstance(first, OfContact) and first.what == "mode":
                return self.contacts[first.contact].mode
            columns = values(self, tuple(parts.values()))
            return columns[:, 0] if len(parts) == 1 else columns
        try:
            expression = self.kernels.model.names.expression(name, "trajectory[...]")
        except ExpressionError as error:
            raise SimulationError(
                f"Expected a coordinate, a speed or an expression of them. {error}"
            ) from None
        program = self.kernels.expressions((expression,))
        return self._observed(program, "values", self.t, self.states)[:, 0]

    def _number(self, name: str) -> float | None:
        """Return the number for the whole run that a text such as "max(theta)" names, else None."""
        if not reduction(name)[0]:
            return None
        outputs = outputs_of(self.kernels.model, [name])
        return float(outputs.number(name, extremes(self, outputs)[None])[0])

    @cached_property
    def data(self) -> xarray.Dataset:
        """All quantities at the output times, with units, as one dataset with the dimension ``time``."""
        return dataset(self)

    def save(self, path: str | FilePath) -> None:
        """Write the motion to a netCDF file, whole or not at all: :attr:`data`, which any program can read, the
        description of the machine, and the computed path. :meth:`load` reads the motion back.
        """
        module_for("save").save(self, path)

    @staticmethod
    def load(path: str | FilePath, machine: System | None = None) -> Trajectory:
        """Return the motion that :meth:`save` wrote, with all its quantities.

        Nothing in a file is executed. The file holds the machine. Signals and the inputs of controllers are stored as
        parameters with other values in each part of the run: a loaded motion has neither the signals' names nor the
        controllers' functions. Its events have their names, but no expressions to watch for again.

        Parameters
        ----------
        path : path
        machine : System, optional
            Needed if the machine could not be written to the file (the error says so); useful to have this system's
            own symbols.

        Raises
        ------
        SimulationError
            The file holds no motion, is damaged, or holds no machine.

        Examples
        --------
        >>> import tempfile
        >>> import freebody as fb
        >>> s = fb.System("cart")
        >>> rail = s.slider("rail", s.ground, s.body("cart", fb.particle(2)), axis="x", coordinate="x")
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     fb.simulate(s, until=3, initial={"x'": 2}).save(f"{folder}/cart.nc")
        ...     motion = fb.Trajectory.load(f"{folder}/cart.nc")
        >>> motion
        Trajectory of 'cart': t = 0 to 3 s, 1 coordinate, 0 events, finished
        >>> round(motion.at(1.5)["x"], 12)
        3.0
        """
        trajectory: Trajectory = module_for("load").load(path, machine)
        return trajectory

    def plot(self, names: Any = None, *, ax: Any = None, path: str | FilePath | None = None) -> Any:
        """Plot coordinates (or other quantities) over time, one panel for each unit, with the events marked.

        Parameters
        ----------
        names : name, expression or sequence of them, optional
            As in ``trajectory[...]``; all coordinates if not given.
        ax : matplotlib Axes, optional
            Axes for all of them.
        path : path, optional
            Also write the picture to this file.

        Returns
        -------
        matplotlib Axes, or array of Axes when there are several panels
        """
        axes = module_for("plots").history(self, names, ax)
        if path is not None:
            np.ravel(np.asarray(axes, dtype=object))[0].figure.savefig(path, dpi=150)
        return axes

    def plot_margin(self, names: Any = None, ax: Any = None) -> Any:
        """Plot the friction-cone margin μ_s N - |T| of contacts over time.

        Parameters
        ----------
        names : name or sequence of names, optional
            All contacts if not given.
        ax : matplotlib Axes, optional

        Returns
        -------
        matplotlib Axes
        """
        if not self.contacts:
            raise SimulationError(
                f"Expected the motion of a machine with contacts for plot_margin, but '{self.name}' has none."
            )
        if ax is None:
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.figure import Figure

            figure = Figure(figsize=(7, 3), layout="constrained")
            FigureCanvasAgg(figure)
            ax = figure.subplots()
        if names is not None and not (
            isinstance(names, str | list | tuple) and all(isinstance(n, str) for n in names)
        ):
            raise SimulationError(f"Expected the name of a contact, or a list of them, got {names!r}.")
        for name in [names] if isinstance(names, str) else names or list(self.contacts):
            ax.plot(self.t, self.contacts[name].margin, label=name)
        ax.axhline(0.0, color="0.6", linewidth=0.8)
        ax.set_xlabel("time [s]")
        ax.set_ylabel("μ_s N - |T| [N]")
        ax.legend()
        ax.grid(alpha=0.3)
        return ax

    def animate(self, path: str | FilePath | None = None, **options: Any) -> Any:
        """Return the motion as an animation: a player in a notebook, or a file.

        Parameters
        ----------
        path : path, optional
            Also write it to this file: ``.html`` is a page that opens offline; ``.gif`` and ``.mp4`` are made with a
            browser.
        **options
            ``tolerance`` between keyframes, ``height`` in a notebook, and what is shown from the beginning:
            ``trails``, ``frames``, ``names``, ``forces``, ``reactions``, ``cones``, ``follow``, ``repeat``.

        Returns
        -------
        Animation
        """
        animation = module_for("animate").animate(self, **options)
        if path is not None:
            animation.save(path)
        return animation

    def _repr_html_(self) -> str:
        return str(module_for("animate").animate(self)._repr_html_())

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        n, events, crossings = len(self.kernels.model.coordinates), len(self.events), self.path.crossings
        ended = str(self.path.status)
        if self.path.status == End.TERMINAL and crossings:
            ended = f"stopped by '{self.specs[crossings[-1].number].name}'"
        warnings = "".join(
            f"; not physical from t = {warning.time:.6g} s on: {warning.what} ('{warning.name}')"
            for warning in self.warnings
        )
        return (
            f"Trajectory of '{self.name}': t = {self.path.start:g} to {self.path.end:g} s, "
            f"{n} coordinate{'s' * (n != 1)}, {events} event{'s' * (events != 1)}, {ended}{warnings}"
        )
