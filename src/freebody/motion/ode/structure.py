"""Symplectic Gauss collocation of order 6 with equal steps: in long runs the energy does not drift.

    q' = ∂H/∂P,   P' = -∂H/∂q,        H(q, P) = ½ pᵀ M(q)⁻¹ p + V(q),   p = B(q)ᵀ P,   q' = B(q) u,   u = M⁻¹ p

is integrated in place of (q, u), with the three stages of `gauss`: symplectic, symmetric, of order 6. For a ball
or free joint q holds a unit quaternion e, and P its four momenta. On these the Hamiltonian system is the lift of the
motion on the group. |e|² and e·P are quadratic, so Gauss collocation conserves them to round-off, as it does linear and
angular momentum. The quaternion is never normalised during the run. By backward error analysis the computed states are
those of a machine whose energy differs by O(h⁶), for times that grow exponentially with 1/h. In chaotic motion, if
steps are long compared with its fastest moments, these times are short, and that energy walks at random.

The stages are iterated to round-off and the sums compensated. What remains is a random walk of single round-offs. (q,
P) is carried from step to step. A state between steps is the end of a shorter step. The dense output is cubic: it only
brackets events, which are then located on shorter steps.

Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration (2006), sections VI.4, VII.2, VIII.6, IX.8.
"""

from __future__ import annotations

import math

from ...native.instructions import Truth, compiled
from .gauss import bound_to
from .method import Method, cubic
from .run import Hamiltonian, Run
from .step_control import Functions

STAGES = 3
_bound = bound_to(STAGES, goal=0.0, most=60)
forget, step_from, hold_step, pass_step = (
    _bound[name] for name in ("forget", "step_from", "hold_step", "pass_step")
)


@compiled
def prepare(run: Run, fresh: Truth) -> None:
    """Compute z = (q, P) at y."""
    own = Hamiltonian(run.own)
    m, stages = own.coordinates, own.collocation
    for i in range(m):
        own.z[i] = run.y[i]
    own.momenta(run.t, run.y, stages.c, own.z[m:])
    stages.f(run.t, own.z, stages.c, stages.new)
    forget(stages, 1.0)


@compiled
def attempt(run: Run, h: float) -> int:
    """Take one step of length ``h`` from y to y_new."""
    own = Hamiltonian(run.own)
    m, stages = own.coordinates, own.collocation
    failed = step_from(run, stages, h)
    if failed == 0:
        for i in range(m):
            run.y_new[i] = own.z_new[i]
        own.velocities(run.t + h, own.z_new, stages.c, run.y_new[m:])
    return failed


@compiled
def judge(run: Run, h: float) -> float:
    """Return 0, or nan if the state is not finite: the user prescribes the length of the steps."""
    for i in range(run.n):
        if not math.isfinite(run.y_new[i]):
            run.blame = i
            return math.nan
    return 0.0


@compiled
def densify(run: Run) -> None:
    """Compute the cubic through the states and rates at both ends."""
    cubic(run, 12)


@compiled
def interpolate(run: Run, x: float) -> None:
    """Set the row point: the cubic at the fraction ``x`` (0 to 1) of the step."""
    z = 1.0 - x
    for i in range(run.width):
        p = run.dense[1, i] + x * run.dense[2, i]
        run.point[i] = run.y[i] + x * (run.dense[0, i] + z * p)


@compiled
def hold(run: Run) -> None:
    """Save the step while shorter steps are tried."""
    own = Hamiltonian(run.own)
    hold_step(own.collocation)
    for i in range(own.collocation.v):
        own.saved[i] = own.z_new[i]


@compiled
def accept(run: Run, good: Truth) -> None:
    """Make the end of the step the next start."""
    own = Hamiltonian(run.own)
    pass_step(own.collocation)
    for i in range(own.collocation.v):
        own.z[i] = own.saved[i]


METHOD = Method(
    name="structure", order=6, attempt=attempt, judge=judge, densify=densify, interpolate=interpolate, prepare=prepare,
    hold=hold, accept=accept,
)  # fmt: skip
FUNCTIONS = Functions(METHOD)
