"""The modes in which a motion with contacts starts: as the motion has them, without it, and said with the equations."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest
from click.testing import CliRunner

import freebody as fb
from freebody.cli import command
from freebody.errors import ModelError
from freebody.gallery import entries
from freebody.motion.contact.starting_modes import starting_modes
from freebody.picture.free_body.free_body_diagram import free_body_diagram

STARTS = "the modes in which the motion starts; modes= chooses others"
GALLERY = entries()
FAST = ["ex-6-1", "ex-6-4", "prob-6-7"]


LENGTHS = {"m": 2.0, "R": 0.2, "g": 9.81, "mu": 0.3, "F": 0.0}


def disk(given=True):
    """On a floor, pushed by F; with or without values of its parameters."""
    s = fb.System("disk")
    m, R, g, mu, F = s.parameters(**LENGTHS) if given else s.parameters("m R g mu F")
    s.gravity = (0, -g, 0)
    body = s.body("disk", fb.disk(m, R))
    s.planar("p", s.ground, body, coordinate="x y f")
    s.force("F", body, (F, 0, 0))
    s.contact("floor", body.circle(R), s.ground.plane(normal="y"), friction=mu)
    return s


def first_modes(motion):
    found = {}
    for change in motion.modes:
        found.setdefault(change.contact, change.mode)
    return found


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in FAST else pytest.mark.slow) for name in GALLERY]
)
def test_the_gallery_starts_in_the_modes_of_its_motion(name):
    entry = GALLERY[name]
    s = entry.build()
    if not s.contacts:
        pytest.skip("it touches nothing")
    motion = fb.simulate(s, 1e-6, initial=entry.start)
    assert starting_modes(s, entry.start, entry.near) == first_modes(motion)


def test_a_disk_starts_as_its_motion_does():
    """Rolling, slip of both senses, flight, and an impact, at random; the kernels are those of one machine."""
    s, rng = disk(), np.random.default_rng(4)
    seen = set()
    for k in range(40):
        initial = {"y": 0.2 + (k % 5 == 4) * 0.1, "x'": rng.choice([0, 1, -1]), "f'": rng.choice([0, 5, -5])}
        initial["y'"] = -(k % 7 == 6)
        values = {"F": float(rng.choice([0, 4, 40])), "mu": float(rng.choice([0, 0.3]))}
        found = starting_modes(s, initial, values=values)
        assert found == first_modes(fb.simulate(s, 1e-6, initial=initial, values=values))
        seen.add(found["floor"])
    assert seen == {"open", "stick", "slip", "slip+", "slip-"}


def test_nothing_is_compiled(monkeypatch):
    def never(*_, **__):
        raise AssertionError

    monkeypatch.setattr(import_module("freebody.motion.kernels.kernels"), "compile_tape", never)
    for name in FAST:
        entry = GALLERY[name]
        assert fb.equations(entry.build(), initial=entry.start).chosen == STARTS


def test_the_equations_are_those_of_the_start_and_say_so():
    s = disk()
    rolling = fb.equations(s, initial={"y": 0.2})
    assert rolling.text().splitlines()[0] == f"Contacts: floor stick ({STARTS})"
    assert rolling.lines() == fb.equations(s, modes={"floor": "stick"}).text().splitlines()
    assert rolling.free_body("disk").text().startswith(f"Contacts: floor stick ({STARTS})\nFree body 'disk'")
    for product in (rolling, rolling.free_body("disk")):
        assert "Contacts: floor stick" in product.latex().splitlines()[1]
        assert "Contacts: floor stick" in product.html()
    slips = fb.equations(s, initial={"y": 0.2}, values={"F": 40})
    assert "floor slip+" in slips.text() and "N_floor" in slips.text()
    assert "floor open" in fb.equations(s, initial={"y": 0.3}).text()
    chosen = fb.equations(s, modes={"floor": "stick"})
    assert not chosen.heading and "Contacts" not in chosen.text()


@pytest.mark.parametrize(
    ("values", "initial", "why"),
    [
        ({"R": 0.2, "g": 9.81, "F": 0}, {"y": 0.2}, "No value for parameters m, mu."),
        (LENGTHS, {}, "has contact 'floor' 0.2 m deep."),
        ({**LENGTHS, "mu": -1}, {"y": 0.2}, "Expected a friction of contact 'floor' of at least 0, got -1."),
    ],
)
def test_a_start_that_does_not_decide_is_said(values, initial, why):
    line = fb.equations(disk(given=False), initial=initial, values=values).text().splitlines()[0]
    assert line.startswith("Contacts: floor open (the start does not decide the modes, modes= chooses them: ")
    assert why in line


def test_legs_that_share_a_weight_with_friction_decide_by_equal_compliance():
    """Sliding feet of unequal friction on one line of action more than the motion determines."""
    s = fb.System("table")
    m, g = s.parameters(m=1, g=9.81)
    s.gravity = (0, -g, 0)
    box = s.body("box", fb.box(m, (2, 1, 1)))
    s.planar("p", s.ground, box, coordinate="x y f")
    floor = s.ground.plane(normal="y")
    for k, (x, mu) in enumerate(((-1, 0.1), (0, 0.5), (1, 0.3))):
        s.contact(f"foot_{k}", box.point(x, "-1/2", 0), floor, friction=mu)
    line = fb.equations(s, initial={"y": 0.5, "x'": 1}).text().splitlines()[0]
    assert line.startswith("Contacts: foot_0 slip+, foot_1 slip+, foot_2 slip+")


def test_a_start_that_nothing_is_done_with_is_refused():
    with pytest.raises(
        ModelError, match="Expected no initial= for equations: modes= says what the contacts do"
    ):
        fb.equations(disk(), modes={"floor": "stick"}, initial={"y": 0.2})
    s = fb.System("free")
    s.planar("p", s.ground, s.body("b", fb.disk(1, 1)), coordinate="x y f")
    with pytest.raises(
        ModelError, match="Expected no values= for equations: without contacts no start is needed"
    ):
        fb.equations(s, values={})
    with pytest.raises(ModelError, match="Expected no initial= for 'free', which has no contacts"):
        free_body_diagram(s, "b", initial={})
    with pytest.raises(ModelError, match="Expected no initial= with modes="):
        free_body_diagram(disk(), "disk", initial={}, modes={})


def symbols(drawing):
    return {part.split('"')[0] for part in drawing.svg.split('data-symbol="')[1:]}


def test_a_diagram_has_its_contacts():
    s = disk()
    assert {"N_floor", "T_floor"} <= symbols(free_body_diagram(s, "disk"))
    assert {"N_floor", "mu*N_floor"} <= symbols(free_body_diagram(s, "disk", initial={"y": 0.2, "x'": 1}))
    assert not symbols(free_body_diagram(s, "disk", initial={"y": 1})) & {"N_floor", "T_floor"}
    drawn = free_body_diagram(s, "disk", at={"y": 0.2})
    assert {"N_floor", "T_floor"} <= symbols(drawn) and "starts from rest as it is drawn" in drawn.svg
    assert {"N_O", "T_O"} <= symbols(free_body_diagram(GALLERY["prob-6-9"].build(), "bar"))


def test_the_commands_take_the_start():
    run = CliRunner().invoke
    for arguments in (
        ["equations", "ex-6-4"],
        ["equations", "ex-6-4", "--body", "disk"],
        ["analyze", "ex-6-4"],
    ):
        found = run(command, arguments)
        assert found.exit_code == 0 and f"Contacts: slope stick ({STARTS})" in found.output, found.output
        assert "N_slope" in found.output
    chosen = run(command, ["equations", "ex-6-4", "--mode", "slope=open"]).output
    assert "Contacts" not in chosen and "N_slope" not in chosen
