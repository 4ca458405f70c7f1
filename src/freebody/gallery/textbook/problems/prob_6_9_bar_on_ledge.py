"""Bar on a ledge whose string is cut (chapter, Problem 6.9).

The corner O is the origin, the bar lies along x; phi is its rotation, counter-clockwise, so that it falls by
theta = -phi below the horizontal on the right. The friction of the corner holds it until it begins to slip.
"""

from __future__ import annotations

import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved, same
from ...tools.case import Case, angle_where, explain
from ...tools.entry import Entry

CENTRED = {"x": 0, "y": 0, "x'": 0, "y'": 0}
LEVEL = {**CENTRED, "phi": 0, "phi'": 0}


def build() -> fb.System:
    """Return the system; x, y belong to the point of the bar that is initially at O."""
    s = fb.System("bar_on_ledge")
    m, L, b, mu, g = s.parameters(m=2.0, L=1.2, b=0.3, mu=0.4, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L))
    s.planar("plane", s.ground, bar, to=(b - L / 2, 0, 0), coordinate="x y phi")
    s.scenery = fb.box(1, (3 * L / 5, L / 3, 1)).moved(
        (-3 * L / 10, -L / 6, 0)
    )  # the ledge, whose corner is O
    side = bar.segment((-L / 2, 0, 0), (L / 2, 0, 0), normal="-y")
    s.contact("O", side, s.ground.point(0, 0, 0), friction=mu)
    explain(
        s,
        m="kg: mass of the bar",
        L="m: length of the bar",
        b="m: length of the part on the ledge",
        mu="1: friction between corner and bar",
        g="m/s²: gravity",
        x="m: displacement of the point of the bar that was at O, to the right",
        y="m: the same, up",
        phi="rad: turn of the bar, counter-clockwise",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.contact_plots import contact_forces
    from ....picture.plots.plots import energy_residual, history, saved

    case.refuse_unless(
        "b", 0 <= case["b"] < case["L"] / 2, "a part on the ledge of less than half the length"
    )
    case.refuse_unless("mu", case["mu"] > 0, "friction greater than 0")
    e, rate = case.equations, case.atoms["phi'"]
    solution = e.solve(["phi''", "N_O", "T_O"], where=CENTRED)
    square = case.square_of_speed("phi'", LEVEL, CENTRED)
    balance = sympy.expand(solution["T_O"] + case.atoms["mu"] * solution["N_O"]).subs(rate**2, square)
    # it falls clockwise, and T is positive down along the bar: the corner holds it with T = -mu N
    falls = -angle_where(balance, case.atoms["phi"])
    at = {**CENTRED, "phi": -falls}
    N, T = (solution[name].subs(rate**2, square) for name in ("N_O", "T_O"))
    how = 'fb.equations(s, modes={"O": "stick"}).solve, T_O = -mu*N_O with the energy integral'
    scope = "(the formula: at any phi)"
    answers: Answers = {
        "theta": case.formula("angle below the horizontal at which slip begins", falls, "rad", how),
        "omega": case.formula(
            f"angular velocity then, clockwise + {scope}",
            sympy.sqrt(square),
            "rad/s",
            "energy integral",
            at=at,
        ),
        "N": case.formula(f"normal force then {scope}", N, "N", how, at=at),
        "T": case.formula(f"friction force on the bar then, up along it + {scope}", -T, "N", how, at=at),
        "theta_b0": case.formula(
            "angle for b = 0, the bar supported at its end", case.put(falls, {"b": 0}), "rad", how
        ),
    }
    motion, event = case.simulate_to_mode("O", "slip")
    force = motion.contacts["O"]
    before = (motion.t < event.time) & (motion.t > 0)
    bound = 1000 * case.tolerance
    where = "fb.simulate, event located"
    _, gone = case.simulate_to_mode("O", "open")
    answers["theta_leave"] = Answer(
        "angle below the horizontal at which it leaves the corner",
        -float(gone.state["phi"]),
        "rad",
        how=where,
    )
    answers["omega_leave"] = Answer(
        "angular velocity with which it falls then, clockwise +",
        -float(gone.state["phi'"]),
        "rad/s",
        how=where,
    )
    checks = (
        same("theta and omega against the event of the simulation",
             [answers["theta"].value, answers["omega"].value], [-event.state["phi"], -event.state["phi'"]], bound),
        same("friction law held until then: largest |T| - mu N over the weight",
             max(0.0, -float(force.margin[before].min(initial=0.0))) / (case["m"] * case["g"]), 0, bound),
    )  # fmt: skip
    trajectory = case.motion()
    plots: Plots = {
        "angle.png": saved(lambda: history(trajectory, ["phi", "x"], title="Bar on a ledge")),
        "forces.png": saved(lambda: contact_forces(trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


BAR_ON_LEDGE = Entry(
    "prob-6-9",
    ("bar-on-ledge",),
    "Bar on the corner of a ledge, its string cut (Problem 6.9)",
    (
        "angle at which it begins to slip; angular velocity, normal force and friction then",
        "the angle for b = 0",
        "angle and angular velocity with which it leaves the corner",
    ),
    build,
    solve,
    until=0.6,
    positive=("g",),
    drawn={"phi": "-15deg"},
    modes={"O": "stick"},
    fixed_values={**CENTRED, "x''": 0, "y''": 0},
)
