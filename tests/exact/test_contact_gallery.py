"""Bouncing ball, rocking block, turntable, tippe top, rattleback, Euler's disk against closed forms and laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy
from scipy.integrate import quad, solve_ivp

from chapter_answers import MOTION, check_formulas, check_numbers, compare, outcome
from freebody import exact
from freebody.errors import ModelError
from freebody.exact.elementary import arctan, cos, sin, sqrt
from freebody.gallery import entries
from freebody.gallery.beyond.rattleback import vertical_spin


def bouncing_ball(p):
    e, h, g, v = (p[name] for name in ("e", "h", "g", "v"))
    first = sqrt(2 * h / g)
    over = first * (1 + e) / (1 - e)
    return {
        "t_1": first, "v_1": g * first, "T": over, "way": h * (1 + e**2) / (1 - e**2), "x_T": v * over,
        "R_over": p["R"], "E_rest": p["m"] * v**2 / 2,
    }  # fmt: skip


def test_bouncing_ball(changing):
    check_numbers("bouncing-ball", bouncing_ball, e=0.5, v=-1.0, changing=changing)
    check_formulas("bouncing-ball", bouncing_ball)
    with pytest.raises(ModelError, match="Expected a coefficient of restitution between 0 and 1, got e = 1"):
        outcome("bouncing-ball", e=1.0)


def swings(p):
    """(time of the first impact, next angle, time of the rest) by quadratures of the energy.

    θ'' = p² sin(θ - α) for θ > 0, p² = 3 g/(4 r), r half of the diagonal, tan α = b/h.
    """
    b, h, g = p["b"], p["h"], p["g"]
    alpha, square = math.atan2(b, h), 1.5 * g / math.hypot(b, h)
    ratio = (2 * h**2 - b**2) / (2 * (b**2 + h**2))

    def fall(angle):
        # θ = angle - u²: 2 u/√(cos(α - angle) - cos(α - θ)), the difference as a product
        def integrand(u):
            drop = 2 * math.sin(alpha - angle + u * u / 2) * math.sin(u * u / 2) / (u * u)
            return 2 / math.sqrt(2 * square * drop)

        return quad(integrand, 0, math.sqrt(angle), epsabs=1e-15, epsrel=1e-13)[0]

    angle, total, first, second = p["theta_0"], 0.0, 0.0, 0.0
    while angle > 1e-7:
        time = fall(angle)
        total += time if not first else 2 * time
        first = first or time
        # 1 - cos and sin of the next angle from ω² = 2 p² (cos(α - θ) - cos α)
        level = ratio**2 * 2 * math.sin(alpha - angle / 2) * math.sin(angle / 2)
        # 2 sin(α - θ/2) sin(θ/2) = level by Newton's method
        angle = level / math.sin(alpha)
        for _ in range(8):
            angle -= (2 * math.sin(alpha - angle / 2) * math.sin(angle / 2) - level) / math.sin(alpha - angle)
        second = second or angle
    # what is left is a geometric series of flights 2 ω/(p² sin α)
    last = math.sqrt(2 * square * math.sin(alpha) * angle)
    return first, second, total + 2 * last / (square * math.sin(alpha)) / (1 - ratio)


def rocking_block(p):
    m, b, h, g, start = (p[name] for name in ("m", "b", "h", "g", "theta_0"))
    d2 = b**2 + h**2
    ratio = (2 * h**2 - b**2) / (2 * d2)
    # m d² ω²/6 = m g (b sin θ_0 - h (1 - cos θ_0))/2
    square = 3 * g * (b * sin(start) - h * (1 - cos(start))) / d2
    expected = {
        "theta_fall": arctan(b / h), "alpha": 3 * g * (b * cos(start) - h * sin(start)) / (2 * d2),
        "omega_1": sqrt(square), "ratio": ratio, "lost": m * d2 * square / 6 * (1 - ratio**2),
    }  # fmt: skip
    if not isinstance(m, sympy.Basic):
        expected["t_1"], expected["theta_1"], expected["t_rest"] = swings(p)
    return expected


def test_rocking_block():
    compare(outcome("rocking-block"), rocking_block)
    compare(outcome("rocking-block", b=0.4, theta_0=0.2, g=5.0), rocking_block)
    compare(outcome("rocking-block", m=2.0, h=0.8), rocking_block)
    check_formulas("rocking-block", rocking_block)
    with pytest.raises(ModelError, match=r"falls back, less than 0\.291457 rad, got theta_0 = 0\.4"):
        outcome("rocking-block", theta_0=0.4)
    with pytest.raises(ModelError, match=r"a block that rocks, of a width less than sqrt\(2\) h, got b = 2"):
        outcome("rocking-block", b=2.0)


def turntable(p):
    rate = 2 * p["Omega"] / 7
    absolute = sympy.Abs if isinstance(rate, sympy.Basic) else abs
    return {
        "rate": rate, "period": 2 * (sympy.pi if absolute is not abs else math.pi) / rate,
        "radius": absolute(p["v_0"] / rate), "x_c": p["x_0"] - p["v_0"] / rate,
        "w_x": (p["Omega"] * p["x_0"] - p["v_0"]) / p["R"], "N": p["m"] * p["g"],
        "mu_needed": absolute(rate * p["v_0"]) / p["g"], "v_max": p["mu"] * p["g"] / absolute(rate),
    }  # fmt: skip


def test_ball_on_a_turntable(changing):
    check_numbers("turntable", turntable, Omega=-2.0, v_0=0.5, changing=changing)
    check_formulas("turntable", turntable)
    assert outcome("turntable").answers["equation_x"].value == "x'' = -2*Omega*y'/7"
    with pytest.raises(
        ModelError, match=r"a velocity at which the ball rolls, up to 3\.4335 m/s, got v_0 = 10"
    ):
        outcome("turntable", v_0=10.0)


def tippe_top(p):
    R, a, start = p["R"], p["a"], p["theta_0"]
    head = p["spin"] * (R * cos(start) - a) / (R + a)
    spent = p["I_3"] * (p["spin"] ** 2 - head**2) / 2 - p["m"] * p["g"] * a * (1 + cos(start))
    return {"spin_head": head, "spent": spent}


def test_tippe_top_rises_and_keeps_jelletts_integral():
    check_formulas("tippe-top", tippe_top)
    found = outcome("tippe-top")
    expected = tippe_top(found.values)
    for key, value in expected.items():
        assert found.answers[key].value == pytest.approx(value, rel=1e-12)
    assert found.answers["rises"].value == "yes"
    # upside down, its spin about its own axis has changed sign
    assert found.trajectory["air_wz"][-1] == pytest.approx(-expected["spin_head"], rel=1e-3)
    ledger = found.trajectory.energy
    # it hops on its way: impacts take some
    assert -ledger.friction[-1] - ledger.impulses[-1] == pytest.approx(expected["spent"], rel=1e-3)
    assert np.all(np.diff(found.trajectory.energy.friction) <= 1e-12)


def test_slow_tippe_top_does_not_rise():
    found = outcome("tippe-top", spin=30.0)
    assert found.answers["rises"].value == "no" and found.answers["t_half"].value == "none: it does not rise"


def cross(a, b):
    """a × b, ten times as fast as numpy's of two vectors."""
    (a_x, a_y, a_z), (b_x, b_y, b_z) = a.tolist(), b.tolist()
    return np.array([a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x])


def sliding_top(p, y):
    """(rates of (v, w, e), N) of a ball on a floor that slides; e its axis, C at a below the middle; in ground axes.

    r = a e - R z,  F = N (z - mu slip/|slip|),  m v' = F - m g z,  I_1 w' + (I_3 - I_1) ((w.e) e)' = r x F, and N from
    z_C = R - a e.z.
    """
    v, w, e = np.split(np.asarray(y), 3)
    z = np.array([0, 0, 1.0])
    r = p["a"] * e - p["R"] * z
    slip = v + cross(w, r)
    slip[2] = 0
    push = z - p["mu"] * slip / np.linalg.norm(slip)
    difference = p["I_3"] - p["I_1"]
    turned = cross(w, e)
    twist = cross(r, push)
    still = -difference * (w @ e) * turned / p["I_1"]
    per_N = (twist - difference * (twist @ e) / p["I_3"] * e) / p["I_1"]
    free = -p["a"] * (cross(still, e) + cross(w, turned)) @ z
    N = (p["g"] + free) / (1 / p["m"] + p["a"] * cross(per_N, e) @ z)
    return [*(N * push / p["m"] - p["g"] * z), *(still + N * per_N), *turned], N


def test_the_hops_of_the_tippe_top_are_its_own():
    """N falls to zero where it does in balances written out by hand: the nutation grows until it lifts the top."""
    found = outcome("tippe-top")
    motion, p = found.trajectory, found.values
    first = next(event for event in motion.events if "N reached 0" in str(event))
    begin = 3.0  # it slides from here on
    R = motion.poses["top"].rotation
    k = int(np.searchsorted(motion.t, begin))
    w, v = (R[k] @ [motion[f"air_{letter}{axis}"][k] for axis in "xyz"] for letter in "wv")
    e = R[k, :, 2]
    start = [*(v - p["a"] * cross(w, e)), *w, *e]  # that of C
    lifts = lambda _, y: sliding_top(p, y)[1]  # noqa: E731
    lifts.terminal = True
    end = solve_ivp(
        lambda _, y: sliding_top(p, y)[0],
        (motion.t[k], 10),
        start,
        "DOP853",
        rtol=1e-11,
        atol=1e-12,
        events=lifts,
    )
    assert end.t[-1] == pytest.approx(first.time, abs=1e-6)


def rolling_stone(p, spin, times):
    """Angular velocity about the vertical of a rolling ellipsoid: its own equations for ω and the vertical γ.

    In body axes, with r from the mass centre to the foot, F the force of the table:  v = -ω × r,  γ' = γ × ω,
    m (v' + ω × v) = F - m g γ,  I ω' + ω × I ω = r × F.
    """
    squares = np.array([p["a"], p["b"], p["c"]]) ** 2
    inertia = np.array([[p["A"], p["D"], 0], [p["D"], p["B"], 0], [0, 0, p["C"]]])

    def rates(_, y):
        w, up = y[:3], y[3:]
        root = math.sqrt(up @ (squares * up))
        r = np.array([0, 0, p["h"]]) - squares * up / root
        turning = cross(up, w)
        r_rate = -squares * turning / root + squares * up * (up @ (squares * turning)) / root**3
        # F = m (-ω' × r - ω × r' - ω × (ω × r) + g γ)
        free = p["m"] * (-cross(w, r_rate) - cross(w, cross(w, r)) + p["g"] * up)
        mass = inertia + p["m"] * (r @ r * np.eye(3) - np.outer(r, r))
        return [*np.linalg.solve(mass, cross(r, free) - cross(w, inertia @ w)), *turning]

    up = np.array([-math.sin(p["lean"]), 0, math.cos(p["lean"])])
    end = solve_ivp(rates, (0, times[-1]), [*(spin * up), *up], "DOP853", times, rtol=1e-12, atol=1e-13).y
    return np.sum(end[:3] * end[3:], axis=0)


def test_rattleback_reverses_one_way_only():
    found = outcome("rattleback")
    answers = found.answers
    assert answers["reverses"].value == "yes" and answers["reverses_back"].value == "no"
    # past the reversal
    motion, stop = entries()["rattleback"].run({"t_1": 3.0}, 3.0, 1e-12).trajectory, answers["t_0"].value
    times = np.union1d(motion.t[::50], stop)
    expected = rolling_stone(found.values, found.values["spin"], times)
    spin, size = vertical_spin(motion)[::50], np.max(np.abs(expected))
    np.testing.assert_allclose(spin, expected[times != stop], rtol=0, atol=MOTION * size)
    assert abs(expected[times == stop]) < MOTION * size


@pytest.mark.slow
def test_the_mirrored_rattleback_and_the_symmetric_one():
    answers = outcome("rattleback").answers
    mirrored = outcome("rattleback", D=2e-5, spin=5.0).answers
    assert mirrored["reverses"].value == "yes"
    assert mirrored["t_0"].value == pytest.approx(answers["t_0"].value, rel=MOTION)
    symmetric = outcome("rattleback", D=0.0).answers
    assert symmetric["reverses"].value == symmetric["reverses_back"].value == "no"


def euler_disk(p):
    turn = exact.euler_disk_turn(p["R"], p["theta_0"], p["g"])
    return {
        "turn": turn,
        "energy": exact.euler_disk_energy(p["m"], p["R"], p["theta_0"], p["g"]),
        "t_end": exact.euler_disk_end(p["m"], p["R"], p["c"], p["theta_0"]),
    }


@pytest.mark.parametrize(("changed", "limit"), [({}, "stick → slip"), ({"mu": 100.0, "c": 1e-6}, "")])
def test_euler_s_disk_ends_where_its_own_balances_do(changed, limit):
    found = outcome("euler-disk", **changed)
    p, answers, motion = found.values, found.answers, found.trajectory
    for key, value in euler_disk(p).items():
        assert answers[key].value == pytest.approx(value, rel=1e-12)
    assert limit in answers["limit"].value

    def rates(_, y):
        return [y[1], *exact.rolling_disk(p["m"], p["R"], p["c"], y, p["g"]).accelerations]

    def grips(_, y):
        one = exact.rolling_disk(p["m"], p["R"], p["c"], y, p["g"])
        return p["mu"] * one.normal - one.friction

    grips.terminal = True
    start = [motion[name][0] for name in ("theta", "theta'", "psi'", "phi'")]
    end = solve_ivp(
        rates,
        (0, answers["t_end"].value),
        start,
        "DOP853",
        rtol=1e-12,
        atol=1e-13,
        events=grips,
        dense_output=True,
    )
    assert end.t[-1] == pytest.approx(answers["t_limit"].value, rel=1e-7)
    times = motion.t[:-1:100]
    for k, name in enumerate(("theta", "theta'", "psi'", "phi'")):
        np.testing.assert_allclose(motion[name][:-1:100], end.sol(times)[k], rtol=1e-7, atol=1e-7)
    # what the centre does besides is of second order in the angle
    assert answers["t_limit"].value < answers["t_end"].value or not limit
    with pytest.raises(ModelError, match="Expected an angle between 0 and 90 degrees, got theta_0 = 0"):
        outcome("euler-disk", theta_0=0.0)
    with pytest.raises(ModelError, match="Expected a damping greater than 0, got c = 0"):
        outcome("euler-disk", c=0.0)
