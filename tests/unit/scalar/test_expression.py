"""Values of expressions in a field."""

from __future__ import annotations

import math

import pytest
import sympy

from freebody.scalar.algebra import floats
from freebody.scalar.expression import evaluate


def test_exponentials_are_multiplied_by_their_exponents():
    """As canonical forms have them, one of them is beyond the greatest float."""
    x = sympy.Symbol("x", real=True)
    product = sympy.Mul(3, x, sympy.exp(800 * x, evaluate=False), sympy.exp(-799 * x), evaluate=False)
    assert len(product.args) == 4
    assert evaluate(product, {x: 1.0}, floats) == pytest.approx(3 * math.e, rel=1e-13)
