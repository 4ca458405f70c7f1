"""Armature and rotors of joints: how they are said, in files, and what is refused; their laws: test_armature.py."""

from __future__ import annotations

import pytest

import freebody as fb
from freebody.dynamics import float_state, kinetic_energy, mass_matrix
from freebody.formats.toml.read import case_from_text
from freebody.formats.toml.write import toml_text


def machine():
    """A joint of every type in a row, with armature or a rotor."""
    s = fb.System("row")
    J, n = s.parameters(J=0.25, n=3)
    parent = s.ground
    given = {
        "hinge": {"rotor": fb.Rotor(J, ratio=n), "armature": "J/2"},
        "slider": {"rotor": fb.Rotor(J, ratio=-n, axis=(0, 3, 4))},
        "screw": {"rotor": fb.Rotor(2, axis="x"), "pitch": 0.1},
        "universal": {"armature": (1, "J")},
        "cylindrical": {"armature": 2},
        "planar": {"armature": [1, 2, "n"]},
        "gimbal": {"armature": J},
        "ball": {"armature": n},
        "free": {"armature": (J, 5)},
    }
    for name, arguments in given.items():
        body = s.body(f"of_{name}", fb.box(1, (1, 2, 3)))
        getattr(s, name)(name, parent, body, to=(0, 1, 0), **arguments)
        parent = body
    return s


def test_a_file_keeps_armature_and_rotors():
    s = machine()
    text = toml_text(s)
    again = case_from_text(text).system
    assert toml_text(again) == text
    assert (
        'rotor = { inertia = "J", ratio = "-n", axis = [0, "3/5", "4/5"] }' in text
        or "axis = [0, 0.6, 0.8]" in text
    )
    assert 'armature = [1, 2, "n"]' in text and 'armature = ["J", 5]' in text
    models = [fb.assemble(x) for x in (s, again)]
    q = list(models[0].rest[: models[0].n_q])
    u = [0.1 * (i + 1) for i in range(models[0].n_u)]
    first, second = (float(kinetic_energy(m, float_state(m, q, u))) for m in models)
    assert first == pytest.approx(second, rel=1e-14)


def test_armature_adds_to_the_diagonal_alone():
    def of(**given):
        s = fb.System("row")
        one, two = s.body("one", fb.box(1, (1, 2, 3))), s.body("two", fb.box(1, (1, 2, 3)))
        s.hinge("a", s.ground, one, to=(0, 1, 0), **given)
        s.hinge("b", one, two, at=(1, 1, 0), to=(0, 1, 0))
        model = fb.assemble(s)
        return mass_matrix(model, float_state(model, [0.1, 0.2], [0, 0]))

    (a, b), (_, d) = of(armature=0.5)
    (e, f), (_, g) = of()
    assert a - e == pytest.approx(0.5) and b == f and d == g


def test_a_motor_and_a_rotor_add_up():
    s = fb.System("arm")
    arm = s.body("arm", fb.particle(0))
    pin = s.hinge("pin", s.ground, arm, coordinate="q", rotor=fb.Rotor(2, ratio=3), armature=5)
    s.motor("drive", pin, stall_torque=1, ratio=2, inertia=4)
    assert fb.equations(s).text() == "39*q'' = 2"  # 5 + 2 * 9 + 4 * 4; the arm has no mass of its own


@pytest.mark.parametrize(
    ("joint", "given", "message"),
    [
        (
            "hinge",
            {"armature": -1},
            "Expected a number of at least zero for the armature of hinge 'j', got -1",
        ),
        (
            "hinge",
            {"armature": "t"},
            "The armature of hinge 'j' must be constant, but it depends on t. A clutch",
        ),
        (
            "planar",
            {"armature": (1, 2)},
            "Expected one armature for planar joint 'j', or 3, one a displacement, got",
        ),
        ("free", {"armature": (1, 2, 3)}, "or one for its turning and one for its sliding, got"),
        ("hinge", {"rotor": 3}, "Expected a rotor for hinge 'j', such as fb.Rotor"),
        ("hinge", {"rotor": fb.Rotor(-3)}, "at least zero for the inertia of the rotor of hinge 'j'"),
        (
            "hinge",
            {"rotor": fb.Rotor(1, ratio="sin(t)")},
            "The ratio of the gear of hinge 'j' must be constant",
        ),
        (
            "hinge",
            {"rotor": fb.Rotor(1, axis=(0, 0, 0))},
            "The axis of the rotor of hinge 'j' has length zero",
        ),
    ],
)
def test_refusals(joint, given, message):
    s = fb.System("row")
    body = s.body("body", fb.box(1, (1, 2, 3)))
    with pytest.raises(fb.FreebodyError, match=message.replace("(", "\\(")):
        getattr(s, joint)("j", s.ground, body, **given)
    assert not s.joints


def test_a_joint_that_closes_a_loop_has_none():
    s = fb.System("loop")
    body = s.body("body", fb.box(1, (1, 2, 3)))
    s.hinge("a", s.ground, body)
    with pytest.raises(fb.FreebodyError, match="Hinge 'b' closes a loop .* takes no armature= or rotor="):
        s.hinge("b", s.ground, body, at=(0, 1, 0), to=(0, 1, 0), armature=1)
    closing = s.hinge("b", s.ground, body, at=(0, 0, 1), to=(0, 0, 1))
    s.motor("m", closing, stall_torque=1, inertia=1)
    with pytest.raises(fb.FreebodyError, match="Motor 'm': joint 'b' closes a loop"):
        fb.assemble(s)


def test_a_rotor_turns_with_one_displacement():
    s = fb.System("row")
    body = s.body("body", fb.box(1, (1, 2, 3)))
    joint = s.planar("j", s.ground, body)
    with pytest.raises(fb.FreebodyError, match="The rotor of motor 'm' turns with a single displacement"):
        s.motor("m", joint, stall_torque=1)


def test_a_file_with_a_bad_rotor_is_refused():
    text = toml_text(machine()).replace("axis = [1, 0, 0] }", "axle = 3 }")
    with pytest.raises(fb.FreebodyError, match="joints.screw.rotor.axle: Unknown key 'axle'"):
        case_from_text(text)
