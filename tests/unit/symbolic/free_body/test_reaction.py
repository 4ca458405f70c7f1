"""What each joint can transmit, the names of the components, and their values."""

from __future__ import annotations

import pytest
import sympy
from sympy import cos, sin

import freebody as fb

BOX = (1, (1, 2, 3))


def one_joint(kind, **given):
    s = fb.System(kind)
    s.gravity = (0, -10, 0)
    block = s.body("block", fb.box(*BOX))
    getattr(s, kind)("j", s.ground, block, **given)
    return s, fb.equations(s)


@pytest.mark.parametrize(
    ("kind", "given", "components"),
    [
        ("weld", {}, "x y z Mx My Mz"),
        ("hinge", {}, "x y z Mx My"),
        ("hinge", {"axis": "x"}, "x y z My Mz"),
        ("hinge", {"axis": "-y"}, "x y z Mx Mz"),
        ("hinge", {"axis": (1, 1, 0)}, "x y z Mp Mq"),
        ("slider", {"axis": "y"}, "x z Mx My Mz"),
        ("slider", {"axis": (1, 1, 1)}, "p q Mx My Mz"),
        ("cylindrical", {}, "x y Mx My"),
        ("screw", {"pitch": 2}, "x y z Mx My"),
        ("universal", {}, "x y z Mn"),
        ("universal", {"axis": ("x", "z")}, "x y z Mn"),
        ("gimbal", {}, "x y z"),
        ("planar", {}, "z Mx My"),
        ("planar", {"axis": "x"}, "x My Mz"),
        ("ball", {}, "x y z"),
        ("free", {}, ""),
        ("hinge", {"coordinate": "3*t"}, "x y z Mx My Mz"),
        ("slider", {"coordinate": "3*t"}, "x y z Mx My Mz"),
        ("screw", {"pitch": 2, "coordinate": "3*t"}, "x y z Mx My Mz"),
        ("gimbal", {"coordinate": ["t", "a", "b"]}, "x y z Mn"),
        ("planar", {"coordinate": ["t", "a", "b"]}, "x z Mx My"),
        ("cylindrical", {"coordinate": ["a", "t"]}, "x y Mx My Mz"),
    ],
)
def test_components_are_as_many_as_the_joint_takes_away(kind, given, components):
    _, eq = one_joint(kind, **given)
    expected = [f"j_{name}" for name in components.split()]
    assert list(eq.reactions["j"].components) == expected
    assert [str(x) for x in eq.free_body("block").unknowns] == expected
    assert len(expected) == 6 - eq.model.n_u


def test_components_lie_along_the_ground_where_the_free_axis_does():
    """A hinge about z of a body that turned about z keeps ground axes; about a turned axis, the child's."""
    s = fb.System("arm")
    base, arm = s.body("base", fb.box(*BOX)), s.body("arm", fb.box(*BOX))
    s.hinge("yaw", s.ground, base, axis="z", coordinate="psi")
    s.hinge("pitch", base, arm, axis="x", coordinate="theta")
    eq = fb.equations(s)
    forces = eq.free_body("base").forces
    assert forces["yaw_x"] == sympy.ImmutableMatrix([sympy.Symbol("yaw_x", real=True), 0, 0])
    pitch_My = sympy.Symbol("pitch_My", real=True)
    psi, theta = eq.coordinates
    moment = eq.free_body("arm").moments["pitch_My"]
    expected = pitch_My * sympy.Matrix(
        [-cos(theta) * sin(psi), cos(theta) * cos(psi), sin(theta)]
    )  # the arm's y
    assert [sympy.expand(a - b) for a, b in zip(moment, expected, strict=True)] == [0, 0, 0]


def test_the_reaction_says_what_it_is():
    _, eq = one_joint("hinge", to=(0, 1, 0))
    reaction = eq.reactions["j"]
    assert (reaction.joint, reaction.on, reaction.frame) == ("j", "block", "ground")
    assert reaction.about == "point (0, 1, 0) of block"
    assert reaction.force.shape == reaction.moment.shape == (3, 1)


def test_reactions_are_a_mapping_of_joints():
    s = fb.System("two")
    a, b = s.body("a", fb.particle(1)), s.body("b", fb.particle(1))
    s.slider("one", s.ground, a)
    s.weld("two", a, b)
    reactions = fb.equations(s).reactions
    assert (len(reactions), list(reactions), "two" in reactions, "three" in reactions) == (
        2,
        ["one", "two"],
        True,
        False,
    )
    assert reactions["one"] is reactions["one"]


def test_a_weld_carries_weight_and_its_moment():
    s = fb.System("bracket")
    m, g, L = s.parameters("m g L")
    s.gravity = (0, -g, 0)
    s.weld("wall", s.ground, s.body("beam", fb.slender_bar(m, L, axis="x")), to=(-L / 2, 0, 0))
    reaction = fb.equations(s).reactions["wall"]
    assert reaction.force == sympy.ImmutableMatrix([0, m * g, 0])
    assert reaction.moment == sympy.ImmutableMatrix([0, 0, m * g * L / 2])
    assert reaction.components == {
        "wall_x": 0, "wall_y": m * g, "wall_z": 0, "wall_Mx": 0, "wall_My": 0, "wall_Mz": m * g * L / 2,
    }  # fmt: skip


def test_a_cylindrical_joint_carries_nothing_along_its_axis():
    s = fb.System("piston")
    m, g = s.parameters("m g")
    s.gravity = (0, -g, -g)
    s.cylindrical("bush", s.ground, s.body("rod", fb.cylinder(m, 1, 4)), axis="z", coordinate="z turn")
    reaction = fb.equations(s).reactions["bush"]
    assert reaction.force == sympy.ImmutableMatrix([0, m * g, 0])
    assert reaction.moment == sympy.zeros(3, 1)


def test_springs_of_a_joint_are_no_part_of_its_reaction():
    s = fb.System("spring")
    m, k = s.parameters("m k")
    cylinder = s.cylindrical("bush", s.ground, s.body("rod", fb.cylinder(m, 1, 4)), coordinate="z turn")
    s.spring("axial", cylinder, stiffness=k)
    s.torsion_spring("twist", cylinder, stiffness=k)
    eq = fb.equations(s)
    assert eq.reactions["bush"].force == eq.reactions["bush"].moment == sympy.zeros(3, 1)
    assert [a.name for a in eq.free_body("rod").actions][:2] == ["axial", "twist"]


def test_a_universal_joint_carries_a_moment_across_both_axes_only():
    """A rotor on a universal joint: the moment is along the cross product of the axes."""
    s = fb.System("joint")
    s.parameters("A C")
    A, C = s.expression("A"), s.expression("C")
    rotor = s.body("rotor", fb.MassProperties(1, (0, 0, 0), ((A, 0, 0), (0, A, 0), (0, 0, C))))
    s.universal("u", s.ground, rotor, coordinate="a b")
    eq = fb.equations(s)
    a, b = eq.coordinates
    normal = sympy.Matrix([0, -sin(a), cos(a)])  # x cross the turned y
    reaction = eq.reactions["u"]
    value = reaction.components["u_Mn"]
    difference = sympy.Matrix(reaction.moment) - value * normal
    assert [eq.ring.from_sympy(d) for d in difference] == [0, 0, 0]
    # against Euler's equations: M·z of the body, with M along z turned by the second angle
    assert value.has(a.diff(s.t)) and value.has(b.diff(s.t))


def test_a_screw_carries_the_thread_force_with_its_moment():
    """A nut that falls on its thread: F_z from F_z h = -M_z, with M_z from the spin."""
    s = fb.System("nut")
    m, J, h, g = s.parameters("m J h g")
    s.gravity = (0, 0, -g)
    nut = s.body("nut", fb.MassProperties(m, (0, 0, 0), ((J, 0, 0), (0, J, 0), (0, 0, J))))
    s.screw("thread", s.ground, nut, pitch=h, coordinate="phi")
    eq = fb.equations(s)
    (phi,) = eq.coordinates
    acceleration = phi.diff(s.t, 2)
    (motion,) = eq.motion
    assert sympy.expand(motion.lhs - (J + m * h**2) * acceleration - m * g * h) == 0
    force = eq.reactions["thread"].force[2]
    assert sympy.expand(force - m * (h * acceleration + g)) == 0
    moment = eq.reactions["thread"].moment[2]
    assert sympy.expand(moment + h * force) == 0


def test_section_6_6_bearing_moment_of_a_tilted_disk():
    """Disk tilted by beta on a shaft at constant omega: the moment turns with it, of size omega² times I_yz."""
    s = fb.System("shaft")
    m, R, beta, omega = s.parameters("m R beta omega")
    tilt = ((1, 0, 0), ("0", sympy.cos(beta), sympy.sin(beta)), (0, -sympy.sin(beta), sympy.cos(beta)))
    disk = s.body("disk", fb.disk(m, R))
    s.hinge(
        "bearing",
        s.ground,
        disk,
        coordinate=omega * s.t,
        child_axes=[list(row) for row in zip(*tilt, strict=True)],
    )
    eq = fb.equations(s)
    moment = eq.reactions["bearing"].moment
    # the disk's normal is (0, sin beta, cos beta) in shaft axes: I_yz = ∫ y z dm = -(C - A) sin beta cos beta
    I_yz = -(m * R**2 / 2 - m * R**2 / 4) * sin(beta) * cos(beta)
    angle = omega * s.t
    expected = sympy.Matrix([cos(angle), sin(angle), 0]) * I_yz * omega**2
    assert eq.reactions["bearing"].force == sympy.zeros(3, 1)
    difference = [eq.ring.from_sympy(a - b) for a, b in zip(moment, expected, strict=True)]
    assert difference == [0, 0, 0]
