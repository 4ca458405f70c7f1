"""Sections 6.3 and 6.4: the equations of motion, (6.20)-(6.30), and the kinetic energy, (6.31)-(6.37)."""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy

import freebody as fb

from . import machines
from .meaning import Meaning
from .momentum import angular_momentum, body_rates, flight, mass_of_flight, resolved, split, triple, vector
from .statement import Statement

t = machines.t


def _newton() -> Meaning:
    """F is the force that the free-body equations require."""
    force, _ = machines.flying()[0].balances("body")
    return Meaning({**flight().names, "F": force})


@cache
def _turning() -> Meaning:
    """The body about 0 in ground axes; its components in body axes by the library's free body and forms."""
    machine = machines.turning()
    _, moment = machine.balances("body")
    _, own = machine.balances("body", frame="body")
    axes = machine.frame("body")
    units = [axes[c] for c in "ijk"]
    omega = machine.omega("body")
    rates = [omega.dot(u) for u in units]
    inside = angular_momentum(_matrix(machine), rates)
    apparent = angular_momentum(_matrix(machine), [x.diff(t) for x in rates])
    names = {
        "M_0": moment, "H_0": machine.momentum(), "dH_0/dt": machine.momentum().diff(t), "ω": omega, **axes,
        "d'H_0/dt": sum((x * u for x, u in zip(apparent, units, strict=True)), sympy.zeros(3, 1)),
        **resolved("M_0x M_0y M_0z", own), **resolved("H_0x H_0y H_0z", inside),
    }  # fmt: skip
    return Meaning(names)


def _matrix(machine: machines.Machine) -> Any:
    """Return the inertia matrix from the system."""
    from ..gallery.tools.case import mass_properties

    return mass_properties(machine.body("body")).about((0, 0, 0))


def _plain_moments() -> Meaning:
    """Moments in body axes, written in the speeds of a ball joint, ω_x, ω_y, ω_z, and their rates."""
    machine = machines.ball()
    _, moment = machine.balances("body", frame="body")
    return Meaning({**body_rates(machine), **resolved("M_0x M_0y M_0z", moment)})


def _about_centre() -> Meaning:
    """The free body: M_C from its free-body equations; the rate of H_C in ground axes and in body axes."""
    machine, whole, _ = machines.flying()
    _, moment = machine.balances("body")
    axes = [flight().names[c] for c in "ijk"]
    omega = flight().names["ω"]
    rates = [omega.dot(u).diff(t) for u in axes]
    apparent = angular_momentum(whole, rates)
    names = {
        **flight().names, "M_C": moment, "dH_C/dt": flight().names["H_C"].diff(t),
        "d'H_C/dt": sum((x * u for x, u in zip(apparent, axes, strict=True)), sympy.zeros(3, 1)),
    }  # fmt: skip
    return Meaning(names)


def _principal() -> Meaning:
    """A body given by its principal moments, turned by an angle out of its principal axes and back."""
    moments = sympy.symbols("I_1 I_2 I_3", positive=True)
    c, d = sympy.cos(sympy.Symbol("beta", real=True)), sympy.sin(sympy.Symbol("beta", real=True))
    turn = sympy.Matrix([[1, 0, 0], [0, c, -d], [0, d, c]])
    own = fb.MassProperties(1, (0, 0, 0), ((moments[0], 0, 0), (0, moments[1], 0), (0, 0, moments[2])))
    back = own.rotated(turn.tolist()).rotated(turn.T.tolist())
    names = {f"I_{c}{c}": back.inertia[i][i] for i, c in enumerate("xyz")}
    names |= {f"I_{k}": getattr(back.products, k) for k in ("xy", "xz", "yz")}
    return Meaning({**names, **resolved("I_1 I_2 I_3", moments)})


@cache
def principal() -> Meaning:
    """Moments, energy and rates of the body in principal axes."""
    machine = machines.spinning()
    _, moment = machine.balances("body", frame="body")
    return Meaning(
        {**body_rates(machine, "123"), **resolved("M_1 M_2 M_3", moment), "T_rot": machine.kinetic}
    )


# --- kinetic energy ---------------------------------------------------------------------------------------------


@cache
def energy() -> Meaning:
    """T of the free body, T_rot of the body with a fixed mass centre, T_tr of the body that does not turn."""
    machine, whole, _ = machines.flying()
    still = {machine.atoms[f"{q}'"]: 0 for q in ("psi", "theta", "phi")}
    velocity = dict(zip((machine.atoms[f"{q}'"] for q in "XYZ"), flight().names["v_C"], strict=True))
    carried = machine.kinetic.subs(still).subs(velocity, simultaneous=True)
    names = {**flight().names, "T_rot": machines.centred().kinetic, "T_tr": carried}
    return Meaning(names, flight().elements)


def _split_energy() -> Meaning:
    return Meaning({**split().names, "T": machines.flying()[0].kinetic}, split().elements)


def _by_components() -> Meaning:
    """T_rot in components along the body's axes."""
    machine, _, parts = machines.flying()
    whole = mass_of_flight()
    units = [flight().names[c] for c in "ijk"]
    omega = [flight().names["ω"].dot(u) for u in units]
    elements = [
        (m, {c: x - y for c, x, y in zip("xyz", place, whole.center, strict=True)}) for m, place in parts
    ]
    J, P = whole.inertia, whole.products
    names = {f"I_{c}{c}": J[i][i] for i, c in enumerate("xyz")} | {
        f"I_{k}": getattr(P, k) for k in ("xy", "xz", "yz")
    }
    return Meaning({**names, "T_rot": machines.centred().kinetic, **resolved("ω_x ω_y ω_z", omega)}, elements)


def _spin_velocity() -> Meaning:
    omega, rho = triple("omega"), sympy.symbols("x y z", real=True)
    axes = {name: vector(*axis) for name, axis in zip("ijk", machines.AXES, strict=True)}
    return Meaning(
        {"ω": omega, "ρ": vector(*rho), **resolved("x y z", rho), **resolved("ω_x ω_y ω_z", omega), **axes}
    )


BALANCES = "fb.equations(s).free_body('body').equations"
OWN = "fb.equations(s).free_body('body', frame='body').equations"
KINETIC = "fb.equations(s).energy.kinetic"
STATEMENTS = (
    Statement("6.20", "the force is the rate of the linear momentum", BALANCES + "; fb.equations(s).momentum.linear",
              "F = dp/dt = m a_C", _newton),
    Statement("6.21", "the moment about a fixed point is the rate of the angular momentum",
              BALANCES + "; fb.equations(s).momentum.angular()", "M_0 = dH_0/dt", _turning),
    Statement("6.22", "unit vectors of axes that turn",
              "dynamics.kinematics.point_position, differentiated; .angular_velocity",
              ("di/dt = ω × i", "dj/dt = ω × j", "dk/dt = ω × k"), _turning),
    Statement("6.23", "components of the angular momentum along body axes",
              "fb.equations(s).momentum.angular(); fb.forms.angular_momentum(inertia, omega)",
              "H_0 = H_0x i + H_0y j + H_0z k", _turning, defines=True),
    Statement("6.24", "rate of a vector that is given in axes that turn; d' is the rate in these",
              "fb.equations(s).momentum.angular(), differentiated; fb.forms.angular_momentum(inertia, alpha)",
              "dH_0/dt = d/dt (H_0x i + H_0y j + H_0z k)"
              " = H_0x' i + H_0x di/dt + H_0y' j + H_0y dj/dt + H_0z' k + H_0z dk/dt"
              " = H_0x' i + H_0y' j + H_0z' k + H_0x ω × i + H_0y ω × j + H_0z ω × k"
              " = H_0x' i + H_0y' j + H_0z' k + ω × (H_0x i + H_0y j + H_0z k) = d'H_0/dt + ω × H_0", _turning),
    Statement("6.25", "the moment equation in body axes; d' is the rate in these", BALANCES, "M_0 = d'H_0/dt + ω × H_0",
              _turning),
    Statement("6.26", "components of the moment along body axes", BALANCES + "; " + OWN,
              "M_0 = M_0x i + M_0y j + M_0z k", _turning, defines=True),
    Statement("6.27", "the moment equations in body axes that need not be principal", OWN,
              ("M_0x = I_xx ω_x' - I_xy ω_y' - I_xz ω_z' - I_xz ω_x ω_y + I_xy ω_x ω_z + (I_zz - I_yy) ω_y ω_z"
               " - I_yz (ω_y^2 - ω_z^2)",
               "M_0y = -I_xy ω_x' + I_yy ω_y' - I_yz ω_z' + I_yz ω_x ω_y + (I_xx - I_zz) ω_x ω_z - I_xy ω_y ω_z"
               " - I_xz (ω_z^2 - ω_x^2)",
               "M_0z = -I_xz ω_x' - I_yz ω_y' + I_zz ω_z' + (I_yy - I_xx) ω_x ω_y - I_yz ω_x ω_z + I_xz ω_y ω_z"
               " - I_xy (ω_x^2 - ω_y^2)"), _plain_moments),
    Statement("6.28", "the moment equation about the mass centre; d' is the rate in body axes",
              BALANCES + "; fb.equations(s).momentum.angular(C)", "M_C = dH_C/dt = d'H_C/dt + ω × H_C", _about_centre),
    Statement("6.29", "principal axes: no products of inertia", "MassProperties.rotated(R)",
              ("I_xx = I_1", "I_yy = I_2", "I_zz = I_3", "I_xy = I_xz = I_yz = 0"), _principal, defines=True),
    Statement("6.30", "Euler's moment equations", OWN,
              ("M_1 = I_1 ω_1' + (I_3 - I_2) ω_2 ω_3", "M_2 = I_2 ω_2' + (I_1 - I_3) ω_1 ω_3",
               "M_3 = I_3 ω_3' + (I_2 - I_1) ω_1 ω_2"), principal),
    Statement("6.31", "the kinetic energy is the sum over all elements of mass", KINETIC, "T = 1/2 ∫ v · v dm", flight,
              defines=True),
    Statement("6.32",
              "the kinetic energy in three parts; they are the same for any point of the body in the place of C",
              KINETIC, "T = 1/2 ∫ (v_C + ω × ρ) · (v_C + ω × ρ) dm"
              " = 1/2 v_C · v_C ∫ dm + v_C · ω × ∫ ρ dm + 1/2 ∫ (ω × ρ) · (ω × ρ) dm", _split_energy),
    Statement("6.33", "kinetic energy of translation and of rotation",
              KINETIC + ": of the body, of the body that does not turn, and of the body held at C", "T = T_tr + T_rot",
              energy),
    Statement("6.34a", "the kinetic energy of translation", KINETIC + " of the body that does not turn",
              "T_tr = 1/2 m v_C · v_C", energy, defines=True),
    Statement("6.34b", "the kinetic energy of rotation about the mass centre", KINETIC + " of the body held at C",
              "T_rot = 1/2 ∫ (ω × ρ) · (ω × ρ) dm", energy, defines=True),
    Statement("6.35", "the velocity from rotation, by components", "scalar.algebra.cross",
              "ω × ρ = (ω_y z - ω_z y) i + (ω_z x - ω_x z) j + (ω_x y - ω_y x) k", _spin_velocity),
    Statement("6.36", "the kinetic energy of rotation by components", KINETIC + " of the body held at C",
              "T_rot = 1/2 ∫ [(ω_y z - ω_z y)^2 + (ω_z x - ω_x z)^2 + (ω_x y - ω_y x)^2] dm"
              " = 1/2 (I_xx ω_x^2 + I_yy ω_y^2 + I_zz ω_z^2 - 2 I_xy ω_x ω_y - 2 I_xz ω_x ω_z - 2 I_yz ω_y ω_z)",
              _by_components),
    Statement("6.37", "the kinetic energy of rotation in principal axes", KINETIC,
              "T_rot = 1/2 (I_1 ω_1^2 + I_2 ω_2^2 + I_3 ω_3^2)", principal),
)  # fmt: skip
