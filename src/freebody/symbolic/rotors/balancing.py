"""Static and dynamic balancing of a rigid rotor.

S = Σ m r and P = Σ m z r are the first moment and the product moment of the rotor about its shaft (z along the shaft, r
across it). The rotor loads its bearings with the rotating force -ω² S and moment -ω² n × P. Correction masses m_i at
r_i in planes z_i, U_i = m_i r_i, remove both if

    U_1 + U_2 = -S,        z_1 U_1 + z_2 U_2 = -P          dynamic balance, two planes
    U_1 = -S                                               static balance, one plane; P + z_1 U_1 remains.

The correction does not depend on the speed or acceleration. Source: chapter, section 6.6; ISO 21940-11 has the terms.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import sympy

from ...dynamics.state import State
from ...errors import ModelError
from ...model.model import Model
from ...scalar.algebra import Expression, Scalar, add, apply, dot, negate, scale, subtract
from ...space.spatial import Inertia, inertia_sum, inertia_to_parent
from ..free_body.reaction import LETTERS
from ..printing.display import Formulas, equation_text
from .bearings import Shaft, shaft_of


def balance(s: Any, joint: Any, planes: Mapping[str, Expression]) -> Balance:
    """Return the correction masses that balance a rotor: in two planes dynamically, in one plane statically.

    Parameters
    ----------
    s : System, Model or Equations
    joint : str or Joint
        The hinge of the rotor; bodies welded to its child are part of the rotor.
    planes : mapping
        Names of one or two planes -> distance from the joint's point along the joint's axis, number or expression [m].

    Returns
    -------
    Balance

    Raises
    ------
    ModelError
        A joint that is not a hinge, a rotor with moving parts, or a number of planes other than one or two.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("rotor")
    >>> m, R, L, e = s.parameters(m=2, R=0.1, L=0.4, e=0.001)
    >>> disk = s.body("disk", fb.disk(m, R).moved((e, 0, L / 8)))
    >>> axle = s.hinge("axle", s.ground, disk, coordinate="theta")
    >>> print(fb.balance(s, axle, planes={"left": 0, "right": L / 4}).text())
    Corrections of 'disk', mass times distance from the shaft, in the axes of the rotor
      left_x = -m*e/2
      right_x = -m*e/2
    """
    rotor_shaft = shaft_of(s, joint)
    return Balance(rotor_shaft, rotor_shaft.distances(planes, "the correction planes"))


class Balance(Formulas):
    """Correction of a rotor. Made by :func:`balance`; components are in the axes of the rotor."""

    def __init__(self, shaft: Shaft, places: dict[str, Scalar]) -> None:
        self._shaft = shaft
        e = shaft.e
        _, h, J = rotor_inertia(e.model, e.state, shaft.link, shaft.joint)
        n = shaft.axis
        first = subtract(h, scale(dot(n, h), n))  # S
        Jn = apply(J, n)
        product = negate(subtract(Jn, scale(dot(n, Jn), n)))  # P: J n = Σ m (r² + z²) n - Σ m z (r + z n)
        self.canonical_first, self.canonical_product = first, product
        if len(places) == 1:
            ((name, z),) = places.items()
            self.canonical = {name: negate(first)}
            self.canonical_left = add(product, scale(z, negate(first)))
        else:
            self.canonical = shaft.two_forces(places, negate(first), negate(product), "correction planes")
            self.canonical_left = (0, 0, 0)
        self.planes = tuple(places)
        self._places = places

    @cached_property
    def unbalance(self) -> tuple[Any, Any]:
        """S = Σ m r [kg m] and P = Σ m z r [kg m²] of the rotor, SymPy columns."""
        return self._shaft.e.column(self.canonical_first), self._shaft.e.column(self.canonical_product)

    @cached_property
    def corrections(self) -> dict[str, Any]:
        """U = mass times distance from the shaft in each plane, SymPy columns [kg m]."""
        return {name: self._shaft.e.column(U) for name, U in self.canonical.items()}

    @cached_property
    def left(self) -> Any:
        """Remaining product moment Σ m z r, SymPy column [kg m²]; zero after dynamic balancing."""
        return self._shaft.e.column(self.canonical_left)

    def masses(
        self, radius: Expression, values: Mapping[Any, Expression] | None = None
    ) -> dict[str, tuple[float, tuple[float, float, float]]]:
        """Return the mass [kg] in each plane at a distance from the shaft, and its place in the rotor's axes [m].

        Parameters
        ----------
        radius : number or expression
            Distance from the shaft, positive [m].
        values : mapping, optional
            Values of parameters in place of their defaults.

        Returns
        -------
        dict
            Plane -> (mass, place from the joint's point), to be added as ``fb.particle(mass).moved(place)``.

        Raises
        ------
        ModelError
            A radius that is not positive, or a parameter without a value.
        """
        e = self._shaft.e
        atoms = {e.model.names.atoms[name]: value for name, value in e.model.values(values).items()}

        def number(x: Any) -> float:
            return float(sympy.N(sympy.sympify(x).xreplace(atoms), 17))

        r = number(self._shaft.vocabulary.expression(radius, "the radius of the correction masses"))
        if not r > 0:
            raise ModelError(f"Expected a positive radius of the correction masses, got {r:g} m.")
        axis = [number(e.sympy(x)) for x in self._shaft.axis]
        masses = {}
        for name, U in self.canonical.items():
            vector = [number(e.sympy(x)) for x in U]
            size = math.hypot(*vector)
            z = number(e.sympy(self._places[name]))
            across = [x / size * r if size else x for x in vector]
            x, y, w = (c + z * n for c, n in zip(across, axis, strict=True))
            masses[name] = (size / r, (x, y, w))
        return masses

    def _lines(self, write: Any) -> list[str]:
        e = self._shaft.e
        return [
            write(
                e.ring.generator(sympy.Symbol(f"{name}_{letter}", real=True), "reaction"), component, e.ring
            )
            for name, U in self.canonical.items()
            for letter, component in zip(LETTERS, U, strict=True)
            if component != 0
        ]

    def text(self) -> str:
        """The components of the corrections as plain text, without zeros."""
        lines = self._lines(equation_text) or ["none: the rotor is balanced"]
        head = f"Corrections of '{self._shaft.rotor}', mass times distance from the shaft, in the axes of the rotor"
        return "\n".join([head, *(f"  {line}" for line in lines)])


def rotor_inertia(model: Model, state: State, link: int, joint: str) -> Inertia:
    """Mass, first moment and inertia of all links that turn rigidly with a link, about its origin and in its axes.

    Raises
    ------
    ModelError
        A part of the rotor can move relative to it.
    """
    composite = {link: state.inertia(link)}
    order = [link]
    for i in range(link + 1, len(model.links)):
        part = model.links[i]
        if part.parent in composite:
            if not part.fixed:
                raise ModelError(
                    f"Expected a rigid rotor on '{joint}', but '{part.joint}' lets a part of it move. Weld it, or "
                    "balance the parts one by one."
                )
            composite[i] = state.inertia(i)
            order.append(i)
    for i in reversed(order[1:]):
        R, p, _ = state.joint(i)
        parent = model.links[i].parent
        composite[parent] = inertia_sum(composite[parent], inertia_to_parent(R, p, composite[i]))
    return composite[link]
