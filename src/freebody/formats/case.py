"""A model file's content: the machine, and what is to be run with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy

from ..describe.system import System
from ..errors import ModelError, nearest


@dataclass(frozen=True)
class Case:
    """A system with the start and the length of a run.

    Attributes
    ----------
    system : System
    initial : dict of str to expression
        Values at the start by name (``theta``, ``theta'``); expressions of parameters and numbers.
    until : expression or None
        Length of the run [s].
    tolerance : float or None
        Of the integration.
    """

    system: System
    initial: dict[str, Any] = field(default_factory=dict)
    until: Any = None
    tolerance: float | None = None

    def values(self, given: Mapping[str, float] | None = None) -> dict[str, float]:
        """Values of all parameters: those given, and the defaults of the others.

        Raises
        ------
        ModelError
            A name that is no parameter, a parameter that has no value.
        """
        given = dict(given or {})
        known = {parameter.name: parameter for parameter in self.system.parameter_list}
        for name in given:
            if name not in known:
                raise ModelError(f"Unknown parameter '{name}'; {nearest(name, known)}")
        result = {}
        for name, parameter in known.items():
            value = given.get(name, parameter.default)
            if value is None:
                raise ModelError(
                    f"Parameter '{name}' has no default value. Give one, such as --set {name}=1."
                )
            result[name] = float(value)
        return result

    def start(self, values: Mapping[str, float]) -> dict[str, float]:
        """The initial values as numbers, at these values of the parameters."""
        return {name: self.number(value, values) for name, value in self.initial.items()}

    def number(self, expression: Any, values: Mapping[str, float]) -> float:
        """An expression of parameters as a number."""
        symbols = {p.symbol: values[p.name] for p in self.system.parameter_list}
        return float(sympy.sympify(expression).subs(symbols))
