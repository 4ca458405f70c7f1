"""Linearization of planar chains about hanging at rest, in symbols, against SymPy's ``KanesMethod.linearize``."""

from __future__ import annotations

from typing import Any

from .tables import NOT_INSTALLED, module, ratio_text, seconds, show, time_text

SIZES = (2, 3, 4, 5, 6, 8, 10)
QUICK = (2, 6)
AGREEMENT = 1e-12


def ours(system: Any) -> tuple[Any, Any, Any]:
    """M, C, K as SymPy matrices, from the described system on."""
    import freebody as fb

    linear = fb.linearize(fb.equations(system))
    return linear.M, linear.C, linear.K


def theirs(kane: Any, n: int) -> tuple[Any, Any]:
    """SymPy's M and A in M x' = A x, of its formed equations, with the hanging state put in."""
    import sympy
    from sympy.physics.mechanics import dynamicsymbols

    still = {x: 0 for k in range(1, n + 1) for x in dynamicsymbols(f"q{k} u{k}")}
    still |= {x.diff(sympy.Symbol("t")): 0 for x in list(still)}
    M, A, _ = kane.to_linearizer().linearize(op_point=still)
    return M, A


def largest_difference(n: int) -> float:
    """Of M and K between freebody and SymPy at random parameters."""
    import random

    import sympy

    from .models import BUILDERS
    from .sympy_chains import planar_chain

    choose = random.Random(n)
    numbers: dict[str, float] = {}

    def values(matrix: Any) -> list[float]:
        for symbol in sorted(matrix.free_symbols, key=str):
            numbers.setdefault(str(symbol), choose.uniform(0.5, 1.5))
        at = {x: sympy.Float(numbers[str(x)], 30) for x in matrix.free_symbols}
        return [float(x) for x in matrix.xreplace(at)]

    M, _, K = ours(BUILDERS["planar"](n))
    peer_M, peer_A = theirs(planar_chain(n), n)
    # rows of SymPy's first-order form: q' = u, then -M u' = K q
    pairs = [(M, -peer_M[n:, n:]), (K, peer_A[n:, :n])]
    return max(
        abs(a - b)
        for mine, peer in pairs
        for a, b in zip(values(mine), values(sympy.Matrix(peer)), strict=True)
    )


def main(quick: bool = False, repeats: int = 5, limit: float = 185.0) -> None:
    """Print the table; sizes after one that took SymPy longer than ``limit`` are skipped."""
    from .models import BUILDERS

    rows: list[list[Any]] = []
    slow = False
    installed = module("sympy") is not None
    for n in QUICK if quick else SIZES:
        system = BUILDERS["planar"](n)
        ours(system)
        mine = seconds(lambda system=system: ours(system), repeats)  # type: ignore[misc]
        if not installed or slow:
            rows.append([n, time_text(mine), *[NOT_INSTALLED if not installed else "-"] * 3])
            continue
        from sympy.core.cache import clear_cache

        from .sympy_chains import planar_chain

        if n <= 4 and not largest_difference(n) < AGREEMENT:
            raise ArithmeticError(f"the linear equations of {n} links differ: these are not the same machine")
        kane = planar_chain(n)
        peer = seconds(lambda kane=kane, n=n: theirs(kane, n), 1, before=clear_cache)  # type: ignore[misc]
        slow = peer > limit
        rows.append([n, time_text(mine), time_text(peer), ratio_text(peer, mine)])
    show(
        "Linearization of planar chains of n bars about hanging at rest, in symbols",
        ["n", "freebody", "SymPy linearize", "ratio"],
        [row[:4] for row in rows],
        [
            "freebody: fb.linearize(fb.equations(s)) to M, C, K as SymPy matrices, with the forming of all that "
            "is needed.",
            "SymPy: to_linearizer().linearize(op_point) of equations that KanesMethod has formed before the "
            "clock starts.",
        ],
    )


if __name__ == "__main__":
    main()
