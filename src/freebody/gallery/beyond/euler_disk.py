"""Euler's disk: a coin that rolls round, ever flatter and ever faster, until it can no longer roll.

theta is the angle of the disk from the horizontal, psi its rotation about the vertical, phi its spin. A damper at the
axle slows the contact point on its path round the rim: a horizontal couple of the power -c phi'². Rigid bodies would
reach an infinite psi' in a finite time. Before that, the required friction or normal force exceeds the limits of the
contact, and the run shows which of them.

Source: Moffatt, Nature 404 (2000) 833-834, for the steady turn and the energy argument.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import sympy

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, fact, same
from ..tools.case import Case, explain, happened, mass_properties
from ..tools.entry import Entry


def build() -> fb.System:
    """Return the coin with a damper at its axle."""
    s, turn = coin()
    s.damper("rim", turn, damping="c", coordinate=2)
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the disk",
        c="N m s/rad: damping of the foot's way round the rim",
        mu="1: friction of the floor",
        g="m/s²: gravity",
        theta_0="rad: angle of the disk from the level at the start",
        x="m: place of the centre along x",
        y="m: place of the centre along y",
        z="m: height of the centre",
        psi="rad: turn about the vertical",
        theta="rad: angle of the disk from the level",
        phi="rad: spin",
    )
    return s


def coin() -> tuple[fb.System, Any]:
    """Return the system and its gimbal: three massless sliders carry the centre, the gimbal carries the disk."""
    s = fb.System("euler_disk")
    m, R, mu, g, *_ = s.parameters(m=0.44, R=0.0375, mu=0.3, g=9.81, c=2e-7, theta_0=0.1)
    s.gravity = (0, 0, -g)
    nothing = fb.MassProperties(0, (0, 0, 0), ((0, 0, 0), (0, 0, 0), (0, 0, 0)))
    disk = s.body("disk", fb.disk(m, R))
    along, across, above = (s.body(name, nothing, shape="nothing") for name in ("along", "across", "above"))
    s.slider("way_x", s.ground, along, axis="x", coordinate="x")
    s.slider("way_y", along, across, axis="y", coordinate="y")
    s.slider("way_z", across, above, axis="z", coordinate="z")
    turn = s.gimbal("turn", above, disk, axis="ZXZ", coordinate="psi theta phi")
    s.contact("floor", disk.circle(R), s.ground.plane(normal="z"), friction=mu)
    return s, turn


def begin(case: Case, theta: float, turn: float) -> dict[str, float]:
    """Return the steady turn at an angle; it sinks as the damper takes energy: 3/2 m g R cos θ θ' = -c (ψ' cos θ)²."""
    R, sin, cos = case["R"], math.sin(theta), math.cos(theta)
    falls = -2 * case["c"] * turn**2 * cos / (3 * case["m"] * case["g"] * R)
    return {
        "theta": theta, "theta'": falls, "psi'": turn, "phi'": -turn * cos, "x": 0.0, "y": 0.0,
        "z": R * sin, "x'": 0.0, "y'": -R * falls * sin, "z'": R * falls * cos,
    }  # fmt: skip


def turn_of(case: Case) -> Any:
    """Return ψ' of the steady turn with the centre at rest, φ' = -ψ' cos θ, from the conditions of steady motion."""
    e = fb.equations(coin()[0], modes={"floor": "stick"})
    atoms = e.model.names.atoms
    theta, turn, spin = (atoms[name] for name in ("theta", "psi'", "phi'"))
    sine, square = sympy.Symbol("sine", positive=True), sympy.Symbol("square")  # 0 < theta < pi
    level = {spin: -turn * sympy.cos(theta), sympy.sin(theta): sine}
    conditions = [(c.lhs - c.rhs).xreplace(level) for c in fb.steady_motions(e).conditions]
    (normal,) = {a for c in conditions for a in c.free_symbols if a.name == "N_floor"}
    balances = [sympy.expand(c).subs(turn**2, square) for c in conditions if c.has(normal)]
    ((_, rate),) = sympy.linsolve(balances, (normal, square))
    return sympy.sqrt(
        sympy.simplify(rate.subs(sympy.cos(theta) ** 2, 1 - sine**2)).subs(sine, sympy.sin(theta))
    )


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.contact_plots import contact_forces
    from ...picture.plots.plots import energy_residual, saved

    case.refuse_unless("theta_0", 0 < case["theta_0"] < math.pi / 2, "an angle between 0 and 90 degrees")
    case.refuse_unless("c", case["c"] > 0, "a damping greater than 0")
    m, R, c, g, theta_0 = (case.atoms[name] for name in ("m", "R", "c", "g", "theta_0"))
    rate = turn_of(case).xreplace({case.atoms["theta"]: theta_0})
    inertia = mass_properties(case.system.bodies["disk"]).inertia[0][0]
    spent = m * g * R * sympy.sin(theta_0) + inertia * (rate * sympy.sin(theta_0)) ** 2 / 2
    how = "fb.steady_motions(fb.equations(s, modes={'floor': 'stick'})).conditions"
    # d(energy)/dtheta theta' = -c (psi' cos(theta))^2, the centre at rest
    angle = sympy.Symbol("angle", positive=True)
    power = c * (rate * sympy.cos(theta_0)) ** 2
    slowness = sympy.simplify((sympy.diff(spent, theta_0) / power).subs(theta_0, angle))
    lasts = sympy.integrate(slowness, (angle, 0, theta_0))
    answers: Answers = {
        "turn": Answer(
            "turn psi' about the vertical at the start", case.number(rate), "rad/s", rate, how
        ),
        "energy": case.formula("energy of the steady turn", sympy.simplify(spent), "J", how),
        "t_end": case.formula(
            "time in which the damper takes it, the centre at rest: psi' is infinite then", lasts, "s",
            "the energies, and the power of the damper",
        ),
    }  # fmt: skip
    start = begin(case, case["theta_0"], answers["turn"].value)
    fine = case.tolerance / 10
    end = answers["t_end"].value
    whole = case.simulate(end, initial=start, tolerance=fine)
    gone = happened(whole, "floor")
    until = float(gone[0].time) if gone else end
    last = gone[0].state if gone else whole.at(end)
    trajectory = case.motion(until=min(case.until, until), initial=start)
    answers |= {
        "limit": Answer(
            "what ends the rolling", str(gone[0]).split(": ", 1)[1] if gone else "nothing up to t_end", "",
            how="fb.simulate, the first event",
        ),
        "t_limit": Answer("time at which it ends", until, "s", how="fb.simulate, event located"),
        "theta_limit": Answer("angle then", float(last["theta"]), "rad", how="fb.simulate"),
        "turn_limit": Answer("turn psi' then", float(last["psi'"]), "rad/s", how="fb.simulate"),
    }  # fmt: skip
    known = {"theta": case["theta_0"], "phi'": start["phi'"], **{k: case[k] for k in ("m", "R", "mu", "g")}}
    steady = fb.steady_motions(fb.equations(coin()[0], modes={"floor": "stick"}), solve_for="psi'").at(known)
    nearest = min((one.values["psi'"] for one in steady), key=lambda w: abs(w - start["psi'"]))
    ledger = trajectory.energy
    rolls = trajectory.contacts["floor"].mode[trajectory.t < until] == "stick"
    quarter = trajectory.t <= end / 4
    sines = np.sin(trajectory["theta"][quarter])
    expected = np.sqrt(4 * case["g"] / (case["R"] * sines))
    checks = (
        same("steady turn against the root of the balances in numbers", start["psi'"] / nearest, 1, 1e-12),
        fact("it rolls until then", bool(np.all(rolls))),
        same("energy ledger with the work of the damper", ledger.relative_residual, 0, 1000 * case.tolerance),
        # the centre deviates from its place by a fraction of the order theta^2
        same("turn over that of the steady turn at the same angle, in the first quarter",
             trajectory["psi'"][quarter] / expected, np.ones(len(sines)), 2 * case["theta_0"] ** 2),
    )  # fmt: skip
    plots: Plots = {
        "turn.png": saved(lambda: turns(trajectory)),
        "forces.png": saved(lambda: contact_forces(trajectory)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


def turns(trajectory: fb.Trajectory) -> Any:
    """Draw the angle, which goes to zero, and the rate psi', which grows, over time."""
    from ...picture.plots.plots import figure

    upper, lower = figure(8, 5).subplots(2, 1, sharex=True)
    upper.plot(trajectory.t, trajectory["theta"], linewidth=1.4)
    upper.set_ylabel("theta [rad]")
    lower.plot(trajectory.t, trajectory["psi'"], linewidth=1.4)
    lower.set_ylabel("psi' [rad/s]")
    lower.set_xlabel("time [s]")
    upper.set_title("Euler's disk: flatter and faster")
    return upper


EULER_DISK = Entry(
    "euler-disk",
    (),
    "Euler's disk: it rolls ever flatter and faster, until friction no longer holds it",
    (
        "turn and energy of the steady motion",
        "time in which it would come to rest, turning infinitely fast",
        "what ends the rolling before, when, and at which angle",
    ),
    build,
    solve,
    until=5.7,
    start={"theta": "theta_0", "z": "R*sin(theta_0)"},
    bodies=("disk",),
    modes={"floor": "stick"},
)
