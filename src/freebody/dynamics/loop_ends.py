"""The two ends of a loop, seen from the link that carries it, and their motion without accelerations u'.

Outward along the loop, in the axes of the carrier, with r from the parent's origin to that of the link and (w_J, v_J)
the motion of the joint:

    a_i = a_p + B_p r + 2 w_p × v_J + w_J × v_J + y'' s        B = [α]× + [w]×²
    α_i = α_p + w_p × w_J + y'' n                              w_i = w_p + w_J

so that a point at r from the origin of a link has the acceleration a + B r.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 8, there with spatial accelerations.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..model.closure import Closure
from ..model.model import GROUND, Model
from ..scalar.algebra import (
    IDENTITY,
    ZERO,
    Matrix,
    Vector,
    add,
    apply,
    cross,
    dot,
    multiply,
    subtract,
)
from ..space.spatial import times
from .dependence import loop_links
from .kinematics import Posture, link_postures, place_of, turning
from .state import State


@dataclass(frozen=True)
class Swing:
    """Of a link: w, and of α and the acceleration a of its origin what is free of u', in the carrier's axes."""

    w: Vector
    alpha: Vector
    a: Vector

    def carried(self, r: Vector) -> Vector:
        """Acceleration of the point at ``r`` from the origin."""
        return add(self.a, apply(turning(self.w, self.alpha), r))


@dataclass(frozen=True)
class End:
    """One side of a closure: its link, its axes, its point from the link's origin and from the carrier's."""

    link: int
    axes: Matrix
    arm: Vector
    place: Vector


def carrier_of(model: Model, joint: Closure) -> int:
    """The link that carries the whole loop."""
    links = loop_links(model, joint)
    return model.links[min(links)].parent if links else place_of(model, joint.parent)[0]


def ends(model: Model, state: State, joint: Closure) -> tuple[End, End]:
    """The parent's side and the child's, in the axes of :func:`carrier_of`."""
    carrier = carrier_of(model, joint)
    found = []
    for body, axes, at in (
        (joint.parent, joint.parent_axes, joint.at),
        (joint.child, joint.child_axes, joint.to),
    ):
        link, origin = place_of(model, body)
        side = _side(model, state, link, carrier)
        point = state.vector(tuple(a + b for a, b in zip(origin, body.point(*at).components, strict=True)))
        arm = apply(side.rotation, point)
        found.append(End(link, multiply(side.rotation, state.matrix(axes)), arm, add(side.position, arm)))
    return found[0], found[1]


def _side(model: Model, state: State, link: int, carrier: int) -> Posture:
    """Pose of a link in the axes of one that carries it."""
    if carrier == GROUND:
        return Posture(IDENTITY, ZERO) if link == GROUND else link_postures(model, state)[link]
    known = state.cache.setdefault(("sides", carrier), {carrier: Posture(IDENTITY, ZERO)})
    if link not in known:
        P = _side(model, state, model.links[link].parent, carrier)
        R, p, _ = state.joint(link)
        known[link] = Posture(multiply(P.rotation, R), add(P.position, apply(P.rotation, p)))
    return known[link]


def _swing(model: Model, state: State, link: int, carrier: int) -> Swing:
    known = state.cache.setdefault(("swings", carrier), {carrier: Swing(ZERO, ZERO, ZERO)})
    if link not in known:
        one = model.links[link]
        P = _swing(model, state, one.parent, carrier)
        before, after = (_side(model, state, i, carrier) for i in (one.parent, link))
        wJ, vJ = (apply(after.rotation, x) for x in state.joint(link)[2])
        a = add(P.carried(apply(before.rotation, state.joint(link)[1])), cross(add(add(P.w, P.w), wJ), vJ))
        alpha = add(P.alpha, cross(P.w, wJ))
        if one.one_dof:
            turn, slide = times(state.second_rate(one, None), state.subspace(link))
            alpha, a = add(alpha, apply(after.rotation, turn)), add(a, apply(after.rotation, slide))
        known[link] = Swing(add(P.w, wJ), alpha, a)
    return known[link]


def bias_of(model: Model, state: State, joint: Closure, ground: Matrix) -> list[Any]:
    """γ of a closure in ground axes, ``ground`` from those of the carrier:

    e·(a_C - a_P),    and of A·B with A fixed in the parent and B in the child  A·([α]× + [w]×²) B  of their relative
    motion, w = w_C - w_P,  α = α_C - α_P - w_P × w_C.
    """
    carrier = carrier_of(model, joint)
    parent, child = ends(model, state, joint)
    P, C = (_swing(model, state, end.link, carrier) for end in (parent, child))
    d = apply(ground, subtract(C.carried(child.arm), P.carried(parent.arm)))
    B_CP = turning(subtract(C.w, P.w), subtract(subtract(C.alpha, P.alpha), cross(P.w, C.w)))
    result = [dot(state.vector(e), d) for _, e in joint.along]
    for _, a, b in joint.square:
        A, B = apply(parent.axes, state.vector(a)), apply(child.axes, state.vector(b))
        result.append(dot(A, apply(B_CP, B)))
    return result
