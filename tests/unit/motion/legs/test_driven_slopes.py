"""What controllers set has the derivatives of their functions, called with dual numbers."""

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError


def cart(**parameters):
    s = fb.System("cart")
    s.parameters(k=4.0, u=0.0, w=0.0, T=0.1, **parameters)
    body = s.body("cart", fb.particle(2))
    rail = s.slider("rail", s.ground, body, axis="x", coordinate="x")
    s.force("push", rail, "u + w")
    return s


def test_a_gain_as_a_matrix_and_a_sensor():
    """u = -K (x, v) with a sensor v = 2 x' + k x."""
    s = cart(c=0.5)

    def law(t, x):
        return -np.array([x["k"], x["c"]]) @ np.array([x["x"], x["v"]])

    s.controller(law, 0.2, "u", sensors={"v": "2*x' + k*x"})
    motion = fb.simulate(s, 0.3, initial={"x": 1.0, "x'": 0.5}, sensitivities=["k", "c", "x"], samples=2)
    # the first sample gives u = -(k x + c (2 x' + k x)), the second one acts for 0.1 s
    h, u = 0.2, -(4 + 0.5 * (1 + 4))
    x, v = 1 + 0.5 * h + u * h**2 / 4, 0.5 + u * h / 2
    for name, first in (("k", -1.5), ("c", -5.0), ("x", -6.0)):
        of_x, of_v = (name == "x") + first * h**2 / 4, first * h / 2
        given = {"k": -(1.5 * x), "c": -(2 * v + 4 * x), "x": 0.0}[name]
        later = given - 4 * of_x - 0.5 * (2 * of_v + 4 * of_x)
        expected = (of_x + of_v * 0.1 + later * 0.01 / 4, of_v + later * 0.1 / 2)
        found = [motion.sensitivity[quantity, name][-1] for quantity in ("x", "x'")]
        assert found == pytest.approx(expected, rel=1e-9), name


def test_two_controllers_whose_samples_would_move_apart():
    s = cart()
    s.controller(lambda t, x: -x["k"] * x["x"], "T", "u", name="one")
    s.controller(lambda t, x: -x["x'"], 0.3, "w", name="other")
    message = (
        "after t = 0.3 s: a sample of controller '(one|other)' and .* come at the same time, but .* if 'T'"
    )
    with pytest.raises(SimulationError, match=message):
        fb.simulate(s, 1, initial={"x": 1.0}, sensitivities=["T"])
    assert fb.simulate(s, 1, initial={"x": 1.0}, sensitivities=["k"]).sensitivity["x", "k"][-1] < 0


def test_what_a_controller_limits_has_no_part_in_the_motion():
    """|u| stays at its limit."""
    s = cart()
    s.controller(lambda t, x: np.clip(-x["k"] * (x["x"] + 10), -1, 1), "T", "u")
    motion = fb.simulate(s, 1, initial={"x": 1.0}, sensitivities=["k", "x"], samples=2)
    assert motion.sensitivity["x", "k"][-1] == 0 and motion.sensitivity["x", "x"][-1] == 1
    assert motion["x"][-1] == pytest.approx(1 - 1 / 4)
