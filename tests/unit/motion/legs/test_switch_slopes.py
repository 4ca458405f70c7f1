"""Derivatives across the switches of loads: stops with springs and dampers, and laws with sign(…)."""

import numpy as np
import pytest
import sympy

import freebody as fb


def pushed(load):
    """A stone of 1 kg on a rail, pushed along x by a load."""
    s = fb.System("pushed")
    s.parameters(k=2.0)
    stone = s.body("stone", fb.particle(1))
    s.slider("rail", s.ground, stone, axis="x", coordinate="x")
    s.force("F", stone.origin, (load, 0, 0))
    return s


def test_a_relay():
    """x = a - k t²/2 down to 0 at T = √(2a/k), back at 3 T: between them x = -k T τ + k τ²/2, τ = t - T."""
    motion = fb.simulate(
        pushed("-k*sign(x)"), 2.9, initial={"x": 1}, sensitivities=["k", "x"], tolerance=1e-12
    )
    a, k, t = sympy.symbols("a k t", positive=True)
    T = sympy.sqrt(2 * a / k)
    x = -k * T * (t - T) + k * (t - T) ** 2 / 2
    at = {a: 1, k: 2, t: 2.5}
    found = fb.simulate(
        pushed("-k*sign(x)"), 2.5, initial={"x": 1}, sensitivities=["k", "x"], tolerance=1e-12, samples=2
    ).sensitivity
    for unknown, symbol in (("k", k), ("x", a)):
        assert found["x", unknown][-1] == pytest.approx(float(x.diff(symbol).subs(at)), rel=1e-9)
        assert found["x'", unknown][-1] == pytest.approx(float(x.diff(t, symbol).subs(at)), rel=1e-9)
    assert len(motion.path.segments) == 2 and motion.energy.relative_residual < 1e-9


def test_a_law_that_switches_in_time_from_the_start_on():
    """x'' = k up to t = π/k, then -k: x = π²/(2 k) + π τ - k τ²/2, τ = t - π/k."""
    motion = fb.simulate(pushed("k*sign(sin(k*t))"), 2, sensitivities=["k"], tolerance=1e-12, samples=2)
    k, t = sympy.symbols("k t")
    tau = t - sympy.pi / k
    x = sympy.pi**2 / (2 * k) + sympy.pi * tau - k * tau**2 / 2
    assert motion.sensitivity["x", "k"][-1] == pytest.approx(float(x.diff(k).subs({k: 2, t: 2})), rel=1e-9)


@pytest.mark.parametrize("damping", [0, 3.0])
def test_a_stop_with_a_spring_and_a_damper(damping):
    """It holds a mass for (π - 2φ)/ω_d, sin φ = ζ, and lets it go at the depth c v'/k with v' = v exp(-(π - 2φ) tan φ).

    Source: T. Schwager, T. Pöschel, Coefficient of restitution and linear-dashpot model revisited, Granular Matter 9
    (2007) 465-469.
    """
    s = fb.System("stop")
    s.parameters(k=100.0, m=2.0, c=damping, h=0.1)
    body = s.body("b", fb.particle("m"))
    rail = s.slider("rail", s.ground, body, axis="x", coordinate="x")
    s.stop("wall", rail, high="h", stiffness="k", damping="c")
    names = ["k", "m", "c", "h", "x'"] if damping else ["k", "m", "h", "x'"]
    motion = fb.simulate(s, 1, initial={"x'": 1.0}, sensitivities=names, tolerance=1e-12, samples=2)
    k, m, c, h, v = symbols = sympy.symbols("k m c h v", positive=True)
    phi = sympy.asin(c / (2 * sympy.sqrt(k * m)))
    left = h / v + (sympy.pi - 2 * phi) / (sympy.sqrt(k / m) * sympy.cos(phi)) + c / k
    speed = -v * sympy.exp(-(sympy.pi - 2 * phi) * sympy.tan(phi))
    at = dict(zip(symbols, (100, 2, damping, 0.1, 1), strict=True))
    of = dict(zip(("k", "m", "c", "h", "x'"), symbols, strict=True))
    for j, name in enumerate(names):
        expected = [float(x.diff(of[name]).subs(at)) for x in (h / v, left, speed)]
        touched, leaves = (motion.sensitivity.times(f"wall {what}")[0, j] for what in ("touches", "leaves"))
        assert [touched, leaves, motion.sensitivity["x'", name][-1]] == pytest.approx(
            expected, rel=1e-8, abs=1e-10
        )


def test_a_stop_with_a_damper_beside_contacts():
    """A ball rolls against a plate on a buffer; by differences of the fourth order."""
    s = fb.System("ball and buffer")
    s.parameters(k=300.0, c=5.0, e=0.5, mu=0.3, d=0.01)
    s.gravity = (0, -9.81, 0)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.planar("plane", s.ground, ball, coordinate="x y turn")
    plate = s.body("plate", fb.particle(0.5))
    rail = s.slider("rail", s.ground, plate, axis="x", coordinate="z")
    s.stop("buffer", rail, low=-0.1, high=0.02, stiffness="k", damping="c")
    s.contact("floor", ball.sphere(0.1), s.ground.plane(), friction="mu", rolling="d")
    s.contact(
        "wall", ball.sphere(0.1), plate.plane(normal="-x", at=(1, 0, 0)), friction="mu", restitution="e"
    )
    options = {"initial": {"y": 0.1, "x'": 3.0}, "tolerance": 1e-13, "samples": 2}
    motion = fb.simulate(s, 0.45, sensitivities=["k", "c", "e", "mu", "d"], **options)
    assert [event.name for event in motion.events if "buffer" in event.name]
    for name in ("k", "c", "e", "mu", "d"):
        value, ends = float(motion.values[name]), []
        h = 1e-4 * value
        for n in (1, -1, 2, -2):
            ends.append(fb.simulate(s, 0.45, values={name: value + n * h}, **options).states[-1])
        expected = (8 * (ends[0] - ends[1]) - (ends[2] - ends[3]))[:8] / (12 * h)
        found = np.array([motion.sensitivity[x, name][-1] for x in motion.names])
        assert np.abs(found - expected).max() <= 1e-6 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("load", "start", "unknown", "message"),
    [
        ("-k*sign(x)", {"x'": 1.0}, "x", r"after t = 0 s, where a law .*: it is zero at the start"),
        ("-k*sign(x')", {"x'": 1.0}, "x'", "after t = 0.5 s, .* both sides lead back to it, and the motion sticks"),
        ("-k*sign(x) - k*sign(sin(x))", {"x": 1.0}, "x", "passes zero at the same time"),
        ("3*k*sign(x) - 2*k", {"x": 0.5, "x'": -(2**0.5) - 1e-10}, "x'", "it only touches zero there, with the rate"),
    ],
)  # fmt: skip
def test_switches_without_derivatives(load, start, unknown, message):
    with pytest.raises(
        fb.errors.SimulationError, match=message + ".*End the run before, ask for other unknowns"
    ):
        fb.simulate(pushed(load), 3, initial=start, sensitivities=[unknown], tolerance=1e-12)
