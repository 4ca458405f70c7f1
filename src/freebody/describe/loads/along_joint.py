"""What loads along one displacement of a joint have in common."""

from __future__ import annotations

from typing import Any

from ..joints.joint import Joint
from .displacement import check_displacement
from .load import Load


class AlongJoint(Load):
    """A load along the displacement ``index`` of a joint; each kind has that field as its last one."""

    joint: Joint

    words = {"index": "coordinate"}

    def check(self) -> None:
        """Refuse a displacement that the joint does not have."""
        part: Any = self
        check_displacement(self.joint, part.index, self.title)
