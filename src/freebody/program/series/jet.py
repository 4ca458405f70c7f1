"""Taylor coefficients of the solution of y' = f(t, y, c), as LLVM IR.

    y(t + τ) = Σ_k y_k τᵏ,    (k + 1) y_(k+1) = f_k

The sums of the recurrences (`recurrence`) are not made when they are wanted, but in advance and in vectors: as soon as
a_k and b_k are known they are multiplied by all that went before, which adds to the sums of the orders k to 2k,

    (s_k, s_(k+1), ...) += a_k (b_0, b_1, ... b_k) + b_k (a_0, ... a_(k-1), 0),

whose first entry then is complete and is shifted out. So nothing is summed across a vector; what an order waits for
are the two products with a_0 and b_0 only. Of p coefficients half stand in the vectors: a_i b_j with i + j < p has
the smaller index below p/2.

Sums stay in memory, which the code of an order touches twice, where it begins and ends them: registers are fewer. A
short recurrence is a loop whose other vectors stay in registers, or where these do not suffice on the stack; it is
written twice, since the vectors are complete at order p/2 and only read from there on. A long one is cut into pieces,
and keeps them in memory too.

The file is longer than others: what is known when, and so the order of the text, is one matter.

Source: J. van der Hoeven, Relax, but don't be too lazy (2002): products in advance.
"""

from __future__ import annotations

from ...native.ir_text import Lines, literal
from ..code.emit import Module
from ..code.lower import Program
from .combining import combined
from .recurrence import ONE, Number, Recurrence
from .rewriting import shortened

LANES = 8
ORDER = 2 * LANES
"""p, the last coefficient. Its cost grows little with it while half of the sums fit in a register."""
PIECE = 400
"""Nodes of one piece of a long recurrence."""

STRETCHES = (1, LANES, True), (LANES, ORDER, False)
"""Orders from and to, and whether their coefficients go into the vectors."""

_V, _B = f"<{LANES} x double>", f"<{LANES} x i1>"
_TURN = "<" + ", ".join(f"i32 {(k + 1) % LANES}" for k in range(LANES)) + ">"
_PLACES = "<" + ", ".join(f"i64 {k}" for k in range(LANES)) + ">"
_LANE = (
    f"  %k0 = insertelement <{LANES} x i64> poison, i64 %k, i32 0",
    f"  %kk = shufflevector <{LANES} x i64> %k0, <{LANES} x i64> poison, <{LANES} x i32> zeroinitializer",
    f"  %lane = icmp eq <{LANES} x i64> %kk, {_PLACES}",
    f"  %below = icmp ugt <{LANES} x i64> %kk, {_PLACES}",
)
"""Which lane is the k-th, and which come before."""
_REST = (
    "  %last = load i64, ptr @jet.last",
    f"  %last0 = insertelement <{LANES} x i64> poison, i64 %last, i32 0",
    f"  %lasts = shufflevector <{LANES} x i64> %last0, <{LANES} x i64> poison, <{LANES} x i32> zeroinitializer",
    f"  %rest = icmp ugt <{LANES} x i64> %lasts, {_PLACES}",
)
"""All lanes but the last, in a register: what LLVM knows for a constant it shifts in by two instructions, not one."""
INVERSES = (
    f"@jet.inverse = private constant [{ORDER + 1} x double] "
    f"[{', '.join(f'double {literal(1 / max(k, 1))}' for k in range(ORDER + 1))}]"
)
"""1 / k, and what is not read for k = 0."""
LAST = f"@jet.last = internal global i64 {LANES - 1}"


def jet(module: Module, program: Program, body: str, name: str, stride: int, piece: int = PIECE) -> None:
    """Add the function ``name`` of a kernel's signature, which writes the rows y_0 ... y_p.

    Parameters
    ----------
    module : Module
    program : Program
    body : str
        Name of the body whose outputs are the rates, in the order of the state.
    name : str
    stride : int
        Length of a row, which may be longer than the state.
    piece : int
        Nodes of one piece of a long recurrence.

    Raises
    ------
    ExpressionError
        A function that bends or jumps.
    """
    recurrence = shortened(Recurrence(program, body))
    if len(cut(recurrence.order, piece)) == 1:
        combined(recurrence)
    module.functions.append(_Writer(module, recurrence, name, stride, piece).text())


class _Writer(Lines):
    """The function that fills the coefficients."""

    def __init__(self, module: Module, recurrence: Recurrence, name: str, stride: int, piece: int) -> None:
        self.module, self.name, self.stride = module, name, stride
        self.nodes, self.outputs = recurrence.nodes, recurrence.outputs
        self.zero = recurrence.starts_at_zero
        order = recurrence.order
        self.pieces = cut(order, piece)
        self.single = len(self.pieces) == 1
        self.owner = {i: j for j, part in enumerate(self.pieces) for i in part}
        self.pairs = {i: self._pairs(i) for i in order}
        self.sums = {i: j for j, i in enumerate(i for i in order if self.pairs[i])}
        factors = dict.fromkeys(x for p in self.pairs.values() for _, *ab in p for x in ab)
        self.vectors = {i: len(self.sums) + j for j, i in enumerate(factors)}
        self.direct = {i: x for i in order if (x := self._directly(i)) >= 0}
        self.given = {self.nodes[i].operand for i in self.direct}
        self.after = self._after(order)
        self.ends = {i: self.owner[j] for j, found in self.after.items() for i in found}
        self.ready = self._ready(order)
        self.divisors = {
            i: j for j, i in enumerate(i for i in order if self.nodes[i].rule in ("quotient", "root"))
        }
        self.slots = self._crossing()
        super().__init__()
        self.combined: dict[Number, str] = {}  # made before the loops
        self.tag, self.grows = "", True
        self._start()

    # -- what needs what ----------------------------------------------------------------------

    def _pairs(self, i: int) -> list[tuple[int, int, int]]:
        """The products that node ``i`` keeps sums of, with their signs."""
        node = self.nodes[i]
        if node.rule == "quotient":
            return [(1, node.operand, i)]
        if node.rule == "root":
            return [(1, i, i)]
        return list(node.products)

    def _directly(self, i: int) -> int:
        """x, where node ``i`` is y with ϑy = ± g ϑx, so that y_k = ± g_0 x_k + (the rest of the sum) / k; else -1."""
        node = self.nodes[i]
        if node.rule == "integral":
            rate = self.nodes[node.operand]
            if rate.rule == "sum" and not rate.terms and len(rate.products) == 1:
                moment = self.nodes[rate.products[0][1]]
                return moment.operand if moment.rule == "moment" else -1
        return -1

    def _operands(self, i: int) -> list[int]:
        """Nodes whose k-th coefficient the k-th of node ``i`` needs."""
        node = self.nodes[i]
        found = [self._unscaled(x)[0] for _, x in node.terms if isinstance(x, int)]
        for _, a, b in node.products:  # (ϑx b)_k does not need b_k
            found += [self._unscaled(x)[0] for x, other in ((a, b), (b, a)) if other not in self.zero]
        if node.operand >= 0:
            found.append(node.operand)
        if node.rule == "quotient" and isinstance(node.arguments[0], int):
            found.append(node.arguments[0])
        return found

    def _after(self, order: list[int]) -> dict[int, list[int]]:
        """After which node the products of which others can be added."""
        place = {i: j for j, i in enumerate(order)}
        reader = {self.nodes[i].operand: i for i in self.direct}
        result: dict[int, list[int]] = {}
        for i in order:
            if self.pairs[i]:
                last = max(place[x] for x in (reader.get(i, i), *(x for _, *ab in self.pairs[i] for x in ab)))
                result.setdefault(order[last], []).append(i)
        return result

    def _halves(self, i: int) -> list[tuple[int, int, int]]:
        """(sign, a, b): what the products a b of a sum still need at order k is a_k b_0, from both sides."""
        return [
            (sign, x, y)
            for sign, a, b in self.nodes[i].products
            for x, y in ((a, b), (b, a))
            if y not in self.zero
        ]

    def _unscaled(self, x: int) -> tuple[int, Number]:
        """A series and a number with that product: where a multiplication waits anyway, that by the number need not."""
        node = self.nodes[x]
        return (node.operand, node.number) if node.rule == "scaled" else (x, ONE)

    def _ready(self, order: list[int]) -> dict[int, int]:
        """When the value of each node is there, in cycles from the beginning of an order, 4 for an operation."""
        ready: dict[int, int] = {}
        for i in order:
            node, now = self.nodes[i], 0
            if node.rule == "sum":
                waits = [ready[self._unscaled(x)[0]] for _, x in node.terms if isinstance(x, int)]
                waits += [ready[self._unscaled(x)[0]] for _, x, _ in self._halves(i)]
                now = min(_end(sorted(waits), chains) for chains in (1, 2))
            elif i in self.direct:
                now = ready[self.direct[i]] + 4
            elif node.rule not in ("state", "time"):
                now = 4 + max(ready[x] for x in self._operands(i))
                if node.rule == "quotient":
                    now = max(now, ready[node.operand] + 8)
            ready[i] = now
        return ready

    def _crossing(self) -> dict[int, int]:
        """Places of the values that are read in other pieces than their own."""
        found: dict[int, int] = {}
        for i, j in self.owner.items():
            needed = self._operands(i) + [x for x in self.nodes[i].arguments if isinstance(x, int)]
            needed += [x for _, x in self.nodes[i].terms if isinstance(x, int)]
            needed += [x for _, *ab in self.nodes[i].products for x in ab]
            needed += [self.direct[i]] if i in self.direct else []
            needed += [x for other in self.after.get(i, ()) for _, *ab in self.pairs[other] for x in ab]
            for x in needed:
                if self.owner[x] != j:
                    found.setdefault(x, len(self.divisors) + len(found))
        return found

    def _early(self, i: int) -> list[tuple[int, int, int, bool]]:
        """(sign, a, b, whether with b_k): products a_k (b_0, ...) that complete the k-th sum of node ``i``."""
        node = self.nodes[i]
        if node.rule == "quotient":
            return [(1, node.operand, i, False)]
        result = []
        for sign, a, b in node.products:
            if a in self.zero or b in self.zero:
                result.append((sign, a, b, False) if a in self.zero else (sign, b, a, False))
            else:
                if self.ready[a] > self.ready[b]:
                    a, b = b, a
                result += [(sign, a, b, False), (sign, b, a, True)]  # the first does not wait for b_k
        return sorted(result, key=lambda one: self.ready[one[1]])

    def _late(self, i: int) -> list[tuple[int, int, int, bool]]:
        """The others, for later sums only."""
        node = self.nodes[i]
        if node.rule == "root":
            return [(1, i, i, True), (1, i, i, False)]
        if node.rule == "quotient":
            return [(1, i, node.operand, True)]
        return [
            (sign, b, a, True) if a in self.zero else (sign, a, b, True)
            for sign, a, b in node.products
            if a in self.zero or b in self.zero
        ]

    # -- text ---------------------------------------------------------------------------------

    def text(self) -> str:
        """The function and its pieces."""
        result: list[str] = []
        shared = "ptr noalias %y, ptr noalias %c, ptr noalias %out, ptr noalias %frame, ptr noalias %slots"
        orders = f"i64 %k, double %x, double %by, double %next, ptr noalias %from, ptr noalias %to, {shared}"
        room = len(self.sums) + (0 if self.single else len(self.vectors))
        main = [
            f"define void @{self.name}(double %t, ptr noalias %y, ptr noalias %c, ptr noalias %out) nounwind {{",
            f"  %frame = alloca {_V}, i64 {max(1, room)}, align 64",
            f"  %slots = alloca double, i64 {max(1, len(self.divisors) + len(self.slots))}, align 64",
        ]
        self.module.helpers |= {"@jet.inverse": INVERSES, "@jet.last": LAST}
        if self.single:
            self._zero(0)
            for i in self.owner:
                if self.nodes[i].number.parts:
                    self._number(self.nodes[i].number)
            self.combined = {x: value for x, value in self.numbers.items() if x.parts}
            main += [*_REST, *self.lines]
            last = [self._value(x) for x in self.outputs], self.held
            for stretch in STRETCHES:
                lines, last = self._stretch(*stretch, *last)
                main += lines
        else:
            loop = []
            for j in range(len(self.pieces)):
                self._start()
                self._zero(j)
                head = f"define internal void @{self.name}.z{j}(double %t, {shared}) nounwind noinline {{"
                result.append("\n".join([head, *self.lines, "  ret void", "}", ""]))
                main.append(f"  call void @{self.name}.z{j}(double %t, {names(shared)})")
                self._start()
                self._order(j)
                head = f"define internal void @{self.name}.k{j}({orders}) nounwind noinline {{"
                result.append("\n".join([head, *_REST, *_LANE, *self.lines, "  ret void", "}", ""]))
                loop.append(f"  call void @{self.name}.k{j}({names(orders)})")
            main += self._around(1, ORDER, [], loop)
        return "\n".join([*result, *main, "  ret void", "}", ""])

    def _around(self, first: int, end: int, phis: list[str], loop: list[str]) -> list[str]:
        """A loop over orders."""
        t = self.tag
        return [
            f"  br label %enter{t}",
            f"enter{t}:",
            f"  br label %loop{t}",
            f"loop{t}:",
            f"  %k{t} = phi i64 [ {first}, %enter{t} ], [ %k1{t}, %loop{t} ]",
            *phis,
            f"  %k1{t} = add i64 %k{t}, 1",
            f"  %x{t} = sitofp i64 %k{t} to double",
            f"  %here{t} = getelementptr double, ptr @jet.inverse, i64 %k{t}",
            f"  %by{t} = load double, ptr %here{t}, align 8",
            f"  %there{t} = getelementptr double, ptr %here{t}, i64 1",
            f"  %next{t} = load double, ptr %there{t}, align 8",
            f"  %row{t} = mul i64 %k{t}, {self.stride}",
            f"  %from{t} = getelementptr double, ptr %out, i64 %row{t}",
            f"  %to{t} = getelementptr double, ptr %from{t}, i64 {self.stride}",
            *loop,
            f"  %more{t} = icmp slt i64 %k1{t}, {end}",
            f"  br i1 %more{t}, label %loop{t}, label %done{t}",
            f"done{t}:",
        ]

    def _start(self) -> None:
        self.lines = []
        self.values: dict[int, str] = {}
        self.held: dict[int, str] = {}
        self.rows: dict[int, str] = {}
        self.numbers: dict[Number, str] = dict(self.combined)
        self.sines: dict[int | Number, tuple[str, str]] = {}
        self.spreads: dict[str, str] = {}
        self.full: set[int] = set()
        self.following: list[str] = []

    def _stretch(
        self, first: int, end: int, grows: bool, states: list[str], held: dict[int, str]
    ) -> tuple[list[str], tuple[list[str], dict[int, str]]]:
        """The loop over a stretch of orders, in registers, from what goes into it: states and vectors; and what comes
        out."""
        self._start()
        self.grows, self.tag = grows, "" if grows else ".late"
        t = self.tag
        self.states = [f"%y{place}{t}" for place in range(len(states))]
        self.held = {i: f"%h{i}" for i in held} if grows else held
        renewed = {i: f"%h{i}.new" for i in held}
        self._order(0)

        def phi(name: str, T: str, first: str, later: str) -> str:
            return f"  {name} = phi {T} [ {first}, %enter{t} ], [ {later}, %loop{t} ]"

        phis = [phi(f"%y{k}{t}", "double", x, self.following[k]) for k, x in enumerate(states)]
        phis += [phi(f"%h{i}", _V, x, renewed[i]) for i, x in held.items() if grows]
        loop = [*(_LANE if grows else ()), *self.lines]
        return self._around(first, end, phis, loop), (self.following, renewed)

    def _pointer(self, base: str, place: int, T: str) -> str:
        return base if place == 0 else self._new(f"getelementptr {T}, ptr {base}, i64 {place}")

    def _load(self, base: str, place: int, T: str = "double") -> str:
        align = 8 if T == "double" else 64
        return self._new(f"load {T}, ptr {self._pointer(base, place, T)}, align {align}")

    def _store(self, value: str, base: str, place: int, T: str = "double") -> None:
        align = 8 if T == "double" else 64
        self.lines.append(f"  store {T} {value}, ptr {self._pointer(base, place, T)}, align {align}")

    def _number(self, x: Number) -> str:
        if x not in self.numbers and x.parts:
            total: str | None = None
            for known, factors in x.parts:
                product = literal(known)
                for factor in factors:
                    product = self._arithmetic("fmul", product, self._number(factor))
                total = self._signed(total, 1, product)
            assert total is not None
            self.numbers[x] = total
        elif x not in self.numbers:
            value = literal(x.value) if x.value is not None else self._load("%c", x.place)
            if x.function == "square":
                value = self._arithmetic("fmul", value, value)
            elif x.function:
                value = self._new(
                    f"call double {self.module.need_function(x.function, 1, 1)}(double {value})"
                )
            self.numbers[x] = value
        return self.numbers[x]

    def _value(self, x: int | Number) -> str:
        """The coefficient at this order; of a number, that at order 0."""
        if isinstance(x, Number):
            return self._number(x)
        if x not in self.values:  # of another piece, or needed for values at the start only
            self.values[x] = self._load("%slots", self.slots[x]) if x in self.slots else self._first(x)
        return self.values[x]

    def _mine(self, j: int) -> list[tuple[int, int | Number]]:
        """Outputs, with their places, that piece ``j`` writes."""
        return [
            (k, x) for k, x in enumerate(self.outputs) if (self.owner[x] if isinstance(x, int) else 0) == j
        ]

    # -- order 0 ------------------------------------------------------------------------------

    def _zero(self, j: int) -> None:
        """Values of a piece, and its vectors as they are before order 1."""
        for i in self.pieces[j]:
            value = self.values[i] = self._first(i)
            if i in self.vectors:
                self.held[i] = self._new(f"insertelement {_V} zeroinitializer, double {value}, i32 0")
                if not self.single:
                    self._store(self.held[i], "%frame", self.vectors[i], _V)
            if i in self.sums:
                self._keep(i, "zeroinitializer")
            if i in self.slots:
                self._store(value, "%slots", self.slots[i])
        for place, x in self._mine(j):
            self._store(self._load("%y", place), "%out", place)
            self._store(self._value(x), "%out", self.stride + place)

    def _first(self, i: int) -> str:
        """The value of node ``i`` at the start."""
        node = self.nodes[i]
        match node.rule:
            case "state":
                return self._load("%y", node.place)
            case "time":
                return "%t"
            case "sum":
                total: str | None = None
                for sign, x in node.terms:
                    if x not in self.zero:
                        total = self._signed(total, sign, self._value(x))
                for sign, a, b in node.products:
                    if a not in self.zero and b not in self.zero:
                        product = self._arithmetic("fmul", self._value(a), self._value(b))
                        total = self._signed(total, sign, product)
                return literal(0.0) if total is None else total
            case "scaled":
                return self._arithmetic("fmul", self._value(node.operand), self._number(node.number))
            case "quotient":
                divisor = self._value(node.operand)
                inverse = self._arithmetic("fdiv", literal(1.0), divisor)
                self._store(inverse, "%slots", self.divisors[i])
                above = node.arguments[0]
                return inverse if above == ONE else self._arithmetic("fdiv", self._value(above), divisor)
            case "root":
                function = self.module.need_intrinsic("sqrt", 1, 1)
                value = self._new(f"call double {function}(double {self._value(node.operand)})")
                self._store(self._arithmetic("fdiv", literal(0.5), value), "%slots", self.divisors[i])
                return value
            case "moment":
                return literal(0.0)
        if node.rule == "integral" and node.place >= 0:
            return self._value(node.place)
        if node.function in ("sin", "cos"):
            return self._load(self._sine_and_cosine(node.arguments[0])[node.function == "cos"], 0)
        arguments = ", ".join(f"double {self._value(x)}" for x in node.arguments)
        function = self.module.need_function(node.function, 1, len(node.arguments))
        return self._new(f"call double {function}({arguments})")

    def _sine_and_cosine(self, x: int | Number) -> tuple[str, str]:
        """Where they are."""
        if x not in self.sines:
            value, s, c = self._value(x), self._new("alloca double"), self._new("alloca double")
            self.lines.append(f"  call void {self.module.need_sincos(1)}(double {value}, ptr {s}, ptr {c})")
            self.sines[x] = (s, c)
        return self.sines[x]

    # -- order k ------------------------------------------------------------------------------

    def _order(self, j: int) -> None:
        """Coefficients of a piece at order k, and what follows from them for later orders."""
        for i in self.pieces[j]:
            if i in self.sums:
                turned = f"shufflevector {_V} {self._kept(i)}, {_V} poison, <{LANES} x i32> {_TURN}"
                self.rows[i] = self._new(f"select {_B} %rest, {_V} {self._new(turned)}, {_V} zeroinitializer")
                if i not in self.given:
                    self.rows[i] = self._added(self.rows[i], self._early(i))
                if self.ends[i] != j:
                    self._keep(i, self.rows[i])
            value = self.values[i] = self._later(i)
            if i in self.vectors:
                old = self.held[i] if self.single else self._load("%frame", self.vectors[i], _V)
                if self.grows:
                    new = f"%h{i}.new"
                    spread = self._spread(value)
                    self.lines.append(f"  {new} = select {_B} %lane, {_V} {spread}, {_V} {old}")
                    if not self.single:
                        self._store(new, "%frame", self.vectors[i], _V)
                    else:
                        self.held[i] = new
                        self.full.add(i)
            if i in self.slots:
                self._store(value, "%slots", self.slots[i])
            for other in self.after.get(i, ()):
                self._add_products(other)
        for place, x in self._mine(j):
            value = self._integrated(x)
            self._store(value, f"%to{self.tag}", place)
            self.following.append(value)

    def _integrated(self, x: int | Number) -> str:
        """Of a rate, the next coefficient of what changes at it."""
        if isinstance(x, Number):
            return literal(0.0)
        node = self.nodes[x]
        if node.rule != "scaled" or node.operand not in self.values:
            return self._arithmetic("fmul", self._value(x), f"%next{self.tag}")
        factor = self._arithmetic(
            "fmul", self._number(node.number), f"%next{self.tag}"
        )  # can be made in advance
        return self._arithmetic("fmul", self._value(node.operand), factor)

    def _spread(self, value: str) -> str:
        """A number in every lane."""
        if value not in self.spreads:
            one = self._new(f"insertelement {_V} poison, double {value}, i32 0")
            spread = f"shufflevector {_V} {one}, {_V} poison, <{LANES} x i32> zeroinitializer"
            self.spreads[value] = self._new(spread)
        return self.spreads[value]

    def _added(self, total: str, products: list[tuple[int, int, int, bool]]) -> str:
        """A vector of sums with products added."""
        fma = self.module.need_intrinsic("fmuladd", LANES, 3)
        for sign, a, b, newest in products:
            x = self._spread(self._value(a))
            y = self.held[b] if self.single else self._load("%frame", self.vectors[b], _V)
            if sign < 0:
                x = self._new(f"fneg {_V} {x}")
            added = self._new(f"call {_V} {fma}({_V} {x}, {_V} {y}, {_V} {total})")
            if not newest and (b in self.full or not self.single):  # b_k is there, or may be
                added = self._new(f"select {_B} %below, {_V} {added}, {_V} {total}")
            total = added
        return total

    def _add_products(self, i: int) -> None:
        """Products that are known now to the sums of node ``i``, which an order later move on by one."""
        total = self.rows[i] if i in self.rows else self._kept(i)
        self._keep(i, self._added(total, [*(self._early(i) if i in self.given else ()), *self._late(i)]))

    def _kept(self, i: int) -> str:
        """The sums of node ``i``."""
        return self._load("%frame", self.sums[i], _V)

    def _keep(self, i: int, total: str) -> None:
        self._store(total, "%frame", self.sums[i], _V)

    def _at_start(self, i: int) -> str:
        """The value of a node at order 0."""
        if self.single:
            return self._new(f"extractelement {_V} {self.held[i]}, i32 0")
        return self._new(f"load double, ptr {self._pointer('%frame', self.vectors[i], _V)}, align 64")

    def _later(self, i: int) -> str:
        """The coefficient of node ``i`` at order k."""
        node = self.nodes[i]
        known = self._new(f"extractelement {_V} {self.rows[i]}, i32 0") if i in self.sums else None
        match node.rule:
            case "state":
                return self.states[node.place] if self.single else self._load("%from", node.place)
            case "time":
                first = self._new(f"icmp eq i64 %k{self.tag}, 1")
                return self._new(f"select i1 {first}, double {literal(1.0)}, double {literal(0.0)}")
            case "sum":
                return self._sum(i, known)
            case "scaled":
                return self._arithmetic("fmul", self._value(node.operand), self._number(node.number))
            case "quotient":
                assert known is not None
                return self._divided(i, node.arguments[0], known)
            case "root":
                assert known is not None
                return self._divided(i, node.operand, known)
            case "integral" if i in self.direct:
                sign, _, other = self.nodes[node.operand].products[0]
                row = self.rows.get(node.operand) or self._kept(node.operand)
                known = self._arithmetic(
                    "fmul", self._new(f"extractelement {_V} {row}, i32 0"), f"%by{self.tag}"
                )
                part = self._arithmetic("fmul", self._value(self.direct[i]), self._at_start(other))
                return self._signed(known, sign, part)
            case "moment":
                return self._arithmetic("fmul", self._value(node.operand), f"%x{self.tag}")
        return self._arithmetic("fmul", self._value(node.operand), f"%by{self.tag}")

    def _sum(self, i: int, known: str | None) -> str:
        """The coefficient of a sum, of whose products ``known`` is known; in two parts where one takes longer."""
        parts = [(*self._unscaled(x), sign) for sign, x in self.nodes[i].terms if isinstance(x, int)]
        parts.sort(key=lambda part: self.ready[part[0]])
        waits = [self.ready[part[0]] for part in parts]
        totals = [known, *[None] * (min((1, 2), key=lambda chains: _end(waits, chains)) - 1)]
        times = [0] * len(totals)
        for x, number, sign in parts:
            j = times.index(min(times))
            times[j] = max(times[j], self.ready[x]) + 4
            part = self._value(x)
            if number != ONE:
                part = self._arithmetic("fmul", part, self._number(number))
            totals[j] = self._signed(totals[j], sign, part)
        found = [total for total in totals if total is not None]
        if not found:
            return literal(0.0)
        return found[0] if len(found) == 1 else self._arithmetic("fadd", *found)

    def _divided(self, i: int, above: int | Number, known: str) -> str:
        """(above - known) / divisor, where ``above`` comes last."""
        inverse = self._load("%slots", self.divisors[i])
        known = self._arithmetic("fmul", known, inverse)
        if isinstance(above, Number):
            return self._signed(None, -1, known)
        return self._signed(self._arithmetic("fmul", self._value(above), inverse), -1, known)


def _end(waits: list[int], chains: int) -> int:
    """When a sum is there whose terms come at these times, and which is added up in so many parts."""
    times = [0] * chains
    for wait in waits:
        j = times.index(min(times))
        times[j] = max(times[j], wait) + 4
    return max(times) + 4 * (chains - 1)


def cut(order: list[int], piece: int) -> list[list[int]]:
    """A long recurrence in pieces of about so many nodes."""
    count = -(-len(order) // piece) if len(order) > 2 * piece else 1
    size = -(-len(order) // count) if order else 1
    return [order[j * size : (j + 1) * size] for j in range(count)]


def names(arguments: str) -> str:
    """A list of parameters as arguments of a call."""
    return arguments.replace("noalias ", "")
