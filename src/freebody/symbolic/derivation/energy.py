"""Kinetic and potential energy of a machine, as formulas."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import sympy

from ...dynamics.energy import kinetic_energy, potential_energy
from ...scalar.algebra import Scalar
from ..printing.display import Formulas
from .canonical_model import CanonicalModel
from .questions import named


class Energy(Formulas):
    """Kinetic and potential energy [J]."""

    def __init__(self, e: CanonicalModel) -> None:
        self._e = e

    @cached_property
    @named("the kinetic energy")
    def canonical_kinetic(self) -> Scalar:
        """T as a canonical polynomial."""
        return kinetic_energy(self._e.model, self._e.state)

    @cached_property
    @named("the potential energy")
    def canonical_potential(self) -> Scalar:
        """V as a canonical polynomial."""
        return potential_energy(self._e.model, self._e.state)

    @cached_property
    @named("the kinetic energy")
    def kinetic(self) -> Any:
        """T = ½ Σ (m v_C² + ω·H_C) as a SymPy expression."""
        return self._e.displayed(self.canonical_kinetic)

    @cached_property
    @named("the potential energy")
    def potential(self) -> Any:
        """V of weight (zero at the ground's origin) and springs (zero when free of force) as a SymPy expression."""
        return self._e.displayed(self.canonical_potential)

    def _lines(self, show: Any) -> list[str]:
        ring = self._e.ring
        letters = ("T", "V")
        if any(letter in self._e.model.names.kinds for letter in letters):
            letters = ("kinetic", "potential")
        T, V = (ring.generator(sympy.Symbol(letter, real=True), "parameter") for letter in letters)
        return [show(T, self.canonical_kinetic, ring), show(V, self.canonical_potential, ring)]
