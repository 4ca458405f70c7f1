"""Gap, approach and slip of one pair of a family at the states of a motion, by its program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...dynamics.kinematics import place_of
from ...dynamics.state import float_state
from ...model.family import Family, touch_in_patch
from ...model.model import GROUND
from ...native import loop
from ..kernels.kernels import Kernels
from ..ode.dense_output import Array, observe
from .family_record import POSE, Families
from .memory import fill_members, link_poses
from .meshes import most_points
from .narrow_phase import P, Q, T
from .pair_programs import numbers_of, pair_program


def poses_at(kernels: Kernels, values: Mapping[str, float], times: Array, states: Array) -> Array:
    """Return the poses of all links at states."""
    program, name = link_poses(kernels)
    constants = program.constants(kernels.parameters(values))
    return observe(program.address(name), program.outputs(name), times, states, constants)


def pair_quantities(
    kernels: Kernels,
    values: Mapping[str, float],
    family: Family,
    pair: tuple[int, int],
    times: Array,
    poses: Array,
) -> tuple[Array, Array, Array, Array]:
    """Return gap and approach (n,), inf and nan beside the ends of a side, the slip along both tangents (n, 2), and the
    relative angular velocity about the axes of rolling and about the normal (n, 3), at poses of the links.
    """
    model = kernels.model
    if touch_in_patch(*(family.members[k].shape for k in pair)):
        return patch_quantities(kernels, values, model.families.index(family), pair, times, poses)
    state = float_state(model, values=values)
    given: list[Any] = []
    own, sizes = [], []
    for k in pair:
        member = family.members[k]
        link, origin = place_of(model, member.shape.body)
        at_rest = np.tile(np.eye(3).reshape(-1).tolist() + [0.0] * 9, (len(times), 1))
        own.append(at_rest if link == GROUND else poses[:, POSE * link : POSE * (link + 1)])
        sizes += [float(state(x)) for x in numbers_of(member.shape, origin)]
    given = [own[0][:, :12], own[1][:, :12], np.tile(sizes, (len(times), 1))]
    law = pair_program(family.members[pair[0]].shape, family.members[pair[1]].shape, family.planar)
    outputs = law.compiled["touch"].outputs
    y = np.ascontiguousarray(np.concatenate(given, axis=1))
    touch = observe(law.address, outputs, times, y, np.zeros(1))
    n, tangents = touch[:, 1:4], touch[:, T : T + 6].reshape(-1, 2, 3)
    if family.law.along is not None:
        tangents = directed_tangents(n, own[1], [float(state(x)) for x in family.law.along])
    elif not law.defined:
        tangents = upright_tangents(n, [float(x) for x in family.upright])
    moved = _velocity(own[0], touch[:, P : P + 3]) - _velocity(own[1], touch[:, Q : Q + 3])
    beside = (touch[:, 16 : 16 + law.reaches] < 0).any(axis=1)
    approach = -np.einsum("kj,kj->k", n, moved)
    slip = np.einsum("kij,kj->ki", tangents, moved)
    if family.planar is not None:
        tangents = np.broadcast_to([[float(x) for x in family.planar]] * 2, tangents.shape)
    turning = _turning(own[0], own[1], tangents, n)
    return np.where(beside, np.inf, touch[:, 0]), np.where(beside, np.nan, approach), slip, turning


def patch_quantities(
    kernels: Kernels,
    values: Mapping[str, float],
    number: int,
    pair: tuple[int, int],
    times: Array,
    poses: Array,
) -> tuple[Array, Array, Array, Array]:
    """Return the gap (n,) of two members that touch in a patch; where it is least approach (n,), slip (n, 2) and the
    relative angular velocity (n, 3).
    """
    model = kernels.model
    shapes = [member.shape for one in model.families for member in one.members]
    points = max(most_points(shape) for shape in shapes)
    of = Families.made(members=len(shapes), pairs=1, points=points)
    of.pairs.most, of.patch.most = 1, points
    fill_members(of, model, values)
    first, second = (k + sum(len(one.members) for one in model.families[:number]) for k in pair)
    ground = np.zeros(POSE)
    ground[[0, 4, 8]] = 1
    of.links.poses = np.concatenate([ground, poses[0]])
    measure = loop.code("motion.families.patches", "measure")
    gap, approach = np.empty(len(times)), np.empty(len(times))
    slip, turning = np.empty((len(times), 2)), np.empty((len(times), 3))
    up, along = [float(x) for x in model.families[number].upright], model.families[number].law.along
    if along is not None:
        along = [float(float_state(model, values=values)(x)) for x in along]
    for k, row in enumerate(poses):
        of.links.poses[POSE:] = row
        gap[k] = measure(of, first, second, np.inf)
        point = of.patch.points[: of.patch.count]
        point = point[point[:, 6].argmin()]
        own = [
            of.links.poses[POSE * link : POSE * (link + 1)][None] for link in of.members.link[[first, second]]
        ]
        tangents = upright_tangents(point[None, 3:6], up)[0]
        if along is not None:
            tangents = directed_tangents(point[None, 3:6], own[1], along)[0]
        moved = _velocity(own[0], point[None, :3]) - _velocity(own[1], point[None, :3])
        approach[k], slip[k] = -point[3:6] @ moved[0], tangents @ moved[0]
        turning[k] = _turning(own[0], own[1], tangents[None], point[None, 3:6])[0]
    return gap, approach, slip, turning


def _turning(one: Array, other: Array, tangents: Array, n: Array) -> Array:
    """Return the angular velocity of one pose less that of another one, along tangents and normals."""
    w = [np.einsum("kij,kj->ki", pose[:, :9].reshape(-1, 3, 3), pose[:, 12:15]) for pose in (one, other)]
    axes = np.concatenate([tangents, n[:, None]], axis=1)
    return np.einsum("kij,kj->ki", axes, w[0] - w[1])


def _velocity(pose: Array, point: Array) -> Array:
    """Return the velocity of the point of a link that is at a place."""
    R = pose[:, :9].reshape(-1, 3, 3)
    w, v = (np.einsum("kij,kj->ki", R, pose[:, k : k + 3]) for k in (12, 15))
    return np.asarray(v + np.cross(w, point - pose[:, 9:12]))


def directed_tangents(n: Array, pose: Array, along: Sequence[float]) -> Array:
    """Return the tangents of `narrow_phase.direct` for normals n and poses of the surface, shape (k, 2, 3)."""
    a = pose[:, :9].reshape(-1, 3, 3) @ np.array(along)
    level = a - np.einsum("ki,ki->k", a, n)[:, None] * n
    first = level / np.linalg.norm(level, axis=1)[:, None]
    return np.stack([first, np.cross(n, first)], axis=1)


def upright_tangents(n: Array, up: list[float]) -> Array:
    """Return the tangents of `narrow_phase.turn` for normals n, shape (k, 2, 3)."""
    k = int(np.flatnonzero(up)[0])
    a, b = (k + 1) % 3, (k + 2) % 3
    x, y, z = n[:, a], n[:, b], n[:, k]
    s = np.where(z >= 0, 1, -1)
    share = 1 / (1 + s * z)
    result = np.empty((len(n), 2, 3))
    result[:, 0, a], result[:, 0, b], result[:, 0, k] = 1 - x * x * share, -x * y * share, -s * x
    result[:, 1, a], result[:, 1, b], result[:, 1, k] = -s * (x * y * share), s * (1 - y * y * share), -y
    return result
