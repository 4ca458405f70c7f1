"""Taylor coefficients of the solution of y' = f(t, y, c), as LLVM IR.

    y(t + τ) = Σ_k y_k τᵏ,    (k + 1) y_(k+1) = f_k

The sums of the recurrences (`recurrence`) are computed in advance and in vectors. As soon as a_k and b_k are known,
they are multiplied by all former coefficients, which adds to the sums of the orders k to 2k:

    (s_k, s_(k+1), ...) += a_k (b_0, b_1, ... b_k) + b_k (a_0, ... a_(k-1), 0)

The first entry is then complete and is shifted out. So nothing is summed across a vector, and an order waits only for
the two products with a_0 and b_0. Vectors hold half of the p coefficients, which suffices: of two indices with
i + j < p, the smaller is below p/2.

The sums stay in memory, since registers are too few; the code of an order reads and writes each once. A short
recurrence is a loop whose other vectors stay in registers or, if these do not suffice, on the stack. This loop is
written twice: the vectors are complete at order p/2 and are only read from there on. A long recurrence is cut into
pieces and keeps its vectors in memory too.

The file is longer than others: the order of the text follows from what is known at each point, for all rules together.

Source: J. van der Hoeven, Relax, but don't be too lazy (2002): products in advance.
"""

from __future__ import annotations

from ...native.records import WIDTH as LANES
from ..code.emit import Module
from ..code.ir_text import literal
from ..code.lower import Program
from .combining import combined
from .recurrence import ONE, Number, Product, Recurrence
from .rewriting import shortened
from .writer import INVERSES, ORDER, PIECE, SeriesWriter, arguments_of, cut

STRETCHES = (1, LANES, True), (LANES, ORDER, False)
"""First order, end, and whether the coefficients are stored in the vectors."""

_V, _B = f"<{LANES} x double>", f"<{LANES} x i1>"
_TURN = "<" + ", ".join(f"i32 {(k + 1) % LANES}" for k in range(LANES)) + ">"
_PLACES = "<" + ", ".join(f"i64 {k}" for k in range(LANES)) + ">"
_LANE = (
    f"  %k0 = insertelement <{LANES} x i64> poison, i64 %k, i32 0",
    f"  %kk = shufflevector <{LANES} x i64> %k0, <{LANES} x i64> poison, <{LANES} x i32> zeroinitializer",
    f"  %lane = icmp eq <{LANES} x i64> %kk, {_PLACES}",
    f"  %below = icmp ugt <{LANES} x i64> %kk, {_PLACES}",
)
"""Masks of the k-th lane and of the lanes before it."""
_REST = (
    "  %last = load i64, ptr @jet.last",
    f"  %last0 = insertelement <{LANES} x i64> poison, i64 %last, i32 0",
    f"  %lasts = shufflevector <{LANES} x i64> %last0, <{LANES} x i64> poison, <{LANES} x i32> zeroinitializer",
    f"  %rest = icmp ugt <{LANES} x i64> %lasts, {_PLACES}",
)
"""Mask of all lanes but the last, loaded at run time: for a constant mask LLVM shifts by two instructions, not one."""
LAST = f"@jet.last = internal global i64 {LANES - 1}"


def jet(module: Module, program: Program, body: str, name: str, stride: int, piece: int = PIECE) -> None:
    """Add the function ``name`` with a kernel's signature, which writes the rows y_0 ... y_p.

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
        Number of nodes in one piece of a long recurrence.

    Raises
    ------
    ExpressionError
        For a function with a kink or a jump.
    """
    recurrence = shortened(Recurrence(program, body))
    if len(cut(recurrence.order, piece)) == 1:
        combined(recurrence)
    module.functions.append(_Writer(module, recurrence, name, stride, piece).text())


class _Writer(SeriesWriter):
    """Writer of the function that fills the coefficients of one motion."""

    def __init__(self, module: Module, recurrence: Recurrence, name: str, stride: int, piece: int) -> None:
        super().__init__(module, recurrence, name, piece, lanes=1)
        self.stride = stride
        order = recurrence.order
        self.single = len(self.pieces) == 1
        self.pairs = {i: self._pairs(i) for i in order}
        self.sums = {i: j for j, i in enumerate(i for i in order if self.pairs[i])}
        factors = dict.fromkeys(x for p in self.pairs.values() for _, *ab in p for x in ab)
        self.vectors = {i: len(self.sums) + j for j, i in enumerate(factors)}
        self.direct = {i: x for i in order if (x := self._directly(i)) >= 0}
        self.direct_rates = {self.nodes[i].operand for i in self.direct}
        self.complete_after = self._complete_after(order)
        self.ends = {i: self.owner[j] for j, nodes in self.complete_after.items() for i in nodes}
        self.ready = self._ready(order)
        self.divisors = {
            i: j for j, i in enumerate(i for i in order if self.nodes[i].rule in ("quotient", "root"))
        }
        self.slots = self._crossing()
        self.combined: dict[object, str] = {}  # numbers computed before the loops
        self.tag, self.grows = "", True
        self._start()

    # -- dependences --------------------------------------------------------------------------

    def _pairs(self, i: int) -> list[Product]:
        """Products whose sums node ``i`` needs, with their signs."""
        node = self.nodes[i]
        if node.rule == "quotient":
            return [(1, node.operand, i)]
        if node.rule == "root":
            return [(1, i, i)]
        return list(node.products)

    def _directly(self, i: int) -> int:
        """Return x if node ``i`` is y with ϑy = ± g ϑx, else -1. Then y_k = ± g_0 x_k + (the rest of the sum) / k."""
        node = self.nodes[i]
        if node.rule == "integral":
            rate = self.nodes[node.operand]
            if rate.rule == "sum" and not rate.terms and len(rate.products) == 1:
                moment = self.nodes[rate.products[0][1]]
                return moment.operand if moment.rule == "moment" else -1
        return -1

    def _operands(self, i: int) -> list[int]:
        """Nodes whose k-th coefficient is needed for the k-th coefficient of node ``i``."""
        node = self.nodes[i]
        operands = [self._unscaled(x)[0] for _, x in node.terms if isinstance(x, int)]
        for _, a, b in node.products:  # (ϑx b)_k does not need b_k
            operands += [self._unscaled(x)[0] for x, other in ((a, b), (b, a)) if other not in self.zero]
        if node.operand >= 0:
            operands.append(node.operand)
        if node.rule == "quotient" and isinstance(node.arguments[0], int):
            operands.append(node.arguments[0])
        return operands

    def _complete_after(self, order: list[int]) -> dict[int, list[int]]:
        """Map each node to the nodes whose products can be added after it."""
        place = {i: j for j, i in enumerate(order)}
        reader = {self.nodes[i].operand: i for i in self.direct}
        result: dict[int, list[int]] = {}
        for i in order:
            if self.pairs[i]:
                last = max(place[x] for x in (reader.get(i, i), *(x for _, *ab in self.pairs[i] for x in ab)))
                result.setdefault(order[last], []).append(i)
        return result

    def _halves(self, i: int) -> list[Product]:
        """(sign, a, b) of the products a_k b_0 that the products of a sum still need at order k, from both sides."""
        return [
            (sign, x, y)
            for sign, a, b in self.nodes[i].products
            for x, y in ((a, b), (b, a))
            if y not in self.zero
        ]

    def _unscaled(self, x: int) -> tuple[int, Number]:
        """A series and a number whose product is x. A factor in a product need not wait for its own multiplication."""
        node = self.nodes[x]
        return (node.operand, node.number) if node.rule == "scaled" else (x, ONE)

    def _ready(self, order: list[int]) -> dict[int, int]:
        """Time at which the value of each node is ready, in cycles from the start of an order, 4 for an operation."""
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
        """Slots of the values that other pieces read."""
        slots: dict[int, int] = {}
        for i, j in self.owner.items():
            needed = self._operands(i) + [x for x in self.nodes[i].arguments if isinstance(x, int)]
            needed += [x for _, x in self.nodes[i].terms if isinstance(x, int)]
            needed += [x for _, *ab in self.nodes[i].products for x in ab]
            needed += [self.direct[i]] if i in self.direct else []
            needed += [
                x for other in self.complete_after.get(i, ()) for _, *ab in self.pairs[other] for x in ab
            ]
            for x in needed:
                if self.owner[x] != j:
                    slots.setdefault(x, len(self.divisors) + len(slots))
        return slots

    def _early(self, i: int) -> list[tuple[int, int, int, bool]]:
        """(sign, a, b, whether b_k is included) of the products a_k (b_0, ...) that complete node ``i``'s k-th sum."""
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
        return sorted(result, key=lambda product: self.ready[product[1]])

    def _late(self, i: int) -> list[tuple[int, int, int, bool]]:
        """The other products of node ``i``, which later sums need, in the form of `_early`."""
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
        frame = len(self.sums) + (0 if self.single else len(self.vectors))
        main = [
            f"define void @{self.name}(double %t, ptr noalias %y, ptr noalias %c, ptr noalias %out) nounwind {{",
            f"  %frame = alloca {_V}, i64 {max(1, frame)}, align 64",
            f"  %slots = alloca double, i64 {max(1, len(self.divisors) + len(self.slots))}, align 64",
        ]
        self.module.helpers |= {"@jet.inverse": INVERSES, "@jet.last": LAST}
        if self.single:
            self._zero(0)
            for i in self.owner:
                if self.nodes[i].number.parts:
                    self._number(self.nodes[i].number)
            self.combined = {
                x: value for x, value in self.numbers.items() if isinstance(x, Number) and x.parts
            }
            main += [*_REST, *self.lines]
            last = [self._value(x) for x in self.outputs], self.vector_values
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
                main.append(f"  call void @{self.name}.z{j}(double %t, {arguments_of(shared)})")
                self._start()
                self._order(j)
                head = f"define internal void @{self.name}.k{j}({orders}) nounwind noinline {{"
                result.append("\n".join([head, *_REST, *_LANE, *self.lines, "  ret void", "}", ""]))
                loop.append(f"  call void @{self.name}.k{j}({arguments_of(orders)})")
            main += self._around(1, ORDER, [], loop)
        return "\n".join([*result, *main, "  ret void", "}", ""])

    def _around(self, first: int, end: int, phis: list[str], loop: list[str]) -> list[str]:
        """Write a loop over orders around these lines."""
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
        """Begin a new function or loop: no value is known in it yet."""
        self.lines = []
        self.values = {}
        self.numbers = dict(self.combined)
        self.sines = {}
        self.vector_values: dict[int, str] = {}
        self.shifted_sums: dict[int, str] = {}
        self.spreads: dict[str, str] = {}
        self.updated: set[int] = set()  # nodes whose vectors contain the k-th coefficient already
        self.next_states: list[str] = []

    def _stretch(
        self, first: int, end: int, grows: bool, states: list[str], vectors: dict[int, str]
    ) -> tuple[list[str], tuple[list[str], dict[int, str]]]:
        """Write the loop over a stretch of orders, in registers.

        It takes states and vectors, and returns its lines and the new states and vectors.
        """
        self._start()
        self.grows, self.tag = grows, "" if grows else ".late"
        t = self.tag
        self.states = [f"%y{place}{t}" for place in range(len(states))]
        self.vector_values = {i: f"%h{i}" for i in vectors} if grows else vectors
        new_vectors = {i: f"%h{i}.new" for i in vectors}
        self._order(0)

        def phi(name: str, T: str, first: str, later: str) -> str:
            return f"  {name} = phi {T} [ {first}, %enter{t} ], [ {later}, %loop{t} ]"

        phis = [phi(f"%y{k}{t}", "double", x, self.next_states[k]) for k, x in enumerate(states)]
        phis += [phi(f"%h{i}", _V, x, new_vectors[i]) for i, x in vectors.items() if grows]
        loop = [*(_LANE if grows else ()), *self.lines]
        return self._around(first, end, phis, loop), (self.next_states, new_vectors)

    def _value(self, x: int | Number) -> str:
        if isinstance(x, Number):
            return self._number(x)
        if x not in self.values:  # from another piece, or needed for values at order 0 only
            self.values[x] = self._load("%slots", self.slots[x]) if x in self.slots else self._first(x)
        return self.values[x]

    def _outputs_of(self, j: int) -> list[tuple[int, int | Number]]:
        """Outputs that piece ``j`` writes, with their places."""
        return [
            (k, x) for k, x in enumerate(self.outputs) if (self.owner[x] if isinstance(x, int) else 0) == j
        ]

    # -- order 0 ------------------------------------------------------------------------------

    def _zero(self, j: int) -> None:
        """Write the values of a piece at order 0, and its vectors before order 1."""
        for i in self.pieces[j]:
            value = self.values[i] = self._first(i)
            if i in self.vectors:
                vector = self._new(f"insertelement {_V} zeroinitializer, double {value}, i32 0")
                self.vector_values[i] = vector
                if not self.single:
                    self._store(vector, "%frame", self.vectors[i], _V)
            if i in self.sums:
                self._store_sums(i, "zeroinitializer")
            if i in self.slots:
                self._store(value, "%slots", self.slots[i])
        for place, x in self._outputs_of(j):
            self._store(self._load("%y", place), "%out", place)
            self._store(self._value(x), "%out", self.stride + place)

    def _first(self, i: int) -> str:
        """The value of node ``i`` at order 0."""
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
                value = self._called(self.module.need_intrinsic("sqrt", 1, 1), [self._value(node.operand)])
                self._store(self._arithmetic("fdiv", literal(0.5), value), "%slots", self.divisors[i])
                return value
            case "moment":
                return literal(0.0)
        if node.rule == "integral" and node.place >= 0:
            return self._value(node.place)
        return self._function_at_start(node)

    # -- order k ------------------------------------------------------------------------------

    def _order(self, j: int) -> None:
        """Write the coefficients of a piece at order k, and their products for later orders."""
        for i in self.pieces[j]:
            if i in self.sums:
                turned = self._new(
                    f"shufflevector {_V} {self._load_sums(i)}, {_V} poison, <{LANES} x i32> {_TURN}"
                )
                shifted = self._new(f"select {_B} %rest, {_V} {turned}, {_V} zeroinitializer")
                if i not in self.direct_rates:
                    shifted = self._added(shifted, self._early(i))
                self.shifted_sums[i] = shifted
                if self.ends[i] != j:
                    self._store_sums(i, shifted)
            value = self.values[i] = self._later(i)
            if i in self.vectors:
                old = self.vector_values[i] if self.single else self._load("%frame", self.vectors[i], _V)
                if self.grows:
                    new = f"%h{i}.new"
                    spread = self._spread(value)
                    self.lines.append(f"  {new} = select {_B} %lane, {_V} {spread}, {_V} {old}")
                    if not self.single:
                        self._store(new, "%frame", self.vectors[i], _V)
                    else:
                        self.vector_values[i] = new
                        self.updated.add(i)
            if i in self.slots:
                self._store(value, "%slots", self.slots[i])
            for other in self.complete_after.get(i, ()):
                self._add_products(other)
        for place, x in self._outputs_of(j):
            value = self._integrated(x)
            self._store(value, f"%to{self.tag}", place)
            self.next_states.append(value)

    def _integrated(self, x: int | Number) -> str:
        """The next coefficient of the state whose rate is x."""
        if isinstance(x, Number):
            return literal(0.0)
        node = self.nodes[x]
        if node.rule != "scaled" or node.operand not in self.values:
            return self._arithmetic("fmul", self._value(x), f"%next{self.tag}")
        # this factor does not wait for the coefficient
        factor = self._arithmetic("fmul", self._number(node.number), f"%next{self.tag}")
        return self._arithmetic("fmul", self._value(node.operand), factor)

    def _spread(self, value: str) -> str:
        """Vector with a number in every lane."""
        if value not in self.spreads:
            first = self._new(f"insertelement {_V} poison, double {value}, i32 0")
            spread = f"shufflevector {_V} {first}, {_V} poison, <{LANES} x i32> zeroinitializer"
            self.spreads[value] = self._new(spread)
        return self.spreads[value]

    def _added(self, total: str, products: list[tuple[int, int, int, bool]]) -> str:
        """Add products to a vector of sums."""
        fma = self.module.need_intrinsic("fmuladd", LANES, 3)
        for sign, a, b, newest in products:
            x = self._spread(self._value(a))
            y = self.vector_values[b] if self.single else self._load("%frame", self.vectors[b], _V)
            if sign < 0:
                x = self._new(f"fneg {_V} {x}")
            added = self._new(f"call {_V} {fma}({_V} {x}, {_V} {y}, {_V} {total})")
            if not newest and (b in self.updated or not self.single):  # the vector has b_k, or may have it
                added = self._new(f"select {_B} %below, {_V} {added}, {_V} {total}")
            total = added
        return total

    def _add_products(self, i: int) -> None:
        """Add the products that are now known to the sums of node ``i``, for later orders."""
        total = self.shifted_sums[i] if i in self.shifted_sums else self._load_sums(i)
        products = [*(self._early(i) if i in self.direct_rates else ()), *self._late(i)]
        self._store_sums(i, self._added(total, products))

    def _load_sums(self, i: int) -> str:
        return self._load("%frame", self.sums[i], _V)

    def _store_sums(self, i: int, total: str) -> None:
        self._store(total, "%frame", self.sums[i], _V)

    def _at_start(self, i: int) -> str:
        """The value of a node at order 0."""
        if self.single:
            return self._new(f"extractelement {_V} {self.vector_values[i]}, i32 0")
        return self._new(f"load double, ptr {self._pointer('%frame', self.vectors[i], _V)}, align 64")

    def _later(self, i: int) -> str:
        """The coefficient of node ``i`` at order k."""
        node = self.nodes[i]
        partial = None
        if i in self.sums:
            partial = self._new(f"extractelement {_V} {self.shifted_sums[i]}, i32 0")
        match node.rule:
            case "state":
                return self.states[node.place] if self.single else self._load("%from", node.place)
            case "time":
                first = self._new(f"icmp eq i64 %k{self.tag}, 1")
                return self._new(f"select i1 {first}, double {literal(1.0)}, double {literal(0.0)}")
            case "sum":
                return self._sum(i, partial)
            case "scaled":
                return self._arithmetic("fmul", self._value(node.operand), self._number(node.number))
            case "quotient":
                assert partial is not None
                return self._divided(i, node.arguments[0], partial)
            case "root":
                assert partial is not None
                return self._divided(i, node.operand, partial)
            case "integral" if i in self.direct:
                sign, _, other = self.nodes[node.operand].products[0]
                sums = self.shifted_sums.get(node.operand) or self._load_sums(node.operand)
                rest = self._new(f"extractelement {_V} {sums}, i32 0")
                rest = self._arithmetic("fmul", rest, f"%by{self.tag}")
                part = self._arithmetic("fmul", self._value(self.direct[i]), self._at_start(other))
                return self._signed(rest, sign, part)
            case "moment":
                return self._arithmetic("fmul", self._value(node.operand), f"%x{self.tag}")
        return self._arithmetic("fmul", self._value(node.operand), f"%by{self.tag}")

    def _sum(self, i: int, partial: str | None) -> str:
        """The coefficient of a sum whose products add up to ``partial``; in two chains where one takes longer."""
        parts = [(*self._unscaled(x), sign) for sign, x in self.nodes[i].terms if isinstance(x, int)]
        parts.sort(key=lambda part: self.ready[part[0]])
        waits = [self.ready[part[0]] for part in parts]
        totals = [partial, *[None] * (min((1, 2), key=lambda chains: _end(waits, chains)) - 1)]
        times = [0] * len(totals)
        for x, number, sign in parts:
            j = times.index(min(times))
            times[j] = max(times[j], self.ready[x]) + 4
            part = self._value(x)
            if number != ONE:
                part = self._arithmetic("fmul", part, self._number(number))
            totals[j] = self._signed(totals[j], sign, part)
        sums = [total for total in totals if total is not None]
        if not sums:
            return literal(0.0)
        return sums[0] if len(sums) == 1 else self._arithmetic("fadd", *sums)

    def _divided(self, i: int, above: int | Number, partial: str) -> str:
        """(above - partial) / divisor, with ``above`` used last since it is ready last."""
        inverse = self._load("%slots", self.divisors[i])
        partial = self._arithmetic("fmul", partial, inverse)
        if isinstance(above, Number):
            return self._signed(None, -1, partial)
        return self._signed(self._arithmetic("fmul", self._value(above), inverse), -1, partial)


def _end(waits: list[int], chains: int) -> int:
    """Time at which a sum is ready, given the times of its terms and the number of chains of additions."""
    times = [0] * chains
    for wait in waits:
        j = times.index(min(times))
        times[j] = max(times[j], wait) + 4
    return max(times) + 4 * (chains - 1)
