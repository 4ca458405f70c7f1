"""Bearing forces of a rotor on a shaft in two bearings.

Two bearings A and B together act as a hinge. The hinge's reaction on the rotor is the force F and the moment M about
its point P. The bearings, at the distances a and b from P along the shaft n, carry forces at right angles to the shaft
and no moments:

    R_A + R_B = F - n (n·F),        n × (a R_A + b R_B) = M - n (n·M)

so with Y = M × n

    R_A = (Y - b F) / (a - b),      R_B = (a F - Y) / (a - b)      across the shaft.

F and M come from the free-body equations, for any mass distribution and any motion. Source: chapter, section 6.6.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy

from ...dynamics.kinematics import rotation
from ...errors import ModelError, nearest
from ...scalar.algebra import (
    Expression,
    Scalar,
    Vector,
    apply,
    apply_transpose,
    cross,
    divide,
    dot,
    scale,
    subtract,
)
from ..equations import Equations, equations
from ..free_body.reaction import LETTERS
from ..printing.display import Formulas, equation_text
from ..solving.vocabulary import Vocabulary


@dataclass(frozen=True)
class Shaft:
    """A hinge as a shaft: the equations, the joint's name and link, and the axis in the axes of the rotor."""

    e: Equations
    joint: str
    link: int
    axis: Vector

    @property
    def rotor(self) -> str:
        """Name of the body that the hinge carries."""
        return self.e.model.joints[self.joint].child

    @cached_property
    def vocabulary(self) -> Vocabulary:
        """Reader of expressions in the model's names."""
        return Vocabulary(self.e)

    def distances(self, at: Any, what: str) -> dict[str, Scalar]:
        """Return places along the shaft by name, canonical.

        Raises
        ------
        ModelError
            No mapping, or an empty one.
        """
        if not isinstance(at, Mapping) or not at:
            raise ModelError(
                f"Expected {what} by name with their distances along the shaft from joint '{self.joint}', such as "
                f'{{"A": "L/2", "B": "-L/2"}}, got {at!r}.'
            )
        return {str(name): self.vocabulary.element(place, what) for name, place in at.items()}

    def two_forces(self, places: Mapping[str, Scalar], F: Vector, Y: Vector, what: str) -> dict[str, Vector]:
        """Return forces at two places along the shaft, with the sum F and with Σ place · force = Y."""
        if len(places) != 2:
            raise ModelError(
                f"Expected two {what} along the shaft, got {len(places)}: {', '.join(places)}. More than two are "
                "statically indeterminate, one alone does not hold a shaft."
            )
        (first, a), (second, b) = places.items()
        if a == b:
            raise ModelError(f"Expected two {what} at different places, got '{first}' and '{second}' at one.")
        span = a - b
        return {
            first: tuple(divide(y - b * f, span) for y, f in zip(Y, F, strict=True)),
            second: tuple(divide(a * f - y, span) for y, f in zip(Y, F, strict=True)),
        }


def shaft_of(s: Any, joint: Any) -> Shaft:
    """Return a hinge of a system as a shaft.

    Raises
    ------
    ModelError
        An unknown joint, or one that is not a hinge of the tree.
    """
    e = s if isinstance(s, Equations) else equations(s)
    name = str(getattr(joint, "name", joint))
    if name not in e.model.joints:
        raise ModelError(f"Unknown joint '{name}'; {nearest(str(name), list(e.model.joints))}")
    place = e.model.joints[name]
    link = e.model.links[place.links[-1]]
    if len(place.links) != 1 or not link.turns_only:
        raise ModelError(
            f"Expected a hinge, which two bearings of a shaft form together, got the {place.type} '{name}'."
        )
    return Shaft(e, name, place.links[-1], e.state.vector(link.axis))


def bearing_reactions(s: Any, joint: Any, at: Mapping[str, Expression]) -> BearingReactions:
    """Return the forces of two bearings on the shaft of a rotor, for any mass distribution and any motion.

    Parameters
    ----------
    s : System, Model or Equations
    joint : str or Joint
        The hinge that the two bearings form together.
    at : mapping
        Names of the bearings -> distance from the joint's point along the joint's axis, number or expression [m].

    Returns
    -------
    BearingReactions

    Raises
    ------
    ModelError
        A joint that is not a hinge, a number of bearings other than two, bearings at one place, unknown names.

    References
    ----------
    Chapter, section 6.6, eqs (6.62) to (6.66), here for any rotor.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("unbalanced disk")
    >>> m, R, L, e = s.parameters(m=2, R=0.1, L=0.4, e=0.001)
    >>> disk = s.body("disk", fb.disk(m, R).moved((e, 0, 0)))
    >>> axle = s.hinge("axle", s.ground, disk, coordinate="theta")
    >>> forces = fb.bearing_reactions(s, axle, at={"A": L / 2, "B": -L / 2})
    >>> forces.rotating["A"].T
    Matrix([[-e*m*Derivative(theta(t), t)**2/2, e*m*Derivative(theta(t), (t, 2))/2, 0]])
    """
    return BearingReactions(shaft_of(s, joint), at)


class BearingReactions(Formulas):
    """Forces on a shaft at two bearings. Made by :func:`bearing_reactions`.

    Attributes
    ----------
    names : tuple of str
        Names of the bearings.
    """

    def __init__(self, shaft: Shaft, at: Mapping[str, Expression]) -> None:
        self._shaft = shaft
        e = shaft.e
        self._places = shaft.distances(at, "the bearings")
        F, M = e.canonical_reactions[shaft.joint]
        R = rotation(e.model, e.state, shaft.link)
        n = apply(R, shaft.axis)
        self._axial, self._torque = dot(n, F), dot(n, M)
        across = subtract(F, scale(self._axial, n))
        self.canonical = shaft.two_forces(self._places, across, cross(M, n), "bearings")
        """Forces in ground axes by bearing, canonical."""
        self.canonical_rotating = {name: apply_transpose(R, f) for name, f in self.canonical.items()}
        """Forces in the axes of the rotor by bearing, canonical."""
        self.names = tuple(self._places)

    @cached_property
    def ground(self) -> dict[str, Any]:
        """Force on the shaft at each bearing, SymPy column in ground axes [N]."""
        return {name: self._shaft.e.column(force) for name, force in self.canonical.items()}

    @cached_property
    def rotating(self) -> dict[str, Any]:
        """Force on the shaft at each bearing, SymPy column in the axes of the rotor [N]."""
        return {name: self._shaft.e.column(force) for name, force in self.canonical_rotating.items()}

    @cached_property
    def axial(self) -> Any:
        """Force along the shaft, on the shaft, that a thrust bearing carries [N]."""
        return self._shaft.e.displayed(self._axial)

    @cached_property
    def torque(self) -> Any:
        """Torque about the axis on the shaft, if its angle is a function of time; 0 if it turns freely [N m]."""
        return self._shaft.e.displayed(self._torque)

    def under(self, angle: Expression, *, rotating: bool = False) -> dict[str, Any]:
        """Return the forces while the shaft turns by a function of time, theta(t), as SymPy columns.

        Parameters
        ----------
        angle : expression or text
            In ``t`` and parameters, such as ``"alpha0*t^2/2"``; its derivatives are the speed and acceleration.
        rotating : bool, optional
            Return components in the axes of the rotor instead of ground axes.

        Raises
        ------
        ModelError
            The hinge's angle is not a coordinate of its own, or the expression contains an unknown name.
        """
        e = self._shaft.e
        link = e.model.links[self._shaft.link]
        q = link.displacement
        if q not in e.coordinates:
            raise ModelError(
                f"Expected the angle of '{self._shaft.joint}' to be a coordinate of its own, got {q}: its motion is "
                f"given."
            )
        theta = self._shaft.vocabulary.expression(angle, "the angle of the shaft")
        t = next((x for x in theta.free_symbols if x.name == "t"), sympy.Symbol("t"))
        j = e.coordinates.index(q)
        speed = e.model.speeds[j]
        values = {speed.acceleration: sympy.diff(theta, t, 2), speed.symbol: sympy.diff(theta, t), q: theta}
        return {
            name: column.xreplace(values)
            for name, column in (self.rotating if rotating else self.ground).items()
        }

    def along(self, trajectory: Any) -> dict[str, Any]:
        """Return the forces in ground axes at the output times of a motion by bearing: arrays, shape (n, 3) [N].

        Parameters
        ----------
        trajectory : Trajectory
            A motion of this system.
        """
        import numpy as np

        reaction = trajectory.reactions[self._shaft.joint]
        axis = np.array([self._number(x, trajectory.values) for x in self._shaft.axis])
        n = trajectory.poses[self._shaft.rotor].rotation @ axis
        F = reaction.force - n * np.sum(n * reaction.force, axis=1)[:, None]
        Y = np.cross(reaction.moment, n)
        (first, a), (second, b) = (
            (name, self._number(x, trajectory.values)) for name, x in self._places.items()
        )
        return {first: (Y - b * F) / (a - b), second: (a * F - Y) / (a - b)}

    def _number(self, x: Scalar, values: Mapping[str, float]) -> float:
        e = self._shaft.e
        atoms = {e.model.names.atoms[name]: value for name, value in values.items()}
        return float(sympy.sympify(e.sympy(x)).xreplace(atoms))

    def _lines(self, write: Any) -> list[str]:
        e = self._shaft.e
        lines = []
        for axes, forces in (("", self.canonical), ("'", self.canonical_rotating)):
            for name, force in forces.items():
                for letter, component in zip(LETTERS, force, strict=True):
                    if component != 0:
                        symbol = sympy.Symbol(f"{name}_{letter}{axes}", real=True)
                        lines.append(write(e.ring.generator(symbol, "reaction"), component, e.ring))
        return lines

    def text(self) -> str:
        """Components in ground axes, and with a prime in the axes of the rotor, as plain text, without zeros."""
        head = f"Forces of the bearings on the shaft of '{self._shaft.rotor}': A_x in ground axes, A_x' in its own"
        head = head.replace("A_", f"{self.names[0]}_")
        return "\n".join([head, *(f"  {line}" for line in self._lines(equation_text))])
