"""Writer of TOML model files, which `read` reads back as the same system."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import sympy

from ...describe.constraints import constraint as constraints
from ...describe.contacts.contact import ContactPair
from ...describe.description import about_of, coordinates_of, names_of, parameters_of, positive_in
from ...describe.frame import Frame
from ...describe.system import System
from ...errors import FormatError, FreebodyError
from ...scalar.algebra import IDENTITY, ZERO
from ...space import solids
from ...space.mass import MassProperties
from ..text import expression_text
from .contacts import contact_keys, family_keys
from .joints import axis_text, joint_keys
from .loads import load_keys
from .looks import dimensions, looks_keys, shape_text
from .read import SOLIDS, case_from_text
from .value_texts import ValueTexts, block, quoted


def toml_text(
    system: System,
    *,
    initial: Mapping[str, Any] | None = None,
    until: Any = None,
    tolerance: float | None = None,
    near: Mapping[str, Any] | None = None,
) -> str:
    """Return the text of a model file.

    Parameters
    ----------
    system : System
    initial, near : mapping of str to number or expression, optional
    until, tolerance : optional
        Values of the table ``[run]``.

    Raises
    ------
    FormatError
        An expression that has no text in the file's language.
    """
    writer = Writer(system)
    text = writer.document(initial, near, until, tolerance, assumed=())
    # The reader knows that masses and dimensions are positive by their use. Only the other assumptions are written:
    # those that it does not know before the contacts, since they simplify the lengths of sides.
    without_contacts = writer.document(initial, near, until, tolerance, assumed=(), contacts=False)
    implied = positive_in(case_from_text(without_contacts, "the text being written").system)
    assumed = positive_in(system) - implied
    return writer.document(initial, near, until, tolerance, assumed=assumed) if assumed else text


class Writer(ValueTexts):
    """Text of the parts of a system."""

    def __init__(self, system: System) -> None:
        if not isinstance(system, System):
            raise FormatError(f"Expected a System to write, got {system!r}.")
        if system.controllers or names_of(system).signals:
            names = [*system.controllers, *(signal.name for signal in names_of(system).signals)]
            raise FormatError(
                f"A model file cannot hold controllers and signals, but '{system.name}' has {', '.join(names)}. Keep "
                "the description in Python."
            )
        super().__init__(system)

    # --- the document ---

    def document(
        self,
        initial: Any,
        near: Any,
        until: Any,
        tolerance: Any,
        assumed: Iterable[Any],
        contacts: bool = True,
    ) -> str:
        """Return the whole text, with these assumptions."""
        system = self.system
        parts = [block(None, self.head(assumed))]
        parameters = {p.name: "{}" if p.default is None else repr(p.default) for p in parameters_of(system)}
        if parameters:
            parts.append(block(("parameters",), parameters))
        for name, body in system.bodies.items():
            parts.append(block(("bodies", name), self.body(body)))
        self.used: set[Any] = set()  # coordinates of the joints so far
        for name, joint in system.joints.items():
            parts.append(block(("joints", name), joint_keys(self, joint)))
        for name, constraint in system.constraints.items():
            parts.append(block(("constraints", name), self.constraint(constraint)))
        for name, pair in system.contacts.items() if contacts else ():
            shape = getattr(pair, "surface", None)  # a stop has none
            slack = shape is not None and shape.look == "rope"
            keys = self.slack_rope(pair) if slack else contact_keys(self, pair)
            parts.append(block((shape.section if shape is not None else "contacts", name), keys))
        for name, family in system.families.items() if contacts else ():
            parts.append(block(("families", name), family_keys(self, family)))
        for name, load in system.loads.items():
            section, keys = load_keys(self, load)
            parts.append(block((section, name), keys))
        for name, (unit, about) in about_of(system).items():
            keys = {"unit": quoted(unit), "about": quoted(about)}
            parts.append(block(("describe", name), {k: v for k, v in keys.items() if v != '""'}))
        return "\n".join([*parts, *self.run(initial, near, until, tolerance)])

    def head(self, assumed: Iterable[Any]) -> dict[str, str]:
        """Return the keys before the first table."""
        system = self.system
        keys = {"name": quoted(system.name)}
        if any(component != 0 for component in system.gravity):
            keys["gravity"] = self.row(system.gravity)
        if system.scenery is not None and (text := shape_text(self, system.scenery, SOLIDS)) is not None:
            keys["scenery"] = text
        if first := self.declared_first():
            keys["coordinates"] = f"[{', '.join(map(quoted, first))}]"
        conditions = sorted(f"{expression_text(expression, self.texts)} > 0" for expression in assumed)
        if conditions:
            keys["assume"] = f"[{', '.join(map(quoted, conditions))}]"
        return keys

    def run(self, initial: Any, near: Any, until: Any, tolerance: Any) -> list[str]:
        """Return the tables of the run."""
        parts = []
        for section, start in (("initial", initial), ("near", near)):
            if start:
                values = {self.texts.get(name, name): value for name, value in start.items()}
                parts.append(block((section,), {name: self.start(name, x) for name, x in values.items()}))
        run = {}
        if until is not None:
            run["until"] = self.value(self.system.expression(until, "until"))
        if tolerance is not None:
            run["tolerance"] = repr(float(tolerance))
        return [*parts, block(("run",), run)] if run else parts

    def start(self, name: str, value: Any) -> str:
        """Return an initial value; four values for the attitude of a ball or free joint."""
        values = value if isinstance(value, tuple | list) else (value,)
        expressions = [self.system.expression(x, f"the initial value of '{name}'") for x in values]
        return self.row(expressions) if len(expressions) > 1 else self.value(expressions[0])

    def declared_first(self) -> list[str]:
        """Return the coordinates to declare before the joints, so that the reader gets the same order.

        A joint declares its own coordinates when it is read. If that gives another order, or an
        expression with a name that is not known yet, all coordinates are declared first.
        """
        kinds = names_of(self.system).kinds
        order = [text for text, kind in kinds.items() if kind == "coordinate"]
        return [] if self.order_after([]) == order else list(coordinates_of(self.system))

    def order_after(self, first: list[str]) -> list[str] | None:
        """Return the order of the coordinates if ``first`` are declared first; None if a joint uses an unknown one."""
        names = names_of(self.system)
        order: dict[str, Any] = dict.fromkeys(first)
        for joint in self.system.joints.values():
            # a joint by functions declares its coordinates first
            for text in joint.coordinate.split() if joint.pair.path else ():
                order.setdefault(text)
            for primitive in () if joint.closes else joint.primitives:
                y = primitive.coordinate
                for atom in y if isinstance(y, tuple) else (y,):
                    text = names.texts.get(atom) if isinstance(atom, sympy.Basic) else None
                    if text is not None:
                        order.setdefault(text)
                    elif any(name not in order for name in names.depends(atom, "coordinate")):
                        return None
        return list(order)

    # --- bodies ---

    def body(self, body: Frame) -> dict[str, str]:
        """Return the keys of a body."""
        mass = body.mass_properties
        assert mass is not None
        shape = mass.shape
        bare = mass if shape is None or not shape.color else replace(mass, shape=replace(shape, color=""))
        solid = self.solid(bare)
        if solid is not None:
            return solid | looks_keys(self, shape, SOLIDS, True)
        keys = {"mass": self.value(mass.mass)}
        if tuple(mass.center) != ZERO:
            keys["center"] = self.row(mass.center)
        if any(entry != 0 for row in mass.inertia for entry in row):
            keys["inertia"] = self.matrix(mass.inertia)
        keys |= looks_keys(self, shape, SOLIDS, False)
        return keys

    def solid(self, mass: MassProperties) -> dict[str, str] | None:
        """Return the keys of a named solid, or None if no solid of this shape has exactly these mass properties."""
        shape = mass.shape
        if shape is None or shape.kind not in SOLIDS or shape.axes != IDENTITY:
            return None
        make = getattr(solids, shape.kind)
        arguments = {"m": mass.mass, **dimensions(shape, make)}
        try:
            unmoved = make(**arguments)
            place = tuple(a - b for a, b in zip(mass.center, unmoved.center, strict=True))
            again = unmoved.moved(place)
        except (FreebodyError, TypeError):
            return None
        same = (mass.mass, mass.center, mass.inertia, shape) == (
            again.mass,
            again.center,
            again.inertia,
            again.shape,
        )
        if not same:
            return None
        keys = {"solid": quoted(shape.kind)}
        for name, value in arguments.items():
            keys["mass" if name == "m" else name] = self.argument(value)
        if any(component != 0 for component in place):
            keys["at"] = self.row(place)
        return keys

    # --- constraints ---

    def constraint(self, constraint: constraints.Constraint) -> dict[str, str]:
        """Return the keys of a constraint."""
        match constraint:
            case constraints.Condition():
                keys = {"type": quoted("condition"), "expression": self.value(constraint.expression)}
                return keys | ({"unilateral": "true"} if constraint.unilateral else {})
            case constraints.SpeedCondition():
                return {"type": quoted("speed"), "expression": self.value(constraint.expression)}
            case constraints.Gear():
                keys = {"first": quoted(constraint.first.name), "second": quoted(constraint.second.name)}
                keys["pressure_angle"] = self.value(constraint.pressure_angle)
                if constraint.helix_angle != 0:
                    keys["helix_angle"] = self.value(constraint.helix_angle)
                return {"type": quoted("gear"), **keys, "ratio": self.value(constraint.ratio)}
            case constraints.Rope():
                points = f"[{', '.join(map(self.point, constraint.points))}]"
                keys = {"type": quoted("rope"), "points": points, "length": self.value(constraint.length)}
                return keys | ({} if constraint.unilateral else {"unilateral": "false"})
            case constraints.Rolling():
                keys = {"wheel": self.point(constraint.center), "radius": self.value(constraint.radius)}
                if constraint.written_axis is not None:
                    keys["axis"] = axis_text(self, constraint.written_axis)
                letter, up = constraint.normal
                keys["normal"] = quoted(letter if sum(up) > 0 else f"-{letter}")
                if constraint.plane.components != ZERO:
                    keys["plane"] = self.point(constraint.plane)
                if not constraint.unilateral:
                    keys["unilateral"] = "false"
                if constraint.friction is not None:
                    keys["friction"] = self.value(constraint.friction)
                return {"type": quoted("rolling"), **keys}
        raise AssertionError(f"no keys for {constraint!r}")

    def slack_rope(self, pair: ContactPair) -> dict[str, str]:
        """Return the keys of a rope that may go slack, which the system holds as a contact."""
        rope = pair.surface
        points = f"[{self.point(rope.body.point(*rope.at))}, {self.point(pair.feature)}]"
        keys = {"type": quoted("rope"), "points": points, "length": self.value(rope.radius), "taut": "false"}
        return keys | ({"restitution": self.value(pair.restitution)} if pair.restitution != 0 else {})
