"""Car under a cable, hung from two wheels of which one is driven (chapter, Problem 6.3).

x is forward, to the right. The wheels have no mass, so no force along the cable acts on a wheel that rolls freely. The
rim of the driven wheel, at its limit, slips backwards over the cable: there the friction is mu N, forward. In the run
the rim is a point of the car, which therefore moves backwards while this force accelerates it forward.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import sympy

import freebody as fb

from ....space.shape import Shape
from ...tools.answer import Answer, Answers, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import box_between, together, wheel

LEVEL = {"theta": 0, "theta'": 0}
WHEELS = ("front", "rear")


def look(span: Any, h: Any) -> Shape:
    """Return the car as it is drawn: it hangs from two wheels that run on top of the cable."""
    r, ends = h / 6, (span / 2, -span / 2)
    return together(
        *(wheel(r, (x, h + r, 0)) for x in ends),
        *(box_between((x - r / 3, h / 2, 0), (x + r / 3, h + r, 0)) for x in ends),
        box_between((-3 * span / 5, -h / 2, 0), (3 * span / 5, h / 2, 0)),
    )


def build(driven: str = "front") -> fb.System:
    """Return the system; the cable is the x axis with the wheels on top of it, and x, y belong to the mass centre."""
    s = fb.System("monorail")
    m, span, h, mu, g = s.parameters(m=2000.0, l=4.0, h=1.5, mu=0.5, g=9.81)
    s.gravity = (0, -g, 0)
    car = s.body("car", fb.box(m, (span, h, h)), shape=look(span, h))
    s.planar("plane", s.ground, car, at=(0, -h, 0), coordinate="x y theta")
    for name, x in (("front", span / 2), ("rear", -span / 2)):
        s.contact(name, car.point(x, h, 0), s.ground.plane(), friction=mu if name == driven else 0)
    explain(
        s,
        m="kg: mass of the car",
        l="m: distance of the wheels",
        h="m: depth of the mass centre below the cable",
        mu="1: friction between the driven wheel and the cable",
        g="m/s²: gravity",
        x="m: displacement of the mass centre",
        y="m: height of the mass centre above that at rest",
        theta="rad: pitch, counter-clockwise",
    )
    return s


def modes(driven: str) -> dict[str, str]:
    """Return the contact modes with one wheel driven."""
    return {name: "slip-" if name == driven else "slip" for name in WHEELS}


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    solutions, cases, friction = {}, {}, {}
    for driven, other in (WHEELS, WHEELS[::-1]):
        s = case.system if driven == "front" else build(driven)
        variant = cases[driven] = replace(case, system=s, equations=fb.equations(s, modes=modes(driven)))
        unknowns = ["x''", "N_front", "N_rear"]
        limit = dict(variant.equations.solve(unknowns, where=LEVEL))
        friction[driven] = case["mu"]
        if variant.number(limit["x''"]) <= 0 or variant.number(limit[f"N_{other}"]) < 0:
            # the friction cannot be used fully: the other wheel lifts off first
            lifting = variant.equations.solve(["x''", f"N_{driven}", "mu"], where={**LEVEL, f"N_{other}": 0})
            limit = {**lifting, f"N_{other}": sympy.Integer(0)}
            friction[driven] = variant.number(lifting["mu"])
        solutions[driven] = limit
    best = {driven: cases[driven].number(solutions[driven]["x''"]) for driven in WHEELS}
    better = max(WHEELS, key=best.__getitem__)
    how = 'fb.equations(s, modes={"front": "slip-", "rear": "slip"}).solve, and the other way round'
    answers: Answers = {
        "driven": Answer("(1) which wheel should be driven", better, "", None, "a_front and a_rear"),
    }
    for driven in WHEELS:
        answers[f"a_{driven}"] = cases[driven].formula(
            f"(2) largest acceleration with the {driven} wheel driven", solutions[driven]["x''"], "m/s²", how
        )
    for end in WHEELS:
        answers[f"N_{end}"] = cases[better].formula(
            f"(2) load of the {end} wheel then, {better} wheel driven",
            solutions[better][f"N_{end}"],
            "N",
            how,
        )
    checks = []
    for driven, variant in cases.items():
        # slightly less if a wheel is about to lift off
        used = friction[driven] if friction[driven] == case["mu"] else friction[driven] * (1 - 1e-9)
        begun = {"x'": -2 * best[driven] * case.until}
        now = variant.having(mu=used).simulate_to([0, case.until], initial=begun)
        checks += [
            same(f"acceleration against the simulation, {driven} wheel driven",
                 (now["x'"][1] - now["x'"][0]) / case.until, best[driven], 1000 * case.tolerance),
            same(f"wheel loads against the simulation, {driven} wheel driven",
                 [now.contacts[wheel].least[-1, 0] for wheel in WHEELS],
                 [variant.number(solutions[driven][f"N_{wheel}"]) for wheel in WHEELS], 1000 * case.tolerance),
        ]  # fmt: skip
    trajectory = (
        cases[better].having(mu=friction[better]).motion(initial={"x'": -2 * best[better] * case.until})
    )
    plots: Plots = {
        "speed.png": saved(lambda: history(trajectory, ["x", "x'"], title="Monorail car at its limit")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks), cases[better].equations)


MONORAIL = Entry(
    "prob-6-3",
    ("monorail",),
    "Car hung from two wheels on a cable, one of them driven (Problem 6.3)",
    (
        "(1) which wheel should be driven",
        "(2) largest acceleration for each choice, wheel loads for the better one",
    ),
    build,
    solve,
    until=1.0,
    positive=("mu", "g"),
    start={"x'": -10.0},
    modes=modes("front"),
)
