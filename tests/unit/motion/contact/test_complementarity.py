"""Contact problems of numbers: every law holds in every solution; Painlevé; impacts lose energy."""

import numpy as np
import pytest

from freebody.motion.contact.complementarity import OPEN, SLIP, STICK, Touching, distinct, painleve, solutions
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


def holds(contact, mode, forces, rates, scale_f, scale_r):
    at, n = contact.row, contact.tangents
    N, T = forces[at], forces[at + 1 : at + 1 + n]
    rn, rt = rates[at], rates[at + 1 : at + 1 + n]
    name, _ = mode
    assert -ROUND * scale_f <= N
    assert rn >= -ROUND * scale_r
    assert abs(N * rn) <= ROUND * scale_f * scale_r
    assert np.linalg.norm(T) <= contact.friction * N + ROUND * scale_f
    if name == SLIP and contact.sliding is None and np.linalg.norm(rt) > 0:
        # friction against the slip that begins, at its limit
        assert T @ rt <= -contact.friction * N * np.linalg.norm(rt) * (1 - 1e-7) + ROUND * scale_f * scale_r


@pytest.mark.parametrize("tangents", [0, 1, 2])
def test_laws_hold_in_every_solution_and_one_exists(tangents):
    rng = np.random.default_rng(tangents)
    for _ in range(25 if tangents < 2 else 10):
        count = int(rng.integers(1, 3))
        A, responses = problem(rng, count, tangents)
        c = rng.normal(size=len(A))
        contacts = [
            Touching(
                f"c{k}", k * (1 + tangents), tangents, 0.3 if tangents else 0.0, 0.3 if tangents else 0.0
            )
            for k in range(count)
        ]
        found = solutions(A, c, contacts)
        assert len(distinct(found, responses)) == 1
        for one in found:
            assert one.residual <= 1e-10
            np.testing.assert_allclose(A @ one.forces + c, one.rates, atol=1e-12 * np.abs(c).max())
            for contact, mode in zip(contacts, one.modes, strict=True):
                holds(contact, mode, one.forces, one.rates, np.abs(one.forces).max() + 1, np.abs(c).max())


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
    A, c, tip = rod(theta, 2.0)
    criterion = 1 + 3 * np.sin(theta) ** 2 - 2.0 * 3 * np.sin(theta) * np.cos(theta)
    assert painleve(A, tip) == pytest.approx(criterion, rel=1e-14)
    assert criterion < 0
    assert solutions(A, c, [tip]) == []
    A, c, tip = rod(theta, 2.0, w=6.0)  # the free end would lift: both open and slip are consistent
    found = solutions(A, c, [tip])
    assert {one.modes[0][0] for one in found} == {OPEN, SLIP}
    assert len(distinct(found, np.linalg.cholesky(A))) == 2
    A, c, tip = rod(theta, 0.5)
    assert len(solutions(A, c, [tip])) == 1


def test_stick_and_the_cone_at_rest():
    # a block of mass 2 on a floor, pulled with F: c = (-g, F/m)
    A = np.eye(2) / 2
    for pull, mode in ((5.0, STICK), (6.0, SLIP)):
        one = solutions(A, np.array([-9.81, pull / 2]), [Touching("floor", 0, 1, 0.3, 0.3)])
        assert [s.modes[0][0] for s in one] == [mode]
    assert one[0].forces[1] == pytest.approx(-0.3 * 2 * 9.81)


def touching_zero(rng, mu, angle):
    """A contact in space of which det S (r_T × d) has a double root at an angle, and the normal force there.

    With r_N = 0, N = -c_N / D, D = A_NN - μ A_NT·d, and f = D (r_T × d) = -c_N (A_TN - μ A_TT d) × d + D (c_T × d):
    f = f' = 0 are two linear equations in c_T.
    """
    L = rng.normal(size=(3, 3))
    A = L @ L.T
    d = np.array([np.cos(angle), np.sin(angle)])
    e = np.array([-d[1], d[0]])  # d' = e, e' = -d; v × d = -v·e, v × e = v·d

    def push(v):
        return A[1:, 1:] @ v

    b = A[1:, 0]
    D, slope = A[0, 0] - mu * b @ d, -mu * b @ e
    f = -(b - mu * push(d)) @ e
    f_slope = (b - mu * push(d)) @ d + mu * push(e) @ e
    # f - D (c_T·e) = 0 and f' + D (c_T·d) - D' (c_T·e) = 0, with c_N = -1
    across = f / D
    along = (slope * across - f_slope) / D
    return A, np.array([-1.0, *(along * d + across * e)]), d, 1 / D


@pytest.mark.parametrize("beside", [False, True])
def test_a_slip_whose_direction_is_a_double_root_is_found(beside):
    rng = np.random.default_rng(3)
    found = 0
    while found < 20:
        mu = rng.uniform(0.2, 2)
        A, c, d, N = touching_zero(rng, mu, rng.uniform(0, 2 * np.pi))
        rates = A @ (N * np.array([1, *(-mu * d)])) + c
        if N < 0 or N > 50 or rates[1:] @ d < 0:
            continue
        assert abs(rates[1] * d[1] - rates[2] * d[0]) < 1e-13 * (1 + np.abs(rates).max())
        contacts = [Touching("a", 0, 2, mu, mu)]
        if beside:  # another one, on its own body, that is pulled beyond what friction holds
            A = np.block([[A, np.zeros((3, 3))], [np.zeros((3, 3)), np.eye(3)]])
            c = np.array([*c, -1.0, *rng.uniform(1, 2, size=2)])
            contacts.append(Touching("b", 3, 2, 0.3, 0.3))
        every = solutions(A, c, contacts)
        assert any(
            mode == SLIP and way @ d > 1 - 1e-12 and all(other[0] == SLIP for other in one.modes[1:])
            for one in every
            for mode, way in one.modes[:1]
            if way is not None
        )
        found += 1


def test_four_legs_are_least_in_norm():
    # four normal forces on a plate: three independent rows
    points = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) / 2
    W = np.column_stack([np.ones(4), points])
    A = W @ np.diag([1, 3, 3]) @ W.T
    (one,) = solutions(A, -9.81 * np.ones(4), [Touching(f"leg{k}", k, 0, 0.0, 0.0) for k in range(4)])[:1]
    best = [
        s
        for s in solutions(A, -9.81 * np.ones(4), [Touching(f"leg{k}", k, 0, 0.0, 0.0) for k in range(4)])
        if s.rank_lack
    ]
    assert best[0].rank_lack == 1
    np.testing.assert_allclose(best[0].forces, 9.81 / 4, rtol=1e-12)
    assert one.residual <= 1e-10


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


def test_more_contacts_than_combinations_can_be_tried_are_solved_at_once():
    contacts = [Touching(f"c{k}", 2 * k, 1, 0.5, 0.5) for k in range(8)]
    (one,) = solutions(np.eye(16), -np.ones(16), contacts)
    assert {mode for mode, _ in one.modes} == {SLIP}
    np.testing.assert_allclose(one.forces, np.tile([1, 0.5], 8), rtol=1e-12)
