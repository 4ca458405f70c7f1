"""The contacts of a machine as numbers at one moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ..ode.dense_output import Array


@dataclass(frozen=True)
class Snapshot:
    """The contacts at one moment: E elements, m rows in the order of :func:`contact_layout`.

    ``c`` are the derivatives of the rates without contact forces, ``free`` the accelerations u' so, ``matrix`` is W,
    and ``responses`` the change of u' per unit of each contact force. ``away`` are the least rates of reaches that are
    zero.
    """

    gap: Array
    reach: Array
    rate: Array
    c: Array
    free: Array
    matrix: Array
    responses: Array
    friction: Array
    static: Array
    restitution: Array
    away: Array

    @cached_property
    def A(self) -> Array:
        """A = W M⁻¹ Wᵀ, rates per unit of each force; symmetric."""
        return self.between(range(len(self.rate)))

    def between(self, rows: Sequence[int]) -> Array:
        """Return the rows and columns of A."""
        chosen = list(rows)
        return self.matrix[chosen] @ self.responses[chosen].T
