"""What motions refuse where the load of a joint bounds its friction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...errors import SimulationError
from ...model import Model


def frictions(model: Model) -> str:
    """Return the names of friction that the load of a joint bounds."""
    return ", ".join(repr(one.name) for one in model.contacts if one.loaded)


def jammed(model: Model, t: float) -> SimulationError:
    """Return the error for joints whose load grows with the friction that it bounds."""
    joints = ", ".join(
        f"'{one.name}' of joint '{one.law.joint.name}'" for one in model.contacts if one.loaded
    )
    return SimulationError(
        f"Joints of '{model.name}' jam at t = {t:.9g} s: the friction under their load presses them by more than it "
        f"takes, so that no finite force is the friction {joints} (Painlevé). Less friction, a smaller radius of a pin "
        f"or a greater length of a guide has a motion."
    )


def struck_load(model: Model, what: str, cure: str) -> SimulationError:
    """Return the error for an impact, or a blow, of a machine whose joints have friction under their load."""
    return SimulationError(
        f"{what} The load of a joint is an impulse then, and so is the friction {frictions(model)} that it bounds, "
        f"which is not known. {cure}"
    )


def check_blows(model: Model, blows: Sequence[Any], why: str) -> None:
    """Refuse blows beside friction under the load of joints, for a reason."""
    if frictions(model) and blows:
        raise struck_load(
            model, f"'{model.name}' has a blow, '{blows[0].name}', and {why}.",
            "Give the joint torque= or force=, or let a short force act in place of the blow.",
        )  # fmt: skip


def check_loads(model: Model) -> None:
    """Refuse families of contacts beside friction under the load of joints."""
    names = frictions(model)
    if names and model.families:
        raise SimulationError(
            f"'{model.name}' has contacts in families, '{model.families[0].name}', whose forces are not among the "
            f"loads of joints that bound friction {names}. Take s.contact for them, or give the joint torque= or "
            "force=."
        )
