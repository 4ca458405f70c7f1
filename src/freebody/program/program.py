"""``fb.compile``: the dynamics of a machine as functions of numbers, in machine code.

    M(q, t) u' + h(q, u, t) = τ

for one state or for many at once. Each function is recorded and compiled when it is first called, and found on disk
the next time.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..describe.system import System
from ..dynamics import float_state
from ..dynamics.constrained import closed_coordinates, independent_rows
from ..errors import ModelError, arguments_named
from ..model import Model, assemble
from .arguments import (
    NUMBERS,
    Assumption,
    array,
    assumptions,
    check_parameters,
    checked,
    is_plain,
    parameters_given,
    place_of,
    signals_at,
)
from .export.closed import Singularity, actuator_forces, chosen, completed, singularity
from .kernels import Kernel, KernelSet
from .large.tree_loop import LoopedKernel, LoopedSet, looped_kernel
from .products import (
    Product,
    check_conditions,
    compiled,
    derivative_of,
    jacobian_of,
    named_variable,
    product_named,
    transmitting,
    values_of,
)

if TYPE_CHECKING:
    from .export.source_text import CasadiFunctions, CSource, PythonSource

Array = NDArray[np.float64]
_KEPT = 8  # sets of parameters whose hoisted constants are remembered


_Plain: TypeAlias = tuple[Kernel, Array | None, tuple[tuple[int, ...], ...], tuple[int, ...]]
"""Kernel, its constants unless parameters were given, shapes of the parts of a state, and of a result."""


class Reaction(NamedTuple):
    """What a joint does to its child, in ground axes: force [N] and moment about the joint's point on it [N m]."""

    force: Array
    moment: Array


class Posture(NamedTuple):
    """Rotation (ground from body) and position of a body's origin in ground axes [m]."""

    rotation: Array
    position: Array


class Momentum(NamedTuple):
    """Linear momentum [kg m/s], and moment of momentum about the ground's origin [kg m²/s], in ground axes."""

    linear: Array
    angular: Array


class Velocity(NamedTuple):
    """Angular velocity of a body [rad/s] and velocity of its origin [m/s], in ground axes."""

    angular: Array
    linear: Array


class Derivatives(NamedTuple):
    """Of the accelerations u' by the coordinates and by the speeds: shapes (n_u, n_q) and (n_u, n_u)."""

    by_q: Array
    by_u: Array


@arguments_named
def compile_system(
    machine: System | Model, *, threads: int = 1, at: Sequence[float] | None = None
) -> Program:
    """The dynamics of a machine as compiled functions.

    Parameters
    ----------
    machine : System or Model
    threads : int
        How many threads share a batch. Results do not depend on it.
    at : sequence of float, length n_q, optional
        Of a machine with constraints, a configuration near one that fulfils them, where it is decided, at the
        parameters' default values, which conditions are independent of each other.

    Returns
    -------
    Program
        Functions of the state. Nothing is compiled before it is asked for.

    Raises
    ------
    ModelError
        For what is no machine, for every defect that :func:`assemble` finds, and for constraints that can not be met
        near ``at``.

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
    """Compiled dynamics of one model. Made by :func:`freebody.compile`.

    The arguments are the same in all functions:

    q, u : array, shape (n_q,) and (n_u,), or (N, n_q) and (N, n_u)
        Coordinates and speeds in the order of :attr:`coordinate_names` and :attr:`speed_names` of the model; of one
        state or of a batch. In a batch what has no leading axis is shared by all states.
    t : float or array, shape (N,)
        Time [s].
    values : mapping, optional
        Parameters by name or symbol: a number, or N numbers for a batch. Those not given have their default value.
    **named
        Parameters by name.

    Results have the leading axis N in a batch. Every function raises :class:`freebody.errors.ModelError` for a wrong
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
        self._plain: tuple[dict[Any, _Plain], dict[Any, _Plain]] = {}, {}  # of one state, of a batch

    def __reduce__(self) -> Any:
        """Another process, or a copy, compiles what it is asked for, or finds it on disk."""
        return type(self), (self.model, self.threads, self._active)

    def __repr__(self) -> str:
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
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Array:
        """Accelerations u' = M⁻¹ (τ - h), shape (n_u,).

        Parameters
        ----------
        forces : array, shape (n_u,), optional
            Generalized forces τ conjugate to the speeds, beyond the model's own loads [N, N m].
        """
        given = {"q": q, "u": u}
        if forces is None:
            return self._run("forward_dynamics", given, t, values, named)
        return self._run("forced_dynamics", {**given, "forces": forces}, t, values, named)

    def inverse_dynamics(
        self,
        q: ArrayLike,
        u: ArrayLike,
        udot: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        actuators: Any = None,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Array:
        """Generalized forces τ that the motion needs beyond the model's loads [N, N m].

        Parameters
        ----------
        udot : array, shape (n_u,)
            Accelerations. With ``actuators`` they keep the constraints, as :meth:`accelerations` finds them.
        actuators : "all", or names of coordinates or joints, optional
            Of a machine with constraints: where forces act. Of more actuators than degrees of freedom, the
            smallest forces Σ τ² of all that give the motion.

        Returns
        -------
        ndarray
            One force for each actuator, in their order (all speeds for "all"); without ``actuators``, τ = M u' + h of
            the tree without its constraints, shape (n_u,).

        Raises
        ------
        ModelError
            Accelerations that break the constraints, too few actuators, and positions in which they lock up.
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
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Array:
        """All accelerations u' that keep the constraints, where those of some coordinates are given, shape (n_u,).

        Parameters
        ----------
        given : mapping of coordinate or joint to number
            Second derivatives, ``{"crank": 2.0}``, of as many coordinates as there are degrees of freedom.

        Raises
        ------
        ModelError
            Accelerations that leave others open or contradict the constraints.
        """
        G, gamma = self._conditions(q, u, t, values, named)
        if G.ndim != 2:
            raise ModelError("Expected one state for accelerations, got a batch.")
        if not isinstance(given, Mapping):
            raise ModelError(f"Expected accelerations by name, such as {{'crank': 2.0}}, got {given!r}.")
        places = chosen(self.model, list(given)) if given else []
        wanted = np.zeros(len(places))
        for k, (name, x) in enumerate(given.items()):
            number = array(x, f"the acceleration of '{name}'")
            if number.shape != () or not np.isfinite(number):
                raise ModelError(f"Expected a finite number for the acceleration of '{name}', got {x!r}.")
            wanted[k] = number
        return completed(self.model, G, gamma, places, wanted)

    def singularity(
        self,
        q: ArrayLike,
        t: float = 0.0,
        *,
        actuators: Any = None,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Singularity:
        """Whether a machine with loops is in, or near, a singular position: a branch, or a lock-up of ``actuators``.

        Parameters
        ----------
        q : array, shape (n_q,)
            A position that closes the loops.
        actuators : names of coordinates or joints, optional
            Which of them drive the machine; without, only branches are looked for.

        Returns
        -------
        Singularity
        """
        check_conditions(self.model, self._active)
        x = np.zeros(self.model.n_u)
        found = self._all_conditions(q, x, t, values, named)
        if found.ndim != 2:
            raise ModelError("Expected one position for singularity, got a batch.")
        if not np.isfinite(found).all():
            raise ModelError(
                f"Expected a position in which the conditions of '{self.model.name}' have values, got q = {q!r}."
            )
        M = self._run("mass_matrix", {"q": q}, t, values, named)
        active = self._active or ()
        places = None if actuators is None else chosen(self.model, actuators)
        return singularity(self.model, found[:, :-1], M, len(active), active, places)

    def _conditions(
        self, q: ArrayLike, u: ArrayLike, t: Any, values: Mapping[Any, Any] | None, named: Mapping[str, Any]
    ) -> tuple[Array, Array]:
        """G and γ of the independent conditions."""
        check_conditions(self.model, self._active)
        x = self._all_conditions(q, u, t, values, named)
        x = x[..., list(self._active or ()), :]
        return x[..., :-1], x[..., -1]

    def _all_conditions(
        self, q: ArrayLike, u: ArrayLike, t: Any, values: Mapping[Any, Any] | None, named: Mapping[str, Any]
    ) -> Array:
        """G and γ of all conditions by rows, shape (..., rows, n_u + 1); no rows without constraints."""
        given = {"q": q, "u": u}
        if self.model.constraints:
            return self._run("conditions", given, t, values, named)
        *_, count = checked(self.model, given, t, parameters_given(self.model, values, named))
        return np.zeros((*(() if count is None else (count,)), 0, self.model.n_u + 1))

    def mass_matrix(
        self, q: ArrayLike, t: ArrayLike = 0.0, *, values: Mapping[Any, Any] | None = None, **named: Any
    ) -> Array:
        """M, symmetric, shape (n_u, n_u) [kg, kg m, kg m²]."""
        return self._run("mass_matrix", {"q": q}, t, values, named)

    def bias(
        self,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Array:
        """h: what remains of M u' + h at u' = 0, the model's loads included, shape (n_u,) [N, N m]."""
        return self._run("bias", {"q": q, "u": u}, t, values, named)

    def coordinate_rates(
        self,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Array:
        """q', shape (n_q,): u itself, but for ball and free joints."""
        return self._run("coordinate_rates", {"q": q, "u": u}, t, values, named)

    def derivatives(
        self,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Derivatives:
        """Exact derivatives of :meth:`forward_dynamics` by q and u (of a quaternion, by its four components)."""
        n_q = self.model.n_q
        J = self._run("derivatives", {"q": q, "u": u}, t, values, named)
        return Derivatives(J[..., :n_q], J[..., n_q:])

    # --- energies, places, forces --------------------------------------------------------------

    def kinetic_energy(
        self,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Any:
        """Kinetic energy of all bodies [J], a number or shape (N,)."""
        return self._run("kinetic_energy", {"q": q, "u": u}, t, values, named)

    def potential_energy(
        self, q: ArrayLike, t: ArrayLike = 0.0, *, values: Mapping[Any, Any] | None = None, **named: Any
    ) -> Any:
        """Potential energy of weight (zero at the ground's origin) and springs [J], a number or shape (N,)."""
        return self._run("potential_energy", {"q": q}, t, values, named)

    def poses(
        self, q: ArrayLike, t: ArrayLike = 0.0, *, values: Mapping[Any, Any] | None = None, **named: Any
    ) -> dict[str, Posture]:
        """Rotation (3, 3) and position (3,) of every body, by name."""
        x = self._run("poses", {"q": q}, t, values, named)
        return {
            name: Posture(x[..., k, :9].reshape(*x.shape[:-2], 3, 3), x[..., k, 9:])
            for k, name in enumerate(self.model.bodies)
        }

    def momentum(
        self,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Momentum:
        """Momentum of all bodies (3,), and its moment about the ground's origin (3,)."""
        x = self._run("momentum", {"q": q, "u": u}, t, values, named)
        return Momentum(x[..., :3], x[..., 3:])

    def velocities(
        self,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
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
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> dict[str, Reaction]:
        """Force (3,) and moment (3,) of every joint on its child, by name.

        Parameters
        ----------
        udot : array, shape (n_u,), optional
            Accelerations; without them, those of the motion.
        """
        name, given = ("reactions", {"q": q, "u": u})
        if udot is not None:
            name, given = "reactions_at", {**given, "udot": udot}
        x = self._run(name, given, t, values, named)
        names = transmitting(self.model) if udot is None else self.model.joints
        return {name: Reaction(x[..., k, :3], x[..., k, 3:]) for k, name in enumerate(names)}

    def jacobian(
        self,
        point: Any,
        q: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Array:
        """J of a point of a body, shape (6, n_u): (angular velocity of the body, velocity of the point) = J u.

        Both are in ground axes; the motion that driven joints give is not part of J u.

        Parameters
        ----------
        point : Point, Body or str
            A point of a body; a body, or its name, stands for its origin.
        """
        place = place_of(self.model, point)
        key = ("jacobian", place.body.name, place.components)
        return self._run(key, {"q": q}, t, values, named, jacobian_of(place))

    def value(
        self,
        expressions: Any,
        q: ArrayLike,
        u: ArrayLike,
        t: ArrayLike = 0.0,
        *,
        values: Mapping[Any, Any] | None = None,
        **named: Any,
    ) -> Any:
        """An expression of the model's names, or a sequence of them, shape (number of expressions,)."""
        several = isinstance(expressions, Sequence) and not isinstance(expressions, str)
        given = [
            self.model.names.expression(e, "an expression to evaluate")
            for e in (expressions if several else [expressions])
        ]
        key = ("value", tuple(given), several)
        return self._run(key, {"q": q, "u": u}, t, values, named, values_of(given, several))

    # --- derivatives ---------------------------------------------------------------------------

    def derivative(self, product: str, by: Any, *, point: Any = None) -> Callable[..., Any]:
        """The exact derivative of a product as a function, recorded from its trace: no differences are taken.

        Parameters
        ----------
        product : str
            ``"forward_dynamics"``, ``"forced_dynamics"`` (with forces), ``"inverse_dynamics"``, ``"mass_matrix"``,
            ``"bias"``, ``"coordinate_rates"``, ``"kinetic_energy"``, ``"potential_energy"``, ``"momentum"``,
            ``"poses"``, ``"velocities"``, ``"reactions"``, ``"reactions_at"`` (with u'), ``"jacobian"`` (of ``point``),
            and with constraints ``"conditions"`` (G and γ of G u' + γ = 0, by rows).
        by : str or Symbol
            An input of the product (``"q"``, ``"u"``, ``"udot"``, ``"forces"``), ``"t"``, ``"parameters"`` (all, in the
            model's order), one parameter, or ``"displacement"``. By q, the four components of a
            quaternion count as independent numbers; by displacement, the configuration is turned and moved by a
            unit of each speed, ∂f/∂q G with q' = G(q) u, which has n_u columns.
        point : Point, Body or str
            For ``"jacobian"``.

        Returns
        -------
        function
            Of the product's inputs, one after the other, then t, ``values=`` and parameters by name, as of the other
            methods. Result: the shape of the product with one more axis; none for time and for one parameter.
            Bodies and joints stand in the order of the model, as (12,) for a pose (rotation by rows, position) and
            (6,) for a velocity (angular, linear) and a reaction (force, moment).

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
        if isinstance(product, str) and product == "jacobian" and point is not None:
            place = place_of(self.model, point)
            base, key = jacobian_of(place), ("jacobian", place.body.name, place.components, by)
            found = derivative_of(self.model, base, by)
        else:
            if point is not None or isinstance(product, str) and product == "jacobian":
                raise ModelError("Expected point= together with the product 'jacobian', and only there.")
            found = derivative_of(self.model, product_named(self.model, product), by)
            key = f"{product}_by_{by}"  # type: ignore[assignment]

        def function(*arrays: ArrayLike, values: Mapping[Any, Any] | None = None, **named: Any) -> Any:
            names = (*found.inputs, "t")
            given = dict(zip(names, arrays, strict=False))
            for name in names:
                if name in named and name not in given:
                    given[name] = named.pop(name)
            missing = [name for name in found.inputs if name not in given]
            if missing or len(arrays) > len(names):
                raise ModelError(
                    f"Expected {', '.join(found.inputs)} and, if it matters, t for the derivative of '{product}', "
                    f"got {len(arrays)} arguments."
                )
            t = given.pop("t", 0.0)
            return self._run(key, given, t, values, named, found)

        function.__name__ = function.__qualname__ = f"{product}_by_{by}"
        return function

    # --- export --------------------------------------------------------------------------------

    def to_c(self, *products: str, name: str | None = None) -> CSource:
        """Products as one C99 source file and its header, which need nothing but the C library's mathematics.

        Parameters
        ----------
        *products : str
            As of :meth:`derivative`; ``"forward_dynamics_by_q"`` is a derivative. Without any, all that the
            machine has but derivatives.
        name : str, optional
            Of the files and before the functions; the model's name if not given.

        Returns
        -------
        CSource
            With ``source``, ``header`` and ``write(folder)``.
        """
        from .export.source_text import c_source

        return c_source(self.model, products, self._active, name)

    def to_numpy(self, *products: str) -> PythonSource:
        """Products as Python functions f(q, u, ..., t, p) of NumPy arrays, with any leading axes.

        The result is called by name, ``result["bias"](q, u)``; its ``source`` needs NumPy only.
        """
        from .export.source_text import python_source

        return python_source(self.model, products, self._active, "numpy")

    def to_jax(self, *products: str) -> PythonSource:
        """Products as Python functions of JAX arrays, to be given to ``jax.jit``, ``grad`` and ``vmap``."""
        from .export.source_text import python_source

        return python_source(self.model, products, self._active, "jax")

    def to_casadi(self, *products: str) -> CasadiFunctions:
        """Products as ``casadi.Function`` by name, of the inputs q, u, ..., t and the parameters p as columns."""
        from .export.source_text import casadi_functions

        return casadi_functions(self.model, products, self._active)

    # --- what lies below -----------------------------------------------------------------------

    def kernel(self, name: str, batch: bool = False) -> Kernel:
        """The machine code of a product (``"forward_dynamics"``, ...), for callers that use addresses.

        The state y of the kernel is what the product depends on, one after the other: q, u, u' or forces.
        """
        made = self._compiled(name, self._product(name), batch)
        return made.of_rows(shared=False) if batch and isinstance(made, LoopedKernel) else made["f"]

    def constants(
        self, name: str = "forward_dynamics", values: Mapping[Any, Any] | None = None, **named: Any
    ) -> Array:
        """The vector c for the kernel of a product at these values of the parameters."""
        given = parameters_given(self.model, values, named)
        return self._hoisted(name, self._compiled(name, self._product(name), False), given).copy()

    def describe(self, *names: str) -> str:
        """Operations, size and compile time of the products named, or of all compiled so far, a line each.

        Operations are those of one state, ``once`` those done once per set of parameters; the size is that of the
        object code with its batch form where there is one; the time is that
        of compiling the recorded program, and ``from the disk`` says that it was spent earlier.

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
            made = self._sets[name][0]
            operations = made.operations
            once = sum(operations["parameters"].values())
            parts = ", ".join(f"{count} {code}" for code, count in operations["f"].items())
            total = sum(operations["f"].values())
            lines.append(
                f"{_title(name)}: {total} operations ({parts or 'none'}); {once} once per parameters; "
                f"{made.size / 1e3:.1f} kB, compiled in {made.seconds * 1e3:.0f} ms"
                f"{' (from the disk)' if made.from_disk else ''}{made.remark}"
            )
        return "\n".join(lines)

    def _product(self, name: str) -> Product:
        return product_named(self.model, name)

    def _compiled(self, key: Any, product: Product, batch: bool) -> KernelSet | LoopedKernel:
        kept = self._sets.get(key)
        if kept is None or (batch and not kept[1]):
            if product.moves:
                check_conditions(self.model, self._active)
            kept = self._sets[key] = self._looped(key, product) or (
                compiled(self.model, product, batch, self._active),
                batch,
            )
            self._constants.pop(key, None)
            for plain in self._plain:
                plain.pop(key, None)
        return kept[0]

    def _looped(self, key: Any, product: Product) -> tuple[Any, bool] | None:
        """The kernel of a large tree, of one state and of batches."""
        found = looped_kernel(self.model, key, product, self._large)
        return None if found is None else (found, True)

    def _run(
        self,
        key: Any,
        given: Mapping[str, ArrayLike],
        t: ArrayLike,
        values: Mapping[Any, Any] | None,
        named: Mapping[str, Any],
        product: Product | None = None,
    ) -> Any:
        """Result of a product, in its shape."""
        parameters = parameters_given(self.model, values, named)
        state = tuple(given.values())
        batch = type(state[0]) is np.ndarray and state[0].ndim == 2
        plain = self._plain[batch].get(key) if type(t) is float else None
        if plain is not None:
            kernel, c, widths, shape = plain
            shapes = [state[0].shape[:1] + width for width in widths] if batch else widths
            if all(map(is_plain, state, shapes)) and NUMBERS.issuperset(map(type, parameters.values())):
                # the most common calls in a third of the time
                if c is None or parameters:
                    c = self._hoisted(key, self._sets[key][0], parameters)
                if batch:
                    out = kernel.batch_of_parts(t, state, c, threads=self.threads)
                    return out if len(shape) == 1 else out.reshape(len(out), *shape)
                out = kernel.unchecked(t, state[0] if len(state) == 1 else np.concatenate(state), c)
                return out if len(shape) == 1 else out.reshape(shape) if shape else float(out[0])
        if self.model.signals:
            parameters = {**signals_at(self.model, t), **parameters}
        arrays, time, count = checked(self.model, given, t, parameters)
        if product is None:
            product = self._product(key)
        program = self._compiled(key, product, count is not None)
        shape = product.shape(self.model)
        c = self._hoisted(key, program, parameters)
        kernel = program["f"]
        if isinstance(program, LoopedKernel) and count is not None:
            kernel = program.of_rows(shared=c.ndim == 1)
        if c.ndim == 1 and not self.model.signals:
            widths = tuple(x.shape[-1:] for x in arrays.values())
            self._plain[count is not None][key] = (kernel, None if parameters else c, widths, shape)
        if count is None:
            out = kernel(float(time), np.concatenate(list(arrays.values())), c)
            return out.reshape(shape) if shape else float(out[0])
        parts = [x if x.ndim == 2 else np.broadcast_to(x, (count, len(x))) for x in arrays.values()]
        out = kernel.batch_of_parts(time, parts, c, threads=self.threads)
        return out.reshape(count, *shape)

    def _hoisted(self, key: Any, program: KernelSet | LoopedKernel, parameters: Mapping[str, Any]) -> Array:
        """The vector c, or one for each state; the last few are kept."""
        known = self._constants.setdefault(key, OrderedDict())
        columns = {name: value for name, value in parameters.items() if isinstance(value, np.ndarray)}
        label: Any = None
        if not columns:
            if not NUMBERS.issuperset(map(type, parameters.values())):  # a text and a number may print alike
                parameters = self.model.values(parameters)
            label = tuple(sorted(parameters.items()))
            if label in known:
                known.move_to_end(label)
                return known[label]
        single = {name: value for name, value in parameters.items() if name not in columns}
        one = self.model.values({**single, **{name: 0 for name in columns}})
        if self._assumptions is None:
            self._assumptions = assumptions(self.model)
        check_parameters(self.model, self._assumptions, columns, one)
        if not columns:
            c = known[label] = program.constants([*one.values()])
            while len(known) > _KEPT:
                known.popitem(last=False)
            return c
        count = len(next(iter(columns.values())))
        P = np.empty((count, len(one)))
        for k, (name, number) in enumerate(one.items()):
            P[:, k] = columns.get(name, number)
        return program.constants(P)


def _title(key: Any) -> str:
    if isinstance(key, str):
        return key
    return f"{key[0]} of {', '.join(map(str, key[1:]))}"
