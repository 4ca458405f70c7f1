"""Draws from the unit cube by number: draw k of dimension j, without the draws before it.

    random   p = (w + 1/2) / 2^52, w 52 bits of word k of Philox4x64-10 [SalmonEtAl2011] with the key of (seed, j)
    lhs      p = (π_j(k) + r) / n, a Latin hypercube: π_j a permutation of 0 ... n - 1, r in (0, 1) by Philox
    sobol    p = (x + 1/2) / 2^52, x = s_j xor (direction numbers of the bits of k xor k/2): the sequence of SciPy

Every p is shifted by half a unit of its last digit, so that none is 0 or 1, whose quantiles may be infinite. The
integers are the same on every machine.

π_j is a Feistel network [LubyRackoff1988] over the smallest 2^m >= n numbers: the halves L, R of the bits of k change
by L <- L xor F_i(R), R <- R xor G_i(L). Results of n and beyond go through it again until they are below n, which
keeps it a permutation of 0 ... n - 1 [BlackRogaway2002].
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import SimulationError

Words = NDArray[np.uint64]
_BITS = 52
_ROUNDS = 3
_SMALL = 1 << 12
"""Number of lanes up to which a permutation is the order of random words: few rounds mix few bits badly."""
_PIECE = 1 << 13
"""Number of lanes whose permutation stays in the nearest cache of a processor."""
_LOW = 12
"""Number of bits of k whose combinations of direction numbers stand in a table."""
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_HALF, _ALL = np.uint64(32), np.uint64(64)
_JITTER, _PERMUTATION = 1, 2
"""Streams of random words besides those of "random", which is 0."""


class Draws:
    """Draws of ``count`` lanes in several dimensions."""

    most = 1 << 62
    """Greatest number of lanes."""

    def __init__(self, dimensions: int, count: int, seed: int) -> None:
        self.dimensions, self.count, self.seed = dimensions, count, seed

    def probabilities(self, j: int, low: int, high: int) -> NDArray[np.float64]:
        """Return the draws ``low`` to ``high`` - 1 of dimension j, 0 < p < 1."""
        return _between(words(self.seed, 0, j, low, high) >> np.uint64(64 - _BITS), _BITS)


class LatinHypercube(Draws):
    """Draws of which one lies in each of n equal parts of every dimension."""

    most = 1 << 40

    def strata(self, j: int, low: int, high: int) -> Words:
        """Return the parts of the lanes, a permutation of 0 ... n - 1."""
        if self.count <= _SMALL:
            order = np.argsort(words(self.seed, _PERMUTATION, j, 0, self.count), kind="stable")
            return order[low:high].astype(np.uint64)
        keys = _key(self.seed, _PERMUTATION, j, 2 * _ROUNDS)
        bits = (self.count - 1).bit_length()
        result = np.arange(low, high, dtype=np.uint64)
        for start in range(0, result.size, _PIECE):
            result[start : start + _PIECE] = feistel(result[start : start + _PIECE], bits, keys)
        beyond = np.flatnonzero(result >= self.count)
        while beyond.size:
            result[beyond] = feistel(result[beyond], bits, keys)
            beyond = beyond[result[beyond] >= self.count]
        return result

    def probabilities(self, j: int, low: int, high: int) -> NDArray[np.float64]:
        """Return the draws ``low`` to ``high`` - 1 of dimension j."""
        # with 53 bits for both, stratum + place is exact, and the quotient by n is rounded within the stratum
        bits = 52 - (self.count - 1).bit_length()
        place = _between(words(self.seed, _JITTER, j, low, high) >> np.uint64(64 - bits), bits)
        return (self.strata(j, low, high).astype(float) + place) / self.count


class Sobol(Draws):
    """Draws of the Sobol sequence scrambled by the seed, as by scipy.stats.qmc.Sobol(d, bits=52, rng=seed)."""

    most = 1 << _BITS

    def __init__(self, dimensions: int, count: int, seed: int) -> None:
        super().__init__(dimensions, count, seed)
        from scipy.stats import qmc

        if dimensions > qmc.Sobol.MAXDIM:
            raise SimulationError(
                f"Expected at most {qmc.Sobol.MAXDIM} names for by='sobol', got {dimensions}. Take by='lhs'."
            )
        generator: Any = np.random.default_rng(seed)
        try:
            engine = qmc.Sobol(dimensions, bits=_BITS, rng=generator)
        except TypeError:  # SciPy before 1.15
            engine = qmc.Sobol(dimensions, bits=_BITS, seed=generator)
        # engine.fast_forward(k) takes time in proportion to k, and SciPy 1.17 has none for more than 32 bits
        self.shift: Words = np.array(engine._shift, dtype=np.uint64)
        directions = np.array(engine._sv, dtype=np.uint64)
        # of bit r of k, bits r and r - 1 of k xor k/2 come
        self.directions: Words = directions
        self.directions[:, 1:] ^= directions[:, :-1].copy()

    def integers(self, j: int, low: int, high: int) -> Words:
        """Return the points ``low`` to ``high`` - 1 of dimension j, times 2^52."""
        directions = self.directions[j]
        table = self.shift[j : j + 1]
        for direction in directions[:_LOW]:
            table = np.concatenate([table, table ^ direction])
        rows = np.arange(low >> _LOW, ((high - 1) >> _LOW) + 1, dtype=np.uint64)
        start = np.zeros_like(rows)
        for r, direction in enumerate(directions[_LOW:]):
            start ^= ((rows >> np.uint64(r)) & np.uint64(1)) * direction
        first = (low >> _LOW) << _LOW
        result: Words = (start[:, None] ^ table).reshape(-1)[low - first : high - first]
        return result

    def probabilities(self, j: int, low: int, high: int) -> NDArray[np.float64]:
        """Return the draws ``low`` to ``high`` - 1 of dimension j."""
        return _between(self.integers(j, low, high), _BITS)


KINDS: dict[str, type[Draws]] = {"sobol": Sobol, "lhs": LatinHypercube, "random": Draws}


def words(seed: int, stream: int, j: int, low: int, high: int) -> Words:
    """Return random words of 64 bits by number; each count of Philox makes four."""
    key = _key(seed, stream, j, 2)
    first = low // 4
    result: Words = np.random.Philox(key=key, counter=first).random_raw(high - 4 * first)[low - 4 * first :]
    return result


def feistel(numbers: Words, bits: int, keys: Words) -> Words:
    """Return a permutation of 0 ... 2^bits - 1 of numbers, by two keys a round."""
    half = bits // 2
    low_bits, high_bits = np.uint64(half), np.uint64(bits - half)
    left, right = numbers >> low_bits, numbers & np.uint64((1 << half) - 1)
    mixed, shifted = np.empty_like(left), np.empty_like(left)
    for first, second in keys.reshape(-1, 2):
        for source, target, key, width in ((right, left, first, high_bits), (left, right, second, low_bits)):
            # the high bits depend on all bits of the source and of the key (after splitmix64)
            np.add(source, key, out=mixed)
            mixed *= _FIRST
            np.right_shift(mixed, _HALF, out=shifted)
            mixed ^= shifted
            mixed *= _SECOND
            mixed >>= _ALL - width
            target ^= mixed
    left <<= low_bits
    left |= right
    return left


@lru_cache(maxsize=1024)
def _key(seed: int, stream: int, j: int, count: int) -> Words:
    """Return words that the seed makes for a stream of dimension j, which blocks ask for again and again."""
    keys = np.random.SeedSequence(seed, spawn_key=(stream, j)).generate_state(count, np.uint64)
    keys.flags.writeable = False
    return np.asarray(keys, np.uint64)


def _between(integers: Words, bits: int) -> NDArray[np.float64]:
    """Return (x + 1/2) / 2^bits, which is exact for at most 52 bits."""
    return (integers.astype(float) + 0.5) * 2.0**-bits
