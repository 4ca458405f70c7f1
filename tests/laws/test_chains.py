"""Chains of primitive motions against the same motions with massless bodies between, and the laws of free bodies."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.dynamics import float_state, forward_dynamics, mass_matrix
from freebody.dynamics.newton_euler import reactions
from freebody.testing import polynomial_value, random_inertia, random_rotation, random_state, small_inertia
from sampled import sampled

from .test_laws_free_bodies import check, on_a_motion

EPS = np.finfo(float).eps
EXACT = 2**12 * EPS  # as in test_laws_floats, times the condition of the mass matrix where it is solved

CHAINS = {
    "three hinges": [("hinge", "x"), ("hinge", "y"), ("hinge", "z")],
    "hinges of one direction": [("hinge", "z"), ("hinge", "-z")],
    "three of one direction": [("hinge", "y"), ("hinge", "y"), ("hinge", "y")],
    "two of one direction and one across": [("hinge", "z"), ("hinge", "z"), ("hinge", "x")],
    "arm that reaches": [("hinge", "z"), ("slider", "x")],
    "slides askew": [("slider", (1, 1, 0)), ("slider", "x"), ("hinge", (0, 1, 1))],
    "screw and hinge": [("screw", "z"), ("hinge", "x")],
    "slider and ball": [("slider", "y"), ("ball", None)],
    "hinge and ball": [("hinge", "y"), ("ball", None)],
    "ball between hinges": [("hinge", "x"), ("ball", None), ("hinge", (1, 2, 0))],
    "one hinge": [("hinge", "x")],
    "a base": [(kind, axis) for kind in ("slider", "hinge") for axis in "xyz"],
}


def motions(pattern, rng, small):
    result = []
    for k, (kind, axis) in enumerate(CHAINS[pattern]):
        at = tuple(int(x) for x in rng.integers(-2, 3, size=3)) if small else tuple(rng.normal(size=3))
        given = {"at": at, "coordinate": f"q{k}"}
        if kind == "ball":
            given["armature"] = 0.3
        else:
            given["axis"] = axis
        if kind == "screw":
            given["pitch"] = 2
        result.append(getattr(fb, kind.capitalize())(**given))
    return result


def machine(pattern, seed, *, explicit=False):
    """A body on a chain, and a body on a hinge on it; ``explicit``: with massless bodies between the motions."""
    rng = np.random.default_rng(seed)
    s = fb.System(pattern)
    s.gravity = (1, -2, 3)
    bodies = [
        s.body(f"b{k}", fb.MassProperties(1.5 + k, rng.normal(size=3), random_inertia(rng))) for k in range(2)
    ]
    base = s.body("base", fb.MassProperties(1, (0, 0, 1), random_inertia(rng)))
    s.hinge("root", s.ground, base, axis=(2, 1, 2), coordinate="root")
    at, to = rng.normal(size=3), rng.normal(size=3)
    on_parent, on_child = random_rotation(rng), random_rotation(rng)
    parts = motions(pattern, rng, False)
    if explicit:
        parent, place, axes = base, np.array(at), on_parent
        A, before = np.array(on_parent, float), np.zeros(3)
        for k, part in enumerate(parts):
            last = k == len(parts) - 1
            child = bodies[0] if last else s.body(f"between{k}", fb.particle(0))
            step = np.array(part.at) - before
            given = {
                "at": place + (A @ step if k == 0 else step),
                "coordinate": part.coordinate,
                "parent_axes": axes,
            }
            if last:
                given |= {"to": to + np.array(on_child, float) @ part.at, "child_axes": on_child}
            if part.kind == "ball":
                given["armature"] = part.armature
            else:
                given["axis"] = part.axis
            if part.kind == "screw":
                given["pitch"] = part.pitch
            getattr(s, part.kind)(f"j{k}", parent, child, **given)
            parent, place, axes, before = child, np.zeros(3), None, np.array(part.at)
    else:
        s.chain("j", base, bodies[0], parts, at=at, to=to, parent_axes=on_parent, child_axes=on_child)
    s.hinge(
        "tip", bodies[0], bodies[1], at=(0.3, 0.1, -0.2), to=(0.5, -0.4, 1), axis=(1, 2, 2), coordinate="tip"
    )
    s.force("F", bodies[1].point(1, 2, 3), (1, -2, 0.5))
    return fb.assemble(s)


@pytest.mark.parametrize("pattern", CHAINS)
@pytest.mark.parametrize("seed", sampled(range(3), 3))
def test_a_chain_moves_as_with_massless_bodies_between(pattern, seed, tmp_path):
    """Mass matrix, accelerations, and the wrench of its last motion on the child are those of the longer machine."""
    short, long = machine(pattern, seed), machine(pattern, seed, explicit=True)
    q, u = random_state(short, seed)
    a, b = float_state(short, q, u), float_state(long, q, u)
    M = np.array(mass_matrix(short, a), float)
    condition = np.linalg.cond(M)
    np.testing.assert_allclose(M, np.array(mass_matrix(long, b), float), rtol=0, atol=EXACT * np.abs(M).max())
    udot = forward_dynamics(short, a)
    other = forward_dynamics(long, b)
    size = max(1, np.abs(udot).max())
    np.testing.assert_allclose(udot, other, rtol=0, atol=EXACT * condition * size)
    last = f"j{len(CHAINS[pattern]) - 1}"
    own = reactions(short, a, udot)
    natural, theirs = reactions(short, a, udot, natural=True), reactions(long, b, other)
    compared = [(name, natural[name]) for name in ("root", "j", "tip")] + [("root", theirs["root"])]
    if "ball" not in pattern:  # its armature drives the motion of the ball alone, and not the bodies between
        compared.append(("j", theirs[last]))
    for name, pair in compared:
        size = max(1, *map(abs, (*own[name][0], *own[name][1])))
        for mine, expected in zip(own[name], pair, strict=True):
            np.testing.assert_allclose(mine, expected, rtol=0, atol=EXACT * condition * size)
    compiled = fb.compile(short).forward_dynamics(q, u)
    np.testing.assert_allclose(compiled, udot, rtol=0, atol=EXACT * condition * size_of(udot))
    fb.write(short.described[0], tmp_path / "chain.toml")
    written = fb.assemble(fb.read(tmp_path / "chain.toml"))
    assert (written.links, written.joints) == (short.links, short.joints)


def size_of(x):
    return max(1, np.abs(x).max())


LARGE = ("a base", "three of one direction", "slider and ball", "ball between hinges")
SMALL = [name for name in CHAINS if name not in LARGE]


@pytest.mark.parametrize("pattern", SMALL)
@pytest.mark.parametrize("loaded", [False, True])
def test_six_equations_hold_with_the_reactions_of_a_chain(pattern, loaded):
    """Springs on every motion, and a generalized force: what the chain transmits balances its child."""
    rng = np.random.default_rng(5)
    s = fb.System(pattern)
    s.gravity = (1, -2, 3)
    body = s.body("b", fb.MassProperties(2, (1, -1, 2), small_inertia(rng)))
    joint = s.chain("j", s.ground, body, motions(pattern, rng, True), at=(1, 0, 1), to=(0, 1, 0))
    if loaded:
        for k, motion in enumerate(joint.primitives):
            if motion.displaces:
                s.spring(f"k{k}", joint, stiffness=2 + k, rest=1, coordinate=k)
        s.generalized_force("q0", "3*t")
    eq, values, condition = on_a_motion(s, 5)
    check(eq, values, EXACT * condition)
    assert len(eq.reactions["j"].components) == 6 - sum(1 if p.displaces else 3 for p in joint.primitives)
    # the components are those of the wrench: together they give its force and moment back
    force, moment = eq.canonical_reactions["j"]
    state = float_state(eq.model, *state_of(eq, values), 0.3)
    expected = reactions(eq.model, state, forward_dynamics(eq.model, state))["j"]
    for mine, numbers in zip((force, moment), expected, strict=True):
        mine = [polynomial_value(x, values) for x in mine]
        np.testing.assert_allclose(mine, numbers, rtol=0, atol=EXACT * condition * max(1, *map(abs, numbers)))


def state_of(eq, values):
    q = [values[c.symbol] for c in eq.model.coordinates]
    return q, [values[s.symbol] for s in eq.model.speeds]
