"""Records in machine code: the instructions that read, assign and call their fields (`records`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from llvmlite import ir

from .records import ASSIGNED, Field, Record

REAL, WHOLE = ir.DoubleType(), ir.IntType(64)
BYTE = ir.IntType(8)
KERNEL = ir.FunctionType(ir.VoidType(), [REAL, *[REAL.as_pointer()] * 3]).as_pointer()
"""``void f(double t, const double *y, const double *c, double *out)``"""
_IN_MEMORY = {
    "Real": REAL, "Whole": WHOLE, "Count": WHOLE, "Row": REAL.as_pointer(), "Wholes": WHOLE.as_pointer(),
    "Rows": REAL.as_pointer(), "Kernel": KERNEL,
}  # fmt: skip


class RecordPointer(type(BYTE.as_pointer())):  # type: ignore[misc]
    """LLVM type of a record: the address of its first byte."""

    def __new__(cls, record: type[Record]) -> RecordPointer:  # noqa: D102
        return object.__new__(cls)

    def __init__(self, record: type[Record]) -> None:
        super().__init__(BYTE)
        self.record = record

    def __eq__(self, other: object) -> bool:
        return isinstance(other, RecordPointer) and other.record is self.record

    def __hash__(self) -> int:
        return hash(self.record)


class Table(NamedTuple):
    """Rows of equal length: the first number and the length."""

    first: Any
    length: Any

    def row(self, builder: Any, k: Any) -> Any:
        """Pointer to row k."""
        return builder.gep(self.first, [builder.mul(k, self.length)])


def typed(annotation: Any, types: dict[str, Any], space: dict[str, Any]) -> Any:
    """LLVM type of an annotation: one of ``types``, or a record of the name space. Raise KeyError for another."""
    if annotation in types:
        return types[annotation]
    record = space.get(annotation, annotation)
    if isinstance(record, type) and issubclass(record, Record):
        return RecordPointer(record)
    raise KeyError(annotation)


def field_of(pointer: Any, name: str, refused: Callable[..., Exception]) -> Field:
    """Return a field of a record, or raise the error of the translation."""
    record = pointer.type.record
    field = record.fields.get(name)
    if field is None:
        raise refused(f"a field of '{record.__name__}' ({', '.join(record.fields)})", f"'{name}'")
    return field


def _inside(builder: Any, pointer: Any, distance: int) -> Any:
    """Pointer to a byte of a record."""
    return builder.gep(builder.bitcast(pointer, BYTE.as_pointer()), [WHOLE(distance)])


def place(builder: Any, pointer: Any, field: Field, word: int = 0) -> Any:
    """Pointer to a field, or to a later word of it."""
    kind = _IN_MEMORY[field.kind] if word == 0 else WHOLE
    result = builder.bitcast(_inside(builder, pointer, field.place + 8 * word), kind.as_pointer())
    result.tag = f"{pointer.type.record.__name__}.{field.name}"
    return result


def value(builder: Any, pointer: Any, field: Field) -> Any:
    """Value of a field: a number, a pointer, a record or a table."""
    if field.nested is not None:
        return builder.bitcast(_inside(builder, pointer, field.place), RecordPointer(field.nested))
    first = loaded(builder, place(builder, pointer, field), field.kind not in ASSIGNED)
    if field.kind == "Rows":
        return Table(first, loaded(builder, place(builder, pointer, field, 1), True))
    return first


def assigned(pointer: Any, field: Field, refused: Callable[..., Exception]) -> Field:
    """Return the field, or raise the error of the translation if compiled code cannot assign it."""
    if field.kind not in ASSIGNED:
        what = {
            "Count": "a count, which only Python assigns",
            "Kernel": "a kernel, which only Python assigns",
        }.get(
            field.kind,
            "a record: assign to its fields" if field.nested else "a row: assign to its components, [i]",
        )
        raise refused(
            "a number that can be assigned", f"'{pointer.type.record.__name__}.{field.name}', {what}"
        )
    return field


def tagged(module: Any, instruction: Any, tag: str) -> None:
    """Say which memory an instruction reads or writes: one field of all records, or the components of rows.

    LLVM then keeps the fields of a record in registers while rows are written.
    """
    root = module.add_metadata(["memory of freebody"])
    kind = module.add_metadata([tag, root, WHOLE(0)])
    instruction.set_metadata("tbaa", module.add_metadata([kind, kind, WHOLE(0)]))


def loaded(builder: Any, pointer: Any, constant: bool = False) -> Any:
    """Value at a place; ``constant`` if no code changes it."""
    result = builder.load(pointer)
    tag = getattr(pointer, "tag", "")
    if tag:
        tagged(builder.module, result, tag)
    if constant:
        result.set_metadata("invariant.load", builder.module.add_metadata([]))
    return result


def stored(builder: Any, number: Any, pointer: Any) -> None:
    """Store a number at a place."""
    result = builder.store(number, pointer)
    tag = getattr(pointer, "tag", "")
    if tag:
        tagged(builder.module, result, tag)
