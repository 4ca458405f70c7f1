"""Quantities of a motion over time as the data of a page, and which of them are plotted together."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any

import numpy as np

from ...motion.trajectory.trajectory import unit_of
from .keyframes import Keyframes

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

APART = 15
"""Quantities whose greatest values are so many times apart have charts of their own."""

LEAST = 1e-9
"""Variation, in parts of the size of the machine (of other units, of 1), that is round-off."""

CURVES = 6
"""Most curves in one chart of the page."""


def channels(trajectory: Trajectory, keys: Keyframes, acting: set[str]) -> dict[str, dict[str, Any]]:
    """Quantities over time by a key: their values, n times ``width`` numbers, and their unit."""
    result: dict[str, dict[str, Any]] = {}
    for arrow in keys.arrows:
        if arrow.key not in acting:
            continue
        unit = "N" if arrow.kind == "force" else "N m"
        result[arrow.key] = {"unit": unit, "width": 3, "values": base64_floats(keys.vectors[arrow.key])}
    for i, name in enumerate(trajectory.names):
        result[f"state {name}"] = {
            "unit": unit_of(trajectory, name),
            "width": 1,
            "values": base64_floats(keys.states[:, i]),
        }
    for name, values in keys.energy.items():
        result[f"energy {name}"] = {"unit": "J", "width": 1, "values": base64_floats(values)}
    if keys.touched is not None:
        for k, name in enumerate(keys.touched.names):
            result[f"gap {name}"] = _scalar("m", keys.touched.gap[:, k])
            for i, force in enumerate(_force_names(trajectory, k)):
                result[f"force {force}"] = _scalar("N", keys.touched.forces[k][:, i])
            if not trajectory.kernels.model.contacts[k].frictionless:
                result[f"margin {name}"] = _scalar("N", keys.touched.margin(k))
    result["energy residual"] = {"unit": "J", "width": 1, "values": base64_floats(keys.residual)}
    return result


def charts(
    trajectory: Trajectory, keys: Keyframes, acting: set[str], size: float = 1.0
) -> list[dict[str, Any]]:
    """What is plotted together: a title, the least range, and curves as (key, component, label)."""
    model = trajectory.kernels.model
    charts: list[dict[str, Any]] = []

    def put(title: str, group: str, curves: list[list[Any]]) -> None:
        count = -(-len(curves) // CURVES)  # rounded up
        for k in range(count):
            more = f" ({k + 1} of {count})" if count > 1 else ""
            charts.append(
                {
                    "title": title + more,
                    "group": group,
                    "curves": curves[k * CURVES : (k + 1) * CURVES],
                    # a quantity that varies by less is shown as a straight line, not as its round-off
                    "least": 0.0 if "unbalanced" in title else LEAST * size,
                }
            )

    for title, group, names in (
        ("Coordinates", "coordinates", model.coordinate_names),
        ("Speeds", "speeds", model.speed_names),
    ):
        groups = _alike(trajectory, keys, names)
        for together in groups:
            which = (
                f": {', '.join(together[:3])}{' …' if len(together) > 3 else ''}" if len(groups) > 1 else ""
            )
            put(title + which, group, [[f"state {name}", 0, name] for name in together])
    put("Energy", "energy", [[f"energy {name}", 0, name] for name in keys.energy])
    put("Energy: what the ledger leaves unbalanced", "energy", [["energy residual", 0, "residual"]])
    for arrow in keys.arrows:
        if arrow.group == "reaction" and arrow.contact is None and arrow.key in acting:
            letter = "" if arrow.kind == "force" else "M"
            curves = [[arrow.key, k, f"{arrow.name}_{letter}{'xyz'[k]}"] for k in range(3)]
            put(f"{arrow.kind.capitalize()} of {arrow.name} on {arrow.body}", "reactions", curves)
    if keys.touched is not None:
        names, contacts = keys.touched.names, model.contacts
        for k, name in enumerate(names if len(names) <= CURVES else ()):
            forces = [[f"force {force}", 0, force] for force in _force_names(trajectory, k)]
            put(f"Contact {name}: force on {contacts[k].feature.body.name}", "contacts", forces)
        if len(names) > CURVES:
            put(
                "Normal forces of contacts",
                "contacts",
                [[f"force {one.normal_name}", 0, one.normal_name] for one in contacts],
            )
        rough = [name for name, one in zip(names, contacts, strict=True) if not one.frictionless]
        if rough:
            put("Friction margin: μN - |T|", "contacts", [[f"margin {name}", 0, name] for name in rough])
        put("Gaps of contacts", "contacts", [[f"gap {name}", 0, name] for name in names])
    return charts


def _force_names(trajectory: Trajectory, k: int) -> tuple[str, ...]:
    contact = trajectory.kernels.model.contacts[k]
    return (contact.normal_name, *(() if contact.frictionless else contact.tangent_names))


def _scalar(unit: str, values: Any) -> dict[str, Any]:
    return {"unit": unit, "width": 1, "values": base64_floats(values)}


def _alike(trajectory: Trajectory, keys: Keyframes, names: Any) -> list[list[str]]:
    """Names of one unit and of ranges that one chart can show."""
    groups: list[tuple[str, float, list[str]]] = []
    for name in names:
        unit = unit_of(trajectory, name)
        size = float(np.abs(keys.states[:, trajectory.names.index(name)]).max(initial=0.0))
        for known, scale, group in groups:
            if known == unit and (not (size > 0 and scale > 0) or 1 / APART < size / scale < APART):
                group.append(name)
                break
        else:
            groups.append((unit, size, [name]))
    return [group for _, _, group in groups]


def base64_floats(values: Any) -> str:
    """Numbers as 32-bit floats in base64."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode("ascii")
