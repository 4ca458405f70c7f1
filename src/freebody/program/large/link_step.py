"""One link of the articulated-body algorithm as machine code: the steps that the looped path runs over all links.

The algorithm is that of :mod:`freebody.dynamics`, recorded for one link whose parent, constants and joint variables
are inputs. Links of one kind share the code.

What a link owns stands in two records, so that those of the motion are short and fit into a cache. The first:

    outward            V (6), and what R and r depend on besides the parameters (up to 12, behind the rest)
    final              y'' (k), force along a driven displacement (1)
    inward             rows of D⁻¹ Uᵀ (6 k), D⁻¹ m (k); of a driven displacement I^A S and S·p^A

The second:

    outward            q' of a ball or free joint (7)
    place              R_N (9), p_N (3), kinetic energy (1), first moment m p_N + R_N h (3), origin of the body (3)
    moved              angular velocity and velocity of the body's origin (6), momentum and its moment about the
                       ground's origin (6), in ground axes
    pressed            wrench F = I^A A + p^A that the joint transmits (6); what it carries across its free motion,
                       force and moment in ground axes (6)

``inward`` reads the sum of what the tips beyond pass on, p^a (6) and I^a (21), and passes on its own; ``final`` reads
the parent's acceleration and leaves A (6). Where these stand is up to the loop, since few others need them. So are the
joint variables: y, y', then τ or the part of y'' free of accelerations; of a ball or free joint q, u, τ.

From accelerations to forces, where those of the joint stand in place of τ, only these differ:

    carried            A (6), where ``final`` writes it
    started            the same at rest, with the joint's acceleration from its variables
    transmitted        wrench on the link in the parent (6), passed on; force along the joint (1, 3 or 6), in the
                       second record
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from ...dynamics.articulated import apparent_inertia, columns_solved, free_motions, pivot
from ...dynamics.joint_freedom import Axis, carried_part
from ...dynamics.linear import Factorization
from ...dynamics.state import ball_joint, free_joint, one_dof_joint
from ...model.model import GROUND, Link, Model
from ...scalar.algebra import HALF, IDENTITY, ZERO, add, apply, apply_transpose, cross, multiply, scale
from ...scalar.derivative import beside
from ...scalar.trace import Tape, Traced
from ...space.quaternion import quaternion_rate
from ...space.spatial import (
    Blocks,
    Spatial,
    blocks,
    blocks_sum,
    blocks_times,
    blocks_to_parent,
    force_cross,
    force_to_parent,
    momentum_of,
    motion_cross,
    motion_to_child,
    plus,
    power,
    rigid_inertia,
    times,
)
from ..code.emit import Form
from ..kernels import KernelSet, compile_tape

V, RATES = 0, 6
SECOND = 100
"""From this place on, a number is of the second record."""
COORDINATE_RATES = SECOND
PLACE = COORDINATE_RATES + 7
KINETIC, MOMENT, ORIGIN = PLACE + 12, PLACE + 13, PLACE + 16
MOVED = ORIGIN + 3
MOMENTUM = MOVED + 6
PRESSED = MOVED + 12
REACTION = PRESSED + 6
ALONG = REACTION + 6
WIDTH = ALONG + 6 - SECOND
"""Of the second record."""
SUM = 27
"""Of what tips pass on: p^a (6), I^a (21)."""

CONSTANTS = 32
"""Of a link: rotation (9), position (3), axis (3), pitch, mass, centre (3), inertia (9), origin of the body (3)."""


@dataclass(frozen=True)
class Kind:
    """What links must have in common to share their code."""

    kind: str
    axis: int  # 0, 1, 2 for a coordinate axis, else -1
    driven: bool
    straight: bool  # the joint's axes are the parent's
    massless: bool
    free: bool  # a displacement that can change alone

    @property
    def joint_of_one(self) -> bool:
        """Whether one displacement moves the link."""
        return self.kind in ("hinge", "slider", "screw")

    @property
    def freedom(self) -> int:
        """Number of motions that forces decide."""
        if self.joint_of_one:
            return 0 if self.driven else 1
        return {"ball": 3, "free": 6}.get(self.kind, 0)

    @property
    def force(self) -> int:
        """Where the force along a driven displacement is."""
        return RATES + self.freedom

    @property
    def kept(self) -> int:
        """Where the rows of D⁻¹ Uᵀ begin."""
        return RATES + (self.freedom or int(self.driven))

    @property
    def turn(self) -> int:
        """Where what R and r depend on begins."""
        return self.kept + 7 * (self.freedom or int(self.driven))


def kind_of(link: Link, free: bool) -> Kind:
    """The kind of a link; ``free`` tells whether its displacement can change alone."""
    axis = IDENTITY.index(link.axis) if link.one_dof and link.axis in IDENTITY else -1
    massless = link.mass == 0 and link.body is None
    return Kind(link.kind, axis, link.driven, link.rotation == IDENTITY, massless, free)


def constants_of(model: Model, i: int) -> list[Any]:
    """The expressions that :data:`CONSTANTS` lists."""
    link = model.links[i]
    origin = ZERO if link.body is None else model.bodies[link.body].origin
    return [
        *(x for row in link.rotation for x in row), *link.position, *link.axis, link.pitch, link.mass, *link.center,
        *(x for row in link.inertia for x in row), *origin,
    ]  # fmt: skip


ARRAYS = {
    "record": 80, "joint": 20, "parent": 6, "tips": SUM, "above": 6, "own": 6, "second": WIDTH, "parents_second": WIDTH,
}  # fmt: skip
"""What steps read: the link's record, joint variables, the parent's record, what the tips pass on, the parent's and the
link's own acceleration, the second records; and how many numbers."""

STEPS = {
    "outward": (("joint", "parent"), ("record", "second")),
    "inward": (("record", "joint", "tips"), ("passed", "record")),
    "final": (("record", "joint", "above"), ("own", "record")),
    "carried": (("record", "joint", "above"), ("own",)),
    "started": (("record", "joint", "above"), ("own",)),
    "transmitted": (("record", "own", "tips"), ("passed", "second")),
    "place": (("record", "parents_second"), ("second",)),
    "moved": (("record", "second"), ("second",)),
    "pressed": (("record", "own", "tips", "second"), ("second",)),
}
"""Of each step, what it reads and what it writes; ``passed`` is for the parent's sum."""


@dataclass(frozen=True)
class Step:
    """The compiled steps of a kind, and the length of its record."""

    compiled: KernelSet
    width: int


@lru_cache(maxsize=64)
def compiled_step(kind: Kind, lanes: int = 1, shared: bool = True, moved: bool = False) -> Step:
    """The steps that the head of this file names, of one state or of several side by side.

    ``shared``: the constants are the same in all lanes. ``moved``: every number has its derivative along a direction
    behind it.
    """
    tape = Tape()
    given = [tape.input(f"c{k}") for k in range(CONSTANTS)]
    read = {name: [tape.input(f"{name} {k}") for k in range(n)] for name, n in ARRAYS.items()}
    written = _recorded(tape, read, given, kind)
    functions = {name: [x for part in parts for x in part[2]] for name, parts in written.items()}
    places = [
        [
            (STEPS[name][1].index(array), first + k)
            for array, first, values in parts
            for k in range(len(values))
        ]
        for name, parts in written.items()
    ]
    state = [x for one in read.values() for x in one]
    sizes = tuple(ARRAYS.values())
    if moved:
        functions, state = beside(tape, functions, state)
        places = [[(array, 2 * place + k) for array, place in one for k in (0, 1)] for one in places]
        sizes = tuple(2 * n for n in sizes)
    names = list(ARRAYS)
    reads = tuple(tuple(names.index(x) for x in STEPS[name][0]) for name in written)
    writes = tuple(len(STEPS[name][1]) for name in written)
    form = Form(lanes, shared, sizes, reads, tuple(map(tuple, places)), writes)
    made = compile_tape(tape, functions, None, state, given, form=form)
    turn = next(len(values) for _, start, values in written["outward"] if start == kind.turn)
    return Step(made, kind.turn + turn)


Written = list[tuple[str, int, list[Any]]]
"""What a step writes: array, first place, values."""


def _recorded(tape: Tape, read: dict[str, list[Any]], given: list[Any], kind: Kind) -> dict[str, Written]:
    record, joint, tips = read["record"], read["joint"], read["tips"]
    E = IDENTITY if kind.straight else _matrix(given[0:9])
    n = IDENTITY[kind.axis] if kind.axis >= 0 else _vector(given[12:15])
    inertia: Any = (0, ZERO, (ZERO, ZERO, ZERO))
    if not kind.massless:
        inertia = rigid_inertia(given[16], _vector(given[17:20]), _matrix(given[20:29]))
    S: Spatial | None = None
    tau: list[Any] = []
    count = kind.freedom
    if kind.kind == "weld":
        R, r, vJ = E, _vector(given[9:12]), (ZERO, ZERO)
    elif kind.kind == "ball":
        R, r, vJ = ball_joint(E, _vector(given[9:12]), joint[0:4], joint[4:7])
        tau = joint[7:10]
    elif kind.kind == "free":
        R, r, vJ = free_joint(E, _vector(given[9:12]), joint[0:7], joint[7:13])
        tau = joint[13:19]
    else:
        pitch = given[15]
        R, r, vJ = one_dof_joint(kind.kind, E, _vector(given[9:12]), n, pitch, joint[0], joint[1], tape)
        S = {"slider": (ZERO, n), "hinge": (n, ZERO)}.get(kind.kind, (n, scale(pitch, n)))
        tau = joint[2:3]
    # outward
    V_i = plus(motion_to_child(R, r, _spatial(read["parent"][V:])), vJ)
    coordinate_rates: list[Any] = []
    if kind.kind == "free":
        coordinate_rates = [*apply_transpose(E, apply(R, vJ[1])), *quaternion_rate(tuple(joint[3:7]), vJ[0])]
    elif kind.kind == "ball":
        coordinate_rates = [*quaternion_rate(tuple(joint[0:4]), vJ[0])]
    turn, placed = _kept(tape, [*_flat(R), *r], joint, record[kind.turn :])
    outward: Written = [
        ("record", V, [*_six(V_i)]),
        ("record", kind.turn, turn),
        ("second", COORDINATE_RATES - SECOND, coordinate_rates),
    ]
    # inward: what stands in the record by then
    R_, r_ = _matrix(placed), _vector(placed[9:])
    V_ = _spatial(record[V:])
    c = motion_cross(V_, vJ)
    if kind.driven and S is not None:
        c = plus(c, times(joint[2], S))
    p = force_cross(V_, momentum_of(inertia, V_))
    I_A, p_A = blocks_sum(_blocks(tips[6:]), blocks(inertia)), plus(_spatial(tips), p)
    motion = [] if kind.driven or kind.kind == "weld" else free_motions(_any_link(kind), S)
    kept: Any = None
    stored: list[Any] = []
    if motion:
        U, m = pivot(motion, tau, I_A, p_A)
        D = Factorization([[power(S_k, W) for W in U] for S_k in motion])
        kept = (motion, U, m, D)
        stored = [*(x for W in columns_solved(D, U) for x in _six(W)), *D.solve(m)]
    elif kind.driven and S is not None:
        stored = [*_six(blocks_times(I_A, S)), power(S, p_A)]
    I_a, p_a = apparent_inertia(I_A, p_A, c, tau if motion else [], kept)
    inward: Written = [
        ("passed", 0, [*_six(force_to_parent(R_, r_, p_a)), *_blocks_list(blocks_to_parent(R_, r_, I_a))]),
        ("record", kind.kept, stored),
    ]
    # final:  y'' = D⁻¹ m - D⁻¹ Uᵀ A'
    moved_on = motion_to_child(R_, r_, _spatial(read["above"]))
    a = plus(moved_on, c)
    rates: list[Any] = []
    for k in range(len(motion)):
        row = _spatial(record[kind.kept + 6 * k :])
        rates.append(record[kind.kept + 6 * count + k] - power(a, row))
    force = []
    if kind.driven and S is not None:
        force = [power(a, _spatial(record[kind.kept :])) + record[kind.kept + 6]]
    for S_k, rate in zip(motion, rates, strict=True):
        a = plus(a, times(rate, S_k))
    # carried, transmitted: c holds the acceleration along a displacement that is driven
    started, carried = moved_on, plus(moved_on, c)
    if kind.kind in ("ball", "free"):
        own = (_vector(tau), _vector(tau[3:6]) if kind.kind == "free" else ZERO)
        started, carried = plus(started, own), plus(carried, own)
    elif S is not None:
        started = plus(started, times(joint[2], S))
    A_ = _spatial(read["own"])
    F = plus(momentum_of(inertia, A_), p_A)
    along = [] if S is None else [power(S, F)]
    if kind.kind in ("ball", "free"):
        along = [*F[0], *(F[1] if kind.kind == "free" else ())]
    # place
    above = read["parents_second"][PLACE - SECOND :]
    R_P, p_P = _matrix(above), _vector(above[9:])
    R_N, p_N = multiply(R_P, R_), add(p_P, apply(R_P, r_))
    kinetic = HALF * power(V_, momentum_of(inertia, V_))
    first = add(scale(inertia[0], p_N), apply(R_N, inertia[1]))
    shift = _vector(given[29:32])
    origin = add(p_N, apply(R_N, shift))
    place = [*_flat(R_N), *p_N, kinetic, *first, *origin]
    # moved, pressed
    here = read["second"][PLACE - SECOND :]
    R_N, p_N = _matrix(here), _vector(here[9:])
    w, v = apply(R_N, V_[0]), apply(R_N, add(V_[1], cross(V_[0], shift)))
    about, linear = (apply(R_N, x) for x in momentum_of(inertia, V_))
    F_A = plus(blocks_times(I_A, A_), p_A)
    axes = [Axis(0, kind.kind, n, given[15], True)] if kind.joint_of_one and kind.free else []
    moment, force_across = carried_part({kind.kind}, axes, F_A)
    return {
        "outward": outward,
        "inward": inward,
        "final": [("own", 0, [*_six(a)]), ("record", RATES, [*rates, *force])],
        "carried": [("own", 0, [*_six(carried)])],
        "started": [("own", 0, [*_six(started)])],
        "transmitted": [
            ("passed", 0, [*_six(force_to_parent(R_, r_, F))]),
            ("second", ALONG - SECOND, along),
        ],
        "place": [("second", PLACE - SECOND, place)],
        "moved": [("second", MOVED - SECOND, [*w, *v, *linear, *add(about, cross(p_N, linear))])],
        "pressed": [
            ("second", PRESSED - SECOND, [*_six(F_A), *apply(R_N, force_across), *apply(R_N, moment)])
        ],
    }


def _kept(tape: Tape, values: list[Any], joint: list[Any], places: list[Any]) -> tuple[list[Any], list[Any]]:
    """What is to be kept of values, each number once and none that depends on parameters alone; and the values, read
    from these places."""
    moving = {x.index for x in joint}
    stored: dict[int, tuple[Any, Any]] = {}  # node -> itself, where it is read again
    read = []
    for x in values:
        if type(x) is not Traced or moving.isdisjoint(tape.used([x])):
            read.append(x)
            continue
        bare = x if x.minus is None else x.minus
        if bare.index not in stored:
            stored[bare.index] = (bare, places[len(stored)])
        found = stored[bare.index][1]
        read.append(found if x.minus is None else -found)
    return [x for x, _ in stored.values()], read


def _any_link(kind: Kind) -> Link:
    """A link of this kind, for what depends on the kind only."""
    zero: Any = ZERO
    u = 0 if kind.kind in ("ball", "free") else -1
    return Link(
        "", None, kind.kind, GROUND, IDENTITY, zero, zero, 0, 0, ((0, 1),), 0, 0, u, u, 0, zero, IDENTITY
    )


def _vector(x: Any) -> Any:
    return (x[0], x[1], x[2])


def _matrix(x: Any) -> Any:
    return (tuple(x[0:3]), tuple(x[3:6]), tuple(x[6:9]))


def _spatial(x: Any) -> Spatial:
    return (_vector(x), _vector(x[3:6]))


def _six(a: Spatial) -> tuple[Any, ...]:
    return (*a[0], *a[1])


def _flat(R: Any) -> list[Any]:
    return [x for row in R for x in row]


def _blocks_list(a: Blocks) -> list[Any]:
    """J and M are symmetric: six entries each."""
    J, H, M = a
    return [*_upper(J), *_flat(H), *_upper(M)]


def _upper(J: Any) -> list[Any]:
    return [J[0][0], J[0][1], J[0][2], J[1][1], J[1][2], J[2][2]]


def _symmetric(x: Any) -> Any:
    return ((x[0], x[1], x[2]), (x[1], x[3], x[4]), (x[2], x[4], x[5]))


def _blocks(x: Any) -> Blocks:
    return (_symmetric(x), _matrix(x[6:15]), _symmetric(x[15:21]))
