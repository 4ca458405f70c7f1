"""The computed path of a motion, and all quantities that follow from it, computed when needed.

What differs between motions in legs, with contacts and in time steps is in their `course`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.indeterminate import indeterminate
from ...dynamics.conditions.unilateral import Limit, MotionWarning, limits
from ...dynamics.motion import transmitting
from ...dynamics.state import float_state
from ...errors import SimulationError, nearest
from ..ending import NOT_PHYSICAL, End
from ..kernels.kernels import Kernels
from ..kernels.program import Program
from .contact_expressions import note_of, of_contacts
from .course import Course
from .event import Event, EventList, EventSpec, Happening
from .one_sided_limits import Span, spans, warnings_of
from .path import SampledPath
from .quantities import BodyPose, ByName, Energy, Reaction

Array = NDArray[np.float64]
_FEWEST, _MOST = 401, 4001  # number of output times if none are given


class StateView(Mapping[str, Any]):
    """Coordinates and speeds by name, at one time or at several times."""

    def __init__(self, trajectory: ComputedMotion, t: Any, y: Array) -> None:
        model = trajectory.kernels.model
        self.t = t
        self.q = y[..., : model.n_q]
        self.u = y[..., model.n_q : model.n_q + model.n_u]
        self._trajectory = trajectory
        self._y = y

    def __getitem__(self, name: Any) -> Any:
        value = self._y[..., self._trajectory.place(name)]
        return float(value) if value.ndim == 0 else value

    def __iter__(self) -> Iterator[str]:
        return iter(self._trajectory.names)

    def __len__(self) -> int:
        return len(self._trajectory.names)

    def __repr__(self) -> str:
        if np.ndim(self.t):
            return f"<States at {len(self.t)} times of {', '.join(self)}>"
        return f"<State at t = {self.t:g} s: {', '.join(f'{name} = {self[name]:g}' for name in self)}>"


class ComputedMotion:
    """Path of a motion, and the quantities that follow from it.

    :class:`~freebody.motion.trajectory.trajectory.Trajectory` adds the quantities by name, files and pictures.
    """

    def __init__(
        self,
        kernels: Kernels,
        values: Mapping[str, float],
        path: SampledPath,
        specs: Sequence[EventSpec],
        tolerances: Array,
        times: Array | None = None,
        samples: int | None = None,
        *,
        course: Course,
    ) -> None:
        self.kernels = kernels
        self.numbers = dict(values)
        self.values = kernels.model.given(self.numbers)
        self.path = path
        self.specs = tuple(specs)
        self.tolerances = tolerances
        self._times_and_samples = times, samples
        self.initial: dict[Any, Any] = {}
        self.near: dict[Any, Any] = {}
        self.course = course

    def begun(self, initial: Mapping[Any, Any] | None, near: Mapping[Any, Any] | None) -> Self:
        """Note the initial values and guesses that were given, and return the motion."""
        self.initial, self.near = dict(initial or {}), dict(near or {})
        return self

    def __getstate__(self) -> dict[str, Any]:
        """Keep the path and the states at the output times; all other quantities can be computed again."""
        with suppress(ValueError):  # a failed run may have no values between its steps
            self.states  # noqa: B018
        kept, computed = ("t", "states"), self._computed
        return {name: x for name, x in self.__dict__.items() if name in kept or name not in computed}

    @property
    def _computed(self) -> set[str]:
        """Names of the quantities that are computed when they are first asked for."""
        entries = (item for kind in type(self).__mro__ for item in vars(kind).items())
        return {name for name, entry in entries if isinstance(entry, cached_property)}

    def __copy__(self) -> Self:
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)
        return other

    @cached_property
    def _parameters(self) -> Array:
        return self.kernels.parameters(self.numbers)

    @cached_property
    def t(self) -> Array:
        """Output times [s], shape (n,)."""
        return _output_times(self.path, *self._times_and_samples)

    # -- states -----------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the machine."""
        return self.kernels.model.name

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates and speeds."""
        return self.kernels.model.state_names

    @property
    def status(self) -> str:
        """How the run ended: finished, terminal event, interrupted, or why it failed.

        "not physical" is added if there are :attr:`warnings`.
        """
        return f"{self.path.status}, {NOT_PHYSICAL}" if self.warnings else str(self.path.status)

    @property
    def has_work(self) -> bool:
        """True if the work done is a component of the state."""
        return self.course.works(self)

    @property
    def interrupted(self) -> bool:
        """True if Ctrl-C stopped the run before its end."""
        return self.path.status == End.INTERRUPTED

    @property
    def steps(self) -> int:
        """Number of accepted steps."""
        return self.path.steps

    @cached_property
    def states(self) -> Array:
        """Coordinates, speeds (and work) at the output times, shape (n, ...)."""
        return self.path.sample(self.t)

    def place(self, name: Any) -> int:
        """Return the index in the state of a coordinate or speed, given by name or SymPy atom."""
        text = self.kernels.model.names.text_of(name)
        if text not in self.names:
            raise SimulationError(f"Unknown name '{text}'; {nearest(text, self.names)}")
        return self.names.index(text)

    def _rates(self) -> Array:
        """Rates of the state at the output times."""
        return self.course.quantity(self, "rates")

    def at(self, t: ArrayLike) -> StateView:
        """Return coordinates and speeds at any time of the run, as accurate as the steps of the run.

        Parameters
        ----------
        t : float or array (k,)
            Time within the run [s].

        Returns
        -------
        StateView
            Values by name, ``["theta"]``; ``.q`` and ``.u`` hold all of them.
        """
        try:
            times = np.asarray(t, dtype=float)
        except (TypeError, ValueError):
            raise SimulationError(f"Expected a time of the run, or several [s], got {t!r}.") from None
        try:
            y = self.path.sample(times.reshape(-1))
        except ValueError as error:
            raise SimulationError(str(error)) from None
        y = y.reshape(*times.shape, y.shape[-1])
        return StateView(self, float(times) if times.ndim == 0 else times, y)

    @cached_property
    def events(self) -> EventList:
        """Events that happened, in their order: events of the user, passings of the limit of a one-sided constraint
        (:attr:`warnings`), and :attr:`happenings`. ``print`` shows a sentence for each.
        """
        model = self.kernels.model
        watched = [of_contacts(model, spec.expression, "an event") for spec in self.specs]
        crossings = [
            Event(
                crossing.time,
                self.specs[crossing.number].name,
                crossing.sign,
                dict(zip(self.names, crossing.state.tolist(), strict=False)),
                note=note_of(model, watched[crossing.number], self.path, crossing.time),
            )
            for crossing in self.path.crossings
        ]
        events = [*crossings, *self._passings(), *self.happenings]
        return EventList(sorted(events, key=lambda event: self._sense * event.time))

    @property
    def happenings(self) -> tuple[Happening, ...]:
        """Blows, impacts and changes of contact modes or of active conditions, in their order."""
        return self.course.happenings

    @property
    def _sense(self) -> float:
        return 1.0 if self.path.end >= self.path.start else -1.0

    # -- one-sided constraints ----------------------------------------------------------------------------------

    @cached_property
    def _limits(self) -> tuple[Limit, ...]:
        return limits(self.kernels.model)

    @cached_property
    def _passed(self) -> list[Span]:
        """Parts of the run in which a one-sided constraint is beyond its limit."""
        return spans(self.course.limit_pieces(self), len(self._limits)) if self._limits else []

    def _passings(self) -> Iterator[Happening]:
        for span in self._passed:
            limit = self._limits[span.limit]
            state = self.path.sample([span.begin])[0].tolist()
            yield Happening(
                span.begin, limit.event, -1, dict(zip(self.names, state, strict=False)),
                f"{limit.constraint}: from here on {limit.what}",
            )  # fmt: skip

    @cached_property
    def warnings(self) -> tuple[MotionWarning, ...]:
        """Parts of the motion that are not physical: a rope that pushes, a plane that pulls a wheel down, a blow that
        does, what comes behind a side, time steps that make energy.

        The run keeps the constraints as they are described. Each warning says from when on the answer is therefore not
        physical, how far the limit is passed, and what to do. Warnings are computed on first use of this attribute, of
        :attr:`events` or of :attr:`status`.
        """
        warnings = (*warnings_of(self._limits, self._passed), *self.course.warnings(self))
        return tuple(sorted(warnings, key=lambda warning: self._sense * warning.time))

    # -- derived quantities -------------------------------------------------------------------------------------------

    def _observed(self, program: Program, function: str, times: Array, states: Array) -> Array:
        """Return the outputs of a function of a program at states."""
        return self.course.observed(self, program, function, times, states)

    @cached_property
    def energy(self) -> Energy:
        """Energy ledger at the output times.

        ``work`` includes that of blows and impacts (``impulses``) and of the friction of contacts (``friction``).
        """
        return self.course.energy(self)

    @cached_property
    def poses(self) -> dict[str, BodyPose]:
        """Position and rotation of every body."""
        poses = self._observed(self.kernels.poses(), "poses", self.t, self.states)
        n = len(self.t)
        return ByName(
            "body",
            {
                name: BodyPose(
                    poses[:, 12 * i : 12 * i + 3], poses[:, 12 * i + 3 : 12 * i + 12].reshape(n, 3, 3)
                )
                for i, name in enumerate(self.kernels.model.bodies)
            },
        )

    @cached_property
    def reactions(self) -> dict[str, Reaction]:
        """Force and moment of every joint on its child, about the joint's point on the child, in ground axes.

        Joints that close loops and rolling wheels (about the centre of the wheel) are included. Reactions that are
        :attr:`indeterminate` are one of many solutions: the constraints declared last carry no force, and no force
        presses teeth apart if their pressure angle is not given. In time steps they are means over a step.
        """
        reactions = self.course.quantity(self, "reactions")
        return ByName(
            "joint",
            {
                name: Reaction(
                    reactions[:, 6 * i : 6 * i + 3], reactions[:, 6 * i + 3 : 6 * i + 6], on, about
                )
                for i, (name, on, about) in enumerate(transmitting(self.kernels.model))
            },
        )

    @cached_property
    def multipliers(self) -> dict[str, Array]:
        """Constraint forces by name, shape (n,): components of loop-closing joints, tensions of ropes, forces of
        conditions on coordinates and speeds.
        """
        multipliers = self.course.quantity(self, "multipliers")
        names = [row.name for row in rows(self.kernels.model)]
        return ByName("constraint", {name: multipliers[:, i] for i, name in enumerate(names)})

    @property
    def indeterminate(self) -> tuple[str, ...]:
        """Names of reactions that the motion does not determine: of redundant constraints, of gears and of contacts.

        A planar linkage of rigid parts has such reactions: forces out of its plane depend on how its pins were fitted.
        Names are those of :attr:`multipliers`; for other joints ``A_z`` is the force of joint A along the ground's z,
        ``A_Mx`` its moment about x. They are found by rank at the start. Their values in :attr:`reactions` are one of
        many solutions.
        """
        model = self.kernels.model
        y = self.path.states[0]
        q, u = y[: model.n_q].tolist(), y[model.n_q : model.n_q + model.n_u].tolist()
        by_rank = indeterminate(model, float_state(model, q, u, self.path.start, self.values))
        return (*by_rank, *self.course.indeterminate)

    # -- contacts ---------------------------------------------------------------------------------------------------

    @cached_property
    def contacts(self) -> Mapping[str, Any]:
        """Gap, forces, slip and mode of every contact, by name; in time steps, forces are means over a step."""
        return self.course.contacts(self)

    @cached_property
    def modes(self) -> Sequence[Any]:
        """Modes of every contact, with their times and the reasons why they began, printed one per line."""
        return self.course.modes(self)

    @property
    def residual(self) -> float:
        """Greatest rate by which a contact violated its laws in any decision, impact or time step, relative to the
        greatest rate of a contact there: accelerations in decisions, else speeds.

        In a time step this is the greatest contact speed without contact forces, taken as Σ |W| |u|, the sum of the
        terms of a contact's speed without their signs.
        """
        found = self.course.residual
        if found is None:
            raise SimulationError(
                f"Expected a motion with contacts for trajectory.residual, got '{self.name}' without."
            )
        return found

    # -- time steps -------------------------------------------------------------------------------------------------

    @property
    def step(self) -> float:
        """Length of the steps of a motion by ``method="timestepping"`` [s]."""
        return float(self._of_steps("step"))

    @property
    def depth(self) -> float:
        """Greatest penetration at the end of any time step [m]."""
        return float(self._of_steps("depth"))

    @property
    def sweeps(self) -> float:
        """Mean number of sweeps per time step."""
        return float(self._of_steps("sweeps"))

    @property
    def reduced(self) -> int:
        """Number of time steps in which contacts rebounded by less than Newton's law of restitution says.

        With friction the law would have made energy there (Kane), as in an impact whose event says so.
        """
        return int(self._of_steps("reduced"))

    def _of_steps(self, name: str) -> float:
        """Return a measure of a motion in time steps."""
        if self.course.stepping is None:
            raise SimulationError(
                f'Expected a motion by method="timestepping" for trajectory.{name}, got one by method='
                f'"{self.path.method}".'
            )
        return float(getattr(self.course.stepping, name))

    # -- derivatives --------------------------------------------------------------------------------------------------

    @cached_property
    def sensitivity(self) -> Any:
        """Derivatives by (quantity, parameter or initial value) of a motion with ``sensitivities=``."""
        if self.course.derivatives is None:
            raise SimulationError(
                "Expected a motion with derivatives for trajectory.sensitivity, got one without. Name what it depends "
                'on: fb.simulate(..., sensitivities=["m"]).'
            )
        return self.course.derivatives.of(self)


def _output_times(path: SampledPath, times: Array | None, samples: int | None) -> Array:
    """Return the output times: the given times that the run reached, or a regular grid with both ends."""
    if times is not None:
        first, last = min(path.start, path.end), max(path.start, path.end)
        return times[(times >= first) & (times <= last)]
    if path.start == path.end:
        return np.array([path.start])
    return np.linspace(path.start, path.end, samples or min(_MOST, max(_FEWEST, path.steps + 1)))
