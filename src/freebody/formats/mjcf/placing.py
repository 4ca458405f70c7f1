"""Poses of elements: every way in which MJCF writes an orientation, and the one in which we write it."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from ...scalar.algebra import IDENTITY, Matrix, cross, dot, multiply
from ...scalar.expression import exact
from ...space.pose import Pose
from ...space.rotation import Rotation
from ..builder import whole
from ..machine import text_of
from ..xml_tree import Element
from .document import ORIENTATIONS, Compiler

RIGHT = math.pi / 2
AXES: dict[str, Any] = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def pose(element: Element, compiler: Compiler) -> Pose:
    """Return the pose of an element in its parent."""
    return Pose(Rotation.trusted(orientation(element, compiler)), place(element))


def place(element: Element) -> Any:
    """Return the position of an element."""
    return tuple(map(exact, element.numbers("pos", 3, (0, 0, 0))))


def pose_attributes(pose: Pose) -> dict[str, str]:
    """Return the attributes of a pose: ``xyaxes`` holds a rotation matrix without loss.

    >>> pose_attributes(Pose(position=(0, 0, 1)))
    {'pos': '0 0 1'}
    """
    result = {"pos": text_of(*pose.position)} if any(pose.position) else {}
    R = pose.rotation.matrix
    if R != IDENTITY:
        result["xyaxes"] = text_of(*(row[0] for row in R), *(row[1] for row in R))
    return result


def orientation(element: Element, compiler: Compiler) -> Matrix:
    """Return the rotation matrix of an element."""
    ways = [name for name in ORIENTATIONS if name in element.attributes]
    if not ways:
        return IDENTITY
    if len(ways) > 1:
        raise element.error(f"expected one orientation of <{element.tag}>, got {' and '.join(ways)}")
    match ways[0]:
        case "quat":
            return of_quaternion(element, element.numbers("quat", 4))
        case "axisangle":
            *axis, angle = element.numbers("axisangle", 4)
            return about(unit(element, "axisangle", axis), *turn(angle, compiler.angle == "degree"))
        case "euler":
            return _euler(element.numbers("euler", 3), compiler)
        case "xyaxes":
            *x, y1, y2, y3 = element.numbers("xyaxes", 6)
            x = unit(element, "xyaxes", x)
            along = dot(x, (y1, y2, y3))
            y = unit(element, "xyaxes", [b - along * a for a, b in zip(x, (y1, y2, y3), strict=True)])
            z = cross(x, y)
            return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])
        case _:
            return to_axis(unit(element, "zaxis", element.numbers("zaxis", 3)))


def of_quaternion(element: Element, q: tuple[float, ...]) -> Matrix:
    """Return the rotation matrix of a quaternion of any length, scalar first: rational, as the quaternion is."""
    w, x, y, z = map(exact, q)
    n = w * w + x * x + y * y + z * z
    if n == 0:
        raise element.error(f"expected a quaternion of <{element.tag}> that is not zero")
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return tuple(tuple(whole(Fraction(entry) / n) for entry in row) for row in rows)  # type: ignore[return-value]


def turn(angle: float, degrees: bool) -> tuple[Any, Any]:
    """Return cosine and sine of an angle; a multiple of a right angle has exact ones.

    >>> turn(-90, True), turn(0, False)
    ((0, -1), (1, 0))
    """
    right = 90 if degrees else RIGHT
    count = round(angle / right)
    if angle == count * right:
        return ((1, 0), (0, 1), (-1, 0), (0, -1))[count % 4]
    angle = math.radians(angle) if degrees else angle
    return math.cos(angle), math.sin(angle)


def about(n: Any, c: Any, s: Any) -> Matrix:
    """Return the matrix of a turn about a unit vector: R = c 1 + (1 - c) n nᵀ + s n×."""
    x, y, z = n
    d = 1 - c
    return (
        (c + d * x * x, d * x * y - s * z, d * x * z + s * y),
        (d * x * y + s * z, c + d * y * y, d * y * z - s * x),
        (d * x * z - s * y, d * y * z + s * x, c + d * z * z),
    )


def to_axis(z: Any) -> Matrix:
    """Return the shortest turn of the z axis to a unit vector."""
    across = math.hypot(z[0], z[1])
    if across == 0:
        return IDENTITY if z[2] > 0 else ((1, 0, 0), (0, -1, 0), (0, 0, -1))
    return about((-z[1] / across, z[0] / across, 0), z[2], across)


def unit(element: Element, name: str, v: Any) -> Any:
    """Return a vector of length 1."""
    length = math.hypot(*direction(element, name, v))
    return tuple(whole(x / length) for x in v)


def direction(element: Element, name: str, v: Any) -> Any:
    """Return a vector of any length but 0."""
    if not any(v):
        raise element.error(f"expected a direction for {name}= of <{element.tag}>, got a vector of length 0")
    return tuple(map(whole, v))


def _euler(angles: tuple[float, ...], compiler: Compiler) -> Matrix:
    """Return the turns of a sequence: about body-fixed axes in lower case, space-fixed ones in capitals."""
    R = IDENTITY
    for letter, angle in zip(compiler.eulerseq, angles, strict=True):
        one = about(AXES[letter.lower()], *turn(angle, compiler.angle == "degree"))
        R = multiply(R, one) if letter.islower() else multiply(one, R)
    return R
