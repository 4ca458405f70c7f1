"""Disk fixed to the end of a massless rod, let go from the horizontal (chapter, Problem 6.6).

theta is the angle of the rod from the downward vertical, counter-clockwise +. The disk cannot turn relative to the
rod: rod and disk are one body.
"""

from __future__ import annotations

import sympy

import freebody as fb

from ...tools.answer import Answers, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry

RELEASE = {"theta": "theta_0", "theta'": 0}


def build() -> fb.System:
    """Return the system; the rod is along y of the body, from the centre of the disk up to the hinge O."""
    s = fb.System("disk_pendulum")
    m, L, R, g = s.parameters(m=2.0, L=1.0, R=0.2, g=9.81)
    s.parameters(theta_0="90deg", theta_1="30deg")
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R, axis="z"))
    s.hinge("O", s.ground, disk, to=(0, L, 0), axis="z", coordinate="theta")
    explain(
        s,
        m="kg: mass of the disk",
        L="m: length of the rod, from O to the centre of the disk",
        R="m: radius of the disk",
        g="m/s²: gravity",
        theta_0="rad: angle of release, at rest",
        theta_1="rad: angle to answer for, on the way down",
        theta="rad: angle of the rod from the downward vertical, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, reaction, saved

    case.refuse_unless("theta_0", 0 < case["theta_0"] < sympy.pi, "a release between 0 and 180 degrees")
    case.refuse_unless(
        "theta_1",
        abs(case["theta_1"]) < case["theta_0"],
        "an angle between -theta_0 and theta_0, which the rod passes",
    )
    e = case.equations
    place = {"theta": "theta_1"}
    speed = -sympy.sqrt(case.square_of_speed("theta'", RELEASE, place))
    solution = e.solve(["theta''", "O_x", "O_y"], where=place)
    force = [solution[name].subs(case.atoms["theta'"], speed) for name in ("O_x", "O_y")]
    angle = case.atoms["theta_1"]
    along = -sympy.sin(angle) * force[0] + sympy.cos(angle) * force[1]
    across = sympy.cos(angle) * force[0] + sympy.sin(angle) * force[1]
    linear = fb.linearize(e)
    (square,) = linear.M.LUsolve(linear.K)
    how = 'fb.equations(s).solve(["theta\'\'", "O_x", "O_y"]), theta\' by the energy integral'
    answers: Answers = {
        "equation": case.equation(0, "differential equation of the motion"),
        "theta'": case.formula(
            "angular velocity at theta_1 on the way down, counter-clockwise +", speed, "rad/s", "energy integral"
        ),
        "theta''": case.formula(
            "angular acceleration there, counter-clockwise +", solution["theta''"], "rad/s²", how
        ),
        "R_x": case.formula("reaction on the rod at O there, right +", force[0], "N", how),
        "R_y": case.formula("reaction on the rod at O there, up +", force[1], "N", how),
        "R_n": case.formula("its component along the rod, from the disk to O", along, "N", how),
        "R_t": case.formula("its component in the direction of increasing theta", across, "N", how),
        "omega_n": case.formula(
            "natural frequency of small oscillation",
            sympy.sqrt(square), "rad/s", "fb.linearize(s): sqrt(K / M)",
        ),
    }  # fmt: skip
    passed = [fb.event("theta - theta_1", name="theta_1", direction=-1)]
    swing = case.simulate_past(
        "theta_1", 1, initial=RELEASE, events=[fb.event("theta - theta_1", "theta_1", -1, terminal=True)]
    )
    bound = 1000 * case.tolerance
    checks = (
        same("theta' against the simulation", answers["theta'"].value, swing["theta'"][-1], bound),
        same(
            "reaction against the simulation",
            [answers["R_x"].value, answers["R_y"].value],
            swing.reactions["O"].force[-1, :2],
            bound,
        ),
    )
    trajectory = case.motion(initial=RELEASE, events=passed)
    plots: Plots = {
        "theta.png": saved(lambda: history(trajectory, "theta", title="Disk pendulum")),
        "reaction.png": saved(lambda: reaction(trajectory, "O", axes="xy")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


DISK_PENDULUM = Entry(
    "prob-6-6",
    ("disk-pendulum",),
    "Disk pendulum let go from the horizontal (Problem 6.6)",
    (
        "differential equation of the motion",
        "angular velocity and acceleration at the angle theta_1",
        "reaction at O there, horizontal and vertical, along the rod and across it",
        "frequency of small oscillation",
    ),
    build,
    solve,
    until=5.0,
    positive=("L", "g"),
    start={"theta": "theta_0"},
)
