"""Random places of a machine: values of its state at which the results of an algorithm are numbers.

They are whole numbers modulo a prime, or rational numbers beside the symbols of the machine. Sines and cosines are
points of the circle x² + y² = 1, quaternions are points of the sphere, and roots are roots modulo the prime.
"""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

from flint import nmod

from ...dynamics.state import State
from ...errors import ModelError
from ...scalar.algebra import Matrix, Scalar, Vector, divide
from ...scalar.polynomial import Ring
from ...space.spatial import Spatial
from ..derivation.canonical_model import CanonicalModel

SMALL = (0, 0, 0, 1, -1, 2, -2, Fraction(1, 2), Fraction(-1, 3))
"""Random numbers beside symbols: results are short if many of these are zero."""


class NoRootError(Exception):
    """A number has no square root modulo the prime."""


class Place:
    """A random place: the values there of the elements of a ring.

    They are numbers modulo a ``prime``, where what depends on parameters alone has the values ``machine``, which
    several places share. Without a prime they are exact, and what depends on parameters alone keeps its symbols.
    """

    def __init__(
        self, canonical: CanonicalModel, seed: int, prime: int = 0, machine: dict[int, Any] | None = None
    ) -> None:
        self.ring: Ring = canonical.ring
        self.random, self.model = random.Random(seed), canonical.model
        self.prime, self.machine = prime, {} if machine is None else machine
        self.values: dict[int, Any] = dict(self.machine)
        for i in self.model.quaternions:
            quaternion = canonical.state.q[i : i + 4]
            for x, value in zip(quaternion, self._unit_quaternion(), strict=True):
                self.values[self.ring.used(x)[0].index] = value

    def __call__(self, x: Scalar) -> Any:
        """Value of an element or of a number."""
        if not hasattr(x, "ring"):
            return self._constant(x)
        total: Any = 0
        for monomial, c in x.terms():
            term: Any = c
            for index, e in monomial:
                if index not in self.values:
                    self._choose(index)
                term = self.values[index] ** e * term
            total = total + term
        return self._constant(total) / x.den if self.prime else divide(total, x.den)

    def _constant(self, x: Any) -> Any:
        if not self.prime or isinstance(x, nmod):
            return x
        x = Fraction(x)
        return nmod(x.numerator, self.prime) / nmod(x.denominator, self.prime)

    def _number(self) -> Any:
        if self.prime:
            return nmod(self.random.randrange(1, self.prime), self.prime)
        return self.random.choice(SMALL)

    def _unit_quaternion(self) -> list[Any]:
        """Return p p / |p|² of a random p, whose components need no root."""
        a, b, c, d = 1 if not self.prime else self._number(), *(self._number() for _ in range(3))
        square = a * a + b * b + c * c + d * d
        whole = a * a - b * b - c * c - d * d
        return [divide(whole, square), *(divide(2 * a * x, square) for x in (b, c, d))]

    def _choose(self, index: int) -> None:
        """Set the value of a generator, and that of its partner."""
        g = self.ring.generators[index]
        constant = all(atom.kind in ("parameter", "constant") for atom in self.ring.of_mask(g.depends))
        if constant and not self.prime:
            self.values[index] = self.ring.variable(index)
            return
        if g.kind in ("sin", "cos", "sinh", "cosh"):
            t = self._number()
            square = t * t if g.kind in ("sinh", "cosh") else -t * t
            odd, even = divide(2 * t, 1 - square), divide(1 + square, 1 - square)
            first = g.kind in ("sin", "sinh")
            self.values[index] = odd if first else even
            self.values[g.partner] = even if first else odd
        elif g.kind == "inverse":
            self.values[index] = divide(1, self(g.arguments[0]))
        elif g.kind == "sqrt":
            self.values[index] = self._root(g, constant)
        else:
            self.values[index] = self._number()
        if constant:
            self.machine.update({i: self.values[i] for i in (index, g.partner) if i >= 0})

    def _root(self, g: Any, constant: bool) -> Any:
        """Square root modulo a prime p = 4 n + 3: a^(n + 1), if a^(2 n + 1) is 1."""
        if not self.prime:
            raise ModelError(
                f"Expected places and displacements of '{self.model.name}' without roots of coordinates for its base "
                f"parameters, got {self.ring.to_sympy(self.ring.variable(g.index))}."
            )
        a = self(g.arguments[0])
        if a ** ((self.prime - 1) // 2) != 1:
            raise NoRootError(constant)
        return a ** ((self.prime + 1) // 4)


class Placed(State):
    """A state at a place: that of the ring, evaluated."""

    def __init__(self, exact: State, at: Place) -> None:
        super().__init__(
            exact.model, exact.field, at(exact.t), [at(x) for x in exact.q], [at(x) for x in exact.u], {}
        )
        self._exact, self._at = exact, at

    def __call__(self, expression: Any) -> Scalar:
        """Value of an expression of the model's names."""
        return self._at(self._exact(expression))

    def joint(self, i: int) -> tuple[Matrix, Vector, Spatial]:
        """Pose and motion of a link, as :meth:`State.joint`."""
        if i not in self._joints:
            self._joints[i] = _each(self._exact.joint(i), self._at)
        return self._joints[i]


def _each(nested: Any, function: Any) -> Any:
    return tuple(_each(x, function) for x in nested) if isinstance(nested, tuple) else function(nested)
