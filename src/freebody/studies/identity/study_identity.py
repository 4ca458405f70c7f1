"""Identity of a study: a digest of all that its results depend on, and of nothing else.

The content counts (`content_digest`), not where it is computed: the machine with its constants and controllers, the
values and initial values of all lanes, times, outputs, events, blows and options as they are after reading, and the
sources that compute. Left out are threads, executors and processors, and the versions of the libraries below, which
change no result beyond round-off.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from copy import copy
from dataclasses import fields
from functools import cache
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from ...describe.body import Body
from ...describe.controller import Controller
from ...describe.description import Parameter
from ...describe.joints.joint import Joint
from ...errors import SimulationError
from ...model import Model
from ...motion.batch.job import Job
from ...motion.ode.loops import label
from ...motion.start.arguments import is_number
from .content_digest import NoContentError, digest

_NAMED = (Body, Joint, Parameter)
"""Types to which the rest of a machine refers: their content is in the links, their values in those of the lanes."""
_ROOMS_LEFT_OUT = ("cli", "exact", "formats", "gallery", "picture")
"""Rooms whose sources change no result."""


def identity(job: Job) -> str:
    """Return the digest of a study.

    Parameters
    ----------
    job : Job
        The study, read and checked.

    Raises
    ------
    SimulationError
        A controller that holds an object whose content cannot be read, such as an open file.
    """
    return digest(parts(job))


def parts(job: Job, law: Any = None) -> dict[str, str]:
    """Return the digests of the parts of a study, by the name of the part.

    A ``law`` stands for the values that vary, of which the job of a study holds some lanes only.
    """
    model, lanes, request = job.kernels.model, job.lanes, job.request
    varied = () if law is None else lanes.varied[0] + lanes.varied[1]
    aliases = _aliases(model)

    def of(value: Any) -> str:
        try:
            return digest(value, _NAMED, aliases)
        except NoContentError as error:
            raise SimulationError(
                f"Expected numbers, expressions and points for a study that is stored in a file, got {error.args[0]!r}."
            ) from None

    machine = [
        getattr(model, x.name) for x in fields(Model) if x.compare and x.name not in ("names", "controllers")
    ]
    columns = [
        (aliases.get(name, name), np.array(x, dtype=float))
        for name, x in lanes.columns.items()
        if name not in varied
    ]
    events = [(x.name, x.direction, x.terminal) for x in job.specs]
    initial = {name: x for name, x in lanes.initial.items() if name not in varied}
    starts = [_by_name(model, x) for x in (initial, request.near)]
    method = [label(request.method), request.step, request.longest_step, request.max_steps, job.tolerances]
    return {
        "machine": of(machine),
        "controllers": digest([_controller(controller, aliases) for controller in model.controllers]),
        "signals": of([vars(placed.signal) for placed in model.signals]),
        "values": of([job.count, lanes.varied, columns]),
        **({} if law is None else {"lanes": of(law)}),
        "starts": of([*starts, bool(request.project)]),
        "times": of([job.begin, job.end, job.times]),
        "outputs": of(job.outputs),
        "events": of([events, job.expressions]),
        "blows": of(request.impulses),
        "method or tolerance": of([*method, request.impacts, request.indeterminate]),
        "derivatives": of(job.unknowns),
        "version of freebody": version(),
    }


def _aliases(model: Model) -> dict[str, str]:
    """Return names of the constants of signals by their order: unnamed signals have other names in each process."""
    return {
        symbol.name: f"constant {k} of signal {i}"
        for i, placed in enumerate(model.signals)
        for k, symbol in enumerate(placed.symbols)
    }


def _by_name(model: Model, values: Any) -> Any:
    """Return values in the order of their names, numbers as floats."""
    if not isinstance(values, Mapping):
        return values
    named = {model.names.text_of(key): x for key, x in values.items()}
    # copies, since one array used twice has the content of two arrays
    return [
        (name, float(x) if is_number(x) else copy(x)) for name, x in sorted(named.items(), key=itemgetter(0))
    ]


def _controller(controller: Controller, aliases: Mapping[str, str]) -> str:
    """Return the digest of a controller as a run finds it: reset, if it has a ``reset``."""
    reset = getattr(controller.function, "reset", None)
    if callable(reset):
        reset()
    law = digest([controller.name, controller.period, controller.inputs, controller.sensors], (), aliases)
    try:
        return digest([law, controller.function])
    except NoContentError as error:
        value, _, *where = error.args
        inside = f" (in {', in '.join(where[:-1][-3:])})" if where[:-1] else ""
        raise SimulationError(
            f"Expected a controller whose content can be read, so that another controller cannot continue a file of "
            f"results, but '{controller.name}' holds a {type(value).__module__}.{type(value).__qualname__}{inside}. "
            "Open or make it within the function, or leave out store=."
        ) from None


@cache
def version() -> str:
    """Return the digest of the sources that compute."""
    package = Path(__file__).parents[2]
    result = hashlib.sha256()
    for file in sorted(package.rglob("*.py")):
        where = file.relative_to(package)
        if where.parts[0] not in _ROOMS_LEFT_OUT:
            content = file.read_bytes()
            result.update(f"{where.as_posix()} {len(content)}\n".encode() + content)
    return result.hexdigest()
