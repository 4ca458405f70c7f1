"""Particle on a guided spring with a hinged bar, force on the bar's free end (chapter, Example 6.5).

x is the displacement of the particle M to the right, theta the angle of the bar from the downward vertical,
counter-clockwise +.
"""

from __future__ import annotations

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved
from ...tools.case import Case, explain, states
from ...tools.entry import Entry


def build() -> fb.System:
    """Return the system; the guide is the x axis, and the bar of length 2 a hangs along y at theta = 0."""
    s = fb.System("cart_and_bar")
    M, m, a, k, F, g = s.parameters(M=2.0, m=1.0, a=0.5, k=50.0, F=3.0, g=9.81)
    s.parameters(t_1=1.0, t_2=2.0)
    s.gravity = (0, -g, 0)
    cart = s.body("cart", fb.particle(M))
    bar = s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    guide = s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    s.hinge("pin", cart, bar, to=(0, a, 0), axis="z", coordinate="theta")
    s.spring("spring", guide, stiffness=k)
    s.force("F", bar.point(0, -a, 0), (F, 0, 0))
    explain(
        s,
        M="kg: mass of the particle",
        m="kg: mass of the bar",
        a="m: half the length of the bar",
        k="N/m: stiffness of the spring",
        F="N: force on the lower end of the bar, to the right",
        g="m/s²: gravity",
        t_1="s: first time to answer for",
        t_2="s: second time to answer for",
        x="m: displacement of the particle to the right",
        theta="rad: angle of the bar from the downward vertical, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, reaction, saved

    case.refuse_unless("k", case["k"] >= 0, "a stiffness of at least 0")
    answers: Answers = {
        "equation_x": case.equation(0, "equation of motion of x"),
        "equation_theta": case.equation(1, "equation of motion of theta"),
    }
    at = {label: case.simulate_to([case[label]]) for label in ("t_1", "t_2")}
    units = {"x": "m", "theta": "rad", "x'": "m/s", "theta'": "rad/s"}
    for label, motion in at.items():
        answers |= states(motion, 0, units, label)
    for label, motion in at.items():
        # the pin's reaction acts on the bar; the opposite force acts on the particle
        F_x, F_y, _ = -motion.reactions["pin"].force[0]
        f = motion.reactions["guide"].force[0, 1]
        how = "fb.simulate(s, ...).reactions"
        answers |= {
            f"F_x({label})": Answer(f"hinge force on M at {label}, x component", float(F_x), "N", how=how),
            f"F_y({label})": Answer(f"hinge force on M at {label}, y component", float(F_y), "N", how=how),
            f"f({label})": Answer(f"force of the ground on M at {label}, up +", float(f), "N", how=how),
        }
    trajectory = case.motion()
    plots: Plots = {
        "coordinates.png": saved(lambda: history(trajectory, title="Particle on a spring with a hinged bar")),
        "hinge.png": saved(lambda: reaction(trajectory, "pin", axes="xy")),
        "guide.png": saved(lambda: reaction(trajectory, "guide", axes="y")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


CART_AND_BAR = Entry(
    "ex-6-5",
    ("cart-and-bar",),
    "Particle on a spring with a hinged bar, force on its end (Example 6.5)",
    ("equations of motion", "x, theta, x', theta' at t_1 and t_2", "hinge force and ground force then"),
    build,
    solve,
    until=10.0,
)
