"""A live motion as a WebAssembly module: `live.simulate`, the functions of the machine, and their memory.

The module has one exported function, ``simulate(address)``, over one record (`memory.Live`) at a fixed address of the
exported memory. Addresses in the memory are written here, so that a caller computes none.
"""

from __future__ import annotations

import hashlib
from typing import Any

from ...native import cache, sources
from ...native.records import Record
from ...program.export.wasm import WasmModule
from ...program.export.wasm_linking import base_of_image, linked
from ...program.export.wasm_object import TARGET, optimised, version, wasm_object
from ...program.kernels import Recorded, machine_text, program_key
from .machine import LiveMachine
from .memory import READ

MODULE = "motion.live.live"
EXPORT = "simulate"
CALLED = (
    "piece", "find", "collided", "looked", "rate", "rates", "projection", "acceleration", "force", "watched", "derived",
)  # fmt: skip
"""Functions that the loop of a machine with contacts calls by their addresses."""
KIND = {"Real": "real", "Row": "real", "Rows": "real", "Whole": "whole", "Wholes": "whole"}


def module_of(
    machine: LiveMachine, outputs: tuple[str, ...] = (), answers: tuple[str, ...] = ()
) -> WasmModule:
    """Return the module of a machine; ``outputs`` and ``answers`` are the names of these numbers."""
    setting, model = machine.setting, machine.model
    header, code = _object(machine)
    names = list(machine.functions)
    called = CALLED if machine.touching is not None else ()
    table = ["prologue", *(f"f{k}" for k in range(len(names))), *called]
    addresses = {name: k for k, name in enumerate(["prologue", *names, *called], 1)}
    live = machine.memory(addresses, header["hoisted"])
    base = base_of_image(code)
    touching = machine.touching
    others: tuple[Record, ...] = (machine.hoisted,)
    if touching is not None:
        data = touching.of_phase.data, touching.of_looking.data
        others += (touching.run, touching.problem, *data, *touching.laws)
    image = live.image_at(base, others)
    module = linked(code, [EXPORT], table, image, len(image))
    places = live.places_of(*READ)
    return WasmModule(
        code=module.code,
        address=base,
        fields={name: (base + place, KIND[kind], shape) for name, (place, kind, shape) in places.items()},
        imports=module.imports,
        parameters=machine.names,
        state=machine.state_names,
        outputs=outputs,
        events=tuple(spec.name for spec in setting.specs),
        answers=answers,
        conditions=tuple(row.name for row in machine.kinds),
        contacts=tuple(contact.name for contact in model.contacts),
        assumed=tuple(str(expression).replace("**", "^") for expression in model.assumed),
    )


def _object(machine: LiveMachine) -> tuple[dict[str, Any], bytes]:
    """Header of the functions, and the object of the loop and the functions, from the disk or compiled now."""
    tape = Recorded(machine.tape, machine.functions, machine.state.t, machine.inputs, machine.parameters)
    needs = bool(machine.setting.kernels.active), machine.touching is not None
    key = _key(program_key(tape, TARGET), needs)
    stored = cache.load(key)
    if stored is not None:
        return stored
    header, text = machine_text(tape, TARGET)
    code = wasm_object(_loop(needs), text)
    cache.store(key, header, code)
    return header, code


def _loop(needs: tuple[bool, bool]) -> bytes:
    """The loop, from the disk or compiled now, the same for all machines with the same needs: constraints, contacts."""
    key = _key("loop", needs)
    stored = cache.load(key)
    if stored is not None:
        return stored[1]
    from ...native.translation import translated  # imported late: not needed if the code is on the disk
    from .live import called, functions

    wanted = {EXPORT: functions(*needs)[EXPORT], **(called() if needs[1] else {})}
    code = optimised(translated(wanted))
    cache.store(key, {}, code)
    return code


def _key(what: str, needs: tuple[bool, bool]) -> str:
    """Hash of the functions, of the loop, and of the sources that compile them."""
    source = sources.identity(MODULE, __name__.partition(".")[2])
    return hashlib.sha256(f"wasm {what} {needs} {source} {version()}".encode()).hexdigest()
