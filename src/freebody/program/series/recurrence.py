"""Rates as recurrences for Taylor coefficients.

The k-th coefficient f_k of the rates along the solution follows from y_0 ... y_k by a recurrence for each operation.
All are combinations of four (ϑ = τ d/dτ, so that (ϑx)_k = k x_k):

    products    p = Σ ± a b     p_k = Σ_i a_i b_(k-i)
    quotient    q = a / b       q_k = (a_k - Σ_(i<k) q_i b_(k-i)) / b_0
    root        r = √x          r_k = (x_k - Σ_(0<i<k) r_i r_(k-i)) / 2 r_0
    integral    ϑx = w          x_k = w_k / k

    e = exp x: ϑe = e ϑx    s = sin x, c = cos x: ϑs = c ϑx, ϑc = -s ϑx    l = log x: ϑl = ϑx / x    and so on.

Source: Griewank and Walther, Evaluating Derivatives (2008), section 13.2.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from ...errors import ExpressionError
from ...scalar.trace import ADD, DIV, INPUT, MUL, NAMES, NEG, SUB
from ..code.lower import FIXED, HOISTED, RECIPROCAL, TIME, VARYING, Program

Product: TypeAlias = tuple[int, int, int]
"""A sign and two nodes whose series are multiplied."""


class Number(NamedTuple):
    """A value independent of time: a literal, a place in c, a function of one, or a sum of products (`combining`)."""

    value: float | None = None
    place: int = -1
    function: str = ""
    parts: tuple[tuple[float, tuple[Number, ...]], ...] = ()


ONE = Number(1.0)


class Node(NamedTuple):
    """A series: its rule and the data of the rule.

    state     place in y
    time
    sum       signed terms (nodes or numbers) and signed products of nodes
    scaled    number, node
    quotient  node or number, node
    root      node
    moment    node x; the series is ϑx
    integral  node w with ϑx = w; x_0 as a function and its arguments, or as the place of a node with this value
    """

    rule: str
    place: int = -1
    terms: tuple[tuple[int, int | Number], ...] = ()
    products: tuple[tuple[int, int, int], ...] = ()
    number: Number = ONE
    operand: int = -1
    function: str = ""
    arguments: tuple[int | Number, ...] = ()


class Recurrence:
    """The series that the outputs of a body need, in the order of their computation.

    Attributes
    ----------
    nodes : list of Node
    order : list of int
        Nodes in the order of computation: the k-th coefficient of a node needs the coefficients 0 to k of the nodes
        before it, and those below k of the nodes after it.
    outputs : list of int or Number
    starts_at_zero : set of int
        Nodes whose coefficient at order 0 is zero.
    """

    def __init__(self, program: Program, name: str) -> None:
        self.program = program
        self.nodes: list[Node] = []
        self.order: list[int] = []
        self.starts_at_zero: set[int] = set()
        self._places: dict[object, int] = {}
        self._series_of: dict[int, int | Number] = {}
        body = program.bodies[name]
        self._uses: dict[int, int] = {}
        needed = self._needed(body.outputs)
        for i in needed:
            for x in (program.a[i], program.b[i]):
                self._uses[x] = self._uses.get(x, 0) + 1
        for i in body.outputs:
            self._uses[i] = self._uses.get(i, 0) + 1
        parts = {x for i in needed if program.op[i] in _LINEAR for x in self._absorbed(i)}
        for i in needed:
            if i not in parts:
                self._series_of[i] = self._series(i)
        self.outputs = [self._value(i) for i in body.outputs]
        self.forget()

    def _needed(self, outputs: list[int]) -> list[int]:
        """The varying nodes that the outputs need, operands first."""
        program = self.program
        needed: set[int] = set()
        stack = [i for i in outputs if program.kind[i] == VARYING]
        while stack:
            i = stack.pop()
            if i in needed or program.op[i] <= INPUT:
                continue
            needed.add(i)
            stack += [x for x in (program.a[i], program.b[i]) if x >= 0 and program.kind[x] == VARYING]
        return sorted(needed)

    def _absorbed(self, i: int) -> list[int]:
        """Operands of a sum that have no other use and become parts of it."""
        program = self.program
        return [
            x
            for x in (program.a[i], program.b[i])
            if x >= 0
            and self._uses.get(x) == 1
            and program.kind[x] == VARYING
            and (program.op[x] in _LINEAR or self._is_product(x))
        ]

    def forget(self) -> None:
        """Drop nodes that no output needs, such as products whose factor cancels."""
        needed: set[int] = set()
        stack = [x for x in self.outputs if isinstance(x, int)]
        while stack:
            i = stack.pop()
            if i in needed:
                continue
            needed.add(i)
            stack += self.used(i)
        self.order = [i for i in self.order if i in needed]

    def used(self, i: int) -> list[int]:
        """Series that node ``i`` uses, each as often as it is used."""
        node = self.nodes[i]
        operands = [node.operand, *node.arguments, *(x for _, x in node.terms)]
        operands += [x for _, *ab in node.products for x in ab]
        return [x for x in operands if isinstance(x, int) and x >= 0]

    def _is_product(self, i: int) -> bool:
        program = self.program
        return (
            program.op[i] == MUL
            and program.kind[program.a[i]] == VARYING
            and program.kind[program.b[i]] == VARYING
        )

    def _value(self, i: int) -> int | Number:
        """Series or number of node ``i`` of the program."""
        program = self.program
        if program.kind[i] == FIXED:
            return Number(program.constants[program.a[i]])
        if program.kind[i] == HOISTED:
            return Number(None, program.hoisted[i])
        if program.op[i] == INPUT:
            return self._once(Node("time") if program.a[i] == TIME else Node("state", program.a[i]))
        return self._series_of[i]

    def _add(self, node: Node) -> int:
        self.nodes.append(node)
        i = len(self.nodes) - 1
        zero = self.starts_at_zero
        if (
            node.rule == "moment"
            or (
                node.rule in ("scaled", "quotient")
                and (node.operand if node.rule == "scaled" else node.arguments[0]) in zero
            )
            or (
                node.rule == "sum"
                and all(x in zero for _, x in node.terms)
                and all(a in zero or b in zero for _, a, b in node.products)
            )
        ):
            zero.add(i)
        return i

    def _once(self, node: Node) -> int:
        """Add a node unless an equal one exists, and return its place."""
        if node not in self._places:
            self._places[node] = self._add(node)
            self.order.append(self._places[node])
        return self._places[node]

    # -- operations ---------------------------------------------------------------------------

    def _series(self, i: int) -> int | Number:
        program = self.program
        code, a, b = program.op[i], program.a[i], program.b[i]
        if code in _LINEAR:
            terms: list[tuple[int, int | Number]] = []
            products: list[Product] = []
            self._collect(i, 1, terms, products, True)
            if not terms and len(products) == 2 and (series := self._angle_sum(*products)) is not None:
                return series
            return self._once(Node("sum", terms=tuple(terms), products=tuple(products)))
        if code == MUL:
            return self.product(self._value(a), self._value(b))
        if code == DIV:
            return self.quotient(self._value(a), self._value(b))
        if code == RECIPROCAL:
            return self.quotient(ONE, self._value(a))
        rule = _FUNCTIONS.get(NAMES[code])
        if rule is None:
            raise ExpressionError(
                f"'{NAMES[code]}' has no Taylor series where it bends. Known: {', '.join(_FUNCTIONS)}."
            )
        return rule(self, *(self._value(x) for x in (a, b) if x >= 0))

    def _collect(
        self,
        i: int,
        sign: int,
        terms: list[tuple[int, int | Number]],
        products: list[Product],
        top: bool = False,
    ) -> None:
        """Collect the terms and products of a sum and of its parts."""
        program = self.program
        code = program.op[i]
        if not top and not (
            self._uses.get(i) == 1 and program.kind[i] == VARYING and (code in _LINEAR or self._is_product(i))
        ):
            terms.append((sign, self._value(i)))
            return
        if code == MUL:
            a, b = self._value(program.a[i]), self._value(program.b[i])
            assert isinstance(a, int) and isinstance(b, int)
            products.append((sign, a, b))
            return
        if code == NEG:
            self._collect(program.a[i], -sign, terms, products)
            return
        self._collect(program.a[i], sign, terms, products)
        self._collect(program.b[i], -sign if code == SUB else sign, terms, products)

    def _angle_sum(self, first: Product, second: Product) -> int | None:
        """Sine or cosine of x ± y, if two products are its expansion in sines and cosines of x and y; else None.

        The expansions take two products each, sine and cosine of an angle one. Those of x and y are dropped unless
        needed elsewhere. Only the values at order 0 are computed from the products.
        """
        parts: list[list[tuple[int, str]]] = []
        for _, *ab in (first, second):
            nodes = [self.nodes[i] for i in ab]
            if any(
                node.function not in ("sin", "cos") or not isinstance(node.arguments[0], int)
                for node in nodes
            ):
                return None
            parts.append(sorted((node.arguments[0], node.function) for node in nodes))  # type: ignore[misc]
        ((x, f), (y, g)), ((u, h), (v, k)) = parts
        if x == y or (x, y) != (u, v) or f == h or g == k:
            return None
        sign, other = first[0], second[0]
        if f == "sin" if f == g else f == "cos":  # begin with cos cos or sin cos
            sign, other = other, sign
        relative = sign * other if f != g else -sign * other
        sx, cx = (_sine_and_cosine(self, x, j) for j in (0, 1))
        sy, cy = (_sine_and_cosine(self, y, j) for j in (0, 1))
        starts = (
            self._once(Node("sum", products=((1, sx, cy), (relative, cx, sy)))),
            self._once(Node("sum", products=((1, cx, cy), (-relative, sx, sy)))),
        )
        series = _sine_and_cosine(self, self.sum((1, x), (relative, y)), f == g, starts)
        return series if sign > 0 else self.sum((-1, series))

    def product(self, a: int | Number, b: int | Number) -> int:
        """Series a b."""
        if isinstance(a, Number):
            a, b = b, a
        assert isinstance(a, int)
        if isinstance(b, Number):
            return self._once(Node("scaled", number=b, operand=a))
        return self._once(Node("sum", products=((1, a, b),)))

    def _factors(self, i: int) -> tuple[int, ...]:
        """The two factors of a node that is a product of series; empty for other nodes."""
        node = self.nodes[i]
        if node.rule != "sum" or node.terms or len(node.products) != 1:
            return ()
        return node.products[0][1:]

    def quotient(self, a: int | Number, b: int | Number) -> int:
        """Series a / b."""
        assert isinstance(b, int)  # a division by a number is a product in a lowered program
        if isinstance(a, int):
            above, below = self._factors(a), self._factors(b)
            for f in above:
                if f in below:  # (f x) / (f y)
                    x, y = (pair[1] if pair[0] == f else pair[0] for pair in (above, below))
                    quotient = self.quotient(x, y)
                    sign = self.nodes[a].products[0][0] * self.nodes[b].products[0][0]
                    return quotient if sign > 0 else self.sum((-1, quotient))
        return self._once(Node("quotient", arguments=(a,), operand=b))

    def sum(self, *terms: tuple[int, int | Number], products: tuple[Product, ...] = ()) -> int:
        """Series of a sum of signed terms and products."""
        return self._once(Node("sum", terms=terms, products=products))

    def root(self, x: int) -> int:
        """Series √x."""
        return self._once(Node("root", operand=x))

    def moment(self, x: int) -> int:
        """Series ϑx."""
        return self._once(Node("moment", operand=x))

    def integrals(
        self,
        key: object,
        starts: list[tuple[str, tuple[int | Number, ...]]],
        rates: Callable[[list[int]], list[int]],
        places: tuple[int, ...] = (),
    ) -> list[int]:
        """Series x with ϑx = w, where the rates w may depend on them; added once for each key.

        Their values at order 0 are the functions ``starts``, or those of the nodes ``places`` if there are any.
        """
        if (key, 0) not in self._places:
            new = []
            for j, (function, arguments) in enumerate(starts):
                place = places[j] if places else -1
                new.append(self._add(Node("integral", place, function=function, arguments=arguments)))
                self._places[(key, j)] = new[-1]
            for x, w in zip(new, rates(new), strict=True):
                self.nodes[x] = self.nodes[x]._replace(operand=w)
            self.order += new
        return [self._places[(key, j)] for j in range(len(starts))]


_LINEAR = frozenset((ADD, SUB, NEG))


def _sine_and_cosine(r: Recurrence, x: int, which: int, starts: tuple[int, ...] = ()) -> int:
    z = r.moment(x)
    return r.integrals(
        ("sin", x),
        [("sin", (x,)), ("cos", (x,))],
        lambda f: [r.sum(products=((1, z, f[1]),)), r.sum(products=((-1, z, f[0]),))],
        starts,
    )[which]


def _hyperbolic(r: Recurrence, x: int, which: int) -> int:
    z = r.moment(x)
    return r.integrals(
        ("sinh", x),
        [("sinh", (x,)), ("cosh", (x,))],
        lambda f: [r.sum(products=((1, z, f[1]),)), r.sum(products=((1, z, f[0]),))],
    )[which]


def _tangent(name: str, sign: int) -> Callable[[Recurrence, int], int]:
    """ϑf = (1 ± f²) ϑx."""

    def rule(r: Recurrence, x: int) -> int:
        z = r.moment(x)

        def rates(f: list[int]) -> list[int]:
            growth = r.sum((1, ONE), products=((sign, f[0], f[0]),))
            r.order.remove(growth)  # it must follow f, whose square it contains
            late.append(growth)
            return [r.sum(products=((1, z, growth),))]

        late: list[int] = []
        series = r.integrals((name, x), [(name, (x,))], rates)[0]
        r.order += late
        return series

    return rule


def _exponential(r: Recurrence, x: int) -> int:
    z = r.moment(x)
    return r.integrals(("exp", x), [("exp", (x,))], lambda f: [r.sum(products=((1, z, f[0]),))])[0]


def _logarithm(r: Recurrence, x: int) -> int:
    return r.integrals(("log", x), [("log", (x,))], lambda _: [r.quotient(r.moment(x), x)])[0]


def _arc(
    name: str, divisor: Callable[[Recurrence, int], int], sign: int = 1
) -> Callable[[Recurrence, int], int]:
    """ϑf = ± ϑx / divisor."""

    def rule(r: Recurrence, x: int) -> int:
        def rates(_: list[int]) -> list[int]:
            rate = r.quotient(r.moment(x), divisor(r, x))
            return [rate if sign > 0 else r.sum((-1, rate))]

        return r.integrals((name, x), [(name, (x,))], rates)[0]

    return rule


def _semicircle(r: Recurrence, x: int) -> int:
    return r.root(r.sum((1, ONE), products=((-1, x, x),)))


def _atan2(r: Recurrence, y: int | Number, x: int | Number) -> int:
    """ϑf = (x ϑy - y ϑx) / (x² + y²)."""

    def rates(_: list[int]) -> list[int]:
        terms: list[tuple[int, int | Number]] = []
        products: list[Product] = []
        squares: list[Product] = []
        constants: list[tuple[int, int | Number]] = []
        for sign, p, q in ((1, x, y), (-1, y, x)):  # ± p ϑq
            if isinstance(q, Number):
                constants.append((1, Number(q.value, q.place, "square")))
                continue
            squares.append((1, q, q))
            if isinstance(p, Number):
                terms.append((sign, r.product(r.moment(q), p)))
            else:
                products.append((sign, r.moment(q), p))
        above = r._once(Node("sum", terms=tuple(terms), products=tuple(products)))
        below = r._once(Node("sum", terms=tuple(constants), products=tuple(squares)))
        return [r.quotient(above, below)]

    return r.integrals(("atan2", y, x), [("atan2", (y, x))], rates)[0]


def _power(r: Recurrence, x: int | Number, n: int | Number) -> int:
    """ϑf = n f ϑx / x for a number n, else f = exp(n log x)."""
    key = ("pow", x, n)
    start: list[tuple[str, tuple[int | Number, ...]]] = [("pow", (x, n))]
    if isinstance(n, Number):
        assert isinstance(x, int)
        z = r.moment(x)
        return r.integrals(
            key, start, lambda f: [r.quotient(r.product(r.sum(products=((1, z, f[0]),)), n), x)]
        )[0]
    log = Number(x.value, x.place, "log") if isinstance(x, Number) else _logarithm(r, x)
    z = r.moment(r.product(log, n))
    return r.integrals(key, start, lambda f: [r.sum(products=((1, z, f[0]),))])[0]


_FUNCTIONS: dict[str, Callable[..., int]] = {
    "sin": lambda r, x: _sine_and_cosine(r, x, 0),
    "cos": lambda r, x: _sine_and_cosine(r, x, 1),
    "tan": _tangent("tan", 1),
    "tanh": _tangent("tanh", -1),
    "sinh": lambda r, x: _hyperbolic(r, x, 0),
    "cosh": lambda r, x: _hyperbolic(r, x, 1),
    "sqrt": lambda r, x: r.root(x),
    "exp": _exponential,
    "log": _logarithm,
    "atan": _arc("atan", lambda r, x: r.sum((1, ONE), products=((1, x, x),))),
    "asin": _arc("asin", _semicircle),
    "acos": _arc("acos", _semicircle, -1),
    "atan2": _atan2,
    "pow": _power,
}
