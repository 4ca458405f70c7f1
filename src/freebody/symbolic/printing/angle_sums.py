"""The printed forms of a trigonometric coefficient, computed on dictionaries of terms.

A coefficient is ``{monomial: {parameters: integer}}`` over one power of two: the monomial contains
sines, cosines and coordinates, and the parameters are its factor. Its canonical form has no
sin². The shortest of these forms is printed:

- sines and cosines in canonical form, or with cos² = 1 - sin², or homogeneous (I₁ sin² + I₃ cos²);
- sums of angles, cos a cos b = ½ cos(a - b) + ½ cos(a + b), which collapse for parallel axes.

In a monomial a generator is ``(index, exponent)``, a sine or cosine of a sum of angles is
``("sin" | "cos", ((index of the angle's cosine, multiple), ...))``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import combinations, product
from typing import Any

Monomial = tuple[Any, ...]
Row = dict[Any, int]
Coefficient = dict[Monomial, Row]
Split = tuple[int, int, Monomial]
"""A monomial as the powers of the sine and the cosine of one angle, and the other factors."""

LARGEST = 4000
"""Number of terms beyond which a coefficient is printed in its canonical form: nobody reads it."""
_DEGREE = 12
"""Largest degree of a product of sines and cosines that is expanded into sums of angles."""
_WAVES = 2**18
"""Most sines and cosines of sums to form in the search for the shortest form: half a second."""


def shortest(ring: Any, coefficient: Coefficient, rank: Callable[[int], Any]) -> tuple[Coefficient, int]:
    """Return the form with the fewest terms, and the power of two by which it is to be divided.

    ``rank`` orders generators; the first angle of a sum is positive.
    Ties go to the earlier of: canonical, homogeneous, sin², angle sums.
    """
    size = _size(coefficient)
    pairs = _pairs(ring, coefficient)
    if size < 2 or size > LARGEST or not pairs:
        return coefficient, 1
    best = _squares(ring, coefficient, {c: d for c, d in pairs.items() if d > 1})
    best_size, power = _size(best), 1
    for angles in _sets(pairs, size):
        sums, p = angle_sums(ring, coefficient, angles, rank)
        if sums and len(sums) < 2 * best_size:
            sums = _squares(ring, sums, {c: d for c, d in pairs.items() if d > 1 and c not in angles})
            n = _size(sums)
            if n < best_size:
                best, best_size, power = sums, n, p
    return best, power


def _squares(ring: Any, coefficient: Coefficient, pairs: dict[int, int]) -> Coefficient:
    """Return the shortest form that sin² + cos² = 1 gives, angle by angle."""
    size = _size(coefficient)
    for cosine in pairs:
        sine = ring.generators[cosine].partner
        before = split = [(_split(m, cosine, sine), row) for m, row in coefficient.items()]
        for form in (_homogeneous, _without_cosines):
            changed = form(split)
            n = size if changed is None else sum(map(len, changed.values()))
            if changed is not None and n < size:
                split, size = list(changed.items()), n
        if split is not before:
            coefficient = {_join(key, cosine, sine): row for key, row in split}
    return coefficient


def _size(coefficient: Coefficient) -> int:
    return sum(map(len, coefficient.values()))


def _pairs(ring: Any, coefficient: Coefficient) -> dict[int, int]:
    """Return {index of an angle's cosine: largest degree of its sine and cosine together}."""
    generators = ring.generators
    result: dict[int, int] = {}
    divided = set()
    for monomial in coefficient:
        degrees: dict[int, int] = {}
        for index, e in monomial:
            g = generators[index]
            if g.kind not in ("sin", "cos"):
                continue
            cosine = index if g.kind == "cos" else g.partner
            degrees[cosine] = degrees.get(cosine, 0) + e
            if e < 0:  # 1/cos is not rewritten
                divided.add(cosine)
        for index, d in degrees.items():
            if d > result.get(index, 0):
                result[index] = d
    return {index: d for index, d in result.items() if index not in divided}


def _sets(pairs: dict[int, int], size: int) -> list[frozenset[int]]:
    """Return the sets of angles to expand into sums: all angles; for a short coefficient also every pair."""
    if len(pairs) < 2 and max(pairs.values()) < 2:
        return []
    sets = [frozenset(pairs)]
    if 2 < len(pairs) <= 8 and size <= 60:
        sets += map(frozenset, combinations(pairs, 2))
    return sets


def _split(monomial: Monomial, cosine: int, sine: int) -> Split:
    """Return the powers of a sine and a cosine in a monomial, and its other factors."""
    s = c = 0
    cofactor = []
    for factor in monomial:
        if factor[0] == cosine:
            c = factor[1]
        elif factor[0] == sine:
            s = factor[1]
        else:
            cofactor.append(factor)
    return s, c, tuple(cofactor)


def _join(key: Split, cosine: int, sine: int) -> Monomial:
    s, c, cofactor = key
    new = list(cofactor)
    if s:
        new.append((sine, s))
    if c:
        new.append((cosine, c))
    new.sort(key=_newest_first)
    return tuple(new)


def _newest_first(factor: tuple[Any, Any]) -> Any:
    return (1, 0) if isinstance(factor[0], str) else (0, -factor[0])


def _without_cosines(split: list[tuple[Split, Row]]) -> dict[Split, Row] | None:
    """Substitute cos² = 1 - sin² for one angle; None if it changes nothing."""
    if all(c < 2 for (_, c, _), _ in split):
        return None
    result: dict[Split, Row] = {}
    for (s, c, cofactor), parameters in split:
        for k, binomial in enumerate(_binomials(c // 2)):
            _add(result, (s + 2 * k, c % 2, cofactor), parameters, (-1) ** k * binomial)
    return result


def _homogeneous(split: list[tuple[Split, Row]]) -> dict[Split, Row] | None:
    """Multiply by sin² + cos² of one angle up to the largest degree of the same parity; None if it changes nothing."""
    degrees = {s + c for (s, c, _), _ in split}
    largest = {n % 2: n for n in sorted(degrees)}
    if len(degrees) == len(largest):
        return None
    result: dict[Split, Row] = {}
    for (s, c, cofactor), parameters in split:
        missing = (largest[(s + c) % 2] - s - c) // 2
        for k, binomial in enumerate(_binomials(missing)):
            _add(result, (s + 2 * k, c + 2 * (missing - k), cofactor), parameters, binomial)
    return result


@cache
def _binomials(n: int) -> tuple[int, ...]:
    row = [1]
    for k in range(n):
        row.append(row[-1] * (n - k) // (k + 1))
    return tuple(row)


def _add(result: dict[Any, Row], monomial: Any, parameters: Row, factor: int) -> None:
    row = result.get(monomial)
    if row is None:
        result[monomial] = (
            parameters.copy() if factor == 1 else {key: factor * value for key, value in parameters.items()}
        )
        return
    for key, value in parameters.items():
        total = row.get(key, 0) + factor * value
        if total:
            row[key] = total
        else:
            del row[key]
    if not row:
        del result[monomial]


def angle_sums(
    ring: Any, coefficient: Coefficient, angles: frozenset[int], rank: Callable[[int], Any]
) -> tuple[Coefficient, int]:
    """Return the coefficient with products of sines and cosines of ``angles`` as sums, and its power of two.

    sinᵃx cosᵇx = Σ_n z_n exp(i n x), with exact z_n. Series of several angles are multiplied; the terms
    of n and -n together are a sine or a cosine.
    """
    generators = ring.generators
    split = []
    largest = waves = 0
    for monomial, parameters in coefficient.items():
        cofactor = []
        powers: dict[int, list[int]] = {}
        for factor in monomial:
            g = generators[factor[0]]
            if g.kind == "cos" and factor[0] in angles:
                powers.setdefault(factor[0], [0, 0])[1] = factor[1]
            elif g.kind == "sin" and g.partner in angles:
                powers.setdefault(g.partner, [0, 0])[0] = factor[1]
            else:
                cofactor.append(factor)
        key = tuple((index, s, c) for index, (s, c) in sorted(powers.items(), key=lambda item: rank(item[0])))
        degree = sum(s + c for _, s, c in key)
        if degree > _DEGREE:
            return {}, 1
        largest = max(largest, degree)
        waves += 2**degree * len(parameters)
        if waves > _WAVES:
            return {}, 1
        split.append((key, degree, tuple(cofactor), parameters))
    result: Coefficient = {}
    for key, degree, cofactor_key, parameters in split:
        scale = 2 ** (largest - degree)
        for wave, value in _waves(key):
            _add(result, (*cofactor_key, wave) if wave else cofactor_key, parameters, scale * value)
    return result, 2**largest


@cache
def _waves(powers: tuple[tuple[int, int, int], ...]) -> tuple[tuple[Any, int], ...]:
    """Return Π sinˢ cosᶜ times 2^degree as ((wave, integer), ...); wave () is the constant 1."""
    spectra = []
    odd = 0
    for index, s, c in powers:
        odd += s
        spectra.append([(index, n, z) for n, z in _spectrum(s, c)])
    # (1/i)^odd: the sum of exp(i a) is a sum of (-1)^(odd/2) cos a, or of (-1)^((odd-1)/2) sin a
    sign = (-1) ** (odd // 2)
    result: dict[Any, int] = {}
    for parts in product(*spectra):
        value = sign
        angle = []
        for index, n, z in parts:
            value *= z
            if n:
                angle.append((index, n))
        if not angle:
            if odd % 2 == 0:
                result[()] = result.get((), 0) + value
            continue
        if angle[0][1] < 0:
            angle = [(index, -n) for index, n in angle]
            value = -value if odd % 2 else value
        wave = ("sin" if odd % 2 else "cos", tuple(angle))
        result[wave] = result.get(wave, 0) + value
    return tuple((wave, value) for wave, value in result.items() if value)


@cache
def _spectrum(s: int, c: int) -> tuple[tuple[int, int], ...]:
    """Return (z - 1/z)ˢ (z + 1/z)ᶜ as ((power of z, integer), ...)."""
    row = {0: 1}
    for sign in (-1,) * s + (1,) * c:
        new: dict[int, int] = {}
        for n, value in row.items():
            new[n + 1] = new.get(n + 1, 0) + value
            new[n - 1] = new.get(n - 1, 0) + sign * value
        row = new
    return tuple((n, value) for n, value in row.items() if value)
