"""Derivatives of conditions against differences of their residuals along a motion."""

import numpy as np

from freebody.dynamics import float_state
from freebody.dynamics.conditions.constraints import residuals, rows
from freebody.dynamics.conditions.linearized import linearized
from freebody.model.assemble import assemble
from live_machines import four_bar


def test_rates_and_their_rates_are_those_of_the_residuals():
    """φ(q(t)) of q' = u, u' = 0 has the derivatives G u and γ; differences over 2h miss them by O(h²)."""
    model, random, h = assemble(four_bar()), np.random.default_rng(3), 1e-4
    q, u = random.uniform(0.1, 1, model.n_q), random.normal(size=model.n_u)
    assert not any(row.on_speeds for row in rows(model))

    def phi(t):
        return np.array(
            residuals(model, float_state(model, (q + t * u).tolist(), u.tolist(), t)), dtype=float
        )

    at = linearized(model, float_state(model, q.tolist(), u.tolist(), 0.0))
    np.testing.assert_allclose(at.residual, phi(0.0), rtol=0, atol=1e-15)
    np.testing.assert_allclose(at.rate, (phi(h) - phi(-h)) / (2 * h), rtol=0, atol=1e-6)
    np.testing.assert_allclose(np.array(at.matrix) @ u, at.rate, rtol=0, atol=1e-13)
    np.testing.assert_allclose(at.bias, (phi(h) - 2 * phi(0.0) + phi(-h)) / h**2, rtol=0, atol=1e-5)
    assert at.symmetric and at.acting == at.matrix
