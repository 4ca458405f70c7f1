"""Mass properties by integration: a density over a region, and solids of revolution.

    m = ∫ dm,   m c = ∫ r dm,   I_O = ∫ (|r|² 1 - r rᵀ) dm,   dm = ρ dV

SymPy computes the integrals exactly. An integral that SymPy cannot do is refused. With numbers for the symbols
(``values=``) the integrals are computed by adaptive quadrature.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy

from ..errors import MassError, shown
from ..scalar.algebra import Expression, Vector
from .entries import AXES, exact_number, is_symbolic, reciprocal, substitution, text, value_of
from .mass import MassProperties
from .shape import Shape

REGIONS = ("cartesian", "cylindrical", "spherical")

Bounds = Sequence[tuple[Expression, Expression]]


def from_density(
    density: Expression,
    bounds: Bounds,
    variables: Sequence[Any],
    coordinates: str = "cartesian",
    *,
    positive: Sequence[Any] = (),
    values: Mapping[Any, Any] | None = None,
) -> MassProperties:
    """Mass properties of a region filled with a density.

    Parameters
    ----------
    density : number or expression of the variables
        [kg/m³]
    bounds : three pairs (lower, upper)
        Bounds of each variable, in the order of ``variables``; they may be expressions of the other variables.
    variables : three symbols
        ``(x, y, z)``; ``(r, phi, z)`` for ``"cylindrical"``; ``(r, theta, phi)`` for ``"spherical"``, theta
        measured from the z axis.
    coordinates : str
        ``"cartesian"``, ``"cylindrical"`` or ``"spherical"``.
    positive : sequence of symbols
        Parameters known to be positive. A symbol that is the upper bound above a lower bound 0 is added.
    values : mapping of symbol (or name) to number, optional
        Numbers for the parameters; the integrals are then computed by quadrature.

    Returns
    -------
    MassProperties
        In the axes x, y, z of the region; the body's origin is the origin of the region.

    Raises
    ------
    MassError
        If SymPy cannot do an integral; the message shows it.

    Examples
    --------
    >>> x, y, z, rho, a = sympy.symbols("x y z rho a", real=True)
    >>> from_density(rho, [(0, a), (0, a), (0, a)], (x, y, z)).mass
    a**3*rho
    """
    names = _symbols(variables, 3)
    if coordinates not in REGIONS:
        raise MassError(f"Expected coordinates {', '.join(REGIONS)}, got {shown(coordinates)}.")
    limits = _bounds(bounds, 3)
    rho = exact_number(density, "the density")
    position, jacobian = _position(names, coordinates)
    assumed = _assumed_positive(limits, positive)
    region = _Region(names, limits, assumed, values)
    x, y, z = position
    integrands = [1, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z]
    m, mx, my, mz, xx, yy, zz, xy, xz, yz = region.integrals([rho * f * jacobian for f in integrands])
    inertia = ((yy + zz, -xy, -xz), (-xy, xx + zz, -yz), (-xz, -yz, xx + yy))
    return _assembled(m, (mx, my, mz), inertia, None, assumed)


def revolve(
    profile: Expression,
    bounds: tuple[Expression, Expression],
    variable: Any,
    *,
    mass: Expression = None,
    density: Expression = None,
    inner: Expression = 0,
    axis: str = "z",
    positive: Sequence[Any] = (),
    values: Mapping[Any, Any] | None = None,
) -> MassProperties:
    """Mass properties of a solid of revolution about ``axis``.

        m = π ∫ ρ (r² - r_i²) dz      I_axis = π/2 ∫ ρ (r⁴ - r_i⁴) dz
        I_across about the origin = I_axis/2 + π ∫ ρ z² (r² - r_i²) dz

    Parameters
    ----------
    profile : number or expression of ``variable``
        The outer radius r along the axis [m]; ``inner`` is the inner radius.
    bounds : (lower, upper)
        Ends of the solid along the axis [m].
    variable : symbol
        The coordinate along the axis, from the body's origin.
    mass, density : number or expression, one of the two
        [kg] for a uniform solid; [kg/m³], which may depend on ``variable``.
    values : mapping of symbol (or name) to number, optional
        Numbers for the parameters; the integrals are then computed by quadrature.

    Raises
    ------
    MassError
        If SymPy cannot do an integral, which the message shows; for numbers, if a radius is negative or the inner
        radius is larger than the outer.

    Examples
    --------
    >>> z, m, r, h = sympy.symbols("z m r h", real=True)
    >>> revolve(r * z / h, (0, h), z, mass=m).center           # a cone, its apex at the origin
    (0, 0, 3*h/4)
    """
    (z,) = _symbols([variable], 1)
    if axis not in AXES:
        raise MassError(
            f"Expected the axis of revolution as 'x', 'y' or 'z', got {shown(axis)}. Turn it with .rotated(R)."
        )
    if (mass is None) == (density is None):
        raise MassError("Expected either mass= or density= of the solid of revolution, got both or none.")
    r, r_i = exact_number(profile, "the profile"), exact_number(inner, "the inner profile")
    limits = _bounds([bounds], 1)
    assumed = _assumed_positive(limits, positive)
    _check_profile(r, r_i, z, limits[0], values)
    rho = 1 if density is None else exact_number(density, "the density")
    region = _Region((z,), limits, assumed, values)
    ring = sympy.pi * sympy.Rational(1, 2) * rho * (r**4 - r_i**4)
    disk = sympy.pi * rho * (r**2 - r_i**2)
    m, mz, mzz, along = region.integrals([disk, z * disk, z**2 * disk, ring])
    if mass is not None:
        M = exact_number(mass, "the mass")
        assumed = (*assumed, M) if is_symbolic(M) else assumed
        M = region.put(M)
        share = exact_number(M) * reciprocal(exact_number(m))
        m, mz, mzz, along = M, *(share * exact_number(x) for x in (mz, mzz, along))
    across = exact_number(along) * sympy.Rational(1, 2) + mzz
    n = "xyz".index(axis)
    moments, first = [across] * 3, [sympy.Integer(0)] * 3
    moments[n], first[n] = along, mz
    inertia = ((moments[0], 0, 0), (0, moments[1], 0), (0, 0, moments[2]))
    dimensions = {"profile": r, "inner": r_i, "variable": z, "lower": limits[0][0], "upper": limits[0][1]}
    shape = Shape("revolved", tuple(dimensions.items()), AXES[axis])
    if values is not None:
        shape = shape.mapped(region.put)
    return _assembled(m, (first[0], first[1], first[2]), inertia, shape, assumed)


class _Region:
    """A region of integration, with integrals over it."""

    def __init__(
        self, names: Sequence[Any], limits: Bounds, positive: Sequence[Any], values: Mapping[Any, Any] | None
    ) -> None:
        self.put = substitution(values) if values is not None else (lambda entry: entry)
        self.numeric = values is not None
        # SymPy can do many integrals only with these assumptions; the results are written in the original symbols
        self.assumed = {s: sympy.Dummy(s.name, positive=True) for s in positive if s.is_Symbol}
        self.order = _order(names, limits)
        for lower, upper in limits:
            width = value_of(exact_number(self.put(sympy.sympify(upper - lower))))
            if width is not None and width < 0:
                raise MassError(
                    f"Expected bounds (lower, upper), got ({text(lower)}, {text(upper)}). Swap them."
                )

    def integrals(self, integrands: Sequence[Any]) -> list[Any]:
        """The integrals of the integrands: SymPy expressions, or floats if there are values."""
        return [self._quadrature(f) if self.numeric else self._exact(f) for f in integrands]

    def _exact(self, integrand: Any) -> Any:
        back = {new: old for old, new in self.assumed.items()}
        result = sympy.expand(sympy.sympify(integrand).xreplace(self.assumed))
        for name, lower, upper in self.order:
            a, b = (sympy.sympify(x).xreplace(self.assumed) for x in (lower, upper))
            sign = {"positive": True} if sympy.sympify(a).is_nonnegative else {"real": True}
            inner = sympy.Dummy(name.name, **sign)
            integral = sympy.integrate(result.xreplace({name: inner}), (inner, a, b))
            if integral.has(sympy.Integral, sympy.Piecewise, sympy.nan, sympy.oo, sympy.zoo):
                rest = next(iter(integral.atoms(sympy.Integral)), integral).xreplace({inner: name, **back})
                raise MassError(
                    f"Expected an integral that SymPy can do, but it left {rest}. Give numbers for its "
                    "symbols with values={...}, or say which of them are positive with positive=(...)."
                )
            result = sympy.expand(integral.xreplace({inner: name}))
        return result.xreplace(back)

    def _quadrature(self, integrand: Any) -> Any:
        from scipy.integrate import nquad

        integrand = sympy.sympify(self.put(sympy.sympify(integrand)))
        order = [(name, self.put(sympy.sympify(a)), self.put(sympy.sympify(b))) for name, a, b in self.order]
        names = [name for name, _, _ in order]
        free = set().union(*(sympy.sympify(e).free_symbols for _, a, b in order for e in (a, b)))
        free = (free | integrand.free_symbols) - set(names)
        if free:
            raise MassError(
                "Expected values of every symbol for the quadrature, got none of "
                f"{', '.join(sorted(map(str, free)))}."
            )
        if integrand == 0:
            return 0
        ranges = [sympy.lambdify(names[i + 1 :], (a, b), "math") for i, (_, a, b) in enumerate(order)]
        function = sympy.lambdify(names, integrand, "math")
        result, error = nquad(function, ranges, opts={"epsabs": 0, "epsrel": _QUADRATURE})
        size = nquad(lambda *at: abs(function(*at)), ranges, opts={"epsrel": 1 / 1000})[0] if error else 0
        if error > 1000 * _QUADRATURE * size:
            raise MassError(
                f"Expected an integral of {integrand} to 1e-9, got an error of {error / size:.1e} by "
                "quadrature. Split the region where the integrand is not smooth."
            )
        return 0 if abs(result) <= error else result


_QUADRATURE = 1 / 10**12  # relative


def _assembled(
    m: Any, first: Vector, about_origin: Any, shape: Shape | None, positive: Sequence[Any]
) -> MassProperties:
    """Mass properties from the mass, the first moment and the inertia about the origin."""
    m, first = _closed(m), tuple(exact_number(x) for x in first)
    if m == 0:
        raise MassError("Expected a solid with mass, got an integral of the density of 0. Check the bounds.")
    center = tuple(_closed(x * reciprocal(m)) for x in first)
    properties = MassProperties.from_inertia_about(m, center, about_origin, (0, 0, 0))
    a, b, c = (tuple(_closed(x) for x in row) for row in properties.inertia)
    return MassProperties(m, properties.center, (a, b, c), shape, tuple(positive))


def _closed(entry: Any) -> Any:
    """An exact entry: a quotient in lowest terms whose numerator and denominator are products."""
    entry = exact_number(entry)
    return exact_number(sympy.factor_terms(sympy.cancel(entry))) if is_symbolic(entry) else entry


def _position(names: Sequence[Any], coordinates: str) -> tuple[Vector, Any]:
    """Position vector and Jacobian determinant."""
    a, b, c = names
    if coordinates == "cartesian":
        return (a, b, c), sympy.Integer(1)
    if coordinates == "cylindrical":
        return (a * sympy.cos(b), a * sympy.sin(b), c), a
    sine = sympy.sin(b)
    return (a * sine * sympy.cos(c), a * sine * sympy.sin(c), a * sympy.cos(b)), a**2 * sine


def _order(names: Sequence[Any], limits: Bounds) -> list[tuple[Any, Any, Any]]:
    """Variables with their bounds, innermost first: no bounds of later variables depend on a variable."""
    remaining = dict(zip(names, limits, strict=True))
    order = []
    while remaining:
        free = [n for n in remaining if not any(_has(e, n) for pair in remaining.values() for e in pair)]
        if not free:
            raise MassError(
                f"Expected bounds that can be integrated one after the other, got bounds of "
                f"{', '.join(map(str, remaining))} that depend on each other in a circle."
            )
        order.append((free[0], *remaining.pop(free[0])))
    return order


def _has(entry: Any, name: Any) -> bool:
    return is_symbolic(entry) and entry.has(name)


def _symbols(variables: Any, count: int) -> tuple[Any, ...]:
    symbols = tuple(variables)
    if not all(isinstance(s, sympy.Symbol) for s in symbols) or len(set(symbols)) != count:
        raise MassError(
            f"Expected {count} different SymPy symbol{'s' if count > 1 else ''} as integration variables, "
            f"got {symbols}."
        )
    return symbols


def _bounds(bounds: Any, count: int) -> list[tuple[Any, Any]]:
    pairs = [tuple(pair) if isinstance(pair, (tuple, list)) else () for pair in bounds]
    if len(pairs) != count or any(len(pair) != 2 for pair in pairs):
        many = "s" if count > 1 else ""
        raise MassError(f"Expected {count} pair{many} (lower, upper) of bounds, got {shown(bounds)}.")
    return [(exact_number(a, "a lower bound"), exact_number(b, "an upper bound")) for a, b in pairs]


def _assumed_positive(limits: Bounds, positive: Sequence[Any]) -> tuple[Any, ...]:
    """The symbols declared positive, and the upper bounds that must be."""
    upper = [b for a, b in limits if a == 0 and isinstance(b, sympy.Symbol)]
    return tuple(dict.fromkeys([*(exact_number(s, "a positive symbol") for s in positive), *upper]))


def _check_profile(
    r: Any, r_i: Any, z: Any, limits: tuple[Any, Any], values: Mapping[Any, Any] | None
) -> None:
    """Refuse numerical radii that are impossible at samples along the axis."""
    put = substitution(values or {})
    a, b = (value_of(sympy.sympify(put(x))) for x in limits)
    if a is None or b is None:
        return
    for i in range(33):
        place = exact_number(a) + (exact_number(b) - exact_number(a)) * sympy.Rational(i, 32)
        outer_, inner_ = (value_of(sympy.N(sympy.sympify(put(e)).subs(z, place))) for e in (r, r_i))
        if outer_ is None or inner_ is None:
            return
        low = min(outer_, inner_)
        if low < -TOUCHING:
            raise MassError(
                f"Expected a radius that is not negative, got {text(low)} at {z} = {text(float(place))}. "
                "Check the profile and the bounds."
            )
        if inner_ > outer_ + TOUCHING:
            raise MassError(
                f"Expected an inner radius within the outer one, got {text(inner_)} > {text(outer_)} at "
                f"{z} = {text(float(place))}. Swap profile and inner."
            )


TOUCHING = _QUADRATURE  # two radii that meet at an end may differ by round-off
