"""Disk that rolls off the corner of a ledge (chapter, Problem 6.8).

The corner O is the origin; the disk moves to the left, and theta, the angle of OC from the upward vertical, is
positive in that direction, counter-clockwise. Without slip it turns about O; with the friction mu it slips before it
leaves.
"""

from __future__ import annotations

import math
from typing import Any

import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry

CENTRED = {"x": 0, "y": 0, "x'": 0, "y'": 0}
TOP = {**CENTRED, "theta": 0, "theta'": 0}
BEGIN = 0.05
"""Initial angle of the run [rad], with the speed of a fall from rest at the top."""


def build() -> fb.System:
    """Return the system; x, y belong to the point of the rim that touches O at the top, theta is the disk's turn."""
    s = fb.System("disk_on_ledge")
    m, R, g, mu = s.parameters(m=3.0, R=0.25, g=9.81, mu=0.5)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.planar("plane", s.ground, disk, to=(0, -R, 0), coordinate="x y theta")
    s.scenery = fb.box(1, (5 * R / 2, R, 1)).moved((5 * R / 4, -R / 2, 0))  # the ledge, whose corner is O
    s.contact("O", disk.circle(R), s.ground.point(0, 0, 0), friction=mu)
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the disk",
        g="m/s²: gravity",
        mu="1: friction at the corner, for the last answers and the run",
        x="m: displacement of the point of the rim that was at O",
        y="m: its height",
        theta="rad: turn of the disk, counter-clockwise",
    )
    return s


def pivoted(case: Case) -> fb.System:
    """Return the same disk on a hinge at O, for comparison: its reaction along OC is N."""
    s = fb.System("disk_on_pivot")
    m, R, g = s.parameters(m=case["m"], R=case["R"], g=case["g"])
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    s.hinge("O", s.ground, disk, to=(0, -R, 0), coordinate="theta")
    return s


def line(case: Case, state: Any) -> float:
    """Return the angle of OC from the vertical: C is R above the point of the rim at x, y."""
    x, y, theta = (float(state[name]) for name in ("x", "y", "theta"))
    return math.atan2(case["R"] * math.sin(theta) - x, case["R"] * math.cos(theta) + y)


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.contact_plots import contact_forces
    from ....picture.plots.plots import energy_residual, history, saved

    case.refuse_unless("mu", case["mu"] > 0, "friction greater than 0")
    e = case.equations
    rate = case.atoms["theta'"]
    square = case.square_of_speed("theta'", TOP, CENTRED)
    falling = sympy.Eq(rate**2, square)
    solution = e.solve(["theta''", "N_O", "T_O"], where=CENTRED)
    leaving = e.solve(["theta", "theta'^2"], where=[{**CENTRED, "N_O": 0}, falling])
    (place,) = [b for b in leaving.branches if 0 < case.number(b["theta"]) < math.pi / 2]
    away = {**CENTRED, "theta": place["theta"], "theta'": sympy.sqrt(place["theta'^2"])}
    free = case.touching(O="open")
    flying = free.equations.solve("theta''")["theta''"]
    how = 'fb.equations(s, modes={"O": "stick"}).solve'
    energy = how + '("theta", where="N_O = 0" and the energy integral)'
    answers: Answers = {
        "theta": case.formula(
            "angle of OC from the vertical where N vanishes", place["theta"], "rad", energy
        ),
        "omega": case.formula("angular velocity then", away["theta'"], "rad/s", energy),
        "alpha": case.formula(
            "angular acceleration just before", case.put(solution["theta''"], away), "rad/s²", how
        ),
        "T": case.formula("tangential contact force then", case.put(solution["T_O"], away), "N", how),
        "alpha_after": free.formula(
            "angular acceleration just after", flying, "rad/s²", 'fb.equations(s, modes={"O": "open"}).solve'
        ),
    }
    slip = e.solve(["theta", "theta'^2"], where=[CENTRED, "T_O = mu*N_O", falling])
    (begins,) = [b for b in slip.branches if 0 < case.number(b["theta"]) < answers["theta"].value]
    answers["theta_slip"] = case.formula(
        "with the friction mu: angle of OC at which it begins to slip", begins["theta"], "rad",
        how + '("theta", where="T_O = mu*N_O" and the energy integral)',
    )  # fmt: skip
    first = min(BEGIN, answers["theta_slip"].value / 2)
    start = {"theta": first, "theta'": math.sqrt(case.number(square, {"theta": first}))}
    fine = case.tolerance / 100
    motion, gone = case.simulate_to_mode("O", "open", initial=start, tolerance=fine)
    where = "fb.simulate, event located"
    answers["theta_leave"] = Answer(
        "angle of OC at which it then leaves O", line(case, gone.state), "rad", how=where
    )
    answers["omega_leave"] = Answer(
        "angular velocity with which it flies", float(gone.state["theta'"]), "rad/s", how=where
    )
    slips = next(event for event in motion.events if "stick → slip" in str(event))
    pivot = fb.simulate(
        pivoted(case), 10 * case.until, initial=start, tolerance=fine,
        events=[fb.event("g*cos(theta) - R*theta'^2", terminal=True)],
    )  # fmt: skip
    push = pivot.reactions["O"].force[-1]
    bound = 1000 * case.tolerance
    # with the friction mu it leaves later by 1.4e-2/mu in cos; the accelerations in slip have a round-off of mu eps
    high_mu = 1 / bound
    _, rough = case.having(mu=high_mu).simulate_to_mode("O", "open", initial=start, tolerance=fine)
    now = answers["theta"].value
    along = (-math.sin(now), math.cos(now))
    weight = case["m"] * case["g"]
    checks = (
        same("theta and omega against the disk on a hinge", [now, answers["omega"].value],
             [pivot["theta"][-1], pivot["theta'"][-1]], bound),
        same("N at this angle, reaction of the hinge along OC over the weight",
             (push[0] * along[0] + push[1] * along[1]) / weight, 0, bound),
        same("T against the reaction of the hinge", answers["T"].value,
             push[0] * along[1] - push[1] * along[0], bound),
        same(f"theta and omega against the simulation with the friction {high_mu:g}", [now, answers["omega"].value],
             [line(case, rough.state), float(rough.state["theta'"])], bound),
        same("theta_slip against the simulation", answers["theta_slip"].value, line(case, slips.state), bound),
    )  # fmt: skip
    trajectory = case.motion(initial=start)
    plots: Plots = {
        "angle.png": saved(lambda: history(trajectory, ["theta", "theta'"], title="Disk on a ledge")),
        "forces.png": saved(lambda: contact_forces(trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


DISK_ON_LEDGE = Entry(
    "prob-6-8",
    ("disk-on-ledge",),
    "Disk that turns about the corner of a ledge and leaves it (Problem 6.8)",
    (
        "without slip: angle, angular velocity and acceleration where the normal force vanishes, friction then",
        "angular acceleration just after",
        "with the friction mu: where it begins to slip, and where it leaves",
    ),
    build,
    solve,
    until=0.8,
    positive=("g",),
    start={"theta": BEGIN},
    drawn={"x": 0, "y": 0, "theta": "25deg"},
    modes={"O": "stick"},
    fixed_values={**CENTRED, "x''": 0, "y''": 0},
)
