"""Residuals of motions beside a measurement, with their derivatives, against a closed form."""

import numpy as np
import pytest

import freebody as fb
from freebody.model.assemble import assemble
from freebody.motion.legs.variation import unknowns_of
from freebody.studies.comparison import Comparison


@pytest.fixture
def fall():
    """A stone falls from z with the speed w: z + w t - g t²/2, weighted by σ = 0.5."""
    s = fb.System("stone")
    s.parameters(g=9.81)
    s.gravity = (0, 0, "-g")
    s.slider("rail", s.ground, s.body("stone", fb.particle(1)), axis="z", coordinate="z")
    times, model = np.array([0.2, 0.1, 0.4]), assemble(s)
    unknowns = unknowns_of(model, ["g", "z'"], {}, "unknown")
    options = {"near": None, "start": 0, "tolerance": 1e-9}
    bounds = np.array([-np.inf, -np.inf]), np.array([np.inf, np.inf])
    measured = [(times, {"z": np.array([1.0, np.nan, 2.0])})]
    weights = [{"z": np.full(3, 0.5)}]
    return Comparison(s, unknowns, measured, weights, [{"z": 3.0}], {}, bounds, options), times[[0, 2]]


def test_residuals_and_derivatives_are_those_of_the_fall(fall):
    comparison, t = fall
    p = np.array([9.0, 0.7])
    residuals, J, (motion,) = comparison.at(p)
    np.testing.assert_allclose(residuals, (3 + 0.7 * t - 4.5 * t**2 - [1, 2]) / 0.5, rtol=1e-9)
    np.testing.assert_allclose(J, np.column_stack([-(t**2) / 2, t]) / 0.5, rtol=1e-8)
    assert motion.t.tolist() == [0.1, 0.2, 0.4]
    assert comparison.at(p).residuals is residuals and comparison.calls == 1


def test_where_there_is_no_motion_residuals_are_huge(fall):
    comparison, _ = fall
    assert comparison.residuals(np.array([np.nan, 0.0]), 2).tolist() == [1e150, 1e150]
