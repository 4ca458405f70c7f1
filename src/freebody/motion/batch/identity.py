"""Identity of a study: a digest of everything that its results depend on, and of nothing else.

It is the content that counts (`content`), not where it is computed: the machine with its constants and controllers, the
values and starts of all lanes, times, outputs, events, blows and options as they are after reading, and the sources
that compute. Left out is who computes: threads, executors, processors; and the versions of the libraries below, which
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
from ..start.arguments import is_number
from .content import NoContentError, digest

_NAMED = (Body, Joint, Parameter)
"""What the rest of a machine refers to: its content is in the links, its values in those of the lanes."""
_SHOWING = ("cli", "exact", "formats", "gallery", "picture")
"""Rooms whose sources change no result."""


def identity(job: Any) -> str:
    """Digest of a study.

    Parameters
    ----------
    job : batch.Job
        The study, read and checked.

    Raises
    ------
    SimulationError
        A controller that holds something of which no content can be read, such as an open file.
    """
    return digest(parts(job))


def parts(job: Any) -> dict[str, str]:
    """Digests of what makes up a study, by what it is called."""
    model, given, alone = job.kernels.model, job.given, job.alone
    aliases = _aliases(model)

    def of(value: Any) -> str:
        try:
            return digest(value, _NAMED, aliases)
        except NoContentError as error:
            raise SimulationError(
                f"Expected numbers, expressions and points for a study that is kept in a file, got {error.args[0]!r}."
            ) from None

    machine = [
        getattr(model, x.name) for x in fields(Model) if x.compare and x.name not in ("names", "controllers")
    ]
    columns = [(aliases.get(name, name), np.array(x, dtype=float)) for name, x in given.columns.items()]
    events = [(x.name, x.direction, x.terminal) for x in job.specs]
    starts = [_by_name(model, x) for x in (given.initial, alone["near"])]
    method = [job.method, job.step, job.longest, job.max_steps, job.tolerances]
    return {
        "machine": of(machine),
        "controllers": digest([_controller(one, aliases) for one in model.controllers]),
        "signals": of([vars(placed.signal) for placed in model.signals]),
        "values": of([given.count, given.varied, columns]),
        "starts": of([*starts, bool(alone["project"])]),
        "times": of([job.begin, job.end, job.wanted]),
        "outputs": of(job.asked),
        "events": of([events, job.expressions]),
        "blows": of(alone["impulses"]),
        "method or tolerance": of([*method, alone["impacts"], alone["indeterminate"]]),
        "version of freebody": version(),
    }


def _aliases(model: Model) -> dict[str, str]:
    """Names of the constants of signals by their order: a signal without a name has another in each process."""
    return {
        symbol.name: f"constant {k} of signal {i}"
        for i, placed in enumerate(model.signals)
        for k, symbol in enumerate(placed.symbols)
    }


def _by_name(model: Model, given: Any) -> Any:
    """Values by name, numbers as they are used."""
    if not isinstance(given, Mapping):
        return given
    named = {model.names.text_of(key): x for key, x in given.items()}
    # one array given twice is two arrays of one content
    return [
        (name, float(x) if is_number(x) else copy(x)) for name, x in sorted(named.items(), key=itemgetter(0))
    ]


def _controller(one: Controller, aliases: Mapping[str, str]) -> str:
    """Digest of a controller as a run finds it: begun anew, if it has a ``reset``."""
    begin = getattr(one.function, "reset", None)
    if callable(begin):
        begin()
    law = digest([one.name, one.period, one.inputs, one.sensors], (), aliases)
    try:
        return digest([law, one.function])
    except NoContentError as error:
        held, _, *where = error.args
        inside = f" (in {', in '.join(where[:-1][-3:])})" if where[:-1] else ""
        raise SimulationError(
            f"Expected a controller whose content can be read, so that a file of results is not gone on with by "
            f"another one, but '{one.name}' holds a {type(held).__module__}.{type(held).__qualname__}{inside}. Open or "
            "make it within the function, or leave out store=."
        ) from None


@cache
def version() -> str:
    """Digest of the sources that compute."""
    package = Path(__file__).parents[2]
    found = hashlib.sha256()
    for file in sorted(package.rglob("*.py")):
        where = file.relative_to(package)
        if where.parts[0] not in _SHOWING:
            content = file.read_bytes()
            found.update(f"{where.as_posix()} {len(content)}\n".encode() + content)
    return found.hexdigest()
