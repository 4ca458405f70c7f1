"""Free-body equations with values for some of the coordinates, speeds, accelerations and reactions.

While contacts are closed, some coordinates are constant. With their values, the directions of N and T are short; the
general directions hold for any configuration and are long.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property

import sympy

from ...errors import ModelError, nearest
from ...scalar.algebra import ZERO, Expression, Vector
from ...scalar.substitute import Substitution
from .action import Action
from .free_body import FreeBody


class FreeBodyAt(FreeBody):
    """A free body at given values. Made by :meth:`FreeBody.at`."""

    def __init__(self, whole: FreeBody, values: Mapping[str, Expression]) -> None:
        e = whole._e
        super().__init__(e, whole.body)
        self._about, self.about, self.frame, self._axes = whole._about, whole.about, whole.frame, whole._axes
        atoms = {str(name): atom for name, atom in e.model.names.atoms.items()}
        for speed in e.model.speeds:
            atoms[speed.name + "'"] = speed.acceleration
        atoms |= {symbol.name: symbol for symbol in whole.unknowns}
        for name in values:
            if name not in atoms:
                raise ModelError(
                    f"Unknown coordinate, speed or reaction '{name}'; {nearest(name, list(atoms))}"
                )
        substituted = {atoms[name]: e.ring.from_sympy(sympy.sympify(value)) for name, value in values.items()}
        self._substitution = Substitution(e.ring, e.ring, substituted)

    def _at(self, v: Vector) -> Vector:
        x, y, z = (self._substitution(c) for c in v)
        return (x, y, z)

    @cached_property
    def actions(self) -> tuple[Action, ...]:
        """Every force and couple on the body, by name."""
        actions = (
            replace(a, force=self._at(a.force), moment=self._at(a.moment), at=self._at(a.at))
            for a in super().actions
        )
        return tuple(a for a in actions if (a.force, a.moment) != (ZERO, ZERO))

    @cached_property
    def mass_acceleration(self) -> Vector:
        """m a_C in the axes of the components [N], canonical."""
        return self._at(super().mass_acceleration)

    @cached_property
    def momentum_rate(self) -> Vector:
        """dH_C/dt + r_PC × m a_C about the point P of the moments [N m], canonical."""
        return self._at(super().momentum_rate)

    @cached_property
    def force_sum(self) -> Vector:
        """Σ F in the axes of the components [N], canonical."""
        return self._at(super().force_sum)

    @cached_property
    def moment_sum(self) -> Vector:
        """Σ M about the point P of the moments [N m], canonical."""
        return self._at(super().moment_sum)
