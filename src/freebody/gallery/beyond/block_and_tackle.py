"""Block and tackle: a weight on a movable pulley, carried by ``four`` parts of one rope, and a counterweight.

The rope runs from the beam to the movable block, back to the beam, again to the block, over the beam to the
counterweight. With massless pulleys of no size 4 x + y is constant: M x'' = M g - 4 S, m y'' = m g - S.
"""

from __future__ import annotations

import freebody as fb

from ..tools.answer import Answer, Answers, Plots, Solved
from ..tools.case import Case, explain
from ..tools.entry import Entry


def build() -> fb.System:
    """Return the system; x and y are the depths of weight and counterweight below the beam."""
    s = fb.System("block_and_tackle")
    M, m, L, g = s.parameters(M=100.0, m=30.0, L=15.0, g=9.81)
    s.parameters(x_0=3.0, t_1=0.6)
    s.gravity = (0, -g, 0)
    weight, counter = s.body("weight", fb.particle(M)), s.body("counterweight", fb.particle(m))
    s.slider("left", s.ground, weight, axis="-y", coordinate="x")
    s.slider("right", s.ground, counter, at=(1, 0, 0), axis="-y", coordinate="y")
    beam, over = s.ground.point(0, 0, 0), s.ground.point(1, 0, 0)
    s.rope([beam, weight.origin, beam, weight.origin, beam, over, counter.origin], L, name="rope")
    explain(
        s,
        M="kg: mass of the weight with its block",
        m="kg: mass of the counterweight",
        L="m: length of the rope",
        g="m/s²: gravity",
        x_0="m: depth of the weight at the start",
        t_1="s: time to answer for",
        x="m: depth of the weight",
        y="m: depth of the counterweight",
    )
    return s


START = {"x": "x_0"}
NEAR = {"y": 1}


def solve(case: Case) -> Solved:
    """Simulate the system and answer its questions."""
    from ...picture.plots.plots import energy_residual, history, saved

    at = case.simulate_to([case["t_1"]], initial=START, near=NEAR)
    here = {name: float(at[name][0]) for name in ("x", "y", "x'", "y'")}
    start = case.accelerations(here)
    answers: Answers = {
        "x''": Answer("acceleration of the load, x''", start["x''"], "m/s²"),
        "y''": Answer("acceleration y''", start["y''"], "m/s²"),
        "tension": Answer("tension of the rope", float(at.multipliers["rope"][0]), "N"),
        "x(t_1)": Answer("x at t_1", here["x"], "m"),
        "y(t_1)": Answer("y at t_1", here["y"], "m"),
    }
    trajectory = case.motion(initial=START, near=NEAR)
    plots: Plots = {
        "depths.png": saved(lambda: history(trajectory, title="Block and tackle: depths below the beam")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(trajectory, answers, plots)


BLOCK_AND_TACKLE = Entry(
    "block-and-tackle",
    (),
    "Block and tackle: four parts of a rope carry the weight",
    ("accelerations", "tension of the rope", "depths at t_1"),
    build,
    solve,
    until=1.0,
    positive=("L", "x_0"),
    near={**START, **NEAR},
)
