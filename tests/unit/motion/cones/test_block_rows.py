"""Islands of blocks that rows join."""

import numpy as np

from freebody.native import loop


def test_blocks_that_rows_join_have_the_same_first_block():
    join, root_of = (loop.code("motion.cones.block_rows", name) for name in ("join", "root_of"))
    rng = np.random.default_rng(0)
    for _ in range(100):
        n = int(rng.integers(1, 12))
        parent, reached = np.arange(n), np.eye(n, dtype=bool)
        for _ in range(int(rng.integers(0, n))):
            a, b = rng.integers(n, size=2).tolist()
            join(parent, a, b)
            reached[a, b] = reached[b, a] = True
        for _ in range(n):
            reached |= reached @ reached
        for b in range(n):
            assert root_of(parent, b) == np.flatnonzero(reached[b])[0]
