"""Every numbered equation of the chapter, (6.1)-(6.125), and every lettered equation of its examples, with a verdict.

    >>> from freebody.chapter import statements
    >>> statements()["6.30"].finding.verdict
    'holds'

Only the printed equations are stored; the library derives the correct result and the verdict on every call.
"""

from __future__ import annotations

import re

from ..errors import ModelError, nearest
from .statement import Finding, Statement

__all__ = ["Finding", "Statement", "find", "statements"]


def statements() -> dict[str, Statement]:
    """Return all statements by number; the examples follow the numbered equations of their section."""
    from . import examples, fixed_axis, gyroscope, momentum, motion, planar, precession, systems, torque_free

    result: dict[str, Statement] = {}
    for room in (momentum, motion, planar, examples, fixed_axis, systems, torque_free, gyroscope, precession):
        result.update({statement.number: statement for statement in room.STATEMENTS})
    return result


def find(asked: str) -> list[Statement]:
    """Return the statements of a number: ``6.66``, ``6.34`` (both its parts), ``ex-6-1 (d)``, ``ex-6-1``.

    Raises
    ------
    ModelError
        The chapter has no such number; the message names the nearest one.
    """
    available = statements()
    plain = _plain(asked)
    exact = [s for number, s in available.items() if _plain(number) == plain]
    parts = [s for number, s in available.items() if re.fullmatch(re.escape(plain) + "[a-z]", _plain(number))]
    if not exact and not parts:
        raise ModelError(
            f"Expected the number of an equation of the chapter, 6.1 to 6.125, or of an example such as "
            f"'ex-6-1 (d)', got '{asked}'; {nearest(asked, available, 'freebody chapter')}"
        )
    return exact or parts


def _plain(number: str) -> str:
    return re.sub(r"[\s()]|^eq\.?", "", number.lower())
