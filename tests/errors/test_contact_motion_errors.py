"""Messages of motion with contact that a run reaches only in odd states: each from a scene or a state that has it."""

import re

import numpy as np
import pytest

import freebody as fb
from freebody.errors import SimulationError
from freebody.motion.contact import refusals, run
from freebody.motion.contact.state import ContactRun
from freebody.motion.events import event_run
from freebody.motion.events.code import code
from freebody.motion.ode import layout
from freebody.motion.phase.phase import NUMBERS
from freebody.motion.request import Request, problem_of
from freebody.motion.timestepping import failure, timestepping
from mixed_machines import thrown

G = 9.81


def looked_at_end(start, end, mode, wall=False, spare=0):
    """Raise what the check at the end of a phase says, of a rod between two states."""
    s = fb.System("rod")
    s.gravity = (0, -G, 0)
    rod = s.body("rod", fb.slender_bar(1, 2, axis="y"))
    s.planar("plane", s.ground, rod, coordinate="x y turn")
    surface = s.ground.segment((0, 0, 0), (1, 0, 0), normal="y") if wall else s.ground.plane()
    s.contact("tip", rod.point(0, -1, 0), surface, friction=0.2)
    problem = problem_of(Request(s, 1))
    work = ContactRun.of(problem, np.full(8, 1e-9), np.full(8, 1e-9))
    it = work.it
    it.times[:2], it.lengths[0], it.logged, it.t = (0, 0.5), 0.5, 2, 0.5
    it.states[:6], it.y[:6] = start, end
    it.mode[:], it.spare_count = NUMBERS[mode], spare
    if why := code("depth")(it, layout.FINISHED):
        raise refusals.refusal(work, why)
    if code("parted")(it):
        raise refusals.refusal(work, event_run.PARTED)


def test_a_contact_that_was_passed_over():
    deep = (0.5, 0.99, 0, 0, 0, 0)
    with pytest.raises(SimulationError, match=r"'tip' of 'rod' closed between 0 and 0.5 s within one step of .* s, and was passed over: it is 0.01 m deep. Give a max_step"):  # fmt: skip  # noqa: E501
        looked_at_end((0.5, 1, 0, 0, 0, 0), deep, "open")
    looked_at_end((0.5, 1, 0, 0, 0, 0), deep, "stick")
    looked_at_end(
        (-1, 1, 0, 0, 0, 0), (-1, 0.99, 0, 0, 0, 0), "open", wall=True
    )  # beside its side it may be below


@pytest.mark.parametrize("mode,v", [("slip+", -1e-3), ("slip-", 1e-3)])
def test_a_sense_of_slip_that_was_passed_over(mode, v):
    with pytest.raises(SimulationError, match="'tip' of 'rod' changed its sense of slip between 0 and 0.5 s within one step of .* s, and was passed over. Give a max_step shorter"):  # fmt: skip  # noqa: E501
        looked_at_end((0, 1, 0, 0, 0, 0), (0, 1, 0, v, 0, 0), mode)
    looked_at_end((0, 1, 0, 0, 0, 0), (0, 1, 0, -v, 0, 0), mode)


@pytest.mark.parametrize("y", [(0, 1.001, 0, 0, 0, 0), (0, 1, 0, 1e-3, 0, 0)])
def test_a_contact_that_no_longer_follows_from_the_others(y):
    start = (0, 1, 0, 0, 0, 0)
    with pytest.raises(SimulationError, match=r"Contact 'tip' of 'rod' followed from the others at t = 0 s, as at a dead centre, and no longer at 0.5 s, where its gap is .* m. No set of modes leads from there. Change the start"):  # fmt: skip  # noqa: E501
        looked_at_end(start, y, "stick", spare=1)
    looked_at_end(start, y, "stick")
    looked_at_end(start, start, "stick", spare=1)


def standing(mu=0.5, adhesion=0, **push):
    """A cylinder that stands on its edge, or falls on it."""
    s = fb.System("can")
    s.gravity = (0, 0, -G)
    can = s.body("can", fb.cylinder(1, 0.1, 0.3))
    s.free("f", s.ground, can)
    rim = can.circle(0.1, at=(0, 0, -0.15))
    s.contact("rim", rim, s.ground.plane(normal="z"), friction=mu, adhesion=adhesion)
    if push:
        s.force("push", can.origin, (push["along"], push["across"], 0))
    return s


def test_a_disk_that_bears_adhesion_and_should_carry_a_moment_is_refused_soon():
    with pytest.raises(SimulationError, match="'can' does not move on: 20000 steps led from t = .* to .* s .contacts: 'rim'.. Forces hold it .* as of 'rim', touches at its lowest point, which jumps where the disk lies flat: give it points along the edge, body.corners") as caught:  # fmt: skip  # noqa: E501
        fb.simulate(standing(along=0.5, across=0, adhesion=0.1), 1, initial={"f_z": 0.15})
    assert caught.value.trajectory.path.end > 0
    motion = fb.simulate(standing(adhesion=0.1), 1, initial={"f_z": 0.15})
    assert np.abs(motion.at(1).u).max() == 0  # without a moment it stands


def test_a_disk_with_adhesion_that_falls_through_lying_flat_says_why():
    turn = {"f_e0": float(np.cos(0.15)), "f_e1": float(np.sin(0.15))}
    with pytest.raises(
        SimulationError, match="of 'rim', touches at its lowest point, which jumps where the disk lies flat"
    ):
        fb.simulate(standing(adhesion=0.1), 1, initial={"f_z": 0.3, **turn})


def test_short_steps_of_an_explicit_method_name_the_one_that_changes():
    """A slip that begins and turns at once is stiff: 33 implicit steps, or 20,000 of 1 ns."""
    s, start = thrown(35)
    with pytest.raises(SimulationError, match="does not move on: 20000 steps .* If its forces are stiff, as where a slip begins, method='auto' has implicit steps where 'dop54' has short ones"):  # fmt: skip  # noqa: E501
        fb.simulate(s, 0.6, initial=start, method="dop54")
    assert fb.simulate(s, 0.6, initial=start).status == "finished"


def test_two_laws_at_once_are_refused():
    s = fb.System("box")
    s.gravity = (0, -G, 0)
    box = s.body("box", fb.box(1, (1, 1, 1)))
    s.planar("plane", s.ground, box, coordinate="x y turn")
    for name, x, law in (("a", -0.5, "newton"), ("b", 0.5, "poisson")):
        s.contact(name, box.point(x, -0.5, 0), s.ground.plane(), restitution=0.5, impact=law)
    with pytest.raises(SimulationError, match="Contacts 'a', 'b' collide at once, some by Newton's and some by Poisson's law"):  # fmt: skip  # noqa: E501
        fb.simulate(s, 1, initial={"y": 0.6})


def test_phases_without_end(monkeypatch):
    monkeypatch.setattr(run.limits, "PHASES", 3)
    s = fb.System("ball")
    (g,) = (s.parameters(g=G),)
    s.gravity = (0, -g, 0)
    ball = s.body("ball", fb.disk(1, 0.1))
    s.planar("plane", s.ground, ball, coordinate="x y turn")
    s.contact("floor", ball.circle(0.1), s.ground.plane(), friction=0, restitution=0.9)
    with pytest.raises(SimulationError, match="of 'ball' has more than 3 phases between events up to t = "):
        fb.simulate(s, 5, initial={"y": 1})


def test_friction_of_three_legs_that_reaches_its_limit():
    """A pull beside the middle that grows: how the legs share friction in space decides when they slip, and whither."""
    s = fb.System("table")
    g, mu = s.parameters(g=G, mu=0.3)
    s.gravity = (0, 0, -g)
    table = s.body("table", fb.box(2, (0.4, 0.3, 0.2)))
    s.free("f", s.ground, table)
    legs = table.corners((-0.2, -0.15, -0.1), (0.2, -0.15, -0.1), (0, 0.15, -0.1))
    s.contact("leg", legs, s.ground.plane(normal="z"), friction=mu)
    s.force("F", table.point(0, 0.1, -0.1), (s.t, 0, 0))
    with pytest.raises(
        SimulationError, match="indeterminate: friction, shared in proportion to N, has reached"
    ):
        fb.simulate(s, 6, initial={"f_z": 0.1}, indeterminate="refuse")


def test_three_feet_of_different_friction():
    s = fb.System("sledge")
    (g,) = (s.parameters(g=G),)
    s.gravity = (0, -g, 0)
    body = s.body("sledge", fb.box(2, (1, 0.2, 1)))
    s.planar("plane", s.ground, body, coordinate="x y turn")
    for i, (x, mu) in enumerate(((-0.5, 0.1), (0, 0.3), (0.5, 0.2))):
        s.contact(f"foot{i}", body.point(x, -0.1, 0), s.ground.plane(), friction=mu)
    with pytest.raises(SimulationError, match="are statically indeterminate, and each distribution moves the machine differently"):  # fmt: skip  # noqa: E501
        fb.simulate(s, 0.1, initial={"y": 0.1, "x'": 3}, indeterminate="refuse")
    # with one coefficient the distribution does not matter
    s2 = fb.System("sledge")
    s2.gravity = (0, -G, 0)
    body = s2.body("sledge", fb.box(2, (1, 0.2, 1)))
    s2.planar("plane", s2.ground, body, coordinate="x y turn")
    for i, x in enumerate((-0.5, 0, 0.5)):
        s2.contact(f"foot{i}", body.point(x, -0.1, 0), s2.ground.plane(), friction=0.2)
    motion = fb.simulate(s2, 0.1, initial={"y": 0.1, "x'": 3})
    assert motion.at(0.1)["x'"] == pytest.approx(3 - 0.2 * G * 0.1, rel=1e-12)


def test_a_time_step_that_is_not_solved(monkeypatch):
    s = fb.System("disk")
    s.gravity = (0, -G, 0)
    disk = s.body("disk", fb.disk(1, 0.1))
    s.planar("plane", s.ground, disk, coordinate="x y turn")
    s.contact("floor", disk.circle(0.1), s.ground.plane(), friction=0.2)
    monkeypatch.setattr(timestepping, "RESIDUAL", -1.0)  # cannot be reached
    for module in (timestepping, failure):
        monkeypatch.setattr(module, "MOST_SWEEPS", 3000)
    # the last sweeps are accepted if they are close enough
    motion = fb.simulate(s, 0.1, initial={"y": 0.1, "x'": 1}, method="timestepping", step=0.01)
    assert motion.status == "finished" and motion.residual <= 1e-9
    assert motion.sweeps <= 300  # four turns of eight
    for name in ("ACCEPTED", "MOST_ACCEPTED"):
        monkeypatch.setattr(failure, name, -1.0)
    with pytest.raises(SimulationError, match="'disk' were not solved in the step at t = 0 s: after 3000 sweeps and Newton's method a law is still missed by .* \\(required: -1\\). Where friction jams a contact"):  # fmt: skip  # noqa: E501
        fb.simulate(s, 0.1, initial={"y": 0.1, "x'": 1}, method="timestepping", step=0.01)


def table(**loads):
    s = fb.System("table")
    s.gravity = (0, 0, -G)
    top = s.body("top", fb.box(10, (1, 0.8, 0.1)))
    s.free("f", s.ground, top)
    legs = top.corners((-0.5, -0.4, -0.4), (0.5, -0.4, -0.4), (0.5, 0.4, -0.4), (-0.5, 0.4, -0.4))
    s.contact("leg", legs, s.ground.plane(normal="z"), friction=0.3)
    for name, (at, components) in loads.items():
        s.force(name, top.point(*at), components)
    return s


def test_a_table_that_is_pulled_evenly_slides_and_one_that_turns_as_it_slides_is_refused():
    evenly = fb.simulate(table(F=((0, 0, 0), (60, 0, 0))), 1, initial={"f_z": 0.4})
    # m a = F - mu m g, however the legs share the weight
    assert evenly.at(1)["f_vx"] == pytest.approx(6 - 0.3 * G, rel=1e-9)
    assert {f"N_leg_{k}" for k in range(1, 5)} <= set(evenly.indeterminate)
    beside = table(F=((0, 0.1, 0), (60, 0, 0)))
    with pytest.raises(SimulationError, match="statically indeterminate, and each distribution moves the machine differently .* or take indeterminate='compliance'"):  # fmt: skip  # noqa: E501
        fb.simulate(beside, 1, initial={"f_z": 0.4}, indeterminate="refuse")
    spinning = {"f_z": 0.4, "f_vx": 1, "f_wz": 1}
    with pytest.raises(SimulationError, match="or take indeterminate='compliance', which decides for the limit of equal compliance"):  # fmt: skip  # noqa: E501
        fb.simulate(table(), 1, initial=spinning, indeterminate="refuse")
    chosen = fb.simulate(table(), 1, initial=spinning, indeterminate="compliance")
    assert chosen.energy.relative_residual < 1e-8
    assert chosen.modes[-1].mode == "stick"
    N = np.array([chosen.contacts[f"leg_{k}"].least[:, 0] for k in range(1, 5)])
    before = chosen.t < chosen.events[0].time
    assert N[:, before].sum(axis=0) == pytest.approx(10 * G, rel=1e-9)


def test_an_unknown_choice_for_indeterminate_forces():
    with pytest.raises(SimulationError, match=r"Expected indeterminate='compliance' \(the limit of equal compliance\) or 'refuse', got 'most'"):  # fmt: skip  # noqa: E501
        fb.simulate(table(), 1, initial={"f_z": 0.4}, indeterminate="most")


@pytest.mark.parametrize("friction", ["sqrt(0.1 + x)", "log(x)", "acos(x - 2)"])
@pytest.mark.parametrize("speed", [0, 1])
def test_friction_without_a_value(friction, speed):
    s = fb.System("block")
    s.gravity = (1, -G, 0)
    block = s.body("block", fb.particle(1))
    s.chain("move", s.ground, block, [fb.Slider("x", "x"), fb.Slider("y", "y")])
    s.contact("floor", block.origin, s.ground.plane(), friction=friction)
    with pytest.raises(SimulationError) as caught:
        fb.simulate(s, 1, initial={"x": -1, "x'": speed})
    said = (
        "The friction of 'floor' of 'block' has no finite value at t = 0 s."
        if speed
        else "The friction of contact 'floor' has no value there."
    )
    assert f"{said} " in str(caught.value)
    assert "Write a law that has one wherever the contact is closed." in str(caught.value)


def test_outputs_of_a_stop_and_in_expressions():
    s = fb.System("bar")
    s.gravity = (0, -G, 0)
    bar = s.body("bar", fb.slender_bar(1, 1, axis="y"))
    pin = s.hinge("pin", s.ground, bar, to=(0, 0.5, 0), axis="z", coordinate="theta")
    s.stop("wall", pin, low=-0.2)
    motion = fb.simulate(s, 0.1, initial={"theta": 0.5})
    for value, said in (
        (
            "wall.slip",
            "Expected a contact with tangents for 'wall.slip', but 'wall' has none: nothing slips there. Its "
            "quantities are gap, approach, normal, mode.",
        ),
        (
            "2*wall.normal - 1",
            "Expected 'wall.normal' by itself in output '2*wall.normal - 1': outputs take no expressions of quantities "
            "of contacts. Ask for it, and compute with its numbers; events take such expressions.",
        ),
    ):
        with pytest.raises(SimulationError) as caught:
            motion[value]
        assert str(caught.value) == said


@pytest.mark.parametrize(
    ("sensor", "said"),
    [
        ("floor.nrml", "Unknown quantity 'nrml' of contact 'floor' in sensor 'N' of controller 'law'"),
        ("flor.normal", "Unknown contact 'flor' in sensor 'N' of controller 'law'; did you mean 'floor'"),
        ("floor.mode", "Expected a number in sensor 'N' of controller 'law', got the mode of contact"),
        ("rail.force", "and the time for sensor 'N' of controller 'law', got 'rail.force', which is"),
    ],
)
def test_sensors_of_contacts_that_a_motion_does_not_know(sensor, said):
    s = fb.System("ball")
    u = s.parameters(u=0.0)
    s.gravity = (0, -G, 0)
    ball = s.body("ball", fb.particle(1))
    s.slider("rail", s.ground, ball, axis="y", coordinate="y")
    s.contact("floor", ball.origin, s.ground.plane())
    s.force("lift", ball.origin, (0, u, 0))
    s.controller(lambda t, x: x["N"], 0.1, "u", sensors={"N": sensor}, name="law")
    with pytest.raises(SimulationError, match=re.escape(said)):
        fb.simulate(s, 1, initial={"y": 1})
