"""Section 6.6: rotation about a fixed axis and the tilted disk on its shaft, (6.56)-(6.66)."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy
from sympy import cos, sin

import freebody as fb

from ..gallery.tools.case import mass_properties
from . import machines
from .meaning import Meaning
from .momentum import resolved
from .small import put
from .statement import Statement

t = machines.t


def _axis() -> Meaning:
    """The body on its shaft: ω and the moments about 0 in body axes."""
    machine = machines.shaft()
    _, moment = machine.balances("rotor", frame="rotor")
    return Meaning({**machine.names, **resolved("ω_x ω_y ω_z", machine.omega("rotor")), "ω": machine.atoms["theta'"],
                    **resolved("M_0x M_0y M_0z", moment)})  # fmt: skip


@cache
def turned() -> Meaning:
    """Two particles in axes x'y'z', and the same body turned into xyz by the library."""
    beta = sympy.Symbol("beta", real=True)
    c, d = cos(beta), sin(beta)
    matrix = ((1, 0, 0), (0, c, d), (0, -d, c))
    whole, elements = None, []
    for i in (1, 2):
        m = sympy.Symbol(f"m_{i}", positive=True)
        own = sympy.symbols(f"x_{i}' y_{i}' z_{i}'", real=True)
        one = fb.particle(m).moved(own)
        whole = one if whole is None else whole + one
        place = one.rotated(matrix).center
        elements.append((m, {"x'": own[0], "y'": own[1], "z'": own[2], "r'": sympy.Matrix(own),
                             **resolved("x y z", place)}))  # fmt: skip
    assert whole is not None
    J, P, Q = (
        whole.about((0, 0, 0)),
        whole.products_about((0, 0, 0)),
        whole.rotated(matrix).products_about((0, 0, 0)),
    )
    names = {
        **elements[0][1],
        "β": beta,
        "I_xz": Q.xz,
        "I_yz": Q.yz,
        "I_x'y'": P.xy,
        "I_x'z'": P.xz,
        "I_y'z'": P.yz,
    }
    return Meaning({**names, **{f"I_{c}'{c}'": J[i][i] for i, c in enumerate("xyz")}}, elements)


def _thin_disk() -> Meaning:
    m, R = sympy.symbols("m R", positive=True)
    J = fb.disk(m, R).inertia
    return Meaning({"m": m, "R": R, **{f"I_{c}'{c}'": J[i][i] for i, c in enumerate("xyz")}})


@cache
def disk() -> Meaning:
    """The tilted disk at a constant rate: moments in its own and in ground axes, and bearing reactions."""
    machine = machines.tilted_disk()
    a = machine.atoms
    steady = ((a["theta"].diff(t, 2), 0), (a["theta'"], a["omega"]))
    reactions = fb.bearing_reactions(machine.equations, "shaft", at={"A": "L/2", "B": "-L/2"}).ground
    products = mass_properties(machine.body("disk")).products
    force, ground = machine.balances("disk")
    _, own = machine.balances("disk", frame="disk")
    values: dict[str, Any] = {
        **{f"R_{name}{c}": reactions[name][i] for name in "AB" for i, c in enumerate("XY")},
        **resolved("F_X F_Y", force[:2]), **resolved("M_0X M_0Y", ground[:2]), **resolved("M_0x M_0y M_0z", own),
        "I_xz": products.xz, "I_yz": products.yz, "W": a["m"] * a["g"],
    }  # fmt: skip
    return Meaning({**machine.names, **{name: put(x, steady) for name, x in values.items()}})


def _in_time() -> Meaning:
    names = disk().names
    theta, omega = names["θ"], names["ω"]
    return Meaning({**{k: put(v, [(theta, omega * t)]) for k, v in names.items()}, "t": t})


OWN = "fb.equations(s).free_body('disk', frame='disk').equations"
GROUND = "fb.equations(s).free_body('disk').equations"
BEARINGS = "fb.bearing_reactions(s, 'shaft', at={'A': 'L/2', 'B': '-L/2'}).ground"
STATEMENTS = (
    Statement("6.56", "rotation about the fixed axis z", "dynamics.kinematics.angular_velocity of a body on a hinge",
              ("ω_x = ω_y = 0", "ω_z = ω"), _axis, defines=True),
    Statement("6.57", "moments on a body that turns about a fixed axis",
              "fb.equations(s).free_body('rotor', frame='rotor').equations",
              ("M_0x = -I_xz ω' + I_yz ω^2", "M_0y = -I_yz ω' - I_xz ω^2", "M_0z = I_zz ω'"), _axis),
    Statement("6.58", "axes turned by β about x", "MassProperties.rotated(R).center",
              ("x = x'", "y = y' cos β + z' sin β", "z = -y' sin β + z' cos β"), turned, defines=True),
    Statement("6.59a", "the product I_xz in turned axes", "MassProperties.rotated(R).products_about((0, 0, 0))",
              "I_xz = ∫ x z dm = ∫ x' (-y' sin β + z' cos β) dm = -sin β ∫ x' y' dm + cos β ∫ x' z' dm"
              " = -sin β I_x'y' + cos β I_x'z'", turned),
    Statement("6.59b", "the product I_yz in turned axes", "MassProperties.rotated(R).products_about((0, 0, 0))",
              "I_yz = ∫ y z dm = ∫ (y' cos β + z' sin β) (-y' sin β + z' cos β) dm"
              " = sin β cos β ∫ (z'^2 - y'^2) dm + (cos^2 β - sin^2 β) ∫ y' z' dm"
              " = sin β cos β ∫ [(r'^2 - y'^2) - (r'^2 - z'^2)] dm + (cos^2 β - sin^2 β) ∫ y' z' dm"
              " = sin β cos β (I_y'y' - I_z'z') + (cos^2 β - sin^2 β) I_y'z'", turned),
    Statement("6.60", "moments of inertia of a thin disk", "fb.disk(m, R).inertia",
              ("I_x'x' = I_y'y' = 1/4 m R^2", "I_z'z' = 1/2 m R^2"), _thin_disk),
    Statement("6.61", "products of inertia of the tilted disk", "fb.disk(m, R).rotated(R).products",
              ("I_xz = 0", "I_yz = -1/4 m R^2 sin β cos β"), disk),
    Statement("6.62", "moments on the tilted disk at a constant rate, in body axes", OWN,
              ("M_0x = I_yz ω^2 = -1/4 m R^2 ω^2 sin β cos β", "M_0y = 0", "M_0z = 0"), disk),
    Statement("6.63", "the moment resolved along ground axes", OWN + "; " + GROUND,
              ("M_0X = M_0x cos θ", "M_0Y = M_0x sin θ"), disk),
    Statement("6.64", "force equations of the tilted disk", GROUND + "; " + BEARINGS,
              ("F_X = R_AX + R_BX = 0", "F_Y = R_AY + R_BY - W = 0"), disk),
    Statement("6.65", "moments of the bearing reactions about 0", GROUND + "; " + BEARINGS,
              ("M_0X = (R_BY - R_AY) L/2 = -1/4 m R^2 ω^2 sin β cos β cos θ",
               "M_0Y = (R_AX - R_BX) L/2 = -1/4 m R^2 ω^2 sin β cos β sin θ"), disk),
    Statement("6.66", "bearing reactions on the shaft at a constant rate", BEARINGS,
              ("R_BX = -R_AX = 1/4 m R^2 ω^2/L sin β cos β sin(ω t)",
               "R_AY = 1/2 W - 1/4 m R^2 ω^2/L sin β cos β cos(ω t)",
               "R_BY = 1/2 W + 1/4 m R^2 ω^2/L sin β cos β cos(ω t)"), _in_time),
)  # fmt: skip
