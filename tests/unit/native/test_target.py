"""Machine code for other processors, and code of other processors that is not run here."""

from __future__ import annotations

import ctypes
import math
import struct
import sys

import llvmlite.binding as llvm
import numpy as np
import pytest

from freebody.native import cache, codegen, loop, target
from freebody.program.code.emit import Module
from freebody.program.code.lower import lower
from freebody.scalar.trace import Tape
from random_programs import ARGUMENTS, Writer, arrays, bits, compiled

MACHINES = {"x86-64-v2": 62, "x86-64-v3": 62, "x86-64-v4": 62, "aarch64": 183}
"""Number of a processor in the head of an ELF file."""
OTHERS = [name for name in target.NAMES if name != target.THIS]


def kernel(name):
    """Object code of sin x + tan x, for one state and for eight, as kernels are made."""
    tape = Tape()
    x = tape.input("x")
    program = lower(tape, {"f": [tape.sin(x) + tape.apply("tan", x)]}, None, [x], [])
    module = Module(target.named(name).triple, codegen.layout(name), codegen.fused(name))
    module.add(program, program.bodies["f"], "f")
    module.add(program, program.bodies["f"], "f", lanes=8)
    module.add_batch("f", 1, 0, 1)
    return codegen.object_code(module.text(), name=name)


def of_processor(code, name):
    """Whether object code is of this processor's kind."""
    if name == "wasm32":
        return code[:4] == b"\0asm"
    return code[:4] == b"\x7fELF" and struct.unpack("<H", code[18:20])[0] == MACHINES[name]


@pytest.mark.parametrize("name", OTHERS)
def test_code_for_every_target(name, tmp_path):
    """Of a loop in the compiled language, of eight lanes, and of a kernel."""
    library, _ = compiled([Writer(1).text()], ["f1"], tmp_path, f"one_{name.replace('-', '_')}", target=name)
    assert of_processor(library, name)
    wide, _ = compiled([Writer(1, wide=True).text()], ["f1"], tmp_path, "wide", 8, target=name)
    assert of_processor(wide, name)
    assert of_processor(kernel(name), name)


def test_levels_of_x86_differ_in_their_registers(tmp_path):
    codes = [
        compiled([Writer(1, wide=True).text()], ["f1"], tmp_path, "wide", 8, target=f"x86-64-v{k}")[0]
        for k in (2, 3, 4)
    ]
    assert len(set(codes)) == 3


@pytest.mark.skipif(not codegen.processor()[0].startswith("x86_64"), reason="runs code for x86-64")
@pytest.mark.skipif(sys.platform != "linux", reason="loads an ELF file")
def test_code_for_an_older_processor_gives_the_same_bits(tmp_path):
    names = [f"f{seed}" for seed in range(20)]
    texts = [Writer(seed).text() for seed in range(20)]
    here, addresses = compiled(texts, names, tmp_path, "here")
    code, _ = compiled(texts, names, tmp_path, "there", target="x86-64-v2")
    older = codegen.Library(code)
    kind = ctypes.CFUNCTYPE(
        ctypes.c_double, *[ctypes.c_int64] * 2, *[ctypes.c_double] * 2, *[ctypes.c_void_p] * 2
    )
    for name in names:
        for arguments in ARGUMENTS:
            results = []
            for address in (addresses[name], older.addresses([name])[name]):
                p, k = arrays(np.random.default_rng(1))
                value = kind(address)(*arguments, p.ctypes.data, k.ctypes.data)
                results.append([*bits(value), *bits(p), *k.tolist()])
            assert results[0] == results[1], name
    assert here is not None


def test_unknown_targets_are_refused():
    with pytest.raises(
        ValueError, match=r"Expected the name of a target, got 'z80'\. Targets are this machine, x86-64-v2,"
    ):
        codegen.object_code("", name="z80")


def test_a_target_that_llvm_lacks_is_refused_by_name(monkeypatch):
    def lacking(triple):
        raise RuntimeError(f"No available targets are compatible with triple '{triple}'")

    target._other.cache_clear()
    monkeypatch.setattr(llvm.Target, "from_triple", lacking)
    with pytest.raises(
        ValueError, match=r"Expected a build of llvmlite with code for 'wasm32', got one without: No avail"
    ):
        target.named("wasm32")


@pytest.fixture
def forged(monkeypatch):
    """This processor with other features."""

    def forge(features):
        other = target.this()._replace(features=features)
        monkeypatch.setattr(target, "this", lambda: other)

    return forge


def test_code_of_other_features_has_another_key(forged):
    keys = [loop.key("forged", "motion.start.gauss_newton")]
    forged("+sse2")
    keys.append(loop.key("forged", "motion.start.gauss_newton"))
    forged("+sse2,+avx512f")
    keys.append(loop.key("forged", "motion.start.gauss_newton"))
    assert len(set(keys)) == 3


def test_code_of_other_features_is_never_run(forged, tmp_path, monkeypatch):
    """A file under the right name whose code was made for other features is compiled anew."""
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path))
    monkeypatch.setattr("freebody.native.sources.changed", lambda: False)
    space = vars(loop.module_named("motion.ode.crossing"))
    names = ("approached",)
    header, code = loop._compiled(space, names)
    assert loop._loaded(header, code, names) is not None
    header["target"] = header["target"].replace("+", "-", 1)
    assert cache.store("0" * 64, header, code)
    assert loop._loaded(*cache.load("0" * 64), names) is None
    assert not loop._made("0" * 64, names, lambda: space).from_disk
    assert loop._made("0" * 64, names, lambda: space).from_disk
    forged(codegen.processor()[2] + ",+other")
    assert loop._loaded(*cache.load("0" * 64), names) is None


def test_code_for_this_machine_reads_no_addresses_from_a_table():
    triple = codegen.processor()[0]
    if not (triple.startswith("x86_64") and "linux" in triple):
        pytest.skip("code of other systems has tables")
    text = """
        declare double @sin(double)
        define internal double @g(double %x) noinline { %y = call double @sin(double %x) ret double %y }
        define double @f(double %x) { %y = call double @g(double %x) %z = fadd double %y, 0.1 ret double %z }
    """
    for code in (codegen.object_code(text), codegen.optimised_code(text)[0]):
        assert b"_GLOBAL_OFFSET_TABLE_" not in code
        library = codegen.Library(code)
        f = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(library.addresses(["f"])["f"])
        assert f(0.5) == math.sin(0.5) + 0.1
