"""Car that slides on four locked wheels (chapter, Problem 6.2).

x is to the right, the direction of travel; "front" and "rear" are the contacts of the axles, two wheels each.
"""

from __future__ import annotations

from typing import Any

import freebody as fb

from ....space.shape import Shape
from ...tools.answer import Answers, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import box_between, together, wheel

LEVEL = {"theta": 0, "theta'": 0}


def look(l_f: Any, l_r: Any, h: Any) -> Shape:
    """Return the car as it is drawn, on its wheels."""
    r = 3 * h / 5
    return together(
        box_between((-l_r / 2, h / 4, 0), (l_f / 4, h, 0)),
        box_between((-l_r - h / 2, -h / 2, 0), (l_f + h, h / 4, 0)),
        wheel(r, (l_f, r - h, 0)),
        wheel(r, (-l_r, r - h, 0)),
    )


def build() -> fb.System:
    """Return the system; x, y are displacements of the mass centre from its position at rest on the road."""
    s = fb.System("braking_car")
    m, l_f, l_r, h = s.parameters(m=1500.0, l_f=1.2, l_r=1.6, h=0.5)
    _, mu, _, g = s.parameters(a=6.0, mu_road=0.4, v=20.0, g=9.81)
    s.gravity = (0, -g, 0)
    car = s.body("car", fb.box(m, (l_f + l_r, 2 * h, 2 * h)), shape=look(l_f, l_r, h))
    s.planar("plane", s.ground, car, at=(0, h, 0), coordinate="x y theta")
    s.contact("front", car.point(l_f, -h, 0), s.ground.plane(), friction=mu)
    s.contact("rear", car.point(-l_r, -h, 0), s.ground.plane(), friction=mu)
    explain(
        s,
        m="kg: mass of the car",
        l_f="m: distance of the mass centre behind the front axle",
        l_r="m: distance of the mass centre ahead of the rear axle",
        h="m: height of the mass centre above the road",
        a="m/s²: deceleration",
        mu_road="1: friction coefficient of another road, for the last two answers",
        v="m/s: speed at which the wheels lock",
        g="m/s²: gravity",
        x="m: displacement of the mass centre",
        y="m: height of the mass centre above that at rest",
        theta="rad: pitch, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    case.refuse_unless("v", case["v"] > 0, "a speed greater than 0")
    case.refuse_unless("a", case["a"] > 0, "a deceleration greater than 0")
    e = case.equations
    solution = e.solve(["mu_road", "N_front", "N_rear"], where={**LEVEL, "x''": "-a"})
    mu = solution["mu_road"]
    road = e.solve("x''", where=LEVEL)["x''"]
    how = 'fb.equations(s, modes={"front": "slip+", "rear": "slip+"}).solve(..., where={"x\'\'": "-a"})'
    axles = {name: solution[f"N_{name}"] for name in ("front", "rear")}
    answers: Answers = {"mu": case.formula("friction coefficient", mu, "1", how)}
    for name, N in axles.items():
        answers[f"N_{name}"] = case.formula(f"normal force on the {name} axle", N, "N", how)
    for name, N in axles.items():
        answers[f"N_{name}_wheel"] = case.formula(f"normal force on each {name} wheel", N / 2, "N", how)
    for name, N in axles.items():
        answers[f"T_{name}"] = case.formula(f"friction force on the {name} axle, backwards", mu * N, "N", how)
    v = case.atoms["v"]
    answers["a_road"] = case.formula(
        "deceleration on the road of mu_road", -road, "m/s²", "fb.equations(s, modes=...).solve(\"x''\")"
    )
    answers["stop_road"] = case.formula(
        "distance to the stop from v there", v**2 / (-2 * road), "m", "constant deceleration"
    )
    for name, N in axles.items():
        if case.number(N) < 0:
            raise fb.errors.ModelError(
                f"Expected a deceleration at which all wheels stay on the road, got a = {case['a']:g} m/s², "
                f"where the {name} axle lifts off."
            )
    braking = case.having(mu_road=answers["mu"].value)
    trajectory = braking.motion(initial=START)
    t = 0.5 * min(case.until, case["v"] / case["a"])
    contacts = braking.simulate_to([t], initial=START).contacts
    bound = 1000 * case.tolerance
    halt = [fb.event("x'", name="stop", terminal=True)]
    stop = braking.simulate_past("stop", 1, initial=START, events=halt)
    other = case.simulate_past("stop", 1, initial=START, events=halt) if case["mu_road"] > 0 else None
    checks = [
        same("N_front, N_rear against the simulation", [answers["N_front"].value, answers["N_rear"].value],
             [contacts[name].least[-1, 0] for name in axles], bound),
        same("friction against the simulation", [answers["T_front"].value, answers["T_rear"].value],
             [-contacts[name].least[-1, 1] for name in axles], bound),
        same("time of the stop, v/a, against the simulation", case["v"] / case["a"], stop.t[-1], bound),
    ]  # fmt: skip
    if other is not None:
        checks.append(
            same("stop_road against the simulation", answers["stop_road"].value, other["x"][-1], bound)
        )
    plots: Plots = {
        "speed.png": saved(lambda: history(trajectory, ["x", "x'"], title="Braking car")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks))


START = {"x'": "v"}

BRAKING_CAR = Entry(
    "prob-6-2",
    ("braking-car",),
    "Car braking with locked wheels (Problem 6.2)",
    (
        "friction coefficient",
        "normal forces, per axle and wheel",
        "friction per axle",
        "the stop on another road",
    ),
    build,
    solve,
    until=3.0,
    positive=("mu_road", "g"),
    start=START,
    modes={"front": "slip+", "rear": "slip+"},
)
