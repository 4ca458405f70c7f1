"""Fits: the parameters and initial values with which a motion is closest to a measurement.

    minimize  Σ ((x_k(p) - measured_k) / σ_k)²,        covariance of p:  (Jᵀ J)⁻¹,    J_kj = (∂x_k/∂p_j) / σ_k

J is exact: the derivatives are integrated together with the motion (`sensitivity`). If σ is not known, it is taken
as equal for all measurements and estimated from the residuals r, σ² = Σ r² / (N - n).

Sources: Nocedal and Wright, Numerical Optimization (2006), section 10.3; Bard, Nonlinear Parameter Estimation (1974),
section 7.5.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import sympy

from ..errors import SimulationError, arguments_named
from ..motion.kernels.kernels import kernels_of
from ..motion.legs.variation import unknowns_of
from ..motion.start.initial import number, quaternions_by_joint
from .comparison import Comparison, Computed
from .measurement import Array, bounds_of, check_rank, measured_by, name_of, weighted, weights_of
from .minima import Minimum, best_of

if TYPE_CHECKING:
    from ..model.model import Model
    from ..motion.trajectory.trajectory import Trajectory


_RESERVED = ("times", "samples", "sensitivities", "outputs", "store", "executor", "threads")
"""Options of `simulate` that a fit sets itself, or that belong to a batch."""


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
    _check_free(model, unknowns)
    begin = number(model, kernels.values(values), start, "start")
    for option in _RESERVED:
        if option in options:
            raise SimulationError(
                f"Expected no {option}= for a fit, got {options[option]!r}: the measured times and unknown= set it. "
                "Leave it out."
            )
    measured = [measured_by(model, run, begin) for run in runs]
    quantities = list(dict.fromkeys(name for run in measured for name in run[1]))
    if not quantities:
        raise SimulationError("Expected at least one measured quantity besides the time, got none.")
    fixed_values = {**(values or {})}
    value_names = {name_of(model, key) for key in fixed_values}
    initial_names = {name_of(model, key) for initial_values in initials for key in initial_values}
    for x in unknowns:
        fixed_names = value_names if x.symbol is not None else initial_names
        if guesses[x.name] is not None and x.name in fixed_names:
            where = "values=" if x.symbol is not None else "initial="
            raise SimulationError(
                f"'{x.name}' has a first guess in unknown= and a value in {where}. Leave one out."
            )
    numbers = model.values(fixed_values | _parameter_guesses(unknowns, guesses))
    first = np.array([_first(x, guesses, numbers, initials, model) for x in unknowns])
    fixed = [{name_of(model, k): v for k, v in one.items()} for one in initials]
    comparison = Comparison(
        s, unknowns, measured, weights_of(sigma, quantities, measured), fixed, fixed_values,
        bounds_of(bounds, names, first), {**options, "near": near, "start": start, "tolerance": tolerance},
    )  # fmt: skip

    from scipy.optimize import least_squares

    residuals, J, _ = comparison.at(first)
    if residuals.size < len(names):
        raise SimulationError(
            f"Expected at least as many measured numbers as unknowns, got {residuals.size} for {len(names)}."
        )
    size = math.hypot(*(float(np.linalg.norm(x)) for x in weighted(measured, comparison.weights)))
    with_contacts = bool(model.contacts or model.families)
    # contacts that stick at the first guess may slip where the search goes
    if not (with_contacts and J.any()):
        check_rank(J, first, names, size, with_contacts)
    scale = np.where(first != 0, np.abs(first), 1.0)
    solved = least_squares(
        lambda p: comparison.residuals(p, residuals.size), first, jac=lambda p: comparison.at(p).jacobian,
        bounds=comparison.bounds, x_scale=scale, method="trf", xtol=1e-13, ftol=1e-13, gtol=1e-13, max_nfev=200,
    )  # fmt: skip
    if solved.status == 0:
        raise SimulationError(
            f"The search did not end in {solved.nfev} steps; it is at "
            f"{', '.join(f'{n} = {x:.6g}' for n, x in zip(names, solved.x, strict=True))}. Begin nearer: pass guesses, "
            "unknown={'m': 1.0}."
        )
    result = comparison.at(solved.x)
    check_rank(result.jacobian, solved.x, names, size, with_contacts)
    return _result(solved.x, result, names, measured, sigma, quantities, comparison.calls)


def _check_free(model: Model, unknowns: Sequence[Any]) -> None:
    """Refuse components of unit quaternions, which are not free."""
    for x in unknowns:
        for joint, k in quaternions_by_joint(model).items():
            if k <= x.place < k + 4:
                raise SimulationError(
                    f"Expected unknowns that are free, got '{x.name}', a component of the unit quaternion of joint "
                    f"'{joint}'. Fit a joint with Euler angles (gimbal), or its speeds."
                )


def _listed(unknown: Any) -> list[Any]:
    """Unknowns as a list."""
    if isinstance(unknown, str) or not isinstance(unknown, Sequence):
        return [unknown]
    return list(unknown)


def _parameter_guesses(unknowns: Sequence[Any], guesses: Mapping[str, Any]) -> dict[str, Any]:
    """First guesses of parameters, by name."""
    return {x.name: guesses[x.name] for x in unknowns if x.symbol is not None and guesses[x.name] is not None}


def _first(
    unknown: Any, guesses: Mapping[str, Any], numbers: Mapping[str, float], starts: Any, model: Model
) -> float:
    """Value of an unknown at which the search begins."""
    guess = guesses[unknown.name]
    if guess is None and unknown.symbol is None:
        initial = [{name_of(model, k): v for k, v in start.items()}.get(unknown.name) for start in starts]
        guess = next((x for x in initial if x is not None), 0.0)
    if guess is None:
        return float(numbers[unknown.name])
    return number(model, numbers, guess, f"the guess of '{unknown.name}'")


def _result(
    p: Array,
    computed: Computed,
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
