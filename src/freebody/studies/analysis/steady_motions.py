"""The steady motions of a machine, as a section of its analysis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ...errors import FreebodyError, TooManyTermsError
from .deadline import OutOfTimeError
from .inquiry import Inquiry
from .section import Section, plain_data, plain_latex

WIDTH = 110
"""Characters after which a condition begins a line of its own, and is broken at its sums."""


@dataclass
class SteadyMotionsFound:
    """The steady motions of a machine that were found: all in closed form, and in numbers."""

    asked: Inquiry
    motions: Any = None
    states: tuple[Any, ...] = ()

    def section(self) -> Section:
        """Return the section of the steady motions.

        Raises
        ------
        OutOfTimeError
            At the deadline; nothing is found then.
        """
        try:
            return self._section()
        except OutOfTimeError:
            self.motions, self.states = None, ()
            raise

    def _section(self) -> Section:
        from ...symbolic.steady.steady import steady_motions

        section = Section("Steady motions")
        section.data = {"conditions": [], "motions": [], "states": []}
        try:
            self.motions = steady_motions(self.asked.e)
        except TooManyTermsError as error:
            section.notes.append(error.reason)
            self._near(section)
            return section
        except FreebodyError as error:
            section.notes.append(str(error))
            return section
        closed = []
        for motion in self.motions:
            line, data = self._closed(motion, section)
            closed.append(line)
            section.data["motions"].append(data)
        lines = self.motions.text().splitlines()
        conditions = lines[: len(self.motions.conditions)]
        if self.motions.reason:
            section.notes.append(f"No closed form: {self.motions.reason}")
        section.data["conditions"] = conditions
        section.text += [*conditions, *closed]
        section.latex.append(self.motions.latex())
        self._in_numbers(section)
        return section

    def _closed(self, motion: Any, section: Section) -> tuple[str, dict[str, Any]]:
        """Text and data of a steady motion in closed form."""
        stable = self._condition(lambda: motion.stable_if, section)
        energy = self._condition(lambda: motion.stable_by_energy_if, section)
        lines = [motion.text()]
        ways = {"in the linear approximation": stable, "by energy": None if energy is None else [energy]}
        said = {way: self._stable(relations) for way, relations in ways.items() if relations is not None}
        for text in dict.fromkeys(said.values()):  # one condition is written once
            lines.append(f"    {' and '.join(way for way in said if said[way] == text)}: {text}")
        return "\n".join(lines), {
            "name": motion.name,
            "solution": {name: self.asked.show(x) for name, x in motion.solution.items()},
            "free": list(motion.free),
            "exists_if": [self.asked.show(x) for x in motion.existence],
            "left": [self.asked.show(x.lhs) + " = 0" for x in motion.left],
            "singular": bool(motion.singular),
            "stable_if": None if stable is None else [self._relation(x) for x in stable],
            "stable_by_energy_if": None if energy is None else self._relation(energy),
            "latex": motion.latex(),
        }

    def _condition(self, question: Callable[[], Any], section: Section) -> Any:
        """Return a condition of stability; None if none is known, or when the time is over, which a note says."""
        if self.asked.deadline == 0:
            return None
        try:
            return question()
        except OutOfTimeError:
            section.notes.append(self.asked.out_of_time("Conditions of stability not found"))
            return None

    def _stable(self, relations: Sequence[Any]) -> str:
        """Text of a condition of stability."""
        parts = [self._relation(x) for x in relations]
        if "never" in parts:
            return "not stable"
        parts = [part for part in parts if part != "always"]
        text = " and ".join(parts)
        if len(text) > WIDTH:
            from ...symbolic.printing.text import broken

            return "stable if\n" + "\n".join(broken(part, "      ", WIDTH) for part in parts)
        return f"stable if {text}" if parts else "stable"

    def _relation(self, x: Any) -> str:
        """Text of a relation: always, never, or its formula."""
        if x == True or x == False:  # noqa: E712  (SymPy's own true and false)
            return "always" if x == True else "never"  # noqa: E712
        return self.asked.show(x)

    def _near(self, section: Section) -> None:
        """Add a steady motion near zero, if the conditions are too long to be written."""
        from ...symbolic.steady.equilibrium_near import steady_near

        if self.asked.missing:
            section.notes.append(self.asked.no_numbers())
            return
        try:
            motions = steady_near(self.asked.model, self.asked.values, {})
        except FreebodyError as error:
            section.notes.append(f"In numbers: {error}")
            return
        self.states = motions.states
        section.text.append(f"at {self.asked.at()}, next to zero; others may exist")
        self._add_states(section, lambda state: state.latex())

    def _in_numbers(self, section: Section) -> None:
        """Add the steady motions in numbers."""
        if self.asked.missing:
            section.notes.append(self.asked.no_numbers())
            return
        assumed: dict[str, float] = {}
        try:
            self.states, assumed = self._solved()
        except FreebodyError as error:
            section.notes.append(f"In numbers: {error}" + self._hint())
            return
        if assumed:
            shown = ", ".join(f"{name} = {value:.6g}" for name, value in assumed.items())
            section.notes.append(
                f"In numbers with {shown}, which the conditions leave free (choose with --about)."
            )
        if not self.states:
            section.notes.append("At these values no steady motion exists.")
        if self.states:
            section.text.append(f"at {self.asked.at()}" if self.asked.values else "in numbers")
        self._add_states(section, self._state_latex)

    def _add_states(self, section: Section, latex: Callable[[Any], str]) -> None:
        """Add the states of the steady motions with their stability."""
        for state in self.states:
            section.text.append(f"  {state!r}")
            section.latex.append(latex(state))
            stability = state.stability
            section.data["states"].append(
                {
                    "name": state.name,
                    "values": {name: plain_data(x) for name, x in state.values.items()},
                    "state": {name: plain_data(x) for name, x in state.state.items()},
                    "stability": stability.verdict,
                    "spectral": stability.spectral,
                    "energy": stability.energy,
                    "eigenvalues": [plain_data(complex(x)) for x in stability.eigenvalues],
                }
            )

    def _hint(self) -> str:
        return "" if self.asked.about else " On the command line: --about NAME=VALUE."

    def _state_latex(self, state: Any) -> str:
        import sympy

        parts = []
        for name, value in state.values.items():
            parts.append(
                f"{self.asked.vocabulary.latex(self.asked.symbol(name))} = {sympy.latex(sympy.Float(value, 8))}"
            )
        label = f"{plain_latex(state.name)}: " if state.name else ""
        shown = ",\\ ".join(parts) + r"\quad" if parts else ""
        return rf"\text{{{label}}}{shown}\text{{{plain_latex(state.stability.verdict)}}}"

    def _solved(self) -> tuple[tuple[Any, ...], dict[str, float]]:
        """Steady motions in numbers, and the assumed values of unknowns that the conditions leave free."""
        motions = self.motions
        about = {name: x for name, x in self.asked.about.items() if name in motions.unknowns}
        first: FreebodyError | None = None
        # rates of ball and free joints are not searched for: every rotation and mirror image of a root is a root
        if not self.asked.e.model.quaternions or set(motions.rates) & set(motions.unknowns) <= set(about):
            try:
                return tuple(motions.at({**self.asked.values, **about})), {}
            except FreebodyError as error:
                first = error
        for names in self._choices():
            assumed = {name: self.asked.start.get(name, float(0)) for name in names if name not in about}
            try:
                states = tuple(motions.at({**self.asked.values, **about, **assumed}))
            except FreebodyError as error:
                first = first or error
                continue
            if states:
                return states, assumed
        if first is not None:
            raise first
        return (), {}

    def _choices(self) -> list[list[str]]:
        """Sets of unknowns to assume, in turn: free ones with a value in ``start``, all rates, all others, all."""
        motions = self.motions
        rates = [name for name in motions.rates if name in motions.unknowns]
        result = [
            list(motion.free) for motion in motions if any(name in self.asked.start for name in motion.free)
        ]
        return [
            *result[:1],
            rates,
            [name for name in motions.unknowns if name not in rates],
            list(motions.unknowns),
        ]
