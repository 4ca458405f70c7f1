"""The free-body equations of one body: what acts on it, by name, and the six equations."""

from __future__ import annotations

import pytest
import sympy
from sympy import cos, sin

import freebody as fb
from freebody.describe.description import parameters_of
from freebody.errors import ModelError


@pytest.fixture
def crane():
    """A trolley on rails, a rod with a load at its end: spring, damper, motor, force and couple."""
    s = fb.System("crane")
    M, m, L, g, k, c, F, T, P = s.parameters("M m L g k c F T P")
    s.gravity = (0, -g, 0)
    trolley = s.body("trolley", fb.box(M, (1, 1, 1)))
    rod = s.body("rod", fb.slender_bar(m, L, axis="y"))
    rails = s.slider("rails", s.ground, trolley, coordinate="x")
    pin = s.hinge("pin", trolley, rod, at=(0, -1, 0), to=(0, L / 2, 0), coordinate="theta")
    s.spring("k", trolley.point(1, 0, 0), s.ground.point(5, 0, 0), stiffness=k, rest=2)
    s.damper("c", pin, damping=c)
    s.torque("motor", pin, T)
    s.force("drive", rails, P)
    s.force("F", rod.point(0, -L / 2, 0), (0, F, 0), frame=rod)
    s.torque("couple", rod, (0, 0, "7"), reaction_on=trolley)
    return s, fb.equations(s)


def names(body):
    return [action.name for action in body.actions]


def test_every_action_has_its_name_kind_and_cause(crane):
    _, eq = crane
    body = eq.free_body("rod")
    assert names(body) == [
        "weight",
        "c",
        "motor",
        "F",
        "couple",
        "pin_x",
        "pin_y",
        "pin_z",
        "pin_Mx",
        "pin_My",
    ]
    kinds = {a.name: (a.kind, a.by) for a in body.actions}
    assert kinds["weight"] == ("weight", "gravity")
    assert kinds["c"] == ("damper", "joint 'pin'")
    assert kinds["motor"] == ("motor", "joint 'pin'")
    assert kinds["F"] == ("load", "")
    assert kinds["pin_x"] == ("reaction", "joint 'pin', trolley")
    trolley = eq.free_body("trolley")
    assert names(trolley)[:6] == ["weight", "k", "c", "motor", "drive", "couple"]
    assert {a.name: a.by for a in trolley.actions}["pin_x"] == "joint 'pin', rod"


def test_action_and_reaction_are_opposite(crane):
    s, eq = crane
    pin = s.bodies["trolley"].point(0, -1, 0)
    rod, trolley = (eq.free_body(name, about=pin) for name in ("rod", "trolley"))
    for name in ("pin_x", "pin_y", "pin_z"):
        assert rod.forces[name] == -trolley.forces[name]
        assert name not in rod.moments and name not in trolley.moments  # they act at the point
    for name in ("c", "motor", "couple", "pin_Mx", "pin_My"):
        assert rod.moments[name] == -trolley.moments[name]


def test_loads_have_their_size_and_place(crane):
    s, eq = crane
    M, m, L, g, k, c, F, T, P = (p.symbol for p in parameters_of(s))
    x, theta = eq.coordinates
    rod, trolley = eq.free_body("rod"), eq.free_body("trolley")
    assert rod.forces["F"] == sympy.ImmutableMatrix([-F * sin(theta), F * cos(theta), 0])
    assert rod.moments["c"] == sympy.ImmutableMatrix([0, 0, -c * theta.diff(s.t)])
    assert rod.moments["motor"][2] == T
    assert rod.moments["couple"][2] == 7
    assert trolley.forces["drive"] == sympy.ImmutableMatrix([P, 0, 0])
    assert "weight" not in rod.moments  # about the mass centre
    length = sympy.sqrt((4 - x) ** 2)
    tension = trolley.forces["k"][0] / (k * (length - 2) * (4 - x) / length)
    assert abs(tension.subs({x: sympy.Rational(1, 3), k: 5}).evalf(30) - 1) < 1e-28


def test_weight_is_left_out_without_gravity_or_mass():
    s = fb.System("space")
    frame = s.body("frame", fb.MassProperties(0, (0, 0, 0), ((0, 0, 0),) * 3))
    tip = s.body("tip", fb.particle(1))
    s.hinge("a", s.ground, frame)
    s.slider("b", frame, tip)
    assert "weight" not in names(fb.equations(s).free_body("tip"))
    s.gravity = (0, -1, 0)
    eq = fb.equations(s)
    assert "weight" in names(eq.free_body("tip")) and "weight" not in names(eq.free_body("frame"))


def test_a_body_without_mass_passes_forces_on():
    s = fb.System("strut")
    m = s.parameters("m")
    strut = s.body("strut", fb.MassProperties(0, (0, 0, 0), ((0, 0, 0),) * 3))
    s.hinge("a", s.ground, strut)
    s.weld("b", strut, s.body("tip", fb.particle(m)), at=(1, 0, 0))
    body = fb.equations(s).free_body("strut")
    assert all(equation.rhs == 0 for equation in body.equations)


def test_the_user_may_call_a_force_weight_and_a_parameter_as_a_reaction():
    """Names of the user come first; ours step aside."""
    s = fb.System("names")
    pin_x = s.parameters("pin_x")
    s.gravity = (0, -10, 0)
    bar = s.body("bar", fb.slender_bar(2, 1))
    s.hinge("pin", s.ground, bar)
    s.force("weight", bar, (pin_x, 0, 0))
    s.force("pin_y", bar, (0, 1, 0))
    eq = fb.equations(s)
    body = eq.free_body("bar")
    assert names(body)[:5] == ["gravity", "weight", "pin_y", "pin_x_", "pin_y_"]
    assert body.equations[0].lhs == pin_x + sympy.Symbol("pin_x_", real=True)
    assert list(eq.reactions["pin"].components)[:2] == ["pin_x_", "pin_y_"]


def test_components_along_a_frame(crane):
    s, eq = crane
    theta = eq.coordinates[1]
    R = sympy.Matrix([[cos(theta), -sin(theta), 0], [sin(theta), cos(theta), 0], [0, 0, 1]])
    ground, body = eq.free_body("rod"), eq.free_body("rod", frame="rod")
    assert (ground.frame, body.frame) == ("ground", "rod")
    for name, force in ground.forces.items():
        assert sympy.simplify(sympy.Matrix(force) - R * sympy.Matrix(body.forces[name])) == sympy.zeros(3, 1)
    assert body.forces["F"] == sympy.ImmutableMatrix([0, s.expression("F"), 0])
    trolley = eq.free_body("rod", frame=s.bodies["trolley"])  # it does not turn
    assert trolley.equations == ground.equations


def test_moments_about_a_moving_point_have_no_extra_terms(crane):
    """About any P: Σ M_P = dH_C/dt + r_PC x m a_C, also when P is the end of the rod."""
    s, eq = crane
    m, L = s.expression("m"), s.expression("L")
    end = s.bodies["rod"].point(0, -L / 2, 0)
    at_C, at_end = eq.free_body("rod"), eq.free_body("rod", about=end)
    assert at_end.about == "point (0, -L/2, 0) of rod"
    assert "F" not in at_end.moments
    theta = eq.coordinates[1]
    arm = sympy.Matrix([-sin(theta) * L / 2, cos(theta) * L / 2, 0])  # from the end to C
    for side in ("lhs", "rhs"):
        force = sympy.Matrix([getattr(e, side) for e in at_C.equations[:3]])
        moment = sympy.Matrix([getattr(e, side) for e in at_C.equations[3:]])
        other = sympy.Matrix([getattr(e, side) for e in at_end.equations[3:]])
        difference = [eq.ring.from_sympy(z) for z in other - moment - arm.cross(force)]
        assert difference == [0, 0, 0]
    assert at_end.equations[5].rhs.has(m)


def test_a_body_stands_for_its_origin(crane):
    s, eq = crane
    rod = s.bodies["rod"]
    assert eq.free_body(rod, about=rod).equations == eq.free_body("rod").equations


def test_text_lists_actions_and_equations(crane):
    _, eq = crane
    lines = eq.free_body("rod", frame="rod").text().splitlines()
    assert lines[0] == (
        "Free body 'rod': planar, components along x, y of rod axes, moments about its mass centre C along z"
    )
    assert lines[1].split() == ["weight", "force", "(-m*g*sin(theta),", "-m*g*cos(theta))", "[gravity]"]
    assert any(line.strip().startswith("force x:  ") for line in lines)
    assert any(line.strip().startswith("moment z:  ") for line in lines)
    assert sum(" = " in line for line in lines) == 3
    assert lines[-1].split(":") == ["  out of the plane, zero", "  pin_z, pin_Mx, pin_My"]
    assert repr(eq.free_body("rod")) == eq.free_body("rod").text()


def test_equations_of_nothing_are_not_printed():
    s = fb.System("point")
    s.slider("rail", s.ground, s.body("bead", fb.particle("2")), axis="x", coordinate="x")
    body = fb.equations(s).free_body("bead")
    text = body.text()
    assert "force x:  0 = 2*x''" in text
    latex = body.latex()
    assert latex.count(" &= ") == text.count(" = ")
    assert body._repr_latex_() == f"$\\displaystyle {latex}$"
    assert len(body.equations) == 6


def test_a_generalized_force_is_a_load_along_the_joint():
    s = fb.System("wheel")
    J, T = s.parameters("J T")
    wheel = s.body("wheel", fb.MassProperties(1, (0, 0, 0), ((J, 0, 0), (0, J, 0), (0, 0, J))))
    s.hinge("axle", s.ground, wheel, coordinate="theta")
    s.generalized_force("theta", T, name="Q")
    body = fb.equations(s).free_body("wheel")
    assert body.moments["Q"] == sympy.ImmutableMatrix([0, 0, T])
    assert body.equations[5].lhs == T


def test_free_body_at_values_that_a_contact_keeps():
    """A disk on a corner: with x = y = 0 the directions of N and T are those of the line of centres."""
    s = fb.System("disk on a corner")
    m, R, g = s.parameters(m=3, R=0.25, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, to=(0, -R, 0), coordinate="x y theta")
    s.contact("O", disk.circle(R), s.ground.point(0, 0, 0), friction=1)
    whole = fb.equations(s, modes={"O": "stick"}).free_body("disk")
    held = {name + dots: 0 for name in "xy" for dots in ("", "'", "''")}
    kept = whole.at(held)
    assert (
        "force x:  -N_O*sin(theta) + T_O*cos(theta) = m*R*(theta'^2*sin(theta) - theta''*cos(theta))"
        in kept.text()
    )
    assert "moment z:  R*T_O = m*R^2*theta''/2" in kept.text()
    # the same numbers as the whole equations there
    for mine, full in zip(kept.equations, whole.equations, strict=True):
        put = {whole._e.model.names.atoms[name]: 0 for name in ("x", "y")}
        put |= {
            symbol: 0 for speed in whole._e.model.speeds[:2] for symbol in (speed.symbol, speed.acceleration)
        }
        left = (full.lhs - full.rhs).xreplace(put) - (mine.lhs - mine.rhs)
        assert sympy.simplify(left.subs(R, sympy.Rational(1, 4))) == 0
    assert "T_O " not in whole.at({**held, "T_O": 0}).text()
    with pytest.raises(
        ModelError, match="Unknown coordinate, speed or reaction 'thetta'; did you mean 'theta'"
    ):
        whole.at({"thetta": 0})
