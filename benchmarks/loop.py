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
define void @add(i64 %n, ptr %sums) {
entry:
  br label %body
body:
  %i = phi i64 [0, %entry], [%next, %body]
BEGIN
ADD
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %body, label %end
end:
STORE
  ret void
}
"""
SUMS = 16
"""Of vectors, side by side: more than wait for each other on any processor (latency x pipes), as many as all have."""


def lanes() -> int:
    """Doubles in a vector register of this processor."""
    from freebody.native import codegen

    features = codegen.processor()[2].split(",")
    return 8 if "+avx512f" in features else 4 if "+avx" in features else 2


def _text() -> str:
    T = f"<{lanes()} x double>"
    one = ", ".join(["double 1.0"] * lanes())
    parts = {
        "BEGIN": f"  %x{{k}} = phi {T} [zeroinitializer, %entry], [%y{{k}}, %body]",
        "ADD": f"  %y{{k}} = fadd {T} %x{{k}}, <{one}>",
        "STORE": f"  %p{{k}} = getelementptr {T}, ptr %sums, i64 {{k}}\n  store {T} %y{{k}}, ptr %p{{k}}, align 8",
    }
    text = _IR
    for name, line in parts.items():
        text = text.replace(name, "\n".join(line.format(k=k) for k in range(SUMS)))
    return text


@cache
def _engine() -> tuple[Any, Any]:
    import llvmlite.binding as llvm

    try:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
    except RuntimeError:
        pass  # newer LLVM starts by itself
    name, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    machine = llvm.Target.from_default_triple().create_target_machine(cpu=name, features=features, opt=2)
    parsed = llvm.parse_assembly(_text())
    engine = llvm.create_mcjit_compiler(parsed, machine)
    engine.finalize_object()
    add = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_void_p)
    engine.add = add(engine.get_function_address("add"))
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


def additions() -> float:
    """Additions of doubles that this core does in a second of this thread, if none waits for another: its limit now."""
    engine, _ = _engine()
    n = 40_000
    sums = np.zeros(SUMS * lanes())
    start = time.thread_time()
    engine.add(n, sums.ctypes.data)
    elapsed = time.thread_time() - start
    if not (sums == n).all():
        raise ArithmeticError(f"{n} additions of 1 gave {sums}")
    return n * len(sums) / elapsed
