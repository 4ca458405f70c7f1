"""From a motion to a live one: which motions can be, and what they begin with; `program.to_wasm`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ...errors import SimulationError
from ...model import Model
from ...program.export.wasm import WasmModule
from ...scalar.algebra import Expression
from ..contact.course import Touching
from ..contact.history import History
from ..kernels.kernels import Kernels, kernels_of
from ..kernels.sides import sides_of
from ..request import Request, problem_of
from .machine import LiveMachine
from .module import module_of
from .setting import Setting
from .touching_machine import MOST_ROWS

if TYPE_CHECKING:
    from ..trajectory.trajectory import Trajectory

METHOD = "dop853"
"""Method of all live motions: it needs the rates alone."""

MOST_BODIES = 40
"""Most bodies of a machine: the code of its equations grows faster than their number."""

LARGEST = 1_000_000
"""Greatest number of steps that a module has room for."""

FRAMES = 2001
"""Number of frames that a module has room for."""


def check_live(trajectory: Trajectory) -> None:
    """Raise SimulationError for a motion that cannot be computed live, with the reason and a cure.

    Raises
    ------
    SimulationError
        Patches of solids, signals or controllers that switch, blows, dependent conditions, a stiff motion, a large
        machine.
    """
    model = trajectory.kernels.model
    check_machine(trajectory.kernels)
    if model.contacts:
        _check_contacts(trajectory)
    elif trajectory.course.happenings or (
        hasattr(trajectory.path, "segments") and sides_of(trajectory.kernels) is None
    ):
        raise _refusal(
            model, "a motion in one leg", "one that blows, or conditions that depend on each other, interrupt",
            "Leave out the blows, or write the page without live=True",
        )  # fmt: skip
    elif trajectory.path.method == "radau":
        raise _refusal(
            model, "a motion for explicit steps", "a stiff one, for which method 'radau' was needed",
            "Lower the stiffness or the damping that decays fastest, or write the page without live=True",
        )  # fmt: skip


def _check_contacts(trajectory: Trajectory) -> None:
    """Raise SimulationError for a motion with contacts by time steps, from a file, or with blows."""
    model, course = trajectory.kernels.model, trajectory.course
    if not isinstance(course, Touching):
        raise _refusal(
            model, "a motion from event to event", "one by time steps",
            "Leave out method='timestepping', or write the page without live=True",
        )  # fmt: skip
    if not isinstance(course.history, History):
        raise _refusal(
            model, "a motion with contacts that was computed just now", "one from a file",
            "Simulate it again, or write the page without live=True",
        )  # fmt: skip
    if course.history.told:
        raise _refusal(
            model, "a motion without blows", "one with", "Leave them out, or write the page without live=True"
        )


def check_machine(kernels: Kernels) -> None:
    """Raise SimulationError for a machine whose motions cannot be computed live."""
    model = kernels.model
    without = "Write the page without live=True: it shows the motion that was computed here"
    if model.families:
        names = ", ".join(f"'{family.name}'" for family in model.families[:3])
        raise _refusal(model, "contacts of named features", f"contacts of whole bodies, {names}", without)
    if model.patches:  # Python chooses the points of a patch
        names = ", ".join(sorted({f"'{patch.whole.owner}'" for patch in model.patches}))
        raise _refusal(model, "contacts at single points", f"solids that touch in patches, {names}", without)
    count = sum(1 + contact.tangents for contact in model.contacts)
    if count > MOST_ROWS:
        raise _refusal(
            model, f"contacts with at most {MOST_ROWS} forces and components of friction", f"{count}", without
        )
    if model.controllers:
        names = ", ".join(f"'{controller.name}'" for controller in model.controllers[:3])
        raise _refusal(
            model,
            "a machine without controllers",
            f"controller {names}, whose Python does not run in a page",
            without,
        )
    if model.switched:
        raise _refusal(model, "a machine whose forces are smooth in time", "signals that switch", without)
    count = len(model.bodies)
    if count > MOST_BODIES:
        raise _refusal(model, f"a machine of at most {MOST_BODIES} bodies", f"one of {count}", without)
    if kernels.dropped:
        names = ", ".join(map(repr, kernels.dropped[:3]))
        raise _refusal(
            model,
            "conditions that are independent",
            f"{names}, which others imply",
            "Leave such constraints out",
        )


def _refusal(model: Model, expected: str, got: str, cure: str) -> SimulationError:
    return SimulationError(f"Expected {expected} for a live motion of '{model.name}', got {got}. {cure}.")


def setting_of(trajectory: Trajectory, most_steps: int, most_frames: int) -> Setting:
    """Return what a live motion begins with that is this one at first."""
    kernels, path = trajectory.kernels, trajectory.path
    model = kernels.model
    return Setting(
        kernels=kernels,
        values=trajectory.numbers,
        initial=trajectory.initial,
        near=trajectory.near,
        state=path.states[0][: model.n_q + model.n_u].tolist(),
        begin=path.start,
        until=path.end,
        specs=trajectory.specs,
        relative=trajectory.tolerances,
        most_steps=most_steps,
        most_frames=most_frames,
        **_of_contacts(trajectory),
    )


def _of_contacts(trajectory: Trajectory) -> dict[str, Any]:
    """Return what the setting of a motion with contacts has besides; nothing for others."""
    history = getattr(trajectory.course, "history", None)
    if not isinstance(history, History):
        return {}
    it = history.work.it
    return {"longest": it.longest, "sequential": bool(it.sequential), "refuse": bool(it.refuse)}


def wasm_module(
    model: Model, until: Expression, outputs: Sequence[Expression], most_steps: int, **asked: Any
) -> WasmModule:
    """Return a machine and its motion as a WebAssembly module (`Program.to_wasm`)."""
    if not isinstance(most_steps, int) or isinstance(most_steps, bool) or not 0 < most_steps <= LARGEST:
        raise SimulationError(f"Expected most_steps= between 1 and {LARGEST}, got {most_steps!r}.")
    names = model.names
    expressions = [names.expression(x, "outputs=") for x in outputs]
    check_machine(kernels_of(model))
    problem = problem_of(Request(model, until, method=METHOD, **asked))
    check_machine(problem.kernels)
    setting = Setting(
        kernels=problem.kernels,
        values=problem.numbers,
        initial=problem.request.initial or {},
        near=problem.request.near or {},
        state=problem.state.tolist(),
        begin=problem.begin,
        until=problem.end,
        specs=problem.specs,
        relative=problem.tolerances,
        most_steps=most_steps,
        most_frames=FRAMES,
        longest=problem.request.longest_step,
        sequential=problem.request.impacts == "sequential",
        refuse=problem.request.indeterminate == "refuse",
    )
    machine = LiveMachine(
        setting, lambda state, moving, forces: [state(x) for x in expressions], lambda state: ()
    )
    return module_of(machine, outputs=tuple(map(str, outputs)))
