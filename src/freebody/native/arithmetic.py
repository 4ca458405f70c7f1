"""Arithmetic of the compiled language: on constants of Python, on numbers, and on vectors with a number for each lane.

A value is a number of Python, which is known during translation, or a value of LLVM. A number joins a vector as the
same number in every lane. Integers become real numbers where needed, never the reverse.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir

from .builder import Function, Value

REAL, WHOLE, TRUTH = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
FIRST, LAST = -(2**63), 2**63 - 1
"""Range of an integer."""

_OF_REALS = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_OF_INTEGERS = {
    ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.LShift: "shl", ast.RShift: "ashr",
    ast.BitAnd: "and_", ast.BitOr: "or_", ast.BitXor: "xor",
}  # fmt: skip
_OF_TRUTHS = {ast.BitAnd: "and_", ast.BitOr: "or_", ast.BitXor: "xor"}
_OF_PYTHON: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow, ast.LShift: operator.lshift,
    ast.RShift: operator.rshift, ast.BitAnd: operator.and_, ast.BitOr: operator.or_, ast.BitXor: operator.xor,
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}  # fmt: skip
_COMPARISONS = {ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
_NUMBERS = (bool, int, float)
_KINDS = {bool: TRUTH, int: WHOLE, float: REAL}
_SINGLE = (ir.DoubleType, ir.IntType)
"""Classes of the types of one number."""
_WORDS = {REAL: "a real number", WHOLE: "an integer", TRUTH: "a truth value"}


class Refusal(Exception):
    """Reason why a construct has no translation: what was expected, what came, and the cure."""

    def __init__(self, expected: str, cure: str, got: str = "") -> None:
        super().__init__(expected)
        self.expected, self.cure, self.got = expected, cure, got


# -- types ---------------------------------------------------------------------------------------------


def is_number(value: Any) -> bool:
    """Return whether a value is a number of Python."""
    return isinstance(value, _NUMBERS)


def kind_of(value: Any) -> Any:
    """LLVM type of a value; None for what has no type."""
    if value.__class__ is Value:
        return value.type
    kind = _KINDS.get(value.__class__)
    if kind is not None:
        return kind
    if is_number(value):  # of a class of its own, as NumPy's
        return WHOLE if isinstance(value, int) else REAL
    return getattr(value, "type", None)


def lanes_of(kind: Any) -> int:
    """Number of lanes of a type, of a record, or of what a pointer points to; 1 for a number."""
    if kind.__class__ in _SINGLE:
        return 1
    if hasattr(kind, "record"):
        return int(kind.lanes)
    kind = kind.pointee if isinstance(kind, ir.PointerType) else kind
    return int(kind.count) if isinstance(kind, ir.VectorType) else 1


def element_of(kind: Any) -> Any:
    """Type of the number in a lane."""
    return kind.element if isinstance(kind, ir.VectorType) else kind


def wide(kind: Any, lanes: int) -> Any:
    """Type with a number of this type in each lane."""
    return kind if lanes == 1 else ir.VectorType(kind, lanes)


def in_words(value: Any) -> str:
    """The type of a value in plain words."""
    kind = kind_of(value)
    word = _WORDS.get(element_of(kind))
    if word is None:
        if isinstance(kind, ir.PointerType):
            return f"a record '{kind.record.__name__}'" if hasattr(kind, "record") else "an array"
        return "no value" if kind is None or isinstance(kind, ir.VoidType) else f"a value of type {kind}"
    return word if lanes_of(kind) == 1 else f"{word} for each of {lanes_of(kind)} lanes"


def common_lanes(*values: Any) -> int:
    """Number of lanes in which values meet."""
    kinds = [kind for kind in map(kind_of, values) if kind.__class__ not in _SINGLE]
    if not kinds:
        return 1
    counts = {lanes_of(kind) for kind in kinds if not isinstance(kind, ir.PointerType)} - {1}
    if len(counts) > 1:
        raise Refusal(
            "values of one width", "Values meet one number with all lanes.", f"widths {sorted(counts)}"
        )
    return counts.pop() if counts else 1


# -- conversions ---------------------------------------------------------------------------------------


def constant(value: Any, kind: Any) -> Any:
    """LLVM constant of a number of Python."""
    element = element_of(kind)
    if element == WHOLE and not FIRST <= value <= LAST:
        raise Refusal(
            "an integer of 64 bits with its sign",
            "Subtract 2**64 from a pattern of bits beyond, or use a real number.",
            str(value),
        )
    number = element(value)
    return number if element is kind else ir.Constant(kind, [number] * kind.count)


def cast(builder: Any, value: Any, kind: Any) -> Any:
    """The value as an LLVM value of this type."""
    if value.__class__ is Value and value.type is kind:
        return value
    present = kind_of(value)
    if present == kind and not is_number(value):
        return value
    lanes, element = lanes_of(kind), element_of(kind)
    pointers = isinstance(kind, ir.PointerType) or isinstance(present, ir.PointerType)
    if present is None or pointers or lanes_of(present) not in (1, lanes):
        raise _unlike(value, kind)
    is_whole = element_of(present) == WHOLE and element == REAL
    if element_of(present) != element and not is_whole:
        raise _unlike(value, kind)
    if is_number(value):
        if is_whole:
            try:
                value = float(value)
            except OverflowError:
                raise Refusal("a real number", "Its size is at most 1.8e308.", str(value)) from None
        return constant(value, kind)
    if is_whole:
        value = builder.sitofp(value, wide(REAL, lanes_of(present)))
    return value if lanes_of(value.type) == lanes else splat(builder, value, lanes)


def _unlike(value: Any, kind: Any) -> Refusal:
    """Refusal of a value where another type is expected."""
    element, present = element_of(kind), kind_of(value)
    cure = "A name keeps the type of its first value, and an argument has that of its annotation."
    if lanes_of(present) > 1 and lanes_of(kind) == 1 and not isinstance(kind, ir.PointerType):
        cure = "any(c), all(c) and x[lane] give one value for all lanes."
    elif element == WHOLE and element_of(present) == REAL:
        cure = "whole(x) gives the integer part of a real number; a name that begins with 0.0 may hold it."
    elif element == TRUTH:
        cure = "Compare it, such as with != 0."
    elif element in (REAL, WHOLE) and element_of(present) == TRUTH:
        cure = "Write 1 if c else 0, or where(c, 1, 0)."
    expected = _WORDS.get(element, f"{kind}")
    if isinstance(kind, ir.PointerType):
        expected = f"a record '{kind.record.__name__}'" if hasattr(kind, "record") else "an array"
    return Refusal(expected, cure, in_words(value))


def splat(builder: Any, scalar: Any, lanes: int) -> Any:
    """Vector with a number in every lane."""
    undefined = ir.Constant(ir.VectorType(scalar.type, lanes), ir.Undefined)
    first = builder.insert_element(undefined, scalar, ir.IntType(32)(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), lanes), [0] * lanes)
    return builder.shuffle_vector(first, undefined, zeros)


def intrinsic(builder: Any, name: str, result: Any, *values: Any) -> Any:
    """Call a function of LLVM or of the C library and return its result."""
    function = builder.module.globals.get(name)
    if function is None:
        kind = ir.FunctionType(result, [value.type for value in values])
        function = Function(builder.module, kind, name)
    return builder.call(function, values)


def mathematical(builder: Any, name: str, *values: Any) -> Any:
    """Call an intrinsic function of real numbers, such as ``sqrt``, lane by lane."""
    kind = values[0].type
    suffix = f"v{kind.count}f64" if lanes_of(kind) > 1 else "f64"
    return intrinsic(builder, f"llvm.{name}.{suffix}", kind, *values)


# -- operations ----------------------------------------------------------------------------------------


def operated(builder: Any, operation: type, a: Any, b: Any) -> Any:
    """Sum, product, ... of two values."""
    if is_number(a) and is_number(b):
        return _folded(operation, a, b)
    lanes = common_lanes(a, b)
    elements = [element_of(kind_of(x)) for x in (a, b)]
    if operation in (ast.Div, ast.Pow) or REAL in elements:
        a, b = (cast(builder, x, wide(REAL, lanes)) for x in (a, b))
        if operation is ast.Pow:
            return mathematical(builder, "pow", a, b)
        if operation not in _OF_REALS:
            cure = "Real numbers have + - * / and **. whole(x) gives the integer part of one."
            raise Refusal("an operation on real numbers", cure)
        return getattr(builder, _OF_REALS[operation])(a, b)
    if TRUTH in elements and operation in _OF_TRUTHS:
        a, b = (cast(builder, x, wide(TRUTH, lanes)) for x in (a, b))
        return getattr(builder, _OF_TRUTHS[operation])(a, b)
    a_number, b_number = (x if is_number(x) else None for x in (a, b))
    a, b = (cast(builder, x, wide(WHOLE, lanes)) for x in (a, b))
    if operation in (ast.LShift, ast.RShift):
        b = _count(builder, b, b_number)
    if operation in _OF_INTEGERS:
        return getattr(builder, _OF_INTEGERS[operation])(a, b)
    if operation not in (ast.FloorDiv, ast.Mod):
        raise Refusal("an operation on integers", "Integers have + - * / // % ** << >> & | and ^.")
    if a_number is None and b_number == 0:
        raise Refusal("a divisor that is not 0", "Divide by another number.")
    return _divided(builder, operation, a, b, b_number)


def _folded(operation: type, a: Any, b: Any) -> Any:
    """Result of an operation on numbers of Python."""
    if operation not in _OF_PYTHON:
        raise Refusal("an operation on numbers", "Numbers have + - * / // % ** << >> & | and ^.")
    if operation is ast.LShift and isinstance(b, int) and not 0 <= b < 64:
        _count(None, None, b)
    try:
        result = _OF_PYTHON[operation](a, b)
    except (ArithmeticError, TypeError, ValueError) as error:
        raise Refusal("an operation that has a result", "Change the constants.", f"{error}") from None
    if not is_number(result):
        raise Refusal("a real result", "Change the constants.", str(result))
    return result


def _count(builder: Any, b: Any, number: Any) -> Any:
    """Number of places of a shift: of an unknown one, the processor takes the lowest six bits."""
    if number is not None and not 0 <= number < 64:
        raise Refusal("a shift by 0 to 63 places", "An integer has 64 bits.", str(number))
    return b if number is not None else builder.and_(b, constant(63, b.type))


def _divided(builder: Any, operation: type, a: Any, b: Any, number: Any) -> Any:
    """Floor of a / b, or the remainder, which has the sign of b.

    As in NumPy, a division by 0 gives 0, and -2^63 // -1 = -2^63: neither ends the process.
    """
    zero, one = constant(0, a.type), constant(1, a.type)
    divisor = b
    if number is None or number == -1:  # what the processor's division cannot do
        nothing = builder.icmp_signed("==", b, zero)
        inverse = builder.icmp_signed("==", b, constant(-1, a.type))
        divisor = builder.select(builder.or_(nothing, inverse), one, b)
    # the processor rounds towards zero, and its remainder has the sign of the dividend
    quotient, remainder = builder.sdiv(a, divisor), builder.srem(a, divisor)
    unlike = builder.icmp_signed("<", builder.xor(remainder, divisor), zero)
    corrected = builder.and_(builder.icmp_signed("!=", remainder, zero), unlike)
    if operation is ast.FloorDiv:
        result = builder.sub(quotient, builder.zext(corrected, a.type))
    else:
        result = builder.select(corrected, builder.add(remainder, divisor), remainder)
    if divisor is b:
        return result
    if operation is ast.FloorDiv:
        result = builder.select(inverse, builder.sub(zero, a), result)
    return builder.select(nothing, zero, result)


def compared(builder: Any, operation: type, a: Any, b: Any) -> Any:
    """Truth value of a comparison of two values."""
    if operation not in _COMPARISONS:
        cure = "There are ==, !=, <, <=, > and >=; compare with each value in turn."
        raise Refusal("a comparison of two numbers", cure)
    if is_number(a) and is_number(b):
        return _OF_PYTHON[operation](a, b)
    lanes, elements = common_lanes(a, b), [element_of(kind_of(x)) for x in (a, b)]
    element = REAL if REAL in elements else TRUTH if TRUTH in elements else WHOLE
    a, b = (cast(builder, x, wide(element, lanes)) for x in (a, b))
    sign = _COMPARISONS[operation]
    if element == TRUTH:
        return builder.icmp_unsigned(sign, a, b)  # false < true
    if element == WHOLE:
        return builder.icmp_signed(sign, a, b)
    # with nan, every comparison but != is false
    return (builder.fcmp_unordered if operation is ast.NotEq else builder.fcmp_ordered)(sign, a, b)


def opposite(builder: Any, value: Any) -> Any:
    """-value."""
    element = element_of(kind_of(value))
    if element not in (REAL, WHOLE):
        raise Refusal("a sign of a number", "A truth value has 'not'; 1 if c else 0 makes a number of it.")
    if is_number(value):
        return -value
    return builder.fneg(value) if element == REAL else builder.sub(constant(0, kind_of(value)), value)


def negated(builder: Any, value: Any) -> Any:
    """Not value."""
    if is_number(value):
        return not value
    if element_of(kind_of(value)) != TRUTH:
        raise Refusal("'not' of a truth value", "Compare with 0.")
    return builder.not_(value)


def size(builder: Any, value: Any) -> Any:
    """Absolute value."""
    kind = kind_of(value)
    if element_of(kind) not in (REAL, WHOLE):
        raise Refusal("a number", "abs takes an integer or a real number.", in_words(value))
    if is_number(value):
        return abs(value)
    if element_of(kind) == REAL:
        return mathematical(builder, "fabs", value)
    negative = builder.icmp_signed("<", value, constant(0, kind))
    return builder.select(negative, builder.sub(constant(0, kind_of(value)), value), value)


def selected(builder: Any, c: Any, a: Any, b: Any) -> Any:
    """a where c holds, b elsewhere; both are evaluated."""
    lanes = common_lanes(c, a, b)
    elements = [element_of(kind_of(x)) for x in (a, b)]
    element = REAL if REAL in elements else elements[0]
    if element not in (REAL, WHOLE, TRUTH):
        raise Refusal("two numbers", "where(c, a, b) chooses between numbers.", in_words(a))
    if is_number(c):
        c = TRUTH(bool(c))
    if element_of(kind_of(c)) != TRUTH:
        raise Refusal("a truth value", "Compare with 0.", in_words(c))
    if lanes > 1:
        c = cast(builder, c, wide(TRUTH, lanes))
    return builder.select(c, *(cast(builder, x, wide(element, lanes)) for x in (a, b)))
