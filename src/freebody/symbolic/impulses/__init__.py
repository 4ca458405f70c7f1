"""Jumps of the speeds under impulses, as formulas."""
