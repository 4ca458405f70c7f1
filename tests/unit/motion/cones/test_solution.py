"""The contact problem: its laws hold to round-off, whatever the contacts, and its motion is that of enumeration."""

from dataclasses import replace

import numpy as np
import pytest

from cone_problems import ConeProblem, Touching, contacts_of
from enumeration import distinct, solutions
from freebody.motion.cones.collision import compiled_code
from freebody.motion.cones.contacts import EXACT
from freebody.motion.events.code import code
from impacts import impact


def rows_at(points, tangents=2):
    """Rows of velocities (normal z, tangents x, y) of points of a body with the speeds (v, w)."""
    rows = []
    for x, y, z in points:
        J = np.hstack([np.eye(3), [[0, z, -y], [-z, 0, x], [y, -x, 0]]])
        rows += [J[2], *J[:tangents]]
    return np.array(rows)


def face(rng, count):
    turns = 2 * np.pi * np.arange(count) / count
    return rows_at(np.column_stack([np.cos(turns), np.sin(turns), np.full(count, -rng.uniform(0.2, 1))]))


def edge(rng, count):
    return rows_at(np.column_stack([np.linspace(-1, 1, count), np.zeros(count), -np.ones(count)]))


def wedge(rng, count):
    """A body between planes of different normals."""
    rows = rows_at(rng.normal(size=(count, 3)))
    for k in range(count):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        rows[3 * k : 3 * k + 3] = turn @ rows[3 * k : 3 * k + 3]
    return rows


def bodies(rng, count):
    """A chain of bodies: each contact between two of three, or between one and the ground."""
    rows = np.zeros((3 * count, 18))
    for k in range(count):
        first, second = rng.permutation(4)[:2]
        for body, sign in ((first, 1), (second, -1)):
            if body < 3:
                rows[3 * k : 3 * k + 3, 6 * body : 6 * body + 6] = sign * rows_at(rng.normal(size=(1, 3)))
    return rows


def tree(rng, count):
    """Contacts of a machine with fewer speeds than rows."""
    return rng.normal(size=(3 * count, 4))


SORTS = [face, edge, wedge, bodies, tree]


def random_problem(rng, sort, count):
    """A random impact: speeds before it, responses, and the restitution of the approaching contacts."""
    W = sort(rng, count)
    L = rng.normal(size=(W.shape[1], W.shape[1])) / np.sqrt(W.shape[1]) + np.eye(W.shape[1])
    responses = np.linalg.solve(L @ L.T + 0.1 * np.eye(len(L)), W.T).T
    before = W @ rng.normal(size=W.shape[1])
    mu = rng.uniform(0.05, 1)
    contacts = [Touching(f"c{k}", 3 * k, 2, mu, mu) for k in range(count)]
    return W @ responses.T, before, contacts, responses


def check_problems(seed, number):
    rng = np.random.default_rng(seed)
    for k in range(number):
        sort = SORTS[k % len(SORTS)]
        A, before, contacts, _ = random_problem(rng, sort, int(rng.integers(1, 9)))
        problem = ConeProblem(A, before, contacts)
        found = problem.solve()
        assert found.residual <= EXACT, (seed, k, sort.__name__, found.residual)
        assert found.residual == pytest.approx(problem.residual(found.forces), abs=1e-12)
        # compression never makes energy, and neither does Poisson's expansion of a single contact
        assert found.forces @ (before + found.rates) <= 1e-9 * np.abs(found.forces) @ np.abs(before)


def test_every_problem_is_solved():
    check_problems(1, 600)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 7))
def test_ten_thousand_problems_are_solved(seed):
    check_problems(seed, 2000)


def test_the_motion_is_that_of_enumeration():
    rng = np.random.default_rng(3)
    compared = 0
    for k in range(60):
        sort = SORTS[k % len(SORTS)]
        A, before, contacts, responses = random_problem(rng, sort, int(rng.integers(1, 3)))
        every = solutions(A, before, contacts)
        groups = distinct(every, responses)
        motion = ConeProblem(A, before, contacts).solve().forces @ responses
        size = max(np.abs(before).max(), np.abs(motion).max())
        assert groups and min(np.abs(motion - g[0].forces @ responses).max() for g in groups) < 1e-8 * size, k
        compared += len(groups) == 1
    assert compared > 40


def test_the_order_of_the_contacts_does_not_matter():
    rng = np.random.default_rng(4)
    for k in range(100):
        A, before, contacts, responses = random_problem(rng, SORTS[k % 2], 4 + k % 3)
        motion = ConeProblem(A, before, contacts).solve().forces @ responses
        order = rng.permutation(len(contacts))
        rows = np.concatenate([[3 * i, 3 * i + 1, 3 * i + 2] for i in order])
        turned = [replace(contacts[i], row=3 * place) for place, i in enumerate(order)]
        other = ConeProblem(A[np.ix_(rows, rows)], before[rows], turned).solve().forces @ responses[rows]
        np.testing.assert_allclose(other, motion, atol=1e-7 * np.abs(motion).max(initial=1e-9))


def test_four_equal_corners_share_evenly():
    A_rows = rows_at([(1, 1, -1), (-1, 1, -1), (-1, -1, -1), (1, -1, -1)])
    A = A_rows @ A_rows.T
    c = A_rows @ [0, 0, -9.81, 0, 0, 0]
    found = ConeProblem(A, c, [Touching(f"c{k}", 3 * k, 2, 0.5, 0.5) for k in range(4)]).solve()
    np.testing.assert_allclose(found.forces.reshape(4, 3), [[9.81 / 4, 0, 0]] * 4, atol=1e-11)


def test_a_loop_is_an_equality_or_eliminated():
    """Multipliers as equality rows give the contact forces of the problem without them."""
    rng = np.random.default_rng(5)
    for _ in range(50):
        W, G = rng.normal(size=(6, 5)), rng.normal(size=(2, 5))
        whole = np.vstack([W, G])
        u = rng.normal(size=5)
        u -= np.linalg.pinv(G) @ (G @ u)
        contacts = [Touching("a", 0, 2, 0.4, 0.4), Touching("b", 3, 2, 0.4, 0.4)]
        full = ConeProblem(whole @ whole.T, whole @ u, contacts, equalities=(6, 7)).solve()
        P = np.eye(5) - np.linalg.pinv(G) @ G
        part = ConeProblem(W @ P @ W.T, W @ u, contacts).solve()
        assert max(full.residual, part.residual) <= EXACT
        np.testing.assert_allclose(full.forces @ whole, part.forces @ W @ P, atol=1e-9 * np.abs(u).max())


def test_a_contact_that_slides_has_its_ray():
    A, c = np.diag([1.0, 1, 1]), np.array([-2.0, 0, 0])
    found = ConeProblem(A, c, [Touching("a", 0, 2, 0.5, 0.5, np.array([0.6, 0.8]))]).solve()
    np.testing.assert_allclose(found.forces, [2, -0.6, -0.8], rtol=1e-12)


def test_friction_off_its_ray_is_a_violation():
    A, c = np.diag([1.0, 1, 1]), np.array([-2.0, 0, 0])
    problem = ConeProblem(A, c, [Touching("a", 0, 2, 0.5, 0.5, np.array([0.6, 0.8]))])
    assert problem.residual(np.array([2, -0.6, -0.8])) < 1e-15
    assert problem.residual(np.array([2, -0.6, 0.8])) == pytest.approx(1.6 / 2)
    smooth = ConeProblem(A, c, [Touching("a", 0, 2, 0.0, 0.0)])
    assert smooth.residual(np.array([2.0, 0.3, 0])) == pytest.approx(0.3 / 2)


def test_a_large_pile_is_swept_first():
    """More directions than `newton.DENSE`: a row of blocks, each on the ground and beside the next."""
    n = 20
    W, M = [], np.eye(2 * n)
    for i in range(n):
        W += [M[2 * i + 1], M[2 * i]]
        if i + 1 < n:
            W += [M[2 * i + 2] - M[2 * i], M[2 * i + 3] - M[2 * i + 1]]
    W = np.array(W)
    contacts = [Touching(f"c{k}", 2 * k, 1, 0.3, 0.3) for k in range(len(W) // 2)]
    found = ConeProblem(W @ W.T, W @ np.tile([1.0, -1], n) * np.linspace(1, 2, len(W)), contacts).solve()
    assert found.residual <= EXACT


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_no_impact_makes_energy(law):
    rng = np.random.default_rng(6)
    reduced = 0
    for k in range(400):
        A, before, contacts, _ = random_problem(rng, SORTS[k % len(SORTS)], int(rng.integers(1, 6)))
        e = rng.uniform(0.3, 1)
        hit = impact(A, before, contacts, e, law)
        assert hit.energy <= 1e-9 * np.abs(hit.impulses) @ (np.abs(before) + np.abs(hit.after))
        assert hit.after[::3].min() > -1e-8 * np.abs(before).max()
        assert hit.part in (1, 1 / 2, 1 / 4, 1 / 8, 1 / 16, 0)
        reduced += hit.part < 1
    assert reduced < (2 if law == "poisson" else 60)


def test_impulses_solve_the_contact_problem():
    """The compiled impact beside the contact problem with c = v⁻ + e v_N⁻ of the contacts that approach."""
    rng = np.random.default_rng(11)
    for k in range(60):
        A, before, contacts, _ = random_problem(rng, SORTS[k % len(SORTS)], int(rng.integers(1, 6)))
        contacts = [replace(one, sliding=None, static=one.friction) for one in contacts]
        hit = impact(A, before, contacts, 0.3, "newton")
        c = before.copy()
        for one in contacts:
            c[one.row] += hit.part * 0.3 * min(before[one.row], 0)
        problem = ConeProblem(A, c, contacts)
        assert problem.residual(hit.impulses) <= EXACT
        assert hit.residual <= EXACT
        other = problem.solve()
        moved = np.abs(A @ (hit.impulses - other.forces)).max()
        assert moved <= 1e-8 * np.abs(before).max()


@pytest.mark.parametrize("sort", SORTS)
def test_where_the_motion_is_unique_enumeration_finds_one(sort):
    rng = np.random.default_rng(12)
    proven = 0
    for _ in range(40):
        A, c, contacts, responses = random_problem(rng, sort, int(rng.integers(1, 3)))
        contacts = [replace(one, static=one.friction) for one in contacts]
        it = contacts_of(A, c, contacts)
        compiled_code()["find"](it)
        if not code("unique")(it, it.directions):
            continue
        proven += 1
        every = solutions(A, c, contacts)
        assert len(distinct(every, responses)) == 1
        motion = ConeProblem(A, c, contacts).solve().forces @ responses
        assert np.abs(every[0].forces @ responses - motion).max() <= 1e-7 * np.abs(motion).max()
    assert proven


def test_a_point_that_resists_rolling_and_spinning_has_one_solution_found_at_once():
    """The normal rows of its resistances move nothing and are no rows of the problem, which is regular."""
    rng = np.random.default_rng(3)
    rows = rows_at([(0.012, 0, -0.001)])
    turns = np.hstack([np.zeros((3, 3)), np.eye(3)])
    nothing = np.zeros((1, 6))
    W = np.vstack([rows, nothing, turns[:2], nothing, turns[2:]])
    inverse = np.diag([100.0] * 3 + [2.8e6, 2.8e6, 1.4e6])
    contacts = [
        Touching("edge", 0, 2, 0.4, 0.4),
        Touching("rolling", 3, 2, 2e-4, 2e-4, held=True, presser=0),
        Touching("spinning", 6, 1, 2e-4, 2e-4, held=True, presser=0),
    ]
    for _ in range(20):
        c = W @ (inverse @ (rng.normal(size=6) * [1, 1, 1, 1e-3, 1e-3, 1e-3])) - 10 * (np.arange(8) == 0)
        it = contacts_of(W @ inverse @ W.T, c, contacts)
        compiled_code()["find"](it)
        assert it.sole == 1 and it.newton.factored == 0
        assert it.residual <= 1e-13
