"""Box thrown with a spin about its middle axis: it tumbles (Euler's equations with three different moments).

The box has the edges a > b > c along x, y, z, the size of a book, so that I_x < I_y < I_z. It is seen from its
falling mass centre, where no weight is felt. The spin is about y but for a small part about x and z.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import freebody as fb

from ...exact import torque_free
from ..tools.answer import Answer, Answers, Check, Plots, Solved, same
from ..tools.case import Case, explain, happened, mass_properties
from ..tools.entry import Entry

START = {"flight_wx": "w_x", "flight_wy": "w_y", "flight_wz": "w_z"}


def build() -> fb.System:
    """Return a free body without loads."""
    s = fb.System("tumbling_body")
    m, a, b, c = s.parameters(m=0.6, a=0.2, b=0.12, c=0.03)
    s.parameters(w_x=0.1, w_y=8.0, w_z=0.1, t_1=5.0)
    box = s.body("box", fb.box(m, (a, b, c)))
    s.free("flight", s.ground, box)
    explain(
        s,
        m="kg: mass of the box",
        a="m: edge along x",
        b="m: edge along y",
        c="m: edge along z",
        w_x="rad/s: angular velocity about x at the start",
        w_y="rad/s: angular velocity about y at the start",
        w_z="rad/s: angular velocity about z at the start",
        t_1="s: time to answer for",
    )
    return s


def circled(case: Case, moments: np.ndarray, H: float, T: float) -> str:
    """Return the axis that omega circles in the body: smallest moment if H² < 2 T I_middle, else largest moment."""
    low, middle, high = np.argsort(moments, kind="stable")
    if sum(case[f"w_{axis}"] != 0 for axis in "xyz") < 2:
        return "none: it turns steadily"
    return "xyz"[low if 2 * T * moments[middle] > H**2 else high]


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.cones import cones
    from ...picture.plots.plots import energy_residual, history, saved
    from ...picture.plots.sphere import axis_path, polhode

    box = case.system.bodies["box"]
    inertia = mass_properties(box).inertia
    moments = np.array([case.number(inertia[i][i]) for i in range(3)])
    middle = "xyz"[np.argsort(moments, kind="stable")[1]]
    name = f"flip of {middle}"
    events = [fb.event(f"flight_w{middle}", name=name)]
    # a body that turns about one of its axes never tumbles
    long = case.simulate_past(name, 3, required=False, initial=START, events=events)
    turns = [event.time for event in happened(long, name)]
    steady = "none: it turns steadily"
    flip, period = (turns[1] - turns[0], turns[2] - turns[0]) if len(turns) > 2 else (steady, steady)

    trajectory = case.motion(initial=START, events=events)
    H = np.stack([trajectory[part] for part in case.equations.momentum.angular(box.center)], axis=-1)
    size, T = float(np.linalg.norm(H[0])), float(trajectory.energy.kinetic[0])
    at = case.simulate_to([case["t_1"]], initial=START)
    answers: Answers = {
        "I": Answer("I_x, I_y, I_z", tuple(moments.tolist()), "kg m²"),
        "T": Answer("kinetic energy", T, "J"),
        "H": Answer("angular momentum", size, "kg m²/s"),
        "axis": Answer("axis that omega circles in the body", circled(case, moments, size, T), ""),
        "period": Answer(
            "period of omega in the body",
            period,
            "" if isinstance(period, str) else "s",
            how="fb.simulate, event located",
        ),
        "flip": Answer(
            f"time from one flip to the next: {middle} from nearly along H to nearly against it",
            flip,
            "" if isinstance(flip, str) else "s",
            how="fb.simulate, events located",
        ),
        "omega(t_1)": Answer(
            "omega in body axes at t_1", tuple(float(at[f"flight_w{axis}"][0]) for axis in "xyz"), "rad/s"
        ),
        "axis(t_1)": Answer(
            f"middle axis, {middle}, in ground axes at t_1",
            tuple(at.poses["box"].rotation[0][:, "xyz".index(middle)].tolist()),
            "1",
            how="fb.simulate",
        ),
        "H_change": Answer(
            "largest change of the angular momentum vector, relative",
            float(np.max(np.linalg.norm(H - H[0], axis=1))) / size,
            "",
        ),
    }
    speeds = ["flight_wx", "flight_wy", "flight_wz"]
    plots: Plots = {
        "omega.png": saved(
            lambda: history(trajectory, speeds, title="Tumbling box: angular velocity in body axes")
        ),
        "polhode.png": saved(lambda: polhode(trajectory, speeds, moments)),
        "middle_axis.png": saved(
            lambda: axis_path(
                trajectory,
                "box",
                axis=middle,
                about=H[0],
                about_name="the angular momentum H",
                title="Tumbling box: path of its middle axis",
            )
        ),
        "cones.png": saved(lambda: cones(trajectory, "box", title="Cones of the tumbling box")),
        "herpolhode.png": saved(lambda: herpolhode(trajectory, H[0])),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots, checks(case, trajectory, moments))


def checks(case: Case, motion: fb.Trajectory, moments: np.ndarray) -> tuple[Check, ...]:
    """Check angular velocity and attitude against elliptic functions, as far as the data determine them.

    A small deviation from the middle axis, and any error in it, grows until the body has flipped, by the ratio of the
    whole angular velocity to the deviation.
    """
    w = np.array([case[f"w_{axis}"] for axis in "xyz"])
    exact = torque_free(moments, w)
    off = float(np.linalg.norm(np.delete(w, np.argsort(moments, kind="stable")[1])))
    bound = 1000 * case.tolerance * (float(np.linalg.norm(w)) / off if off else 1.0)
    omega = np.stack([motion[f"flight_w{axis}"] for axis in "xyz"], axis=-1)
    return (
        same("omega, simulated and by elliptic functions", omega, exact.angular_velocity(motion.t), bound),
        same(
            "attitude, simulated and by elliptic functions",
            motion.poses["box"].rotation,
            exact.attitude(motion.t),
            bound,
        ),
        same(
            "herpolhode, simulated and by elliptic functions",
            in_space(motion),
            exact.herpolhode(motion.t),
            bound,
        ),
    )


def in_space(motion: fb.Trajectory) -> np.ndarray:
    """Return the angular velocity in ground axes, shape (times, 3) [rad/s]."""
    own = np.stack([motion[f"flight_w{axis}"] for axis in "xyz"], axis=-1)
    return np.asarray(np.einsum("nij,nj->ni", motion.poses["box"].rotation, own))


def herpolhode(motion: fb.Trajectory, H: np.ndarray) -> Any:
    """Draw the path of the tip of omega in the plane perpendicular to H, between its two circles."""
    from ...picture.plots.plots import COLORS, INK, figure
    from ...picture.plots.sphere import _across

    n = H / np.linalg.norm(H)
    first, second = _across(n)
    w = in_space(motion)
    x, y = w @ first, w @ second
    radius = np.hypot(x, y)
    ax = figure(7, 6.6).subplots()
    turn = np.linspace(0, 2 * np.pi, 361)
    for r in (radius.min(), radius.max()):
        ax.plot(r * np.cos(turn), r * np.sin(turn), "--", color=INK, linewidth=1.0)
    ax.plot(x, y, color=COLORS[0], linewidth=1.3)
    ax.plot(x[0], y[0], "o", color=COLORS[1], label="start")
    ax.plot(0, 0, "+", color=INK, markersize=11, label="angular momentum H")
    ax.set_aspect("equal")
    ax.set_xlabel("omega across H [rad/s]")
    ax.set_ylabel("[rad/s]")
    ax.grid(alpha=0.3)
    ax.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
    ax.set_title("Herpolhode", loc="left", fontweight="bold")
    return ax


TUMBLING_BODY = Entry(
    "tumbling-body",
    ("torque-free-triaxial", "intermediate-axis"),
    "Tumbling box: free rotation with three different moments of inertia",
    (
        "energy and angular momentum, and how well they keep",
        "axis circled by omega, period, time between flips",
        "omega in the body and the middle axis in space at t_1",
    ),
    build,
    solve,
    until=10.0,
)
