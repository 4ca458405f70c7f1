"""Rotations as values: R_AB takes components in B to components in A, ``v_A = R_AB @ v_B``.

The entries of a :class:`Rotation` are numbers or SymPy expressions. The formulas are in `turn`, `euler` and
`quaternion` and accept every scalar type.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy

from ..errors import ModelError
from ..scalar.algebra import IDENTITY, Expression, Matrix, Scalar, Vector, apply, dot, multiply, transpose
from .entries import (
    common_field,
    direction,
    is_symbolic,
    matrix,
    number,
    plain,
    substitution,
    text,
    value_of,
    vector,
)
from .euler import euler_axes, euler_from_matrix, matrix_from_euler
from .quaternion import axis_angle_from_quaternion, matrix_from_quaternion, quaternion_from_matrix
from .turn import matrix_about

# Allowed deviation of a user's numbers from orthonormal columns (or unit length): twelve printed digits.
TOLERANCE = 4096 * sys.float_info.epsilon


@dataclass(frozen=True)
class Rotation:
    """A rotation R_AB: the columns of ``matrix`` are the axes of B, seen in A.

    Parameters
    ----------
    matrix : 3 x 3
        Numbers or SymPy expressions, with orthonormal columns and determinant +1.

    Raises
    ------
    ModelError
        If the shape is not (3, 3), the columns are not orthonormal (see :meth:`nearest`), or the
        determinant is -1.

    Examples
    --------
    >>> R = Rotation.axis_angle("z", sympy.pi / 2)
    >>> R @ (1, 0, 0)
    (0, 1, 0)
    >>> Rotation.euler("ZXZ", 0.1, 0.2, 0.3).as_euler("ZXZ")
    (0.1..., 0.2..., 0.3...)
    """

    matrix: Matrix

    def __post_init__(self) -> None:
        object.__setattr__(self, "matrix", _checked(matrix(self.matrix, "rotation matrix")))

    # --- construction -------------------------------------------------------------------------

    @classmethod
    def trusted(cls, R: Any) -> Rotation:
        """The rotation of a matrix that is known to be a rotation matrix; nothing is checked."""
        result = object.__new__(cls)
        rows = tuple(tuple(plain(entry) for entry in row) for row in R)
        object.__setattr__(result, "matrix", rows)
        return result

    @classmethod
    def identity(cls) -> Rotation:
        """The identity rotation."""
        return cls.trusted(IDENTITY)

    @classmethod
    def axis_angle(cls, axis: Any, angle: Expression) -> Rotation:
        """A turn by ``angle`` [rad] about ``"x"``, ``"y"``, ``"z"``, or a vector of any length."""
        n = direction(axis, "the axis of rotation")
        field, (x, y, z, turn) = common_field(*n, number(angle, "the angle"))
        square = dot((x, y, z), (x, y, z))
        length = field.sqrt(square) if square != 1 else 1
        if not isinstance(length, int):
            x, y, z = x / length, y / length, z / length
        elif length != 1:
            x, y, z = (Fraction(component) / length for component in (x, y, z))
        return cls.trusted(matrix_about((x, y, z), turn, field))

    @classmethod
    def euler(cls, sequence: str, *angles: Expression) -> Rotation:
        """``R_i(α) R_j(β) R_k(γ)``: turns about body-fixed axes, one after the other [rad].

        ``sequence`` is one of twelve in capitals, such as ``"ZXZ"`` (psi, theta, phi of a gyroscope).
        """
        entries = angles[0] if len(angles) == 1 and not isinstance(angles[0], (str, sympy.Expr)) else angles
        euler_axes(sequence)
        try:
            count = len(entries)
        except TypeError:
            count = 1
        if count != 3:
            raise ModelError(f"Expected three angles for the sequence {sequence}, got {count}.")
        angles = tuple(number(a, f"angle {i + 1} of {sequence}") for i, a in enumerate(entries))
        field, turns = common_field(*angles)
        return cls.trusted(matrix_from_euler(sequence, turns, field))

    @classmethod
    def quaternion(cls, *q: Expression, normalize: bool = False) -> Rotation:
        """The rotation of a unit quaternion, scalar first: w, x, y, z.

        Raises
        ------
        ModelError
            For a zero quaternion, and for one that is not of unit length unless ``normalize=True``.
        """
        components = q[0] if len(q) == 1 and not isinstance(q[0], (str, int, float, sympy.Expr)) else q
        if not hasattr(components, "__len__") or len(components) != 4:
            got = len(components) if hasattr(components, "__len__") else repr(components)
            raise ModelError(f"Expected the four components (w, x, y, z) of a quaternion, got {got}.")
        items = [
            number(c, f"component {x} of the quaternion") for c, x in zip(components, "wxyz", strict=True)
        ]
        field, entries = common_field(*items)
        square = sum(c * c for c in entries)
        if all(c == 0 for c in entries):
            raise ModelError("Expected a unit quaternion (w, x, y, z), got 0. No rotation is (1, 0, 0, 0).")
        if normalize:
            length = field.sqrt(square)
            entries = tuple(Fraction(c) / length if isinstance(length, int) else c / length for c in entries)
        else:
            value = _number_or_sample(square)
            if value is not None and abs(value - 1) > TOLERANCE:
                length = text(float(value) ** (1 / 2))
                raise ModelError(
                    f"Expected a unit quaternion (w, x, y, z), got one of length {length}. "
                    "Use Rotation.quaternion(..., normalize=True) if its direction is what you mean."
                )
        return cls.trusted(matrix_from_quaternion(entries))

    @classmethod
    def nearest(cls, given: Any) -> Rotation:
        """The rotation nearest to a matrix of rounded numbers (polar decomposition)."""
        import numpy

        R = _floats(matrix(given, "rotation matrix"), "nearest")
        U, sizes, V = numpy.linalg.svd(numpy.array(R))
        if sizes[2] <= sizes[0] * TOLERANCE:
            raise ModelError("Expected a matrix near a rotation, got a singular one.")
        if numpy.linalg.det(U @ V) < 0:
            raise ModelError(_rotoreflection(numpy.linalg.det(numpy.array(R))))
        return cls.trusted(tuple(tuple(float(x) for x in row) for row in U @ V))

    @classmethod
    def from_scipy(cls, rotation: Any) -> Rotation:
        """The rotation of a single ``scipy.spatial.transform.Rotation``."""
        R = rotation.as_matrix()
        if R.shape != (3, 3):
            raise ModelError(
                f"Expected a single SciPy rotation, got a stack of {R.shape[0]}. Convert one at a time."
            )
        return cls.trusted(tuple(tuple(float(x) for x in row) for row in R))

    # --- group --------------------------------------------------------------------------------

    @property
    def inverse(self) -> Rotation:
        """R_BA."""
        return Rotation.trusted(transpose(self.matrix))

    def __matmul__(self, other: Any) -> Any:
        """``R_AB @ R_BC`` is R_AC; ``R_AB @ v_B`` gives the components of a vector in A."""
        if isinstance(other, Rotation):
            return Rotation.trusted(multiply(self.matrix, other.matrix))
        return self.apply(other)

    def apply(self, v: Any) -> Vector:
        """Components in A of a vector with components ``v`` in B."""
        x, y, z = (plain(c) for c in apply(self.matrix, vector(v, "the vector")))
        return (x, y, z)

    # --- conversion ---------------------------------------------------------------------------

    def as_euler(self, sequence: str) -> tuple[float, float, float]:
        """Angles of a sequence [rad]; at its singularity the third is zero. See :func:`euler_from_matrix`."""
        return euler_from_matrix(sequence, _floats(self.matrix, "as_euler"))

    def as_quaternion(self) -> tuple[float, float, float, float]:
        """Unit quaternion, scalar first; its first nonzero component is positive."""
        return quaternion_from_matrix(_floats(self.matrix, "as_quaternion"))

    def as_axis_angle(self) -> tuple[tuple[float, float, float], float]:
        """Unit axis, and angle in [0, π] [rad]; (1, 0, 0) and 0 for the identity."""
        return axis_angle_from_quaternion(self.as_quaternion())

    def to_scipy(self) -> Any:
        """The rotation as a ``scipy.spatial.transform.Rotation``."""
        from scipy.spatial.transform import Rotation as SciPyRotation

        return SciPyRotation.from_matrix(_floats(self.matrix, "to_scipy"))

    def at(self, values: Mapping[Any, Expression]) -> Rotation:
        """The rotation with numbers for symbols (or their names); entries that become numbers are floats."""
        put = substitution(values)
        rows = [[put(entry) for entry in row] for row in self.matrix]
        return Rotation.trusted(
            tuple(
                tuple(float(value_of(x)) if is_symbolic(x) and value_of(x) is not None else x for x in row)
                for row in rows
            )
        )

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        """The matrix as a NumPy array, shape (3, 3)."""
        import numpy

        del copy
        symbolic = is_symbolic(*(x for row in self.matrix for x in row))
        return numpy.array(self.matrix, dtype=dtype or (object if symbolic else float))

    def __repr__(self) -> str:
        return "Rotation(" + "; ".join(", ".join(map(text, row)) for row in self.matrix) + ")"


def _checked(R: Matrix) -> Matrix:
    """Return the matrix; raise ModelError if it is not a rotation matrix."""
    columns = transpose(R)
    for i in range(3):
        for j in range(i, 3):
            value = _number_or_sample(dot(columns[i], columns[j]))
            expected = 1 if i == j else 0
            if value is not None and abs(value - expected) > TOLERANCE:
                reason = (
                    f"column {i + 1} has the squared length"
                    if i == j
                    else f"columns {i + 1} and {j + 1} have the dot product"
                )
                raise ModelError(
                    f"Expected a rotation matrix with orthonormal columns, but {reason} {text(float(value))}, "
                    f"{text(abs(float(value) - expected))} from {expected}. If these are rounded numbers, "
                    "use Rotation.nearest(matrix)."
                )
    determinant = _number_or_sample(_determinant(R))
    if determinant is not None and determinant < 0:
        raise ModelError(_rotoreflection(determinant))
    return R


def _rotoreflection(determinant: Any) -> str:
    """Message about a matrix with determinant -1."""
    return (
        f"Expected a rotation matrix with determinant +1, got {text(float(determinant))}: it is a "
        "rotoreflection, which turns a right hand into a left one. Change the sign of one column."
    )


def _determinant(R: Matrix) -> Scalar:
    (a, b, c), (d, e, f), (g, h, i) = R
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def _number_or_sample(entry: Scalar) -> Any:
    """A number itself; for an expression with symbols its value at one fixed point, None if the value is not real.

    An identity holds at every point, so a sample never refuses a correct matrix.
    """
    if not is_symbolic(entry):
        return entry
    atoms = entry.free_symbols | entry.atoms(sympy.core.function.AppliedUndef)
    point = {atom: sympy.Rational(3 + 2 * i, 11 + 5 * i) for i, atom in enumerate(sorted(atoms, key=str))}
    value = sympy.N(entry.xreplace(point), 30)
    return float(value) if value.is_real else None


def _floats(R: Matrix, method: str) -> list[list[float]]:
    """The entries as floats; raise ModelError in the name of the method if they contain symbols."""
    values = [[value_of(x) for x in row] for row in R]
    if any(x is None for row in values for x in row):
        names = sorted({str(s) for row in R for x in row if is_symbolic(x) for s in x.free_symbols})
        raise ModelError(
            f"Expected a rotation of numbers for {method}, got symbols ({', '.join(names)}). "
            "Put numbers for them first: .at({...})."
        )
    return [[float(x) for x in row] for row in values]
