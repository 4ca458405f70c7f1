"""Builder of LLVM's text: modules, functions and tables, and instructions at the end of a block.

The builder of `llvmlite.ir` makes an object of each instruction and asks for its text at the end. Here an instruction
is a line at once, which takes a third of the time. Types and constants are those of `llvmlite.ir`, and so are the names
of instructions.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, cast

from llvmlite import ir

_TRUTH = ir.IntType(1)
_SIGNS = {"==": "eq", "!=": "ne", "<": "lt", "<=": "le", ">": "gt", ">=": "ge", "uno": "no"}


def kind_text(kind: Any) -> str:
    """Text of a type. Pointers have no types, whatever they point to."""
    if isinstance(kind, ir.PointerType):
        return "ptr"
    known = kind.__dict__.get("short")
    if known is None:
        known = kind.short = str(kind)
    return cast(str, known)


class Value:
    """The result of an instruction, an argument, a function or a table: its type, and its name in the text."""

    __slots__ = ("length", "name", "type")

    def __init__(self, kind: Any, name: str) -> None:
        self.type, self.name = kind, name
        self.length: Any = None
        """Of a row that a record declares: its length, or where that is (`record_access.length_of`)."""

    def get_reference(self) -> str:
        """Return the name, as llvmlite's constants ask for it."""
        return self.name


class Meeting(Value):
    """A value that depends on the way to its block: a phi node."""

    __slots__ = ("ways",)

    def __init__(self, kind: Any, name: str) -> None:
        super().__init__(kind, name)
        self.ways: list[str] = []

    def add_incoming(self, value: Any, block: Block) -> None:
        """Say what the value is on the way from a block."""
        self.ways.append(
            f"[{value.name if value.__class__ is Value else value.get_reference()}, %{block.name}]"
        )

    def __str__(self) -> str:
        return f"  {self.name} = phi {kind_text(self.type)} {', '.join(self.ways)}"


class Block:
    """Instructions in a row, the last of which leads elsewhere."""

    __slots__ = ("function", "is_terminated", "lines", "name")

    def __init__(self, function: Function, name: str) -> None:
        self.function, self.name, self.is_terminated = function, name, False
        self.lines: list[str | Meeting] = []


class Function(Value):
    """A function of a module: declared, and defined by its blocks."""

    __slots__ = (
        "args",
        "attributes",
        "blocks",
        "count",
        "function_type",
        "linkage",
        "module",
        "of_arguments",
    )

    def __init__(self, module: Module, kind: Any, name: str) -> None:
        super().__init__(kind.as_pointer(), f"@{name}")
        self.module, self.function_type, self.count = module, kind, len(kind.args)
        self.args = [Value(x, f"%v{k}") for k, x in enumerate(kind.args)]
        self.of_arguments = ["" for _ in kind.args]
        self.attributes: set[str] = set()
        self.linkage = ""
        self.blocks: list[Block] = []
        module.globals[name] = self

    @property
    def is_declaration(self) -> bool:
        """Whether the function is defined elsewhere."""
        return not self.blocks

    def new(self) -> str:
        """Return a name for a value or a block."""
        self.count += 1
        return f"v{self.count}"

    def append_basic_block(self) -> Block:
        """Return a new block, behind the others."""
        self.blocks.append(Block(self, self.new()))
        return self.blocks[-1]

    def _head(self, word: str, names: Sequence[str]) -> str:
        kinds = map(kind_text, self.function_type.args)
        parts = [
            f"{kind} {about}{name}" for kind, about, name in zip(kinds, self.of_arguments, names, strict=True)
        ]
        arguments = ", ".join(part.rstrip() for part in parts)
        head = f"{word} {kind_text(self.function_type.return_type)} {self.name}({arguments})"
        return f"{head} {' '.join(sorted(self.attributes))}".rstrip()

    def declared(self) -> str:
        """Return the text for a module that calls the function, which another defines."""
        return self._head("declare", ["" for _ in self.args])

    def __str__(self) -> str:
        if not self.blocks:
            return self.declared()
        lines = [self._head(f"define {self.linkage}".rstrip(), [value.name for value in self.args]), "{"]
        for block in self.blocks:
            lines.append(f"{block.name}:")
            lines += map(str, block.lines)
        return "\n".join([*lines, "}\n"])


class ConstantTable(Value):
    """A constant array in memory, internal to its module."""

    __slots__ = ("content",)

    def __init__(self, module: Module, content: Any, name: str) -> None:
        super().__init__(content.type.as_pointer(), f"@{name}")
        self.content = content
        module.globals[name] = self

    is_declaration = False

    def __str__(self) -> str:
        return f"{self.name} = internal constant {self.content.type} {self.content.get_reference()}"


class Module:
    """Functions and tables by name."""

    def __init__(self) -> None:
        self.globals: dict[str, Function | ConstantTable] = {}
        self.metadata: dict[str, int] = {}

    def note(self, text: str) -> str:
        """Return the name of what instructions say beside themselves, such as ``!{}``."""
        return f"!{self.metadata.setdefault(text, len(self.metadata))}"

    def __str__(self) -> str:
        return self.without(())

    def without(self, functions: Collection[Function]) -> str:
        """Text in which these functions are declared only."""
        parts = [
            item.declared() if isinstance(item, Function) and item in functions else str(item)
            for item in self.globals.values()
        ]
        notes = [f"!{number} = {text}" for text, number in self.metadata.items()]
        return "\n".join([*parts, *notes, ""])


class Builder:
    """Writes instructions at the end of a block, with the names that they have in llvmlite.ir."""

    def __init__(self, block: Block) -> None:
        self.function, self.module = block.function, block.function.module
        self.position_at_end(block)

    def position_at_end(self, block: Block) -> None:
        """Go to a block."""
        self.block, self.lines = block, block.lines

    def append_basic_block(self) -> Block:
        """Return a new block of the function."""
        return self.function.append_basic_block()

    @contextmanager
    def goto_entry_block(self) -> Iterator[None]:
        """Write into the first block, which holds the variables in memory, before its end."""
        here = self.block
        first = self.function.blocks[0]
        end = [first.lines.pop()] if first.is_terminated else []
        self.position_at_end(first)
        yield
        first.lines += end
        self.position_at_end(here)

    def _new(self, kind: Any, text: str) -> Value:
        function = self.function
        function.count += 1
        name = f"%v{function.count}"
        self.lines.append(f"  {name} = {text}")
        return Value(kind, name)

    # -- the ends of blocks --

    def _end(self, text: str) -> None:
        self.lines.append(text)
        self.block.is_terminated = True

    def branch(self, block: Block) -> None:
        """Go on at a block."""
        self._end(f"  br label %{block.name}")

    def cbranch(self, truth: Any, yes: Block, no: Block, weights: tuple[int, ...] = ()) -> None:
        """Go on at one of two blocks; ``weights`` say how often."""
        about = ""
        if weights:
            content = ", ".join(['!"branch_weights"', *(f"i32 {weight}" for weight in weights)])
            about = f", !prof {self.module.note(f'!{{ {content} }}')}"
        self._end(f"  br i1 {_name(truth)}, label %{yes.name}, label %{no.name}{about}")

    def ret(self, value: Any) -> None:
        """Return a value."""
        self._end(f"  ret {kind_text(value.type)} {_name(value)}")

    def ret_void(self) -> None:
        """Return."""
        self._end("  ret void")

    # -- values --

    def phi(self, kind: Any) -> Meeting:
        """Value that depends on the way to this block."""
        self.function.count += 1
        result = Meeting(kind, f"%v{self.function.count}")
        self.lines.append(result)
        return result

    def fneg(self, a: Any) -> Value:
        """-a."""
        return self._new(a.type, f"fneg {kind_text(a.type)} {_name(a)}")

    def not_(self, a: Any) -> Value:
        """Not a."""
        ones = "true" if kind_text(a.type) == "i1" else "splat (i1 true)"
        return self._new(a.type, f"xor {kind_text(a.type)} {_name(a)}, {ones}")

    def _compared(self, operation: str, sign: str, a: Any, b: Any) -> Value:
        kind = a.type
        truth = ir.VectorType(_TRUTH, kind.count) if isinstance(kind, ir.VectorType) else _TRUTH
        return self._new(truth, f"{operation}{_SIGNS[sign]} {kind_text(kind)} {_name(a)}, {_name(b)}")

    def icmp_signed(self, sign: str, a: Any, b: Any) -> Value:
        """Comparison of integers with signs."""
        return self._compared("icmp " if sign in ("==", "!=") else "icmp s", sign, a, b)

    def icmp_unsigned(self, sign: str, a: Any, b: Any) -> Value:
        """Comparison of integers without signs, or of addresses."""
        return self._compared("icmp " if sign in ("==", "!=") else "icmp u", sign, a, b)

    def fcmp_ordered(self, sign: str, a: Any, b: Any) -> Value:
        """Comparison of real numbers, false with nan."""
        return self._compared("fcmp o", sign, a, b)

    def fcmp_unordered(self, sign: str, a: Any, b: Any) -> Value:
        """Comparison of real numbers, true with nan."""
        return self._compared("fcmp u", sign, a, b)

    def select(self, truth: Any, a: Any, b: Any) -> Value:
        """a where the truth value holds, else b."""
        kind = kind_text(a.type)
        return self._new(
            a.type, f"select {kind_text(truth.type)} {_name(truth)}, {kind} {_name(a)}, {kind} {_name(b)}"
        )

    def _cast(self, operation: str, a: Any, kind: Any) -> Any:
        if a.type == kind:
            return a
        return self._new(kind, f"{operation} {kind_text(a.type)} {_name(a)} to {kind_text(kind)}")

    def bitcast(self, a: Any, kind: Any) -> Any:
        """The same bits as another type; of a pointer, the same pointer."""
        if isinstance(kind, ir.PointerType):
            return Value(kind, _name(a))
        return self._cast("bitcast", a, kind)

    def gep(self, pointer: Any, places: Sequence[Any]) -> Value:
        """Pointer to a component of what a pointer points to."""
        kind = pointer.type.pointee
        at = ", ".join([f"{kind_text(place.type)} {_name(place)}" for place in places])
        text = f"getelementptr {kind_text(kind)}, ptr {_name(pointer)}, {at}"
        return self._new(pointer.type if len(places) == 1 else kind.element.as_pointer(), text)

    def inside(self, pointer: Any, distance: int, kind: Any) -> Value:
        """Pointer of this type to what stands so many bytes behind another."""
        return self._new(kind, f"getelementptr i8, ptr {_name(pointer)}, i64 {distance}")

    def load(self, pointer: Any, align: int | None = None, constant: bool = False) -> Value:
        """Number or pointer in memory. No code changes what is ``constant``: LLVM then loads it once, although rows
        are written meanwhile.
        """
        kind = pointer.type.pointee
        about = f", align {align}" if align else ""
        if constant:
            about += f", !invariant.load {self.module.note('!{}')}"
        return self._new(kind, f"load {kind_text(kind)}, ptr {_name(pointer)}{about}")

    def store(self, value: Any, pointer: Any, align: int | None = None) -> None:
        """Write into memory."""
        about = f", align {align}" if align else ""
        self.lines.append(f"  store {kind_text(value.type)} {_name(value)}, ptr {_name(pointer)}{about}")

    def load_atomic(self, pointer: Any, ordering: str, align: int) -> Value:
        """Number in memory that other threads write."""
        kind = pointer.type.pointee
        return self._new(
            kind, f"load atomic {kind_text(kind)}, ptr {_name(pointer)} {ordering}, align {align}"
        )

    def store_atomic(self, value: Any, pointer: Any, ordering: str, align: int) -> None:
        """Write into memory that other threads read."""
        kind = kind_text(value.type)
        self.lines.append(
            f"  store atomic {kind} {_name(value)}, ptr {_name(pointer)} {ordering}, align {align}"
        )

    def alloca(self, kind: Any, size: Any = None, align: int | None = None) -> Value:
        """Memory of the function for a number, or for so many."""
        size = ir.IntType(64)(size) if isinstance(size, int) else size
        about = f", {kind_text(size.type)} {_name(size)}" if size is not None else ""
        about += f", align {align}" if align else ""
        return self._new(kind.as_pointer(), f"alloca {kind_text(kind)}{about}")

    def call(self, function: Any, values: Sequence[Any]) -> Value:
        """Call a function, or the function at an address."""
        kind = function.type.pointee.return_type
        arguments = ", ".join([f"{kind_text(value.type)} {_name(value)}" for value in values])
        text = f"call {kind_text(kind)} {_name(function)}({arguments})"
        if isinstance(kind, ir.VoidType):
            self.lines.append(f"  {text}")
            return Value(kind, "")
        return self._new(kind, text)

    def extract_element(self, vector: Any, place: Any) -> Value:
        """Number of a vector."""
        at = f"{kind_text(place.type)} {_name(place)}"
        return self._new(
            vector.type.element, f"extractelement {kind_text(vector.type)} {_name(vector)}, {at}"
        )

    def insert_element(self, vector: Any, value: Any, place: Any) -> Value:
        """Vector with another number in one place."""
        parts = ", ".join([f"{kind_text(x.type)} {_name(x)}" for x in (vector, value, place)])
        return self._new(vector.type, f"insertelement {parts}")

    def shuffle_vector(self, a: Any, b: Any, places: Any) -> Value:
        """Vector of numbers of two vectors."""
        parts = ", ".join([f"{kind_text(x.type)} {_name(x)}" for x in (a, b, places)])
        return self._new(ir.VectorType(a.type.element, places.type.count), f"shufflevector {parts}")


def _name(value: Any) -> str:
    return value.name if isinstance(value, Value) else value.get_reference()


def _operation(name: str) -> Any:
    def write(self: Builder, a: Any, b: Any) -> Value:
        kind = a.type
        return self._new(kind, f"{name} {kind_text(kind)} {_name(a)}, {_name(b)}")

    write.__doc__ = f"LLVM's {name}."
    return write


def _conversion(name: str) -> Any:
    def write(self: Builder, a: Any, kind: Any) -> Any:
        return self._cast(name, a, kind)

    write.__doc__ = f"LLVM's {name}."
    return write


_OPERATIONS = (
    "add", "sub", "mul", "sdiv", "udiv", "srem", "shl", "ashr", "lshr", "and", "or", "xor", "fadd", "fsub", "fmul",
    "fdiv",
)  # fmt: skip
for _word in _OPERATIONS:
    setattr(Builder, f"{_word}_" if _word in ("and", "or") else _word, _operation(_word))
for _word in ("zext", "trunc", "sitofp", "uitofp", "inttoptr", "ptrtoint"):
    setattr(Builder, _word, _conversion(_word))
