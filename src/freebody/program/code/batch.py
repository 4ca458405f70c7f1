"""The loop of a batch: rows of arrays in, lanes of vectors through a function, rows out.

The parts of a row may stand in several arrays. A table holds three numbers for each array: its address, its width, and
the number of doubles from one row to the next, which is 0 where all rows share one.

Rows become lanes in registers, 4 (2, 1) columns at a time, in as many vectors. Vector k holds the rows k, k + 4, ...
side by side, and the squares of 4 x 4 numbers in the vectors are transposed by halves,

    (a b)     (a c)
    (c d)  →  (b d),

first of neighbours, then of pairs. The transposition is its own inverse, so it leads from lanes to rows as well.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from llvmlite import ir

from ...native.arithmetic import REAL, WHOLE, intrinsic, lanes_of, wide
from ...native.builder import ConstantTable, Function
from ...native.functions import Inlined, Instruction, instruction
from ...native.instructions import Integers, Parts, Reals, Row, compiled, lanes, reals_at, shifted
from ...native.translation import parts

BLOCKS = 2
"""Number of blocks of rows that each piece of a long function takes in turn; a block has as many rows as lanes.

Code that does not fit into the first-level cache is then fetched half as often.
"""
LONG = 6
"""Number of pieces above which a function is long."""


# -- rows and lanes ----------------------------------------------------------------------------------------------


@instruction("Row", "Reals", "int", "int", "int")
def rows_at(builder: Any, like: Any, array: Any, row: Any, n: Any, stride: Any) -> tuple[Any, ...]:
    """Pointers to a row for each lane of ``like``, and to the row behind them. Rows past the end are the last again."""
    last, result = builder.sub(n, WHOLE(1)), []
    for k in range(lanes_of(like.type)):
        place = builder.add(row, WHOLE(k))
        place = builder.select(builder.icmp_signed("<", place, last), place, last)
        result.append(builder.gep(array, [builder.mul(place, stride)]))
    return (*result, builder.gep(result[0], [builder.mul(stride, WHOLE(len(result)))]))


def _shuffled(builder: Any, a: Any, b: Any, places: Iterable[int]) -> Any:
    """Vector of the numbers at these places of two vectors side by side."""
    numbers = [*places]
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(ir.IntType(32), len(numbers)), numbers))


def _transposed(builder: Any, vectors: Sequence[Any]) -> list[Any]:
    """Transpose the squares in 1, 2, 4, ... vectors."""
    result, count, size = [*vectors], lanes_of(vectors[0].type), 1
    while size < len(result):
        for k in range(len(result)):
            if not k & size:
                a, b = result[k], result[k + size]
                low = [count + i - size if i & size else i for i in range(count)]
                high = [count + i if i & size else i + size for i in range(count)]
                result[k], result[k + size] = (_shuffled(builder, a, b, places) for places in (low, high))
        size *= 2
    return result


def _ahead(builder: Any, rows: Sequence[Any], j: Any, count: int, written: int) -> None:
    """Prefetch as many vectors of the next rows: a hint to the processor."""
    *ours, following = rows
    if len(ours) > 1:
        for k in range(count):
            place = builder.mul(builder.add(j, WHOLE(k)), WHOLE(len(ours)))
            hints = [ir.IntType(32)(number) for number in (written, 3, 1)]
            intrinsic(builder, "llvm.prefetch", ir.VoidType(), builder.gep(following, [place]), *hints)


def reading(count: int) -> Instruction:
    """Return the instruction that reads columns j, j + 1, ... of the rows into vectors."""

    def read(builder: Any, rows: Sequence[Any], j: Any, target: Any) -> None:
        vector = ir.VectorType(REAL, count).as_pointer()
        places = [builder.gep(row, [j]) for row in rows[:-1]]
        if len(places) == 1:
            builder.store(builder.load(places[0]), builder.gep(target, [j]))
            return
        joined = [builder.load(builder.bitcast(place, vector), align=8) for place in places]
        _ahead(builder, rows, j, count, 0)
        width = count
        while width < len(places):
            joined = [
                _shuffled(builder, joined[k], joined[k + count], range(2 * width))
                for m in range(0, len(joined), 2 * count)
                for k in range(m, m + count)
            ]
            width *= 2
        for k, x in enumerate(_transposed(builder, joined)):
            builder.store(x, builder.gep(target, [builder.add(j, WHOLE(k))]), align=8 * len(places))

    return Instruction(read, "", "int", "Row")


def writing(count: int, placed: bool) -> Instruction:
    """Return the instruction that writes vectors j, j + 1, ..., or those at these places of a table, to columns."""

    def write(builder: Any, rows: Sequence[Any], j: Any, source: Any, *table: Any) -> None:
        places = [builder.add(j, WHOLE(k)) for k in range(count)]
        if placed:
            places = [builder.load(builder.gep(table[0], [place])) for place in places]
        number = len(rows) - 1
        if number == 1:
            builder.store(builder.load(builder.gep(source, [places[0]])), builder.gep(rows[0], [j]))
            return
        vectors = [builder.load(builder.gep(source, [place]), align=8 * number) for place in places]
        vectors = _transposed(builder, vectors)
        kind = ir.VectorType(REAL, count).as_pointer()
        for k in reversed(range(number)):  # the last row is written after the lanes that repeat it
            start, x = k - k % count, vectors[k % count]
            part = _shuffled(builder, x, ir.Constant(x.type, ir.Undefined), range(start, start + count))
            builder.store(part, builder.bitcast(builder.gep(rows[k], [j]), kind), align=8)
        _ahead(builder, rows, j, count, 1)

    return Instruction(write, "", "int", "Row", *["Integers"] * placed)


read_1, read_2, read_4 = (reading(count) for count in (1, 2, 4))
write_1, write_2, write_4 = (writing(count, False) for count in (1, 2, 4))
place_1, place_2, place_4 = (writing(count, True) for count in (1, 2, 4))


@compiled
def gather(source: Reals, row: int, n: int, width: int, stride: int, target: Row) -> None:
    """Rows to lanes: target[j][k] = source[row + k][j]. Lanes past the last row repeat it."""
    rows = rows_at(target, source, row, n, stride)
    j = 0
    while lanes(target) >= 4 and j + 4 <= width:
        read_4(rows, j, target)
        j += 4
    while lanes(target) >= 2 and j + 2 <= width:
        read_2(rows, j, target)
        j += 2
    while j + 1 <= width:
        read_1(rows, j, target)
        j += 1


@compiled
def gather_parts(parts: Integers, row: int, n: int, width: int, target: Row) -> None:
    """Do as `gather` for rows in several parts."""
    k, filled = 0, 0
    while filled < width:
        part = parts[k + 1]
        gather(reals_at(parts[k]), row, n, part, parts[k + 2], shifted(target, filled))
        filled += part
        k += 3


@compiled
def scatter(source: Row, row: int, n: int, width: int, target: Reals) -> None:
    """Lanes to the rows before the end: target[row + k][j] = source[j][k]."""
    rows = rows_at(source, target, row, n, width)
    j = 0
    while lanes(source) >= 4 and j + 4 <= width:
        write_4(rows, j, source)
        j += 4
    while lanes(source) >= 2 and j + 2 <= width:
        write_2(rows, j, source)
        j += 2
    while j + 1 <= width:
        write_1(rows, j, source)
        j += 1


@compiled
def deliver(source: Row, places: Integers, row: int, n: int, width: int, target: Reals) -> None:
    """Lanes to the rows before the end: target[row + k][j] = source[places[j]][k]."""
    rows = rows_at(source, target, row, n, width)
    j = 0
    while lanes(source) >= 4 and j + 4 <= width:
        place_4(rows, j, source, places)
        j += 4
    while lanes(source) >= 2 and j + 2 <= width:
        place_2(rows, j, source, places)
        j += 2
    while j + 1 <= width:
        place_1(rows, j, source, places)
        j += 1


# -- the loop ----------------------------------------------------------------------------------------------------

part = Parts()

# Bound by `loop`.
vectors: Any = None
"""(count): memory for so many vectors; the count is a constant."""
LANES = STATE = HOISTED = OUTPUTS = ROUNDS = PIECES = FRAME = 0
compute: Any = None
"""(blocks, t, t_step, y, c, c_step, out): the function for so many blocks."""
of_lanes: Any = None
"""(t, y, c, out): the function for one block."""
piece: Any = None
"""(number, t, y, c, out, frame): a piece of a long function for one block."""


@part
def batch(n: int, t: Reals, ts: int, arrays: Integers, c: Reals, cs: int, out: Reals) -> None:
    """Compute n rows. The steps are 1 and the length of c, or 0 if all rows share t or c."""
    tt, cc = vectors(ROUNDS), vectors(ROUNDS * HOISTED)
    yy, oo = vectors(ROUNDS * STATE), vectors(ROUNDS * OUTPUTS)
    if n <= 0:
        return
    gather(t, 0, n, 1, ts, tt)
    gather(c, 0, n, HOISTED, cs, cc)
    row = 0
    while row < n:
        end = row + LANES * ROUNDS
        end = n if end > n else end
        i, b = row, 0
        while i < end:
            gather_parts(arrays, i, n, STATE, shifted(yy, b * STATE))
            if ts != 0:
                gather(t, i, n, 1, ts, shifted(tt, b * ts))
            if cs != 0:
                gather(c, i, n, HOISTED, cs, shifted(cc, b * cs))
            i, b = i + LANES, b + 1
        compute(b, tt, ts, yy, cc, cs, oo)
        i, b = row, 0
        while i < end:
            scatter(shifted(oo, b * OUTPUTS), i, n, OUTPUTS, out)
            i, b = i + LANES, b + 1
        row = end


@part
def one_block(n: int, t: Row, ts: int, y: Row, c: Row, cs: int, out: Row) -> None:
    """Compute one block."""
    of_lanes(t, y, c, out)


@part
def tiled(n: int, t: Row, ts: int, y: Row, c: Row, cs: int, out: Row) -> None:
    """Compute n blocks: each piece of a long function for all of them in turn."""
    frame = vectors(ROUNDS * FRAME)
    for p in range(PIECES):
        for e in range(n):
            piece(p, shifted(t, e * ts), shifted(y, e * STATE), shifted(c, e * cs), shifted(out, e * OUTPUTS),
                  shifted(frame, e * FRAME))  # fmt: skip


def loop(
    name: str, sizes: tuple[int, int, int], lanes: int, pieces: Sequence[str], frame: int
) -> dict[str, str]:
    """IR of ``void name.batch(n, t, t_step, parts, c, c_step, out)`` around ``name.lanes``, or around its pieces.

    ``sizes`` are those of state, hoisted constants and outputs. ``frame`` is the number of vectors that pieces pass on.
    """
    T = wide(REAL, lanes)
    long = len(pieces) > LONG

    @instruction("int")
    def vectors(builder: Any, count: Any) -> Any:
        """Memory for so many vectors."""
        with builder.goto_entry_block():
            return builder.alloca(T, max(count.constant, 1), align=64)

    @instruction("Row", "Row", "Row", "Row")
    def of_lanes(builder: Any, *arrays: Any) -> None:
        """The function for one block."""
        intrinsic(builder, f"{name}.lanes", ir.VoidType(), *arrays)

    @instruction("int", *["Row"] * 5)
    def piece(builder: Any, number: Any, *arrays: Any) -> None:
        """A piece; it reads the values of earlier pieces through one pointer and writes its own through another."""
        module = builder.module
        kind = ir.FunctionType(ir.VoidType(), [T.as_pointer()] * 6)
        functions = [Function(module, kind, symbol[1:]) for symbol in pieces]
        address = kind.as_pointer()
        addresses = ir.ArrayType(address, len(pieces))(
            [ir.FormattedConstant(address, function.name) for function in functions]
        )
        table = ConstantTable(module, addresses, f"{name}.pieces")
        function = builder.load(builder.gep(table, [WHOLE(0), number]))
        builder.call(function, [*arrays, arrays[-1]])

    space = {
        **globals(), "STATE": sizes[0], "HOISTED": sizes[1], "OUTPUTS": sizes[2], "LANES": lanes,
        "ROUNDS": BLOCKS if long else 1, "PIECES": len(pieces), "FRAME": frame,
        "vectors": vectors, "of_lanes": of_lanes, "piece": piece,
    }  # fmt: skip
    bound = part.bound(space)
    functions = {f"{name}.batch": bound["batch"]}
    if long:
        space["compute"] = functions[f"{name}.blocks"] = bound["tiled"]
    else:
        space["compute"] = Inlined(bound["one_block"].function)
    result = parts(functions, lanes, public=True)
    return {key: text for key, text in result.items() if key not in (f"@{name}.lanes", *pieces)}
