"""Families of contacts in a description: members, names, files, drawings, refusals."""

import copy

import pytest

import freebody as fb


def machine():
    s = fb.System("dice")
    mu = s.parameters(mu=0.4)
    dice = [s.body(f"d{k}", fb.box(1, (1, 1, 1))) for k in range(2)]
    for die in dice:
        s.free(f"air_{die.name}", s.ground, die)
    return s, mu, dice


def test_members_have_names():
    s, mu, (a, b) = machine()
    family = s.contacts(
        "dice", [die.corners(size=(1, 1, 1)) for die in (a, b)], against=s.ground.plane(normal="z")
    )
    s.contacts("balls", [a.sphere(0.5), b.sphere(0.5)], friction=mu, restitution=0.1)
    assert s.families["dice"] is family and repr(family) == "family of contacts 'dice'"
    assert repr(s) == "System 'dice': 2 bodies, 2 joints, 14 coordinates, 2 families of contacts"
    first, second = fb.assemble(s).families
    assert first.label(0, 16) == "dice[d0.1,ground]" and second.label(0, 1) == "balls[d0,d1]"
    assert first.meet(0, 16) and not first.meet(0, 8) and second.meet(0, 1)
    assert first.pair("dice[d1.8,ground]") == (15, 16) and first.pair("dice[d0.1,d1.1]") is None
    assert first.tangents == 2 and copy.copy(s).contacts.system is not s


def test_joined_bodies_and_shapes_of_one_body_do_not_touch():
    s, _, (a, b) = machine()
    c = s.body("c", fb.sphere(1, 1))
    s.hinge("pin", b, c, axis="z", coordinate="q")
    s.contacts("all", [a.sphere(1), b.sphere(1), b.sphere(2), c.sphere(1), s.ground.plane()])
    (family,) = fb.assemble(s).families
    meets = {(i, j) for i in range(5) for j in range(i + 1, 5) if family.meet(i, j)}
    assert meets == {(0, 1), (0, 2), (0, 3), (0, 4), (1, 4), (2, 4), (3, 4)}


def test_bodies_are_held_apart_by_name_in_one_family_and_not_in_another():
    s, _, (a, b) = machine()
    shapes = [a.sphere(1), b.sphere(1), s.ground.plane()]
    s.contacts("one", shapes, apart=[("d0", b)])
    s.contacts("two", [a.sphere(2), b.sphere(2)])
    one, two = fb.assemble(s).families
    assert [one.meet(i, j) for i, j in ((0, 1), (1, 0), (0, 2), (1, 2))] == [False, False, True, True]
    assert two.meet(0, 1)


def test_files_hold_families(tmp_path):
    s, mu, (a, b) = machine()
    s.contacts("dice", [die.corners(size=(1, 1, 1)) for die in (a, b)], against=s.ground.plane(normal="z"))
    s.contacts("balls", [a.sphere(0.5), b.sphere(0.5)], friction=mu, restitution=0.1)
    s.contacts("far", [a.sphere(0.4), b.sphere(0.4), s.ground.plane()], apart=[(a, b)])
    fb.write(s, tmp_path / "dice.toml")
    text = (tmp_path / "dice.toml").read_text()
    again = fb.read(tmp_path / "dice.toml")
    assert fb.assemble(getattr(again, "system", again)).families[1].label(0, 1) == "balls[d0,d1]"
    assert not fb.assemble(again).families[2].meet(0, 1)
    fb.write(getattr(again, "system", again), tmp_path / "again.toml")
    assert (tmp_path / "again.toml").read_text() == text


def test_a_drawing_shows_the_members():
    s, _, (a, b) = machine()
    s.contacts("balls", [a.sphere(0.5), b.sphere(0.5), s.ground.plane(normal="z")])
    assert "<svg" in fb.draw(s).svg


@pytest.mark.parametrize(
    "shapes, options, said",
    [
        (
            lambda a, b, g: [a.sphere(1), a.sphere(1), b.sphere(1)],
            {},
            "every shape of the family of contacts 'x' once",
        ),
        (lambda a, b, g: [a.corners(size=(1, 1, 1)), b.corners(size=(1, 1, 1))], {}, "against=others"),
        (lambda a, b, g: [a.sphere(1), a.sphere(2)], {}, "none of these 2 may touch another one"),
        (lambda a, b, g: [a, b], {}, "got the whole of body 'd0'"),
        (lambda a, b, g: "balls", {}, "Expected a sequence of shapes"),
        (
            lambda a, b, g: [a.sphere(1), b.sphere(1)],
            {"apart": ["d0"]},
            "Expected pairs of bodies for 'apart' of the family of contacts 'x', such as .*, got 'd0'",
        ),
        (
            lambda a, b, g: [a.sphere(1), b.sphere(1)],
            {"apart": 3},
            "'apart' of the family of contacts 'x', such as .*, got 3",
        ),
        (
            lambda a, b, g: [a.sphere(1), b.sphere(1)],
            {"apart": [("d0", "d0")]},
            "Expected two bodies in each pair of 'apart'",
        ),
        (
            lambda a, b, g: [a.sphere(1), b.sphere(1)],
            {"apart": [("d0", "d7")]},
            "Unknown body 'd7' in 'apart' of the family",
        ),
        (lambda a, b, g: [a.sphere(1), 3], {}, "Expected a shape for the family of contacts 'x'"),
        (lambda a, b, g: [a.origin, g.heightline("x")], {}, "A heightline cannot be one of"),
        (lambda a, b, g: [a.sphere(2), g.sphere(1, inside=True)], {}, "does not fit inside"),
        (lambda a, b, g: [a.sphere(1), b.sphere(1)], {"friction": -1}, "Expected a friction of 0 or more"),
        (lambda a, b, g: [a.sphere(1), b.sphere(1)], {"restitution": 2}, "between 0 \\(no bounce\\) and 1"),
    ],
)
def test_what_cannot_be_a_family_is_refused(shapes, options, said):
    s, _, (a, b) = machine()
    with pytest.raises(fb.errors.ModelError, match=said):
        s.contacts("x", shapes(a, b, s.ground), **options)
    assert not s.families


def test_a_name_is_given_once():
    s, _, (a, b) = machine()
    s.contacts("x", [a.sphere(1), b.sphere(1)])
    with pytest.raises(fb.errors.ModelError, match="already a family of contacts 'x'"):
        s.contact("x", a.sphere(1), s.ground.plane())
    other = fb.System("other").body("o", fb.sphere(1, 1))
    with pytest.raises(fb.errors.ModelError, match="belongs to the system 'other'"):
        s.contacts("y", [a.sphere(1), other.sphere(1)])
