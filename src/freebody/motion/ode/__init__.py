"""Integrators of ordinary differential equations with step-size control, events and dense output."""
