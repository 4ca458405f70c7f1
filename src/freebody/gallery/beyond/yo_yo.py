"""Yo-yo de-spin: two masses unwind their cords from a spinning satellite and stop its spin.

theta is the turn of the satellite, phi the angle from which the cords have come off. A free cord is the tangent of the
drum, of length R phi. The cords are inextensible and have no mass.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy

import freebody as fb

from ..tools.answer import Answers, Plots, Solved, same
from ..tools.case import Case, explain
from ..tools.entry import Entry
from ..tools.pictures import lines

FREE = 0.05
"""Initial angle of a simulation [rad]: with a cord of zero free length the masses could not move."""


def build() -> fb.System:
    """Return the system: a massless reel follows each cord's point of departure; the mass slides along the tangent."""
    s = fb.System("yo_yo")
    inertia, R, m = s.parameters(I=50.0, R=0.6, m=0.8)
    s.parameters(omega_0=12.0, l_1=5.0)
    s.assume(inertia > 0, R > 0, m > 0, s.expression("omega_0") > 0, s.expression("l_1") > 0)
    theta, phi = s.coordinates("theta phi")
    drum = s.body(
        "drum",
        fb.MassProperties(1, (0, 0, 0), ((inertia, 0, 0), (0, inertia, 0), (0, 0, inertia))),
        shape=fb.disk(1, R),
    )
    s.hinge("axis", s.ground, drum, axis="z", coordinate=theta)
    for side, sign in (("1", 1), ("2", -1)):
        reel = s.body(f"reel_{side}", fb.particle(0))
        mass = s.body(f"mass_{side}", fb.particle(m))
        s.hinge(f"reel_{side}", drum, reel, axis="z", coordinate=phi)
        s.slider(f"cord_{side}", reel, mass, at=(sign * R, 0, 0), axis=(0, -sign, 0), coordinate=R * phi)
    explain(
        s,
        I="kg m²: moment of inertia of the satellite without the masses",
        R="m: radius of the drum",
        m="kg: each of the two masses",
        omega_0="rad/s: spin before the release",
        l_1="m: length of free cord to answer for",
        theta="rad: turn of the satellite",
        phi="rad: angle from which the cords have come off",
    )
    return s


def unwinding(case: Case) -> tuple[Any, Any]:
    """Return theta', phi' at any phi after the release at phi = 0: energy and momentum are conserved."""
    spin = {"theta": 0, "theta'": "omega_0", "phi": 0, "phi'": 0}
    conditions = [
        sympy.factor(one.expression - case.put(one.expression, spin))
        for one in (case.equations.integrals[name] for name in ("energy", "momentum of theta"))
    ]
    rates = [case.atoms[name] for name in ("theta'", "phi'")]
    solution = [
        tuple(sympy.factor(x) for x in pair)
        for pair in sympy.solve(conditions, rates)
        if sympy.simplify(pair[1]) != 0
    ]
    # the other root rewinds the cords: phi' < 0
    (pair,) = [pair for pair in solution if case.number(pair[1], {"phi": 1}) > 0]
    return pair


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, saved

    for name in ("I", "R", "m", "omega_0"):
        case.refuse_unless(name, case[name] > 0, "values above 0")
    case.refuse_unless("l_1", case["l_1"] > FREE * case["R"], f"a cord longer than {FREE:g} R")
    atoms = case.atoms
    rate, unwound = unwinding(case)
    at_l = {"phi": "l_1 / R"}
    stop = [x for x in sympy.solve(rate, atoms["phi"]) if case.number(x) > 0]
    # the moment of a cord about the axis, transmitted by its reel
    state = {"theta'": rate, "phi'": unwound}
    state |= {f"{name}'": x.diff(atoms["phi"]) * unwound for name, x in tuple(state.items())}
    moment = case.equations.reactions["reel_1"].moment[2]
    pull = case.put(sympy.factor(case.put(moment, state)) / atoms["R"], at_l)
    how = "energy and momentum integrals from the release"
    answers: Answers = {
        "phi'": case.formula("rate at which the cords come off", unwound, "rad/s", how),
        "l": case.formula("free length of cord at which the spin is gone", stop[0] * atoms["R"], "m", how),
        "t(l_1)": case.formula(
            "time from the release until the free length is l_1",
            case.put(atoms["phi"] / unwound, at_l),
            "s",
            how,
        ),
        "omega(l_1)": case.formula("spin of the satellite then", case.put(rate, at_l), "rad/s", how),
        "F(l_1)": case.formula(
            "tension of each cord then",
            pull,
            "N",
            'fb.equations(s).reactions["reel_1"]: moment of the cord over R',
        ),
    }
    start = {"phi": FREE} | {
        name: case.number(x, {"phi": FREE}) for name, x in (("theta'", rate), ("phi'", unwound))
    }
    free = [fb.event("R*phi - l_1", name="l_1", terminal=True)]
    run = case.simulate(2 * answers["t(l_1)"].value, initial=start, events=free)
    bound = 1000 * case.tolerance
    checks = (
        same("spin at l_1 against the simulation", run["theta'"][-1], answers["omega(l_1)"].value, bound),
        same(
            "time to l_1 against the simulation",
            run.t[-1] + FREE / answers["phi'"].value,
            answers["t(l_1)"].value,
            bound,
        ),
        same(
            "tension at l_1 against the simulation",
            np.linalg.norm(run.reactions["cord_1"].force[-1]),
            answers["F(l_1)"].value,
            bound,
        ),
    )
    trajectory = case.motion(initial=start, events=[fb.event("R*phi - l_1", name="l_1")])
    plots: Plots = {
        "spin.png": saved(lambda: history(trajectory, "theta'", title="Yo-yo: spin of the satellite")),
        "tension.png": saved(
            lambda: lines(
                trajectory.t,
                {"tension [N]": {"cord 1": np.linalg.norm(trajectory.reactions["cord_1"].force, axis=1)}},
                "Yo-yo: tension of a cord",
            )
        ),
        "path.png": saved(lambda: paths(trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def paths(trajectory: fb.Trajectory) -> Any:
    """Draw the paths of the masses along the axis, with the drum."""
    from ...picture.plots.plots import COLORS, figure

    ax = figure(7, 7).subplots()
    around = np.linspace(0, 2 * np.pi, 200)
    R = trajectory.values["R"]
    ax.plot(R * np.cos(around), R * np.sin(around), color="0.4", linewidth=1.5, label="drum")
    for name, color in zip(("mass_1", "mass_2"), COLORS, strict=False):
        x, y, _ = trajectory.poses[name].position.T
        ax.plot(x, y, color=color, linewidth=1.4, label=name)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("X [m]")
    ax.set_ylabel("Y [m]")
    ax.grid(alpha=0.3)
    ax.legend(frameon=False)
    ax.set_title("Yo-yo: paths of the masses", loc="left", fontweight="bold")
    return ax


YO_YO = Entry(
    "yo-yo",
    ("yo-yo-despin",),
    "Yo-yo de-spin of a satellite (beyond the chapter)",
    (
        "rate at which the cords come off, and the length at which the spin is gone",
        "time, spin and tension at the free length l_1",
    ),
    build,
    solve,
    until=1.0,
    bodies=("drum", "mass_1"),
)
