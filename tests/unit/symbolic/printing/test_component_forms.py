"""The component forms of the chapter, each proven from H and dH/dt."""

import pytest
import sympy

import freebody as fb
from freebody import forms
from freebody.errors import ModelError
from freebody.scalar.polynomial import Ring

t = sympy.Symbol("t")


def zero(column):
    """Canonically: angles are the coordinates, their derivatives symbols of their own."""
    ring = Ring()
    return all(ring.from_sympy(x) == 0 for x in column)


def test_angular_momentum_is_the_integral():
    # (6.9) of one particle at (x, y, z): moments m (r² - x²), products m x y
    x, y, z, m = sympy.symbols("x y z m")
    r, w = sympy.Matrix([x, y, z]), sympy.Matrix(sympy.symbols("w_x w_y w_z"))
    H = forms.angular_momentum(fb.particle(m).about((-x, -y, -z)), w)
    assert zero(H - m * r.cross(w.cross(r)))
    I_xy = sympy.Symbol("I_xy", real=True)
    assert forms.angular_momentum()[0].coeff(I_xy) == -sympy.Function("omega_y")(t)
    assert forms.angular_momentum()[1].coeff(I_xy) == -sympy.Function("omega_x")(t)


def test_moment_equations_from_the_rate_of_momentum():
    # axes fixed in a body that turns by a rotation R(t): dH/dt in space, seen in the body
    angles = [sympy.Function(n)(t) for n in ("a", "b")]
    a, b = angles
    R = sympy.rot_axis3(-a) * sympy.rot_axis1(-b)
    W = R.T * R.diff(t)
    w = sympy.Matrix([W[2, 1], W[0, 2], W[1, 0]])
    inertia = forms.inertia_matrix()
    H = R * forms.angular_momentum(inertia, w)
    assert zero(R.T * H.diff(t) - forms.moment_equations(inertia, w))


def test_moment_equations_term_by_term():
    # (6.27), first line
    J = {n: sympy.Symbol(f"I_{n}", real=True) for n in ("xx", "yy", "zz", "xy", "xz", "yz")}
    x, y, z = forms.rates("omega")
    dx, dy, dz = (w.diff(t) for w in (x, y, z))
    first = (
        J["xx"] * dx - J["xy"] * dy - J["xz"] * dz - J["xz"] * x * y + J["xy"] * x * z
        + (J["zz"] - J["yy"]) * y * z - J["yz"] * (y**2 - z**2)
    )  # fmt: skip
    assert sympy.expand(forms.moment_equations()[0] - first) == 0
    third = (
        -J["xz"] * dx - J["yz"] * dy + J["zz"] * dz + (J["yy"] - J["xx"]) * x * y - J["yz"] * x * z
        + J["xz"] * y * z - J["xy"] * (x**2 - y**2)
    )  # fmt: skip
    assert sympy.expand(forms.moment_equations()[2] - third) == 0


def test_euler_equations_are_the_principal_case():
    moments = sympy.symbols("I_1 I_2 I_3", real=True)
    w = forms.rates("omega", "123")
    assert zero(forms.euler_equations() - forms.moment_equations(moments, w))
    numbers = forms.euler_equations((1, 2, 4), (1, 2, 3), (0, 0, 1))
    assert list(numbers) == [12, -9, 6]


def test_modified_equations_in_an_intermediate_frame():
    # a body of revolution turns by phi in a frame that turns by psi and theta: (6.91), (6.92)
    psi, theta, phi = (sympy.Function(n)(t) for n in ("psi", "theta", "phi"))
    R = sympy.rot_axis3(-psi) * sympy.rot_axis1(-theta)
    frame = sympy.Matrix([theta.diff(t), psi.diff(t) * sympy.sin(theta), psi.diff(t) * sympy.cos(theta)])
    body = frame + sympy.Matrix([0, 0, phi.diff(t)])
    J, K = sympy.symbols("I_xi I_zeta", real=True)
    H = R * sympy.diag(J, J, K) * body
    M = forms.modified_euler_equations((J, J, K), frame, body)
    assert zero(R.T * H.diff(t) - M)
    # (6.90) with the symbols of the chapter
    w = forms.rates("omega", ("xi", "eta", "zeta"))
    spin = sympy.Function("Omega_zeta")(t)
    printed = sympy.Matrix(
        [
            J * w[0].diff(t) + w[1] * (K * spin - J * w[2]),
            J * w[1].diff(t) + w[0] * (J * w[2] - K * spin),  # the print has omega_zeta for omega_xi
            K * spin.diff(t),
        ]
    )
    assert zero(forms.modified_euler_equations() - printed)


def test_body_axes_are_one_such_frame():
    w = forms.rates("omega")
    inertia = forms.inertia_matrix()
    assert zero(forms.modified_euler_equations(inertia, w, w) - forms.moment_equations(inertia, w))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: forms.modified_euler_equations((1, 2, 3)), "The inertia is not constant in this frame"),
        (lambda: forms.moment_equations(None, (1, 2, 3)), "are no functions of t.*give them by alpha="),
        (lambda: forms.modified_euler_equations(None, (0, 0, 0), (0, 0, 1)), "give them by body_rate="),
        (lambda: forms.angular_momentum((1, 2)), "Expected an inertia as MassProperties"),
        (lambda: forms.angular_momentum([[1, 2, 3], [0, 1, 0], [0, 0, 1]]), "Expected a symmetric inertia"),
        (
            lambda: forms.angular_momentum((1, 2, 3), (1, 2)),
            "Expected three components of an angular velocity",
        ),
        (lambda: forms.euler_equations(forms.inertia_matrix().tolist()), "Expected three principal moments"),
    ],
)
def test_refusals(call, message):
    with pytest.raises(ModelError, match=message):
        call()
