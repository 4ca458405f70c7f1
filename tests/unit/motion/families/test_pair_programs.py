"""Programs of pairs of shapes: a program serves all sizes, and closed forms of its results."""

import numpy as np

import freebody as fb
from freebody.motion.families.family_record import TOUCH
from freebody.motion.families.pair_programs import chosen, numbers_of, pair_program
from freebody.motion.ode.dense_output import observe

LEVEL = [1, 0, 0, 0, 1, 0, 0, 0, 1]


def touch(first, second, given, planar=None):
    """Return the outputs of a program."""
    program = pair_program(first, second, planar)
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
    assert chosen("bowl", "sphere") == ("sphere", "bowl", True)
    assert chosen("sphere", "bowl") == ("sphere", "bowl", False)


def test_a_plane_gives_the_tangents():
    numbers = [0, 0, 0.2, 0, 0, 1, 1, 0, 0, 0, 1, 0]
    got = touch("point", "plane", [*LEVEL, 1, 2, 3, *LEVEL, 0, 0, 0, 0, 0, 0, *numbers])
    np.testing.assert_allclose(got[[0, 3, 10, 14]], [2.8, 1, 1, 1])
    assert pair_program("point", "plane", None).defined
    assert not pair_program("sphere", "sphere", None).defined
    assert pair_program("point", "segment", (0, 0, 1)).reaches == 2


def test_one_program_serves_all_sizes():
    assert pair_program("sphere", "sphere", None) is pair_program("sphere", "sphere", None)
    s = fb.System("one")
    body = s.body("b", fb.sphere(1, 1))
    assert numbers_of(body.sphere(2, at=(1, 2, 3)), "sphere", (10, 20, 30)) == [11, 22, 33, 2]
    assert numbers_of(body.point(1, 2, 3), "end", (0, 0, 0)) == [1, 2, 3]
