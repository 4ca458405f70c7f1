"""Linear equations of a few unknowns, in compiled code."""

from __future__ import annotations

import math

from ...native.instructions import Reals, compiled


@compiled
def solved(a: Reals, n: int, b: Reals) -> int:
    """Replace b by a⁻¹ b by elimination with row exchanges; overwrite a. Return 0 if a is singular, else 1."""
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(a[i * n + k]) > abs(a[p * n + k]):
                p = i
        if a[p * n + k] == 0.0 or not math.isfinite(a[p * n + k]):
            return 0
        if p != k:
            for j in range(k, n):
                exchanged = a[k * n + j]
                a[k * n + j] = a[p * n + j]
                a[p * n + j] = exchanged
            exchanged = b[k]
            b[k] = b[p]
            b[p] = exchanged
        for i in range(k + 1, n):
            part = a[i * n + k] / a[k * n + k]
            if part != 0.0:
                for j in range(k + 1, n):
                    a[i * n + j] -= part * a[k * n + j]
                b[i] -= part * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= a[k * n + j] * b[j]
        b[k] /= a[k * n + k]
    return 1
