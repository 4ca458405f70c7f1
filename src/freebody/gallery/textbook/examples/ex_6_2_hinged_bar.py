"""Uniform bar hinged at a third of its length, let go in the horizontal position (chapter, Example 6.2).

theta is the angle from the horizontal, counter-clockwise +: the long right part falls, so theta turns negative.
"""

from __future__ import annotations

import sympy

import freebody as fb

from ...tools.answer import Answers, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry

RELEASE = {"theta": 0, "theta'": 0}
VERTICAL = {"theta": "-pi/2"}


def build() -> fb.System:
    """Return the system; the bar lies along x at theta = 0, and its hinge is L/6 to the left of its centre."""
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


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, reaction, saved

    e = case.equations
    start = e.solve(["theta''", "pin_y"], where=RELEASE)
    square = case.square_of_speed("theta'", RELEASE, VERTICAL)
    below = e.solve(["theta''", "pin_y"], where=VERTICAL)
    by_energy = "energy integral, from the release to the vertical"
    answers: Answers = {
        "alpha": case.formula(
            "angular acceleration just after release, counter-clockwise +",
            start["theta''"], "rad/s²", 'fb.equations(s).solve("theta\'\'")',
        ),
        "R_1": case.formula(
            "vertical reaction on the bar at the hinge just after release, up +",
            start["pin_y"], "N", 'fb.equations(s).solve("pin_y")',
        ),
        "omega_2": case.formula(
            "angular velocity when the bar is first vertical, counter-clockwise +",
            -sympy.sqrt(square), "rad/s", by_energy,
        ),
        "R_2": case.formula(
            "vertical reaction on the bar then, up +",
            below["pin_y"].subs(case.atoms["theta'"], sympy.sqrt(square)), "N", by_energy + ', then solve("pin_y")',
        ),
        "T_2": case.formula(
            "kinetic energy then",
            case.put(e.energy.kinetic, {**VERTICAL, "theta'": sympy.sqrt(square)}), "J", by_energy,
        ),
    }  # fmt: skip
    swing = case.simulate_past("vertical", 1, events=[fb.event("cos(theta)", name="vertical", terminal=True)])
    bound = 1000 * case.tolerance
    checks = (
        same("omega_2 against the simulation", answers["omega_2"].value, swing["theta'"][-1], bound),
        same("R_2 against the simulation", answers["R_2"].value, swing.reactions["pin"].force[-1, 1], bound),
        same("T_2 against the simulation", answers["T_2"].value, swing.energy.kinetic[-1], bound),
    )
    trajectory = case.motion(events=[fb.event("cos(theta)", name="vertical")])
    plots: Plots = {
        "theta.png": saved(lambda: history(trajectory, "theta", title="Bar hinged at its third point")),
        "reaction.png": saved(lambda: reaction(trajectory, "pin", axes="xy")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


HINGED_BAR = Entry(
    "ex-6-2",
    ("hinged-bar",),
    "Bar hinged at its third point, released horizontal (Example 6.2)",
    (
        "just after release: angular acceleration, vertical reaction",
        "first vertical: angular velocity, vertical reaction, kinetic energy",
    ),
    build,
    solve,
    until=3.0,
)
