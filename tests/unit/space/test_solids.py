"""Every solid's formula, derived again by integration over its own region; density and revolution."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import sympy
from sympy import cos, pi, sin

from freebody.errors import MassError
from freebody.space.density import from_density, revolve
from freebody.space.mass import MassProperties
from freebody.space.rotation import Rotation
from freebody.space.solids import (
    box,
    cone,
    cylinder,
    disk,
    ellipsoid,
    particle,
    plate,
    ring,
    slender_bar,
    sphere,
    spherical_shell,
    torus,
    tube,
)

m, a, b, c = sympy.symbols("m a b c", positive=True)
x, y, z, r, s, u, v = sympy.symbols("x y z r s u v", real=True)


def integrated(position, element, *ranges):
    """Mass 1 spread as ``element`` (length, area, volume) over a map of the ranges: mass, centre and inertia."""

    def total(f):
        result = sympy.expand(f * element)
        for variable in ranges:
            result = sympy.expand(sympy.integrate(result, variable))
        return result

    size = total(sympy.Integer(1))
    center = [sympy.cancel(total(p) / size) for p in position]
    S = sympy.Matrix(3, 3, lambda i, j: total((position[i] - center[i]) * (position[j] - center[j])) / size)
    inertia = sympy.trace(S) * sympy.eye(3) - S
    return center, inertia.applyfunc(lambda e: sympy.cancel(m * e))


def assert_same(body, center, inertia):
    assert [sympy.cancel(p - q) for p, q in zip(body.center, center, strict=True)] == [0, 0, 0]
    assert (sympy.Matrix(body.inertia) - inertia).applyfunc(sympy.cancel) == sympy.zeros(3, 3)


ROUND = (u, 0, 2 * pi)
CASES = {
    "slender_bar": (slender_bar(m, a), (x, 0, 0), 1, [(x, -a / 2, a / 2)]),
    "disk": (disk(m, a), (r * cos(u), r * sin(u), 0), r, [(r, 0, a), ROUND]),
    "ring": (ring(m, a), (a * cos(u), a * sin(u), 0), a, [ROUND]),
    "cylinder": (cylinder(m, a, b), (r * cos(u), r * sin(u), z), r, [(r, 0, a), ROUND, (z, -b / 2, b / 2)]),
    "tube": (tube(m, a, b, c), (r * cos(u), r * sin(u), z), r, [(r, a, b), ROUND, (z, -c / 2, c / 2)]),
    # The cone's base at -b/4 and apex at 3 b/4 on z, as its docstring says.
    "cone": (
        cone(m, a, b),
        (r * cos(u), r * sin(u), z),
        r,
        [(r, 0, a * (3 * b / 4 - z) / b), ROUND, (z, -b / 4, 3 * b / 4)],
    ),
    "box": (box(m, (a, b, c)), (x, y, z), 1, [(x, -a / 2, a / 2), (y, -b / 2, b / 2), (z, -c / 2, c / 2)]),
    "plate": (plate(m, (a, b)), (x, y, 0), 1, [(x, -a / 2, a / 2), (y, -b / 2, b / 2)]),
    "plate normal to x": (plate(m, (a, b), "x"), (0, x, y), 1, [(x, -a / 2, a / 2), (y, -b / 2, b / 2)]),
    "plate normal to y": (plate(m, (a, b), "y"), (y, 0, x), 1, [(x, -a / 2, a / 2), (y, -b / 2, b / 2)]),
    "sphere": (
        sphere(m, a),
        (r * sin(v) * cos(u), r * sin(v) * sin(u), r * cos(v)),
        r**2 * sin(v),
        [(r, 0, a), (v, 0, pi), ROUND],
    ),
    "spherical_shell": (
        spherical_shell(m, a),
        (a * sin(v) * cos(u), a * sin(v) * sin(u), a * cos(v)),
        a**2 * sin(v),
        [(v, 0, pi), ROUND],
    ),
    "ellipsoid": (
        ellipsoid(m, (a, b, c)),
        (a * r * sin(v) * cos(u), b * r * sin(v) * sin(u), c * r * cos(v)),
        a * b * c * r**2 * sin(v),
        [(r, 0, 1), (v, 0, pi), ROUND],
    ),
    "torus": (
        torus(m, a, b),
        ((a + r * cos(v)) * cos(u), (a + r * cos(v)) * sin(u), r * sin(v)),
        r * (a + r * cos(v)),
        [(r, 0, b), (v, 0, 2 * pi), ROUND],
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_formula_is_the_integral(name):
    body, position, element, ranges = CASES[name]
    assert body.mass == m
    assert_same(body, *integrated(position, element, *ranges))
    assert m in body.positive and body.shape.kind == name.split()[0]


def test_particle():
    assert particle(m) == MassProperties(m, (0, 0, 0), np.zeros((3, 3)))
    assert particle(2).shape.kind == "particle"


@pytest.mark.parametrize(
    "solid",
    [
        lambda axis: slender_bar(m, a, axis),
        lambda axis: disk(m, a, axis),
        lambda axis: ring(m, a, axis),
        lambda axis: cylinder(m, a, b, axis),
        lambda axis: tube(m, a, b, c, axis),
        lambda axis: cone(m, a, b, axis),
        lambda axis: torus(m, a, b, axis),
    ],
)
def test_axis(solid):
    along = solid("z")
    for axis, about, angle in (("x", "y", pi / 2), ("y", "x", -pi / 2)):
        turned = along.rotated(Rotation.axis_angle(about, angle))
        assert_same(solid(axis), turned.center, sympy.Matrix(turned.inertia))
    oblique = solid((1, 2, 2))  # of length 3: no square root is left
    turned = along.rotated(Rotation([[2 / 3, -2 / 3, 1 / 3], [1 / 3, 2 / 3, 2 / 3], [-2 / 3, -1 / 3, 2 / 3]]))
    at = {m: 2, a: 0.3, b: 0.3, c: 1.1}
    difference = np.array(oblique.at(at).inertia, float) - np.array(turned.at(at).inertia, float)
    assert np.abs(difference).max() < 1e-15


def test_positive_by_use():
    assert slender_bar(m, 2 * a).positive == (m, 2 * a)
    assert tube(m, a, b, 1).positive == (m, a, b, b - a)
    assert box(2, (1, a, 3)).positive == (a,)


def test_shape_remembers_the_dimensions():
    shape = cylinder(m, a, b, axis="y").shape
    assert (shape.kind, shape["radius"], shape["length"], shape.axis) == ("cylinder", a, b, (0, 1, 0))
    placed = box(1, (1, 2, 3)).rotated(Rotation.axis_angle("z", pi / 2)).moved((5, 0, 0)).shape
    assert placed.center == (5, 0, 0) and placed.axes == ((0, -1, 0), (1, 0, 0), (0, 0, 1))
    pierced = (box(3, (1, 2, 3)) - particle(1).moved((0, sympy.Rational(1, 2), 0))).shape
    assert [(part.kind, part.hole) for part in pierced.parts] == [("box", False), ("particle", True)]


# --- density ----------------------------------------------------------------------------------

rho, h = sympy.symbols("rho h", real=True)
A, B, C = sympy.symbols("A B C", real=True)


def same(found, expected):
    """Equal as expressions, entry by entry."""
    pairs = [(found.mass, expected.mass), *zip(found.center, expected.center, strict=True)]
    pairs += [
        (p, q)
        for P, Q in zip(found.inertia, expected.inertia, strict=True)
        for p, q in zip(P, Q, strict=True)
    ]
    return all(sympy.simplify(p - q) == 0 for p, q in pairs)


def test_density_over_boxes_cylinders_and_spheres():
    found = from_density(rho, [(0, A), (0, B), (0, C)], (x, y, z))
    assert same(found, box(rho * A * B * C, (A, B, C)).moved((A / 2, B / 2, C / 2)))
    found = from_density(rho, [(0, A), (0, 2 * pi), (0, h)], (r, u, z), "cylindrical")
    assert same(found, cylinder(pi * rho * A**2 * h, A, h).moved((0, 0, h / 2)))
    assert A in found.positive and h in found.positive
    found = from_density(rho, [(0, A), (0, pi), (0, 2 * pi)], (r, v, u), "spherical")
    assert same(found, sphere(4 * pi * rho * A**3 / 3, A))


def test_density_with_bounds_that_depend_on_other_variables():
    # A right triangle of thickness C; its integrals are in every handbook: I_xy about the corner = m A B/12
    found = from_density(rho, [(0, A), (0, B * (1 - x / A)), (0, C)], (x, y, z))
    assert found.mass == A * B * C * rho / 2
    assert found.center == (A / 3, B / 3, C / 2)
    assert sympy.simplify(found.products_about((0, 0, 0)).xy - found.mass * A * B / 12) == 0


def test_density_that_varies():
    # ρ = k r in a half ball: m = k π a⁴/2, centre at 2 a/5
    k = sympy.Symbol("k", real=True)
    found = from_density(k * r, [(0, A), (0, pi / 2), (0, 2 * pi)], (r, v, u), "spherical")
    assert (found.mass, found.center) == (pi * A**4 * k / 2, (0, 0, 2 * A / 5))


def test_density_by_quadrature():
    values = {"A": 1, B: 2, "C": 3, "rho": 4}
    exact = from_density(rho * x**2, [(0, A), (0, B), (0, C)], (x, y, z)).at(values)
    found = from_density(rho * x**2, [(0, A), (0, B), (0, C)], (x, y, z), values=values)
    assert float(found.mass) == pytest.approx(float(exact.mass), rel=1e-12)
    assert np.array(found.inertia, float) == pytest.approx(
        np.array(exact.inertia, float), rel=1e-12, abs=1e-12
    )


def test_revolve():
    assert same(revolve(A, (-h / 2, h / 2), z, mass=m), cylinder(m, A, h))
    assert same(revolve(B, (-h / 2, h / 2), z, mass=m, inner=A), tube(m, A, B, h))
    assert same(revolve(sympy.sqrt(A**2 - z**2), (-A, A), z, mass=m), sphere(m, A))
    assert same(revolve(A * (1 - z / h), (0, h), z, mass=m), cone(m, A, h).moved((0, 0, h / 4)))
    assert same(
        revolve(A * (1 - z / h), (0, h), z, mass=m, axis="x"), cone(m, A, h, "x").moved((h / 4, 0, 0))
    )
    assert revolve(A, (0, h), z, density=rho).mass == pi * A**2 * h * rho


def test_revolve_a_paraboloid():
    # r² = a² z/h: m = π ρ a² h/2, centre 2 h/3, I_z = m a²/3 (CRC, elliptic paraboloid)
    found = revolve(A * sympy.sqrt(z / h), (0, h), z, mass=m)
    assert found.center == (0, 0, 2 * h / 3)
    assert sympy.simplify(found.moments[2] - m * A**2 / 3) == 0
    assert sympy.simplify(found.moments[0] - m * (3 * A**2 + h**2) / 18) == 0


def test_revolve_numbers_stay_exact():
    found = revolve(1, (0, 3), z, mass=1)
    assert found == cylinder(1, 1, 3).moved((0, 0, sympy.Rational(3, 2)))


def test_revolve_by_quadrature():
    profile = sympy.exp(sin(z))
    found = revolve(profile, (0, h), z, density=rho, values={"h": 1, "rho": 2})
    from scipy.integrate import quad

    expected = 2 * np.pi * quad(lambda t: np.exp(2 * np.sin(t)), 0, 1)[0]
    assert float(found.mass) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: revolve(sympy.exp(sin(z)), (0, h), z, density=rho),
            r"left Integral\(exp\(2\*sin\(z\)\), \(z, 0, h\)\).*values=",
        ),
        (
            lambda: revolve(1 - z, (0, 2), z, mass=1),
            r"radius that is not negative, got -0\.0625 at z = 1\.0625",
        ),
        (lambda: revolve(1, (0, 2), z, mass=1, inner=2), "inner radius within the outer one, got 2 > 1"),
        (lambda: revolve(1, (2, 0), z, mass=1), r"bounds \(lower, upper\), got \(2, 0\)\. Swap"),
        (lambda: revolve(1, (0, 1), z), "either mass= or density=.*got both or none"),
        (lambda: revolve(1, (0, 1), z, mass=1, axis="q"), "axis of revolution as 'x', 'y' or 'z', got 'q'"),
        (lambda: revolve(1, (0, 1, 2), z, mass=1), r"1 pair \(lower, upper\) of bounds"),
        (lambda: revolve(1, (0, 1), "z", mass=1), "1 different SymPy symbol as integration variables"),
        (lambda: from_density(1, [(0, 1)], (x, y, z)), r"3 pairs \(lower, upper\) of bounds"),
        (lambda: from_density(1, [(0, 1)] * 3, (x, x, z)), "3 different SymPy symbols"),
        (
            lambda: from_density(1, [(0, y), (0, x), (0, 1)], (x, y, z)),
            "bounds of x, y that depend on each other in a circle",
        ),
        (
            lambda: from_density(1, [(0, 1)] * 3, (x, y, z), "polar"),
            "coordinates cartesian, cylindrical, spherical, got 'polar'",
        ),
        (
            lambda: from_density(0, [(0, 1)] * 3, (x, y, z)),
            "a solid with mass, got an integral of the density of 0",
        ),
        (lambda: from_density(-1, [(0, 1)] * 3, (x, y, z)), "mass that is not negative, got -1 kg"),
        (
            lambda: revolve(A, (0, h), z, density=rho, values={"A": 1}),
            "values of every symbol.*got none of h, rho",
        ),
    ],
)
def test_refusals_of_integrals(make, message):
    with pytest.raises(MassError, match=message):
        make()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: disk(1, -1), "radius of the disk that is not negative, got -1"),
        (lambda: slender_bar(1, -0.5), "length of the slender_bar that is not negative, got -0.5"),
        (
            lambda: tube(1, 2, 1, 1),
            "inner radius of the tube not to be larger than the outer radius, got 2 > 1.*order",
        ),
        (
            lambda: torus(1, 1, 2),
            "minor radius of the torus not to be larger than the major radius, got 2 > 1",
        ),
        (
            lambda: box(1, (1, 2)),
            r"three components of the edges \(l_x, l_y, l_z\) of the box, got 2 components",
        ),
        (lambda: box(1, (1, -2, 3)), "edge y of the box that is not negative, got -2"),
        (lambda: ellipsoid(1, 3), r"semi-axes \(a, b, c\) of the ellipsoid, got 3"),
        (lambda: plate(1, (1, 2, 3)), r"two edges \(a, b\) of a plate, got \(1, 2, 3\)"),
        (lambda: plate(1, (1, 2), (1, 0, 0)), r"normal of a plate as 'x', 'y' or 'z'.*\.rotated"),
        (lambda: disk(-1, 1), "mass that is not negative, got -1 kg"),
        (
            lambda: disk("m*", 1),
            "the mass as a number or an expression of parameters: Expected a number",
        ),
        (lambda: disk(1, None), "radius of the disk as a number or a SymPy expression, got None"),
        (lambda: disk(1, float("nan")), "radius of the disk to be finite, got nan"),
        (lambda: disk(1, sympy.oo), "radius of the disk to be finite, got oo"),
        (lambda: disk(1, 1, "w"), "axis of the disk as 'x', 'y', 'z' or three components, got 'w'"),
        (lambda: disk(1, 1, (0, 0, 0)), "axis of the disk of a length that is not zero"),
        (lambda: particle(True), "the mass as a number or a SymPy expression, got True"),
    ],
)
def test_refusals_of_solids(make, message):
    with pytest.raises(MassError, match=message):
        make()


def test_no_heavy_import():
    code = (
        "import sys; from freebody.space import density, mass, mesh, pose, rotation, solids; "
        "solids.disk(1, 1); print(sorted({'scipy', 'trimesh', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_text_stands_for_the_parameters_of_a_system():
    import freebody as fb

    s = fb.System("bar")
    m, a = s.parameters(m=1, a=2)
    assert fb.slender_bar("m", "2*a", axis="y") == fb.slender_bar(m, 2 * a, axis="y")
    s.body("bar", fb.slender_bar("m", "2*a"))
    with pytest.raises(
        fb.errors.ExpressionError, match="mass properties of body 'ball'.*'mm'; did you mean 'm'"
    ):
        s.body("ball", fb.sphere("mm", 1))
