"""Forces and moments on one body by name, and the balance that they form with its motion: F = m a_C and M = dH/dt.

    Σ F = m a_C,        Σ M_P = dH_C/dt + r_PC × m a_C

The second holds about any point P, moving or not. H_C contains the spin of rotors that stand in the body.

Source: chapter 6, eqs (6.3), (6.24), (6.25).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property, reduce
from typing import Any

from ...describe.body import Body
from ...describe.constraints.constraint import Gear
from ...describe.frame import Point
from ...describe.loads.action import Couple, GeneralizedForce, JointForce, PointForce
from ...describe.loads.load import Load
from ...dynamics.armature import resistance, spin_rate
from ...dynamics.conditions.constraint_forces import friction_along_tangents, torques
from ...dynamics.conditions.constraints import Row, rows
from ...dynamics.conditions.contact import unit_forces
from ...dynamics.coordinates import forces_on_free_displacements
from ...dynamics.joints.freedom import on_ball, on_path, unit_load_wrench
from ...dynamics.kinematics import point_position, rotation, velocities
from ...dynamics.loads.actions import actions, scaled
from ...dynamics.loads.added_mass import moving
from ...dynamics.loads.loading import weight
from ...dynamics.loads.power import joint_link, speed_of
from ...errors import ModelError, nearest
from ...model.contact_modes import Sliding, Touching
from ...model.model import JointPlace
from ...scalar.algebra import (
    IDENTITY,
    ZERO,
    Scalar,
    Vector,
    add,
    apply,
    apply_transpose,
    cross,
    scale,
    subtract,
)
from ...space.spatial import ZERO6, Spatial, times
from ..derivation.bodies import own_body
from ..derivation.derivation import Derivation
from ..derivation.questions import named
from ..printing.display import equation_text
from .action import Action
from .contact_forces import contact_actions
from .gears import radial_forces, radial_laws, radial_symbols, undetermined_by_couplings
from .reaction import unknowns


def total_of(vectors: Iterable[Vector]) -> Vector:
    """Return the sum of vectors."""
    return reduce(add, vectors, ZERO)


@named("the free body")
def body_balance(e: Derivation, body: str) -> BodyBalance:
    """Return the balance of a body of the model about its mass centre, in ground axes."""
    return BodyBalance(e, body)


class BodyBalance:
    """Forces and moments on one body, and its motion, in canonical polynomials.

    :class:`~freebody.symbolic.free_body.free_body.FreeBody` adds what users ask for.
    """

    def __init__(self, e: Derivation, body: str, about: Any = None, frame: Any = None) -> None:
        self._e = e
        self.body = body
        model, state = e.model, e.state
        self._place = model.bodies[body]
        link = self._place.link
        self._R = rotation(model, state, link)
        posture = e.postures[body]
        r_OC = apply(posture.rotation, state.vector(self._place.center))
        self._centre = add(posture.position, r_OC)
        self._about = self._centre if about is None else self._point(about)
        self.about = "its mass centre C" if about is None else str(about)
        self.frame = "ground"
        self._axes = IDENTITY
        if frame is not None:
            name = frame if isinstance(frame, str) else own_body(model, frame, "a frame").name
            if name != "ground":
                if name not in model.bodies:
                    raise ModelError(f"Unknown frame '{name}'; {nearest(name, [*model.bodies, 'ground'])}")
                self.frame = name
                self._axes = rotation(model, state, model.bodies[name].link)

    def _point(self, about: Any) -> Vector:
        if isinstance(about, Body):
            about = about.origin
        if not isinstance(about, Point):
            raise ModelError(
                f"Expected a point, such as bar.point(0, 1, 0), to take moments about, got {about!r}."
            )
        own_body(self._e.model, about.body, "a point to take moments about")
        return point_position(self._e.model, self._e.state, about)

    @cached_property
    @named("the free body")
    def actions(self) -> tuple[Action, ...]:
        """Every force and couple on the body, by name."""
        e, model, state = self._e, self._e.model, self._e.state
        result = []
        if self._place.mass != 0 and any(g != 0 for g in model.gravity):
            name = "gravity" if "weight" in model.loads else "weight"
            result.append(
                Action(name, "weight", weight(model, state, self._place.mass), ZERO, self._centre, "gravity")
            )
        for load in model.loads.values():
            if isinstance(load, Sliding) and load.contact.name in model.constraints:
                continue  # of an adhesion: one force with the friction of N
            result.extend(self._load_actions(load))
        for name, joint in model.joints.items():
            sign = 1 if joint.child == self.body else -1 if joint.parent == self.body else 0
            if sign == 0:
                continue
            at = e.joint_points[name]
            for c in unknowns(model, state, name):
                value = e.ring.generator(c.symbol, "reaction")
                force, moment = scale(sign * value, c.force), scale(sign * value, c.moment)
                other = joint.parent if sign == 1 else joint.child
                result.append(Action(c.name, "reaction", force, moment, at, f"joint '{name}', {other}"))
            result.extend(self._armature_actions(name, joint))
        for row, symbol, pair in zip(rows(model), e.multipliers, e.constraint_wrenches, strict=True):
            result.extend(self._constraint_actions(row, symbol, pair))
        for gear, symbol in radial_symbols(e).items():
            for spot, force, _ in radial_forces(e, gear):
                if spot.body.name == self.body:
                    result.append(Action(symbol.name, "reaction", force, ZERO, spot.position, gear))
        return tuple(result)

    @cached_property
    def laws(self) -> tuple[tuple[Scalar, Scalar], ...]:
        """(left, right) of the further laws between the forces, canonical, such as F_r = tan α |F_t| of teeth."""
        return tuple(radial_laws(self._e, {a.by for a in self.actions}))

    def remarks(self) -> list[str]:
        """Lines of text: the laws, and the forces that no equation determines."""
        laws = [equation_text(left, right, self._e.ring) for left, right in self.laws]
        return [f"  {line}" for line in (*laws, *undetermined_by_couplings(self._e, body=self.body))]

    def _armature_actions(self, name: str, joint: JointPlace) -> list[Action]:
        """The force with which armature and rotors resist along a joint: on its child, and opposite on its parent."""
        e, model, state = self._e, self._e.model, self._e.state
        result: list[Action] = []
        for i in joint.links:
            forces = resistance(state, i, e.udot, e.accelerations)
            sign = -1 if joint.child == self.body else 1
            label = f"{name}_rotor" if model.links[i].rotor != ZERO else f"{name}_armature"
            if model.links[i].one_dof and forces:
                several = sum(bool(model.links[k].armature) for k in joint.links) > 1
                label = f"{label}_{joint.links.index(i) + 1}" if several else label
                result += self._along_joint(label, name, i, -forces[0], "motor")
            elif forces:
                R = rotation(model, state, joint.links[-1])
                moment, force = (scale(sign, apply(R, x)) for x in on_ball(model, state, joint, i, forces))
                result.append(Action(label, "motor", force, moment, e.joint_points[name], f"joint '{name}'"))
        return result

    def _constraint_actions(self, row: Row, symbol: Any, pair: Any) -> list[Action]:
        """Forces of one condition on this body: of a loop-closing joint, contact or rope, or along the joints."""
        e, model, state = self._e, self._e.model, self._e.state
        value = e.ring.generator(symbol, "reaction")
        owner = model.constraints[row.owner]
        if isinstance(owner, Touching):
            return self._contact_actions(owner, row, value)
        result = []
        for place, force, moment in pair:
            body, point = place if isinstance(place, tuple) else (place.body, place)
            if body.name == self.body:
                at = point_position(model, state, point)
                result.append(
                    Action(row.name, "reaction", scale(value, force), scale(value, moment), at, row.owner)
                )
        if isinstance(owner, Gear):
            for joint, link, factor in torques(model, state, owner):
                result += self._along_joint(row.name, joint, link, factor * value, "reaction")
        elif not pair:
            matrix = e.conditions.matrix[rows(model).index(row)]
            for j, entry in enumerate(matrix):
                if entry != 0:
                    result += self._generalized_actions(row.name, j, entry * value, "reaction")
        if len(result) > 1:
            # one unknown makes one action: its forces and couples on this body are added
            force, moment = ZERO, ZERO
            for part in result:
                force, moment = add(force, part.force), add(moment, part.about(result[0].at))
            result = [replace(result[0], force=force, moment=moment)]
        return result

    def _contact_actions(self, touching: Touching, row: Row, value: Scalar) -> list[Action]:
        """Forces of one condition of a contact on this body, with the friction of its slip."""
        e, contact = self._e, touching.contact
        if contact.law is None:
            return contact_actions(e, self.body, touching, row, value)
        names = [contact.normal_name, *contact.tangent_names]
        unit = unit_forces(e.model, e.state, contact)
        parts = [(row.name, "reaction", unit[names.index(row.name)], value)]
        if touching.slips and not contact.frictionless:
            shares = friction_along_tangents(e.model, e.state, touching, value)
            for name, share, acting in zip(contact.tangent_names, shares, unit[1:], strict=True):
                parts.append((name, "friction", acting, share))
        result = []
        for name, kind, acting, factor in parts:
            forces = [scaled(action, factor) for action in acting]
            result += [
                replace(x, by=f"contact '{contact.name}'")
                for x in self._actions_of(contact.law, name, kind, forces)
            ]
        return result

    def _load_actions(self, load: Load) -> list[Action]:
        """The actions of a load on this body; those at one place make one."""
        acting = actions(self._e.model, moving(self._e.model, self._e.state, self._e.udot), load.name)
        return [replace(x, load=load.name) for x in self._actions_of(load, load.name, load.look.role, acting)]

    def _actions_of(self, part: Any, label: str, role: str, acting: Iterable[Any]) -> list[Action]:
        """Actions of a load or contact on this body; those at one place make one."""
        model, state = self._e.model, self._e.state
        result: list[Action] = []
        at_place: dict[Vector, Action] = {}
        for action in acting:
            match action:
                case JointForce():
                    link = joint_link(model, action)
                    result += self._along_joint(label, action.joint.name, link, action.value, role)
                    continue
                case GeneralizedForce():
                    speed = speed_of(model, part, action.coordinate)
                    result += self._generalized_actions(label, speed, action.value, role)
                    continue
                case PointForce(point, force) if point.body.name == self.body:
                    at, moment = point_position(model, state, point), ZERO
                case Couple(body, moment) if body.name == self.body:
                    at, force = self._centre, ZERO
                case _:
                    continue
            before = at_place.get(at, Action(label, role, ZERO, ZERO, at, ""))
            at_place[at] = replace(before, force=add(before.force, force), moment=add(before.moment, moment))
        result += at_place.values()
        several = len(result) > 1 and len({action.name for action in result}) == 1
        names = [f"{label}_{i}" if several else action.name for i, action in enumerate(result, start=1)]
        return [replace(x, name=name) for x, name in zip(result, names, strict=True)]

    def _generalized_actions(self, load: str, speed: int, value: Scalar, kind: str) -> list[Action]:
        """A generalized force as forces and couples along the free displacements, which have the same power."""
        model, state = self._e.model, self._e.state
        tau = forces_on_free_displacements(model, state, speed, value)
        parts = []
        for name, joint in model.joints.items():
            for i in joint.links:
                if tau.get(i, 0) != 0:
                    parts += self._along_joint(load, name, i, tau[i], kind)
            if joint.pair.path:
                parts += self._on_child(load, name, on_path(model, state, joint, {speed: value}), kind)
        if len(parts) < 2:
            return parts
        if any(part.force != ZERO for part in parts):
            return [replace(part, name=f"{load}_{i}") for i, part in enumerate(parts, start=1)]
        total = total_of(part.moment for part in parts)
        return [replace(parts[0], moment=total, by="")] if total != ZERO else []

    def _along_joint(self, load: str, name: str, link: int, value: Scalar, kind: str) -> list[Action]:
        """A load along a displacement of a joint: on its child, or with opposite sign on its parent."""
        model, state = self._e.model, self._e.state
        joint = model.joints[name]
        sign = 1 if joint.child == self.body else -1 if joint.parent == self.body else 0
        if sign == 0:
            return []
        # the massless links inside the joint transmit the whole load
        return self._on_child(load, name, times(value, unit_load_wrench(model, state, joint, link)), kind)

    def _on_child(self, load: str, name: str, wrench: Spatial, kind: str) -> list[Action]:
        """A load in a joint by its wrench on the child, in the axes of the last link; opposite on the parent."""
        model, state = self._e.model, self._e.state
        joint = model.joints[name]
        sign = 1 if joint.child == self.body else -1 if joint.parent == self.body else 0
        if sign == 0 or wrench == ZERO6:
            return []
        R = rotation(model, state, joint.links[-1])
        moment, force = (scale(sign, apply(R, v)) for v in wrench)
        return [Action(load, kind, force, moment, self._e.joint_points[name], f"joint '{name}'")]

    @cached_property
    @named("the free body")
    def mass_acceleration(self) -> Vector:
        """m a_C in the axes of the components [N], canonical."""
        a = self._e.center_acceleration(self.body)
        return self._in_axes(scale(self._e.state(self._place.mass), a))

    @cached_property
    @named("the free body")
    def momentum_rate(self) -> Vector:
        """dH_C/dt + r_PC × m a_C about the point P of the moments [N m], canonical."""
        e, model, state = self._e, self._e.model, self._e.state
        link = self._place.link
        w, _ = velocities(model, state)[link]
        wdot, _ = e.accelerations[link]
        inertia = state.matrix(self._place.inertia)
        rate = add(apply(inertia, wdot), cross(w, apply(inertia, w)))
        rate = add(rate, self.spin_rate)
        arm = subtract(self._centre, self._about)
        ma = scale(state(self._place.mass), e.center_acceleration(self.body))
        return self._in_axes(add(apply(self._R, rate), cross(arm, ma)))

    @cached_property
    def spin_rate(self) -> Vector:
        """Rate of change of the spin of the rotors in the body, in its axes [N m], canonical."""
        e, links = self._e, self._e.model.links
        inner = (i for i, link in enumerate(links) if link.parent == self._place.link)
        return total_of(spin_rate(e.state, i, e.udot, velocities(e.model, e.state)) for i in inner)

    def _in_axes(self, v_N: Vector) -> Vector:
        """Return the components of a vector in the axes of the equations, from those in ground axes."""
        return apply_transpose(self._axes, v_N)

    @cached_property
    @named("the free body")
    def force_sum(self) -> Vector:
        """Σ F in the axes of the components [N], canonical."""
        return self._in_axes(total_of(action.force for action in self.actions))

    @cached_property
    @named("the free body")
    def moment_sum(self) -> Vector:
        """Σ M about the point P of the moments [N m], canonical."""
        return self._moments_about(self._about)

    def _moments_about(self, point: Vector) -> Vector:
        """Return the sum of the moments about a point, in the body's axes of reference."""
        return self._in_axes(total_of(action.about(point) for action in self.actions))

    @cached_property
    @named("the free body")
    def balances(self) -> tuple[tuple[Scalar, Scalar], ...]:
        """(left, right) of the three force and three moment equations, canonical."""
        force = zip(self.force_sum, self.mass_acceleration, strict=True)
        moment = zip(self.moment_sum, self.momentum_rate, strict=True)
        return (*force, *moment)
