"""Why a machine has no motion in time steps, or a step fails, in the user's terms."""

from __future__ import annotations

from collections.abc import Mapping

from ...dynamics.conditions.mobility import massless_motion
from ...dynamics.state import float_state
from ...errors import SimulationError
from ...model import Model
from ...model.family import contact_laws
from ..cones.contacts import ACCEPTED
from ..contact.motion import check_coefficients
from ..families.memory import label_of
from ..kernels.kernels import Kernels
from ..moreau.stepping_record import (
    CONSTRAINTS,
    CONTACTS,
    JAMMED,
    LOADS,
    MASS,
    NO_FRICTION,
    OVERLAP,
    SLIPS,
    Run,
)
from ..ode.dense_output import Array
from ..start.initial import number
from ..start.loaded_joints import jammed

MOST_SWEEPS = 100_000
"""Sweeps after which the search for the impulses of a step ends."""


MOST_ACCEPTED = 1e-8
"""Limit on the residual with which a step is taken: the root of the round-off, at which a double zero ends."""


def accept(run: Run) -> None:
    """Set the limits of the residual with which a problem of velocities is taken whose search would be long.

    A contact closes by residual · v · h in the step: by no more than the correction leaves, 1e-10 m.
    """
    run.accepted, run.most_accepted = ACCEPTED, MOST_ACCEPTED


def failure(run: Run, model: Model, values: Mapping[str, float], t: float, y: Array) -> str:
    """Return why the step at t from y fails."""
    where = f"the step of '{model.name}' at t = {t:.9g} s"
    if run.failure == CONTACTS:
        return (
            f"The contacts of '{model.name}' were not solved in the step at t = {t:.9g} s: after {MOST_SWEEPS} sweeps "
            f"and Newton's method a law is still missed by {run.problem.residual:.3g} of the greatest speed (required: "
            f"{run.enough:.2g}). Where friction jams a contact (Painlevé) or restitution works against it, there "
            "may be no solution: less friction or restitution=0 has one. Otherwise take a shorter step, or masses that "
            "differ less: they need fewer sweeps."
        )
    if run.failure == MASS:
        q, u = y[: model.n_q].tolist(), y[model.n_q :].tolist()
        idle = massless_motion(model, float_state(model, q, u, t, values))
        names = f" {' and '.join(map(repr, idle))} together move no mass." if idle else ""
        return (
            f"Expected a mass matrix that is positive definite in {where}.{names} Give every body that can move by "
            "itself a mass and moments of inertia, or fix each part that moves no mass by a joint."
        )
    if run.failure == CONSTRAINTS:
        return (
            f"The constraints of '{model.name}' depend on each other in {where}: this happens when bars come into "
            "line. Stop the motion earlier with a terminal event, or change the lengths."
        )
    if run.failure == OVERLAP:
        return (
            f"The overlap of bodies could not be removed in {where}: {run.overlap:.3g} m remain (required: 1e-10 m). "
            "The cause may be bodies wedged in too narrow a space or driven into each other. Otherwise take a shorter "
            "step."
        )
    if run.failure == JAMMED:
        return str(jammed(model, t))
    if run.failure == NO_FRICTION:
        return (
            f"The friction of contact '{_law_of(run, model, run.friction.blame)}' is below 0 or has no value in "
            f"{where}. Write a law that stays above 0 wherever the contact is closed."
        )
    if run.failure == SLIPS:
        return (
            f"No coefficients of friction were found that agree with the slips in {where}: the law of contact "
            f"'{_law_of(run, model, run.friction.blame)}' is missed by {run.friction.residual:.3g} of the greatest "
            f"speed (required: {run.enough:.2g}). A shorter step helps where friction changes much with the slip; "
            "method='auto' follows it from event to event."
        )
    if run.failure == LOADS:
        return (
            f"No mean speeds agree with the loads that depend on them in {where}. This happens where bodies turn "
            "several times in a step, or where a load jumps with a speed. Take a shorter step."
        )
    return (
        f"A rate or a speed is not a finite number in {where}. A division by zero, or a root or logarithm of a "
        "negative number causes this: check the loads there, or take a shorter step."
    )


def _law_of(run: Run, model: Model, a: int) -> str:
    """Return the name of the contact whose normal is row ``a`` of the problem."""
    e, pairs = int(run.contacts.owner[a]), run.families.pairs
    if a < run.contacts.closed:
        return model.contacts[e].name
    slot = pairs.slots[e]
    return label_of(model, int(pairs.first[slot]), int(pairs.second[slot]))


def laws_of_rebounds(model: Model, values: Mapping[str, float]) -> dict[str, str]:
    """Return the laws of impact of contacts that rebound, each with the name of such a contact."""
    laws = contact_laws(model)
    return {c.impact: c.name for c in laws if number(model, values, c.restitution, "restitution") != 0}


def check_laws(kernels: Kernels, values: Mapping[str, float]) -> None:
    """Refuse laws of contacts that the steps do not know."""
    model = kernels.model
    check_coefficients(model, values)
    kinds = laws_of_rebounds(model, values)
    if len(kinds) > 1:
        newton, poisson = kinds["newton"], kinds["poisson"]
        raise SimulationError(
            f"Contact '{newton}' rebounds by Newton's and contact '{poisson}' by Poisson's law: in time steps they may "
            "collide at once. Give all the same law: impact='newton' or 'poisson'."
        )
    loaded = [c.name for c in model.contacts if c.loaded]
    if "poisson" in kinds and loaded:
        raise SimulationError(
            f"Contact '{kinds['poisson']}' rebounds by Poisson's law, and the load of its joint bounds the friction of "
            f"'{loaded[0]}': an impact in time steps has one load. Take impact='newton', or method='auto'."
        )
