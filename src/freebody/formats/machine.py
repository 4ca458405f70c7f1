"""A machine in numbers, as the formats of robots say it: joints of one motion each, with what acts along them.

A joint of the file has a coordinate x of its own and moves by d = x - ref. The displacement y of a motion of the system
is d itself if y = ±q + b: with the sign σ on the axis, d = σ y, x = q and ref = -σ b. A displacement that is another
function of the coordinate of another joint follows that joint.

What the file cannot hold is collected by :meth:`Machine.refuse`, and refused at the end, each part by its name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy
from sympy.core.function import AppliedUndef

from ..describe.constants import is_number
from ..describe.description import names_of, parameters_of
from ..describe.names import finite
from ..describe.system import System
from ..errors import FormatError, nearest, shown
from ..scalar.algebra import IDENTITY, ZERO, Matrix, Vector
from ..space.mass import MassProperties
from ..space.pose import Pose
from ..space.rotation import Rotation
from .builder import normal, placed, whole
from .xml_tree import identifier

SOLIDS = {
    "box": ("x", "y", "z"),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "ellipsoid": ("a", "b", "c"),
}
"""Solids that are drawn, and their dimensions."""
GROUND = "ground"


@dataclass
class Motion:
    """One motion of a joint, which is a joint of the file; ``anchor`` is in joint axes, from the joint's point.

    ``sign`` and ``ref`` are those of its coordinate. ``follows`` has the motion whose coordinate x it follows, and the
    polynomial y(x).
    """

    name: str
    kind: str
    title: str
    axis: Vector
    anchor: Vector
    atom: Any = None
    sign: int = 1
    ref: float = 0
    follows: tuple[Motion, sympy.Poly] | None = None
    armature: float = 0
    stiffness: float = 0
    rest: float = 0
    damping: float = 0
    friction: float = 0
    low: float = -math.inf
    high: float = math.inf

    @property
    def limits(self) -> tuple[float, float] | None:
        """Limits of the coordinate, if it has any."""
        return None if math.isinf(self.low) and math.isinf(self.high) else (self.low, self.high)


@dataclass
class Held:
    """A body with the joint that holds it. ``frame`` is the pose of the file's frame in the body's axes."""

    body: Any
    joint: Any
    motions: list[Motion]
    start: Pose
    end: Pose
    frame: Pose = Pose()
    below: list[Held] = field(default_factory=list)


class Machine:
    """The numbers of a system, for a format with the names of what it holds.

    ``cannot`` has, by the kind of a load, joint, contact or constraint, why the format cannot hold it.
    """

    def __init__(
        self, system: System, values: Mapping[Any, Any] | None, article: str, cannot: Mapping[str, str]
    ):
        if not isinstance(system, System):
            raise FormatError(f"Expected a System to write, got {system!r}.")
        self.system, self.article, self.cannot = system, article, cannot
        self.refused: dict[str, str] = {}
        self.values = self._values(dict(values or {}))
        self.link_names, self.joint_names = {GROUND, "world", *system.bodies}, set()  # type: set[str], set[str]
        self.motions: dict[tuple[str, int], Motion] = {}
        self.held = self._tree()
        for part in (*system.controllers, *(signal.name for signal in names_of(system).signals)):
            self.refuse(f"'{part}'", "controllers and signals stay in Python")
        for family in system.families.values():
            self.refuse(f"{family!r}", "families of contacts stay in Python and in .toml files")

    # -- refusals -----------------------------------------------------------------------------------

    def refuse(self, part: str, why: str) -> None:
        """Note a part that the file cannot hold, and why, with the cure."""
        self.refused.setdefault(part, why)

    def finish(self) -> None:
        """Raise FormatError if there is something that the file cannot hold."""
        if self.refused:
            by_reason: dict[str, list[str]] = {}
            for part, why in self.refused.items():
                by_reason.setdefault(why, []).append(part)
            parts = "; ".join(f"{', '.join(these)}: {why}" for why, these in by_reason.items())
            raise FormatError(
                f"{self.article} cannot hold all of '{self.system.name}'. {parts}. A .toml file can."
            )

    # -- numbers ------------------------------------------------------------------------------------

    def _values(self, given: dict[Any, Any]) -> dict[Any, Any]:
        """Return the values of the parameters."""
        known = {p.name: p for p in parameters_of(self.system)}
        result = {p.symbol: p.default for p in known.values()}
        for key, value in given.items():
            name = str(key)
            if name not in known:
                raise FormatError(f"Unknown parameter '{name}' in values=; {nearest(name, known)}")
            number = self.system.expression(value, f"the value of '{name}'")
            if not is_number(number):
                raise FormatError(f"Expected a number for '{name}' in values=, got {shown(value)}.")
            result[known[name].symbol] = finite(number, f"the value of '{name}'")
        return result

    def number(self, expression: Any, what: str) -> Any:
        """Return the value of a constant; without one it is refused."""
        symbols = getattr(expression, "free_symbols", ())
        for symbol in symbols:
            if self.values.get(symbol) is None:
                self.refuse(
                    what,
                    f"'{symbol}' has no value; give it one, values={{'{symbol}': ...}} or s.parameters({symbol}=...)",
                )
                return 1
        if symbols:
            expression = expression.subs({symbol: self.values[symbol] for symbol in symbols})
        return whole(float(expression))

    def vector(self, components: Any, what: str) -> Vector:
        """Return three numbers."""
        x, y, z = (self.number(component, what) for component in components)
        return (x, y, z)

    def matrix(self, rows: Any, what: str) -> Matrix:
        """Return nine numbers."""
        x, y, z = (self.vector(row, what) for row in rows)
        return (x, y, z)

    def properties(self, held: Held) -> MassProperties:
        """Return the mass properties of a body in the file's axes."""
        own, what = held.body.mass_properties, f"the mass properties of body '{held.body.name}'"
        inertia = self.matrix(own.inertia, what)
        given = MassProperties.as_given(
            self.number(own.mass, what), self.vector(own.center, what), inertia, possible=False
        )
        return self.framed(given, held)

    def framed(self, thing: Any, held: Held) -> Any:
        """Return a shape or mass properties of a body in the file's axes."""
        return (
            thing
            if held.frame.position == ZERO and held.frame.rotation.matrix == IDENTITY
            else placed(thing, held.frame.inverse)
        )

    def place(self, body: Any, pose: Pose) -> Pose:
        """Return a pose in a body as one in the file's axes."""
        return pose if body.is_ground else self.of[body.name].frame.inverse @ pose

    def solids(self, shape: Any, what: str) -> list[tuple[str, tuple[float, ...], Pose, str]]:
        """Return kind, dimensions, pose and colour of the solids by which a shape is drawn; others are not."""
        parts = () if shape is None else shape.parts if shape.kind == "compound" else (shape,)
        result = []
        for part in parts:
            if part.kind not in SOLIDS or part.hole:
                continue
            sizes = tuple(float(self.number(part[name], what)) for name in SOLIDS[part.kind])
            R = self.matrix(part.axes, what)
            pose = Pose(Rotation.trusted(R), self.vector(part.center, what))
            axis = self.vector(part.axis, what)
            if part.kind == "cylinder" and axis != (0, 0, 1):
                length = math.hypot(*axis)
                x, y, z = (whole(a / length) for a in axis)
                pose = pose @ Pose(Rotation.trusted(normal((x, y, z))))
            result.append((part.kind, sizes, pose, part.color or shape.color))
        return result

    # -- joints -------------------------------------------------------------------------------------

    def _tree(self) -> list[Held]:
        """Return the bodies that the ground holds, with those that they hold."""
        roots: list[Held] = []
        self.of: dict[str, Held] = {}
        for joint in self.system.joints.values():
            if not joint.closes:
                held = self._joint(joint)
                self.of[joint.child.name] = held
        for held in self.of.values():
            parent = held.joint.parent
            (roots if parent.is_ground or parent.name not in self.of else self.of[parent.name].below).append(
                held
            )
        for name in self.system.bodies:
            if name not in self.of:
                self.refuse(f"body '{name}'", "no joint holds it; s.free lets it move freely")
        self._coordinates()
        return roots

    def _joint(self, joint: Any) -> Held:
        what = f"{joint.title} of '{joint.child.name}'" if not joint.name else joint.title
        poses = []
        for axes, point in ((joint.parent_axes, joint.at), (joint.child_axes, joint.to)):
            poses.append(Pose(Rotation.trusted(self.matrix(axes, what)), self.vector(point, what)))
        kinds = [p.kind for p in joint.primitives]
        known = "path" if joint.pair.path else next((kind for kind in kinds if self.cannot.get(kind)), "")
        if known:
            self.refuse(what, self.cannot[known])
        motions = []
        for index, p in enumerate(joint.primitives):
            if not (p.displaces or p.n_speeds):
                continue
            single = len(joint.primitives) == 1
            if single:
                text = joint.name
            elif p.displaces:
                text = self._coordinate_text(p.coordinate)
            else:
                text = names_of(self.system).texts[p.coordinate[0]].removesuffix(f"_{p.endings[0]}")
            name = identifier(text or f"{joint.name}_{index + 1}", self.joint_names)
            axis = self.vector(p.axis, what) if p.displaces else (0, 0, 1)
            anchor = ZERO if p.at is None else self.vector(p.at, what)
            motion = Motion(name, p.kind, what, axis, anchor)
            self._inertia(motion, p, joint, what)
            motions.append(motion)
            self.motions[joint.name, index] = motion
        return Held(joint.child, joint, motions, poses[0], poses[1])

    def _coordinate_text(self, y: Any) -> str | None:
        """Return the name of the coordinate q of a displacement ±q + b."""
        atoms = sympy.sympify(y).atoms(AppliedUndef)
        if len(atoms) != 1 or sympy.diff(y, *atoms) not in (1, -1):
            return None
        return names_of(self.system).texts.get(*atoms)

    def _inertia(self, motion: Motion, p: Any, joint: Any, what: str) -> None:
        """Read the armature and the rotor of a motion."""
        numbers = {self.number(x, what) for x in p.armature} or {0}
        if p.rotor is not None:
            J, G = self.number(p.rotor.inertia, what), self.number(p.rotor.ratio, what)
            # in the ground the spin of the rotor has no moment: it is armature J G²
            if not joint.parent.is_ground:
                self.refuse(what, "the spin of its rotor; armature= is its inertia along the joint alone")
            numbers = {x + J * G * G for x in numbers}
        if len(numbers) > 1:
            self.refuse(what, "armature of several values; give it one number")
        motion.armature = numbers.pop()
        if motion.armature and self.cannot.get("armature"):
            self.refuse(what, self.cannot["armature"])

    def _coordinates(self) -> None:
        """Give each motion its coordinate, or the one that it follows."""
        pairs = [
            (self.motions[name, i], p.coordinate) for name, joint in self.system.joints.items() if not joint.closes
            for i, p in enumerate(joint.primitives) if p.displaces and (name, i) in self.motions
        ]  # fmt: skip
        owners: dict[Any, Motion] = {}
        later = []
        for motion, y in pairs:
            atom, polynomial = self._function(y)
            if atom is None or polynomial is None:
                self.refuse(
                    motion.title,
                    f"its displacement {y} is no function of one coordinate; give the joint its own",
                )
            elif polynomial.degree() == 1 and abs(polynomial.LC()) == 1 and atom not in owners:
                slope, offset = polynomial.all_coeffs()
                motion.atom, motion.sign = atom, int(slope)
                motion.axis = tuple(motion.sign * x for x in motion.axis)
                motion.ref = whole(float(-slope * offset))
                owners[atom] = motion
            else:
                later.append((motion, atom, polynomial, y))
        for motion, atom, polynomial, y in later:
            if atom not in owners:
                self.refuse(
                    motion.title,
                    f"its displacement is {y}, but no joint has {atom.func} itself; give one the coordinate "
                    f"{atom.func}",
                )
            else:
                motion.follows = owners[atom], polynomial
        self.owners = owners

    def _function(self, y: Any) -> tuple[Any, sympy.Poly | None]:
        """Return the coordinate that a displacement is a polynomial of, and the polynomial with numbers."""
        y, x = sympy.sympify(y), sympy.Dummy()
        atoms = y.atoms(AppliedUndef)
        value = y.subs({atom: x for atom in atoms})
        if len(atoms) != 1 or self.system.t in value.free_symbols:
            return None, None
        value = value.subs({s: self.number(s, f"the displacement {y}") for s in value.free_symbols - {x}})
        return atoms.pop(), sympy.Poly(value, x) if value.is_polynomial(x) else None

    # -- what acts along joints ---------------------------------------------------------------------

    def acts(self, sayings: Mapping[str, Callable[[Any], None]]) -> None:
        """Say the loads, contacts and constraints by the functions of their kinds; the others are refused."""
        s = self.system
        for part in (*s.loads.values(), *s.contacts.values(), *s.constraints.values()):
            kind = getattr(part, "kind", "") or type(part).__name__
            title = getattr(part, "title", "") or repr(part)
            if kind in sayings and not self.cannot.get(kind):
                sayings[kind](part)
            else:
                why = self.cannot.get(kind) or "there is no such part in the format; leave it out"
                self.refuse(title, why)

    def along(self, part: Any) -> Motion | None:
        """Return the motion along which a part acts."""
        motion = self.motions.get((part.joint.name, part.index))
        if motion is None or part.joint.closes:
            self.refuse(
                part.title, f"its joint '{part.joint.name}' closes a loop; act on a joint of the tree"
            )
            return None
        return motion

    def spring(self, part: Any) -> None:
        """Add a spring: -k (y - y_0) = -σ k (x - ref - σ y_0); two springs are one about their mean."""
        motion = self.along(part)
        if motion is not None:
            k = self.number(part.stiffness, part.title)
            rest = motion.sign * self.number(part.rest, part.title) + motion.ref
            total = motion.stiffness + k
            motion.rest = whole((motion.stiffness * motion.rest + k * rest) / total) if total else 0
            motion.stiffness = total

    def damper(self, part: Any) -> None:
        """Add a damper."""
        motion = self.along(part)
        if motion is not None:
            motion.damping += self.number(part.damping, part.title)

    def dry_friction(self, part: Any) -> None:
        """Add dry friction."""
        motion = self.along(part)
        if motion is not None:
            motion.friction += self.bound(part)

    def bound(self, part: Any) -> Any:
        """Return the greatest force or torque of dry friction."""
        if part.static_friction is not None and part.static_friction != part.friction:
            self.refuse(part.title, "its static friction; leave out static=")
        return self.number(part.friction, part.title)

    def stop(self, part: Any) -> None:
        """Add a stop: of two stops the narrower limits."""
        motion = self.along(part)
        if motion is None:
            return
        self.without_rebound(part)
        ends = [
            end * math.inf if y is None else motion.sign * self.number(y, part.title)
            for y, end in ((part.low, -motion.sign), (part.high, motion.sign))
        ]
        low, high = sorted(ends)
        motion.low, motion.high = max(motion.low, low + motion.ref), min(motion.high, high + motion.ref)

    def without_rebound(self, part: Any) -> None:
        """Refuse the restitution of a stop."""
        if part.restitution != 0:
            self.refuse(part.title, "its restitution; limits do not rebound, leave out restitution=")


def text_of(*numbers: Any) -> str:
    """Return the text of numbers, from which they are read again without loss.

    >>> text_of(1.0, -0.0, 0.1, 2)
    '1 0 0.1 2'
    """
    return " ".join(str(int(x)) if x == int(x) and abs(x) < 2**53 else repr(float(x)) for x in numbers)
