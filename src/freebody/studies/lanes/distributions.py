"""Distributions of one number: quantile function, density, support, and a content that tells them apart."""

from __future__ import annotations

import io
import pickle
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import cloudpickle
import numpy as np

from ...errors import SimulationError, shown
from ...model import Model
from ..identity.content_digest import NoContentError, digest
from .law import Array, numbers_from


@dataclass(frozen=True)
class Uniform:
    """Uniform distribution between two numbers, or two texts with units until it is resolved."""

    low: Any
    high: Any

    def quantile(self, p: Array) -> Array:
        """Return the values below which lies the probability p."""
        return self.low + (self.high - self.low) * p

    def density(self, x: Array) -> Array:
        """Return the density at x."""
        return np.where((self.low <= x) & (x <= self.high), 1 / (self.high - self.low), 0.0)

    def support(self) -> tuple[float, float]:
        """Return the smallest and the greatest value."""
        return self.low, self.high

    def resolved(self, model: Model, name: str, where: str) -> Uniform:
        """Return the distribution with numbers in place of texts."""
        return _between((self.low, self.high), name, where, model)

    def __str__(self) -> str:
        return f"uniform({_number(self.low)}, {_number(self.high)})"


@dataclass(frozen=True, eq=False)
class Distribution:
    """A distribution with `ppf` (scipy.stats) or `icdf` (the newer distributions of SciPy).

    ``content``        digest of the distribution, without its memory of earlier calls and its random numbers
    ``text``           how it is shown
    ``distribution``   the object, of which content and text tell all
    """

    content: str
    text: str
    distribution: Any = field(compare=False)

    def __reduce__(self) -> Any:
        return _unpacked, (self.content, self.text, _packed(self.distribution))

    def quantile(self, p: Array) -> Array:
        """Return the values below which lies the probability p."""
        d = self.distribution
        return np.asarray(d.ppf(p) if hasattr(d, "ppf") else d.icdf(p), dtype=float)

    def density(self, x: Array) -> Array:
        """Return the density at x; of a discrete distribution, the probability."""
        d = self.distribution
        return np.asarray(d.pmf(x) if self.discrete else d.pdf(x), dtype=float)

    @property
    def discrete(self) -> bool:
        """True if values have probabilities, not densities."""
        kind = type(self.distribution)
        # the newer distributions of SciPy have both; pmf of some of its continuous ones never ends
        return hasattr(kind, "pmf") and (
            not hasattr(kind, "pdf") or any(base.__name__ == "DiscreteDistribution" for base in kind.__mro__)
        )

    def support(self) -> tuple[float, float]:
        """Return the smallest and the greatest value."""
        low, high = self.distribution.support()
        return float(low), float(high)

    def resolved(self, model: Model, name: str, where: str) -> Distribution:
        """Return the distribution itself: it has numbers only."""
        return self

    def __str__(self) -> str:
        return self.text


Marginal = Uniform | Distribution


def marginal(value: Any, name: str) -> Marginal:
    """Return the distribution of a name: a pair is uniform, others have `ppf` or `icdf`."""
    if isinstance(value, tuple | list) and len(value) == 2:
        return _between(value, name, "the sample", None)
    pair = f"or a pair (low, high) for '{name}'"
    if isinstance(value, type) or _is_family(value) or not (hasattr(value, "ppf") or hasattr(value, "icdf")):
        raise SimulationError(
            f"Expected a distribution with its parameters, such as scipy.stats.norm(0.5, 0.05), {pair}, got "
            f"{shown(value)}."
        )
    try:
        own = pickle.loads(_packed(value))
        content = digest(_content(value))
    except (NoContentError, TypeError, AttributeError, pickle.PicklingError) as error:
        raise SimulationError(
            f"Expected a distribution whose content can be read and sent to other processes, {pair}, got "
            f"{shown(value)}: {error.args[0]!r}."
        ) from None
    result = Distribution(content, _text(value), own)
    _probe(result, value, name)
    return result


def _probe(result: Distribution, original: Any, name: str) -> None:
    """Refuse distributions of several numbers, quantile functions that do not increase, and copies that differ."""
    p = np.array([0.25, 0.5, 0.75])
    try:
        values = result.quantile(p)
        others = Distribution("", "", original).quantile(p)
        shapes = (values.shape, result.quantile(p[:2]).shape)
    except Exception as error:
        raise SimulationError(
            f"Expected a distribution with quantiles for '{name}', but {result} has none: {error}."
        ) from None
    if shapes != ((3,), (2,)):
        raise SimulationError(
            f"Expected a distribution of one number for '{name}', but {result} has quantiles of shape {values.shape} "
            "for 3 probabilities. Name each number."
        )
    if not (np.isfinite(values).all() and values[0] <= values[1] <= values[2]):
        raise SimulationError(
            f"Expected finite quantiles that do not decrease for '{name}', but {result} has {values.tolist()} at 25, "
            "50 and 75 %. Check its parameters."
        )
    if not np.array_equal(values, others):
        raise SimulationError(
            f"Expected a distribution whose copies are equal to it, so that it can be sent to other processes, for "
            f"'{name}', but {result} has {others.tolist()} at 25, 50 and 75 %, and its copy {values.tolist()}. Take a "
            "distribution of scipy.stats, such as scipy.stats.norm(0.5, 0.05)."
        )


def check_proposal(target: Marginal, proposal: Marginal, name: str) -> None:
    """Refuse a pair of distributions whose weights target/proposal do not make every mean right."""
    for what, x in (("target", target), ("proposal", proposal)):
        if isinstance(x, Distribution) and not (
            hasattr(x.distribution, "support")
            and (hasattr(x.distribution, "pdf") or hasattr(x.distribution, "pmf"))
        ):
            raise SimulationError(
                f"Expected distributions with pdf() and support() for the weights of '{name}', but the {what} {x} "
                "lacks them. Take distributions of scipy.stats."
            )
    kinds = [isinstance(x, Distribution) and x.discrete for x in (target, proposal)]
    if kinds[0] != kinds[1]:
        raise SimulationError(
            f"Expected two densities or two discrete distributions for '{name}', got {target} with the proposal "
            f"{proposal}. Take a proposal of the same kind."
        )
    (a, b), (low, high) = target.support(), proposal.support()
    if a < low or b > high:
        raise SimulationError(
            f"Expected a proposal for '{name}' that reaches all values of its distribution, {a:g} to {b:g}, but "
            f"{proposal} reaches {low:g} to {high:g}: means would miss the rest without a sign. Take a wider proposal."
        )


def _between(pair: Any, name: str, where: str, model: Model | None) -> Uniform:
    """Return the uniform distribution on a pair (low, high)."""
    array = numbers_from(list(pair), name, where, model)
    if not isinstance(array, np.ndarray):
        return Uniform(*array)
    if array.shape != (2,) or not (np.isfinite(array).all() and array[0] < array[1]):
        raise SimulationError(
            f"Expected a pair (low, high) of finite numbers with low < high for '{name}' in {where}, got {pair!r}."
        )
    low, high = array.tolist()
    return Uniform(low, high)


def _is_family(x: Any) -> bool:
    """Return True for a family of distributions, such as scipy.stats.norm without parameters."""
    families = sys.modules.get("scipy.stats")
    return hasattr(x, "freeze") and getattr(families, str(getattr(x, "name", None)), None) is x


_FORGOTTEN = ("_random_state", "rng", "_rng", "_moment_methods")


def _content(x: Any) -> Any:
    """Return what tells a distribution of SciPy from others, without caches and states of random numbers.

    scipy.stats distributions refer to the global random numbers of NumPy, and the newer ones remember results.
    """
    if isinstance(x, dict):
        return {key: _content(value) for key, value in x.items()}
    if isinstance(x, list | tuple):
        return [_content(value) for value in x]
    kind = type(x)
    if isinstance(x, type) or not _is_of_scipy(kind):
        return x
    state = x.__getstate__()
    if not isinstance(state, Mapping):
        return x
    return kind, {
        name: _content(value)
        for name, value in sorted(state.items())
        if not name.endswith("_cache") and name not in _FORGOTTEN
    }


class _Packer(cloudpickle.Pickler):
    """Pickles distributions; the newer ones of SciPy as class and state, without their caches.

    In SciPy 1.17 a plain copy of Normal(mu=1, sigma=2), also by pickle, is a StandardNormal, since Normal.__new__ makes
    one if it is called without arguments.
    """

    def reducer_override(self, x: Any) -> Any:
        if isinstance(x, type) or not (hasattr(type(x), "icdf") and _is_of_scipy(type(x))):
            return super().reducer_override(x)
        state = {
            name: _emptied(value) if name.endswith("_cache") else value for name, value in vars(x).items()
        }
        return object.__new__, (type(x),), state


def _emptied(cache: Any) -> Any:
    return {} if isinstance(cache, dict) else None


def _packed(x: Any) -> bytes:
    """Return a distribution as bytes that `pickle.loads` reads."""
    with io.BytesIO() as file:
        _Packer(file).dump(x)
        return file.getvalue()


def _unpacked(content: str, text: str, distribution: bytes) -> Distribution:
    return Distribution(content, text, pickle.loads(distribution))


def _is_of_scipy(kind: type) -> bool:
    return any(base.__module__.startswith("scipy.stats") for base in kind.__mro__)


def _text(x: Any) -> str:
    """Return the name of a distribution with its parameters: norm(0.5, 0.05)."""
    if hasattr(x, "dist") and hasattr(x, "args"):
        arguments = [*map(_number, x.args), *(f"{name}={_number(value)}" for name, value in x.kwds.items())]
        return f"{getattr(x.dist, 'name', None) or type(x.dist).__name__}({', '.join(arguments)})"
    text = " ".join(str(x).split())
    return shown(x) if " at 0x" in text else text


def _number(x: Any) -> str:
    return f"{x:g}" if isinstance(x, int | float) else str(x)
