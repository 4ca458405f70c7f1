"""Rattleback: a stone that rocks and reverses its spin when it is spun the wrong way.

Half an ellipsoid whose principal axes of inertia are turned slightly from the axes of its surface, by the product of
inertia D. It rolls without slip on a table; no friction slows it, and still its spin about the vertical reverses.

Source of the shape: Kane & Levinson, International Journal of Non-Linear Mechanics 17 (1982) 175-186.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved, fact, same
from ..tools.case import SMOOTH, Case, explain
from ..tools.entry import Entry

ROUGH = 10
"""Friction of a table on which it rolls; the required friction is an answer."""


def build() -> fb.System:
    """Return the system; the body's origin is its mass centre, h below the centre of the ellipsoid."""
    s = fb.System("rattleback")
    m, a, b, c, h, g = s.parameters(m=1.0, a=0.2, b=0.03, c=0.02, h=0.01, g=9.81)
    A, B, C, D = s.parameters(A=2e-4, B=1.6e-3, C=1.6e-3, D=-2e-5)
    s.parameters(lean="0.5deg", spin=-5.0, t_1=8.0)
    s.gravity = (0, 0, -g)
    stone = s.body("stone", fb.MassProperties(m, (0, 0, 0), ((A, D, 0), (D, B, 0), (0, 0, C))))
    s.free("air", s.ground, stone, at=(0, 0, c - h))
    s.contact("table", stone.ellipsoid((a, b, c), at=(0, 0, h)), s.ground.plane(normal="z"), friction=ROUGH)
    explain(
        s,
        m="kg: mass of the stone",
        a="m: half axis of its surface along x, the long one",
        b="m: half axis along y",
        c="m: half axis along z, downwards",
        h="m: depth of the mass centre below the centre of the surface",
        g="m/s²: gravity",
        A="kg m²: moment of inertia about x",
        B="kg m²: moment of inertia about y",
        C="kg m²: moment of inertia about z",
        D="kg m²: product of inertia, entry xy of the inertia matrix",
        lean="rad: turn about y at the start",
        t_1="s: time for which it is watched",
        spin="rad/s: angular velocity about the vertical at the start, counter-clockwise +",
    )
    return s


def begin(case: Case, spin: float) -> dict[str, Any]:
    """Return the state that rolls about the vertical: v = -ω × r, with r from the mass centre to the contact point."""
    cos, sin = math.cos(case["lean"]), math.sin(case["lean"])
    up = np.array([-sin, 0, cos])  # in the axes of the stone
    squares = np.array([case["a"], case["b"], case["c"]]) ** 2
    foot = np.array([0, 0, case["h"]]) - squares * up / math.sqrt(up @ (squares * up))
    w = spin * up
    v = -np.cross(w, foot)
    start: dict[str, Any] = {"air": fb.Rotation.euler("XYZ", 0, case["lean"], 0)}
    start["air_z"] = -float(foot @ up) - (case["c"] - case["h"])
    for letter, turn, speed in zip("xyz", w, v, strict=True):
        start |= {f"air_w{letter}": float(turn), f"air_v{letter}": float(speed)}
    return start


def vertical_spin(motion: fb.Trajectory) -> np.ndarray:
    """Return the angular velocity about the vertical at the output times [rad/s]."""
    w = np.stack([motion[f"air_w{axis}"] for axis in "xyz"], axis=-1)
    return np.einsum("nj,nj->n", motion.poses["stone"].rotation[:, 2], w)


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy, figure, saved

    case.refuse_unless("spin", case["spin"] != 0, "a spin")
    case.refuse_unless(
        "h", 0 < case["h"] < case["c"], "a mass centre between the foot and the centre of the surface"
    )
    upright = fb.event("(2*(air_e1*air_e3 - air_e0*air_e2))*air_wx + (2*(air_e2*air_e3 + air_e0*air_e1))*air_wy"
                       " + (air_e0^2 + air_e3^2 - air_e1^2 - air_e2^2)*air_wz", name="no spin")  # fmt: skip
    runs = {}
    for key, spin in (("", case["spin"]), ("_back", -case["spin"])):
        runs[key] = case.simulate(
            case["t_1"],
            initial=begin(case, spin),
            events=[upright],
            samples=SMOOTH,
            tolerance=case.tolerance / 100,
        )
    answers: Answers = {}
    checks = []
    for key, words in (("", "spun as given"), ("_back", "spun the other way")):
        motion = runs[key]
        turned = vertical_spin(motion)
        stopped = [event.time for event in motion.events if event.name == "no spin"]
        start = turned[0]
        against = -turned * np.sign(start)
        reverses = bool(stopped) and against.max() > 0.1 * abs(start)
        answers |= {
            f"reverses{key}": Answer(f"{words}: does its spin reverse by t_1?", "yes" if reverses else "no", "",
                                     how="fb.simulate"),
            f"t_0{key}": Answer(f"{words}: time at which it first stands still about the vertical",
                                float(stopped[0]) if stopped else "none: it does not", "s" if stopped else "",
                                how="fb.simulate, event located"),
            f"spin{key}": Answer(f"{words}: largest spin against it", float(max(against.max(), 0.0)), "rad/s",
                                 how="fb.simulate, output times"),
        }  # fmt: skip
        ledger = motion.energy
        held = motion.contacts["table"]
        needed = np.linalg.norm(held.tangential, axis=1) / held.normal
        checks += [
            fact(f"{words}: it rolls all the time", bool(np.all(held.mode == "stick"))),
            same(f"{words}: the energy keeps its value", ledger.relative_residual, 0, 1000 * case.tolerance),
            same(
                f"{words}: gap at the table over h",
                np.abs(held.gap).max() / case["h"],
                0,
                1000 * case.tolerance,
            ),
        ]
        answers[f"mu_needed{key}"] = Answer(
            f"{words}: largest |T|/N, friction that the rolling takes",
            float(needed.max()),
            "1",
            how="fb.simulate",
        )
    trajectory = case.motion(initial=begin(case, case["spin"]), events=[upright])

    def spins() -> Any:
        ax = figure(8, 4).subplots()
        for key, label in (("", "spun as given"), ("_back", "spun the other way")):
            ax.plot(runs[key].t, vertical_spin(runs[key]), label=label, linewidth=1.4)
        ax.axhline(0, color="0.6", linewidth=0.8)
        ax.set_xlabel("time [s]")
        ax.set_ylabel("spin about the vertical [rad/s]")
        ax.set_title("Rattleback", loc="left", fontweight="bold")
        ax.legend(frameon=False)
        return ax

    plots: Plots = {"spin.png": saved(spins), "energy.png": saved(lambda: energy(trajectory))}
    return Solved(trajectory, answers, plots, tuple(checks))


RATTLEBACK = Entry(
    "rattleback",
    ("wobblestone",),
    "Rattleback: a stone that reverses its spin",
    (
        "spun as given, and the other way: does its spin reverse, when, and how far",
        "friction that the rolling takes",
    ),
    build,
    solve,
    until=8.0,
    positive=("m", "g", "t_1"),
)
