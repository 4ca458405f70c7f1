"""Recursive Newton-Euler algorithm: from motion to forces, with the reaction of every joint.

Outward, the accelerations with the ground accelerated by -g; then for each link, from the tips inward,

    n_i = J α + w × J w + h × a,    f_i = m a + ([α]× + [w]×²) h,    h = m c
    F_i = (n_i, f_i) - (loads on i) + Σ F_child,        τ_i = Sᵀ F_i,

where F_i is the wrench that the joint transmits to link i, and a is the acceleration of its origin. Armature needs
forces along the joints, too, and rotors a moment on the link that they stand in (:mod:`freebody.dynamics.armature`).

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §5.3; chapter 6, eqs (6.1), (6.24), (6.25).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..model.model import GROUND, JointPlace, Model
from ..scalar.algebra import ZERO, Scalar, Vector, add, apply, cross, negate, scale
from ..space.spatial import ZERO6, Spatial, force_to_parent, minus, plus, power
from .armature import has_armature, resistance, spin_rate
from .coordinates import forces_on_free_displacements, forces_on_speeds
from .joints.freedom import loads_on_child, on_ball, on_path, transmissible
from .kinematics import accelerations, rotation, turning, velocities
from .loads.loading import Loading, loading
from .state import State

Resisting = dict[int, tuple[Scalar, ...]]
"""Forces that the armature of a joint needs along the motions of its link, by link."""


def joint_wrenches(
    model: Model, state: State, udot: Sequence[Scalar] | None, loads: Loading | None
) -> tuple[list[Spatial], Resisting]:
    """Return the wrench F_i on every link from its parent, about the link's origin in its axes, and those of armature.

    ``loads`` None leaves out the loads and gravity; ``udot`` None leaves out the part linear in accelerations.
    """
    F, resisting = _needs(model, state, udot, loads)
    for i in range(len(model.links) - 1, -1, -1):
        link = model.links[i]
        F[i] = state.intermediate("force", i, F[i])
        if link.parent != GROUND:
            R, p, _ = state.joint(i)
            F[link.parent] = plus(F[link.parent], force_to_parent(R, p, F[i]))
    return F, resisting


def _needs(
    model: Model, state: State, udot: Sequence[Scalar] | None, loads: Loading | None
) -> tuple[list[Spatial], Resisting]:
    """Return the wrench that the motion of a link alone needs, (n, f) less the loads, and the forces of armature."""
    V = velocities(model, state)
    ground = (0, 0, 0) if loads is None else negate(state.vector(model.gravity))
    A = accelerations(model, state, udot, ground)
    F: list[Spatial] = []
    for i in range(len(model.links)):
        m, h, J = state.inertia(i)
        (w, _), (alpha, a) = V[i], A[i]
        n = add(add(apply(J, alpha), cross(w, apply(J, w))), cross(h, a))
        force = (n, add(scale(m, a), apply(turning(w, alpha), h)))
        F.append(force if loads is None else minus(force, loads.wrench(i)))
    along: Resisting = {}
    for i, link in enumerate(model.links) if has_armature(model) else ():
        if link.armature:
            along[i] = resistance(state, i, udot, A)
        if link.parent != GROUND:
            F[link.parent] = plus(F[link.parent], (spin_rate(state, i, udot, V), ZERO))
    return F, along


def inverse_dynamics(
    model: Model, state: State, udot: Sequence[Scalar] | None, loads: Loading | None | str = "all"
) -> tuple[Scalar, ...]:
    """Return the generalized forces that the motion needs beyond the model's loads,  M u' + h - Q.

    They are zero along a motion of the model. ``loads`` may select some loads (:func:`loading`); None leaves out all
    loads and gravity.

    Returns
    -------
    tuple, length n_u
        Forces conjugate to the speeds [N, N m].
    """
    acting = loading(model, state, udot=udot) if loads == "all" else loads
    assert not isinstance(acting, str)
    F, resisting = joint_wrenches(model, state, udot, acting)
    tau: list[Scalar] = []
    for i, link in enumerate(model.links):
        along = power(state.subspace(i), F[i]) if link.one_dof else 0
        if link.one_dof and i in resisting:
            along = along + resisting[i][0]
        tau.append(along if acting is None else along - acting.along.get(i, 0))
    total = forces_on_speeds(model, state, tau, F)
    for i, link in enumerate(model.links):
        if link.u >= 0:
            for k, force in enumerate(resisting.get(i, ())):
                total[link.u + k] = total[link.u + k] + force
    if acting is not None:
        for j, force in acting.generalized.items():
            total[j] = total[j] - force
    return tuple(total)


def bias(model: Model, state: State) -> tuple[Scalar, ...]:
    """Return h - Q of the equations of motion M u' + (h - Q) = 0. Length n_u [N, N m]."""
    return inverse_dynamics(model, state, None)


def reactions(
    model: Model, state: State, udot: Sequence[Scalar], *, natural: bool = False, loads: Loading | None = None
) -> dict[str, tuple[Vector, Vector]]:
    """Return (force, moment) of every joint on its child, about the joint's point on the child, in ground axes.

    Loads along the joint (springs, dampers, motors) are not part of the reaction; the force that drives a prescribed
    displacement is.

    Parameters
    ----------
    udot : sequence, length n_u
        If these are not the accelerations of the motion, the forces of :func:`inverse_dynamics` also act in the
        joints.
    natural : bool
        True if ``udot`` is known to be that of the motion. Terms that the equations of motion make zero are then left
        out at once, which gives short formulas: a hinge transmits no moment about its axis.
    loads : Loading, optional
        Loads in place of the model's own, if constraints act too.
    """
    loads = loading(model, state, udot=udot) if loads is None else loads
    F, resisting = _needs(model, state, udot, loads)
    loads = _with_resistance(model, loads, resisting)
    ends = {joint.links[-1]: (name, joint) for name, joint in model.joints.items()}
    result = {}
    for i in range(len(model.links) - 1, -1, -1):
        if i in ends:
            name, joint = ends[i]
            enforced = loads_on_child(model, state, joint, loads.along, free=False)
            n, f = transmissible(model, state, joint, minus(F[i], enforced))
            R = rotation(model, state, i)
            result[name] = (apply(R, f), apply(R, n))
            if natural:
                along = dict(loads.along)
                for j, force in loads.generalized.items():
                    for k, tau in forces_on_free_displacements(model, state, j, force).items():
                        along[k] = along.get(k, 0) + tau
                moved = loads_on_child(model, state, joint, along, free=True)
                moved = plus(moved, on_path(model, state, joint, loads.generalized))
                F[i] = plus((n, f), plus(enforced, minus(moved, _of_ball(model, state, joint, resisting))))
        parent = model.links[i].parent
        if parent != GROUND:
            R, p, _ = state.joint(i)
            F[parent] = plus(F[parent], force_to_parent(R, p, F[i]))
    return {name: result[name] for name in model.joints}


def _with_resistance(model: Model, loads: Loading, resisting: Resisting) -> Loading:
    """Return the loads with those that armature puts on the displacements of joints."""
    along = dict(loads.along)
    for i, forces in resisting.items():
        if model.links[i].one_dof:
            along[i] = along.get(i, 0) - forces[0]
    return replace(loads, along=along)


def _of_ball(model: Model, state: State, joint: JointPlace, resisting: Resisting) -> Spatial:
    """Return the wrench that the armature of a ball or free joint needs, in the axes of the joint's last link."""
    own = next((i for i in joint.links if i in resisting and not model.links[i].one_dof), None)
    return ZERO6 if own is None else on_ball(model, state, joint, own, resisting[own])


def drive_power(model: Model, state: State, udot: Sequence[Scalar], loads: Loading | None = None) -> Scalar:
    """Return the power that the drives of prescribed displacements put in: Σ (Sᵀ F - loads along) ∂y/∂t [W]."""
    driven = [i for i, link in enumerate(model.links) if link.one_dof and link.drift != 0]
    if not driven:
        return 0
    loads = loading(model, state, udot=udot) if loads is None else loads
    F, resisting = joint_wrenches(model, state, udot, loads)
    total: Scalar = 0
    for i in driven:
        force = power(state.subspace(i), F[i]) - loads.along.get(i, 0)
        if i in resisting:
            force = force + resisting[i][0]
        total = total + force * state(model.links[i].drift)
    return total
