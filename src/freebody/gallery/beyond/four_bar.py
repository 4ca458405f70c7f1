"""Four-bar linkage, a crank-rocker: the shortest bar makes full turns, the opposite bar rocks.

Bars a (crank), b (coupler), c (rocker) and the ground d, with a + the longest < the sum of the other two (Grashof).
The crank is driven at constant speed; gravity acts.
"""

from __future__ import annotations

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved
from ..tools.case import Case, explain
from ..tools.entry import Entry


def build() -> fb.System:
    """Return the linkage: the coupler hangs on the crank, and its hinge on the rocker closes the loop."""
    s = fb.System("four_bar")
    a, b, c, d, omega = s.parameters(a=0.1, b=0.3, c=0.2, d=0.3, omega=6.0)
    rho, g, t_1 = s.parameters(rho=4.0, g=9.81, t_1=0.4)
    s.gravity = (0, -g, 0)
    crank, coupler, rocker = (
        s.body(name, fb.slender_bar(rho * length, length))
        for name, length in (("crank", a), ("coupler", b), ("rocker", c))
    )
    s.hinge("A", s.ground, crank, to=(-a / 2, 0, 0), coordinate=omega * s.t)
    s.hinge("B", crank, coupler, at=(a / 2, 0, 0), to=(-b / 2, 0, 0), coordinate="beta")
    s.hinge("D", s.ground, rocker, at=(d, 0, 0), to=(-c / 2, 0, 0), coordinate="psi")
    s.hinge("C", rocker, coupler, at=(c / 2, 0, 0), to=(b / 2, 0, 0))
    explain(
        s,
        a="m: length of the crank",
        b="m: length of the coupler",
        c="m: length of the rocker",
        d="m: distance of the fixed hinges",
        omega="rad/s: angular velocity of the crank",
        rho="kg/m: mass of the bars per length",
        g="m/s²: gravity",
        t_1="s: time to answer for",
        beta="rad: angle of the coupler from the crank",
        psi="rad: angle of the rocker from the x axis",
    )
    return s


NEAR = {"beta": 1.3, "psi": 2.0}
"""Guess of the assembly with the coupler above the line of the fixed hinges."""


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, reaction, saved

    at = case.simulate_to([case["t_1"]], near=NEAR)
    here = {name: float(at[name][0]) for name in ("beta", "psi", "beta'", "psi'", "t")}
    ends = [
        fb.event("psi'", name="greatest psi", direction=-1),
        fb.event("psi'", name="least psi", direction=1),
    ]
    swing = case.simulate_past("greatest psi", 2, near=NEAR, events=ends)
    angles = {event.name: event.state["psi"] for event in swing.events if event.time > 0}
    trajectory = case.motion(near=NEAR)
    answers: Answers = {
        "psi(t_1)": Answer("psi at t_1", here["psi"], "rad"),
        "psi'(t_1)": Answer("psi' at t_1", here["psi'"], "rad/s"),
        "psi''(t_1)": Answer("psi'' at t_1", case.accelerations(here)["psi''"], "rad/s²"),
        "psi_max": Answer("greatest psi", angles["greatest psi"], "rad"),
        "psi_min": Answer("least psi", angles["least psi"], "rad"),
        "torque(t_1)": Answer("torque on the crank at t_1", float(at.reactions["A"].moment[0, 2]), "N m"),
        "force(t_1)": Answer(
            "force of the rocker on the coupler at t_1", tuple(at.reactions["C"].force[0, :2].tolist()), "N"
        ),
        "indeterminate": Answer(
            "reactions that no motion determines", ", ".join(trajectory.indeterminate), ""
        ),
    }
    plots: Plots = {
        "rocker.png": saved(
            lambda: history(trajectory, "psi", title="Four-bar linkage: angle of the rocker")
        ),
        "hinge.png": saved(lambda: reaction(trajectory, "C", axes="xy")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


FOUR_BAR = Entry(
    "four-bar",
    ("crank-rocker",),
    "Four-bar linkage with a driven crank (crank-rocker)",
    (
        "angle, speed and acceleration of the rocker at t_1",
        "its extreme angles",
        "torque on the crank, hinge force",
    ),
    build,
    solve,
    until=2.5,
    near=NEAR,
)
