"""Poses: composition, inverse, points and vectors."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

from freebody.errors import ModelError
from freebody.space.pose import Pose, compose, invert
from freebody.space.rotation import Rotation

EPS = np.finfo(float).eps

X_AB = Pose(Rotation.euler("ZYX", 0.3, -0.4, 1.2), (1, 2, 3))
X_BC = Pose(Rotation.euler("XYX", -1.0, 0.2, 0.5), (-0.5, 0.1, 0.9))


def homogeneous(X):
    H = np.eye(4)
    H[:3, :3], H[:3, 3] = np.array(X.rotation), X.position
    return H


def test_composition_is_that_of_homogeneous_matrices():
    assert np.abs(homogeneous(X_AB @ X_BC) - homogeneous(X_AB) @ homogeneous(X_BC)).max() <= 8 * EPS


def test_inverse():
    assert np.abs(homogeneous(X_AB @ X_AB.inverse) - np.eye(4)).max() <= 8 * EPS
    assert np.abs(homogeneous(X_AB.inverse @ X_AB) - np.eye(4)).max() <= 8 * EPS


def test_points_move_and_vectors_only_turn():
    p = (0.2, -0.7, 0.4)
    assert X_AB.point(p) == pytest.approx(tuple((homogeneous(X_AB) @ [*p, 1])[:3]), abs=8 * EPS)
    assert X_AB.vector(p) == pytest.approx(tuple((homogeneous(X_AB) @ [*p, 0])[:3]), abs=8 * EPS)
    assert (X_AB @ X_BC).point(p) == pytest.approx(X_AB.point(X_BC.point(p)), abs=16 * EPS)


def test_symbols():
    a, x = sympy.symbols("a x", real=True)
    X = Pose(Rotation.axis_angle("z", a), (x, 0, 0))
    assert X.point((1, 0, 0)) == (x + sympy.cos(a), sympy.sin(a), 0)
    assert X.at({"a": 0, x: 2}).point((1, 0, 0)) == (3, 0, 0)


def test_functions_of_plain_tuples():
    raw = (X_AB.rotation.matrix, X_AB.position)
    R, p = compose(raw, invert(raw))
    assert np.abs(np.array(R) - np.eye(3)).max() <= 8 * EPS and p == pytest.approx((0, 0, 0), abs=8 * EPS)


def test_refusals():
    with pytest.raises(ModelError, match=r"three components of the position, got 2 components"):
        Pose(Rotation.identity(), (1, 2))
    with pytest.raises(
        ModelError, match=r"a pose on the right of @, got \(1, 2, 3\).*\.point\(p\) for a point"
    ):
        X_AB @ (1, 2, 3)
    with pytest.raises(ModelError, match="rotation matrix with shape"):
        Pose([1, 2, 3])
