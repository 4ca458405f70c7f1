"""The displacement of a joint along which a load acts."""

from __future__ import annotations

from ...errors import ModelError, shown
from ..joints.joint import Joint


def check_displacement(joint: Joint, index: int, title: str) -> None:
    """Refuse a joint without a single displacement, and an index that it does not have."""
    if joint.pair.path:
        raise ModelError(
            f"Path joint '{joint.name}' has no single displacement for {title} to act along. Act between two points, "
            f"or by s.generalized_force on its coordinate."
        )
    kinds = joint.primitives
    there = isinstance(index, int) and 0 <= index < len(kinds)
    if not kinds[index if there else 0].displaces:
        raise ModelError(
            f"{joint.type[0].upper()}{joint.type[1:]} '{joint.name}' has no single displacement for {title} to act "
            "along. Act between two points, or by a torque on the body; the turn of a ball or free joint has "
            "s.torsion_spring and s.damper, and s.bushing acts in all directions."
        )
    if not there:
        raise ModelError(
            f"Joint '{joint.name}' has {len(kinds)} displacements (0 to {len(kinds) - 1}), got {shown(index)} for "
            f"{title}."
        )
