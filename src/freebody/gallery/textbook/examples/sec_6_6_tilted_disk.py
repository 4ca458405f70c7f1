"""Thin disk fixed askew on a shaft that turns at a constant rate (chapter, section 6.6).

The disk's normal is (0, sin(beta), cos(beta)) in the body axes; its centre is on the shaft, midway between the
bearings.
"""

from __future__ import annotations

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

STATE = {"theta": "omega*t_1", "theta'": "omega", "theta''": 0}
START = {"theta'": "omega"}


def build() -> fb.System:
    """Return the disk, rotated by -beta about x, on a hinge along Z."""
    s = fb.System("tilted_disk")
    m, R, L, _ = s.parameters(m=20.0, R=0.2, L=0.6, g=9.81)
    s.assume(L > 0)
    beta, *_ = s.parameters(beta="5deg", omega=100.0, t_1=0.012)
    tilted = fb.disk(m, R).rotated(fb.Rotation.axis_angle("x", -beta))
    disk = s.body("disk", tilted, shape=with_shaft(tilted, L))
    on_shaft(s, disk)
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the disk",
        beta="rad: angle of the disk's normal from the shaft",
        omega="rad/s: angular velocity of the shaft",
        t_1="s: time to answer for",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    answers: Answers = {
        "I_yz": product_of_inertia(case, "disk"),
        "R_dynamic": dynamic_amplitude(case, case.atoms["omega"]),
        **reactions(case, STATE, "at t_1"),
    }
    at = case.simulate_to([case["t_1"]], initial=START)
    trajectory = case.motion(initial=START)
    checks = (against_simulation(case, answers, at),)
    return Solved(trajectory, answers, plots(case, trajectory, "Tilted disk: forces on the shaft"), checks)


TILTED_DISK = Entry(
    "sec-6-6",
    ("tilted-disk",),
    "Thin disk fixed askew on a turning shaft: bearing reactions (section 6.6)",
    (
        "product of inertia I_yz about the midpoint",
        "amplitude of the dynamic reaction",
        "reactions R_AX, R_AY, R_BX, R_BY on the shaft at t_1",
    ),
    build,
    solve,
    until=0.2,
    start=START,
)
