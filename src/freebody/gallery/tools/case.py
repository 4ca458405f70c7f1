"""A system with values for its parameters, and the tools that compute its answers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ...describe.description import about_of, names_of
from ...symbolic.printing.closed.abbreviations import abbreviated, groups
from ...symbolic.printing.display import displayed
from ...symbolic.printing.show import text_of
from .answer import Answer, Answers, Printed

TOLERANCE = 1e-10
"""Default tolerance of the simulations."""


SMOOTH = 2001
"""Number of output times of a motion that is drawn."""


@dataclass(frozen=True)
class Case:
    """A system with values for its parameters.

    ``case["m"]`` is the value of a parameter; ``names`` are names for groups of parameters, used in the closed forms.
    """

    system: fb.System
    values: dict[str, float]
    until: float
    tolerance: float
    equations: Any
    names: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def atoms(self) -> dict[str, Any]:
        """The SymPy atom of every name: parameters, coordinates, speeds and accelerations."""
        found = dict(names_of(self.system).atoms)
        for speed in self.equations.model.speeds:
            found[speed.name + "'"] = speed.acceleration
        return found

    def having(self, **values: float) -> Case:
        """Return the same system at other values of some parameters."""
        return replace(self, values={**self.values, **values})

    def touching(self, **modes: Any) -> Case:
        """Return the same system in other contact modes: ``case.touching(floor="stick")``; other contacts are open."""
        return replace(self, equations=fb.equations(self.system, modes=modes))

    def refuse_unless(self, name: str, holds: bool, expected: str) -> None:
        """Refuse a value of a parameter for which the answers do not exist."""
        if not holds:
            raise fb.errors.ModelError(f"Expected {expected}, got {name} = {self.values[name]:g}.")

    # -- answers --------------------------------------------------------------------------------------------

    def formula(
        self,
        question: str,
        expression: Any,
        unit: str,
        how: str,
        at: Mapping[str, Any] | None = None,
        where: Mapping[str, Any] | None = None,
    ) -> Answer:
        """Return an answer in closed form: a canonical expression, and its value at the parameters.

        Parameters
        ----------
        question, unit, how
            As in :class:`Answer`.
        expression : SymPy expression
            Derived from the model, in its parameters, coordinates, speeds and accelerations.
        at : mapping, optional
            Values of the coordinates and speeds in the expression, by name, if it holds at any state; used for the
            value only.
        where : mapping, optional
            Abbreviations in the expression: a coordinate or a real symbol by name -> longer expression. Earlier
            abbreviations may contain later ones.
        """
        ring = self.equations.ring
        canonical = ring.from_sympy(sympy.sympify(expression))
        written_out = sympy.sympify(expression)
        for name, meant in (where or {}).items():
            written_out = written_out.xreplace({self.atoms.get(name, sympy.Symbol(name, real=True)): meant})
        meant_by = {name: ring.from_sympy(meant) for name, meant in (where or {}).items()}
        canonical, meant_by = self._named(canonical, meant_by)
        return Answer(
            question, self.number(written_out, at), unit, displayed(canonical, ring), how,
            Printed.closed(canonical, ring),
            {name: displayed(meant, ring) for name, meant in meant_by.items()},
            {name: Printed.closed(meant, ring) for name, meant in meant_by.items()},
        )  # fmt: skip

    def _named(self, x: Any, meant_by: Mapping[str, Any]) -> tuple[Any, dict[str, Any]]:
        """Return a closed form and its abbreviations with the groups of parameters named, and their meanings added.

        What is a group itself keeps its parameters: it tells what the name means.
        """
        if x in self._groups.values():
            return x, dict(meant_by)
        sides = [(one, 0) for one in (x, *meant_by.values())]
        shown, used = abbreviated(sides, self._groups, self.equations.ring, closed=True)
        (x, _), *rest = shown
        return x, {**{name: one for name, (one, _) in zip(meant_by, rest, strict=True)}, **used}

    @cached_property
    def _groups(self) -> dict[str, Any]:
        return groups(self.equations, self.names)

    def equation(self, index: int, question: str) -> Answer:
        """Return an equation of motion as an answer whose value is its text; each side is in its closed form."""
        e = self.equations
        left, right = e.balances[index]
        printed = Printed.equation(left, right, e.ring)
        return Answer(question, printed.text, "", e.motion[index], "fb.equations(s).motion", printed)

    def general(self, question: str, expression: Any, how: str) -> Answer:
        """Return an answer that holds for any motion: its value is the text of its closed form."""
        ring = self.equations.ring
        canonical = ring.from_sympy(sympy.sympify(expression))
        printed = Printed.closed(canonical, ring)
        return Answer(question, printed.text, "", displayed(canonical, ring), how, printed)

    def square_of_speed(
        self, speed: str, start: Mapping[str, Any], end: Mapping[str, Any], integral: str = "energy"
    ) -> Any:
        """Return the square of a speed at a state, from an integral of the motion and its value at another state.

        Parameters
        ----------
        speed : str
            Name of the speed, such as ``"theta'"``; the integral must be quadratic in it.
        start, end : mapping
            Coordinates and speeds by name, numbers or expressions; ``speed`` is the unknown of ``end``.
        integral : str, optional
            Name of one of ``fb.equations(s).integrals``.

        Returns
        -------
        SymPy expression in the parameters (and in coordinates and speeds that ``start`` and ``end`` leave open)
        """
        kept = self.equations.integrals[integral].expression
        u = sympy.Dummy("u")
        balance = self.put(kept, {**end, speed: u}) - self.put(kept, start)
        slope, rest = (sympy.Poly(sympy.expand(balance), u).coeff_monomial(u**k) for k in (2, 0))
        return -rest / slope

    # -- numbers --------------------------------------------------------------------------------------------

    def __getitem__(self, name: str) -> float:
        return self.values[name]

    def put(self, expression: Any, state: Mapping[str, Any] | None = None) -> Any:
        """Return an expression or matrix at a state with names such as ``"theta"``, ``"theta'"``, ``"theta''"``.

        All are replaced at once; the parameters stay symbols.
        """
        # nothing is substituted inside a derivative that the state does not name
        kept = {atom: atom for atom in self.atoms.values()}
        return expression.xreplace(kept | {self.atoms[k]: self._value(v) for k, v in (state or {}).items()})

    def _value(self, value: Any) -> Any:
        return self.system.expression(value) if isinstance(value, str) else sympy.sympify(value)

    def number(self, expression: Any, state: Mapping[str, Any] | None = None) -> float:
        """Return the value of an expression at a state and at the values of the parameters.

        Raises
        ------
        ModelError
            The value is not finite, for example because the expression divides by a length of zero.
        """
        value = sympy.N(self.put(self.put(sympy.sympify(expression), state), self._exact_values), 17)
        if not (value.is_real and value.is_finite):
            wrong = [name for name, x in self.values.items() if x == 0]
            hint = f" Look at what is zero: {', '.join(wrong)}." if wrong else ""
            raise fb.errors.ModelError(
                f"Expected values of '{self.system.name}' at which '{text_of(expression)}' is a finite number, got "
                f"{'none: it divides by zero' if value.has(sympy.zoo, sympy.nan, sympy.oo) else value}.{hint}"
            )
        return float(value)

    @cached_property
    def _exact_values(self) -> dict[str, Any]:
        """Return the values, with doubles nearest to a multiple of 90 degrees made exact, so that their cosine is 0."""
        found: dict[str, Any] = dict(self.values)
        for name, x in self.values.items():
            turns = round(2 * x / math.pi)
            if turns and x == turns * (math.pi / 2) and about_of(self.system).get(name, ("",))[0] == "rad":
                found[name] = turns * sympy.pi / 2
        return found

    def numbers(self, matrix: Any, state: Mapping[str, Any] | None = None) -> np.ndarray:
        """Return the values of a SymPy matrix as an array of the same shape."""
        return np.array([self.number(entry, state) for entry in matrix]).reshape(matrix.shape)

    def accelerations(self, state: Mapping[str, Any]) -> dict[str, float]:
        """Return u' by name at coordinates and speeds, from the equations of motion: M u' = -bias + Gᵀ λ, G u' = -γ."""
        e = self.equations
        M, bias = self.numbers(e.mass_matrix, state), self.numbers(e.bias, state)
        if e.model.constraints:
            G, gamma = self.numbers(e.constraint_matrix, state), self.numbers(e.constraint_bias, state)
            M = np.block([[M, -G.T], [G, np.zeros((len(G), len(G)))]])
            bias = np.vstack([bias, gamma])
        # redundant conditions leave multipliers indeterminate, but not the accelerations
        found = np.linalg.lstsq(M, -bias[:, 0])[0] if e.model.constraints else np.linalg.solve(M, -bias[:, 0])
        names = [speed.name + "'" for speed in e.model.speeds]
        return dict(zip(names, found.tolist(), strict=False))

    def simulate(self, until: Any = None, **options: Any) -> Any:
        """Simulate at this case's values and tolerance; options as for :func:`freebody.simulate`."""
        end = self.until if until is None else until
        options = {"values": self.values, "tolerance": self.tolerance, **options}
        # with contacts the simulation finds the modes: it uses the system itself, not its copy in the equations' modes
        machine = self.system if self.system.contacts else self.equations.model
        return fb.simulate(machine, end, **options)

    def motion(self, **options: Any) -> Any:
        """Simulate the run with enough output times for its picture: no fewer than `SMOOTH`."""
        trajectory = self.simulate(**options)
        return trajectory if len(trajectory.t) >= SMOOTH else self.simulate(samples=SMOOTH, **options)

    def simulate_to(self, times: Iterable[float], **options: Any) -> Any:
        """Simulate with output at ``times`` only, in the order given.

        The tolerance is a hundredth of the run's, as far as doubles permit: the error at the end is a multiple of
        the error of a single step.
        """
        wanted = [self._time(t) for t in times]
        finer = min(self.tolerance, max(self.tolerance / 100, 1e-13))
        options = {"tolerance": finer, **options}
        return self.simulate(max([*wanted, 1e-9]), times=wanted, **options)

    @staticmethod
    def _time(t: float) -> float:
        if not t >= 0:
            raise fb.errors.ModelError(f"Expected times of 0 s or later to answer for, got {t:g} s.")
        return t

    def simulate_past(self, name: str, count: int, required: bool = True, **options: Any) -> Any:
        """Simulate until ``count`` events of a name have happened after the start; terminal events end the motion.

        Raises
        ------
        SimulationError
            The events are required and do not happen within a hundred times the length of the run.
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

    def simulate_to_mode(self, contact: str, mode: str, **options: Any) -> tuple[Any, Any]:
        """Return a motion in which a contact enters a mode ("slip": either sense), and the event that begins the mode.

        Raises
        ------
        SimulationError
            The contact does not enter the mode within a hundred times the length of the run.
        """
        until = self.until
        while True:
            trajectory = self.simulate(until, **options)
            for event in happened(trajectory, contact):
                if f"→ {mode}" in str(event):
                    return trajectory, event
            if until > 100 * self.until:
                raise fb.errors.SimulationError(
                    f"Expected contact '{contact}' of '{self.system.name}' to come to '{mode}', but in {until:g} s "
                    "it does not. Choose values with which it does."
                )
            until *= 2


def happened(trajectory: fb.Trajectory, name: str) -> list[Any]:
    """Return the events of a name after the start."""
    return [event for event in trajectory.events if event.name == name and event.time > 0]


def explain(system: fb.System, **about: str) -> None:
    """Describe parameters and coordinates by name: ``m="kg: mass of the disk"``."""
    for name, words in about.items():
        unit, _, what = words.partition(": ")
        system.describe(name, unit=unit, about=what)


def angle_where(expression: Any, angle: Any) -> Any:
    """Return the angle from -90 to 90 degrees at which an expression A sin + B cos is zero: atan(-B/A).

    Raises
    ------
    ModelError
        The expression is not of this form.
    """
    numerator = sympy.expand(sympy.numer(sympy.together(sympy.expand(expression))))
    A, B = (numerator.coeff(f(angle), 1) for f in (sympy.sin, sympy.cos))
    left = sympy.expand(numerator - A * sympy.sin(angle) - B * sympy.cos(angle))
    if left != 0 or A.has(angle) or B.has(angle):
        raise fb.errors.ModelError(f"Expected A sin({angle}) + B cos({angle}) = 0 to solve, got {numerator}.")
    return sympy.atan(sympy.cancel(-B / A))


def mass_properties(body: Any) -> fb.MassProperties:
    """Return the mass properties of a body other than the ground."""
    assert body.mass_properties is not None
    return body.mass_properties


def states(trajectory: fb.Trajectory, i: int, names: Mapping[str, str], label: str) -> Answers:
    """Return answers ``theta(t_1)``, ``theta'(t_1)`` and so on at output time ``i``, whose name is ``label``.

    ``names`` maps names to units.
    """
    return {
        f"{name}({label})": Answer(f"{name} at {label}", float(trajectory[name][i]), unit, how="fb.simulate")
        for name, unit in names.items()
    }
