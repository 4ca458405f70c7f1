"""Friction with two coefficients: closed forms of drift and of stick, maximum dissipation, files, diagrams."""

import math

import numpy as np
import pytest
import sympy
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command as program
from freebody.errors import FormatError
from freebody.exact import drifting_block
from freebody.picture.paper.sheet import Label, flat

G, MU_1, MU_2 = 9.81, 0.2, 0.4
STEPS = {"method": "timestepping", "step": 1e-2}


def block(gravity=(0, 0, -G), friction=("mu_1", "mu_2"), along="x", **laws):
    """A particle of 2 kg over a floor."""
    s = fb.System("block")
    s.parameters(mu_1=MU_1, mu_2=MU_2)
    s.gravity = gravity
    body = s.body("block", fb.particle(2))
    s.chain("move", s.ground, body, [fb.Slider(axis, axis) for axis in "xyz"])
    s.contact("floor", body.origin, s.ground.plane(normal="z"), friction=friction, along=along, **laws)
    return s


def on_slope(d, slope):
    """The block on a slope on which it slides along d."""
    fall = drifting_block(MU_1, MU_2, d, slope, G)
    level = math.sin(slope) * G
    gravity = (level * fall.along, level * fall.across, -math.cos(slope) * G)
    return gravity, fall.acceleration


@pytest.mark.parametrize("route", [{"tolerance": 1e-11}, STEPS])
def test_a_block_drifts_sideways_down_a_slope(route):
    d = (0.6, 0.8)
    gravity, a = on_slope(d, 0.5)
    motion = fb.simulate(block(gravity), 2, **route)
    assert [change.mode for change in motion.modes] == ["slip"]
    np.testing.assert_allclose([motion["x"][-1], motion["y"][-1]], [x * a * 2 for x in d], rtol=1e-8)
    one = motion.contacts["floor"]
    N = 2 * G * math.cos(0.5)
    size = math.hypot(MU_1 * d[0], MU_2 * d[1])
    T = [-(mu**2) * x * N / size for mu, x in zip((MU_1, MU_2), d, strict=True)]
    np.testing.assert_allclose(one.tangential[-1], T, rtol=1e-8)
    np.testing.assert_allclose(one.slip[-1], [x * a * 2 for x in d], rtol=1e-8)
    assert np.abs(one.margin[1:]).max() < 1e-10
    assert abs(motion.energy.residual[-1]) < 1e-10


def test_stick_is_an_ellipse():
    fall = math.atan(1 / math.hypot(0.6 / MU_1, 0.8 / MU_2))  # tan β √((e₁/μ₁)² + (e₂/μ₂)²) = 1
    for part, mode in ((0.999, "stick"), (1.001, "slip")):
        level = G * math.sin(fall * part)
        gravity = (0.6 * level, 0.8 * level, -G * math.cos(fall * part))
        for route in ({}, STEPS):
            motion = fb.simulate(block(gravity), 0.1, **route)
            assert [change.mode for change in motion.modes] == [mode]
            assert motion.contacts["floor"].margin[-1] == pytest.approx(
                2 * (MU_1 * G * math.cos(fall * part) - level * math.hypot(0.6, 0.8 * MU_1 / MU_2))
                if mode == "stick"
                else 0,
                abs=1e-9,
            )


def test_a_slip_turns_towards_the_easy_direction():
    """v₁'/v₂' = μ₁² v₁/(μ₂² v₂) on a level floor: v₂ ~ v₁^(μ₂²/μ₁²)."""
    motion = fb.simulate(block(), 0.4, initial={"x'": 1.0, "y'": 1.0}, tolerance=1e-11)
    np.testing.assert_allclose(motion["y'"], motion["x'"] ** 4, atol=1e-9)
    assert np.abs(motion.energy.residual).max() < 1e-10
    stops = fb.simulate(block(), 1, initial={"x'": 1.0, "y'": 1.0})
    assert [change.mode for change in stops.modes] == ["slip", "stick"]


def test_equal_coefficients_are_one():
    start = {"x'": 1.0, "y'": 0.5}
    equal = fb.simulate(block(friction=(0.3, 0.3), along=(1, 2, 0)), 0.3, initial=start, tolerance=1e-11)
    one = fb.simulate(block(friction=0.3, along=None), 0.3, initial=start, tolerance=1e-11)
    for name in ("x", "y"):
        assert equal[name][-1] == pytest.approx(one[name][-1], abs=1e-10)


@pytest.mark.parametrize("route", [{}, STEPS])
def test_an_impact_has_friction_of_the_ellipse(route):
    motion = fb.simulate(block(), 0.1, initial={"z": 0.02, "z'": -1.0, "x'": 1.0, "y'": 1.0}, **route)
    hit = next(k for k, change in enumerate(motion.modes) if change.mode == "slip")
    after = motion.modes[hit].start
    k = int(np.searchsorted(motion.t, after + 1e-2))
    x, y = motion["x'"][k], motion["y'"][k]
    assert y < x < 1
    speeds = motion.events[0].after if hit else {}
    jump = [1 - speeds[f"{name}'"] for name in "xy"]
    v = [speeds[f"{name}'"] for name in "xy"]
    assert jump[1] / jump[0] == pytest.approx((MU_2 / MU_1) ** 2 * v[1] / v[0], rel=0.05 if route else 1e-9)


def test_a_soft_floor_has_the_same_drift():
    d = (0.6, 0.8)
    gravity, a = on_slope(d, 0.5)
    s = block(gravity, normal="1e4*depth + 100*rate")
    motion = fb.simulate(s, 1, initial={"z": 2 * gravity[2] / 1e4}, tolerance=1e-11)
    np.testing.assert_allclose([motion["x"][-1], motion["y"][-1]], [x * a / 2 for x in d], rtol=1e-8)
    found = fb.equations(s, modes={"floor": ("slip", (0.6, 0.8))}).motion[0]
    assert "mu_2" in str(found)


def test_equations_have_the_power_of_most_dissipation():
    e = fb.equations(block(), modes={"floor": ("slip", ("3/5", "4/5"))})
    T1, T2, N = (e.reactions["floor"].components[name] for name in ("T1_floor", "T2_floor", "N_floor"))
    values = dict(zip(sympy.symbols("mu_1 mu_2", real=True), (MU_1, MU_2), strict=True))
    size = math.hypot(0.6 * MU_1, 0.8 * MU_2)
    for T, mu, d in ((T1, MU_1, 0.6), (T2, MU_2, 0.8)):
        assert float(sympy.simplify(T / N).subs(values)) == pytest.approx(-(mu**2) * d / size, rel=1e-12)
    motion = str(e.motion[0])
    assert "mu_1" in motion and "mu_2" in motion


def test_files_check_and_report_keep_both(tmp_path):
    s = block(static_friction=("2*mu_1", "2*mu_2"), along=(1, 1, 0))
    fb.write(s, tmp_path / "block.toml")
    again = fb.read(tmp_path / "block.toml").contacts["floor"]
    first = s.contacts["floor"]
    assert str(again) == str(first)
    for name in ("friction", "friction_across", "static_friction", "along"):
        assert getattr(again, name) == getattr(first, name)
    assert 'friction = ["mu_1", "mu_2"]' in (tmp_path / "block.toml").read_text()
    said = CliRunner().invoke(program, ["check", str(tmp_path / "block.toml")], catch_exceptions=False).output
    assert "across" in said
    fb.report(s, fb.simulate(s, 0.1, initial={"x'": 1.0}), tmp_path / "block.html")
    assert "0.2 along, 0.4 across" in (tmp_path / "block.html").read_text(encoding="utf-8")
    with pytest.raises(FormatError, match="its second coefficient of friction"):
        fb.write(block(), tmp_path / "block.xml")


def test_a_diagram_names_the_ellipse():
    for mode, sign in (("stick", r"\leq"), ("slip", "=")):
        drawing = fb.free_body_diagram(block(), "block", modes={"floor": mode})
        said = [item.tex for item in flat(drawing.sheet.root) if isinstance(item, Label)]
        law = rf"$\sqrt{{(T_{{1,floor}}/\mu_{{1}})^2+(T_{{2,floor}}/\mu_{{2}})^2}}{sign}N_{{floor}}$"
        assert law in "".join(said).replace(r"\mathrm{floor}", "floor").replace(" ", ""), said
