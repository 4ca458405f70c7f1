"""Free motions of a joint, and the wrench that it can transmit.

The reaction of an ideal joint does no work in any of its free motions. It is the part of the wrench (n, f) on the
child, about the joint's point, that is at right angles to the free turns (for n) and the free slides (for f):

    n_R = n - P n,        f_R = f - P f,        P onto the span of the free axes.

A load along one free motion acts on the child with the wrench that has power in that motion only.
A displacement that shares its coordinate with another one, or is a function of time, is not free: the joint
transmits the force that enforces this.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import sympy

from ...describe.joints.moving import Moving
from ...model.model import JointPlace, Model
from ...scalar.algebra import ZERO, Scalar, Vector, add, apply_transpose, cross, divide, dot, scale, subtract
from ...space.spatial import ZERO6, Spatial, plus, times
from ..state import State
from .motions import Twist, carried, twists, wrenches


@dataclass(frozen=True)
class Axis(Moving):
    """One motion of a joint: its link, kind, axis in the axes of the joint's last link, and pitch."""

    link: int
    kind: str  # hinge, slider, screw
    direction: Vector
    pitch: Scalar
    free: bool


def free_displacements(model: Model) -> tuple[tuple[int, int], ...]:
    """Return (link, speed) of the displacements that can change alone, each with a speed that changes it.

    A speed that occurs in only one displacement frees it; without that displacement, other speeds may occur in
    only one.
    """
    rows = {i: dict(link.partials) for i, link in enumerate(model.links) if link.partials}
    links_with: dict[int, set[int]] = {}
    for i, row in rows.items():
        for j in row:
            links_with.setdefault(j, set()).add(i)
    ready = [j for j, links in links_with.items() if len(links) == 1]
    result = []
    while ready:
        j = ready.pop()
        if len(links_with[j]) != 1:
            continue
        (i,) = links_with[j]
        if isinstance(rows[i][j], sympy.Basic):
            continue  # the partial derivative may vanish somewhere
        result.append((i, j))
        for k in rows[i]:
            links_with[k].discard(i)
            if len(links_with[k]) == 1:
                ready.append(k)
    return tuple(result)


def joint_axes(model: Model, state: State, joint: JointPlace) -> list[Axis]:
    """Return the 1-dof motions of a joint, first to last, in the axes of its last link."""
    if "free" not in state.cache:
        state.cache["free"] = {i for i, _ in free_displacements(model)}
    axes: list[Axis] = []
    for i in joint.links:
        link = model.links[i]
        R, _, _ = state.joint(i)
        axes = [Axis(a.link, a.kind, apply_transpose(R, a.direction), a.pitch, a.free) for a in axes]
        if link.one_dof:
            free = i in state.cache["free"]
            axes.append(Axis(i, link.kind, state.vector(link.axis), state(link.pitch), free))
    return axes


def transmissible(model: Model, state: State, joint: JointPlace, wrench: Spatial) -> Spatial:
    """Return the part of a wrench on the child, about the joint's point in the last link's axes, that it can carry."""
    if joint.pair.anchored:
        return carried(free_motions(model, state, joint), wrench)
    own = next((model.links[i] for i in joint.links if model.links[i].own), None)
    return carried_part(own, [a for a in joint_axes(model, state, joint) if a.free], wrench)


def carried_part(own: Moving | None, free: list[Axis], wrench: Spatial) -> Spatial:
    """Return the part of a wrench that a joint with these free axes carries, or one with speeds of its ``own``."""
    n, f = wrench
    slides = [axis.direction for axis in free if axis.slides_only]
    if own is not None:
        return (ZERO, ZERO) if own.flies else (ZERO, _across(f, slides))
    turns = [axis.direction for axis in free if axis.turns_only]
    for axis in free:
        if axis.advances:
            # the thread carries the axial force f with the moment -h f about the axis
            power = dot(axis.direction, n) + axis.pitch * dot(axis.direction, f)
            n = subtract(n, scale(power, axis.direction))
    return (_across(n, turns), _across(f, slides))


def free_motions(model: Model, state: State, joint: JointPlace) -> list[Twist]:
    """Return the motions that a chain or a path can make alone."""
    if joint.pair.path:
        return twists(model, state, joint)
    free = {axis.link for axis in joint_axes(model, state, joint) if axis.free}
    free |= {i for i in joint.links if model.links[i].u >= 0}
    return [t for t in twists(model, state, joint) if t.key[1] in free]


def on_path(model: Model, state: State, joint: JointPlace, forces: Mapping[int, Scalar]) -> Spatial:
    """Return the wrench on the child of generalized forces, by speed, on the coordinates of a path."""
    result = ZERO6
    motions = twists(model, state, joint) if joint.pair.path and forces else []
    for t, wrench in zip(motions, wrenches(motions), strict=True):
        if t.key[1] in forces:
            result = plus(result, times(forces[t.key[1]], wrench))
    return result


def on_ball(model: Model, state: State, joint: JointPlace, link: int, forces: Sequence[Scalar]) -> Spatial:
    """Return the wrench on the child, about the joint's point in the last link's axes, of forces on the speeds of its
    ball, or of a free joint.
    """
    if joint.pair.anchored:
        motions = free_motions(model, state, joint)
        own = [w for t, w in zip(motions, wrenches(motions), strict=True) if t.key[1] == link]
        return reduce(plus, map(times, forces, own))
    n, f = (forces[0], forces[1], forces[2]), (forces[3], forces[4], forces[5]) if len(forces) > 3 else ZERO
    for i in joint.links[joint.links.index(link) + 1 :]:
        R = state.joint(i)[0]
        n, f = apply_transpose(R, n), apply_transpose(R, f)
    return (n, f)


def _with(free: list[Twist], motions: list[Twist], link: int) -> list[Twist]:
    """The free motions and that of a link."""
    keys = {t.key for t in free}
    return [t for t in motions if t.key in keys or t.key == ("link", link)]


def _across(v: Vector, free: list[Vector]) -> Vector:
    """Return v less its projection on the span of the free directions, which are unit vectors."""
    if not free:
        return v
    if len(free) == 1:
        return subtract(v, scale(dot(free[0], v), free[0]))
    if len(free) == 2:
        normal = cross(free[0], free[1])
        return scale(divide(dot(normal, v), dot(normal, normal)), normal)
    return ZERO


def unit_load_wrench(model: Model, state: State, joint: JointPlace, link: int) -> Spatial:
    """Return the wrench on the child of a unit load along one displacement, about its point in the last link's axes.

    It has power one in that displacement and none in the other free displacements.
    """
    if joint.pair.anchored:
        motions = _with(free_motions(model, state, joint), twists(model, state, joint), link)
        return wrenches(motions)[[t.key for t in motions].index(("link", link))]
    axes = joint_axes(model, state, joint)
    (loaded,) = [axis for axis in axes if axis.link == link]
    if loaded.slides_only:
        slides = [axis.direction for axis in axes if axis.slides_only and axis.free and axis.link != link]
        return (ZERO, loaded.direction if loaded.free else _across(loaded.direction, slides))
    if loaded.advances:
        return (loaded.direction, ZERO)
    free_turns = [axis.direction for axis in axes if axis.turns_only and axis.free and axis.link != link]
    across = _across(loaded.direction, free_turns)
    if loaded.free and free_turns:
        across = scale(divide(1, dot(loaded.direction, across)), across)
    return (across, ZERO)


def loads_on_child(
    model: Model, state: State, joint: JointPlace, along: Mapping[int, Scalar], *, free: bool
) -> Spatial:
    """Return the wrench on the child of the loads ``along`` the joint's free displacements, or along the others."""
    n: Vector = ZERO
    f: Vector = ZERO
    for axis in joint_axes(model, state, joint) if along else ():
        if axis.free == free and axis.link in along:
            moment, force = unit_load_wrench(model, state, joint, axis.link)
            n = add(n, scale(along[axis.link], moment))
            f = add(f, scale(along[axis.link], force))
    return (n, f)
