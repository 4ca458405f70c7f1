"""Tippe top: a ball whose mass centre lies below its middle stands up on its head while it spins.

Sliding friction raises it. It acts at the foot, and for any magnitude and direction H·r, with r from the mass centre
C to the foot, is constant as long as the surface is a ball (Jellett's integral): it gives the spin of the top when it
stands on its head.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy

import freebody as fb

from ...space.shape import Shape
from ..tools.answer import Answer, Answers, Plots, Solved, same
from ..tools.case import Case, explain, happened
from ..tools.entry import Entry
from ..tools.looks import placed, together, tube_between


def look(R: Any) -> Shape:
    """Return the top as it is drawn: a ball with a stem."""
    return together(placed(fb.sphere(1, R)), tube_between((0, 0, R), (0, 0, 8 * R / 5), R / 5))


def build() -> fb.System:
    """Return the top; the joint's point is the middle of the ball, and C lies a below it on the axis z of the top."""
    s = fb.System("tippe_top")
    m, R, a, mu, g = s.parameters(m=0.02, R=0.02, a=0.006, mu=0.03, g=9.81)
    I_1, I_3 = s.parameters(I_1=2.994e-6, I_3=3.2e-6)
    s.parameters(theta_0=0.2, spin=200.0)
    s.gravity = (0, 0, -g)
    inertia = ((I_1, 0, 0), (0, I_1, 0), (0, 0, I_3))
    top = s.body("top", fb.MassProperties(m, (0, 0, -a), inertia), shape=look(R))
    s.free("air", s.ground, top, at=(0, 0, R))
    s.contact("floor", top.sphere(R), s.ground.plane(normal="z"), friction=mu)
    explain(
        s,
        m="kg: mass of the top",
        R="m: radius of its ball",
        a="m: distance of its mass centre below the middle of the ball",
        mu="1: friction of the floor",
        g="m/s²: gravity",
        I_1="kg m²: transverse moment of inertia about C",
        I_3="kg m²: moment of inertia about the axis",
        theta_0="rad: angle of the axis from the vertical at the start",
        spin="rad/s: spin about the axis at the start",
    )
    return s


def jellett(case: Case, motion: fb.Trajectory) -> np.ndarray:
    """Return -H·r at the output times, r from C to the foot, H about C [kg m²/s · m]."""
    R = motion.poses["top"].rotation
    w = np.stack([motion[f"air_w{axis}"] for axis in "xyz"], axis=-1)
    H = np.einsum("nij,nj->ni", R, w * np.array([case["I_1"], case["I_1"], case["I_3"]]))
    r = np.array([0, 0, -case["R"]]) + case["a"] * R[:, :, 2]
    return -np.einsum("ni,ni->n", H, r)


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy, history, saved

    case.refuse_unless("mu", case["mu"] > 0, "friction greater than 0")
    case.refuse_unless("a", 0 < case["a"] < case["R"], "a mass centre within the ball, below its middle")
    case.refuse_unless("spin", case["spin"] != 0, "a spin")
    start = {"air": fb.Rotation.euler("ZXZ", 0, case["theta_0"], 0), "air_wz": "spin"}
    level = fb.event("air_e0^2 + air_e3^2 - air_e1^2 - air_e2^2", name="horizontal")
    trajectory = case.motion(initial=start, events=[level])
    up = trajectory.poses["top"].rotation[:, 2, 2]
    theta = np.arccos(np.clip(up, -1, 1))
    J = jellett(case, trajectory)
    R, a, spin, first = (case.atoms[name] for name in ("R", "a", "spin", "theta_0"))
    head = spin * (R * sympy.cos(first) - a) / (R + a)
    m, g, I_3 = (case.atoms[name] for name in ("m", "g", "I_3"))
    spent = I_3 * (spin**2 - head**2) / 2 - m * g * a * (1 + sympy.cos(first))
    law = "Jellett's integral H·r"
    w_z = trajectory["air_wz"]
    rose = bool(theta[-1] > 0.95 * np.pi)
    passed = happened(trajectory, "horizontal")
    answers: Answers = {
        "spin_head": case.formula("spin when it stands on its head", head, "rad/s", law),
        "spent": case.formula(
            "energy that friction and hops have taken then", spent, "J", law + " and the energies"
        ),
        "rises": Answer(
            "does it stand on its head in the run?", "yes" if rose else "no", "", how="fb.simulate"
        ),
        "t_half": Answer(
            "time at which its axis is first horizontal",
            float(passed[0].time) if passed else "none: it does not rise", "s" if passed else "",
            how="fb.simulate, event located",
        ),
    }  # fmt: skip
    ledger = trajectory.energy
    mechanical = ledger.kinetic + ledger.potential
    checks = [
        same("Jellett's integral over the run, over its first value", J / J[0], np.ones(len(J)), 1e5 * case.tolerance),
        same("the energy never grows: largest growth over the first energy",
             max(0.0, float(np.max(np.diff(mechanical)))) / float(ledger.kinetic[0]), 0, 1e4 * case.tolerance),
        same("energy ledger with the heat of friction", ledger.relative_residual, 0, 1000 * case.tolerance),
    ]  # fmt: skip
    if rose:
        checks.append(same("spin on its head, in the axes of the top, over that by Jellett",
                           -w_z[-1] / answers["spin_head"].value, 1, 0.01))  # fmt: skip
    plots: Plots = {
        "axis.png": saved(
            lambda: history(trajectory, ["air_wz"], title="Tippe top: spin about its axis", events=False)
        ),
        "energy.png": saved(lambda: energy(trajectory)),
    }
    return Solved(trajectory, answers, plots, tuple(checks))


TIPPE_TOP = Entry(
    "tippe-top",
    (),
    "Tippe top rising to its head by sliding friction",
    ("spin when it stands on its head, energy spent then", "does it rise, and when is its axis horizontal"),
    build,
    solve,
    until=18.0,
    positive=("m", "I_3", "g"),
    near={"air": (1, 0, 0, 0)},
)
