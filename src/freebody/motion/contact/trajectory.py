"""Trajectory of a machine with contacts: contact modes, contact forces and gaps."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import SimulationError, nearest
from ..kernels.kernels import Program
from ..ode.dense_output import Array, observe
from ..trajectory.phased_trajectory import PhasedTrajectory
from ..trajectory.quantities import ByName, Energy, Reaction
from .run import Change

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class ContactMotion:
    """One contact at the output times.

    Attributes
    ----------
    gap : ndarray (n,)
        Distance of the surfaces [m].
    normal : ndarray (n,)
        Normal force N [N]; nan if the motion does not determine it.
    tangential : ndarray (n,) or (n, 2)
        Friction on the feature along the tangents [N]; nan if the motion does not determine it.
    slip : ndarray (n,) or (n, 2)
        Slip velocity along the tangents [m/s].
    margin : ndarray (n,)
        Friction-cone margin μ_s N - |T| [N]; nan while open.
    mode : ndarray of str (n,)
        open, stick, slip+, slip- or slip.
    least : ndarray (n, 1 + tangents)
        (N, T...) [N]; of forces that the motion does not determine, those least in norm.
    """

    gap: Array
    normal: Array
    tangential: Array
    slip: Array
    margin: Array
    mode: Any
    least: Array


class Timeline(list[Change]):
    """Modes of all contacts in the order in which they began, printed one per line."""

    def of(self, contact: str) -> list[Change]:
        """Return the modes of one contact."""
        known = {change.contact for change in self}
        if not isinstance(contact, str) or contact not in known:
            raise SimulationError(f"Unknown contact '{contact}'; {nearest(str(contact), known)}")
        return [change for change in self if change.contact == contact]

    def __str__(self) -> str:
        return "\n".join(map(str, self))


def timeline(text: Any) -> Timeline:
    """Return the modes of all contacts in a lane of a batch, with their times and the reasons why they began.

    Parameters
    ----------
    text : str or DataArray of one
        Entry of the variable ``modes`` of a batch, such as ``data["modes"][3]``.

    Returns
    -------
    Timeline
        The same as ``trajectory.modes`` of a single run; empty for a lane without a motion.

    Raises
    ------
    SimulationError
        If ``text`` is not the timeline of one lane.

    Examples
    --------
    >>> print(timeline('[["floor", "stick", 0.0, 2.0, "the start"]]'))
    floor: stick from 0 to 2 s (the start)
    """
    try:
        given = text.item() if hasattr(text, "item") else text
        return Timeline(Change(*entry) for entry in (json.loads(given) if given else []))
    except (TypeError, ValueError):
        raise SimulationError(
            f'Expected the modes of one lane, such as data["modes"][3], got {text!r}.'
        ) from None


class ContactTrajectory(PhasedTrajectory):
    """A trajectory with contacts.

    Attributes
    ----------
    modes : Timeline
        Modes of every contact, with their times and the reasons why they began.
    """

    def __init__(
        self,
        *arguments: Any,
        changes: Sequence[Sequence[Any]] = (),
        unknown: Mapping[str, float],
        **options: Any,
    ) -> None:
        super().__init__(*arguments, **options)
        self.modes = Timeline(Change(*change) for change in changes)
        self._unknown = dict(unknown)

    has_work = True

    @property
    def indeterminate(self) -> tuple[str, ...]:
        """Reactions and contact forces that the motion does not determine at some time of the run."""
        return (*super().indeterminate, *self._unknown)

    def _rates(self) -> Array:
        """Rates of the state at the output times, each in the contact modes of its time."""
        (found,) = self._by_segment(lambda phase: phase.motion(), ("rates",))
        return found

    def _by_segment(self, made: Callable[[Any], Program], functions: Sequence[str]) -> list[Array]:
        """Return outputs of functions at the output times, each from the program of its segment."""
        parts: list[tuple[Any, list[Array]]] = []
        programs: dict[int, Any] = {}
        for k, chosen in self.path.split(self.t):
            segment = self.path.segments[k]
            if id(segment.kernels) not in programs:
                program = made(segment.kernels)
                programs[id(segment.kernels)] = (program, program.constants(self._parameters))
            program, constants = programs[id(segment.kernels)]
            times, states = self.t[chosen], self.states[chosen]
            if type(segment.path).__name__ == "Leap":  # the start of a leap has no direction of slip yet
                states, times = (
                    np.broadcast_to(segment.path.states[-1], states.shape),
                    times * 0 + segment.path.end,
                )
            parts.append(
                (
                    chosen,
                    [
                        observe(program.address(f), program.outputs(f), times, states, constants)
                        for f in functions
                    ],
                )
            )
        result = []
        for j in range(len(functions)):
            width = min((values[j].shape[1] for _, values in parts), default=0)
            whole = np.empty((len(self.t), width))  # reactions of closed contacts follow those of joints
            for chosen, values in parts:
                whole[chosen] = values[j][:, :width]
            result.append(whole)
        return result

    @cached_property
    def contacts(self) -> dict[str, ContactMotion]:
        """Gap, forces, slip and mode of every contact, by name."""
        gaps, rates, forces = self._by_segment(lambda phase: phase.contact(), ("gap", "rate", "force"))
        first = self.path.segments[0].kernels.scene
        places = self.path.places(self.t)
        segments = self.path.segments
        result = {}
        for k, contact in enumerate(self.kernels.model.contacts):
            at, n = first.first[k], first.tangents[k]
            lambdas = forces[:, at : at + 1 + n]
            modes = np.array([segments[p].modes[k] for p in places])
            loose = np.array([segments[p].loose[at : at + 1 + n] for p in places]).reshape(-1, 1 + n)
            shown = np.where(loose, np.nan, lambdas)
            mu = self._value(contact.static_friction)
            T, slip = shown[:, 1:], rates[:, at + 1 : at + 1 + n]
            margin = np.where(modes == "open", np.nan, mu * shown[:, 0] - np.linalg.norm(T, axis=1))
            result[contact.name] = ContactMotion(
                gaps[:, k],
                shown[:, 0],
                T[:, 0] if n == 1 else T,
                slip[:, 0] if n == 1 else slip,
                margin,
                modes,
                lambdas,
            )
        return ByName("contact", result)

    def _value(self, expression: Any) -> float:
        from ..start.initial import number

        return number(self.kernels.model, self.values, expression, "a coefficient of friction")

    @cached_property
    def energy(self) -> Energy:
        """Energy ledger.

        ``work`` includes the work of friction (``-friction`` is its heat) and of impacts (``impulses``).
        """
        ledger = super().energy
        n = self.kernels.model.n_q + self.kernels.model.n_u
        return Energy(
            ledger.kinetic,
            ledger.potential,
            ledger.work,
            ledger.residual,
            ledger.impulses,
            -self.states[:, n + 1],
        )

    @cached_property
    def reactions(self) -> dict[str, Reaction]:
        """Force and moment that every joint transmits to its child; see :attr:`Trajectory.reactions`."""
        (found,) = self._by_segment(lambda phase: phase.reactions(), ("reactions",))
        return ByName(
            "joint",
            {
                name: Reaction(found[:, 6 * i : 6 * i + 3], found[:, 6 * i + 3 : 6 * i + 6], on, about)
                for i, (name, on, about) in enumerate(self.kernels.transmitting)
            },
        )

    def plot_margin(self, names: Any = None, ax: Any = None) -> Axes:
        """Friction-cone margin μ_s N - |T| of contacts over time.

        Parameters
        ----------
        names : name or sequence of names, optional
            All contacts if not given.
        ax : matplotlib Axes, optional

        Returns
        -------
        matplotlib Axes
        """
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
