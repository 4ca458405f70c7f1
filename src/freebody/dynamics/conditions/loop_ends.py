"""Motion of the two ends of a loop relative to the link that carries it.

Without accelerations u', outward along the loop, with r from the parent's origin to the link's origin and the motion
(w_J, v_J) of the joint:

    a_i = a_p + B_p r + 2 w_p × v_J + w_J × v_J + y'' s        B = [α]× + [w]×²
    α_i = α_p + w_p × w_J + y'' n                              w_i = w_p + w_J

so that a point at r from the origin of a link has the acceleration a + B r.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 8, there with spatial accelerations.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...model.closure import Closure
from ...model.model import GROUND, Model
from ...scalar.algebra import (
    IDENTITY,
    ZERO,
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    cross,
    dot,
    multiply,
    subtract,
    transpose,
)
from ...space.spatial import times
from ..kinematics import Posture, link_postures, motions, place_of, turning
from ..state import State
from .dependence import loop_links


@dataclass(frozen=True)
class End:
    """One side of a closure: its axes and its point."""

    axes: Matrix
    place: Vector


def carrier_of(model: Model, joint: Closure) -> int:
    """Return the link that carries the whole loop."""
    links = loop_links(model, joint)
    return model.links[min(links)].parent if links else place_of(model, joint.parent)[0]


def ends(model: Model, state: State, joint: Closure) -> tuple[End, End]:
    """Return the parent's side and the child's side, in the axes of :func:`carrier_of`."""
    carrier = carrier_of(model, joint)
    result = []
    for body, axes, at in (
        (joint.parent, joint.parent_axes, joint.at),
        (joint.child, joint.child_axes, joint.to),
    ):
        link, origin = place_of(model, body)
        side = _side(model, state, link, carrier)
        point = state.vector(tuple(a + b for a, b in zip(origin, body.point(*at).components, strict=True)))
        arm = apply(side.rotation, point)
        result.append(End(multiply(side.rotation, state.matrix(axes)), add(side.position, arm)))
    return result[0], result[1]


def _side(model: Model, state: State, link: int, carrier: int) -> Posture:
    """Return the pose of a link in the axes of a link that carries it."""
    if carrier == GROUND:
        return Posture(IDENTITY, ZERO) if link == GROUND else link_postures(model, state)[link]
    postures = state.cache.setdefault(("sides", carrier), {carrier: Posture(IDENTITY, ZERO)})
    if link not in postures:
        P = _side(model, state, model.links[link].parent, carrier)
        R, p, _ = state.joint(link)
        postures[link] = Posture(multiply(P.rotation, R), add(P.position, apply(P.rotation, p)))
    return postures[link]


def last_link(model: Model, joint: Closure) -> int:
    """Return the link at the end of the longer side, in whose axes most vectors are constant."""
    P, C = _sides(model, joint)
    return (P if len(P) > len(C) else C or [carrier_of(model, joint)])[-1]


def _sides(model: Model, joint: Closure) -> tuple[list[int], list[int]]:
    """Return the links of the loop from the carrier outward, to the parent and to the child."""
    carrier = carrier_of(model, joint)
    result = []
    for body in (joint.parent, joint.child):
        links: list[int] = []
        link, _ = place_of(model, body)
        while link != carrier:
            links.insert(0, link)
            link = model.links[link].parent
        result.append(links)
    return result[0], result[1]


def _rotations(model: Model, state: State, joint: Closure, link: int) -> dict[int, Matrix]:
    """Return the rotations of the links of a loop and of its carrier into the axes of one of them."""
    R = {link: IDENTITY}
    for side in _sides(model, joint):
        if link in side:
            for i in reversed(side[: side.index(link) + 1]):
                R[model.links[i].parent] = multiply(R[i], transpose(state.joint(i)[0]))
    for side in _sides(model, joint):
        for i in side:
            if i not in R:
                R[i] = multiply(R[model.links[i].parent], state.joint(i)[0])
    return R


def loop_rows(
    model: Model, state: State, joint: Closure, frame: int
) -> tuple[list[list[Scalar]], list[Scalar]]:
    """Return G and γ of a closure whose points coincide, its force in the axes of the link ``frame`` of the loop.

    A joint with the motion (n, s) per unit speed moves the end at r from its link's origin by s + n × r, and turns a
    vector B by n × B. γ is e·(a_C - a_P); for A·B, with A fixed in the parent and B in the child, it is
    A·([α]× + [w]×²) B of the relative motion, w = w_C - w_P, α = α_C - α_P - w_P × w_C.
    """
    R = _rotations(model, state, joint, frame)
    A: list[Vector] = []
    B: list[Vector] = []
    for _, a, b in joint.square:
        for vectors, body, axes, e in (
            (A, joint.parent, joint.parent_axes, a),
            (B, joint.child, joint.child_axes, b),
        ):
            vectors.append(apply(R[place_of(model, body)[0]], apply(state.matrix(axes), state.vector(e))))
    G: list[list[Scalar]] = [[0] * model.n_u for _ in range(3 + len(A))]
    turns, ends_move = [], []
    for sign, links, body, at in zip(
        (-1, 1), _sides(model, joint), (joint.parent, joint.child), (joint.at, joint.to), strict=True
    ):
        link, origin = place_of(model, body)
        point = state.vector(tuple(x + y for x, y in zip(origin, body.point(*at).components, strict=True)))
        arm = r = apply(R[link], point)
        w, alpha, acceleration = ZERO, ZERO, ZERO
        for i in reversed(links):
            for j, weight, (n, s) in motions(model, state, i):
                n, s = apply(R[i], n), apply(R[i], s)
                moved = (*add(s, cross(n, r)), *(dot(a, cross(n, b)) for a, b in zip(A, B, strict=True)))
                for k, x in enumerate(moved):
                    G[k][j] = G[k][j] + sign * (weight * x)
            r = add(r, apply(R[model.links[i].parent], state.joint(i)[1]))
        for i in links:
            member, (_, p, (wJ, vJ)) = model.links[i], state.joint(i)
            p, wJ, vJ = apply(R[member.parent], p), apply(R[i], wJ), apply(R[i], vJ)
            acceleration = add(acceleration, apply(turning(w, alpha), p))
            acceleration = add(acceleration, cross(add(add(w, w), wJ), vJ))
            alpha = add(alpha, cross(w, wJ))
            if member.one_dof:
                turn, slide = times(state.second_rate(member, None), state.subspace(i))
                alpha, acceleration = add(alpha, apply(R[i], turn)), add(acceleration, apply(R[i], slide))
            w = add(w, wJ)
        turns.append((w, alpha))
        ends_move.append(add(acceleration, apply(turning(w, alpha), arm)))
    (w_P, alpha_P), (w_C, alpha_C) = turns
    relative = turning(subtract(w_C, w_P), subtract(subtract(alpha_C, alpha_P), cross(w_P, w_C)))
    bias = [dot(a, apply(relative, b)) for a, b in zip(A, B, strict=True)]
    return G, [*subtract(ends_move[1], ends_move[0]), *bias]
