"""All roots of the conditions of steady motion in numbers, and their continuation along a parameter.

One unknown: roots of a polynomial, in the unknown itself or in exp(i x) of an angle. Several: Newton's method from many
starts. Every root is refined by Newton's method with exact derivatives; its residual, relative to the size of the
terms, and the last step are reported.

Sources: E. L. Allgower, K. Georg, Introduction to Numerical Continuation Methods (2003), chapters 2, 6 and 8.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ..errors import ModelError
from ..scalar.polynomial import Ring
from ..scalar.substitute import Substitution, arrays
from .steady_solve import coefficients, factors

EPS = float(np.finfo(float).eps)
STARTS = 512
STEPS = 60


class Pieces:
    """Polynomials of some unknowns with all else given in numbers, and their exact derivatives."""

    def __init__(self, ring: Ring, pieces: Sequence[Any], unknowns: Sequence[Any], given: Mapping[Any, Any]) -> None:
        self.ring = ring
        self.pieces = list(pieces)
        self.unknowns = list(unknowns)
        self.given = dict(given)
        self.slopes = [[ring.derivative(x, a) for a in unknowns] for x in pieces]
        self.angles = np.array([self._is_angle(a) for a in unknowns], dtype=bool)

    def _is_angle(self, atom: Any) -> bool:
        g = self.ring.find(atom)
        x = self.ring.variable(g.index)  # type: ignore[union-attr]
        used = {one.index: one for piece in self.pieces for one in self.ring.used(piece)}
        depending = [one for one in used.values() if one.depends & 1 << g.index]  # type: ignore[union-attr]
        return bool(depending) and all(one.kind in ("sin", "cos") and one.arguments[0] == x for one in depending)

    def _at(self, x: np.ndarray) -> Substitution:
        return Substitution(self.ring, arrays, {**self.given, **dict(zip(self.unknowns, x, strict=True))})

    def values(self, x: np.ndarray) -> np.ndarray:
        """(m, N) values at the columns of x (n, N)."""
        at = self._at(x)
        return np.array([np.broadcast_to(at(p), x.shape[1:]) for p in self.pieces], dtype=float)

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """(m, n, N)."""
        at = self._at(x)
        return np.array(
            [[np.broadcast_to(at(d), x.shape[1:]) for d in row] for row in self.slopes], dtype=float
        )

    def size(self, x: np.ndarray) -> np.ndarray:
        """Sum of the absolute values of the terms of each polynomial at one point, and of what round-off of x does."""
        at = self._at(x)
        result = []
        near = np.abs(self.jacobian(x)) @ np.maximum(1, np.abs(x)) if len(x) else np.zeros(len(self.pieces))
        for p in self.pieces:
            total = 0
            for monomial, c in p.terms():
                term = abs(c) / p.den
                for index, power in monomial:
                    term = term * abs(float(at.generator(index))) ** power
                total = total + term
            result.append(total)
        return np.array(result, dtype=float) + near

    def newton(self, x: np.ndarray, steps: int = STEPS) -> np.ndarray:
        """Columns of x after damped Newton steps; those that fail are not finite."""
        with np.errstate(all="ignore"):
            for _ in range(steps):
                F, J = self.values(x), self.jacobian(x)
                J = np.moveaxis(J, -1, 0)
                bad = ~np.isfinite(J).all(axis=(1, 2)) | ~np.isfinite(F).all(axis=0)
                J[bad] = np.eye(*J.shape[1:])
                step = -np.linalg.pinv(J) @ F.T[:, :, None]
                step = np.where(bad, np.nan, step[:, :, 0].T)
                most = np.maximum(1, np.abs(x).max(axis=0))
                step = step * np.minimum(1, most / np.maximum(np.abs(step).max(axis=0), EPS * EPS))
                x = x + step
                if (np.abs(step) <= 2 * EPS * np.abs(x) + EPS * EPS)[:, ~bad].all():
                    break
        return x


def roots(ring: Ring, conditions: Sequence[Any], unknowns: Sequence[Any], given: Mapping[Any, Any]) -> list[Any]:
    """(values of the unknowns, relative residual, last Newton step) of every root found.

    An unknown that may have any value at a root is reported as zero.

    Raises
    ------
    ModelError
        Fewer conditions than unknowns on some branch.
    """
    known = set(unknowns)
    choices = []
    for x in conditions:
        pieces = factors(ring, x, known)
        if pieces is None:
            return []
        if pieces:
            choices.append(pieces)
    found: list[Any] = []
    for pieces in product(*choices):
        dead = [p for p in pieces if not ring.atoms_of(p) & known]
        if dead and not all(_vanishes(Pieces(ring, [p], [], given)) for p in dead):
            continue
        live = [p for p in dict.fromkeys(pieces) if ring.atoms_of(p) & known]
        if not live and unknowns:
            continue
        if len(live) < len(unknowns):
            free = sorted({str(a) for p in live for a in ring.atoms_of(p) & known})
            raise Underdetermined(free)
        for root in _of_branch(Pieces(ring, live, unknowns, given)):
            if not any(_same(root[0], other[0]) for other in found):
                found.append(root)
    return sorted(found, key=lambda one: tuple(one[0]))


class Underdetermined(Exception):
    """Fewer conditions than unknowns."""


def _vanishes(one: Pieces) -> bool:
    x = np.zeros((0,))
    value = np.abs(one.values(x))
    return bool((value <= 64 * EPS * one.size(x)).all())


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    return bool((np.abs(a - b) <= np.sqrt(EPS) * (1 + np.abs(a))).all())


def _of_branch(one: Pieces) -> list[Any]:
    n = len(one.unknowns)
    starts = _univariate(one) if n == 1 else None
    if starts is None:
        random = np.random.default_rng(n)
        spread = random.uniform(-1, 1, (n, STARTS)) * np.power(float(10), random.uniform(-2, 2, (n, STARTS)))
        turned = random.uniform(-np.pi, np.pi, (n, STARTS))
        starts = np.where(one.angles[:, None], turned, spread)
        starts = one.newton(starts)
    result: list[Any] = []
    for x in starts.T:
        if not np.isfinite(x).all():
            continue
        x = one.newton(x[:, None], 8)[:, 0]
        if not np.isfinite(x).all():
            continue
        F, size = one.values(x), one.size(x)
        residual = float((np.abs(F) / np.maximum(size, EPS * EPS)).max(initial=0))
        if residual > 1024 * EPS:
            continue
        x = np.where(one.angles, np.pi - np.mod(np.pi - x, 2 * np.pi), x)
        step = float(np.abs(np.linalg.pinv(one.jacobian(x)) @ F).max(initial=0))
        x = np.where(_open(one, x), 0, x)
        if not any(_same(x, other[0]) for other in result):
            result.append((x, residual, step))
    return result


def _open(one: Pieces, x: np.ndarray) -> np.ndarray:
    """Which unknowns may have any value at a root: azimuth of what hangs on the axis."""
    result = np.zeros(len(x), dtype=bool)
    for i in range(len(x)):
        moved = x.copy()
        moved[i] += 1
        result[i] = bool((np.abs(one.values(moved)) <= 1024 * EPS * one.size(moved)).all())
    return result


def _univariate(one: Pieces) -> np.ndarray | None:
    """Starts (1, N) that reach every root of a polynomial in the unknown, or in its sine and cosine."""
    ring, x = one.ring, one.pieces[0]
    if len(one.pieces) != 1:
        return None
    (atom,) = one.unknowns
    index = ring.find(atom).index  # type: ignore[union-attr]
    depending = [g for g in ring.used(x) if g.depends & 1 << index]
    at = Substitution(ring, arrays, one.given)
    if len(depending) == 1 and depending[0].index == index:
        c = coefficients(ring, x, index)
        table = [float(at(c.get(k, 0))) for k in range(max(c), -1, -1)]
        found = np.roots(table)
        near = np.abs(found.imag) <= np.sqrt(EPS) * (np.abs(found) + np.abs(found).max(initial=0) * EPS)
        return found[near].real[None, :]
    if not one.angles[0]:
        return None
    first = depending[0]
    s, c_ = (first.index, first.partner) if first.kind == "sin" else (first.partner, first.index)
    degree = 0
    parts: dict[tuple[int, int], Any] = {}
    for power, rest in coefficients(ring, x, s).items():
        inner = coefficients(ring, ring.coerce(rest), c_)
        for other, value in inner.items():
            parts[power, other] = float(at(value))
            degree = max(degree, power + other)
    # sin = (z - 1/z)/(2i), cos = (z + 1/z)/2, times z^degree
    total = np.zeros(2 * degree + 1, dtype=complex)
    sine, cosine = np.array([1, 0, -1]) / complex(0, 2), np.array([1, 0, 1]) / 2
    for (i, j), value in parts.items():
        term = np.array([value], dtype=complex)
        for factor, times in ((sine, i), (cosine, j)):
            for _ in range(times):
                term = np.convolve(term, factor)
        missing = degree - i - j
        total[missing : len(total) - missing] += term
    found = np.roots(total)
    # double roots lie off the circle by the root of round-off; Newton decides
    near = np.abs(np.abs(found) - 1) <= 1 / np.float64(1024)
    return np.angle(found[near])[None, :]


# -- continuation ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Special:
    """A fold or a bifurcation: where it is, in the parameter and the unknowns."""

    kind: str
    parameter: float
    values: dict[str, float]


@dataclass(frozen=True)
class Branch:
    """Steady motions along a parameter.

    Attributes
    ----------
    parameter : str
    parameters : ndarray, shape (n,)
    values : dict of ndarray, shape (n,)
        Unknowns by name.
    stable : tuple of str
        The verdict at each point.
    special : tuple of Special
        Folds (the branch turns back) and bifurcations (another branch crosses), located.
    """

    parameter: str
    parameters: np.ndarray
    values: dict[str, np.ndarray]
    stable: tuple[str, ...]
    special: tuple[Special, ...]

    @property
    def folds(self) -> tuple[Special, ...]:
        """Where the branch turns back in the parameter."""
        return tuple(one for one in self.special if one.kind == "fold")

    @property
    def bifurcations(self) -> tuple[Special, ...]:
        """Where another branch crosses."""
        return tuple(one for one in self.special if one.kind == "bifurcation")

    def __repr__(self) -> str:
        a, b = self.parameters[0], self.parameters[-1]
        marks = "".join(f", {one.kind} at {one.parameter:.6g}" for one in self.special)
        return f"Branch over {self.parameter} from {a:.6g} to {b:.6g}, {len(self.parameters)} points{marks}"


def follow(
    one: Pieces, start: np.ndarray, span: tuple[float, float], scale: np.ndarray, direction: int, points: int = 400
) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """Points z = (unknowns, parameter) of the branch through ``start``, by pseudo-arclength, and what is special.

    ``one`` has the parameter as its last unknown; ``scale`` is the unit of length of each.
    """

    def tangent(z: np.ndarray, before: np.ndarray | None) -> np.ndarray:
        _, _, V = np.linalg.svd(one.jacobian(z) * scale)
        t = V[-1]
        turn = t @ before if before is not None else t[-1] * direction
        return -t if turn < 0 else t

    def test(z: np.ndarray, t: np.ndarray) -> float:
        return float(np.linalg.det(np.vstack([_unit_rows(one.jacobian(z) * scale), t])))

    def correct(guess: np.ndarray, t: np.ndarray) -> np.ndarray | None:
        z = guess.copy()
        for _ in range(12):
            A = np.vstack([one.jacobian(z) * scale, t])
            right = np.append(one.values(z), t @ ((z - guess) / scale))
            try:
                step = np.linalg.solve(A, right)
            except np.linalg.LinAlgError:
                return None
            z = z - step * scale
            if not np.isfinite(z).all():
                return None
            if np.abs(step).max() <= 64 * EPS * (1 + np.abs(z / scale).max()):
                return z
        return z if np.abs(step).max() <= np.sqrt(EPS) else None

    h = largest = 1 / np.float64(50)
    z = start
    t = tangent(z, None)
    path, special = [z], []
    while len(path) < points:
        new = correct(z + h * t * scale, t)
        if new is None or np.linalg.norm((new - z) / scale) > 2 * h:
            h = h / 2
            if h < np.sqrt(EPS):
                break
            continue
        after = tangent(new, t)
        if t @ after < 1 - 1 / np.float64(50) and h > largest / 64:
            h = h / 2
            continue
        for kind, f in (("fold", lambda z, t: float(t[-1])), ("bifurcation", test)):
            if f(z, t) * f(new, after) < 0:
                special.append((kind, _located(z, t, h, f, correct, tangent, scale)))
        z, t = new, after
        if not min(span) <= z[-1] <= max(span):
            end = _clipped(one, path[-1], z, span)
            if end is not None:
                path.append(end)
            break
        path.append(z)
        h = min(2 * h, largest)
    # a branch that turns back just where another crosses it: that is a bifurcation (pitchfork)
    crossed = [z for kind, z in special if kind == "bifurcation"]
    special = [
        (kind, z)
        for kind, z in special
        if kind != "fold" or not any(np.linalg.norm((z - c) / scale) < np.cbrt(EPS) for c in crossed)
    ]
    return np.array(path), special


def _unit_rows(A: np.ndarray) -> np.ndarray:
    return A / np.maximum(np.linalg.norm(A, axis=1, keepdims=True), EPS * EPS)


def _located(z: np.ndarray, t: np.ndarray, h: float, f: Any, correct: Any, tangent: Any, scale: np.ndarray) -> Any:
    """The point between z and the next where f changes sign, by bisection on the arclength."""
    low, high = 0 * h, h
    at_low = f(z, t)
    best = z
    for _ in range(50):
        mid = (low + high) / 2
        point = correct(z + mid * t * scale, t)
        if point is None:
            break
        best = point
        if f(point, tangent(point, t)) * at_low > 0:
            low = mid
        else:
            high = mid
    return best


def _clipped(one: Pieces, a: np.ndarray, b: np.ndarray, span: tuple[float, float]) -> np.ndarray | None:
    """The point of the branch at the end of the range, between a and b."""
    end = min(span) if b[-1] < min(span) else max(span)
    if b[-1] == a[-1]:
        return None
    z = a + (b - a) * (end - a[-1]) / (b[-1] - a[-1])
    for _ in range(12):
        step = np.linalg.pinv(one.jacobian(z)[:, :-1]) @ one.values(z)
        z[:-1] = z[:-1] - step
    return z if np.isfinite(z).all() else None


def check_span(span: Any) -> tuple[float, float]:
    """A range of two different finite numbers."""
    try:
        a, b = (float(x) for x in span)
    except (TypeError, ValueError):
        raise ModelError(f"Expected a range of two numbers to continue over, such as (1, 5), got {span!r}.") from None
    if not np.isfinite([a, b]).all() or a == b:
        raise ModelError(f"Expected a range of two different finite numbers to continue over, got {span!r}.")
    return a, b
