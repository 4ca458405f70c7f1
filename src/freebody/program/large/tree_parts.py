"""The parts of a looped tree: steps of its links, straight code, and the place of every number in S.

    front     joint variables and forces along them, as functions of t, q, u
    turn      sines and cosines of some displacements, from their place in front of the results
    loads     wrenches of the forces, springs and couples at points
    finish    u' from the second derivatives of the displacements; power; reactions
    energy    kinetic and potential energy

S = 0, t, y | fetched from the records | front | loads | finish | energy | of the loops | records | second records

(the ground's second record first). The loops over the links stand in `tree_walk`; this is the one file that knows the
place of every number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ...dynamics import traced_state
from ...dynamics.armature import turned_slides
from ...dynamics.coordinates import (
    accelerations_of_coordinates,
    forces_on_coordinates,
    forces_on_displacements,
)
from ...dynamics.joints.freedom import free_displacements, loads_on_child, transmissible
from ...dynamics.kinematics import Posture, jacobian, rotation
from ...dynamics.loads.loading import Loading, load_potential, load_power, loading
from ...dynamics.state import State
from ...model.model import Model
from ...native.records import WIDTH
from ...scalar.algebra import ZERO, Scalar, apply, dot, negate
from ...scalar.derivative import beside
from ...scalar.trace import INPUT, Tape, Traced
from ...space.spatial import minus
from ..code.emit import Form
from ..kernel import KernelSet
from ..kernels import compile_tape
from . import link_moves, link_step
from .link_masses import is_bare
from .link_places import accelerations, sums
from .link_step import Step, compiled_step, kind_of, normal_of

OF_Q = ("potential_energy", "postures", "jacobian", "mass_matrix")
"""Kernels that depend on q only."""


class Directions(NamedTuple):
    """A kernel and the variables of its derivative: ``columns`` numbers of its state from ``first`` on.

    With ``columns`` 0, the derivative is taken along one direction, which stands behind the state from ``first`` on.
    """

    kernel: str
    first: int
    columns: int = 0


GIVEN = ("inverse", "reactions_at")
"""Modes with given accelerations."""
FORCES, ACCELERATIONS = ("outward", "inward", "final", "place"), ("transmitted", "carried")
STEPS = {
    "motion": (*FORCES, "moved"), "forced": FORCES, "reactions": (*FORCES, "pressed"), "inverse": ACCELERATIONS,
    "reactions_at": (*ACCELERATIONS, "outward", "place", "pressed"), "mass": ("outward", "composed", "projected"),
    "jacobian": ("outward", "place"),
}  # fmt: skip
"""Steps of each mode. From accelerations to forces, loads may need poses and velocities besides."""


class _Inputs(list[Any]):
    """Inputs of the straight parts that come from the records of links, created at their first use."""

    def __init__(self, create: Any) -> None:
        super().__init__()
        self.inputs: dict[int, Any] = {}
        self._create = create

    def __getitem__(self, i: Any) -> Any:
        if i not in self.inputs:
            self.inputs[i] = self._create(i)
        return self.inputs[i]


class Parts:
    """The compiled parts of a looped tree, and the place of every number in S.

    Attributes
    ----------
    hoisted : int
        Length of the vector c: the constants of the links, then those of the straight parts.
    inputs : int
        Length of y: q, u and the generalized forces or accelerations that some modes take besides.
    fetched : list of (link, place)
        Numbers of the records that the straight parts read, in the order of their inputs.
    joints : list of list of int
        Places of the joint variables of each link.
    outputs, states : dict
        By kernel: the places of its outputs, and the length of its state.
    works : bool
        True if power goes in or out.
    """

    def __init__(
        self, model: Model, mode: str, point: Any, lanes: int, shared: bool, directions: Directions | None
    ) -> None:
        self.model, self.mode, self.directions = model, mode, directions
        self.lanes, self.shared = lanes, shared
        self.block = WIDTH if lanes == 1 else 4  # angles whose sines are computed by one call
        self.back = mode in GIVEN  # from accelerations to forces
        self.turning = [i for i, link in enumerate(model.links) if link.one_dof and link.motion.turns]
        self._choose_kinds()
        self._compile_straight(point)
        self.hoisted = self.straight_offset + self.straight.hoisted
        del self._inputs  # and with them the tape

    def _choose_kinds(self) -> None:
        """Choose the kind of every link."""
        links = self.model.links
        free = {i for i, _ in free_displacements(self.model)}
        # modes with forces and reactions as results need loads across the plane, too
        self.normal = normal_of(links) if self.mode in ("motion", "forced") else -1
        self.kinds = [kind_of(link, i in free, self.normal) for i, link in enumerate(links)]
        if self.back or self.mode == "mass":  # no accelerations along displacements follow from forces
            self.kinds = [replace(kind, driven=True) if kind.joint_of_one else kind for kind in self.kinds]
        if self.mode == "inverse":
            self.kinds = [
                replace(kind, free=True, bare=kind.axis if is_bare(links, i, kind.axis) else -1)
                for i, kind in enumerate(self.kinds)
            ]

    def _compile_steps(self) -> None:
        """Compile the steps of every kind of link, and place their constants in c."""
        self.loops = STEPS[self.mode]
        if self.back and self.placed and "place" not in self.loops:
            self.loops = (*self.loops, "outward", "place")
        self.steps: dict[link_step.Kind, Step] = {
            kind: compiled_step(kind, self.loops, self.lanes, self.shared, self.directions is not None)
            for kind in dict.fromkeys(self.kinds)
        }
        self.offsets: list[int] = []
        offset = 0
        for kind in self.kinds:
            self.offsets.append(offset)
            offset += self.steps[kind].compiled.hoisted
        self.straight_offset = offset

    def step(self, i: int) -> KernelSet:
        """The code of link i."""
        return self.steps[self.kinds[i]].compiled

    def _compile_straight(self, point: Any) -> None:
        """Record and compile the straight parts, and place all numbers in S."""
        model, mode = self.model, self.mode
        tape = Tape()
        state = traced_state(model, tape)
        zero, time = tape.input("0"), tape.input("time in S")
        extra = [tape.input(f"{mode} {k}") for k in range(model.n_u if self.back or mode == "forced" else 0)]
        self._inputs: list[Traced] = [zero, time, *state.q, *state.u, *extra]
        self.inputs = model.n_q + model.n_u + len(extra)
        self._places = {x.index: k for k, x in enumerate(self._inputs)} | {state.t.index: 1}
        self.fetched: list[tuple[int, int]] = []

        def fetch(i: int, place: int, count: int) -> list[Traced]:
            new = [tape.input(f"link {i}, {place + k}") for k in range(count)]
            for k, x in enumerate(new):
                self._places[x.index] = len(self._inputs)
                self._inputs.append(x)
                self.fetched.append((i, place + k))
            return new

        def posture(i: int) -> Posture:
            x = fetch(i, link_step.PLACE, 12)
            return Posture((tuple(x[0:3]), tuple(x[3:6]), tuple(x[6:9])), tuple(x[9:12]))  # type: ignore[arg-type]

        def velocity(i: int) -> Any:
            x = fetch(i, link_step.V, 6)
            return (tuple(x[0:3]), tuple(x[3:6]))

        state.cache["postures"], state.cache["velocities"] = _Inputs(posture), _Inputs(velocity)
        at_rest = mode in ("mass", "jacobian")
        loads = Loading() if at_rest else loading(model, state)
        joints = self._joint_variables(state, loads, extra)
        gravity = ZERO if at_rest else state.vector(model.gravity)
        energetic = mode == "motion"
        power = load_power(model, state) if energetic else 0
        spring = load_potential(model, state) if energetic else 0
        self.placed = bool(state.cache["postures"].inputs or (self.back and state.cache["velocities"].inputs))
        self._compile_steps()
        self.loads_end = len(self._inputs)
        self.works = False
        if mode in ("reactions", "reactions_at"):
            finish = self._reactions(state, loads, fetch)
        elif mode == "jacobian":
            finish = [x for row in jacobian(model, state, point) for x in row]
        elif mode == "mass":
            finish = []
        elif self.back:
            finish = self._forces(state, loads, joints, fetch)
        else:
            finish = self._accelerations(state, loads, power, fetch)
        totals = [tape.input(f"sum {k}") for k in range(6)]  # energies take four, momenta six, products three
        self.totals = len(self._inputs)
        block = [tape.input(f"angle {k}") for k in range(self.block)]
        self.angles = self.totals + len(totals)
        for x in (*totals, *block):
            self._places[x.index] = len(self._inputs)
            self._inputs.append(x)
        potential = spring - dot(gravity, (totals[1], totals[2], totals[3]))
        moves = link_moves.numbers(model, state) if mode == "mass" else []
        functions: dict[str, list[Any]] = {
            "front": [x for variables in joints for x in variables] + list(negate(gravity)) + moves,
            "loads": [x for wrench in loads.wrenches.values() for vector in wrench for x in vector],
            "finish": finish,
            "energy": [totals[0], potential] if energetic else [],
            "product": [totals[0] * totals[1] * totals[2]] if mode == "mass" else [],
            "turn": [f(x) for f in (tape.sin, tape.cos) for x in block] if self.turning else [],
        }
        computed: dict[str, list[Any]] = {}
        start = len(self._inputs)
        self.start: dict[str, int] = {}
        placed: dict[str, list[int]] = {}
        for name, outputs in functions.items():
            self.start[name] = start
            new: list[Any] = []
            placed[name] = [self._place(x, start, new) for x in outputs]
            computed[name] = new
            start += len(new)
        self.joints, self.ground, left = self._places_of_front(joints, placed["front"])
        start = self._place_turns(start)
        self._place_records(start, loads)
        self.empty = {name for name, outputs in computed.items() if not outputs}
        parameters = [state.values[parameter.symbol] for parameter in model.parameters]
        inputs = self._inputs
        if self.directions is not None:
            computed, inputs = beside(tape, computed, inputs)
        form = Form(self.lanes, self.shared) if self.lanes > 1 else None
        self.straight = compile_tape(tape, computed, state.t, inputs, parameters, form=form)
        self.moves = link_moves.moves(model, left) if mode == "mass" else None
        self.pressed = [
            (self.sums.of[i] + j, placed["loads"][6 * n + j])
            for n, i in enumerate(loads.wrenches)
            for j in range(6)
        ]
        self._place_outputs(state, placed)
        self.states = {name: model.n_q if name in OF_Q else self.inputs for name in self.outputs}
        self.states.update({"bias": model.n_q + model.n_u})

    def _joint_variables(self, state: State, loads: Loading, extra: Sequence[Scalar]) -> list[list[Scalar]]:
        """Joint variables of each link: y, y' and τ or y''; for a ball or free joint q, u, τ or u'."""
        model = self.model
        generalized = dict(loads.generalized)
        along: dict[int, Scalar] = {}
        udot = extra if self.back else None
        if not self.back and self.mode != "mass":
            for k, force in enumerate(extra):
                generalized[k] = generalized.get(k, 0) + force
            along = forces_on_displacements(model, state, generalized)
            for i, force in loads.along.items():
                along[i] = along.get(i, 0) + force
        joints: list[list[Scalar]] = []
        for i, link in enumerate(model.links):
            if link.one_dof:
                rate, last = state.rate(link), along.get(i, 0)
                if self.mode == "mass":
                    rate = 0
                elif udot is not None or link.driven:
                    last = state.second_rate(link, udot)
                joints.append([state(link.displacement), rate, last])
            elif link.u >= 0:
                n_q, n_u = link.n_coordinates, link.n_speeds
                if udot is None:
                    forces = [generalized.get(link.u + k, 0) for k in range(n_u)]
                else:
                    forces = [*udot[link.u : link.u + n_u]]
                joints.append([*state.q[link.q : link.q + n_q], *state.u[link.u : link.u + n_u], *forces])
            else:
                joints.append([])
        return joints

    @staticmethod
    def _places_of_front(
        joints: list[list[Scalar]], places: list[int]
    ) -> tuple[list[list[int]], list[int], list[int]]:
        """Places of the variables of each joint, of the ground's acceleration, and of what is left."""
        left = iter(places)
        return (
            [[next(left) for _ in variables] for variables in joints],
            [next(left) for _ in range(3)],
            [*left],
        )

    def _place_turns(self, start: int) -> int:
        """Place sines and cosines of angles, in blocks, behind the other variables of the joints."""
        self.turned = list(dict.fromkeys(self.joints[i][0] for i in self.turning))
        self.sines, size = start, self.block
        for i, link in enumerate(self.model.links):
            if link.one_dof:
                y, rate, last = self.joints[i]
                self.joints[i] = [rate, last]
                if link.motion.turns:
                    block, k = divmod(self.turned.index(y), size)
                    self.joints[i] += [start + 2 * size * block + k, start + 2 * size * block + size + k]
                if link.motion.slides:
                    self.joints[i].append(y)
        self.turned += self.turned[-1:] * (-len(self.turned) % size)
        return start + 2 * len(self.turned)

    def _place_records(self, start: int, loads: Loading) -> None:
        """Place the numbers of the loops from ``start`` on: sums, accelerations, joint variables and records."""
        links = self.model.links
        parents = [link.parent for link in links]
        everywhere = self.mode.startswith("reactions")
        size = 6 if self.back else link_step.SUM
        self.sums = sums(parents, range(len(parents)) if everywhere else loads.wrenches, start, size)
        self.accelerations, start = accelerations(
            parents, everywhere, self.sums.end, link_step.MOVING if self.back else 6
        )
        self.joint = start
        self.records = []
        start += link_step.ARRAYS["joint"]
        for kind in self.kinds:
            self.records.append(start)
            start += self.steps[kind].width
        self.base = start
        self.momentum = start + (len(links) + 1) * link_step.WIDTH  # two places, for that of one motion
        self.matrix = self.momentum + 12
        self.size = self.matrix + (self.model.n_u**2 if self.mode == "mass" else 0)

    def _place_outputs(self, state: State, placed: dict[str, list[int]]) -> None:
        """List the places of each kernel's outputs in S."""
        model = self.model
        single = {"inverse": ("inverse_dynamics", "bias")}
        if self.mode == "mass":
            self.outputs = {"mass_matrix": list(range(self.matrix, self.size))}
            return
        if self.mode not in ("motion", "forced"):
            names = single.get(self.mode, (self.mode.removesuffix("_at"),))
            self.outputs = dict.fromkeys(names, placed["finish"])
            if self.mode == "reactions":
                self.outputs["multipliers"] = []  # a tree has none
            return
        *accelerations, work, pushed = placed["finish"]
        coordinate_rates = self._coordinate_rates(state)
        self.outputs = {
            "rates": [*coordinate_rates, *accelerations, *([work] if self.works else [])],
            "accelerations": accelerations,
            "moving": [*coordinate_rates, pushed],
            "link_poses": [
                self.at(i, k)
                for i in range(len(model.links))
                for k in (*range(link_step.PLACE, link_step.PLACE + 12), *range(link_step.V, link_step.V + 6))
            ],
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

    def _accelerations(self, state: State, loads: Loading, power: Scalar, fetch: Any) -> list[Scalar]:
        """u', the power, and that of loads alone, from the results of the loops in the records."""
        model = self.model
        second, free, driven = {}, {}, {}
        for i, link in enumerate(model.links):
            kind = self.kinds[i]
            if link.driven:
                if link.drift != 0:
                    (driven[i],) = fetch(i, kind.force, 1)
            elif kind.freedom:
                rates = fetch(i, link_step.RATES, kind.freedom)
                if link.one_dof:
                    second[i] = rates[0]
                else:
                    free.update({link.u + k: rate for k, rate in enumerate(rates)})
        udot, pushed = accelerations_of_coordinates(model, state, second, free), power
        for i, force in driven.items():
            power = power + (force - loads.along.get(i, 0)) * state(model.links[i].drift)
        self.works = not (isinstance(power, int) and power == 0)
        return [*udot, power, pushed]

    def _forces(
        self, state: State, loads: Loading, joints: Sequence[Sequence[Scalar]], fetch: Any
    ) -> list[Scalar]:
        """Generalized forces, from the forces along the joints in the records: see `newton_euler.inverse_dynamics`."""
        model = self.model
        tau: list[Scalar] = [0] * len(model.links)
        free: dict[int, Scalar] = {}
        for i, link in enumerate(model.links):
            armature = state.armature(i)
            if link.partials:
                (tau[i],) = fetch(i, link_step.ALONG, 1)
                tau[i] = tau[i] - loads.along.get(i, 0)
                for a in armature:
                    tau[i] = tau[i] + a * joints[i][2]
            elif link.u >= 0:
                along = fetch(i, link_step.ALONG, link.n_speeds)
                turned = turned_slides(state, i)
                for k, x in enumerate(along):
                    free[link.u + k] = x
                    if armature:
                        free[link.u + k] = x + armature[k] * (
                            joints[i][k - len(along)] + (turned[k] if k < len(turned) else 0)
                        )
        total = forces_on_coordinates(model, state, tau)
        for j, force in free.items():
            total[j] = force
        for j, force in loads.generalized.items():
            total[j] = total[j] - force
        return list(total)

    def _reactions(self, state: State, loads: Loading, fetch: Any) -> list[Scalar]:
        """Force and moment of every joint: see `newton_euler.reactions`."""
        model = self.model
        result: list[Scalar] = []
        for joint in model.joints.values():
            i = joint.links[-1]
            if len(joint.links) == 1 and i not in loads.along:
                result += fetch(i, link_step.REACTION, 6)
                continue
            x = fetch(i, link_step.PRESSED, 6)
            on_child = loads_on_child(model, state, joint, loads.along, free=False)
            wrench = minus((tuple(x[0:3]), tuple(x[3:6])), on_child)
            moment, force = transmissible(model, state, joint, wrench)
            R = rotation(model, state, i)
            result += [*apply(R, force), *apply(R, moment)]
        return result

    def at(self, i: int, place: int) -> int:
        """Place in S of a number of the records of link i; i = -1 is the ground, which has a second record only."""
        if place < link_step.SECOND:
            return self.records[i] + place
        return self.base + (i + 1) * link_step.WIDTH + place - link_step.SECOND

    def _place(self, x: Any, start: int, computed: list[Any]) -> int:
        """Place of x in S; x is added to the computed numbers unless it is an input or zero."""
        if type(x) is not Traced:
            if x == 0:
                return 0
        elif x.tape.op[x.index] == INPUT and x.index in self._places:
            return self._places[x.index]
        computed.append(x)
        return start + len(computed) - 1

    def _coordinate_rates(self, state: State) -> list[int]:
        """Places of the coordinate rates in S."""
        model = self.model
        speeds = {speed.name: state.u[i] for i, speed in enumerate(model.speeds)}
        result = [
            self._places[speeds[coordinate.name + "'"].index] if coordinate.kind == "scalar" else -1
            for coordinate in model.coordinates
        ]
        for i, link in enumerate(model.links):
            if link.own:
                for k in range(link.n_coordinates):
                    result[link.q + k] = self.at(i, link_step.COORDINATE_RATES + k)
        return result
