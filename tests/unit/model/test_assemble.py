"""The model that a description becomes."""

from __future__ import annotations

import dataclasses

import pytest
import sympy

import freebody as fb
from freebody.model.model import GROUND


def chain(count=3, absolute=False):
    s = fb.System("chain")
    names = [f"q{i}" for i in range(count)]
    q = s.coordinates(" ".join(names)) if absolute else None
    parent = s.ground
    for i in range(count):
        bar = s.body(f"bar{i}", fb.slender_bar(1, 2, axis="y"))
        coordinate = names[i] if q is None else q[i] - (q[i - 1] if i else 0)
        s.hinge(f"pin{i}", parent, bar, at=(0, -1 if i else 0, 0), to=(0, 1, 0), coordinate=coordinate)
        parent = bar
    return s


def test_a_model_is_frozen():
    model = fb.assemble(chain())
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.name = "other"
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.links[0].mass = 2


def test_links_stand_at_the_joints():
    """Frame of a link at the point ``to`` of its child; the child's origin seen from there."""
    model = fb.assemble(chain())
    assert [link.parent for link in model.links] == [GROUND, 0, 1]
    assert [link.position for link in model.links] == [(0, 0, 0), (0, -2, 0), (0, -2, 0)]
    assert model.bodies["bar1"].origin == (0, -1, 0)
    assert model.links[1].center == (0, -1, 0)
    assert model.joints["pin1"].links == (1,)


def test_order_of_description_is_kept_but_links_go_outward():
    s = fb.System("backwards")
    tip, root = s.body("tip", fb.particle(1)), s.body("root", fb.particle(1))
    s.slider("b", root, tip, coordinate="y")
    s.slider("a", s.ground, root, coordinate="x")
    model = fb.assemble(s)
    assert (list(model.bodies), list(model.joints)) == (["tip", "root"], ["b", "a"])
    assert [link.body for link in model.links] == ["root", "tip"]
    assert model.coordinate_names == ("y", "x")


def test_joints_of_several_motions_have_massless_links():
    s = fb.System("top")
    rotor = s.body("rotor", fb.disk(1, 1))
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -1), axis="ZXZ")
    model = fb.assemble(s)
    assert [link.body for link in model.links] == [None, None, "rotor"]
    assert [link.mass for link in model.links] == [0, 0, 1]
    assert [link.axis for link in model.links] == [(0, 0, 1), (1, 0, 0), (0, 0, 1)]


def test_axes_are_made_unit_and_turned_into_the_body():
    s = fb.System("oblique")
    bar = s.body("bar", fb.box(1, (1, 1, 1)))
    turn = ((0, -1, 0), (1, 0, 0), (0, 0, 1))  # the joint's x along the body's y
    s.hinge("pin", s.ground, bar, axis=(3, 4, 0), child_axes=turn, parent_axes=fb.Rotation.axis_angle("x", 0))
    (link,) = fb.assemble(s).links
    assert link.axis == (-sympy.Rational(4, 5), sympy.Rational(3, 5), 0)


def test_expressions_are_differentiated_once():
    s = fb.System("cam")
    q, L = s.coordinates("q"), s.parameters("L")
    block = s.body("block", fb.particle(1))
    s.slider("rail", s.ground, block, coordinate=L * sympy.sin(q) + s.t**2)
    (link,) = fb.assemble(s).links
    v = q.diff(s.t)
    assert link.partials == ((0, L * sympy.cos(q)),)
    assert link.drift == 2 * s.t
    assert sympy.expand(link.bias - (2 - L * sympy.sin(q) * v**2)) == 0
    assert not link.driven


def test_absolute_angles_are_solved_in_order():
    model = fb.assemble(chain(4, absolute=True))
    assert [link.partials for link in model.links] == [
        ((0, 1),), ((0, -1), (1, 1)), ((1, -1), (2, 1)), ((2, -1), (3, 1)),
    ]  # fmt: skip
    assert model.order == ((0, 0), (1, 1), (2, 2), (3, 3))


@pytest.mark.parametrize(
    ("coordinates", "solved"),
    [
        (["q1 + q2", "q2"], True),  # from the last to the first
        (["q1 + q2", "q1 - q2"], False),  # together only
        (["q1", "2*q1", "q2"], False),  # more displacements than coordinates
        (["q1", "3*q2 + L*q1"], True),
        (["q1", "L*q2"], False),  # L may be zero
        (["q1", "q2*q1"], False),  # as may q1
    ],
)
def test_coordinates_that_are_not_solved_one_by_one_go_by_the_mass_matrix(coordinates, solved):
    s = fb.System("mixed")
    s.parameters(L=2)
    s.coordinates("q1 q2")
    for i, coordinate in enumerate(coordinates):
        s.slider(f"rail{i}", s.ground, s.body(f"b{i}", fb.particle(1)), coordinate=s.expression(coordinate))
    assert (fb.assemble(s).order is not None) == solved


def test_driven_joints_have_no_speed():
    s = fb.System("shaft")
    omega = s.parameters(omega=3)
    shaft = s.body("shaft", fb.disk(1, 1))
    s.hinge("bearing", s.ground, shaft, coordinate=omega * s.t)
    model = fb.assemble(s)
    assert (model.n_q, model.n_u) == (0, 0)
    assert model.links[0].driven
    assert (model.links[0].drift, model.links[0].bias) == (omega, 0)


def test_quaternions_are_known_by_their_place():
    s = fb.System("flight")
    for name in "ab":
        s.free(name, s.ground, s.body(f"body_{name}", fb.sphere(1, 1)))
    s.ball("c", "body_a", s.body("body_c", fb.sphere(1, 1)))
    model = fb.assemble(s)
    assert model.quaternions == (3, 10, 14)
    assert [model.coordinate_names[i] for i in model.quaternions] == ["a_e0", "b_e0", "c_e0"]
    assert [c.kind for c in model.coordinates[:4]] == ["position"] * 3 + ["quaternion"]


def test_assembly_is_linear_in_the_number_of_bodies():
    """Five hundred links: a quadratic step would show in the count of calls of the profiler."""
    import cProfile
    import pstats

    def calls(count):
        s = chain(count)
        profile = cProfile.Profile()
        profile.runcall(fb.assemble, s)
        return pstats.Stats(profile).total_calls

    small, large = calls(50), calls(200)
    assert large <= 4.5 * small
