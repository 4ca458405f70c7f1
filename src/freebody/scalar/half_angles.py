"""Unique form of a fraction of sines and cosines, by the tangents of half angles.

    t = tan(x/2),   sin x = 2t/(1 + t²),   cos x = (1 - t²)/(1 + t²)

Modulo sin² + cos² = 1 a fraction has many reduced forms: 1/(1 + cos x) = (1 - cos x)/sin² x. In t it is a fraction
of plain polynomials, whose reduced form is unique. This form decides what is printed: its poles give the powers of
sin x and cos x, the factors 1 ± cos x and 1 ± sin x, and the other polynomials of the denominator; the rest is the
numerator. Hyperbolic functions are treated in the same way with tanh(x/2). Of commensurable angles x/n, the widest is
used in which the fraction can be written: tan(x/2) is a function of x.

A polynomial of degree 2k in t over (1 + t²)^k is a polynomial in sin x and cos x. If the denominator has an odd degree,
numerator and denominator are multiplied by one more factor: sin x/(1 + cos x) or (1 - cos x)/sin x. The shorter form is
chosen, and of two forms of equal length the one with fewer poles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import lcm
from typing import Any, NamedTuple

from flint import Ordering, fmpz_mpoly_ctx

from .angles import sine_and_cosine
from .element import Polynomial, element

LONGEST = 20_000
"""Estimated number of terms in t beyond which a fraction keeps its form."""
KINDS = {"sin": "sin", "cos": "sin", "sinh": "sinh", "cosh": "sinh"}
"""Kinds of the generators of angles -> the first kind of their pair."""


@dataclass(frozen=True)
class HalfAngles:
    """``top / below``, elements of a new ring that contains nothing else.

    Attributes
    ----------
    ring : Ring
    top, below : Polynomial or number
    longest : int
        Terms of the longest factor of the denominator with a sine or cosine.
    """

    ring: Any
    top: Any
    below: Any
    longest: int

    @property
    def whole(self) -> Any:
        """The fraction as an element of its ring."""
        return self.ring.coerce(self.ring.quotient(self.ring.coerce(self.top), self.ring.coerce(self.below)))


@dataclass(frozen=True)
class _Form:
    """``top / (content · Π factorsⁿ)``."""

    top: Any
    content: Any
    factors: tuple[tuple[Any, int], ...]

    def size(self) -> int:
        """Number of terms in the printed form."""
        return _size(self.top) + sum(_size(f) for f, _ in self.factors)


@dataclass(slots=True)
class _Angle:
    """An angle, 1/level of a monomial, and its sines and cosines: generator -> (True for the sine, multiple)."""

    kind: str
    unit: Any  # the element at level 1
    level: int
    members: dict[int, tuple[bool, int]]
    t: Any = None
    place: int = 0
    sine: Any = None
    cosine: Any = None

    @property
    def sign(self) -> int:
        return 1 if self.kind == "sin" else -1

    def units(self) -> list[Any]:
        """Polynomials in t that are nowhere zero where the angle is finite: 1 + t², or 1 - t and 1 + t."""
        return [1 + self.t * self.t] if self.sign > 0 else [1 - self.t, 1 + self.t]


def half_angles(x: Any, below: Any = 1) -> HalfAngles | None:
    """Return the form of ``x / below`` that is the same for all equal fractions.

    Parameters
    ----------
    x, below : Polynomial or number

    Returns
    -------
    HalfAngles or None
        None if the denominator has no sine or cosine, if it has a root, an absolute value or the square of a
        quaternion's component, and if the polynomials in t have more than ``LONGEST`` terms.
    """
    ring = next((e.ring for e in (x, below) if type(e) is Polynomial), None)
    if ring is None or not _divides(x, below):
        return None
    key = ("half angles", ring.coerce(x), ring.coerce(below), len(ring.positive))
    if key not in ring.cache:
        ring.cache[key] = None
        if _cleared_size(x) * _cleared_size(below) <= LONGEST:
            ring.cache[key] = _form(ring, ring.coerce(x), ring.coerce(below))
    form: HalfAngles | None = ring.cache[key]
    return form


def _divides(x: Any, below: Any) -> bool:
    """True if a sine or cosine occurs in a denominator."""
    if type(below) is Polynomial and any(g.kind in KINDS for g in below.ring.used(below)):
        return True
    for e in (x, below):
        # the mask of an element is known and contains all generators that occur
        if type(e) is Polynomial and (mask := e.mask & _divisors(e.ring)) and mask & e.ring.support(e.num):
            return True
    return False


def _divisors(ring: Any) -> int:
    """Mask of the inverse generators whose argument contains a sine or cosine."""
    count, mask = ring.cache.get("divided by angles", (0, 0))
    if count < len(ring.generators):
        for g in ring.generators[count:]:
            if g.kind == "inverse" and any(h.kind in KINDS for h in ring.used(g.arguments[0])):
                mask |= 1 << g.index
        ring.cache["divided by angles"] = len(ring.generators), mask
    return int(mask)


def _cleared_size(x: Any) -> int:
    """Estimated number of terms of an element times the reciprocals of its inverse generators."""
    if type(x) is not Polynomial:
        return 1
    ring = x.ring
    size = len(x)
    degrees = ring.promoted(x.num).degrees()
    for g in ring.used(x):
        if g.kind == "inverse":
            size *= len(g.arguments[0]) ** max(int(degrees[-1 - g.index]), 0)
    return size


def _form(ring: Any, x: Polynomial, divisor: Polynomial) -> HalfAngles | None:
    """:func:`half_angles` without the cache and the first checks."""
    (num, den), (top, low) = _cleared(ring, x), _cleared(ring, divisor)
    num, den = num * low, den * top
    scale = Fraction(divisor.den, x.den)
    below = ring.of_mask(ring.support(den))
    if not num or not any(g.kind in KINDS for g in below):
        return None
    if any((1 << g.index) & ring.relations.squares and g.kind not in KINDS for g in below):
        return None
    angles = _angles(ring, below, ring.of_mask(ring.support(num)))
    replaced = {i for angle in angles for i in angle.members}
    for g in reversed(ring.of_mask(ring.support(num))):
        if 1 << g.index in ring.relations.square and g.index not in replaced:
            num = num % ring.relations.square[1 << g.index]
    mask = ring.support(num) | ring.support(den)
    unchanged = sorted({g.index for g in ring.of_mask(mask)} - replaced, key=lambda i: _rank(ring, i))
    names = (*(f"t{k}" for k in range(len(angles))), *(f"x{k}" for k in range(len(unchanged))))
    context = fmpz_mpoly_ctx.get(names, Ordering.lex)
    for place, (angle, t) in enumerate(zip(angles, context.gens(), strict=False)):
        angle.t, angle.place = t, place
    first, second = (_in_half_angles(ring, x, angles, unchanged, context) for x in (num, den))
    if first is None or second is None:
        return None
    (above, high), (under, deep) = first, second
    for angle, a, b in zip(angles, high, deep, strict=True):
        unit = 1 + angle.sign * angle.t * angle.t
        above, under = above * unit ** max(b - a, 0), under * unit ** max(a - b, 0)
    common = above.gcd(under)
    above, under = above // common, under // common
    for angle in angles:
        above, under = _widest(above, under, angle)
    new = _fresh(ring, [*unchanged, *replaced])
    for angle in angles:
        x = new.coerce(new.from_sympy(ring.to_sympy(angle.unit)) * Fraction(1, angle.level))
        angle.sine, angle.cosine = sine_and_cosine(new, angle.kind, x)
    atoms = [new.from_sympy(ring.to_sympy(ring.variable(i))) for i in unchanged]
    form = _shortest(new, above, under, angles, atoms, scale)
    total = form.content
    for x, n in form.factors:
        total = total * x**n
    return HalfAngles(new, form.top, total, max((_size(x) for x, _ in form.factors), default=0))


def _cleared(ring: Any, x: Polynomial) -> tuple[Any, Any]:
    """(numerator, denominator) of x without inverse generators; the relations are not used, since they hold in t."""
    num, den = ring.promoted(x.num), ring.promoted(ring.one.num)
    while True:
        inverses = [g for g in ring.of_mask(ring.support(num) | ring.support(den)) if g.kind == "inverse"]
        if not inverses:
            return num, den
        index = inverses[-1].index
        p = ring.promoted(inverses[-1].arguments[0].num)
        (num, n), (den, m) = _times(ring, num, index, p), _times(ring, den, index, p)
        num, den = num * p ** max(m - n, 0), den * p ** max(n - m, 0)


def _times(ring: Any, x: Any, index: int, p: Any) -> tuple[Any, int]:
    """(x pⁿ, n) of x = Σ a_k i^k with i = 1/p: Σ a_k p^(n-k)."""
    place = ring.capacity - 1 - index
    n = max(int(x.degrees()[place]), 0)
    total = x * 0
    for k in range(n + 1):
        total = total + x.subs({f"g{index}": 0}) * p ** (n - k)
        x = x.derivative(place) // (k + 1)
    return total, n


def _fresh(ring: Any, used: Sequence[int]) -> Any:
    """A new ring with only the atoms that some generators depend on, declared as in the old ring."""
    mask = 0
    for i in used:
        mask |= ring.generators[i].depends | (1 << i if ring.generators[i].atom is not None else 0)
    new = type(ring)()
    atoms = sorted((g for g in ring.of_mask(mask) if not g.arguments), key=lambda g: g.rank)
    for g in atoms:
        new.generator(g.atom, g.kind)
        copy = new.find(g.atom)
        copy.positive = g.positive
        if not g.depends:  # π
            copy.depends = 0
    angles = (ring.variable(g.index) for g in ring.generators if g.positive and g.kind in ("sin", "cos"))
    for x in (*angles, *ring.positive):
        if not ring.depends(x) & ~mask:
            new.assume_positive(ring.to_sympy(x))
    return new


# -- to half angles -------------------------------------------------------------------------------


def _rank(ring: Any, index: int) -> Any:
    """Sort key of a generator that does not depend on the order in which the ring read expressions."""
    g = ring.generators[index]
    return (sorted(a.rank for a in ring.of_mask(g.depends)), g.kind, g.name, index)


def _angles(ring: Any, below: Sequence[Any], above: Sequence[Any]) -> list[_Angle]:
    """The angles of a denominator, each at the finest fraction of it that occurs."""
    members_of: dict[Any, tuple[Any, dict[int, tuple[bool, int]]]] = {}
    for k, g in enumerate((*below, *above)):
        if g.kind not in KINDS:
            continue
        x = g.arguments[0]
        kind = KINDS[g.kind]
        ((monomial, c),) = ring.terms(ring.promoted(x.num))
        levels = [level for level, _ in ring.cache.get(("fractions", kind, monomial), ())]
        level = x.den if c == 1 and x.den in levels else 1
        key = (kind, x * level)
        if key in members_of or k < len(below):
            members_of.setdefault(key, (x * level, {}))[1][g.index] = (g.kind == kind, level)
    result = []
    for (kind, _), (unit, levels_of) in members_of.items():
        finest = lcm(*(level for _, level in levels_of.values()))
        members = {i: (sine, finest // level) for i, (sine, level) in levels_of.items()}
        result.append(_Angle(kind, ring.coerce(unit), finest, members))
    return sorted(
        result, key=lambda a: (_rank(ring, min(a.members))[:2], ring.terms(a.unit.num)[0][1], a.unit.den)
    )


def _in_half_angles(
    ring: Any, x: Any, angles: Sequence[_Angle], unchanged: Sequence[int], context: Any
) -> tuple[Any, list[int]] | None:
    """(polynomial in t, k): x = polynomial / Π (1 ± t²)^k."""
    angle_of = {i: angle for angle in angles for i in angle.members}
    free = dict(zip(unchanged, context.gens()[len(angles) :], strict=True))
    rows: dict[Any, Any] = {}
    for monomial, c in ring.terms(x):
        powers: list[list[tuple[int, int]]] = [[] for _ in angles]
        rest: Any = context.constant(c)
        for i, e in monomial:
            if i in angle_of:
                powers[angle_of[i].place].append((i, e))
            else:
                rest = rest * free[i] ** e
        key = tuple(map(tuple, powers))
        rows[key] = rows[key] + rest if key in rows else rest
    degrees = {
        key: [
            sum(angle.members[i][1] * e for i, e in part) for angle, part in zip(angles, key, strict=True)
        ]
        for key in rows
    }  # fmt: skip
    highest = [max(degree[k] for degree in degrees.values()) for k in range(len(angles))]
    estimate = len(x)
    for k in highest:
        estimate *= 2 * k + 1
    if estimate > LONGEST:
        return None
    total = context.constant(0)
    tables: list[dict[Any, Any]] = [{} for _ in angles]
    for key, rest in rows.items():
        for angle, part, most, degree, table in zip(angles, key, highest, degrees[key], tables, strict=True):
            if part not in table:
                value = (1 + angle.sign * angle.t * angle.t) ** (most - degree)
                for i, e in part:
                    sine, n = angle.members[i]
                    value = value * _multiple(angle, n)[sine] ** e
                table[part] = value
            rest = rest * table[part]
        total = total + rest
    return total, highest


def _multiple(angle: _Angle, n: int) -> tuple[Any, Any]:
    """(C, S) with cos n y = C/(1 ± t²)^n and sin n y = S/(1 ± t²)^n."""
    c, s = 1 - angle.sign * angle.t * angle.t, 2 * angle.t
    C, S = 1, 0
    for _ in range(n):
        C, S = C * c - angle.sign * S * s, S * c + C * s
    return C, S


def _widest(above: Any, under: Any, angle: _Angle) -> tuple[Any, Any]:
    """The fraction in the tangent of the widest half angle in which it can be written."""
    p = 2
    while p <= angle.level:
        wider = None if angle.level % p else _wider(above, under, angle, p)
        if wider is None:
            p += 1
        else:
            above, under = wider
            angle.level //= p
    return above, under


def _wider(above: Any, under: Any, angle: _Angle, p: int) -> tuple[Any, Any] | None:
    """The fraction in T = tan(p y/2) = A/B, None if it is no function of T.

    The numerator is then Σ a_j A^j B^(n-j), and the denominator likewise.
    """
    t = angle.t
    degree = max(_degree(above, angle), _degree(under, angle))
    if degree % p:
        return None
    B, A = t * 0 + 1, t * 0
    for _ in range(p):
        A, B = A + t * B, B - angle.sign * t * A
    n, scale = degree // p, 1
    if p == 2:  # A = 2t
        A, scale = t, 2
    parts = []
    for x in (above, under):
        total = t * 0
        high, low = (A, B) if p % 2 else (B, A)
        lead = int(high.leading_coefficient())
        for j in range(n, -1, -1):  # the highest power of t occurs in high^j only
            a = _coefficient(x, angle, p * j) * lead**j
            x, rest = divmod(x - a * high**j, low)
            if rest and j:
                return None
            if not j:
                if rest:
                    return None
                x = t * 0
            power = j if p % 2 else n - j
            total = total + a * t**power * scale ** (n - power)
        parts.append(total)
    common = parts[0].gcd(parts[1])
    return parts[0] // common, parts[1] // common


def _degree(x: Any, angle: _Angle) -> int:
    """Degree in t of an angle."""
    return max(int(x.degrees()[angle.place]), 0)


def _coefficient(x: Any, angle: _Angle, power: int) -> Any:
    """The coefficient of a power of t, a polynomial in all other variables."""
    place = angle.place
    return x.context().from_dict(
        {(*m[:place], 0, *m[place + 1 :]): c for m, c in x.to_dict().items() if m[place] == power}
    )


# -- from half angles -----------------------------------------------------------------------------


def _shortest(
    ring: Any, above: Any, under: Any, angles: Sequence[_Angle], atoms: Sequence[Any], scale: Fraction
) -> _Form:
    """The shortest form in sines and cosines that has these poles."""
    infinite = [max(_degree(above, a) - _degree(under, a), 0) for a in angles]
    unit_powers = []
    for a in angles:
        powers = []
        for unit in a.units():
            under, n = _without(under, unit)
            powers.append(n)
        unit_powers.append(powers)
    constant, factors = under.factor()
    scale = scale / int(constant)
    content = under.context().constant(1)
    poles = [{"i": n, "0": 0, "+": 0, "-": 0} for n in infinite]  # at t = ∞, 0, 1, -1
    plain = []
    for f, n in factors:
        n = int(n)
        place, name = _special(f, angles)
        if name:
            poles[place][name] += n
            scale = scale * int(f.leading_coefficient()) ** n  # ±1
        elif not any(_degree(f, a) for a in angles):
            content = content * f**n
        else:
            plain.append((f, n))
    odd = under.context().constant(1)
    whole: list[tuple[Any, int]] = []
    for f, n in plain:
        if all(_degree(f, a) % 2 == 0 for a in angles):
            whole.append((f, n))
            continue
        if n > 1:
            whole.append((f * f, n // 2))
        if n % 2:
            odd = odd * f
    parity = [(_degree(odd, a) + sum(p.values())) % 2 for a, p in zip(angles, poles, strict=True)]
    choices = [
        # existing poles first
        sorted("i0+-" if a.sign > 0 else "i0", key=lambda name: pole[name] % 2 == 0) if uneven else [" "]
        for a, pole, uneven in zip(angles, poles, parity, strict=True)
    ]
    if sum(parity) > 2:
        choices = [c[:1] for c in choices]
    write = _Writer(ring, angles, atoms)
    under_factors = _Denominator(odd, whole, poles, unit_powers, content, scale)
    best: _Form | None = None
    for extra in product(*choices):
        form = _written(write, above, under_factors, extra)
        if best is None or form.size() < best.size():
            best = form
    assert best is not None
    return best


def _without(x: Any, divisor: Any) -> tuple[Any, int]:
    """x without its factors ``divisor``, and their number."""
    n = 0
    while True:
        quotient, rest = divmod(x, divisor)
        if rest:
            return x, n
        x, n = quotient, n + 1


def _special(f: Any, angles: Sequence[_Angle]) -> tuple[int, str]:
    """The angle and the name of a pole at t = 0, 1 or -1, where sin x or cos x is zero."""
    if f.total_degree() == 1 and len(f) < 3:
        for a in angles:
            names = {"0": a.t, "+": a.t - 1, "-": a.t + 1} if a.sign > 0 else {"0": a.t}
            for name, zero in names.items():
                if f in (zero, -zero):
                    return a.place, name
    return 0, ""


_ROOTS = {"i": 0, "0": 0, "+": 1, "-": -1}


class _Denominator(NamedTuple):
    """Factors of a denominator, whose numerator is multiplied by ``scale``.

    ``poles`` and powers of the ``units`` are those of each angle; the factors of ``whole`` are of even degree in all
    angles, ``odd`` is of odd degree in some; ``content`` has no angle.
    """

    odd: Any
    whole: Sequence[tuple[Any, int]]
    poles: Sequence[dict[str, int]]
    units: Sequence[Sequence[int]]
    content: Any
    scale: Fraction


def _written(write: _Writer, above: Any, denominator: _Denominator, extra: Sequence[str]) -> _Form:
    """The form whose denominator has these poles, and one more (``extra``) where their number is odd."""
    odd, whole, poles, unit_powers, content, scale = denominator
    factors: list[tuple[Any, int]] = []
    k = [0] * len(write.angles)  # powers of 1 ± t² below

    def below(x: Any, n: int) -> None:
        nonlocal scale
        if type(x) is Polynomial:
            content_of = int(x.num.content())
            factors.append((element(write.ring, x.num // content_of, 1, x.mask), n))
            scale = scale * Fraction(content_of, x.den) ** -n
        else:
            scale = scale * Fraction(x) ** -n

    def written(f: Any) -> Any:
        powers = [-(-_degree(f, a) // 2) for a in write.angles]
        return powers, write(f, powers)

    spare = [0] * len(write.angles)
    for a, pole, more in zip(write.angles, poles, extra, strict=True):
        pole = dict(pole)
        s, c = a.sine, a.cosine
        if more != " ":
            pole[more] += 1
            # t, t - 1 or t + 1 above, as below
            above = above * (a.t - _ROOTS[more] if more != "i" else 1)
        for x, pair, number in ((s, "0i", 2), (c, "+-", -1)):
            n = min(pole[p] for p in pair)
            if pair == "+-" and a.sign < 0:
                continue
            if n:  # s = 2t/(1 + t²), c = -(t - 1)(t + 1)/(1 + t²)
                below(x, n)
                scale = scale * Fraction(number) ** n
                k[a.place] += n
                for p in pair:
                    pole[p] -= n
        for name, x, number in (
            ("i", 1 + c, 2),
            ("0", a.sign * (1 - c), 2),
            ("+", 1 - s, 1),
            ("-", 1 + s, 1),
        ):
            n = pole[name] // 2
            if n:  # 1 + c = 2/(1 + t²), 1 - c = 2t²/(1 + t²), 1 - s = (t - 1)²/(1 + t²)
                below(x, n)
                scale = scale * Fraction(number) ** n
                k[a.place] += n
            if pole[name] % 2:
                odd = odd * (a.t - _ROOTS[name] if name != "i" else 1)
                spare[a.place] += name == "i"
    for f, n in whole:
        powers, x = written(f)
        below(x, n)
        k = [i + n * j for i, j in zip(k, powers, strict=True)]
    if not odd.is_constant() or any(spare):
        powers = [(_degree(odd, a) + j) // 2 for a, j in zip(write.angles, spare, strict=True)]
        below(write(odd, powers), 1)
        k = [i + j for i, j in zip(k, powers, strict=True)]
    for a, counts in zip(write.angles, unit_powers, strict=True):
        for unit, n in zip(a.units(), counts, strict=True):
            above = above * unit ** (max(counts) - n)
        k[a.place] += max(counts)
    # f · Π below = above/(content · Π (1 ± t²)^k): numerical factors were moved to scale
    top = write(above, k) * scale
    return _Form(top, write(content, [0] * len(k)), tuple(factors))


class _Writer:
    """Conversion of polynomials in t over powers of 1 ± t² to sines and cosines."""

    def __init__(self, ring: Any, angles: Sequence[_Angle], atoms: Sequence[Any]) -> None:
        self.ring, self.angles, self.atoms = ring, angles, atoms

    def __call__(self, x: Any, k: Sequence[int]) -> Any:
        """x / Π (1 ± t²)^k: t²/(1 + t²) = (1 - cos)/2, 1/(1 + t²) = (1 + cos)/2, t/(1 + t²) = sin/2."""
        ring, n = self.ring, len(self.angles)
        rows: dict[Any, Any] = {}
        for m, c in x.to_dict().items():
            value = ring.constant(int(c))
            for x_i, e in zip(self.atoms, m[n:], strict=True):
                if e:
                    value = value * x_i ** int(e)
            rows[m[:n]] = rows.get(m[:n], 0) + value
        total: Any = 0
        for powers, value in rows.items():
            for a, e, most in zip(self.angles, powers, k, strict=True):
                e = int(e)
                value = value * ((1 - a.cosine) * a.sign / 2) ** (e // 2) * (a.sine / 2) ** (e % 2)
                value = value * ((1 + a.cosine) / 2) ** (most - e // 2 - e % 2)
            total = total + value
        return total


def _size(x: Any) -> int:
    return len(x) if type(x) is Polynomial else 1
