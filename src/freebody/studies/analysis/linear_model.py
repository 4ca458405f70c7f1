"""Small motions about a steady motion, as sections of the analysis of a machine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...errors import FreebodyError
from .inquiry import Inquiry
from .section import Section, plain_data
from .steady_motions import SteadyMotionsFound

STABLE = ("asymptotically stable", "stable")
LONGEST = 2000
"""Most characters of symbolic equations; longer ones are shown in numbers only."""

LINE = 300
"""Most characters of a symbolic condition or frequency in the text; longer ones are in the data."""

ROUND = 1e-12
"""Greatest difference that counts as zero."""

CLOSED = 4
"""Most coordinates for which natural frequencies are computed in closed form."""


@dataclass
class SmallMotions:
    """The linear model of a machine and its modes, about one of its steady motions."""

    asked: Inquiry
    steady: SteadyMotionsFound

    def sections(self) -> tuple[Section, Section]:
        """Return the sections of the linear model and of its modes."""
        section, table = Section("Linear model"), Section("Modes", data=[])
        if self.asked.missing:
            section.notes.append(self.asked.no_numbers())
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
            **{name: plain_data(getattr(linear, name)) for name in ("M", "C", "K")},
            **{
                name: plain_data(getattr(linear, name))
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
                    "frequency": plain_data(mode.frequency),
                    "damping_ratio": plain_data(mode.damping_ratio),
                    "eigenvalue": [
                        plain_data(complex(mode.eigenvalue).real),
                        plain_data(complex(mode.eigenvalue).imag),
                    ],
                    "shape": {name: plain_data(x) for name, x in mode.shape.items()},
                }
            )
        return section, table

    def _where(self, about: Mapping[str, float]) -> dict[str, float]:
        """All coordinates and speeds: the values in ``about``, the others at zero and without rotation."""
        from ...dynamics.state import rest_coordinates

        values = dict(
            zip(
                self.asked.model.coordinate_names, map(float, rest_coordinates(self.asked.model)), strict=True
            )
        )
        values |= dict.fromkeys(self.asked.model.speed_names, float(0))
        return {name: float(about.get(name, x)) for name, x in values.items()}

    def _point(self, section: Section) -> tuple[Any, Mapping[str, float], Any]:
        """(linear model in numbers, its operating point, the steady motion in closed form or None)."""
        from ...symbolic.linear.linearize import linearize

        if self.asked.about:
            about = self._closed_state(self.asked.about)
            try:
                return linearize(self.asked.e, about=about, values=self.asked.values), about, None
            except FreebodyError as error:
                refusal = error
            if not self.steady.states or not all(
                math.isclose(state.state.get(name, x), x, abs_tol=1 / 10**9)
                for state in self.steady.states
                for name, x in self.asked.about.items()
            ):
                raise refusal
            section.notes.append("The steady motion gives the values that --about does not.")
        if not self.steady.states:
            rest = self._closed_state({})
            return linearize(self.asked.e, about=rest, values=self.asked.values), rest, None
        chosen = next((state for state in self.steady.states if state.stability.verdict in STABLE), None)
        if chosen is None:
            section.notes.append(
                "None of the steady motions is known to be stable; the first is the operating point."
            )
            chosen = self.steady.states[0]
        return (
            linearize(self.asked.e, about=chosen, values=self.asked.values),
            chosen.state,
            self._motion_of(chosen),
        )

    def _closed_state(self, about: Mapping[str, float]) -> dict[str, float]:
        """The values in ``about``, and for a machine with constraints all that follow from them."""
        if not self.asked.model.constraints:
            return dict(about)
        from ...motion.kernels.kernels import kernels_of
        from ...motion.start.loop_closure import closed_start

        y, _ = closed_start(
            kernels_of(self.asked.model), self.asked.values, about, self.asked.near, float(0), False
        )
        names = self.asked.model.state_names
        return dict(zip(names, y.tolist(), strict=True))

    def _motion_of(self, state: Any) -> Any:
        """The steady motion in closed form that a state belongs to; None if there is none."""
        import sympy

        if self.steady.motions is None:  # the states were found near zero
            return None
        names = self.asked.model.names.atoms
        numbers = {names[name]: sympy.Float(value) for name, value in self.asked.values.items()}
        numbers |= {
            self.asked.symbol(name): sympy.Float(value)
            for name, value in {**state.state, **state.values}.items()
        }
        for motion in self.steady.motions:
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

        from ...symbolic.linear.linearize import linearize

        if motion is None:
            return
        try:
            linear = linearize(self.asked.e, about=motion)
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
