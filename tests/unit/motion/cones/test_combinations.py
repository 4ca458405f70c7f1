"""Contact problems of few contacts: none, one or several motions, as enumeration has them; impacts lose energy."""

import numpy as np
import pytest

from cone_problems import ConeProblem, Touching, contacts_of
from enumeration import distinct, solutions
from freebody.motion.cones.collision import compiled_code
from freebody.motion.cones.contacts import AWAY, EXACT, FORWARDS, PRESSED
from freebody.motion.events.code import code
from impacts import impact

ROUND = 1e-9


def problem(rng, count, tangents, dofs=6):
    """Random A = W M⁻¹ Wᵀ of full rank, responses and contacts."""
    m = count * (1 + tangents)
    W = rng.normal(size=(m, max(dofs, m)))
    L = rng.normal(size=(W.shape[1], W.shape[1]))
    M = L @ L.T + W.shape[1] * np.eye(W.shape[1])
    X = np.linalg.solve(M, W.T)
    return W @ X, X.T


def holds(contact, forces, rates, scale_f, scale_r):
    at, n = contact.row, contact.tangents
    N, T = forces[at], forces[at + 1 : at + 1 + n]
    rn, rt = rates[at], rates[at + 1 : at + 1 + n]
    assert -ROUND * scale_f <= N
    assert rn >= -ROUND * scale_r
    assert abs(N * rn) <= ROUND * scale_f * scale_r
    assert np.linalg.norm(T) <= contact.friction * N + ROUND * scale_f
    if np.linalg.norm(rt) > ROUND * scale_r:
        # friction against the slip that begins, at its limit
        assert T @ rt <= -contact.friction * N * np.linalg.norm(rt) * (1 - 1e-7) + ROUND * scale_f * scale_r


def motions(A, c, contacts):
    """Number of motions, rates of the first one, and its modes."""
    it, k, m = contacts_of(A, c, contacts), len(contacts), len(c)
    count = code("motions")(it)
    if count == 1:
        code("take_first")(it)
    return count, it.after[:m].copy(), it.tried[k : 2 * k].tolist(), it.tried[:k].tolist()


def random_contacts(rng, count, tangents):
    """Contacts with much and little friction, at rest or sliding; in space all with friction slide."""
    result = []
    for k in range(count):
        friction = float(rng.choice([0.0, rng.uniform(0, 0.5), rng.uniform(0, 3)]))
        static = friction * float(rng.choice([1.0, 1.3]))
        d = rng.normal(size=tangents)
        slides = friction > 0 and (tangents == 2 or rng.random() < 0.5)
        way = d / np.linalg.norm(d) if slides else None
        result.append(Touching(f"c{k}", k * (1 + tangents), tangents, friction, static, way))
    return result


def kept(found, contacts):
    """Without slips that begin although static friction, greater than kinetic, could hold, the others unchanged."""

    def begun(one):
        return [
            i
            for i, (mode, _) in enumerate(one.modes)
            if mode == "slip" and contacts[i].sliding is None and contacts[i].static > contacts[i].friction
        ]

    return [
        one
        for one in found
        if not begun(one)
        or not any(
            all((b[0] == "stick") if i in begun(one) else (a[0] == b[0]) for i, (a, b) in enumerate(pair))
            for pair in ([*zip(one.modes, other.modes, strict=True)] for other in found)
        )
    ]


@pytest.mark.parametrize("tangents", [1, 2])
@pytest.mark.parametrize("dofs", [2, 3, 6])
def test_thousands_of_problems_have_the_motions_of_enumeration(tangents, dofs):
    rng = np.random.default_rng(10 * tangents + dofs)
    counts = [0, 0, 0]
    for _ in range(600):
        count = int(rng.integers(1, 4))
        m = count * (1 + tangents)
        W = rng.normal(size=(m, dofs))
        A, c, contacts = W @ W.T, W @ rng.normal(size=dofs), random_contacts(rng, count, tangents)
        found = distinct(kept(solutions(A, c, contacts), contacts), W)
        number, rates, _, _ = motions(A, c, contacts)
        assert number == min(len(found), 2)
        counts[number] += 1
        if number == 1:
            size = np.abs(c).max() + np.abs(rates).max()
            np.testing.assert_allclose(rates, found[0][0].rates, atol=1e-7 * size)
    assert counts[1] > 300 and min(counts) > 0  # Painlevé's paradoxes of both kinds are among them


@pytest.mark.parametrize("dofs", [3, 6])
def test_wheels_that_resist_rolling_have_the_motions_of_enumeration(dofs):
    """Contacts in a plane, each followed by its resistance, whose own normal row is zero."""
    rng = np.random.default_rng(dofs)
    counts, solved = [0, 0, 0], 0
    for _ in range(100):
        W, contacts = [], []
        for k in range(int(rng.integers(1, 3))):
            way = [np.array([rng.choice([-1.0, 1.0])]) if rng.random() < 0.3 else None for _ in range(2)]
            mu = rng.uniform(0, 1, size=2).tolist()
            contacts.append(Touching(f"c{k}", 4 * k, 1, mu[0], mu[0], way[0]))
            contacts.append(Touching(f"r{k}", 4 * k + 2, 1, mu[1], mu[1], way[1], presser=2 * k))
            W += [*rng.normal(size=(2, dofs)), np.zeros(dofs), rng.normal(size=dofs)]
        W = np.array(W)
        A, c = W @ W.T, W @ rng.normal(size=dofs)
        found = distinct(solutions(A, c, contacts), W)
        number, rates, _, _ = motions(A, c, contacts)
        assert number == min(len(found), 2)
        counts[number] += 1
        it = contacts_of(A, c, contacts)
        compiled_code()["find"](it)
        if number == 1:
            size = np.abs(c).max() + np.abs(rates).max()
            np.testing.assert_allclose(rates, found[0][0].rates, atol=1e-7 * size)
            if it.residual <= EXACT:
                solved += 1
                np.testing.assert_allclose(it.after[: len(c)], rates, atol=1e-7 * size)
        if code("unique")(it, it.directions):
            assert number == 1 and it.residual <= EXACT
    assert counts[1] > 60 and solved > 0.95 * counts[1]


@pytest.mark.parametrize("tangents", [0, 1, 2])
def test_laws_hold_in_the_solution(tangents):
    rng = np.random.default_rng(tangents)
    for _ in range(200):
        count = int(rng.integers(1, 3))
        A, _ = problem(rng, count, tangents)
        c, mu = rng.normal(size=len(A)), 0.3 if tangents else 0.0
        contacts = [Touching(f"c{k}", k * (1 + tangents), tangents, mu, mu) for k in range(count)]
        found = ConeProblem(A, c, contacts).solve()
        assert found.residual <= EXACT
        np.testing.assert_allclose(A @ found.forces + c, found.rates, atol=1e-12 * np.abs(c).max())
        for contact in contacts:
            holds(contact, found.forces, found.rates, np.abs(found.forces).max() + 1, np.abs(c).max())


def rod(theta, mu, w=0.0, v=1.0):
    """Uniform rod of mass 1 and length 1 sliding on its lower end, leaning by theta from the vertical; g = 9.81.

    A = 1/m + (l/2)²/I (…) in closed form; c_N = (l/2) w² cos - g.
    """
    s, k = np.sin(theta), np.cos(theta)
    a = 3.0  # (l/2)² / I for l = 1
    A = np.array([[1 + a * s * s, a * s * k], [a * s * k, 1 + a * k * k]])
    c = np.array([0.5 * w * w * k - 9.81, 0.5 * w * w * s])
    return A, c, Touching("tip", 0, 1, mu, mu, np.array([v]))


def test_painleve_rod_has_no_or_two_motions():
    theta = np.radians(35)
    criterion = 1 + 3 * np.sin(theta) ** 2 - 2.0 * 3 * np.sin(theta) * np.cos(theta)
    assert criterion < 0
    A, c, tip = rod(theta, 2.0)
    assert motions(A, c, [tip])[0] == 0
    A, c, tip = rod(theta, 2.0, w=6.0)  # the free end would lift: both open and slip are consistent
    count, _, first, second = motions(A, c, [tip])
    assert count == 2 and {*first, *second} == {AWAY, PRESSED}
    A, c, tip = rod(theta, 0.5)
    assert motions(A, c, [tip])[0] == 1


def test_stick_and_the_cone_at_rest():
    # a block of mass 2 on a floor, pulled with F: c = (-g, F/m)
    A, floor = np.eye(2) / 2, [Touching("floor", 0, 1, 0.3, 0.3)]
    for pull, mode in ((5.0, PRESSED), (6.0, FORWARDS)):
        count, rates, modes, _ = motions(A, np.array([-9.81, pull / 2]), floor)
        assert (count, modes) == (1, [mode])
    assert rates[1] == pytest.approx((6.0 - 0.3 * 2 * 9.81) / 2)


def test_static_friction_holds_what_kinetic_friction_would_let_slip():
    A = np.eye(2) / 2
    for static, mode in ((0.3, FORWARDS), (0.4, PRESSED)):
        count, _, modes, _ = motions(A, np.array([-9.81, 3.5]), [Touching("floor", 0, 1, 0.3, static)])
        assert (count, modes) == (1, [mode])


def test_four_legs_share_their_load():
    # four normal forces on a plate: three independent rows
    points = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) / 2
    W = np.column_stack([np.ones(4), points])
    A = W @ np.diag([1, 3, 3]) @ W.T
    found = ConeProblem(
        A, -9.81 * np.ones(4), [Touching(f"leg{k}", k, 0, 0.0, 0.0) for k in range(4)]
    ).solve()
    np.testing.assert_allclose(found.forces, 9.81 / 4, rtol=1e-12)


def test_more_contacts_than_combinations_can_be_tried_are_solved_at_once():
    contacts = [Touching(f"c{k}", 2 * k, 1, 0.5, 0.5) for k in range(8)]
    assert motions(np.eye(16), -np.ones(16), contacts)[0] == 0
    found = ConeProblem(np.eye(16), -np.ones(16), contacts).solve()
    np.testing.assert_allclose(found.forces, np.tile([1, 0.5], 8), rtol=1e-12)


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("tangents", [1, 2])
def test_impacts_never_make_energy_and_keep_their_law(law, tangents):
    rng = np.random.default_rng(5)
    reduced = 0
    for _ in range(40 if tangents == 1 else 8):
        count = int(rng.integers(1, 3))
        A, responses = problem(rng, count, tangents)
        mu, e = rng.uniform(0, 1), rng.uniform(0, 1)
        before = rng.normal(size=len(A))
        contacts = [Touching(f"c{k}", k * (1 + tangents), tangents, mu, mu) for k in range(count)]
        before[0] = -abs(before[0])
        hit = impact(A, before, contacts, e, law)
        reduced += hit.part < 1
        assert hit.energy <= 1e-12
        np.testing.assert_allclose(hit.after, A @ hit.impulses + before, atol=1e-12)
        for one in contacts:
            at = one.row
            N, T = hit.impulses[at], hit.impulses[at + 1 : at + 1 + tangents]
            assert N >= -1e-12
            assert np.linalg.norm(T) <= mu * N + 1e-9
            if law == "newton" and before[at] < 0 and N > 1e-9:
                assert hit.after[at] == pytest.approx(-hit.part * e * before[at], abs=1e-10)
            assert hit.after[at] >= -1e-10
    assert reduced < 20


def test_newtons_cradle_at_once():
    # three equal balls: rates v2 - v1, v3 - v2; the first comes with speed 1
    W = np.array([[-1.0, 1, 0], [0, -1, 1]])
    A, contacts = W @ W.T, [Touching("a", 0, 0, 0, 0), Touching("b", 1, 0, 0, 0)]
    before = W @ [1, 0, 0]
    both = impact(A, before, contacts, 1, "newton")
    np.testing.assert_allclose([1, 0, 0] + both.impulses @ W, [-1 / 3, 2 / 3, 2 / 3], atol=1e-13)
    assert abs(both.energy) < 1e-13
