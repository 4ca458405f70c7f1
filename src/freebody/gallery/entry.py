"""What an entry of the gallery is, and the tools its answers are worked out with."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import sympy

import freebody as fb

Answers = dict[str, tuple[Any, str]]
Plots = dict[str, Callable[[Path], Any]]

TOLERANCE = 1e-10
"""Of the simulations, where none is asked for."""


SMOOTH = 2001
"""Output times of a motion that is drawn."""


@dataclass(frozen=True)
class Outcome:
    """What running an entry gives.

    Attributes
    ----------
    system : System
    equations : Equations
    trajectory : Trajectory
    answers : dict
        Name -> (value, unit).
    plots : dict
        File name -> function that draws it to a path.
    """

    system: fb.System
    equations: Any
    trajectory: fb.Trajectory
    answers: Answers
    plots: Plots


@dataclass(frozen=True)
class Entry:
    """A system that can be run by name.

    Attributes
    ----------
    name : str
    aliases : tuple of str
        Other names it is found by, such as the place in the book.
    title : str
    asks : tuple of str
        The questions it answers.
    build : function
        Makes the system, with default values.
    solve : function of a :class:`Case`
        Gives (trajectory, answers, plots).
    until : float
        Length of the run where none is asked for [s].
    start : mapping
        Values by name, numbers or expressions of parameters, from which the motion of the run begins.
    near : mapping
        Of a machine with constraints: coordinates near which it is closed.
    """

    name: str
    aliases: tuple[str, ...]
    title: str
    asks: tuple[str, ...]
    build: Callable[[], fb.System]
    solve: Callable[[Case], tuple[fb.Trajectory, Answers, Plots]]
    until: float
    start: Mapping[str, Any] = field(default_factory=dict)
    near: Mapping[str, Any] = field(default_factory=dict)

    def run(
        self, values: Mapping[str, Any] | None = None, until: Any = None, tolerance: float | None = None
    ) -> Outcome:
        """Derive the equations, simulate, and answer what is asked.

        Parameters
        ----------
        values : mapping, optional
            Of parameters, by name, in place of their defaults.
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
        case = Case(
            system,
            model.values(values),
            self.until if until is None else float(until),
            TOLERANCE if tolerance is None else tolerance,
            fb.equations(model),
        )
        trajectory, answers, plots = self.solve(case)
        return Outcome(system, case.equations, trajectory, answers, plots)


@dataclass(frozen=True)
class Case:
    """A system with numbers for its parameters.

    ``case["m"]`` is the value of a parameter.
    """

    system: fb.System
    values: dict[str, float]
    until: float
    tolerance: float
    equations: Any
    atoms: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.atoms.update(self.system.names.atoms)
        for speed in self.equations.model.speeds:
            self.atoms[speed.name + "'"] = speed.acceleration

    def __getitem__(self, name: str) -> float:
        return self.values[name]

    def put(self, expression: Any, state: Mapping[str, Any] | None = None) -> Any:
        """An expression (or matrix) at a state, given by names such as ``"theta"``, ``"theta'"``, ``"theta''"``.

        All are replaced at once; the parameters stay symbols.
        """
        return expression.xreplace({self.atoms[k]: sympy.sympify(v) for k, v in (state or {}).items()})

    def number(self, expression: Any, state: Mapping[str, Any] | None = None) -> float:
        """The value of an expression at a state and at the values of the parameters."""
        return float(sympy.N(self.put(self.put(sympy.sympify(expression), state), self.values), 17))

    def numbers(self, matrix: Any, state: Mapping[str, Any] | None = None) -> np.ndarray:
        """The values of a SymPy matrix, shape of the matrix."""
        return np.array([self.number(entry, state) for entry in matrix]).reshape(matrix.shape)

    def accelerations(self, state: Mapping[str, Any]) -> dict[str, float]:
        """u' by name at coordinates and speeds, from the equations of motion: M u' = -bias + Gᵀ λ, G u' = -γ."""
        e = self.equations
        M, bias = self.numbers(e.mass_matrix, state), self.numbers(e.bias, state)
        if e.model.constraints:
            G, gamma = self.numbers(e.constraint_matrix, state), self.numbers(e.constraint_bias, state)
            M = np.block([[M, -G.T], [G, np.zeros((len(G), len(G)))]])
            bias = np.vstack([bias, gamma])
        # redundant conditions leave multipliers open, but no acceleration
        found = np.linalg.lstsq(M, -bias[:, 0])[0] if e.model.constraints else np.linalg.solve(M, -bias[:, 0])
        names = [speed.name + "'" for speed in e.model.speeds]
        return dict(zip(names, found.tolist(), strict=False))

    def simulate(self, until: Any = None, **options: Any) -> fb.Trajectory:
        """The motion at this case's values and tolerance; options as of :func:`freebody.simulate`."""
        end = self.until if until is None else until
        options = {"values": self.values, "tolerance": self.tolerance, **options}
        return fb.simulate(self.equations.model, end, **options)

    def motion(self, **options: Any) -> fb.Trajectory:
        """The motion over the run at as many times as its picture needs: no fewer than `SMOOTH`."""
        trajectory = self.simulate(**options)
        return trajectory if len(trajectory.t) >= SMOOTH else self.simulate(samples=SMOOTH, **options)

    def simulate_to(self, times: Iterable[float], **options: Any) -> fb.Trajectory:
        """The motion at ``times`` only, in the order given."""
        wanted = [self._time(t) for t in times]
        return self.simulate(max([*wanted, 1e-9]), times=wanted, **options)

    @staticmethod
    def _time(t: float) -> float:
        if not t >= 0:
            raise fb.errors.ModelError(f"Expected times of 0 s or later to answer for, got {t:g} s.")
        return t

    def simulate_past(self, name: str, count: int, required: bool = True, **options: Any) -> fb.Trajectory:
        """A motion long enough for ``count`` events of a name after the start; it ends there if they are terminal.

        Raises
        ------
        SimulationError
            They are required and do not happen in a hundred times the length of the run.
        """
        until = self.until
        while True:
            trajectory = self.simulate(until, **options)
            if len(happened(trajectory, name)) >= count:
                return trajectory
            if until > 100 * self.until:
                break
            until *= 2
        if required:
            raise fb.errors.SimulationError(
                f"Expected '{name}' of '{self.system.name}' to happen {count} times, but in {until:g} s it does "
                "not. Choose values with which it moves."
            )
        return trajectory


def happened(trajectory: fb.Trajectory, name: str) -> list[Any]:
    """The events of a name after the start."""
    return [event for event in trajectory.events if event.name == name and event.time > 0]


def explain(system: fb.System, **about: str) -> None:
    """Say of parameters and coordinates by name what they are: ``m="kg: mass of the disk"``."""
    for name, text in about.items():
        unit, _, what = text.partition(": ")
        system.describe(name, unit=unit, about=what)


def mass_properties(body: Any) -> fb.MassProperties:
    """Of a body that is not the ground."""
    assert body.mass_properties is not None
    return body.mass_properties


def states(trajectory: fb.Trajectory, i: int, names: Mapping[str, str], label: str) -> Answers:
    """Answers "theta at t_1" and so on at output time ``i``; ``names`` are name -> unit."""
    return {f"{name} at {label}": (float(trajectory[name][i]), unit) for name, unit in names.items()}


def small_frequencies(case: Case, at: Mapping[str, Any]) -> np.ndarray:
    """Circular frequencies of small oscillation about an equilibrium, lowest first [rad/s].

    det(K - w² M) = 0 with K_ij = d bias_i / dq_j there.
    """
    e = case.equations
    M = case.numbers(e.mass_matrix, at)
    K = np.array([[case.number(h.diff(q), at) for q in e.coordinates] for h in e.bias])
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    return np.array([math.sqrt(s) if s > 0 else math.nan for s in squares])
