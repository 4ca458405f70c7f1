"""The peers for motion: the heavy top and the tumbling body in SciPy, MuJoCo and Drake.

Each function prepares outside the clock and returns (seconds, quaternions (w, x, y, z) at the reference times).
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np


def numbers(motion: dict[str, Any]) -> dict[str, Any]:
    """Parameters of a reference motion as floats."""
    values = {}
    for name, value in motion["parameters"].items():
        values[name] = [float(v) for v in value] if isinstance(value, list) else float(value)
    return values


def quaternion_of_angles(psi: Any, theta: Any, phi: Any) -> np.ndarray:
    """(w, x, y, z) of the body-fixed turns psi about Z, theta about X, phi about Z."""
    c, s = np.cos(np.asarray(theta) / 2), np.sin(np.asarray(theta) / 2)
    plus, minus = (np.asarray(psi) + phi) / 2, (np.asarray(psi) - phi) / 2
    return np.stack([c * np.cos(plus), s * np.cos(minus), s * np.sin(minus), c * np.sin(plus)], axis=-1)


def orientation_error(found: np.ndarray, expected: np.ndarray) -> float:
    """Largest angle between two attitudes over the times [rad]; quaternions need not be unit."""
    found = found / np.linalg.norm(found, axis=1, keepdims=True)
    w0, v0, w1, v1 = expected[:, :1], expected[:, 1:], found[:, :1], found[:, 1:]
    between = w0 * v1 - w1 * v0 - np.cross(v0, v1)
    return float(2 * np.arcsin(np.minimum(1.0, np.linalg.norm(between, axis=1))).max())


# -- SciPy on SymPy ------------------------------------------------------------------------------


def scipy_rates(name: str, motion: dict[str, Any]) -> tuple[Any, np.ndarray, Any]:
    """Lambdified rates y' = f(t, y) (``cse`` and plain ``math``: SymPy's fastest), start, attitude."""
    return _scipy_top(motion) if name == "heavy_top" else _scipy_tumbling(motion)


def _scipy_top(motion: dict[str, Any]) -> tuple[Any, np.ndarray, Any]:
    import sympy
    from sympy.physics.mechanics import KanesMethod, Point, ReferenceFrame, RigidBody, dynamicsymbols, inertia

    p = numbers(motion)
    m, R, L, g = (sympy.Float(p[name], 17) for name in ("m", "R", "L", "g"))
    q = dynamicsymbols("psi theta phi")
    u = dynamicsymbols("u1:4")
    N = ReferenceFrame("N")
    A = N.orientnew("A", "Axis", [q[0], N.z])
    B = A.orientnew("B", "Axis", [q[1], A.x])
    C = B.orientnew("C", "Axis", [q[2], B.z])
    C.set_ang_vel(N, u[0] * A.z + u[1] * B.x + u[2] * C.z)
    pivot = Point("O")
    pivot.set_vel(N, 0)
    center = pivot.locatenew("G", L * C.z)
    center.v2pt_theory(pivot, N, C)
    disk = RigidBody("disk", center, C, m, (inertia(C, m * R**2 / 4, m * R**2 / 4, m * R**2 / 2), center))
    kane = KanesMethod(N, q_ind=q, u_ind=u, kd_eqs=[a.diff() - b for a, b in zip(q, u, strict=True)])
    kane.kanes_equations([disk], [(center, -m * g * N.z)])
    accelerations = kane.mass_matrix.applyfunc(sympy.trigsimp).LUsolve(kane.forcing.applyfunc(sympy.trigsimp))
    plain = sympy.symbols("y0:6")
    names = dict(zip([*q, *u], plain, strict=True))
    rhs = sympy.lambdify(plain, [*plain[3:], *(a.subs(names) for a in accelerations)], "math", cse=True)
    start = np.array([0.0, np.arccos(p["cos_theta0"]), 0.0, 0.0, 0.0, p["spin"]])
    return lambda t, y: rhs(*y.tolist()), start, lambda y: quaternion_of_angles(y[0], y[1], y[2])


def _scipy_tumbling(motion: dict[str, Any]) -> tuple[Any, np.ndarray, Any]:
    import sympy

    p = numbers(motion)
    e0, e1, e2, e3, wx, wy, wz = plain = sympy.symbols("e0:4 wx wy wz")
    moments = sympy.diag(*(sympy.Float(value, 17) for value in p["moments"]))
    w = sympy.Matrix([wx, wy, wz])
    acceleration = moments.LUsolve(-w.cross(moments * w))
    turn = sympy.Matrix([[-e1, -e2, -e3], [e0, -e3, e2], [e3, e0, -e1], [-e2, e1, e0]]) * w / 2
    rhs = sympy.lambdify(plain, [*turn, *acceleration], "math", cse=True)
    start = np.array([1.0, 0.0, 0.0, 0.0, *p["w0"]])
    return lambda t, y: rhs(*y.tolist()), start, lambda y: y[:4].T


def scipy_motion(name: str, motion: dict[str, Any], tolerance: float) -> tuple[float, np.ndarray]:
    """``solve_ivp`` with DOP853, rtol = atol = tolerance."""
    from scipy.integrate import solve_ivp

    rates, start, attitude = scipy_rates(name, motion)
    times = motion["times"]
    begin = time.perf_counter()
    result = solve_ivp(rates, (0.0, times[-1]), start, "DOP853", t_eval=times, rtol=tolerance, atol=tolerance)
    elapsed = time.perf_counter() - begin
    return elapsed, attitude(result.y)


# -- MuJoCo --------------------------------------------------------------------------------------


def mujoco_motion(name: str, motion: dict[str, Any], timestep: float) -> tuple[float, np.ndarray]:
    """RK4 with a fixed step, a ball joint, everything but the dynamics switched off."""
    import mujoco

    p = numbers(motion)
    if name == "heavy_top":
        m, R, L = p["m"], p["R"], p["L"]
        mass, center, moments, gravity = m, L, (m * R**2 / 4, m * R**2 / 4, m * R**2 / 2), p["g"]
        half = np.arccos(p["cos_theta0"]) / 2
        attitude, w = (np.cos(half), np.sin(half), 0.0, 0.0), (0.0, 0.0, p["spin"])
    else:
        mass, center, moments, gravity = 1.0, 0.0, p["moments"], 0.0
        attitude, w = (1.0, 0.0, 0.0, 0.0), p["w0"]
    inertia = " ".join(repr(float(value)) for value in moments)
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler inertiafromgeom="false"/>'
        f'<option timestep="{timestep!r}" integrator="RK4" gravity="0 0 {-gravity!r}">'
        f'<flag contact="disable" constraint="disable" sensor="disable"/></option><worldbody><body>'
        f'<inertial mass="{mass!r}" pos="0 0 {center!r}" diaginertia="{inertia}"/><joint type="ball"/>'
        f"</body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = attitude, w
    steps = np.diff(np.round(np.concatenate([[0.0], motion["times"]]) / timestep).astype(int))
    found = []
    begin = time.perf_counter()
    for count in steps:
        mujoco.mj_step(model, data, nstep=int(count))
        found.append(data.qpos.copy())
    return time.perf_counter() - begin, np.array(found)


# -- Drake ---------------------------------------------------------------------------------------


def drake_motion(
    name: str, motion: dict[str, Any], accuracy: float, scheme: str = "runge_kutta3"
) -> tuple[float, np.ndarray]:
    """Continuous plant, error-controlled; the top on three hinges ZXZ with massless frames, the body free."""
    from pydrake.math import RotationMatrix
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import RevoluteJoint, SpatialInertia, UnitInertia
    from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig

    p = numbers(motion)
    plant = MultibodyPlant(0.0)
    if name == "heavy_top":
        m, R, L = p["m"], p["R"], p["L"]
        plant.mutable_gravity_field().set_gravity_vector(np.array([0, 0, -p["g"]]))
        A, C = m * R**2 / 4 + m * L**2, m * R**2 / 2
        top = SpatialInertia(m, np.array([0, 0, L]), UnitInertia(A / m, A / m, C / m))
        parent = plant.world_frame()
        joints = []
        for i, axis in enumerate(np.eye(3)[[2, 0, 2]]):
            body = plant.AddRigidBody(f"b{i}", top if i == 2 else SpatialInertia.Zero())
            joints.append(plant.AddJoint(RevoluteJoint(f"j{i}", parent, body.body_frame(), axis)))
            parent = body.body_frame()
    else:
        plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
        moments = p["moments"]
        body = plant.AddRigidBody("body", SpatialInertia(1.0, np.zeros(3), UnitInertia(*moments)))
    plant.Finalize()
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    if name == "heavy_top":
        plant.SetPositions(context, [0.0, np.arccos(p["cos_theta0"]), 0.0])
        plant.SetVelocities(context, [0.0, 0.0, p["spin"]])
    else:
        plant.SetPositions(context, [1.0, 0, 0, 0, 0, 0, 0])
        plant.SetVelocities(context, [*p["w0"], 0, 0, 0])
    config = SimulatorConfig(integration_scheme=scheme, max_step_size=0.1, accuracy=accuracy)
    ApplySimulatorConfig(config, simulator)
    simulator.Initialize()
    found = []
    begin = time.perf_counter()
    for t in motion["times"]:
        simulator.AdvanceTo(t)
        found.append(
            RotationMatrix(plant.EvalBodyPoseInWorld(context, body).rotation()).ToQuaternion().wxyz()
        )
    return time.perf_counter() - begin, np.array(found)
