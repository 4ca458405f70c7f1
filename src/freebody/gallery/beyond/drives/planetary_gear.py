"""A planetary gear with a fixed ring: a motor turns the sun, the carrier drives a load.

The planets, drawn as one of their common mass, roll in the ring of the radius r_s + 2 r_p and on the sun. By Willis the
sun turns i = 2 (r_s + r_p)/r_s times as fast as the carrier, and by the energy of all wheels

    (4 m_s + 3 m_p + m_c) (r_s + r_p)²/2 ψ'' = i T - Q

Source: Willis, Principles of Mechanism (1841); Shigley & Mischke, Mechanical Engineering Design (1989), §13-9.
"""

from __future__ import annotations

import freebody as fb

from ...tools.answer import Answer, Answers, Plots, Solved, same
from ...tools.case import Case, explain
from ...tools.entry import Entry


def build() -> fb.System:
    """Return sun and planet on the carrier, whose teeth are those of the sun and of the fixed ring."""
    s = fb.System("planetary_gear")
    m_s, r_s, m_p, r_p, m_c = s.parameters(m_s=2.0, r_s=0.03, m_p=1.5, r_p=0.02, m_c=3.0)
    T, Q, t_1 = s.parameters(T=10.0, Q=30.0, t_1=0.5)
    carrier = s.body("carrier", fb.disk(m_c, r_s + r_p))
    sun, planet = s.body("sun", fb.disk(m_s, r_s)), s.body("planet", fb.disk(m_p, r_p))
    out = s.hinge("out", s.ground, carrier, coordinate="psi")
    shaft = s.hinge("shaft", carrier, sun, coordinate="sigma")
    pin = s.hinge("pin", carrier, planet, at=(r_s + r_p, 0, 0), coordinate="theta")
    s.gear(shaft, pin, -r_p / r_s, name="inner")
    s.gear(out, pin, -r_p / (r_s + 2 * r_p), name="outer")
    s.torque("motor", sun, (0, 0, T))
    s.torque("load", out, -Q)
    explain(
        s,
        m_s="kg: mass of the sun",
        r_s="m: radius of the sun's pitch circle",
        m_p="kg: mass of the planets",
        r_p="m: radius of a planet's pitch circle",
        m_c="kg: mass of the carrier, a disk out to the pins",
        T="N m: torque of the motor on the sun",
        Q="N m: torque of the load on the carrier",
        t_1="s: time to answer for",
        psi="rad: angle of the carrier",
        sigma="rad: angle of the sun relative to the carrier",
        theta="rad: angle of the planet relative to the carrier",
    )
    return s


def solve(case: Case) -> Solved:
    """Solve the equations for accelerations and forces, and simulate."""
    from ....picture.plots.plots import energy_residual, history, saved

    how = "fb.equations(s).solve"
    found = case.equations.solve(["psi''", "sigma''", "theta''", "inner", "outer"])
    at = case.simulate_to([case["t_1"]])
    sun, carrier = (float(x) for x in (at["psi'"][0] + at["sigma'"][0], at["psi'"][0]))
    r_s, r_p = (case.atoms[name] for name in ("r_s", "r_p"))
    answers: Answers = {
        "ratio": case.formula(
            "rate of the sun over that of the carrier", 1 + found["sigma''"] / found["psi''"], "1", how
        ),
        "psi''": case.formula("angular acceleration of the carrier", found["psi''"], "rad/s²", how),
        "F_sun": case.formula("tangential force between sun and planet", -found["inner"] / r_s, "N", how),
        "F_ring": case.formula(
            "tangential force between planet and ring", found["outer"] / (r_s + 2 * r_p), "N", how
        ),
        "omega_sun(t_1)": Answer("angular velocity of the sun at t_1", sun, "rad/s", how="fb.simulate"),
        "psi'(t_1)": Answer("angular velocity of the carrier at t_1", carrier, "rad/s", how="fb.simulate"),
    }
    trajectory = case.motion()
    plots: Plots = {
        "angles.png": saved(lambda: history(trajectory, title="Planetary gear: angles")),
        "energy.png": saved(lambda: energy_residual(trajectory)),
    }
    return Solved(
        trajectory,
        answers,
        plots,
        checks=(same("ratio of the rates at t_1", sun / carrier, answers["ratio"].value, 1e-9),),
    )


PLANETARY_GEAR = Entry(
    "planetary-gear",
    ("planetary", "epicyclic-gear"),
    "A planetary gear with a fixed ring",
    ("ratio", "angular acceleration", "forces of the teeth", "angular velocities at t_1"),
    build,
    solve,
    until=1.0,
)
