"""Draws by number: the right integers, everywhere, and the promises of each kind."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats
from scipy.stats import qmc

from freebody.errors import SimulationError
from freebody.studies.lanes.draws import KINDS, Draws, LatinHypercube, Sobol, feistel, words

FAR = 10**12 // 4 * 3


def test_words_are_those_of_philox_in_order() -> None:
    """One generator that runs through gives the same words."""
    key = np.random.SeedSequence(9, spawn_key=(0, 2)).generate_state(2, np.uint64)
    run = np.random.Philox(key=key).random_raw(1000)
    for low, high in ((0, 1000), (1, 2), (3, 9), (998, 1000), (4, 4)):
        assert np.array_equal(words(9, 0, 2, low, high), run[low:high])
    far = words(9, 0, 2, FAR + 1, FAR + 3)
    assert np.array_equal(far, np.random.Philox(key=key, counter=FAR // 4).random_raw(3)[1:])


@pytest.mark.parametrize("kind", KINDS)
def test_draws_are_never_0_or_1(kind: str) -> None:
    draws = KINDS[kind](2, 1 << 40, 3)
    for low in (0, FAR, (1 << 40) - 1000):
        p = draws.probabilities(1, low, low + 1000)
        assert (p >= 2.0**-53).all() and (p <= 1 - 2.0**-53).all()


@pytest.mark.parametrize("count", [1, 2, 3, 4096])
def test_few_lanes_are_a_hypercube(count: int) -> None:
    law = LatinHypercube(2, count, 1)
    for j in (0, 1):
        assert np.array_equal(np.sort(law.strata(j, 0, count)), np.arange(count))


@pytest.mark.parametrize("count", [4097, 8191, 8192, 8193, 100_003])
def test_each_stratum_has_one_lane(count: int) -> None:
    """Exactly: floor(n p), computed with whole numbers, is a permutation, and that of `strata`."""
    law = LatinHypercube(2, count, 1)
    for j in (0, 1):
        strata = law.strata(j, 0, count)
        assert np.array_equal(np.sort(strata), np.arange(count))
        whole = (law.probabilities(j, 0, count) * 2.0**53).astype(np.int64).astype(object)
        assert np.array_equal((whole * count) >> 53, strata.astype(object))
    assert not np.array_equal(law.strata(0, 0, count), law.strata(1, 0, count))
    assert not np.array_equal(strata, LatinHypercube(2, count, 2).strata(1, 0, count))


def test_the_strata_of_2_to_40_lanes() -> None:
    """The last lanes of the largest hypercube lie in their strata, too."""
    count = 1 << 40
    law = LatinHypercube(1, count, 1)
    for low in (0, FAR, count - 5000):
        whole = (law.probabilities(0, low, low + 5000) * 2.0**53).astype(np.uint64)
        assert np.array_equal(whole >> np.uint64(13), law.strata(0, low, low + 5000))


@pytest.mark.parametrize("bits", [2, 3, 7, 12, 13])
def test_a_feistel_network_is_a_permutation(bits: int) -> None:
    keys = np.random.SeedSequence(bits).generate_state(6, np.uint64)
    result = feistel(np.arange(1 << bits, dtype=np.uint64), bits, keys)
    assert np.array_equal(np.sort(result), np.arange(1 << bits))


@pytest.mark.parametrize("count", [5, 6000, 2**20])
def test_permutations_look_random(count: int) -> None:
    """χ² of pairs on a board of g² squares, with g (g - 1) or more degrees of freedom; seeds are fixed, p > 10⁻³."""
    if count == 5:  # each of the 120 permutations
        permutations = np.array([LatinHypercube(1, 5, seed).strata(0, 0, 5) for seed in range(3000)])
        observed = np.unique(permutations, axis=0, return_counts=True)[1]
        assert observed.size == 120
        assert scipy.stats.chisquare(observed).pvalue > 1e-3
        return
    law, g = LatinHypercube(2, count, 7), 16
    first, second = (law.strata(j, 0, count).astype(float) / count for j in (0, 1))
    lanes = np.arange(count) / count
    for x, y in (
        (first, second),
        (lanes, first),
        (first[:-1], first[1:]),
        (first[: count // 2], first[count // 2 :]),
    ):
        squares = np.histogram2d(x, y, bins=g, range=[[0, 1], [0, 1]])[0]
        chi2 = ((squares - x.size / g**2) ** 2).sum() / (x.size / g**2)
        assert scipy.stats.chi2.sf(chi2, g * g - 1) > 1e-3
        assert scipy.stats.chi2.cdf(chi2, (g - 1) ** 2) > 1e-3


def test_sobol_is_the_sequence_of_scipy() -> None:
    for dimensions in (1, 2, 7):
        theirs = qmc.Sobol(dimensions, bits=52, rng=np.random.default_rng(4)).random(2**13)
        ours = Sobol(dimensions, 10**9, 4)
        for j in range(dimensions):
            for low, high in ((0, 2**13), (4095, 4097), (8191, 8192)):
                assert np.array_equal(ours.probabilities(j, low, high), theirs[low:high, j] + 2.0**-53)


def test_far_points_of_sobol_are_those_of_its_definition() -> None:
    """Point k is the shift xor the direction numbers of the bits of the Gray code k xor k/2."""
    engine = qmc.Sobol(2, bits=52, rng=np.random.default_rng(4))
    law = Sobol(2, 1 << 52, 4)
    for k in (10**9, 2**40 - 1, 2**40, 2**52 - 1):
        gray = k ^ (k >> 1)
        for j in (0, 1):
            point = int(engine._shift[j])
            for bit in range(52):
                point ^= int(engine._sv[j, bit]) * (gray >> bit & 1)
            assert int(law.integers(j, k, k + 1)[0]) == point


def test_sobol_is_a_net_far_from_the_beginning() -> None:
    """2^m points from a multiple of 2^m on: one in each box of 2^-a by 2^(a - m), in the first two dimensions."""
    m = 12
    law = Sobol(2, 1 << 45, 8)
    low = (10**10 >> m) << m
    x, y = (law.integers(j, low, low + (1 << m)).astype(np.int64) for j in (0, 1))
    for a in range(m + 1):
        boxes = ((x >> (52 - a)) << (m - a)) | (y >> (52 - (m - a)))
        assert np.array_equal(np.sort(boxes), np.arange(1 << m)), a


def test_too_many_dimensions() -> None:
    with pytest.raises(
        SimulationError, match="Expected at most 21201 names for by='sobol', got 21202. Take by='lhs'"
    ):
        Sobol(21202, 4, 1)


def test_dimensions_and_seeds_are_independent() -> None:
    """Correlations of n independent draws have the deviation 1/√n; 4 deviations."""
    n = 40_000
    for kind in (Draws, LatinHypercube):
        columns = [kind(3, n, seed).probabilities(j, 0, n) for seed in (1, 2) for j in range(3)]
        correlation = np.corrcoef(columns)[np.triu_indices(6, 1)]
        assert (abs(correlation) < 4 / np.sqrt(n)).all()


FIRST = {
    "sobol": [0.3523786718963079, 0.5811704935949608, 0.07493309490244371, 0.8666417168058217],
    "lhs": [0.3663631462744228, 0.42993881852762844, 0.7399335813656418, 0.31531027793704036],
    "random": [0.6373851244634413, 0.174484261445348, 0.8798575390911229, 0.36995972966080404],
}


@pytest.mark.parametrize("kind", KINDS)
def test_draws_of_a_seed_stay_as_they_are(kind: str) -> None:
    """A store of an earlier day goes on with the same lanes: these numbers may not change."""
    assert KINDS[kind](2, 5000, 7).probabilities(1, 4000, 4004).tolist() == FIRST[kind]
