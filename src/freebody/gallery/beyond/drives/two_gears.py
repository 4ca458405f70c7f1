"""Two gears in mesh: a motor turns the small one, a load brakes the large one.

J_1 a_1 = T - r_1 F,  J_2 a_2 = r_2 F - Q,  r_1 a_1 = r_2 a_2, with F the tangential force at the teeth. They
push along a line at the pressure angle alpha to it, with F/cos alpha, and so do the bearings against them.
"""

from __future__ import annotations

import numpy as np
import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved
from ...tools.case import Case, explain
from ...tools.entry import Entry


def build() -> fb.System:
    """Return the wheels as disks; the second turns opposite to the first."""
    s = fb.System("two_gears")
    m_1, r_1, m_2, r_2 = s.parameters(m_1=1.0, r_1=0.05, m_2=6.0, r_2=0.15)
    T, Q, alpha, t_1 = s.parameters(T=2.0, Q=1.5, alpha=sympy.pi / 9, t_1=1.0)
    small, large = s.body("pinion", fb.disk(m_1, r_1)), s.body("wheel", fb.disk(m_2, r_2))
    first = s.hinge("first", s.ground, small, coordinate="phi_1")
    second = s.hinge("second", s.ground, large, at=(r_1 + r_2, 0, 0), coordinate="phi_2")
    s.gear(first, second, -r_2 / r_1, name="mesh", pressure_angle=alpha)
    s.torque("motor", first, T)
    s.torque("load", second, Q)
    explain(
        s,
        m_1="kg: mass of the pinion",
        r_1="m: radius of the pinion",
        m_2="kg: mass of the wheel",
        r_2="m: radius of the wheel",
        T="N m: torque of the motor on the pinion",
        Q="N m: torque of the load on the wheel, against its motion",
        alpha="rad: pressure angle of the teeth",
        t_1="s: time to answer for",
        phi_1="rad: angle of the pinion",
        phi_2="rad: angle of the wheel",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    at = case.simulate_to([case["t_1"]])
    here = {name: float(at[name][0]) for name in ("phi_1", "phi_2", "phi_1'", "phi_2'")}
    start = case.accelerations(here)
    answers: Answers = {
        "phi_1''": Answer("angular acceleration of the pinion", start["phi_1''"], "rad/s²"),
        "phi_2''": Answer("angular acceleration of the wheel", start["phi_2''"], "rad/s²"),
        # the multiplier is the torque of the mesh on the pinion
        "force": Answer(
            "tangential force at the teeth", -float(at.multipliers["mesh"][0]) / case["r_1"], "N"
        ),
        "bearing": Answer(
            "force of the pinion's bearing", float(np.linalg.norm(at.reactions["first"].force[0])), "N"
        ),
        "phi_1(t_1)": Answer("phi_1 at t_1", here["phi_1"], "rad"),
        "phi_2(t_1)": Answer("phi_2 at t_1", here["phi_2"], "rad"),
    }
    trajectory = case.motion()
    plots: Plots = {
        "angles.png": saved(lambda: history(trajectory, title="Two gears: angles")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


TWO_GEARS = Entry(
    "two-gears",
    ("gears",),
    "Two gears in mesh, motor on one and load on the other",
    ("angular accelerations", "force at the teeth and of the bearing", "angles at t_1"),
    build,
    solve,
    until=2.0,
)
