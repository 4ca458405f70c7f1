"""A car on its tyres: the single-track model, steered by δ at the speed V.

A tyre that rolls at a slip angle σ pushes the axle sideways with C σ times its load. For small angles, with v the side
speed of the mass centre, r the yaw rate, and K the stiffness C times the load of an axle,

    K_F (δ - (v + a r)/V) + K_R (b r - v)/V = m V r,      a K_F (δ - (v + a r)/V) = b K_R (b r - v)/V

The car understeers if b K_R > a K_F, here C_R > C_F: it then turns less the faster it goes. If it oversteers, it
leaves its course at the speed where r/δ is infinite.

Source: Pacejka, Tyre and Vehicle Dynamics (2006), equations (1.37) to (1.41).
"""

from __future__ import annotations

from typing import Any

import sympy

import freebody as fb

from ....space.shape import Shape
from ...tools.answer import Answer, Answers, Plots, Solved
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import placed, together

STRAIGHT = {"x": 0, "y": 0, "psi": 0, "x'": "V", "y'": 0, "psi'": 0}


def look(b: Any) -> Shape:
    """Return the car without its front wheel: the rear wheel in the plane of symmetry, seen through the thin body."""
    wheel = placed(fb.cylinder(1, 0.3, 0.2, axis="y"), (-b, 0, 0))
    return together(placed(fb.box(1, (4, 1.6, 0.3))), wheel)


def build() -> fb.System:
    """Return the car in the plane of the road; the steered axle and the rear one are in its plane of symmetry."""
    s = fb.System("turning_car")
    m, J, a, b, C_F, C_R = s.parameters(m=1200.0, J=1800.0, a=1.2, b=1.5, C_F=12.0, C_R=14.0)
    delta, V, g, _ = s.parameters(delta="1deg", V=25.0, g=9.81, t_1=4.0)
    s.assume(V > 0)
    mass = fb.MassProperties(m, (0, 0, 0), ((J, 0, 0), (0, J, 0), (0, 0, J)))
    car = s.body("car", mass, shape=look(b))
    front = s.body("front", fb.particle(0), shape=placed(fb.cylinder(1, 0.3, 0.2, axis="y")))
    s.planar("road", s.ground, car, coordinate="x y psi")
    s.hinge("steering", car, front, at=(a, 0, 0), axis="z", coordinate=delta)
    s.tyre("Y_F", front, axis="y", lateral=C_F, load=m * g * b / (a + b), normal="z")
    s.tyre("Y_R", car.point(-b, 0, 0), axis="y", lateral=C_R, load=m * g * a / (a + b), normal="z")
    explain(
        s,
        m="kg: mass of the car",
        J="kg m²: moment of inertia about the vertical",
        a="m: from the front axle to the mass centre",
        b="m: from the mass centre to the rear axle",
        C_F="1/rad: cornering stiffness of the front axle over its load",
        C_R="1/rad: cornering stiffness of the rear axle over its load",
        delta="rad: steering angle",
        V="m/s: speed",
        g="m/s²: gravity",
        t_1="s: time to answer for",
        x="m: place of the mass centre",
        y="m: place of the mass centre, to the left",
        psi="rad: heading, to the left",
    )
    return s


def turn(linear: Any, V: Any) -> tuple[Any, Any]:
    """Return r/δ and v/δ of the steady turn: y' = v + V psi and psi' = r in the linear equations."""
    v, r = sympy.symbols("v r")
    across, about = (
        linear.M[i, 1] * V * r + linear.C[i, 1] * v + linear.C[i, 2] * r - linear.B[i, 0] for i in (1, 2)
    )
    found = sympy.solve([across, about], [v, r])
    return found[r], found[v]


def solve(case: Case) -> Solved:
    """Solve the linear equations for the steady turn, and simulate the car that is steered at once."""
    from ....picture.plots.plots import energy_residual, history, saved

    linear = fb.linearize(case.system, about=STRAIGHT, where={"delta": 0}, inputs=["delta"])
    V, delta = case.atoms["V"], case.atoms["delta"]
    rate, side = (x * delta for x in turn(linear, V))
    start = {"x'": "V"}
    at = case.simulate_to([case["t_1"]], initial=start)
    how = "fb.linearize(s, about=..., inputs=['delta'])"
    answers: Answers = {
        "r": case.formula("yaw rate of the steady turn, small slip", rate, "rad/s", how),
        "v": case.formula("side speed of the mass centre", side, "m/s", how),
        "psi'(t_1)": Answer("yaw rate at t_1", float(at["psi'"][0]), "rad/s", how="fb.simulate"),
        "psi(t_1)": Answer("heading at t_1", float(at["psi"][0]), "rad", how="fb.simulate"),
    }
    trajectory = case.motion(initial=start)
    plots: Plots = {
        "motion.png": saved(
            lambda: history(trajectory, ["psi", "psi'"], title="Turning car: heading and yaw rate")
        ),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


TURNING_CAR = Entry(
    "turning-car",
    ("single-track-car",),
    "A car turns on its tyres",
    ("yaw rate and side speed of the steady turn", "yaw rate and heading at t_1"),
    build,
    solve,
    until=6.0,
    start={"x'": "V"},
    drawn={"x": 0, "y": 0, "psi": 0, "x'": 25, "y'": 0, "psi'": 0.1},
)
