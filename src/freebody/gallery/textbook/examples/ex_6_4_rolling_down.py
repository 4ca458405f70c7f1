"""Disk that rolls from rest down a slope (chapter, Example 6.4).

The slope falls to the right by beta; phi is counter-clockwise, so it is negative after rolling down.
"""

from __future__ import annotations

import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved, fact, same
from ...tools.case import Case, angle_where, explain
from ...tools.entry import Entry

REST = {"s": 0, "n": 0, "phi": 0, "s'": 0, "n'": 0, "phi'": 0}


def build() -> fb.System:
    """Return the system; s is along the slope, n normal to it: the axes of the joint are rotated by -beta."""
    s = fb.System("rolling_down")
    m, R, _, beta, mu, g = s.parameters(m=5.0, R=0.25, H=2.0, beta="30deg", mu=0.5, g=9.81)
    s.gravity = (0, -g, 0)
    disk = s.body("disk", fb.disk(m, R))
    c, n = sympy.cos(beta), sympy.sin(beta)
    turned = ((c, n, 0), (-n, c, 0), (0, 0, 1))
    s.planar("plane", s.ground, disk, at=(R * n, R * c, 0), parent_axes=turned, coordinate="s n phi")
    s.contact("slope", disk.circle(R), s.ground.plane(normal=(n, c, 0)), friction=mu)
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the disk",
        H="m: height through which the centre drops",
        beta="rad: slope",
        mu="1: friction between disk and slope",
        g="m/s²: gravity",
        s="m: displacement down the slope",
        n="m: distance of the disk from the slope",
        phi="rad: turn of the disk, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    e = case.equations
    solution = e.solve(["s''", "phi''", "N_slope", "T_slope"])
    case.refuse_unless("beta", 0 < case["beta"] < sympy.pi / 2, "a slope between 0 and 90 degrees")
    case.refuse_unless("H", case["H"] > 0, "a height H greater than 0")
    beta, mu = case.atoms["beta"], case.atoms["mu"]
    steepest = angle_where(solution["T_slope"] + mu * solution["N_slope"], beta)
    needed = sympy.cancel(-solution["T_slope"] / solution["N_slope"])
    rolling = case.having(mu=max(case["mu"], 1.01 * case.number(needed)))
    rolls = case["mu"] >= case.number(needed)
    # rolling: phi' = s' phi''/s''
    rate = sympy.Dummy("rate", real=True)
    ratio = sympy.cancel(solution["phi''"] / solution["s''"])
    low = {**REST, "s": "H/sin(beta)"}
    energy = e.integrals["energy"].expression
    balance = sympy.expand(
        case.put(energy, {**low, "s'": rate, "phi'": ratio * rate}) - case.put(energy, REST)
    )
    square = sympy.simplify(-balance.coeff(rate, 0) / balance.coeff(rate, 2))
    how = "energy integral, from rest to H lower, and the condition of rolling"
    modes = 'fb.equations(s, modes={"slope": "stick"}).solve'
    answers: Answers = {
        "v_2": case.formula("speed of the centre when it has dropped by H", sympy.sqrt(square), "m/s", how),
        "omega_2": case.formula(
            "angular velocity then, counter-clockwise +", ratio * sympy.sqrt(square), "rad/s", how
        ),
        "a": case.formula("acceleration down the slope", solution["s''"], "m/s²", modes),
        "N": case.formula("normal force of the slope", solution["N_slope"], "N", modes),
        "H_up": case.formula("friction on the disk, up the slope +", -solution["T_slope"], "N", modes),
        "mu_needed": case.formula("friction that rolling takes", needed, "1", modes + ", T_slope/N_slope"),
        "beta_max": case.formula(
            "with the friction mu: steepest slope on which it rolls",
            steepest,
            "rad",
            modes + ", T_slope = -mu*N_slope",
        ),
        "state": Answer(
            "with the friction mu", "rolls" if rolls else "slips", "", how="mu against mu_needed"
        ),
    }
    down = rolling.simulate_past(
        "down", 1, initial=dict(REST), events=[fb.event("s*sin(beta) - H", name="down", terminal=True)]
    )
    bound = 1000 * case.tolerance
    contact = down.contacts["slope"]
    checks = (
        same("v_2 against the simulation", answers["v_2"].value, down["s'"][-1], bound),
        same("omega_2 against the simulation", answers["omega_2"].value, down["phi'"][-1], bound),
        same("N and friction against the simulation", [answers["N"].value, -answers["H_up"].value],
             [contact.normal[-1], contact.tangential[-1]], bound),
    )  # fmt: skip
    trajectory = case.motion()
    way = "rolls" if rolls else "slips"
    as_found = fact(f"it {way} in the simulation too", (trajectory.modes[0].mode == "stick") == rolls)
    plots: Plots = {
        "speed.png": saved(lambda: history(trajectory, ["s'", "phi'"], title="Disk rolling down a slope")),
        "margin.png": saved(lambda: trajectory.plot_margin()),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, (*checks, as_found))


ROLLING_DOWN = Entry(
    "ex-6-4",
    ("rolling-down",),
    "Disk rolling down a slope from rest (Example 6.4)",
    ("speed and angular velocity when the centre has dropped by H", "forces of the slope", "steepest slope"),
    build,
    solve,
    until=1.5,
    positive=("g",),
    modes={"slope": "stick"},
)
