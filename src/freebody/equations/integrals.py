"""Conserved quantities, each proven by a derivative that is canonically zero.

With the equations of motion written as E_j = 0, linear in u', the rate of a quantity I(q, u, t) along q' = N(q) u is

    dI/dt = Σ μ_j E_j + Σ ν_i ψ_i

identically in q, u and u' exactly if I is conserved, where ψ_i = 0 are the constraints on speeds. The multipliers are
known in advance: u_j for the energy, the components of a rigid motion of the whole machine for a momentum, one for an
ignorable coordinate. So nothing is inverted: the two sides are subtracted as canonical polynomials, and what is not
identically zero is not claimed.

Source: E. Noether (1918); chapter 6, eqs (6.36)-(6.38); Jacobi's integral after H. Goldstein et al., Classical
Mechanics, 3rd ed., §2.7.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import sympy

from ..describe.load import Force, GeneralizedForce, JointForce
from ..dynamics.kinematics import coordinate_rates, link_postures, point_position
from ..dynamics.loading import speed_of
from ..dynamics.momentum import mass_centre, momentum
from ..errors import ModelError, nearest
from ..model.model import GROUND
from ..scalar.algebra import IDENTITY, ZERO, Vector, cross, dot, scale
from ..scalar.substitute import Substitution, arrays
from .display import latex, text
from .symmetry import rigid_motion, solved

if TYPE_CHECKING:
    from .equations import Equations

AXES = "XYZ"
LARGEST_SOLVED = 3
"""Degrees of freedom up to which M μ = ∂I/∂u is solved exactly."""


@dataclass(frozen=True)
class Proof:
    """dI/dt = Σ μ_j E_j + Σ ν_i ψ_i, an identity of polynomials in q, u, u'.

    Attributes
    ----------
    multipliers : dict
        μ_j as SymPy expressions, by the name of the speed whose equation of motion E_j = 0 they multiply.
    constraints : dict
        ν_i by the name of the constraint on speeds, ψ_i = 0.
    """

    multipliers: dict[str, Any]
    constraints: dict[str, Any]
    statement: str

    def __str__(self) -> str:
        return self.statement


class Integral:
    """A quantity that keeps its value along every motion.

    Attributes
    ----------
    name : str
    also : tuple of str
        Other names of the same quantity.
    canonical : Polynomial
    """

    def __init__(
        self, equations: Equations, name: str, canonical: Any, mu: Sequence[Any], nu: Sequence[Any]
    ) -> None:
        self._e = equations
        self.name = name
        self.also: tuple[str, ...] = ()
        self.canonical = canonical
        self._mu = tuple(mu)
        self._nu = tuple(nu)

    @cached_property
    def expression(self) -> Any:
        """The quantity as a SymPy expression."""
        return self._e.displayed(self.canonical)

    @cached_property
    def proof(self) -> Proof:
        """The multipliers of the equations of motion that make up its rate."""
        e = self._e
        mu = {
            name: e.displayed(x) for name, x in zip(e.model.speed_names, self._mu, strict=True) if x != 0
        }
        nu = {name: e.displayed(x) for name, x in zip(e.condition_names, self._nu, strict=True) if x != 0}
        named = [(x, f"(equation of {n})") for n, x in zip(e.model.speed_names, self._mu, strict=True)]
        named += [(x, f"(rate of {n})") for n, x in zip(e.condition_names, self._nu, strict=True)]
        parts = [_times(text(x, e.ring), what) for x, what in named if x != 0]
        return Proof(mu, nu, f"d({self.name})/dt = " + ((" + ".join(parts).replace("+ -", "- ") or "0")))

    def remainder(self) -> Any:
        """dI/dt - Σ μ_j E_j - Σ ν_i ψ_i formed anew: the canonical zero, int 0."""
        return remainder(self._e, self.canonical, self._mu, self._nu)

    def value(self, state: Mapping[Any, Any] | None = None, **values: Any) -> Any:
        """The number at a state.

        Parameters
        ----------
        state : mapping, optional
            Coordinates, speeds, ``t`` and parameters by name or symbol; numbers, or arrays of one shape. Coordinates
            and speeds that are not given are zero, unit quaternions the identity, parameters at their defaults.
        **values
            The same by name, for names that are Python's too.

        Raises
        ------
        ModelError
            An unknown name, or a parameter without a value.
        """
        atoms = numbers(self._e, {**(state or {}), **values})
        result = Substitution(self._e.ring, arrays, atoms)(self.canonical)
        return float(result) if getattr(result, "ndim", 0) == 0 else result

    def text(self) -> str:
        """``name: expression = const`` as plain text."""
        return f"{self.name}: {text(self.canonical, self._e.ring)} = const"

    def latex(self) -> str:
        """The expression as LaTeX, = const."""
        return latex(self.canonical, self._e.ring) + r" = \text{const}"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        return self.text()


class Integrals(Sequence[Integral]):
    """The conserved quantities of a system, in a stable order; also found by name."""

    def __init__(self, found: Sequence[Integral]) -> None:
        self._found = tuple(found)

    @property
    def names(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(one.name for one in self._found)

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, str):
            return self._found[key]
        for one in self._found:
            if key == one.name or key in one.also:
                return one
        if not self._found:
            raise ModelError(f"This system has no conserved quantity that is known here, so none named '{key}'.")
        raise ModelError(f"Unknown conserved quantity '{key}'; {nearest(key, self.names)}")

    def __iter__(self) -> Iterator[Integral]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    def text(self) -> str:
        """One line each."""
        return "\n".join(one.text() for one in self._found) or "No conserved quantities."

    def latex(self) -> str:
        """A LaTeX ``aligned`` block."""
        lines = [rf"&\text{{{one.name}:}}\quad {one.latex()}" for one in self._found]
        return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        return self.text()


def integrals(e: Equations) -> Integrals:
    """The conserved quantities of a system, proven.

    Looked for are the energy (Jacobi's integral where something is driven; constant forces count with their
    potential), the momenta of ignorable coordinates, linear momentum along the ground's axes, angular momentum
    about the ground's origin, about the points and axes of the joints on the ground and about the mass centre, and the
    components of angular momentum along the axes of bodies on ball and free joints. Those that are combinations of
    others with constant coefficients are left out.

    Returns
    -------
    Integrals

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1, L=1, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(m))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), coordinate="theta")
    >>> fb.equations(s).integrals
    energy: m*L^2*theta'^2/2 - m*L*g*cos(theta) = const
    >>> print(fb.equations(s).integrals["energy"].proof)
    d(energy)/dt = theta'*(equation of theta')
    """
    found: list[Integral] = []
    for name, canonical, mu in _candidates(e):
        nu = _proven(e, canonical, mu)
        if nu is None:
            continue
        twin = next((one for one in found if one.canonical in (canonical, -canonical)), None)
        if twin is not None:
            twin.also = (*twin.also, name)
        else:
            found.append(Integral(e, name, canonical, mu, nu))
    return Integrals(_independent(e, found))


# -- proof ----------------------------------------------------------------------------------------


def residuals_of(e: Equations) -> tuple[Any, ...]:
    """E_j = M u' + h - Q - Gᵀ λ, canonical; zero along every motion."""
    if "residuals" not in e.state.cache:
        e.state.cache["residuals"] = tuple(left - right for left, right in e.balances)
    return e.state.cache["residuals"]


def rate_of(e: Equations, x: Any) -> Any:
    """dx/dt along q' = N u, with u' as symbols."""
    rates = {
        c.symbol: rate
        for c, rate in zip(e.model.coordinates, coordinate_rates(e.model, e.state), strict=True)
    }
    rates.update({speed.symbol: udot for speed, udot in zip(e.model.speeds, e.udot, strict=True)})
    return e.ring.total_derivative(x, rates)


def remainder(e: Equations, canonical: Any, mu: Sequence[Any], nu: Sequence[Any]) -> Any:
    """dI/dt - Σ μ_j E_j - Σ ν_i ψ_i."""
    total = rate_of(e, canonical)
    for factor, E in zip(mu, residuals_of(e), strict=True):
        if factor != 0:
            total = total - factor * E
    for factor, rate in zip(nu, e.conditions.rate, strict=True):
        if factor != 0:
            total = total - factor * rate
    return total


def _proven(e: Equations, canonical: Any, mu: Sequence[Any]) -> tuple[Any, ...] | None:
    """Multipliers ν of the constraints that complete the proof; None if there is none."""
    none: tuple[Any, ...] = (0,) * len(e.condition_names)
    rest = remainder(e, canonical, mu, none)
    if rest == 0:
        return none
    if not e.condition_names:
        return None
    # λ enters as λ·(G μ): where G μ is a constraint's own ψ, as for the energy, it is zero along the motion
    nu = _by_constraint(e, mu)
    return nu if nu is not None and remainder(e, canonical, mu, nu) == 0 else None


def _by_constraint(e: Equations, mu: Sequence[Any]) -> tuple[Any, ...] | None:
    nu: list[Any] = []
    for row, rate, multiplier in zip(
        e.conditions.matrix, e.conditions.rate, e.canonical_multipliers, strict=True
    ):
        along: Any = 0
        for entry, factor in zip(row, mu, strict=True):
            along = along + entry * factor
        if along == 0:
            nu.append(0)
        elif along == rate:
            nu.append(multiplier)
        else:
            return None
    return tuple(nu)


# -- candidates -----------------------------------------------------------------------------------


def _candidates(e: Equations) -> Iterator[tuple[str, Any, tuple[Any, ...]]]:
    """(name, quantity, multipliers μ) of all that may be conserved."""
    yield from _energies(e)
    n = e.model.n_u
    p = momenta(e)
    still = _static(e)
    for j, speed in enumerate(e.model.speed_names):
        coordinate = speed.removesuffix("'")
        if speed.endswith("'") and still[j] == 0 and p[j] != 0:
            yield f"momentum of {coordinate}", p[j], tuple(int(k == j) for k in range(n))
    for name, w, v in _motions(e):
        xi = rigid_motion(e.model, e.state, w, v)
        if xi is None:
            yield from _through_masses(e, name, w, v)
        elif _along(xi, still) == 0:  # the force along the motion at rest: it costs next to nothing to ask
            yield name, _along(xi, p), xi
    for link in e.model.links:
        if link.u < 0:
            continue
        for k in range(3):
            if still[link.u + k] == 0 and p[link.u + k] != 0:
                which = f"angular momentum along {'xyz'[k]} of {link.body}"
                yield which, p[link.u + k], tuple(int(j == link.u + k) for j in range(n))


def _through_masses(
    e: Equations, name: str, w: Vector, v: Vector
) -> Iterator[tuple[str, Any, tuple[Any, ...]]]:
    """A momentum along a motion that the joints do not allow to rigid bodies, but to particles and bars.

    Its multipliers solve M μ = ∂I/∂u; asked of small systems, where numbers at a random state say that it is conserved.
    """
    if e.model.n_u > LARGEST_SOLVED or e.condition_names:
        return
    given = momentum(e.model, e.state)
    I = dot(v, given.linear) + dot(w, given.angular)
    gradient = [e.ring.derivative(I, speed.symbol) for speed in e.model.speeds]
    if all(x == 0 for x in gradient) or not _steady_in_numbers(e, I):
        return
    balance = [
        ({j: x for j, x in enumerate(row) if x != 0}, g)
        for row, g in zip(e.canonical_mass_matrix, gradient, strict=True)
    ]
    mu = solved(e.model.n_u, balance, {})
    if mu is not None:
        yield name, I, mu


def _steady_in_numbers(e: Equations, x: Any) -> bool:
    """Whether dx/dt is zero, to round-off, at a random state."""
    import numpy as np

    random = np.random.default_rng(1)
    atoms: dict[Any, Any] = dict.fromkeys((speed.acceleration for speed in e.model.speeds), 0)
    for g in e.ring.generators:
        if not g.arguments and g.atom is not None and g.kind != "constant" and g.atom not in atoms:
            atoms[g.atom] = random.uniform(1, 2)
    for start in e.model.quaternions:
        parts = [e.model.coordinates[start + k].symbol for k in range(4)]
        norm = np.sqrt(sum(atoms[part] ** 2 for part in parts))
        atoms.update({part: atoms[part] / norm for part in parts})
    at = Substitution(e.ring, arrays, atoms)
    M = np.array([[float(at(entry)) for entry in row] for row in e.canonical_mass_matrix])
    right = np.array([float(at(E)) for E in residuals_of(e)])
    if abs(np.linalg.det(M)) <= np.finfo(float).eps * np.linalg.norm(M) ** len(M):
        return False
    udot = -np.linalg.solve(M, right)
    atoms.update({speed.acceleration: a for speed, a in zip(e.model.speeds, udot, strict=True)})
    rate = rate_of(e, x)
    size = sum(abs(float(at(e.ring.derivative(x, s.symbol))) * a) for s, a in zip(e.model.speeds, udot, strict=True))
    value = float(Substitution(e.ring, arrays, atoms)(rate))
    return abs(value) <= np.sqrt(np.finfo(float).eps) * (1 + size)


def momenta(e: Equations) -> tuple[Any, ...]:
    """∂T/∂u_j, canonical."""
    if "momenta" not in e.state.cache:
        T = e.energy.canonical_kinetic
        e.state.cache["momenta"] = tuple(e.ring.derivative(T, speed.symbol) for speed in e.model.speeds)
    return e.state.cache["momenta"]


def _along(a: Sequence[Any], b: Sequence[Any]) -> Any:
    total: Any = 0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def _static(e: Equations) -> list[Any]:
    """E_j at rest without constraint forces: less the forces of weight, springs and loads."""
    zero = {speed.symbol: 0 for speed in e.model.speeds} | {speed.acceleration: 0 for speed in e.model.speeds}
    zero |= {symbol: 0 for symbol in e.multipliers}
    at_rest = Substitution(e.ring, e.ring, zero)
    return [at_rest(E) for E in residuals_of(e)]


def _energies(e: Equations) -> Iterator[tuple[str, Any, tuple[Any, ...]]]:
    """T₂ - T₀ + V less the work of constant forces; the energy itself if nothing is driven."""
    T, p = e.energy.canonical_kinetic, momenta(e)
    u = e.state.u
    V = e.energy.canonical_potential - _work_of_constants(e)
    h = _along(p, u) - T + V
    if h == 0 or not e.ring.atoms_of(h) & {speed.symbol for speed in e.model.speeds}:
        return
    name = "energy" if h == T + V else "Jacobi's integral"
    yield name, h, u


def _work_of_constants(e: Equations) -> Any:
    """Σ F·r of forces with constant components in ground axes, Q q and value * displacement."""
    model, state = e.model, e.state
    total: Any = 0
    for load in model.loads.values():
        if isinstance(load, Force) and load.frame.is_ground and _constant(e, *load.components):
            total = total + dot(state.vector(load.components), point_position(model, state, load.point))
        elif isinstance(load, GeneralizedForce) and _constant(e, load.value):
            symbol = model.speeds[speed_of(model, load)].name.removesuffix("'")
            total = total + state(load.value) * state.q[model.coordinate_names.index(symbol)]
        elif isinstance(load, JointForce) and _constant(e, load.value):
            link = model.links[model.joints[load.joint.name].links[load.index]]
            total = total + state(load.value) * state(link.displacement)
    return total


def _constant(e: Equations, *values: Any) -> bool:
    symbols = {parameter.symbol for parameter in e.model.parameters}
    return all(e.ring.atoms_of(e.state(value)) <= symbols for value in values)


def _motions(e: Equations) -> Iterator[tuple[str, Vector, Vector]]:
    """(name, w, v) of the rigid motions to try: translations, turnings about fixed points and the mass centre."""
    for axis, unit in zip(AXES, IDENTITY, strict=True):
        yield f"linear momentum along {axis}", ZERO, unit
    for axis, unit in zip(AXES, IDENTITY, strict=True):
        yield f"angular momentum along {axis} about the ground's origin", unit, ZERO
    postures = link_postures(e.model, e.state)
    parameters = {parameter.symbol for parameter in e.model.parameters}
    for name, joint in e.model.joints.items():
        i = joint.links[0]
        link = e.model.links[i]
        if link.parent != GROUND or link.kind == "free":
            continue
        axes = list(zip(AXES, IDENTITY, strict=True))
        if link.one_dof:
            n = e.state.vector(link.axis)
            R = e.state.matrix(link.rotation)
            n = tuple(dot(row, n) for row in R)  # type: ignore[assignment]
            if n not in IDENTITY and scale(-1, n) not in IDENTITY:
                axes.append((f"the axis of {name}", n))
                if link.kind == "slider":
                    yield f"linear momentum along the axis of {name}", ZERO, n
        at = postures[i].position
        if at == ZERO or link.kind == "slider":
            at = ZERO
            axes = axes[3:]
        if not all(e.ring.atoms_of(x) <= parameters for x in at):
            continue
        for axis, unit in axes:
            yield f"angular momentum along {axis} about {name}", unit, cross(at, unit)
    _, centre = mass_centre(e.model, e.state)
    if all(e.ring.atoms_of(x) <= parameters for x in centre):
        return
    for axis, unit in zip(AXES, IDENTITY, strict=True):
        yield f"angular momentum along {axis} about the mass centre", unit, cross(centre, unit)


# -- independence ---------------------------------------------------------------------------------


def _independent(e: Equations, found: Sequence[Integral]) -> list[Integral]:
    """Those that are not combinations of earlier ones with coefficients of parameters.

    Decided at random states with the parameters held: a rank of numbers, as a choice of what to print, not a proof.
    """
    import numpy as np

    if len(found) < 2:
        return list(found)
    count = 2 * len(found) + 4
    random = np.random.default_rng(len(found))
    atoms = {}
    for g in e.ring.generators:
        if not g.arguments and g.atom is not None and g.kind != "constant":
            fixed = g.kind == "parameter"
            atoms[g.atom] = 1 + random.random() if fixed else random.uniform(-1, 1, count)
    for start in e.model.quaternions:
        parts = [e.model.coordinates[start + k].symbol for k in range(4)]
        norm = np.sqrt(sum(atoms[part] ** 2 for part in parts))
        atoms.update({part: atoms[part] / norm for part in parts})
    at = Substitution(e.ring, arrays, atoms)
    kept: list[Integral] = []
    basis: list[Any] = [np.ones(count) / np.sqrt(count)]  # a constant is no integral
    small = np.sqrt(np.finfo(float).eps)
    for one in found:
        value = np.broadcast_to(np.asarray(at(one.canonical), dtype=float), (count,))
        rest = value
        for _ in range(2):
            for b in basis:
                rest = rest - (b @ rest) * b
        if np.linalg.norm(rest) > small * np.linalg.norm(value) or not np.isfinite(value).all():
            kept.append(one)
            if np.isfinite(value).all():
                basis.append(rest / np.linalg.norm(rest))
    return kept


# -- numbers --------------------------------------------------------------------------------------


def numbers(e: Equations, given: Mapping[Any, Any]) -> dict[Any, Any]:
    """Numbers for all atoms: those given by name or symbol, parameters by default, coordinates and speeds zero."""
    model = e.model
    known = {**model.names.atoms}
    known.update({speed.name: speed.symbol for speed in model.speeds})
    known.update({c.name: c.symbol for c in model.coordinates})
    parameters = {parameter.name for parameter in model.parameters}
    by_symbol = {symbol: name for name, symbol in known.items()}
    atoms: dict[Any, Any] = {c.symbol: 0 for c in model.coordinates} | {s.symbol: 0 for s in model.speeds}
    atoms.update({model.coordinates[i].symbol: 1 for i in model.quaternions})
    atoms[model.names.atoms["t"]] = 0
    constants = {}
    for key, value in given.items():
        name = key if isinstance(key, str) else by_symbol.get(key, str(key))
        if name not in known:
            raise ModelError(f"Unknown name '{name}'; {nearest(name, known)}")
        if name in parameters and getattr(value, "ndim", 0) == 0:
            constants[name] = value
        else:
            atoms[known[name]] = _plain(value)
    arrays_given = {name for name in parameters if known[name] in atoms}
    values = model.values({**dict.fromkeys(arrays_given, 0), **constants})
    for parameter in model.parameters:
        if parameter.name not in arrays_given:
            atoms[parameter.symbol] = values[parameter.name]
    return atoms


def _plain(value: Any) -> Any:
    if isinstance(value, str | sympy.Basic):
        return float(sympy.sympify(value))
    return value


def _times(factor: str, what: str) -> str:
    if factor in ("1", "-1"):
        return ("-" if factor == "-1" else "") + what
    return f"({factor})*{what}" if " " in factor else f"{factor}*{what}"

