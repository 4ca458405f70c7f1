"""Mean of a number over all runs; of a condition, the fraction of runs in which it holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...errors import arguments_named
from .exact_moments import UNIT, Moments, moments, quotient, square_root
from .intervals import CONFIDENCE, wilson
from .number import Array
from .reducer import Reducer, Variable, is_skipped, numbers_of

_PLAIN = ((1,), (2,))
_WEIGHTED = ((1, 1), (2, 2), (0, 1), (0, 2))


@arguments_named
def mean(what: str, by: Any = None, *, missing: str = "raise") -> Mean:
    """Return the reducer for the mean of a number over all runs, or for the fraction in which a condition holds.

        m = Σ f / n,   error = sqrt(Σ (f - m)² / (n (n - 1)))

    Sums are exact: neither the order nor the number of workers changes a bit. With weights w (importance sampling)
    the mean is Σ w f / n, without bias, and its error that of w f. The fraction has Wilson's interval of 95 % too.
    Errors are those of independent runs; for a Latin hypercube of n lanes they are an upper bound but for a factor
    sqrt(n/(n - 1)) (Owen 1997), for scrambled Sobol points the true ones fall faster as n grows.

    Parameters
    ----------
    what : str
        Number of a whole run: max(...), min(...), initial(...), final(...), range(...) of quantities, parameters,
        varied starts (``theta_start``), ``end``, ``steps``, ``event_time["hit"]``, ``event_last["hit"]``,
        ``event_count["hit"]``, contact modes (``final(floor.mode) == "stick"``); + - * / **, sqrt, exp, log, sin,
        ..., comparisons, and, or, not.
    by : str or sequence of str, optional
        Numbers whose distinct values are groups, such as a parameter; each group has its own mean.
    missing : {"raise", "skip"}, optional
        Meaning of a run in which the number has no finite value, such as the time of an event that did not happen:
        an error that names the lane, or a run to leave out.

    Returns
    -------
    Mean
        Its result has ``value``, ``error``, ``count``; of a fraction ``low`` and ``high``; with weights ``effective``,
        the effective number of runs (Σ w)² / Σ w².

    Raises
    ------
    SimulationError
        If the text is no number of a whole run.

    Examples
    --------
    >>> import freebody as fb, numpy as np
    >>> p = fb.mean("max(theta') > 6")
    >>> p.wanted
    ("max(theta')",)
    >>> state = p.of({"max(theta')": np.array([5.0, 7.0, 6.5, 1.0])}, lanes=np.arange(4))
    >>> more = p.of({"max(theta')": np.array([8.0])}, lanes=np.array([4]))
    >>> p.result(state.merge(more)).value.item()
    0.6
    """
    return Mean(**numbers_of([what], "mean", by), skipped=is_skipped(missing, "mean"))


@dataclass(frozen=True, repr=False)
class Mean(Reducer):
    """Mean of a number, or fraction. Made by :func:`mean`."""

    title: ClassVar[str] = "mean"
    takes_weights: ClassVar[bool] = True

    def part(self, values: list[Array], lanes: Any, weighted: bool) -> Moments:
        """Return the exact sums of the lanes of one group."""
        if weighted:
            return moments(values, _WEIGHTED)
        if self.of_condition:  # f² = f
            holds = int(np.count_nonzero(values[0]))
            return Moments(_PLAIN, len(lanes), (holds << UNIT, holds << 2 * UNIT))
        return moments(values, _PLAIN)

    def variables(self, parts: list[Moments]) -> tuple[dict[str, Variable], dict[str, Any]]:
        """Return value, error, count, and the interval of a fraction."""
        weighted = any(part.powers == _WEIGHTED for part in parts)
        first, second = _WEIGHTED[:2] if weighted else _PLAIN
        unit = UNIT * sum(first)
        pairs = [_mean_and_error(part.count, part.sum(*first), part.sum(*second), unit) for part in parts]
        value, error = np.array(pairs).reshape(-1, 2).T
        text = f"{'fraction of runs with' if self.of_condition else 'mean of'} {self.numbers[0].text}"
        result: dict[str, Variable] = {
            "value": ((), value, {"long_name": text}),
            "error": ((), error, {"long_name": "standard error"}),
            "count": ((), np.array([part.count for part in parts], dtype=np.int64), {"long_name": "runs"}),
        }
        if weighted:
            sizes = [quotient(part.sum(0, 1) ** 2, part.sum(0, 2), "an effective number") for part in parts]
            result["effective"] = (
                (),
                np.array(sizes),
                {"long_name": "effective number of runs, (Σ w)²/Σ w²"},
            )
            # no run with a number other than zero tells nothing of the error
            result["error"] = ((), np.where(value == 0, np.nan, error), result["error"][2])
        elif self.of_condition:
            bounds = np.array([wilson(part.sum(1) >> UNIT, part.count) for part in parts]).reshape(-1, 2).T
            about = {"long_name": f"Wilson's interval of {CONFIDENCE:.0%}", "confidence": CONFIDENCE}
            result |= {"low": ((), bounds[0], about), "high": ((), bounds[1], about)}
        return result, {}


def _mean_and_error(n: int, first: int, second: int, unit: int) -> tuple[float, float]:
    """Return Σ f/n and sqrt((n Σ f² - (Σ f)²)/(n² (n - 1))), from Σ f in units of 2^-unit and Σ f² in its square."""
    error = square_root(n * second - first**2, n * n * (n - 1) << 2 * unit)
    return quotient(first, n << unit, "a mean"), error
