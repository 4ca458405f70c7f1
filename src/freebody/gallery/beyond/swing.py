"""Swing pumped by its rider, who stands up at the bottom and squats at the ends.

theta is the angle of the rope from the downward vertical, counter-clockwise +. The mass centre of the rider is at the
distance L + a sin(Omega t) from the pivot, driven by the rider's legs; at the start, the end of a swing, it sinks.
"""

from __future__ import annotations

import math
from dataclasses import replace

import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain, happened, states
from ..tools.entry import Entry
from ..tools.looks import placed

START = {"theta": "theta_0"}


def build() -> fb.System:
    """Return the massless rope on a hinge, with the rider on a driven slider along it."""
    s = fb.System("swing")
    m, L, a, Omega, g = s.parameters(m=50.0, L=2.2, a=0.15, Omega="2*sqrt(9.81/2.2)", g=9.81)
    s.parameters(theta_0="10deg", theta_1="60deg", t_1="10*pi/sqrt(9.81/2.2)")
    s.gravity = (0, -g, 0)
    rope = s.body("rope", fb.particle(0), shape=placed(fb.slender_bar(1, L, axis="y"), (0, -L / 2, 0)))
    rider = s.body("rider", fb.particle(m))
    s.hinge("pivot", s.ground, rope, axis="z", coordinate="theta")
    s.slider("legs", rope, rider, axis=(0, -1, 0), coordinate=L + a * sympy.sin(Omega * s.t))
    explain(
        s,
        m="kg: mass of the rider",
        L="m: mean distance of the rider's mass centre from the pivot",
        a="m: amplitude of this distance",
        Omega="rad/s: frequency of pumping, twice that of the swing",
        g="m/s²: gravity",
        theta_0="rad: angle at the start, at rest",
        theta_1="rad: angle to reach",
        t_1="s: time to answer for",
        theta="rad: angle of the rope from the downward vertical, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, reaction, saved

    case.refuse_unless("Omega", case["Omega"] > 0, "a frequency above 0")
    case.refuse_unless("a", abs(case["a"]) < case["L"], "an amplitude below L")
    case.refuse_unless(
        "theta_0",
        0 < case["theta_0"] < case["theta_1"],
        "a start above 0 and below theta_1, which is to be reached",
    )
    at = case.simulate_to([0.0, case["t_1"]], initial=START)
    high = [
        fb.event("theta - theta_1", name="reached", direction=1, terminal=True),
        fb.event("theta + theta_1", name="reached", direction=-1, terminal=True),
    ]
    # at least twenty strokes, even if the drawn run is shorter
    long = replace(case, until=max(case.until, 40 * math.pi / case["Omega"]))
    run = long.simulate_past("reached", 1, initial=START, events=high)
    how = "fb.simulate"
    answers: Answers = {"equation": case.equation(0, "equation of motion of theta")}
    answers |= states(at, 1, {"theta": "rad", "theta'": "rad/s"}, "t_1")
    pull = at.reactions["legs"].force[1] @ at.poses["rope"].rotation[1][:, 1]
    answers["F(t_1)"] = Answer(
        "force of the rope on the rider at t_1, towards the pivot +",
        float(pull),
        "N",
        how=how + ", reactions",
    )
    answers["W(t_1)"] = Answer(
        "work that the rider's legs have done by t_1",
        float(at.energy.work[1]),
        "J",
        how=how + ", energy ledger",
    )
    answers["t_f"] = Answer(
        "time at which the swing first reaches theta_1 on either side",
        float(happened(run, "reached")[0].time), "s", how=how + ", event located",
    )  # fmt: skip
    gained = at.energy.total[1] - at.energy.total[0]
    checks = (
        same("work of the legs against the energy gained", at.energy.work[1], gained, 1000 * case.tolerance),
    )
    marks = [fb.event("abs(theta) - theta_1", name="theta_1")]
    trajectory = case.motion(initial=START, events=marks)
    plots: Plots = {
        "theta.png": saved(lambda: history(trajectory, "theta", title="Swing, pumped by its rider")),
        "rope.png": saved(lambda: reaction(trajectory, "legs", axes="xy")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


SWING = Entry(
    "pumped-swing",
    ("swing",),
    "Swing pumped by its rider (beyond the chapter)",
    (
        "equation of motion",
        "angle and speed at t_1, force of the rope and work of the legs",
        "when the swing reaches the angle theta_1",
    ),
    build,
    solve,
    until=20.0,
    positive=("L", "a", "g"),
    start=START,
)
