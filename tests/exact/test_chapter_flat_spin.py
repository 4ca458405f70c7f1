"""A satellite with a damped wheel inside, against Euler's equations of the two bodies written out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chapter_answers import check_formulas, check_numbers, outcome
from freebody.errors import ModelError
from freebody.exact.elementary import sqrt
from freebody.gallery import entries


def closed(p):
    """H² is kept, T is least about the largest moment; the wobble with the wheel stuck is that of Euler's equations."""
    A, B, C = p["I_x"] + p["J"], p["I_y"] + p["J_t"], p["I_z"] + p["J_t"]
    n, J, c = p["spin"], p["J"], p["c"]
    H = sqrt((A * p["w_x"]) ** 2 + (C * n) ** 2)
    square = n**2 * (A - C) * (B - C) / (A * B)
    return {
        "H": H,
        "T_0": (A * p["w_x"] ** 2 + C * n**2) / 2,
        "T_min": H**2 / (2 * B),
        "growth_sink": c * C * square / (2 * A * (A - C) * (square + (c / J) ** 2)),
    }


def numbers(p):
    A, B, C = p["I_x"] + p["J"], p["I_y"] + p["J_t"], p["I_z"] + p["J_t"]
    n, J, c = p["spin"], p["J"], p["c"]
    found = closed(p)

    def rates(_, y):
        x, y_, z, d = y
        wx = ((B - C) * y_ * z + c * d) / (A - J)
        return [wx, ((C - A) * x * z - J * d * z) / B, ((A - B) * x * y_ + J * d * y_) / C, -c / J * d - wx]

    def crossing(_, y):
        return C * y[2] - found["H"] / math.sqrt(2)

    motion = solve_ivp(rates, (0, 300), [p["w_x"], 0, n, 0], "DOP853", rtol=1e-12, atol=1e-13, events=crossing,
                       dense_output=True)  # fmt: skip
    at = motion.sol(p["t_1"])
    linear = np.array([
        [0, (B - C) * n / (A - J), 0, c / (A - J)], [(C - A) * n / B, 0, 0, -J * n / B], [0, 0, 0, 0],
        [0, -(B - C) * n / (A - J), 0, -c / J - c / (A - J)],
    ])  # fmt: skip
    roots = np.linalg.eigvals(linear)
    # the wheel turns with respect to the hull
    T = (A * at[0] ** 2 + B * at[1] ** 2 + C * at[2] ** 2 + 2 * J * at[0] * at[3] + J * at[3] ** 2) / 2
    return found | {
        "I": (A, B, C),
        "growth": max(root.real for root in roots if abs(root.imag) > 0.1),
        "t_45": motion.t_events[0][0],
        "T(t_1)": T,
        "omega(t_1)": at[:3],
    }


def test_flat_spin(changing):
    check_numbers("flat-spin", numbers, spin=7.0, J=0.02, changing=changing)


def test_flat_spin_formulas():
    check_formulas("flat-spin", closed)


def test_the_end_is_a_turn_about_the_major_axis():
    for moments, axis in (({}, "y"), ({"I_x": 1.3, "w_x": 0.2}, "x")):
        found = outcome("flat-spin", **moments)
        w = np.array([found.trajectory[f"C_w{a}"][-1] for a in "xyz"])
        assert found.answers["axis"].value == axis
        if axis == "y":  # a wheel that is dragged along takes long to come to rest in the hull
            assert abs(w["xyz".index(axis)]) == pytest.approx(np.linalg.norm(w), rel=1e-6)
        assert all(check.holds for check in found.checks), found.checks


def test_time_to_45_degrees_at_either_sense_of_the_spin():
    other = outcome("flat-spin", spin=-2 * math.pi).answers["t_45"].value
    assert other == pytest.approx(outcome("flat-spin").answers["t_45"].value, rel=1e-9)
    assert outcome("flat-spin", w_x=5.0).answers["t_45"].value == "none: it is further from the start"


def test_energy_sink_is_the_limit_of_a_light_wheel():
    """Its error is of the first order in J/I: half the wheel, half the error."""
    errors = []
    for J in (0.02, 0.01, 0.005):
        answers = outcome("flat-spin", J=J, J_t=J / 2, c=4 * J, t_1=1.0).answers
        errors.append(answers["growth"].value / answers["growth_sink"].value - 1)
    assert np.divide(errors[:-1], errors[1:]) == pytest.approx([2, 2], rel=0.1)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"I_z": 2.0}, "Expected z to be the axis of the smallest moment"),
        ({"w_x": 0.0}, "Expected a start with some wobble"),
        ({"c": 0.0}, "Expected a damping greater than 0"),
        ({"spin": 0.0}, "Expected a spin that is not 0"),
    ],
)
def test_refused(changed, message):
    with pytest.raises(ModelError, match=message):
        entries()["flat-spin"].run(changed)
