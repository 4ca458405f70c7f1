"""Taylor coefficients of eight motions at once, as LLVM IR: each place of a register belongs to one motion.

    p_k = Σ_i a_i b_(k-i) = a_0 b_k + a_k b_0 + Σ_(0<j<k/2) (a_j b_(k-j) + a_(k-j) b_j) + [k even] a_(k/2) b_(k/2)

With a motion in each place of a register, a recurrence (`recurrence`) is computed as written on paper. Nothing is
spread over a register, shifted in it or added up across it, as for one motion (`jet`). The coefficients of a series lie
in memory one after the other.

An order begins with the sums above, without their end terms, for all its products together. A sum runs from the middle
outwards: it needs the coefficients of the previous order last, so that it does not wait for them. The coefficients j
and k - j of a series are read once for all its products. For a square, only half of the sum is computed. Numbers that
multiply a factor are taken out of it, so that products which differ only by numbers are computed once.

Orders are a loop. Unrolled, the kernel of a heavy top took ten times as long to compile and twice as long to run.

The file is longer than others: an order is one text, whose parts share the values computed so far.
"""

from __future__ import annotations

from typing import TypeAlias

from ...native.records import WIDTH
from ..code.emit import Module
from ..code.lower import Program
from .recurrence import ONE, Number, Recurrence
from .rewriting import shortened
from .writer import INVERSES, ORDER, PIECE, SeriesWriter, arguments_of

TOGETHER = 22
"""Number of products that are summed side by side: with their factors they fill the registers."""

_V = f"<{WIDTH} x double>"
_BYTES = 8 * WIDTH
_ROW = (
    ORDER + 1
)  # vectors of a series: an odd number of cache lines, so that rows fall into different sets of the cache
Pair: TypeAlias = tuple[int, int]
Factors: TypeAlias = list[tuple[int, tuple[Number, ...]]]
"""Signs and numbers that multiply a product."""


def jet_of_lanes(module: Module, program: Program, body: str, name: str, piece: int = PIECE) -> int:
    """Add the function ``name`` for eight motions, which writes the rows y_0 ... y_p of eight times the state.

    Its signature is that of the kernels for eight lanes: component i of motion l stands at 8 i + l. It stores the
    coefficients of other series behind the rows, since a stack may be too small for them.

    Parameters
    ----------
    module : Module
    program : Program
    body : str
        Name of the body whose outputs are the rates, in the order of the state.
    name : str
    piece : int
        Number of nodes in one piece of a long recurrence.

    Returns
    -------
    int
        Number of doubles that it writes, including the other series.

    Raises
    ------
    ExpressionError
        For a function with a kink or a jump.
    """
    writer = _Writer(module, shortened(Recurrence(program, body)), name, piece)
    module.functions.append(writer.text())
    return WIDTH * (ORDER + 1) * (len(writer.outputs) + len(writer.rows))


class _Writer(SeriesWriter):
    """Writer of the function that fills the coefficients of eight motions."""

    def __init__(self, module: Module, recurrence: Recurrence, name: str, piece: int) -> None:
        super().__init__(module, recurrence, name, piece, lanes=WIDTH)
        order = recurrence.order
        self.pairs = {i: self._pairs(i) for i in order}
        self.rows = self._rows(order)
        self._start()

    # -- series in memory ---------------------------------------------------------------------

    def _unscaled(self, x: int) -> tuple[int, tuple[Number, ...]]:
        """A series and numbers whose product is the series x."""
        numbers: tuple[Number, ...] = ()
        while self.nodes[x].rule == "scaled":
            numbers += (self.nodes[x].number,)
            x = self.nodes[x].operand
        return x, numbers

    def _pairs(self, i: int) -> dict[Pair, Factors]:
        """Products that node ``i`` adds up, and their factors."""
        node = self.nodes[i]
        if node.rule == "quotient":
            return {_pair(self._unscaled(node.operand)[0], i): []}
        if node.rule == "root":
            return {(i, i): []}
        pairs: dict[Pair, Factors] = {}
        for sign, *ab in node.products:
            (a, first), (b, second) = map(self._unscaled, ab)
            pairs.setdefault(_pair(a, b), []).append((sign, first + second))
        return pairs

    def _rows(self, order: list[int]) -> dict[int, int]:
        """Rows of memory for factors of products, for series that other pieces read and, as -1 - i, for inverses."""
        stored = dict.fromkeys(x for pairs in self.pairs.values() for pair in pairs for x in pair)
        for i in order:
            stored.update(dict.fromkeys(x for x in self._operands(i) if self.owner[x] != self.owner[i]))
        inverses = [-1 - i for i in order if self.nodes[i].rule in ("quotient", "root")]
        return {x: j for j, x in enumerate([*stored, *inverses])}

    def _operands(self, i: int) -> list[int]:
        """Series whose coefficients node ``i`` needs."""
        node = self.nodes[i]
        operands = [x for x in (node.operand, *node.arguments) if isinstance(x, int) and x >= 0]
        operands += [x for _, x in node.terms if isinstance(x, int)]
        return [self._unscaled(x)[0] for x in operands] + [x for pair in self.pairs[i] for x in pair]

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
            main.append(f"  call void @{self.name}.z{j}(ptr %t, {arguments_of(shared)})")
            self._start()
            self._order(j)
            head = f"define internal void @{self.name}.k{j}({orders}) nounwind noinline {{"
            result.append("\n".join([head, *self.lines, "  ret void", "}", ""]))
            loop.append(f"  call void @{self.name}.k{j}({arguments_of(orders)})")
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
                for name, scalar in (("x", "k0"), ("by", "by0"), ("next", "next0"))
                for line in (
                    f"  %{name}.1 = insertelement {_V} poison, double %{scalar}, i32 0",
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
        """Begin a new function: no value is known in it yet."""
        self.lines = []
        self.block, self.here = "0", "%here"
        self.values = {}
        self.numbers = {}
        self.sines = {}
        self.sums: dict[Pair, str] = {}
        self.products: dict[Pair, str] = {}

    def _fused(self, a: str, b: str, total: str | None) -> str:
        """a b + total, where a total of None is zero."""
        if total is None:
            return self._arithmetic("fmul", a, b)
        function = self.module.need_intrinsic("fmuladd", WIDTH, 3)
        return self._new(f"call {_V} {function}({_V} {a}, {_V} {b}, {_V} {total})")

    def _factor(self, factors: Factors) -> str | int:
        """Σ ± products of numbers; an integer if it is a sign only."""
        if len(factors) == 1 and not factors[0][1]:
            return factors[0][0]
        key = tuple(factors)
        if key not in self.numbers:
            total: str | None = None
            for sign, numbers in factors:
                value = self._constant(1.0)
                for j, x in enumerate(numbers):
                    value = self._number(x) if j == 0 else self._arithmetic("fmul", value, self._number(x))
                total = self._signed(total, sign, value)
            assert total is not None
            self.numbers[key] = total
        return self.numbers[key]

    def _value(self, x: int | Number) -> str:
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

    def _outputs_of(self, j: int) -> list[tuple[int, int | Number]]:
        """Outputs that piece ``j`` writes, with their places."""
        return [
            (k, x)
            for k, x in enumerate(self.outputs)
            if (self.owner[self._unscaled(x)[0]] if isinstance(x, int) else 0) == j
        ]

    # -- order 0 ------------------------------------------------------------------------------

    def _zero(self, j: int) -> None:
        """Write the values of a piece at order 0."""
        self.here = "%frame"
        for i in self.pieces[j]:
            if self.nodes[i].rule == "scaled":
                continue
            value = self.values[i] = self._first(i)
            if i in self.rows:
                self._store(value, "%frame", _ROW * self.rows[i])
        for place, x in self._outputs_of(j):
            self._store(self._load("%y", place), "%out", place)
            self._store(self._value(x), "%out", len(self.outputs) + place)

    def _first(self, i: int) -> str:
        """The value of node ``i`` at order 0."""
        node = self.nodes[i]
        match node.rule:
            case "state":
                return self._load("%y", node.place)
            case "time":
                return self._load("%t", 0)
            case "moment":
                return "zeroinitializer"
            case "sum":
                return self._sum(i, True)
            case "quotient":
                divisor, base = self._value(node.operand), self._value(self._unscaled(node.operand)[0])
                inverse = self._arithmetic("fdiv", self._constant(1.0), divisor)
                self._store(inverse, "%frame", _ROW * self.rows[-1 - i])
                base_inverse = inverse
                if base != divisor:
                    base_inverse = self._arithmetic("fdiv", self._constant(1.0), base)
                self._store(base_inverse, "%frame", _ROW * self.rows[-1 - i] + 1)
                above = node.arguments[0]
                return inverse if above == ONE else self._arithmetic("fdiv", self._value(above), divisor)
            case "root":
                value = self._called(
                    self.module.need_intrinsic("sqrt", WIDTH, 1), [self._value(node.operand)]
                )
                inverse = self._arithmetic("fdiv", self._constant(0.5), value)
                for place in (0, 1):
                    self._store(inverse, "%frame", _ROW * self.rows[-1 - i] + place)
                return value
        return self._function_at_start(node)

    # -- order k ------------------------------------------------------------------------------

    def _order(self, j: int) -> None:
        """Write the coefficients of a piece at order k."""
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
        for q, group in enumerate(_grouped(pairs)):
            self._convolve(f"{j}.{q}", group)
        for i in self.pieces[j]:
            if self.nodes[i].rule == "scaled":
                continue
            value = self.values[i] = self._later(i)
            if i in self.rows:
                self._store(value, "%here", _ROW * self.rows[i])
        for place, x in self._outputs_of(j):
            value = "zeroinitializer"
            if not isinstance(x, Number):
                value = self._arithmetic("fmul", self._value(x), "%next")
            self._store(value, "%to", place)

    def _convolve(self, name: str, pairs: list[Pair]) -> None:
        """Write Σ_(0<i<k) a_i b_(k-i) of a group of products; for squares, half of it."""
        before, factors = self.block, list(dict.fromkeys(x for pair in pairs for x in pair))
        self.lines += [f"  br i1 %even, label %mid.{name}, label %begin.{name}", f"mid.{name}:"]
        at = {x: self._load("%mid", _ROW * self.rows[x]) for x in factors}
        first = []
        for a, b in pairs:
            x = self._arithmetic("fmul", at[a], self._constant(0.5)) if a == b else at[a]
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

    def _product(self, pair: Pair) -> str:
        """The coefficient of a product: the sum and the end terms, which contain a_0 or b_0."""
        if pair not in self.products:
            a, b = pair
            total = self.sums[pair]
            for x, y in ((a, b), (b, a))[: 1 if a == b else 2]:
                if x not in self.zero:
                    total = self._fused(self._value(y), self._at_start(x), total)
            self.products[pair] = self._arithmetic("fadd", total, total) if a == b else total
        return self.products[pair]

    def _later(self, i: int) -> str:
        """The coefficient of node ``i`` at order k."""
        node = self.nodes[i]
        match node.rule:
            case "state":
                return self._load("%from", node.place)
            case "time":
                first = self._new("icmp eq i64 %k, 1")
                return self._new(f"select i1 {first}, {_V} {self._constant(1.0)}, {_V} zeroinitializer")
            case "sum":
                return self._sum(i, False)
            case "quotient":
                base, _ = self._unscaled(node.operand)
                partial = self.sums[_pair(base, i)]
                if i not in self.zero:
                    partial = self._fused(self._value(base), self._at_start(i), partial)
                return self._divided(i, node.arguments[0], partial)
            case "root":
                half = self.sums[(i, i)]
                return self._divided(i, node.operand, self._arithmetic("fadd", half, half))
            case "moment":
                return self._arithmetic("fmul", self._value(node.operand), "%x")
        return self._arithmetic("fmul", self._value(node.operand), "%by")

    def _sum(self, i: int, start: bool) -> str:
        """The coefficient of a sum, at order 0 (``start``) or at order k."""
        total: str | None = None
        for sign, x in self.nodes[i].terms:
            if (start and x in self.zero) or (not start and isinstance(x, Number)):
                continue
            if isinstance(x, Number):
                total = self._signed(total, sign, self._number(x))
                continue
            base, numbers = self._unscaled(x)
            total = self._plus(total, self._value(base), self._factor([(sign, numbers)]))
        for pair, factors in self.pairs[i].items():
            if start and (pair[0] in self.zero or pair[1] in self.zero):
                continue
            if start:
                product = self._arithmetic("fmul", self._value(pair[0]), self._value(pair[1]))
            else:
                product = self._product(pair)
            total = self._plus(total, product, self._factor(factors))
        return "zeroinitializer" if total is None else total

    def _plus(self, total: str | None, value: str, factor: str | int) -> str:
        """total + factor · value."""
        if isinstance(factor, int):
            return self._signed(total, factor, value)
        return self._fused(value, factor, total)

    def _divided(self, i: int, above: int | Number, partial: str) -> str:
        """(above - partial) / divisor, with ``above`` used last since it is ready last."""
        inverse, base_inverse = (self._load("%frame", _ROW * self.rows[-1 - i] + place) for place in (0, 1))
        partial = self._signed(None, -1, self._arithmetic("fmul", partial, base_inverse))
        return partial if isinstance(above, Number) else self._fused(self._value(above), inverse, partial)


def _grouped(pairs: list[Pair]) -> list[list[Pair]]:
    """Group the products that are summed side by side: those with common factors together."""
    remaining, groups = list(pairs), list[list[Pair]]()
    size = -(-len(remaining) // -(-len(remaining) // TOGETHER)) if remaining else 0
    while remaining:
        group, factors = list[Pair](), set[int]()
        while remaining and len(group) < size:
            best = min(remaining, key=lambda pair: len({*pair} - factors))
            remaining.remove(best)
            group.append(best)
            factors |= {*best}
        groups.append(group)
    return groups


def _pair(a: int, b: int) -> Pair:
    return (a, b) if a <= b else (b, a)
