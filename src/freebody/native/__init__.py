"""Compiled language: Python functions of numbers and arrays as machine code. It knows nothing of machines."""
