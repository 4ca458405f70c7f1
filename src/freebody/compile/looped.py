"""Large trees: one loop over the links in place of straight-line code, so that nothing grows but tables.

    front     joint variables and forces along them: what the model's expressions say of t, q, u     (straight)
    outward   poses, velocities, inertias, link by link                                              (loop)
    loads     wrenches of the forces, springs and couples at points                                  (straight)
    inward    articulated inertias, tips first                                                       (loop)
    final     accelerations                                                                          (loop)
    finish    u' from the second derivatives of the displacements; energies; power                   (straight)

The straight parts hold what the user wrote, and are empty where a displacement is a coordinate. The loop steps are
:mod:`freebody.compile.link_step`. All numbers of one call live in one array S of doubles: inputs of the straight
parts, their outputs, and one record per link; tables of places in S say what goes where.
"""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter
from typing import Any

import numpy as np
import sympy

from ..dynamics import traced_state
from ..dynamics.coordinates import accelerations_of_coordinates, forces_on_displacements
from ..dynamics.kinematics import Posture
from ..dynamics.loading import load_power, loading, spring_energy
from ..dynamics.state import float_state
from ..model.model import GROUND, Model
from ..scalar.algebra import dot, negate
from ..scalar.trace import INPUT, Tape, Traced
from . import link_step, native
from .kernels import Kernel, KernelSet, compile_tape
from .link_step import WIDTH, compiled_step, constants_of, kind_of

BODIES = 200
"""From this number of bodies on, a tree is looped over."""

OF_Q = ("potential_energy", "postures")
"""Kernels that are given q only."""

_ROW = 8  # numbers per link in the table of links


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


def is_large(model: Model) -> bool:
    """Whether the model is looped over."""
    return len(model.bodies) >= BODIES and applies(model)


class LoopedSet:
    """Kernels of one large model, as a :class:`KernelSet` gives them: one vector c for all.

    ``rates`` (q', u' and, where power goes in or out, that), ``accelerations``, ``energy`` (kinetic, potential), each
    of the two, and ``poses`` (position, rotation by rows of each body) as functions of t and y = (q, u), where
    ``potential_energy`` and ``postures`` (rotation, position) are given q only. If ``forced``, generalized forces
    besides the model's stand after u in y, and there is ``accelerations`` alone.
    """

    def __init__(self, model: Model, forced: bool = False) -> None:
        self.model = model
        self._kinds = [kind_of(link) for link in model.links]
        self._steps = {kind: compiled_step(kind) for kind in dict.fromkeys(self._kinds)}
        parts = _Parts(model, self._kinds, forced)
        self.works = parts.works
        self.straight: KernelSet = parts.compiled
        self._offsets: list[int] = []
        offset = 0
        for kind in self._kinds:
            self._offsets.append(offset)
            offset += self._steps[kind].hoisted
        self.straight_offset = offset
        self.hoisted = offset + self.straight.hoisted
        self.from_disk = self.straight.from_disk and all(step.from_disk for step in self._steps.values())
        self._tables: list[np.ndarray] = []
        start = perf_counter()
        code = native.object_code(_Driver(self, parts).text())
        library = native.Library(code)
        used = [self.straight, *self._steps.values()]
        self.size = len(code) + sum(one.size for one in used)
        self.seconds = perf_counter() - start + sum(one.seconds for one in used)
        names = [name for name in parts.outputs]
        library.needs = (self._tables, self._steps, self.straight)
        found = library.addresses([*names, *(f"{name}.batch" for name in names)])
        self.kernels = {
            name: Kernel(
                name, library, found[name], found[f"{name}.batch"], parts.states[name], self.hoisted,
                len(parts.outputs[name]), self._operations(),
            )
            for name in names
        }  # fmt: skip

    def __getitem__(self, name: str) -> Kernel:
        return self.kernels[name]

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Counts of operations of one call, by kernel."""
        return {name: dict(kernel.operations) for name, kernel in self.kernels.items()} | {"parameters": {}}

    def _operations(self) -> dict[str, int]:
        total: dict[str, int] = {}
        for kind in self._kinds:
            for name in ("outward", "inward", "final"):
                for code, count in self._steps[kind][name].operations.items():
                    total[code] = total.get(code, 0) + count
        return dict(sorted(total.items()))

    def step(self, i: int) -> KernelSet:
        """The code of link i."""
        return self._steps[self._kinds[i]]

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
            step, start = self._steps[kind], self._offsets[i]
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


class _Parts:
    """The straight parts of a model, and where everything stands in S.

    S = 0, t, y | fetched from the records | front | loads | finish | energy | records (the ground's first)
    """

    def __init__(self, model: Model, kinds: Sequence[link_step.Kind], forced: bool) -> None:
        self.model = model
        tape = Tape()
        state = traced_state(model, tape)
        zero, time = tape.input("0"), tape.input("time in S")
        besides = [tape.input(f"force {k}") for k in range(model.n_u)] if forced else []
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
        loads = loading(model, state)
        generalized = dict(loads.generalized)
        for k, force in enumerate(besides):
            generalized[k] = generalized.get(k, 0) + force
        along = forces_on_displacements(model, state, generalized)
        for i, force in loads.along.items():
            along[i] = along.get(i, 0) + force
        joints: list[list[Any]] = []
        for i, link in enumerate(model.links):
            if link.one_dof:
                third = state.second_rate(link, None) if link.driven else along.get(i, 0)
                joints.append([state(link.displacement), state.rate(link), third])
            elif link.u >= 0:
                n_q, n_u = (7, 6) if link.kind == "free" else (4, 3)
                forces = [generalized.get(link.u + k, 0) for k in range(n_u)]
                joints.append([*state.q[link.q : link.q + n_q], *state.u[link.u : link.u + n_u], *forces])
            else:
                joints.append([])
        gravity = state.vector(model.gravity)
        power = load_power(model, state)
        spring = spring_energy(model, state)
        self.placed = len(state.cache["postures"].made) > 0
        self.loads_end = len(self._inputs)
        # finish
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
        # energy
        sums = [tape.input(f"sum {k}") for k in range(4)]
        self.sums = len(self._inputs)
        for x in sums:
            self._places[x.index] = len(self._inputs)
            self._inputs.append(x)
        potential = spring - dot(gravity, (sums[1], sums[2], sums[3]))
        self.fetched = fetched

        functions: dict[str, list[Any]] = {
            "front": [x for one in joints for x in one] + list(negate(gravity)),
            "loads": [x for wrench in loads.wrenches.values() for vector in wrench for x in vector],
            "finish": [*udot, power],
            "energy": [sums[0], potential],
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
        self.base = start
        self.empty = {name for name, outputs in computed.items() if not outputs}
        parameters = [state.values[parameter.symbol] for parameter in model.parameters]
        self.compiled = compile_tape(tape, computed, state.t, self._inputs, parameters)
        # tables
        self.joints: list[list[int]] = []
        k = 0
        for one in joints:
            self.joints.append(placed["front"][k : k + len(one)])
            k += len(one)
        self.ground = placed["front"][k:]
        self.pressed = [
            (self.record(i) + link_step.INERTIA + 21 + j, placed["loads"][6 * n + j])
            for n, i in enumerate(loads.wrenches)
            for j in range(6)
        ]
        *accelerations, work = placed["finish"]
        coordinate_rates = self._coordinate_rates(state)
        self.outputs: dict[str, list[int]] = {
            "rates": [*coordinate_rates, *accelerations, *([work] if self.works else [])],
            "accelerations": accelerations,
            "energy": placed["energy"],
            "kinetic_energy": placed["energy"][:1],
            "potential_energy": placed["energy"][1:],
            "poses": [
                self.record(model.bodies[name].link) + k
                for name in model.bodies
                for k in (
                    *range(link_step.ORIGIN, link_step.ORIGIN + 3), *range(link_step.PLACE, link_step.PLACE + 9)
                )
            ],
            "postures": [
                self.record(model.bodies[name].link) + k
                for name in model.bodies
                for k in (
                    *range(link_step.PLACE, link_step.PLACE + 9), *range(link_step.ORIGIN, link_step.ORIGIN + 3)
                )
            ],
        }  # fmt: skip
        if forced:
            self.outputs = {"accelerations": accelerations}
        self.states = {name: model.n_q if name in OF_Q else self.given for name in self.outputs}

    def record(self, i: int) -> int:
        """Where the record of link i begins; the ground's is the first."""
        return self.base + (i + 1) * WIDTH

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
                    result[link.q + k] = self.record(i) + link_step.COORDINATE_RATES + k
        return result


class _Driver:
    """The loops as LLVM IR."""

    def __init__(self, owner: LoopedSet, parts: _Parts) -> None:
        self.owner = owner
        self.parts = parts
        self.count = len(parts.model.links)
        rows: list[int] = []
        joints: list[int] = []
        for i, link in enumerate(parts.model.links):
            step = owner.step(i)
            parent = parts.base if link.parent == GROUND else parts.record(link.parent)
            addresses = [step[name].address for name in ("outward", "inward", "final", "place")]
            rows += [*addresses, parent, owner.offset(i), len(joints), len(parts.joints[i])]
            joints += parts.joints[i]
        self.links, self.joints = owner.table(rows), owner.table(joints)

    def text(self) -> str:
        """The module."""
        triple = native.processor()[0]
        head = f'target triple = "{triple}"\ntarget datalayout = "{native.layout()}"\n'
        batches = [_BATCH.format(name=name, **self._sizes(name)) for name in self.parts.outputs]
        functions = [self._function(name) for name in self.parts.outputs]
        return head + _HELPERS + "\n".join([*self._loops(), *functions, *batches])

    def _sizes(self, name: str) -> dict[str, int]:
        return {"state": self.parts.states[name], "outputs": len(self.parts.outputs[name])}

    def _function(self, name: str) -> str:
        parts = self.parts
        state = parts.given
        size = parts.record(self.count)
        moving = name in ("rates", "accelerations")
        placed = not moving or parts.placed
        lines = [
            f"define void @{name}(double %t, ptr %y, ptr %c, ptr %out) nounwind {{",
            f"  %S = call ptr @malloc(i64 {8 * size})",
            "  store double 0.0, ptr %S, align 8",
            "  %S1 = getelementptr double, ptr %S, i64 1",
            "  store double %t, ptr %S1, align 8",
            "  %S2 = getelementptr double, ptr %S, i64 2",
            f"  call void @llvm.memset.p0.i64(ptr %S2, i8 0, i64 {8 * state}, i1 false)",
            f"  call void @copy(ptr %S2, ptr %y, i64 {parts.states[name]})",
            f"  %ground = getelementptr double, ptr %S, i64 {parts.base}",
            f"  call void @llvm.memset.p0.i64(ptr %ground, i8 0, i64 {8 * WIDTH}, i1 false)",
        ]
        for k in (0, 4, 8):
            lines += [
                f"  %one{k} = getelementptr double, ptr %ground, i64 {link_step.PLACE + k}",
                f"  store double 1.0, ptr %one{k}, align 8",
            ]
        lines += self._straight("front")
        lines.append(f"  %g = getelementptr double, ptr %ground, i64 {link_step.A + 3}")
        lines.append(self._gather("%g", parts.ground))
        lines.append(f"  call void @outward.{'placed' if placed else 'plain'}(double %t, ptr %S, ptr %c)")
        fetched = [parts.record(i) + k for i, k in parts.fetched]
        first = 2 + state
        if fetched and name not in ("poses", "postures"):
            early = parts.loads_end - first
            lines.append(f"  %early = getelementptr double, ptr %S, i64 {first}")
            lines.append(self._gather("%early", fetched[:early]))
        if moving:
            lines += self._straight("loads")
            if parts.pressed:
                targets = self.owner.table([a for a, _ in parts.pressed])
                sources = self.owner.table([b for _, b in parts.pressed])
                lines.append(
                    f"  call void @press(ptr %S, ptr inttoptr (i64 {targets} to ptr), "
                    f"ptr inttoptr (i64 {sources} to ptr), i64 {len(parts.pressed)})"
                )
            lines += [
                "  call void @inward(double %t, ptr %S, ptr %c)",
                "  call void @final(double %t, ptr %S, ptr %c)",
            ]
            late = fetched[parts.loads_end - first :]
            if late:
                lines.append(f"  %late = getelementptr double, ptr %S, i64 {parts.loads_end}")
                lines.append(self._gather("%late", late))
            lines += self._straight("finish")
        elif name.endswith("energy"):
            lines.append(f"  %sums = getelementptr double, ptr %S, i64 {parts.sums}")
            lines.append("  call void @sum(ptr %S, ptr %sums)")
            lines += self._straight("energy")
        lines.append(self._gather("%out", parts.outputs[name]))
        return "\n".join([*lines, "  call void @free(ptr %S)", "  ret void", "}", ""])

    def _straight(self, name: str) -> list[str]:
        if name in self.parts.empty:
            return []
        address = self.owner.straight[name].address
        return [
            f"  %{name}.c = getelementptr double, ptr %c, i64 {self.owner.straight_offset}",
            f"  %{name}.out = getelementptr double, ptr %S, i64 {self.parts.start[name]}",
            f"  call void inttoptr (i64 {address} to ptr)(double %t, ptr %S, ptr %{name}.c, ptr %{name}.out)",
        ]

    def _gather(self, target: str, places: Sequence[int]) -> str:
        table = self.owner.table(places)
        return (
            f"  call void @gather(ptr {target}, ptr %S, ptr inttoptr (i64 {table} to ptr), i64 {len(places)})"
        )

    def _loops(self) -> list[str]:
        s, base = link_step, self.parts.base
        joints = f"ptr inttoptr (i64 {self.joints} to ptr)"
        fetch = f"""
  %start = load i64, ptr %row6, align 8
  %many = load i64, ptr %row7, align 8
  %places = getelementptr i64, {joints}, i64 %start
  %joint = getelementptr double, ptr %record, i64 {s.JOINT}
  call void @gather(ptr %joint, ptr %S, ptr %places, i64 %many)
  %from = getelementptr double, ptr %parent, i64 {s.V}
  call void @llvm.memcpy.p0.p0.i64(ptr %record, ptr %from, i64 48, i1 false)
{_call(0, s.OUTWARD)}"""
        place = f"""
  %above = getelementptr double, ptr %parent, i64 {s.PLACE}
  %there = getelementptr double, ptr %record, i64 {s.PARENT_PLACE}
  call void @llvm.memcpy.p0.p0.i64(ptr %there, ptr %above, i64 96, i1 false)
{_call(3, s.PLACE)}"""
        inward = f"""
{_call(1, s.INWARD)}
  %sum = getelementptr double, ptr %parent, i64 {s.INERTIA}
  call void @add(ptr %sum, ptr %to1, i64 27)"""
        final = f"""
  %from = getelementptr double, ptr %parent, i64 {s.A}
  %A = getelementptr double, ptr %record, i64 {s.PARENT_A}
  call void @llvm.memcpy.p0.p0.i64(ptr %A, ptr %from, i64 48, i1 false)
{_call(2, s.FINAL)}"""
        total = f"""
  %kinetic = getelementptr double, ptr %record, i64 {s.KINETIC}
  call void @add(ptr %c, ptr %kinetic, i64 4)"""
        fill = {"links": self.links, "n": self.count, "base": base, "width": WIDTH}
        up = {"first": 0, "stop": self.count, "by": 1}
        down = {"first": self.count - 1, "stop": -1, "by": -1}
        return [
            _LOOP.format(name="outward.plain", body=fetch, **fill, **up),
            _LOOP.format(name="outward.placed", body=fetch + place, **fill, **up),
            _LOOP.format(name="inward", body=inward, **fill, **down),
            _LOOP.format(name="final", body=final, **fill, **up),
            _LOOP.format(name="sums", body=total, **fill, **up),
        ]


def _call(column: int, target: int) -> str:
    """The step of a column of the table, which writes from ``target`` of the record on."""
    return f"""  %address{column} = load i64, ptr %row{column}, align 8
  %f{column} = inttoptr i64 %address{column} to ptr
  %to{column} = getelementptr double, ptr %record, i64 {target}
  call void %f{column}(double %t, ptr %record, ptr %own, ptr %to{column})"""


_LOOP = (
    """
define internal void @{name}(double %t, ptr %S, ptr %c) nounwind noinline {{
entry:
  br label %loop
loop:
  %i = phi i64 [{first}, %entry], [%next, %loop]
  %r = mul i64 %i, 8
  %row0 = getelementptr i64, ptr inttoptr (i64 {links} to ptr), i64 %r
"""
    + "\n".join(f"  %row{k} = getelementptr i64, ptr %row0, i64 {k}" for k in range(1, _ROW))
    + """
  %place = load i64, ptr %row4, align 8
  %offset = load i64, ptr %row5, align 8
  %parent = getelementptr double, ptr %S, i64 %place
  %own = getelementptr double, ptr %c, i64 %offset
  %i1 = add i64 %i, 1
  %w = mul i64 %i1, {width}
  %b = add i64 %w, {base}
  %record = getelementptr double, ptr %S, i64 %b
{body}
  %next = add i64 %i, {by}
  %more = icmp ne i64 %next, {stop}
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""
)

_BATCH = """
define void @{name}.batch(i64 %n, ptr %t, i64 %ts, ptr %y, ptr %c, i64 %cs, ptr %out) nounwind {{
entry:
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %loop, label %done
loop:
  %i = phi i64 [0, %entry], [%next, %loop]
  %it = mul i64 %i, %ts
  %iy = mul i64 %i, {state}
  %ic = mul i64 %i, %cs
  %io = mul i64 %i, {outputs}
  %pt = getelementptr double, ptr %t, i64 %it
  %py = getelementptr double, ptr %y, i64 %iy
  %pc = getelementptr double, ptr %c, i64 %ic
  %po = getelementptr double, ptr %out, i64 %io
  %time = load double, ptr %pt, align 8
  call void @{name}(double %time, ptr %py, ptr %pc, ptr %po)
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""


def _each(name: str, arguments: str, body: str) -> str:
    """A loop of %k from 0 to %n."""
    return f"""
define internal void @{name}({arguments}, i64 %n) nounwind noinline {{
entry:
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %loop, label %done
loop:
  %k = phi i64 [0, %entry], [%next, %loop]
{body}
  %next = add i64 %k, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""


_HELPERS = (
    """
declare ptr @malloc(i64)
declare void @free(ptr)
declare void @llvm.memset.p0.i64(ptr, i8, i64, i1)
declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)
define internal void @copy(ptr %target, ptr %source, i64 %n) nounwind {
  %bytes = mul i64 %n, 8
  call void @llvm.memcpy.p0.p0.i64(ptr %target, ptr %source, i64 %bytes, i1 false)
  ret void
}
define internal void @sum(ptr %S, ptr %sums) nounwind {
  call void @llvm.memset.p0.i64(ptr %sums, i8 0, i64 32, i1 false)
  call void @sums(double 0.0, ptr %S, ptr %sums)
  ret void
}
"""
    + _each(
        "gather",
        "ptr %target, ptr %S, ptr %places",
        """  %p = getelementptr i64, ptr %places, i64 %k
  %place = load i64, ptr %p, align 8
  %s = getelementptr double, ptr %S, i64 %place
  %x = load double, ptr %s, align 8
  %d = getelementptr double, ptr %target, i64 %k
  store double %x, ptr %d, align 8""",
    )
    + _each(
        "add",
        "ptr %target, ptr %source",
        """  %s = getelementptr double, ptr %source, i64 %k
  %d = getelementptr double, ptr %target, i64 %k
  %x = load double, ptr %s, align 8
  %z = load double, ptr %d, align 8
  %sum = fadd double %x, %z
  store double %sum, ptr %d, align 8""",
    )
    + _each(
        "press",
        "ptr %S, ptr %targets, ptr %sources",
        """  %a = getelementptr i64, ptr %targets, i64 %k
  %b = getelementptr i64, ptr %sources, i64 %k
  %i = load i64, ptr %a, align 8
  %j = load i64, ptr %b, align 8
  %d = getelementptr double, ptr %S, i64 %i
  %s = getelementptr double, ptr %S, i64 %j
  %x = load double, ptr %d, align 8
  %z = load double, ptr %s, align 8
  %less = fsub double %x, %z
  store double %less, ptr %d, align 8""",
    )
)


LOOPED = {
    "forward_dynamics": "accelerations", "forced_dynamics": "accelerations", "kinetic_energy": "kinetic_energy",
    "potential_energy": "potential_energy", "poses": "postures",
}  # fmt: skip
"""Products of a program that large models have in looped form, and their kernels."""


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

    def constants(self, parameters: Any) -> np.ndarray:
        """See :meth:`LoopedSet.constants`."""
        return self.owner.constants(parameters)

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Counts of operations of one call."""
        return {"f": dict(self.kernel.operations), "parameters": {}}
