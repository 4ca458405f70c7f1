"""(a) Equations: mass matrix and bias of chains, against SymPy's ``KanesMethod``, then ``simplify``.

freebody's result is canonical (equal expressions are identical, zero is recognised); SymPy's is not before
``simplify``, and not always after it.
"""

from __future__ import annotations

from typing import Any

from .tables import NOT_INSTALLED, module, ratio_text, seconds, show, time_text

SIZES = {"planar": (2, 3, 4, 5, 6, 7, 8, 9, 10), "spatial": (2, 3, 4, 5, 6)}
QUICK = {"planar": (2, 3, 10), "spatial": (2, 3, 6)}
AGREEMENT = 1e-12
TITLES = {
    "planar": "Equations of planar chains of n bars, absolute angles",
    "spatial": "Equations of spatial chains of n bodies, hinge axes x, y, x, ...",
}


def ours(kind: str, n: int, repeats: int) -> dict[str, float]:
    """Times [s]: canonical M and bias from the described system on; then also as text; then also as LaTeX."""
    import freebody as fb

    from .models import BUILDERS

    system = BUILDERS[kind](n)

    def form() -> Any:
        equations = fb.equations(system)
        return equations, equations.canonical_mass_matrix, equations.canonical_bias

    form()  # imports
    return {
        "form": seconds(form, repeats),
        "text": seconds(lambda: form()[0].text(), max(1, repeats // 2)),
        "latex": seconds(lambda: form()[0].latex(), max(1, repeats // 2)),
    }


def difference(kind: str, n: int) -> float:
    """Largest difference of M and bias between freebody and SymPy at a random state and random parameters."""
    import random

    import freebody as fb

    from .models import BUILDERS
    from .sympy_chains import form

    system = BUILDERS[kind](n)
    equations = fb.equations(system)
    mass, forcing = form(kind, n)
    choose = random.Random(n)
    numbers: dict[str, float] = {}

    def values(expressions: Any) -> list[float]:
        atoms: dict[Any, float] = {}
        for expression in expressions:
            for atom in (
                expression.atoms(sympy.Derivative, sympy.core.function.AppliedUndef) | expression.free_symbols
            ):
                # SymPy's speed u1 is our derivative of q1
                name = (
                    f"u{str(atom.args[0].func)[1:]}"
                    if atom.is_Derivative
                    else str(getattr(atom, "name", atom.func))
                )
                if name not in numbers:
                    numbers[name] = choose.uniform(0.3, 1.5)
                atoms[atom] = numbers[name]
        # derivatives before what they derive, functions of time before the time
        order = sorted(atoms, key=lambda atom: (not atom.is_Derivative, not atom.is_Function))
        found = []
        for expression in expressions:
            for atom in order:
                expression = expression.xreplace({atom: sympy.Float(atoms[atom], 30)})
            found.append(float(expression.evalf(20)))
        return found

    import sympy

    ours_found = values([*equations.mass_matrix, *(-h for h in equations.bias)])
    theirs = values([*mass, *forcing])
    return max(abs(a - b) for a, b in zip(ours_found, theirs, strict=True))


def sympy_form(kind: str, n: int, repeats: int) -> float:
    """Median time [s] of ``KanesMethod`` to mass matrix and forcing, SymPy's cache emptied each time."""
    from sympy.core.cache import clear_cache

    from .sympy_chains import form

    return seconds(lambda: form(kind, n), repeats, before=clear_cache)


def main(quick: bool = False, repeats: int = 5, limit: float = 185.0) -> None:
    """Print the two tables."""
    installed = module("sympy") is not None
    for kind, sizes in (QUICK if quick else SIZES).items():
        rows = []
        stopped = False
        for n in sizes:
            mine = ours(kind, n, repeats)
            if not installed:
                rows.append(
                    [n, *(time_text(mine[k]) for k in ("form", "text", "latex")), *[NOT_INSTALLED] * 6]
                )
                continue
            from .sympy_chains import simplified

            if n <= 3 and not difference(kind, n) < AGREEMENT:
                raise ArithmeticError(
                    f"the {kind} chains of {n} bodies differ: these are not the same machine"
                )
            form = sympy_form(kind, n, max(1, min(3, repeats)))
            late = f"> {limit:.0f} s"
            after = dict.fromkeys(("simplify", "text"), late) if stopped else simplified(kind, n, limit)
            stopped = stopped or after["simplify"] == late
            both = after["simplify"] if isinstance(after["simplify"], str) else form + after["simplify"]
            read = late if isinstance(after["text"], str) else both + after["text"]
            rows.append(
                [
                    n,
                    time_text(mine["form"]),
                    time_text(mine["text"]),
                    time_text(mine["latex"]),
                    time_text(form),
                    ratio_text(form, mine["form"]),
                    time_text(after["simplify"]),
                    ratio_text(both, mine["form"]),
                    time_text(read),
                    ratio_text(read, mine["text"]),
                ]
            )
        show(
            TITLES[kind],
            [
                "n",
                "freebody canonical",
                "to text",
                "to LaTeX",
                "SymPy Kane",
                "ratio",
                "+ simplify",
                "ratio",
                "to text",
                "ratio",
            ],
            rows,
            [
                "freebody: fb.equations(s) to canonical mass matrix and bias, anew each time; text, LaTeX include it.",
                "SymPy: KanesMethod to mass_matrix and forcing (cache emptied); then simplify, then pretty,",
                f"in a child process ended {limit:.0f} s after the forming; larger sizes are then skipped.",
            ],
        )
