"""Upper bound of the length of the equations of motion in explicit form, without forming them.

The algorithm runs on numbers of terms: a product of a and b terms has at most a b terms, a sum at most a + b.
Cancellation and sin² + cos² = 1 are not considered, so the bound is too high, and more so for longer machines.
"""

from __future__ import annotations

from typing import Any

from ..dynamics.newton_euler import inverse_dynamics
from ..dynamics.state import State
from ..model.model import Model
from ..scalar.algebra import Field, FieldVector, Scalar


class Terms:
    """Number of terms of an expression, in place of the expression."""

    __slots__ = ("n",)

    def __init__(self, n: int) -> None:
        self.n = n

    def __add__(self, other: Scalar) -> Terms:
        return self if type(other) is not Terms and other == 0 else Terms(self.n + _terms(other))

    __radd__ = __sub__ = __rsub__ = __add__

    def __mul__(self, other: Scalar) -> Scalar:
        if type(other) is FieldVector:
            return NotImplemented
        return Terms(self.n * other.n) if type(other) is Terms else 0 if other == 0 else self

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Terms:
        return self

    def __rtruediv__(self, other: Scalar) -> Scalar:
        return 0 if other == 0 else Terms(1)

    def __pow__(self, exponent: Scalar) -> Terms:
        return Terms(self.n ** abs(exponent)) if isinstance(exponent, int) else Terms(1)

    __rpow__ = __rtruediv__

    def __neg__(self) -> Terms:
        return self


def _terms(x: Scalar) -> int:
    return x.n if type(x) is Terms else 1


class Lengths(Field):
    """Field whose scalars are numbers of terms."""

    def constant(self, value: Any) -> Terms:
        """Return one term."""
        return Terms(1)

    def apply(self, function: str, *arguments: Scalar) -> Terms:
        """Return the terms of a function: 2^(n - 1) for sine and cosine of a sum of n angles, else 1."""
        n = _terms(arguments[0])
        return Terms(2 ** min(n - 1, 1000) if function in ("sin", "cos") else 1)


def most_terms(model: Model) -> int:
    """Return an upper bound of the number of terms of all equations of motion in explicit form."""
    symbol = Terms(1)
    values = {parameter.symbol: symbol for parameter in model.parameters}
    state = State(model, Lengths(), symbol, [symbol] * model.n_q, [symbol] * model.n_u, values)
    return sum(map(_terms, inverse_dynamics(model, state, [symbol] * model.n_u)))
