"""Programs of pairs of shapes: a program serves all sizes, and closed forms of its results."""

import numpy as np

import freebody as fb
from freebody.describe.shapes.point import Spot
from freebody.model.family import turned
from freebody.motion.families.family_record import TOUCH
from freebody.motion.families.pair_programs import numbers_of, pair_program
from freebody.motion.ode.dense_output import observe

MACHINE = fb.System("shapes")
BODY = MACHINE.body("b", fb.sphere(1, 1))
SHAPES = {
    "point": Spot(BODY, (0, 0, 0)),
    "sphere": BODY.sphere(1),
    "bowl": BODY.sphere(1, inside=True),
    "plane": BODY.plane(),
    "segment": BODY.segment((0, 0, 0), (1, 0, 0), normal="y"),
}
LEVEL = [1, 0, 0, 0, 1, 0, 0, 0, 1]


def touch(first, second, given, planar=None):
    """Return the outputs of a program."""
    program = pair_program(SHAPES[first], SHAPES[second], planar)
    y = np.array([[float(x) for x in given]])
    outputs = program.compiled["touch"].outputs
    assert outputs <= TOUCH
    return observe(program.address, outputs, np.zeros(1), y, np.zeros(1))[0]


def test_two_spheres_touch_on_the_line_of_their_centres():
    got = touch("sphere", "sphere", [*LEVEL, 0, 0, 3, *LEVEL, 0, 4, 0, 0, 0, 0, 1, 0, 0, 0, 1.5])
    np.testing.assert_allclose(got[:10], [2.5, 0, -0.8, 0.6, 0, 0.8, 2.4, 0, 2.8, 0.9], atol=1e-15)


def test_a_sphere_in_a_bowl():
    got = touch("sphere", "bowl", [*LEVEL, 0, 0, -1, *LEVEL, 0, 0, 0, 0, 0, 0, 0.5, 0, 0, 0, 2])
    np.testing.assert_allclose(got[:7], [0.5, 0, 0, 1, 0, 0, -1.5], atol=1e-15)
    assert turned(SHAPES["bowl"], SHAPES["sphere"]) and not turned(SHAPES["sphere"], SHAPES["bowl"])


def test_a_plane_gives_the_tangents():
    numbers = [0, 0, 0.2, 0, 0, 1, 1, 0, 0, 0, 1, 0]
    got = touch("point", "plane", [*LEVEL, 1, 2, 3, *LEVEL, 0, 0, 0, 0, 0, 0, *numbers])
    np.testing.assert_allclose(got[[0, 3, 10, 14]], [2.8, 1, 1, 1])
    assert pair_program(SHAPES["point"], SHAPES["plane"], None).defined
    assert not pair_program(SHAPES["sphere"], SHAPES["sphere"], None).defined
    assert pair_program(SHAPES["point"], SHAPES["segment"], (0, 0, 1)).reaches == 2


def test_one_program_serves_all_sizes():
    assert pair_program(SHAPES["sphere"], SHAPES["sphere"], None) is pair_program(
        SHAPES["sphere"], SHAPES["sphere"], None
    )
    s = fb.System("one")
    body = s.body("b", fb.sphere(1, 1))
    assert numbers_of(body.sphere(2, at=(1, 2, 3)), (10, 20, 30)) == [11, 22, 33, 2]
    assert numbers_of(Spot(body, (1, 2, 3)), (0, 0, 0)) == [1, 2, 3]
