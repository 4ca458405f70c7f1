"""What the gallery shows beyond the chapter, against closed forms: rotors and spacecraft."""

from __future__ import annotations

import numpy as np
import pytest
import sympy
from scipy.integrate import quad, solve_ivp

from chapter_answers import check_formulas, check_numbers, outcome
from freebody import exact
from freebody.errors import ModelError
from freebody.gallery import entries


def symbols(p):
    return any(isinstance(x, sympy.Basic) for x in p.values())


def gyrocompass(p):
    sin_cos = sympy if symbols(p) else np
    w = p["Omega"] * sin_cos.cos(p["latitude"])
    M, H, c, I_T = p["I_T"] + p["I_R"], p["I_S"] * p["spin"], p["c"], p["I_T"]
    stiff = H * w - I_T * w**2
    rate = sin_cos.sqrt(stiff / M)
    found = {"omega_n": rate, "T": 2 * sin_cos.pi / rate, "zeta": c / (2 * sin_cos.sqrt(stiff * M))}
    if symbols(p):
        return found

    def rates(_, y):
        return [y[1], exact.gyrocompass(*y, M=M, c=c, H=H, I_T=I_T, horizontal=w)]

    run = solve_ivp(rates, (0, p["t_1"]), [p["theta_0"], 0], "DOP853", rtol=1e-12, atol=1e-13)
    south = H * w + I_T * w**2
    return found | {
        "sigma": (-c + np.sqrt(c**2 + 4 * M * south)) / (2 * M),
        "theta(t_1)": run.y[0, -1],
    }


def test_gyrocompass(changing):
    check_numbers("gyrocompass", gyrocompass, Omega=0.5, spin=40.0, c=1e-3, latitude=-0.3, changing=changing)


def test_gyrocompass_formulas():
    check_formulas("gyrocompass", gyrocompass)


def test_gyrocompass_points_nowhere_at_a_pole():
    with pytest.raises(ModelError, match="between the poles"):
        entries()["gyrocompass"].run({"latitude": "90deg"})
    with pytest.raises(ModelError, match="a spin above 0"):
        entries()["gyrocompass"].run({"spin": 0})


def jeffcott(p):
    m, e, k, d, omega = (p[name] for name in ("m", "e", "k", "d", "omega"))
    critical = (sympy if symbols(p) else np).sqrt(k / m)
    whirl = exact.jeffcott(m, e, k, d, omega)
    found = {
        "omega_c": critical,
        "r": whirl.radius,
        "delta": whirl.lag,
        "r_c": exact.jeffcott(m, e, k, d, critical).radius,
        "M_z": whirl.torque,
    }
    if symbols(p):
        return found
    x, y = exact.jeffcott_start(m, e, k, d, omega, p["t_1"])
    return found | {"x(t_1)": x, "y(t_1)": y}


def test_jeffcott_rotor(changing):
    check_numbers("jeffcott-rotor", jeffcott, idle=("R",), omega=150.0, d=10.0, e=0.01, changing=changing)


def test_jeffcott_start_is_small_and_still_right():
    """The deflections are a fraction of a millimetre: relative to their size."""
    found = outcome("jeffcott-rotor")
    expected = jeffcott(found.values)
    for key in ("x(t_1)", "y(t_1)"):
        np.testing.assert_allclose(found.answers[key].value, expected[key], rtol=1e-9)


def test_jeffcott_formulas():
    check_formulas("jeffcott-rotor", jeffcott)


def reaction_wheel(p):
    pi = sympy.pi if symbols(p) else np.pi
    turn = exact.wheel_turn(p["I_B"], p["I_W"], p["T"], p["tau"], pi)
    return dict(zip(("alpha", "theta'_max", "phi'_max", "W"), turn, strict=True))


def test_reaction_wheel(changing):
    check_numbers("reaction-wheel", reaction_wheel, I_W=3.0, tau=20.0, changing=changing)


def test_reaction_wheel_formulas():
    check_formulas("reaction-wheel", reaction_wheel)


def control_moment_gyro(p):
    inertia = [p[name] for name in ("I_P", "I_S", "I_T", "Omega", "nu")]
    turn = exact.platform_turn(*inertia, p["delta_1"])
    found = {
        "alpha_0": turn.start,
        "M_0": p["I_P"] * turn.start,
        "theta'(delta_1)": turn.rate,
        "M_x(delta_1)": turn.motor,
    }
    if symbols(p):
        return found
    turned = quad(lambda d: exact.platform_turn(*inertia, d).rate / p["nu"], 0, p["delta_1"], epsabs=1e-13)[0]
    return found | {"theta(delta_1)": turned}


def test_control_moment_gyro(changing):
    check_numbers(
        "control-moment-gyro", control_moment_gyro, I_P=0.2, delta_1=2.0, Omega=-30.0, changing=changing
    )


def test_control_moment_gyro_formulas():
    check_formulas("control-moment-gyro", control_moment_gyro)


def yo_yo(p):
    despin = exact.yo_yo(p["I"], p["R"], p["m"], p["omega_0"], p["l_1"])
    keys = ("l", "t(l_1)", "omega(l_1)", "F(l_1)")
    return {"phi'": p["omega_0"], **dict(zip(keys, despin, strict=True))}


def test_yo_yo(changing):
    check_numbers("yo-yo", yo_yo, l_1=9.0, I=20.0, m=2.0, changing=changing)


def test_yo_yo_formulas():
    check_formulas("yo-yo", yo_yo)


def test_yo_yo_takes_the_whole_spin():
    """With cords of the length that it names, the satellite stands still when they are off."""
    length = outcome("yo-yo").answers["l"].value
    assert abs(outcome("yo-yo", l_1=length).answers["omega(l_1)"].value) < 1e-12


def test_yo_yo_refuses_a_cord_that_hardly_comes_off():
    with pytest.raises(ModelError, match="a cord longer than 0.05 R"):
        entries()["yo-yo"].run({"l_1": 0.01})


def falling_cat(p):
    pi = sympy.pi if symbols(p) else np.pi
    found = {
        "psi": exact.cat_turn(p["J"], p["K"], p["alpha"], pi),
        "alpha_pi": exact.cat_bend(p["J"], p["K"]),
    }
    return found if symbols(p) else found | {"h": p["g"] * p["tau"] ** 2 / 2}


def test_falling_cat(changing):
    check_numbers("falling-cat", falling_cat, alpha=1.0, K=0.02, changing=changing)


def test_falling_cat_formulas():
    check_formulas("falling-cat", falling_cat)
    # halves as round as long: 60 degrees
    assert abs(outcome("falling-cat", K=0.015).answers["alpha_pi"].value - np.pi / 3) < 1e-14


def test_cat_that_does_not_bend_turns_back_by_what_it_rolled():
    assert abs(exact.cat_turn(0.015, 0.05, 0.0) - 2 * np.pi) < 1e-15
    with pytest.raises(ModelError, match="0 <= alpha < 90 degrees"):
        entries()["falling-cat"].run({"alpha": "90deg"})


def sink_growth(p, moments):
    """Largest real part of the wobble about spin along the last of three axes: four linear equations."""
    I_1, I_2, I_3 = moments
    I_D, c, spin = p["I_D"], p["c"], p["omega_0"]
    A = np.array(
        [
            [-c / I_1, (I_2 - I_3) * spin / I_1, c / I_1, 0],
            [(I_3 - I_1) * spin / I_2, -c / I_2, 0, c / I_2],
            [c / I_D, -spin, -c / I_D, spin],
            [spin, c / I_D, -spin, -c / I_D],
        ]
    )
    return np.linalg.eigvals(A).real.max()


def energy_sink(p):
    sin_cos = sympy if symbols(p) else np
    I_1, I_2, I_3, I_D = (p[name] for name in ("I_1", "I_2", "I_3", "I_D"))
    H_1, H_3 = (I_1 + I_D) * p["w_1"], (I_3 + I_D) * p["omega_0"]
    found = {
        "omega_f": sin_cos.sqrt(H_1**2 + H_3**2) / (I_2 + I_D),
        "T_0": (H_1**2 / (I_1 + I_D) + H_3**2 / (I_3 + I_D)) / 2,
        "T_f": (H_1**2 + H_3**2) / (I_2 + I_D) / 2,
    }
    if symbols(p):
        return found
    found |= {
        "sigma_3": sink_growth(p, (I_1, I_2, I_3)),
        "sigma_2": sink_growth(p, (I_3, I_1, I_2)),
    }

    def rates(_, y):
        return np.concatenate(exact.sink_rates(y[:3], y[3:], I_1, I_2, I_3, I_D, p["c"]))

    w = [p["w_1"], 0, p["omega_0"]]
    y = solve_ivp(rates, (0, p["t_1"]), [*w, *w], "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    H = np.array([I_1, I_2, I_3]) * y[:3] + I_D * y[3:]
    found |= {f"C_w{axis}(t_1)": x for axis, x in zip("xyz", y[:3], strict=True)}
    return found | {"nutation(t_1)": np.arctan2(np.hypot(H[0], H[1]), H[2])}


def test_energy_sink(changing):
    check_numbers("energy-sink", energy_sink, w_1=0.2, t_1=60.0, I_1=70.0, changing=changing)


def test_energy_sink_formulas():
    check_formulas("energy-sink", energy_sink)


def test_major_axis_rule():
    """Spin about the smallest moment of inertia is lost, that about the largest is kept; no damper, no loss."""
    answers = outcome("energy-sink").answers
    assert answers["sigma_3"].value > 0 > answers["sigma_2"].value
    assert answers["T_f"].value < answers["T_0"].value
    with pytest.raises(ModelError, match="a drag above 0"):
        entries()["energy-sink"].run({"c": 0})
    with pytest.raises(ModelError, match="axis 2 is the one of flat spin, got I_1 = 120"):
        entries()["energy-sink"].run({"I_1": 120})


def sleeping_top(p):
    m, R, L, g, c = (p[name] for name in ("m", "R", "L", "g", "c"))
    I_1, I_3, mgL = m * R**2 / 4 + m * L**2, m * R**2 / 2, m * g * L
    critical = exact.sleeping_spin(I_1, I_3, mgL)
    if symbols(p):
        return {"Omega_c": critical}

    def rates(_, y):
        """Angular momentum H about O and direction a of the axis in ground axes, which do not spin with the top."""
        hx, hy, hz, ax, ay, az = y
        loss = c * (hx * ax + hy * ay + hz * az) / I_3
        return [
            -mgL * ay - loss * ax,
            mgL * ax - loss * ay,
            -loss * az,
            (hy * az - hz * ay) / I_1,
            (hz * ax - hx * az) / I_1,
            (hx * ay - hy * ax) / I_1,
        ]

    def fallen(_, y):
        return y[5] - np.cos(p["theta_1"])

    fallen.terminal = True
    axis = np.array([0, -np.sin(p["theta_0"]), np.cos(p["theta_0"])])
    start = [*(I_3 * p["Omega_0"] * axis), *axis]
    precise = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}
    run = solve_ivp(rates, (0, 100), start, events=fallen, **precise)
    at = solve_ivp(rates, (0, p["t_1"]), start, **precise).y[3:, -1]
    end = run.y_events[0][0]
    return {
        "Omega_c": critical,
        "t_c": I_3 / c * np.log(p["Omega_0"] / critical),
        "theta(t_1)": np.arctan2(np.hypot(at[0], at[1]), at[2]),
        "t_f": run.t_events[0][0],
        "Omega_f": end[:3] @ end[3:] / I_3,
    }


def test_sleeping_top(changing):
    check_numbers("sleeping-top", sleeping_top, factor=0.95, c=1e-4, theta_0=0.1, t_1=1.0, changing=changing)


def test_sleeping_top_formulas():
    check_formulas("sleeping-top", sleeping_top, "Omega_c")


def test_sleeping_top_that_does_not_sleep():
    with pytest.raises(ModelError, match="above 79.7891 rad/s, at which it sleeps, got Omega_0 = 70"):
        entries()["sleeping-top"].run({"Omega_0": 70})
    with pytest.raises(ModelError, match="without it the top sleeps for ever"):
        entries()["sleeping-top"].run({"c": 0})


def monorail(p):
    names = ("m_C", "h", "I_C", "m_R", "a", "I_S", "I_T", "h_G")
    values = {name: p[name] for name in (*names, "g")}
    found = {"Omega_c": exact.monorail_speed(**values)}
    if symbols(p):
        return found

    def rates(_, y):
        return [y[2], y[3], *exact.monorail(y, **values, Omega=p["Omega"])]

    y = solve_ivp(rates, (0, p["t_1"]), [p["phi_0"], 0, 0, 0], "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    A = p["I_C"] + p["m_C"] * p["h"] ** 2 + p["I_T"] + p["m_R"] * (p["h_G"] + p["a"]) ** 2
    B, k = p["I_T"] + p["m_R"] * p["a"] ** 2, p["m_R"] * p["g"] * p["a"]
    W, H = p["g"] * (p["m_C"] * p["h"] + p["m_R"] * (p["h_G"] + p["a"])), p["I_S"] * p["Omega"]
    squares = -np.roots([A * B, H**2 - A * k - B * W, W * k])
    low, high = np.sqrt(np.sort(squares))
    return found | {"omega_1": low, "omega_2": high, "phi(t_1)": y[0], "theta(t_1)": y[1]}


def test_monorail(changing):
    check_numbers("gyro-monorail", monorail, Omega=400.0, a=0.1, phi_0=0.1, changing=changing)


def test_monorail_formulas():
    check_formulas("gyro-monorail", monorail)


def test_monorail_falls_with_a_slow_rotor():
    with pytest.raises(ModelError, match="rad/s, which keeps the car up, got Omega = 100"):
        entries()["gyro-monorail"].run({"Omega": 100})


def swing(p):
    m, L, a, Omega, g = (p[name] for name in ("m", "L", "a", "Omega", "g"))

    def length(t):
        """Distance from the pivot and its rate."""
        return L + a * np.sin(Omega * t), a * Omega * np.cos(Omega * t)

    def rates(t, y):
        """Angular momentum: d(m l² theta')/dt = -m g l sin(theta)."""
        r, r_rate = length(t)
        return [y[1], -(2 * r_rate * y[1] + g * np.sin(y[0])) / r]

    def energy(t, y):
        r, r_rate = length(t)
        return m * ((r * y[1]) ** 2 + r_rate**2) / 2 - m * g * r * np.cos(y[0])

    def high(_, y):
        return abs(y[0]) - p["theta_1"]

    high.terminal = True
    start = [p["theta_0"], 0.0]
    precise = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    y = solve_ivp(rates, (0, p["t_1"]), start, **precise).y[:, -1]
    r, stretch = length(p["t_1"])[0], -a * Omega**2 * np.sin(Omega * p["t_1"])
    return {
        "theta(t_1)": y[0],
        "theta'(t_1)": y[1],
        "F(t_1)": m * (r * y[1] ** 2 - stretch + g * np.cos(y[0])),
        "W(t_1)": energy(p["t_1"], y) - energy(0, start),
        "t_f": solve_ivp(rates, (0, 200), start, events=high, **precise).t_events[0][0],
    }


def test_swing(changing):
    check_numbers("pumped-swing", swing, factor=0.98, a=0.3, theta_1=0.8, changing=changing)


def test_equation_of_the_swing():
    assert outcome("pumped-swing").answers["equation"].value == (
        "m*(L + a*sin(Omega*t))*(theta''*(L + a*sin(Omega*t)) + 2*a*Omega*theta'*cos(Omega*t) + g*sin(theta)) = 0"
    )


def test_swing_that_starts_too_high():
    with pytest.raises(ModelError, match="a start above 0 and below theta_1"):
        entries()["pumped-swing"].run({"theta_0": "70deg"})
