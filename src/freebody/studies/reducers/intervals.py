"""Confidence intervals: of a fraction, and of a quantile by its order statistics.

Sources: Wilson, Probable inference, the law of succession, and statistical inference (1927); David and Nagaraja,
Order Statistics (2003).
"""

from __future__ import annotations

import math
from fractions import Fraction

CONFIDENCE = 0.95
"""Probability that an interval covers the true value."""
DEVIATIONS = 1.959963984540054
"""Half of the width of an interval of 95 % of a normal distribution, in standard deviations."""


def wilson(k: int, n: int) -> tuple[float, float]:
    """Return Wilson's interval of a probability after k of n runs; it is never empty, not even for k = 0.

    (p + z²/2n ± z sqrt(p (1 - p)/n + z²/4n²)) / (1 + z²/n),   p = k/n

    >>> [round(x, 4) for x in wilson(0, 100)]
    [0.0, 0.037]
    """
    if not n:
        return math.nan, math.nan
    z2 = DEVIATIONS**2
    centre = k + z2 / 2
    half = DEVIATIONS * math.sqrt(k * (n - k) / n + z2 / 4)
    low = 0.0 if k == 0 else (centre - half) / (n + z2)
    return low, 1.0 if k == n else (centre + half) / (n + z2)


def rank_of(q: float, n: int) -> int:
    """Return the rank of the sample quantile, the least k with k/n >= q, from 1 to n.

    >>> rank_of(0.5, 4), rank_of(0.999, 1000)
    (2, 999)
    """
    return max(1, math.ceil(Fraction(repr(q)) * n))


def ranks_around(q: float, n: int) -> tuple[int, int]:
    """Return ranks whose order statistics enclose the quantile; 0 and n + 1 stand for no bound.

    P(X_(l) <= x_q < X_(u)) = P(l <= K <= u - 1),   K binomial (n, q)

    >>> ranks_around(0.5, 100)
    (40, 61)
    """
    from scipy.stats import binom

    tail = (1 - CONFIDENCE) / 2
    return int(binom.ppf(tail, n, q)), int(binom.ppf(1 - tail, n, q)) + 1
