"""Section 6.5: planar motion, (6.38)-(6.55), without its examples."""

from __future__ import annotations

from typing import Any

import sympy

from ..case import mass_properties
from . import machines
from .statement import Line, Statement, balance, value

t = machines.t
ZERO = sympy.Integer(0)


def _atoms() -> dict[str, Any]:
    """Of the lamina: coordinates, speeds, accelerations and parameters by name."""
    s, _ = machines.lamina()
    a = dict(s.names.atoms)
    for q in ("x", "y", "theta"):
        a[q + "''"] = a[q].diff(t, 2)
    return a


def _show(v: Any) -> Any:
    _, e = machines.lamina()
    return sympy.Matrix([e.sympy(x) for x in v])


def _kinematics() -> dict[str, Any]:
    """Of C and of the point A at (a, b) in the body's axes, seen from C: places, velocities, accelerations; ω, α."""
    from ...dynamics.kinematics import angular_velocity, point_acceleration, point_position, point_velocity

    s, e = machines.lamina()
    a = _atoms()
    body = s.bodies["lamina"]
    A = body.point(a["a"], a["b"], 0)
    w = _show(angular_velocity(e.model, e.state, body))
    return {
        "r_A": _show(point_position(e.model, e.state, A)),
        "r_C": _show(point_position(e.model, e.state, body.origin)),
        "v_C": _show(point_velocity(e.model, e.state, body.origin)),
        "a_A": _show(point_acceleration(e.model, e.state, A, e.udot)),
        "a_C": _show(e.center_acceleration("lamina")),
        "omega": w,
        "alpha": w.diff(t),
        "A": A,
    }


def _plane() -> list[Line]:
    k = _kinematics()
    return [value(sympy.Symbol("v_z"), ZERO, k["v_C"][2]), value(sympy.Symbol("a_z"), ZERO, k["a_C"][2])]


def _rates() -> list[Line]:
    k, a = _kinematics(), _atoms()
    names = sympy.symbols("omega_x omega_y alpha_x alpha_y")
    found = (k["omega"][0], k["omega"][1], k["alpha"][0], k["alpha"][1])
    rows = [value(n, ZERO, x) for n, x in zip(names, found, strict=True)]
    return [*rows, value(sympy.Symbol("omega_z"), a["theta'"], k["omega"][2])]


def _products() -> list[Line]:
    """A body without extent along z: the products with z vanish, whatever its other elements."""
    import freebody as fb

    mass = fb.particle(sympy.Symbol("m_1", positive=True)).moved((*sympy.symbols("x_1 y_1"), 0))
    mass += fb.particle(sympy.Symbol("m_2", positive=True)).moved((*sympy.symbols("x_2 y_2"), 0))
    P = mass.products_about((0, 0, 0))
    return [value(sympy.Symbol("I_xz"), ZERO, P.xz), value(sympy.Symbol("I_yz"), ZERO, P.yz)]


def _rows() -> tuple[Any, ...]:
    _, e = machines.lamina()
    return tuple((row.lhs, row.rhs) for row in e.free_body("lamina").planar_equations)


def _no_turn() -> dict[Any, Any]:
    a = _atoms()
    return {a["theta''"]: 0, a["theta'"]: 0}


def _still(pair: tuple[Any, Any]) -> tuple[Any, Any]:
    put = _no_turn()
    return tuple(sympy.sympify(x).subs(put) for x in pair)


def _translation() -> list[Line]:
    """Every point has the acceleration of C where the body does not turn."""
    k = _kinematics()
    put = _no_turn()
    return [value(sympy.Symbol(f"a_A{c}"), k["a_C"][i], k["a_A"][i].subs(put)) for i, c in enumerate("xy")]


def _force(i: int) -> list[Line]:
    a = _atoms()
    name, q = (("F_x", "x''"), ("F_y", "y''"))[i]
    return [balance(a[name], a["m"] * a[q], _still(_rows()[i]))]


def _moment_of_translation() -> list[Line]:
    return [balance(_atoms()["M_Cz"], ZERO, _still(_rows()[2]))]


def _energy(put: Any = None) -> Any:
    _, e = machines.lamina()
    return sympy.sympify(e.energy.kinetic).subs(put or {})


def _hinged() -> tuple[Any, dict[str, Any], Any]:
    s, e = machines.hinged()
    return e, s.names.atoms, s.names.atoms["I_C"] + s.names.atoms["m"] * s.names.atoms["e"] ** 2


def _angular_momentum() -> list[Line]:
    e, a, I_0 = _hinged()
    return [value(sympy.Symbol("H_0"), I_0 * a["theta'"], e.momentum.angular()[2])]


def _moment_about_0() -> list[Line]:
    e, a, I_0 = _hinged()
    row = e.motion[0]
    return [balance(a["M_0"], I_0 * a["theta"].diff(t, 2), (row.rhs, row.lhs) if row.rhs.has(a["M_0"]) else
                    (row.lhs, row.rhs))]  # fmt: skip


def _hinged_energy() -> list[Line]:
    e, a, I_0 = _hinged()
    return [value(sympy.Symbol("T"), I_0 * a["theta'"] ** 2 / 2, e.energy.kinetic)]


def _moment_about_C() -> list[Line]:
    a = _atoms()
    return [balance(a["M_Cz"], a["I_C"] * a["theta''"], _rows()[2])]


def _planar_energy() -> list[Line]:
    a = _atoms()
    printed = a["m"] * (a["x'"] ** 2 + a["y'"] ** 2) / 2 + a["I_C"] * a["theta'"] ** 2 / 2
    return [value(sympy.Symbol("T"), printed, _energy())]


def _form() -> tuple[Any, Any, dict[str, Any]]:
    """The moment form about A: (Σ M_A as given by the forces, the terms, the kinematics)."""
    _, e = machines.lamina()
    k = _kinematics()
    form = e.free_body("lamina").moment_form(k["A"])
    return form, e, k


def _shifted_moment() -> list[Line]:
    """M_A = ρ_AC × F + M_C of the loads, against the sum that the library takes about A."""
    form, e, k = _form()
    a = _atoms()
    rho = k["r_C"] - k["r_A"]
    force = sympy.Matrix([a["F_x"], a["F_y"], 0])
    printed = rho.cross(force)[2] + a["M_Cz"]
    return [value(sympy.Symbol("M_Az"), printed, e.sympy(form.moments[2]))]


def _with_acceleration() -> list[Line]:
    form, e, k = _form()
    a = _atoms()
    rho = k["r_C"] - k["r_A"]
    printed = rho.cross(a["m"] * k["a_C"])[2] + a["I_C"] * a["theta''"]
    return [balance(e.sympy(form.moments[2]), printed, _sympy(e, form.balances[2]))]


def _sympy(e: Any, pair: tuple[Any, Any]) -> tuple[Any, Any]:
    return e.sympy(pair[0]), e.sympy(pair[1])


def _centre_couple() -> list[Line]:
    _, e = machines.lamina()
    a = _atoms()
    rate = e.free_body("lamina").momentum_rate
    return [value(sympy.Symbol("M_Cz"), a["I_C"] * a["theta''"], e.sympy(rate[2]))]


def _relative() -> list[Line]:
    k = _kinematics()
    relative = (k["r_C"] - k["r_A"]).diff(t, 2)
    return [value(sympy.Symbol(f"a_C{c}"), (k["a_A"] + relative)[i], k["a_C"][i]) for i, c in enumerate("xy")]


def _relative_by_rotation() -> list[Line]:
    k, a = _kinematics(), _atoms()
    rho = k["r_C"] - k["r_A"]
    printed = k["a_A"] - a["theta'"] ** 2 * rho + k["alpha"].cross(rho)
    return [value(sympy.Symbol(f"a_C{c}"), printed[i], k["a_C"][i]) for i, c in enumerate("xy")]


def _about_any_point() -> list[Line]:
    form, e, k = _form()
    a = _atoms()
    rho = k["r_C"] - k["r_A"]
    I_A = a["I_C"] + a["m"] * (a["a"] ** 2 + a["b"] ** 2)
    printed = rho.cross(a["m"] * k["a_A"])[2] + I_A * a["theta''"]
    return [balance(e.sympy(form.moments[2]), printed, _sympy(e, form.balances[2]))]


def _parallel_axis() -> list[Line]:
    s, _ = machines.lamina()
    a = _atoms()
    mass = mass_properties(s.bodies["lamina"])
    found = mass.about((a["a"], a["b"], 0))[2][2]
    return [value(sympy.Symbol("I_A"), a["I_C"] + a["m"] * (a["a"] ** 2 + a["b"] ** 2), found)]


BODY = "fb.equations(s).free_body('lamina')"
STATEMENTS = (
    Statement("6.38a", "motion in the plane xy: no velocity or acceleration along z", "s.planar(...)", _plane,
              defines=True, print_is="v_z = a_z = 0"),
    Statement("6.38b", "motion in the plane xy: the body turns about z only", "s.planar(...)", _rates, defines=True,
              print_is="ω_x = ω'_x = ω_y = ω'_y = 0, ω_z = ω"),
    Statement("6.39", "no products of inertia with z of a body that is thin along z",
              "MassProperties.products_about((0, 0, 0))", _products),
    Statement("6.40", "pure translation: the acceleration is that of C at every point",
              "dynamics.kinematics.point_acceleration at θ' = θ'' = 0", _translation, defines=True,
              print_is="ω = ω' = 0"),
    Statement("6.41a", "force equation along x", f"{BODY}.planar_equations", lambda: _force(0)),
    Statement("6.41b", "force equation along y", f"{BODY}.planar_equations", lambda: _force(1)),
    Statement("6.42", "no moment about C in pure translation", f"{BODY}.planar_equations", _moment_of_translation),
    Statement("6.43", "kinetic energy of pure translation", "fb.equations(s).energy.kinetic",
              lambda: [value(sympy.Symbol("T"), _atoms()["m"] * (_atoms()["x'"] ** 2 + _atoms()["y'"] ** 2) / 2,
                             _energy(_no_turn()))]),
    Statement("6.44", "angular momentum about a fixed point, planar; I_0 = I_C + m e²",
              "fb.equations(s).momentum.angular()", _angular_momentum, print_is="H_0 = I_0 ω"),
    Statement("6.45", "moment about a fixed point, planar", "fb.equations(s).motion of a body on a hinge",
              _moment_about_0, print_is="M_0 = I_0 α"),
    Statement("6.46", "kinetic energy of rotation about a fixed point", "fb.equations(s).energy.kinetic",
              _hinged_energy, print_is="T = 1/2 I_0 ω²"),
    Statement("6.47", "moment about the mass centre, planar", f"{BODY}.planar_equations", _moment_about_C,
              print_is="M_C = I_C α"),
    Statement("6.48", "kinetic energy of planar motion", "fb.equations(s).energy.kinetic", _planar_energy),
    Statement("6.49", "the moment about any point A", f"{BODY}.moment_form(A).moments", _shifted_moment,
              print_is="M_A = ρ_AC × F + M_C"),
    Statement("6.50", "the moment about A in the acceleration of C", f"{BODY}.moment_form(A)", _with_acceleration,
              print_is="M_A = ρ_AC × m a_C + M_C"),
    Statement("6.51", "the couple about C, planar", f"{BODY}.momentum_rate", _centre_couple, print_is="M_C = I_C α"),
    Statement("6.52", "the acceleration of C from that of A", "dynamics.kinematics.point_acceleration", _relative,
              print_is="a_C = a_A + a_C/A"),
    Statement("6.53", "the same in ω and α", "dynamics.kinematics.point_acceleration", _relative_by_rotation,
              print_is="a_C = a_A - ω² ρ_AC + α × ρ_AC"),
    Statement("6.54", "the moment about A in the acceleration of A", f"{BODY}.moment_form(A)", _about_any_point,
              print_is="M_A = ρ_AC × m a_A + I_A α"),
    Statement("6.55", "moment of inertia about A (parallel axes)", "MassProperties.about(point)", _parallel_axis),
)  # fmt: skip
