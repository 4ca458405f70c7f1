"""Analysis of a machine: equations, conserved quantities, steady motions, and small motions about a steady motion.

If a question has no answer for a machine, a sentence says why, and the analysis continues with the next question.

This file is longer than others: each question needs the answers to the questions before it.
"""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from time import monotonic
from typing import TYPE_CHECKING, Any

from ..errors import FreebodyError, ModelError, TooManyTermsError, nearest

if TYPE_CHECKING:
    from ..symbolic.equations import Equations
    from ..symbolic.solving.vocabulary import Vocabulary

STABLE = ("asymptotically stable", "stable")
LONGEST = 2000
"""Most characters of symbolic equations; longer ones are shown in numbers only."""

LINE = 300
"""Most characters of a symbolic condition or frequency in the text; longer ones are in the data."""

WIDTH = 110
"""Characters after which a condition begins a line of its own, and is broken at its sums."""

ROUND = 1e-12
"""Greatest difference that counts as zero."""

CLOSED = 4
"""Most coordinates for which natural frequencies are computed in closed form."""


@dataclass
class Section:
    """One question and its answer as text, LaTeX and plain data.

    Attributes
    ----------
    title : str
    text : list of str
        Blocks of plain text.
    latex : list of str
        Displayed formulas.
    notes : list of str
        Sentences: answers that do not exist, and assumptions.
    data : dict or list
        The answer as data that JSON can hold.
    """

    title: str
    text: list[str] = field(default_factory=list)
    latex: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    data: Any = None


@dataclass
class Analysis:
    """The sections of an analysis, made by :func:`analysis`."""

    name: str
    values: dict[str, float | None]
    sections: dict[str, Section]

    def text(self) -> str:
        """Return everything as plain text."""
        head = f"Analysis of '{self.name}'"
        blocks = [f"{head}\n{'=' * len(head)}"]
        for section in self.sections.values():
            blocks.append("\n".join([section.title, "-" * len(section.title), *section.notes, *section.text]))
        return "\n\n".join(blocks) + "\n"

    def latex(self) -> str:
        """Return everything as a LaTeX document."""
        lines = [
            r"\documentclass{article}",
            r"\usepackage[landscape,margin=15mm]{geometry}",
            r"\usepackage{amsmath}",
            r"\begin{document}",
            rf"\section*{{Analysis of {plain_latex(self.name)}}}",
        ]
        for section in self.sections.values():
            lines.append(rf"\subsection*{{{plain_latex(section.title)}}}")
            lines += [plain_latex(note) + "\n" for note in section.notes]
            lines += [f"\\[\n{formula}\n\\]" for formula in section.latex]
        return "\n".join([*lines, r"\end{document}"]) + "\n"

    def data(self) -> dict[str, Any]:
        """Return everything as data that JSON can hold."""
        report: dict[str, Any] = {"model": self.name, "values": self.values}
        for key, section in self.sections.items():
            report[key] = section.data
        report["notes"] = {key: section.notes for key, section in self.sections.items() if section.notes}
        return report


def analysis(
    system: Any,
    values: Mapping[str, float] | None = None,
    about: Mapping[str, float] | None = None,
    start: Mapping[str, Any] | None = None,
    near: Mapping[str, Any] | None = None,
    patience: float | None = None,
) -> Analysis:
    """Analyse a system: equations of motion, conserved quantities, steady motions, linear model and modes.

    Parameters
    ----------
    system : System or Model
    values : mapping, optional
        Values of parameters by name, in place of their defaults.
    about : mapping, optional
        Coordinates and speeds of the operating point by name, or some unknowns of a steady motion; by default the first
        stable steady motion.
    start : mapping, optional
        Values by name, numbers or expressions, for unknowns that the steady motions leave free.
    near : mapping, optional
        For machines with constraints: an approximate closed configuration.
    patience : float, optional
        Longest time for symbolic answers [s]; beyond it, answers are numbers only.

    Returns
    -------
    Analysis

    Raises
    ------
    ModelError
        If the system cannot be assembled, a name in ``about`` is unknown, or a parameter cannot have its value.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1, L=1, g=9)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(m))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    >>> result = analysis(s).data()
    >>> result["linear_model"]["about"], result["modes"][0]["frequency"]
    ({'theta': 0.0, "theta'": 0.0}, 3.0)
    """
    return _Inquiry(
        system, dict(values or {}), dict(about or {}), dict(start or {}), dict(near or {}), patience
    ).report()


class OutOfTimeError(Exception):
    """Raised if an answer takes too long."""


@contextmanager
def within(deadline: float | None) -> Iterator[None]:
    """Stop the block at a time of the monotonic clock, if the system has timers and this is the main thread.

    Raises
    ------
    OutOfTimeError
        At the deadline.
    """
    if deadline is None:
        yield
        return
    remaining = deadline - monotonic()
    if remaining <= 0:
        raise OutOfTimeError
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: Any) -> None:
        raise OutOfTimeError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, remaining)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


class _Inquiry:
    """The questions in their order; each stores the results that the next needs."""

    def __init__(
        self,
        system: Any,
        values: dict[str, float],
        about: dict[str, float],
        start: dict[str, Any],
        near: dict[str, Any],
        patience: float | None,
    ) -> None:
        from ..motion.contact.equations_at_start import equations

        options: dict[str, Any] = {}
        if system.contacts:
            options = {"initial": start, "near": near, "values": values}
        self.e: Equations = equations(system, **options)
        self.model = self.e.model
        self.overrides = values
        self.about = about
        self.near = near
        self.deadline = None if patience is None else monotonic() + patience
        self.patience = patience
        self.missing = [p.name for p in self.model.parameters if p.default is None and p.name not in values]
        self.values = {} if self.missing else dict(self.model.values(values))
        names = [*self.model.coordinate_names, *self.model.speed_names]
        for name in about:
            if name not in names:
                raise ModelError(
                    f"--about {name}: expected a coordinate or a speed of '{self.model.name}', got '{name}'; "
                    f"{nearest(name, names)}"
                )
        self.start = {} if self.missing else {name: self._number(name, x) for name, x in start.items()}
        self.motions: Any = None
        self.states: tuple[Any, ...] = ()

    @cached_property
    def vocabulary(self) -> Vocabulary:
        """Names of symbols in text and LaTeX."""
        from ..symbolic.solving.vocabulary import Vocabulary

        return Vocabulary(self.e)

    def _number(self, name: str, value: Any) -> float:
        from ..motion.start.initial import number

        return number(self.model, self.values, value, f"the initial value of '{name}'")

    def report(self) -> Analysis:
        """Return all sections."""
        sections = {"equations": self._in_symbols("Equations of motion", self.motion)}
        if self.model.n_u:
            sections["integrals"] = self._in_symbols("Conserved quantities", self.integrals)
            sections["steady_motions"] = self._in_symbols("Steady motions", self.steady)
            sections["linear_model"], sections["modes"] = self.linear()
        shown: dict[str, float | None] = {
            p.name: self.values.get(p.name, self.overrides.get(p.name, p.default))
            for p in self.model.parameters
        }
        return Analysis(self.model.name, shown, sections)

    def _in_symbols(self, title: str, question: Callable[[], Section]) -> Section:
        """The answer, or a section with the reason why there is none."""
        try:
            with within(self.deadline):
                return question()
        except OutOfTimeError:
            self.motions, self.states = None, ()
            return Section(title, notes=[self._out_of_time("Not found")])
        except TooManyTermsError as error:
            return Section(title, notes=[str(error)])

    def _out_of_time(self, what: str) -> str:
        """End the time for symbolic answers, since the next questions need the same equations; return a note."""
        self.deadline = float(0)
        return (
            f"{what} in {self.patience:g} s: the symbolic answer is large. Allow more time with --patience."
        )

    # -- equations and integrals --------------------------------------------------------------------

    def motion(self) -> Section:
        """Return the section of the equations of motion."""
        section = Section("Equations of motion")
        if not self.model.n_u:
            section.notes.append(
                f"'{self.model.name}' has no degree of freedom: there is nothing to solve for."
            )
            section.data = []
            return section
        section.data = self.e.lines()
        section.text, section.latex = ["\n".join(section.data)], [self.e.latex()]
        section.notes += self.e.heading
        return section

    def integrals(self) -> Section:
        """Return the section of the conserved quantities."""
        section = Section("Conserved quantities", data=[])
        integrals = self.e.integrals
        if not integrals:
            section.notes.append(
                "None are known: no quantity that was tried keeps its value along every motion."
            )
            return section
        for integral in integrals:
            proof = str(integral.proof)
            section.text.append(f"{integral.text()}\n    {proof}")
            section.data.append(
                {
                    "name": integral.name,
                    "also": list(integral.also),
                    "expression": self.show(integral.expression),
                    "latex": integral.latex(),
                    "proof": proof,
                }
            )
        section.latex.append(integrals.latex())
        return section

    def show(self, expression: Any) -> str:
        """Return a SymPy expression or relation as plain text."""
        if getattr(expression, "is_Relational", False):
            return f"{self._arranged(expression.lhs)} {expression.rel_op} {self._arranged(expression.rhs)}"
        return self.vocabulary.name(expression)

    def _arranged(self, expression: Any) -> str:
        """Text of a SymPy expression, arranged as equations are if the ring has it."""
        from ..symbolic.printing.closed.answers import shown
        from ..symbolic.printing.text import Text

        try:
            element = self.vocabulary.ring.from_sympy(expression)
        except FreebodyError:
            return self.vocabulary.name(expression)
        return str(shown(Text, element, self.vocabulary.ring, closed=False))

    # -- steady motions -----------------------------------------------------------------------------

    def steady(self) -> Section:
        """Return the section of the steady motions."""
        from ..symbolic.steady.steady import steady_motions

        section = Section("Steady motions")
        section.data = {"conditions": [], "motions": [], "states": []}
        try:
            self.motions = steady_motions(self.e)
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
            "solution": {name: self.show(x) for name, x in motion.solution.items()},
            "free": list(motion.free),
            "exists_if": [self.show(x) for x in motion.existence],
            "left": [self.show(x.lhs) + " = 0" for x in motion.left],
            "singular": bool(motion.singular),
            "stable_if": None if stable is None else [self._relation(x) for x in stable],
            "stable_by_energy_if": None if energy is None else self._relation(energy),
            "latex": motion.latex(),
        }

    def _condition(self, question: Callable[[], Any], section: Section) -> Any:
        """Return a condition of stability; None if none is known, or when the time is over, which a note says."""
        if self.deadline == 0:
            return None
        try:
            return question()
        except OutOfTimeError:
            section.notes.append(self._out_of_time("Conditions of stability not found"))
            return None

    def _stable(self, relations: Sequence[Any]) -> str:
        """Text of a condition of stability."""
        parts = [self._relation(x) for x in relations]
        if "never" in parts:
            return "not stable"
        parts = [part for part in parts if part != "always"]
        text = " and ".join(parts)
        if len(text) > WIDTH:
            from ..symbolic.printing.text import broken

            return "stable if\n" + "\n".join(broken(part, "      ", WIDTH) for part in parts)
        return f"stable if {text}" if parts else "stable"

    def _relation(self, x: Any) -> str:
        """Text of a relation: always, never, or its formula."""
        if x == True or x == False:  # noqa: E712  (SymPy's own true and false)
            return "always" if x == True else "never"  # noqa: E712
        return self.show(x)

    def _near(self, section: Section) -> None:
        """Add a steady motion near zero, if the conditions are too long to be written."""
        from ..symbolic.steady.equilibrium_near import steady_near

        if self.missing:
            section.notes.append(self._no_numbers())
            return
        try:
            motions = steady_near(self.model, self.values, {})
        except FreebodyError as error:
            section.notes.append(f"In numbers: {error}")
            return
        self.states = motions.states
        section.text.append(f"at {self._at()}, next to zero; others may exist")
        self._add_states(section, lambda state: state.latex())

    def _in_numbers(self, section: Section) -> None:
        """Add the steady motions in numbers."""
        if self.missing:
            section.notes.append(self._no_numbers())
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
            section.text.append(f"at {self._at()}" if self.values else "in numbers")
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
                    "values": {name: _json(x) for name, x in state.values.items()},
                    "state": {name: _json(x) for name, x in state.state.items()},
                    "stability": stability.verdict,
                    "spectral": stability.spectral,
                    "energy": stability.energy,
                    "eigenvalues": [_json(complex(x)) for x in stability.eigenvalues],
                }
            )

    def _hint(self) -> str:
        return "" if self.about else " On the command line: --about NAME=VALUE."

    def _no_numbers(self) -> str:
        names = ", ".join(self.missing)
        return f"No numbers, since no value is given for {names}. Add --set {self.missing[0]}=VALUE."

    def _at(self) -> str:
        return ", ".join(f"{name} = {value:.6g}" for name, value in self.values.items())

    def _state_latex(self, state: Any) -> str:
        import sympy

        parts = []
        for name, value in state.values.items():
            parts.append(
                f"{self.vocabulary.latex(self._symbol(name))} = {sympy.latex(sympy.Float(value, 8))}"
            )
        label = f"{plain_latex(state.name)}: " if state.name else ""
        shown = ",\\ ".join(parts) + r"\quad" if parts else ""
        return rf"\text{{{label}}}{shown}\text{{{plain_latex(state.stability.verdict)}}}"

    def _symbol(self, name: str) -> Any:
        """SymPy symbol of a name."""
        import sympy

        return self.vocabulary.names.get(name, sympy.Symbol(name, real=True))

    def _solved(self) -> tuple[tuple[Any, ...], dict[str, float]]:
        """Steady motions in numbers, and the assumed values of unknowns that the conditions leave free."""
        motions = self.motions
        about = {name: x for name, x in self.about.items() if name in motions.unknowns}
        first: FreebodyError | None = None
        # rates of ball and free joints are not searched for: every rotation and mirror image of a root is a root
        if not self.e.model.quaternions or set(motions.rates) & set(motions.unknowns) <= set(about):
            try:
                return tuple(motions.at({**self.values, **about})), {}
            except FreebodyError as error:
                first = error
        for names in self._choices():
            assumed = {name: self.start.get(name, float(0)) for name in names if name not in about}
            try:
                states = tuple(motions.at({**self.values, **about, **assumed}))
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
        result = [list(motion.free) for motion in motions if any(name in self.start for name in motion.free)]
        return [
            *result[:1],
            rates,
            [name for name in motions.unknowns if name not in rates],
            list(motions.unknowns),
        ]

    # -- small motions ------------------------------------------------------------------------------

    def linear(self) -> tuple[Section, Section]:
        """Return the sections of the linear model and of its modes."""
        section, table = Section("Linear model"), Section("Modes", data=[])
        if self.missing:
            section.notes.append(self._no_numbers())
            table.notes.append("No modes without a linear model in numbers.")
            return section, table
        try:
            linear, about, motion = self._point(section)
        except FreebodyError as error:
            section.notes.append(str(error))
            table.notes.append("No modes without a linear model.")
            return section, table
        where = self._where(about)
        rest = self._where({})
        shown = ", ".join(f"{name} = {x:.6g}" for name, x in where.items() if abs(x - rest[name]) > ROUND)
        section.notes.append(
            f"About {shown}, all others zero." if shown else "About the state in which all is zero."
        )
        section.data = {
            "about": where,
            "coordinates": list(linear.coordinates),
            **{name: _json(getattr(linear, name)) for name in ("M", "C", "K")},
            **{
                name: _json(getattr(linear, name))
                for name in ("damping", "gyroscopic", "stiffness", "circulatory")
            },
        }
        self._symbols(section, table, motion)
        section.text.append(linear.text())
        section.latex.append(linear.latex())
        section.data["equations"] = linear.text().splitlines()
        try:
            modes = linear.modes()
        except FreebodyError as error:
            table.notes.append(str(error))
            return section, table
        table.notes.append("Frequencies in rad/s, mode shapes relative to their largest component.")
        table.text.append(modes.text())
        table.latex.append(modes.latex())
        for mode in modes:
            table.data.append(
                {
                    "kind": mode.kind,
                    "frequency": _json(mode.frequency),
                    "damping_ratio": _json(mode.damping_ratio),
                    "eigenvalue": [
                        _json(complex(mode.eigenvalue).real),
                        _json(complex(mode.eigenvalue).imag),
                    ],
                    "shape": {name: _json(x) for name, x in mode.shape.items()},
                }
            )
        return section, table

    def _where(self, about: Mapping[str, float]) -> dict[str, float]:
        """All coordinates and speeds: the values in ``about``, the others at zero and without rotation."""
        from ..dynamics.state import rest_coordinates

        values = dict(zip(self.model.coordinate_names, map(float, rest_coordinates(self.model)), strict=True))
        values |= dict.fromkeys(self.model.speed_names, float(0))
        return {name: float(about.get(name, x)) for name, x in values.items()}

    def _point(self, section: Section) -> tuple[Any, Mapping[str, float], Any]:
        """(linear model in numbers, its operating point, the steady motion in closed form or None)."""
        from ..symbolic.linear.linearize import linearize

        if self.about:
            about = self._closed_state(self.about)
            try:
                return linearize(self.e, about=about, values=self.values), about, None
            except FreebodyError as error:
                refusal = error
            if not self.states or not all(
                math.isclose(state.state.get(name, x), x, abs_tol=1 / 10**9)
                for state in self.states
                for name, x in self.about.items()
            ):
                raise refusal
            section.notes.append("The steady motion gives the values that --about does not.")
        if not self.states:
            rest = self._closed_state({})
            return linearize(self.e, about=rest, values=self.values), rest, None
        chosen = next((state for state in self.states if state.stability.verdict in STABLE), None)
        if chosen is None:
            section.notes.append(
                "None of the steady motions is known to be stable; the first is the operating point."
            )
            chosen = self.states[0]
        return linearize(self.e, about=chosen, values=self.values), chosen.state, self._motion_of(chosen)

    def _closed_state(self, about: Mapping[str, float]) -> dict[str, float]:
        """The values in ``about``, and for a machine with constraints all that follow from them."""
        if not self.model.constraints:
            return dict(about)
        from ..motion.kernels.kernels import kernels_of
        from ..motion.start.loop_closure import closed_start

        y, _ = closed_start(kernels_of(self.model), self.values, about, self.near, float(0), False)
        names = [*self.model.coordinate_names, *self.model.speed_names]
        return dict(zip(names, y.tolist(), strict=True))

    def _motion_of(self, state: Any) -> Any:
        """The steady motion in closed form that a state belongs to; None if there is none."""
        import sympy

        if self.motions is None:  # the states were found near zero
            return None
        names = self.model.names.atoms
        numbers = {names[name]: sympy.Float(value) for name, value in self.values.items()}
        numbers |= {
            self._symbol(name): sympy.Float(value) for name, value in {**state.state, **state.values}.items()
        }
        for motion in self.motions:
            if motion.left or not motion.solution:
                continue
            for name, x in motion.solution.items():
                solution = sympy.N(sympy.sympify(x).xreplace(numbers))
                if not solution.is_number:  # it depends on values that the state does not have
                    break
                value = {**state.state, **state.values}.get(name)
                if value is None or not abs(complex(solution) - value) <= (1 + abs(value)) / 10**6:
                    break
            else:
                return motion
        return None

    def _symbols(self, section: Section, table: Section, motion: Any) -> None:
        """Add the linear equations and natural frequencies in symbols, if they are not too long."""
        import sympy

        from ..symbolic.linear.linearize import linearize

        if motion is None:
            return
        try:
            linear = linearize(self.e, about=motion)
            text = linear.text()
        except FreebodyError:
            return  # they exist in numbers only
        if len(text) > LONGEST:
            return
        section.text += [text, "in numbers"]
        section.latex.append(linear.latex())
        section.data["symbolic"] = text.splitlines()
        if len(linear.coordinates) > CLOSED:
            return
        try:
            frequencies = linear.natural_frequencies()
        except FreebodyError:
            return
        texts = [sympy.sstr(x) for x in frequencies]
        section.data["natural_frequencies"] = texts
        if texts and sum(map(len, texts)) <= LINE:
            table.text.append("natural frequencies in closed form: " + ", ".join(texts))
            table.latex.append(r",\quad ".join(sympy.latex(x) for x in frequencies))


def _json(x: Any) -> Any:
    """A number, array or matrix as JSON can hold it: a complex number as [real, imaginary], infinity as None."""
    if hasattr(x, "tolist"):
        return _json(x.tolist())
    if isinstance(x, Sequence):
        return [_json(entry) for entry in x]
    if isinstance(x, complex):
        return [_json(x.real), _json(x.imag)]
    return float(x) if math.isfinite(x) else None


def plain_latex(text: str) -> str:
    """Return text with the special characters of LaTeX escaped.

    >>> plain_latex("momentum of theta_1: 50%")
    'momentum of theta\\\\_1: 50\\\\%'
    """
    special = {"\\": r"\textbackslash{}", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}"}
    return "".join(special.get(c, "\\" + c if c in "&%$#_{}" else c) for c in text)
