"""Memory of runs: its sizes, and what is written into it for a machine, a method and events.

Nothing in this file needs a compiler.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...native.records import padded
from .run import PARTS, Collocation, Hamiltonian, Newton, Run, Search, Series

MACHINE = ("rates", "c", "quaternions", "n_quaternions", "projection", "projected")
"""What is written for a machine (`dense_output.Rates.words`)."""
_MACHINE, _MACHINE_AT = Run.packer(*MACHINE)
_OF_METHOD: dict[Any, Any] = {
    Newton: Newton.packer("derivative", "c"),
    Series: Series.packer("coefficients", "bends", "c"),
}
"""What is written for a machine into the memory of a method (`dense_output.Rates.words_of_method`)."""


def most_events(m: int) -> int:
    """Maximum number of events of ``m`` event functions in one window of a step.

    Between two points each function gives at most two, and each point can be a zero.
    """
    return 3 * (PARTS + 2) * m


def memory(method: str, n: int, m: int = 0) -> tuple[Run, Any]:
    """Return the memory of a run with ``n`` components and ``m`` event functions, and that of its method."""
    run = Run.made(**sizes(n, m))
    return run, own_memory(method, run)


def sizes(n: int, m: int) -> dict[str, int]:
    """Return the sizes of the rows of `Run`."""
    return {"n": n, "width": padded(n), "count": m, "columns": padded(m + 1), "zeros": most_events(m)}


def own_memory(method: str, run: Run) -> Any:
    """Return the memory of a method for a run; None if it has none."""
    n, width = run.n, run.width
    own: Any = None
    if method in ("gauss", "crossing"):
        own = Collocation.made(S=8, n=n, v=width)
        own.z, own.z_new = run.y, run.y_new
    elif method == "structure":
        own = Hamiltonian.made(S=3, v=2 * width)
        own.collocation.z, own.collocation.z_new = own.z, own.z_new
    elif method == "radau":
        own = Newton.made(n=n, width=width, pair_size=padded(2 * n))
    elif method == "taylor":
        own = Series.made(n=n, width=width)
    if own is not None:
        run.own = own.memory
    return own


def equip(run: Run, own: Any, rates: Any) -> None:
    """Write the rates of a machine into the memory of a run (`dense_output.Rates`)."""
    _MACHINE.pack_into(run.memory, run.begin + _MACHINE_AT, *rates.words)
    run.keep = rates
    if own is None:
        return
    if isinstance(own, Collocation):
        own.f, own.c, own.n = rates.address, rates.constants, run.n
    elif isinstance(own, Hamiltonian):
        stages = own.collocation
        stages.f, own.momenta, own.velocities, own.coordinates = rates.method_kernels
        stages.c, stages.n = rates.constants[rates.method_constants :], 2 * own.coordinates
    else:
        packed, place = _OF_METHOD[type(own)]
        packed.pack_into(own.memory, place, *rates.words_of_method)


def watch(
    search: Search,
    address: int,
    constants: Any,
    directions: Sequence[int],
    terminal: Sequence[Any],
    guarded: int = 0,
) -> None:
    """Write event functions into the memory of a search: those of a user, then ``guarded`` ones of the loop around it.

    Each of these ends the run where it falls through zero.
    """
    search.functions, search.c, search.guarded = address, constants, guarded
    search.directions[:] = [*directions, *[-1] * guarded]
    search.terminal[:] = [*terminal, *[1] * guarded]


def make_log(search: Search, piece: int, n: int) -> None:
    """Give a search room for the events of ``piece`` steps of n components."""
    size = piece + most_events(search.count) + 1
    search.log_times, search.log_states = np.empty(size), np.empty((size, n))
    search.log_numbers, search.log_signs = (np.empty(size, dtype=np.int64) for _ in range(2))


def make_rows(run: Run, piece: int) -> None:
    """Give a run room for ``piece`` steps, one after another in memory: times, lengths and states."""
    rows = piece + 1
    buffer = np.empty(rows * (2 + run.n))
    run.times, run.lengths = buffer[:rows], buffer[rows : 2 * rows]
    run.states = buffer[2 * rows :].reshape(rows, run.n)
