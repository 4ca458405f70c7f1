"""Large trees: one loop over the links in place of straight-line code, so that only tables grow with the model.

    front     joint variables and forces along them, by the model's expressions of t, q, u           (straight)
    turn      sines and cosines of the joints' angles, eight side by side                            (loop)
    outward   poses and velocities, link by link                                                     (loop)
    loads     wrenches of the forces, springs and couples at points                                  (straight)
    inward    articulated inertias, tips first                                                       (loop)
    final     accelerations                                                                          (loop)
    finish    u' from the second derivatives of the displacements; energies; power                   (straight)

From accelerations to forces (:mod:`freebody.dynamics.newton_euler`) the loops are outward, with accelerations and the
wrenches that they need, and transmitted (wrenches, tips first). The mass matrix takes composite inertias, tips first,
and then the momentum of each motion from its link to the ground (:mod:`freebody.dynamics.composite`): n times the depth
of the tree.

In both directions the wrench of a joint follows from the record of its last link, F = I^A A + p^A (Featherstone 2008,
eq. 7.21). Straight code projects it if several links make up a joint, or if loads act along directions that are not
free.

The straight parts (`tree_parts`) hold the user's expressions, and are empty where a displacement is a coordinate. The
steps of the loops stand in `link_step`. All numbers of a call live in one array S: inputs and outputs of the straight
parts, and the records of the links. Tables of places in S connect them. A number is a double, or eight doubles of
states side by side, or either with its derivative along a direction: the loops are the same.
"""

from __future__ import annotations

from collections import Counter
from time import perf_counter
from typing import Any

import numpy as np
import sympy

from ...dynamics.armature import has_armature
from ...dynamics.loads.actions import accelerating
from ...dynamics.state import float_state
from ...model.model import GROUND, Model
from ...native import codegen
from ...native.records import WIDTH
from ...scalar.algebra import ZERO
from ..kernel import Kernel
from .link_masses import counted
from .link_step import constants_of
from .tree_code import entries
from .tree_parts import Directions, Parts

BODIES = 200
"""Number of bodies from which a tree is looped over for every product."""
SOONER = {
    "derivatives": 10, "forward_dynamics": 40, "forced_dynamics": 40, "inverse_dynamics": 40, "bias": 40,
    "mass_matrix": 40, "reactions": 100, "reactions_at": 100,
}  # fmt: skip
"""Number of bodies from which these products are looped over. From there on loops are about as fast as straight code,
which takes seconds to compile. Measured in `docs/compiled.md`."""


def applies(model: Model, mode: str = "motion") -> bool:
    """Return whether a model can be looped over in a mode.

    Its dimensions and masses must be functions of the parameters alone. From accelerations to forces, rotors may stand
    in the ground only. From forces to accelerations, it must be a tree without armature whose displacements determine
    the coordinates one after another.
    """
    if accelerating(model):
        return False
    if mode in ("inverse", "mass"):
        if any(link.rotor != ZERO and link.parent != GROUND for link in model.links):
            return False
    elif model.constraints or model.order is None or has_armature(model):
        return False
    symbols = {parameter.symbol for parameter in model.parameters}

    def constant(x: Any) -> bool:
        return not isinstance(x, sympy.Basic) or (
            x.free_symbols <= symbols and not x.atoms(sympy.core.function.AppliedUndef)
        )

    return all(constant(x) for i in range(len(model.links)) for x in constants_of(model, i))


def is_large(model: Model, use: str = "") -> bool:
    """Return whether the model is looped over, for every use or for one product or its derivative."""
    name = use.partition("_by_")[0]
    size = SOONER.get("derivatives" if name != use else use, BODIES)
    return len(model.bodies) >= min(BODIES, size) and applies(model, MODES.get(name, "motion"))


class LoopedSet:
    """Kernels of one large model, with one vector c for all, in the form of a :class:`KernelSet`.

    The mode "motion" has these functions of t and y = (q, u): ``rates`` (q', u' and the power if there is any),
    ``moving`` (q' and the power of loads), ``link_poses`` (rotation, place, motion in its axes of each link),
    ``accelerations``, ``energy`` (kinetic, potential), ``kinetic_energy``, ``poses`` (position, rotation by rows of
    each body), ``velocities`` (angular, of the origin) of each body, and ``momentum`` (linear, angular). Its
    ``potential_energy`` and ``postures`` (rotation, position) depend on q only.

    Other modes:

    - "forced": ``accelerations``, with generalized forces beyond the model's after u in y
    - "inverse": ``inverse_dynamics``, with u' after u in y, and ``bias`` of (q, u)
    - "mass": ``mass_matrix`` of q
    - "reactions", and "reactions_at" with u' after u: ``reactions`` (force, moment of each joint)
    - "jacobian": the Jacobian of ``point``

    With ``directions`` there is one kernel: ``f``, the derivative of another by numbers of its state, or ``tangent``.
    """

    def __init__(
        self, model: Model, mode: str = "motion", point: Any = None, lanes: int = 1, shared: bool = True,
        directions: Directions | None = None,
    ) -> None:  # fmt: skip
        self.model = model
        self.mode, self.point = mode, point
        self.directions = directions
        if directions and directions.columns:
            lanes = WIDTH
        elif directions:
            lanes = 1
        self.lanes = lanes
        self._wide: dict[bool, dict[str, Kernel]] = {}
        self._parts = parts = Parts(model, mode, point, lanes, shared, directions)
        self.works = parts.works
        self.hoisted = parts.hoisted
        compiled = [parts.straight, *(step.compiled for step in parts.steps.values())]
        self.from_disk = all(kernels.from_disk for kernels in compiled)
        start = perf_counter()
        text, needs = entries(parts)
        code = codegen.object_code(text)
        library = codegen.Library(code)
        self.size = len(code) + sum(kernels.size for kernels in compiled)
        self.seconds = perf_counter() - start + sum(kernels.seconds for kernels in compiled)
        suffix = "" if lanes == 1 else ".lanes"
        sizes = {name: len(places) for name, places in parts.outputs.items()}
        states = dict(parts.states)
        if directions:
            base, first, count = directions
            suffix, sizes = "", {"f": sizes[base] * count} if count else {"tangent": sizes[base]}
            states = {"f": states[base], "tangent": 2 * first}
        library.needs = parts, needs
        addresses = library.addresses(
            [*(f"{name}{suffix}" for name in sizes), *(f"{name}.batch" for name in sizes)]
        )
        operations = self._operations()
        self.kernels = {
            name: Kernel(
                name, library, addresses[f"{name}{suffix}"], addresses[f"{name}.batch"], states[name], self.hoisted,
                size, operations, addresses[f"{name}.lanes"] if suffix else None,
            )
            for name, size in sizes.items()
        }  # fmt: skip

    def __getitem__(self, name: str) -> Kernel:
        """Return the kernel of this name."""
        return self.kernels[name]

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Counts of operations of one call, by kernel."""
        return {name: dict(kernel.operations) for name, kernel in self.kernels.items()} | {"parameters": {}}

    def _operations(self) -> dict[str, int]:
        total: Counter[str] = Counter()
        for name in ("front", "loads", "finish"):
            total.update(self._parts.straight[name].operations)
        for kind, links in Counter(self._parts.kinds).items():
            for name in self._parts.loops:
                for code, count in self._parts.steps[kind].compiled[name].operations.items():
                    total[code] += links * count
        columns = self.directions.columns or 1 if self.directions else 1
        return {code: columns * count for code, count in sorted(total.items())}

    def of_rows(self, name: str, shared: bool) -> Kernel:
        """Return a kernel with its batch form: eight states at a time, with the same parameters (``shared``) or not.

        Kernels that compute columns of a matrix side by side have one already.
        """
        if self.lanes > 1 or self.directions:
            return self.kernels[name]
        if shared not in self._wide:
            wide = LoopedSet(self.model, self.mode, self.point, WIDTH, shared)
            self._wide[shared] = {
                name: Kernel(
                    name, (kernel, eight), kernel.address, eight.batch_address, kernel.state, kernel.hoisted,
                    kernel.outputs, kernel.operations, eight.lanes_address,
                )
                for (name, kernel), eight in zip(self.kernels.items(), wide.kernels.values(), strict=True)
            }  # fmt: skip
        return self._wide[shared][name]

    def constants(self, parameters: Any) -> np.ndarray:
        """The vector c, shape (hoisted,), or one for each row of parameters."""
        p = np.ascontiguousarray(parameters, dtype=float)
        if p.ndim == 2:
            return np.stack([self.constants(row) for row in p])
        values = {parameter.symbol: float(x) for parameter, x in zip(self.model.parameters, p, strict=True)}
        state = float_state(self.model, values=values)
        c = np.empty(self.hoisted)
        links, kinds = self.model.links, self._parts.kinds
        own = [[float(state(x)) for x in constants_of(self.model, i)] for i in range(len(links))]
        masses = counted(links, own, [kind.bare for kind in kinds])
        for i, start in enumerate(self._parts.offsets):
            step = self._parts.step(i)
            c[start : start + step.hoisted] = step.constants([*own[i], *masses[i]])
        c[self._parts.straight_offset :] = self._parts.straight.constants(p)
        return c


LOOPED = {
    "forward_dynamics": "accelerations", "forced_dynamics": "accelerations", "kinetic_energy": "kinetic_energy",
    "potential_energy": "potential_energy", "poses": "postures", "inverse_dynamics": "inverse_dynamics", "bias": "bias",
    "mass_matrix": "mass_matrix", "velocities": "velocities", "momentum": "momentum", "reactions": "reactions",
    "reactions_at": "reactions",
}  # fmt: skip
"""Looped kernels of products."""

MODES = {
    "forced_dynamics": "forced", "inverse_dynamics": "inverse", "bias": "inverse", "mass_matrix": "mass",
    "reactions": "reactions", "reactions_at": "reactions_at",
}  # fmt: skip
"""Modes of the sets that contain these products; the others are in the mode "motion"."""


def looped_kernel(model: Model, key: Any, product: Any, sets: dict[Any, LoopedSet]) -> LoopedKernel | None:
    """Return the looped kernel of a product of a large model; None if there is none.

    ``sets`` has the sets of the model by mode; a new one is added.
    """
    if product.point is not None:
        if not is_large(model):
            return None
        return LoopedKernel(LoopedSet(model, "jacobian", product.point), "jacobian")
    name, _, by = key.partition("_by_") if isinstance(key, str) else ("", "", "")
    if key == "derivatives":
        name, by = "forward_dynamics", "q u"
    if name not in LOOPED or not is_large(model, f"{name}_by_{by}" if by else name):
        return None
    mode, kernel = MODES.get(name, "motion"), LOOPED[name]
    if by == "":
        if mode not in sets:
            sets[mode] = LoopedSet(model, mode)
        return LoopedKernel(sets[mode], kernel)
    if by == "displacement" and not model.quaternions:
        by = "q"
    sizes = {x: model.n_q if x == "q" else model.n_u for x in product.inputs}
    if by not in (*sizes, "q u"):
        return None
    first = 0 if by == "q u" else sum([*sizes.values()][: [*sizes].index(by)])
    count = sum(sizes.values()) if by == "q u" else sizes[by]
    if count == 0:
        return None
    return LoopedKernel(LoopedSet(model, mode, directions=Directions(kernel, first, count)), "f")


class LoopedKernel:
    """One kernel of a looped model as a set with the kernel ``"f"``."""

    def __init__(self, owner: LoopedSet, name: str) -> None:
        self.owner = owner
        self.kernel = owner[name]
        self.hoisted = owner.hoisted
        self.size, self.seconds, self.from_disk = owner.size, owner.seconds, owner.from_disk
        self.remark = f"; looped over {len(owner.model.links)} links, one code for all products"

    def __getitem__(self, name: str) -> Kernel:
        """Return the kernel, whose name here is "f"."""
        assert name == "f"
        return self.kernel

    def of_rows(self, shared: bool) -> Kernel:
        """Return the kernel with its batch form, as :meth:`LoopedSet.of_rows` does."""
        return self.owner.of_rows(self.kernel.name, shared)

    def constants(self, parameters: Any) -> np.ndarray:
        """The vector c, as :meth:`LoopedSet.constants` returns it."""
        return self.owner.constants(parameters)

    @property
    def operations(self) -> dict[str, dict[str, int]]:
        """Counts of operations of one call."""
        return {"f": dict(self.kernel.operations), "parameters": {}}
