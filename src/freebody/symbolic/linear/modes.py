"""Modes of linear equations: frequency, damping ratio, shape.

    (M s² + C s + K) X = 0,      frequency |s|,      damping ratio -Re s / |s|

Roots at zero are split off before the others are computed. A rigid-body mode and its constant rate form a Jordan block,
whose double root would otherwise be known only to the square root of the precision.

Source: Golub & Van Loan, Matrix Computations (4th ed.), §7.6.5 (staircase of null spaces); Meirovitch (1970), §8.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ...scalar.polynomial import Ring
from ..printing.closed.expressions import Closed
from ..printing.latex import latex_name, latex_number
from ..printing.lines import Lines, Result, assignments
from ..printing.show import latex_of

Array = NDArray[Any]
NULL = 10**-10
"""Relative size below which a singular value is zero; entries of the matrices are exact or have round-off only."""
SAME = 10**-7
"""Relative distance below which roots count as one multiple root."""


@dataclass(frozen=True, eq=False)
class Mode(Lines):
    """One mode: a pair of complex roots, a real root, or a root at zero.

    Attributes
    ----------
    kind : str
        ``oscillation``, ``decay``, ``growth``, ``rigid body`` (a shape without stiffness) or ``drift``
        (a constant rate).
    eigenvalue : complex or expression
        s, with Im s >= 0 [1/s].
    frequency, damping_ratio : float or expression
        |s| [rad/s], -Re s / |s| (0 if s is zero).
    shape : dict
        Component of each coordinate, divided by the largest (numeric) or the first (symbolic) one.
    """

    kind: str
    eigenvalue: Any
    frequency: Any
    damping_ratio: Any
    shape: dict[str, Any]
    ring: Ring | None = field(default=None, repr=False)

    def shown(self, x: Any) -> Any:
        """Return a number, or an expression that prints in closed form."""
        return Closed(x, self.ring) if self.ring is not None else x

    def _lines(self) -> list[list[Any]]:
        head = [
            f"{self.kind}: frequency ",
            self.shown(self.frequency),
            ", damping ratio ",
            self.shown(self.damping_ratio),
        ]
        return [[*head, "; ", *assignments((name, self.shown(x)) for name, x in self.shape.items())]]


class Modes(Result, Sequence[Mode]):
    """The modes of a linear model, lowest frequency first; prints as a table."""

    def __init__(self, modes: Sequence[Mode], all_eigenvalues: Any) -> None:
        self._modes = tuple(modes)
        self.all_eigenvalues = all_eigenvalues
        """Every root, with repetitions."""

    def __getitem__(self, i: Any) -> Any:
        return self._modes[i]

    def __iter__(self) -> Iterator[Mode]:
        return iter(self._modes)

    def __len__(self) -> int:
        return len(self._modes)

    def _rows(self) -> tuple[list[str], list[list[Any]]]:
        names = list(self._modes[0].shape) if self._modes else []
        head = ["mode", "kind", "frequency", "damping ratio", *names]
        return head, [
            [k + 1, m.kind, *map(m.shown, (m.frequency, m.damping_ratio, *m.shape.values()))]
            for k, m in enumerate(self._modes)
        ]

    def text(self) -> str:
        """The table as plain text."""
        head, rows = self._rows()
        cells = [head, *([_text(x) for x in row] for row in rows)]
        widths = [max(len(row[i]) for row in cells) for i in range(len(head))]
        return "\n".join(
            "  ".join(
                cell.ljust(w) if i == 1 else cell.rjust(w)
                for i, (cell, w) in enumerate(zip(row, widths, strict=True))
            )
            for row in cells
        )

    def latex(self) -> str:
        """The table as a LaTeX ``array``."""
        head, rows = self._rows()
        titles = [rf"\text{{{x}}}" for x in head[:4]] + [latex_name(x) for x in head[4:]]
        lines = [" & ".join(titles) + r" \\ \hline"]
        lines += [" & ".join(_latex(x) for x in row) + r" \\" for row in rows]
        return (
            rf"\begin{{array}}{{rl{'r' * (len(head) - 2)}}}" + "\n" + "\n".join(lines) + "\n" + r"\end{array}"
        )


def _rounded(x: Any) -> Any:
    if isinstance(x, complex | np.complexfloating):
        real, imag = (float(f"{part:.6g}") for part in (x.real, x.imag))
        return complex(real, imag) if imag else real
    return float(f"{x:.6g}") if isinstance(x, float | np.floating) else x


def _text(x: Any) -> str:
    if isinstance(x, str):
        return x
    if isinstance(x, Closed):
        return x.text()
    x = _rounded(x)
    if isinstance(x, complex):
        return f"{x.real:g}{x.imag:+g}i"
    return f"{x:g}" if isinstance(x, float) else str(x)


def _latex(x: Any) -> str:
    if isinstance(x, str):
        return rf"\text{{{x}}}"
    if isinstance(x, Closed):
        return x.latex()
    return latex_of(x) if isinstance(x, sympy.Basic) else latex_number(x)


# -- numbers --------------------------------------------------------------------------------------


def eigenvalues(A: Array) -> Array:
    """Return all eigenvalues by magnitude; those at zero are exactly zero."""
    levels, reduced = _staircase(A)
    zeros = sum(len(level) for level in levels)
    return _sorted(
        np.concatenate([np.zeros(zeros), np.linalg.eigvals(reduced) if reduced.size else np.zeros(0)])
    )


def _staircase(A: Array) -> tuple[list[Array], Array]:
    """Return the generalized eigenvectors of the zero roots, level by level, and the matrix of the other roots.

    The first level is the null space of A; A maps each other level into the span of the levels before it.
    """
    from scipy.linalg import matrix_balance

    reduced, scaling = matrix_balance(A, permute=False)
    basis = scaling
    levels: list[Array] = []
    while reduced.size:
        _, sizes, right = np.linalg.svd(reduced)
        null = int(np.sum(sizes <= NULL * max(sizes[0], np.finfo(float).tiny)))
        if null == 0:
            break
        # in the basis (null space, its complement) the matrix is [0 *; 0 reduced]
        complement, vectors = right[: len(reduced) - null], right[len(reduced) - null :]
        levels.append((basis @ vectors.T).T)
        basis = basis @ complement.T
        reduced = complement @ reduced @ complement.T
    return levels, reduced


def _sorted(s: Array) -> Array:
    s = np.asarray(s, dtype=complex)
    return s[_order(s)]


def _order(s: Array) -> Array:
    """Return the order by magnitude, then real part, then upper half plane first; round-off is ignored."""
    size = np.abs(s)
    top = size.max(initial=0)
    key = [float(f"{x:.9e}") if x > NULL * top else 0 for x in size]
    real = [float(f"{x:.6e}") if abs(x) > NULL * top else 0 for x in s.real]
    return np.lexsort((-s.imag, np.array(real), np.array(key)))


def modes_of(linear: Any) -> Modes:
    """Return the modes of a numeric :class:`LinearModel`."""
    M, C, K = (np.asarray(linear.canonical[key], dtype=float) for key in "MCK")
    names = (*linear.coordinates, *linear.carried)
    if not linear.carried and _is_conservative(M, C, K):
        return _conservative(M, K, names)
    A = linear.first_order[0]
    levels, reduced = _staircase(A)
    zeros = sum(len(level) for level in levels)
    roots = _sorted(np.linalg.eigvals(reduced)) if reduced.size else np.zeros(0, dtype=complex)
    result = _at_zero(levels[0][:, : len(names)], names, "rigid body") if levels else []
    for level in levels[1:]:
        result += _at_zero((level @ A.T)[:, : len(names)], names, "drift")
    distinct: list[complex] = []
    for s in roots:
        if s.imag < 0 or any(abs(s - other) <= SAME * abs(s) for other in distinct):
            continue
        distinct.append(s)
        times = int(np.sum(np.abs(roots - s) <= SAME * abs(s)))
        vectors = np.linalg.svd(A - s * np.eye(len(A)))[2][-times:].conj()
        result += [_mode(s, _shape(names, vector[: len(names)])) for vector in vectors[::-1]]
    return Modes(result, np.concatenate([np.zeros(zeros, dtype=complex), roots]))


def _mode(s: complex, shape: dict[str, Any]) -> Mode:
    real, imag = float(s.real), float(s.imag)
    size = abs(s)
    if abs(imag) <= NULL * size:
        imag = 0
    if abs(real) <= np.finfo(float).eps * len(shape) * 10 * size:
        real = 0
    kind = "oscillation" if imag else "decay" if real < 0 else "growth"
    return Mode(kind, complex(real, imag), float(size), -real / float(size), shape)


def _at_zero(vectors: Array, names: Sequence[str], kind: str) -> list[Mode]:
    zero = float(0)
    return [Mode(kind, complex(0), zero, zero, _shape(names, v)) for v in _echelon(np.array(vectors))]


def _echelon(vectors: Array) -> Array:
    """Return a basis of the same span in which each vector has a leading coordinate that the others lack."""
    rows = 0
    for column in range(vectors.shape[1]):
        if rows == len(vectors):
            break
        k = rows + int(np.argmax(np.abs(vectors[rows:, column])))
        if abs(vectors[k, column]) <= SAME * np.abs(vectors).max():
            continue
        vectors[[rows, k]] = vectors[[k, rows]]
        vectors[rows] /= vectors[rows, column]
        for other in range(len(vectors)):
            if other != rows:
                vectors[other] -= vectors[other, column] * vectors[rows]
        rows += 1
    return vectors[:rows]


def _shape(names: Sequence[str], vector: Array) -> dict[str, Any]:
    """Return the components divided by the largest; the first, if several are equal up to round-off."""
    sizes = np.abs(vector)
    largest = int(np.argmax(sizes >= (1 - SAME) * sizes.max()))
    parts = vector / vector[largest]
    real, imag = (np.where(np.abs(x) <= NULL, 0, x) for x in (parts.real, np.imag(parts)))
    parts = real + complex(0, 1) * imag if np.any(imag) else real
    return {name: x.item() for name, x in zip(names, parts, strict=True)}


def _is_conservative(M: Array, C: Array, K: Array) -> bool:
    """Return True if there are no velocity terms and the stiffness is symmetric."""
    speed = np.sqrt(np.abs(K).max(initial=0) * np.abs(M).max(initial=0))
    return bool(
        np.abs(C).max(initial=0) <= np.finfo(float).eps * speed
        and np.abs(K - K.T).max(initial=0) <= 100 * np.finfo(float).eps * np.abs(K).max(initial=0)
    )


def _conservative(M: Array, K: Array, names: Sequence[str]) -> Modes:
    """Return the modes of M ξ'' + K ξ = 0; w² come from a symmetric eigenproblem, to full precision."""
    from scipy.linalg import eigh

    squares, shapes = eigh((K + K.T) / 2, M)
    rigid = np.abs(squares) <= NULL * np.abs(squares).max(initial=0)
    result = _at_zero(shapes[:, rigid].T, names, "rigid body")
    result += _at_zero(shapes[:, rigid].T, names, "drift")
    roots: list[complex] = [complex(0)] * (2 * int(np.sum(rigid)))
    for k in np.flatnonzero(~rigid):
        w = float(np.sqrt(abs(squares[k])))
        pair = [complex(0, w), complex(0, -w)] if squares[k] > 0 else [complex(-w), complex(w)]
        roots += pair
        shape = _shape(names, shapes[:, k])
        result += [_mode(s, shape) for s in pair if s.imag >= 0]
    return Modes(sorted(result, key=lambda mode: mode.frequency), _sorted(np.array(roots)))
