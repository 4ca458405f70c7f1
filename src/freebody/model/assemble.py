"""Assembly of a system to a model; the message about each defect uses the user's names."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import sympy

from ..describe.contacts.mesh import Mesh
from ..describe.description import about_of, changes_of, coordinates_of, names_of, parameters_of, positive_in
from ..describe.joints.joint import Joint
from ..describe.joints.pair import parallel_turns
from ..describe.joints.primitive import Primitive
from ..describe.joints.rotor import Rotor, own_rotor
from ..describe.joints.weld import Weld
from ..describe.names import TIME, rate
from ..describe.system import System
from ..errors import ModelError, shown
from ..scalar.algebra import IDENTITY, ZERO, Matrix, Vector, apply, multiply, scale, subtract, transpose
from ..scalar.expression import exact
from .closure import closure
from .contact import contacts
from .family import families
from .model import GROUND, Coordinate, JointPlace, Link, Model, Place, Speed
from .resistance import with_resistances


def assemble(system: System) -> Model:
    """Return the model of a system: a tree of links, outward from the ground.

    The cost is linear in the number of bodies.

    Parameters
    ----------
    system : System

    Returns
    -------
    Model

    Raises
    ------
    ModelError
        If a body hangs on nothing, a joint of a type that cannot close a loop closes one, a coordinate moves
        nothing, or a moving tip has no mass.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("ball")
    >>> ball = s.body("ball", fb.sphere(1, 1))
    >>> joint = s.free("air", s.ground, ball)
    >>> fb.assemble(s).n_u
    6
    """
    if not isinstance(system, System):
        raise ModelError(
            f"Expected a System, got {shown(system)}. A model is described first: s = fb.System('name')."
        )
    kinds = names_of(system).kinds
    coordinates, speeds = _state(system)
    index = {speed.symbol: i for i, speed in enumerate(speeds)}
    # a scalar coordinate has the index of its speed
    index.update({c.symbol: index[rate(c.symbol)] for c in coordinates if c.kind == "scalar"})
    positions = {coordinate.symbol: i for i, coordinate in enumerate(coordinates)}
    links: list[Link] = []
    bodies: dict[str, Place] = {}
    joints: dict[str, JointPlace] = {}
    rotors = _rotors(system)
    for joint in _outward(system):
        place = (
            Place(GROUND, ZERO, 0, ZERO, IDENTITY) if joint.parent.is_ground else bodies[joint.parent.name]
        )
        numbers = []
        last = len(joint.primitives) - 1
        parent, position, rotation = place.link, _plus(place.origin, joint.start), joint.parent_axes
        primitives = list(joint.primitives)
        mounted = rotors.get(joint.name, ())
        if primitives[last].n_speeds and joint.child_axes != IDENTITY:
            primitives.append(Weld())
            last += 1
        for i, primitive in enumerate(primitives):
            body = None
            if i == last:
                body = joint.child
                if joint.child_axes != IDENTITY:
                    rotation = _exact(multiply(rotation, transpose(joint.child_axes)))
                    axis = tuple(map(exact, apply(joint.child_axes, primitive.axis)))
                    primitive = replace(primitive, axis=axis)
            numbers.append(len(links))
            if i:
                position = (
                    _minus(primitives[i].at or ZERO, primitives[i - 1].at or ZERO)
                    if i < len(joint.primitives)
                    else ZERO
                )
            link = _link(joint, primitive, parent, (rotation, position), body, index, positions)
            links.append(_with_rotors(link, mounted, joint.child_axes))
            parent, position, rotation = numbers[-1], ZERO, IDENTITY
        mass = joint.child.mass_properties
        assert mass is not None
        bodies[joint.child.name] = Place(
            numbers[-1], _minus(ZERO, joint.end), mass.mass, mass.center, mass.inertia, mass
        )
        joints[joint.name] = JointPlace(
            joint.type, joint.pair, tuple(numbers), joint.parent.name, joint.child.name, joint.start, joint.end,
            parallel_turns(primitives),
        )  # fmt: skip
    model = Model(
        name=system.name,
        parameters=tuple(parameters_of(system)),
        coordinates=coordinates,
        speeds=speeds,
        links=tuple(links),
        bodies={name: bodies[name] for name in system.bodies},
        joints={name: joints[name] for name in system.joints if name in joints},
        loads=dict(system.loads),
        gravity=system.gravity,
        positive=_in_order(positive_in(system)),
        names=names_of(system),
        about=dict(about_of(system)),
        order=_order(links, speeds, kinds),
        constraints={
            **{name: closure(joint) for name, joint in system.joints.items() if joint.closes},
            **system.constraints,
        },
        controllers=tuple(system.controllers.values()),
        frames={
            name: (point.body.name, point.components)
            for name, (point, _) in (system.reading.frames if system.reading else {}).items()
        },
        pose=dict(system.reading.initial) if system.reading else None,
        scenery=system.scenery,
        described=(system, changes_of(system).count),
    )
    _check_coordinates(model)
    _check_tips(model)
    of_meshes = {x for mesh in model.meshes.values() if isinstance(mesh, Mesh) for x in mesh.positive}
    positive = _in_order({*model.positive, *of_meshes}) if of_meshes else model.positive
    pairs = with_resistances(contacts(model, tuple(system.contacts.values())), system.contacts)
    return replace(model, positive=positive, contacts=pairs, families=families(model, system))


def _in_order(positive: Iterable[Any]) -> tuple[Any, ...]:
    """Return positive expressions, symbols first: a ring that reads |r + R| knows then that r and R are positive."""
    return tuple(sorted(positive, key=lambda x: (not x.is_Symbol, str(x))))


def _state(system: System) -> tuple[tuple[Coordinate, ...], tuple[Speed, ...]]:
    """Coordinates and speeds, in order of declaration."""
    coordinates, speeds = [], []
    names = names_of(system)
    for text, atom in names.atoms.items():
        kind = names.kinds[text]
        if kind == "coordinate":
            sort = (
                "scalar"
                if text in coordinates_of(system)
                else "quaternion"
                if text[-2:-1] == "e"
                else "position"
            )
            coordinates.append(Coordinate(text, atom, sort))
        elif kind == "speed":
            speeds.append(Speed(text, atom, rate(atom)))
    return tuple(coordinates), tuple(speeds)


def _outward(system: System) -> list[Joint]:
    """Joints in an order in which every parent comes before its children."""
    carriers: dict[str, Joint] = {}
    children: dict[str, list[Joint]] = {}
    for joint in system.joints.values():
        if joint.closes:
            continue
        carriers[joint.child.name] = joint
        children.setdefault(joint.parent.name, []).append(joint)
    loose = [name for name in system.bodies if name not in carriers]
    if loose:
        carries = {joint.parent.name: joint.name for joint in system.joints.values()}
        as_parent = [name for name in loose if name in carries]
        cure = (
            f"It is only the parent of joint '{carries[as_parent[0]]}': exchange parent and child, "
            f"or join it too."
            if as_parent
            else f"Join it to the ground or to another body; a body that flies has s.free('air', s.ground, {loose[0]})."
        )
        raise ModelError(
            f"Body '{(as_parent or loose)[0]}' hangs on nothing: it is the child of no joint. {cure}"
        )
    result: list[Joint] = []
    waiting = deque(children.get("ground", []))
    while waiting:
        joint = waiting.popleft()
        result.append(joint)
        waiting.extend(children.get(joint.child.name, []))
    if len(result) < len(carriers):
        reached = {joint.child.name for joint in result}
        ring = [name for name in carriers if name not in reached]
        raise ModelError(
            f"Bodies {', '.join(ring)} hang on each other and not on the ground. Join one of them to the ground."
        )
    if not result:
        cure = "Add one: s.body('name', fb.sphere(m, R))."
        if getattr(system, "reading", None) is not None:
            cure = "In its file nothing moves on the ground: read it with base='free', or --read base=free."
        raise ModelError(f"System '{system.name}' has no body. {cure}")
    return result


def _link(
    joint: Joint, primitive: Primitive, parent: int, pose: tuple[Matrix, Vector], body: Any,
    index: dict[Any, int], positions: dict[Any, int],
) -> Link:  # fmt: skip
    """The link of a primitive at a pose in its parent; ``index`` and ``positions`` give the speeds and coordinates of
    SymPy atoms.
    """
    y = primitive.coordinate
    partials: tuple[tuple[int, Any], ...] = ()
    drift: Any = 0
    bias: Any = 0
    q = u = -1
    if primitive.n_speeds:
        q = positions[y[0]]
        prefix = str(y[0].func).rpartition("_")[0]
        u = index[sympy.Function(f"{prefix}_wx")(TIME)]
    elif primitive.displaces and isinstance(y, sympy.Basic):
        partials, drift, bias = _rates(y, index)
    mass: Any = 0
    center, inertia = ZERO, (ZERO, ZERO, ZERO)
    if body is not None:
        properties = body.mass_properties
        mass, center, inertia = properties.mass, _minus(properties.center, joint.end), properties.inertia
    return Link(
        joint.name, None if body is None else body.name, primitive.kind, parent, *pose, primitive.axis,
        primitive.pitch, y if primitive.displaces else 0, partials, drift, bias, q, u,
        mass, center, inertia, primitive.armature,
    )  # fmt: skip


def _rotors(system: System) -> dict[str, list[Rotor]]:
    """Rotors of each joint: its own, and those of the motors on it."""
    result: dict[str, list[Rotor]] = {}
    for joint in system.joints.values():
        result[joint.name] = [p.rotor for p in joint.primitives if p.rotor is not None]
    for load in system.loads.values():
        for joint, rotor in load.rotors:
            if joint.closes:
                raise ModelError(
                    f"{load.heading}: joint '{joint.name}' closes a loop and has no displacement. Name a joint of the "
                    f"tree."
                )
            result[joint.name].append(own_rotor(system, load.title, rotor, joint.primitives))
    return result


def _with_rotors(link: Link, rotors: Sequence[Rotor], child_axes: Matrix) -> Link:
    """The link of a joint with rotors: reflected inertia J G², and spin J G about the axis of each."""
    inertia: Any = sum((exact(rotor.inertia * rotor.ratio**2) for rotor in rotors), 0)
    if inertia == 0:
        return link
    spin = ZERO
    for rotor in rotors:
        axis = link.axis if rotor.axis is None else apply(child_axes, rotor.axis)
        spin = _plus(spin, scale(rotor.inertia * rotor.ratio, axis))
    (own,) = link.armature or (0,)
    return replace(link, armature=(exact(own + inertia),), rotor=spin)


def _rates(y: Any, index: dict[Any, int]) -> tuple[tuple[tuple[int, Any], ...], Any, Any]:
    """Rates of a displacement y(q, t): the non-zero (j, ∂y/∂q_j), ∂y/∂t, and y'' without its terms with accelerations.

    The last is Σ_jk ∂²y/∂q_j∂q_k u_j u_k + 2 Σ_j ∂²y/∂q_j∂t u_j + ∂²y/∂t².
    """
    linear = {}
    for term in sympy.Add.make_args(y):
        factor, rest = term.as_coeff_Mul()
        if rest in index:
            linear[index[rest]] = exact(factor)
        elif TIME in term.free_symbols:
            break
    else:
        return tuple(sorted(linear.items())), 0, 0
    atoms = sorted(
        (atom for atom in y.atoms(sympy.core.function.AppliedUndef) if atom in index), key=index.__getitem__
    )
    plain = {atom: sympy.Dummy() for atom in atoms}
    back = {dummy: atom for atom, dummy in plain.items()}
    z = y.xreplace(plain)
    steps = [(index[atom], plain[atom], atom.diff(TIME)) for atom in atoms]
    partials = tuple((j, exact(z.diff(x).xreplace(back))) for j, x, _ in steps)
    drift = z.diff(TIME)
    bias = drift.diff(TIME)
    for _, x, speed in steps:
        bias += 2 * drift.diff(x) * speed
        for _, x2, speed2 in steps:
            bias += z.diff(x, x2) * speed * speed2
    nonzero = tuple((j, partial) for j, partial in partials if partial != 0)
    return nonzero, exact(drift.xreplace(back)), exact(sympy.expand(bias.xreplace(back)))


def _order(
    links: list[Link], speeds: tuple[Speed, ...], kinds: dict[str, str]
) -> tuple[tuple[int, int], ...] | None:
    """Pairs (link, speed) in which the rows of dy/dq determine the speeds, or None if they do not.

    A row whose other speeds are all determined, and whose entry for the last is a non-zero constant, determines the
    last.
    """
    rows = {i: dict(link.partials) for i, link in enumerate(links) if link.partials}
    undetermined: dict[int, set[int]] = {i: set(row) for i, row in rows.items()}
    rows_with: dict[int, list[int]] = {}
    for i, row in rows.items():
        for j in row:
            rows_with.setdefault(j, []).append(i)
    ready = deque(i for i in rows if len(undetermined[i]) == 1)
    order: list[tuple[int, int]] = []
    while ready:
        i = ready.popleft()
        if len(undetermined[i]) != 1:
            continue
        (j,) = undetermined[i]
        if isinstance(rows[i][j], sympy.Basic):
            continue
        order.append((i, j))
        for k in rows_with[j]:
            undetermined[k].discard(j)
            if len(undetermined[k]) == 1:
                ready.append(k)
    scalars = sum(speed.name.endswith("'") for speed in speeds)
    return tuple(order) if len(order) == len(rows) == scalars else None


def _check_coordinates(model: Model) -> None:
    """Refuse a coordinate that occurs in no displacement."""
    moved = {j for link in model.links for j, _ in link.partials}
    for i, speed in enumerate(model.speeds):
        if speed.name.endswith("'") and i not in moved:
            raise ModelError(
                f"Coordinate '{speed.name[:-1]}' is undetermined: it occurs in the displacement of no joint. "
                f"Use it in a coordinate=, or do not declare it."
            )


def _check_tips(model: Model) -> None:
    """Refuse a moving link without mass at the end of the tree, unless its speeds also move other links."""
    parents = {link.parent for link in model.links}
    tips, speeds_of_others = set(), set()
    for i, link in enumerate(model.links):
        entries = (link.mass, *link.armature, *(entry for row in link.inertia for entry in row))
        massless = all(entry == 0 for entry in entries)
        if i not in parents and massless and (link.own or link.partials):
            tips.add(i)
        else:
            speeds_of_others |= {j for j, _ in link.partials}
    for i in sorted(tips):
        link = model.links[i]
        if link.own or not {j for j, _ in link.partials} <= speeds_of_others:
            raise ModelError(
                f"Body '{link.body}' is a moving tip without mass: joint '{link.joint}' would accelerate it without "
                f"limit. Give it mass, weld it, leave it out, or let it follow bodies with mass, by a coordinate= that "
                "is an expression of theirs, such as coordinate=-x/R of a roller."
            )


def _plus(a: Vector, b: Vector) -> Vector:
    return (exact(a[0] + b[0]), exact(a[1] + b[1]), exact(a[2] + b[2]))


def _minus(a: Vector, b: Vector) -> Vector:
    x, y, z = subtract(a, b)
    return (exact(x), exact(y), exact(z))


def _exact(A: Matrix) -> Matrix:
    return tuple(tuple(map(exact, row)) for row in A)  # type: ignore[return-value]
