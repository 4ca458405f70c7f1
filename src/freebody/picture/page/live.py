"""A machine whose values the user changes in the page: each change gives a new motion, as the data of the page."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from contextlib import suppress
from html import escape
from threading import Lock
from typing import Any

from ...dynamics.state import float_state
from ...errors import FormatError, FreebodyError, ModelError, SimulationError
from ...formats.case import Case
from ...model.assemble import assemble
from ...studies.simulate import simulate
from ..moving.keyframes import TOLERANCE
from .animation import frames_of, scene_of
from .balances import balances
from .page import stage
from .report import charts
from .simulator import simulator
from .sliders import sliders, start_of
from .symbols import Symbols

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
        self._symbols = Symbols.of(model)

    def machine(self) -> dict[str, Any]:
        """Return everything that the page shows of the machine: sliders, equations, text and first motion."""
        with self._lock:
            return self._machine()

    def _machine(self) -> dict[str, Any]:
        motion = self._motion(self.values, {}, self.until)
        case, model = self.case, self.model
        with suppress(SimulationError):  # the server computes what the page cannot
            motion["scene"]["live"] = simulator(
                case.system, self._trajectory, self._keys, motion["scene"], {}
            )
        panel = sliders(case.system, model, self.values, case.initial, case.near)
        motion["scene"]["symbols"] |= self._symbols.labels(slider["name"] for slider in panel)
        return {
            "name": self.model.name,
            "text": self.text,
            "until": self.until,
            "sliders": panel,
            **motion,
            "equations": self._equations(),
            "glyphs": self._symbols.table(),
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
            names = self.model.state_names
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
        self._trajectory, self._keys = trajectory, frames_of(trajectory, TOLERANCE)
        scene = scene_of(trajectory, self._keys)
        given = start_of(self.case.system, self.model, values, self.case.initial)
        symbols = self._symbols
        return {
            "scene": symbols.scene(scene),
            "charts": charts(scene, symbols),
            "start": given,
            "glyphs": symbols.table(),
        }

    def _equations(self) -> str:
        """Free bodies and equations as HTML, or why they cannot be written; the machine moves in either case."""
        try:
            return "\n".join(balances(self._trajectory, self._symbols))
        except FreebodyError as error:
            return f"<p>{escape(str(error))}</p>"


def problem(error: FreebodyError) -> dict[str, Any]:
    """Return an error as the page shows it: its text, and the line of the model that it is about."""
    match = re.search(r"line (\d+)", str(error)) if isinstance(error, FormatError | ModelError) else None
    return {"error": str(error), "line": int(match[1]) if match else None}


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
        '<div id="glyphs"></div>\n'
        f'<h1 id="name">{escape(name)}</h1>\n{stage(True)}\n<h2>Plots</h2><div id="charts"></div>\n'
        '<div id="equations"></div>\n'
        '<h2>Model</h2><div class="editor"><pre id="lines" aria-hidden="true"></pre>'
        '<textarea id="text" spellcheck="false" aria-label="Model file"></textarea></div>\n'
        '<p><button id="apply" type="button">Apply the text</button> '
        '<button id="close" type="button">Close</button></p>'
    )
