"""Drag, motors, gravitation, bushings, cables and springs of any law against closed forms and equations by hand."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import exact
from freebody.dynamics import float_state, forward_dynamics
from freebody.testing import random_inertia, random_state

EPS = np.finfo(float).eps
SLACK = 1e3  # error of a run in units of its tolerance and size


def close(a, b, tolerance):
    a, b = np.asarray(a, float), np.asarray(b, float)
    assert np.abs(a - b).max(initial=0) <= tolerance * max(1, np.abs(b).max(initial=0))


# --- drag --------------------------------------------------------------------------------------


def falling(**drag):
    s = fb.System("falling ball")
    m, g, k = s.parameters(m=2.0, g=9.81, k=0.05)
    s.assume(g > 0, k > 0)
    s.gravity = (0, -g, 0)
    ball = s.body("ball", fb.sphere(m, 0.1))
    s.slider("guide", s.ground, ball, axis="-y", coordinate="y")
    s.drag("air", ball, **{name: k if value is True else value for name, value in drag.items()})
    return s


@pytest.mark.parametrize("kind", ["quadratic", "linear"])
def test_fall_through_a_fluid(kind):
    s = falling(**{kind: True})
    motion = fb.simulate(s, 20, tolerance=1e-11)
    terminal = np.sqrt(2 * 9.81 / 0.05) if kind == "quadratic" else 2 * 9.81 / 0.05
    fall = exact.fall_with_drag if kind == "quadratic" else exact.fall_in_syrup
    speed, distance = fall(terminal, 9.81, motion.t)
    close(motion["y'"], speed, SLACK * 1e-11)
    close(motion["y"], distance, SLACK * 1e-11)
    assert np.abs(motion.energy.residual).max() < 1e-6
    batch = fb.simulate(s, 2, values={"k": [0.05, 0.1]}, tolerance=1e-11)
    last = [float(batch["y'"][i, -1]) for i in range(2)]
    terminals = [terminal, terminal / np.sqrt(2) if kind == "quadratic" else terminal / 2]
    close(last, [fall(v, 9.81, 2).speed for v in terminals], SLACK * 1e-11)


def test_drag_about_the_terminal_speed_and_in_the_wind():
    """m v' = m g - k v|v|: about v_t the slope is -2 k v_t/m; in an upward wind w the ball falls at v_t - w."""
    s = falling(quadratic=True, wind=(0, 4, 0))
    v = np.sqrt(2 * 9.81 / 0.05)
    (acceleration,) = fb.compile(s).forward_dynamics([0.0], [v - 4])
    assert abs(acceleration) < 1e-12
    linear = fb.linearize(s, about={"y": 0, "y'": v - 4}, values={})
    close(linear.C, [[2 * 0.05 * v]], 1e-10)


def test_stokes_moment_and_force_on_a_body_that_spins():
    s = fb.System("sphere in oil")
    ball = s.body("ball", fb.sphere(2, 0.5))
    s.free("j", s.ground, ball)
    s.drag("oil", ball, linear=0.3, turning=0.7)
    udot = fb.compile(s).forward_dynamics([0, 0, 0, 1, 0, 0, 0], [1.0, -2.0, 3.0, 4.0, 5.0, -6.0])
    turn = -0.7 / (2 / 5 * 2 * 0.25) * np.array([1, -2, 3])
    w, v = np.array([1.0, -2, 3]), np.array([4.0, 5, -6])
    close(udot, [*turn, *(-0.15 * v - np.cross(w, v))], 64 * EPS)


# --- motor -------------------------------------------------------------------------------------


def crane(**motor):
    s = fb.System("crane")
    A, T, w, n, J = s.parameters(A=2.0, T=0.5, w=300.0, n=50, J=1e-3)
    arm = s.body("arm", fb.MassProperties(1, (0, 0, 0), [[A, 0, 0], [0, A, 0], [0, 0, A]]))
    pin = s.hinge("pin", s.ground, arm, coordinate="q")
    s.motor("drive", pin, **{"stall_torque": T, "no_load_speed": w, "ratio": n, "inertia": J, **motor})
    return s


def test_start_of_a_motor():
    s = crane()
    motion = fb.simulate(s, 3, tolerance=1e-11)
    start = exact.motor_start(0.5, 300.0, 50, 1e-3, 2.0, motion.t)
    close(motion["q'"], start.rate, SLACK * 1e-11)
    close(motion["q"], start.angle, SLACK * 1e-11)
    kinetic = (2 + 1e-3 * 2500) * start.rate**2 / 2
    close(motion.energy.kinetic, kinetic, SLACK * 1e-10)
    assert fb.simulate(s, 0.1)["q'"][-1] > 0


def test_an_electric_motor_is_the_line_of_its_voltage():
    """T_s = k V/R and ω_0 = V/k; the voltage may be a function of time."""
    V, k, R = 12.0, 0.04, 0.96
    one = crane(stall_torque=k * V / R, no_load_speed=V / k)
    two = crane(stall_torque=None, no_load_speed=None, electric=(V, k, R))
    for q, u in (([0.3], [1.0]), ([1.0], [-20.0])):
        close(fb.compile(one).forward_dynamics(q, u), fb.compile(two).forward_dynamics(q, u), 64 * EPS)
    switched = crane(stall_torque=None, no_load_speed=None, electric=("12*sin(t)", k, R))
    assert "sin(t)" in fb.equations(switched).text()


# --- gravitation -------------------------------------------------------------------------------


def test_an_orbit_is_keplers():
    s = fb.System("orbit")
    mu, m = s.parameters(mu=2.0, m=3.0)
    planet = s.body("planet", fb.particle(m))
    s.planar("plane", s.ground, planet, coordinate=["x", "y", "turn"])
    s.gravitation("sun", planet, parameter=mu)
    a, e = 1.5, 0.6
    near = exact.kepler_orbit(2.0, a, e, 0.0)
    motion = fb.simulate(
        s,
        15,
        initial={"x": float(near.x), "y'": float(near.vy)},
        tolerance=1e-12,
        times=np.linspace(0, 15, 40),
    )
    orbit = exact.kepler_orbit(2.0, a, e, motion.t)
    close(motion["x"], orbit.x, 1e-8)
    close(motion["y"], orbit.y, 1e-8)
    close(motion.energy.total, -2.0 * 3 / (2 * a), 1e-9)  # -μ m/(2 a)


def test_two_bodies_attract_each_other():
    """The mass centre stays, and the distance is an orbit of μ = G (m_1 + m_2)."""
    s = fb.System("pair")
    stars = []
    for name, mass in (("A", 2.0), ("B", 1.0)):
        star = s.body(name, fb.sphere(mass, 0.1))
        s.planar(f"j{name}", s.ground, star, coordinate=[f"x{name}", f"y{name}", f"t{name}"])
        stars.append(star)
    s.gravitation("pull", stars[0], stars[1], parameter=1.0)  # G = 1, mass of B
    near = exact.kepler_orbit(3.0, 1.0, 0.3, 0.0)
    start = {"xA": float(near.x) / 3, "xB": -2 * float(near.x) / 3, "yA'": float(near.vy) / 3}
    motion = fb.simulate(s, 6, initial=start | {"yB'": -2 * float(near.vy) / 3}, tolerance=1e-12)
    orbit = exact.kepler_orbit(3.0, 1.0, 0.3, motion.t)
    close(motion["xA"] - motion["xB"], orbit.x, 1e-8)
    close(2 * motion["xA"] + motion["xB"], 0 * motion.t, 1e-9)


def test_the_gradient_of_gravitation_swings_a_satellite():
    """The frequency of the pitch is Ω √(3 (I_1 - I_3)/I_2), for a rod √3 Ω, to first order in (size/distance)²."""
    for inertia in ((1.0, 1.0, 1e-9), (3.0, 4.0, 2.0)):
        s = fb.System("satellite")
        along, across, vertical = inertia
        # in the plane of x, y: the vertical is body x, the path body y, the normal z
        body = s.body("body", fb.MassProperties(1e4, (0, 0, 0), np.diag([vertical, along, across])))
        arm = s.body("arm", fb.particle(1))
        s.hinge("orbit", s.ground, arm, coordinate=2.0 * s.t)
        s.hinge("pitch", arm, body, at=(100, 0, 0), coordinate="theta")
        s.gravitation("earth", body, parameter=4.0 * 100**3, extended=True)
        linear = fb.linearize(s, about={"theta": 0, "theta'": 0}, values={})
        (frequency,) = linear.natural_frequencies()
        close(float(frequency), exact.libration_frequency(2.0, along, across, vertical), 1e-9)


# --- bushing -----------------------------------------------------------------------------------


def test_a_bushing_is_a_gimbal_with_torsion_springs():
    """Large angles: the same accelerations as three springs on the angles of a gimbal, to round-off."""
    rng = np.random.default_rng(3)
    k, c = (3.0, 5.0, 7.0), (0.3, 0.2, 0.1)
    inertia = random_inertia(rng)
    machines = []
    for with_bushing in (False, True):
        s = fb.System("mount")
        base = s.body("base", fb.box(3, (1, 2, 1)))
        s.hinge("turn", s.ground, base, axis=(0, 0.6, 0.8), coordinate="phi")
        top = s.body("top", fb.MassProperties(2, (0, 0, 0), inertia))
        joint = s.gimbal("g", base, top, at=(0.1, 0.2, 0.3), axis="XYZ", coordinate=["a", "b", "c"])
        if with_bushing:
            s.bushing("rubber", base.point(0.1, 0.2, 0.3), top, turning_stiffness=k, turning_damping=c)
        else:
            for i in range(3):
                s.torsion_spring(f"k{i}", joint, stiffness=k[i], coordinate=i)
                s.damper(f"c{i}", joint, damping=c[i], coordinate=i)
        machines.append(fb.assemble(s))
    for seed in range(4):
        q, u = [x / 2 for x in random_state(machines[0], seed)[0]], random_state(machines[0], seed)[1]
        one, two = (forward_dynamics(m, float_state(m, q, u)) for m in machines)
        close(one, two, 2**14 * EPS)


def test_a_bushing_at_rest_is_its_stiffness():
    s = fb.System("mount")
    block = s.body("block", fb.box(2, (0.3, 0.4, 0.5)))
    s.planar("plane", s.ground, block, coordinate=["x", "y", "turn"])
    s.bushing(
        "rubber", s.ground, block, stiffness=(100, 200, 1), damping=(1, 2, 3), turning_stiffness=(1, 1, 9)
    )
    linear = fb.linearize(s, about={"x": 0, "y": 0, "turn": 0}, values={})
    close(linear.K, np.diag([100, 200, 9]), 1e-12)
    close(linear.C, np.diag([1, 2, 0]), 1e-12)


def test_a_bushing_at_large_angles():
    """By its power along the axes of the gimbal, in the axes of the first body."""
    s = fb.System("mount")
    block = s.body("block", fb.box(2, (0.3, 0.4, 0.5)))
    s.gimbal("turn", s.ground, block, axis="XYZ", coordinate="a b c")
    stiffness, angles = (7.0, 5.0, 3.0), (0.9, -0.6, 1.3)
    s.bushing("rubber", s.ground, block, stiffness=(1, 1, 1), turning_stiffness=stiffness)
    moment = fb.equations(s).free_body("block").moments["rubber"]
    at = dict(zip(map(s.expression, "abc"), angles, strict=True))
    close([float(x.subs(at)) for x in moment], exact.bushing_moment(angles, stiffness), 64 * EPS)


# --- cable, springs of any law -------------------------------------------------------------------


def test_a_jump_on_a_cable():
    """Free fall to the length L, then a half swing about L + m g/k, and the same again: all times in closed form."""
    s = fb.System("bungee")
    m, g, k, L = 70.0, 9.81, 100.0, 20.0
    s.gravity = (0, -g, 0)
    jumper = s.body("jumper", fb.particle(m))
    s.slider("fall", s.ground, jumper, axis="-y", coordinate="y")
    s.cable("rope", s.ground, jumper, stiffness=k, length=L)
    motion = fb.simulate(s, 10, initial={"y": 1.0}, tolerance=1e-11)
    jump = exact.cable_jump(m, k, L - 1, g)
    close([e.time for e in motion.events], [jump.taut, jump.slack, jump.again], 1e-8)
    assert [e.name for e in motion.events] == ["rope becomes taut", "rope becomes slack", "rope becomes taut"]
    assert all(abs(e.state["y"] - L) < 1e-9 for e in motion.events)
    assert abs(motion.energy.residual).max() < 1e-9 * m * g * L * SLACK
    assert "becomes taut" in str(motion.events)
    close(motion["y"].max(), L + jump.stretch, 1e-3)


def test_a_damped_cable_never_pushes():
    s = fb.System("tow")
    boat = s.body("boat", fb.particle(1.0))
    s.slider("x", s.ground, boat)
    s.cable("rope", s.ground, boat, stiffness=50, length=1, damping=3)
    program = fb.compile(s)
    for x, v, force in (
        (0.5, 9.0, 0.0),
        (1.2, 1.0, 13.0),
        (1.2, -1.0, 7.0),
        (1.2, -9.0, 0.0),
        (-1.2, -1.0, -13.0),
    ):
        close(program.forward_dynamics([x], [v]), [-force], 64 * EPS)


def duffing(**law):
    s = fb.System("duffing")
    k, k3, m = s.parameters(k=4.0, k3=30.0, m=2.0)
    body = s.body("body", fb.particle(m))
    guide = s.slider("guide", s.ground, body, coordinate="x")
    s.spring("spring", guide, **law)
    return s


def test_a_hardening_spring_swings_as_elliptic_functions_do():
    """m x'' + k x + k3 x³ = 0 from rest at A: x = A cn(ω t, κ²), ω² = (k + k3 A²)/m, κ² = k3 A²/(2 m ω²)."""
    from scipy.special import ellipj

    s = duffing(force="k*stretch + k3*stretch^3")
    A = 0.7
    motion = fb.simulate(s, 8, initial={"x": A}, tolerance=1e-12)
    w2 = (4 + 30 * A**2) / 2
    _, cn, _, _ = ellipj(np.sqrt(w2) * motion.t, 30 * A**2 / (2 * 2 * w2))
    close(motion["x"], A * cn, 1e-9)
    close(motion.energy.potential[0], 4 * A**2 / 2 + 30 * A**4 / 4, 1e-12)
    assert fb.equations(s).text() == "m*x'' + k*x + k3*x^3 = 0"


def test_a_table_is_joined_by_monotone_cubics():
    from scipy.interpolate import PchipInterpolator

    table = [(-1, -3), (-0.5, -0.1), (0, 0), (0.2, 3), (0.7, 3), (1.5, 10)]
    program = fb.compile(duffing(force=table))
    x = np.linspace(-1, 1.5, 101)
    force = -2 * np.array([program.forward_dynamics([float(a)], [0.0])[0] for a in x])
    curve = PchipInterpolator(*np.array(table).T)
    inside = (x >= -0.5) & (x <= 0.7)  # the slopes at the ends are ours: those of the last chords
    close(force[inside], curve(x[inside]), 1e-12)
    assert (np.diff(force) > -1e-12).all()
    slope = program.forward_dynamics([2.5], [0.0])[0] - program.forward_dynamics([1.5], [0.0])[0]
    close(-2 * slope, 7 / 0.8, 1e-12)  # beyond the table the last chord goes on
    motion = fb.simulate(duffing(force=table), 5, initial={"x": 1.2}, tolerance=1e-10)
    assert np.abs(motion.energy.residual).max() < 1e-6


def test_a_damper_of_any_law():
    s = duffing(force="k*stretch + k3*rate*abs(rate)")
    close(fb.compile(s).forward_dynamics([0.5], [-2.0]), [-(4 * 0.5 - 30 * 4) / 2], 64 * EPS)
    motion = fb.simulate(s, 1, initial={"x": 0.3})
    whole = motion.energy.kinetic + 2 * motion["x"] ** 2  # the whole law is counted as work
    assert (
        (np.diff(whole) <= 1e-9).all()
        and whole[-1] < whole[0]
        and np.abs(motion.energy.residual).max() < 1e-7
    )


def test_a_law_along_a_line():
    s = fb.System("pendulum on a spring")
    m = s.parameters(m=1.0)
    ball = s.body("ball", fb.particle(m))
    s.planar("j", s.ground, ball, coordinate=["x", "y", "turn"])
    s.spring("k", s.ground, ball, force="3*stretch + rate", rest=2)
    udot = fb.compile(s).forward_dynamics([3.0, 4.0, 0.0], [1.0, 0.5, 0.0])
    pull = 3 * (5 - 2) + (3 + 2) / 5
    close(udot[:2], [-pull * 0.6, -pull * 0.8], 64 * EPS)


def test_drag_at_rest():
    """Implicit methods differentiate |v| v at v = 0; the numeric linear equations there are refused."""
    s = fb.System("drop")
    m, k, g = s.parameters(m=1.0, k=0.5, g=9.81)
    s.gravity = (0, 0, -g)
    rail = s.slider("z", s.ground, s.body("drop", fb.particle(m)), axis="z", coordinate="z")
    s.drag("air", s.bodies["drop"], quadratic=k)
    fastest = np.sqrt(9.81 / 0.5)
    assert fb.simulate(s, 3, method="radau")["z'"][-1] == pytest.approx(
        -fastest * np.tanh(9.81 * 3 / fastest), rel=1e-8
    )
    s.gravity = (0, 0, 0)
    s.spring("spring", rail, stiffness=4)
    with pytest.raises(fb.errors.ModelError, match=r"not finite at the state given: .* drag at rest"):
        fb.linearize(s, values={})
