"""Door whose hinge line leans from the vertical (chapter, Problem 6.5).

Y is up; the hinge line leans by alpha towards -X. theta is the rotation of the door about it from equilibrium, in
which its free edge is lowest.
"""

from __future__ import annotations

import math

import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved, same
from ...tools.case import Case, explain, happened
from ...tools.entry import Entry


def build() -> fb.System:
    """Return the system; the hinge line is y of the tilted frame, and the door extends from it along its own -x."""
    s = fb.System("door")
    m, b, h, alpha, g = s.parameters(m=25.0, b=0.9, h=2.0, alpha="10deg", g=9.81)
    s.parameters(theta_0="20deg")
    s.gravity = (0, -g, 0)
    door = s.body("door", fb.plate(m, (b, h), normal="z"))
    c, n = sympy.cos(alpha), sympy.sin(alpha)
    tilt = ((c, -n, 0), (n, c, 0), (0, 0, 1))
    s.hinge("line", s.ground, door, to=(b / 2, 0, 0), axis="y", parent_axes=tilt, coordinate="theta")
    explain(
        s,
        m="kg: mass of the door",
        b="m: width, from the hinge line to the free edge",
        h="m: height",
        alpha="rad: angle of the hinge line from the vertical",
        g="m/s²: gravity",
        theta_0="rad: amplitude of the free oscillation",
        theta="rad: turn of the door about the hinge line from equilibrium",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, reaction, saved

    case.refuse_unless(
        "alpha", 0 < case["alpha"] < math.pi, "a hinge line that leans, 0 < alpha < 180 degrees"
    )
    case.refuse_unless("theta_0", 0 < case["theta_0"] < math.pi, "an amplitude between 0 and 180 degrees")
    (square,) = fb.linearize(case.equations).M.LUsolve(fb.linearize(case.equations).K)
    swing = case.simulate_past(
        "middle", 2, initial={"theta": "theta_0"}, events=[fb.event("theta", name="middle")]
    )
    first, second = (event.time for event in happened(swing, "middle")[:2])
    answers: Answers = {
        "equation": case.equation(0, "equation of motion"),
        "omega_n": case.formula(
            "natural frequency of small motion", sympy.sqrt(square), "rad/s", "fb.linearize(s): sqrt(K / M)"
        ),
        "T": Answer(
            "period of the free oscillation of amplitude theta_0", 2 * (second - first), "s",
            how="fb.simulate, twice the time between two passages of the middle",
        ),
    }  # fmt: skip
    speed = case.square_of_speed("theta'", {"theta": case["theta_0"], "theta'": 0}, {"theta": 0})
    checks = (
        same("a half swing ends where it began", first, (second - first) / 2, 1000 * case.tolerance),
        same(
            "speed in the middle against the energy integral",
            happened(swing, "middle")[0].state["theta'"] ** 2,
            case.number(speed),
            1000 * case.tolerance,
        ),
    )
    trajectory = case.motion(initial={"theta": "theta_0"})
    plots: Plots = {
        "theta.png": saved(lambda: history(trajectory, "theta", title="Door with a leaning hinge line")),
        "hinge.png": saved(lambda: reaction(trajectory, "line")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


DOOR = Entry(
    "prob-6-5",
    ("door",),
    "Door with an inclined hinge line (Problem 6.5)",
    (
        "equation of motion",
        "natural frequency of small motion",
        "exact period of the free oscillation of amplitude theta_0",
    ),
    build,
    solve,
    until=10.0,
    positive=("g",),
    start={"theta": "theta_0"},
)
