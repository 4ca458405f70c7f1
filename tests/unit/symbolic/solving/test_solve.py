"""The free-body equations solved for what a user asks: exact answers, and refusals that say what was left."""

import math

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.dynamics import float_state, forward_dynamics
from freebody.dynamics.conditions.constrained import constrained_dynamics, independent_rows
from freebody.errors import ModelError
from freebody.scalar.algebra import floats
from freebody.scalar.polynomial import Ring
from freebody.scalar.ratio import Ratio
from freebody.scalar.substitute import Substitution
from freebody.symbolic.printing.systems import Row
from freebody.symbolic.solving.polynomial_roots import roots
from freebody.symbolic.solving.vocabulary import Vocabulary

t = sympy.Symbol("t")


def hinged_bar():
    s = fb.System("hinged bar")
    m, a, g = s.parameters(m=1, a=1, g=9.81)
    s.parameters(M=3)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, a, 0), coordinate="theta")
    return s, (m, a, g)


def double_pendulum():
    s = fb.System("double pendulum")
    m1, m2, L1, L2, g = s.parameters(m1=2, m2=1, L1=0.8, L2=0.6, g=9.81)
    s.gravity = (0, -g, 0)
    q1, q2 = s.coordinates("q1 q2")
    A, B = s.body("A", fb.slender_bar(m1, L1, axis="y")), s.body("B", fb.slender_bar(m2, L2, axis="y"))
    s.hinge("O", s.ground, A, to=(0, L1 / 2, 0), coordinate=q1)
    s.hinge("J", A, B, at=(0, -L1 / 2, 0), to=(0, L2 / 2, 0), coordinate=q2 - q1)
    return s


def equal(a, b):
    return sympy.simplify(sympy.expand(sympy.together(a - b))) == 0


@pytest.fixture(scope="module")
def bar():
    s, symbols = hinged_bar()
    return fb.equations(s), symbols, sympy.Function("theta")(t)


def test_reactions_as_functions_of_the_motion(bar):
    e, (m, a, g), q = bar
    result = e.solve(["pin_x", "pin_y"])
    acc, w = q.diff(t, 2), q.diff(t)
    assert equal(result["pin_x"], m * a * (acc * sympy.cos(q) - w**2 * sympy.sin(q)))
    assert equal(result["pin_y"], m * g + m * a * (acc * sympy.sin(q) + w**2 * sympy.cos(q)))
    (condition,) = result.conditions
    assert equal(condition.lhs, 4 * a * acc + 3 * g * sympy.sin(q))
    assert result.text() == (
        "pin_x = m*a*(theta''*cos(theta) - theta'^2*sin(theta))\n"
        "pin_y = m*a*(theta''*sin(theta) + theta'^2*cos(theta)) + m*g\n"
        "provided that\n"
        "  4*a*theta'' + 3*g*sin(theta) = 0"
    )
    assert r"\ddot{\theta}" in result.latex()
    assert list(result) == ["pin_x", "pin_y"] and len(result) == 2 and "pin_x" in result


def test_reactions_in_the_state_alone(bar):
    e, (m, a, g), q = bar
    for result in (e.solve(["pin_x", "pin_y", "theta''"]), e.solve(["pin_x", "pin_y"], eliminate="theta''")):
        w = q.diff(t)
        assert not result.conditions
        assert equal(result["pin_y"], m * a * w**2 * sympy.cos(q) + m * g * (1 + 3 * sympy.cos(q) ** 2) / 4)
        assert not result["pin_x"].has(q.diff(t, 2))
    assert equal(e.solve("theta''")[q.diff(t, 2)], -3 * g * sympy.sin(q) / (4 * a))


def test_squares_speeds_and_angles(bar):
    e, (m, a, g), q = bar
    c = sympy.cos(q)
    assert equal(e.solve("theta'^2", where={"pin_y": 0})["theta'^2"], -g * (1 + 3 * c**2) / (4 * a * c))
    both = e.solve("theta'", where={"pin_y": 0})
    assert len(both.branches) == 2
    assert equal(both.branches[0]["theta'"] ** 2, -g * (1 + 3 * c**2) / (4 * a * c))
    assert equal(both.branches[0]["theta'"], -both.branches[1]["theta'"])
    assert "\nor\n" in both.text() and r"\dot{\theta}" in both.latex()
    with pytest.raises(ModelError, match=r"2 solutions for theta'. Choose one: result.branches\[0\]"):
        both["theta'"]
    at_rest = e.solve("theta", where={"pin_x": 0, "theta'": 0})
    assert {branch["theta"] for branch in at_rest.branches} == {0, sympy.pi, sympy.pi / 2, -sympy.pi / 2}
    with pytest.raises(ModelError, match="no real solution for theta"):
        e.solve("theta", where={"pin_y": 0, "theta'": 0})


def test_disk_leaves_its_ledge_where_cos_is_four_sevenths():
    s = fb.System("ledge")  # problem 6.8
    m, R, g = s.parameters(m=3, R=0.25, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.hinge("O", s.ground, disk, to=(0, -R, 0), coordinate="theta")
    where = ["O_y*cos(theta) = O_x*sin(theta)", "3*R*theta'^2 = 4*g*(1 - cos(theta))"]
    result = fb.equations(s).solve(["cos(theta)", "theta'^2"], where=where)
    assert result["cos(theta)"] == sympy.Rational(4, 7)
    assert equal(result["theta'^2"], 4 * g / (7 * R))
    # the angle itself, by the shortest of the ways from its sine and cosine
    angles = [
        branch["theta"] for branch in fb.equations(s).solve(["theta", "theta'^2"], where=where).branches
    ]
    assert angles == [-sympy.acos(sympy.Rational(4, 7)), sympy.acos(sympy.Rational(4, 7))]


def sliding_body():
    s = fb.System("sliding body")  # example 6.1
    m, L, H, D, mu, beta, g = s.parameters(m=50, L=1.2, H=0.8, D=0.15, mu=0.25, beta="20deg", g=9.81)
    F, A, B = s.parameters("F N_A N_B")
    s.gravity = (0, -g, 0)
    body = s.body("body", fb.box(m, (L, H, 1)))
    s.planar("floor", s.ground, body, coordinate="x y phi")
    s.force("F", body.point(-L / 2, H / 2, 0), (F * sympy.cos(beta), F * sympy.sin(beta), 0))
    s.force("A", body.point(-L / 2, -H / 2 - D, 0), (-mu * A, A, 0))
    s.force("B", body.point(L / 2, -H / 2 - D, 0), (-mu * B, B, 0))
    return s


UPRIGHT = {"phi": 0, "phi'": 0, "phi''": 0, "y''": 0}


def test_the_force_at_which_the_normal_force_vanishes():
    e = fb.equations(sliding_body())
    sliding = e.solve(["x''", "N_A", "N_B"], where=UPRIGHT)
    tipping = e.solve(["x''", "F", "N_B"], where=[UPRIGHT, {"N_A": 0}])
    F = sympy.Symbol("F", real=True)
    assert equal(sliding["N_A"].xreplace({F: tipping["F"]}), 0)
    assert equal(sliding["N_B"].xreplace({F: tipping["F"]}), tipping["N_B"])
    # the moment of example 6.1 about the front foot, with its numbers
    m, L, H, D, mu, b, g = 50, 1.2, 0.8, 0.15, 0.25, np.deg2rad(20), 9.81
    c, s = np.cos(b), np.sin(b)
    low = mu * (H / 2 + D)
    values = {
        x: v
        for x, v in zip(sympy.symbols("m L H D mu beta g", real=True), (m, L, H, D, mu, b, g), strict=True)
    }
    expected = m * g * (L / 2 - low) / (c * H / 2 + s * (L - low))
    assert float(tipping["F"].subs(values)) == pytest.approx(expected, rel=1e-13)


def test_the_acceleration_at_which_friction_is_just_enough():
    s = fb.System("board behind a cab")  # problem 6.1
    m, L, beta, mu, g = s.parameters(m=20, L=2.5, beta="70deg", mu=0.3, g=9.81)
    N, T, W = s.parameters("N T W")
    s.gravity = (0, -g, 0)
    board = s.body("board", fb.slender_bar(m, L, axis="x"))
    s.planar("air", s.ground, board, coordinate="x y phi")
    s.force("floor", board.point(-L / 2, 0, 0), (T, N, 0))
    s.force("wall", board.point(L / 2, 0, 0), (-W, 0, 0))
    still = {"phi": "beta", "phi'": 0, "phi''": 0, "y''": 0}
    e = fb.equations(s)
    slide = e.solve(["x''", "N", "W", "T"], where=[still, "T = mu*N"])
    cot = sympy.cos(beta) / sympy.sin(beta)
    assert equal(slide["x''"], 2 * mu * g - g * cot)
    assert equal(slide["W"], m * g * (cot - mu))
    tip = e.solve(["x''", "N", "T"], where=(still, {"W": 0}))
    assert equal(tip["x''"], g * cot)
    needed = e.solve(["mu", "N", "T", "W"], where=[still, sympy.Eq(T, mu * N), ("x''", "g/4")])
    assert equal(needed["mu"], sympy.Rational(1, 8) + cot / 2)


def evaluated(e, result, model, q, u, udot, values=None):
    state = float_state(model, q, u, values=values)
    numbers = dict(state.values) | {c.symbol: x for c, x in zip(model.coordinates, q, strict=True)}
    numbers |= {s.symbol: x for s, x in zip(model.speeds, u, strict=True)}
    numbers |= {s.acceleration: float(x) for s, x in zip(model.speeds, udot, strict=True)}
    at = Substitution(e.ring, floats, numbers)
    return {name: at(r.num) / at(r.den) for name, r in result.ratios.items()}, numbers


@pytest.mark.parametrize("eliminated", [(), ("q1''", "q2''")])
def test_double_pendulum_agrees_with_its_dynamics(eliminated):
    e = fb.equations(double_pendulum())
    model = e.model
    q, u = [0.3, -0.7], [1.1, 0.4]
    udot = forward_dynamics(model, float_state(model, q, u))
    found = e.solve(["O_x", "O_y", "J_x", "J_y"], eliminate=eliminated)
    assert bool(found.conditions) != bool(eliminated)
    values, numbers = evaluated(e, found, model, q, u, udot)
    at = Substitution(e.ring, floats, numbers)
    for joint in ("O", "J"):
        force, _ = e.canonical_reactions[joint]
        for letter, component in zip("xy", force, strict=False):
            assert values[f"{joint}_{letter}"] == pytest.approx(at(component), rel=1e-12)
    motion, _ = evaluated(e, e.solve(["q1''", "q2''"]), model, q, u, udot)
    assert [motion["q1''"], motion["q2''"]] == pytest.approx([float(x) for x in udot], rel=1e-12)


def test_constrained_machine_agrees_with_its_dynamics():
    s = fb.System("tackle")
    m, M, g = s.parameters(m=1, M=3, g=9.81)
    s.gravity = (0, -g, 0)
    a, b = s.body("a", fb.sphere(M, 0.1)), s.body("b", fb.sphere(m, 0.1))
    s.slider("left", s.ground, a, at=(0, -1, 0), axis="-y", coordinate="p")
    s.slider("right", s.ground, b, at=(1, -1, 0), axis="-y", coordinate="q")
    s.constrain("2*p + q = 3", name="rope")
    e = fb.equations(s)
    result = e.solve(["p''", "q''", "rope"])
    assert equal(result["p''"], g * (M - 2 * m) / (M + 4 * m))
    assert equal(result["q''"], -2 * result["p''"])
    model = e.model
    state = float_state(model, [1, 1], [0.1, -0.2])
    udot, multipliers = constrained_dynamics(model, state, independent_rows(model, state))
    values, _ = evaluated(e, result, model, [1, 1], [0.1, -0.2], udot)
    assert values["p''"] == pytest.approx(udot[0], rel=1e-12)
    assert values["rope"] == pytest.approx(multipliers[0], rel=1e-12)


def test_selected_bodies_and_points():
    e = fb.equations(double_pendulum())
    only_b = e.solve(["J_x", "J_y"], bodies="B")
    assert equal(only_b["J_x"], e.solve(["J_x", "J_y"])["J_x"])
    s, (m, a, g) = hinged_bar()
    e = fb.equations(s)
    about_pin = e.free_body("bar", about=s.bodies["bar"].point(0, a, 0))
    assert equal(e.solve("theta''", bodies=[about_pin])["theta''"], e.solve("theta''")["theta''"])
    with pytest.raises(ModelError, match="belongs to other equations"):
        fb.equations(s).solve("pin_x", bodies=[about_pin])


def test_what_polynomials_can_and_can_not():
    s = fb.System("spring")
    m, k, c, F = s.parameters(m=1, k=1, c=1, F=1)
    bob = s.body("bob", fb.particle(m))
    s.slider("way", s.ground, bob, coordinate="x")
    s.force("pull", bob.origin, ("F - k*x - c*x^3", 0, 0))
    e = fb.equations(s)
    result = e.solve("x", where={"x''": 0, "F": 0})
    values = {branch["x"] for branch in result.branches}
    assert 0 in values and len(values) == 3
    with pytest.raises(
        ModelError, match="No closed form is known: the remaining equations have degree 3 in x"
    ):
        e.solve("x", where={"x''": 0})
    numeric = e.solve("x", where={"x''": 0, "F": 10, "k": 1, "c": 1})
    assert [float(b["x"]) for b in numeric.branches] == [2]


@pytest.mark.parametrize(
    ("unknowns", "where", "message"),
    [
        ([], None, "Expected at least one unknown to solve for"),
        ("foo", None, "Expected a known name, got 'foo'"),
        (["pin_x", "M"], None, r"Under-determined: 6 equations do not determine 'M'"),
        (
            ["pin_x"],
            {"theta''": 0, "theta'": 0},
            r"Over-determined: 6 equations for pin_x; 'm\*a\*g\*sin.*moment z",
        ),
        (["pin_x", "pin_x"], None, "'pin_x' is asked for twice"),
        ("t", None, "The time cannot be an unknown"),
        ("pin_x + pin_y", None, "Expected a name, a square such as theta'\\^2"),
        ("pin_x", {"pin_y": 0, sympy.Symbol("pin_y", real=True): 1}, "'pin_y' is given twice in where"),
        ("pin_x", {"nope": 1}, "got 'nope'"),
        ("pin_x", "pin_y", "expected an equation"),
        ("pin_x", 3, "Expected values by name"),
        ("pin_x", [sympy.Symbol("z") + 1], "unknown name 'z'"),
    ],
)
def test_refusals(bar, unknowns, where, message):
    e, *_ = bar
    with pytest.raises(ModelError, match=message):
        e.solve(unknowns, where=where)


def test_refusals_name_the_other_joint_and_lookups_the_nearest():
    e = fb.equations(double_pendulum())
    with pytest.raises(ModelError, match="J_y act in 'J': take the bodies there too"):
        e.solve("J_x", bodies=["A"])
    with pytest.raises(ModelError, match="'J_z' was not solved for"):
        e.solve("J_x")["J_z"]
    s, _ = hinged_bar()
    s.torsion_spring("coil", s.joints["pin"], stiffness=2)
    s.damper("oil", s.joints["pin"], damping=3)
    with pytest.raises(ModelError, match="'theta' occurs inside and outside of sines"):
        fb.equations(s).solve("theta", where={"theta''": 0, "theta'": 0})
    with pytest.raises(ModelError, match=r"has other powers of .* than 'theta'\^2'"):
        fb.equations(s).solve("theta'^2")
    with pytest.raises(ModelError, match="occurs inside exp"):
        s, _ = hinged_bar()
        s.force("wind", s.bodies["bar"].origin, ("exp(M)", 0, 0))
        fb.equations(s).solve("M")
    with pytest.raises(ModelError, match="has no value"):
        s, _ = hinged_bar()
        s.force("wind", s.bodies["bar"].origin, ("1/M", 0, 0))
        fb.equations(s).solve("pin_x", where={"M": 0})


def test_ratios_cancel_what_divides():
    ring = Ring()
    m, M = sympy.symbols("m M")
    q = sympy.Function("q")(t)
    f = ring.from_sympy
    s, c = sympy.sin(q), sympy.cos(q)
    assert Ratio(ring, f(m * m - M * M), f(m + M)).den == 1
    assert repr(Ratio(ring, f(m * s), f(M * (1 - c**2))).tidy()) == "(m)/(M*sin(q(t)))"
    x = Ratio(ring, f(m), f(M + s))
    assert x - x == 0 and not (x - x) and x / x == 1 and x * (1 / x) == 1 and x**-1 == 1 / x
    assert (1 + x) - x == 1 and (x + f(m)) - f(m) == x and 0 - (-x) == x
    assert Ratio(ring, f(1 / m), f(1 / M)).num == f(M)
    assert Ratio(ring, f(s), f(s * m)).whole() == f(1 / m)
    # (1 + s)(1 - s)/(c (1 + s)) = c/(1 + s) by the relation alone
    assert Ratio(ring, f(1 - s), f(c)) == Ratio(ring, f(c), f(1 + s))
    with pytest.raises(Exception, match="divisor that is not zero"):
        x / (x - x)
    with pytest.raises(TypeError, match="no hash"):
        hash(x)


def test_a_body_on_a_ball_joint_is_solved_in_its_own_axes():
    """(A + m L²) wx' = (B - C + m L²) wy wz + m g L 2 (e0 e1 + e2 e3): Euler's equations, no factor left over."""
    s = fb.System("top")
    A, B, C, m, g, L = s.parameters(A=1, B=2, C=2.5, m=1, g=9.81, L=0.3)
    s.gravity = (0, 0, -g)
    top = s.body("top", fb.MassProperties(m, (0, 0, L), ((A, 0, 0), (0, B, 0), (0, 0, C))))
    s.ball("O", s.ground, top)
    e = fb.equations(s)
    asked = ["O_wx'", "O_wy'", "O_wz'"]
    result = e.solve([*asked, "O_x"])
    e0, e1, e2, e3 = e.coordinates
    wx, wy, wz = e.speeds
    assert equal(
        result["O_wx'"], ((B - C + m * L**2) * wy * wz + 2 * m * g * L * (e0 * e1 + e2 * e3)) / (A + m * L**2)
    )
    assert equal(result["O_wz'"], (A - B) * wx * wy / C)
    assert len(result.text().splitlines()[0]) < 100
    assert not result.conditions
    # the force is the one that Newton-Euler gives with these accelerations
    values = {name: result[name] for name in asked}
    force = e.solve("O_x", where={**values})["O_x"]
    numbers = {e0: 0.1, e1: 0.5, e2: -0.7, e3: 0.5, wx: 0.3, wy: -0.4, wz: 0.7}
    given = {p.symbol: p.default for p in e.model.parameters}
    assert float((force - result["O_x"]).subs(numbers).subs(given)) == pytest.approx(0, abs=1e-12)


def test_joints_that_share_a_coordinate_are_solved_for_its_acceleration():
    """A reel and a cord that both follow phi: what couples them does no work on the whole."""
    s = fb.System("unwinding")
    inertia, R, m = s.parameters(I=50, R=0.6, m=0.8)
    theta, phi = s.coordinates("theta phi")
    properties = fb.MassProperties(1, (0, 0, 0), ((inertia, 0, 0), (0, inertia, 0), (0, 0, inertia)))
    drum, reel, mass = (
        s.body("drum", properties),
        s.body("reel", fb.particle(0)),
        s.body("mass", fb.particle(m)),
    )
    s.hinge("axis", s.ground, drum, axis="z", coordinate=theta)
    s.hinge("reel", drum, reel, axis="z", coordinate=phi)
    s.slider("cord", reel, mass, at=(R, 0, 0), axis=(0, -1, 0), coordinate=R * phi)
    e = fb.equations(s)
    result = e.solve(["theta''", "phi''", "reel_Mz"])
    assert not result.conditions
    model = e.model
    q, u = [0.3, 1.2], [0.7, -0.4]
    state = float_state(model, q=q, u=u)
    expected = forward_dynamics(model, state)
    numbers = dict(zip((*e.speeds, *e.coordinates), (*u, *q), strict=True))
    given = {p.symbol: p.default for p in model.parameters}
    for name, value in zip(("theta''", "phi''"), expected, strict=True):
        found = result[name]
        for symbol, number in numbers.items():
            found = found.subs(symbol, number)
        assert float(found.subs(given)) == pytest.approx(value, rel=1e-12)


# -- long answers -----------------------------------------------------------------------------------


def four_bar():
    s = fb.System("four-bar")
    a, b, c, d, g = s.parameters(a=1, b=3, c=2.5, d=3, g=9.81)
    s.gravity = (0, -g, 0)
    crank, coupler, rocker = (
        s.body(name, fb.slender_bar(1, x)) for name, x in zip("ABC", (a, b, c), strict=True)
    )
    s.hinge("O", s.ground, crank, to=(-a / 2, 0, 0), coordinate="p")
    s.hinge("P", crank, coupler, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), coordinate="q")
    s.hinge("G", s.ground, rocker, at=(d, 0, 0), to=(-c / 2, 0, 0), coordinate="r")
    s.hinge("Q", coupler, rocker, at=(b / 2, 0, 0), to=(c / 2, 0, 0))
    return s, ["p''", "q''", "r''", "Q_x"]


def hinge_on_a_free_body():
    s = fb.System("free body and hinge")
    m, length, M, L, a, g = s.parameters(m=2, length=0.7, M=3, L=0.4, a=0.3, g=9.81)
    s.gravity = (0, 0, -g)
    big = s.body("big", fb.cylinder(m, a, length))
    bar = s.body("bar", fb.slender_bar(M, 2 * L, axis="y"))
    s.free("f", s.ground, big)
    s.hinge("h", big, bar, at=(a, 0, 0), to=(0, L, 0), axis="z", coordinate="theta")
    return s, ["f_wx'", "f_wy'", "f_wz'", "f_vx'", "f_vy'", "f_vz'", "theta''", "h_x", "h_y"]


@pytest.mark.parametrize("machine", [pytest.param(four_bar, marks=pytest.mark.slow), hinge_on_a_free_body])
def test_a_long_answer_is_printed_in_steps_that_give_the_same_values(machine) -> None:
    """The steps at a state, one after another, against the dynamics of the machine in floats (constraints included)."""
    s, asked = machine()
    e = fb.equations(s)
    result = e.solve(asked)
    if e.condition_names:
        q = np.array([0.9, *closed_four_bar(0.9)])
        G = np.array([[float(x) for x in row] for row in conditions_at(e, q)])
        u = np.linalg.lstsq(np.vstack([G, [1, 0, 0]]), [0, 0, 2.0], rcond=None)[0]
    else:
        q, u = np.array([0.1, 0.2, 0.3, 0.2, 0.4, 0.4, 0.8, 0.7]), np.arange(-3, 4) / 4
    udot = (
        fb.compile(s, at=q).forward_dynamics(q, u)
        if e.condition_names
        else fb.compile(s).forward_dynamics(q, u)
    )
    known = dict(zip((c.symbol for c in e.model.coordinates), q, strict=True))
    known |= dict(zip((x.symbol for x in e.model.speeds), u, strict=True))
    known |= {p.symbol: float(p.default) for p in e.model.parameters}
    lines, coefficients = result.steps
    assert lines and coefficients and coefficients[0][0] == "k_1"
    for name, expression in coefficients:
        known[sympy.Symbol(name, real=True)] = float(sympy.sympify(expression.xreplace(known)))
    atoms = dict(Vocabulary(e).names)
    for name, expression in lines:
        known[atoms[name]] = float(sympy.sympify(expression.xreplace(known)))
    accelerations = [x.acceleration for x in e.model.speeds]
    scale = np.abs(udot).max()
    np.testing.assert_allclose([known[a] for a in accelerations], udot, rtol=0, atol=1e-9 * scale)
    for name in asked:
        ratio = result.ratios[name]
        at = Substitution(e.ring, floats, known)
        assert at(ratio.num) / at(ratio.den) == pytest.approx(known[atoms[name]], rel=1e-6, abs=1e-6 * scale)
    shown = result.text()
    assert len(shown) < 6000 and "\nwhere\n  k_1 = " in shown
    assert r"k_{1} &= " in result.latex() and result.html().count("data-tex") == len(lines) + len(
        coefficients
    )


def closed_four_bar(p):
    """(q, r) at a crank angle, by the law of cosines."""
    way = np.array([3 - np.cos(p), -np.sin(p)])
    r = np.hypot(*way)
    coupler = np.arctan2(way[1], way[0]) + np.arccos((9 + r**2 - 2.5**2) / (6 * r))
    end = np.array([np.cos(p) + 3 * np.cos(coupler) - 3, np.sin(p) + 3 * np.sin(coupler)])
    return coupler - p, np.arctan2(end[1], end[0])


def conditions_at(e, q):
    values = dict(zip((c.symbol for c in e.model.coordinates), q, strict=True))
    values |= {p.symbol: float(p.default) for p in e.model.parameters}
    at = Substitution(e.ring, floats, values)
    rows = [[float(at(x)) for x in row] for row in e.conditions.matrix]
    return [row for row in rows if any(row)]


def test_a_short_answer_has_no_steps(bar) -> None:
    assert bar[0].solve(["theta''", "pin_x"]).steps == ((), ())


# -- roots of degree two ----------------------------------------------------------------------------


def test_fast_and_slow_precession_of_a_top():
    """(A - C) cos θ ψ'² - C φ' ψ' + m g a = 0, with A about the tip."""
    s = fb.System("top")
    A, C, m, a, g = s.parameters(A=0.2, C=0.1, m=1, a=0.3, g=9.81)
    s.gravity = (0, 0, -g)
    across = A - m * a**2
    top = s.body("top", fb.MassProperties(m, (0, 0, a), [[across, 0, 0], [0, across, 0], [0, 0, C]]))
    s.gimbal("tip", s.ground, top, axis="ZXZ", coordinate="psi theta phi")
    e = fb.equations(s)
    found = e.solve(["psi'"], where={"theta''": 0, "theta'": 0})
    lines = [line for line in found.text().splitlines() if line != "or"]
    root = "sqrt(-4*A*a*g*m*cos(theta) + C^2*phi'^2 + 4*C*a*g*m*cos(theta))/(2*(A - C)*cos(theta))"
    assert sorted(lines) == sorted(f"psi' = C*phi'/(2*(A - C)*cos(theta)) {sign} {root}" for sign in "+-")
    theta, phi = s.expression("theta"), s.expression("phi'")
    at = {A: 0.2, C: 0.1, m: 1, a: 0.3, g: 9.81, theta: 0.4, phi: 90.0}
    rates = sorted(float(branch["psi'"].subs(at)) for branch in found.branches)
    assert rates == pytest.approx(
        sorted(np.roots([0.1 * math.cos(0.4), -0.1 * 90, 0.3 * 9.81]).real), rel=1e-12
    )
    assert rates[0] == pytest.approx(0.3 * 9.81 / (0.1 * 90), rel=0.01)  # the slow one: m g a/(C n)


def quadratic_row(*coefficients):
    """Σ c_k v^k = 0, by rising powers, and its ring and symbols."""
    ring = Ring()
    terms = {
        ((("v", k),) if k else ()): Ratio(ring, ring.from_sympy(sympy.sympify(c)))
        for k, c in enumerate(coefficients)
    }
    row = Row("line", {key: c for key, c in terms.items() if c})
    return roots([row], ring, set(), {"v": sympy.Symbol("v", real=True)})


p, r_, c_ = sympy.symbols("p r c", real=True)


@pytest.mark.parametrize(
    ("coefficients", "expected"),
    [
        ((6, -5, 1), {2, 3}),  # the root of the discriminant is a number
        ((p * r_, -p - r_, 1), {p, r_}),  # or a polynomial: (p - r)²
        ((c_**2, -2 * c_, 1), {c_}),  # or zero
        ((-2, 0, 1), {sympy.sqrt(2), -sympy.sqrt(2)}), ((1, -3, 1), {(3 + sympy.sqrt(5)) / 2, (3 - sympy.sqrt(5)) / 2}),
        ((0, -p, 1), {0, p}), ((0, 0, 3), {0}), ((1, 0, 1), set()), ((1, 1, 1), set()), ((-p, 2), {p / 2}),
        ((36, 0, -13, 0, 1), {2, -2, 3, -3}),  # squares of them
        ((-6, 11, -6, 1), {1, 2, 3}), ((-2, 1, -2, 1), {2}),  # by factors
        ((sympy.Rational(-1, 12), sympy.Rational(-1, 12), sympy.S.Half), {sympy.S.Half, sympy.Rational(-1, 3)}),
    ],
    ids=lambda x: str(x) if isinstance(x, tuple) else "roots",  # a set has no order
)  # fmt: skip
def test_roots_of_one_equation(coefficients, expected):
    found = {sympy.simplify(root["v"]) for root in quadratic_row(*coefficients)}
    assert found == {sympy.simplify(x) for x in map(sympy.sympify, expected)}


@pytest.mark.parametrize("seed", range(5))
def test_random_roots_of_degree_two(seed):
    """With symbols in the coefficients, against NumPy's roots at numbers where they are real."""
    rng = np.random.default_rng(seed)
    c = [
        sum(int(k) * x for k, x in zip(rng.integers(-4, 5, 3), (1, p, r_), strict=True)) + sympy.cos(c_)
        for _ in range(3)
    ]
    found = [root["v"] for root in quadratic_row(*c)]
    real = 0
    for place in rng.uniform(-2, 2, (20, 3)):
        at = dict(zip((p, r_, c_), place, strict=True))
        numbers = [float(x.subs(at)) for x in c]
        expected = np.roots(numbers[::-1])
        got = np.array([complex(x.subs(at)) for x in found])
        assert np.sort_complex(got) == pytest.approx(np.sort_complex(expected), rel=1e-9, abs=1e-9)
        real += bool(np.isreal(expected).all())
    assert len(found) == 2 and real
