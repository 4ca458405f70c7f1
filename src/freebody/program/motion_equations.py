"""The equations of motion as functions of numbers: accelerations, forces, their matrices, the constraints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics import float_state
from ..dynamics.regressor import inertial_parameters, parameter_names
from ..errors import ModelError, arguments_named
from .arguments import (
    Array,
    array,
    checked,
    parameters_by_name,
)
from .closed_loops import Singularity, actuator_forces, chosen, completed, singularity
from .evaluation import Evaluation, Values, entered
from .products import (
    check_conditions,
)


class Derivatives(NamedTuple):
    """Derivatives of the accelerations u' by the coordinates, shape (n_u, n_q), and by the speeds, (n_u, n_u)."""

    by_q: Array
    by_u: Array


@arguments_named
class MotionEquations(Evaluation):
    """Methods of :class:`Program` for the equations of motion."""

    @entered
    def forward_dynamics(
        self,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        forces: ArrayLike | None = None,
        values: Values = None,
        **named: Any,
    ) -> Array:
        """Accelerations u' = M⁻¹ (τ - h), shape (n_u,).

        Parameters
        ----------
        forces : array, shape (n_u,), optional
            Generalized forces τ conjugate to the speeds, beyond the model's own loads [N, N m].
        """
        if forces is None:
            return self._run("forward_dynamics", {"q": q, "u": u}, t, values, named)
        return self._run("forced_dynamics", {"q": q, "u": u, "forces": forces}, t, values, named)

    @entered
    def inverse_dynamics(
        self,
        q: ArrayLike,
        u: ArrayLike,
        udot: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        actuators: Any = None,
        values: Values = None,
        **named: Any,
    ) -> Array:
        """Generalized forces τ that the motion needs beyond the model's loads [N, N m].

        Parameters
        ----------
        udot : array, shape (n_u,)
            Accelerations. With ``actuators`` they must keep the constraints, as those of :meth:`accelerations` do.
        actuators : "all", or names of coordinates or joints, optional
            For a machine with constraints: the coordinates on which forces act. With more actuators than degrees of
            freedom, the forces with the smallest Σ τ² are returned.

        Returns
        -------
        ndarray
            One force for each actuator, in their order (all speeds for "all"). Without ``actuators``, τ = M u' + h of
            the tree without its constraints, shape (n_u,).

        Raises
        ------
        ModelError
            For accelerations that break the constraints, too few actuators, and positions in which they lock up.
        """
        tau = self._run("inverse_dynamics", {"q": q, "u": u, "udot": udot}, t, values, named)
        if actuators is None:
            return tau
        places = chosen(self.model, actuators)
        G, gamma = self._conditions(q, u, t, values, named)
        return actuator_forces(self.model, tau, G, gamma, np.asarray(udot, dtype=float), places)

    def accelerations(
        self,
        q: ArrayLike,
        u: ArrayLike,
        given: Mapping[Any, float],
        t: float = 0.0,
        *,
        values: Values = None,
        **named: Any,
    ) -> Array:
        """All accelerations u' that keep the constraints and have given values for some coordinates, shape (n_u,).

        Parameters
        ----------
        given : mapping of coordinate or joint to number
            Second derivatives, ``{"crank": 2.0}``, of as many coordinates as there are degrees of freedom.

        Raises
        ------
        ModelError
            For accelerations that leave others undetermined or contradict the constraints.
        """
        G, gamma = self._conditions(q, u, t, values, named)
        if G.ndim != 2:
            raise ModelError("Expected one state for accelerations, got a batch.")
        if not isinstance(given, Mapping):
            raise ModelError(f"Expected accelerations by name, such as {{'crank': 2.0}}, got {given!r}.")
        places = chosen(self.model, list(given)) if given else []
        prescribed = np.zeros(len(places))
        for k, (name, x) in enumerate(given.items()):
            number = array(x, f"the acceleration of '{name}'")
            if number.shape != () or not np.isfinite(number):
                raise ModelError(f"Expected a finite number for the acceleration of '{name}', got {x!r}.")
            prescribed[k] = number
        return completed(self.model, G, gamma, places, prescribed)

    def singularity(
        self, q: ArrayLike, t: float = 0.0, *, actuators: Any = None, values: Values = None, **named: Any
    ) -> Singularity:
        """Return how near a machine with loops is to a singular position: a branch, or a lock-up of ``actuators``.

        Parameters
        ----------
        q : array, shape (n_q,)
            A position that closes the loops.
        actuators : names of coordinates or joints, optional
            Coordinates that drive the machine. Without them, only branches are sought.

        Returns
        -------
        Singularity
        """
        check_conditions(self.model, self._active)
        conditions = self.conditions(q, np.zeros(self.model.n_u), t, values={**(values or {}), **named})
        if conditions.ndim != 2:
            raise ModelError("Expected one position for singularity, got a batch.")
        if not np.isfinite(conditions).all():
            raise ModelError(
                f"Expected a position in which the conditions of '{self.model.name}' have values, got q = {q!r}."
            )
        M = self._run("mass_matrix", {"q": q}, t, values, named)
        active = self._active or ()
        places = None if actuators is None else chosen(self.model, actuators)
        return singularity(self.model, conditions[:, :-1], M, len(active), active, places)

    def _conditions(
        self, q: ArrayLike, u: ArrayLike, t: Any, values: Values, named: Mapping[str, Any]
    ) -> tuple[Array, Array]:
        """G and γ of the independent conditions."""
        check_conditions(self.model, self._active)
        x = self.conditions(q, u, t, values={**(values or {}), **named})
        x = x[..., list(self._active or ()), :]
        return x[..., :-1], x[..., -1]

    def conditions(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Array:
        """Conditions G u' + γ = 0 of the constraints on the accelerations, rows (G, γ), shape (rows, n_u + 1).

        Conditions that others imply are among them. There are no rows without constraints.
        """
        state = {"q": q, "u": u}
        if self.model.constraints:
            return self._run("conditions", state, t, values, named)
        *_, count = checked(self.model, state, t, parameters_by_name(self.model, values, named), "conditions")
        return np.zeros((*(() if count is None else (count,)), 0, self.model.n_u + 1))

    @entered
    def mass_matrix(self, q: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any) -> Array:
        """Mass matrix M, symmetric, shape (n_u, n_u) [kg, kg m, kg m²]."""
        return self._run("mass_matrix", {"q": q}, t, values, named)

    @entered
    def bias(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Array:
        """Bias h: the value of M u' + h at u' = 0, including the model's loads, shape (n_u,) [N, N m]."""
        return self._run("bias", {"q": q, "u": u}, t, values, named)

    @entered
    def coriolis_matrix(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Array:
        """Coriolis matrix C, shape (n_u, n_u): M u' + C u + g = τ, and Ṁ - 2 C is skew.

        C u is the part of the bias that is quadratic in u, without loads. With Ṁ - 2 C skew, passivity-based
        controllers and momentum observers work.
        """
        return self._run("coriolis_matrix", {"q": q, "u": u}, t, values, named)

    @entered
    def gravity_forces(
        self, q: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Array:
        """Generalized forces g that hold the machine against gravity at rest, shape (n_u,) [N, N m]."""
        return self._run("gravity_forces", {"q": q}, t, values, named)

    @entered
    def regressor(
        self,
        q: ArrayLike,
        u: ArrayLike,
        udot: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Values = None,
        **named: Any,
    ) -> Array:
        """Regressor Y, shape (n_u, 10 bodies): the forces that a motion needs beyond loads and armature are Y θ.

        θ are the :meth:`inertial_parameters`.
        """
        return self._run("regressor", {"q": q, "u": u, "udot": udot}, t, values, named)

    def inertial_parameters(self, *, values: Values = None, **named: Any) -> dict[str, float]:
        """Inertial parameters θ by name, such as ``"arm.hx"``, in the order of the regressor's columns.

        Each body has its mass m [kg], first moment h = m c [kg m] and moments of inertia I [kg m²] (the entries of the
        matrix) about its origin, in its axes.
        """
        state = float_state(self.model, values=parameters_by_name(self.model, values, named))
        numbers = map(float, inertial_parameters(self.model, state))
        return dict(zip(parameter_names(self.model), numbers, strict=True))

    @entered
    def coordinate_rates(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Array:
        """Coordinate rates q', shape (n_q,): equal to u except for ball and free joints."""
        return self._run("coordinate_rates", {"q": q, "u": u}, t, values, named)

    def derivatives(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Derivatives:
        """Exact derivatives of :meth:`forward_dynamics` by q and u (for a quaternion, by its four components)."""
        n_q = self.model.n_q
        J = self._run("derivatives", {"q": q, "u": u}, t, values, named)
        return Derivatives(J[..., :n_q], J[..., n_q:])
