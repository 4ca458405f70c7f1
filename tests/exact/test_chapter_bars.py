"""Examples 6.2 and 6.5 against closed forms: the hinged bar, and the particle on a spring with a bar."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from chapter_answers import check_formulas, check_numbers, outcome
from freebody import exact


def hinged_bar(p):
    bar = exact.hinged_bar(p["m"], p["L"], p["g"])
    return {  # the closed form counts clockwise
        "alpha": -bar.alpha,
        "R_1": bar.reaction_start,
        "omega_2": -bar.omega_vertical,
        "R_2": bar.reaction_vertical,
        "T_2": bar.energy_vertical,
    }


def test_hinged_bar(changing):
    check_numbers("ex-6-2", hinged_bar, g=3.7, L=0.4, changing=changing)


def test_hinged_bar_formulas():
    check_formulas("ex-6-2", hinged_bar)


def cart_and_bar(p):
    """The equations of motion written out by hand, integrated by another integrator."""
    values = {name: p[name] for name in ("M", "m", "a", "k", "F", "g")}

    def rates(_, y):
        motion = exact.cart_and_bar(*y, **values)
        return [y[2], y[3], motion.x_acceleration, motion.theta_acceleration]

    expected = {}
    for label in ("t_1", "t_2"):
        solution = solve_ivp(rates, (0, p[label]), np.zeros(4), "DOP853", rtol=1e-12, atol=1e-13)
        y = solution.y[:, -1]
        forces = exact.cart_and_bar(*y, **values)
        expected |= {f"{name}({label})": x for name, x in zip(("x", "theta", "x'", "theta'"), y, strict=True)}
        expected |= {f"F_{axis}({label})": x for axis, x in zip("xy", forces.hinge, strict=True)}
        expected[f"f({label})"] = forces.ground
    return expected


def test_cart_and_bar(changing):
    check_numbers("ex-6-5", cart_and_bar, changing=changing)


def test_equations_of_the_cart_and_bar():
    answers = outcome("ex-6-5").answers
    written = "(M + m)*x'' + m*a*(theta''*cos(theta) - theta'^2*sin(theta)) + k*x = F"
    assert answers["equation_x"].value == written
    assert answers["equation_theta"].value.endswith("= 2*a*F*cos(theta)")
