"""Controllers: Python functions that are called once per sample and whose results hold until the next sample."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from ..errors import ModelError, nearest, shown
from .description import Description, names_of, parameters_of, varying
from .labels import Named
from .names import check_name


@dataclass(frozen=True, eq=False, repr=False)
class Controller(Named):
    """A sampled controller. Made by :meth:`System.controller`.

    ``inputs``   names of the parameters that it sets
    ``sensors``  (name, expression) of its further arguments, besides coordinates, speeds and parameters
    """

    name: str
    function: Callable[..., Any]
    period: Any
    inputs: tuple[str, ...]
    sensors: tuple[tuple[str, Any], ...]


def controller(
    system: Description,
    function: Callable[..., Any],
    period: Any,
    inputs: Any,
    *,
    sensors: Mapping[str, Any] | None = None,
    name: str | None = None,
) -> Controller:
    """A sampled controller: a Python function that sets parameters, called once per sample.

    At t = start + k ``period``, k = 0, 1, ..., the function is called with the time and the state; what it returns
    holds until the next sample (zero-order hold).

    Parameters
    ----------
    function : callable
        ``function(t, x)``: the time [s] and the state, ``x["theta"]``, ``x["theta'"]``: coordinates, speeds,
        parameters (inputs with the value held up to now) and sensors, by name. It returns the number for the input; for
        several inputs, a mapping by name or one number for each in their order. Its method ``reset``, if it has one,
        is called when a run begins.
    period : expression
        Time between two samples [s]: a number, or an expression of parameters.
    inputs : str, symbol or list of them
        Parameters that it sets; they may stand in loads and in gravity.
    sensors : mapping of str to expression, optional
        Further entries of the state: expressions of coordinates, speeds, time and parameters, and as texts such as
        ``"foot.normal"`` of quantities of contacts, as events watch them, just before the sample. Forces in time steps
        are means over the last step. At the start of a run, before any force has acted, they are 0.
    name : str, optional
        Name in error messages; the name of the function if not given.

    Raises
    ------
    ModelError
        Inputs that are not parameters of this system or that another controller sets, a period that is not positive.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("cart")
    >>> push = s.parameters(push=0.0)
    >>> cart = s.body("cart", fb.particle(2))
    >>> rail = s.slider("rail", s.ground, cart, axis="x", coordinate="x")
    >>> motor = s.force("motor", rail, push)
    >>> pd = s.controller(lambda t, x: 4 * (1 - x["x"]) - 4 * x["x'"], 0.01, "push", name="pd")
    >>> motion = fb.simulate(s, until=20)
    >>> round(motion.at(20)["x"], 6), round(float(motion["push"][0]), 6)
    (1.0, 4.0)
    """
    if not callable(function) or isinstance(function, sympy.Basic):
        raise ModelError(
            f"Expected a Python function of (t, state) for a controller, got {shown(function)}. A law without "
            "samples is an expression: s.torque('motor', joint, '-k*theta')."
        )
    label = name or getattr(function, "__name__", type(function).__name__)
    label = check_name("controller" if label == "<lambda>" else label, "controller")
    what = f"controller '{label}'"
    if label in system.controllers:
        raise ModelError(f"There is already a {what} in this system. Pass another name=.")
    period = system.expression(period, f"the period of {what}")
    moving = varying(system, period)
    if moving:
        raise ModelError(f"The period of {what} must be constant, but it depends on {', '.join(moving)}.")
    if not isinstance(period, sympy.Basic) and not 0 < float(period) < math.inf:
        raise ModelError(f"Expected a period greater than 0 s for {what}, got {period}.")
    names = _inputs(system, inputs, what)
    expressions = []
    if not isinstance(sensors, Mapping | None):
        raise ModelError(
            f"Expected sensors of {what} as expressions by name, such as {{'height': 'L*cos(theta)'}}, got "
            f"{shown(sensors)}."
        )
    for key, value in (sensors or {}).items():
        check_name(key, "sensor")
        if key in names_of(system).kinds:
            raise ModelError(
                f"Sensor '{key}' of {what} has the name of a {names_of(system).kinds[key]} of this system. "
                "Choose another."
            )
        names_contacts = isinstance(value, str) and _OUTPUT.search(value)  # a motion knows these
        expressions.append(
            (key, value if names_contacts else system.expression(value, f"sensor '{key}' of {what}"))
        )
    result = Controller(label, function, period, names, tuple(expressions))
    system.controllers[label] = result
    return result


_OUTPUT = re.compile(r"(?<![\w.\]])([^\W\d]\w*)(?:\[[^\[\]]*\]\w*)?\.[^\W\d]\w*")


def _inputs(system: Description, inputs: Any, what: str) -> tuple[str, ...]:
    """Return the names of the parameters that a controller sets."""
    if isinstance(inputs, str):
        inputs = inputs.replace(",", " ").split()
    elif not isinstance(inputs, Sequence):
        inputs = [inputs]
    names = names_of(system)
    parameters = sorted(p.name for p in parameters_of(system) if names.kinds[p.name] == "parameter")
    result: list[str] = []
    for parameter in inputs:
        text = names.text_of(parameter)
        if text not in parameters:
            raise ModelError(
                f"Expected parameters of this system as the inputs of {what}, got '{text}'; "
                f"{nearest(text, parameters)} "
                f"Declare an input first: {text if text.isidentifier() else 'tau'} = s.parameters(...=0)."
            )
        for controller in system.controllers.values():
            if text in controller.inputs:
                raise ModelError(
                    f"Parameter '{text}' is already set by controller '{controller.name}', not also by {what}."
                )
        if text in result:
            raise ModelError(f"Parameter '{text}' is listed twice in the inputs of {what}.")
        result.append(text)
    if not result:
        raise ModelError(f"Expected at least one input for {what}, such as inputs='tau'.")
    return tuple(result)
