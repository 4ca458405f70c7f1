"""Poses of elements of a URDF file, and right angles in them.

Source: the XML specification of URDF (ROS wiki, urdf/XML), and what its reference reader (urdfdom) accepts.
"""

from __future__ import annotations

import math
import re
from typing import Any

from ...space.pose import Pose
from ...space.rotation import Rotation
from ..builder import whole
from ..reading import Reading
from ..xml_tree import Element

DECIMALS = 10
"""Decimals with which a multiple of a right angle must be written to be taken as one."""
RIGHT = math.pi / 2


def pose_of(element: Element, reading: Reading | None = None) -> Pose:
    """Return the pose of the element's <origin>; ``reading`` counts the angles that are taken as others."""
    origin = element.first("origin")
    if origin is None:
        return Pose()
    x, y, z = map(whole, origin.numbers("xyz", 3, (0.0, 0.0, 0.0)))
    words = origin.attributes.get("rpy", "0 0 0").replace(",", " ").split()
    angles = origin.numbers("rpy", 3, (0.0, 0.0, 0.0))
    turns = [_turn(word, angle) for word, angle in zip(words, angles, strict=True)]
    if reading is not None:
        reading.right_angles += sum(
            angle != 0 and exact for angle, (*_, exact) in zip(angles, turns, strict=True)
        )
    (cr, sr, _), (cp, sp, _), (cy, sy, _) = turns
    # R = Rz(yaw) Ry(pitch) Rx(roll)
    R = Rotation.trusted((
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    ))  # fmt: skip
    return Pose(R, (x, y, z))


def _turn(word: str, angle: float) -> tuple[Any, Any, bool]:
    """Return cosine and sine of an angle, and whether it is taken as a multiple of a right angle.

    It is if it is that multiple rounded to the decimals that are written, at least :data:`DECIMALS` of them.
    """
    decimals = re.fullmatch(r"[+-]?\d*\.(\d+)", word)
    count = round(angle / RIGHT)
    written = len(decimals[1]) if decimals else 0
    exact = angle == 0 or (written >= DECIMALS and abs(angle - count * RIGHT) <= 10.0**-written)
    if exact:
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[count % 4]
        return c, s, True
    return math.cos(angle), math.sin(angle), False
