"""The text of every refusal of chains of primitive motions."""

# ruff: noqa: E501 (tables: one case, one line)

from __future__ import annotations

import pytest

import freebody as fb
from freebody.errors import ModelError


@pytest.fixture
def s():
    system = fb.System("leg")
    system.coordinates("q")
    system.body("foot", fb.slender_bar(1, 2))
    return system


def chain(motions, **given):
    return lambda s: s.chain("leg", s.ground, s.bodies["foot"], motions, **given)


CASES = [
    (chain([]), "Expected at least one motion for chain 'leg', such as [fb.Hinge(\"x\"), fb.Hinge(\"y\", at=(0, 0, 1))]. Without motion it is s.weld."),
    (chain("hinge"), "Expected a list of motions for chain 'leg', such as"),
    (chain(fb.Hinge("x")), "Expected a list of motions for chain 'leg', such as"),
    (chain(["hinge"]), "Expected fb.Hinge, fb.Slider, fb.Screw or fb.Ball in chain 'leg', got 'hinge'."),
    (chain([fb.Ball(), fb.Hinge("x")]), "Chain 'leg' has a ball, which makes every turn about its point. Leave out other balls, and turns beside it whose axis goes through that point."),
    (chain([fb.Hinge("x", at=(3, 1, 0)), fb.Ball(at=(0, 1, 0))]), "Chain 'leg' has a ball, which makes every turn about its point. Leave out other balls, and turns beside it whose axis goes through that point."),
    (chain([fb.Ball(), fb.Ball(at=(0, 1, 0))]), "Chain 'leg' has a ball, which makes every turn about its point. Leave out other balls, and turns beside it whose axis goes through that point."),
    (chain([fb.Hinge(k, at=(1, 2, 3)) for k in "xyzx"] + [fb.Ball()]), "Chain 'leg' has 3 turns about different axes and 4 displacements beside them"),
    (chain([fb.Hinge("x", at=("q", 0, 0))]), "The anchor of chain 'leg' is fixed in the joint and cannot depend on q."),
    (chain([fb.Hinge("x"), fb.Hinge("y", rotor=fb.Rotor(1))]), "The rotor of motion 2 of chain 'leg' would stand on the motion before it, which has no body. Put it on the first motion, or give the joint a body there."),
    (chain([fb.Ball(rotor=fb.Rotor(1))]), "The ball in chain 'leg' takes no rotor=. Make the joint by hinges."),
    (chain([fb.Ball(armature=-2)]), "Expected a number of at least zero for the armature of chain 'leg', got -2."),
    (chain([fb.Hinge(k) for k in "xyxy"]), "Chain 'leg' has 4 turns about different axes and 0 displacements beside them; a body has at most three of each. Leave some out."),
    (chain([fb.Hinge("x"), fb.Hinge("-x", at=(2, 0, 0))]), "Motions 1 and 2 of chain 'leg' are the same hinge, so their coordinates cannot be told apart. Leave one out, or give it another anchor."),
    (chain([fb.Slider("x"), fb.Slider("x", at=(0, 1, 0))]), "Motions 1 and 2 of chain 'leg' are the same slider"),
    (chain([fb.Hinge((0, 0, 0))]), "The axis of chain 'leg' has length zero. Give a direction, such as (0, 0, 1)."),
    (chain([fb.Screw("x", pitch="q")]), "The pitch of chain 'leg' must be constant, but it depends on q."),
]  # fmt: skip


@pytest.mark.parametrize(("call", "words"), CASES, ids=range(len(CASES)))
def test_refusals(s, call, words):
    with pytest.raises(ModelError) as error:
        call(s)
    assert words in str(error.value)
    assert not s.joints
    # nothing stays behind: the same names serve the next attempt
    s.chain("leg", s.ground, s.bodies["foot"], [fb.Hinge("x"), fb.Hinge("y")])


def test_a_chain_that_closes_a_loop(s):
    s.hinge("pin", s.ground, s.bodies["foot"])
    with pytest.raises(
        ModelError, match="Chain 'leg' closes a loop, which joints of this type cannot. Open the loop"
    ):
        chain([fb.Hinge("x"), fb.Slider("y")])(s)


def test_a_chain_of_displacements_then_turns_closes_a_loop(s):
    """A pin in a slot: its conditions are those of its motions."""
    s.hinge("pin", s.ground, s.bodies["foot"], coordinate="q")
    chain([fb.Slider("x"), fb.Hinge("z")], at=(1, 1, 0), to=(0, 1, 0))(s)
    closure = fb.assemble(s).constraints["leg"]
    assert [letter for letter, _ in closure.along] == ["y", "z"]
    assert closure.square == (("x", (0, -1, 0), (0, 0, 1)), ("y", (1, 0, 0), (0, 0, 1)))
