"""Blocks of speeds that masses, and conditions of the machine, couple."""

import numpy as np

from freebody.motion.phase.candidates.speed_blocks import coupled_speeds, speed_blocks


def test_coupled_speeds_are_sets_that_share_none():
    rng = np.random.default_rng(0)
    for _ in range(100):
        n = int(rng.integers(1, 12))
        coupled = [
            rng.integers(n, size=int(rng.integers(1, 4))).tolist() for _ in range(int(rng.integers(0, 6)))
        ]
        groups = coupled_speeds(n, coupled)
        assert sorted(j for group in groups for j in group) == list(range(n))
        for one in coupled:
            assert sum(any(j in group for j in one) for group in groups) == 1


def test_blocks_follow_each_other_and_a_contact_has_at_most_two():
    """Each set of speeds that something couples lies in one block, each contact in the two that it names."""
    rng, twos = np.random.default_rng(1), 0
    for _ in range(300):
        n = int(rng.integers(2, 15))
        pairs = [
            [j, j + int(rng.integers(1, 4))] for j in rng.integers(n, size=int(rng.integers(0, 6))).tolist()
        ]
        coupled = [[j for j in pair if j < n] for pair in pairs]
        contacts = [
            rng.integers(n, size=int(rng.integers(0, 5))).tolist() for _ in range(int(rng.integers(0, 5)))
        ]
        own = [sorted(set(rng.integers(n, size=2).tolist())) for _ in range(int(rng.integers(0, 2)))]
        blocks = speed_blocks(n, coupled, contacts, own)
        assert blocks.starts[0] == 0 and blocks.starts[-1] == n and (np.diff(blocks.starts) > 0).all()
        block = np.repeat(np.arange(len(blocks.starts) - 1), np.diff(blocks.starts))
        assert all(len({block[j] for j in one}) == 1 for one in [*coupled, *own])
        assert [block[one[0]] for one in own] == list(blocks.own)
        for speeds, beside in zip(contacts, blocks.contacts, strict=True):
            assert {block[j] for j in speeds} <= set(beside)
            twos += len({block[j] for j in speeds}) == 2
    assert twos > 100


def test_bodies_that_nothing_couples_are_blocks_of_their_own():
    bodies = [range(0, 6), range(6, 12), range(12, 18)]
    contacts = [range(0, 6), range(6, 12), range(6, 18)]
    blocks = speed_blocks(18, bodies, contacts, [])
    assert blocks == ((0, 6, 12, 18), ((0, 0), (1, 1), (1, 2)), ())
    assert speed_blocks(18, bodies, contacts, [[2, 13]]).starts == (0, 18)  # it has those between them, too
