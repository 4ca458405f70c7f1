"""Memory of families of contacts, shared by Python and compiled code. It needs no compiler.

A pose is R (9), p (3) and V (6): rotation and place of a link's frame in the ground, and its motion in its own axes.
"""

from __future__ import annotations

from typing import Annotated

from ...native.records import Count, Kernel, Real, Record, Row, Rows, Whole, Wholes, record

POINTS = 1 << 20
"""Numbers of the points of a patch."""
POSE = 18
"""Length of a pose."""
TOUCH = 18
"""Length of the geometry of a touch: gap, n, P, Q, t1, t2, two reaches (`pair_programs`)."""
ENTRY = 15
"""Length of an entry of the log: N, T1, T2, mode, impulse on the first body (3) and the point where it acts (3), first
and second member, point (3) where its opposite acts on the second body."""
RESISTED = 8
"""Length of what follows where a family resists rolling or spinning: impulses of the moments about two axes of rolling
and that of spinning, their sum on the first body (3), modes of rolling and of spinning."""
ROWS = 6
"""Greatest number of rows of a pair: the normal, two tangents, two axes of rolling, and that of spinning."""
RATES = 2 * ROWS
"""Numbers that the last step leaves of each row: v₋ and T₋ (`curvature`)."""
UNBOUNDED, SPOT, BALL, EDGE, OVAL, SOLID, DRUM = range(7)
"""How the bounds of a member follow from its numbers."""


@record
class Links(Record):
    """Poses of the links, and the motions that the speeds give them.

    ``poses``    pose of the ground, then of every link, which the kernel ``code`` writes with constants ``c``
    ``chain``    moving links from each link inwards, itself too, from ``chain_at`` on
    ``axes``     motion (6) of a link per unit of a speed, in its axes; from ``motion_at`` on, with the ``place`` of
                 the speed in block order
    ``block``    block of the speeds of a link, -1 if it does not move
    ``varying``  1 if M varies: a block with motions of several links; ``known``: 1 if M has been computed
    ``masses``   mass, centre (3), inertia about it by rows (9) of each of ``count`` links
    """

    count: Count
    varying: Count
    known: Whole
    code: Kernel
    c: Row
    masses: Row
    poses: Row
    chain_at: Wholes
    chain: Wholes
    motion_at: Wholes
    place: Wholes
    axes: Row
    block: Wholes


@record
class Members(Record):
    """Members of all families.

    ``link``    0: the ground;  ``kind``: number of the kind;  ``body``: number of the body in the family
    ``sizes``   numbers of the shape in the link's frame, ``sizes_at`` the first
    ``bound``   how the bounds follow from them;  ``lower``, ``upper``: bounds in ground axes
    ``order``   bounded members along the axis ``axis``;  ``wide``: the others
    ``joined``  bodies that a body does not touch, from ``joined_at`` on
    ``mesh``    corners, faces and edges of the solids: number of corners and of faces, place of the edges, first
                corner of each face and the end, corners of the faces; number of edges, number of those that differ
                in direction, which come first, and two corners of each. A plane has no corners; ``mesh_at``: first
    ``radius``  by which a solid is rounded
    ``corners``, ``normals``, ``middles``    of the cores (`Core`) in this search: corners stand as in ``sizes``,
                normals from ``normals_at`` on
    """

    count: Count
    link: Wholes
    kind: Wholes
    family: Wholes
    group: Wholes
    body: Wholes
    bound: Wholes
    sizes: Row
    sizes_at: Wholes
    joined_at: Wholes
    joined: Wholes
    lower: Annotated[Rows, "members", 3]
    upper: Annotated[Rows, "members", 3]
    mesh: Wholes
    mesh_at: Wholes
    radius: Row
    corners: Row
    normals: Row
    normals_at: Wholes
    middles: Annotated[Rows, "members", 3]
    bounded: Count
    order: Wholes
    unbounded: Count
    wide: Wholes
    axis: Whole


@record
class Laws(Record):
    """Laws of each family, and programs of its pairs of kinds.

    ``program``    address for each family and two kinds; 0 if they do not touch
    ``turned``     1 if the program takes the second member first
    ``reaches``    number of reaches of the program
    ``tangents``   1 or 2 of each family; ``grouped``: 1 if only different groups touch
    ``rolls``, ``spins``, ``rows``    numbers of axes of rolling and of spinning that are resisted, and of all rows
    ``axis``       normal (3) of the plane of motion of each family in a plane
    ``up``         ground axis (3) against which the tangents of round shapes turn, of each family
    ``defined``    1 if the program gives the tangents
    ``patched``    1 if the two touch in patches (`patches`), without a program
    ``directed``, ``along``, ``ratio``    1 if a family has two coefficients of friction, their direction (3) in axes of
                   the second member, and μ_2/μ_1
    ``normal``, ``normal_c``, ``normal_at``    kernel of the normal force of a compliant family, its constants and the
                   first of them: the state, depth and rate give the force; 0: rigid.  ``given``: its arguments;
    ``compliant``  number of these families
    """

    kinds: Count
    program: Wholes
    turned: Wholes
    reaches: Wholes
    defined: Wholes
    patched: Wholes
    tangents: Wholes
    grouped: Wholes
    up: Row
    rolls: Wholes
    spins: Wholes
    rows: Wholes
    axis: Row
    directed: Wholes
    along: Row
    ratio: Row
    compliant: Count
    normal: Wholes
    normal_c: Row
    normal_at: Wholes
    given: Row
    mu: Row
    rolling: Row
    spinning: Row
    adhesion: Row
    restitution: Row


@record
class Pairs(Record):
    """The closed pairs at a configuration.

    ``count``, ``most``    number of pairs, and the room for them; ``count`` beyond ``most``: it did not suffice
    ``first``, ``second``  members; ``touch``: geometry
    ``ids``                (first · members + second) · `POINTS` + number of the point (`narrow_phase.number`), in
                           ascending order
    ``slots``              places of that order
    ``apart``              gap of the members of each pair; ``crossed``: 1 if their patch is that of two edges
    ``within``             limit up to which the pairs are there, in the order of their places, or -1 (`nearer`);
                           ``again``: what that measures again
    ``known``, ``past``, ``impulses``    ids of the pairs that pressed in the last step, impulses of their rows;
                           ``stays``, ``last``: how long one has stayed closed, not 0, and its rates (`curvature`)
    ``earlier``, ``earlier_past``, ``earlier_impulses``    the same of the step before the last one
    ``alternates``         1 if the last impulses were nearer to those than to the ones between
    ``pull``               pull that each pair bears in the step (`adhere`)
    ``depth``              depth of a compliant pair, whose gap counts as 0 then
    ``found``, ``given``   geometry of one pair, and the arguments of its program
    """

    most: Count
    count: Whole
    first: Annotated[Wholes, "pairs"]
    second: Annotated[Wholes, "pairs"]
    ids: Annotated[Wholes, "pairs"]
    slots: Annotated[Wholes, "pairs"]
    apart: Annotated[Row, "pairs"]
    crossed: Annotated[Wholes, "pairs"]
    within: Real
    again: Annotated[Wholes, "pairs"]
    touch: Annotated[Rows, "pairs", TOUCH]
    known: Whole
    past: Annotated[Wholes, "pairs"]
    impulses: Annotated[Rows, "pairs", ROWS]
    earlier: Whole
    earlier_past: Annotated[Wholes, "pairs"]
    earlier_impulses: Annotated[Rows, "pairs", 3]
    alternates: Whole
    stays: Annotated[Wholes, "pairs"]
    stuck: Annotated[Wholes, "pairs"]
    last: Annotated[Rows, "pairs", RATES]
    pull: Annotated[Row, "pairs"]
    depth: Annotated[Row, "pairs"]
    found: Annotated[Row, TOUCH]
    given: Annotated[Row, 56]


@record
class Core(Record):
    """The corners of a solid in ground axes, their middle, the normals of its faces, the radius around, and the place
    of its mesh.
    """

    count: Whole
    mesh: Whole
    radius: Real
    middle: Annotated[Row, 3]
    corners: Row
    normals: Row


@record
class Patch(Record):
    """The patch of two solids: the best normal and the distance of the cores along it, and points.

    ``kind``, ``face``       feature of the normal;  ``extent`` of the cores
    ``even``                 by how much two edges may separate the cores better than a face that is taken for them
    ``points``               place (3), normal from the second to the first body (3), gap
    ``features``             what meets at each point, four numbers (`faces`);  ``met``: the same of one point
    ``pair``, ``trial``      two points, a vector or two points;  ``polygon``, ``rest``: a face that is cut
    ``tags``, ``rest_tags``  two numbers for each of its corners;  ``towards``: number of that face, -1 for none
    ``heights``              of corners along a direction
    """

    most: Count
    count: Whole
    kind: Whole
    face: Whole
    apart: Real
    extent: Real
    even: Real
    normal: Annotated[Row, 3]
    pair: Annotated[Row, 6]
    trial: Annotated[Row, 6]
    polygon: Row
    rest: Row
    tags: Wholes
    rest_tags: Wholes
    heights: Row
    towards: Whole
    met: Annotated[Wholes, 4]
    features: Wholes
    points: Annotated[Rows, "points", 7]


@record
class Families(Record):
    """Families of contacts of a machine.

    ``sharp``  1 for a step that was not solved with faces for edges where points stay closed (`patches.TILT`)
    """

    sharp: Whole
    links: Links
    members: Members
    laws: Laws
    pairs: Pairs
    one: Core
    other: Core
    patch: Patch
