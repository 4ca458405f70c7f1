"""Records in machine code: the instructions that read, assign and call their fields (`records`)."""

from __future__ import annotations

from typing import Any, NamedTuple

from llvmlite import ir

from .arithmetic import REAL, WHOLE, Refusal, wide
from .records import ASSIGNED, Field, Record

BYTE = ir.IntType(8)


def kernel(lanes: int) -> Any:
    """LLVM type of a kernel: ``void f(double t, const double *y, const double *c, double *out)``.

    That for several lanes takes a pointer to their times.
    """
    row = wide(REAL, lanes).as_pointer()
    return ir.FunctionType(ir.VoidType(), [REAL if lanes == 1 else row, *[row] * 3]).as_pointer()


def _in_memory(field: Field) -> Any:
    """LLVM type of a field."""
    if field.kind == "Kernel":
        return kernel(field.lanes)
    if field.kind in ("Count", "Wholes"):
        return WHOLE if field.kind == "Count" else WHOLE.as_pointer()
    number = wide(WHOLE if field.kind == "Whole" else REAL, field.lanes)
    return number if field.kind in ASSIGNED else number.as_pointer()


class RecordPointer(type(BYTE.as_pointer())):  # type: ignore[misc]
    """LLVM type of a record: the address of its first byte."""

    def __new__(cls, record: type[Record]) -> RecordPointer:  # noqa: D102
        return object.__new__(cls)

    def __init__(self, record: type[Record]) -> None:
        super().__init__(BYTE)
        self.record, self.lanes = record, record.lanes

    def __eq__(self, other: object) -> bool:
        return isinstance(other, RecordPointer) and other.record is self.record

    def __hash__(self) -> int:
        return hash(self.record)


class Table(NamedTuple):
    """Rows of equal length: the first number, the length, and whether the record declares it.

    Only rows of a declared length have room for a multiple of eight numbers, as an assignment to a whole row needs.
    """

    first: Any
    length: Any
    declared: bool

    def row(self, builder: Any, k: Any) -> Any:
        """Pointer to row k."""
        result = builder.gep(self.first, [builder.mul(k, self.length)])
        if self.declared:
            result.length = self.length
        return result


def is_record(value: Any) -> bool:
    """Return whether a value of LLVM is the address of a record."""
    return isinstance(getattr(value, "type", None), RecordPointer)


def length_of(builder: Any, row: Any) -> Any:
    """Length of a row, which the record declares."""
    length = getattr(row, "length", None)
    if length is None:
        cure = 'It is a row of a record with a size that the record counts, y: Annotated[Row, "width"].'
        raise Refusal("a row with a length", cure)
    if isinstance(length, tuple):
        pointer, size = length
        return (
            WHOLE(size)
            if isinstance(size, int)
            else value(builder, pointer, pointer.type.record.fields[size])
        )
    return length


def field_of(pointer: Any, name: str) -> Field:
    """Return a field of a record."""
    record = pointer.type.record
    field: Field | None = record.fields.get(name)
    if field is None:
        cure = f"Fields are {', '.join(record.fields)}."
        raise Refusal(f"a field of the record '{record.__name__}'", cure, f"'{name}'")
    return field


def _inside(builder: Any, pointer: Any, distance: int, kind: Any) -> Any:
    """Pointer to a part of a record, so many bytes behind its first."""
    return builder.inside(pointer, distance, kind)


def place(builder: Any, pointer: Any, field: Field, word: int = 0) -> Any:
    """Pointer to a field, or to a later word of it."""
    kind = _in_memory(field) if word == 0 else WHOLE
    return _inside(builder, pointer, field.place + 8 * word, kind.as_pointer())


def is_constant(field: Field) -> bool:
    """Return whether no compiled code changes the value of a field: a count, a row, a kernel or a nested record."""
    return field.nested is not None or field.kind not in ASSIGNED


def value(builder: Any, pointer: Any, field: Field) -> Any:
    """Value of a field: a number, a pointer, a record or a table."""
    if field.nested is not None:
        return _inside(builder, pointer, field.place, RecordPointer(field.nested))
    result = builder.load(place(builder, pointer, field), align=8, constant=is_constant(field))
    if not is_constant(field):
        return result
    if field.kind == "Rows":
        length = builder.load(place(builder, pointer, field, 1), constant=True)
        return Table(result, length, bool(field.shape))
    if field.kind == "Row" and field.shape and _is_counted(pointer, field.shape[0]):
        result.length = pointer, field.shape[0]
    return result


def _is_counted(pointer: Any, size: int | str) -> bool:
    """Return whether the record knows a size."""
    return isinstance(size, int) or size in pointer.type.record.fields


def assigned_place(builder: Any, pointer: Any, name: str) -> Any:
    """Pointer to a field that compiled code may assign."""
    field = field_of(pointer, name)
    if is_constant(field):
        what, cure = {
            "Count": ("a count", "Only Python assigns it."),
            "Kernel": ("a kernel", "Only Python assigns it."),
        }.get(
            field.kind,
            ("a record", "Assign to its fields.")
            if field.nested is not None
            else ("a row", "Assign to its components, [i], or to all of them, [:]."),
        )
        got = f"'{pointer.type.record.__name__}.{name}', {what}"
        raise Refusal("a number that can be assigned", cure, got)
    return place(builder, pointer, field)
