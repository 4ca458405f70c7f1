"""The mass matrix of a tree by blocks, from the poses of its links:

    M_jk = Σ m v_j·v_k + ω_j·(I ω_k)          over the links that both speeds move

with the velocities v of the mass centre and ω of the link per unit of each speed, in the link's axes.
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, room
from ..cones.contact_problem import Blocks
from .family_record import POSE, Links
from .vectors import from_axes, in_axes

MASSES = 13
"""Numbers of the inertia of a link."""


@compiled
def mass_blocks(links: Links, blocks: Blocks, M: Reals) -> None:
    """Set the blocks of M."""
    for k in range(blocks.squares[blocks.count]):
        M[k] = 0.0
    for i in range(links.count):
        if links.block[i + 1] >= 0 and links.masses[MASSES * i] > 0.0:
            add_link(links, blocks, i + 1, M)


@compiled
def add_link(links: Links, blocks: Blocks, link: int, M: Reals) -> None:
    """Add a link's part."""
    inertia, b = links.masses[MASSES * (link - 1) :], links.block[link]
    size, first = blocks.starts[b + 1] - blocks.starts[b], blocks.starts[b]
    block, moved, other, load = M[blocks.squares[b] :], room(6), room(6), room(6)
    for n in range(links.chain_at[link], links.chain_at[link + 1]):
        for j in range(links.motion_at[links.chain[n]], links.motion_at[links.chain[n] + 1]):
            motion_of(links, link, links.chain[n], j, inertia, moved)
            for i in range(3):
                load[i] = inertia[0] * moved[3 + i]
                load[3 + i] = (
                    inertia[4 + 3 * i] * moved[0]
                    + inertia[5 + 3 * i] * moved[1]
                    + inertia[6 + 3 * i] * moved[2]
                )
            row = links.place[j] - first
            for m in range(links.chain_at[link], links.chain_at[link + 1]):
                for k in range(links.motion_at[links.chain[m]], links.motion_at[links.chain[m] + 1]):
                    motion_of(links, link, links.chain[m], k, inertia, other)
                    total = 0.0
                    for i in range(3):
                        total += load[i] * other[3 + i] + load[3 + i] * other[i]
                    block[row * size + links.place[k] - first] += total


@compiled
def motion_of(links: Links, link: int, a: int, j: int, inertia: Reals, result: Reals) -> None:
    """Set ω and v of the mass centre of a link, in its axes, per unit of motion j, which is one of link a."""
    R, A, S = links.poses[POSE * link :], links.poses[POSE * a :], links.axes[6 * j :]
    if a == link:
        for i in range(3):
            result[i], result[3 + i] = S[i], S[3 + i]
        result[3] += S[1] * inertia[3] - S[2] * inertia[2]
        result[4] += S[2] * inertia[1] - S[0] * inertia[3]
        result[5] += S[0] * inertia[2] - S[1] * inertia[1]
        return
    w, v, d = room(3), room(3), room(3)
    for i in range(3):
        w[i], v[i] = from_axes(A, i, S[0], S[1], S[2]), from_axes(A, i, S[3], S[4], S[5])
        d[i] = R[9 + i] - A[9 + i]
        d[i] += from_axes(R, i, inertia[1], inertia[2], inertia[3])
    v[0] += w[1] * d[2] - w[2] * d[1]
    v[1] += w[2] * d[0] - w[0] * d[2]
    v[2] += w[0] * d[1] - w[1] * d[0]
    for i in range(3):
        result[i], result[3 + i] = in_axes(R, i, w[0], w[1], w[2]), in_axes(R, i, v[0], v[1], v[2])
