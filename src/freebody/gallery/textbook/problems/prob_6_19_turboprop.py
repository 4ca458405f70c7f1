"""Propeller and engine rotor of an aircraft in a level turn (chapter, Problem 6.19).

x points forward, y to the left, Z up. The pilot sees the propeller turn clockwise: its spin is along +x. The
engine rotor turns the other way. In a right turn the aircraft turns at -v/R about Z. The reactions of the shafts
are the moments that turn the rotors; the opposite moments act on the airframe.
"""

from __future__ import annotations

from typing import Any

import freebody as fb

from ....space.shape import Shape
from ...tools.answer import Answer, Answers, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ...tools.looks import placed, together
from ...tools.pictures import moments

SHAFTS = ("P", "E")
TURN = {"psi'": "-v/R", "p'": "w_p", "n'": "-w_e"}


def look() -> Shape:
    """Return the airframe as it is drawn: fuselage along x, wings, tail."""
    return together(
        placed(fb.ellipsoid(1, (3, 0.5, 0.5))),
        placed(fb.box(1, (1, 7, 0.08)), (0.5, 0, 0)),
        placed(fb.box(1, (0.6, 2.4, 0.06)), (-2.6, 0, 0.2)),
        placed(fb.box(1, (0.7, 0.06, 1)), (-2.6, 0, 0.7)),
    )


def build() -> fb.System:
    """Return an airframe that turns about the vertical, with two rotors along x; their masses have no effect."""
    s = fb.System("turboprop")
    I_p, I_e = s.parameters(I_p=8.0, w_p=120.0, I_e=0.6, w_e=1200.0)[::2]
    s.parameters(v=100.0, R=800.0, w_e2=1800.0)
    airframe = s.body(
        "airframe",
        # balances the rotors, so that the aircraft turns about its mass centre: nothing holds it there
        fb.MassProperties(11, ("-1/2", 0, 0), ((10, 0, 0), (0, 10, 0), (0, 0, 10))),
        shape=look(),
    )
    shown = {
        "propeller": (fb.box(1, (0.1, 0.25, 2.6)), 3.1),
        "engine": (fb.cylinder(1, 0.45, 0.5, axis="x"), 2.4),
    }
    s.gimbal("yaw", s.ground, airframe, axis="ZYX", coordinate=("psi", 0, 0))  # wings and tail hold it level
    for shaft, rotor, inertia, angle in zip(
        SHAFTS, ("propeller", "engine"), (I_p, I_e), ("p", "n"), strict=True
    ):
        thin = ((inertia, 0, 0), (0, inertia / 2, 0), (0, 0, inertia / 2))
        body = s.body(rotor, fb.MassProperties(1, (0, 0, 0), thin), shape=shown[rotor][0])
        s.hinge(shaft, airframe, body, at=(shown[rotor][1], 0, 0), axis="x", coordinate=angle)
    explain(
        s,
        I_p="kg m²: moment of inertia of the propeller about its axis",
        w_p="rad/s: angular velocity of the propeller, clockwise as the pilot sees it",
        I_e="kg m²: moment of inertia of the engine rotor about its axis",
        w_e="rad/s: angular velocity of the engine rotor, counter-clockwise",
        v="m/s: speed of the aircraft",
        R="m: radius of the right turn",
        w_e2="rad/s: another angular velocity of the engine rotor",
        psi="rad: turn of the aircraft about the vertical, to the left +",
        p="rad: angle of the propeller about the forward axis",
        n="rad: angle of the engine rotor about the forward axis",
    )
    return s


def pitching(case: Case, **turn: Any) -> Any:
    """Return the moment on the airframe about the left-pointing axis y, nose up +, in a steady turn."""
    e = case.equations
    steady = {name: 0 for name in ("psi", "p", "n", "psi''", "p''", "n''")}
    on_rotors = sum(e.reactions[shaft].moment[1] for shaft in SHAFTS)
    # a moment about +y turns the nose down; the moment on the airframe is opposite to that on the rotors
    return case.put(on_rotors, {**steady, **TURN, **turn})


def nose(moment: float) -> str:
    """Return the tendency of the nose in words."""
    return "neither: no moment" if moment == 0 else "rise" if moment > 0 else "fall"


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ....picture.plots.plots import energy_residual, history, saved

    how = "fb.equations(s).reactions of both shafts, in a steady turn"
    moment = case.formula("gyroscopic pitching moment on the airframe, nose up +", pitching(case), "N m", how)
    other = case.formula(
        "gyroscopic pitching moment with w_e2, nose up +", pitching(case, **{"n'": "-w_e2"}), "N m", how
    )
    answers: Answers = {
        "nose": Answer("does the nose tend to rise or to fall?", nose(moment.value), "", how=how),
        "M": moment,
        "nose_2": Answer("does it rise or fall with w_e2?", nose(other.value), "", how=how),
        "M_2": other,
    }
    start = {name: case.number(case.system.expression(x)) for name, x in TURN.items()}
    trajectory = case.motion(initial=start)
    felt = sum(trajectory.reactions[shaft].moment[0, 1] for shaft in SHAFTS)
    checks = (same("M against the simulation", moment.value, felt, 1000 * case.tolerance),)
    plots: Plots = {
        "angles.png": saved(lambda: history(trajectory, "psi", title="Turboprop: heading")),
        "propeller.png": saved(lambda: moments(trajectory, "P", "Turboprop: moment on the propeller")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks)


TURBOPROP = Entry(
    "prob-6-19",
    ("turboprop",),
    "Turboprop aircraft in a right turn: gyroscopic pitching moment (Problem 6.19)",
    (
        "does the nose tend to rise or to fall?",
        "gyroscopic pitching moment exerted on the airframe, nose up +",
        "which way with the engine rotor at w_e2",
    ),
    build,
    solve,
    until=1.0,
    start=TURN,
)
