"""Stability of steady motions: by eigenvalues of the linearised equations, and by energy.

Small deviations from a steady motion, without δq along the symmetries, satisfy

    M δu' + C δu + K δq = 0,      M = ∂E/∂u',  C = ∂E/∂u,  K = ∂E/∂q,

with exact coefficients, since E are canonical polynomials. For a conservative system the amended potential W = -R
(Routhian at rest, with constant momenta) is stationary. The motion is stable if the second derivative of W is positive
definite, and unstable if it has an odd number of negative eigenvalues.

Sources: E. J. Routh, Stability of a Given State of Motion (1877); J. E. Marsden, Lectures on Mechanics (1992), §5.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
import sympy

from ...scalar.algebra import HALF, Scalar
from ...scalar.polynomial import Polynomial
from ...scalar.series import Series, SeriesField
from ...scalar.substitute import Substitution, arrays
from ..derivation.determinant import determinant
from ..integrals.conserved_quantities import integrals
from ..integrals.routh import Routh, ignorable
from ..printing.lines import COMMA, Lines
from .factors import coefficients, fraction, signed_part
from .problem import Problem

EPS = float(np.finfo(float).eps)
LARGEST = 4
"""Largest number of speeds for which determinants are formed in closed form."""


@dataclass(frozen=True)
class Stability(Lines):
    """Verdicts on the stability of one steady motion.

    Attributes
    ----------
    spectral : str
        "asymptotically stable", "stable" (in the linear approximation: all eigenvalues are on the imaginary axis),
        "unstable", "undecided" (more zeros than symmetries, or rolling on which positions depend), or "singular" (the
        coordinates are singular). For a member of a family it applies to deviations from the family.
    energy : str
        "stable" (definite energy), "unstable" (odd number of negative eigenvalues), or "undecided".
    eigenvalues : ndarray of complex, [1/s]
    stiffness : ndarray or None
        Eigenvalues of the second derivative of the amended potential.
    family : int
        Dimension of the continuous family to which the steady motion belongs; 0 if it is isolated.
    """

    spectral: str
    energy: str
    eigenvalues: np.ndarray
    stiffness: np.ndarray | None
    family: int = 0

    @property
    def verdict(self) -> str:
        """The stronger statement of the two: "stable" by energy holds for the nonlinear equations.

        A member of a family is "neutral along the family" unless it is unstable: from a neighbouring member the machine
        does not return.
        """
        if self.family and "unstable" not in (self.spectral, self.energy):
            return "neutral along the family"
        if self.spectral in ("unstable", "asymptotically stable"):
            return self.spectral
        if self.energy != "undecided":
            return self.energy
        return "undecided" if self.spectral == "singular" else self.spectral

    def _lines(self) -> list[list[Scalar]]:
        lines: list[list[Scalar]] = [[str(self)]]
        if len(self.eigenvalues):
            lines.append(["eigenvalues: ", *_listed(self.eigenvalues.tolist())])
        if self.stiffness is not None:
            lines.append(["second derivatives of the amended potential: ", *_listed(self.stiffness.tolist())])
        return lines

    def __str__(self) -> str:
        shown = f"{self.verdict} (spectral: {self.spectral}; energy: {self.energy})"
        return f"one of a family of dimension {self.family}, {shown}" if self.family else shown


def _listed(values: Sequence[Any]) -> list[Any]:
    return [piece for x in values for piece in (x, COMMA)][:-1]


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues of M q'' + C q' + K q = 0, and a bound of their size from its entries.

    Attributes
    ----------
    values : ndarray of complex
    scale : float
        max(|C|/|M|, sqrt(|K|/|M|)) of the matrices before constraints are eliminated.
    damped : bool
        True if forces depend on speeds; otherwise every zero is double.
    """

    values: np.ndarray
    scale: float
    damped: bool

    @classmethod
    def of(cls, A: np.ndarray, M: np.ndarray, C: np.ndarray, K: np.ndarray) -> Spectrum:
        """Return the spectrum of A, the first-order matrix of M, C and K."""
        roots = np.linalg.eigvals(A)
        m, c, k = (float(np.abs(x).max(initial=0)) for x in (M, C, K))
        scale = max(c / m, (k / m) ** float(HALF)) if m else 0
        return cls(roots[np.lexsort((roots.imag, roots.real))], scale, c > EPS * scale * m)


class Linear:
    """Exact coefficients of the equations of a problem, linearised about any of its steady motions."""

    def __init__(self, problem: Problem) -> None:
        p = self.problem = problem
        e, derivative = p.e, p.ring.derivative
        self.speeds = [e.model.speeds[j] for j in p.free]
        self.q = [p.coordinates[p.coordinate_of[j]] for j in p.free]
        self.M = [[derivative(E, s.acceleration) for s in self.speeds] for E in p.residuals]
        self.C = [[derivative(E, s.symbol) for s in self.speeds] for E in p.residuals]
        self.K = [[derivative(E, c) for c in self.q] for E in p.residuals]
        # a motion along a family does not change K: use the relative coordinates q_r - ξ_r q_pivot
        self.relative = [k for k, j in enumerate(p.free) if j not in p.pivots]

    def matrices(self, atoms: Mapping[Any, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return M, C and K in numbers."""
        at = Substitution(self.problem.ring, arrays, atoms)
        return tuple(np.array([[float(at(x)) for x in row] for row in A]) for A in (self.M, self.C, self.K))  # type: ignore[return-value]

    def spectrum(self, atoms: Mapping[Any, Any]) -> Spectrum | None:
        """Return the spectrum of small deviations; None if the mass matrix is singular."""
        p = self.problem
        M, C, K = whole = self.matrices(atoms)
        n = len(M)
        if not all(np.isfinite(A).all() for A in whole):  # a law without a slope, as |y| at zero
            return Spectrum(np.full(n, np.nan, dtype=complex), 0, False)
        if p.matrix:
            at = Substitution(p.ring, arrays, atoms)
            G = np.array([[float(at(row[j])) for j in p.free] for row in p.matrix])
            _, size, V = np.linalg.svd(G)
            N = V[int((size > np.sqrt(EPS) * size.max(initial=0)).sum()) :].T
            M, C, K = N.T @ M @ N, N.T @ C @ N, N.T @ K @ N
            n = len(M)
            R, S = np.zeros((n, n)), np.eye(n)
        else:
            r = self.relative
            R = np.zeros((len(r), len(r)))
            S = np.eye(n)[r]
            index = {j: k for k, j in enumerate(p.free)}
            for family, pivot in zip(p.families, p.pivots, strict=True):
                for j, x in family.items():
                    if j != pivot:
                        S[r.index(index[j]), index[pivot]] -= float(x)
            K = K[:, r]
        if n == 0:
            return Spectrum(np.zeros(0, dtype=complex), 0, False)
        scale = np.sqrt(np.abs(M).max(initial=0))
        if scale == 0 or np.linalg.cond(M) > 1 / np.sqrt(EPS):
            return None
        A = np.block([[R, S], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
        return Spectrum.of(A, *whole)

    def characteristic(self, values: Mapping[Any, Scalar], s: Any) -> list[Scalar] | None:
        """Return the coefficients, lowest first, of det(M s² + C s + K) on a steady motion, without its zero roots.

        None for systems with constraints, more than four speeds, or singular coordinates.
        """
        p = self.problem
        if p.matrix or p.coupled or len(self.speeds) > LARGEST:
            return None
        ring = p.ring
        M, C, K = (self._steady(A, values) for A in (self.M, self.C, self.K))
        if determinant(M) == 0:
            return None
        z = ring.generator(s, "parameter")
        n = range(len(M))
        det = ring.coerce(determinant([[(M[i][j] * z + C[i][j]) * z + K[i][j] for j in n] for i in n]))
        in_s = coefficients(ring, ring.coerce(fraction(ring, det)[0]), ring.find(s).index)  # type: ignore[union-attr]
        lowest = min(in_s)
        return [in_s.get(k, 0) for k in range(lowest, max(in_s) + 1)]

    def _steady(self, A: Sequence[Sequence[Scalar]], values: Mapping[Any, Scalar]) -> list[list[Scalar]]:
        """Return a matrix on a steady motion, canonical."""
        p = self.problem
        steady = Substitution(p.ring, p.ring, p.steady_values)
        again = Substitution(p.ring, p.ring, p.replaced)
        put_in = Substitution(p.ring, p.ring, values)
        return [[put_in(again(steady(x))) for x in row] for row in A]

    def singular(self, values: Mapping[Any, Scalar]) -> bool:
        """Return True if the coordinates are singular at a steady motion: det M = 0, or M has no value.

        Only determined for up to four speeds.
        """
        if len(self.speeds) > LARGEST:
            return False
        try:
            return determinant(self._steady(self.M, values)) == 0
        except ZeroDivisionError:
            return True


def hurwitz(problem: Problem, c: Sequence[Scalar]) -> list[Scalar] | None:
    """Return what must be positive so that all roots of Σ c_k s^k are on the imaginary axis or left of it.

    For polynomials in s² of degree 2 or 4 (conservative systems): the squares are real and negative. For others up to
    degree 4: the Routh-Hurwitz conditions. None beyond.
    """
    ring = problem.ring
    if len(c) == 1:
        return []
    lead = c[-1]
    if all(x == 0 for x in c[1::2]):
        d = c[::2]
        if len(d) == 2:
            raw = [d[0] * lead]
        elif len(d) == 3:
            raw = [d[0] * lead, d[1] * lead, d[1] * d[1] - 4 * d[0] * d[2]]
        else:
            return None
    elif len(c) == 2:
        raw = [c[0] * lead]
    elif len(c) == 3:
        raw = [c[0] * lead, c[1] * lead]
    elif len(c) == 4:
        raw = [c[0] * lead, c[2] * lead, c[1] * c[2] - c[0] * c[3]]
    elif len(c) == 5:
        raw = [
            c[0] * lead,
            c[1] * lead,
            c[3] * lead,
            lead * (c[1] * c[2] * c[3] - c[4] * c[1] ** 2 - c[0] * c[3] ** 2),
        ]
    else:
        return None
    result = []
    for x in raw:
        y = signed_part(ring, x)
        if (type(y) is Polynomial or y <= 0) and y not in result:
            result.append(y)
    return result


class Amended:
    """The canonical amended potential W(q; p) of a conservative problem, with the momenta p of its rates."""

    def __init__(self, problem: Problem) -> None:
        e = problem.e
        self.problem = problem
        self.potential: Scalar = None
        pivots = set(problem.pivots)
        conserved = integrals(e)
        conservative = any(name in conserved.names for name in ("energy", "Jacobi's integral"))
        if (
            not conservative
            or problem.dependent
            or problem.matrix
            or any(len(f) > 1 for f in problem.families)
        ):
            return
        if not pivots <= set(ignorable(e)):
            return
        remaining_speeds = [s.symbol for j, s in enumerate(e.model.speeds) if j not in pivots]
        if pivots:
            routh = Routh(e, problem.pivots)
            self.potential = routh.canonical_amended_potential
            self.symbols = routh.momenta
        else:
            at_rest = Substitution(e.ring, e.ring, dict.fromkeys(remaining_speeds, 0))
            self.potential = e.energy.canonical_potential - at_rest(e.energy.canonical_kinetic)
            self.symbols = ()
        self.momenta = [e.ring.derivative(e.energy.canonical_kinetic, rate) for rate in problem.rates]
        self.q = [c for c in problem.coordinates if c not in problem.gauge]

    def stiffness(self, atoms: Mapping[Any, Any]) -> np.ndarray | None:
        """Return the eigenvalues of ∂²W/∂q² in numbers, at constant momenta."""
        if self.potential is None or not self.q:
            return None
        p = self.problem
        at = Substitution(p.ring, arrays, atoms)
        momenta = {symbol: float(at(x)) for symbol, x in zip(self.symbols, self.momenta, strict=True)}
        full = Substitution(p.ring, arrays, {**atoms, **momenta})
        first = [p.ring.derivative(self.potential, c) for c in self.q]
        with np.errstate(all="ignore"):
            H = np.array([[float(full(p.ring.derivative(x, c))) for c in self.q] for x in first])
        if np.isfinite(H).all():
            return np.linalg.eigvalsh((H + H.T) * float(HALF))
        return None

    def singular(self, atoms: Mapping[Any, Any]) -> np.ndarray | None:
        """Return the limit of ∂²W/∂q² (its sign) at a multiple of a right angle with singular coordinates."""
        if self.potential is None or len(self.q) != 1:
            return None
        p = self.problem
        quarter = float(atoms[self.q[0]]) / float(np.pi) * 2
        if abs(quarter - round(quarter)) > np.sqrt(EPS):
            return None
        x = self.curvature({self.q[0]: p.ring.constant("pi") * Fraction(round(quarter), 2)})
        if x is None:
            return None
        terms = {symbol: Substitution(p.ring, arrays, atoms)(y) for symbol, y in p.terms.items()}
        return np.array([float(Substitution(p.ring, arrays, {**atoms, **terms})(x))])

    def curvature(self, values: Mapping[Any, Scalar]) -> Any:
        """Return a canonical element with the sign of ∂²W/∂q² at a steady motion, for one coordinate; None if unknown.

        W is expanded in powers of the deviation, which gives the limit if the coordinates are singular.
        """
        if self.potential is None or len(self.q) != 1:
            return None
        p = self.problem
        ring = p.ring
        steady = Substitution(ring, ring, p.steady_values)
        again = Substitution(ring, ring, p.replaced)
        put_in = Substitution(ring, ring, values)
        (q,) = self.q
        # if the coordinate is free, its steady value needs a symbol different from the varying coordinate
        steady_value = sympy.Symbol("_steady", real=True)
        separate = Substitution(ring, ring, {q: ring.generator(steady_value, "parameter")})
        momenta = {
            symbol: separate(put_in(again(steady(x))))
            for symbol, x in zip(self.symbols, self.momenta, strict=True)
        }
        values = {a: separate(v) for a, v in values.items()}
        start = separate(put_in(ring.generator(q)))
        put_in_others = Substitution(ring, ring, {**momenta, **{a: v for a, v in values.items() if a != q}})
        N, D = fraction(ring, put_in_others(self.potential))
        order = 8
        field = SeriesField(ring, order)
        along = _AlongSeries(ring, field, q, field.series([start, 1]))
        top, bottom = ((x.c if isinstance(x, Series) else (x, *(0,) * order)) for x in (along(N), along(D)))
        k = next((i for i, x in enumerate(bottom) if x != 0), None)
        if k is None or k + 2 > order or any(x != 0 for x in top[:k]):
            return None
        quotient: list[Any] = []
        for i in range(3):
            total = top[k + i]
            for j in range(i):
                total = total - quotient[j] * bottom[k + i - j]
            quotient.append(ring.quotient(ring.coerce(total), ring.coerce(bottom[k])) if total != 0 else 0)
        back = Substitution(ring, ring, {steady_value: ring.generator(q)})
        N, D = fraction(ring, back(2 * quotient[2]))
        return signed_part(ring, N * D)


class _AlongSeries(Substitution):
    """Substitution of a series for one atom; all others stay as they are."""

    def __init__(self, ring: Any, field: SeriesField, atom: Any, series: Series) -> None:
        super().__init__(ring, field, {atom: series})
        self._moving = 1 << ring.find(atom).index

    def _make(self, index: int) -> Any:
        g = self.ring.generators[index]
        return super()._make(index) if g.depends & self._moving else self.ring.variable(index)


class ProblemStability:
    """Stability of the steady motions of one problem: by eigenvalues and by energy."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem

    @cached_property
    def linear(self) -> Linear:
        """The linearised equations about any of the motions."""
        return Linear(self._problem)

    @cached_property
    def amended(self) -> Amended:
        """The amended potential."""
        return Amended(self._problem)

    def at(self, atoms: Mapping[Any, Any], family: int = 0) -> Stability:
        """Stability of one steady motion in numbers, a member of a family of dimension ``family``."""
        problem = self._problem
        spectrum = self.linear.spectrum(atoms)
        eigenvalues = np.zeros(0, dtype=complex) if spectrum is None else spectrum.values
        if spectrum is None:
            spectral, family = "singular", 0
        elif problem.coupled:
            spectral = "undecided"
        else:
            zeros = len(problem.families) * (2 if problem.matrix else 1)
            spectral = spectral_verdict(spectrum, zeros, family)
        stiffness = self.amended.stiffness(atoms) if spectral != "singular" else self.amended.singular(atoms)
        energy = "undecided"
        if stiffness is not None:
            small = np.sqrt(EPS) * np.abs(stiffness).max(initial=0)
            if (stiffness > small).all():
                energy = "stable"
            elif (np.abs(stiffness) > small).all() and int((stiffness < 0).sum()) % 2:
                energy = "unstable"
        return Stability(spectral, energy, eigenvalues, stiffness, family)


def spectral_verdict(spectrum: Spectrum, zeros: int, family: int = 0) -> str:
    """Return the verdict of eigenvalues, of which ``zeros`` are zero by the symmetries and others along a family.

    A family of dimension k has k zeros, which are double if no force depends on speeds.
    """
    eigenvalues = spectrum.values
    if np.isnan(eigenvalues).any():
        return "undecided"
    scale = np.abs(eigenvalues).max(initial=0)
    if family:
        scale = max(scale, spectrum.scale)
        eigenvalues = eigenvalues[np.argsort(np.abs(eigenvalues), kind="stable")][
            family * (1 if spectrum.damped else 2) :
        ]
        zeros += family if spectrum.damped else 0
    # a double eigenvalue is known to the square root of round-off
    small = 16 * np.sqrt(EPS) * scale
    if (eigenvalues.real > small).any():
        return "unstable"
    if int((np.abs(eigenvalues) <= small).sum()) > zeros:
        return "undecided"
    nonzero = eigenvalues[np.abs(eigenvalues) > small]
    return "asymptotically stable" if len(nonzero) and (nonzero.real < -small).all() else "stable"
