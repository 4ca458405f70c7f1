"""Motorcycle in a steady curve to the left: torque on its wheels, and lean (chapter, Problem 6.18).

The motorcycle moves along y at the distance R from the vertical axis of the curve; x points away from the axis,
and theta is the lean towards it. The wheels roll forwards at -v/r about the axle x. The angular momentum of wheels
that only turn about x does not depend on their place, so both are one rotor at the mass centre C, with the whole
mass. The ground force acts at the distance h from C in the plane of the motorcycle: the weight up, and the
centripetal force inwards; a check shows that no other force is needed to carry C round.

Only the spin of the wheels is included, as the problem requires; the rest is smaller by r/R, which is also checked.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ....space.shape import Shape
from ...tools.answer import Answer, Answers, Check, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import placed, rim, together, tube_between
from ...tools.pictures import moments

CURVE = {"psi": 0, "psi'": "v/R", "p'": "-v/r", "theta'": 0, "theta''": 0, "psi''": 0, "p''": 0}


def look(r: Any, h: Any) -> Shape:
    """Return the machine as it is drawn, with wheels and rider; it runs along y, and its centre is the origin."""
    rear, front = (0, -2 * h / 3 - r / 3, r - h), (0, 2 * h / 3 + r, r - h)
    head, seat = (0, 2 * h / 3, h / 3), (0, -2 * h / 3, h / 6)
    low, hips, neck = (0, 0, r - h), (0, -h / 3, h / 4), (0, 0, h)
    thin = r / 8
    tubes = ((rear, low), (rear, seat), (low, head), (head, front), (neck, head))
    return together(
        rim(r, thin, rear, "x"),
        rim(r, thin, front, "x"),
        *(tube_between(start, end, thin) for start, end in tubes),
        *(tube_between(start, end, 2 * thin) for start, end in ((seat, head), (hips, neck))),
        placed(fb.sphere(1, h / 5), (0, h / 10, 6 * h / 5)),
    )


def build() -> fb.System:
    """Return the system: a massless frame leans on a massless carriage and carries the mass with the wheels."""
    s = fb.System("motorcycle")
    spin, r, v, R = s.parameters(I=0.8, r=0.3, v=25.0, R=80.0)
    m, h, g = s.parameters(m=250.0, h=0.6, g=9.81)
    s.assume(spin > 0, r > 0, R > 0, h > 0, g > 0)
    s.gravity = (0, 0, -g)
    nothing = fb.MassProperties(0, (0, 0, 0), ((0, 0, 0), (0, 0, 0), (0, 0, 0)))
    carriage = s.body("carriage", nothing, shape="nothing")
    frame = s.body("frame", nothing, shape=look(r, h))
    # two thin hoops: the moment of inertia about a diameter is half
    inertia = ((2 * spin, 0, 0), (0, spin, 0), (0, 0, spin))
    wheels = s.body("wheels", fb.MassProperties(m, (0, 0, 0), inertia), shape="nothing")
    s.scenery = fb.box(1, (9 * h / 5, 22 * h / 5, h / 20)).moved((R, 0, -41 * h / 40))
    s.hinge("turn", s.ground, carriage, axis="z", coordinate="psi")
    s.hinge("lean", carriage, frame, at=(R, 0, 0), axis=(0, -1, 0), coordinate="theta")
    s.hinge("axle", frame, wheels, axis="x", coordinate="p")
    s.force("ground", frame.point(0, 0, -h), (-m * v**2 / R, 0, m * g), frame=carriage)
    explain(
        s,
        I="kg m²: moment of inertia of each wheel about its axle",
        r="m: radius of the wheels",
        v="m/s: speed",
        R="m: radius of the curve",
        m="kg: mass of the machine with its rider",
        h="m: distance of the mass centre from the line of contact",
        g="m/s²: gravity",
        psi="rad: turn of the machine about the vertical, to the left +",
        theta="rad: lean from the vertical, into the curve +",
        p="rad: angle of the wheels about the axle",
    )
    return s


def balance(case: Case) -> Any:
    """Return left minus right side of the equation of motion of theta in the steady curve."""
    e = case.equations
    motion = e.motion[e.model.speed_names.index("theta'")]
    return sympy.expand(case.put(motion.lhs - motion.rhs, {**CURVE, "p'": "-v/r"}))


def lean(case: Case, wheels: bool) -> Any:
    """Return the equilibrium lean with or without the spin of the wheels; their other momenta are neglected."""
    e, atoms = case.equations, case.atoms
    motion = e.motion[e.model.speed_names.index("theta'")]
    rate = sympy.Dummy("spin")
    whole = sympy.expand(case.put(motion.lhs - motion.rhs, {**CURVE, "p'": rate}))
    without = case.put(whole.coeff(rate, 0), {"I": 0})
    spun = whole.coeff(rate, 1) * case.system.expression("-v/r") if wheels else 0
    residual = sympy.expand(without + spun)
    theta = atoms["theta"]
    # a sin + b cos = 0
    a, b = residual.coeff(sympy.sin(theta), 1), residual.coeff(sympy.cos(theta), 1)
    assert sympy.expand(residual - a * sympy.sin(theta) - b * sympy.cos(theta)) == 0
    return sympy.atan(sympy.cancel(-b / a))


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, saved

    case.refuse_unless("v", case["v"] > 0, "a speed greater than 0")
    e = case.equations
    upright = {**CURVE, "theta": 0, "p": 0}
    moment = case.put(e.reactions["axle"].moment, upright)
    size = case.formula(
        "torque that must act on both wheels together, upright: its size",
        sympy.sqrt(sum(x**2 for x in moment)), "N m", 'fb.equations(s).reactions["axle"].moment',
    )  # fmt: skip
    along = case.number(moment[1])
    answers: Answers = {
        "M": size,
        "direction": Answer(
            "its direction",
            f"about the direction of travel, pointing {'backwards' if along < 0 else 'forwards'} in a left turn "
            f"(right-hand rule): it turns the wheels' tops {'into' if along < 0 else 'out of'} the curve",
            "",
            how="its component along y",
        ),
        "arises": Answer(
            "how this torque arises",
            "the spin momentum of the wheels, 2 I v/r along the axles, turns with the machine at v/R: it changes at "
            "2 I v^2/(r R). The bearings of the axles give this torque to the wheels, and the frame has it from the "
            "ground: the machine leans so far that the weight on the tyres, at the arm h sin(lean) from C, has more "
            "moment about C than the friction m v^2/R at the arm h cos(lean)",
            "",
            how="dH/dt = omega x H for the wheels; moments about C for the whole machine",
        ),
        "lean": case.formula(
            "lean from the vertical with the gyroscopic effect",
            lean(case, True),
            "rad",
            "equation of motion of theta",
        ),
        "lean_without": case.formula(
            "lean from the vertical without it",
            lean(case, False),
            "rad",
            "equation of motion of theta, wheels at rest",
        ),
    }
    whole = full_lean(case, answers["lean"].value)
    start = {
        name: case.number(case.system.expression(x)) for name, x in CURVE.items() if "''" not in name and x
    }
    trajectory = case.motion(initial={**start, "theta": whole})
    # the equilibrium is unstable, like that of a bar on its end: round-off grows, so the check is early
    soon = case.simulate_to([0, 0.05], initial={**start, "theta": whole})
    needed = np.abs(soon.reactions["turn"].force).max() / (case["m"] * case["g"])
    tilt = answers["lean"].value
    from_ground = case["m"] * (
        case["g"] * case["h"] * math.sin(tilt) - case["v"] ** 2 / case["R"] * case["h"] * math.cos(tilt)
    )
    checks = (
        same("moment of the ground's forces about C against the torque on the leaning wheels",
             from_ground / size.value, math.cos(tilt), 1e-12),
        Check("nothing but the ground carries C round: force at the axis of the curve over weight",
              float(needed), 1e4 * case.tolerance),
        Check("lean with all momenta of the wheels, relative difference (smaller than r/R)",
              abs(whole / answers["lean"].value - 1), case["r"] / case["R"]),
        Check("steady: change of the lean in 0.05 s", float(np.ptp(soon["theta"])), 1e4 * case.tolerance),
    )  # fmt: skip
    plots: Plots = {
        "axle.png": saved(lambda: moments(trajectory, "axle", "Motorcycle in a curve: moment on its wheels")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def full_lean(case: Case, guess: float) -> float:
    """Return the equilibrium lean with all momenta, near a guess, by Newton's method on the equation of motion."""
    theta = case.atoms["theta"]
    residual = case.put(balance(case), case.values)
    slope = sympy.diff(residual, theta)
    for _ in range(20):
        step = float(residual.subs(theta, guess)) / float(slope.subs(theta, guess))
        guess -= step
        if abs(step) < 1e-15:
            break
    return guess


MOTORCYCLE = Entry(
    "prob-6-18",
    ("motorcycle",),
    "Motorcycle in a curve: torque on the wheels, and lean (Problem 6.18)",
    (
        "torque (upright wheels, size and direction) that makes the wheels turn with the curve, and how it arises",
        "lean from the vertical, with and without the gyroscopic effect",
    ),
    build,
    solve,
    until=0.2,
    positive=("m",),
    drawn={"psi": 0, "theta": "8deg"},
    start={"psi'": "v/R", "p'": "-v/r"},
)
