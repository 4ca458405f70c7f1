"""Answers in print: elements without speeds, accelerations and reactions, in their closed form."""

from __future__ import annotations

from typing import Any

from ....scalar.algebra import Scalar
from ....scalar.element import Polynomial
from ....scalar.polynomial import Ring
from ..arrange import MOVING
from ..printer import Printer
from .form import closed_form


def is_answer(x: Scalar) -> bool:
    """Return True for an element without speeds, accelerations and reactions."""
    return type(x) is Polynomial and not any(g.kind in MOVING for g in x.ring.used(x))


def answer(kind: type[Printer], x: Scalar, ring: Ring, below: Scalar = 1) -> Any:
    """Return ``x / below`` in its closed form, printed by a kind of printer; None if it is a number or too long."""
    form = closed_form(x, ring, below)
    return None if form is None else kind(form[1]).sum(form[0])


def shown(kind: type[Printer], x: Scalar, ring: Ring, closed: bool | None = None) -> Any:
    """Return an element or a number as printed: an answer in its closed form, all others arranged as equations are.

    ``closed`` prints the closed form in any case (True), or in none (False).
    """
    form = answer(kind, x, ring) if (is_answer(x) if closed is None else closed) else None
    return kind(ring).show(x) if form is None else form


def closed(kind: type[Printer], x: Scalar, ring: Ring) -> Any:
    """Return an element or a number in its closed form; see `shown`."""
    return shown(kind, x, ring, closed=True)
