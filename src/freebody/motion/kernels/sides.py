"""Laws that switch, with the side of each as a constant of a run: rates that are smooth up to a switch and beyond it.

    sign(e) = s      |e| = s e      max(a, b) = ½ (1 + s) a + ½ (1 - s) b,   e = a - b      s = ±1

A run keeps every s, stops where an e passes zero, and goes on with the other s (`sided_way`). So the steps see no jump
and no bend, and an e that dips through zero within one long step is found as any event is.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics import State, coordinate_rates, traced_state
from ...dynamics.motion import motion, total_power
from ...scalar.algebra import HALF, Scalar
from ...scalar.derivative import forward
from ...scalar.trace import ADD, CONST, INPUT, MUL, NEG, SUB, Tape, Traced
from ..ode.dense_output import Array, Watch, observe, outputs_at
from .kernels import Kernels
from .program import Program
from .switches import value_of

BENDING = ("abs", "min", "max")
"""Functions that bend where their e is zero, and do not jump."""
SWITCHING = ("sign", *BENDING)


class SidedTape(Tape):
    """A tape whose signs, or also its ``bends``, have a side that is an input while it is ``sided``.

    ``sides``    input and e of each law, in the order in which they came, by the node of e
    ``jumps``    numbers of the laws that are the sign of their e somewhere
    ``free``     numbers of laws that are left as they are
    ``closed``   True if no further law gets an input
    """

    def __init__(self, bends: bool = False, free: Iterable[int] = ()) -> None:
        super().__init__()
        self.bends, self.free = bends, frozenset(free)
        self.sided = self.closed = False
        self.sides: dict[int, tuple[Traced, Traced]] = {}
        self.jumps: set[int] = set()

    def apply(self, function: str, *arguments: Scalar) -> Scalar:
        """Return a function of scalars; where it switches, by the side of its e."""
        if not self.sided or not (function == "sign" or self.bends and function in BENDING):
            return super().apply(function, *arguments)
        a, *others = arguments
        side = self._side(a - others[0] if others else a, function)
        if side is None:
            return super().apply(function, *arguments)
        if function == "sign":
            return side
        if not others:
            return side * a
        if function == "min":
            side = -side
        return (1 + side) * HALF * a + (1 - side) * HALF * others[0]

    def _side(self, x: Scalar, function: str) -> Scalar | None:
        """Return the side of e; None if it has none."""
        if not isinstance(x, Traced):
            return None
        if x.minus is not None:
            side = self._side(x.minus, function)
            return None if side is None else -side
        e = self.node(x)
        if e.index not in self.sides:
            if self.closed:
                return None
            self.sides[e.index] = self.input(f"side {len(self.sides)}"), e
        number = list(self.sides).index(e.index)
        if function == "sign":
            self.jumps.add(number)
        return None if number in self.free else self.sides[e.index][0]


@dataclass(frozen=True)
class Law:
    """A law that switches where e = 0.

    ``text``     e
    ``jumps``    True if it is a sign of e somewhere; else it only bends
    ``order``    1 if ė depends on its side, as for a speed; else 2
    """

    text: str
    jumps: bool
    order: int


class SidedKernels(Kernels):
    """Programs of a model whose laws that switch have sides, behind the parameters; those in ``free`` have none."""

    def __init__(self, whole: Kernels, free: frozenset[int] = frozenset()) -> None:
        super().__init__(whole.model, whole.active)
        self.whole, self.free = whole, free

    def __reduce__(self) -> Any:
        return _restored, (self.whole, self.free)

    def recorded(self) -> tuple[Tape, State, list[Scalar]]:
        """Return a tape on which the rates are recorded, the state, and the parameters with the sides behind them."""
        tape = SidedTape(True, self.free)
        state = traced_state(self.model, tape)
        tape.sided = True
        moving = motion(self.model, state, self.active)
        total_power(self.model, state, moving)
        tape.closed = True
        parameters = [state.values[parameter.symbol] for parameter in self.model.parameters]
        return tape, state, [*parameters, *(side for side, _ in tape.sides.values())]

    def watched(self, watch: Watch | None, parameters: Array, count: int, stops: Sequence[bool]) -> Watch:
        """Return the events of a run, in both directions, and behind them the e of all laws; the run stops where
        ``stops`` say.

        ``parameters`` are followed by the sides of the ``count`` laws.
        """
        events = () if watch is None else watch.functions
        program = self.program(("watched", events), lambda state: {"values": _watched(state, events)})
        terminal = () if watch is None else watch.terminal
        return Watch(
            program.address("values"), (0,) * (len(terminal) + count), (*terminal, *stops),
            program.constants(parameters), program, guarded=count,
        )  # fmt: skip


def _watched(state: State, events: Sequence[Any]) -> list[Scalar]:
    """Return events, whose own signs have no sides, and the e of all laws."""
    tape = state.field
    assert isinstance(tape, SidedTape)
    plain = unsided(state)
    return [*(value_of(plain, x) for x in events), *(e for _, e in tape.sides.values())]


def unsided(state: State) -> State:
    """Return a state on the same tape, whose laws switch by themselves; a state keeps the values it has found."""
    tape = state.field
    assert isinstance(tape, SidedTape)
    tape.sided = False
    return traced_state(state.model, tape)


def _restored(whole: Kernels, free: frozenset[int]) -> Kernels:
    sides = sides_of(whole)
    assert sides is not None
    return sides.kernels(free)


class Flow:
    """How the rates depend on sides: a product with a factor that the sides make zero depends on that factor alone."""

    def __init__(self, tape: SidedTape, outputs: Sequence[Scalar]) -> None:
        self.inputs = [side.index for side, _ in tape.sides.values()]
        self.switching = [e.index for _, e in tape.sides.values()]
        self.outputs = [x.index for x in outputs if isinstance(x, Traced)]
        used = tape.used([*outputs, *(e for _, e in tape.sides.values())])
        self.nodes = [(i, tape.op[i], tape.a[i], tape.b[i]) for i in used]
        self.fixed = {i: tape.scalar(i) for i in used if tape.op[i] == CONST}
        of_sides = {*self.inputs, *self.fixed}
        self.of_sides = []
        for node, code, a, b in self.nodes:
            if code in KNOWN and a in of_sides and (b < 0 or b in of_sides):
                of_sides.add(node)
                self.of_sides.append((node, KNOWN[code], a, b))

    def counting(self, sides: Array) -> frozenset[int]:
        """Return the numbers of the sides on which the outputs depend, and the e of these laws."""
        values = {**self.fixed, **dict(zip(self.inputs, sides.tolist(), strict=True))}
        for i, function, a, b in self.of_sides:
            values[i] = function(values[a]) if b < 0 else function(values[a], values[b])
        found: frozenset[int] = frozenset()
        while True:
            needed = {*self.outputs, *(self.switching[k] for k in found)}
            self._need(needed, values)
            now = frozenset(k for k, i in enumerate(self.inputs) if i in needed)
            if now == found:
                return found
            found = now

    def _need(self, needed: set[int], values: dict[int, Any]) -> None:
        """Add the nodes on which needed ones depend."""
        for i, code, a, b in reversed(self.nodes):
            if i not in needed or code <= INPUT:
                continue
            if code == MUL and values.get(a) == 0 and values.get(b) != 0:
                needed.add(a)
            elif code == MUL and values.get(b) == 0 and values.get(a) != 0:
                needed.add(b)
            else:
                needed.add(a)
                if b >= 0:
                    needed.add(b)


KNOWN: dict[int, Callable[..., Any]] = {
    ADD: operator.add,
    SUB: operator.sub,
    MUL: operator.mul,
    NEG: operator.neg,
}


class Sides:
    """The laws of a machine that switch.

    ``laws``    in the order of their sides
    """

    def __init__(self, whole: Kernels) -> None:
        self.whole = whole
        self._kernels: dict[frozenset[int], SidedKernels] = {}
        self._counting: dict[bytes, frozenset[int]] = {}
        self._last: tuple[bytes, Array] | None = None
        self.laws: tuple[Law, ...] = ()
        self.program: Program = self.kernels().program("laws", self._functions)

    @property
    def texts(self) -> tuple[str, ...]:
        """Return e of each law."""
        return tuple(law.text for law in self.laws)

    def kernels(self, free: frozenset[int] = frozenset()) -> SidedKernels:
        """Return the programs with sides; laws in ``free`` have none."""
        if free not in self._kernels:
            self._kernels[free] = SidedKernels(self.whole, free)
        return self._kernels[free]

    def _functions(self, state: State) -> dict[str, list[Scalar]]:
        """Return e, ė and, of a law of order 2, ë of every law."""
        model, tape = self.whole.model, state.field
        assert isinstance(tape, SidedTape)
        tape.sided = True
        qdot, moving = coordinate_rates(model, state), motion(model, state, self.whole.active)
        udot = moving.udot
        self._flow = Flow(tape, [*udot, total_power(model, state, moving)])
        variables, rates = [state.t, *state.q, *state.u], [1, *qdot, *udot]
        outputs: list[Scalar] = []
        laws: list[Law] = []
        for k, (side, e) in enumerate(tape.sides.values()):
            (rate,) = forward(tape, [e], variables, rates)
            (by_side,) = forward(tape, [rate], [side], [1])
            order = 1 if isinstance(by_side, Traced) or by_side != 0 else 2
            (change,) = forward(tape, [rate], variables, rates) if order > 1 else (0,)
            outputs += [e, rate, change]
            laws.append(Law(str(tape.to_sympy(e)), k in tape.jumps, order))
        self.laws = tuple(laws)
        return {"laws": outputs}

    def start(self, t: float, y: Array, parameters: Array) -> Array:
        """Return the sides of all laws at a state, 0 where e is zero."""
        sides = np.zeros(len(self.laws))
        for _ in range(len(sides) + 1):  # an e may depend on other sides
            before, sides = sides, np.sign(self.at(t, y, parameters, sides)[:, 0])
            if (before == sides).all():
                break
        return sides

    def counting(self, sides: Array) -> frozenset[int]:
        """Return the laws on whose sides the rates depend, where all have these sides: not the law of a stop that is
        not touched.
        """
        key = sides.tobytes()
        if key not in self._counting:
            self._counting[key] = self._flow.counting(sides)
        return self._counting[key]

    def at(self, t: float, y: Array, parameters: Array, sides: Array) -> Array:
        """Return e, ė and ë of each law at a state, shape (laws, 3)."""
        y = np.ascontiguousarray(y, dtype=float)
        constants = self.constants(parameters, sides)
        return outputs_at(self.program.address("laws"), 3 * len(self.laws), t, y, constants).reshape(-1, 3)

    def constants(self, parameters: Array, sides: Array) -> Array:
        """Return the constants of the program; the last ones are kept."""
        key = parameters.tobytes() + sides.tobytes()
        last = self._last
        if last is None or last[0] != key:
            self._last = last = key, self.program.constants(np.concatenate([parameters, sides]))
        return last[1]

    def along(self, times: Array, states: Array, parameters: Array, sides: Array) -> Array:
        """Return e, ė and ë of each law at states, shape (times, laws, 3)."""
        constants, count = self.constants(parameters, sides), 3 * len(self.laws)
        found = observe(self.program.address("laws"), count, times, states, constants)
        return found.reshape(len(times), -1, 3)


def sides_of(kernels: Kernels) -> Sides | None:
    """Return the laws of a machine that switch; None if there are none, or if the rates are looped over links."""
    if kernels.operations is None or kernels.operations.keys().isdisjoint(SWITCHING):
        return None
    if "sides" not in kernels.cache:
        found = Sides(kernels)
        kernels.cache["sides"] = found if found.laws else None
    sides: Sides | None = kernels.cache["sides"]
    return sides
