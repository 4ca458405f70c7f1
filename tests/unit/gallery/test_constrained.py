"""The constrained systems of the gallery against their closed forms, worked out here by hand."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from freebody.errors import ModelError
from freebody.exact import steady_turn
from freebody.gallery import entries

GALLERY = entries()
MOTION = 1e-9
ALGEBRA = 1e-11


def run(name, changed=None):
    found = GALLERY[name].run(changed or {})
    return found.trajectory.values, {key: answer.value for key, answer in found.answers.items()}, found


@pytest.mark.parametrize("changed", [{}, {"r": 0.1, "L": 0.3, "omega": -20.0, "t_1": 0.05, "m_2": 2.0}])
def test_slider_crank(changed):
    """x = r cos a + sqrt(L² - r² sin² a); torque by virtual power, force on the piston by its momentum."""
    p, answers, _ = run("slider-crank", changed)
    r, L, w, t = p["r"], p["L"], p["omega"], p["t_1"]

    def state(t):
        """Rod's angle and centre, and the piston's place, with two derivatives by exact formulas."""
        a = w * t
        s, c = math.sin(a), math.cos(a)
        sb, sb1, sb2 = -r * s / L, -r * w * c / L, r * w**2 * s / L  # sine of the rod's absolute angle
        cb = math.sqrt(1 - sb**2)
        b1 = sb1 / cb
        b2 = (sb2 + sb * b1**2) / cb
        x = r * c + L * cb
        x1 = -r * w * s - L * sb * b1
        x2 = -r * w**2 * c - L * (cb * b1**2 + sb * b2)
        centre2 = (
            -r * w**2 * c - L / 2 * (cb * b1**2 + sb * b2),
            -r * w**2 * s + L / 2 * (cb * b2 - sb * b1**2),
        )
        centre1 = (-r * w * s - L / 2 * sb * b1, r * w * c + L / 2 * cb * b1)
        return x, x1, x2, b1, b2, centre1, centre2, sb, cb

    x, x1, x2, b1, b2, v, acceleration, sb, cb = state(t)
    assert answers["x(t_1)"] == pytest.approx(x, rel=1e-12)
    assert answers["x'(t_1)"] == pytest.approx(x1, rel=1e-11)
    assert answers["x''(t_1)"] == pytest.approx(x2, rel=1e-10)
    # power of the torque = rate of the kinetic energy; the crank turns uniformly
    m2, m3 = p["m_2"], p["m_3"]
    power = m2 * np.dot(v, acceleration) + m2 * L**2 / 12 * b1 * b2 + m3 * x1 * x2
    assert answers["torque(t_1)"] == pytest.approx(power / w, rel=1e-10)
    kinetic = p["m_1"] * r**2 * w**2 / 6 + m2 * np.dot(v, v) / 2 + m2 * L**2 / 24 * b1**2 + m3 * x1**2 / 2
    assert answers["T(t_1)"] == pytest.approx(kinetic, rel=1e-11)
    force = m3 * x2
    assert answers["F_rod(t_1)"] == pytest.approx(force, rel=1e-10)
    # moments of the rod about its crank pin: the force of the piston on it is (-force, N)
    pin2 = (acceleration[0] * 1.0, acceleration[1] * 1.0)
    turned = m2 * L**2 / 12 * b2 + m2 * L / 2 * (cb * pin2[1] - sb * pin2[0])
    side = (turned - L * sb * force) / (L * cb)
    # the cylinder carries on to the piston what the rod presses against it
    assert answers["F_cylinder(t_1)"] == pytest.approx(side, rel=1e-9)


def rocker(a, b, c, d, angle):
    """Angle of the rocker by the cosine rule, coupler above."""
    B = a * np.exp(1j * angle)
    line = B - d
    f = abs(line)
    inner = math.acos((f**2 + c**2 - b**2) / (2 * f * c))
    return float(np.angle(line)) - inner


def test_four_bar():
    p, answers, found = run("four-bar")
    a, b, c, d, w, t = (p[name] for name in ("a", "b", "c", "d", "omega", "t_1"))
    psi = rocker(a, b, c, d, w * t)
    assert answers["psi(t_1)"] == pytest.approx(psi, rel=1e-12)
    # extremes: crank and coupler in line, by the cosine rule in the triangle of d, c and b ± a
    for name, reach in (("psi_min", b + a), ("psi_max", b - a)):
        angle = math.pi - math.acos((d**2 + c**2 - reach**2) / (2 * d * c))
        assert answers[name] == pytest.approx(angle, abs=MOTION)
    # velocity: the coupler's ends have the same velocity along it
    B, C = a * np.exp(1j * w * t), d + c * np.exp(1j * psi)
    along = (C - B) / b
    rate = ((1j * w * B) * along.conjugate()).real / (1j * (C - d) * along.conjugate()).real
    assert answers["psi'(t_1)"] == pytest.approx(rate, rel=1e-11)
    # torque: power of the drive = rate of kinetic and potential energy, closed forms in forty digits
    rho, g = p["rho"], p["g"]

    def places(s):
        B = a * mpmath.expj(w * s)
        line = B - d
        inner = mpmath.acos((abs(line) ** 2 + c**2 - b**2) / (2 * abs(line) * c))
        return B, d + c * mpmath.expj(mpmath.arg(line) - inner)

    def energy(s):
        B, C = places(s)
        vB, vC = (mpmath.diff(lambda s, end=end: places(s)[end], s) for end in (0, 1))
        # a slender bar: T = m/6 (v1² + v1·v2 + v2²)
        kinetic = rho * b / 6 * (abs(vB) ** 2 + (vB * mpmath.conj(vC)).real + abs(vC) ** 2)
        kinetic += rho * c / 6 * abs(vC) ** 2
        return kinetic + g * rho * (a * B.imag / 2 + b * (B + C).imag / 2 + c * C.imag / 2)

    with mpmath.workdps(40):
        power = float(mpmath.diff(energy, t))
    assert answers["torque(t_1)"] == pytest.approx(power / w, rel=1e-9)
    assert "C_z" in answers["indeterminate"]
    assert found.trajectory.energy.relative_residual < MOTION


@pytest.mark.parametrize("changed", [{}, {"T": -1.0, "r_1": 0.2, "m_1": 9.0, "Q": 0.3, "alpha": 0.4}])
def test_two_gears(changed):
    p, answers, _ = run("two-gears", changed)
    J1, J2 = p["m_1"] * p["r_1"] ** 2 / 2, p["m_2"] * p["r_2"] ** 2 / 2
    n = p["r_1"] / p["r_2"]
    # the load Q acts against the wheel when it turns backwards, as the pinion drives it
    first = (p["T"] - n * p["Q"]) / (J1 + n**2 * J2)
    assert answers["phi_1''"] == pytest.approx(first, rel=ALGEBRA)
    assert answers["phi_2''"] == pytest.approx(-n * first, rel=ALGEBRA)
    force = (p["T"] - J1 * first) / p["r_1"]
    assert answers["force"] == pytest.approx(force, rel=ALGEBRA)
    # the teeth push along their line of action, at the pressure angle to the tangent
    assert answers["bearing"] == pytest.approx(abs(force) / math.cos(p["alpha"]), rel=ALGEBRA)
    assert answers["phi_1(t_1)"] == pytest.approx(first * p["t_1"] ** 2 / 2, rel=ALGEBRA)


@pytest.mark.parametrize("changed", [{"T": -1.0, "r_1": 0.2, "m_1": 9.0, "Q": 0.3, "alpha": 0.4}])
def test_bevel_gears(changed):
    p, answers, _ = run("bevel-gears", changed)
    n = p["r_1"] / p["r_2"]
    J1, J2 = p["m_1"] * p["r_1"] ** 2 / 2, p["m_2"] * p["r_2"] ** 2 / 2
    first = (p["T"] - n * p["Q"]) / (J1 + n**2 * J2)
    assert answers["phi_1''"] == pytest.approx(first, rel=ALGEBRA)
    assert answers["phi_2''"] == pytest.approx(-n * first, rel=ALGEBRA)
    force = (p["T"] - J1 * first) / p["r_1"]
    assert answers["mesh"] == pytest.approx(-force * p["r_1"], rel=ALGEBRA)
    gamma, apart = math.atan(n), abs(force) * math.tan(p["alpha"])
    assert answers["thrust"] == pytest.approx(apart * math.sin(gamma), rel=ALGEBRA)
    assert answers["apart"] == pytest.approx(apart * math.cos(gamma), rel=ALGEBRA)
    assert answers["around"] == pytest.approx(force, rel=ALGEBRA)


@pytest.mark.parametrize("changed", [{"T": 2.0, "r": 0.05, "l": 0.1, "Q": 200.0, "alpha": 0.4}])
def test_worm_gear(changed):
    p, answers, _ = run("worm-gear", changed)
    J1, J2, n = p["m_1"] * p["r"] ** 2 / 2, p["m_2"] * p["R"] ** 2 / 2, p["l"] / (2 * math.pi * p["R"])
    first = (p["T"] - n * p["Q"]) / (J1 + n**2 * J2)
    assert answers["phi''"] == pytest.approx(first, rel=ALGEBRA)
    assert answers["theta''"] == pytest.approx(-n * first, rel=ALGEBRA)
    around = (p["T"] - J1 * first) / p["r"]
    along = (p["Q"] + J2 * n * first) / p["R"]  # by the moments of the wheel
    assert answers["around"] == pytest.approx(around, rel=ALGEBRA)
    assert answers["thrust"] == pytest.approx(along, rel=ALGEBRA)
    assert answers["apart"] == pytest.approx(math.hypot(around, along) * math.tan(p["alpha"]), rel=ALGEBRA)


@pytest.mark.parametrize("changed", [{"T": 2.0, "r_p": 0.1, "m_p": 4.0, "Q": -5.0, "t_1": 0.1}])
def test_planetary_gear(changed):
    """Newton and Euler for the carrier, the planet about its own centre, and the sun."""
    p, answers, _ = run("planetary-gear", changed)
    s, r, arm = p["r_s"], p["r_p"], p["r_s"] + p["r_p"]
    i = 2 * arm / s
    assert answers["ratio"] == pytest.approx(i, rel=ALGEBRA)
    # unknown: carrier's acceleration a, tangential forces F of the sun and R of the ring on the planet
    rows = [
        [p["m_s"] * s**2 / 2 * i, s, 0],  # J_s i a = T - s F
        [p["m_p"] * arm + p["m_c"] * arm / 2, -1, -1],  # (m_p arm² + m_c arm²/2) a = (F + R) arm - Q
        [p["m_p"] * r / 2 * arm, -r, r],  # J_p arm/r a = (F - R) r
    ]
    a, sun, ring = np.linalg.solve(rows, [p["T"], -p["Q"] / arm, 0])
    assert answers["psi''"] == pytest.approx(a, rel=ALGEBRA)
    assert answers["F_sun"] == pytest.approx(sun, rel=ALGEBRA)
    assert answers["F_ring"] == pytest.approx(ring, rel=ALGEBRA)
    assert answers["psi'(t_1)"] == pytest.approx(a * p["t_1"], rel=MOTION)


def test_turning_car():
    p, answers, found = run("turning-car", {"delta": 1e-4, "t_1": 6.0})
    load = p["m"] * p["g"] / (p["a"] + p["b"])
    axles = (p["a"], p["C_F"] * load * p["b"]), (p["b"], p["C_R"] * load * p["a"])
    exact = steady_turn(p["V"], p["delta"], p["m"], *axles)
    assert answers["r"] == pytest.approx(exact.yaw_rate, rel=ALGEBRA)
    assert answers["v"] == pytest.approx(exact.side_speed, rel=ALGEBRA)
    assert answers["psi'(t_1)"] == pytest.approx(exact.yaw_rate, rel=1e-4)  # slips brake the car
    assert found.trajectory.energy.relative_residual < MOTION


@pytest.mark.parametrize("changed", [{}, {"M": 200.0, "m": 20.0, "t_1": 0.3}])
def test_block_and_tackle(changed):
    found = GALLERY["block-and-tackle"].run(changed, until=0.5)  # before the counterweight is at the beam
    p, answers = found.trajectory.values, {key: answer.value for key, answer in found.answers.items()}
    M, m, g = p["M"], p["m"], p["g"]
    x2 = g * (M - 4 * m) / (M + 16 * m)
    assert answers["x''"] == pytest.approx(x2, rel=ALGEBRA)
    assert answers["y''"] == pytest.approx(-4 * x2, rel=ALGEBRA)
    assert answers["tension"] == pytest.approx(m * (g + 4 * x2), rel=ALGEBRA)
    assert answers["x(t_1)"] == pytest.approx(p["x_0"] + x2 * p["t_1"] ** 2 / 2, rel=ALGEBRA)
    # the beam is one metre long
    assert answers["y(t_1)"] == pytest.approx(p["L"] - 1 - 4 * answers["x(t_1)"], rel=ALGEBRA)


@pytest.mark.parametrize(
    "changed", [{}, {"lean": -0.5, "Omega": 3.0}, {"R": 0.1, "Omega": -2.0, "lean": 1.0}]
)
def test_rolling_disk(changed):
    """Steady turn. e: axle, at the angle lean above the horizontal; s spin, Ω turn, c = cos lean, n = sin lean.

    Along the horizontal h (from the centre to the upper side's foot), ω = Ω Z + s e has components
    ω_h = s c along h, ω_Z = Ω + s n; the centre moves at v = R (s + Ω n); it turns at Ω on a circle of radius v/Ω.
    H along the axle: A_3 = m R²/2 (s + Ω n); across, in the plane of e and Z: A_1 = m R²/4 Ω c. dH/dt = Ω Z × H =
    moment of the normal force m g and of the friction m Ω v about the centre:

        Ω (A_3 c - A_1 n) + m Ω v R c + m g R n = 0.
    """
    p, answers, _ = run("rolling-disk", changed)
    m, R, g, turn = p["m"], p["R"], p["g"], p["Omega"]
    c, n = math.cos(p["lean"]), math.sin(p["lean"])
    # Ω m R² c (s + Ω n) (1/2 + 1) - m R² Ω² c n / 4 + m g R n = 0
    total = (turn**2 * c * n / 4 - g * n / R) / (1.5 * turn * c)
    spin = total - turn * n
    assert answers["spin"] == pytest.approx(spin, rel=1e-9)
    v = R * abs(total)
    assert answers["radius"] == pytest.approx(v / abs(turn), rel=1e-9)
    assert answers["lean(t_1)"] == pytest.approx(p["lean"], abs=MOTION)
    chord = 2 * v / abs(turn) * abs(math.sin(turn * p["t_1"] / 2))
    moved = answers["path(t_1)"]
    assert math.hypot(*moved[:2]) == pytest.approx(chord, rel=1e-9)
    assert moved[2] == pytest.approx(0, abs=MOTION)
    force = answers["force"]
    assert force[2] == pytest.approx(m * g, rel=1e-9)
    assert math.hypot(*force[:2]) == pytest.approx(m * v * abs(turn), rel=1e-9)


@pytest.mark.parametrize("changed", [{"lean": math.pi / 2}, {"Omega": 0.0}])
def test_a_disk_that_lies_flat_or_runs_straight_makes_no_turn(changed):
    with pytest.raises(ModelError, match="Expected a lean between -90 and 90 degrees and a turn, got lean ="):
        GALLERY["rolling-disk"].run(changed)


def test_another_bicycle():
    """The answers follow the parameters; with the contact ahead of the steering axis it falls over at all speeds."""
    _, answers, found = run("whipple-bicycle", {"w": 1.05, "m_B": 80.0})
    low, high = answers["stable"]
    assert 0 < low < high and (low, high) != pytest.approx((4.292382536341, 6.024262015388))
    assert np.array(answers["M"]) == pytest.approx(np.array(answers["M"]).T, rel=1e-12)
    assert found.trajectory.energy.relative_residual < MOTION
    _, back, _ = run("whipple-bicycle", {"c": -0.3})
    assert back["stable"] == "none: unstable at all speeds"
