"""Steady precession in Euler's angles from the equation of motion of theta, for the tops of the gallery.

psi turns about the axis parallel to the force that exerts the moment, theta about the nodal axis, phi about the
symmetry axis; the total spin phi' + psi' cos(theta) is a constant of the motion, and a parameter of the system.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import sympy

import freebody as fb

from .answer import Answer, Answers
from .case import Case


def steady_balance(case: Case, spin: str = "Omega_zeta") -> tuple[Any, ...]:
    """Return the coefficients of 1, w, w² in the balance of theta for constant theta and psi' = w."""
    w = sympy.Symbol("w")
    state = {"theta'": 0, "theta''": 0, "psi''": 0, "phi''": 0, "psi'": w}
    phi_rate = case.system.expression(f"{spin} - psi'*cos(theta)")
    balance = case.equations.motion[1]
    steady = case.put(
        balance.lhs - balance.rhs, {**state, "phi'": phi_rate.xreplace({case.atoms["psi'"]: w})}
    )
    return tuple(sympy.Poly(steady, w).coeff_monomial(w**k) for k in range(3))


def steady_root(case: Case, theta: str, spin: str = "Omega_zeta") -> tuple[Any, Any, bool]:
    """Return the fast and slow rate of steady precession at the angle of that name, and True if they are real.

    The roots of A w² + B w + C are q/A and C/q with q = -(B ± sqrt(B² - 4 A C))/2. The sign is the sign of B, so that
    the slow root does not lose digits.
    """
    C, B, A = (
        case.put(c, {"theta": theta}) / sympy.sin(case.atoms[theta]) for c in steady_balance(case, spin)
    )
    square = B**2 - 4 * A * C
    if case.number(square) < 0:
        return sympy.nan, sympy.nan, False
    sign = -1 if case.number(B) < 0 else 1
    q = -(B + sign * sympy.sqrt(square)) / 2
    return q / A, C / q, case.number(q) != 0


def steady_rates(case: Case, theta: str, ending: str = "", spin: str = "Omega_zeta") -> Answers:
    """Return answers for both rates of steady precession at the angle of that name."""
    fast, slow, there = steady_root(case, theta, spin)
    # the cosine of a right angle is not 0 in doubles
    horizontal = there and abs(case.number(sympy.cos(case.atoms[theta]))) < 1e-15
    how = "equation of motion of theta at constant theta and psi'"
    found: Answers = {}
    for kind, rate in (("fast", fast), ("slow", slow)):
        question = f"{kind} steady precession rate psi' at {theta}"
        key = f"psi'_{kind}{ending}"
        if not there:
            found[key] = Answer(question, "none: spin too small", "", None, how)
        elif kind == "fast" and horizontal:
            found[key] = Answer(question, "infinite: the shaft is horizontal", "", None, how)
        else:
            found[key] = case.formula(question, rate, "rad/s", how)
    return found


def least_spin(case: Case, theta: Any = "theta_0", spin: str = "Omega_zeta") -> Any:
    """Return the smallest spin with a steady precession at an angle: B² = 4 A C, and B is a multiple of the spin."""
    C, B, A = (sympy.cancel(c / sympy.sin(case.atoms["theta"])) for c in steady_balance(case, spin))
    C, B, A = (case.put(c, {"theta": theta}) for c in (C, B, A))
    slope = B.diff(case.atoms[spin])
    return sympy.sqrt(sympy.cancel(4 * A * C / slope**2)) if case.number(A * C) > 0 else sympy.Integer(0)


def stop(case: Case) -> tuple[Any, Any]:
    """Return energy and momentum about the vertical at a stop of the axis, theta' = psi' = 0, divided by cos(theta).

    Both are the same for all motions of the same spin.
    """
    still = {"theta'": 0, "psi'": 0, "phi'": "Omega_zeta"}
    cosine = sympy.cos(case.atoms["theta"])
    energy, momentum = (
        sympy.expand(case.put(case.equations.integrals[name].expression, still))
        for name in ("energy", "momentum of psi")
    )
    spin = energy.subs(cosine, 0)
    return sympy.expand((energy - spin) / cosine), sympy.expand(momentum / cosine)


def left_at_stop(case: Case, start: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return cos(theta) at which psi' vanishes in a motion, and the remaining energy of theta' there [J].

    The momentum about the vertical gives cos(theta) at psi' = 0, and E gives the energy of theta' there. If it is
    positive, the path has loops; if it is zero, cusps; if it is negative, psi' never vanishes and the path has waves.
    """
    weight, spin = stop(case)
    energy, momentum = (
        case.put(case.equations.integrals[name].expression, start) for name in ("energy", "momentum of psi")
    )
    still = case.put(
        case.equations.integrals["energy"].expression,
        {"theta": sympy.pi / 2, "theta'": 0, "psi'": 0, "phi'": "Omega_zeta"},
    )
    cosine = momentum / spin
    return cosine, energy - still - weight * cosine


def path_class(case: Case, start: Mapping[str, Any]) -> str:
    """Return loop, cusp or wave: the shape of the axis' path on the unit sphere, from the integrals of the motion."""
    cosine, left = (case.number(x) for x in left_at_stop(case, start))
    weight = abs(case.number(stop(case)[0]))
    if abs(left) <= 1e-12 * weight and abs(cosine) <= 1:
        return "cusp"
    return "loop" if left > 0 and abs(cosine) < 1 else "wave"


def between(case: Case, name: str = "theta_0") -> None:
    """Raise an error for a vertical shaft, for which psi and phi are one angle."""
    if not 0 < case[name] < math.pi:
        raise fb.errors.ModelError(
            f"Expected {name} between 0 and pi, got {case[name]:g}: there the shaft is vertical and "
            "psi and phi are one angle."
        )
