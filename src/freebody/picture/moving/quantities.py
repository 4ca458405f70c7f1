"""Quantities of a motion over time as the data of a page, and the charts that plot them together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...motion.trajectory.units import unit_of
from .keyframes import Keyframes

if TYPE_CHECKING:
    from ...motion.trajectory.trajectory import Trajectory

APART = 15
"""Ratio of the greatest values of two quantities above which they have separate charts."""

LEAST = 1e-9
"""Variation that is round-off, relative to the size of the machine."""

CURVES = 6
"""Most curves in one chart of the page."""


def channels(trajectory: Trajectory, keys: Keyframes, acting: set[str]) -> dict[str, dict[str, Any]]:
    """Quantities over time by key: their unit, and their values as n times ``width`` numbers."""
    result: dict[str, dict[str, Any]] = {}
    for arrow in keys.arrows:
        if arrow.key not in acting:
            continue
        unit = "N" if arrow.kind == "force" else "N m"
        result[arrow.key] = {"unit": unit, "width": 3, "values": keys.vectors[arrow.key]}
    for i, name in enumerate(trajectory.names):
        result[f"state {name}"] = _scalar(unit_of(trajectory, name), keys.states[:, i])
    for name, values in keys.energy.items():
        result[f"energy {name}"] = _scalar("J", values)
    if keys.touched is not None:
        for k, name in enumerate(keys.touched.names):
            units = trajectory.kernels.model.contacts[k].units
            result[f"gap {name}"] = _scalar(units["gap"], keys.touched.gap[:, k])
            for i, force in enumerate(_force_names(trajectory, k)):
                result[f"force {force}"] = _scalar(units["normal"], keys.touched.forces[k][:, i])
            if not trajectory.kernels.model.contacts[k].frictionless:
                result[f"margin {name}"] = _scalar(units["margin"], keys.touched.margin(k))
    result["energy residual"] = _scalar("J", keys.residual)
    return result


def charts(
    trajectory: Trajectory, keys: Keyframes, acting: set[str], size: float = 1.0
) -> list[dict[str, Any]]:
    """Charts: each has a title, a group, a least range, and curves as [key, component, label]."""
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
                    # a quantity that varies by less is drawn as a straight line, so that round-off is not magnified
                    "least": 0.0 if "unbalanced" in title else LEAST * size,
                }
            )

    for title, group, names in (
        ("Coordinates", "coordinates", model.coordinate_names),
        ("Speeds", "speeds", model.speed_names),
    ):
        groups = _alike(trajectory, keys, names)
        for together in groups:
            members = f": {', '.join(together[:3])}{' …' if len(together) > 3 else ''}"
            put(
                title + (members if len(groups) > 1 else ""),
                group,
                [[f"state {name}", 0, name] for name in together],
            )
    put("Energy", "energy", [[f"energy {name}", 0, name] for name in keys.energy])
    put("Energy: what the ledger leaves unbalanced", "energy", [["energy residual", 0, "residual"]])
    for arrow in keys.arrows:
        if arrow.group == "reaction" and arrow.contact is None and arrow.key in acting:
            letter = "" if arrow.kind == "force" else "M"
            curves = [[arrow.key, k, f"{arrow.name}_{letter}{'xyz'[k]}"] for k in range(3)]
            put(f"{arrow.kind.capitalize()} of {arrow.name} on {arrow.body}", "reactions", curves)
    if keys.touched is not None:
        names, contacts = keys.touched.names, model.contacts
        if len(names) <= CURVES:
            for k, name in enumerate(names):
                forces = [[f"force {force}", 0, force] for force in _force_names(trajectory, k)]
                put(f"Contact {name}: force on {contacts[k].feature.body.name}", "contacts", forces)
        else:
            normal_names = [contact.normal_name for contact in contacts]
            put(
                "Normal forces of contacts", "contacts", [[f"force {name}", 0, name] for name in normal_names]
            )
        rough = [contact.name for contact in contacts if not contact.frictionless]
        if rough:
            put("Friction margin: μN - |T|", "contacts", [[f"margin {name}", 0, name] for name in rough])
        put("Gaps of contacts", "contacts", [[f"gap {name}", 0, name] for name in names])
    return charts


def _force_names(trajectory: Trajectory, k: int) -> tuple[str, ...]:
    """Names of the normal force and of the friction components of contact k."""
    contact = trajectory.kernels.model.contacts[k]
    return (contact.normal_name, *(() if contact.frictionless else contact.tangent_names))


def _scalar(unit: str, values: Any) -> dict[str, Any]:
    """A quantity of one number at each moment."""
    return {"unit": unit, "width": 1, "values": np.asarray(values, dtype=float)}


def _alike(trajectory: Trajectory, keys: Keyframes, names: Any) -> list[list[str]]:
    """Groups of names, each of one unit and of ranges that one chart can show."""
    groups: list[tuple[str, float, list[str]]] = []
    for name in names:
        unit = unit_of(trajectory, name)
        size = float(np.abs(keys.states[:, trajectory.names.index(name)]).max(initial=0.0))
        for group_unit, scale, group in groups:
            if group_unit == unit and (not (size > 0 and scale > 0) or 1 / APART < size / scale < APART):
                group.append(name)
                break
        else:
            groups.append((unit, size, [name]))
    return [group for _, _, group in groups]
