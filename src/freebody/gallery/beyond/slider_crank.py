"""Slider-crank: a crank driven at constant speed, a rod and a piston without friction.

With n = sin(b)/sin(a) = -r/L the piston is at x = r cos a + sqrt(L² - r² sin² a), a = omega t.
"""

from __future__ import annotations

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved
from ..tools.case import Case, explain
from ..tools.entry import Entry


def build() -> fb.System:
    """Return the mechanism: the crank pin carries the rod, and the wrist pin closes the loop."""
    s = fb.System("slider_crank")
    r, L, omega = s.parameters(r=0.05, L=0.16, omega=100.0)
    m_1, m_2, m_3, t_1 = s.parameters(m_1=1.5, m_2=0.6, m_3=0.5, t_1=0.012)
    crank = s.body("crank", fb.slender_bar(m_1, r))
    rod = s.body("rod", fb.slender_bar(m_2, L))
    piston = s.body("piston", fb.particle(m_3))
    s.hinge("shaft", s.ground, crank, to=(-r / 2, 0, 0), coordinate=omega * s.t)
    s.hinge("crank_pin", crank, rod, at=(r / 2, 0, 0), to=(-L / 2, 0, 0), coordinate="b")
    s.slider("cylinder", s.ground, piston, axis="x", coordinate="x")
    s.hinge("wrist_pin", rod, piston, at=(L / 2, 0, 0))
    explain(
        s,
        r="m: length of the crank",
        L="m: length of the rod",
        omega="rad/s: angular velocity of the crank",
        m_1="kg: mass of the crank",
        m_2="kg: mass of the rod",
        m_3="kg: mass of the piston",
        t_1="s: time to answer for",
        b="rad: angle of the rod from the crank",
        x="m: distance of the piston from the shaft",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, reaction, saved

    near = {"x": "L"}  # the other position has the piston on the far side
    at = case.simulate_to([case["t_1"]], near=near)
    here = {name: float(at[name][0]) for name in ("b", "x", "b'", "x'", "t")}
    shaft, cylinder, pin = (at.reactions[name] for name in ("shaft", "cylinder", "wrist_pin"))
    answers: Answers = {
        "x(t_1)": Answer("x at t_1", here["x"], "m"),
        "x'(t_1)": Answer("x' at t_1", here["x'"], "m/s"),
        "x''(t_1)": Answer("x'' at t_1", case.accelerations(here)["x''"], "m/s²"),
        "torque(t_1)": Answer("torque on the crank at t_1", float(shaft.moment[0, 2]), "N m"),
        "F_cylinder(t_1)": Answer(
            "force of the cylinder on the piston at t_1 (y)", float(cylinder.force[0, 1]), "N"
        ),
        "F_rod(t_1)": Answer("force of the rod on the piston at t_1 (x)", float(pin.force[0, 0]), "N"),
        "T(t_1)": Answer("kinetic energy at t_1", float(at.energy.kinetic[0]), "J"),
    }
    trajectory = case.motion(near=near)
    plots: Plots = {
        "piston.png": saved(lambda: history(trajectory, "x", title="Slider-crank: place of the piston")),
        "cylinder.png": saved(lambda: reaction(trajectory, "cylinder", axes="y")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


SLIDER_CRANK = Entry(
    "slider-crank",
    (),
    "Slider-crank with a driven crank: a joint that closes a loop",
    ("place, speed and acceleration of the piston at t_1", "torque on the crank, side force of the cylinder"),
    build,
    solve,
    until=0.15,
    near={"x": "L"},
)
