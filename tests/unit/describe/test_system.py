"""What a system remembers of its description."""

from __future__ import annotations

from fractions import Fraction

import pytest
import sympy

import freebody as fb
from freebody.describe.description import about_of, coordinates_of, parameters_of, positive_in, vector
from freebody.describe.frame import Point


@pytest.fixture
def s():
    return fb.System("crane")


def test_parameters_are_real_symbols_with_defaults(s):
    a, b = s.parameters(a=2, b="75deg")
    c = s.parameters("c")
    assert (a, b, c) == sympy.symbols("a b c", real=True)
    assert [(p.name, p.default) for p in parameters_of(s)[:1]] == [("a", 2.0)]
    assert parameters_of(s)[1].default == pytest.approx(1.3089969389957472, abs=0)
    assert parameters_of(s)[2].default is None
    assert s.parameters("d, e") == sympy.symbols("d e", real=True)


def test_coordinates_are_functions_of_time(s):
    from sympy.physics.mechanics import dynamicsymbols

    theta, x = s.coordinates("theta, x")
    assert theta == dynamicsymbols("theta")
    assert s.expression("theta'") == theta.diff(s.t)
    assert s.expression("x' + theta*t") == x.diff(s.t) + theta * s.t
    assert list(coordinates_of(s)) == ["theta", "x"]


def test_numbers_are_exact(s):
    assert s.expression(0.1) == Fraction(1, 10)
    assert s.expression("0.1*3") == Fraction(3, 10)
    assert s.expression(Fraction(4, 2)) == 2
    assert vector(s, (1, 0.5, "1/3"), "a test") == (1, Fraction(1, 2), Fraction(1, 3))


def test_describe_keeps_unit_and_meaning(s):
    F = s.parameters(F=0.0)
    s.coordinates("x")
    s.describe(F, unit="N", about="force at the free end")
    s.describe("x", about="way of the cart")
    assert about_of(s) == {"F": ("N", "force at the free end"), "x": ("", "way of the cart")}
    s.body("b", fb.particle(1))
    s.slider("rail", s.ground, "b", coordinate="x")
    assert fb.assemble(s).about == about_of(s)


def test_assumptions_and_use_make_positive(s):
    k, c, m, R = s.parameters("k c m R")
    s.assume(k > 0, c > k, True)
    assert positive_in(s) == {k, c - k}
    s.body("ball", fb.sphere(m, R))
    assert {m, R} <= positive_in(s)
    s.slider("rail", s.ground, "ball", coordinate="x")
    s.spring("spring", s.joints["rail"], stiffness="sqrt(k**2)")
    (motion,) = fb.equations(s).motion
    x = s.expression("x")
    assert motion.lhs == m * x.diff(s.t, 2) + k * x  # sqrt(k²) is k


def test_gravity_is_none_until_given(s):
    assert s.gravity == (0, 0, 0)
    g = s.parameters(g=9.81)
    s.gravity = (0, -g, 0)
    assert s.gravity == (0, -g, 0)


def test_repr_counts(s):
    assert repr(s) == "System 'crane': 0 bodies, 0 joints, 0 coordinates"
    bar = s.body("bar", fb.slender_bar(1, 2))
    pin = s.hinge("pin", s.ground, bar)
    assert repr(s) == "System 'crane': 1 body, 1 joint, 1 coordinate"
    assert (repr(bar), repr(s.ground), repr(pin)) == (
        "body 'bar'",
        "the ground",
        "hinge 'pin' (ground -> bar)",
    )
    assert repr(bar.point(0, "1/2", 0)) == "point (0, 1/2, 0) of bar"
    assert repr(fb.assemble(s)) == "Model 'crane': 1 body, 1 degree of freedom"


def test_points_of_a_body(s):
    L = s.parameters("L")
    bar = s.body("bar", fb.slender_bar(1, L).moved((0, L / 2, 0)))
    assert bar.point((1, 2, 3)) == bar.point(1, 2, 3) == Point(bar, (1, 2, 3))
    assert bar.origin.components == (0, 0, 0)
    assert bar.center.components == (0, L / 2, 0)
    assert s.ground.center == s.ground.origin
    assert s.ground.is_ground and not bar.is_ground


def test_bodies_and_points_may_be_named(s):
    s.body("bar", fb.slender_bar(1, 2))
    joint = s.hinge("pin", "ground", "bar", at=s.ground.point(1, 2, 3))
    assert (joint.parent, joint.child, joint.at) == (s.ground, s.bodies["bar"], (1, 2, 3))


def test_default_coordinates_of_joints(s):
    for kind, names in {
        "hinge": ["j"],
        "slider": ["j"],
        "screw": ["j"],
        "cylindrical": ["j_slide", "j_turn"],
        "universal": ["j_1", "j_2"],
        "gimbal": ["j_1", "j_2", "j_3"],
        "planar": ["j_x", "j_y", "j_turn"],
        "ball": ["j_e0", "j_e1", "j_e2", "j_e3"],
        "free": ["j_x", "j_y", "j_z", "j_e0", "j_e1", "j_e2", "j_e3"],
        "weld": [],
    }.items():
        one = fb.System(kind)
        bar = one.body("bar", fb.box(1, (1, 2, 3)))
        getattr(one, kind)("j", one.ground, bar, **({"pitch": 1} if kind == "screw" else {}))
        model = fb.assemble(one)
        assert list(model.coordinate_names) == names
        if kind in ("ball", "free"):
            ends = ["wx", "wy", "wz"] + (["vx", "vy", "vz"] if kind == "free" else [])
            assert list(model.speed_names) == [f"j_{end}" for end in ends]
        else:
            assert list(model.speed_names) == [f"{name}'" for name in names]


@pytest.mark.parametrize("given", ["a b c", "a, b, c", ["a", "b", "c"], ("a", "b", "c")])
def test_several_coordinates_are_named_in_one_text_or_a_list(s, given):
    bar = s.body("bar", fb.box(1, (1, 2, 3)))
    s.gimbal("mount", s.ground, bar, coordinate=given)
    assert fb.assemble(s).coordinate_names == ("a", "b", "c")


def test_planar_joints_name_their_plane(s):
    for axis, names in {"x": "y z", "y": "z x", "z": "x y"}.items():
        body = s.body(f"on_{axis}", fb.box(1, (1, 2, 3)))
        s.planar(axis, s.ground, body, axis=axis)
        first, second = names.split()
        assert [p.coordinate for p in s.joints[axis].primitives] == [
            s.expression(f"{axis}_{first}"), s.expression(f"{axis}_{second}"), s.expression(f"{axis}_turn"),
        ]  # fmt: skip


def test_a_description_can_grow_after_it_was_assembled(s):
    crank = s.body("crank", fb.slender_bar(1, 2))
    s.hinge("a", s.ground, crank)
    before = fb.assemble(s)
    s.hinge("b", crank, s.body("rod", fb.slender_bar(1, 2)))
    s.torque("T", crank, (0, 0, 1))
    assert (before.n_u, list(before.bodies), list(before.loads)) == (1, ["crank"], [])
    assert fb.assemble(s).n_u == 2


def test_expressions_may_be_text_or_sympy(s):
    k, m = s.parameters(k=2, m=1)
    block = s.body("block", fb.particle(m))
    rail = s.slider("rail", s.ground, block, coordinate="x")
    s.force("drag", block, ("-k*x'**2*sign(x')", 0, 0))
    x = s.expression("x")
    v = x.diff(s.t)
    assert s.loads["drag"].components[0] == -k * v**2 * sympy.sign(v)
    spring = s.torsion_spring(
        "t", s.hinge("pin", block, s.body("arm", fb.slender_bar(1, 1))), stiffness=k, rest="pi/2"
    )
    assert (spring.stiffness, spring.rest, spring.index) == (k, sympy.pi / 2, 0)
    assert s.generalized_force("x", "3*t").name == "Q_x"
    assert rail.coordinate == (s.expression("x"),)
