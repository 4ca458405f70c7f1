"""A reaction wheel turns a satellite from rest to rest.

theta is the turn of the satellite about the axis of the wheel, phi that of the wheel in the satellite. The motor's
torque on the satellite is T sin(2 pi t / tau): it turns for half the time and brakes for the other half.
"""

from __future__ import annotations

import sympy

import freebody as fb

from ..tools.answer import Answers, Plots, Solved, same
from ..tools.case import Case, explain
from ..tools.entry import Entry
from ..tools.pictures import lines


def build() -> fb.System:
    """Return the system in a frame that moves with the mass centre; nothing turns about the other axes."""
    s = fb.System("reaction_wheel")
    I_B, I_W, T, tau = s.parameters(I_B=80.0, I_W=0.05, T=0.2, tau=60.0)
    s.assume(I_B > 0, I_W > 0, tau > 0)
    hull, rotor = (((one, 0, 0), (0, one, 0), (0, 0, one)) for one in (I_B, I_W))
    satellite = s.body("satellite", fb.MassProperties(1, (0, 0, 0), hull), shape=fb.box(1, (1, 1, 1)))
    wheel = s.body("wheel", fb.MassProperties(1, (0, 0, 0), rotor), shape=fb.disk(1, 0.3))
    s.hinge("attitude", s.ground, satellite, axis="z", coordinate="theta")
    axle = s.hinge("axle", satellite, wheel, axis="z", coordinate="phi")
    s.torque("motor", axle, -T * sympy.sin(2 * sympy.pi * s.t / tau))
    explain(
        s,
        I_B="kg m²: moment of inertia of the satellite without the wheel",
        I_W="kg m²: moment of inertia of the wheel",
        T="N m: greatest torque of the motor",
        tau="s: time of the manoeuvre",
        theta="rad: turn of the satellite",
        phi="rad: turn of the wheel in the satellite",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, saved

    for name in ("I_B", "I_W", "tau"):
        case.refuse_unless(name, case[name] > 0, "moments of inertia and a time above 0")
    t, tau = case.system.t, case.atoms["tau"]
    solution = case.equations.solve(["theta''", "phi''"])
    u, v = sympy.symbols("u v", positive=True)
    rate = {name: sympy.integrate(solution[f"{name}''"].subs(t, u), (u, 0, v)) for name in ("theta", "phi")}
    turned = sympy.integrate(rate["theta"], (v, 0, tau))
    half = {name: rate[name].subs(v, tau / 2) for name in rate}
    how = "fb.equations(s).solve([\"theta''\", \"phi''\"]), integrated"
    answers: Answers = {
        "alpha": case.formula("angle that the satellite has turned at tau", turned, "rad", how),
        "theta'_max": case.formula("greatest rate of the satellite, at tau/2", half["theta"], "rad/s", how),
        "phi'_max": case.formula(
            "rate of the wheel in the satellite then, against the satellite -", half["phi"], "rad/s", how
        ),
        "W": case.formula(
            "work of the motor up to tau/2, given back in the second half",
            case.put(case.equations.energy.kinetic, {f"{name}'": half[name] for name in half}),
            "J",
            "kinetic energy at these rates",
        ),
    }
    run = case.simulate(case["tau"], times=[case["tau"] / 2, case["tau"]])
    bound = 1000 * case.tolerance
    checks = (
        same("alpha against the simulation", run["theta"][1], answers["alpha"].value, bound),
        same("rate of the wheel against the simulation", run["phi'"][0], answers["phi'_max"].value, bound),
        same("work against that of the simulation", run.energy.work[0], answers["W"].value, bound),
        same("at rest at tau", [run["theta'"][1], run["phi'"][1]], 0, bound * abs(answers["phi'_max"].value)),
    )
    trajectory = case.motion()
    plots: Plots = {
        "theta.png": saved(
            lambda: history(trajectory, "theta", title="Satellite turned by a reaction wheel")
        ),
        "rates.png": saved(
            lambda: lines(
                trajectory.t,
                {
                    "satellite [rad/s]": {"theta'": trajectory["theta'"]},
                    "wheel [rad/s]": {"phi'": trajectory["phi'"]},
                },
                "Rates of satellite and wheel",
            )
        ),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


REACTION_WHEEL = Entry(
    "reaction-wheel",
    (),
    "Reaction wheel turns a satellite from rest to rest (beyond the chapter)",
    (
        "angle that the satellite turns",
        "greatest rates of satellite and wheel",
        "work of the motor up to half the time",
    ),
    build,
    solve,
    until=60.0,
)
