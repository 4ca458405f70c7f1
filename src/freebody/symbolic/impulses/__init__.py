"""Impulses on a machine: jumps of the speeds and impulsive reactions, as formulas."""
