"""Machines that tests of several messages share."""

import pytest

import freebody as fb


@pytest.fixture(scope="module")
def pendulum():
    s = fb.System("pendulum")
    s.parameters(m=1, L=1)
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar("m", "L", axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, "L/2", 0), axis="z", coordinate="a")
    return s


@pytest.fixture(scope="module")
def bar():
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    return s
