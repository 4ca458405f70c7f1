"""The memory of families of contacts, filled for a machine: motions of links, members, laws and programs of pairs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...describe.contacts.normal_law import DEPTH, RATE
from ...describe.shapes.shape import ContactShape
from ...dynamics.kinematics import link_postures, motions, place_of, velocities
from ...dynamics.state import State, float_state
from ...errors import SimulationError
from ...model import Model
from ...model.contact import friction_varies
from ...model.family import Family, touch_each_other, touch_in_patch, turned
from ...model.model import GROUND
from ...scalar.algebra import ZERO
from ..kernels.kernels import Kernels
from ..kernels.program import Program
from ..ode.dense_output import Array
from ..start.initial import number
from .family_record import BALL, DRUM, EDGE, OVAL, POSE, SOLID, SPOT, UNBOUNDED, Families
from .meshes import core_of, mesh_of
from .pair_programs import numbers_of, pair_program

BOUNDS = {"spot": SPOT, "ball": BALL, "oval": OVAL, "edge": EDGE, "solid": SOLID, "drum": DRUM}
"""How the bounds of the shapes that have some follow from their numbers."""
Whole = Any  # array of int64


def whole(numbers: Any) -> Whole:
    """Return integers as an array; one that is empty has room for one number."""
    result = np.array(list(numbers), dtype=np.int64)
    return result if len(result) else np.zeros(1, dtype=np.int64)


def link_poses(kernels: Kernels) -> tuple[Program, str]:
    """Return the program that gives the poses of all links, and the name of its function."""
    large = kernels.looped()
    if large is not None:
        return large[0], "link_poses"

    def functions(state: State) -> Mapping[str, Sequence[Any]]:
        model = kernels.model
        found = zip(link_postures(model, state), velocities(model, state), strict=True)
        return {
            "link_poses": [
                x
                for posture, (w, v) in found
                for x in (*(x for row in posture.rotation for x in row), *posture.position, *w, *v)
            ]
        }

    return kernels.program("link poses", functions), "link_poses"


def fill(
    of: Families, kernels: Kernels, values: Mapping[str, float], order: Sequence[int], blocks: Sequence[int]
) -> tuple[Any, ...]:
    """Fill the memory for a machine whose speeds stand in ``order``, in blocks; return what must live with it."""
    model = kernels.model
    _fill_links(of, kernels, values, order, blocks)
    fill_members(of, model, values)
    return _fill_laws(of, kernels, values)


def _fill_links(
    of: Families, kernels: Kernels, values: Mapping[str, float], order: Sequence[int], blocks: Sequence[int]
) -> None:
    model, links = kernels.model, of.links
    program, name = link_poses(kernels)
    links.code = program.address(name)
    links.poses = np.zeros(POSE * (1 + len(model.links)))
    links.poses[[0, 4, 8]] = 1
    place = np.argsort(order)
    block_of = np.searchsorted(blocks, place, side="right") - 1
    state = float_state(model, values=values)
    moves = [_constant_motions(model, state, i) for i in range(len(model.links))]
    chains: list[list[int]] = [[]]
    block = [-1]
    for i, link in enumerate(model.links):
        inward = [] if link.parent == GROUND else chains[link.parent + 1]
        chains.append([i + 1, *inward] if moves[i] else inward)
        of_link = [int(block_of[j]) for j, _, _ in moves[i]]
        block.append(of_link[0] if of_link else (-1 if link.parent == GROUND else block[link.parent + 1]))
    links.chain_at = whole(np.cumsum([0, *map(len, chains)]))
    links.chain = whole(k for chain in chains for k in chain)
    links.motion_at = whole(np.cumsum([0, 0, *map(len, moves)]))
    links.place = whole(place[j] for one in moves for j, _, _ in one)
    links.axes = np.array(
        [weight * x for one in moves for _, weight, S in one for v in S for x in v] or [0.0], dtype=float
    )
    links.block = whole(block)
    links.count = len(model.links)
    links.varying = int(any(len(chain) > 1 for chain in chains))
    links.masses = np.array(
        [
            float(x)
            for link in model.links
            for x in (
                state(link.mass), *state.vector(link.center), *(x for row in state.matrix(link.inertia) for x in row),
            )
        ]
    )  # fmt: skip


def _constant_motions(model: Model, state: State, i: int) -> Any:
    """Return the motions of a link by its speeds; refuse those that vary."""
    for _, partial in model.links[i].partials:
        varies = model.names.depends(partial, "coordinate", "speed", "time")
        if varies:
            joint = next(name for name, place in model.joints.items() if i in place.links)
            raise SimulationError(
                f"The displacement of joint '{joint}' is not linear in {', '.join(varies)}, and '{model.name}' has "
                "families of contacts, which need displacements linear in the coordinates. Give the joint a coordinate "
                "of its own and the relation by s.constrain, or describe the contacts one by one by s.contact."
            )
    return motions(model, state, i)


def fill_members(of: Families, model: Model, values: Mapping[str, float]) -> None:
    """Fill the members of all families."""
    members, state = of.members, float_state(model, values=values)
    bodies = {name: k for k, name in enumerate(("ground", *model.bodies))}
    link, kind, family, group, body, bound, sizes, mesh, radius = ([] for _ in range(9))
    kinds = kinds_of(model.families)
    for f, one in enumerate(model.families):
        for member in one.members:
            shape = member.shape
            at, origin = place_of(model, shape.body)
            found = [float(state(x)) for x in (core_of(shape, origin) or numbers_of(shape, origin))]
            mesh.append(mesh_of(shape, found))
            radius.append(float(state(getattr(shape, "radius", 0))))
            link.append(at + 1 if at != GROUND else 0)
            kind.append(kinds.index(member.kind))
            family.append(f)
            group.append(member.group)
            body.append(f * len(bodies) + bodies[shape.body.name])
            bound.append(_bound(one, shape))
            sizes.append(found)
    n = len(link)
    members.count = n
    for name, numbers in (
        ("link", link), ("kind", kind), ("family", family), ("group", group), ("body", body), ("bound", bound),
        ("sizes_at", np.cumsum([0, *map(len, sizes)])),
        ("mesh_at", np.cumsum([0, *map(len, mesh)])), ("mesh", [x for one in mesh for x in one]),
        ("order", [k for k in range(n) if bound[k] != UNBOUNDED]),
        ("wide", [k for k in range(n) if bound[k] == UNBOUNDED]),
    ):  # fmt: skip
        setattr(members, name, whole(numbers))
    members.sizes = np.array([x for one in sizes for x in one] + [0.0])
    members.radius = np.array([*radius, 0.0])
    corners, faces = (max((one[k] for one in mesh), default=1) for k in range(2))
    for core in (of.one, of.other):
        core.corners, core.normals = np.zeros(3 * max(corners, 1)), np.zeros(3 * max(faces, 1))
    normals_at = np.cumsum([0, *(3 * one[1] for one in mesh)])
    members.corners, members.normals = np.zeros(len(members.sizes)), np.zeros(normals_at[-1] + 1)
    members.normals_at = whole(normals_at)
    patch, room = of.patch, 2 * (corners + 2)
    patch.polygon, patch.rest, patch.heights = np.zeros(3 * room), np.zeros(3 * room), np.zeros(room)
    patch.tags, patch.rest_tags = (np.zeros(2 * room, dtype=np.int64) for _ in range(2))
    patch.features = np.zeros(4 * max(patch.most, 1), dtype=np.int64)
    members.bounded = sum(x != UNBOUNDED for x in bound)
    members.unbounded = n - members.bounded
    near: list[list[int]] = [[] for _ in range(len(bodies) * len(model.families))]
    for f, one in enumerate(model.families):
        for a, b in one.joined:
            near[f * len(bodies) + bodies[a]].append(f * len(bodies) + bodies[b])
    members.joined_at, members.joined = (
        whole(np.cumsum([0, *map(len, near)])),
        whole(x for one in near for x in one),
    )


def _bound(family: Family, shape: ContactShape) -> int:
    """Return how the bounds of a member follow from its numbers.

    In a plane and beside round shapes an edge is a wall without end.
    """
    others = [family.members[members[0]].shape for members in family.by_kind.values()]
    walls = family.planar or any(o.round and type(o) is not type(shape) for o in others)
    if shape.inside or (shape.extruded and walls):
        return UNBOUNDED
    return BOUNDS.get(shape.bound, UNBOUNDED)


def kinds_of(families: Sequence[Family]) -> list[str]:
    """Return the kinds of all members, each once."""
    return list(dict.fromkeys(member.kind for family in families for member in family.members))


def _fill_laws(of: Families, kernels: Kernels, values: Mapping[str, float]) -> tuple[Any, ...]:
    model = kernels.model
    laws, kinds = of.laws, kinds_of(model.families)
    count, n = len(model.families), len(kinds)
    tables = {
        name: np.zeros((count, n, n), dtype=np.int64)
        for name in ("program", "turned", "reaches", "defined", "patched")
    }
    programs = []
    for f, family in enumerate(model.families):
        for i, first in enumerate(kinds):
            for j, second in enumerate(kinds):
                if not {first, second} <= set(family.by_kind):
                    continue
                a, b = (family.members[family.by_kind[kind][0]].shape for kind in (first, second))
                if not touch_each_other(a, b):
                    continue
                swapped = turned(a, b)  # as in `Family.ordered`
                if touch_in_patch(a, b):
                    for name in ("program", "patched"):
                        tables[name][f, i, j] = 1
                    tables["turned"][f, i, j] = swapped
                    continue
                program = pair_program(*((b, a) if swapped else (a, b)), family.planar)
                programs.append(program)
                for name, value in (
                    ("program", program.address), ("turned", swapped), ("reaches", program.reaches),
                    ("defined", program.defined),
                ):  # fmt: skip
                    tables[name][f, i, j] = value
    laws.kinds = n
    for name, table in tables.items():
        setattr(laws, name, table.reshape(-1) if table.size else whole(()))
    rows = [family.rows for family in model.families]
    laws.tangents, laws.rolls, laws.spins = (whole(row[k] for row in rows) for k in range(3))
    laws.rows = whole(1 + sum(row) for row in rows)
    laws.grouped = whole(int(family.grouped) for family in model.families)
    laws.up = np.array([float(x) for family in model.families for x in family.upright] or [0.0])
    laws.axis = np.array([float(x) for family in model.families for x in family.planar or ZERO] or [0.0])
    for name, field in (
        ("restitution", "restitution"), ("adhesion", "adhesion"), ("rolling", "rolling"),
        ("spinning", "spinning"),
    ):  # fmt: skip
        numbers = [
            number(model, values, getattr(one.law, field), f"the {field} of {one!r}")
            for one in model.families
        ]
        setattr(laws, name, np.array(numbers or [0.0]))
    laws.mu = np.array([_friction(model, values, one) for one in model.families] or [0.0])
    laws.directed = whole(int(one.law.along is not None) for one in model.families)
    state = float_state(model, values=values)
    laws.along = np.array([float(state(x)) for one in model.families for x in one.law.along or ZERO] or [0.0])
    laws.ratio = np.array([_ratio(model, values, one) for one in model.families] or [1.0])
    normals = [None if one.law.normal_force is None else normal_law(kernels, one) for one in model.families]
    laws.compliant = sum(one is not None for one in normals)
    laws.normal = whole(0 if one is None else one.address("normal") for one in normals)
    laws.given = np.zeros(model.n_q + model.n_u + 2)
    return tuple(programs)


def set_constants(of: Families, kernels: Kernels, parameters: Array) -> None:
    """Give the kernels of poses and of normal forces the constants of values of the parameters."""
    program, _ = link_poses(kernels)
    of.links.c = program.constants(parameters)
    families = kernels.model.families
    constants = [
        np.zeros(0) if one.law.normal_force is None else normal_law(kernels, one).constants(parameters)
        for one in families
    ]
    of.laws.normal_at = whole(np.cumsum([0, *map(len, constants)]))
    of.laws.normal_c = np.concatenate([*constants, [0.0]])


def _friction(model: Model, values: Mapping[str, float], family: Family) -> float:
    """Return the coefficient of friction of a family; 0 if it varies, so that the steps find it."""
    if any(friction_varies(model, contact) for contact in family.representatives[:1]):
        return 0.0
    return number(model, values, family.law.friction, f"the friction of {family!r}")


def _ratio(model: Model, values: Mapping[str, float], family: Family) -> float:
    """Return μ_2/μ_1 of a family with two coefficients of friction, else 1."""
    law = family.law
    if law.friction_across is None:
        return 1.0
    mu, across = (
        number(model, values, x, f"the friction of {family!r}") for x in (law.friction, law.friction_across)
    )
    return across / mu


def normal_law(kernels: Kernels, family: Family) -> Program:
    """Return the function ``normal``: the normal force of a pair, of the state, its depth and the rate of that."""

    def functions(state: State, given: Sequence[Any]) -> Mapping[str, Sequence[Any]]:
        return {"normal": [state.with_values(family.law.normal_force, {DEPTH: given[0], RATE: given[1]})]}

    return kernels.program(f"normal force of {family.name}", functions, 2)


def label_of(model: Model, first: int, second: int) -> str:
    """Return the name of the contact of two members, by their numbers among those of all families."""
    for family in model.families:
        if first < len(family.members):
            return family.label(first, second)
        first, second = first - len(family.members), second - len(family.members)
    raise IndexError(f"Expected the number of a member, got {first} beyond the last one.")
