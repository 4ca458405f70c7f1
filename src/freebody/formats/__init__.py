"""Model files: read and written, one module per format."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import FormatError, nearest
from ..unreachable import no_collection
from .files import replacing

if TYPE_CHECKING:
    from ..describe.system import System
    from .case import Case

MAX_SIZE = {".toml": 4_000_000, ".urdf": 40_000_000, ".xml": 40_000_000, ".mjcf": 40_000_000}
"""Greatest size of a file, in bytes."""
OPTIONS: dict[str, Any] = {
    "base": None, "symbols": "masses", "keep_fixed": False, "meshes": True, "limits": False, "friction": False,
    "contacts": None,
}  # fmt: skip
"""Options of robots' files, with their defaults."""
ROBOTS = {".urdf": "urdf", ".xml": "mjcf", ".mjcf": "mjcf"}
"""Formats of robots' files."""
WRITTEN = {".toml": "", **dict.fromkeys(ROBOTS, "")}
"""Formats that are written."""
READ = {
    **WRITTEN,
    ".xacro": "Expand its macros first: `xacro IN.urdf.xacro > OUT.urdf` (ROS), or `xacrodoc IN -o OUT.urdf` (PyPI).",
    ".sdf": "Convert it first, by sdformat's `gz sdf --print` and a converter to URDF such as sdformat_urdf.",
}
"""Formats that are read; for others that people have, what to do."""

__all__ = ["read", "read_case", "replacing", "write"]


def read(
    path: str | os.PathLike[str],
    *,
    base: Any = None,
    symbols: str = "masses",
    keep_fixed: bool = False,
    meshes: bool = True,
    limits: bool = False,
    friction: bool = False,
    contacts: str | Mapping[str, Any] | None = None,
) -> System:
    """Return the system that a file describes: a model file, or a robot in URDF or MJCF.

    Nothing in a file is executed, and it opens no other file but meshes and parts that a robot includes. What a
    robot's file says that the system does not say, or says otherwise, is reported in ``s.reading``, with its line.

    Parameters
    ----------
    path : path-like
        A ``.toml`` file (the page *Model files* of the documentation gives its keys), or a ``.urdf`` or ``.xml``
        (MJCF) file (*Robots*).
    base : {"fixed", "free", "planar"}, motion or sequence of motions, optional
        How the ground holds the link of a robot that no joint holds, of which URDF says nothing; by default fixed, and
        in MJCF as the file says. Motions make a joint as in :meth:`System.chain`: ``fb.Slider("x", "rail")``.
    symbols : {"none", "masses", "all"}
        What of a robot becomes a parameter with the file's number as its default: nothing, masses and inertias
        (``m_link3``, ``c_link3_x``, ``I_link3_xx``, dampers, springs and ``g``), or lengths (``r_joint3_x``) too.
    keep_fixed : bool
        Keep the fixed joints of a robot. By default they merge their links into one body of the first link's name.
    meshes : bool
        Read the meshes that a robot is drawn with, as far as they are found (``package://`` beside the file and the
        folders above it) and made coarse.
    limits : bool
        Stop the joints of a robot at their limits (:meth:`System.stop`, without rebound). By default they are data,
        ``s.reading.limits``, and the robot moves freely, also from a pose that its limits forbid.
    friction : bool
        Give the joints of a robot their dry friction (:meth:`System.friction`).
    contacts : "floor", "all" or mapping, optional
        Let the solids of a robot touch (:meth:`System.contact`) the planes of the world in MJCF, and elsewhere the
        plane z = 0; with "all" each other too, in families (``s.contacts``) for time steps. A mapping gives another
        floor by ``normal``, ``at`` and ``friction``: ``{"friction": 0.8}``; with ``"bodies": True`` bodies touch each
        other, but not those of the pairs of links ``"apart": [("hand", "arm")]``. By default nothing touches. The
        coefficients of friction are parameters ``mu``.

    Returns
    -------
    System

    Raises
    ------
    FormatError
        The message names the file, the line and the key, and says what was expected and what came.

    See Also
    --------
    write : write a system to a file

    Examples
    --------
    >>> import tempfile, freebody as fb
    >>> text = '''<robot name="pendulum"><link name="base"/>
    ... <link name="rod"><inertial><mass value="2"/><origin xyz="0 0 -0.5"/><inertia ixx="0.1" iyy="0.1" izz="0.01"/>
    ... </inertial></link>
    ... <joint name="pin" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
    ... </robot>'''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = open(f"{folder}/pendulum.urdf", "w").write(text)
    ...     s = fb.read(f"{folder}/pendulum.urdf")
    >>> s
    System 'pendulum': 1 body, 1 joint, 1 coordinate
    >>> print(s.reading)
    Read from pendulum.urdf: 1 joint, 2 links.
    changed: gravity is 9.81 m/s² against z; the format says nothing: <robot>, line 1
    >>> print(fb.equations(s))
    Equations of motion of 'pendulum'
    (m_rod*c_rod_z^2 + I_rod_yy)*pin'' - g*m_rod*c_rod_z*sin(pin) = 0
    """
    options = {"limits": limits, "friction": friction, "contacts": contacts}
    return read_case(path, base=base, symbols=symbols, keep_fixed=keep_fixed, meshes=meshes, **options).system


def read_case(path: str | os.PathLike[str], **options: Any) -> Case:
    """Return the system of a file with its ``[initial]``, ``[near]`` and ``[run]``; errors as in :func:`read`."""
    file = _checked(path, READ)
    if not file.is_file():
        content = "a special file" if file.exists() else "no file"
        raise FormatError(f"Expected a model file at '{file}', found {content}.")
    suffix = file.suffix.lower()
    for name in options:
        if name not in OPTIONS:
            raise FormatError(f"Unknown option '{name}' of fb.read; {nearest(name, OPTIONS)}")
    try:
        with file.open("rb") as stream:
            data = stream.read(MAX_SIZE[suffix] + 1)
    except OSError as error:
        raise FormatError(f"Cannot read '{file}': {error.strerror}.") from None
    if len(data) > MAX_SIZE[suffix]:
        raise FormatError(f"{file.name}: expected at most {MAX_SIZE[suffix]} bytes, got more.")
    if suffix in ROBOTS:
        with no_collection():
            from .builder import Options
            from .case import Case
            from .reading import Reading
            from .xml_tree import tree

            reader = import_module(f".{ROBOTS[suffix]}.read", __package__)
        wanted = Options(**{**OPTIONS, **options})
        system = reader.system_of(tree(data, file.name), file, Reading(file.name), wanted)
        return Case(system, dict(system.reading.initial))
    for name, value in options.items():
        if value != OPTIONS[name]:
            raise FormatError(
                f"{file.name}: {name}= is an option of robots' files; a model file says it itself."
            )
    with no_collection():
        from .toml.read import case_from_text

    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise FormatError(
            f"{file.name}, line {line}: expected UTF-8 text, got the byte {data[error.start]:#04x}."
        ) from None
    return case_from_text(text, file.name)


def write(
    system: System,
    path: str | os.PathLike[str],
    *,
    initial: Mapping[str, Any] | None = None,
    until: Any = None,
    tolerance: float | None = None,
    near: Mapping[str, Any] | None = None,
    values: Mapping[Any, Any] | None = None,
) -> None:
    """Write a system as a model file that :func:`read` reads back as the same system, or as a robot in URDF or MJCF.

    A robot's file has numbers: the defaults of the parameters, and ``values``. Its joints have the names of the
    system's joints; those of a joint of several motions have the names of the coordinates. It holds what the format can
    say, and the rest is refused by name (the page *Robots* of the documentation has the table).

    The file is replaced as a whole: an error leaves the old file in place.

    Parameters
    ----------
    system : System
    path : path-like
        Ends in ``.toml``, ``.urdf`` or ``.xml`` (MJCF); its folder must exist.
    initial : mapping of str to number or expression, optional
        Initial values by name, for the table ``[initial]``.
    until : number or expression, optional
        Length of the run [s].
    tolerance : float, optional
    near : mapping, optional
        For machines with constraints, for the table ``[near]``: an approximate closed configuration.
    values : mapping of str to number, optional
        Values of parameters in the file of a robot.

    Raises
    ------
    FormatError
        What the format cannot hold, part by part, each with the cure; an expression that has no text in the file's
        language; a folder that cannot be written.

    Examples
    --------
    >>> import tempfile, freebody as fb
    >>> s = fb.System("ball")
    >>> m = s.parameters(m=1.0)
    >>> ball = s.body("ball", fb.sphere(m, 0.1))
    >>> joint = s.free("air", s.ground, ball)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     fb.write(s, f"{folder}/ball.toml")
    ...     fb.read(f"{folder}/ball.toml")
    System 'ball': 1 body, 1 joint, 7 coordinates

    A robot for another simulator, of a given mass:

    >>> with tempfile.TemporaryDirectory() as folder:
    ...     fb.write(s, f"{folder}/ball.xml", values={"m": 2.5})
    ...     fb.read(f"{folder}/ball.xml", symbols="none").bodies["ball"].mass_properties.mass
    Fraction(5, 2)
    """
    file = _checked(path, WRITTEN)
    run = {"initial": initial, "until": until, "tolerance": tolerance, "near": near}
    if file.suffix.lower() in ROBOTS:
        text = _robot_text(system, file, values, run)
    elif values:
        raise FormatError(f"{file.name}: values= is for robots' files; a .toml file keeps the parameters.")
    else:
        from .toml.write import toml_text

        text = toml_text(system, **run)
    with replacing(file) as new:
        new.write_text(text, encoding="utf-8", newline="\n")


def _robot_text(system: System, file: Path, values: Mapping[Any, Any] | None, run: dict[str, Any]) -> str:
    """Return the text of a robot's file."""
    for name, value in run.items():
        if value is not None:
            raise FormatError(f"{file.name}: {name}= is for .toml files; a robot's file has no run.")
    writer = import_module(f".{ROBOTS[file.suffix.lower()]}.write", __package__)
    text: str = writer.text_of_system(system, values)
    return text


def _models_in(folder: Path) -> str:
    """Return the end of a message: the first files of a folder that are models."""
    with suppress(OSError):
        models = sorted(file.name for file in folder.iterdir() if file.suffix.lower() in MAX_SIZE)
        if models:
            return (
                f" It has {', '.join(models[:3])}{f' and {len(models) - 3} more' if len(models) > 3 else ''}."
            )
    return ""


def _checked(path: str | os.PathLike[str], cures: Mapping[str, str]) -> Path:
    """Return the path of a file to read or write; ``cures`` tells what to do with files of other formats."""
    try:
        file = Path(path)
    except TypeError:
        raise FormatError(f"Expected the path of a model file, got {path!r}.") from None
    suffix = file.suffix.lower()
    if cures is READ and file.is_dir():
        raise FormatError(f"Expected a model file at '{file}', found a folder.{_models_in(file)}")
    if "\0" in str(file) or cures.get(suffix, "none") != "":
        *others, last = (known for known, cure in cures.items() if not cure)
        formats = f"{', '.join(others)} or {last}" if others else last
        cure = cures.get(suffix) or "Other formats are not read or written yet."
        raise FormatError(f"Expected a file that ends in {formats}, got '{file}'. {cure}")
    return file
