"""Processors that machine code is made for: this one, or another by name."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import llvmlite.binding as llvm

THIS = "this machine"


class Target(NamedTuple):
    """A processor as LLVM names it."""

    name: str
    triple: str
    processor: str
    features: str
    fused: bool
    """Whether it has a fused multiply-add."""


_LINUX, _WASM = "unknown-linux-gnu", "wasm32-unknown-unknown"
_OTHERS = (
    Target("x86-64-v2", f"x86_64-{_LINUX}", "x86-64-v2", "", False),
    Target("x86-64-v3", f"x86_64-{_LINUX}", "x86-64-v3", "", True),
    Target("x86-64-v4", f"x86_64-{_LINUX}", "x86-64-v4", "", True),
    Target("aarch64", f"aarch64-{_LINUX}", "generic", "", True),
    Target("wasm32", _WASM, "generic", "+simd128", False),
)
NAMES = (THIS, *(target.name for target in _OTHERS))
"""Names of targets."""


@lru_cache(maxsize=1)
def this() -> Target:
    """Return this processor."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    triple, features = llvm.get_process_triple(), llvm.get_host_cpu_features().flatten()
    if triple.startswith(("x86", "i386", "i686", "amd64")):
        fused = "+fma" in features.split(",")
    else:
        fused = triple.startswith(("aarch64", "arm64", "powerpc64", "ppc64", "riscv64"))
    return Target(THIS, triple, llvm.get_host_cpu_name(), features, fused)


def named(name: str) -> Target:
    """Return a target by its name, one of `NAMES`.

    Raises
    ------
    ValueError
        If there is no such target, or if this build of LLVM has no code for it.
    """
    return this() if name == THIS else _other(name)


@lru_cache(maxsize=len(_OTHERS))
def _other(name: str) -> Target:
    """Return a target other than this processor."""
    for target in _OTHERS:
        if target.name == name:
            llvm.initialize_all_targets()
            llvm.initialize_all_asmprinters()
            try:
                llvm.Target.from_triple(target.triple)
            except RuntimeError as error:
                raise ValueError(
                    f"Expected a build of llvmlite with code for '{name}', got one without: {error}. Install llvmlite "
                    "from PyPI, or choose another target."
                ) from None
            return target
    raise ValueError(f"Expected the name of a target, got '{name}'. Targets are {', '.join(NAMES)}.")
