"""Laws of lanes: the values of the lanes of a study as a function of the lane's number.

A law is a value of a few kilobytes, whatever the number of its lanes. It is pickled, has a content that
`content_digest.digest` reads, and computes the values of any range of lanes where these run. A lane has the same
values, to the last bit, however its range is cut.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...dynamics.conditions.mobility import check_bodies
from ...errors import ModelError, SimulationError, nearest, shown
from ...model import Model
from ...model.values import check_assumptions
from ...motion.batch.start import Lanes, lanes_of, numbers_in
from ...motion.start.initial import quaternions_by_joint

Array = NDArray[np.float64]
Self = TypeVar("Self", bound="Law")

MOST_CHECKED = 1_000_000
"""Number of lanes up to which every lane is checked; of more lanes, the first ``CHECKED`` are."""
CHECKED = 1 << 20
_CHUNK = 1 << 16
"""Number of lanes that are checked at a time."""


class Law(ABC):
    """The values of the lanes of a study, by the lane's number: made by `fb.grid`, `fb.table` and `fb.sample`."""

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of lanes."""

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Names of the parameters and initial values that vary."""

    @abstractmethod
    def columns(self, low: int, high: int) -> dict[str, Array]:
        """Return the values of the lanes ``low`` to ``high`` - 1 by name, each of shape (high - low,)."""

    @abstractmethod
    def resolved(self: Self, model: Model, where: str = "lanes") -> Self:
        """Return the law with names of the model, and numbers in place of texts; ``where`` is for messages."""

    def part(self: Self, low: int, high: int) -> Self:
        """Return a small law with the same values in the lanes ``low`` to ``high`` - 1, for another process."""
        self._check(low, high)
        return self

    def weights(self, low: int, high: int) -> Array | None:
        """Return the importance weights of the lanes, shape (high - low,); None if all are 1."""
        self._check(low, high)
        return None

    def impossible(
        self, model: Model, values: Mapping[Any, Any] | None = None
    ) -> tuple[int, int, int | None]:
        """Return the number of lanes in which no such machine can exist, of how many, and the first of them.

        Up to ``MOST_CHECKED`` lanes are checked; beyond, the first ``CHECKED``. ``values`` are the parameters that are
        the same in all lanes.
        """
        of = self.count if self.count <= MOST_CHECKED else CHECKED
        if not any(name in model.defaults for name in self.names):
            return (
                (0, of, None) if reason_against(lanes_of(model, values or {}, {}), 0) is None else (of, of, 0)
            )
        count, first = 0, None
        for low in range(0, of, _CHUNK):
            lanes = self.machines(model, low, min(low + _CHUNK, of), values)
            bad, clear = lanes.impossible(constants=True)
            for lane in np.flatnonzero(bad & ~clear):  # as a run of the lane decides
                clear[lane] = reason_against(lanes, int(lane)) is not None
            if first is None and clear.any():
                first = low + int(clear.argmax())
            count += int(clear.sum())
        return count, of, first

    def machines(self, model: Model, low: int, high: int, values: Mapping[Any, Any] | None = None) -> Lanes:
        """Return the parameters of the lanes ``low`` to ``high`` - 1, without initial values."""
        columns = {name: x for name, x in self.columns(low, high).items() if name in model.defaults}
        return lanes_of(model, {**(values or {}), **columns}, {})

    def _check(self, low: int, high: int) -> None:
        if not 0 <= low <= high <= self.count:
            raise SimulationError(f"Expected lanes from 0 to {self.count}, got {low} to {high}.")

    def _counted(self) -> str:
        return "1 lane" if self.count == 1 else f"{self.count} lanes"


def reason_against(lanes: Lanes, lane: int) -> str | None:
    """Return why the machine of a lane cannot exist; None if it can."""
    try:
        check_bodies(lanes.model, lanes.values_of(lane))
        check_assumptions(lanes.model, lanes.values_of(lane))
    except ModelError as error:
        return str(error)
    return None


def by_name(entries: Any, others: Mapping[str, Any], call: str) -> dict[str, Any]:
    """Return what varies by the text of its name, from one mapping or from keyword arguments."""
    if entries is not None and others:
        raise SimulationError(
            f"Expected one mapping or keyword arguments for {call}(), got both. Leave one out."
        )
    entries = others if entries is None else entries
    if not isinstance(entries, Mapping) or not entries:
        raise SimulationError(
            f"Expected values by name, such as {call}({{'theta': [0.1, 0.2]}}), got "
            f"{shown(entries) if entries else 'none'}."
        )
    result: dict[str, Any] = {}
    for key, value in entries.items():
        if str(key) in result:
            raise SimulationError(f"Expected each name once in {call}(), got '{key}' twice. Leave one out.")
        result[str(key)] = value
    return result


def names_in(model: Model, names: Iterable[str], where: str) -> list[str]:
    """Return the names of parameters, coordinates and speeds that texts stand for; ``where`` is for messages."""
    known = [*model.defaults, *model.state_names]
    atoms = {str(atom): text for atom, text in model.names.texts.items()}  # theta(t) is theta
    result: list[str] = []
    for text in names:
        name = text if text in known else atoms.get(text, text)
        if name in quaternions_by_joint(model):
            start = quaternions_by_joint(model)[name]
            four = model.coordinate_names[start : start + 4]
            raise SimulationError(
                f"Expected names of single numbers in {where}, but the joint '{name}' starts with a quaternion. Vary "
                f"its components {', '.join(four)}, which are scaled to length 1; four standard normal distributions "
                "make every rotation equally likely."
            )
        if name not in known:
            raise SimulationError(f"Unknown name '{name}' in {where}; {nearest(name, known)}")
        if name in result:
            raise SimulationError(f"Expected each name once in {where}, got '{name}' twice. Leave one out.")
        result.append(name)
    return result


def check_apart(model: Model, law: Law, values: Any, initial: Any, where: str = "lanes") -> None:
    """Refuse names that vary and have a value that is the same in all lanes."""
    for argument, others in (("values", values), ("initial", initial)):
        for key in others or ():
            name = model.names.text_of(key)
            if name in law.names:
                raise SimulationError(f"'{name}' is in {where}= and in {argument}=. Leave one out.")


def numbers_from(entries: Any, name: str, where: str, model: Model | None = None) -> Any:
    """Return entries as an array of floats that cannot be written to; texts wait, as a tuple, for a model."""
    try:
        if isinstance(entries, np.ndarray) and entries.ndim and entries.dtype.kind in "OUT":
            entries = entries.tolist()
        if isinstance(entries, list | tuple) and any(isinstance(x, str) for x in entries):
            if model is None:
                return tuple(entries)
            entries = numbers_in(model, entries, name, f"values of '{name}' in {where}")
        if np.asarray(entries).dtype.kind in "cmM":
            raise TypeError
        array = np.array(entries, dtype=float)
    except (TypeError, ValueError):
        raise SimulationError(f"Expected numbers for '{name}' in {where}, got {entries!r}.") from None
    array.setflags(write=False)
    return array
