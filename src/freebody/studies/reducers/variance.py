"""Variance of a number over all runs, and covariance of two.

The variance is the covariance of a number with itself. With exact sums S_ij = Σ x^i y^j,

    c = (n S_11 - S_10 S_01) / (n (n - 1)),
    var c = (μ_22 - (n - 2)/(n - 1) c² + s_x² s_y²/(n - 1)) / n,

where μ_22 is the mean of (x - x̄)² (y - ȳ)², also a ratio of integers. Only the last division and root round.

Source: Kendall and Stuart, The Advanced Theory of Statistics (1977), for the variance of a sample covariance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...errors import arguments_named
from .exact_moments import UNIT, Moments, moments, quotient, square_root
from .number import Array
from .reducer import Reducer, Variable, is_skipped, numbers_of

_OF_ONE = ((1,), (2,), (3,), (4,))
_OF_TWO = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (2, 1), (1, 2), (2, 2))


@arguments_named
def variance(what: str, by: Any = None, *, missing: str = "raise") -> Variance:
    """Return the reducer for the variance of a number over all runs.

        s² = Σ (x - x̄)² / (n - 1)

    It is right to the last bit, even for a tiny scatter about a large mean: the sums of powers are exact. Its standard
    error follows from the fourth moment, for any distribution that has one.

    Parameters
    ----------
    what : str
        Number of a whole run, as in :func:`freebody.mean`.
    by : str or sequence of str, optional
        Numbers whose distinct values are groups.
    missing : {"raise", "skip"}, optional
        Meaning of a run in which the number has no finite value.

    Returns
    -------
    Variance
        Its result has ``value``, ``error``, ``count``; they are nan for fewer than two runs.

    Raises
    ------
    SimulationError
        If the text is no number of a whole run.

    Examples
    --------
    >>> import freebody as fb, numpy as np
    >>> v = fb.variance("max(theta)")
    >>> state = v.of({"max(theta)": 1e6 + np.array([0, 2, 4]) / 2**30}, lanes=np.arange(3))
    >>> v.result(state).value.item() == 4 / 2**60
    True
    """
    return Variance(**numbers_of([what], "variance", by), skipped=is_skipped(missing, "variance"))


@arguments_named
def covariance(what: str, other: str, by: Any = None, *, missing: str = "raise") -> Covariance:
    """Return the reducer for the covariance of two numbers over all runs.

        c = Σ (x - x̄) (y - ȳ) / (n - 1)

    Like the variance it is right to the last bit.

    Parameters
    ----------
    what, other : str
        Numbers of a whole run, as in :func:`freebody.mean`.
    by : str or sequence of str, optional
        Numbers whose distinct values are groups.
    missing : {"raise", "skip"}, optional
        Meaning of a run in which one of the numbers has no finite value.

    Returns
    -------
    Covariance
        Its result has ``value``, ``error``, ``count`` and ``correlation``, c/(s_x s_y).

    Raises
    ------
    SimulationError
        If a text is no number of a whole run.

    Examples
    --------
    >>> import freebody as fb, numpy as np
    >>> c = fb.covariance("I", "max(theta)")
    >>> state = c.of({"I": np.array([1.0, 2, 3]), "max(theta)": np.array([6.0, 4, 2])}, lanes=np.arange(3))
    >>> data = c.result(state)
    >>> data.value.item(), data.correlation.item()
    (-2.0, -1.0)
    """
    return Covariance(
        **numbers_of([what, other], "covariance", by), skipped=is_skipped(missing, "covariance")
    )


@dataclass(frozen=True, repr=False)
class Covariance(Reducer):
    """Covariance of two numbers. Made by :func:`covariance`."""

    title: ClassVar[str] = "covariance"

    def part(self, values: list[Array], lanes: Any, weighted: bool) -> Moments:
        """Return the exact sums of the lanes of one group."""
        return moments(values, _OF_ONE if len(values) == 1 else _OF_TWO)

    def variables(self, parts: list[Moments]) -> tuple[dict[str, Variable], dict[str, Any]]:
        """Return value, error, count, and the correlation of two numbers."""
        rows = np.array([_statistics(part) for part in parts]).reshape(-1, 3)
        text = f"{self.title} of {' and '.join(number.text for number in self.numbers)}"
        result: dict[str, Variable] = {
            "value": ((), rows[:, 0], {"long_name": text}),
            "error": ((), rows[:, 1], {"long_name": "standard error"}),
            "count": ((), np.array([part.count for part in parts], dtype=np.int64), {"long_name": "runs"}),
        }
        if len(self.numbers) == 2:
            result["correlation"] = ((), rows[:, 2], {"long_name": "coefficient of correlation"})
        return result, {}


@dataclass(frozen=True, repr=False)
class Variance(Covariance):
    """Variance of a number. Made by :func:`variance`."""

    title: ClassVar[str] = "variance"


def _statistics(part: Moments) -> tuple[float, float, float]:
    """Return covariance, its standard error and the correlation; nan for fewer than two lanes."""
    n = part.count
    if n < 2:
        return np.nan, np.nan, np.nan
    s: Callable[[int, int], int] = (
        (lambda i, j: part.sum(i, j)) if len(part.powers[0]) == 2 else (lambda i, j: part.sum(i + j))
    )
    x, y, xy = s(1, 0), s(0, 1), s(1, 1)
    # n (n - 1) times the variances and the covariance; n⁴ times the central moment
    c, vx, vy = n * xy - x * y, n * s(2, 0) - x * x, n * s(0, 2) - y * y
    central = (
        n**3 * s(2, 2) - 2 * n**2 * (y * s(2, 1) + x * s(1, 2))
        + n * (y * y * s(2, 0) + x * x * s(0, 2) + 4 * x * y * xy) - 3 * x * x * y * y
    )  # fmt: skip
    # n⁵ (n - 1)³ times the variance of the covariance
    numerator = central * (n - 1) ** 3 + n**2 * (vx * vy - (n - 2) * c * c)
    value = quotient(c, n * (n - 1) << 2 * UNIT, "a variance or covariance")
    sign = 1 if c >= 0 else -1
    return value, square_root(numerator, n**5 * (n - 1) ** 3 << 4 * UNIT), sign * square_root(c * c, vx * vy)
