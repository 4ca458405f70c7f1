"""Text of numbers for people to read."""

from __future__ import annotations

from typing import Any


def significant(value: Any, digits: int = 6) -> str:
    """Text of a number with ``digits`` significant digits, of several numbers in a row, or of a word unchanged.

    >>> significant(0.1 + 0.2), significant(3), significant(True), significant((1.0, 2.5, -0.0))
    ('0.3', '3', 'yes', '1, 2.5, 0')
    >>> significant(((1, 2), (3, 4)))  # rows
    '1, 2; 3, 4'
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if hasattr(value, "tolist"):
        return significant(value.tolist(), digits)
    if isinstance(value, list | tuple):
        rows = any(isinstance(v, list | tuple) for v in value)
        return ("; " if rows else ", ").join(significant(v, digits) for v in value)
    try:
        return f"{float(value) + 0.0:.{digits}g}"
    except (TypeError, ValueError):
        return str(value).replace("**", "^")
