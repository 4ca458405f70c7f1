"""Inputs of linear equations that have a response in closed form: sums of t^k e^(a t) (p cos(w t) + q sin(w t))."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy
from sympy.simplify.fu import TR8

from ...errors import ModelError

T = sympy.Symbol("t")


@dataclass(frozen=True)
class Term:
    """t^power e^(growth t) (cosine cos(frequency t) + sine sin(frequency t))."""

    cosine: Any
    sine: Any
    power: int
    growth: Any
    frequency: Any

    def numbers(self) -> tuple[complex, complex]:
        """(c, s) with the term = Re c t^power e^(s t)."""
        parts = []
        for x in (self.cosine, self.sine, self.growth, self.frequency):
            if x.free_symbols:
                unknown = ", ".join(sorted(map(str, x.free_symbols)))
                raise ModelError(
                    f"Expected numbers in the forcing of a numeric model, but '{x}' holds {unknown}. Put a number, or "
                    "leave out values= for a symbolic result."
                )
            parts.append(float(x))
        return complex(parts[0], -parts[1]), complex(parts[2], parts[3])


def terms_of(expression: Any, name: str) -> list[Term]:
    """Return the terms of an expression of t; ``name`` is its input, for messages.

    Raises
    ------
    ModelError
        The expression has another form.
    """
    expanded = sympy.expand(TR8(sympy.expand(sympy.sympify(expression))))
    return [_term(part, name) for part in sympy.Add.make_args(expanded) if part != 0]


def _term(part: Any, name: str) -> Term:
    amplitude, of_time = part.as_independent(T, as_Add=False)
    zero = sympy.Integer(0)
    cosine, sine, growth, frequency, power = amplitude, zero, zero, zero, 0
    for factor in sympy.Mul.make_args(of_time):
        if factor == 1:
            continue
        base, exponent = factor.as_base_exp()
        if base == T and exponent.is_Integer and exponent > 0:
            power += int(exponent)
            continue
        if factor.func is sympy.exp:
            slope, offset = _linear(factor.args[0], name)
            growth = growth + slope
            cosine, sine = cosine * sympy.exp(offset), sine * sympy.exp(offset)
            continue
        if factor.func in (sympy.cos, sympy.sin) and frequency == 0:
            slope, offset = _linear(factor.args[0], name)
            frequency = slope
            c, s = sympy.cos(offset), sympy.sin(offset)
            cosine, sine = (cosine * c, -cosine * s) if factor.func is sympy.cos else (cosine * s, cosine * c)
            continue
        raise _refused(factor, name)
    return Term(cosine, sine, power, growth, frequency)


def _linear(argument: Any, name: str) -> tuple[Any, Any]:
    poly = sympy.Poly(argument, T) if argument.is_polynomial(T) else None
    if poly is None or poly.degree() > 1:
        raise _refused(argument, name)
    return poly.coeff_monomial(T), poly.coeff_monomial(1)


def _refused(part: Any, name: str) -> ModelError:
    return ModelError(
        f"Expected the input '{name}' to be a sum of terms t^k e^(a t) cos(w t) or sin(w t), but it holds '{part}'. "
        "Simulate the linear equations for other inputs: model.state_space().to_scipy()."
    )
