"""``fb.compile``: the dynamics of a machine as functions of numbers, in machine code.

    M(q, t) u' + h(q, u, t) = τ

for one state or for many at once. Each function is recorded and compiled at its first call, and loaded from the disk by
later processes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from ..describe.system import System
from ..dynamics import float_state
from ..dynamics.conditions.constrained import closed_coordinates, independent_rows
from ..errors import ModelError, arguments_named
from ..model import Model, assemble
from ..rooms_above import module_for
from .arguments import (
    array,
)
from .evaluation import Values
from .motion_equations import MotionEquations
from .products import (
    OF_POINT,
    derivative_of,
    named_variable,
    of_point,
    product_named,
)
from .quantities import Quantities

if TYPE_CHECKING:
    from .export.c import CSource
    from .export.casadi import CasadiFunctions
    from .export.python import PythonSource
    from .export.wasm import WasmModule


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


@arguments_named
class Program(MotionEquations, Quantities):
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
