"""Refusal of laws with lanes in which the machine cannot exist."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...errors import SimulationError
from ...model import Model
from .law import Law, reason_against
from .sample import Sample


def check_possible(law: Law, model: Model, values: Mapping[Any, Any] | None = None) -> None:
    """Refuse values for which the machine cannot exist in some lanes, before anything runs.

    Raises
    ------
    SimulationError
        Tells how many lanes have negative masses, impossible inertia, or values that contradict an assumption, and why
        the first of them does.
    """
    count, of, first = law.impossible(model, values)
    if first is None:
        return
    reason = reason_against(law.machines(model, first, first + 1, values), 0)
    parameters = [repr(name) for name in law.names if name in model.defaults]
    cure = "Leave these values out." if parameters else "Change the values."
    if parameters and isinstance(law, Sample):
        cure = f"Cut the distribution of {' or '.join(parameters)}, such as scipy.stats.truncnorm(...)."
    lanes = f"{count} of {of}" if of == law.count else f"{count} of the first {of}"
    raise SimulationError(
        f"Expected values for which every lane is possible, but {100 * count / of:.3g} % of the lanes ({lanes}) have "
        f"values that no machine can have, lane {first} the first: {reason} {cure}"
    )
