"""Formulas of a model: free-body equations, reactions, equations of motion, energy, momentum."""
