"""Component forms of the moment equations of one rigid body, with symbols or with numbers.

    H = I ω                                      angular_momentum           (6.9)
    M = I ω' + ω × I ω                           moment_equations           (6.27)
    M_1 = I_1 ω_1' + (I_3 - I_2) ω_2 ω_3, ...    euler_equations            (6.30)
    M = H' + ω × H,   H = I Ω                    modified_euler_equations   (6.88)-(6.90)

All components are in one frame with its origin at a fixed point of the body or at its mass centre. Without arguments
the symbols are those of the chapter. Products of inertia ``I_xy`` are the integrals ∫xy dm (6.11), so that they have a
minus sign in the matrix.

Examples
--------
>>> from freebody.symbolic.printing import component_forms as forms
>>> print(forms.euler_equations()[0])
I_1*Derivative(omega_1(t), t) + (-I_2 + I_3)*omega_2(t)*omega_3(t)
"""

from __future__ import annotations

from typing import Any

import sympy

from ...errors import ModelError
from ...scalar.expression import exact
from ...space.mass import MassProperties

t = sympy.Symbol("t")


def inertia_matrix(names: str = "xyz") -> Any:
    """Return the matrix of moments and products of inertia about axes with these letters, as symbols [kg m²]."""
    a, b, c = tuple(names)

    def entry(i: str, j: str) -> Any:
        pair = "".join(sorted(i + j))
        symbol = sympy.Symbol(f"I_{pair}", real=True)
        return symbol if i == j else -symbol

    return sympy.ImmutableMatrix(3, 3, [entry(i, j) for i in (a, b, c) for j in (a, b, c)])


def rates(name: str, subscripts: str | tuple[str, ...] = "xyz") -> Any:
    """Return the components of an angular velocity as functions of time, such as ω_x(t) [rad/s]."""
    return sympy.ImmutableMatrix([sympy.Function(f"{name}_{i}")(t) for i in subscripts])


def angular_momentum(inertia: Any = None, omega: Any = None) -> Any:
    """Return the components of the angular momentum H = I ω about a fixed point or the mass centre (6.9).

    Parameters
    ----------
    inertia : MassProperties, matrix 3 x 3, or three principal moments, optional
        Inertia about the point; that of MassProperties is about the mass centre [kg m²].
    omega : three components, optional
        Angular velocity of the body [rad/s].

    Returns
    -------
    SymPy column
        H_x, H_y, H_z [kg m²/s].

    Examples
    --------
    >>> angular_momentum()[0]
    I_xx*omega_x(t) - I_xy*omega_y(t) - I_xz*omega_z(t)
    >>> angular_momentum((1, 2, 3), (4, 5, 6)).T
    Matrix([[4, 10, 18]])
    """
    J, w = _inertia(inertia), _rates(omega)
    return sympy.ImmutableMatrix(J * w)


def moment_equations(inertia: Any = None, omega: Any = None, alpha: Any = None) -> Any:
    """Return the moments M = I ω' + ω × I ω about body axes, principal or not (6.27).

    Parameters
    ----------
    inertia, omega
        See :func:`angular_momentum`.
    alpha : three components, optional
        Time derivatives of the components of ω [rad/s²]; by default ω is differentiated with respect to t.

    Returns
    -------
    SymPy column
        M_x, M_y, M_z, grouped as they are printed [N m].
    """
    J, w = _inertia(inertia), _rates(omega)
    a = _derivative(w, alpha, "alpha")
    return _grouped(J * a + w.cross(J * w), w)


def euler_equations(moments: Any = None, omega: Any = None, alpha: Any = None) -> Any:
    """Return Euler's equations about principal axes (6.30).

    Parameters
    ----------
    moments : three moments of inertia, optional
        I_1, I_2, I_3 [kg m²].
    omega, alpha : three components, optional
        As for :func:`moment_equations`.

    Returns
    -------
    SymPy column
        M_1, M_2, M_3 [N m].
    """
    if moments is None:
        moments = sympy.symbols("I_1 I_2 I_3", real=True)
    if isinstance(moments, MassProperties) or len(moments) != 3 or hasattr(moments[0], "__len__"):
        raise ModelError(
            f"Expected three principal moments of inertia, got {moments!r}. For other axes: moment_equations."
        )
    w = rates("omega", "123") if omega is None else _rates(omega)
    a = _derivative(w, alpha, "alpha")
    I1, I2, I3 = (sympy.sympify(exact(x)) for x in moments)
    return sympy.ImmutableMatrix(
        [
            I1 * a[0] + (I3 - I2) * w[1] * w[2],
            I2 * a[1] + (I1 - I3) * w[0] * w[2],
            I3 * a[2] + (I2 - I1) * w[0] * w[1],
        ]
    )


def modified_euler_equations(
    inertia: Any = None, frame: Any = None, body: Any = None, body_rate: Any = None
) -> Any:
    """Return the moment equations in an intermediate frame that turns with ω while the body turns with Ω (6.88).

        M = H' + ω × H,    H = I Ω

    Parameters
    ----------
    inertia : as for :func:`angular_momentum`, optional
        Inertia in the axes of the frame. It must be constant there: (Ω - ω) × leaves it unchanged. By default the
        inertia of a body of revolution, (I_xi, I_xi, I_zeta).
    frame : three components, optional
        Angular velocity ω of the frame, in its axes [rad/s].
    body : three components, optional
        Angular velocity Ω of the body, in the same axes; by default equal to ω except for Ω_zeta (6.85).
    body_rate : three components, optional
        Time derivatives of the components of Ω; by default Ω is differentiated with respect to t.

    Returns
    -------
    SymPy column
        M_xi, M_eta, M_zeta [N m]; (6.90) if there are no arguments.

    Raises
    ------
    ModelError
        The inertia changes in the frame as the body turns.

    Examples
    --------
    >>> modified_euler_equations()[2]
    I_zeta*Derivative(Omega_zeta(t), t)
    """
    greek = ("xi", "eta", "zeta")
    if inertia is None:
        I_xi, I_zeta = sympy.symbols("I_xi I_zeta", real=True)
        inertia = (I_xi, I_xi, I_zeta)
    J = _inertia(inertia)
    w = rates("omega", greek) if frame is None else _rates(frame)
    if body is None:
        spin = sympy.Function("Omega_zeta")(t)
        body = (w[0], w[1], spin)
    W = _rates(body)
    relative = _skew(W - w)
    drift = (relative * J - J * relative).applyfunc(lambda x: sympy.simplify(sympy.expand(x)))
    if drift != sympy.zeros(3, 3):
        raise ModelError(
            f"The inertia is not constant in this frame: as the body turns by Omega - omega = {tuple(W - w)} in it, "
            f"the matrix changes at the rate {drift.tolist()}. Take axes in which it is constant, such as body axes, "
            f"or any that turn about the axis of a body of revolution."
        )
    H = J * W
    rate = J * _derivative(W, body_rate, "body_rate")
    return _grouped(rate + w.cross(H), w)


def _inertia(inertia: Any) -> Any:
    """Return an inertia in any form that a user may write as a 3 x 3 SymPy matrix."""
    if inertia is None:
        return inertia_matrix()
    if isinstance(inertia, MassProperties):
        inertia = inertia.inertia
    rows = inertia.tolist() if hasattr(inertia, "tolist") else list(inertia)
    if len(rows) == 3 and not any(hasattr(x, "__len__") for x in rows):
        return sympy.ImmutableMatrix(sympy.diag(*(sympy.sympify(exact(x)) for x in rows)))
    if len(rows) != 3 or any(not hasattr(row, "__len__") or len(row) != 3 for row in rows):
        raise ModelError(
            f"Expected an inertia as MassProperties, a matrix 3 x 3 or three principal moments, got {inertia!r}."
        )
    J = sympy.ImmutableMatrix([[sympy.sympify(exact(x)) for x in row] for row in rows])
    if (J - J.T).applyfunc(sympy.expand) != sympy.zeros(3, 3):
        raise ModelError(
            "Expected a symmetric inertia matrix: I_xy stands at (x, y) and at (y, x), both with a minus."
        )
    return J


def _rates(omega: Any) -> Any:
    if omega is None:
        return rates("omega")
    values = list(omega) if hasattr(omega, "__len__") and not isinstance(omega, str) else []
    if len(values) != 3:
        raise ModelError(f"Expected three components of an angular velocity, got {omega!r}.")
    return sympy.ImmutableMatrix([sympy.sympify(exact(x)) for x in values])


def _derivative(w: Any, alpha: Any, name: str) -> Any:
    if alpha is not None:
        return _rates(alpha)
    if not w.has(t):
        raise ModelError(
            f"The components {tuple(w)} are no functions of t, so that their derivatives are not known: "
            f"give them by {name}=."
        )
    return w.diff(t)


def _skew(v: Any) -> Any:
    return sympy.ImmutableMatrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def _grouped(v: Any, w: Any) -> Any:
    """Return the terms collected by products of the angular velocities, as the chapter prints them."""
    pairs = [w[i] * w[j] for i in range(3) for j in range(i, 3)]
    return sympy.ImmutableMatrix([sympy.collect(sympy.expand(x), pairs) for x in v])
