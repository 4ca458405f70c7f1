"""Formulas on rows, eight components at a time: a plain loop over a state would compute one after the other.

An assignment to a whole row, ``run.y_new[:] = run.y + h * combination(B, run.k)``, holds for each component. Rows stand
for their components and numbers for themselves; a product that is added to something is joined to the sum, with one
rounding if the processor has a fused multiply-add.

    combination(weights, k)         Σ_j weights[j] k[j], with constant weights by number of the row
    chain(weights, k)               the same, in a row that a kernel reads next (`Chain`)

In a loop over components, ``for i in components(run.n)``, ``row[i]`` is a vector, of this component and of the seven
after it, and so are the names that the body gives to numbers (`Components`). Names from before the loop collect the
greatest of the components, by `maximum` or `larger`, or their sum. Of lanes, a component is a vector already.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from llvmlite import ir

from .arithmetic import (
    REAL,
    WHOLE,
    Refusal,
    cast,
    element_of,
    kind_of,
    lanes_of,
    mathematical,
    operated,
    selected,
    splat,
    wide,
)
from .functions import instruction, unrolled
from .instructions import larger, maximum, where
from .record_access import length_of
from .records import WIDTH

# -- loops over components -----------------------------------------------------------------------------


class Components:
    """Eight components of the rows of one run, from ``offset`` on; of the last, those from ``count`` on are padding."""

    def __init__(self, builder: Any, offset: Any, count: Any) -> None:
        self.builder, self.offset, self.count = builder, offset, count

    def of(self, row: Any) -> Any:
        """Pointer to these components of a row, which has places up to the next multiple of eight."""
        length_of(self.builder, row)
        place = self.builder.gep(row, [self.offset])
        return self.builder.bitcast(place, wide(REAL, WIDTH).as_pointer())

    def without_padding(self, value: Any, other: Any) -> Any:
        """The value in the components, ``other`` in the padding."""
        b = self.builder
        places = ir.Constant(ir.VectorType(WHOLE, WIDTH), [WHOLE(k) for k in range(WIDTH)])
        remaining = splat(b, b.sub(self.count, self.offset), WIDTH)
        return b.select(b.icmp_signed("<", places, remaining), value, other)


def begun(builder: Any, operation: Any, value: Any) -> Any:
    """Vector from which a reduction begins: a first value, met once in a sum."""
    if operation is not ast.Add:
        return splat(builder, value, WIDTH)
    nothing = ir.Constant(wide(REAL, WIDTH), [REAL(-0.0)] * WIDTH)  # x + -0.0 is x, for 0.0 and -0.0 too
    return builder.insert_element(nothing, value, ir.IntType(32)(0))


def reduced(builder: Any, operation: Any, vector: Any) -> Any:
    """One number of eight: in pairs, so that few operations wait for each other."""
    for k in (4, 2, 1):
        places = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [(i + k) % WIDTH for i in range(WIDTH)])
        other = builder.shuffle_vector(vector, vector, places)
        is_sum = operation is ast.Add
        vector = builder.fadd(vector, other) if is_sum else operation.write(builder, vector, other)
    return builder.extract_element(vector, ir.IntType(32)(0))


class LoopOverComponents:
    """The syntax of a loop over components.

    What holds for one component after the other must hold for eight at once. So no component may depend on another,
    except through a reduction, and what the loop writes are rows.
    """

    def __init__(self, node: ast.For, known: dict[str, Any], value: Callable[[ast.expr], Any]) -> None:
        """``known`` are the types of the names that have a value before the loop; ``value`` is that of a global."""
        self.node, self.known, self.value = node, known, value
        self.name = node.target.id if isinstance(node.target, ast.Name) else ""
        self.reductions: dict[str, Any] = {}
        """Operation by name: `maximum`, `larger` or ast.Add. Only the rounding of sums depends on the order."""
        self.new: set[str] = set()
        """Names of the body."""

    def refusals(self) -> Iterator[tuple[ast.AST, str, str]]:
        """(node, expectation, cure) of each part that is no part of such a loop."""
        if not self.name or self.name in self.known:
            yield self.node, "a name of its own for the component", "Write for i in components(n)."
        yield from self._of_statements(self.node.body)
        allowed = set()
        for x in self._parts():
            if isinstance(x, ast.Subscript):
                last = x.slice.elts[-1] if isinstance(x.slice, ast.Tuple) else x.slice
                base = x.value.id if isinstance(x.value, ast.Name) else ""
                if isinstance(last, ast.Name) and last.id == self.name:
                    allowed.add(last)
                elif not base or (base in self.known or base in self.new):
                    yield x, "a component of a row at the place of the loop", f"Write row[{self.name}]."
            elif isinstance(x, ast.Call) and self.value(x.func) in (any, all):
                yield (
                    x,
                    "a number for each component",
                    "Collect one with maximum, and test it behind the loop.",
                )
        for x in self._parts():
            if isinstance(x, ast.Name) and x.id == self.name and x not in allowed:
                yield x, "the component as a place in rows", "Its number is known in a loop over range."
        yield from self._of_reductions()

    def _parts(self) -> Iterator[ast.AST]:
        return (x for statement in self.node.body for x in ast.walk(statement))

    def _of_statements(self, statements: Sequence[ast.stmt]) -> Iterator[tuple[ast.AST, str, str]]:
        for x in statements:
            if (
                isinstance(x, ast.For)
                and isinstance(x.iter, ast.Call)
                and self.value(x.iter.func) is unrolled
            ):
                self.new |= {x.target.id} if isinstance(x.target, ast.Name) else set()
                yield from self._of_statements(x.body)
            elif isinstance(x, ast.Assign | ast.AugAssign):
                targets = x.targets if isinstance(x, ast.Assign) else [x.target]
                parts = [y for t in targets for y in (t.elts if isinstance(t, ast.Tuple) else [t])]
                for target in parts:
                    if isinstance(target, ast.Name):
                        self.new |= {target.id} - {*self.known}
                    elif not isinstance(target, ast.Subscript):
                        yield (
                            target,
                            "a component or a name of the body",
                            "Assign to the field behind the loop.",
                        )
            else:
                yield (
                    x,
                    "assignments in a loop over components",
                    "Other statements stand in a loop over range.",
                )

    def _of_reductions(self) -> Iterator[tuple[ast.AST, str, str]]:
        """Find the reductions, and whether their names serve nothing else."""
        uses: dict[str, int] = {}
        for x in self._parts():
            operation, name = self._reduction(x)
            if operation is not None and name in self.known:
                uses[name] = uses.get(name, 0) + (1 if operation is ast.Add else 2)
                if self.reductions.setdefault(name, operation) is not operation:
                    yield (
                        x,
                        f"one reduction to '{name}'",
                        "Collect in a second name, and join them behind the loop.",
                    )
        for x in self._parts():
            if isinstance(x, ast.Name) and x.id in self.known:
                changes = isinstance(x.ctx, ast.Store) and x.id not in self.reductions
                if changes or x.id in self.reductions and self._count(x.id) != uses[x.id]:
                    cure = f"Write {x.id} = maximum({x.id}, y) or {x.id} += y, and use it behind the loop."
                    yield x, f"a reduction to '{x.id}'", cure
        for name in self.reductions:
            if element_of(self.known[name]) != REAL:
                yield self.node, f"a real number '{name}'", f"Write {name}: Real = 0.0 before the loop."

    def _count(self, name: str) -> int:
        return sum(isinstance(x, ast.Name) and x.id == name for x in self._parts())

    def _reduction(self, x: ast.AST) -> tuple[Any, str]:
        """Operation and name of a statement that collects; (None, "") of another."""
        match x:
            case ast.AugAssign(target=ast.Name(id=name), op=ast.Add()):
                return ast.Add, name
            case ast.Assign(
                targets=[ast.Name(id=name)], value=ast.Call(func=f, args=[ast.Name(id=first), _])
            ):
                if name == first and self.value(f) in (maximum, larger):
                    return self.value(f), name
        return None, ""


# -- assignments to rows -------------------------------------------------------------------------------


class Chain(NamedTuple):
    """A sum of rows for a kernel, y + h Σ_j w_j k_j: what is known early, and its last term h w k.

    A kernel has just written the last row, and the next kernel reads the sum. The numbers of the last row are added one
    by one: a wide sum would wait for the slowest of them, whereas the angles of the next stage follow from speeds, so
    that their sines can be computed before the accelerations are known.
    """

    early: Any
    weight: Any
    late: Any


@instruction("", "")
def combination(builder: Any, weights: Any, rows: Any) -> Any:
    """Refuse the call outside of an assignment to a row."""
    raise Refusal(
        "a combination of rows in an assignment to a row", "Write row[:] = h * combination(weights, rows)."
    )


@instruction("", "")
def chain(builder: Any, weights: Any, rows: Any) -> Any:
    """Refuse the call outside of an assignment to a row."""
    raise Refusal("a chain in an assignment to a row", "Write row[:] = y + h * chain(weights, rows).")


class RowFormula:
    """The right side of an assignment to a row, at the eight components from ``offset`` on."""

    def __init__(self, value: Callable[[ast.expr], Any], builder: Any, offset: Any) -> None:
        self.plain, self.builder, self.offset = value, builder, offset

    def assign(self, row: Any, node: ast.expr) -> None:
        """Write the components of a row."""
        value = self.value(node)
        if (
            isinstance(value, Chain) and lanes_of(row.type) > 1
        ):  # no kernel waits for the slowest of the lanes
            late = self.builder.load(self._place(value.late), align=8)
            value = mathematical(
                self.builder, "fmuladd", *map(self.vector, (value.weight, late, value.early))
            )
        if not isinstance(value, Chain):
            self.builder.store(self.vector(value), self._place(row), align=8)
            return
        b = self.builder
        early = self.vector(value.early)
        for k in range(WIDTH):
            # atomic, so that LLVM does not join them into vectors; the machine code is an ordinary load and store
            old, new = (b.gep(p, [b.add(self.offset, WHOLE(k))]) for p in (value.late, row))
            term = b.load_atomic(old, "monotonic", 8)
            total = b.extract_element(early, ir.IntType(32)(k))
            b.store_atomic(mathematical(b, "fmuladd", value.weight, term, total), new, "monotonic", 8)

    def vector(self, value: Any) -> Any:
        """A value as eight numbers."""
        return cast(self.builder, value, wide(REAL, WIDTH))

    def value(self, node: ast.expr) -> Any:
        """Value of an expression: a number, eight numbers, or a chain."""
        if isinstance(node, ast.BinOp):
            return self._operated(node)
        if isinstance(node, ast.Call):
            function = self.plain(node.func)
            if function is combination or function is chain:
                weights, rows = (self.plain(argument) for argument in node.args)
                terms = sorted((weights if isinstance(weights, dict) else dict(enumerate(weights))).items())
                if function is combination:
                    return self._sum(terms, rows)
                *early, (late, weight) = terms
                return Chain(self._sum(early, rows), weight, rows.row(self.builder, WHOLE(late)))
            if function is where:
                return selected(self.builder, *map(self.value, node.args))
        value = self.plain(node)
        if isinstance(kind_of(value), ir.PointerType):
            return self.builder.load(self._place(value), align=8)
        return value

    def _operated(self, node: ast.BinOp) -> Any:
        b, is_sum = self.builder, isinstance(node.op, ast.Add)
        left, right = (
            (node.right, node.left) if is_sum and _is_product(node.left) else (node.left, node.right)
        )
        if not (is_sum and isinstance(right, ast.BinOp) and _is_product(right)):
            return operated(b, type(node.op), self.value(left), self.value(right))
        a, p, q = self.value(left), self.value(right.left), self.value(right.right)
        if isinstance(q, Chain):  # a + p (early + weight late)
            early = a if q.early is None else self._joined(p, q.early, a)
            return Chain(early, operated(b, ast.Mult, p, q.weight), q.late)
        return self._joined(p, q, a)

    def _joined(self, p: Any, q: Any, a: Any) -> Any:
        """p q + a."""
        return mathematical(self.builder, "fmuladd", *map(self.vector, (q, p, a)))

    def _sum(self, terms: Sequence[tuple[int, float]], rows: Any) -> Any:
        """Σ_j w_j k_j; None without a term."""
        total = None
        for j, weight in terms:
            if weight == 0:
                continue
            row = self.builder.load(self._place(rows.row(self.builder, WHOLE(j))), align=8)
            if total is None:
                total = operated(self.builder, ast.Mult, row, weight)
            else:
                total = mathematical(self.builder, "fmuladd", row, self.vector(weight), total)
        return total

    def _place(self, row: Any) -> Any:
        b = self.builder
        return b.bitcast(b.gep(row, [self.offset]), wide(REAL, WIDTH).as_pointer())  # of lanes: as it is


def _is_product(node: ast.expr) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)
