"""Combinations of the free-body equations that are free of reactions.

    Σ c_i (m a - Σ F)_i = 0   with   Σ c_i ∂(Σ F)_i/∂r = 0   for every reaction component r

If all reactions of a tree are eliminated, the combination is a motion that the joints allow: for each speed, c are the
velocities of the mass centres (factors of the force equations) and the angular velocities (factors of the moment
equations) per unit of that speed, and the result is the equation of motion of that speed (principle of virtual power).
For chosen reactions, and for the multipliers of constraints, the combination is found by elimination, without division.

Source: chapter 6, sections 6.3 and 6.7; the powers of ideal joints vanish.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy

from ...dynamics.kinematics import jacobian
from ...errors import ModelError, nearest
from ...scalar.algebra import Scalar
from ...scalar.polynomial import Ring
from ...scalar.ratio import Ratio, cleared, common_factor, divided, over_sine
from ...scalar.substitute import Substitution
from ..derivation.bodies import NamedBody, PointOf
from ..derivation.derivation import Derivation
from ..free_body.action import TITLES
from ..free_body.free_body import FreeBody
from ..printing.display import equation_latex, equation_text, latex, text
from ..printing.show import latex_words
from ..printing.systems import Row, Terms, best_pivot, collect
from ..printing.typeset import Typeset
from .solve import free_bodies
from .vocabulary import Vocabulary

Label = tuple[str, str]


@dataclass(frozen=True)
class Combination:
    """One equation without the reactions: its coefficients by (body, row), and its (left, right), all canonical."""

    name: str
    coefficients: dict[Label, Scalar]
    balance: tuple[Scalar, Scalar]


class Elimination(Typeset):
    """Reactions eliminated from the free-body equations. Made by :meth:`Equations.eliminate`.

    Attributes
    ----------
    reactions : tuple of str
        Components that are eliminated.
    steps : tuple of Combination
        Canonical coefficients and equations.
    """

    def __init__(self, e: Derivation, reactions: Sequence[str], steps: Sequence[Combination]) -> None:
        self._e = e
        self.reactions = tuple(reactions)
        self.steps = tuple(steps)

    @property
    def combination(self) -> tuple[dict[Label, Any], ...]:
        """SymPy coefficients of the free-body equations by (body, row), such as ("bar", "force x"), for each result."""
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
        """The combinations and the resulting equations, as plain text."""
        ring = self._e.ring
        lines = [f"Without {', '.join(self.reactions)}:"]
        for step in self.steps:
            lines.append(f"{step.name}")
            for (body, title), c in step.coefficients.items():
                lines.append(f"    ({text(c, ring)}) * [{body}: {title}]")
            lines.append(f"  gives  {equation_text(*step.balance, ring)}")
        return "\n".join(lines)

    def latex(self) -> str:
        """The combinations and the resulting equations, as a LaTeX ``aligned`` block."""
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

    def __repr__(self) -> str:
        return self.text()


@dataclass
class _Line:
    """A row that is linear in reactions, and its coefficients of the free-body equations."""

    row: Row
    coefficients: dict[Label, Ratio] = field(default_factory=dict)
    name: str = ""


def eliminate(e: Derivation, reactions: Any = None, bodies: Any = None) -> Elimination:
    """Eliminate reactions from the free-body equations; see :meth:`Equations.eliminate`."""
    vocabulary = Vocabulary(e)
    names = _component_names(vocabulary, reactions)
    whole = bodies is None and set(names) == set(vocabulary.reactions)
    free = free_bodies(e, bodies)
    balances = {
        (body.body, title): balance
        for body in free
        for title, balance in zip(TITLES, body.balances, strict=True)
        if balance != (0, 0)
    }
    lines = _powers(e, vocabulary, balances) if whole else []
    if whole:
        if e.condition_names:
            lines = _without_reactions(lines, e.condition_names)
    else:
        _check_each_once(free)
        for label, (left, _) in balances.items():
            row = Row(f"{label[0]}: {label[1]}", _in_reactions(e, vocabulary, left))
            lines.append(_Line(row, {label: Ratio(e.ring, 1)}))
        lines = _without_reactions(lines, names)
    steps = []
    for line in lines:
        step = _step(e, line, balances, whole)
        if step is not None:
            steps.append(step)
    steps = [step for step in steps if not _is_trivial(e, step, vocabulary)] or steps
    if not steps:
        raise ModelError(
            f"No combination of the {len(balances)} free-body equations given is free of {', '.join(names)}. "
            f"Eliminate fewer reactions, or take more bodies."
        )
    return Elimination(e, names, steps)


def _component_names(vocabulary: Vocabulary, reactions: Any) -> list[str]:
    """Names of the reaction components for names of components, joints and constraints; all by default."""
    if reactions is None:
        return list(vocabulary.reactions)
    requests = list(reactions) if isinstance(reactions, list | tuple | set) else [reactions]
    result: list[str] = []
    for reaction in requests:
        name = reaction if isinstance(reaction, str) else str(getattr(reaction, "name", reaction))
        components = [c for c, owner in vocabulary.owner.items() if name in (c, owner)]
        if not components:
            known_names = [*vocabulary.reactions, *dict.fromkeys(vocabulary.owner.values())]
            raise ModelError(f"Unknown reaction '{name}'; {nearest(name, known_names)}")
        result += [c for c in components if c not in result]
    if not result:
        raise ModelError("Expected at least one reaction to eliminate, such as 'pin_x' or the joint 'pin'.")
    return result


def _check_each_once(free: Sequence[FreeBody]) -> None:
    names: set[str] = set()
    for body in free:
        if body.body in names:
            raise ModelError(
                f"Body '{body.body}' is given twice. Its six equations can be taken about one point only."
            )
        names.add(body.body)


def _powers(
    e: Derivation, vocabulary: Vocabulary, balances: dict[Label, tuple[Scalar, Scalar]]
) -> list[_Line]:
    """Velocities of all bodies per unit of each speed: combinations in which ideal joints have no power."""
    lines = []
    jacobians = {}
    for name, place in e.model.bodies.items():
        # rows of the angular velocity, then of the velocity of the mass centre
        jacobians[name] = jacobian(e.model, e.state, PointOf(NamedBody(name), place.center))
    for j, speed in enumerate(e.model.speeds):
        line = _Line(Row(speed.name, {}), name=_of_speed(speed.name))
        for name, J in jacobians.items():
            for k, title in enumerate(TITLES):
                c = J[k + 3 if k < 3 else k - 3][j]
                if c != 0 and (name, title) in balances:
                    line.coefficients[name, title] = Ratio(e.ring, c)
        if e.condition_names:
            # not G itself: in the free-body equations the forces of a loop act at one point, in G at two points whose
            # positions are different polynomials
            total: Scalar = 0
            for label, c in line.coefficients.items():
                total = total + c.num * balances[label][0]
            line.row.terms = _in_reactions(e, vocabulary, total)
        lines.append(line)
    return lines


def _of_speed(name: str) -> str:
    return f"by {name}"


def _in_reactions(e: Derivation, vocabulary: Vocabulary, left: Scalar) -> Terms:
    """Terms of a left side that contain reactions."""
    places = {}
    for name, symbol in vocabulary.reactions.items():
        g = e.ring.find(symbol)
        if g is not None:
            places[g.index] = (name, 1)
    return {monomial: c for monomial, c in collect(left, places, e.ring).items() if monomial}


def _without_reactions(lines: list[_Line], names: Iterable[str]) -> list[_Line]:
    """Return the lines without these reactions, by Gauss's elimination without back substitution."""
    remaining_lines = list(lines)
    remaining_names = list(names)
    while (pivot := best_pivot([line.row for line in remaining_lines], remaining_names)) is not None:
        row, name = pivot
        (pivot_line,) = [line for line in remaining_lines if line.row is row]
        remaining_lines.remove(pivot_line)
        key = ((name, 1),)
        for line in remaining_lines:
            if key not in line.row.terms:
                continue
            factor = line.row.terms[key] / row.terms[key]
            line.row.terms = _minus_multiple(line.row.terms, row.terms, factor)
            line.coefficients = _minus_multiple(line.coefficients, pivot_line.coefficients, factor)
            line.name = ""
        remaining_names.remove(name)
    return remaining_lines


def _minus_multiple(a: dict[Any, Ratio], b: dict[Any, Ratio], factor: Ratio) -> dict[Any, Ratio]:
    """a - factor b, without zeros."""
    result = dict(a)
    for key, c in b.items():
        total = result[key] - factor * c if key in result else -(factor * c)
        if total:
            result[key] = total
        else:
            result.pop(key, None)
    return result


def _step(
    e: Derivation, line: _Line, balances: dict[Label, tuple[Scalar, Scalar]], whole: bool
) -> Combination | None:
    """Return the combination without denominators and common factors, and its equation; None for 0 = 0."""
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
    forces: Scalar = 0
    masses: Scalar = 0
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


def _without_sines(ring: Ring, numbers: list[Scalar]) -> list[Scalar]:
    """Return the coefficients divided by the sines that divide all of them."""
    for g in list(ring.generators):
        while g.kind == "sin" and g.partner >= 0:
            shorter = [over_sine(ring, c, g.index) for c in numbers]
            if any(c is None for c in shorter):
                break
            numbers = shorter
    return numbers


def _is_trivial(e: Derivation, step: Combination, vocabulary: Vocabulary) -> bool:
    """True if an equation only states that other reactions vanish, or balance each other."""
    without_reactions = Substitution(e.ring, e.ring, dict.fromkeys(vocabulary.reactions.values(), 0))
    return all(without_reactions(side) == 0 for side in step.balance)
