"""Taylor coefficients of eight motions at once, as LLVM IR: each number of a register is another motion.

    p_k = Σ_i a_i b_(k-i) = a_0 b_k + a_k b_0 + Σ_(0<j<k/2) (a_j b_(k-j) + a_(k-j) b_j) + [k even] a_(k/2) b_(k/2)

With a motion in each place of a register a recurrence (`recurrence`) is what it is on paper: nothing is spread over a
register, shifted in it or added up across it, as it is for one motion (`jet`). Coefficients lie in memory, those of a
series one after the other. An order begins with the sums above, without the ends, of all its products together: from
the middle outwards, so that the coefficients of the order before are wanted last, and the sums do not wait for them.
The numbers j and k - j of a series are read once for all products it is in. Of a square half the sum is made; numbers
that multiply a factor are taken out of it, so that products which differ by them are one.

Loops, and not one text for each order: unrolled, the kernel of a heavy top took ten times as long to compile and
twice as long to run.

The file is longer than others: an order is one text, whose parts share what is known so far.
"""

from __future__ import annotations

from ...native.ir_text import Lines, literal, splat
from ...native.registers import WIDTH
from ..code.emit import Module
from ..code.lower import Program
from .jet import INVERSES, ORDER, cut, names
from .recurrence import ONE, Number, Recurrence
from .rewriting import shortened

PIECE = 400
"""Nodes of one piece of a long recurrence."""
TOGETHER = 22
"""Products that are summed side by side: with their factors they fill the registers."""

_V = f"<{WIDTH} x double>"
_BYTES = 8 * WIDTH
_ROW = _BYTES * (
    ORDER + 1
)  # an odd number of lines of the cache, so that rows do not lie in the same sets of it
Pair = tuple[int, int]


def jet_wide(module: Module, program: Program, body: str, name: str, piece: int = PIECE) -> int:
    """Add the function ``name`` on eight motions, which writes the rows y_0 ... y_p of eight times the state.

    Its signature is that of the kernels for eight lanes: component i of motion l stands at 8 i + l. After the rows it
    needs room for the coefficients of other series, which a stack may not have.

    Parameters
    ----------
    module : Module
    program : Program
    body : str
        Name of the body whose outputs are the rates, in the order of the state.
    name : str
    piece : int
        Nodes of one piece of a long recurrence.

    Returns
    -------
    int
        How many numbers it writes, with those in that room.

    Raises
    ------
    ExpressionError
        A function that bends or jumps.
    """
    writer = _Writer(module, shortened(Recurrence(program, body)), name, piece)
    module.functions.append(writer.text())
    return WIDTH * (ORDER + 1) * (len(writer.outputs) + len(writer.rows))


class _Writer(Lines):
    """The function that fills the coefficients."""

    T = _V

    def __init__(self, module: Module, recurrence: Recurrence, name: str, piece: int) -> None:
        self.module, self.name = module, name
        self.nodes, self.outputs = recurrence.nodes, recurrence.outputs
        self.zero = recurrence.starts_at_zero
        order = recurrence.order
        self.pieces = cut(order, piece)
        self.owner = {i: j for j, part in enumerate(self.pieces) for i in part}
        self.pairs = {i: self._pairs(i) for i in order}
        self.rows = self._rows(order)
        super().__init__()
        self._start()

    # -- what is kept -------------------------------------------------------------------------

    def _unscaled(self, x: int) -> tuple[int, tuple[Number, ...]]:
        """The series and the numbers whose product a series is."""
        numbers: tuple[Number, ...] = ()
        while self.nodes[x].rule == "scaled":
            numbers += (self.nodes[x].number,)
            x = self.nodes[x].operand
        return x, numbers

    def _pairs(self, i: int) -> dict[Pair, list[tuple[int, tuple[Number, ...]]]]:
        """Products that node ``i`` adds up, and their factors: signs and numbers."""
        node = self.nodes[i]
        if node.rule == "quotient":
            return {_pair(self._unscaled(node.operand)[0], i): []}
        if node.rule == "root":
            return {(i, i): []}
        found: dict[Pair, list[tuple[int, tuple[Number, ...]]]] = {}
        for sign, *ab in node.products:
            (a, first), (b, second) = map(self._unscaled, ab)
            found.setdefault(_pair(a, b), []).append((sign, first + second))
        return found

    def _rows(self, order: list[int]) -> dict[int, int]:
        """Rows of memory: of the factors of products, of what other pieces read and, as -1 - i, of inverses."""
        kept = dict.fromkeys(x for pairs in self.pairs.values() for pair in pairs for x in pair)
        for i in order:
            kept.update(dict.fromkeys(x for x in self._read(i) if self.owner[x] != self.owner[i]))
        inverses = [-1 - i for i in order if self.nodes[i].rule in ("quotient", "root")]
        return {x: j for j, x in enumerate([*kept, *inverses])}

    def _read(self, i: int) -> list[int]:
        """Series whose coefficients node ``i`` needs."""
        node = self.nodes[i]
        found = [x for x in (node.operand, *node.arguments) if isinstance(x, int) and x >= 0]
        found += [x for _, x in node.terms if isinstance(x, int)]
        return [self._unscaled(x)[0] for x in found] + [x for pair in self.pairs[i] for x in pair]

    # -- text ---------------------------------------------------------------------------------

    def text(self) -> str:
        """The function and its pieces."""
        shared = "ptr noalias %y, ptr noalias %c, ptr noalias %out, ptr noalias %frame"
        orders = (
            f"i64 %k, {_V} %x, {_V} %by, {_V} %next, ptr noalias %from, ptr noalias %to, ptr %here, {shared}"
        )
        result, main, loop = [], [], []
        for j in range(len(self.pieces)):
            self._start()
            self._zero(j)
            head = f"define internal void @{self.name}.z{j}(ptr noalias %t, {shared}) nounwind noinline {{"
            result.append("\n".join([head, *self.lines, "  ret void", "}", ""]))
            main.append(f"  call void @{self.name}.z{j}(ptr %t, {names(shared)})")
            self._start()
            self._order(j)
            head = f"define internal void @{self.name}.k{j}({orders}) nounwind noinline {{"
            result.append("\n".join([head, *self.lines, "  ret void", "}", ""]))
            loop.append(f"  call void @{self.name}.k{j}({names(orders)})")
        self.module.helpers["@jet.inverse"] = INVERSES
        width = _BYTES * len(self.outputs)
        main = [
            f"define void @{self.name}(ptr noalias %t, {shared.rpartition(',')[0]}) nounwind {{",
            f"  %frame = getelementptr i8, ptr %out, i64 {width * (ORDER + 1)}",
            *main,
            "  br label %loop",
            "loop:",
            "  %k = phi i64 [ 1, %0 ], [ %k1, %loop ]",
            "  %k1 = add i64 %k, 1",
            "  %k0 = sitofp i64 %k to double",
            "  %at = getelementptr double, ptr @jet.inverse, i64 %k",
            "  %by0 = load double, ptr %at, align 8",
            "  %after = getelementptr double, ptr %at, i64 1",
            "  %next0 = load double, ptr %after, align 8",
            *(
                line
                for name, one in (("x", "k0"), ("by", "by0"), ("next", "next0"))
                for line in (
                    f"  %{name}.1 = insertelement {_V} poison, double %{one}, i32 0",
                    f"  %{name} = shufflevector {_V} %{name}.1, {_V} poison, <{WIDTH} x i32> zeroinitializer",
                )
            ),
            f"  %row = mul i64 %k, {width}",
            "  %from = getelementptr i8, ptr %out, i64 %row",
            f"  %to = getelementptr i8, ptr %from, i64 {width}",
            f"  %far = mul i64 %k, {_BYTES}",
            "  %here = getelementptr i8, ptr %frame, i64 %far",
            *loop,
            f"  %more = icmp slt i64 %k1, {ORDER}",
            "  br i1 %more, label %loop, label %done",
            "done:",
            "  ret void",
            "}",
            "",
        ]
        return "\n".join([*result, *main])

    def _start(self) -> None:
        self.lines = []
        self.block, self.here = "0", "%here"
        self.values: dict[int, str] = {}
        self.sums: dict[Pair, str] = {}
        self.whole: dict[Pair, str] = {}
        self.numbers: dict[object, str] = {}
        self.sines: dict[int | Number, tuple[str, str]] = {}

    def _load(self, base: str, bytes_: int) -> str:
        pointer = base if bytes_ == 0 else self._new(f"getelementptr i8, ptr {base}, i64 {bytes_}")
        return self._new(f"load {_V}, ptr {pointer}, align 64")

    def _store(self, value: str, base: str, bytes_: int) -> None:
        pointer = base if bytes_ == 0 else self._new(f"getelementptr i8, ptr {base}, i64 {bytes_}")
        self.lines.append(f"  store {_V} {value}, ptr {pointer}, align 64")

    def _fused(self, a: str, b: str, total: str | None) -> str:
        """a b + total; None is zero."""
        if total is None:
            return self._arithmetic("fmul", a, b)
        function = self.module.need_intrinsic("fmuladd", WIDTH, 3)
        return self._new(f"call {_V} {function}({_V} {a}, {_V} {b}, {_V} {total})")

    def _number(self, x: Number) -> str:
        if x not in self.numbers:
            value = self._load("%c", _BYTES * x.place) if x.value is None else splat(literal(x.value), WIDTH)
            if x.function == "square":
                value = self._arithmetic("fmul", value, value)
            elif x.function:
                value = self._new(
                    f"call {_V} {self.module.need_function(x.function, WIDTH, 1)}({_V} {value})"
                )
            self.numbers[x] = value
        return self.numbers[x]

    def _factor(self, factors: list[tuple[int, tuple[Number, ...]]]) -> str | int:
        """Σ ± products of numbers, as a sign where it is one."""
        if len(factors) == 1 and not factors[0][1]:
            return factors[0][0]
        key = tuple(factors)
        if key not in self.numbers:
            total: str | None = None
            for sign, numbers in factors:
                value = splat(literal(1.0), WIDTH)
                for j, x in enumerate(numbers):
                    value = self._number(x) if j == 0 else self._arithmetic("fmul", value, self._number(x))
                total = self._signed(total, sign, value)
            assert total is not None
            self.numbers[key] = total
        return self.numbers[key]

    def _value(self, x: int | Number) -> str:
        """The coefficient at this order; of a number, that at order 0."""
        if isinstance(x, Number):
            return self._number(x)
        if x not in self.values:
            if self.nodes[x].rule == "scaled":
                base, numbers = self._unscaled(x)
                factor = self._factor([(1, numbers)])
                assert isinstance(factor, str)
                self.values[x] = self._arithmetic("fmul", self._value(base), factor)
            else:
                self.values[x] = self._load(self.here, _ROW * self.rows[x])
        return self.values[x]

    def _at_start(self, x: int) -> str:
        """The coefficient at order 0 of a factor."""
        return self._load("%frame", _ROW * self.rows[x])

    def _mine(self, j: int) -> list[tuple[int, int | Number]]:
        """Outputs, with their places, that piece ``j`` writes."""
        return [
            (k, x)
            for k, x in enumerate(self.outputs)
            if (self.owner[self._unscaled(x)[0]] if isinstance(x, int) else 0) == j
        ]

    # -- order 0 ------------------------------------------------------------------------------

    def _zero(self, j: int) -> None:
        """Values of a piece."""
        self.here = "%frame"
        for i in self.pieces[j]:
            if self.nodes[i].rule == "scaled":
                continue
            value = self.values[i] = self._first(i)
            if i in self.rows:
                self._store(value, "%frame", _ROW * self.rows[i])
        for place, x in self._mine(j):
            self._store(self._load("%y", _BYTES * place), "%out", _BYTES * place)
            self._store(self._value(x), "%out", _BYTES * (len(self.outputs) + place))

    def _first(self, i: int) -> str:
        """The value of node ``i`` at the start."""
        node = self.nodes[i]
        match node.rule:
            case "state":
                return self._load("%y", _BYTES * node.place)
            case "time":
                return self._load("%t", 0)
            case "moment":
                return "zeroinitializer"
            case "sum":
                return self._sum(i, True)
            case "quotient":
                divisor, base = self._value(node.operand), self._value(self._unscaled(node.operand)[0])
                inverse = self._arithmetic("fdiv", splat(literal(1.0), WIDTH), divisor)
                self._store(inverse, "%frame", _ROW * self.rows[-1 - i])
                of_base = inverse
                if base != divisor:
                    of_base = self._arithmetic("fdiv", splat(literal(1.0), WIDTH), base)
                self._store(of_base, "%frame", _ROW * self.rows[-1 - i] + _BYTES)
                above = node.arguments[0]
                return inverse if above == ONE else self._arithmetic("fdiv", self._value(above), divisor)
            case "root":
                function = self.module.need_intrinsic("sqrt", WIDTH, 1)
                value = self._new(f"call {_V} {function}({_V} {self._value(node.operand)})")
                inverse = self._arithmetic("fdiv", splat(literal(0.5), WIDTH), value)
                for place in (0, _BYTES):
                    self._store(inverse, "%frame", _ROW * self.rows[-1 - i] + place)
                return value
        if node.function in ("sin", "cos"):
            return self._load(self._sine_and_cosine(node.arguments[0])[node.function == "cos"], 0)
        arguments = ", ".join(f"{_V} {self._value(x)}" for x in node.arguments)
        function = self.module.need_function(node.function, WIDTH, len(node.arguments))
        return self._new(f"call {_V} {function}({arguments})")

    def _sine_and_cosine(self, x: int | Number) -> tuple[str, str]:
        """Where they are."""
        if x not in self.sines:
            value, s, c = self._value(x), *(self._new(f"alloca {_V}, align 64") for _ in range(2))
            self.lines.append(f"  call void {self.module.need_sincos(WIDTH)}({_V} {value}, ptr {s}, ptr {c})")
            self.sines[x] = (s, c)
        return self.sines[x]

    # -- order k ------------------------------------------------------------------------------

    def _order(self, j: int) -> None:
        """Coefficients of a piece at order k."""
        pairs = list(dict.fromkeys(pair for i in self.pieces[j] for pair in self.pairs[i]))
        if pairs:
            self.lines += [
                "  %odd = and i64 %k, 1",
                "  %even = icmp eq i64 %odd, 0",
                "  %m = lshr i64 %k, 1",
                f"  %m1 = mul i64 %m, {_BYTES}",
                "  %mid = getelementptr i8, ptr %frame, i64 %m1",
                "  %k.1 = sub i64 %k, 1",
                "  %half = lshr i64 %k.1, 1",
                "  %any = icmp ne i64 %half, 0",
            ]
        for q, some in enumerate(_gathered(pairs)):
            self._convolve(f"{j}.{q}", some)
        for i in self.pieces[j]:
            if self.nodes[i].rule == "scaled":
                continue
            value = self.values[i] = self._later(i)
            if i in self.rows:
                self._store(value, "%here", _ROW * self.rows[i])
        for place, x in self._mine(j):
            value = "zeroinitializer"
            if not isinstance(x, Number):
                value = self._arithmetic("fmul", self._value(x), "%next")
            self._store(value, "%to", _BYTES * place)

    def _convolve(self, name: str, pairs: list[Pair]) -> None:
        """Σ_(0<i<k) a_i b_(k-i) of some products, of squares half of it."""
        before, factors = self.block, list(dict.fromkeys(x for pair in pairs for x in pair))
        self.lines += [f"  br i1 %even, label %mid.{name}, label %begin.{name}", f"mid.{name}:"]
        at = {x: self._load("%mid", _ROW * self.rows[x]) for x in factors}
        first = []
        for a, b in pairs:
            x = self._arithmetic("fmul", at[a], splat(literal(0.5), WIDTH)) if a == b else at[a]
            first.append(self._arithmetic("fmul", x, at[b]))
        self.lines += [f"  br label %begin.{name}", f"begin.{name}:"]
        started = [self._new(f"phi {_V} [ zeroinitializer, %{before} ], [ {x}, %mid.{name} ]") for x in first]
        self.lines += [f"  br i1 %any, label %loop.{name}, label %end.{name}", f"loop.{name}:"]
        self.lines.append(f"  %i.{name} = phi i64 [ %half, %begin.{name} ], [ %i1.{name}, %loop.{name} ]")
        self.count += 1
        label, place = self.count, len(self.lines)
        up = self._new(f"mul i64 %i.{name}, {_BYTES}")
        low = self._new(f"getelementptr i8, ptr %frame, i64 {up}")
        down = self._new(f"sub i64 0, {up}")
        high = self._new(f"getelementptr i8, ptr %here, i64 {down}")
        lows: dict[int, str] = {}
        highs: dict[int, str] = {}
        ends = []
        for j, (a, b) in enumerate(pairs):
            for factor in (a, b):
                if factor not in lows:
                    lows[factor] = self._load(low, _ROW * self.rows[factor])
                    highs[factor] = self._load(high, _ROW * self.rows[factor])
            total = self._fused(lows[a], highs[b], f"%s{label}.{j}")
            if a != b:
                total = self._fused(lows[b], highs[a], total)
            ends.append(total)
        self.lines[place:place] = [
            f"  %s{label}.{j} = phi {_V} [ {x}, %begin.{name} ], [ {y}, %loop.{name} ]"
            for j, (x, y) in enumerate(zip(started, ends, strict=True))
        ]
        self.lines += [
            f"  %i1.{name} = sub i64 %i.{name}, 1",
            f"  %more.{name} = icmp ne i64 %i1.{name}, 0",
            f"  br i1 %more.{name}, label %loop.{name}, label %end.{name}",
            f"end.{name}:",
        ]
        for pair, x, y in zip(pairs, started, ends, strict=True):
            self.sums[pair] = self._new(f"phi {_V} [ {x}, %begin.{name} ], [ {y}, %loop.{name} ]")
        self.block = f"end.{name}"

    def _ended(self, pair: Pair, total: str, sign: int) -> str:
        """A sum of products with the two that have a_0 or b_0, of a square half of them."""
        a, b = pair
        for x, y in ((a, b), (b, a))[: 1 if a == b else 2]:
            if x not in self.zero:
                value = self._value(y)
                if sign < 0:
                    value = self._new(f"fneg {_V} {value}")
                total = self._fused(value, self._at_start(x), total)
        return total

    def _product(self, pair: Pair) -> str:
        """The coefficient of a product."""
        if pair not in self.whole:
            total = self._ended(pair, self.sums[pair], 1)
            self.whole[pair] = self._arithmetic("fadd", total, total) if pair[0] == pair[1] else total
        return self.whole[pair]

    def _later(self, i: int) -> str:
        """The coefficient of node ``i`` at order k."""
        node = self.nodes[i]
        match node.rule:
            case "state":
                return self._load("%from", _BYTES * node.place)
            case "time":
                first = self._new("icmp eq i64 %k, 1")
                one = splat(literal(1.0), WIDTH)
                return self._new(f"select i1 {first}, {_V} {one}, {_V} zeroinitializer")
            case "sum":
                return self._sum(i, False)
            case "quotient":
                base, _ = self._unscaled(node.operand)
                known = self.sums[_pair(base, i)]
                if i not in self.zero:
                    known = self._fused(self._value(base), self._at_start(i), known)
                return self._divided(i, node.arguments[0], known)
            case "root":
                known = self.sums[(i, i)]
                return self._divided(i, node.operand, self._arithmetic("fadd", known, known))
            case "moment":
                return self._arithmetic("fmul", self._value(node.operand), "%x")
        return self._arithmetic("fmul", self._value(node.operand), "%by")

    def _sum(self, i: int, start: bool) -> str:
        """The coefficient of a sum, at the start or at order k."""
        total: str | None = None
        for sign, x in self.nodes[i].terms:
            if (start and x in self.zero) or (not start and isinstance(x, Number)):
                continue
            if isinstance(x, Number):
                total = self._signed(total, sign, self._number(x))
                continue
            base, numbers = self._unscaled(x)
            total = self._with(total, self._value(base), self._factor([(sign, numbers)]))
        for pair, factors in self.pairs[i].items():
            if start and (pair[0] in self.zero or pair[1] in self.zero):
                continue
            if start:
                product = self._arithmetic("fmul", self._value(pair[0]), self._value(pair[1]))
            else:
                product = self._product(pair)
            total = self._with(total, product, self._factor(factors))
        return "zeroinitializer" if total is None else total

    def _with(self, total: str | None, value: str, factor: str | int) -> str:
        """total + factor value."""
        if isinstance(factor, int):
            return self._signed(total, factor, value)
        return self._fused(value, factor, total)

    def _divided(self, i: int, above: int | Number, known: str) -> str:
        """(above - known) / divisor, where ``above`` comes last."""
        of_whole, of_base = (self._load("%frame", _ROW * self.rows[-1 - i] + place) for place in (0, _BYTES))
        known = self._signed(None, -1, self._arithmetic("fmul", known, of_base))
        return known if isinstance(above, Number) else self._fused(self._value(above), of_whole, known)


def _gathered(pairs: list[Pair]) -> list[list[Pair]]:
    """Products that are summed side by side, those with factors in common together."""
    left, result = list(pairs), list[list[Pair]]()
    size = -(-len(left) // -(-len(left) // TOGETHER)) if left else 0
    while left:
        some, factors = list[Pair](), set[int]()
        while left and len(some) < size:
            best = min(left, key=lambda pair: len({*pair} - factors))
            left.remove(best)
            some.append(best)
            factors |= {*best}
        result.append(some)
    return result


def _pair(a: int, b: int) -> Pair:
    return (a, b) if a <= b else (b, a)
