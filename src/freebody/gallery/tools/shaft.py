"""What the shafts of the gallery have in common: two bearings, a rotor between them, and their reactions.

X is horizontal, Y up, Z along the shaft; bearing A is at Z = L/2, B at Z = -L/2. They carry forces across the
shaft and no moments: together they are a hinge, whose reaction :func:`freebody.bearing_reactions` shares
between them. theta is the angle of the body's x axis from X.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

import freebody as fb

from .answer import Answer, Answers, Check, Plots, same
from .case import Case, explain, mass_properties
from .pictures import lines

BEARINGS = {"A": "L/2", "B": "-L/2"}
HOW = 'fb.bearing_reactions(s, "axle", at={"A": "L/2", "B": "-L/2"})'


def on_shaft(s: fb.System, rotor: Any) -> Any:
    """Put a rotor on the shaft, with weight along -Y; describe what all shafts share."""
    s.gravity = (0, -s.expression("g"), 0)
    axle = s.hinge("axle", s.ground, rotor, axis="z", coordinate="theta")
    explain(
        s,
        L="m: distance between the bearings",
        g="m/s²: gravity",
        theta="rad: angle of the body's x axis from X, counter-clockwise about Z",
    )
    return axle


def product_of_inertia(case: Case, rotor: str) -> Answer:
    """I_yz = ∫ y z dm about the midpoint of the shaft, in body axes."""
    about = mass_properties(case.system.bodies[rotor]).about((0, 0, 0))
    return case.formula(
        "product of inertia I_yz = ∫ y z dm about the midpoint, body axes",
        -sympy.sympify(about[1][2]), "kg m²", "rotor.mass_properties.about(midpoint)",
    )  # fmt: skip


def dynamic_amplitude(case: Case, omega: Any) -> Answer:
    """Size of the reaction at a bearing that turns with the shaft: without weight, at constant speed."""
    found = fb.bearing_reactions(case.equations, "axle", at=BEARINGS).rotating["A"]
    x, y, _ = case.put(found, {"theta'": omega, "theta''": 0, "g": 0})
    return case.formula(
        "amplitude of the dynamic reaction at each bearing", sympy.sqrt(x**2 + y**2), "N", HOW
    )


def reactions(
    case: Case, state: Mapping[str, Any], label: str, ending: str = "", where: Mapping[str, Any] | None = None
) -> Answers:
    """Components of the force of each bearing on the shaft at a state; ``where`` are values of parameters."""
    found = fb.bearing_reactions(case.equations, "axle", at=BEARINGS).ground
    return {
        f"R_{name}{axis}{ending}": case.formula(
            f"force of bearing {name} on the shaft {label}, {axis} component",
            case.put(case.put(force[i], state), where), "N", HOW,
        )
        for name, force in found.items()
        for i, axis in enumerate("XY")
    }  # fmt: skip


def against_simulation(case: Case, answers: Answers, at: fb.Trajectory, ending: str = "") -> Check:
    """The closed forms of the reactions, and those of the simulation at its last time."""
    felt = fb.bearing_reactions(case.equations, "axle", at=BEARINGS).along(at)
    simulated = [felt[name][-1][i] for name in "AB" for i in range(2)]
    closed = [answers[f"R_{name}{axis}{ending}"].value for name in "AB" for axis in "XY"]
    return same(
        f"bearing reactions{ending.replace('_', ' ')} against the simulation",
        closed,
        simulated,
        1e4 * case.tolerance,
    )


def plots(case: Case, trajectory: fb.Trajectory, title: str) -> Plots:
    """Forces of the bearings over time, in ground axes, and the energy ledger."""
    from ...picture.plots.plots import energy_residual, saved

    felt = fb.bearing_reactions(case.equations, "axle", at=BEARINGS).along(trajectory)

    panels = {
        f"force at {name} [N]": {f"R_{name}{axis}": force[:, i] for i, axis in enumerate("XY")}
        for name, force in felt.items()
    }
    return {
        "bearings.png": saved(lambda: lines(trajectory.t, panels, title)),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
