"""Which combination of the free-body equations is free of reactions.

    Σ c_i (m a - Σ F)_i = 0   with   Σ c_i ∂(Σ F)_i/∂r = 0   for every reaction component r

For all reactions of a tree the combination is the motion that the joints allow: c is what a unit of one speed gives to
the velocities of the mass centres (times the force equations) and to the angular velocities (times the moment
equations), and the result is the equation of motion of that speed (principle of virtual power). For chosen
reactions, and for the multipliers of constraints, the combination is found by elimination, without division.

Source: chapter 6, sections 6.3 and 6.7; the powers of ideal joints vanish.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy

from ...dynamics.kinematics import jacobian
from ...errors import ModelError, nearest
from ...scalar.ratio import Ratio, cleared, common_factor, divided, over_sine
from ...scalar.substitute import Substitution
from ..derivation.derivation import Derivation
from ..free_body.action import TITLES
from ..free_body.free_body import FreeBody
from ..printing.display import equation_latex, equation_text, latex, text
from ..printing.show import EQUALS, elements, inner, latex_words, words
from ..printing.systems import Row, best_pivot, collect
from .solve import chosen
from .vocabulary import Vocabulary

Label = tuple[str, str]


@dataclass(frozen=True)
class Combination:
    """One equation free of the reactions: coefficients by (body, row), and (left, right), all canonical."""

    name: str
    coefficients: dict[Label, Any]
    balance: tuple[Any, Any]


class Elimination:
    """Reactions eliminated from the free-body equations. Made by :meth:`Equations.eliminate`.

    Attributes
    ----------
    reactions : tuple of str
        The components that are eliminated.
    steps : tuple of Combination
        Canonical coefficients and equations.
    """

    def __init__(self, e: Derivation, reactions: Sequence[str], steps: Sequence[Combination]) -> None:
        self._e = e
        self.reactions = tuple(reactions)
        self.steps = tuple(steps)

    @property
    def combination(self) -> tuple[dict[Label, Any], ...]:
        """Per result, the SymPy coefficient of each free-body equation by (body, row), such as ("bar", "force x")."""
        show = self._e.displayed
        return tuple({label: show(c) for label, c in step.coefficients.items()} for step in self.steps)

    @property
    def equations(self) -> tuple[Any, ...]:
        """The results as SymPy ``Eq``."""
        show = self._e.displayed
        return tuple(
            sympy.Eq(show(left), show(right), evaluate=False)
            for left, right in (s.balance for s in self.steps)
        )

    def text(self) -> str:
        """The combinations and what they give, as plain text."""
        ring = self._e.ring
        lines = [f"Without {', '.join(self.reactions)}:"]
        for step in self.steps:
            lines.append(f"{step.name}")
            for (body, title), c in step.coefficients.items():
                lines.append(f"    ({text(c, ring)}) * [{body}: {title}]")
            lines.append(f"  gives  {equation_text(*step.balance, ring)}")
        return "\n".join(lines)

    def latex(self) -> str:
        """The combinations and what they give as a LaTeX ``aligned`` block."""
        ring = self._e.ring
        rows = []
        for step in self.steps:
            parts = [
                f"\\left({latex(c, ring)}\\right) [{latex_words(f'{body}: {title}')}]"
                for (body, title), c in step.coefficients.items()
            ]
            rows.append(" + ".join(parts).replace("[", "&\\,[", 1))
            rows.append("\\Rightarrow\\quad &" + equation_latex(*step.balance, ring))
        return "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"

    def mathml(self) -> str:
        """The combinations and what they give as presentation MathML, two elements each."""
        ring = self._e.ring
        lines = []
        for step in self.steps:
            parts = [
                f"<mrow><mo>(</mo>{inner(c, ring)}<mo>)</mo></mrow>{words(f' [{body}: {title}]')}"
                for (body, title), c in step.coefficients.items()
            ]
            left, right = step.balance
            lines.append("<mo>+</mo>".join(parts))
            lines.append("<mo>⇒</mo>" + inner(left, ring) + EQUALS + inner(right, ring))
        return elements(lines)

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        return self.text()


@dataclass
class _Line:
    """A row of reactions (left sides, linear), and what it is made of."""

    row: Row
    coefficients: dict[Label, Ratio] = field(default_factory=dict)
    name: str = ""


def eliminate(e: Derivation, reactions: Any = None, bodies: Any = None) -> Elimination:
    """See :meth:`Equations.eliminate`."""
    vocabulary = Vocabulary(e)
    names = _names(e, vocabulary, reactions)
    whole = bodies is None and set(names) == set(vocabulary.reactions)
    free = chosen(e, bodies)
    balances = {
        (body.body, title): balance
        for body in free
        for title, balance in zip(TITLES, body.balances, strict=True)
        if balance != (0, 0)
    }
    lines = _powers(e, vocabulary, balances) if whole else []
    if whole:
        names_left = list(e.condition_names)
        if names_left:
            lines = _eliminated(e, lines, names_left)
    else:
        _check_one_each(free)
        for label, (left, _) in balances.items():
            row = Row(f"{label[0]}: {label[1]}", _in_reactions(e, vocabulary, left))
            lines.append(_Line(row, {label: Ratio(e.ring, 1)}))
        lines = _eliminated(e, lines, names)
    steps = []
    for line in lines:
        step = _step(e, line, balances, whole)
        if step is not None:
            steps.append(step)
    steps = [step for step in steps if not _idle(e, step, vocabulary)] or steps
    if not steps:
        raise ModelError(
            f"No combination of the {len(balances)} free-body equations given is free of {', '.join(names)}. "
            f"Eliminate fewer reactions, or take more bodies."
        )
    return Elimination(e, names, steps)


def _names(e: Derivation, vocabulary: Vocabulary, reactions: Any) -> list[str]:
    """Component names from those of components, joints and constraints."""
    if reactions is None:
        return list(vocabulary.reactions)
    given = list(reactions) if isinstance(reactions, list | tuple | set) else [reactions]
    result: list[str] = []
    for one in given:
        name = one if isinstance(one, str) else str(getattr(one, "name", one))
        found = [c for c, owner in vocabulary.owner.items() if name in (c, owner)]
        if not found:
            known = [*vocabulary.reactions, *dict.fromkeys(vocabulary.owner.values())]
            raise ModelError(f"Unknown reaction '{name}'; {nearest(name, known)}")
        result += [c for c in found if c not in result]
    if not result:
        raise ModelError("Expected at least one reaction to eliminate, such as 'pin_x' or the joint 'pin'.")
    return result


def _check_one_each(free: Sequence[FreeBody]) -> None:
    seen: set[str] = set()
    for body in free:
        if body.body in seen:
            raise ModelError(
                f"Body '{body.body}' is given twice. Its six equations can be taken about one point only."
            )
        seen.add(body.body)


def _powers(e: Derivation, vocabulary: Vocabulary, balances: dict[Label, Any]) -> list[_Line]:
    """Per speed, the velocities of all bodies per unit of it: the combination that no ideal joint has power in."""
    lines = []
    of_body = {}
    for name in e.model.bodies:
        # rows of the angular velocity, then of the velocity of the mass centre
        of_body[name] = jacobian(e.model, e.state, _Center(e, name))
    for j, speed in enumerate(e.model.speeds):
        line = _Line(Row(speed.name, {}), name=_of_speed(speed.name))
        for name, J in of_body.items():
            for k, title in enumerate(TITLES):
                c = J[k + 3 if k < 3 else k - 3][j]
                if c != 0 and (name, title) in balances:
                    line.coefficients[name, title] = Ratio(e.ring, c)
        if e.condition_names:
            # not G itself: in the sums the forces of a loop act at one point, in G at points that only coincide
            total: Any = 0
            for label, c in line.coefficients.items():
                total = total + c.num * balances[label][0]
            line.row.terms = _in_reactions(e, vocabulary, total)
        lines.append(line)
    return lines


def _of_speed(name: str) -> str:
    return f"by {name}"


class _Center:
    """The mass centre of a body of the model, as a point."""

    def __init__(self, e: Derivation, body: str) -> None:
        self.body = _Named(body)
        self.components = e.model.bodies[body].center


@dataclass(frozen=True)
class _Named:
    name: str
    is_ground: bool = False


def _in_reactions(e: Derivation, vocabulary: Vocabulary, left: Any) -> Any:
    places = {}
    for name, symbol in vocabulary.reactions.items():
        g = e.ring.find(symbol)
        if g is not None:
            places[g.index] = (name, 1)
    return {monomial: c for monomial, c in collect(left, places, e.ring).items() if monomial}


def _eliminated(e: Derivation, lines: list[_Line], names: Iterable[str]) -> list[_Line]:
    """Gauss without back substitution; rows that hold none of the reactions are left."""
    left = list(lines)
    rest = list(names)
    while (pivot := best_pivot([line.row for line in left], rest)) is not None:
        row, name = pivot
        (used,) = [line for line in left if line.row is row]
        left.remove(used)
        key = ((name, 1),)
        for line in left:
            if key not in line.row.terms:
                continue
            factor = line.row.terms[key] / row.terms[key]
            line.row.terms = _less(line.row.terms, row.terms, factor)
            line.coefficients = _less(line.coefficients, used.coefficients, factor)
            line.name = ""
        rest.remove(name)
    return left


def _less(a: dict[Any, Ratio], b: dict[Any, Ratio], factor: Ratio) -> dict[Any, Ratio]:
    """a - factor b, without zeros."""
    result = dict(a)
    for key, c in b.items():
        total = result[key] - factor * c if key in result else -(factor * c)
        if total:
            result[key] = total
        else:
            result.pop(key, None)
    return result


def _step(e: Derivation, line: _Line, balances: dict[Label, Any], whole: bool) -> Combination | None:
    """The combination without denominators and common factors, and the equation that it gives."""
    ring = e.ring
    place = {label: i for i, label in enumerate(balances)}
    labels = sorted(line.coefficients, key=place.__getitem__)
    values = [line.coefficients[label].tidy() for label in labels]
    if whole and line.name:
        numbers = [c.whole() for c in values]
    else:
        numbers = cleared(ring, values)
        common = common_factor(ring, numbers)
        numbers = _without_sines(ring, [divided(ring, c, common) for c in numbers])
        if numbers and text(numbers[-1], ring).startswith("-"):
            numbers = [-c for c in numbers]
    coefficients = dict(zip(labels, numbers, strict=True))
    forces: Any = 0
    masses: Any = 0
    for label, c in coefficients.items():
        left, right = balances[label]
        forces, masses = forces + c * left, masses + c * right
    if forces == 0 and masses == 0:
        return None
    for j, speed in enumerate(e.model.speeds):
        a, b = e.balances[j]
        if line.name == _of_speed(speed.name) and masses - forces == a - b:
            return Combination(line.name, coefficients, (a, b))
    balance = (masses, forces) if masses != 0 else (forces, 0)
    return Combination(line.name or f"from {line.row.name}", coefficients, balance)


def _without_sines(ring: Any, numbers: list[Any]) -> list[Any]:
    """The coefficients over the sines that divide all of them."""
    for g in list(ring.generators):
        while g.kind == "sin" and g.partner >= 0:
            shorter = [over_sine(ring, c, g.index) for c in numbers]
            if any(c is None for c in shorter):
                break
            numbers = shorter
    return numbers


def _idle(e: Derivation, step: Combination, vocabulary: Vocabulary) -> bool:
    """Whether an equation only says that other reactions vanish, or balance each other."""
    absent = Substitution(e.ring, e.ring, dict.fromkeys(vocabulary.reactions.values(), 0))
    return all(absent(side) == 0 for side in step.balance)
