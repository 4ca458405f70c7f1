"""Contacts of robots with a floor: shapes by their gaps, who touches, friction, and what is said of the rest."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody.errors import FormatError, ModelError

from .test_mjcf import read as read_mjcf
from .test_urdf import bar, joint
from .test_urdf import read as read_urdf

FLOOR = '<geom name="ground" type="plane" size="1 1 1"/>'
BALL = '<body name="ball" pos="0 0 2"><freejoint name="air"/><geom {}/></body>'
TURN = 'euler="90 0 0"'


def mjcf(folder: Path, geom: str = 'size="0.1"', floor: str = FLOOR, **options: object) -> fb.System:
    """A free body with one geom above a floor, in the pose of the file."""
    return read_mjcf(folder, floor, BALL.format(geom), **{"contacts": "floor", **options})  # type: ignore[arg-type]


def gaps(s: fb.System) -> dict[str, float]:
    """Gaps of the contacts in the pose of the file, without points on which disks would stand that lie flat."""
    motion = fb.simulate(s, 1e-3, initial=s.reading.initial)
    stands = {contact.name for contact in motion.kernels.model.contacts if contact.stands}
    return {name: float(contact.gap[0]) for name, contact in motion.contacts.items() if name not in stands}


@pytest.mark.parametrize(
    "geom, lowest",
    [
        ('size="0.1"', [0.1]),
        ('type="capsule" size="0.1 0.3"', [0.4, -0.2]),
        (f'type="capsule" size="0.1 0.3" {TURN}', [0.1, 0.1]),
        (f'type="cylinder" size="0.1 0.3" {TURN}', [0.1, 0.1]),
        ('type="box" size="0.1 0.2 0.3"', [0.3] * 4 + [-0.3] * 4),
        ('type="box" size="0.1 0.1 0.3" euler="0 45 0"', [x / sqrt(2) for x in (0.4, 0.2, -0.2, -0.4)] * 2),
        ('type="ellipsoid" size="0.1 0.2 0.3"', [0.3]),
        (f'type="ellipsoid" size="0.1 0.2 0.3" {TURN}', [0.2]),
    ],
)  # fmt: skip
def test_solids_touch_at_their_lowest_points(tmp_path, geom, lowest):
    s = mjcf(tmp_path, geom, floor=FLOOR.replace("<geom ", '<geom pos="0 0 0.5" '))
    assert sorted(gaps(s).values()) == pytest.approx(sorted(1.5 - z for z in lowest), abs=1e-12)


def test_an_upright_cylinder_has_its_ends_above_and_below(tmp_path):
    s = mjcf(tmp_path, 'type="cylinder" size="0.1 0.3"')
    (pair,) = s.contacts.values()
    assert [float(end.at[2]) for end in pair.feature.rims] == [-0.3, 0.3] and pair.feature.kind == "drum"


def test_a_mesh_touches_with_the_corners_of_its_hull(tmp_path):
    corners = "0 0 0  1 0 0  0 1 0  0 0 1  0.1 0.1 0.1"
    faces = "0 2 1  0 1 3  0 3 2  1 2 3"
    mesh = f'<asset><mesh name="m" vertex="{corners}" face="{faces}"/></asset>'
    s = read_mjcf(tmp_path, FLOOR, BALL.format('type="mesh" mesh="m"'), head=mesh, contacts="floor")
    assert sorted(gaps(s).values()) == pytest.approx([2, 2, 2, 3], abs=1e-12)


def test_collisions_of_urdf_rest_on_the_floor(tmp_path):
    solid = '<collision><origin xyz="0 0 -0.5"/><geometry>{}</geometry></collision></link>'
    box = '<box size="0.4 0.4 0.2"/>'
    s = read_urdf(tmp_path, bar("a").replace("</link>", solid.format(box)), base="free", contacts="floor")
    assert list(s.contacts) == ["a_floor"]
    motion = fb.simulate(s, 0.2, initial={"base_z": 0.6})
    assert abs(motion["base_z"] - 0.6).max() < 1e-12 and not motion.events
    assert fb.assemble(s).values()["mu"] == 1
    assert "the plane z = 0, of friction 1, since the format has no floor" in str(s.reading)


def test_a_floor_is_given_by_its_normal_place_and_friction(tmp_path):
    solid = '<collision><geometry><sphere radius="0.25"/></geometry></collision></link>'
    floor = {"normal": (0, 3, 4), "at": (0, 0, -1), "friction": 0.3}
    s = read_urdf(tmp_path, bar("a").replace("</link>", solid), base="free", contacts=floor)
    (pair,) = s.contacts.values()
    assert gaps(s) == {"a_floor": pytest.approx(0.8 - 0.25, abs=1e-12)}
    assert str(pair.friction) == "mu"
    assert fb.assemble(s).values()["mu"] == 0.3 and "plane z = 0" not in str(s.reading)


def test_links_of_a_fixed_base_do_not_touch_and_the_others_do(tmp_path):
    solid = '<collision><geometry><sphere radius="0.25"/></geometry></collision></link>'
    s = read_urdf(tmp_path, '<link name="w">' + solid, bar("a").replace("</link>", solid), joint("j", "w", "a"),
                  contacts="floor")  # fmt: skip
    assert list(s.contacts) == ["a_floor"]


@pytest.mark.parametrize(
    "floor, geom, head, friction",
    [
        ("", "", "", 1.0),
        ('friction="0.4"', 'friction="0.7 0 0"', "", 0.7),
        ('friction="0.4" priority="1"', 'friction="0.7 0 0"', "", 0.4),
        ('condim="1"', 'condim="1" friction="0.7"', "", 0.0),
        ('condim="1" priority="2"', 'friction="0.7"', "", 0.0),
        ("", "", '<contact><pair geom1="g" geom2="ground" friction="0.2 0.2 0 0 0"/></contact>', 0.2),
        ('contype="0" conaffinity="0"', "", '<contact><pair geom1="g" geom2="ground"/></contact>', 1.0),
        ('contype="2" conaffinity="4"', 'contype="4" conaffinity="1"', "", 1.0),
        ('contype="2" conaffinity="4"', 'contype="1" conaffinity="1"', "", None),
        ("", "", '<contact><exclude body1="world" body2="ball"/></contact>', None),
    ],
)  # fmt: skip
def test_who_touches_and_with_what_friction(tmp_path, floor, geom, head, friction):
    s = mjcf(tmp_path, f'name="g" size="0.1" {geom}', FLOOR.replace("<geom ", f"<geom {floor} "), head=head)
    assert list(s.contacts) == ([] if friction is None else ["g_ground"])
    for pair in s.contacts.values():
        value = pair.friction if friction == 0 else fb.assemble(s).values()["mu"]
        assert value == friction


def test_equal_coefficients_are_one_parameter(tmp_path):
    geoms = (
        '<geom size="0.1" friction="0.5"/><geom size="0.2" friction="0.5"/><geom size="0.3" friction="0.6"/>'
    )
    s = read_mjcf(tmp_path, FLOOR.replace("<geom ", '<geom friction="0" '),
                  BALL.replace("<geom {}/>", geoms), contacts="floor")  # fmt: skip
    assert [str(pair.friction) for pair in s.contacts.values()] == ["mu", "mu", "mu_2"]


@pytest.mark.parametrize(
    "floor, geom, options, text",
    [
        (FLOOR, "size='0.1'", {"contacts": None}, "nothing touches: contacts='floor' lets geoms touch planes"),
        (FLOOR, "size='0.1'", {}, "bodies touch planes and not each other, which contacts='all' reads"),
        (FLOOR, "size='0.1' condim='6'", {}, "no friction resists its turn and roll: <geom>, line 4, condim 6"),
        (FLOOR, "type='ellipsoid' size='1 2 3' euler='9 0 0'", {}, "an ellipsoid that is turned in its body"),
        (FLOOR, "size='0.1' solref='1 1'", {}, "solref: contacts are rigid here, not soft"),
        (FLOOR, "size='0.1'", {"head": '<option><flag contact="disable"/></option>'}, "the file disables contacts"),
        (FLOOR + "<geom size='1'/>", "size='0.1'", {}, "that nothing touches: <geom> 'world_geom2'"),
        ("", "size='0.1'", {}, "the plane z = 0, since the file has no plane"),
        (FLOOR, "size='0.1'", {"head": "<contact><touch/></contact>"}, "not a part of <contact>: <touch>"),
    ],
)  # fmt: skip
def test_what_does_not_touch_is_said(tmp_path, floor, geom, options, text):
    assert text in str(mjcf(tmp_path, geom, floor, **options).reading)


def test_meshes_with_too_many_corners_or_none_are_said(tmp_path):
    rng = np.random.default_rng(1)
    points = rng.normal(size=(200, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    round_ = " ".join(map(str, points.ravel()))
    for vertices, text in (
        (round_, "a mesh of more than 100 corners is not read"),
        ("0 0 0 1 0 0 0 1 0 1 1 0", "a flat mesh"),
    ):
        mesh = f'<asset><mesh name="m" vertex="{vertices}"/></asset>'
        inertial = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><geom '
        s = read_mjcf(tmp_path, FLOOR, BALL.format('type="mesh" mesh="m"').replace("<geom ", inertial), head=mesh,
                      contacts="floor")  # fmt: skip
        assert not s.contacts and f"it does not touch the floor: <geom> 'ball', line 4, {text}" in str(
            s.reading
        )


@pytest.mark.parametrize(
    "geometry, text",
    [
        ("<mesh filename='none.stl'/>", "no such file near the robot's file"),
        ("<cone/>", "a cone is not a solid of URDF"),
        ("<sphere radius='0'/>", "a solid without size"),
    ],
)
def test_collisions_that_cannot_be_read_are_said(tmp_path, geometry, text):
    solid = f"<collision><geometry>{geometry}</geometry></collision></link>"
    s = read_urdf(tmp_path, bar("a").replace("</link>", solid), base="free", contacts="floor")
    assert not s.contacts and f"it does not touch the floor: link 'a', <collision>, line 3, {text}" in str(
        s.reading
    )


@pytest.mark.parametrize(
    "value, message",
    [
        ("ground", "'floor', 'all' or a mapping that gives a floor, such as {'friction': 0.8}, got 'ground'."),
        (True, "got True."),
        ({"mu": 1}, "Unknown key 'mu' of contacts=; known names: apart, at, bodies, friction, normal."),
        ({"bodies": 1}, "Expected 'bodies' of contacts= True or False, got 1."),
        ({"apart": ["ball"]}, "Expected pairs of links for 'apart' of contacts=, such as [('hand', 'arm')], got 'ball'."),
        ({"apart": [("ball", "bell")]}, "Unknown link 'bell' in 'apart' of contacts=; did you mean 'ball'?"),
    ],
)  # fmt: skip
def test_values_of_contacts_that_do_not_exist_are_refused(tmp_path, value, message):
    with pytest.raises(ModelError) as caught:
        mjcf(tmp_path, contacts=value)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "element, message",
    [
        ('<pair geom1="g" geom2="x"/>', "unknown geom 'x' of <pair>"),
        ('<pair geom1="g"/>', "expected the attribute 'geom2' of <pair>"),
        ('<exclude body1="ball" body2="bal"/>', "unknown body 'bal' of <exclude>; did you mean 'ball'?"),
    ],
)
def test_pairs_of_unknown_names_are_refused(tmp_path, element, message):
    with pytest.raises(FormatError) as caught:
        mjcf(tmp_path, 'name="g" size="0.1"', head=f"<contact>{element}</contact>")
    assert f"arm.xml, line 1: {message}" in str(caught.value)


# -- bodies that touch each other -----------------------------------------------------------------------

PENDULUM = """<body name="{0}" pos="{1} 0 0"><joint name="{0}_pin" axis="0 1 0"/>
<inertial pos="0 0 -1" mass="1" diaginertia="0.01 0.01 0.01"/><geom name="{0}_ball" size="0.1" pos="0 0 -1" {2}/></body>"""


def meetings(s: fb.System) -> dict[tuple[str, str], str]:
    """The coefficient of friction of all pairs of bodies that may touch in families."""
    found = {}
    for family in fb.assemble(s).families:
        n = len(family.members)
        for pair in ((i, j) for i in range(n) for j in range(i + 1, n) if family.meet(i, j)):
            names = sorted(family.members[k].shape.body.name for k in pair)
            assert tuple(names) not in found
            found[tuple(names)] = str(family.law.friction)
    return found


def two(folder: Path, first: str = "", second: str = "", **options: object) -> fb.System:
    """Two pendulums side by side, whose balls are geoms with these attributes."""
    bodies = PENDULUM.format("a", 0, first), PENDULUM.format("b", 0.2, second)
    floor = FLOOR.replace("<geom ", '<geom pos="0 0 -9" ')
    return read_mjcf(folder, floor, *bodies, **{"contacts": "all", **options})  # type: ignore[arg-type]


def test_a_pendulum_stops_at_another_and_gives_it_its_momentum(tmp_path):
    smooth = 'friction="0"'
    s = two(tmp_path, smooth, smooth)
    m = fb.simulate(s, 0.01, initial={"a_pin'": -1.0}, method="timestepping", step=1e-3)
    assert m.contacts["bodies[a,b]"].normal.max() > 0
    # without rebound both go on with half the speed, since both have the inertia 1.01 kg m² about their pins
    # (gravity adds less than 10 * 0.005 * 0.01 in that time)
    assert [m[name][-1] for name in ("a_pin'", "b_pin'")] == pytest.approx([-0.5, -0.5], abs=1e-3)
    assert meetings(s) == {("a", "b"): "0"}
    through = two(tmp_path, smooth, smooth, contacts={"apart": [("a", "b")]})
    m = fb.simulate(through, 0.1, initial={"a_pin'": -1.0}, method="timestepping", step=1e-3)
    assert meetings(through) == {} and m["b_pin"][-1] == 0 and m["a_pin"][-1] < -0.09


@pytest.mark.parametrize(
    "first, second, options, friction",
    [
        ("", "", {}, 1.0),
        ('friction="0.2"', 'friction="0.3"', {}, 0.3),
        ('contype="2" conaffinity="2"', "", {}, None),
        ('contype="2" conaffinity="2"', 'contype="1" conaffinity="3"', {}, 1.0),
        ('contype="0" conaffinity="0"', "", {}, None),
        ("", "", {"head": '<contact><exclude body1="a" body2="b"/></contact>'}, None),
        ('contype="0" conaffinity="0"', "",
         {"head": '<contact><pair geom1="a_ball" geom2="b_ball" friction="0.4 0.4 0 0 0"/></contact>'}, 0.4),
        ("", "", {"contacts": {"bodies": True}}, 1.0),
        ("", "", {"contacts": {"friction": 0.5}}, None),
    ],
)  # fmt: skip
def test_which_bodies_touch_and_with_what_friction(tmp_path, first, second, options, friction):
    s = two(tmp_path, first, second, **options)
    met = meetings(s)
    assert list(met) == ([] if friction is None else [("a", "b")])
    assert friction is None or fb.assemble(s).values()[met["a", "b"]] == friction


def test_every_pair_of_groups_is_in_one_family(tmp_path):
    """Geoms of random types and affinities: the bodies that meet are those that the rule of the format names."""
    rng = np.random.default_rng(3)
    types = rng.integers(0, 4, size=(7, 2))
    text = [
        PENDULUM.format(f"b{i}", 0.3 * i, f'contype="{t}" conaffinity="{a}"')
        for i, (t, a) in enumerate(types)
    ]
    s = read_mjcf(tmp_path, *text, contacts="all")
    rule = {
        (f"b{i}", f"b{j}") for i, (t, a) in enumerate(types) for j, (u, b) in enumerate(types)
        if i < j and (t & b or u & a)
    }  # fmt: skip
    assert set(meetings(s)) == rule and 5 < len(rule) < 21


@pytest.mark.parametrize(
    "geom, kind, text",
    [
        ('type="capsule" size="0.1 0.2"', "capsule", ""),
        ('type="box" size="0.1 0.2 0.3"', "box", ""),
        ('type="box" size="0.1 0.2 0.3" euler="90 0 0"', "box", ""),
        ('type="box" size="0.1 0.2 0.3" euler="0 20 0"', "hull", ""),
        ('type="mesh" mesh="m"', "hull", ""),
        ('type="ellipsoid" size="0.1 0.2 0.3"', "", "an ellipsoid has no law of contact with solids"),
    ],
)  # fmt: skip
def test_solids_touch_each_other_by_their_shapes(tmp_path, geom, kind, text):
    mesh = '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
    box = '<geom name="table" type="box" size="1 1 0.1" pos="0 0 -1"/>'
    other = '<body name="other" pos="3 0 0"><freejoint/><geom name="o" size="0.1"/></body>'
    s = read_mjcf(tmp_path, box, BALL.format(geom), other, head=mesh, contacts="all")
    assert ("ball", "ground") in meetings(s) or text
    assert ("ground", "other") in meetings(s)  # the table of the world is touched, too
    family = s.families["bodies"]
    assert [shape.kind for shape in family.shapes if shape.body.name == "ball"] == ([kind] if kind else [])
    assert f"it does not touch other bodies: <geom> 'ball', line 4, {text}" in str(s.reading) or not text
    if geom.endswith('"90 0 0"'):
        (shape,) = (shape for shape in family.shapes if shape.kind == "box" and shape.body.name == "ball")
        assert np.ptp(np.array(shape.corners, float), axis=0) == pytest.approx([0.2, 0.6, 0.4])


def test_cylinders_touch_spheres(tmp_path):
    """A cylinder and a box or another cylinder have no law: what is left out is said."""
    others = "".join(
        f'<body name="o{i}" pos="{i} 0 0"><freejoint/><geom name="g{i}" {geom}/></body>'
        for i, geom in enumerate(('size="0.1"', 'type="box" size="0.1 0.1 0.1"', 'type="cylinder" size="0.1 0.2"'), 3)
    )  # fmt: skip
    s = read_mjcf(tmp_path, BALL.format('type="cylinder" size="0.1 0.2"'), others, contacts="all")
    assert set(meetings(s)) == {("ball", "o3"), ("o3", "o5"), ("o3", "o4")}
    text = "of other bodies it touches spheres alone: <geom> 'ball', line"
    assert text in str(s.reading) and "a cylinder has no law of contact with other solids" in str(s.reading)


def test_an_exclusion_of_a_body_that_is_one_with_another_is_said(tmp_path):
    part = '<body name="tip" pos="0 0 -2"><geom size="0.1"/></body></body>'
    s = read_mjcf(tmp_path, PENDULUM.format("a", 0, "").replace("</body>", part), PENDULUM.format("b", 0.5, ""),
                  head='<contact><exclude body1="tip" body2="b"/></contact>', contacts="all")  # fmt: skip
    assert meetings(s) == {}
    assert "<exclude> holds for all bodies that are one with it: body 'tip', line 4" in str(s.reading)


def test_links_of_urdf_touch_each_other_and_not_those_they_are_joined_to(tmp_path):
    solid = (
        '<collision><origin xyz="0 0 -0.5"/><geometry><sphere radius="0.1"/></geometry></collision></link>'
    )
    parts = ['<link name="w">' + solid, *(bar(x).replace("</link>", solid) for x in "abc")]
    joints = [joint("j", "w", "a"), joint("k", "a", "b"), joint("l", "b", "c")]
    s = read_urdf(tmp_path, *parts, *joints, contacts={"bodies": True, "friction": 0.2})
    assert set(meetings(s)) == {("b", "ground"), ("c", "ground"), ("a", "c")}
    assert fb.assemble(s).values()["mu"] == 0.2 and "each other" not in str(s.reading)
    assert "which contacts='all' reads" in str(read_urdf(tmp_path, *parts, *joints, contacts="floor").reading)
