"""Uniform bar hinged at a third of its length, let go in the horizontal position (chapter, Example 6.2).

theta is the angle from the horizontal, counter-clockwise +: the long right part falls, so theta turns negative.
"""

from __future__ import annotations

import freebody as fb

from .entry import Answers, Case, Entry, Plots, explain

VERTICAL = fb.event("cos(theta)", name="vertical", terminal=True)


def build() -> fb.System:
    """The bar lies along x at theta = 0; its hinge is L/6 to the left of its centre."""
    s = fb.System("hinged_bar")
    m, L, g = s.parameters(m=3.0, L=1.5, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="x"))
    s.hinge("pin", s.ground, bar, to=(-L / 6, 0, 0), axis="z", coordinate="theta")
    explain(
        s,
        m="kg: mass of the bar",
        L="m: length of the bar",
        g="m/s²: gravity",
        theta="rad: angle from the horizontal, counter-clockwise",
    )
    return s


def solve(case: Case) -> tuple[fb.Trajectory, Answers, Plots]:
    from ..picture.plots import energy_residual, history, reaction, saved

    release = {"theta": 0, "theta'": 0}
    start = case.accelerations(release)
    R = case.equations.reactions["pin"].force[1]
    swing = case.simulate_past("vertical", 1, events=[VERTICAL])
    answers: Answers = {
        "alpha after release (counter-clockwise +)": (start["theta''"], "rad/s²"),
        "vertical reaction R after release (up +)": (case.number(R, {**release, **start}), "N"),
        "omega_2 when first vertical (counter-clockwise +)": (float(swing["theta'"][-1]), "rad/s"),
        "vertical reaction then (up +)": (float(swing.reactions["pin"].force[-1, 1]), "N"),
        "kinetic energy T_2 then": (float(swing.energy.kinetic[-1]), "J"),
    }
    trajectory = case.motion(events=[fb.event("cos(theta)", name="vertical")])
    plots: Plots = {
        "theta.png": saved(lambda: history(trajectory, "theta", title="Bar hinged at its third point")),
        "reaction.png": saved(lambda: reaction(trajectory, "pin", axes="xy")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return trajectory, answers, plots


HINGED_BAR = Entry(
    "ex-6-2",
    ("hinged-bar",),
    "Bar hinged at its third point, released horizontal (Example 6.2)",
    (
        "just after release: angular acceleration, reaction",
        "first vertical: angular velocity, reaction, kinetic energy",
    ),
    build,
    solve,
    until=3.0,
)
