"""Quantities at a state as functions of numbers: energies, places, velocities, reactions, what points show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.motion import transmitting
from ..errors import ModelError, arguments_named
from .arguments import Array
from .evaluation import Evaluation, Values
from .products import (
    of_point,
    operational_space,
    values_of,
)


class Reaction(NamedTuple):
    """Load of a joint on its child in ground axes: force [N], and moment about the joint's point on the child [N m]."""

    force: Array
    moment: Array


class Posture(NamedTuple):
    """Rotation (ground from body) and position of a body's origin in ground axes [m]."""

    rotation: Array
    position: Array


class Momentum(NamedTuple):
    """Linear momentum [kg m/s] and moment of momentum about the ground's origin [kg m²/s], in ground axes."""

    linear: Array
    angular: Array


class Velocity(NamedTuple):
    """Angular velocity of a body [rad/s] and velocity of its origin [m/s], in ground axes."""

    angular: Array
    linear: Array


@arguments_named
class Quantities(Evaluation):
    """Methods of :class:`Program` for quantities at a state."""

    def kinetic_energy(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Any:
        """Kinetic energy of all bodies [J], a number or shape (N,)."""
        return self._run("kinetic_energy", {"q": q, "u": u}, t, values, named)

    def potential_energy(
        self, q: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Any:
        """Potential energy of weight (zero at the ground's origin) and of springs [J], a number or shape (N,)."""
        return self._run("potential_energy", {"q": q}, t, values, named)

    def poses(
        self, q: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> dict[str, Posture]:
        """Rotation (3, 3) and position (3,) of every body, by name."""
        x = self._run("poses", {"q": q}, t, values, named)
        return {
            name: Posture(x[..., k, :9].reshape(*x.shape[:-2], 3, 3), x[..., k, 9:])
            for k, name in enumerate(self.model.bodies)
        }

    def momentum(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Momentum:
        """Momentum of all bodies (3,) and its moment about the ground's origin (3,)."""
        x = self._run("momentum", {"q": q, "u": u}, t, values, named)
        return Momentum(x[..., :3], x[..., 3:])

    def velocities(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> dict[str, Velocity]:
        """Angular velocity (3,) of every body and velocity (3,) of its origin, by name."""
        x = self._run("velocities", {"q": q, "u": u}, t, values, named)
        return {name: Velocity(x[..., k, :3], x[..., k, 3:]) for k, name in enumerate(self.model.bodies)}

    def reactions(
        self,
        q: ArrayLike,
        u: ArrayLike,
        udot: ArrayLike | None = None,
        t: ArrayLike = 0.0,
        *,
        values: Values = None,
        **named: Any,
    ) -> dict[str, Reaction]:
        """Force (3,) and moment (3,) of every joint on its child, by name.

        Parameters
        ----------
        udot : array, shape (n_u,), optional
            Accelerations. By default those of the motion.
        """
        if udot is None:
            x = self._run("reactions", {"q": q, "u": u}, t, values, named)
        else:
            x = self._run("reactions_at", {"q": q, "u": u, "udot": udot}, t, values, named)
        names = [name for name, *_ in transmitting(self.model)] if udot is None else list(self.model.joints)
        return {name: Reaction(x[..., k, :3], x[..., k, 3:]) for k, name in enumerate(names)}

    def jacobian(
        self, point: Any, q: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Array:
        """J of a point of a body, shape (6, n_u): (angular velocity of the body, velocity of the point) = J u.

        Both are in ground axes. The motion imposed by driven joints is not part of J u.

        Parameters
        ----------
        point : Point, Body or str
            A point of a body; a body, its name, or the name of a link or site of a robot's file stands for its origin.
        """
        product = of_point(self.model, "jacobian", point)
        return self._run(product.key, {"q": q}, t, values, named, product)

    def jacobian_rate(
        self,
        point: Any,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Values = None,
        **named: Any,
    ) -> Array:
        """Rate dJ/dt of a point, shape (6, n_u): accelerations are J u' + (dJ/dt) u and the part of driven joints."""
        product = of_point(self.model, "jacobian_rate", point)
        return self._run(product.key, {"q": q, "u": u}, t, values, named, product)

    def operational_inertia(
        self,
        point: Any,
        q: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        components: Any = None,
        values: Values = None,
        **named: Any,
    ) -> Array:
        """Inertia Λ that forces at a point meet, Λ x'' + μ = F with x' = J u; shape (6, 6), or of the ``components``.

        Parameters
        ----------
        point : Point, Body or str
            As in :meth:`jacobian`.
        components : text or sequence of text, optional
            Some of ``"wx wy wz vx vy vz"``: moments about, and forces along, ground axes. By default all six.

        Raises
        ------
        ModelError
            If forces cannot accelerate the components independently: with too few speeds, and in singular positions.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("cart")
        >>> cart = s.body("cart", fb.particle(3))
        >>> rail = s.slider("rail", s.ground, cart, axis="x")
        >>> fb.compile(s).operational_inertia("cart", [0.0], components="vx")
        array([[3.]])
        """
        product = of_point(self.model, "operational_inertia", point, components)
        return _regular(self._run(product.key, {"q": q}, t, values, named, product), point)

    def operational_bias(
        self,
        point: Any,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        components: Any = None,
        values: Values = None,
        **named: Any,
    ) -> Array:
        """Bias μ of Λ x'' + μ = F, loads and weight included: the force at a point that keeps x' constant.

        Arguments and errors are those of :meth:`operational_inertia`.
        """
        product = operational_space(self.model, point, components)
        x = self._run(product.key, {"q": q, "u": u}, t, values, named, product)
        _regular(x[..., :-1, :], point)
        return np.array(x[..., -1, :])

    def value(
        self,
        expressions: Any,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Values = None,
        **named: Any,
    ) -> Any:
        """Value of an expression of the model's names, or of a sequence of them, shape (number of expressions,)."""
        several = isinstance(expressions, Sequence) and not isinstance(expressions, str)
        parsed = [
            self.model.names.expression(e, "an expression to evaluate")
            for e in (expressions if several else [expressions])
        ]
        key = ("value", tuple(parsed), several)
        return self._run(key, {"q": q, "u": u}, t, values, named, values_of(parsed, several))


def _regular(inertia: Array, point: Any) -> Array:
    """Return an inertia of operational space; singular positions are refused."""
    n = inertia.shape[-1]
    with np.errstate(all="ignore"):
        scale = np.sqrt(np.abs(inertia.diagonal(axis1=-2, axis2=-1)))
        scaled = inertia / scale[..., :, np.newaxis] / scale[..., np.newaxis, :]
        finite = np.asarray(np.isfinite(scaled).all(axis=(-2, -1)))
        inverse = np.linalg.eigvalsh(np.where(finite[..., np.newaxis, np.newaxis], scaled, np.eye(n)))
    regular = finite & (inverse[..., 0] > 2**6 * n * np.finfo(float).eps)
    if not regular.all():
        state = "" if inertia.ndim == 2 else f" in state {int(np.argmin(regular))}"
        raise ModelError(
            f"Expected a position in which forces at {point} can accelerate all components independently, got a "
            f"singular one{state}. Choose fewer components, or another position."
        )
    return inertia
