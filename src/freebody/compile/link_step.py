"""One link of the articulated-body algorithm as machine code: the steps that the looped path runs over all links.

The algorithm is that of :mod:`freebody.dynamics`, recorded for one link whose parent, constants and joint variables
are inputs. Links of one kind share the code.

A link owns a record of :data:`WIDTH` doubles:

    from the parent    V (6), A (6), R_N (9), p_N (3)
    joint variables    y, y', then τ or the part of y'' free of accelerations; of a ball or free joint q, u, τ
    outward            R (9), r (3), V (6), c (6), I^A (21), p^A (6), q' of a ball or free joint (7)
    inward             I^a (21) and p^a (6) in the parent, U (6 k), m (k), D (k k)
    final              A (6), y'' (k), force along a driven displacement (1)
    place              R_N (9), p_N (3), kinetic energy (1), first moment m p_N + R_N h (3), origin of the body (3)
    moved              angular velocity and velocity of the body's origin (6), momentum and its moment about the
                       ground's origin (6), in ground axes
    pressed            wrench F = I^A A + p^A that the joint transmits (6); what it carries across its free motion,
                       force and moment in ground axes (6)

From accelerations to forces, where those of the joint stand in place of τ, only these differ:

    carried            A (6), where ``final`` writes it
    started            the same at rest, with the joint's acceleration from its variables
    transmitted        wrench on the link in the parent (6), force along the joint (1, 3 or 6), where ``inward`` writes
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from ..dynamics.articulated import accelerated, free_motions, passed_on, pivot
from ..dynamics.joint_freedom import Axis
from ..dynamics.joint_freedom import carried as carried_by
from ..dynamics.linear import Factorization
from ..dynamics.state import displaced, flown, turned
from ..model.model import GROUND, Link, Model
from ..scalar.algebra import HALF, IDENTITY, ZERO, add, apply, apply_transpose, cross, multiply, scale
from ..scalar.trace import Tape
from ..space.quaternion import quaternion_rate
from ..space.spatial import (
    Blocks,
    Spatial,
    blocks,
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
from .kernels import KernelSet, compile_tape

PARENT_V, PARENT_A, PARENT_PLACE = 0, 6, 12
JOINT = 24
OUTWARD = 44
V, INERTIA, COORDINATE_RATES = OUTWARD + 12, OUTWARD + 24, OUTWARD + 51
INWARD = OUTWARD + 58
ALONG = INWARD + 6
FINAL = INWARD + 27 + 36 + 6 + 36
A, RATES = FINAL, FINAL + 6
PLACE = FINAL + 13
KINETIC, MOMENT, ORIGIN = PLACE + 12, PLACE + 13, PLACE + 16
MOVED = ORIGIN + 3
MOMENTUM = MOVED + 6
PRESSED = MOVED + 12
REACTION = PRESSED + 6
WIDTH = 264

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


@lru_cache(maxsize=64)
def compiled_step(kind: Kind) -> KernelSet:
    """Kernels of a kind: the steps that the head of this file names.

    They read the record and write the part of it that their name says.
    """
    tape = Tape()
    record = [tape.input(f"r{k}") for k in range(WIDTH)]
    given = [tape.input(f"c{k}") for k in range(CONSTANTS)]
    functions = _recorded(tape, record, given, kind)
    time = tape.input("t")
    return compile_tape(tape, functions, time, record, given)


def _recorded(tape: Tape, record: list[Any], given: list[Any], kind: Kind) -> dict[str, list[Any]]:
    E = IDENTITY if kind.straight else _matrix(given[0:9])
    n = IDENTITY[kind.axis] if kind.axis >= 0 else _vector(given[12:15])
    inertia: Any = (0, ZERO, (ZERO, ZERO, ZERO))
    if not kind.massless:
        inertia = rigid_inertia(given[16], _vector(given[17:20]), _matrix(given[20:29]))
    joint = record[JOINT:OUTWARD]
    S: Spatial | None = None
    coordinate_rates: list[Any] = []
    count = kind.freedom
    if kind.kind == "weld":
        R, r, vJ = E, _vector(given[9:12]), (ZERO, ZERO)
    elif kind.kind == "ball":
        R, r, vJ = turned(E, _vector(given[9:12]), joint[0:4], joint[4:7])
        coordinate_rates = [*quaternion_rate(tuple(joint[0:4]), vJ[0])]
        tau = joint[7:10]
    elif kind.kind == "free":
        R, r, vJ = flown(E, _vector(given[9:12]), joint[0:7], joint[7:13])
        position = apply_transpose(E, apply(R, vJ[1]))
        coordinate_rates = [*position, *quaternion_rate(tuple(joint[3:7]), vJ[0])]
        tau = joint[13:19]
    else:
        pitch = given[15]
        R, r, vJ = displaced(kind.kind, E, _vector(given[9:12]), n, pitch, joint[0], joint[1], tape)
        S = {"slider": (ZERO, n), "hinge": (n, ZERO)}.get(kind.kind, (n, scale(pitch, n)))
        tau = joint[2:3]
    # outward
    V_i = plus(motion_to_child(R, r, _spatial(record[PARENT_V:])), vJ)
    c = motion_cross(V_i, vJ)
    if kind.driven and S is not None:
        c = plus(c, times(joint[2], S))
    p = force_cross(V_i, momentum_of(inertia, V_i))
    outward = [
        *_flat(R), *r, *_six(V_i), *_six(c), *_blocks_list(blocks(inertia)), *_six(p), *coordinate_rates
    ]  # fmt: skip
    # inward: what stands in the record by then
    R_, r_ = _matrix(record[OUTWARD:]), _vector(record[OUTWARD + 9 :])
    if kind.kind == "slider":
        R_ = E
    elif kind.kind != "free" and kind.kind != "screw":
        r_ = _vector(given[9:12])
    V_, c_ = _spatial(record[V:]), _spatial(record[V + 6 :])
    I_A, p_A = _blocks(record[INERTIA:]), _spatial(record[INERTIA + 21 :])
    motion = [] if kind.driven or kind.kind == "weld" else free_motions(_any_link(kind), S)
    kept: Any = None
    stored: list[Any] = []
    if motion:
        U, m = pivot(motion, tau, I_A, p_A)
        D = [[power(S_k, W) for W in U] for S_k in motion]
        kept = (motion, U, m, Factorization(D))
        stored = [*(x for W in U for x in _six(W)), *m, *(x for row in D for x in row)]
    I_a, p_a = passed_on(I_A, p_A, c_, tau if motion else [], kept)
    inward = [*_blocks_list(blocks_to_parent(R_, r_, I_a)), *_six(force_to_parent(R_, r_, p_a)), *stored]
    # final
    a = plus(motion_to_child(R_, r_, _spatial(record[PARENT_A:])), c_)
    rates: list[Any] = []
    if motion:
        start = INWARD + 27
        U = [_spatial(record[start + 6 * k :]) for k in range(count)]
        m = record[start + 6 * count : start + 7 * count]
        rest = record[start + 7 * count :]
        D = [[rest[count * j + k] for k in range(count)] for j in range(count)]
        rates, a = accelerated(a, (motion, U, m, Factorization(D)))
    force = []
    if kind.driven and S is not None:
        force = [power(S, plus(blocks_times(I_A, a), p_A))]
    # carried, transmitted: c holds the acceleration along a displacement that is driven
    started = motion_to_child(R_, r_, _spatial(record[PARENT_A:]))
    carried = plus(started, c_)
    if kind.kind in ("ball", "free"):
        own = (_vector(tau), _vector(tau[3:6]) if kind.kind == "free" else ZERO)
        started, carried = plus(started, own), plus(carried, own)
    elif S is not None:
        started = plus(started, times(joint[2], S))
    F = plus(momentum_of(inertia, _spatial(record[A:])), p_A)
    along = [] if S is None else [power(S, F)]
    if kind.kind in ("ball", "free"):
        along = [*F[0], *(F[1] if kind.kind == "free" else ())]
    # place
    P = PARENT_PLACE
    R_P, p_P = _matrix(record[P:]), _vector(record[P + 9 :])
    R_N, p_N = multiply(R_P, R_), add(p_P, apply(R_P, r_))
    placed = [*_flat(R_N), *p_N]
    kinetic = HALF * power(V_, momentum_of(inertia, V_))
    first = add(scale(inertia[0], p_N), apply(R_N, inertia[1]))
    shift = _vector(given[29:32])
    origin = add(p_N, apply(R_N, shift))
    # moved, pressed
    R_N, p_N = _matrix(record[PLACE:]), _vector(record[PLACE + 9 :])
    w, v = apply(R_N, V_[0]), apply(R_N, add(V_[1], cross(V_[0], shift)))
    about, linear = (apply(R_N, x) for x in momentum_of(inertia, V_))
    F_A = plus(blocks_times(I_A, _spatial(record[A:])), p_A)
    axes = [Axis(0, kind.kind, n, given[15], True)] if kind.joint_of_one and kind.free else []
    moment, force_across = carried_by({kind.kind}, axes, F_A)
    return {
        "outward": outward,
        "inward": inward,
        "final": [*_six(a), *rates, *force],
        "carried": [*_six(carried)],
        "started": [*_six(started)],
        "transmitted": [*_six(force_to_parent(R_, r_, F)), *along],
        "place": [*placed, kinetic, *first, *origin],
        "moved": [*w, *v, *linear, *add(about, cross(p_N, linear))],
        "pressed": [*_six(F_A), *apply(R_N, force_across), *apply(R_N, moment)],
    }


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
