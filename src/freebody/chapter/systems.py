"""Section 6.7: systems of rigid bodies, (6.67)-(6.68), and Example 6.5."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import sympy

from ..gallery.textbook.examples.ex_6_5_cart_and_bar import build as cart_and_bar
from ..gallery.textbook.problems.prob_6_15_double_pendulum import build as double_pendulum
from ..gallery.tools.case import mass_properties
from . import machines
from .meaning import Meaning
from .momentum import angular_momentum, resolved, vector
from .statement import Statement

t = machines.t


@cache
def links() -> tuple[Meaning, ...]:
    """Each body of the double pendulum along its motion: the sums of its loads and the library's reactions."""
    machine = machines.Machine(double_pendulum())
    e = machine.equations
    reaction_values = reactions(e)
    meanings = []
    for angle, (name, place) in zip(e.coordinates, e.model.bodies.items(), strict=True):
        free = e.free_body(name)
        inertia = [[e.sympy(e.state(x)) for x in row] for row in place.inertia]
        names = {
            "F_i": _total(free.forces, reaction_values), "M_Ci": _total(free.moments, reaction_values),
            "m_i": e.sympy(e.state(place.mass)),
            "a_Ci": machine.column(e.center_acceleration(name)), "θ_i": angle,
            "dH_Ci/dt": angular_momentum(inertia, machine.omega(name)).diff(t), "I_Ci": inertia[2][2],
        }  # fmt: skip
        meanings.append(Meaning(names, along=machine.along()))
    return tuple(meanings)


def reactions(e: Any) -> dict[str, Any]:
    """Return the components of the joints' reactions by their names in the free-body equations."""
    return {
        str(name): e.sympy(value)
        for joint in e.reactions
        for name, value in e.canonical_components(joint).items()
    }


def _total(parts: Mapping[str, Any], reaction_values: dict[str, Any]) -> Any:
    """Return the sum of the actions on a body, with the values of the reactions."""
    total = sum((sympy.Matrix(v) for v in parts.values()), sympy.zeros(3, 1))
    return total.xreplace(
        {x: reaction_values[str(x)] for x in total.free_symbols if str(x) in reaction_values}
    )


def _planar() -> list[Meaning]:
    return [Meaning({**m.names, "M_Ci": m.names["M_Ci"][2]}, along=m.along) for m in links()]


# --- Example 6.5 -------------------------------------------------------------------------------------------------


@cache
def _machine() -> machines.Machine:
    return machines.Machine(cart_and_bar())


@cache
def cart() -> Meaning:
    """Example 6.5: its kinematics and the forces of the hinge and of the guide."""
    machine = _machine()
    e = machine.equations
    pin, guide = (sympy.Matrix(e.reactions[name].force) for name in ("pin", "guide"))
    a_0, a_C = (machine.column(e.center_acceleration(name)) for name in ("cart", "bar"))
    omega = machine.omega("bar")
    place = lambda body: machine.place(machine.body(body).origin)  # noqa: E731
    names = {
        # the pin's reaction acts on the bar; the chapter's F_x, F_y act on the particle
        **machine.names, **resolved("F_x F_y", -pin[:2, 0]), "f": guide[1],
        **resolved("a_0x a_0y", a_0[:2]), **resolved("a_Cx a_Cy", a_C[:2]), "a_0": a_0, "a_C": a_C, "ω": omega,
        "r_0C": place("bar") - place("cart"), "i": vector(1, 0, 0), "j": vector(0, 1, 0), "k": vector(0, 0, 1),
        "I_C": mass_properties(machine.body("bar")).inertia[2][2],
    }  # fmt: skip
    return Meaning(names)


def _scalars() -> Meaning:
    """The same along the motion, with k for the stiffness of the spring."""
    machine = _machine()
    return Meaning({**cart().names, "k": machine.names["k"]}, along=machine.along())


def _motion() -> Meaning:
    """The library's equations of motion; the print may be a numerical multiple of them."""
    meaning = _scalars()
    rows = _machine().equations.motion
    return Meaning(meaning.names, rows={i: (row.lhs, row.rhs) for i, row in enumerate(rows)})


FREE = "fb.equations(s).reactions, .motion"
CENTRES = "fb.equations(s).center_acceleration(...)"
STATEMENTS = (
    Statement("6.67a", "force equations of every body", FREE, "F_i = m_i a_Ci", links),
    Statement("6.67b", "moment equations of every body", FREE + "; fb.forms.angular_momentum(inertia, omega)",
              "M_Ci = dH_Ci/dt", links),
    Statement("6.68", "moment equations of every body, planar", FREE, "M_Ci = I_Ci θ_i''", _planar),
    Statement("ex-6-5 (a)", "particle: force equation along x", FREE, "F_x - k x = M a_0x", _scalars),
    Statement("ex-6-5 (b)", "particle: force equation along y", FREE, "f + F_y - M g = M a_0y", _scalars),
    Statement("ex-6-5 (c)", "bar: force equation along x", FREE, "F - F_x = m a_Cx", _scalars),
    Statement("ex-6-5 (d)", "bar: force equation along y", FREE, "-F_y - m g = m a_Cy", _scalars),
    Statement("ex-6-5 (e)", "bar: moment equation about C", FREE + "; fb.slender_bar(m, 2*a).inertia",
              ("(F + F_x) a cos θ + F_y a sin θ = I_C θ''", "I_C = m (2 a)^2/12 = m a^2/3"),
              _scalars),
    Statement("ex-6-5 (f)", "the combinations that are free of the hinge force", "fb.equations(s).motion",
              ("M a_0x + m a_Cx + k x = F",
               "I_C θ'' + m a (a_Cx cos θ + a_Cy sin θ) + m g a sin θ = 2 F a cos θ"), _motion),
    Statement("ex-6-5 (g)", "acceleration of the particle as a vector", CENTRES, "a_0 = a_0x i + a_0y j = x'' i", cart),
    Statement("ex-6-5 (h)", "acceleration of the particle by components", CENTRES, ("a_0x = x''", "a_0y = 0"), cart),
    Statement("ex-6-5 (i)", "acceleration of C from that of 0", CENTRES + ", dynamics.kinematics",
              "a_C = a_Cx i + a_Cy j = a_0 + ω × (ω × r_0C) + ω' × r_0C", cart),
    Statement("ex-6-5 (j)", "the bar's half and its rotation", "dynamics.kinematics",
              ("r_0C = a (sin θ i - cos θ j)", "ω = θ' k", "ω' = θ'' k"), cart),
    Statement("ex-6-5 (k)", "acceleration of C as a vector", CENTRES,
              "a_C = [x'' + a (θ'' cos θ - θ'^2 sin θ)] i + a (θ'' sin θ + θ'^2 cos θ) j", cart),
    Statement("ex-6-5 (l)", "acceleration of C by components", CENTRES,
              ("a_Cx = x'' + a (θ'' cos θ - θ'^2 sin θ)", "a_Cy = a (θ'' sin θ + θ'^2 cos θ)"), cart),
    Statement("ex-6-5 (m)", "the equations of motion", "fb.equations(s).motion",
              ("(M + m) x'' + m a (θ'' cos θ - θ'^2 sin θ) + k x = F",
               "1/2 m a^2 θ'' + m x'' cos θ + m g a sin θ = 2 F a cos θ"), _motion),
)  # fmt: skip
