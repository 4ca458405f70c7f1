"""Joints that close loops by an oblique axis, and by a thread: against the same joint in the tree."""

from __future__ import annotations

import math

import numpy as np
import pytest

import freebody as fb


def pair(kind, closing, **given):
    """A body on the ground by a joint, which is one of the tree, or closes the loop of a free body."""
    s = fb.System(f"{kind} {'closing' if closing else 'in the tree'}")
    s.gravity = (1, 2, -9)
    body = s.body(
        "body", fb.MassProperties(2, (0.1, 0.2, 0.05), ((0.3, 0, 0), (0, 0.4, 0.05), (0, 0.05, 0.5)))
    )
    if closing:
        s.free("air", s.ground, body)
    getattr(s, kind)("joint", s.ground, body, at=(0.5, 0, 0), to=(0, 0.3, 0.2), **given)
    return s


CLOSED = {"air_x": 0.5, "air_y": -0.3, "air_z": -0.2}
"""Where the free body's axes are those of the ground and the points of the joint meet."""
AXES = [("hinge", {"axis": (1, 2, 2)}), ("cylindrical", {"axis": (3, 4, 0)}), ("slider", {"axis": (1, 1, 1)})]
THREADS = [("screw", {"pitch": 0.15, "axis": axis}) for axis in ("x", "-z", (1, -2, 2))]


@pytest.mark.parametrize(("kind", "given"), [*AXES, *THREADS])
def test_the_loop_moves_as_the_joint_of_the_tree(kind, given):
    tree, loop = pair(kind, False, **given), pair(kind, True, **given)
    a = fb.simulate(tree, 1.5, tolerance=1e-11, samples=31)
    b = fb.simulate(loop, 1.5, initial=CLOSED, tolerance=1e-11, samples=31)
    assert "air_wx" in b.names and "air_wx" not in a.names
    one, other = a.poses["body"], b.poses["body"]
    assert np.abs(one.position - other.position).max() < 1e-7
    assert np.abs(one.rotation - other.rotation).max() < 1e-7
    force = a.reactions["joint"].force - b.reactions["joint"].force
    moment = a.reactions["joint"].moment - b.reactions["joint"].moment
    assert np.abs(force).max() < 1e-6 and np.abs(moment).max() < 1e-6


def test_many_turns_of_a_thread():
    """The nut runs down the thread by gravity, turn after turn: no angle is lost at half a turn."""
    s = pair("screw", True, pitch=0.15, axis="z")
    found = fb.simulate(s, 6, initial=CLOSED, tolerance=1e-10)
    point = found.poses["body"].position + found.poses["body"].rotation @ np.array([0, 0.3, 0.2])
    fallen = point[-1, 2] - point[0, 2]
    tree = fb.simulate(pair("screw", False, pitch=0.15, axis="z", coordinate="f"), 6, tolerance=1e-10)
    assert abs(tree["f"][-1]) > 4 * math.pi
    assert fallen == pytest.approx(0.15 * tree["f"][-1], rel=1e-6)


def test_names_of_oblique_forces():
    e = fb.equations(pair("hinge", True, axis=(1, 2, 2)))
    assert e.condition_names == ("joint_x", "joint_y", "joint_z", "joint_Mp", "joint_Mq")
    e = fb.equations(pair("screw", True, axis=(1, 2, 2), pitch=1))
    assert e.condition_names == ("joint_p", "joint_q", "joint_Mp", "joint_Mq", "joint_n")
    e = fb.equations(pair("screw", True, axis="y", pitch=1))
    assert e.condition_names == ("joint_z", "joint_x", "joint_Mz", "joint_Mx", "joint_y")


def test_symbolic_axis_that_leans():
    """The axis may hold parameters, as the steering axis of a bicycle does."""
    s = fb.System("leaning")
    s.parameters(lam="18deg")
    body = s.body("body", fb.box(1, (1, 2, 3)))
    s.free("air", s.ground, body)
    s.hinge("axle", s.ground, body, axis=("sin(lam)", 0, "cos(lam)"))
    linear = fb.linearize(s)
    assert len(linear.coordinates) == 1
    assert linear.numeric().M.shape == (1, 1)
