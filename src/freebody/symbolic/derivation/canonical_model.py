"""A model in canonical polynomials: its ring and its state, and polynomials as SymPy expressions."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Any

import sympy

from ...dynamics.state import State, polynomial_state
from ...model.model import Model
from ...scalar.algebra import Scalar
from ...scalar.polynomial import Ring
from ..printing.display import displayed
from .contact_modes import modes_in_words

CURE = (
    "Ask for fb.equations(s, form='recursive'), which names the long expressions, or for numbers: "
    "fb.simulate, fb.compile."
)


class CanonicalModel:
    """Ring of a model's canonical polynomials, its state in the ring, and the SymPy forms of polynomials.

    Attributes
    ----------
    model : Model
    ring : Ring
        Ring of all canonical polynomials of the model.
    state : State
        Coordinates, speeds, time and parameters as elements of the ring.
    udot : tuple of Polynomial
        Rates u' of the speeds, symbols of the ring.
    chosen : str
        How the modes of the contacts were chosen; empty if the user gave them.
    """

    def __init__(self, model: Model, chosen: str = "") -> None:
        self.model = model
        self.chosen = chosen
        # room for every symbol, sine and cosine from the start: growing a ring re-packs its elements
        self.ring = Ring(capacity=64 + len(model.parameters) + 6 * model.n_q)
        self.ring.budget.subject, self.ring.budget.cure = f"the equations of '{model.name}'", CURE
        self.state: State = polynomial_state(model, self.ring)
        self.udot = tuple(self.ring.generator(speed.acceleration, "acceleration") for speed in model.speeds)

    def question(self, subject: str) -> AbstractContextManager[None]:
        """Return a context with its own budget, whose refusals name ``subject``."""
        return self.ring.budget.question(f"{subject} of '{self.model.name}'", CURE)

    # -- SymPy at the edge ------------------------------------------------------------------------

    def sympy(self, x: Scalar) -> Any:
        """Return a canonical polynomial as an expanded SymPy expression."""
        return self.ring.to_sympy(x)

    def displayed(self, x: Scalar) -> Any:
        """Return a canonical polynomial as a SymPy expression, grouped as it is printed."""
        return displayed(x, self.ring)

    def column(self, v: Sequence[Scalar]) -> Any:
        """Return canonical polynomials, such as the components of a vector, as a SymPy column."""
        return sympy.ImmutableMatrix([self.displayed(c) for c in v])

    @property
    def heading(self) -> list[str]:
        """Line that names the modes of the contacts; no line if the user gave them. Families have one of their own."""
        if self.model.families:
            names = " and ".join(f"'{family.name}'" for family in self.model.families)
            return [f"Contacts of the family {names}: left out, since only a motion has them"]
        if not self.chosen:
            return []
        return [f"Contacts: {modes_in_words(self.model)} ({self.chosen})"]
