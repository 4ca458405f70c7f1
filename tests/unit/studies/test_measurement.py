"""Measurements of a fit: what they hold, and whether they tell unknowns apart."""

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError
from freebody.model.assemble import assemble
from freebody.studies.measurement import bounds_of, check_rank, measured_by, weighted, weights_of


def pendulum():
    s = fb.System("pendulum")
    s.hinge("pin", s.ground, s.body("bar", fb.slender_bar(1, 1, axis="x")), coordinate="theta")
    return assemble(s)


def test_numbers_are_weighted_by_their_deviations_where_they_were_measured():
    run = measured_by(pendulum(), {"t": [0, 1, 2], "theta": [1.0, np.nan, 3.0]}, 0.0)
    times, columns = run
    assert times.tolist() == [0, 1, 2] and list(columns) == ["theta"]
    (scales,) = weights_of({"theta": 0.5}, ["theta"], [run])
    (numbers,) = weighted([run], [scales])
    assert numbers.tolist() == [2.0, 6.0]
    (scales,) = weights_of(None, ["theta"], [run])
    assert set(scales["theta"].tolist()) == {1.0}


def test_bounds_are_open_where_none_are_given():
    low, high = bounds_of({"m": (0, np.inf)}, ["m", "k"], np.array([1.0, 2.0]))
    assert low.tolist() == [0, -np.inf] and high.tolist() == [np.inf, np.inf]


def test_what_the_data_do_not_tell_apart_is_said():
    p, names = np.array([2.0, 4.0]), ["m", "k"]
    J = np.array([[1.0, -0.5], [2.0, -1.0], [3.0, -1.5]])  # of k/m: both together change nothing
    with pytest.raises(SimulationError, match=r"'m', 'k' apart: changing m by \+1 %, k by \+1 % together"):
        check_rank(J, p, names, 1.0, False)
    with pytest.raises(SimulationError, match="does not depend on 'k'"):
        check_rank(J * [1, 0], p, names, 1.0, False)
    check_rank(J + np.eye(3, 2), p, names, 1.0, False)
