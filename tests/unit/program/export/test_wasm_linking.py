"""The linker: an object becomes a module with the image in its memory, and functions call others by the table."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from freebody.program.export.wasm_linking import GAP, PAGE, STACK, base_of_image, linked, signed, unsigned
from freebody.program.export.wasm_object import optimised, wasm_object

LOOP = """
@table = internal constant [3 x double] [double 1.5, double 2.5, double 4.5]
define void @fill(ptr %p) {
  %t = alloca [4 x double]
  %f = load i64, ptr %p
  %g = inttoptr i64 %f to ptr
  call void %g(double 2.0, ptr %t, ptr @table, ptr %t)
  %v = load double, ptr %t
  %q = getelementptr double, ptr %p, i64 1
  store double %v, ptr %q
  ret void
}
"""
KERNELS = """
declare double @sin(double)
define void @f0(double %t, ptr %y, ptr %c, ptr %out) {
  %p = getelementptr double, ptr %c, i64 2
  %x = load double, ptr %p
  %s = call double @sin(double %x)
  %r = fadd double %t, %s
  store double %r, ptr %out
  ret void
}
"""


def run(image: bytes, size: int) -> np.ndarray:
    """Call "fill" in wasmtime; return the memory behind the base."""
    wasmtime = pytest.importorskip("wasmtime", reason="wasmtime, a WebAssembly runtime, is not installed")
    code = wasm_object(optimised(LOOP), KERNELS)
    module = linked(code, ["fill"], ["f0"], image, size)
    assert module.imports == ("sin",)
    store = wasmtime.Store()
    real = wasmtime.ValType.f64()
    sine = wasmtime.Func(store, wasmtime.FuncType([real], [real]), np.sin)
    exports = wasmtime.Instance(store, wasmtime.Module(store.engine, module.code), [sine]).exports(store)
    memory = exports["memory"]
    first = ctypes.cast(memory.data_ptr(store), ctypes.POINTER(ctypes.c_uint8))
    content = np.ctypeslib.as_array(first, (memory.data_len(store),))
    base = base_of_image(code)
    assert len(content) % PAGE == 0 and len(content) >= base + size
    assert bytes(content[base : base + len(image)]) == image  # before any call
    exports["fill"](store, base)
    return content[base : base + size].copy()


def test_functions_are_called_by_their_place_in_the_table_and_read_constants():
    memory = run((1).to_bytes(8, "little") + bytes(8), 16).view(np.float64)
    assert memory[1] == 2 + np.sin(4.5)


def test_an_image_keeps_every_byte_however_its_zeros_lie():
    rng = np.random.default_rng(1)
    image = bytearray((1).to_bytes(8, "little"))
    for _ in range(200):
        image += rng.bytes(int(rng.integers(1, 9))) + bytes(int(rng.integers(0, 3 * GAP)))
    run(bytes(image), len(image) + 1000)


def test_addresses_of_no_function_trap():
    wasmtime = pytest.importorskip("wasmtime", reason="wasmtime, a WebAssembly runtime, is not installed")
    for place in (0, 2, 10**6):
        with pytest.raises(wasmtime.Trap):
            run(place.to_bytes(8, "little"), 16)


def test_constants_stand_between_the_stack_and_the_image():
    base = base_of_image(wasm_object(optimised(LOOP), KERNELS))
    assert base > STACK and base % 64 == 0


def test_numbers_in_leb128():
    assert [signed(x).hex() for x in (0, -1, 63, 64, -64, -65, 2**31 - 1)] == [
        "00", "7f", "3f", "c000", "40", "bf7f", "ffffffff07",
    ]  # fmt: skip
    assert unsigned(127) == b"\x7f" and unsigned(128) == b"\x80\x01" and len(unsigned(0, 5)) == 5
