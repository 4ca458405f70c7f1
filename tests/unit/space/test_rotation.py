"""Rotations: the group, the twelve Euler sequences against SciPy, quaternions, and the rate maps by differentiation."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation as SciPyRotation

from freebody.errors import ModelError
from freebody.scalar.algebra import apply, floats, multiply, transpose
from freebody.space.entries import expressions
from freebody.space.euler import (
    SEQUENCES,
    euler_from_matrix,
    euler_rate_map,
    euler_rate_map_inverse,
    euler_rates,
    euler_singularity,
    matrix_from_euler,
)
from freebody.space.quaternion import (
    angular_velocity_from_quaternion_rate,
    matrix_from_quaternion,
    quaternion_conjugate,
    quaternion_from_axis_angle,
    quaternion_product,
    quaternion_rate,
    quaternion_rate_map,
)
from freebody.space.rotation import Rotation
from freebody.space.turn import matrix_about

EPS = np.finfo(float).eps
ANGLES = (0.7, 0.4, -1.1)


def random_quaternions(n):
    q = np.random.default_rng(0).normal(size=(n, 4))
    return [tuple(map(float, row)) for row in q / np.linalg.norm(q, axis=1)[:, None]]


def vee(S):
    return np.array([S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]]) / 2


# --- matrices ---------------------------------------------------------------------------------


def test_turn_about_an_exact_axis_is_sparse():
    c, s = sympy.symbols("c s")

    class Recorded(type(expressions)):
        def apply(self, function, *arguments):
            return {"sin": s, "cos": c}[function]

    R = matrix_about((0, 0, 1), sympy.Symbol("a"), Recorded())
    assert ((c, -s, 0), (s, c, 0), (0, 0, 1)) == R
    assert matrix_about((0, -1, 0), sympy.Symbol("a"), Recorded()) == ((c, 0, -s), (0, 1, 0), (s, 0, c))
    assert matrix_about((1, 0, 0), 0.3, floats)[0] == (1, 0, 0)


def test_turn_about_an_oblique_axis_is_rodrigues():
    n = (Fraction(3, 5), 0, Fraction(4, 5))
    R = np.array(matrix_about(n, 0.9, floats), float)
    expected = SciPyRotation.from_rotvec(0.9 * np.array(n, float)).as_matrix()
    assert np.abs(R - expected).max() <= 4 * EPS


def test_exact_symbols_give_exact_matrices():
    R = Rotation.axis_angle("z", sympy.pi / 2)
    assert R.matrix == ((0, -1, 0), (1, 0, 0), (0, 0, 1))
    a = sympy.Symbol("a", real=True)
    S = Rotation.axis_angle((1, 1, 0), a)
    product = sympy.Matrix(S.matrix) * sympy.Matrix(S.inverse.matrix)
    assert product.applyfunc(sympy.simplify) == sympy.eye(3)
    assert S.at({"a": 0.3}).matrix[0][0] == pytest.approx((1 + math.cos(0.3)) / 2, rel=4 * EPS)


def test_group():
    rotations = [Rotation.quaternion(q) for q in random_quaternions(6)]
    for A, B, C in zip(rotations, rotations[1:], rotations[2:], strict=False):
        assert np.abs(np.array((A @ B) @ C) - np.array(A @ (B @ C))).max() <= 8 * EPS
        assert np.abs(np.array(A @ A.inverse) - np.eye(3)).max() <= 8 * EPS
        assert np.abs(np.array((A @ B).inverse) - np.array(B.inverse @ A.inverse)).max() <= 8 * EPS
        assert np.linalg.det(np.array(A)) == pytest.approx(1, abs=8 * EPS)
        v = (0.3, -2.0, 1.1)
        assert (A @ B) @ v == pytest.approx(A @ (B @ v), abs=16 * EPS)
    assert Rotation.identity() @ (1, 2, 3) == (1, 2, 3)


# --- Euler angles -----------------------------------------------------------------------------


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_agrees_with_scipy(sequence):
    for angles in np.random.default_rng(1).uniform(-3, 3, size=(20, 3)):
        R = Rotation.euler(sequence, *map(float, angles))
        expected = SciPyRotation.from_euler(sequence, angles)
        assert np.abs(np.array(R) - expected.as_matrix()).max() <= 8 * EPS
        assert R.as_euler(sequence) == pytest.approx(tuple(expected.as_euler(sequence)), abs=1e-12)
        again = Rotation.euler(sequence, R.as_euler(sequence))
        assert np.abs(np.array(again) - np.array(R)).max() <= 8 * EPS


@pytest.mark.parametrize("sequence", SEQUENCES)
@pytest.mark.parametrize("offset", [0.0, 1e-15, 1e-12, 1e-8, 1e-4])
def test_euler_angles_at_and_near_the_singularity(sequence, offset):
    proper = sequence[0] == sequence[2]
    for singular in (0, math.pi) if proper else (math.pi / 2, -math.pi / 2):
        R = matrix_from_euler(sequence, (0.4, singular + offset, 0.3), floats)
        angles = euler_from_matrix(sequence, R)
        again = matrix_from_euler(sequence, angles, floats)
        assert np.abs(np.array(again, float) - np.array(R, float)).max() <= 32 * EPS
        if offset == 0:
            assert angles[2] == 0  # the convention: the third is zero, the first carries the turn


def test_euler_angles_of_symbols():
    psi, theta, phi = sympy.symbols("psi theta phi", real=True)
    R = Rotation.euler("ZXZ", psi, theta, phi)
    # The spin axis of the gyroscope: (sin θ sin ψ, -sin θ cos ψ, cos θ)
    spin = R @ (0, 0, 1)
    assert spin == (
        sympy.sin(psi) * sympy.sin(theta), -sympy.sin(theta) * sympy.cos(psi), sympy.cos(theta)
    )  # fmt: skip
    assert Rotation.euler("XYZ", 0, sympy.pi, theta).matrix[2] == (0, 0, -1)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_rate_map_by_differentiating_the_matrix(sequence):
    t = sympy.Symbol("t")
    rates = (Fraction(3, 10), Fraction(-7, 10), Fraction(9, 10))
    angles = [sympy.Rational(a).limit_denominator(100) + r * t for a, r in zip(ANGLES, rates, strict=True)]
    R = sympy.Matrix(matrix_from_euler(sequence, angles, expressions))
    Rdot = np.array(R.diff(t).subs(t, 0).evalf(30).tolist(), float)
    R = np.array(R.subs(t, 0).evalf(30).tolist(), float)
    numbers = tuple(map(float, (a.subs(t, 0) for a in angles)))
    for axes, w in (("child", vee(R.T @ Rdot)), ("parent", vee(Rdot @ R.T))):
        J = euler_rate_map(sequence, numbers, floats, axes)
        assert apply(J, tuple(map(float, rates))) == pytest.approx(tuple(w), abs=8 * EPS)
        back = euler_rates(sequence, numbers, tuple(map(float, w)), floats, axes)
        assert back == pytest.approx(tuple(map(float, rates)), abs=32 * EPS)
        inverse = euler_rate_map_inverse(sequence, numbers, floats, axes)
        assert np.abs(np.array(multiply(inverse, J), float) - np.eye(3)).max() <= 32 * EPS


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_determinant_of_the_rate_map_is_the_singularity_measure(sequence):
    J = np.array(euler_rate_map(sequence, ANGLES, floats), float)
    where = euler_singularity(sequence, ANGLES, floats)
    assert (where.angle, where.function) == (1, "sin" if sequence[0] == sequence[2] else "cos")
    assert abs(np.linalg.det(J)) == pytest.approx(abs(where.measure), rel=16 * EPS)


def test_rate_map_of_symbols_is_the_gyroscopes():
    psi, theta, phi = sympy.symbols("psi theta phi", real=True)
    J = euler_rate_map("ZXZ", (psi, theta, phi), expressions)
    s, c = sympy.sin, sympy.cos
    expected = ((s(theta) * s(phi), c(phi), 0), (s(theta) * c(phi), -s(phi), 0), (c(theta), 0, 1))
    assert sympy.Matrix(J).applyfunc(sympy.expand) == sympy.Matrix(expected)


# --- quaternions and axis-angle ---------------------------------------------------------------


def test_quaternions_agree_with_scipy():
    for q in random_quaternions(20):
        expected = SciPyRotation.from_quat([q[1], q[2], q[3], q[0]])
        assert np.abs(np.array(matrix_from_quaternion(q)) - expected.as_matrix()).max() <= 8 * EPS
        assert (
            np.abs(np.array(Rotation.quaternion(q).to_scipy().as_matrix()) - expected.as_matrix()).max()
            <= 8 * EPS
        )
        R = Rotation.from_scipy(expected)
        back = R.as_quaternion()
        assert abs(abs(np.dot(back, q)) - 1) <= 8 * EPS and back[0] >= 0


def test_quaternion_product_is_the_matrix_product():
    for p, q in zip(random_quaternions(10), random_quaternions(10)[::-1], strict=True):
        R = multiply(matrix_from_quaternion(p), matrix_from_quaternion(q))
        assert (
            np.abs(np.array(matrix_from_quaternion(quaternion_product(p, q))) - np.array(R)).max() <= 16 * EPS
        )
        assert quaternion_product(q, quaternion_conjugate(q)) == pytest.approx((1, 0, 0, 0), abs=4 * EPS)
        inverse = matrix_from_quaternion(quaternion_conjugate(q))
        assert np.abs(np.array(inverse) - np.array(transpose(matrix_from_quaternion(q)))).max() <= 4 * EPS


def test_quaternion_from_axis_angle():
    n = (Fraction(2, 3), Fraction(-1, 3), Fraction(2, 3))
    R = matrix_from_quaternion(quaternion_from_axis_angle(n, 1.3, floats))
    assert np.abs(np.array(R, float) - np.array(matrix_about(n, 1.3, floats), float)).max() <= 8 * EPS


def test_quaternion_rate_by_differentiating_the_matrix():
    w = sympy.symbols("w_x w_y w_z", real=True)
    q = sympy.symbols("e0:4", real=True)
    R = sympy.Matrix(matrix_from_quaternion(q))
    rate = quaternion_rate(q, w)
    Rdot = sum((R.diff(e) * r for e, r in zip(q, rate, strict=True)), sympy.zeros(3, 3))
    unit = {q[0] ** 2: 1 - q[1] ** 2 - q[2] ** 2 - q[3] ** 2}
    S = sympy.Matrix([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    # Ṙ = R [ω]× on the unit sphere of q
    difference = (Rdot - R * S).applyfunc(lambda e: sympy.expand(sympy.expand(e).subs(unit)))
    assert difference.applyfunc(
        lambda e: sympy.expand(e.subs(q[0] ** 3, q[0] * unit[q[0] ** 2]))
    ) == sympy.zeros(3, 3)
    assert sympy.expand(sum(e * r for e, r in zip(q, rate, strict=True))) == 0


def test_quaternion_rate_map_and_its_inverse():
    for q in random_quaternions(5):
        w = (0.3, -1.2, 0.8)
        rate = quaternion_rate(q, w)
        by_matrix = [sum(a * b for a, b in zip(row, w, strict=True)) for row in quaternion_rate_map(q)]
        assert rate == pytest.approx(by_matrix, abs=4 * EPS)
        assert angular_velocity_from_quaternion_rate(q, rate) == pytest.approx(w, abs=8 * EPS)


@pytest.mark.parametrize("angle", [1e-9, 0.5, 3.0, math.pi - 1e-9, math.pi])
def test_axis_angle_both_ways(angle):
    n = np.array([1.0, -2.0, 0.5])
    axis, turned = Rotation.axis_angle(tuple(n), angle).as_axis_angle()
    assert turned == pytest.approx(angle, rel=1e-7 if angle < 1e-6 else 8 * EPS)
    assert axis == pytest.approx(tuple(n / np.linalg.norm(n)), abs=1e-7 if angle < 1e-6 else 16 * EPS)


def test_conventions_of_the_inverse_functions():
    assert Rotation.identity().as_axis_angle() == ((1, 0, 0), 0)
    assert Rotation.identity().as_quaternion() == (1, 0, 0, 0)
    # Half turns: all three have w = 0, where the sign is chosen by the next component.
    for axis in ((1, 0, 0), (0, -1, 0), (0, 0, -1), (-1, 1, 0)):
        found, angle = Rotation.axis_angle(axis, math.pi).as_axis_angle()
        assert next(c for c in found if abs(c) > EPS) > 0 and angle == pytest.approx(math.pi)


def test_nearest_mends_rounded_numbers():
    R = Rotation.euler("XYZ", 0.1, 0.2, 0.3)
    rounded = np.round(np.array(R), 4)
    mended = np.array(Rotation.nearest(rounded))
    assert np.abs(mended @ mended.T - np.eye(3)).max() <= 8 * EPS
    assert np.abs(mended - np.array(R)).max() < 1e-4


# --- refusals ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Rotation([[1, 0], [0, 1]]),
            r"Expected rotation matrix with shape \(3, 3\), got .* shape \(2, 2\)",
        ),
        (lambda: Rotation([1, 0, 0]), r"Expected rotation matrix with shape \(3, 3\), got .* shape \(3,\)"),
        (lambda: Rotation(np.diag([1.0, 1, -1])), r"determinant \+1, got -1: it is a rotoreflection"),
        (
            lambda: Rotation(np.diag([1.0, 1, 1.1])),
            r"column 3 has the squared length 1.21, 0.21 from 1.*nearest",
        ),
        (lambda: Rotation([[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]), r"columns 1 and 2 have the dot product 0.1"),
        (lambda: Rotation(sympy.diag(1, 1, sympy.Symbol("a"))), "orthonormal columns, but column 3"),
        (lambda: Rotation.quaternion(0, 0, 0, 0), r"unit quaternion \(w, x, y, z\), got 0"),
        (lambda: Rotation.quaternion(1, 1, 0, 0), "got one of length 1.41421.*normalize=True"),
        (lambda: Rotation.quaternion((1, 0, 0)), r"four components \(w, x, y, z\).*got 3"),
        (
            lambda: Rotation.euler("zxz", 1, 2, 3),
            "capitals, got 'zxz'.*space-fixed.*'ZXZ' with the angles in reverse",
        ),
        (lambda: Rotation.euler("ZZX", 1, 2, 3), "one of the 12 sequences XYZ, .*got 'ZZX'"),
        (lambda: Rotation.euler("ZXZ", 1, 2), "three angles for the sequence ZXZ, got 2"),
        (
            lambda: Rotation.euler("ZXZ", 1, "b)", 3),
            "angle 2 of ZXZ as a number or an expression of parameters: Expected",
        ),
        (lambda: Rotation.axis_angle((0, 0, 0), 1), r"length that is not zero, got \(0, 0, 0\)"),
        (lambda: Rotation.axis_angle("X", 1), "'x', 'y', 'z' or three components, got 'X'"),
        (lambda: Rotation.axis_angle("x", math.nan), "the angle to be finite, got nan"),
        (lambda: Rotation.identity() @ (1, 2), "three components of the vector, got 2 components"),
        (
            lambda: Rotation.axis_angle("x", sympy.Symbol("a")).as_euler("XYZ"),
            r"for as_euler, got symbols \(a\).*\.at",
        ),
        (lambda: Rotation.from_scipy(SciPyRotation.identity(2)), "single SciPy rotation, got a stack of 2"),
        (lambda: Rotation.nearest(np.diag([1.0, 1, -1])), "determinant .1, got -1"),
        (lambda: Rotation.nearest(np.zeros((3, 3))), "near a rotation, got a singular one"),
        (lambda: euler_rate_map("ZXZ", ANGLES, floats, "body"), "'child' or 'parent'.*got 'body'"),
    ],
)
def test_refusals(make, message):
    with pytest.raises(ModelError, match=message):
        make()


def test_quaternion_is_normalised_by_name_only():
    assert Rotation.quaternion(2, 0, 0, 0, normalize=True) == Rotation.identity()
    a = sympy.Symbol("a", real=True)
    R = Rotation.quaternion(sympy.cos(a / 2), 0, 0, sympy.sin(a / 2))
    assert sympy.simplify(R.matrix[0][0] - sympy.cos(a)) == 0


def test_a_text_with_pi_means_the_number():
    assert Rotation.axis_angle("z", "pi/2") == Rotation.axis_angle("z", "90deg")


def test_a_text_holds_functions_of_parameters():
    a, b = sympy.symbols("a b", real=True)
    assert Rotation.axis_angle("z", "2*atan2(a, b)") == Rotation.axis_angle("z", 2 * sympy.atan2(a, b))
