"""Section 6.5: planar motion, (6.38)-(6.55), without its examples."""

from __future__ import annotations

from functools import cache

import sympy

import freebody as fb

from ..gallery.tools.case import mass_properties
from . import machines
from .meaning import Meaning
from .momentum import resolved
from .statement import Statement

t = machines.t


@cache
def lamina() -> Meaning:
    """The body in the plane: kinematics of C and of a point A of it; forces and moments that its motion requires."""
    machine = machines.lamina()
    a = machine.atoms
    C, A = machine.point("lamina", 0, 0, 0), machine.point("lamina", a["a"], a["b"], 0)
    force, moment = machine.balances("lamina")
    omega = machine.omega("lamina")
    v, a_C = machine.velocity(C), machine.acceleration(C)
    rho = machine.place(C) - machine.place(A)
    names = {
        **machine.names, "T": machine.kinetic, "v_z": v[2], "a_z": a_C[2], **resolved("v_Cx v_Cy", v[:2]),
        **resolved("a_Cx a_Cy", a_C[:2]), **resolved("ω_x ω_y ω_z", omega), "ω": a["theta'"], "α": omega.diff(t),
        **resolved("F_x F_y", force[:2]), "M_C": moment, "a_C": a_C, "a_A": machine.acceleration(A), "ρ_AC": rho,
        "a_C/A": rho.diff(t, 2),
        "I_A": mass_properties(machine.body("lamina")).about((a["a"], a["b"], 0))[2][2],
    }  # fmt: skip
    return Meaning(names)


def _planar() -> Meaning:
    """The same, with moments and accelerations about z only."""
    names = lamina().names
    return Meaning({**names, "M_C": names["M_C"][2], "α": names["α"][2]})


def _thin() -> Meaning:
    """A body without extent along z: its products of inertia with z vanish, whatever its other elements."""
    whole = fb.particle(sympy.Symbol("m_1", positive=True)).moved((*sympy.symbols("x_1 y_1"), 0))
    whole += fb.particle(sympy.Symbol("m_2", positive=True)).moved((*sympy.symbols("x_2 y_2"), 0))
    P = whole.products_about((0, 0, 0))
    return Meaning({"I_xz": P.xz, "I_yz": P.yz})


@cache
def carried() -> Meaning:
    """The body on two slides, which keep it from turning."""
    machine = machines.carried()
    C = machine.point("lamina", 0, 0, 0)
    force, moment = machine.balances("lamina")
    a, v = machine.acceleration(C), machine.velocity(C)
    return Meaning({**machine.names, "ω": machine.omega("lamina"), **resolved("a_Cx a_Cy", a[:2]), "v_C": v,
                    **resolved("v_Cx v_Cy", v[:2]), **resolved("F_x F_y", force[:2]), "M_Cz": moment[2],
                    "T": machine.kinetic})  # fmt: skip


@cache
def _hinged() -> Meaning:
    machine = machines.hinged()
    theta = machine.atoms["theta"]
    _, moment = machine.balances("lamina", about=machine.system.ground.origin)
    return Meaning({
        "H_0": machine.momentum()[2], "M_0": moment[2], "T": machine.kinetic, "ω": machine.omega("lamina")[2],
        "α": theta.diff(t, 2), "I_0": mass_properties(machine.body("lamina")).about((0, 0, 0))[2][2],
    })  # fmt: skip


def _sums() -> dict[str, object]:
    """Moments about A and C, and the force: sums over the loads, without the reactions that keep the plane."""
    machine = machines.lamina()
    a = machine.atoms
    A = machine.point("lamina", a["a"], a["b"], 0)
    total = lambda found: sum((sympy.Matrix(found[f"F_{i}"]) for i in (1, 2)), sympy.zeros(3, 1))  # noqa: E731
    about = lambda point: total(machine.free_body("lamina", about=point).moments)  # noqa: E731
    free = machine.free_body("lamina")
    return {"M_A": about(A), "M_C": about(machine.point("lamina", 0, 0, 0)), "F": total(free.forces)}


def _shifted() -> Meaning:
    machine = machines.lamina()
    a = machine.atoms
    C, A = machine.point("lamina", 0, 0, 0), machine.point("lamina", a["a"], a["b"], 0)
    loads = []
    for i in (1, 2):
        place = machine.place(machine.point("lamina", a[f"x_{i}"], a[f"y_{i}"], 0))
        force = sympy.Matrix([a[f"X_{i}"], a[f"Y_{i}"], 0])
        loads.append({"ρ": place - machine.place(C), "ρ_A": place - machine.place(A), "dF": force})
    return Meaning({**lamina().names, **_sums()}, loads=loads)


def _about_any_point() -> Meaning:
    """Moments of the loads about A and C, along the motion that they cause."""
    return Meaning({**lamina().names, **_sums()}, along=machines.lamina().along())


BODY = "fb.equations(s).free_body('lamina')"
ROWS = f"{BODY}.equations"
KINETIC = "fb.equations(s).energy.kinetic"
ACCELERATION = "dynamics.kinematics.point_acceleration"
STATEMENTS = (
    Statement("6.38a", "motion in the plane xy: no velocity or acceleration along z", "s.planar(...)",
              "v_z = a_z = 0", lamina, defines=True),
    Statement("6.38b", "motion in the plane xy: the body turns about z only", "s.planar(...)",
              ("ω_x = ω_x' = ω_y = ω_y' = 0", "ω_z = ω"), lamina, defines=True),
    Statement("6.39", "no products of inertia with z of a body that is thin along z",
              "MassProperties.products_about((0, 0, 0))", "I_xz = I_yz = 0", _thin),
    Statement("6.40", "pure translation", "dynamics.kinematics.angular_velocity of a body on two slides",
              "ω = ω' = 0", carried, defines=True),
    Statement("6.41a", "force equation along x", ROWS, "F_x = m a_Cx", carried),
    Statement("6.41b", "force equation along y", ROWS, "F_y = m a_Cy", carried),
    Statement("6.42", "no moment about C in pure translation", ROWS, "M_Cz = 0", carried),
    Statement("6.43", "kinetic energy of pure translation", KINETIC,
              "T = 1/2 m v_C · v_C = 1/2 m (v_Cx^2 + v_Cy^2)", carried),
    Statement("6.44", "angular momentum about a fixed point, planar", "fb.equations(s).momentum.angular()",
              "H_0 = I_0 ω", _hinged),
    Statement("6.45", "moment about a fixed point, planar", "fb.equations(s).free_body('lamina', about=0).equations",
              "M_0 = I_0 α", _hinged),
    Statement("6.46", "kinetic energy of rotation about a fixed point", KINETIC, "T = 1/2 I_0 ω^2", _hinged),
    Statement("6.47", "moment about the mass centre, planar", ROWS, "M_C = I_C α", _planar),
    Statement("6.48", "kinetic energy of planar motion", KINETIC, "T = 1/2 m (v_Cx^2 + v_Cy^2) + 1/2 I_C ω^2", lamina),
    Statement("6.49", "the moment about any point A", "fb.equations(s).free_body('lamina', about=A).moments",
              "M_A = ∫ ρ_A × dF = ∫ (ρ_AC + ρ) × dF = ρ_AC × F + M_C", _shifted),
    Statement("6.50", "the moment about A in the acceleration of C",
              "fb.equations(s).free_body('lamina', about=A).moments, along fb.equations(s).motion",
              "M_A = ρ_AC × m a_C + M_C", _about_any_point),
    Statement("6.51", "the couple about C, planar", ROWS, "M_C = I_C α", lamina),
    Statement("6.52", "the acceleration of C from that of A", ACCELERATION, "a_C = a_A + a_C/A", lamina),
    Statement("6.53", "the same in ω and α", ACCELERATION, "a_C = a_A - ω^2 ρ_AC + α × ρ_AC", lamina),
    Statement("6.54", "the moment about A in the acceleration of A",
              "fb.equations(s).free_body('lamina', about=A).moments, along fb.equations(s).motion",
              "M_A = ρ_AC × m a_A + I_A α", _about_any_point),
    Statement("6.55", "moment of inertia about A (parallel axes)", "MassProperties.about(point)",
              "I_A = I_C + m ρ_AC^2", lamina),
)  # fmt: skip
