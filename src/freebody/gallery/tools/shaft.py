"""Common parts of the gallery's shafts: two bearings, a rotor between them, and the bearing reactions.

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
    """Put a rotor on the shaft, with weight along -Y, and describe the parameters of all shafts."""
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
    """Return I_yz = ∫ y z dm about the midpoint of the shaft, in body axes."""
    about = mass_properties(case.system.bodies[rotor]).about((0, 0, 0))
    return case.formula(
        "product of inertia I_yz = ∫ y z dm about the midpoint, body axes",
        -sympy.sympify(about[1][2]), "kg m²", "rotor.mass_properties.about(midpoint)",
    )  # fmt: skip


def dynamic_amplitude(case: Case, omega: Any) -> Answer:
    """Return the magnitude of the bearing reaction that turns with the shaft: without weight, at constant speed."""
    found = fb.bearing_reactions(case.equations, "axle", at=BEARINGS).rotating["A"]
    x, y, _ = case.put(found, {"theta'": omega, "theta''": 0, "g": 0})
    return case.formula(
        "amplitude of the dynamic reaction at each bearing", sympy.sqrt(x**2 + y**2), "N", HOW
    )


def reactions(
    case: Case, state: Mapping[str, Any], label: str, ending: str = "", where: Mapping[str, Any] | None = None
) -> Answers:
    """Return the force components of each bearing on the shaft at a state; ``where`` gives values of parameters."""
    found = fb.bearing_reactions(case.equations, "axle", at=BEARINGS).ground
    return {
        f"R_{name}{axis}{ending}": case.formula(
            f"force of bearing {name} on the shaft {label}, {axis} component",
            case.put(case.put(force[i], state), where), "N", HOW,
        )
        for name, force in found.items()
        for i, axis in enumerate("XY")
    }  # fmt: skip


def reactions_in_any_motion(case: Case, label: str, ending: str, where: Mapping[str, Any]) -> Answers:
    """Return the force components of each bearing on the shaft in its angle and the rates of it."""
    force_at = fb.bearing_reactions(case.equations, "axle", at=BEARINGS).ground
    return {
        f"R_{name}{axis}{ending}": case.general(
            f"force of bearing {name} on the shaft for any theta(t), {label}, {axis} component",
            case.put(force[i], where), HOW,
        )
        for name, force in force_at.items()
        for i, axis in enumerate("XY")
    }  # fmt: skip


def against_simulation(case: Case, answers: Answers, at: fb.Trajectory, ending: str = "") -> Check:
    """Return a check of the closed-form reactions against the simulation at its last time."""
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
    """Return the plots of the bearing forces over time, in ground axes, and of the energy ledger."""
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
