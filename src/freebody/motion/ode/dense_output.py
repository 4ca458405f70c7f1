"""The computed path of a state through time, and its values between the steps."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import SimulationError
from ...native.loop import passed
from ...native.records import address
from ..ending import End
from . import loops
from .layout import ITERATED
from .memory import equip, memory

Array = NDArray[np.float64]
_POINTER = ctypes.c_void_p
_KERNEL = ctypes.CFUNCTYPE(None, ctypes.c_double, _POINTER, _POINTER, _POINTER)


@dataclass(frozen=True)
class Rates:
    """The right-hand side y' = f(t, y, c) as machine code, with the constants it is called with.

    ``address``           of ``void f(double t, const double *y, const double *c, double *out)``
    ``size``              number of components of y
    ``constants``         c
    ``quaternions``       indices in y at which a unit quaternion (four components) begins
    ``keep``              the owner of the machine code
    ``projection``        address of the kernel that moves a state onto the constraints, with the same constants, or 0
    ``projected``         number of its outputs: the first components of y
    ``method_kernels``    addresses of further kernels of a method (`radau`: f'(y) v of (y, v); `structure`: Hamilton's
                          equations; `taylor`: the coefficients of the motion)
    ``method_constants``  offset of their constants in ``constants``
    ``recipe``            a function and its arguments that make the same rates in another process
    ``equipped``          cache: these rates with the further kernels of a method, by name of the method
    ``ways``              cache: the ways of runs by these rates (`kernels.methods.Way`), by their options
    """

    address: int
    size: int
    constants: Array
    quaternions: tuple[int, ...] = ()
    keep: Any = None
    projection: int = 0
    projected: int = 0
    method_kernels: tuple[int, ...] = ()
    method_constants: int = 0
    recipe: tuple[Any, ...] = field(default=(), repr=False, compare=False)
    equipped: dict[str, Rates] = field(default_factory=dict, init=False, repr=False, compare=False)
    ways: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __deepcopy__(self, memo: Any) -> Rates:
        return self  # code and constants never change

    @cached_property
    def words(self) -> tuple[int, ...]:
        """What the compiled loop reads of the rates, in the order of `memory.MACHINE`."""
        indices = self.indices
        return (
            self.address, self.constants_at, address(indices), indices.size, self.projection, self.projected
        )  # fmt: skip

    @cached_property
    def words_of_method(self) -> tuple[int, ...]:
        """The further kernels of a method, and the address of their constants."""
        return *self.method_kernels, self.constants_at + self.constants.itemsize * self.method_constants

    @cached_property
    def constants_at(self) -> int:
        """Address of the constants."""
        return passed(self.constants, "Reals") or 0

    def at(self, t: float, y: Array) -> Array:
        """Return y' at one state."""
        row = np.ascontiguousarray(y, dtype=float)
        return outputs_at(self.address, self.size, t, row, self.constants)

    def along(self, times: Array, states: Array) -> Array:
        """Return y' at each of the times and states."""
        return observe(self.address, self.size, times, states, self.constants)

    @cached_property
    def indices(self) -> NDArray[np.int64]:
        """Indices of the quaternions, as the compiled loop reads them."""
        return np.array(self.quaternions, dtype=np.int64)


@dataclass(frozen=True)
class Watch:
    """Event functions g(t, y, c) as machine code; for each a direction, -1, 0 or +1, and whether it is terminal.

    If ``constants`` is None, they are those of the rates. The run stops if a function has no value, except the last
    ones, so many as ``guarded``: a step is taken again where the run has no such zero, but its dense output has one.
    ``functions`` are what the machine code computes.
    """

    address: int
    directions: tuple[int, ...]
    terminal: tuple[bool, ...]
    constants: Array | None = None
    keep: Any = None
    guarded: int = 0
    functions: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Crossing:
    """A located zero of event function ``number``; ``sign`` is the sign of the function just after the zero."""

    time: float
    number: int
    sign: int
    state: Array


@dataclass(eq=False)  # not frozen: freezing costs the time of five steps of a small machine
class Path:
    """States of a run, one per accepted step, and the dense output between them.

    ``times`` (m + 1) and ``states`` (m + 1, n) hold the starts of the m steps and the end of the run. ``lengths`` (m)
    are the steps that the integrator took; the last may reach beyond a terminal event. ``blame`` is the index of the
    cause of a failed run: of an event function for the status UNDEFINED, of a law (`sides`) for STUCK, else of a
    component. ``method``, ``relative`` and ``absolute`` are the method and tolerances of the steps. ``stiff`` counts
    the steps that the stability of an explicit method limited. ``step`` is the memory of a method of
    `layout.SINGLE_STEPS` with its step, from which its states are sampled. ``legs`` are those that
    `Integration.drive` tells of a run with other rates in each.
    """

    rates: Rates
    times: Array
    lengths: Array
    states: Array
    crossings: tuple[Crossing, ...]
    status: End
    blame: int
    rejected: int
    evaluations: int
    method: str = "dop853"
    relative: ArrayLike | None = None
    absolute: ArrayLike | None = None
    stiff: int = 0
    step: Any = field(default=None, repr=False)
    legs: ClassVar[Any] = None
    curved: ClassVar[bool] = True  # False: straight between the ends of steps

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the path without machine code. Another process compiles it when values between steps are needed."""
        state = dict(self.__dict__)
        rates, state["step"] = state.pop("rates", None), None
        return {"_recipe": rates.recipe, **state} if rates is not None else state

    def __getattr__(self, name: str) -> Any:
        if name != "rates" or "_recipe" not in self.__dict__:
            raise AttributeError(f"'{type(self).__name__}' has no '{name}'.")
        make, *arguments = self._recipe
        self.rates = make(*arguments)
        return self.rates

    @property
    def start(self) -> float:
        """Time of the first state [s]."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """Time of the last state [s]."""
        return float(self.times[-1])

    @property
    def steps(self) -> int:
        """Number of accepted steps."""
        return self.lengths.size

    def sample(self, times: ArrayLike, dense: bool = False) -> Array:
        """Return the states, shape (k, n), at ``times``, shape (k,), each between the start and the end of the run.

        Each state costs one step and is as accurate as the steps. With ``dense`` the states come from the dense output,
        of order 6 for "dop853": less accurate, but faster if many times lie in one step.

        Raises
        ------
        ValueError           a time outside the run
        SimulationError      the iteration of the method does not converge for the shorter step that ends at a time
        """
        moments = np.atleast_1d(np.ascontiguousarray(times, dtype=float))
        if ((moments == self.start) | (moments == self.end)).all():  # needs no code
            return self.states[np.where(moments == self.start, 0, -1)]
        return Sampler(self, dense)(moments)


class Sampler:
    """States between the steps of a path (:meth:`Path.sample`), with the memory of the last step that it looked into.

    Many calls for one step cost that step once, if the states come from its dense output.
    """

    def __init__(self, path: Path, dense: bool = False) -> None:
        self.path, self.dense = path, dense
        self.run, self.own = run, own = memory(path.method, path.rates.size)
        equip(run, own, path.rates)
        run.relative[:] = 1.0 if path.relative is None else path.relative
        run.absolute[:] = 1.0 if path.absolute is None else path.absolute
        run.times, run.lengths, run.states = path.times, path.lengths, path.states
        if path.step is not None:
            own.take(path.step)
            run.y[: path.rates.size] = path.states[0]
            run.sampled = 1

    def __call__(self, times: ArrayLike) -> Array:
        """Return the states, shape (k, n), at ``times``, shape (k,)."""
        path, moments = self.path, within(self.path, times)
        result = np.empty((moments.size, path.rates.size))
        loops.sample(path.method, self.run, path.steps, int(self.dense), moments.size, moments, result)
        diverged = ~np.isfinite(result).all(axis=1)
        if diverged.any():  # the states of the run itself are all finite
            raise self._no_state(float(moments[diverged][0]))
        return result

    def _no_state(self, t: float) -> SimulationError:
        """Return the error for a time at which a step has no end."""
        path = self.path
        if path.method in ITERATED:
            return SimulationError(
                f"The iteration of method {path.method!r} does not converge for a step that ends at t = {t:g}. Shorter "
                "steps do: pass a smaller max_step=, step= or tolerance=, or times= at the steps; where bars come into "
                "line, take method='auto'."
            )
        k = int(np.abs(path.times - t).argmin())
        near = path.times[max(k - 1, 0) : k + 2]
        before, after = near[near <= t].max(), near[near >= t].min()
        return SimulationError(
            f"The rates are not finite at t = {t:.9g} s, between the steps of the run at {before:.9g} and {after:.9g} "
            "s, which passed over it: a division by zero, or a root of a negative number. Look there, pass a smaller "
            "max_step= or tolerance= so that the run meets it, or ask for times= at its steps."
        )


def within(path: Any, times: ArrayLike) -> Array:
    """Return the times as an array; raise if one of them is outside the run."""
    moments = np.atleast_1d(np.ascontiguousarray(times, dtype=float))
    first, last = sorted((path.start, path.end))
    outside = ~((moments >= first) & (moments <= last))
    if outside.any():
        raise ValueError(
            f"Expected times within the run, {first:g} to {last:g}; got {moments[outside][0]}. "
            "Ask for a time inside, or simulate further."
        )
    return moments


def cut(path: Path, k: int, status: End) -> Path:
    """Return the first ``k`` steps of a path."""
    direction = 1.0 if path.end >= path.start else -1.0
    crossings = (crossing for crossing in path.crossings if (path.times[k] - crossing.time) * direction >= 0)
    times, lengths, states = path.times[: k + 1], path.lengths[:k], path.states[: k + 1]
    return replace(
        path, times=times, lengths=lengths, states=states, crossings=tuple(crossings), status=status
    )


def projected(rates: Rates, t: float, y: Array) -> Array:
    """Return a state near the constraints, moved onto them."""
    result = y.copy()
    if rates.projection:
        for _ in range(3):
            result[: rates.projected] = outputs_at(
                rates.projection, rates.projected, t, result, rates.constants
            )
            for i in rates.quaternions:
                result[i : i + 4] /= np.linalg.norm(result[i : i + 4])
    return result


def outputs_at(kernel: int, outputs: int, t: float, y: Array, constants: Array) -> Array:
    """Return the outputs of the kernel at an address at one state, a contiguous array."""
    result = np.zeros(outputs)
    if outputs:
        _KERNEL(kernel)(t, address(y), address(constants), address(result))
    return result


def observe(address: int, outputs: int, times: Array, states: Array, constants: Array) -> Array:
    """Return the outputs, shape (k, outputs), of the kernel at ``address`` at each of the k times and states."""
    result = np.zeros((times.size, outputs))
    if outputs:
        moments, flat = np.ascontiguousarray(times, dtype=float), np.ascontiguousarray(states, dtype=float)
        loops.observe(address, moments.size, moments, flat, flat.shape[1], constants, result, outputs)
    return result
