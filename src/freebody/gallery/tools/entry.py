"""What an entry of the gallery is.

A module of the gallery describes one system through the public API (`build`), and lets the library work out
what is asked of it (`solve`). `solve` returns a :class:`Solved`: a motion, the answers by short keys in the
order in which they are asked, pictures, and checks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import freebody as fb

from ...model.values import check_assumptions
from .answer import Answers, Check, Plots, Solved
from .case import TOLERANCE, Case


@dataclass(frozen=True)
class Outcome:
    """What running an entry gives.

    Attributes
    ----------
    entry : Entry
    system : System
    values : dict
        Of the parameters, by name.
    equations : Equations
    trajectory : Trajectory
    answers : dict
        Short key -> :class:`Answer`.
    plots : dict
        File name -> function that draws it to a path.
    checks : tuple of Check
    """

    entry: Entry
    system: fb.System
    values: dict[str, float]
    equations: Any
    trajectory: fb.Trajectory
    answers: Answers
    plots: Plots
    checks: tuple[Check, ...] = ()

    @property
    def events(self) -> list[Any]:
        """The events of the motion that is kept."""
        return list(self.trajectory.events)

    @property
    def free_bodies(self) -> dict[str, Any]:
        """The free-body equations of the bodies that the entry shows, by name.

        Components are those in ground axes; where attitudes are quaternions in ground or body axes, whichever are the
        shorter to read.
        """
        shown = self.system.bodies if self.entry.bodies is None else self.entry.bodies
        model = self.equations.model
        by_quaternions = len(model.coordinate_names) > len(model.speed_names)

        def one(name: str) -> Any:
            axes = (None, name) if by_quaternions else (None,)
            return min(
                (self.equations.free_body(name, frame=frame) for frame in axes), key=lambda b: len(b.text())
            )

        found = {name: one(name) for name in shown if name != "ground"}
        if self.entry.held:
            found = {name: body.at(self.entry.held) for name, body in found.items()}
        return found


@dataclass(frozen=True)
class Entry:
    """A system that can be run by name.

    Attributes
    ----------
    name : str
        Short: ``sec-6-9`` for what stands in the chapter.
    aliases : tuple of str
        Other names it is found by; the first is what people call it.
    title : str
        A line that says what the system is.
    asks : tuple of str
        The questions it answers.
    build : function
        Makes the system, with default values.
    solve : function of a :class:`Case`
        Gives a :class:`Solved`.
    until : float
        Length of the run where none is asked for [s].
    start : mapping
        Values by name, numbers or expressions of parameters, from which the motion of the run begins.
    near : mapping
        Of a machine with constraints: coordinates near which it is closed.
    positive : tuple of str
        Parameters above 0, without which the questions have no answers.
    bodies : tuple of str, optional
        The bodies whose free-body equations are shown with the answers; all if not given.
    modes : mapping, optional
        Of a machine with contacts: the modes that its equations are for, see :func:`freebody.equations`.
    held : mapping
        Values of coordinates, speeds and accelerations that these modes keep: the free bodies are shown with them.
    """

    name: str
    aliases: tuple[str, ...]
    title: str
    asks: tuple[str, ...]
    build: Callable[[], fb.System]
    solve: Callable[[Case], Solved]
    until: float
    start: Mapping[str, Any] = field(default_factory=dict)
    near: Mapping[str, Any] = field(default_factory=dict)
    positive: tuple[str, ...] = ()
    bodies: tuple[str, ...] | None = None
    modes: Mapping[str, Any] | None = None
    held: Mapping[str, Any] = field(default_factory=dict)

    def run(
        self, values: Mapping[str, Any] | None = None, until: Any = None, tolerance: float | None = None
    ) -> Outcome:
        """Derive the equations, simulate, and answer what is asked.

        Parameters
        ----------
        values : mapping, optional
            Of parameters, by name, in place of their defaults; numbers or text such as ``"75deg"``.
        until : float, optional
            Length of the run [s]. Answers that need a longer one get it.
        tolerance : float, optional
            Of the simulations.

        Raises
        ------
        ModelError, SimulationError
            An unknown parameter, a value that the system can not have, a run that fails.
        """
        system = self.build()
        model = fb.assemble(system)
        numbers = model.values(values)
        check_assumptions(model, numbers)
        decides = model.contacts and self.modes is None
        start: dict[str, Any] = (
            {"initial": self.start, "near": self.near, "values": numbers} if decides else {}
        )
        case = Case(
            system,
            numbers,
            self.until if until is None else float(until),
            TOLERANCE if tolerance is None else tolerance,
            fb.equations(model, modes=self.modes, **start),
        )
        for name in self.positive:
            case.refuse_unless(name, case[name] > 0, f"{name} greater than 0")
        found = self.solve(case)
        return Outcome(
            self,
            system,
            case.values,
            found.equations or case.equations,
            found.trajectory,
            found.answers,
            found.plots,
            found.checks,
        )
