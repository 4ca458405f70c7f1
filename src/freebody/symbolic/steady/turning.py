"""Conditions of steady motion of machines with ball and free joints: relative equilibria of a group of motions.

A motion is steady if it runs along commuting symmetries of the equations of motion: the turn of a joint's descendants
about the vertical n (from the left), the spin of a body about its axis of symmetry ζ (from the right), displacements,
and ignorable coordinates. In the child's axes, with R the rotation of the joint,

    ω = Ω Rᵀ n + σ ζ,      ω' = ω × σ ζ,      E_k(q, u, u') = 0      at one instant, hence at all.

R = R_a(θ) R_b(φ), without the turn about n and, if b = ζ, without the spin φ. Speeds need not be constant: those of a
body that spins while it precesses turn in its axes. Every symmetry is proven on the canonical equations of motion.

Source: J. E. Marsden, Lectures on Mechanics (1992), chapter 4.

The file is longer than others: symmetries, unknowns and stability of one problem belong together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from ...dynamics.energy import kinetic_energy, potential_energy
from ...dynamics.kinematics import rotation
from ...dynamics.newton_euler import inverse_dynamics
from ...dynamics.state import State
from ...errors import ModelError
from ...model.model import GROUND
from ...scalar.algebra import (
    HALF,
    ZERO,
    Expression,
    Matrix,
    Scalar,
    Vector,
    add,
    apply_transpose,
    cross,
    dot,
    floats,
    multiply,
    scale,
)
from ...space.quaternion import quaternion_product
from ...space.turn import matrix_about
from ..derivation.along_motion import residuals_of
from ..linear.linearize import terms_at
from ..linear.operating_point import tangent_drift
from .factors import cleared
from .problem import Problem
from .stability import Spectrum, Stability, spectral_verdict

if TYPE_CHECKING:
    from ..equations import Equations

T = sympy.Symbol("t")
SAME = 1 / 10**6
"""Relative difference of energies and eigenvalues below which two motions are the same."""
SHORT = 2
"""Largest number of angles for which a closed form is sought: those of one joint on the ground."""


@dataclass(frozen=True)
class Turning:
    """One ball or free joint: its angles, the axes they turn about, and the rates of its symmetries."""

    link: int
    vertical: Vector  # n, in the parent's joint axes
    turns: tuple[tuple[Vector, Any], ...]  # (axis, atom), the parent's first; an atom None is zero
    precession: Any  # atom of Ω, or None
    spin: Any  # atom of σ, or None
    axis: Vector  # ζ
    # of a free joint: atoms of the position in the parent's joint axes, None if ignorable, and of the velocity, or None
    place: tuple[Any, ...]
    drift: tuple[Any, ...]


class _Turned(State):
    """A state whose ball and free joints are turned by given matrices."""

    def __init__(
        self, state: State, q: Sequence[Scalar], u: Sequence[Scalar], turned: Mapping[int, Matrix]
    ) -> None:
        super().__init__(state.model, state.field, state.t, q, u, state.values)
        self._turned = turned

    def _evaluate_joint(self, link: Any) -> Any:
        i = self.model.links.index(link)
        if i not in self._turned:
            return super()._evaluate_joint(link)
        E, r = self.matrix(link.rotation), self.vector(link.position)
        w = self.u[link.u : link.u + 3]
        if link.pivots:
            return (multiply(E, self._turned[i]), r, (w, ZERO))
        p = self.q[link.q : link.q + 3]
        moved = tuple(dot(row, p) for row in E)
        return (multiply(E, self._turned[i]), add(r, moved), (w, self.u[link.u + 3 : link.u + 6]))


class TurningProblem(Problem):
    """The conditions of the steady motions of a machine with ball and free joints; attributes as in `Problem`."""

    def __init__(self, e: Equations, terms: Mapping[Any, Expression] | None = None) -> None:
        self.e = e
        self.ring = e.ring
        model = e.model
        if model.constraints:
            raise ModelError(
                f"Steady motions of '{model.name}' are not sought, since it has both constraints "
                f"({', '.join(model.constraints)}) and joints with unit quaternions. Describe the turning by Euler "
                "angles: s.gimbal in place of s.ball, and for a free body s.gimbal on a massless carrier that slides."
            )
        if terms:
            raise ModelError(
                f"Expected no `terms` for '{model.name}': they are combinations of its own speeds, but the rates of "
                "its ball and free joints belong to the steady motion. Ask for these: psi' of the turn about the "
                "vertical and phi' of the spin, with the joint's name in front."
            )
        self.names: dict[Any, str] = {}
        self.coordinates = [c.symbol for c in model.coordinates]
        self.free = tuple(range(model.n_u))
        self.residuals = residuals_of(e)
        self.closing, self.matrix, self.multipliers, self.coupled = (), [], [], ()
        self.dependent = {}
        self._refuse_time()
        self.turnings = self._turnings()
        scalar = {s.name: j for j, s in enumerate(model.speeds)}
        coordinate = {c.name: k for k, c in enumerate(model.coordinates) if c.kind == "scalar"}
        self.scalars = {j: coordinate[name[:-1]] for name, j in scalar.items() if name[:-1] in coordinate}
        self.families = self._scalar_families()
        self.pivots = tuple(next(iter(family)) for family in self.families)
        self.gauge = {self.coordinates[self.scalars[j]] for j in self.pivots}
        more = [
            a
            for turning in self.turnings
            for a in (turning.precession, turning.spin, *turning.drift)
            if a is not None
        ]
        self.rates = (*dict.fromkeys(more), *(model.speeds[j].symbol for j in self.pivots))
        self._form()
        self.terms, self.replaced = {}, {}
        numerators = (cleared(self.ring, x) for x in self.exact)
        self.conditions = tuple(x for x in numerators if x != 0)
        self.short = len(self.unknown_angles) <= SHORT
        self.unknowns = self._unknowns()

    # -- joints and their symmetries --------------------------------------------------------------

    def _atom(self, joint: str, ending: str) -> Any:
        """Return a new coordinate of the steady motion, such as ``pivot_theta``."""
        name = f"{joint}_{ending}"
        while name in self.e.model.names.kinds or name in self.names.values():
            name += "_"
        atom = sympy.Function(name)(T)
        self.ring.generator(atom, "coordinate")
        self.names[atom] = name
        return atom

    def _rate(self, atom: Any) -> Any:
        rate = atom.diff(T)
        self.ring.generator(rate, "speed")
        self.names[rate] = self.names[atom] + "'"
        return rate

    def _turnings(self) -> list[Turning]:
        e = self.e
        result = []
        for i, link in enumerate(e.model.links):
            if not link.own:
                continue
            vertical, fixed = self._vertical(i)
            spinning = self._spin_axis(i)
            b = spinning if spinning is not None else vertical
            a = cross(vertical, b)
            if a == ZERO:
                a = (b[1], b[2], b[0])
            psi, theta, phi = (self._atom(link.joint, name) for name in ("psi", "theta", "phi"))
            turns = fixed and self._symmetric(i, vertical, left=True)
            place, drift = [], []
            if link.flies:
                for k in range(3):
                    direction = tuple(int(m == k) for m in range(3))
                    along = fixed and self._displaced(i, direction)
                    name = e.model.coordinates[link.q + k].symbol
                    # an ignorable displacement along the axis of the turn has a constant rate
                    free = along and direction in (vertical, tuple(-x for x in vertical))
                    place.append(None if free else name)
                    self.names[name] = e.model.coordinates[link.q + k].name
                    drift.append(self._rate(name) if free else None)
            result.append(
                Turning(
                    i,
                    vertical,
                    (
                        (vertical, None if turns else psi),
                        (a, theta),
                        (b, None if spinning is not None else phi),
                    ),
                    self._rate(psi) if turns else None,
                    self._rate(phi) if spinning is not None else None,
                    b,
                    tuple(place),
                    tuple(drift),
                )
            )
        return result

    def _vertical(self, i: int) -> tuple[Vector, bool]:
        """Return (upward direction in the parent's joint axes or z, True if these axes do not turn)."""
        e = self.e
        model, link = e.model, e.model.links[i]
        parent = link.parent
        while parent != GROUND:
            if not (model.links[parent].slides_only or model.links[parent].fixed):
                return (0, 0, 1), False
            parent = model.links[parent].parent
        E = e.state.matrix(link.rotation)
        if link.parent != GROUND:
            E = multiply(rotation(model, e.state, link.parent), E)
        g = e.state.vector(model.gravity)
        if g == ZERO:
            return (0, 0, 1), True
        n = apply_transpose(E, g)
        live = [k for k in range(3) if n[k] != 0]
        if len(live) != 1:
            raise ModelError(
                f"Gravity does not stand along an axis of joint '{link.joint}' of '{model.name}', about which its "
                "steady turning is sought. Turn the joint's axes on both sides (parent_axes=, child_axes=), or "
                "choose ground axes with one of them vertical."
            )
        return tuple(int(k == live[0]) for k in range(3)), True  # type: ignore[return-value]

    def _spin_axis(self, i: int) -> Vector | None:
        """Return the body axis about which the link has rotational symmetry, proven on the equations, or None."""
        model = self.e.model
        if any(link.parent == i for link in model.links):
            return None
        for k in (2, 1, 0):
            axis: Vector = tuple(int(m == k) for m in range(3))  # type: ignore[assignment]
            if self._symmetric(i, axis, left=False):
                return axis
        return None

    def _symmetric(self, i: int, axis: Vector, left: bool) -> bool:
        """Return True if a turn about an axis of the parent (``left``) or of the child is a symmetry."""
        e = self.e
        link = e.model.links[i]
        start = link.quaternion
        quaternion: Any = e.state.q[start : start + 4]
        half = (0, *scale(HALF, axis))
        moved: Any = quaternion_product(half, quaternion) if left else quaternion_product(quaternion, half)
        rates = {e.model.coordinates[start + k].symbol: x for k, x in enumerate(moved)}
        expected: list[Any] = [0] * e.model.n_u
        if left and link.flies:
            p = e.state.q[link.q : link.q + 3]
            rates.update({e.model.coordinates[link.q + k].symbol: x for k, x in enumerate(cross(axis, p))})
        if not left:
            for first in (link.u, link.u + 3)[: 2 if link.flies else 1]:
                u, udot, E = (tuple(x[first : first + 3]) for x in (e.state.u, e.udot, self.residuals))
                for k, (x, y, z) in enumerate(zip(*(cross(v, axis) for v in (u, udot, E)), strict=True)):
                    speed = e.model.speeds[first + k]
                    rates[speed.symbol], rates[speed.acceleration] = x, y
                    expected[first + k] = z
        return all(
            e.ring.total_derivative(E, rates) == x for E, x in zip(self.residuals, expected, strict=True)
        )

    def _displaced(self, i: int, direction: Any) -> bool:
        e = self.e
        link = e.model.links[i]
        rates = {e.model.coordinates[link.q + k].symbol: x for k, x in enumerate(direction)}
        return all(e.ring.total_derivative(E, rates) == 0 for E in self.residuals)

    def _scalar_families(self) -> list[dict[int, Any]]:
        """Return the families of the scalar coordinates, as for any machine."""
        free, self.free = self.free, tuple(self.scalars)
        self.coordinate_of = {j: k for j, k in self.scalars.items()}  # type: ignore[assignment]
        families = self._symmetries()
        self.free = free
        return families

    # -- the conditions ---------------------------------------------------------------------------

    def _form(self) -> None:
        """Form the speeds and accelerations on a steady motion, and the equations of motion at these values."""
        e, ring, model = self.e, self.ring, self.e.model
        values: dict[Any, Scalar] = dict.fromkeys(self.gauge, 0)
        u: list[Scalar] = [0] * model.n_u
        udot: list[Scalar] = [0] * model.n_u
        q = [0 if c in self.gauge else ring.generator(c) for c in self.coordinates]
        for family, j in zip(self.families, self.pivots, strict=True):
            w = ring.generator(model.speeds[j].symbol)
            for k, factor in family.items():
                u[k] = u[k] + factor * w
        turned = {}
        self.unknown_angles: list[Any] = []
        for turning in self.turnings:
            link = model.links[turning.link]
            R: Any = None
            for axis, atom in turning.turns:
                if atom is None:
                    continue
                self.unknown_angles.append(atom)
                step = matrix_about(axis, ring.generator(atom), ring)
                R = step if R is None else multiply(R, step)
            if R is None:
                R = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
            turned[turning.link] = R
            n = turning.vertical
            W = scale(ring.generator(turning.precession), n) if turning.precession is not None else ZERO
            sigma = scale(ring.generator(turning.spin), turning.axis) if turning.spin is not None else ZERO
            spin = add(apply_transpose(R, W), sigma)
            u[link.u : link.u + 3] = spin
            udot[link.u : link.u + 3] = cross(spin, sigma)
            if link.flies:
                p = tuple(0 if a is None else ring.generator(a) for a in turning.place)
                q[link.q : link.q + 3] = p
                V = tuple(0 if a is None else ring.generator(a) for a in turning.drift)
                V = add(V, cross(W, p))  # type: ignore[arg-type]
                v = apply_transpose(R, V)
                u[link.u + 3 : link.u + 6] = v
                udot[link.u + 3 : link.u + 6] = add(
                    apply_transpose(R, cross(W, V)), scale(-1, cross(spin, v))
                )
                values.update(zip(self.coordinates[link.q : link.q + 3], p, strict=True))
        state = _Turned(e.state, q, u, turned)
        self.exact = list(inverse_dynamics(model, state, udot))
        for speed, x, a in zip(model.speeds, u, udot, strict=True):
            values[speed.symbol] = x
            values[speed.acceleration] = a
        rates = set(self.rates)
        self.steady_values = {a: x for a, x in values.items() if a not in rates}
        self.steady_values.update({a: ring.generator(a) for a in self.rates if a in values})

    def _unknowns(self) -> tuple[Any, ...]:
        used = frozenset().union(*(self.ring.atoms_of(x) for x in self.conditions), ())
        rates = [rate for rate in self.rates if rate not in self.replaced]
        places = [a for turning in self.turnings for a in turning.place if a is not None]
        q = [self.coordinates[k] for k in self.scalars.values() if self.coordinates[k] not in self.gauge]
        order = [*rates, *self.unknown_angles, *places, *q, *self.terms]
        return tuple(atom for atom in order if atom in used)

    @property
    def named(self) -> tuple[Any, ...]:
        """The unknowns, and the angles, rates and terms that may have any value."""
        more = [
            a
            for a in (*self.rates, *self.unknown_angles, *self.terms)
            if a not in self.replaced and a not in self.unknowns
        ]
        return (*self.unknowns, *more)

    def name(self, atom: Any) -> str:
        """Return the name of an unknown."""
        return self.names.get(atom) or super().name(atom)

    # -- numbers ----------------------------------------------------------------------------------

    def completed(self, full: Mapping[Any, Any]) -> dict[Any, Any]:
        """Return the quaternions at the angles of a steady motion, by atom."""
        model = self.e.model
        result = {}
        for turning in self.turnings:
            link = model.links[turning.link]
            start = link.quaternion
            e: Any = (1, 0, 0, 0)
            for axis, atom in turning.turns:
                half = 0 if atom is None else float(full.get(atom, 0)) / 2
                e = quaternion_product(e, (np.cos(half), *(x * np.sin(half) for x in axis)))
            result.update({self.coordinates[start + k]: float(x) for k, x in enumerate(e)})
        return result

    def defaults(self) -> dict[Any, Any]:
        """Return zero for angles and rates that nothing determines."""
        return dict.fromkeys((*self.unknown_angles, *self.rates), 0)

    def distinct(self, states: Sequence[Any], atoms: Mapping[Any, Any]) -> Sequence[Any]:
        """Return one of the states that agree in kinetic and potential energy, rates and all eigenvalues.

        The others are the same motion, turned or mirrored: the angles (θ, φ) and (-θ, φ + π) are equivalent, and
        symmetries leave some angles free.
        """
        distinct: list[tuple[np.ndarray, Any]] = []
        for state in sorted(states, key=lambda s: sum(x < 0 for x in s.values.values())):
            mark = self._mark(state, atoms)
            scale = 1 + np.abs(mark).max(initial=0)
            if not any(
                len(mark) == len(other) and np.abs(mark - other).max(initial=0) <= SAME * scale
                for other, _ in distinct
            ):
                distinct.append((mark, state))
        representatives = {id(state) for _, state in distinct}
        return [state for state in states if id(state) in representatives]

    def _mark(self, steady: Any, atoms: Mapping[Any, Any]) -> np.ndarray:
        model = self.e.model
        q, u = ([steady.state[x] for x in names] for names in (model.coordinate_names, model.speed_names))
        state = State(model, floats, 0, q, u, atoms)
        energies = [float(kinetic_energy(model, state)), float(potential_energy(model, state))]
        eigenvalues = steady.stability.eigenvalues
        # compare the coefficients of the polynomial: its double roots are known only to the square root of round-off
        rates = [steady.values[self.name(a)] for a in self.rates if self.name(a) in steady.values]
        return np.array([*energies, *np.poly(eigenvalues).real, *rates])


class _NoClosedForm:
    """Stand-in for `Linear` and `Amended`: no closed forms of stability."""

    def singular(self, values: Any) -> bool:
        """Return False."""
        return False

    def characteristic(self, values: Any, s: Any) -> None:
        """Return None."""
        return None

    def curvature(self, values: Any) -> None:
        """Return None."""
        return None


class TurningStability:
    """Stability of the steady motions of a `TurningProblem`: by eigenvalues, in numbers only."""

    def __init__(self, problem: TurningProblem) -> None:
        self._problem = problem
        self.linear = self.amended = _NoClosedForm()

    def at(self, full: Mapping[Any, Any], family: int = 0) -> Stability:
        """Return the stability by eigenvalues, in axes that do not spin with the bodies: there C and K are constant."""
        spectrum = self._spectrum(full)
        if spectrum is None:
            return Stability("singular", "undecided", np.zeros(0, dtype=complex), None)
        if any(self._upright(turning, full) for turning in self._problem.turnings):
            family = 0  # there the angles may be free although the motion is isolated
        verdict = spectral_verdict(spectrum, 2 * len(self._problem.rates), family)
        return Stability(verdict, "undecided", spectrum.values, None, family)

    def _upright(self, turning: Turning, full: Mapping[Any, Any]) -> bool:
        """Return True if the axis b is vertical: the turns about n and about b are then the same."""
        (_, (a, theta), (b, _)) = turning.turns
        angle = float(full[theta])
        n, b_n = (np.array(v, dtype=float) for v in (turning.vertical, b))
        turned = b_n * np.cos(angle) + np.cross(np.array(a, dtype=float), b_n) * np.sin(angle)
        return bool(np.abs(np.cross(n, turned)).max() < SAME)

    def _spectrum(self, full: Mapping[Any, Any]) -> Spectrum | None:
        model = self._problem.e.model
        numbers = {p.symbol: float(full[p.symbol]) for p in model.parameters}
        q = [float(full[c]) for c in self._problem.coordinates]
        u = [float(full[s.symbol]) for s in model.speeds]
        udot = [float(full[s.acceleration]) for s in model.speeds]
        terms = terms_at(model, floats, q, u, udot, 0, numbers, ())
        M, C, K = (np.array(terms[key], dtype=float).reshape(model.n_u, model.n_u) for key in "MCK")
        if not len(M) or np.linalg.cond(M) > 1 / np.sqrt(np.finfo(float).eps):
            return None
        A = np.array(tangent_drift(model, u), dtype=float)
        back = np.zeros_like(A)
        for turning in self._problem.turnings:
            if turning.spin is None:
                continue
            x, y, z = (float(full[turning.spin]) * c for c in turning.axis)
            skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            link = model.links[turning.link]
            for first in (link.u, link.u + 3)[: 2 if link.flies else 1]:
                back[first : first + 3, first : first + 3] = skew
        n = model.n_u
        top = np.hstack([A + back, np.eye(n)])
        low = np.hstack([-np.linalg.solve(M, K), back - np.linalg.solve(M, C)])
        return Spectrum.of(np.vstack([top, low]), M, C, K)
