"""A gear: teeth that couple the displacements of two joints, and push at a pitch point.

    y_1 = i y_2,        F_r = |f| tan α

The force f across the teeth follows from the multiplier; :mod:`freebody.describe.contacts.mesh` has the geometry.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy

from ...errors import ModelError, shown
from ...scalar.algebra import Expression, Scalar
from ...scalar.expression import exact
from ..constants import default_value
from ..contacts.backlash import Backlash
from ..contacts.gap import Gap
from ..contacts.mesh import Mesh, mesh_of
from ..description import Description, claim, take_as_positive
from ..joints.joint import Joint
from ..labels import Named
from ..part import add
from .arguments import fixed, store, text_of


@dataclass(frozen=True, repr=False)
class Gear(Named):
    """A gear: displacement of the first joint = ratio times displacement of the second.

    The pressure angle is across the teeth; the helix angle is that of the first body, positive if right-handed.
    """

    name: str
    first: Joint
    second: Joint
    ratio: Scalar
    pressure_angle: Scalar
    helix_angle: Scalar = 0

    @cached_property
    def mesh(self) -> Mesh | str:
        """Where and how the teeth push, or the reason why only the ratio is known."""
        return mesh_of(self.first, self.second, self.ratio, self.helix_angle)


def gear(
    system: Description,
    first: Joint,
    second: Joint,
    ratio: Expression,
    *,
    name: str | None = None,
    pressure_angle: Expression = "pi/9",
    helix_angle: Expression = 0,
    backlash: Expression = None,
    efficiency: Expression = None,
    friction: Expression = None,
    restitution: Expression = 0,
) -> Gear | Gap:
    """Couple two joints by teeth: displacement of the first = ``ratio`` times that of the second.

    Two wheels in outer mesh turn in opposite senses, with ratio -r2/r1; a rack and pinion have the ratio r. The points
    of the joints are the centres of the pitch circles. For wheels with parallel axes on a common body, for bevel
    wheels, whose axes meet, for a worm and other wheels on crossed axes, and for a wheel and a rack, the ratio and the
    axes fix the pitch point: there the teeth push both bodies, and the bearings feel it. Coaxial wheels, screws, and
    wheels on different carriers have no such point: their bearings and teeth cannot be separated. Use :meth:`belt` for
    belts and chains.

    Parameters
    ----------
    first, second : Joint
        Hinges, sliders or screws. In a planetary gear they join wheels and carrier; a fixed wheel is the ground.
    ratio : expression of parameters
    name : str, optional
        Name of the multiplier, the moment [N m] or force [N] on the first joint.
    pressure_angle : expression [rad], optional
        Angle between the force of the teeth and the pitch plane, across the teeth (the *normal* pressure angle): more
        than 0 and less than pi/2. The force that presses the teeth apart is its tangent times the force across the
        teeth, whichever flank bears.
    helix_angle : expression [rad], optional
        Angle between the teeth of the first body and its axis (of bevel wheels, the line on which their cones touch),
        positive for right-handed teeth; more than -pi/2 and less than pi/2. Of a rack and a wheel it is the wheel's.
        On crossed axes it is needed, since it places the pitch point: a worm of radius r and lead l has
        pi/2 - atan(l/(2 pi r)).
    backlash : expression of parameters, optional
        By how much the first joint can move while the second stands [rad] or [m]. The teeth are then a contact of two
        flanks, ``name_forward`` and ``name_back``, with impacts; both are equally far away where the joints fit.
    efficiency : expression of parameters, optional
        Power out over power in, with the first joint as driver; the loss is dry friction. Needs a backlash.
    friction : expression of parameters, optional
        Coefficient of friction of teeth that slide, on crossed axes. Needs a backlash.
    restitution : expression of parameters, optional
        Of teeth with backlash.

    Raises
    ------
    ModelError
        Joints with several displacements or of another system, a ratio of zero, an angle out of range, a helix angle
        where the teeth are not known, losses without backlash.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("gears")
    >>> T, r, R = s.parameters(T=2, r=0.1, R=0.3)
    >>> small, large = s.body("small", fb.disk(1, r)), s.body("large", fb.disk(9, R))
    >>> one = s.hinge("one", s.ground, small, coordinate="p")
    >>> two = s.hinge("two", s.ground, large, at=(r + R, 0, 0), coordinate="q")
    >>> mesh = s.gear(one, two, -R / r, name="mesh", helix_angle="pi/12")
    >>> motor = s.torque("motor", one, T)
    >>> fb.simulate(s, until=1).reactions["one"].force[0].round(6)  # apart, around, and along the axis
    array([ 6.782575, 18.      , -4.823085])
    """
    for joint in (first, second):
        if not isinstance(joint, Joint) or system.joints.get(joint.name) is not joint:
            raise ModelError(f"Expected two joints of this system for a gear, got {shown(joint)}.")
        if len(joint.primitives) != 1 or not joint.primitives[0].displaces:
            raise ModelError(
                f"A gear couples joints with one displacement, but '{joint.name}' is a {joint.type}. "
                f"Use s.constrain on its coordinates."
            )
        if joint.closes:
            raise ModelError(
                f"A gear couples joints that have coordinates, but '{joint.name}' closes a loop. Declare it before the "
                f"joint that is to close the loop."
            )
    if first is second:
        raise ModelError(f"A gear couples two joints, got '{first.name}' twice.")
    name = f"gear_{first.name}_{second.name}" if name is None else name
    claim(system, name, "constraint")
    factor = fixed(system, ratio, f"the ratio of gear '{name}'", "coordinate", "speed", "time")
    if factor == 0:
        still = text_of(system, sympy.sympify(first.primitives[0].coordinate))
        raise ModelError(
            f"The ratio of gear '{name}' is 0: '{first.name}' would stand still and '{second.name}' move "
            f"freely. Give another ratio, or hold '{first.name}' by s.constrain('{still}')."
        )
    if isinstance(factor, sympy.Basic):
        take_as_positive(system, factor**2)
    pressure = _angle(system, pressure_angle, f"the pressure angle of gear '{name}'", 0)
    helix = _angle(system, helix_angle, f"the helix angle of gear '{name}'", -sympy.pi / 2)
    result = Gear(name, first, second, factor, pressure, helix)
    if helix != 0 and isinstance(result.mesh, str):
        raise ModelError(
            f"Gear '{name}' has a helix_angle, but where its teeth push is not known: {result.mesh}. Leave it out, or "
            f"place the joints so that the wheels touch."
        )
    if backlash is None:
        given = {"efficiency": efficiency, "friction": friction, "restitution": restitution}
        for word, value in given.items():
            if value is not None and value != 0:
                raise ModelError(
                    f"Gear '{name}' has {_article(word)} but no backlash: its teeth bear on both flanks at once, and "
                    f"how hard they press on each is not determined. Give backlash= too, such as 0.001."
                )
        return store(system, result)
    loss = _loss(system, result, efficiency, friction)
    play = Backlash(first, second, factor, backlash, pressure, helix, friction=loss, restitution=restitution)
    return add(system, name, play)


def _article(word: str) -> str:
    return f"an {word}" if word[0] in "aeiou" else f"{word}" if word == "friction" else f"a {word}"


def _loss(system: Description, gear: Gear, efficiency: Any, friction: Any) -> Any:
    """Return the coefficient of friction in a gear with backlash."""
    what = f"gear '{gear.name}'"
    slides = not isinstance(gear.mesh, str) and gear.mesh.teeth is not None
    if slides and efficiency is not None:
        raise ModelError(
            f"Expected friction= for {what}, whose teeth slide along each other on crossed axes, got an efficiency, "
            f"which follows from it."
        )
    if not slides and friction is not None:
        raise ModelError(
            f"Expected efficiency= for {what}, whose teeth do not slide at the pitch point, got friction=. Give its "
            f"mean efficiency, such as 0.98."
        )
    if efficiency is None:
        return 0 if friction is None else friction
    value = sympy.sympify(
        fixed(system, efficiency, f"the efficiency of {what}", "coordinate", "speed", "time")
    )
    number = default_value(system, value)
    if number is not None and not 0 < number <= 1:
        raise ModelError(f"Expected an efficiency above 0 and up to 1 for {what}, got {number:g}.")
    return exact(1 / value - 1)


def _angle(system: Description, value: Any, what: str, low: Any) -> Any:
    """Return an angle of teeth below pi/2; refuse numbers out of range, and take others as in it."""
    if value is None:
        raise ModelError(f"Expected an angle for {what}, got None. Leave it out, or name a parameter.")
    angle = sympy.sympify(fixed(system, value, what, "coordinate", "speed", "time"))
    if angle.is_number and not low < angle < sympy.pi / 2:
        raise ModelError(
            f"Expected {what} between {low} and pi/2 rad (90 degrees), got {angle}."
            + (" Teeth have pi/9 (20 degrees) as a rule." if low == 0 else "")
        )
    if angle.free_symbols:
        take_as_positive(system, angle - low, sympy.pi / 2 - angle, sympy.cos(angle))
    return angle
