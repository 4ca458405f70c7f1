"""Contacts: shapes, elements, the plane of motion, symbols of a machine in modes, and the page that says so."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.describe.description import parameters_of
from freebody.describe.shapes.shape import KINDS, may_touch
from freebody.dynamics import float_state
from freebody.dynamics.conditions.contact import touches
from freebody.dynamics.contact_motion import contact_forces, in_modes
from freebody.dynamics.motion import motion
from freebody.errors import ModelError

PAGE = (Path(__file__).parents[4] / "docs" / "contact.md").read_text(encoding="utf-8")


# --- the page --------------------------------------------------------------------------------------


def test_the_page_prints_what_it_says(capsys):
    """Every block of code runs, in order, and prints the block of text below it."""
    names: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```\n\n(?:[^`]*?)```text\n(.*?)```", PAGE, re.DOTALL)
    assert len(blocks) == 12
    for code, said in blocks:
        exec(code, names)
        assert capsys.readouterr().out == said


def test_the_table_of_pairs_is_what_is_supported():
    head, _, *lines = re.search(r"(\| \| point .*?)\n\n", PAGE, re.DOTALL).group(1).splitlines()
    columns = [cell.strip() for cell in head.split("|")[2:-1]]
    for line in lines:
        first, *cells = [cell.strip(" *") for cell in line.split("|")[1:-1]]
        for second, cell in zip(columns, cells, strict=True):
            pair = may_touch(KINDS[first], KINDS[second])
            assert pair == (cell != "–"), (first, second)


def test_every_pair_of_the_table_is_made_of_elements_with_a_gap():
    """Each supported pair gives finite geometry on a planar machine."""
    make = {
        "point": lambda b: b.point(0.1, 0.2, 0),
        "sphere": lambda b: b.sphere(0.3),
        "ellipsoid": lambda b: b.ellipsoid((0.3, 0.2, 0.4)),
        "circle": lambda b: b.circle(0.3),
        "cylinder": lambda b: b.cylinder(0.3),
        "plane": lambda b: b.plane(normal="y"),
        "segment": lambda b: b.segment((-1, 0, 0), (1, 0, 0), normal="y"),
        "corners": lambda b: b.corners(size=(1, 2)),
        "heightline": lambda b: b.heightline("0.1*sin(x)"),
    }
    count = 0
    for first in make:
        for second in make:
            if not may_touch(KINDS[first], KINDS[second]):
                continue
            s = fb.System("pair")
            a, b = s.body("a", fb.disk(1, 1)), s.body("b", fb.disk(1, 1))
            s.planar("p", s.ground, a, coordinate="x y f")
            s.planar("q", s.ground, b, coordinate="x1 y1 f1")
            s.contact("c", make[first](a), make[second](b), friction=0.1)
            model = fb.assemble(s)
            elements = touches(model, float_state(model, [0.3, 0.2, 0.4, -0.5, 3.1, 1.1]))
            assert all(c.planar == (0, 0, 1) for c in model.contacts)
            assert all(np.isfinite(float(it.gap)) for it in elements)
            count += 1
    assert count == sum(may_touch(KINDS[a], KINDS[b]) for a in make for b in make)  # in either order


# --- elements and planes -----------------------------------------------------------------------------


def test_corners_are_elements_in_order():
    s = fb.System("box")
    box = s.body("box", fb.box(1, (1, 2, 3)))
    s.free("air", s.ground, box)
    s.contact("floor", box.corners(size=(1, 2, 3)), s.ground.plane(normal="z"), friction=0.5)
    contacts = fb.assemble(s).contacts
    assert [c.name for c in contacts] == [f"floor_{i}" for i in range(1, 9)]
    assert {c.owner for c in contacts} == {"floor"}
    lower = [c.feature.components for c in contacts[:4]]
    assert lower == [(-0.5, -1, -1.5), (0.5, -1, -1.5), (0.5, 1, -1.5), (-0.5, 1, -1.5)]
    e = fb.equations(s, modes={"floor_1": "stick", "floor_3": "slip"})
    assert e.condition_names == ("N_floor_1", "T1_floor_1", "T2_floor_1", "N_floor_3")


@pytest.mark.parametrize(
    "axis,plane,tangent",
    [("z", "y", (1, 0, 0)), ("z", "x", (0, -1, 0)), ("y", "x", (0, 0, 1)), ("x", "z", (0, 1, 0))],
)
def test_the_plane_of_motion_is_found(axis, plane, tangent):
    """t = n × k, with k the axis that all joints turn about."""
    s = fb.System("block")
    block = s.body("block", fb.box(1, (1, 1, 1)))
    s.planar("p", s.ground, block, axis=axis, coordinate="a b f")
    s.contact("c", block.point(0, 0, 0), s.ground.plane(normal=plane), friction=1)
    model = fb.assemble(s)
    (it,) = touches(model, float_state(model, [0.1, 0.2, 0.3]))
    assert it.tangents == (tangent,)


def test_a_contact_out_of_the_plane_has_two_tangents():
    s = fb.System("block on a table, seen from above")
    block = s.body("block", fb.box(1, (1, 1, 1)))
    s.planar("p", s.ground, block, coordinate="x y f")
    s.contact("table", block.point(0, 0, -0.5), s.ground.plane(at=(0, 0, -0.5), normal="z"), friction=1)
    s.contact("post", block.sphere(0.1, at=(0, 0, 0.3)), s.ground.sphere(0.1))
    assert [c.tangents for c in fb.assemble(s).contacts] == [2, 2]


def test_a_turned_joint_stays_in_its_plane():
    """Axes that are turned about the normal leave the machine planar; others do not."""
    for sequence, tangents in (("XYZ", 2), ("ZXZ", 1)):
        s = fb.System("bar")
        bar = s.body("bar", fb.slender_bar(1, 2))
        angles = (0.1, 0.2, 0.3) if tangents == 2 else (0.1, 0, 0.3)
        s.hinge("p", s.ground, bar, parent_axes=fb.Rotation.euler(sequence, *angles), coordinate="f")
        s.contact("c", bar.point(1, 0, 0), s.ground.plane(at=(0, -2, 0)), friction=1)
        assert fb.assemble(s).contacts[0].tangents == tangents


def test_a_polygon_of_vertices():
    s = fb.System("hexagon")
    wheel = s.body("wheel", fb.disk(1, 1))
    s.planar("p", s.ground, wheel, coordinate="x y f")
    angle = np.arange(6) * np.pi / 3
    vertices = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    s.contact("floor", wheel.corners(vertices), s.ground.plane())
    model = fb.assemble(s)
    gaps = [it.gap for it in touches(model, float_state(model, [0, 2, 0.2]))]
    assert gaps == pytest.approx(2 + np.sin(angle + 0.2))


def test_the_lowest_point_of_a_tilted_disk():
    s = fb.System("coin")
    coin = s.body("coin", fb.disk(1, 0.5))
    s.free("air", s.ground, coin)
    s.contact("floor", coin.circle(0.5), s.ground.plane(normal="z"))
    model = fb.assemble(s)
    theta = 0.7  # tilt about x
    q = [0.0, 0.0, 1.0, np.cos(theta / 2), np.sin(theta / 2), 0.0, 0.0]
    it, *rests = touches(model, float_state(model, q))
    assert it.gap == pytest.approx(1 - 0.5 * np.sin(theta))
    assert sorted(rest.gap for rest in rests) == pytest.approx([it.gap, 1, 1, 2 - it.gap])
    assert it.reach[0] > 0
    level = touches(model, float_state(model, [0.0, 0.0, 1.0, 1.0, 4e-12, 0.0, 0.0]))  # a disk that lies flat
    assert level[0].reach[0] < 0
    assert np.array(it.on_feature) == pytest.approx([0, -0.5 * np.cos(theta), 1 - 0.5 * np.sin(theta)])


def test_the_lowest_point_of_a_turned_ellipsoid():
    """The point that is deepest among all of the surface; with equal half axes that of a sphere."""
    s = fb.System("egg")
    egg = s.body("egg", fb.sphere(1, 0.1))
    s.ball("turn", s.ground, egg)
    s.contact(
        "floor", egg.ellipsoid((0.3, 0.2, 0.4), at=(0.05, 0, 0.1)), s.ground.plane(at=(0, 0, -1), normal="z")
    )
    s.contact("ball", egg.sphere(0.25), s.ground.plane(at=(0, 0, -1), normal="z"))
    s.contact("round", egg.ellipsoid((0.25, 0.25, 0.25)), s.ground.plane(at=(0, 0, -1), normal="z"))
    model = fb.assemble(s)
    q = np.array([0.5, -0.3, 0.7, 0.2])
    q /= np.linalg.norm(q)
    it, ball, same = touches(model, float_state(model, q.tolist()))
    e0, e = q[0], q[1:]
    R = (e0 * e0 - e @ e) * np.eye(3) + 2 * np.outer(e, e) + 2 * e0 * np.cross(np.eye(3), e)
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 801), np.linspace(0, 2 * np.pi, 1601), indexing="ij")
    ball_points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    height = (ball_points * (0.3, 0.2, 0.4) + (0.05, 0, 0.1)) @ R[2]
    assert float(it.gap) == pytest.approx(1 + height.min(), abs=1e-5)
    assert float(it.gap) < 1 + height.min()
    np.testing.assert_allclose(np.array(it.on_feature, float)[2], float(it.gap) - 1, atol=1e-15)
    assert float(same.gap) == pytest.approx(float(ball.gap), abs=1e-15)
    with pytest.raises(
        ModelError, match=r"Expected three half axes \(a, b, c\) for the ellipsoid of body 'egg', got 0\.3"
    ):
        egg.ellipsoid(0.3)
    with pytest.raises(
        ModelError, match="ellipsoid and the point of contact 'no' are not a supported pair. An ellipsoid may"
    ):
        s.contact("no", egg.ellipsoid((1, 1, 1)), s.ground.point(0, 0, 0))


def test_a_round_feature_rolls_over_the_end_of_a_side():
    """At the end of a ledge the gaps to the side and to its corner are one, and beyond it the corner's is less."""
    s = fb.System("ledge")
    disk = s.body("disk", fb.disk(1, 0.5))
    s.planar("p", s.ground, disk, coordinate="x y f")
    s.contact("ledge", disk.circle(0.5), s.ground.segment((0, 0, 0), (2, 0, 0), normal="y"), friction=1)
    model = fb.assemble(s)
    assert [c.name for c in model.contacts] == ["ledge", "ledge_start", "ledge_end"]
    e = fb.equations(s, modes={"ledge": "stick"})
    assert e.condition_names == ("N_ledge", "T_ledge")
    side, start, end = touches(model, float_state(model, [2.0, 0.6, 0.1]))
    assert (side.gap, end.gap) == pytest.approx((0.1, 0.1))
    assert (side.reach, start.reach, end.reach) == ((2, 0), (), ())
    assert np.array(side.normal, dtype=float) == pytest.approx(np.array(end.normal, dtype=float))
    side, _, end = touches(model, float_state(model, [2.3, 0.4, 0.1]))
    assert side.reach[1] < 0
    assert end.gap == pytest.approx(0)
    assert side.gap == pytest.approx(-0.1)


# --- symbols -------------------------------------------------------------------------------------------


def block():
    s = fb.System("block")
    m, mu, g = s.parameters(m=2, mu=0.3, g=9.81)
    s.gravity = (0, -g, 0)
    body = s.body("block", fb.box(m, (1, 1, 1)))
    s.free("air", s.ground, body)
    s.contact("floor", body.sphere(0.5), s.ground.plane(), friction=mu)
    return s


def test_friction_in_space_stands_in_the_free_body():
    """T = -μ N γ/|γ| with the slip velocity of the state, as a formula."""
    s = block()
    e = fb.equations(s, modes={"floor": "slip"})
    free = e.free_body("block")
    friction = {a.name: a for a in free.actions}["T_floor"]
    assert friction.kind == "friction"
    N, mu = sympy.Symbol("N_floor", real=True), s.expression("mu")
    size = sympy.sqrt(sum(e.sympy(x) ** 2 for x in friction.force))
    at = {p.symbol: p.default for p in parameters_of(s)}
    at |= {c.symbol: x for c, x in zip(e.model.coordinates, (0.1, 0.5, 0.2, 1, 0, 0, 0), strict=True)}
    at |= {u.symbol: x for u, x in zip(e.model.speeds, (0.3, 0.1, -0.2, 1, 0, 0.7), strict=True)}
    assert float(size.subs({**at, N: 5.0})) == pytest.approx(0.3 * 5)
    assert free.unknowns == (N,)
    assert mu in size.free_symbols


def test_symbols_and_numbers_agree_in_a_mode():
    """The multipliers of the symbolic equations are the forces of the numeric motion."""
    s = fb.System("disk")
    m, R, mu, g = s.parameters(m=2, R=0.3, mu=0.2, g=9.81)
    s.gravity = (1, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("p", s.ground, disk, coordinate="x y f")
    s.contact("bowl", disk.circle(R), s.ground.circle(2, inside=True), friction=mu)
    for mode in ("stick", "slip+", "slip-"):
        e = fb.equations(s, modes={"bowl": mode})
        angle, spin = 0.4, 1.5
        q = [1.7 * np.sin(angle), -1.7 * np.cos(angle), 0.3]
        u = [1.7 * np.cos(angle) * spin, 1.7 * np.sin(angle) * spin, -1.7 * spin / 0.3]
        held = in_modes(fb.assemble(s), {"bowl": mode})
        state = float_state(held, q, u)
        moving = motion(held, state)
        forces = contact_forces(held, state, moving.multipliers)["bowl"]
        at = {p.symbol: p.default for p in parameters_of(s)}
        at |= dict(zip((c.symbol for c in e.model.coordinates), q, strict=True))
        at |= dict(zip((c.symbol for c in e.model.speeds), u, strict=True))
        names = e.multipliers
        accelerations = [speed.acceleration for speed in e.model.speeds]
        values = dict(zip(accelerations, moving.udot, strict=True))
        values |= dict(zip(names, moving.multipliers, strict=True))
        for equation in e.motion:
            left = (equation.lhs - equation.rhs).xreplace(values).xreplace(at)
            assert float(left) == pytest.approx(0, abs=1e-10)
        # and so do the free-body equations, forces and moment
        for equation in e.free_body("disk").planar_equations:
            left = (equation.lhs - equation.rhs).xreplace(values).xreplace(at)
            assert float(left) == pytest.approx(0, abs=1e-10)
        assert forces[0] > 0
        if mode != "stick":
            assert forces[1] == pytest.approx((-0.2 if mode == "slip+" else 0.2) * forces[0])


def test_elimination_leaves_no_force_of_a_contact_that_slips():
    s = fb.System("disk on a slope")
    m, R, mu, g = s.parameters(m=2, R=0.3, mu=0.2, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("p", s.ground, disk, coordinate="x y f")
    s.contact("floor", disk.circle(R), s.ground.plane(), friction=mu)
    e = fb.equations(s, modes={"floor": "slip+"})
    along, turning = e.eliminated(["x", "f"])
    x, y, f = (speed.acceleration for speed in e.model.speeds)
    # m x'' = -μ (m y'' + m g),  m R² f''/2 = -R μ (m y'' + m g)
    assert sympy.expand(along.lhs - m * (x + mu * (y + g))) == 0
    assert sympy.expand(turning.lhs - m * R * (R * f / 2 + mu * (y + g))) == 0


def test_no_energy_is_kept_while_a_contact_slips():
    s = block()
    smooth = fb.System("smooth")
    body = smooth.body("ball", fb.sphere(1, 0.5))
    smooth.gravity = (0, -9.81, 0)
    smooth.planar("p", smooth.ground, body, coordinate="x y f")
    smooth.contact("floor", body.circle(0.5), smooth.ground.plane())
    assert "energy" in [i.name for i in fb.equations(smooth, modes={"floor": "slip"}).integrals]
    assert "energy" not in [i.name for i in fb.equations(s, modes={"floor": "slip"}).integrals]


def test_forces_are_opposite_on_the_other_body():
    s = fb.System("board on a roller")
    g = s.parameters(g=9.81)
    s.gravity = (0, -g, 0)
    roller, board = s.body("roller", fb.disk(1, 0.2)), s.body("board", fb.slender_bar(2, 3))
    s.planar("p", s.ground, roller, coordinate="x y f")
    s.planar("q", s.ground, board, coordinate="X Y F")
    side = board.segment((-1.5, 0, 0), (1.5, 0, 0), normal="-y")
    s.contact("c", side, roller.circle(0.2), friction=0.5)
    e = fb.equations(s, modes={"c": "stick"})
    a, b = e.free_body("roller").forces, e.free_body("board").forces
    for name in ("N_c", "T_c"):
        assert sympy.simplify(a[name] + b[name]) == sympy.zeros(3, 1)
    total = e.momentum.linear
    assert total.shape == (3, 1)


def test_the_reaction_of_a_contact():
    s = fb.System("disk")
    m, R, mu, g = s.parameters(m=2, R=0.3, mu=0.2, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("p", s.ground, disk, coordinate="x y f")
    s.contact("floor", disk.circle(R), s.ground.plane(), friction=mu)
    s.contact("wall", disk.circle(R), s.ground.plane(at=(1, 0, 0), normal="-x"))
    e = fb.equations(s, modes={"floor": "slip-"})
    reaction = e.reactions["floor"]
    N = sympy.Symbol("N_floor", real=True)
    assert reaction.force == sympy.Matrix([mu * N, N, 0])
    assert reaction.components == {"N_floor": N, "T_floor": mu * N}
    assert (reaction.on, reaction.about) == ("disk", "the point of contact")
    assert repr(e).startswith("Equations of motion of 'disk' (floor slip-, wall open)")
    assert "wall" not in e.reactions
    sticking = fb.equations(s, modes={"floor": "stick"}).reactions["floor"]
    assert list(sticking.components) == ["N_floor", "T_floor"]
    assert "N_floor = N_floor" in sticking.text()


def test_what_the_motion_does_not_share_out_is_indeterminate():
    """Two feet that stick on one floor: their friction only as a sum; four legs: their normal forces too."""
    s = fb.System("box")
    s.gravity = (0, -9.81, 0)
    box = s.body("box", fb.box(1, (2, 1, 1)))
    s.planar("p", s.ground, box, coordinate="x y f")
    for name, x in (("a", -1), ("b", 1)):
        s.contact(name, box.point(x, -0.5, 0), s.ground.plane(), friction=0.5)
    near = {"y": 0.5}
    found = fb.equations(s, modes={"a": "stick", "b": "stick"}).indeterminate(near)
    assert [n for n in found if n[:2] in ("N_", "T_")] == ["T_a", "T_b"]
    # sliding friction follows from the normal force
    found = fb.equations(s, modes={"a": "slip+", "b": "slip+"}).indeterminate(near)
    assert [n for n in found if n[:2] in ("N_", "T_")] == []
    s = fb.System("table")
    table = s.body("table", fb.box(1, (2, 1, 1)))
    s.free("air", s.ground, table)
    s.contact(
        "legs", table.corners((1, 1, 0), (-1, 1, 0), (-1, -1, 0), (1, -1, 0)), s.ground.plane(normal="z")
    )
    found = fb.equations(s, modes={"legs": "slip"}).indeterminate()
    assert found == ("N_legs_1", "N_legs_2", "N_legs_3", "N_legs_4")


# --- command line ----------------------------------------------------------------------------------


def test_the_command_line_names_contacts_and_takes_modes(tmp_path):
    from click.testing import CliRunner

    from freebody.cli import command as program

    s = fb.System("disk")
    m, R, mu, g = s.parameters(m=2, R=0.3, mu=0.2, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("p", s.ground, disk, coordinate="x y f")
    s.contact("floor", disk.circle(R), s.ground.plane(), friction=mu, static_friction=0.4, restitution=0.5)
    path = tmp_path / "disk.toml"
    fb.write(s, path)

    def run(*arguments):
        return CliRunner().invoke(program, [arguments[0], str(path), *arguments[1:]])

    checked = run("check").output
    for word in ("floor", "circle of disk", "plane of ground", "mu, static 2/5", "1/2 (newton)"):
        assert word in checked
    assert "N_floor" not in run("equations").output
    assert "m*x'' = T_floor" in run("equations", "--mode", "floor=stick").output
    slipping = run("equations", "--mode", "floor=slip+", "--body", "disk").output
    assert "T_floor  force (-mu*N_floor, 0)   [contact 'floor', ground]" in slipping
    refused = str(run("equations", "--mode", "floor").exception)
    assert refused == "Expected a contact and its mode, such as floor=stick, for --mode, got 'floor'."
    refused = str(run("equations", "--mode", "flor=open").exception)
    assert refused == "Unknown contact 'flor' in modes; did you mean 'floor'?"


def test_a_mesh_falls_on_its_vertices():
    """A cube of a mesh, moved and turned in its body, has the corners of the box, and comes to rest as it does."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.2
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    faces = [face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))]
    doubled = [tuple(8 * (k % 2) + i for i in face) for k, face in enumerate(faces)]  # as in an STL file
    solid = fb.mesh(np.vstack([corners, corners]), doubled, mass=2).moved((-0.1, -0.1, -0.1))
    s = fb.System("cube")
    s.gravity = (0, 0, -9.81)
    cube = s.body("cube", solid)
    s.free("air", s.ground, cube)
    s.contact("floor", cube.corners(), s.ground.plane(normal="z"), friction=0.5)
    points = [[float(x) for x in point.components] for point in cube.corners().points]
    np.testing.assert_allclose(sorted(points), sorted((corners - 0.1).tolist()), atol=1e-15)
    motion = fb.simulate(s, 0.5, initial={"air_z": 0.6})
    assert motion.events[0].time == pytest.approx(np.sqrt(2 * 0.5 / 9.81), abs=1e-12)
    assert motion.at(0.5)["air_z"] == pytest.approx(0.1, abs=1e-12)


@pytest.mark.parametrize("family", [False, True])
@pytest.mark.parametrize("how", [{}, {"method": "timestepping", "step": 1e-3}])
def test_a_ball_on_the_axis_of_a_capsule_hits_its_end(how, family):
    """The wall has no direction there; the end of radius 0.1 at 0.2 m is hit at 0.4 m, and the ball returns at e v."""
    s = fb.System("pill")
    ball = s.body("ball", fb.sphere(0.5, 0.1))
    s.slider("way", s.ground, ball, axis="x", coordinate="x")
    shapes = ball.sphere(0.1), s.ground.capsule((-0.2, 0, 0), (0.2, 0, 0), 0.1)
    if family:
        s.contacts("hit", list(shapes), restitution=0.5)
    else:
        s.contact("hit", *shapes, restitution=0.5)
    motion = fb.simulate(s, 1.0, initial={"x": 0.8, "x'": -1}, **how)
    assert motion["x'"][-1] == pytest.approx(0.5, abs=1e-12)
    assert motion["x"][-1] == pytest.approx(0.4 + 0.3, abs=1e-9 if not how else 1.5e-3)
