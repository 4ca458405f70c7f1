"""``method="timestepping"``: many contacts with friction, in steps of given length.

The loop is `moreau`; here it gets its kernels and its memory, and what it did becomes a trajectory. The method is of
first order in the step, impacts fall on the step they happen in, and what is exact are the laws: in every step each
contact satisfies Signorini's and Coulomb's conditions to the residual that the trajectory states.
"""

from __future__ import annotations

import hashlib
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path as FilePath
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from ..compile import cache as disk
from ..compile import native
from ..dynamics import State, coordinate_rates, mass_matrix
from ..dynamics.constraints import linearized
from ..dynamics.contact import contact_rows
from ..dynamics.energy import load_power
from ..dynamics.newton_euler import bias
from ..errors import SimulationError
from .contact_motion import check_coefficients
from .contact_scene import scene_of_layout
from .contact_trajectory import ContactMotion
from .event import EventSpec
from .initial import number
from .kernels import Kernels, Program
from .loop import LIBRARIES, Function, outside
from .path import FINISHED, INTERRUPTED, TERMINAL, Array, Crossing, Path, Rates, observe
from .phases import EventList
from .polish import polished
from .trajectory import Energy, Trajectory, _ByName

RESIDUAL = 1e-12
"""Speed by which a contact may miss its laws, in parts of the greatest free speed in the problem of a step."""
SWEEPS = 2_000
"""Sweeps of one problem before it is handed to Newton's method (`polish`); ten times more where that fails."""
MOST_SWEEPS = 200_000
_PIECE = 0.1


@dataclass(frozen=True, eq=False)
class Steps(Path):
    """States at the ends of steps, straight between them."""

    def sample(self, times: Any, dense: bool = False) -> Array:
        del dense
        wanted = np.atleast_1d(np.asarray(times, dtype=float))
        outside = ~((wanted >= self.start) & (wanted <= self.end))
        if outside.any():
            raise ValueError(
                f"Expected times within the run, {self.start:g} to {self.end:g}; got {wanted[outside][0]!r}. "
                "Ask for a time inside, or simulate further."
            )
        k = np.clip(np.searchsorted(self.times, wanted, side="right") - 1, 0, max(len(self.times) - 2, 0))
        if len(self.times) == 1:
            return np.repeat(self.states, wanted.size, axis=0)
        x = ((wanted - self.times[k]) / (self.times[k + 1] - self.times[k]))[:, None]
        y = (1 - x) * self.states[k] + x * self.states[k + 1]
        for i in self.rates.quaternions:
            y[:, i : i + 4] /= np.linalg.norm(y[:, i : i + 4], axis=1, keepdims=True)
        return y


class SteppedTrajectory(Trajectory):
    """A motion in steps of given length, made by ``fb.simulate(..., method="timestepping", step=h)``.

    Attributes
    ----------
    residual : float
        Greatest speed by which a contact missed its laws in any step, in parts of the greatest free speed there.
    depth : float
        Greatest penetration at the end of any step [m].
    sweeps : float
        Mean number of Gauss-Seidel sweeps of a step.
    """

    method = "Moreau-Jean time stepping, exact Coulomb cones"

    def __init__(
        self,
        *arguments: Any,
        impulses: Array,
        works: Array,
        residual: float,
        depth: float,
        sweeps: float,
        scene: Any,
    ) -> None:
        super().__init__(*arguments)
        self.residual, self.depth, self.sweeps = residual, depth, sweeps
        self._impulses, self._works, self._layout = impulses, works, scene

    def _step_of(self, times: Array) -> Any:
        """The step that ends at or after each time."""
        ends = self.path.times[1:]
        return np.clip(np.searchsorted(ends, times, side="left"), 0, max(len(ends) - 1, 0))

    def mean_forces(self, times: Array) -> Array:
        """Contact forces, means over the step that ends at or after each time, in the order of the layout [N]."""
        lengths = np.diff(self.path.times)
        if not len(lengths):
            return np.zeros((len(times), self._impulses.shape[1]))
        k = self._step_of(times)
        return np.asarray(self._impulses[k] / lengths[k, None])

    def work_until(self, times: Array) -> Array:
        """Work done since the start, and of that by contacts, shape (n, 2) [J]."""
        total = np.concatenate([[[0.0, 0.0]], np.cumsum(self._works, axis=0)])
        columns = [np.interp(times, self.path.times, column) for column in total.T]
        return np.column_stack([columns[0] + columns[1], columns[0]])

    @cached_property
    def contacts(self) -> dict[str, ContactMotion]:
        """Gap, mean forces over the step, slip and mode of every contact, by name."""
        first, tangents = self._layout
        kernels = self.kernels
        program = _gaps(kernels)
        found = self._observed(program, "contact", self.t, self.states)
        E = len(first)
        gaps, rates = found[:, :E], found[:, E:]
        lengths = np.diff(self.path.times)
        k = self._step_of(self.t)
        forces = (
            self._impulses[k] / lengths[k, None] if len(lengths) else np.zeros((len(self.t), rates.shape[1]))
        )
        result = {}
        for e, contact in enumerate(kernels.model.contacts):
            at, n = first[e], tangents[e]
            lam, v = forces[:, at : at + 1 + n], rates[:, at + 1 : at + 1 + n]
            mu = number(kernels.model, self.values, contact.friction, "a coefficient of friction")
            T = np.linalg.norm(lam[:, 1:], axis=1)
            margin = mu * lam[:, 0] - T
            slipping = np.linalg.norm(v, axis=1) > 1e-9
            mode = np.where(lam[:, 0] > 0, np.where(slipping, "slip", "stick"), "open")
            result[contact.name] = ContactMotion(
                gaps[:, e], lam[:, 0], lam[:, 1] if n == 1 else lam[:, 1:], v[:, 0] if n == 1 else v,
                np.where(mode == "open", np.nan, margin), mode, lam,
            )  # fmt: skip
        return _ByName("contact", result)

    @cached_property
    def energy(self) -> Energy:
        """The energy ledger, whose residual is the error of the steps, of first order in their length."""
        times = np.concatenate([[self.path.start], self.t])
        states = np.concatenate([self.path.states[:1], self.states])
        both = self._observed(self.kernels.motion(), "energy", times, states)
        total = np.concatenate([[[0.0, 0.0]], np.cumsum(self._works, axis=0)])
        work = np.array([np.interp(times, self.path.times, column) for column in total.T])
        residual = both.sum(axis=1) - both[0].sum() - work.sum(axis=0)
        return Energy(both[1:, 0], both[1:, 1], work.sum(axis=0)[1:], residual[1:], work[0][1:])

    @property
    def events(self) -> Any:
        """Where the expressions that were asked for pass through zero, between two steps."""
        return EventList(super().events)

    @property
    def reactions(self) -> Any:
        raise SimulationError(
            "Reactions of joints are not kept by method='timestepping', which knows impulses of steps. Contact forces "
            "are in .contacts; for reactions, simulate with method='auto'."
        )


def _gaps(kernels: Kernels) -> Program:
    def functions(state: State) -> Mapping[str, Sequence[Any]]:
        given = contact_rows(kernels.model, state)
        return {"contact": [*given.gap, *given.rate]}

    return kernels._program("gaps", functions)


def _stepping(kernels: Kernels) -> Program:
    """Functions ``system`` and ``moving``; see `moreau.march`."""
    model = kernels.model

    def functions(state: State) -> Mapping[str, Sequence[Any]]:
        given = contact_rows(model, state)
        held = linearized(model, state)
        active = kernels.active
        M = mass_matrix(model, state)
        return {
            "system": [
                *(x for row in M for x in row),
                *(-x for x in bias(model, state)),
                *given.gap,
                *(x for row in given.matrix for x in row),
                *(x for i in active for x in held.matrix[i]),
                *given.drift,
                *(held.rate[i] - _dot(held.matrix[i], state.u) for i in active),
                *(held.residual[i] for i in active),
            ],
            "moving": [*coordinate_rates(model, state), load_power(model, state)],
        }

    return kernels._program("stepping", functions)


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    total: Any = 0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def stepped_motion(
    kernels: Kernels,
    values: Mapping[str, float],
    state: Array,
    begin: float,
    end: float,
    specs: Sequence[EventSpec],
    expressions: Sequence[Any],
    tolerances: Array,
    times: Array | None,
    samples: int | None,
    *,
    step: Any,
    impulses: Any,
    between: Callable[[float], None] | None,
) -> SteppedTrajectory:
    """The motion of a machine with contacts in equal steps; arguments as of `simulate`, read."""
    model = kernels.model
    if not model.contacts:
        raise SimulationError(
            "method='timestepping' is for machines with contacts, and this one has none. Take method='auto'."
        )
    if step is None:
        raise SimulationError(
            "Expected the length of a step for method='timestepping', such as step=1e-3 [s]."
        )
    h = number(model, values, step, "step")
    if not h > 0:
        raise SimulationError(f"Expected a step greater than 0 s, got step={h:g}.")
    if end < begin:
        raise SimulationError(
            "Friction and impacts have no way back: a run with contacts needs until later than start."
        )
    if impulses:
        raise SimulationError("impulses= are not applied by method='timestepping'. Take method='auto'.")
    check_coefficients(model, values)
    different = [
        c.name
        for c in model.contacts
        if number(model, values, c.friction, "mu") != number(model, values, c.static_friction, "mu_s")
    ]
    if different:
        raise SimulationError(
            f"method='timestepping' knows one coefficient of friction, but contact '{different[0]}' has a static one "
            f"besides. Leave static_friction out, or take method='auto'."
        )
    count = max(round((end - begin) / h), 1 if end > begin else 0)
    if count and abs(count * h - (end - begin)) > 1e-9 * max(h, abs(end)):
        count = math.ceil((end - begin) / h)
    h = (end - begin) / count if count else h
    return _march(
        kernels, values, state, begin, h, count, specs, expressions, tolerances, times, samples, between
    )


def _march(
    kernels: Kernels, values: Any, state: Array, begin: float, h: float, count: int, specs: Any, expressions: Any,
    tolerances: Any, times: Any, samples: Any, between: Any,
) -> SteppedTrajectory:  # fmt: skip
    model = kernels.model
    first, tangents, m = scene_of_layout(model)
    n_q, n, E, held = model.n_q, model.n_u, len(first), len(kernels.active)
    program = _stepping(kernels)
    constants = program.constants(kernels.parameters(values))
    width = m + held

    def coefficient(name: str) -> Array:
        return np.array([number(model, values, getattr(c, name), name) for c in model.contacts])

    y = np.array(state[: n_q + n], dtype=float)
    y0 = y.copy()
    reals = {name: np.zeros(size) for name, size in (
        ("z", n_q + n + width), ("out", program.outputs("system")), ("rate", n_q + 1), ("L", n * n),
        ("X", width * n), ("A", width * width), ("b", width), ("x", width), ("memory", width),
    )}  # fmt: skip
    rows, kinds = np.zeros(width, dtype=np.int64), np.zeros(width, dtype=np.int64)
    coefficients, v, report = np.zeros(width), np.zeros(n), np.zeros(5)
    sizes = np.array(tangents, dtype=np.int64)
    quaternions = np.array(model.quaternions, dtype=np.int64)
    mu, e = coefficient("friction"), coefficient("restitution")
    blocks: list[tuple[Array, Array, Array]] = []
    done, status = 0, FINISHED
    stop: Crossing | None = None
    sweeps = SWEEPS
    march = loop()
    depth = observe(
        _gaps(kernels).address("contact"), E + m, np.array([begin]), y[None],
        _gaps(kernels).constants(kernels.parameters(values)),
    )[0, :E]  # fmt: skip
    if depth.min(initial=0) < -1e-9:
        worst = int(depth.argmin())
        raise SimulationError(
            f"The initial state of '{model.name}' has contact '{model.contacts[worst].name}' {-depth[worst]:.6g} m "
            f"deep. Begin with every gap at zero or above."
        )
    terminal = [i for i, spec in enumerate(specs) if spec.terminal]
    block = max(1, min(100 if terminal else 1000, count))
    try:
        while done < count:
            size = min(block, count - done)
            states, impulses, works = np.empty((size, n_q + n)), np.empty((size, m)), np.empty((size, 2))
            got = march(
                program.address("system"), program.address("moving"), constants, n_q, n, E, m, held, sizes, mu, e,
                quaternions, len(quaternions), np.array([begin + done * h, h, RESIDUAL]), size, y, reals["z"],
                reals["out"], reals["rate"], reals["L"], reals["X"], reals["A"], reals["b"], reals["x"],
                reals["memory"], rows, kinds, coefficients, v, states, impulses, works, report, sweeps,
            )  # fmt: skip
            blocks.append((states[:got], impulses[:got], works[:got]))
            done += got
            if got > 0:
                sweeps = SWEEPS
            if got < size and np.isfinite(y).all() and sweeps <= MOST_SWEEPS and report[4] > 0:
                found = _by_newton(reals, rows, kinds, coefficients, int(report[4]))
                if not found or got == 0:
                    sweeps *= 10
                continue
            if got < size or not np.isfinite(y).all():
                raise SimulationError(
                    f"The contacts of '{model.name}' were not solved in the step at t = {begin + done * h:.9g} s: "
                    f"after {MOST_SWEEPS} sweeps, and Newton's method, a law is still missed by {report[3]:.3g} of the "
                    f"greatest speed (to reach: {RESIDUAL:g}). A shorter step, or masses less far apart, need fewer."
                )
            if terminal:
                whole = np.concatenate([y0[None] if len(blocks) == 1 else blocks[-2][0][-1:], blocks[-1][0]])
                moments = begin + h * np.arange(done - got, done + 1, dtype=np.float64)
                passed = _crossings(kernels, values, specs, expressions, moments, whole)
                stop = next((c for c in passed if c.number in terminal), None)
                if stop is not None:
                    status = TERMINAL
                    break
            if between is not None:
                between(begin + done * h)
    except KeyboardInterrupt:
        status = INTERRUPTED
    states = np.concatenate([y0[None], *(b[0] for b in blocks)])
    impulses = np.concatenate([np.empty((0, m)), *(b[1] for b in blocks)])
    works = np.concatenate([np.empty((0, 2)), *(b[2] for b in blocks)])
    moments = begin + h * np.arange(len(states), dtype=np.float64)
    if stop is not None:  # within a step: its part up to the event
        k = int(np.searchsorted(moments, stop.time, side="left"))
        part = (stop.time - moments[k - 1]) / h
        states, moments = np.concatenate([states[:k], stop.state[None]]), np.append(moments[:k], stop.time)
        impulses, works = impulses[:k].copy(), works[:k].copy()
        impulses[-1] *= part
        works[-1] *= part
    rates = Rates(0, n_q + n, constants, tuple(model.quaternions), program)
    crossings = _crossings(kernels, values, specs, expressions, moments, states)
    if stop is not None:  # the last state is the event itself
        earlier = (
            c for c in crossings if c.time < moments[-2] or (c.time < stop.time and c.number != stop.number)
        )
        crossings = (*earlier, stop)
    lengths = np.diff(moments)
    path = Steps(rates, moments, lengths, states, crossings, status, 0, 0, len(states))
    return SteppedTrajectory(
        kernels, values, path, specs, tolerances, times, samples, impulses=impulses, works=works,
        residual=float(report[0]), depth=float(report[2]), sweeps=float(report[1]) / max(done, 1),
        scene=(first, tangents),
    )  # fmt: skip


def _by_newton(reals: Mapping[str, Array], rows: Any, kinds: Any, coefficients: Array, count: int) -> bool:
    """Solve the problem on which the sweeps stopped. Its impulses, or else those reached, begin the next try."""
    width = len(reals["x"])
    A, b, x = reals["A"].reshape(width, width)[:count, :count], reals["b"][:count], reals["x"][:count]
    found = polished(A, b, kinds[:count], coefficients[:count], x.copy(), RESIDUAL / 3)
    reals["memory"][:] = 0.0
    reals["memory"][rows[:count]] = x if found is None else found
    return found is not None


def _crossings(
    kernels: Kernels, values: Any, specs: Any, expressions: Any, times: Array, states: Array
) -> tuple[Crossing, ...]:
    """Zeros of the user's events between the ends of steps, by the chord."""
    if not specs:
        return ()
    program = kernels.expressions(expressions)
    g = observe(
        program.address("values"), len(specs), times, states, program.constants(kernels.parameters(values))
    )
    result = []
    for i, spec in enumerate(specs):
        for k in np.flatnonzero((g[:-1, i] * g[1:, i] < 0) | ((g[1:, i] == 0) & (g[:-1, i] != 0))):
            sign = 1 if g[k, i] < 0 else -1
            if spec.direction in (0, sign):
                x = g[k, i] / (g[k, i] - g[k + 1, i])
                result.append(
                    Crossing(
                        float(times[k] + x * (times[k + 1] - times[k])),
                        i,
                        sign,
                        states[k] + x * (states[k + 1] - states[k]),
                    )
                )
    return tuple(sorted(result, key=lambda one: one.time))


# --- the machine code of the loop, from the disk or from numba -----------------------------------

_ONE = threading.Lock()
_SOURCES = ("moreau.py", "machine.py", "layout.py")


def loop() -> Function:
    """`moreau.march`, compiled; kept on the disk as the other loop is (`simulate.loop`)."""
    with _ONE:
        return _loop()


@cache
def _loop() -> Any:
    digest = hashlib.sha256(f"moreau {disk.VERSION} {native.version()}\n".encode())
    for name in _SOURCES:
        digest.update((FilePath(__file__).parent / name).read_bytes())
    key = digest.hexdigest()
    found = disk.load(key)
    if found is not None and all(map(llvm.address_of_symbol, found[0]["needed"])):
        header, code = found
        library = native.Library(code)
        address = next(iter(library.addresses([header["symbol"]]).values()))
        if address:
            return _Kept(Function(address, header["arguments"], header["result"]), library)
    from .moreau import FUNCTIONS

    context = llvm.create_context()
    modules = [llvm.parse_assembly(f.code.inspect_llvm(), context=context) for f in FUNCTIONS.values()]
    for module in modules[1:]:
        modules[0].link_in(module)
    text = str(modules[0])
    needed = outside(text)
    made = FUNCTIONS["march"]
    if LIBRARIES.issuperset(needed):
        code = native.object_code(text)
        disk.store(
            key,
            {
                "needed": needed,
                "symbol": made.code.native_name,
                "arguments": made.arguments,
                "result": made.result,
            },
            code,
        )
    return _Kept(Function(int(made.code.address), made.arguments, made.result), FUNCTIONS)


class _Kept:
    """A function, and what owns its code."""

    def __init__(self, function: Function, keep: Any) -> None:
        self.function, self.keep = function, keep

    def __call__(self, *arguments: Any) -> int:
        return int(self.function(*arguments))
