"""Box on two feet, pulled at its upper rear corner while it slides (chapter, Example 6.1).

x is to the right, in the direction of sliding; A is the rear foot, B the front foot; theta is counter-clockwise.
"""

from __future__ import annotations

import sympy

import freebody as fb

from ...tools.answer import Answers, Plots, Solved, fact, same
from ...tools.case import Case, explain
from ...tools.entry import Entry

LEVEL = {"theta": 0, "theta'": 0}
START = {"x'": 2.0}
SLIDING = {"A": "slip+", "B": "slip+"}


def build() -> fb.System:
    """Return the system; x, y are displacements of the centre from the position with both feet on the floor."""
    s = fb.System("sliding_body")
    m, L, H, D, mu, F = s.parameters(m=50.0, L=1.2, H=0.8, D=0.15, mu=0.25, F=200.0)
    beta, g = s.parameters(beta="20deg", g=9.81)
    s.gravity = (0, -g, 0)
    body = s.body("body", fb.box(m, (L, H, L)))
    foot = -(H / 2 + D)
    s.planar("plane", s.ground, body, at=(0, -foot, 0), coordinate="x y theta")
    s.contact("A", body.point(-L / 2, foot, 0), s.ground.plane(), friction=mu)
    s.contact("B", body.point(L / 2, foot, 0), s.ground.plane(), friction=mu)
    s.force("F", body.point(-L / 2, H / 2, 0), (F * sympy.cos(beta), F * sympy.sin(beta), 0))
    explain(
        s,
        m="kg: mass of the body",
        L="m: length of the body, and distance of its feet",
        H="m: height of the body",
        D="m: length of its feet",
        mu="1: kinetic friction at both feet",
        F="N: force on the upper left corner",
        beta="rad: angle of the force above the horizontal",
        g="m/s²: gravity",
        x="m: displacement of the centre to the right",
        y="m: height of the centre above that on both feet",
        theta="rad: turn of the body, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    e = case.equations
    unknowns = ["x''", "N_A", "N_B"]
    solution = e.solve(unknowns, where=LEVEL)
    tipping = e.solve(["F", "x''", "N_B"], where={**LEVEL, "N_A": 0})
    stands = case.number(solution["N_A"]) >= 0
    shown, how = case, 'fb.equations(s, modes={"A": "slip+", "B": "slip+"}).solve'
    state = "both feet slide on the floor"
    forces = {name: solution[name] for name in unknowns}
    if not stands:  # it tips about B
        shown, how = case.touching(B="slip+"), 'fb.equations(s, modes={"B": "slip+"}).solve'
        state = "tips: foot A leaves the floor"
        turning = shown.equations.solve(["x''", "N_B"], where=LEVEL)
        forces = {"x''": turning["x''"], "N_A": sympy.Integer(0), "N_B": turning["N_B"]}
    limit = 'solve("F", where={"N_A": 0})'
    answers: Answers = {
        "a_x": shown.formula(f"(1) acceleration to the right under F ({state})", forces["x''"], "m/s²", how),
        "N_A": shown.formula("(1) normal force at the rear foot A", forces["N_A"], "N", how),
        "N_B": shown.formula("(1) normal force at the front foot B", forces["N_B"], "N", how),
        "F_tip": case.formula("(2) force on the verge of tipping, N_A = 0", tipping["F"], "N", limit),
        "a_tip": case.formula("(2) acceleration then", tipping["x''"], "m/s²", limit),
        "N_B_tip": case.formula("(2) normal force at B then", tipping["N_B"], "N", limit),
    }
    trajectory = case.motion(initial=START)
    now = case.simulate_to([0], initial=START)
    bound = 1000 * case.tolerance
    F_tip = answers["F_tip"].value
    checks = [
        same("N_A and N_B against the simulation", [answers["N_A"].value, answers["N_B"].value],
             [now.contacts[foot].least[0, 0] for foot in "AB"], bound),
    ]  # fmt: skip
    for part, feet in ((1 - 1e-6, ("slip", "slip")), (1 + 1e-6, ("open", "slip"))):
        if F_tip > 0:
            near = case.having(F=F_tip * part)
            modes = near.simulate_to([0], initial=START).contacts
            checks.append(
                fact(f"{'slides on A and B at F_tip less' if part < 1 else 'A lifts at F_tip plus'} 1e-6 of it",
                     all(modes[foot].mode[0].rstrip("+") == one for foot, one in zip("AB", feet, strict=True)))
            )  # fmt: skip
    plots: Plots = {
        "speed.png": saved(lambda: history(trajectory, ["x", "x'"], title="Sliding body")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks), shown.equations)


SLIDING_BODY = Entry(
    "ex-6-1",
    ("sliding-body",),
    "Body sliding on two feet, pulled until it tips (Example 6.1)",
    (
        "(1) acceleration and normal forces under F",
        "(2) force on the verge of tipping, acceleration and force then",
    ),
    build,
    solve,
    until=0.5,
    positive=("g",),
    start=START,
    modes=SLIDING,
)
