"""Bar that falls over on a rough floor and slips (chapter, Problem 6.11).

theta is the angle from the vertical, counter-clockwise, so that the bar falls to the left. At first friction holds
its lower end by a force to the left; the end slips to the right, backwards, when that force reaches mu N.
"""

from __future__ import annotations

import math
from typing import Any

import sympy
from scipy.optimize import brentq

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved, fact, same
from ...tools.case import Case, explain
from ...tools.entry import Entry

CENTRED = {"x": 0, "y": 0, "x'": 0, "y'": 0}
UPRIGHT = {**CENTRED, "theta": 0, "theta'": 0}
BEGIN = 0.02
"""Initial angle of the run [rad], with the speed of a fall from rest at the vertical."""
WAYS = {"slip +": "backwards, away from the side to which it falls", "slip -": "forwards, the other way"}


def build() -> fb.System:
    """Return the system; x, y belong to the lower end."""
    s = fb.System("falling_bar")
    m, L, _, mu, g = s.parameters(m=2.0, L=1.5, angle="60deg", mu_floor=0.3, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.planar("plane", s.ground, bar, to=(0, -L / 2, 0), coordinate="x y theta")
    s.contact("floor", bar.point(0, -L / 2, 0), s.ground.plane(), friction=mu)
    s.contact("end", bar.point(0, L / 2, 0), s.ground.plane(), friction=mu)
    explain(
        s,
        m="kg: mass of the bar",
        L="m: length of the bar",
        angle="rad: angle from the floor at which it is seen to slip",
        mu_floor="1: friction coefficient of another floor, for the last answers",
        g="m/s²: gravity",
        x="m: displacement of the lower end to the right",
        y="m: its height",
        theta="rad: angle from the vertical",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.contact_plots import contact_forces
    from ....picture.plots.plots import energy_residual, history, saved

    e, rate = case.equations, case.atoms["theta'"]
    square = case.square_of_speed("theta'", UPRIGHT, CENTRED)
    solution = e.solve(["theta''", "N_floor", "T_floor"], where=CENTRED)
    # to the left, the side of the fall
    N = sympy.cancel(solution["N_floor"].subs(rate**2, square))
    H = sympy.cancel(-solution["T_floor"].subs(rate**2, square))
    steepest, largest = most(case, H / N)
    slips = ranges(case, H / N, N, steepest, largest)
    backwards, forwards = ([math.pi / 2 - x for x in slips[way]] for way in ("slip +", "slip -"))
    case.refuse_unless(
        "angle", backwards[1] < case["angle"] < backwards[0] or forwards[1] < case["angle"] < forwards[0],
        f"an angle from the floor between {backwards[1]:.6g} and {backwards[0]:.6g} rad, where it slips backwards, "
        f"or between {forwards[1]:.6g} and {forwards[0]:.6g} rad, where it slips forwards "
        "(friction that holds as far as between the two holds still longer)",
    )  # fmt: skip
    way = "slip +" if case["angle"] > backwards[1] else "slip -"
    at = {**CENTRED, "theta": "pi/2 - angle"}
    share = H / N if way == "slip +" else -H / N
    how = 'fb.equations(s, modes={"floor": "stick"}).solve, with the energy integral'
    answers: Answers = {
        "mu": case.formula("coefficient of friction", sympy.cancel(case.put(share, at)), "1", how),
        "H": case.formula(
            "friction force at that instant, towards the side to which it falls +", case.put(H, at), "N", how
        ),
        "N": case.formula("normal force then", case.put(N, at), "N", how),
        "omega": case.formula(
            "angular speed then", sympy.sqrt(case.put(square, at)), "rad/s", "energy integral"
        ),
        "mu_limit": case.formula(
            "largest coefficient for which it slips this way at all", largest, "1", how + ", largest H/N"
        ),
        "theta_limit": case.formula("angle from the vertical at which it then slips", steepest, "rad", how),
    }
    begin = {"theta": BEGIN, "theta'": math.sqrt(case.number(square, {"theta": BEGIN}))}
    needed = case.number(H / N, {"theta": BEGIN})
    if not case["mu_floor"] > needed:
        raise fb.errors.ModelError(
            f"Expected a friction coefficient with which the bar stands on its end at first, greater than "
            f"{needed:.3g}, got mu_floor = {case['mu_floor']:g}."
        )
    where = "fb.simulate, event located"
    _, other = case.simulate_to_mode("floor", "slip", initial=begin)
    words = next(words for mode, words in WAYS.items() if f"→ {mode}" in str(other))
    answers["theta_floor"] = Answer(
        "angle from the vertical at which it slips on the floor of mu_floor",
        float(other.state["theta"]),
        "rad",
        how=where,
    )
    answers["way"] = Answer("which way its lower end then slips", words, "", how=where)
    observed = case.having(mu_floor=answers["mu"].value)
    motion, event = observed.simulate_to_mode("floor", "slip", initial=begin)
    bound = 1000 * case.tolerance
    now = {**CENTRED, "theta": other.state["theta"], "theta'": other.state["theta'"]}
    pull, push = (case.number(solution[name], now) for name in ("T_floor", "N_floor"))
    checks = [
        same("angle of the slip in the simulation with mu", math.pi / 2 - event.state["theta"], case["angle"],
             bound / slope(case, H / N)),
        same("omega against the simulation", answers["omega"].value, event.state["theta'"],
             bound / slope(case, H / N)),
        fact(f"it slips {WAYS[way].split(',')[0]} in the simulation with mu too", f"→ {way}" in str(event)),
        same("|T| = mu_floor N of the equations where the simulation slips",
             abs(pull) / (case["m"] * case["g"]), case["mu_floor"] * push / (case["m"] * case["g"]), bound),
        fact("it slips backwards in the simulation with more than mu_limit", "→ slip -" in str(
             case.having(mu_floor=answers["mu_limit"].value * (1 + 1e-6)).simulate_to_mode(
                 "floor", "slip", initial=begin)[1])),
    ]  # fmt: skip
    trajectory = observed.motion(initial=begin)
    plots: Plots = {
        "angle.png": saved(lambda: history(trajectory, ["theta", "x"], title="Falling bar")),
        "forces.png": saved(lambda: contact_forces(trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks))


def most(case: Case, share: Any) -> tuple[Any, Any]:
    """Return (angle, value) of the largest ratio H/N between the vertical and the angle at which H is zero.

    As a function of c = cos(theta), it is sqrt(1 - c^2) times a rational function: its square is rational.
    """
    theta = case.atoms["theta"]
    c, n = sympy.symbols("c n", real=True)
    square = sympy.cancel(
        sympy.expand((share**2).subs({sympy.sin(theta): n, sympy.cos(theta): c}).subs(n**2, 1 - c**2))
    )
    if square.has(n):
        numerator, denominator = (
            sympy.rem(part, n**2 + c**2 - 1, n) for part in sympy.fraction(sympy.together(square))
        )
        square = sympy.cancel(numerator / denominator)
    turning = sympy.real_roots(sympy.numer(sympy.cancel(sympy.diff(square, c))), c)
    inside = [
        root for root in turning if 0 < root < 1 and case.number(share, {"theta": sympy.acos(root)}) > 0
    ]
    best = max(inside, key=lambda root: square.subs(c, root))
    return sympy.acos(best), sympy.sqrt(square.subs(c, best))


def ranges(case: Case, share: Any, N: Any, steepest: Any, largest: Any) -> dict[str, tuple[float, float]]:
    """Return the range of angles from the vertical at which the bar can begin to slip, for each direction.

    Backwards the ratio H/N grows up to ``steepest``. Friction that holds there holds until H is reversed and -H/N is
    as large. The normal force vanishes where its square root, which is rational in cos(theta), is zero.
    """
    limit, most_ = case.number(steepest), case.number(largest)
    lifted = brentq(
        lambda x: case.number(sympy.diff(N, case.atoms["theta"]), {"theta": x}), limit, math.pi / 2
    )
    first = brentq(lambda x: case.number(share, {"theta": x}) + most_, limit, lifted * (1 - 1e-6))
    return {"slip +": (0.0, limit), "slip -": (first, lifted)}


def slope(case: Case, share: Any) -> float:
    """Return the slope of H/N over the angle at the slip, at most 1: a small slope amplifies errors of the angle."""
    theta = case.atoms["theta"]
    return min(1.0, abs(case.number(sympy.diff(share, theta), {"theta": "pi/2 - angle"})))


FALLING_BAR = Entry(
    "prob-6-11",
    ("falling-bar",),
    "Bar falling over on a rough floor, seen to slip (Problem 6.11)",
    (
        "coefficient of friction; friction, normal force and angular speed at that instant",
        "largest coefficient for which it slips this way at all, and where",
        "angle and way of the slip on another floor",
    ),
    build,
    solve,
    until=2.0,
    positive=("g",),
    start={"theta": BEGIN},
    drawn={"theta": "-25deg"},
    modes={"floor": "stick"},
    fixed_values={**CENTRED, "x''": 0, "y''": 0},
)
