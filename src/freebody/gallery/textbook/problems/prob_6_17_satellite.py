"""Spinning symmetric satellite hit by an impulse (chapter, Problem 6.17).

Axis 3 = z is the symmetry axis. The impulse J along +3 acts on the side of axis 2, at the distance `arm` from
axis 3; the motion about the mass centre is then torque-free. At t = 0 body axes and inertial axes coincide.
"""

from __future__ import annotations

import math
from typing import Any

import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.pictures import tip
from ..examples.sec_6_8_torque_free import answer, checks

SPINNING = {"C_wx": 0, "C_wy": 0, "C_wz": "spin"}


def build() -> fb.System:
    """Return a body on a ball joint at its mass centre, in a frame that moves with it: its mass does not matter."""
    s = fb.System("satellite")
    I_3, I_1 = s.parameters(I_3=2000.0, I_1=1600.0)
    s.parameters(spin="5*pi", J=300.0, arm=1.68, t_1=1.0)
    s.assume(I_1 > 0, I_3 > 0)
    drum = s.body("body", fb.MassProperties(1, (0, 0, 0), ((I_1, 0, 0), (0, I_1, 0), (0, 0, I_3))))
    s.ball("C", s.ground, drum)
    explain(
        s,
        I_3="kg m²: moment of inertia about the symmetry axis",
        I_1="kg m²: moment of inertia about a transverse axis",
        spin="rad/s: angular velocity about the symmetry axis before the impulse",
        J="N s: impulse parallel to the symmetry axis",
        arm="m: distance of the impulse from the symmetry axis, on the side of axis 2",
        t_1="s: time to answer for",
    )
    return s


def just_after(case: Case) -> tuple[Any, Any, Any]:
    """Return the angular velocity in body axes just after the impulse."""
    s, atoms = case.system, case.atoms
    drum = s.bodies["body"]
    hit = fb.impulse(
        case.equations,
        at=drum.point(0, atoms["arm"], 0),
        impulse=(0, 0, atoms["J"]),
        frame=drum,
        initial=SPINNING,
    )
    x, y, z = (sympy.sympify(hit.after[f"C_w{axis}"]) for axis in "xyz")
    return x, y, z


def interpretation(alpha: float, rate: float) -> str:
    """Describe the rolling cones, from the angle of axis 3 with H and the rate at which omega turns in the body."""
    if alpha == 0:
        return "no wobble: the satellite spins about axis 3, which stays where it is"
    if rate > 0:
        return (
            "flat body: omega lies beyond H as seen from axis 3; the body cone (half angle beta about axis 3) rolls "
            "with its inside on the fixed space cone (half angle beta - alpha about H)"
        )
    if rate == 0:
        return "equal moments: omega stays along H"
    return (
        "slender body: omega lies between axis 3 and H; the body cone (half angle beta about axis 3) rolls on the "
        "outside of the fixed space cone (half angle alpha - beta about H)"
    )


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    after = just_after(case)
    how = "fb.impulse(s, at=body.point(0, arm, 0), impulse=(0, 0, J), frame=body)"
    answers: Answers = {
        f"w_{i}": case.formula(
            f"angular velocity about body axis {i} just after the impulse", x, "rad/s", how
        )
        for i, x in enumerate(after, 1)
    }
    answers |= answer(case, after)
    answers["interpretation"] = Answer(
        "geometric interpretation",
        interpretation(answers["alpha"].value, answers["Omega"].value * math.copysign(1, case["spin"])),
        "",
        how="alpha, and the sign of Omega",
    )
    trajectory = case.motion(initial={f"C_w{a}": case.number(x) for a, x in zip("xyz", after, strict=True)})
    H = [trajectory[part][0] for part in case.equations.momentum.angular()]
    plots: Plots = {
        "omega.png": saved(
            lambda: history(
                trajectory, ["C_wx", "C_wy", "C_wz"], title="Satellite: angular velocity in body axes"
            )
        ),
        "axis_3.png": saved(
            lambda: tip(trajectory, "body", "Satellite: path of axis 3", about=("angular momentum H", H))
        ),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks(case, trajectory))


SATELLITE = Entry(
    "prob-6-17",
    ("satellite", "struck-satellite"),
    "Spinning satellite hit by an impulse (Problem 6.17)",
    (
        "angular velocity just after the impulse",
        "rate Omega of omega about axis 3, angles alpha and beta of axis 3 with H and omega, precession rate",
        "omega (body) and axis 3 (inertial) at t_1",
        "geometric interpretation",
    ),
    build,
    solve,
    until=2.0,
    start=SPINNING,
)
