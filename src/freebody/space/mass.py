"""Mass properties of a rigid body and their theorems.

    I_P = I_C + m (|d|² 1 - d dᵀ),  d = p_PC        translation (parallel axes)
    I_A = R_AB I_B R_BA                             rotation
    I = Σ I_i about the common mass centre          combination; a hole is subtracted

The inertia is always the inertia *matrix*, whose entries off the diagonal are minus the products of inertia. The
products of inertia are the integrals ``I_xy = ∫ x y dm`` (Meirovitch's eq. (6.11)). Entries are exact numbers or
SymPy expressions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import sympy

from ..errors import MassError, arguments_named
from ..scalar.algebra import (
    ZERO,
    Expression,
    Matrix,
    Scalar,
    Vector,
    add,
    add_matrices,
    apply,
    congruence,
    dot,
    scale,
    subtract,
    subtract_matrices,
)
from .entries import (
    direction,
    exact_number,
    is_symbolic,
    matrix,
    reciprocal,
    substitution,
    text,
    value_of,
    vector,
)
from .feasibility import check_inertia, check_mass, symmetric
from .principal import PrincipalAxes, principal_axes
from .rotation import Rotation
from .shape import Shape, compound


class Products(NamedTuple):
    """Products of inertia ``∫ x y dm``, ``∫ x z dm``, ``∫ y z dm`` [kg m²]."""

    xy: Scalar
    xz: Scalar
    yz: Scalar


@arguments_named
@dataclass(frozen=True)
class MassProperties:
    """Mass, mass centre and inertia matrix of a rigid body.

    Parameters
    ----------
    mass : number or expression
        [kg]
    center : 3 entries
        The mass centre from the body's origin, in body axes [m].
    inertia : 3 x 3
        The inertia *matrix* about the mass centre, in body axes [kg m²]: its entries off the diagonal are
        minus the products of inertia. See :meth:`from_products` for the other convention, and
        :meth:`from_inertia_about` for an inertia about another point.
    shape : Shape, optional
        Shape of the body, for drawings only.
    positive : tuple of expressions
        Masses and dimensions, which are assumed positive.

    Raises
    ------
    MassError
        If the mass or a moment of inertia is negative, a moment is larger than the sum of the other
        two, or the inertia matrix is not symmetric. With symbols, :meth:`check` repeats the
        test with numbers.

    Examples
    --------
    >>> MassProperties(2, (0, 0, 1), ((3, 0, 0), (0, 3, 0), (0, 0, 1))).about((0, 0, 0))
    ((5, 0, 0), (0, 5, 0), (0, 0, 1))
    """

    mass: Scalar
    center: Vector
    inertia: Matrix
    shape: Shape | None = field(default=None, compare=False, repr=False)
    positive: tuple[Any, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        mass = exact_number(self.mass, "the mass")
        inertia = symmetric(matrix(self.inertia, "the inertia matrix", MassError, exact_number))
        check_mass(mass)
        check_inertia(inertia)
        self._set(mass, vector(self.center, "the mass centre", MassError, exact_number), inertia)
        object.__setattr__(self, "positive", _positive(self.positive))

    @classmethod
    def as_given(
        cls,
        mass: Expression,
        center: Vector,
        inertia: Matrix,
        shape: Shape | None = None,
        possible: bool = True,
    ) -> MassProperties:
        """Mass properties of a file, which are not checked here; if they are not ``possible``, never."""
        result: MassProperties = object.__new__(MassProperties if possible else _AsGiven)
        result._keep(mass, center, inertia, shape, (mass,) if possible else ())
        return result

    @classmethod
    def from_products(
        cls,
        mass: Expression,
        center: Vector,
        moments: Vector,
        products: Vector = ZERO,
        *,
        shape: Shape | None = None,
    ) -> MassProperties:
        """Mass properties from moments and *products* of inertia about the mass centre.

        Parameters
        ----------
        moments : (I_xx, I_yy, I_zz)
            [kg m²]
        products : (I_xy, I_xz, I_yz)
            The integrals ``∫ x y dm``, ...; the entries of the inertia *matrix* are minus these [kg m²].
        """
        Ixx, Iyy, Izz = vector(moments, "the moments of inertia", MassError, exact_number)
        Ixy, Ixz, Iyz = vector(products, "the products of inertia", MassError, exact_number)
        return cls(mass, center, ((Ixx, -Ixy, -Ixz), (-Ixy, Iyy, -Iyz), (-Ixz, -Iyz, Izz)), shape)

    @classmethod
    def from_inertia_about(
        cls, mass: Expression, center: Vector, inertia: Matrix, point: Vector
    ) -> MassProperties:
        """Mass properties from the inertia *matrix* about ``point`` (body axes, from the body's origin)."""
        m = exact_number(mass, "the mass")
        I_P = symmetric(matrix(inertia, "the inertia matrix", MassError, exact_number))
        c = vector(center, "the mass centre", MassError, exact_number)
        p = vector(point, "the point", MassError, exact_number)
        return cls(m, c, subtract_matrices(I_P, _point_mass(m, subtract(c, p))))

    # --- theorems -----------------------------------------------------------------------------

    def about(self, point: Any) -> Matrix:
        """Inertia matrix about a point, in body axes [kg m²]: ``I_C + m (|d|² 1 - d dᵀ)``, d = p_PC.

        ``point`` has three components in body axes, from the body's origin [m].
        """
        p = vector(point, "the point", MassError, exact_number)
        return _map(_tidy, add_matrices(self.inertia, _point_mass(self.mass, subtract(self.center, p))))

    def moved(self, p: Any) -> MassProperties:
        """Mass properties of the body displaced by ``p`` (body axes) relative to the body's origin."""
        shift = vector(p, "the displacement", MassError, exact_number)
        shape = self.shape and self.shape.moved(shift)
        return self._with(self.mass, add(self.center, shift), self.inertia, shape)

    def rotated(self, R: Any) -> MassProperties:
        """Mass properties of the body turned about its origin by R: ``c -> R c``, ``I_C -> R I_C Rᵀ``.

        ``R`` is a :class:`Rotation` or a rotation matrix R_BA that takes components in the current
        axes A of the properties to components in body axes B.
        """
        rotation = R if isinstance(R, Rotation) else Rotation(R)
        R_BA = _map(exact_number, rotation.matrix)
        shape = self.shape and self.shape.rotated(R_BA)
        return self._with(self.mass, apply(R_BA, self.center), congruence(R_BA, self.inertia), shape)

    def __add__(self, other: MassProperties) -> MassProperties:
        """Mass properties of both bodies as one; both refer to the same body axes and origin."""
        if not isinstance(other, MassProperties):
            return NotImplemented
        mass = _tidy(self.mass + other.mass)
        center = self.center if mass == 0 else _weighted(self, other, 1, mass)
        inertia = add_matrices(self.about(center), other.about(center))
        positive = self.positive + other.positive
        return self._with(mass, center, inertia, compound(self.shape, other.shape), positive)

    def __sub__(self, hole: MassProperties) -> MassProperties:
        """Mass properties of the body with ``hole`` cut out; both refer to the same body axes and origin.

        Raises
        ------
        MassError
            If no mass remains, or no body can have the remaining properties (the hole is not inside, or denser).
        """
        if not isinstance(hole, MassProperties):
            return NotImplemented
        mass = _tidy(self.mass - hole.mass)
        value = value_of(mass)
        if value is not None and value <= 0:
            raise MassError(
                f"Expected a hole lighter than the body, got a hole of mass {text(hole.mass)} in a body of "
                f"mass {text(self.mass)}. Give the hole the mass of the material that it removes."
            )
        center = _weighted(self, hole, -1, mass)
        inertia = subtract_matrices(self.about(center), hole.about(center))
        shape = compound(self.shape, hole.shape, hole=True)
        positive = self.positive + hole.positive + (mass,)
        try:  # a hole that extends beyond the body can leave properties that no body has
            return MassProperties(mass, center, inertia, shape, positive)
        except MassError as problem:
            raise MassError(
                f"Expected a hole inside the body, got a remainder that no body can have: {problem} "
                "Move the hole inside the body, or correct its mass."
            ) from problem

    # --- derived quantities -------------------------------------------------------------------

    @property
    def moments(self) -> Vector:
        """``(I_xx, I_yy, I_zz)`` about the mass centre [kg m²]."""
        return (self.inertia[0][0], self.inertia[1][1], self.inertia[2][2])

    @property
    def products(self) -> Products:
        """Products of inertia about the mass centre, the integrals ``∫ x y dm`` [kg m²]."""
        return _products(self.inertia)

    def products_about(self, point: Any) -> Products:
        """Products of inertia about a point (body axes, from the body's origin) [kg m²]."""
        return _products(self.about(point))

    def principal(self) -> PrincipalAxes:
        """Principal moments and axes of inertia about the mass centre; see :func:`principal_axes`."""
        return principal_axes(self.inertia, self.positive)

    def radius_of_gyration(self, axis: Any, point: Any = None) -> Scalar:
        """``sqrt(n·I n / m)`` about an axis through the mass centre, or through ``point`` [m].

        >>> MassProperties(1, (0, 0, 0), ((4, 0, 0), (0, 4, 0), (0, 0, 4))).radius_of_gyration("z")
        2
        """
        n = tuple(exact_number(x, "the axis") for x in direction(axis, "the axis", MassError))
        if self.mass == 0:
            raise MassError("Expected a body with mass, got mass 0: it has no radius of gyration.")
        I = self.inertia if point is None else self.about(point)  # noqa: E741
        ratio = sympy.sympify(dot(n, apply(I, n))) / (sympy.sympify(dot(n, n)) * sympy.sympify(self.mass))
        return exact_number(sympy.sqrt(sympy.cancel(ratio)))

    @property
    def symbols(self) -> frozenset[Any]:
        """The symbols in mass, centre and inertia."""
        entries = (self.mass, *self.center, *(x for row in self.inertia for x in row))
        return frozenset().union(*(e.free_symbols for e in entries if isinstance(e, sympy.Basic)))

    def at(self, values: Mapping[Any, Expression]) -> MassProperties:
        """The mass properties with numbers for symbols (or their names), checked again."""
        put = substitution(values)
        _check_positive(self.positive, put)
        shape = self.shape and self.shape.mapped(put)
        rest = tuple(e for e in map(put, self.positive) if is_symbolic(e))
        x, y, z = map(put, self.center)
        return MassProperties(put(self.mass), (x, y, z), _map(put, self.inertia), shape, rest)

    def check(self, values: Mapping[Any, Expression]) -> None:
        """Refuse values of the parameters for which no body can have these mass properties.

        Raises
        ------
        MassError
            The message names the failed condition and by how much it fails, or the symbols without a value.
        """
        put = substitution(values)
        missing = sorted(str(s) for s in self.symbols if str(s) not in {str(key) for key in values})
        if missing:
            raise MassError(
                f"Expected a value of every symbol of the mass properties, got none of {', '.join(missing)}."
            )
        _check_positive(self.positive, put)
        mass, inertia = put(self.mass), _map(put, self.inertia)
        check_mass(mass)
        check_inertia(inertia)

    def __repr__(self) -> str:
        rows = "; ".join(", ".join(map(text, row)) for row in self.inertia)
        center = ", ".join(map(text, self.center))
        return f"MassProperties(mass {text(self.mass)}, centre ({center}), inertia [{rows}])"

    def _keep(
        self, mass: Any, center: Any, inertia: Any, shape: Shape | None, positive: tuple[Any, ...]
    ) -> None:
        """Keep entries as they are, in exact numbers."""
        self._set(exact_number(mass), tuple(map(exact_number, center)), _map(exact_number, inertia))
        object.__setattr__(self, "shape", shape)
        object.__setattr__(self, "positive", _positive(positive))

    def _set(self, mass: Scalar, center: Vector, inertia: Matrix) -> None:
        for name, value in (("mass", mass), ("center", center), ("inertia", inertia)):
            object.__setattr__(self, name, value)

    def _with(
        self, mass: Scalar, center: Vector, inertia: Matrix, shape: Shape | None, positive: Any = None
    ) -> MassProperties:
        # The result is not checked: the theorems turn possible mass properties into possible ones, and a check
        # would refuse only flat bodies, which are at the limit, because of the round-off of a rotation.
        result = object.__new__(type(self))
        result._set(_tidy(mass), tuple(map(_tidy, center)), _map(_tidy, inertia))
        object.__setattr__(result, "shape", shape)
        object.__setattr__(result, "positive", _positive(self.positive if positive is None else positive))
        return result


class _AsGiven(MassProperties):
    """Mass properties that no body can have, kept as a file gives them."""

    def __post_init__(self) -> None:
        self._keep(self.mass, self.center, self.inertia, self.shape, self.positive)

    def check(self, values: Mapping[Any, Expression]) -> None:
        """Pass: what a file says is kept, and its reader reports what no body can have."""


def _point_mass(m: Scalar, d: Vector) -> Matrix:
    """Inertia matrix m (|d|² 1 - d dᵀ) of a particle at d."""
    x, y, z = d
    xy, xz, yz = -m * x * y, -m * x * z, -m * y * z
    return ((m * (y * y + z * z), xy, xz), (xy, m * (x * x + z * z), yz), (xz, yz, m * (x * x + y * y)))


def _weighted(a: MassProperties, b: MassProperties, sign: int, mass: Scalar) -> Vector:
    """Mass centre (m_a c_a ± m_b c_b) / m."""
    moment = add(scale(a.mass, a.center), scale(sign * b.mass, b.center))
    inverse = reciprocal(mass)
    return tuple(_tidy(inverse * x) for x in moment)


def _tidy(entry: Scalar) -> Scalar:
    """An exact entry, with expressions in lowest terms."""
    entry = exact_number(entry)
    return exact_number(sympy.cancel(entry)) if is_symbolic(entry) else entry


def _map(function: Any, A: Matrix) -> Matrix:
    a, b, c = (tuple(function(x) for x in row) for row in A)
    return (a, b, c)


def _products(A: Matrix) -> Products:
    return Products(-A[0][1], -A[0][2], -A[1][2])


def _positive(entries: tuple[Any, ...]) -> tuple[Any, ...]:
    """Each expression once, in the order of its first occurrence; numbers need no assumption."""
    return tuple(dict.fromkeys(e for e in map(exact_number, entries) if is_symbolic(e)))


def _check_positive(positive: tuple[Any, ...], put: Any) -> None:
    """Refuse values that make a mass or a length negative."""
    for expression in positive:
        value = value_of(put(expression))
        if value is not None and value < 0:
            raise MassError(
                f"Expected {expression} not to be negative (the mass or a length of a solid), got "
                f"{text(value)}. Check the values of its symbols."
            )
