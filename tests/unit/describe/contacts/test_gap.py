"""Contacts by their gaps: what they refuse, how they stand in equations, files, drawings and batches."""

import re

import numpy as np
import pytest

import freebody as fb
from freebody.describe.contacts.joint_friction import JointFriction
from freebody.describe.contacts.stop import CoordinateStop, Stop
from freebody.formats.toml.read import case_from_text
from freebody.formats.toml.write import toml_text
from freebody.testing import check_contact, random_state


def arm():
    s = fb.System("arm")
    s.gravity = (0, -9.81, 0)
    a, b = (s.body(name, fb.slender_bar(1, 1, axis="y")) for name in "ab")
    shoulder = s.hinge("shoulder", s.ground, a, to=(0, 0.5, 0), axis="z", coordinate="q1")
    elbow = s.hinge("elbow", a, b, at=(0, -0.5, 0), to=(0, 0.5, 0), axis="z", coordinate="q2")
    s.stop("stretched", elbow, low=0, high="3/2", restitution=0.3)
    s.stop("sum", "q1 + q2", low=-0.5, restitution=0.3)
    s.friction("dry", shoulder, torque=0.3)
    s.friction("stiff", elbow, torque=0.05, static=0.06)
    return s, shoulder, elbow


def slider(s):
    return s.slider("slot", s.ground, s.body("c", fb.particle(1)), axis="x", coordinate="x")


def sleeve(s):
    return s.cylindrical("sleeve", s.ground, s.body("c", fb.sphere(1, 1)), axis="x", coordinate="x turn")


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        (Stop, {"low": 0.5, "high": None}),
        (Stop, {"low": 0.25, "high": 2}),
        (CoordinateStop, {"expression": "x + phi^2", "low": 0.5, "high": None, "body": "ground"}),
        (JointFriction, {"friction": 2}),
    ],
)
def test_kinds_pass_the_battery(kind, data):
    check_contact(kind, **data)


def test_equations_and_reactions_have_it():
    s, *_ = arm()
    modes = {"stretched_low": "closed", "dry": "slip-", "stiff": "stick"}
    e = fb.equations(s, modes=modes)
    names = [action.name for action in e.free_body("b").actions]
    assert "N_stretched_low" in names and "T_stiff" in names and "T_dry" not in names
    (N,) = [x for x in e.free_body("b").actions if x.name == "N_stretched_low"]
    assert str(N.moment[2]) == "N_stretched_low" and all(x == 0 for x in N.force)
    assert str(e.reactions["stretched_low"].moment) == "Matrix([[0], [0], [N_stretched_low]])"
    (T,) = [x for x in e.free_body("a").actions if x.name == "T_dry"]
    assert str(T.moment[2]) == "3/10"
    one = fb.equations(s, modes={"stretched_low": "closed"})
    assert "N_stretched_low" in one.text()


def test_the_load_of_a_joint_is_a_number_of_equations_in_slip():
    s, shoulder, _ = arm()
    s.friction("pressed", shoulder, coefficient="3/4", radius="1/10")
    e = fb.equations(s, modes={"pressed": "slip+"})
    (T,) = [x for x in e.free_body("a").actions if x.name == "T_pressed"]
    assert str(T.moment[2]) == "-3*N_pressed/5"
    assert "N_pressed" in e.text() and "T_pressed" in fb.equations(s, modes={"pressed": "stick"}).text()
    read = case_from_text(toml_text(s)).system
    assert read.contacts["pressed"].radius == shoulder.parent.system.contacts["pressed"].radius
    motion = fb.simulate(s, 0.1, initial={"q1": 0.3, "q2": 0.6})
    drawn = fb.free_body_diagram(s, "a", trajectory=motion, at=0.05).svg
    assert "pressed" in drawn


def test_the_free_bodies_give_the_force_of_the_motion():
    s, *_ = arm()
    start = {"q1": 0.3, "q2": 0.6, "q1'": 0.7, "q2'": -0.2}
    s.stop("held", "q1 - q2", high=-0.3)
    s.torque("M", s.joints["shoulder"], 9)
    motion = fb.simulate(s, 0.01, initial={**start, "q2'": 0.7})
    assert motion.contacts["held"].mode[0] == "closed"
    e = fb.equations(s, modes={"held": "closed", "dry": "slip+", "stiff": "slip+"})
    N = e.solve(["N_held"], bodies=["a", "b"])["N_held"]
    atoms = e.model.names.atoms
    for name in ("q1'", "q2'", "q1", "q2"):
        N = N.subs(atoms[name], {**start, "q2'": 0.7}[name])
    assert float(N) == pytest.approx(motion.contacts["held"].normal[0], rel=1e-9)


def test_modes_are_checked():
    s, *_ = arm()
    for modes, words in {
        "stretched_low": ("stick", "has no friction and cannot stick"),
        "dry": ("closed", "has friction: expected the mode 'stick', or that of its slip, got 'closed'"),
        "stiff": ("slip", "slips along one line: expected 'slip+' or 'slip-'"),
    }.items():
        with pytest.raises(fb.FreebodyError, match=re.escape(words[1])):
            fb.equations(s, modes={modes: words[0]})


def test_a_joint_is_at_one_of_its_stops():
    s, _, _ = arm()
    message = "'stretched_low' and 'stretched_high' cannot be closed at once: .* modes={\"stretched_low\": \"closed\"}"
    with pytest.raises(fb.errors.ModelError, match=message):
        fb.equations(s, modes={"stretched": "closed"})
    modes = "modes={'stretched_low': 'closed', 'sum': 'closed', 'dry': 'stick', 'stiff': 'stick'}"
    with pytest.raises(fb.errors.ModelError, match=re.escape(modes)):
        fb.linearize(s)


def test_a_motion_obeys_the_laws_at_every_step():
    s, *_ = arm()
    motion = fb.simulate(s, 3, initial={"q1": 1.2, "q2": 0.3}, tolerance=1e-11)
    assert len(motion.events) > 10
    for name, bound in (("dry", 0.3), ("stiff", 0.06)):
        contact = motion.contacts[name]
        assert (abs(contact.tangential) <= bound * (1 + 1e-12)).all()
        slips = np.char.startswith(contact.mode.astype(str), "slip")
        assert (contact.tangential * contact.slip)[slips].max() <= 0
        assert abs(contact.slip[~slips]).max(initial=0) < 1e-9
    for name in ("stretched_low", "stretched_high", "sum"):
        contact = motion.contacts[name]
        assert contact.gap.min() > -1e-9 and contact.normal.min() >= -1e-9
        assert abs(contact.gap * contact.normal).max() < 1e-8
        assert set(contact.mode) <= {"open", "closed"}
    assert abs(motion.energy.residual).max() < 1e-8


def test_forces_have_names_and_units():
    s, _, _ = arm()
    motion = fb.simulate(s, 2, initial={"q1": 0.5, "q2": 0.75, "q2'": 2})
    assert (motion["N_stretched_high"] == motion.contacts["stretched_high"].normal).all()
    assert (motion["dry.tangential"] == motion.contacts["dry"].tangential).all()
    assert motion["dry.mode"].tolist() == motion.contacts["dry"].mode.tolist()
    assert motion["max(T_dry)"] == pytest.approx(0.3)
    units = {name: motion.data[name].attrs["units"] for name in ("sum.gap", "dry.tangential", "stiff.slip")}
    assert units == {"sum.gap": "rad", "dry.tangential": "N m", "stiff.slip": "rad/s"}
    assert fb.plot.contact_forces(motion, "dry").get_ylabel() == "moment on a [N m]"
    texts = [event.text for event in motion.events]
    assert any("impact, normal speed" in text for text in texts)
    assert not any(text.endswith((" m/s", " N")) for text in texts)
    data = fb.sweep(s, {"q1": [0.5, 0.6]}, until=1, outputs=["max(T_dry)", "N_sum"])
    assert data["N_sum"].attrs["units"] == "N m"


def test_a_file_holds_it():
    s, *_ = arm()
    text = toml_text(s)
    again = case_from_text(text).system
    assert toml_text(again) == text
    a, b = (fb.simulate(x, 1, initial={"q1": 1.2, "q2": 0.3}) for x in (s, again))
    assert a["q1"] == pytest.approx(b["q1"], abs=1e-14)


def test_a_batch_is_its_motions():
    s, *_ = arm()
    start = {"q1": [1.2, 1.0], "q2": 0.3}
    data = fb.simulate(s, 1, initial=start, outputs=["q1", "stretched_low.mode"])
    for k, q1 in enumerate(start["q1"]):
        one = fb.simulate(s, 1, initial={"q1": q1, "q2": 0.3})
        assert float(data["q1"][k][-1]) == pytest.approx(one["q1"][-1], abs=1e-12)


def test_a_machine_with_it_is_drawn():
    s, *_ = arm()
    assert "<svg" in fb.draw(s).svg
    diagram = fb.free_body_diagram(s, "b", modes={"stretched_low": "closed", "stiff": "stick"})
    assert "stretched" in diagram.svg


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s, p: s.stop("x", p), "Stop 'x' stops nothing. Give low= or high=, or both."),
        (
            lambda s, p: s.stop("x", p, high=1, stiffness=-5),
            "Expected 0 or more for stiffness= of stop 'x', got -5. A stop pushes its joint back and takes energy; "
            "what pulls or drives is a spring or a force.",
        ),
        (
            lambda s, p: s.stop("x", p, high=1, stiffness=5, damping=-0.5),
            "Expected 0 or more for damping= of stop 'x', got -0.5.",
        ),
        (lambda s, p: s.stop("x", p, low=2, high=1), "Expected low below high for stop 'x', got 2 and 1."),
        (lambda s, p: s.stop("x", p, low=0, restitution=2), "for stop 'x', got 2."),
        (lambda s, p: s.stop("x", p, low=0, damping=1), "Stop 'x' has a damping but no stiffness."),
        (
            lambda s, p: s.stop("x", p, low=0, stiffness=1, restitution=0.5),
            "Stop 'x' has a stiffness and a restitution.",
        ),
        (lambda s, p: s.stop("x", "q1", low=0, stiffness=1), "A compliant stop 'x' is a load on a joint"),
        (lambda s, p: s.stop("x", "q1' + q2", low=0), 'got "q1\' + q2", which depends on q1'),
        (
            lambda s, p: s.stop("x", "abs(q1)", high=1),
            "Expected a displacement without a jump or a bend for stop 'x', got 'abs(q1)': where it bends, the force "
            "of the stop has no direction. Limit each part by a stop of its own: abs(y) to h by low=-h, high=h of y, "
            "max(a, b) by a stop of a and one of b.",
        ),
        (lambda s, p: s.stop("x", 3, low=0), "Expected a joint or an expression of coordinates for stop 'x'"),
        (lambda s, p: s.stop("x", p, low="q2"), "must be constant, but it depends on q2"),
        (lambda s, p: s.stop("dry", p, low=0), "There is already a contact 'dry'"),
        (
            lambda s, p: s.friction("x", p, force=1),
            "Expected torque= for friction 'x', since joint 'shoulder' turns",
        ),
        (lambda s, p: s.friction("x", p), "Expected torque= for friction 'x'"),
        (
            lambda s, p: s.friction("x", p, torque=-1),
            "Expected a friction of 0 or more for friction 'x', got -1.",
        ),
        (lambda s, p: s.friction("x", p, torque=2, static=1), "is 1, below its kinetic friction 2"),
        (
            lambda s, p: s.friction("x", p, coefficient=0.2),
            "Expected radius= for friction 'x', since joint 'shoulder' turns: the radius of its pin",
        ),
        (
            lambda s, p: s.friction("x", p, coefficient=0.2, torque=1),
            "Friction 'x' has a coefficient and a torque. The load of joint 'shoulder' bounds it, or a given one",
        ),
        (
            lambda s, p: s.friction("x", p, torque=1, radius=1),
            "Expected coefficient= for friction 'x', which has a",
        ),
        (
            lambda s, p: s.friction("x", p, coefficient=0.2, radius=0),
            "Expected radius= above 0 m for friction 'x'",
        ),
        (
            lambda s, p: s.friction("x", p, coefficient=0.2, radius=1, length=-1),
            "Expected length= above 0 m for friction 'x', got -1",
        ),
        (
            lambda s, p: s.friction("x", slider(s), coefficient=0.2, radius=1),
            "Friction 'x' has a radius, but joint 'slot' slides. Leave radius= out",
        ),
        (
            lambda s, p: s.friction("x", sleeve(s), coefficient=0.2, radius=1),
            "Friction 'x' has a coefficient, which hinges and sliders have: the load of cylindrical 'sleeve'",
        ),
        (lambda s, p: s.friction("x", p, coefficient=-1, radius=1), "Expected a friction of 0 or more"),
        (lambda s, p: s.friction("x", "shoulder", torque=1), "Expected a joint for friction 'x'"),
        (lambda s, p: s.add("x", fb.Gap()), "has no point, body or joint among its fields"),
    ],
)
def test_what_is_refused(call, message):
    s, shoulder, _ = arm()
    with pytest.raises(fb.FreebodyError, match=re.escape(message)):
        call(s, shoulder)


def test_a_kind_that_says_nothing_is_refused():
    class Nothing(fb.Gap):
        point: fb.Point

    s = fb.System("ball")
    ball = s.body("ball", fb.particle(1))
    s.slider("guide", s.ground, ball, axis="x", coordinate="x")
    s.add("x", Nothing(ball.origin))
    with pytest.raises(fb.FreebodyError, match="its class Nothing has no"):
        fb.simulate(s, 1)
    assert random_state(fb.assemble(s), 0)


def test_tangents_are_counted():
    class Skewed(fb.Gap):
        point: fb.Point
        directions = 2

        def gap(self, at):
            return at.position(self.point)[1]

        def normal(self, at):
            yield fb.PointForce(self.point, (0, 1, 0))

        def tangents(self, at):
            return ((fb.PointForce(self.point, (1, 0, 0)),),)

    s = fb.System("ball")
    ball = s.body("ball", fb.particle(1))
    s.slider("guide", s.ground, ball, axis="x", coordinate="x")
    s.add("x", Skewed(ball.origin, friction=0.2))
    with pytest.raises(fb.FreebodyError, match="its tangents must be 2"):
        fb.simulate(s, 1)
