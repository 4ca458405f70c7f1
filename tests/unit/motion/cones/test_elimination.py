"""Elimination in blocks against a dense solver, with and without entries far from the diagonal."""

import numpy as np
import pytest

from freebody.motion.cones.contact_problem import Blocks, Links
from freebody.native.loop import code

ELIMINATION = "motion.cones.elimination"


def linked(pairs, count, n):
    """Return the links of so many blocks of which some pairs are linked."""
    links = Links.made(links=count * count, n=n)
    for b, c in pairs:
        links.blocks[min(b, c) * count + max(b, c)] = 1
    code(ELIMINATION, "fill_in")(links, count)
    return links


def later(links, count):
    return [links.blocks[b * count : b * count + links.later[b]].tolist() for b in range(count)]


@pytest.mark.parametrize("seed", range(10))
def test_blocks_are_eliminated_as_a_whole_matrix_is(seed):
    rng = np.random.default_rng(seed)
    sizes = np.full(9, 6) if seed == 0 else rng.choice([1, 2, 4, 6, 6], 9)
    starts = np.concatenate([[0], np.cumsum(sizes)])
    n, pairs = int(starts[-1]), [(b, c) for b in range(9) for c in range(b) if rng.random() < 0.3]
    a = np.zeros((n, n))
    for b, c in [*pairs, *((b, b) for b in range(9))]:
        i, j = (slice(starts[k], starts[k + 1]) for k in (b, c))
        a[i, j], a[j, i] = rng.normal(size=(sizes[b], sizes[c])), rng.normal(size=(sizes[c], sizes[b]))
    a += 4 * n**0.5 * np.diag(rng.choice([-1, 1], n))  # pivots from other blocks are not looked for
    for b in range(9):  # rows of a block in another order: there they are
        i = slice(starts[b], starts[b + 1])
        a[i] = a[i][rng.permutation(sizes[b])]
    x, factors = rng.normal(size=n), a.copy()
    blocks = Blocks.made()
    blocks.n, blocks.count, blocks.starts = n, 9, starts
    links, order, found = linked(pairs, 9, n), np.zeros(n, dtype=np.int64), a @ x
    assert code(ELIMINATION, "factored")(factors.reshape(-1), blocks, links, order) == 1
    code(ELIMINATION, "substitute")(factors.reshape(-1), blocks, links, order, found)
    rounding = np.finfo(float).eps * n * np.linalg.cond(a)
    np.testing.assert_allclose(found, x, atol=rounding * np.abs(x).max())


def test_a_block_leaves_links_between_its_neighbours():
    assert later(linked([(0, 1), (0, 3), (0, 4)], 5, 5), 5) == [[1, 3, 4], [3, 4], [], [4], []]
    assert later(linked([(0, 4), (1, 4), (2, 3), (2, 4)], 5, 5), 5) == [[4], [4], [3, 4], [4], []]


def test_a_tree_of_blocks_is_eliminated_from_its_leaves():
    count, pairs = 9, [(0, b) for b in range(1, 6)] + [(5, 6), (6, 7), (6, 8)]
    links, degree, sequence = (
        Links.made(links=count * count, n=count),
        *np.zeros((2, count), dtype=np.int64),
    )
    for b, c in pairs:
        links.blocks[b * count + c] = links.blocks[c * count + b] = 1
    code(ELIMINATION, "least_linked")(links, degree, sequence, count)
    place = np.argsort(sequence)
    assert sorted(sequence) == list(range(count))
    left = linked([(place[b], place[c]) for b, c in pairs], count, count)
    assert sum(map(len, later(left, count))) == len(pairs)


def test_one_block_takes_pivots_from_its_rows_and_a_singular_one_is_told():
    a = np.array([[0.0, 2.0], [3.0, 1.0]])
    blocks = Blocks.made()
    blocks.n, blocks.count, blocks.starts = 2, 1, np.array([0, 2])
    links, order, x = linked([], 1, 2), np.zeros(2, dtype=np.int64), np.array([4.0, 5.0])
    factors = a.copy()
    assert code(ELIMINATION, "factored")(factors.reshape(-1), blocks, links, order) == 1
    code(ELIMINATION, "substitute")(factors.reshape(-1), blocks, links, order, x)
    np.testing.assert_allclose(a @ x, [4, 5], rtol=1e-15)
    assert code(ELIMINATION, "factored")(np.array([1.0, 2.0, 2.0, 4.0]), blocks, links, order) == 0
