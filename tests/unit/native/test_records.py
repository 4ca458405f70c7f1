"""Records: Python and machine code read the same fields at the same places; every misuse is refused with its cure."""

from __future__ import annotations

import ctypes
from typing import Annotated

import numpy as np
import pytest

from freebody.native import codegen
from freebody.native.records import Count, Kernel, Real, Row, Rows, Whole, Wholes, record
from freebody.native.translation import Compiled, translated

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
    call = ctypes.CFUNCTYPE(result, *[ctypes.c_void_p] * len(translation.arguments))(
        library.addresses(["f"])["f"]
    )

    def run(*values):
        assert library is not None
        return call(*(getattr(value, "address", value) for value in values))

    return run


def a_run() -> Run:
    run = Run.made(width=5, events=2)
    run.width = 5
    return run


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
    assert Run.dtype.itemsize == Run.size == 8 * 17
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


def test_a_record_is_passed_to_functions_and_found_at_a_row():
    def inside(search: Search, by: float) -> float:
        search.reach += by
        return search.reach

    called = Compiled(inside)
    globals()["called"] = called

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
    run.t = called(run, 1.0)  # noqa: F821


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
        (unknown_field, ("a field of 'Run' (t, taken, width, y,", "'q'", "'unknown_field'")),
        (assigned_row, ("'Run.y', a row: assign to its components, [i]",)),
        (assigned_table, ("'Run.k', a row: assign to its components, [i]",)),
        (assigned_count, ("'Run.width', a count, which only Python assigns",)),
        (assigned_kernel, ("'Run.rates', a kernel, which only Python assigns",)),
        (assigned_record, ("'Run.search', a record: assign to its fields",)),
        (wrong_type, ("a value of type i64", "double of 'run.taken'")),
        (arguments_of_kernel, ("4 arguments",)),
        (one_index, ("two indices of a component, [j, i]",)),
        (part_of_row, ("the rest of a row, as in row[k:]", "'run.y[1:3]'")),
        (unknown_type, ("or a record as the type", "'Ran'", "import the record into this file")),
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


def test_several_fields_are_assigned_at_once():
    write, place = Run.packer("t", "taken", "width")
    run = a_run()
    write(run.memory, run.begin + place, 0.25, 3, 4)
    assert (run.t, run.taken, run.width) == (0.25, 3, 4)
    with pytest.raises(TypeError, match="Expected 'width' next to 't' in 'Run'; they are apart"):
        Run.packer("t", "width")


def test_fields_stay_in_registers_while_rows_are_written():
    """A loop over a row reads the record before it begins, although rows might overlap each other."""

    def add(run: Run) -> None:
        for i in range(run.width):
            run.y[i] = run.given[i] + run.t * run.k[1, i]

    code = str(_optimised(translated({"f": Compiled(add)})))
    loop = code[code.index("vector.body:") :]
    body = loop[: loop.index("br i1")]
    assert "<" in body and "!invariant.load" not in body and "double, ptr %.1" not in body


def _optimised(text: str):
    import llvmlite.binding as llvm

    machine, module = codegen._machine(), llvm.parse_assembly(text, context=llvm.create_context())
    module.triple, module.data_layout = codegen.processor()[0], codegen.layout()
    passes = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=1))
    passes.getModulePassManager().run(module, passes)
    return module
