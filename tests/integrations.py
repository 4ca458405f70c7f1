"""Paths of the integrator in one call."""

from __future__ import annotations

from freebody.motion.ode.integration import Integration


def integrate(rates, state, start, until, *, absolute=1e-9, between=None, halt=None, **how):
    """The path from a state, integrated as ``how`` says."""
    return Integration(rates, **how).path(state, start, until, absolute, between, halt)
