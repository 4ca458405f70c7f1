"""A loop in machine code around a kernel ``void f(double t, const double *y, const double *c, double *out)``.

The call by address is what an integrator pays, and what a peer's C++ loop pays; Python is outside.
"""

from __future__ import annotations

import ctypes
import time
from functools import cache
from typing import Any

import numpy as np

_IR = """
define void @repeat(i64 %address, i64 %n, double %t, ptr %y, ptr %c, ptr %out) {
entry:
  %f = inttoptr i64 %address to ptr
  br label %head
head:
  %i = phi i64 [0, %entry], [%next, %body]
  %more = icmp slt i64 %i, %n
  br i1 %more, label %body, label %end
body:
  call void %f(double %t, ptr %y, ptr %c, ptr %out)
  %next = add i64 %i, 1
  br label %head
end:
  ret void
}
define i64 @chain(i64 %n, i64 %x) {
entry:
  br label %body
body:
  %i = phi i64 [0, %entry], [%next, %body]
  %y0 = phi i64 [%x, %entry], [%y8, %body]
MULTIPLY
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %body, label %end
end:
  ret i64 %y8
}
"""
_IR = _IR.replace("MULTIPLY", "\n".join(f"  %y{k + 1} = mul i64 %y{k}, %y{k}" for k in range(8)))
LATENCY = 3  # cycles of an integer product, on all x86-64 processors since 2008 and on those of Arm


@cache
def _engine() -> tuple[Any, Any]:
    import llvmlite.binding as llvm

    try:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
    except RuntimeError:
        pass  # newer LLVM starts by itself
    machine = llvm.Target.from_default_triple().create_target_machine(opt=2)
    parsed = llvm.parse_assembly(_IR)
    engine = llvm.create_mcjit_compiler(parsed, machine)
    engine.finalize_object()
    chain = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64)
    engine.chain = chain(engine.get_function_address("chain"))
    pointer = ctypes.c_void_p
    prototype = ctypes.CFUNCTYPE(
        None, ctypes.c_int64, ctypes.c_int64, ctypes.c_double, pointer, pointer, pointer
    )
    return engine, prototype(engine.get_function_address("repeat"))


def repeater(address: int, y: np.ndarray, c: np.ndarray, out: np.ndarray) -> Any:
    """``loop(n)``: calls the kernel ``n`` times at the same state."""
    _, repeat = _engine()

    def loop(n: int) -> None:
        repeat(address, n, 0.0, y.ctypes.data, c.ctypes.data, out.ctypes.data)

    loop.arrays = (y, c, out)  # type: ignore[attr-defined] - keeps them alive
    return loop


def clock(repeats: int = 7) -> float:
    """Cycles per second of this core while it works: a chain of integer products, each waiting for the last."""
    engine, _ = _engine()
    n = 400_000
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        engine.chain(n, 3)
        best = min(best, time.perf_counter() - start)
    return 8 * LATENCY * n / best
