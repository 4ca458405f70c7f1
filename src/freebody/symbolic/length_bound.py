"""How long equations of motion are when they are written out: a bound, found without writing them.

The algorithm runs on numbers of terms: a product of a and b terms has at most a b, a sum at most a + b. What cancels,
and what sin² + cos² = 1 joins, is not seen, so that the bound lies above, the further the longer the machine.
"""

from __future__ import annotations

from typing import Any

from ..dynamics.newton_euler import inverse_dynamics
from ..dynamics.state import State
from ..model.model import Model
from ..scalar.algebra import Field


class Terms:
    """A number of terms in place of what has them."""

    __slots__ = ("n",)

    def __init__(self, n: int) -> None:
        self.n = n

    def __add__(self, other: Any) -> Terms:
        return self if type(other) is not Terms and other == 0 else Terms(self.n + _terms(other))

    __radd__ = __sub__ = __rsub__ = __add__

    def __mul__(self, other: Any) -> Any:
        return Terms(self.n * other.n) if type(other) is Terms else 0 if other == 0 else self

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Terms:
        return self

    def __rtruediv__(self, other: Any) -> Any:
        return 0 if other == 0 else Terms(1)

    def __pow__(self, exponent: Any) -> Terms:
        return Terms(self.n ** abs(exponent)) if isinstance(exponent, int) else Terms(1)

    __rpow__ = __rtruediv__

    def __neg__(self) -> Terms:
        return self


def _terms(x: Any) -> int:
    return x.n if type(x) is Terms else 1


class Lengths(Field):
    """The field of numbers of terms."""

    def constant(self, value: Any) -> Terms:
        return Terms(1)

    def apply(self, function: str, *arguments: Any) -> Terms:
        """A function is one generator, but sine and cosine of a sum of n angles have 2^(n - 1) terms."""
        n = _terms(arguments[0])
        return Terms(2 ** min(n - 1, 1000) if function in ("sin", "cos") else 1)


def most_terms(model: Model) -> int:
    """Most terms that the equations of motion have when they are written out."""
    one = Terms(1)
    values = {parameter.symbol: one for parameter in model.parameters}
    state = State(model, Lengths(), one, [one] * model.n_q, [one] * model.n_u, values)
    return sum(map(_terms, inverse_dynamics(model, state, [one] * model.n_u)))
