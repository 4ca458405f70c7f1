"""The machine as the user describes it: the only mutable object of the library.

The methods that make joints, loads, constraints and contacts are functions of the folders of these names.
"""

from __future__ import annotations

import copy
from typing import Any

import sympy

from ..errors import ModelError, arguments_named, shown
from ..rooms_above import module_for
from ..scalar.algebra import Vector
from ..space.mass import MassProperties
from ..space.shape import Shape
from . import controller as _controller
from .body import Body
from .constraints import system_constraints as _constraints
from .constraints.constraint import Constraint
from .constraints.gear import gear as _gear
from .contacts import stop as _stop
from .contacts import system_contacts as _contacts
from .contacts import system_friction as _friction
from .contacts.family import ContactFamily
from .contacts.system_families import ContactTable
from .controller import Controller
from .description import (
    Description,
    Parameter,
    all_or_nothing,
    declare_coordinate,
    take_as_positive,
    varying,
    vector,
)
from .joints.joint import Joint
from .joints.kinds import ball as _ball
from .joints.kinds import chain as _chain
from .joints.kinds import cylindrical as _cylindrical
from .joints.kinds import free as _free
from .joints.kinds import gimbal as _gimbal
from .joints.kinds import hinge as _hinge
from .joints.kinds import path_joint as _path_joint
from .joints.kinds import planar as _planar
from .joints.kinds import screw as _screw
from .joints.kinds import slider as _slider
from .joints.kinds import universal as _universal
from .joints.kinds import weld as _weld
from .loads import belt as _belt
from .loads import bushing as _bushing
from .loads import cable as _cable
from .loads import drag as _drag
from .loads import gravitation as _gravitation
from .loads import motor as _motor
from .loads import system_loads as _loads
from .loads import tyre as _tyre
from .loads.load import Load
from .looks import drawn_as, solid_of
from .names import TIME, check_name, finite
from .part import add


@arguments_named
class System(Description):
    """A machine: parameters, bodies, joints, forces, springs, dampers.

    Any number may be given as int, float, Fraction, SymPy expression, or text over the system's own names.

    ``s.ground`` is the inertial frame. ``s.bodies`` (without the ground), ``s.joints``, ``s.loads``, ``s.constraints``,
    ``s.contacts``, ``s.families`` (of contacts) and ``s.controllers`` are dictionaries of the machine's parts by name.
    ``s.reading`` is the report of the reader of a robot's file (:func:`freebody.read`): what was read, changed and left
    out; None for other machines.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    >>> pin = s.hinge("pin", s.ground, bar, to=(0, L/2, 0), axis="z", coordinate="theta")
    >>> s
    System 'pendulum': 1 body, 1 joint, 1 coordinate
    """

    bodies: dict[str, Body]
    joints: dict[str, Joint]
    loads: dict[str, Load]
    constraints: dict[str, Constraint]
    contacts: ContactTable
    families: dict[str, ContactFamily]
    controllers: dict[str, Controller]

    reading: Any

    def __init__(self, name: str = "system") -> None:
        super().__init__(name)
        self.reading = None
        self.contacts = ContactTable(self)
        self.ground = Body(self, "ground")
        self._gravity: Vector = (0, 0, 0)
        self._scenery: Shape | None = None

    def __copy__(self) -> System:
        """Return an independent copy of the machine."""
        return copy.deepcopy(self)

    # -- symbols --------------------------------------------------------------------------------

    @property
    def t(self) -> sympy.Symbol:
        """Symbol of the time [s]."""
        return TIME

    def parameters(self, names: str = "", /, **defaults: Any) -> Any:
        """Declare parameters; keyword arguments give default values, text names leave them open.

        Parameters
        ----------
        names : str, optional
            Names without default values, separated by spaces.
        **defaults : number or text
            Default values, in any consistent units; text such as ``"75deg"`` is allowed.

        Returns
        -------
        Symbol or tuple of Symbol
            Real SymPy symbols, in the order given.
        """
        _check_text(names, "parameters", "m k")
        values: list[tuple[str, float | None]] = [(name, None) for name in names.replace(",", " ").split()]
        for name, value in defaults.items():
            number = self.expression(value, f"the default of parameter '{name}'")
            if isinstance(number, sympy.Basic) and number.free_symbols:
                raise ModelError(
                    f"The default value of parameter '{name}' must be a number, got '{number}'. "
                    f"Write expressions of parameters where they are used."
                )
            values.append((name, finite(number, f"the default of parameter '{name}'")))
        with all_or_nothing(self):
            symbols = [self._names.parameter(name) for name, _ in values]
        for symbol, (name, default) in zip(symbols, values, strict=True):
            self._parameters[name] = Parameter(name, symbol, default)
        if not symbols:
            raise ModelError("Expected at least one parameter, such as parameters(m=1.0).")
        return symbols[0] if len(symbols) == 1 else tuple(symbols)

    def coordinates(self, names: str) -> Any:
        """Declare coordinates to be used in the expressions of joints, ``"theta1 theta2"``.

        Returns
        -------
        function of time, or tuple of them
            Their time derivatives, ``theta.diff(s.t)`` or the text ``"theta'"``, are the speeds.
        """
        _check_text(names, "coordinates", "theta1 theta2")
        with all_or_nothing(self):
            atoms = [declare_coordinate(self, name) for name in names.replace(",", " ").split()]
        if not atoms:
            raise ModelError("Expected at least one coordinate name, such as coordinates('theta').")
        return atoms[0] if len(atoms) == 1 else tuple(atoms)

    def describe(self, symbol: Any, *, unit: str = "", about: str = "") -> None:
        """Set the unit and the meaning of a parameter or coordinate; reports show them.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("cart")
        >>> F = s.parameters(F=0.0)
        >>> s.describe(F, unit="N", about="force at the free end")
        """
        atom = self.expression(symbol, "describe")
        if atom not in self._names.texts:
            raise ModelError(f"Expected a parameter or a coordinate to describe, got '{atom}'.")
        self._about[self._names.texts[atom]] = (unit, about)

    def assume(self, *conditions: Any) -> None:
        """Declare that expressions are positive, ``s.assume("R > r")`` or ``s.assume(R > r)``; roots then simplify.

        Masses and dimensions of solids are known to be positive by their use.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("bowl")
        >>> R, r = s.parameters("R r")
        >>> s.assume("R > r")
        """
        for condition in conditions:
            if condition is not sympy.true and condition is not True:
                greater, less = (
                    self.expression(side, f"the condition {condition}") for side in _sides(condition)
                )
                difference = sympy.sympify(greater - less)
                if difference.is_positive is False and difference.is_number:
                    raise ModelError(f"Expected a condition that can hold, got {shown(condition)}.")
                take_as_positive(self, difference)

    @property
    def gravity(self) -> tuple[Any, Any, Any]:
        """Acceleration of free fall, components in ground axes [m/s²]."""
        return self._gravity

    @gravity.setter
    def gravity(self, components: Any) -> None:
        acceleration = vector(self, components, "gravity")
        for component in acceleration:
            moving = varying(self, component)
            if moving:
                raise ModelError(
                    f"Gravity must be constant, but it depends on {', '.join(moving)}. "
                    f"Describe a varying field as forces on the bodies."
                )
        self._gravity = acceleration
        self._changes.count += 1

    @property
    def scenery(self) -> Shape | None:
        """Solid fixed in the ground that is only drawn, such as a ledge; nothing touches it. None if there is none."""
        return self._scenery

    @scenery.setter
    def scenery(self, solid: Any) -> None:
        self._scenery = None if solid is None else solid_of(solid, f"the scenery of '{self.name}'")
        self._changes.count += 1

    # -- joints, loads, constraints, contacts ---------------------------------------------------

    hinge = _hinge.hinge
    slider = _slider.slider
    cylindrical = _cylindrical.cylindrical
    screw = _screw.screw
    universal = _universal.universal
    gimbal = _gimbal.gimbal
    planar = _planar.planar
    ball = _ball.ball
    free = _free.free
    weld = _weld.weld
    chain = _chain.chain
    path_joint = _path_joint.path_joint
    add = add
    force = _loads.force
    torque = _loads.torque
    spring = _loads.spring
    damper = _loads.damper
    torsion_spring = _loads.torsion_spring
    generalized_force = _loads.generalized_force
    drag = _drag.drag
    motor = _motor.motor
    gravitation = _gravitation.gravitation
    belt = _belt.belt
    bushing = _bushing.bushing
    cable = _cable.cable
    tyre = _tyre.tyre
    constrain = _constraints.constrain
    constrain_speed = _constraints.constrain_speed
    gear = _gear
    rope = _constraints.rope
    rolling = _constraints.rolling
    contact = _contacts.contact
    stop = _stop.stop
    friction = _friction.friction
    controller = _controller.controller

    # -- bodies ---------------------------------------------------------------------------------

    def body(
        self, name: str, mass_properties: MassProperties, *, shape: Any = None, color: str | None = None
    ) -> Body:
        """Add a body; its origin is the point from which ``mass_properties`` measures the mass centre.

        Parameters
        ----------
        name : str
        mass_properties : MassProperties
            Such as those that :func:`freebody.slender_bar` returns.
        shape : MassProperties, optional
            Solid that is drawn for the body, such as ``fb.box(1, (0.4, 0.2, 0.2))``; its mass does not matter.
            ``"nothing"`` for a frame between two joints that is not drawn.
        color : str, optional
            Colour of the body in drawings, such as ``"#0072B2"``.
        """
        check_name(name, "body")
        if name == "ground" or name in self.bodies:
            raise ModelError(f"There is already a body '{name}' in this system. Choose another name.")
        if not isinstance(mass_properties, MassProperties):
            raise ModelError(
                f"Expected mass properties for body '{name}', such as fb.sphere(m, R) or fb.particle(m), "
                f"got {shown(mass_properties)}."
            )
        mass = drawn_as(mass_properties, shape, color, name)
        entries = [mass.mass, *mass.center, *(entry for row in mass.inertia for entry in row)]
        for entry in entries:
            value = self.expression(entry, f"the mass properties of body '{name}'")
            moving = varying(self, value)
            if moving:
                raise ModelError(
                    f"Body '{name}' is rigid, but its mass properties depend on {', '.join(moving)}. "
                    f"Use parameters; a part that moves is a body of its own."
                )
        take_as_positive(self, *mass.positive)
        body = Body(self, name, mass)
        self.bodies[name] = body
        return body

    def _repr_html_(self) -> str | None:
        """Return the drawing for a notebook; None, so that the text is shown, if the system cannot be assembled yet."""
        from ..errors import FreebodyError

        try:
            return str(module_for("draw").draw(self)._repr_html_())
        except FreebodyError:
            return None

    def __repr__(self) -> str:
        def count(n: int, noun: str) -> str:
            return f"{n} {noun if n == 1 else noun[:-1] + 'ies' if noun == 'body' else noun + 's'}"

        parts: tuple[str, ...] = (
            count(len(self.bodies), "body"),
            count(len(self.joints), "joint"),
            count(sum(kind == "coordinate" for kind in self._names.kinds.values()), "coordinate"),
        )
        if self.contacts:
            parts = (*parts, count(len(self.contacts), "contact"))
        if self.families:
            n = len(self.families)
            parts = (*parts, f"{n} {'family' if n == 1 else 'families'} of contacts")
        return f"System '{self.name}': {', '.join(parts)}"


def _sides(condition: Any) -> tuple[Any, Any]:
    """Return the greater and the lesser side of a condition."""
    if isinstance(condition, sympy.StrictGreaterThan | sympy.StrictLessThan):
        return condition.gts, condition.lts
    if isinstance(condition, str) and sum(map(condition.count, "<>")) == 1 and "=" not in condition:
        first, sign, second = condition.partition(">" if ">" in condition else "<")
        return (first, second) if sign == ">" else (second, first)
    raise ModelError(f"Expected a condition such as k > 0, got {shown(condition)}.")


def _check_text(names: Any, what: str, such_as: str) -> None:
    if not isinstance(names, str):
        raise ModelError(f"Expected names of {what} as text, such as '{such_as}', got {shown(names)}.")
