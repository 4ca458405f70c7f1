"""Ball that bounces on a smooth floor until it rests: infinitely many bounces in a finite time.

From the height h (of its lowest point) the ball falls for t_1 = sqrt(2 h/g). Each bounce multiplies its speed by e,
so the flights last 2 t_1 e, 2 t_1 e^2, ... The sum of this series converges, and all bounces end at its limit.
"""

from __future__ import annotations

import numpy as np
import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain, happened
from ..tools.entry import Entry

START = {"y": "h", "x'": "v"}


def build() -> fb.System:
    """Return the system; y is the height of the lowest point, x the distance along the floor."""
    s = fb.System("bouncing_ball")
    m, R, e, g = s.parameters(m=0.2, R=0.05, e=0.8, g=9.81)
    h, _ = s.parameters(h=1.0, v=0.5)
    s.assume(g > 0, h > 0)
    s.gravity = (0, -g, 0)
    ball = s.body("ball", fb.sphere(m, R))
    s.planar("plane", s.ground, ball, at=(0, R, 0), coordinate="x y phi")
    s.contact("floor", ball.circle(R), s.ground.plane(), restitution=e)
    explain(
        s,
        m="kg: mass of the ball",
        R="m: radius of the ball",
        e="1: coefficient of restitution",
        g="m/s²: gravity",
        h="m: height from which it falls",
        v="m/s: velocity along the floor",
        x="m: way along the floor",
        y="m: height of the lowest point above the floor",
        phi="rad: turn of the ball, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy, history, saved

    case.refuse_unless("e", 0 < case["e"] < 1, "a coefficient of restitution between 0 and 1")
    case.refuse_unless("h", case["h"] > 0, "a height greater than 0")
    case.refuse_unless("g", case["g"] > 0, "gravity")
    fall = case.equations.solve("y''")["y''"]
    h, e, v, R = (case.atoms[name] for name in ("h", "e", "v", "R"))
    top = {"x": 0, "y": "h", "x'": 0, "y'": 0, "phi": 0, "phi'": 0}
    square = case.square_of_speed("y'", top, {**top, "y": 0})
    first = sympy.sqrt(square) / -fall
    flight = "equation of motion and energy integral of the flight"
    series = flight + ", speed times e at each bounce: geometric series"
    # flights of 2 t_1 e, 2 t_1 e^2, ...; heights h e^2, h e^4, ...
    over = sympy.factor(first * (1 + 2 * e / (1 - e)))
    motion = case.simulate_past("rest", 1, initial=START, tolerance=case.tolerance / 100)
    rest, impacts = happened(motion, "rest")[0], happened(motion, "impact")
    energy_left = motion.energy.kinetic[-1]
    answers: Answers = {
        "t_1": case.formula("time of the first bounce", first, "s", flight),
        "v_1": case.formula("speed at which it arrives there", sympy.sqrt(square), "m/s", flight),
        "T": case.formula("time after which all bounces are over", over, "s", series),
        "way": case.formula("way up and down until then", h + 2 * h * e**2 / (1 - e**2), "m", series),
        "x_T": case.formula("way along the floor until then", v * over, "m", series),
        "R_over": case.formula("height of the centre when it rests", R, "m", "geometry of the contact"),
        "E_rest": Answer("energy that is left then, of the motion along the floor", float(energy_left), "J",
                         how="fb.simulate, energy ledger"),
    }  # fmt: skip
    k = np.arange(len(impacts))
    t_1, ratio = answers["t_1"].value, case["e"]
    expected = t_1 * (1 + 2 * ratio * (1 - ratio**k) / (1 - ratio))
    arrivals = np.array([event.state["y'"] for event in impacts])
    departures = np.array([event.after["y'"] for event in impacts])
    checks = (
        same("time of every bounce against the series", [event.time for event in impacts], expected, 1e-11),
        same("time of the rest against the simulation", answers["T"].value, rest.time, 1e-11),
        same("speed after each bounce over that before", departures / arrivals, np.full(len(k), -ratio), 1e-14),
        same("way along the floor against the simulation", answers["x_T"].value, float(rest.state["x"]), 1e-11),
        same("energy ledger with what the bounces take", motion.energy.relative_residual, 0, 1e-12),
    )  # fmt: skip
    trajectory = case.motion(initial=START)
    plots: Plots = {
        "height.png": saved(lambda: history(trajectory, "y", title="Bouncing ball", events=False)),
        "energy.png": saved(lambda: energy(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


BOUNCING_BALL = Entry(
    "bouncing-ball",
    (),
    "Ball bouncing on a floor until it rests, in a finite time",
    ("first bounce", "when all bounces are over, and the ways until then", "what energy is left"),
    build,
    solve,
    until=5.0,
    start=START,
)
