"""The entry of the gallery, and the outcome of running it.

A module of the gallery describes one system through the public API (`build`), and answers questions about it with
the library (`solve`). `solve` returns a :class:`Solved`: a motion, the answers by short keys in the order of the
questions, pictures, and checks.
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
    """The result of running an entry.

    Attributes
    ----------
    entry : Entry
    system : System
    values : dict
        Values of the parameters by name.
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
        """The events of the stored motion."""
        return list(self.trajectory.events)

    @property
    def free_bodies(self) -> dict[str, Any]:
        """The free-body equations of the bodies that the entry shows, by name.

        Components are in ground axes; if attitudes are quaternions, in ground or body axes, whichever are shorter.
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
        if self.entry.fixed_values:
            found = {name: body.at(self.entry.fixed_values) for name, body in found.items()}
        return found


@dataclass(frozen=True)
class Entry:
    """A system that can be run by name.

    Attributes
    ----------
    name : str
        Short name: ``sec-6-9`` for a system of the chapter.
    aliases : tuple of str
        Other names of the entry; the first is its common name.
    title : str
        One line that describes the system.
    asks : tuple of str
        The questions that it answers.
    build : function
        Returns the system with default values.
    solve : function of a :class:`Case`
        Returns a :class:`Solved`.
    until : float
        Default length of the run [s].
    start : mapping
        Initial values of the run by name: numbers or expressions in the parameters.
    near : mapping
        For machines with constraints: an approximate closed configuration.
    positive : tuple of str
        Parameters that must be above 0 for the questions to have answers.
    bodies : tuple of str, optional
        The bodies whose free-body equations are shown with the answers; by default all.
    drawn : mapping
        Coordinates in which it is drawn; generic ones are chosen for the others.
    enlarged : mapping
        Values of parameters that its drawing shows in place of theirs, which are too small to be seen.
    blows : function of the system, optional
        Returns the impulses that its drawing shows: (point, components) by name.
    modes : mapping, optional
        For machines with contacts: the contact modes of its equations, see :func:`freebody.equations`.
    names : mapping
        Names for groups of parameters, with which equations of motion and closed forms are printed.
    fixed_values : mapping
        Values of coordinates, speeds and accelerations that these modes hold fixed; the free bodies are shown with
        them.
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
    drawn: Mapping[str, Any] = field(default_factory=dict)
    enlarged: Mapping[str, float] = field(default_factory=dict)
    blows: Callable[[fb.System], Mapping[str, Any]] | None = None
    positive: tuple[str, ...] = ()
    bodies: tuple[str, ...] | None = None
    modes: Mapping[str, Any] | None = None
    names: Mapping[str, Any] = field(default_factory=dict)
    fixed_values: Mapping[str, Any] = field(default_factory=dict)

    def drawing(self, values: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """How :func:`freebody.draw` draws it, with other ``values`` of parameters if given."""
        return {
            "near": self.near,
            "at": dict(self.drawn) or None,
            "values": {**(values or {}), **self.enlarged} or None,
        }

    def run(
        self, values: Mapping[str, Any] | None = None, until: Any = None, tolerance: float | None = None
    ) -> Outcome:
        """Derive the equations, simulate, and answer the questions.

        Parameters
        ----------
        values : mapping, optional
            Values of parameters by name in place of their defaults; numbers or text such as ``"75deg"``.
        until : float, optional
            Length of the run [s]. Answers that need a longer run use one.
        tolerance : float, optional
            Tolerance of the simulations.

        Raises
        ------
        ModelError, SimulationError
            An unknown parameter, an impossible value, or a run that fails.
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
            self.names,
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
