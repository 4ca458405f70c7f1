"""Events: times at which an expression of the state passes through zero."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...dynamics.conditions.unilateral import MotionWarning
from ...errors import SimulationError, arguments_named
from ...model import Model
from ...scalar.algebra import Expression
from ..kernels.kernels import Kernels
from ..kernels.reading import expression_of
from ..kernels.switches import Switch, switches
from ..ode.dense_output import Watch
from .contact_expressions import of_contacts, refuse_outputs


@dataclass(frozen=True)
class EventSpec:
    """An event to watch for. Made by :func:`event`."""

    expression: Expression
    name: str
    direction: int = 0
    terminal: bool = False


@dataclass(frozen=True)
class Event:
    """An event that happened.

    Attributes
    ----------
    time : float
        Time of the event [s].
    name : str
        Name of the event.
    direction : int
        +1 when the expression rose through zero, -1 when it fell.
    state : mapping of str to float
        Coordinates and speeds at that time, by name.
    note : str
        What a force of a contact is that the motion does not determine there; else empty.
    """

    time: float
    name: str
    direction: int
    state: Mapping[str, float]
    note: str = field(default="", kw_only=True)

    def __str__(self) -> str:
        how = {1: "rises through", -1: "falls through"}.get(self.direction, "is")
        return f"t = {self.time:.6g} s: {self.name}: {how} zero{'; ' if self.note else ''}{self.note}"


@dataclass(frozen=True)
class Happening(Event):
    """An event that the user did not ask for: a blow, an impact, a change of a contact mode or of the active conditions
    of a linkage, a one-sided constraint whose force passes its limit.

    ``text`` says what happened; ``state`` is the state just before, ``after`` the state just after; ``warnings``
    concern its impulses.
    """

    text: str = ""
    after: dict[str, float] = field(default_factory=dict)
    warnings: tuple[MotionWarning, ...] = ()

    @classmethod
    def between(
        cls, names: Sequence[str], time: float, name: str, states: tuple[Any, Any], text: str,
        warnings: tuple[MotionWarning, ...] = (),
    ) -> Happening:  # fmt: skip
        """Return the event with arrays of the states before and after it, which begin with what has these names."""
        before, after = (dict(zip(names, y.tolist(), strict=False)) for y in states)
        return cls(time, name, 0, before, text, after, warnings)

    def __str__(self) -> str:
        return f"t = {self.time:.6g} s: {self.text}"


class EventList(list[Event]):
    """Events in their order; ``print`` shows a sentence for each."""

    def __str__(self) -> str:
        return "\n".join(map(str, self))


@arguments_named
def event(
    expression: Expression, name: str | None = None, direction: int = 0, terminal: bool = False
) -> EventSpec:
    """Return an event to watch for in a simulation: ``expression`` passes through zero.

    A jump from one sign to the other passes through zero; a pole such as that of ``1/theta`` does not. A run does not
    start, and stops, where the expression has no value. In time steps events lie on the straight line between the ends
    of a step.

    Parameters
    ----------
    expression : SymPy expression or text
        Expression of coordinates, speeds, time and parameters, such as ``"theta - pi/2"`` or ``"x'"``.
    name : str, optional
        Name of the event in the results; the expression's text if not given.
    direction : {0, 1, -1}
        Only where the expression rises (+1) or falls (-1) in the direction of the run; both if 0.
    terminal : bool
        True to stop the run there. An event at the very start of a run is recorded but does not stop it; in a batch
        only events after the start count, so that the time of the event is the time of the end.

    Returns
    -------
    EventSpec

    Examples
    --------
    >>> event("theta'", name="turning point", direction=-1)
    EventSpec(expression="theta'", name='turning point', direction=-1, terminal=False)
    """
    if callable(expression) and not hasattr(expression, "free_symbols"):
        raise SimulationError(
            f"Expected an expression for an event, got the Python function {_called(expression)}. No Python runs "
            'inside a step; write what becomes zero as an expression, such as fb.event("theta - pi/2").'
        )
    if direction not in (-1, 0, 1):
        raise SimulationError(
            f"Expected direction -1 (falling), 0 (both) or +1 (rising) for event '{name or expression}', "
            f"got {direction!r}."
        )
    if not isinstance(terminal, bool | np.bool_):
        raise SimulationError(
            f"Expected True or False for terminal= of event '{name or expression}', got {terminal!r}."
        )
    return EventSpec(
        expression, _text(expression) if name is None else str(name), int(direction), bool(terminal)
    )


def specs_of(events: Any) -> tuple[EventSpec, ...]:
    """Return the events of an argument ``events=``; a bare expression becomes an event with its text as name."""
    if isinstance(events, (tuple, list)) and not events:
        return ()
    if events is None or isinstance(events, Mapping):
        raise SimulationError(
            f"Expected a list of fb.event(...) or expressions for events=, got {events!r}. For none leave it out."
        )
    if isinstance(events, EventSpec | str) or not isinstance(events, Iterable):
        events = [events]
    return tuple(spec if isinstance(spec, EventSpec) else event(spec) for spec in events)


def switch_specs(model: Model) -> tuple[EventSpec, ...]:
    """Return the events at which loads switch: a condition of ``at.where`` rises through zero, or falls."""
    found = switches(model)
    if not found:
        return ()
    return tuple(
        EventSpec(switch, f"{switch.load} {word}", direction)
        for switch in found
        for word, direction in zip(model.loads[switch.load].switches, (1, -1), strict=True)
    )


def expressions_of(model: Model, specs: Iterable[EventSpec]) -> tuple[Expression, ...]:
    """Return the expressions of events in the names of the model."""
    result: list[Any] = []
    for spec in specs:
        if isinstance(spec.expression, Switch):
            result.append(spec.expression)
            continue
        touched = of_contacts(model, spec.expression, f"event '{spec.name}'")
        if touched is not None:
            result.append(touched)
            continue
        refuse_outputs(
            model, spec.expression, f"event '{spec.name}'", "coordinates, speeds, the time and contacts"
        )
        value = expression_of(model, spec.expression, f"event '{spec.name}'")
        if not model.names.depends(value, "coordinate", "speed", "time"):
            raise SimulationError(
                f"Expected an expression that changes for event '{spec.name}', but '{value}' depends on no "
                "coordinate, no speed and not on the time t: it never passes through zero."
            )
        result.append(value)
    return tuple(result)


def watching(
    kernels: Kernels,
    parameters: NDArray[np.float64],
    specs: Sequence[EventSpec],
    expressions: Sequence[Expression],
) -> Watch | None:
    """Return the compiled event functions; None if there are none."""
    if not specs:
        return None
    observer = kernels.expressions(tuple(expressions))
    directions, terminal = (tuple(spec.direction for spec in specs), tuple(spec.terminal for spec in specs))
    constants = observer.constants(parameters)
    return Watch(
        observer.address("values"), directions, terminal, constants, observer, functions=tuple(expressions)
    )  # fmt: skip


@lru_cache(maxsize=64)
def _printed(expression: sympy.Basic) -> str:
    """Return the text of an expression, printed once."""
    return str(expression)


def _text(expression: Expression) -> str:
    """Return the name of an event without a name."""
    return _printed(expression) if isinstance(expression, sympy.Basic) else str(expression)


def _called(function: Any) -> str:
    return f"'{getattr(function, '__name__', function)}'"
