"""Robots in MJCF: against machines that are described by hand, and every message."""

from __future__ import annotations

import math
import struct
from pathlib import Path

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.errors import FormatError, ModelError

from .test_urdf import same

ROD = '<inertial pos="0 0 -0.5" mass="2" diaginertia="0.2 0.2 0.01"/>'
PIN = '<body name="rod"><joint name="pin" axis="0 1 0"/>' + ROD + "</body>"
RADIAN = '<compiler angle="radian"/>'


def read(folder: Path, *parts: str, head: str = "", name: str = "arm.xml", **options: object) -> fb.System:
    """The system of a file with these bodies; what is in ``head`` stands before them."""
    path = folder / name
    path.write_text(
        "\n".join([f"<mujoco model='arm'>{head}", "<worldbody>", *parts, "</worldbody></mujoco>"])
    )
    return fb.read(path, **options)  # type: ignore[arg-type]


def by_hand(mass: fb.MassProperties, axis: object = "y", **where: object) -> fb.System:
    """A body on a hinge in the ground."""
    s = fb.System("arm")
    s.gravity = (0, 0, -9.81)
    s.hinge("pin", s.ground, s.body("rod", mass), axis=axis, coordinate="pin", **where)
    return s


def mass_of(s: fb.System, body: str = "rod") -> fb.MassProperties:
    """Mass properties of a body, with numbers."""
    return s.bodies[body].mass_properties


def test_a_pendulum_is_the_machine_described_by_hand(tmp_path):
    rod = fb.MassProperties(2, (0, 0, -0.5), ((0.2, 0, 0), (0, 0.2, 0), (0, 0, 0.01)))
    assert same(read(tmp_path, PIN), by_hand(rod)) < 1e-13


@pytest.mark.parametrize("symbols", ["none", "masses", "all"])
def test_symbols_are_parameters_with_the_files_numbers(tmp_path, symbols):
    s = read(tmp_path, PIN, symbols=symbols)
    values = fb.assemble(s).values()
    assert values == ({} if symbols == "none" else values)
    assert values.get("m_rod") == (None if symbols == "none" else 2)
    assert fb.compile(s).mass_matrix([0.0]) == pytest.approx(np.array([[0.7]]), rel=1e-15)


# -- orientations ---------------------------------------------------------------------------------------

TURN = fb.Rotation.euler("XYZ", 0.3, -0.2, 0.7)
COLUMNS = np.array(TURN.matrix, float)
QUATERNION = " ".join(f"{3 * x!r}" for x in map(float, TURN.as_quaternion()))
AXIS, ANGLE = TURN.as_axis_angle()


@pytest.mark.parametrize(
    "written, head",
    [
        ('euler="0.3 -0.2 0.7"', RADIAN),
        (f'euler="{math.degrees(0.3)!r} {math.degrees(-0.2)!r} {math.degrees(0.7)!r}"', ""),
        ('euler="0.7 -0.2 0.3"', '<compiler angle="radian" eulerseq="ZYX"/>'),
        (f'quat="{QUATERNION}"', ""),
        (f'axisangle="{" ".join(str(2 * float(x)) for x in AXIS)} {float(ANGLE)!r}"', RADIAN),
        (
            f'xyaxes="{" ".join(map(str, 2 * COLUMNS[:, 0]))} {" ".join(map(str, COLUMNS[:, 1] + COLUMNS[:, 0]))}"',
            "",
        ),
    ],
    ids=["radians", "degrees", "space-fixed", "quaternion", "axis and angle", "two axes"],
)
def test_orientations_are_those_of_the_format(tmp_path, written, head):
    s = read(tmp_path, f'<body name="a" pos="1 2 3" {written}><body name="b" pos="0 0 1"/></body>', head=head)
    point, axes = s.reading.frames["b"]
    assert np.array(axes, float) == pytest.approx(COLUMNS, abs=1e-15)
    assert np.array(point.components, float) == pytest.approx(np.array([1, 2, 3]) + COLUMNS[:, 2], abs=1e-15)


def test_an_axis_is_reached_by_the_shortest_turn(tmp_path):
    s = read(tmp_path, '<body name="a" zaxis="0 3 4"/><body name="b" zaxis="0 0 -2"/>')
    assert np.array(s.reading.frames["a"][1], float) == pytest.approx(
        np.array([[1, 0, 0], [0, 0.8, 0.6], [0, -0.6, 0.8]]), abs=1e-15
    )
    assert s.reading.frames["b"][1] == ((1, 0, 0), (0, -1, 0), (0, 0, -1))


def test_right_angles_are_exact(tmp_path):
    s = read(tmp_path, '<body name="a" euler="90 0 -90"/><body name="b" quat="0.707107 0 0 0.707107"/>')
    assert s.reading.frames["a"][1] == ((0, 1, 0), (0, 0, -1), (-1, 0, 0))
    assert s.reading.frames["b"][1] == ((0, -1, 0), (1, 0, 0), (0, 0, 1))


def test_frames_move_what_they_hold(tmp_path):
    inside = f'<frame pos="1 0 0" euler="0 0 90"><body name="rod" pos="0 2 0"><joint name="pin" axis="0 1 0"/>{ROD}</body></frame>'
    s = read(tmp_path, inside)
    rod = fb.MassProperties(2, (0, 0, -0.5), ((0.2, 0, 0), (0, 0.2, 0), (0, 0, 0.01)))
    turned = fb.Rotation.axis_angle("z", "pi/2")
    assert same(s, by_hand(rod, at=(-1, 0, 0), parent_axes=turned)) < 1e-13


# -- masses ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "geom, solid",
    [
        ('type="sphere" size="0.2" mass="3"', fb.sphere(3, 0.2)),
        ('type="box" size="0.1 0.2 0.3" mass="3"', fb.box(3, (0.2, 0.4, 0.6))),
        ('type="cylinder" size="0.1 0.2" mass="3"', fb.cylinder(3, 0.1, 0.4)),
        ('type="ellipsoid" size="0.1 0.2 0.3" mass="3"', fb.ellipsoid(3, (0.1, 0.2, 0.3))),
        ('type="box" size="0.1 0.2 0.3" density="500"', fb.box(24, (0.2, 0.4, 0.6))),
    ],
)
def test_geoms_are_solids(tmp_path, geom, solid):
    s = read(tmp_path, f'<body name="rod"><joint/><geom {geom}/></body>', symbols="none")
    mass = mass_of(s)
    assert float(mass.mass) == pytest.approx(float(solid.mass), rel=1e-15)
    assert np.array(mass.inertia, float) == pytest.approx(np.array(solid.inertia, float), rel=1e-14)


def test_a_capsule_is_a_cylinder_with_two_half_spheres(tmp_path):
    r, h = 0.1, 0.4
    s = read(
        tmp_path, f'<body name="rod"><joint/><geom type="capsule" size="{r} {h / 2}"/></body>', symbols="none"
    )
    z = sympy.Symbol("z", real=True)
    half = fb.revolve(sympy.sqrt(r * r - z * z), (0, r), z, density=1000, axis="z")
    tube = fb.cylinder(1000 * math.pi * r * r * h, r, h)
    whole = (
        tube
        + half.moved((0, 0, h / 2))
        + half.rotated(fb.Rotation.axis_angle("x", "pi")).moved((0, 0, -h / 2))
    )
    mass = mass_of(s)
    assert float(mass.mass) == pytest.approx(float(whole.mass), rel=1e-14)
    assert np.array(mass.inertia, float) == pytest.approx(
        np.array(whole.inertia, float), rel=1e-13, abs=1e-15
    )


def test_ends_of_a_geom_say_where_it_is(tmp_path):
    s = read(tmp_path, '<body name="rod"><joint/><geom type="cylinder" fromto="0 0 0 0 3 4" size="0.1" mass="2"/></body>',
             symbols="none")  # fmt: skip
    rod = fb.cylinder(2, 0.1, 5).rotated(fb.Rotation.nearest([[1, 0, 0], [0, 0.8, 0.6], [0, -0.6, 0.8]]))
    mass = mass_of(s)
    assert np.array(mass.center, float) == pytest.approx([0, 1.5, 2])
    assert np.array(mass.inertia, float) == pytest.approx(np.array(rod.inertia, float), rel=1e-13, abs=1e-15)


CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SIDES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]  # fmt: skip
VERTICES = " ".join(f"{c}" for corner in CUBE for c in corner)
FACES = " ".join(f"{i}" for face in SIDES for i in face)


def cube(**more: str) -> str:
    attributes = " ".join(f'{name}="{value}"' for name, value in more.items())
    return f'<asset><mesh name="cube" vertex="{VERTICES}" {attributes}/></asset>'


@pytest.mark.parametrize("way", ["legacy", "convex", "exact"])
@pytest.mark.parametrize("faces", ["", FACES])
def test_meshes_have_the_mass_of_their_volume(tmp_path, way, faces):
    more = {"inertia": way, "scale": "0.2 0.4 0.6"} | ({"face": faces} if faces else {})
    s = read(tmp_path, '<body name="rod"><joint/><geom type="mesh" mesh="cube" density="500"/></body>',
             head=cube(**more), symbols="none")  # fmt: skip
    mass, box = mass_of(s), fb.box(24, (0.2, 0.4, 0.6))
    assert float(mass.mass) == pytest.approx(24, rel=1e-14)
    assert np.array(mass.center, float) == pytest.approx([0.1, 0.2, 0.3], rel=1e-14)
    assert np.array(mass.inertia, float) == pytest.approx(np.array(box.inertia, float), rel=1e-13, abs=1e-15)


def test_an_open_mesh_has_the_pyramids_over_its_triangles(tmp_path):
    """Without its top the cube of edge 1 has five pyramids over its faces from the mass centre of five such pyramids."""
    open_faces = " ".join(f"{i}" for face in SIDES if not all(CUBE[k][2] for k in face) for i in face)
    s = read(tmp_path, '<body name="rod"><joint/><geom type="mesh" mesh="cube" density="1"/></body>',
             head=cube(face=open_faces), symbols="none")  # fmt: skip
    # first apex: centroid of five faces, z = 4/5 1/2 = 2/5; pyramids: four of height 1/2 with z (3 1/2 + 2/5)/4, one of 2/5
    low, high = 4 / 6, (2 / 5) / 3
    z = (low * (1.5 + 0.4) / 4 + high * 0.4 / 4) / (low + high)
    mass = mass_of(s)
    assert np.array(mass.center, float) == pytest.approx([0.5, 0.5, z], rel=1e-14)
    assert float(mass.mass) == pytest.approx(low + z / 3, rel=1e-14)


def test_a_shell_has_its_mass_in_its_surface(tmp_path):
    s = read(tmp_path, '<body name="rod"><joint/><geom type="mesh" mesh="cube" mass="6"/></body>',
             head=cube(face=FACES, inertia="shell"), symbols="none")  # fmt: skip
    # six plates of mass 1: two across x (1/6 + 1/4 ... ): I = 2 (1/6) + 4 (1/12 + 1/4)
    assert np.array(mass_of(s).inertia, float) == pytest.approx(
        np.eye(3) * (2 / 6 + 4 * (1 / 12 + 1 / 4)), abs=1e-14
    )


def test_a_mesh_file_of_each_kind_is_read(tmp_path):
    points = np.array(CUBE, float)
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *points[list(face)].ravel(), 0) for face in SIDES)
    (tmp_path / "cube.stl").write_bytes(b" " * 80 + struct.pack("<I", len(SIDES)) + triangles)
    lines = [f"v {x} {y} {z}" for x, y, z in CUBE] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in SIDES]
    (tmp_path / "cube.obj").write_text("\n".join(lines))
    counts = struct.pack("<4i", 8, 0, 0, 12)
    (tmp_path / "cube.msh").write_bytes(
        counts + struct.pack("<24f", *points.ravel()) + struct.pack("<36i", *sum(SIDES, ()))
    )
    for kind in ("stl", "obj", "msh"):
        s = read(tmp_path, '<body name="rod"><joint/><geom type="mesh" mesh="cube" mass="6"/></body>',
                 head=f'<asset><mesh file="cube.{kind}"/></asset>', symbols="none")  # fmt: skip
        assert np.array(mass_of(s).inertia, float) == pytest.approx(np.eye(3), abs=1e-14)


def test_the_compiler_chooses_the_masses(tmp_path):
    both = f'<body name="rod"><joint/>{ROD}<geom size="0.1" mass="3"/><geom size="0.1" mass="4" group="4"/></body>'
    geoms = both.replace(ROD, "")

    def mass(head: str, body: str = both) -> float:
        return float(mass_of(read(tmp_path, body, head=head, symbols="none")).mass)

    assert mass("") == 2
    assert mass('<compiler inertiafromgeom="true"/>') == 7
    assert mass('<compiler inertiagrouprange="0 3"/>', geoms) == 3
    assert mass('<compiler boundmass="10"/>') == 10
    assert mass('<compiler settotalmass="5"/>') == 5


def test_the_compiler_bounds_and_balances_inertia(tmp_path):
    thin = '<body name="rod"><joint/><inertial pos="0 0 0" mass="2" diaginertia="1 1 4"/></body>'
    s = read(tmp_path, thin, head='<compiler balanceinertia="true"/>', symbols="none")
    assert mass_of(s).inertia == ((2, 0, 0), (0, 2, 0), (0, 0, 2))
    s = read(tmp_path, thin, head='<compiler boundinertia="3"/>', symbols="none")
    assert mass_of(s).inertia == ((3, 0, 0), (0, 3, 0), (0, 0, 4)) and "raised to the bounds" in str(
        s.reading
    )


def test_an_inertia_that_no_body_has_is_kept_and_said(tmp_path):
    s = read(
        tmp_path,
        '<body name="rod"><joint/><inertial pos="0 0 0" mass="2" fullinertia="1 1 4 0.1 0.2 0.3"/></body>',
    )
    assert "kept as it is, although no body can have it: body 'rod'" in str(s.reading)


# -- default classes and included files -----------------------------------------------------------------

CLASSES = """<default><joint armature="1"/><geom density="500"/>
<default class="leg"><joint axis="0 1 0"/><default class="foot"><joint armature="3"/></default></default></default>"""


def test_classes_give_what_an_element_does_not_say(tmp_path):
    bodies = "".join(
        f'<body name="{name}" {child}><joint name="j_{name}" {own}/><geom type="box" size="0.5 0.5 0.5"/></body>'
        for name, child, own in (
            ("a", "", ""), ("b", 'childclass="leg"', ""), ("c", 'childclass="leg"', 'class="foot"'),
            ("d", 'childclass="foot"', 'armature="7"'),
        )
    )  # fmt: skip
    s = read(tmp_path, bodies, head=CLASSES, symbols="none")
    assert [float(mass_of(s, name).mass) for name in "abcd"] == [500] * 4
    assert [s.joints[f"j_{name}"].primitives[0].armature for name in "abcd"] == [(1,), (1,), (3,), (7,)]
    assert [s.joints[f"j_{name}"].primitives[0].axis for name in "ab"] == [(0, 0, 1), (0, 1, 0)]


def test_an_orientation_replaces_that_of_the_class(tmp_path):
    head = '<default><geom quat="0 1 0 0"/></default>'
    s = read(tmp_path, '<body name="rod"><joint/><geom type="box" size="1 2 3" mass="6" euler="0 0 90"/></body>',
             head=head, symbols="none")  # fmt: skip
    assert mass_of(s).inertia == ((20, 0, 0), (0, 26, 0), (0, 0, 10))


def test_files_are_included_where_they_stand(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "rod.xml").write_text(
        f"<mujocoinclude>{PIN}<include file='tip.xml'/></mujocoinclude>"
    )
    (tmp_path / "parts" / "tip.xml").write_text(
        "<mujocoinclude><body name='tip' pos='0 0 1'/></mujocoinclude>"
    )
    s = read(tmp_path, "<include file='parts/rod.xml'/>")
    assert list(s.bodies) == ["rod"] and "tip" in s.reading.frames


# -- joints ---------------------------------------------------------------------------------------------


def test_joints_of_one_body_act_one_after_the_other(tmp_path):
    inside = f"""<body name="rod" pos="0 0 1" euler="20 0 0"><joint name="slide" type="slide" axis="1 1 0"/>
    <joint name="yaw" axis="0 0 1" pos="0.1 0 0"/><joint name="pitch" axis="0 1 0" pos="0 0 0.2" armature="0.3"/>{ROD}</body>"""
    s = read(tmp_path, inside)
    other = fb.System("arm")
    other.gravity = (0, 0, -9.81)
    rod = fb.MassProperties(2, (0, 0, -0.5), ((0.2, 0, 0), (0, 0.2, 0), (0, 0, 0.01)))
    one, two = (other.body(name, fb.particle(0)) for name in "ab")
    body = other.body("rod", rod)
    tilt = fb.Rotation.nearest(np.array(fb.Rotation.euler("XYZ", math.radians(20), 0, 0).matrix, float))
    other.slider(
        "slide", other.ground, one, at=(0, 0, 1), parent_axes=tilt, axis=(1, 1, 0), coordinate="slide"
    )
    other.hinge("yaw", one, two, at=(0.1, 0, 0), to=(0.1, 0, 0), axis="z", coordinate="yaw")
    other.hinge(
        "pitch", two, body, at=(0, 0, 0.2), to=(0, 0, 0.2), axis="y", coordinate="pitch", armature=0.3
    )
    assert list(s.joints) == ["rod"] and s.joints["rod"].type == "chain"
    assert same(s, other) < 1e-13


def test_reference_and_springs_are_in_the_files_values(tmp_path):
    s = read(tmp_path, f"""<body name="rod"><joint name="pin" axis="0 1 0" ref="90" springref="30" stiffness="5"
    damping="2" range="-10 100"/>{ROD}</body>""")  # fmt: skip
    assert s.reading.initial == {"pin": math.pi / 2}
    assert s.reading.limits == {"pin": {"lower": math.radians(-10), "upper": math.radians(100)}}
    program = fb.compile(s)
    # at the file's pose the rod hangs; the spring pulls it by 5 (90 - 30) degrees, the damper by 2
    a = program.forward_dynamics([math.pi / 2], [1.0])
    assert a == pytest.approx([-(5 * math.radians(60) + 2) / 0.7], rel=1e-14)


def test_a_free_body_stands_where_the_file_has_it(tmp_path):
    s = read(tmp_path, f'<body name="rod" pos="1 2 3" quat="0 1 0 0"><freejoint name="root"/>{ROD}</body>')
    assert s.reading.initial == {"root_x": 1, "root_y": 2, "root_z": 3, "root_e1": 1}
    motion = fb.simulate(s, 1, initial=s.reading.initial)
    assert motion["root_z"][-1] == pytest.approx(3 - 9.81 / 2, rel=1e-9)


@pytest.mark.parametrize("kind, speed, power", [("ball", "w", 0), ("free", "v", 1)])
def test_damping_of_balls_and_free_joints_is_against_their_speeds(tmp_path, kind, speed, power):
    s = read(tmp_path, f"""<body name="rod"><joint name="j" type="{kind}" damping="0.3" armature="0.1"/>
    <inertial pos="0 0 0" mass="2" diaginertia="2 2 2"/></body>""")  # fmt: skip
    program, model = fb.compile(s), fb.assemble(s)
    q = np.zeros(model.n_q)
    q[list(model.coordinate_names).index("j_e0")] = 1
    u = np.zeros(model.n_u)
    k = list(model.speed_names).index(f"j_{speed}x")
    u[k] = 1
    assert program.forward_dynamics(q, u)[k] == pytest.approx(-0.3 / 2.1, rel=1e-14)


def test_bodies_without_joints_merge_or_are_kept(tmp_path):
    inside = PIN.replace(
        "</body>", '<body name="tool" pos="0 0 -1"><geom size="0.1" mass="1"/></body></body>'
    )
    merged, kept = read(tmp_path, inside), read(tmp_path, inside, keep_fixed=True)
    assert list(merged.bodies) == ["rod"] and list(kept.bodies) == ["rod", "tool"]
    assert same(merged, kept) < 1e-13


@pytest.mark.parametrize("base, count", [(None, 0), ("free", 6), ("planar", 3), ("fixed", 0)])
def test_base_says_what_the_file_does_not(tmp_path, base, count):
    s = read(tmp_path, f'<body name="base"><geom size="0.1"/>{PIN}</body>', base=base)
    assert fb.assemble(s).n_u == count + 1


def test_motions_hold_the_base_where_the_file_has_it(tmp_path):
    inside = f'<body name="base" pos="0 0 2" euler="0 0 90"><geom size="0.1"/>{PIN}</body>'
    s = read(tmp_path, inside, base=fb.Slider("x", "rail"))
    position = fb.compile(s).poses([0.5, 0.0])["base"][1]
    assert position == pytest.approx([0, 0.5, 2], abs=1e-15)


def test_bodies_in_a_fixed_one_stay_welded(tmp_path):
    inside = f'<body name="a"><geom size="0.1"/><body name="b"><geom size="0.1"/>{PIN}</body></body>'
    for base in (None, "fixed"):
        s = read(tmp_path, inside, base=base, keep_fixed=True)
        assert s.joints["b_base"].kind == "weld" and fb.assemble(s).n_u == 1


def test_a_fixed_base_takes_the_free_joint_away(tmp_path):
    s = read(tmp_path, f'<body name="base"><freejoint/><geom size="0.1"/>{PIN}</body>', base="fixed")
    assert fb.assemble(s).coordinate_names == ("pin",)
    assert "base='fixed' holds the body" in str(s.reading)


def test_gravity_is_that_of_the_options(tmp_path):
    s = read(tmp_path, PIN, head='<option gravity="0 0 -3"/>')
    assert fb.assemble(s).values()["g"] == 3
    s = read(tmp_path, PIN, head='<option gravity="1 0 0"/>')
    assert s.gravity == (1, 0, 0)
    s = read(tmp_path, PIN, head='<option><flag gravity="disable"/></option>')
    assert s.gravity == (0, 0, 0)


# -- forces and constraints -----------------------------------------------------------------------------

TWO = PIN + PIN.replace("rod", "bar").replace("pin", "knee").replace("<body ", '<body pos="0 1 0" ')


def after(text: str) -> dict[str, str]:
    """What stands after the bodies of a file: the reader does not mind the order."""
    return {"head": text}


@pytest.mark.parametrize(
    "actuator, control, expected",
    [
        ('<motor name="m" joint="pin" gear="10"/>', 0.5, 5),
        ('<motor name="m" joint="pin" gear="10" ctrlrange="-1 1"/>', 3, 10),
        ('<motor name="m" joint="pin" gear="10" forcerange="-0.2 0.2"/>', 1, 2),
        ('<position name="m" joint="pin" kp="7" kv="2"/>', 0.5, 7 * (0.5 - 0.3) - 2 * 0.4),
        ('<position name="m" joint="pin" gear="2" kp="7"/>', 0.5, 2 * 7 * (0.5 - 0.6)),
        ('<velocity name="m" joint="pin" kv="3"/>', 0.5, 3 * (0.5 - 0.4)),
        ('<damper name="m" joint="pin" kv="3" ctrlrange="0 1"/>', 0.5, -3 * 0.5 * 0.4),
        (
            '<general name="m" joint="pin" gainprm="2" biastype="affine" biasprm="1 2 3"/>',
            0.5,
            1 + 1 + 0.6 + 1.2,
        ),
        ('<general name="m" joint="pin" gaintype="affine" gainprm="2 1 1"/>', 0.5, 0.5 * (2 + 0.3 + 0.4)),
    ],
)
def test_actuators_are_inputs(tmp_path, actuator, control, expected):
    s = read(tmp_path, PIN, head=f"<actuator>{actuator}</actuator>")
    assert s.reading.inputs == {"m": "u_m"}
    program = fb.compile(s)
    force = program.bias([0.3], [0.4], values={"u_m": 0}) - program.bias(
        [0.3], [0.4], values={"u_m": control}
    )
    rest = program.bias([0.3], [0.4], values={"u_m": control}) - fb.compile(read(tmp_path, PIN)).bias(
        [0.3], [0.4]
    )
    assert rest == pytest.approx([-expected], rel=1e-12)
    assert force.shape == (1,)


def test_an_actuator_begins_with_what_its_class_says(tmp_path):
    head = (
        '<default><position kp="50" kv="2"/></default><actuator><position name="m" joint="pin"/></actuator>'
    )
    program = fb.compile(read(tmp_path, PIN, head=head, symbols="none"))
    rest = fb.compile(read(tmp_path, PIN, symbols="none")).bias([0.3], [0.4])
    assert program.bias([0.3], [0.4], values={"u_m": 1}) - rest == pytest.approx(
        [-(50 * 0.7 - 0.8)], rel=1e-12
    )


TENDON = """<tendon><fixed name="cord" stiffness="4" damping="0.5" springlength="0.1"><joint joint="pin" coef="2"/>
<joint joint="knee" coef="-3"/></fixed></tendon>"""


def test_fixed_tendons_are_forces_on_their_joints(tmp_path):
    motor = '<actuator><motor name="m" tendon="cord"/></actuator>'
    program = fb.compile(read(tmp_path, TWO, head=TENDON + motor))
    q, u = np.array([0.3, 0.2]), np.array([0.4, 0.1])
    rest = program.bias(q, u, values={"u_m": 2.0}) - fb.compile(read(tmp_path, TWO)).bias(q, u)
    force = -4 * (2 * 0.3 - 3 * 0.2 - 0.1) - 0.5 * (2 * 0.4 - 3 * 0.1) + 2
    assert rest == pytest.approx([-2 * force, 3 * force], rel=1e-12)


def test_a_slack_tendon_pulls_beyond_its_rest_lengths(tmp_path):
    cord = TENDON.replace('damping="0.5" springlength="0.1"', 'springlength="-0.1 0.2"')
    program, rest = fb.compile(read(tmp_path, TWO, head=cord)), fb.compile(read(tmp_path, TWO))
    for q, force in (([0.2, 0.1], 0.0), ([0.2, 0.0], -4 * 0.2), ([0.0, 0.1], 4 * 0.2)):
        difference = program.bias(q, [0, 0]) - rest.bias(q, [0, 0])
        assert difference == pytest.approx([-2 * force, 3 * force], rel=1e-12, abs=1e-14)


def test_joint_equalities_are_constraints(tmp_path):
    head = '<equality><joint name="mimic" joint1="knee" joint2="pin" polycoef="0.1 2 0.5 0 0"/></equality>'
    s = read(tmp_path, TWO, head=head)
    assert list(s.constraints) == ["mimic"]
    motion = fb.simulate(s, 0.2, initial={"pin": 0.3})
    pin, knee = motion["pin"], motion["knee"]
    assert np.abs(knee - 0.1 - 2 * pin - 0.5 * pin**2).max() < 1e-12


def test_tendon_equalities_are_constraints(tmp_path):
    cord = (
        '<tendon><fixed name="a"><joint joint="pin" coef="1"/><joint joint="knee" coef="1"/></fixed></tendon>'
    )
    s = read(tmp_path, TWO, head=cord + '<equality><tendon tendon1="a" polycoef="0.5 0 0 0 0"/></equality>')
    motion = fb.simulate(s, 0.2, initial={"pin": 0.3})
    assert np.abs(motion["knee"] + motion["pin"] - 0.5).max() < 1e-12


LINKS = """<body name="a"><joint name="ja" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0 0 1"/>
<body name="b" pos="0 0 1"><joint name="jb" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 1 0 0"/></body>
</body>
<body name="c" pos="1 0 0"><joint name="jc" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0 0 1"/></body>"""


@pytest.mark.parametrize(
    "equality",
    [
        '<connect name="loop" body1="b" body2="c" anchor="1 0 0"/>',
        '<connect name="loop" site1="sb" site2="sc"/>',
    ],
)
def test_connected_bodies_close_a_loop(tmp_path, equality):
    bodies = LINKS.replace('<joint name="jb"', '<site name="sb" pos="1 0 0"/><joint name="jb"').replace(
        '<joint name="jc"', '<site name="sc" pos="0 0 1"/><joint name="jc"'
    )
    s = read(tmp_path, bodies, head=f"<equality>{equality}</equality>")
    assert s.joints["loop"].closes and s.joints["loop"].type == "ball"
    motion = fb.simulate(s, 0.1, initial={"ja": 0.2})
    assert motion["jb"] == pytest.approx(-motion["ja"], abs=1e-12)  # a parallelogram
    assert motion["jc"] == pytest.approx(motion["ja"], abs=1e-12)


def test_welded_bodies_close_a_loop(tmp_path):
    s = read(tmp_path, TWO, head='<equality><weld name="glue" body1="rod" body2="bar"/></equality>')
    assert s.joints["glue"].closes
    motion = fb.simulate(s, 0.1, initial={"pin": 0.2})
    assert motion["knee"] == pytest.approx(motion["pin"], abs=1e-12)


def test_keyframes_are_values_of_coordinates(tmp_path):
    s = read(tmp_path, TWO, head='<keyframe><key name="up" qpos="0.1 0.2"/><key qpos="1"/></keyframe>')
    assert s.reading.keyframes == {"up": {"pin": 0.1, "knee": 0.2}}
    assert "a keyframe of other joints: <key> 'key2'" in str(s.reading)


# -- what is left out, and what is refused --------------------------------------------------------------


@pytest.mark.parametrize(
    "body, head, text",
    [
        (PIN.replace("<joint ", '<joint range="-1 1" '), "", "no stop holds it at its limits, which limits=True reads: joint 'pin'"),
        (PIN.replace("<joint ", '<joint frictionloss="1" '), "", "it moves without its dry friction, which friction=True reads"),
        ('<body name="b"><joint name="p" type="ball" frictionloss="1"/>' + ROD + "</body>", "", "it moves without its dry friction, which friction=True reads: joint 'p'"),
        ('<body name="b"><joint name="p" type="ball" range="0 1"/>' + ROD + "</body>", "", "no stop holds it at its limits, which limits=True reads: joint 'p'"),
        ('<body name="b"><joint name="p" type="free" frictionloss="1"/>' + ROD + "</body>", "", "it moves without its dry friction, which friction=True reads: joint 'p'"),
        (PIN.replace("<joint ", '<joint springdamper="0.1 1" '), "", "springdamper: the spring and damper"),
        (PIN.replace("<joint ", '<joint stiffness="1 2" '), "", "coefficients of higher order are left out"),
        (PIN.replace("<joint ", '<joint colour="1" '), "", "colour: not an attribute that freebody knows"),
        (PIN.replace("<joint ", '<joint actuatorfrcrange="-1 1" '), "", "the sum of its actuators is not limited"),
        (PIN.replace("<body ", '<body gravcomp="1" '), "", "its weight acts in full"),
        (PIN.replace("<body ", '<body mocap="true" '), "", "a mocap body stands where the file has it"),
        (PIN.replace("</body>", '<plugin/></body>'), "", "a plugin is another simulator's code"),
        (PIN.replace("</body>", '<geom type="hfield" hfield="h"/></body>'), "", "a geom that cannot be read"),
        (PIN.replace("</body>", '<geom size="1" shellinertia="true"/></body>'), "", "the inertia of a shell"),
        (PIN, '<option density="1"/>', "no fluid acts"),
        (PIN, '<sensor><jointpos joint="pin"/></sensor>', "sensors: values of coordinates"),
        (PIN, '<deformable><skin/></deformable>', "nothing bends"),
        (PIN, '<tendon><spatial name="a"/></tendon>', "a spatial tendon: its force is left out"),
        (PIN, '<actuator><muscle joint="pin"/></actuator>', "left out: no muscle pulls"),
        (PIN, '<actuator><general joint="pin" dyntype="integrator"/></actuator>', "a state that the machine does not"),
        (PIN, '<actuator><position joint="pin" dampratio="1"/></actuator>', "dampratio: it has no damping"),
        (PIN, '<actuator><motor site="x"/></actuator>', "acts on sites or bodies"),
        (PIN, '<equality><flex/></equality>', "nothing is flexible"),
        (PIN, '<equality><joint joint1="pin" active="false"/></equality>', "it is not active"),
        (PIN, '<thing><a/></thing>', "not a part of MJCF that freebody knows"),
        ('<body name="m" mocap="true"/>' + PIN, '<equality><weld body1="m" body2="rod"/></equality>', "a mocap body drags"),
    ],
)  # fmt: skip
def test_what_is_left_out_is_said(tmp_path, body, head, text):
    assert text in str(read(tmp_path, body, head=head).reading)


def test_limits_are_stops_of_the_coordinate_not_of_the_turn_from_the_drawn_pose(tmp_path):
    s = read(tmp_path, PIN.replace("<joint ", '<joint range="-1 1" ref="0.5" '), head=RADIAN, limits=True)
    assert s.reading.initial == {"pin": 0.5}
    motion = fb.simulate(s, 3, initial=s.reading.initial | {"pin'": 3})
    assert motion.at(motion.events[0].time)["pin"] == pytest.approx(1, abs=1e-9)
    assert "limits" not in str(s.reading)


def test_the_range_of_a_ball_stops_its_turn_and_its_friction_acts_about_each_axis(tmp_path):
    """A ball of moments J alike about all axes, without weight: it turns about one axis until it stops or sticks."""
    geom = '<geom type="sphere" size="0.1" mass="1"/></body>'
    body = '<body name="b"><joint name="p" type="ball" range="0 40" frictionloss="0.002"/>' + geom
    s = read(tmp_path, body, head='<option gravity="0 0 0"/>', limits=True, friction=True, symbols="none")
    assert "p" not in str(s.reading).partition("touches")[0].partition("left out")[2]
    J, w, T = 0.004, 2.0, 0.002
    motion = fb.simulate(s, 2, initial={"p_wy": w})
    angle = math.radians(40)  # w t - T/(2 J) t² at the stop
    first = motion.events[0]
    assert first.time == pytest.approx((w - math.sqrt(w * w - 2 * T / J * angle)) / (T / J), rel=1e-9)
    assert motion["p_wy"][-1] == 0
    s = read(tmp_path, body.replace("40", "200"), limits=True)
    assert "the turn of a ball is at most half a turn: joint 'p'" in str(s.reading)


def test_friction_of_a_joint_sticks(tmp_path):
    pin = PIN.replace("<joint ", '<joint frictionloss="3" ')
    moment = 2 * 9.81 * 0.5  # of the weight, on the level rod
    for start, sticks in ((math.asin(2.9 / moment), True), (math.asin(3.1 / moment), False)):
        s = read(tmp_path, pin, friction=True)
        motion = fb.simulate(s, 0.5, initial={"pin": start})
        assert (abs(motion["pin"][-1] - start) < 1e-12) == sticks
    assert fb.assemble(s).values()["f_pin"] == 3


def test_a_fixed_tendon_stops_at_its_range(tmp_path):
    fingers = "".join(
        f'<body name="f{i}"><joint name="j{i}" type="slide" axis="1 0 0"/>{ROD}</body>' for i in "12"
    )
    tendon = '<tendon><fixed name="t" range="-1 1"><joint joint="j1" coef="1"/><joint joint="j2" coef="2"/></fixed></tendon>'
    s = read(tmp_path, fingers, head=tendon, limits=True)
    motion = fb.simulate(s, 1, initial={"j1'": 1, "j2'": 1})
    (event,) = [event for event in motion.events if "impact" in str(event)]
    assert event.time == pytest.approx(1 / 3, abs=1e-9)
    # masses m, m and the impulse P (1, 2): j1' + 2 j2' = 0 after it
    assert [motion[name][-1] for name in ("j1'", "j2'")] == pytest.approx([1 - 3 / 5, 1 - 6 / 5], abs=1e-9)


def test_a_joint_that_is_left_out_by_the_compiler_has_no_limits(tmp_path):
    s = read(tmp_path, PIN.replace("<joint ", '<joint range="-1 1" limited="false" '))
    assert s.reading.limits == {}


@pytest.mark.parametrize(
    "parts, message",
    [
        ({"root": "<robot/>"}, "line 1: expected <mujoco> as the root of an MJCF file, got <robot>. This is URDF: rename the file to end in .urdf."),
        ({"root": "<sdf/>"}, "got <sdf>. This is SDF: convert it first"),
        ({"root": "<mujocoinclude/>"}, "got <mujocoinclude>. This is a part of an MJCF file: read the file that includes it."),
        ({"root": "<html/>"}, "got <html>. A model file of freebody ends in .toml."),
        ({"root": "<mujoco/>"}, "line 1: expected a <worldbody>, got none. A part of a model is read with the file that includes it."),
        ({"root": "<mujoco>"}, "expected XML, got text with an error"),
        ({"root": '<!DOCTYPE a [<!ENTITY b "c">]><mujoco/>'}, "expected no document type"),
        ({"head": '<compiler angle="grad"/>'}, "expected one of 'radian', 'degree' for angle= of <compiler>, got 'grad'."),
        ({"head": '<compiler coordinate="global"/>'}, "expected local coordinates, got coordinate='global'"),
        ({"head": '<compiler eulerseq="xy"/>'}, "expected three of x, y, z (or X, Y, Z) for eulerseq, got 'xy'."),
        ({"head": '<default><default><joint/></default></default>'}, "expected the attribute 'class' of a <default> in another one."),
        ({"head": '<default><default class="a"/><default class="a"/></default>'}, "expected each class once, got 'a' again."),
        ({"bodies": PIN.replace("<joint ", '<joint class="lag" '), "head": '<default><default class="leg"/></default>'}, "unknown class 'lag' of <joint>; "),
        ({"bodies": '<body euler="0 0 0" quat="1 0 0 0"/>'}, "expected one orientation of <body>, got quat and euler."),
        ({"bodies": '<body quat="0 0 0 0"/>'}, "expected a quaternion of <body> that is not zero."),
        ({"bodies": '<body zaxis="0 0 0"/>'}, "expected a direction for zaxis= of <body>, got a vector of length 0."),
        ({"bodies": '<body pos="0 0"/>'}, 'expected 3 numbers for pos= of <body>, got "0 0".'),
        ({"bodies": PIN + PIN}, "expected each body once, got 'rod' again."),
        ({"bodies": "<joint/>"}, "expected joints in bodies, got one in <worldbody>."),
        ({"bodies": PIN.replace("0 1 0", "0 0 0")}, "expected a direction for axis= of <joint>"),
        ({"bodies": PIN.replace("<joint ", '<joint type="screw" ')}, "for type= of <joint>, got 'screw'."),
        ({"bodies": PIN.replace("<joint ", '<freejoint/><joint ')}, "expected the free joint of body 'rod' alone, on a body directly in <worldbody>, got other joints beside it."),
        ({"bodies": f"<body name='a'>{PIN.replace('<joint ', '<joint type=@free@ ')}</body>".replace("@", '"')}, "got it in body 'a'."),
        ({"bodies": PIN.replace("<joint ", '<joint range="0 1" '), "head": '<compiler autolimits="false"/>'}, "expected limited= of a joint with range=, since autolimits='false'."),
        ({"bodies": '<body name="a"><joint/></body>'}, "expected a mass of body 'a' or of one that it carries, since it has a joint."),
        ({"bodies": PIN.replace(ROD, ROD + ROD)}, "expected one <inertial> in body 'rod', got another."),
        ({"bodies": PIN.replace('mass="2"', 'mass="-2"')}, "expected a mass that is not negative, got -2 kg."),
        ({"bodies": "<geom type='cone'/>"}, "for type= of <geom>, got 'cone'."),
        ({"bodies": "<geom type='box' size='1 1'/>"}, "expected 3 numbers for the size of a box, got 2."),
        ({"bodies": "<geom size='-1'/>"}, "expected sizes of a sphere above zero, got -1."),
        ({"bodies": "<geom size='1' density='-1'/>"}, "expected a mass or density that is not negative"),
        ({"bodies": "<geom size='1' fromto='0 0 0 1 1 1'/>"}, "expected fromto= of a capsule, cylinder, ellipsoid or box, got it of a sphere."),
        ({"bodies": "<geom type='mesh' mesh='no'/>"}, "unknown mesh 'no'."),
        ({"bodies": PIN.replace("</body>", "<composite/></body>")}, "<composite> in a body is not read: bodies would be missing. Write the file that MuJoCo makes"),
        ({"bodies": "<body name='b'><joint name='p' type='ball'/><joint pos='1 0 0' axis='0 1 0'/><geom size='1'/></body>"}, "expected no turn after joint 'p' in body 'b', got a hinge, which MuJoCo refuses, too: put the hinges before the ball"),
        ({"head": "<include file='no.xml'/>"}, "cannot include 'no.xml': no such file near the robot's file."),
        ({"head": "<include file='arm.xml'/>"}, "expected each file included once, got 'arm.xml' again."),
        ({"head": "<include file='/etc/passwd'/>"}, "cannot include '/etc/passwd': no such file near the robot's file."),
        ({"head": "<include file='file:///etc/passwd'/>"}, "cannot include 'file:///etc/passwd': expected a path or package://, got file://."),
        ({"head": "<actuator><motor joint='pan'/></actuator>"}, "unknown joint 'pan' of <motor> 'actuator1'; "),
        ({"head": "<actuator><motor/></actuator>"}, "expected joint= or tendon= of <motor> 'actuator1'."),
        ({"head": "<tendon><fixed name='a'/></tendon>"}, "expected joints in the fixed tendon 'a'."),
        ({"head": "<tendon><fixed name='a'><joint joint='pan' coef='1'/></fixed></tendon>"}, "unknown joint 'pan' of tendon 'a'; "),
        ({"head": "<equality><connect body1='rad' anchor='0 0 0'/></equality>"}, "unknown body 'rad' of equality 'equality1'; "),
        ({"head": "<equality><joint/></equality>"}, "expected the attribute 'joint1' of equality 'equality1'."),
        ({"head": "<equality><tendon/></equality>"}, "expected the attribute 'tendon1' of equality 'equality1'."),
        *((
            {"bodies": PIN.replace("<joint ", f"<joint {text} ")}, message) for text, message in (
            ('ref="1 2"', 'expected a number for ref= of <joint>, got "1 2".'),
            ('range="1 2 3"', 'expected 2 numbers for range= of <joint>, got "1 2 3".'),
            ('limited="maybe"', "expected one of 'false', 'true', 'auto' for limited= of <joint>, got 'maybe'."),
            ('stiffness="inf"', 'expected a number for stiffness= of <joint>, got "inf".'),
            ('armature="-1"', "expected armature= of <joint> that is not negative, got -1."),
            ('frictionloss="-1"', "expected frictionloss= of <joint> that is not negative, got -1."),
            ('springdamper="1"', 'expected 2 numbers for springdamper= of <joint>, got "1".'),
            ('pos="nan 0 0"', 'expected 3 numbers for pos= of <joint>, got "nan 0 0".'),
            ('pos="1e61 0 0"', 'expected numbers of at most 1e60 for pos= of <joint>, got "1e61 0 0".'),
        )),
        *((
            {"bodies": PIN.replace("<body ", f"<body {text} ")}, message) for text, message in (
            ('mocap="yes"', "expected one of 'false', 'true' for mocap= of <body>, got 'yes'."),
            ('gravcomp="x"', 'expected a number for gravcomp= of <body>, got "x".'),
            ('quat="1 0 0"', 'expected 4 numbers for quat= of <body>, got "1 0 0".'),
            ('quat="1e200 0 0 0"', "expected numbers of at most 1e60 for quat= of <body>"),
            ('euler="1 0"', 'expected 3 numbers for euler= of <body>, got "1 0".'),
            ('axisangle="0 0 0 1"', "expected a direction for axisangle= of <body>, got a vector of length 0."),
            ('xyaxes="1 0 0 1 0 0"', "expected a direction for xyaxes= of <body>, got a vector of length 0."),
            ('childclass="no"', "unknown class 'no' of <joint>; no names are known yet."),
        )),
        *((
            {"bodies": PIN.replace("</body>", f"<geom {text}/></body>").replace(ROD, "")}, message) for text, message in (
            ("", "expected the attribute 'size' of <geom>."),
            ('size="1e300"', 'expected numbers of at most 1e60 for size= of <geom>, got "1e300".'),
            ('size="1" mass="x"', 'expected a number for mass= of <geom>, got "x".'),
            ('size="1" group="x"', 'expected a number for group= of <geom>, got "x".'),
            ('size="1" contype="1.5"', "expected a whole number for contype= of <geom>, got 1.5."),
            ('size="1" rgba="a b c d"', 'expected 4 numbers for rgba= of <geom>, got "a b c d".'),
            ('size="1" shellinertia="x"', "expected one of 'false', 'true' for shellinertia= of <geom>, got 'x'."),
            ('type="capsule" size="1" fromto="0 0 0"', 'expected 6 numbers for fromto= of <geom>, got "0 0 0".'),
            ('type="capsule" size="1" fromto="0 0 0 0 0 0"', "expected a direction for fromto= of <geom>"),
            ('type="mesh"', "expected the attribute 'mesh' of <geom>."),
            ('name="g" size="1"/><geom name="g" size="1"', "expected each geom once, got 'g' again."),
        )),
        *((
            {"head": f'<asset><mesh name="m" {text}/></asset>',
             "bodies": PIN.replace("</body>", '<geom type="mesh" mesh="m"/></body>').replace(ROD, "")},
            f"expected a mass of body 'rod' or of one that it carries, since it has a joint: m: {message}",
        ) for text, message in (
            ("", "expected three numbers for each vertex, got 0 numbers."),
            ('vertex="0 0 0 1"', "expected three numbers for each vertex, got 4 numbers."),
            ('vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 1 9"', "expected face= with faces of its own vertices."),
            ('vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 1 -1"', "expected face= with faces of its own vertices."),
            ('vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 1"', "expected face= with faces of its own vertices."),
            ('vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 1 1e30"', "expected face= with faces of its own vertices."),
            ('vertex="0 0 0 1 0 0 0 1 0 1 1 0"', "expected points with a convex hull."),
            ('vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 1 2 0 3 1 0 2 3 1 3 2" inertia="exact"', "expected a mesh with a volume, got one that is inside out or flat."),
            ('vertex="0 0 0 1 0 0 0 1 0 0 0 0" face="0 1 2"', "expected a mesh with a volume; inertia='shell' gives one to a sheet."),
            ('vertex="0 0 0 1 0 0 0 1 0 0 0 1" inertia="magic"', "arm.xml, line 2: expected one of 'legacy', 'convex'"),
            ('vertex="0 0 0 1 0 0 0 1 0 0 0 1" scale="1 1"', "arm.xml, line 2: expected 3 numbers for scale= of <mesh>"),
            ('vertex="0 0 0 1 0 0 0 1 0 0 0 1" refquat="0 0 0 0"', "arm.xml, line 2: expected a quaternion of <mesh>"),
            ('file="no.stl"', "no such file near the robot's file."),
        )),
        *((
            {"head": head}, message) for head, message in (
            ('<asset><mesh name="m" vertex="0 0 0"/><mesh name="m" vertex="0 0 0"/></asset>', "expected each mesh once, got 'm' again."),
            ('<option gravity="x"/>', 'expected 3 numbers for gravity= of <option>, got "x".'),
            ('<option><flag gravity="perhaps"/></option>', "expected one of 'disable', 'enable' for gravity= of <flag>, got 'perhaps'."),
            ('<compiler inertiafromgeom="x"/>', "for inertiafromgeom= of <compiler>, got 'x'."),
            ('<compiler boundmass="x"/>', 'expected a number for boundmass= of <compiler>, got "x".'),
            ('<compiler inertiagrouprange="1"/>', 'expected 2 numbers for inertiagrouprange= of <compiler>, got "1".'),
            ('<compiler balanceinertia="1"/>', "expected one of 'false', 'true' for balanceinertia= of <compiler>, got '1'."),
            ('<default><default class="main"/></default>', "expected each class once, got 'main' again."),
            ('<default><joint armature="x"/></default>', 'expected a number for armature= of <joint>, got "x".'),
            ('<actuator><motor joint="pin" gear="x"/></actuator>', 'expected a number for gear= of <motor>, got "x".'),
            ('<actuator><motor joint="pin" ctrlrange="1"/></actuator>', 'expected 2 numbers for ctrlrange= of <motor>, got "1".'),
            ('<actuator><motor joint="pin" forcerange="2 1"/></actuator>', "expected the smaller one first of forcerange= of <motor>, got 2 1."),
            ('<actuator><motor joint="pin" ctrllimited="x"/></actuator>', "for ctrllimited= of <motor>, got 'x'."),
            ('<actuator><motor tendon="no"/></actuator>', "unknown tendon 'no' of <motor>; no names are known yet."),
            ('<actuator><motor name="a" joint="pin"/><motor name="a" joint="pin"/></actuator>', "expected each actuator once, got 'a' again."),
            ('<tendon><fixed name="t"><joint joint="pin"/></fixed></tendon>', "expected the attribute 'coef' of <joint>."),
            ('<tendon><fixed name="t" range="1"><joint joint="pin" coef="1"/></fixed></tendon>', 'expected 2 numbers for range= of <fixed>, got "1".'),
            ('<tendon><fixed name="t" springlength="1 2 3"  stiffness="1"><joint joint="pin" coef="1"/></fixed></tendon>', "expected one or two numbers for springlength= of <fixed> 't', got 3."),
            ('<tendon><fixed name="t"/><fixed name="t"/></tendon>', "expected each tendon once, got 't' again."),
            ('<equality><connect body1="rod"/></equality>', "expected the attribute 'anchor' of <connect>."),
            ('<equality><weld body1="rod" relpose="1 2"/></equality>', 'expected 7 numbers for relpose= of <weld>, got "1 2".'),
            ('<equality><joint joint1="pin" polycoef="x"/></equality>', 'expected a number for polycoef= of <joint>, got "x".'),
            ('<equality><joint joint1="pin" active="x"/></equality>', "for active= of <joint>, got 'x'."),
            ('<equality><joint joint1="pin" joint2="pin"/></equality>', "contains no coordinate: '0' does not restrict the motion."),
            ('<equality><connect site1="a" site2="b"/></equality>', "unknown site 'a' of equality 'equality1'; no names are known yet."),
            ('<equality><tendon tendon1="no"/></equality>', "unknown tendon 'no' of <tendon>; no names are known yet."),
            ('<keyframe><key qpos="x"/></keyframe>', 'expected a number for qpos= of <key>, got "x".'),
            ('<keyframe><key name="a" qpos="1"/><key name="a" qpos="2"/></keyframe>', "expected each key once, got 'a' again."),
            ('<include/>', "expected the attribute 'file' of <include>."),
            (f'<include file="{"a" * 5000}"/>', "no such file near the robot's file."),
            ('<include file="../../../../../../../../../etc/passwd"/>', "no such file near the robot's file."),
        )),
        ({"bodies": PIN.replace("</body>", '<joint type="ball"/></body>')}, "Chain 'rod' has a ball, which makes every turn about its point."),
    ],
)  # fmt: skip
def test_broken_files_are_refused_with_line_and_cure(tmp_path, parts, message):
    path = tmp_path / "arm.xml"
    body = f"<mujoco>\n{parts.get('head', '')}\n<worldbody>{parts.get('bodies', PIN)}</worldbody></mujoco>"
    path.write_text(parts.get("root", body))
    with pytest.raises(FormatError) as error:
        fb.read(path)
    assert message in str(error.value) and "arm.xml, line " in str(error.value)


def test_a_friction_below_zero_is_refused_with_its_line(tmp_path):
    ball = '<body><freejoint/><geom size="1" friction="-1"/></body>'
    with pytest.raises(
        FormatError, match="arm.xml, line 3: expected a friction of <geom> that is not negative, got -1"
    ):
        read(tmp_path, ball, contacts="floor")


def test_parts_are_refused_in_their_own_lines(tmp_path):
    for text, message in (
        (
            "<mujoco>\n<include file='arm.xml'/></mujoco>",
            "b.xml, line 2: expected each file included once, got 'arm.xml'",
        ),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><mujoco/>", "b.xml, line 1: expected no document type"),
        ("<mujoco>", "b.xml, line 1: expected XML, got text with an error"),
        (
            f"<mujoco>\n{'<body>' * 199}{'</body>' * 199}</mujoco>",
            "b.xml, line 2: expected elements nested at most 200 deep, got more",
        ),
    ):
        (tmp_path / "b.xml").write_text(text)
        with pytest.raises(FormatError, match=message):
            read(tmp_path, PIN, head="<include file='b.xml'/>")


def test_attributes_of_the_compiler_that_are_not_read_are_said(tmp_path):
    s = read(tmp_path, PIN, head='<compiler alignfree="true" magic="1" texturedir="x"/>')
    assert "alignfree: a free joint keeps the origin and axes of its body: <compiler>, line 1" in str(
        s.reading
    )
    assert "magic: not an attribute that freebody knows" in str(s.reading) and "texturedir" not in str(
        s.reading
    )


def test_options_are_checked(tmp_path):
    with pytest.raises(
        ModelError,
        match="Expected base= one of 'fixed', 'free', 'planar', or motions such as .*, got 'wheels'",
    ):
        read(tmp_path, PIN, base="wheels")


def test_hostile_files_end(tmp_path):
    deep = "<body>" * 300 + "</body>" * 300
    with pytest.raises(FormatError, match="nested at most 200 deep"):
        read(tmp_path, deep)
    with pytest.raises(FormatError, match="at most 500000 elements"):
        read(tmp_path, "<body/>" * 500_001)
    (tmp_path / "huge.stl").write_bytes(b" " * 80 + struct.pack("<I", 10**9))
    s = read(tmp_path, PIN.replace("</body>", '<geom type="mesh" mesh="huge"/></body>'),
             head='<asset><mesh file="huge.stl"/></asset>')  # fmt: skip
    assert "expected STL, got 84 bytes whose header counts 1000000000 triangles" in str(s.reading)
    (tmp_path / "bad.msh").write_bytes(struct.pack("<4i", 10**9, 0, 0, 10**9))
    s = read(tmp_path, PIN.replace("</body>", '<geom type="mesh" mesh="bad"/></body>'),
             head='<asset><mesh file="bad.msh"/></asset>')  # fmt: skip
    assert "expected MSH of" in str(s.reading)
