"""Integrators of many motions at once, eight to a vector."""
