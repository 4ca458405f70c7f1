"""What the names of a print mean: what the library gives for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy

from .notation import Node
from .small import Small


@dataclass(frozen=True)
class Meaning:
    """What the library gives for the names of a print.

    Attributes
    ----------
    names : mapping
        A SymPy expression, or a column for a vector.
    elements : sequence of (mass, names), or function
        Elements of mass to be summed for ∫ dm; or what integrates a function of its element over the body.
    loads : sequence of names
        Forces dF with their places, to be summed for ∫ dF.
    along : pairs
        Put into every difference: what holds along a motion, as its accelerations.
    steady : pairs
        The state at which rates of what is constant are taken, their rates too.
    rows : mapping from a print's place to (left, right)
        Where a print is a balance that the library states itself, this: only a number may stand between the two.
    positive : expression
        Where a print is an inequality: what the library finds to be positive.
    small : Small
        Where a print is an approximation.
    units : triple
        Names of the unit vectors that components of columns go with, for right forms.
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
        """∫ of a print: a sum over the elements of mass, or over the loads."""
        inside = lambda element: value(node.parts[0], self, element) if node.parts else sympy.Integer(1)  # noqa: E731
        if callable(self.elements) and node.value:
            return self.elements(inside)
        weighted = self.elements if node.value else [(1, load) for load in self.loads]
        terms = [weight * inside(element) for weight, element in weighted]
        total = terms[0]
        for term in terms[1:]:
            total = total + term
        return total
