"""Families of contacts have the laws of single contacts: the same motion, by events and in steps; momentum stays."""

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

import freebody as fb
from freebody.cli import command as program
from freebody.errors import ModelError, SimulationError
from freebody.exact import rolling_ball, spinning_ball

G, R = 9.81, 0.1


def ball(family, space, floor="plane", **laws):
    s = fb.System("ball")
    s.parameters(d=0.01, ds=0.004, mu=0.4)
    body = s.body("ball", fb.sphere(1, R))
    s.gravity = (0, 0, -G) if space else (0, -G, 0)
    if space:
        s.free("f", s.ground, body)
    else:
        s.planar("f", s.ground, body, coordinate="x y turn")
    surface = s.ground.plane(normal="z" if space else "y")
    if floor == "box":
        surface = s.ground.box((4, 4, 0.2), at=(0, 0, -0.1))
    shapes, laws = (body.sphere(R), surface), {"friction": "mu"} | laws
    if family:
        s.contacts("floor", shapes[:1], against=surface, **laws)
    else:
        s.contact("floor", *shapes, **laws)
    start = {"f_z": R, "f_vx": 1.0, "f_vy": 0.3, "f_wz": 5.0, "f_wx": 3.0}
    return s, start if space else {"y": R, "x'": 1.0, "turn'": 3.0}


def axes_of(at, joint):
    """R_NB of a body on a free joint."""
    w, x, y, z = (at[f"{joint}_e{k}"] for k in range(4))
    return Rotation.from_quat([x, y, z, w]).as_matrix()


LAWS = (
    (True, {"rolling": "d", "spinning": "ds", "restitution": 0.3}),
    (False, {"rolling": "d", "adhesion": 3.0}),
    pytest.param(True, {"adhesion": 3.0, "spinning": "ds"}, marks=pytest.mark.slow),
    (True, {"normal": "1e4*depth**1.5*(1 + rate/5)", "rolling": "d"}),
    (True, {"friction": ("mu", "mu/2"), "along": (0.6, 0.8, 0), "restitution": 0.3}),
    pytest.param(False, {"normal": "1e3*depth*t"}, marks=pytest.mark.slow),
    pytest.param(True, {"friction": ("mu", "2*mu"), "along": "y", "rolling": "d"}, marks=pytest.mark.slow),
    (False, {"static_friction": "1.5*mu", "rolling": "d"}),
    (False, {"impact": "poisson", "restitution": 0.5}),
)
STEPPED = LAWS[:7]


@pytest.mark.parametrize(("space", "laws"), LAWS)
def test_a_family_of_one_pair_moves_as_the_contact_by_events(space, laws):
    one, other = (
        fb.simulate(s, 1.2, initial=start, samples=7)
        for s, start in (ball(family, space, **laws) for family in (False, True))
    )
    assert (one.states == other.states).all()
    assert [str(x).replace("[ball,ground]", "") for x in other.modes] == [str(x) for x in one.modes]


@pytest.mark.parametrize(("space", "laws"), STEPPED)
def test_a_family_of_one_pair_moves_as_the_contact_in_steps(space, laws):
    found = []
    for family in (False, True):
        s, start = ball(family, space, **laws)
        motion = fb.simulate(s, 1.2, initial=start, samples=7, method="timestepping", step=2e-3)
        found.append(motion)
        assert motion.energy.relative_residual < 1e-12
    one, other = found
    assert np.abs(one.states - other.states).max() < 1e-10  # a hundred times the residual of 600 steps
    for about in ("", "_rolling", "_spinning"):
        if about == "" or about[1:] in laws:
            a, b = one.contacts[f"floor{about}"], other.contacts[f"floor[ball,ground]{about}"]
            assert (a.mode == b.mode).all()
            size = 1 + np.abs(a.tangential).max()
            assert (
                np.abs(a.tangential - b.tangential).max() < 1e-7 * size
            )  # impulses of the residual over a step
            assert np.abs(a.normal - b.normal).max() < 1e-7 * G and np.abs(a.slip - b.slip).max() < 1e-9


@pytest.mark.parametrize("floor", ["plane", pytest.param("box", marks=pytest.mark.slow)])
@pytest.mark.parametrize("options", [{}, {"method": "timestepping", "step": 2e-3}])
def test_a_ball_of_a_family_rolls_and_spins_to_rest(floor, options):
    """v' = -5/7 g δ/R and ω' = -5/2 g δ_n/R², on a plane and on a solid."""
    s, _ = ball(True, True, floor, rolling="d", spinning="ds")
    start = {"f_z": R, "f_vx": 0.3, "f_wy": 3.0, "f_wz": 4.0}
    motion = fb.simulate(s, 1.0, initial=start, samples=41, **options)
    rolls, spins = rolling_ball(0.3, R, 0.01, G), spinning_ball(4.0, R, 0.004, G)
    allowed = 10 * options["step"] ** 2 if options else 1e-6  # attitudes are of second order in a step
    for t in motion.t:
        at = motion.at(t)
        v = (axes_of(at, "f") @ [at[f"f_v{x}"] for x in "xyz"])[0]
        w = (axes_of(at, "f") @ [at[f"f_w{x}"] for x in "xyz"])[2]
        for found, first, law in ((v, 0.3, rolls), (w, 4.0, spins)):
            if abs(t - law.time) > 0.01:
                assert found == pytest.approx(max(first - law.deceleration * t, 0), abs=allowed), t


@pytest.mark.parametrize("options", [{}, {"method": "timestepping", "step": 1e-3}])
def test_moments_of_a_pair_are_opposite(options):
    """Two balls in space that meet, roll on each other by the pull of a spring: momentum and its moment stay."""
    s = fb.System("balls")
    s.gravity = (0, 0, 0)
    bodies = [s.body(f"b{k}", fb.sphere(1 + k, R)) for k in range(2)]
    for k, body in enumerate(bodies):
        s.free(f"f{k}", s.ground, body)
    s.spring("k", bodies[0].origin, bodies[1].origin, stiffness=200, rest=0.1)
    s.contacts("pair", [b.sphere(R) for b in bodies], friction=0.3, rolling=0.01, spinning=0.005)
    start = {"f0_vy": 0.5, "f0_wz": 8.0, "f0_wx": 4.0, "f1_x": 2 * R, "f1_wz": -3.0, "f1_wx": -2.0}
    motion = fb.simulate(s, 0.5, initial=start, samples=6, **options)
    totals = []
    for t in motion.t:
        at, total = motion.at(t), np.zeros(6)
        for k, m in enumerate((1.0, 2.0)):
            R_k = axes_of(at, f"f{k}")
            v = R_k @ [at[f"f{k}_v{x}"] for x in "xyz"]
            w = R_k @ [at[f"f{k}_w{x}"] for x in "xyz"]
            place = np.array([at[f"f{k}_{x}"] for x in "xyz"])
            total += [*(m * v), *(m * np.cross(place, v) + 0.4 * m * R**2 * w)]
        totals.append(total)
    allowed = options["step"] ** 2 if options else 1e-8  # attitudes are of second order in a step
    assert np.abs(np.array(totals) - totals[0]).max() < allowed
    names = "pair[b0,b1]", "pair[b0,b1]_rolling"
    assert motion.contacts[names[0]].mode[-1] == "stick" and motion.contacts[names[1]].mode[0] != "open"


@pytest.mark.parametrize(
    "options", [pytest.param({}, marks=pytest.mark.slow), {"method": "timestepping", "step": 2e-3}]
)
def test_reactions_and_files_know_the_moments(options, tmp_path):
    """A ball on a carriage that is drawn over a floor: the moment that resists its rolling turns the carriage, too."""
    found = []
    for family in (False, True):
        s = fb.System("carriage")
        s.gravity = (0, 0, -G)
        frame, body = s.body("frame", fb.box(1, (0.2, 0.2, 0.1))), s.body("ball", fb.sphere(1, R))
        s.free("f", s.ground, frame)
        s.weld("held", frame, body)
        shapes = body.sphere(R), s.ground.plane(normal="z")
        s.force("pull", frame.origin, (3, 0, 0), frame=s.ground)
        laws = {"friction": 0.2, "rolling": 0.02, "spinning": 0.01}
        if family:
            s.contacts("floor", shapes, **laws)
        else:
            s.contact("floor", *shapes, **laws)
        start = {"f_z": R, "f_wz": 2.0, "f_wy": 1.0}
        motion = fb.simulate(s, 0.1, initial=start, samples=5, **options)
        if family and options:
            motion.save(tmp_path / "motion.nc")
            again = fb.Trajectory.load(tmp_path / "motion.nc")
            name = "floor[ball,ground]_rolling"
            assert (again.contacts[name].tangential == motion.contacts[name].tangential).all()
            assert (again.reactions["held"].moment == motion.reactions["held"].moment).all()
        found.append(motion)
    one, other = (motion.reactions["held"].moment for motion in found)
    assert np.abs(one - other).max() < 1e-6 * np.abs(one).max()
    assert np.abs(one[:, 2]).max() > 0.01  # it spins against its resistance


@pytest.mark.parametrize(
    "count", [3, pytest.param(45, marks=pytest.mark.slow)]
)  # the machine as a loop over its links
def test_balls_that_a_pull_takes_off_or_does_not(count):
    """N = m g - F >= -A, friction and resistance have N + A; beyond A they fly."""
    for pull, held in ((12.0, True), (16.0, False)):
        s = fb.System("balls")
        s.gravity = (0, 0, -G)
        bodies, start = [s.body(f"b{k}", fb.sphere(1, R)) for k in range(count)], {}
        for k, body in enumerate(bodies):
            s.free(f"f{k}", s.ground, body)
            s.force(f"F{k}", body.origin, (0, 0, pull), frame=s.ground)
            start |= {f"f{k}_x": 0.3 * k, f"f{k}_z": R, f"f{k}_vx": 0.5}
        shapes = [*(body.sphere(R) for body in bodies), s.ground.plane(normal="z")]
        s.contacts("floor", shapes, friction=0.3, adhesion=5.0, rolling=0.01)
        motion = fb.simulate(s, 0.3, initial=start, method="timestepping", step=2e-3, samples=4)
        last = f"floor[b{count - 1},ground]"
        one, rolls = motion.contacts[last], motion.contacts[f"{last}_rolling"]
        assert motion.energy.relative_residual < 1e-12
        if held:
            assert one.normal[1:] == pytest.approx([G - pull] * 3, abs=1e-9)
            assert np.linalg.norm(rolls.tangential[1]) == pytest.approx(0.01 * (G - pull + 5), rel=1e-9)
        else:
            height = R + (pull - G) * 0.3**2 / 2
            late = (pull - G) * 2e-3 * 0.3  # a contact that begins closed opens after its first step
            assert motion[f"f{count - 1}_z"][-1] == pytest.approx(height, abs=late) and one.mode[-1] == "open"


def dice():
    s = fb.System("dice")
    s.parameters(d=0.01, mu=0.4)
    s.gravity = (0, 0, -G)
    bodies = [s.body(f"b{k}", fb.box(1, (0.2, 0.2, 0.2))) for k in range(2)]
    for k, body in enumerate(bodies):
        s.free(f"f{k}", s.ground, body)
    return s, bodies


def test_files_and_the_command_tell_all_laws(tmp_path):
    laws = {"friction": "mu*(1 + slip)", "static_friction": "2*mu", "restitution": 0.5, "impact": "poisson"}
    s, _ = ball(False, True)
    shapes = [s.bodies["ball"].sphere(R), s.ground.plane(at=(0, 0, -1), normal="z")]
    s.contacts("pile", shapes, adhesion="3*mu", rolling="d", spinning="2*d", **laws)
    fb.write(s, tmp_path / "ball.toml")
    text = (tmp_path / "ball.toml").read_text()
    for line in (
        'friction = "mu*(slip + 1)"',
        'static_friction = "2*mu"',
        'impact = "poisson"',
        'spinning = "2*d"',
    ):
        assert line in text
    again = fb.read(tmp_path / "ball.toml")
    fb.write(again, tmp_path / "again.toml")
    assert (tmp_path / "again.toml").read_text() == text
    said = "".join(CliRunner().invoke(program, ["check", str(tmp_path / "ball.toml")]).output.split())
    assert "static2*mu" in said and "1/2(poisson),adhesion3*mu,rollingd,spinning2*d" in said


def test_what_families_refuse():
    s, bodies = dice()
    boxes = [b.box((0.2, 0.2, 0.2)) for b in bodies]
    s.contacts("pile", boxes, rolling="d")
    message = "The family of contacts 'pile' has rolling=, for shapes that touch at one point, but the box of body 'b0'"
    with pytest.raises(ModelError, match=message):
        fb.assemble(s)
    s, bodies = dice()
    s.contacts("pile", [bodies[0].sphere(R), bodies[1].box((0.2, 0.2, 0.2))], adhesion=1)
    with pytest.raises(ModelError, match="has adhesion=, for shapes that touch at one point, but the sphere"):
        fb.assemble(s)
    s, _ = ball(True, False, spinning="d")
    with pytest.raises(ModelError, match="Family of contacts 'floor' resists spinning about its normal, but"):
        fb.assemble(s)
    s, bodies = dice()
    shapes = [b.sphere(R) for b in bodies]
    with pytest.raises(
        ModelError, match="impact='newton' or impact='poisson' for the family of contacts 'pile', got"
    ):
        s.contacts("pile", shapes, impact="hertz")
    with pytest.raises(ModelError, match="rolling= of 0 m or more for the family of contacts 'pile', got -1"):
        s.contacts("pile", shapes, rolling=-1)
    s, start = ball(True, True, rolling="d")
    with pytest.raises(SimulationError, match="Expected rolling= of 0 m or more for contact 'floor', got -1"):
        fb.simulate(s, 1, initial=start, values={"d": -1}, method="timestepping", step=1e-2)


@pytest.mark.parametrize("count", [2, pytest.param(45, marks=pytest.mark.slow)])  # the loop over links
def test_soft_balls_come_to_rest_at_the_depth_of_their_weight(count):
    """Towers of two balls: k d^(3/2) is m g between them, and 2 m g at the floor; balls that slide have μ N."""
    s, start = fb.System("towers"), {}
    s.gravity = (0, 0, -G)
    bodies = [s.body(f"b{k}", fb.sphere(1, R)) for k in range(count)]
    for k, body in enumerate(bodies):
        s.free(f"f{k}", s.ground, body)
        start |= {f"f{k}_x": 0.3 * (k // 2), f"f{k}_z": R * (1 + 2 * (k % 2))}
    shapes = [*(body.sphere(R) for body in bodies), s.ground.plane(normal="z")]
    s.contacts("pile", shapes, normal="1e4*depth**1.5*(1 + 4*rate)")
    motion = fb.simulate(s, 1.5, initial=start, method="timestepping", step=1e-3, samples=4)
    depths = [(one * G / 1e4) ** (2 / 3) for one in (1, 2)]
    assert motion.contacts["pile[b0,b1]"].gap[-1] == pytest.approx(-depths[0], rel=1e-4)
    assert motion.contacts["pile[b0,ground]"].gap[-1] == pytest.approx(-depths[1], rel=1e-4)
    assert motion.contacts["pile[b0,ground]"].normal[-1] == pytest.approx(2 * G, rel=1e-4)
    assert motion.energy.relative_residual < 1e-12


STEPS = {"method": "timestepping", "step": 2e-3}


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("sphere", STEPS),
        pytest.param("sphere", {}, marks=pytest.mark.slow),
        pytest.param("box", STEPS, marks=pytest.mark.slow),
        pytest.param("box", {}, marks=pytest.mark.slow),
    ],
)
def test_bodies_slide_on_grooves_that_turn(kind, options):
    """A ball, or the corners of a box, on a plate that turns: the direction of the coefficients is the plate's."""
    found = []
    for family in (False, True):
        s = fb.System("plate")
        s.gravity = (0, 0, -G)
        plate, box = s.body("plate", fb.disk(2, 1.0)), s.body("box", fb.box(1, (0.2, 0.2, 0.1)))
        s.hinge("axle", s.ground, plate, coordinate="a", axis="z")
        s.free("f", s.ground, box)
        top = plate.plane(normal="z")
        shape = box.sphere(0.05) if kind == "sphere" else box.box((0.2, 0.2, 0.1))
        laws = {"friction": (0.1, 0.5), "along": (0.6, 0.8, 0)}
        if family:
            s.contacts("feet", shape, against=top, **laws)
        else:
            s.contact("feet", shape, top, **laws)
        start = {"f_z": 0.05, "f_x": 0.3, "f_vy": 0.4, "a'": 1.0}
        found.append(fb.simulate(s, 0.4, initial=start, samples=5, **options))
    one, other = found
    allowed = 1e-9 if options else 1e-7  # points of patches press with other shares than the four corners
    assert np.abs(one.states - other.states).max() < allowed
    assert np.linalg.norm(one.states[-1] - one.states[0]) > 0.1


def test_files_know_the_direction_and_the_normal_force(tmp_path):
    s, _ = ball(False, True)
    floor = s.ground.plane(at=(0, 0, -1), normal="z")
    laws = {"friction": ("mu", "2*mu"), "static_friction": ("2*mu", "4*mu"), "along": "x"}
    s.contacts("pile", s.bodies["ball"].sphere(R), against=floor, normal="1000*depth*(1 + rate)", **laws)
    fb.write(s, tmp_path / "ball.toml")
    text = (tmp_path / "ball.toml").read_text()
    for line in ('friction = ["mu", "2*mu"]', 'along = "x"', 'normal = "1000*depth*(rate + 1)"'):
        assert line in text
    fb.write(fb.read(tmp_path / "ball.toml"), tmp_path / "again.toml")
    assert (tmp_path / "again.toml").read_text() == text
    said = "".join(CliRunner().invoke(program, ["check", str(tmp_path / "ball.toml")]).output.split())
    assert "mualong(1,0,0),2*muacross" in said and "N=1000*depth*(rate+1)" in said


def test_what_families_with_a_direction_or_a_normal_force_refuse():
    s, bodies = dice()
    spheres, floor = [b.sphere(R) for b in bodies], s.ground.plane(normal="z")
    pair = {"friction": (0.1, 0.2), "along": "x"}
    with pytest.raises(
        ModelError, match="Expected against= for the family of contacts 'a', whose friction has"
    ):
        s.contacts("a", [*spheres, floor], **pair)
    with pytest.raises(
        ModelError, match="Expected along= for the family of contacts 'a', whose friction has two"
    ):
        s.contacts("a", spheres, against=floor, friction=(0.1, 0.2))
    with pytest.raises(
        ModelError, match="The family of contacts 'a' has a direction, along='x', and one coeff"
    ):
        s.contacts("a", spheres, against=floor, friction=0.1, along="x")
    with pytest.raises(ModelError, match="along='z', is the normal of its plane"):
        s.contacts("a", spheres, against=floor, friction=(0.1, 0.2), along="z")
    with pytest.raises(
        ModelError, match="has a normal force and a restitution. A compliant contact rebounds"
    ):
        s.contacts("a", spheres, normal="1e3*depth", restitution=0.5)
    with pytest.raises(ModelError, match="has a normal force and an adhesion, which rigid contacts have"):
        s.contacts("a", spheres, normal="1e3*depth", adhesion=0.5)
    with pytest.raises(
        ModelError, match="shapes without ends for the family of contacts 'a', which has a normal"
    ):
        s.contacts("a", [bodies[0].capsule((0, 0, 0), (0.1, 0, 0), R), floor], normal="1e3*depth")
    s.contacts("a", [b.box((0.2, 0.2, 0.2)) for b in bodies], normal="1e3*depth")
    with pytest.raises(
        ModelError, match="'a' has normal=, for shapes that touch at one point, but the box of bo"
    ):
        fb.assemble(s)
    s, bodies = dice()
    hollow = s.ground.sphere(1, inside=True)
    s.contacts("a", hollow, against=[b.sphere(R) for b in bodies], **pair)
    with pytest.raises(
        ModelError, match="surfaces, but the sphere of the ground is one, and none of against="
    ):
        fb.assemble(s)
    s, start = ball(True, False, friction=("mu", "2*mu"), along="x")
    with pytest.raises(
        ModelError, match="'floor' has two coefficients of friction, but the machine moves in a p"
    ):
        fb.simulate(s, 1, initial=start)
    s, start = ball(True, True, friction=("mu", 1), along="x")
    for options in ({}, {"method": "timestepping", "step": 1e-2}):
        with pytest.raises(
            SimulationError, match="two coefficients of friction above 0 of contact 'floor.ball,g"
        ):
            fb.simulate(s, 1, initial=start, values={"mu": 0}, **options)
