"""The rates of the closed pairs of families, and their rows of W.

e·(v_P - v_Q) = W u + w,   e = n, t1, t2;      W_j = S_j·(wrench of e at P on the first body, -e at Q on the second),
                                               S_j: motion per unit of speed j
"""

from __future__ import annotations

from ...native.instructions import Reals, compiled, inlined, room
from ..cones.contact_problem import Blocks
from .family_record import POSE, Families, Links
from .narrow_phase import P, Q, T
from .vectors import cross, in_axes, vector


@compiled
def rows(of: Families, blocks: Blocks, first: int, W: Reals, friction: int) -> int:
    """Write the rows of all pairs over the blocks of their two bodies, from row ``first`` on; return their end.

    Those of tangents have values only if ``friction`` is not 0.
    """
    pairs, links, r = of.pairs, of.links, first
    for c in range(pairs.count):
        slot = pairs.slots[c]
        f = of.members.family[pairs.first[slot]]
        one, other = of.members.link[pairs.first[slot]], of.members.link[pairs.second[slot]]
        touch = pairs.touch[slot]
        for k in range(of.laws.rows[f]):
            piece, at = blocks.first[r], blocks.at[r]
            low, high = links.block[one], links.block[other]
            if high < low:
                low, high = high, low
            if low >= 0 and low != high:
                blocks.pieces[piece] = low
                piece += 1
            if high >= 0:
                blocks.pieces[piece] = high
                piece += 1
            end = at
            for p in range(blocks.first[r], piece):
                b = blocks.pieces[p]
                end += blocks.starts[b + 1] - blocks.starts[b]
            blocks.first[r + 1], blocks.at[r + 1] = piece, end
            r += 1
            if k > 0 and friction == 0:
                continue
            for n in range(at, end):
                W[n] = 0.0
            e = axis(of, slot, k)
            if k <= of.laws.tangents[f]:
                stretch = stretch_of(of, f, k)
                press(links, blocks, r - 1, one, touch[P:], e, stretch, W)
                press(links, blocks, r - 1, other, touch[Q:], e, -stretch, W)
            else:
                twist(links, blocks, r - 1, one, e, 1.0, W)
                twist(links, blocks, r - 1, other, e, -1.0, W)
    return r


@compiled
def place_of_axis(of: Families, f: int, k: int) -> int:
    """Return the place in a touch of the axis of row k of a pair; -1 for the axis of a plane of motion."""
    tangents = of.laws.tangents[f]
    if k == 0 or k - 1 - tangents >= of.laws.rolls[f]:  # of spinning, too
        return 1
    if k <= tangents:
        return T + 3 * (k - 1)
    return -1 if tangents == 1 else T + 3 * (k - 1 - tangents)


@inlined
def axis(of: Families, slot: int, k: int) -> Reals:
    """Return the axis of row k of a pair: normal, tangents, then axes of what resists rolling and spinning."""
    f, touch = of.members.family[of.pairs.first[slot]], of.pairs.touch[slot]
    place = place_of_axis(of, f, k)
    return of.laws.axis[3 * f :] if place < 0 else touch[place:]


@inlined
def stretch_of(of: Families, f: int, k: int) -> float:
    """Return the factor of row k of a pair: μ_2/μ_1 of a second tangent with its own coefficient, else 1."""
    return of.laws.ratio[f] if k == 2 else 1.0


@compiled
def row_rate(of: Families, slot: int, k: int) -> float:
    """Return the rate of row k of a pair: the velocity, or the angular velocity, along its axis.

    That of the normal of a compliant pair, whose force is given, counts as 0.
    """
    members, pairs, e = of.members, of.pairs, axis(of, slot, k)
    f = members.family[pairs.first[slot]]
    if k == 0 and of.laws.normal[f] != 0:
        return 0.0
    if k <= of.laws.tangents[f]:
        return stretch_of(of, f, k) * rate(of, slot, e)
    first, second = members.link[pairs.first[slot]], members.link[pairs.second[slot]]
    return turning(of.links, first, e) - turning(of.links, second, e)


@inlined
def turning(links: Links, link: int, e: Reals) -> float:
    """Return the angular velocity of a link along e."""
    R, total = links.poses[POSE * link :], 0.0
    for i in range(3):
        total += R[12 + i] * in_axes(R, i, e[0], e[1], e[2])
    return total


@compiled
def press(
    links: Links, blocks: Blocks, r: int, link: int, point: Reals, e: Reals, sign: float, W: Reals
) -> None:
    """Add to row r the generalized force of a force e on a link at a point."""
    if links.block[link] < 0:
        return
    start, wrench = start_of(links, blocks, r, link), room(6)
    for n in range(links.chain_at[link], links.chain_at[link + 1]):
        a = links.chain[n]
        R = links.poses[POSE * a :]
        x, y, z = vector(R[9:], point)
        m_x, m_y, m_z = cross(x, y, z, e[0], e[1], e[2])
        for i in range(3):
            wrench[i] = sign * in_axes(R, i, m_x, m_y, m_z)
            wrench[3 + i] = sign * in_axes(R, i, e[0], e[1], e[2])
        for j in range(links.motion_at[a], links.motion_at[a + 1]):
            S, total = links.axes[6 * j :], 0.0
            for i in range(6):
                total += S[i] * wrench[i]
            W[start + links.place[j]] += total


@inlined
def start_of(links: Links, blocks: Blocks, r: int, link: int) -> int:
    """Return the place of the first speed of the machine in row r, as far as the block of a link counts."""
    start, b = blocks.at[r], blocks.pieces[blocks.first[r]]
    if b != links.block[link]:
        start += blocks.starts[b + 1] - blocks.starts[b]
        b = links.block[link]
    return start - blocks.starts[b]


@compiled
def twist(links: Links, blocks: Blocks, r: int, link: int, e: Reals, sign: float, W: Reals) -> None:
    """Add to row r the generalized force of a moment e on a link."""
    if links.block[link] < 0:
        return
    start = start_of(links, blocks, r, link)
    for n in range(links.chain_at[link], links.chain_at[link + 1]):
        a = links.chain[n]
        R = links.poses[POSE * a :]
        for j in range(links.motion_at[a], links.motion_at[a + 1]):
            S, total = links.axes[6 * j :], 0.0
            for i in range(3):
                total += S[i] * in_axes(R, i, e[0], e[1], e[2])
            W[start + links.place[j]] += sign * total


@compiled
def rate(of: Families, slot: int, e: Reals) -> float:
    """Return e·(v_P - v_Q) of a pair."""
    members, pairs = of.members, of.pairs
    touch = pairs.touch[slot]
    return along(of.links, members.link[pairs.first[slot]], touch[P:], e) - along(
        of.links, members.link[pairs.second[slot]], touch[Q:], e
    )


@compiled
def along(links: Links, link: int, point: Reals, e: Reals) -> float:
    """Return the velocity along e of the point of a link that is at a place now."""
    R = links.poses[POSE * link :]
    x, y, z = vector(R[9:], point)
    m_x, m_y, m_z = cross(x, y, z, e[0], e[1], e[2])
    total = 0.0
    for i in range(3):
        total += R[12 + i] * in_axes(R, i, m_x, m_y, m_z)
        total += R[15 + i] * in_axes(R, i, e[0], e[1], e[2])
    return total
