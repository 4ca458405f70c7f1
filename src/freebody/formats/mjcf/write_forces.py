"""Writer of what acts on the bodies of an MJCF file: springs, dampers, stops, motors, equalities.

A motor is an affine function of its control, of its coordinate x and of the speed x',

    F = γ f,        f = g u + b_0 + b_1 γ x + b_2 γ x'

in which f and u may be kept within ranges, as Max(low, Min(high, ...)) says it. The control u is the parameter that has
the value 0, or none.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import sympy
from sympy.core.function import AppliedUndef

from ...describe.description import names_of
from ...scalar.algebra import IDENTITY, ZERO, Vector
from ...space.pose import Pose
from ...space.rotation import Rotation
from ..machine import Machine, Motion, text_of
from ..xml_tree import identifier
from .placing import pose_attributes
from .write_contacts import Contacts
from .write_tendons import Pull, pulls

POINTS = "the format has forces along joints only; keep it in Python or in a .toml file"
COUPLE = "the format has torques along joints only; use s.damper for the damping of a ball or free joint"
CANNOT = {
    "screw": "the format has no screw; write the drive as a hinge",
    "path": "the format has no joint by functions",
    **dict.fromkeys(("spring", "damper"), POINTS),
    "torque": COUPLE,
    "SpeedCondition": "the format has no conditions on speeds",
    "Rope": "the format has no ropes that are constraints; keep it in Python or in a .toml file",
    "Rolling": "the format has no rolling without slip; use a contact with friction",
}
"""Why MJCF cannot hold a kind of part; what is named here or in no other place is refused."""
HIGHEST = 4
"""Degree of the polynomial of a joint equality."""
DRAG = {
    "damping": "a force other than the damping -d v of a free joint that has s.damper of the same d; "
    + POINTS,
    "friction": "in the format the friction of a free joint resists turns and displacements up to the same number; "
    "give it torque= in one s.friction and force= in another",
}
LOOP = "its joint closes a loop; act on a joint of the tree"


class Forces:
    """Says the parts of a machine in the sections of a file; ``elements`` has those of the bodies."""

    def __init__(self, machine: Machine, sections: dict[str, Element], elements: dict[str, Element]) -> None:
        self.machine, self.sections, self.elements = machine, sections, elements
        self.contacts = Contacts(machine, sections, elements)
        self.controls: set[Any] = set()
        self.equalities: set[str] = set()  # names
        self.tendons: set[str] = set()
        self.along: list[tuple[Any, Motion, Any]] = []  # forces on coordinates
        self.drags: dict[tuple[str, str], tuple[Motion, dict[str, tuple[Any, Any]]]] = {}
        m = machine
        self.sayings: dict[str, Callable[[Any], None]] = {
            "joint_spring": m.spring, "joint_damper": m.damper, "joint_friction": m.dry_friction, "stop": m.stop,
            "joint_effort": self._effort, "generalized_force": self._coordinate_force, "motor": self._motor,
            "turn_stop": self._turn_stop, "turn_friction": self._turn_friction,
            "shift_friction": self._turn_friction,
            "torsion_spring": self._torsion, "torsion_damper": self._turning, "force": self._sliding,
            "Condition": self._condition, "Gear": self._gear,
            "ContactPair": self.contacts.add,
        }  # fmt: skip

    def add(self) -> None:
        """Add what names bodies and joints: equalities of loops and followers, shapes that touch."""
        m = self.machine
        self.pull()
        for joint in m.system.joints.values():
            if joint.closes:
                self._loop(joint)
        for motion in m.motions.values():
            if motion.follows is not None:
                leader, polynomial = motion.follows
                self._couple(f"{motion.name}_follows", motion, leader, polynomial, motion.title)
        self.contacts.finish()

    # -- springs and damping of ball and free joints --------------------------------------------------

    def damp(self) -> None:
        """Give ball and free joints their damping and dry friction: the same against all their speeds."""
        for (_, word), (motion, parts) in self.drags.items():
            values = {d for _, d in parts.values()}
            if len(values) > 1 or (motion.kind == "free" and len(parts) < 2):
                self.machine.refuse(next(iter(parts.values()))[0].title, DRAG[word])
            setattr(motion, word, values.pop())

    def _drag(self, part: Any, motion: Motion, d: Any, word: str = "damping") -> None:
        """Add to what resists the turns, or the displacements, of a joint."""
        parts = self.drags.setdefault((motion.name, word), (motion, {}))[1]
        parts[part.kind] = part, d + parts.get(part.kind, (part, 0))[1]

    def _ball(self, part: Any) -> Motion | None:
        """Return the ball of the joint on which a part acts."""
        index = next(k for k, motion in enumerate(part.joint.primitives) if motion.quaternion >= 0)
        motion = self.machine.motions.get((part.joint.name, index))
        if motion is None or part.joint.closes:
            self.machine.refuse(part.title, LOOP)
            return None
        return motion

    def _torsion(self, part: Any) -> None:
        """Add a spring along the rotation vector of a ball."""
        m, motion = self.machine, self._ball(part)
        if motion is None:
            return
        if motion.kind == "free":
            m.refuse(part.title, "in the format the spring of a free joint acts along its displacement too")
        elif part.rest != IDENTITY:
            m.refuse(
                part.title, "in the format it rests where the axes of the joint are parallel: turn parent_axes= of "
                f"'{part.joint.name}' in place of rest=",
            )  # fmt: skip
        motion.stiffness += m.number(part.stiffness, part.title)

    def _turn_stop(self, part: Any) -> None:
        """Add a stop of the turn of a ball."""
        m, motion = self.machine, self._ball(part)
        if motion is None:
            return
        if motion.kind == "free":
            m.refuse(part.title, "in the format a free joint has no limits")
        m.without_rebound(part)
        motion.low, motion.high = 0, min(motion.high, m.number(part.high, part.title))

    def _turn_friction(self, part: Any) -> None:
        """Add dry friction about the axes of a ball or free joint, or along those of a free one."""
        motion = self._ball(part)
        if motion is not None:
            self._drag(part, motion, self.machine.bound(part), "friction")

    def _turning(self, part: Any) -> None:
        """Add a damper of the turns of a joint."""
        motion = self._ball(part)
        if motion is not None:
            self._drag(part, motion, self.machine.number(part.damping, part.title))

    def _sliding(self, part: Any) -> None:
        """Take a force -d v at the point of a free joint as the damping of its displacements."""
        for held in self.machine.of.values():
            own = (
                [motion.kind for motion in held.motions] == ["free"]
                and part.frame is part.point.body is held.body
                and part.point.components == held.joint.to
                and held.end.rotation.matrix == IDENTITY
            )
            if own:
                d = self._slope(part, held.joint)
                if d is not None:
                    self._drag(part, held.motions[0], d)
                    return
        self.machine.refuse(part.title, DRAG["damping"])

    def _slope(self, part: Any, joint: Any) -> Any:
        """Return d if a force is -d v, else None."""
        names = names_of(self.machine.system).atoms
        atoms = [names[f"{joint.coordinate or joint.name}_v{x}"] for x in "xyz"]
        pairs = [(sympy.sympify(c), atom) for c, atom in zip(part.components, atoms, strict=True)]
        slopes = {-c.diff(atom) for c, atom in pairs}
        if len(slopes) > 1 or any(sympy.expand(c - c.diff(atom) * atom) != 0 for c, atom in pairs):
            return None
        return self.machine.number(slopes.pop(), part.title)

    # -- motors -------------------------------------------------------------------------------------

    def _effort(self, part: Any) -> None:
        motion = self.machine.motions.get((part.joint.name, 0))
        if motion is None:
            self.machine.refuse(part.title, LOOP)
        else:
            self._joint(part, motion, motion.sign * sympy.sympify(part.value))

    def _coordinate_force(self, part: Any) -> None:
        motion = self.machine.owners.get(part.coordinate)
        if motion is None:
            self.machine.refuse(part.title, "no joint of the file has its coordinate")
        else:
            self.along.append((part, motion, sympy.sympify(part.value)))

    def pull(self) -> None:
        """Add the forces on coordinates: actuators of joints and of fixed tendons."""
        for pull in pulls(self.along, self.machine.system.t):
            target = {"joint": pull.weights[0][0].name}
            if pull.is_tendon:
                weights = [(motion.name, float(c)) for motion, c in pull.weights]
                target = {"tendon": self._tendon(pull.part.name, weights)}
            self._actuator(pull, target)

    def _tendon(self, name: str, weights: list[tuple[str, float]]) -> str:
        """Add a fixed tendon, and return its name."""
        name = identifier(name, self.tendons)
        fixed = SubElement(self.sections["tendon"], "fixed", name=name)
        for joint, c in weights:
            SubElement(fixed, "joint", joint=joint, coef=text_of(c))
        return name

    def _motor(self, part: Any) -> None:
        """Add a motor: n (T_s - d n y'); its rotor is armature n² J where its stator stands in the ground."""
        m = self.machine
        motion = m.motions.get((part.joint.name, 0))
        if motion is None:
            m.refuse(part.title, LOOP)
            return
        J, n = m.number(part.inertia, part.title), m.number(part.ratio, part.title)
        if J and not part.joint.parent.is_ground:
            m.refuse(part.title, "the spin of its rotor; leave out inertia=, and give the joint armature=")
        motion.armature += J * n * n
        y = sympy.sympify(part.joint.primitives[0].coordinate)
        value = part.ratio * (sympy.sympify(part.stall_torque) - part.slope * part.ratio * y.diff(m.system.t))
        self._joint(part, motion, motion.sign * value)

    def _joint(self, part: Any, motion: Motion, value: Any) -> None:
        self._actuator(Pull(part, value, [(motion, sympy.Integer(1))]), {"joint": motion.name})

    def _actuator(self, pull: Pull, target: dict[str, str]) -> None:
        """Add an actuator for a force conjugate to a coordinate, or to the length of a tendon."""
        m, part = self.machine, pull.part
        x, v, u = sympy.symbols("x v u", cls=sympy.Dummy)
        value = pull.along(x, v, m.system.t)
        names = value.free_symbols - {m.system.t, x, v}
        open_ones = sorted((s for s in names if not m.values.get(s)), key=str)
        value = value.subs({s: m.values[s] for s in names if s not in open_ones})
        value = value.subs({s: u for s in open_ones})
        gear, law = value.as_coeff_Mul() if isinstance(value, sympy.Mul) else (sympy.Integer(1), value)
        force_range = control_range = None
        if (inner := between(law)) is not None:
            law, force_range = inner
        else:
            gear, law = sympy.Integer(1), value
        for clamp in law.atoms(sympy.Max):
            if (inner := between(clamp)) is not None and inner[0] == u:
                law, control_range = law.subs(clamp, u), inner[1]
        terms = sympy.Poly(law, u, x, v) if law.is_polynomial(u, x, v) else None
        if len(open_ones) > 1 or terms is None or terms.total_degree() > 1 or terms.free_symbols_in_domain:
            m.refuse(
                part.title, "a motor of the format is an affine function of one control (a parameter of value 0), of "
                f"its coordinate and speed; got {part.value if hasattr(part, 'value') else value}",
            )  # fmt: skip
            return
        if self.controls.intersection(open_ones):
            m.refuse(
                part.title,
                f"it shares its control {open_ones[0]} with another; give each motor one of its own",
            )
        self.controls.update(open_ones)
        g, b = terms.coeff_monomial(u), [terms.coeff_monomial(k) for k in (1, x, v)]
        attributes = {"name": part.name, **target}
        if not any(b) and force_range is None:
            gear, g = gear * g, 1
        if gear != 1:
            attributes["gear"] = text_of(float(gear))
        for key, bounds in (("ctrlrange", control_range), ("forcerange", force_range)):
            if bounds is not None:
                attributes[key] = text_of(*bounds)
        plain = not any(b) and g == 1
        if not plain:
            attributes["gainprm"] = text_of(float(g))
        if any(b):
            attributes |= {
                "biastype": "affine",
                "biasprm": text_of(float(b[0]), *(float(one / gear) for one in b[1:])),
            }
        SubElement(self.sections["actuator"], "motor" if plain else "general", attributes)

    # -- constraints --------------------------------------------------------------------------------

    def _condition(self, part: Any) -> None:
        if part.unilateral:
            self.machine.refuse(repr(part), "it acts to one side only; leave out unilateral=True")
        self._constrain(part, sympy.sympify(part.expression))

    def _gear(self, part: Any) -> None:
        one, two = (sympy.sympify(joint.primitives[0].coordinate) for joint in (part.first, part.second))
        self._constrain(part, one - part.ratio * two)

    def _constrain(self, part: Any, expression: Any) -> None:
        """Add a constraint: two joints by a polynomial of one of them, or a linear function of several joints."""
        m = self.machine
        atoms = sorted(expression.atoms(AppliedUndef), key=str)
        motions: list[Any] = [m.owners.get(atom) for atom in atoms]
        x = sympy.symbols(f"x:{len(atoms)}", cls=sympy.Dummy)
        value = expression.subs(dict(zip(atoms, x, strict=True)))
        value = value.subs({s: m.number(s, repr(part)) for s in value.free_symbols - {*x, m.system.t}})
        if m.system.t in value.free_symbols or None in motions or not value.is_polynomial(*x):
            m.refuse(repr(part), "the format couples joints by polynomials of their coordinates only")
            return
        polynomial = sympy.Poly(value, *x)
        for i, one in enumerate(motions):
            rest = [k for k in range(len(x)) if k != i]
            if len(rest) > 1 or polynomial.degree(x[i]) != 1 or polynomial.coeff_monomial(x[i]) == 0:
                continue
            slope = sympy.Poly(value.diff(x[i]), *x)
            if slope.is_ground:
                y = sympy.Poly(-value.subs(x[i], 0) / slope.as_expr(), x[rest[0]] if rest else sympy.Dummy())
                self._couple(part.name, one, motions[rest[0]] if rest else None, y, repr(part))
                return
        if polynomial.total_degree() > 1:
            m.refuse(
                repr(part),
                "the format couples two joints by a polynomial of one of them, or several linearly",
            )
            return
        weights = [
            (one, float(polynomial.coeff_monomial(atom))) for one, atom in zip(motions, x, strict=True)
        ]
        tendon = self._tendon(part.name, [(one.name, c) for one, c in weights])
        constant = -float(polynomial.coeff_monomial(1)) - sum(c * one.ref for one, c in weights)
        SubElement(
            self.sections["equality"],
            "tendon",
            name=part.name,
            tendon1=tendon,
            polycoef=text_of(constant, 0, 0, 0, 0),
        )

    def _couple(self, name: str, follower: Motion, leader: Motion | None, y: sympy.Poly, title: str) -> None:
        """Add the equality y(x) of two joints; MuJoCo counts both from the pose in which they are drawn."""
        if y.degree() > HIGHEST:
            self.machine.refuse(title, f"a polynomial of degree {y.degree()}; the format has up to {HIGHEST}")
            return
        shifted = sympy.Poly(
            y.as_expr().subs(y.gen, y.gen + (leader.ref if leader else 0)) - follower.ref, y.gen
        )
        terms = [float(shifted.coeff_monomial(y.gen**k)) for k in range(HIGHEST + 1)]
        joints = {"joint1": follower.name} | ({"joint2": leader.name} if leader else {})
        name = identifier(name, self.equalities)
        SubElement(self.sections["equality"], "joint", {"name": name, **joints, "polycoef": text_of(*terms)})

    # -- loops --------------------------------------------------------------------------------------

    def _loop(self, joint: Any) -> None:
        """Close a loop: a ball holds a point, a hinge two points of its axis, a weld a frame."""
        m = self.machine
        kinds = [p.kind for p in joint.primitives]
        ends = []
        for body, axes, point in (
            (joint.parent, joint.parent_axes, joint.at), (joint.child, joint.child_axes, joint.to),
        ):  # fmt: skip
            pose = Pose(Rotation.trusted(m.matrix(axes, joint.title)), m.vector(point, joint.title))
            ends.append((body, m.place(body, pose)))
        if kinds == ["weld"]:
            self._equality("weld", joint.name, ends, ZERO)
        elif kinds == ["ball"]:
            self._equality("connect", joint.name, ends, ZERO)
        elif kinds == ["hinge"]:
            self._equality("connect", joint.name, ends, ZERO)
            self._equality(
                "connect", f"{joint.name}_axis", ends, m.vector(joint.primitives[0].axis, joint.title)
            )
        else:
            m.refuse(
                joint.title, "it closes a loop, which ball joints, hinges and welds can in the format; open the loop "
                "at another joint",
            )  # fmt: skip

    def _equality(self, tag: str, name: str, ends: list[tuple[Any, Pose]], place: Vector) -> None:
        """Hold two sites together, at a place in the axes of each end."""
        names = []
        for number, (body, pose) in enumerate(ends, start=1):
            site = f"{name}_{number}"
            outer = self.sections["worldbody"] if body.is_ground else self.elements[body.name]
            where = pose @ Pose(position=place)
            SubElement(
                outer,
                "site",
                {"name": site, **pose_attributes(where if tag == "weld" else Pose(position=where.position))},
            )
            names.append(site)
        name = identifier(name, self.equalities)
        SubElement(self.sections["equality"], tag, name=name, site1=names[0], site2=names[1])


def between(value: Any) -> tuple[Any, tuple[float, float]] | None:
    """Return what Max(low, Min(high, value)) keeps between two numbers, and these; None if a value is not that.

    >>> u = sympy.Symbol("u")
    >>> between(sympy.Max(-1, sympy.Min(2, 3 * u)))
    (3*u, (-1.0, 2.0))
    """
    ends = []
    for kind in (sympy.Max, sympy.Min):
        if not isinstance(value, kind) or len(value.args) != 2:
            return None
        numbers = [x for x in value.args if x.is_number]
        if len(numbers) != 1:
            return None
        ends.append(float(numbers[0]))
        (value,) = (x for x in value.args if not x.is_number)
    return value, (ends[0], ends[1])
