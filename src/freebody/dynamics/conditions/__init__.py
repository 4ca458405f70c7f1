"""Conditions on a motion: constraints, closed loops and contacts, their rows, and the motion that keeps them."""
