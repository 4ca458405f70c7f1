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


def test_gyrocompass():
    check_numbers("gyrocompass", gyrocompass, Omega=0.5, spin=40.0, c=1e-3, latitude=-0.3)


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


def test_jeffcott_rotor():
    check_numbers("jeffcott-rotor", jeffcott, idle=("R",), omega=150.0, d=10.0, e=0.01)


def test_jeffcott_start_is_small_and_still_right():
    """The deflections are a fraction of a millimetre: relative to their size."""
    found = outcome("jeffcott-rotor")
    expected = jeffcott(found.values)
    for key in ("x(t_1)", "y(t_1)"):
        np.testing.assert_allclose(found.answers[key].value, expected[key], rtol=1e-6)


def test_jeffcott_formulas():
    check_formulas("jeffcott-rotor", jeffcott)


def reaction_wheel(p):
    pi = sympy.pi if symbols(p) else np.pi
    turn = exact.wheel_turn(p["I_B"], p["I_W"], p["T"], p["tau"], pi)
    return dict(zip(("alpha", "theta'_max", "phi'_max", "W"), turn, strict=True))


def test_reaction_wheel():
    check_numbers("reaction-wheel", reaction_wheel, I_W=3.0, tau=20.0)


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


def test_control_moment_gyro():
    check_numbers("control-moment-gyro", control_moment_gyro, I_P=0.2, delta_1=2.0, Omega=-30.0)


def test_control_moment_gyro_formulas():
    check_formulas("control-moment-gyro", control_moment_gyro)


def yo_yo(p):
    despin = exact.yo_yo(p["I"], p["R"], p["m"], p["omega_0"], p["l_1"])
    keys = ("l", "t(l_1)", "omega(l_1)", "F(l_1)")
    return {"phi'": p["omega_0"], **dict(zip(keys, despin, strict=True))}


def test_yo_yo():
    check_numbers("yo-yo", yo_yo, l_1=9.0, I=20.0, m=2.0)


def test_yo_yo_formulas():
    check_formulas("yo-yo", yo_yo)


def test_yo_yo_takes_the_whole_spin():
    """With cords of the length that it names, the satellite stands still when they are off."""
    length = outcome("yo-yo").answers["l"].value
    assert abs(outcome("yo-yo", l_1=length).answers["omega(l_1)"].value) < 1e-12


def test_yo_yo_refuses_a_cord_that_hardly_comes_off():
    with pytest.raises(ModelError, match="a cord longer than 0.05 R"):
        entries()["yo-yo"].run({"l_1": 0.01})
