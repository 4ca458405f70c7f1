"""Equations written recursively are the equations written out: with every name replaced, the difference is zero."""

import numpy as np
import pytest
import sympy

import freebody as fb
from freebody.scalar.element import is_zero
from freebody.scalar.polynomial import Polynomial
from freebody.scalar.substitute import Substitution
from freebody.symbolic.length_bound import most_terms
from freebody.testing import random_chain, random_system

KINDS = {
    name: ("hinge", "slider", name)
    for name in ("screw", "ball", "free", "planar", "universal", "cylindrical")
}


def written_out(recursive, ring):
    """The balances with all names replaced, one after another, in another ring."""
    model = recursive.model
    atoms = [c.symbol for c in model.coordinates] + [p.symbol for p in model.parameters]
    atoms += [x for s in model.speeds for x in (s.symbol, s.acceleration)] + [model.names.atoms["t"]]
    values = {a: ring.generator(a) for a in atoms}
    named = recursive.names.definitions
    for g in recursive.ring.generators:
        if g.kind == "reaction" and g.index not in named:
            values[g.atom] = ring.generator(g.atom)
    for definition in recursive.definitions:
        values[definition.symbol] = Substitution(recursive.ring, ring, values)(definition.value)
    put_in = Substitution(recursive.ring, ring, values)
    return [put_in(x) for x in recursive.balances]


def agree(system):
    e = fb.equations(system)
    found = written_out(e.recursive, e.ring)
    assert len(found) == e.model.n_u
    assert all(is_zero(x - (left - right)) for x, (left, right) in zip(found, e.balances, strict=True))
    return e


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", KINDS)
def test_recursive_equations_are_the_equations(kind, seed):
    agree(
        random_system(
            seed, 3, KINDS[kind], small=True, loads=False, driven=seed % 2 == 0, armature=seed % 2 == 1
        )
    )


@pytest.mark.parametrize("seed", [1, 2, 5, 7])
def test_with_loads(seed):
    agree(random_system(seed, 2, small=True, driven=seed % 2 == 0))


def test_with_absolute_angles_and_drives():
    s = fb.System("absolute")
    m, L, g, omega = s.parameters(m=1, L=1, g=9.81, omega=2)
    s.gravity = (0, -g, 0)
    q1, q2 = s.coordinates("q1 q2")
    first, second, third = (s.body(name, fb.slender_bar(m, L, axis="y")) for name in ("a", "b", "c"))
    s.hinge("p", s.ground, first, to=(0, L / 2, 0), coordinate=q1)
    s.hinge("q", first, second, at=(0, -L / 2, 0), to=(0, L / 2, 0), axis=(0, 0, -1), coordinate=q1 - q2)
    s.hinge("r", second, third, at=(0, -L / 2, 0), to=(0, L / 2, 0), coordinate=omega * s.t)
    s.force("F", third.point(0, -L / 2, 0), ("3", 0, 0))
    agree(s)
    text = fb.equations(s, form="recursive").text()
    assert "phi_b" not in text  # q2 itself
    assert "  phi_c = omega*t + q2" in text.splitlines()


def test_with_constraints():
    """The force of a pin that closes a loop acts at the child's point: the same where the conditions hold.

    The difference is a multiple of them, C_y φ_x - C_x φ_y for the joints before the loop's end.
    """
    s = fb.System("crank")
    m, r, L, g = s.parameters(m=1, r=1, L=3, g=9.81)
    s.gravity = (0, -g, 0)
    crank, rod, block = (
        s.body("crank", fb.slender_bar(m, r, axis="x")),
        s.body("rod", fb.slender_bar(m, L, axis="x")),
        s.body("block", fb.particle(m)),
    )
    s.hinge("A", s.ground, crank, to=(-r / 2, 0, 0), coordinate="alpha")
    s.hinge("B", crank, rod, at=(r / 2, 0, 0), to=(-L / 2, 0, 0), coordinate="beta")
    s.slider("guide", s.ground, block, axis="x", coordinate="x")
    s.hinge("C", rod, block, at=(L / 2, 0, 0))
    e = fb.equations(s)
    x, y = (e.conditions.residual[i] for i in (0, 1))
    C_x, C_y = e.canonical_multipliers[:2]
    found = written_out(e.recursive, e.ring)
    difference = [a - (left - right) for a, (left, right) in zip(found, e.balances, strict=True)]
    assert difference == [C_y * x - C_x * y, C_y * x - C_x * y, 0]
    assert "x - r*cos(alpha) - L*cos(phi_rod) = 0" in fb.equations(s, form="recursive").text()


def test_with_gears_and_conditions():
    s = fb.System("geared")
    m, r, g = s.parameters(m=1, r=1, g=9.81)
    s.gravity = (0, -g, 0)
    discs = [s.body(f"d{i}", fb.disk(m, r)) for i in range(3)]
    pins = [
        s.hinge(f"p{i}", parent, disc, at=(r, 0, 0), to=(0, r / 2, 0), coordinate=f"a{i}")
        for i, (parent, disc) in enumerate(zip([s.ground, *discs], discs, strict=False))
    ]
    s.gear(pins[0], pins[1], 2, name="gear")
    s.constrain("a2 - a0**2")
    agree(s)


@pytest.mark.parametrize("axes", [("z",), ("x", "y", "z")])
def test_in_numbers(axes):
    """A chain that is too long to be written out, against the compiled machine."""
    s = random_chain(3, 14, axes)
    e = fb.equations(s)
    assert e.form == "recursive"
    rng = np.random.default_rng(1)
    n = e.model.n_u
    state, rates, seconds = rng.normal(size=(3, n))
    numbers = dict(zip([c.symbol for c in e.model.coordinates], state.tolist(), strict=True))
    for speed, u, a in zip(e.model.speeds, rates.tolist(), seconds.tolist(), strict=True):
        numbers |= {speed.symbol: u, speed.acceleration: a}
    from freebody.scalar.algebra import floats

    for definition in e.recursive.definitions:
        numbers[definition.symbol] = Substitution(e.recursive.ring, floats, numbers)(definition.value)
    found = [Substitution(e.recursive.ring, floats, numbers)(x) for x in e.recursive.balances]
    expected = fb.compile(s).inverse_dynamics(state, rates, seconds)
    size = np.abs(expected).max()
    assert np.abs(np.array(found) - expected).max() <= 1e4 * np.finfo(float).eps * size


@pytest.mark.parametrize("seed", range(4))
def test_every_definition_is_short_and_used(seed):
    e = fb.equations(random_chain(seed, 8), form="recursive")
    lengths = [len(d.value) for d in e.recursive.definitions if type(d.value) is Polynomial]
    assert max(lengths) <= 60
    used = sympy.Matrix([*e.definitions.values(), *(x.lhs for x in e.motion)]).atoms(
        sympy.Symbol, sympy.Function
    )
    used |= {x.args[0] for x in sympy.Matrix([*e.definitions.values()]).atoms(sympy.Derivative)}
    assert set(e.definitions) <= used


@pytest.mark.parametrize("seed", range(6))
def test_bound_on_the_terms(seed):
    e = fb.equations(random_system(seed, 3, ("hinge", "slider", "ball"), small=True, loads=False))
    terms = sum(len(x) for pair in e.balances for x in pair if type(x) is Polynomial)
    assert terms <= most_terms(e.model)
