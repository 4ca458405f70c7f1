"""Thin disk that rolls without slip on a level plane: a steady turn.

z points up. The disk leans by the angle ``lean`` from the vertical, its plane turns about the vertical at the rate
Omega, and its centre moves on a circle. The library finds the spin for which the lean is constant.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved
from ..tools.case import Case, explain
from ..tools.entry import Entry


def build() -> fb.System:
    """Return the disk with six coordinates and the contact; its axle is its z axis."""
    s = fb.System("rolling_disk")
    m, R, g = s.parameters(m=2.0, R=0.3, g=9.81)
    s.parameters(lean="20deg", Omega=1.5, t_1=0.7)
    s.gravity = (0, 0, -g)
    disk = s.body("disk", fb.disk(m, R))
    s.free("air", s.ground, disk)
    s.rolling("contact", disk, radius=R, axis="z", normal="z")
    explain(
        s,
        m="kg: mass of the disk",
        R="m: radius of the disk",
        g="m/s²: gravity",
        lean="rad: angle of the disk from the vertical",
        Omega="rad/s: rate at which its plane turns about the vertical",
        t_1="s: time to answer for",
    )
    return s


def start_of(case: Case, spin: float) -> dict[str, Any]:
    """Return the state with a constant lean, axle in the plane yz: ω = Omega Z + spin · axle, both in disk axes.

    The axle is z turned about x by ``lean`` - 90°; the lowest point lies R cos(lean) below the centre.
    """
    tilt = case["lean"] - math.pi / 2
    return {
        "air": fb.Rotation.euler("XYZ", tilt, 0, 0),
        "air_wx": 0,
        "air_wy": case["Omega"] * math.sin(tilt),
        "air_wz": case["Omega"] * math.cos(tilt) + spin,
    }


NEAR = {"air_z": "R"}


def fall(case: Case, spin: float) -> float:
    """Return the second derivative of the axle tip's height at this spin, e'' = ω' × e + ω × (ω × e) along z [1/s²]."""
    from ...dynamics.conditions.constrained import independent_rows
    from ...dynamics.motion import motion
    from ...dynamics.state import float_state

    model = case.equations.model
    begun = case.simulate_to([0], initial=start_of(case, spin), near=NEAR)
    now = begun.at(0)
    state = float_state(model, now.q.tolist(), now.u.tolist(), 0, case.values)
    udot = np.array(motion(model, state, independent_rows(model, state)).udot, dtype=float)
    axle, w = np.array([0, 0, 1]), now.u[:3]
    turned = np.cross(udot[:3], axle) + np.cross(w, np.cross(w, axle))
    return float(begun.poses["disk"].rotation[0, 2] @ turned)


def steady_spin(case: Case) -> float:
    """Return the spin at which the lean is constant; the acceleration of the lean is linear in the spin."""
    low, high = fall(case, 0.0), fall(case, 1.0)
    return low / (low - high)


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, reaction, saved

    if not 0 <= abs(case["lean"]) < math.pi / 2 or case["Omega"] == 0:
        raise fb.errors.ModelError(
            f"Expected a lean between -90 and 90 degrees and a turn, got lean = {case['lean']:g} rad and "
            f"Omega = {case['Omega']:g} rad/s."
        )
    spin = steady_spin(case)
    start = start_of(case, spin)
    at = case.simulate_to([0, case["t_1"]], initial=start, near=NEAR)
    R = at.poses["disk"].rotation
    velocity = np.einsum("nij,nj->ni", R, np.stack([at[f"air_v{c}"] for c in "xyz"], axis=-1))
    # in steady motion the velocity of the centre turns at Omega: v = Omega times the distance from the turn's axis
    answers: Answers = {
        "spin": Answer("spin about the axle in a steady turn", spin, "rad/s"),
        "radius": Answer(
            "radius of the centre's circle", float(np.linalg.norm(velocity[0]) / abs(case["Omega"])), "m"
        ),
        "path(t_1)": Answer(
            "centre at t_1 from its start",
            tuple(float(at[f"air_{c}"][1] - at[f"air_{c}"][0]) for c in "xyz"),
            "m",
        ),
        "lean(t_1)": Answer("lean at t_1", math.asin(float(R[1, 2, 2])), "rad"),
        "force": Answer(
            "force of the plane at the start", tuple(at.reactions["contact"].force[0].tolist()), "N"
        ),
    }
    trajectory = case.motion(initial=start, near=NEAR)
    plots: Plots = {
        "path.png": saved(
            lambda: history(trajectory, ["air_x", "air_y"], title="Rolling disk: path of its centre")
        ),
        "contact.png": saved(lambda: reaction(trajectory, "contact", axes="xyz")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


ROLLING_DISK = Entry(
    "rolling-disk",
    (),
    "Thin disk rolling on a plane: a steady turn",
    ("spin at which the lean stays", "circle of the centre", "force at the contact"),
    build,
    solve,
    until=4.0,
    near={**NEAR, "air": (1, 1, 0, 0)},
)
