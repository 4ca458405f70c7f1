"""Products of a model as functions of numbers: compiled at the first call, then called by their addresses."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ModelError
from ..model import Model
from .arguments import (
    NUMBERS,
    Array,
    Assumption,
    assumptions,
    call_of,
    check_parameters,
    checked,
    is_plain,
    of_list,
    parameters_by_name,
    signals_at,
)
from .entry import python_entry
from .kernel import Kernel, KernelSet
from .large.tree_loop import LoopedKernel, LoopedSet, looped_kernel
from .products import (
    Product,
    check_conditions,
    compiled,
    product_named,
    recording,
)

Values: TypeAlias = Mapping[Any, Any] | None
"""Values of parameters by name or symbol."""
_REMEMBERED = 8  # sets of parameters whose hoisted constants are kept

_Shortcut: TypeAlias = tuple[Kernel, Array | None, tuple[tuple[int, ...], ...], tuple[int, ...]]
"""Kernel, its constants for default parameters (None for others), shapes of the parts of a state and of the result."""

_Method = TypeVar("_Method", bound=Callable[..., Any])

_ENTERED: set[str] = set()
"""Products whose plain calls take an entry of their kernel."""


def entered(method: _Method) -> _Method:
    """Let an entry of the product's kernel stand in place of its method after two calls (`entry`)."""
    _ENTERED.add(method.__name__)
    return method


class Evaluation:
    """Products of one model, compiled and called; the base of :class:`Program`."""

    def __init__(self, model: Model, threads: int = 1, active: tuple[int, ...] | None = None) -> None:
        self.model = model
        self.threads = threads
        self._active = active
        self._assumptions: tuple[Assumption, ...] | None = None
        self._large: dict[str, LoopedSet] = {}
        self._sets: dict[Any, tuple[KernelSet | LoopedKernel, bool]] = {}
        self._constants: dict[Any, OrderedDict[Any, Array]] = {}
        self._timed: dict[Any, bool] = {}  # products that depend on time
        self._shortcuts: tuple[dict[Any, _Shortcut], dict[Any, _Shortcut]] = (
            {},
            {},
        )  # of one state, of a batch

    def __reduce__(self) -> Any:
        """Pickle without compiled code: another process, or a copy, compiles or loads each function."""
        return type(self), (self.model, self.threads, self._active)

    def __repr__(self) -> str:
        """Return the model and the names of the products compiled so far."""
        return (
            f"Program of {self.model!r}; compiled so far: {', '.join(map(_title, self._sets)) or 'nothing'}"
        )

    def kernel(self, name: str, batch: bool = False) -> Kernel:
        """Return the machine code of a product (``"forward_dynamics"``, ...), for callers that use addresses.

        The state y of the kernel holds the product's inputs in their order: q, u, u' or forces.
        """
        kernels = self._compiled(name, product_named(self.model, name), batch)
        return kernels.of_rows(shared=False) if batch and isinstance(kernels, LoopedKernel) else kernels["f"]

    def constants(self, name: str = "forward_dynamics", values: Values = None, **named: Any) -> Array:
        """Return the vector c for the kernel of a product at these values of the parameters."""
        parameters = parameters_by_name(self.model, values, named)
        kernels = self._compiled(name, product_named(self.model, name), False)
        return self._hoisted(name, kernels, parameters).copy()

    def describe(self, *names: str) -> str:
        """Report operations, size and compile time of products, a line each; by default of all compiled so far.

        The first count is that of the operations for one state, the second that of the operations done once per set of
        parameters. The size is that of the object code, including its batch form if there is one. The time is that of
        compiling the recorded program; ``from the disk`` means that an earlier process spent it.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("pendulum")
        >>> m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
        >>> s.gravity = (0, -g, 0)
        >>> pin = s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), axis="z")
        >>> print(fb.compile(s).describe("forward_dynamics"))
        forward_dynamics: 2 operations (1 mul, 1 sincos); ... once per parameters; ... kB, compiled in ... ms...
        """
        for name in names:
            self.kernel(name)
        chosen = names or tuple(self._sets) or ("forward_dynamics",)
        lines = []
        for name in chosen:
            if name not in self._sets:
                self.kernel(name)
            kernels = self._sets[name][0]
            operations = kernels.operations
            once = sum(operations["parameters"].values())
            parts = ", ".join(f"{count} {code}" for code, count in operations["f"].items())
            total = sum(operations["f"].values())
            lines.append(
                f"{_title(name)}: {total} operations ({parts or 'none'}); {once} once per parameters; "
                f"{kernels.size / 1e3:.1f} kB, compiled in {kernels.seconds * 1e3:.0f} ms"
                f"{' (from the disk)' if kernels.from_disk else ''}{kernels.remark}"
            )
        return "\n".join(lines)

    def _compiled(self, key: Any, product: Product, batch: bool) -> KernelSet | LoopedKernel:
        """Return the kernels of a product, compiled if they or their batch form are missing."""
        entry = self._sets.get(key)
        if entry is None or (batch and not entry[1]):
            if product.moves:
                check_conditions(self.model, self._active)
            looped = looped_kernel(
                self.model, key, product, self._large
            )  # of a large tree: with its batch form
            if looped is not None:
                entry = (looped, True)
            else:
                entry = (compiled(self.model, product, batch, self._active), batch)
            self._sets[key] = entry
            self._constants.pop(key, None)
            vars(self).pop(key, None)
            for shortcuts in self._shortcuts:
                shortcuts.pop(key, None)
        return entry[0]

    def _run(
        self,
        key: Any,
        arguments: Mapping[str, ArrayLike],
        t: ArrayLike,
        values: Values,
        named: Mapping[str, Any],
        product: Product | None = None,
    ) -> Any:
        """Evaluate a product; the result has its shape."""
        parameters = parameters_by_name(self.model, values, named)
        state = tuple(map(of_list, arguments.values()))
        batch = type(state[0]) is np.ndarray and state[0].ndim == 2
        shortcut = self._shortcuts[batch].get(key) if type(t) is float else None
        if shortcut is not None:
            kernel, c, widths, shape = shortcut
            shapes = [state[0].shape[:1] + width for width in widths] if batch else widths
            if all(map(is_plain, state, shapes)) and NUMBERS.issuperset(map(type, parameters.values())):
                # the most common calls take a third of the time
                if c is None or parameters:
                    c = self._hoisted(key, self._sets[key][0], parameters)
                if batch:
                    out = kernel.batch_of_parts(t, state, c, threads=self.threads)
                    return out if len(shape) == 1 else out.reshape(len(out), *shape)
                if c is not None and not parameters and key in _ENTERED and key not in vars(self):
                    entry = python_entry(getattr(self, key), kernel, c, [len(x) for x in state], shape)
                    if entry is not None:
                        vars(self)[key] = entry  # in place of the method
                out = kernel.unchecked(t, state[0] if len(state) == 1 else np.concatenate(state), c)
                return out if len(shape) == 1 else out.reshape(shape) if shape else float(out[0])
        if self.model.signals:
            parameters = {**signals_at(self.model, t), **parameters}
        arrays, time, count = checked(self.model, arguments, t, parameters, key)
        if product is None:
            product = product_named(self.model, key)
        single = not any(x.ndim == 2 for x in arrays.values()) and not any(
            isinstance(x, np.ndarray) for x in parameters.values()
        )
        if single and time.ndim == 1 and not self.model.signals:
            self._check_times(key, product, arguments, len(time))
        program = self._compiled(key, product, count is not None)
        shape = product.shape(self.model)
        c = self._hoisted(key, program, parameters)
        kernel = program["f"]
        if isinstance(program, LoopedKernel) and count is not None:
            kernel = program.of_rows(shared=c.ndim == 1)
        if c.ndim == 1 and not self.model.signals:
            widths = tuple(x.shape[-1:] for x in arrays.values())
            self._shortcuts[count is not None][key] = (kernel, None if parameters else c, widths, shape)
        if count is None:
            out = kernel(float(time), np.concatenate(list(arrays.values())), c)
            return out.reshape(shape) if shape else float(out[0])
        parts = [x if x.ndim == 2 else np.broadcast_to(x, (count, len(x))) for x in arrays.values()]
        out = kernel.batch_of_parts(time, parts, c, threads=self.threads)
        return out.reshape(count, *shape)

    def _check_times(self, key: Any, product: Product, arguments: Mapping[str, Any], count: int) -> None:
        """Refuse several times for one state if nothing depends on time: what was meant is something else."""
        if key not in self._timed:
            r = recording(self.model, self._active)
            self._timed[key] = r.state.t.index in r.tape.used(product.record(r))
        if not self._timed[key]:
            raise ModelError(
                f"Expected a number as time t of one state, since nothing of '{self.model.name}' depends on time, "
                f"got {count} numbers.{call_of(key, arguments)}"
            )

    def _hoisted(self, key: Any, program: KernelSet | LoopedKernel, parameters: Mapping[str, Any]) -> Array:
        """Return the vector c, or one for each state; the last few are remembered."""
        remembered = self._constants.setdefault(key, OrderedDict())
        columns = {name: value for name, value in parameters.items() if isinstance(value, np.ndarray)}
        label: Any = None
        if not columns:
            if not NUMBERS.issuperset(map(type, parameters.values())):  # a text and a number may print alike
                parameters = self.model.values(parameters)
            label = tuple(sorted(parameters.items()))
            if label in remembered:
                remembered.move_to_end(label)
                return remembered[label]
        single = {name: value for name, value in parameters.items() if name not in columns}
        numbers = self.model.values({**single, **{name: 0 for name in columns}})
        if self._assumptions is None:
            self._assumptions = assumptions(self.model)
        check_parameters(self.model, self._assumptions, columns, numbers)
        if not columns:
            c = remembered[label] = program.constants([*numbers.values()])
            while len(remembered) > _REMEMBERED:
                remembered.popitem(last=False)
            return c
        count = len(next(iter(columns.values())))
        P = np.empty((count, len(numbers)))
        for k, (name, number) in enumerate(numbers.items()):
            P[:, k] = columns.get(name, number)
        return program.constants(P)


def _title(key: Any) -> str:
    if isinstance(key, str):
        return key
    return f"{key[0]} of {', '.join(map(str, key[1:]))}"
