"""A machine whose values the user changes in the page: each change gives a new motion, as the data of the page."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from html import escape
from threading import Lock
from typing import Any

from ...describe.description import about_of
from ...dynamics.state import float_state, rest_coordinates
from ...errors import FormatError, FreebodyError, ModelError, SimulationError
from ...formats.case import Case
from ...model.assemble import assemble
from ...model.symbols import symbols_of
from ...studies.simulate import simulate
from ...symbolic.equations import Equations, equations
from .animation import animation
from .longest_phases import longest_contact
from .report import LARGEST, charts, formulas

LENGTH = 10.0
"""Length of the run if the model gives none [s]."""

STEPS = 200_000
"""Most steps of a run."""


class Live:
    """A machine with values, initial values and a length of its run, all of which may change.

    Parameters
    ----------
    case : Case
        The system, its initial values and the length of its run.
    text : str
        Text of the model file, which the page shows and changes.

    Raises
    ------
    ModelError
        As :func:`freebody.assemble`.
    """

    def __init__(self, case: Case, text: str = "") -> None:
        self._lock = Lock()  # one request at a time
        self._take(case, text)

    def _take(self, case: Case, text: str) -> None:
        model = assemble(case.system)
        values = model.values({})
        state = float_state(model, values=values)
        until = LENGTH if case.until is None else float(state(case.system.expression(case.until)))
        self.case, self.model, self.text = case, model, text
        self.values, self.until = values, until

    def machine(self) -> dict[str, Any]:
        """Return everything that the page shows of the machine: sliders, equations, text and first motion."""
        with self._lock:
            return self._machine()

    def _machine(self) -> dict[str, Any]:
        motion = self._motion(self.values, {}, self.until)
        return {
            "name": self.model.name,
            "text": self.text,
            "until": self.until,
            "sliders": self._sliders(),
            "equations": self._equations(),
            **motion,
        }

    def motion(self, values: Mapping[str, Any], initial: Mapping[str, Any], until: Any) -> dict[str, Any]:
        """Return the motion with other values and initial values.

        Parameters
        ----------
        values : mapping
            Numbers for parameters, by name.
        initial : mapping
            Numbers for coordinates and speeds, by name.
        until : float
            Length of the run [s].

        Returns
        -------
        dict
            ``scene`` and ``charts`` (HTML).

        Raises
        ------
        FreebodyError
            If a name is unknown, the machine cannot have the values, or the run fails.
        """
        with self._lock:
            names = (*self.model.coordinate_names, *self.model.speed_names)
            for name in initial:
                if name not in names:
                    raise SimulationError(f"Unknown coordinate or speed '{name}' of '{self.model.name}'.")
            values, initial = (
                {name: _number(name, x) for name, x in group.items()} for group in (values, initial)
            )
            length = _number("until", until)
            if not 0 < length <= 1e6:
                raise SimulationError(
                    f"Expected the length of the run between 0 and 1e6 s, got {length:g} s."
                )
            return self._motion({**self.values, **values}, initial, length)

    def change(self, text: str) -> dict[str, Any]:
        """Take the machine of a model file's text and return it as `machine` does; keep this one on an error."""
        from ...formats.toml.read import case_from_text

        with self._lock:
            before = self.case, self.text
            try:
                self._take(case_from_text(text), text)
                return self._machine()
            except FreebodyError:
                self._take(*before)
                raise

    def _motion(
        self, values: Mapping[str, float], initial: Mapping[str, Any], until: float
    ) -> dict[str, Any]:
        # initial values of the model may be expressions of parameters; they follow these until the user moves them
        start = {**self.case.initial, **initial}
        trajectory = simulate(
            self.model, until, initial=start, near=self.case.near, values=values, max_steps=STEPS,
            tolerance=1e-8 if self.case.tolerance is None else self.case.tolerance,
        )  # fmt: skip
        scene = animation(trajectory)
        self._trajectory = trajectory
        return {"scene": scene, "charts": charts(scene), "start": self._start(values)}

    def _sliders(self) -> list[dict[str, Any]]:
        """Sliders of parameters, coordinates and speeds, with their values, ranges and units."""
        model, result = self.model, []
        about = about_of(self.case.system)
        relevant = self._relevant_parameters()
        for parameter in model.parameters:
            if parameter.name not in relevant:
                continue
            x = self.values[parameter.name]
            unit, text = about.get(parameter.name, ("", ""))
            low, high = (min(0.0, 2 * x), max(0.0, 2 * x)) if x else (-1.0, 1.0)
            result.append(_slider("values", parameter.name, x, low, high, unit, text))
        rest = dict(zip(model.coordinate_names, map(float, rest_coordinates(model)), strict=True))
        start = self._start(self.values)
        scalars = {c.name for c in model.coordinates if c.kind == "scalar"}
        # with constraints, only initial values that the model gives have sliders: all others follow from these
        for name in model.coordinate_names:
            if name in scalars and (not model.constraints or name in start):
                x = float(start.get(name, rest[name]))
                low, high = min(-math.pi, 2 * x), max(math.pi, 2 * x)
                result.append(
                    _slider("initial", name, x, low, high, "", "at the start", self._followed(name))
                )
        for name in model.speed_names:
            if not model.constraints or name in start:
                x = float(start.get(name, 0.0))
                reach = max(10.0, 2 * abs(x))
                result.append(
                    _slider("initial", name, x, -reach, reach, "", "at the start", self._followed(name))
                )
        return result

    def _relevant_parameters(self) -> set[str]:
        """Names of the parameters that the motion or the drawing depends on."""
        model, system = self.model, self.case.system
        solids = [body.mass_properties for body in system.bodies.values()]
        start = [system.expression(x) for x in (*self.case.initial.values(), *self.case.near.values())]
        parts = (
            model.links, model.loads, model.gravity, model.constraints, model.contacts, model.controllers, solids, start
        )  # fmt: skip
        return {symbol.name for symbol in symbols_of(parts)}

    def _followed(self, name: str) -> list[str]:
        """Names of the parameters that an initial value depends on."""
        parameters = {parameter.name for parameter in self.model.parameters}
        start = self.case.system.expression(self.case.initial.get(name, 0))
        return sorted({symbol.name for symbol in symbols_of(start)} & parameters)

    def _start(self, values: Mapping[str, float]) -> dict[str, float]:
        """Initial values that the model gives for single coordinates and speeds."""
        state = float_state(self.model, values=values)
        names = (*self.model.coordinate_names, *self.model.speed_names)
        system = self.case.system
        return {
            name: float(state(system.expression(value)))
            for name, value in self.case.initial.items()
            if name in names
        }

    def _equations(self) -> str:
        """Equations as HTML, or the reason why they cannot be written; the machine moves in either case."""
        try:
            return self._formulas()
        except FreebodyError as error:
            return f"<p>{escape(str(error))}</p>"

    def _formulas(self) -> str:
        if self.model.n_u > LARGEST:
            return "<p>Not shown for a machine of this size.</p>"
        modes = longest_contact(self._trajectory)
        if modes is None:
            return formulas(Equations(self.model).mathml())
        words = ", ".join(f"{name} {mode}" for name, mode in modes.items())
        return f"<p>While contacts are: {escape(words)}</p>" + formulas(
            equations(self.model, modes=modes).mathml()
        )


def problem(error: FreebodyError) -> dict[str, Any]:
    """Return an error as the page shows it: its text, and the line of the model that it is about."""
    match = re.search(r"line (\d+)", str(error)) if isinstance(error, FormatError | ModelError) else None
    return {"error": str(error), "line": int(match[1]) if match else None}


def _slider(
    group: str,
    name: str,
    value: float,
    low: float,
    high: float,
    unit: str,
    about: str,
    follows: Sequence[str] = (),
) -> dict[str, Any]:
    return {
        "group": group,
        "name": name,
        "value": value,
        "low": low,
        "high": high,
        "unit": unit,
        "about": about,
        "follows": list(follows),
    }


def _number(name: str, value: Any) -> float:
    """A finite number, from data of the page."""
    try:
        number = math.nan if isinstance(value, bool) or not isinstance(value, int | float) else float(value)
    except OverflowError:  # an integer beyond the largest float
        number = math.inf
    if not math.isfinite(number):
        raise SimulationError(f"Expected a finite number for '{name}', got {repr(value)[:40]}.")
    return number


def body(name: str) -> str:
    """Return the HTML of the live page's body."""
    return (
        f'<h1 id="name">{escape(name)}</h1>\n<p id="problem" role="alert" hidden></p>\n<div class="live">\n'
        '<section><div id="player"></div><h2>Plots</h2><div id="charts"></div></section>\n'
        '<aside><h2>Values</h2><div id="sliders"></div></aside>\n</div>\n'
        '<h2>Equations of motion</h2><div id="equations"></div>\n'
        '<h2>Model</h2><div class="editor"><pre id="lines" aria-hidden="true"></pre>'
        '<textarea id="text" spellcheck="false" aria-label="Model file"></textarea></div>\n'
        '<p><button id="apply" type="button">Apply the text</button> '
        '<button id="close" type="button">Close</button></p>'
    )
