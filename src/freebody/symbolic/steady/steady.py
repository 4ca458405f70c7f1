"""Steady motions: equilibria and relative equilibria, their conditions of existence and their stability.

The conditions are the equations of motion at constant coordinates and constant ignorable rates; see
:mod:`freebody.symbolic.steady.problem`. They are split into factors and solved in closed form if they are quadratic in
an unknown, else in numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, overload

from ...describe.system import System
from ...errors import TooManyTermsError
from ...model.model import Model
from ...scalar.algebra import Expression
from ..derivation.contact_modes import check_modes_are_chosen
from .problem import Problem
from .stability import ProblemStability
from .steady_motions import NEAR, SteadyMotions

if TYPE_CHECKING:
    from ..equations import Equations
    from .equilibrium_near import SteadyNear


@overload
def steady_motions(
    system: System | Model | Equations,
    *,
    solve_for: Any = None,
    terms: Mapping[Any, Expression] | None = None,
    values: None = None,
    near: None = None,
) -> SteadyMotions: ...


@overload
def steady_motions(
    system: System | Model | Equations,
    *,
    solve_for: Any = None,
    terms: Mapping[Any, Expression] | None = None,
    values: Mapping[Any, Expression] | None = None,
    near: Mapping[Any, Expression] | None = None,
) -> SteadyMotions | SteadyNear: ...


def steady_motions(
    system: System | Model | Equations,
    *,
    solve_for: Any = None,
    terms: Mapping[Any, Expression] | None = None,
    values: Mapping[Any, Expression] | None = None,
    near: Mapping[Any, Expression] | None = None,
) -> SteadyMotions | SteadyNear:
    """Find motions with constant coordinates, except those on which nothing depends: these have constant rates.

        E_k(q, u = Σ w_a ξ_a, u' = 0) = 0

    The unknowns of a ball or free joint ``p`` are angles: R = R_n(p_psi) R_a(p_theta) R_b(p_phi), where n is the
    vertical and b the body's axis of symmetry (n if it has none). The rates are p_psi' of the turn about the vertical
    and p_phi' of the spin, if these are symmetries, so that a body may spin while it precesses. In numbers, one motion
    is given for all that a turn or a reflection maps to each other, and one for each continuous family.

    Parameters
    ----------
    system : System, Model or Equations
    solve_for : str, symbol or sequence of them, optional
        Unknowns to solve for; by default, rates before coordinates. An unknown is a coordinate (``theta``), the rate
        of an ignorable one (``psi'``), a term, or the force of a constraint.
    terms : mapping, optional
        New names for combinations of rates, each in place of the last rate in it:
        ``{"Omega_zeta": "phi' + psi'*cos(theta)"}`` is the total spin.
    values : mapping, optional
        Parameters, and known unknowns, by name or symbol; then ``.states`` contains all roots in numbers.
    near : mapping, optional
        A guess of the coordinates by name, others zero: the result is the one equilibrium in numbers that Newton's
        method finds from it. Also used, with the guess zero by default, if the conditions would be too long to write.

    Returns
    -------
    SteadyMotions or SteadyNear
        SteadyNear if the motion was searched near a guess; ``.reason`` tells why.

    Raises
    ------
    ModelError
        No steady motion exists (with the requirement), no closed form for the unknowns (with the remaining
        conditions), a machine with constraints and unit quaternions, or too few values.
    TooManyTermsError
        Without values, if the conditions would be too long to write.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("conical pendulum")
    >>> m, L, g = s.parameters(m=1, L=0.5, g=9.81)
    >>> s.assume(L > 0), s.assume(g > 0)
    (None, None)
    >>> s.gravity = (0, 0, -g)
    >>> bob = s.body("bob", fb.particle(m))
    >>> arm = s.universal("arm", s.ground, bob, to=(0, 0, L), axis=("z", "x"), coordinate="psi theta")
    >>> print(fb.steady_motions(s, solve_for="theta").text())
    0 = L*psi'^2*cos(theta) - g or sin(theta)
    theta = acos(g/(L*psi'^2))  if L*psi'^2 - g >= 0
    theta = -acos(g/(L*psi'^2))  if L*psi'^2 - g >= 0
    theta = 0, any psi'  (coordinates are singular here)
    theta = pi, any psi'  (coordinates are singular here)
    """
    from ..equations import Equations, equations

    e = system if isinstance(system, Equations) else equations(system)
    if e is not system:
        check_modes_are_chosen(e.model, "fb.steady_motions")
    if near is not None:
        from .equilibrium_near import steady_near

        return steady_near(e.model, values or {}, near)
    try:
        with e.ring.budget.question(f"the conditions of steady motion of '{e.model.name}'", NEAR):
            if e.model.quaternions:
                from .turning import TurningProblem, TurningStability

                turning = TurningProblem(e, terms)
                return SteadyMotions(turning, TurningStability(turning), solve_for, values)
            problem = Problem(e, terms)
            return SteadyMotions(problem, ProblemStability(problem), solve_for, values)
    except TooManyTermsError as error:
        if values is None:
            raise
        from .equilibrium_near import steady_near

        return steady_near(e.model, values, None, error.reason)
