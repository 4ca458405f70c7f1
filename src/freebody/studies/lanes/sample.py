"""Samples of lanes: each lane draws its values from distributions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...errors import SimulationError, arguments_named, nearest
from ...model import Model
from .distributions import Marginal, Uniform, check_proposal, marginal
from .draws import KINDS, Draws
from .law import Array, Law, by_name, names_in

_BLOCK = 1 << 13
"""Number of lanes whose quantiles are computed in one call, always the same lanes together.

Vectorised functions may round the last numbers of an array in another way than the others; so that a lane has the same
bits in every range, blocks begin at multiples of this number and end there or at the last lane of all."""
_CHUNK = 8 * _BLOCK


@dataclass(frozen=True, eq=False, repr=False)
class Sample(Law):
    """Lanes that draw their values from distributions.

    ``marginals``   (name, distribution) of each name
    ``lanes``       number of lanes
    ``proposals``   (name, distribution) of the names that are drawn from another distribution
    """

    marginals: tuple[tuple[str, Marginal], ...]
    lanes: int
    by: str
    seed: int
    proposals: tuple[tuple[str, Marginal], ...] = ()

    @property
    def count(self) -> int:
        """Number of lanes."""
        return self.lanes

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the distributions."""
        return tuple(name for name, _ in self.marginals)

    @cached_property
    def _draws(self) -> Draws:
        """Draws of all lanes; making those of a sequence takes as long as a small block."""
        return KINDS[self.by](len(self.marginals), self.lanes, self.seed)

    def __getstate__(self) -> dict[str, Any]:
        return {x.name: getattr(self, x.name) for x in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def columns(self, low: int, high: int) -> dict[str, Array]:
        """Return the values of the lanes ``low`` to ``high`` - 1 by name."""
        self._check(low, high)
        draws, proposals = self._draws, dict(self.proposals)
        result = {}
        for j, (name, distribution) in enumerate(self.marginals):
            distribution = proposals.get(name, distribution)
            if isinstance(distribution, Uniform) and isinstance(distribution.low, str):
                raise SimulationError(
                    f"Expected numbers for '{name}', got texts. resolved(model) reads their units."
                )
            result[name] = self._values(draws, j, name, distribution, low, high)
        return result

    def weights(self, low: int, high: int) -> Array | None:
        """Return Π target density / proposal density of the lanes ``low`` to ``high`` - 1; None without proposals."""
        self._check(low, high)
        if not self.proposals:
            return None
        targets = dict(self.marginals)
        # whole blocks again, for the densities too
        first, last = low // _BLOCK * _BLOCK, min(-(-high // _BLOCK) * _BLOCK, self.lanes)
        columns = self.columns(first, max(first, last))
        result = np.ones(max(first, last) - first)
        with np.errstate(divide="ignore", invalid="ignore"):
            for name, proposal in self.proposals:
                for start in range(0, result.size, _BLOCK):
                    x = columns[name][start : start + _BLOCK]
                    result[start : start + _BLOCK] *= targets[name].density(x) / proposal.density(x)
        result = result[low - first : high - first]
        if not np.isfinite(result).all():
            lane = int(np.flatnonzero(~np.isfinite(result))[0])
            values = ", ".join(
                f"{name} = {columns[name][low - first + lane]:g}" for name, _ in self.proposals
            )
            raise SimulationError(
                f"Expected finite weights, got {result[lane]} in lane {low + lane} ({values}). Take a proposal whose "
                "density is nowhere zero among its values."
            )
        return result

    def resolved(self, model: Model, where: str = "lanes") -> Sample:
        """Return the sample with names of the model, and numbers in place of texts."""
        names = dict(zip(self.names, names_in(model, self.names, where), strict=True))
        marginals, proposals = (
            tuple((names[name], x.resolved(model, names[name], where)) for name, x in part)
            for part in (self.marginals, self.proposals)
        )
        result = replace(self, marginals=marginals, proposals=proposals)
        result.check_proposals()
        return result

    def check_proposals(self) -> None:
        """Refuse proposals that miss values of their targets; texts wait for a model."""
        targets = dict(self.marginals)
        for name, proposal in self.proposals:
            pair = (targets[name], proposal)
            if not any(isinstance(x, Uniform) and isinstance(x.low, str) for x in pair):
                check_proposal(*pair, name)

    def _values(self, draws: Draws, j: int, name: str, distribution: Marginal, low: int, high: int) -> Array:
        """Return the values of one name."""
        result = np.empty(high - low)
        for start, probabilities in _blocks(draws, j, low, high):
            values = distribution.quantile(probabilities)
            stop = start + values.size
            cut = slice(max(low - start, 0), max(min(high, stop) - start, 0))
            values = values[cut]
            if not np.isfinite(values).all():
                lane = int(np.flatnonzero(~np.isfinite(values))[0])
                raise SimulationError(
                    f"Expected finite values of '{name}', but {distribution} has {values[lane]} at the probability "
                    f"{probabilities[cut][lane]:.17g} of lane {max(low, start) + lane}. Cut the distribution."
                )
            result[max(low, start) - low : min(high, stop) - low] = values
        return result

    def __repr__(self) -> str:
        proposals = dict(self.proposals)
        texts = [
            f"{name} ~ {x}" + (f" drawn from {proposals[name]}" if name in proposals else "")
            for name, x in self.marginals
        ]
        return f"sample of {', '.join(texts)} by {self.by}, seed {self.seed}: {self._counted()}"


def _blocks(draws: Draws, j: int, low: int, high: int) -> Iterator[tuple[int, Array]]:
    """Yield the probabilities of whole blocks of lanes that cover a range, with their first lane."""
    for chunk in range(low // _BLOCK * _BLOCK, high, _CHUNK):
        last = min(chunk + _CHUNK, -(-high // _BLOCK) * _BLOCK, draws.count)
        probabilities = draws.probabilities(j, chunk, last)
        for start in range(chunk, last, _BLOCK):
            yield start, probabilities[start - chunk : start - chunk + _BLOCK]


@arguments_named
def sample(
    distributions: Mapping[Any, Any],
    n: int,
    *,
    by: str = "sobol",
    seed: int = 1,
    proposal: Mapping[Any, Any] | None = None,
) -> Sample:
    """Lanes of a study that draw their values from distributions, independent of one another.

    Lane k has the values x_j = F_j⁻¹(p_jk), F_j⁻¹ the quantile function of name j, 0 < p_jk < 1:

        "sobol"    point k of the Sobol sequence, scrambled by the seed. Means converge with about 1/n; best for n a
                   power of 2
        "lhs"      a Latin hypercube: for each name, one lane lies in each of n parts of equal probability
        "random"   independent random numbers

    The draws are computed by the number of the lane (Philox, Feistel permutations, Gray code), so that a lane has its
    values wherever it runs. Draws have 52 bits (of a hypercube, stratum and place in it together) and are shifted by
    half a unit of the last: none is 0 or 1, where quantiles may be infinite. The quantiles have the same bits wherever
    SciPy and NumPy compute the same bits.

    With ``proposal``, names draw from other distributions g_j, and lane k has the weight
    w_k = Π_j f_j(x_jk) / g_j(x_jk), f_j the density of the distribution: the mean of w y is the mean of y that the
    distributions would have given, with many lanes where a rare event happens (importance sampling).

    Parameters
    ----------
    distributions : mapping of name to distribution
        Distributions of parameters, and of initial values of coordinates and speeds: a distribution of ``scipy.stats``
        with its parameters, another object with ``ppf(p)`` or ``icdf(p)``, or a pair (low, high), numbers or texts with
        a unit, for a uniform distribution.
    n : int
        Number of lanes.
    by : {"sobol", "lhs", "random"}, optional
        How the lanes are drawn.
    seed : int, optional
        Seed of the draws, at least 0. The same seed gives the same lanes.
    proposal : mapping of name to distribution, optional
        Distributions to draw from in place of those of the same names.

    Returns
    -------
    Sample
        ``count`` is its number of lanes, ``columns(low, high)`` are the values of the lanes low to high - 1 by name,
        and ``weights(low, high)`` their weights, or None without ``proposal``.

    Raises
    ------
    SimulationError
        If a distribution has no quantiles, a proposal does not reach all values of its distribution, or there are more
        lanes than different draws.

    Examples
    --------
    >>> import freebody as fb
    >>> import scipy.stats
    >>> lanes = fb.sample({"I": scipy.stats.norm(0.5, 0.05), "theta": (0, 3)}, n=10**9, seed=7)
    >>> lanes
    sample of I ~ norm(0.5, 0.05), theta ~ uniform(0, 3) by sobol, seed 7: 1000000000 lanes
    >>> block = lanes.columns(500_000_000, 500_065_536)
    >>> block["I"].mean().round(4), block["theta"].mean().round(4)
    (np.float64(0.5), np.float64(1.5))
    """
    entries = {name: marginal(x, name) for name, x in by_name(distributions, {}, "fb.sample").items()}
    if by not in KINDS:
        raise SimulationError(f"Unknown way to draw {by!r}; {nearest(str(by), KINDS)}")
    seed = _whole(seed, "seed", 0, "A study is a value: the same seed gives the same lanes.")
    n = _whole(n, "number of lanes n", 1, "")
    if n > KINDS[by].most:
        others = [kind for kind in KINDS if KINDS[kind].most > n]
        cure = f"Take by={others[-1]!r}, or fewer lanes." if others else "Take fewer lanes."
        raise SimulationError(
            f"Expected at most 2^{KINDS[by].most.bit_length() - 1} lanes for by={by!r}, got {n}. {cure}"
        )
    proposals = {} if proposal is None else by_name(proposal, {}, "proposal=")
    for name in proposals:
        if name not in entries:
            raise SimulationError(f"Unknown name '{name}' in proposal=; {nearest(name, entries)}")
    drawn = tuple((name, marginal(x, name)) for name, x in proposals.items())
    result = Sample(tuple(entries.items()), n, by, seed, drawn)
    result.check_proposals()
    KINDS[by](len(entries), n, seed)  # refuses too many names
    return result


def _whole(value: Any, what: str, least: int, why: str) -> int:
    """Return a whole number, written as an int or as 1e6."""
    number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not number or value != value or abs(value) == np.inf or value != int(value) or value < least:
        raise SimulationError(
            f"Expected a whole number of at least {least} for the {what}, got {value!r}. {why}".rstrip()
        )
    return int(value)
