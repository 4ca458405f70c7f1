"""Records: Python and machine code read the same fields at the same places; every misuse is refused with its cure."""

from __future__ import annotations

import ctypes
from typing import Annotated

import numpy as np
import pytest

from freebody.native import codegen
from freebody.native.functions import Compiled, unrolled
from freebody.native.records import Count, Kernel, Real, Row, Rows, Whole, Wholes, record
from freebody.native.rows import chain, combination
from freebody.native.translation import translated

SIDES = 2


@record
class Search:
    count: Count
    reach: Real
    signs: Annotated[Wholes, "events"]


@record
class Run:
    """A record with a field of every kind."""

    t: Real
    taken: Whole
    width: Count
    y: Annotated[Row, "width"]
    given: Row
    table: Rows
    search: Search
    other: Search
    k: Annotated[Rows, 3, "width"]
    ends: Annotated[Rows, SIDES, 4]
    rates: Kernel
    h: Real


def machine_code(function):
    """The function for Python, called with records."""
    translation = Compiled(function)
    code, _ = codegen.optimised_code(translated({"f": translation}))
    library = codegen.Library(code)
    result = {"None": None, "int": ctypes.c_int64, "float": ctypes.c_double}[translation.result]
    kinds = (ctypes.c_double if kind == "float" else ctypes.c_void_p for kind in translation.arguments)
    call = ctypes.CFUNCTYPE(result, *kinds)(library.addresses(["f"])["f"])

    def run(*values):
        assert library is not None
        return call(*(getattr(value, "address", value) for value in values))

    return run


def a_run() -> Run:
    run = Run.made(width=5, events=2)
    run.width = 5
    return run


@record
class Inner:
    n: Annotated[Wholes, 3]


@record
class Tailed:
    width: Count
    x: Annotated[Row, "width"]
    tail: Row
    inner: Inner


def test_python_and_machine_code_find_every_field_at_one_place():
    """Machine code copies each field into the next number of a row. Python wrote other numbers into all of them."""

    def read(run: Run) -> None:
        out = run.given
        out[0] = run.t
        out[1] = run.taken
        out[2] = run.width
        out[3] = run.y[4]
        out[4] = run.search.count
        out[5] = run.search.reach
        out[6] = run.search.signs[1]
        out[7] = run.other.reach
        out[8] = run.other.signs[0]
        out[9] = run.k[2, 3]
        out[10] = run.k[1][4]
        out[11] = run.ends[1, 2]
        out[12] = run.h
        out[13] = run.y[2:][1]

    run = a_run()
    run.given = np.zeros(14)
    run.t, run.taken, run.h = 1.5, -2, 12.5
    run.y[:] = 0, 10, 20, 30, 40
    run.search.count, run.search.reach, run.other.reach = 3, 2.5, 7.5
    run.search.signs[:] = 5, -6
    run.other.signs[:] = -8, 9
    run.k[:] = np.arange(15.0).reshape(3, 5)
    run.ends[:] = -np.arange(8.0).reshape(2, 4)
    machine_code(read)(run)
    assert run.given.tolist() == [1.5, -2, 5, 40, 3, 2.5, -6, 7.5, -8, 13, 9, -6, 12.5, 30]


def test_what_machine_code_assigns_python_reads_and_nothing_else_changes():
    def write(run: Run) -> None:
        run.t += 1
        run.taken = run.width << 1
        run.other.reach = -1.0
        run.search.signs[1] = 9
        run.k[1, 2] = 7.0
        last = run.k[2]
        last[0] = 8.0
        run.ends[0][3] -= 2.0

    run = a_run()
    before = {
        name: run.memory.view(np.uint8)[field.place : field.place + 8].copy()
        for name, field in Run.fields.items()
    }
    machine_code(write)(run)
    assert (run.t, run.taken, run.other.reach, run.search.reach) == (1.0, 10, -1.0, 0.0)
    assert run.search.signs.tolist() == [0, 9] and run.other.signs.tolist() == [0, 0]
    assert run.k.sum() == 15.0 and run.k[1, 2] == 7.0 and run.k[2, 0] == 8.0
    assert run.ends[0, 3] == -2.0
    changed = {
        name
        for name, old in before.items()
        if (run.memory.view(np.uint8)[Run.fields[name].place :][:8] != old).any()
    }
    assert changed == {"t", "taken"}


def test_the_structured_view_of_numpy_has_the_same_places():
    run = a_run()
    run.t, run.taken, run.search.reach, run.h = 1.0, 2, 3.0, 4.0
    view = np.frombuffer(run.memory, dtype=Run.dtype, count=1)[0]
    assert (view["t"], view["taken"], view["search"]["reach"], view["h"]) == (1.0, 2, 3.0, 4.0)
    assert Run.dtype.itemsize == Run.size == 8 * 19
    assert view["k"][1] == 5 and view["y"] % 64 == 0


def test_a_kernel_is_called_through_its_field_and_compared_with_none():
    def step(run: Run) -> int:
        if run.rates is None:
            return 0
        run.rates(run.t, run.y, run.given, run.k[1])
        return 1 if run.rates is not None else 2

    run = a_run()
    run.given, run.t = np.array([10.0]), 0.5
    run.y[0] = 2.0
    f = machine_code(step)
    assert f(run) == 0

    @ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.POINTER(ctypes.c_double)] * 3)
    def rates(t, y, c, out):
        out[0] = t + y[0] + c[0]

    run.rates = ctypes.cast(rates, ctypes.c_void_p).value
    assert f(run) == 1
    assert run.k[1, 0] == 12.5


@Compiled
def called(search: Search, by: float) -> float:
    search.reach += by
    return search.reach


def test_a_record_is_passed_to_functions_and_found_at_a_row():
    def both(run: Run) -> float:
        part = Search(run.given)
        return called(run.search, 1.0) + 10 * called(part, 2.0)

    run = a_run()
    elsewhere = Search.made(events=1)
    run.given = elsewhere.memory
    assert machine_code(both)(run) == 21.0
    assert (run.search.reach, elsewhere.reach) == (1.0, 2.0)


def unknown_field(run: Run) -> float:
    return run.q


def assigned_row(run: Run) -> None:
    run.y = run.given


def assigned_table(run: Run) -> None:
    run.k = run.given


def assigned_count(run: Run) -> None:
    run.width += 1


def assigned_kernel(run: Run) -> None:
    run.rates = run.rates


def assigned_record(run: Run) -> None:
    run.search = run.other


def wrong_type(run: Run) -> None:
    run.taken = run.t


def other_record(run: Run) -> None:
    run.t = called(run, 1.0)


def arguments_of_kernel(run: Run) -> None:
    run.rates(run.t, run.y)


def one_index(run: Run) -> None:
    run.k[1] = 0.0


def part_of_row(run: Run) -> None:
    run.rates(run.t, run.y[1:3], run.y, run.y)


def unknown_type(run: Ran) -> None:  # noqa: F821
    run.t = 0.0


@pytest.mark.parametrize(
    ("function", "parts"),
    [
        (unknown_field, ("a field of the record 'Run'", "Fields are t, taken, width, y,", "'q'", "'unknown_field'")),
        (assigned_row, ("'Run.y', a row (", "Assign to its components, [i], or to all of them, [:]")),
        (assigned_table, ("'Run.k', a row (", "Assign to its components, [i]")),
        (assigned_count, ("'Run.width', a count (", "Only Python assigns it.")),
        (assigned_kernel, ("'Run.rates', a kernel (", "Only Python assigns it.")),
        (assigned_record, ("'Run.search', a record (", "Assign to its fields.")),
        (wrong_type, ("an integer", "a real number", "whole(x) gives")),
        (arguments_of_kernel, ("4 arguments",)),
        (one_index, ("two indices of a component", "Write [j, i].")),
        (part_of_row, ("the rest of an array", "'run.y[1:3]'", "Write row[k:].")),
        (unknown_type, ("a type of the compiled language for 'run'", "'Ran'", "and records")),
    ],
)  # fmt: skip
def test_misuse_is_refused_with_its_line_and_cure(function, parts):
    with pytest.raises(TypeError) as refusal:
        translated({"f": Compiled(function)})
    text = str(refusal.value)
    for part in (*parts, "test_records.py, line "):
        assert part in text, text


def test_python_refuses_arrays_of_another_kind():
    run = a_run()
    for name, value, expected in (
        ("y", [1.0], "a contiguous array of float64 with 1 dimension for 'y', got [1.0]"),
        ("y", np.zeros(4)[::2], "a contiguous array of float64"),
        ("y", np.zeros(4, dtype=int), "got int64 of shape (4,)"),
        ("k", np.zeros(4), "with 2 dimensions for 'k', got float64 of shape (4,)"),
        ("search", run.other, "an assignment to a field of 'search', which is a record"),
    ):
        with pytest.raises(TypeError) as refusal:
            setattr(run, name, value)
        assert expected in str(refusal.value)


def test_declarations_that_have_no_layout_are_refused():
    def declared(**fields):
        return type("Wrong", (), {"__annotations__": fields, "__module__": __name__})

    for fields, name in (
        ({"x": "float"}, "Wrong.x"),
        ({"x": "Annotated[Real, 3]"}, "Wrong.x"),
        ({"x": "Annotated[Rows, 3]"}, "Wrong.x"),
        ({"memory": "Real"}, "'memory'"),
    ):
        with pytest.raises(TypeError) as refusal:
            record(declared(**fields))
        assert name in str(refusal.value)


WEIGHTS = ((), (0.5,), (0.25, 0.0, -1.5), {0: 2.0, 2: 1.0})


def test_a_row_is_assigned_as_a_whole():
    """Each component is that of the formula. Products join sums with one rounding or with two, by the processor."""

    def formula(run: Run, h: float) -> None:
        run.y[:] = run.k[0] + h * combination(WEIGHTS[2], run.k)
        run.k[1][:] = h * combination(WEIGHTS[3], run.k) - run.k[0] / 2
        run.k[2][:] = run.y

    run = Run.made(width=16, events=0)
    assert run.width == 16
    k = np.random.default_rng(3).normal(size=(3, 16))
    run.k[:] = k
    machine_code(formula)(run, 0.3)
    y = k[0] + 0.3 * (0.25 * k[0] - 1.5 * k[2])
    assert np.allclose(run.y, y, rtol=4 * np.finfo(float).eps, atol=4 * np.finfo(float).eps)
    assert np.allclose(run.k[1], 0.3 * (2 * k[0] + k[2]) - k[0] / 2, rtol=0, atol=8 * np.finfo(float).eps)
    assert (run.k[2] == run.y).all()


def test_a_chain_has_the_value_of_the_combination_and_its_last_row_is_added_last():
    def formula(run: Run, h: float) -> None:
        for j in unrolled(1, 4):
            run.y[:] = run.y + h * chain(WEIGHTS[j], run.k)

    run = Run.made(width=8, events=0)
    run.k[:] = k = np.random.default_rng(4).normal(size=(3, 8))
    machine_code(formula)(run, 0.3)
    expected = 0.3 * (0.5 * k[0] + (0.25 * k[0] - 1.5 * k[2]) + (2 * k[0] + k[2]))
    assert np.allclose(run.y, expected, rtol=0, atol=16 * np.finfo(float).eps)


def unnamed_length(run: Run) -> None:
    run.given[:] = run.y


def unnamed_length_of_a_table(run: Run) -> None:
    run.table[1][:] = run.y


def part_assigned(run: Run) -> None:
    run.y[1:] = run.y


def outside(run: Run) -> None:
    run.t = combination(WEIGHTS[2], run.k)


def varying_place(run: Run) -> None:
    for i in range(3):
        run.y[:] = run.y + run.t * chain(WEIGHTS[i], run.k)


def beyond_constants(run: Run) -> None:
    run.y[:] = run.y + run.t * chain(WEIGHTS[7], run.k)


def chain_outside(run: Run) -> None:
    run.t = chain(WEIGHTS[2], run.k)


def unrolled_outside(run: Run) -> None:
    unrolled(1, 12)


def component_of_number(run: Run) -> None:
    run.t[0] = 1.0


def rows_of_record(run: Run) -> float:
    return run.search[0, 1]


def other_record_passed(run: Run) -> None:
    called(run, 1.0)


def unrolled_by_a_number(run: Run) -> None:
    for i in unrolled(run.width):
        run.y[i] = 0.0


def unrolled_name(run: Run) -> float:
    for i in unrolled(3):
        run.y[i] = 0.0
    return i


@pytest.mark.parametrize(
    ("function", "parts"),
    [
        (unnamed_length, ("a row with a length", "'run.given[:] = run.y'", 'Annotated[Row, "width"]')),
        (unnamed_length_of_a_table, ("a row with a length", "'run.table[1][:] = run.y'")),
        (part_assigned, ("an assignment to all components of one row", "row[:] = formula")),
        (outside, ("a combination of rows in an assignment to a row",)),
        (chain_outside, ("a chain in an assignment to a row", "row[:] = y + h * chain(weights, rows)")),
        (unrolled_outside, ("a loop over unrolled(...)", "for i in unrolled(1, 12)")),
        (component_of_number, ("an array that has components", "'run.t[0]'")),
        (rows_of_record, ("an integer", "'(0, 1)'")),
        (other_record_passed, ("a record 'Search'", "got a record 'Run'")),
        (varying_place, ("a constant place", "'WEIGHTS[i]'", "unrolled(...) gives constants")),
        (beyond_constants, ("a place in these constants", "got 7", "There are 4 elements.")),
        (unrolled_by_a_number, ("one, two or three constant integers", "unrolled(start, stop)")),
        (unrolled_name, ("a name that has a value", "'i'")),
    ],
)  # fmt: skip
def test_misuse_of_rows_is_refused_with_its_line_and_cure(function, parts):
    with pytest.raises(TypeError) as refusal:
        translated({"f": Compiled(function)})
    for part in (*parts, "test_records.py, line "):
        assert part in str(refusal.value), refusal.value


def test_records_stand_side_by_side_with_shared_rows():
    def second(runs: Run) -> float:
        runs[1].t += 1.0
        runs[1].k[0, 0] = 7.0
        return runs[1].t

    first = Run.made(width=4, events=1)
    first.t = 2.0
    runs = first.copies(3)
    assert machine_code(second)(runs) == 3.0
    assert (runs.t, runs[1].t, runs[2].t) == (2.0, 3.0, 2.0) and first.k[0, 0] == 7.0


def test_a_record_takes_the_numbers_and_rows_of_another():
    run, other = a_run(), a_run()
    run.t, run.search.count, run.given = 2.5, 7, np.ones(3)
    run.k[1, 2], run.other.signs[1] = 3.0, -1
    other.take(run)
    assert (other.t, other.search.count, other.k[1, 2], other.other.signs[1]) == (2.5, 7, 3.0, -1)
    assert other.given is None and other.memory.ctypes.data != run.memory.ctypes.data


def test_a_copy_has_rows_and_parts_of_rows_of_its_own():
    it = Tailed.made(width=4)
    it.x[:], it.tail, it.inner.n[:] = [1.0, 2.0, 3.0, 4.0], it.x[2:], 7
    other = it.copied()
    tail = np.frombuffer(ctypes.string_at(other.wholes[Tailed.fields["tail"].place // 8], 16))
    assert tail.tolist() == [3.0, 4.0] and other.inner.n.tolist() == [7, 7, 7]
    it.x[:], it.inner.n[:] = 0.0, 0
    assert other.x.tolist() == [1.0, 2.0, 3.0, 4.0] and other.inner.n.tolist() == [7, 7, 7]
    it.tail = np.zeros(2)
    with pytest.raises(ValueError, match="Expected rows in the memory of the record, got one elsewhere"):
        it.copied()


def test_several_fields_are_assigned_at_once():
    packed, place = Run.packer("t", "taken", "width")
    run = a_run()
    packed.pack_into(run.memory, run.begin + place, 0.25, 3, 4)
    assert (run.t, run.taken, run.width) == (0.25, 3, 4)
    assert packed.unpack_from(run.memory, run.begin + place) == (0.25, 3, 4)
    with pytest.raises(TypeError, match="Expected 'width' next to 't' in 'Run'; they are apart"):
        Run.packer("t", "width")


def test_fields_stay_in_registers_while_rows_are_written():
    """A loop over a row reads the addresses of the record before it begins, although rows might overlap each other."""

    def add(run: Run) -> None:
        t = run.t
        for i in range(run.width):
            run.y[i] = run.given[i] + t * run.k[1, i]

    code = str(_optimised(translated({"f": Compiled(add)})))
    loop = code[code.index("vector.body:") :]
    body = loop[: loop.index("br i1")]
    assert "<" in body and "!invariant.load" not in body


def _optimised(text: str):
    import llvmlite.binding as llvm

    machine, module = codegen._machine(), llvm.parse_assembly(text, context=llvm.create_context())
    module.triple, module.data_layout = codegen.processor()[0], codegen.layout()
    passes = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=1))
    passes.getModulePassManager().run(module, passes)
    return module


def test_records_that_point_to_each_other_at_another_address():
    @record
    class Other:
        x: Annotated[Row, 3]

    @record
    class First:
        other: Row
        own: Annotated[Row, 2]

    other, first = Other.made(), First.made()
    first.other, first.own[:], other.x[:] = other.memory, [1, 2], [3, 4, 5]
    image = np.frombuffer(first.image_at(1000, others=(other,)), dtype=np.int64)
    start = 1000 + 8 * first.memory.size  # whole cache lines
    begin = (start - 1000) // 8
    assert image[0] == start and image[1] == 1000 + 8 * first.placed["own"][0]
    assert image[begin] == start + 8 * other.placed["x"][0]
    assert image.view(float)[begin + other.placed["x"][0] :][:3].tolist() == [3, 4, 5]
    with pytest.raises(ValueError, match="Expected rows in the memory of the record, got one elsewhere"):
        first.image_at(1000)
