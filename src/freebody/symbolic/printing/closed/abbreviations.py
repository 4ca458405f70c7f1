"""Names for groups of parameters, such as I_xi = m (R²/4 + L²), where an equation or an answer becomes shorter.

A group p = A a^n + B, with A a single term, is a relation that eliminates a power of one parameter: a^n = (name - B)/A.
All choices of the parameters are compared, and the equations with the fewest operations are printed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import sympy

from ....describe.names import check_name
from ....errors import ModelError
from ....scalar.algebra import Expression, Scalar, divide
from ....scalar.element import Polynomial
from ....scalar.polynomial import Ring
from ....scalar.roots import is_positive
from ....scalar.substitute import Substitution
from ..arrange import arrange
from .form import closed_form
from .operations import length

MOST = 4
"""Most names in one print: each may eliminate any of its parameters, and all choices are compared."""

Sides = Sequence[tuple[Scalar, Scalar]]


class Elimination(Substitution):
    """Substitution of a power of one parameter, also where it divides."""

    def __init__(self, ring: Ring, index: int, power: int, value: Scalar) -> None:
        super().__init__(ring, ring, {})
        self.index, self.power, self.value = index, power, value
        self.inverse = divide(1, ring.variable(index))

    def _power(self, index: int, e: int) -> Any:
        if index != self.index and self.ring.variable(index) != self.inverse:
            return super()._power(index, e)
        whole, rest = divmod(e, self.power)
        value = self.value if index == self.index else divide(1, self.value)
        return value**whole * self.ring.variable(index) ** rest

    def _touches(self, g: Any) -> bool:
        return bool(g.depends >> self.index & 1)


def groups(e: Any, names: Mapping[str, Expression]) -> dict[str, Polynomial]:
    """Return the groups of parameters by name, as elements of the ring of a machine's equations.

    Raises
    ------
    ModelError
        Too many names, a name that the machine has, or a group that is not a polynomial of parameters.
    """
    if len(names) > MOST:
        raise ModelError(
            f"Expected at most {MOST} names for groups of parameters, got {len(names)}: {', '.join(names)}."
        )
    result = {}
    for name, value in names.items():
        check_name(name, "a name for a group of parameters")
        if name in e.model.names.kinds:
            raise ModelError(
                f"Expected a new name for a group of parameters, got '{name}', which is a "
                f"{e.model.names.kinds[name]} of the model; choose another."
            )
        x = e.ring.from_sympy(e.model.names.expression(value, f"the group '{name}'"))
        if type(x) is not Polynomial or not list(_powers(x)):
            raise ModelError(
                f"Expected a sum or product of parameters with a power of a parameter in one term for '{name}', got "
                f"{value}; name a group such as 'm*(R**2/4 + L**2)'."
            )
        result[name] = x
    return result


def _powers(x: Polynomial) -> Iterator[tuple[int, int, tuple[Any, int]]]:
    """Yield (generator, power, term) of each parameter that occurs in one term of an element and in nothing else."""
    terms = x.terms()
    for g in x.ring.used(x):
        holding = [(monomial, c) for monomial, c in terms if g.index in dict(monomial)]
        derived = any(h.arguments and h.depends >> g.index & 1 for h in x.ring.used(x) if h.index != g.index)
        if g.kind == "parameter" and len(holding) == 1 and not derived:
            yield g.index, dict(holding[0][0])[g.index], holding[0]


def _eliminations(x: Polynomial, named: Polynomial) -> Iterator[Elimination]:
    """Yield the ways to bring a named group into formulas."""
    ring = x.ring
    for index, power, (monomial, c) in _powers(x):
        factor: Scalar = divide(c, x.den)
        for i, e in monomial:
            factor = factor * ring.variable(i) ** (e if i != index else 0)
        rest = x - factor * ring.variable(index) ** power
        yield Elimination(ring, index, power, divide(named - rest, factor))


def _ways(sides: Sides, meanings: Sequence[tuple[Polynomial, Polynomial]]) -> Iterator[Sides]:
    """Yield the equations with all groups named, in each of the ways."""
    if not meanings:
        yield sides
        return
    (group, named), *others = meanings
    for eliminate in _eliminations(group, named) if type(group) is Polynomial else ():
        after = [(eliminate(left), eliminate(right)) for left, right in sides]
        yield from _ways(after, [(eliminate(x), name) for x, name in others])


def _symbol(name: str, x: Polynomial, rank: int) -> Polynomial:
    """Return the name of a group as an element; it stands before all parameters."""
    positive = is_positive(x.ring, x.ring.promoted(x.num))
    symbol = x.ring.generator(sympy.Symbol(name, **{"positive" if positive else "real": True}), "parameter")
    (generator,) = x.ring.used(symbol)
    generator.rank = rank
    return symbol


def abbreviated(
    sides: Sides, names: Mapping[str, Polynomial], ring: Ring, closed: bool = False
) -> tuple[Sides, dict[str, Polynomial]]:
    """Return equations with groups of parameters named, and the names that are used.

    An equation that would become longer keeps its parameters. ``closed``: as long as in its closed form.
    """
    if not names:
        return sides, {}
    symbols = {name: _symbol(name, x, k - len(names)) for k, (name, x) in enumerate(names.items())}

    def operations(pair: tuple[Scalar, Scalar]) -> int:
        forms = ((closed and closed_form(x, ring)) or (arrange(x, ring), ring) for x in pair if x != 0)
        return sum(length(*form).total for form in forms)

    before = [operations(pair) for pair in sides]
    best, fewest = sides, sum(before)
    for way in _ways(sides, [(x, symbols[name]) for name, x in names.items()]):
        lengths = [operations(pair) for pair in way]
        if sum(map(min, lengths, before)) <= fewest:
            fewest = sum(map(min, lengths, before))
            best = [
                new if after <= old else pair
                for pair, new, after, old in zip(sides, way, lengths, before, strict=True)
            ]
    atoms = {a for pair in best for x in pair if type(x) is Polynomial for a in x.atoms()}
    return best, {name: x for name, x in names.items() if ring.to_sympy(symbols[name]) in atoms}
