"""The ways from a request to its answer.

    batch           many motions, in the compiled loop over lanes or one by one   `studies.batch`
    cluster         the same, in blocks that ``executor=`` runs elsewhere         `studies.batch`
    sensitivities   one motion and its derivatives                                `legs.sensitivity`
                    the same with contacts, signals, controllers or blows         `contact.derivatives.sensitivity`
    steps           equal steps of Moreau and Jean                                `timestepping`
    contacts        phases between the events of contacts                         `contact.motion`
    legs            between blows, and between changes of signals and controllers `legs.several_legs`
    one motion      a run without interruption                                    `legs.one_leg`

Every way is a function of a `Request`. The first two give a dataset, the others a trajectory.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..rooms_above import module_for
from .legs.one_leg import motion_in_one_leg
from .legs.several_legs import motion_in_legs
from .request import Request


def route(request: Request) -> Callable[[Request], Any]:
    """Return the way that answers a request. What a way needs is imported when it is first taken."""
    if request.many:
        return module_for("batch").batch
    return route_of_one(request)


def route_of_one(request: Request) -> Callable[[Request], Any]:
    """Return the way that answers a request for one motion."""
    model = request.kernels.model
    if request.sensitivities is not None and request.in_phases:
        from .contact.derivatives.sensitivity import sensitive_touching_motion

        return sensitive_touching_motion
    if request.sensitivities is not None:
        from .legs.sensitivity import sensitive_motion

        return sensitive_motion
    if request.method == "timestepping":
        from .timestepping.timestepping import stepped_motion

        return stepped_motion
    if model.contacts:
        from .contact.motion import touching_motion

        return touching_motion
    if request.struck or model.switched:
        return motion_in_legs
    return motion_in_one_leg
