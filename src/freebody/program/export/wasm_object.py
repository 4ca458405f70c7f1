"""A relocatable WebAssembly object of functions of a machine and of a compiled loop, by LLVM."""

from __future__ import annotations

from typing import Any

import llvmlite.binding as llvm

from ...native import codegen, target

TARGET = "wasm32"
FEATURES = "+bulk-memory,+sign-ext,+nontrapping-fptoint"
"""Features besides the target's own. Browsers have had them, and SIMD, since 2021."""


def version() -> str:
    """Versions of LLVM and of what else shapes an object besides the sources."""
    return f"{codegen.version(TARGET)} {FEATURES}"


def optimised(loop: str) -> bytes:
    """Return a loop, an LLVM text, after the passes of level 1 that do not repeat code: a page carries each copy."""
    machine, module = _machine(), llvm.parse_assembly(loop, context=llvm.create_context())
    _aim(module, machine)
    options = llvm.create_pipeline_tuning_options(speed_level=1)
    options.loop_unrolling = options.loop_vectorization = options.slp_vectorization = False
    passes = llvm.create_pass_builder(machine, options)
    passes.getModulePassManager().run(module, passes)
    return bytes(module.as_bitcode())


def wasm_object(loop: bytes, kernels: str) -> bytes:
    """Return the object of an `optimised` loop and of kernels, an LLVM text, which needs no passes."""
    machine, context = _machine(), llvm.create_context()
    whole, more = llvm.parse_bitcode(loop, context=context), llvm.parse_assembly(kernels, context=context)
    _aim(more, machine)
    whole.link_in(more)
    return bytes(machine.emit_object(whole))


def _machine() -> Any:
    chosen = target.named(TARGET)
    return llvm.Target.from_triple(chosen.triple).create_target_machine(
        cpu=chosen.processor, features=f"{chosen.features},{FEATURES}", opt=codegen.OPTIMISATION, reloc="static",
        codemodel="default",
    )  # fmt: skip


def _aim(module: Any, machine: Any) -> None:
    module.triple, module.data_layout = target.named(TARGET).triple, str(machine.target_data)
