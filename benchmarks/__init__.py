"""Benchmarks: freebody beside its peers, measured in one run.

``python -m benchmarks`` prints every table; ``python -m benchmarks equations dynamics motion first`` chooses.
Peers (SymPy, Pinocchio, MuJoCo, Drake, SciPy) are measured in the same process with the same clock; a peer
that is not installed shows as "not installed". Times are medians of repeats.
"""
