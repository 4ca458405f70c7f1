"""Systems with contacts against closed forms: Examples 6.1, 6.3, 6.4, Problems 6.1 to 6.3, 6.7 to 6.11."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from chapter_answers import check_formulas, check_numbers, compare, outcome
from freebody import exact
from freebody.describe.description import names_of
from freebody.errors import ModelError
from freebody.exact.contact import sliding_board, tipping_body
from freebody.exact.falling import disk_slips_on_ledge

# -- sliding and tipping ----------------------------------------------------------------------------------------


def sliding_body(p):
    one = exact.sliding_body(*(p[name] for name in ("m", "L", "H", "D", "mu", "beta", "F", "g")))
    return {
        "a_x": one.acceleration,
        "N_A": one.normal_A,
        "N_B": one.normal_B,
        "F_tip": one.force_tip,
        "a_tip": one.acceleration_tip,
        "N_B_tip": one.normal_tip,
    }


def test_sliding_body(changing):
    check_numbers("ex-6-1", sliding_body, F=100.0, beta=-0.2, changing=changing)
    check_formulas("ex-6-1", sliding_body)


def test_sliding_body_that_tips():
    def tips(p):
        a, N = tipping_body(*(p[name] for name in ("m", "L", "H", "D", "mu", "beta", "F", "g")))
        return {**sliding_body(p), "a_x": a, "N_A": 0, "N_B": N}

    found = outcome("ex-6-1", F=400.0)
    compare(found, tips)
    assert "tips" in found.answers["a_x"].question
    assert found.trajectory.modes[0].mode == "open"


def leaning_board(p):
    one = exact.leaning_board(p["mu"], p["beta"], p["g"])
    return {
        "a_slide": one.slide,
        "a_tip": one.tip,
        "a_max": one.largest,
        "beta_max": one.angle,
        "alpha": sliding_board(p["L"], p["mu"], p["beta"], p["a"], p["g"]),
    }


def test_board_on_a_truck():
    check_formulas("prob-6-1", leaning_board, "a_slide", "a_tip", "a_max", "beta_max")
    found = outcome("prob-6-1")
    assert found.answers["state"].value.startswith("slides")
    compare(found, leaning_board)
    for changed in ({"L": 3.0}, {"mu": 0.25}, {"beta": 1.25}, {"g": 9.0}, {"a": 2.9}):
        compare(outcome("prob-6-1", **changed), leaning_board)


def test_board_that_stands_and_board_that_tips():
    stands = outcome("prob-6-1", a=1.0)
    assert stands.answers["state"].value == "stands" and stands.answers["alpha"].value == 0
    # it turns about its lower end: m l²/3 alpha = m l/2 (a sin - g cos)
    tips = outcome("prob-6-1", beta=1.45, a=2.0)
    assert tips.answers["state"].value.startswith("tips")
    assert tips.answers["alpha"].value == pytest.approx(
        1.5 / 2.5 * (2 * math.sin(1.45) - 9.81 * math.cos(1.45)), rel=1e-12
    )


def braking_car(p):
    one = exact.braking_car(*(p[name] for name in ("m", "l_f", "l_r", "h", "a", "g")))
    return {
        "mu": one.mu,
        "N_front": one.normal_front,
        "N_rear": one.normal_rear,
        "N_front_wheel": one.normal_front / 2,
        "N_rear_wheel": one.normal_rear / 2,
        "T_front": one.friction_front,
        "T_rear": one.friction_rear,
        "a_road": p["mu_road"] * p["g"],
        "stop_road": p["v"] ** 2 / (2 * p["mu_road"] * p["g"]),
    }


def test_braking_car(changing):
    check_numbers("prob-6-2", braking_car, a=8.0, h=0.7, changing=changing)
    check_formulas("prob-6-2", braking_car)
    with pytest.raises(ModelError, match="Expected a deceleration at which all wheels stay .* rear axle"):
        outcome("prob-6-2", a=30.0)


def monorail(p):
    one = exact.monorail_car(*(p[name] for name in ("m", "l", "h", "mu", "g")))
    return {
        "a_front": one.front_driven,
        "a_rear": one.rear_driven,
        "N_front": one.normal_front,
        "N_rear": one.normal_rear,
    }


def test_monorail(changing):
    check_numbers("prob-6-3", monorail, mu=0.2, h=0.5, changing=changing)
    check_formulas("prob-6-3", monorail)
    assert outcome("prob-6-3").answers["driven"].value == exact.monorail_car(2000, 4, 1.5, 0.5).better


def test_monorail_with_more_friction_than_can_be_used():
    # N_rear = 0: m g l/2 = m a h
    found = outcome("prob-6-3", mu=1.5).answers
    assert found["a_front"].value == pytest.approx(9.81 * 4 / (2 * 1.5), rel=1e-14)
    assert found["N_rear"].value == 0 and found["N_front"].value == pytest.approx(2000 * 9.81, rel=1e-14)


# -- rolling ----------------------------------------------------------------------------------------------------


def pulled_disk(p, rolls=(None, None)):
    result = {}
    for tail, F, known in (("", p["F"], rolls[0]), ("_2", p["F_2"], rolls[1])):
        one = exact.pulled_disk(*(p[name] for name in ("m", "R", "h", "mu")), F, p["g"], known)
        result |= {f"a{tail}": one.acceleration, f"alpha{tail}": one.alpha, f"H{tail}": one.friction}
        result["F_max"] = one.force_limit
    return result


def test_pulled_disk(changing):
    check_numbers("ex-6-3", pulled_disk, h=0.6, F=200.0, changing=changing)
    compare(outcome("ex-6-3", h=0.1), pulled_disk)
    check_formulas("ex-6-3", lambda p: pulled_disk(p, (True, False)))
    found = outcome("ex-6-3").answers
    assert list(found)[:8] == ["state", "a", "alpha", "H", "state_2", "a_2", "alpha_2", "H_2"]
    assert found["state"].value == "rolls without slip" and found["state_2"].value == "slips"
    assert outcome("ex-6-3", F=250.0).answers["state"].value == "slips"


def test_pulled_disk_that_never_slips():
    found = outcome("ex-6-3", R=0.5, h=0.75).answers
    assert found["F_max"].value == "none: no force makes it slip"
    assert found["state_2"].value == "rolls without slip"


def rolling_down(p):
    one = exact.rolling_down(p["m"], p["R"], p["H"], p["beta"], p["g"])
    steepest = exact.elementary.arctan(3 * p["mu"])
    needed = exact.elementary.sin(p["beta"]) / exact.elementary.cos(p["beta"]) / 3
    return {"v_2": one.speed, "omega_2": one.omega, "a": one.acceleration, "N": one.normal,
            "H_up": one.friction, "beta_max": steepest, "mu_needed": needed}  # fmt: skip


def test_rolling_down(changing):
    check_numbers("ex-6-4", rolling_down, beta=0.3, changing=changing)
    check_formulas("ex-6-4", rolling_down)
    assert outcome("ex-6-4").answers["state"].value == "rolls"
    slips = outcome("ex-6-4", mu=0.1)
    compare(slips, rolling_down)
    assert slips.answers["state"].value == "slips" and slips.trajectory.modes[0].mode == "slip+"


# -- falling ----------------------------------------------------------------------------------------------------


def bar_in_cylinder(p):
    one = exact.bar_in_cylinder(*(p[name] for name in ("m", "R", "theta_0", "theta_1", "g")))
    return {
        "N_A(theta)": one.normal_A, "N_B(theta)": one.normal_B, "theta'": one.rate, "theta''": one.alpha,
        "N_A": one.normal_A, "N_B": one.normal_B, "omega_n": one.frequency,
    }  # fmt: skip


def test_bar_in_cylinder(changing):
    check_numbers("prob-6-7", bar_in_cylinder, theta_0=1.2, theta_1=-0.4, changing=changing)
    check_formulas("prob-6-7", bar_in_cylinder, "theta'", "theta''", "N_A", "N_B", "omega_n")
    answers = outcome("prob-6-7").answers
    assert answers["equation"].value == "theta'' = -3*sqrt(2)*g*sin(theta)/(4*R)"

    def at_any_state(p):
        # (N_A + N_B)/√2 = m g cos θ + m R θ'²/√2, (N_A - N_B)/√2 = m g sin θ/4
        c, s, root = sympy.cos(p["theta"]), sympy.sin(p["theta"]), sympy.sqrt(2)
        total = root * p["m"] * p["g"] * c + p["m"] * p["R"] * p["theta'"] ** 2
        difference = root * p["m"] * p["g"] * s / 4
        return {"N_A(theta)": (total + difference) / 2, "N_B(theta)": (total - difference) / 2}

    check_formulas("prob-6-7", at_any_state, "N_A(theta)", "N_B(theta)")
    with pytest.raises(ModelError, match=r"both ends touch the cylinder, got theta_0 = 1\.4: end B"):
        outcome("prob-6-7", theta_0=1.4)


def slipping_on_the_corner(m, R, mu, g):
    """Angle and angular velocity with which the disk leaves: C stays on the circle about O while it slips.

    R θ'' = g sin θ - μ N/m, N = m g cos θ - m R θ'²;  R φ'' = 2 μ N/m for the turn φ of the disk.
    """
    theta = float(disk_slips_on_ledge(mu))
    rate = math.sqrt(4 * g * (1 - math.cos(theta)) / (3 * R))

    def normal(_, y):
        return g * math.cos(y[0]) - R * y[1] ** 2

    def rates(t, y):
        N = normal(t, y)
        return [y[1], (g * math.sin(y[0]) - mu * N) / R, 2 * mu * N / R]

    normal.terminal, normal.direction = True, -1
    end = solve_ivp(rates, (0, 10), [theta, rate, rate], "DOP853", events=normal, rtol=1e-12, atol=1e-14).y[
        :, -1
    ]
    return end[0], end[2]


def disk_on_ledge(p):
    one = exact.disk_off_ledge(p["m"], p["R"], p["g"])
    expected = {"theta": one.theta, "omega": one.omega, "alpha": one.alpha, "T": one.friction,
                "alpha_after": one.alpha_after, "theta_slip": disk_slips_on_ledge(p["mu"])}  # fmt: skip
    if not isinstance(p["m"], sympy.Basic):
        expected["theta_leave"], expected["omega_leave"] = slipping_on_the_corner(
            p["m"], p["R"], p["mu"], p["g"]
        )
    return expected


def test_disk_on_ledge(changing):
    check_numbers("prob-6-8", disk_on_ledge, mu=0.1, changing=changing)
    check_formulas("prob-6-8", disk_on_ledge)


def sliding_off_the_corner(p):
    """Angle and angular velocity with which the bar leaves: polar coordinates s, θ of its centre about O.

    s'' - s θ'² = g sin θ - μ N/m,   s θ'' + 2 s' θ' = g cos θ - N/m,   m L² θ''/12 = N s.
    """
    L, mu, g = p["L"], p["mu"], p["g"]
    one = exact.bar_on_ledge(p["m"], L, p["b"], mu, g)

    def push(_, y):
        return (g * math.cos(y[0]) - 2 * y[3] * y[1]) / (1 + 12 * y[2] ** 2 / L**2)

    def rates(t, y):
        N = push(t, y)
        return [y[1], 12 * N * y[2] / L**2, y[3], y[2] * y[1] ** 2 + g * math.sin(y[0]) - mu * N]

    push.terminal, push.direction = True, -1
    start = [one.theta, one.omega, L / 2 - p["b"], 0]
    end = solve_ivp(rates, (0, 10), start, "DOP853", events=push, rtol=1e-12, atol=1e-14).y[:, -1]
    return end[0], end[1]


def bar_on_ledge(p):
    one, at_end = (exact.bar_on_ledge(p["m"], p["L"], b, p["mu"], p["g"]) for b in (p["b"], 0 * p["b"]))
    expected = {
        "theta": one.theta,
        "omega": one.omega,
        "N": one.normal,
        "T": one.friction,
        "theta_b0": at_end.theta,
    }
    if not isinstance(p["m"], sympy.Basic):
        expected["theta_leave"], expected["omega_leave"] = sliding_off_the_corner(p)
    return expected


def test_bar_on_ledge(changing):
    check_numbers("prob-6-9", bar_on_ledge, b=0.1, mu=0.8, changing=changing)
    check_formulas("prob-6-9", bar_on_ledge, "theta", "theta_b0")

    def at_any_angle(p):
        d, s, c = p["L"] / 2 - p["b"], -sympy.sin(p["phi"]), sympy.cos(p["phi"])
        k2 = p["L"] ** 2 / 12 + d**2
        weight = p["m"] * p["g"]
        return {"N": weight * c * (1 - d**2 / k2), "T": weight * s * (1 + 2 * d**2 / k2),
                "omega": sympy.sqrt(2 * p["g"] * d * s / k2)}  # fmt: skip

    check_formulas("prob-6-9", at_any_angle, "N", "T")
    found = outcome("prob-6-9")
    difference = (
        found.answers["omega"].formula ** 2 - at_any_angle(names_of(found.system).atoms)["omega"] ** 2
    )
    assert sympy.simplify(difference) == 0
    with pytest.raises(ModelError, match=r"part on the ledge of less than half the length, got b = 0\.7"):
        outcome("prob-6-9", b=0.7)


def disk_in_cylinder(p):
    one = exact.disk_in_cylinder(*(p[name] for name in ("m", "R", "r", "theta_0", "theta_1", "g")))
    return {"omega_n": one.frequency, "theta'": one.rate, "theta''": one.alpha, "N": one.normal,
            "f": one.friction, "period": one.period, "theta_max": exact.elementary.arctan(3 * p["mu"]),
            "mu_needed": exact.elementary.sin(p["theta_0"]) / exact.elementary.cos(p["theta_0"]) / 3}  # fmt: skip


def test_disk_in_cylinder(changing):
    check_numbers("prob-6-10", disk_in_cylinder, theta_0=0.9, theta_1=-0.3, changing=changing)
    check_formulas(
        "prob-6-10", disk_in_cylinder, "theta'", "theta''", "N", "omega_n", "theta_max", "mu_needed"
    )
    found = outcome("prob-6-10").answers
    assert found["f"].text == "m*g*sin(theta_1)/3"
    e = outcome("prob-6-10").equations
    atoms = names_of(outcome("prob-6-10").system).atoms
    alpha = next(speed.acceleration for speed in e.model.speeds if speed.name == "theta'")
    expected = alpha + 2 * atoms["g"] * sympy.sin(atoms["theta"]) / (3 * (atoms["R"] - atoms["r"]))
    assert e.ring.from_sympy(found["equation"].formula.lhs - expected) == 0
    slips = outcome("prob-6-10", mu=0.2)
    compare(slips, disk_in_cylinder)
    assert slips.answers["state"].value == "slips at the release"


def falling_bar(p):
    one = exact.falling_bar(p["m"], p["L"], p["angle"], p["g"])
    expected = {"mu": one.mu, "H": one.friction, "N": one.normal, "omega": one.omega,
                "mu_limit": one.mu_limit, "theta_limit": one.theta_limit}  # fmt: skip
    if not isinstance(p["m"], sympy.Basic):

        def excess(theta):
            s, c = math.sin(theta), math.cos(theta)
            return 3 * abs(s * (3 * c - 2)) - p["mu_floor"] * (1 - 3 * c) ** 2

        backwards = p["mu_floor"] < one.mu_limit
        start, end = (0.02, one.theta_limit) if backwards else (math.acos(2 / 3), math.acos(1 / 3))
        expected["theta_floor"] = brentq(excess, start, end, xtol=1e-15)
    return expected


def test_falling_bar(changing):
    check_numbers("prob-6-11", falling_bar, mu_floor=0.6, angle=1.3, factor=1.1, changing=changing)
    check_formulas("prob-6-11", falling_bar)
    assert outcome("prob-6-11").answers["way"].value.startswith("backwards")
    assert outcome("prob-6-11", mu_floor=0.6, angle=1.3).answers["way"].value.startswith("forwards")
    with pytest.raises(
        ModelError, match=r"Expected an angle from the floor between 0\.958242 and 1\.5708 rad.*0\.8"
    ):
        outcome("prob-6-11", angle=0.8)


def test_a_falling_bar_that_slips_forwards():
    """55 degrees from the vertical: mu = -H/N = 3 sin(theta) (2 - 3 cos(theta)) / (3 cos(theta) - 1)²."""
    theta = math.radians(55)
    answers = outcome("prob-6-11", angle=math.pi / 2 - theta, mu_floor=1.32).answers
    s, c = math.sin(theta), math.cos(theta)
    assert answers["mu"].value == pytest.approx(3 * s * (2 - 3 * c) / (3 * c - 1) ** 2, rel=1e-13)
    assert answers["mu"].value == pytest.approx(1.32, abs=0.005) and answers["H"].value < 0
    assert answers["theta_floor"].value == pytest.approx(theta, abs=1e-3)
    assert answers["way"].value.startswith("forwards")


def test_events_are_sentences_and_modes_a_timeline():
    motion = outcome("prob-6-11").trajectory
    assert str(motion.events[0]) == "t = 1.04426 s: contact floor: stick → slip +, |T| reached 4.40035 N"
    first, *_ = motion.modes.of("floor")
    assert str(first) == "floor: stick from 0 to 1.04426 s (the start)"
    np.testing.assert_allclose(motion.events[0].state["theta"], math.radians(30), rtol=1e-9)
