"""Kernels in memory: how compiled functions are called, for one state and for rows of states.

    void f(double t, const double *y, const double *c, double *out)

is the signature of every kernel. y is the state. c holds the values that depend on parameters only;
:meth:`KernelSet.constants` computes them once per set of parameters. Kernels are pure functions of these arguments and
may run in any thread.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import Any, cast

import numpy as np

from ..errors import ExpressionError
from ..native import codegen
from ..native.records import WIDTH
from .code.lower import PROLOGUE

_Scalar = ctypes.CFUNCTYPE(None, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_Batch = ctypes.CFUNCTYPE(
    None, ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64,
    ctypes.c_void_p,
)  # fmt: skip


SHARE = 256
"""Number of rows below which a batch is not shared between threads: handing the rows over costs as much."""


@lru_cache(maxsize=4)
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="freebody")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # threads stay with the parent


class KernelSet:
    """Kernels compiled together, with one prologue and one vector of hoisted constants.

    Attributes
    ----------
    kernels : dict
        Name -> :class:`Kernel`.
    hoisted : int
        Length of the vector of hoisted constants.
    parameters : int
        Number of parameters.
    from_disk : bool
        True if the code was loaded from the disk.
    size : int
        Size of the code and its tables in bytes.
    seconds : float
        Time that its compilation took, now or before it was stored: lowering, text and LLVM.
    """

    def __init__(
        self,
        header: Mapping[str, Any],
        library: codegen.Library,
        names: Sequence[str],
        state: int,
        parameters: int,
        batch: Sequence[str],
        from_disk: bool,
        size: int,
        lanes: int = 1,
    ) -> None:
        self.hoisted: int = header["hoisted"]
        self.from_disk = from_disk
        self.size = size
        self.seconds: float = header["seconds"]
        self.remark = ""
        symbols = [f"f{k}" if lanes == 1 else f"f{k}.lanes" for k in range(len(names))]
        batches = [f"{s}.batch" for s, name in zip(symbols, names, strict=True) if name in batch]
        if batches:
            batches += [
                "prologue.batch",
                *(f"{s}.lanes" for s, name in zip(symbols, names, strict=True) if name in batch),
            ]
        addresses = library.addresses(["prologue", *symbols, *batches])
        self.parameters = parameters
        self._prologue = Kernel(
            "parameters", library, addresses["prologue"], addresses.get("prologue.batch"), parameters, 0,
            self.hoisted, header["operations"][PROLOGUE],
        )  # fmt: skip
        self.kernels: dict[str, Kernel] = {
            name: Kernel(
                name, library, addresses[s], addresses.get(f"{s}.batch"), state, self.hoisted,
                header["outputs"][name], header["operations"][name], addresses.get(f"{s}.lanes"),
                header.get("rooms", {}).get(name, 0),
            )
            for s, name in zip(symbols, names, strict=True)
        }  # fmt: skip

    def __getitem__(self, name: str) -> Kernel:
        """Return the kernel of this name."""
        return self.kernels[name]

    def constants(self, parameters: Any) -> np.ndarray:
        """The vector c of hoisted constants, shape (hoisted,).

        Parameters
        ----------
        parameters : array-like, shape (parameters,) or (N, parameters)
            The second form gives shape (N, hoisted), for a batch in which each state has its own parameters.
        """
        p = np.ascontiguousarray(parameters, dtype=float)
        if p.ndim == 2:
            if self._prologue.batch_address is None:
                return np.stack([self._prologue(0.0, row, ()) for row in p])
            return self._prologue.batch(0.0, p, ())
        if p.shape == (self._prologue.state,):
            return self._prologue.unchecked(0.0, p, p)
        return self._prologue(0.0, p, ())

    @property
    def prologue(self) -> Kernel:
        """The function of the parameters that gives the constants: f(0, p, p, c)."""
        return self._prologue

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Counts of operations by kernel; ``"parameters"`` has those done once per set of parameters."""
        return {k.name: dict(k.operations) for k in (self._prologue, *self.kernels.values())}


class Kernel:
    """One compiled function.

    Attributes
    ----------
    address : int
        Address of ``void f(double t, const double *y, const double *c, double *out)``, valid while this object lives.
    batch_address : int or None
        Address of ``void f(int64 n, const double *t, int64 t_step, const int64 *parts, const double *c, int64 c_step,
        double *out)`` over rows; a step of 0 shares t or c between all rows. The rows y are those of several arrays
        side by side. The table ``parts`` holds three numbers for each array: its address, its width, and the number of
        doubles from one row to the next.
    lanes_address : int or None
        Address of ``void f(const double *t, const double *y, const double *c, double *out)`` over 8 lanes: entry i of
        lane l stands at 8 i + l, and every pointer is a multiple of 64.
    room : int
        Number of doubles that the series of eight lanes writes to ``out``.
    outputs : int
        Length of ``out``.
    operations : dict
        Operation -> number of times it is done.
    """

    def __init__(
        self,
        name: str,
        library: Any,
        address: int,
        batch_address: int | None,
        state: int,
        hoisted: int,
        outputs: int,
        operations: Mapping[str, int],
        lanes_address: int | None = None,
        room: int = 0,
    ) -> None:
        self.name = name
        self.room = room
        self.lanes_address = lanes_address
        self.address = address
        self.batch_address = batch_address
        self.state = state
        self.hoisted = hoisted
        self.outputs = outputs
        self.operations = operations
        self._library = library  # keeps the code in memory
        self._function = _Scalar(address)
        self._batch = None if batch_address is None else _Batch(batch_address)

    def __repr__(self) -> str:
        return f"<Kernel {self.name}: {self.state} -> {self.outputs}, {sum(self.operations.values())} operations>"

    def __call__(self, t: float, y: Any, c: Any, out: np.ndarray | None = None) -> np.ndarray:
        """Outputs, shape (outputs,), at time ``t``, state ``y`` and hoisted constants ``c``."""
        y = self._checked(y, (self.state,), "y")
        c = self._checked(c, (self.hoisted,), "c")
        if out is None:
            out = np.empty(self.outputs)
        else:
            self._check_out(out, (self.outputs,))
        self._function(t, _pointer(y), _pointer(c), _pointer(out))
        return out

    def unchecked(self, t: float, y: np.ndarray, c: np.ndarray) -> np.ndarray:
        """Return the outputs without checks, for contiguous arrays of doubles of the right shapes."""
        out = np.empty(self.outputs)
        self._function(t, _pointer(y), _pointer(c), _pointer(out))
        return out

    def batch(self, t: Any, Y: Any, C: Any, out: np.ndarray | None = None, threads: int = 1) -> np.ndarray:
        """Outputs of N states at once, shape (N, outputs). Other threads run meanwhile.

        Parameters
        ----------
        t : float or array, shape (N,)
        Y : array, shape (N, state)
        C : array, shape (hoisted,), shared, or (N, hoisted)
        out : array, shape (N, outputs), optional
        threads : int
            Number of threads that share the rows. The results are the same bits.
        """
        Y = np.ascontiguousarray(Y, dtype=float)
        return self.batch_of_parts(t, [self._checked(Y, (len(Y), self.state), "Y")], C, out, threads)

    def batch_of_parts(
        self, t: Any, parts: Sequence[np.ndarray], C: Any, out: np.ndarray | None = None, threads: int = 1
    ) -> np.ndarray:
        """Outputs of N states whose parts stand side by side in arrays of doubles of shape (N, part of the state)."""
        if self._batch is None:
            raise ExpressionError(
                f"Expected a kernel compiled for batches, got '{self.name}'. Name it in batch= of compile_tape."
            )
        n = len(parts[0])
        C = np.asarray(C, dtype=float)
        C = self._checked(C, (self.hoisted,) if C.ndim < 2 else (n, self.hoisted), "C")
        t = np.asarray(t, dtype=float)
        if t.ndim:
            t = self._checked(t, (n,), "t")
        if out is None:
            out = np.empty((n, self.outputs))
        else:
            self._check_out(out, (n, self.outputs))
        parts = [*map(_readable, parts)]
        rows = -(-n // threads)
        rows = max(-(-rows // WIDTH) * WIDTH, SHARE)
        if n <= rows:
            self._rows(0, n, t, parts, C, out)
            return out
        tasks = [
            _pool(threads).submit(self._rows, start, min(start + rows, n), t, parts, C, out)
            for start in range(0, n, rows)
        ]
        for task in tasks:
            task.result()
        return out

    def _rows(
        self,
        start: int,
        stop: int,
        t: np.ndarray,
        parts: Sequence[np.ndarray],
        C: np.ndarray,
        out: np.ndarray,
    ) -> None:
        """Compute the rows of a batch from ``start`` to ``stop``; other threads run meanwhile."""
        assert self._batch is not None
        table: list[int] = []
        for part in parts:
            step = part.strides[0]
            table += (
                part.__array_interface__["data"][0] + start * step,
                part.shape[1],
                step // part.itemsize,
            )
        self._batch(
            stop - start,
            _pointer(t[start:stop] if t.ndim else t),
            int(t.ndim),
            (ctypes.c_int64 * len(table))(*table),
            _pointer(C[start:stop] if C.ndim == 2 else C),
            self.hoisted if C.ndim == 2 else 0,
            _pointer(out[start:stop]),
        )

    def _checked(self, values: Any, shape: tuple[int, ...], name: str) -> np.ndarray:
        values = np.ascontiguousarray(values, dtype=float)
        if values.shape != shape:
            raise ExpressionError(
                f"Expected {name} of shape {shape} for kernel '{self.name}', got shape {values.shape}."
            )
        return values

    def _check_out(self, out: Any, shape: tuple[int, ...]) -> None:
        good = (
            isinstance(out, np.ndarray)
            and out.shape == shape
            and out.dtype == float
            and out.flags.c_contiguous
        )
        if not good or not out.flags.writeable:
            got = f"{out.dtype} of shape {out.shape}" if isinstance(out, np.ndarray) else type(out).__name__
            raise ExpressionError(
                f"Expected out to be a writeable contiguous array of doubles of shape {shape} for kernel "
                f"'{self.name}', got {got}."
            )


def _readable(rows: np.ndarray) -> np.ndarray:
    """Return the rows, or a copy if the numbers of a row are not contiguous."""
    row_step, step = rows.strides
    size = rows.itemsize
    contiguous = rows.flags.aligned and row_step % size == 0 and (step == size or rows.shape[1] < 2)
    return rows if contiguous else np.ascontiguousarray(rows)


def _pointer(values: np.ndarray) -> int:
    """Address of the first number. `from_buffer` takes a third of the time of `values.ctypes`."""
    if values.size and values.flags.writeable:
        return ctypes.addressof(ctypes.c_double.from_buffer(cast(Any, values)))
    return values.ctypes.data
