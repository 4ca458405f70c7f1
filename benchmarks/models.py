"""The benchmark models through freebody's public interface."""

from __future__ import annotations

from typing import Any

import freebody as fb

from .chains import GRAVITY, Link


def planar_chain(n: int) -> Any:
    """``n`` uniform bars that hang on pins, absolute angles, all dimensions symbols."""
    s = fb.System(f"planar chain {n}")
    m = [s.parameters(**{f"m{i}": 1.0}) for i in range(1, n + 1)]
    L = [s.parameters(**{f"L{i}": 1.0}) for i in range(1, n + 1)]
    g = s.parameters(g=9.81)
    s.gravity = (0, -g, 0)
    q = [s.coordinates(f"q{i}") for i in range(1, n + 1)]
    parent, at = s.ground, (0, 0, 0)
    for i in range(n):
        bar = s.body(f"bar{i}", fb.slender_bar(m[i], L[i], axis="y"))
        angle = q[i] if i == 0 else q[i] - q[i - 1]
        s.hinge(f"pin{i}", parent, bar, at=at, to=(0, L[i] / 2, 0), axis="z", coordinate=angle)
        parent, at = bar, (0, -L[i] / 2, 0)
    return s


def spatial_chain(n: int) -> Any:
    """``n`` bodies, hinge axes x, y, x, ..., principal moments of inertia, all dimensions symbols."""
    s = fb.System(f"spatial chain {n}")
    g = s.parameters(g=9.81)
    s.gravity = (0, 0, -g)
    parent, at = s.ground, (0, 0, 0)
    for i in range(1, n + 1):
        m, L, c, Ix, Iy, Iz = s.parameters(
            **{f"m{i}": 1.0, f"L{i}": 0.3, f"c{i}": 0.14, f"Ix{i}": 0.011, f"Iy{i}": 0.012, f"Iz{i}": 0.003}
        )
        body = s.body(f"body{i}", fb.MassProperties(m, (0, 0, -c), ((Ix, 0, 0), (0, Iy, 0), (0, 0, Iz))))
        s.hinge(f"hinge{i}", parent, body, at=at, axis="xy"[(i - 1) % 2], coordinate=f"q{i}")
        parent, at = body, (0, 0, -L)
    return s


BUILDERS = {"planar": planar_chain, "spatial": spatial_chain}


def numeric_chain(links: list[Link]) -> Any:
    """A chain given as numbers, the one its peers get."""
    s = fb.System("chain")
    s.gravity = GRAVITY
    parent = s.ground
    for i, link in enumerate(links):
        body = s.body(f"body{i}", fb.MassProperties(link.mass, link.center, link.inertia))
        s.hinge(f"hinge{i}", parent, body, at=link.at, axis=link.axis, coordinate=f"q{i}")
        parent = body
    return s


def heavy_top(parameters: dict[str, Any]) -> Any:
    """Thin disk on a massless shaft that turns about a fixed point, angles psi, theta, phi (ZXZ)."""
    s = fb.System("heavy top")
    m, R, L, g = s.parameters(**{name: float(parameters[name]) for name in ("m", "R", "L", "g")})
    s.gravity = (0, 0, -g)
    rotor = s.body("rotor", fb.disk(m, R, axis="z"))
    angles = s.coordinates("psi theta phi")
    s.gimbal("pivot", s.ground, rotor, to=(0, 0, -L), axis="ZXZ", coordinate=angles)
    return s


def tumbling_body(parameters: dict[str, Any]) -> Any:
    """Free of torque, three different moments of inertia, attitude as a quaternion."""
    s = fb.System("tumbling body")
    A, B, C = s.parameters(**{name: float(v) for name, v in zip("ABC", parameters["moments"], strict=True)})
    body = s.body("body", fb.MassProperties(1, (0, 0, 0), ((A, 0, 0), (0, B, 0), (0, 0, C))))
    s.ball("turn", s.ground, body)
    return s


def forward_dynamics_kernels(system: Any) -> Any:
    """Machine code of u' = forward dynamics, from the description: assembled, traced, compiled."""
    from freebody.dynamics import forward_dynamics, traced_state
    from freebody.program.kernels import compile_tape
    from freebody.scalar.trace import Tape

    model = fb.assemble(system)
    tape = Tape()
    state = traced_state(model, tape)
    functions = {"accelerations": list(forward_dynamics(model, state))}
    return compile_tape(tape, functions, state.t, [*state.q, *state.u], [])
