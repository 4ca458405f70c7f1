"""What the walks over a large tree (`tree_walk`) read of it: places of numbers in the workspace S, and code.

A kernel has a `Product`, which Python fills (`tree_code`).
"""

from __future__ import annotations

from ...native.records import Count, Record, Wholes, record


@record
class Copy(Record):
    """Places in S whose numbers are copied side by side, from the place ``target`` on."""

    count: Count
    sources: Wholes
    target: Count


@record
class Straight(Record):
    """Straight code, at an address (0: it computes nothing), and the place of its first result."""

    code: Count
    target: Count


@record
class Tree(Record):
    """Places in S and code of a tree. What belongs to the links has an entry for each of them."""

    links: Count
    numbers: Count
    """Length of S."""
    inputs: Count
    """Numbers of the state, and of the forces or accelerations behind it."""
    hoisted: Count
    """Length of c: constants of the links, then of the straight code."""
    given: Count
    """1 if accelerations are given, and forces follow from them."""
    # code of the steps; 0 where the mode has no such step
    outward: Wholes
    inward: Wholes
    final: Wholes
    carried: Wholes
    transmitted: Wholes
    place: Wholes
    moved: Wholes
    pressed: Wholes
    composed: Wholes
    projected: Wholes
    # places in c and S
    constants: Wholes
    joints: Wholes
    """First of the joint's entries in ``variables``; the last number is their end."""
    variables: Wholes
    tips: Wholes
    passed: Wholes
    added: Wholes
    """Sum to which the link's own is added; -1 if it is the first one of its parent."""
    record: Wholes
    parent: Wholes
    own: Wholes
    above: Wholes
    second: Wholes
    parents_second: Wholes
    # of the mass matrix: motions of each link, speeds that they belong to, and places of their weights (-1 for 1)
    parents: Wholes
    """Parent of each link; -1 for the ground."""
    moves: Wholes
    """First of the link's entries in the next three; the last number is their end."""
    speeds: Wholes
    motions: Wholes
    weights: Wholes
    freedoms: Wholes
    """First of the link's motions in the next two; the last number is their end."""
    momenta: Wholes
    armature: Wholes
    # places in S
    joint: Count
    cleared: Count
    kept: Count
    """Sums from ``cleared`` to ``kept`` begin with zero."""
    ground: Count
    ground_end: Count
    ground_axes: Count
    """Rotation of the ground in its second record, which lies from ``ground`` to ``ground_end``."""
    at_rest: Count
    at_rest_end: Count
    """Acceleration of the ground: angular, then linear, against gravity; further numbers are zero."""
    totals: Count
    kinetic: Count
    momentum: Count
    """Places, in a second record, of energy and first moments of a link, and of its momentum."""
    along: Count
    """Place, in a second record, of the forces along the joint."""
    matrix: Count
    order: Count
    """Mass matrix, and the number of its rows."""
    projection: Count
    """Momentum of one motion on its way to the ground: two places of six numbers."""
    # straight code, and what it reads of the records
    straight_constants: Count
    front: Straight
    turn: Straight
    """Code of the sines and cosines of a block of angles, and the place of the first block's."""
    turned: Wholes
    """Places of the angles."""
    turning: Count
    """Number of angles."""
    block: Count
    angles: Count
    """Number of angles in a block, and the place where the code reads them."""
    gravity: Copy
    early: Copy
    loads: Straight
    late: Copy
    finish: Straight
    energy: Straight
    product: Straight
    loaded: Copy
    """The loads, which are subtracted from the numbers at ``loaded_links``."""
    loaded_links: Wholes


@record
class Product(Record):
    """What a kernel computes: which walks it needs, and the places of its outputs."""

    tree: Tree
    state: Count
    outputs: Wholes
    count: Count
    # 1 or 0
    posed: Count
    early: Count
    moving: Count
    pressed: Count
    finished: Count
    speeds: Count
    momenta: Count
    energies: Count
    composed: Count
    # of a derivative: the first number of the state that varies, or of the direction; and the number of columns
    first: Count
    columns: Count
