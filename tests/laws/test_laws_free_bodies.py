"""The free-body equations of every body are the equations of motion seen joint by joint.

With the values of the reactions put for the unknowns, what is left of the six equations of a body is the lack of
balance of the equations of motion along the free motions of its joints: zero on a motion of the machine.
"""

from __future__ import annotations

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.dynamics import float_state, forward_dynamics, mass_matrix
from freebody.testing import JOINTS, polynomial_value, random_state, random_system, state_values
from sampled import sampled

EXACT = 2**12 * np.finfo(float).eps
T = 0.3


def on_a_motion(system, seed):
    """Equations, and the values of all atoms and of all reaction components at a state of the motion."""
    model = fb.assemble(system)
    q, u = random_state(model, seed)
    state = float_state(model, q, u, T)
    udot = forward_dynamics(model, state)
    values = state_values(model, q, u, T)
    values.update((s.acceleration, x) for s, x in zip(model.speeds, udot, strict=True))
    eq = fb.equations(model)
    reactions = dict(values)
    for name in model.joints:
        for component, value in eq.canonical_components(name).items():
            reactions[component] = polynomial_value(value, values)
    M = np.array(mass_matrix(model, state), float)
    return eq, reactions, np.linalg.cond(M) if len(M) else 1


def check(eq, values, tolerance, **options):
    for body in eq.model.bodies:
        sides = [
            (polynomial_value(a, values), polynomial_value(b, values))
            for a, b in eq.free_body(body, **options).balances
        ]
        size = max(1, *(abs(x) for side in sides for x in side))
        for left, right in sides:
            assert abs(left - right) <= tolerance * size


@pytest.mark.parametrize(
    ("kind", "armature"),
    [*((kind, False) for kind in JOINTS), *sampled(((kind, True) for kind in JOINTS), 4)],
)
def test_six_equations_of_every_body_hold_with_the_reactions(kind, armature):
    """All loads act: springs and dampers along the joints and between points, forces, couples, generalized forces."""
    bodies = 1 if kind in ("free", "ball", "gimbal", "universal") else 2
    system = random_system(4, bodies, [kind], small=True, branching=False, armature=armature)
    eq, values, condition = on_a_motion(system, 4)
    check(eq, values, EXACT * condition)
    last = list(system.bodies.values())[-1]
    check(eq, values, EXACT * condition, about=last.point(1, 2, -1), frame=last)
    check(eq, values, EXACT * condition, about=system.ground.point(1, 1, 1), frame="ground")


@pytest.mark.parametrize("kind", ["cylindrical", "universal", "gimbal", "planar", "screw"])
@pytest.mark.parametrize("index", [0, 1, 2])
def test_loads_on_inner_motions_of_a_joint(kind, index):
    """A spring on any displacement of a joint, and a generalized force: the massless links inside pass them on."""
    system = random_system(2, 1, [kind], loads=False, small=True)
    (joint,) = system.joints.values()
    if index >= len(joint.primitives):
        index = 0
    system.spring("k", joint, stiffness=2, rest=1, coordinate=index)
    system.damper("c", joint, damping=3, coordinate=index)
    system.generalized_force(joint.primitives[index].coordinate, "3*t")
    eq, values, condition = on_a_motion(system, 5)
    check(eq, values, EXACT * condition)
    names = [action.name for action in eq.free_body("b0").actions]
    assert {"k", "c"} < set(names)


@pytest.mark.parametrize("driven", [(0,), (1,), (2,), (0, 2)])
def test_joints_that_are_driven_in_part(driven):
    """The drive's moment is one more component of the reaction."""
    s = fb.System("rotor in a driven gimbal")
    s.gravity = (1, -2, 3)
    rotor = s.body("rotor", fb.box(2, (1, 2, 3)))
    names = ["psi", "theta", "phi"]
    given = ["t + t**2/2" if i in driven else name for i, name in enumerate(names)]
    joint = s.gimbal("mount", s.ground, rotor, to=(1, 1, 2), axis="ZXZ", coordinate=given)
    s.spring("k0", joint, stiffness=2, coordinate=0)
    s.spring("k1", joint, stiffness=2, rest=1, coordinate=1)
    eq, values, condition = on_a_motion(s, 3)
    check(eq, values, EXACT * condition)
    moments = [name for name in eq.reactions["mount"].components if "_M" in name]
    assert len(moments) == len(driven)


def test_shared_coordinates_and_a_free_hinge_beside_them():
    """Two hinges geared 1 : 2 carry the gear's moment; the third, with its own coordinate, carries none."""
    s = fb.System("gear")
    s.gravity = (0, -3, 0)
    (q,) = [s.coordinates("q")]
    one, two, three = (s.body(name, fb.box(1, (1, 2, 1))) for name in ("one", "two", "three"))
    s.hinge("a", s.ground, one, to=(0, 1, 0), coordinate=q)
    s.hinge("b", s.ground, two, at=(3, 0, 0), to=(0, 1, 0), coordinate=2 * q)
    s.hinge("c", two, three, to=(0, 1, 0), coordinate="r")
    s.generalized_force("r", 2)
    eq, values, condition = on_a_motion(s, 1)
    assert eq.model.order is None
    check(eq, values, EXACT * condition)
    assert "c_Mz" not in eq.reactions["c"].components
    assert "a_Mz" in eq.reactions["a"].components
    # the gear does no work: M_a q' + M_b 2 q' = 0, on the motion
    M = [polynomial_value(eq.canonical_reactions[name][1][2], values) for name in "ab"]
    assert abs(M[0] + 2 * M[1]) <= EXACT * condition * max(map(abs, M))


def test_absolute_angles_with_generalized_forces():
    """A moment conjugate to an absolute angle is shared out to the joints of the chain."""
    s = fb.System("chain")
    s.gravity = (0, -2, 0)
    q1, q2, q3 = s.coordinates("q1 q2 q3")
    parent, last = s.ground, 0
    for i, q in enumerate((q1, q2, q3)):
        bar = s.body(f"bar{i}", fb.slender_bar(1, 2, axis="y"))
        s.hinge(f"pin{i}", parent, bar, at=(0, -1 if i else 0, 0), to=(0, 1, 0), coordinate=q - last)
        parent, last = bar, q
    s.generalized_force("q2", "5*sin(t)")
    eq, values, condition = on_a_motion(s, 2)
    assert eq.model.order is not None
    check(eq, values, EXACT * condition)
    # it turns the second bar against the ground: the joints pass it on so that the other bars feel no moment
    felt = []
    for i in range(3):
        moments = eq.free_body(f"bar{i}").moments
        felt.append("Q_q2" in moments and moments["Q_q2"])
    assert [bool(x) and any(x) for x in felt] == [False, True, False]


@pytest.mark.parametrize("kind", ["hinge", "slider", "screw", "planar", "cylindrical"])
def test_six_equations_hold_exactly_on_the_motion(kind):
    """In symbols: with the reactions and the accelerations of the motion put in, every difference is zero."""
    system = random_system(6, 1, [kind], small=True, loads=False)
    (joint,) = system.joints.values()
    system.spring("k", joint, stiffness=3, rest=1)
    eq = fb.equations(system)
    udot = forward_dynamics(eq.model, eq.state)
    motion = {speed.acceleration: value for speed, value in zip(eq.model.speeds, udot, strict=True)}
    reactions = eq.canonical_components(joint.name)
    for left, right in eq.free_body("b0", about=joint.child.point(*joint.to)).balances:
        assert substituted(eq.ring, substituted(eq.ring, left, reactions) - right, motion) == 0


def substituted(ring, x, put):
    """x with elements for some of its atoms, in which it is linear."""
    total = x
    for atom, value in put.items():
        slope = ring.derivative(x, atom)
        total = total + slope * (value - ring.generator(atom))
    return total


def test_the_equations_solve_for_reactions_and_accelerations_alone():
    """Counted as a student does: six equations for every body, and no other equation, give every unknown."""
    s = fb.System("cart and bar")
    M, m, a, k, g, F = s.parameters(M=2, m=1, a=0.5, k=10, g=9.81, F=3)
    s.gravity = (0, -g, 0)
    cart, bar = s.body("cart", fb.particle(M)), s.body("bar", fb.slender_bar(m, 2 * a, axis="y"))
    guide = s.slider("guide", s.ground, cart, axis="x", coordinate="x")
    s.hinge("pin", cart, bar, to=(0, a, 0), axis="z", coordinate="theta")
    s.spring("k", guide, stiffness=k)
    s.force("F", bar.point(0, -a, 0), (F, 0, 0))
    eq = fb.equations(s)
    unknowns = list(eq.free_body("cart").unknowns)
    unknowns += [x for x in eq.free_body("bar").unknowns if x not in unknowns]
    unknowns += [speed.acceleration for speed in eq.model.speeds]
    equations = [*eq.free_body("cart").equations, *eq.free_body("bar").equations]
    assert len(unknowns) == len(equations) == 12
    solution = sympy.solve(equations, unknowns, dict=True)
    assert len(solution) == 1
    state = {M: 2, m: 1, a: sympy.Rational(1, 2), k: 10, g: 9, F: 3}
    x, theta = eq.coordinates
    state |= {x.diff(s.t): 1, theta.diff(s.t): 2, x: sympy.Rational(1, 3), theta: sympy.Rational(2, 5)}
    for joint in ("guide", "pin"):
        for name, value in eq.reactions[joint].components.items():
            with_udot = value.subs(
                {speed.acceleration: solution[0][speed.acceleration] for speed in eq.model.speeds}
            )
            difference = with_udot - solution[0][sympy.Symbol(name, real=True)]
            assert abs(difference.subs(state).evalf(30)) < 1e-25


@pytest.mark.parametrize(
    "coordinates",
    [
        ["q1 + t**2/3", "2*q2 + sin(q1)", "q3 - q1*q2"],
        ["q1", "q2*q1", "q3 + q2"],
        ["q1", "q1/2", "q2 + q3", "q3"],
    ],
    ids=["solved", "together", "geared"],
)
def test_displacements_that_are_expressions(coordinates):
    """Generalized forces on every coordinate, springs on every joint: six equations of every body still hold."""
    s = fb.System("coupled")
    s.gravity = (1, -2, 3)
    s.coordinates("q1 q2 q3")
    parent = s.ground
    for i, coordinate in enumerate(coordinates):
        body = s.body(f"b{i}", fb.MassProperties(1 + i, (1, 0, i), ((3, 1, 0), (1, 4, 0), (0, 0, 5))))
        kind = ("hinge", "slider")[i % 2]
        given = {"at": (1, i, 0), "to": (0, 1, -1), "axis": "xyz"[i % 3]}
        joint = getattr(s, kind)(f"j{i}", parent, body, coordinate=s.expression(coordinate), **given)
        s.spring(f"k{i}", joint, stiffness=2, rest=1)
        parent = body
    for q in ("q1", "q2", "q3"):
        s.generalized_force(q, f"{q}' - t")
    eq, values, condition = on_a_motion(s, 3)
    check(eq, values, EXACT * condition)
