"""Functions in machine code: each gives what Python gives where it runs the same text."""

from __future__ import annotations

import ctypes
import itertools
import math

import numpy as np
import pytest

from freebody.native import codegen
from freebody.native.functions import Compiled, Inlined, each
from freebody.native.instructions import (
    Integers,
    Real,
    Reals,
    compiled,
    greater,
    hot,
    integers_at,
    lesser,
    root,
    shifted,
    where,
    whole,
    with_bits,
)
from freebody.native.translation import by_heat, translated

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
    total, last, i = 0, -1, 0
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
        if function is reals:  # powers are the library's
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
    return ctypes[a]


def nothing(a: int) -> int:
    b = None
    return a if b else 0


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (an_integer_becomes_real, r"an integer in 'an_integer_becomes_real'.* got a real number, 'a'"),
        (no_truth, "a truth value in 'no_truth'.* got an integer, 'a'"),
        (otherwise, "a loop without else in 'otherwise'"),
        (unknown, "a name that has a value in 'unknown'.* got 'nowhere'"),
        (late, "a name that has a value in 'late', .* got 'b'"),
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
        (negative_truth, "a sign of a number in 'negative_truth'"),
        (of_number, "a name of a module"),
        (no_table, "a table of numbers"),
        (nothing, "a number or an array for 'b'"),
    ],
)
def test_what_no_processor_has_is_refused_with_its_place(function, message):
    with pytest.raises(TypeError, match=rf"Expected {message}.*\(test_translation\.py, line \d+\)\. \S.+\.$"):
        translated({"f": Compiled(function)})


def test_instruction_is_not_for_python():
    with pytest.raises(TypeError, match="Expected compiled code to call 'greater', got a call from Python"):
        greater(1.0, 2.0)


def falls_off(a: int) -> int:
    if a > 0:
        return 1


def on_one_way(a: int) -> int:
    if a > 0:
        b = 1
    return b


def after_no_round(a: int) -> int:
    for i in range(a):
        b = i
    return b


def from_the_end(p: Reals) -> float:
    return p[-1]


def beyond_the_table(a: int) -> float:
    return TABLE[2, a]


def one_place(a: int) -> float:
    return TABLE[a]


def beyond_an_integer(a: int) -> int:
    return a + 2**63


def constant_division(a: int) -> float:
    return a + 1 / CLOSED


def long_shift(a: int) -> int:
    return a << 64


def many_bounds(a: int) -> int:
    for i in range(0, a, 1, 2):
        a += i
    return a


def named_bounds(a: int) -> int:
    for i in range(a, step=1):
        a += i
    return a


def no_condition(a: int) -> int:
    return (a > 0) and 3


def in_pairs(a: int) -> int:
    b, c = (a, a) if a > 0 else (a, 1)
    return b + c


def by_default(a: int, b: int = 2) -> int:
    return a + b


def without_type(a, b: int) -> int:
    return a + b


def of_text(a: str) -> int:
    return 1


def returns_nothing(a: int) -> int:
    return


def returns_something(a: int) -> None:
    return a


def on_all_lanes(x: Real) -> Real:
    if x > 0.0:
        x = 0.0
    return x


def chosen_for_all(x: Real) -> Real:
    return 0.0 if x > 0.0 else x


def called_for_all(x: Real) -> Real:
    return where(x > 0.0 and HELPER(x) > 0.0, 1.0, x)


def outside_a_loop(x: Real) -> Real:
    each(x > 0.0)
    return x


def into_a_number(x: Real, p: Reals) -> None:
    p[0] = x


def _itself(x: Real) -> Real:
    return x


HELPER = Compiled(_itself)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (falls_off, "a value on every way in 'falls_off'"),
        (on_one_way, "a name that has a value on every way to here in 'on_one_way'.* got 'b'"),
        (after_no_round, "a name that has a value on every way to here in 'after_no_round'.* got 'b'"),
        (from_the_end, "a place from 0 on"),
        (beyond_the_table, "a place from 0 to 1"),
        (one_place, "2 places in the table 'TABLE'"),
        (beyond_an_integer, "an integer of 64 bits with its sign.* got 9223372036854775808"),
        (constant_division, "an operation that has a result.* got division by zero"),
        (long_shift, "a shift by 0 to 63 places.* got 64"),
        (many_bounds, "a range of one, two or three integers"),
        (named_bounds, "a loop over range"),
        (no_condition, "a truth value in 'no_condition'"),
        (in_pairs, "two numbers or two arrays"),
        (by_default, "arguments by position without defaults for 'by_default'.* got 'b: 'int' = 2'"),
        (without_type, "a type for every argument and for the result of 'without_type'.* got none for a"),
        (of_text, "a type of the compiled language for 'a' of 'of_text', got 'str'"),
        (returns_nothing, "a value to return"),
        (returns_something, "no value to return"),
        (on_all_lanes, "a truth value in 'on_all_lanes'.* got a truth value for each of 8 lanes"),
        (chosen_for_all, "a truth value in 'chosen_for_all'"),
        (called_for_all, "operands without calls of functions"),
        (outside_a_loop, r"a loop over each\(c\)"),
        (into_a_number, "a real number in 'into_a_number'.* got a real number for each of 8 lanes"),
    ],
)
def test_strange_code_is_refused_with_the_cure(function, message):
    with pytest.raises(TypeError, match=rf"Expected {message}.*\(test_translation\.py, line \d+\)\. \S.+\.$"):
        translated({"f": Compiled(function)}, 8)


def noted(k: Integers, truth: int) -> int:
    k[0] += 1
    return truth


def with_effects(k: Integers, a: int) -> int:
    """What Python calls is called, though a constant decides behind it; what it does not call is not."""
    result = 0
    if NOTED(k, a) > 0 and CLOSED != 0:
        result += 1
    if 0 < a < NOTED(k, 2):
        result += 10
    if a > 2 and NOTED(k, a) > 0:
        result += 100
    return result


NOTED = Compiled(noted)


@pytest.mark.parametrize(("a", "result", "calls"), [(0, 0, 1), (1, 10, 2), (3, 100, 3)])
def test_calls_in_conditions_are_those_of_python(a, result, calls):
    k = np.zeros(1, dtype=np.int64)
    assert machine_code(with_effects)(k, a) == result
    assert k[0] == calls


def order_of_truths(a: int, b: int) -> int:
    return (
        (1 if (a > 0) < (b > 0) else 0)
        + (2 if (a > 0) >= (b > 0) else 0)
        + (OPEN and 4 or 8)
        + (CLOSED or 16)
    )


def test_false_is_less_than_true_and_constants_decide_as_in_python():
    run = machine_code(order_of_truths)
    for a, b in itertools.product((0, 1), (0, 1)):
        assert run(a, b) == order_of_truths(a, b)


def near_the_end(first: int, last: int) -> int:
    rounds = 0
    for _ in range(first, last, 5):
        rounds += 1
    for _ in range(last, first, -7):
        rounds += 100
    return rounds


@pytest.mark.parametrize("first", [2**63 - 13, 2**63 - 11, -(2**63), 5])
@pytest.mark.parametrize("length", [0, 1, 6, 10])
def test_loops_end_where_integers_end(first, length):
    last = min(first + length, 2**63 - 1)
    assert machine_code(near_the_end)(first, last) == near_the_end(first, last)


def by_nothing(a: int, b: int) -> int:
    return a // b * 1000 + a % b


def test_no_division_ends_the_process():
    run = machine_code(by_nothing)
    assert run(7, 0) == run(0, 0) == 0
    assert run(-(2**63), -1) == 0  # 1000 (-2^63) in 64 bits
    assert run(-7, 2) == by_nothing(-7, 2)


def test_a_function_of_a_closure_takes_its_numbers():
    factor = 3.0

    def scaled(x: float) -> float:
        return factor * x

    assert machine_code(scaled)(2.0) == 6.0
    assert not [name for name in ("scaled",) if name in globals()]


def test_a_function_without_a_file_is_refused():
    space = {}
    exec("from __future__ import annotations\ndef f(a: int) -> int:\n    return a", space)
    with pytest.raises(
        TypeError, match=r"Expected the text of 'f' in .*, got another\. Write the function with def"
    ):
        translated({"f": Compiled(space["f"])})


def sum_and_product(a: Real, b: Real) -> tuple[Real, Real]:
    result = a
    for i in range(1):
        result += b + i
    return result, a * b


def of_both(a: float, b: float) -> float:
    if a < b:
        a, b = b, a
    s, p = BOTH(a, b)
    both = BOTH(s, 2)
    t, q = both
    return s + 10 * p + 100 * t + 1000 * q


BOTH = Inlined(sum_and_product)


def test_a_function_at_the_place_of_its_call_gives_several_values():
    assert machine_code(of_both)(2.0, 3.0) == 5 + 60 + 700 + 10000
    assert translated({"f": Compiled(of_both)}).count("define") == 1


def two_ends(a: float) -> float:
    if a > 0.0:
        return a
    return -a


def around_itself(a: float) -> float:
    return AROUND(a)


def fewer(a: float) -> tuple[float, float]:
    return a


def changed_by_a_branch(a: float, b: float) -> float:
    both = BOTH(a, b)
    if a > 0.0:
        both = BOTH(b, b)
    s, p = both
    return s + p


TWO_ENDS, AROUND, FEWER = map(Inlined, (two_ends, around_itself, fewer))


def call_two_ends(a: float) -> float:
    return TWO_ENDS(a)


def call_around(a: float) -> float:
    return AROUND(a)


def call_fewer(a: float) -> float:
    b, c = FEWER(a)
    return b


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (call_two_ends, "one return with a value, at the end in 'two_ends'"),
        (call_around, "a function that does not call itself"),
        (call_fewer, "2 values in 'fewer'"),
        (changed_by_a_branch, "a name that has a value .*'changed_by_a_branch'.* got 'both'"),
    ],
)
def test_a_function_at_the_place_of_its_call_is_refused(function, message):
    with pytest.raises(TypeError, match=rf"Expected {message}.*\(test_translation\.py, line \d+\)\. \S.+\.$"):
        translated({"f": Compiled(function)})


@hot
@compiled
def doubled(x: Reals, n: int) -> None:
    for k in range(n):
        x[k] *= 2.0


@compiled
def doubled_and_summed(x: Reals, n: int) -> float:
    doubled(x, n)
    total = 0.0
    for k in range(n):
        total += x[k]
    return total


def test_hot_functions_alone_get_all_passes_and_results_have_the_same_bits():
    text, others = by_heat({"f": doubled_and_summed})
    for part, name in ((text, "@own.doubled("), (others, "@f(")):
        heads = [line for line in part.splitlines() if line.startswith("define")]
        assert len(heads) == 1
        assert name in heads[0]
    results = []
    for passes in ("all", "hot", "few", "none"):
        texts = (text, others) if passes == "hot" else (translated({"f": doubled_and_summed}), "")
        library = codegen.Library(codegen.optimised_code(texts[0], passes=passes, others=texts[1])[0])
        f = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_int64)(library.addresses(["f"])["f"])
        x = np.arange(37.0) / 3
        results.append((f(x.ctypes.data, x.size), x.tobytes()))
    assert len(set(results)) == 1
