"""Tapes: scalars that record how they are computed.

An algorithm that runs on :class:`Traced` scalars records its operations on a :class:`Tape`. Equal operations are
one node (hash consing), so equal scalars are one object. Operations on numbers alone are not recorded: they are
folded exactly (``int``, ``Fraction``) or in double precision. Signs are moved outward, so that

    a + (-b) = a - b,   (-a) b = -(a b),   a - b = -(b - a),   (a 2) (1/2) = a

each leave one node. Every identity used holds exactly in IEEE arithmetic up to the sign of zero, with these
exceptions: neighbouring constants are joined and a division by a constant becomes a multiplication by its
reciprocal (each costs one rounding), and 0 x is 0 and x / x is 1 for every x.

Source: hash consing after A. P. Ershov, On programming of arithmetic operations (1958).

The file is long because every operation of a scalar is a rule of its tape.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping
from fractions import Fraction
from numbers import Real
from typing import Any

from ..errors import ExpressionError
from .algebra import FUNCTIONS, Field, Scalar
from .folding import EVEN, ODD, fold, number, reciprocal

# Codes of operations; `NAMES[code]` is the name. The codes are part of the key of compiled programs on disk.
NAMES = ("const", "input", "add", "sub", "mul", "div", "neg", *FUNCTIONS)
CONST, INPUT, ADD, SUB, MUL, DIV, NEG = range(7)
CODES = {name: code for code, name in enumerate(NAMES)}
POW = CODES["pow"]
NONE = -1
"""The second operand of an operation with one operand."""

_BINARY = frozenset({"atan2", "pow", "min", "max"})


class Tape(Field):
    """A recorded computation: operations in the order of their first use.

    Node ``i`` is ``op[i]`` of the nodes ``a[i]`` and ``b[i]`` (:data:`NONE` if there is no second operand).
    For a constant, ``a`` is its index in :attr:`constants`; for an input, its index in :attr:`inputs`.

    >>> tape = Tape()
    >>> x, y = tape.input("x"), tape.input("y")
    >>> tape.to_sympy(tape.sin(x) * y + 0 * x - (-y))
    y*sin(x) + y
    >>> x * y is y * x
    True
    """

    def __init__(self, numbers_are_data: bool = False) -> None:
        self.numbers_are_data = numbers_are_data
        self.data: dict[str, Scalar] = {}
        self.op: list[int] = []
        self.a: list[int] = []
        self.b: list[int] = []
        self.constants: list[Scalar] = []
        self.inputs: list[str] = []
        self._memo: list[dict[Any, Traced]] = [{} for _ in NAMES]

    def __len__(self) -> int:
        return len(self.op)

    def __repr__(self) -> str:
        return f"<Tape of {len(self.op)} nodes, {len(self.inputs)} inputs>"

    def input(self, name: str) -> Traced:
        """The input of this name."""
        scalar = self._memo[INPUT].get(name)
        if scalar is None:
            self.inputs.append(name)
            scalar = self._memo[INPUT][name] = self._append(INPUT, len(self.inputs) - 1, NONE)
        return scalar

    def constant(self, value: int | Fraction | float | str) -> Scalar:
        """The number itself; ``"pi"`` and ``"E"`` as floats."""
        if isinstance(value, str):
            return {"pi": math.pi, "E": math.e}[value]
        return value

    def datum(self, value: int | Fraction | float) -> Scalar:
        """A number of a model: itself, or an input with this value if numbers are data, except 0, 1 and -1.

        Functions that differ only in such numbers are of one kind (`program.code.kinds`).
        """
        if not self.numbers_are_data or value in (0, 1, -1):
            return value
        name = f"datum {value}"
        self.data[name] = value
        return self.input(name)

    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """``function`` of numbers (folded) or of scalars of this tape."""
        if function not in CODES or CODES[function] <= NEG:
            raise ExpressionError(
                f"Expected a function that can be compiled, got {function!r}. Known: {', '.join(FUNCTIONS)}."
            )
        expected = 2 if function in _BINARY else 1
        if len(arguments) != expected:
            raise ExpressionError(f"Expected {expected} argument(s) of {function}, got {len(arguments)}.")
        x = arguments[0]
        if expected == 2:
            y = arguments[1]
            if type(x) is not Traced and type(y) is not Traced:
                return fold(function, x, y)
            if function == "pow":
                return x**y if type(x) is Traced else self._pow(x, y)
            if (function == "min" or function == "max") and x is y:
                return x
            i, j = self.node(x).index, self.node(y).index
            if function != "atan2" and j < i:
                i, j = j, i
            return self._record(CODES[function], i, j)
        if type(x) is not Traced:
            return fold(function, x)
        if x.minus is not None:
            if function in ODD:
                return -self.apply(function, x.minus)
            if function in EVEN:
                x = x.minus
        return self._record(CODES[function], self.node(x).index, NONE)

    def node(self, x: Scalar) -> Traced:
        """``x`` as a node of this tape; a number becomes a constant node."""
        if type(x) is Traced:
            if x.tape is not self:
                raise ExpressionError(
                    "Expected scalars of one tape, got one of another tape. "
                    "Record the whole program on one Tape."
                )
            return x
        x = number(x)
        node = self._memo[CONST].get(x)
        if node is None:
            self.constants.append(x)
            node = self._memo[CONST][x] = self._append(CONST, len(self.constants) - 1, NONE)
        return node

    def scalar(self, i: int) -> Scalar:
        """The scalar of node ``i``: a number for a constant, else the traced scalar."""
        code = self.op[i]
        if code == CONST:
            return self.constants[self.a[i]]
        if code == INPUT:
            return self._memo[INPUT][self.inputs[self.a[i]]]
        if code == NEG:
            return self._memo[NEG][self.a[i]]
        return self._memo[code][self.a[i], self.b[i]]

    def used(self, outputs: Iterable[Scalar]) -> list[int]:
        """Indices of the nodes that the outputs need, operands first (increasing)."""
        op, a, b = self.op, self.a, self.b
        last = {x.index for x in outputs if type(x) is Traced}
        if not last:
            return []
        needed = bytearray(max(last) + 1)
        for i in last:
            needed[i] = 1
        for i in range(len(needed) - 1, -1, -1):
            if needed[i] and op[i] > INPUT:
                needed[a[i]] = 1
                if b[i] >= 0:
                    needed[b[i]] = 1
        return [i for i, flag in enumerate(needed) if flag]

    def depends(self, x: Scalar, inputs: Container[int]) -> bool:
        """True if a scalar of this tape needs one of the inputs with these indices."""
        waiting = [x.index] if type(x) is Traced else []
        seen = set(waiting)
        while waiting:
            i = waiting.pop()
            if i in inputs:
                return True
            if self.op[i] > INPUT:
                new = {self.a[i], self.b[i]} - seen - {NONE}
                seen |= new
                waiting += new
        return False

    def uses(self, x: Traced) -> bool:
        """True if an operation of this tape takes a scalar."""
        operations = zip(self.op, self.a, self.b, strict=True)
        return any(op > INPUT and x.index in (a, b) for op, a, b in operations)

    def evaluate(self, outputs: Iterable[Scalar], values: Mapping[str, float]) -> list[float]:
        """Values of the outputs in Python floats, from the inputs by name: the slow reference of the compiler."""
        outputs = list(outputs)
        table: dict[int, float] = {}
        for i in self.used(outputs):
            code, p, q = self.op[i], self.a[i], self.b[i]
            if code == CONST:
                table[i] = float(self.constants[p])
            elif code == INPUT:
                name = self.inputs[p]
                table[i] = float(self.data[name] if name in self.data else values[name])
            else:
                table[i] = _EVALUATE[code](table[p]) if q < 0 else _EVALUATE[code](table[p], table[q])
        return [table[x.index] if type(x) is Traced else float(x) for x in outputs]

    def to_sympy(self, x: Scalar, symbols: Mapping[str, Any] | None = None) -> Any:
        """A scalar as a SymPy expression; an input is a symbol of its name unless ``symbols`` replaces it."""
        import sympy

        def constant(value: Any) -> Any:
            if isinstance(value, Fraction):
                return sympy.Rational(value.numerator, value.denominator)
            if isinstance(value, float):
                return {math.pi: sympy.pi, math.e: sympy.E}.get(value, sympy.Float(value))
            return sympy.Integer(value)

        if type(x) is not Traced:
            return constant(x)
        functions: dict[int, Callable[..., Any]] = {
            ADD: lambda p, q: p + q, SUB: lambda p, q: p - q, MUL: lambda p, q: p * q,
            DIV: lambda p, q: p / q, NEG: lambda p: -p, POW: lambda p, q: p**q,
            CODES["abs"]: sympy.Abs, CODES["min"]: sympy.Min, CODES["max"]: sympy.Max,
        }  # fmt: skip
        symbols = symbols or {}
        table: dict[int, Any] = {}
        for i in self.used([x]):
            code, p, q = self.op[i], self.a[i], self.b[i]
            if code == CONST:
                table[i] = constant(self.constants[p])
            elif code == INPUT:
                name = self.inputs[p]
                table[i] = symbols[name] if name in symbols else sympy.Symbol(name)
            else:
                function = functions.get(code) or getattr(sympy, NAMES[code])
                table[i] = function(table[p]) if q < 0 else function(table[p], table[q])
        return table[x.index]

    # --- recording ---------------------------------------------------------------------------

    def _append(self, code: int, i: int, j: int) -> Traced:
        new = Traced(self, len(self.op), None)
        self.op.append(code)
        self.a.append(i)
        self.b.append(j)
        return new

    def _record(self, code: int, i: int, j: int) -> Traced:
        memo = self._memo[code]
        scalar = memo.get((i, j))
        if scalar is None:
            scalar = memo[i, j] = self._append(code, i, j)
        return scalar

    def _times_number(self, x: Traced, c: Scalar) -> Scalar:
        if c == 0:
            return 0
        if c == 1:
            return x
        if x.minus is not None:
            x, c = x.minus, -c
        if c < 0:
            return -self._times_number(x, -c)
        i = x.index
        if self.op[i] == MUL and self.op[self.b[i]] == CONST:  # (x c') c
            c = c * self.constants[self.a[self.b[i]]]
            i = self.a[i]
            if c == 1:
                return self.scalar(i)
        return self._record(MUL, i, self.node(c).index)

    def _plus_number(self, x: Traced, c: Scalar) -> Scalar:
        if c == 0:
            return x
        if x.minus is not None:  # -x + c
            return -self._plus_number(x.minus, -c)
        i = x.index
        code = self.op[i]
        if code in (ADD, SUB) and self.op[self.b[i]] == CONST:  # (x ± c') + c
            joined = self.constants[self.a[self.b[i]]]
            return self._plus_number(self.scalar(self.a[i]), c + joined if code == ADD else c - joined)
        if c < 0:
            return self._record(SUB, i, self.node(-c).index)
        return self._record(ADD, i, self.node(c).index)

    def _pow(self, x: Any, y: Any) -> Any:
        return self._record(POW, self.node(x).index, self.node(y).index)


class Traced:
    """A scalar of a tape: node ``index`` of ``tape``. Equal scalars are the same node."""

    __slots__ = ("index", "minus", "tape")
    __array_ufunc__ = None  # NumPy numbers leave the operation to this class

    def __init__(self, tape: Tape, index: int, minus: Traced | None) -> None:
        self.tape = tape
        self.index = index
        self.minus = minus  # x if this is -x

    def __add__(self, other: Scalar) -> Scalar:
        if type(other) is not Traced:
            if other.__class__ is int and other == 0:
                return self
            if not isinstance(other, Real):
                return NotImplemented
            return self.tape._plus_number(self, number(other))
        if self.minus is not None:
            return other - self.minus
        if other.minus is not None:
            return self - other.minus
        tape = self.tape
        if tape is not other.tape:
            tape.node(other)
        i, j = self.index, other.index
        if i == j:
            return tape._times_number(self, 2)
        key = (i, j) if i < j else (j, i)
        result = tape._memo[ADD].get(key)
        if result is None:
            result = tape._memo[ADD][key] = Traced(tape, len(tape.op), None)
            tape.op.append(ADD)
            tape.a.append(key[0])
            tape.b.append(key[1])
        return result

    __radd__ = __add__

    def __sub__(self, other: Scalar) -> Scalar:
        if type(other) is not Traced:
            if other.__class__ is int and other == 0:
                return self
            if not isinstance(other, Real):
                return NotImplemented
            return self.tape._plus_number(self, -number(other))
        if other.minus is not None:
            return self + other.minus
        if self.minus is not None:
            return -(self.minus + other)
        tape = self.tape
        if tape is not other.tape:
            tape.node(other)
        i, j = self.index, other.index
        if i == j:
            return 0
        memo = tape._memo[SUB]
        result = memo.get((i, j))
        if result is None:
            result = memo.get((j, i))
            if result is not None:
                return -result
            result = memo[i, j] = Traced(tape, len(tape.op), None)
            tape.op.append(SUB)
            tape.a.append(i)
            tape.b.append(j)
        return result

    def __rsub__(self, other: Scalar) -> Scalar:
        return -(self - other)

    def __mul__(self, other: Scalar) -> Scalar:
        if type(other) is not Traced:
            if other.__class__ is int and other == 0:
                return 0
            if not isinstance(other, Real):
                return NotImplemented
            return self.tape._times_number(self, number(other))
        if self.minus is not None:
            return -(self.minus * other)
        if other.minus is not None:
            return -(self * other.minus)
        tape = self.tape
        if tape is not other.tape:
            tape.node(other)
        i, j = self.index, other.index
        key = (i, j) if i < j else (j, i)
        result = tape._memo[MUL].get(key)
        if result is None:
            result = tape._memo[MUL][key] = Traced(tape, len(tape.op), None)
            tape.op.append(MUL)
            tape.a.append(key[0])
            tape.b.append(key[1])
        return result

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        if type(other) is not Traced:
            if not isinstance(other, Real):
                return NotImplemented
            return self.tape._times_number(self, reciprocal(number(other)))
        if self is other:
            return 1
        if self.minus is not None:
            return -(self.minus / other)
        if other.minus is not None:
            return -(self / other.minus)
        return self.tape._record(DIV, self.index, self.tape.node(other).index)

    def __rtruediv__(self, other: Scalar) -> Scalar:
        if not isinstance(other, Real):
            return NotImplemented
        c = number(other)
        if c == 0:
            return 0
        if self.minus is not None:
            return -(c / self.minus)
        if c < 0:
            return -(-c / self)
        tape = self.tape
        i = self.index
        if c == 1 and tape.op[i] == DIV and tape.op[tape.a[i]] != CONST:  # 1 / (x / y)
            return tape._record(DIV, tape.b[i], tape.a[i])
        return tape._record(DIV, tape.node(c).index, i)

    def __neg__(self) -> Traced:
        if self.minus is not None:
            return self.minus
        tape = self.tape
        i = self.index
        result = tape._memo[NEG].get(i)
        if result is None:
            result = tape._memo[NEG][i] = Traced(tape, len(tape.op), self)
            tape.op.append(NEG)
            tape.a.append(i)
            tape.b.append(NONE)
        return result

    def __pos__(self) -> Traced:
        return self

    def __abs__(self) -> Scalar:
        return self.tape.apply("abs", self)

    def __pow__(self, exponent: Scalar) -> Scalar:
        if type(exponent) is Traced:
            return self.tape._pow(self, exponent)
        if not isinstance(exponent, Real):
            return NotImplemented
        n = number(exponent)
        if n == int(n) and abs(n) <= 64:
            n = int(n)
            power = _power(self, abs(n))
            return power if n >= 0 else 1 / power
        if 2 * n == int(2 * n) and abs(n) <= 64:
            power = _power(self.tape.apply("sqrt", self), abs(int(2 * n)))
            return power if n > 0 else 1 / power
        return self.tape._pow(self, n)

    def __rpow__(self, base: Scalar) -> Scalar:
        return self.tape.apply("pow", base, self) if isinstance(base, Real) else NotImplemented

    def _no_branch(self, *_: Any) -> bool:
        raise TypeError(
            "Expected no branch on the value of a recorded scalar: it has none while the program is recorded. abs, "
            "sign, min and max serve instead."
        )

    __bool__ = __lt__ = __le__ = __gt__ = __ge__ = _no_branch
    __float__ = __int__ = _no_branch

    def __repr__(self) -> str:
        tape, i = self.tape, self.index
        code = tape.op[i]
        if code == INPUT:
            return f"<{tape.inputs[tape.a[i]]}>"
        operands = ", ".join(f"#{k}" for k in (tape.a[i], tape.b[i]) if k >= 0)
        return f"<#{i} = {NAMES[code]}({operands})>"


def _power(x: Scalar, n: int) -> Scalar:
    """x to the natural power n by squaring."""
    if n == 0:
        return 1
    if n == 1:
        return x
    half = _power(x, n // 2)
    return half * half if n % 2 == 0 else half * half * x


_EVALUATE: dict[int, Callable[..., float]] = {
    ADD: float.__add__, SUB: float.__sub__, MUL: float.__mul__, DIV: float.__truediv__, NEG: float.__neg__,
    **{CODES[name]: getattr(math, name) for name in FUNCTIONS if hasattr(math, name)},
    CODES["abs"]: abs, CODES["sign"]: lambda x: float((x > 0) - (x < 0)),
    CODES["min"]: min, CODES["max"]: max,
}  # fmt: skip
