"""Derivatives of motions by parameters and starts, against closed forms and identities."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError


def pendulum() -> fb.System:
    s = fb.System("pendulum")
    m, L, g, a, c = s.parameters(m=1.0, L=2.0, g=9.81, a=1.2, c=0.0)
    s.gravity = (0, -g, 0)
    pin = s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), axis="z", coordinate="theta")
    s.damper("c", pin, damping=c)
    return s


def oscillator() -> fb.System:
    s = fb.System("oscillator")
    m, k, d = s.parameters(m=2.0, k=8.0, d=0.4)
    rail = s.slider("rail", s.ground, s.body("cart", fb.particle(m)), axis="x", coordinate="x")
    s.spring("k", rail, stiffness=k)
    s.damper("d", rail, damping=d)
    return s


@pytest.mark.parametrize("method", ["auto", "taylor"])
def test_damped_oscillator_by_every_parameter_and_start(method: str) -> None:
    """x = e^(-δt) (x₀ cos ωt + (v₀ + δ x₀)/ω sin ωt), differentiated by SymPy."""
    import sympy as sp

    m, k, d, x0, v0, t = sp.symbols("m k d x0 v0 t", positive=True)
    delta = d / (2 * m)
    w = sp.sqrt(k / m - delta**2)
    x = sp.exp(-delta * t) * (x0 * sp.cos(w * t) + (v0 + delta * x0) / w * sp.sin(w * t))
    names = {"m": m, "k": k, "d": d, "x": x0, "x'": v0}
    at = {m: 2.0, k: 8.0, d: 0.4, x0: 0.3, v0: -1.0}
    motion = fb.simulate(
        oscillator(), 6, initial={"x": 0.3, "x'": -1.0}, tolerance=1e-12, sensitivities=list(names), samples=7,
        method=method,
    )  # fmt: skip
    for name, symbol in names.items():
        exact = sp.lambdify(t, x.diff(symbol).subs(at))(motion.t)
        assert np.allclose(motion.sensitivity["x", name], exact, rtol=0, atol=1e-10), name
        rate = sp.lambdify(t, x.diff(t).diff(symbol).subs(at))(motion.t)
        assert np.allclose(motion.sensitivity["x'", name], rate, rtol=0, atol=1e-10), name
    plain = fb.simulate(oscillator(), 6, initial={"x": 0.3, "x'": -1.0}, tolerance=1e-12, samples=7)
    assert np.allclose(motion["x"], plain["x"], rtol=0, atol=1e-11)
    assert np.abs(motion.energy.residual).max() < 1e-9 and "x" in motion.data


@pytest.mark.parametrize("method", ["auto", "taylor"])
def test_large_pendulum_against_elliptic_functions(method: str) -> None:
    """Central differences of the closed form with two steps, extrapolated: accurate to about 1e-10."""
    s = pendulum()
    motion = fb.simulate(
        s, 5, initial={"theta": "2*a"}, tolerance=1e-12, sensitivities=["L", "m", "a"],
        samples=6, method=method,
    )  # fmt: skip

    def theta(length: float, a: float) -> np.ndarray:
        return fb.exact.pendulum(2 * a, np.sqrt(9.81 / length), motion.t)[0]

    def slope(f, h: float) -> np.ndarray:
        one, two = ((f(step) - f(-step)) / (2 * step) for step in (h, h / 2))
        return (4 * two - one) / 3

    by_length = slope(lambda h: theta(2 + h, 1.2), 2e-3)
    by_a = slope(lambda h: theta(2, 1.2 + h), 2e-3)
    assert np.allclose(motion.sensitivity["theta", "L"], by_length, rtol=0, atol=1e-8)
    assert np.allclose(motion.sensitivity["theta", "a"], by_a, rtol=0, atol=1e-8)
    assert np.allclose(motion.sensitivity["theta", "m"], 0, atol=1e-12)  # the mass has no influence
    # an expression depends on the parameter by itself too: d(L sin θ)/dL = sin θ + L cos θ dθ/dL
    expected = np.sin(motion["theta"]) + 2 * np.cos(motion["theta"]) * motion.sensitivity["theta", "L"]
    assert np.allclose(motion.sensitivity["L*sin(theta)", "L"], expected, rtol=0, atol=1e-12)
    assert motion.sensitivity.of("L*sin(theta)").shape == (6, 3)


def differences(s, name: str, value: float, h: float, run) -> dict[str, np.ndarray]:
    """Central differences of all coordinates and speeds, extrapolated."""
    out = {}
    runs = {step: run(value + step) for step in (h, -h, h / 2, -h / 2)}
    for key in runs[h].names:
        one, two = ((runs[x][key] - runs[-x][key]) / (2 * x) for x in (h, h / 2))
        out[key] = (4 * two - one) / 3
    return out


@pytest.mark.parametrize("method", ["auto", "taylor"])
def test_ball_joint_keeps_quaternions_on_the_sphere(method: str) -> None:
    s = fb.System("top")
    m, d = s.parameters(m=1.0, d=0.3)
    s.gravity = (0, 0, -9.81)
    s.ball("O", s.ground, s.body("top", fb.MassProperties(m, (0, 0, d), np.diag([0.1, 0.1, 0.05]).tolist())))
    start = {"O": fb.Rotation.axis_angle((1, 0, 0), 0.6), "O_wz": 20.0}

    def run(x: float, **more):
        return fb.simulate(s, 1.5, initial={**start, "O_wz": x}, tolerance=1e-13, samples=4, **more)

    motion = run(20.0, sensitivities=["O_wz", "d"], method=method)
    expected = differences(s, "O_wz", 20.0, 2e-2, run)
    for name, values in expected.items():
        assert np.allclose(motion.sensitivity[name, "O_wz"], values, rtol=0, atol=2e-8), name
    e = np.stack([motion[f"O_e{i}"] for i in range(4)])
    for unknown in ("O_wz", "d"):
        de = np.stack([motion.sensitivity[f"O_e{i}", unknown] for i in range(4)])
        assert np.abs((e * de).sum(axis=0)).max() < 1e-11  # unit length at first order too
    by_part = fb.simulate(
        s, 0.0, initial={"O_e0": 3.0, "O_e1": 4.0}, sensitivities=["O_e1"]
    )  # e = r/|r|: de₁/dr₁ = r₀²/|r|³
    assert by_part.sensitivity["O_e1", "O_e1"][0] == pytest.approx(9 / 125, abs=1e-15)


@pytest.mark.parametrize("method", ["auto", "taylor"])
def test_four_bar_by_a_length_and_by_its_start(method: str) -> None:
    def build() -> fb.System:
        s = fb.System("four-bar")
        b, L = s.parameters(b=3.0, L=1.0)
        s.gravity = (0, -9.81, 0)
        one, two, three = (
            s.body(name, fb.slender_bar(1, length, axis="x"))
            for name, length in (("a", L), ("b", b), ("c", 2))
        )
        s.hinge("A", s.ground, one, to=(-L / 2, 0, 0), axis="z", coordinate="q1")
        s.hinge("B", one, two, at=(L / 2, 0, 0), to=(-b / 2, 0, 0), axis="z", coordinate="q2")
        s.hinge("D", s.ground, three, at=(3, 0, 0), to=(-1, 0, 0), axis="z", coordinate="q3")
        s.hinge("C", two, three, at=(b / 2, 0, 0), to=(1, 0, 0), axis="z")
        return s

    s = build()
    near = {"q2": -0.7, "q3": 1.2}

    def run(b: float = 3.0, q1: float = 1.0, **more):
        return fb.simulate(
            s,
            1.2,
            initial={"q1": q1, "q1'": 3.0},
            near=near,
            values={"b": b},
            tolerance=1e-12,
            samples=4,
            **more,
        )

    motion = run(sensitivities=["b", "q1"], method=method)
    for name, expected in (
        ("b", differences(s, "b", 3.0, 2e-3, lambda x: run(b=x))),
        ("q1", differences(s, "q1", 1.0, 2e-3, lambda x: run(q1=x))),
    ):
        for key, values in expected.items():
            assert np.allclose(motion.sensitivity[key, name], values, rtol=1e-7, atol=1e-7), (key, name)


def test_heavy_top_against_its_closed_form() -> None:
    """Thin disk on a shaft, by its length, its spin and its start; differences of the exact formula, extrapolated."""
    m, R, L, g, theta0, spin = 1.2, 0.06, 0.1, 9.81, 1.0, 100.0
    s = fb.System("heavy top")
    names = dict(zip(("m", "R", "L", "g"), s.parameters(m=m, R=R, L=L, g=g), strict=True))
    s.gravity = (0, 0, -names["g"])
    rotor = s.body("rotor", fb.disk(names["m"], names["R"], axis="z"))
    angles = s.coordinates("psi theta phi")
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -names["L"]), axis="ZXZ", coordinate=angles)
    motion = fb.simulate(
        s, 1.0, initial={"theta": theta0, "phi'": spin}, tolerance=1e-13, samples=5,
        sensitivities=["L", "R", "phi'", "theta"],
    )  # fmt: skip

    def exact(L: float = L, R: float = R, spin: float = spin, theta0: float = theta0) -> np.ndarray:
        path = fb.exact.top(m * (R**2 / 4 + L**2), m * R**2 / 2, m * g * L, theta0, spin)
        return np.stack([path.theta(motion.t), path.psi(motion.t), path.phi(motion.t)])

    for unknown, key, h in (
        ("L", "L", 1e-4),
        ("R", "R", 1e-4),
        ("phi'", "spin", 0.1),
        ("theta", "theta0", 1e-3),
    ):
        at = {"L": L, "R": R, "spin": spin, "theta0": theta0}[key]
        one, two = ((exact(**{key: at + x}) - exact(**{key: at - x})) / (2 * x) for x in (h, h / 2))
        for angle, values in zip(("theta", "psi", "phi"), (4 * two - one) / 3, strict=True):
            ours = motion.sensitivity[angle, unknown]
            assert np.allclose(ours, values, rtol=1e-6, atol=1e-6 * np.abs(values).max()), (angle, unknown)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sensitivities": ["M"]}, "Unknown name 'M' in sensitivities"),
        ({"sensitivities": []}, "at least one parameter or initial value"),
        ({"sensitivities": ["m", "m"]}, "'m' is named twice"),
        ({"sensitivities": ["m"], "method": "radau"}, "for sensitivities=, got method='radau'"),
        ({"sensitivities": ["theta"], "initial": {"theta": "2*a"}}, "a number for the initial value of 'theta'.*by a"),
        ({"sensitivities": ["m"], "impulses": ["x"]}, "Expected fb.blow\\(time"),
    ],
)  # fmt: skip
def test_refusals(options: dict, message: str) -> None:
    with pytest.raises(SimulationError, match=message):
        fb.simulate(pendulum(), 1, **options)


def test_unknown_quantities_are_named() -> None:
    motion = fb.simulate(pendulum(), 1, initial={"theta": 1}, sensitivities="L", samples=2)
    with pytest.raises(SimulationError, match="Unknown name 'm' in trajectory.sensitivity"):
        motion.sensitivity["theta", "m"]
    with pytest.raises(SimulationError, match="a quantity and an unknown"):
        motion.sensitivity["theta"]
    with pytest.raises(SimulationError, match="Expected a coordinate, a speed, an energy or an expression"):
        motion.sensitivity["thet", "L"]
    assert list(motion.sensitivity) == [("theta", "L"), ("theta'", "L")] and "by L at 2 times" in repr(
        motion.sensitivity
    )


def pushed(load):
    """A stone of 1 kg on a rail, pushed along x by a load."""
    s = fb.System("pushed")
    s.parameters(k=1.0)
    stone = s.body("stone", fb.particle(1))
    s.slider("rail", s.ground, stone, axis="x", coordinate="x")
    s.force("F", stone.origin, (load, 0, 0))
    return s


def test_rates_that_jump_later_or_at_a_fixed_time_or_do_not_jump_have_derivatives():
    early = fb.simulate(pushed("-k*sign(x)"), 1, initial={"x": 1}, sensitivities=["k"])
    assert early.sensitivity["x", "k"][-1] == pytest.approx(-1 / 2, abs=1e-9)  # x = 1 - k t²/2
    # from t = 1 on pushed back: x = k/2 + k (t - 1) - k (t - 1)²/2
    timed = fb.simulate(pushed("k*sign(1 - t)"), 2, initial={"x": 0}, sensitivities=["k"])
    assert timed.sensitivity["x", "k"][-1] == pytest.approx(1, abs=1e-7)
    # a spring that only pulls back: x = cos(√k t), then x = -√k (t - π/(2√k))
    bent = fb.simulate(pushed("-k*max(x, 0)"), 4, initial={"x": 1}, sensitivities=["k"])
    assert bent.sensitivity["x", "k"][-1] == pytest.approx(-2, abs=1e-7)
