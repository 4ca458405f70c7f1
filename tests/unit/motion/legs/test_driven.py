"""Signals and sampled controllers against closed forms, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm

import freebody as fb
from freebody.errors import FormatError, ModelError, SimulationError


def cart(mass: float = 2.0):
    s = fb.System("cart")
    body = s.body("body", fb.particle(mass))
    rail = s.slider("rail", s.ground, body, axis="x", coordinate="x")
    return s, body, rail


# -- signals ---------------------------------------------------------------------------------------


def test_values_of_each_kind():
    t, v = [0.0, 1.0, 3.0], [1.0, 3.0, -1.0]
    x = np.array([0.0, 0.5, 1.0, 2.0, 3.0])
    np.testing.assert_allclose(fb.signal(t, v)(x), [1, 2, 3, 1, -1], rtol=1e-15)
    np.testing.assert_array_equal(fb.signal(t, v, "previous")(x), [1, 1, 3, 3, -1])
    assert fb.signal(t, v, "previous")(7.0) == -1  # held after its last sample
    parabola = fb.signal(np.linspace(0, 2, 5), np.linspace(0, 2, 5) ** 2, "cubic")
    assert parabola(0.3) == pytest.approx(0.09, abs=1e-15)
    assert str(2 * fb.signal(t, v, name="gust")) == "2*gust"
    held = fb.signal(t, v, outside="hold")
    assert held(-5.0) == 1 and held(9.0) == -1


@pytest.mark.parametrize("kind", ["linear", "previous", "cubic"])
def test_force_of_a_signal_gives_its_integral(kind):
    """m v = ∫ F dt, of polynomials of degree at most 3: exact in each interval."""
    rng = np.random.default_rng(3)
    times = np.cumsum(rng.uniform(0.05, 0.6, 12))
    times -= times[0]
    force = fb.signal(times, rng.uniform(-3, 3, 12), kind, name="F")
    s, body, _ = cart()
    s.force("push", body, (2 * force, 0, 0))
    motion = fb.simulate(s, float(times[-1]), initial={"x'": 0.3})
    moments = np.linspace(0, times[-1], 40)
    # Simpson's rule is exact in each piece
    expected = []
    for t in moments:
        total = 0.3
        for a, b in zip(times[:-1], np.minimum(times[1:], t), strict=True):
            if b > a:
                inside = np.nextafter(b, a)
                total += (b - a) / 6 * (2 * force(a) + 8 * force((a + b) / 2) + 2 * force(inside)) / 2.0
        expected.append(total)
    np.testing.assert_allclose(motion.at(moments)["x'"], expected, rtol=0, atol=2e-13)
    assert motion.energy.relative_residual < 1e-12
    # at the very end the last piece still holds
    np.testing.assert_allclose(motion["F"][:-1], force(motion.t[:-1]), rtol=0, atol=1e-12)


def test_text_names_a_signal_once_it_is_used():
    s, body, _ = cart()
    s.force("first", body, (fb.signal([0, 1], [1, 1], name="wind"), 0, 0))
    s.force("second", body, ("2*wind*t", 0, 0))
    assert fb.simulate(s, 1).at(1)["x'"] == pytest.approx((1 + 1) / 2, abs=1e-14)


def test_prescribed_displacement_of_a_cubic_signal_and_its_reaction():
    """A cubic through samples of a cubic is that cubic: force of the drive m x'' and its work to the end."""
    times = np.linspace(0, 2, 9)
    path = fb.signal(times, times**3 - times, "cubic", name="path")
    s = fb.System("table")
    table = s.body("table", fb.particle(2))
    s.slider("guide", s.ground, table, axis="x", coordinate=path)
    bob = s.body("bob", fb.particle(0.5))
    s.slider("cross", table, bob, axis="y", coordinate="y")
    motion = fb.simulate(s, 2, initial={"y'": 1})
    np.testing.assert_allclose(motion.poses["table"].position[:, 0], motion.t**3 - motion.t, atol=1e-13)
    np.testing.assert_allclose(motion.reactions["guide"].force[:, 0], 2.5 * 6 * motion.t, atol=1e-10)
    work = 0.5 * 2.5 * ((3 * 2**2 - 1) ** 2 - 1)
    assert motion.energy.work[-1] == pytest.approx(work, rel=1e-11)
    assert np.max(np.abs(motion.energy.residual)) < 1e-11 * work


def test_order_is_kept_across_break_points():
    """Bends that a step crossed would spoil the order: errors fall with the tolerance down to round-off."""
    times = np.array([0.0, 0.317, 0.71, 1.3, 2.0])
    torque = fb.signal(times, [0, 3, -2, 1, 0], name="torque")
    ends = []
    for tolerance in (1e-6, 1e-9, 1e-12, 1e-13):
        s = fb.System("pendulum")
        s.gravity = (0, -9.81, 0)
        bob = s.body("bob", fb.particle(1))
        pin = s.hinge("pin", s.ground, bob, to=(0, 1, 0), axis="z", coordinate="theta")
        s.torque("motor", pin, torque)
        motion = fb.simulate(s, 2, initial={"theta": 1}, tolerance=tolerance)
        assert set(times[1:-1]) <= set(motion.path.times)
        ends.append(motion.at(2)["theta"])
    assert abs(ends[1] - ends[3]) < 1e-8
    assert abs(ends[2] - ends[3]) < 1e-11


def test_products_of_a_program_follow_the_time():
    s, body, _ = cart()
    wind = fb.signal([0, 1, 3], [0, 2, -2], name="wind")
    s.force("push", body, (wind, 0, 0))
    program = fb.compile(s)
    assert program.forward_dynamics([0.0], [0.0], 2.0)[0] == pytest.approx(0.0, abs=1e-15)
    t = np.array([0.5, 1.0, 2.5])
    np.testing.assert_allclose(program.forward_dynamics([0.0], [0.0], t)[:, 0], wind(t) / 2, atol=1e-15)


def test_event_at_a_jump_of_a_signal():
    s, body, _ = cart()
    s.force("push", body, (fb.signal([0, 0.4, 1], [1, -1, -1], "previous", name="push"), 0, 0))
    motion = fb.simulate(s, 1, events=[fb.event("push*(1 + t)", name="reversal")])
    assert [(e.name, e.time, e.direction) for e in motion.events] == [("reversal", 0.4, -1)]
    stopped = fb.simulate(s, 1, events=[fb.event("push*(1 + t)", name="reversal", terminal=True)])
    assert stopped.path.end == 0.4 and stopped.status == "terminal event"


def test_signals_and_blows_together():
    s, body, _ = cart()
    s.force("push", body, (fb.signal([0, 1, 2], [0, 2, 2], name="push"), 0, 0))
    motion = fb.simulate(s, 2, impulses=[fb.blow(1.5, at=body, impulse=(4, 0, 0))])
    assert motion.at(2)["x'"] == pytest.approx(1.5 + 2, abs=1e-13)
    assert motion.energy.relative_residual < 1e-12


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0, 1], [1, 2, 3]), "as many values as times"),
        (([0, 0], [1, 2]), r"times that increase .* kind='previous'"),
        (([0, math.nan], [1, 2]), "finite times .* at place 1"),
        (([0], [1]), "at least two samples"),
        (([[0, 1]], [1, 2]), "A vector is three signals"),
        ((["a"], [1]), "Expected numbers for the times"),
        (([0, 1], [1, 2], "spline"), "'linear', 'previous' or 'cubic'"),
    ],
)
def test_refused_signals(arguments, message):
    with pytest.raises(ModelError, match=message):
        fb.signal(*arguments)


def test_refused_uses_of_signals():
    with pytest.raises(ModelError, match="ends="):
        fb.signal([0, 1], [0, 1], ends="natural")
    with pytest.raises(ModelError, match="outside"):
        fb.signal([0, 1], [0, 1], outside="zero")
    with pytest.raises(ModelError, match="name"):
        fb.signal([0, 1], [0, 1], name="two words")
    s, body, rail = cart()
    arm = s.body("arm", fb.particle(1))
    with pytest.raises(ModelError, match="signal 'drive' bends or jumps.*cubic"):
        s.hinge("pin", body, arm, to=(0, 1, 0), axis="z", coordinate=fb.signal([0, 1], [0, 1], name="drive"))
    with pytest.raises(ModelError, match="must be constant, but it depends on rate"):
        s.spring("k", rail, stiffness=fb.signal([0, 1], [1, 2], "previous", name="rate"))
    with pytest.raises(ModelError, match="signal 'steps' jumps"):
        s.constrain_speed(s.expression("x'") - fb.signal([0, 1], [0, 1], "previous", name="steps"))
    short, other, _ = cart()
    short.force("push", other, (fb.signal([0, 1], [0, 1], name="push"), 0, 0))
    with pytest.raises(SimulationError, match="'push' is given from 0 to 1 s.*outside=\"hold\""):
        fb.simulate(short, 3)
    with pytest.raises(SimulationError, match="no way back"):
        fb.simulate(short, 0, start=1)
    with pytest.raises(FormatError, match="cannot hold controllers and signals.*push"):
        fb.write(short, "push.toml")
    with pytest.raises(SimulationError, match="'late' occurs in no load"):
        fb.simulate(short, 1, events=[fb.event(fb.signal([0, 1], [-1, 1], name="late"))])


# -- controllers -----------------------------------------------------------------------------------


def test_sampled_pd_of_a_cart_is_the_discrete_closed_form():
    """x_{k+1} = A x_k + B u_k, u = -K x (zero-order hold): A = [[1, T], [0, 1]], B = [T²/2, T] / m."""
    T, K = 0.05, np.array([6.0, 5.0])
    s, _, rail = cart()
    s.parameters(F=0.0)
    s.force("motor", rail, "F")
    s.controller(lambda t, x: -K @ [x["x"], x["x'"]], T, "F")
    motion = fb.simulate(s, 2, initial={"x": 1})
    closed = np.array([[1, T], [0, 1]]) - np.outer([T * T / 4, T / 2], K)
    expected = np.linalg.matrix_power(closed, 40) @ [1.0, 0.0]
    assert motion.at(2)["x"] == pytest.approx(expected[0], abs=1e-13)
    assert motion.at(2)["x'"] == pytest.approx(expected[1], abs=1e-13)
    # the ledger: the held force's work is the change of kinetic energy
    assert motion.energy.relative_residual < 1e-12
    assert np.min(np.abs(motion["F"])) < np.max(np.abs(motion["F"]))


def test_sampled_pd_pendulum_against_its_linear_closed_form():
    """Small angles: x' = A x + B u held for T, exactly discretized by exp; the difference is of second order."""
    T, kp, kd, g = 0.02, 30.0, 6.0, 9.81
    A = np.array([[0, 1], [-g, 0.0]])
    both = expm(T * np.block([[A, np.array([[0.0], [1.0]])], [np.zeros((1, 3))]]))
    closed = both[:2, :2] - both[:2, 2:] @ [[kp, kd]]
    expected = np.linalg.matrix_power(closed, 25) @ [1.0, 0.0]
    errors = []
    for size in (1e-2, 1e-3):
        s = fb.System("pendulum")
        s.gravity = (0, -g, 0)
        s.parameters(tau=0.0)
        bob = s.body("bob", fb.particle(1))
        pin = s.hinge("pin", s.ground, bob, to=(0, 1, 0), axis="z", coordinate="theta")
        s.torque("motor", pin, "tau")
        s.controller(lambda t, x: {"tau": -kp * x["theta"] - kd * x["theta'"]}, T, "tau", name="pd")
        motion = fb.simulate(s, 0.5, initial={"theta": size}, tolerance=1e-13)
        errors.append(abs(motion.at(0.5)["theta"] / size - expected[0]))
    assert errors[1] < 1e-6
    assert errors[0] / errors[1] == pytest.approx(100, rel=0.05)


def test_motor_drive_with_current_as_signal_reaches_its_closed_form():
    """J ω' = k i(t) - c ω with i held: ω relaxes to k i / c in each interval."""
    J, k, c = 0.02, 0.1, 0.05
    s = fb.System("motor")
    rotor = s.body("rotor", fb.MassProperties(1, (0, 0, 0), ((J, 0, 0), (0, J, 0), (0, 0, J))))
    shaft = s.hinge("shaft", s.ground, rotor, axis="z", coordinate="phi")
    current = fb.signal([0, 0.3, 0.8], [2, -1, 4], "previous", name="current")
    s.torque("coil", shaft, k * current)
    s.damper("bearing", shaft, damping=c)
    motion = fb.simulate(s, 1.5, tolerance=1e-12)
    w, t0 = 0.0, 0.0
    for i, t1 in ((2, 0.3), (-1, 0.8), (4, 1.5)):
        w = k * i / c + (w - k * i / c) * math.exp(-c / J * (t1 - t0))
        t0 = t1
        assert motion.at(t1)["phi'"] == pytest.approx(w, abs=1e-11)
    assert motion.energy.relative_residual < 1e-11


def test_several_controllers_sensors_and_mappings():
    s, body, rail = cart()
    s.parameters(a=0.0, b=0.0, c=0.0, T=0.1)
    s.force("f", rail, "a + b + c")
    calls: list[tuple[str, float]] = []

    def slow(t, x):
        calls.append(("slow", t))
        assert set(x) >= {"x", "x'", "a", "b", "c", "T", "twice"} and x["twice"] == 2 * x["x"]
        return {"b": 2.0}

    def fast(t, x):
        calls.append(("fast", t))
        return [1.0, -1.0]

    s.controller(slow, "2*T", ["b"], sensors={"twice": "2*x"})
    s.controller(fast, "T", "a c")
    motion = fb.simulate(s, 1)
    assert [t for who, t in calls if who == "fast"] == pytest.approx(np.arange(10) * 0.1, abs=1e-15)
    assert [t for who, t in calls if who == "slow"] == pytest.approx(np.arange(5) * 0.2, abs=1e-15)
    assert calls[:2] == [("slow", 0.0), ("fast", 0.0)]
    assert motion.at(1)["x'"] == pytest.approx(1.0, abs=1e-13)


def test_stiffness_that_a_controller_sets_does_work():
    """A spring of which the stiffness is quadrupled at x = 1: W = 3 k x² / 2, and the amplitude stays."""
    s, _, rail = cart()
    s.parameters(k=2.0)
    s.spring("spring", rail, stiffness="k")

    class Switch:
        def __init__(self):
            self.count = 99

        def reset(self):
            self.count = 0

        def __call__(self, t, x):
            self.count += 1
            return 2.0 if self.count <= 1 else 8.0

    s.controller(Switch(), 2 * math.pi, "k", name="switch")
    motion = fb.simulate(s, 9, initial={"x": 1}, tolerance=1e-12)
    assert motion.at(2 * math.pi)["x"] == pytest.approx(1, abs=1e-10)  # ω = 1
    assert motion.at(9)["x"] == pytest.approx(math.cos(2 * (9 - 2 * math.pi)), abs=1e-9)
    assert motion.energy.impulses[-1] == pytest.approx(3.0, abs=1e-9)
    assert motion.energy.relative_residual < 1e-10


def test_a_controlled_machine_with_a_loop():
    """A crank that a sampled torque turns against a four-bar: the loop stays closed, the ledger balances."""
    s = fb.System("four-bar")
    s.gravity = (0, -9.81, 0)
    s.parameters(tau=0.0)
    parts = [
        s.body(n, fb.slender_bar(1, L, axis="x")) for n, L in (("crank", 1), ("coupler", 3), ("rocker", 2.5))
    ]
    pin = s.hinge("A", s.ground, parts[0], to=(-0.5, 0, 0), axis="z", coordinate="a")
    s.hinge("B", parts[0], parts[1], at=(0.5, 0, 0), to=(-1.5, 0, 0), axis="z", coordinate="b")
    s.hinge("D", s.ground, parts[2], at=(3, 0, 0), to=(-1.25, 0, 0), axis="z", coordinate="d")
    s.hinge("C", parts[1], parts[2], at=(1.5, 0, 0), to=(1.25, 0, 0), axis="z")
    s.torque("motor", pin, "tau")
    s.controller(lambda t, x: 20 * (3.0 - x["a'"]), 0.02, "tau", name="governor")
    motion = fb.simulate(s, 1, initial={"a": 1.0}, near={"d": 1.8, "b": 0.0}, tolerance=1e-10)
    assert motion.energy.relative_residual < 1e-8
    A = motion.poses["coupler"]
    end = A.position + A.rotation @ [1.5, 0, 0]
    B = motion.poses["rocker"]
    assert np.max(np.abs(end - B.position - B.rotation @ [1.25, 0, 0])) < 1e-12


def test_refused_controllers():
    s, _, rail = cart()
    F = s.parameters(F=0.0)
    s.parameters(m=1.0)
    s.force("motor", rail, F)
    zero = lambda t, x: 0.0  # noqa: E731
    with pytest.raises(ModelError, match="Expected a Python function"):
        s.controller("-2*x", 0.1, "F")
    with pytest.raises(
        ModelError, match="parameters of this system.*'G'.*Did you mean 'F'|parameters of this system.*'G'"
    ):
        s.controller(zero, 0.1, "G")
    with pytest.raises(ModelError, match="period greater than 0 s"):
        s.controller(zero, 0, "F")
    with pytest.raises(ModelError, match="period .* must be constant"):
        s.controller(zero, "x", "F")
    with pytest.raises(ModelError, match="is listed twice"):
        s.controller(zero, 0.1, "F F")
    with pytest.raises(ModelError, match="at least one input"):
        s.controller(zero, 0.1, [])
    with pytest.raises(ModelError, match="Sensor 'x' .* coordinate"):
        s.controller(zero, 0.1, "F", sensors={"x": "2*x"})
    s.controller(zero, 0.1, F, name="first")
    with pytest.raises(ModelError, match="already a controller 'first'"):
        s.controller(zero, 0.1, "m", name="first")
    with pytest.raises(ModelError, match="already set by controller 'first'"):
        s.controller(zero, 0.1, "F", name="second")


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (lambda t, x: None, "Expected a number for 'F' from controller 'c' at t = 0 s, got None"),
        (lambda t, x: math.nan, "finite number for 'F'"),
        (lambda t, x: {"G": 1}, "returned a value for 'G'.*not among its inputs"),
        (lambda t, x: [1, 2], "Expected a number for 'F'"),
        (lambda t, x: x["y"], "Controller 'c' asks for 'y'.*sensors"),
        (lambda t, x: 1 / 0, "Controller 'c' failed at t = 0 s: ZeroDivisionError"),
    ],
)
def test_refused_answers(answer, message):
    s, _, rail = cart()
    s.parameters(F=0.0)
    s.force("motor", rail, "F")
    s.controller(answer, 0.1, "F", name="c")
    with pytest.raises(SimulationError, match=message):
        fb.simulate(s, 1)


def test_inputs_that_would_jump_masses_are_refused():
    s = fb.System("cart")
    m = s.parameters(m=1.0)
    body = s.body("body", fb.particle(m))
    s.slider("rail", s.ground, body, axis="x", coordinate="x")
    s.controller(lambda t, x: 1.0, 0.1, "m", name="c")
    with pytest.raises(SimulationError, match="Controller 'c' sets 'm', which occurs in a mass"):
        fb.simulate(s, 1)


def test_the_page_prints_what_it_says(capsys):
    import re
    from pathlib import Path

    text = (Path(__file__).parents[4] / "docs" / "drives.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", text, re.DOTALL)
    assert len(blocks) >= 3
    names: dict[str, object] = {}
    for code, printed in blocks:
        exec(compile(code, "drives.md", "exec"), names)
        assert capsys.readouterr().out == printed
