"""Expressions of the user, parsed once: a repeated call of `simulate` names the same events and times.

Parsing one text takes as long as ten steps of a small machine. The meaning of a text, or of a SymPy expression, changes
only with the names of its system, which are never renamed: their number is part of the key.
"""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

import sympy

from ...describe.names import Names
from ...model import Model
from ...scalar.algebra import Expression

_MOST = 256
_parsed: WeakKeyDictionary[Names, dict[Any, Any]] = WeakKeyDictionary()


def expression_of(model: Model, value: Expression, what: str) -> Any:
    """Return ``model.names.expression(value, what)``, parsed once."""
    names = model.names
    if type(value) is not str and not isinstance(value, sympy.Basic):
        return names.expression(value, what)
    key = type(value), value, len(names.kinds)
    known = _parsed.setdefault(names, {})
    if key not in known:
        if len(known) >= _MOST:
            known.clear()
        known[key] = names.expression(value, what)
    return known[key]
