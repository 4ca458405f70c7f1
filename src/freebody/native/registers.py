"""Width of the vectors that compiled code works on."""

from __future__ import annotations

WIDTH = 8
"""Number of doubles in a vector: a register of 512 bits. LLVM splits vectors on processors with shorter registers."""
