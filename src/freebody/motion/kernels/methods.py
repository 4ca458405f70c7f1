"""Choosing a method, and what each needs of the model.

    dop853      explicit, order 8(5,3), step control: smooth motions at tolerances of 1e-5 to 1e-13
    dop54       explicit, order 5(4), step control: coarse tolerances
    radau       implicit, order 5, step control: stiff machines
    gauss       Gauss collocation, order 16, step control, compensated sums: tolerances down to 1e-15
    structure   symplectic Gauss collocation, order 6, steps of one length: long runs without drift of the energy
    taylor      Taylor series of order 16, step control, compensated sums: small smooth machines, down to 1e-16
    timestepping    Moreau and Jean, order 1, steps of one length: many contacts (`timestepping`)
    auto        taylor for small machines at tolerances of 1e-7 and below, in a batch of 1e-6 and below; else gauss for
                tolerances below 1e-14; else dop853. Where stability and not accuracy makes the steps short, radau

Only what a run asks for is loaded or compiled.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import SimulationError, nearest
from ...native import loop
from ..ode.crossing import MOVED, ONTO, OWN, PLACES, RATES, ROOM, SIZE, TURNING
from ..ode.dense_output import FINISHED, INTERRUPTED, STIFF, Path, Rates
from ..ode.integration import FINEST_OF_SUMS, Halt, Integration, first_halt, integrate
from .kernels import Kernels, Program
from .switching_laws import sticking

METHODS = ("auto", "dop853", "dop54", "radau", "gauss", "taylor", "structure", "timestepping")


FINE = FINEST_OF_SUMS
"""Tolerances below it are left to compensated sums."""

BUDGET = 30_000
"""Of "auto": the errors of all steps of a run together are at most those of twice so many steps at the tolerance."""


ACCURATE = 1e-7
"""Tolerance from which on a series pays, at equal errors: the steps of order 8 are 1.2 times as many at 1e-5, and 1.15
times as many again for each digit more, and a step of the series takes 0.8 to 1.7 times as long."""

PRODUCTS = 150
"""Multiplications in the rates up to which it does: each becomes some sixteen. Measured in `docs/integrators.md`."""

ACCURATE_OF_EIGHT, PRODUCTS_OF_EIGHT = 1e-6, 60
"""The same of a batch, whose lanes go eight at a time, by series and by stages. Eight longer series do not fit into the
first level of the cache. At coarser tolerances, too, series are faster, but less exact than the stages."""

COMPARED = 256
"""Steps of "dop853" that are few, for what took the first piece of a run, 1024 steps, by the series."""

_BENT = frozenset(("abs", "sign", "min", "max", "sqrt", "pow", "asin", "acos", "atan2"))
"""Functions that bend, or may: √(x²), the length of a spring whose ends pass through each other, has the series x where
x > 0, which knows nothing of the bend ahead."""


def check_method(method: Any, step: Any) -> None:
    """Whether there is such a method, and whether it takes steps of a given length."""
    if not isinstance(method, str) or method not in METHODS:
        raise SimulationError(f"Unknown method {method!r}; {nearest(str(method), METHODS)}")
    if method == "timestepping":  # which asks for its step itself
        return
    if step is None:
        if method == "structure":
            raise SimulationError(
                'Expected the length of a step for method="structure", got none. Its steps have one length: pass '
                "step=, such as a fiftieth of the shortest period."
            )
        return
    if isinstance(step, bool) or not isinstance(step, int | float | np.floating) or not 0 < step < math.inf:
        raise SimulationError(f"Expected a length of steps greater than 0 s, got step={step!r}.")
    if method == "auto":
        raise SimulationError(
            f'Expected a method for steps of one length, got step={step!r} with method="auto". Name one '
            '("structure" keeps the energy), or give a tolerance in place of step=.'
        )


def check_method_of_contacts(method: str, step: Any) -> None:
    """Whether the phases between events of contacts can be integrated so."""
    allowed = ("auto", "dop853", "dop54", "gauss")
    if method not in allowed or step is not None:
        got = f"method={method!r}" if step is None else f"step={step!r}"
        raise SimulationError(
            f"Expected one of {', '.join(map(repr, allowed))}, with step control, for a machine with contacts, "
            f"got {got}."
            ' Steps of one length are those of method="timestepping".'
        )


class _Shortened(Exception):
    """The steps of a series are much shorter than those of an explicit method."""


class Way:
    """How runs from several starts are made: by a method, which "auto" may leave for another on the way.

    ``options`` are those that `Integration` takes besides.
    """

    def __init__(
        self, kernels: Kernels, parameters: NDArray[np.float64], method: str, rates: Rates,
        relative: NDArray[np.float64], **options: Any,
    ) -> None:  # fmt: skip
        self.kernels, self.parameters, self.rates = kernels, parameters, rates
        self.options = {"relative": relative, **options}
        finest = _finest(relative)
        self.turns = method == "auto" and finest >= FINE
        self.stuck = sticking(kernels, parameters)
        self.first = self.by(_of_accuracy(kernels, finest) if method == "auto" else method)

    def by(self, method: str, turns: bool | None = None) -> Integration:
        """The integration by a method."""
        equipped = _equipped(self.kernels, self.parameters, method, self.rates)
        if self.turns if turns is None else turns:
            return Integration(equipped, method=method, until_stiff=True, budget=BUDGET, **self.options)
        return Integration(equipped, method=method, **self.options)

    def _compared(
        self, state: Any, start: float, absolute: ArrayLike, between: Callable[[float], None] | None
    ) -> Callable[[float], None]:
        """``between`` for a run by series, which sees once whether its steps are shortened by round-off.

        A rotor that is driven, or symmetric, turns many times in a step that its slow precession allows. The angle, and
        what is in body axes, cancels from the rates but for round-off, of which the terms of the series grow as those
        of the turning do.
        """
        seen = False

        def look(t: float) -> None:
            nonlocal seen
            if not seen:
                seen = True
                alone = {**self.options, "absolute": absolute, "max_steps": COMPARED, "watch": None}
                other = integrate(self.rates, state, start, t, method="dop853", **alone)
                if other.status == INTERRUPTED:
                    raise KeyboardInterrupt
                if other.status == FINISHED:
                    raise _Shortened
            if between is not None:
                between(t)

        return look

    def path(
        self, state: Sequence[float] | NDArray[np.float64], start: float, until: float, absolute: ArrayLike,
        between: Callable[[float], None] | None = None, halt: Halt | None = None,
    ) -> Path:  # fmt: skip
        """`integrate`."""
        halt, seen = first_halt(halt, self.stuck), between
        if self.turns and self.first.method == "taylor" and halt is None:
            seen = self._compared(state, start, absolute, between)
        try:
            path = self.first.path(state, start, until, absolute, seen, halt)
        except _Shortened:
            path = self.by("dop853").path(state, start, until, absolute, between, halt)
        if path.status != STIFF or not self.turns:
            return path
        # from the start again: a path is of one method, and the little that was done tells nothing
        return self.by("radau", turns=False).path(state, start, until, absolute, between, halt)


def first_method(kernels: Kernels, method: str, relative: NDArray[np.float64], batch: bool = False) -> str:
    """What a run begins with, or every lane of a batch."""
    return _of_accuracy(kernels, _finest(relative), batch) if method == "auto" else method


def _of_accuracy(kernels: Kernels, finest: float, batch: bool = False) -> str:
    accurate, products = (ACCURATE_OF_EIGHT, PRODUCTS_OF_EIGHT) if batch else (ACCURATE, PRODUCTS)
    if finest <= accurate and _has_short_series(kernels, products):
        return "taylor"
    return "gauss" if finest < FINE else "dop853"


def _finest(relative: NDArray[np.float64]) -> float:
    return min(relative.ravel().tolist(), default=1.0)


def _has_short_series(kernels: Kernels, products: int) -> bool:
    """Whether the series of a motion costs less than the stages of an explicit method, as its rates tell."""
    model = kernels.model
    if model.contacts or model.switched or not kernels.size:
        return False  # a phase between two events, or between two samples, is short
    operations = kernels.operations
    return operations is not None and operations.get("mul", 0) <= products and not may_bend(kernels)


def _equipped(kernels: Kernels, parameters: NDArray[np.float64], method: str, rates: Rates) -> Rates:
    """The rates with the other kernels that a method calls."""
    if method not in rates.equipped:
        made = _with_others(kernels, parameters, method, rates)
        if made is not rates:
            made = replace(made, recipe=(made_by, kernels, parameters, method))
        rates.equipped[method] = made
    return rates.equipped[method]


def made_by(kernels: Kernels, parameters: NDArray[np.float64], method: str) -> Rates:
    """The rates of a path by a method."""
    return _equipped(kernels, parameters, method, kernels.rates(parameters))


def _with_others(kernels: Kernels, parameters: NDArray[np.float64], method: str, rates: Rates) -> Rates:
    if method == "radau":
        from .method_kernels import tangent

        return with_others(rates, tangent(kernels), parameters, ("tangent",))
    if method == "taylor":
        from .method_kernels import series

        return with_series(rates, series(kernels), parameters, kernels)
    if method == "crossing":
        return _along_branch(rates)
    if method == "structure":
        from .method_kernels import hamilton

        _check_hamiltonian(kernels)
        return with_others(
            rates, hamilton(kernels), parameters, ("hamilton", "momenta", "speeds"), kernels.model.n_q
        )
    return rates


def with_others(
    rates: Rates, program: Program, parameters: NDArray[np.float64], names: tuple[str, ...], *more: int
) -> Rates:
    """The rates with functions of another program beside them, and numbers that the method reads there."""
    constants = program.constants(parameters)
    return replace(
        rates,
        constants=np.concatenate([rates.constants, constants]),
        keep=(rates.keep, program),
        others=(*map(program.address, names), *more),
        others_constants=rates.constants.size,
    )


def with_series(rates: Rates, program: Program, parameters: NDArray[np.float64], kernels: Kernels) -> Rates:
    """The rates with the coefficients of their series, and whether these may go on behind a bend."""
    return with_others(rates, program, parameters, ("series",), int(may_bend(kernels)))


def _along_branch(rates: Rates) -> Rates:
    """f(P(y)) of the rates f and their projection P (`crossing`)."""
    n = rates.size
    room = np.zeros(2 * n)
    function = loop.code("motion.ode.crossing", "along_branch")
    constants = np.zeros(OWN + rates.constants.size)
    constants[RATES], constants[ONTO], constants[SIZE] = rates.address, rates.projection, n
    constants[MOVED], constants[TURNING] = rates.projected, len(rates.quaternions)
    constants[PLACES], constants[ROOM] = loop.address(rates.corrections), loop.address(room)
    constants[OWN:] = rates.constants
    address = ctypes.cast(function.code, ctypes.c_void_p).value
    assert address is not None
    keep = rates, room, function
    return replace(rates, address=address, constants=constants, keep=keep, projection=0, projected=0)


def may_bend(kernels: Kernels) -> bool:
    """Whether there is a function in the rates that bends or may, or whose functions are not known."""
    return kernels.operations is None or not _BENT.isdisjoint(kernels.operations)


def _check_hamiltonian(kernels: Kernels) -> None:
    """Whether the motion has a structure to preserve, in coordinates that are free."""
    model = kernels.model
    if model.constraints:
        raise SimulationError(
            f"Expected a machine without constraints for method=\"structure\", but '{model.name}' has "
            f'{", ".join(map(repr, model.constraints))}. Use method="gauss", which projects onto them.'
        )
    if kernels.works:
        raise SimulationError(
            f"Expected a machine whose energy is constant for method=\"structure\", but on '{model.name}' loads "
            'without potential or drives do work. Leave them out, or use method="gauss".'
        )
