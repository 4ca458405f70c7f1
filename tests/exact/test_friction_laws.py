"""Friction by a law of the slip speed and of the state, against closed forms and an integration of the slip alone."""

import math

import numpy as np
import pytest
import sympy
from click.testing import CliRunner
from scipy.integrate import solve_ivp

import freebody as fb
from freebody.cli import command as program
from freebody.errors import ExpressionError, ModelError, SimulationError
from freebody.exact.contact import stribeck_time

G = 9.81
MU, MU_S, V_S = 0.2, 0.4, 0.1
STRIBECK = "mu + (mu_s - mu)*exp(-slip/v_s)"


def block(friction, space=False, belt=0, **laws):
    """A block on a floor or on a belt."""
    s = fb.System("block")
    s.parameters(mu=MU, mu_s=MU_S, v_s=V_S)
    s.gravity = (0, -G, 0)
    body = s.body("block", fb.particle(2))
    slides = [fb.Slider("x", "x"), fb.Slider("y", "y"), *([fb.Slider("z", "z")] if space else [])]
    s.chain("plane", s.ground, body, slides)
    under = s.ground
    if belt:
        under = s.body("belt", fb.particle(1))
        s.slider("drive", s.ground, under, axis="x", coordinate=belt * s.t)
    s.contact("floor", body.origin, under.plane(normal="y"), friction=friction, **laws)
    return s


def test_a_block_stops_after_the_time_of_stribeck():
    motion = fb.simulate(block(STRIBECK), 1, initial={"x'": 1.0}, tolerance=1e-11)
    slip, stick = motion.modes
    assert (slip.mode, stick.mode) == ("slip+", "stick")
    assert stick.start == pytest.approx(float(stribeck_time(1.0, MU, MU_S, V_S)), rel=1e-9)
    assert np.abs(motion.energy.residual).max() < 1e-10


def test_in_space_the_slip_keeps_its_direction():
    motion = fb.simulate(
        block(STRIBECK, space=True), 1, initial={"x'": 0.6, "z'": 0.8}, tolerance=1e-11, samples=101
    )
    assert motion.modes[-1].start == pytest.approx(float(stribeck_time(1.0, MU, MU_S, V_S)), abs=1e-8)
    np.testing.assert_allclose(0.8 * motion["x"], 0.6 * motion["z"], atol=1e-10)
    one = motion.contacts["floor"]
    slips = one.mode == "slip"
    speed = np.linalg.norm(one.slip, axis=1)
    law = MU + (MU_S - MU) * np.exp(-speed / V_S)
    np.testing.assert_allclose(
        np.linalg.norm(one.tangential, axis=1)[slips], (law * one.normal)[slips], rtol=1e-9
    )


def test_a_joint_with_stribeck_friction():
    """J w' = -(T + (T_s - T) e^(-w/w_s)): the block's law with μ g as T/J."""
    s = fb.System("wheel")
    s.parameters(T=1.0, T_s=2.0, w_s=0.3)
    wheel = s.body("wheel", fb.disk(2, 1))  # J = 1
    s.friction("dry", s.hinge("h", s.ground, wheel, coordinate="a"), torque="T + (T_s - T)*exp(-slip/w_s)")
    motion = fb.simulate(s, 4, initial={"a'": -3.0}, tolerance=1e-11)
    stops = float(stribeck_time(3.0, 1.0, 2.0, 0.3, g=1.0))
    assert [change.mode for change in motion.modes] == ["slip-", "stick"]
    assert motion.modes[-1].start == pytest.approx(stops, rel=1e-9)
    (law,) = fb.equations(s, modes={"dry": "slip-"}).motion
    (T, T_s, w_s), t = sympy.symbols("T T_s w_s", real=True), sympy.Symbol("t")
    left = law.lhs - law.rhs
    w = sympy.Function("a")(t).diff(t)
    assert sympy.simplify(left - (w.diff(t) - T - (T_s - T) * sympy.exp(w / w_s))) == 0


def test_friction_by_place():
    """Ice thins out: μ = 0.1 + 0.3/(1 + x), so v²/2 falls by g ∫ μ dx."""
    motion = fb.simulate(block("0.1 + 0.3/(1 + x)"), 1, initial={"x'": 2.0}, tolerance=1e-11)
    x, v = motion["x"], motion["x'"]
    np.testing.assert_allclose(v**2 / 2 + G * (0.1 * x + 0.3 * np.log1p(x)), 2, atol=1e-9)


# --- laws that jump or bend: their switches are located --------------------------------------------------------------


@pytest.mark.parametrize("space", [False, True])
def test_a_narrow_strip_is_not_passed_over(space):
    """μ = 0.6 between x = 1 and x = 1 + w, else none: v² falls by 2 μ g w within one step, which saw nothing of it."""
    w, v = 2e-3, 4.0
    s = block("3/10 - 3/10*sign((x - 1)*(x - 1 - 2/1000))", space)
    motion = fb.simulate(s, 1, initial={"x'": v})
    after = math.sqrt(v * v - 2 * 0.6 * G * w)
    inside = (v - after) / (0.6 * G)
    assert motion["x'"][-1] == pytest.approx(after, abs=1e-12)
    assert motion["x"][-1] == pytest.approx(1 + w + after * (1 - 1 / v - inside), abs=1e-12)
    assert motion.path.rejected == 0


def test_friction_that_bends_with_the_slip():
    """v' = -g/10 above v = 2/5, then -g (1/2 - v): it stops after 6/g and another ln 5/g."""
    motion = fb.simulate(block("max(1/10, 1/2 - slip)"), 2, initial={"x'": 1.0})
    assert [change.mode for change in motion.modes] == ["slip+", "stick"]
    assert motion.modes[-1].start == pytest.approx((6 + math.log(5)) / G, abs=1e-10)


def test_slip_stays_where_friction_drives_it_back_from_either_side():
    """μ g is more than the pull above v = 1 and less below it: no motion leaves v = 1."""
    s = block("1/5 + 1/10*sign(slip - 1)")
    s.force("pull", s.bodies["block"], (2 * 0.2 * G, 0, 0))
    with pytest.raises(SimulationError, match="drives it back from either side"):
        fb.simulate(s, 3, initial={"x'": 2.0})


def test_a_brake_on_a_part_of_a_turn():
    """φ'' = -T_0 up to φ = 1, then -3 T_0, on a wheel of 1 kg m²."""
    s = fb.System("wheel")
    s.parameters(T_0=1.0)
    pin = s.hinge("pin", s.ground, s.body("wheel", fb.disk(2, 1, axis="z")), axis="z", coordinate="phi")
    s.friction("brake", pin, torque="T_0*(2 + sign(phi - 1))")
    motion = fb.simulate(s, 5, initial={"phi'": 3.0})
    w = math.sqrt(9 - 2)
    assert motion["phi"][-1] == pytest.approx(1 + w * w / 6, abs=1e-12)
    assert motion.modes[-1].start == pytest.approx(3 - w + w / 3, abs=1e-12)


def test_stick_slip_on_a_belt_is_a_limit_cycle():
    """Stick until k x = μ_s m g; then m x'' = m g μ(v - x') - k x until x' = v again. Each period is the same."""
    m, k, v = 2.0, 40.0, 0.1
    s = block(STRIBECK, belt=v)
    s.generalized_force("x", "-40*x")
    motion = fb.simulate(s, 12, initial={"x'": v}, tolerance=1e-11)
    modes = [change.mode for change in motion.modes]
    assert modes == (["stick", "slip-"] * len(modes))[: len(modes)] and len(modes) > 6
    begins = [change.start for change in motion.modes]
    break_away = MU_S * m * G / k
    assert begins[1] == pytest.approx(break_away / v, rel=1e-10)

    def slips(t, y):
        return [y[1], G * (MU + (MU_S - MU) * math.exp(-(v - y[1]) / V_S)) - k * y[0] / m]

    def stops(t, y):
        return y[1] - v if t > 1e-2 else -1.0

    stops.terminal, stops.direction = True, 1
    # the slip begins at an unstable point, v - x' = 0: a start on the curve beside it
    path = solve_ivp(slips, (0, 5), [break_away, v - 1e-13], rtol=1e-12, atol=1e-14, events=stops)
    (back,) = path.y_events[0]
    period = path.t[-1] + (break_away - back[0]) / v
    np.testing.assert_allclose(np.diff(begins[1::2]), period, rtol=1e-7)


def test_a_ball_on_a_turntable_rolls_on_a_circle():
    """r' = 2/7 Ω e_z × (r - c) of a homogeneous sphere, whatever carries it: here the plane of a driven body."""
    s = fb.System("turntable")
    s.gravity = (0, 0, -G)
    table = s.body("table", fb.disk(1, 1))
    s.hinge("axle", s.ground, table, axis="z", coordinate=2 * s.t)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, ball)
    s.contact("on", ball.sphere(0.1), table.plane(normal="z"), friction="0.5 + 0.1*exp(-slip)")
    # rolls from the start: v = Ω × r_contact + w × R e_z with w = 0 -> v = (-Ω y, Ω x)
    start = {"f_z": 0.1, "f_x": 0.5, "f_vy": 1.0}
    motion = fb.simulate(s, 5, initial=start, tolerance=1e-11)
    assert [change.mode for change in motion.modes] == ["stick"]
    rate = 2 * 2 / 7
    radius = 1.0 / rate
    x = 0.5 - radius + radius * np.cos(rate * motion.t)
    y = radius * np.sin(rate * motion.t)
    np.testing.assert_allclose(motion["f_x"], x, atol=1e-8)
    np.testing.assert_allclose(motion["f_y"], y, atol=1e-8)


def test_equations_know_the_law_along_the_slip():
    s = block(STRIBECK)
    equations = fb.equations(s, modes={"floor": "slip-"})
    t = sympy.Symbol("t")
    mu, mu_s, v_s, N = sympy.symbols("mu mu_s v_s N_floor", real=True)
    x = sympy.Function("x")(t)
    law = equations.motion[0]
    friction = N * (mu + (mu_s - mu) * sympy.exp(x.diff(t) / v_s))
    assert sympy.simplify(law.lhs - law.rhs - (2 * x.diff(t, 2) - friction)) == 0
    motion = fb.simulate(s, 0.2, initial={"x'": -1.0})
    assert motion["floor.margin"][-1] > 0


def test_a_law_of_friction_goes_through_a_file(tmp_path):
    s = block(STRIBECK, static_friction=0.5)
    fb.write(s, tmp_path / "block.toml")
    again = fb.read(tmp_path / "block.toml")
    assert again.contacts["floor"].friction == s.contacts["floor"].friction
    assert again.contacts["floor"].static_friction == s.contacts["floor"].static_friction
    assert 'friction = "mu + (-mu + mu_s)*exp(-slip/v_s)"' in (tmp_path / "block.toml").read_text()


def test_check_and_report_print_the_law(tmp_path):
    s = block(STRIBECK)
    fb.write(s, tmp_path / "block.toml")
    said = CliRunner().invoke(program, ["check", str(tmp_path / "block.toml")], catch_exceptions=False)
    law = "mu + (-mu + mu_s)*exp(-slip/v_s)"
    assert said.exit_code == 0 and law in said.output
    fb.report(s, fb.simulate(s, 1, initial={"x'": 1.0}), tmp_path / "block.html")
    assert law in (tmp_path / "block.html").read_text(encoding="utf-8")


def test_a_symbol_named_slip_is_the_slip_speed():
    slip = sympy.Symbol("slip", positive=True)
    s = block(0.2 + 0.2 * sympy.exp(-slip / 0.1))
    motion = fb.simulate(s, 1, initial={"x'": 1.0}, tolerance=1e-11)
    assert motion.modes[-1].start == pytest.approx(float(stribeck_time(1.0, MU, MU_S, V_S)), rel=1e-9)


def test_a_system_with_its_own_slip_is_refused():
    s = fb.System("block")
    s.parameters(slip=0.1)
    body = s.body("block", fb.particle(1))
    s.planar("plane", s.ground, body, coordinate="x y turn")
    with pytest.raises(ModelError) as caught:
        s.contact("floor", body.origin, s.ground.plane(), friction="0.3 + slip")
    assert str(caught.value) == (
        "The friction of contact 'floor' is an expression of `slip`, the slip speed, but this system has a parameter "
        "'slip'. Give that another name."
    )


def test_unknown_names_are_refused_with_the_nearest():
    with pytest.raises(ExpressionError) as caught:
        block("mu*slipp")
    assert str(caught.value).startswith(
        "In the friction of contact 'floor': Expected a known name, got 'slipp'; did you mean 'slip'?"
    )


def test_friction_that_vanishes_is_refused():
    with pytest.raises(SimulationError, match="above 0 at rest, since it depends on slip; got 0 at slip = 0"):
        fb.simulate(block("mu*slip"), 1, initial={"x'": 1.0})
    with pytest.raises(SimulationError) as caught:
        fb.simulate(block("0.2 - x"), 1, initial={"x'": 1.0})
    assert "The friction of contact 'floor' falls to 0 there, and friction below 0 would drive." in str(
        caught.value
    )
    assert caught.value.trajectory["x"][-1] == pytest.approx(0.2, abs=1e-6)


@pytest.mark.parametrize("space", [False, True])
@pytest.mark.parametrize("speed", [0, 1])
def test_friction_that_vanishes_is_refused_where_a_ball_rests_or_rolls_and_needs_none(space, speed):
    s = fb.System("ball")
    s.gravity = (0, 0, -9.81) if space else (0, -9.81, 0)
    ball = s.body("ball", fb.sphere(1, 0.1))
    if space:
        s.free("f", s.ground, ball)
        start = {"f_z": 0.1, "f_vx": speed, "f_wy": 10 * speed}
    else:
        s.planar("plane", s.ground, ball, coordinate="x y turn")
        start = {"y": 0.1, "x'": speed, "turn'": -10 * speed}
    s.contact("floor", ball.sphere(0.1), s.ground.plane(normal="z" if space else "y"), friction="0.3 - t")
    with pytest.raises(SimulationError, match="just after t = 0.3 s.* 'floor' falls to 0 there") as caught:
        fb.simulate(s, 1, initial=start)
    assert caught.value.trajectory.t[-1] == pytest.approx(0.3, abs=1e-9)
    assert fb.simulate(s, 0.25, initial=start).status == "finished"


def test_a_motion_that_ends_by_a_load_blames_no_friction():
    s = block(0)
    s.generalized_force("x", "sqrt(0.5 - x)")
    with pytest.raises(SimulationError, match="is not a finite number") as caught:
        fb.simulate(s, 5, initial={"x'": 1.0})
    assert "friction" not in str(caught.value)


def test_in_time_steps_a_block_stops_after_the_time_of_stribeck():
    """In every step the law holds at its end: v_{k+1} = v_k - g h μ(v_{k+1}); so the stop is off by a few steps."""
    stops = float(stribeck_time(1.0, MU, MU_S, V_S))
    for h in (4e-3, 1e-3):
        motion = fb.simulate(block(STRIBECK), 1, initial={"x'": 1.0}, method="timestepping", step=h)
        assert [change.mode for change in motion.modes] == ["slip+", "stick"] and motion.residual <= 1e-12
        assert abs(motion.modes[-1].start - stops) < h
        v = motion.path.states[:, 2]
        k = round(motion.modes[-1].start / h)
        law = MU + (MU_S - MU) * np.exp(-v[1:k] / V_S)
        np.testing.assert_allclose(np.diff(v[:k]), -G * h * law, rtol=0, atol=1e-12 * (v[0] + G * h))


@pytest.mark.parametrize(
    ("friction", "laws"),
    [
        (STRIBECK, {}),
        ("mu", {"static_friction": "mu_s"}),
        ("0.2 + 0.5*slip", {}),
        ("0.3/(1 + x^2) + 0.05*t", {}),
    ],
)
def test_in_time_steps_a_block_on_a_belt_sticks_and_slips_as_by_events(friction, laws):
    """A spring holds it back: the margin of a stick is never negative, and errors fall with the step."""
    s = block(friction, belt=0.3, **laws)
    s.generalized_force("x", "-40*x")
    exact, times = fb.simulate(s, 5), np.linspace(0, 5, 51)
    errors = []
    for h in (4e-3, 1e-3):
        motion = fb.simulate(s, 5, method="timestepping", step=h)
        errors.append(np.abs(motion.at(times)["x"] - exact.at(times)["x"]).max())
        assert [m.mode for m in motion.modes] == [m.mode for m in exact.modes]
        floor = motion.contacts["floor"]
        assert floor.margin[floor.mode == "stick"].min() > -1e-9 and motion.residual <= 1e-12
    assert errors[1] < 0.4 * errors[0]


def test_in_time_steps_static_friction_of_a_pile_and_of_a_joint():
    """A family of blocks on a slope between the two angles, with the law of a pair: it rests; started, it slides."""
    s = fb.System("slope")
    s.gravity = (G * math.sin(0.3), 0, -G * math.cos(0.3))  # tan 0.3 = 0.309
    balls, start = [], {}
    for i in range(2):
        body = s.body(f"b{i}", fb.sphere(1, 0.1))
        s.chain(
            f"c{i}",
            s.ground,
            body,
            [fb.Slider("x", f"x{i}"), fb.Slider("y", f"y{i}"), fb.Slider("z", f"z{i}")],
        )
        balls.append(body.sphere(0.1))
        start |= {f"z{i}": 0.1, f"y{i}": i, f"x{i}'": i}
    s.contacts("on", balls, against=s.ground.plane(normal="z"), friction=0.2, static_friction=0.35)
    motion = fb.simulate(s, 1, initial=start, method="timestepping", step=5e-3)
    assert np.abs(motion["x0"]).max() < 1e-12 and motion.contacts["on[b0,ground]"].mode[-1] == "stick"
    slides = 1 + 0.5 * G * (math.sin(0.3) - 0.2 * math.cos(0.3))
    assert motion["x1"][-1] == pytest.approx(slides, rel=1e-9)
    margin = motion.contacts["on[b0,ground]"].margin[-1]
    assert margin == pytest.approx(G * (0.35 * math.cos(0.3) - math.sin(0.3)), rel=1e-9)
    wheel = fb.System("wheel")
    disk = wheel.body("wheel", fb.disk(2, 1))  # J = 1
    hinge = wheel.hinge("h", wheel.ground, disk, coordinate="a")
    wheel.friction("dry", hinge, torque="1 + exp(-slip/0.3)")
    wheel.torque("M", hinge, "0.8*t")
    exact = fb.simulate(wheel, 4)
    steps = fb.simulate(wheel, 4, method="timestepping", step=1e-3)
    assert [m.mode for m in steps.modes] == ["stick", "slip+"] == [m.mode for m in exact.modes]
    assert (
        steps.modes[1].start == pytest.approx(2.5, abs=2e-3) and abs(steps["a"][-1] - exact["a"][-1]) < 5e-3
    )


def test_an_impact_in_a_step_has_the_friction_of_the_slip_before_it():
    """A disk lands on a floor: Δv = -μ(v⁻) Δv_N; a block that rests on it elsewhere keeps its static friction."""
    s = fb.System("landing")
    s.gravity = (0, -G, 0)
    disk, rest = s.body("disk", fb.particle(1)), s.body("rest", fb.particle(1))
    for name, body in (("d", disk), ("r", rest)):
        s.chain(name, s.ground, body, [fb.Slider("x", f"{name}x"), fb.Slider("y", f"{name}y")])
        s.contact(
            f"{name}c",
            body.origin,
            s.ground.plane(normal="y"),
            friction="0.1 + 0.05*slip",
            static_friction=0.3,
        )
    s.force("pull", rest, (0.2 * G, 0, 0))
    start = {"dx'": 4.0, "dy": 0.5, "dy'": -2.0}
    motion = fb.simulate(s, 0.5, initial=start, method="timestepping", step=1e-4)
    fall = math.sqrt(4 + 2 * G * 0.5)
    after = 4 - (0.1 + 0.05 * 4) * fall
    landed = (fall - 2) / G
    assert motion.at(landed + 3e-4)["dx'"] == pytest.approx(after, abs=5e-3)
    assert np.abs(motion["rx"]).max() < 1e-12
