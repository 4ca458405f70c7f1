"""Mass properties: the theorems of translation, rotation and combination, principal axes, products."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy

from freebody.space.mass import MassProperties, Products
from freebody.space.rotation import Rotation
from freebody.space.solids import box, cylinder, disk, particle, plate, slender_bar, sphere, tube

m, a, b, c, l = sympy.symbols("m a b c l", real=True)  # noqa: E741
half = Fraction(1, 2)

BODY = MassProperties(2, (half, -1, 3), ((4, Fraction(-1, 3), half), (Fraction(-1, 3), 5, 1), (half, 1, 6)))


def array(A):
    return np.array(A, float)


def zero(difference):
    return all(sympy.simplify(x) == 0 for x in sympy.Matrix(difference))


# --- translation ------------------------------------------------------------------------------


def test_parallel_axes():
    d = array(BODY.center) - [1, 2, 3]
    expected = array(BODY.inertia) + 2 * (d @ d * np.eye(3) - np.outer(d, d))
    assert np.array_equal(array(BODY.about((1, 2, 3))), expected)
    assert BODY.about(BODY.center) == BODY.inertia


def test_bar_about_its_end():
    bar = slender_bar(m, l, axis="y")
    assert bar.about((0, -l / 2, 0))[2][2] == l**2 * m / 3
    assert bar.moved((0, l / 2, 0)).about((0, 0, 0))[0][0] == l**2 * m / 3


def test_inertia_about_a_point_and_back():
    again = MassProperties.from_inertia_about(2, BODY.center, BODY.about((1, 2, 3)), (1, 2, 3))
    assert again == BODY


def test_moved_keeps_the_inertia():
    moved = BODY.moved((1, 1, 1))
    assert (moved.center, moved.inertia, moved.mass) == ((Fraction(3, 2), 0, 4), BODY.inertia, 2)


# --- rotation ---------------------------------------------------------------------------------


def test_rotated():
    R = Rotation.euler("ZXZ", 0.3, 1.1, -0.4)
    turned = BODY.rotated(R)
    assert np.abs(array(turned.inertia) - array(R) @ array(BODY.inertia) @ array(R).T).max() < 1e-14
    assert np.abs(array(turned.center) - array(R) @ array(BODY.center)).max() < 1e-15
    assert turned.rotated(np.array(R.inverse)).mass == 2


def test_inclined_disk_has_the_textbooks_product():
    # Meirovitch, section 6.6: a thin disk whose normal is turned by β from the shaft z, about y:
    # I_xz = (I_d - I_t) sin β cos β with I_d = m r²/2, I_t = m r²/4, up to the sense of β.
    r, beta = sympy.symbols("r beta", real=True)
    turned = disk(m, r).rotated(Rotation.axis_angle("y", beta))
    expected = -m * r**2 / 4 * sympy.sin(beta) * sympy.cos(beta)
    assert sympy.simplify(turned.products.xz - expected) == 0
    assert turned.products.xy == 0 and turned.products.yz == 0


# --- combination ------------------------------------------------------------------------------


def test_a_box_is_two_halves():
    halves = box(m / 2, (a / 2, b, c)).moved((a / 4, 0, 0)) + box(m / 2, (a / 2, b, c)).moved((-a / 4, 0, 0))
    whole = box(m, (a, b, c))
    assert halves.mass == m and halves.center == (0, 0, 0)
    assert zero(sympy.Matrix(halves.inertia) - sympy.Matrix(whole.inertia))
    assert set(halves.positive) >= {a / 2, b, c, m / 2}


def test_a_tube_is_a_cylinder_less_a_cylinder():
    rho = m / (sympy.pi * (b**2 - a**2) * l)
    solid = cylinder(rho * sympy.pi * b**2 * l, b, l) - cylinder(rho * sympy.pi * a**2 * l, a, l)
    hollow = tube(m, a, b, l)
    assert sympy.simplify(solid.mass - m) == 0
    assert zero(sympy.Matrix(solid.inertia) - sympy.Matrix(hollow.inertia))


def test_an_off_centre_hole_moves_the_centre():
    plain, hole = plate(4, (2, 2)), disk(1, half).moved((half, 0, 0))
    rest = plain - hole
    assert rest.mass == 3
    assert rest.center == (Fraction(-1, 6), 0, 0)
    assert rest + hole == plain
    assert rest.about((0, 0, 0)) == tuple(
        tuple(p - q for p, q in zip(P, Q, strict=True))
        for P, Q in zip(plain.about((0, 0, 0)), hole.about((0, 0, 0)), strict=True)
    )


def test_two_particles_make_a_dumbbell():
    M = sympy.Symbol("M", real=True)
    both = particle(m) + particle(M).moved((l, 0, 0))
    assert both.center == (M * l / (M + m), 0, 0)
    assert sympy.simplify(both.moments[1] - l**2 * m * M / (m + M)) == 0  # the reduced mass
    assert both.moments[0] == 0


def test_adding_nothing():
    assert particle(0) + particle(0) == particle(0)
    assert BODY + particle(0) == BODY


# --- principal axes ---------------------------------------------------------------------------


def diagonal(body):
    moments, axes = body.principal()
    R = array(axes)
    return moments, R, R.T @ array(body.inertia) @ R


def test_principal_axes_diagonalise():
    moments, R, D = diagonal(BODY)
    assert list(moments) == sorted(moments)
    assert np.abs(D - np.diag(moments)).max() < 1e-14
    assert np.linalg.det(R) == pytest.approx(1)
    for axis in (R[:, 0], R[:, 1]):
        assert axis[np.abs(axis).argmax()] > 0


@pytest.mark.parametrize("moments", [(1, 2, 2), (2, 2, 3), (2, 2, 2), (1, 2, Fraction(5, 2))])
def test_principal_axes_of_turned_bodies(moments):
    body = MassProperties.from_products(1, (0, 0, 0), moments).rotated(Rotation.euler("XYZ", 0.3, 0.5, 0.7))
    found, R, D = diagonal(body)
    assert found == pytest.approx([float(x) for x in moments])
    assert np.abs(D - np.diag(found)).max() < 4e-15
    assert np.linalg.det(R) == pytest.approx(1)


def test_degenerate_axes_are_chosen_the_same_way_every_time():
    # The unique axis is (0, 1, 1)/√2; of the two equal ones the first is the body's x.
    body = disk(1, 1, axis=(0, 1, 1))
    moments, axes = body.principal()
    root = np.sqrt(1 / 2)
    assert moments == pytest.approx((0.25, 0.25, 0.5))
    assert array(axes) == pytest.approx(np.array([[1, 0, 0], [0, root, root], [0, -root, root]]))
    oblique = array(disk(1, 1, axis=(1, 1, 1)).principal().axes)
    assert oblique[:, 2] == pytest.approx(np.ones(3) / np.sqrt(3))
    assert oblique[:, 0] == pytest.approx(np.array([2, -1, -1]) / np.sqrt(6))
    bar = slender_bar(1, 1, axis=(0, 1, 1))
    assert array(bar.principal().axes) == pytest.approx(
        np.array([[0, 1, 0], [root, 0, root], [root, 0, -root]])
    )
    assert sphere(1, 1).principal().axes == Rotation.identity()


def test_principal_axes_of_a_diagonal_matrix_are_exact():
    body = MassProperties.from_products(1, (0, 0, 0), (3, 1, Fraction(5, 2)))
    moments, axes = body.principal()
    assert moments == (1, Fraction(5, 2), 3)
    assert axes.matrix == ((0, 0, 1), (1, 0, 0), (0, 1, 0))
    odd = MassProperties.from_products(1, (0, 0, 0), (3, 2, 4)).principal()
    assert odd.moments == (2, 3, 4)
    assert odd.axes.matrix == ((0, 1, 0), (1, 0, 0), (0, 0, -1))


def test_principal_axes_with_symbols():
    # Ordered where the symbols are positive by their use, in the order of the body's axes where that says nothing.
    r = sympy.Symbol("r", real=True)
    moments, axes = disk(m, r, axis="x").principal()
    assert moments == (m * r**2 / 4, m * r**2 / 4, m * r**2 / 2)
    assert axes.matrix == ((0, 0, 1), (1, 0, 0), (0, 1, 0))
    moments, axes = slender_bar(m, 2 * l, axis="y").principal()
    assert moments == (0, m * l**2 / 3, m * l**2 / 3)
    I1, I2, I3 = sympy.symbols("I1 I2 I3", real=True)
    free = MassProperties.from_products(m, (0, 0, 0), (I3, I1, I2)).principal()
    assert free.moments == (I3, I1, I2) and free.axes == Rotation.identity()


# --- products, radii, numbers -----------------------------------------------------------------


def test_products_are_the_integrals():
    # Two particles at ±(1, 2, 3): I_xy = ∫ x y dm = 2 · 2 = 4, and the matrix holds minus that.
    body = particle(1).moved((1, 2, 3)) + particle(1).moved((-1, -2, -3))
    assert body.products == Products(xy=4, xz=6, yz=12)
    assert body.inertia[0] == (26, -4, -6)
    assert body.products_about((0, 0, 1)) == (4, 6, 12)
    assert particle(2).moved((1, 2, 3)).products_about((0, 0, 0)) == (4, 6, 12)


def test_from_products_takes_the_integrals():
    body = particle(1).moved((1, 2, 3)) + particle(1).moved((-1, -2, -3))
    again = MassProperties.from_products(2, (0, 0, 0), body.moments, body.products)
    assert again == body


def test_radius_of_gyration():
    assert slender_bar(m, 2 * l).radius_of_gyration("z") ** 2 == l**2 / 3
    assert slender_bar(3, 2).radius_of_gyration("z", point=(1, 0, 0)) == sympy.sqrt(3) * 2 / 3
    assert sphere(7, 5).radius_of_gyration((1, 1, 1)) == sympy.sqrt(10)


def test_at_puts_numbers():
    r = sympy.Symbol("r", real=True)
    body = disk(m, r).moved((r, 0, 0))
    at = body.at({"m": 4, r: 0.5})
    assert (at.mass, at.center, at.moments) == (4, (half, 0, 0), (Fraction(1, 4), Fraction(1, 4), half))
    assert at.shape["radius"] == half and at.positive == ()
    assert body.at({"m": 4}).symbols == {r} and body.at({"m": 4}).positive == (r,)


def test_floats_are_the_decimals_they_print_as():
    body = MassProperties(0.1, (0.2, 0, 0), np.diag([0.3, 0.3, 0.3]))
    assert (body.mass, body.center[0], body.inertia[0][0]) == (
        Fraction(1, 10),
        Fraction(1, 5),
        Fraction(3, 10),
    )
    assert MassProperties(0.5 * m, (0, 0, 0), sympy.zeros(3, 3)).mass == m / 2


def test_values_are_frozen_and_print_shortly():
    body = disk(0.3, 1)
    assert (
        repr(body)
        == "MassProperties(mass 0.3, centre (0, 0, 0), inertia [0.075, 0, 0; 0, 0.075, 0; 0, 0, 0.15])"
    )
    with pytest.raises(AttributeError):
        body.mass = 2
    assert hash(body) == hash(disk(Fraction(3, 10), 1))


def test_two_flywheels_whose_mass_is_counted_elsewhere_keep_both_inertias():
    one, two = (MassProperties(0, (0, 0, 0), ((i, 0, 0), (0, i, 0), (0, 0, i))) for i in (1, 2))
    assert (one + two).inertia == ((3, 0, 0), (0, 3, 0), (0, 0, 3)) and (one + two).mass == 0
