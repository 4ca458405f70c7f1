"""Disk on a rough floor, pulled by a force whose line is above its centre (chapter, Example 6.3).

x is to the right, phi is counter-clockwise; the friction force H on the disk is positive to the left.
"""

from __future__ import annotations

from typing import Any

import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Check, Plots, Solved, fact, same
from ...tools.case import Case, explain
from ...tools.entry import Entry


def build() -> fb.System:
    """Return the system; a force at C and a couple keep the line of the force at the height h as the disk turns."""
    s = fb.System("pulled_disk")
    m, R, h, mu = s.parameters(m=10.0, R=0.3, h=0.4, mu=0.2)
    F, _, g = s.parameters(F=30.0, F_2=250.0, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, at=(0, R, 0), coordinate="x y phi")
    s.contact("floor", disk.circle(R), s.ground.plane(), friction=mu)
    s.force("F", disk.origin, (F, 0, 0))
    s.torque("F_moved", disk, (0, 0, -F * (h - R)))
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the disk",
        h="m: height of the line of the force above the floor",
        mu="1: friction between disk and floor, static and kinetic",
        F="N: force to the right, item (1)",
        F_2="N: force to the right, item (2)",
        g="m/s²: gravity",
        x="m: displacement of the centre to the right",
        y="m: height of the centre above R",
        phi="rad: turn of the disk, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    rolling = case.touching(floor="stick")
    sticking = rolling.equations.solve(["x''", "phi''", "T_floor", "N_floor"])
    # T without slip is proportional to F; it opposes the slip that would otherwise occur
    share = rolling.number(sticking["T_floor"], {"F": 1})
    limit: Any = None
    if abs(share) > 1e-14:  # smaller values are round-off of a line through the centre of percussion
        end = "-" if share < 0 else ""
        limit = rolling.equations.solve("F", where=f"T_floor = {end}mu*N_floor")["F"]
    largest = sympy.oo if limit is None else rolling.number(limit)
    answers: Answers = {}
    checks: list[Check] = []
    shown = rolling
    motions = []
    for item, name, tail in ((1, "F", ""), (2, "F_2", "_2")):
        F = case[name]
        rolls = abs(F) <= largest
        now = rolling
        if not rolls:
            now = case.touching(floor="slip+" if share * F < 0 else "slip-")
        solution = sticking if rolls else now.equations.solve(["x''", "phi''", "T_floor", "N_floor"])
        mode = f'fb.equations(s, modes={{"floor": "{"stick" if rolls else "slip"}"}}).solve'
        at = {"F": name}
        answers[f"state{tail}"] = Answer(
            f"({item}) does the disk roll or slip under {name}?",
            "rolls without slip" if rolls else "slips", "", None, f"|{name}| against F_max",
        )  # fmt: skip
        forces = {"a": ("x''", 1, "acceleration of the centre, to the right +", "m/s²"),
                  "alpha": ("phi''", 1, "angular acceleration, counter-clockwise +", "rad/s²"),
                  "H": ("T_floor", -1, "friction force on the disk, to the left +", "N")}  # fmt: skip
        for key, (unknown, sign, words, unit) in forces.items():
            answers[key + tail] = now.formula(
                f"({item}) {words}", now.put(sign * solution[unknown], at), unit, mode
            )
        motion = case.having(F=F).motion()
        end_of_run, t = motion.at(case.until), case.until
        checks.append(
            same(f"a{tail}, alpha{tail} against the simulation",
                 [answers[f"a{tail}"].value * t, answers[f"alpha{tail}"].value * t],
                 [end_of_run["x'"], end_of_run["phi'"]], 1000 * case.tolerance)
        )  # fmt: skip
        checks.append(
            fact(f"{'rolls' if rolls else 'slips'} all the time in the simulation under {name}",
                 all((change.mode == "stick") == rolls for change in motion.modes))
        )  # fmt: skip
        motions.append(motion)
        if item == 1:
            shown = now
    how = 'fb.equations(s, modes={"floor": "stick"}).solve("F", where="T_floor = -mu*N_floor")'
    words = "(3) largest force without slip"
    answers["F_max"] = (
        rolling.formula(words, limit, "N", how)
        if limit is not None
        else Answer(words, "none: no force makes it slip", "", None, how)
    )
    if limit is not None and largest > 0:
        for part, mode in ((1 - 1e-9, "stick"), (1 + 1e-9, "slip+" if share < 0 else "slip-")):
            near = case.having(F=largest * part).simulate_to([0])
            checks.append(
                fact(f"{'sticks' if part < 1 else 'slips'} at F_max {'less' if part < 1 else 'plus'} 1e-9 of it",
                     near.contacts["floor"].mode[0] == mode)
            )  # fmt: skip
    first, second = motions
    plots: Plots = {
        "speed.png": saved(lambda: history(first, ["x'", "phi'"], title="Pulled disk, item (1)")),
        "speed_2.png": saved(lambda: history(second, ["x'", "phi'"], title="Pulled disk, item (2)")),
        "margin.png": saved(lambda: first.plot_margin()),
        "energy.png": saved(lambda: energy_residual(first)),
    }
    return Solved(first, answers, plots, tuple(checks), shown.equations)


PULLED_DISK = Entry(
    "ex-6-3",
    ("pulled-disk",),
    "Disk pulled along a rough floor: rolls or slips (Example 6.3)",
    (
        "(1), (2) under F and F_2: does it roll or slip; acceleration, angular acceleration, friction",
        "(3) largest force without slip",
    ),
    build,
    solve,
    until=1.0,
    positive=("g",),
    modes={"floor": "stick"},
)
