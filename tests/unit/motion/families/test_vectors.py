"""Products of vectors, and components in the axes of a link, against their laws in exact numbers."""

from fractions import Fraction

import numpy as np

from freebody.motion.families.vectors import along, cross, from_axes, in_axes, vector

A, B = [Fraction(3, 7), Fraction(-2), Fraction(5, 3)], [Fraction(1, 2), Fraction(4, 9), Fraction(-7)]
R = [Fraction(x, 3) for x in (1, 2, 2, 2, 1, -2, -2, 2, -1)]
"""A rotation with rational entries, row by row."""


def test_the_cross_product_is_at_right_angles_to_both():
    c = cross.function(*A, *B)
    assert along.function(c, A) == along.function(c, B) == 0
    assert along.function(c, c) == along.function(A, A) * along.function(B, B) - along.function(A, B) ** 2
    assert cross.function(1, 0, 0, 0, 1, 0) == (0, 0, 1)


def test_a_vector_between_two_points():
    assert vector.function(A, B) == tuple(b - a for a, b in zip(A, B, strict=True))


def test_components_in_axes_and_back():
    there = [in_axes.function(R, i, *A) for i in range(3)]
    assert [from_axes.function(R, i, *there) for i in range(3)] == A
    ground = np.array(R).reshape(3, 3) @ np.array(A)
    assert [from_axes.function(R, i, *A) for i in range(3)] == ground.tolist()
