"""Exact derivation of a model's equations, as canonical polynomials: the quantities that all products are made of."""
