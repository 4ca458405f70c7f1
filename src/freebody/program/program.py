"""``fb.compile``: the dynamics of a machine as functions of numbers, in machine code.

    M(q, t) u' + h(q, u, t) = τ

for one state or for many at once. Each function is recorded and compiled at its first call, and loaded from the disk by
later processes.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..describe.system import System
from ..dynamics import float_state
from ..dynamics.conditions.constrained import closed_coordinates, independent_rows
from ..dynamics.motion import transmitting
from ..dynamics.regressor import inertial_parameters, parameter_names
from ..errors import ModelError, arguments_named
from ..model import Model, assemble
from ..rooms_above import module_for
from .arguments import (
    NUMBERS,
    Assumption,
    array,
    assumptions,
    check_parameters,
    checked,
    is_plain,
    parameters_by_name,
    signals_at,
)
from .closed_loops import Singularity, actuator_forces, chosen, completed, singularity
from .kernels import Kernel, KernelSet
from .large.tree_loop import LoopedKernel, LoopedSet, looped_kernel
from .products import (
    OF_POINT,
    Product,
    check_conditions,
    compiled,
    derivative_of,
    named_variable,
    of_point,
    product_named,
    values_of,
)

if TYPE_CHECKING:
    from .export.c import CSource
    from .export.casadi import CasadiFunctions
    from .export.python import PythonSource
    from .export.wasm import WasmModule

Array = NDArray[np.float64]
Values: TypeAlias = Mapping[Any, Any] | None
"""Values of parameters by name or symbol."""
_REMEMBERED = 8  # sets of parameters whose hoisted constants are kept

_Shortcut: TypeAlias = tuple[Kernel, Array | None, tuple[tuple[int, ...], ...], tuple[int, ...]]
"""Kernel, its constants for default parameters (None for others), shapes of the parts of a state and of the result."""


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


class Derivatives(NamedTuple):
    """Derivatives of the accelerations u' by the coordinates, shape (n_u, n_q), and by the speeds, (n_u, n_u)."""

    by_q: Array
    by_u: Array


@arguments_named
def compile_system(
    machine: System | Model, *, threads: int = 1, at: Sequence[float] | None = None
) -> Program:
    """Return the dynamics of a machine as compiled functions.

    Parameters
    ----------
    machine : System or Model
    threads : int
        Number of threads that share a batch. Results do not depend on it.
    at : sequence of float, length n_q, optional
        For a machine with constraints: a configuration near one that fulfils them. There, at the parameters' default
        values, the conditions that are independent of each other are chosen.

    Returns
    -------
    Program
        Functions of the state. Each is compiled at its first call.

    Raises
    ------
    ModelError
        For an argument that is no machine, for every defect that :func:`assemble` finds, and for constraints that
        cannot be met near ``at``.

    Examples
    --------
    >>> import freebody as fb
    >>> s = fb.System("pendulum")
    >>> m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
    >>> s.gravity = (0, -g, 0)
    >>> bob = s.body("bob", fb.particle(m))
    >>> pin = s.hinge("pin", s.ground, bob, to=(0, L, 0), axis="z", coordinate="theta")
    >>> program = fb.compile(s)
    >>> program.mass_matrix([0.0])
    array([[4.]])
    >>> program.forward_dynamics([[0.1], [0.2]], [[0.0], [0.0]], L=1.0).round(6)
    array([[-0.979366],
           [-1.948946]])
    """
    if isinstance(machine, System):
        machine = assemble(machine)
    if not isinstance(machine, Model):
        raise ModelError(
            f"Expected a System or a Model to compile, got {machine!r}. "
            "A machine is described first: s = fb.System('name')."
        )
    if isinstance(threads, bool) or not isinstance(threads, int) or threads < 1:
        raise ModelError(f"Expected threads to be a whole number of at least 1, got {threads!r}.")
    active = None
    if at is not None:
        q = array(at, "at")
        if q.shape != (machine.n_q,):
            raise ModelError(
                f"Expected at= of shape ({machine.n_q},), one number for each of "
                f"{', '.join(machine.coordinate_names)}; got shape {q.shape}."
            )
        if machine.constraints:
            active = independent_rows(machine, float_state(machine, closed_coordinates(machine, q.tolist())))
    return Program(machine, threads, active)


class Program:
    """Compiled dynamics of one model, returned by :func:`freebody.compile`.

    The arguments are the same in all functions:

    q, u : array, shape (n_q,) and (n_u,), or (N, n_q) and (N, n_u)
        Coordinates and speeds of one state or of a batch, in the order of :attr:`coordinate_names` and
        :attr:`speed_names` of the model. In a batch, all states share an argument without a leading axis.
    t : float or array, shape (N,)
        Time [s].
    values : mapping, optional
        Parameters by name or symbol: a number, or N numbers for a batch. Other parameters have their default values.
    **named
        Parameters by name.

    In a batch, results have the leading axis N. Every function raises :class:`freebody.errors.ModelError` for a wrong
    shape, an unknown parameter and a parameter without value.
    """

    def __init__(self, model: Model, threads: int = 1, active: tuple[int, ...] | None = None) -> None:
        self.model = model
        self.threads = threads
        self._active = active
        self._assumptions: tuple[Assumption, ...] | None = None
        self._large: dict[str, LoopedSet] = {}
        self._sets: dict[Any, tuple[KernelSet | LoopedKernel, bool]] = {}
        self._constants: dict[Any, OrderedDict[Any, Array]] = {}
        self._shortcuts: tuple[dict[Any, _Shortcut], dict[Any, _Shortcut]] = (
            {},
            {},
        )  # of one state, of a batch

    def __reduce__(self) -> Any:
        """Pickle without compiled code: another process, or a copy, compiles or loads each function."""
        return type(self), (self.model, self.threads, self._active)

    def __repr__(self) -> str:
        """Return the model and the names of the products compiled so far."""
        return (
            f"Program of {self.model!r}; compiled so far: {', '.join(map(_title, self._sets)) or 'nothing'}"
        )

    # --- the dynamics --------------------------------------------------------------------------

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
        *_, count = checked(self.model, state, t, parameters_by_name(self.model, values, named))
        return np.zeros((*(() if count is None else (count,)), 0, self.model.n_u + 1))

    def mass_matrix(self, q: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any) -> Array:
        """Mass matrix M, symmetric, shape (n_u, n_u) [kg, kg m, kg m²]."""
        return self._run("mass_matrix", {"q": q}, t, values, named)

    def bias(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Array:
        """Bias h: the value of M u' + h at u' = 0, including the model's loads, shape (n_u,) [N, N m]."""
        return self._run("bias", {"q": q, "u": u}, t, values, named)

    def coriolis_matrix(
        self, q: ArrayLike, u: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Array:
        """Coriolis matrix C, shape (n_u, n_u): M u' + C u + g = τ, and Ṁ - 2 C is skew.

        C u is the part of the bias that is quadratic in u, without loads. With Ṁ - 2 C skew, passivity-based
        controllers and momentum observers work.
        """
        return self._run("coriolis_matrix", {"q": q, "u": u}, t, values, named)

    def gravity_forces(
        self, q: ArrayLike, t: ArrayLike = 0.0, *, values: Values = None, **named: Any
    ) -> Array:
        """Generalized forces g that hold the machine against gravity at rest, shape (n_u,) [N, N m]."""
        return self._run("gravity_forces", {"q": q}, t, values, named)

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

    # --- energies, places, forces --------------------------------------------------------------

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
        self.operational_inertia(point, q, t, components=components, values=values, **named)
        product = of_point(self.model, "operational_bias", point, components)
        return self._run(product.key, {"q": q, "u": u}, t, values, named, product)

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

    # --- derivatives ---------------------------------------------------------------------------

    def derivative(self, product: str, by: Any, *, point: Any = None) -> Callable[..., Any]:
        """Return the exact derivative of a product as a function, recorded from its trace without differences.

        Parameters
        ----------
        product : str
            ``"forward_dynamics"``, ``"forced_dynamics"`` (with forces), ``"inverse_dynamics"``, ``"mass_matrix"``,
            ``"coriolis_matrix"``, ``"gravity_forces"``, ``"regressor"``, ``"bias"``, ``"coordinate_rates"``,
            ``"kinetic_energy"``, ``"potential_energy"``, ``"momentum"``, ``"poses"``, ``"velocities"``,
            ``"reactions"``, ``"reactions_at"`` (with u'), with constraints ``"conditions"`` (G and γ of G u' + γ = 0,
            by rows), and of ``point`` ``"jacobian"``, ``"jacobian_rate"``, ``"operational_inertia"`` and
            ``"operational_bias"``. These are also named with the body or frame, ``"jacobian of hand"``, and with
            components, ``"operational_inertia of hand: vx vy vz"``.
        by : str or Symbol
            An input of the product (``"q"``, ``"u"``, ``"udot"``, ``"forces"``), ``"t"``, ``"parameters"`` (all, in the
            model's order), one parameter, or ``"displacement"``. By q, the four components of a quaternion count as
            independent numbers. By displacement, the configuration is turned and moved by a unit of each speed:
            ∂f/∂q G with q' = G(q) u, which has n_u columns.
        point : Point, Body or str
            The point of such a product.

        Returns
        -------
        function
            A function of the product's inputs in their order, then t, ``values=`` and parameters by name, as in the
            other methods. Its result has the shape of the product with one more axis, or without it for time and for
            one parameter. Bodies and joints are in the order of the model: (12,) for a pose (rotation by rows,
            position), (6,) for a velocity (angular, linear) and for a reaction (force, moment).

        Raises
        ------
        ModelError
            For an unknown product or variable.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("pendulum")
        >>> m, L, g = s.parameters(m=1.0, L=2.0, g=9.0)
        >>> s.gravity = (0, -g, 0)
        >>> pin = s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), axis="z")
        >>> program = fb.compile(s)
        >>> program.derivative("forward_dynamics", "q")([0.0], [0.0])
        array([[-4.5]])
        >>> program.derivative("kinetic_energy", "L")([0.0], [3.0])
        18.0
        """
        by = named_variable(self.model, by)
        of_points = isinstance(product, str) and product in OF_POINT
        if of_points and point is not None:
            base = of_point(self.model, product, point)
            derived, key = derivative_of(self.model, base, by), (*base.key, by)
        else:
            if point is not None or of_points:
                raise ModelError(
                    f"Expected point= together with one of {', '.join(OF_POINT)}, and only there."
                )
            derived = derivative_of(self.model, product_named(self.model, product), by)
            key = f"{product}_by_{by}"  # type: ignore[assignment]

        def function(*arrays: ArrayLike, values: Values = None, **named: Any) -> Any:
            names = (*derived.inputs, "t")
            arguments = dict(zip(names, arrays, strict=False))
            for name in names:
                if name in named and name not in arguments:
                    arguments[name] = named.pop(name)
            missing = [name for name in derived.inputs if name not in arguments]
            if missing or len(arrays) > len(names):
                raise ModelError(
                    f"Expected {', '.join(derived.inputs)} and, if it matters, t for the derivative of '{product}', "
                    f"got {len(arrays)} arguments."
                )
            t = arguments.pop("t", 0.0)
            return self._run(key, arguments, t, values, named, derived)

        function.__name__ = function.__qualname__ = f"{product}_by_{by}"
        return function

    # --- export --------------------------------------------------------------------------------

    def to_c(self, *products: str, name: str | None = None) -> CSource:
        """Write products as one C99 source file and its header, which need nothing but the C library's mathematics.

        Parameters
        ----------
        *products : str
            Names as in :meth:`derivative`; ``"forward_dynamics_by_q"`` is a derivative. By default, all products of
            the machine without derivatives.
        name : str, optional
            Name of the files and prefix of the functions. By default the model's name.

        Returns
        -------
        CSource
            An object with ``source``, ``header`` and ``write(folder)``.
        """
        from .export.c import c_source

        return c_source(self.model, products, self._active, name)

    def to_numpy(self, *products: str) -> PythonSource:
        """Write products as Python functions f(q, u, ..., t, p) of NumPy arrays, with any leading axes.

        Functions are called by name, ``result["bias"](q, u)``. Their ``source`` needs NumPy only.
        """
        from .export.python import python_source

        return python_source(self.model, products, self._active, "numpy")

    def to_jax(self, *products: str) -> PythonSource:
        """Write products as Python functions of JAX arrays, for use with ``jax.jit``, ``grad`` and ``vmap``."""
        from .export.python import python_source

        return python_source(self.model, products, self._active, "jax")

    def to_casadi(self, *products: str) -> CasadiFunctions:
        """Write products as ``casadi.Function`` by name, of the inputs q, u, ..., t and the parameters p as columns."""
        from .export.casadi import casadi_functions

        return casadi_functions(self.model, products, self._active)

    def to_wasm(
        self, until: Any = 10.0, *, initial: Values = None, near: Values = None, values: Values = None,
        outputs: Sequence[Any] = (), events: Any = (), most_steps: int = 20_000,
    ) -> WasmModule:  # fmt: skip
        """Write the machine, and the loop that computes its motion, as one WebAssembly module.

        The module closes the machine's loops, integrates (method "dop853"), projects, finds events, and gives frames at
        the times that are asked for, as :func:`freebody.simulate` does, without Python. Parameters, start, length and
        tolerances are read at each call; those given here are the values at first.

        Parameters
        ----------
        until, initial, near, values, events
            As for :func:`freebody.simulate`. Initial values that are expressions of parameters follow these.
        outputs : sequence of expressions
            Expressions of coordinates, speeds and parameters, whose values each frame has.
        most_steps : int
            Number of steps that the module has room for. A run that needs more ends.

        Returns
        -------
        WasmModule
            ``code``, and the places of everything that is written and read.

        Raises
        ------
        SimulationError
            For machines with contacts, signals or controllers, with conditions that others imply, and for those so
            large that their equations are loops.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("pendulum")
        >>> bar = s.body("bar", fb.slender_bar(1, 2, axis="y"))
        >>> s.gravity = (0, -9.81, 0)
        >>> pin = s.hinge("pin", s.ground, bar, to=(0, 1, 0), coordinate="theta")
        >>> module = fb.compile(s).to_wasm(until=2, initial={"theta": 1}, outputs=["sin(theta)"])
        >>> module.code[:4], module.state, module.outputs
        (b'\\x00asm', ('theta', "theta'"), ('sin(theta)',))
        """
        return module_for("wasm").wasm_module(
            self.model, until, outputs, most_steps, initial=initial, near=near, values=values, events=events
        )

    # --- kernels -------------------------------------------------------------------------------

    def kernel(self, name: str, batch: bool = False) -> Kernel:
        """Return the machine code of a product (``"forward_dynamics"``, ...), for callers that use addresses.

        The state y of the kernel holds the product's inputs in their order: q, u, u' or forces.
        """
        kernels = self._compiled(name, product_named(self.model, name), batch)
        return kernels.of_rows(shared=False) if batch and isinstance(kernels, LoopedKernel) else kernels["f"]

    def constants(self, name: str = "forward_dynamics", values: Values = None, **named: Any) -> Array:
        """Return the vector c for the kernel of a product at these values of the parameters."""
        parameters = parameters_by_name(self.model, values, named)
        kernels = self._compiled(name, product_named(self.model, name), False)
        return self._hoisted(name, kernels, parameters).copy()

    def describe(self, *names: str) -> str:
        """Report operations, size and compile time of products, a line each; by default of all compiled so far.

        The first count is that of the operations for one state, the second that of the operations done once per set of
        parameters. The size is that of the object code, including its batch form if there is one. The time is that of
        compiling the recorded program; ``from the disk`` means that an earlier process spent it.

        Examples
        --------
        >>> import freebody as fb
        >>> s = fb.System("pendulum")
        >>> m, L, g = s.parameters(m=1.0, L=2.0, g=9.81)
        >>> s.gravity = (0, -g, 0)
        >>> pin = s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), axis="z")
        >>> print(fb.compile(s).describe("forward_dynamics"))
        forward_dynamics: 2 operations (1 mul, 1 sincos); ... once per parameters; ... kB, compiled in ... ms...
        """
        for name in names:
            self.kernel(name)
        chosen = names or tuple(self._sets) or ("forward_dynamics",)
        lines = []
        for name in chosen:
            if name not in self._sets:
                self.kernel(name)
            kernels = self._sets[name][0]
            operations = kernels.operations
            once = sum(operations["parameters"].values())
            parts = ", ".join(f"{count} {code}" for code, count in operations["f"].items())
            total = sum(operations["f"].values())
            lines.append(
                f"{_title(name)}: {total} operations ({parts or 'none'}); {once} once per parameters; "
                f"{kernels.size / 1e3:.1f} kB, compiled in {kernels.seconds * 1e3:.0f} ms"
                f"{' (from the disk)' if kernels.from_disk else ''}{kernels.remark}"
            )
        return "\n".join(lines)

    def _compiled(self, key: Any, product: Product, batch: bool) -> KernelSet | LoopedKernel:
        """Return the kernels of a product, compiled if they or their batch form are missing."""
        entry = self._sets.get(key)
        if entry is None or (batch and not entry[1]):
            if product.moves:
                check_conditions(self.model, self._active)
            looped = looped_kernel(
                self.model, key, product, self._large
            )  # of a large tree: with its batch form
            if looped is not None:
                entry = (looped, True)
            else:
                entry = (compiled(self.model, product, batch, self._active), batch)
            self._sets[key] = entry
            self._constants.pop(key, None)
            for shortcuts in self._shortcuts:
                shortcuts.pop(key, None)
        return entry[0]

    def _run(
        self,
        key: Any,
        arguments: Mapping[str, ArrayLike],
        t: ArrayLike,
        values: Values,
        named: Mapping[str, Any],
        product: Product | None = None,
    ) -> Any:
        """Evaluate a product; the result has its shape."""
        parameters = parameters_by_name(self.model, values, named)
        state = tuple(arguments.values())
        batch = type(state[0]) is np.ndarray and state[0].ndim == 2
        shortcut = self._shortcuts[batch].get(key) if type(t) is float else None
        if shortcut is not None:
            kernel, c, widths, shape = shortcut
            shapes = [state[0].shape[:1] + width for width in widths] if batch else widths
            if all(map(is_plain, state, shapes)) and NUMBERS.issuperset(map(type, parameters.values())):
                # the most common calls take a third of the time
                if c is None or parameters:
                    c = self._hoisted(key, self._sets[key][0], parameters)
                if batch:
                    out = kernel.batch_of_parts(t, state, c, threads=self.threads)
                    return out if len(shape) == 1 else out.reshape(len(out), *shape)
                out = kernel.unchecked(t, state[0] if len(state) == 1 else np.concatenate(state), c)
                return out if len(shape) == 1 else out.reshape(shape) if shape else float(out[0])
        if self.model.signals:
            parameters = {**signals_at(self.model, t), **parameters}
        arrays, time, count = checked(self.model, arguments, t, parameters)
        if product is None:
            product = product_named(self.model, key)
        program = self._compiled(key, product, count is not None)
        shape = product.shape(self.model)
        c = self._hoisted(key, program, parameters)
        kernel = program["f"]
        if isinstance(program, LoopedKernel) and count is not None:
            kernel = program.of_rows(shared=c.ndim == 1)
        if c.ndim == 1 and not self.model.signals:
            widths = tuple(x.shape[-1:] for x in arrays.values())
            self._shortcuts[count is not None][key] = (kernel, None if parameters else c, widths, shape)
        if count is None:
            out = kernel(float(time), np.concatenate(list(arrays.values())), c)
            return out.reshape(shape) if shape else float(out[0])
        parts = [x if x.ndim == 2 else np.broadcast_to(x, (count, len(x))) for x in arrays.values()]
        out = kernel.batch_of_parts(time, parts, c, threads=self.threads)
        return out.reshape(count, *shape)

    def _hoisted(self, key: Any, program: KernelSet | LoopedKernel, parameters: Mapping[str, Any]) -> Array:
        """Return the vector c, or one for each state; the last few are remembered."""
        remembered = self._constants.setdefault(key, OrderedDict())
        columns = {name: value for name, value in parameters.items() if isinstance(value, np.ndarray)}
        label: Any = None
        if not columns:
            if not NUMBERS.issuperset(map(type, parameters.values())):  # a text and a number may print alike
                parameters = self.model.values(parameters)
            label = tuple(sorted(parameters.items()))
            if label in remembered:
                remembered.move_to_end(label)
                return remembered[label]
        single = {name: value for name, value in parameters.items() if name not in columns}
        numbers = self.model.values({**single, **{name: 0 for name in columns}})
        if self._assumptions is None:
            self._assumptions = assumptions(self.model)
        check_parameters(self.model, self._assumptions, columns, numbers)
        if not columns:
            c = remembered[label] = program.constants([*numbers.values()])
            while len(remembered) > _REMEMBERED:
                remembered.popitem(last=False)
            return c
        count = len(next(iter(columns.values())))
        P = np.empty((count, len(numbers)))
        for k, (name, number) in enumerate(numbers.items()):
            P[:, k] = columns.get(name, number)
        return program.constants(P)


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


def _title(key: Any) -> str:
    if isinstance(key, str):
        return key
    return f"{key[0]} of {', '.join(map(str, key[1:]))}"
