"""One link of the articulated-body algorithm as machine code: the steps that the loops run over all links.

The algorithm is that of :mod:`freebody.dynamics`, recorded for one link whose parent, constants and joint variables
are inputs. Links of one kind share the code.

The numbers of a link stand in two records, so that those of the motion are short and fit into a cache. The first:

    outward            V (6), and the varying terms of R and r (up to 12, behind the rest)
    final              y'' (k), force along a driven displacement (1)
    inward             rows of D⁻¹ Uᵀ (6 k), D⁻¹ m (k); of a driven displacement I^A S and S·p^A

The second:

    outward            q' of a ball or free joint (7)
    place              R_N (9), p_N (3), kinetic energy (1), first moment m p_N + R_N h (3), origin of the body (3)
    moved              angular velocity and velocity of the body's origin (6), momentum and its moment about the
                       ground's origin (6), in ground axes
    pressed            wrench F that the joint transmits (6), I^A A + p^A or what is needed and what tips pass on;
                       its part across the free motion of the joint, force and moment in ground axes (6)

``inward`` reads the sum over the tips, p^a (6) and I^a (21), and passes on its own; ``final`` reads the parent's
acceleration and writes A (6). The loop decides their places, since few other steps need them. It also decides those of
the joint variables: y', τ or the part of y'' free of accelerations, sine and cosine of a turn, y of a slide; for a ball
or free joint q, u, τ.

From accelerations to forces, the joint's accelerations stand in place of τ, and there are two steps:

    carried            the wrench that the motion of the link alone needs (6), in place of V or behind it, and then
                       the varying terms of R and r; angular acceleration, acceleration of the origin, angular
                       velocity and turning of the link (18), where ``final`` writes A
    transmitted        wrench on the link in the parent (6), passed on; force along the joint (1, 3 or 6), in the
                       second record

The mass matrix takes the inertia of each link with all links outward of it (:mod:`freebody.dynamics.composite`):

    composed           composite inertia m, h, J in the parent (10), passed on; in place of the rows of D⁻¹ Uᵀ the
                       momentum of each motion of the joint at unit rate (6 k)
    projected          a momentum in the parent (6); its components along the joint (1, 3 or 6), in the second record

Where all links move in one plane, only a turn about its normal and two components of velocity differ from zero. The
space of these three motions is closed: a step needs the loads, inertias and accelerations in it, and leaves out the
others, which no acceleration depends on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from ...describe.joints.moving import Moving
from ...dynamics.articulated import apparent_inertia, columns_solved, free_motions, pivot
from ...dynamics.joints.freedom import Axis, carried_part
from ...dynamics.linear import Factorization
from ...dynamics.state import ball_joint, free_joint, one_dof_joint, unit_motion
from ...model.model import GROUND, Link, Model
from ...scalar.algebra import (
    HALF,
    IDENTITY,
    ZERO,
    Expression,
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    cross,
    multiply,
    scale,
)
from ...scalar.derivative import beside
from ...scalar.trace import Tape, Traced
from ...space.quaternion import Quaternion, quaternion_rate
from ...space.spatial import (
    Blocks,
    Spatial,
    blocks,
    blocks_sum,
    blocks_times,
    blocks_to_parent,
    force_cross,
    force_to_parent,
    inertia_sum,
    inertia_to_parent,
    momentum_of,
    motion_cross,
    motion_to_child,
    plus,
    power,
    rigid_inertia,
    times,
)
from ...space.turn import matrix_from_sine
from ..code.emit import Form
from ..kernel import KernelSet
from ..kernels import compile_tape
from . import link_masses

V, RATES = 0, 6
SECOND = 100
"""First place of the second record."""
COORDINATE_RATES = SECOND
PLACE = COORDINATE_RATES + 7
KINETIC, MOMENT, ORIGIN = PLACE + 12, PLACE + 13, PLACE + 16
MOVED = ORIGIN + 3
MOMENTUM = MOVED + 6
PRESSED = MOVED + 12
REACTION = PRESSED + 6
ALONG = REACTION + 6
WIDTH = ALONG + 6 - SECOND
"""Length of the second record."""
SUM = 27
"""Length of the sum that tips pass on: p^a (6), I^a (21)."""
COMPOSITE = 10
"""Length of a composite inertia."""

MOVING = 18
"""Numbers that describe a given motion of a link."""

OWN = 32
"""Number of a link's own constants: rotation (9), position (3), axis (3), pitch, mass, centre (3), inertia (9), origin
of the body (3)."""
CONSTANTS = OWN + link_masses.COUNT
"""Number of constants of a link: its own, and the masses that given motions take."""


@dataclass(frozen=True)
class Kind(Moving):
    """Properties that links with the same code have in common."""

    kind: str
    axis: int  # 0, 1, 2 for a coordinate axis, else -1
    driven: bool
    straight: bool  # True if the joint's axes are the parent's
    massless: bool
    free: bool  # True if its displacement can change alone
    normal: int = -1  # axis across the plane in which all links move: 0, 1, 2; -1 if there is no such plane
    bare: int = -1  # axis of the joint if masses on it count to the parent, else -1

    @property
    def joint_of_one(self) -> bool:
        """True if one displacement moves the link."""
        return self.one_dof

    @property
    def freedom(self) -> int:
        """Number of motions that forces determine."""
        if self.joint_of_one:
            return 0 if self.driven else 1
        return self.n_speeds

    @property
    def force(self) -> int:
        """Place of the force along a driven displacement."""
        return RATES + self.freedom

    @property
    def solved(self) -> int:
        """First place of the rows of D⁻¹ Uᵀ."""
        return RATES + (self.freedom or int(self.driven))

    @property
    def turn(self) -> int:
        """First place of the varying terms of R and r."""
        return self.solved + 7 * (self.freedom or int(self.driven))

    def kept(self, a: Spatial) -> Spatial:
        """Return a motion or force without the components across the plane in which the links move."""
        k = self.normal
        if k < 0:
            return a
        turn, shift = (
            tuple(x if (i == k) == inner else 0 for i, x in enumerate(v))
            for inner, v in zip((True, False), a, strict=True)
        )
        return (turn, shift)  # type: ignore[return-value]

    def kept_blocks(self, a: Blocks) -> Blocks:
        """Return an articulated inertia without the rows and columns across that plane."""
        k = self.normal
        if k < 0:
            return a
        return tuple(
            tuple(
                tuple(x if ((i == k), (j == k)) == inner else 0 for j, x in enumerate(row))
                for i, row in enumerate(block)
            )
            for inner, block in zip(((True, True), (True, False), (False, False)), a, strict=True)
        )  # type: ignore[return-value]


def kind_of(link: Link, free: bool, normal: int = -1) -> Kind:
    """Kind of a link; ``free`` is true if its displacement can change alone."""
    axis = IDENTITY.index(link.axis) if link.one_dof and link.axis in IDENTITY else -1
    massless = link.mass == 0 and link.body is None
    return Kind(link.kind, axis, link.driven, link.rotation == IDENTITY, massless, free, normal)


def normal_of(links: Sequence[Link]) -> int:
    """Return the axis, of all links and of the ground, across the plane in which they move; -1 if there is none."""

    def keeps(link: Link, k: int) -> bool:
        across = [link.axis[i] for i in range(3) if i != k]
        moves = {"weld": True, "hinge": not any(across), "slider": link.axis[k] == 0}
        row, column = link.rotation[k], [row[k] for row in link.rotation]
        turned = all(x == 0 for i in range(3) if i != k for x in (row[i], column[i]))
        return moves.get(link.kind, False) and turned

    return next((k for k in range(3) if all(keeps(link, k) for link in links)), -1)


def constants_of(model: Model, i: int) -> list[Expression]:
    """Expressions of a link's own constants, in the order of :data:`OWN`."""
    link = model.links[i]
    origin = ZERO if link.body is None else model.bodies[link.body].origin
    return [
        *(x for row in link.rotation for x in row), *link.position, *link.axis, link.pitch, link.mass, *link.center,
        *(x for row in link.inertia for x in row), *origin,
    ]  # fmt: skip


ARRAYS = {
    "record": 80, "joint": 20, "parent": 6, "tips": SUM, "above": MOVING, "own": 6, "second": WIDTH,
    "parents_second": WIDTH,
}  # fmt: skip
"""Lengths of the arrays that steps read: the link's record, joint variables, the parent's record, the sum over tips,
the parent's acceleration or given motion, the link's own, the second records."""

STEPS = {
    "outward": (("joint", "parent"), ("record", "second")),
    "inward": (("record", "joint", "tips"), ("passed", "record")),
    "final": (("record", "joint", "above"), ("own", "record")),
    "carried": (("joint", "above"), ("record", "own")),
    "transmitted": (("record", "tips"), ("passed", "second")),
    "composed": (("record", "tips"), ("passed", "record")),
    "projected": (("record", "own"), ("passed", "second")),
    "place": (("record", "parents_second"), ("second",)),
    "moved": (("record", "second"), ("second",)),
    "pressed": (("record", "own", "tips", "second"), ("second",)),
}
"""Arrays that each step reads and writes; ``passed`` is for the parent's sum."""


@dataclass(frozen=True)
class Step:
    """The compiled steps of a kind, and the length of its record."""

    compiled: KernelSet
    width: int


@lru_cache(maxsize=64)
def compiled_step(
    kind: Kind, names: tuple[str, ...], lanes: int = 1, shared: bool = True, derivatives: bool = False
) -> Step:
    """Compile some steps of a kind, for one state or for several side by side.

    With ``shared``, the constants are the same in all lanes. With ``derivatives``, each number is followed by its
    derivative along a direction.
    """
    tape = Tape()
    constants = [tape.input(f"c{k}") for k in range(CONSTANTS)]
    read = {name: [tape.input(f"{name} {k}") for k in range(n)] for name, n in ARRAYS.items()}
    needed = RATES if "outward" in names else V
    turn = needed + 6 if "carried" in names else kind.turn
    recorded = _recorded(tape, read, constants, kind, needed, turn)
    written = {name: recorded[name] for name in names}
    ones: Matrix = ((1, 1, 1),) * 3
    kept = [*_six(kind.kept((ones[0], ones[0]))), *_blocks_list(kind.kept_blocks((ones, ones, ones)))]
    results = {
        name: [
            ((STEPS[name][1].index(array), first + k), x)
            for array, first, values in parts
            for k, x in enumerate(values)
            if array not in ("passed", "own") or k >= len(kept) or kept[k]
        ]
        for name, parts in written.items()
    }
    functions = {name: [x for _, x in pairs] for name, pairs in results.items()}
    places = [[place for place, _ in pairs] for pairs in results.values()]
    state = [x for array in read.values() for x in array]
    sizes = tuple(ARRAYS.values())
    if derivatives:
        functions, state = beside(tape, functions, state)
        places = [[(array, 2 * place + k) for array, place in pairs for k in (0, 1)] for pairs in places]
        sizes = tuple(2 * n for n in sizes)
    arrays = list(ARRAYS)
    reads = tuple(tuple(arrays.index(x) for x in STEPS[name][0]) for name in written)
    writes = tuple(len(STEPS[name][1]) for name in written)
    form = Form(lanes, shared, sizes, reads, tuple(map(tuple, places)), writes)
    compiled = compile_tape(tape, functions, None, state, constants, form=form)
    return Step(
        compiled, turn + next(len(values) for _, start, values in recorded["outward"] if start == turn)
    )


Written = list[tuple[str, int, list[Scalar]]]
"""Results of a step: array, first place, values."""


def _recorded(
    tape: Tape, read: dict[str, list[Traced]], constants: list[Traced], kind: Kind, needed_at: int,
    turn_at: int,
) -> dict[str, Written]:  # fmt: skip
    """Record all steps of a kind, with the places of the needed wrench and of the varying terms of R and r."""
    given = turn_at == needed_at + 6
    record, joint, tips = read["record"], read["joint"], read["tips"]
    E, n = _constant_axes(constants, kind)
    inertia: Any = (0, ZERO, (ZERO, ZERO, ZERO))
    if not kind.massless:
        inertia = rigid_inertia(constants[16], _vector(constants[17:20]), _matrix(constants[20:29]))

    def spatial(x: Sequence[Scalar]) -> Spatial:
        return kind.kept(_spatial(x))

    S: Spatial | None = None
    tau: list[Traced] = []
    count = kind.freedom
    position, pitch = _vector(constants[9:12]), constants[15]
    if kind.fixed:
        R, r, vJ = E, position, (ZERO, ZERO)
    elif kind.pivots:
        R, r, vJ = ball_joint(E, position, joint[0:4], joint[4:7])
        tau = joint[7:10]
    elif kind.flies:
        R, r, vJ = free_joint(E, position, joint[0:7], joint[7:13])
        tau = joint[13:19]
    else:
        turned = matrix_from_sine(n, joint[2], joint[3])
        y = joint[4 if kind.motion.turns else 2]
        R, r, vJ = one_dof_joint(kind.motion, E, position, n, pitch, y, joint[0], turned)
        S = unit_motion(kind.motion, n, pitch)
        tau = joint[1:2]
    # outward
    V_i = plus(kind.kept(motion_to_child(R, r, spatial(read["parent"][V:]))), vJ)
    coordinate_rates: list[Scalar] = []
    if kind.flies:
        coordinate_rates = [
            *apply_transpose(E, apply(R, vJ[1])),
            *quaternion_rate(_quaternion(joint[3:7]), vJ[0]),
        ]
    elif kind.pivots:
        coordinate_rates = [*quaternion_rate(_quaternion(joint[0:4]), vJ[0])]
    turn, turn_read = _stored(tape, [*_flat(R), *r], joint, record[turn_at:])
    outward: Written = [
        ("record", V, [*_six(V_i)]),
        ("record", turn_at, turn),
        ("second", COORDINATE_RATES - SECOND, coordinate_rates),
    ]
    # inward, from the record that `outward` has written
    R_, r_ = _matrix(turn_read), _vector(turn_read[9:])
    V_ = spatial(record[V:])
    c = motion_cross(V_, vJ)
    if kind.driven and S is not None:
        c = plus(c, times(joint[1], S))
    p = force_cross(V_, momentum_of(inertia, V_))
    I_A = kind.kept_blocks(blocks_sum(_blocks(tips[6:]), blocks(inertia)))
    p_A = kind.kept(plus(_spatial(tips), p))
    motion = [] if kind.driven or kind.fixed else free_motions(_any_link(kind), S)
    pivots: Any = None
    stored: list[Scalar] = []
    if motion:
        U, m = pivot(motion, tau, I_A, p_A)
        D = Factorization([[power(S_k, W) for W in U] for S_k in motion])
        pivots = (motion, U, m, D)
        stored = [*(x for W in columns_solved(D, U) for x in _six(W)), *D.solve(m)]
    elif kind.driven and S is not None:
        stored = [*_six(blocks_times(I_A, S)), power(S, p_A)]
    I_a, p_a = apparent_inertia(I_A, p_A, c, tau if motion else [], pivots)
    inward: Written = [
        ("passed", 0, [*_six(force_to_parent(R_, r_, p_a)), *_blocks_list(blocks_to_parent(R_, r_, I_a))]),
        ("record", kind.solved, stored),
    ]
    # final:  y'' = D⁻¹ m - D⁻¹ Uᵀ A'
    moved_on = motion_to_child(R_, r_, spatial(read["above"]))
    a = plus(moved_on, c)
    rates: list[Scalar] = []
    for k in range(len(motion)):
        row = spatial(record[kind.solved + 6 * k :])
        rates.append(record[kind.solved + 6 * count + k] - power(a, row))
    force = []
    if kind.driven and S is not None:
        force = [power(a, spatial(record[kind.solved :])) + record[kind.solved + 6]]
    for S_k, rate in zip(motion, rates, strict=True):
        a = plus(a, times(rate, S_k))
    # carried, transmitted
    x = read["above"]
    motion_above = (_vector(x), _vector(x[3:6]), _vector(x[6:9]), _matrix(x[9:]))
    change: Spatial = (ZERO, ZERO) if S is None else times(joint[1], S)
    if kind.own:
        change = (_vector(tau), _vector(tau[3:6]) if kind.flies else ZERO)
    motion_given = link_masses.accelerated(R, r, vJ, change, motion_above)
    mass = link_masses.of(constants[OWN:], kind.bare)
    needed = (ZERO, ZERO) if kind.massless else link_masses.needed(mass, motion_given[3], motion_given[1])
    F = plus(_spatial(record[needed_at:]), _spatial(tips))
    # composed, projected
    moves = free_motions(_any_link(kind), S) if kind.own or S is not None else []
    x = tips
    composite = inertia_sum((x[0], _vector(x[1:4]), _symmetric(x[4:10])), inertia)
    total, first_moment, moment_of_inertia = inertia_to_parent(R_, r_, composite)
    momentum = _spatial(read["own"])
    # place
    above = read["parents_second"][PLACE - SECOND :]
    R_P, p_P = _matrix(above), _vector(above[9:])
    R_N, p_N = multiply(R_P, R_), add(p_P, apply(R_P, r_))
    kinetic = HALF * power(V_, momentum_of(inertia, V_))
    first = add(scale(inertia[0], p_N), apply(R_N, inertia[1]))
    shift = _vector(constants[29:32])
    origin = add(p_N, apply(R_N, shift))
    place = [*_flat(R_N), *p_N, kinetic, *first, *origin]
    # moved, pressed
    pose = read["second"][PLACE - SECOND :]
    R_N, p_N = _matrix(pose), _vector(pose[9:])
    w, v = apply(R_N, V_[0]), apply(R_N, add(V_[1], cross(V_[0], shift)))
    about, linear = (apply(R_N, x) for x in momentum_of(inertia, V_))
    F_A = F if given else plus(blocks_times(I_A, _spatial(read["own"])), p_A)
    axes = [Axis(0, kind.kind, n, pitch, True)] if kind.joint_of_one and kind.free else []
    moment, force_across = carried_part(kind if kind.own else None, axes, F_A)
    return {
        "outward": outward,
        "inward": inward,
        "final": [("own", 0, [*_six(a)]), ("record", RATES, [*rates, *force])],
        "carried": [
            ("record", turn_at, turn),
            ("record", needed_at, [*_six(needed)]),
            ("own", 0, [x for v in motion_given[:3] for x in v] + _flat(motion_given[3])),
        ],
        "transmitted": [
            ("passed", 0, [*_six(force_to_parent(R_, r_, F))]),
            ("second", ALONG - SECOND, [power(S_k, F) for S_k in moves]),
        ],
        "composed": [
            ("passed", 0, [total, *first_moment, *_upper(moment_of_inertia)]),
            ("record", kind.solved, [x for S_k in moves for x in _six(momentum_of(composite, S_k))]),
        ],
        "projected": [
            ("passed", 0, [*_six(force_to_parent(R_, r_, momentum))]),
            ("second", ALONG - SECOND, [power(S_k, momentum) for S_k in moves]),
        ],
        "place": [("second", PLACE - SECOND, place)],
        "moved": [("second", MOVED - SECOND, [*w, *v, *linear, *add(about, cross(p_N, linear))])],
        "pressed": [
            ("second", PRESSED - SECOND, [*_six(F_A), *apply(R_N, force_across), *apply(R_N, moment)])
        ],
    }


def _constant_axes(constants: Sequence[Traced], kind: Kind) -> tuple[Matrix, Vector]:
    """Return the constant part of R, and the axis of the joint, with the zeros that motion in a plane gives them."""
    E = IDENTITY if kind.straight else _matrix(constants[0:9])
    n = IDENTITY[kind.axis] if kind.axis >= 0 else _vector(constants[12:15])
    k = kind.normal
    if k >= 0:
        E = tuple(
            tuple(x if (i == k) == (j == k) else 0 for j, x in enumerate(row)) for i, row in enumerate(E)
        )  # type: ignore[assignment]
        n = tuple(x if (i == k) == kind.turns_only else 0 for i, x in enumerate(n))  # type: ignore[assignment]
    return E, n


def _stored(
    tape: Tape, values: list[Scalar], joint: list[Traced], places: list[Traced]
) -> tuple[list[Scalar], list[Scalar]]:
    """Return the numbers to store for later steps, and the values as read from these places.

    Each number is stored once, and none that depends on parameters alone.
    """
    moving = {x.index for x in joint}
    stored: dict[int, tuple[Any, Any]] = {}  # node -> itself, and the input that reads it again
    read = []
    for x in values:
        if type(x) is not Traced or moving.isdisjoint(tape.used([x])):
            read.append(x)
            continue
        bare = x if x.minus is None else x.minus
        if bare.index not in stored:
            stored[bare.index] = (bare, places[len(stored)])
        value = stored[bare.index][1]
        read.append(value if x.minus is None else -value)
    return [x for x, _ in stored.values()], read


def _any_link(kind: Kind) -> Link:
    """Return a link of this kind, for functions that depend on the kind only."""
    zero: Any = ZERO
    u = 0 if kind.own else -1
    return Link(
        "", None, kind.kind, GROUND, IDENTITY, zero, zero, 0, 0, ((0, 1),), 0, 0, u, u, 0, zero, IDENTITY
    )


def _quaternion(x: Sequence[Scalar]) -> Quaternion:
    return (x[0], x[1], x[2], x[3])


def _vector(x: Sequence[Scalar]) -> Vector:
    return (x[0], x[1], x[2])


def _matrix(x: Sequence[Scalar]) -> Matrix:
    return (_vector(x[0:3]), _vector(x[3:6]), _vector(x[6:9]))


def _spatial(x: Sequence[Scalar]) -> Spatial:
    return (_vector(x), _vector(x[3:6]))


def _six(a: Spatial) -> tuple[Scalar, ...]:
    return (*a[0], *a[1])


def _flat(R: Matrix) -> list[Scalar]:
    return [x for row in R for x in row]


def _blocks_list(a: Blocks) -> list[Scalar]:
    """The 21 numbers of blocks: J and M are symmetric, with six entries each."""
    J, H, M = a
    return [*_upper(J), *_flat(H), *_upper(M)]


def _upper(J: Matrix) -> list[Scalar]:
    return [J[0][0], J[0][1], J[0][2], J[1][1], J[1][2], J[2][2]]


def _symmetric(x: Sequence[Scalar]) -> Matrix:
    return ((x[0], x[1], x[2]), (x[1], x[3], x[4]), (x[2], x[4], x[5]))


def _blocks(x: Sequence[Scalar]) -> Blocks:
    return (_symmetric(x), _matrix(x[6:15]), _symmetric(x[15:21]))
