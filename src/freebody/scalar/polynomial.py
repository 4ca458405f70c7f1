"""Exact canonical expressions on FLINT: polynomials modulo the relations of their generators.

>>> import sympy
>>> from freebody.scalar.polynomial import Ring
>>> m, M, q = sympy.symbols("m M q")
>>> ring = Ring()
>>> x = ring.from_sympy(m * sympy.sin(q) ** 2 + m * sympy.cos(q) ** 2)
>>> x == ring.generator(m)
True
>>> ring.from_sympy((m**2 - M**2) / (m + M)).to_sympy()
-M + m

`Ring` makes elements (`ring`), `Polynomial` is an element (`element`), `relations` keeps elements canonical,
`functions` turns sines, roots and opaque functions into generators.
"""

from .element import Polynomial as Polynomial
from .ring import Generator as Generator
from .ring import Ring as Ring

__all__ = ["Generator", "Polynomial", "Ring"]
