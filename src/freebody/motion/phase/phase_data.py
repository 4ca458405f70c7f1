"""The data of a phase of contacts (`PhaseData`), made for a machine, and its functions with them as constants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from ...dynamics.bearing_loads import LOADED
from ...dynamics.conditions.constraints import rows
from ...native.records import padded
from ..kernels.contact_quantities import NAMES, Asked
from ..kernels.hoisted import Hoisted
from ..ode.dense_output import Array
from .candidates.candidates import ContactPattern
from .phase_record import PhaseData

SLIPPING = "slip+", "slip-", "slip", "limit"
"""Kinds of modes with friction along a direction."""


@dataclass(frozen=True, eq=False)
class DataProgram:
    """Functions of (t, y, c) whose constants c are the data of a phase.

    ``functions``  address and number of outputs of each
    ``data``       the data, without constants of kernels
    ``programs``   of each kernel in them, by its name there
    """

    functions: Mapping[str, tuple[int, int]]
    data: PhaseData
    programs: Mapping[str, Any]
    _last: list[tuple[bytes, PhaseData]] = field(default_factory=list)

    def address(self, name: str) -> int:
        """Address of a function."""
        return self.functions[name][0]

    def outputs(self, name: str) -> int:
        """Number of outputs of a function."""
        return self.functions[name][1]

    def constants(self, parameters: Array) -> Array:
        """Return c for these parameters; it is memory of the functions too, so no two threads may share it.

        A part or a plain copy of it will not do: rows in it are addresses.
        """
        key = parameters.tobytes()
        last = self._last[0] if self._last else (b"", None)  # another thread may replace it meanwhile
        if last[1] is None or last[0] != key:
            data = self.data.copied()
            self.set_parameters(data.memory, parameters)
            last = key, data
            self._last[:] = [last]
        return last[1].copied().memory

    def follow(self, hoisted: Hoisted, c: Array) -> None:
        """Let the constants of the kernels in c follow the parameters that a run writes."""
        for name, program in self.programs.items():
            place, _, (size,) = self.data.placed[f"{name}_c"]
            program.follow(hoisted, c[place : place + size])

    def set_parameters(self, c: Array, parameters: Array) -> None:
        """Write the constants of the kernels for these parameters, and for the sides of laws that switch, into c."""
        for name, program in self.programs.items():
            place, _, (size,) = self.data.placed[f"{name}_c"]
            given = np.concatenate([parameters, self.data.sides])
            c[place : place + size] = program.constants(given[: program.compiled.parameters])


def phase_data(
    phase: Any, programs: Mapping[str, tuple[Any, str]], endings: bool, whole: bool, asked: Asked = ()
) -> PhaseData:
    """Return the data of a phase, before its modes are written: a copy of those made for the first phase of its sizes.

    ``programs``   name of a kernel in the data -> its program, and its name there
    ``endings``    True if the end of the phase is watched
    ``whole``      True for room for all modes, which compiled code may write then
    ``asked``      quantities of contacts that the functions of the user take
    """
    scene, own, n = phase.scene, len(phase.own), phase.model.n_u
    active, conditions = len(phase.active), own + len(phase.conditions)
    slipping = sum(mode.partition(" ")[0] in SLIPPING for mode in phase.modes)
    if whole:
        active, conditions, slipping = min(own + scene.rows, n), own + scene.rows, len(phase.modes)
    kernels = {name: (one.address(its), one.compiled.hoisted) for name, (one, its) in programs.items()}
    key = (active, conditions, slipping, endings, asked, *kernels.items())
    if key not in scene.layouts:
        data = _made(phase, (active, conditions, slipping), kernels, scene.endings if endings else (), asked)
        _write_pattern(data, phase, programs["machine"][0])
        scene.layouts[key] = data
    data = scene.layouts[key].copied()
    data.sides[:] = phase.sides
    for k, mode in enumerate(phase.modes):
        if " " in mode:
            data.direction[k] = list(map(float, mode.split()[1:]))
    return data


def _made(
    phase: Any, sizes: tuple[int, int, int], kernels: Mapping[str, tuple[int, int]], endings: Sequence[Any],
    asked: Asked,
) -> PhaseData:  # fmt: skip
    """Return data with these kernels, each with the number of its constants, and endings.

    ``sizes``    numbers of active conditions, of all, and of contacts that slip, which there is room for
    """
    scene, model, pattern, own, n = (
        phase.scene, phase.model, phase.scene.candidates.pattern, phase.own, phase.model.n_u,
    )  # fmt: skip
    active, conditions, slipping = sizes
    parts = {
        "q_dot": model.n_q, "free": n, "scale": n, "L": len(pattern.below), "load": 1, "residual": len(own),
        "rate": len(own), "gamma": len(own), "own_G": len(own) * n,
    }  # fmt: skip
    state = {"state": model.n_q + n, "udot": n, "force": scene.rows, "multiplier": scene.candidates.own}
    constants = {f"of_{name}": 0 for name in ("machine", "values", "power", "bearings", "derived")}
    constants |= {f"of_{name}": size for name, (_, size) in kernels.items()}
    data = PhaseData.made(
        n_q=model.n_q, n=n, contacts=len(phase.modes), rows=scene.rows, pairs=len(pattern.pairs), own=len(own),
        all_own=scene.candidates.own, endings=len(endings), held_count=sum(scene.held),
        compliant_count=sum(scene.compliant), adhesive_count=sum(scene.adhesive), driven=int("power" in kernels),
        loaded_count=len(scene.loaded), laws=scene.laws, of_bearing=LOADED * len(scene.loaded),
        loaded_squared=len(scene.loaded) ** 2,
        machine_outputs=sum(parts.values()), pair_outputs=sum(pattern.pairs), contact_outputs=sum(pattern.sizes),
        of_y=model.n_q + n + 2, extended_state=sum(state.values()), after_speeds=n + 1, entries_of_L=len(pattern.below),
        entries_of_W=len(pattern.columns), most_conditions=conditions, most_active=active,
        equations=padded(active + 1), width=padded(n),
        asked=sum(map(len, asked)), of_inputs=model.n_q + n + len(asked),
        rows_of_G_and_K=conditions + slipping, after_conditions=conditions + 1,
        blocks=len(pattern.blocks.starts) - 1, of_contacts_twice=2 * len(phase.modes), **constants,
    )  # fmt: skip
    names = [contact.name for contact in model.contacts]
    terms = [(names.index(k), NAMES.index(what), j, at) for at, one in enumerate(asked) for k, what, j in one]
    if terms:
        data.of_contact[:], data.what[:], data.component[:], data.into[:] = np.array(terms).T
    _part(data, parts)
    _part(data, state)
    for name, (address, _) in kernels.items():
        setattr(data, name, address)
    kinds = rows(model)
    data.number[:], data.on_coordinates[:] = own, [not kinds[i].on_speeds for i in own]
    data.owner[:], data.place[:] = [end.contact for end in endings], [end.place for end in endings]
    return data


def _part(data: PhaseData, sizes: Mapping[str, int]) -> None:
    """Give each name its part of the row of the first one."""
    first, *others = sizes
    whole, at = getattr(data, first), sizes[first]
    for name in others:
        part = whole[at : at + sizes[name]]
        setattr(data, name, part.reshape(-1, data.n) if data.fields[name].kind == "Rows" else part)
        at += sizes[name]


def _write_pattern(data: PhaseData, phase: Any, program: Any) -> None:
    """Write the kernels of the contacts, and the places in their outputs."""
    scene, pattern = phase.scene, phase.scene.candidates.pattern
    data.gaps_of[:] = [program.address(f"pair {p}") for p in range(data.pairs)]
    for k in scene.candidates.groups:
        data.touching[k] = program.address(f"contact {k}")
    data.gaps_at[:], data.touch_at[:] = (_before(sizes) for sizes in (pattern.pairs, pattern.sizes))
    data.order[:], data.starts[:], data.below[:] = pattern.order, pattern.starts, pattern.below
    data.columns[:], data.first[:], data.tangents[:] = pattern.columns, scene.first, scene.tangents
    of = ContactPattern(*np.array(pattern.contacts, dtype=np.int64).reshape(-1, 7).T)
    data.gap_at[:], data.reaches[:], at = data.gaps_at[of.pair] + of.gap, of.reaches, data.touch_at
    data.laws_at[:], data.rates_at[:], data.biases_at[:] = at + of.laws, at + of.rates, at + of.biases
    data.away_at[:], data.held[:], data.compliant[:] = at + of.away, scene.held, scene.compliant
    data.presser[:], data.loaded[:] = scene.presser, scene.loaded
    place = np.argsort(pattern.order)  # of each speed
    for b, (first, last) in enumerate(pairwise(pattern.blocks.starts)):
        data.block_low[b] = place[first:last].min(initial=data.n)
        data.block_high[b] = 1 + place[first:last].max(initial=-1)
    data.beside_of[:], data.own_block[:] = np.ravel(pattern.blocks.contacts), pattern.blocks.own
    data.rough[:] = [not contact.frictionless for contact in phase.model.contacts]
    data.side[:] = data.first_end[:] = data.next_end[:] = -1
    for k, ((side, _),) in scene.ends.items():
        data.side[k], data.next_end[k], data.first_end[side] = side, data.first_end[side], k
    data.entry[:], data.entries[:], place = np.array(pattern.rows, dtype=np.int64).reshape(-1, 3).T
    data.W_at[:] = np.repeat(at, 1 + data.tangents) + place


def _before(sizes: Any) -> Any:
    """Return the place of each of several parts that follow each other."""
    return np.cumsum([0, *sizes[:-1]]) if sizes else []
