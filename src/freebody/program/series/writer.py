"""The part of a series' text that one motion (`jet`) and eight motions (`jet_of_lanes`) share."""

from __future__ import annotations

from ...native.records import WIDTH
from ..code.emit import Module
from ..code.ir_text import Lines, literal, splat
from .recurrence import Node, Number, Recurrence

ORDER = 2 * WIDTH
"""p, the order of the last coefficient. Its cost grows little with it while half of the sums fit in a register."""
PIECE = 400
"""Number of nodes in one piece of a long recurrence."""
INVERSES = (
    f"@jet.inverse = private constant [{ORDER + 1} x double] "
    f"[{', '.join(f'double {literal(1 / max(k, 1))}' for k in range(ORDER + 1))}]"
)
"""Table of 1 / k; the entry for k = 0 is not read."""


class SeriesWriter(Lines):
    """Writer of the function that fills the coefficients: values at order 0, numbers, loads and stores."""

    def __init__(self, module: Module, recurrence: Recurrence, name: str, piece: int, lanes: int) -> None:
        super().__init__()
        self.lanes = lanes
        self.T = "double" if lanes == 1 else f"<{lanes} x double>"
        self.module, self.name = module, name
        self.nodes, self.outputs = recurrence.nodes, recurrence.outputs
        self.zero = recurrence.starts_at_zero
        self.pieces = cut(recurrence.order, piece)
        self.owner = {i: j for j, part in enumerate(self.pieces) for i in part}
        self.values: dict[int, str] = {}
        self.numbers: dict[object, str] = {}
        self.sines: dict[int | Number, tuple[str, str]] = {}

    def _value(self, x: int | Number) -> str:
        """The coefficient at the current order; for a number, its value."""
        raise NotImplementedError

    def _constant(self, value: float) -> str:
        return splat(literal(value), self.lanes)

    def _pointer(self, base: str, place: int, T: str = "") -> str:
        return base if place == 0 else self._new(f"getelementptr {T or self.T}, ptr {base}, i64 {place}")

    def _load(self, base: str, place: int, T: str = "") -> str:
        T = T or self.T
        return self._new(f"load {T}, ptr {self._pointer(base, place, T)}, align {_alignment(T)}")

    def _store(self, value: str, base: str, place: int, T: str = "") -> None:
        T = T or self.T
        self.lines.append(f"  store {T} {value}, ptr {self._pointer(base, place, T)}, align {_alignment(T)}")

    def _number(self, x: Number) -> str:
        """Value of a number: a literal, a hoisted constant, a function of one, or a sum of products."""
        if x not in self.numbers and x.parts:
            total: str | None = None
            for value, factors in x.parts:
                product = self._constant(value)
                for factor in factors:
                    product = self._arithmetic("fmul", product, self._number(factor))
                total = self._signed(total, 1, product)
            assert total is not None
            self.numbers[x] = total
        elif x not in self.numbers:
            number = self._constant(x.value) if x.value is not None else self._load("%c", x.place)
            if x.function == "square":
                number = self._arithmetic("fmul", number, number)
            elif x.function:
                number = self._called(self.module.need_function(x.function, self.lanes, 1), [number])
            self.numbers[x] = number
        return self.numbers[x]

    def _called(self, function: str, arguments: list[str]) -> str:
        return self._new(f"call {self.T} {function}({', '.join(f'{self.T} {x}' for x in arguments)})")

    def _function_at_start(self, node: Node) -> str:
        """Value at order 0 of a node whose function and arguments define it."""
        if node.function in ("sin", "cos"):
            return self._load(self._sine_and_cosine(node.arguments[0])[node.function == "cos"], 0)
        arguments = [self._value(x) for x in node.arguments]
        return self._called(self.module.need_function(node.function, self.lanes, len(arguments)), arguments)

    def _sine_and_cosine(self, x: int | Number) -> tuple[str, str]:
        """Pointers to the sine and the cosine of a value at order 0."""
        if x not in self.sines:
            value = self._value(x)
            s, c = (self._new(f"alloca {self.T}, align {_alignment(self.T)}") for _ in range(2))
            self.lines.append(
                f"  call void {self.module.need_sincos(self.lanes)}({self.T} {value}, ptr {s}, ptr {c})"
            )
            self.sines[x] = (s, c)
        return self.sines[x]


def _alignment(T: str) -> int:
    return 8 if T == "double" else 64


def cut(order: list[int], piece: int) -> list[list[int]]:
    """Cut a long recurrence into equal pieces of about ``piece`` nodes."""
    count = -(-len(order) // piece) if len(order) > 2 * piece else 1
    size = -(-len(order) // count) if order else 1
    return [order[j * size : (j + 1) * size] for j in range(count)]


def arguments_of(parameters: str) -> str:
    """Return a list of parameters as arguments of a call."""
    return parameters.replace("noalias ", "")
