"""Section 6.6: rotation about a fixed axis and the tilted disk on its shaft, (6.56)-(6.66)."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import cos, sin

import freebody as fb

from ..case import mass_properties
from . import machines
from .statement import Line, Statement, balance, value

t = machines.t
ZERO = sympy.Integer(0)
QUARTER = sympy.Rational(1, 4)


def _axis() -> list[Line]:
    from ...dynamics.kinematics import angular_velocity

    s, e = machines.shaft()
    w = [e.sympy(x) for x in angular_velocity(e.model, e.state, s.bodies["rotor"])]
    names = sympy.symbols("omega_x omega_y omega_z")
    return [value(n, p, d) for n, p, d in zip(names, (ZERO, ZERO, s.names.atoms["theta'"]), w, strict=True)]


def _rotor_moments() -> list[tuple[Any, Any]]:
    """(left, right) of the moment equations about 0, in body axes."""
    _, e = machines.shaft()
    return [(row.lhs, row.rhs) for row in e.free_body("rotor", frame="rotor").equations[3:]]


def _axis_moments() -> list[Line]:
    s, _ = machines.shaft()
    a = s.names.atoms
    w, dw = a["theta'"], a["theta"].diff(t, 2)
    xz, yz, zz = a["I_xz"], a["I_yz"], a["I_zz"]
    printed = [-xz * dw + yz * w**2, -yz * dw - xz * w**2, zz * dw]
    names = sympy.symbols("M_0x M_0y M_0z")
    return [value(n, p, d[1]) for n, p, d in zip(names, printed, _rotor_moments(), strict=True)]


@cache
def _turned() -> tuple[Any, Any, Any]:
    """(angle, a body with any inertia in axes x'y'z', the same in xyz) by the library."""
    beta = sympy.Symbol("beta", real=True)
    names = "I_x'x' I_y'y' I_z'z' I_x'y' I_x'z' I_y'z'"
    xx, yy, zz, xy, xz, yz = (sympy.Symbol(n, real=True) for n in names.split())
    c, d = cos(beta), sin(beta)
    own = fb.MassProperties(1, (0, 0, 0), ((xx, -xy, -xz), (-xy, yy, -yz), (-xz, -yz, zz)))
    return beta, (xx, yy, zz, xy, xz, yz), own.rotated(((1, 0, 0), (0, c, d), (0, -d, c)))


def _transformation() -> list[Line]:
    """Components of a vector in x'y'z', brought into xyz by the same matrix that turned the body."""
    from ...scalar.algebra import apply

    beta, _, _ = _turned()
    x, y, z = (sympy.Symbol(n, real=True) for n in ("x'", "y'", "z'"))
    c, d = cos(beta), sin(beta)
    found = apply(((1, 0, 0), (0, c, d), (0, -d, c)), (x, y, z))
    printed = (x, y * c + z * d, -y * d + z * c)
    return [value(n, p, f) for n, p, f in zip(sympy.symbols("x y z"), printed, found, strict=True)]


def _product_xz() -> list[Line]:
    beta, (_, _, _, xy, xz, _), turned = _turned()
    return [value(sympy.Symbol("I_xz"), -sin(beta) * xy + cos(beta) * xz, turned.products.xz)]


def _product_yz() -> list[Line]:
    beta, (_, yy, zz, _, _, yz), turned = _turned()
    c, d = cos(beta), sin(beta)
    return [value(sympy.Symbol("I_yz"), d * c * (yy - zz) + (c**2 - d**2) * yz, turned.products.yz)]


def _thin_disk() -> list[Line]:
    m, R = sympy.symbols("m R", positive=True)
    J = fb.disk(m, R).inertia
    printed = (m * R**2 / 4, m * R**2 / 4, m * R**2 / 2)
    return [
        value(sympy.Symbol(f"I_{c}'{c}'"), p, J[i][i])
        for i, (c, p) in enumerate(zip("xyz", printed, strict=True))
    ]


@cache
def disk() -> dict[str, Any]:
    """The tilted disk as it turns at a constant rate: its atoms, products of inertia and the shaft's reaction."""
    s, e = machines.tilted_disk()
    a = s.names.atoms
    steady = {a["theta"].diff(t, 2): 0, a["theta'"]: a["omega"]}
    r = e.reactions["shaft"]
    free = e.free_body("disk", frame="disk")

    def put(x: Any) -> Any:
        return sympy.sympify(x).subs(steady)

    return {
        **a,
        "P": mass_properties(s.bodies["disk"]).products,
        "force": [put(x) for x in r.force],
        "body": [put(row.rhs) for row in free.equations[3:]],
        "ground": [put(row.rhs) for row in e.free_body("disk").equations[3:]],
        "W": a["m"] * a["g"],
    }


def _amplitude() -> Any:
    d = disk()
    return QUARTER * d["m"] * d["R"] ** 2 * d["omega"] ** 2 * sin(d["beta"]) * cos(d["beta"])


def _products() -> list[Line]:
    d = disk()
    printed = -QUARTER * d["m"] * d["R"] ** 2 * sin(d["beta"]) * cos(d["beta"])
    return [value(sympy.Symbol("I_xz"), ZERO, d["P"].xz), value(sympy.Symbol("I_yz"), printed, d["P"].yz)]


def _steady_moments() -> list[Line]:
    names = sympy.symbols("M_0x M_0y M_0z")
    return [
        value(n, p, x) for n, p, x in zip(names, (-_amplitude(), ZERO, ZERO), disk()["body"], strict=True)
    ]


def _resolved() -> list[Line]:
    d = disk()
    M = d["body"][0]
    printed = (M * cos(d["theta"]), M * sin(d["theta"]))
    return [value(n, p, x) for n, p, x in zip(sympy.symbols("M_0X M_0Y"), printed, d["ground"], strict=False)]


R = {k: sympy.Symbol(k) for k in ("R_AX", "R_AY", "R_BX", "R_BY")}


def _forces() -> list[Line]:
    d = disk()
    force = d["force"]
    e = machines.tilted_disk()[1]
    row = e.free_body("disk").equations
    ma = [sympy.sympify(row[i].rhs).subs({d["theta"].diff(t, 2): 0}) for i in (0, 1)]
    return [
        balance(R["R_AX"] + R["R_BX"], ZERO, (R["R_AX"] + R["R_BX"] - force[0] + ma[0], ZERO)),
        balance(R["R_AY"] + R["R_BY"] - d["W"], ZERO, (R["R_AY"] + R["R_BY"] - force[1] + ma[1], ZERO)),
    ]


def _moments() -> list[Line]:
    d, half = disk(), disk()["L"] / 2
    A, B = sympy.Matrix([R["R_AX"], R["R_AY"], 0]), sympy.Matrix([R["R_BX"], R["R_BY"], 0])
    moment = sympy.Matrix([0, 0, half]).cross(A - B)
    printed = (
        ((R["R_BY"] - R["R_AY"]) * half, -_amplitude() * cos(d["theta"])),
        ((R["R_AX"] - R["R_BX"]) * half, -_amplitude() * sin(d["theta"])),
    )
    return [balance(*p, (moment[i], d["ground"][i])) for i, p in enumerate(printed)]


def _reactions() -> list[Line]:
    d = disk()
    found = fb.bearing_reactions(machines.tilted_disk()[1], "shaft", at={"A": "L/2", "B": "-L/2"}).ground
    size = _amplitude() / d["L"]
    angle = d["omega"] * t
    put = [(d["theta"].diff(t, 2), 0), (d["theta'"], d["omega"]), (d["theta"], angle)]
    derived = {f"R_{name}{c}": found[name][i].subs(put) for name in "AB" for i, c in enumerate("XY")}
    printed = {
        "R_BX": size * sin(angle),
        "R_AX": -size * sin(angle),
        "R_AY": d["W"] / 2 - size * cos(angle),
        "R_BY": d["W"] / 2 + size * cos(angle),
    }
    return [value(R[k], printed[k], derived[k]) for k in printed]


STATEMENTS = (
    Statement("6.56", "rotation about the fixed axis z", "s.hinge(...)", _axis, defines=True,
              print_is="ω_x = ω_y = 0, ω_z = ω"),
    Statement("6.57", "moments on a body that turns about a fixed axis",
              "fb.equations(s).free_body('rotor', frame='rotor').equations", _axis_moments),
    Statement("6.58", "axes turned by β about x", "scalar.algebra.apply(R, v)", _transformation, defines=True),
    Statement("6.59a", "the product I_xz in turned axes", "MassProperties.rotated(R).products", _product_xz),
    Statement("6.59b", "the product I_yz in turned axes", "MassProperties.rotated(R).products", _product_yz),
    Statement("6.60", "moments of inertia of a thin disk", "fb.disk(m, R).inertia", _thin_disk),
    Statement("6.61", "products of inertia of the tilted disk", "fb.disk(m, R).rotated(R).products", _products),
    Statement("6.62", "moments on the tilted disk at a constant rate, in body axes",
              "fb.equations(s).free_body('disk', frame='disk').equations", _steady_moments),
    Statement("6.63", "the moment resolved along ground axes", "fb.equations(s).free_body('disk').equations",
              _resolved),
    Statement("6.64", "force equations of the tilted disk", "fb.equations(s).free_body('disk'), .reactions['shaft']",
              _forces),
    Statement("6.65", "moments of the bearing reactions about 0", "fb.equations(s).free_body('disk').equations",
              _moments),
    Statement("6.66", "bearing reactions on the shaft at a constant rate",
              "fb.bearing_reactions(s, 'shaft', at={'A': 'L/2', 'B': '-L/2'}).ground",
              _reactions),
)  # fmt: skip
