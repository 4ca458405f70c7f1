"""Elementary gyroscopic effects: wheels of a motorcycle, rotors of an aircraft, and a blow on a spinning body.

A rotor with the spin angular momentum h that is turned at Omega needs the moment Omega × h, and exerts the
opposite moment.

All functions accept numbers or SymPy expressions. Sources: chapter, Problems 6.17 to 6.19 and 6.21, derived here
by hand.
"""

from __future__ import annotations

from typing import Any

from .elementary import arctan


def wheel_torque(I: Any, r: Any, v: Any, R: Any) -> Any:  # noqa: E741
    """Torque that turns two upright wheels with a curve: 2 I (v/r)(v/R) [N m]."""
    return 2 * I * v**2 / (r * R)


def curve_lean(m: Any, h: Any, v: Any, R: Any, g: Any, I: Any = 0, r: Any = 1) -> Any:  # noqa: E741
    """Lean of a motorcycle in a curve, from the vertical [rad]; without ``I`` the lean of a particle.

    Moments about C along the direction of travel: m g h sin - (m v²/R) h cos = 2 I (v/r)(v/R) cos.
    """
    return arctan(v**2 / (R * g) * (1 + 2 * I / (m * r * h)))


def pitching_moment(I_p: Any, w_p: Any, I_e: Any, w_e: Any, v: Any, R: Any) -> Any:
    """Moment on an airframe in a right turn, positive nose up.

    The propeller turns clockwise as the pilot sees it, the engine the other way. The spin h = I_p w_p - I_e w_e points
    forwards. The turn -v/R about the vertical swings its tip to the right. This needs a moment on the rotors to the
    right, nose up, and the rotors press the airframe's nose down.
    """
    return -(v / R) * (I_p * w_p - I_e * w_e)


def transverse_spin(J: Any, arm: Any, I_1: Any) -> Any:
    """Angular velocity after an impulse J, about the axis normal to impulse and arm: J arm / I_1 [rad/s]."""
    return J * arm / I_1
