"""Single-gimbal control moment gyro on a platform that is free to turn about the vertical.

theta is the rotation of the platform about Z. The gimbal turns at the rate nu about x of the platform by
delta = nu t, from the position in which the axis of the rotor lies along y. The rotor keeps its speed Omega in the
gimbal.
"""

from __future__ import annotations

from typing import Any

import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain
from ..tools.entry import Entry
from ..tools.pictures import lines


def build() -> fb.System:
    """Return the platform, the massless gimbal and the rotor, all centred at one point."""
    s = fb.System("control_moment_gyro")
    I_P, I_S, I_T = s.parameters(I_P=12.0, I_S=0.06, I_T=0.035)
    Omega, nu = s.parameters(Omega=600.0, nu=0.5)
    s.parameters(delta_1="60deg")
    s.assume(I_P > 0, I_S > 0, I_T > 0)
    platform = s.body("platform", fb.MassProperties(1, (0, 0, 0), ((I_P, 0, 0), (0, I_P, 0), (0, 0, I_P))),
                      shape=fb.box(1, (0.7, 0.7, 0.1)).moved((0, 0, -0.3)))  # fmt: skip
    gimbal = s.body("gimbal", fb.particle(0), shape=fb.torus(1, 0.2, 0.01, axis="z"))
    disk = fb.cylinder(1, 0.14, 0.05, axis="y") + fb.cylinder(1, 0.008, 0.4, axis="y")
    rotor = s.body("rotor", fb.MassProperties(1, (0, 0, 0), ((I_T, 0, 0), (0, I_S, 0), (0, 0, I_T))),
                   shape=disk)  # fmt: skip
    s.hinge("pivot", s.ground, platform, axis="z", coordinate="theta")
    s.hinge("gimbal", platform, gimbal, axis="x", coordinate=nu * s.t)
    s.hinge("axle", gimbal, rotor, axis="y", coordinate=Omega * s.t)
    explain(
        s,
        I_P="kg m²: moment of inertia of the platform about the vertical",
        I_S="kg m²: moment of inertia of the rotor about its axis",
        I_T="kg m²: moment of inertia of the rotor across its axis",
        Omega="rad/s: speed of the rotor in the gimbal",
        nu="rad/s: rate of the gimbal",
        delta_1="rad: angle of the gimbal to answer for",
        theta="rad: turn of the platform, counter-clockwise from above",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, saved

    for name in ("nu", "delta_1"):
        case.refuse_unless(name, case[name] > 0, "a rate and an angle of the gimbal above 0")
    e, t = case.equations, case.system.t
    speed = case.atoms["theta'"]
    H = e.momentum.angular()[2]
    rate = sympy.solve(H, speed)[0]
    then = case.atoms["delta_1"] / case.atoms["nu"]
    first = e.solve("theta''", where={"theta'": 0})["theta''"].subs(t, 0)
    solution = e.solve(["theta''", "gimbal_Mx"], where={"theta": 0})
    moment = case.put(solution["gimbal_Mx"], {"theta'": rate}).subs(t, then)
    at = case.simulate_to([case["delta_1"] / case["nu"]])
    answers: Answers = {
        "alpha_0": case.formula(
            "angular acceleration of the platform at the start, counter-clockwise +",
            first, "rad/s²", 'fb.equations(s).solve("theta''")',
        ),
        "M_0": case.formula(
            "torque on the platform about the vertical at the start", case.atoms["I_P"] * first, "N m", "I_P alpha_0"
        ),
        "theta'(delta_1)": case.formula(
            "rate of the platform at delta_1, from rest at delta = 0", rate.subs(t, then), "rad/s",
            "fb.equations(s).momentum.angular() = 0",
        ),
        "M_x(delta_1)": case.formula(
            "torque of the gimbal's motor at delta_1", moment, "N m", 'fb.equations(s).solve("gimbal_Mx")'
        ),
        "theta(delta_1)": Answer("turn of the platform at delta_1", float(at["theta"][-1]), "rad", how="fb.simulate"),
    }  # fmt: skip
    felt = at.reactions["gimbal"].moment[-1] @ at.poses["platform"].rotation[-1][:, 0]
    bound = 1000 * case.tolerance
    checks = (
        same("theta' against the simulation", at["theta'"][-1], answers["theta'(delta_1)"].value, bound),
        same("torque of the motor against the simulation", felt, answers["M_x(delta_1)"].value, bound),
    )
    trajectory = case.motion()
    plots: Plots = {
        "platform.png": saved(
            lambda: history(trajectory, ["theta", "theta'"], title="Platform with a control moment gyro")
        ),
        "torques.png": saved(lambda: torques(trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def torques(trajectory: fb.Trajectory) -> Any:
    """Draw the torque of the gyro on the platform about the vertical, and the torque of its motor."""
    moment = trajectory.reactions["gimbal"].moment
    x = trajectory.poses["platform"].rotation[:, :, 0]
    return lines(
        trajectory.t,
        {
            "N m": {
                "on the platform, vertical": -moment[:, 2],
                "of the gimbal's motor": (moment * x).sum(axis=1),
            }
        },
        "Control moment gyro: torques",
    )


CONTROL_MOMENT_GYRO = Entry(
    "control-moment-gyro",
    ("cmg",),
    "Single-gimbal control moment gyro turns a platform (beyond the chapter)",
    (
        "angular acceleration and torque at the start",
        "rate of the platform and torque of the gimbal's motor at the angle delta_1 of the gimbal",
        "turn of the platform then",
    ),
    build,
    solve,
    until=3.0,
)
