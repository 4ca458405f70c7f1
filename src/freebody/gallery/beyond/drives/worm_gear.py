"""A worm turns a wheel on a crossed axis: a motor on the worm, a load on the wheel.

A worm of the lead l moves the teeth of the wheel by l in a turn, so that its wheel of radius R turns 2 π R/l times as
slowly. The teeth push across their helix: with the force F_t around the worm, F_a = F_t 2 π r/l pushes along it and
turns the wheel, and both are pressed apart by F tan α, with F = sqrt(F_t² + F_a²) across the teeth.

    J_1 a_1 = T - r F_t,    J_2 a_2 = R F_a - Q,    l a_1 = 2 π R a_2

Friction of the teeth, which decides whether the worm locks itself, needs a backlash and is left out here.

Source: Shigley & Mischke, Mechanical Engineering Design (1989), equations (13-41) to (13-43).
"""

from __future__ import annotations

import sympy

import freebody as fb

from ...tools.answer import Answers, Plots, Solved
from ...tools.case import Case, explain
from ...tools.entry import Entry


def build() -> fb.System:
    """Return the worm about x above the wheel about y, with right-handed teeth."""
    s = fb.System("worm_gear")
    m_1, r, m_2, R, lead = s.parameters(m_1=1.0, r=0.03, m_2=8.0, R=0.1, l=0.025)
    T, Q, alpha = s.parameters(T=5.0, Q=60.0, alpha=sympy.pi / 9)
    s.assume(lead > 0)
    worm, wheel = (
        s.body("worm", fb.cylinder(m_1, r, 6 * r, axis="x")),
        s.body("wheel", fb.disk(m_2, R, axis="y"), shape=fb.cylinder(1, R, r, axis="y")),
    )
    shaft = s.hinge("shaft", s.ground, worm, at=(0, 0, r + R), axis="x", coordinate="phi")
    axle = s.hinge("axle", s.ground, wheel, axis="y", coordinate="theta")
    slope = lead / (2 * sympy.pi * r)
    helix = sympy.pi / 2 - sympy.atan(slope)
    s.gear(shaft, axle, -R / (r * slope), name="mesh", helix_angle=helix, pressure_angle=alpha)
    s.torque("motor", shaft, T)
    s.torque("load", axle, Q)
    explain(
        s,
        m_1="kg: mass of the worm",
        r="m: radius of the worm's pitch cylinder",
        m_2="kg: mass of the wheel",
        R="m: radius of the wheel's pitch circle",
        l="m: lead of the worm, along its axis in a turn",
        T="N m: torque of the motor on the worm",
        Q="N m: torque of the load on the wheel, against its motion",
        alpha="rad: pressure angle across the teeth",
        phi="rad: angle of the worm",
        theta="rad: angle of the wheel",
    )
    return s


def solve(case: Case) -> Solved:
    """Solve the equations for accelerations and the forces of the worm's bearing, and simulate."""
    from ....picture.plots.plots import energy_residual, history, saved

    how = "fb.equations(s).solve"
    found = case.equations.solve(["phi''", "theta''", "mesh", "shaft_x", "shaft_y", "shaft_z"])
    answers: Answers = {
        "phi''": case.formula("angular acceleration of the worm", found["phi''"], "rad/s²", how),
        "theta''": case.formula("angular acceleration of the wheel", found["theta''"], "rad/s²", how),
        "thrust": case.formula("force of the bearing along the worm, against x", -found["shaft_x"], "N", how),
        "around": case.formula("force of the bearing around the wheel", found["shaft_y"], "N", how),
        "apart": case.formula("force of the bearing against the teeth, down", -found["shaft_z"], "N", how),
    }
    trajectory = case.motion()
    plots: Plots = {
        "angles.png": saved(lambda: history(trajectory, title="Worm gear: angles")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


WORM_GEAR = Entry(
    "worm-gear",
    ("worm",),
    "A worm gear: the bearings of the worm",
    ("angular accelerations", "forces of the worm's bearing along and across its axis"),
    build,
    solve,
    until=1.0,
)
