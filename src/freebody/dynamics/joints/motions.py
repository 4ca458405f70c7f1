"""Free motions of a joint as twists about its point, each with the wrench that has power in it alone.

Twists t_i = (w_i, v_i) with wrenches f_j, t_i·f_j = δ_ij. The turns w_i of motions that turn have dual vectors w^i in
their span, w^i·w_j = δ_ij; those of turns about parallel axes are one turn, and their differences slide. A turn beside
a ball is a turn of the ball, and differs from it by a slide, too. With the dual vectors s^k of the slides s_k,

    slide k     force s^k,    couple -Σ_i (v_i·s^k) w^i
    turn i      couple w^i,   less the wrenches of the slides with which other turns differ from it.

What a joint transmits has no power in any of them. Chains with anchors and paths need this;
for the others the axes alone tell it (:mod:`freebody.dynamics.joints.freedom`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...model.model import JointPlace, Model
from ...scalar.algebra import (
    IDENTITY,
    ZERO,
    Scalar,
    Vector,
    add,
    apply_transpose,
    cross,
    divide,
    dot,
    scale,
    subtract,
)
from ...space.spatial import ZERO6, Spatial, minus, plus, times
from ..state import State

Key = tuple[str, int]
"""("link", number) of the motion of one link, ("speed", number) of the motion of a path with one coordinate."""


@dataclass(frozen=True)
class Twist:
    """A motion per unit rate: of the joint's point, in the axes of its last link; ``head`` and ``sign`` tell the turn
    that it is parallel to (its own key if there is none).
    """

    key: Key
    turn: Vector
    slide: Vector
    turns: bool
    head: Key
    sign: int


def twists(model: Model, state: State, joint: JointPlace) -> list[Twist]:
    """Return the motions of the joint's links, first to last; of a path, those of the coordinates that only it has."""
    found: list[
        tuple[int, int, Spatial]
    ] = []  # link, its motion among several, twist at the last origin so far
    for i in joint.links:
        R, p, _ = state.joint(i)
        found = [
            (k, n, (apply_transpose(R, w), apply_transpose(R, add(v, cross(w, p))))) for k, n, (w, v) in found
        ]
        link = model.links[i]
        if link.one_dof:
            found.append((i, 0, state.subspace(i)))
        elif link.u >= 0:
            found += [(i, n, (e, ZERO)) for n, e in enumerate(IDENTITY)]
    if joint.pair.path:
        return _of_path(model, state, joint, {i: twist for i, _, twist in found})
    result = []
    for i, n, (w, v) in found:
        head, sign = joint.parallel[joint.links.index(i)]
        key = ("link", i) if n == 0 else (f"turn {n}", i)
        at_head = key if joint.links[head] == i else ("link", joint.links[head])
        result.append(Twist(key, w, v, model.links[i].motion.turns, at_head, sign))
    return result


def _of_path(model: Model, state: State, joint: JointPlace, found: dict[int, Spatial]) -> list[Twist]:
    """The motion of a path per unit speed: Σ ∂y_i/∂q_j t_i."""
    result = []
    for j in path_speeds(model, joint):
        total, turns = ZERO6, False
        for i, twist in found.items():
            partial = dict(model.links[i].partials).get(j, 0)
            if partial != 0:
                total, turns = plus(total, times(state(partial), twist)), turns or model.links[i].motion.turns
        result.append(Twist(("speed", j), *total, turns, ("speed", j), 1))
    return result


def path_speeds(model: Model, joint: JointPlace) -> list[int]:
    """Return the speeds that occur in the displacements of this joint only."""
    own = dict.fromkeys(j for i in joint.links for j, _ in model.links[i].partials)
    others = {j for i, link in enumerate(model.links) if i not in joint.links for j, _ in link.partials}
    return [j for j in own if j not in others]


def wrenches(motions: Sequence[Twist]) -> list[Spatial]:
    """Return for each motion the wrench that has power one in it and none in the others."""
    slides, turns = slides_and_turns(motions)
    up = dual([t.turn for t in turns])
    shares = shares_of(motions)
    result: dict[Key, Spatial] = {}
    for key, force in zip(slides, dual([*slides.values()]), strict=True):
        result[key] = (couple_beside(force, turns, up), force)
    for head, w in zip(turns, up, strict=True):
        result[head.key] = (w, ZERO)
        for key, parts in shares.items():
            for one, share in parts:
                if one is head:
                    result[head.key] = minus(result[head.key], times(share, result[key]))
    return [result[t.key] for t in motions]


def couple_beside(force: Vector, turns: Sequence[Twist], up: Sequence[Vector]) -> Vector:
    """Return the couple that takes the power of a force in the turns away, -Σ (v_i·f) w^i."""
    couple: Vector = ZERO
    for t, w in zip(turns, up, strict=True):
        power = dot(t.slide, force)
        if type(power) is not int or power != 0:
            couple = subtract(couple, scale(power, w))
    return couple


def dual(vectors: Sequence[Vector]) -> list[Vector]:
    """Return the vectors b_i in the span of up to three vectors a_j with b_i·a_j = δ_ij."""
    if len(vectors) == 1:
        (a,) = vectors
        return [scale(divide(1, dot(a, a)), a)]
    if len(vectors) == 2:
        a, b = vectors
        n = cross(a, b)
        size = divide(1, dot(n, n))
        return [scale(size, cross(b, n)), scale(size, cross(n, a))]
    if len(vectors) == 3:
        a, b, c = vectors
        size = divide(1, dot(a, cross(b, c)))
        return [scale(size, cross(b, c)), scale(size, cross(c, a)), scale(size, cross(a, b))]
    return []


def slides_and_turns(motions: Sequence[Twist]) -> tuple[dict[Key, Vector], list[Twist]]:
    """Return the directions along which motions slide, by their keys, and the turns that are not parallel."""
    shares = shares_of(motions)
    slides: dict[Key, Vector] = {}
    for t in motions:
        if not t.turns or t.key in shares:
            slides[t.key] = t.slide
            for head, share in shares.get(t.key, ()):
                slides[t.key] = subtract(slides[t.key], scale(share, head.slide))
    return slides, [t for t in motions if t.turns and t.key not in shares]


def shares_of(motions: Sequence[Twist]) -> dict[Key, list[tuple[Twist, Scalar]]]:
    """Return the turns that are made of others, w = Σ share w_j, by their keys: parallel ones, and those beside a ball,
    whose axes are at right angles.
    """
    balls = {t.key[1] for t in motions if t.key[0].startswith("turn")}
    axes = [t for t in motions if t.turns and t.key[1] in balls]
    heads: dict[Key, Twist] = {}
    result: dict[Key, list[tuple[Twist, Scalar]]] = {}
    for t in motions:
        if t.turns and axes and t.key[1] not in balls:
            result[t.key] = [(axis, dot(t.turn, axis.turn)) for axis in axes]
        elif t.turns and heads.setdefault(t.head, t) is not t:
            result[t.key] = [(heads[t.head], t.sign * heads[t.head].sign)]
    return result


def carried(motions: Sequence[Twist], wrench: Spatial) -> Spatial:
    """Return a wrench less its parts with power in the motions."""
    result = wrench
    for t, own in zip(motions, wrenches(motions), strict=True):
        result = minus(result, times(dot(t.turn, wrench[0]) + dot(t.slide, wrench[1]), own))
    return result
