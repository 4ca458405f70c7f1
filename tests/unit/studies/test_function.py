"""Studies as functions: known heights, sensitivity indices in closed form, optimization, lanes that fail."""

from __future__ import annotations

import math
import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
import scipy.stats
from scipy.optimize import differential_evolution, minimize

import freebody as fb
from freebody.errors import SimulationError

G = 9.81


def stone(outputs="max(y)", **options) -> fb.Study:
    """A stone thrown upwards: its height is y + v²/2g."""
    s = fb.System("stone")
    m = s.parameters(m=1.0)
    s.slider("fall", s.ground, s.body("stone", fb.particle(m)), axis="y", coordinate="y")
    s.gravity = (0, -G, 0)
    lanes = fb.sample({"y'": scipy.stats.uniform(1, 2), "y": (0, 1), "m": (1, 2)}, n=1)
    return fb.study(s, until=1, lanes=lanes, outputs=outputs, **options)


def test_rows_stand_for_names_in_the_order_of_the_lanes() -> None:
    f = stone().as_function()
    assert f.names == ("y'", "y", "m") and f.outputs == ("max(y)",)
    x = np.array([[1.0, 2.0, 3.0], [0.5, 0.0, 1.0], [1.0, 1.0, 2.0]])
    exact = x[1] + x[0] ** 2 / (2 * G)
    # the tolerance of the run is 1e-9
    assert np.allclose(f(x), exact, rtol=0, atol=1e-8) and f(x).shape == (3,)
    assert isinstance(f(x[:, 0]), float) and f(x[:, 0]) == f(x)[0]
    assert np.array_equal(f.rows(x.T), f(x))
    assert f(np.empty((3, 0))).shape == (0,)
    both = stone(["max(y)", "final(y)"]).as_function()
    assert both.outputs == ("max(y)", "final(y)")
    assert both(x).shape == (2, 3) and both(x[:, 0]).shape == (2,) and both.rows(x.T).shape == (3, 2)
    assert np.allclose(both(x)[1], x[1] + x[0] - G / 2, rtol=0, atol=1e-8)
    assert stone(["max(y)"]).as_function()(x).shape == (1, 3)


def test_bits_do_not_depend_on_the_executor() -> None:
    x = np.random.default_rng(1).uniform(1, 2, (3, 500))
    here = stone().as_function()
    with ProcessPoolExecutor(2) as pool:
        there = stone().as_function(pool)
        assert np.array_equal(there(x), here(x)) and np.array_equal(there(x[:, :7]), here(x[:, :7]))
    with stone().as_function("processes") as there:
        assert np.array_equal(there(x), here(x))
    assert np.array_equal(pickle.loads(pickle.dumps(here))(x), here(x))


def test_sensitivity_indices_of_a_sum() -> None:
    """Var of v²/2g with v uniform on [1, 3]: E v⁴ − (E v²)² = 242/10 − (26/6)²; of y: 1/12. No interactions."""
    parts = np.array([(242 / 10 - (26 / 6) ** 2) / (2 * G) ** 2, 1 / 12, 0.0])
    f = stone().as_function()
    result = scipy.stats.sobol_indices(func=f, n=4096, dists=f.distributions, random_state=1)
    # the errors of Sobol points fall as about 1/n; 1/sqrt(n) is a bound for random ones
    assert np.allclose(result.first_order, parts / parts.sum(), atol=1 / math.sqrt(4096))
    assert np.allclose(result.total_order, parts / parts.sum(), atol=1 / math.sqrt(4096))


def test_ishigami_through_a_machine() -> None:
    """A body that a force F moves from rest for √2 s by F/m: x = sin a + 7 sin² b + c⁴ sin(a)/10.

    Indices of Ishigami's function, A = 7, B = 1/10: Ishigami and Homma (1990).
    """
    s = fb.System("moved")
    s.parameters(a=1.0, b=1.0, c=1.0)
    cart = s.body("cart", fb.particle(1))
    s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    s.force("push", cart.origin, ("sin(a) + 7*sin(b)^2 + c^4*sin(a)/10", 0, 0))
    between = scipy.stats.uniform(-math.pi, 2 * math.pi)
    lanes = fb.sample({"a": between, "b": between, "c": between}, n=1)
    f = fb.study(s, until=math.sqrt(2), lanes=lanes, outputs="final(x)").as_function()
    A, B, pi = 7, 0.1, math.pi
    first = np.array([(1 + B * pi**4 / 5) ** 2 / 2, A**2 / 8, 0])
    both = B**2 * pi**8 * (1 / 18 - 1 / 50)
    variance = first.sum() + both
    result = scipy.stats.sobol_indices(func=f, n=4096, dists=f.distributions, random_state=1)
    assert np.allclose(result.first_order, first / variance, atol=1.5 / math.sqrt(4096))
    total = (first + np.array([both, 0, both])) / variance
    assert np.allclose(result.total_order, total, atol=1.5 / math.sqrt(4096))


def test_optimization() -> None:
    """|y(1)| is least, 0, where v = g/2 − y; the height of a throw is greatest at the ends of the bounds."""
    s = fb.System("stone")
    s.slider("fall", s.ground, s.body("stone", fb.particle(1)), axis="y", coordinate="y")
    s.gravity = (0, -G, 0)
    f = fb.study(s, until=1, lanes=fb.grid({"y'": [0]}), outputs="final((y - 1)^2)").as_function()
    best = minimize(f, [3.0], tol=1e-10)
    assert abs(best.x[0] - (1 + G / 2)) < 1e-5 and best.fun < 1e-10
    best = differential_evolution(f, [(0, 10)], vectorized=True, updating="deferred", maxiter=60)
    assert abs(best.x[0] - (1 + G / 2)) < 1e-4


def test_salib() -> None:
    sampling, analysis = pytest.importorskip("SALib.sample.sobol"), pytest.importorskip("SALib.analyze.sobol")
    f = stone().as_function()
    problem = {"num_vars": 3, "names": list(f.names), "bounds": [[1, 3], [0, 1], [1, 2]]}
    X = sampling.sample(problem, 1024, calc_second_order=False)
    parts = np.array([(242 / 10 - (26 / 6) ** 2) / (2 * G) ** 2, 1 / 12, 0.0])
    result = analysis.analyze(problem, f.rows(X), calc_second_order=False)
    assert np.allclose(result["ST"], parts / parts.sum(), atol=1 / math.sqrt(1024))


def test_lanes_that_fail_raise_or_have_a_number() -> None:
    x = [[1.0, 2.0], [0.0, 0.0], [1.0, -1.0]]
    with pytest.raises(
        SimulationError,
        match=r"1 of 2 lanes failed, the first with y' = 2, y = 0, m = -1: refused: Body 'stone': Expected m not to be "
        r"negative .*\. as_function\(failed=\.\.\.\) takes the number",
    ):
        stone().as_function()(x)
    for failed in ("nan", math.inf, -1):
        y = stone(["max(y)", "min(y)"]).as_function(failed=failed)(x)
        assert np.array_equal(y[:, 1], [float(failed)] * 2, equal_nan=True) and np.isfinite(y[:, 0]).all()
    with pytest.raises(SimulationError, match="Expected \"raise\", or the number .* for failed=, got 'skip'"):
        stone().as_function(failed="skip")


def test_what_is_refused() -> None:
    with pytest.raises(
        SimulationError, match=r"one number of a whole run .* got 'y' over time. Write outputs=\['final\(y"
    ):
        stone("y").as_function()
    f = stone().as_function()
    with pytest.raises(
        SimulationError, match=r"shape \(3,\) or \(3, n\), whose rows are y', y, m, got shape \(2,\)"
    ):
        f([1, 2])
    with pytest.raises(
        SimulationError, match=r"got shape \(5, 3\). For an array with one row for each lane, call .rows"
    ):
        f(np.ones((5, 3)))
    with pytest.raises(
        SimulationError, match=r"shape \(n, 3\), whose columns are y', y, m, got shape \(3, 5\)"
    ):
        f.rows(np.ones((3, 5)))
    with pytest.raises(SimulationError, match="Expected finite numbers for y', y, m, got nan"):
        f([1, math.nan, 1])
    with pytest.raises(SimulationError, match="Expected numbers for y', y, m, got 'a'"):
        f("a")
    with pytest.raises(SimulationError, match=r"Expected an executor with submit\(\)"):
        stone().as_function("here")
    with pytest.raises(SimulationError, match="Expected threads= or executor=, got both"):
        stone().as_function("processes", threads=2)
    lanes = fb.grid({"y'": [1.0]})
    with pytest.raises(
        SimulationError, match=r"distributions of lanes=fb.sample\(...\), but the lanes are a grid of"
    ):
        _ = fb.study(stone().machine, 1, lanes=lanes, outputs="max(y)").as_function().distributions


class Dead:
    """An executor that takes nothing."""

    def submit(self, *arguments):
        raise RuntimeError("closed")


def test_an_executor_that_takes_nothing_is_an_error() -> None:
    with pytest.raises(
        SimulationError, match="No lane of 2 was run; the first was not begun: RuntimeError: closed"
    ):
        stone().as_function(Dead())(np.ones((3, 2)))
