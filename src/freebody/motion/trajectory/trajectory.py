"""The motion of a machine: the computed path, and all quantities that follow from it, computed when needed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy
from numpy.typing import ArrayLike, NDArray

from ...describe.pictures import picture
from ...dynamics.constraints import rows
from ...dynamics.indeterminate import indeterminate
from ...dynamics.state import float_state
from ...dynamics.unilateral import Limit, MotionWarning, limits
from ...errors import ExpressionError, SimulationError, nearest
from ..kernels.kernels import Kernels, Program
from ..ode.dense_output import INTERRUPTED, TERMINAL, Path, observe
from .event import Event, EventSpec, Happening
from .file_access import file_module
from .one_sided_limits import NOT_PHYSICAL, Span, Values, piece_of, spans, warnings_of
from .outputs import outputs_of, reduction

if TYPE_CHECKING:
    from pathlib import Path as FilePath

    import xarray

    from ...describe.system import System

Array = NDArray[np.float64]
_FEWEST, _MOST = 401, 4001  # number of output times if none are given


@dataclass(frozen=True, eq=False)
class Energy:
    """The energy ledger at the output times, each of shape (n,) [J].

    ``work`` is the work done since the start by loads without potential and by drives; ``residual`` is the error of the
    ledger, (T + V) - (T₀ + V₀) - W, zero except for the error of the integration. ``impulses`` is the part of the work
    done by blows and impacts, ``friction`` the part done by friction of contacts; each is None if there are none.
    """

    kinetic: Array
    potential: Array
    work: Array
    residual: Array
    impulses: Array | None = None
    friction: Array | None = None

    @property
    def total(self) -> Array:
        """Kinetic and potential energy."""
        return self.kinetic + self.potential

    @property
    def relative_residual(self) -> float:
        """Greatest residual, relative to the greatest kinetic energy, potential energy or work."""
        scale = max(float(np.max(np.abs(part))) for part in (self.kinetic, self.potential, self.work))
        worst = float(np.max(np.abs(self.residual)))
        return worst / scale if scale > 0 else worst


@dataclass(frozen=True, eq=False)
class Reaction:
    """Force and moment that a joint transmits, at the output times.

    ``force`` [N] and ``moment`` [N m], shape (n, 3), act **on** the body ``on``; the moment is **about** the point
    ``about``; components in the axes of ``frame``.
    """

    force: Array
    moment: Array
    on: str
    about: str
    frame: str = "ground"


@dataclass(frozen=True, eq=False)
class BodyPose:
    """Pose of a body at the output times: ``position`` (n, 3) of its origin in ground axes [m], ``rotation`` R_NB
    (n, 3, 3), and the unit ``quaternion`` (n, 4), scalar first, continuous in time.
    """

    position: Array
    rotation: Array

    @cached_property
    def quaternion(self) -> Array:
        """Unit quaternion (n, 4), scalar first, continuous in time."""
        return quaternions(self.rotation)


class StateView(Mapping[str, Any]):
    """Coordinates and speeds by name, at one time or at several times."""

    def __init__(self, trajectory: Trajectory, t: Any, y: Array) -> None:
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


class Trajectory:
    """The motion of a machine. Made by :func:`freebody.simulate`.

    ``trajectory["theta"]``, ``["theta'"]``, or any expression of the machine's names, gives an array over the output
    times ``t``. Energies, poses and reactions are computed on first use.

    Attributes
    ----------
    values : dict
        Values of all parameters.
    tolerances : ndarray
        Relative tolerance of each coordinate and speed.
    """

    def __init__(
        self,
        kernels: Kernels,
        values: Mapping[str, float],
        path: Path,
        specs: Sequence[EventSpec],
        tolerances: Array,
        times: Array | None = None,
        samples: int | None = None,
    ) -> None:
        self.kernels = kernels
        self.values = dict(values)
        self.path = path
        self.specs = tuple(specs)
        self.tolerances = tolerances
        self._times_and_samples = times, samples

    def __getstate__(self) -> dict[str, Any]:
        """Keep the path and the states at the output times; all other quantities can be computed again."""
        with suppress(ValueError):  # a failed run may have no values between its steps
            self.states  # noqa: B018
        computed = {
            name
            for kind in type(self).__mro__
            for name, entry in vars(kind).items()
            if isinstance(entry, cached_property)
        }
        return {
            name: x for name, x in self.__dict__.items() if name in ("t", "states") or name not in computed
        }

    def __copy__(self) -> Trajectory:
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)
        return other

    @cached_property
    def _parameters(self) -> Array:
        return self.kernels.parameters(self.values)

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
        return (*self.kernels.model.coordinate_names, *self.kernels.model.speed_names)

    @property
    def status(self) -> str:
        """How the run ended: finished, terminal event, interrupted, or why it failed.

        "not physical" is added if there are :attr:`warnings`.
        """
        return f"{self.path.status}, {NOT_PHYSICAL}" if self.warnings else self.path.status

    @property
    def has_work(self) -> bool:
        """True if the work done is a component of the state."""
        return self.kernels.works

    @property
    def interrupted(self) -> bool:
        """True if Ctrl-C stopped the run before its end."""
        return self.path.status == INTERRUPTED

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

    def __getitem__(self, name: Any) -> Any:
        """A coordinate, speed, acceleration or expression (SymPy or text) at the output times.

        ``["max(theta)"]``, and likewise min, initial, final and range, is one number for the whole run, as in a batch.
        """
        if not isinstance(name, str | sympy.Basic | int | float):
            raise SimulationError(f"Expected a coordinate, a speed or an expression of them, got {name!r}.")
        text = name if isinstance(name, str) else self.kernels.model.names.texts.get(name)
        if text in self.names:
            return self.states[:, self.names.index(text)]
        if isinstance(name, str) and name in ("t", "time"):
            return self.t
        if isinstance(name, str) and name in _PRODUCTS:
            return getattr(self.energy, _PRODUCTS[name])
        if isinstance(name, str) and name.endswith("'") and name[:-1] in self.kernels.model.speed_names:
            return self._rates()[:, self.kernels.model.n_q + self.kernels.model.speed_names.index(name[:-1])]
        if isinstance(name, str) and (number := self._number(name)) is not None:
            return number
        try:
            expression = self.kernels.model.names.expression(name, "trajectory[...]")
        except ExpressionError as error:
            raise SimulationError(
                f"Expected a coordinate, a speed or an expression of them. {error}"
            ) from None
        program = self.kernels.expressions((expression,))
        return self._observed(program, "values", self.t, self.states)[:, 0]

    def _rates(self) -> Array:
        """Rates of the state at the output times."""
        return self._observed(self.kernels.motion(), "rates", self.t, self.states)

    def _number(self, name: str) -> float | None:
        """Return the number for the whole run that a text such as "max(theta)" names, else None."""
        from .extremes import extremes

        if not reduction(name)[0]:
            return None
        outputs = outputs_of(self.kernels.model, [name])
        return float(outputs.number(name, extremes(self, outputs.reduced_values)[None])[0])

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
    def events(self) -> list[Event]:
        """Events that happened, in their order: events of the user, and passings of the limit of a one-sided constraint
        (:attr:`warnings`).
        """
        crossings = [
            Event(
                crossing.time,
                self.specs[crossing.number].name,
                crossing.sign,
                dict(zip(self.names, crossing.state.tolist(), strict=False)),
            )
            for crossing in self.path.crossings
        ]
        if not self._passed:
            return crossings
        sense = 1.0 if self.path.end >= self.path.start else -1.0
        return sorted([*crossings, *self._passings()], key=lambda event: sense * event.time)

    # -- one-sided constraints ----------------------------------------------------------------------------------

    @cached_property
    def _limits(self) -> tuple[Limit, ...]:
        return limits(self.kernels.model)

    @cached_property
    def _passed(self) -> list[Span]:
        """Parts of the run in which a one-sided constraint is beyond its limit."""
        return spans(self._limit_pieces(), len(self._limits)) if self._limits else []

    def _limit_pieces(self) -> Iterator[tuple[Array, Values | None, Array]]:
        program = self.kernels.limits()
        yield piece_of(self.path, program, program.constants(self._parameters))

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
        """Parts of the motion that are not physical: a rope that pushes, a plane that pulls a wheel down.

        The run keeps the constraints as they are described. Each warning says from when on the answer is therefore not
        physical, how far the limit is passed, and what to do. Warnings are computed on first use of this attribute, of
        :attr:`events` or of :attr:`status`.
        """
        return warnings_of(self._limits, self._passed)

    # -- derived quantities -------------------------------------------------------------------------------------------

    def _observed(self, program: Program, function: str, times: Array, states: Array) -> Array:
        """Return the outputs of a function of a program at states."""
        constants = program.constants(self._parameters)
        return observe(program.address(function), program.outputs(function), times, states, constants)

    @cached_property
    def energy(self) -> Energy:
        """Energy ledger at the output times."""
        times = np.concatenate([[self.path.start], self.t])
        states = np.concatenate([self.path.states[:1], self.states])
        energies = self._observed(self.kernels.motion(), "energy", times, states)
        n = self.kernels.size - 1
        work = states[:, n] if self.kernels.works else np.zeros(len(times))
        residual = energies.sum(axis=1) - energies[0].sum() - work
        return Energy(energies[1:, 0], energies[1:, 1], work[1:], residual[1:])

    @cached_property
    def poses(self) -> dict[str, BodyPose]:
        """Position and rotation of every body."""
        poses = self._observed(self.kernels.poses(), "poses", self.t, self.states)
        n = len(self.t)
        return _ByName(
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
        presses teeth apart if their pressure angle is not given.
        """
        reactions = self._observed(self.kernels.reactions(), "reactions", self.t, self.states)
        return _ByName(
            "joint",
            {
                name: Reaction(
                    reactions[:, 6 * i : 6 * i + 3],
                    reactions[:, 6 * i + 3 : 6 * i + 6],
                    on,
                    about,
                )
                for i, (name, on, about) in enumerate(self.kernels.transmitting)
            },
        )

    @cached_property
    def multipliers(self) -> dict[str, Array]:
        """Constraint forces by name, shape (n,): components of loop-closing joints, tensions of ropes, forces of
        conditions on coordinates and speeds.
        """
        multipliers = self._observed(self.kernels.reactions(), "multipliers", self.t, self.states)
        names = [row.name for row in rows(self.kernels.model)]
        return _ByName("constraint", {name: multipliers[:, i] for i, name in enumerate(names)})

    @property
    def indeterminate(self) -> tuple[str, ...]:
        """Names of reactions that the motion does not determine: of redundant constraints, and of gears.

        A planar linkage of rigid parts has such reactions: forces out of its plane depend on how its pins were fitted.
        Names are those of :attr:`multipliers`; for other joints ``A_z`` is the force of joint A along the ground's z,
        ``A_Mx`` its moment about x. They are found by rank at the start. Their values in :attr:`reactions` are one of
        many solutions.
        """
        model = self.kernels.model
        y = self.path.states[0]
        q, u = y[: model.n_q].tolist(), y[model.n_q : model.n_q + model.n_u].tolist()
        return indeterminate(model, float_state(model, q, u, self.path.start, self.values))

    @cached_property
    def data(self) -> xarray.Dataset:
        """All quantities at the output times, with units, as one dataset with the dimension ``time``."""
        from .dataset import dataset

        return dataset(self)

    def save(self, path: str | FilePath) -> None:
        """Write the motion to a netCDF file, whole or not at all: :attr:`data`, which any program can read, the
        description of the machine, and the computed path. :meth:`load` reads the motion back.
        """
        file_module("save").save(self, path)

    @staticmethod
    def load(path: str | FilePath, machine: System | None = None) -> Trajectory:
        """Return the motion that :meth:`save` wrote, with all its quantities.

        Nothing in a file is executed. The file holds the machine. Signals and the inputs of controllers are stored as
        parameters with other values in each part of the run: a loaded motion has neither the signals' names nor the
        controllers' functions. Its events have their names, but no expressions to watch for again.

        Parameters
        ----------
        path : path
        machine : System, optional
            Needed if the machine could not be written to the file (the error says so); useful to have this system's
            own symbols.

        Raises
        ------
        SimulationError
            The file holds no motion, is damaged, or holds no machine.

        Examples
        --------
        >>> import tempfile
        >>> import freebody as fb
        >>> s = fb.System("cart")
        >>> rail = s.slider("rail", s.ground, s.body("cart", fb.particle(2)), axis="x", coordinate="x")
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     fb.simulate(s, until=3, initial={"x'": 2}).save(f"{folder}/cart.nc")
        ...     motion = fb.Trajectory.load(f"{folder}/cart.nc")
        >>> motion
        Trajectory of 'cart': t = 0 to 3 s, 1 coordinate, 0 events, finished
        >>> round(motion.at(1.5)["x"], 12)
        3.0
        """
        trajectory: Trajectory = file_module("load").load(path, machine)
        return trajectory

    def plot(self, names: Any = None, *, ax: Any = None, path: str | FilePath | None = None) -> Any:
        """Plot coordinates (or other quantities) over time, one panel for each unit, with the events marked.

        Parameters
        ----------
        names : name, expression or sequence of them, optional
            As in ``trajectory[...]``; all coordinates if not given.
        ax : matplotlib Axes, optional
            Axes for all of them.
        path : path, optional
            Also write the picture to this file.

        Returns
        -------
        matplotlib Axes, or array of Axes when there are several panels
        """
        axes = picture("plots").history(self, names, ax)
        if path is not None:
            np.ravel(np.asarray(axes, dtype=object))[0].figure.savefig(path, dpi=150)
        return axes

    def animate(self, path: str | FilePath | None = None, **options: Any) -> Any:
        """Return the motion as an animation: a player in a notebook, or a file.

        Parameters
        ----------
        path : path, optional
            Also write it to this file: ``.html`` is a page that opens offline; ``.gif`` and ``.mp4`` are made with a
            browser.
        **options
            Options of :func:`freebody.picture.page.animate.animate`.

        Returns
        -------
        Animation
        """
        animation = picture("animate").animate(self, **options)
        if path is not None:
            animation.save(path)
        return animation

    def _repr_html_(self) -> str:
        return str(picture("animate").animate(self)._repr_html_())

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        n, events, crossings = len(self.kernels.model.coordinates), len(self.events), self.path.crossings
        ended = self.path.status
        if ended == TERMINAL and crossings:
            ended = f"stopped by '{self.specs[crossings[-1].number].name}'"
        warnings = "".join(
            f"; not physical from t = {warning.time:.6g} s on: {warning.what} ('{warning.name}')"
            for warning in self.warnings
        )
        return (
            f"Trajectory of '{self.name}': t = {self.path.start:g} to {self.path.end:g} s, "
            f"{n} coordinate{'s' * (n != 1)}, {events} event{'s' * (events != 1)}, {ended}{warnings}"
        )


_PRODUCTS = {
    "kinetic_energy": "kinetic",
    "potential_energy": "potential",
    "work": "work",
    "energy_residual": "residual",
}


class _ByName(dict[str, Any]):
    """Dictionary whose error for an unknown name offers the nearest one."""

    def __init__(self, what: str, items: Mapping[str, Any]) -> None:
        super().__init__(items)
        self.what = what

    def __missing__(self, name: Any) -> Any:
        raise SimulationError(f"Unknown {self.what} '{name}'; {nearest(str(name), self)}")

    def __getitem__(self, name: Any) -> Any:
        return super().__getitem__(name) if isinstance(name, str) else self.__missing__(name)


def _output_times(path: Path, times: Array | None, samples: int | None) -> Array:
    """Return the output times: the given times that the run reached, or a regular grid with both ends."""
    if times is not None:
        first, last = min(path.start, path.end), max(path.start, path.end)
        return times[(times >= first) & (times <= last)]
    if path.start == path.end:
        return np.array([path.start])
    return np.linspace(path.start, path.end, samples or min(_MOST, max(_FEWEST, path.steps + 1)))


def quaternions(rotation: Array) -> Array:
    """Return unit quaternions (n, 4), scalar first, of rotation matrices (n, 3, 3), without jumps of sign along n.

    Of the four columns of 4 e eᵀ, whose diagonal is 1 + a R₁₁ + b R₂₂ + c R₃₃, the column with the greatest diagonal is
    used, so that no division is by a small number. Source: Shepperd (1978).
    """
    R = rotation
    x, y, z = R[:, 0, 0], R[:, 1, 1], R[:, 2, 2]
    a, b, c = R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]
    d, e, f = R[:, 1, 0] + R[:, 0, 1], R[:, 0, 2] + R[:, 2, 0], R[:, 2, 1] + R[:, 1, 2]
    columns = np.array(
        [
            [1 + x + y + z, a, b, c],
            [a, 1 + x - y - z, d, e],
            [b, d, 1 - x + y - z, f],
            [c, e, f, 1 - x - y + z],
        ]
    )
    best = np.argmax(np.einsum("iin->in", columns), axis=0)
    q = columns[best, :, np.arange(len(R))]
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    if len(q):
        turns = np.sign(np.einsum("ni,ni->n", q[1:], q[:-1]))
        turns[turns == 0] = 1
        first = -1.0 if q[0, 0] < 0 else 1.0
        q *= (first * np.concatenate([[1.0], np.cumprod(turns)]))[:, None]
    return q


def unit_of(trajectory: Trajectory, name: str) -> str:
    """Unit of a coordinate or speed: as described, else the unit of the joint it moves."""
    return unit_of_name(trajectory.kernels.model, name)


def unit_of_name(model: Any, name: str) -> str:
    """Unit of a coordinate or speed of a model."""
    base = name.rstrip("'")
    unit = model.about.get(base, ("", ""))[0] or _unit(model, name, base)
    return f"{unit}/s" if name.endswith("'") and unit else unit


def _unit(model: Any, name: str, base: str) -> str:
    for coordinate in model.coordinates:
        if coordinate.name == base and coordinate.kind != "scalar":
            return "m" if coordinate.kind == "position" else "1"
    atom = model.names.atoms[base]
    if base == name and name not in model.coordinate_names:  # a component of an angular or linear velocity
        return "rad/s" if name[-2:-1] == "w" else "m/s"
    units = {
        "m" if link.kind == "slider" else "rad"
        for link in model.links
        if link.one_dof and isinstance(link.displacement, sympy.Basic) and link.displacement.has(atom)
    }
    return units.pop() if len(units) == 1 else ""
