"""The two ends of a straight load."""

from __future__ import annotations

from ...errors import ModelError
from ..frame import Point


def check_ends(start: Point, end: Point, title: str) -> None:
    """Refuse two ends on one body."""
    if start.body is end.body:
        raise ModelError(
            f"Both ends of {title} are on '{start.body.name}', so it does nothing. Put one end on another body."
        )
