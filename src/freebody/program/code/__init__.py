"""From a recorded computation to LLVM IR.

Bottom up: lower (from a tape to a program), sincos and vector_math (elementary functions), batch (loops over rows),
emit (the text).
"""
