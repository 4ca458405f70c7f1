"""Disk that rolls inside a rough cylinder (chapter, Problem 6.10).

theta is the angle of the line from the cylinder's axis to the centre C, from the downward vertical, counter-clockwise.
theta and rho, the distance of C from the axis beyond R - r, give the position of C on a massless arm and slider, so
that the equations are those of the chapter; the reactions of arm and slider are zero.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import sympy

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Printed, Solved, fact, same
from ...tools.case import Case, angle_where, explain, happened
from ...tools.entry import Entry

ROLLING = {"rho": 0, "rho'": 0, "rho''": 0}
RELEASE = {"rho": 0, "rho'": 0, "theta": "theta_0", "theta'": 0, "phi'": 0, "phi": 0}


def build() -> fb.System:
    """Return the system; phi is the rotation of the disk relative to the line of centres."""
    s = fb.System("disk_in_cylinder")
    m, R, r, mu, g = s.parameters(m=1.5, R=1.0, r=0.2, mu=0.5, g=9.81)
    s.parameters(theta_0="50deg", theta_1="20deg")
    s.gravity = (0, -g, 0)
    nothing = fb.MassProperties(0, (0, 0, 0), ((0, 0, 0), (0, 0, 0), (0, 0, 0)))
    arm, hub = (s.body(name, nothing, shape="nothing") for name in ("arm", "hub"))
    disk = s.body("disk", fb.disk(m, r))
    s.hinge("axis", s.ground, arm, coordinate="theta")
    s.slider("radius", arm, hub, at=(0, r - R, 0), axis=(0, -1, 0), coordinate="rho")
    s.hinge("pin", hub, disk, coordinate="phi")
    s.contact("wall", disk.circle(r), s.ground.circle(R, inside=True), friction=mu)
    s.assume(r > 0, g > 0, R - r > 0, R - r + s.expression("rho") > 0)
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the cylinder",
        r="m: radius of the disk",
        mu="1: friction between disk and cylinder",
        g="m/s²: gravity",
        theta_0="rad: angle of the release",
        theta_1="rad: angle to answer for, on the way down",
        theta="rad: angle of the line of centres from the downward vertical",
        rho="m: distance of the centre from the axis, beyond R - r",
        phi="rad: turn of the disk against the line of centres",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.contact_plots import contact_forces
    from ....picture.plots.plots import energy_residual, history, saved

    case.refuse_unless("r", 0 < case["r"] < case["R"], "a disk smaller than the cylinder")
    case.refuse_unless(
        "theta_0", 0 < case["theta_0"] < sympy.pi / 2, "an angle of release between 0 and 90 degrees"
    )
    case.refuse_unless(
        "theta_1", abs(case["theta_1"]) < case["theta_0"], "an angle that is passed on the way down"
    )
    e = case.equations
    theta = case.atoms["theta"]
    solution = e.solve(["theta''", "phi''", "N_wall", "T_wall"], where=ROLLING)
    spin = sympy.cancel(solution["phi''"] / solution["theta''"])  # rolling: phi' = spin theta'
    by_forces, by_moments = derivations(case, spin)
    # the required friction is largest at the release: T/N = sin/(3 cos + 4 (cos - cos theta_0)) grows with the angle
    released = {**RELEASE, "theta": theta}
    steepest = angle_where(
        case.put(solution["T_wall"] - case.atoms["mu"] * solution["N_wall"], released), theta
    )
    needed = case.put(solution["T_wall"] / solution["N_wall"], RELEASE)
    # the questions are about rolling: their simulations have slightly more friction than it requires
    rolling = case.having(mu=max(case["mu"], 1.01 * case.number(needed)))
    rolls = case["mu"] >= case.number(needed)
    rate = -sympy.sqrt(speed_squared(case, spin))
    now = {"theta": "theta_1", "theta'": rate, **ROLLING}
    how = 'fb.equations(s, modes={"wall": "stick"})'
    equation = case.formula(
        "equation of motion in theta", by_forces, "", how + ".eliminate()", at={**now, "theta''": 0}
    )
    printed = Printed(f"{equation.text} = 0", f"{equation.latex} = 0")
    agree = e.ring.from_sympy(sympy.expand(by_forces - by_moments)) == 0
    stiffness = -sympy.diff(solution["theta''"], theta)
    answers: Answers = {
        "equation": replace(
            equation, value=printed.text, formula=sympy.Eq(equation.formula, 0), printed=printed
        ),
        "ways": Answer(
            "the two ways to it, compared",
            "with C, two equations of forces give N and f, which the moments about C then contain; about the contact "
            "N and f have no moment, and one equation of moments is enough. Both give "
            + ("the same equation" if agree else "different equations"),
            "",
            how=how + ".eliminate(), and moments about the contact",
        ),
        "omega_n": case.formula(
            "frequency of small oscillation", sympy.sqrt(case.put(stiffness, {"theta": 0})), "rad/s",
            "equation of motion, linear about theta = 0",
        ),
        "theta'": case.formula("theta' when theta_1 is first reached", rate, "rad/s", "energy integral, rolling"),
        "theta''": case.formula("theta'' then", case.put(solution["theta''"], now), "rad/s²", how + ".solve"),
        "N": case.formula("normal force then", case.put(solution["N_wall"], now), "N", how + ".solve"),
        "f": case.formula(
            "size of the friction force then",
            case.put(solution["T_wall"], now) * (1 if case.number(solution["T_wall"], now) >= 0 else -1), "N",
            how + ".solve",
        ),
    }  # fmt: skip
    begin = {"theta": "theta_0"}
    fine = case.tolerance / 100
    swing = rolling.simulate_past(
        "turning", 2, initial=begin, tolerance=fine, events=[fb.event("theta'", name="turning")]
    )
    period = happened(swing, "turning")[1].time
    answers["period"] = Answer(
        "exact period of the oscillation of amplitude theta_0", period, "s", how="fb.simulate, event located"
    )
    answers["mu_needed"] = case.formula(
        "friction that this takes", needed, "1", how + ".solve, T_wall/N_wall"
    )
    answers["theta_max"] = case.formula(
        "with the friction mu: largest angle of release from which it rolls", steepest, "rad",
        how + '.solve, "T_wall = mu*N_wall"',
    )  # fmt: skip
    answers["state"] = Answer(
        "with the friction mu, let go at theta_0", "rolls all the time" if rolls else "slips at the release", "",
        how="mu against mu_needed",
    )  # fmt: skip
    passing = rolling.simulate_past(
        "at theta_1", 1, initial=begin, events=[fb.event("theta - theta_1", name="at theta_1", terminal=True)]
    )
    bound = 1000 * case.tolerance
    linear = fb.linearize(e.model, about={"theta": 0, "rho": 0, "phi": 0}, values=case.values)
    contact = passing.contacts["wall"]
    checks = (
        fact("forces with moments about C, and moments about the contact, give the same equation of motion",
             agree),
        same("theta' against the simulation", answers["theta'"].value, passing["theta'"][-1], bound),
        same("N and f against the simulation", [answers["N"].value, answers["f"].value],
             [contact.normal[-1], abs(contact.tangential[-1])], bound),
        same("omega_n against fb.linearize", answers["omega_n"].value, max(linear.natural_frequencies()), 1e-12),
        same("the arm without mass does not pull: force at its pin over the weight",
             abs(swing.reactions["pin"].force).max() / (case["m"] * case["g"]), 0, bound),
        fact("it rolls all the time in the simulation", all(change.mode == "stick" for change in swing.modes)),
    )  # fmt: skip
    trajectory = case.motion(initial=begin)
    way = "rolls" if rolls else "slips"
    as_found = fact(f"it {way} in the simulation too", (trajectory.modes[0].mode == "stick") == rolls)
    plots: Plots = {
        "theta.png": saved(
            lambda: history(trajectory, ["theta", "theta'"], title="Disk in a rough cylinder")
        ),
        "forces.png": saved(lambda: contact_forces(trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, (*checks, as_found))


def derivations(case: Case, spin: Any) -> tuple[Any, Any]:
    """Return the left side of theta'' + ... = 0 from forces and moments about C, and from moments about the contact.

    In both the disk rolls: rho = 0, phi'' = spin theta''.
    """
    e, atoms = case.equations, case.atoms
    rolls = {**ROLLING, "phi''": spin * atoms["theta''"], "phi'": spin * atoms["theta'"]}
    hub = next(body for name, body in case.system.bodies.items() if name == "hub")

    def monic(left: Any) -> Any:
        left = sympy.expand(case.put(left, rolls))
        return sympy.expand(sympy.cancel(left / left.coeff(atoms["theta''"], 1)))

    (eliminated,) = e.eliminate().equations
    pins = {atom: 0 for atom in (sympy.Symbol("pin_x", real=True), sympy.Symbol("pin_y", real=True))}
    moment = e.free_body("disk").moment_form(hub.point(0, -atoms["r"], 0)).equations[2]
    return monic(eliminated.lhs - eliminated.rhs), monic((moment.lhs - moment.rhs).subs(pins))


def speed_squared(case: Case, spin: Any) -> Any:
    """Return theta'^2 at theta_1 after rolling from rest at theta_0."""
    u = sympy.Dummy("u", real=True)
    energy = case.equations.integrals["energy"].expression
    end = case.put(energy, {**RELEASE, "theta": "theta_1", "theta'": u, "phi'": spin * u})
    balance = sympy.expand(end - case.put(energy, RELEASE))
    return sympy.factor(sympy.cancel(-balance.coeff(u, 0) / balance.coeff(u, 2)))


DISK_IN_CYLINDER = Entry(
    "prob-6-10",
    ("disk-in-cylinder",),
    "Disk rolling inside a rough cylinder (Problem 6.10)",
    (
        "equation of motion in theta, frequency of small oscillation",
        "theta', theta'', normal force and friction at theta_1",
        "exact period of the oscillation of amplitude theta_0",
    ),
    build,
    solve,
    until=4.0,
    start={"theta": "theta_0"},
    bodies=("disk",),
    modes={"wall": "stick"},
    fixed_values={**ROLLING, "pin_x": 0, "pin_y": 0},
)
