"""The data of a phase of contacts (`PhaseData`), made for a machine, and its functions with them as constants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...dynamics.conditions.constraints import rows
from ..ode.dense_output import Array
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
            data = PhaseData(self.data.copied_memory())
            self.set_parameters(data.memory, parameters)
            last = key, data
            self._last[:] = [last]
        return last[1].copied_memory()

    def set_parameters(self, c: Array, parameters: Array) -> None:
        """Write the constants of the kernels for these parameters into c."""
        for name, program in self.programs.items():
            place, _, (size,) = self.data.placed[f"{name}_c"]
            c[place : place + size] = program.constants(parameters)


def phase_data(phase: Any, programs: Mapping[str, tuple[Any, str]], endings: bool, whole: bool) -> PhaseData:
    """Return the data of a phase, before its modes are written.

    ``programs``   name of a kernel in the data -> its program, and its name there
    ``endings``    True if the end of the phase is watched
    ``whole``      True for room for all modes, which compiled code may write then
    """
    scene, model, pattern = phase.scene, phase.model, phase.scene.candidates.pattern
    own, n, m, E = phase.own, model.n_u, scene.rows, len(model.contacts)
    active, conditions = len(phase.active), len(own) + len(phase.conditions)
    slipping = sum(mode.partition(" ")[0] in SLIPPING for mode in phase.modes)
    if whole:
        active, conditions, slipping = min(len(own) + m, n), len(own) + m, E
    parts = {
        "q_dot": model.n_q, "free": n, "scale": n, "L": len(pattern.below), "load": 1, "residual": len(own),
        "rate": len(own), "gamma": len(own), "own_G": len(own) * n,
    }  # fmt: skip
    state = {"state": model.n_q + n, "udot": n, "force": m, "multiplier": scene.candidates.own}
    watched = scene.endings if endings else ()
    constants = {f"of_{name}": 0 for name in ("machine", "values", "power", "derived")}
    constants |= {f"of_{name}": program.compiled.hoisted for name, (program, _) in programs.items()}
    data = PhaseData.made(
        n_q=model.n_q, n=n, contacts=E, rows=m, pairs=len(pattern.pairs), own=len(own), all_own=scene.candidates.own,
        endings=len(watched), held_count=sum(scene.held), driven=int("power" in programs),
        machine_outputs=sum(parts.values()), pair_outputs=sum(pattern.pairs), contact_outputs=sum(pattern.sizes),
        extended_state=sum(state.values()), after_speeds=n + 1, entries_of_L=len(pattern.below),
        entries_of_W=len(pattern.columns), most_conditions=conditions, most_active=active,
        square_of_active=active * active, rows_of_G_and_K=conditions + slipping, **constants,
    )  # fmt: skip
    _part(data, parts)
    _part(data, state)
    for name, (program, function) in programs.items():
        setattr(data, name, program.address(function))
    _write_pattern(data, phase, programs["machine"][0])
    kinds = rows(model)
    data.number[:], data.on_coordinates[:] = own, [not kinds[i].on_speeds for i in own]
    data.owner[:], data.place[:] = [end.contact for end in watched], [end.place for end in watched]
    for k, mode in enumerate(phase.modes):
        data.direction[k, : len(mode.split()) - 1] = list(map(float, mode.split()[1:]))
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
    scene, contacts = phase.scene, phase.model.contacts
    pattern = scene.candidates.pattern
    data.gaps_of[:] = [program.address(f"pair {p}") for p in range(data.pairs)]
    data.touching[:] = [program.address(f"contact {k}") for k in range(data.contacts)]
    data.gaps_at[:], data.touch_at[:] = (_before(sizes) for sizes in (pattern.pairs, pattern.sizes))
    data.order[:], data.starts[:], data.below[:] = pattern.order, pattern.starts, pattern.below
    data.columns[:], data.first[:], data.tangents[:] = pattern.columns, scene.first, scene.tangents
    for k, (contact, one) in enumerate(zip(contacts, pattern.contacts, strict=True)):
        at = data.touch_at[k]
        data.gap_at[k], data.reaches[k] = data.gaps_at[one.pair] + one.gap, one.reaches
        data.laws_at[k], data.rates_at[k] = at + one.laws, at + one.rates
        data.biases_at[k], data.away_at[k] = at + one.biases, at + one.away
        data.rough[k], data.held[k] = not contact.frictionless, contact.held
    data.side[:] = -1
    for k, ((side, _),) in scene.ends.items():
        data.side[k] = side
    of_row = np.repeat(data.touch_at, 1 + data.tangents)
    for r, (start, size, place) in enumerate(pattern.rows):
        data.entry[r], data.entries[r], data.W_at[r] = start, size, of_row[r] + place


def _before(sizes: Any) -> Any:
    """Return the place of each of several parts that follow each other."""
    return np.cumsum([0, *sizes[:-1]]) if sizes else []
