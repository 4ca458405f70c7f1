"""LLVM through llvmlite: from IR text to object code to functions in memory."""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import threading
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import llvmlite
import llvmlite.binding as llvm

from . import target
from .target import THIS

OPTIMISATION = 1
"""Level of code generation. Levels 2 and 3 give the same code here and take a tenth longer."""
LONG = 1 << 24
"""Length in characters of a module that takes six seconds at that level: thousands of contacts in one function."""

OWN = "own."
"""Begin of the names of functions that two texts share: LLVM knows functions of the C library by their names."""

LIBRARY = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "exp2", "log", "log2", "pow",
    "fma", "floor", "ceil", "memcpy", "memset", "memmove",
)  # fmt: skip
"""Functions of the C library that code may call."""

_emitting = threading.Lock()


@lru_cache(maxsize=1)
def initialize() -> None:
    """Make the C functions that code may call known to LLVM, and code for this processor possible."""
    target.this()
    missing = [name for name in LIBRARY if not llvm.address_of_symbol(name)]
    if missing:
        library = ctypes.CDLL(ctypes.util.find_library("msvcrt" if os.name == "nt" else "m"))
        for name in missing:
            if hasattr(library, name):
                llvm.add_symbol(name, ctypes.cast(getattr(library, name), ctypes.c_void_p).value)


def processor() -> tuple[str, str, str]:
    """Target triple, name and features of this processor."""
    return target.this()[1:4]


def fused(name: str = THIS) -> bool:
    """Return whether a processor has a fused multiply-add."""
    return target.named(name).fused


def _new_machine(optimisation: int = OPTIMISATION, name: str = THIS) -> Any:
    """Compiler for a target.

    Code for this machine is completed when its place in memory is known, so it need not read addresses from a table.
    """
    _, triple, cpu, features, _ = target.named(name)
    here = name == THIS
    fixed = here and triple.startswith("x86_64") and "linux" in triple  # elsewhere a table is the rule
    return llvm.Target.from_triple(triple).create_target_machine(
        cpu=cpu,
        features=features,
        opt=optimisation,
        reloc="static" if fixed else "pic",
        codemodel="jitdefault" if here else "default",
        jit=here,
    )


_machine = lru_cache(maxsize=4)(_new_machine)


def layout(name: str = THIS) -> str:
    """Data layout of a processor in LLVM's notation."""
    return str(_machine(name=name).target_data)


def version(name: str = THIS) -> str:
    """Versions of LLVM and of everything else outside the sources that shapes the object code."""
    machine = " ".join(target.named(name)[1:4])
    return f"{llvmlite.__version__} {llvm.llvm_version_info} {machine} O{OPTIMISATION}"


def object_code(text: str, optimisation: int | None = None, name: str = THIS) -> bytes:
    """Object code of a module for a target (`target.NAMES`).

    No passes run on the IR: the tape has already shared and folded what they would find, and code generation itself
    contracts, schedules and allocates. Without optimisation, code generation takes an eighth of the time and its code
    is a fifth slower. Modules longer than :data:`LONG` are compiled so.
    """
    initialize()
    if optimisation is None:
        optimisation = OPTIMISATION if len(text) < LONG else 0
    machine = _machine(optimisation, name)
    return _emitted(llvm.parse_assembly(text, context=llvm.create_context()), machine, reduction=True)


def optimised_code(
    text: str, name: str = THIS, *, passes: str = "all", wide: bool = False, others: str = ""
) -> tuple[bytes, list[str]]:
    """Object code of a module in the compiled language for a target, after LLVM's passes, and the C functions that it
    calls.

    ``passes`` "all" are those of level 1 with vectorisation. Levels 2 and 3 take up to half as long again and give code
    that is no faster. Code whose loops have few rounds is as fast after "few" passes, in half the time. "none" are
    plain instructions for what runs rarely, in a tenth of the time. In ``wide`` code the lanes are the vectors:
    vectorisation only doubles its time.

    ``others`` is the text of functions that the first ones call and that call them (`translation.by_heat`): they get a
    few passes.
    """
    initialize()
    machine = _machine(0 if passes == "none" else OPTIMISATION, name=name)
    context = llvm.create_context()
    module = _parsed(text, name, context)
    options = llvm.create_pipeline_tuning_options(speed_level=0 if passes == "none" else 1)
    options.slp_vectorization = passes == "hot"
    if wide:
        options.loop_vectorization = options.slp_vectorization = options.loop_unrolling = False
    builder = llvm.create_pass_builder(machine, options)
    manager = _few_passes() if passes == "few" else builder.getModulePassManager()
    manager.run(module, builder)
    if others:
        more = _parsed(others, name, context)
        _few_passes().run(more, builder)
        module.link_in(more)
        for function in module.functions:
            if function.name.startswith(OWN):
                function.linkage = "internal"
    called = (f.name.removeprefix("llvm.").split(".")[0] for f in module.functions if f.is_declaration)
    # all other declarations of LLVM become instructions
    return _emitted(module, machine, reduction=wide), sorted(set(LIBRARY).intersection(called))


def _emitted(module: Any, machine: Any, *, reduction: bool) -> bytes:
    """Object code of a module, with strength reduction of the places in loops or without it.

    It takes a fourth of code generation. Batches are 6 % faster with it, and loops of one run as fast without. LLVM has
    one such switch for a process, which others may use, too.
    """
    with _emitting:
        llvm.set_option("freebody", f"-disable-lsr={'false' if reduction else 'true'}")
        try:
            return bytes(machine.emit_object(module))
        finally:
            llvm.set_option("freebody", "-disable-lsr=false")


def _parsed(text: str, name: str, context: Any) -> Any:
    module = llvm.parse_assembly(text, context=context)
    module.triple, module.data_layout = target.named(name).triple, layout(name)
    return module


def _few_passes() -> Any:
    """Passes that keep variables in registers and combine instructions."""
    result = llvm.create_new_module_pass_manager()
    result.add_simplify_cfg_pass()
    result.add_sroa_pass()
    result.add_instruction_combine_pass()
    result.add_simplify_cfg_pass()
    return result


class Library:
    """Object code in memory. It is unloaded with this object: keep the object as long as its addresses are called."""

    needs: Any = None
    """Objects that the code uses and that must live as long."""

    def __init__(self, code: bytes) -> None:
        initialize()
        # the engine owns and frees its target machine
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _new_machine())
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()

    def addresses(self, names: Iterable[str]) -> dict[str, int]:
        """Addresses of functions by name."""
        return {name: self._engine.get_function_address(name) for name in names}
