"""The linear equations of small motions: matrices, modes, response and printing.

    M ξ'' + C ξ' + K ξ = B f

C splits into the damping (symmetric) and the gyroscopic (skew) part, K into the stiffness (symmetric) and the
circulatory (skew) part. The gyroscopic part does no work; the energy ½ ξ'ᵀM ξ' + ½ ξᵀS ξ changes at the rate
-ξ'ᵀD ξ' of damping and -ξ'ᵀN ξ of circulatory forces.

Source: Meirovitch, Methods of Analytical Dynamics (1970), §8.2; Merkin, Introduction to the Theory of Stability (1997),
§6.1.

The file is longer than others: one class holds the equations and all their products.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import sympy

from ...dynamics.linear import Factorization
from ...errors import ModelError
from ...model.model import Model
from ...model.values import check_assumptions
from ...rooms_above import module_for
from ...scalar.algebra import Expression
from ...scalar.polynomial import Ring
from ..printing.display import displayed, equation_latex, equation_text
from ..printing.show import aligned
from ..printing.typeset import Typeset
from . import characteristic, linear_text, modes, response
from .modes import Modes
from .operating_point import SINGULAR
from .response import ExactResponse, Response
from .state_space import StateSpace


class LinearModel(Typeset):
    """Linear equations of small motions. Made by :func:`freebody.linearize`.

    A symbolic model has SymPy matrices, a numeric one has arrays. Along a trajectory, or with arrays of values, the
    axes of the times or of the values come first; ``linear[k]`` is the model at one of them.

    Attributes
    ----------
    M, C, K : matrix (n, n)
        Mass, velocity and displacement matrix.
    B : matrix (n, m)
        Generalized forces per unit of each input.
    damping, gyroscopic : matrix (n, n)
        Symmetric and skew part of C.
    stiffness, circulatory : matrix (n, n)
        Symmetric and skew part of K.
    coordinates : tuple of str
        Names of the deviations ξ.
    carried : tuple of str
        For machines with constraints on speeds: further deviations with c' = E (ξ, c) + E_r ξ'.
    inputs : tuple of str
    point : dict
        The operating point: coordinates and speeds by name.
    times : ndarray or None
        Times of a model along a trajectory [s].
    """

    def __init__(
        self,
        model: Model,
        names: Sequence[str],
        inputs: Sequence[str],
        terms: Mapping[str, Any],
        *,
        ring: Ring | None = None,
        point: Mapping[str, Any] | None = None,
        values: Mapping[str, float] | None = None,
        times: Any = None,
        carried: Sequence[str] = (),
    ) -> None:
        self.model = model
        self.coordinates = tuple(names)
        self.inputs = tuple(inputs)
        self.carried = tuple(carried)
        self.ring = ring
        self.point = dict(point or {})
        self.values = dict(values or {})
        self.times = times
        self.canonical = dict(terms)
        self._shown: dict[Any, Any] = {}  # canonical polynomials as SymPy expressions

    @property
    def symbolic(self) -> bool:
        """True if the matrices are exact expressions."""
        return self.ring is not None

    @property
    def rates(self) -> tuple[str, ...]:
        """Names of the rates ξ'."""
        return tuple(f"{name}'" for name in self.coordinates)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states of the first-order form: ξ, the carried deviations, ξ'."""
        return (*self.coordinates, *self.carried, *self.rates)

    @property
    def _shape(self) -> tuple[int, ...]:
        """Shape of the times of a trajectory or of the arrays of values; () for one state or symbols."""
        return () if self.ring is not None else np.shape(self.canonical["M"])[:-2]

    def __getitem__(self, index: Any) -> LinearModel:
        """Return the linear equations at some of many values or times, by index."""
        if not self._shape:
            raise ModelError(
                f"The linear equations of '{self.model.name}' are of one state: they have no index."
            )

        def part(x: Any) -> Any:
            return x[index] if np.shape(x)[: len(self._shape)] == self._shape else x

        return LinearModel(
            self.model,
            self.coordinates,
            self.inputs,
            {key: x if key == "chosen" else x[index] for key, x in self.canonical.items()},
            point={name: part(x) for name, x in self.point.items()},
            values={name: part(x) for name, x in self.values.items()},
            times=None if self.times is None else self.times[index],
            carried=self.carried,
        )

    # -- matrices ---------------------------------------------------------------------------------

    def _matrix(self, rows: Any, columns: int) -> Any:
        if self.ring is None:
            return np.asarray(rows, dtype=float)
        shown = self._shown
        for row in rows:
            for x in row:
                if x not in shown:
                    shown[x] = displayed(x, self.ring)
        return sympy.ImmutableMatrix(len(rows), columns, [shown[x] for row in rows for x in row])

    def _part(self, name: str, sign: int) -> Any:
        """Half the sum (``sign`` 1) or the difference (-1) of a matrix and its transpose."""
        X = self.canonical[name]
        if self.ring is None:
            return (X + sign * np.swapaxes(X, -1, -2)) / 2
        n = len(X)
        return self._matrix(
            [[self.ring.coerce(X[i][j] + sign * X[j][i]) / 2 for j in range(n)] for i in range(n)], n
        )

    @cached_property
    def M(self) -> Any:
        """Mass matrix."""
        return self._matrix(self.canonical["M"], len(self.coordinates))

    @cached_property
    def C(self) -> Any:
        """Velocity matrix: damping and gyroscopic part together."""
        return self._matrix(self.canonical["C"], len(self.coordinates))

    @cached_property
    def K(self) -> Any:
        """Displacement matrix: stiffness and circulatory part together."""
        return self._matrix(self.canonical["K"], len(self.coordinates))

    @cached_property
    def B(self) -> Any:
        """Input matrix."""
        return self._matrix(self.canonical["B"], len(self.inputs))

    @cached_property
    def damping(self) -> Any:
        """Symmetric part of C."""
        return self._part("C", 1)

    @cached_property
    def gyroscopic(self) -> Any:
        """Skew part of C."""
        return self._part("C", -1)

    @cached_property
    def stiffness(self) -> Any:
        """Symmetric part of K."""
        return self._part("K", 1)

    @cached_property
    def circulatory(self) -> Any:
        """Skew part of K."""
        return self._part("K", -1)

    # -- other forms ------------------------------------------------------------------------------

    def numeric(self, values: Mapping[Any, Expression] | None = None) -> LinearModel:
        """Return these equations in numbers.

        Parameters
        ----------
        values : mapping, optional
            Numbers by name or symbol, also for symbols of the operating point; other parameters have their
            default values.
        """
        if self.ring is None:
            return self
        numbers_by_name = {str(key): sympy.sympify(value) for key, value in (values or {}).items()}
        for p in self.model.parameters:
            if p.default is not None:
                numbers_by_name.setdefault(p.name, sympy.Float(p.default))
        terms = {}
        widths = {"B": len(self.inputs), "K_carried": len(self.carried)}
        for key in ("M", "C", "K", "B", *(("K_carried", "E", "E_rates") if self.carried else ())):
            width = widths.get(key, len(self.coordinates) + (len(self.carried) if key == "E" else 0))
            matrix = self._matrix(self.canonical[key], width)
            replacements = {
                x: numbers_by_name[str(x)] for x in matrix.free_symbols if str(x) in numbers_by_name
            }
            missing = sorted(str(x) for x in matrix.free_symbols if str(x) not in numbers_by_name)
            if missing:
                raise ModelError(
                    f"No value for {', '.join(missing)} in the linear equations. Give values={{'{missing[0]}': ...}}."
                )
            terms[key] = np.array(matrix.xreplace(replacements).evalf().tolist(), dtype=float).reshape(
                matrix.shape
            )
        numbers = {name: float(value) for name, value in numbers_by_name.items()}
        if all(p.name in numbers for p in self.model.parameters):
            check_assumptions(self.model, numbers)
        return LinearModel(
            self.model,
            self.coordinates,
            self.inputs,
            terms,
            point=self.point,
            values=numbers,
            carried=self.carried,
        )

    @cached_property
    def first_order(self) -> tuple[Any, Any]:
        """Matrices A and B of x' = A x + B f, where x are the :attr:`states`."""
        if self.ring is None:
            return _first_order(self.canonical, len(self.coordinates), len(self.carried))
        n, m = len(self.coordinates), len(self.inputs)
        try:
            factors = Factorization(self.canonical["M"])
            singular = any(pivot == 0 for pivot in factors.D)
        except ZeroDivisionError:
            singular = True
        if singular:
            raise ModelError(SINGULAR.format(self.model.name))
        solve = factors.solve
        ring = self.ring
        c = len(self.carried)
        blocks = {}
        for key, width in (("K", n), ("K_carried", c), ("C", n), ("B", m)):
            rows = self.canonical[key] if width else [[] for _ in range(n)]
            columns = [solve([ring.coerce(row[j]) for row in rows]) for j in range(width)]
            sign = 1 if key == "B" else -1
            blocks[key] = [[sign * column[i] for column in columns] for i in range(n)]
        size = 2 * n + c
        top = [[int(j == n + c + i) for j in range(size)] for i in range(n)]
        follow = [[*self.canonical["E"][i], *self.canonical["E_rates"][i]] for i in range(c)]
        last = [[*blocks["K"][i], *blocks["K_carried"][i], *blocks["C"][i]] for i in range(n)]
        A = self._matrix([*top, *follow, *last], size)
        return A, self._matrix([*([0] * m for _ in range(n + c)), *blocks["B"]], m)

    def state_space(self, outputs: Sequence[str] | None = None) -> StateSpace:
        """Return x' = A x + B f, y = C x + D f with the names of states, inputs and outputs.

        Parameters
        ----------
        outputs : names, optional
            Coordinates, carried deviations and rates; all states by default.
        """
        self._require_one_state("state_space()")
        A, B = self.first_order
        return StateSpace.of(A, B, self.states, self.inputs, outputs)

    def _require_one_state(self, what: str) -> None:
        if self._shape and self.times is not None:
            raise ModelError(
                f"The linear equations along a trajectory change with time; {what} is for one instant. "
                "Linearise about trajectory.at(t), or about a steady motion."
            )
        if self._shape:
            raise ModelError(
                f"These are the linear equations at {' x '.join(map(str, self._shape))} values; {what} is for one. "
                "Take one by its index, such as linear[0], or use eigenvalues(), which gives those of all."
            )

    # -- modes ------------------------------------------------------------------------------------

    @cached_property
    def characteristic(self) -> characteristic.Characteristic:
        """det(M s² + C s + K) of a symbolic model, factored."""
        if self.ring is None:
            raise ModelError(
                "A numeric model has no characteristic polynomial in symbols; use eigenvalues(), or leave out values=."
            )
        polynomial = characteristic.of(self.ring, self.canonical, len(self.coordinates), len(self.carried))
        degree = 2 * len(self.coordinates) + len(self.carried)
        if len(polynomial.coefficients) <= degree:  # det M is the first of them
            raise ModelError(SINGULAR.format(self.model.name))
        return polynomial

    def eigenvalues(self) -> Any:
        """Roots s of det(M s² + C s + K) = 0 [1/s].

        Numeric: a complex array, by magnitude; roots at zero (rigid-body modes and constant rates) are exactly zero.
        Along a trajectory, or at arrays of values: the eigenvalues at each of them. Symbolic: a list with repetitions,
        if the factors of the characteristic polynomial can be solved.
        """
        if self.ring is not None:
            return self.characteristic.roots()
        if self._shape:
            A = self.first_order[0]
            return np.array([modes.eigenvalues(a) for a in A.reshape(-1, *A.shape[-2:])]).reshape(
                A.shape[:-1]
            )
        return self.modes().all_eigenvalues

    def natural_frequencies(self) -> Any:
        """Natural frequency |s| of each mode [rad/s], lowest first; zero for a rigid-body mode.

        Numeric: an array with one entry for a pair of complex roots, for each real root, and for each rigid-body
        mode. Symbolic: a list of expressions, for pairs of roots.
        """
        if self.ring is not None:
            return self.characteristic.frequencies()
        return np.array([mode.frequency for mode in self.modes() if mode.kind != "drift"])

    def damping_ratios(self) -> Any:
        """Damping ratio -Re s / |s| of each mode, in the order of :meth:`natural_frequencies`."""
        if self.ring is not None:
            return self.characteristic.damping_ratios()
        return np.array([mode.damping_ratio for mode in self.modes() if mode.kind != "drift"])

    def modes(self) -> Modes:
        """Return frequency, damping ratio and mode shape of every mode, lowest frequency first.

        A mode shape is divided by its component of largest magnitude (numeric) or by its first nonzero component
        (symbolic).
        """
        self._require_one_state("modes()")
        return self._modes

    @cached_property
    def _modes(self) -> Modes:
        return characteristic.modes_of(self) if self.ring is not None else modes.modes_of(self)

    def animate(self, mode: int = 0, *, amplitude: float | None = None, **shown: Any) -> Any:
        """Return the motion of the machine in one of its modes as an animation.

            q(t) = q_0 + u_0 t + a Re(X e^(i ω t))

        Parameters
        ----------
        mode : int
            Number of the mode in :meth:`modes`, from 0.
        amplitude : float, optional
            a, for the shape X as :meth:`modes` gives it; by default as large as the eye needs.
        **shown : bool
            Switches, and ``height``, as for :meth:`freebody.Trajectory.animate`.

        Returns
        -------
        Animation
            Notebooks show it; ``.save(path)`` writes ``.html``, ``.gif`` or ``.mp4``.

        Raises
        ------
        ModelError
            Linear equations in symbols, a mode that does not move, coordinates that are components of a quaternion.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("pendulum")
        >>> s.gravity = (0, "-9.81", 0)
        >>> bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
        >>> pin = s.hinge("pin", s.ground, bar, to=(0, 1, 0), coordinate="theta")
        >>> fb.linearize(s, values={}).animate(0)
        Animation of 'pendulum, mode 0', 0 to 6.94922 s
        """
        return module_for("animate").animate_mode(self, mode, amplitude=amplitude, **shown)

    # -- response ---------------------------------------------------------------------------------

    def response(
        self, initial: Mapping[Any, Expression] | None = None, forcing: Mapping[Any, Expression] | None = None
    ) -> ExactResponse | Response:
        """Return the motion from initial deviations and under inputs, in closed form.

        Parameters
        ----------
        initial : mapping, optional
            Initial deviations, by the names of :attr:`coordinates` and :attr:`rates` (or of the speeds): numbers
            or expressions. Those not named are zero.
        forcing : mapping, optional
            Inputs by name, as sums of t^k e^(a t) cos(w t) or sin(w t): ``{"F": "cos(2*t)/10"}``. Text may contain
            names of the model, a SymPy expression any symbol.

        Returns
        -------
        ExactResponse or Response
            For a symbolic model: SymPy expressions of ``t`` by name, by partial fractions. For a numeric one: a
            function of time.

        Raises
        ------
        ModelError
            Unknown names, an input of another form, a characteristic polynomial without roots in closed form.
        """
        self._require_one_state("response()")
        return response.response(self, initial or {}, forcing or {})

    # -- display ----------------------------------------------------------------------------------

    def _balances(self, ring: Ring) -> list[tuple[Any, Any]]:
        """Return left and right side of each equation as canonical polynomials of the deviations."""
        t = sympy.Symbol("t")
        atoms = [sympy.Function(name)(t) for name in self.coordinates]
        motion = {
            "M": [ring.generator(x.diff(t, 2), "acceleration") for x in atoms],
            "C": [ring.generator(x.diff(t), "speed") for x in atoms],
            "K": [ring.generator(x, "coordinate") for x in atoms],
            "B": [ring.generator(sympy.Symbol(name, real=True), "load") for name in self.inputs],
        }
        rows = []
        for i in range(len(atoms)):
            sides = {
                key: sum((y * x for x, y in zip(self.canonical[key][i], motion[key], strict=True)), 0)
                for key in motion
            }
            rows.append((sides["M"] + sides["C"] + sides["K"], sides["B"]))
        if self.carried:
            functions = [sympy.Function(name)(t) for name in self.carried]
            carried = [ring.generator(x, "coordinate") for x in functions]
            carried_rates = [ring.generator(x.diff(t), "speed") for x in functions]
            rows = [
                (a + sum((x * y for x, y in zip(row, carried, strict=True)), 0), b)
                for (a, b), row in zip(rows, self.canonical["K_carried"], strict=True)
            ]
            for x, E, E_rates in zip(
                carried_rates, self.canonical["E"], self.canonical["E_rates"], strict=True
            ):
                right = sum((y * z for y, z in zip(E, [*motion["K"], *carried], strict=True)), 0)
                rows.append((x, right + sum((y * z for y, z in zip(E_rates, motion["C"], strict=True)), 0)))
        return rows

    def text(self) -> str:
        """The linear equations as plain text, a line each."""
        self._require_one_state("text()")
        if self.ring is None:
            return linear_text.text(linear_text.rows_of(self))
        ring = self.ring
        return "\n".join(equation_text(a, b, ring) for a, b in self._balances(ring))

    def latex(self) -> str:
        """The linear equations as a LaTeX ``aligned`` block."""
        self._require_one_state("latex()")
        if self.ring is None:
            return linear_text.latex(linear_text.rows_of(self))
        ring = self.ring
        lines = [equation_latex(a, b, ring).replace(" = ", " &= ", 1) for a, b in self._balances(ring)]
        return aligned(lines)

    def _repr_latex_(self) -> str | None:
        if self._shape:
            return None
        return f"$\\displaystyle {self.latex()}$"

    def __repr__(self) -> str:
        if self._shape:
            what = "values" if self.times is None else "times"
            along = "" if self.times is None else " along a trajectory,"
            return f"Linear equations of '{self.model.name}'{along} at {int(np.prod(self._shape))} {what}"
        return f"Linear equations of '{self.model.name}'\n{self.text()}"


def _first_order(terms: Mapping[str, Any], n: int, carried: int) -> tuple[Any, Any]:
    M, C, K, B = (np.asarray(terms[key], dtype=float) for key in "MCKB")
    shape = M.shape[:-2]
    size = 2 * n + carried
    A = np.zeros((*shape, size, size))
    inputs = np.zeros((*shape, size, B.shape[-1]))
    w = slice(n + carried, size)
    A[..., :n, w] = np.eye(n)
    A[..., w, :n] = -np.linalg.solve(M, K)
    A[..., w, w] = -np.linalg.solve(M, C)
    inputs[..., w, :] = np.linalg.solve(M, B)
    if carried:
        A[..., w, n : n + carried] = -np.linalg.solve(M, terms["K_carried"])
        A[..., n : n + carried, : n + carried] = terms["E"]
        A[..., n : n + carried, w] = terms["E_rates"]
    return A, inputs
