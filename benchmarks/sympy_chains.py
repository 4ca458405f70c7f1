"""The peer for equations: chains by SymPy's ``KanesMethod``, as its own documentation writes them."""

from __future__ import annotations

import multiprocessing
import time
from typing import Any

AXES = "xy"


def planar_chain(n: int) -> Any:
    """``KanesMethod`` of ``n`` uniform bars that hang on pins, absolute angles, equations formed."""
    import sympy
    from sympy.physics.mechanics import (
        KanesMethod,
        Point,
        ReferenceFrame,
        RigidBody,
        dynamicsymbols,
        inertia,
    )

    q = dynamicsymbols(f"q1:{n + 1}")
    u = dynamicsymbols(f"u1:{n + 1}")
    m = sympy.symbols(f"m1:{n + 1}", positive=True)
    L = sympy.symbols(f"L1:{n + 1}", positive=True)
    g = sympy.symbols("g", positive=True)
    N = ReferenceFrame("N")
    pin = Point("O")
    pin.set_vel(N, 0)
    bodies, loads = [], []
    for i in range(n):
        A = N.orientnew(f"A{i}", "Axis", [q[i], N.z])
        A.set_ang_vel(N, u[i] * N.z)
        center = pin.locatenew(f"C{i}", -L[i] / 2 * A.y)
        center.v2pt_theory(pin, N, A)
        end = pin.locatenew(f"P{i}", -L[i] * A.y)
        end.v2pt_theory(pin, N, A)
        bar = inertia(A, m[i] * L[i] ** 2 / 12, 0, m[i] * L[i] ** 2 / 12)
        bodies.append(RigidBody(f"B{i}", center, A, m[i], (bar, center)))
        loads.append((center, -m[i] * g * N.y))
        pin = end
    kane = KanesMethod(N, q_ind=q, u_ind=u, kd_eqs=[qi.diff() - ui for qi, ui in zip(q, u, strict=True)])
    kane.kanes_equations(bodies, loads)
    return kane


def spatial_chain(n: int) -> Any:
    """``KanesMethod`` of ``n`` bodies, hinge axes x, y, x, ..., diagonal inertia, equations formed."""
    import sympy
    from sympy.physics.mechanics import (
        KanesMethod,
        Point,
        ReferenceFrame,
        RigidBody,
        dynamicsymbols,
        inertia,
    )

    q = dynamicsymbols(f"q1:{n + 1}")
    u = dynamicsymbols(f"u1:{n + 1}")
    m, L, c, Ix, Iy, Iz = (
        sympy.symbols(f"{name}1:{n + 1}", positive=True) for name in ("m", "L", "c", "Ix", "Iy", "Iz")
    )
    g = sympy.symbols("g", positive=True)
    N = ReferenceFrame("N")
    frame, joint = N, Point("O")
    joint.set_vel(N, 0)
    bodies, loads = [], []
    for i in range(n):
        axis = getattr(frame, AXES[i % 2])
        A = frame.orientnew(f"A{i}", "Axis", [q[i], axis])
        A.set_ang_vel(frame, u[i] * axis)
        center = joint.locatenew(f"C{i}", -c[i] * A.z)
        center.v2pt_theory(joint, N, A)
        end = joint.locatenew(f"P{i}", -L[i] * A.z)
        end.v2pt_theory(joint, N, A)
        bodies.append(RigidBody(f"B{i}", center, A, m[i], (inertia(A, Ix[i], Iy[i], Iz[i]), center)))
        loads.append((center, -m[i] * g * N.z))
        frame, joint = A, end
    kane = KanesMethod(N, q_ind=q, u_ind=u, kd_eqs=[qi.diff() - ui for qi, ui in zip(q, u, strict=True)])
    kane.kanes_equations(bodies, loads)
    return kane


FORMERS = {"planar": planar_chain, "spatial": spatial_chain}


def form(kind: str, n: int) -> tuple[Any, Any]:
    """Mass matrix and forcing, as SymPy forms them."""
    kane = FORMERS[kind](n)
    return kane.mass_matrix, kane.forcing


def _simplify(kind: str, n: int, pipe: Any) -> None:
    """In a child process: simplify, then print as text; the time of each stage goes back as it ends."""
    import sympy

    mass, forcing = form(kind, n)
    pipe.send(("ready", 0.0))
    start = time.perf_counter()
    mass, forcing = sympy.simplify(mass), sympy.simplify(forcing)
    pipe.send(("simplify", time.perf_counter() - start))
    start = time.perf_counter()
    sympy.pretty(mass, wrap_line=False)
    sympy.pretty(forcing, wrap_line=False)
    pipe.send(("text", time.perf_counter() - start))
    start = time.perf_counter()
    sympy.latex(mass)
    sympy.latex(forcing)
    pipe.send(("latex", time.perf_counter() - start))


def simplified(kind: str, n: int, limit: float) -> dict[str, Any]:
    """Times [s] of ``simplify`` on M and forcing, and of printing the result.

    Runs in a child process that is ended at ``limit`` seconds (of simplify and printing); a stage that was
    not reached by then is ``"> limit s"``.
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    child = context.Process(target=_simplify, args=(kind, n, sender), daemon=True)
    child.start()
    sender.close()
    times: dict[str, Any] = {}
    deadline = time.perf_counter() + 600  # forming, before the clock of the limit starts
    try:
        while len(times) < 4 and receiver.poll(max(0.0, deadline - time.perf_counter())):
            try:
                stage, elapsed = receiver.recv()
            except EOFError:
                raise RuntimeError("SymPy's process ended before its time: see what it printed.") from None
            times[stage] = elapsed
            if stage == "ready":
                deadline = time.perf_counter() + limit
    finally:
        if child.is_alive():
            child.terminate()
        child.join()
    late = f"> {limit:.0f} s"
    return {stage: times.get(stage, late) for stage in ("simplify", "text", "latex")}
