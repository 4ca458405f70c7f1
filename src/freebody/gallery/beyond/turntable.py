"""Ball that rolls on a turning table: it moves on a circle at 2/7 of the rate of the table.

x, y, z are those of the ball's centre in ground axes, the table turns about z at the rate Omega, counter-clockwise. The
equations are looked at with the axes of the ball parallel to those of the ground: a ball is the same all round.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ..tools.answer import Answers, Plots, Solved, fact, same
from ..tools.case import Case, explain
from ..tools.entry import Entry

ALIGNED = {"turn_e0": 1, "turn_e1": 0, "turn_e2": 0, "turn_e3": 0, "z": 0, "z'": 0, "z''": 0}


def build() -> fb.System:
    """Return the system: three massless sliders carry the centre, a ball joint carries the ball."""
    s = fb.System("turntable")
    m, R, Omega, mu, g = s.parameters(m=0.5, R=0.05, Omega=3.0, mu=0.3, g=9.81)
    s.parameters(x_0=0.3, v_0=0.2)
    s.gravity = (0, 0, -g)
    nothing = fb.MassProperties(0, (0, 0, 0), ((0, 0, 0), (0, 0, 0), (0, 0, 0)))
    table, ball = s.body("table", fb.particle(1), shape=fb.disk(1, 0.5)), s.body("ball", fb.sphere(m, R))
    along, across, above = (s.body(name, nothing, shape="nothing") for name in ("along", "across", "above"))
    s.hinge("axle", s.ground, table, axis="z", coordinate=Omega * s.t)
    s.slider("way_x", s.ground, along, axis="x", coordinate="x")
    s.slider("way_y", along, across, axis="y", coordinate="y")
    s.slider("way_z", across, above, at=(0, 0, R), axis="z", coordinate="z")
    s.ball("turn", above, ball)
    s.contact("top", ball.sphere(R), table.plane(normal="z"), friction=mu)
    explain(
        s,
        m="kg: mass of the ball",
        R="m: radius of the ball",
        Omega="rad/s: turn of the table",
        mu="1: friction between ball and table",
        g="m/s²: gravity",
        x_0="m: distance from the axle at which the ball is put down",
        v_0="m/s: velocity of its centre there, along y",
        x="m: place of the centre along x",
        y="m: place of the centre along y",
        z="m: height of the centre above R",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, saved

    case.refuse_unless("Omega", case["Omega"] != 0, "a table that turns")
    e, atoms = case.equations, case.atoms
    unknowns = ["x''", "y''", "turn_wx'", "turn_wy'", "turn_wz'", "N_top", "T1_top", "T2_top"]
    solution = e.solve(unknowns, where=ALIGNED)
    # rolling determines the spin from the velocity of the centre
    turned = atoms["Omega"] * case.system.t
    now = {sympy.cos(turned): 1, sympy.sin(turned): 0}  # at t = 0; the table is symmetric about its axis
    rolls = [case.put(c.lhs - c.rhs, ALIGNED).xreplace(now) for c in e.constraints[1:]]
    spins = [atoms["turn_wx"], atoms["turn_wy"]]
    (spin,) = sympy.linsolve(rolls, spins)
    put = dict(zip(spins, spin, strict=True))
    ax, ay = (sympy.expand(solution[name].xreplace(put)) for name in ("x''", "y''"))
    vx, vy = atoms["x'"], atoms["y'"]
    rate = -ax.coeff(vy, 1)
    how = 'fb.equations(s, modes={"top": "stick"}).solve, with the condition of rolling'
    begin = {"x": "x_0", "y": 0, "x'": 0, "y'": "v_0"}
    v_0, x_0 = atoms["v_0"], atoms["x_0"]
    needed = sympy.Abs(rate * v_0) / atoms["g"]
    lines = {
        name: case.formula(f"equation of motion along {name}", a, "", how, at=begin)
        for name, a in (("x", ax), ("y", ay))
    }
    answers: Answers = {
        "equation_x": replace(lines["x"], value=f"x'' = {lines['x'].text}"),
        "equation_y": replace(lines["y"], value=f"y'' = {lines['y'].text}"),
        "rate": case.formula("rate at which the centre runs round its circle", rate, "rad/s", how),
        "period": case.formula("period", 2 * sympy.pi / rate, "s", how),
        "radius": case.formula("radius of the circle", sympy.Abs(v_0 / rate), "m", how),
        "x_c": case.formula("place of its centre along x", x_0 - v_0 / rate, "m", how),
        "w_x": case.formula(
            "spin about x with which it is put down, rolling", case.put(spin[0], begin), "rad/s", "condition of rolling"
        ),
        "N": case.formula("normal force", solution["N_top"], "N", how),
        "mu_needed": case.formula("friction that the circle takes", needed, "1", how),
        "v_max": case.formula(
            "largest velocity at which it rolls", atoms["mu"] * atoms["g"] / sympy.Abs(rate), "m/s", how
        ),
    }  # fmt: skip
    case.refuse_unless("v_0", case["v_0"] != 0, "a ball that moves on the ground")
    case.refuse_unless(
        "v_0", answers["mu_needed"].value < case["mu"],
        f"a velocity at which the ball rolls, up to {answers['v_max'].value:g} m/s",
    )  # fmt: skip
    start = {"x": "x_0", "y'": "v_0", "turn_wx": answers["w_x"].value}
    period = abs(answers["period"].value)
    at = case.simulate_to(np.linspace(0, period, 13), initial=start)
    bound = 1000 * case.tolerance
    distance = np.hypot(at["x"] - answers["x_c"].value, at["y"])
    angle = np.unwrap(np.arctan2(at["y"], at["x"] - answers["x_c"].value))
    friction = np.linalg.norm(at.contacts["top"].tangential, axis=1)
    checks = (
        same("simulation: back at the start after a period", [at["x"][-1], at["y"][-1]], [case["x_0"], 0], bound),
        same("simulation: distance from the circle's centre", distance, np.full(13, answers["radius"].value), bound),
        same("simulation: steady round the circle", angle - angle[0], answers["rate"].value * at.t, bound),
        same("friction against the simulation", friction / (case["m"] * case["g"]),
             np.full(13, answers["mu_needed"].value), bound),
        same("the carriers without mass do not pull: force at the joint over the weight",
             np.abs(at.reactions["turn"].force).max() / (case["m"] * case["g"]), 0, bound),
        fact("the path does not depend on the axes of the ball: x'' has no x, x'",
             sympy.expand(ax + rate * vy) == 0 and sympy.expand(ay - rate * vx) == 0),
        same("the rate is 2/7 of the table's", answers["rate"].value, case["Omega"] * 2 / 7, 1e-14),
    )  # fmt: skip
    trajectory = case.motion(initial=start)
    plots: Plots = {
        "path.png": saved(lambda: path(trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def path(trajectory: fb.Trajectory) -> Any:
    """Draw the path of the centre from above."""
    from ...picture.plots.plots import figure, phase

    ax = phase(
        trajectory, "x", "y", ax=figure(7, 6).subplots(), title="Ball on a turntable: way of its centre"
    )
    ax.set_aspect("equal")
    return ax


TURNTABLE = Entry(
    "turntable",
    ("ball-on-turntable",),
    "Ball rolling on a turning table: a circle at 2/7 of its rate",
    (
        "equations of motion",
        "rate, period, radius and centre of the circle",
        "forces, and the friction that it takes",
    ),
    build,
    solve,
    until=10.0,
    positive=("g", "mu"),
    start={"x": "x_0", "y'": "v_0"},
    drawn={"x": 0.16, "y": 0.38},
    bodies=("ball",),
    modes={"top": "stick"},
    fixed_values={**ALIGNED, "turn_x": 0, "turn_y": 0, "turn_z": 0},
)
