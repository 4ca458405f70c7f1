"""Equations of a machine whose contacts are in the modes in which its motion starts.

The package of the equations does not compute initial values, and the package of the motion is above it. This file uses
both.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...describe.system import System
from ...errors import FreebodyError, ModelError, arguments_named
from ...model.assemble import assemble
from ...model.contact_modes import in_modes, no_equations_of
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
    """Return the equations of a system: free bodies, motion, reactions, energy, momentum.

    Each result is computed when it is first used. Equations too long for a page, such as those of a long chain, are
    printed recursively: angles from the ground, velocities, accelerations and joint forces get names, body by body.

    Parameters
    ----------
    system : System or Model
    modes : mapping of str to str, optional
        Modes of the contacts, by name: "open", "stick" (round features roll), "slip+" or "slip-" by the sign of the
        slip velocity (in 3-D "slip"). Contacts without an entry are open. The forces of a closed contact are the
        unknowns ``N_name`` and, if it sticks, ``T_name``; if it slips, friction is -μ N along the slip velocity. By
        default, the modes are those in which the motion from ``initial`` starts. A line above the equations then names
        these modes, or says why the initial values do not decide them.
    initial, near, values : mapping, optional
        Initial values that decide the modes, as in :func:`freebody.simulate`.
    form : {"auto", "explicit", "recursive"}
        How the equations of motion are printed: "explicit" in coordinates alone, "recursive" in named quantities, each
        defined by a short formula. With "recursive", ``.motion`` and ``.definitions`` use these quantities too. "auto"
        is "recursive" if the equations have more than 5000 terms.

    Returns
    -------
    Equations

    Raises
    ------
    ModelError
        If :func:`freebody.assemble` refuses the system; for unknown contacts, modes and forms; if initial values are
        given together with modes, or for a machine without contacts.
    TooManyTermsError
        If a requested formula would be too long for memory.

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
        why = "without contacts no start is needed"
        if modes is not None:
            why = "modes= says what the contacts do"
        elif model.families:
            why = no_equations_of(model.families[0])
        raise ModelError(f"Expected no {', '.join(named)} for equations: {why}. Leave it out.")
    return Equations(model_in_modes(model, modes), form)


def assembled(system: System | Model) -> Model:
    """Return the model itself, or the assembled model of a system."""
    return system if isinstance(system, Model) else assemble(system)


def modes_at_start(
    system: System | Model,
    initial: Mapping[Any, Any] | None = None,
    near: Mapping[Any, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
) -> tuple[dict[str, str], str]:
    """Return the modes in which a motion starts and a note on them, or no modes and the reason if undecided."""
    from .starting_modes import starting_modes

    try:
        return starting_modes(system, initial, near, values), STARTS
    except FreebodyError as error:
        return {}, f"the start does not decide the modes, modes= chooses them: {error}"
