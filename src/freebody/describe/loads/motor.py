"""A motor on a joint: a torque that falls with the speed, behind a gear, and the inertia of its rotor.

T_m = T_s - d n y',        f = n T_m                the rotor turns at n y', n: ratio of the gear

A direct-current motor has T_s = k V/R and d = k²/R, from V = R i + k ω and T_m = k i. Its rotor adds the reflected
inertia J n² and the moments of its spin (:mod:`freebody.dynamics.armature`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Expression
from ...scalar.expression import exact
from ..description import Description
from ..joints.joint import Joint
from ..joints.rotor import Rotor, check_single
from ..part import Constant, add
from .action import Action, JointForce
from .displacement import check_displacement
from .load import Load, Look


class Motor(Load, kind="motor"):
    """A motor along a joint; its stator stands in the joint's parent."""

    joint: Joint
    stall_torque: Expression  # T_s [N m]
    slope: Constant = 0  # d, fall of the torque per speed of the rotor [N m s]
    ratio: Constant = 1  # n, turns of the rotor per turn of the joint; on a slider [rad/m]
    inertia: Constant = 0  # J of the rotor [kg m²]

    units = {"stall_torque": "N m", "slope": "N m s", "inertia": "kg m^2"}
    noun = "motor"
    look = Look("motor")

    def check(self) -> None:
        """Refuse a joint without a displacement, or with several."""
        check_displacement(self.joint, 0, self.title)
        check_single(self.title, self.joint.primitives)

    @property
    def rotors(self) -> tuple[tuple[Joint, Rotor], ...]:
        """The rotor, if it has inertia."""
        return () if self.inertia == 0 else ((self.joint, Rotor(self.inertia, self.ratio)),)

    def actions(self, at: Any) -> Iterator[Action]:
        """Yield the torque behind the gear."""
        n = at(self.ratio)
        torque = at(self.stall_torque) - at(self.slope) * n * at.rate(self.joint)
        yield JointForce(self.joint, n * torque)


def motor(
    system: Description,
    name: str,
    joint: Joint,
    *,
    stall_torque: Expression = None,
    no_load_speed: Expression = None,
    electric: Any = None,
    ratio: Expression = 1,
    inertia: Expression = 0,
) -> Load:
    """Add a motor on a joint, behind a gear; its stator stands in the joint's parent, whose mass contains the rotor's.

    Parameters
    ----------
    name : str
    joint : hinge, slider or screw
    stall_torque : expression
        T_s, torque of the standing rotor [N m]; a function of time or of a signal if the motor is switched.
    no_load_speed : expression
        Rate ω_0 at which the torque has fallen to zero [rad/s]; without it the torque is T_s at every speed.
    electric : (V, k, R), in place of these two
        Voltage [V], constant [N m/A] and resistance [ohm] of a direct-current motor: T_s = k V/R, ω_0 = V/k.
    ratio : expression
        n, turns of the rotor per turn of the joint; on a slider, radians per metre.
    inertia : expression
        J of the rotor [kg m²]: n² J along the joint, and the moments of its spin on the parent.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("crane")
    >>> I, T, w, n, J = s.parameters(I=2.0, T=0.5, w=300.0, n=50, J=1e-4)
    >>> arm = s.body("arm", fb.MassProperties(1, (0, 0, 0), [[I, 0, 0], [0, I, 0], [0, 0, I]]))
    >>> pin = s.hinge("pin", s.ground, arm, coordinate="q")
    >>> drive = s.motor("drive", pin, stall_torque=T, no_load_speed=w, ratio=n, inertia=J)
    >>> print(fb.equations(s).text())
    (I + n^2*J)*q'' = -T*n^2*q'/w + T*n
    """
    what = f"motor '{name}'"
    if (electric is None) == (stall_torque is None):
        raise ModelError(
            f"Expected stall_torque= of {what}, with no_load_speed= if the torque falls with the speed, or "
            f"electric=(V, k, R); got {'neither' if electric is None else 'both'}."
        )
    if electric is not None:
        if not isinstance(electric, list | tuple) or len(electric) != 3:
            raise ModelError(
                f"Expected electric=(voltage, constant, resistance) of {what}, got {shown(electric)}."
            )
        V, k, R = (system.expression(x, what) for x in electric)
        return add(system, name, Motor(joint, _quotient(k * V, R), _quotient(k * k, R), ratio, inertia))
    slope: Any = 0
    if no_load_speed is not None:
        slope = _quotient(system.expression(stall_torque, what), system.expression(no_load_speed, what))
    return add(system, name, Motor(joint, stall_torque, slope, ratio, inertia))


def _quotient(a: Any, b: Any) -> Any:
    """Return a/b of expressions, exact."""
    return exact(sympy.sympify(a) / sympy.sympify(b))
