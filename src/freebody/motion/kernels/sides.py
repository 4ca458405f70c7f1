"""Laws that switch, with the side of each as a constant of a run: rates that are smooth up to a switch and beyond it.

    sign(e) = s      |e| = s e      max(a, b) = ½ (1 + s) a + ½ (1 - s) b,   e = a - b      s = ±1

A run keeps every s, stops where an e passes zero, and goes on with the other s (`sided_way`). So the steps see no jump
and no bend, and an e that dips through zero within one long step is found as any event is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import sympy

from ...dynamics import State, coordinate_rates, traced_state
from ...dynamics.conditions.contact import coefficients, watched_by_modes
from ...dynamics.motion import motion, total_power
from ...errors import SimulationError
from ...model import Model
from ...program.large.tree_loop import BODIES, is_large
from ...scalar.algebra import HALF, Scalar
from ...scalar.derivative import forward
from ...scalar.trace import ADD, CONST, INPUT, MUL, NEG, SUB, Tape, Traced
from ..ode.dense_output import Array, outputs_at
from .hoisted import Hoisted
from .kernels import Kernels
from .program import Program
from .sided_run import SidedRun, sided_run

ALIKE = 1e-9
"""Part of e at the ends of a step that counts as zero."""
BENDING = ("abs", "min", "max")
"""Functions that bend where their e is zero, and do not jump."""
SWITCHING = ("sign", *BENDING)
_KINKS = sympy.sign, sympy.Abs, sympy.Max, sympy.Min


class SidedTape(Tape):
    """A tape whose signs, or also its ``bends``, have a side that is an input while it is ``sided``.

    ``sides``    input and e of each law, in the order in which they came, by the node of e
    ``jumps``    numbers of the laws that are the sign of their e somewhere
    ``closed``   True if no further law gets an input
    ``watched``  nodes that are zero where modes of contacts change: they have no side
    """

    def __init__(self, bends: bool = False) -> None:
        super().__init__()
        self.bends = bends
        self.sided = self.closed = False
        self.sides: dict[int, tuple[Traced, Traced]] = {}
        self.jumps: set[int] = set()
        self.watched: set[int] = set()

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
        if e.index in self.watched:
            return None
        if e.index not in self.sides:
            if self.closed:
                return None
            self.sides[e.index] = self.input(f"side {len(self.sides)}"), e
        if function == "sign":
            self.jumps.add(list(self.sides).index(e.index))
        return self.sides[e.index][0]


@dataclass(frozen=True)
class Law:
    """A law that switches where e = 0.

    ``text``     e
    ``jumps``    True if it is a sign of e somewhere; else it only bends
    ``order``    1 if ė depends on rates of speeds; else 2
    """

    text: str
    jumps: bool
    order: int


class SidedKernels(Kernels):
    """Programs of a model whose laws that switch have sides, behind the parameters."""

    def __init__(self, whole: Kernels) -> None:
        super().__init__(whole.model, whole.active)
        self.whole = whole

    def __reduce__(self) -> Any:
        return _restored, (self.whole,)

    def _large(self) -> None:
        return None  # sides are parameters of straight code

    def recorded(self, numbers_are_data: bool = False) -> tuple[Tape, State, list[Scalar]]:
        """Return a tape on which the rates are recorded, the state, and the parameters with the sides behind them.

        Numbers are no data: whether the sign of an expression switches is read from them.
        """
        tape = SidedTape(True)
        state = traced_state(self.model, tape)
        for contact in switching_contacts(self.model):
            numbers = [x for x in watched_by_modes(self.model, state, contact) if isinstance(x, Traced)]
            tape.watched |= {(x if x.minus is None else x.minus).index for x in numbers}
        tape.sided = True
        _with_sides(state, self.active)
        tape.closed = True
        parameters = [state.values[parameter.symbol] for parameter in self.model.parameters]
        return tape, state, [*parameters, *(side for side, _ in tape.sides.values())]


def _with_sides(state: State, active: tuple[int, ...]) -> list[Scalar]:
    """Return what depends on sides: rates of speeds, the power of loads, and coefficients and forces of contacts."""
    model, moving = state.model, motion(state.model, state, active)
    laws = [x for contact in switching_contacts(model) for x in coefficients(model, state, contact)]
    return [*moving.udot, total_power(model, state, moving), *laws]


def switching_contacts(model: Model) -> tuple[Any, ...]:
    """Return the contacts with a sign, an amount or an extreme in the expressions of their laws."""
    if "switching contacts" not in model.memo:
        model.memo["switching contacts"] = tuple(
            contact
            for contact in model.contacts
            for laws in [(contact.friction, contact.static_friction, contact.normal_force)]
            if any(isinstance(x, sympy.Basic) and x.has(*_KINKS) for x in laws)
        )
    return model.memo["switching contacts"]


def laws_of(state: State) -> list[Scalar]:
    """Return the e of the laws that have sides on the tape of a state."""
    tape = state.field
    return [e for _, e in tape.sides.values()] if isinstance(tape, SidedTape) else []


def unsided(state: State) -> State:
    """Return a state on the same tape, whose laws switch by themselves; a state keeps the values it has found."""
    tape = state.field
    if not isinstance(tape, SidedTape):
        return state
    tape.sided = False
    return traced_state(state.model, tape)


def _restored(whole: Kernels) -> Kernels:
    sides = sides_of(whole)
    assert sides is not None
    return sides.kernels


class Flow:
    """How the rates depend on sides, as rows for `switching.find_idle`: nodes of the trace, in their order.

    ``code``, ``first``, ``second``    operation and operands of each node
    ``known``, ``value``    1 if it follows from the sides alone, and the value of a constant
    ``inputs``, ``switching``, ``outputs``    nodes of the sides, of the e of the laws, and of the rates
    """

    def __init__(self, tape: SidedTape, outputs: Sequence[Scalar]) -> None:
        sides, e = [side for side, _ in tape.sides.values()], [e for _, e in tape.sides.values()]
        used = sorted(tape.used([*outputs, *e, *sides]))
        place = {node: k for k, node in enumerate(used)}
        self.code = [tape.op[i] for i in used]
        operands = [code if code > INPUT else -1 for code in self.code]
        self.first = [place[tape.a[i]] if one >= 0 else 0 for i, one in zip(used, operands, strict=True)]
        self.second = [
            place[tape.b[i]] if one >= 0 and tape.b[i] >= 0 else first
            for i, one, first in zip(used, operands, self.first, strict=True)
        ]
        self.value = [float(tape.scalar(i)) if tape.op[i] == CONST else 0.0 for i in used]
        self.inputs, self.switching = ([place[x.index] for x in nodes] for nodes in (sides, e))
        self.outputs = sorted({place[x.index] for x in outputs if isinstance(x, Traced)})
        self.known = [int(code == CONST or k in self.inputs) for k, code in enumerate(self.code)]
        for k, code in enumerate(self.code):
            if code in (ADD, SUB, MUL, NEG):
                self.known[k] = self.known[self.first[k]] & self.known[self.second[k]]


class Sides:
    """The laws of a machine that switch.

    ``laws``    in the order of their sides
    """

    def __init__(self, whole: Kernels) -> None:
        self.whole = whole
        self.kernels = SidedKernels(whole)
        self.spare: dict[Any, list[Any]] = {}  # memory of finished runs
        self.laws: tuple[Law, ...] = ()
        self.program: Program = self.kernels.program("laws", self.functions, whole.model.n_u)

    @property
    def texts(self) -> tuple[str, ...]:
        """Return e of each law."""
        return tuple(law.text for law in self.laws)

    def functions(self, state: State, udot: Sequence[Scalar] = ()) -> dict[str, list[Scalar]]:
        """Return e, ė and, of a law of order 2, ë of every law; ``udot`` are the rates of the speeds."""
        model, tape = self.whole.model, state.field
        assert isinstance(tape, SidedTape)
        tape.sided = True
        qdot = coordinate_rates(model, state)
        self.flow = Flow(tape, _with_sides(state, self.whole.active))
        variables, rates = [state.t, *state.q, *state.u], [1, *qdot, *udot]
        outputs: list[Scalar] = []
        laws: list[Law] = []
        for k, (_, e) in enumerate(tape.sides.values()):
            (rate,) = forward(tape, [e], variables, rates)
            order = 2 if {x.index for x in udot}.isdisjoint(tape.used([rate])) else 1
            (change,) = forward(tape, [rate], variables, rates) if order > 1 else (0,)
            outputs += [e, rate, change]
            laws.append(Law(str(tape.to_sympy(e)), k in tape.jumps, order))
        self.laws = tuple(laws)
        return {"laws": outputs}

    def run(self, n_y: int, hoisted: Hoisted) -> SidedRun:
        """Return the memory of a run, whose sides are the last of the parameters of ``hoisted``."""
        constants = np.zeros(self.program.compiled.hoisted)
        self.program.follow(hoisted, constants)
        return sided_run(self, n_y, hoisted, self.program.address("laws"), constants)

    def unseen(
        self, plain: Sequence[Any], found: Sequence[Any], parameters: Array, near: float
    ) -> Iterator[tuple[float, str]]:
        """Yield the steps of a run without sides that show no sign of a switch, and e of the law, which jumps.

        ``plain`` and ``found`` are its segments, and those of the run with sides; times within ``near`` are the same.
        """
        times = np.concatenate([one.path.times for one in plain])
        e = [
            self.e(t, y, parameters)
            for one in plain
            for t, y in zip(one.path.times, one.path.states, strict=True)
        ]
        for before, after in pairwise(found):
            t = after.path.start
            here = self.e(t, after.path.states[0], parameters)
            turned = before.kernels.sides, after.kernels.sides
            first, last = np.searchsorted(times, t - near) - 1, np.searchsorted(times, t + near)
            for k, law in enumerate(self.laws) if first >= 0 and last < len(times) else ():
                low, high = e[first][k], e[last][k]
                at_zero = abs(here[k]) <= ALIKE * max(
                    abs(low), abs(high)
                )  # an idle law follows at a start of a leg
                if law.jumps and at_zero and turned[0][k] * turned[1][k] < 0 < low * high:
                    yield float(times[first]), law.text

    def start(self, t: float, y: Array, parameters: Array) -> Array:
        """Return the sides of all laws at a state, 0 where e is zero."""
        return np.sign(self.e(t, y, parameters))

    def e(self, t: float, y: Array, parameters: Array) -> Array:
        """Return e of all laws at a state, with the sides there."""
        sides, moved = np.zeros(len(self.laws)), self.whole.model.n_q + self.whole.model.n_u
        argument = np.concatenate([y[:moved], np.zeros(self.whole.model.n_u)])
        for _ in range(len(sides) + 1):  # an e may depend on other sides
            constants = self.program.constants(np.concatenate([parameters, sides]))
            found = outputs_at(self.program.address("laws"), 3 * len(self.laws), t, argument, constants)
            before, sides = sides, np.sign(found[::3])
            if (before == sides).all():
                break
        result: Array = found[::3]
        return result


def sided_kernels(kernels: Kernels) -> Kernels:
    """Return the programs of a machine with the sides of its laws, or its own if none switches."""
    sides = sides_of(kernels)
    return kernels if sides is None else sides.kernels


def sides_of(kernels: Kernels) -> Sides | None:
    """Return the laws of a machine that switch; None if there are none, or if they only bend in a very large tree.

    Raises
    ------
    SimulationError
        A law that jumps in a tree of so many bodies that its equations are only loops over links.
    """
    if "sides" not in kernels.cache:
        own, found = kernels.operations or {}, None
        if not own.keys().isdisjoint(SWITCHING) or switching_contacts(kernels.model):
            found = None if _is_looped(kernels, own) else Sides(kernels)
        kernels.cache["sides"] = found if found and found.laws else None
    sides: Sides | None = kernels.cache["sides"]
    return sides


def _is_looped(kernels: Kernels, operations: Mapping[str, int]) -> bool:
    """Return True for a tree without straight code; refuse one whose laws jump."""
    model, count = kernels.model, len(kernels.model.bodies)
    if count < BODIES or not is_large(model):
        return False
    if "sign" in operations:
        raise SimulationError(
            f"Expected forces that do not jump in a tree of {BODIES} bodies or more, whose equations are loops over "
            f"links, but those of '{model.name}', with {count}, have a sign(...), whose switches would not be located. "
            "Give the jump a width of your choice, tanh(x/width) for sign(x)."
        )
    return True
