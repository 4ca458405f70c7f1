"""The loop of a batch as LLVM IR: rows of arrays in, lanes of vectors through a function, rows out.

The parts of a row may stand in several arrays. A table holds three numbers for each array: its address, its width, and
the number of doubles from one row to the next, which is 0 where all rows share one.

Rows become lanes in registers, 4 (2, 1) columns at a time, in as many vectors. Vector k holds the rows k, k + 4, ...
side by side, and the squares of 4 x 4 numbers in the vectors are transposed by halves,

    (a b)     (a c)
    (c d)  →  (b d),

first of neighbours, then of pairs. The transposition is its own inverse, so it leads from lanes to rows as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...native.ir_text import Lines

DECLARATION = "declare void @llvm.prefetch(ptr, i32, i32, i32)"
"""Declaration of the function that the functions of this file call."""
BLOCKS = 2
"""Number of blocks of rows that each piece of a long function takes in turn; a block has as many rows as lanes.

Code that does not fit into the first-level cache is then fetched half as often.
"""
LONG = 6
"""Number of pieces above which a function is long."""
COLUMNS = (4, 2, 1)
"""Numbers of columns that are transposed at once, the largest that still fits."""


def loop(name: str, state: int, hoisted: int, outputs: int, lanes: int, blocks: int = 1) -> str:
    """``void name.batch(n, t, t_step, parts, c, c_step, out)`` around ``name.lanes``, or ``name.blocks`` (`tiled`).

    The steps are 1 and the length of c, or 0 if all rows share t or c.
    """
    T = f"<{lanes} x double>"
    call = f"@{name}.lanes(ptr %tt, ptr %yy, ptr %cc, ptr %oo)"
    if blocks > 1:
        call = f"@{name}.blocks(i64 %b1, ptr %tt, i64 %ts, ptr %yy, ptr %cc, i64 %cs, ptr %oo)"
    return f"""define void @{name}.batch(i64 %n, ptr %t, i64 %ts, ptr %parts, ptr %c, i64 %cs, ptr %out) nounwind {{
entry:
  %tt = alloca {T}, i64 {blocks}, align 64
  %yy = alloca {T}, i64 {blocks * max(state, 1)}, align 64
  %cc = alloca {T}, i64 {blocks * max(hoisted, 1)}, align 64
  %oo = alloca {T}, i64 {blocks * max(outputs, 1)}, align 64
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %first, label %done
first:
  call void @gather.{lanes}(ptr %t, i64 0, i64 %n, i64 1, i64 %ts, ptr %tt)
  call void @gather.{lanes}(ptr %c, i64 0, i64 %n, i64 {hoisted}, i64 %cs, ptr %cc)
  %timed = icmp ne i64 %ts, 0
  %varied = icmp ne i64 %cs, 0
  br label %begin
begin:
  %row = phi i64 [0, %first], [%end, %written]
  %full = add i64 %row, {lanes * blocks}
  %over = icmp sgt i64 %full, %n
  %end = select i1 %over, i64 %n, i64 %full
  br label %read
read:
  %i = phi i64 [%row, %begin], [%i1, %on]
  %b = phi i64 [0, %begin], [%b1, %on]
  %yi = mul i64 %b, {state}
  %yb = getelementptr {T}, ptr %yy, i64 %yi
  call void @gather_parts.{lanes}(ptr %parts, i64 %i, i64 %n, i64 {state}, ptr %yb)
  br i1 %timed, label %time, label %constants
time:
  %ti = mul i64 %b, %ts
  %tb = getelementptr {T}, ptr %tt, i64 %ti
  call void @gather.{lanes}(ptr %t, i64 %i, i64 %n, i64 1, i64 %ts, ptr %tb)
  br label %constants
constants:
  br i1 %varied, label %vary, label %on
vary:
  %ci = mul i64 %b, %cs
  %cb = getelementptr {T}, ptr %cc, i64 %ci
  call void @gather.{lanes}(ptr %c, i64 %i, i64 %n, i64 {hoisted}, i64 %cs, ptr %cb)
  br label %on
on:
  %b1 = add i64 %b, 1
  %i1 = add i64 %i, {lanes}
  %again = icmp slt i64 %i1, %end
  br i1 %again, label %read, label %compute
compute:
  call void {call}
  br label %write
write:
  %j = phi i64 [%row, %compute], [%j1, %write]
  %w = phi i64 [0, %compute], [%w1, %write]
  %wk = mul i64 %w, {outputs}
  %ow = getelementptr {T}, ptr %oo, i64 %wk
  call void @scatter.{lanes}(ptr %ow, i64 %j, i64 %n, i64 {outputs}, ptr %out)
  %w1 = add i64 %w, 1
  %j1 = add i64 %j, {lanes}
  %left = icmp slt i64 %j1, %end
  br i1 %left, label %write, label %written
written:
  %more = icmp slt i64 %end, %n
  br i1 %more, label %begin, label %done
done:
  ret void
}}
"""


def tiled(name: str, state: int, outputs: int, lanes: int, pieces: Sequence[str], frame: int) -> str:
    """``void name.blocks(n, t, t_step, y, c, c_step, out)``: each piece of a long function for n blocks in turn.

    ``frame`` is the number of vectors that pieces pass on to later ones.
    """
    T = f"<{lanes} x double>"
    return f"""@{name}.pieces = private constant [{len(pieces)} x ptr] [{", ".join(f"ptr {x}" for x in pieces)}]
define internal void @{name}.blocks(
  i64 %n, ptr %t, i64 %ts, ptr %y, ptr %c, i64 %cs, ptr %out) nounwind noinline {{
entry:
  %ff = alloca {T}, i64 {BLOCKS * frame}, align 64
  br label %piece
piece:
  %p = phi i64 [0, %entry], [%p1, %computed]
  %pp = getelementptr ptr, ptr @{name}.pieces, i64 %p
  %function = load ptr, ptr %pp, align 8
  br label %compute
compute:
  %e = phi i64 [0, %piece], [%e1, %compute]
  %yk = mul i64 %e, {state}
  %ck = mul i64 %e, %cs
  %ok = mul i64 %e, {outputs}
  %fk = mul i64 %e, {frame}
  %tk = mul i64 %e, %ts
  %te = getelementptr {T}, ptr %t, i64 %tk
  %ye = getelementptr {T}, ptr %y, i64 %yk
  %ce = getelementptr {T}, ptr %c, i64 %ck
  %oe = getelementptr {T}, ptr %out, i64 %ok
  %fe = getelementptr {T}, ptr %ff, i64 %fk
  call void %function(ptr %te, ptr %ye, ptr %ce, ptr %oe, ptr %fe, ptr %fe)
  %e1 = add i64 %e, 1
  %next = icmp slt i64 %e1, %n
  br i1 %next, label %compute, label %computed
computed:
  %p1 = add i64 %p, 1
  %further = icmp slt i64 %p1, {len(pieces)}
  br i1 %further, label %piece, label %done
done:
  ret void
}}
"""


def gather(lanes: int) -> str:
    """Rows to lanes: target[j][k] = source[row + k][j]. Lanes past the last row repeat it.

    ``gather_parts`` does the same for rows in several parts.
    """
    parameters = "ptr noalias %source, i64 %row, i64 %n, i64 %width, i64 %stride, ptr noalias %target"
    text = _Transposition(lanes, "source", "%stride").function("gather", parameters, _Transposition.read)
    return text + _PARTS.replace("LANES", str(lanes))


def scatter(lanes: int) -> str:
    """Lanes to the rows before the end: target[row + k][j] = source[j][k]."""
    parameters = "ptr noalias %source, i64 %row, i64 %n, i64 %width, ptr noalias %target"
    return _Transposition(lanes, "target", "%width").function("scatter", parameters, _Transposition.write)


def deliver(lanes: int) -> str:
    """Lanes to the rows before the end: target[row + k][j] = source[places[j]][k]."""
    parameters = "ptr noalias %source, ptr noalias %places, i64 %row, i64 %n, i64 %width, ptr noalias %target"
    writer = _Transposition(lanes, "target", "%width")
    return writer.function("deliver", parameters, _Transposition.write_placed)


class _Transposition(Lines):
    """The instructions of a function between rows and vectors of lanes."""

    def __init__(self, lanes: int, array: str, stride: str) -> None:
        super().__init__()
        self.lanes = lanes
        self.T = f"<{lanes} x double>"
        self.rows = []
        last = self._new("sub i64 %n, 1")
        for k in range(lanes):  # rows past the end are the last one again
            row = self._new(f"add i64 %row, {k}")
            inside = self._new(f"icmp slt i64 {row}, {last}")
            row = self._new(f"select i1 {inside}, i64 {row}, i64 {last}")
            self.rows.append(self._address("double", f"%{array}", self._new(f"mul i64 {row}, {stride}")))
        self.following = self._address("double", self.rows[0], self._new(f"mul i64 {stride}, {lanes}"))

    def function(
        self, name: str, parameters: str, columns: Callable[[_Transposition, str, int], None]
    ) -> str:
        """Write a function that applies ``columns`` to as many columns as possible at once, then to the remaining."""
        counts = [count for count in COLUMNS if count <= self.lanes]
        before, reached = "entry", "0"
        for count, after in zip(counts, [*(f"test{c}" for c in counts[1:]), "done"], strict=True):
            self.lines += [
                *([f"  br label %test{count}"] if before == "entry" else []),
                f"test{count}:",
                f"  %j{count} = phi i64 [{reached}, %{before}], [%k{count}, %do{count}]",
                f"  %k{count} = add i64 %j{count}, {count}",
                f"  %more{count} = icmp sle i64 %k{count}, %width",
                f"  br i1 %more{count}, label %do{count}, label %{after}",
                f"do{count}:",
            ]
            columns(self, f"%j{count}", count)
            self.lines.append(f"  br label %test{count}")
            before, reached = f"test{count}", f"%j{count}"
        head = f"define internal void @{name}.{self.lanes}({parameters}) nounwind noinline {{\nentry:"
        return "\n".join([head, *self.lines, "done:", "  ret void", "}", ""])

    def read(self, j: str, count: int) -> None:
        """Read columns j, j + 1, ... of the rows into vectors."""
        R, width = f"<{count} x double>", count
        parts = [self._load(R, self._address("double", row, j), 8) for row in self.rows]
        self._ahead(j, count, 0)
        while width < self.lanes:
            side_by_side = range(2 * width)
            parts = [
                self._shuffle(width, parts[k], parts[k + count], side_by_side)
                for m in range(0, len(parts), 2 * count)
                for k in range(m, m + count)
            ]
            width *= 2
        for k, x in enumerate(self._transposed(parts)):
            target = self._address(self.T, "%target", self._new(f"add i64 {j}, {k}"))
            self.lines.append(f"  store {self.T} {x}, ptr {target}, align {8 * self.lanes}")

    def write(self, j: str, count: int) -> None:
        """Write vectors j, j + 1, ... to columns of the rows."""
        self._write(j, [self._new(f"add i64 {j}, {k}") for k in range(count)])

    def write_placed(self, j: str, count: int) -> None:
        """Write the vectors at the places j, j + 1, ... of a table to columns of the rows."""
        places = [self._address("i64", "%places", self._new(f"add i64 {j}, {k}")) for k in range(count)]
        self._write(j, [self._load("i64", place, 8) for place in places])

    def _write(self, j: str, places: Sequence[str]) -> None:
        count = len(places)
        vectors = [
            self._load(self.T, self._address(self.T, "%source", place), 8 * self.lanes) for place in places
        ]
        vectors = self._transposed(vectors)
        for k in reversed(range(self.lanes)):  # the last row is written after the lanes that repeat it
            start = k - k % count
            x = self._shuffle(self.lanes, vectors[k % count], "poison", range(start, start + count))
            target = self._address("double", self.rows[k], j)
            self.lines.append(f"  store <{count} x double> {x}, ptr {target}, align 8")
        self._ahead(j, count, 1)

    def _ahead(self, j: str, count: int, written: int) -> None:
        """Prefetch the same number of vectors of the next rows: a hint to the processor."""
        if self.lanes == 1:
            return
        for k in range(count):
            place = self._new(f"mul i64 {self._new(f'add i64 {j}, {k}')}, {self.lanes}")
            address = self._address("double", self.following, place)
            self.lines.append(f"  call void @llvm.prefetch(ptr {address}, i32 {written}, i32 3, i32 1)")

    def _transposed(self, vectors: Sequence[str]) -> list[str]:
        """Transpose the squares in 1, 2, 4, ... vectors."""
        result, lanes, size = list(vectors), range(self.lanes), 1
        while size < len(result):
            for k in range(len(result)):
                if not k & size:
                    a, b = result[k], result[k + size]
                    low = [self.lanes + i - size if i & size else i for i in lanes]
                    high = [self.lanes + i if i & size else i + size for i in lanes]
                    result[k] = self._shuffle(self.lanes, a, b, low)
                    result[k + size] = self._shuffle(self.lanes, a, b, high)
            size *= 2
        return result

    def _address(self, T: str, base: str, place: str) -> str:
        return self._new(f"getelementptr {T}, ptr {base}, i64 {place}")

    def _load(self, T: str, address: str, align: int) -> str:
        return self._new(f"load {T}, ptr {address}, align {align}")

    def _shuffle(self, width: int, a: str, b: str, places: Sequence[int]) -> str:
        """Vector of the numbers at these places of two vectors of ``width`` side by side."""
        T, mask = f"<{width} x double>", ", ".join(f"i32 {place}" for place in places)
        return self._new(f"shufflevector {T} {a}, {T} {b}, <{len(places)} x i32> <{mask}>")


_PARTS = """define internal void @gather_parts.LANES(
  ptr %parts, i64 %row, i64 %n, i64 %state, ptr %target) nounwind noinline {
entry:
  br label %test
test:
  %k = phi i64 [0, %entry], [%k3, %part]
  %filled = phi i64 [0, %entry], [%more, %part]
  %left = icmp slt i64 %filled, %state
  br i1 %left, label %part, label %done
part:
  %p = getelementptr i64, ptr %parts, i64 %k
  %k1 = add i64 %k, 1
  %p1 = getelementptr i64, ptr %parts, i64 %k1
  %k2 = add i64 %k, 2
  %p2 = getelementptr i64, ptr %parts, i64 %k2
  %k3 = add i64 %k, 3
  %source = load ptr, ptr %p, align 8
  %width = load i64, ptr %p1, align 8
  %stride = load i64, ptr %p2, align 8
  %to = getelementptr <LANES x double>, ptr %target, i64 %filled
  call void @gather.LANES(ptr %source, i64 %row, i64 %n, i64 %width, i64 %stride, ptr %to)
  %more = add i64 %filled, %width
  br label %test
done:
  ret void
}
"""
