"""What no body can have, and the words it is refused with: which test failed, and by how much."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

from freebody.errors import MassError, ModelError
from freebody.space.mass import MassProperties
from freebody.space.solids import box, disk, particle, slender_bar, tube

m, r, I1, I2 = sympy.symbols("m r I1 I2", real=True)
O = (0, 0, 0)  # noqa: E741


def body(*moments, products=(0, 0, 0), mass=1):
    return MassProperties.from_products(mass, O, moments, products)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: MassProperties(-2, O, np.zeros((3, 3))), "a mass that is not negative, got -2 kg"),
        (lambda: body(1, -0.5, 1), "moments of inertia that are not negative, got -0.5 about y"),
        (
            lambda: body(1, 1, 3),
            r"about x, y, z that satisfy the triangle inequality, got \(1, 1, 3\): "
            r"no body has 3 > 1 \+ 1, too large by 1\. "
            "Check the unit, the order of the axes, and that the inertia is about the mass centre",
        ),
        (
            lambda: body(1, 1, 1, products=(2, 0, 0)),
            r"principal moments of inertia that are not negative, got \(-1, 1, 3\)",
        ),
        (
            lambda: body(2, 2, 2, products=(-1, -1, -1)),
            r"principal moments of inertia that satisfy the triangle inequality, got \(1, 1, 4\): "
            r"no body has 4 > 1 \+ 1, "
            "too large by 2",
        ),
        (
            lambda: MassProperties(1, O, [[2, 0.5, 0], [0.4, 2, 0], [0, 0, 2]]),
            r"a symmetric inertia matrix, got 0\.5 at \(1, 2\) and 0\.4 at \(2, 1\), a difference of 0\.1",
        ),
        (
            lambda: MassProperties(1, O, [[2, m, 0], [r, 2, 0], [0, 0, 2]]),
            r"symmetric inertia matrix, got m at \(1, 2\) and r",
        ),
        (
            lambda: MassProperties(1, O, (1, 1, 1)),
            r"inertia matrix with shape \(3, 3\), got an array with shape \(3,\)",
        ),
        (
            lambda: MassProperties(1, O, np.eye(2)),
            r"inertia matrix with shape \(3, 3\), got an array with shape \(2, 2\)",
        ),
        (
            lambda: MassProperties(1, O, [[1, 0, 0], [0, 1], [0, 0, 1]]),
            "inertia matrix with shape .* rows of different lengths",
        ),
        (lambda: MassProperties(1, O, 3), r"inertia matrix with shape \(3, 3\), got 3"),
        (
            lambda: MassProperties(1, (0, 0), np.eye(3)),
            "three components of the mass centre, got 2 components",
        ),
        (
            lambda: MassProperties(1, O, np.diag([1, 1, np.nan])),
            r"entry \(3, 3\) of the inertia matrix to be finite, got nan",
        ),
        (lambda: MassProperties(1, "abc", np.eye(3)), "three components of the mass centre, got 'abc'"),
        (
            lambda: MassProperties("m +", O, np.eye(3)),
            "the mass as a number or an expression of parameters: Expected",
        ),
        (lambda: MassProperties(sympy.I, O, np.eye(3)), "a mass that is a real number, got I"),
        (lambda: MassProperties([1], O, np.eye(3)), r"the mass as a number or a SymPy expression, got \[1\]"),
        (lambda: body(1, 2), "three components of the moments of inertia, got 2 components"),
        (lambda: particle(0).radius_of_gyration("x"), "a body with mass, got mass 0"),
        (
            lambda: disk(1, 1) - disk(2, 1),
            "a hole lighter than the body, got a hole of mass 2 in a body of mass 1",
        ),
        (
            lambda: box(3, (1, 2, 3)) - particle(1).moved((0, 5, 0)),
            "a hole inside the body, got a remainder that no body can have: Expected moments .* "
            "got -[0-9.]+ about .* Move the hole",
        ),
    ],
)
def test_numbers(make, message):
    with pytest.raises(MassError, match=message):
        make()


def test_what_is_decidable_with_symbols_is_refused_at_once():
    with pytest.raises(MassError, match="not negative, got -1 about z"):
        body(I1, I2, -1)
    with pytest.raises(
        MassError,
        match=r"triangle inequality, got \(I1, I1 \+ 2, 1\): I1 \+ 2 exceeds \(1\) \+ \(I1\) by 1\.",
    ):
        body(I1, I1 + 2, 1)
    assert body(I1, I1, 0.5).moments[0] == I1


def test_the_rest_is_checked_with_numbers():
    properties = body(I1, I1, I2, mass=m)
    properties.check({"m": 1, "I1": 1, "I2": 2})
    with pytest.raises(MassError, match=r"got \(1, 1, 2\.5\): no body has 2\.5 > 1 \+ 1, too large by 0\.5"):
        properties.check({"m": 1, "I1": 1, "I2": 2.5})
    with pytest.raises(MassError, match="mass that is not negative, got -1 kg"):
        properties.check({m: -1, I1: 1, I2: 1})
    with pytest.raises(MassError, match="a value of every symbol of the mass properties, got none of I2, m"):
        properties.check({"I1": 1})
    with pytest.raises(MassError, match="too large by 0.5"):
        properties.at({"m": 1, "I1": 1, "I2": 2.5})


def test_dimensions_are_checked_with_numbers():
    bar = slender_bar(m, 2 * r)
    bar.check({"m": 1, "r": 1})
    with pytest.raises(
        MassError, match=r"2\*r not to be negative \(the mass or a length of a solid\), got -2\. Check the"
    ):
        bar.check({"m": 1, "r": -1})
    a, b = sympy.symbols("a b", real=True)
    with pytest.raises(MassError, match=r"-a \+ b not to be negative"):
        tube(1, a, b, 1).at({"a": 2, "b": 1})


def test_symbols_off_the_diagonal_have_no_principal_axes():
    with pytest.raises(MassError, match=r"symbols off the diagonal.*\.at\(\{\.\.\.\}\)\.principal\(\)"):
        body(I1, I1, I1, products=(I2, 0, 0)).principal()


def test_flat_bodies_on_the_bound_are_bodies_also_after_rounding():
    # A thin disk has I_z = I_x + I_y; round-off must not make it impossible.
    for angle in np.linspace(0, 3, 31):
        turned = disk(0.3, 0.7).rotated(np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)],
                                                  [0, np.sin(angle), np.cos(angle)]]))  # fmt: skip
        again = MassProperties(turned.mass, turned.center, turned.inertia)
        # m R²/4 twice, m R²/2 about the normal, which is turned by the angle
        assert sorted(again.principal().moments) == pytest.approx(
            [0.3 * 0.49 / 4] * 2 + [0.3 * 0.49 / 2], rel=1e-14
        )
        normal = np.array([0, -np.sin(angle), np.cos(angle)])
        assert normal @ np.array(again.inertia, float) @ normal == pytest.approx(0.3 * 0.49 / 2, rel=1e-14)


def test_a_hair_too_much_is_refused():
    with pytest.raises(MassError, match="too large by 1e-13"):
        body(1, 1, 2 + sympy.Rational(1, 10**13))


def test_mass_errors_are_model_errors():
    assert issubclass(MassError, ModelError) and issubclass(ModelError, ValueError)


def test_only_mass_properties_are_added():
    with pytest.raises(TypeError):
        disk(1, 1) + 2
    with pytest.raises(TypeError):
        disk(1, 1) - 2
