"""Cylinder fixed to an accelerating shaft (chapter, Problem 6.13), in both readings of the missing figure.

(a) Its centre is on the shaft and its axis (0, sin(beta), cos(beta)) in the body axes. (b) Its axis is parallel
to the shaft, at the distance e along x. One model has both, the tilt beta and the distance e: reading (a) is e
= 0, (b) is beta = 0. A constraint prescribes the motion theta = alpha0 t²/2; its reaction is the torque that must be
applied.
"""

from __future__ import annotations

import freebody as fb

from ...tools.answer import Answers, Solved
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import with_shaft
from ...tools.shaft import against_simulation, on_shaft, plots, reactions, reactions_in_any_motion

STATE = {"theta": "alpha0*t_1^2/2", "theta'": "alpha0*t_1", "theta''": "alpha0"}
READINGS = {"a": {"e": 0}, "b": {"beta": 0}}
WORDS = {"a": "(a) tilted, centred", "b": "(b) parallel, off centre"}


def build() -> fb.System:
    """Return the cylinder, rotated by -beta about x and displaced by e along x, on a driven hinge along Z."""
    s = fb.System("cylinder_on_shaft")
    m, R, length, L, *_ = s.parameters(m=8.0, R=0.08, l=0.3, L=0.7, g=9.81)
    beta, e, alpha0, _ = s.parameters(beta="10deg", e=0.02, alpha0=20.0, t_1=2.0)
    turned = fb.cylinder(m, R, length).rotated(fb.Rotation.axis_angle("x", -beta))
    solid = turned.moved((e, 0, 0))
    on_shaft(s, s.body("cylinder", solid, shape=with_shaft(solid, L)))
    s.constrain(s.expression("theta - alpha0*t^2/2"), name="drive")
    explain(
        s,
        m="kg: mass of the cylinder",
        R="m: radius of the cylinder",
        l="m: length of the cylinder",
        beta="rad: angle of the cylinder's axis from the shaft, reading (a)",
        e="m: distance of the cylinder's axis from the shaft, reading (b)",
        alpha0="rad/s²: angular acceleration of the shaft",
        t_1="s: time to answer for",
    )
    return s


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    torque = case.equations.solve("drive", where={"theta''": case.atoms["theta''"]})["drive"]
    answers: Answers = {}
    motions = {}
    checks = []
    for reading, where in READINGS.items():
        answers |= reactions(case, STATE, f"at t_1, {WORDS[reading]}", f"_{reading}", where)
        motions[reading] = case.having(**{name: float(x) for name, x in where.items()})
    for reading, where in READINGS.items():
        answers[f"torque_{reading}"] = case.formula(
            f"torque about the shaft that must be applied at t_1, {WORDS[reading]}, counter-clockwise +",
            case.put(case.put(torque, STATE), where), "N m", 'fb.equations(s).solve("drive")',
        )  # fmt: skip
        at = motions[reading].simulate_to([case["t_1"]])
        checks.append(against_simulation(motions[reading], answers, at, f"_{reading}"))
    for reading, where in READINGS.items():
        answers |= reactions_in_any_motion(case, WORDS[reading], f"_{reading}(theta)", where)
    trajectory = motions["a"].motion()
    pictures = plots(
        motions["a"], trajectory, "Tilted cylinder on a shaft that speeds up: forces on the shaft"
    )
    return Solved(trajectory, answers, pictures, tuple(checks))


CYLINDER_ON_SHAFT = Entry(
    "prob-6-13",
    ("cylinder-on-shaft",),
    "Cylinder on a shaft that speeds up: bearing reactions and torque (Problem 6.13)",
    (
        "forces of the bearings A and B on the shaft at t_1, (a) tilted and (b) off centre",
        "torque about the shaft that must be applied, for (a) and (b)",
        "the reactions for any motion theta(t) of the shaft",
    ),
    build,
    solve,
    until=2.0,
)
