"""Robots that are written as URDF and MJCF: the same machine when read again, here, by Pinocchio and by MuJoCo."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.testing.machines import random_system
from sampled import sampled

STATES = 3
MOTIONS = ("hinge", "slider", "cylindrical", "universal", "gimbal", "planar", "weld")
KINDS = {"urdf": (*MOTIONS, "free"), "xml": (*MOTIONS, "ball")}
"""Joints that each format has, at any place of both bodies."""


def again(s: fb.System, folder: Path, ending: str, **options: Any) -> fb.System:
    """Write a system and read it."""
    path = folder / f"machine.{ending}"
    fb.write(s, path)
    return fb.read(path, symbols="none", meshes=False, **options)


def random_values(s: fb.System, random: Any) -> dict[str, float]:
    """Random values of coordinates and speeds by name, with unit quaternions."""
    model = fb.assemble(s)
    values = {name: random.uniform(-1, 1) for name in (*model.coordinate_names, *model.speed_names)}
    for name in model.coordinate_names:
        if name.endswith("_e0"):
            four = [f"{name[:-1]}{i}" for i in range(4)]
            length = np.linalg.norm([values[x] for x in four])
            values.update({x: values[x] / length for x in four})
    return values


def difference(
    s: fb.System, other: fb.System, names: dict[str, str] | None = None, poses: bool = True
) -> float:
    """Largest relative difference of M, bias, accelerations and poses at random states; ``names`` from s to other."""
    random, worst = np.random.default_rng(5), 0.0
    renamed = names or {}
    models, programs = [fb.assemble(one) for one in (s, other)], [fb.compile(one) for one in (s, other)]
    order = [list(models[1].speed_names).index(renamed.get(name, name)) for name in models[0].speed_names]
    for _ in range(STATES):
        values = random_values(s, random)
        named = {renamed.get(name, name): value for name, value in values.items()}
        found = []
        for model, program, given in zip(models, programs, (values, named), strict=True):
            q = np.array([given[name] for name in model.coordinate_names])
            u = np.array([given[name] for name in model.speed_names])
            found.append(
                [program.mass_matrix(q), program.bias(q, u), program.forward_dynamics(q, u), program.poses(q)]
            )
        (M, h, a, X), (N, k, b, Y) = found
        M_n, h_n, a_n = N[np.ix_(order, order)], k[order], b[order]
        condition = np.linalg.cond(M)
        worst = max(
            worst, abs(M - M_n).max() / abs(M).max(), abs(h - h_n).max() / (abs(h).max() + abs(M).max())
        )
        worst = max(worst, abs(a - a_n).max() / (1 + abs(a).max()) / condition)
        for body, (R, p) in X.items() if poses else ():
            T, r = Y[body] if body in Y else carried(other, Y, body)
            worst = max(worst, abs(R - T).max(), abs(p - r).max() / (1 + abs(p).max()))
    return worst


def carried(s: fb.System, poses: Any, body: str) -> Any:
    """Pose of a body that is part of another."""
    point, axes = s.reading.frames[body]
    R, p = (np.eye(3), np.zeros(3)) if point.body.is_ground else poses[point.body.name]
    return R @ np.array(axes, float), p + R @ np.array(point.components, float)


@pytest.mark.parametrize("seed", sampled(range(6), 3))
@pytest.mark.parametrize("ending", KINDS)
def test_a_random_tree_is_the_same_when_it_is_read_again(tmp_path, seed, ending):
    s = random_system(seed, 5, KINDS[ending], loads=False)
    s.gravity = (0, 0, -9.81)
    other = again(s, tmp_path, ending)
    assert (
        difference(s, other, poses=ending == "xml" and not any(j.type == "ball" for j in s.joints.values()))
        < 1e-13
    )


def forces(s: fb.System) -> None:
    """Give the joints of a random machine what both formats hold."""
    for i, joint in enumerate(s.joints.values()):
        for k, primitive in enumerate(joint.primitives):
            if primitive.displaces:
                s.spring(f"k{i}{k}", joint, stiffness=2.5 + k, rest=0.1, coordinate=k)
                s.damper(f"c{i}{k}", joint, damping=0.4 + i, coordinate=k)


@pytest.mark.parametrize("seed", sampled(range(4), 4))
@pytest.mark.parametrize("ending", KINDS)
def test_springs_and_dampers_along_joints_are_the_same(tmp_path, seed, ending):
    s = random_system(seed + 20, 4, KINDS[ending], loads=False)
    s.gravity = (0, 0, -9.81)
    forces(s)
    assert difference(s, again(s, tmp_path, ending), poses=False) < 1e-13


@pytest.mark.parametrize("seed", sampled(range(4), 4))
def test_armature_is_the_same(tmp_path, seed):
    s = random_system(
        seed + 30, 4, ("universal", "ball", "cylindrical", "planar"), loads=False, armature=True
    )
    assert difference(s, again(s, tmp_path, "xml"), poses=False) < 1e-13


def arm(**coordinates: Any) -> tuple[fb.System, Any, Any]:
    """Two links with a hinge and a slider of these coordinates."""
    s = fb.System("arm")
    s.gravity = (0, 0, -9.81)
    upper, lower = s.body("upper", fb.box(2, (0.1, 0.2, 1))), s.body("lower", fb.cylinder(1, 0.1, 0.5))
    s.coordinates("q r" if "r" in coordinates.get("two", "r") else "q")
    one = s.hinge("turn", s.ground, upper, to=(0, 0, 0.5), axis="y", coordinate=coordinates.get("one", "q"))
    axes = fb.Rotation.axis_angle("x", "pi/3")
    two = s.slider(
        "slide",
        upper,
        lower,
        at=(0, 0, -0.5),
        axis=(1, 2, 2),
        parent_axes=axes,
        coordinate=coordinates.get("two", "r"),
    )
    return s, one, two


NAMES = {"q": "turn", "q'": "turn'", "r": "slide", "r'": "slide'"}


@pytest.mark.parametrize("ending", KINDS)
@pytest.mark.parametrize("two", ["r", "-r", "r - 0.3", "0.2 - r"])
def test_a_displacement_of_either_sign_and_zero_keeps_its_coordinate(tmp_path, ending, two):
    s, one, slide = arm(one="1 - q", two=two)
    s.spring("k", slide, stiffness=3, rest=0.4)
    s.spring("k2", slide, stiffness=2, rest=-0.1)
    s.spring("twist", one, stiffness=7, rest=0.2)
    s.stop("ends", slide, low=-0.5, high=0.75)
    s.stop("side", one, high=0.25)
    s.friction("dry", one, torque=0.3)
    other = again(s, tmp_path, ending, limits=True, friction=True)
    assert difference(s, other, NAMES, poses=False) < 1e-14
    for values in ({"q": 0.3, "r": -0.2}, {"q": 1.0, "r": 0.6}):
        gaps = sorted(gap_values(s, values))
        assert gaps == pytest.approx(
            sorted(gap_values(other, {NAMES[k]: x for k, x in values.items()})), abs=1e-14
        )
    friction = next(gap for gap in other.contacts.values() if gap.kind == "joint_friction")
    assert float(friction.friction) == 0.3 and friction.joint.name == "turn"


def gap_values(s: fb.System, values: dict[str, float]) -> list[float]:
    """Distances to the stops."""
    result = []
    for gap in s.contacts.values():
        if gap.kind == "stop":
            y = s.expression(gap.joint.primitives[0].coordinate)
            y = float(y.subs({s.expression(name): value for name, value in values.items()}))
            result += [
                sign * (y - float(end)) for sign, end in ((1, gap.low), (-1, gap.high)) if end is not None
            ]
    return result


def test_a_joint_that_follows_another_mimics_it_in_urdf(tmp_path):
    s, *_ = arm(two="0.5*q - 0.1")
    assert difference(s, again(s, tmp_path, "urdf"), NAMES, poses=False) < 1e-14


@pytest.mark.parametrize("two", ["0.5*q - 0.1", "q^2/2 + q^3"])
def test_a_joint_that_follows_another_is_an_equality_in_mjcf(tmp_path, two):
    s, *_ = arm(one="q - 0.2", two=two)
    other = again(s, tmp_path, "xml")
    q, u = 0.7, 1.3
    slide, rate = (
        float(s.expression(two).diff(s.expression("q"), k).subs({s.expression("q"): q})) for k in (0, 1)
    )
    one, two = fb.compile(s), fb.compile(other, at=[q, slide])
    a = one.forward_dynamics([q], [u])
    b = two.forward_dynamics([q, slide], [u, rate * u])
    assert b[0] == pytest.approx(a[0], abs=1e-12 * (1 + abs(a[0])))


def at(program: Any, s: fb.System, state: dict[str, float], **options: Any) -> np.ndarray:
    """Accelerations, in the order of the system's speeds."""
    model = fb.assemble(s)
    q = np.array([state[name] for name in model.coordinate_names])
    u = np.array([state[name] for name in model.speed_names])
    return program.forward_dynamics(q, u, **options)


def four_bar(kind: str) -> fb.System:
    """A crank, a coupler and a rocker, the last joint of which closes the loop."""
    s = fb.System("four-bar")
    s.gravity = (0, 0, -9.81)
    crank, coupler, rocker = (
        s.body(name, fb.box(1, (0.1, 0.2, 1))) for name in ("crank", "coupler", "rocker")
    )
    s.hinge("a", s.ground, crank, to=(0, 0, -0.5), axis="y", coordinate="a")
    s.hinge("b", crank, coupler, at=(0, 0, 0.5), to=(0, 0, -0.5), axis="y", coordinate="b")
    s.hinge("d", s.ground, rocker, at=(1, 0, 0), to=(0, 0, -0.5), axis="y", coordinate="d")
    if kind == "ball":
        s.ball("c", coupler, rocker, at=(0, 0, 0.5), to=(0, 0, 0.5))
    else:
        s.hinge("c", coupler, rocker, at=(0, 0, 0.5), to=(0, 0, 0.5), axis="y")
    return s


@pytest.mark.parametrize("kind", ["ball", "hinge"])
def test_a_closed_loop_is_the_same_in_mjcf(tmp_path, kind):
    s = four_bar(kind)
    other = again(s, tmp_path, "xml")
    motions = [
        fb.simulate(one, 0.5, initial={"a": 0.3, "a'": 1}, near={"b": 1.2, "d": 0.5}, tolerance=1e-11)
        for one in (s, other)
    ]
    for name in ("a", "b", "d"):
        assert motions[1][name][-1] == pytest.approx(motions[0][name][-1], abs=1e-9)
    assert 'connect name="c"' in (tmp_path / "machine.xml").read_text()


def test_a_weld_that_closes_a_loop_is_the_same_in_mjcf(tmp_path):
    s, *_ = arm()
    tip = s.body("tip", fb.sphere(1, 0.1))
    turn = fb.Rotation.axis_angle("z", 0.4)
    s.free("air", s.ground, tip)
    s.weld("glue", s.bodies["lower"], tip, at=(0.1, 0, 0.3), parent_axes=turn)
    other = again(s, tmp_path, "xml")
    poses = [one.joints["glue"] for one in (s, other)]
    for one, two in ((poses[0].at, poses[1].at), (poses[0].to, poses[1].to)):
        assert np.allclose(np.array(one, float), np.array(two, float), atol=1e-15)
    R, S = (np.array(one.parent_axes, float) @ np.array(one.child_axes, float).T for one in poses)
    assert np.allclose(R, S, atol=1e-15)


@pytest.mark.parametrize("condition", ["r - q^2 + 0.3*q", "2*r + q", "r - 0.2", "q^4 - r/3 + 1"])
def test_constraints_of_two_joints_are_equalities(tmp_path, condition):
    s, *_ = arm(one="q - 0.4", two="r + 0.2")
    s.constrain(condition, name="cam")
    other = again(s, tmp_path, "xml")
    rows = [conditions(one, {"q": 0.3, "r": 0.7}, NAMES if one is other else {}) for one in (s, other)]
    assert abs(np.cross(*rows)).max() < 1e-13 * np.prod([abs(row).max() for row in rows])


def conditions(s: fb.System, values: dict[str, float], names: dict[str, str]) -> np.ndarray:
    """Value and slopes of the only constraint; parallel for the same condition, so that value/slope is compared too."""
    (condition,) = s.constraints.values()
    atoms = {s.expression(names.get(name, name)): value for name, value in values.items()}
    slopes = [float(condition.expression.diff(atom).subs(atoms)) for atom in atoms]
    return np.array([float(condition.expression.subs(atoms)), *slopes])


def test_a_gear_and_a_condition_of_three_joints_are_equalities(tmp_path):
    s = fb.System("gears")
    s.coordinates("j0 j1 j2")
    bodies = [s.body(f"wheel{i}", fb.cylinder(1 + i, 0.1, 0.1, axis="y")) for i in range(3)]
    one, two, three = (
        s.hinge(f"j{i}", s.ground, body, at=(i, 0, 0), axis="y", coordinate=f"j{i} - 0.{i}")
        for i, body in enumerate(bodies)
    )
    s.gear(one, two, "-3/2", name="teeth")
    s.constrain("j0 + 2*j1 - j2/2 + 0.7", name="sum")
    other = again(s, tmp_path, "xml")
    s.torsion_spring("k", three, stiffness=2)
    other.torsion_spring("k", other.joints["j2"], stiffness=2)
    # where both hold: j0 = -3/2 (j1 - 0.1), j2 = 2 (j0 + 2 j1 + 0.7)
    j1, v1 = 0.3, 0.4
    j0, v0 = -1.5 * (j1 - 0.1), -1.5 * v1
    state = [j0, j1, 2 * (j0 + 2 * j1 + 0.7)], [v0, v1, 2 * (v0 + 2 * v1)]
    a, b = (fb.compile(one, at=state[0]) for one in (s, other))
    assert np.allclose(a.forward_dynamics(*state), b.forward_dynamics(*state), rtol=1e-12)
    assert "<tendon" in (tmp_path / "machine.xml").read_text()


MOTORS = {
    "plain": "20*u", "position": "2*(30*u - 30*(2*q - 1)) - q'", "constant": "1.5 - 2*q", "command": "Max(-1, Min(2, u))",
    "force": "3*Max(-1, Min(1, 4*u - q))", "both": "3*Max(-1, Min(1, 4*Max(-0.5, Min(0.5, u)) - q'))",
}  # fmt: skip


@pytest.mark.parametrize(("law", "one"), sampled(itertools.product(MOTORS, ["q", "0.3 - q"]), 2))
def test_motors_are_the_same(tmp_path, law, one):
    s, turn, _ = arm(one=one)
    s.parameters(u=0)
    text = MOTORS[law].replace("Max", "max").replace("Min", "min")
    s.torque("drive", turn, text)
    s.generalized_force("r", 0.3, name="push")
    other = again(s, tmp_path, "xml")
    assert other.reading.inputs["drive"] == "u_drive"
    for u in (-2, 0.1, 0.4):
        values = {"q": 0.3, "r": 0.2, "q'": -0.5, "r'": 1.0}
        a = at(fb.compile(s), s, values, values={"u": u})
        b = at(fb.compile(other), other, {NAMES[k]: x for k, x in values.items()}, values={"u_drive": u})
        assert np.allclose(a, b, rtol=1e-12)


@pytest.mark.parametrize("kind", ["ball", "free"])
def test_springs_and_damping_of_ball_and_free_joints_are_the_same(tmp_path, kind):
    s = fb.System("air")
    body = s.body("body", fb.box(2, (0.1, 0.2, 0.4)))
    getattr(s, kind)(
        "j", s.ground, body, **({"at": (1, 2, 3)} if kind == "ball" else {"to": (0.1, 0.2, 0.3)})
    )
    d = s.parameters(d=0.7)
    s.damper("turning", s.joints["j"], damping=d)
    if kind == "ball":
        s.torsion_spring("spring", s.joints["j"], stiffness=3)
    if kind == "free":
        s.force(
            "sliding", body.point(0.1, 0.2, 0.3), [-d * s.expression(f"j_v{x}") for x in "xyz"], frame=body
        )
    other = again(s, tmp_path, "xml")
    assert difference(s, other, poses=False) < 1e-14 and len(other.loads) == len(s.loads)


LENGTH = {"q": "left", "q'": "left'", "r": "right", "r'": "right'"}


@pytest.mark.parametrize("law", ["2*u - 3*(L - 1/5) - R/2", "max(-2, min(3, 4*u - L))", "u", "-5*L"])
def test_forces_along_a_length_of_several_coordinates_are_a_tendon(tmp_path, law):
    s = fb.System("fins")
    s.parameters(u=0)
    body = s.body("body", fb.box(2, (0.1, 0.2, 0.4)))
    s.hinge("left", s.ground, body, coordinate="q", to=(0.3, 0, 0))
    s.hinge(
        "right", body, s.body("fin", fb.box(1, (0.1, 0.2, 0.4))), coordinate="r", to=(0, 0.3, 0), axis="x"
    )
    text = law.replace("L", "(q - 3*r/2)").replace("R", "(q' - 3*r'/2)")
    s.generalized_force("q", text, name="one")
    s.generalized_force("r", f"-3/2*({text})", name="two")
    other = again(s, tmp_path, "xml")
    assert (tmp_path / "machine.xml").read_text().count("<fixed") == 1
    values = {"q": 0.3, "r": 0.2, "q'": -0.5, "r'": 1.0}
    control = other.reading.inputs["one"]
    a = at(fb.compile(s), s, values, values={"u": 0.7})
    b = at(fb.compile(other), other, {LENGTH[k]: x for k, x in values.items()}, values={control: 0.7})
    assert np.allclose(a, b, rtol=1e-12)


def test_motions_of_a_joint_have_the_names_of_their_coordinates(tmp_path):
    s = fb.System("hopper")
    body = s.body("body", fb.box(2, (0.1, 0.2, 0.4)))
    x, z = s.coordinates("x z")
    s.chain(
        "root", s.ground, body, [fb.Slider("x", x), fb.Slider("z", sympy.Rational(5, 4) - z), fb.Hinge("y")]
    )
    other = again(s, tmp_path, "xml")
    assert fb.assemble(other).coordinate_names == ("x", "z", "root_3") and difference(s, other) < 1e-14


def test_a_motor_and_a_rotor_on_the_ground_are_the_same(tmp_path):
    s = fb.System("crane")
    s.gravity = (0, 0, -9.81)
    body = s.body("boom", fb.box(2, (0.1, 0.2, 1)))
    pin = s.hinge("pin", s.ground, body, to=(0, 0, 0.5), axis="y", rotor=fb.Rotor("1e-3", ratio=20))
    s.motor("drive", pin, stall_torque=0.5, no_load_speed=30, ratio=15, inertia="2e-3")
    assert difference(s, again(s, tmp_path, "xml")) < 1e-14


# -- peers ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", sampled(range(4), 2))
def test_mujoco_compiles_what_is_written_and_agrees(tmp_path, seed):
    pytest.importorskip("mujoco")
    peer = pytest.importorskip("benchmarks.mujoco_peer", reason="benchmarks are not in the package")
    s = random_system(seed + 40, 5, KINDS["xml"], loads=False)
    forces(s)
    floating = s.body("floating", fb.box(2, (0.1, 0.2, 0.4)))
    s.free("air", s.ground, floating, to=(0.1, 0.2, 0.3), child_axes=fb.Rotation.axis_angle((1, 2, 2), 0.7))
    s.hinge(
        "rider", floating, s.body("light", fb.sphere(1, 0.2)), at=(1, 0, 0), to=(0, 0.5, 0), axis=(1, 1, 0)
    )
    path = tmp_path / "machine.xml"
    fb.write(s, path)
    outcome, found = peer.compared(path)
    assert outcome == "compared" and (found.differences < 1e-13).all(), found


def test_mujoco_closes_the_loops_that_are_written(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    path = tmp_path / "machine.xml"
    fb.write(four_bar("hinge"), path)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    s = four_bar("hinge")
    start = fb.simulate(s, 0.01, initial={"a": 0.3}, near={"b": 1.2, "d": 0.5})
    data.qpos[:] = [float(start[name][0]) for name in ("a", "b", "d")]
    mujoco.mj_forward(model, data)
    names = [model.site(i).name for i in range(model.nsite)]
    ends = {name: data.site_xpos[i] for i, name in enumerate(names)}
    assert len(names) == 4
    for first in [name for name in names if name.endswith("_1")]:
        assert np.allclose(ends[first], ends[first[:-1] + "2"], atol=1e-9)


@pytest.mark.parametrize("seed", sampled(range(4), 2))
def test_pinocchio_reads_what_is_written_and_agrees(tmp_path, seed):
    pinocchio = pytest.importorskip("pinocchio")
    s = random_system(seed + 50, 5, MOTIONS, loads=False)
    s.gravity = (0, 0, -9.81)
    path = tmp_path / "machine.urdf"
    fb.write(s, path)
    model = pinocchio.buildModelFromUrdf(str(path))
    data, program, own = model.createData(), fb.compile(s), fb.assemble(s)
    values = random_values(s, np.random.default_rng(seed))
    q, v = pinocchio.neutral(model), np.zeros(model.nv)
    order = []
    for joint, name in zip(model.joints[1:], list(model.names)[1:], strict=True):
        angle, rate = values[name], values[f"{name}'"]
        q[joint.idx_q : joint.idx_q + joint.nq] = angle if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        v[joint.idx_v] = rate
        order.append((joint.idx_v, list(own.speed_names).index(f"{name}'")))
    theirs, ours = zip(*order, strict=True)
    ours_q = np.array([values[name] for name in own.coordinate_names])
    ours_u = np.array([values[name] for name in own.speed_names])
    M = pinocchio.crba(model, data, q)
    M = np.triu(M) + np.triu(M, 1).T
    h = pinocchio.nonLinearEffects(model, data, q, v)
    N, k = program.mass_matrix(ours_q), program.bias(ours_q, ours_u)
    assert abs(M[np.ix_(theirs, theirs)] - N[np.ix_(ours, ours)]).max() < 1e-13 * abs(M).max()
    assert abs(h[list(theirs)] - k[list(ours)]).max() < 1e-13 * (abs(h).max() + abs(M).max())


# -- contacts, looks, names -----------------------------------------------------------------------------


def touching(feature: Any, **laws: Any) -> fb.System:
    """A free body with a shape that may touch a plane."""
    s = fb.System("drop")
    s.gravity = (0, 0, -9.81)
    body = s.body("body", fb.box(2, (0.4, 0.2, 0.1)))
    s.free("air", s.ground, body)
    shapes = feature(body)
    for i, shape in enumerate(shapes if isinstance(shapes, list) else [shapes]):
        s.contact(f"touch{i}", shape, s.ground.plane(at=(0, 0, -0.1), normal=(0, 0.6, 0.8)), **laws)
    return s


SHAPES = {
    "sphere": lambda body: body.sphere(0.1, at=(0.2, 0, 0)),
    "capsule": lambda body: body.capsule((0, 0, -0.1), (0.2, 0.1, 0.1), 0.05),
    "ellipsoid": lambda body: body.ellipsoid((0.3, 0.2, 0.1), at=(0, 0.1, 0)),
    "box": lambda body: body.corners(size=(0.4, 0.2, 0.1), at=(0.1, 0, 0)),
    "hull": lambda body: body.corners((0.5, 0, 0), (0, 0.25, 0), (0, 0, 0.5), (-0.25, -0.25, -0.5)),
    "cylinder": lambda body: [body.drum(0.2, 0.4, at=(0, 0.1, 0.1), axis="y")],
}  # fmt: skip


@pytest.mark.parametrize(("shape", "friction"), [*((shape, 0.3) for shape in SHAPES), ("sphere", 0)])
def test_shapes_that_touch_a_plane_touch_it_again(tmp_path, shape, friction):
    s = touching(SHAPES[shape], friction=friction)
    other = again(s, tmp_path, "xml", contacts="floor")
    assert {float(x.friction) for x in other.contacts.values()} == {friction}
    start = {"air_z": 0.6, "air_wx": 1.0, "air_wy": 2.0, "air_vx": 0.4}
    one, two = (fb.simulate(x, 0.6, initial=start, tolerance=1e-10).events for x in (s, other))
    assert len(one) and one[0].time == pytest.approx(two[0].time, abs=1e-9), (one, two)


def test_solids_and_colours_are_drawn_again(tmp_path):
    s = fb.System("looks")
    s.gravity = (0, 0, -9.81)
    s.scenery = fb.box(1, (2, 2, 0.1))
    box = s.body("box", fb.box(2, (0.1, 0.2, 0.3)).moved((0, 0, 1)), color="#0072b2")
    rod = s.body("rod", fb.cylinder(1, 0.1, 0.5, axis="y"))
    ball = s.body("ball", fb.sphere(1, 0.2) + fb.sphere(1, 0.1).moved((0.3, 0, 0)))
    for body in (box, rod, ball):
        s.free(f"air_{body.name}", s.ground, body)
    for ending in KINDS:
        path = tmp_path / f"looks.{ending}"
        fb.write(s, path)
        other = fb.read(path, symbols="none")
        shapes = {name: body.mass_properties.shape for name, body in other.bodies.items()}
        assert dict(shapes["box"].dimensions) == {"x": 0.1, "y": 0.2, "z": 0.3}
        assert tuple(shapes["box"].center) == (0, 0, 1) and shapes["box"].color == "#0072b2"
        axis = np.array(shapes["rod"].axes, float) @ np.array(shapes["rod"].axis, float)
        assert abs(axis) == pytest.approx([0, 1, 0], abs=1e-15)
        assert len(shapes["ball"].parts) == 2 and dict(other.scenery.dimensions)["z"] == 0.1


def test_numbers_are_the_defaults_and_the_values_that_are_given(tmp_path):
    s = fb.System("ball")
    m, r = s.parameters("m", r=0.1)
    s.free("air", s.ground, s.body("ball", fb.sphere(m, r)))
    with pytest.raises(fb.errors.FormatError) as caught:
        fb.write(s, tmp_path / "ball.xml")
    assert str(caught.value) == (
        "An MJCF file cannot hold all of 'ball'. the mass properties of body 'ball': 'm' has no value; give it one, "
        "values={'m': ...} or s.parameters(m=...). A .toml file can."
    )
    fb.write(s, tmp_path / "ball.xml", values={"m": 2})
    assert fb.read(tmp_path / "ball.xml", symbols="none").bodies["ball"].mass_properties.mass == 2


# -- refusals -------------------------------------------------------------------------------------------


def moving(s: fb.System, name: str = "body", **joint: Any) -> Any:
    """A box on a hinge."""
    body = s.body(name, fb.box(1, (0.1, 0.2, 0.3)))
    return body, s.hinge(f"{name}_pin", s.ground, body, axis="y", **joint)


def on_ground(s: fb.System) -> Any:
    return s.body("body", fb.box(1, (0.1, 0.2, 0.3)))


def loop(s: fb.System) -> None:
    body, _ = moving(s)
    s.slider("rail", s.ground, body)


REFUSED: dict[str, tuple[str, Any, str]] = {
    "gravity": ("urdf", lambda s: setattr(s, "gravity", (0, -9.81, 0)), "gravity (0, -9.81, 0): the format has none, and what reads it takes 9.81 against z; set s.gravity = (0, 0, -9.81)"),
    "ball": ("urdf", lambda s: s.ball("j", s.ground, on_ground(s)), "ball 'j': the format has no ball joint; use a gimbal, or write a .xml file (MJCF)"),
    "stop of a free joint": ("xml", lambda s: s.stop("wall", s.free("j", s.ground, on_ground(s)), high=1), "stop 'wall': in the format a free joint has no limits"),
    "friction of a free joint": ("xml", lambda s: s.friction("dry", s.free("j", s.ground, on_ground(s)), torque=1), "friction 'dry': in the format the friction of a free joint resists turns and displacements up to the same number"),
    "restitution of a ball": ("xml", lambda s: s.stop("wall", s.ball("j", s.ground, on_ground(s)), high=1, restitution=0.5), "stop 'wall': its restitution; limits do not rebound, leave out restitution="),
    "hinge after a ball": ("xml", lambda s: s.chain("j", s.ground, on_ground(s), [fb.Ball(), fb.Hinge("x", at=(0, 0, 1))]), "chain 'j': MuJoCo takes no turn after a ball in one body; put a body between them"),
    "stop of a ball": ("urdf", lambda s: s.stop("wall", s.ball("j", s.ground, on_ground(s)), high=1), "ball 'j': the format has no ball joint"),
    "family": ("xml", lambda s: s.contacts("pile", [on_ground(s).sphere(0.1)], against=[s.ground.plane(normal="z")]), "families of contacts stay in Python and in .toml files"),
    "screw": ("xml", lambda s: s.screw("j", s.ground, on_ground(s), pitch=0.1), "screw 'j': the format has no screw; write the drive as a hinge"),
    "path": ("xml", lambda s: s.path_joint("j", s.ground, on_ground(s), coordinate="x", position=("x", "x^2", 0)), "path joint 'j': the format has no joint by functions"),
    "armature": ("urdf", lambda s: moving(s, armature=2), "hinge 'body_pin': the format has no armature; add it to the inertia, or write a .xml file (MJCF)"),
    "values of armature": ("xml", lambda s: s.free("j", s.ground, on_ground(s), armature=(1, 2)), "free 'j': armature of several values; give it one number"),
    "rotor": ("xml", lambda s: s.hinge("j", moving(s)[0], s.body("b", fb.box(1, (1, 1, 1))), rotor=fb.Rotor(1, 2)), "hinge 'j': the spin of its rotor; armature= is its inertia along the joint alone"),
    "motor": ("xml", lambda s: s.motor("m", s.hinge("j", moving(s)[0], s.body("b", fb.box(1, (1, 1, 1)))), stall_torque=1, inertia=1), "motor 'm': the spin of its rotor; leave out inertia=, and give the joint armature="),
    "motor in URDF": ("urdf", lambda s: s.torque("m", moving(s)[1], 1), "torque 'm': the format has no motors; leave it out: a program that reads the file drives the joint"),
    "motor law": ("xml", lambda s: s.torque("m", moving(s)[1], "body_pin^2"), "torque 'm': a motor of the format is an affine function of one control (a parameter of value 0), of its coordinate and speed; got body_pin(t)**2"),
    "control": ("xml", lambda s: (s.parameters(u=0), s.torque("m", moving(s)[1], "u"), s.torque("n", moving(s, "b")[1], "u")), "torque 'n': it shares its control u with another; give each motor one of its own"),
    "coordinate": ("xml", lambda s: (s.coordinates("q"), moving(s, coordinate="2*q")), "hinge 'body_pin': its displacement is 2*q(t), but no joint has q itself; give one the coordinate q"),
    "angles": ("urdf", lambda s: (s.coordinates("p q"), moving(s, coordinate="p"), moving(s, "b", coordinate="q - p")), "hinge 'b_pin': its displacement -p(t) + q(t) is no function of one coordinate; give the joint its own"),
    "driven": ("xml", lambda s: moving(s, coordinate="0.1*t"), "is no function of one coordinate; give the joint its own"),
    "follower": ("urdf", lambda s: (s.coordinates("p"), moving(s, coordinate="p"), moving(s, "b", coordinate="p^2")), "hinge 'b_pin': its displacement is no linear function of another; write a .xml file (MJCF)"),
    "degree": ("xml", lambda s: (s.coordinates("p"), moving(s, coordinate="p"), moving(s, "b", coordinate="p^5")), "hinge 'b_pin': a polynomial of degree 5; the format has up to 4"),
    "free": ("xml", lambda s: s.free("j", s.ground, on_ground(s), at=(1, 0, 0)), "free 'j': a free joint of the format begins at the origin of the ground and has its axes; use s.free(name, s.ground, body) without at= and parent_axes="),
    "world": ("xml", lambda s: moving(s, "world"), "body 'world': the format calls the ground so; give the body another name"),
    "held": ("urdf", on_ground, "body 'body': no joint holds it; s.free lets it move freely"),
    "thin": ("xml", lambda s: s.hinge("j", s.ground, s.body("rod", fb.slender_bar(1, 1))), "body 'rod': MuJoCo moves no body without a mass and a moment of inertia about each axis; give it a thickness, such as fb.cylinder in place of fb.slender_bar, or fb.sphere in place of fb.particle"),
    "loop in URDF": ("urdf", lambda s: s.ball("j", s.ground, moving(s)[0]), "ball 'j': it closes a loop, and the format has trees; write a .xml file (MJCF)"),
    "loop": ("xml", loop, "slider 'rail': it closes a loop, which ball joints, hinges and welds can in the format; open the loop at another joint"),
    "spring": ("xml", lambda s: s.spring("k", s.ground.point(1, 0, 0), on_ground(s).point(0, 0, 0), stiffness=1), "spring 'k': the format has forces along joints only; keep it in Python or in a .toml file"),
    "spring in URDF": ("urdf", lambda s: s.spring("k", s.ground.point(1, 0, 0), on_ground(s).point(0, 0, 0), stiffness=1), "spring 'k': the format has no forces but those of joints; keep it in Python or in a .toml file"),
    "torque": ("xml", lambda s: s.torque("M", moving(s)[0], (1, 0, 0)), "torque 'M': the format has torques along joints only; use s.damper for the damping of a ball or free joint"),
    "drag": ("xml", lambda s: s.damper("d", s.free("j", s.ground, on_ground(s)), damping=2), "torsion damper 'd': a force other than the damping -d v of a free joint that has s.damper of the same d"),
    "free spring": ("xml", lambda s: s.torsion_spring("k", s.free("j", s.ground, on_ground(s)), stiffness=2), "torsion spring 'k': in the format the spring of a free joint acts along its displacement too"),
    "spring at rest elsewhere": ("xml", lambda s: s.torsion_spring("k", s.ball("j", s.ground, on_ground(s)), stiffness=2, rest=fb.Rotation.axis_angle((0, 0, 1), 1)), "torsion spring 'k': in the format it rests where the axes of the joint are parallel: turn parent_axes= of 'j' in place of rest="),
    "torsion in urdf": ("urdf", lambda s: s.damper("d", s.free("j", s.ground, on_ground(s)), damping=2), "torsion damper 'd': springs and dampers of the format act along one axis"),
    "other load": ("urdf", lambda s: s.drag("air", moving(s)[0], linear=1), "drag 'air': there is no such part in the format; leave it out"),
    "friction": ("xml", lambda s: s.friction("dry", moving(s)[1], torque=1, static=2), "friction 'dry': its static friction; leave out static="),
    "stop": ("xml", lambda s: s.stop("end", moving(s)[1], low=0, restitution=0.5), "stop 'end': its restitution; limits do not rebound, leave out restitution="),
    "speeds": ("xml", lambda s: (moving(s), moving(s, "b"), s.constrain_speed("body_pin' - b_pin'", name="c")), "speed condition 'c': the format has no conditions on speeds"),
    "one side": ("xml", lambda s: (moving(s), moving(s, "b"), s.constrain("body_pin - b_pin", name="c", unilateral=True)), "condition 'c': it acts to one side only; leave out unilateral=True"),
    "sine": ("xml", lambda s: (moving(s), moving(s, "b"), s.constrain("body_pin - sin(b_pin)", name="c")), "condition 'c': the format couples joints by polynomials of their coordinates only"),
    "product": ("xml", lambda s: (moving(s), moving(s, "b"), s.constrain("body_pin*b_pin - 1", name="c")), "condition 'c': the format couples two joints by a polynomial of one of them, or several linearly"),
    "constraint in URDF": ("urdf", lambda s: (moving(s), moving(s, "b"), s.constrain("body_pin - b_pin", name="c")), "condition 'c': the format has no constraints but a joint whose displacement is an expression"),
    "contact in URDF": ("urdf", lambda s: s.contact("c", moving(s)[0].sphere(0.1), s.ground.plane(normal="z")), "contact 'c': the format has shapes but no floor and no friction; write a .xml file (MJCF)"),
    "bodies": ("xml", lambda s: s.contact("c", moving(s)[0].sphere(0.1), moving(s, "b")[0].sphere(0.1)), "contact 'c': bodies of such a file touch planes of the ground; keep it in Python or in a .toml file"),
    "restitution": ("xml", lambda s: s.contact("c", moving(s)[0].sphere(0.1), s.ground.plane(), restitution=0.5), "contact 'c': its restitution; contacts of the format do not rebound, leave out restitution="),
    "static friction": ("xml", lambda s: s.contact("c", moving(s)[0].sphere(0.1), s.ground.plane(), friction=0.2, static_friction=0.5), "contact 'c': its static friction; leave out static_friction="),
    "circle": ("xml", lambda s: s.contact("c", moving(s)[0].circle(0.1), s.ground.plane()), "contact 'c': a circle of body 'body' is no shape of the format; use spheres, capsules, drums, ellipsoids, boxes or corners of a solid"),
    "point": ("xml", lambda s: s.contact("c", moving(s)[0].point(0, 0, 1), s.ground.plane()), "contact 'c': a point of body 'body' is no shape of the format; use spheres, capsules, drums, ellipsoids, boxes or corners of a solid"),
    "flat": ("xml", lambda s: s.contact("c", moving(s)[0].corners(size=(1, 1)), s.ground.plane()), "contact 'c': a flat mesh has no hull; give the corners of a solid, or spheres"),
    "controller": ("urdf", lambda s: (moving(s), s.parameters(u=0), s.controller(lambda t, x: 0.0, 0.1, "u", name="pid")), "'pid': controllers and signals stay in Python"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_a_format_cannot_say_is_refused_by_name(tmp_path, case):
    ending, build, message = REFUSED[case]
    s = fb.System("machine")
    s.gravity = (0, 0, -9.81)
    build(s)
    path = tmp_path / f"machine.{ending}"
    with pytest.raises(fb.errors.FormatError) as caught:
        fb.write(s, path)
    assert message in str(caught.value) and not path.exists()


def test_a_family_and_several_parts_are_refused_together(tmp_path):
    s = fb.System("dice")
    s.gravity = (0, 0, -9.81)
    for i in range(2):
        body = s.body(f"die{i}", fb.box(1, (0.1, 0.1, 0.1)))
        s.free(f"air{i}", s.ground, body)
    s.contacts("heap", [body.box((0.1, 0.1, 0.1)) for body in s.bodies.values()])
    s.force("wind", s.bodies["die0"].point(0, 0, 0), (1, 0, 0))
    with pytest.raises(fb.errors.FormatError) as caught:
        fb.write(s, tmp_path / "dice.xml")
    text = str(caught.value)
    assert text.count("'heap'") == text.count("'wind'") == 1 and text.endswith("A .toml file can.")


def test_a_tree_is_written_as_deep_as_readers_take_it(tmp_path):
    def chain(n: int) -> fb.System:
        s = fb.System("chain")
        s.gravity = (0, 0, -9.81)
        parent = s.ground
        for i in range(n):
            body = s.body(f"b{i}", fb.box(1, (0.1, 0.1, 0.1)))
            s.hinge(f"j{i}", parent, body, axis="y", at=(0, 0, -1))
            parent = body
        return s

    assert len(again(chain(196), tmp_path, "xml").bodies) == 196
    with pytest.raises(fb.errors.FormatError, match="the tree: it has more than 196 bodies one in the other"):
        fb.write(chain(197), tmp_path / "deep.xml")
    assert len(again(chain(197), tmp_path, "urdf").bodies) == 197


def test_options_of_one_format_are_not_taken_for_another(tmp_path):
    s = fb.System("machine")
    s.gravity = (0, 0, -9.81)
    moving(s)
    with pytest.raises(
        fb.errors.FormatError, match=r"m.urdf: initial= is for .toml files; a robot's file has no run."
    ):
        fb.write(s, tmp_path / "m.urdf", initial={"body_pin": 1})
    with pytest.raises(
        fb.errors.FormatError, match=r"m.toml: values= is for robots' files; a .toml file keeps"
    ):
        fb.write(s, tmp_path / "m.toml", values={"m": 1})
    with pytest.raises(fb.errors.FormatError, match=r"Unknown parameter 'x' in values=; "):
        fb.write(s, tmp_path / "m.xml", values={"x": 1})
    s.parameters(m=1)
    with pytest.raises(fb.errors.FormatError, match="Expected a number for 'm' in values=, got m/2"):
        fb.write(s, tmp_path / "m.xml", values={"m": s.expression("m/2")})
    with pytest.raises(
        fb.errors.ExpressionError, match="In the value of .m.: Expected a finite number, got inf"
    ):
        fb.write(s, tmp_path / "m.xml", values={"m": float("inf")})
    with pytest.raises(fb.errors.FormatError, match="Expected a System to write, got 3"):
        fb.write(3, tmp_path / "m.xml")  # type: ignore[arg-type]
