"""Parts of a machine whose kinds users may add by classes of their own: loads, joints and contacts.

A part is data in fields. :func:`add` checks them by the sorts that their annotations name, and puts the part into the
system; an error in the code of a kind names the part, the line and the cure.
"""

from __future__ import annotations

import linecache
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from traceback import FrameSummary, extract_tb
from typing import Any, ClassVar, NoReturn, Self, TypeAlias, dataclass_transform

from ..errors import FreebodyError, ModelError, UndefinedError, nearest, shown
from ..scalar.algebra import Expression
from .constants import unchanging
from .description import Description, all_or_nothing, claim, coordinates_of, vector
from .frame import own_body, own_point
from .labels import Named

Constant: TypeAlias = Expression
"""An expression that does not change during a motion."""
Coordinate: TypeAlias = Any
"""A coordinate, by its name or its function of time."""
Check: TypeAlias = Callable[[Description, Any, Any, str], Any]
"""Returns a value of a field in the system's own terms: (system, value, part, name of the field)."""

PACKAGE = Path(__file__).parents[1]
"""Folder of freebody; lines of code in other folders are the user's."""


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
@dataclass(frozen=True, repr=False, eq=False)
class Part(Named):
    """A part of a machine whose data are its fields. ``table`` is the dictionary of the system that holds it."""

    name: str = field(default="", kw_only=True)

    table: ClassVar[str] = ""
    article: ClassVar[str] = "part"
    """What messages call a part of this sort."""
    base: ClassVar[str] = "fb.Load"
    """The class that users subclass for a part of this sort."""
    labels: ClassVar[Mapping[str, str]] = {}
    """What messages call fields, if not by their names."""
    noun: ClassVar[str] = ""
    """What messages call the part, if not by the name of its class."""
    kind: ClassVar[str] = ""
    """Name of the kind in model files."""
    words: ClassVar[Mapping[str, str]] = {}
    """Keys in model files that are not the names of their fields."""
    cure: ClassVar[str] = "Write the law as a force or a generalized force instead."
    """What messages advise for a constant that changes."""
    rules: ClassVar[str] = ""
    """What messages say about the code of a kind that fails."""
    _data: ClassVar[Sequence[tuple[str, str, bool]]] = ()
    """Name and sort of each field that :func:`add` checks, and whether it may be None."""

    def check(self) -> None:
        """Refuse data that no part of this kind can have; :meth:`System.add` calls it."""

    def joined(self, system: Description) -> Self:
        """Return the part as it stands in the system, checked as a whole."""
        answer(self, self.check)
        return self

    @property
    def title(self) -> str:
        """Kind and name, as messages write them."""
        return f"{self.noun} '{self.name}'" if self.noun else repr(self)

    @property
    def heading(self) -> str:
        """Kind and name at the beginning of a sentence."""
        return f"{self.title[0].upper()}{self.title[1:]}"


def register(cls: type[Part], kind: str, known: dict[str, Any], *, by_data: bool = True) -> None:
    """Make a class of a part a frozen dataclass, and its kind known to model files.

    ``by_data`` says that parts with equal data are equal.
    """
    # a class of the same place replaces the one that it was: a notebook runs a cell again, a script is imported
    other = known.get(kind)
    if other is not None and _place(other) != _place(cls):
        raise ModelError(
            f"There is already a kind of {cls.article} '{kind}' in files, {other.__module__}.{other.__qualname__}. "
            f"Choose another kind= for {cls.__qualname__}."
        )
    cls.kind = kind
    dataclass(frozen=True, repr=False, eq=by_data)(cls)
    cls._data = [(f.name, sort_of(f), f.default is None) for f in fields(cls) if f.name != "name" and f.init]
    if kind:
        known[kind] = cls


def _place(cls: type[Part]) -> tuple[str, str]:
    """Return the file, or else the module, in which a class is written, and its name there."""
    module = cls.__module__
    return getattr(sys.modules.get(module), "__file__", None) or module, cls.__qualname__


def add(system: Description, name: str, part: Part) -> Any:
    """Add a load, a joint or a contact to the machine.

    Parameters
    ----------
    name : str
    part : Load, Joint or Gap
        Such as an instance of your own subclass of :class:`freebody.Load`, :class:`freebody.Joint` or
        :class:`freebody.Gap`.

    Returns
    -------
    Load, Joint or Gap
        The part with its name.
    """
    claim(system, name, getattr(part, "article", "load"))
    if not isinstance(part, Part):
        cure = " Make it one: Drag(point, factor)." if isinstance(part, type) else ""
        raise ModelError(
            f"Expected a load, a joint or a contact for '{name}', an instance of a subclass of fb.Load, fb.Joint or "
            f"fb.Gap, got {shown(part)}.{cure}"
        )
    if part.name:
        raise ModelError(f"{part.title} is already part of a system. Make another one for '{name}'.")
    part = replace(part, name=name)
    with all_or_nothing(system):
        values = {
            field: _checked(system, part, field, sort, optional) for field, sort, optional in part._data
        }
        changed = {field: value for field, value in values.items() if value is not getattr(part, field)}
        part = (replace(part, **changed) if changed else part).joined(system)
    getattr(system, part.table)[name] = part
    return part


# --- fields ------------------------------------------------------------------------------------


def sort_of(field: Any) -> str:
    """Return the sort of a field's data, the last name of its annotation: "Point" for ``fb.Point | None``."""
    text = field.type if isinstance(field.type, str) else getattr(field.type, "__name__", str(field.type))
    text = text.partition("|")[0].strip().rpartition(".")[2]
    return {"Frame": "Body", "tuple": "Vector", "Any": "Expression", "Scalar": "Expression"}.get(text, text)


def _checked(system: Description, part: Part, name: str, sort: str, optional: bool) -> Any:
    """Return the value of a field in the system's own terms; None only where that is the default."""
    value = getattr(part, name)
    if sort not in SORTS or (value is None and optional):
        return value
    return SORTS[sort](system, value, part, name)


def _expression(system: Description, value: Any, part: Part, name: str) -> Any:
    return system.expression(value, part.title)


def _constant(system: Description, value: Any, part: Part, name: str) -> Any:
    what = f"the {part.labels.get(name, name)} of {part.title}"
    return unchanging(system, value, what, part.cure)


def _joint(system: Description, value: Any, part: Part, name: str) -> Any:
    if not isinstance(value, Part) or value.table != "joints":
        raise ModelError(f"Expected a joint for {part.title}, got {shown(value)}.")
    if system.joints.get(value.name) is not value:
        raise ModelError(
            f"{part.heading}: joint '{value.name}' belongs to another system than '{system.name}'. "
            f"Name a joint of this one."
        )
    return value


def own_coordinate(system: Description, value: Any) -> Any:
    """Return a coordinate of the system, by its name or itself, as its function of time."""
    if isinstance(value, str) and value not in coordinates_of(system):
        raise ModelError(f"Unknown coordinate '{value}'; {nearest(value, coordinates_of(system))}")
    atom = system.expression(value, "the coordinate of a generalized force")
    if atom not in coordinates_of(system).values():
        raise ModelError(
            f"Expected a coordinate of this system, got '{atom}'. Coordinates of ball and free joints take "
            f"forces and torques on the body instead."
        )
    return atom


SORTS: dict[str, Check] = {
    "Point": lambda system, value, part, name: own_point(system, value, part.title),
    "Body": lambda system, value, part, name: own_body(system, value, part.title),
    "Joint": _joint,
    "Coordinate": lambda system, value, part, name: own_coordinate(system, value),
    "Expression": _expression,
    "Constant": _constant,
    "Vector": lambda system, value, part, name: vector(system, value, part.title),
}
"""Checks of fields, by the sorts that their annotations name; a room adds its own."""


# --- the code of a kind ------------------------------------------------------------------------


def answer(part: Part, question: Callable[[], Any]) -> Any:
    """Return what the code of a part answers; an error in it names the part, the line and the cure."""
    try:
        return question()
    except ZeroDivisionError as error:
        # the check of a user's kind names the line
        if isinstance(error, UndefinedError) or is_own(part):
            raise
        raise UndefinedError(
            f"{part.heading} has no value at this state: its law divides by zero there. Choose a state at which it has "
            "one, such as points that are apart, or speeds other than zero."
        ) from error
    except (FreebodyError, ArithmeticError) as error:
        line = _own_line(part, error)
        if line is None or type(error) is not ModelError or line.filename in str(error):
            raise
        raise ModelError(f"{error} ({line.filename}, line {line.lineno}: {line.line})") from error
    except Exception as error:
        blame(part, error)


def is_own(part: Part) -> bool:
    """Return True if the kind of a part is a user's, and not one of freebody."""
    return type(part).__module__.partition(".")[0] != PACKAGE.name


def line_of(found: Any, question: Callable[..., Any]) -> str:
    """Return the file and the line of a user's code: where a generator stands, or else where a method begins."""
    frame = getattr(found, "gi_frame", None)
    code = frame.f_code if frame is not None else getattr(question, "__code__", None)
    if code is None:
        return ""
    line = frame.f_lineno if frame is not None else code.co_firstlineno
    return f"({code.co_filename}, line {line}: {linecache.getline(code.co_filename, line).strip()})"


@contextmanager
def said_by(part: Part, question: Callable[..., Any]) -> Iterator[None]:
    """Give the line of a method of a user's kind to what is refused of its answer."""
    try:
        yield
    except ModelError as error:
        line = line_of(None, question)
        if not is_own(part) or "(" + line[1:].partition(", line")[0] in str(error):
            raise
        raise ModelError(f"{error} {line}") from None


def blame(part: Part, error: Exception) -> NoReturn:
    """Raise ModelError for an error in the code of a part, with the line in the user's file."""
    line = _own_line(part, error) or extract_tb(error.__traceback__)[-1]
    raise ModelError(
        f"{part.heading}: {error} ({line.filename}, line {line.lineno}: {line.line}) {part.rules}"
    ) from error


def _own_line(part: Part, error: Exception) -> FrameSummary | None:
    """Return the last line on the way to an error that is the user's; None if there is none.

    It is one of the file of the kind, or else of any file but those of freebody.
    """
    frames = extract_tb(error.__traceback__)
    files = {f.__code__.co_filename for f in vars(type(part)).values() if hasattr(f, "__code__")}
    others = [frame for frame in frames if not Path(frame.filename).is_relative_to(PACKAGE)]
    own = [frame for frame in others if frame.filename in files] or others
    return own[-1] if own else None
