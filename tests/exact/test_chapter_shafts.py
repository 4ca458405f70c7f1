"""Section 6.6 and Problems 6.12, 6.13 against closed forms: bodies fixed to a shaft in two bearings."""

from __future__ import annotations

import pytest

from chapter_answers import check_formulas, check_numbers
from freebody import exact
from freebody.exact.elementary import sqrt

NAMES = ("R_AX", "R_AY", "R_BX", "R_BY")


def amplitude(p, I_yz, omega):
    return sqrt((I_yz * omega**2 / p["L"]) ** 2)


def tilted_disk(p):
    across = p["m"] * p["R"] ** 2 / 4
    I_yz = exact.tilted_product(2 * across, across, p["beta"])
    forces = exact.bearing_forces(p["m"], p["L"], p["g"], p["omega"] * p["t_1"], p["omega"], I_yz=I_yz)
    dynamic = amplitude(p, I_yz, p["omega"])
    return {"I_yz": I_yz, "R_dynamic": dynamic, **dict(zip(NAMES, forces, strict=True))}


def dumbbell(p):
    I_yz = exact.dumbbell_product(p["m"], p["a"], p["beta"])
    forces = exact.bearing_forces(2 * p["m"], p["L"], p["g"], p["theta_1"], p["omega"], I_yz=I_yz)
    dynamic = amplitude(p, I_yz, p["omega"])
    return {"I_yz": I_yz, "R_dynamic": dynamic, **dict(zip(NAMES, forces, strict=True))}


def cylinder(p):
    m, R, a, t, e = (p[name] for name in ("m", "R", "alpha0", "t_1", "e"))
    axis, across = m * R**2 / 2, m * (3 * R**2 + p["l"] ** 2) / 12
    theta, omega = a * t**2 / 2, a * t
    I_yz = exact.tilted_product(axis, across, p["beta"])
    tilted = exact.bearing_forces(m, p["L"], p["g"], theta, omega, a, I_yz=I_yz)
    parallel = exact.bearing_forces(m, p["L"], p["g"], theta, omega, a, e=e)
    return {
        **{f"{name}_a": force for name, force in zip(NAMES, tilted, strict=True)},
        **{f"{name}_b": force for name, force in zip(NAMES, parallel, strict=True)},
        "torque_a": exact.tilted_axial(axis, across, p["beta"]) * a,
        "torque_b": (axis + m * e**2) * a + m * p["g"] * e * exact.elementary.cos(theta),
    }


@pytest.mark.parametrize(
    ("name", "closed"), [("sec-6-6", tilted_disk), ("prob-6-12", dumbbell), ("prob-6-13", cylinder)]
)
def test_shafts(name, closed, changing):
    check_numbers(name, closed, changing=changing)
    check_formulas(name, closed)
