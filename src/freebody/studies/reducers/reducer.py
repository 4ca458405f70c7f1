"""What all reducers have in common: numbers of the lanes, groups, states that merge, and results as datasets.

    state of all lanes = state of block 1 ⊕ state of block 2 ⊕ ...

⊕ is exactly associative and commutative: neither the blocks, nor the workers, nor their order change a bit.

Source: Owen, Monte Carlo variance of scrambled net quadrature (1997), for the errors of Latin hypercubes.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self

import numpy as np

from ...errors import SimulationError, shown
from .number import Array, Number, check_names, number_of

if TYPE_CHECKING:
    import xarray

GROUPS = 4096
"""Greatest number of groups: distinct values of ``by``, multiplied over its names."""
ENTRIES = 1 << 20
"""Greatest number of entries of a state, of 16 bytes each: groups times entries of each."""
ERRORS = (
    "Standard errors of independent lanes. For a Latin hypercube they are an upper bound but for a factor "
    "sqrt(n/(n - 1)) (Owen 1997); for scrambled Sobol points the true ones fall faster as n grows."
)
"""What standard errors mean; an attribute of every result."""
Variable = tuple[tuple[str, ...], Any, dict[str, Any]]
"""Dimensions, array and attributes of a result; the array has one row for each group."""
NAMES = ("value", "error", "count", "low", "high", "lower", "upper", "effective", "correlation", "lane", "rank", "bin",
          "left", "right", "lanes", "below", "above", "quantile", "missing", "failed")  # fmt: skip
"""Names of the variables of results."""


class Part(Protocol):
    """State of one group."""

    @property
    def count(self) -> int:
        """Number of lanes."""

    def merge(self, other: Any) -> Self:
        """Return the state of the lanes of both."""


@dataclass(frozen=True)
class State:
    """State of a reducer after some lanes; its size does not depend on their number.

    ``by``       names of the groups
    ``limit``    greatest number of groups
    ``parts``    values of ``by`` -> state of that group, in the order of the values
    ``missing``  number of lanes that were left out, since the number has no finite value there
    """

    by: tuple[str, ...]
    limit: int
    parts: Mapping[tuple[float, ...], Any]
    missing: int = 0

    def __post_init__(self) -> None:
        check_groups(self.by, [len(set(values)) for values in zip(*self.parts, strict=True)], self.limit)

    def merge(self, other: State) -> State:
        """Return the state of the lanes of both, in either order."""
        parts = dict(self.parts)
        for key, part in other.parts.items():
            parts[key] = parts[key].merge(part) if key in parts else part
        ordered = {key: parts[key] for key in sorted(parts)}
        return State(self.by, self.limit, ordered, self.missing + other.missing)


def check_groups(by: Sequence[str], sizes: Sequence[int], limit: int) -> None:
    """Refuse too many groups.

    Raises
    ------
    SimulationError
        More groups than fit into a state.
    """
    if math.prod(sizes) > limit:
        counts = " x ".join(map(str, sizes))
        raise SimulationError(
            f"Expected at most {limit} groups by {', '.join(by)}, got {counts}. Group by fewer names, or by a coarser "
            f'number such as by="floor({by[0]})"{"" if limit == GROUPS else ", or take fewer buckets, bins or values"}.'
        )


@dataclass(frozen=True)
class Reducer(ABC):
    """A statistic of one or two numbers of each run, over all runs.

    ``numbers``   numbers of a run
    ``by``        numbers whose distinct values are groups
    ``skipped``   True if lanes are left out where a number has no finite value; else they are refused
    ``wanted``    outputs that a run must have, such as ``"max(theta')"``
    ``names``     other names that the numbers read, such as ``"I"``, ``"end"``, ``'event_time["hit"]'``
    """

    numbers: tuple[Number, ...]
    by: tuple[Number, ...]
    skipped: bool = field(kw_only=True, default=False)

    title: ClassVar[str]
    has_error: ClassVar[bool] = True
    """True if the result has a standard error."""
    takes_weights: ClassVar[bool] = False

    # -- what it reads ----------------------------------------------------------------------------------------

    @property
    def wanted(self) -> tuple[str, ...]:
        """Outputs that must be asked of the run."""
        return tuple(dict.fromkeys(x for number in (*self.numbers, *self.by) for x in number.wanted))

    @property
    def names(self) -> tuple[str, ...]:
        """Other names: parameters, starts, ``end``, ``steps``, ``event_time["hit"]``."""
        return tuple(dict.fromkeys(x for number in (*self.numbers, *self.by) for x in number.names))

    @property
    def of_condition(self) -> bool:
        """True if the number is a condition."""
        return self.numbers[0].condition

    def check(self, known_names: Iterable[str]) -> None:
        """Refuse names that no run of the study has.

        Raises
        ------
        SimulationError
            Names the nearest known name.
        """
        check_names(self.names, known_names, repr(self))

    def __repr__(self) -> str:
        by = [number.text for number in self.by]
        arguments = [repr(number.text) for number in self.numbers] + self.options()
        arguments += [f"by={by[0]!r}" if len(by) == 1 else f"by={by!r}"] if by else []
        arguments += ['missing="skip"'] if self.skipped else []
        return f"{self.title}({', '.join(arguments)})"

    def options(self) -> list[str]:
        """Return the other arguments, as in a call."""
        return []

    # -- states -----------------------------------------------------------------------------------------------

    @property
    def entries(self) -> int:
        """Greatest number of entries of the state of one group."""
        return 1

    @property
    def limit(self) -> int:
        """Greatest number of groups."""
        return max(1, min(GROUPS, ENTRIES // self.entries))

    def of(self, columns: Mapping[str, Any], lanes: Any, weights: Any = None) -> State:
        """Return the state of the good lanes of a block.

        Parameters
        ----------
        columns : mapping of name to array, (lanes,)
            Columns of ``wanted`` and ``names``.
        lanes : int array, (lanes,)
            Numbers of the lanes, for messages and for extremes.
        weights : array, (lanes,), optional
            Ratio of the densities of the lane, of the study and of the sample (importance sampling).

        Raises
        ------
        SimulationError
            A number without a finite value, too many groups, or weights that the reducer cannot take.
        """
        lanes = np.asarray(lanes, dtype=np.int64)
        values = [number.of(columns, len(lanes)) for number in self.numbers]
        return self.state(values, columns, lanes, weights)

    def of_failed(self, columns: Mapping[str, Any], lanes: Any, weights: Any = None) -> State:
        """Return the state of lanes that failed, counted as lanes in which the condition holds."""
        lanes = np.asarray(lanes, dtype=np.int64)
        return self.state([np.ones(len(lanes)) for _ in self.numbers], columns, lanes, weights)

    def state(self, values: list[Array], columns: Mapping[str, Any], lanes: Any, weights: Any) -> State:
        """Return the state of lanes with these values."""
        if weights is not None:
            values = [*values, self.weights(weights, lanes)]
        groups = [number.of(columns, len(lanes)) + 0.0 for number in self.by]  # -0.0 + 0.0 = 0.0
        absent = np.zeros(len(lanes), dtype=bool)
        for x in values:
            absent |= np.isnan(x)
        for number, x in zip(self.by, groups, strict=True):
            if np.isnan(x).any():
                self.refuse(number, lanes[np.isnan(x)])
        if absent.any():
            if not self.skipped:
                number = next(
                    n for n, x in zip(self.numbers, values, strict=False) if np.isnan(x[absent.argmax()])
                )
                self.refuse(number, lanes[np.isnan(values[self.numbers.index(number)])])
            values, groups, lanes = (
                [x[~absent] for x in values],
                [x[~absent] for x in groups],
                lanes[~absent],
            )
        names = tuple(number.text for number in self.by)
        parts = {
            key: self.part([x[rows] for x in values], lanes[rows], weights is not None)
            for key, rows in _rows_of(names, groups, len(lanes), self.limit)
        }
        return State(names, self.limit, parts, int(absent.sum()))

    def refuse(self, number: Number, lanes: Any) -> None:
        """Refuse a number without a finite value."""
        cures = ['missing="skip" leaves such runs out']
        events = [x for x in number.names if x.startswith(("event_time", "event_last"))]
        if events:
            happened = "event_count" + events[0][len("event_time") :]
            cures.insert(
                0, f"an event that did not happen has no time; a condition may begin with {happened} > 0 and"
            )
        raise SimulationError(
            f"Expected a finite number in every run for {self!r}, but {number.text!r} has none in lane {lanes.min()}: "
            f"{'; '.join(cures)}."
        )

    def weights(self, weights: Any, lanes: Any) -> Array:
        """Return checked weights.

        Raises
        ------
        SimulationError
            The reducer takes none, or a weight is negative or not finite.
        """
        if not self.takes_weights:
            raise SimulationError(
                f"Expected no weights for {self!r}: only fb.mean takes them. Write a mean, such as the fraction "
                'fb.mean("max(x) > 6").'
            )
        weights = np.asarray(weights, dtype=float)
        bad = ~(np.isfinite(weights) & (weights >= 0))
        if weights.shape != lanes.shape or bad.any():
            where = (
                f"lane {lanes[bad].min()}" if weights.shape == lanes.shape else f"the shape {weights.shape}"
            )
            raise SimulationError(f"Expected one finite weight of at least 0 for each lane, got {where}.")
        return weights

    @abstractmethod
    def part(self, values: list[Array], lanes: Any, weighted: bool) -> Part:
        """Return the state of the lanes of one group."""

    # -- results ----------------------------------------------------------------------------------------------

    def result(self, state: State, failures: int = 0, failed: str = "raise") -> xarray.Dataset:
        """Return the result of a state.

        Parameters
        ----------
        state : State
        failures : int, optional
            Number of lanes that failed.
        failed : {"raise", "skip", "count"}, optional
            What they mean; see `failures`.

        Returns
        -------
        xarray.Dataset
            ``value``, its standard ``error``, the ``count`` of lanes, and more by the kind of the reducer; by the
            groups, if there are any. ``missing`` and ``failed`` are lanes that have no number, and that failed.
        """
        import xarray

        if not self.by and not state.parts:
            state = State(
                (), self.limit, {(): self.part([np.zeros(0) for _ in self.numbers], np.zeros(0, int), False)}
            )
        axes = [np.unique([key[i] for key in state.parts]) for i in range(len(self.by))]
        shape = tuple(len(axis) for axis in axes)
        names = tuple(x.text for x in self.by)
        places = tuple(np.searchsorted(axis, [key[i] for key in state.parts]) for i, axis in enumerate(axes))
        variables, coordinates = self.variables(list(state.parts.values()))
        arrays: dict[str, Variable] = {}
        for name, (inner, rows, about) in variables.items():
            rows = np.asarray(rows)
            whole = np.nan if rows.dtype.kind == "f" else -1 if name == "lane" else 0
            array = np.full((*shape, *rows.shape[1:]), whole, dtype=rows.dtype)
            array[places if names else ...] = rows if names else rows[0]
            arrays[name] = ((*names, *inner), array, about)
        about = {"failed_means": failed, "long_name": "runs that failed" + _MEANS.get(failed, "")}
        arrays["missing"] = (
            (),
            state.missing,
            {"long_name": "runs left out, since the number has no finite value"},
        )
        arrays["failed"] = ((), failures, about)
        coordinates |= {name: ((name,), axis, {}) for name, axis in zip(names, axes, strict=True)}
        result = xarray.Dataset(arrays, coords=coordinates, attrs={"reducer": repr(self), "errors": ERRORS})
        result.attrs["summary"] = summary(result)
        return result

    @abstractmethod
    def variables(self, parts: list[Any]) -> tuple[dict[str, Variable], dict[str, Any]]:
        """Return variables with one row for each group, and coordinates."""


_MEANS = {"count": ", counted as runs in which the condition holds", "skip": ", left out"}


def summary(result: xarray.Dataset) -> str:
    """Return a line on a result: value, standard error and number of runs, or the sizes of its dimensions.

    >>> import freebody as fb, numpy as np
    >>> p = fb.mean("max(x) > 2")
    >>> p.result(p.of({"max(x)": np.arange(10)}, np.arange(10))).summary
    '0.70 ± 0.15 (10 runs)'
    """
    runs = f"{int(result['count'].sum()):,} runs"
    if result["value"].ndim:
        return f"{' x '.join(f'{size} {name}' for name, size in result['value'].sizes.items())} ({runs})"
    value = float(result["value"])
    error = float(result["error"]) if "error" in result else math.nan
    if not (math.isfinite(error) and error > 0 and math.isfinite(value)):
        return f"{value:.6g} ({runs})"
    digits = max(0, 1 - math.floor(math.log10(error)))
    if digits > 15 or abs(value) >= 1e6:
        return f"{value:.6g} ± {error:.2g} ({runs})"
    return f"{value:.{digits}f} ± {error:.2g} ({runs})"


def _rows_of(names: Sequence[str], groups: list[Array], count: int, limit: int) -> Iterable[tuple[Any, Any]]:
    """Return the values of each group with the rows of its lanes, in the order of the values."""
    if not count:
        return []
    if not groups:
        return [((), slice(None))]
    split = [np.unique(x, return_inverse=True) for x in groups]
    check_groups(names, [len(values) for values, _ in split], limit)
    codes: Any = np.zeros(count, dtype=np.int64)
    for values, inverse in split:
        codes = codes * len(values) + inverse.reshape(-1)
    order = np.argsort(codes, kind="stable")
    edges = np.flatnonzero(np.diff(codes[order], prepend=-1))
    return [(tuple(float(x[rows[0]]) for x in groups), rows) for rows in np.split(order, edges[1:])]


def numbers_of(texts: Sequence[Any], title: str, by: Any) -> dict[str, Any]:
    """Return the numbers and the groups of a reducer, by the names of its fields.

    Raises
    ------
    SimulationError
        A text that is no number of a run, a group by a condition's values or by the name of a result.
    """
    names = [] if by is None else [by] if isinstance(by, str) else by
    if not isinstance(names, Sequence):
        raise SimulationError(f"Expected a name or a list of names for by= of {title}, got {shown(by)}.")
    groups = tuple(number_of(name, f"by= of {title}") for name in names)
    for number in groups:
        if number.text in NAMES or [x.text for x in groups].count(number.text) > 1:
            raise SimulationError(
                f"Expected other names for by= of {title} than {', '.join(NAMES)}, each once, got '{number.text}'. "
                f'Write an expression of it, such as by="{number.text} + 0".'
            )
    return {"numbers": tuple(number_of(text, title) for text in texts), "by": groups}


def is_skipped(missing: Any, title: str) -> bool:
    """Return True if lanes without a number are left out.

    Raises
    ------
    SimulationError
        Neither "raise" nor "skip".
    """
    if not isinstance(missing, str) or missing not in ("raise", "skip"):
        raise SimulationError(
            f'Expected missing="raise" or missing="skip" for {title}, got {shown(missing)}.'
        )
    return missing == "skip"
