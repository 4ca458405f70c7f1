"""A WebAssembly module from one relocatable object of LLVM and an image of memory.

An object imports memory, table and stack pointer, each alone of its kind, so that they keep the number 0 when they
are defined instead, and the numbers of functions, types and globals stand as they are. Only addresses of data are
left to be written. The memory begins with the stack, which grows down: a stack that overflows leaves the memory
and traps. Then follow the constants of the code, then the image.

Source: WebAssembly Core Specification 2.0, chapter 5 (binary format); tool-conventions, Linking.md (objects).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

PAGE, STACK, LINE = 1 << 16, 1 << 16, 64
"""Bytes of a page of memory, of the stack, and of a cache line."""
GAP = 16
"""Number of zeros of an image from which they are left out: memory is zero at the beginning."""

_CUSTOM, _TYPE, _IMPORT, _FUNCTION, _TABLE, _MEMORY, _GLOBAL, _EXPORT, _ELEMENT, _CODE, _DATA = (
    0, 1, 2, 3, 4, 5, 6, 7, 9, 10, 11,
)  # fmt: skip
_I32, _FUNCTIONS, _CONSTANT, _END = 0x7F, 0x70, 0x41, 0x0B
_SYMBOLS, _UNDEFINED, _NAMED = 8, 0x10, 0x40
_INDEX_OF_TABLE = {1: 5, 2: 4}  # kinds of relocation, with the bytes that they fill
_ADDRESS = {3: 5, 4: 5, 5: 4}
_UNCHANGED = (0, 6, 7, 20)  # numbers of functions, types, globals and tables


def unsigned(value: int, width: int = 1) -> bytes:
    """Return a natural number in LEB128, filled up to ``width`` bytes.

    >>> unsigned(624485).hex(), unsigned(3, 5).hex()
    ('e58e26', '8380808000')
    """
    result = bytearray()
    while value > 0x7F or len(result) + 1 < width:
        result.append(value & 0x7F | 0x80)
        value >>= 7
    result.append(value)
    return bytes(result)


def signed(value: int) -> bytes:
    """Return an integer in LEB128.

    >>> signed(-123456).hex(), signed(64).hex()
    ('c0bb78', 'c000')
    """
    result = bytearray()
    while not -64 <= value < 64:
        result.append(value & 0x7F | 0x80)
        value >>= 7
    result.append(value & 0x7F)
    return bytes(result)


class _Reader:
    """Bytes that are read from the front."""

    def __init__(self, content: bytes, place: int = 0) -> None:
        self.content, self.place = content, place

    def byte(self) -> int:
        self.place += 1
        return self.content[self.place - 1]

    def bytes(self, count: int) -> bytes:
        self.place += count
        return self.content[self.place - count : self.place]

    def unsigned(self) -> int:
        result = shift = 0
        while True:
            part = self.byte()
            result |= (part & 0x7F) << shift
            shift += 7
            if part < 0x80:
                return result

    def signed(self) -> int:
        start = self.place
        value = self.unsigned()
        bits = 7 * (self.place - start)
        return value - (1 << bits) if value >> (bits - 1) & 1 else value

    def name(self) -> str:
        return self.bytes(self.unsigned()).decode()

    def limits(self) -> None:
        for _ in range(1 + (self.byte() & 1)):
            self.unsigned()


@dataclass
class _Object:
    """What an object file has: its sections, imported functions, symbols, and relocations of code and data."""

    sections: dict[int, bytes]
    imports: list[tuple[str, int]]
    functions: dict[str, int]
    data: list[tuple[int, int] | None]
    """For each symbol, its segment and its place in it; None for a symbol that is no datum."""
    function_of: list[int]
    relocations: dict[int, list[tuple[int, int, int, int]]]


@dataclass(frozen=True)
class Linked:
    """A module: its bytes, and the names of the functions that it imports."""

    code: bytes
    imports: tuple[str, ...]


def base_of_image(code: bytes) -> int:
    """Return the address at which the image of memory begins, behind the constants of an object."""
    segments = _segments(_read(code))
    end = max((offset + len(content) for offset, content in segments), default=0)
    return STACK + -(-end // LINE) * LINE


def linked(code: bytes, exports: Sequence[str], table: Sequence[str], image: bytes, size: int) -> Linked:
    """Return a module of one object.

    Parameters
    ----------
    code : bytes
        A relocatable object.
    exports : sequence of str
        Functions that the module exports, besides ``memory``.
    table : sequence of str
        Functions that are called by their address: 1, 2, ... in this order. The address 0 is no function.
    image : bytes
        Beginning of the memory from `base_of_image` on.
    size : int
        Length of the memory from there on.
    """
    o = _read(code)
    base, places = base_of_image(code), _segments(o)
    starts = [STACK + offset for offset, _ in places]
    numbers = {o.functions[name]: k for k, name in enumerate(table, 1)}

    def value(kind: int, symbol: int, addend: int) -> int:
        if kind in _ADDRESS:
            place = o.data[symbol]
            if place is None:
                raise ValueError(
                    f"Expected the address of a datum for symbol {symbol} of an object, got a function."
                )
            return starts[place[0]] + place[1] + addend
        number = o.function_of[symbol]
        return numbers.setdefault(number, len(numbers) + 1)

    patched = {section: _patched(o, section, value) for section in (_CODE, _DATA)}
    o.sections |= patched
    content = [(STACK + offset, part) for offset, part in _segments(o)] + [
        (base + offset, part) for offset, part in _pieces(image)
    ]
    pages = -(-(base + size) // PAGE)
    imported = b"".join(
        unsigned(3) + b"env" + _text(name) + b"\0" + unsigned(kind) for name, kind in o.imports
    )
    exported = (
        _text("memory")
        + b"\2\0"
        + b"".join(_text(name) + b"\0" + unsigned(o.functions[name]) for name in exports)
    )
    elements = sorted(numbers, key=numbers.__getitem__)
    count = unsigned(len(elements) + 1)
    sections = (
        (_TYPE, o.sections[_TYPE]),
        (_IMPORT, unsigned(len(o.imports)) + imported),
        (_FUNCTION, o.sections[_FUNCTION]),
        (_TABLE, bytes((1, _FUNCTIONS, 1)) + count + count),
        (_MEMORY, b"\1\0" + unsigned(pages)),
        (_GLOBAL, bytes((1, _I32, 1, _CONSTANT)) + signed(STACK) + bytes((_END,))),
        (_EXPORT, unsigned(1 + len(exports)) + exported),
        (_ELEMENT, _elements(elements)),
        (_CODE, o.sections[_CODE]),
        (_DATA, unsigned(len(content)) + b"".join(_segment(*segment) for segment in content)),
    )
    module = b"\0asm\1\0\0\0" + b"".join(
        bytes((number,)) + unsigned(len(part)) + part for number, part in sections
    )
    return Linked(module, tuple(name for name, _ in o.imports))


def _elements(functions: Sequence[int]) -> bytes:
    """Section that fills the table from 1 on."""
    head = bytes((1, 0, _CONSTANT, 1, _END))
    return head + unsigned(len(functions)) + b"".join(map(unsigned, functions))


def _text(name: str) -> bytes:
    return unsigned(len(name.encode())) + name.encode()


def _segment(address: int, content: bytes) -> bytes:
    return bytes((0, _CONSTANT)) + signed(address) + bytes((_END,)) + unsigned(len(content)) + content


def _pieces(image: bytes) -> Iterator[tuple[int, bytes]]:
    """Pieces of an image without its long runs of zeros, each with its place."""
    start, end, zeros = 0, len(image), bytes(GAP)
    while start < end:
        while start < end and image[start] == 0:
            start += 1
        stop = image.find(zeros, start)
        stop = end if stop < 0 else stop
        if start < stop:
            yield start, image[start:stop]
        start = stop


# -- objects ------------------------------------------------------------------------------------------------


def _read(code: bytes) -> _Object:
    reader = _Reader(code, 8)
    sections: dict[int, bytes] = {}
    order: list[int] = []
    custom: list[tuple[str, bytes]] = []
    while reader.place < len(code):
        number, part = reader.byte(), reader.bytes(reader.unsigned())
        order.append(number)
        if number == _CUSTOM:
            inner = _Reader(part)
            custom.append((inner.name(), part[inner.place :]))
        else:
            sections[number] = part
    o = _Object(sections, _imports(sections[_IMPORT]), {}, [], [], {_CODE: [], _DATA: []})
    for name, part in custom:
        if name == "linking":
            _read_symbols(o, _Reader(part))
        elif name.startswith("reloc."):
            inner = _Reader(part)
            kind = order[inner.unsigned()]
            if kind in o.relocations:
                o.relocations[kind] = list(_relocations(inner))
    return o


def _imports(part: bytes) -> list[tuple[str, int]]:
    """Imported functions with their types; memory, table and stack pointer are defined instead."""
    reader, result = _Reader(part), []
    for _ in range(reader.unsigned()):
        reader.name()
        name, kind = reader.name(), reader.byte()
        if kind == 0:
            result.append((name, reader.unsigned()))
        elif kind == 1:
            reader.byte()
            reader.limits()
        elif kind == 2:
            reader.limits()
        elif name == "__stack_pointer":
            reader.bytes(2)
        else:
            raise ValueError(f"Expected no global but the stack pointer in an object, got '{name}'.")
    return result


def _read_symbols(o: _Object, reader: _Reader) -> None:
    """Read the symbol table of the section "linking"."""
    reader.unsigned()
    while reader.place < len(reader.content):
        kind, part = reader.byte(), _Reader(reader.bytes(reader.unsigned()))
        for _ in range(part.unsigned() if kind == _SYMBOLS else 0):
            _read_symbol(o, part)


def _read_symbol(o: _Object, part: _Reader) -> None:
    kind, flags = part.byte(), part.unsigned()
    defined = not flags & _UNDEFINED
    place, function = None, -1
    if kind == 1:
        part.name()
        if defined:
            place = part.unsigned(), part.unsigned()
            part.unsigned()
    elif kind == 3:
        part.unsigned()
    else:
        number = part.unsigned()
        name = part.name() if defined or flags & _NAMED else ""
        if kind == 0:
            function = number
            if defined:
                o.functions[name] = number
    o.data.append(place)
    o.function_of.append(function)


def _relocations(reader: _Reader) -> Iterator[tuple[int, int, int, int]]:
    """Kind, place, symbol and addend of relocations."""
    for _ in range(reader.unsigned()):
        kind, place, symbol = reader.byte(), reader.unsigned(), reader.unsigned()
        addend = reader.signed() if kind in _ADDRESS else 0
        yield kind, place, symbol, addend


def _patched(o: _Object, section: int, value: Callable[[int, int, int], int]) -> bytes:
    """Section with its relocations applied."""
    content = bytearray(o.sections.get(section, b"\0"))
    for kind, place, symbol, addend in o.relocations[section]:
        if kind in _UNCHANGED:
            continue
        width = {**_ADDRESS, **_INDEX_OF_TABLE}.get(kind)
        if width is None:
            raise ValueError(
                f"Expected relocations of functions and data in an object, got one of kind {kind}."
            )
        number = value(kind, symbol, addend)
        # addresses are below 2^31, so that filled up to five bytes their signed and unsigned forms are the same
        content[place : place + width] = (
            number.to_bytes(4, "little") if width == 4 else unsigned(number, width)
        )
    return bytes(content)


def _segments(o: _Object) -> list[tuple[int, bytes]]:
    """Segments of data with their places."""
    reader = _Reader(o.sections.get(_DATA, b"\0"))
    result = []
    for _ in range(reader.unsigned()):
        reader.bytes(2)  # an active segment, and the instruction of its place
        place = reader.signed()
        reader.byte()
        result.append((place, reader.bytes(reader.unsigned())))
    return result
