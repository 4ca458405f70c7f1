"""Sections 6.8 to 6.10 and Problems 6.17, 6.20, 6.21 against closed forms: bodies that turn about a point."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from chapter_answers import check_formulas, check_numbers, outcome
from freebody import exact
from freebody.errors import ModelError
from freebody.exact.elementary import arctan2, sqrt
from freebody.gallery import entries


def weight(p):
    return p["m"] * p["g"] * p["L"]


def gyroscope_formulas(p):
    I = exact.gyroscope_moments(p["m"], p["R"], p["L"])  # noqa: E741
    fast, slow = exact.steady_precession(*I, weight(p), p["theta_0"], p["Omega_zeta"])
    fast_low, slow_low = exact.steady_precession(*I, weight(p), p["theta_low"], p["Omega_zeta"])
    return {
        "I_xi": I[0],
        "I_zeta": I[1],
        "psi'_fast": fast,
        "psi'_slow": slow,
        "Omega_min": exact.least_spin(*I, weight(p), p["theta_0"]),
        "psi'_fast(theta_low)": fast_low,
        "psi'_slow(theta_low)": slow_low,
        "Omega_sleeping": exact.sleeping_spin(*I, weight(p)),
    }


def gyroscope(p):
    I = exact.gyroscope_moments(p["m"], p["R"], p["L"])  # noqa: E741
    motion = exact.top_from_rest(*I, weight(p), p["theta_0"], p["Omega_zeta"], p["t_1"])
    return gyroscope_formulas(p) | {
        "theta_max": motion.theta_max,
        "period": motion.period,
        "theta(t_1)": motion.theta,
        "psi(t_1)": motion.psi,
        "theta'(t_1)": motion.theta_rate,
        "psi'(t_1)": motion.psi_rate,
    }


def test_gyroscope(changing):
    check_numbers("sec-6-9", gyroscope, theta_0=math.radians(75), Omega_zeta=-250.0, changing=changing)


def test_gyroscope_formulas():
    check_formulas("sec-6-9", gyroscope_formulas)


def cones_formulas(p, I_1, I_3, w_1, w_3, ending=""):
    return {
        f"Omega{ending}": (I_3 - I_1) / I_1 * w_3,
        f"alpha{ending}": arctan2(I_1 * abs(w_1), I_3 * w_3),
        f"beta{ending}": arctan2(abs(w_1), w_3),
        f"precession{ending}": sqrt((I_1 * w_1) ** 2 + (I_3 * w_3) ** 2) / I_1,
    }


def cones(p, I_1, I_3, w_1, w_3, ending=""):
    motion = exact.torque_free_symmetric(I_1, I_3, w_1, w_3, p["t_1"])
    return {
        f"Omega{ending}": motion.rate,
        f"alpha{ending}": motion.alpha,
        f"beta{ending}": motion.beta,
        f"precession{ending}": motion.precession_rate,
        f"omega{ending}(t_1)": motion.omega,
        f"axis{ending}(t_1)": motion.attitude[:, 2],
    }


def torque_free(p, cones=cones):
    flat = cones(p, p["I_1"], p["I_3"], p["w_1"], p["w_3"], "_a")
    slender = cones(p, p["I_1b"], p["I_3b"], p["w_1"], p["w_3"], "_b")
    return flat | slender | {"period_c": 1 / (p["earth_ratio"] * p["earth_spin"])}


def test_torque_free(changing):
    check_numbers("sec-6-8", torque_free, w_1=-0.8, w_3=2.0, changing=changing)


def test_torque_free_formulas():
    check_formulas("sec-6-8", lambda p: torque_free(p, cones_formulas))


def satellite(p, cones=cones):
    w_1 = exact.transverse_spin(p["J"], p["arm"], p["I_1"])
    return {"w_1": w_1, "w_2": 0, "w_3": p["spin"], **cones(p, p["I_1"], p["I_3"], w_1, p["spin"])}


def test_satellite(changing):
    check_numbers("prob-6-17", satellite, changing=changing)


def test_satellite_formulas():
    check_formulas("prob-6-17", lambda p: satellite(p, cones_formulas))


def test_cones_of_flat_slender_and_round_satellites():
    words = {
        moment: entries()["prob-6-17"].run({"I_3": moment}).answers["interpretation"].value
        for moment in (2000.0, 1200.0, 1600.0)
    }
    assert words[2000.0].startswith("flat body") and "inside" in words[2000.0]
    assert words[1200.0].startswith("slender body") and "outside" in words[1200.0]
    assert words[1600.0].startswith("equal moments")
    still = entries()["prob-6-17"].run({"J": 0.0}).answers["interpretation"].value
    assert still.startswith("no wobble")


def oscillation(p, w_xi, w_eta):
    """Linear theory in numbers, and the nonlinear motion by integration of (6.96) written out by hand."""
    I_xi, I_zeta = exact.gyroscope_moments(p["m"], p["R"], p["L"])
    theta0, Omega = p["theta_0"], p["Omega_zeta"]
    found = exact.precession_response(I_xi, I_zeta, weight(p), theta0, Omega, w_xi, w_eta, p["t_1"])
    slow = exact.steady_precession(I_xi, I_zeta, weight(p), theta0, Omega)[1]

    def rates(_, y):
        theta, psi, theta_rate, psi_rate = y
        s, c = math.sin(theta), math.cos(theta)
        theta_2 = (weight(p) * s - psi_rate * s * (I_zeta * Omega - I_xi * psi_rate * c)) / I_xi
        psi_2 = (I_zeta * Omega - 2 * I_xi * psi_rate * c) * theta_rate / (I_xi * s)
        return [theta_rate, psi_rate, theta_2, psi_2]

    start = [theta0, 0.0, w_xi, slow + w_eta / math.sin(theta0)]
    end = solve_ivp(rates, (0, p["t_1"]), start, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return found.frequency, {
        "theta_linear(t_1)": found.theta,
        "psi_linear(t_1)": found.psi,
        "theta(t_1)": end[0],
        "psi(t_1)": end[1],
    }


def oscillation_formulas(p, w_xi, w_eta):
    """The same in symbols, in terms of the rate psi' of the steady precession."""
    I_xi, _ = exact.gyroscope_moments(p["m"], p["R"], p["L"])
    rate = p["psi'"]
    c = weight(p) / (I_xi * rate) - rate * sympy.cos(p["theta_0"])
    return exact.small_oscillation(rate, c, p["theta_0"], w_xi, w_eta, p["t_1"])


def nutation(p):
    frequency, motion = oscillation(p, p["w_xi"], p["w_eta"])
    return {"omega_n": frequency, **motion, "error_order": 2}


def struck(p):
    I_xi, _ = exact.gyroscope_moments(p["m"], p["R"], p["L"])
    w_eta = exact.transverse_spin(p["F"], p["reach"] * p["L"], I_xi)
    return {"w_xi": 0, "w_eta": w_eta, **oscillation(p, 0.0, w_eta)[1]}


def test_small_oscillation(changing):
    # the order is measured at finite sizes of the change
    check_numbers("sec-6-10", nutation, {"error_order": 1e-2}, changing=changing)


def test_struck_gyroscope(changing):
    check_numbers("prob-6-21", struck, changing=changing)


def test_small_oscillation_formulas():
    def closed(p):
        found = oscillation_formulas(p, p["w_xi"], p["w_eta"])
        return {"omega_n": found.frequency, "theta_linear(t_1)": found.theta, "psi_linear(t_1)": found.psi}

    check_formulas("sec-6-10", closed)


def test_struck_gyroscope_formulas():
    def closed(p):
        I_xi, _ = exact.gyroscope_moments(p["m"], p["R"], p["L"])
        w_eta = exact.transverse_spin(p["F"], p["reach"] * p["L"], I_xi)
        found = oscillation_formulas(p, sympy.Integer(0), w_eta)
        return {"w_xi": 0, "w_eta": w_eta, "theta_linear(t_1)": found.theta, "psi_linear(t_1)": found.psi}

    check_formulas("prob-6-21", closed)


def test_linear_theory_errs_by_the_second_order():
    """Half the change of the angular velocity, a quarter of the error; within the third order."""
    errors = []
    for part in (1.0, 0.5, 0.25):
        found = outcome("sec-6-10", w_xi=0.1 * part, w_eta=0.16 * part).answers
        errors.append(abs(found["theta_linear(t_1)"].value - found["theta(t_1)"].value))
    slopes = np.diff(np.log2(errors))
    assert slopes == pytest.approx([-2, -2], abs=0.1)


def changed_top(p, w):
    """The exact motion after the change w in the direction gamma."""
    I = exact.gyroscope_moments(p["m"], p["R"], p["L"])  # noqa: E741
    slow = exact.steady_precession(*I, weight(p), p["theta_0"], p["Omega_zeta"])[1]
    w_xi, w_eta = w * math.cos(p["gamma"]), w * math.sin(p["gamma"])
    rate = slow + w_eta / math.sin(p["theta_0"])
    return exact.top(*I, weight(p), p["theta_0"], p["Omega_zeta"], w_xi, rate)


def cusps(p):
    """The circle of changes with cusps: about the rate r, through the axis at rest."""
    I = exact.gyroscope_moments(p["m"], p["R"], p["L"])  # noqa: E741
    slow = exact.steady_precession(*I, weight(p), p["theta_0"], p["Omega_zeta"])[1]
    sine, r = sympy.sin(p["theta_0"]), weight(p) / (I[1] * p["Omega_zeta"])
    if not isinstance(p["m"], float):
        slow = p["psi'"]
    off = sine * (slow - r)
    w = -off * sympy.sin(p["gamma"]) + sqrt((r * sine) ** 2 - (off * sympy.cos(p["gamma"])) ** 2)
    return {"r": r, "w_cusp": w, "w_cusp_linear": slow * sine}


def paths(p):
    I = exact.gyroscope_moments(p["m"], p["R"], p["L"])  # noqa: E741
    found = {"psi'_slow": exact.steady_precession(*I, weight(p), p["theta_0"], p["Omega_zeta"])[1]}
    found |= {key: float(value) for key, value in cusps(p).items()}
    for name, factor in (("loop", p["loop"]), ("cusp", 1.0), ("wave", p["wave"])):
        motion = changed_top(p, factor * found["w_cusp"])
        u, a = math.cos(motion.theta_min), I[1] * p["Omega_zeta"] / I[0]
        w = factor * found["w_cusp"]
        rate = found["psi'_slow"] + w * math.sin(p["gamma"]) / math.sin(p["theta_0"])
        b = rate * math.sin(p["theta_0"]) ** 2 + a * math.cos(p["theta_0"])
        found |= {f"theta_top_{name}": motion.theta_min, f"psi'_top_{name}": (b - a * u) / (1 - u * u)}
    return found


def test_paths_of_the_axis(changing):
    check_numbers("precession-paths", paths, Omega_zeta=-200.0, theta_0=2.0, changing=changing)
    check_formulas("precession-paths", cusps, "r", "w_cusp", "w_cusp_linear")


@pytest.mark.parametrize(
    "changed", [{}, {"gamma": -1.2, "Omega_zeta": 300.0}, {"theta_0": 2.2, "loop": 0.8, "wave": 1.2}]
)
def test_classes_of_paths(changed):
    """Loop, cusp and wave by the integrals are those of the roots of the cubic."""
    found = outcome("precession-paths", **changed)
    p, w = found.values, found.answers["w_cusp"].value
    for name in ("loop", "wave"):
        assert found.answers[f"path_{name}"].value == changed_top(p, p[name] * w).path
    assert found.answers["path_cusp"].value == "cusp"
    near = [changed_top(p, w * (1 + 1e-9 * side)).path for side in (-1, 1)]
    assert near == ["wave", "loop"]


def test_no_cusp_before_the_vertical():
    with pytest.raises(
        ModelError, match="Expected a change .* comes to a stop, .* passes the vertical first"
    ):
        entries()["precession-paths"].run({"Omega_zeta": 91.2})


def test_class_of_the_path_after_a_small_change():
    for w_eta, expected in ((0.08, "wave"), (-1.7, "loop")):
        found = outcome("sec-6-10", w_xi=0.05, w_eta=w_eta)
        assert found.answers["path"].value == expected
        assert all(check.holds for check in found.checks)


def test_too_slow_for_a_steady_precession():
    with pytest.raises(
        ModelError, match="Expected a spin with a steady precession at theta_0 = 1.0472 rad, got Omega_zeta"
    ):
        entries()["sec-6-10"].run({"Omega_zeta": 40.0})


def projectile(p):
    I = p["I_T"], p["I_S"]  # noqa: E741
    turn = p["D"] * p["h"]
    fast, slow = exact.steady_precession(*I, turn, p["alpha"], p["Omega"])
    return {
        "Omega_min": exact.least_spin(*I, turn, p["alpha"]),
        "Omega_limit": exact.sleeping_spin(*I, turn),
        "omega_fast": fast,
        "omega_slow": slow,
    }


def test_projectile(changing):
    check_numbers("prob-6-20", projectile, changing=changing)
    check_formulas("prob-6-20", projectile)


def test_projectile_without_enough_spin():
    answers = entries()["projectile"].run({"Omega": 1500.0}).answers
    assert answers["omega_fast"].value == answers["omega_slow"].value == "none: spin too small"
    for alpha in (2.0, -0.1):
        with pytest.raises(
            ModelError, match=f"Expected an angle from 0 to below pi/2.*got alpha = {alpha:g}"
        ):
            entries()["projectile"].run({"alpha": alpha})


def test_a_projectile_that_flies_along_its_axis():
    """The rates are those of small wobbles; pushed by v aside it nutates to 2 v / (fast - slow)."""
    found = entries()["projectile"].run({"alpha": 0})
    answers = found.answers
    a, b, c = 3e-4, 4.5e-5 * 2500, 150 * 0.03
    root = math.sqrt(b**2 - 4 * a * c)
    assert answers["omega_fast"].value == pytest.approx((b + root) / (2 * a), rel=1e-13)
    assert answers["omega_slow"].value == pytest.approx((b - root) / (2 * a), rel=1e-13)
    assert answers["Omega_min"].value == answers["Omega_limit"].value
    motion = found.trajectory
    tilt = np.hypot(motion["alpha_x"], motion["alpha_y"]).max()
    assert tilt == pytest.approx(2 * 2.5 * a / root, rel=1e-3)
