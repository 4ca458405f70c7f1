"""The stop and the dry friction of a ball: as a hinge where it moves like one, in files and in errors."""

from __future__ import annotations

import math

import pytest

import freebody as fb
from freebody.describe.contacts.turn import ShiftFriction, TurnFriction, TurnStop
from freebody.errors import ModelError
from freebody.testing import check_contact

RELATIVE = 1e-9
"""Of motions with an error of 1e-11 a step."""


def pendulum(kind: str) -> fb.System:
    s = fb.System("pendulum")
    s.gravity = (0, 0, -9.81)
    rod = s.body("rod", fb.MassProperties(2, (0, 0, -0.5), ((0.2, 0, 0), (0, 0.2, 0), (0, 0, 0.1))))
    axes = {"parent_axes": ((0, 0, 1), (1, 0, 0), (0, 1, 0)), "child_axes": ((0, 0, 1), (1, 0, 0), (0, 1, 0))}
    if kind == "ball":
        s.ball("pin", s.ground, rod, **axes)
    else:
        s.hinge("pin", s.ground, rod, axis="x", coordinate="theta")
    return s


@pytest.mark.parametrize("high", [0.3, 2.5])
def test_the_power_of_its_moment_is_the_rate_of_the_gap(high: float) -> None:
    check_contact(TurnStop, high=high)


def test_friction_moves_about_the_axes_of_the_child() -> None:
    check_contact(TurnFriction, friction=0.3)


def test_friction_of_a_free_joint_along_the_axes_of_the_parent() -> None:
    check_contact(ShiftFriction, friction=0.3)


def test_a_free_body_stops_along_each_axis_by_itself_as_in_mjcf(tmp_path) -> None:
    """A mass that turns: each component of its velocity stops after m v/F, each turn of a sphere after J w/F."""
    xml = """<mujoco><option gravity="0 0 0"/><worldbody><body name="stone"><joint name="air" type="free"
    frictionloss="0.5"/><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/></body></worldbody></mujoco>"""
    path = tmp_path / "stone.xml"
    path.write_text(xml)
    start = {"air_vx": 0.3, "air_vy": -0.2, "air_vz": 0.1, "air_wx": 0.35}
    times = sorted([2 * 0.3 / 0.5, 2 * 0.2 / 0.5, 2 * 0.1 / 0.5, 0.35 / 0.5])
    s = fb.read(path, friction=True, symbols="none")
    fb.write(s, tmp_path / "again.xml")
    for system in (s, fb.read(tmp_path / "again.xml", friction=True, symbols="none")):
        start = {name: start[name] for name in start}
        motion = fb.simulate(system, 2, initial=start, tolerance=1e-11)
        stops = sorted({round(event.time, 8) for event in motion.events})
        assert stops == pytest.approx(times, rel=1e-8)
        assert motion.energy.kinetic[-1] == 0


def test_a_ball_that_swings_in_a_plane_stops_and_rubs_as_a_hinge() -> None:
    """The axis of the swing is x of the body, z of the joint's axes (they are turned on both sides alike)."""
    ends = []
    for kind, speed in (("ball", "pin_wx"), ("hinge", "theta'")):
        s = pendulum(kind)
        pin = s.joints["pin"]
        low = {} if kind == "ball" else {"low": -0.5}
        s.stop("wall", pin, high=0.5, restitution=0.5, **low)
        s.friction("dry", pin, torque="0.3 + 0.2*exp(-slip/0.5)", static=0.6)
        motion = fb.simulate(s, 1, initial={speed: 3.0}, tolerance=1e-11)
        ends.append([motion[speed][-1], motion.energy.kinetic[-1], *(event.time for event in motion.events)])
        if kind == "ball":
            assert motion["pin_wy"][-1] == motion["pin_wz"][-1] == 0
    ball, hinge = ends
    assert ball[:2] == pytest.approx(hinge[:2], rel=RELATIVE)
    assert set(round(t, 9) for t in hinge[2:]) == set(round(t, 9) for t in ball[2:])


def test_friction_about_each_axis_by_itself() -> None:
    """A sphere of inertia J about each axis: each component of ω stops after J ω/T."""
    s = fb.System("sphere")
    J, T = 0.02, 0.05
    s.ball(
        "socket",
        s.ground,
        s.body("sphere", fb.MassProperties(1, (0, 0, 0), ((J, 0, 0), (0, J, 0), (0, 0, J)))),
    )
    s.friction("dry", s.joints["socket"], torque=T)
    motion = fb.simulate(s, 2, initial={"socket_wx": 3.0, "socket_wy": -1.0, "socket_wz": 2.0})
    stops = sorted(event.time for event in motion.events)
    assert stops == pytest.approx([J * w / T for w in (1.0, 2.0, 3.0)], rel=RELATIVE)
    assert [motion[f"socket_w{x}"][-1] for x in "xyz"] == pytest.approx([0, 0, 0], abs=1e-100)


def test_the_stop_of_a_free_joint_and_the_angle_where_it_closes() -> None:
    s = fb.System("stone")
    s.free(
        "air", s.ground, s.body("stone", fb.MassProperties(1, (0, 0, 0), ((1, 0, 0), (0, 1, 0), (0, 0, 1))))
    )
    s.parameters(h=1.25)
    s.stop("wall", s.joints["air"], high="h")
    motion = fb.simulate(s, 3, initial={"air_wx": 0.6, "air_wz": 0.8})
    assert [event.time for event in motion.events][0] == pytest.approx(1.25, rel=RELATIVE)
    assert motion["wall.gap"][0] == pytest.approx((1 - math.cos(1.25)) / math.sin(1.25))


def test_it_is_written_and_read_again(tmp_path) -> None:
    s = pendulum("ball")
    s.stop("wall", s.joints["pin"], high=0.5)
    s.friction("dry", s.joints["pin"], torque=0.3)
    start = {"pin_wx": 2.0, "pin_wy": 1.0}
    found = [fb.simulate(s, 0.6, initial=start).energy.kinetic[-1]]
    for name, options in (("it.toml", {}), ("it.xml", {"limits": True, "friction": True, "symbols": "none"})):
        fb.write(s, tmp_path / name)
        again = fb.read(tmp_path / name, **options)
        turned = name == "it.xml"  # the body of a file has the axes of the joint
        mine = {"pin_wz": 2.0, "pin_wx": 1.0} if turned else start
        found.append(fb.simulate(again, 0.6, initial=mine).energy.kinetic[-1])
    assert found[1] == pytest.approx(found[0], rel=RELATIVE)


REFUSED = {
    "low": ("stop", {"low": 0, "high": 1}, "an angle from 0 to π about any axis: give high= alone"),
    "no end": ("stop", {}, "Stop 'x' has no end, but ball joint 'pin' has a turn"),
    "compliant": ("stop", {"high": 1, "stiffness": 2}, "Stop 'x' has a stiffness, but ball joint 'pin' has a turn"),
    "too far": ("stop", {"high": 4}, "the greatest angle of the turn, got 4 rad. No turn is larger: leave it out"),
    "nothing": ("stop", {"high": 0}, "got 0 rad. A joint that does not turn is s.weld"),
    "force": ("friction", {"force": 1}, "for friction 'x', since ball joint 'pin' turns about all axes"),
    "both": ("friction", {"force": 1, "torque": 1}, "Expected torque= alone for friction 'x'"),
    "load": ("friction", {"coefficient": 1, "radius": 1}, "Expected torque= alone for friction 'x'"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_no_ball_has_is_refused(case: str) -> None:
    what, data, message = REFUSED[case]
    s = pendulum("ball")
    with pytest.raises(ModelError) as caught:
        getattr(s, what)("x", s.joints["pin"], **data)
    assert message in str(caught.value)


@pytest.mark.parametrize("part", [TurnStop, TurnFriction])
def test_a_hinge_is_no_ball(part: type) -> None:
    s = pendulum("hinge")
    data = {"high": 1} if part is TurnStop else {"friction": 1}
    with pytest.raises(
        ModelError, match="acts against the turn of a ball or free joint, but 'pin' is a hinge"
    ):
        s.add("x", part(s.joints["pin"], **data))


def test_a_free_joint_has_friction_of_turns_or_of_displacements() -> None:
    s = fb.System("stone")
    air = s.free("air", s.ground, s.body("stone", fb.sphere(1, 0.1)))
    for data in ({}, {"force": 1, "torque": 1}, {"force": 1, "coefficient": 1}):
        with pytest.raises(
            ModelError, match="Expected torque= or force= alone for friction 'x', since free joint"
        ):
            s.friction("x", air, **data)
    with pytest.raises(ModelError, match="displacements of a free joint, but 'pin' is a ball"):
        system = pendulum("ball")
        system.add("x", ShiftFriction(system.joints["pin"], friction=1))
