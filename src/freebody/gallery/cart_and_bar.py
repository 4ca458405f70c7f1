"""Particle on a guided spring with a hinged bar, force on the bar's free end (chapter, Example 6.5).

x is the displacement of the particle M to the right, theta the angle of the bar from the downward vertical,
counter-clockwise +.
"""

from __future__ import annotations

import freebody as fb

from .entry import Answers, Case, Entry, Plots, explain, states


def build() -> fb.System:
    """The guide is the x axis; the bar of length 2 a hangs along y at theta = 0."""
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


def solve(case: Case) -> tuple[fb.Trajectory, Answers, Plots]:
    from ..picture.plots import energy_residual, history, reaction, saved

    answers: Answers = {
        f"equation of {name}": (text, "")
        for name, text in zip(("x", "theta"), case.equations.text().splitlines(), strict=True)
    }
    for label in ("t_1", "t_2"):
        at = case.simulate_to([case[label]])
        answers |= states(at, 0, {"x": "m", "theta": "rad", "x'": "m/s", "theta'": "rad/s"}, label)
        # the pin's reaction is that on the bar; the particle feels the opposite
        F_x, F_y, _ = -at.reactions["pin"].force[0]
        answers |= {
            f"hinge force F_x on M at {label}": (float(F_x), "N"),
            f"hinge force F_y on M at {label}": (float(F_y), "N"),
            f"ground force f on M (up +) at {label}": (float(at.reactions["guide"].force[0, 1]), "N"),
        }
    trajectory = case.motion()
    plots: Plots = {
        "coordinates.png": saved(lambda: history(trajectory, title="Particle on a spring with a hinged bar")),
        "hinge.png": saved(lambda: reaction(trajectory, "pin", axes="xy")),
        "guide.png": saved(lambda: reaction(trajectory, "guide", axes="y")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return trajectory, answers, plots


CART_AND_BAR = Entry(
    "ex-6-5",
    ("cart-and-bar",),
    "Particle on a spring with a hinged bar, force on its end (Example 6.5)",
    ("equations of motion", "x, theta, x', theta' at t_1 and t_2", "hinge force and ground force then"),
    build,
    solve,
    until=10.0,
)
