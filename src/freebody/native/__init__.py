"""Compiled language: Python functions of numbers and arrays as machine code.

This room knows nothing of mechanics. Bottom up: ownership and sources, the cache on disk, arithmetic and the
translator, targets and LLVM (codegen), compiled loops, then the instructions that compiled functions use.
"""
