"""Explicit Runge-Kutta methods as data: the tableau of a user's own method.

    k_i = f(t + c_i h, y + h Σ_j a_ij k_j),   c_i = Σ_j a_ij,        y(t + h) = y + h Σ_i b_i k_i

The order is p if Φ(τ) = 1/γ(τ) for every rooted tree τ of up to p nodes, where Φ(τ) = Σ_i b_i Π Φ_i(child) over the
subtrees of the root, and γ(τ) is the product of the numbers of nodes of all its subtrees.

Source: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), sections II.1 and II.2.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations_with_replacement
from math import isfinite
from typing import Any, TypeAlias

from ...errors import SimulationError, shown
from . import layout

MOST_STAGES = 11
"""Most stages of a method; the memory of a step has twelve rows for rates before the end of the step."""
MOST = 8
"""Greatest order that is checked."""
CLOSE = 1e-12
"""Greatest difference from an order condition: coefficients are printed with fifteen digits or more."""

Tree: TypeAlias = "tuple[Tree, ...]"
"""A rooted tree: its subtrees."""

OWN: dict[str, RungeKutta] = {}
"""Methods that users added, by name."""


@dataclass(frozen=True)
class RungeKutta:
    """An explicit Runge-Kutta method of your own, by its coefficients.

    ``fb.simulate(s, 10, method="NAME")`` runs it: step-size control by the embedded method, events, states between
    steps, projection onto constraints, batches. :func:`freebody.testing.check_method` checks it.

    Parameters
    ----------
    name : str
    order : int
        Order p of the result.
    stages : sequence of sequences
        Rows a_i of the tableau, from the second stage on: the first has one number, the next two, and so on.
    weights : sequence
        b_i, one for each stage.
    embedded : sequence
        Weights of the embedded method, whose difference is the error; one for each stage, and one more if it uses the
        rates at the end of the step.

    Raises
    ------
    SimulationError
        Rows of other lengths, weights that do not have the order, a name in use.

    Examples
    --------
    The method of Bogacki and Shampine, of order 3(2):

    >>> import freebody as fb
    >>> method = fb.RungeKutta(
    ...     "bogacki", order=3, stages=[[1 / 2], [0, 3 / 4]], weights=[2 / 9, 1 / 3, 4 / 9],
    ...     embedded=[7 / 24, 1 / 4, 1 / 3, 1 / 8],
    ... )
    >>> s = fb.System("falling ball")
    >>> s.gravity = (0, -9.81, 0)
    >>> guide = s.slider("guide", s.ground, s.body("ball", fb.particle(1)), axis="y", coordinate="y")
    >>> print(f"{fb.simulate(s, 2, method='bogacki')['y'][-1]:.6f}")
    -19.620000
    """

    name: str
    order: int
    stages: Sequence[Sequence[float]]
    weights: Sequence[float]
    embedded: Sequence[float]

    def __post_init__(self) -> None:
        what = f"the method {shown(self.name)}"
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise SimulationError(f"Expected a name such as 'heun' for a method, got {shown(self.name)}.")
        rows = [
            _numbers(row, f"row {i} of the stages of {what}")
            for i, row in enumerate(_rows(self.stages, what), 1)
        ]
        for i, row in enumerate(rows, start=1):
            if len(row) != i:
                raise SimulationError(
                    f"Expected {i} number{'s' * (i > 1)} in row {i} of the stages of {what}, which is explicit, got "
                    f"{len(row)}: {shown(row)}. A stage uses the rates of the earlier ones only."
                )
        count = len(rows) + 1
        weights = _numbers(self.weights, f"the weights of {what}")
        embedded = _numbers(self.embedded, f"the embedded weights of {what}")
        for numbers, allowed, which in (
            (weights, (count,), "weights"),
            (embedded, (count, count + 1), "embedded"),
        ):
            if len(numbers) not in allowed:
                raise SimulationError(
                    f"Expected {' or '.join(map(str, allowed))} {which}, one for each of the {count} stages of {what}, "
                    f"got {len(numbers)}."
                )
        if count > MOST_STAGES:
            raise SimulationError(f"Expected at most {MOST_STAGES} stages for {what}, got {count}.")
        if isinstance(self.order, bool) or not isinstance(self.order, int) or not 1 <= self.order <= MOST:
            raise SimulationError(f"Expected an order from 1 to {MOST} for {what}, got {shown(self.order)}.")
        for key, value in (("stages", tuple(rows)), ("weights", weights), ("embedded", embedded)):
            object.__setattr__(self, key, value)
        self._check_order(what)
        self._register()

    def __reduce__(self) -> Any:
        """Pickle the coefficients. Another process checks them again, and knows the name."""
        return RungeKutta, (self.name, self.order, self.stages, self.weights, self.embedded)

    def _check_order(self, what: str) -> None:
        """Refuse weights without the order, and an embedded method that is the method itself."""
        for n in range(1, self.order + 1):
            for tree in trees(n):
                found, exact = self.elementary_weight(tree), 1 / density(tree)
                if abs(found - exact) > CLOSE:
                    raise SimulationError(
                        f"Expected weights of order {self.order} for {what}, but they have order {n - 1}: for the tree "
                        f"{shown(tree)} Σ b_i Φ_i is {found:.12g}, and should be {exact:.12g}. Correct a coefficient, "
                        f"or pass order={n - 1}."
                    )
        if abs(sum(self.embedded) - 1) > CLOSE:
            raise SimulationError(
                f"Expected embedded weights of {what} that add up to 1, got {sum(self.embedded):.12g}."
            )
        if max(map(abs, self.errors)) < CLOSE:
            raise SimulationError(
                f"The embedded weights of {what} are its weights, so that no step has an error. Give those of a method "
                f"of order {self.order - 1}."
            )

    def _register(self) -> None:
        """Make the name known to `simulate`, studies and batches."""
        if self.name not in OWN and self.name in (*layout.ORDERS, "auto", "timestepping"):
            raise SimulationError(f"There is already a method '{self.name}'. Choose another name.")
        OWN[self.name] = self
        layout.EXPLICIT[self.name] = layout.ORDERS[self.name] = self.order

    @property
    def nodes(self) -> tuple[float, ...]:
        """The times c_i of the stages, as fractions of the step."""
        return (0.0, *(float(sum(row)) for row in self.stages))

    @property
    def errors(self) -> tuple[float, ...]:
        """Weights of the error: those of the method less those of the embedded one."""
        count = len(self.embedded)
        weights = (*self.weights, *[0.0] * (count - len(self.weights)))
        return tuple(b - e for b, e in zip(weights, self.embedded, strict=True))

    @property
    def identity(self) -> str:
        """Hash of the coefficients."""
        content = repr((self.name, self.order, self.stages, self.weights, self.embedded))
        return hashlib.sha256(content.encode()).hexdigest()

    @property
    def stable(self) -> float:
        """End of the region of stability on the negative axis, |1 + Σ z^(n+1) b·A^n 1| = 1; 0 beyond 100."""
        step, z = 1 / 64, 0.0
        while z < 100:
            z += step
            if abs(self.growth(-z)) > 1:
                return z - step
        return 0.0

    def growth(self, z: float) -> float:
        """Return y(t + h)/y(t) for y' = λ y with z = λ h."""
        rates: list[float] = []
        for row in ((), *self.stages):
            rates.append(z * (1 + sum(a * k for a, k in zip(row, rates, strict=True))))
        return 1 + sum(b * k for b, k in zip(self.weights, rates, strict=True))

    def elementary_weight(self, tree: Tree) -> float:
        """Return Σ_i b_i Φ_i of a rooted tree."""
        return sum(b * x for b, x in zip(self.weights, self._stage_weights(tree), strict=True))

    def _stage_weights(self, tree: Tree) -> list[float]:
        result = [1.0] * len(self.weights)
        for child in tree:
            inner = self._stage_weights(child)
            for i, row in enumerate(((), *self.stages)):
                result[i] *= sum(a * x for a, x in zip(row, inner, strict=False))
        return result


def _rows(stages: Any, what: str) -> list[Any]:
    if isinstance(stages, str) or not hasattr(stages, "__iter__"):
        raise SimulationError(f"Expected rows of numbers for the stages of {what}, got {shown(stages)}.")
    return list(stages)


def _numbers(row: Any, what: str) -> tuple[float, ...]:
    """Return the coefficients of a row as floats."""
    try:
        numbers = tuple(float(x) for x in row)
    except (TypeError, ValueError):
        raise SimulationError(f"Expected numbers for {what}, got {shown(row)}.") from None
    if not all(map(isfinite, numbers)):
        raise SimulationError(f"Expected finite numbers for {what}, got {shown(row)}.")
    return numbers


@cache
def trees(n: int) -> tuple[Tree, ...]:
    """Return the rooted trees of n nodes.

    >>> [len(trees(n)) for n in range(1, 7)]
    [1, 1, 2, 4, 9, 20]
    """
    return tuple(_forests(n - 1, n - 1))


def _forests(nodes: int, largest: int) -> Iterator[Tree]:
    """Yield the sets of trees of so many nodes together, none with more than ``largest``."""
    if nodes == 0:
        yield ()
        return
    for size in range(min(largest, nodes), 0, -1):
        for count in range(1, nodes // size + 1):
            for chosen in combinations_with_replacement(trees(size), count):
                for rest in _forests(nodes - size * count, size - 1):
                    yield (*chosen, *rest)


def size_of(tree: Tree) -> int:
    """Return the number of nodes of a rooted tree."""
    return 1 + sum(map(size_of, tree))


def density(tree: Tree) -> int:
    """Return γ, the product of the numbers of nodes of all subtrees.

    >>> density((((),),)), density(((), ()))
    (6, 3)
    """
    result = size_of(tree)
    for child in tree:
        result *= density(child)
    return result
