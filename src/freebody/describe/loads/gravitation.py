"""Gravitation: the attraction of a body to a point, at r from it to the body's mass centre.

F = -μ m r/r³,        V = -μ m/r

An extended body, of moment of inertia J about its mass centre, feels the gradient of the field, too:

V = -μ m/r - μ (tr J r² - 3 r·J r)/(2 r⁵),        M = 3 μ r × J r/r⁵

to second order in its size over the distance. The opposite force acts at the point that attracts.

Source: Hughes, Spacecraft Attitude Dynamics (1986), §8.1 (MacCullagh's formula).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...errors import ModelError
from ...scalar.algebra import HALF, Expression, FieldVector, Scalar, apply, apply_transpose, divide
from ...space.mass import MassProperties
from ..description import Description
from ..frame import Frame, Point
from ..part import Constant, add
from .action import Action, Couple, PointForce
from .load import Load


class Gravitation(Load, kind="gravitation"):
    """Attraction of a body to a point of another body or of the ground."""

    body: Frame
    toward: Point
    parameter: Constant  # μ, the constant of gravitation times the mass that attracts [m³/s²]
    extended: bool = False

    units = {"parameter": "m^3/s^2"}
    noun = "gravitation"

    def check(self) -> None:
        """Refuse the ground, a body that attracts itself, and the inertia of a body that has none."""
        if self.body.is_ground or self.body is self.toward.body:
            what = (
                "the ground, which nothing moves"
                if self.body.is_ground
                else "a body toward a point of itself"
            )
            raise ModelError(f"{self.heading} acts on {what}. Name a body, and a point of another one.")
        if not self.extended:
            return
        if all(x == 0 for row in self._mass.inertia for x in row):
            raise ModelError(
                f"{self.heading}: '{self.body.name}' has no moment of inertia, so the gradient of the field "
                f"does nothing to it. Leave out extended=True."
            )

    @property
    def _mass(self) -> MassProperties:
        assert self.body.mass_properties is not None
        return self.body.mass_properties

    def _place(self, at: Any) -> tuple[FieldVector, Scalar, FieldVector, Scalar]:
        """Return r, its length, J r in ground axes, and the trace of J."""
        r = at.line(self.toward, self.body.point(*self._mass.center))
        if not self.extended:
            return r, r.norm(), r, 0
        J = tuple(tuple(at(x) for x in row) for row in self._mass.inertia)
        turned = apply(J, apply_transpose(at.rotation(self.body), tuple(r)))  # type: ignore[arg-type]
        return r, r.norm(), at.vector(FieldVector(r.field, turned), self.body), J[0][0] + J[1][1] + J[2][2]

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the attraction and its opposite, and the moment of the gradient."""
        r, d, Jr, trace = self._place(at)
        mu = at(self.parameter)
        cube = d * d * d
        force = -divide(mu * at(self._mass.mass), cube) * r
        if self.extended:
            fifth = cube * d * d
            along = divide(15 * mu * r.dot(Jr), 2 * fifth * d * d) - divide(3 * mu * trace, 2 * fifth)
            force = force + along * r - divide(3 * mu, fifth) * Jr
            yield Couple(self.body, divide(3 * mu, fifth) * r.cross(Jr))
        force = at.named(force)
        yield PointForce(self.body.point(*self._mass.center), force)
        yield PointForce(self.toward, -force)

    def potential(self, at: Any) -> Scalar:
        """Return -μ m/r and, of an extended body, the part of its inertia [J]."""
        r, d, Jr, trace = self._place(at)
        mu = at(self.parameter)
        V = -divide(mu * at(self._mass.mass), d)
        if self.extended:
            cube = d * d * d
            V = V - HALF * (divide(mu * trace, cube) - divide(3 * mu * r.dot(Jr), cube * d * d))
        return V


def gravitation(
    system: Description,
    name: str,
    body: Frame,
    toward: Any = None,
    *,
    parameter: Expression,
    extended: bool = False,
) -> Load:
    """Add the attraction of a body to a point: μ m/r², with the moment of the gradient of the field if ``extended``.

    Parameters
    ----------
    name : str
    body : Body
    toward : Point, or Body (its mass centre), optional
        What attracts, and is attracted; by default the ground's origin.
    parameter : expression
        μ: the constant of gravitation times the mass that attracts [m³/s²].
    extended : bool
        If true, the moment of inertia takes part, to second order in the body's size over the distance.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("satellite")
    >>> m, mu = s.parameters(m=1.0, mu=398600.4418)
    >>> moon = s.body("moon", fb.particle(m))
    >>> orbit = s.free("orbit", s.ground, moon)
    >>> s.gravitation("earth", moon, parameter=mu)
    gravitation 'earth'
    """
    if toward is None:
        toward = system.ground.origin
    elif getattr(toward, "mass_properties", None) is not None:
        toward = toward.point(*toward.mass_properties.center)
    return add(system, name, Gravitation(body, toward, parameter, bool(extended)))
