"""Problems 6.4 to 6.6 and 6.14 to 6.16 against closed forms: bodies on a hinge, and two coupled degrees of freedom."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from chapter_answers import check_formulas, check_numbers, outcome
from freebody import exact
from freebody.describe.description import names_of
from freebody.errors import ModelError
from freebody.gallery import entries


def percussion(p):
    m, L, F = p["m"], p["L"], p["F"]
    h = 2 * L / 3
    return {
        "h": h,
        "alpha": exact.struck_bar(m, L, F, h).alpha,
        "R_x_1": exact.struck_bar(m, L, F, p["h_1"]).reaction,
        "R_x_2": exact.struck_bar(m, L, F, p["h_2"]).reaction,
    }


def test_percussion(changing):
    check_numbers("prob-6-4", percussion, factor=0.95, L=2.5, h_1=0.0, changing=changing)
    assert exact.struck_bar(2, 3, 100, 2).reaction == 0


def test_percussion_formulas():
    check_formulas("prob-6-4", percussion)


def test_percussion_refuses_a_miss():
    with pytest.raises(ModelError, match="a force that strikes the bar, from 0 to L, got h_2 = 1.3"):
        entries()["prob-6-4"].run({"h_2": 1.3})


def door(p):
    frequency = exact.door_frequency(p["b"], p["alpha"], p["g"])
    found = {"omega_n": frequency}
    if not isinstance(frequency, sympy.Basic):
        found["T"] = exact.pendulum_period(p["theta_0"], frequency)
    return found


def test_door(changing):
    check_numbers("prob-6-5", door, idle=("m", "h"), theta_0=3.0, alpha=0.5, changing=changing)


def test_door_formulas():
    check_formulas("prob-6-5", door)
    written = "m*b*(b*theta''/3 + g*sin(alpha)*sin(theta)/2) = 0"
    assert outcome("prob-6-5").answers["equation"].value == written


@pytest.mark.parametrize("name", ["alpha", "theta_0"])
def test_door_refuses_an_upright_line_and_no_swing(name):
    with pytest.raises(ModelError, match=f"got {name} = 0"):
        entries()["prob-6-5"].run({name: 0})


def disk_pendulum(p):
    d = exact.disk_pendulum(p["m"], p["L"], p["R"], p["g"], p["theta_0"], p["theta_1"])
    keys = ("theta'", "theta''", "R_x", "R_y", "R_n", "R_t", "omega_n")
    return dict(zip(keys, d, strict=True))


def test_disk_pendulum(changing):
    check_numbers("prob-6-6", disk_pendulum, R=0.9, theta_0=2.5, theta_1=-0.7, changing=changing)


def test_disk_pendulum_formulas():
    check_formulas("prob-6-6", disk_pendulum)


def test_disk_pendulum_refuses_an_angle_it_does_not_pass():
    with pytest.raises(ModelError, match="between -theta_0 and theta_0, which the rod passes"):
        entries()["prob-6-6"].run({"theta_1": 2.0})


def airfoil(p):
    stiff = [p[name] for name in ("m", "I_E", "s", "k_x", "k_theta")]
    found = exact.airfoil(*stiff)
    answers = {f"omega_{k}": w for k, w in enumerate(found.frequencies, 1)}
    answers |= {f"ratio_{k}": r for k, r in enumerate(found.ratios, 1)}
    if not isinstance(found.ratios[0], sympy.Basic):
        x, theta = exact.airfoil_motion(*stiff, p["x_0"], p["theta_0"], p["t_1"])
        answers |= {"x(t_1)": x, "theta(t_1)": theta}
    return answers


def test_airfoil(changing):
    check_numbers("prob-6-14", airfoil, s=-0.2, x_0=-0.02, theta_0=0.1, t_1=3.0, changing=changing)


def test_airfoil_formulas():
    check_formulas("prob-6-14", airfoil)
    answers = outcome("prob-6-14").answers
    assert answers["equation_x"].value == "m*x'' + m*s*theta'' + k_x*x = 0"
    assert answers["equation_theta"].value == "m*s*x'' + I_E*theta'' + k_theta*theta = 0"


def test_an_airfoil_with_its_mass_centre_on_the_axis_has_two_motions_apart():
    answers = entries()["prob-6-14"].run({"s": 0, "theta_0": 0.02}).answers
    pitch, plunge = (200 / 0.9) ** 0.5, (4000 / 10) ** 0.5
    assert answers["omega_1"].value == pytest.approx(pitch, rel=1e-14)
    assert answers["omega_2"].value == pytest.approx(plunge, rel=1e-14)
    assert answers["ratio_1"].value == 0 and answers["ratio_2"].value == "none: theta stays zero"
    assert answers["x(t_1)"].value == pytest.approx(0.01 * math.cos(plunge), rel=1e-9)
    assert answers["theta(t_1)"].value == pytest.approx(0.02 * math.cos(pitch), rel=1e-9)


def test_airfoil_refuses_too_little_inertia():
    with pytest.raises(
        ModelError, match=r"Expected I_E - m\*s\^2 > 0 in 'airfoil'.*I_E = 0.1, m = 10, s = 0.1"
    ):
        entries()["prob-6-14"].run({"I_E": 0.1})


def double_pendulum(p):
    values = {name: p[name] for name in ("m1", "m2", "L1", "L2", "g")}
    if any(isinstance(x, sympy.Basic) for x in values.values()):
        m1, m2, L1, L2, g = values.values()
        A, B, D = (m1 / 3 + m2) * L1**2, m2 * L1 * L2 / 2, m2 * L2**2 / 3
        k1, k2 = (m1 / 2 + m2) * g * L1, m2 * g * L2 / 2
        middle, lead = A * k2 + D * k1, A * D - B**2
        root = sympy.sqrt(sympy.expand(middle**2 - 4 * lead * k1 * k2))
        return {
            "omega_1": sympy.sqrt((middle - root) / (2 * lead)),
            "omega_2": sympy.sqrt((middle + root) / (2 * lead)),
        }

    def rates(_, y):
        return [y[2], y[3], *exact.double_pendulum(*y, **values).accelerations]

    expected = {}
    for label in ("t_1", "t_2"):
        start = [p["theta_10"], p["theta_20"], 0, 0]
        solution = solve_ivp(rates, (0, p[label]), start, "DOP853", rtol=1e-12, atol=1e-13)
        y = solution.y[:, -1]
        forces = exact.double_pendulum(*y, **values)
        names = ("theta_1", "theta_2", "theta_1'", "theta_2'")
        expected |= {f"{name}({label})": x for name, x in zip(names, y, strict=True)}
        for joint, force in (("O", forces.support), ("J", forces.joint)):
            expected |= {f"{joint}_{axis}({label})": x for axis, x in zip("xy", force, strict=True)}
    low, high = exact.double_pendulum_frequencies(**values)
    return expected | {"omega_1": low, "omega_2": high}


def test_double_pendulum(changing):
    check_numbers("prob-6-15", double_pendulum, changing=changing)


def test_double_pendulum_formulas():
    check_formulas("prob-6-15", double_pendulum)


def two_links(p):
    values = [p[name] for name in ("m", "L", "M", "k_1", "k_2", "g")]
    m, L, _, k_1, k_2, g = values

    def rates(_, y):
        return [y[2], y[3], *exact.folding_links(y[0], y[1], y[3], *values)]

    expected = {}
    for label in ("t_1", "t_2"):
        solution = solve_ivp(rates, (0, p[label]), np.zeros(4), "DOP853", rtol=1e-12, atol=1e-13)
        names = ("x", "theta", "x'", "theta'")
        expected |= {f"{name}({label})": x for name, x in zip(names, solution.y[:, -1], strict=True)}
    x, theta = exact.folding_equilibrium(m, L, k_1, k_2, g)
    return expected | {"x_s": x, "theta_s": theta}


def test_two_links(changing):
    check_numbers("prob-6-16", two_links, k_1=50.0, m=3.0, changing=changing)


def test_equations_of_the_two_links():
    """The accelerations of the canonical equations are those written by hand, exactly."""
    found = outcome("prob-6-16").answers
    written = "M*x'' + (k_1 + k_2)*x - 2*L*k_1*(1 - cos(theta)) = 0"
    assert found["equation_x"].value == written
    from freebody import equations
    from freebody.gallery.textbook.problems.prob_6_16_two_links import symmetric

    s = symmetric()
    e = equations(s)
    atoms = dict(names_of(s).atoms)
    x, theta = e.coordinates
    accelerations = [speed.acceleration for speed in e.model.speeds]
    parameters = [atoms[name] for name in ("m", "L", "M", "k_1", "k_2", "g")]
    by_hand = exact.folding_links(x, theta, atoms["theta'"], *parameters)
    for equation in e.motion:
        residual = (equation.lhs - equation.rhs).xreplace(dict(zip(accelerations, by_hand, strict=True)))
        numerator, _ = sympy.fraction(sympy.together(residual))
        assert e.ring.from_sympy(sympy.expand(numerator)) == 0
