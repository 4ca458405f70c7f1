"""Samples: distributions, convergence, weights."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
import scipy.stats

import freebody as fb
from freebody.errors import ArgumentError, SimulationError

KINDS = ("sobol", "lhs", "random")
NORM, GAMMA = scipy.stats.norm(0.5, 0.05), scipy.stats.gamma(2.5)


@pytest.mark.parametrize("by", KINDS)
def test_values_have_their_distribution(by: str) -> None:
    """The distance of Kolmogorov and Smirnov D.

    At random, P(D √n > 1.95) = 0.001; a hypercube, and 2^m points of Sobol, have one lane in each of n parts: D <= 1/n.
    """
    n = 1 << 14
    columns = fb.sample({"I": NORM, "theta": GAMMA, "m": (1, 2)}, n, by=by, seed=11).columns(0, n)
    for (name, x), exact in zip(columns.items(), (NORM, GAMMA, scipy.stats.uniform(1, 1)), strict=True):
        distance = scipy.stats.kstest(x, exact.cdf).statistic
        # round-off of quantile and distribution function, of 10^-12 or less
        assert distance < (1.95 / math.sqrt(n) if by == "random" else 1 / n + 1e-12), name


def test_integrals_converge_faster_than_at_random() -> None:
    """∫∫ exp(x + y) = (e - 1)². At random the error has the deviation σ/√n; a hypercube takes the sum of functions of
    one number out of the variance, and Sobol all but a little."""
    n, exact = 1 << 14, (math.e - 1) ** 2
    sigma = math.sqrt(((math.e**2 - 1) / 2) ** 2 - exact**2)
    error = {}
    for by in KINDS:
        columns = fb.sample({"x": (0, 1), "y": (0, 1)}, n, by=by, seed=2).columns(0, n)
        error[by] = abs(np.exp(columns["x"] + columns["y"]).mean() - exact)
    assert error["random"] < 4 * sigma / math.sqrt(n)
    # f - its additive part = (e^x - a)(e^y - a), a = e - 1, with the deviation (e² - 1)/2 - a²
    rest = (math.e**2 - 1) / 2 - exact
    assert error["lhs"] < 4 * rest / math.sqrt(n)
    assert error["sobol"] < 0.01 * sigma / math.sqrt(n)


def test_two_names_are_independent() -> None:
    """(x > median, y > median) in each of four squares: n/4 lanes each, to 4 √(n/16)·√3; of Sobol exactly."""
    n = 1 << 14
    for by in KINDS:
        columns = fb.sample({"x": NORM, "y": GAMMA}, n, by=by).columns(0, n)
        both = (columns["x"] > NORM.median()) & (columns["y"] > GAMMA.median())
        allowed = 0 if by == "sobol" else 4 * math.sqrt(3 * n / 16)
        assert abs(int(both.sum()) - n // 4) <= allowed


def test_a_probability_of_3_in_10_million() -> None:
    """P(x > 5) = Φ(-5), drawn from a normal distribution about 5 with weights w = φ(x)/φ(x - 5).

    Mean of w² over x > 5: e^25 Φ(-10), so that the error has the deviation √((e^25 Φ(-10) - Φ(-5)²)/n).
    """
    n, sf = 20_000, scipy.stats.norm.sf
    law = fb.sample(
        {"x": scipy.stats.norm(0, 1), "y": (0, 1)}, n, by="random", proposal={"x": scipy.stats.norm(5, 1)}
    )
    x, weights = law.columns(0, n)["x"], law.weights(0, n)
    assert weights is not None and np.allclose(weights, np.exp(12.5 - 5 * x), rtol=1e-12)
    deviation = math.sqrt((math.exp(25) * sf(10) - sf(5) ** 2) / n)
    assert deviation < 0.02 * sf(5)
    assert abs((weights * (x > 5)).mean() - sf(5)) < 4 * deviation


def test_the_mean_of_the_weights_is_1() -> None:
    """Of several names; each weight is a product. Integrals by Sobol, to 10 times its error above."""
    n = 1 << 14
    target = {"x": scipy.stats.norm(0, 1), "y": (0, 1), "k": scipy.stats.randint(1, 4)}
    proposal = {"x": scipy.stats.norm(0.5, 1.5), "k": scipy.stats.randint(0, 6)}
    law = fb.sample(target, n, proposal=proposal)
    weights, columns = law.weights(0, n), law.columns(0, n)
    assert weights is not None and abs(weights.mean() - 1) < 1e-3
    assert abs((weights * columns["x"] ** 2).mean() - 1) < 1e-3
    assert abs((weights * columns["k"]).mean() - 2) < 1e-3
    assert fb.sample(target, n).weights(0, n) is None


def test_weights_without_a_value_name_their_lane() -> None:
    """The densities of both distributions are infinite in the middle."""

    law = fb.sample({"I": Spike()}, 5, by="lhs", proposal={"I": Spike()})
    with pytest.raises(
        SimulationError, match=r"Expected finite weights, got nan in lane \d \(I = 0.5\)\. Take a proposal"
    ):
        law.weights(0, 5)


class Spike:
    def ppf(self, p: np.ndarray) -> np.ndarray:
        return np.full(np.shape(p), 0.5)

    def pdf(self, x: np.ndarray) -> np.ndarray:
        return np.full(np.shape(x), np.inf)

    def support(self) -> tuple[float, float]:
        return 0.0, 1.0


class NoDensity:
    def ppf(self, p: np.ndarray) -> np.ndarray:
        return p


def test_preparation_takes_little_time() -> None:
    """A block of 10⁵ lanes from the middle of 10⁹ takes some 10 ms; ten times that is asked."""
    for by in KINDS:
        law = fb.sample({"I": NORM, "theta": scipy.stats.norm(0, 1)}, 10**9, by=by)
        times = []
        for _ in range(3):
            clock = time.process_time()
            law.columns(500_000_000, 500_100_000)
            times.append(time.process_time() - clock)
        assert min(times) < 0.1, by


def test_print() -> None:
    law = fb.sample(
        {"I": NORM, "theta": ("10 deg", 3)}, 10**6, by="lhs", seed=4, proposal={"I": scipy.stats.norm(1, 2)}
    )
    assert repr(law) == (
        "sample of I ~ norm(0.5, 0.05) drawn from norm(1, 2), theta ~ uniform(10 deg, 3) by lhs, seed 4: 1000000 lanes"
    )


def test_a_number_of_lanes_may_be_written_as_1e6() -> None:
    assert fb.sample({"I": NORM}, 1e6).count == 10**6 and isinstance(fb.sample({"I": NORM}, 1e6).count, int)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n": 0}, "Expected a whole number of at least 1 for the number of lanes n, got 0"),
        ({"n": 2.5}, "number of lanes n, got 2.5"),
        ({"n": True}, "number of lanes n, got True"),
        ({"n": float("nan")}, "number of lanes n, got nan"),
        ({"n": "many"}, "number of lanes n, got 'many'"),
        ({"n": 2**52 + 1}, r"at most 2\^52 lanes for by='sobol', got 4503599627370497. Take by='random', or fewer"),
        ({"n": 2**41, "by": "lhs"}, r"at most 2\^40 lanes for by='lhs', got \d+. Take by='random', or fewer"),
        ({"n": 2**63, "by": "random"}, r"at most 2\^62 lanes for by='random', got \d+. Take fewer lanes"),
        ({"by": "halton"}, "Unknown way to draw 'halton'; "),
        ({"by": None}, "Unknown way to draw None"),
        ({"seed": None}, r"whole number of at least 0 for the seed, got None. A study is a value"),
        ({"seed": -1}, "for the seed, got -1"),
        ({"proposal": {"J": NORM}}, "Unknown name 'J' in proposal=; "),
        ({"proposal": {}}, "Expected values by name, such as proposal="),
        ({"proposal": {"I": (0, 1)}}, r"proposal for 'I' that reaches all .*, -inf to inf, but uniform\(0, 1\)"),
        ({"proposal": {"I": scipy.stats.expon()}}, "Take a wider proposal"),
        ({"proposal": {"I": scipy.stats.poisson(3)}}, "Expected two densities or two discrete distributions for 'I'"),
        ({"proposal": {"I": NoDensity()}}, r"with pdf\(\) and support\(\) for the weights of 'I', but the proposal"),
        ({"distributions": {"I": NoDensity()}, "proposal": {"I": NORM}}, "but the target a NoDensity lacks them"),
    ],
)  # fmt: skip
def test_refusals(arguments: dict, message: str) -> None:
    with pytest.raises(SimulationError, match=message):
        fb.sample(**{"distributions": {"I": NORM}, "n": 4, **arguments})


def test_arguments_are_named() -> None:
    with pytest.raises(
        ArgumentError, match="Expected an argument of sample, got 'proposals='; did you mean 'proposal'"
    ):
        fb.sample({"I": NORM}, 4, proposals={})
