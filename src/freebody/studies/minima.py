"""A fit from many starts: least squares have several minima, and a search from one start finds the nearest."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..errors import SimulationError, shown
from ..model.model import Model
from .lanes.law import Law

ALIKE = 1e-6
"""Relative difference of two values up to which they are one: the search ends within 1e-8 of a minimum."""
_PART = 0.01  # part of a standard error that makes no difference


@dataclass(frozen=True)
class Minimum:
    """A minimum that a fit reached from some of its starts.

    Attributes
    ----------
    values : dict of str to float
        The unknowns there.
    cost : float
        Σ ((computed - measured)/σ)²; σ is 1 where it is not given.
    starts : int
        Number of starts from which the search ended there.
    """

    values: dict[str, float]
    cost: float
    starts: int


def best_of(
    fitted: Callable[[Mapping[str, Any]], Any], guesses: Mapping[str, Any], starts: Any, model: Model
) -> Any:
    """Return the fit of the least cost, with all minima that the starts lead to.

    ``fitted`` makes the fit from first guesses; ``guesses`` has those of unknowns that the starts do not name.

    Raises
    ------
    SimulationError
        ``starts`` is no law of lanes, names something else than unknowns, or none of them leads to a fit.
    """
    if not isinstance(starts, Law):
        raise SimulationError(
            f"Expected starts=fb.sample(...), fb.grid(...) or fb.table(...) for a fit, got {shown(starts)}."
        )
    law = starts.resolved(model, "starts")
    if others := [name for name in law.names if name not in guesses]:
        raise SimulationError(
            f"Expected starts of the unknowns {', '.join(guesses)}, got '{others[0]}'. Name it in unknown= too, or "
            "leave it out."
        )
    fits, errors = [], []
    for k in range(law.count):
        values = {name: float(column[0]) for name, column in law.columns(k, k + 1).items()}
        try:
            fits.append(fitted({**guesses, **values}))
        except SimulationError as error:
            errors.append(error)
    if not fits:
        raise SimulationError(
            f"None of the {law.count} starts led to a fit. The first: {errors[0]}"
        ) from errors[0]
    fits.sort(key=lambda fit: fit.cost)
    groups: list[list[Any]] = []
    for fit in fits:
        group = next((group for group in groups if _alike(group[0], fit)), None)
        if group is None:
            groups.append(group := [])
        group.append(fit)
    minima = tuple(Minimum(group[0].values, group[0].cost, len(group)) for group in groups)
    return replace(fits[0], minima=minima, failed_starts=len(errors))


def _alike(one: Any, other: Any) -> bool:
    """Return True if two fits ended at the same minimum."""
    return all(
        abs(a - other.values[name]) <= ALIKE * max(abs(a), abs(other.values[name])) + _PART * one.errors[name]
        for name, a in one.values.items()
    )
