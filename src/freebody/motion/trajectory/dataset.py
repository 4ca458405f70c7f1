"""A trajectory as an xarray dataset."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...model.contact import OF_LENGTHS
from ...version import VERSION
from .computed_motion import ComputedMotion
from .quantities import LEDGER
from .units import unit_of

if TYPE_CHECKING:
    import xarray

ENERGIES = {
    "kinetic_energy": "kinetic energy of all bodies",
    "potential_energy": "potential energy of weight and springs",
    "work": "work done since the start by loads without potential and by drives",
    "energy_residual": "what the energy ledger fails to balance",
}


_OF_CONTACT = {
    "gap": "gap {}", "approach": "speed at which the gap closes {}", "normal": "normal force {}",
    "tangential": "friction on the feature {}", "slip": "slip velocity {}",
    "margin": "what friction has left {}, mu_s N - |T|",
}  # fmt: skip


def dataset(trajectory: ComputedMotion) -> xarray.Dataset:
    """Return coordinates, speeds, poses, energies and reactions over ``time``, and events over ``event``.

    The pose of body b is ``b.position`` (time, axis) and ``b.quaternion`` (time, component); the reaction of joint j is
    ``j.force`` and ``j.moment`` (time, axis); all are in ground axes. Each variable has ``units`` and ``long_name``.
    Attributes hold the values of the parameters, as JSON, and the origin of the data.
    """
    import xarray

    model = trajectory.kernels.model
    variables: dict[str, Any] = {}
    for i, name in enumerate(trajectory.names):
        about = model.about.get(name.rstrip("'"), ("", ""))[1] or name.rstrip("'")
        text = f"rate of {about}" if name.endswith("'") else about
        variables[name] = (
            "time",
            trajectory.states[:, i],
            {"units": unit_of(trajectory, name), "long_name": text},
        )
    for name, text in ENERGIES.items():
        variables[name] = (
            "time",
            getattr(trajectory.energy, LEDGER[name]),
            {"units": "J", "long_name": text},
        )
    for name, pose in trajectory.poses.items():
        variables[f"{name}.position"] = (
            ("time", "axis"),
            pose.position,
            {"units": "m", "long_name": f"position of the origin of {name} in ground axes"},
        )
        variables[f"{name}.quaternion"] = (
            ("time", "component"),
            pose.quaternion,
            {"units": "1", "long_name": f"unit quaternion, ground from {name}"},
        )
    units = {contact.name: contact.units for contact in trajectory.kernels.model.contacts}
    for name, motion in trajectory.contacts.items():
        variables.update(_of_contact(name, motion, units.get(name, OF_LENGTHS)))
    for name, reaction in trajectory.reactions.items():
        where = f"on {reaction.on}, in {reaction.frame} axes"
        variables[f"{name}.force"] = (
            ("time", "axis"),
            reaction.force,
            {"units": "N", "long_name": f"reaction force of joint {name} {where}"},
        )
        variables[f"{name}.moment"] = (
            ("time", "axis"),
            reaction.moment,
            {"units": "N m", "long_name": f"reaction moment of joint {name} {where}, about {reaction.about}"},
        )
    events = trajectory.events
    if trajectory.specs or events:
        variables["event_time"] = (
            "event",
            np.array([event.time for event in events], dtype=float),
            {"units": "s", "long_name": "time of the event"},
        )
        variables["event_name"] = ("event", np.array([event.name for event in events], dtype=object))
        variables["event_direction"] = (
            "event",
            np.array([event.direction for event in events], dtype=np.int64),
        )
    return xarray.Dataset(
        variables,
        coords={
            "time": ("time", trajectory.t, {"units": "s", "long_name": "time"}),
            "axis": list("xyz"),
            "component": list("wxyz"),
        },
        attrs={
            "title": f"Motion of {trajectory.name}",
            "status": trajectory.status,
            "method": trajectory.path.method,
            # if every joint is driven, nothing is integrated
            **({"tolerance": float(np.min(trajectory.tolerances))} if len(trajectory.tolerances) else {}),
            "steps": trajectory.steps,
            "parameters": json.dumps(trajectory.values),
            "source": f"freebody {VERSION}",
        },
    )


def _of_contact(name: str, motion: Any, units: Mapping[str, str]) -> dict[str, Any]:
    """Return gap, approach, forces, slip, friction-cone margin and mode of a contact."""
    about, result = f"of contact {name}", dict[str, Any]()
    for what, text in _OF_CONTACT.items():
        values = getattr(motion, what)
        if values.size:  # a stop has no tangent
            dims = ("time", "tangent")[: values.ndim]
            result[f"{name}.{what}"] = (dims, values, {"units": units[what], "long_name": text.format(about)})
    result[f"{name}.mode"] = ("time", np.array(motion.mode, dtype=object), {"long_name": f"mode {about}"})
    return result
