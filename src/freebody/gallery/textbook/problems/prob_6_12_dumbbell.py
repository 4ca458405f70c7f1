"""Dumbbell fixed askew on a shaft that turns at a constant rate (chapter, Problem 6.12).

Two particles at ±a (0, sin(beta), cos(beta)) in the body axes, their midpoint on the shaft midway between the
bearings.
"""

from __future__ import annotations

import sympy

import freebody as fb

from ...tools.answer import Answers, Solved
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import with_shaft
from ...tools.shaft import (
    against_simulation,
    dynamic_amplitude,
    on_shaft,
    plots,
    product_of_inertia,
    reactions,
)

STATE = {"theta": "theta_1", "theta'": "omega", "theta''": 0}
START = {"theta": "theta_1", "theta'": "omega"}


def build() -> fb.System:
    """Return two particles welded into one body on a hinge along Z."""
    s = fb.System("dumbbell")
    m, a, L, _ = s.parameters(m=0.5, a=0.15, L=0.6, g=9.81)
    s.assume(L > 0)
    beta, *_ = s.parameters(beta="30deg", omega=50.0, theta_1="40deg")
    place = (0, a * sympy.sin(beta), a * sympy.cos(beta))
    ends = fb.particle(m).moved(place) + fb.particle(m).moved(tuple(-x for x in place))
    on_shaft(s, s.body("dumbbell", ends, shape=with_shaft(ends, L)))
    explain(
        s,
        m="kg: mass of each particle",
        a="m: half the length of the rod",
        beta="rad: angle of the rod from the shaft",
        omega="rad/s: angular velocity of the shaft",
        theta_1="rad: angle of the shaft to answer for",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    answers: Answers = {
        "I_yz": product_of_inertia(case, "dumbbell"),
        "R_dynamic": dynamic_amplitude(case, case.atoms["omega"]),
        **reactions(case, STATE, "at theta_1"),
    }
    at = case.simulate_to([0], initial=START)
    trajectory = case.motion(initial=START)
    checks = (against_simulation(case, answers, at),)
    return Solved(trajectory, answers, plots(case, trajectory, "Dumbbell: forces on the shaft"), checks)


DUMBBELL = Entry(
    "prob-6-12",
    ("dumbbell",),
    "Dumbbell fixed askew on a turning shaft: bearing reactions (Problem 6.12)",
    (
        "product of inertia I_yz",
        "amplitude of the dynamic reaction",
        "reactions R_AX, R_AY, R_BX, R_BY on the shaft at theta_1",
    ),
    build,
    solve,
    until=0.4,
    start=START,
)
