"""What was assumed positive is asked of the values that are given."""

from __future__ import annotations

import math

import pytest

import freebody as fb
from freebody.errors import ModelError


def oscillator():
    s = fb.System("oscillator")
    m, k, c = s.parameters(m=1, k=2, c=3)
    s.assume(c > k)
    block = s.body("block", fb.particle(m))
    guide = s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.spring("spring", guide, stiffness=c - k)
    return s


ASKED = {
    "simulate": lambda s, values: fb.simulate(s, 1, initial={"x'": 1}, values=values),
    "linearize": lambda s, values: fb.linearize(s, values=values),
    "numeric": lambda s, values: fb.linearize(s).numeric(values),
    "steady motions": lambda s, values: fb.steady_motions(s, values=values).states,
    "where": lambda s, values: fb.linearize(s, where={"c": f"{values['c']}"}, values={}),
    "impulse": lambda s, values: fb.impulse(s, at=s.bodies["block"].origin, impulse=(1, 0, 0), values=values),
}


@pytest.mark.parametrize("how", ASKED)
@pytest.mark.parametrize("c", [1, 2])
def test_values_that_contradict_an_assumption(how, c):
    with pytest.raises(
        ModelError,
        match=rf"Expected c - k > 0 in 'oscillator', as s\.assume or its use says, but "
        rf"c = {c}, k = 2 makes it {c - 2}\. Change the values, or take the assumption back\.",
    ):
        ASKED[how](oscillator(), {"c": c})


ROOT = math.sqrt(2.5 - 2)  # of the stiffness c - k, at m = 1
AGREED = {
    "simulate": lambda motion: (motion["x"][-1], math.sin(ROOT) / ROOT),
    "linearize": lambda linear: (float(linear.natural_frequencies()[0]), ROOT),
    "numeric": lambda linear: (float(linear.natural_frequencies()[0]), ROOT),
    "steady motions": lambda states: ([one.state["x"] for one in states], [0]),
    "where": lambda linear: (float(linear.natural_frequencies()[0]), ROOT),
    "impulse": lambda blow: (float(blow.after["x'"]), 1),
}


@pytest.mark.parametrize("how", ASKED)
def test_values_that_agree(how):
    found, expected = AGREED[how](ASKED[how](oscillator(), {"c": 2.5}))
    assert found == pytest.approx(expected, rel=1e-8)


def test_a_dimension_turned_round():
    s = fb.System("tube")
    outer, inner = s.parameters(outer=2, inner=1)
    s.free("air", s.ground, s.body("tube", fb.tube(1, inner, outer, 1)))
    assert fb.simulate(s, 0.1).t[-1] == 0.1
    with pytest.raises(ModelError, match=r"Body 'tube': Expected -inner \+ outer not to be negative"):
        fb.simulate(s, 0.1, values={"inner": 3})


def test_assumptions_on_the_motion_are_not_asked():
    s = oscillator()
    s.assume(s.expression("x") + 1 > 0)
    # x + 1 > 0 is not so at the start: the motion goes on as one of a unit mass on a spring of c - k = 1
    motion = fb.simulate(s, 0.1, initial={"x": -2})
    assert motion["x"][-1] == pytest.approx(-2 * math.cos(0.1), rel=1e-8)
