"""Board that leans against the cab of an accelerating truck (chapter, Problem 6.1).

x is forward, to the right; the board's lower end is on the floor, its upper end against the smooth rear wall of
the cab, at the angle beta from the floor. theta is its rotation on the truck, counter-clockwise: backwards.
"""

from __future__ import annotations

from typing import Any

import sympy

import freebody as fb

from ....space.shape import Shape
from ...tools.answer import Answer, Answers, Plots, Solved, fact, same
from ...tools.case import Case, angle_where, explain
from ...tools.entry import Entry
from ...tools.looks import box_between, together, wheel

REST = {"theta": 0, "x": 0, "y": 0, "theta'": 0, "x'": 0, "y'": 0}
WAYS = {
    ("stick", "slip"): "stands",
    ("stick", "open"): "tips backwards: leaves the wall, its lower end holds",
    ("slip-", "slip"): "slides: its lower end slips backwards, its upper end stays at the wall",
    ("slip-", "open"): "slides and leaves the wall",
}


def look(length: Any, cab: Any, height: Any) -> Shape:
    """Return the truck as it is drawn: a bed whose top is the floor, a cab whose rear wall is at ``cab``, wheels."""
    low, r = length / 12, length / 9
    return together(
        wheel(r, (-length / 4, -low - r / 2, 0)),
        wheel(r, (cab + length / 6, -low - r / 2, 0)),
        box_between((-length / 2, -low, 0), (cab, 0, 0)),
        box_between((cab, -low, 0), (cab + length / 3, height + length / 12, 0)),
    )


def build() -> fb.System:
    """Return the system; x, y are displacements of the centre on the truck from the leaning position."""
    s = fb.System("board_on_truck")
    m, L, mu, beta = s.parameters(m=20.0, L=2.5, mu=0.3, beta="70deg")
    a, g = s.parameters(a=3.0, g=9.81)
    s.gravity = (0, -g, 0)
    c, n = sympy.cos(beta), sympy.sin(beta)
    truck = s.body("truck", fb.particle(1), shape=look(L, L * c, L * n))
    board = s.body("board", fb.slender_bar(m, L))
    s.slider("road", s.ground, truck, axis="x", coordinate=a * s.t**2 / 2)
    s.planar("plane", truck, board, at=(L / 2 * c, L / 2 * n, 0),
             child_axes=((c, n, 0), (-n, c, 0), (0, 0, 1)), coordinate="x y theta")  # fmt: skip
    s.contact("floor", board.point(-L / 2, 0, 0), truck.plane(), friction=mu)
    s.contact("wall", board.point(L / 2, 0, 0), truck.plane(at=(L * c, 0, 0), normal="-x"))
    explain(
        s,
        m="kg: mass of the board",
        L="m: length of the board",
        mu="1: friction between floor and lower end",
        beta="rad: angle between board and floor",
        a="m/s²: acceleration of the truck, item (4) and the run",
        g="m/s²: gravity",
        x="m: displacement of the centre on the truck, forward",
        y="m: displacement of the centre on the truck, up",
        theta="rad: turn of the board, backwards",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    case.refuse_unless("beta", 0 < case["beta"] < sympy.pi / 2, "an angle between 0 and 90 degrees")
    e, beta = case.equations, case.atoms["beta"]
    slide = e.solve("a", where=[REST, "T_floor = mu*N_floor"])["a"]
    tip = e.solve("a", where={**REST, "N_wall": 0})["a"]
    # one acceleration grows with the angle, the other falls
    angle = angle_where(sympy.expand((slide - tip) * sympy.sin(beta)), beta)
    largest = sympy.cancel(tip.subs(sympy.cos(beta), sympy.sin(beta) / sympy.tan(angle)))
    how = 'fb.equations(s, modes={"floor": "stick", "wall": "slip"}).solve("a", where='
    begun = case.simulate_to([0])
    modes = {name: str(begun.contacts[name].mode[0]) for name in ("floor", "wall")}
    shown = case.touching(**{name: mode for name, mode in modes.items() if mode != "open"})
    alpha = shown.equations.solve("theta''", where=REST)["theta''"]
    answers: Answers = {
        "a_slide": case.formula(
            "(1) acceleration at which the lower end is about to slip", slide, "m/s²", how + '"T_floor = mu*N_floor")'
        ),
        "a_tip": case.formula(
            "(2) acceleration at which the board is about to leave the wall", tip, "m/s²", how + '{"N_wall": 0})'
        ),
        "a_max": case.formula(
            "(3) largest acceleration for which some angle allows neither", largest, "m/s²", "a_slide = a_tip"
        ),
        "beta_max": case.formula("(3) that angle from the floor", angle, "rad", "a_slide = a_tip"),
        "state": Answer("(4) what the board does at the acceleration a",
                        WAYS[modes["floor"], modes["wall"]], "", None, "fb.simulate(s).modes"),
        "alpha": shown.formula("(4) its angular acceleration then, backwards +", alpha, "rad/s²",
                               f"fb.equations(s, modes={modes}).solve"),
    }  # fmt: skip
    checks = []
    thresholds = {"a_slide": answers["a_slide"].value, "a_tip": answers["a_tip"].value}
    first = min(thresholds, key=thresholds.__getitem__)
    for part, stands in ((1 - 1e-9, True), (1 + 1e-9, False)):
        if thresholds[first] > 0:
            near = case.having(a=thresholds[first] * part).simulate_to([0]).contacts
            outcome = WAYS[str(near["floor"].mode[0]), str(near["wall"].mode[0])]
            expected = "stands" if stands else {"a_slide": "slides", "a_tip": "tips"}[first]
            checks.append(fact(f"the board {expected} at {first} {'less' if stands else 'plus'} 1e-9 of it",
                               outcome.startswith(expected)))  # fmt: skip
    short = 1e-4
    soon = case.simulate_to([short])
    checks.append(
        same(
            "alpha against the simulation's first moments",
            soon["theta'"][-1] / short,
            answers["alpha"].value,
            1e-3,
        )
    )
    trajectory = case.motion()
    plots: Plots = {
        "board.png": saved(lambda: history(trajectory, ["x", "theta"], title="Board on a truck")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks), shown.equations)


BOARD_ON_TRUCK = Entry(
    "prob-6-1",
    ("board-on-truck",),
    "Board leaning against the cab of a truck (Problem 6.1)",
    (
        "(1) acceleration at which its lower end slips",
        "(2) acceleration at which it leaves the cab",
        "(3) largest acceleration for which some angle allows neither, and that angle",
        "(4) what it does at the acceleration a",
    ),
    build,
    solve,
    until=0.4,
    positive=("mu", "g"),
    drawn={"x": 0, "y": 0, "theta": 0},
    bodies=("board",),
    modes={"floor": "stick", "wall": "slip"},
)
