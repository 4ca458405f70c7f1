"""Block that rocks on a rough floor (Housner's block), less with each impact until it stands.

It is let go leaning on its left corner. When its base comes down, the right corner hits, the left one lifts off, and
it goes on about the right corner: the angular momentum about that corner is kept, part of the speed is lost.
theta is the turn of the block, counter-clockwise.
"""

from __future__ import annotations

import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain, happened
from ..tools.entry import Entry

LEFT = {"x": 0, "y": 0, "x'": 0, "y'": 0}
RELEASE = {**LEFT, "theta": "-theta_0", "theta'": 0}
FLAT = {**LEFT, "theta": 0}
ROUGH = 10
"""Friction of a floor on which it does not slip."""


def build() -> fb.System:
    """Return the system; x, y belong to the right corner, on which the block leans if theta is negative."""
    s = fb.System("rocking_block")
    m, b, h, g = s.parameters(m=3.0, b=0.3, h=1.0, g=9.81)
    s.parameters(theta_0=0.1)
    s.gravity = (0, -g, 0)
    block = s.body("block", fb.box(m, (b, h, b)))
    s.planar("plane", s.ground, block, to=(b / 2, -h / 2, 0), coordinate="x y theta")
    corners = block.corners((-b / 2, -h / 2, 0), (b / 2, -h / 2, 0))
    s.contact("foot", corners, s.ground.plane(), friction=ROUGH)
    explain(
        s,
        m="kg: mass of the block",
        b="m: width of the block",
        h="m: height of the block",
        g="m/s²: gravity",
        theta_0="rad: angle at which it is let go, leaning on its right corner",
        x="m: displacement of the right corner to the right",
        y="m: its height",
        theta="rad: turn of the block, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.contact_plots import contact_forces
    from ...picture.plots.plots import energy, history, saved

    e, atoms = case.equations, case.atoms
    b, h, m, rate = (atoms[name] for name in ("b", "h", "m", "theta'"))
    steepest = sympy.atan(b / h)
    case.refuse_unless(
        "theta_0", 0 < case["theta_0"] < case.number(steepest),
        f"an angle from which it falls back, less than {case.number(steepest):.6g} rad",
    )  # fmt: skip
    case.refuse_unless(
        "b", case["b"] ** 2 < 2 * case["h"] ** 2, "a block that rocks, of a width less than sqrt(2) h"
    )
    solution = e.solve("theta''", where=RELEASE)["theta''"]
    square = case.square_of_speed("theta'", RELEASE, FLAT)
    first = sympy.sqrt(square)
    # the base comes down turning about the right corner; the angular momentum about the left corner is conserved
    block = case.system.bodies["block"]
    about = e.momentum.angular(block.point(-b / 2, -h / 2, 0))[2]
    before = case.put(about, {**FLAT, "theta'": rate})
    # then it turns about the left corner: the right corner, with x and y, goes up
    after = case.put(about, {"x": 0, "y": 0, "theta": 0, "x'": 0, "y'": b * rate, "theta'": rate})
    ratio = sympy.cancel(before / after)
    lost = case.put(e.energy.kinetic, {**FLAT, "theta'": first}) * (1 - ratio**2)
    how = 'fb.equations(s, modes={"foot_2": "stick"})'
    start = {"theta": "-theta_0"}
    fine = case.tolerance / 100
    motion = case.simulate_past("rest", 1, initial=start, tolerance=fine)
    impacts, rest = happened(motion, "impact"), happened(motion, "rest")[0]
    begun = impacts[0]
    turning = case.simulate_past(
        "turn", 1, initial=start, tolerance=fine, events=[fb.event("theta'", name="turn", terminal=True)]
    )
    answers: Answers = {
        "theta_fall": case.formula("angle beyond which it falls over", steepest, "rad", "mass centre over the corner"),
        "alpha": case.formula("angular acceleration just after the release", solution, "rad/s²", how + ".solve"),
        "omega_1": case.formula("angular velocity just before the first impact", first, "rad/s", "energy integral"),
        "ratio": case.formula(
            "angular velocity after an impact over that before", ratio, "1", "momentum about the corner that hits"
        ),
        "lost": case.formula("energy that the first impact takes", lost, "J", "kinetic energy before and after"),
        "t_1": Answer("time of the first impact", float(begun.time), "s", how="fb.simulate, event located"),
        "theta_1": Answer("angle that it reaches on the other side", float(turning["theta"][-1]), "rad",
                          how="fb.simulate, event located"),
        "t_rest": Answer("time after which it stands", float(rest.time), "s", how="fb.simulate, limit of the impacts"),
    }  # fmt: skip
    bound = 1000 * case.tolerance
    parts = [event.after["theta'"] / event.state["theta'"] for event in impacts[:8]]
    checks = (
        same("omega_1 against the simulation", answers["omega_1"].value, begun.state["theta'"], bound),
        same(
            "ratio against the first impacts of the simulation",
            parts,
            [answers["ratio"].value] * len(parts),
            1e-9,
        ),
        same("lost against the energy ledger", answers["lost"].value, -work_of_impacts(turning), bound),
        same("energy ledger until it stands", motion.energy.relative_residual, 0, bound),
    )
    trajectory = case.motion(initial=start)
    plots: Plots = {
        "angle.png": saved(lambda: history(trajectory, "theta", title="Rocking block", events=False)),
        "forces.png": saved(lambda: contact_forces(trajectory)),
        "energy.png": saved(lambda: energy(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def work_of_impacts(motion: fb.Trajectory) -> float:
    """Return the work of the impulses up to the end of a motion [J]."""
    impulses = motion.energy.impulses
    return 0.0 if impulses is None else float(impulses[-1])


ROCKING_BLOCK = Entry(
    "rocking-block",
    (),
    "Block rocking on a floor until it stands (Housner)",
    (
        "angle beyond which it falls; acceleration at the release",
        "first impact: time, velocity before and after, energy lost",
        "angle on the other side; when it stands",
    ),
    build,
    solve,
    until=5.0,
    positive=("g",),
    start={"theta": "-theta_0"},
    modes={"foot_2": "stick"},
    fixed_values={**LEFT, "x''": 0, "y''": 0},
)
