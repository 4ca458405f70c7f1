"""Identification: exact from exact data, honest errors from noise, refusals."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ModelError


def arm():
    s = fb.System("arm")
    s.parameters(L=0.4, c=0.2, m=1.5)
    s.gravity = (0, 0, -9.81)
    upper = s.body(
        "upper", fb.MassProperties(2, (0.1, 0.02, 0), ((0.1, 0, 0), (0, 0.2, 0.01), (0, 0.01, 0.15)))
    )
    fore = s.body("fore", fb.MassProperties("m", (0.2, 0, 0.03), ((0.05, 0, 0), (0, 0.06, 0), (0, 0, 0.07))))
    shoulder = s.hinge("shoulder", s.ground, upper, axis="y")
    s.hinge("elbow", upper, fore, axis="z", at=("L", 0, 0), rotor=fb.Rotor(1e-4, ratio=50))
    s.damper("friction", shoulder, damping="c")
    return s


def measured(s, count=200, noise=0.0):
    rng = np.random.default_rng(4)
    q, u, udot = rng.uniform(-2, 2, (3, count, 2))
    tau = fb.compile(s).inverse_dynamics(q, u, udot)
    return q, u, udot, tau + noise * rng.normal(size=tau.shape) * [1, 3]


def test_exact_data_give_the_parameters():
    s = arm()
    found = fb.identify(s, *measured(s), unknowns=["c"])
    theta = np.array([*fb.compile(s).inertial_parameters().values()])
    expected = [*found.base.matrix() @ theta, 0.2]
    assert [*found.values] == [*found.base.names, "c"]
    assert np.abs(np.array([*found.values.values()]) - expected).max() < 1e-13 * found.condition


def test_noise_gives_errors_that_hold():
    """χ² of the errors of n unknowns: mean n, variance 2 n."""
    s = arm()
    found = fb.identify(s, *measured(s, 2000, 0.1), unknowns=["c"])
    theta = np.array([*fb.compile(s).inertial_parameters().values()])
    gap = np.array([*found.values.values()]) - [*found.base.matrix() @ theta, 0.2]
    n = len(gap)
    assert gap @ np.linalg.solve(found.covariance, gap) < n + 5 * np.sqrt(2 * n)
    assert found.sigma == pytest.approx({"shoulder'": 0.1, "elbow'": 0.3}, rel=0.1)
    assert "±" in repr(found) and "condition" in repr(found)


def test_what_cannot_be_found_is_refused():
    s = arm()
    q, u, udot, tau = measured(s)
    with pytest.raises(ModelError, match=r"but in these states .*fore.* cannot be distinguished"):
        fb.identify(s, 0 * q, 0 * u, udot, tau)
    with pytest.raises(ModelError, match="Expected coefficients of loads as unknowns, got m"):
        fb.identify(s, q, u, udot, tau, unknowns=["m"])
    with pytest.raises(ModelError, match="Unknown parameter 'd'"):
        fb.identify(s, q, u, udot, tau, unknowns=["d"])
    with pytest.raises(ModelError, match=r"Expected forces of shape \(200, 2\), got \(200, 1\)"):
        fb.identify(s, q, u, udot, tau[:, :1])
    with pytest.raises(ModelError, match="Expected finite numbers in u, got nan in row 3"):
        fb.identify(s, q, np.where(np.arange(200)[:, None] == 3, np.nan, u), udot, tau)
    with pytest.raises(ModelError, match=r"Expected more than \d+ measured forces"):
        fb.identify(s, q[:2], u[:2], udot[:2], tau[:2])


def test_a_load_that_is_not_linear_in_its_coefficient_is_refused():
    s = arm()
    s.parameters(k=1.0)
    s.spring("odd", s.joints["elbow"], stiffness="k**2")
    with pytest.raises(ModelError, match=r"Expected forces that are linear in 'k'.*fb\.fit"):
        fb.identify(s, *measured(s), unknowns=["k"])


def test_a_closed_loop_is_refused():
    s = arm()
    s.constrain("shoulder - 2*elbow", name="gear")
    q, u, udot, tau = measured(arm())
    with pytest.raises(ModelError, match="without constraints to identify, but 'arm' has gear"):
        fb.identify(s, q, u, udot, tau)
