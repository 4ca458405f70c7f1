"""What a page shows of a motion that it computes itself: the outputs of `motion.live` and their places."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...dynamics import State, kinetic_energy, poses, potential_energy
from ...dynamics.conditions.contact import touches
from ...dynamics.kinematics import angular_velocity
from ...dynamics.motion import Motion, all_reactions, transmitting
from ...model.contact import Contact, friction_margin
from ...motion.kernels.kernels import Kernels
from ...motion.phase.phase import KINDS
from ...scalar.algebra import ZERO, Scalar, add, scale
from .forces import applied, arrows, moving_points
from .keyframes import Named


class Outputs:
    """Quantities of a frame, one after the other, with the place and the number of components of each.

    Attributes
    ----------
    bodies : list of int
        For each body the place of its position (3), followed by its rotation by rows (9) and its angular velocity (3),
        all in ground axes.
    channels : dict
        Key of a channel of the page -> [``"outputs"`` or ``"states"``, place, number of components].
    points : dict
        Key of an arrow that moves over its body -> place of its point (3).
    """

    def __init__(self, kernels: Kernels) -> None:
        model, self.kernels = kernels.model, kernels
        self.bodies = [15 * i for i in range(len(model.bodies))]
        self.channels: dict[str, list[Any]] = {}
        place = 15 * len(model.bodies)
        acting = arrows(kernels)
        for arrow in (arrow for arrow in acting if arrow.group == "force"):
            self.channels[arrow.key] = ["outputs", place, 3]
            place += 3
        first = {name: place + 6 * i for i, (name, _, _) in enumerate(transmitting(model))}
        for arrow in (arrow for arrow in acting if arrow.group == "reaction" and arrow.contact is None):
            self.channels[arrow.key] = ["outputs", first[arrow.name] + 3 * (arrow.kind == "moment"), 3]
        place += 6 * len(first)
        for name in ("kinetic", "potential", "total"):
            self.channels[f"energy {name}"] = ["outputs", place, 1]
            place += 1
        self.points: dict[str, int] = {}
        for arrow in (arrow for arrow in acting if arrow.moves):
            self.points[arrow.key] = place
            place += 3
        for i, name in enumerate(model.state_names):
            self.channels[f"state {name}"] = ["states", i, 1]
        if kernels.works or model.contacts:
            self.channels["energy work"] = ["states", model.n_q + model.n_u, 1]
        if model.contacts:
            self.channels["energy heat of friction"] = ["states", model.n_q + model.n_u + 1, 1]
        self.contacts: list[dict[str, Any]] = []
        for k, contact in enumerate(model.contacts):
            place = self._place_contact(k, contact, place)
        for arrow in (arrow for arrow in acting if arrow.contact is not None):
            at = self.contacts[arrow.contact or 0]["normal" if arrow.role != "friction" else "friction"]
            self.channels[arrow.key] = ["outputs", at, 3]
        self.count = place

    def _place_contact(self, k: int, contact: Contact, place: int) -> int:
        """Place gap, forces, margin, force vectors, point and reaches of a contact; return the place after them."""
        rough, name = not contact.frictionless, contact.name
        names = (contact.normal_name, *(contact.tangent_names if rough else ()))
        self.channels[f"gap {name}"] = ["outputs", place, 1]
        for i, force in enumerate(names):
            self.channels[f"force {force}"] = ["outputs", place + 1 + i, 1]
        end = place + 1 + len(names)
        if rough:
            self.channels[f"margin {name}"] = ["outputs", end, 1]
            end += 1
        # whose distance that of a corner is, too
        side = next((i for i, one in enumerate(self.kernels.model.contacts) if one.name == contact.owner), k)
        self.contacts.append({
            "side": k if contact.presser else side,
            "name": name, "modes": [contact.shown(kind) for kind in KINDS], "gap": place, "forces": len(names),
            "normal": end, "friction": end + 3, "point": end + 6,
            "reach": end + 9,
        })  # fmt: skip
        return end + 11

    def __call__(self, state: State, moving: Motion, forces: Sequence[Scalar] = ()) -> list[Scalar]:
        """Return the outputs at a state with its accelerations, multipliers, and forces of contacts."""
        model = self.kernels.model
        result: list[Scalar] = []
        for name, posture in poses(model, state).items():
            result += [*posture.position, *(x for row in posture.rotation for x in row)]
            result += angular_velocity(model, state, Named(name))
        result += [x for _, vector in applied(model, state, moving.udot) for x in vector]
        result += [
            x for pair in all_reactions(model, state, moving).values() for vector in pair for x in vector
        ]
        kinetic, potential = kinetic_energy(model, state), potential_energy(model, state)
        result += [kinetic, potential, kinetic + potential]
        result += [x for point in moving_points(model, state).values() for x in point]
        at = 0
        for contact, touch in zip(model.contacts, touches(model, state), strict=True):
            N, *T = forces[at : at + 1 + contact.tangents]
            at += 1 + contact.tangents
            normal, friction = scale(N, touch.normal), ZERO
            for component, tangent in zip(T, touch.tangents, strict=True):
                friction = add(friction, scale(component, tangent))
            result += [touch.gap, N]
            if not contact.frictionless:
                static, pressure = state(contact.static_friction), N + state(contact.adhesion)
                ratio = state(contact.stretch)
                result += [*T, friction_margin(static, pressure, T, ratio, state.field.sqrt)]
            result += [*normal, *friction, *touch.on_feature, *touch.both_reaches]
        assert len(result) == self.count
        return result
