"""What cannot be computed live is refused, with the reason and a cure."""

from __future__ import annotations

import re

import pytest

import freebody as fb
from contact_machines import pulled_disk
from freebody.errors import SimulationError
from freebody.motion.live.export import check_live
from live_machines import double_pendulum, motion_of

WITHOUT = "Write the page without live=True: it shows the motion that was computed here."


def refused(motion: fb.Trajectory, text: str) -> None:
    with pytest.raises(SimulationError, match=f"^{re.escape(text)}$"):
        check_live(motion)


def test_time_steps():
    motion = fb.simulate(pulled_disk(), 0.1, method="timestepping", step=1e-3)
    refused(
        motion,
        "Expected a motion from event to event for a live motion of 'pulled_disk', got one by time steps. Leave out "
        "method='timestepping', or write the page without live=True.",
    )


def test_a_motion_with_contacts_from_a_file(tmp_path):
    fb.simulate(pulled_disk(), 0.1).save(tmp_path / "disk.nc")
    refused(
        fb.Trajectory.load(tmp_path / "disk.nc"),
        "Expected a motion with contacts that was computed just now for a live motion of 'pulled_disk', got one from a "
        "file. Simulate it again, or write the page without live=True.",
    )


def test_blows_on_a_machine_with_contacts():
    s = pulled_disk()
    blow = fb.blow(0.05, at=s.bodies["disk"], impulse=(1, 0, 0))
    refused(
        fb.simulate(s, 0.1, impulses=[blow]),
        "Expected a motion without blows for a live motion of 'pulled_disk', got one with. Leave them out, or write "
        "the page without live=True.",
    )


def test_contacts_of_whole_bodies():
    s = fb.System("balls")
    s.gravity = (0, 0, -9.81)
    bodies = [s.body(name, fb.sphere(1, 0.1)) for name in "ab"]
    for k, body in enumerate(bodies):
        s.free(f"free_{body.name}", s.ground, body, at=(k, 0, 1))
    s.contacts("balls", [body.sphere(0.1) for body in bodies], friction=0.5, restitution=0)
    refused(
        fb.simulate(s, 0.01, method="timestepping", step=1e-3),
        f"Expected contacts of named features for a live motion of 'balls', got contacts of whole bodies, "
        f"'balls'. {WITHOUT}",
    )


def test_solids_that_touch_in_patches():
    s = fb.System("box")
    body = s.body("box", fb.box(1, (1, 1, 1)))
    s.free("f", s.ground, body)
    s.contacts("faces", [body.box((1, 1, 1)), s.ground.box((9, 9, 1), at=(0, 0, -0.5))], friction=0)
    refused(
        fb.simulate(s, 0.01, initial={"f_z": 0.6}),
        f"Expected contacts at single points for a live motion of 'box', got solids that touch in patches, 'faces'. "
        f"{WITHOUT}",
    )


def test_many_contacts():
    s = fb.System("comb")
    s.gravity = (0, -9.81, 0)
    bar = s.body("bar", fb.slender_bar(1, 1, axis="x"))
    s.planar("plane", s.ground, bar, coordinate="x y theta")
    for k in range(51):
        s.contact(f"tooth_{k}", bar.point(k / 50 - 1 / 2, 0, 0), s.ground.plane(at=(0, -1, 0)), friction=0.1)
    refused(
        fb.simulate(s, 0.01),
        "Expected contacts with at most 100 forces and components of friction for a live motion of 'comb', got 102. "
        f"{WITHOUT}",
    )


def test_a_controller():
    s = double_pendulum()
    s.parameters(tau=0.0)
    s.torque("motor", s.joints["upper"], "tau")
    s.controller(lambda t, x: -x["q1"], 0.1, "tau", name="hold")
    refused(
        fb.simulate(s, 0.2),
        "Expected a machine without controllers for a live motion of 'double pendulum', got controller 'hold', whose "
        f"Python does not run in a page. {WITHOUT}",
    )


def test_a_signal():
    s = double_pendulum()
    s.force("gust", s.bodies["b"].origin, (fb.signal([0, 1], [0, 1], name="wind"), 0, 0))
    refused(
        fb.simulate(s, 0.2),
        "Expected a machine whose forces are smooth in time for a live motion of 'double pendulum', got signals that "
        f"switch. {WITHOUT}",
    )


def test_a_large_machine():
    s = fb.System("chain")
    s.gravity = (0, -9.81, 0)
    last = s.ground
    for k in range(60):
        body = s.body(f"b{k}", fb.slender_bar(1, 1, axis="y"))
        s.hinge(
            f"h{k}",
            last,
            body,
            at=(0, 0 if k == 0 else -0.5, 0),
            to=(0, 0.5, 0),
            axis="z",
            coordinate=f"q{k}",
        )
        last = body
    refused(
        fb.simulate(s, 0.01),
        f"Expected a machine of at most 40 bodies for a live motion of 'chain', got one of 60. {WITHOUT}",
    )


def test_conditions_that_others_imply():
    """Three equal cranks on one coupler: two of them move it, and the third follows."""
    s = fb.System("cranks")
    coupler = s.body("coupler", fb.slender_bar(1, 2, axis="x"))
    cranks = [s.body(f"crank_{k}", fb.slender_bar(1, 1, axis="y")) for k in range(3)]
    for k, crank in enumerate(cranks):
        s.hinge(f"A{k}", s.ground, crank, at=(k - 1, 0, 0), to=(0, -0.5, 0), axis="z", coordinate=f"q{k}")
    s.hinge("B0", cranks[0], coupler, at=(0, 0.5, 0), to=(-1, 0, 0), axis="z", coordinate="p")
    for k in (1, 2):
        s.hinge(f"B{k}", coupler, cranks[k], at=(k - 1, 0, 0), to=(0, 0.5, 0), axis="z")
    motion = fb.simulate(s, 0.1, initial={"q0": 0.3, "q0'": 1})
    with pytest.raises(
        SimulationError, match=r"^Expected (conditions that are independent|a motion in one leg)"
    ):
        check_live(motion)


def test_blows():
    s = double_pendulum()
    motion = fb.simulate(
        s, 1, initial={"q1": 1}, impulses=[fb.blow(0.5, at=s.bodies["b"], impulse=(1, 0, 0))]
    )
    refused(
        motion,
        "Expected a motion in one leg for a live motion of 'double pendulum', got one that blows, or conditions that "
        "depend on each other, interrupt. Leave out the blows, or write the page without live=True.",
    )


def test_a_stiff_motion():
    s = double_pendulum()
    s.damper("c", s.joints["upper"], damping=1e7)
    motion = fb.simulate(s, 5, initial={"q1": 1}, tolerance=1e-6, method="radau")
    refused(
        motion,
        "Expected a motion for explicit steps for a live motion of 'double pendulum', got a stiff one, for which "
        "method 'radau' was needed. Lower the stiffness or the damping that decays fastest, or write the page without "
        "live=True.",
    )


@pytest.mark.parametrize("steps", [0, -1, 1.5, True, 10_000_000])
def test_a_number_of_steps_that_is_none(steps):
    with pytest.raises(SimulationError, match=f"Expected most_steps= between 1 and 1000000, got {steps!r}"):
        fb.compile(double_pendulum()).to_wasm(1, most_steps=steps)


def test_a_smooth_motion_is_not_refused():
    check_live(motion_of("four-bar", until=0.1))
