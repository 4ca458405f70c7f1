"""Whipple's bicycle, from the description to the eigenvalues, beside SymPy's own test of it.

``python -m benchmarks bicycle`` measures freebody; SymPy's test takes about 100 s and runs only when it is asked for:
``python -m benchmarks.bicycle --peer --limit 200``.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from typing import Any

from .tables import module, ratio_text, seconds, show, time_text

# eigenvalues at v = 5 m/s: Meijaard et al. (2007), table 2
PUBLISHED = (-14.07838969279822, -0.32286642900409, -0.77534188219585, -0.77534188219585)

FRESH = """
from freebody.gallery import whipple_bicycle as bicycle
import freebody as fb
model = fb.assemble(bicycle.build())
parts = bicycle.coefficients(model, model.values({}))
print([complex(z) for z in bicycle.eigenvalues(parts, 5, 9.81)])
"""
"""The work of SymPy's test: symbols of v, that is the four coefficient matrices, and the eigenvalues at one speed."""

PEER = "from sympy.physics.mechanics.tests.test_kane3 import test_bicycle; test_bicycle()"


def in_fresh_process(script: str, limit: float | None = None) -> float | str:
    """Wall time of a Python process that runs a script, imports included [s]."""
    start = time.perf_counter()
    try:
        subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return f"> {limit:g} s"
    return time.perf_counter() - start


def largest_difference() -> float:
    """Of the real parts of the eigenvalues at v = 5 from the published ones."""
    from freebody.gallery.beyond import whipple_bicycle as bicycle

    system = bicycle.build()
    import freebody as fb

    model = fb.assemble(system)
    found = bicycle.eigenvalues(bicycle.coefficients(model, model.values({})), 5, 9.81)
    return max(abs(a - b) for a, b in zip(sorted(z.real for z in found), sorted(PUBLISHED), strict=True))


def main(*, quick: bool = False, repeats: int = 5, limit: float = 200.0, peer: bool = False) -> None:
    """Print the table."""
    import freebody as fb
    from freebody.gallery.beyond import whipple_bicycle as bicycle

    count = 1 if quick else repeats
    model = fb.assemble(bicycle.build())
    values = model.values({})
    describe = seconds(lambda: fb.assemble(bicycle.build()), count)
    one = seconds(lambda: bicycle.linear(model, 5.0, values), count)
    coefficients = seconds(lambda: bicycle.coefficients(model, values), count)
    whole = seconds(lambda: in_fresh_process(FRESH), 1)
    theirs: Any = None
    if peer and module("sympy") is not None:
        theirs = in_fresh_process(PEER, limit)
    rows: list[list[Any]] = [
        ["describe and assemble", time_text(describe), "", ""],
        ["linear equations at one speed", time_text(one), "", ""],
        ["coefficients M, C1, K0, K2", time_text(coefficients), "", ""],
        [
            "new process: import to eigenvalues",
            time_text(whole),
            time_text(theirs) if theirs is not None else "run with --peer",
            ratio_text(theirs, whole) if theirs is not None else "-",
        ],
    ]
    show(
        "Whipple's bicycle: from the model to the eigenvalues",
        ("", "freebody", "SymPy", "SymPy / freebody"),
        rows,
        [
            f"Largest difference from the published eigenvalues at v = 5 m/s: {largest_difference():.1e} 1/s.",
            "SymPy: sympy.physics.mechanics.tests.test_kane3.test_bicycle, Kane's method by hand-set kinematics, which "
            "gives the same matrices; its model takes 250 lines, ours 25.",
        ],
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m benchmarks.bicycle")
    parser.add_argument("--peer", action="store_true", help="also run SymPy's test (about 100 s)")
    parser.add_argument("--limit", type=float, default=200.0, help="seconds allowed to it")
    options = parser.parse_args()
    main(peer=options.peer, limit=options.limit)
