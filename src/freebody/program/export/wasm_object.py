"""A relocatable WebAssembly object of functions of a machine and of a compiled loop, by LLVM."""

from __future__ import annotations

import llvmlite.binding as llvm

from ...native import codegen, target

TARGET = "wasm32"
FEATURES = "+bulk-memory,+sign-ext,+nontrapping-fptoint"
"""Features besides the target's own. Browsers have had them, and SIMD, since 2021."""


def version() -> str:
    """Versions of LLVM and of what else shapes an object besides the sources."""
    return f"{codegen.version(TARGET)} {FEATURES}"


def wasm_object(loop: str, kernels: str) -> bytes:
    """Return the object of a loop and of kernels, from their LLVM texts.

    The loop is optimised by LLVM's passes of level 1 with vectorisation, as for this computer; kernels need none.
    """
    chosen = target.named(TARGET)
    machine = llvm.Target.from_triple(chosen.triple).create_target_machine(
        cpu=chosen.processor, features=f"{chosen.features},{FEATURES}", opt=codegen.OPTIMISATION, reloc="static",
        codemodel="default",
    )  # fmt: skip
    context = llvm.create_context()
    modules = [llvm.parse_assembly(text, context=context) for text in (loop, kernels)]
    for module in modules:
        module.triple, module.data_layout = chosen.triple, str(machine.target_data)
    whole, more = modules
    passes = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=1))
    passes.getModulePassManager().run(whole, passes)
    whole.link_in(more)
    return bytes(machine.emit_object(whole))
