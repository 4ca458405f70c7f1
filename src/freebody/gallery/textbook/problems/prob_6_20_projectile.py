"""Spin-stabilised projectile: steady wobble about its flight path (chapter, Problem 6.20).

The mass centre C moves uniformly; a frame that moves with it is inertial, and the body turns about C. Z is the
direction of flight, theta the angle of the symmetry axis from it. The drag acts at the centre of pressure,
ahead of C: its moment is overturning.
"""

from __future__ import annotations

import math
from typing import Any

import freebody as fb

from ....space.shape import Shape
from ...tools.answer import Answers, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import placed, together
from ...tools.pictures import tip
from ...tools.precession import least_spin, steady_rates, steady_root


def look(h: Any) -> Shape:
    """Return the shell as it is drawn, with its tip along z."""
    return together(
        placed(fb.cylinder(1, h / 2, 3 * h), (0, 0, -h / 2)),
        placed(fb.cone(1, h / 2, 2 * h), (0, 0, 3 * h / 2)),
    )


def shell_in(axis: str, angles: str) -> fb.System:
    """Return a symmetric body on a gimbal at its mass centre, with the drag along -Z; its mass has no effect."""
    s = fb.System("projectile")
    D, h, I_T, I_S = s.parameters(D=150.0, h=0.03, I_T=3.0e-4, I_S=4.5e-5)
    s.parameters(alpha="3deg", Omega=2500.0)
    s.assume(D > 0, h > 0, I_T > 0, I_S > 0)
    inertia = ((I_T, 0, 0), (0, I_T, 0), (0, 0, I_S))
    shell = s.body("shell", fb.MassProperties(1, (0, 0, 0), inertia), shape=look(h))
    nothing = fb.MassProperties(0, (0, 0, 0), ((0, 0, 0), (0, 0, 0), (0, 0, 0)))
    flight = s.body("flight", nothing, shape="nothing")  # moves with C, at the constant velocity
    s.weld("moving", s.ground, flight)
    s.gimbal("C", flight, shell, axis=axis, coordinate=angles)
    s.force("drag", shell.point(0, 0, h), (0, 0, -D))
    explain(
        s,
        D="N: drag, opposite to the velocity",
        h="m: distance of the centre of pressure ahead of the mass centre",
        I_T="kg m²: transverse moment of inertia about the mass centre",
        I_S="kg m²: moment of inertia about the symmetry axis",
        alpha="rad: angle of the symmetry axis from the velocity",
        Omega="rad/s: total spin along the symmetry axis, for the wobble rates",
    )
    return s


def build() -> fb.System:
    """Return the shell in Euler angles."""
    s = shell_in("ZXZ", "psi theta phi")
    explain(
        s,
        theta="rad: angle of the symmetry axis from the velocity",
        psi="rad: turn of the symmetry axis about the velocity",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    case.refuse_unless(
        "alpha", 0 <= case["alpha"] < math.pi / 2,
        "an angle from 0 to below pi/2; a shell that flies backwards is stable without spin",
    )  # fmt: skip
    how = "equation of motion of theta: both rates equal"
    rates = steady_rates(case, "alpha", spin="Omega")
    answers: Answers = {
        "Omega_min": case.formula(
            "smallest spin with a steady wobble at alpha", least_spin(case, "alpha", "Omega"), "rad/s", how
        ),
        "Omega_limit": case.formula(
            "its limit as alpha goes to 0", least_spin(case, 0, "Omega"), "rad/s", how + ", at theta = 0"
        ),
        "omega_fast": rates["psi'_fast"],
        "omega_slow": rates["psi'_slow"],
    }
    fast, slow, exists = steady_root(case, "alpha", "Omega")
    cosine = math.cos(case["alpha"])
    starts = [
        {"theta": case["alpha"], "psi'": rate, "phi'": case["Omega"] - rate * cosine}
        for rate in ([case.number(slow), case.number(fast)] if exists else [0.0])
    ]
    if not case["alpha"]:
        return Solved(straight(case), answers, {}, ())
    checks = tuple(
        same(
            f"theta stays at alpha in the {kind} wobble", motion["theta"], case["alpha"], 1e4 * case.tolerance
        )
        for kind, motion in zip(
            ("slow", "fast"), (case.simulate(0.05, initial=one) for one in starts), strict=False
        )
        if exists
    )
    trajectory = case.motion(initial={**starts[0], "theta'": case["Omega"] / 1000})
    plots: Plots = {
        "theta.png": saved(lambda: history(trajectory, "theta", title="Shell: angle from its flight path")),
        "axis.png": saved(
            lambda: tip(trajectory, "shell", "Shell: path of its axis", about=("velocity", (0, 0, 1)))
        ),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def straight(case: Case) -> fb.Trajectory:
    """Simulate a slightly disturbed flight along the axis; two tilts replace psi and phi, which are one angle there."""
    start = {"phi'": case["Omega"], "alpha_x'": case["Omega"] / 1000}
    until, values = case.until, case.values
    return fb.simulate(
        shell_in("XYZ", "alpha_x alpha_y phi"), until, initial=start, values=values, tolerance=case.tolerance
    )


PROJECTILE = Entry(
    "prob-6-20",
    ("projectile", "spinning-shell"),
    "Spin-stabilised projectile: steady wobble (Problem 6.20)",
    (
        "smallest spin for a steady wobble at the angle alpha, and its limit as alpha goes to 0",
        "both wobble rates at the spin Omega",
    ),
    build,
    solve,
    until=0.1,
    start={"theta": "alpha", "phi'": "Omega"},
)
