"""Every numbered equation of the chapter, (6.1)-(6.125), and every lettered one of its examples, with a verdict.

    >>> from freebody.chapter import statements
    >>> statements()["6.30"].finding.verdict
    'holds'

Nothing is written down but the prints: what is right is derived by the library each time it is asked for.
"""

from __future__ import annotations

import re

from ..errors import ModelError, nearest
from .statement import Finding, Statement

__all__ = ["Finding", "Statement", "find", "statements"]


def statements() -> dict[str, Statement]:
    """All statements by number, those of the examples after the numbered ones of their section."""
    from . import examples, fixed_axis, gyroscope, momentum, motion, planar, precession, systems, torque_free

    found: dict[str, Statement] = {}
    for room in (momentum, motion, planar, examples, fixed_axis, systems, torque_free, gyroscope, precession):
        found.update({statement.number: statement for statement in room.STATEMENTS})
    return found


def find(asked: str) -> list[Statement]:
    """The statements that a number stands for: ``6.66``, ``6.34`` (both its parts), ``ex-6-1 (d)``, ``ex-6-1``.

    Raises
    ------
    ModelError
        A number that the chapter does not have, with the nearest that it has.
    """
    known = statements()
    wanted = _plain(asked)
    exact = [s for number, s in known.items() if _plain(number) == wanted]
    parts = [s for number, s in known.items() if re.fullmatch(re.escape(wanted) + "[a-z]", _plain(number))]
    if not exact and not parts:
        raise ModelError(
            f"Expected the number of an equation of the chapter, 6.1 to 6.125, or of an example such as "
            f"'ex-6-1 (d)', got '{asked}'; {nearest(asked, known, 'freebody chapter')}"
        )
    return exact or parts


def _plain(number: str) -> str:
    return re.sub(r"[\s()]|^eq\.?", "", number.lower())
