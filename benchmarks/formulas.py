"""Formulas: operations of the gallery's answers as printed, beside the shortest of SymPy's rewritings of the same.

An operation is a sign in front, a sum, a product, a division, a power, a root or another function, counted in the
printed text; of an equation, in both sides. SymPy is given the formula with real symbols, and once more with those
positive that are known to be, and rewrites it in the ways of `_ways`; its shortest text counts.
``python -m benchmarks.formulas`` stores these counts in ``formulas.json``, and a test compares the prints with them.
"""

from __future__ import annotations

import ast
import json
import re
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from .tables import show

STORE = Path(__file__).with_suffix(".json")
CHAPTER = ("ex-", "sec-", "prob-")
LIMIT = 10.0


def operations(text: str) -> int:
    """Number of operations in a printed formula, or in both sides of a printed equation.

    >>> operations("-sqrt(3*g/L)"), operations("-sqrt(L)*sqrt(g)*sqrt(3)/L"), operations("m*theta'' = -k*theta^2")
    (4, 7, 4)
    """
    total = 0
    for side in text.split(" = "):
        side = re.sub(r"(\w)('+)", lambda m: m[1] + "_p" * len(m[2]), side)
        side = re.sub(r"\b(lambda|is|in|as)\b", r"\1_", side.replace("^", "**"))
        tree = ast.walk(ast.parse(side, mode="eval"))
        total += sum(isinstance(node, ast.BinOp | ast.UnaryOp | ast.Call) for node in tree)
    return total


def answers(names: Callable[[str], bool] = lambda name: True) -> Iterator[tuple[str, Any]]:
    """Names and answers with a formula of the gallery's systems."""
    from freebody.gallery import entries

    for name, entry in entries().items():
        if names(name):
            for key, answer in entry.run().answers.items():
                if answer.formula is not None:
                    yield f"{name} {key}", answer


def _ways() -> dict[str, Callable[[Any], Any]]:
    import sympy as s

    single = (
        s.simplify, s.factor, s.together, s.powsimp, s.radsimp, s.trigsimp, s.factor_terms, s.cancel, s.ratsimp,
        s.expand, s.sqrtdenest,
    )  # fmt: skip
    after = (s.factor_terms, s.radsimp, s.factor, s.powsimp)
    ways: dict[str, Callable[[Any], Any]] = {"as it is": lambda x: x}
    ways |= {f.__name__: f for f in single}
    ways |= {f"{f.__name__}(simplify)": (lambda x, f=f: f(s.simplify(x))) for f in after}
    ways |= {f"{f.__name__}(trigsimp)": (lambda x, f=f: f(s.trigsimp(x))) for f in (s.factor, s.together)}
    return ways


def sympy_shortest(formula: Any, limit: float = LIMIT) -> tuple[int, str]:
    """Operations and text of the shortest rewriting that SymPy finds; each way has ``limit`` seconds of time."""
    import sympy

    sides = formula.args if isinstance(formula, sympy.Equality) else (formula,)
    results = [_shortest(side, limit) for side in sides]
    return sum(n for n, _ in results), " = ".join(text for _, text in results)


def _shortest(x: Any, limit: float) -> tuple[int, str]:
    import sympy

    best: tuple[int, str] | None = None
    for known in (True, False):
        y = sympy.sympify(x)
        moving = y.atoms(sympy.Derivative, sympy.core.function.AppliedUndef)
        for atom in sorted(moving, key=lambda a: (-sympy.count_ops(a), str(a))):
            dots = atom.derivative_count if atom.is_Derivative else 0
            name = str(atom.expr.func if atom.is_Derivative else atom.func) + "_p" * dots
            y = y.xreplace({atom: sympy.Symbol(name, real=True)})
        if known:
            y = y.xreplace({a: sympy.Symbol(a.name, positive=True) for a in y.free_symbols if a.is_positive})
        for way in _ways().values():
            text = _within(limit, way, y)
            if text is not None and (best is None or operations(text) < best[0]):
                best = (operations(text), text)
    assert best is not None
    return best


def _within(limit: float, way: Callable[[Any], Any], x: Any) -> str | None:
    def late(*_: Any) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, limit)
    try:
        return str(way(x))
    except Exception:  # SymPy gives up in many ways
        return None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def main(quick: bool = False, repeats: int = 1, limit: float = LIMIT) -> None:
    """Print the table of the systems: operations of ours and of SymPy's shortest."""
    stored = json.loads(STORE.read_text(encoding="utf-8"))
    rows: dict[str, list[int]] = {}
    for name, answer in answers():
        if name in stored:
            row = rows.setdefault(name.split()[0], [0, 0, 0, 0])
            ours, theirs = operations(answer.text), stored[name]
            for i, n in enumerate((1, ours, theirs, ours > theirs)):
                row[i] += n
    chapter = [row for name, row in rows.items() if name.startswith(CHAPTER)]
    table = [[name, *row] for name, row in rows.items()]
    table.append(["chapter", *map(sum, zip(*chapter, strict=True))])
    table.append(["all", *map(sum, zip(*rows.values(), strict=True))])
    show(
        "Operations of answers as printed",
        ["system", "formulas", "freebody", "SymPy's shortest", "longer"],
        table,
    )


def store() -> None:
    """Count SymPy's shortest rewritings and store them."""
    counts = {name: sympy_shortest(answer.formula)[0] for name, answer in answers()}
    STORE.write_text(json.dumps(counts, indent=0) + "\n", encoding="utf-8")


if __name__ == "__main__":
    store()
