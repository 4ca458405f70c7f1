"""Quantities of contacts that functions of the user may take: what they are in each mode. It needs no compiler.

They are 0 where the mode makes them so, without round-off: the gap of a closed contact, the force of an open one, the
slip of one that sticks, the margin of one that slips.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ...dynamics import State
from ...scalar.algebra import Scalar
from .kernels import Kernels
from .program import Program
from .sides import SidedKernels, laws_of, unsided
from .switches import value_of

NAMES = ("gap", "approach", "normal", "tangential", "slip", "margin")
"""Names of quantities, in the order of their numbers."""
GAP, APPROACH, NORMAL, TANGENTIAL, SLIP, MARGIN = range(6)


@dataclass(frozen=True)
class OfContacts:
    """An expression of quantities of contacts, for which symbols stand in it, such as ``floor.normal - 50``.

    ``quantities``    for each symbol: contacts over which a quantity is summed, the quantity and its component
    """

    text: str
    expression: Any
    quantities: Mapping[Any, tuple[tuple[str, str, int], ...]] = field(hash=False)

    def __str__(self) -> str:
        return self.text

    def value(self, state: State, numbers: Mapping[Any, Scalar]) -> Scalar:
        """Return its value where its quantities have these ``numbers``."""
        own = {symbol: numbers[quantity] for symbol, quantity in self.quantities.items()}
        return state.with_values(self.expression, own)


Asked = tuple[tuple[tuple[str, str, int], ...], ...]
"""Quantities, each a sum over contacts: their name, the quantity and its component."""


def asked_by(expressions: Sequence[Any]) -> Asked:
    """Return the quantities that functions of the user take."""
    return tuple(
        dict.fromkeys(
            quantity for x in expressions if isinstance(x, OfContacts) for quantity in x.quantities.values()
        )
    )


def watched_program(kernels: Kernels, expressions: Sequence[Any], asked: Asked = ()) -> Program:
    """Return the program of functions of the user, whose state the quantities of contacts follow that are ``asked``.

    Behind them stand the e of all laws that have sides. `laws_watched` says which functions are the e of a law.
    """
    sided = isinstance(kernels, SidedKernels)
    if not asked and not sided:
        return kernels.expressions(expressions)

    def functions(state: Any, numbers: Sequence[Any] = ()) -> Mapping[str, Sequence[Any]]:
        of = dict(zip(asked, numbers, strict=True))
        e, state = laws_of(state), unsided(state)  # what is observed switches by itself
        own = [x.value(state, of) if isinstance(x, OfContacts) else value_of(state, x) for x in expressions]
        kernels.cache["laws watched", tuple(expressions)] = [
            next((k for k, law in enumerate(e) if x is law or x is -law), -1) for x in own
        ]
        return {"values": [*own, *e]}

    return kernels.program(("watched", tuple(expressions), asked), functions, len(asked))


def laws_watched(kernels: Kernels, expressions: Sequence[Any]) -> list[int]:
    """Return for each function of a `watched_program` the law whose e it is, or -1."""
    watched_program(kernels, expressions)
    result: list[int] = kernels.cache.get(("laws watched", tuple(expressions)), [-1] * len(expressions))
    return result
