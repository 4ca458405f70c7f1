"""A blow on the shaft of a gyroscope in steady slow precession (chapter, Problem 6.21).

The impulse acts along the nodal axis, at right angles to the vertical plane of the shaft. `fb.impulse` gives
the angular velocity just after it; the small oscillation of section 6.10 follows.
"""

from __future__ import annotations

from typing import Any

import sympy

import freebody as fb

from ...tools.answer import Answers, Solved
from ...tools.case import Case, explain
from ...tools.entry import Entry
from ..examples.sec_6_9_gyroscope import MOMENTS, top
from ..examples.sec_6_10_nutation import plots, slow_precession, start, steadiness, theory_and_truth


def build() -> fb.System:
    """Return the gyroscope with a blow on its shaft."""
    s = top("struck_gyroscope", F=0.02, reach=0.8, t_1=0.1)
    explain(
        s,
        F="N s: impulse along the nodal axis",
        reach="1: distance of the blow from the pivot, as a part of L",
        t_1="s: time to answer for",
    )
    return s


def blow(s: fb.System) -> dict[str, Any]:
    """Return the blow on the shaft: at psi = 0 the nodal axis is X; the rotor's origin is L from the pivot."""
    return {"F": (s.bodies["rotor"].point(0, 0, "reach*L - L"), ("F", 0, 0))}


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    slow = slow_precession(case)
    atoms = case.atoms
    point, impulse = blow(case.system)["F"]
    hit = fb.impulse(
        case.equations,
        at=point,
        impulse=impulse,
        initial={"theta": "theta_0", "psi": 0},
    )
    change = hit.change
    sine = sympy.sin(atoms["theta_0"])
    how = "fb.impulse(s, at=shaft.point(...), impulse=(F, 0, 0))"
    answers: Answers = {
        "w_xi": case.formula(
            "change of the angular velocity along xi, the nodal axis", change["theta'"], "rad/s", how
        ),
        "w_eta": case.formula(
            "change of the angular velocity along eta, across the nodal axis and the shaft",
            change["psi'"] * sine, "rad/s", how,
        ),
    }  # fmt: skip
    linear_answers, theory = theory_and_truth(case, slow, change["theta'"], change["psi'"])
    answers |= linear_answers
    trajectory = case.motion(initial=start(case, slow, change["theta'"], change["psi'"]))
    return Solved(trajectory, answers, plots(case, trajectory, theory), (steadiness(case, slow),))


STRUCK_GYROSCOPE = Entry(
    "prob-6-21",
    ("struck-gyroscope",),
    "Blow on the shaft of a gyroscope in steady slow precession (Problem 6.21)",
    (
        "change of the angular velocity along xi and eta just after the blow",
        "theta and psi at t_1 in the linear theory",
        "theta and psi at t_1, exact (nonlinear)",
    ),
    build,
    solve,
    until=0.5,
    start={"theta": "theta_0", "phi'": "Omega_zeta"},
    drawn={"psi": 0, "theta": "theta_0"},
    blows=blow,
    names=MOMENTS,
)
