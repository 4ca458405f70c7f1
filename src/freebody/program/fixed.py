"""Kernels of several programs as one set, with the constants of one set of parameters built in.

    f(t, y, out) = F(t, y, c, out)

They serve callers that take one vector c for all kernels: its length is then 0.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..native import codegen
from .kernel import Kernel


class Fixed:
    """Kernels by name, each with its own constants; ``hoisted`` is 0 and ``_prologue`` computes nothing."""

    hoisted = 0

    def __init__(self, kernels: Mapping[str, tuple[Kernel, np.ndarray]]) -> None:
        constants = {name: np.ascontiguousarray(c) for name, (_, c) in kernels.items()}
        text = [_NOTHING]
        for k, (name, (kernel, _)) in enumerate(kernels.items()):
            place = constants[name].ctypes.data
            text.append(_CALL.format(name=f"f{k}", time="double", address=kernel.address, constants=place))
            if kernel.lanes_address:
                text.append(
                    _CALL.format(
                        name=f"f{k}.lanes", time="ptr", address=kernel.lanes_address, constants=place
                    )
                )
        library = codegen.Library(
            codegen.object_code(f'target triple = "{codegen.processor()[0]}"\n' + "\n".join(text))
        )
        library.needs = (kernels, constants)
        names = [f"f{k}{form}" for k in range(len(kernels)) for form in ("", ".lanes")]
        addresses = library.addresses(["nothing", *names])
        self._prologue = Kernel("parameters", library, addresses["nothing"], None, 0, 0, 0, {})
        self.kernels: dict[str, Kernel] = {
            name: Kernel(
                name, library, addresses[f"f{k}"], None, kernel.state, 0, kernel.outputs, kernel.operations,
                addresses[f"f{k}.lanes"] or None,
            )
            for k, (name, (kernel, _)) in enumerate(kernels.items())
        }  # fmt: skip

    def __getitem__(self, name: str) -> Kernel:
        """Return the kernel of this name."""
        return self.kernels[name]

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Counts of operations by kernel."""
        return {name: dict(kernel.operations) for name, kernel in self.kernels.items()}


_NOTHING = """define void @nothing(double %t, ptr %y, ptr %c, ptr %out) nounwind {
  ret void
}
"""
_CALL = """define void @{name}({time} %t, ptr %y, ptr %c, ptr %out) nounwind {{
  call void inttoptr (i64 {address} to ptr)({time} %t, ptr %y, ptr inttoptr (i64 {constants} to ptr), ptr %out)
  ret void
}}
"""
