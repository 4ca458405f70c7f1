"""Signals at the start of a run."""

from __future__ import annotations

from collections.abc import Mapping

from ...errors import ModelError, SimulationError
from ...model import Model


def at_time(model: Model, numbers: Mapping[str, float], t: float) -> Mapping[str, float]:
    """Return the values of all parameters, with the values of signals at a time."""
    if not model.names.signals:
        return numbers
    result = dict(numbers)
    for placed in model.signals:
        try:
            result.update(placed.settings(t))
        except ModelError as error:
            raise SimulationError(str(error)) from None
    return result


def check_signals(model: Model) -> None:
    """Refuse signals that occur only in an event or an output."""
    if not model.names.signals:
        return
    used = {placed.signal.name for placed in model.signals}
    for placed in model.names.signals.values():
        if placed.signal.name not in used:
            raise SimulationError(
                f"Signal '{placed.signal.name}' occurs in no load and no drive of '{model.name}', only in an event or "
                "an output. Use it in the machine before it is assembled: for example in a load with the factor 0."
            )
