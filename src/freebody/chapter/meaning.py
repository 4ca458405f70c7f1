"""The meaning of the names in a print: the library's values for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy

from .notation import Node
from .small import Small


@dataclass(frozen=True)
class Meaning:
    """The library's values for the names of a print.

    Attributes
    ----------
    names : mapping
        A SymPy expression for each name, or a column for a vector.
    elements : sequence of (mass, names), or function
        Elements of mass to be summed for ∫ dm; or a function that integrates a function of its element over the body.
    loads : sequence of names
        Forces dF with their places, to be summed for ∫ dF.
    along : pairs
        Substitutions for every difference: relations that hold along a motion, such as its accelerations.
    steady : pairs
        The state at which the rates of a constant, and the rates of those rates, are taken.
    rows : mapping from a print's place to (left, right)
        If a print is a balance that the library also states, the library's balance: they may differ by a number only.
    positive : expression
        If a print is an inequality: the expression that the library finds to be positive.
    small : Small
        If a print is an approximation: its small quantity.
    units : triple
        Names of the unit vectors of the components of columns, for corrected forms.
    """

    names: Mapping[str, Any]
    elements: Any = ()
    loads: Sequence[Mapping[str, Any]] = ()
    along: Sequence[tuple[Any, Any]] = ()
    steady: Sequence[tuple[Any, Any]] = ()
    rows: Mapping[int, tuple[Any, Any]] = field(default_factory=dict)
    positive: Any = None
    small: Small | None = None
    units: tuple[str, str, str] = ("i", "j", "k")
    time: Any = sympy.Symbol("t")

    def integral(self, node: Node, value: Any) -> Any:
        """Return the value of an integral of a print: a sum over the elements of mass, or over the loads."""
        inside = lambda element: value(node.parts[0], self, element) if node.parts else sympy.Integer(1)  # noqa: E731
        if callable(self.elements) and node.value:
            return self.elements(inside)
        weighted = self.elements if node.value else [(1, load) for load in self.loads]
        terms = [weight * inside(element) for weight, element in weighted]
        total = terms[0]
        for term in terms[1:]:
            total = total + term
        return total
