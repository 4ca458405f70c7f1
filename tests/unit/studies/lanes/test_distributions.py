"""Distributions: quantiles and densities of all kinds, and what is refused."""

from __future__ import annotations

import pickle
import threading

import numpy as np
import pytest
import scipy.stats

import freebody as fb
from freebody.errors import SimulationError
from freebody.studies.lanes.distributions import marginal

P = np.array([0.01, 0.3, 0.5, 0.999])


class Squares:
    """A distribution of the user: x = a p²."""

    def __init__(self, a: float) -> None:
        self.a = a

    def ppf(self, p: np.ndarray) -> np.ndarray:
        return self.a * p**2


class Locked(Squares):
    def __init__(self) -> None:
        super().__init__(1.0)
        self.lock = threading.Lock()


class Bare(Squares):
    def ppf(self, p: np.ndarray) -> np.ndarray:
        return np.stack([p, p])


class Falling(Squares):
    def ppf(self, p: np.ndarray) -> np.ndarray:
        return -p


class Failing(Squares):
    def ppf(self, p: np.ndarray) -> np.ndarray:
        raise ValueError("no quantiles today")


class Late(Squares):
    """Infinite in the upper hundredth only."""

    def ppf(self, p: np.ndarray) -> np.ndarray:
        return np.where(p > 0.99, np.inf, p)


def test_pairs_are_uniform() -> None:
    x, exact = marginal((-1, 3), "I"), scipy.stats.uniform(-1, 4)
    assert np.allclose(x.quantile(P), exact.ppf(P), rtol=1e-15)
    points = np.array([-1.5, -1, 0, 3, 3.5])
    assert np.array_equal(x.density(points), exact.pdf(points))
    assert x.support() == (-1, 3) and str(x) == "uniform(-1, 3)"


@pytest.mark.parametrize(
    ("distribution", "text"),
    [
        (scipy.stats.norm(0.5, 0.05), "norm(0.5, 0.05)"),
        (scipy.stats.truncnorm(-2, 2, loc=1), "truncnorm(-2, 2, loc=1)"),
        (scipy.stats.Normal(mu=0.5, sigma=0.05), "Normal(mu=0.5, sigma=0.05)"),
        (scipy.stats.randint(1, 4), "randint(1, 4)"),
        (scipy.stats.rv_histogram(([1, 2, 3], [0, 1, 2, 3])), "a rv_histogram"),
        (Squares(3.0), "a Squares"),
    ],
)
def test_anything_with_quantiles(distribution, text: str) -> None:
    x = marginal(distribution, "I")
    exact = (getattr(distribution, "ppf", None) or distribution.icdf)(P)
    assert np.array_equal(x.quantile(P), exact)
    assert str(x) == text
    assert fb.sample({"I": distribution}, 8).columns(0, 8)["I"].shape == (8,)


def test_densities_of_discrete_distributions_are_probabilities() -> None:
    for die in (scipy.stats.randint(1, 7), scipy.stats.binom(3, 0.5), scipy.stats.Binomial(n=3, p=0.5)):
        x = marginal(die, "I")
        assert x.discrete and np.array_equal(x.density(np.array([1.0, 2.5])), die.pmf([1.0, 2.5]))
    for curve in (scipy.stats.norm(), scipy.stats.truncate(scipy.stats.Normal(mu=0.0, sigma=1.0), -1, 1)):
        assert not marginal(curve, "I").discrete
    assert not marginal(scipy.stats.Normal(mu=0.0, sigma=1.0), "I").discrete


def test_a_distribution_cannot_be_changed_afterwards() -> None:
    own = Squares(3.0)
    x = marginal(own, "I")
    own.a = 4.0
    assert x.quantile(np.array([1.0])) == 3


class Forgetful(Squares):
    """Copies of it are of another distribution."""

    def __reduce__(self) -> tuple:
        return Squares, (1.0,)


@pytest.mark.parametrize(
    "distribution",
    [
        scipy.stats.Normal(mu=0.5, sigma=0.05),
        scipy.stats.Mixture(
            [scipy.stats.Normal(mu=1.0, sigma=2.0), scipy.stats.Normal()], weights=[0.2, 0.8]
        ),
        2 * scipy.stats.Normal(mu=1.0, sigma=0.5) + 3,
        scipy.stats.truncate(scipy.stats.Normal(mu=0.5, sigma=0.05), 0.4, 0.6),
        scipy.stats.exp(scipy.stats.Normal(mu=0.5, sigma=0.05)),
        scipy.stats.make_distribution(scipy.stats.gamma)(a=2.0),
        scipy.stats.norm(1, 2),
    ],
)
def test_distributions_survive_the_way_to_another_process(distribution) -> None:
    """pickle alone makes a StandardNormal of every Normal of SciPy 1.17."""
    quantile = getattr(distribution, "ppf", None) or distribution.icdf
    x = marginal(distribution, "I")
    there = pickle.loads(pickle.dumps(x))
    for one in (x, there, pickle.loads(pickle.dumps(there))):
        assert np.array_equal(one.quantile(P), quantile(P))
        assert np.array_equal(one.density(P), distribution.pdf(P))
        assert one.support() == tuple(map(float, distribution.support()))


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (
            scipy.stats.norm,
            r"distribution with its parameters, such as scipy.stats.norm\(0.5, 0.05\), or a pair .*'I'",
        ),
        (scipy.stats.Normal, "distribution with its parameters"),
        (scipy.stats.multivariate_normal([0, 0]), "distribution with its parameters"),
        (0.5, "distribution with its parameters, .*got 0.5"),
        ((1, 2, 3), r"distribution with its parameters, .*got \(1, 2, 3\)"),
        ((2, 1), r"pair \(low, high\) of finite numbers with low < high for 'I' in the sample, got \(2, 1\)"),
        ((1, 1), r"pair \(low, high\)"),
        ((0, np.inf), r"pair \(low, high\)"),
        ((0, None), r"pair \(low, high\)"),
        ((0, {}), "Expected numbers for 'I' in the sample"),
        (Locked(), "whose content can be read and sent to other processes"),
        (Bare(1.0), r"one number for 'I', but a Bare has quantiles of shape \(2, 3\) for 3 probabilities"),
        (scipy.stats.norm([0, 1, 2], 1), "distribution with quantiles for 'I', but norm.* has none"),
        (scipy.stats.norm([0, 1], 1), "distribution with quantiles for 'I', but norm.* has none"),
        (scipy.stats.norm(0, -1), "finite quantiles that do not decrease for 'I', .* Check its parameters"),
        (
            Falling(1.0),
            r"do not decrease for 'I', but a Falling has \[-0.25, -0.5, -0.75\] at 25, 50 and 75 %",
        ),
        (
            Forgetful(2.0),
            r"whose copies are equal to it, .*'I', but a Forgetful has \[0.125, .*and its copy \[0.0625",
        ),
        (Failing(1.0), "with quantiles for 'I', but a Failing has none: no quantiles today"),
    ],
)
def test_refusals(value, message: str | None) -> None:
    with pytest.raises(SimulationError, match=message):
        fb.sample({"I": value}, 4)


def test_infinite_values_name_their_lane() -> None:
    law = fb.sample({"I": Late(1.0)}, 10_000, by="lhs")
    p = fb.sample({"I": (0, 1)}, 10_000, by="lhs").columns(0, 10_000)["I"]
    lane = int(np.flatnonzero(p > 0.99)[0])
    with pytest.raises(
        SimulationError, match=rf"finite values of 'I', but a Late has inf at .* of lane {lane}\. Cut"
    ):
        law.columns(0, 10_000)
    law.columns(0, lane)


def test_texts_of_a_pair_are_read_by_the_model() -> None:
    s = fb.System("x")
    s.hinge(
        "pin", s.ground, s.body("b", fb.particle(1)), to=(0, s.parameters(L=1.0), 0), axis="z", coordinate="q"
    )
    model = fb.assemble(s)
    law = fb.sample({"L": ("50 cm", "2 m"), "q": (0, "pi")}, 4, proposal={"L": ("40 cm", 3)})
    columns = law.resolved(model).columns(0, 4)
    assert ((columns["L"] > 0.4) & (columns["L"] < 3)).all() and (columns["q"] < np.pi).all()
    with pytest.raises(SimulationError, match=r"low < high for 'L' in lanes, got \('2 m', '50 cm'\)"):
        fb.sample({"L": ("2 m", "50 cm")}, 4).resolved(model)
    with pytest.raises(SimulationError, match="Expected a proposal for 'L' that reaches all values"):
        fb.sample({"L": ("50 cm", "2 m")}, 4, proposal={"L": ("60 cm", 3)}).resolved(model)
