"""Hanging bar struck by a horizontal force: centre of percussion (chapter, Problem 6.4).

theta is the angle from the downward vertical, counter-clockwise +; the force acts to the right at the distance h
below the hinge.
"""

from __future__ import annotations

import freebody as fb

from ...tools.answer import Answers, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry

REST = {"theta": 0, "theta'": 0}


def build() -> fb.System:
    """Return the system; the bar hangs along y at theta = 0, with its upper end on the hinge O."""
    s = fb.System("percussion")
    m, L, F, h_1 = s.parameters(m=2.0, L=1.2, F=100.0, h_1=0.2)
    s.parameters(h_2=1.1)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("O", s.ground, bar, to=(0, L / 2, 0), axis="z", coordinate="theta")
    s.force("F", bar.point(0, L / 2 - h_1, 0), (F, 0, 0))
    explain(
        s,
        m="kg: mass of the bar",
        L="m: length of the bar",
        F="N: force, to the right",
        h_1="m: distance of the force below the hinge",
        h_2="m: another distance of the force below the hinge",
        theta="rad: angle from the downward vertical, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, reaction, saved

    for name in ("h_1", "h_2"):
        case.refuse_unless(name, 0 <= case[name] <= case["L"], "a force that strikes the bar, from 0 to L")
    struck = case.equations.solve(["theta''", "O_x"], where=REST)
    free = case.equations.solve(["theta''", "h_1"], where={**REST, "O_x": 0})
    other = {case.atoms["h_1"]: case.atoms["h_2"]}
    how = 'fb.equations(s).solve(["theta\'\'", "O_x"])'
    answers: Answers = {
        "h": case.formula(
            "distance below the hinge at which the force leaves no horizontal reaction",
            free["h_1"], "m", 'fb.equations(s).solve(["theta\'\'", "h_1"], where={"O_x": 0})',
        ),
        "alpha": case.formula(
            "angular acceleration then, counter-clockwise +", free["theta''"], "rad/s²", "the same solution"
        ),
        "R_x_1": case.formula(
            "horizontal reaction on the bar for a force at h_1, right +", struck["O_x"], "N", how
        ),
        "R_x_2": case.formula(
            "horizontal reaction on the bar for a force at h_2, right +", struck["O_x"].xreplace(other), "N", how
        ),
    }  # fmt: skip
    centre = fb.centre_of_percussion(case.equations, "O")
    bound = 1000 * case.tolerance
    checks = [same("h against fb.centre_of_percussion", answers["h"].value, case.number(centre), bound)]
    for key, distance in (("R_x_1", case["h_1"]), ("R_x_2", case["h_2"]), ("none", answers["h"].value)):
        start = case.having(h_1=distance).simulate_to([0.0]).reactions["O"].force[0, 0]
        expected = answers[key].value if key in answers else 0.0
        checks.append(
            same(f"reaction for a force at {distance:g} m against the simulation", start, expected, bound)
        )
    trajectory = case.motion()
    plots: Plots = {
        "theta.png": saved(lambda: history(trajectory, "theta", title="Struck bar: the force goes on")),
        "reaction.png": saved(lambda: reaction(trajectory, "O", axes="xy")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks))


PERCUSSION = Entry(
    "prob-6-4",
    ("centre-of-percussion", "struck-bar"),
    "Hanging bar struck by a force: centre of percussion (Problem 6.4)",
    (
        "where the force leaves no horizontal reaction at the hinge, and the angular acceleration then",
        "horizontal reaction for a force at h_1 and at h_2",
    ),
    build,
    solve,
    until=0.3,
)
