"""Small pieces of LLVM IR text."""

from __future__ import annotations

import struct
from functools import lru_cache


@lru_cache(maxsize=4096)
def literal(value: float) -> str:
    """A double, bit for bit.

    >>> literal(1.0)
    '0x3FF0000000000000'
    """
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


def splat(value: str, lanes: int, element: str = "double") -> str:
    """A constant in every lane.

    >>> splat("1", 2, "i64")
    '<i64 1, i64 1>'
    """
    if lanes == 1:
        return value
    return "<" + ", ".join([f"{element} {value}"] * lanes) + ">"


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
"""The function that sets n > 0 doubles to zero."""
