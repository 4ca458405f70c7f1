"""Expressions of quantities of contacts in events: what is refused, in the user's names."""

import pytest

import freebody as fb


def machine():
    s = fb.System("ball")
    s.gravity = (0, 0, -9.81)
    body = s.body("ball", fb.box(1, (0.1, 0.1, 0.1)))
    s.free("f", s.ground, body)
    s.contact("floor", body.sphere(0.05), s.ground.plane(normal="z"), friction=0.3)
    s.contacts("pile", [body.box((0.1, 0.1, 0.1)), s.ground.plane(at=(0, 0, -1), normal="z")], friction=0.3)
    return s


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("floor.mode", "Expected a number in event 'e', got the mode of contact 'floor'"),
        ("floor.force - 1", "Unknown quantity 'force' of contact 'floor' in event 'e'; .*normal"),
        ("floor.slip", "is a vector in space: name 'floor.slip.1'"),
        ("floor.slip.3", "Expected a component from 1 to 2 in event 'e', got 'floor.slip.3'"),
        ("floor.gap.1", "Expected 'floor.gap' without a component in event 'e', got 'floor.gap.1'"),
        ("floor.gap - u9", "In event 'e': Expected a known name, got 'u9'"),
        ("flor.gap", "Unknown contact 'flor'"),
        (
            "floor .gap - 0.1",
            "Expected names without blanks in event 'e', got 'floor .gap'. Write 'floor.gap'",
        ),
        ("floor.gap.x", "Expected a component by its number in event 'e', such as '.1', got 'floor.gap.x'"),
        (
            "f.force.x - 1",
            "for event 'e', got 'f.force.x', which is an output of the motion. Write it in these",
        ),
        ("pin.force - 1", "for event 'e', got 'pin.force', which is no name of this machine"),
        (
            "pile[ball,ground].gap",
            r"Expected the normal force of 'pile\[ball,ground\]' in event 'e', got 'gap': solids touch at several",
        ),
    ],
)
def test_what_no_event_watches(text, said):
    with pytest.raises(fb.errors.FreebodyError, match=said) as found:
        fb.simulate(machine(), 1, initial={"f_z": 0.2}, events=[fb.event(text, name="e")])
    assert "contact_1" not in str(found.value)


@pytest.mark.parametrize("when", ["floor.gap - 0.01", fb.event("floor.normal")])
def test_blows_are_not_called_by_them(when):
    kick = fb.blow(when, at="ball", impulse=(0, 0, 1), name="kick")
    with pytest.raises(
        fb.errors.SimulationError, match="for blow 'kick', got 'floor.*a quantity of a contact. End"
    ):
        fb.simulate(machine(), 1, initial={"f_z": 0.2}, impulses=[kick])


def test_blows_are_not_called_by_outputs():
    kick = fb.blow("f.force.x", at="ball", impulse=(0, 0, 1), name="kick")
    with pytest.raises(
        fb.errors.SimulationError, match="speeds and the time for blow 'kick', got 'f.force.x'"
    ):
        fb.simulate(machine(), 1, initial={"f_z": 0.2}, impulses=[kick])


def test_the_approach_is_no_output():
    motion = fb.simulate(machine(), 0.1, initial={"f_z": 0.2})
    with pytest.raises(
        fb.errors.SimulationError, match="approach of contact 'floor' is no output: events watch it"
    ):
        motion["floor.approach"]


def test_time_steps_refuse_them():
    with pytest.raises(
        fb.errors.SimulationError,
        match="which time steps watch, got 'floor.gap', a quantity of a contact.*an output",
    ):
        fb.simulate(
            machine(), 1, initial={"f_z": 0.2}, events=["floor.gap"], method="timestepping", step=0.01
        )


def test_an_expression_without_a_value_at_the_start_is_refused():
    with pytest.raises(
        fb.errors.SimulationError, match="expected a number for event 'e' at t = 0 s.*force or slip"
    ):
        fb.simulate(machine(), 1, initial={"f_z": 0.2}, events=[fb.event("1/floor.normal", name="e")])
