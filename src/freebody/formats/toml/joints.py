"""Joints in model files, read and written: a table for each joint, whose ``type`` is the name of its kind.

[joints.pin]
type = "hinge"
child = "bar"
to = [0, "L/2", 0]
coordinate = "theta"
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...describe.description import vector
from ...describe.joints.joint import KINDS, Joint
from ...describe.joints.moving import MOTIONS
from ...describe.joints.primitive import Primitive
from ...describe.joints.rotor import Rotor
from ...describe.names import is_identifier
from ...describe.system import System
from ...errors import nearest
from ...scalar.algebra import IDENTITY, ZERO
from ..own_kinds import named_kind
from .parts import READERS, WRITERS, added, part_keys
from .table import Table
from .value_texts import quoted

# --- read --------------------------------------------------------------------------------------


def read_joint(system: System, name: str, table: Table) -> None:
    """Add one joint of a file to the system."""
    kind = named_kind(table, "type", KINDS, Joint, "type of joint")
    added(system, name, kind, table, {} if table.has("parent") else {"parent": "ground"})


def axis(table: Table, key: str) -> Any:
    """Return an axis: a letter, or three components."""
    value = table.raw(key)
    return value if isinstance(value, str) else table.three(value, key)


def _axes(table: Table, key: str) -> Any:
    value = table.raw(key)
    if not isinstance(value, list):
        table.fail(f"Expected a list of axes, such as ['x', 'y'], got {value!r}.", key)
    return tuple(part if isinstance(part, str) else table.three(part, key) for part in value)


def _coordinates(table: Table, key: str) -> Any:
    value = table.data[key]
    if isinstance(value, list):
        return [part if isinstance(part, str) else table.read(part, key) for part in value]
    return value if isinstance(value, str) else table.read(value, key)


def _armature(table: Table, key: str) -> Any:
    value = table.data[key]
    return [table.read(x, key) for x in value] if isinstance(value, list) else table.read(value, key)


def _rotor(table: Table, key: str) -> Rotor:
    below = table.table(key)
    direction = axis(below, "axis") if below.has("axis") else None
    rotor = Rotor(below.expression("inertia"), below.expression("ratio", 1), direction)
    below.done()
    return rotor


def _motions(table: Table, key: str) -> list[Primitive]:
    return [_motion(part) for part in table.each(key)]


def _motion(table: Table) -> Primitive:
    """Return one motion of a chain."""
    kinds = {name: kind for name, kind in MOTIONS.items() if kind.chained}
    kind = table.text("type")
    if kind not in kinds:
        table.fail(f"Unknown motion '{kind}' of a chain; {nearest(kind, kinds)}", "type")
    made = kinds[kind]
    readers: dict[str, Any] = {"coordinate": _coordinates, "at": Table.vector, "armature": Table.expression}
    if made.displaces:
        readers |= {"axis": axis, "rotor": _rotor}
    if "pitch" in made.__annotations__:
        table.raw("pitch")
        readers["pitch"] = Table.expression
    arguments = {key: read(table, key) for key, read in readers.items() if table.has(key)}
    table.done()
    return made(**arguments)


def _turns(table: Table, key: str) -> list[tuple[Any, Any]]:
    """Return the axis and the angle of each turn of a joint by functions."""
    result = []
    for turn in table.each(key):
        result.append((axis(turn, "axis"), turn.raw("angle")))
        turn.done()
    return result


READERS.update(
    Anchor=lambda table, key: table.vector(key),
    Axes=lambda table, key: table.matrix(key),
    Direction=axis,
    Directions=_axes,
    Displacements=_coordinates,
    Armature=_armature,
    Rotor=_rotor,
    Motions=_motions,
    Turns=_turns,
    Components=lambda table, key: table.raw(key),  # of coordinates that the joint declares
)


# --- write -------------------------------------------------------------------------------------


def joint_keys(writer: Any, joint: Joint) -> dict[str, str]:
    """Return the keys of a joint and their texts."""
    return part_keys(writer, joint, "type")


def axis_text(writer: Any, value: Any) -> str:
    """Return the text of an axis."""
    return (
        quoted(value) if isinstance(value, str) else str(writer.row(vector(writer.system, value, "the axis")))
    )


def _coordinates_text(writer: Any, value: Any) -> str | None:
    if value is None or isinstance(value, str):
        return None if value is None else quoted(value)
    texts = [_coordinate_text(writer, part) for part in value]
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"


def _coordinate_text(writer: Any, coordinate: Any) -> str:
    """Return the text of a joint's displacement."""
    if isinstance(coordinate, str):
        return quoted(coordinate)
    text: str = writer.value(coordinate)
    if coordinate in writer.used and is_identifier(text.strip('"')):
        return f'"({text[1:-1]})"'  # the reader refuses a bare name in use; parentheses make it an expression
    writer.used.add(coordinate)
    return text


def _armature_text(writer: Any, value: Any) -> str:
    return str(writer.row(value) if isinstance(value, tuple) else writer.value(value))


def _rotor_text(writer: Any, rotor: Rotor) -> str:
    parts = [f"inertia = {writer.value(rotor.inertia)}", f"ratio = {writer.value(rotor.ratio)}"]
    parts += [] if rotor.axis is None else [f"axis = {axis_text(writer, rotor.axis)}"]
    return f"{{ {', '.join(parts)} }}"


def _motions_text(writer: Any, motions: Sequence[Primitive]) -> str:
    parts = ",\n  ".join(_motion_text(writer, motion) for motion in motions)
    return f"[\n  {parts},\n]"


def _motion_text(writer: Any, motion: Primitive) -> str:
    """Return the table of one motion of a chain."""
    keys = {"type": quoted(motion.kind)}
    if motion.coordinate is None or motion.coordinate == ():  # the joint closes a loop
        keys |= {"axis": writer.row(motion.axis)} if motion.displaces else {}
    elif motion.displaces:
        keys |= {"axis": writer.row(motion.axis), "coordinate": _coordinate_text(writer, motion.coordinate)}
    else:
        keys["coordinate"] = quoted(str(motion.coordinate[0].func).removesuffix("_e0"))
    keys |= {"at": writer.row(motion.at)} if motion.at != ZERO else {}
    keys |= {"pitch": writer.value(motion.pitch)} if motion.pitch != 0 else {}
    keys |= {"armature": writer.value(motion.armature[0])} if motion.armature else {}
    keys |= {"rotor": _rotor_text(writer, motion.rotor)} if motion.rotor is not None else {}
    return "{ " + ", ".join(f"{key} = {text}" for key, text in keys.items()) + " }"


def _turns_text(writer: Any, turns: Sequence[Any]) -> str:
    texts = [
        f"{{ axis = {axis_text(writer, axis)}, angle = {_function_text(writer, angle)} }}"
        for axis, angle in turns
    ]
    return f"[{', '.join(texts)}]"


def _components_text(writer: Any, components: Any) -> str:
    return f"[{', '.join(_function_text(writer, part) for part in components)}]"


def _function_text(writer: Any, function: Any) -> str:
    """Return the text of a function of the coordinates of a joint."""
    expression = writer.system.expression(function)
    writer.used.add(expression)
    return str(writer.value(expression))


WRITERS.update(
    Anchor=lambda writer, value: None if value == ZERO else writer.row(value),
    Axes=lambda writer, value: None if value == IDENTITY else writer.matrix(value),
    Direction=axis_text,
    Directions=lambda writer, value: f"[{', '.join(axis_text(writer, part) for part in value)}]",
    Displacements=_coordinates_text,
    Armature=_armature_text,
    Rotor=_rotor_text,
    Motions=_motions_text,
    Turns=_turns_text,
    Components=_components_text,
)
