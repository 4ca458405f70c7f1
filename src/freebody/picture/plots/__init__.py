"""Plots of motions and of linear models."""
