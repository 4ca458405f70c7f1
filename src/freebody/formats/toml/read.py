"""Reader of TOML model files: every table becomes a call of the method of `System` that has its name.

The schema is on the page *Model files* of the documentation.
"""

from __future__ import annotations

import inspect
import re
import tomllib
from collections.abc import Callable, Iterable
from typing import Any

from ...describe.description import names_of, varying
from ...describe.system import System
from ...errors import FormatError, nearest
from ...space import solids
from ...space.mass import MassProperties
from ..case import Case
from .contacts import read_contacts
from .joints import axis, read_joint
from .loads import load_calls
from .looks import read_looks, read_shape
from .parts import own_joint, own_place, place
from .positions import key_lines
from .table import Document, Table

MAX_ENTITIES = 20_000  # parameters, bodies, joints, constraints, contacts and loads together

SOLIDS = (
    "particle", "slender_bar", "disk", "ring", "cylinder", "tube", "cone", "box", "plate", "sphere",
    "spherical_shell", "ellipsoid", "torus",
)  # fmt: skip


def case_from_text(text: str, name: str = "model.toml") -> Case:
    """Return the case that a TOML text describes.

    Parameters
    ----------
    text : str
    name : str
        Name of the file, for messages.

    Raises
    ------
    FormatError
        The message names the file, the line and the key, and says what was expected and what came.

    Examples
    --------
    >>> case = case_from_text('''
    ... [parameters]
    ... m = 1.0
    ... L = 2.0
    ... [bodies.bar]
    ... solid = "slender_bar"
    ... mass = "m"
    ... length = "L"
    ... axis = "y"
    ... [joints.pin]
    ... type = "hinge"
    ... child = "bar"
    ... to = [0, "L/2", 0]
    ... coordinate = "theta"
    ... ''')
    >>> case.system
    System 'model': 1 body, 1 joint, 1 coordinate
    """
    document = Document(name, key_lines(text, name))
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        raise FormatError(f"{name}: expected TOML. {error}") from None
    _check_size(data, document)
    system_name = data.get("name", name.rpartition("/")[2].removesuffix(".toml"))
    if not isinstance(system_name, str) or not system_name.strip():
        document.fail(("name",), f"Expected a name (text), got {system_name!r}.")
    system = System(system_name)
    root = Table(document, (), data, system)
    root.has("name")
    _parameters(root)
    for coordinate in root.texts("coordinates"):
        root.guard(lambda name=coordinate: system.coordinates(name), "coordinates")
    conditions = root.texts("assume")
    of_joints = [text for text in conditions if _names(text) - set(names_of(system).kinds)]
    for condition in conditions:
        if condition not in of_joints:
            root.guard(lambda condition=condition: root.system.assume(condition), "assume")
    for body, table in root.tables("bodies"):
        _body(system, body, table)
    # joints refer to coordinates and loads refer to joints, so this order, whatever the order of the file
    for joint, table in root.tables("joints"):
        read_joint(system, joint, table)
    for condition in of_joints:  # with coordinates that joints declare
        root.guard(lambda condition=condition: root.system.assume(condition), "assume")
    for constraint, table in root.tables("constraints"):
        _constraint(system, constraint, table)
    read_contacts(system, root)
    if root.has("scenery"):
        system.scenery = read_shape(root, "scenery", SOLIDS, _solid_arguments)
    if root.has("gravity"):
        gravity = root.vector("gravity")
        root.guard(lambda: setattr(system, "gravity", gravity), "gravity")
    for add_load in load_calls(system, root):
        add_load()
    for symbol, table in root.tables("describe"):
        unit, about = table.text("unit", ""), table.text("about", "")
        table.guard(lambda symbol=symbol, u=unit, a=about: system.describe(symbol, unit=u, about=a))
        table.done()
    case = Case(system, _initial(system, root, "initial"), *_run(root), _initial(system, root, "near"))
    root.done()
    return case


def _check_size(data: dict[str, Any], document: Document) -> None:
    count = sum(len(value) for value in data.values() if isinstance(value, (dict, list)))
    if count > MAX_ENTITIES:
        document.fail(
            (), f"Expected at most {MAX_ENTITIES} parameters, bodies, joints and loads, got {count}."
        )


def _parameters(root: Table) -> None:
    table = root.table("parameters")
    for name, value in table.data.items():
        table.has(name)
        if value == {}:
            table.guard(lambda name=name: table.system.parameters(name), name)
            continue
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            table.fail(
                f"Expected a number, a number as text such as '75deg', or {{}} for a parameter without "
                f"default, got {value!r}.",
                name,
            )
        table.guard(lambda name=name, value=value: table.system.parameters(**{name: value}), name)


def _names(text: str) -> set[str]:
    """Return the names in an expression, without its functions."""
    return set(re.findall(r"[A-Za-z_]\w*(?!\w|\s*\()", text))


# --- bodies -----------------------------------------------------------------------------------


def _body(system: System, name: str, table: Table) -> None:
    mass = _parts(table) if table.has("parts") else _solid(table)
    shape, color = read_looks(table, SOLIDS, _solid_arguments)
    table.done()
    table.guard(lambda: system.body(name, mass, shape=shape, color=color))


def _parts(table: Table) -> MassProperties:
    parts = table.raw("parts")
    if not isinstance(parts, list) or not parts:
        table.fail(f"Expected a list of parts, [[bodies.NAME.parts]], got {parts!r}.", "parts")
    total: Any = None
    for data in parts:
        part = Table(table.document, (*table.path, "parts"), data, table.system)
        hole = part.has("hole") and part.flag("hole")
        mass = _solid(part)
        part.done()
        if total is None:
            if hole:
                part.fail("Expected a part of mass before the first hole.", "hole")
            total = mass
        else:
            before = total
            total = part.guard(lambda a=before, b=mass, hole=hole: a - b if hole else a + b)
    return total


def _solid(table: Table) -> MassProperties:
    """Return one solid, or mass, centre and inertia, moved by ``at``."""
    if not table.has("solid"):
        mass = table.expression("mass")
        center = table.vector("center", (0, 0, 0))
        inertia = table.matrix("inertia") if table.has("inertia") else ((0, 0, 0),) * 3
        result = table.guard(lambda: MassProperties(mass, center, inertia))
    else:
        kind = table.text("solid")
        if kind not in SOLIDS:
            table.fail(f"Unknown solid '{kind}'; {nearest(kind, SOLIDS)}", "solid")
        make = getattr(solids, kind)
        arguments = dict(_solid_arguments(table, make))
        result = table.guard(lambda: make(**arguments))
    place = table.vector("at", (0, 0, 0))
    return result.moved(place) if place != (0, 0, 0) else result


def _solid_arguments(table: Table, make: Callable[..., Any]) -> Iterable[tuple[str, Any]]:
    for parameter in inspect.signature(make).parameters.values():
        key = "mass" if parameter.name == "m" else parameter.name
        if not table.has(key):
            if parameter.default is parameter.empty:
                table.raw(key)
            continue
        value = table.data[key]
        if key in ("axis", "normal") and isinstance(value, str):
            yield parameter.name, value
        elif isinstance(value, list):
            yield parameter.name, tuple(table.read(item, key) for item in value)
        else:
            yield parameter.name, table.read(value, key)


# --- constraints ------------------------------------------------------------------------------

CONSTRAINTS = {
    "condition": ("expression", "unilateral"),
    "speed": ("expression",),
    "gear": ("first", "second", "ratio", "pressure_angle", "helix_angle"),
    "rope": ("points", "length", "unilateral", "taut", "restitution"),
    "rolling": ("wheel", "radius", "axis", "normal", "plane", "unilateral", "friction"),
}


def _constraint(system: System, name: str, table: Table) -> None:
    kind = table.text("type")
    if kind not in CONSTRAINTS:
        table.fail(f"Unknown type of constraint '{kind}'; {nearest(kind, CONSTRAINTS)}", "type")
    call: Callable[[], Any]
    if kind in ("condition", "speed"):
        value = table.raw("expression")
        one_sided = _sides(table) if kind == "condition" else {}
        make = system.constrain if kind == "condition" else system.constrain_speed
        # a text is passed on, since "y = x^2" is an equation, which only the system reads
        expression = value if isinstance(value, str) else table.read(value, "expression")
        call = lambda: make(expression, name=name, **one_sided)  # noqa: E731
    elif kind == "gear":
        first, second = own_joint(table, "first"), own_joint(table, "second")
        ratio = table.expression("ratio")
        angles = ("pressure_angle", "helix_angle")
        options = {angle: table.expression(angle) for angle in angles if table.has(angle)}
        call = lambda: system.gear(first, second, ratio, name=name, **options)  # noqa: E731
    elif kind == "rope":
        points = table.raw("points")
        if not isinstance(points, list):
            table.fail(f"Expected a list of points, got {points!r}.", "points")
        places = [place(table, point, "points") for point in points]
        length = table.expression("length")
        options = _sides(table)
        if table.has("taut"):
            options["taut"] = table.flag("taut")
        if table.has("restitution"):
            options["restitution"] = table.expression("restitution")
        call = lambda: system.rope(places, length, name=name, **options)  # noqa: E731
    else:
        wheel, radius, normal = (
            own_place(table, "wheel"),
            table.expression("radius"),
            table.text("normal", "y"),
        )
        turning = axis(table, "axis") if table.has("axis") else None
        plane = own_place(table, "plane") if table.has("plane") else None
        options = _sides(table)
        if table.has("friction"):
            options["friction"] = table.expression("friction")
        call = lambda: system.rolling(  # noqa: E731
            name, wheel, radius=radius, axis=turning, normal=normal, plane=plane, **options
        )
    table.done()
    table.guard(call)


def _sides(table: Table) -> dict[str, Any]:
    """Return the argument ``unilateral`` of a constraint if the file has it."""
    return {"unilateral": table.flag("unilateral")} if table.has("unilateral") else {}


# --- the run ----------------------------------------------------------------------------------


def _initial(system: System, root: Table, section: str) -> dict[str, Any]:
    """Return the values of coordinates and speeds in ``[initial]`` or ``[near]``."""
    table = root.table(section)
    names = names_of(system)
    scalars = [name for name, kind in names.kinds.items() if kind in ("coordinate", "speed")]
    ball_joints = [
        joint.name
        for joint in system.joints.values()
        if len(joint.primitives) == 1 and joint.primitives[0].quaternion >= 0
    ]
    result: dict[str, Any] = {}
    for name, value in table.data.items():
        if name not in scalars and name not in ball_joints:
            table.fail(
                f"Unknown coordinate or speed '{name}'; {nearest(name, [*scalars, *ball_joints])}", name
            )
        if name in scalars:
            result[name] = _constant(table, value, name)
        elif isinstance(value, list) and len(value) == 4:
            result[name] = tuple(_constant(table, part, name) for part in value)
        else:
            table.fail(f"Expected the quaternion [w, x, y, z] of joint '{name}', got {value!r}.", name)
    return result


def _constant(table: Table, value: Any, name: str) -> Any:
    """Return a number or an expression of parameters."""
    expression = table.read(value, name)
    moving = varying(table.system, expression)
    if moving:
        table.fail(f"Expected numbers and parameters only, got an expression of {', '.join(moving)}.", name)
    return expression


def _run(root: Table) -> tuple[Any, float | None]:
    """Return the length and the tolerance of the run, None for those that the file does not give."""
    table = root.table("run")
    until, tolerance = None, None
    if table.has("until"):
        until = _constant(table, table.raw("until"), "until")
        if getattr(until, "is_number", True) and until <= 0:
            table.fail(f"Expected a time greater than 0, got {until}.", "until")
    if table.has("tolerance"):
        value = table.expression("tolerance")
        if not getattr(value, "is_number", True) or not 0 < value < 1:
            table.fail(f"Expected a number between 0 and 1, such as 1e-9, got {value}.", "tolerance")
        tolerance = float(value)
    table.done()
    return until, tolerance
