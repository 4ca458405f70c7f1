"""Two uniform links in series, hung from a fixed point (chapter, Problem 6.15).

theta_1, theta_2 are the absolute angles of the links from the downward vertical, counter-clockwise +.
"""

from __future__ import annotations

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved, same
from ...tools.case import Case, explain, states
from ...tools.entry import Entry

START = {"theta_1": "theta_10", "theta_2": "theta_20"}


def build() -> fb.System:
    """Return the system; both links hang along y at theta_1 = theta_2 = 0."""
    s = fb.System("double_pendulum")
    m1, m2, L1, L2, g = s.parameters(m1=2.0, m2=1.0, L1=0.8, L2=0.6, g=9.81)
    s.parameters(theta_10=0.5, theta_20=1.0, t_1=1.0, t_2=2.0)
    s.assume(m1 > 0, m2 > 0, L1 > 0, L2 > 0, g > 0)
    theta_1, theta_2 = s.coordinates("theta_1 theta_2")
    s.gravity = (0, -g, 0)
    link_1 = s.body("link_1", fb.slender_bar(m1, L1, axis="y"))
    link_2 = s.body("link_2", fb.slender_bar(m2, L2, axis="y"))
    s.hinge("O", s.ground, link_1, to=(0, L1 / 2, 0), axis="z", coordinate=theta_1)
    s.hinge(
        "J", link_1, link_2, at=(0, -L1 / 2, 0), to=(0, L2 / 2, 0), axis="z", coordinate=theta_2 - theta_1
    )
    explain(
        s,
        m1="kg: mass of link 1",
        m2="kg: mass of link 2",
        L1="m: length of link 1",
        L2="m: length of link 2",
        g="m/s²: gravity",
        theta_10="rad: theta_1 at the start",
        theta_20="rad: theta_2 at the start",
        t_1="s: first time to answer for",
        t_2="s: second time to answer for",
        theta_1="rad: angle of link 1 from the downward vertical",
        theta_2="rad: angle of link 2 from the downward vertical",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, reaction, saved

    answers: Answers = {
        f"equation_{k}": case.equation(k - 1, f"equation of motion of theta_{k}") for k in (1, 2)
    }
    at = {label: case.simulate_to([case[label]], initial=START) for label in ("t_1", "t_2")}
    units = {"theta_1": "rad", "theta_2": "rad", "theta_1'": "rad/s", "theta_2'": "rad/s"}
    for label, motion in at.items():
        answers |= states(motion, 0, units, label)
    for label, motion in at.items():
        for joint, what in (("O", "force of the support on link 1"), ("J", "force of link 1 on link 2")):
            for axis, force in zip("xy", motion.reactions[joint].force[0], strict=False):
                answers[f"{joint}_{axis}({label})"] = Answer(
                    f"{what} at {label}, {axis} component",
                    float(force),
                    "N",
                    how="fb.simulate(s, ...).reactions",
                )
    linear = fb.linearize(case.equations)
    for k, frequency in enumerate(sorted(linear.natural_frequencies(), key=case.number), 1):
        answers[f"omega_{k}"] = case.formula(
            f"{'lower' if k == 1 else 'higher'} frequency of small oscillation",
            frequency,
            "rad/s",
            "fb.linearize(s).natural_frequencies()",
        )
    energy = case.simulate_to([0.0, case["t_2"]], initial=START).energy
    checks = (
        same("energy at t_2 against the start", energy.total[-1], energy.total[0], 1000 * case.tolerance),
    )
    trajectory = case.motion(initial=START)
    plots: Plots = {
        "angles.png": saved(lambda: history(trajectory, title="Two links")),
        "support.png": saved(lambda: reaction(trajectory, "O", axes="xy")),
        "joint.png": saved(lambda: reaction(trajectory, "J", axes="xy")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


DOUBLE_PENDULUM = Entry(
    "prob-6-15",
    ("double-pendulum",),
    "Two links, or compound double pendulum (Problem 6.15)",
    (
        "equations of motion",
        "angles and their rates at t_1 and t_2, forces at the support and at the joint then",
        "frequencies of small oscillation",
    ),
    build,
    solve,
    until=10.0,
)
