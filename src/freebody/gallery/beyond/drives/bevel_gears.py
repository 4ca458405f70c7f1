"""Two bevel wheels at a right angle: a motor turns the pinion, a load brakes the wheel.

Their pitch cones touch along a line through the apex, at the angle γ to the pinion's axis, tan γ = r_1/r_2. With the
tangential force F at the pitch circles,

    J_1 a_1 = T - r_1 F,    J_2 a_2 = r_2 F - Q,    r_1 a_1 = r_2 a_2

The teeth press apart with F tan α square to that line: F tan α sin γ pushes the pinion along its axis, away from the
apex, and F tan α cos γ towards its axis.

Source: Shigley & Mischke, Mechanical Engineering Design (1989), equations (13-37) and (13-38).
"""

from __future__ import annotations

import sympy

import freebody as fb

from ....space.shape import Shape
from ...tools.answer import Answers, Plots, Solved
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import placed, together


def build() -> fb.System:
    """Return the wheels as disks in their pitch circles; the apex is the ground's origin."""
    s = fb.System("bevel_gears")
    m_1, r_1, m_2, r_2 = s.parameters(m_1=1.0, r_1=0.05, m_2=5.0, r_2=0.1)
    T, Q, alpha = s.parameters(T=6.0, Q=4.0, alpha=sympy.pi / 9)
    pinion = s.body("pinion", fb.disk(m_1, r_1, axis="x"), shape=look(r_1, r_2, "x"))
    wheel = s.body("wheel", fb.disk(m_2, r_2, axis="y"), shape=look(r_2, r_1, "y"))
    first = s.hinge("first", s.ground, pinion, at=(-r_2, 0, 0), axis="x", coordinate="phi_1")
    second = s.hinge("second", s.ground, wheel, at=(0, -r_1, 0), axis="y", coordinate="phi_2")
    s.gear(first, second, -r_2 / r_1, name="mesh", pressure_angle=alpha)
    s.torque("motor", first, T)
    s.torque("load", second, Q)
    explain(
        s,
        m_1="kg: mass of the pinion",
        r_1="m: radius of the pinion's pitch circle",
        m_2="kg: mass of the wheel",
        r_2="m: radius of the wheel's pitch circle",
        T="N m: torque of the motor on the pinion",
        Q="N m: torque of the load on the wheel, against its motion",
        alpha="rad: pressure angle of the teeth",
        phi_1="rad: angle of the pinion",
        phi_2="rad: angle of the wheel",
    )
    return s


def look(radius: sympy.Expr, apex: sympy.Expr, axis: str) -> Shape:
    """Return a wheel as it looks: its pitch circle and its pitch cone to 0.4 of the way to the apex."""
    z = sympy.Symbol("z")
    cone = fb.revolve(radius * (1 - z / apex), (0, sympy.Rational(2, 5) * apex), z, mass=1, axis=axis)
    return together(placed(fb.disk(1, radius, axis=axis)), placed(cone))


def solve(case: Case) -> Solved:
    """Solve the equations for accelerations and forces, and simulate."""
    from ....picture.plots.plots import energy_residual, history, saved

    how = "fb.equations(s).solve"
    found = case.equations.solve(["phi_1''", "phi_2''", "mesh", "first_x", "first_y", "first_z"])
    answers: Answers = {
        "phi_1''": case.formula("angular acceleration of the pinion", found["phi_1''"], "rad/s²", how),
        "phi_2''": case.formula("angular acceleration of the wheel", found["phi_2''"], "rad/s²", how),
        "mesh": case.formula("torque of the teeth on the pinion", found["mesh"], "N m", how),
        "thrust": case.formula(
            "force of the bearing along the pinion's axis, towards the apex", found["first_x"], "N", how
        ),
        "apart": case.formula("force of the bearing against the teeth", -found["first_y"], "N", how),
        "around": case.formula("force of the bearing around the wheel", -found["first_z"], "N", how),
    }
    trajectory = case.motion()
    plots: Plots = {
        "angles.png": saved(lambda: history(trajectory, title="Bevel gears: angles")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


BEVEL_GEARS = Entry(
    "bevel-gears",
    (),
    "Bevel gears: the bearings of the pinion",
    (
        "angular accelerations",
        "torque of the teeth",
        "forces of the pinion's bearing along and across its axis",
    ),
    build,
    solve,
    until=1.0,
)
