"""The choice of a method, and the kernels that each method needs.

    dop853      explicit, order 8(5,3), step-size control: smooth motions at tolerances of 1e-5 to 1e-13
    dop54, tsit5   explicit, order 5(4), step-size control: coarse tolerances
    radau       implicit, order 5, step-size control: stiff machines
    gauss       Gauss collocation, order 16, step-size control, compensated sums: tolerances down to 1e-15
    structure   symplectic Gauss collocation, order 6, equal steps: long runs without drift of the energy
    taylor      Taylor series of order 16, step-size control, compensated sums: small smooth machines, down to 1e-16
    timestepping    Moreau and Jean, order 1, equal steps: many contacts (`timestepping`)
    auto        taylor for small machines at tolerances of 1e-7 and below, in a batch at 1e-6 and below; else gauss for
                tolerances below 1e-14; else dop853; radau if stability, not accuracy, makes the steps short

Only the method that a run uses is loaded or compiled.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import entry_points
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import SimulationError, nearest
from ...native import loop
from ..ending import End
from ..ode.dense_output import Path, Rates
from ..ode.integration import FINEST_OF_SUMS, Halt, Integration
from ..ode.layout import EXPLICIT, ORDERS, SINGLE_STEPS
from ..ode.run import Branch
from .kernels import Kernels
from .program import Program


def methods() -> tuple[str, ...]:
    """Return the names of all methods that `simulate` takes."""
    return ("auto", *(name for name in ORDERS if name not in SINGLE_STEPS), "timestepping")


def _is_method(name: Any) -> bool:
    """Return True for one of `methods`; a tuple of them for each short run takes longer than its steps."""
    if not isinstance(name, str):
        return False
    return name in ("auto", "timestepping") or name in ORDERS and name not in SINGLE_STEPS


FINE = FINEST_OF_SUMS
"""Tolerance below which only methods with compensated sums are chosen."""

BUDGET = 30_000
"""Steps after which "auto" tightens the tolerances of a long run. The errors of all its steps together then stay within
those of twice as many steps at the tolerance."""


ACCURATE = 1e-7
"""Tolerance from which a series is faster at equal errors. The number of steps of order 8 is 1.2 times that of the
series at 1e-5, and grows by a factor of 1.15 per digit. A step of the series takes 0.8 to 1.7 times as long."""

PRODUCTS = 150
"""Number of multiplications in the rates up to which a series is faster. A series needs about sixteen for each.
Measured in `docs/integrators.md`."""

ACCURATE_OF_EIGHT, PRODUCTS_OF_EIGHT = 1e-6, 60
"""The same two bounds for a batch, in which both series and stages are computed for eight lanes at a time. Eight longer
series do not fit into the first-level cache. At coarser tolerances series are faster, too, but less accurate than the
stages."""

COMPARED = 256
"""Number of steps within which "dop853" must cover the first 1024 steps of the series to replace it."""

_BENT = frozenset(("abs", "sign", "min", "max", "sqrt", "pow", "asin", "acos", "atan2"))
"""Functions that bend, or may bend. √(x²), the length of a spring whose ends pass through each other, has the series x
for x > 0, and this series does not show the bend ahead."""


def check_method(method: Any, step: Any) -> None:
    """Raise SimulationError if the method does not exist, or does not take steps of this length."""
    if isinstance(method, str) and not _is_method(method):
        _import(method)
    if not _is_method(method):
        raise SimulationError(
            f"Unknown method {method!r}; {nearest(str(method), methods())} Import the module that defines it as "
            f"fb.RungeKutta({method!r}, ...), before it is used."
        )
    if method == "timestepping":  # checks its step itself
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


def check_method_of_phases(method: str, step: Any, what: str = "") -> None:
    """Raise SimulationError if the phases between events cannot be integrated by this method."""
    allowed = ("auto", *EXPLICIT, "gauss", "radau")
    if method not in allowed or step is not None:
        got = f"method={method!r}" if step is None else f"step={step!r}"
        cure = "" if what else ' Steps of one length are those of method="timestepping".'
        raise SimulationError(
            f"Expected one of {', '.join(map(repr, allowed))}, with step control, for "
            f"{what or 'a machine with contacts'}, got {got}.{cure}"
        )


def _import(method: str) -> None:
    """Import a method that an installed package names by an entry point ``freebody.kinds``."""
    for entry in entry_points(group="freebody.kinds", name=method):
        try:
            entry.load()
        except Exception as error:
            raise SimulationError(
                f"The method {method!r} is that of the package {getattr(entry.dist, 'name', '')!r}, whose "
                f"{entry.value} cannot be imported: {type(error).__name__}: {error}. Repair or remove the package."
            ) from None


class _Shortened(Exception):
    """The steps of a series are much shorter than those of an explicit method."""


class Way:
    """The method and options of runs from several initial states. "auto" may change the method during a run.

    ``options`` are further arguments of `Integration`.
    """

    def __init__(
        self, kernels: Kernels, parameters: NDArray[np.float64], method: str, rates: Rates,
        relative: NDArray[np.float64], **options: Any,
    ) -> None:  # fmt: skip
        self.kernels, self.parameters, self.rates = kernels, parameters, rates
        self.options = {"relative": relative, **options}
        finest = _finest(relative)
        self.may_change = method == "auto" and finest >= FINE
        self.first = self.by(_of_accuracy(kernels, finest) if method == "auto" else method)

    def by(self, method: str, may_change: bool | None = None) -> Integration:
        """Return the integration by a method."""
        equipped = _equipped(self.kernels, self.parameters, method, self.rates)
        if self.may_change if may_change is None else may_change:
            return Integration(equipped, method=method, until_stiff=True, budget=BUDGET, **self.options)
        return Integration(equipped, method=method, **self.options)

    def _compared(
        self, state: Any, start: float, absolute: ArrayLike, between: Callable[[float], None] | None
    ) -> Callable[[float], None] | None:
        """Return ``between`` for a run by series, with one check whether round-off shortens the steps.

        A driven or symmetric rotor turns many times in a step that its slow precession allows. The angle, and the
        quantities in body axes, cancel from the rates except for round-off. In the terms of the series this round-off
        grows as the terms of the rotation do.
        """
        compared = False

        def look(t: float) -> None:
            nonlocal compared
            if not compared:
                compared = True
                options = {**self.options, "max_steps": COMPARED, "watch": None}
                explicit = Integration(self.rates, method="dop853", **options).path(state, start, t, absolute)
                if explicit.status == End.INTERRUPTED:
                    raise KeyboardInterrupt
                if explicit.status == End.FINISHED:
                    raise _Shortened
            if between is not None:
                between(t)

        return look

    def path(
        self, state: Sequence[float] | NDArray[np.float64], start: float, until: float, absolute: ArrayLike,
        between: Callable[[float], None] | None = None, halt: Halt | None = None,
    ) -> Path:  # fmt: skip
        """Return the path of one run (`Integration.path`)."""
        callback = between
        if self.may_change and self.first.method == "taylor" and halt is None:
            callback = self._compared(state, start, absolute, between)
        try:
            path = self.first.path(state, start, until, absolute, callback, halt)
        except _Shortened:
            path = self.by("dop853").path(state, start, until, absolute, between, halt)
        if path.status != End.STIFF or not self.may_change:
            return path
        # start again: a path has one method, and few steps are lost
        return self.by("radau", may_change=False).path(state, start, until, absolute, between, halt)

    def paths(self, *arguments: Any) -> list[Path]:
        """Return the path of one run, in one leg (`path`); a run with laws that switch has several (`SidedWay`)."""
        return [self.path(*arguments)]


def first_method(kernels: Kernels, method: str, relative: NDArray[np.float64], batch: bool = False) -> str:
    """Return the method that a run, or every lane of a batch, begins with."""
    return _of_accuracy(kernels, _finest(relative), batch) if method == "auto" else method


def _of_accuracy(kernels: Kernels, finest: float, batch: bool = False) -> str:
    accurate, products = (ACCURATE_OF_EIGHT, PRODUCTS_OF_EIGHT) if batch else (ACCURATE, PRODUCTS)
    if finest <= accurate and _has_short_series(kernels, products):
        return "taylor"
    return "gauss" if finest < FINE else "dop853"


def _finest(relative: NDArray[np.float64]) -> float:
    return min(relative.ravel().tolist(), default=1.0)


def _has_short_series(kernels: Kernels, products: int) -> bool:
    """Return True if, by the operation counts of the rates, a series costs less than the stages of an explicit
    method.
    """
    model = kernels.model
    if model.contacts or model.switched or not kernels.size:
        return False  # the phases between events or controller samples are short
    operations = kernels.operations
    return operations is not None and operations.get("mul", 0) <= products and not may_bend(kernels)


def _equipped(kernels: Kernels, parameters: NDArray[np.float64], method: str, rates: Rates) -> Rates:
    """Return the rates with the further kernels that a method calls."""
    if method in rates.equipped:
        return rates.equipped[method]
    with_kernels = _with_method_kernels(kernels, parameters, method, rates)
    if with_kernels is not rates:
        with_kernels = replace(with_kernels, recipe=(made_by, kernels, parameters, method))
    if method != "crossing":  # it writes to memory of its own, which lanes in several threads must not share
        rates.equipped[method] = with_kernels
    return with_kernels


def made_by(kernels: Kernels, parameters: NDArray[np.float64], method: str) -> Rates:
    """Return the rates of a path by a method."""
    return _equipped(kernels, parameters, method, kernels.rates(parameters))


def _with_method_kernels(
    kernels: Kernels, parameters: NDArray[np.float64], method: str, rates: Rates
) -> Rates:
    if method == "radau":
        from .method_kernels import tangent

        return with_program(rates, tangent(kernels), parameters, ("tangent",))
    if method == "taylor":
        from .method_kernels import series

        return with_series(rates, series(kernels), parameters, kernels)
    if method == "crossing":
        return _along_branch(rates)
    if method == "structure":
        from .method_kernels import hamilton

        _check_hamiltonian(kernels)
        return with_program(
            rates, hamilton(kernels), parameters, ("hamilton", "momenta", "speeds"), kernels.model.n_q
        )
    return rates


def with_program(
    rates: Rates, program: Program, parameters: NDArray[np.float64], names: tuple[str, ...], *more: int
) -> Rates:
    """Return the rates with functions of a second program, and with numbers that the method reads after their
    addresses.
    """
    constants = program.constants(parameters)
    return replace(
        rates,
        constants=np.concatenate([rates.constants, constants]),
        keep=(rates.keep, program),
        method_kernels=(*map(program.address, names), *more),
        method_constants=rates.constants.size,
    )


def with_series(rates: Rates, program: Program, parameters: NDArray[np.float64], kernels: Kernels) -> Rates:
    """Return the rates with the coefficients of their series and a flag: 1 if the series may continue past a bend."""
    return with_program(rates, program, parameters, ("series",), int(may_bend(kernels)))


def _along_branch(rates: Rates) -> Rates:
    """Return f(P(y)) of the rates f and their projection P (`crossing`)."""
    branch = Branch.made(n=rates.size, n_quaternions=len(rates.quaternions), n_constants=rates.constants.size)
    branch.rates, branch.projection, branch.projected = rates.address, rates.projection, rates.projected
    branch.quaternions[:], branch.c[:] = rates.quaternions, rates.constants
    function = loop.code("motion.ode.crossing", "along_branch")
    address = ctypes.cast(function.code, ctypes.c_void_p).value
    assert address is not None
    keep = rates, branch, function
    return replace(rates, address=address, constants=branch.memory, keep=keep, projection=0, projected=0)


def may_bend(kernels: Kernels) -> bool:
    """Return True if a function in the rates bends or may bend, or if the functions are unknown."""
    return kernels.operations is None or not _BENT.isdisjoint(kernels.operations)


def _check_hamiltonian(kernels: Kernels) -> None:
    """Raise SimulationError unless the machine has independent coordinates and constant energy."""
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
