"""The equations of a machine, with contacts in the modes in which its motion starts.

The room of the equations knows no start, and the room of the motion stands above it: here both are asked.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...describe.system import System
from ...errors import FreebodyError, ModelError, arguments_named
from ...model.assemble import assemble
from ...model.contact import in_modes
from ...model.model import Model
from ...symbolic.derivation.contact_modes import model_in_modes
from ...symbolic.equations import Equations

STARTS = "the modes in which the motion starts; modes= chooses others"


@arguments_named
def equations(
    system: System | Model,
    *,
    modes: Mapping[str, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
    form: str = "auto",
) -> Equations:
    """The equations of a system: free bodies, motion, reactions, energy, momentum.

    Nothing is computed before it is asked for. Equations that fit no page, such as those of a long chain, are printed
    recursively: angles from the ground, velocities, accelerations and the forces in the joints get names, body by body.

    Parameters
    ----------
    system : System or Model
    modes : mapping of str to str, optional
        What the contacts do, by name: "open", "stick" (round features roll), "slip+" or "slip-" by the sign of the slip
        velocity (in 3-D "slip"). Those not named are open. The forces of a closed contact are the unknowns ``N_name``
        and, where it sticks, ``T_name``; where it slips, friction is -μ N along the slip velocity. If not given, those
        in which the motion from ``initial`` starts, and a line above the equations names them, or says why the start
        does not decide them.
    initial, near, values : mapping, optional
        The start, by which the modes are found, as of :func:`freebody.simulate`.
    form : {"auto", "explicit", "recursive"}
        How the equations of motion are printed: in coordinates alone, or in named quantities, each defined by a short
        formula; then ``.motion`` and ``.definitions`` are in these too. "auto" names them where the equations have more
        than 5000 terms.

    Returns
    -------
    Equations

    Raises
    ------
    ModelError
        What :func:`freebody.assemble` refuses; unknown contacts, modes and forms; a start beside modes, or without
        contacts.
    TooManyTermsError
        On a formula that is asked for and would be too long for memory.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1, L=1, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(m))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    >>> print(fb.equations(s).text())
    m*L^2*theta'' + m*L*g*sin(theta) = 0
    >>> print(fb.equations(s, form="recursive").text())
    Forces and moments that the joints pass on, springs and motors along them included, inward:
      pin_Mz = m*L^2*theta'' + m*L*g*sin(theta)
    Equations of motion:
      pin_Mz = 0
    """
    model = assembled(system)
    if modes is None and model.contacts:
        found, why = modes_at_start(system, initial, near, values)
        return Equations(in_modes(model, found), form, why)
    given = (("initial", initial), ("near", near), ("values", values))
    if named := [f"{name}=" for name, value in given if value is not None]:
        why = (
            "modes= says what the contacts do" if modes is not None else "without contacts no start is needed"
        )
        raise ModelError(f"Expected no {', '.join(named)} for equations: {why}. Leave it out.")
    return Equations(model_in_modes(model, modes), form)


def assembled(system: System | Model) -> Model:
    """The model, or that of a system."""
    return system if isinstance(system, Model) else assemble(system)


def modes_at_start(
    system: System | Model,
    initial: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
) -> tuple[dict[str, str], str]:
    """The modes in which a motion starts, and the words that say so; none, and why, where the start does not decide."""
    from .starting_modes import starting_modes

    try:
        return starting_modes(system, initial, near, values), STARTS
    except FreebodyError as error:
        return {}, f"the start does not decide the modes, modes= chooses them: {error}"
