"""Functions of a machine's state, recorded once and evaluated at many states and values in one pass.

In numbers, `linearize` evaluates the same program at all values of a machine's parameters. The program is recorded on
traced scalars (`scalar.trace`) at its first use, and kept with the model.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...describe.description import changes_of
from ...describe.system import System
from ...describe.table import Changes
from ...dynamics.state import State
from ...model.assemble import assemble
from ...model.model import Model
from ...scalar.replay import Replay
from ...scalar.trace import Tape

Array = NDArray[np.float64]
KEPT = 16
"""Number of machines, the most recently used, whose programs are kept."""


@dataclass(frozen=True)
class Points:
    """States of one machine, a row each: times (N,), coordinates (N, n_q), speeds (N, n_u), parameters (N, n_p)."""

    t: Array
    q: Array
    u: Array
    values: Array

    def __len__(self) -> int:
        return len(self.t)

    def at(self, **changed: Any) -> Points:
        """Return these points with other times, coordinates or speeds."""
        return replace(self, **changed)

    def __getitem__(self, which: Any) -> Points:
        return Points(self.t[which], self.q[which], self.u[which], self.values[which])


class Recorded:
    """The recorded programs of one model, by key."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._programs: dict[Any, tuple[Replay, list[tuple[str, tuple[int, ...], int]]]] = {}

    def __call__(
        self, key: Any, build: Callable[..., Mapping[str, Any]], points: Points, *more: Array
    ) -> dict[str, Array]:
        """Return the blocks of ``build(state, *more)`` by name, (N, ...) each; the program is recorded under ``key``.

        Parameters
        ----------
        key : hashable
            Everything except the model on which ``build`` depends.
        build : callable
            Function of a state and of lists of scalars that returns nested lists of scalars by name.
        points : Points
        *more : array (N, k)
            Further inputs.
        """
        if key not in self._programs:
            self._programs[key] = self._recorded(build, [x.shape[1] for x in more])
        replay, blocks = self._programs[key]
        rows = replay(np.concatenate([points.t[:, None], points.q, points.u, points.values, *more], axis=1).T)
        result, start = {}, 0
        for name, shape, size in blocks:
            result[name] = rows[start : start + size].T.reshape(len(points), *shape)
            start += size
        return result

    def _recorded(self, build: Callable[..., Mapping[str, Any]], sizes: Sequence[int]) -> Any:
        model, tape = self.model, Tape()
        t, *q_u = (tape.input(f"{k}") for k in range(1 + model.n_q + model.n_u))
        values = {p.symbol: tape.input(f"value {p.name}") for p in model.parameters}
        more = [[tape.input(f"{k} {i}") for i in range(size)] for k, size in enumerate(sizes)]
        products = build(State(model, tape, t, q_u[: model.n_q], q_u[model.n_q :], values), *more)
        blocks, outputs = [], []
        for name, x in products.items():
            block = np.empty(np.shape(x), dtype=object)
            block[...] = x
            blocks.append((name, block.shape, block.size))
            outputs += block.reshape(-1).tolist()
        return Replay(tape, outputs), blocks


_recent: OrderedDict[int, tuple[Any, Changes, int, Recorded]] = OrderedDict()


def recorded(machine: System | Model) -> Recorded:
    """Return the programs of a model, or of a system in its present form; the most recently used are kept."""
    entry = _recent.get(id(machine))  # the entry keeps the object alive, so that no other object has its id
    if entry is None or entry[1].count != entry[2]:
        changes = changes_of(machine) if isinstance(machine, System) else Changes()
        model = assemble(machine) if isinstance(machine, System) else machine
        entry = _recent[id(machine)] = (machine, changes, changes.count, Recorded(model))
    _recent.move_to_end(id(machine))
    while len(_recent) > KEPT:
        _recent.popitem(last=False)
    return entry[3]
