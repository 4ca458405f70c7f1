"""Mass properties by integration: a density over a region, and solids of revolution.

    m = ∫ dm,   m c = ∫ r dm,   I_O = ∫ (|r|² 1 - r rᵀ) dm,   dm = ρ dV

The integrals are SymPy's and exact; what SymPy cannot do is refused, unless numbers are given for the
symbols (``values=``): then it is done by adaptive quadrature.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy

from ..errors import MassError, shown
from ..scalar.algebra import Vector
from .entries import AXES, exact_number, is_symbolic, reciprocal, substitution, text, value_of
from .mass import MassProperties
from .shape import Shape

REGIONS = ("cartesian", "cylindrical", "spherical")

Bounds = Sequence[tuple[Any, Any]]


def from_density(
    density: Any,
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
        Of each variable, in the order of ``variables``; the bounds of one may be expressions of others.
    variables : three symbols
        ``(x, y, z)``; ``(r, phi, z)`` for ``"cylindrical"``; ``(r, theta, phi)`` for ``"spherical"``, theta
        measured from the z axis.
    coordinates : str
        ``"cartesian"``, ``"cylindrical"`` or ``"spherical"``.
    positive : sequence of symbols
        Parameters known to be positive; a lone symbol as the upper bound over a lower bound 0 is known to be.
    values : mapping of symbol (or name) to number, optional
        Numbers for the parameters; the integrals are then done by quadrature.

    Returns
    -------
    MassProperties
        In the axes x, y, z of the region; the body's origin is that of the region.

    Raises
    ------
    MassError
        If SymPy leaves an integral, which the message shows.

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
    known = _known_positive(limits, positive)
    region = _Region(names, limits, known, values)
    x, y, z = position
    integrands = [1, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z]
    m, mx, my, mz, xx, yy, zz, xy, xz, yz = region.integrals([rho * f * jacobian for f in integrands])
    inertia = ((yy + zz, -xy, -xz), (-xy, xx + zz, -yz), (-xz, -yz, xx + yy))
    return _assembled(m, (mx, my, mz), inertia, None, known)


def revolve(
    profile: Any,
    bounds: tuple[Any, Any],
    variable: Any,
    *,
    mass: Any = None,
    density: Any = None,
    inner: Any = 0,
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
        The outer radius r along the axis [m]; ``inner`` is the inner one.
    bounds : (lower, upper)
        Ends of the solid along the axis [m].
    variable : symbol
        The coordinate along the axis, from the body's origin.
    mass, density : number or expression, one of the two
        [kg] for a uniform solid; [kg/m³], which may depend on ``variable``.
    values : mapping of symbol (or name) to number, optional
        Numbers for the parameters; the integrals are then done by quadrature.

    Raises
    ------
    MassError
        If SymPy leaves an integral, which the message shows; for a radius below zero or an inner above an
        outer radius, where they are numbers.

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
    known = _known_positive(limits, positive)
    _check_profile(r, r_i, z, limits[0], values)
    rho = 1 if density is None else exact_number(density, "the density")
    region = _Region((z,), limits, known, values)
    ring = sympy.pi * sympy.Rational(1, 2) * rho * (r**4 - r_i**4)
    disk = sympy.pi * rho * (r**2 - r_i**2)
    m, mz, mzz, along = region.integrals([disk, z * disk, z**2 * disk, ring])
    if mass is not None:
        M = exact_number(mass, "the mass")
        known = (*known, M) if is_symbolic(M) else known
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
    return _assembled(m, (first[0], first[1], first[2]), inertia, shape, known)


class _Region:
    """What is integrated over, and how."""

    def __init__(
        self, names: Sequence[Any], limits: Bounds, known: Sequence[Any], values: Mapping[Any, Any] | None
    ) -> None:
        self.put = substitution(values) if values is not None else (lambda entry: entry)
        self.numeric = values is not None
        # SymPy does many integrals only with these assumptions; the symbols themselves come back afterwards.
        self.assumed = {s: sympy.Dummy(s.name, positive=True) for s in known if s.is_Symbol}
        self.order = _order(names, limits)
        for lower, upper in limits:
            width = value_of(exact_number(self.put(sympy.sympify(upper - lower))))
            if width is not None and width < 0:
                raise MassError(
                    f"Expected bounds (lower, upper), got ({text(lower)}, {text(upper)}). Swap them."
                )

    def integrals(self, integrands: Sequence[Any]) -> list[Any]:
        """The integral of each; SymPy expressions, or floats if there are values."""
        return [self._quadrature(f) if self.numeric else self._exact(f) for f in integrands]

    def _exact(self, integrand: Any) -> Any:
        back = {new: old for old, new in self.assumed.items()}
        result = sympy.expand(sympy.sympify(integrand).xreplace(self.assumed))
        for name, lower, upper in self.order:
            a, b = (sympy.sympify(x).xreplace(self.assumed) for x in (lower, upper))
            sign = {"positive": True} if sympy.sympify(a).is_nonnegative else {"real": True}
            inner = sympy.Dummy(name.name, **sign)
            done = sympy.integrate(result.xreplace({name: inner}), (inner, a, b))
            if done.has(sympy.Integral, sympy.Piecewise, sympy.nan, sympy.oo, sympy.zoo):
                left = next(iter(done.atoms(sympy.Integral)), done).xreplace({inner: name, **back})
                raise MassError(
                    f"Expected an integral that SymPy can do, but it left {left}. Give numbers for its "
                    "symbols with values={...}, or say which of them are positive with positive=(...)."
                )
            result = sympy.expand(done.xreplace({inner: name}))
        return result.xreplace(back)

    def _quadrature(self, integrand: Any) -> Any:
        from scipy.integrate import nquad

        integrand = sympy.sympify(self.put(sympy.sympify(integrand)))
        order = [(name, self.put(sympy.sympify(a)), self.put(sympy.sympify(b))) for name, a, b in self.order]
        names = [name for name, _, _ in order]
        left = set().union(*(sympy.sympify(e).free_symbols for _, a, b in order for e in (a, b)))
        left = (left | integrand.free_symbols) - set(names)
        if left:
            raise MassError(
                "Expected values of every symbol for the quadrature, got none of "
                f"{', '.join(sorted(map(str, left)))}."
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
    m: Any, first: Vector, about_origin: Any, shape: Shape | None, known: Sequence[Any]
) -> MassProperties:
    m, first = _closed(m), tuple(exact_number(x) for x in first)
    if m == 0:
        raise MassError("Expected a solid with mass, got an integral of the density of 0. Check the bounds.")
    center = tuple(_closed(x * reciprocal(m)) for x in first)
    found = MassProperties.from_inertia_about(m, center, about_origin, (0, 0, 0))
    a, b, c = (tuple(_closed(x) for x in row) for row in found.inertia)
    return MassProperties(m, found.center, (a, b, c), shape, tuple(known))


def _closed(entry: Any) -> Any:
    """An exact entry, a quotient in lowest terms and its numerator and denominator as products."""
    entry = exact_number(entry)
    return exact_number(sympy.factor_terms(sympy.cancel(entry))) if is_symbolic(entry) else entry


def _position(names: Sequence[Any], coordinates: str) -> tuple[Vector, Any]:
    a, b, c = names
    if coordinates == "cartesian":
        return (a, b, c), sympy.Integer(1)
    if coordinates == "cylindrical":
        return (a * sympy.cos(b), a * sympy.sin(b), c), a
    sine = sympy.sin(b)
    return (a * sine * sympy.cos(c), a * sine * sympy.sin(c), a * sympy.cos(b)), a**2 * sine


def _order(names: Sequence[Any], limits: Bounds) -> list[tuple[Any, Any, Any]]:
    """Innermost first: a variable is integrated out when no bounds that remain speak of it."""
    left = dict(zip(names, limits, strict=True))
    order = []
    while left:
        free = [n for n in left if not any(_has(e, n) for m, pair in left.items() for e in pair)]
        if not free:
            raise MassError(
                f"Expected bounds that can be integrated one after the other, got bounds of "
                f"{', '.join(map(str, left))} that depend on each other in a circle."
            )
        order.append((free[0], *left.pop(free[0])))
    return order


def _has(entry: Any, name: Any) -> bool:
    return is_symbolic(entry) and entry.has(name)


def _symbols(variables: Any, count: int) -> tuple[Any, ...]:
    found = tuple(variables)
    if not all(isinstance(s, sympy.Symbol) for s in found) or len(set(found)) != count:
        raise MassError(
            f"Expected {count} different SymPy symbol{'s' if count > 1 else ''} as integration variables, "
            f"got {found}."
        )
    return found


def _bounds(bounds: Any, count: int) -> list[tuple[Any, Any]]:
    pairs = [tuple(pair) if isinstance(pair, (tuple, list)) else () for pair in bounds]
    if len(pairs) != count or any(len(pair) != 2 for pair in pairs):
        many = "s" if count > 1 else ""
        raise MassError(f"Expected {count} pair{many} (lower, upper) of bounds, got {shown(bounds)}.")
    return [(exact_number(a, "a lower bound"), exact_number(b, "an upper bound")) for a, b in pairs]


def _known_positive(limits: Bounds, given: Sequence[Any]) -> tuple[Any, ...]:
    found = [b for a, b in limits if a == 0 and isinstance(b, sympy.Symbol)]
    return tuple(dict.fromkeys([*(exact_number(s, "a positive symbol") for s in given), *found]))


def _check_profile(
    r: Any, r_i: Any, z: Any, limits: tuple[Any, Any], values: Mapping[Any, Any] | None
) -> None:
    """Refuse radii that are numbers and wrong, at samples along the axis."""
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
