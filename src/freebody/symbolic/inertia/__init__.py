"""Inertia that the forces of a machine can tell: base parameters."""
