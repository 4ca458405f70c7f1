"""Constraints in the description and in the symbolic equations."""

from __future__ import annotations

import pytest
import sympy

import freebody as fb
from freebody.dynamics.conditions.constraints import rows
from freebody.scalar.expression import exact


def disk_on_a_slope():
    s = fb.System("disk")
    m, R, g = s.parameters(m=5, R=0.25, g=9.81)
    s.gravity = (g * sympy.sin(sympy.pi / 6), -g * sympy.cos(sympy.pi / 6), 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("p", s.ground, disk, coordinate="x y f")
    s.constrain("y = R", name="N")
    s.constrain_speed("x' + R*f'", name="T")
    return s


def slider_crank():
    s = fb.System("slider-crank")
    r, L, m, g = s.parameters(r=1, L=3, m=2, g=9.81)
    s.gravity = (0, -g, 0)
    crank, rod, piston = (
        s.body("crank", fb.slender_bar(m, r)),
        s.body("rod", fb.slender_bar(m, L)),
        s.body("piston", fb.particle(m)),
    )
    s.hinge("shaft", s.ground, crank, to=(-r / 2, 0, 0), coordinate="a")
    s.hinge("pin", crank, rod, at=(r / 2, 0, 0), to=(-L / 2, 0, 0), coordinate="b")
    s.slider("bore", s.ground, piston, coordinate="x")
    s.hinge("wrist", rod, piston, at=(L / 2, 0, 0))
    return s


def atoms(s, *names):
    return [s.expression(name) for name in names]


def test_constraints_matrix_and_multipliers():
    s = disk_on_a_slope()
    e = fb.equations(s)
    y, x1, f1 = atoms(s, "y", "x'", "f'")
    R = atoms(s, "R")[0]
    assert [c.lhs - c.rhs for c in e.constraints] == [y - R, x1 + R * f1]
    assert e.constraint_matrix == sympy.Matrix([[0, 1, 0], [1, 0, R]])
    assert e.constraint_bias == sympy.zeros(2, 1)
    assert [str(symbol) for symbol in e.multipliers] == ["N", "T"]
    N, T = e.multipliers
    m, g = atoms(s, "m", "g")
    x2, f2 = (a.diff(s.t) for a in (x1, f1))
    assert [sympy.expand(eq.lhs - eq.rhs) for eq in e.motion] == [
        sympy.expand(m * x2 - m * g / 2 - T),
        sympy.expand(m * y.diff(s.t, 2) + sympy.sqrt(3) * m * g / 2 - N),
        sympy.expand(m * R**2 * f2 / 2 - R * T),
    ]


def test_text_and_latex_hold_the_constraints():
    text = fb.equations(disk_on_a_slope()).text().splitlines()
    assert text[-2:] == ["-R + y = 0", "x' + R*f' = 0"]
    assert "T" in text[0] and text[0].endswith("= T")
    assert r"\dot{f}" in fb.equations(disk_on_a_slope()).latex().splitlines()[-2]


def test_matrix_is_the_derivative_of_the_constraints():
    s = slider_crank()
    e = fb.equations(s)
    # the two in the plane; the others hold identically
    live = [i for i in range(len(e.multipliers)) if any(x != 0 for x in e.constraint_matrix.row(i))]
    assert [str(e.multipliers[i]) for i in live] == ["wrist_x", "wrist_y"]
    assert len(e.constraints) == 2
    for i, constraint in zip(live, e.constraints, strict=True):
        for j, q in enumerate(e.coordinates):
            assert sympy.simplify(constraint.lhs.diff(q) - e.constraint_matrix[i, j]) == 0
        # γ: what is left of the second derivative without accelerations
        second = constraint.lhs.diff(s.t, 2).xreplace({speed.acceleration: 0 for speed in e.model.speeds})
        assert sympy.simplify(second - e.constraint_bias[i]) == 0


@pytest.mark.parametrize(
    ("make", "independent"), [(disk_on_a_slope, ["x"]), (slider_crank, ["a"]), (slider_crank, ["x"])]
)
def test_eliminated_is_free_of_multipliers_and_equal_to_the_equations(make, independent):
    """The combination Nᵀ of the equations with multipliers: canonically the same."""
    s = make()
    e = fb.equations(s)
    (found,) = e.eliminated(independent)
    assert not found.lhs.has(*e.multipliers)
    # N from G, by division, with SymPy
    G = sympy.Matrix(
        [e.constraint_matrix.row(i) for i in range(len(e.multipliers)) if any(e.constraint_matrix.row(i))]
    )
    chosen = [e.model.coordinate_names.index(name) for name in independent]
    rest = [j for j in range(e.model.n_u) if j not in chosen]
    D = G[:, rest]
    N = sympy.zeros(e.model.n_u, 1)
    N[chosen[0]] = D.det()
    for k, j in enumerate(rest):
        N[j] = -(D.adjugate() * G[:, chosen[0]])[k]
    total = sum(N[j] * (eq.lhs - eq.rhs) for j, eq in enumerate(e.motion))
    assert e.ring.from_sympy(sympy.expand(total)) == e.ring.from_sympy(found.lhs)


def test_eliminated_takes_names_and_symbols_alike():
    s = disk_on_a_slope()
    e = fb.equations(s)
    x = s.expression("x")
    assert e.eliminated(["x"]) == e.eliminated([x]) == e.eliminated(["x'"])


def test_reactions_of_a_loop_closing_joint():
    e = fb.equations(slider_crank())
    assert [*e.reactions] == ["shaft", "pin", "bore", "wrist"]
    wrist = e.reactions["wrist"]
    assert [str(c) for c in wrist.force] == ["wrist_x", "wrist_y", "wrist_z"]
    assert (wrist.on, wrist.frame) == ("piston", "ground")
    assert set(wrist.components) == {"wrist_x", "wrist_y", "wrist_z", "wrist_Mx", "wrist_My"}


def test_multipliers_stand_in_the_free_bodies():
    e = fb.equations(slider_crank())
    rod, piston = (e.free_body(name).forces for name in ("rod", "piston"))
    assert rod["wrist_x"] == -piston["wrist_x"]
    assert sympy.Symbol("wrist_y", real=True) in e.free_body("piston").unknowns


def test_a_rope_pulls_at_all_its_points():
    s = fb.System("tackle")
    m = s.parameters(m=1)
    a, b = s.body("a", fb.particle(m)), s.body("b", fb.particle(m))
    s.slider("left", s.ground, a, axis="-y", coordinate="p")
    s.slider("right", s.ground, b, at=(1, 0, 0), axis="-y", coordinate="q")
    s.assume(s.expression("p") > 0, s.expression("q") > 0)
    s.rope([s.ground.origin, a.origin, s.ground.origin, s.ground.point(1, 0, 0), b.origin], 6, name="S")
    e = fb.equations(s)
    S = sympy.Symbol("S", real=True)
    assert sympy.simplify(e.free_body("a").forces["S"][1] - 2 * S) == 0
    assert sympy.simplify(e.free_body("b").forces["S"][1] - S) == 0


def test_the_teeth_of_a_gear_act_on_its_wheels_and_not_on_their_carrier():
    """Forces and moments of the teeth add up to zero; about the axis of the first wheel they are the multiplier."""
    s = fb.System("planet")
    carrier, sun, planet = (s.body(name, fb.disk(1, 1)) for name in ("carrier", "sun", "planet"))
    s.hinge("arm", s.ground, carrier, coordinate="c")
    first = s.hinge("first", carrier, sun, coordinate="p")
    second = s.hinge("second", carrier, planet, at=(2, 0, 0), coordinate="q")
    s.gear(first, second, -2, name="mesh")
    e = fb.equations(s)
    about = s.ground.point(3, -1, 0)
    for name in ("mesh", "mesh_r"):
        for kind in ("forces", "moments"):
            on = [getattr(e.free_body(body, about=about), kind)[name] for body in ("sun", "planet")]
            assert (on[0] + on[1]).applyfunc(sympy.simplify) == sympy.zeros(3, 1)
        assert name not in e.free_body("carrier").forces
    assert e.free_body("sun").moments["mesh"][2] == sympy.Symbol("mesh", real=True)


def test_multipliers_keep_their_names_apart_from_others():
    s = fb.System("names")
    F = s.parameters(F=1)
    ball = s.body("ball", fb.sphere(1, 1))
    s.planar("p", s.ground, ball, coordinate="x y f")
    s.force("push", ball, (F, 0, 0))
    s.constrain("y", name="F")
    s.constrain("x - y", name="push")
    s.constrain("f", name="p_z")
    model = fb.assemble(s)
    assert [row.name for row in rows(model)] == ["F_", "push_", "p_z_"]
    e = fb.equations(s)
    assert [str(symbol) for symbol in e.multipliers] == ["F_", "push_", "p_z_"]
    assert "F_" in e.text() and sympy.Symbol("F_", real=True) != F


def test_conditions_as_text_equation_and_expression():
    def made(condition):
        s = fb.System("bead")
        bead = s.body("bead", fb.particle(1))
        s.planar("p", s.ground, bead, coordinate="x y f")
        return s, s.constrain(condition(s), name="wire").expression

    forms = [
        made(lambda s: "y = x^2"),
        made(lambda s: "y - x^2"),
        made(lambda s: sympy.Eq(s.expression("y"), s.expression("x") ** 2)),
        made(lambda s: s.expression("y") - s.expression("x") ** 2),
    ]
    assert len({str(expression) for _, expression in forms}) == 1


def test_constraints_are_numbered_without_names():
    s = fb.System("bead")
    bead = s.body("bead", fb.particle(1))
    s.planar("p", s.ground, bead, coordinate="x y f")
    assert [s.constrain("x - 1").name, s.constrain_speed("y'").name] == ["constraint_1", "constraint_2"]


def test_joints_take_names_for_bodies_when_they_close_a_loop():
    s = slider_crank()
    again = fb.System("by name")
    for name in ("crank", "rod"):
        again.body(name, fb.slender_bar(1, 1))
    again.hinge("A", "ground", "crank", coordinate="a")
    again.hinge("B", "crank", "rod", coordinate="b")
    assert again.hinge("C", "ground", "rod").closes
    assert s.joints["wrist"].closes and not s.joints["pin"].closes


def test_indeterminate_by_name():
    e = fb.equations(slider_crank())
    across = {
        "wrist_z",
        "wrist_Mx",
        "wrist_My",
        "shaft_z",
        "shaft_Mx",
        "shaft_My",
        "pin_z",
        "pin_Mx",
        "pin_My",
    }
    found = set(e.indeterminate({"a": 0.5, "x": 3, "b": -0.6}))
    # a particle on a slider can take no moment from the wrist, yet its guide can
    assert across <= found <= across | {"bore_z", "bore_Mx", "bore_My", "bore_Mz"}
    assert "bore_y" not in found and "wrist_y" not in found


def test_indeterminate_takes_symbols_and_expressions():
    s = slider_crank()
    e = fb.equations(s)
    a, x = atoms(s, "a", "x")
    first = e.indeterminate({a: 0.5, x: "L", "b": "-r/2"})
    assert first == e.indeterminate({"a": 0.5, "x": 3, "b": -0.5})
    assert e.indeterminate({"a": 0.5, "x": 7, "b": -0.5}, values={"L": 7}) == first


def test_a_machine_without_constraints_has_none():
    s = fb.System("free")
    s.hinge("A", s.ground, s.body("bar", fb.slender_bar(1, 1)), coordinate="a")
    e = fb.equations(s)
    assert e.constraints == () and e.multipliers == () and e.indeterminate() == ()
    assert e.constraint_matrix.shape == (0, 1)


def test_exact_numbers_stay_exact():
    s = fb.System("bead")
    bead = s.body("bead", fb.particle(1))
    s.planar("p", s.ground, bead, coordinate="x y f")
    s.constrain("y - 0.1*x", name="wire")
    assert fb.equations(s).constraint_matrix == sympy.Matrix([[-sympy.Rational(1, 10), 1, 0]])
    assert exact(0.1) == sympy.Rational(1, 10)
