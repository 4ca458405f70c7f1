"""Steady motions: conditions, families of solutions, stability."""
