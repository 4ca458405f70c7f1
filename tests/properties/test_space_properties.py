"""Laws of space and mass on whatever Hypothesis finds, and the same formulas for every scalar type."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy
from hypothesis import example, given, settings
from hypothesis import strategies as st

from freebody.errors import MassError
from freebody.scalar.algebra import floats, multiply, transpose
from freebody.space.euler import SEQUENCES, euler_from_matrix, euler_rate_map, euler_rates, matrix_from_euler
from freebody.space.mass import MassProperties
from freebody.space.quaternion import matrix_from_quaternion, quaternion_from_matrix
from freebody.space.rotation import Rotation
from freebody.space.solids import particle

EPS = np.finfo(float).eps
few = settings(max_examples=60)

angle = st.floats(-10, 10)
component = st.floats(-3, 3).map(lambda x: round(x, 3))
point = st.tuples(component, component, component)
cloud = st.lists(st.tuples(st.integers(1, 9), point), min_size=1, max_size=5)
quaternion = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .filter(lambda q: math.hypot(*q) > 1 / 10)
    .map(lambda q: tuple(c / math.hypot(*q) for c in q))
)


def body_of(masses):
    """A body of point masses: what it has, a body can have."""
    total = particle(0)
    for m, p in masses:
        total = total + particle(m).moved(p)
    return total


def array(A):
    return np.array(A, float)


@few
@given(q=quaternion)
@example(q=(2.220446049250313e-16, 0.0, 0.0, -1.0))
def test_quaternion_and_matrix(q):
    R = matrix_from_quaternion(q)
    assert np.abs(array(multiply(R, transpose(R))) - np.eye(3)).max() <= 16 * EPS
    back = quaternion_from_matrix(R)
    assert min(math.dist(back, q), math.dist(back, [-c for c in q])) <= 16 * EPS
    axis, turned = Rotation.quaternion(q).as_axis_angle()
    assert 0 <= turned <= math.pi
    assert np.abs(array(Rotation.axis_angle(axis, turned)) - array(R)).max() <= 32 * EPS


@few
@given(sequence=st.sampled_from(SEQUENCES), angles=st.tuples(angle, angle, angle))
def test_euler_angles_give_the_matrix_back(sequence, angles):
    R = matrix_from_euler(sequence, angles, floats)
    again = matrix_from_euler(sequence, euler_from_matrix(sequence, R), floats)
    assert np.abs(array(again) - array(R)).max() <= 32 * EPS


@few
@given(masses=cloud)
def test_what_a_body_has_is_accepted(masses):
    body = body_of(masses)
    MassProperties(body.mass, body.center, body.inertia)  # checked again; nothing raised
    total = sum(m for m, _ in masses)
    assert body.mass == total
    center = sum(m * array(p) for m, p in masses) / total
    assert array(body.center) == pytest.approx(center, abs=1e-14)
    for p in ((0, 0, 0), (1, -2, 0.5)):
        d = [array(at) - array(p) for _, at in masses]
        expected = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for (m, _), r in zip(masses, d, strict=True))
        assert array(body.about(p)) == pytest.approx(expected, abs=1e-11)


@few
@given(masses=cloud, q=quaternion)
def test_principal_moments_do_not_turn(masses, q):
    body = body_of(masses)
    R = Rotation.quaternion(q)
    moments, axes = body.principal()
    assert moments[0] <= moments[1] <= moments[2]
    assert float(moments[2]) <= float(moments[0] + moments[1]) * (1 + 1e-12) + 1e-12
    turned = body.rotated(R)
    scale = max(1, float(moments[2]))
    assert array(turned.principal().moments) == pytest.approx(array(moments), abs=64 * EPS * scale)
    D = array(axes).T @ array(body.inertia) @ array(axes)
    assert np.abs(D - np.diag(array(moments))).max() <= 64 * EPS * scale
    assert np.linalg.det(array(axes)) == pytest.approx(1, abs=1e-12)


@few
@given(masses=cloud, others=cloud)
def test_combination_is_undone_by_subtraction(masses, others):
    a, b = body_of(masses), body_of(others)
    assert (a + b) - b == a
    assert a + b == b + a


@few
@given(moments=st.tuples(*[st.integers(0, 50)] * 3), q=quaternion)
def test_triangle_inequality_decides(moments, q):
    """A diagonal inertia, turned anyhow, is refused just when one moment exceeds the sum of the other two."""
    R = array(Rotation.quaternion(q))
    turned = R @ np.diag([float(x) for x in moments]) @ R.T
    excess = 2 * max(moments) - sum(moments)
    if excess > 0:
        with pytest.raises(MassError, match="triangle inequality|not negative"):
            MassProperties(1, (0, 0, 0), turned)
    elif excess < 0:
        assert array(MassProperties(1, (0, 0, 0), turned).inertia) == pytest.approx(turned, abs=1e-12)


# --- one formula, every scalar ----------------------------------------------------------------

VALUES = {"a": 0.3, "b": 0.9, "c": -0.6, "x": 0.2, "y": -0.4, "z": 1.1}


def traced():
    from freebody.scalar.trace import Tape

    tape = Tape()
    inputs = {name: tape.input(name) for name in VALUES}
    return tape, inputs, lambda outputs: tape.evaluate(outputs, VALUES)


def polynomial():
    from freebody.scalar.ring import Ring

    ring = Ring()
    symbols = {name: sympy.Symbol(name, real=True) for name in VALUES}
    at = {symbols[name]: sympy.Float(value, 30) for name, value in VALUES.items()}
    inputs = {name: ring.generator(symbol, "coordinate") for name, symbol in symbols.items()}
    return (
        ring,
        inputs,
        lambda outputs: [float(sympy.sympify(ring.to_sympy(x)).evalf(25, subs=at)) for x in outputs],
    )


@pytest.mark.parametrize("kind", [traced, polynomial])
@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_formulas_for_every_scalar(kind, sequence):
    field, given_, evaluate = kind()
    angles, w = tuple(given_[k] for k in "abc"), tuple(given_[k] for k in "xyz")
    numbers, w_numbers = tuple(VALUES[k] for k in "abc"), tuple(VALUES[k] for k in "xyz")
    for found, expected in (
        (matrix_from_euler(sequence, angles, field), matrix_from_euler(sequence, numbers, floats)),
        (euler_rate_map(sequence, angles, field), euler_rate_map(sequence, numbers, floats)),
        ((euler_rates(sequence, angles, w, field),), (euler_rates(sequence, numbers, w_numbers, floats),)),
    ):
        flat = evaluate([x for row in found for x in row])
        assert flat == pytest.approx([float(x) for row in expected for x in row], abs=16 * EPS)


@pytest.mark.parametrize("kind", [traced, polynomial])
def test_quaternion_formulas_for_every_scalar(kind):
    from freebody.space.quaternion import (
        angular_velocity_from_quaternion_rate,
        quaternion_from_axis_angle,
        quaternion_product,
        quaternion_rate,
    )

    def formulas(field, v):
        p = quaternion_from_axis_angle((0, 0, 1), v["a"], field)
        q = (v["b"], v["c"], v["x"], v["y"])
        w = (v["x"], v["y"], v["z"])
        rate = quaternion_rate(q, w)
        return [*quaternion_product(p, q), *rate, *angular_velocity_from_quaternion_rate(q, rate), *p] + [
            x for row in matrix_from_quaternion(q) for x in row
        ]

    field, given_, evaluate = kind()
    assert evaluate(formulas(field, given_)) == pytest.approx(
        list(map(float, formulas(floats, VALUES))), abs=16 * EPS
    )


def test_canonical_polynomials_make_a_rotation_exactly_orthonormal():
    field, given_, _ = polynomial()
    R = matrix_from_euler("ZXZ", tuple(given_[k] for k in "abc"), field)
    product = multiply(R, transpose(R))
    assert all(product[i][j] == (1 if i == j else 0) for i in range(3) for j in range(3))
