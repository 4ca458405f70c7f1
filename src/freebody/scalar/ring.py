"""The ring of canonical polynomials: generators, relations, conversion from and to SymPy.

Every scalar of a machine is a polynomial in parameters, coordinates, speeds, accelerations,
and *derived* generators: sine and cosine of an angle, the inverse of a sum of masses, a
square root. The ring stores the relations among the generators (`relations`), so that each element
has one form. A function without a relation (``exp(v)``, ``atan2(y, x)``) is an opaque generator: canonical
then means up to relations among such generators, and equal canonical arguments give the same generator.

Elements may have several forms only in these cases: products of square roots whose
radicands have a common factor not known to be positive; inverse trigonometric functions combined with
each other; inverses of expressions of three and more angles with symbols for their lengths, such
as the inverse of a spring's length (`relations.LIMITS`; `element.is_zero` decides exactly there too); sines of
pi/n for n outside 1, 2, 3, 4, 6, 12; multiples of an angle beyond 24-fold (``sin(1.2345*theta)`` is
not related to ``sin(theta)``).

Within one ring equal elements are one element. For fractions with sines and cosines (or sinh and cosh) of
commensurable angles in the denominator, not even the *text* depends on what the ring read before (`half_angles`).
Exceptions: denominators with a root, an absolute value or the square of a quaternion's component, more than
`half_angles.LONGEST` terms, and long denominators that are printed under a name. Without a denominator, an angle and
its fractions (theta, theta/2) are printed in the form that the ring read first.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import compress
from typing import Any

import sympy
from flint import Ordering, fmpz_mpoly_ctx

from ..errors import ExpressionError, nearest
from . import expression, functions, quotients
from .algebra import FUNCTIONS, Expression, Field, Scalar, divide
from .budget import Budget
from .element import FEW, Polynomial, element
from .relations import Relations

ATOM_KINDS = (
    "parameter", "time", "coordinate", "speed", "acceleration", "reaction", "load", "quaternion", "constant",
)  # fmt: skip

_GENERATOR = re.compile(r"g(\d+)")
_UNDECLARED = 10**6  # rank of atoms that only occurred in an expression: after all declared atoms


@dataclass(slots=True, eq=False)
class Generator:
    """One generator of the ring.

    ``kind`` is one of `ATOM_KINDS`, or for a derived generator one of ``sin, cos, sinh, cosh, inverse,
    sqrt, function``. ``arguments`` are the arguments of that function, ``depends`` the mask of the
    atoms in them. A ``root`` is a symbol that solves an equation.
    """

    index: int
    kind: str
    atom: Any = None  # SymPy expression of the generator
    name: str = ""  # of a function
    arguments: tuple[Any, ...] = ()
    depends: int = 0
    partner: int = -1  # the sine of a cosine and the cosine of a sine
    positive: bool = False
    rank: int = 0  # position among the atoms in printed text, by the first declaration
    derivatives: dict[int, Any] = field(default_factory=dict)
    root: Root | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Root:
    """What a root solves: ``function`` of the unknown of the ring, its ``slope``, and both at the root."""

    function: Any
    slope: Any
    ends: tuple[Any, Any]
    certain: bool
    residual: Any
    slope_there: Any


class Ring(Field):
    """The field of canonical polynomials over a growing set of generators.

    Parameters
    ----------
    capacity : int
        Initial room for generators. It doubles when it is used up, and older elements
        are converted when they are next used.
    """

    def __init__(self, capacity: int = 64):
        self.generators: list[Generator] = []
        self._index: dict[Any, int] = {}  # SymPy atom, or key of a derived generator -> index
        self._memo: dict[Any, Any] = {}
        self.positive: dict[Any, None] = {}  # polynomials assumed positive, primitive, in order
        self.cache: dict[Any, Any] = {}  # for `functions` and the display
        self._declared = 0
        self._open(capacity)
        self.budget = Budget(self)
        self.relations = Relations(self)
        self.one = element_one(self)

    # ---------------------------------------------------------------- contexts
    def _open(self, capacity: int) -> None:
        self.capacity = capacity
        # lexicographic, newest first: see `relations`
        names = tuple(f"g{i}" for i in reversed(range(capacity)))
        self.context = fmpz_mpoly_ctx.get(names, Ordering.lex)
        self._variables = self.context.gens()[::-1]

    def promoted(self, num: Any) -> Any:
        """``num`` in the current context."""
        return num if num.context() is self.context else num.project_to_context(self.context)

    def exponents(self, monomial: tuple[Any, ...]) -> tuple[tuple[int, int], ...]:
        """FLINT's exponent vector as ((generator, exponent), ...), newest generator first."""
        last = len(monomial) - 1
        return tuple(
            (last - i, int(e))
            for i, e in zip(compress(range(last + 1), monomial), filter(None, monomial), strict=True)
        )

    def terms(self, num: Any) -> list[tuple[tuple[tuple[int, int], ...], int]]:
        """Terms of an fmpz_mpoly as (sparse monomial, coefficient), in lexicographic order."""
        # FLINT's text is parsed: exponent vectors of 64 generators cost four times as much
        if num.is_constant():
            return [((), int(num.coefficient(0)))] if num else []
        factors: dict[str, tuple[int, int]] = {}
        result = []
        for word in str(num).replace(" - ", " + -").split(" + "):
            parts = word.split("*")
            first = parts[0]
            if first[0] == "g":
                c = 1
            elif first[0] == "-" and first[1] == "g":
                c = -1
                parts[0] = first[1:]
            else:
                c = int(first)
                del parts[0]
            monomial = []
            for part in parts:
                f = factors.get(part)
                if f is None:
                    name, _, power = part.partition("^")
                    f = factors[part] = (int(name[1:]), int(power or 1))
                monomial.append(f)
            result.append((tuple(monomial), c))
        return result

    def support(self, num: Any) -> int:
        """Exact mask of the generators that occur in an fmpz_mpoly."""
        mask = 0
        if len(num) <= FEW:
            for index in set(_GENERATOR.findall(str(num))):
                mask |= 1 << int(index)
            return mask
        degrees = num.degrees()
        last = len(degrees) - 1
        for i in compress(range(last + 1), degrees):
            mask |= 1 << (last - i)
        return mask

    # ---------------------------------------------------------------- generators
    def new(self, kind: str, key: Any, **attributes: Any) -> Generator:
        """Add a generator; :meth:`find` returns it for ``key``."""
        index = len(self.generators)
        if index == self.capacity:
            self._open(2 * self.capacity)
            self.relations.promote()
        generator = Generator(index, kind, **attributes)
        if not generator.depends:
            for argument in generator.arguments:
                if type(argument) is Polynomial:
                    generator.depends |= self.depends(argument)
        self.generators.append(generator)
        self._index[key] = index
        return generator

    def find(self, key: Any) -> Generator | None:
        """The generator with this SymPy atom or key."""
        index = self._index.get(key)
        return None if index is None else self.generators[index]

    def variable(self, index: int) -> Polynomial:
        """The generator of an index as an element."""
        x = object.__new__(Polynomial)
        x.ring, x.num, x.den, x.mask = self, self._variables[index], 1, 1 << index
        return x

    def generator(self, atom: Any, kind: str | None = None) -> Polynomial:
        """The element for a SymPy atom, created on first use.

        Parameters
        ----------
        atom : Symbol, function of time, or derivative of one
        kind : str, optional
            One of `ATOM_KINDS`. Printed text groups the atoms by kind, in the order in which they
            were first declared with a kind. By default the form of the atom
            decides: a symbol is a parameter, f(t) a coordinate, f'(t) a speed, f''(t) an acceleration.
        """
        if kind is not None and kind not in ATOM_KINDS:
            raise ExpressionError(f"Unknown kind '{kind}' of a generator: {nearest(kind, ATOM_KINDS)}")
        index = self._index.get(atom)
        if index is None:
            generator = self.new(kind or _kind(atom), atom, atom=atom, positive=bool(atom.is_positive))
            generator.depends = 1 << generator.index
            generator.rank = _UNDECLARED + generator.index
        else:
            generator = self.generators[index]
        if kind is not None:
            generator.kind = kind
            if generator.rank >= _UNDECLARED:  # first seen in an expression, declared only now
                self._declared += 1
                generator.rank = self._declared
        return self.variable(generator.index)

    def assume_positive(self, expr: Any) -> None:
        """Assume an atom, or an expression such as ``2*a`` or ``a - b``, positive: √(expr²) is expr from now on."""
        x = self.from_sympy(expr)
        if type(x) is not Polynomial:
            return
        x.num = self.promoted(x.num)
        _, factors = self.factored(x.num)
        self._memo.clear()  # its values did not use the assumption
        if len(factors) == 1 and int(factors[0][1]) % 2 == 0:
            return  # a positive square says nothing about the sign of its root
        if len(x) == 1 and len(factors) == 1 and x.num.leading_coefficient() > 0:
            self.used(x)[0].positive = True
        else:
            self.positive[self._primitive(x)] = None

    def _primitive(self, x: Polynomial) -> Any:
        return element(self, x.num // int(x.num.content()), 1, x.mask)

    def unit_norm(self, e0: Any, e1: Any, e2: Any, e3: Any) -> None:
        """Declare e0² + e1² + e2² + e3² = 1 for four atoms, before they are used in computations."""
        parts = [self.generator(e) if not isinstance(e, Polynomial) else e for e in (e0, e1, e2, e3)]
        total: Any = -1
        for e in parts:
            e = self.coerce(e)
            if len(e) != 1 or e.mask & self.relations.squares:
                raise ExpressionError(
                    f"Expected four quaternion components that carry no relation yet, got {e}; "
                    "declare each unit norm once, before computing with its components."
                )
            total = e * e + total
        mask = max(e.mask for e in parts)
        self.relations.add_square(mask, self.promoted(total.num))

    # ---------------------------------------------------------------- Field
    def constant(self, value: Expression) -> Polynomial:
        """A number as an element; ``"pi"`` and ``"E"`` are generators."""
        if isinstance(value, str):
            atoms = {"pi": sympy.pi, "E": sympy.E}
            if value not in atoms:
                raise ExpressionError(f"Unknown constant '{value}': {nearest(value, atoms)}")
            x = self.generator(atoms[value], "constant")
            self.generators[self._index[atoms[value]]].depends = 0
            return x
        value = expression.exact(value)
        if not isinstance(value, (int, Fraction)):
            raise ExpressionError(f"Expected a number, got '{value}'; use from_sympy for an expression.")
        x = object.__new__(Polynomial)
        x.ring, x.mask, x.den = self, 0, value.denominator
        x.num = self.context.constant(value.numerator)
        return x

    def coerce(self, value: Scalar) -> Polynomial:
        """A number or an element as an element of this ring."""
        if type(value) is Polynomial:
            if value.ring is not self:
                raise ExpressionError(
                    "Expected an element of this ring, got one of another; carry it over through SymPy."
                )
            return value
        return self.constant(value)

    def vanishing(self, square: Scalar) -> Scalar:
        """1 for the exact 0; expressions with symbols are treated as non-zero."""
        return 1 if square == 0 else 0

    def root(
        self,
        function: Callable[[Scalar], Scalar],
        slope: Callable[[Scalar], Scalar],
        ends: tuple[Scalar, Scalar],
        name: str,
        certain: bool = True,
    ) -> Scalar:
        """A generator of this name; its function says which root it is, of an unknown z of the ring."""
        z = self.generator(functions.UNKNOWN, "constant")
        equation = self.coerce(function(z))
        g = self.find(("root", equation))
        if g is None:
            atom = sympy.Symbol(name, real=True)
            while atom in self._index:
                atom = sympy.Symbol(f"{atom.name}_", real=True)
            depends = self.depends(equation) & ~z.mask
            g = self.new("coordinate", ("root", equation), atom=atom, depends=depends)
            self._index[atom] = g.index
            g.rank = _UNDECLARED + g.index
            x = self.variable(g.index)
            g.root = Root(equation, self.coerce(slope(z)), ends, certain, function(x), slope(x))
        return self.variable(g.index)

    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """A function of elements or numbers, as a canonical element."""
        if function not in FUNCTIONS:
            raise ExpressionError(f"Unknown function '{function}': {nearest(function, FUNCTIONS)}")
        return functions.apply(self, function, [self.coerce(a) for a in arguments])

    def arc_over_sine(self, cosine: Scalar) -> Scalar:
        """h / sin h of the angle h from 0 to π/2 with this cosine."""
        return 1 if cosine == 1 else divide(self.apply("acos", cosine), self.sqrt(1 - cosine * cosine))

    # ---------------------------------------------------------------- division
    def quotient(self, a: Polynomial, b: Polynomial) -> Scalar:
        """a / b; common factors cancel, the remaining factors of b become inverse generators."""
        return quotients.quotient(self, a, b)

    def reduced(self, x: Polynomial) -> Scalar:
        """Normal form of an element that is older than a relation."""
        num, scale, mask = self.relations.normal_form(self.promoted(x.num), x.mask, x.mask)
        return element(self, num, x.den * scale, mask)

    def factor(self, x: Scalar) -> tuple[Any, list[tuple[Polynomial, int]]]:
        """Content and irreducible factors; see `Polynomial.factor`."""
        x = self.coerce(x)
        if not x:
            return 0, []
        constant, factors = self.factored(x.num)
        scale = Fraction(int(constant), x.den)
        return (
            scale.numerator if scale.denominator == 1 else scale,
            [(element(self, p, 1, self.support(p)), n) for p, n in factors],
        )

    def factored(self, num: Any) -> tuple[Any, Any]:
        """Content and irreducible factors of an fmpz_mpoly."""
        if len(num) > 1:
            self.budget.factors(num)
        return num.factor()

    def common(self, a: Any, b: Any) -> Any:
        """Greatest common divisor of two fmpz_mpoly."""
        self.budget.factors(a, b)
        return a.gcd(b)

    # ---------------------------------------------------------------- derivatives
    def used(self, x: Polynomial) -> list[Generator]:
        """Generators that occur in an element, oldest first; the call makes its mask exact."""
        mask = x.mask = self.support(x.num)
        return self.of_mask(mask)

    def of_mask(self, mask: int) -> list[Generator]:
        """Generators of a bit mask, oldest first."""
        result = []
        while mask:
            bit = mask & -mask
            result.append(self.generators[bit.bit_length() - 1])
            mask ^= bit
        return result

    def depends(self, x: Scalar) -> int:
        """Mask of the atoms that an element depends on, through its derived generators."""
        if type(x) is not Polynomial:
            return 0
        mask = 0
        for g in self.used(x):
            mask |= g.depends
        return mask

    def atoms_of(self, x: Scalar) -> frozenset[Any]:
        """SymPy atoms that an element depends on."""
        return frozenset(g.atom for g in self.of_mask(self.depends(x)))

    def derivative(self, x: Scalar, atom: Any) -> Scalar:
        """∂x/∂atom with the chain rule through derived generators."""
        index = self._index.get(atom)
        if index is None or type(x) is not Polynomial:
            return 0
        bit = 1 << index
        total: Any = 0
        for g in self.used(x):
            if g.depends & bit:
                total = total + self._partial(x, g.index) * self._generator_derivative(g, index)
        return total

    def total_derivative(self, x: Scalar, rates: Mapping[Any, Scalar]) -> Scalar:
        """Rate of x when every atom changes at its rate; see `Polynomial.total_derivative`."""
        if type(x) is not Polynomial:
            return 0
        atom_rates: dict[int, Any] = {}
        for g in self.of_mask(self.depends(x)):
            rate = rates.get(g.atom, 1 if g.kind == "time" else 0)
            atom_rates[g.index] = rate if type(rate) is Polynomial else self.coerce(rate)
        total: Any = 0
        for g in self.used(x):
            rate = 0
            for atom in self.of_mask(g.depends):
                if atom_rates[atom.index] != 0:
                    rate = rate + self._generator_derivative(g, atom.index) * atom_rates[atom.index]
            if rate != 0:
                total = total + self._partial(x, g.index) * rate
        return total

    def _partial(self, x: Polynomial, index: int) -> Any:
        x.num = self.promoted(x.num)
        num = x.num.derivative(self.capacity - 1 - index)
        return element(self, num, x.den, x.mask)

    def _generator_derivative(self, g: Generator, index: int) -> Any:
        if g.index == index:
            return 1
        if index not in g.derivatives:
            rule = functions.derivative if g.root is None else functions.derivative_of_root
            g.derivatives[index] = rule(self, g, self.generators[index].atom)
        return g.derivatives[index]

    # ---------------------------------------------------------------- SymPy
    def from_sympy(self, expr: Expression) -> Scalar:
        """A SymPy expression (or a number) as a canonical element, or a plain number."""
        if isinstance(expr, str):
            raise ExpressionError(f"Expected a SymPy expression, got the text {expr!r}; parse it first.")
        try:
            expr = sympy.sympify(expr, strict=not isinstance(expr, Fraction))
        except (sympy.SympifyError, AttributeError):
            raise ExpressionError(f"Expected a SymPy expression, got {expr!r}.") from None
        if not isinstance(expr, sympy.Expr):
            raise ExpressionError(f"Expected one SymPy expression, got {type(expr).__name__} {expr}.")
        if expr.has(sympy.nan, sympy.oo, sympy.zoo, -sympy.oo, sympy.I):
            raise ExpressionError(f"Expected a finite real expression, got '{expr}'.")
        return expression.evaluate(expr, self._lookup, self, self._memo)

    def _lookup(self, atom: Any) -> Polynomial:
        if atom.is_Symbol or atom.is_Derivative or isinstance(atom, sympy.core.function.AppliedUndef):
            return self.generator(atom)
        raise KeyError(atom)

    def to_sympy(self, x: Scalar) -> Any:
        """An element as an expanded SymPy expression."""
        from . import to_sympy

        return to_sympy.expression_of(self, x)

    def text(self, x: Scalar) -> str:
        """Plain text of the element for messages; `symbolic.printing.display` prints for readers."""
        if type(x) is not Polynomial:
            return str(x)
        return str(self.to_sympy(x)) if len(x) <= 200 else f"<polynomial of {len(x)} terms>"

    def elements(self, values: Iterable[Scalar]) -> tuple[Polynomial, ...]:
        """Several values as elements of this ring."""
        return tuple(self.coerce(v) for v in values)


def element_one(ring: Ring) -> Polynomial:
    """The number 1 as an element of a ring."""
    return ring.constant(1)


def _kind(atom: Any) -> str:
    """Kind of an atom, from its form."""
    if atom.is_Symbol:
        return "time" if atom.name == "t" else "parameter"
    if atom.is_Derivative:
        order = sum(count for _, count in atom.variable_count)
        return "speed" if order == 1 else "acceleration"
    if atom.is_Function:
        return "coordinate"
    raise ExpressionError(f"Expected a symbol, a function of time or a derivative of one, got '{atom}'.")
