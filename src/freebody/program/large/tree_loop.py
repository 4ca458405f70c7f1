"""Large trees: one loop over the links in place of straight-line code, so that nothing grows but tables.

    front     joint variables and forces along them: what the model's expressions say of t, q, u     (straight)
    outward   poses, velocities, inertias, link by link                                              (loop)
    loads     wrenches of the forces, springs and couples at points                                  (straight)
    inward    articulated inertias, tips first                                                       (loop)
    final     accelerations                                                                          (loop)
    finish    u' from the second derivatives of the displacements; energies; power                   (straight)

From accelerations to forces (:mod:`freebody.dynamics.newton_euler`) the loops are outward, carried (accelerations) and
transmitted (wrenches, tips first); the mass matrix is found so column by column, at rest and without loads.

The wrench of a joint follows from what either way leaves in the record of its last link, F = I^A A + p^A (Featherstone
2008, eq. 7.21). Straight code projects it where several links make a joint, or loads act along what is not free.

The straight parts hold what the user wrote, and are empty where a displacement is a coordinate. The loop steps are
`link_step`. All numbers of one call live in one array S: inputs of the straight parts, their
outputs, and the records of the links; tables of places in S say what goes where. A number is a double, or eight of
states side by side, or of these with its derivative along a direction: the loops are the same.

The file is longer than others: it is the one place that knows where everything stands in S.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
import sympy

from ...dynamics import traced_state
from ...dynamics.coordinates import (
    accelerations_of_coordinates,
    forces_on_coordinates,
    forces_on_displacements,
)
from ...dynamics.joint_freedom import free_displacements, loads_on_child, transmissible
from ...dynamics.kinematics import Posture, jacobian, rotation
from ...dynamics.loading import Loading, load_power, loading, spring_energy
from ...dynamics.state import float_state
from ...model.model import Model
from ...native import codegen
from ...native.registers import WIDTH
from ...scalar.algebra import ZERO, apply, dot, negate
from ...scalar.derivative import beside
from ...scalar.trace import INPUT, Tape, Traced
from ...space.spatial import minus
from ..code.emit import Form
from ..kernels import Kernel, KernelSet, compile_tape
from . import link_step
from .link_loop import Driver
from .link_places import accelerations, sums
from .link_step import compiled_step, constants_of, kind_of

BODIES = 200
"""From this number of bodies on, a tree is looped over, whatever is asked of it."""
SOONER = {
    "derivatives": 10, "forward_dynamics": 40, "forced_dynamics": 40, "inverse_dynamics": 100, "bias": 100,
    "mass_matrix": 100, "reactions": 100, "reactions_at": 100,
}  # fmt: skip
"""From this number on for these uses: from there on loops are as fast as straight code, or nearly, and straight code
takes seconds to compile. Measured in `docs/compiled.md`."""

OF_Q = ("potential_energy", "postures", "jacobian")
"""Kernels that are given q only."""


class Directions(NamedTuple):
    """Of which kernel derivatives are wanted, and by what: ``columns`` numbers of its state from ``first`` on; or, with
    ``columns`` 0, along the one direction that stands behind the state, from ``first`` on."""

    kernel: str
    first: int
    columns: int = 0


GIVEN = ("inverse", "mass", "reactions_at")
"""Modes in which accelerations are given."""


def applies(model: Model) -> bool:
    """Whether a model can be looped over: a tree whose displacements determine the coordinates one after another,
    and whose dimensions and masses are functions of the parameters alone."""
    if model.constraints or model.order is None:
        return False
    symbols = {parameter.symbol for parameter in model.parameters}

    def constant(x: Any) -> bool:
        return not isinstance(x, sympy.Basic) or (
            x.free_symbols <= symbols and not x.atoms(sympy.core.function.AppliedUndef)
        )

    return all(constant(x) for i in range(len(model.links)) for x in constants_of(model, i))


def is_large(model: Model, use: str = "") -> bool:
    """Whether the model is looped over, for any use or for one of `SOONER`."""
    return len(model.bodies) >= min(BODIES, SOONER.get(use, BODIES)) and applies(model)


class LoopedSet:
    """Kernels of one large model, as a :class:`KernelSet` gives them: one vector c for all.

    ``rates`` (q', u' and, where power goes in or out, that), ``accelerations``, ``energy`` (kinetic, potential), each
    of the two, and ``poses`` (position, rotation by rows of each body) as functions of t and y = (q, u), where
    ``potential_energy`` and ``postures`` (rotation, position) are given q only.

    ``velocities`` (angular, of the origin) of each body and ``momentum`` (linear, angular) are among them.

    Other modes: "forced", where generalized forces besides the model's stand after u in y, has ``accelerations`` alone;
    "inverse", where u' stand there, has ``inverse_dynamics``, and ``bias`` of (q, u); "mass" has ``mass_matrix`` of q;
    "reactions" and "reactions_at", with u' after u, have ``reactions`` (force, moment of each joint); "jacobian" has
    that of ``point``.

    With ``directions`` there is one kernel: ``f``, the derivative of another by numbers of its state, or ``tangent``.
    """

    def __init__(
        self, model: Model, mode: str = "motion", point: Any = None, lanes: int = 1, shared: bool = True,
        directions: Directions | None = None,
    ) -> None:  # fmt: skip
        self.model = model
        self.mode, self.point = mode, point
        self.directions = directions
        if directions:
            lanes = WIDTH if directions.columns else 1
        self._wide: dict[bool, dict[str, Kernel]] = {}
        if mode == "mass":
            lanes = WIDTH
        self.lanes = lanes
        self.shared = shared
        self.back = mode in GIVEN  # from accelerations to forces
        self.loops = (
            ("outward", "transmitted", "started" if mode == "mass" else "carried")
            if self.back
            else ("outward", "inward", "final")
        )
        alone = {i for i, _ in free_displacements(model)}
        self._kinds = [kind_of(link, i in alone) for i, link in enumerate(model.links)]
        if self.back:  # accelerations along displacements are given
            self._kinds = [replace(kind, driven=True) if kind.joint_of_one else kind for kind in self._kinds]
        self._steps = {
            kind: compiled_step(kind, lanes, shared, directions is not None)
            for kind in dict.fromkeys(self._kinds)
        }
        widths = [self._steps[kind].width for kind in self._kinds]
        parts = Parts(model, self._kinds, widths, mode, point, Form(lanes, shared), directions is not None)
        self.works = parts.works
        self.straight: KernelSet = parts.compiled
        self._offsets: list[int] = []
        offset = 0
        for kind in self._kinds:
            self._offsets.append(offset)
            offset += self._steps[kind].compiled.hoisted
        self.straight_offset = offset
        self.hoisted = offset + self.straight.hoisted
        self.from_disk = self.straight.from_disk and all(
            step.compiled.from_disk for step in self._steps.values()
        )
        self._tables: list[np.ndarray] = []
        start = perf_counter()
        code = codegen.object_code(Driver(self, parts).text())
        library = codegen.Library(code)
        used = [self.straight, *(step.compiled for step in self._steps.values())]
        self.size = len(code) + sum(one.size for one in used)
        self.seconds = perf_counter() - start + sum(one.seconds for one in used)
        wide, of = "" if lanes == 1 else ".lanes", {name: len(x) for name, x in parts.outputs.items()}
        states = dict(parts.states)
        if mode == "mass":
            wide, of, states = "", {"mass_matrix": model.n_u**2}, {"mass_matrix": model.n_q}
        if directions:
            base, first, count = directions
            wide, of = "", {"f": of[base] * count} if count else {"tangent": of[base]}
            states = {"f": states[base], "tangent": 2 * first}
        library.needs = (self._tables, self._steps, self.straight)
        found = library.addresses([*(f"{name}{wide}" for name in of), *(f"{name}.batch" for name in of)])
        operations = self._operations()
        self.kernels = {
            name: Kernel(
                name, library, found[f"{name}{wide}"], found[f"{name}.batch"], states[name], self.hoisted,
                size, operations, found[f"{name}.lanes"] if wide else None,
            )
            for name, size in of.items()
        }  # fmt: skip

    def __getitem__(self, name: str) -> Kernel:
        return self.kernels[name]

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Counts of operations of one call, by kernel."""
        return {name: dict(kernel.operations) for name, kernel in self.kernels.items()} | {"parameters": {}}

    def _operations(self) -> dict[str, int]:
        total: Counter[str] = Counter()
        for name in ("front", "loads", "finish"):
            total.update(self.straight[name].operations)
        for kind, links in Counter(self._kinds).items():
            for name in self.loops:
                for code, count in self._steps[kind].compiled[name].operations.items():
                    total[code] += links * count
        columns = self.directions.columns or 1 if self.directions else 1
        return {code: columns * count for code, count in sorted(total.items())}

    def of_rows(self, name: str, shared: bool) -> Kernel:
        """A kernel with its form for batches: eight states at a time, of the same parameters or each of its own.

        Columns of a matrix stand side by side already.
        """
        if self.lanes > 1 or self.directions:
            return self.kernels[name]
        if shared not in self._wide:
            wide = LoopedSet(self.model, self.mode, self.point, WIDTH, shared)
            self._wide[shared] = {
                name: Kernel(
                    name, (one, eight), one.address, eight.batch_address, one.state, one.hoisted, one.outputs,
                    one.operations, eight.lanes_address,
                )
                for (name, one), eight in zip(self.kernels.items(), wide.kernels.values(), strict=True)
            }  # fmt: skip
        return self._wide[shared][name]

    def step(self, i: int) -> KernelSet:
        """The code of link i."""
        return self._steps[self._kinds[i]].compiled

    def offset(self, i: int) -> int:
        """Where the constants of link i stand in c."""
        return self._offsets[i]

    def table(self, values: Sequence[int]) -> int:
        """Address of a table that lives as long as this object."""
        self._tables.append(np.array(values, dtype=np.int64))
        return int(self._tables[-1].ctypes.data)

    def constants(self, parameters: Any) -> np.ndarray:
        """The vector c, shape (hoisted,), or one for each row of parameters."""
        p = np.ascontiguousarray(parameters, dtype=float)
        if p.ndim == 2:
            return np.stack([self.constants(row) for row in p])
        values = {one.symbol: float(x) for one, x in zip(self.model.parameters, p, strict=True)}
        state = float_state(self.model, values=values)
        c = np.empty(self.hoisted)
        for i, kind in enumerate(self._kinds):
            step, start = self._steps[kind].compiled, self._offsets[i]
            numbers = [float(state(x)) for x in constants_of(self.model, i)]
            c[start : start + step.hoisted] = step.constants(numbers)
        c[self.straight_offset :] = self.straight.constants(p)
        return c


class _Inputs(list[Any]):
    """Inputs of the straight parts that come from the records of links, made when they are asked for."""

    def __init__(self, make: Any) -> None:
        super().__init__()
        self.made: dict[int, Any] = {}
        self._make = make

    def __getitem__(self, i: Any) -> Any:
        if i not in self.made:
            self.made[i] = self._make(i)
        return self.made[i]


class Parts:
    """The straight parts of a model, and where everything stands in S.

    S = 0, t, y | fetched from the records | front | loads | finish | energy | of the loops | records | second records

    (the ground's first).
    """

    def __init__(
        self, model: Model, kinds: Sequence[link_step.Kind], widths: Sequence[int], mode: str, point: Any, form: Form,
        moved: bool,
    ) -> None:  # fmt: skip
        self.model = model
        self.mode = mode
        tape = Tape()
        state = traced_state(model, tape)
        zero, time = tape.input("0"), tape.input("time in S")
        besides = [tape.input(f"{mode} {k}") for k in range(model.n_u if mode in (*GIVEN, "forced") else 0)]
        self._inputs: list[Traced] = [zero, time, *state.q, *state.u, *besides]
        self.given = model.n_q + model.n_u + len(besides)
        self._places = {x.index: k for k, x in enumerate(self._inputs)} | {state.t.index: 1}
        fetched: list[tuple[int, int]] = []  # (link, place in its record), input after input

        def fetch(i: int, place: int, count: int) -> list[Traced]:
            new = [tape.input(f"link {i}, {place + k}") for k in range(count)]
            for k, x in enumerate(new):
                self._places[x.index] = len(self._inputs)
                self._inputs.append(x)
                fetched.append((i, place + k))
            return new

        def posture(i: int) -> Posture:
            x = fetch(i, link_step.PLACE, 12)
            return Posture((tuple(x[0:3]), tuple(x[3:6]), tuple(x[6:9])), tuple(x[9:12]))  # type: ignore[arg-type]

        def velocity(i: int) -> Any:
            x = fetch(i, link_step.V, 6)
            return (tuple(x[0:3]), tuple(x[3:6]))

        state.cache["postures"], state.cache["velocities"] = _Inputs(posture), _Inputs(velocity)
        # front
        still = mode in ("mass", "jacobian")
        loads = Loading() if still else loading(model, state)
        generalized = dict(loads.generalized)
        along: dict[int, Any] = {}
        udot = besides if mode in GIVEN else None
        if udot is None:
            for k, force in enumerate(besides):
                generalized[k] = generalized.get(k, 0) + force
            along = forces_on_displacements(model, state, generalized)
            for i, force in loads.along.items():
                along[i] = along.get(i, 0) + force
        joints: list[list[Any]] = []
        for i, link in enumerate(model.links):
            if link.one_dof:
                rate = state.rate(link)
                third = along.get(i, 0)
                if udot is not None or link.driven:
                    third = state.second_rate(link, udot)
                if mode == "mass":
                    rate, third = 0, 0
                    for j, partial in link.partials:
                        third = third + state(partial) * besides[j]
                joints.append([state(link.displacement), rate, third])
            elif link.u >= 0:
                n_q, n_u = (7, 6) if link.kind == "free" else (4, 3)
                if udot is None:
                    forces = [generalized.get(link.u + k, 0) for k in range(n_u)]
                else:
                    forces = udot[link.u : link.u + n_u]
                joints.append([*state.q[link.q : link.q + n_q], *state.u[link.u : link.u + n_u], *forces])
            else:
                joints.append([])
        gravity = ZERO if still else state.vector(model.gravity)
        energetic = mode == "motion"
        power = load_power(model, state) if energetic else 0
        spring = spring_energy(model, state) if energetic else 0
        self.placed = len(state.cache["postures"].made) > 0
        self.loads_end = len(self._inputs)
        # finish
        self.works = False
        if mode in ("reactions", "reactions_at"):
            finish = self._reactions(state, loads, fetch)
        elif mode == "jacobian":
            finish = [x for row in jacobian(model, state, point) for x in row]
        elif udot is None:
            finish = self._accelerations(state, kinds, loads, power, fetch)
        else:
            finish = self._forces(state, loads, fetch)
        # energy
        totals = [tape.input(f"sum {k}") for k in range(6)]  # of which momenta are six
        self.totals = len(self._inputs)
        for x in totals:
            self._places[x.index] = len(self._inputs)
            self._inputs.append(x)
        potential = spring - dot(gravity, (totals[1], totals[2], totals[3]))
        self.fetched = fetched

        functions: dict[str, list[Any]] = {
            "front": [x for one in joints for x in one] + list(negate(gravity)),
            "loads": [x for wrench in loads.wrenches.values() for vector in wrench for x in vector],
            "finish": finish,
            "energy": [totals[0], potential] if energetic else [],
        }
        computed: dict[str, list[Any]] = {}
        start = len(self._inputs)
        self.start: dict[str, int] = {}
        placed: dict[str, list[int]] = {}
        for name, outputs in functions.items():
            self.start[name] = start
            own_list: list[Any] = []
            placed[name] = [self._place(x, start, own_list) for x in outputs]
            computed[name] = own_list
            start += len(own_list)
        parents = [link.parent for link in model.links]
        everywhere = mode.startswith("reactions")
        self.sums = sums(parents, range(len(parents)) if everywhere else loads.wrenches, start, link_step.SUM)
        self.accelerations, start = accelerations(parents, everywhere or mode in GIVEN, self.sums.end)
        self.joint = start
        self.records = []
        start += link_step.ARRAYS["joint"]
        for width in widths:
            self.records.append(start)
            start += width
        self.base = start
        self.size = start + (len(model.links) + 1) * link_step.WIDTH
        self.empty = {name for name, outputs in computed.items() if not outputs}
        parameters = [state.values[parameter.symbol] for parameter in model.parameters]
        inputs = self._inputs
        if moved:
            computed, inputs = beside(tape, computed, inputs)
        self.compiled = compile_tape(
            tape, computed, state.t, inputs, parameters, form=form if form.lanes > 1 else None
        )
        # tables
        self.joints: list[list[int]] = []
        k = 0
        for one in joints:
            self.joints.append(placed["front"][k : k + len(one)])
            k += len(one)
        self.ground = placed["front"][k:]
        self.pressed = [
            (self.sums.of[i] + j, placed["loads"][6 * n + j])
            for n, i in enumerate(loads.wrenches)
            for j in range(6)
        ]
        self._place_outputs(state, placed)
        self.states = {name: model.n_q if name in OF_Q else self.given for name in self.outputs}
        self.states.update({"bias": model.n_q + model.n_u})

    def _place_outputs(self, state: Any, placed: Any) -> None:
        """Of each kernel: where its outputs stand in S."""
        model = self.model
        single = {"inverse": ("inverse_dynamics", "bias"), "mass": ("column",)}
        if self.mode not in ("motion", "forced"):
            names = single.get(self.mode, (self.mode.removesuffix("_at"),))
            self.outputs: dict[str, list[int]] = dict.fromkeys(names, placed["finish"])
            if self.mode == "reactions":
                self.outputs["multipliers"] = []  # a tree has none
            return
        *accelerations, work = placed["finish"]
        coordinate_rates = self._coordinate_rates(state)
        self.outputs = {
            "rates": [*coordinate_rates, *accelerations, *([work] if self.works else [])],
            "accelerations": accelerations,
            "energy": placed["energy"],
            "kinetic_energy": placed["energy"][:1],
            "potential_energy": placed["energy"][1:],
            "poses": [
                self.at(model.bodies[name].link, k)
                for name in model.bodies
                for k in (
                    *range(link_step.ORIGIN, link_step.ORIGIN + 3), *range(link_step.PLACE, link_step.PLACE + 9)
                )
            ],
            "postures": [
                self.at(model.bodies[name].link, k)
                for name in model.bodies
                for k in (
                    *range(link_step.PLACE, link_step.PLACE + 9), *range(link_step.ORIGIN, link_step.ORIGIN + 3)
                )
            ],
        }  # fmt: skip
        moved = [
            self.at(model.bodies[name].link, k)
            for name in model.bodies
            for k in range(link_step.MOVED, link_step.MOVED + 6)
        ]
        self.outputs |= {"velocities": moved, "momentum": list(range(self.totals, self.totals + 6))}
        if self.mode == "forced":
            self.outputs = {"accelerations": accelerations}

    def _accelerations(self, state: Any, kinds: Any, loads: Any, power: Any, fetch: Any) -> list[Any]:
        """u' and the power, from what the loops leave in the records."""
        model = self.model
        second, own, driven = {}, {}, {}
        for i, link in enumerate(model.links):
            kind = kinds[i]
            if link.driven:
                if link.drift != 0:
                    (driven[i],) = fetch(i, kind.force, 1)
            elif kind.freedom:
                rates = fetch(i, link_step.RATES, kind.freedom)
                if link.one_dof:
                    second[i] = rates[0]
                else:
                    own.update({link.u + k: rate for k, rate in enumerate(rates)})
        udot = accelerations_of_coordinates(model, state, second, own)
        for i, force in driven.items():
            power = power + (force - loads.along.get(i, 0)) * state(model.links[i].drift)
        self.works = not (isinstance(power, int) and power == 0)
        return [*udot, power]

    def _forces(self, state: Any, loads: Any, fetch: Any) -> list[Any]:
        """Generalized forces, from those along the joints in the records: see `newton_euler.inverse_dynamics`."""
        model = self.model
        tau: list[Any] = [0] * len(model.links)
        own: dict[int, Any] = {}
        for i, link in enumerate(model.links):
            if link.partials:
                (tau[i],) = fetch(i, link_step.ALONG, 1)
                tau[i] = tau[i] - loads.along.get(i, 0)
            elif link.u >= 0:
                count = 6 if link.kind == "free" else 3
                own.update({link.u + k: x for k, x in enumerate(fetch(i, link_step.ALONG, count))})
        total = forces_on_coordinates(model, state, tau)
        for j, force in own.items():
            total[j] = force
        for j, force in loads.generalized.items():
            total[j] = total[j] - force
        return list(total)

    def _reactions(self, state: Any, loads: Any, fetch: Any) -> list[Any]:
        """Force and moment of every joint: see `newton_euler.reactions`."""
        model = self.model
        result: list[Any] = []
        for joint in model.joints.values():
            i = joint.links[-1]
            if len(joint.links) == 1 and i not in loads.along:
                result += fetch(i, link_step.REACTION, 6)
                continue
            x = fetch(i, link_step.PRESSED, 6)
            held = loads_on_child(model, state, joint, loads.along, free=False)
            wrench = minus((tuple(x[0:3]), tuple(x[3:6])), held)
            moment, force = transmissible(model, state, joint, wrench)
            R = rotation(model, state, i)
            result += [*apply(R, force), *apply(R, moment)]
        return result

    def at(self, i: int, place: int) -> int:
        """Where a number of the records of link i stands; i = -1 is the ground, which has a second one only."""
        if place < link_step.SECOND:
            return self.records[i] + place
        return self.base + (i + 1) * link_step.WIDTH + place - link_step.SECOND

    def _place(self, x: Any, start: int, computed: list[Any]) -> int:
        """Where x is found in S; it is computed unless it stands there."""
        if type(x) is not Traced:
            if x == 0:
                return 0
        elif x.tape.op[x.index] == INPUT and x.index in self._places:
            return self._places[x.index]
        computed.append(x)
        return start + len(computed) - 1

    def _coordinate_rates(self, state: Any) -> list[int]:
        model = self.model
        speeds = {speed.name: state.u[i] for i, speed in enumerate(model.speeds)}
        result = [
            self._places[speeds[one.name + "'"].index] if one.kind == "scalar" else -1
            for one in model.coordinates
        ]
        for i, link in enumerate(model.links):
            if link.kind in ("ball", "free"):
                for k in range(7 if link.kind == "free" else 4):
                    result[link.q + k] = self.at(i, link_step.COORDINATE_RATES + k)
        return result


LOOPED = {
    "forward_dynamics": "accelerations", "forced_dynamics": "accelerations", "kinetic_energy": "kinetic_energy",
    "potential_energy": "potential_energy", "poses": "postures", "inverse_dynamics": "inverse_dynamics", "bias": "bias",
    "mass_matrix": "mass_matrix", "velocities": "velocities", "momentum": "momentum", "reactions": "reactions",
    "reactions_at": "reactions",
}  # fmt: skip
"""Products of a program that large models have in looped form, and their kernels."""

MODES = {
    "forced_dynamics": "forced", "inverse_dynamics": "inverse", "bias": "inverse", "mass_matrix": "mass",
    "reactions": "reactions", "reactions_at": "reactions_at",
}  # fmt: skip
"""Mode of the set that has them; the others are of "motion"."""


def looped_kernel(model: Model, key: Any, product: Any, kept: dict[Any, LoopedSet]) -> LoopedKernel | None:
    """The kernel of a product of a large model in looped form, if it has one; sets are ``kept`` for other products."""
    if product.point is not None:
        if not is_large(model):
            return None
        return LoopedKernel(LoopedSet(model, "jacobian", product.point), "jacobian")
    name, _, by = key.partition("_by_") if isinstance(key, str) else ("", "", "")
    if key == "derivatives":
        name, by = "forward_dynamics", "q u"
    if name not in LOOPED or not is_large(model, "derivatives" if by else name):
        return None
    mode, kernel = MODES.get(name, "motion"), LOOPED[name]
    if by == "":
        if mode not in kept:
            kept[mode] = LoopedSet(model, mode)
        return LoopedKernel(kept[mode], kernel)
    if by == "displacement" and not model.quaternions:
        by = "q"
    sizes = {x: model.n_q if x == "q" else model.n_u for x in product.inputs}
    if mode == "mass" or by not in (*sizes, "q u"):
        return None
    first = 0 if by == "q u" else sum([*sizes.values()][: [*sizes].index(by)])
    count = sum(sizes.values()) if by == "q u" else sizes[by]
    if count == 0:
        return None
    return LoopedKernel(LoopedSet(model, mode, directions=Directions(kernel, first, count)), "f")


class LoopedKernel:
    """One kernel of a looped model in the form of a set with the kernel ``"f"``."""

    def __init__(self, owner: LoopedSet, name: str) -> None:
        self.owner = owner
        self.kernel = owner[name]
        self.hoisted = owner.hoisted
        self.size, self.seconds, self.from_disk = owner.size, owner.seconds, owner.from_disk
        self.remark = f"; looped over {len(owner.model.links)} links, one code for all products"

    def __getitem__(self, name: str) -> Kernel:
        assert name == "f"
        return self.kernel

    def of_rows(self, shared: bool) -> Kernel:
        """The kernel with its form for batches: eight states at a time, of the same parameters or each of its own."""
        return self.owner.of_rows(self.kernel.name, shared)

    def constants(self, parameters: Any) -> np.ndarray:
        """See :meth:`LoopedSet.constants`."""
        return self.owner.constants(parameters)

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Counts of operations of one call."""
        return {"f": dict(self.kernel.operations), "parameters": {}}
