"""The gap of a mesh: teeth with backlash bear on one flank or the other, or on none.

With x = y_1 - i y_2 and the backlash b of the first joint,

    0 ≤ b/2 ± x  ⊥  N ≥ 0

N on a flank is the moment (of a rack, the force) on the first joint; the teeth push with the force of
:mod:`freebody.describe.contacts.mesh`, N f ± and N |f| tan α apart. Friction is a tangential force of the contact:

- Where teeth slide at the pitch point, on crossed axes, μ N |f|/cos α along them. A worm of lead angle γ then has the
  efficiency (cos α - μ tan γ)/(cos α + μ cot γ), and holds its wheel at rest if μ > cos α tan γ.
- Elsewhere they roll there, and slide before and behind. The mean loss is a moment μ N on the first joint against its
  rate. With power from the first to the second joint the efficiency is η = 1/(1 + μ), in the other sense
  1 - μ = 2 - 1/η, and below η = 1/2 the gear locks itself.

Sources: Shigley & Mischke, Mechanical Engineering Design (1989), §13-17 and 8-2; Pfeiffer & Glocker, Multibody Dynamics
with Unilateral Contacts (1996), chapter 10.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import sympy

from ...scalar.algebra import Scalar
from ..constants import check_default
from ..frame import Frame
from ..joints.joint import Joint
from ..loads.action import Action, JointForce, PointForce
from ..part import Constant
from .gap import Gap
from .mesh import Mesh, mesh_of


class Backlash(Gap, kind="backlash"):
    """Teeth with backlash that couple two joints; ``side`` is the flank, 1 or -1, and 0 for both."""

    first: Joint
    second: Joint
    ratio: Constant
    backlash: Constant  # of the first joint [rad] or [m]
    pressure_angle: Constant
    helix_angle: Constant = 0
    side: int = 0

    noun = "gear"

    def check(self) -> None:
        """Refuse a backlash that is no gap."""
        system: Any = self.first.parent.system
        cure = " Leave it out for teeth without backlash."
        check_default(
            system, self.backlash, lambda x: x > 0, f"a backlash greater than 0 for {self.title}", cure
        )
        super().check()

    @cached_property
    def mesh(self) -> Mesh | str:
        """Where and how the teeth push, or the reason why only the ratio is known."""
        return mesh_of(self.first, self.second, self.ratio, self.helix_angle)

    @property
    def bodies(self) -> tuple[Frame, Frame]:
        """The two bodies with teeth."""
        if isinstance(self.mesh, Mesh):
            return self.mesh.first, self.mesh.second
        return self.first.child, self.second.child

    @property
    def turns(self) -> bool:
        """True if the first joint turns: the backlash is an angle, and the force on a flank a moment."""
        return self.first.primitives[0].turns

    @property
    def parts(self) -> tuple[str, str]:
        """What touches what, in words."""
        first, second = (body.name for body in self.bodies)
        return f"teeth of {first}", second

    @property
    def elements(self) -> Sequence[tuple[str, Gap]]:
        """Both flanks: that on which the first joint is pushed forwards, and that on which it is pushed back."""
        return (("forward", replace(self, side=1)), ("back", replace(self, side=-1)))

    def gap(self, at: Any) -> Scalar:
        """Return the gap of the flank, as a displacement of the first joint."""
        x = at.displacement(self.first) - at(self.ratio) * at.displacement(self.second)
        return at(self.backlash) / 2 + self.side * x

    def normal(self, at: Any) -> Iterator[Action]:
        """Yield the force of the teeth on both bodies, at the pitch point; only along the joints if it is not known."""
        mesh = self.mesh
        if not isinstance(mesh, Mesh):
            yield JointForce(self.first, self.side)
            yield JointForce(self.second, -self.side * at(self.ratio))
            return
        across, apart = at.vector(mesh.tangent, mesh.carrier), at.vector(mesh.apart, mesh.carrier)
        press = across.norm() * at(sympy.tan(self.pressure_angle)) / apart.norm()
        yield from self._pair(at, mesh, self.side * across + press * apart)

    def tangents(self, at: Any) -> Sequence[Sequence[Action]]:
        """Return the friction along the teeth, or where they do not slide at the pitch point on the first joint."""
        mesh = self.mesh
        if not isinstance(mesh, Mesh) or mesh.teeth is None:
            return ((JointForce(self.first, 1),),)
        across, teeth = at.vector(mesh.tangent, mesh.carrier), at.vector(mesh.teeth, mesh.carrier)
        size = across.norm() / (teeth.norm() * at(sympy.cos(self.pressure_angle)))
        return (tuple(self._pair(at, mesh, size * teeth)),)

    @staticmethod
    def _pair(at: Any, mesh: Mesh, force: Any) -> Iterator[Action]:
        place = at.position(mesh.point)
        yield PointForce(at.spot(mesh.first, place), force)
        yield PointForce(at.spot(mesh.second, place), -force)
