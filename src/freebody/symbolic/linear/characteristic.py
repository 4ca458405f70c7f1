"""The characteristic polynomial of symbolic linear equations, and its roots in closed form.

    Δ(s) = det(M s² + C s + K) = c s^k Π f_i(s)^n_i

The determinant is formed and factored on canonical polynomials. Factors are solved if they are linear, quadratic or
biquadratic in s, or of degree three or four.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy

from ...errors import ExpressionError, ModelError
from ...scalar.algebra import Scalar
from ...scalar.element import element
from ...scalar.polynomial import Polynomial, Ring
from ..printing.closed.expressions import Expressions
from ..printing.display import displayed, text
from ..printing.lines import Result
from ..printing.rational import Rationals, S
from ..printing.show import latex_of
from ..printing.show import text_of as text_expression
from .modes import Mode, Modes

LARGEST = 8
"""Largest number of coordinates of a determinant in symbols; it has 2ⁿ minors."""


@dataclass(frozen=True)
class Factor:
    """A factor of the characteristic polynomial: its coefficients by rising powers of s, and how often it occurs."""

    element: Scalar
    coefficients: tuple[Scalar, ...]
    times: int

    @property
    def degree(self) -> int:
        """Degree in s."""
        return len(self.coefficients) - 1

    @property
    def even(self) -> bool:
        """True if only even powers of s occur."""
        return all(c == 0 for c in self.coefficients[1::2])


class Characteristic(Result):
    """det(M s² + C s + K), factored.

    Attributes
    ----------
    ring : Ring
    coefficients : tuple
        Canonical coefficients by rising powers of s.
    factors : tuple of Factor
        Factors that depend on s.
    """

    def __init__(self, ring: Ring, matrix: list[list[Scalar]], determinant: Scalar) -> None:
        self.ring = ring
        self.matrix = matrix
        self.determinant = determinant
        self.coefficients = coefficients(ring, determinant)

    @cached_property
    def factors(self) -> tuple[Factor, ...]:
        """Factors that depend on s, lowest degree first."""
        ring = self.ring
        result = []
        for f, times in ring.factor(cleared(ring, self.determinant))[1]:
            parts = coefficients(ring, f)
            if len(parts) > 1:
                result.append(Factor(f, parts, int(times)))
        return tuple(sorted(result, key=lambda f: (f.degree, text_of(ring, f))))

    @cached_property
    def expression(self) -> Any:
        """The polynomial as a SymPy expression of ``s``."""
        return sum(displayed(c, self.ring) * S**k for k, c in enumerate(self.coefficients))

    def text(self) -> str:
        """The polynomial as plain text."""
        return text_expression(self.expression)

    def latex(self) -> str:
        """The polynomial as LaTeX."""
        return latex_of(self.expression)

    def roots(self) -> list[Any]:
        """All roots, with repetitions."""
        return [s for f in self.factors for s in roots(self.ring, f) for _ in range(f.times)]

    def frequencies(self) -> Expressions:
        """|s| of each pair of roots: the square root of the product of the pair."""
        return self._of_pairs(0)

    def damping_ratios(self) -> Expressions:
        """-Re s / |s| of each pair of roots."""
        return self._of_pairs(1)

    def _of_pairs(self, k: int) -> Expressions:
        pairs = (pair for f in self.factors for pair in oscillations(self.ring, f) for _ in range(f.times))
        return Expressions((pair[k] for pair in pairs), self.ring)


def pencil(terms: Mapping[str, Any], n: int, carried: int) -> list[list[list[Scalar]]]:
    """Return P_0, P_1, P_2 of P_2 s² + P_1 s + P_0 = [M s² + C s + K, K_c; -E_ξ - E_r s, s - E_c] for (ξ, c)."""
    m = n + carried
    result = [[[0] * m for _ in range(m)] for _ in range(3)]
    for k, key in enumerate("KCM"):
        for i in range(n):
            result[k][i][:n] = terms[key][i]
    for i in range(n if carried else 0):
        result[0][i][n:] = terms["K_carried"][i]
    for i in range(carried):
        result[0][n + i] = [-x for x in terms["E"][i]]
        result[1][n + i][:n] = [-x for x in terms["E_rates"][i]]
        result[1][n + i][n + i] = 1
    return result


def of(ring: Ring, terms: Mapping[str, Any], n: int, carried: int = 0) -> Characteristic:
    """Return the characteristic polynomial of M s² + C s + K, extended by the carried deviations."""
    if n + carried > LARGEST:
        raise ModelError(
            f"The characteristic polynomial of {n + carried} coordinates in symbols is too large (at most {LARGEST}). "
            "Give numbers: model.numeric(values), or values= in fb.linearize."
        )
    s = ring.generator(S, "parameter")
    P = pencil(terms, n, carried)
    rows = [
        [P[2][i][j] * s * s + P[1][i][j] * s + P[0][i][j] for j in range(n + carried)]
        for i in range(n + carried)
    ]
    return Characteristic(ring, rows, determinant(ring, rows))


def determinant(ring: Ring, rows: Sequence[Sequence[Scalar]]) -> Polynomial:
    """Return the determinant by expansion in minors of the first rows, each formed once, without division."""
    minors: dict[int, Scalar] = {0: 1}
    n = len(rows)
    for row in rows:
        following: dict[int, Scalar] = {}
        for mask, minor in minors.items():
            for j in range(n):
                if mask >> j & 1 or row[j] == 0:
                    continue
                sign = -1 if (mask >> (j + 1)).bit_count() % 2 else 1
                term = row[j] * minor * sign
                key = mask | 1 << j
                following[key] = following[key] + term if key in following else term
        minors = following
    return ring.coerce(minors.get((1 << n) - 1, 0))


def cleared(ring: Ring, x: Scalar) -> Polynomial:
    """Return x times powers of its denominators: a polynomial without inverse generators and with the same roots."""
    x = ring.coerce(x)
    while True:
        inverses = [g for g in ring.used(x) if g.kind == "inverse"]
        if not inverses:
            return x
        g = inverses[-1]
        x = ring.coerce(x * g.arguments[0] ** int(x.num.degrees()[-1 - g.index]))


def coefficients(ring: Ring, x: Scalar) -> tuple[Scalar, ...]:
    """Return the canonical coefficients by rising powers of s."""
    x = ring.coerce(x)
    result: list[Scalar] = []
    factorial = 1
    s = ring.generator(S)
    while x != 0:
        constant = _without_s(ring, x, s.mask)
        result.append(ring.coerce(constant) / factorial if factorial > 1 and constant != 0 else constant)
        x = ring.derivative(x, S)
        factorial *= len(result)
    return tuple(result) or (0,)


def _without_s(ring: Ring, x: Scalar, mask: int) -> Scalar:
    if not isinstance(x, Polynomial):
        return x
    name = f"g{mask.bit_length() - 1}"
    return element(ring, ring.promoted(x.num).subs({name: 0}), x.den, x.mask)


def text_of(ring: Ring, f: Factor) -> str:
    """Return a factor as plain text, by falling powers of s."""
    parts = []
    for k, c in reversed(list(enumerate(f.coefficients))):
        if c != 0:
            power = "" if k == 0 else "*s" if k == 1 else f"*s^{k}"
            parts.append(f"({text(c, ring)}){power}")
    return " + ".join(parts)


def ratios(ring: Ring, f: Factor) -> list[Any]:
    """Return the coefficients divided by the leading one, as SymPy expressions."""
    lead = ring.coerce(f.coefficients[-1])
    return [sympy.factor_terms(displayed(ring.quotient(ring.coerce(c), lead), ring)) for c in f.coefficients]


def squares(ring: Ring, f: Factor) -> list[Any]:
    """Return w², with s² = -w², of a quadratic or biquadratic factor in even powers."""
    c = ratios(ring, f)
    return [c[0]] if f.degree == 2 else biquadratic(ring, c[2], c[0])


def biquadratic(ring: Ring, b: Any, c: Any) -> list[Any]:
    """Return the two solutions w² of w⁴ - b w² + c = 0; the square root uses the assumptions of the system."""
    half, product = (ring.coerce(ring.from_sympy(x)) for x in (b / 2, c))
    inside = half * half - product
    try:
        root = displayed(ring.sqrt(inside), ring)
    except ExpressionError:  # a negative number
        root = sympy.sqrt(ring.to_sympy(inside))
    middle = displayed(half, ring)
    return [sympy.factor_terms(middle - root), sympy.factor_terms(middle + root)]


def roots(ring: Ring, f: Factor) -> list[Any]:
    """Return the roots of a factor in closed form."""
    c = ratios(ring, f)
    if f.degree == 1:
        return [-c[0]]
    if f.even and f.degree in (2, 4):
        return [sign * sympy.I * sympy.sqrt(w2) for w2 in squares(ring, f) for sign in (1, -1)]
    if f.degree == 2:
        root = sympy.I * sympy.sqrt(sympy.factor(c[0] - c[1] ** 2 / 4))
        return [-c[1] / 2 + root, -c[1] / 2 - root]
    if f.degree <= 4:
        multiplicities = sympy.roots(sympy.Poly(list(reversed(c)), S))
        if sum(multiplicities.values()) == f.degree:
            return [s for s, times in multiplicities.items() for _ in range(times)]
    raise ModelError(
        f"The roots of a factor of degree {f.degree} in s have no closed form: {text_of(ring, f)} = 0. "
        "Give numbers: model.numeric(values), or values= in fb.linearize."
    )


def oscillations(ring: Ring, f: Factor) -> list[tuple[Any, Any]]:
    """Return (frequency, damping ratio) of each pair of roots of a factor."""
    if f.degree == 1:
        return []
    if f.even and f.degree in (2, 4):
        return [(sympy.sqrt(w2), sympy.Integer(0)) for w2 in squares(ring, f)]
    if f.degree == 2:
        c = ratios(ring, f)
        w = sympy.sqrt(c[0])
        return [(w, c[1] / (2 * w))]
    closed = roots(ring, f)
    pairs = [s for s in closed if sympy.im(sympy.N(s)) > 0] if all(s.is_number for s in closed) else None
    if pairs is None:
        raise ModelError(
            f"Which roots of {text_of(ring, f)} = 0 form pairs depends on the values of its symbols. "
            "Give numbers: model.numeric(values), or values= in fb.linearize."
        )
    return [(sympy.Abs(s), -sympy.re(s) / sympy.Abs(s)) for s in pairs]


def modes_of(linear: Any) -> Modes:
    """Return the modes of a symbolic :class:`LinearModel`: one root per pair, and mode shapes from cofactors."""
    character = linear.characteristic
    ring = character.ring
    result = []
    for f in character.factors:
        factor_roots = roots(ring, f)
        if f.degree == 1 and f.coefficients[0] == 0:
            result += _at_zero(linear, f.times)
            continue
        if f.even:
            frequencies = list(
                zip(
                    factor_roots[::2],
                    [(sympy.sqrt(w2), sympy.Integer(0)) for w2 in squares(ring, f)],
                    strict=True,
                )
            )
        elif f.degree == 2:
            frequencies = [(factor_roots[0], oscillations(ring, f)[0])]
        else:
            frequencies = [
                (s, (sympy.Abs(s), -sympy.re(s) / sympy.Abs(s))) for s in factor_roots if _upper(s)
            ]
        for s, (w, ratio) in frequencies:
            shapes = _shapes(linear, f, s)
            kind = "oscillation" if f.degree > 1 else "real root"
            repeats = f.times if len(shapes) == 1 else 1
            result += [Mode(kind, s, w, ratio, shape, ring) for shape in shapes for _ in range(repeats)]
    return Modes(result, character.roots())


def _upper(s: Any) -> bool:
    return not s.is_number or bool(sympy.im(sympy.N(s)) >= 0)


def _at_zero(linear: Any, times: int) -> list[Mode]:
    """Return the modes at s = 0: rigid-body shapes, K X = 0, and constant rates, K X' = 0 with K X + C X' = 0."""
    zero = sympy.Integer(0)
    if linear.carried:
        return _zero_modes_with_carried(linear)[:times]
    n = len(linear.coordinates)
    K, C = linear.K, linear.C
    rigid = [list(v) for v in K.nullspace(simplify=True)]
    chains = sympy.Matrix(sympy.BlockMatrix([[K, C], [sympy.zeros(n), K]])).nullspace(simplify=True)
    drift = [list(v)[n:] for v in chains if any(x != 0 for x in list(v)[n:])]
    result = [Mode("rigid body", zero, zero, zero, _normalised(linear.coordinates, v)) for v in rigid]
    result += [Mode("drift", zero, zero, zero, _normalised(linear.coordinates, v)) for v in drift]
    return result[:times]


def _zero_modes_with_carried(linear: Any) -> list[Mode]:
    """Return the modes at s = 0 of x' = A x with carried deviations: solutions of A^k x = 0 for k = 1, 2, ..."""
    zero = sympy.Integer(0)
    names = (*linear.coordinates, *linear.carried)
    A = linear.first_order[0]
    result: list[Mode] = []
    basis: list[Any] = []
    power = A
    while True:
        level: list[Any] = []
        for v in power.nullspace(simplify=True):
            if sympy.Matrix.hstack(*basis, *level, v).rank(simplify=True) > len(basis) + len(level):
                level.append(v)
        if not level:
            return result
        for v in level:
            kind, shape = ("drift", A * v) if basis else ("rigid body", v)
            result.append(Mode(kind, zero, zero, zero, _normalised(names, list(shape)[: len(names)])))
        basis += level
        power = power * A


def _shapes(linear: Any, f: Factor, s: Any) -> list[dict[str, Any]]:
    """Return null vectors of M s² + C s + K at a root s of a factor: cofactors of a row, reduced modulo the factor."""
    character = linear.characteristic
    ring, rows = character.ring, character.matrix
    n = len(rows)
    field = Rationals(ring, [f.element, *(x for row in rows for x in row)])
    modulus = field.poly(f.element).monic()
    for i in range(n):
        cofactors = []
        for j in range(n):
            minor = [[row[c] for c in range(n) if c != j] for r, row in enumerate(rows) if r != i]
            d = determinant(ring, minor) if n > 1 else ring.coerce(1)
            cofactors.append(field.poly(d * (-1) ** (i + j)).rem(modulus))
        lead = next((x for x in cofactors if not x.is_zero), None)
        if lead is None:
            continue
        inverse = lead.invert(modulus)
        parts = [field.listed((x * inverse).rem(modulus)) if not x.is_zero else [] for x in cofactors]
        values = [sum((c * s**k for k, c in enumerate(p)), sympy.Integer(0)) for p in parts]
        return [
            dict(zip((*linear.coordinates, *linear.carried), map(sympy.factor_terms, values), strict=True))
        ]
    # all cofactors vanish at a repeated root: take all null vectors
    P = sympy.Matrix(n, n, [_at(ring, x, s) for row in rows for x in row])
    names = (*linear.coordinates, *linear.carried)
    return [_normalised(names, v) for v in P.nullspace(simplify=True)]


def _at(ring: Ring, x: Scalar, s: Any) -> Any:
    return sum((displayed(c, ring) * s**k for k, c in enumerate(coefficients(ring, x))), sympy.Integer(0))


def _normalised(names: Sequence[str], vector: Sequence[Any]) -> dict[str, Any]:
    values = list(vector)
    lead = next(v for v in values if v != 0)
    return {name: sympy.simplify(v / lead) for name, v in zip(names, values, strict=True)}
