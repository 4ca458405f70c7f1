"""The symbols of a part of a machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import sympy

from ..describe.body import Body
from ..describe.frame import Point
from ..describe.joints.joint import Joint


def symbols_of(part: Any) -> set[Any]:
    """Symbols of the expressions in a part of a model, such as its links, loads or contacts.

    A body has no symbols here: its mass is counted with its link.
    """
    if isinstance(part, sympy.Basic):
        return set(part.free_symbols)
    if isinstance(part, Mapping):
        return symbols_of(list(part.values()))
    if isinstance(part, list | tuple):
        return set().union(*map(symbols_of, part)) if part else set()
    if isinstance(part, Body):
        return set()
    if isinstance(part, Point):
        return symbols_of(list(part.components))
    if isinstance(part, Joint):
        return symbols_of([part.at, part.to])
    if is_dataclass(part):
        return set().union(*(symbols_of(getattr(part, field.name)) for field in fields(part)), set())
    return set()
