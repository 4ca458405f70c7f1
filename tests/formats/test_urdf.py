"""Robots in URDF: against machines that are described by hand, and every message."""

from __future__ import annotations

import pickle
import struct
from pathlib import Path
from time import process_time

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.errors import FormatError, MassError, ModelError, SimulationError

ROD = """<inertial><origin xyz="0 0 {c}"/><mass value="{m}"/>
<inertia ixx="{a}" iyy="{a}" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>"""
BAR = '<link name="{name}">' + ROD.format(c=-0.5, m=2, a=0.2) + "</link>"


def joint(
    name: str, parent: str, child: str, kind: str = "continuous", inside: str = "", axis: str = "0 1 0"
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="{axis}"/>{inside}</joint>'
    )


def bar(name: str) -> str:
    return BAR.format(name=name)


def read(tmp_path: Path, *parts: str, name: str = "arm.urdf", **options: object) -> fb.System:
    path = tmp_path / name
    path.write_text("\n".join(["<robot name='arm'>", *parts, "</robot>"]))
    return fb.read(path, **options)  # type: ignore[arg-type]


DOUBLE = [
    '<link name="world"/>', bar("upper"), bar("lower"), joint("shoulder", "world", "upper"),
    joint("elbow", "upper", "lower", inside='<origin xyz="0 0.1 -1" rpy="0 0 1.5707963267949"/>'),
]  # fmt: skip


def by_hand() -> fb.System:
    s = fb.System("arm")
    s.gravity = (0, 0, -9.81)
    rod = fb.MassProperties(2, (0, 0, -0.5), ((0.2, 0, 0), (0, 0.2, 0), (0, 0, 0.01)))
    upper, lower = s.body("upper", rod), s.body("lower", rod)
    s.hinge("shoulder", s.ground, upper, axis="y", coordinate="shoulder")
    turned = fb.Rotation.axis_angle("z", "pi/2")
    s.hinge("elbow", upper, lower, at=(0, 0.1, -1), parent_axes=turned, axis="y", coordinate="elbow")
    return s


def same(s: fb.System, other: fb.System, seed: int = 0) -> float:
    """Largest relative difference of mass matrix and forward dynamics at a random state."""
    random = np.random.default_rng(seed)
    one, two = fb.compile(s), fb.compile(other)
    model = fb.assemble(other)
    q, u = random.uniform(-1, 1, model.n_q), random.uniform(-1, 1, model.n_u)
    pairs = [
        (one.mass_matrix(q), two.mass_matrix(q)),
        (one.forward_dynamics(q, u), two.forward_dynamics(q, u)),
    ]
    return max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs)


@pytest.mark.parametrize("symbols", ["none", "masses", "all"])
def test_a_robot_is_the_machine_described_by_hand(tmp_path, symbols):
    s = read(tmp_path, *DOUBLE, symbols=symbols)
    assert list(s.bodies) == ["upper", "lower"] and fb.assemble(s).coordinate_names == ("shoulder", "elbow")
    assert same(s, by_hand()) < 1e-13


def test_equations_hold_the_links_by_name(tmp_path):
    s = read(tmp_path, '<link name="world"/>', bar("rod"), joint("pin", "world", "rod"))
    text = str(fb.equations(s))
    assert "m_rod" in text and "I_rod_yy" in text and "c_rod_z" in text and "g" in text


def test_lengths_are_parameters_when_all_are_asked_for(tmp_path):
    s = read(tmp_path, *DOUBLE, symbols="all")
    assert fb.assemble(s).values()["r_elbow_z"] == -1


FIXED = [
    '<link name="world"/>', bar("upper"), bar("lower"), '<link name="tool"/>', joint("shoulder", "world", "upper"),
    joint("glue", "upper", "lower", "fixed", '<origin xyz="0 0.1 -1" rpy="0.3 -0.2 0.7"/>'),
    joint("flange", "lower", "tool", "fixed", '<origin xyz="0 0 -1"/>'),
]  # fmt: skip


def test_fixed_joints_merge_their_links_into_one_body(tmp_path):
    merged, kept = read(tmp_path, *FIXED), read(tmp_path, *FIXED, keep_fixed=True)
    assert list(merged.bodies) == ["upper"] and list(kept.bodies) == ["upper", "lower", "tool"]
    assert same(merged, kept) < 1e-13


def test_frames_of_all_links_are_kept(tmp_path):
    s = read(tmp_path, *FIXED)
    point, axes = s.reading.frames["tool"]
    R = fb.Rotation.euler("ZYX", 0.7, -0.2, 0.3)
    assert point.body.name == "upper"
    expected = np.array([0, 0.1, -1]) + np.array(R, float) @ [0, 0, -1]
    assert np.array(point.components, float) == pytest.approx(expected, abs=1e-15)
    assert np.array(axes, float) == pytest.approx(np.array(R, float), abs=1e-15)


def test_a_free_base_falls(tmp_path):
    s = read(tmp_path, *DOUBLE[1:3], DOUBLE[4], base="free")
    model = fb.assemble(s)
    assert model.n_u == 7
    q = np.zeros(model.n_q)
    q[list(model.coordinate_names).index("base_e0")] = 1
    a = fb.compile(s).forward_dynamics(q, np.zeros(7))
    assert dict(zip(model.speed_names, a, strict=True))["base_vz"] == pytest.approx(-9.81, abs=1e-13)


def test_a_planar_base_slides(tmp_path):
    s = read(tmp_path, *DOUBLE[1:3], DOUBLE[4], base="planar")
    assert fb.assemble(s).coordinate_names[:3] == ("base_x", "base_y", "base_turn")


def test_a_base_moves_by_given_motions(tmp_path):
    base = [fb.Slider("x", "rail"), fb.Hinge("z", "shoulder")]
    s = read(tmp_path, *DOUBLE[1:3], DOUBLE[4], base=base)
    names = fb.assemble(s).coordinate_names
    assert names[:2] == ("rail", "shoulder") and len(set(names)) == len(names) == 3
    alone = fb.compile(read(tmp_path, bar("a"), base=fb.Slider("x", "rail")))
    assert float(alone.mass_matrix([0.3])[0, 0]) == pytest.approx(2, abs=1e-15)


def test_a_joint_that_mimics_follows(tmp_path):
    follow = '<mimic joint="left" multiplier="-2" offset="0.1"/>'
    s = read(tmp_path, '<link name="w"/>', bar("a"), bar("b"), joint("left", "w", "a"),
             joint("right", "w", "b", inside=follow))  # fmt: skip
    model = fb.assemble(s)
    assert model.coordinate_names == ("left",)
    assert str(s.joints["right"].primitives[0].coordinate) == "1/10 - 2*left(t)"
    # each rod: 0.2 + 2 · 0.5² about its pin; the second turns twice as fast
    assert float(fb.compile(s).mass_matrix([0.3])[0, 0]) == pytest.approx((1 + 4) * 0.7, abs=1e-14)


@pytest.mark.parametrize(
    ("kind", "axis", "expected"),
    [("prismatic", "1 0 0", "slider"), ("floating", "1 0 0", "free"), ("planar", "0 1 0", "planar"),
     ("spherical", "1 0 0", "ball"), ("revolute", "0 0 -2", "hinge")],
)  # fmt: skip
def test_every_type_of_joint(tmp_path, kind, axis, expected):
    s = read(tmp_path, '<link name="w"/>', bar("a"), joint("j", "w", "a", kind, axis=axis))
    assert s.joints["j"].type == expected
    fb.compile(s)


def test_a_planar_joint_turns_about_its_axis(tmp_path):
    s = read(tmp_path, '<link name="w"/>', bar("a"), joint("j", "w", "a", "planar", axis="0.6 0 0.8"))
    M = fb.compile(s).mass_matrix([0, 0, 0])
    n, c = np.array([0.6, 0, 0.8]), np.array([0, 0, -0.5])
    about = n @ np.diag([0.2, 0.2, 0.01]) @ n + 2 * (c @ c - (n @ c) ** 2)
    assert float(M[2, 2]) == pytest.approx(about, abs=1e-14)


def test_dampers_and_springs(tmp_path):
    inside = '<dynamics damping="0.5" spring_stiffness="3" spring_reference="0.2"/>'
    s = read(tmp_path, '<link name="w"/>', bar("a"), joint("j", "w", "a", inside=inside), symbols="none")
    s.gravity = (0, 0, 0)
    a = fb.compile(s).forward_dynamics([0.5], [2.0])
    assert float(a[0]) == pytest.approx(-(3 * 0.3 + 0.5 * 2) / 0.7, abs=1e-14)


def test_names_become_identifiers_that_never_clash(tmp_path):
    s = read(tmp_path, '<link name="w"/>', bar("left-arm"), bar("left_arm"), bar("3"), joint("t", "w", "left-arm"),
             joint("if", "w", "left_arm"), joint("g", "w", "3"))  # fmt: skip
    assert list(s.bodies) == ["left_arm", "left_arm_2", "_3"]
    assert s.reading.names == {"left-arm": "left_arm", "left_arm": "left_arm_2", "3": "_3", "if": "if_"}
    assert fb.assemble(s).coordinate_names == ("t_2", "if_", "g_2")


def test_a_tip_without_mass_is_fixed_and_said(tmp_path):
    s = read(tmp_path, *DOUBLE, '<link name="finger"/>', joint("grip", "lower", "finger", "prismatic"))
    assert fb.assemble(s).coordinate_names == ("shoulder", "elbow")
    assert "fixed at zero" in str(s.reading) and "joint 'grip'" in str(s.reading)
    assert s.reading.frames["finger"][0].body.name == "lower"


def test_a_joint_without_mass_moves_if_one_with_mass_mimics_it(tmp_path):
    s = read(tmp_path, *DOUBLE, '<link name="knob"/>', joint("knob", "world", "knob"), bar("arm"),
             joint("arm", "world", "arm", inside='<mimic joint="knob"/>'))  # fmt: skip
    assert fb.assemble(s).coordinate_names == ("shoulder", "elbow", "knob")
    fb.compile(s).forward_dynamics(np.zeros(3), np.zeros(3))


def test_masses_that_no_body_has_are_kept_and_said(tmp_path):
    wrong = '<link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="3"/></inertial></link>'
    s = read(tmp_path, '<link name="w"/>', wrong, joint("j", "w", "a", axis="0 0 1"))
    assert "no body can have" in str(s.reading) and "3 > 1 + 1" in str(s.reading)
    motion = fb.simulate(s, 1, initial={"j'": 2.0})
    assert motion["j"][-1] == pytest.approx(2, abs=1e-12)
    assert float(fb.compile(s).mass_matrix([0.0])[0, 0]) == 3


def test_values_of_possible_masses_are_checked_as_ever(tmp_path):
    s = read(tmp_path, *DOUBLE)
    with pytest.raises(MassError, match="negative"):
        fb.simulate(s, 1, values={"m_upper": -1})


def test_the_report_names_each_rule_once(tmp_path):
    collision = "<collision><geometry><sphere radius='1'/></geometry></collision>"
    links = [bar(f"l{i}").replace("</link>", collision + "</link>") for i in range(5)]
    s = read(tmp_path, '<link name="w"/>', *links, *[joint(f"j{i}", "w", f"l{i}") for i in range(5)],
             "<gazebo/>", "<transmission name='x'/>")  # fmt: skip
    text = str(s.reading)
    assert text.count("<collision>") == 1 and "and 2 more" in text
    assert sum("collision" in note.what for note in s.reading.notes) == 5
    assert "<gazebo>" in text and "<transmission>" in text and "9.81" in text
    assert text.startswith("Read from arm.urdf: 5 joints, 6 links.")


def test_limits_and_dry_friction_are_kept_or_said(tmp_path):
    inside = '<limit lower="-1" upper="2" effort="30" velocity="4"/><dynamics friction="0.7"/>'
    s = read(tmp_path, '<link name="w"/>', bar("a"), joint("j", "w", "a", "revolute", inside))
    assert s.reading.limits == {"j": {"lower": -1, "upper": 2, "effort": 30, "velocity": 4}}
    text = str(s.reading)
    assert "no stop holds it at its limits, which limits=True reads: joint 'j', line 5, -1 to 2" in text
    assert "it moves without its dry friction, which friction=True reads: joint 'j', line 5, 0.7" in text
    assert (
        "nothing limits the drive: s.reading.limits has its limits: joint 'j', line 5, effort 30, velocity 4"
        in text
    )


def test_limits_and_dry_friction_are_read_when_asked_for(tmp_path):
    inside = '<limit lower="-0.25" upper="2"/><dynamics friction="0.7"/>'
    parts = '<link name="w"/>', bar("a"), joint("j", "w", "a", "revolute", inside)
    s = read(tmp_path, *parts, limits=True, friction=True)
    assert s.reading.notes[1:] == [] and list(s.contacts) == ["j_stop", "j_friction"]
    motion = fb.simulate(s, 5, initial={"j": 1.5})
    assert motion.at(motion.events[0].time)["j"] == pytest.approx(-0.25, abs=1e-9)
    assert float(np.abs(motion.energy.residual).max()) < 1e-8
    assert fb.assemble(s).values()["f_j"] == 0.7


def test_a_pose_beyond_the_limits_is_said_and_the_nearest_is_the_start(tmp_path):
    inside = '<limit lower="-3" upper="-0.5"/>'
    s = read(tmp_path, '<link name="w"/>', bar("a"), joint("j", "w", "a", "revolute", inside), limits=True)
    assert s.reading.initial == {"j": -0.5} and "0 is not in -3 to -0.5" in str(s.reading)
    assert fb.simulate(s, 0.1, initial=s.reading.initial)["j"][0] == -0.5
    with pytest.raises(SimulationError, match="j_stop"):
        fb.simulate(s, 0.1)


@pytest.mark.parametrize("ends", ['lower="0" upper="0"', 'lower="1" upper="-1"'])
def test_limits_without_a_range_stop_nothing(tmp_path, ends):
    inside = f"<limit {ends}/>"
    s = read(tmp_path, '<link name="w"/>', bar("a"), joint("j", "w", "a", "revolute", inside), limits=True)
    assert not s.contacts and "limits without a range between them stop nothing: joint 'j'" in str(s.reading)


def test_limits_and_friction_of_a_follower_are_those_of_the_joint_that_it_mimics(tmp_path):
    def limited(low: float, high: float, friction: float, more: str = "") -> str:
        return f'<limit lower="{low}" upper="{high}"/><dynamics friction="{friction}"/>{more}'

    mimic = '<mimic joint="a" multiplier="-2" offset="1"/>'
    s = read(tmp_path, '<link name="w"/>', bar("A"), bar("B"),
             joint("a", "w", "A", "prismatic", limited(-1, 1, 0.5)),
             joint("b", "w", "B", "prismatic", limited(0, 4, 0.25, mimic)), limits=True, friction=True)  # fmt: skip
    stop, friction = s.contacts.values()
    # 0 <= 1 - 2 a <= 4
    assert (stop.low, stop.high) == (-1, sympy.Rational(1, 2)) and fb.assemble(s).values()["f_a"] == 1
    assert "its limits are those of the joint that it follows: joint 'b', line 8, 'a' -1 to 0.5" in str(
        s.reading
    )


def test_angles_are_taken_as_right_angles_by_their_decimals(tmp_path):
    def axes(rpy: str) -> np.ndarray:
        s = read(
            tmp_path, '<link name="w"/>', bar("a"), joint("j", "w", "a", inside=f'<origin rpy="{rpy}"/>')
        )
        return np.array(s.joints["j"].parent_axes, float)

    assert set(axes("1.57079632679 0 -3.14159265359").flat) == {-1, 0, 1}
    rounded = axes("1.5708 0 0")
    assert rounded[2, 2] == pytest.approx(np.cos(1.5708), abs=1e-16) and rounded[2, 2] != 0


def test_solids_are_drawn(tmp_path):
    visual = """<visual><origin xyz="0 0 1"/><geometry><box size="1 2 3"/></geometry><material name="blue"/></visual>
    <visual><geometry><cylinder radius="0.1" length="2"/></geometry></visual></link>"""
    s = read(tmp_path, '<material name="blue"><color rgba="0 0 1 1"/></material>', '<link name="w"/>',
             bar("a").replace("</link>", visual), joint("j", "w", "a"))  # fmt: skip
    shape = s.bodies["a"].mass_properties.shape
    assert [part.kind for part in shape.parts] == ["box", "cylinder"] and shape.color == "#0000ff"
    assert shape.parts[0].center == (0, 0, 1)
    fb.draw(s)


# -- meshes ---------------------------------------------------------------------------------------------

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
QUADS = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]


def obj() -> str:
    lines = ["v " + " ".join(map(str, v)) for v in CUBE] + [
        "f " + " ".join(f"{i}//1" for i in q) for q in QUADS
    ]
    return "\n".join(lines)


def binary_stl(triangles: np.ndarray) -> bytes:
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    data = np.zeros(len(triangles), record)
    data["corners"] = triangles
    return b"\0" * 80 + len(triangles).to_bytes(4, "little") + data.tobytes()


def mesh_link(name: str, extra: str = "") -> str:
    mesh = f'<visual><geometry><mesh filename="{name}" {extra}/></geometry></visual></link>'
    return bar("a").replace("</link>", mesh)


def faces() -> np.ndarray:
    return np.array([[CUBE[q[0] - 1], CUBE[q[k] - 1], CUBE[q[k + 1] - 1]] for q in QUADS for k in (1, 2)])


@pytest.mark.parametrize("name", ["cube.obj", "cube.stl", "text.stl"])
def test_meshes_are_read(tmp_path, name):
    (tmp_path / "meshes").mkdir()
    path = tmp_path / "meshes" / name
    if name == "cube.obj":
        path.write_text(obj())
    elif name == "cube.stl":
        path.write_bytes(binary_stl(faces()))
    else:
        corners = ["facet normal 0 0 0\nouter loop\n" + "\n".join("vertex {} {} {}".format(*v) for v in t)
                   + "\nendloop\nendfacet" for t in faces()]  # fmt: skip
        path.write_text("solid cube\n" + "\n".join(corners) + "\nendsolid")
    s = read(tmp_path, '<link name="w"/>', mesh_link(f"meshes/{name}", 'scale="1 2 1"'), joint("j", "w", "a"))
    shape = s.bodies["a"].mass_properties.shape
    assert (
        shape.kind == "mesh"
        and shape["surface"].vertices.shape == (8, 3)
        and shape["surface"].faces.shape == (12, 3)
    )
    assert shape["surface"].vertices.max(axis=0) == pytest.approx([1, 2, 1])
    assert not any("mesh" in note.what for note in s.reading.notes)
    plain = read(
        tmp_path, '<link name="w"/>', mesh_link(f"meshes/{name}"), joint("j", "w", "a"), meshes=False
    )
    assert plain.bodies["a"].mass_properties.shape is None and "a mesh is not drawn" in str(plain.reading)


def test_packages_are_found_beside_the_folders_above(tmp_path):
    (tmp_path / "arm_description" / "urdf").mkdir(parents=True)
    (tmp_path / "arm_description" / "meshes").mkdir()
    (tmp_path / "arm_description" / "meshes" / "cube.obj").write_text(obj())
    link = mesh_link("package://arm_description/meshes/cube.obj")
    s = read(tmp_path / "arm_description" / "urdf", '<link name="w"/>', link, joint("j", "w", "a"))
    assert s.bodies["a"].mass_properties.shape.kind == "mesh"


def test_large_meshes_are_made_coarse():
    from freebody.formats.meshes import MOST, coarse

    n = 120
    a, b = np.meshgrid(np.linspace(0, np.pi, n), np.linspace(0, 2 * np.pi, n), indexing="ij")
    points = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=-1).reshape(-1, 3)
    k = np.arange(n * (n - 1)).reshape(n - 1, n)[:, :-1].reshape(-1)
    triangles = np.concatenate([np.stack([k, k + 1, k + n], 1), np.stack([k + 1, k + n + 1, k + n], 1)])
    vertices, few = coarse(points, triangles)
    assert MOST / 3 < len(few) <= MOST
    # means of points of a sphere within a cell of it
    assert np.abs(np.linalg.norm(vertices, axis=1) - 1).max() < 0.02


PLY = """ply
format {} 1.0
element vertex 1000000000
property float x
property float y
property float z
element face 1000000000
property list uchar int vertex_indices
end_header
"""
GLTF = (
    b'{"asset":{"version":"2.0"},"buffers":[{"uri":"secret.bin","byteLength":36}],'
    b'"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,'
    b'"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],'
    b'"scenes":[{"nodes":[0]}],"scene":0}'
)
"""A mesh whose corners are in another file."""
LAUGHS = (
    b'<!DOCTYPE lolz [<!ENTITY l1 "lol">'
    + b"".join(b'<!ENTITY l%d "%s">' % (k + 1, b"&l%d;" % k * 10) for k in range(1, 10))
    + b"]><COLLADA>&l10;</COLLADA>"
)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.stl", None, "no such file"),
        ("a.blend", b"x", "expected a mesh (STL, OBJ, DAE, PLY, glTF, OFF), got .blend"),
        ("cut.stl", b"\0" * 80 + (10**9).to_bytes(4, "little") + b"\0" * 50, "counts 1000000000 triangles"),
        ("nan.stl", binary_stl(np.full((1, 3, 3), np.nan)), "expected STL with finite triangles"),
        ("far.obj", b"v 0 0 0\nf 1 2 3", "faces of its own vertices"),
        ("flat.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 1", "triangles with an area"),
        (
            "empty.ply",
            b"ply\nformat ascii 1.0\nelement vertex 0\nelement face 0\nend_header\n",
            "triangles with an area",
        ),
        ("bad.obj", b"v 0 0 x\nf 1 1 1", "three numbers"),
        ("nan.obj", b"v 0 0 nan\nf 1 1 1", "expected finite vertices"),
        ("cut.msh", b"\0" * 15, "expected MSH with its counts"),
        (
            "own.msh",
            struct.pack("<4i9f3i", 3, 0, 0, 1, *range(9), 0, 1, 3),
            "expected MSH with triangles of its own finite vertices",
        ),
        ("word.obj", b"v 0 0 0\nf a b c", "expected corners of a face, got 'f a b c'"),
        ("long" * 2000 + ".stl", None, "no such file"),
        ("huge.obj", b"v 0 0 0\nf 1 2 " + b"9" * 30, "faces of its own vertices"),
        ("lines.obj", b"v 0 0 0\nf 1\n", "faces of its own vertices"),
        ("many.msh", (10**9).to_bytes(4, "little") * 4, "expected MSH of"),
        ("many.ply", PLY.format("binary_little_endian").encode(), "trimesh cannot read it"),
        ("ascii.ply", PLY.format("ascii").encode() + b"0 0 0\n", "triangles with an area"),
        ("many.off", b"OFF\n1000000000 1000000000 0\n0 0 0\n", "trimesh cannot read it ("),
        ("laughs.dae", LAUGHS, "collada cannot read it"),
        (
            "entity.dae",
            b'<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><COLLADA>&x;</COLLADA>',
            "collada cannot",
        ),
        ("other.gltf", GLTF, "trimesh cannot read it"),
        ("package://arm/../../../../../../../etc/passwd", None, "no such file"),
        ("file:///etc/passwd", None, "package://"),
        ("../../../../../../../../etc/passwd", None, "no such file"),
        ("/etc/passwd", None, "no such file"),
    ],
)
def test_a_mesh_that_cannot_be_read_is_left_out_and_said(tmp_path, name, content, words):
    if name.endswith((".dae", ".ply", ".off", ".gltf")):
        pytest.importorskip("collada" if name.endswith(".dae") else "trimesh")
    if content is not None:
        (tmp_path / name).write_bytes(content)
    (tmp_path / "secret.bin").write_bytes(bytes(36))
    begin = process_time()
    s = read(tmp_path, '<link name="w"/>', mesh_link(name), joint("j", "w", "a"))
    (note,) = [note for note in s.reading.notes if "mesh" in note.what]
    shape = s.bodies["a"].mass_properties.shape
    assert shape is None or not len(shape["surface"].faces)
    assert words in note.detail and process_time() - begin < 10, note
    assert fb.draw(s).svg.startswith("<svg")


COLLADA = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#a" count="4" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common>
</source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3</p></triangles>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount><p>0 3 2 1</p></polylist>
<lines count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1</p></lines>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><translate>0 0 5</translate><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_a_collada_file_has_its_scene_in_metres(tmp_path):
    pytest.importorskip("collada")
    from freebody.formats.meshes import surface

    (tmp_path / "a.dae").write_text(COLLADA)
    vertices, faces = surface(tmp_path / "a.dae")
    assert vertices.max(axis=0) == pytest.approx([0.01, 0.01, 0.06]) and len(faces) == 4


def test_meshes_are_read_when_they_are_drawn(tmp_path, monkeypatch):
    from freebody.formats import meshes

    read_now = []
    monkeypatch.setitem(meshes.OWN, ".obj", lambda data: read_now.append(len(data)) or meshes._obj(data))
    (tmp_path / "cube.obj").write_text(obj())
    pair = mesh_link("cube.obj"), mesh_link("cube.obj", 'scale="1 1 -1"').replace('"a"', '"b"')
    s = read(tmp_path, '<link name="w"/>', *pair, joint("j", "w", "a"), joint("k", "a", "b"))
    assert not read_now
    shape = pickle.loads(pickle.dumps(s.bodies["b"].mass_properties.shape))
    assert shape["surface"].vertices[:, 2].min() == -1 and not shape["surface"].vertices.flags.writeable
    assert len(fb.draw(s).svg) > 1000 and len(read_now) == 1
    assert not any("mesh" in note.what for note in s.reading.notes)
    late = read(tmp_path, '<link name="w"/>', *pair, joint("j", "w", "a"), joint("k", "a", "b"))
    (tmp_path / "cube.obj").unlink()
    assert str(late.reading).count("cannot read it: No such file") == 2


def test_a_robot_is_drawn_in_the_pose_of_its_file(tmp_path):
    s = read(tmp_path, '<link name="w"/>', bar("a"), bar("b"), joint("j", "w", "a"), joint("k", "a", "b"))
    assert fb.draw(s).svg == fb.draw(s, at={"j": 0, "k": 0}).svg != fb.draw(s, at={"j": 1}).svg


# -- what is refused ------------------------------------------------------------------------------------

BODY = [bar("a"), bar("b")]


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([], "expected at least one <link> in the robot, got none"),
        (BODY, "one link that no joint holds, got 2: 'a', 'b'"),
        ([*BODY, joint("j", "a", "b"), joint("k", "b", "a")], "go round in a loop"),
        ([*BODY, joint("j", "a", "b"), joint("j", "a", "b")], "each joint once, got 'j' again"),
        ([*BODY, bar("a"), joint("j", "a", "b")], "each link once, got 'a' again"),
        ([*BODY, joint("j", "a", "c")], "unknown link 'c'"),
        ([*BODY, bar("c"), joint("j", "a", "c"), joint("k", "b", "c")], "held by joint 'j' and by 'k'"),
        ([*BODY, joint("j", "a", "b", "hinge")], "expected a type of joint 'j' among revolute"),
        ([*BODY, "<joint type='fixed'/>"], "attribute 'name'"),
        ([*BODY, "<joint name='j' type='fixed'><parent link='a'/></joint>"], "expected <child link"),
        ([*BODY, joint("j", "a", "b", axis="0 0 0")], "expected an axis of joint .j. that has a direction, got .0 0 0.|expected an axis of .* that has a direction, got .0, 0, 0."),
        ([*BODY, joint("j", "a", "b", axis="0 0")], '3 numbers for xyz= of <axis>, got "0 0"'),
        ([*BODY, joint("j", "a", "b", axis="0 0 nan")], "3 numbers"),
        ([*BODY, joint("j", "a", "b", inside="<mimic joint='j'/>")], "mimics itself"),
        ([*BODY, bar("c"), joint("j", "a", "b", inside="<mimic joint='k'/>"),
          joint("k", "a", "c", inside="<mimic joint='j'/>")], "mimics itself, by way of"),
        ([*BODY, joint("j", "a", "b", "floating", "<mimic joint='j'/>")], "expected <mimic> on a joint of one coordinate, got it on "),
        ([*BODY, bar("c"), joint("j", "a", "b", "floating"), joint("k", "a", "c", inside="<mimic joint='j'/>")],
         "expected a joint of one coordinate for 'k' to mimic, got '"),
        ([bar("a").replace('value="2"', 'value="-2"')], "not negative, got -2 kg"),
        ([bar("a").replace('value="2"', 'value="heavy"')], 'a number for value= of <mass>, got "heavy"'),
        ([bar("a").replace('value="2"', 'value="1e61"')], 'numbers of at most 1e60 for value= of <mass>, got "1e61"'),
        ([bar("a").replace('value="2"', "")], "attribute 'value' of <mass>"),
        ([bar("a").replace('ixx="0.2"', 'ixx="x"')], 'a number for ixx= of <inertia>, got "x"'),
        ([bar("a").replace("</link>", "<inertial/></link>")], "expected one <inertial> in <link> of link 'a', got another"),
        ([bar("")], "expected a name of <link>, got none"),
        (["<link/>"], "attribute 'name' of <link>"),
        *(([*BODY, joint("j", "a", "b", "revolute", inside)], words) for inside, words in (
            ("<limit lower='x'/>", 'a number for lower= of <limit>, got "x"'),
            ("<limit/><limit/>", "expected one <limit> in <joint> of joint 'j', got another"),
            ("<axis xyz='1 0 0'/>", "expected one <axis> in <joint> of joint 'j', got another"),
            ("<origin/><origin/>", "expected one <origin> in <joint> of joint 'j', got another"),
            ("<origin xyz='1 2'/>", '3 numbers for xyz= of <origin>, got "1 2"'),
            ("<origin rpy='1 2 x'/>", '3 numbers for rpy= of <origin>, got "1 2 x"'),
            ("<dynamics damping='x'/>", 'a number for damping= of <dynamics>, got "x"'),
            ("<dynamics damping='-1'/>", "expected a damping of joint 'j' that is not negative, got -1"),
            ("<dynamics friction='-1'/>", "expected a friction of joint 'j' that is not negative, got -1"),
            ("<mimic/>", "attribute 'joint' of <mimic>"),
            ("<mimic joint='j' multiplier='x'/>", 'a number for multiplier= of <mimic>, got "x"'),
        )),
        ([*BODY, joint("j", "a", "b").replace(' type="continuous"', "")], "attribute 'type' of <joint>"),
        ([*BODY, joint("j", "a", "b").replace('<child link="b"/>', "<child/>")], "attribute 'link' of <child>"),
        *(([bar("a").replace("</link>", f"<visual><geometry>{solid}</geometry></visual></link>")], words)
          for solid, words in (
            ("<box/>", "attribute 'size' of <box>"),
            ("<box size='1 2'/>", '3 numbers for size= of <box>, got "1 2"'),
            ("<sphere radius='x'/>", 'a number for radius= of <sphere>, got "x"'),
            ("<cylinder radius='1'/>", "attribute 'length' of <cylinder>"),
        )),
        *(([bar("a").replace("</link>", f"<visual><origin xyz='0 0 {x}'/><geometry><sphere radius='1'/></geometry></visual></link>")], f'3 numbers .* "0 0 {x}"')
          for x in ("1_000", "\u0663", "0x10", "nan", "1e400")),
        ([bar("a").replace("</link>", "<visual><geometry><sphere radius='1'/></geometry><material>"
                           "<color rgba='1 2'/></material></visual></link>")], '4 numbers for rgba= of <color>, got "1 2"'),
    ],
)  # fmt: skip
def test_a_wrong_robot_is_refused_with_its_line(tmp_path, parts, words):
    with pytest.raises(FormatError, match=words) as caught:
        read(tmp_path, *parts)
    assert str(caught.value).startswith("arm.urdf, line ")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "expected XML"),
        ("<robot>", "expected XML"),
        ("<model/>", "expected <robot>"),
        ("<mujoco/>", "got <mujoco>. This is MJCF: rename the file to end in .xml"),
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot>&a;</robot>', "no document type"),
        ('<!DOCTYPE r SYSTEM "file:///etc/passwd"><robot/>', "no document type"),
        (
            "<robot>" + "<a>" * 300 + "</a>" * 300 + "</robot>",
            "expected elements nested at most 200 deep, got more",
        ),
        ("<robot>" + "<a/>" * 500_001 + "</robot>", "at most 500000"),
        ("<robot>&nbsp;</robot>", "expected XML"),
        (
            '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="x" value="1"/></robot>',
            "xacro IN.urdf.xacro > OUT.urdf",
        ),
        ("\0", "expected XML"),
        ('<robot><xacro:include filename="a"/></robot>', "got xacro macros"),
        ('<robot><link name="a"><visual name="${n}"/></link></robot>', "got xacro macros"),
    ],
)
def test_what_is_no_robot_is_refused(tmp_path, text, words):
    path = tmp_path / "arm.urdf"
    path.write_text(text)
    with pytest.raises(FormatError, match=words):
        fb.read(path)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("a.xacro", "Expand its macros"),
        ("a.sdf", "Convert it first"),
        ("a.urdf", "no file"),
        ("a.usd", "not read"),
    ],
)
def test_other_formats_are_refused_with_a_cure(tmp_path, name, words):
    with pytest.raises(FormatError, match=words):
        fb.read(tmp_path / name)


def test_what_urdf_does_not_have_is_said(tmp_path):
    inside = "<banana/><limit effort='1' velocity='1' colour='red'/>"
    s = read(tmp_path, '<link name="w"/>', bar("a"), joint("j", "w", "a", "revolute", inside))
    assert "joint 'j', <banana>, line 5" in str(s.reading)
    assert "colour: not an attribute of URDF: joint 'j', <limit>, line 5" in str(s.reading)


def test_wrong_options_are_refused(tmp_path):
    with pytest.raises(
        ModelError, match="base= one of 'fixed', 'free', 'planar', or motions such as .*, got 'loose'"
    ):
        read(tmp_path, *DOUBLE, base="loose")
    with pytest.raises(ModelError, match="Expected at least one motion"):
        read(tmp_path, bar("a"), base=[])
    with pytest.raises(ModelError, match="symbols= one of"):
        read(tmp_path, *DOUBLE, symbols="some")
    with pytest.raises(ModelError, match="meshes= one of False, True, got 'maybe'"):
        read(tmp_path, *DOUBLE, meshes="maybe")
    fb.write(by_hand(), tmp_path / "arm.toml")
    with pytest.raises(FormatError, match="base= is an option of robots' files"):
        fb.read(tmp_path / "arm.toml", base="free")
    with pytest.raises(FormatError, match="expected a mass of link 'a', which moves freely with base='free'"):
        read(tmp_path, '<link name="a"/>', base="free")


def test_the_command_line_reads_robots(tmp_path):
    from click.testing import CliRunner

    from freebody.cli import command

    read(tmp_path, *DOUBLE)
    result = CliRunner().invoke(command, ["check", str(tmp_path / "arm.urdf")])
    assert result.exit_code == 0, result.output
    assert "Read from arm.urdf" in result.output and "'arm' is sound" in result.output


def test_a_robot_without_a_joint_is_told_to_be_free(tmp_path):
    s = read(tmp_path, bar("drone"))
    with pytest.raises(ModelError, match="has no body. In its file nothing moves.*base='free'"):
        fb.simulate(s, 1)
    assert fb.simulate(read(tmp_path, bar("drone"), base="free"), 1).status == "finished"
