"""Programs: the dynamics of a machine as machine code for one state or for many at once.

Bottom up: code (from traces to LLVM), series (Taylor coefficients), kernels, arguments and products, large (loops over
links), closed_loops, export (other languages), program.
"""
