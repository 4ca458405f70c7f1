"""Fits: the parameters and initial values with which a motion is closest to a measurement.

    minimize  Σ ((x_k(p) - measured_k) / σ_k)²,        covariance of p:  (Jᵀ J)⁻¹,    J_kj = (∂x_k/∂p_j) / σ_k

J is exact: the derivatives are integrated together with the motion (`sensitivity`). If σ is not known, it is taken
as equal for all measurements and estimated from the residuals r, σ² = Σ r² / (N - n).

Sources: Nocedal and Wright, Numerical Optimization (2006), section 10.3; Bard, Nonlinear Parameter Estimation (1974),
section 7.5.

This file is longer than others: a third of it checks the data and explains errors in them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
import sympy
from numpy.typing import NDArray

from ..errors import FreebodyError, NoDerivativesError, SimulationError, arguments_named
from ..motion.kernels.kernels import kernels_of
from ..motion.legs.variation import unknowns_of
from ..motion.start.initial import number, quaternions_by_joint
from .minima import Minimum, best_of
from .simulate import simulate

if TYPE_CHECKING:
    from ..model.model import Model
    from ..motion.trajectory.trajectory import Trajectory

Array = NDArray[np.float64]

INDISTINCT = 1e-8
"""Smallest singular value of the scaled Jacobian, relative to the greatest, below which data do not tell parameters
apart: relative changes of parameters then change the motion by no more than its integration error."""

_RESERVED = ("times", "samples", "sensitivities", "outputs", "store", "executor", "threads")
"""Options of `simulate` that a fit sets itself, or that belong to a batch."""

ROUND_OFF = 1e-12
"""Fraction of the measurement below which a derivative is round-off: some thousand roundings."""


class _Computed(NamedTuple):
    """Weighted residuals (computed minus measured), their Jacobian, and the motions."""

    residuals: Array
    jacobian: Array
    motions: list[Any]


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters and initial values that fit a measurement, made by :func:`freebody.fit`.

    Attributes
    ----------
    values : dict of str to float
        The unknowns, by name.
    errors : dict of str to float
        Standard error of each.
    covariance : ndarray (n, n)
        Covariance of the unknowns, in the order of ``values``.
    residuals : dict of str to ndarray
        Measured minus computed values, by quantity, in its unit; several measurements follow each other.
    sigma : dict of str to float or ndarray
        Standard deviation of the measurement of each quantity, given or estimated.
    trajectories : tuple of Trajectory
        The fitted motion of each measurement.
    evaluations : int
        Number of motions computed for each measurement.
    cost : float
        Σ ((computed - measured)/σ)²; σ is 1 where it is not given.
    misfit : float
        √(cost/(N - n)) of N measured numbers and n unknowns. With ``sigma=`` it is near 1 if the machine moves as
        measured; far above 1 the search has ended in a minimum that is not the best, or the machine is another one.
    minima : tuple of Minimum
        With ``starts=``, the minima that they lead to, the best first, each with ``values``, ``cost`` and ``starts``.
    failed_starts : int
        Number of starts from which no fit was found.
    weighted : bool
        True if ``sigma`` was given.
    """

    values: dict[str, float]
    errors: dict[str, float]
    covariance: Array
    residuals: dict[str, Array]
    sigma: dict[str, Any]
    trajectories: tuple[Trajectory, ...]
    evaluations: int
    cost: float
    misfit: float
    minima: tuple[Minimum, ...] = ()
    failed_starts: int = 0
    weighted: bool = False

    @property
    def trajectory(self) -> Trajectory:
        """The fitted motion; for several measurements the first."""
        return self.trajectories[0]

    @property
    def correlation(self) -> Array:
        """Correlation of the errors of the unknowns: the covariance scaled to ones on the diagonal."""
        scale = np.sqrt(self.covariance.diagonal())
        return self.covariance / np.outer(scale, scale)

    def __repr__(self) -> str:
        count = len(self.values)
        lines = [f"Fit of {', '.join(self.residuals)} by {count} unknown{'s' if count > 1 else ''}"]
        for name, value in self.values.items():
            lines.append(f"  {name} = {value:.8g} ± {self.errors[name]:.2g}")
        if self.weighted:
            lines.append(f"  residuals: {self.misfit:.3g} sigma")
        if self.minima:
            costs = ", ".join(f"{x.cost:.4g} from {x.starts}" for x in self.minima)
            failed = f"; {self.failed_starts} led to no fit" if self.failed_starts else ""
            lines.append(f"  starts by their cost: {costs}{failed}")
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
    starts: Any = None,
    tolerance: float = 1e-9,
    start: Any = 0,
    **options: Any,
) -> Fit:
    """Fit parameters and initial values of a machine to measured motions.

    Parameters
    ----------
    s : System or Model
    data : mapping, xarray.Dataset or DataFrame, or sequence of them
        Measured quantities over time: ``{"time": t, "theta": values}``, arrays of shape (N,); a quantity is a
        coordinate, a speed or an expression, and nan stands for a time at which it was not measured. The times of a
        DataFrame are its column, or its index, of this name. A sequence holds measurements of several motions of the
        same machine.
    unknown : sequence of names, or mapping of name to first guess
        Parameters, and initial values of coordinates and speeds. Without a guess the search begins at the value of the
        parameter, or at the value in ``initial``.
    initial : mapping, or sequence of them
        Initial values, as for :func:`freebody.simulate`; a sequence has those of each measurement.
    values : mapping, optional
        Values of known parameters.
    sigma : mapping of quantity to number or array, optional
        Standard deviations of the measurement [unit of the quantity]. Several quantities need them as weights; for one
        quantity it is estimated from the residuals by default.
    bounds : mapping of name to (least, greatest), optional
    starts : fb.sample, fb.grid or fb.table, optional
        First guesses of some unknowns: the search begins at each, and the best of the results is returned, with all
        ``minima``.
    tolerance : float
        Tolerance of the integration.
    start : number
        Time of the initial state [s].
    **options
        ``near``, ``method``, ``max_step``, ... of :func:`freebody.simulate`.

    Returns
    -------
    Fit

    Notes
    -----
    The derivatives of the motion are those of :func:`freebody.simulate` with ``sensitivities=``. Where a motion with
    contacts has none, differences of two motions for each unknown take their place. Such a motion bends where an
    impact or a slip moves over a measured time, and jumps where a contact is met or missed, so begin near, or give
    ``starts``.

    Raises
    ------
    SimulationError
        If a name is unknown, there are too few data, the data do not tell the unknowns apart (the message names the
        combination that does not change the motion), or the search does not end.

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
    >>> result = fb.fit(s, {"time": t, "theta": measured}, {"I": 1.0, "theta": 1.0}, values={"m": 2.0, "d": 0.3})
    >>> abs(result.values["I"] - 0.5) < 3 * result.errors["I"]
    True
    """
    kernels = kernels_of(s)
    model = kernels.model
    runs = list(data) if isinstance(data, list | tuple) else [data]
    initials = (
        list(initial)
        if isinstance(initial, list | tuple)
        else [{} if initial is None else initial] * len(runs)
    )
    for initial_values in initials:
        if not isinstance(initial_values, Mapping):
            raise SimulationError(
                f"Expected initial values by name, such as {{'theta': 0.1}}, got {initial_values!r}."
            )
    if len(initials) != len(runs):
        raise SimulationError(
            f"Expected one initial= for each of the {len(runs)} measurements, got {len(initials)}."
        )
    if not isinstance(unknown, str | sympy.Basic | Mapping | list | tuple):
        raise SimulationError(f"Expected names of unknowns, or first guesses by name, got {unknown!r}.")
    guesses = (
        dict(unknown)
        if isinstance(unknown, Mapping)
        else dict.fromkeys(map(model.names.text_of, _listed(unknown)))
    )
    unknowns = unknowns_of(model, list(guesses), {}, "unknown")
    names = [x.name for x in unknowns]
    guesses = dict(zip(names, guesses.values(), strict=True))
    if starts is not None:
        again = partial(
            fit, s, data, initial=initial, near=near, values=values, sigma=sigma, bounds=bounds, tolerance=tolerance,
            start=start, **options,
        )  # fmt: skip
        return cast(Fit, best_of(again, guesses, starts, model))
    for x in unknowns:
        if any(k <= x.place < k + 4 for k in model.quaternions):
            joint = next(j for j, k in quaternions_by_joint(model).items() if k <= x.place < k + 4)
            raise SimulationError(
                f"Expected unknowns that are free, got '{x.name}', a component of the unit quaternion of joint "
                f"'{joint}'. Fit a joint with Euler angles (gimbal), or its speeds."
            )
    begin = number(model, kernels.values(values), start, "start")
    for option in _RESERVED:
        if option in options:
            raise SimulationError(
                f"Expected no {option}= for a fit, got {options[option]!r}: the measured times and unknown= set it. "
                "Leave it out."
            )
    measured = [_measured(model, run, begin) for run in runs]
    quantities = list(dict.fromkeys(name for run in measured for name in run[1]))
    if not quantities:
        raise SimulationError("Expected at least one measured quantity besides the time, got none.")
    fixed_values = {**(values or {})}
    value_names = {_name(model, key) for key in fixed_values}
    initial_names = {_name(model, key) for initial_values in initials for key in initial_values}
    for x in unknowns:
        fixed_names = value_names if x.symbol is not None else initial_names
        if guesses[x.name] is not None and x.name in fixed_names:
            where = "values=" if x.symbol is not None else "initial="
            raise SimulationError(
                f"'{x.name}' has a first guess in unknown= and a value in {where}. Leave one out."
            )
    numbers = model.values(fixed_values | _parameter_guesses(unknowns, guesses))
    first = np.array([_first(x, guesses, numbers, initials, model) for x in unknowns])
    weights = _weights(sigma, quantities, measured)
    low, high = _bounds(bounds, names, first)
    calls = [0]

    def motions(p: Array, sensitive: list[str] | None) -> list[Any]:
        calls[0] += 1
        result = []
        at = dict(zip(names, p.tolist(), strict=True))
        parameters = {**fixed_values, **{x.name: at[x.name] for x in unknowns if x.symbol is not None}}
        searched = {x.name: at[x.name] for x in unknowns if x.symbol is None}
        for (times, _), initial_values in zip(measured, initials, strict=True):
            fixed = {_name(model, k): v for k, v in initial_values.items()}
            result.append(
                simulate(
                    s, float(times.max()), initial={**fixed, **searched}, near=near, values=parameters, start=start,
                    times=np.unique(times), tolerance=tolerance, sensitivities=sensitive, progress=False, **options,
                )
            )  # fmt: skip
        return result

    memory: dict[bytes, _Computed] = {}

    def compared(fitted: list[Any], sensitive: bool) -> tuple[Array, list[Array]]:
        """Residuals of motions, and their derivatives if they are asked for."""
        residuals, rows = [], []
        for (times, columns), motion, scales in zip(measured, fitted, weights, strict=True):
            places = np.searchsorted(motion.t, times)
            for name, array in columns.items():
                finite = np.isfinite(array)
                at = places[finite]
                if at.size and at.max() >= len(motion.t):
                    raise SimulationError(
                        "A terminal event ended the motion before the last measurement. Leave it out."
                    )
                residuals.append((motion[name][at] - array[finite]) / scales[name][finite])
                if sensitive:
                    rows.append(motion.sensitivity.of(name)[at] / scales[name][finite][:, None])
        return np.concatenate(residuals), rows

    def computed(p: Array) -> _Computed:
        """Motions at these unknowns, beside the measurement."""
        key = p.tobytes()
        if key not in memory:
            memory.clear()
            try:
                fitted = motions(p, names)
                residuals, rows = compared(fitted, True)
                J = np.concatenate(rows)
            except NoDerivativesError:
                fitted = motions(p, None)
                residuals, J = compared(fitted, False)[0], differences(p)
            memory[key] = _Computed(residuals, J, fitted)
        return memory[key]

    def differences(p: Array) -> Array:
        """Central differences over h = ε^⅓: their own error h² is as large as that of the motions, ε/h."""
        columns, h = [], tolerance ** (1 / 3) * np.where(p != 0, np.abs(p), 1.0)
        for j, step in enumerate(np.diag(h)):
            ends = [np.clip(p + side * step, low, high) for side in (1, -1)]
            after, before = (compared(motions(end, None), False)[0] for end in ends)
            columns.append((after - before) / (ends[0][j] - ends[1][j]))
        return np.column_stack(columns)

    from scipy.optimize import least_squares

    residuals, J, _ = computed(first)
    if residuals.size < len(names):
        raise SimulationError(
            f"Expected at least as many measured numbers as unknowns, got {residuals.size} for {len(names)}."
        )
    size = math.hypot(*(float(np.linalg.norm(x)) for x in _weighted(measured, weights)))
    with_contacts = bool(model.contacts or model.families)
    # contacts that stick at the first guess may slip where the search goes
    if not (with_contacts and J.any()):
        _check_rank(J, first, names, size, with_contacts)

    def safe(p: Array) -> Array:
        try:
            return computed(p)[0]
        except FreebodyError:  # no motion at these values: the search takes a shorter step
            return np.full(residuals.size, 1e150)

    scale = np.where(first != 0, np.abs(first), 1.0)
    solved = least_squares(
        safe, first, jac=lambda p: computed(p)[1], bounds=(low, high), x_scale=scale, method="trf",
        xtol=1e-13, ftol=1e-13, gtol=1e-13, max_nfev=200,
    )  # fmt: skip
    if solved.status == 0:
        raise SimulationError(
            f"The search did not end in {solved.nfev} steps; it is at "
            f"{', '.join(f'{n} = {x:.6g}' for n, x in zip(names, solved.x, strict=True))}. Begin nearer: pass guesses, "
            "unknown={'m': 1.0}."
        )
    result = computed(solved.x)
    _check_rank(result.jacobian, solved.x, names, size, with_contacts)
    return _result(solved.x, result, names, measured, sigma, quantities, calls[0])


def _weighted(measured: Any, weights: Any) -> Iterator[Array]:
    """Measured values over their standard deviations."""
    for (_, columns), scales in zip(measured, weights, strict=True):
        for name, array in columns.items():
            finite = np.isfinite(array)
            yield array[finite] / scales[name][finite]


def _listed(unknown: Any) -> list[Any]:
    """Unknowns as a list."""
    if isinstance(unknown, str) or not isinstance(unknown, Sequence):
        return [unknown]
    return list(unknown)


def _name(model: Model, key: Any) -> str:
    """Name of a quantity as text."""
    return model.names.text_of(key)


def _parameter_guesses(unknowns: Sequence[Any], guesses: Mapping[str, Any]) -> dict[str, Any]:
    """First guesses of parameters, by name."""
    return {x.name: guesses[x.name] for x in unknowns if x.symbol is not None and guesses[x.name] is not None}


def _first(
    unknown: Any, guesses: Mapping[str, Any], numbers: Mapping[str, float], starts: Any, model: Model
) -> float:
    """Value of an unknown at which the search begins."""
    guess = guesses[unknown.name]
    if guess is None and unknown.symbol is None:
        initial = [{_name(model, k): v for k, v in start.items()}.get(unknown.name) for start in starts]
        guess = next((x for x in initial if x is not None), 0.0)
    if guess is None:
        return float(numbers[unknown.name])
    return number(model, numbers, guess, f"the guess of '{unknown.name}'")


def _measured(model: Model, run: Any, begin: float) -> tuple[Array, dict[str, Array]]:
    """Measured times, and measured quantities by name."""
    if hasattr(run, "data_vars"):
        columns = {str(k): np.asarray(v.values) for k, v in run.data_vars.items()}
        columns["time"] = np.asarray(run["time"].values)
    elif isinstance(run, Mapping):
        columns = {_name(model, k): v for k, v in run.items()}
    elif hasattr(run, "columns"):  # a table of pandas, or a similar one
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
                raise SimulationError(
                    f"Expected real numbers for the measured '{name}', got complex numbers."
                )
            if np.asarray(x).dtype.kind in "mM":  # as numbers they would be nanoseconds
                raise SimulationError(
                    f"Expected numbers for the measured '{name}', got dates or durations. Compute seconds from the "
                    "start as (t - t[0]) / np.timedelta64(1, 's')."
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
    """Standard deviations of all measured numbers, by quantity, for each measurement; 1 if they are estimated."""
    if sigma is not None and not isinstance(sigma, Mapping):
        raise SimulationError(
            f"Expected standard deviations by quantity, such as sigma={{'{quantities[0]}': 0.01}}, got {sigma!r}."
        )
    deviations = dict(sigma or {})
    for name in deviations:
        if name not in quantities:
            raise SimulationError(
                f"Expected measured quantities in sigma, {', '.join(quantities)}; got '{name}'."
            )
    if deviations and len(deviations) < len(quantities):
        missing = [name for name in quantities if name not in deviations]
        raise SimulationError(
            f"Expected sigma of all measured quantities or of none; that of {', '.join(missing)} is missing."
        )
    if not deviations and len(quantities) > 1:
        raise SimulationError(
            f"Expected sigma= for several measured quantities ({', '.join(quantities)}): it weighs their errors "
            "against each other. Pass their standard deviations, such as sigma={'theta': 0.01}."
        )
    result = []
    for times, columns in measured:
        weights = {}
        for name in columns:
            try:
                array = np.asarray(deviations.get(name, 1.0), dtype=float)
            except (TypeError, ValueError):
                array = np.array(math.nan)
            if array.ndim and array.shape != times.shape or not (array > 0).all():
                raise SimulationError(
                    f"Expected a standard deviation greater than 0 for '{name}', one number or {times.size}, got "
                    f"{deviations[name]!r}."
                )
            weights[name] = np.broadcast_to(array, times.shape)
        result.append(weights)
    return result


def _bounds(bounds: Any, names: list[str], first: Array) -> tuple[Array, Array]:
    """Least and greatest values of the unknowns."""
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


def _check_rank(J: Array, p: Array, names: list[str], size: float, with_contacts: bool) -> None:
    """Raise if the data do not tell the unknowns apart; the message names the direction in which nothing changes.

    Columns are scaled by their parameters. A column that is negligible relative to the ``size`` of the measurement is
    round-off, even if all columns are.
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
        listed = " and ".join(map(repr, idle or names))
        if with_contacts:
            at = ", ".join(f"{name} = {x:.6g}" for name, x in zip(names, p.tolist(), strict=True))
            raise SimulationError(
                f"The motion at {at} does not depend on {listed}, as it does not on friction where contacts stick or "
                "stay open. Begin elsewhere, or give starts=; leave out of unknown what no such motion depends on."
            )
        raise SimulationError(
            f"The measured motion does not depend on {listed}: it cannot be found "
            "from these data. Leave it out of unknown, or measure a quantity that depends on it."
        )
    _, singular, V = np.linalg.svd(scaled / lengths, full_matrices=False)
    if singular[-1] <= INDISTINCT * singular[0]:
        direction = V[-1] / lengths
        direction /= np.abs(direction).max()
        if direction[np.abs(direction).argmax()] < 0:
            direction = -direction
        changes = [
            f"{name} by {100 * x:+.3g} %" if q != 0 else f"{name} by {x:+.3g}"
            for name, x, q in zip(names, direction / 100, p, strict=True)
            if abs(x) > 1e-7
        ]
        raise SimulationError(
            f"The measured motion does not tell {', '.join(repr(m.split(' by ')[0]) for m in changes)} apart: changing "
            f"{', '.join(changes)} together does not change it. Give all but one of them in values=, or measure "
            "another quantity, such as a force, or a motion from other initial values."
        )


def _result(
    p: Array,
    computed: _Computed,
    names: list[str],
    measured: Any,
    sigma: Any,
    quantities: list[str],
    calls: int,
) -> Fit:
    """The fit with its covariance and residuals."""
    residuals, J, motions = computed
    lengths = np.linalg.norm(J, axis=0)
    _, singular, V = np.linalg.svd(J / lengths, full_matrices=False)
    covariance = (V.T / singular**2) @ V / np.outer(lengths, lengths)
    spread: dict[str, Any] = dict(sigma or {})
    cost, excess = float(residuals @ residuals), residuals.size - len(names)
    misfit = math.sqrt(cost / excess) if excess > 0 else math.nan
    if not sigma:
        covariance = covariance * misfit**2
        spread = {quantities[0]: misfit}
    differences: dict[str, list[Array]] = {name: [] for name in quantities}
    for (times, columns), motion in zip(measured, motions, strict=True):
        places = np.searchsorted(motion.t, times)
        for name, numbers in columns.items():
            differences[name].append(numbers - motion[name][places])
    return Fit(
        dict(zip(names, p.tolist(), strict=True)),
        dict(zip(names, np.sqrt(covariance.diagonal()).tolist(), strict=True)),
        covariance,
        {name: np.concatenate(parts) for name, parts in differences.items()},
        spread,
        tuple(motions),
        calls,
        cost,
        misfit,
        weighted=bool(sigma),
    )
