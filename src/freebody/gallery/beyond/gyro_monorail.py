"""Gyro-stabilised monorail: a rotor, itself unstable in its gimbal, holds a car on one rail upright.

phi is the roll of the car about the rail X, theta the pitch of the gimbal about y of the car; the rotor's axis is up
at first. The mass centre of the rotor lies above the gimbal's axis: a gyro can stabilise two unstable motions, but not
a single one.
"""

from __future__ import annotations

from typing import Any

import sympy

import freebody as fb

from ...space.shape import Shape
from ..tools.answer import Answer, Answers, Plots, Printed, Solved, same
from ..tools.case import Case, explain, states
from ..tools.entry import Entry
from ..tools.looks import placed, rim, together, tube_between

START = {"phi": "phi_0"}


def look(h: Any, h_G: Any) -> Shape:
    """Return the car as it is drawn: on two wheels, with the bearings of its gimbal; its centre is the origin."""
    wheels = (rim(0.15, 0.03, (x, 0, 0.15 - h), "y") for x in (-0.5, 0.5))
    posts = (tube_between((0, y, 0.25 - h), (0, y, h_G - h), 0.02) for y in (-0.33, 0.33))
    return together(placed(fb.box(1, (1.6, 0.7, 0.06)), (0, 0, 0.27 - h)), *wheels, *posts)


def build() -> fb.System:
    """Return the car on the rail, the massless gimbal at h_G in it, and the rotor at a above the gimbal's axis."""
    s = fb.System("monorail")
    m_C, h, I_C = s.parameters(m_C=200.0, h=0.6, I_C=30.0)
    m_R, a, I_S, I_T = s.parameters(m_R=20.0, a=0.05, I_S=0.4, I_T=0.25)
    h_G, Omega, g = s.parameters(h_G=0.5, Omega=250.0, g=9.81)
    s.parameters(phi_0="2deg", t_1=2.0)
    s.assume(m_C > 0, h > 0, I_C > 0, m_R > 0, a > 0, I_S > 0, I_T > 0, h_G > 0, g > 0, Omega > 0)
    s.gravity = (0, 0, -g)
    car = s.body(
        "car", fb.MassProperties(m_C, (0, 0, 0), ((I_C, 0, 0), (0, I_C, 0), (0, 0, I_C))), shape=look(h, h_G)
    )
    gimbal = s.body("gimbal", fb.particle(0), shape=rim(0.3, 0.02, (0, 0, a), "z"))
    rotor = s.body(
        "rotor",
        fb.MassProperties(m_R, (0, 0, 0), ((I_T, 0, 0), (0, I_T, 0), (0, 0, I_S))),
        shape=fb.cylinder(1, 0.2, 0.12),
    )
    s.scenery = fb.cylinder(1, 0.03, 2.4, axis="x").moved((0, 0, -0.03))
    s.hinge("rail", s.ground, car, to=(0, 0, -h), axis="x", coordinate="phi")
    s.hinge("gimbal", car, gimbal, at=(0, 0, h_G - h), axis="y", coordinate="theta")
    s.hinge("axle", gimbal, rotor, at=(0, 0, a), axis="z", coordinate=Omega * s.t)
    explain(
        s,
        m_C="kg: mass of the car",
        h="m: height of its mass centre above the rail",
        I_C="kg m²: its moment of inertia about the mass centre, along the rail",
        m_R="kg: mass of the rotor",
        a="m: height of the rotor's mass centre above the gimbal's axis",
        I_S="kg m²: moment of inertia of the rotor about its axis",
        I_T="kg m²: moment of inertia of the rotor across its axis",
        h_G="m: height of the gimbal's axis above the rail",
        Omega="rad/s: speed of the rotor in the gimbal",
        g="m/s²: gravity",
        phi_0="rad: roll at the start, at rest",
        t_1="s: time to answer for",
        phi="rad: roll of the car about the rail",
        theta="rad: pitch of the gimbal",
    )
    return s


def least_speed(case: Case, linear: Any) -> Any:
    """Return the smallest Omega for which both pairs of roots of the linear equations are imaginary.

    A s⁴ + B s² + C has such roots where B >= 2 sqrt(A C) > 0; B grows with the square of Omega.
    """
    polynomial = linear.characteristic.expression
    (s,) = (x for x in polynomial.free_symbols if x.name == "s")
    C, B, A = (sympy.expand(polynomial).coeff(s, k) for k in (0, 2, 4))
    Omega = case.atoms["Omega"]
    square = (2 * sympy.sqrt(sympy.factor(A * C)) - B.coeff(Omega, 0)) / B.coeff(Omega, 2)
    return sympy.sqrt(square)


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, saved

    for name in ("m_C", "m_R", "a", "h", "I_S", "I_T", "g"):
        case.refuse_unless(name, case[name] > 0, "a car and a rotor that both topple: values above 0")
    linear = fb.linearize(case.equations)
    critical = least_speed(case, linear)
    written = linear.text().splitlines()
    answers: Answers = {
        f"equation_{name}": Answer(
            f"equation of motion of {name}, small angles",
            line,
            "",
            None,
            "fb.linearize(s)",
            Printed.line(line),
        )
        for name, line in zip(("phi", "theta"), written, strict=True)
    }
    answers["Omega_c"] = case.formula(
        "smallest speed of the rotor that keeps the car up", critical, "rad/s",
        "fb.linearize(s).characteristic: both pairs of roots imaginary",
    )  # fmt: skip
    least = answers["Omega_c"].value
    case.refuse_unless(
        "Omega", case["Omega"] > least, f"a speed above {least:g} rad/s, which keeps the car up"
    )
    modes = fb.linearize(case.equations, values=case.values).natural_frequencies()
    for k, (kind, frequency) in enumerate(
        zip(("slow precession", "fast nutation"), sorted(modes), strict=True), 1
    ):
        answers[f"omega_{k}"] = Answer(
            f"frequency {k}: {kind}",
            float(frequency),
            "rad/s",
            how="fb.linearize(s, values=...).natural_frequencies()",
        )
    at = case.simulate_to([case["t_1"]], initial=START)
    answers |= states(at, 0, {"phi": "rad", "theta": "rad"}, "t_1")
    checks = []
    for part, upright in ((1.001, True), (0.999, False)):
        roots = fb.linearize(case.equations, values={**case.values, "Omega": part * least}).eigenvalues()
        grows = max(roots.real) / max(abs(roots)) > 1e-6
        checks.append(same(f"wobble grows at {part:g} Omega_c: no (0) or yes (1)", grows, not upright, 0.0))
    trajectory = case.motion(initial=START)
    plots: Plots = {
        "angles.png": saved(
            lambda: history(
                trajectory, ["phi", "theta"], title="Monorail: roll of the car and pitch of the gimbal"
            )
        ),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks))


GYRO_MONORAIL = Entry(
    "gyro-monorail",
    (),
    "Gyro-stabilised monorail (beyond the chapter)",
    (
        "equations of motion for small angles",
        "smallest speed of the rotor that keeps the car up",
        "both frequencies at the speed Omega",
        "roll and pitch at t_1 after a start with the roll phi_0",
    ),
    build,
    solve,
    until=5.0,
    start=START,
)
