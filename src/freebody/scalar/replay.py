"""Evaluation of a tape for arrays: one pass over its operations serves many points."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .algebra import Scalar
from .arrays import function_of_arrays
from .trace import ADD, CONST, DIV, INPUT, MUL, NAMES, NEG, SUB, Tape, Traced

Array = NDArray[np.float64]
POINTS = 1024
"""Points of one pass, few enough that the intermediate values stay in the processor's cache."""
_ARITHMETIC: dict[int, Callable[..., Any]] = {
    ADD: operator.add, SUB: operator.sub, MUL: operator.mul, DIV: operator.truediv, NEG: operator.neg,
}  # fmt: skip


class Replay:
    """The outputs of a tape as functions of arrays.

    Parameters
    ----------
    tape : Tape
    outputs : sequence of traced scalars and numbers

    Examples
    --------
    >>> from freebody.scalar.trace import Tape
    >>> tape = Tape()
    >>> x, y = tape.input("x"), tape.input("y")
    >>> Replay(tape, [x * y + 1, 2])([[1, 2, 3], [4, 5, 6]])
    array([[ 5., 11., 19.],
           [ 2.,  2.,  2.]])
    """

    def __init__(self, tape: Tape, outputs: Sequence[Scalar]) -> None:
        used = tape.used(outputs)
        place = {node: k for k, node in enumerate(used)}
        self._inputs: list[tuple[int, int]] = []
        self._constants: list[tuple[int, float]] = []
        self._steps: list[tuple[int, Callable[..., Any], int, int, tuple[int, ...]]] = []
        self._size = len(used)
        for k, i in enumerate(used):
            code, a, b = tape.op[i], tape.a[i], tape.b[i]
            if code == CONST:
                self._constants.append((k, float(tape.constants[a])))
            elif code == INPUT:
                self._inputs.append((k, a))
            else:
                act = _ARITHMETIC.get(code) or function_of_arrays(NAMES[code])
                self._steps.append((k, act, place[a], place[b] if b >= 0 else -1, ()))
        self._outputs = [
            (k, place[x.index] if type(x) is Traced else -1, 0 if type(x) is Traced else float(x))
            for k, x in enumerate(outputs)
        ]

        # a value is released after the last step that needs it
        needed = {node for _, node, _ in self._outputs}
        for n in range(len(self._steps) - 1, -1, -1):
            k, act, a_place, b_place, _ = self._steps[n]
            last = tuple({a_place, b_place} - needed - {-1})
            needed.update(last)
            self._steps[n] = (k, act, a_place, b_place, last)

    def __call__(self, inputs: Any) -> Array:
        """Outputs, shape (m, N), for inputs, shape (n, N), in the order in which the tape's inputs were named."""
        inputs = np.asarray(inputs, dtype=float)
        n = inputs.shape[1]
        result = np.empty((len(self._outputs), n))
        with np.errstate(all="ignore"):  # callers check for values that are not finite
            if n == 1:
                try:  # plain numbers are ten times as fast as arrays of length 1
                    self._pass(inputs[:, 0].tolist(), result)
                    return result
                except ZeroDivisionError:  # arrays give infinity
                    pass
            for start in range(0, n, POINTS):
                self._pass(inputs[:, start : start + POINTS], result[:, start : start + POINTS])
        return result

    def _pass(self, inputs: Any, result: Array) -> None:
        values: list[Any] = [None] * self._size
        for k, value in self._constants:
            values[k] = value
        for k, i in self._inputs:
            values[k] = inputs[i]
        for k, act, a, b, last in self._steps:
            values[k] = act(values[a]) if b < 0 else act(values[a], values[b])
            for i in last:
                values[i] = None
        for k, node, number in self._outputs:
            result[k] = values[node] if node >= 0 else number
