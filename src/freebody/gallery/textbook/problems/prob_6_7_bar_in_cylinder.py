"""Bar whose ends slide on the inside of a smooth cylinder (chapter, Problem 6.7).

theta is the angle of the line from the cylinder's axis to the bar's centre, from the downward vertical,
counter-clockwise; A is the end on the radius at theta - 45 degrees, B that at theta + 45 degrees.
"""

from __future__ import annotations

from dataclasses import replace

import sympy

import freebody as fb

from ...tools.answer import Answers, Check, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry

CENTRED = {"x": 0, "y": 0, "x'": 0, "y'": 0}
RELEASE = {**CENTRED, "theta": "theta_0", "theta'": 0}


def build() -> fb.System:
    """Return the system; x, y belong to the point of the bar's plane that stays on the axis of the cylinder."""
    s = fb.System("bar_in_cylinder")
    m, R, g = s.parameters(m=2.0, R=1.0, g=9.81)
    s.parameters(theta_0="60deg", theta_1="20deg")
    s.assume(R > 0, g > 0)
    s.gravity = (0, -g, 0)
    h = R / sympy.sqrt(2)
    bar = s.body("bar", fb.slender_bar(m, sympy.sqrt(2) * R).moved((0, -h, 0)))
    s.planar("plane", s.ground, bar, coordinate="x y theta")
    side = bar.segment((-h, -h, 0), (h, -h, 0), normal="-y")
    s.contact("wall", side, s.ground.circle(R, inside=True))
    explain(
        s,
        m="kg: mass of the bar",
        R="m: radius of the cylinder",
        g="m/s²: gravity",
        theta_0="rad: angle of the release",
        theta_1="rad: angle to answer for, on the way down",
        x="m: distance of the bar's middle normal from the axis, to the right",
        y="m: distance of the point of the bar that is on the axis, up",
        theta="rad: angle of the bar's centre from the downward vertical",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.contact_plots import contact_forces
    from ....picture.plots.plots import energy_residual, history, saved

    case.refuse_unless(
        "theta_0", 0 < case["theta_0"] < sympy.pi, "a release from above the lowest point, to the right"
    )
    case.refuse_unless(
        "theta_1", abs(case["theta_1"]) < case["theta_0"], "an angle that is passed on the way down"
    )
    e, theta = case.equations, case.atoms["theta"]
    solution = e.solve(["theta''", "N_wall_1", "N_wall_2"], where=CENTRED)
    sides = {"A": solution["N_wall_1"], "B": solution["N_wall_2"]}
    for name, N in sides.items():
        if case.number(N, RELEASE) < 0:
            raise fb.errors.ModelError(
                f"Expected an angle of release at which both ends touch the cylinder, got "
                f"theta_0 = {case['theta_0']:g}: end {name} would have to be pulled outwards."
            )
    at = {**CENTRED, "theta": "theta_1"}
    rate = -sympy.sqrt(case.square_of_speed("theta'", RELEASE, at))
    now = {**at, "theta'": rate}
    how = 'fb.equations(s, modes={"wall": "slip"}).solve'
    alpha = case.formula("equation of motion", solution["theta''"], "", how, at=now)
    stiffness = -sympy.diff(solution["theta''"], theta)
    answers: Answers = {"equation": replace(alpha, value=f"theta'' = {alpha.text}")}
    for name, N in sides.items():
        answers[f"N_{name}(theta)"] = case.formula(
            f"normal force at {name} as a function of theta, theta' (value: at theta_1)", N, "N", how, at=now
        )
    answers["theta'"] = case.formula("theta' when theta_1 is first reached", rate, "rad/s", "energy integral")
    answers["theta''"] = case.formula("theta'' then", case.put(solution["theta''"], now), "rad/s²", how)
    for name, N in sides.items():
        answers[f"N_{name}"] = case.formula(f"normal force at {name} then", case.put(N, now), "N", how)
    answers["omega_n"] = case.formula(
        "frequency of small oscillation", sympy.sqrt(case.put(stiffness, {"theta": 0})), "rad/s",
        "equation of motion, linear about theta = 0",
    )  # fmt: skip
    start = {"theta": "theta_0"}
    passing = case.simulate_past(
        "at theta_1", 1, initial=start, events=[fb.event("theta - theta_1", name="at theta_1", terminal=True)]
    )
    bound = 1000 * case.tolerance
    linear = fb.linearize(e.model, about={"x": 0, "y": 0, "theta": 0}, values=case.values)
    trajectory = case.motion(initial=start)
    checks: list[Check] = [
        same("theta' against the simulation", answers["theta'"].value, passing["theta'"][-1], bound),
        same("N_A, N_B against the simulation", [answers["N_A"].value, answers["N_B"].value],
             [passing.contacts[f"wall_{k}"].normal[-1] for k in (1, 2)], bound),
        same("omega_n against fb.linearize", answers["omega_n"].value, max(linear.natural_frequencies()), 1e-12),
    ]  # fmt: skip
    plots: Plots = {
        "theta.png": saved(
            lambda: history(trajectory, ["theta", "theta'"], title="Bar in a smooth cylinder")
        ),
        "forces.png": saved(lambda: contact_forces(trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks))


BAR_IN_CYLINDER = Entry(
    "prob-6-7",
    ("bar-in-cylinder",),
    "Bar sliding inside a smooth cylinder (Problem 6.7)",
    (
        "equation of motion",
        "normal forces N_A, N_B as functions of theta, theta'",
        "theta', theta'', N_A, N_B at theta_1",
        "frequency of small oscillation",
    ),
    build,
    solve,
    until=5.0,
    start={"theta": "theta_0"},
    modes={"wall": "slip"},
    fixed_values={**CENTRED, "x''": 0, "y''": 0},
)
