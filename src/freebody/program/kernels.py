"""Machine code of recorded functions: from a tape to kernels (`kernel`), compiled or from the disk."""

from __future__ import annotations

import hashlib
from array import array
from collections import Counter
from collections.abc import Mapping, Sequence
from time import perf_counter
from typing import Any, NamedTuple

from ..errors import ExpressionError
from ..native import cache, codegen, sources
from ..native.target import named
from ..scalar.algebra import Scalar
from ..scalar.trace import NAMES, Tape, Traced
from .code.emit import Form, Module
from .code.lower import PROLOGUE, RECIPROCAL, Program, lower
from .kernel import KernelSet
from .series.jet import jet
from .series.jet_of_lanes import jet_of_lanes


class Recorded(NamedTuple):
    """Functions of a tape, and the inputs that they depend on."""

    tape: Tape
    functions: Mapping[str, Sequence[Scalar]]
    time: Traced | None
    state: Sequence[Traced]
    parameters: Sequence[Traced]


class Choices(NamedTuple):
    """What code of functions is wanted, as for `compile_tape`; by default kernels for one state."""

    batch: Sequence[str] = ()
    series: Mapping[str, int] = {}
    form: Form | None = None


_KERNELS = Choices()


def compile_tape(
    tape: Tape,
    functions: Mapping[str, Sequence[Scalar]],
    time: Traced | None,
    state: Sequence[Traced],
    parameters: Sequence[Traced],
    batch: Sequence[str] = (),
    series: Mapping[str, int] | None = None,
    form: Form | None = None,
) -> KernelSet:
    """Machine code of functions of time, state and parameters.

    Parameters
    ----------
    tape : Tape
    functions : mapping
        Name -> outputs, scalars of the tape or numbers.
    time, state, parameters
        Inputs of the tape. Each input that the outputs need must be among them.
    batch : sequence of names
        Functions that also get code for many states at once.
    series : mapping, optional
        Name -> length of a row, for functions that are rates of the state. Their kernels return the Taylor coefficients
        of the solution instead (`jet`), for eight states at once if the name is in ``batch`` too.
    form : Form, optional
        Arguments of functions that a loop calls by their address in place of kernels.

    Returns
    -------
    KernelSet
        Loaded from the disk if the same program was compiled before.
    """
    names = list(functions)
    unknown = [name for name in batch if name not in functions]
    if unknown:
        raise ExpressionError(
            f"Expected names of functions in batch, got {unknown}. Known: {', '.join(names)}."
        )
    recorded = Recorded(tape, functions, time, state, parameters)
    choices = Choices(batch, series or {}, form)
    key = program_key(recorded, codegen.THIS, choices)
    stored = cache.load(key)
    if stored is not None and not (
        stored[0].get("target") == codegen.version() and key.encode() in stored[1]
    ):
        stored = None  # code of another program or processor: it must not run
    if stored is None:
        start = perf_counter()
        header, code = _compile(recorded, choices, key)
        header["seconds"] = perf_counter() - start
        cache.store(key, header, code)
    else:
        header, code = stored
    return KernelSet(
        header, codegen.Library(code), names, len(state), len(parameters), batch, stored is not None, len(code),
        form.lanes if form else 1,
    )  # fmt: skip


def machine_text(recorded: Recorded, target: str) -> tuple[dict[str, Any], str]:
    """Return functions as LLVM's text for a target (`native.target.NAMES`), after what is known of them.

    The text defines ``prologue`` and, in the order of the functions, ``f0``, ``f1``, ... with the kernel's signature.
    """
    header, module = _module(recorded, lower(*recorded), target)
    return header, module.text()


def _compile(recorded: Recorded, choices: Choices, key: str) -> tuple[dict[str, Any], bytes]:
    """Compile functions to what the cache stores: a header and the object code."""
    alone = recorded.functions if choices.form is not None else {*choices.batch, *choices.series}
    header, module = _module(recorded, lower(*recorded, alone), codegen.THIS, choices)
    module.functions.append(f'@freebody.key = constant [{len(key)} x i8] c"{key}"\n')
    return header, codegen.object_code(module.text())


def _module(
    recorded: Recorded, program: Program, target: str, choices: Choices = _KERNELS
) -> tuple[dict[str, Any], Module]:
    """Return the header and the module of a program for a target."""
    (batch, series, form), functions = choices, recorded.functions
    module = Module(named(target).triple, codegen.layout(target), codegen.fused(target))
    hoisted = len(program.given)
    prologue = program.bodies[PROLOGUE]
    module.add(program, prologue, "prologue")
    if batch:
        module.add(program, prologue, "prologue", lanes=8)
        module.add_batch("prologue", len(recorded.parameters), 0, hoisted)
    rooms: dict[str, int] = {}
    symbols = {name: f"f{k}" for k, name in enumerate(functions)}
    for k, (name, outputs) in enumerate(functions.items()):
        if form is not None:
            module.add_formed(program, program.bodies[name], f"f{k}", form, k)
            continue
        if name in series:
            if name in batch:
                rooms[name] = jet_of_lanes(module, program, name, f"f{k}.lanes")
            else:
                jet(module, program, name, f"f{k}", series[name])
            continue
        if name in program.kinds:
            module.add_shared(program, program.kinds[name], name, symbols)
            continue
        module.add(program, program.bodies[name], f"f{k}")
        if name in batch:
            module.add(program, program.bodies[name], f"f{k}", lanes=8)
            module.add_batch(f"f{k}", len(recorded.state), hoisted, len(outputs))
    header = {
        "target": codegen.version(target),
        "hoisted": hoisted,
        "outputs": {name: len(outputs) for name, outputs in functions.items()},
        "rooms": rooms,
        "operations": {name: _operations(program, name) for name in program.bodies},
    }
    return header, module


def _operations(program: Program, name: str) -> dict[str, int]:
    body = program.bodies[name]
    counts = Counter(program.op[i] for i in body.order if i >= 0)
    by_name: Counter[str] = Counter()
    for code, count in counts.items():
        by_name["div" if code == RECIPROCAL else NAMES[code]] += count
    sines = sum(len(g.arguments) for g in body.groups)
    if sines:
        by_name["sincos"] = sines
    return dict(sorted(by_name.items()))


def program_key(recorded: Recorded, target: str, choices: Choices = _KERNELS) -> str:
    """Return a hash of functions for a target, and of the sources that compile them."""
    (tape, functions, time, state, parameters), (batch, series, form) = recorded, choices
    source = sources.identity(__name__.removeprefix("freebody."))
    digest = hashlib.sha256(f"{source} {codegen.version(target)} {NAMES} {form or ''}".encode())
    for values in (tape.op, tape.a, tape.b):
        digest.update(array("i", values).tobytes())
    digest.update(array("d", map(float, [*tape.constants, *tape.data.values()])).tobytes())
    digest.update(" ".join(tape.data).encode())
    inputs = [
        -1 if time is None else time.index,
        *(x.index for x in state),
        -2,
        *(x.index for x in parameters),
    ]
    digest.update(array("i", inputs).tobytes())
    for name, outputs in functions.items():
        places = [x.index if type(x) is Traced else -1 for x in outputs]
        numbers = [0.0 if type(x) is Traced else float(x) for x in outputs]
        digest.update(f"{name!r} {name in batch} {series.get(name)} {len(outputs)}".encode())
        digest.update(array("i", places).tobytes() + array("d", numbers).tobytes())
    return digest.hexdigest()
