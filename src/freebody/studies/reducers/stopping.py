"""Rules by which a reduced study stops: when the errors of its results are small enough."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import SimulationError, arguments_named, nearest, shown
from .intervals import DEVIATIONS
from .reducer import Reducer

if TYPE_CHECKING:
    import xarray


@arguments_named
def error(result: str, *, relative: Any = None, absolute: Any = None, least: int = 100) -> ErrorRule:
    """Return the rule that a study stops when the standard error of a result is small enough.

        error <= relative |value|     or     error <= absolute

    All values of the result count: each quantile, bin and group. Of a fraction, and of a quantile, the interval counts
    too, so that no study stops early because no run has yet met the condition. A value of zero has no relative error:
    the rule is not met. Several rules in a list must all be met.

    Parameters
    ----------
    result : str
        Name of the result in ``study.reduce``.
    relative, absolute : number
        Greatest standard error, relative to the value or in its unit; one of them.
    least : int, optional
        Least number of runs, of each group; before, an error is not yet known well.

    Returns
    -------
    ErrorRule

    Raises
    ------
    SimulationError
        If neither or both errors are given, or one is not positive.

    Examples
    --------
    >>> import freebody as fb, numpy as np
    >>> p = fb.mean("max(x) > 2")
    >>> data = p.result(p.of({"max(x)": np.arange(400) % 4}, lanes=np.arange(400)))
    >>> data.error.item()
    0.0216...
    >>> fb.error("p", relative=0.1).met({"p": data}), fb.error("p", relative=0.01).met({"p": data})
    (True, False)
    """
    if not isinstance(result, str) or not result:
        raise SimulationError(f"Expected the name of a result for fb.error, got {shown(result)}.")
    if (relative is None) == (absolute is None):
        count = "neither" if relative is None else "both"
        raise SimulationError(
            f"Expected relative= or absolute= for fb.error('{result}'), got {count}. Rules in a list must all be met."
        )
    name, bound = ("relative", relative) if absolute is None else ("absolute", absolute)
    try:
        bound = float(bound)
    except (TypeError, ValueError):
        bound = math.nan
    if not 0 < bound < math.inf:
        number = shown(relative if absolute is None else absolute)
        raise SimulationError(
            f"Expected a positive number for {name}= of fb.error('{result}'), got {number}."
        )
    if type(least) is not int or least < 2:
        raise SimulationError(f"Expected at least 2 for least= of fb.error('{result}'), got {shown(least)}.")
    return ErrorRule(result, bound, absolute is None, least)


@dataclass(frozen=True)
class ErrorRule:
    """Rule that the error of a result is at most a bound. Made by :func:`error`."""

    result: str
    bound: float
    relative: bool
    least: int

    def check(self, reducers: Mapping[str, Reducer]) -> None:
        """Refuse a rule about a result that does not exist, or has no error.

        Raises
        ------
        SimulationError
            Names the nearest result.
        """
        if self.result not in reducers:
            raise SimulationError(
                f"Unknown result '{self.result}' in fb.error; {nearest(self.result, reducers)}"
            )
        reducer = reducers[self.result]
        if not reducer.has_error:
            raise SimulationError(
                f"Expected a result with a standard error for fb.error('{self.result}'), got {reducer!r}. Stop by a "
                "mean, a variance, a quantile or a histogram."
            )

    def met(self, results: Mapping[str, xarray.Dataset]) -> bool:
        """Return True if the rule is met by the results, by their names."""
        data = results[self.result]
        count, value, error = (
            np.asarray(data[name].values, dtype=float) for name in ("count", "value", "error")
        )
        if not count.size or not value.size or (count < self.least).any():
            return False
        if "low" in data:
            error = np.maximum(error, (data["high"].values / 2 - data["low"].values / 2) / DEVIATIONS)
        if not self.relative:
            return bool((error <= self.bound).all())  # not met by nan
        return bool(((error <= self.bound * np.abs(value)) & (value != 0)).all())


def rules_of(until: Any) -> tuple[ErrorRule, ...]:
    """Return the rules of an argument ``until=``: a rule, a list of rules, or None.

    Raises
    ------
    SimulationError
        Anything else.
    """
    if until is None:
        return ()
    rules = tuple(until) if isinstance(until, Sequence) and not isinstance(until, str) else (until,)
    for rule in rules:
        if not isinstance(rule, ErrorRule):
            raise SimulationError(
                f"Expected fb.error(...) or a list of them for until= of a study that is reduced, got {shown(rule)}."
            )
    return rules
