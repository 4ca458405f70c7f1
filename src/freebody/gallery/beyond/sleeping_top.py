"""Sleeping top: upright while it spins fast; friction reduces the spin until it wakes, leans over and falls.

The top is a thin disk on a massless shaft that stands on a fixed point O. The couple of the friction acts about the
shaft, against the spin. The tilt is the angle of the shaft from the vertical Z.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain, happened
from ..tools.entry import Entry
from ..tools.pictures import lines, tip
from ..tools.precession import least_spin

START = {"O_e0": "cos(theta_0/2)", "O_e1": "sin(theta_0/2)", "O_wz": "Omega_0"}


def build() -> fb.System:
    """Return the disk on a ball joint, its axis along z: no attitude is singular."""
    s, disk = top()
    c = s.parameters(c=2.0e-5)
    s.parameters(Omega_0=120.0, theta_0="1deg", theta_1="30deg", t_1=5.0)
    s.ball("O", s.ground, disk, to=(0, 0, -s.expression("L")))
    s.torque("friction", disk, (0, 0, -c * s.expression("O_wz")), frame=disk)
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the disk",
        L="m: length of the shaft",
        g="m/s²: gravity",
        c="N m s/rad: friction against the spin",
        Omega_0="rad/s: spin at the start",
        theta_0="rad: tilt at the start",
        theta_1="rad: tilt at which it is taken as fallen",
        t_1="s: time to answer for",
    )
    return s


def leaning() -> fb.System:
    """Return the same top without friction, in Euler's angles; Omega is its total spin."""
    s, disk = top()
    s.parameters(Omega=1.0)
    s.gimbal("O", s.ground, disk, to=(0, 0, -s.expression("L")), axis="ZXZ", coordinate="psi theta phi")
    return s


def top() -> tuple[fb.System, Any]:
    """Return the parameters and the disk, with gravity along -Z."""
    s = fb.System("sleeping_top")
    m, R, L, g = s.parameters(m=0.3, R=0.05, L=0.06, g=9.81)
    s.assume(g > 0)
    s.gravity = (0, 0, -g)
    s.assume(L > 0)
    return s, s.body("disk", fb.disk(m, R, axis="z"))


def tilt(trajectory: fb.Trajectory) -> np.ndarray:
    """Return the angle of the shaft from the vertical at every output time."""
    axis = trajectory.poses["disk"].rotation[:, :, 2]
    return np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, saved

    case.refuse_unless("c", case["c"] > 0, "a friction above 0: without it the top sleeps for ever")
    case.refuse_unless(
        "theta_0", 0 < case["theta_0"] < case["theta_1"], "a small tilt, between 0 and theta_1"
    )
    case.refuse_unless("theta_1", case["theta_1"] < np.pi, "a tilt below 180 degrees")
    euler = leaning()
    e = fb.equations(euler)
    steady = replace(
        case,
        system=euler,
        equations=e,
        values={name: case[name] for name in "mRLg"} | {"Omega": case["Omega_0"]},
    )
    critical = least_spin(steady, 0, "Omega")
    at_least = steady.number(critical)
    case.refuse_unless(
        "Omega_0", case["Omega_0"] > at_least, f"a spin above {at_least:g} rad/s, at which it sleeps"
    )
    (slowing,) = sympy.solve(case.equations.motion[2], case.atoms["O_wz'"])
    spin = sympy.Symbol("spin", positive=True)
    decay = sympy.cancel(-case.put(slowing, {"O_wz": spin}) / spin)
    answers: Answers = {
        "Omega_c": case.formula(
            "smallest spin with which the top sleeps",
            critical, "rad/s", "equation of motion of theta at constant theta and psi', theta = 0",
        ),
        "t_c": case.formula(
            "time until the spin has fallen to it",
            sympy.log(case.atoms["Omega_0"] / sympy.Symbol("Omega_c", real=True)) / decay, "s",
            "fb.equations(s).motion of O_wz, integrated", where={"Omega_c": critical},
        ),
    }  # fmt: skip
    fallen = [fb.event("1 - 2*(O_e1^2 + O_e2^2) - cos(theta_1)", "fallen", -1, terminal=True)]
    long = replace(case, until=max(case.until, 2 * answers["t_c"].value))
    run = long.simulate_past("fallen", 1, initial=START, events=fallen)
    at = case.simulate_to([case["t_1"]], initial=START)
    how = "fb.simulate"
    answers["theta(t_1)"] = Answer("tilt at t_1", float(tilt(at)[-1]), "rad", how=how)
    answers["t_f"] = Answer(
        "time at which the tilt first reaches theta_1", float(happened(run, "fallen")[0].time), "s",
        how=how + ", event located",
    )  # fmt: skip
    answers["Omega_f"] = Answer("spin then", float(run["O_wz"][-1]), "rad/s", how=how)
    passing = [fb.event(f"O_wz - {at_least!r}", name="awake")]
    bound = 1000 * case.tolerance
    checks = [
        same(
            "t_c against the simulation",
            happened(long.simulate(initial=START, events=passing), "awake")[0].time,
            answers["t_c"].value,
            bound,
        )
    ]
    for part, sleeps in ((1.01, True), (0.99, False)):
        roots = fb.linearize(case.equations, {"O_wz": part * at_least}, values={**case.values, "c": 0.0})
        largest = max(roots.eigenvalues().real) / at_least
        checks.append(
            same(
                f"wobble grows at {part:g} Omega_c: no (0) or yes (1)",
                largest > 1e-6,
                0 if sleeps else 1,
                0.0,
            )
        )
    trajectory = case.motion(initial=START, events=[replace(fallen[0], terminal=False)])
    plots: Plots = {
        "tilt.png": saved(
            lambda: lines(
                trajectory.t,
                {
                    "tilt [deg]": {"tilt": np.rad2deg(tilt(trajectory))},
                    "spin [rad/s]": {
                        "spin": trajectory["O_wz"],
                        "Omega_c": np.full(len(trajectory.t), at_least),
                    },
                },
                "Sleeping top wakes",
            )
        ),
        "axis.png": saved(
            lambda: tip(trajectory, "disk", "Sleeping top: path of its axis", about=("up", (0, 0, 1)))
        ),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks))


SLEEPING_TOP = Entry(
    "sleeping-top",
    (),
    "Sleeping top loses its spin and falls (beyond the chapter)",
    (
        "smallest spin with which it sleeps, and the time until friction has brought it down to that",
        "tilt at t_1",
        "when it has fallen to the tilt theta_1, and its spin then",
    ),
    build,
    solve,
    until=14.0,
    start=START,
    names={"I_xi": "m*(R**2/4 + L**2)", "I_zeta": "m*R**2/2"},
)
