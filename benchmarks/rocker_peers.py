"""The crank-rocker of `precision` by others: hand-written equations in SciPy and heyoka, MuJoCo, Drake.

Bars of 0.1, 0.3 and 0.2 m, 4 kg/m, on a base of 0.3 m. The hand-written equations are those of `minimal`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from . import minimal

BARS = (("crank", 0.1), ("coupler", 0.3), ("rocker", 0.2))
ANGLES = ("alpha", "beta", "psi")


def hand_start(initial: dict[str, float]) -> np.ndarray:
    """State of `minimal.crank_rocker`: angles of the bars from the base, speed of the crank."""
    alpha, beta, psi = (initial[name] for name in ANGLES)
    return np.array([alpha, alpha + beta, psi, initial["alpha'"]])


def hand_angles(y: Any) -> np.ndarray:
    """alpha, beta, psi of such states."""
    return np.array([y[0], y[1] - y[0], y[2]])


def hand_rates() -> Callable[[Any, Any], Any]:
    """For numba."""
    import numba
    import sympy

    y, rates = minimal.crank_rocker()
    of = numba.njit(sympy.lambdify(y, rates, "numpy", cse=True))
    return lambda t, y: np.array(of(y[0], y[1], y[2], y[3]))


def heyoka_system(start: np.ndarray) -> tuple[list[tuple[Any, Any]], np.ndarray]:
    """For heyoka, with what the equations share written once."""
    import heyoka as hy
    import sympy

    y, rates = minimal.crank_rocker()
    shared, reduced = sympy.cse(rates)
    made = {symbol: hy.expression(symbol.name) for symbol in y}
    variables = list(made.values())
    for symbol, value in shared:
        made[symbol] = hy.from_sympy(value, made)
    return list(zip(variables, (hy.from_sympy(rate, made) for rate in reduced), strict=True)), start


def mujoco(initial: dict[str, float], end: float, step: float) -> tuple[float, np.ndarray]:
    """RK4; a connect constraint closes the loop, soft, as stiff as the step allows (time constant of 2 steps)."""
    import mujoco as mj

    def bar(i: int, place: str, inner: str = "") -> str:
        name, L = BARS[i]
        inertia = 4 * L**3 / 12
        return (
            f'<body name="{name}" pos="{place}"><inertial mass="{4 * L!r}" pos="{L / 2!r} 0 0" '
            f'diaginertia="1e-6 {inertia!r} {inertia!r}"/><joint type="hinge" axis="0 0 1"/>{inner}</body>'
        )

    model = mj.MjModel.from_xml_string(
        f'<mujoco><compiler inertiafromgeom="false"/><option timestep="{step!r}" integrator="RK4" '
        'gravity="0 -9.81 0" tolerance="1e-14"><flag contact="disable"/></option><worldbody>'
        f'{bar(0, "0 0 0", bar(1, "0.1 0 0"))}{bar(2, "0.3 0 0")}</worldbody><equality><connect body1="coupler" '
        f'body2="rocker" anchor="0.3 0 0" solref="{2 * step!r} 1" solimp="0.9999 0.9999 0.001"/></equality></mujoco>'
    )
    model.eq_data[0, :6] = [
        0.3,
        0,
        0,
        0.2,
        0,
        0,
    ]  # the joint on both bars: at the model's zero they do not meet
    data = mj.MjData(model)
    data.qpos[:], data.qvel[:] = ([initial[name + mark] for name in ANGLES] for mark in ("", "'"))
    begin = time.perf_counter()
    mj.mj_step(model, data, nstep=round(end / step))
    return time.perf_counter() - begin, data.qpos.copy()


def drake(initial: dict[str, float], end: float, step: float) -> tuple[float, np.ndarray]:
    """Steps of the SAP solver, the only one that takes a ball constraint; their error falls as the step."""
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
    from pydrake.multibody.tree import FixedOffsetFrame, RevoluteJoint, SpatialInertia, UnitInertia
    from pydrake.systems.analysis import Simulator

    plant = MultibodyPlant(step)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    plant.mutable_gravity_field().set_gravity_vector(np.array([0, -9.81, 0]))

    def bar(i: int, parent: Any, at: float) -> Any:
        name, L = BARS[i]
        unit = UnitInertia(1e-6, L**2 / 3, L**2 / 3)
        body = plant.AddRigidBody(name, SpatialInertia(4 * L, np.array([L / 2, 0, 0]), unit))
        place = plant.AddFrame(FixedOffsetFrame(f"{name} pin", parent, RigidTransform(np.array([at, 0, 0]))))
        plant.AddJoint(RevoluteJoint(f"{name} joint", place, body.body_frame(), np.array([0, 0, 1])))
        return body

    crank = bar(0, plant.world_frame(), 0.0)
    coupler, rocker = bar(1, crank.body_frame(), 0.1), bar(2, plant.world_frame(), 0.3)
    plant.AddBallConstraint(coupler, np.array([0.3, 0, 0]), rocker, np.array([0.2, 0, 0]))
    plant.Finalize()
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    plant.SetPositions(context, [initial[name] for name in ANGLES])
    plant.SetVelocities(context, [initial[f"{name}'"] for name in ANGLES])
    simulator.Initialize()
    begin = time.perf_counter()
    simulator.AdvanceTo(end)
    return time.perf_counter() - begin, plant.GetPositions(context)
