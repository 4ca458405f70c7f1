"""Few points of a window that show that it has no zeros."""

import numpy as np
import pytest

import freebody as fb
from freebody.motion.ode import window
from freebody.motion.ode.run import MARGIN


@pytest.mark.parametrize("level", [0, 1])
def test_weights_are_exact_for_polynomials(level):
    parts, rng = window.FEWEST[level], np.random.default_rng(level)
    of_level = slice(5 * level, 5 * level + parts + 1)
    middle, close = (np.array(x[of_level]) for x in (window.IN_THE_MIDDLE, window.CLOSE_TO_THE_END))
    x = np.linspace(0, 1, parts + 1)
    p = np.polynomial.Polynomial(rng.normal(size=parts + 1))
    assert close @ p(x) == pytest.approx(p(MARGIN), rel=1e-13)
    q = np.polynomial.Polynomial(rng.normal(size=parts))  # through all ends but the middle one
    error = np.zeros(parts + 1)
    error[parts // 2] = 0.3
    assert abs(middle @ (q(x) + error)) == pytest.approx(0.3, rel=1e-13)


def test_dips_between_the_ends_of_few_parts_are_found():
    """(q - a)² - d² in one long step: a parabola is known at few points, and is below zero between two of them."""
    s = fb.System("slider")
    s.parameters(a=0.5, d=0.1)
    s.slider("guide", s.ground, s.body("block", fb.particle(1)), axis="x", coordinate="q")
    events = ["(q - a)^2 - d^2"]
    for depth in (0.02, 1e-3, 1e-6):
        for place in np.linspace(0.11, 0.89, 10):
            motion = fb.simulate(
                s,
                1,
                initial={"q": 0, "q'": 1},
                values={"a": place, "d": depth},
                events=events,
                method="dop853",
            )
            assert [e.time for e in motion.events] == pytest.approx([place - depth, place + depth], abs=1e-9)
