"""A lowered program as LLVM IR text.

The IR is written as text, since a line costs a tenth of an object of a builder. Every function is straight-line code on
``double`` or on vectors of 8. A long function is cut into pieces, since LLVM's time grows faster than the length of a
block. Values that cross a cut live in a frame on the stack. A piece receives the frame twice: ``%frame`` to read the
values of earlier pieces, which it never writes, and ``%left`` to store its own. Loads that no store can touch need no
place in the order of memory operations, and the bookkeeping of that order took two thirds of LLVM's time.

Arithmetic carries the flag ``contract`` only: a product and a sum may become one fused multiply-add. NaN and infinity
keep their meaning, and nothing is reordered.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, groupby

from ...native.records import WIDTH
from ...scalar.trace import ADD, CODES, CONST, DIV, INPUT, MUL, NAMES, NEG, SUB
from .ir_text import FLAGS, ZEROS, literal, splat
from .kinds import FIXED, HOISTED, TIME, Kind
from .lower import COS, PROLOGUE, RECIPROCAL, SIN, Body, Group, Program

PIECE = 800
"""Number of operations in one piece of a long function; up to three times as many are not cut."""

RUN = 8
"""Number of consecutive zero outputs from which a loop sets them: matrices of large machines are mostly zero."""

_ARITHMETIC = {
    ADD: f"fadd {FLAGS}", SUB: f"fsub {FLAGS}", MUL: f"fmul {FLAGS}", DIV: f"fdiv {FLAGS}",
}  # fmt: skip
_INTRINSICS = {
    CODES["sqrt"]: "sqrt", CODES["abs"]: "fabs", CODES["min"]: "minimum", CODES["max"]: "maximum",
}  # fmt: skip
_SIGN = CODES["sign"]


@dataclass(frozen=True)
class Form:
    """Arrays that the functions called by a loop read and write.

    Their signature is that of a kernel, for one lane or several, with more pointers behind it: to all arrays that they
    read except the first, then to all arrays that they write except the first.
    """

    lanes: int = 1
    shared: bool = True
    """True if the constants are the same in all lanes: one double each, read into every lane."""
    arrays: tuple[int, ...] = ()
    """Lengths of the arrays that make up the state; a single array if empty."""
    reads: tuple[tuple[int, ...], ...] = ()
    """For each function, the arrays that it receives."""
    writes: tuple[tuple[tuple[int, int], ...], ...] = ()
    """For each function, (number of the array, place) of its outputs; one array in their order if empty."""
    written: tuple[int, ...] = ()
    """For each function, the number of arrays that it writes."""


class Module:
    """A module of functions; :meth:`text` returns it as a whole."""

    def __init__(self, triple: str, layout: str, fused: bool) -> None:
        self.triple = triple
        self.layout = layout
        self.fused = fused
        self.functions: list[str] = []
        self.declarations: set[str] = set()
        self.helpers: dict[str, str] = {}
        self.parts: dict[str, tuple[list[str], int]] = {}

    def text(self) -> str:
        """Text of the module."""
        defined = set(self.declarations)
        head = [f'target triple = "{self.triple}"']
        if self.layout:
            head.append(f'target datalayout = "{self.layout}"')
        head.append('!0 = !{!"branch_weights", i32 1, i32 1048575}')
        return "\n".join([*head, *sorted(defined), *self.helpers.values(), *self.functions]) + "\n"

    def need_sincos(self, lanes: int) -> str:
        """Return the name of the function for sine and cosine, defined at its first use."""
        from . import sincos  # imported late: not needed if the code is on the disk

        self._include(sincos.texts(lanes, self.fused))
        return sincos.name(lanes)

    def _include(self, texts: Mapping[str, str]) -> None:
        """Add functions of the compiled language, with their tables and declarations."""
        for name, text in texts.items():
            if text.startswith("declare"):
                self.declarations.add(text)
            else:
                self.helpers.setdefault(name, text)

    def need_intrinsic(self, name: str, lanes: int, arguments: int) -> str:
        """Return the name of an LLVM intrinsic, declared at its first use."""
        T, suffix = ("double", "f64") if lanes == 1 else (f"<{lanes} x double>", f"v{lanes}f64")
        self.declarations.add(f"declare {T} @llvm.{name}.{suffix}({', '.join([T] * arguments)})")
        return f"@llvm.{name}.{suffix}"

    def need_library(self, name: str, lanes: int, arguments: int) -> str:
        """Return the name of a function of the C library; for a vector, of one that applies it lane by lane."""
        self.declarations.add(f"declare double @{name}({', '.join(['double'] * arguments)})")
        if lanes == 1:
            return f"@{name}"
        key = f"@{name}.{lanes}"
        if key not in self.helpers:
            T = f"<{lanes} x double>"
            letters = "xy"[:arguments]
            lines = [
                f"define internal {T} {key}({', '.join(f'{T} %{z}' for z in letters)}) nounwind noinline {{"
            ]
            last = "poison"
            for i in range(lanes):
                lines += [f"  %{z}{i} = extractelement {T} %{z}, i32 {i}" for z in letters]
                lines.append(
                    f"  %f{i} = call double @{name}({', '.join(f'double %{z}{i}' for z in letters)})"
                )
                lines.append(f"  %r{i} = insertelement {T} {last}, double %f{i}, i32 {i}")
                last = f"%r{i}"
            lines += [f"  ret {T} {last}", "}", ""]
            self.helpers[key] = "\n".join(lines)
        return key

    def need_function(self, name: str, lanes: int, arguments: int) -> str:
        """Return the name of an elementary function: ours with a fused multiply-add, else the C library's."""
        from . import vector_math  # imported late: not needed if the code is on the disk

        if name not in vector_math.FUNCTIONS or not self.fused:
            return self.need_library(name, lanes, arguments)
        self._include(vector_math.texts(name, lanes))
        return vector_math.name(name, lanes)

    def add(self, program: Program, body: Body, name: str, lanes: int = 1, piece: int | None = None) -> None:
        """Add the function ``name``: with the kernel's signature for one lane, of pointers to vectors for 8."""
        writer = _Writer(self, program, body, name, Form(lanes, shared=False), 0, piece or PIECE)
        self.functions.append(writer.text())
        self.parts[writer.name] = writer.parts()

    def add_shared(self, program: Program, kind: Kind, name: str, symbols: Mapping[str, str]) -> None:
        """Add a function of a kind, and with the first of them the body that they share; ``symbols`` are by name."""
        body, own = f"{symbols[kind.name]}.shared", symbols[name]
        if body not in self.parts:
            writer = _Writer(
                self, program, program.bodies[kind.name], body, Form(shared=False), 0, PIECE, kind
            )
            self.functions.append(writer.text())
            self.parts[body] = writer.parts()
        places = kind.members[name][1]
        table = ", ".join(f"i64 {k}" for k in places)
        self.functions.append(
            f"@{own}.table = internal constant [{len(places)} x i64] [{table}]\n"
            f"define void @{own}(double %t, ptr noalias readonly %y, ptr noalias readonly %c, "
            f"ptr noalias %out) nounwind {{\n"
            f"  %own = getelementptr double, ptr %c, i64 {kind.starts[name]}\n"
            f"  tail call void @{body}(double %t, ptr %y, ptr %c, ptr %out, ptr %own, ptr @{own}.table)\n"
            "  ret void\n}\n"
        )

    def add_formed(self, program: Program, body: Body, name: str, form: Form, k: int) -> None:
        """Add a function that a loop calls, the ``k``-th of the form."""
        self.functions.append(_Writer(self, program, body, name, form, k, PIECE).text())

    def add_batch(self, name: str, state: int, hoisted: int, outputs: int, lanes: int = WIDTH) -> None:
        """Add the loop over a batch: rows in, 8 lanes at a time through ``name.lanes``, rows out."""
        from .batch import loop  # imported late: not needed if the code is on the disk

        self._include(loop(name, (state, hoisted, outputs), lanes, *self.parts[f"{name}.lanes"]))


class _Writer:
    """Writer of one function."""

    def __init__(
        self,
        module: Module,
        program: Program,
        body: Body,
        name: str,
        form: Form,
        k: int,
        piece: int,
        kind: Kind | None = None,
    ) -> None:
        lanes = form.lanes
        self.module = module
        self.program = program
        self.body = body
        self.kind = kind or Kind(body.name)
        self.others = ["%own", "%table"] if kind else []  # arguments of a body that functions share
        self.name = name if lanes == 1 else f"{name}.lanes"
        self.lanes = lanes
        self.broadcast = form.shared and lanes > 1
        self.starts = list(accumulate(form.arrays[:-1], initial=0))  # place of the first number of each array
        reads = form.reads[k] if form.reads else (0,)
        self.read = dict(zip(reads, ["%y", *(f"%y{n}" for n in range(1, len(reads)))], strict=True))
        self.places = form.writes[k] if form.writes else [(0, n) for n in range(len(body.outputs))]
        self.written = ["%out", *(f"%out{n}" for n in range(1, form.written[k] if form.written else 1))]
        self.T = "double" if lanes == 1 else f"<{lanes} x double>"
        self.align = 8 if lanes == 1 else 64
        self.pieces = _cut(body.order, piece)
        self.owner = {i: k for k, part in enumerate(self.pieces) for i in part if i >= 0}
        # in a batch each argument is a vector of its own
        sines = 2 * sum(g.lanes if lanes == 1 else len(g.arguments) for g in body.groups)
        self.trig = self._places_of_sines()
        self.frame_size = sines
        self.slots = self._slots(sines)
        self.lines: list[str] = []
        self.output_frame = "%left" if len(self.pieces) > 1 else "%frame"
        self.values: dict[int, str] = {}
        self.computed_sines: set[int] = set()  # arguments whose sines were computed in this piece
        self.count = 0

    def _places_of_sines(self) -> dict[int, tuple[int, int]]:
        """Argument -> places of its sine and cosine in the frame."""
        places: dict[int, tuple[int, int]] = {}
        if self.lanes == 1:
            for g in self.body.groups:
                for k, i in enumerate(g.arguments):
                    places[i] = (g.place + k, g.place + g.lanes + k)
        else:
            for g in self.body.groups:
                for i in g.arguments:
                    places[i] = (2 * len(places), 2 * len(places) + 1)
        return places

    def _slots(self, start: int) -> dict[int, int]:
        """Places in the frame of the values that cross a cut. A place is reused once its value is dead."""
        if len(self.pieces) == 1:
            return {}
        program, owner = self.program, self.owner
        last: dict[int, int] = {}
        for k, part in enumerate(self.pieces):
            for i in part:
                operands = (program.a[i], program.b[i]) if i >= 0 else self.body.groups[-1 - i].arguments
                for p in operands:
                    if p in owner and owner[p] < k:
                        last[p] = k
        leaving: dict[int, list[int]] = {}
        slots: dict[int, int] = {}
        free: list[int] = []
        size = start
        for k, part in enumerate(self.pieces):
            for i in part:
                if i in last:
                    if free:
                        slots[i] = free.pop()
                    else:
                        slots[i] = size
                        size += 1
                    leaving.setdefault(last[i], []).append(slots[i])
            free.extend(leaving.pop(k, ()))
        self.frame_size = size
        return slots

    def text(self) -> str:
        """The function and its pieces."""
        T, lanes = self.T, self.lanes
        time = "double %t" if lanes == 1 else "ptr noalias readonly %t"
        arguments = ", ".join(
            [
                f"{time}, ptr noalias readonly %y, ptr noalias readonly %c, ptr noalias %out",
                *(f"ptr noalias readonly {x}" for x in [*self.read.values()][1:]),
                *(f"ptr noalias {x}" for x in self.written[1:]),
                *(f"ptr noalias readonly {x}" for x in self.others),
            ]
        )
        # values that do not fit in registers are spilled to whole cache lines
        attributes = "nounwind" if lanes == 1 else f"nounwind alignstack({self.align})"
        # pieces receive a frame even if no value crosses a cut
        size = max(self.frame_size, int(len(self.pieces) > 1))
        frame = f"  %frame = alloca {T}, i64 {size}, align 64" if size else ""
        stored: dict[int, list[int]] = {}
        runs = self._runs_of_zeros()
        zero = {k for start, n in runs for k in range(start, start + n)}
        for k, i in enumerate(self.body.outputs):
            if k not in zero:
                stored.setdefault(self.owner.get(i, len(self.pieces) - 1), []).append(k)
        if len(self.pieces) == 1:
            self._start()
            self._zeros(runs)
            self._piece(0, stored.get(0, []))
            head = f"define void @{self.name}({arguments}) {attributes} {{"
            return "\n".join([head, frame, *self.lines, "  ret void", "}", ""])
        result = []
        call = "double %t" if lanes == 1 else "ptr %t"
        main = [f"define void @{self.name}({arguments}) {attributes} {{", frame]
        for k in range(len(self.pieces)):
            self._start()
            if k == 0:
                self._zeros(runs)
            self._piece(k, stored.get(k, []))
            frames = "ptr noalias readonly %frame, ptr noalias %left"
            head = f"define internal void @{self.name}.{k}({arguments}, {frames}) {attributes} noinline {{"
            result.append("\n".join([head, *self.lines, "  ret void", "}", ""]))
            passed = ", ".join(
                f"ptr {x}"
                for x in ("%y", "%c", "%out", *[*self.read.values()][1:], *self.written[1:], *self.others)
            )
            main.append(f"  call void @{self.name}.{k}({call}, {passed}, ptr %frame, ptr %frame)")
        result.append("\n".join([*main, "  ret void", "}", ""]))
        return "\n".join(result)

    def parts(self) -> tuple[list[str], int]:
        """Names of the pieces in their order, and the number of vectors in their frame (0 for a single piece)."""
        if len(self.pieces) == 1:
            return [f"@{self.name}"], 0
        return [f"@{self.name}.{k}" for k in range(len(self.pieces))], max(self.frame_size, 1)

    def _runs_of_zeros(self) -> list[tuple[int, int]]:
        """(first place, length) of long runs of outputs that are always zero."""
        program, result, start = self.program, [], 0
        for zero, run in groupby(
            program.kind[i] == FIXED and program.constants[program.a[i]] == 0 and i not in self.kind.numbers
            for i in self.body.outputs
        ):
            length = len(list(run))
            if zero and length >= RUN and len(self.starts) == 1:
                result.append((start, length))
            start += length
        return result

    def _zeros(self, runs: Sequence[tuple[int, int]]) -> None:
        for start, length in runs:
            self.module.helpers["@zeros"] = ZEROS
            target = self._pointer("%out", start)
            self.lines.append(f"  call void @zeros(ptr {target}, i64 {self.lanes * length})")

    def _start(self) -> None:
        self.lines = []
        self.values = {}
        self.computed_sines.clear()
        self.count = 0

    def _piece(self, k: int, outputs: Sequence[int]) -> None:
        # a value stored at the end of a long function would occupy a register until then
        at_once: dict[int, list[int]] = {}
        if len(self.pieces) > 1:
            for place in outputs:
                at_once.setdefault(self.body.outputs[place], []).append(place)
        for i in self.pieces[k]:
            if i >= 0:
                self._node(i)
                self._store(at_once.pop(i, ()))
            elif self.lanes == 1:
                self._group(self.body.groups[-1 - i])
            else:
                for x in self.body.groups[-1 - i].arguments:
                    self._sincos(x)
        if len(self.pieces) > 1:
            outputs = [place for places in at_once.values() for place in places]
        self._store(outputs)

    def _store(self, outputs: Sequence[int]) -> None:
        for output in outputs:
            value = self._ref(self.body.outputs[output])
            array, place = self.places[output]
            target = self._pointer(self.written[array], place)
            self.lines.append(f"  store {self.T} {value}, ptr {target}, align {self.align}")

    def _pointer(self, base: str, place: int) -> str:
        if place == 0:
            return base
        self.count += 1
        self.lines.append(f"  %p{self.count} = getelementptr {self.T}, ptr {base}, i64 {place}")
        return f"%p{self.count}"

    def _load(self, base: str, place: int) -> str:
        pointer = self._pointer(base, place)
        self.count += 1
        self.lines.append(f"  %l{self.count} = load {self.T}, ptr {pointer}, align {self.align}")
        return f"%l{self.count}"

    def _load_at(self, slot: int) -> str:
        """Load the component of the state whose place is in a slot of the table."""
        pointer = self._pointer("%table", slot)
        self.count += 1
        k = self.count
        self.lines += [
            f"  %i{k} = load i64, ptr {pointer}, align 8",
            f"  %p{k} = getelementptr double, ptr %y, i64 %i{k}",
            f"  %l{k} = load double, ptr %p{k}, align 8",
        ]
        return f"%l{k}"

    def _broadcast(self, base: str, place: int) -> str:
        """Load one double into every lane."""
        T, lanes = self.T, self.lanes
        self.count += 1
        k = self.count
        self.lines += [
            f"  %p{k} = getelementptr double, ptr {base}, i64 {place}",
            f"  %d{k} = load double, ptr %p{k}, align 8",
            f"  %e{k} = insertelement {T} poison, double %d{k}, i64 0",
            f"  %l{k} = shufflevector {T} %e{k}, {T} poison, <{lanes} x i32> zeroinitializer",
        ]
        return f"%l{k}"

    def _ref(self, i: int) -> str:
        """Return the value of node ``i`` in this piece; it is loaded at its first use."""
        value = self.values.get(i)
        if value is not None:
            return value
        program = self.program
        code = program.op[i]
        if i in self.kind.numbers:
            value = self._load("%own", self.kind.numbers[i])
        elif i in self.kind.places:
            value = self._load_at(self.kind.places[i])
        elif program.kind[i] == FIXED or (code == CONST and self.body.name == PROLOGUE):
            value = splat(literal(program.constants[program.a[i]]), self.lanes)
        elif program.kind[i] == HOISTED and self.body.name != PROLOGUE:
            value = (self._broadcast if self.broadcast else self._load)("%c", program.hoisted[i])
        elif code == INPUT:
            if program.a[i] == TIME:
                value = "%t" if self.lanes == 1 else self._load("%t", 0)
            else:
                k = bisect_right(self.starts, program.a[i]) - 1
                value = self._load(self.read[k], program.a[i] - self.starts[k])
        elif code in (SIN, COS):
            frame = self.output_frame if program.a[i] in self.computed_sines else "%frame"
            value = self._load(frame, self.trig[program.a[i]][code == COS])
        else:
            value = self._load("%frame", self.slots[i])
        self.values[i] = value
        return value

    def _node(self, i: int) -> None:
        program, T = self.program, self.T
        code = program.op[i]
        x = self._ref(program.a[i])
        if code in _ARITHMETIC:
            y = self._ref(program.b[i])
            operation = f"{_ARITHMETIC[code]}{T} {x}, {y}"
        elif code == NEG:
            operation = f"fneg {T} {x}"
        elif code == RECIPROCAL:
            operation = f"fdiv {FLAGS}{T} {splat(literal(1.0), self.lanes)}, {x}"
        elif code == _SIGN:
            B = f"<{self.lanes} x i1>" if self.lanes > 1 else "i1"
            zero, one, minus = (splat(literal(v), self.lanes) for v in (0.0, 1.0, -1.0))
            self.lines += [
                f"  %g{i} = fcmp ogt {T} {x}, {zero}",
                f"  %h{i} = fcmp olt {T} {x}, {zero}",
                f"  %s{i} = select {B} %h{i}, {T} {minus}, {T} {x}",  # zero and NaN stay
            ]
            operation = f"select {B} %g{i}, {T} {one}, {T} %s{i}"
        else:
            operands = [x] + ([self._ref(program.b[i])] if program.b[i] >= 0 else [])
            if code in _INTRINSICS:
                function = self.module.need_intrinsic(_INTRINSICS[code], self.lanes, len(operands))
            else:
                function = self.module.need_function(NAMES[code], self.lanes, len(operands))
            operation = f"call {T} {function}({', '.join(f'{T} {z}' for z in operands)})"
        self.lines.append(f"  %v{i} = {operation}")
        self.values[i] = f"%v{i}"
        if i in self.slots:
            pointer = self._pointer(self.output_frame, self.slots[i])
            self.lines.append(f"  store {T} %v{i}, ptr {pointer}, align {self.align}")

    def _group(self, group: Group) -> None:
        """Write sines and cosines of up to 8 scalars in one vector."""
        lanes = group.lanes
        function = self.module.need_sincos(lanes)
        operands = [self._ref(i) for i in group.arguments]
        operands += [operands[-1]] * (lanes - len(operands))
        vector, T = operands[0], "double"
        if lanes > 1:
            T = f"<{lanes} x double>"
            vector = "poison"
            for k, x in enumerate(operands):
                self.count += 1
                self.lines.append(f"  %i{self.count} = insertelement {T} {vector}, double {x}, i32 {k}")
                vector = f"%i{self.count}"
        s, c = (
            self._pointer(self.output_frame, group.place),
            self._pointer(self.output_frame, group.place + lanes),
        )
        self.computed_sines.update(group.arguments)
        self.lines.append(f"  call void {function}({T} {vector}, ptr {s}, ptr {c})")

    def _sincos(self, argument: int) -> None:
        """Write sine and cosine of one vector."""
        function = self.module.need_sincos(self.lanes)
        x = self._ref(argument)
        s, c = (self._pointer(self.output_frame, place) for place in self.trig[argument])
        self.computed_sines.add(argument)
        self.lines.append(f"  call void {function}({self.T} {x}, ptr {s}, ptr {c})")


def _cut(order: list[int], piece: int) -> list[list[int]]:
    """Cut nodes into equal pieces no longer than ``piece``, or leave them in one."""
    count = 1 if len(order) <= 3 * piece else -(-len(order) // piece)
    size = -(-len(order) // count) if order else 1
    return [order[k * size : (k + 1) * size] for k in range(count)]
