"""Small pieces of LLVM IR text: numbers, constants and lines of instructions."""

from __future__ import annotations

import math
import struct
from functools import lru_cache


def literal(value: float) -> str:
    """Return a double as IR text, bit for bit.

    >>> literal(1.0), literal(-0.0)
    ('0x3FF0000000000000', '0x8000000000000000')
    """
    return _bits(value) if value else f"0x{'8' if math.copysign(1, value) < 0 else '0'}{'0' * 15}"


@lru_cache(maxsize=4096)
def _bits(value: float) -> str:
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


def splat(value: str, lanes: int, element: str = "double") -> str:
    """Return a vector with the constant in every lane; the constant itself for one lane.

    >>> splat("1", 2, "i64")
    '<i64 1, i64 1>'
    """
    if lanes == 1:
        return value
    return "<" + ", ".join([f"{element} {value}"] * lanes) + ">"


FLAGS = "contract "
"""Fast-math flags of arithmetic: a product and a sum may become one instruction; nothing else is rearranged."""


class Lines:
    """Instructions of a function in their order, on values of type ``T``."""

    T = "double"

    def __init__(self) -> None:
        self.count = 0
        self.lines: list[str] = []

    def _new(self, operation: str) -> str:
        self.count += 1
        self.lines.append(f"  %v{self.count} = {operation}")
        return f"%v{self.count}"

    def _arithmetic(self, operation: str, a: str, b: str) -> str:
        return self._new(f"{operation} {FLAGS}{self.T} {a}, {b}")

    def _signed(self, total: str | None, sign: int, value: str) -> str:
        """Write total ± value, where a total of None is zero, and return the name of the result."""
        if total is not None:
            return self._arithmetic("fadd" if sign > 0 else "fsub", total, value)
        return value if sign > 0 else self._new(f"fneg {FLAGS}{self.T} {value}")


ZEROS = """define internal void @zeros(ptr %out, i64 %n) nounwind noinline {
entry:
  br label %next
next:
  %i = phi i64 [0, %entry], [%j, %next]
  %p = getelementptr double, ptr %out, i64 %i
  store double 0.0, ptr %p, align 8
  %j = add i64 %i, 1
  %more = icmp slt i64 %j, %n
  br i1 %more, label %next, label %done
done:
  ret void
}
"""
"""IR function that sets n > 0 doubles to zero."""
