"""Two links that fold under a line, a mass, two springs and a pulley (chapter, Problem 6.16).

theta is the angle of each link below the horizontal, x the displacement of the mass M to the left. The pulley B rolls
on the line to the right of O; at x = theta = 0 the links are aligned and both springs are relaxed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved, same
from ...tools.case import Case, explain, states
from ...tools.entry import Entry

STRAIGHT = {"x": 0, "theta": 0, "x'": 0, "theta'": 0}


def build() -> fb.System:
    """Return the system: the pulley carries link 2, link 2 carries link 1, and the hinge O closes the loop."""
    s = parts()
    theta, theta_2, x_B = s.coordinates("theta theta_2 x_B")
    pulley = s.body("pulley", fb.particle(0), shape=fb.disk(1, 0.06))
    s.slider("line", s.ground, pulley, at=("2*L", 0, 0), axis="x", coordinate=x_B)
    link_1, link_2 = s.bodies["link_1"], s.bodies["link_2"]
    s.hinge("B", pulley, link_2, to=("L/2", 0, 0), axis="z", coordinate=theta_2)
    s.hinge("A", link_2, link_1, at=("-L/2", 0, 0), to=("L/2", 0, 0), axis="z", coordinate=-theta - theta_2)
    s.hinge("O", s.ground, link_1, to=("-L/2", 0, 0), axis="z")
    s.assume(s.expression("L - x - x_B") > 0)  # the length of the spring
    s.spring("spring", pulley.origin, s.bodies["mass"].origin, stiffness="k_1", rest="L")
    explain(
        s,
        theta="rad: angle of link 1 below the horizontal",
        theta_2="rad: angle of link 2 below the horizontal, the same as theta",
        x_B="m: displacement of the pulley to the right, -2 L (1 - cos theta)",
    )
    return s


def symmetric() -> fb.System:
    """Return the machine with theta for both links: its equations of motion use these two coordinates."""
    s = parts()
    theta, link_1, link_2 = s.coordinates("theta"), s.bodies["link_1"], s.bodies["link_2"]
    s.hinge("O", s.ground, link_1, to=("-L/2", 0, 0), axis="z", coordinate=-theta)
    s.hinge("A", link_1, link_2, at=("L/2", 0, 0), to=("-L/2", 0, 0), axis="z", coordinate=2 * theta)
    s.assume(s.expression("3*L - x - 2*L*cos(theta)") > 0)
    s.spring("spring", link_2.point("L/2", 0, 0), s.bodies["mass"].origin, stiffness="k_1", rest="L")
    return s


def parts() -> fb.System:
    """Return a system with parameters, mass and links; the mass slides to the left."""
    s = fb.System("two_links")
    m, L, M, *_ = s.parameters(m=1.0, L=0.5, M=2.0, k_1=200.0, k_2=100.0, g=9.81, t_1=0.5, t_2=1.0)
    s.gravity = (0, "-g", 0)
    mass = s.body("mass", fb.particle(M))
    for name in ("link_2", "link_1"):
        s.body(name, fb.slender_bar(m, L, axis="x"))
    guide = s.slider("guide", s.ground, mass, at=(3 * L, 0, 0), axis=(-1, 0, 0), coordinate="x")
    s.spring("k_2", guide, stiffness="k_2")
    explain(
        s,
        m="kg: mass of each link",
        L="m: length of each link",
        M="kg: mass on the line",
        k_1="N/m: stiffness of the spring from the pulley to M",
        k_2="N/m: stiffness of the spring from M to the wall",
        g="m/s²: gravity",
        t_1="s: first time to answer for",
        t_2="s: second time to answer for",
        x="m: displacement of the mass to the left",
    )
    return s


def equilibrium(case: Case) -> tuple[float, float]:
    """Return x and theta at rest, 0 <= theta < 90 degrees: the only equilibrium to the right of O."""
    solutions = [
        state
        for state in fb.steady_motions(case.equations, values=case.values).states
        if 0 <= float(state.state["theta"]) < np.pi / 2
    ]
    if len(solutions) != 1:
        raise fb.errors.ModelError(
            f"Expected one static equilibrium with theta from 0 to 90 degrees, got {len(solutions)}."
        )
    return float(solutions[0].state["x"]), float(solutions[0].state["theta"])


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, reaction, saved

    for name in ("m", "M", "k_1", "k_2"):
        case.refuse_unless(name, case[name] > 0, "links, a mass and springs with values above 0")
    reduced = symmetric()
    small = replace(case, system=reduced, equations=fb.equations(reduced))
    answers: Answers = {
        "equation_x": small.equation(0, "equation of motion of x"),
        "equation_theta": small.equation(1, "equation of motion of theta"),
    }
    at = {label: case.simulate_to([case[label]], initial=STRAIGHT) for label in ("t_1", "t_2")}
    units = {"x": "m", "theta": "rad", "x'": "m/s", "theta'": "rad/s"}
    for label, motion in at.items():
        answers |= states(motion, 0, units, label)
    how = "fb.steady_motions(s, values=...)"
    x, theta = equilibrium(case)
    answers["x_s"] = Answer("static equilibrium: x", x, "m", how=how)
    answers["theta_s"] = Answer(
        "static equilibrium: theta, the only one from 0 to 90 degrees", theta, "rad", how=how
    )
    bound = 1000 * case.tolerance
    twin = small.simulate_to([case["t_2"]], initial=STRAIGHT)
    balance = small.accelerations({"x": x, "theta": theta, "x'": 0, "theta'": 0})
    checks = (
        *(
            same(
                f"{name}(t_2) of the machine with one angle for both links",
                twin[name][-1],
                at["t_2"][name][-1],
                bound,
            )
            for name in units
        ),
        same("accelerations in static equilibrium", list(balance.values()), 0, bound),
    )
    trajectory = case.motion(initial=STRAIGHT)
    plots: Plots = {
        "coordinates.png": saved(
            lambda: history(trajectory, ["x", "theta"], title="Two links, mass and two springs")
        ),
        "line.png": saved(lambda: reaction(trajectory, "line", axes="y")),
        "support.png": saved(lambda: reaction(trajectory, "O", axes="xy")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


TWO_LINKS = Entry(
    "prob-6-16",
    ("two-links",),
    "Two links, a mass, two springs and a pulley (Problem 6.16)",
    (
        "equations of motion in x and theta",
        "x, theta, x', theta' at t_1 and t_2",
        "static equilibrium",
    ),
    build,
    solve,
    until=3.0,
    positive=("g",),
    near={"x": "L/20"},
)
