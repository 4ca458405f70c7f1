"""A box thrown with a spin about its middle axis: it tumbles (Euler's equations with three different moments).

The box has the edges a > b > c along x, y, z, the size of a book, so that I_x < I_y < I_z. It is seen from its
falling mass centre, where no weight is felt. The spin is about y but for a small part about x and z.
"""

from __future__ import annotations

import numpy as np

import freebody as fb

from .answer import Answer, Answers, Plots, Solved
from .case import Case, explain, happened, mass_properties
from .entry import Entry

START = {"flight_wx": "w_x", "flight_wy": "w_y", "flight_wz": "w_z"}


def build() -> fb.System:
    """A free body without loads."""
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
    """The axis that omega circles in the body: of the smallest moment if H² < 2 T I_middle, else of the largest."""
    low, middle, high = np.argsort(moments, kind="stable")
    return "xyz"[low if 2 * T * moments[middle] > H**2 else high]


def solve(case: Case) -> Solved:
    from ..picture.plots import energy_residual, history, saved
    from ..picture.sphere import axis_path, polhode

    box = case.system.bodies["box"]
    inertia = mass_properties(box).inertia
    moments = np.array([case.number(inertia[i][i]) for i in range(3)])
    middle = "xyz"[np.argsort(moments, kind="stable")[1]]
    name = f"flight_w{middle} rises through 0"
    events = [fb.event(f"flight_w{middle}", name=name, direction=1)]
    # a body that turns about one of its axes never tumbles
    long = case.simulate_past(name, 2, required=False, initial=START, events=events)
    turns = [event.time for event in happened(long, name)]
    period = turns[1] - turns[0] if len(turns) > 1 else "none: it turns steadily"

    trajectory = case.motion(initial=START, events=events)
    H = np.stack([trajectory[part] for part in case.equations.momentum.angular(box.center)], axis=-1)
    size, T = float(np.linalg.norm(H[0])), float(trajectory.energy.kinetic[0])
    at = case.simulate_to([case["t_1"]], initial=START)
    answers: Answers = {
        "I": Answer("I_x, I_y, I_z", tuple(moments.tolist()), "kg m²"),
        "T": Answer("kinetic energy", T, "J"),
        "H": Answer("angular momentum", size, "kg m²/s"),
        "axis": Answer("axis that omega circles in the body", circled(case, moments, size, T), ""),
        "period": Answer("period of omega in the body", period, "s"),
        "omega(t_1)": Answer(
            "omega in body axes at t_1", tuple(float(at[f"flight_w{axis}"][0]) for axis in "xyz"), "rad/s"
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
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


TUMBLING_BODY = Entry(
    "tumbling-body",
    (),
    "Tumbling box: free rotation with three different moments of inertia",
    ("energy and angular momentum, and how well they keep", "axis circled by omega, period", "omega at t_1"),
    build,
    solve,
    until=10.0,
)
