"""Reactions eliminated, moments about any point, planar motion recognised."""

import pytest
import sympy

import freebody as fb
from freebody.errors import ModelError
from freebody.symbolic.free_body.action import TITLES

t = sympy.Symbol("t")


def pendulum():
    s = fb.System("pendulum")
    m, a, g = s.parameters(m=1, a=1, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, a, 0), coordinate="theta")
    return s, (m, a, g)


def double_pendulum():
    s = fb.System("double pendulum")
    m1, m2, L1, L2, g = s.parameters(m1=2, m2=1, L1=0.8, L2=0.6, g=9.81)
    s.gravity = (0, -g, 0)
    A, B = s.body("A", fb.slender_bar(m1, L1, axis="y")), s.body("B", fb.slender_bar(m2, L2, axis="y"))
    s.hinge("O", s.ground, A, to=(0, L1 / 2, 0), coordinate="q1")
    s.hinge("J", A, B, at=(0, -L1 / 2, 0), to=(0, L2 / 2, 0), coordinate="q2")
    return s


def four_bar():
    s = fb.System("four-bar")
    m, L, g = s.parameters(m=1, L=1, g=9.81)
    s.gravity = (0, -g, 0)
    crank, rod, rocker = (
        s.body(n, fb.slender_bar(k * m, k * L)) for n, k in (("crank", 1), ("rod", 2), ("rocker", 3))
    )
    s.hinge("A", s.ground, crank, to=(-L / 2, 0, 0), coordinate="a")
    s.hinge("B", crank, rod, at=(L / 2, 0, 0), to=(-L, 0, 0), coordinate="b")
    s.hinge("D", s.ground, rocker, at=(2 * L, 0, 0), to=(-3 * L / 2, 0, 0), coordinate="d")
    s.hinge("C", rocker, rod, at=(3 * L / 2, 0, 0), to=(L, 0, 0))
    return s


def spatial(first, second):
    """Two boxes with all moments and products of inertia in sight, joined in space."""
    s = fb.System(f"{first} and {second}")
    m, a, g = s.parameters(m=1, a=1, g=9.81)
    s.gravity = (0, 0, -g)
    inner = s.body("inner", fb.box(2 * m, (a, 2 * a, 3 * a)))
    outer = s.body(
        "outer", fb.box(m, (3 * a, a, 2 * a)).rotated(fb.Rotation.euler("XYZ", sympy.pi / 6, 0, 0))
    )
    getattr(s, first)("lower", s.ground, inner, to=(0, a, 0))
    getattr(s, second)("upper", inner, outer, at=(a, 0, 0), to=(0, 0, 2 * a))
    return s


SPATIAL = [
    ("hinge", "ball"),
    ("gimbal", "hinge"),
    ("universal", "cylindrical"),
    ("ball", "planar"),
    ("free", "weld"),
]


def sum_of_rows(e, coefficients, bodies=None):
    """Σ c (m a - F) of the free-body equations, canonical."""
    total = 0
    for (body, title), c in coefficients.items():
        free = (bodies or {}).get(body) or e.free_body(body)
        left, right = free.balances[TITLES.index(title)]
        total = total + c * (right - left)
    return total


def without_reactions(e, x):
    return not any(str(a) in e_names(e) for a in (e.ring.atoms_of(x)))


def e_names(e):
    return {str(u) for body in e.model.bodies for u in e.free_body(body).unknowns}


def test_a_hinged_bar_as_a_textbook_does_it():
    s, (m, a, g) = pendulum()
    e = fb.equations(s)
    q = sympy.Function("theta")(t)
    for result in (e.eliminate(), e.eliminate("pin"), e.eliminate(["pin_x", "pin_y"])):
        (coefficients,) = result.combination
        assert coefficients == {
            ("bar", "force x"): a * sympy.cos(q),
            ("bar", "force y"): a * sympy.sin(q),
            ("bar", "moment z"): 1,
        }
    assert e.eliminate().equations == e.motion
    about_pin = e.free_body("bar", about=s.bodies["bar"].point(0, a, 0))
    (one,) = e.eliminate("pin", bodies=about_pin).combination
    assert one == {("bar", "moment z"): 1}
    assert e.eliminate("pin").text() == (
        "Without pin_x, pin_y, pin_z, pin_Mx, pin_My:\n"
        "by theta'\n"
        "    (a*cos(theta)) * [bar: force x]\n"
        "    (a*sin(theta)) * [bar: force y]\n"
        "    (1) * [bar: moment z]\n"
        "  gives  4*m*a^2*theta''/3 + m*a*g*sin(theta) = 0"
    )
    assert (
        r"\text{bar: force x}" in e.eliminate("pin").latex()
        and r"\ddot{\theta}" in e.eliminate("pin").latex()
    )


@pytest.mark.parametrize("joints", SPATIAL, ids=str)
def test_all_reactions_of_machines_in_space(joints):
    e = fb.equations(spatial(*joints))
    result = e.eliminate()
    assert len(result.steps) == e.model.n_u
    for step, (left, right) in zip(result.steps, e.balances, strict=True):
        assert sum_of_rows(e, step.coefficients) == left - right
        assert without_reactions(e, left - right)
        assert step.balance == (left, right)


def test_elimination_by_rows_spans_the_equations_of_motion():
    e = fb.equations(double_pendulum())
    free = {name: e.free_body(name) for name in e.model.bodies}
    result = e.eliminate(["O", "J"], bodies=list(free.values()))
    assert len(result.steps) == 2
    ring = e.ring
    motion = [left - right for left, right in e.balances]
    M = e.canonical_mass_matrix
    for step in result.steps:
        x = sum_of_rows(e, step.coefficients)
        assert x == step.balance[0] - step.balance[1]
        assert without_reactions(e, x)
        # x = Σ k_j motion_j: det(M) k = adj(M) ∂x/∂u''
        c = [ring.derivative(x, speed.acceleration) for speed in e.model.speeds]
        det = M[0][0] * M[1][1] - M[0][1] * M[1][0]
        k = (c[0] * M[1][1] - c[1] * M[1][0], c[1] * M[0][0] - c[0] * M[0][1])
        assert det * x == k[0] * motion[0] + k[1] * motion[1]


def test_some_reactions_stay():
    e = fb.equations(double_pendulum())
    result = e.eliminate("J")
    for step in result.steps:
        x = sum_of_rows(e, step.coefficients)
        assert not any(str(a).startswith("J_") for a in e.ring.atoms_of(x))
    assert any(str(a).startswith("O_") for step in result.steps for a in e.ring.atoms_of(step.balance[1]))


def test_multipliers_of_a_loop():
    e = fb.equations(four_bar())
    result = e.eliminate()
    (step,) = result.steps
    x = sum_of_rows(e, step.coefficients)
    assert without_reactions(e, x) and x == step.balance[0] - step.balance[1]
    assert all(any(body == b for b, _ in step.coefficients) for body in e.model.bodies)


def test_refusals():
    e = fb.equations(double_pendulum())
    with pytest.raises(ModelError, match="Unknown reaction 'K'"):
        e.eliminate("K")
    with pytest.raises(ModelError, match="Expected at least one reaction"):
        e.eliminate([])
    with pytest.raises(ModelError, match="No combination of the 6 free-body equations given is free of"):
        e.eliminate(["O", "J"], bodies="A")
    with pytest.raises(ModelError, match="Body 'A' is given twice"):
        e.eliminate("J", bodies=["A", "A"])


# -- moments about any point ------------------------------------------------------------------------


def test_moment_form_about_a_moving_point():
    s = fb.System("cart and bar")  # example 6.5
    M, m, a, F = s.parameters(M=2, m=1, a=0.5, F=1)
    cart, bar = s.body("cart", fb.particle(M)), s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    s.slider("guide", s.ground, cart, coordinate="x")
    s.hinge("pin", cart, bar, to=(0, a, 0), coordinate="theta")
    s.force("F", bar.point(0, -a, 0), (F, 0, 0))
    e = fb.equations(s)
    form = e.free_body("bar").moment_form("pin")
    q, x = sympy.Function("theta")(t), sympy.Function("x")(t)
    assert form.proven and form.of_body
    assert form.terms["rho x m a_A"][2] == m * a * sympy.cos(q) * x.diff(t, 2)
    assert form.terms["I_A alpha"][2] == 4 * m * a**2 * q.diff(t, 2) / 3
    assert form.terms["omega x I_A omega"] == sympy.zeros(3, 1)
    # about the pin, its forces have no moment: 2 a F cos(theta)
    assert form.equations[2].lhs == 2 * F * a * sympy.cos(q)
    assert form.text().splitlines() == [
        "Moments on 'bar' about A = joint 'pin', components in ground axes",
        "  M_A = rho x m a_A + I_A alpha + omega x I_A omega",
        "  moment z:  2*a*F*cos(theta) = (m*a*x''*cos(theta)) + (4*m*a^2*theta''/3)",
    ]
    assert r"\boldsymbol{\rho} \times m \mathbf{a}_A" in form.latex()
    about_cart = e.free_body("bar").moment_form(cart)
    assert about_cart.proven and not about_cart.of_body
    assert set(about_cart.terms) == {"rho x m a_A", "I_C alpha", "omega x I_C omega", "rho x m rho''"}
    assert r"\ddot{\boldsymbol{\rho}}" in about_cart.latex()
    centre = e.free_body("bar").moment_form(bar.center)
    assert centre.terms["rho x m a_A"] == sympy.zeros(3, 1)


@pytest.mark.parametrize("joints", SPATIAL[:4], ids=str)
def test_moment_form_in_space(joints):
    s = spatial(*joints)
    e = fb.equations(s)
    name, other = "outer", s.bodies["inner"]
    for frame in (None, name):
        free = e.free_body(name, frame=frame)
        for about in (s.bodies[name].point(1, 2, 3), other.point(1, 0, 2), s.ground.point(3, 2, 1)):
            form = free.moment_form(about)
            assert form.proven
            same = e.free_body(name, about=about, frame=frame)
            assert form.moments == same.moment_sum
            assert tuple(b for _, b in form.balances) == same.momentum_rate


def test_moment_form_refuses():
    s, _ = pendulum()
    free = fb.equations(s).free_body("bar")
    with pytest.raises(ModelError, match="Unknown joint 'pim' to take moments about"):
        free.moment_form("pim")
    with pytest.raises(ModelError, match="Expected a point, such as"):
        free.moment_form(3)
    other, _ = pendulum()
    with pytest.raises(ModelError, match="belongs to the system"):
        free.moment_form(other.bodies["bar"].origin)


# -- planar motion ------------------------------------------------------------------------------------


def test_planar_equations_are_found():
    s, (m, a, g) = pendulum()
    e = fb.equations(s)
    free = e.free_body("bar")
    assert e.planar == "z"
    assert free.planar_equations == (free.equations[0], free.equations[1], free.equations[5])
    text = free.text()
    assert text.splitlines()[0] == (
        "Free body 'bar': planar, components along x, y of ground axes, moments about its mass centre C along z"
    )
    assert text.splitlines()[-1] == "  out of the plane, zero:  pin_z, pin_Mx, pin_My"
    assert "force z" not in text and "moment x" not in text and text.count("pin_z") == 1
    assert free.latex().count(r"\\") == 2
    assert len(e.free_body("bar", frame="bar").planar_equations) == 3


@pytest.mark.parametrize(("axis", "gravity", "normal"), [("x", (0, 0, -9), "x"), ("y", (0, 0, -9), "y")])
def test_other_planes(axis, gravity, normal):
    s = fb.System("other plane")
    s.gravity = gravity
    bar = s.body("bar", fb.box(1, (1, 2, 3)))
    s.hinge("pin", s.ground, bar, to=(1, 0, 0) if axis == "y" else (0, 1, 0), axis=axis, coordinate="theta")
    assert fb.equations(s).planar == normal


def test_a_translation_is_planar_and_loops_are_indeterminate_out_of_it():
    s = fb.System("slide")
    s.gravity = (0, -9, 0)
    block = s.body("block", fb.particle(1))
    s.slider("guide", s.ground, block, coordinate="x")
    assert fb.equations(s).planar == "z"
    e = fb.equations(four_bar())
    assert e.planar == "z"
    last = e.free_body("rod").text().splitlines()[-1]
    assert last.startswith("  out of the plane, zero:  B_z, B_Mx, B_My, C_z, C_Mx, C_My (B_z")
    assert "indeterminate" in last


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (
            lambda s, b: setattr(s, "gravity", (0, -9, 1)),
            "the force z equation of 'bar' holds more than reactions",
        ),
        (
            lambda s, b: s.force("F", b.point(0, 0, 1), (1, 0, 0)),
            "the moment y equation of 'bar' holds more than",
        ),
        (
            lambda s, b: s.hinge("side", b, s.body("c", fb.sphere(1, 1)), axis="x", coordinate="beta"),
            "'bar' and 'c' turn about the ground axes|'c' turns about the ground axes",
        ),
    ],
)
def test_what_is_not_planar_says_why(change, reason):
    s, _ = pendulum()
    change(s, s.bodies["bar"])
    e = fb.equations(s)
    assert e.planar is None
    with pytest.raises(ModelError, match=f"Free body 'bar' is not planar: ({reason})"):
        e.free_body("bar").planar_equations  # noqa: B018
    assert "force z" in e.free_body("bar").text()


def test_tilted_disk_is_not_planar_for_its_products_of_inertia():
    s = fb.System("tilted disk")
    m, R = s.parameters(m=1, R=1)
    disk = s.body("disk", fb.disk(m, R).rotated(fb.Rotation.euler("XYZ", sympy.pi / 6, 0, 0)))
    s.hinge("shaft", s.ground, disk, axis="z", coordinate="theta")
    with pytest.raises(
        ModelError, match="not planar: the moment [xy] equation of 'disk' holds more than reactions"
    ):
        fb.equations(s).free_body("disk").planar_equations  # noqa: B018


def test_turned_axes_are_not_the_planes():
    s, _ = pendulum()
    tilted = s.body("tilted", fb.particle(1))
    s.weld("w", s.bodies["bar"], tilted, child_axes=fb.Rotation.euler("XYZ", sympy.pi / 6, 0, 0))
    e = fb.equations(s)
    assert e.planar == "z"
    with pytest.raises(ModelError, match="the axes of 'tilted' are not along the normal z"):
        e.free_body("bar", frame="tilted").planar_equations  # noqa: B018
