"""Functions in machine code: each gives what Python gives where it runs the same text."""

from __future__ import annotations

import ctypes
import itertools
import math

import numpy as np
import pytest

from freebody.native import codegen
from freebody.native.instructions import (
    Integers,
    Reals,
    greater,
    integers_at,
    lesser,
    root,
    shifted,
    whole,
    with_bits,
)
from freebody.native.translation import Compiled, translated

TABLE = np.arange(6.0).reshape(2, 3) ** 2
CLOSED, OPEN = 0, 1
MISSING = None
C_TYPES = {"None": None, "int": ctypes.c_int64, "float": ctypes.c_double}


def machine_code(function):
    """The function for Python; arrays are addressed."""
    made = Compiled(function)
    code, _ = codegen.optimised_code(translated({"f": made}))
    library = codegen.Library(code)
    call = ctypes.CFUNCTYPE(
        C_TYPES[made.result], *(C_TYPES.get(kind, ctypes.c_void_p) for kind in made.arguments)
    )(library.addresses(["f"])["f"])

    def run(*values):
        assert library is not None
        return call(*(x.ctypes.data if isinstance(x, np.ndarray) else x for x in values))

    return run


def integers(a: int, b: int) -> int:
    return (a + b) * 1000 + (a - b) * 100 + a // b * 10 + a % b + (a << 3) - -b


def reals(a: float, b: float, k: int) -> float:
    c = a + b * 2 - k / 3 + abs(a) ** 1.5 / (1 + b * b)
    c -= -a
    c /= 1 + k * k
    return c * math.log2(2 + abs(b)) if a < b else c


def order(a: float, b: float) -> int:
    result = 0
    result += 1 if a < b else 0
    result += 2 if a <= b else 0
    result += 4 if a == b else 0
    result += 8 if a != b else 0
    result += 16 if not a > b else 0
    result += 32 if not a >= b else 0
    result += 64 if -1.0 < a < b <= 1.0 else 0
    result += 128 if (a > 0.0) == (b > 0.0) else 0
    result += 256 if a > b or (a < 0.0 and not b < 0.0) else 0
    result += 512 if math.isfinite(a) and math.isfinite(b) else 0
    both = a > 0.0 and b > 0.0
    return -result if both else result


def loops(n: int, m: int) -> int:
    total, last = 0, -1
    for i in range(n, -m, -2):
        if i % 5 == 0:
            continue
        for j in range(i):
            if j > m:
                break
            total += i * j
            last = j
        total = total - last
    k, going = 0, True
    while going and k < m:
        k += 1
        if k * k > n:
            going = False
    for i in range(3):
        total += i * k
    return total * 100 + i + last


def tables(i: int, j: int) -> float:
    a, b = TABLE[i, j], TABLE[1 - i, 2 - j]
    a, b = b, a
    return 10.0 * a - b


def pruned(a: int) -> int:
    if CLOSED != 0:
        a = MISSING(a)
    if OPEN == 0 or (CLOSED != 0 and a > 0):
        return MISSING(a)
    if OPEN != 0:
        a += 1
    else:
        a = MISSING(a)
    return a if OPEN == 1 else MISSING(a)


NUMBERS = (-2.5, -1.0, -0.0, 0.5, 1.0, 3.0, math.inf, -math.inf, math.nan)


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (integers, [(a, b) for a in range(-7, 8) for b in (-5, -2, 1, 3, 8)]),
        (reals, [(a, b, k) for a, b, k in itertools.product(NUMBERS[:6], NUMBERS[:6], (-3, 0, 4))]),
        (order, list(itertools.product(NUMBERS, NUMBERS))),
        (loops, [(n, m) for n in range(9) for m in range(-3, 7)]),
        (tables, [(i, j) for i in range(2) for j in range(3)]),
        (pruned, [(k,) for k in range(-2, 3)]),
    ],
)
def test_machine_code_gives_what_python_gives(function, arguments):
    run = machine_code(function)
    for values in arguments:
        if function is reals:  # products and sums may be fused, and powers are the library's
            assert run(*values) == pytest.approx(function(*values), rel=1e-14, abs=1e-14)
        else:
            assert run(*values) == function(*values), values


def sorted_up(x: Reals, n: int, moves: Integers) -> None:
    """By insertion: what stands before the array is not looked at."""
    for i in range(n):
        k = i
        while k > 0 and x[k - 1] > x[k]:
            x[k - 1], x[k] = x[k], x[k - 1]
            moves[0] += 1
            k -= 1


def test_arrays_are_read_and_written_in_place():
    x, moves = np.array([3.0, 1.0, 2.0, -1.0, 1.0]), np.zeros(1, dtype=np.int64)
    machine_code(sorted_up)(x, 5, moves)
    assert x.tolist() == [-1.0, 1.0, 1.0, 2.0, 3.0]
    assert moves[0] == 7  # pairs out of order


def instructions(x: Reals, addresses: Integers) -> float:
    more, of_integers = shifted(x, 1), integers_at(addresses[0])
    x[0] = more[0] = greater(x[0], more[0])
    more[1] = of_integers[1] = whole(-2.9)
    return root(more[0]) + lesser(0.25, 3) + with_bits(0x3FF << 52)


def test_instructions_stand_for_calls():
    x, counts = np.array([4.0, 9.0, 0.0]), np.zeros(2, dtype=np.int64)
    addresses = np.array([counts.ctypes.data])
    assert machine_code(instructions)(x, addresses) == 3 + 0.25 + 1
    assert x.tolist() == [9.0, 9.0, -2.0]
    assert counts.tolist() == [0, -2]


def test_division_by_zero_is_the_processors():
    def ratio(a: float, b: float) -> float:
        return a / b

    run = machine_code(ratio)
    assert run(1.0, 0.0) == math.inf
    assert run(-1.0, 0.0) == -math.inf
    assert math.isnan(run(0.0, 0.0))


# --- refused ---------------------------------------------------------------------------------------


def an_integer_becomes_real(a: int) -> int:
    a = 0.5
    return a


def otherwise(a: int) -> int:
    while a > 0:
        a -= 1
    else:
        a = 7
    return a


def no_truth(a: int) -> int:
    return 1 if a else 0


def unknown(a: int) -> int:
    return nowhere(a)  # noqa: F821


def python(a: int) -> int:
    return len(a)


def comprehension(a: int) -> int:
    return [a][0]


def caught(a: int) -> int:
    try:
        a += 1
    finally:
        a += 2
    return a


def not_in_order(a: int) -> int:
    for k in (1, 2):
        a += k
    return a


def steps_unknown(a: int) -> int:
    for k in range(0, 10, a):
        a += k
    return a


def too_few(a: float) -> float:
    return greater(a)


def bits_of_real(a: float) -> float:
    return a << 1


def member(a: int) -> int:
    return 1 if a in (1, 2) else 0


def pair(a: int) -> int:
    a, b = a
    return b


def late(a: int) -> int:
    if a > 0:
        a = b  # noqa: F821
    b = 1
    return a + b


def negative_truth(a: int) -> int:
    b = -(a > 0)
    return b


def real_remainder(a: float) -> float:
    return a % 2.0


def named(a: float) -> float:
    return greater(a, b=a)


def of_number(a: float) -> float:
    return a.real


def no_table(a: int) -> int:
    return C_TYPES[a]


def nothing(a: int) -> int:
    b = None
    return a if b else 0


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (an_integer_becomes_real, r"a value of type i64 in 'an_integer_becomes_real'.* got double of"),
        (no_truth, "a value of type i1 in 'no_truth'.* got i64 of 'a'"),
        (otherwise, "a loop without else in 'otherwise'"),
        (unknown, "a name that has a value in 'unknown'.* got 'nowhere'"),
        (late, "a name that has a value, .* got 'b'"),
        (python, "a function that is compiled in 'python'"),
        (comprehension, "an expression of the compiled language in 'comprehension'"),
        (caught, "a statement of the compiled language in 'caught'"),
        (not_in_order, "a loop over range"),
        (steps_unknown, "a loop with a constant step"),
        (too_few, "2 arguments"),
        (named, "2 arguments"),
        (bits_of_real, "an operation on real numbers"),
        (real_remainder, "an operation on real numbers"),
        (member, "a comparison of two numbers"),
        (pair, "as many values as names"),
        (negative_truth, "a sign of a number, or 'not' of a truth value"),
        (of_number, "a field of a record, or a name of a module"),
        (no_table, "a table of numbers"),
        (nothing, "a number or a pointer for 'b'"),
    ],
)
def test_what_no_processor_has_is_refused_with_its_place(function, message):
    with pytest.raises(TypeError, match=rf"Expected {message}.*\(test_translation\.py, line \d+\)"):
        translated({"f": Compiled(function)})


def test_instruction_is_not_for_python():
    with pytest.raises(TypeError, match="Expected compiled code to call 'greater', got a call from Python"):
        greater(1.0, 2.0)
