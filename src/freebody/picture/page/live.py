"""A machine whose values are moved while it is looked at: each change gives a new motion, as the data of the page."""

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
from ...motion.simulate import simulate
from ...symbolic.equations import Equations, equations
from .animation import animation
from .longest_phases import lasting
from .report import LARGEST, charts, formulas

LENGTH = 10.0
"""Of the run, where the model says none [s]."""

STEPS = 200_000
"""Most steps of a run."""


class Live:
    """A machine with values, a start and the length of its run, all of which may change.

    Parameters
    ----------
    case : Case
        The system, and the start and the length of its run.
    text : str
        The model file's text, which the page shows and changes.

    Raises
    ------
    ModelError
        What :func:`freebody.assemble` refuses.
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
        """What the page shows of the machine: its sliders, drawing, equations and first motion."""
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
        """The motion with other values and another start.

        Parameters
        ----------
        values, initial : mapping
            Of parameters, coordinates and speeds by name, numbers.
        until : float
            Length of the run [s].

        Returns
        -------
        dict
            ``scene`` and ``charts`` (HTML).

        Raises
        ------
        FreebodyError
            Unknown names, values that no machine can have, a run that fails.
        """
        with self._lock:
            known = (*self.model.coordinate_names, *self.model.speed_names)
            for name in initial:
                if name not in known:
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
        """Another machine, from the text of a model file; the present one stays if the text is none."""
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
        # the start that the model gives may hold parameters, and follows them until it is moved itself
        start = {**self.case.initial, **initial}
        trajectory = simulate(
            self.model, until, initial=start, near=self.case.near, values=values, max_steps=STEPS,
            tolerance=1e-8 if self.case.tolerance is None else self.case.tolerance,
        )  # fmt: skip
        scene = animation(trajectory)
        self._seen = trajectory
        return {"scene": scene, "charts": charts(scene), "start": self._start(values)}

    def _sliders(self) -> list[dict[str, Any]]:
        model, result = self.model, []
        about = about_of(self.case.system)
        moving = self._moving()
        for parameter in model.parameters:
            if parameter.name not in moving:
                continue
            x = self.values[parameter.name]
            unit, text = about.get(parameter.name, ("", ""))
            low, high = (min(0.0, 2 * x), max(0.0, 2 * x)) if x else (-1.0, 1.0)
            result.append(_slider("values", parameter.name, x, low, high, unit, text))
        rest = dict(zip(model.coordinate_names, map(float, rest_coordinates(model)), strict=True))
        given = self._start(self.values)
        free = {c.name for c in model.coordinates if c.kind == "scalar"}
        # of a machine with constraints only what the model gives can be moved: the rest follows
        for name in model.coordinate_names:
            if name in free and (not model.constraints or name in given):
                x = float(given.get(name, rest[name]))
                low, high = min(-math.pi, 2 * x), max(math.pi, 2 * x)
                result.append(
                    _slider("initial", name, x, low, high, "", "at the start", self._followed(name))
                )
        for name in model.speed_names:
            if not model.constraints or name in given:
                x = float(given.get(name, 0.0))
                reach = max(10.0, 2 * abs(x))
                result.append(
                    _slider("initial", name, x, -reach, reach, "", "at the start", self._followed(name))
                )
        return result

    def _moving(self) -> set[str]:
        """Names of the parameters that the motion or the drawing depends on."""
        model, system = self.model, self.case.system
        solids = [body.mass_properties for body in system.bodies.values()]
        start = [system.expression(x) for x in (*self.case.initial.values(), *self.case.near.values())]
        parts = (
            model.links, model.loads, model.gravity, model.constraints, model.contacts, model.controllers, solids, start
        )  # fmt: skip
        return {symbol.name for symbol in symbols_of(parts)}

    def _followed(self, name: str) -> list[str]:
        """Names of the parameters that a value of the start is an expression of."""
        known = {parameter.name for parameter in self.model.parameters}
        start = self.case.system.expression(self.case.initial.get(name, 0))
        return sorted({symbol.name for symbol in symbols_of(start)} & known)

    def _start(self, values: Mapping[str, float]) -> dict[str, float]:
        """The start that the model gives, where it gives numbers for one coordinate or speed."""
        state = float_state(self.model, values=values)
        names = (*self.model.coordinate_names, *self.model.speed_names)
        system = self.case.system
        return {
            name: float(state(system.expression(value)))
            for name, value in self.case.initial.items()
            if name in names
        }

    def _equations(self) -> str:
        """The equations; why there are none, where they can not be written. The machine moves all the same."""
        try:
            return self._written()
        except FreebodyError as error:
            return f"<p>{escape(str(error))}</p>"

    def _written(self) -> str:
        if self.model.n_u > LARGEST:
            return "<p>Not shown for a machine of this size.</p>"
        sets = [one for one in lasting(self._seen) if set(one[0].values()) != {"open"}]
        if not sets:
            return formulas(Equations(self.model).mathml())
        modes, _ = max(sets, key=lambda one: one[1])
        words = ", ".join(f"{name} {mode}" for name, mode in modes.items())
        return f"<p>While contacts are: {escape(words)}</p>" + formulas(
            equations(self.model, modes=modes).mathml()
        )


def problem(error: FreebodyError) -> dict[str, Any]:
    """An error as the page shows it: its text, and the line of the model that it speaks of."""
    found = re.search(r"line (\d+)", str(error)) if isinstance(error, FormatError | ModelError) else None
    return {"error": str(error), "line": int(found[1]) if found else None}


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
    try:
        number = math.nan if isinstance(value, bool) or not isinstance(value, int | float) else float(value)
    except OverflowError:  # an integer beyond the largest float
        number = math.inf
    if not math.isfinite(number):
        raise SimulationError(f"Expected a finite number for '{name}', got {repr(value)[:40]}.")
    return number


def body(name: str) -> str:
    """The HTML inside of the live page."""
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
