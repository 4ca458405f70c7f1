"""Fitting: the parameters and starts with which a motion comes closest to what was measured.

    minimize  Σ ((x_k(p) - measured_k) / σ_k)²,        covariance of p:  (Jᵀ J)⁻¹,    J_kj = (∂x_k/∂p_j) / σ_k

J is exact: the derivatives are integrated beside the motion (`sensitivity`). Where σ is not known it is taken
as equal for all measurements and estimated from what is left over, σ² = Σ r² / (N - n).

One file, though long: a third of it says what is wrong with the data.

Sources: Nocedal and Wright, Numerical Optimization (2006), section 10.3; Bard, Nonlinear Parameter Estimation (1974),
section 7.5.

The file is longer than others: what is measured, weighed, sought and found is read and checked in one place.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy
from numpy.typing import NDArray

from ..errors import FreebodyError, SimulationError, arguments_named
from ..motion.kernels.kernels import kernels_of
from ..motion.legs.sensitivity import unknowns_of
from ..motion.simulate import simulate
from ..motion.start.initial import number, quaternions_by_joint

if TYPE_CHECKING:
    from ..motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

INDISTINCT = 1e-8
"""Smallest singular value of the scaled Jacobian, in parts of the greatest, below which data do not tell parameters
apart: relative changes of parameters then move the motion by no more than its integration error."""
_OWN = ("times", "samples", "sensitivities", "outputs", "store", "executor", "threads")
"""Options of `simulate` that a fit sets itself, or that are those of a batch."""
ROUND_OFF = 1e-12
"""Part of what was measured below which a derivative is round-off: some thousand roundings."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters and starts that fit a measurement. Made by :func:`freebody.fit`.

    Attributes
    ----------
    values : dict of str to float
        The unknowns, by name.
    errors : dict of str to float
        Standard error of each.
    covariance : ndarray (n, n)
        Of the unknowns, in the order of ``values``.
    residuals : dict of str to ndarray
        Measured less computed, by quantity, in its unit; of several measurements one after another.
    sigma : dict of str to float or ndarray
        Standard deviation of the measurement of each quantity: as given, or as estimated.
    trajectories : tuple of Trajectory
        The motion that fits, one for each measurement.
    evaluations : int
        How many motions were computed for each measurement.
    """

    values: dict[str, float]
    errors: dict[str, float]
    covariance: Array
    residuals: dict[str, Array]
    sigma: dict[str, Any]
    trajectories: tuple[Trajectory, ...]
    evaluations: int

    @property
    def trajectory(self) -> Trajectory:
        """The motion that fits; of several measurements the first."""
        return self.trajectories[0]

    @property
    def correlation(self) -> Array:
        """Of the errors of the unknowns: covariance with ones on the diagonal."""
        scale = np.sqrt(self.covariance.diagonal())
        return self.covariance / np.outer(scale, scale)

    def __repr__(self) -> str:
        count = len(self.values)
        lines = [f"Fit of {', '.join(self.residuals)} by {count} unknown{'s' if count > 1 else ''}"]
        for name, value in self.values.items():
            lines.append(f"  {name} = {value:.8g} ± {self.errors[name]:.2g}")
        return "\n".join(lines)


@arguments_named
def fit(
    s: Any,
    data: Any,
    unknown: Any,
    *,
    initial: Any = None,
    near: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
    sigma: Mapping[str, Any] | None = None,
    bounds: Mapping[Any, tuple[float, float]] | None = None,
    tolerance: float = 1e-9,
    start: Any = 0,
    **options: Any,
) -> Fit:
    """Parameters and starts of a machine from measured motions.

    Parameters
    ----------
    s : System or Model
    data : mapping, xarray.Dataset or DataFrame, or sequence of them
        Measured quantities over time: ``{"time": t, "theta": values}``, arrays of shape (N,); a quantity is a
        coordinate, a speed or an expression, and nan stands for a moment at which it was not measured. The times of a
        DataFrame are its column, or its index, of this name. A sequence holds measurements of several motions of the
        same machine.
    unknown : sequence of names, or mapping of name to first guess
        Parameters, and coordinates and speeds at the start. Without a guess the search begins at the parameter's value,
        or at the value in ``initial``.
    initial : mapping, or sequence of them
        Start of the motion, as for :func:`freebody.simulate`; one for each measurement.
    values : mapping, optional
        Parameters that are known.
    sigma : mapping of quantity to number or array, optional
        Standard deviations of the measurement [unit of the quantity]. Several quantities need
        them, to be weighed against each other; of one quantity it is estimated from the residuals if not given.
    bounds : mapping of name to (least, greatest), optional
    tolerance : float
        Of the integration.
    start : number
        Time of the initial state [s].
    **options
        ``near``, ``method``, ``max_step``, ... of :func:`freebody.simulate`.

    Returns
    -------
    Fit

    Raises
    ------
    SimulationError
        Unknown names, too few data, data that do not tell the unknowns apart (with the combination that the motion does
        not feel), a search that does not end.

    Examples
    --------
    >>> import numpy as np, freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, d, I = s.parameters(m=2.0, d=0.3, I=0.5)
    >>> s.gravity = (0, -9.81, 0)
    >>> bar = s.body("bar", fb.MassProperties(m, (0, -d, 0), ((1, 0, 0), (0, 1, 0), (0, 0, I))))
    >>> pin = s.hinge("pin", s.ground, bar, axis="z", coordinate="theta")
    >>> t = np.linspace(0, 4, 81)
    >>> rng = np.random.default_rng(1)
    >>> measured = fb.simulate(s, 4, initial={"theta": 0.8}, times=t)["theta"] + rng.normal(0, 0.01, 81)
    >>> found = fb.fit(s, {"time": t, "theta": measured}, {"I": 1.0, "theta": 1.0}, values={"m": 2.0, "d": 0.3})
    >>> abs(found.values["I"] - 0.5) < 3 * found.errors["I"]
    True
    """
    kernels = kernels_of(s)
    model = kernels.model
    runs = list(data) if isinstance(data, list | tuple) else [data]
    starts = (
        list(initial)
        if isinstance(initial, list | tuple)
        else [{} if initial is None else initial] * len(runs)
    )
    for begun in starts:
        if not isinstance(begun, Mapping):
            raise SimulationError(
                f"Expected initial values by name, such as {{'theta': 0.1}}, got {begun!r}."
            )
    if len(starts) != len(runs):
        raise SimulationError(
            f"Expected one initial= for each of the {len(runs)} measurements, got {len(starts)}."
        )
    if not isinstance(unknown, str | sympy.Basic | Mapping | list | tuple):
        raise SimulationError(f"Expected names of unknowns, or first guesses by name, got {unknown!r}.")
    guesses = (
        dict(unknown)
        if isinstance(unknown, Mapping)
        else dict.fromkeys(map(model.names.text_of, _listed(unknown)))
    )
    chosen = unknowns_of(model, list(guesses), {}, "unknown")
    names = [one.name for one in chosen]
    guesses = dict(zip(names, guesses.values(), strict=True))
    for one in chosen:
        if any(start_ <= one.place < start_ + 4 for start_ in model.quaternions):
            joint = next(j for j, k in quaternions_by_joint(model).items() if k <= one.place < k + 4)
            raise SimulationError(
                f"Expected unknowns that are free, got '{one.name}', a component of the unit quaternion of joint "
                f"'{joint}'. Fit a joint with Euler angles (gimbal), or its speeds."
            )
    begin = number(model, kernels.values(values), start, "start")
    for option in _OWN:
        if option in options:
            raise SimulationError(
                f"Expected no {option}= for a fit, got {options[option]!r}: the measured times and unknown= say it. "
                "Leave it out."
            )
    measured = [_measured(model, run, begin) for run in runs]
    quantities = list(dict.fromkeys(name for run in measured for name in run[1]))
    if not quantities:
        raise SimulationError("Expected at least one measured quantity besides the time, got none.")
    known = {**(values or {})}
    named = {_name(model, key) for key in known}
    begun_with = {_name(model, key) for begin in starts for key in begin}
    for one in chosen:
        fixed = named if one.symbol is not None else begun_with
        if guesses[one.name] is not None and one.name in fixed:
            where = "values=" if one.symbol is not None else "initial="
            raise SimulationError(
                f"'{one.name}' is unknown, with a first guess, and known, in {where} as well. Leave one out."
            )
    numbers = model.values({k: v for k, v in known.items()} | _given(chosen, guesses))
    first = np.array([_first(one, guesses, numbers, starts, model) for one in chosen])
    weights = _weights(sigma, quantities, measured)
    low, high = _bounds(bounds, names, first)
    calls = [0]

    def motions(p: Array) -> list[Any]:
        calls[0] += 1
        result = []
        at = dict(zip(names, p.tolist(), strict=True))
        parameters = {**known, **{one.name: at[one.name] for one in chosen if one.symbol is not None}}
        begun = {one.name: at[one.name] for one in chosen if one.symbol is None}
        for (times, _), given in zip(measured, starts, strict=True):
            mine = {_name(model, k): v for k, v in given.items()}
            result.append(
                simulate(
                    s, float(times.max()), initial={**mine, **begun}, near=near, values=parameters, start=start,
                    times=np.unique(times), tolerance=tolerance, sensitivities=names, progress=False, **options,
                )
            )  # fmt: skip
        return result

    memory: dict[bytes, tuple[Array, Array, list[Any]]] = {}

    def computed(p: Array) -> tuple[Array, Array, list[Any]]:
        """Weighted residuals (computed less measured), their Jacobian, the motions."""
        key = p.tobytes()
        if key not in memory:
            memory.clear()
            found = motions(p)
            residuals, rows = [], []
            for (times, columns), motion, scales in zip(measured, found, weights, strict=True):
                places = np.searchsorted(motion.t, times)
                for name, numbers_ in columns.items():
                    good = np.isfinite(numbers_)
                    at = places[good]
                    if at.size and at.max() >= len(motion.t):
                        raise SimulationError(
                            "A terminal event ended the motion before the last measurement. Leave it out."
                        )
                    residuals.append((motion[name][at] - numbers_[good]) / scales[name][good])
                    rows.append(motion.sensitivity.of(name)[at] / scales[name][good][:, None])
            memory[key] = (np.concatenate(residuals), np.concatenate(rows), found)
        return memory[key]

    from scipy.optimize import least_squares

    residuals, J, _ = computed(first)
    if residuals.size < len(names):
        raise SimulationError(
            f"Expected at least as many measured numbers as unknowns, got {residuals.size} for {len(names)}."
        )
    size = math.hypot(*(float(np.linalg.norm(x)) for x in _weighted(measured, weights)))
    _check_rank(J, first, names, size)

    def safe(p: Array) -> Array:
        try:
            return computed(p)[0]
        except FreebodyError:  # no motion there: a shorter step of the search
            return np.full(residuals.size, 1e150)

    scale = np.where(first != 0, np.abs(first), 1.0)
    solved = least_squares(
        safe, first, jac=lambda p: computed(p)[1], bounds=(low, high), x_scale=scale, method="trf",
        xtol=1e-13, ftol=1e-13, gtol=1e-13, max_nfev=200,
    )  # fmt: skip
    residuals, J, found = computed(solved.x)
    if solved.status == 0:
        raise SimulationError(
            f"The search did not end in {solved.nfev} steps; it stands at "
            f"{', '.join(f'{n} = {x:.6g}' for n, x in zip(names, solved.x, strict=True))}. Begin nearer: pass guesses, "
            "unknown={'m': 1.0}."
        )
    _check_rank(J, solved.x, names, size)
    return _result(chosen, solved.x, residuals, J, found, measured, sigma, quantities, calls[0])


def _weighted(measured: Any, weights: Any) -> Iterator[Array]:
    """All that was measured, over its standard deviation."""
    for (_, columns), scales in zip(measured, weights, strict=True):
        for name, array in columns.items():
            good = np.isfinite(array)
            yield array[good] / scales[name][good]


def _listed(unknown: Any) -> list[Any]:
    if isinstance(unknown, str) or not isinstance(unknown, Sequence):
        return [unknown]
    return list(unknown)


def _name(model: Any, key: Any) -> str:
    return model.names.text_of(key)


def _given(chosen: Sequence[Any], guesses: Mapping[str, Any]) -> dict[str, Any]:
    return {
        one.name: guesses[one.name]
        for one in chosen
        if one.symbol is not None and guesses[one.name] is not None
    }


def _first(
    one: Any, guesses: Mapping[str, Any], numbers: Mapping[str, float], starts: Any, model: Any
) -> float:
    """Where the search begins."""
    given = guesses[one.name]
    if given is None and one.symbol is None:
        mine = [{_name(model, k): v for k, v in start.items()}.get(one.name) for start in starts]
        given = next((x for x in mine if x is not None), 0.0)
    if given is None:
        return float(numbers[one.name])
    return number(model, numbers, given, f"the guess of '{one.name}'")


def _measured(model: Any, run: Any, begin: float) -> tuple[Array, dict[str, Array]]:
    """Times, and quantities by name."""
    if hasattr(run, "data_vars"):
        columns = {str(k): np.asarray(v.values) for k, v in run.data_vars.items()}
        columns["time"] = np.asarray(run["time"].values)
    elif isinstance(run, Mapping):
        columns = {_name(model, k): v for k, v in run.items()}
    elif hasattr(run, "columns"):  # a table of pandas, or one that is read as such
        columns = {_name(model, k): run[k] for k in run.columns}
        index = getattr(run, "index", None)
        if getattr(index, "name", None) in ("time", "t"):
            columns.setdefault("time", np.asarray(index))
    else:
        raise SimulationError(
            f"Expected measured data by name, such as {{'time': t, 'theta': values}}, got {run!r}."
        )
    if "time" not in columns and "t" in columns:
        columns["time"] = columns.pop("t")
    if "time" not in columns:
        raise SimulationError(
            f"Expected 'time' among the measured data, got {', '.join(columns) or 'nothing'}. Name the array of times "
            "'time'."
        )
    arrays: dict[str, Array] = {}
    try:
        for name, x in columns.items():
            if np.iscomplexobj(x):
                raise SimulationError(f"Expected real numbers for the measured '{name}', got complex ones.")
            if np.asarray(x).dtype.kind in "mM":  # as numbers they would be nanoseconds
                raise SimulationError(
                    f"Expected numbers for the measured '{name}', got dates or durations. Seconds from the start are "
                    "made by (t - t[0]) / np.timedelta64(1, 's')."
                )
            arrays[name] = np.array(x.astype(float) if hasattr(x, "astype") else x, dtype=float)
    except (TypeError, ValueError):
        raise SimulationError(f"Expected arrays of numbers for the measured '{name}', got {x!r}.") from None
    times = arrays.pop("time")
    if times.ndim != 1 or not times.size:
        raise SimulationError(f"Expected times of shape (N,), got shape {times.shape}.")
    if not np.isfinite(times).all():
        k = int(np.flatnonzero(~np.isfinite(times))[0])
        raise SimulationError(f"Expected finite times, got {times[k]:g} for measurement {k}. Leave it out.")
    if times.min() < begin:
        raise SimulationError(
            f"Expected measurements after the start of the motion at {begin:g} s, got one at {times.min():g} s. "
            "start= is the time of the initial state."
        )
    for name, array in arrays.items():
        if array.shape != times.shape:
            raise SimulationError(
                f"Expected {times.size} measured values of '{name}', one for each time, got shape {array.shape}."
            )
        if np.isinf(array).any():
            raise SimulationError(
                f"Expected finite measured values of '{name}' (nan where there is none), got inf."
            )
    return times, arrays


def _weights(sigma: Any, quantities: list[str], measured: Any) -> list[dict[str, Array]]:
    """Standard deviations of every measured number; 1 where they are to be estimated."""
    if sigma is not None and not isinstance(sigma, Mapping):
        raise SimulationError(
            f"Expected standard deviations by quantity, such as sigma={{'{quantities[0]}': 0.01}}, got {sigma!r}."
        )
    given = dict(sigma or {})
    for name in given:
        if name not in quantities:
            raise SimulationError(
                f"Expected measured quantities in sigma, {', '.join(quantities)}; got '{name}'."
            )
    if given and len(given) < len(quantities):
        missing = [name for name in quantities if name not in given]
        raise SimulationError(
            f"Expected sigma of all measured quantities or of none; that of {', '.join(missing)} is missing."
        )
    if not given and len(quantities) > 1:
        raise SimulationError(
            f"Expected sigma= for several measured quantities ({', '.join(quantities)}): how much an error of one "
            "counts against one of another. Pass their standard deviations, such as sigma={'theta': 0.01}."
        )
    result = []
    for times, columns in measured:
        mine = {}
        for name in columns:
            try:
                array = np.asarray(given.get(name, 1.0), dtype=float)
            except (TypeError, ValueError):
                array = np.array(math.nan)
            if array.ndim and array.shape != times.shape or not (array > 0).all():
                raise SimulationError(
                    f"Expected a standard deviation greater than 0 for '{name}', one number or {times.size}, got "
                    f"{given[name]!r}."
                )
            mine[name] = np.broadcast_to(array, times.shape)
        result.append(mine)
    return result


def _bounds(bounds: Any, names: list[str], first: Array) -> tuple[Array, Array]:
    low, high = np.full(len(names), -math.inf), np.full(len(names), math.inf)
    if bounds is not None and not isinstance(bounds, Mapping):
        raise SimulationError(f"Expected bounds by name, such as {{'{names[0]}': (0, 1)}}, got {bounds!r}.")
    for name, pair in (bounds or {}).items():
        if name not in names:
            raise SimulationError(f"Expected unknowns in bounds, {', '.join(names)}; got '{name}'.")
        i = names.index(name)
        try:
            low[i], high[i] = pair
        except (TypeError, ValueError):
            raise SimulationError(
                f"Expected (least, greatest) as bounds of '{name}', got {pair!r}."
            ) from None
        if not low[i] <= first[i] <= high[i]:
            raise SimulationError(
                f"Expected the first guess of '{name}' within its bounds, {low[i]:g} to {high[i]:g}, got {first[i]:g}."
            )
    return low, high


def _check_rank(J: Array, p: Array, names: list[str], size: float) -> None:
    """Refuse data that do not tell the unknowns apart.

    Columns count relative to their parameters; a direction in which nothing changes is named. A column that is nothing
    beside the ``size`` of what was measured is round-off, also where all are.
    """
    scale = np.where(p != 0, np.abs(p), 1.0)
    scaled = J * scale
    lengths = np.linalg.norm(scaled, axis=0)
    largest = lengths.max(initial=0)
    idle = [
        name
        for name, x in zip(names, lengths, strict=True)
        if x <= max(INDISTINCT * largest, ROUND_OFF * size)
    ]
    if idle or largest == 0:
        raise SimulationError(
            f"The measured motion does not depend on {' and '.join(map(repr, idle or names))}: it can not be found "
            "from these data. Leave it out of unknown, or measure something that it moves."
        )
    _, singular, V = np.linalg.svd(scaled / lengths, full_matrices=False)
    if singular[-1] <= INDISTINCT * singular[0]:
        direction = V[-1] / lengths
        direction /= np.abs(direction).max()
        if direction[np.abs(direction).argmax()] < 0:
            direction = -direction
        moved = [
            f"{name} by {100 * x:+.3g} %" if q != 0 else f"{name} by {x:+.3g}"
            for name, x, q in zip(names, direction / 100, p, strict=True)
            if abs(x) > 1e-7
        ]
        raise SimulationError(
            f"The measured motion does not tell {', '.join(repr(m.split(' by ')[0]) for m in moved)} apart: changing "
            f"{', '.join(moved)} together leaves it as it is. Give all but one of them in values=, or measure "
            "something else, such as a force or a motion from another start."
        )


def _result(
    chosen: Sequence[Any], p: Array, residuals: Array, J: Array, found: list[Any], measured: Any,
    sigma: Any, quantities: list[str], calls: int,
) -> Fit:  # fmt: skip
    names = [one.name for one in chosen]
    lengths = np.linalg.norm(J, axis=0)
    _, singular, V = np.linalg.svd(J / lengths, full_matrices=False)
    covariance = (V.T / singular**2) @ V / np.outer(lengths, lengths)
    spread: dict[str, Any] = dict(sigma or {})
    if not sigma:
        free = residuals.size - len(names)
        variance = float(residuals @ residuals) / free if free > 0 else math.nan
        covariance = covariance * variance
        spread = {quantities[0]: math.sqrt(variance)}
    left: dict[str, list[Array]] = {name: [] for name in quantities}
    for (times, columns), motion in zip(measured, found, strict=True):
        places = np.searchsorted(motion.t, times)
        for name, numbers in columns.items():
            left[name].append(numbers - motion[name][places])
    return Fit(
        dict(zip(names, p.tolist(), strict=True)),
        dict(zip(names, np.sqrt(covariance.diagonal()).tolist(), strict=True)),
        covariance,
        {name: np.concatenate(parts) for name, parts in left.items()},
        spread,
        tuple(found),
        calls,
    )
