"""The battery of a kind of joint."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..describe.joints.joint import Joint
from ..describe.system import System
from ..dynamics.composite import mass_matrix
from ..dynamics.energy import kinetic_energy
from ..dynamics.kinematics import (
    Spot,
    accelerations,
    angular_velocity,
    point_acceleration,
    point_position,
    point_velocity,
    poses,
    state_along,
    state_moving,
    velocities,
)
from ..dynamics.newton_euler import bias, inverse_dynamics, reactions
from ..dynamics.state import State, float_state, polynomial_state
from ..model.assemble import assemble
from ..model.model import Model
from ..scalar.polynomial import Ring
from ..scalar.series import derivative_at_start
from ..space.mass import MassProperties
from .comparison import drawn_data, same, same_after_a_file
from .machines import small_inertia, small_rotation
from .states import polynomial_value, random_state, state_values


def check_joint(kind: type[Joint], /, seed: int = 0, **data: Any) -> None:
    """Check a kind of joint on a machine of its own; fields without ``data`` get random values.

    Velocities and accelerations are the derivatives of the pose; every motion moves masses, and what the joint
    transmits has no power in its motions; the reactions obey Newton's and Euler's laws on both of its bodies; floats,
    formulas and compiled code agree, one state and many; it is drawn; a kind with a name in files is the same when
    read again, and twice asked it says the same motions.

    Parameters
    ----------
    kind : subclass of Joint
    seed : int
        Seed of the random machine, state and data.
    **data : optional
        Values of fields, such as ``radius=0.1``.

    Raises
    ------
    AssertionError
        It says which law does not hold.
    ModelError
        A joint that the machine refuses.

    Examples
    --------
    >>> from freebody.describe.joints.kinds.universal import UniversalJoint
    >>> check_joint(UniversalJoint)
    """
    s = _machine(kind, seed, data)
    model = assemble(s)
    _asked_twice(kind, seed, data, s)
    q, u = random_state(model, seed)
    udot = [float(x) for x in np.random.default_rng(seed + 1).normal(size=model.n_u)]
    state = float_state(model, q, u)
    _derivatives(kind, model, state, udot)
    _masses(kind, model, state)
    _power_of_reactions(kind, model, state, udot)
    _newton_and_euler(kind, model, state)
    _every_scalar(kind, s, model, (q, u, udot))
    _drawn(kind, s)
    if kind.kind:
        still = [0] * model.n_u
        same_after_a_file(
            kind, s, lambda again: list(inverse_dynamics(again, float_state(again, q, u), still))
        )


def _machine(kind: type[Joint], seed: int, data: dict[str, Any]) -> System:
    """A body on a hinge in the ground, another one on the joint x, and a third one on a slider."""
    rng = np.random.default_rng(seed)
    s = System(f"machine of {kind.__name__}")
    s.parameters(g=9.8125)
    s.gravity = (1, "-g", 2)
    first, middle, last = (
        s.body(name, MassProperties(mass, center, small_inertia(rng)))
        for name, mass, center in (("first", 2, (0, 1, 0)), ("middle", 3, (1, 0, 1)), ("last", 1, (1, 0, 0)))
    )
    s.hinge("pin", s.ground, first, at=(3, 2, 1), axis=(1, 2, 2), coordinate="alpha")
    axes = {"parent_axes": small_rotation(rng), "child_axes": small_rotation(rng)}
    places = {"at": (0, 2, 1), "to": (1, -1, 0), **axes}
    values = drawn_data(kind, s, rng, {"parent": first, "child": middle, **places, **data})
    s.add("x", kind(**values))
    s.slider("rail", middle, last, at=(1, 2, 0), axis="y", coordinate="beta")
    return s


def _asked_twice(kind: type[Joint], seed: int, data: dict[str, Any], s: System) -> None:
    """The same data give the same motions."""
    again = _machine(kind, seed, data)
    first, second = (
        str([(type(m), m.axis, m.at, m.coordinate) for m in t.joints["x"].primitives]) for t in (s, again)
    )
    if first != second:
        raise AssertionError(
            f"{kind.__name__}: expected the same motions of the same data, got {first} and then {second}. Motions "
            f"are functions of the fields of a joint, and of nothing else."
        )


def _derivatives(kind: type[Joint], model: Model, state: State, udot: Sequence[float]) -> None:
    """Velocity and acceleration of a point of the child, and its angular velocity, against series of the pose."""
    system = model.described[0]
    point = system.bodies["middle"].point(1, 2, 3)
    along = state_along(model, state, state.u, 1, 1)
    velocity = [float(x) for x in point_velocity(model, state, point)]
    rate = [float(derivative_at_start(x)) for x in point_position(model, along, point)]
    same(kind, "the velocity and the rate of the position", velocity, rate, velocity)
    w = [float(x) for x in angular_velocity(model, state, system.bodies["middle"])]
    R = np.array(poses(model, state)["middle"].rotation, float)
    turning = [[float(derivative_at_start(x)) for x in row] for row in poses(model, along)["middle"].rotation]
    cross = np.array([np.cross(w, column) for column in R.T]).T
    same(kind, "the angular velocity and the rate of the rotation", cross.ravel(), np.ravel(turning), w)
    moving = state_moving(model, state, udot)
    second = [float(x.derivative(2)) for x in point_position(model, moving, point)]
    acceleration = [float(x) for x in point_acceleration(model, state, point, udot)]
    same(kind, "the acceleration and the second rate of the position", acceleration, second, acceleration)


def _masses(kind: type[Joint], model: Model, state: State) -> None:
    """Every motion moves masses: u·M u = 2 T > 0, and M is what inverse dynamics needs."""
    M = np.array(mass_matrix(model, state), float)
    values = np.linalg.eigvalsh((M + M.T) / 2)
    if not values[0] > len(M) * np.finfo(float).eps * values[-1]:
        names = ", ".join(model.speed_names)
        raise AssertionError(
            f"{kind.__name__}: expected a positive definite mass matrix, got one with the least eigenvalue "
            f"{values[0]:.3g}, for the speeds {names}. Two of its coordinates make the same motion, or one makes none."
        )
    none = inverse_dynamics(model, state, [0] * model.n_u, None)
    columns = [
        np.subtract(inverse_dynamics(model, state, row, None), none) for row in np.eye(len(M)).tolist()
    ]
    same(
        kind, "the mass matrix and inverse dynamics", M.ravel(), np.array(columns, float).T.ravel(), M.ravel()
    )
    u = np.array(state.u, float)
    same(
        kind,
        "u·M u and twice the kinetic energy",
        [u @ M @ u],
        [2 * float(kinetic_energy(model, state))],
        M.ravel(),
    )


def _power_of_reactions(kind: type[Joint], model: Model, state: State, udot: Sequence[float]) -> None:
    """What the joint transmits has no power in its motions, whatever their speeds."""
    joint = model.described[0].joints["x"]
    force, moment = (np.array(v, float) for v in reactions(model, state, udot)["x"])
    place = point_position(model, state, joint.child.point(*joint.end))
    rng = np.random.default_rng(model.n_u)
    for _ in range(3):
        u = [float(x) for x in rng.normal(size=model.n_u)]
        moving = float_state(model, list(state.q), u)
        slide, turn = np.zeros(3), np.zeros(3)
        for body, sign in ((joint.child, 1), (joint.parent, -1)):
            slide += sign * np.array(point_velocity(model, moving, Spot(body, place)), float)
            turn += sign * np.array(angular_velocity(model, moving, body), float)
        power, terms = force @ slide + moment @ turn, [*(force * slide), *(moment * turn), *force, *moment]
        same(kind, "the power of its reaction in its own motions and zero", [power], [0.0], terms)


def _newton_and_euler(kind: type[Joint], model: Model, state: State) -> None:
    """Without loads along the joint, its reaction is what the bodies beyond it need, by Newton's and Euler's laws."""
    joint = model.described[0].joints["x"]
    if any(motion.armature or motion.rotor for motion in joint.primitives):
        return  # their forces along the joint are no part of the reaction
    M, needed = (np.array(x, float) for x in (mass_matrix(model, state), bias(model, state)))
    udot = np.linalg.solve(M, -needed).tolist()
    found = np.array(reactions(model, state, udot)["x"], float).ravel()
    place = np.array(point_position(model, state, joint.child.point(*joint.end)), float)
    force, moment, terms = np.zeros(3), np.zeros(3), [*found]
    V, A = velocities(model, state), accelerations(model, state, udot, (0, 0, 0))
    for name in ("middle", "last"):
        body = model.described[0].bodies[name]
        properties, link = body.mass_properties, model.bodies[name].link
        R, J = (np.array(x, float) for x in (poses(model, state)[name].rotation, properties.inertia))
        w, alpha = np.array(V[link][0], float), np.array(A[link][0], float)
        center = body.point(*properties.center)
        a = np.array(point_acceleration(model, state, center, udot), float)
        f = float(properties.mass) * (a - np.array(state.vector(model.gravity), float))
        n = R @ (J @ alpha + np.cross(w, J @ w))
        arm = np.array(point_position(model, state, center), float) - place
        force, moment = force + f, moment + n + np.cross(arm, f)
        terms += [*f, *n, *np.cross(arm, f)]
    same(kind, "its reaction and Newton's and Euler's laws", found, [*force, *moment], terms)


def _every_scalar(kind: type[Joint], s: System, model: Model, motion: tuple[Any, Any, Any]) -> None:
    """Numbers, formulas, compiled code of one state and of a batch."""
    from ..program.program import compile_system

    q, u, udot = motion
    numbers = [float(x) for x in inverse_dynamics(model, float_state(model, q, u), udot)]
    symbols = inverse_dynamics(model, polynomial_state(model, Ring()), None)
    free = [float(x) for x in bias(model, float_state(model, q, u))]
    values = state_values(model, q, u)
    same(
        kind,
        "forces as numbers and as formulas",
        free,
        [polynomial_value(x, values) for x in symbols],
        numbers,
    )
    program = compile_system(s)
    one = np.asarray(program.inverse_dynamics(q, u, udot), float)
    same(kind, "forces as numbers and in compiled code", numbers, one, numbers)
    batch = program.inverse_dynamics(np.array([q, q]), np.array([u, u]), np.array([udot, udot]))
    same(kind, "forces of one state and of a batch", [*one, *one], np.asarray(batch, float).ravel(), numbers)


def _drawn(kind: type[Joint], s: System) -> None:
    """The joint is drawn, if it transmits anything."""
    from ..picture.machine.draw import draw

    if s.joints["x"].pair.holds and 'data-joint="x"' not in draw(s).svg:
        raise AssertionError(f"{kind.__name__}: the joint is not drawn.")
