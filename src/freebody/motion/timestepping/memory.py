"""The memory of a run in time steps, filled for a machine: sizes, kernels, laws of contacts, sparsity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

from ...dynamics.bearing_loads import LOADED
from ...dynamics.conditions.constraints import rows
from ...model.contact import friction_varies
from ...model.resistance import pressers
from ...native.loop import Function, made
from ..cones.islands import Islands
from ..families.memory import fill, set_constants, whole
from ..families.meshes import most_points
from ..kernels.kernels import Kernels
from ..kernels.program import Program
from ..moreau.stepping_record import Run
from ..ode.dense_output import Array
from ..start.initial import number
from .failure import laws_of_rebounds
from .mean_motion import center
from .stepped_kernels import FRICTION, Shape, laws_of_friction, mean_bearings, stepping

ISLAND_ROWS, ISLAND_SPEEDS, DENSE_ROWS = 900, 600, 300
"""Limits on an island that Newton's method gets, whose matrices are dense."""


_MODULES = ("motion.moreau.moreau", "motion.moreau.configuration")


@cache
def functions() -> dict[str, Function]:
    """Return the compiled functions: the steps, and what begins closed."""

    def named() -> dict[str, Any]:
        from ..moreau import configuration, moreau

        return vars(configuration) | vars(moreau)

    return made(_MODULES[0], _MODULES, ("march", "begin"), named, passes="hot").functions


def kernels_and_shape(kernels: Kernels) -> tuple[Program, Shape]:
    """Return `stepping`; the first time in a process, LLVM compiles the steps meanwhile."""
    if functions.cache_info().currsize:
        return stepping(kernels)
    with ThreadPoolExecutor(1, thread_name_prefix="freebody") as pool:  # it ends: the process may fork later
        pool.submit(functions)  # what it refuses is refused again where the steps are needed
        return stepping(kernels)


def memory_of(
    kernels: Kernels, values: Mapping[str, float], program: Program, shape: Shape, tangents: Sequence[int],
    pairs: int = 0,
) -> tuple[Run, Islands, Any]:  # fmt: skip
    """Return the memory of the loop for a machine, with room for some pairs of families, and what must live with it."""
    model = kernels.model
    n, n_q, held, E = model.n_u, model.n_q, len(shape.held), len(tangents)
    m = E + sum(tangents)
    loaded = sum(c.loaded for c in model.contacts)
    each = max((1 + sum(one.rows) for one in model.families), default=0)  # rows of a pair
    points = max((most_points(member.shape) for one in model.families for member in one.members), default=1)
    flights = [link for link in model.links if link.flies]
    run = Run.made(
        flights=len(flights), n=n, n_q=n_q, state=n_q + n, q_and_power=n_q + 1, most=max(m + each * pairs, 1), rows=m,
        squares=int(shape.squares[-1]), blocks=len(shape.blocks) - 1,
        constraints=held, holonomic=shape.holonomic, conditions=held * held,
        joints=loaded, of_bearings=LOADED * loaded, moving=n_q + 2 * n + m + len(rows(model)),
        members=max(sum(len(family.members) for family in model.families), 1), pairs=max(pairs, 1), points=points,
    )  # fmt: skip
    machine, contacts, problem = run.machine, run.contacts, run.problem
    machine.turning, machine.order = int(shape.turning), shape.order
    looped = kernels.looped()
    if looped is None:
        for name in ("system", "closing", "moving", "loading"):
            setattr(machine, name, program.address(name))
    else:
        machine.looped, machine.moving = 1, program.address("moving")
        machine.loading = looped[1].address("bias")
        machine.of_loading = looped[1].constants(kernels.parameters(values))
    if loaded:
        bearings, of_joints = run.bearings, mean_bearings(kernels)
        bearings.count, bearings.number[:] = loaded, shape.held
        bearings.loaded[:] = [k for k, c in enumerate(model.contacts) if c.loaded]
        bearings.forces = of_joints.address("bearings")
    run.families.pairs.most, run.families.patch.most = pairs, points
    owned = fill(run.families, kernels, values, shape.order, shape.blocks) if pairs else ()
    machine.n_quaternions, machine.quaternions = len(model.quaternions), np.array(model.quaternions, np.int64)
    for i in model.quaternions:
        machine.turned[i : i + 4] = 1
    for k, link in enumerate(flights):
        machine.attitude[k], machine.center[k] = link.quaternion, center(model, values, link)
        machine.spin[k] = np.flatnonzero(shape.order == link.u)[0]
        machine.block[k] = np.searchsorted(shape.blocks, machine.spin[k], side="right") - 1
    contacts.count, contacts.reaches, contacts.reach_of = E, len(shape.reach_of), shape.reach_of
    contacts.seen, contacts.behind = np.zeros((contacts.reaches, 2)), np.zeros(contacts.reaches, np.int64)
    contacts.tangents = np.array(tangents, dtype=np.int64)
    contacts.mu = np.array(
        [
            0.0 if friction_varies(model, c) else number(model, values, c.friction, "mu")
            for c in model.contacts
        ]
    )
    contacts.restitution = np.array(
        [number(model, values, c.restitution, "restitution") for c in model.contacts]
    )
    run.expansion.poisson = int("poisson" in laws_of_rebounds(model, values))  # and no other (`check_laws`)
    _fill_friction(run, kernels)
    contacts.adhesion = np.array([number(model, values, c.adhesion, "an adhesion") for c in model.contacts])
    contacts.pull = np.zeros(E)
    contacts.presser = np.array(pressers(model.contacts), dtype=np.int64)
    contacts.normal_row = np.full(E, -1, dtype=np.int64)
    contacts.kept, contacts.stuck = np.zeros((2, E), dtype=np.int64)
    contacts.last = np.zeros((m, 2))
    contacts.held = np.array([int(c.held) for c in model.contacts], dtype=np.int64)
    pieces, row_first, row_at = (
        np.concatenate([part, np.zeros(room * pairs, dtype=np.int64)])
        for part, room in ((shape.pieces, 2 * each), (shape.row_first, each), (shape.row_at, each))
    )
    for blocks in (problem.blocks, run.elimination.blocks):
        blocks.n, blocks.count = n, len(shape.blocks) - 1
        blocks.starts, blocks.squares = shape.blocks, shape.squares
        blocks.pieces, blocks.first, blocks.at = pieces, row_first, row_at
    run.elimination.contact_rows = m
    sizes = {
        "M": int(shape.squares[-1]), "f": n, "gap": E, "reach": len(shape.reach_of), "rates": m, "given": E,
        "pressed": n, "pressing": 1, "constraint_rates": held, "phi": shape.holonomic, 
        "W": int(shape.row_at[-1]) + 2 * each * pairs * int(np.diff(shape.blocks).max(initial=0)),
    }  # fmt: skip
    run.outputs = np.zeros(sum(sizes.values()))
    parts = dict(zip(sizes, np.split(run.outputs, np.cumsum(list(sizes.values()))[:-1]), strict=True))
    for name in ("M", "f", "rates", "given", "pressed", "pressing", "constraint_rates", "W"):
        setattr(run, name, parts[name])
    run.end.outputs = np.zeros(max(E + len(shape.reach_of) + shape.holonomic, 1))
    ends = np.split(run.end.outputs, [E, E + len(shape.reach_of)])
    for k, name in enumerate(("gap", "reach", "phi")):
        setattr(run.now, name, parts[name])
        setattr(run.end, name, ends[k])
    problem.W, problem.X = run.W, np.zeros(len(run.W))
    wide = int(np.diff(shape.row_first).max(initial=2))
    return run, _islands(int(blocks.count), max(m + each * pairs, 1), n, wide), owned


def _fill_friction(run: Run, kernels: Kernels) -> None:
    """Fill the memory of the laws of friction that vary."""
    friction, model = run.friction, kernels.model
    laws, names = laws_of_friction(kernels)
    friction.varies = len(names)
    friction.of_contacts, friction.of_families = (
        whole(laws.address(names[one.name]) if laws and one.name in names else 0 for one in kinds)
        for kinds in (model.contacts, model.families)
    )
    friction.given = np.zeros(model.n_q + model.n_u + 1)


def set_parameters(run: Run, kernels: Kernels, program: Program, parameters: Array) -> None:
    """Give all kernels the constants of values of the parameters."""
    run.machine.c = program.constants(parameters)
    if run.bearings.count > 0:
        run.bearings.c = mean_bearings(kernels).constants(parameters)
    if run.friction.varies > 0:
        run.friction.c = kernels.programs[FRICTION].constants(parameters)
    if kernels.model.families:
        set_constants(run.families, kernels, parameters)


def carry(old: Run, new: Run) -> None:
    """Give a memory with more room what the last step left: what stays closed, impulses, and the blow of this step."""
    for measure in ("residual", "depth", "sweeps", "reduced"):
        setattr(new, measure, getattr(old, measure))
    for name in ("kept", "stuck", "last", "guess"):
        getattr(new.contacts, name)[:] = getattr(old.contacts, name)
    new.blow[:], new.past[:] = old.blow, old.past
    pairs, before = new.families.pairs, old.families.pairs
    pairs.known = before.known
    for name in ("past", "stays", "stuck", "last", "impulses"):
        getattr(pairs, name)[: before.known] = getattr(before, name)[: before.known]


def _islands(blocks: int, most: int, n: int, wide: int) -> Islands:
    """Return the memory for islands of a problem of at most ``most`` rows, each of ``wide`` blocks, and n speeds."""
    rows, speeds = min(most, ISLAND_ROWS), min(n, ISLAND_SPEEDS)
    dense = min(rows, DENSE_ROWS)
    result = Islands.made(
        blocks=blocks, most=rows, n=speeds, squares=dense * dense, links=min(blocks, speeds) ** 2
    )
    result.dense.most = dense
    result.rows, result.speeds, result.own = rows, speeds, np.zeros(most, dtype=np.int64)
    result.at, result.touching = np.zeros(blocks + 1, np.int64), np.zeros(wide * most, np.int64)
    part = result.part
    part.W, part.X = np.zeros(rows * speeds), np.zeros(rows * speeds)
    part.blocks.starts = np.zeros(speeds + 1, dtype=np.int64)
    part.blocks.pieces = np.zeros(wide * rows, dtype=np.int64)
    part.blocks.first, part.blocks.at = np.zeros((2, rows + 1), dtype=np.int64)
    return result
