"""Operational space: at a point, Λ x'' + μ = F for any force F; Jacobians and their rates of named frames."""

from __future__ import annotations

import re

import numpy as np
import pytest

import freebody as fb
from freebody import dynamics
from freebody.dynamics.kinematics import accelerations, place_of, point_acceleration, rotation
from freebody.testing import random_state, random_system
from freebody.testing.machines import random_chain
from sampled import sampled

EPS = np.finfo(float).eps


def accelerations_at(program, point, q, u, udot, t=0.0):
    """Angular acceleration of the body and acceleration of the point, in ground axes, of floats."""
    model = program.model
    state = dynamics.float_state(model, q, u, t)
    link, _ = place_of(model, point.body)
    alpha = np.array(rotation(model, state, link)) @ accelerations(model, state, udot)[link][0]
    return np.array([*alpha, *point_acceleration(model, state, point, udot)], float)


@pytest.mark.parametrize("seed", sampled(range(8), 4))
def test_rate_of_the_jacobian_and_inertia_at_a_point(seed):
    s = random_system(seed, bodies=7, branching=False, driven=False)
    program, random = fb.compile(s), np.random.default_rng(seed)
    model = program.model
    point = s.bodies["b6"].point(0.3, -0.2, 0.5)
    q, u = random_state(model, seed)
    udot, force = random.normal(size=model.n_u), random.normal(size=6)
    J, rate = program.jacobian(point, q), program.jacobian_rate(point, q, u)
    expected = accelerations_at(program, point, q, u, list(udot))
    size = np.abs(J) @ np.abs(udot) + np.abs(rate) @ np.abs(u)
    assert np.abs(J @ udot + rate @ u - expected).max() <= 2**8 * EPS * size.max()
    words = "wx wy wz vx vy vz" if model.n_u >= 8 else "vx vy"
    rows = [["wx", "wy", "wz", "vx", "vy", "vz"].index(x) for x in words.split()]
    inertia = program.operational_inertia(point, q, components=words)
    bias = program.operational_bias(point, q, u, components=words)
    M = program.mass_matrix(q)
    moved = program.forward_dynamics(q, u, forces=J[rows].T @ force[rows])
    found = inertia @ (J @ moved + rate @ u)[rows] + bias
    condition = np.linalg.cond(M) * np.linalg.cond(inertia)
    assert np.abs(found - force[rows]).max() <= 2**6 * EPS * condition * max(1, np.abs(bias).max())


def four_bar():
    s = fb.System("four-bar")
    s.gravity = (0, -9.81, 0)
    crank, coupler, rocker = (
        s.body(n, fb.slender_bar(1, L, axis="x")) for n, L in (("crank", 1), ("coupler", 3), ("rocker", 2))
    )
    s.hinge("A", s.ground, crank, to=(-0.5, 0, 0), axis="z", coordinate="a")
    s.hinge("B", crank, coupler, at=(0.5, 0, 0), to=(-1.5, 0, 0), axis="z", coordinate="b")
    s.hinge("D", s.ground, rocker, at=(3, 0, 0), to=(-1, 0, 0), axis="z", coordinate="d")
    s.hinge("C", coupler, rocker, at=(1.5, 0, 0), to=(1, 0, 0), axis="z")
    return s


def test_loops_hold_what_they_hold():
    s = four_bar()
    program = fb.compile(s, at=[1.2, -0.7, 1.6])
    motion = fb.simulate(s, 0.1, initial={"a": 1.2, "a'": 2}, near={"b": -0.7, "d": 1.6})
    at = motion.at(0.1)
    q, u = (np.array([float(at[name]) for name in names]) for names in (("a", "b", "d"), ("a'", "b'", "d'")))
    J, rate = program.jacobian("coupler", q), program.jacobian_rate("coupler", q, u)
    inertia = program.operational_inertia("coupler", q, components="vx")
    bias = program.operational_bias("coupler", q, u, components=["vx"])
    moved = program.forward_dynamics(q, u, forces=J[3] * 7.0)
    assert (inertia @ [J[3] @ moved + rate[3] @ u] + bias).item() == pytest.approx(7.0, rel=1e-12)
    assert inertia.item() < 1 / (J[3] @ np.linalg.solve(program.mass_matrix(q), J[3])) * 10**6
    with pytest.raises(fb.FreebodyError, match="singular one"):
        program.operational_inertia("coupler", q, components="vx vy")


@pytest.mark.parametrize("language", ["casadi", "jax"])
@pytest.mark.parametrize("machine", ["tree", "loop"])
def test_operational_space_and_rates_of_jacobians_in_other_languages(language, machine):
    pytest.importorskip(language)
    if machine == "loop":
        program, q, u = fb.compile(four_bar(), at=[1.2, -0.7, 1.6]), [1.2, -0.7, 1.6], [1.0, -0.5, 0.3]
        point, words = "coupler", "vx"
    else:
        program, point, words = fb.compile(random_chain(3, 7)), "b6", "wx wy wz vx vy vz"
        q, u = np.random.default_rng(0).uniform(-1, 1, (2, 7))
    names = (
        f"jacobian_rate of {point}",
        f"operational_inertia of {point}: {words}",
        f"operational_bias of {point}: {words}",
    )
    expected = (
        program.jacobian_rate(point, q, u),
        program.operational_inertia(point, q, components=words),
        program.operational_bias(point, q, u, components=words),
    )
    # the bias has its inertia from the same run
    assert "operational_space" in repr(program)
    t, p = 0.0, np.array([x for x in program.model.values({}).values()])
    if language == "jax":
        import jax

        before = jax.config.jax_enable_x64
        jax.config.update("jax_enable_x64", True)
    try:
        written = program.to_casadi(*names) if language == "casadi" else program.to_jax(*names)
        for name, function, wanted in zip(names, written.values(), expected, strict=True):
            inputs = (np.array(q),) if "inertia" in name else (np.array(q), np.array(u))
            found = np.array(function(*inputs, t, p), float).reshape(wanted.shape)
            condition = np.linalg.cond(expected[1])
            assert abs(found - wanted).max() < 2**8 * EPS * condition * abs(wanted).max(), name
    finally:
        if language == "jax":
            jax.config.update("jax_enable_x64", before)


MASS = """<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"""
ROBOT = f"""<robot name="arm"><link name="base"/><link name="tool: 0"/>
<link name="upper">{MASS}</link><link name="fore">{MASS}</link>
<joint name="one" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
<joint name="two" type="continuous"><parent link="upper"/><child link="fore"/><origin xyz="1 0 0"/>
<axis xyz="0 0 1"/></joint>
<joint name="end" type="fixed"><parent link="fore"/><child link="tool: 0"/><origin xyz="0.5 0 0"/></joint></robot>"""


def test_frames_of_a_file_by_their_names(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(ROBOT)
    program = fb.compile(fb.read(path))
    J = program.jacobian("tool: 0", [0.0, np.pi / 2])
    assert np.allclose(J[3:, :], [[-0.5, -0.5], [1, 0], [0, 0]], atol=4 * EPS)
    assert (
        program.derivative("jacobian of fore", "q")([0.0, 0.3])
        == program.derivative("jacobian", "q", point="fore")([0.0, 0.3])
    ).all()
    q, u = np.array([0.2, 0.9]), np.array([1.0, -2.0])
    names = ("jacobian of tool: 0", "jacobian_rate of upper: vx vy", "operational_inertia of tool: 0: vx vy",
             "operational_bias of tool: 0: vx vy", "jacobian_by_q of fore")  # fmt: skip
    written = program.to_numpy(*names)
    inertia = program.operational_inertia("tool: 0", q, components="vx vy")
    assert np.allclose(written[names[2]](q), inertia, rtol=2**8 * EPS)
    assert np.allclose(
        written[names[3]](q, u),
        program.operational_bias("tool: 0", q, u, components="vx vy"),
        rtol=2**8 * EPS,
    )
    assert written[names[1]](q, u).shape == (2, 2) and written[names[4]](q).shape == (6, 2, 2)
    header = program.to_c(*names[:2]).header
    assert "/* q[2] -> jacobian_of_tool_0[6][2] */" in header
    assert "double *jacobian_rate_of_upper_vx_vy)" in header
    with pytest.raises(fb.FreebodyError, match="both written as jacobian_of_fore_vx_vy"):
        program.to_c("jacobian of fore: vx vy", "jacobian of fore: vx,vy")
    with pytest.raises(fb.FreebodyError, match="singular one in state 1"):
        program.operational_inertia("tool: 0", [[0.1, 0.5], [0.0, 0.0]], components="vx vy")


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda p: p.jacobian("bose", [0.0]), "Unknown body 'bose'"),
        (lambda p: p.operational_inertia("bob", [0.0]), "move in 6 components for the operational space, got 1 speeds"),
        (lambda p: p.operational_inertia("bob", [0.0], components="vx vx"), "each once, got 'vx vx'"),
        (lambda p: p.operational_bias("bob", [0.0], [0.0], components=""), "Expected at least one of the components"),
        (lambda p: p.to_numpy("mass_matrix of bob"), "Expected a product of a point, got 'mass_matrix'"),
        (lambda p: p.derivative("jacobian_rate", "q"), "Expected point= together with one of jacobian, jacobian_rate"),
    ],
)  # fmt: skip
def test_errors(call, text):
    s = fb.System("pendulum")
    s.hinge("pin", s.ground, s.body("bob", fb.particle(1)), to=(0, 1, 0), axis="z")
    with pytest.raises(fb.FreebodyError, match=re.escape(text)):
        call(fb.compile(s))


def test_the_ground_has_no_inertia():
    s = fb.System("pendulum")
    s.hinge("pin", s.ground, s.body("bob", fb.particle(1)), to=(0, 1, 0), axis="z")
    with pytest.raises(fb.FreebodyError, match="got a point of the ground"):
        fb.compile(s).operational_inertia(s.ground.point(1, 0, 0), [0.0], components="vx")
