"""What a call of `fb.simulate` asks for, checked once, and the initial value problem of one motion.

    y' = f(t, y, c(p)),    y(t₀) = y₀,    from t₀ to t₁

A `Request` is for one motion or for many; `route` names the way that answers it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SimulationError
from ..model import Model
from ..scalar.algebra import Expression
from .kernels.kernels import Kernels, kernels_of
from .kernels.methods import check_method, check_method_of_phases
from .ode.dense_output import Array
from .ode.tableau import OWN, RungeKutta
from .start.arguments import (
    STORED,
    check_numbers,
    check_steps,
    most_steps,
    output_times,
    tolerances_of,
)
from .start.initial import asks_for_many, initial_state, number
from .start.loop_closure import closed_start
from .start.signals import at_time, check_signals
from .trajectory.event import EventSpec, expressions_of, specs_of, switch_specs
from .trajectory.progress import Halt, Progress


@dataclass(frozen=True, eq=False)
class Request:
    """Arguments of :func:`freebody.simulate`, checked as far as they do not depend on the values of a lane.

    ``kernels``   programs of the machine
    ``many``      True if many motions are asked for
    """

    machine: Any
    until: Expression
    initial: Mapping[Any, Any] | None = None
    near: Mapping[Any, Any] | None = None
    project: bool = False
    values: Mapping[Any, Any] | None = None
    tolerance: float | Mapping[Any, float] = 1e-9
    events: Any = ()
    impulses: Any = ()
    impacts: str = "simultaneous"
    indeterminate: str = "compliance"
    method: str = "auto"
    step: float | None = None
    times: ArrayLike | None = None
    samples: int | None = None
    start: Expression = 0
    max_step: float | None = None
    max_steps: int | None = None
    progress: bool | Callable[[float], Any] | Halt | None = None
    outputs: Any = None
    store: Any = None
    threads: int | None = None
    executor: Any = None
    sensitivities: Any = None
    kernels: Kernels = field(init=False, repr=False)
    many: bool = field(init=False)

    @classmethod
    def of(cls, arguments: dict[str, Any]) -> Request:
        """Return the request of a call with these arguments, all of them; the machine is ``s``.

        The dictionary becomes that of the request: setting fields one by one takes longer than a short run.
        """
        arguments["machine"] = arguments.pop("s")
        request = object.__new__(cls)
        object.__setattr__(request, "__dict__", arguments)
        request.__post_init__()
        return request

    def __post_init__(self) -> None:
        if isinstance(self.method, RungeKutta):
            self.__dict__["method"] = self.method.name
        kernels, method = kernels_of(self.machine), self.method
        if not isinstance(method, str) or method != "timestepping":
            kernels = kernels.by_events()
        model = kernels.model
        self.__dict__["kernels"] = kernels
        self.__dict__["many"] = (
            self.outputs is not None
            or self.store is not None
            or self.executor is not None
            or asks_for_many(model, self.initial, self.values)
        )
        if self.threads is not None and self.executor is not None:
            raise SimulationError(
                "Expected threads= or executor=, got both: each block that an executor runs has one thread. Leave one "
                "out."
            )
        if model.contacts and method != "timestepping":
            check_method_of_phases(method, self.step)
        check_method(method, self.step)
        width = 1 if self.many else 1 + model.n_q + model.n_u
        check_numbers(self.times, self.samples, self.max_step, self.max_steps, width)
        _check_heeded(self)

    def __reduce__(self) -> Any:
        """Pickle what was asked for. Another process reads and checks it again."""
        asked = {x.name: getattr(self, x.name) for x in fields(self) if x.init}
        return _requested, ({**asked, "method": OWN.get(self.method, self.method)},)

    @property
    def model(self) -> Model:
        """The machine, assembled."""
        return self.kernels.model

    @property
    def struck(self) -> bool:
        """True if blows are asked for."""
        return not isinstance(self.impulses, tuple | list) or bool(self.impulses)

    @property
    def in_phases(self) -> bool:
        """True for a motion in phases from event to event: with contacts, or derivatives beside what interrupts it."""
        interrupted = self.sensitivities is not None and (self.struck or self.model.switched)
        return bool(self.model.contacts or interrupted) and self.method != "timestepping"

    @property
    def longest_step(self) -> float:
        """Length that no step exceeds."""
        return math.inf if self.max_step is None else float(self.max_step)


def _requested(arguments: Mapping[str, Any]) -> Request:
    return Request(**arguments)


def _check_heeded(request: Request) -> None:
    """Raise SimulationError for an argument without effect on this machine with this method."""
    model, method, near, project = request.model, request.method, request.near, request.project
    impacts, indeterminate = request.impacts, request.indeterminate
    if not (isinstance(impacts, str) and isinstance(indeterminate, str)):
        raise SimulationError(
            f"Expected impacts= and indeterminate= as words, got impacts={impacts!r}, indeterminate={indeterminate!r}."
        )
    usual = impacts == "simultaneous" and indeterminate == "compliance" and method != "timestepping"
    if usual and near is None and project is False:
        return
    if not isinstance(near, Mapping | None):
        raise SimulationError(f"Expected near values by name, such as {{'theta': 0.1}}, got {near!r}.")
    if not isinstance(project, bool | np.bool_):
        raise SimulationError(f"Expected project=True or False, got {project!r}.")
    of_constraints: dict[str, Any] = {"near": near, "project": project}
    of_contacts: dict[str, Any] = {
        "impacts": (impacts, "simultaneous"),
        "indeterminate": (indeterminate, "compliance"),
    }
    of_control: dict[str, Any] = {
        "tolerance": (request.tolerance, 1e-9),
        "max_step": (request.max_step, None),
    }
    for name, value in of_constraints.items():
        if value and not model.constraints:
            raise SimulationError(
                f"Expected a machine with constraints for {name}=, but '{model.name}' has none: it starts as initial= "
                "says. Leave it out."
            )
    for name, (value, default) in of_contacts.items():
        if value != default and not model.contacts:
            raise SimulationError(
                f"Expected a machine with contacts for {name}=, but '{model.name}' has none. Leave it out."
            )
        if value != default and method == "timestepping":
            raise SimulationError(
                f'Expected no {name}= for method="timestepping", got {value!r}: it solves all contacts of a step at '
                'once, and where several answers hold, takes one. Leave it out, or take method="auto".'
            )
    for name, (value, default) in of_control.items():
        if value != default and method == "timestepping":
            raise SimulationError(
                f'Expected no {name}= for method="timestepping", got {value!r}: all its steps have the length step=, '
                "whatever their error. Leave it out."
            )


@dataclass(eq=False, slots=True)  # not frozen: freezing costs the time of some steps of a small machine
class Problem:
    """Initial value problem of one motion.

    ``kernels``      programs of the machine, with the conditions that are independent at the start
    ``numbers``      value of every parameter, by name
    ``state``        (q, u) at ``begin``
    ``specs``        events, and ``expressions``, what they watch
    ``tolerances``   relative tolerance of each component of the state
    ``times``        output times, or None
    ``most_steps``   number of steps at which the run ends with an error
    """

    request: Request
    kernels: Kernels
    numbers: Mapping[str, float]
    state: Array
    begin: float
    end: float
    specs: tuple[EventSpec, ...]
    expressions: tuple[Expression, ...]
    tolerances: Array
    times: Array | None
    most_steps: int

    @property
    def model(self) -> Model:
        """The machine, assembled."""
        return self.kernels.model

    def progress(self) -> Progress:
        """Return the context in which the run shows how much of it is done."""
        return Progress(self.begin, self.end, self.request.progress)

    def outcome(self, path: Any) -> tuple[Any, ...]:
        """Return the arguments of the trajectory with a path."""
        return (
            self.kernels, self.numbers, path, self.specs, self.tolerances, self.times, self.request.samples
        )  # fmt: skip


def problem_of(request: Request) -> Problem:
    """Return the initial value problem of a request for one motion.

    Raises
    ------
    SimulationError
        An argument that the motion cannot use, or a start that does not exist.
    """
    kernels, model, method = request.kernels, request.model, request.method
    if request.threads is not None:
        raise SimulationError(
            f"Expected several motions for threads=, got one of '{model.name}', which runs in one thread. Leave it out."
        )
    numbers: Mapping[str, float] = kernels.values(request.values)
    begin = number(model, numbers, request.start, "start")
    numbers = at_time(model, numbers, begin)
    kernels.check(numbers)
    end = number(model, numbers, request.until, "until")
    most = most_steps(request.max_steps, STORED + model.n_q + model.n_u)
    if method != "timestepping":
        check_steps(begin, end, request.step, request.max_step, most)
    times = output_times(request.times, begin, end)
    specs = (*specs_of(request.events), *switch_specs(model))
    expressions = expressions_of(model, specs)
    check_signals(model)
    initial = {} if request.initial is None else request.initial
    if model.constraints:
        state, active = closed_start(
            kernels, numbers, initial, request.near or {}, begin, bool(request.project)
        )
        kernels = kernels.holding(active)
    else:
        state = initial_state(model, numbers, initial)
    tolerances = tolerances_of(kernels, request.tolerance, method)
    return Problem(
        request, kernels, numbers, state, begin, end, specs, expressions, tolerances, times, most
    )  # fmt: skip
