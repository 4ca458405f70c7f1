"""Free body in named quantities: for a body far out on a machine, whose motion written out fills pages.

Rotations, positions, velocities and accelerations of the links are named one after the other, outward from the ground
(:mod:`freebody.symbolic.recursive`), and the balance of the body is written with these names, in ground axes.
"""

from __future__ import annotations

from functools import cached_property

from ...model.model import Model
from ...space.spatial import Spatial
from ..derivation.derivation import Derivation
from ..printing.printer import Printer
from ..recursive import NamedMotion


class NamedDerivation(Derivation):
    """Derivation whose quantities of links are names."""

    def __init__(self, model: Model, chosen: str = "") -> None:
        self.model, self.chosen = model, chosen
        self._names = NamedMotion(model)
        self.ring, self.udot = self._names.ring, self._names.udot
        self.state = self._names.place()

    @cached_property
    def accelerations(self) -> list[Spatial]:
        """(angular acceleration, acceleration of the origin) of every link in its own axes, in names."""
        return self._names.accelerations()

    def meanings(self, elements: list[object], kind: type[Printer], sign: str) -> list[tuple[str, list[str]]]:
        """Return (heading, lines) of the names that elements need."""
        used = self._names.names.used_by(elements)
        return list(self._names.written(kind, sign, self._names.meanings(used)))
