"""An element of a `Ring`: a polynomial with integer coefficients over one integer denominator."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import gcd
from typing import Any

from flint.utils.flint_exceptions import IncompatibleContextError

from ..errors import DivisorError, ExpressionError
from .algebra import Scalar, exact_constant
from .budget import FREE

FEW = 16
"""Greatest number of terms of which FLINT's text takes less time than the exponents of hundreds of generators."""

_new = object.__new__


class Polynomial:
    """``numerator / denominator``, in normal form modulo the relations of its ring.

    Equal elements have one representation, which ``==`` compares, and ``x - x`` is the plain
    int 0. Results that are numbers are returned as int or `Fraction`.
    """

    __slots__ = ("ring", "num", "den", "mask")

    ring: Any
    num: Any  # fmpz_mpoly
    den: int  # > 0, no factor in common with the content of num
    mask: int  # generators that may occur: a superset of the generators that do

    # ---------------------------------------------------------------- arithmetic
    def __add__(self, other: Scalar) -> Scalar:
        if type(other) is not Polynomial:
            if other == 0 and type(other) is int:
                return self
            other = _operand(self.ring, other)
            if other is NotImplemented:
                return other
        if self.ring is not other.ring:
            _refuse_two_rings()
        a, b = self.den, other.den
        try:
            num = (
                self.num + other.num if a == b else self.num * (b // gcd(a, b)) + other.num * (a // gcd(a, b))
            )
        except IncompatibleContextError:
            _align(self, other)
            return self + other
        if (size := len(num)) < 2 and num.is_constant():
            den = a * b // gcd(a, b)
            return _constant(num, den)
        if size > FREE:
            self.ring.budget.sum(size)
        result = _new(Polynomial)
        result.ring = self.ring
        result.num = num
        result.den = 1
        result.mask = self.mask | other.mask
        if a != 1 or b != 1:
            _cancel(result, a * b // gcd(a, b))
        return result

    __radd__ = __add__

    def __neg__(self) -> Polynomial:
        result = _new(Polynomial)
        result.ring = self.ring
        result.num = -self.num
        result.den = self.den
        result.mask = self.mask
        return result

    def __pos__(self) -> Polynomial:
        return self

    def __sub__(self, other: Scalar) -> Scalar:
        if type(other) is not Polynomial:
            if other == 0 and type(other) is int:
                return self
            other = _operand(self.ring, other)
            if other is NotImplemented:
                return other
        if self.ring is not other.ring:
            _refuse_two_rings()
        a, b = self.den, other.den
        if a != b:
            return self + (-other)
        try:
            num = self.num - other.num
        except IncompatibleContextError:
            _align(self, other)
            num = self.num - other.num
        if (size := len(num)) < 2 and num.is_constant():
            return _constant(num, a)
        if size > FREE:
            self.ring.budget.sum(size)
        result = _new(Polynomial)
        result.ring = self.ring
        result.num = num
        result.den = 1
        result.mask = self.mask | other.mask
        if a != 1:
            _cancel(result, a)
        return result

    def __rsub__(self, other: Scalar) -> Scalar:
        return -self + other

    def __mul__(self, other: Scalar) -> Scalar:
        if type(other) is not Polynomial:
            if type(other) is int:
                if other == 0:
                    return 0
                if other == 1:
                    return self
            return _scaled(self, other)
        ring = self.ring
        if ring is not other.ring:  # FLINT shares contexts between rings of one capacity
            _refuse_two_rings()
        if len(self.num) * len(other.num) > FREE:
            ring.budget.product(self.num, other.num)
        try:
            num = self.num * other.num
        except IncompatibleContextError:
            _align(self, other)
            num = self.num * other.num
        den = self.den * other.den
        ma, mb = self.mask, other.mask
        mask = ma | mb
        relations = ring.relations
        if ma & mb & relations.squares or mask & relations.triggers:
            try:
                num, scale, mask = relations.normal_form(num, ma & mb, mask)
            except IncompatibleContextError:
                num, scale, mask = relations.normal_form(ring.promoted(num), ma & mb, mask)
            den *= scale
            if len(num) < 2 and num.is_constant():
                return _constant(num, den)
        elif not num or not mask:  # a product of constants, or of zero divisors
            return _constant(num, den)
        result = _new(Polynomial)
        result.ring = ring
        result.num = num
        result.den = 1
        result.mask = mask
        if den != 1:
            _cancel(result, den)
        return result

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        if type(other) is not Polynomial:
            other = _plain(other)
            if other is NotImplemented:
                return other
            if other == 0:
                raise DivisorError(f"Expected a divisor that is not zero in ({self}) / 0.")
            return _scaled(self, 1 / Fraction(other))
        return self.ring.quotient(self, other)

    def __rtruediv__(self, other: Scalar) -> Scalar:
        other = _operand(self.ring, other)
        if other is NotImplemented:
            return other
        return self.ring.quotient(other, self)

    def __pow__(self, exponent: Scalar) -> Scalar:
        if isinstance(exponent, Fraction) and exponent.denominator == 1:
            exponent = int(exponent)
        if not isinstance(exponent, int):
            return self.ring.apply("pow", self, exponent)
        if exponent < 0:
            return 1 / self**-exponent
        if exponent > 8:
            self.ring.budget.power(self.num, exponent)
        result: Any = 1
        square: Any = self
        while exponent:
            if exponent & 1:
                result = square * result
            exponent >>= 1
            if exponent:
                square = square * square
        return result

    def __rpow__(self, base: Scalar) -> Scalar:
        return self.ring.apply("pow", base, self)

    # ---------------------------------------------------------------- comparison
    def __eq__(self, other: Any) -> bool:
        if type(other) is not Polynomial:
            if isinstance(other, (int, Fraction)):
                return self.num.is_constant() and _constant(self.num, self.den) == other
            other = _operand(self.ring, other)
            if other is NotImplemented:
                return NotImplemented
        if self.ring is not other.ring or self.den != other.den or len(self.num) != len(other.num):
            return False
        if self.num.context() is not other.num.context():
            _align(self, other)
        return self.num == other.num

    def __hash__(self) -> int:
        num = self.num
        if num.is_constant():
            return hash(Fraction(int(num.coefficient(0)) if num else 0, self.den))
        # the hash must not depend on the number of generators of the context
        if len(num) <= FEW:
            return hash((self.den, str(num)))
        first, last = (self.ring.exponents(num.monomial(i)) for i in (0, len(num) - 1))
        middle = tuple(int(num.coefficient(i)) for i in range(min(len(num), 4)))
        return hash((self.den, len(num), first, last, middle))

    def __bool__(self) -> bool:
        return bool(self.num)

    # ---------------------------------------------------------------- questions
    @property
    def is_number(self) -> bool:
        """True if no generator occurs."""
        return bool(self.num.is_constant())

    def number(self) -> int | Fraction:
        """The value of an element without generators."""
        if not self.num.is_constant():
            raise ExpressionError(f"Expected a number, got {self}.")
        return _constant(self.num, self.den)

    def atoms(self) -> frozenset[Any]:
        """SymPy atoms that the element depends on (an angle rather than its sine)."""
        return self.ring.atoms_of(self)

    def terms(self) -> list[tuple[tuple[tuple[int, int], ...], int]]:
        """``((generator, exponent), ...), coefficient`` of each term of the numerator, in order."""
        return self.ring.terms(self.num)

    def __len__(self) -> int:
        return len(self.num)

    # ---------------------------------------------------------------- derivatives, other forms
    def derivative(self, atom: Any) -> Scalar:
        """∂/∂atom, through every generator that depends on the atom."""
        return self.ring.derivative(self, atom)

    def total_derivative(self, rates: Mapping[Any, Scalar]) -> Scalar:
        """Σ ∂/∂atom · rates[atom]; the rate of time is 1, and an atom without a rate is constant."""
        return self.ring.total_derivative(self, rates)

    def factor(self) -> tuple[int | Fraction, list[tuple[Polynomial, int]]]:
        """``(c, [(f, n), ...])`` with ``self = c · Π fⁿ``, every f irreducible and integer."""
        return self.ring.factor(self)

    def to_sympy(self) -> Any:
        """The element as an expanded SymPy expression."""
        return self.ring.to_sympy(self)

    def __str__(self) -> str:
        return self.ring.text(self)

    __repr__ = __str__

    def __lt__(self, other: Any) -> bool:
        raise TypeError("A canonical polynomial has no order: no algorithm may branch on its value.")

    __le__ = __gt__ = __ge__ = __lt__

    def __float__(self) -> float:
        return float(self.number())


def element(ring: Any, num: Any, den: int, mask: int) -> Scalar:
    """``num / den`` (num in normal form) as a Polynomial, or as a plain number if it is one."""
    if num.is_constant():
        return _constant(num, den)
    result = _new(Polynomial)
    result.ring = ring
    result.num = num
    result.den = 1
    result.mask = mask
    if den != 1:
        _cancel(result, den)
    return result


def is_zero(x: Scalar) -> bool:
    """True if an element, a number or anything that compares with 0 is zero.

    The answer is exact even where the form of an element is not canonical. The ring has no zero divisors, so that
    x = 0 if and only if x P^n = 0. Written in powers of the inverse i of P,

        x = Σ a_k i^k      =>      x P^n = Σ a_k P^(n-k),

    which holds no inverse of P. When all inverses are cleared, the remaining element has one form.
    """
    if type(x) is not Polynomial or not x.ring.relations.unfinished:
        return bool(x == 0)
    return bool(x == 0 or cleared(x) == 0)


def cleared(x: Scalar) -> Scalar:
    """x times powers of the reciprocals of its inverse generators, newest first, so that no inverse remains."""
    ring = x.ring
    while type(x) is Polynomial:
        g = next((g for g in reversed(ring.used(x)) if g.kind == "inverse"), None)
        if g is None:
            break
        terms = ring.terms(ring.promoted(x.num))
        n = max(dict(monomial).get(g.index, 0) for monomial, _ in terms)
        place = ring.capacity - 1 - g.index
        rest, total = ring.promoted(x.num), 0
        for k in range(n + 1):  # the coefficient of i^k, by derivatives at i = 0
            a = rest.subs({f"g{g.index}": 0})
            total = total + _reduced(ring, a, x.den) * g.arguments[0] ** (n - k)
            rest = (rest.derivative(place) if k < n else rest) // (k + 1)
        x = total
    return x


def _reduced(ring: Any, num: Any, den: int) -> Any:
    x = element(ring, num, den, ring.support(num))
    return ring.reduced(x) if type(x) is Polynomial else x


def _constant(num: Any, den: int) -> int | Fraction:
    """A constant fmpz_mpoly over ``den``."""
    return _number(int(num.coefficient(0)), den) if num else 0


def _number(numerator: int, denominator: int) -> int | Fraction:
    """The quotient, as an int if it is one."""
    if denominator == 1:
        return numerator
    value = Fraction(numerator, denominator)
    return value.numerator if value.denominator == 1 else value


def _cancel(result: Polynomial, den: int) -> None:
    """Set the denominator and cancel its common factor with the coefficients."""
    common = gcd(int(result.num.content()), den)
    if common != 1:
        result.num = result.num // common
        den //= common
    result.den = den


def _scaled(x: Polynomial, factor: Any) -> Any:
    """The element times a number, or NotImplemented if the factor is no number."""
    factor = _plain(factor)
    if factor is NotImplemented:
        return factor
    if factor == 0:
        return 0
    result = _new(Polynomial)
    result.ring = x.ring
    result.mask = x.mask
    result.num = x.num * factor.numerator
    result.den = 1
    den = x.den * factor.denominator
    if den != 1:
        _cancel(result, den)
    return result


def _plain(value: Any) -> Any:
    """The number as an int or Fraction, a float as the decimal it prints as; NotImplemented for anything else."""
    if isinstance(value, (int, Fraction)) and not isinstance(value, bool):
        return value
    if isinstance(value, float) or type(value).__module__ == "numpy" or getattr(value, "is_Number", False):
        number = exact_constant(value)
        if number is not None:
            return number
    return NotImplemented


def _operand(ring: Any, value: Any) -> Any:
    """A number as an element of the ring, or NotImplemented."""
    plain = _plain(value)
    return NotImplemented if plain is NotImplemented else ring.coerce(plain)


def _refuse_two_rings() -> None:
    raise ExpressionError(
        "Expected two elements of one ring, got elements of two; create the generators of one "
        "computation in one Ring, or carry an element over through to_sympy and from_sympy."
    )


def _align(a: Polynomial, b: Polynomial) -> None:
    """Convert two elements of one ring to its current context."""
    a.num = a.ring.promoted(a.num)
    b.num = a.ring.promoted(b.num)
