"""Section 6.2: linear and angular momentum, (6.1)-(6.19)."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy

import freebody as fb

from ..gallery.tools.case import mass_properties
from . import machines
from .meaning import Meaning
from .statement import Statement


def vector(*components: Any) -> Any:
    """Return a triple as a SymPy column."""
    return sympy.Matrix(components)


def triple(name: str) -> Any:
    """Return an arbitrary vector: a column of three symbols."""
    return sympy.Matrix([sympy.Symbol(f"{name}_{c}", real=True) for c in "xyz"])


def resolved(names: str, components: Any) -> dict[str, Any]:
    """Return components by the chapter's names for them: ``"ω_x ω_y ω_z"``."""
    return dict(zip(names.split(), components, strict=True))


@cache
def about_0() -> Meaning:
    """The body about the fixed point 0: H_0, ω and each element's place and velocity, by the library's kinematics."""
    machine, _, parts = machines.pivoted()
    elements = []
    for mass, place in parts:
        point = machine.point("body", *place)
        elements.append((mass, {"r": machine.place(point), "v": machine.velocity(point)}))
    return Meaning({"H_0": machine.momentum(), "ω": machine.omega("body"), **elements[0][1]}, elements)


def _triple_product() -> Meaning:
    return Meaning({name: triple(name) for name in "ABC"})


def _position() -> Meaning:
    """The first particle of the turning body: its position in ground axes and along body axes."""
    machine, _, parts = machines.pivoted()
    own = parts[0][1]
    return Meaning({"r": machine.place(machine.point("body", *own)), **dict(zip("xyz", own, strict=True)),
                    **machine.frame("body")})  # fmt: skip


def body_rates(machine: machines.Machine, axes: str = "xyz") -> dict[str, Any]:
    """Return the parameters of a machine on a ball joint, and its speeds as ω_x, ω_y, ω_z along body axes."""
    parameters = {name: x for name, x in machine.names.items() if x.is_Symbol}
    return {
        **parameters,
        **{f"ω_{k}": machine.atoms[f"omega_w{c}"] for k, c in zip(axes, "xyz", strict=True)},
    }


def _rotation() -> Meaning:
    machine = machines.ball()
    return Meaning({"ω": machine.omega("body"), **body_rates(machine), **machine.frame("body")})


def _integrand() -> Meaning:
    x, y, z = sympy.symbols("x y z", real=True)
    omega = triple("omega")
    axes = {name: vector(*axis) for name, axis in zip("ijk", machines.AXES, strict=True)}
    return Meaning({"r": vector(x, y, z), "x": x, "y": y, "z": z, "ω": omega,
                    **resolved("ω_x ω_y ω_z", omega), **axes})  # fmt: skip


def _by_components() -> Meaning:
    machine = machines.ball()
    return Meaning({**body_rates(machine), "H_0": machine.momentum(), **machine.frame("body")})


def _inertia() -> Meaning:
    """Entries of the library's inertia matrix, and its products of inertia; elements of mass by their places."""
    _, whole, parts = machines.pivoted()
    J, P = whole.about((0, 0, 0)), whole.products_about((0, 0, 0))
    names = {f"I_{c}{c}": J[i][i] for i, c in enumerate("xyz")}
    names |= {"I_xy": P.xy, "I_xz": P.xz, "I_yz": P.yz, "I_yx": -J[1][0], "I_zx": -J[2][0], "I_zy": -J[2][1]}
    elements = [(m, {"r": vector(*r), **dict(zip("xyz", r, strict=True))}) for m, r in parts]
    return Meaning(names, elements)


@cache
def flight() -> Meaning:
    """The free body: positions from 0, and from the library's mass centre C along body axes."""
    machine, whole, parts = machines.flying()
    units = machine.units("body")
    C = machine.point("body", *whole.center)
    elements = []
    for mass, place in parts:
        point = machine.point("body", *place)
        own = sum(
            ((x - c) * u for x, c, u in zip(place, whole.center, units, strict=True)), sympy.zeros(3, 1)
        )
        elements.append((mass, {"r": machine.place(point), "v": machine.velocity(point), "ρ": own}))
    momentum = sympy.Matrix(machine.equations.momentum.linear)
    apparent = sum((m * e["ρ"].cross(e["v"] - machine.velocity(C)) for m, e in elements), sympy.zeros(3, 1))
    names = {
        **elements[0][1], "m": whole.mass, "r_C": machine.place(C), "v_C": machine.velocity(C), "p": momentum,
        "dp/dt": momentum.diff(machines.t), "ω": machine.omega("body"), "H_0": machine.momentum(),
        "H_C": machine.momentum(C), "H'_C": apparent,
        "T": machine.kinetic, "a_C": machine.acceleration(C), **machine.frame("body"),
    }  # fmt: skip
    return Meaning(names, elements)


@cache
def split() -> Meaning:
    """The same with any point of the body in place of C: the parts hold for any split of r."""
    machine, _, parts = machines.flying()
    P = machine.point("body", *(machine.atoms[c] for c in "abc"))
    r, v = machine.place(P), machine.velocity(P)
    elements = [(m, {"ρ": machine.place(machine.point("body", *place)) - r}) for m, place in parts]
    return Meaning({**flight().names, "r_C": r, "v_C": v}, elements)


def mass_of_flight() -> Any:
    """Return the mass properties of the free body from the system."""
    return mass_properties(machines.flying()[0].body("body"))


def angular_momentum(inertia: Any, omega: Any) -> Any:
    """Return H along body axes by the library's form."""
    return sympy.Matrix(fb.forms.angular_momentum(inertia, tuple(omega)))


KINEMATICS = "dynamics.kinematics.point_velocity"
ANGULAR = "fb.equations(s).momentum.angular()"
STATEMENTS = (
    Statement("6.1", "the angular momentum about 0 is the moment of the momenta of all elements of mass", ANGULAR,
              "H_0 = ∫ r × v dm", about_0, defines=True),
    Statement("6.2", "velocity of a point of a body that turns about 0", KINEMATICS, "v = ω × r", about_0),
    Statement("6.3", "the angular momentum about 0 in the angular velocity", ANGULAR, "H_0 = ∫ r × (ω × r) dm",
              about_0),
    Statement("6.4", "the vector product of a vector and a vector product", "scalar.algebra.cross",
              "A × (B × C) = (A · C) B - (A · B) C", _triple_product),
    Statement("6.5", "the same with the double product worked out", ANGULAR,
              "H_0 = ∫ [(r · r) ω - (r · ω) r] dm", about_0),
    Statement("6.6", "components of r along the body axes", "dynamics.kinematics.point_position",
              "r = x i + y j + z k", _position, defines=True),
    Statement("6.7", "components of ω along the body axes",
              "dynamics.kinematics.angular_velocity of a body on a ball joint, and its speeds",
              "ω = ω_x i + ω_y j + ω_z k", _rotation, defines=True),
    Statement("6.8", "the integrand by components", "components of vectors",
              "(r · r) ω - (r · ω) r = [(r^2 - x^2) ω_x - x y ω_y - x z ω_z] i"
              " + [-x y ω_x + (r^2 - y^2) ω_y - y z ω_z] j + [-x z ω_x - y z ω_y + (r^2 - z^2) ω_z] k", _integrand),
    Statement("6.9", "the angular momentum by components", ANGULAR + " of a body on a ball joint",
              "H_0 = (I_xx ω_x - I_xy ω_y - I_xz ω_z) i + (-I_xy ω_x + I_yy ω_y - I_yz ω_z) j"
              " + (-I_xz ω_x - I_yz ω_y + I_zz ω_z) k", _by_components),
    Statement("6.10", "moments of inertia about the body axes", "MassProperties.about((0, 0, 0))",
              ("I_xx = ∫ (r^2 - x^2) dm", "I_yy = ∫ (r^2 - y^2) dm", "I_zz = ∫ (r^2 - z^2) dm"), _inertia,
              defines=True),
    Statement("6.11", "products of inertia, and minus the entries of the matrix",
              "MassProperties.products_about((0, 0, 0)), .about((0, 0, 0))",
              ("I_xy = I_yx = ∫ x y dm", "I_xz = I_zx = ∫ x z dm", "I_yz = I_zy = ∫ y z dm"), _inertia, defines=True),
    Statement("6.12", "velocity of a point of a body that moves and turns", KINEMATICS, "v = v_C + ω × ρ", flight),
    Statement("6.13", "position of an element of mass from the mass centre",
              "dynamics.kinematics.point_position, MassProperties.center", "r = r_C + ρ", flight, defines=True),
    Statement("6.14", "the mass centre", "MassProperties.center", "r_C = 1/m ∫ r dm", flight, defines=True),
    Statement("6.15", "the mass centre, seen from itself", "MassProperties.center", "∫ ρ dm = 0", flight),
    Statement("6.16", "the angular momentum about 0 of a body that moves and turns, in four parts; they are the same "
              "for any point of the body in the place of C", ANGULAR,
              "H_0 = ∫ (r_C + ρ) × (v_C + ω × ρ) dm = r_C × v_C ∫ dm + (∫ ρ dm) × v_C + r_C × (ω × ∫ ρ dm)"
              " + ∫ ρ × (ω × ρ) dm", split),
    Statement("6.17", "the linear momentum", "fb.equations(s).momentum.linear", "v_C ∫ dm = m v_C = p", flight),
    Statement("6.18", "the angular momentum about C: apparent and actual are the same",
              "fb.equations(s).momentum.angular(C)", "∫ ρ × (ω × ρ) dm = H_C = H'_C", flight),
    Statement("6.19", "the translation theorem of the angular momentum", ANGULAR, "H_0 = r_C × p + H_C", flight),
)  # fmt: skip
