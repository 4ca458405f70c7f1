"""Symmetric body with no torque about its mass centre; wobble of the earth (chapter, section 6.8).

At t = 0 the body axes lie along the ground's and the angular velocity is (w_1, 0, w_3); axis 3 = z is the
symmetry axis. Case (a) is a flat body, case (b) a slender one, case (c) the earth.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import freebody as fb

from .entry import Answers, Case, Entry, Plots, explain

START = {"C_wx": "w_1", "C_wz": "w_3"}


def build() -> fb.System:
    """A body on a ball joint at its mass centre: its mass does not matter."""
    s = fb.System("torque_free")
    I_1, I_3, *_ = s.parameters(I_1=1.0, I_3=1.8, w_1=0.5, w_3=6.0, t_1=2.0)
    s.parameters(I_1b=1.8, I_3b=0.4, earth_ratio=0.0033, earth_spin=1.0)
    body = s.body("body", fb.MassProperties(1, (0, 0, 0), ((I_1, 0, 0), (0, I_1, 0), (0, 0, I_3))))
    s.ball("C", s.ground, body)
    explain(
        s,
        I_1="kg m²: moment of inertia about a transverse axis, case (a)",
        I_3="kg m²: moment of inertia about the symmetry axis, case (a)",
        w_1="rad/s: angular velocity about axis 1 at the start",
        w_3="rad/s: angular velocity about axis 3",
        t_1="s: time to answer for",
        I_1b="kg m²: I_1 in case (b)",
        I_3b="kg m²: I_3 in case (b)",
        earth_ratio="1: (I_3 - I_1)/I_1 of the earth, case (c)",
        earth_spin="1/day: revolutions of the earth, case (c)",
    )
    return s


def rate_in_body(case: Case, w_3: float) -> float:
    """Omega of w_x' = -Omega w_y, read off the first equation of motion [rad per unit of time of ``w_3``]."""
    e = case.equations
    slope = case.number(e.bias[0].diff(case.atoms["C_wy"]), {"C_wz": w_3})
    return slope / case.number(e.mass_matrix[0, 0])


def angle(a: np.ndarray, b: np.ndarray) -> float:
    """Angle between two vectors [rad]."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def answer(case: Case, label: str) -> Answers:
    """What is asked of one body, at its state at t_1."""
    at = case.simulate_to([case["t_1"]], initial=START)
    R = at.poses["body"].rotation[0]
    w = np.array([at[f"C_w{axis}"][0] for axis in "xyz"])
    H = np.array([at[component][0] for component in case.equations.momentum.angular()])
    axis = R[:, 2]
    # axis 3 moves with the velocity w x axis; about H it turns at the rate of its swept angle
    across = np.cross(H, axis)
    swept = H @ np.cross(axis, np.cross(R @ w, axis))
    precession = swept * np.linalg.norm(H) / (across @ across) if across.any() else 0.0
    return {
        f"{label} rate Omega of omega about axis 3 in the body": (rate_in_body(case, case["w_3"]), "rad/s"),
        f"{label} angle alpha between axis 3 and H": (angle(axis, H), "rad"),
        f"{label} angle beta between axis 3 and omega": (angle(axis, R @ w), "rad"),
        f"{label} precession rate of axis 3 about H": (float(precession), "rad/s"),
        f"{label} omega in body axes at t_1": (tuple(w.tolist()), "rad/s"),
        f"{label} axis 3 in ground axes at t_1": (tuple(axis.tolist()), "1"),
    }


def solve(case: Case) -> tuple[fb.Trajectory, Answers, Plots]:
    from ..picture.plots import energy_residual, history, saved
    from ..picture.sphere import axis_path

    slender = replace(case, values={**case.values, "I_1": case["I_1b"], "I_3": case["I_3b"]})
    earth = replace(case, values={**case.values, "I_1": 1.0, "I_3": 1 + case["earth_ratio"]})
    answers = answer(case, "(a)") | answer(slender, "(b)")
    # Omega in revolutions per day, as the spin is given
    answers["(c) period of the wobble"] = (1 / rate_in_body(earth, case["earth_spin"]), "days")
    flat, thin = (one.motion(initial=START) for one in (case, slender))
    momentum = case.equations.momentum.angular()

    def cone(motion: fb.Trajectory, title: str) -> Any:
        H = [motion[part][0] for part in momentum]
        return axis_path(
            motion, "body", about=H, about_name="the angular momentum H", title=title, view=(48.0, -58.0)
        )

    def omega(motion: fb.Trajectory, title: str) -> Any:
        return history(motion, ["C_wx", "C_wy", "C_wz"], title=title)

    plots: Plots = {
        "omega.png": saved(lambda: omega(flat, "(a) Flat body: angular velocity in body axes")),
        "omega_b.png": saved(lambda: omega(thin, "(b) Slender body: angular velocity in body axes")),
        "axis_3.png": saved(lambda: cone(flat, "(a) Flat body: path of axis 3")),
        "axis_3_b.png": saved(lambda: cone(thin, "(b) Slender body: path of axis 3")),
        "energy.png": saved(lambda: energy_residual(flat)),
    }
    return flat, answers, plots


TORQUE_FREE = Entry(
    "torque-free",
    ("sec-6-8",),
    "Torque-free symmetric body: flat, slender, and the earth (section 6.8)",
    (
        "(a) flat, (b) slender: rate of omega in the body, angles of axis 3 with H and omega, precession rate",
        "(a), (b): omega and axis 3 at t_1",
        "(c) period of the wobble of the earth",
    ),
    build,
    solve,
    until=10.0,
)
